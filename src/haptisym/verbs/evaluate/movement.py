r"""What a fit of stiffness, damping and mass to a movement reports, of the environment and of what
is felt.

A movement with the displacement spectrum S(omega), flat on a band or that of a recording, and the
force H(j omega) that goes with it: least squares of the force on position, velocity and
acceleration minimise::

    int S |H(j omega) - (k - m omega^2 + j b omega)|^2 d omega,

so that k and -m solve the normal equations of Re H on 1 and omega^2 with the weight S, and b = int
S omega Im H / int S omega^2.
It is what such a fit would report, not what a person was shown to perceive: inside a band on which
nothing is noticed, frequency by frequency, the fitted mass may be off by more than the JND.

Integrals over a flat band are enclosed in balls (Arb's), a recording's spectrum is SciPy's, within
the scene's band. Next to 0 rad/s, where a hold is 0/0 as a formula and a power of s has no
derivative, H is enclosed by its program. A narrow band costs the normal equations most of their
digits, so the precision is raised until each number has as many as a double. A number whose ball
still contains 0 is 0 where the form of H shows it for all frequencies, and undecided otherwise.
Across a pole of H the integral of |H|^2 is infinite: there is no fit. Derivation:
21_fitted_movement.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import flint
from flint import acb, arb
from sympy import Expr, Integer

from haptisym.kernel.budget import tick
from haptisym.kernel.dynamics import Ring, on_axis, squared_modulus
from haptisym.kernel.errors import SceneError, UndecidedError
from haptisym.kernel.objects import Shown
from haptisym.kernel.reals import expression_ball
from haptisym.kernel.rings import RationalFunction, omega, s
from haptisym.kernel.roots import chart, sign_of_number
from haptisym.model.quantities import Dimension, number
from haptisym.model.scene import Scene
from haptisym.programs.balls import FUNCTIONS, constant_ball
from haptisym.programs.program import Program

NAMES = ("k", "b", "m")
SYSTEMS = ("environment", "perceived")
_BITS = (160, 320, 640, 1280, 2560)
"""The precisions that are tried, in bits; integrals are computed to five eighths of them."""
_ENOUGH, _ULP = 60, 2.0**-52
"""Correct bits of a number that is given, a few more than a double has; the last digit of a
double."""
_FEWEST = 20  # bits of a number that was computed in doubles: six digits
_FIELDS = ("environment_real", "environment_imag", "real", "imag")
_KINDS = ("displacement", "velocity")
_SUFFIXES = (".csv", ".txt", ".tsv")


@dataclass(frozen=True, repr=False)
class Movement(Shown):
    """What a fit of k, b and m to a movement reports. ``environment``, ``perceived`` : of each, in
    SI; ``spectrum`` : the movement in words.

    ``change`` : relative, of what is felt to the environment's. A number is None where it is
    undecided, or where there is none:
    a change of what is 0, and a fit across a pole of H. ``poles`` : these, rad/s, of each H that
    has some on the band.
    ``band`` : from where to where its frequencies lie, rad/s. ``undecided`` : whether a number is.
    ``computed`` : whether they are in doubles, not enclosed.
    """

    spectrum: str
    band: tuple[float, float]
    environment: dict[str, float | None]
    perceived: dict[str, float | None]
    change: dict[str, float | None]
    poles: dict[str, tuple[float, ...]]
    undecided: bool
    computed: bool = False

    def _line(self) -> str:
        return f"{self.spectrum}: " + ", ".join(
            f"{x} = {_digits(self.perceived[x])}" for x in NAMES
        )

    def row(self) -> dict[str, Any]:
        """As a part of a document."""
        both = {"environment": self.environment, "perceived": self.perceived}
        poles = (
            {"poles": {name: [*found] for name, found in self.poles.items()}} if self.poles else {}
        )
        return {"spectrum": self.spectrum, **both, "change": self.change, **poles}


def _digits(x: float | None) -> str:
    return "undecided" if x is None else f"{x:.6g}"


def movement(scene: Scene, given: str | Path) -> Movement:
    """What a fit reports of a scene with numbers, for a movement.

    ``given`` : "0:15" or "displacement:0:15", a flat displacement spectrum from 0 to 15 rad/s ("0
    Hz:2 Hz" with units); "velocity:1:15", a flat velocity spectrum; or the name of a file with a
    recording, times and positions in columns.
    SceneError for what is none of these.

    >>> from haptisym.model.scenefile import load_scene
    >>> found = movement(load_scene("fu2019"), "0:15")
    >>> [round(found.perceived[x], 10) for x in NAMES]
    [99.8347809537, 16.8292036316, 1.6057031503]
    """
    text = str(given).strip()
    if Path(text).suffix.lower() in _SUFFIXES:
        return _recorded(scene, Path(text))
    kind, ends = _read(text)
    # velocity is omega times displacement: flat in velocity means omega^-2 in displacement
    weight = 0 if kind == "displacement" else -2
    low, high = map(float, ends)
    shown = next(
        x
        for n in (6, 12, 17)
        if (x := [f"{y:.{n}g}" for y in (low, high)]) and (x[0] != x[1] or n == 17)
    )
    return _told(
        scene,
        f"flat {kind} spectrum, {' to '.join(shown)} rad/s",
        (low, high),
        _flat(scene, ends, weight),
    )


Fits = dict[str, dict[str, Any]]
"""Balls around k, b and m, by the name of the H; nothing for one with poles."""
Poles = dict[str, tuple[float, ...] | None]
"""Where H has poles on the band, by its name; None where it is undecided whether it has some."""


def _flat(scene: Scene, ends: tuple[Expr, Expr], weight: int) -> Iterator[tuple[Fits, Poles]]:
    """Fits to a flat spectrum and the poles on its band, with more and more digits."""
    d = scene.closed
    program = scene.chain.at({p.symbol: p.value for p in scene.parameters}).program(_FIELDS)
    both = dict(zip(SYSTEMS, (d.env, d.perc), strict=True))
    poles = {name: found for name, f in both.items() if (found := _poles(f, ends)) != ()}
    for bits in _BITS:
        with flint.ctx.workprec(bits):
            fits = {
                name: _fit(
                    *_integrals(_response(f, program, changed=f is d.perc), ends, weight, bits)
                )
                for name, f in both.items()
                if name not in poles
            }
        yield fits, poles


def _poles(f: RationalFunction, ends: tuple[Expr, Expr]) -> tuple[float, ...] | None:
    """The frequencies on a band at which H is infinite; None where that is undecided."""
    lowest = f.reduced()
    below = f.ring.convert(Integer(1)) / f.ring.function(lowest.denominator)
    # 1/denominator first, which is simpler: where it has no pole, H has none
    for x in (below, lowest):
        if x.denominator.is_constant():
            return ()
        try:
            points = chart({"H": squared_modulus(x)}, *ends).points
        except UndecidedError:
            return None
        poles = tuple(float(p.omega) for p in points if p.orders.get("H", 0) < 0)
        if not poles and not any(p.undecided for p in points):
            return ()
    return None if any(p.undecided for p in points) else poles


def _told(
    scene: Scene,
    spectrum: str,
    band: tuple[float, float],
    tries: Iterable[tuple[Fits, Poles]],
    bits: int = _ENOUGH,
) -> Movement:
    """The answer from fits that get better with each try: numbers with so many correct ``bits``,
    None for one that has fewer in all of them."""
    d = scene.closed
    zeros = {
        name: _zeros(f)
        for name, f in zip((*SYSTEMS, "change"), (d.env, d.perc, d.difference), strict=True)
    }
    for fits, poles in tries:  # noqa: B007  the last ones are told
        tick()
        in_balls = {name: dict(row) for name, row in fits.items()}
        if len(in_balls) == len(SYSTEMS):
            env, perc = (in_balls[name] for name in SYSTEMS)
            # the quotient must not lose the digits of its parts, whatever precision is set here
            with flint.ctx.workprec(_BITS[-1]):
                in_balls["change"] = {
                    x: perc[x] / env[x] - 1 for x in NAMES if x not in zeros["environment"]
                }
        rows = {
            name: {x: _number(y, x in zeros[name], bits) for x, y in row.items()}
            for name, row in in_balls.items()
        }
        undecided = any(x is None for row in rows.values() for x in row.values())
        if not undecided:
            break
    environment, perceived, change = (
        {x: rows.get(name, {}).get(x) for x in NAMES} for name in (*SYSTEMS, "change")
    )
    # whether H has a pole may be undecided, and then whether there is a fit
    known = {name: places for name, places in poles.items() if places is not None}
    is_undecided = undecided or known != poles
    is_computed = bits < _ENOUGH
    return Movement(
        spectrum, band, environment, perceived, change, known, is_undecided, is_computed
    )


def _number(x: Any, is_zero: bool, bits: int) -> float | None:  # noqa: FBT001
    """The middle of a ball that has so many correct bits, else None; 0 where that is known."""
    if is_zero:
        return 0.0
    return float(x) if x.rel_accuracy_bits() >= bits else None


def _zeros(f: RationalFunction) -> set[str]:
    """Which of k, b and m are exactly 0 in every fit: Re H is all mass or all stiffness, Im H is
    none."""
    response = on_axis(f)
    real = response.real.expression()
    # Re H = -m omega^2 alone is fitted by no stiffness, Re H = k alone by no mass. In balls such a
    # number has no digit that is known, whatever the precision.
    zero = {"k"} if not (real / omega**2).has(omega) else set()
    zero |= {"m"} if not real.has(omega) else set()
    zero |= {"k", "m"} if real == 0 else set()
    return zero | ({"b"} if response.imag.is_zero else set())


def _read(text: str) -> tuple[str, tuple[Expr, Expr]]:
    """The kind of a flat spectrum and its band; SceneError for a text that gives none."""
    words = text.split(":")
    kind = words.pop(0).strip() if len(words) == 3 else "displacement"
    if kind not in _KINDS or len(words) != 2:
        raise SceneError(
            f'movement: "{text[:60]}" is no movement: give a band of frequencies, as 0:15, '
            f'"0 Hz:2 Hz" or velocity:1:15,'
            f" or a recording ({', '.join(_SUFFIXES)})"
        )
    low, high = (number(x.strip(), Dimension.FREQUENCY).value for x in words)
    if sign_of_number(low) < 0 or sign_of_number(high - low) <= 0:
        raise SceneError(f"movement: {text}: the band must go up from 0 rad/s or more")
    if kind == "velocity" and not sign_of_number(low):
        raise SceneError(
            f"movement: {text}: a flat velocity spectrum has no end at 0 rad/s: begin above, "
            f"as velocity:1:15"
        )
    return kind, (low, high)


Sums = tuple[tuple[Any, Any, Any], tuple[Any, Any], Any]
"""Moments of S: of 1, omega^2 and omega^4; of Re H with 1 and omega^2; of Im H with omega."""


def _integrals(
    of: Callable[[Any, bool], Any], ends: tuple[Expr, Expr], weight: int, bits: int
) -> Sums:
    """The sums of a flat spectrum, S = omega^weight between two frequencies; not finite where H has
    a pole there."""
    within = arb(2) ** (-bits * 5 // 8)
    a, b = (expression_ball(x) for x in ends)

    def integral(power: int) -> Any:
        # Arb's own absolute tolerance, 2^-bits, is not small against an integral over a narrow band
        # of a small H: this one is relative to the integrand's size.
        least = within * size * (b - a) * b ** (power + weight)
        return acb.integral(
            lambda z, analytic: of(z, analytic) * z ** (power + weight),
            a,
            b,
            rel_tol=within,
            abs_tol=least,
        )

    size = abs(of(acb(b), False))  # noqa: FBT003
    moments = [
        (b ** (n + weight + 1) - a ** (n + weight + 1)) / (n + weight + 1) for n in (0, 2, 4)
    ]
    return tuple(moments), (integral(0).real, integral(2).real), integral(1).imag


def _response(
    f: RationalFunction, program: Program, *, changed: bool
) -> Callable[[Any, bool], Any]:
    """H(j z) in balls, for frequencies z of the complex plane about the band; ``analytic`` as of
    ``acb.integral``.

    ``program`` : of H_env and dH, which holds next to 0 rad/s; ``changed`` : whether dH is part of
    H.
    """
    ring = f.ring
    assert isinstance(ring, Ring)
    is_rational = not any(x.has(s) for x in ring.meanings if x != s)
    constants = {
        i: constant_ball(x.value) for i, x in enumerate(program.operations) if x.name == "constant"
    }

    def next_to_rest(z: Any, analytic: bool) -> Any:  # noqa: FBT001
        # Arb asks whether the integrand is analytic on a ball before it uses Gauss' rule there; nan
        # says no, and it is then bounded on the ball, or the interval cut.
        if analytic:
            return acb("nan")
        found = program.run(FUNCTIONS, [z.real.nonnegative_part()], constants)
        re, im, d_re, d_im = (found[name] for name in _FIELDS)
        return acb(re + d_re, im + d_im) if changed else acb(re, im)

    def response(z: Any, analytic: bool) -> Any:  # noqa: FBT001  as Arb calls it
        if not is_rational and z.contains(0):
            return next_to_rest(z, analytic)
        at = {x: _generator(x, z, analytic) for x in ring.meanings}
        return ring.ball(f.numerator, at) / ring.ball(f.denominator, at)

    return response


def _generator(x: Expr, z: Any, analytic: bool) -> Any:  # noqa: FBT001
    """The value of a generator of the ring at s = j z: s, a power of it, an exponential, a
    number."""
    at = acb(0, 1) * z
    if x == s:
        return at
    if x.has(s) and x.is_Pow and x.base == s:
        # log(j z) = log z + j pi/2; the logarithm is that of z so that its cut is on the negative
        # real axis of frequencies, away from the band
        log = z.log(analytic=analytic) + acb(0, arb.pi() / 2)
        return (log * expression_ball(x.exp)).exp()
    if x.has(s):
        return (at * expression_ball((x.args[0] / s).cancel())).exp()
    return acb(*map(expression_ball, x.as_real_imag())) if x.is_number else acb(0)


def _fit(moments: tuple[Any, Any, Any], real: tuple[Any, Any], imag: Any) -> dict[str, Any]:
    """k, b and m by the normal equations, 2 x 2 for k and -m, one for b."""
    one, two, four = moments
    # the difference of nearly equal products on a narrow band: digits are lost here
    determinant = one * four - two * two
    k = (real[0] * four - two * real[1]) / determinant
    m = (two * real[0] - one * real[1]) / determinant
    return {"k": k, "b": imag / two, "m": m}


def _recorded(scene: Scene, path: Path) -> Movement:
    """What a fit to a recording reports: to those frequencies of its spectrum, by SciPy's
    periodogram, that lie within the scene's band."""
    import numpy as np
    from scipy.signal import periodogram

    from haptisym.model.motions import recording

    # at equal steps of time, which a periodogram needs; the window keeps what leaks from the ends
    # of a recording that is no period small, and a trend is no oscillation
    motion = recording(path)
    times = np.linspace(motion.times[0], motion.times[-1], len(motion.times))
    rate = (len(times) - 1) / float(times[-1] - times[0])
    frequency, power = periodogram(
        motion.derivatives(times, 0)[0], rate, window="hann", detrend="linear"
    )
    omega = 2 * np.pi * frequency
    low, high = map(float, scene.band)
    on_band = (omega > 0) & (omega >= low) & (omega <= high)
    if on_band.sum() < 2 or not power[on_band].any():
        raise SceneError(
            f"movement: {path}: fewer than two frequencies of the recording lie on the band "
            f"of the scene"
        )
    w, S = omega[on_band], power[on_band]
    f = scene.closed.compile(of=list(_FIELDS))(w)

    def sum_of(terms: Any) -> Any:
        """A sum of doubles, and what their roundings may change in it."""
        return arb(float(terms.sum()), len(w) * _ULP * float(np.abs(terms).sum()))

    moments = tuple(sum_of(S * w**n) for n in (0, 2, 4))
    real, imag = (
        (f.environment_real, f.environment_real + f.real),
        (f.environment_imag, f.environment_imag + f.imag),
    )
    fits = {
        name: _fit(moments, (sum_of(S * re), sum_of(S * w**2 * re)), sum_of(S * w * im))
        for name, re, im in zip(SYSTEMS, real, imag, strict=True)
    }
    said = (
        f"recorded movement {path.name}, {len(w)} frequencies from {w[0]:.3g} to {w[-1]:.4g} rad/s"
    )
    return _told(scene, said, (float(w[0]), float(w[-1])), [(fits, {})], _FEWEST)
