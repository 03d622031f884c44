"""How wide formulas are taken to be, against the font itself; and which lines, parts and long formulas follow from that."""

from __future__ import annotations

import random
import re
from collections.abc import Iterator
from pathlib import Path

import matplotlib as mpl
import pytest
from matplotlib.ft2font import FT2Font, LoadFlags
from sympy import Add, Expr, Integer, Pow, Symbol, cos, exp, sinh

from haptisym.writing.boxes import Box, Fraction, Numeral, Product, Sum
from haptisym.writing.document import Line
from haptisym.writing.layout import layout
from haptisym.writing.mathematics import ROOM, Parts, _wide, display
from haptisym.writing.names import named
from haptisym.writing.texlines import LINE, Names, align, broken, is_long, width
from haptisym.writing.texprinter import tex

THIN, MEDIUM, THICK = 3 / 18, 4 / 18, 5 / 18
"""What TeX sets beside commas, signs of operations and relations, em."""
NULL = 0.12
"""Of a quotient, on either side: \\nulldelimiterspace is 1.2 points."""


def advance(font: str, code: int) -> float:
    """Of a letter of Computer Modern, em."""
    face = FT2Font(str(Path(mpl.get_data_path()) / "fonts" / "ttf" / f"{font}.ttf"))
    face.set_size(10, 576)
    return face.load_char(code, flags=LoadFlags.NO_HINTING).linearHoriAdvance / 65536 / 80


def test_a_letter_a_digit_and_a_sign_are_nearly_as_wide_as_in_computer_modern() -> None:
    for letter in "abcdefghknopqrstuvxyzABCDEFGKLOPQRSTUVYZmwMWHNX":
        true = advance("cmmi10", ord(letter))
        assert abs(width(letter) - true) < 0.26, letter
        assert (width(letter) > 0.7) == (letter in "mwMWHNX"), letter
    for digit in "0123456789":
        assert width(digit) == advance("cmr10", ord(digit)) == 0.5
    plus = advance("cmr10", ord("+"))
    for sign, true in (
        ("+", plus + 2 * MEDIUM), ("-", plus + 2 * MEDIUM), ("=", plus + 2 * THICK), ("<", plus + 2 * THICK), (">", plus + 2 * THICK),
        ("(", advance("cmr10", ord("("))), (")", advance("cmr10", ord(")"))), (r"\quad", 1.0), (r"\,", THIN),
        (".", advance("cmr10", ord("."))), (",", advance("cmr10", ord(",")) + THIN), (r"\cdot", 0.278 + 2 * MEDIUM), ("|", 0.278), ("'", 0.275),
        (r"\times", 0.778 + 2 * MEDIUM), (r"\approx", 0.778 + 2 * THICK), (r"\Delta", 0.833), (r"\omega", 0.622), (r"\sqrt", 0.833),
    ):  # fmt: skip
        assert abs(width(sign) - true) <= 0.135, sign
        assert abs(width(sign) / true - 1) < 0.3, sign


def test_fences_that_grow_are_as_wide_as_they_look_and_kinds_of_letters_add_nothing() -> None:
    bare = width("(a)")
    assert width(r"\left( a \right)") == bare
    for command in ("mathrm", "mathcal", "text"):
        assert width(rf"\{command}{{abc}}") == pytest.approx(3 * width("a"))
    for left, right in ((r"\bigl", r"\bigr"), (r"\Bigl", r"\Bigr")):  # 0.458 and 0.597 em each, instead of 0.389
        assert 0 < width(f"{left}( a {right})") - bare <= 0.3


def trees(pick: random.Random, depth: int) -> tuple[str, float]:
    """A formula and how wide TeX sets it: scripts are three quarters as large, a quotient as wide as its wider part and a bar."""
    kind = pick.choice(["leaf", "leaf", "row", "^", "_", "frac", "tfrac", "group"]) if depth else "leaf"
    if kind == "leaf":
        return pick.choice([("7", 0.5), ("x", width("x")), (r"\omega", width(r"\omega")), ("+", width("+"))])
    parts = [trees(pick, depth - 1) for _ in range(3 if kind == "row" else 2)]
    (one, a), (two, b) = parts[:2]
    if kind == "row":
        return " ".join(text for text, _ in parts), sum(wide for _, wide in parts)
    if kind == "group":
        return f"{{{one} {two}}}", a + b
    if kind in ("^", "_"):
        return f"{{{one}}}{kind}{{{two}}}", a + 0.75 * b
    return rf"\{kind}{{{one}}}{{{two}}}", (max(a, b) if kind == "frac" else 0.7 * max(a, b)) + 2 * NULL


def test_a_formula_is_as_wide_as_what_stands_side_by_side_in_it() -> None:
    pick = random.Random(3)
    for _ in range(200):
        text, true = trees(pick, 4)
        bars = text.count(r"\frac") + text.count(r"\tfrac")
        assert true - 1e-9 <= width(text) <= true + 0.011 * bars + 1e-9, text
        assert width(f"{text} {text}") == pytest.approx(2 * width(text))


def test_a_script_without_braces_is_one_sign_and_one_without_anything_ends_the_formula() -> None:
    for mark in "^_":
        assert width(f"x{mark}77") == pytest.approx(width("x") + 0.75 * 0.5 + 0.5)
        assert width(rf"x{mark}\omega") == pytest.approx(width("x") + 0.75 * width(r"\omega"))
        assert 0 < width(f"x{mark}") < 2
    assert width("") == 0
    assert width("7} 7") == 0.5  # what stands behind a brace that nothing opened is not the formula's


# What is long


def tower(levels: int) -> Expr:
    """Powers of powers: two nodes of the tree for a level, and hardly any width."""
    found: Expr = Symbol("x0")
    for n in range(1, levels + 1):
        found = Pow(Symbol(f"x{n}"), found, evaluate=False)
    return found


def nodes(expression: Expr) -> int:
    return 1 + sum(nodes(x) for x in expression.args)


def test_a_formula_is_long_from_more_than_fifty_parts_for_each_line_on() -> None:
    for levels in (23, 24):
        value = tower(levels) + Symbol("b") + Symbol("c")
        assert width(tex_of(value)) < LINE
        assert nodes(value) == 2 * levels + 4
        assert is_long(value, lines=1) == (nodes(value) > 50)
    assert nodes(tower(23) + Symbol("b") + Symbol("c")) == 50
    flat = Add(*(Symbol(f"y{n}") for n in range(1000)))
    assert is_long(flat)


def tex_of(value: Expr) -> str:
    return tex(layout(value))


def test_a_formula_is_long_where_it_fills_more_lines_or_holds_a_number_of_forty_digits() -> None:
    digits = [named("5")] * 80  # half an em each: a line of 40
    for lines in (1, 2):
        assert not is_long(Product((*digits * lines,)), lines)
        assert is_long(Product((*digits * lines, named("5"))), lines)
    assert not is_long(Product((*digits * 10,)))
    assert is_long(Product((*digits * 10, named("5"))))
    for value in (Integer(10**39 - 1), Numeral("1" * 39)):
        assert not is_long(value)
    for value in (Integer(10**39), Integer(-(10**39)), Numeral("1" * 40)):
        assert is_long(value)
    symbol = Symbol("a")
    short = sum((symbol**n for n in range(2, 12)), Integer(0))
    assert is_long(short, lines=1) == (width(tex_of(short)) > LINE)


# What is broken, and what gets a name


def digits_of(count: int, digit: str = "5") -> Box:
    """So many digits side by side, each half an em, which cannot be broken."""
    return named(digit * count)


def parted(above: int, below: int, *, minus: bool = False) -> list[str]:
    box: Box = Fraction(digits_of(above), digits_of(below, "7"))
    text = align([Line(named("N"), Sum(((-1, box),)) if minus else box)])
    assert text.startswith("\\begin{align*}\n  N &= ")
    assert text.endswith("\n\\end{align*}")
    return text.splitlines()[1:-1]


def test_a_fraction_is_written_as_it_is_while_it_fits_and_a_part_gets_a_name_if_it_takes_more_than_the_room_but_two() -> (
    None
):
    """Beside N, of 0.85 em, are 39.15: a bar adds 0.25 to 77 digits; parts of at most 37.15, 74 digits, are written."""
    assert width("N") == 0.85
    for above in (10, 74, 75, 77, 78, 90):
        for below in (10, 74, 75, 78):
            shown = parted(above, below)
            if max(above, below) <= 77:
                assert shown == [rf"  N &= \frac{{{'5' * above}}}{{{'7' * below}}}"]
                continue
            names = [n > 74 for n in (above, below)]
            first, second = (
                rf"\mathcal{{{x}}}_{{1}}" if own else text
                for x, own, text in zip("ND", names, ("5" * above, "7" * below), strict=True)
            )
            told = [rf"N &= \frac{{{first}}}{{{second}}}"]
            told += [
                rf"\mathcal{{{x}}}_{{1}} &= {text}"
                for x, own, text in zip("ND", names, ("5" * above, "7" * below), strict=True)
                if own
            ]
            assert shown == [f"  {x} \\\\" if i + 1 < len(told) else f"  {x}" for i, x in enumerate(told)]


def test_a_minus_stands_in_front_of_a_long_fraction_and_a_sum_of_fractions_is_broken_at_its_signs() -> None:
    assert parted(75, 3, minus=True) == [rf"  N &= -\frac{{{'5' * 75}}}{{777}}"]
    assert parted(80, 3, minus=True)[0].startswith(r"  N &= -\frac{\mathcal{N}_{1}}{777}")
    both = Sum(((1, Fraction(digits_of(60), digits_of(3))), (-1, Fraction(digits_of(50), digits_of(3)))))
    lines = align([Line(named("N"), both)]).splitlines()[1:-1]
    assert [x.count(r"\frac") for x in lines] == [1, 1]
    assert lines[1].startswith(r"  &\quad {} - \frac")
    assert "mathcal" not in "".join(lines)


def test_rows_of_equations_have_the_room_beside_the_widest_name_and_end_with_a_mark_but_for_the_last() -> None:
    """78 digits are 39 em; beside a name of 0.85 there is room for them, beside one of 1.3 or more there is none for a bar."""
    wide = Fraction(digits_of(77), digits_of(3))
    alone = align([Line(named("N"), wide)])
    beside = align([Line(named("N"), wide), Line(named("HHH"), digits_of(1))])
    assert "mathcal" not in alone
    assert r"\mathcal{N}_{1}" in beside
    body = beside.splitlines()
    assert [x.endswith(r" \\") for x in body[1:-1]] == [True, True, False]
    assert (body[0], body[-1]) == (r"\begin{align*}", r"\end{align*}")
    assert align([]) == ""
    for box in (wide, Fraction(digits_of(3), digits_of(90))):
        names = Names()
        lines = [
            *align([Line(named("HHH"), box, "≈")], names).splitlines(),
            *align([Line(named("HHH"), box, "≈")], names).splitlines(),
        ]
        assert sum(r" &\approx 5" in x for x in lines) == 1  # what a name stands for is told once, as rounded as it is


def pieces(pick: random.Random, count: int) -> Iterator[str]:
    """Terms between which a line may be broken, and others within which it may not."""
    for n in range(count):
        kind = pick.choice(
            [
                "a b",
                r"\frac{a + b}{c - d}",
                r"\left( \frac{a}{b} + c \right)",
                r"\left| a - b \right|",
                r"\sqrt{a + b}",
                "x^{a + b}",
            ]
        )
        yield f"{pick.choice('+-')} {kind} c_{{{n}}}"


def test_no_line_ends_within_braces_or_between_fences_that_grow_together() -> None:
    pick = random.Random(8)
    for _ in range(25):
        text = "z " + " ".join(pieces(pick, pick.randint(3, 9)))
        lines = broken(text, pick.choice([3.0, 8.0, 15.0]))
        assert len(lines) > 1
        for line in lines:
            assert line.count("{") == line.count("}")
            assert line.count(r"\left") == line.count(r"\right")
        joined = " ".join(re.sub(r"^\{\} (\\times )?", "", line) for line in lines)
        assert joined == text


def test_sums_in_parentheses_may_be_parted_as_well_as_terms_and_other_factors_only_if_nothing_else_will_do() -> None:
    """Three sums on lines of 8 em end behind one; with a letter between them there is a worse place, and it is not taken."""
    assert broken("a (b + c) (d + e) (f + g)", 8.0) == ["a (b + c) (d + e)", r"{} \times (f + g)"]
    assert broken(r"(b + c) \bigl( d + (e) \bigr) f", 6.0)[0] == "(b + c)"
    assert broken("(b + c) (d + e) f (g + h)", 8.0) == ["(b + c) (d + e) f (g", "{} + h)"]
    assert broken("a b c + d e f", 3.5)[0] == "a b c"
    assert broken(r"2 \cdot 3 \times 4 \cdot 5", 0.5) == [r"2 \cdot 3 \times 4 \cdot 5"]


# The same on a page


def test_a_page_counts_space_around_names_of_functions_and_names_parts_where_latex_does() -> None:
    """Its lines are 38 em: beside N 37.15, parts of at most 35.15 em, 70 digits, are written."""
    x = Symbol("x")
    for form, count in ((cos(x), 1), (cos(x) * sinh(x) ** 2, 2), (exp(x), 0), (x, 0)):
        assert _wide(layout(form)) == pytest.approx(width(tex(layout(form))) + 1.3 * count)
    assert ROOM == 38
    for above in (70, 71, 73, 74):
        for below in (3, 70, 71, 80):
            shown = str(display([Line(named("N"), Fraction(digits_of(above), digits_of(below, "7")))], Parts()))
            fits = max(above, below) <= 73
            assert ("𝒩" in shown) == (not fits and above > 70), (above, below)
            assert ("𝒟" in shown) == (not fits and below > 70), (above, below)
