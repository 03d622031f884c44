"""A formula is laid out once: LaTeX, plain text and MathML agree on order and signs, and plain text reads back too."""

from __future__ import annotations

import re

import pytest
import sympy as sp
from formulas import EXPRESSIONS, are_identical, closed_forms, value_at
from hypothesis import given
from marks import QUICK_SCENES, WRITTEN_OUT, examples, often
from plainreader import expression
from sympy import Abs, Float, I, Integer, Rational, Symbol, acos, asin, atan, cos, exp, pi, sqrt
from sympy.printing.str import StrPrinter

import haptisym as hs
from haptisym.kernel.rings import PolynomialRing
from haptisym.kernel.symbols import omega, s
from haptisym.writing.boxes import Absolute, Fraction, Name, Numeral, Power, Product, Root, Sum
from haptisym.writing.equations import QUANTITIES, equation
from haptisym.writing.formula import readable
from haptisym.writing.layout import layout
from haptisym.writing.mathml import mathml
from haptisym.writing.mathtext import plain, text
from haptisym.writing.names import CAPITALS, GREEK, greek, letter
from haptisym.writing.numerals import is_short, rounded
from haptisym.writing.texprinter import formula, tex

m, b, k, omega_n, zeta, omega_c, tau, J = hs.symbols("m b k omega_n zeta omega_c tau J")


@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        (m * s**2 + b * s + k, "m s^2 + b s + k"),
        (k - m * omega**2, "k - m omega^2"),
        (b * s + J * s + k, "(b + J) s + k"),
        (-(m * omega**2 + k) / omega, "-(m omega^2 + k)/omega"),
        (Rational(9, 5) * s**2 + Rational(1, 3) * s, "1.8 s^2 + (1/3) s"),
        (Rational(2, 7), "2/7"),
        (-Rational(2, 7), "-2/7"),
        (k / (2 * m), "k/(2 m)"),
        (k / (m * (s + 1)), "k/(m (s + 1))"),
        (sqrt(k / m), "sqrt(k/m)"),
        (100 * s ** Rational(1, 5), "100 s^0.2"),
        (s ** Rational(1, 3), "s^(1/3)"),
        (s ** (2 * tau), "s^(2 tau)"),
        (2 * 3 ** Rational(1, 3) * k, "2*3^(1/3) k"),
        (exp(-s * tau) * k, "k exp(-tau s)"),
        (cos(omega * tau) ** 2, "cos(tau omega)^2"),
        (Abs(k - m * omega**2) / k, "|k - m omega^2|/k"),
        (Abs(k - 2 * Abs(s - 1)), "abs(k - 2 |s - 1|)"),
        (asin(k), "asin(k)"),
        (I * k * omega, "k omega j"),
        (Float("7.74037e-7", 6) * s, "7.74037e-7 s"),
        (Float("2805780", 6), "2805780"),
        (Integer(0), "0"),
        (sp.oo, "∞"),
        (-sp.oo, "-∞"),
        (sp.Lt(k, m), "k < m"),
        (sp.ImmutableMatrix([[k, 0], [1, k]]), "[[k, 0], [1, k]]"),
    ],
)
def test_plain_text_is_written_as_a_person_types_it(expression, expected):
    assert plain(expression) == expected


@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        (asin(k / m), r"\arcsin\left( \frac{k}{m} \right)"),
        (acos(k) + atan(zeta) ** 2, r"\arccos(k) + \arctan^{2}(\zeta)"),
        (sp.log(k), r"\ln(k)"),
        (sp.asinh(k), r"\operatorname{arsinh}(k)"),
        (Symbol("force") / Symbol("amplitude"), r"\frac{F}{A}"),
        (Symbol("force_stick_friction"), r"F_{\mathrm{stick\,friction}}"),
        ((-2) ** Rational(1, 3), r"(-2)^{1/3}"),
        (sp.oo, r"\infty"),
        (sp.Ge(k, m), r"k \ge m"),
        (sp.ImmutableMatrix([[k, 0], [1, k]]), r"\begin{pmatrix} k & 0 \\ 1 & k \end{pmatrix}"),
    ],
)
def test_what_a_person_would_not_guess_of_sympys_latex(expression, expected):
    assert formula(expression) == expected


def test_the_tree_is_what_a_person_would_draw():
    assert layout((k - m * omega**2) / sqrt(b)) == Fraction(
        Sum(((1, layout(k)), (-1, Product((layout(m), Power(layout(omega), Numeral("2"))))))), Root(layout(b))
    )
    assert layout(Abs(-k - s)) == Absolute(Sum(((1, layout(s)), (1, layout(k)))))
    assert isinstance(layout(omega_n), Name)


_NO_SIGN = re.compile(r"e-\d+|10\^\{-\d+\}|<mn>10</mn><mrow><mo>−</mo>|<[^>]*>")
"""What holds a minus that is no sign of a term: powers of ten, and attributes."""


def signs(written: str) -> str:
    """The signs of a formula in the order in which they are written."""
    return "".join(re.findall("[-+]", _NO_SIGN.sub("", written).replace("−", "-")))


@given(EXPRESSIONS)
@examples(200)
def test_the_three_outputs_agree_on_every_sign(form):
    assert signs(plain(form)) == signs(mathml(form)) == signs(formula(form))


@given(EXPRESSIONS)
@examples(300)
def test_any_plain_formula_reads_back_with_exactly_the_same_value(form):
    assert value_at(expression(plain(form), {x.name: x for x in form.free_symbols})) == value_at(form)


@pytest.mark.few("fu2019", "delayed-spring", "sidestick", "undamped-resonance")
@pytest.mark.parametrize("name", often(WRITTEN_OUT, QUICK_SCENES.__contains__))
def test_every_closed_form_of_a_shipped_scene_reads_back_exactly_from_plain_text(name):
    for form in closed_forms(name):
        assert are_identical(expression(plain(form), {x.name: x for x in form.free_symbols}), form), form


def test_the_readers_would_notice_a_wrong_sign_or_power():
    form = omega_n**2 * (m * s**2 + b * s + k) / (s**2 + 2 * zeta * omega_n * s + omega_n**2)
    known = {x.name: x for x in form.free_symbols}
    right = plain(form)
    assert are_identical(expression(right, known), form)
    for old, new in (("+ k", "- k"), ("s^2 + b", "s^3 + b"), ("2 zeta", "3 zeta"), ("b s", "b omega_n")):
        assert old in right
        assert not are_identical(expression(right.replace(old, new), known), form)


def test_laying_out_changes_nothing_for_others():
    before = str(k - m * omega**2), sp.latex(k - m * omega**2), str(StrPrinter._default_settings)
    plain(k - m * omega**2)
    assert (str(k - m * omega**2), sp.latex(k - m * omega**2), str(StrPrinter._default_settings)) == before


# Numbers and names.


def test_numbers_are_added_before_they_are_rounded():
    """-50000 pi^2 + 50000 sqrt(5) pi^2 is 609975.09...; its parts, rounded on their own, make 609980."""
    ring = PolynomialRing(s, [k])
    form, is_rounded = readable(ring.convert((Rational(1, 3) + 10**9 * pi) * k), s)
    assert is_rounded
    assert plain(form) == "3.14159e9 k"
    assert rounded(50000 * pi**2 * (sqrt(5) - 1)) == Float("609975", 6)


def test_a_number_is_short_if_it_can_be_read_at_a_glance():
    assert [is_short(Rational(x)) for x in ("1234/5678", "12345/5678", "123456789012", "1e-9", "1.5e-9")] == [
        True, False, True, True, False,
    ]  # fmt: skip


def test_every_greek_letter_has_a_name_and_back():
    assert [greek(letter(name)) for name in (*GREEK, *CAPITALS)] == [*GREEK, *CAPITALS]


# Names of quantities.


@pytest.mark.parametrize("name", QUANTITIES)
def test_every_quantity_is_set_in_latex_and_plain_text(name):
    e = equation(name, k + s)
    assert tex(e).endswith(" = s + k")
    title = text(e).removesuffix(" = s + k")
    assert title.removesuffix("(s)").replace("Delta_jnd", "jnd") == name


def test_a_rounded_value_says_so_in_each_output():
    e = equation("Re dH", k, relation="≈")
    assert (text(e), tex(e)) == ("Re dH ~ k", r"\Re \Delta H(\omega j) \approx k")
