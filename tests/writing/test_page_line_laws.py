"""Where a formula of a page may be broken, and what stands at the ends of its lines."""

from __future__ import annotations

import random
import re
from xml.etree import ElementTree

import pytest
from sympy import Add, Symbol

from haptisym.kernel.symbols import s
from haptisym.writing.boxes import Absolute, Box, Fenced, Fraction, Name, Numeral, Product, Sum
from haptisym.writing.document import Line
from haptisym.writing.layout import layout
from haptisym.writing.mathematics import _NEVER, ROOM, Parts, _pieces, display
from haptisym.writing.mathml import markup
from haptisym.writing.names import named

SPACE = "{http://www.w3.org/1998/Math/MathML}"


def rows(markup_of_page: str) -> list[tuple[str, str]]:
    table = ElementTree.fromstring(markup_of_page.replace("&#x2062;", "⁢"))
    return [(one, two) for one, two in (tuple("".join(c.itertext()) for c in row) for row in table.iter(f"{SPACE}mtr"))]


def text(piece: str) -> str:
    return re.sub("<[^>]*>", "", piece).replace("&#x2062;", "⁢")


def wide(count: int) -> Name:
    """A name of so many digits, half an em each."""
    return named("5" * count)


def total(*parts: Box | tuple[int, Box]) -> Sum:
    return Sum(tuple(x if isinstance(x, tuple) else (1, x) for x in parts))


PARTS = total(wide(4), (-1, wide(6)), wide(8), wide(8))  # 13 em, and 3.6 for its signs


def shown(box: Box, depth: int = 0) -> list[tuple[str, float, int]]:
    return [(text(x.text), round(x.width, 6), x.penalty) for x in _pieces(box, depth)]


@pytest.mark.parametrize("depth", [0, 2])
def test_a_sum_is_cut_at_its_signs_which_count_with_what_follows_them(depth: int) -> None:
    own = total((-1, wide(4)), wide(2), (-1, wide(6)))
    assert shown(own, depth) == [("−5555", 3.2, depth), ("+55", 2.2, depth), ("−555555", 4.2, depth)]
    assert shown(total(wide(4), (-1, wide(2))), depth) == [("5555", 2.0, depth), ("−55", 2.2, depth)]
    first, *others = _pieces(own, depth)
    assert "infix" not in first.text  # a sign in front is no operation
    assert all('<mo form="infix">' in x.text for x in others)


@pytest.mark.parametrize("depth", [0, 2])
def test_between_factors_it_is_ten_worse_and_between_parentheses_one_worse_than_outside(depth: int) -> None:
    never_first = [
        ("(5555", 2.4, _NEVER),
        ("−555555", 4.2, depth + 1),
        ("+55555555", 5.2, depth + 1),
        ("+55555555)", 5.6, depth + 1),
    ]
    assert shown(Fenced(PARTS), depth) == never_first
    between = depth + 10
    assert shown(Product((wide(2), Fenced(PARTS), wide(4))), depth) == [
        ("55", 1.0, between), ("⁢(5555", 2.4, between), *never_first[1:], ("⁢5555", 2.0, between),
    ]  # fmt: skip
    assert shown(Product((Numeral("2"), Numeral("3"), wide(4))), depth) == [
        ("2", 0.5, between),
        ("⋅3", 0.5, between),
        ("⁢5555", 2.0, between),
    ]


def test_parentheses_of_more_than_a_quarter_of_a_line_may_be_broken_and_bars_of_more_than_a_line() -> None:
    """Two fences are 0.7 em, bars too: 8.8 em of digits and a sign fill a quarter of 38."""
    for count, broken in ((13, False), (14, False), (15, True)):
        own = total(wide(count), wide(1))  # half an em for each digit, and 1.2 for a sign
        size = 0.5 * count + 0.5 + 1.2 + 0.7
        assert (size > ROOM / 4) == broken
        assert (len(shown(Fenced(own))) == 2) == broken
        assert shown(Absolute(own)) == [(text(markup(Absolute(own))), round(size, 6), _NEVER)]
    for count, broken in ((71, False), (72, True)):
        own = total(wide(count), wide(1))
        assert (0.5 * count + 2.4 > ROOM) == broken
        cut = shown(Absolute(own))
        assert len(cut) == 1 + broken
        assert "".join(x for x, _, _ in cut) == f"|{'5' * count}+5|"
        assert not broken or [x for _, _, x in cut] == [_NEVER, 1]


def test_one_piece_in_parentheses_stays_whole() -> None:
    own = Fenced(Fraction(wide(30), wide(3)))
    assert [x for x, _, _ in shown(own)] == [f"({'5' * 30}555)"]
    assert shown(own)[0][1] == 0.8 + 15.25


def spread(pick: random.Random, count: int) -> Sum:
    return Sum(tuple((pick.choice([1, -1]), wide(pick.randint(2, 14))) for _ in range(count)))


def test_a_product_of_long_sums_loses_nothing_on_its_lines_and_each_begins_with_the_sign_of_what_it_goes_on_with() -> (
    None
):
    pick = random.Random(6)
    crossed = 0
    for _ in range(30):
        kinds = [pick.random() < 0.4 for _ in range(pick.randint(3, 9))]
        box = Product(tuple(Fenced(spread(pick, 4)) if is_sum else wide(pick.randint(4, 22)) for is_sum in kinds))
        found = rows(display([Line(named("H"), box)]))
        assert [x for x, _ in found] == ["H"] + [""] * (len(found) - 1)
        assert found[0][1].startswith("=")
        for _, line in found[1:]:
            assert line[0] in "+−×"
            crossed += line[0] == "×"
            assert not line.startswith("×⁢")
        whole = found[0][1][1:] + "".join(line.replace("×", "⁢", 1) if line[0] == "×" else line for _, line in found[1:])
        assert whole == text(markup(box))
    assert crossed > 5


def test_lines_after_the_first_are_set_in_by_two_em_and_three_narrower() -> None:
    """Beside H, of 0.85 em, are 37.15: terms of 10 em, with 1.2 for the sign, stand three and three and so on."""
    terms = total(*[wide(20)] * 9)
    found = rows(display([Line(named("H"), terms)]))
    assert [line.count("5" * 20) for _, line in found] == [3, 3, 3]
    narrow = rows(display([Line(named("H"), total(*[wide(22)] * 9))]))  # 11 + 12.2 + 12.2 = 35.4, but 36.6 > 34.15
    assert [line.count("5" * 22) for _, line in narrow] == [3, 2, 2, 2]
    shown_page = str(display([Line(named("H"), terms)]))
    assert shown_page.count('<mspace width="2em"/>') == 2
    assert shown_page.count('<mtr class="more">') == 2
    assert shown_page.count('style="text-align: left"') == 6
    fits = rows(display([Line(named("H"), total(wide(20), wide(20), wide(29)))]))  # 34.5 + 2.4 = 36.9
    over = rows(display([Line(named("H"), total(wide(20), wide(20), wide(30)))]))  # 37.4
    assert (len(fits), len(over)) == (1, 2)


def test_names_of_parts_are_numbered_by_their_letter_and_a_part_keeps_its_name() -> None:
    parts = Parts()
    one, two, three = wide(3), wide(4), wide(5)
    told = [parts.name(x, letter) for x, letter in ((one, "𝒩"), (two, "𝒟"), (three, "𝒩"), (one, "𝒩"), (two, "𝒟"))]
    assert [(x.head.letters, x.below[0].letters, new) for x, new in told] == [
        ("𝒩", "1", True), ("𝒟", "1", True), ("𝒩", "2", True), ("𝒩", "1", False), ("𝒟", "1", False),
    ]  # fmt: skip
    assert [x.text for x, _ in told[:3]] == ["𝒩_1", "𝒟_1", "𝒩_2"]
    assert not any(word.upright for x, _ in told for word in (x.head, *x.below))


def test_what_a_named_part_stands_for_follows_its_fraction_and_has_no_relation_of_its_own() -> None:
    top, bottom = (Add(*(Symbol(f"{letter}{n}") for n in range(40))) for letter in "pq")
    found = rows(display([Line(named("H"), Fraction(layout(top), layout(bottom)), "≈")]))
    assert found[0] == ("H", "≈𝒩1𝒟1")
    starts = {left: right[0] for left, right in found if left}
    assert starts == {"H": "≈", "𝒩1": "=", "𝒟1": "="}
    assert [left for left, _ in found if left] == ["H", "𝒩1", "𝒟1"]
    again = rows(display([Line(named("H"), Fraction(layout(top), layout(s)))]))
    assert again[0] == ("H", "=𝒩1s")
    assert [left for left, _ in again if left] == ["H", "𝒩1"]
