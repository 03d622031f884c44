"""Formulas: a small safe grammar, exact values, and an answer in no time for whatever a text holds."""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from time import process_time

import pytest
from hypothesis import given
from hypothesis import strategies as st
from sympy import Eq, Rational, pi, true

import haptisym as hs
from haptisym.environments import expression
from haptisym.kernel.symbols import s as symbol
from haptisym.model.expressions import HIGHEST_DEGREE, evaluate

NAMES = {"x": Fraction(3), "y": Fraction(-2, 7), "s_1": Fraction(5, 2)}


def value(text: str) -> Fraction:
    return evaluate(text, number=Fraction, name=NAMES.__getitem__)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("1 + 2*3", 7), ("(1 + 2)*3", 9), ("2*x^2 - (x + 1)/4", 17), ("8/4/2", 1), ("8/(4/2)", 4), ("8 - 4 - 2", 2),
        ("8 - (4 - 2)", 6), ("-x^2", -9), ("(-x)^2", 9), ("2^-1", Fraction(1, 2)), ("2^(-2)", Fraction(1, 4)),
        ("2**3", 8), ("2 ** +3", 8), ("-2*-3", 6), ("2*-x^2", -18), ("--x", 3), ("+-+x", -3), ("1.5e2", 150),
        (".5", Fraction(1, 2)), ("2.", 2), ("1e-3", Fraction(1, 1000)), ("s_1*2", 5), ("x\n + \t 1", 4), ("x^0", 1),
        ("0^0", 1), ("6/2*3", 9), ("2*3^2", 18), ("(2*3)^2", 36), ("-1^2", -1), ("((((x))))", 3), ("1 - -1", 2),
        ("x^1.0", 3),
    ],
)  # fmt: skip
def test_formulas_mean_what_they_say(text: str, expected: Fraction | int) -> None:
    assert value(text) == expected


@pytest.mark.parametrize(
    "text",
    [
        "", " ", "1 +", "* 1", "1 1", "2x", "x y", "(1", "1)", "()", "1 + )", "x^", "x^y", "x^x", "x^(1+1)", "x^^2",
        "x***2", "2^3^2", "x**2**2", "1..2", "1e", "1e+", "x.y", "x[0]", "x(1)", "sin(x)", "x, y", "x; y", "x = 1",
        "x == 1", "x != 1", "x < 1", "x > 1", "x % 2.", "x // 2", "x & 1", "x | 1", "~x", "!x", "'x'", '"x"',
        "lambda: 0", "__import__('os')", "__import__", "().__class__", "x.__class__", "exec", "eval(1)", "{}", "[]",
        "x if x else y", "not x", "x@y", "$x", "#x", "x\\", "x?", "`x`", "x\x00", "½", "x²", "√x", "π", "∞", "nan",
        "inf", "oo", "zoo", "True", "None", "unknown", "1/0", "x/(x - 3)", "0^-1", "(x - 3)^(-2)", "1j", "0x1", "1_0",
        "x‐1", "x−1", "x×2", "１＋１", "\u202e1", "x\u00a0\u200by",
    ],
)  # fmt: skip
def test_what_is_not_in_the_grammar_is_refused(text: str) -> None:
    with pytest.raises(hs.ExpressionError):
        value(text)


@pytest.mark.parametrize(
    "text",
    [
        "x^100000", "x^999999999999999999999", "10^10^10", "(10^10)^10^10", "9^9999999", "(((x^9)^9)^9)^9",
        "9^999*9^999*9^999", "(" * 1000 + "x" + ")" * 1000, "-" * 3000 + "x", "+" * 3000 + "x",
        "(-" * 100 + "x" + ")" * 100, "x" * 5000, "1" * 5000, "*".join(["x"] * 100), "+".join(["1"] * 3000),
        "(x+1)^60*(x+1)^60", "x^-61", "1e9999999999", "x^1e9", "x^0.0000000000000001", "((1+x)^30)^3",
        "x^" * 1000 + "2", "(" * 61 + "x" + ")" * 61,
    ],
)  # fmt: skip
def test_what_is_too_large_or_too_deep_is_refused_at_once(text: str) -> None:
    start = process_time()
    with pytest.raises(hs.SceneError) as refused:
        expression(text, parameters={"x": 1})
    assert process_time() - start < 1
    assert len(str(refused.value)) < 400


def test_sixty_deep_and_degree_sixty_are_allowed() -> None:
    assert value("(" * 60 + "x" + ")" * 60) == 3
    assert value("-" * 60 + "x") == 3
    assert value("x^60") == 3**60
    assert value("*".join(["x"] * 60)) == 3**60


def test_an_error_points_at_its_place() -> None:
    with pytest.raises(hs.ExpressionError) as refused:
        value("1 + x*unknown - 2")
    message, shown, caret = str(refused.value).split("\n")
    assert "unknown" in message
    assert shown[caret.index("^") :].startswith("unknown")


def test_an_error_far_into_a_formula_points_at_its_place_too() -> None:
    with pytest.raises(hs.ExpressionError) as refused:
        value("1 + " * 300 + "unknown" + " + 1" * 300)
    _, shown, caret = str(refused.value).split("\n")
    assert shown[caret.index("^") :].startswith("unknown")
    assert len(shown) < 120


# --- random formulas -------------------------------------------------------------------------------------------------

Formula = tuple[str, Fraction, int]
"""A text, its value, and how tightly it binds: 0 a sum, 1 a product, 2 a sign, 3 a power, 4 an atom."""

SPACE = st.sampled_from(["", " ", "  "])


def in_brackets(formula: Formula, least: int) -> str:
    text, _, binding = formula
    return text if binding >= least else f"({text})"


@st.composite
def formulas(draw: Callable[[st.SearchStrategy[object]], object], depth: int = 4) -> Formula:
    if depth == 0 or draw(st.integers(0, 4)) == 0:
        if draw(st.booleans()):
            name = draw(st.sampled_from(sorted(NAMES)))
            return str(name), NAMES[str(name)], 4
        number = draw(st.sampled_from(["0", "1", "2", "7", "0.5", "12.25", "3e-1", ".75", "4."]))
        return str(number), Fraction(str(number)), 4
    one = draw(formulas(depth - 1))
    other = draw(formulas(depth - 1))
    gap = draw(SPACE)
    kind = draw(st.sampled_from(["+", "-", "*", "/", "sign", "power"]))
    assert isinstance(one, tuple)
    assert isinstance(other, tuple)
    if kind == "+":
        return f"{one[0]}{gap}+{gap}{in_brackets(other, 1)}", one[1] + other[1], 0
    if kind == "-":
        return f"{one[0]}{gap}-{gap}{in_brackets(other, 1)}", one[1] - other[1], 0
    if kind == "*":
        return f"{in_brackets(one, 1)}{gap}*{gap}{in_brackets(other, 2)}", one[1] * other[1], 1
    if kind == "/" and other[1]:
        return f"{in_brackets(one, 1)}{gap}/{gap}{in_brackets(other, 2)}", one[1] / other[1], 1
    if kind == "sign":
        return f"-{gap}{in_brackets(one, 2)}", -one[1], 2
    exponent = draw(st.integers(-2 if one[1] else 0, 3))
    assert isinstance(exponent, int)
    sign = draw(st.sampled_from(["^", "**"]))
    return f"{in_brackets(one, 4)}{gap}{sign}{gap}{exponent}", one[1] ** exponent, 3


@given(formulas())
def test_random_formulas_have_the_value_of_fractions(formula: Formula) -> None:
    text, expected, _ = formula
    assert value(text) == expected


@given(formulas(depth=3))
def test_random_formulas_as_dynamics_have_the_value_of_fractions(formula: Formula) -> None:
    text, expected, _ = formula
    parameters = {name: f"{x.numerator}/{x.denominator}" for name, x in NAMES.items()}
    assert Rational(expected.numerator, expected.denominator) == expression(f"s*0 + {text}", parameters=parameters).H


@given(st.text(alphabet="0123456789.+-*/^() sxe", max_size=25))
def test_any_text_is_either_a_value_or_an_error_of_ours(text: str) -> None:
    try:
        found = value(text)
    except hs.ExpressionError:
        return
    assert isinstance(found, int | float | Fraction | complex)


@given(st.text(alphabet="sλµ²½−×√π∞١ａé🙂\u202e\u200b\x00\n\t +-*/^()12.", max_size=30))
def test_any_unicode_text_as_dynamics_is_either_a_formula_or_an_error_of_ours(text: str) -> None:
    try:
        found = expression(text)
    except hs.SceneError:
        return
    assert found.H.free_symbols <= {hs.s}


@st.composite
def powers(draw: Callable[[st.SearchStrategy[object]], object]) -> tuple[str, int]:
    """A product of powers of sums of s, and a bound on its degree: each power counts whichever way it stands."""
    text, degree = "1", 0
    for _ in range(3):
        own, top, below = (draw(st.integers(1, high)) for high in (3, 99, 4))
        assert isinstance(own, int)
        assert isinstance(top, int)
        assert isinstance(below, int)
        sign, joined = draw(st.sampled_from(["", "-", "+"])), draw(st.sampled_from(["*", "/"]))
        text += f" {joined} ({'*'.join(['(s + 2)'] * own)})^({sign}{top}/{below})"
        degree += own * (top // below + (top % below > 0))
    return text, degree


class Felt:
    """What stands for a name: powers of it are not written out."""

    def same(self, _: object) -> Felt:
        return self

    __add__ = __radd__ = __mul__ = __rmul__ = __truediv__ = __rtruediv__ = __pow__ = same

    def __bool__(self) -> bool:
        return True


@given(powers())
def test_a_degree_is_counted_whichever_way_a_power_stands(given_power: tuple[str, int]) -> None:
    text, degree = given_power
    try:
        evaluate(text, number=Fraction, name=lambda _: Felt())
    except hs.ExpressionError as error:
        assert f"is higher than {HIGHEST_DEGREE}" in str(error)  # noqa: PT017  only of those that are refused
        assert degree > HIGHEST_DEGREE
    else:
        assert degree <= HIGHEST_DEGREE


@pytest.mark.parametrize("text", ["1/0", "s + 1/(1/(s - s))", "0^-1", "1/(s - s)", "0/0"])
def test_a_division_by_zero_in_a_dynamics_is_refused(text: str) -> None:
    with pytest.raises(hs.ExpressionError, match="zero"):
        expression(text)


def test_a_number_to_a_power_that_is_not_whole_is_refused() -> None:
    with pytest.raises(hs.SceneError):
        hs.distort(expression("2^0.5"))


def test_names_of_parameters_may_not_hide_the_variable() -> None:
    for name in ("s", "omega", "pi", "j", "1x", "a b", "", "a-b"):
        with pytest.raises(hs.SceneError, match="cannot name a parameter"):
            expression("s", parameters={name: 1})


def test_an_unknown_name_lists_the_known_ones() -> None:
    with pytest.raises(hs.SceneError, match="known are s, pi, m, k"):
        expression("m*s^2 + c*s + k", parameters={"m": "1 kg", "k": "1 N/m"})


@pytest.mark.parametrize("hertz", ["12", "0.5", "1e3"])
def test_pi_in_a_formula_is_exact_as_it_is_in_a_frequency_in_hertz(hertz: str) -> None:
    wall = hs.environments.mass_spring_damper(2, 15, 100)
    by_hand = hs.effects.series("1/(1 + s/(2*pi*f))", parameters={"f": f"{hertz} 1/s"})
    of_catalogue = hs.effects.first_order_lag(f"{hertz} Hz")
    assert hs.distort(wall, by_hand).perceived.equals(hs.distort(wall, of_catalogue).perceived)
    one, two = (hs.evaluate(hs.Scene(wall, (x,), (0, 40), "0.05")) for x in (by_hand, of_catalogue))
    assert [x.omega.digits(40) for x in one.crossings] == [x.omega.digits(40) for x in two.crossings]
    assert one.certified


@pytest.mark.parametrize("given", ["12 Hz", ["5 Hz", "12 Hz"]])
def test_a_value_in_hertz_beside_pi_is_refused_as_its_turns_would_count_twice(given: object) -> None:
    with pytest.raises(
        hs.SceneError, match="a pi of its own, as of a value in Hz: leave pi out of the formula, or give f in 1/s"
    ):
        hs.effects.series("1/(1 + s/(2*pi*f))", parameters={"f": given})
    hs.effects.series("1/(1 + s/(2*pi*f))*g/(s + g)", parameters={"f": "12 1/s", "g": "12 rad/s"})
    hs.effects.series("1/(1 + s/f)", parameters={"f": given})


def test_a_threshold_may_be_a_formula_in_hertz() -> None:
    wall, lag = hs.environments.mass_spring_damper(2, 15, 100), hs.effects.first_order_lag(30)
    found = hs.evaluate(hs.Scene(wall, (lag,), (0, 40), "0.05 + omega/(2*pi)/50")).crossings
    assert found
    for x in found:
        w = complex(0, float(x.omega))
        H, G = 2 * w**2 + 15 * w + 100, 30 / (w + 30)
        change = (G * H - H) / abs(H)
        part = change.real if x.part is hs.Part.REAL else change.imag
        assert abs(part) == pytest.approx(
            0.05 + w.imag / (2 * math.pi) / 50, abs=1e-12
        )  # of floats, far above their last digit


def test_a_power_of_pi_in_a_formula_is_whole() -> None:
    with pytest.raises(hs.SceneError, match="of s alone"):
        expression("pi^0.5*s")
    assert Eq(expression("pi^2*s").H, pi**2 * symbol) is true


def test_a_number_is_a_formula() -> None:
    for given_value in (2, 2.0, "2", "2.0"):
        assert expression(given_value).H == 2


@pytest.mark.parametrize(
    ("text", "order"), [("s^(1/3)", "1/3"), ("s^(-1/3)", "-1/3"), ("s^( 3 / 12 )", "1/4"), ("s^(6/3)", "2")]
)
def test_an_exponent_may_be_a_quotient_in_parentheses(text: str, order: str) -> None:
    own = expression(f"5*{text}")
    assert own.dynamics == 5 * symbol ** Rational(order)
