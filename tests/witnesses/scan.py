"""A second, independent algorithm for scenes with delays: look everywhere.

Nothing here comes from the package. A scene is a list of ``Element``s, each written a second time as the equations of motion
that it stands for, in complex arithmetic with ``exp(-j omega tau)`` and ``(j omega)^alpha``; the same equations run over

* ``FLOATS``: NumPy arrays, for grids of thousands of frequencies;
* ``DIGITS``: mpmath with 40 digits on a context of its own, for the last word.

A grid can miss what an exact method finds, never the other way round: ``disagreements`` looks for frequencies at which what
an evaluation says is not so.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from decimal import Decimal
from fractions import Fraction
from itertools import pairwise
from random import Random
from typing import Any

import mpmath
import numpy as np

MP = mpmath.mp.clone()
MP.dps = 40
PARTS = ("real", "imag")


@dataclass(frozen=True)
class Numbers:
    """A kind of numbers: how a decimal text becomes one, and the functions of the physics."""

    read: Callable[[str], Any]
    exp: Callable[[Any], Any]
    power: Callable[[Any, Any], Any]
    pi: Any


FLOATS = Numbers(float, np.exp, lambda z, a: z**a, np.pi)
DIGITS = Numbers(MP.mpf, MP.exp, MP.power, +MP.pi)


# --- physics ---------------------------------------------------------------------------------------------------------

Values = Mapping[str, Any]


def _mass_spring_damper(p: Values, s: Any, n: Numbers) -> Any:
    return p.get("m", 0) * s**2 + p.get("b", 0) * s + p.get("k", 0)


def _in_a_row(one: Any, other: Any) -> Any:
    """Two stiffnesses that carry the same force: the displacements add up."""
    return 1 / (1 / one + 1 / other)


FELT: dict[str, Callable[[Values, Any, Numbers], Any]] = {
    "mass-spring-damper": _mass_spring_damper,
    "kelvin-voigt": _mass_spring_damper,
    "maxwell": lambda p, s, n: _in_a_row(p["k"], p["b"] * s),
    "zener": lambda p, s, n: p["k0"] + _in_a_row(p["k1"], p["b1"] * s),
    "spring-pot": lambda p, s, n: p.get("k", 0) + p["k_alpha"] * n.power(s, p["alpha"]),
    "two-mass": lambda p, s, n: (
        p["m1"] * s**2 + p["b1"] * s + p["k1"] + _in_a_row(p["m2"] * s**2, p["k2"] + p["b2"] * s)
    ),
}
"""Force per displacement of each environment."""

Motion = tuple[Any, Any]


def _delay(p: Values, s: Any, F: Any, X: Any, n: Numbers) -> Motion:
    return F * n.exp(-s * p["tau"]), X


def _hold(p: Values, s: Any, F: Any, X: Any, n: Numbers) -> Motion:
    """The mean over the last period."""
    return F * (1 - n.exp(-s * p["T"])) / (s * p["T"]), X


def _waves(p: Values, s: Any, F: Any, X: Any, n: Numbers) -> Motion:
    """One wave arrives at the environment, one returns from it; the hand sent the first and gets the second, tau apart."""
    sent, returned = (F + p["b"] * s * X) / 2, (p["b"] * s * X - F) / 2
    sent, returned = sent * n.exp(s * p["tau"]), returned * n.exp(-s * p["tau"])
    return sent - returned, (sent + returned) / (p["b"] * s)


def _followed(p: Values, s: Any, F: Any, X: Any, n: Numbers) -> Any:
    """The master's position: the slave follows it, late, through its controller's spring and damper."""
    return (X + (p["Ms"] * s**2 * X + F) / (p["Bs"] * s + p["Ks"])) * n.exp(s * p["tau"])


def _position_force(p: Values, s: Any, F: Any, X: Any, n: Numbers) -> Motion:
    master = _followed(p, s, F, X, n)
    return p["Mm"] * s**2 * master + F * n.exp(-s * p["tau"]), master


def _position_position(p: Values, s: Any, F: Any, X: Any, n: Numbers) -> Motion:
    master = _followed(p, s, F, X, n)
    pulled = (p["Bm"] * s + p["Km"]) * (master - X * n.exp(-s * p["tau"]))
    return p["Mm"] * s**2 * master + pulled, master


def _four_channel(p: Values, s: Any, F: Any, X: Any, n: Numbers) -> Motion:
    """Each side is sent the other's force and the force that its own device and controller will need."""
    own, other = p["Mm"] * s**2 + p["Bm"] * s + p["Km"], p["Ms"] * s**2 + p["Bs"] * s + p["Ks"]
    late = n.exp(-s * p["tau"])
    from_slave = (F - own * X) * late  # what the master hears
    master = ((other * X + F) / late - from_slave) / (own + other)
    return own * master + from_slave, master


def _limited(p: Values, size: str) -> Any:
    """2/pi (asin u + u sqrt(1 - u^2)) of a limit, u = size/A; 1 beyond it."""
    u = min(p[size] / p["amplitude"], 1)
    return 2 / MP.pi * (MP.asin(u) + u * MP.sqrt(1 - u * u))


def _play(p: Values) -> Any:
    u = max(1 - p["gap"] / p["amplitude"], -1)
    real = (MP.asin(u) + u * MP.sqrt(1 - u * u)) / MP.pi + MP.mpf(1) / 2
    return MP.mpc(real, (u * u - 1) / MP.pi)


def _staircase(p: Values) -> Any:
    """4 q/(pi A) times the sum of cosines of the angles at which the steps are reached."""
    edges = [(i + MP.mpf(1) / 2) * p["q"] / p["amplitude"] for i in range(1000)]
    reached = [MP.sqrt(1 - x * x) for x in edges if x < 1]
    return 4 * p["q"] / (MP.pi * p["amplitude"]) * MP.fsum(reached)


def _harmonic(of: Callable[[Values], Any]) -> Callable[[Values, Any, Any, Any, Numbers], Motion]:
    """A force times the first harmonic of an element, in the arithmetic of the force."""

    def times(p: Values, s: Any, F: Any, X: Any, n: Numbers) -> Motion:
        N = of(p)
        return F * (N if n is DIGITS else complex(N)), X

    return times


BETWEEN: dict[str, Callable[[Values, Any, Any, Any, Numbers], Motion]] = {
    "delay": _delay,
    "zero-order-hold": _hold,
    "wave-variables": _waves,
    "position-force-teleoperator": _position_force,
    "position-position-teleoperator": _position_position,
    "four-channel-teleoperator": _four_channel,
    "coulomb-friction": lambda p, s, F, X, n: (F + 4j * p["force"] / (n.pi * p["amplitude"]) * X, X),
    "encoder": _harmonic(_staircase),
    "backlash": _harmonic(_play),
    "dead-zone": _harmonic(lambda p: 1 - _limited(p, "width")),
    "saturation": _harmonic(lambda p: _limited(p, "limit")),
    "first-order-lag": lambda p, s, F, X, n: (F / (1 + s / p["omega_c"]), X),
    "second-order-lowpass": lambda p, s, F, X, n: (
        F / ((s / p["omega_n"]) ** 2 + 2 * p["zeta"] * s / p["omega_n"] + 1),
        X,
    ),
    "shunt": lambda p, s, F, X, n: (F + _mass_spring_damper(p, s, n) * X, X),
    "compliance": lambda p, s, F, X, n: (F, X + F / (p.get("k", 0) + p.get("b", 0) * s)),
}
"""What each effect does to force and displacement, from its equations of motion."""


@dataclass(frozen=True)
class Element:
    """An environment or an effect: its model and its parameters as decimal texts."""

    model: str
    values: Mapping[str, str]

    def read(self, n: Numbers) -> dict[str, Any]:
        return {name: n.read(text) for name, text in self.values.items()}

    @property
    def table(self) -> str:
        return "\n".join([f'model = "{self.model}"', *(f'{name} = "{text}"' for name, text in self.values.items())])


@dataclass(frozen=True)
class Case:
    """A scene as physics, with its band (texts with units) and thresholds."""

    felt: Element
    between: tuple[Element, ...] = ()
    band: tuple[str, str] = ("0 rad/s", "15 rad/s")
    c: Mapping[str, str] = field(default_factory=lambda: {"real": "0.1", "imag": "0.1"})

    @property
    def text(self) -> str:
        """The scene file."""
        effects = [f"[[effects]]\n{element.table}" for element in self.between]
        jnd = f'jnd = {{ real = "{self.c["real"]}", imag = "{self.c["imag"]}" }}'
        evaluation = f'[evaluation]\nband = ["{self.band[0]}", "{self.band[1]}"]\n{jnd}'
        return "\n\n".join([f"[environment]\n{self.felt.table}", *effects, evaluation])

    def dynamics(self, omega: Any, n: Numbers) -> tuple[Any, Any]:
        """H_env and H_perc at frequencies."""
        s = 1j * omega
        H = FELT[self.felt.model](self.felt.read(n), s, n) + 0 * s
        F, X = H, 1 + 0 * s
        for element in self.between:
            F, X = BETWEEN[element.model](element.read(n), s, F, X, n)
        return H, F / X

    def facts(self, omega: Any, n: Numbers) -> Facts:
        H, G = self.dynamics(omega, n)
        size = abs(H)
        d = {"real": (G - H).real, "imag": (G - H).imag}
        return Facts(
            {part: abs(d[part]) / size - n.read(self.c[part]) for part in PARTS},
            {"real": H.real, "imag": H.imag},
            {"real": G.real, "imag": G.imag},
            d,
            size,
        )

    def without_friction(self, omega: Any, n: Numbers) -> Facts:
        """What is there without the friction."""
        return replace(self, between=tuple(x for x in self.between if x.model != "coulomb-friction")).facts(omega, n)

    def excess(self, part: str, omega: Any) -> Any:
        """r - c in mpmath."""
        return self.facts(omega, DIGITS).excess[part]

    @property
    def ends(self) -> tuple[float, float]:
        low, high = (float(x) * (2 * np.pi if unit == "Hz" else 1) for x, unit in (end.split() for end in self.band))
        return low, high


@dataclass(frozen=True)
class Facts:
    """r - c, and real and imaginary parts of H_env, H_perc and dH, at one frequency or many; ``|H_env|``."""

    excess: Mapping[str, Any]
    env: Mapping[str, Any]
    perc: Mapping[str, Any]
    difference: Mapping[str, Any]
    size: Any


def digits_of(x: Fraction) -> Any:
    return MP.mpf(x.numerator) / x.denominator


def sign(x: Any) -> int:
    return (x > 0) - (x < 0)


# --- looking everywhere ----------------------------------------------------------------------------------------------


def grid(case: Case, near: Iterable[float] = (), count: int = 600) -> Any:
    """Frequencies inside the band: even ones, logarithmic ones, around given ones, and wherever a curve peaks or dips."""
    low, high = case.ends
    first = max(low, high * 1e-6)
    even = np.linspace(first, high, count)
    decades = np.geomspace(first, high, count // 3)
    steps = np.concatenate([sign * 10.0 ** -np.arange(2, 10) for sign in (1, -1)])
    around = np.outer(np.asarray(list(near), dtype=float), 1 + steps).ravel()
    points = np.unique(np.concatenate([even, decades, around]))
    points = points[(points > low) & (points < high)]
    return np.unique(np.concatenate([points, *_turning(case, points)]))


def _turning(case: Case, points: Any, rounds: int = 8) -> Iterator[Any]:
    """Where r - c turns back towards 0, or ``|H_env|`` is least, ever finer."""
    for curve in (_size, *(_towards(part) for part in PARTS)):
        with np.errstate(all="ignore"):
            y = curve(case, points)
        inner = np.flatnonzero((y[1:-1] <= y[:-2]) & (y[1:-1] <= y[2:])) + 1
        left, right = points[inner - 1], points[inner + 1]
        for _ in range(rounds):
            finer = left + (right - left) * np.linspace(0, 1, 9)[:, None]
            yield finer[1:-1].ravel()
            with np.errstate(all="ignore"):
                best = np.clip(np.argmin(curve(case, finer), axis=0), 1, 7)
            columns = np.arange(len(left))
            left, right = finer[best - 1, columns], finer[best + 1, columns]


def _size(case: Case, points: Any) -> Any:
    return case.facts(points, FLOATS).size


def _towards(part: str) -> Callable[[Case, Any], Any]:
    return lambda case, points: abs(case.facts(points, FLOATS).excess[part])


def disagreements(case: Case, result: Any, near: Iterable[float] = (), count: int = 600) -> list[str]:
    """What an evaluation says and frequencies deny. Floats find the suspects; mpmath has the last word."""
    points = grid(case, [*near, *(float(c.omega) for c in result.crossings)], count)
    with np.errstate(all="ignore"):
        facts = case.facts(points, FLOATS)
    return [
        *(x for part in PARTS for x in _crossings(case, result, part)),
        *(x for part in PARTS for x in _cells(case, result, part, points, facts)),
        *_percepts(case, result, points, facts),
        *_active(case, result, points, facts),
    ]


def _crossings(case: Case, result: Any, part: str) -> Iterator[str]:
    """Every crossing is a sign change of r - c, or a touch, with the kind and the sign that it says."""
    found = [c for c in result.crossings if c.part.value == part]
    bounds = [c.omega.bounds(100) for c in found]
    for i, (c, (low, high)) in enumerate(zip(found, bounds, strict=True)):
        gap = high * Fraction(1, 10**9)
        if i:
            gap = min(gap, (low - bounds[i - 1][1]) / 3)
        if i + 1 < len(found):
            gap = min(gap, (bounds[i + 1][0] - high) / 3)
        below, above = (case.facts(digits_of(x), DIGITS) for x in (low - gap, high + gap))
        told = {"exceeds": (-1, 1), "returns": (1, -1)}.get(c.kind.value)
        seen = sign(below.excess[part]), sign(above.excess[part])
        if (seen[0] != seen[1] if told is None else seen != told) or sign(above.difference[part]) != c.sign:
            yield f"{part} crossing at {float(c.omega)!r}: {c.kind.value}, sign {c.sign}; r - c goes {seen}"


def _cells(case: Case, result: Any, part: str, points: Any, facts: Facts) -> Iterator[str]:
    """Between its crossings a ratio is on the side of the threshold that the crossings say."""
    found = [c for c in result.crossings if c.part.value == part and c.kind.value != "touches"]
    for c, following in pairwise(found):
        if c.kind is following.kind:
            yield f"{part}: {c.kind.value} twice, at {float(c.omega)!r} and {float(following.omega)!r}"
    places = np.array([float(c.omega) for c in found])
    exceeding = first_side(result, part) ^ (np.searchsorted(places, points) % 2 == 1)
    for w in points[((facts.excess[part] > 0) != exceeding) & ~_beside(points, places)]:
        value = case.excess(part, MP.mpf(w))
        if (value > 0) != (first_side(result, part) ^ (sum(_lies_below(c.omega, w) for c in found) % 2 == 1)):
            yield f"{part} at {w!r}: r - c = {MP.nstr(value, 5)}"


def first_side(result: Any, part: str) -> bool:
    """Whether a ratio exceeds its threshold at the low end of the band."""
    found = [c for c in result.crossings if c.part.value == part and c.kind.value != "touches"]
    if found:
        return bool(found[0].kind.value == "returns")
    # no crossing: all of the band, or (but for an active display) nothing
    [told] = [result.chart.points[0].after[x] for x in result.criteria if x.name == part]
    return bool(told > 0)


def _lies_below(number: Any, w: float) -> bool:
    low, high = number.bounds(140)
    exact = Fraction(w)
    assert high < exact or exact < low, f"{w!r} is too close to {number}"
    return bool(high < exact)


def _beside(points: Any, places: Any, share: float = 1e-12) -> Any:
    """Whether a frequency is one of some places, to a float's accuracy."""
    if not len(places):
        return np.zeros(len(points), dtype=bool)
    i = np.searchsorted(places, points)
    gaps = [abs(points - places[np.clip(i + k, 0, len(places) - 1)]) for k in (-1, 0)]
    return np.minimum(*gaps) < share * points


def _percepts(case: Case, result: Any, points: Any, facts: Facts) -> Iterator[str]:
    """Percepts cover where a ratio exceeds, but for an active display, and say what the signs say."""
    with np.errstate(all="ignore"):
        bare = case.without_friction(points, FLOATS)
    for part in PARTS:
        own = [(p, float(p.band.low.omega), float(p.band.high.omega)) for p in result.percepts if p.part.value == part]
        edges = np.array(sorted({x for _, low, high in own for x in (low, high)}))
        clear = ~_beside(points, edges, 1e-9)
        label = np.full(len(points), "", dtype=object)
        for p, low, high in own:
            label[(points > low) & (points < high)] = f"{p.property.value} {p.change.value}"
        for i in np.flatnonzero((label != _labels(facts, bare, part)) & clear):
            at = MP.mpf(points[i])
            exact = _labels(case.facts(at, DIGITS), case.without_friction(at, DIGITS), part)
            if str(exact) != label[i]:
                yield f"{part} percept at {points[i]!r}: said {label[i]!r}, is {exact!s}"


def _labels(facts: Facts, bare: Facts, part: str) -> Any:
    """Property and change, or nothing, at one frequency or many."""
    env, perc = (np.asarray(x[part]) for x in (facts.env, facts.perc))
    change = np.where(abs(perc) > abs(env), " higher", " lower")
    if part == "imag":
        name = np.where(np.asarray(bare.excess[part]) > 0, "damping", "friction")
        return _where(facts, part, np.char.add(name, change), passive=perc >= 0)
    # a part that is nothing throughout becomes something of the same kind
    before, after = (np.where(abs(x) > 1e-12 * np.asarray(facts.size), x, 0) for x in (env, perc))
    before, after = np.where(before == 0, after, before) > 0, np.where(after == 0, before, after) > 0
    same = np.where(before, "stiffness", "mass")
    other = np.where(before, "stiffness-to-mass", "mass-to-stiffness")
    return _where(facts, part, np.char.add(np.where(before == after, same, other), change), passive=True)


def _where(facts: Facts, part: str, label: Any, *, passive: Any) -> Any:
    return np.where((np.asarray(facts.excess[part]) > 0) & passive, label, "").astype(object)


def _active(case: Case, result: Any, points: Any, facts: Facts) -> Iterator[str]:
    """The display is active where Im H_perc < 0, and nowhere else."""
    bands = [(float(x.low.omega), float(x.high.omega)) for x in result.outside_model]
    told = np.zeros(len(points), dtype=bool)
    for low, high in bands:
        told |= (points > low) & (points < high)
    clear = ~_beside(points, np.array(sorted({x for band in bands for x in band})), 1e-9)
    for w in points[(told != (facts.perc["imag"] < 0)) & clear]:
        value = case.facts(MP.mpf(w), DIGITS).perc["imag"]
        if (value < 0) != any(low < w < high for low, high in bands):
            yield f"at {w!r}: Im H_perc = {MP.nstr(value, 5)}"


# --- random scenes ---------------------------------------------------------------------------------------------------


class Draw:
    """Random scenes: the same ones for the same seed."""

    def __init__(self, seed: int) -> None:
        self.random = Random(seed)

    def decades(self, low: float, high: float) -> str:
        """A number of two to four digits between two powers of ten."""
        return self.digits(low, high, self.random.choice((2, 3, 4)))

    def digits(self, low: float, high: float, count: int) -> str:
        return f"{Decimal(f'{10 ** self.random.uniform(low, high):.{count}g}'):f}"

    def environment(self, model: str) -> Element:
        scales = {
            "mass-spring-damper": {"m": (-2, 1), "b": (-3, 2), "k": (0, 4)},
            "kelvin-voigt": {"k": (0, 4), "b": (-2, 2)},
            "maxwell": {"k": (0, 4), "b": (-1, 3)},
            "zener": {"k0": (0, 4), "k1": (0, 4), "b1": (-1, 3)},
            "spring-pot": {"k_alpha": (0, 3), "k": (0, 3)},
            "two-mass": {"m1": (-2, 1), "b1": (-2, 2), "k1": (0, 4), "m2": (-2, 1), "b2": (-3, 1), "k2": (0, 4)},
        }[model]
        values = {name: self.decades(*scale) for name, scale in scales.items()}
        if model == "mass-spring-damper":  # sometimes a mass, spring or damper alone
            values = {name: x for name, x in values.items() if self.random.random() < 0.85} or values
        if model == "spring-pot":
            order = {"alpha": f"{self.random.randint(5, 95) / 100:g}"}
            return Element(model, order | dict(list(values.items())[: self.random.choice((1, 2))]))
        return Element(model, values)

    def effect(self, model: str) -> Element:
        scales = {
            "delay": {"tau": (-4, -0.5)},
            "zero-order-hold": {"T": (-4, -1)},
            "wave-variables": {"b": (-1, 2), "tau": (-3, -1)},
            "position-force-teleoperator": {"Mm": (-2, 0), "Ms": (-2, 0), "Bs": (0, 2), "Ks": (2, 4), "tau": (-3, -1)},
            "coulomb-friction": {"force": (-2, 1), "amplitude": (-3, 0)},
            "encoder": {"q": (-4, -2), "amplitude": (-2.5, -1)},
            "backlash": {"gap": (-4, -2), "amplitude": (-2.5, -1)},
            "dead-zone": {"width": (-4, -2), "amplitude": (-2, -1)},
            "saturation": {"limit": (-1, 1), "amplitude": (0, 1)},
            "first-order-lag": {"omega_c": (0, 3)},
            "second-order-lowpass": {"omega_n": (0.5, 3), "zeta": (-2, 0.5)},
            "shunt": {"m": (-3, 0), "b": (-2, 1), "k": (-1, 2)},
            "compliance": {"k": (2, 5), "b": (-1, 2)},
        }
        sides = {"Mm": (-2, 0), "Bm": (0, 2), "Km": (2, 4), "Ms": (-2, 0), "Bs": (0, 2), "Ks": (2, 4), "tau": (-3, -1)}
        # five digits make delays that are no small multiples of a common one
        values = {
            name: self.digits(*scale, 5) if name in ("tau", "T") else self.decades(*scale)
            for name, scale in scales.get(model, sides).items()
        }
        if model == "shunt":
            name = self.random.choice([*values])
            return Element(model, {name: values[name]})
        if model == "compliance" and self.random.random() < 0.5:
            del values["b"]
        return Element(model, values)

    def case(self, family: str) -> Case:
        models, environments, extras = FAMILIES[family]
        felt = self.environment(self.random.choice(environments))
        added = self.random.sample(RATIONAL, self.random.randint(0, extras if felt.model != "two-mass" else 0))
        effects = [self.effect(model) for model in (*models, *added)]
        self.random.shuffle(effects)
        c = self.decades(-2, 0.2)
        thresholds = {"real": c, "imag": self.random.choice((c, self.decades(-2, 0.2)))}
        return Case(felt, tuple(effects), self.band(effects), thresholds)

    def band(self, effects: Sequence[Element]) -> tuple[str, str]:
        """From 0 or a little above it to where the delays together turn by a few radians, or a few times that."""
        lag = sum(float(e.values.get(name, 0)) for e in effects for name in ("tau", "T"))
        turns = self.random.choice((2, 5, 10))
        high = (turns / lag if lag else 10**2.5) * 10 ** self.random.uniform(-0.5, 0)
        low = self.random.choice((0, 0, high / 50))
        unit, scale = self.random.choice((("rad/s", 1.0), ("rad/s", 1.0), ("Hz", 2 * np.pi)))
        low_text, high_text = (f"{Decimal(f'{x / scale:.2g}'):f} {unit}" for x in (low, high))
        return low_text, high_text


RATIONAL = ("first-order-lag", "second-order-lowpass", "shunt", "compliance")
SIMPLE = ("mass-spring-damper", "mass-spring-damper", "kelvin-voigt")
SOLID = (*SIMPLE, "maxwell", "zener")
ALL = (*SOLID, "spring-pot", "two-mass")

FAMILIES: dict[str, tuple[tuple[str, ...], tuple[str, ...], int]] = {
    "delay": (("delay",), ALL, 2),
    "two delays": (("delay", "delay"), SOLID, 1),
    "three delays": (("delay", "delay", "delay"), SIMPLE, 0),
    "hold": (("zero-order-hold",), ALL, 1),
    "sampled and sent": (("zero-order-hold", "delay"), SOLID, 1),
    "waves": (("wave-variables",), SOLID, 1),
    "waves and delay": (("wave-variables", "delay"), SIMPLE, 0),
    "position-force": (("position-force-teleoperator",), (*SIMPLE, "spring-pot"), 1),
    "position-position": (("position-position-teleoperator",), SIMPLE, 1),
    "four-channel": (("four-channel-teleoperator",), SOLID, 0),
    "four-channel and delay": (("four-channel-teleoperator", "delay"), SIMPLE, 0),
    "friction": (("coulomb-friction",), ALL, 1),
    "friction and delay": (("coulomb-friction", "delay"), ALL, 1),
    "fractional": ((), ("spring-pot",), 1),
    "staircase and play": (("encoder", "backlash"), ALL, 1),
    "limit and delay": (("saturation", "delay"), SOLID, 1),
    "dead zone": (("dead-zone",), SOLID, 2),
}
"""What the random scenes have in between, on which environments, and how many rational effects besides."""
