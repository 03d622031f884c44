"""Scenes to test with: random ones over decades of every parameter, and how the package is told of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from random import Random
from typing import Any, Protocol, TypeVar

from hypothesis import strategies as st
from oracles import Case, Element, Hertz
from sympy import Expr, Rational, pi

import haptisym as hs
from haptisym import effects, environments

T = TypeVar("T")


@dataclass(frozen=True)
class Scale:
    """Between which powers of ten a parameter lies, and how it grows with the units of force and time."""

    low: int
    high: int
    force: int = 0
    time: int = 0


MASS, DAMPING, STIFFNESS = Scale(-2, 1, 1, 2), Scale(-1, 2, 1, 1), Scale(0, 4, 1, 0)
RATE, TIME, RATIO = Scale(0, 3, 0, -1), Scale(-3, -1, 0, 1), Scale(-2, 0)
LIGHT = Scale(-3, 0, 1, 2)
STIFF = Scale(2, 5, 1, 0)

KINDS: dict[str, dict[str, Scale]] = {
    "mass-spring-damper": {"m": MASS, "b": DAMPING, "k": STIFFNESS},
    "kelvin-voigt": {"k": STIFFNESS, "b": DAMPING},
    "maxwell": {"k": STIFFNESS, "b": DAMPING},
    "zener": {"k0": STIFFNESS, "k1": STIFFNESS, "b1": DAMPING},
    "prony": {"k0": STIFFNESS, "k_1": STIFFNESS, "k_2": STIFFNESS, "b_1": DAMPING, "b_2": DAMPING},
    "two-mass": {"m1": MASS, "b1": DAMPING, "k1": STIFFNESS, "m2": MASS, "b2": DAMPING, "k2": STIFFNESS},
    "expression": {"k": STIFFNESS, "z": RATE, "q": RATE, "b": DAMPING},
    "first-order-lag": {"omega_c": RATE},
    "second-order-lowpass": {"omega_n": RATE, "zeta": RATIO},
    "gain": {"g": RATIO},
    "lead-lag": {"T1": TIME, "T2": TIME},
    "pade-delay": {"tau": TIME},
    "shunt": {"m": LIGHT, "b": DAMPING, "k": STIFFNESS},
    "compliance": {"k": STIFF, "b": DAMPING},
    "admittance-display": {"w": RATE},
    "two-port": {"g": RATIO, "d": DAMPING, "y": Scale(-4, -1, -1, -1), "q": RATE},
    "position-force-teleoperator": {"Mm": LIGHT, "Ms": LIGHT, "Bs": DAMPING, "Ks": STIFF},
    "position-position-teleoperator": {
        "Mm": LIGHT, "Bm": DAMPING, "Km": STIFF, "Ms": LIGHT, "Bs": DAMPING, "Ks": STIFF,
    },
}  # fmt: skip
"""The parameters of each kind, with their scales."""

OPTIONAL = ("mass-spring-damper", "shunt", "compliance")
ORDER = {
    "mass-spring-damper": 1, "kelvin-voigt": 1, "maxwell": 1, "zener": 1, "prony": 2, "two-mass": 3, "expression": 1,
    "first-order-lag": 1, "second-order-lowpass": 2, "gain": 0, "lead-lag": 1, "pade-delay": 2, "shunt": 1, "compliance": 1,
    "admittance-display": 2, "two-port": 1, "position-force-teleoperator": 2, "position-position-teleoperator": 2,
}  # fmt: skip
"""How much each kind adds to the degree of the threshold polynomial, roughly."""
FELT = tuple(KINDS)[:7]
BETWEEN = tuple(KINDS)[7:]


# --- how the package is told -----------------------------------------------------------------------------------------


def _text(value: Fraction) -> str:
    return f"{value.numerator}/{value.denominator}" + (" Hz" if isinstance(value, Hertz) else "")


def _series(formula: str, names: Mapping[str, str]) -> hs.Effect:
    return effects.series(formula, parameters=names)


def _prony(values: dict[str, str]) -> hs.Environment:
    return environments.prony(values["k0"], [values["k_1"], values["k_2"]], [values["b_1"], values["b_2"]])


TOLD: dict[str, Callable[[dict[str, str]], Any]] = {
    "mass-spring-damper": lambda v: environments.mass_spring_damper(**v),
    "kelvin-voigt": lambda v: environments.kelvin_voigt(**v),
    "maxwell": lambda v: environments.maxwell(**v),
    "zener": lambda v: environments.zener(**v),
    "prony": _prony,
    "two-mass": lambda v: environments.two_mass(**v),
    "expression": lambda v: environments.expression("k*(s + z)/(s + q) + b*s", parameters=v),
    "first-order-lag": lambda v: effects.first_order_lag(**v),
    "second-order-lowpass": lambda v: effects.second_order_lowpass(**v),
    "gain": lambda v: _series("g", v),
    "lead-lag": lambda v: _series("(1 + s*T1)/(1 + s*T2)", v),
    "pade-delay": lambda v: effects.pade_delay(v["tau"], 2),
    "shunt": lambda v: effects.shunt(**v),
    "compliance": lambda v: effects.compliance(**v),
    "admittance-display": lambda v: effects.admittance_display("w^2/(s^2 + w*s + w^2)", parameters=v),
    "two-port": lambda v: effects.two_port("g", "d*s", "y/(s + q)", "1", parameters=v),
    "position-force-teleoperator": lambda v: effects.position_force_teleoperator(**v),
    "position-position-teleoperator": lambda v: effects.position_position_teleoperator(**v),
}


def told(element: Element) -> Any:
    """The package's environment or effect."""
    return TOLD[element.kind]({name: _text(value) for name, value in element.values.items()})


def exact(x: Fraction) -> Expr:
    """The number as SymPy writes it, in rad/s if it is one of Hertz."""
    plain = Rational(x.numerator, x.denominator)
    return 2 * pi * plain if isinstance(x, Hertz) else plain


def scene(case: Case) -> hs.Scene:
    """The package's scene."""
    low, high = map(exact, case.band)
    threshold = hs.Threshold.of(case.c["real"], case.c["imag"])
    return hs.Scene(told(case.felt), tuple(map(told, case.between)), (low, high), threshold)


def evaluate(case: Case) -> hs.Evaluation:
    return hs.evaluate(scene(case))


# --- scaled units ----------------------------------------------------------------------------------------------------


def scaled(case: Case, *, force: Fraction = Fraction(1), time: Fraction = Fraction(1)) -> Case:
    """The same scene with every force that many times as large and everything that many times as slow."""

    def one(element: Element) -> Element:
        scales = KINDS[element.kind]
        return Element(
            element.kind, {n: x * force ** scales[n].force * time ** scales[n].time for n, x in element.values.items()}
        )

    low, high = case.band
    return case.with_(felt=one(case.felt), between=tuple(map(one, case.between)), band=(low / time, high / time))


# --- random scenes ---------------------------------------------------------------------------------------------------


class Picker(Protocol):
    """A source of choices: a seeded generator, or Hypothesis."""

    def whole(self, low: int, high: int) -> int: ...

    def choice(self, options: Sequence[T]) -> T: ...


class Seeded:
    """Choices of Python's generator, the same on every run."""

    def __init__(self, seed: int) -> None:
        self.random = Random(seed)

    def whole(self, low: int, high: int) -> int:
        return self.random.randint(low, high)

    def choice(self, options: Sequence[T]) -> T:
        return options[self.random.randrange(len(options))]


@dataclass(frozen=True)
class Drawn:
    """Choices of Hypothesis, which shrinks them."""

    draw: Callable[[st.SearchStrategy[Any]], Any]

    def whole(self, low: int, high: int) -> int:
        return int(self.draw(st.integers(low, high)))

    def choice(self, options: Sequence[T]) -> T:
        picked: T = self.draw(st.sampled_from(options))
        return picked


def number(pick: Picker, scale: Scale) -> Fraction:
    """A number of two digits, anywhere between those powers of ten."""
    return Fraction(pick.whole(10, 99), 10) * Fraction(10) ** pick.whole(scale.low, scale.high - 1)


def element(pick: Picker, kind: str) -> Element:
    scales = dict(KINDS[kind])
    if kind in OPTIONAL:
        kept = pick.choice([n for n in range(1, 1 << len(scales)) if kind != "shunt" or n.bit_count() < 3])
        scales = {name: x for i, (name, x) in enumerate(scales.items()) if kept >> i & 1}
    signs = (1, 1, -1) if kind == "shunt" else (1,)
    return Element(kind, {name: pick.choice(signs) * number(pick, x) for name, x in scales.items()})


def case(pick: Picker, order: int = 5, felt: Sequence[str] = FELT, between: Sequence[str] = BETWEEN) -> Case:
    """A random scene whose kinds add up to that order at most."""
    first = element(pick, pick.choice(felt))
    left, chain = order - ORDER[first.kind], []
    for _ in range(pick.whole(1, 3)):
        options = [kind for kind in between if ORDER[kind] <= left]
        if options:
            chain.append(element(pick, pick.choice(options)))
            left -= ORDER[chain[-1].kind]
    low = pick.choice([Fraction(0), Fraction(0), number(pick, Scale(-1, 1))])
    thresholds = [Fraction(n, 100) for n in (2, 5, 10, 15, 25, 40, 100)]
    return Case(first, tuple(chain), (low, low + number(pick, Scale(1, 4))),
                {"real": pick.choice(thresholds), "imag": pick.choice(thresholds)})  # fmt: skip


DAMPERS = ("zeta", "b", "b1", "b2")


def coincident_case(pick: Picker) -> Case:
    """A random scene of small whole numbers, often without damping, where zeros, poles and ends of the band coincide."""
    drawn = case(pick, order=4)
    small = [Fraction(n) for n in (1, 2, 3, 4, 5, 9)]

    def whole(name: str, old: Fraction) -> Fraction:
        if name in DAMPERS and pick.choice([True, False, False]):
            return Fraction(0)
        return pick.choice(small) * (-1 if old < 0 else 1)

    def coarse(old: Element) -> Element:
        undamped = old.kind in ("mass-spring-damper", "two-mass", "second-order-lowpass")
        return Element(old.kind, {n: whole(n if undamped else "", x) for n, x in old.values.items()})

    felt = coarse(drawn.felt)
    if not any(felt.values.values()):  # a damper alone that lost its damping: an environment that is zero is no scene
        felt = drawn.felt
    low = Fraction(pick.whole(0, 3))
    thresholds = [Fraction(1, n) for n in (1, 2, 4, 5, 10)]
    return Case(felt, tuple(map(coarse, drawn.between)), (low, low + pick.choice(small)),
                {"real": pick.choice(thresholds), "imag": pick.choice(thresholds)})  # fmt: skip


@st.composite
def cases(draw: Callable[[st.SearchStrategy[Any]], Any], order: int = 4, **kinds: Sequence[str]) -> Case:
    return case(Drawn(draw), order, **kinds)


def rationals(low: int = -3, high: int = 3) -> st.SearchStrategy[Fraction]:
    """Positive numbers of two digits between those powers of ten."""
    return st.builds(lambda n, e: Fraction(n, 10) * Fraction(10) ** e, st.integers(10, 99), st.integers(low, high - 1))


# Scenes that are listed

MSD = environments.mass_spring_damper("1.8 kg", "15 N*s/m", "100 N/m")
SOFT = environments.kelvin_voigt(200, 5)
SPRING = environments.mass_spring_damper(k=100)
TELEOPERATOR = {"Mm": "0.5 kg", "Ms": "2 kg", "Bs": "64 N*s/m", "Ks": "400 N/m", "tau": "20 ms"}
MASTER = {"Bm": "16 N*s/m", "Km": "100 N/m"}
CATALOGUE: dict[str, hs.Scene] = {
    "mass-spring-damper": hs.Scene(MSD),
    "kelvin-voigt": hs.Scene(SOFT),
    "maxwell": hs.Scene(environments.maxwell(100, 5)),
    "zener": hs.Scene(environments.zener(200, 300, 6)),
    "prony": hs.Scene(environments.prony(100, [300, 50], [6, 20])),
    "spring-pot": hs.Scene(environments.spring_pot(80, "0.3", 50)),
    "two-mass": hs.Scene(environments.two_mass("0.5", 4, 200, "0.3", 1, 120)),
    "expression": hs.Scene(environments.expression("k*(s + 3)/(s + 20) + b*s", parameters={"k": 100, "b": 2})),
    "first-order-lag": hs.Scene(MSD, (effects.first_order_lag(30),)),
    "second-order-lowpass": hs.Scene(MSD, (effects.second_order_lowpass(40, "0.4"),)),
    "delay": hs.Scene(MSD, (effects.delay("37 ms"),)),
    "pade-delay": hs.Scene(MSD, (effects.pade_delay("37 ms", 3),)),
    "zero-order-hold": hs.Scene(SOFT, (effects.zero_order_hold("30 ms"),)),
    "difference-equation": hs.Scene(
        SOFT, (effects.sampled_loop("30 ms"),),
        rendered=environments.difference_equation("k + b*(1 - 1/z)", parameters={"k": "200 N/m", "b": "100 N/m"}),
    ),
    "sampled-loop": hs.Scene(SOFT, (effects.sampled_loop("30 ms", "tustin", 1),)),
    "series": hs.Scene(MSD, (effects.series("(1 + s/50)/(1 + s/5)"),)),
    "shunt": hs.Scene(MSD, (effects.shunt(m="-0.4", b=2),)),
    "compliance": hs.Scene(MSD, (effects.compliance(500, 3),)),
    "coulomb-friction": hs.Scene(MSD, (effects.coulomb_friction("0.5 N", "5 cm"), effects.first_order_lag(30))),
    "encoder": hs.Scene(SPRING, (effects.encoder("3 mm", "5 cm"), effects.first_order_lag(30))),
    "backlash": hs.Scene(SOFT, (effects.backlash("1 cm", "5 cm"), effects.shunt(m="0.4", b=2))),
    "dead-zone": hs.Scene(SOFT, (effects.dead_zone("1 cm", "5 cm"), effects.delay("20 ms"))),
    "saturation": hs.Scene(SPRING, (effects.saturation("2 N", "5 N"), effects.first_order_lag(30))),
    "admittance-display": hs.Scene(MSD, (effects.admittance_display("400/(s^2 + 30*s + 400)"),)),
    "wave-variables": hs.Scene(MSD, (effects.wave_variables(10, "20 ms"),)),
    "position-force-teleoperator": hs.Scene(SOFT, (effects.position_force_teleoperator(**TELEOPERATOR),)),
    "position-position-teleoperator": hs.Scene(SOFT, (effects.position_position_teleoperator(**TELEOPERATOR, **MASTER),)),
    "four-channel-teleoperator": hs.Scene(SOFT, (effects.four_channel_teleoperator(**TELEOPERATOR, **MASTER),)),
    "two-port": hs.Scene(MSD, (effects.two_port("0.8", "2*s", "0.001/(1 + s/9)", "1"),)),
}  # fmt: skip
"""A scene for each model."""
