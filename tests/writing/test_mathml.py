"""The MathML is well formed, says what a page or a screen reader needs, and means what it stands for."""

from __future__ import annotations

from xml.etree import ElementTree

import pytest
from formulas import EXPRESSIONS, are_identical, by_key, closed_forms, value_at
from hypothesis import given
from marks import QUICK_SCENES, WRITTEN_OUT, examples, often
from mathreader import SPACE, expression
from sympy import (
    Abs,
    Eq,
    Float,
    Function,
    I,
    ImmutableMatrix,
    Integer,
    Rational,
    Symbol,
    acos,
    asin,
    atan,
    cos,
    exp,
    pi,
    sqrt,
)

import haptisym as hs
from haptisym.kernel.errors import SceneError
from haptisym.kernel.rings import X, omega, s
from haptisym.writing.boxes import Relation
from haptisym.writing.layout import QUANTITIES, equation
from haptisym.writing.mathml import markup, mathml

m, b, k, omega_n, zeta, tau = hs.symbols("m b k omega_n zeta tau")


FENCED_K = '<mrow><mo stretchy="false">(</mo><mi>k</mi><mo stretchy="false">)</mo></mrow>'


def inside(text: str) -> str:
    """What stands in the ``math`` element."""
    return text.partition(">")[2].removesuffix("</math>")


@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        (Integer(0), "<mn>0</mn>"),
        (Rational(9, 5), "<mn>1.8</mn>"),
        (Rational(-1, 3), '<mrow><mo>−</mo><mstyle displaystyle="false"><mfrac><mn>1</mn><mn>3</mn></mfrac></mstyle></mrow>'),
        (Float("7.7e-7", 6), "<mrow><mn>7.7</mn><mo>×</mo><msup><mn>10</mn><mrow><mo>−</mo><mn>7</mn></mrow></msup></mrow>"),
        (k, "<mi>k</mi>"),
        (2 * k, "<mrow><mn>2</mn><mo>&#x2062;</mo><mi>k</mi></mrow>"),
        (k - m, "<mrow><mi>k</mi><mo>−</mo><mi>m</mi></mrow>"),
        (omega_n**2, "<msubsup><mi>ω</mi><mi>n</mi><mn>2</mn></msubsup>"),
        (sqrt(k / m), "<msqrt><mfrac><mi>k</mi><mi>m</mi></mfrac></msqrt>"),
        (k ** Rational(1, 3), '<msup><mi>k</mi><mrow><mn>1</mn><mo lspace="0em" rspace="0em">/</mo><mn>3</mn></mrow></msup>'),
        (exp(-s * tau), "<msup><mi>e</mi><mrow><mo>−</mo><mrow><mi>τ</mi><mo>&#x2062;</mo><mi>s</mi></mrow></mrow></msup>"),
        (asin(k), f'<mrow><mi mathvariant="normal">arcsin</mi><mo>&#x2061;</mo>{FENCED_K}</mrow>'),
        (Abs(Symbol("z")), '<mrow><mo stretchy="false">|</mo><mi>z</mi><mo stretchy="false">|</mo></mrow>'),
        (I * k, "<mrow><mi>k</mi><mo>&#x2062;</mo><mi>j</mi></mrow>"),
        (2 * 3 ** Rational(1, 3), None),
    ],
)  # fmt: skip
def test_a_formula_is_marked_up_as_a_page_needs_it(expression, expected):
    text = inside(mathml(expression))
    if expected is None:
        assert text.startswith("<mrow><mn>2</mn><mo>⋅</mo><msup><mn>3</mn>")
    else:
        assert text == expected


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("omega_n", "<msub><mi>ω</mi><mi>n</mi></msub>"),
        ("H_env", '<msub><mi>H</mi><mi mathvariant="normal">env</mi></msub>'),
        ("k_1", "<msub><mi>k</mi><mn>1</mn></msub>"),
        ("b12", "<msub><mi>b</mi><mn>12</mn></msub>"),
        ("Bs", "<msub><mi>B</mi><mi>s</mi></msub>"),
        ("lambda", "<mi>λ</mi>"),
        ("Delta", '<mi mathvariant="normal">Δ</mi>'),
        ("mass", '<mi mathvariant="normal">mass</mi>'),
        ("zeta_force_sensor", '<msub><mi>ζ</mi><mi mathvariant="normal">force&#xA0;sensor</mi></msub>'),
        (
            "omega_n_filter",
            '<msub><mi>ω</mi><mrow><mi>n</mi><mo rspace="0em">,</mo><mi mathvariant="normal">filter</mi></mrow></msub>',
        ),
        ("force_friction", '<msub><mi>F</mi><mi mathvariant="normal">friction</mi></msub>'),
        ("amplitude", "<mi>A</mi>"),
    ],
)
def test_a_name_gets_greek_letters_and_upright_words(name, expected):
    assert inside(mathml(Symbol(name))) == expected


@pytest.mark.parametrize("name", ["<script>&\"'", "a\x00\x0b\ud800b", "]]>", "\uffff"])
def test_no_character_of_a_name_breaks_the_page(name):
    root = ElementTree.fromstring(mathml(Symbol(name) + 1))
    assert {x.tag.removeprefix(SPACE) for x in root.iter()} <= {"math", "mrow", "mi", "mn", "mo", "msub"}


def test_the_math_element_is_complete_and_says_whether_it_stands_alone():
    alone, in_line = (ElementTree.fromstring(mathml(k, display=x)) for x in (True, False))
    assert (alone.tag, alone.get("display"), in_line.get("display")) == (f"{SPACE}math", "block", "inline")


def test_fences_grow_with_what_they_hold():
    flat, nested, tall = k * (m + b), k * (m + b * (s + k)), k * (m + 1 / s)
    assert [mathml(x).count('stretchy="false"') for x in (flat, nested, tall)] == [2, 2, 0]
    assert 'minsize="1.2em"' in mathml(nested)


def test_a_matrix_a_relation_and_what_has_no_box_are_set_too():
    assert mathml(ImmutableMatrix([[1, 0], [k, 1]])).count("<mtd>") == 4
    assert "<mo>=</mo>" in mathml(Eq(k, m))
    assert "<mo>&lt;</mo>" in mathml(Symbol("x") < 1)
    assert '<mi mathvariant="normal">gain</mi><mo>&#x2061;</mo>' in mathml(Function("gain")(s))


def test_other_things_have_no_mathml():
    with pytest.raises(TypeError, match="no MathML for str"):
        mathml("k")


# What is marked up is what it stands for.


@pytest.mark.dear("fu2019")
@pytest.mark.few("fu2019", "delayed-spring")
@pytest.mark.parametrize("name", often(WRITTEN_OUT, QUICK_SCENES.__contains__))
def test_every_closed_form_of_a_shipped_scene_reads_back_exactly(name):
    for form in closed_forms(name):
        assert are_identical(expression(mathml(form), by_key(form)), form), form


@pytest.mark.slow
@given(EXPRESSIONS)
@examples(300)
def test_any_formula_reads_back_with_exactly_the_same_value(form):
    read = expression(mathml(form), by_key(form))
    assert value_at(read) == value_at(form)


@pytest.mark.parametrize(
    "form",
    [
        cos(omega * tau) ** 2,
        acos(k / m) + atan(zeta) ** 3,
        k * Abs(s - 1) ** tau,
        X * (k + b * I) * pi**2,
        s ** Rational(2, 7),
    ],
)
def test_powers_functions_and_phases_read_back_exactly(form):
    assert are_identical(expression(mathml(form), by_key(form)), form)


# Equations.


@pytest.mark.parametrize("name", QUANTITIES)
def test_every_quantity_can_stand_on_the_left(name):
    root = ElementTree.fromstring(mathml(equation(name, k + s, explained=True), display=True))
    [row] = root
    operators = [x.text for x in row if x.tag == f"{SPACE}mo"]
    assert operators
    assert set(operators) == {"="}
    assert row[-1].tag == f"{SPACE}mrow"


def test_an_equation_names_what_its_left_side_is():
    H = '<msub><mi>H</mi><mi mathvariant="normal">perc</mi></msub>'
    assert markup(equation("H_perc", k)).startswith(f"<mrow><mrow>{H}<mo>&#x2061;</mo>")
    change = markup(equation("Im dH", k, relation="≈"))
    assert change.startswith('<mrow><mrow><mi mathvariant="normal">Im</mi>')
    assert '<mi mathvariant="normal">Δ</mi>' in change
    assert change.endswith("<mo>≈</mo><mi>k</mi></mrow>")


def test_a_ratio_is_explained_by_what_it_compares():
    explained, short = equation("r_r", k, explained=True), equation("r_r", k)
    assert isinstance(explained, Relation)
    assert (len(explained.sides), len(short.sides)) == (3, 2)
    assert markup(explained.sides[1]).startswith("<mrow><mo>|</mo><mfrac>")


def test_a_name_that_is_no_quantity_is_an_error_that_lists_them():
    with pytest.raises(SceneError, match=r"'Re H'.*Re dH.*r_i"):
        equation("Re H", k)
