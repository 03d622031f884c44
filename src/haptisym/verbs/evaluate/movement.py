r"""What a fit of stiffness, damping and mass to a movement reports, of the environment and of what is felt.

A movement with the displacement spectrum S(omega), flat on a band or that of a recording, and the force H(j omega) that goes
with it: least squares of the force on position, velocity and acceleration minimise::

    int S |H(j omega) - (k - m omega^2 + j b omega)|^2 d omega,

so that k and -m solve the normal equations of Re H on 1 and omega^2 with the weight S, and b = int S omega Im H / int S omega^2.
It is what such a fit would report, not what a person was shown to perceive: inside a band on which nothing is noticed, frequency
by frequency, the fitted mass may be off by more than the JND.

Integrals over a flat band are enclosed in balls (Arb's), a recording's spectrum is SciPy's, within the scene's band. Next to
0 rad/s, where a hold is 0/0 as a formula and a power of s has no derivative, H is enclosed by its program.
Derivation: 21_fitted_movement.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import flint
from flint import acb, arb
from sympy import Expr

from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import SceneError, UndecidedError
from haptisym.kernel.objects import Shown
from haptisym.kernel.reals import expression_ball
from haptisym.kernel.rings import Polynomial, RationalFunction, monomials, s
from haptisym.kernel.roots import sign_of_number
from haptisym.model.quantities import Dimension, number
from haptisym.model.scene import Scene
from haptisym.programs.balls import FUNCTIONS, constant_ball
from haptisym.programs.program import Program

NAMES = ("k", "b", "m")
_BITS, _WITHIN, _ULP = 128, 2.0**-80, 2.0**-52
_FIELDS = ("environment_real", "environment_imag", "real", "imag")
_KINDS = ("displacement", "velocity")
_SUFFIXES = (".csv", ".txt", ".tsv")


@dataclass(frozen=True, repr=False)
class Movement(Shown):
    """``environment``, ``perceived`` : what a fit reports of each, k, b and m in SI; ``spectrum`` : the movement in words.

    ``band`` : from where to where its frequencies lie, rad/s.
    """

    spectrum: str
    band: tuple[float, float]
    environment: dict[str, float]
    perceived: dict[str, float]

    def _line(self) -> str:
        return f"{self.spectrum}: " + ", ".join(f"{x} = {self.perceived[x]:.6g}" for x in NAMES)

    @property
    def change(self) -> dict[str, float | None]:
        """Relative, of what is felt to the environment's; None where that is 0."""
        pairs = {x: (self.environment[x], self.perceived[x]) for x in NAMES}
        return {x: seen / own - 1 if own else None for x, (own, seen) in pairs.items()}

    def row(self) -> dict[str, Any]:
        """As a part of a document."""
        both = {"environment": self.environment, "perceived": self.perceived}
        return {"spectrum": self.spectrum, **both, "change": self.change}


def movement(scene: Scene, given: str | Path) -> Movement:
    """What a fit reports of a scene with numbers, for a movement.

    ``given`` : "0:15" or "displacement:0:15", a flat displacement spectrum from 0 to 15 rad/s ("0 Hz:2 Hz" with units);
    "velocity:1:15", a flat velocity spectrum; or the name of a file with a recording, times and positions in columns.
    SceneError for what is none of these; UndecidedError where an integral does not exist, as H has a pole on the band.

    >>> from haptisym.model.scenefile import load_scene
    >>> found = movement(load_scene("fu2019"), "0:15")
    >>> [round(found.perceived[x], 10) for x in NAMES]
    [99.8347809537, 16.8292036316, 1.6057031503]
    """
    text = str(given).strip()
    if Path(text).suffix.lower() in _SUFFIXES:
        return _recorded(scene, Path(text))
    kind, ends = _read(text)
    weight = 0 if kind == "displacement" else -2
    d, program = scene.closed, scene.chain.at({p.symbol: p.value for p in scene.parameters}).program(_FIELDS)
    with flint.ctx.workprec(_BITS):
        fits = [
            _fit(*_integrals(_response(f, program, changed=changed), ends, weight))
            for f, changed in ((d.env, False), (d.perc, True))
        ]
    shown = " to ".join(f"{float(x):g}" for x in ends)
    return Movement(f"flat {kind} spectrum, {shown} rad/s", (float(ends[0]), float(ends[1])), *fits)


def _read(text: str) -> tuple[str, tuple[Expr, Expr]]:
    words = text.split(":")
    kind = words.pop(0).strip() if len(words) == 3 else "displacement"
    if kind not in _KINDS or len(words) != 2:
        raise SceneError(
            f'movement: "{text[:60]}" is no movement: give a band of frequencies, as 0:15, "0 Hz:2 Hz" or velocity:1:15,'
            f" or a recording ({', '.join(_SUFFIXES)})"
        )
    low, high = (number(x.strip(), Dimension.FREQUENCY).value for x in words)
    if sign_of_number(low) < 0 or sign_of_number(high - low) <= 0:
        raise SceneError(f"movement: {text}: the band must go up from 0 rad/s or more")
    if kind == "velocity" and not sign_of_number(low):
        raise SceneError(
            f"movement: {text}: a flat velocity spectrum has no end at 0 rad/s: begin above, as velocity:1:15"
        )
    return kind, (low, high)


Sums = tuple[tuple[Any, Any, Any], tuple[Any, Any], Any]
"""Moments of S: of 1, omega^2 and omega^4; of Re H with 1 and omega^2; of Im H with omega."""


def _integrals(of: Callable[[Any, bool], Any], ends: tuple[Expr, Expr], weight: int) -> Sums:
    """The sums of a flat spectrum: S = omega^weight between two frequencies."""
    a, b = (expression_ball(x) for x in ends)

    def integral(power: int) -> Any:
        found = acb.integral(lambda z, analytic: of(z, analytic) * z ** (power + weight), a, b, rel_tol=_WITHIN)
        if not found.is_finite():
            raise UndecidedError("what a fit to this movement reports: H has a pole on its band")
        return found

    moments = [(b ** (n + weight + 1) - a ** (n + weight + 1)) / (n + weight + 1) for n in (0, 2, 4)]
    return tuple(moments), (integral(0).real, integral(2).real), integral(1).imag


def _response(f: RationalFunction, program: Program, *, changed: bool) -> Callable[[Any, bool], Any]:
    """H(j z) in balls, for frequencies z of the complex plane about the band; ``analytic`` as of ``acb.integral``.

    ``program`` : of H_env and dH, which holds next to 0 rad/s; ``changed`` : whether dH is part of H.
    """
    ring = f.ring
    assert isinstance(ring, Ring)
    is_rational = not any(x.has(s) for x in ring.meanings if x != s)
    constants = {i: constant_ball(x.value) for i, x in enumerate(program.operations) if x.name == "constant"}

    def next_to_rest(z: Any, analytic: bool) -> Any:  # noqa: FBT001
        if analytic:
            return acb("nan")
        found = program.run(FUNCTIONS, [z.real.nonnegative_part()], constants)
        re, im, d_re, d_im = (found[name] for name in _FIELDS)
        return acb(re + d_re, im + d_im) if changed else acb(re, im)

    def response(z: Any, analytic: bool) -> Any:  # noqa: FBT001  as Arb calls it
        if not is_rational and z.contains(0):
            return next_to_rest(z, analytic)
        at = [_generator(x, z, analytic) for x in ring.meanings]
        return _polynomial(f.numerator, at) / _polynomial(f.denominator, at)

    return response


def _generator(x: Expr, z: Any, analytic: bool) -> Any:  # noqa: FBT001
    """What a generator of the ring is at j z."""
    at = acb(0, 1) * z
    if x == s:
        return at
    if x.has(s) and x.is_Pow and x.base == s:
        log = z.log(analytic=analytic) + acb(0, arb.pi() / 2)
        return (log * expression_ball(x.exp)).exp()
    if x.has(s):
        return (at * expression_ball((x.args[0] / s).cancel())).exp()
    return acb(*map(expression_ball, x.as_real_imag())) if x.is_number else acb(0)


def _polynomial(p: Polynomial, at: list[Any]) -> Any:
    """Its value with these numbers for the generators of its ring."""
    total = acb(0)
    for exponents, c in monomials(p):
        term = acb(arb(c))
        for x, n in zip(at, exponents, strict=True):
            term *= x ** int(n) if n else 1
        total += term
    return total


def _fit(moments: tuple[Any, Any, Any], real: tuple[Any, Any], imag: Any, rounding: float = 0.0) -> dict[str, float]:
    """k, b and m by the normal equations; 0 where it is all ``rounding``, of sums relative to their terms."""
    one, two, four = moments
    below = one * four - two * two
    if not below > 0:
        raise SceneError("movement: a fit of k and m needs at least two frequencies")

    def difference(x: Any, y: Any) -> float:
        return float((x - y) / below) if abs(x - y) > rounding * (abs(x) + abs(y)) else 0.0

    k, m = difference(real[0] * four, two * real[1]), difference(two * real[0], one * real[1])
    return {"k": k, "b": float(imag / two) if abs(imag) > 0 else 0.0, "m": m}


def _recorded(scene: Scene, path: Path) -> Movement:
    """Of a recording: lines of its spectrum, SciPy's, those within the scene's band."""
    import numpy as np
    from scipy.signal import periodogram

    from haptisym.model.motions import recording

    motion = recording(path)
    times = np.linspace(motion.times[0], motion.times[-1], len(motion.times))
    rate = (len(times) - 1) / float(times[-1] - times[0])
    frequency, power = periodogram(motion.derivatives(times, 0)[0], rate, window="hann", detrend="linear")
    omega = 2 * np.pi * frequency
    low, high = map(float, scene.band)
    own = (omega > 0) & (omega >= low) & (omega <= high)
    if own.sum() < 2 or not power[own].any():
        raise SceneError(f"movement: {path}: fewer than two frequencies of the recording lie on the band of the scene")
    w, S = omega[own], power[own]
    f = scene.closed.compile(of=list(_FIELDS))(w)
    moments = tuple(float((S * w**n).sum()) for n in (0, 2, 4))
    fits = []
    for re, im in (
        (f.environment_real, f.environment_imag),
        (f.environment_real + f.real, f.environment_imag + f.imag),
    ):
        real = tuple(float((S * w**n * re).sum()) for n in (0, 2))
        fits.append(_fit(moments, real, float((S * w * im).sum()), len(w) * _ULP))  # type: ignore[arg-type]
    said = f"recorded movement {path.name}, {len(w)} frequencies from {w[0]:.3g} to {w[-1]:.4g} rad/s"
    return Movement(said, (float(w[0]), float(w[-1])), *fits)
