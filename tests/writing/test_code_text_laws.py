"""Code as text: brackets only where they are needed, numbers as nearest doubles, names that clash with nothing."""

from __future__ import annotations

import ast
import keyword
import random
import re
from collections.abc import Iterator
from math import inf, isfinite, nextafter

import numpy as np
import pytest
from sympy import Expr, Integer, Rational, pi, sqrt, symbols

from haptisym.kernel.errors import SceneError
from haptisym.programs.program import Writer
from haptisym.writing.code.expressions import DIALECTS, CodePiece, CodeReader, Precedence, _leads, nearest_double
from haptisym.writing.code.names import RESERVED, Language, comment, function_name, identifiers

a, b, c = symbols("a b c", positive=True)
AT = {"a": 1.37, "b": 0.61, "c": 2.9}


def reader(language: Language = Language.NUMPY) -> CodeReader:
    write = Writer((a, b, c))
    program = write.program({"y": write.expression(a)})
    return CodeReader(program, {"a", "b", "c"}, dialect=DIALECTS[language], names={a: "a", b: "b", c: "c"})


def pieces(pick: random.Random, depth: int, *, signed: bool) -> tuple[CodePiece, float]:
    """An expression put together by lot, and its value; ``signed`` : with minuses in front of what is no sum too."""
    own = reader()
    kind = pick.choice(["leaf", "add", "sub", "mul", "div", *["neg"] * signed, "sqrt", "power"]) if depth else "leaf"
    if kind == "leaf":
        if pick.random() < 0.3:
            number = pick.choice([Rational(2), Rational(1, 3), *[Rational(-3), Rational(-5, 7)] * signed])
            return own.constant(number), float(number)
        name = pick.choice("abc")
        return CodePiece(name), AT[name]
    x, one = pieces(pick, depth - 1, signed=signed)
    if kind == "neg":
        return own.made("neg", x), -one
    if kind == "sqrt":
        square = own.made("mul", x, x)
        return own.made("sqrt", square), abs(one)
    if kind == "power":
        exponent = pick.choice([2, 3])
        return own.made("power", x, CodePiece(str(exponent))), one**exponent
    y, two = pieces(pick, depth - 1, signed=signed)
    value = {"add": one + two, "sub": one - two, "mul": one * two, "div": one / two if two else inf}[kind]
    return own.made(kind, x, y), value


def value(text: str) -> float:
    return float(eval(text, {"__builtins__": {}}, {**AT, "np": np}))  # noqa: S307  the text is of this test


def without_brackets(text: str) -> Iterator[str]:
    """The same with one pair of brackets less, but for those of calls."""
    open_at: list[int] = []
    for i, x in enumerate(text):
        if x == "(":
            open_at.append(i)
        elif x == ")":
            start = open_at.pop()
            if not start or not text[start - 1].isalnum():
                yield text[:start] + text[start + 1 : i] + text[i + 1 :]


@pytest.mark.parametrize("seed", range(12))
def test_an_expression_in_code_has_its_value_and_no_bracket_that_could_be_left_out(seed: int) -> None:
    pick, judged = random.Random(seed), 0
    for _ in range(40):
        signed = pick.random() < 0.5
        piece, true = pieces(pick, pick.randint(1, 4), signed=signed)
        if not isfinite(true) or abs(true) > 1e6:
            continue
        assert value(piece.text) == pytest.approx(true, rel=1e-9, abs=1e-9), piece.text
        assert piece.is_negative == (piece.text.startswith("-") and piece.kind is not Precedence.SUM)
        tree = ast.parse(piece.text, mode="eval").body
        for other in () if signed else without_brackets(piece.text):
            judged += 1
            assert ast.dump(ast.parse(other, mode="eval").body) != ast.dump(tree), piece.text
    assert judged > 5


def test_a_sum_takes_over_minuses_and_begins_with_a_plus_where_it_can() -> None:
    own = reader()
    x, y, minus = CodePiece("a"), CodePiece("b"), own.made("neg", CodePiece("c"))
    assert own.made("add", minus, x).text == own.made("add", x, minus).text == "a - c"
    assert own.made("sub", x, minus).text == "a + c"
    assert own.made("add", x, own.made("add", y, x)).text in ("a + (b + a)", "b + a + a")
    assert own.made("sub", x, own.made("sub", y, x)).text == "a - (b - a)"
    assert own.made("neg", own.made("sub", x, y)).text == "-(a - b)"
    assert own.made("neg", minus).text == "c"
    assert own.made("add", minus, own.made("neg", x)).text == "-c - a"
    assert own.made("neg", own.made("div", x, y)).kind is Precedence.QUOTIENT
    assert own.made("neg", x).kind is own.made("neg", own.made("mul", x, y)).kind is Precedence.PRODUCT


def test_in_a_product_a_minus_stands_first_then_numbers_then_quotients() -> None:
    own = reader()
    minus, number, quotient, name = (
        own.made("neg", CodePiece("a")),
        CodePiece("7"),
        own.made("div", CodePiece("a"), CodePiece("b")),
        CodePiece("c"),
    )
    ranked = [minus, number, quotient, name]
    assert [_leads(x) for x in ranked] == sorted((_leads(x) for x in ranked), reverse=True)
    assert len({_leads(x) for x in ranked}) == 4
    for i, one in enumerate(ranked):
        for two in ranked[i + 1 :]:
            assert own.made("mul", two, one).text == own.made("mul", one, two).text
            assert own.made("mul", two, one).text.startswith(one.text)
    assert own.made("mul", quotient, name).kind is Precedence.QUOTIENT
    assert own.made("mul", name, number).kind is Precedence.PRODUCT
    assert own.made("div", name, own.made("mul", name, number)).text == "c/(7*c)"


@pytest.mark.parametrize(
    ("language", "square", "root", "size", "sine"),
    [
        (Language.NUMPY, "(a + b)**c", "np.sqrt(a)", "np.abs(a)", "np.sin(a)"), (Language.C, "pow(a + b, c)", "sqrt(a)", "fabs(a)", "sin(a)"),
        (Language.OCTAVE, "(a + b).^c", "sqrt(a)", "abs(a)", "sin(a)"), (Language.JULIA, "(a + b)^c", "sqrt(a)", "abs(a)", "sin(a)"),
        (Language.JAVASCRIPT, "Math.pow(a + b, c)", "Math.sqrt(a)", "Math.abs(a)", "Math.sin(a)"),
    ],
)  # fmt: skip
def test_powers_and_functions_are_those_of_the_language(
    language: Language, square: str, root: str, size: str, sine: str
) -> None:
    own = reader(language)
    x, y, z = (CodePiece(name) for name in "abc")
    assert own.made("power", own.made("add", x, y), z).text == square
    assert own.made("power", x, CodePiece("0.5")).text == own.made("sqrt", x).text == root
    assert own.made("abs", x).text == size
    twice, above = (
        own.made("power", own.made("power", x, CodePiece("2")), y).text,
        own.made("power", x, own.made("power", y, z)).text,
    )
    if language in (Language.C, Language.JAVASCRIPT):
        assert "(" not in own.made("div", z, own.made("power", x, y)).text.replace("pow(", "").replace("Math.", "")
    else:
        sign = square.replace("(a + b)", "").removesuffix("c")
        assert (twice, above) == (f"(a{sign}2){sign}b", f"a{sign}(b{sign}c)")
        assert own.made("div", z, own.made("power", x, y)).text == f"c{own.dialect.over}a{sign}b"
    assert own.made("sin", x).text == sine
    helped = CodeReader(own.program, set(), dialect=own.dialect, names={}, helpers={"sinc": "my_sinc"})
    assert helped.made("sinc", x).text == "my_sinc(a)"
    assert [own.is_name(CodePiece(t)) for t in ("a", "-a", "a + b", "2", "--a")] == [True, True, False, False, False]


@pytest.mark.parametrize(
    "number",
    [
        Rational(1, 3),
        pi,
        40 * pi,
        sqrt(2),
        Rational(10**25, 3),
        Rational(1, 10**300),
        -Rational(2, 7),
        Integer(2) ** 60 + 1,
    ],
)
def test_a_number_is_the_double_with_none_nearer(number: Expr) -> None:
    own = nearest_double(number)
    off = abs(Rational(own) - number)
    for other in (nextafter(own, inf), nextafter(own, -inf)):
        assert bool((off <= abs(Rational(other) - number)).simplify()) or off.evalf(50) <= abs(
            Rational(other) - number
        ).evalf(50)


def test_what_cancels_is_zero_and_what_is_too_large_is_refused() -> None:
    hidden = sqrt(2) + sqrt(3) - sqrt(5 + 2 * sqrt(6))
    assert nearest_double(hidden) == 0.0
    assert nearest_double(hidden + Rational(1, 10**20)) == 1e-20
    assert nearest_double(Integer(0)) == 0.0
    with pytest.raises(SceneError, match="is too large for a double, whose largest is 1.8e308"):
        nearest_double(Integer(10) ** 309)


@pytest.mark.parametrize("language", [Language.NUMPY, Language.OCTAVE, Language.JULIA])
def test_a_power_of_a_power_stands_in_brackets_on_whichever_side_it_is(language: Language) -> None:
    """NumPy and Julia take the right one first where there are none, Octave the left one."""
    x, y, z = symbols("x y z")
    for form, shown in (((x**y) ** z, "(x^y)^z"), (x ** (y**z), "x^(y^z)")):
        write = Writer((x, y, z))
        program = write.program({"r": write.expression(form)})
        found = (
            CodeReader(program, set(), dialect=DIALECTS[language], names={x: "x", y: "y", z: "z"}).results()["r"].text
        )
        assert found.replace(".^", "^").replace("**", "^") == shown


# Names


@pytest.mark.parametrize("language", list(Language))
def test_every_name_is_one_that_the_language_allows_and_none_is_taken_twice(language: Language) -> None:
    pick = random.Random(4)
    reserved = sorted(RESERVED[language])
    for _ in range(40):
        names = list(
            {"".join(pick.choice("abλ_ 1-é中") for _ in range(pick.randint(1, 6))) for _ in range(6)}
            | set(pick.sample(reserved, 3))
            | {"x" * pick.choice([60, 61, 70])}
        )
        taken = {"b", "a_1"}
        found = identifiers(names, language, taken)
        assert list(found) == names
        assert len(set(found.values())) == len(names)
        for name, own in found.items():
            assert re.fullmatch("[A-Za-z][A-Za-z0-9_]*", own, re.ASCII), own
            assert own not in RESERVED[language] | taken
            assert len(own) <= 63
            can_stay = (
                re.fullmatch("[A-Za-z][A-Za-z0-9_]*", name, re.ASCII)
                and name not in RESERVED[language] | taken
                and len(name) <= 60
            )
            assert (own == name) == bool(can_stay), (name, own)
    assert not any(keyword.iskeyword(x) for x in identifiers(list(keyword.kwlist), Language.NUMPY).values())
    assert identifiers(["_x", "1a", "中"], language) == {"_x": "p_x", "1a": "p_1a", "中": "p_u4E2D"}
    assert function_name("x" * 60, language) == "x" * 60
    for wrong in ("x" * 61, reserved[0], "1x", "a b", ""):
        with pytest.raises(SceneError):
            function_name(wrong, language)
    assert Language.of(language) is Language.of(language.name) is Language.of(language.name.lower()) is language
    assert comment("what? why?? no???") == "what? why? ? no? ? ?"
    for unknown in ("fortran", 3):
        with pytest.raises(SceneError, match="is none of numpy, c, octave, julia, javascript"):
            Language.of(unknown)  # type: ignore[arg-type]
