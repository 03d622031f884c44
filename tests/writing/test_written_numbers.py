"""Numbers and names as they are written: the same for a number and its negative, in code, in text and in LaTeX."""

from __future__ import annotations

import random
import re

import pytest
from plainreader import expression
from sympy import Expr, Integer, Rational, Symbol, pi, sqrt

import haptisym as hs
from haptisym.kernel.errors import SceneError
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.rings import PolynomialRing
from haptisym.kernel.symbols import omega, s
from haptisym.pages.words import unlike
from haptisym.programs.program import Writer
from haptisym.writing.code.expressions import DIALECTS, CodeReader, nearest_double
from haptisym.writing.code.names import Language, comment, function_name, identifiers
from haptisym.writing.formula import readable
from haptisym.writing.mathtext import plain
from haptisym.writing.numerals import approximate, is_short
from haptisym.writing.texlines import broken, width

WHOLE = [0, 1, 7, 10**6, 10**15 - 1, 10**15, 2**53, 2**53 + 1, 10**20, 10**300]
OTHERS = [Rational(1, 3), Rational(1, 10), Rational(10**25, 3), Rational(1, 10**200), Rational(123456789, 1000)]


def in_code(number: Expr, language: Language) -> str:
    """How a language writes a number."""
    write = Writer(())
    program = write.program({"y": write.expression(number)})
    return CodeReader(program, set(), dialect=DIALECTS[language], names={}).results()["y"].text


@pytest.mark.slow
@pytest.mark.parametrize("language", Language, ids=lambda x: x.name)
@pytest.mark.parametrize("sign", [1, -1])
def test_a_number_in_code_reads_back_as_the_double_nearest_to_it(language: Language, sign: int) -> None:
    """Whole numbers beyond all doubles' digits have a point or an exponent: languages read others as machine integers."""
    for value in [*map(Integer, WHOLE), *OTHERS]:
        text = in_code(sign * value, language)
        assert float(text) == float(sign * value), text
        if len(text.lstrip("-")) > 15:
            assert re.search(r"[.e]", text), text


@pytest.mark.parametrize("language", Language, ids=lambda x: x.name)
def test_pi_alone_keeps_its_name_in_code_and_with_a_number_it_is_one_double(language: Language) -> None:
    assert "pi" in in_code(pi, language).lower()
    for number in (3 * pi, pi * sqrt(2)):
        assert float(in_code(number, language)) == nearest_double(number)


@pytest.mark.parametrize("language", Language, ids=lambda x: x.name)
def test_greek_letters_are_spelt_in_code_small_as_small_and_capital_as_capital(language: Language) -> None:
    found = identifiers(["ω", "Ω", "Λ", "ζ_n"], language)
    assert found == {"ω": "omega", "Ω": "Omega", "Λ": "Lambda", "ζ_n": "zeta_n"}


def test_names_that_would_be_the_same_are_numbered_on() -> None:
    found = identifiers(["a b", "a.b", "a-b", "a_b", "a+b"], Language.C)
    assert found["a_b"] == "a_b"
    assert sorted(found.values()) == ["a_b", "a_b_", "a_b_2", "a_b_3", "a_b_4"]


@pytest.mark.parametrize("name", ["1f", "", "f-g", "é", "_f", "f" * 200, "int", "f\n"])
def test_what_cannot_name_a_function_in_c_is_refused_by_its_name(name: str) -> None:
    with pytest.raises(SceneError, match="cannot name a function in C"):
        function_name(name, Language.C)


def test_any_text_is_one_harmless_line_of_comment() -> None:
    pick = random.Random(3)
    for _ in range(300):
        text = "".join(pick.choice('*/\\"?\n\t x\u2028') for _ in range(12))
        line = comment(text)
        assert not any(mark in line for mark in ("*/", "/*", '"', "\\", "??", "\n"))


def test_a_star_before_a_backslash_does_not_close_a_comment() -> None:
    """A backslash becomes a slash; the star before it must not make it the end of a comment in C."""
    assert comment("ends *\\ int evil;") == "ends * / int evil;"


@pytest.mark.parametrize(
    "value", [Rational(68, 15), Rational(12345678), Rational(408233133, 200000001), Integer(10) ** 9]
)
def test_a_negative_number_is_as_short_as_its_positive(value: Rational) -> None:
    assert is_short(-value) == is_short(value)


def test_a_sign_is_no_digit_of_a_long_number() -> None:
    digits = "123456789" * 3
    for n in range(1, 27):
        for value in (Integer(digits[:n]), Rational(int(digits[:n]), 7), Rational(int(digits[:n]), 10**n)):
            assert is_short(-value) == is_short(value), value


@pytest.mark.parametrize("number", [12, 999999, 1000000, 123456789, 10**12])
def test_a_formula_is_rounded_alike_with_either_sign(number: int) -> None:
    """One number of it is long, so that all are written to six digits; whole ones of no more stay whole."""
    formula = number * s + Rational(10**12 + 1, 7)
    assert approximate(-formula) == -approximate(formula)
    short = number < 10**6
    [slope] = [x for x in approximate(-formula).coeff(s).atoms() if x.is_number]
    assert slope.is_Integer == short


@pytest.mark.parametrize("number", [-12, 999999, -999999, 1234567, -123456789])
def test_a_quotient_shows_whole_numbers_of_at_most_six_digits_as_they_are(number: int) -> None:
    ring = PolynomialRing(s)
    shown, is_rounded = readable(ring.convert((number * s + Rational(10**12 + 1, 7)) / (s + 1)), s)
    assert is_rounded
    assert (f"{abs(number)} s" in plain(shown)) == (abs(number) < 10**6)


def test_a_quotient_that_is_rounded_has_its_delays_rounded_too_and_an_exact_one_none() -> None:
    late = hs.distort(hs.environments.kelvin_voigt(100, 2), hs.effects.delay("0.019093053221796195 s")).perc
    (exact, _), (shown, _) = readable(late, s), readable(late, s, 4)
    assert "exp(-0.019093053221796195 s)" in plain(exact)
    assert "exp(-0.01909 s)" in plain(shown)


def test_ends_of_a_band_that_would_look_alike_are_told_apart() -> None:
    """A resonance of damping 1e-9: bands of step 2 went from 1000000000000 to 1000000000000 rad/s."""
    near = [ExactNumber(x) for x in (Rational(1), Rational(10**9 + 1, 10**9), Rational(2), Rational(2))]
    assert [x.digits for x in unlike(near)] == ["1", "1.000000001", "2", "2"]
    assert [x.digits for x in unlike(near[1:3])] == ["1", "2"]


def test_a_formula_is_broken_before_a_sign_rather_than_between_factors() -> None:
    """Each line starts with a sign where it can; inside parentheses only where nothing else will do."""
    terms = [rf"{n} \omega^{{{n}}} \left(a + b\right) c_{n}" for n in range(2, 9)]
    text = " + ".join(terms)
    lines = broken(text, 20)
    assert len(lines) > 2
    rest = [line.removeprefix("{} ") for line in lines]
    assert " ".join(rest) == text
    assert all(line.startswith("+") for line in rest[1:])
    assert all(width(line) <= 22 for line in lines)


def test_frequencies_and_s_come_first_where_terms_are_ordered() -> None:
    b, c = Symbol("b"), Symbol("c")
    assert plain(b * omega + c * omega + b * omega**2 + 1) == "b omega^2 + (b + c) omega + 1"


@pytest.mark.parametrize("value", [Rational(323, 250) ** 9, Rational(3, 10) ** 40, Rational(10**35 + 1, 2)])
def test_a_decimal_of_more_than_28_digits_is_written_with_all_of_them(value: Rational) -> None:
    """It had been rounded, without a word."""
    assert expression(plain(value), {}) == value
