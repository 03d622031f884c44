"""Closed forms of a scene: how long they would be, counted a second time, when they are in symbols, and polynomials that are positive."""

from __future__ import annotations

import random
from functools import cache
from itertools import count
from math import cos as cosine
from types import SimpleNamespace as Made
from typing import Any

import pytest
from sympy import Add, Expr, Float, Integer, Rational, Symbol, exp, expand, fraction, lambdify, pi, together

import haptisym as hs
from haptisym.kernel.symbols import omega, s
from haptisym.model.jnd import Part
from haptisym.pages.sceneforms import DIFFERENCE, DYNAMICS, RATIO_FORMS, SceneForms, _size, _terms
from haptisym.writing.document import Line
from haptisym.writing.plain import said

E, F = hs.environments, hs.effects


def terms_of(value: Expr) -> int:
    found = expand(value)
    return 0 if found == 0 else len(Add.make_args(found))


class Fresh:
    """Formulas in which every symbol occurs once, so that nothing cancels and nothing is put together."""

    def __init__(self, seed: int) -> None:
        self.pick, self.names = random.Random(seed), (Symbol(f"x{n}") for n in count())

    def formula(self, depth: int) -> Expr:
        kind = self.pick.choice(["atom", "sum", "product", "quotient", "power", "quotient of one"]) if depth else "atom"
        if kind == "atom":
            return next(self.names)
        if kind == "power":
            return Add(*(next(self.names) for _ in range(self.pick.randint(1, 3)))) ** self.pick.choice([2, 3, -1, -2])
        one, two = self.formula(depth - 1), self.formula(depth - 1)
        return {"sum": one + two, "product": one * two, "quotient": one / two, "quotient of one": 1 / one}[kind]


@pytest.mark.parametrize("seed", range(24))
def test_the_terms_of_a_quotient_that_is_multiplied_out_are_counted_where_nothing_cancels(seed: int) -> None:
    value = Fresh(seed).formula(3)
    above, below = fraction(together(value))
    assert _terms(value) == (terms_of(above), terms_of(below))


def test_zero_has_no_term_and_what_is_no_quotient_is_one() -> None:
    a, b = Symbol("a"), Symbol("b")
    assert _terms(Integer(0)) == (0, 1)
    assert _terms(Integer(7)) == _terms(a) == _terms(exp(-a * s)) == _terms(a ** Rational(1, 2)) == (1, 1)
    assert _terms((a + b) ** 5) == (6, 1)
    assert _terms((a + b) ** -5) == (1, 6)
    assert _terms(1 / (a + b) + 1 / (a - b)) == (4, 4)


@pytest.mark.parametrize("seed", range(8))
def test_how_long_what_is_felt_would_be_is_counted_through_each_two_port(seed: int) -> None:
    fresh = Fresh(seed)
    many = fresh.pick.choice

    def total() -> Expr:
        return Add(*(next(fresh.names) for _ in range(many([1, 2, 3]))))

    chain = (
        [[total() / total() for _ in range(4)]]
        if seed % 3
        else [[next(fresh.names) for _ in range(4)] for _ in range(2)]
    )
    environment = fresh.formula(1) / (fresh.formula(0) + fresh.formula(0))
    above, below = fraction(together(environment))
    for a, b, c, d in chain:
        (a, p), (b, q), (c, r), (d, t) = (fraction(together(x)) for x in (a, b, c, d))
        above, below = (a * q * above + b * p * below) * r * t, (c * t * above + d * r * below) * p * q
    effects = [Made(dynamics=tuple(x)) for x in chain]
    for rendered in (None, Made(dynamics=environment)):
        own = Made(dynamics=environment if rendered is None else 2 * Symbol("never"))
        scene = Made(environment=own, rendered=rendered, effects=effects)
        assert _size(Made(scene=scene)) == terms_of(above) * terms_of(below)  # type: ignore[arg-type]


def lags(number: int) -> SceneForms:
    """Behind n lags the real part has a term for each even choice of them: 2^(n-1)."""
    own = tuple(F.first_order_lag(20 + n, name=f"l{n}") for n in range(number))
    return SceneForms(hs.evaluate(hs.Scene(E.mass_spring_damper(k=100), own, (0, 15), "0.1")))


def test_forms_of_more_than_fifty_terms_are_not_written_in_symbols() -> None:
    few, many = lags(4), lags(7)
    found = few.in_symbols(DYNAMICS)
    assert found
    assert few.in_symbols(DYNAMICS) is found  # once found, it is kept
    assert many.symbolic is not None
    assert many.in_symbols(DYNAMICS) is None
    assert many.in_symbols(DYNAMICS) is None
    for group in (DYNAMICS, DIFFERENCE):
        names = {x.name for row in few.in_numbers(group) if isinstance(row.value, Expr) for x in row.value.free_symbols}
        assert names <= {"s", "omega"}
    endless = SceneForms(few.evaluation, {DYNAMICS: None})
    assert endless.in_symbols(DYNAMICS) is None
    assert few.in_symbols(RATIO_FORMS) is not None


def test_where_there_are_far_too_many_products_there_are_no_symbols_at_all() -> None:
    small, large = lags(3), lags(7)
    for forms in (small, large):
        assert (forms.symbolic is None) == (_size(forms.evaluation) > 50_000)
    order = tuple(F.second_order_lowpass(f"{350 + n} rad/s", "0.5", name=f"f{n}") for n in range(12))
    forms = SceneForms(hs.evaluate(hs.Scene(E.mass_spring_damper(m=2, b=3, k=100), order, (1, 12), "0.1")))
    assert _size(forms.evaluation) > 50_000
    assert forms.symbolic is None
    assert forms.in_symbols(DYNAMICS) is None


# Polynomials that are positive where a function is


@cache
def forms_of(name: str) -> tuple[SceneForms, Any]:
    """The forms of a scene, and how much its change is of the environment at a frequency."""
    spring = E.mass_spring_damper(k=100)
    wall = E.mass_spring_damper(m="1.23456789", b="3.1415926535", k="97.531")
    scenes: dict[str, tuple[hs.Scene, Any]] = {
        "lag": (hs.Scene(spring, (F.first_order_lag(20),), (0, 15), {"real": "0.1", "imag": "0.2"}), lambda w: 20 / (20 + 1j * w)),
        "rounded": (hs.Scene(wall, (F.second_order_lowpass("37.123456 rad/s", "0.618"), F.first_order_lag("41.4213 rad/s")), (0, 15), {"real": "0.1", "imag": "0.2"}),
                    lambda w: 37.123456**2 / (37.123456**2 - w * w + 2j * 0.618 * 37.123456 * w) * 41.4213 / (41.4213 + 1j * w)),
        "hertz": (hs.Scene(spring, (F.first_order_lag("3 Hz"),), (0, 15), {"real": "0.1", "imag": "0.2"}), lambda w: 6 * 3.141592653589793 / (6 * 3.141592653589793 + 1j * w)),
        "delay": (hs.Scene(spring, (F.delay("40 ms"),), (0, 15), {"real": "0.1", "imag": "0.2"}), lambda w: complex(cosine(0.04 * w), -cosine(0.04 * w - 1.5707963267948966))),
    }  # fmt: skip
    scene, gain = scenes[name]

    def change(w: float) -> complex:
        felt = 97.531 - 1.23456789 * w * w + 3.1415926535j * w if name == "rounded" else 100 + 0j
        return complex((gain(w) - 1) * felt / abs(felt))

    return SceneForms(hs.evaluate(scene)), change


def at(line: Line, w: float) -> float:
    assert isinstance(line.value, Expr)
    return float(lambdify(omega, line.value, "mpmath")(w))


@pytest.mark.parametrize("name", ["lag", "rounded", "hertz", "delay"])
@pytest.mark.parametrize("part", Part)
def test_the_polynomial_of_a_threshold_is_positive_exactly_where_the_ratio_exceeds_it(name: str, part: Part) -> None:
    forms, change_at = forms_of(name)
    line = forms.threshold(part)
    assert said(line.left).startswith("p_r" if part is Part.REAL else "p_i")
    both = set()
    value = lambdify(omega, line.value, "mpmath")
    for n in range(1, 60):
        w = 0.37 * n
        change = change_at(w)
        ratio, limit = (abs(change.real), 0.1) if part is Part.REAL else (abs(change.imag), 0.2)
        assert (value(w) > 0) == (ratio > limit), w
        both.add(ratio > limit)
    assert both == {True, False}
    assert isinstance(line.value, Expr)
    assert (line.relation == "≈") == (name == "rounded")
    assert all(x._prec == Float("1", 10)._prec for x in line.value.atoms(Float))
    assert bool(line.value.atoms(Float)) == (name == "rounded")


def test_a_polynomial_in_factors_is_the_numerator_up_to_a_positive_number() -> None:
    forms, _ = forms_of("lag")
    value = forms.threshold(Part.REAL).value  # w^4/(w^2 + 400)^2 > 0.01, in two factors
    assert isinstance(value, Expr)

    def true(w: float) -> float:
        return (0.9 * w * w - 40) * (1.1 * w * w + 40)

    for w in (1.0, 5.0, 11.0):
        assert float(value.subs(omega, w)) / float(value.subs(omega, 20.0)) == pytest.approx(true(w) / true(20.0))
    nothing = SceneForms(hs.evaluate(hs.Scene(E.mass_spring_damper(k=100), (), (0, 15), "0.1")))
    assert at(nothing.threshold(Part.REAL), 3.0) < 0
    zero = nothing.evaluation.distortion.difference_response.real
    assert nothing.polynomial(forms.threshold(Part.REAL).left, zero).value == 0


# Short names


@pytest.mark.parametrize(
    ("label", "is_short"), [("eightlet", False), ("ninechars", True), ("a-long one", True), ("lag", False)]
)
def test_a_label_of_more_than_eight_letters_becomes_the_number_of_its_effect(label: str, is_short: bool) -> None:  # noqa: FBT001
    scene = hs.Scene(
        E.mass_spring_damper(k=100),
        (F.delay("1 ms", name="early"), F.first_order_lag(20, name=label), F.first_order_lag(30, name="late")),
        (0, 15),
        "0.1",
    )
    forms = SceneForms(hs.evaluate(scene))
    told = {x.name: y.name for x, y in forms.short_names.items()}
    own = scene.effects[1].parameters[0].symbol
    assert told == ({own.name: "omega_c_2"} if is_short else {})
    assert all(x.assumptions0 == y.assumptions0 for x, y in forms.short_names.items())
    [row] = forms.named([Line(forms_of("lag")[0].threshold(Part.REAL).left, own * pi)])
    assert row.value == (next(iter(forms.short_names.values())) if is_short else own) * pi


def test_a_short_name_that_another_parameter_has_is_not_given() -> None:
    own = {"omega_c_1": 3, "k": 100}
    for letters, told in (("omega_c_1*s + k", {}), ("k", {"omega_c_ninechars": "omega_c_1"})):
        environment = E.expression(letters, parameters={x: y for x, y in own.items() if x in letters})
        forms = SceneForms(
            hs.evaluate(
                hs.Scene(environment, (F.first_order_lag(20, name="ninechars"), F.first_order_lag(30)), (0, 15), "0.1")
            )
        )
        found = {x.name: y.name for x, y in forms.short_names.items() if x.name.endswith("ninechars")}
        assert found == told


def test_rounded_quotients_are_of_factors_that_begin_with_one_and_keep_their_values() -> None:
    forms, _ = forms_of("rounded")
    wall, true = forms.evaluation.distortion, {}
    for name, form in (("H_env(s)", wall.environment), ("H_perc(s)", wall.perceived)):
        true[name] = lambdify(s, form, "mpmath")
    for line in forms.in_numbers(DYNAMICS):
        assert isinstance(line.value, Expr)
        shown = lambdify(s, line.value, "mpmath")
        for at_s in (0.5, 2j, 7 + 3j):
            value = complex(true[said(line.left)](at_s))
            assert abs(complex(shown(at_s)) - value) <= 1e-4 * abs(value)
        assert (line.relation == "≈") == (said(line.left) == "H_perc(s)")
