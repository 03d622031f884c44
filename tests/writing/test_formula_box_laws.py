"""Each kind of box as a line of text, in LaTeX and in MathML: brackets, dots, fences, names and characters."""

from __future__ import annotations

import random
import re
import unicodedata
from xml.etree import ElementTree

import pytest

from haptisym.writing.boxes import (
    Absolute,
    Applied,
    Box,
    Equation,
    Exponential,
    Fenced,
    Fraction,
    Grid,
    Name,
    Numeral,
    Operator,
    Power,
    Prefixed,
    Product,
    Ratio,
    Root,
    Sum,
    Titled,
    Word,
    needs_dot,
)
from haptisym.writing.mathml import markup
from haptisym.writing.mathtext import text
from haptisym.writing.names import CAPITALS, GREEK, greek, letter, named
from haptisym.writing.texnames import escape, set_name, spaced
from haptisym.writing.texprinter import tex

a, b, c = (named(x) for x in "abc")
TWO, HALF = Numeral("2"), Ratio(1, 2)
SUM, QUOTIENT, PRODUCT, POWER = Sum(((1, a), (-1, b))), Fraction(a, b), Product((a, b)), Power(a, TWO)
RE = Prefixed(Operator("Re"), named("H"))


@pytest.mark.parametrize(
    ("box", "plain", "latex"),
    [
        (Numeral("1.5", -7), "1.5e-7", r"1.5 \times 10^{-7}"), (Numeral("1", 9), "1e9", "10^{9}"), (TWO, "2", "2"), (HALF, "1/2", r"\tfrac{1}{2}"),
        (SUM, "a - b", "a - b"), (Sum(((-1, a), (1, b))), "-a + b", "-a + b"), (Sum(((-1, a),)), "-a", "-a"),
        (PRODUCT, "a b", "a b"), (Product((TWO, TWO)), "2*2", r"2 \cdot 2"), (Product((HALF, TWO, a)), "(1/2)*2 a", r"\tfrac{1}{2} \cdot 2 a"),
        (Product((TWO, Power(TWO, a))), "2*2^a", r"2 \cdot 2^{a}"), (Product((a, TWO)), "a 2", "a 2"), (Product((RE, a)), "Re H*a", r"\Re H \cdot a"), (Product((a, RE)), "a Re H", r"a \, \Re H"),
        (Product((a, QUOTIENT)), "a (a/b)", r"a \frac{a}{b}"), (Product((QUOTIENT, a)), "(a/b) a", r"\frac{a}{b} a"),
        (QUOTIENT, "a/b", r"\frac{a}{b}"), (Fraction(SUM, PRODUCT), "(a - b)/(a b)", r"\frac{a - b}{a b}"), (Fraction(PRODUCT, SUM), "a b/(a - b)", r"\frac{a b}{a - b}"),
        (Fraction(QUOTIENT, HALF), "(a/b)/(1/2)", r"\frac{\frac{a}{b}}{\tfrac{1}{2}}"), (Fraction(HALF, QUOTIENT), "(1/2)/(a/b)", r"\frac{\tfrac{1}{2}}{\frac{a}{b}}"),
        (POWER, "a^2", "a^{2}"), (Power(a, SUM), "a^(a - b)", "a^{a - b}"), (Power(a, PRODUCT), "a^(a b)", "a^{a b}"), (Power(a, QUOTIENT), "a^(a/b)", r"a^{\frac{a}{b}}"),
        (Power(a, HALF), "a^(1/2)", "a^{1/2}"), (Power(a, POWER), "a^(a^2)", "a^{a^{2}}"), (Power(HALF, a), "(1/2)^a", r"\tfrac{1}{2}^{a}"),
        (Power(Applied(Operator("cos"), (a,)), TWO), "cos(a)^2", r"\cos^{2}(a)"), (Root(SUM), "sqrt(a - b)", r"\sqrt{a - b}"), (Exponential(SUM), "exp(a - b)", "e^{a - b}"),
        (Applied(Operator("arcsin"), (a, b)), "asin(a, b)", r"\arcsin(a, b)"), (Applied(named("f"), (QUOTIENT,)), "f(a/b)", r"f\left( \frac{a}{b} \right)"),
        (Applied(Operator("arsinh"), (a,)), "asinh(a)", r"\operatorname{arsinh}(a)"), (Prefixed(Operator("Im"), SUM), "Im (a - b)", r"\Im a - b"), (Prefixed(Operator("Im"), QUOTIENT), "Im (a/b)", r"\Im \frac{a}{b}"),
        (Fenced(a), "(a)", "(a)"), (Fenced(Fenced(a)), "((a))", r"\bigl( (a) \bigr)"), (Fenced(Fenced(Fenced(a))), "(((a)))", r"\Bigl( \bigl( (a) \bigr) \Bigr)"),
        (Fenced(Root(a)), "(sqrt(a))", r"\left( \sqrt{a} \right)"), (Absolute(a), "|a|", r"\left| a \right|"), (Absolute(Product((a, Absolute(b)))), "abs(a |b|)", r"\left| a \left| b \right| \right|"),
        (Grid(((a, b), (c, TWO))), "[[a, b], [c, 2]]", r"\begin{pmatrix} a & b \\ c & 2 \end{pmatrix}"), (Titled("dH", a), "dH", "a"),
        (Equation((a, b, c), ("=", "≈")), "a = b ~ c", r"a = b \approx c"), (Equation((a, b), ("≤",)), "a <= b", r"a \le b"), (Equation((a, b), ("≠",)), "a != b", r"a \ne b"), (Equation((a, b), ("<",)), "a < b", "a < b"),
    ],
)  # fmt: skip
def test_a_box_is_written_as_it_is_read(box: Box, plain: str, latex: str) -> None:
    assert text(box) == plain
    assert tex(box) == latex


@pytest.mark.parametrize(
    ("box", "inside"),
    [
        (Numeral("1.5", -7), "<mrow><mn>1.5</mn><mo>×</mo><msup><mn>10</mn><mrow><mo>−</mo><mn>7</mn></mrow></msup></mrow>"), (Numeral("1", 9), "<msup><mn>10</mn><mn>9</mn></msup>"),
        (Sum(((-1, a), (1, b))), "<mrow><mo>−</mo><mi>a</mi><mo>+</mo><mi>b</mi></mrow>"), (Product((TWO, TWO)), "<mrow><mn>2</mn><mo>⋅</mo><mn>2</mn></mrow>"),
        (Product((TWO, a)), "<mrow><mn>2</mn><mo>&#x2062;</mo><mi>a</mi></mrow>"), (Equation((a, b), ("<",)), "<mrow><mi>a</mi><mo>&lt;</mo><mi>b</mi></mrow>"),
        (Titled("x", a), "<mi>a</mi>"), (Root(a), "<msqrt><mi>a</mi></msqrt>"), (QUOTIENT, "<mfrac><mi>a</mi><mi>b</mi></mfrac>"),
        (Applied(a, (b, c)), '<mrow><mi>a</mi><mo>&#x2061;</mo><mrow><mo stretchy="false">(</mo><mi>b</mi><mo>,</mo><mi>c</mi><mo stretchy="false">)</mo></mrow></mrow>'),
        (Prefixed(named("d"), a), "<mrow><mi>d</mi><mo>&#x2061;</mo><mi>a</mi></mrow>"),
        (Prefixed(Operator("Re"), a), '<mrow><mi mathvariant="normal">Re</mi><mo>&#x2061;</mo><mspace width="0.17em"/><mi>a</mi></mrow>'),
    ],
)  # fmt: skip
def test_a_box_is_marked_up_as_what_it_is(box: Box, inside: str) -> None:
    assert markup(box) == inside


def test_fences_grow_by_what_they_hold_and_end_at_the_third() -> None:
    sizes = []
    box: Box = a
    for _ in range(4):
        box = Fenced(box)
        root = ElementTree.fromstring(markup(box))
        sizes.append(root[0].get("minsize") or root[0].get("stretchy"))
    assert sizes == ["false", "1.2em", "1.8em", "1.8em"]
    for tall in (QUOTIENT, Root(a), Grid(((a,),))):
        assert markup(Fenced(tall)).startswith("<mrow><mo>(</mo>")
        assert markup(Absolute(tall)).startswith("<mrow><mo>|</mo>")


def test_two_numbers_side_by_side_and_what_follows_an_operand_need_a_sign_between_them() -> None:
    numbers: tuple[Box, ...] = (TWO, HALF, Power(TWO, a), Power(HALF, a))
    others: tuple[Box, ...] = (a, SUM, QUOTIENT, POWER, Fenced(TWO), Root(TWO), RE)
    for left in (*numbers, *others):
        for right in (*numbers, *others):
            needed = left is RE or (isinstance(left, Numeral | Ratio) and right in numbers)
            assert needs_dot(left, right) == needed, (left, right)


# Names and characters


def test_names_have_their_parts_in_every_language() -> None:
    name = Name(
        "x",
        Word("omega", upright=False),
        (Word("n", upright=False), Word("my wall", upright=True), Word("2", upright=False)),
    )
    assert set_name(name) == r"\omega_{n,\mathrm{my\,wall},2}"
    assert text(name) == "x"
    told = markup(name)
    assert told.startswith("<msub><mi>ω</mi><mrow><mi>n</mi>")
    assert told.count('<mo rspace="0em">,</mo>') == 2
    assert "my&#xA0;wall" in told
    assert '<mi mathvariant="normal">my' in told
    assert "<mn>2</mn>" in told
    for below, shown in (
        (Word("n", upright=False), "k_n"),
        (Word("12", upright=False), "k_{12}"),
        (Word("omega", upright=False), r"k_\omega"),
        (Word("ab", upright=True), r"k_{\mathrm{ab}}"),
    ):
        assert set_name(Name("k", Word("k", upright=False), (below,))) == shown
    assert set_name(Name("omicron", Word("omicron", upright=False))) == "o"
    assert set_name(named("∞")) == r"\infty"
    for head in (*GREEK, *CAPITALS):
        assert set_name(named(head)) in (rf"\{head}", "o")
        assert letter(head) in markup(named(head))
        assert greek(letter(head)) == head
    assert [letter(x) for x in ("wall", "Alpha", "")] == ["wall", "Alpha", ""]
    assert [greek(x) for x in ("a", "Α", "ς", "1")] == ["", "Alpha", "", ""]


def test_long_words_get_places_to_break_and_short_ones_none() -> None:
    mark = r"\allowbreak{}"
    assert escape("x" * 20) == "x" * 20
    assert escape("x" * 24) == "x" * 24
    assert escape("x" * 25) == "x" * 5 + mark + "x" * 20
    assert escape("1" * 21).count(mark) == 3
    assert escape("a/b" + "c" * 18).startswith("a/" + mark)
    assert escape("a_b" + "c" * 18).startswith(r"a\_" + mark)
    assert escape("a/b") == "a/b"
    pick = random.Random(4)
    for _ in range(50):
        word = "".join(pick.choice("abc123") for _ in range(pick.randint(21, 60)))
        assert escape(word).replace(mark, "") == word


def test_a_fraction_of_one_character_stays_the_number_that_it_is() -> None:
    """The half of 2½ had become 12, and the whole of it 212."""
    seen = 0
    for c in map(chr, range(0x3000)):
        if "FRACTION" in unicodedata.decomposition(c).upper() and "NUMERATOR" not in unicodedata.name(c):
            found = re.fullmatch(r"2\\textsuperscript\{(\d+)\}/\\textsubscript\{(\d+)\}", escape(f"2{c}"))
            assert found, c
            assert int(found[1]) / int(found[2]) == pytest.approx(unicodedata.numeric(c))
            seen += 1
    assert seen > 15


def test_characters_that_latex_reserves_or_lacks_are_named_and_spaces_stay_at_the_ends() -> None:
    assert escape("--- --") == "-{}-{}- -{}-"
    assert escape("é ç ï ø ß") == r"\'{e} \c{c} \"{\i} \o{} \ss{}"
    assert escape("x² H₂ 5°") == r"x\textsuperscript{2} H\textsubscript{2} 5\ensuremath{^{\circ}}"
    assert escape("\t a \n b \0") == "a b"
    assert escape("ę") == "e"
    assert escape("中") == r"[U+4E2D]\allowbreak{}"
    for words, told in ((" a ", " a "), ("a", "a"), ("", ""), (" ", "  ")):
        assert spaced(words) == told
    for c in map(chr, range(0x20, 0x250)):
        shown = escape(f"x{c}x")
        assert shown.isascii(), c
        if c.isascii() and (c.isalnum() or c in " +=*/.,:;()[]!?@-"):
            assert shown == f"x{c}x"
        elif unicodedata.category(c) not in ("Cc", "Cf", "Zs"):
            assert shown != "xx" or unicodedata.combining(c) or c == "\u00ad", hex(ord(c))
