"""Crossings and changeovers as formulas, against the certified zeros."""

from __future__ import annotations

import pytest
from sympy import Integer, Rational, acos, asin, pi, sqrt

import haptisym as hs
from haptisym.judge.criteria import noticed, opened
from haptisym.kernel.response import RealFunction
from haptisym.kernel.roots import chart
from haptisym.kernel.solutions import solve
from haptisym.kernel.symbols import c, omega
from haptisym.model import catalogue
from haptisym.model.distortion import Distortion, part_of

E, F = hs.environments, hs.effects
TAU, K, B, M, OMEGA_C, K_ALPHA, ALPHA = hs.symbols("tau k b m omega_c k_alpha alpha")
NUMBERS = {
    TAU: Rational(3, 100), K: Integer(120), B: Integer(7), M: Rational(9, 5), OMEGA_C: Integer(60), K_ALPHA: Integer(80),
    ALPHA: Rational(1, 4), c: Rational(1, 10),
}  # fmt: skip
CASES = {
    "delay on a spring": ((E.mass_spring_damper(k=K),), (F.delay(TAU),)),
    "delay on a damper": ((E.mass_spring_damper(b=B),), (F.delay(TAU),)),
    "delay on a mass": ((E.mass_spring_damper(m=M),), (F.delay(TAU),)),
    "lag on a spring": ((E.mass_spring_damper(k=K),), (F.first_order_lag(OMEGA_C),)),
    "lag on a damper": ((E.mass_spring_damper(b=B),), (F.first_order_lag(OMEGA_C),)),
    "lag on a spring-pot": ((E.spring_pot(K_ALPHA, ALPHA),), (F.first_order_lag(OMEGA_C),)),
    "mass beside a spring": ((E.mass_spring_damper(k=K),), (F.shunt(m=M),)),
    "spring behind a damper": ((E.mass_spring_damper(b=B),), (F.compliance(k=K),)),
}


def symbolic(name: str) -> Distortion:
    [environment], effects = CASES[name]
    return hs.distort(environment, *effects)


def numeric_scene(name: str, high: int) -> hs.Scene:
    """The same scene with numbers for all parameters."""
    [environment], effects = CASES[name]

    def with_numbers(element):  # type: ignore[no-untyped-def]
        arguments = {p.key: NUMBERS[p.value] for p in element.parameters}
        models = catalogue.ENVIRONMENTS if isinstance(element, hs.Environment) else catalogue.EFFECTS
        return models[element.model].build(**arguments)

    return hs.Scene(with_numbers(environment), tuple(map(with_numbers, effects)), (0, high))


def excess(d: hs.Distortion, part: hs.Part) -> RealFunction:
    """r^2 - c^2 of a part, c a symbol."""
    [found] = [x.function(d) for x in opened(noticed(hs.Threshold()), hs.Part) if x.part is part]
    assert isinstance(found, RealFunction)
    return found


@pytest.mark.parametrize("part", list(hs.Part), ids=lambda p: p.value)
@pytest.mark.parametrize("name", CASES)
def test_formulas_give_exactly_the_certified_crossings(name: str, part: hs.Part) -> None:
    high = 150
    formulas = solve(excess(symbolic(name), part))
    assert all(x.omega is not None for x in formulas)
    found = set()
    for solution in formulas:
        first = solution.omega.xreplace(NUMBERS).evalf(30)
        period = solution.period.xreplace(NUMBERS).evalf(30)
        for turn in range(-3, 4) if period else [0]:
            value = first + turn * period
            if value.is_real and 0 < value < high:
                found.add(round(float(value), 9))
    certified = [x for x in hs.evaluate(numeric_scene(name, high)).crossings if x.part is part]
    assert sorted(found) == [round(float(x.omega), 9) for x in certified]


def test_a_delay_on_a_spring_is_noticed_at_the_inverse_sine_and_cosine() -> None:
    d = symbolic("delay on a spring")
    assert solve(excess(d, hs.Part.IMAG))[0].omega == asin(c) / TAU
    assert solve(excess(d, hs.Part.REAL))[0].omega == acos(1 - c) / TAU


@pytest.mark.parametrize(
    ("environment", "effects", "expected"),
    [
        (E.mass_spring_damper(M, B, K), (), sqrt(K) / sqrt(M)),
        (E.kelvin_voigt(K, B), (F.shunt(m=M),), sqrt(K) / sqrt(M)),
        (E.mass_spring_damper(k=K), (F.delay(TAU),), pi / (2 * TAU)),
        (E.mass_spring_damper(b=B), (F.delay(TAU),), pi / TAU),
        (E.kelvin_voigt(K, B), (), None),
    ],
)
def test_changeovers_of_models_of_few_parameters_are_formulas(environment, effects, expected) -> None:  # type: ignore[no-untyped-def]
    assert hs.distort(environment, *effects).changeover_perceived == expected


@pytest.mark.parametrize("part", list(hs.Part), ids=lambda p: p.value)
@pytest.mark.parametrize("name", [name for name in CASES if "delay" in name])
def test_formulas_give_every_zero_of_what_is_felt_behind_a_delay(name: str, part: hs.Part) -> None:
    high, found = 500, set()
    for solution in solve(part_of(symbolic(name).perc_response, part)):
        first, period = (x.xreplace(NUMBERS).evalf(30) for x in (solution.omega, solution.period))
        assert 0 < first <= period
        found |= {round(float(first + turn * period), 9) for turn in range(9) if first + turn * period < high}
    felt = part_of(numeric_scene(name, high).distortion().perc_response, part)
    points = chart({"felt": felt}, Integer(0), Integer(high)).points[1:-1]
    assert sorted(found) == [round(float(x.omega), 9) for x in points if x.orders]


def test_what_cannot_be_inverted_is_its_own_answer() -> None:
    [solution] = solve(excess(hs.distort(E.kelvin_voigt(K, B), F.delay(TAU)), hs.Part.REAL))
    assert solution.omega is None
    assert solution.equation.has(omega)
