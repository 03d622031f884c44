"""Documents of blocks put together by hand: what is told in brief and in full, and how it is set as text."""

from __future__ import annotations

import random
from itertools import pairwise
from typing import Any

import pytest
from blocks import figure

from haptisym.kernel.symbols import s
from haptisym.writing.boxes import Sum
from haptisym.writing.document import (
    Block,
    Code,
    Column,
    Document,
    Equations,
    Facts,
    Figure,
    Flow,
    Line,
    Live,
    Notes,
    Paragraph,
    Section,
    Strong,
    Table,
    Versions,
    chosen,
    coded,
    figures_of,
    is_empty,
    listed,
)
from haptisym.writing.names import named
from haptisym.writing.plain import plain, said, widths_of

WORDS, LIVE = Paragraph("Words."), Live(lambda: "<i>live</i>")
TABLE = Table((Column("h"), Column("more", full=True), Column("")), (("x", "y", ""), ("z", "", "")), "")


# What is told


def test_in_brief_there_are_no_figures_and_of_versions_the_brief_one_and_in_full_the_other() -> None:
    blocks: tuple[Block, ...] = (
        WORDS,
        figure("f"),
        LIVE,
        Versions((Paragraph("brief"),), lambda: (Paragraph("full"), figure("g"))),
    )
    assert list(chosen(blocks, full=False)) == [WORDS, Paragraph("brief")]
    assert [x.name if isinstance(x, Figure) else x for x in chosen(blocks, full=True)] == [
        WORDS,
        "f",
        Paragraph("full"),
        "g",
    ]
    assert list(chosen(blocks, full=False, live=True)) == [WORDS, LIVE, Paragraph("brief")]
    assert LIVE in chosen(blocks, full=True, live=True)
    made: list[int] = []

    def noted() -> tuple[Block, ...]:
        made.append(1)
        return ()

    assert list(chosen([Versions((WORDS,), noted)], full=False)) == [WORDS]
    assert made == []  # what is said in full is made only when it is wanted
    assert list(chosen([Versions((WORDS,), noted)], full=True)) == []


def test_a_section_in_which_nothing_is_left_has_no_heading_either() -> None:
    nested = Section("A", (Section("B", (figure("f"),)), Section("C", (WORDS, figure("g")), "c", appendix=True)))
    [brief] = chosen([nested], full=False)
    assert isinstance(brief, Section)
    assert brief == Section("A", (Section("C", (WORDS,), "c", appendix=True),))
    [full] = chosen([nested], full=True)
    assert full == nested
    assert list(chosen([Section("A", ())], full=True)) == []
    assert [x.name for x in figures_of([nested, figure("h"), Versions((figure("i"),), lambda: (figure("j"),))])] == [
        "f",
        "g",
        "h",
        "j",
    ]


def test_columns_for_reports_and_columns_that_say_nothing_are_left_out() -> None:
    assert TABLE.cut(full=False) == Table((Column("h"),), (("x",), ("z",)), "")
    assert TABLE.cut(full=True) == Table((Column("h"), Column("more", full=True)), (("x", "y"), ("z", "")), "")
    told = Table((Column(""), Column("")), (("", "x"), ("", "")), "caption")
    assert told.cut(full=False) == Table((Column(""),), (("x",), ("",)), "caption")
    headed = Table((Column("h"),), (("",),), "")
    assert headed.cut(full=False) == headed
    [cut] = chosen([TABLE], full=False)
    assert cut == TABLE.cut(full=False)
    for words, empty in (
        ("", True),
        ((), True),
        (("", ("", ())), True),
        ("x", False),
        (("", "x"), False),
        (Code(""), False),
        (named("k"), False),
    ):
        assert is_empty(words) is empty


def test_phrases_in_a_row() -> None:
    for count in range(5):
        words = [f"w{n}" for n in range(count)]
        told = said(listed(words))
        assert told == (" and ".join([", ".join(words[:-1]), words[-1]]) if count > 1 else "".join(words))
        assert said(listed(words, "or")) == told.replace(" and ", " or ")
    assert listed([]) == ()
    assert coded("") == ()
    assert coded("a `b` c `d`") == ("a ", Code("b"), " c ", Code("d"))
    assert coded("`b``c`") == (Code("b"), Code("c"))


# As text


def page(*blocks: Block, columns: int = 96, **own: Any) -> list[str]:
    return plain(Document("T", (), blocks), columns, **own).split("\n")[2:-1]


def test_a_page_begins_with_its_title_and_where_it_comes_from_and_ends_with_one_line() -> None:
    text = plain(Document("Title", ("a source", "", ("by ", Code("x"))), (WORDS,)))
    assert text == "Title\na source\nby `x`\n\nWords.\n"
    assert plain(Document("", (), (WORDS,))) == "\nWords.\n"
    assert plain(Document("T", (), (WORDS, figure("f")))) == "T\n\nWords.\n"


@pytest.mark.parametrize("columns", [1, 39, 40, 41, 60, 96])
def test_lines_are_as_full_as_they_may_be_and_no_page_is_narrower_than_forty(columns: int) -> None:
    pick, room = random.Random(columns), max(columns, 40)
    words = ["x" * pick.randint(1, 9) for _ in range(60)]
    shown = page(Paragraph(" ".join(words)), columns=columns)
    assert " ".join(shown) == " ".join(words)
    assert max(map(len, shown)) <= room
    for line, after in pairwise(shown):
        assert len(line) + 1 + len(after.split(" ")[0]) > room
    long = "y" * 120
    assert page(Paragraph(long), columns=columns) == [long]
    assert page(Paragraph("well-known " * 20), columns=columns)[0].endswith("known")


def test_a_share_stays_with_its_sign_and_what_must_stand_together_does() -> None:
    for filler in range(30, 45):
        shown = page(Paragraph("z" * filler + " 12 % of it\xa0all"), columns=44)
        assert all(not x.startswith(("%", "all")) for x in shown)
        assert "\xa0" not in "".join(shown)
    assert page(Paragraph("a %")) == ["a %"]


def test_sections_set_their_blocks_in_by_two_and_have_a_blank_line_below_their_title_unless_a_list_follows() -> None:
    inner = Section("Inner", (WORDS,))
    assert page(Section("Outer", (WORDS, inner))) == ["Outer", "", "  Words.", "", "  Inner", "", "  Words."]
    assert page(Section("Outer", (Notes(("one",)), WORDS))) == ["Outer", "  one", "", "  Words."]
    assert page(Section("Outer", (Facts((("k", "v"),)),))) == ["Outer", "  k  v"]
    assert page(Section("Outer", (Equations((Line(named("H"), s),)),))) == ["Outer", "    H = s"]
    assert page(Section("", (WORDS, inner))) == ["Words.", "", "Inner", "", "  Words."]


def test_an_equation_that_goes_on_is_set_in_by_four_more() -> None:
    long = Sum(tuple((1, named("y" * 9 + str(n))) for n in range(12)))
    shown = page(Equations((Line(named("H"), long),)), columns=48)
    assert shown[0].startswith("    H = y")
    assert len(shown) > 2
    assert all(x.startswith("        ") and x[8] != " " for x in shown[1:])
    below = page(Facts((("F", long),)), columns=60)
    assert all(x.startswith(" " * 9) and x[9] != " " for x in below[1:])
    words = page(Facts((("F", ("w ", long)),)), columns=60)
    assert all(x.startswith(" " * 5) and x[5] != " " for x in words[1:])
    assert page(Facts((("F", ()),))) == []


def test_signs_are_spelt_as_the_screen_can_show_them_wherever_they_stand() -> None:
    def spell(x: str) -> str:
        return x.translate({ord("ω"): "w", ord("─"): "-", ord("≤"): "<="})

    blocks = (
        Paragraph((named("omega"), " ≤ 3")),
        Facts((((named("omega")), "x"),)),
        Table((Column(named("omega")),), (("ω",),), ""),
    )
    shown = page(*blocks, spell=spell)
    assert shown == ["w <= 3", "", "  w  x", "", "  w", "  -", "  w"]


def test_a_flow_passes_on_with_arrows() -> None:
    assert page(Flow(("a", ("b ", Strong("c")), "d"))) == ["a → b c → d"]
    assert page(Flow(("a",))) == ["a"]


@pytest.mark.parametrize("seed", range(6))
def test_columns_give_way_from_the_widest_on_until_they_fit_and_never_below_their_longest_word(seed: int) -> None:
    pick = random.Random(seed)
    for _ in range(30):
        rows = [
            tuple(" ".join("x" * pick.randint(1, 12) for _ in range(pick.randint(0, 5))) for _ in range(3))
            for _ in range(3)
        ]
        natural = [max(map(len, c)) for c in zip(*rows, strict=True)]
        least = [
            max(max((len(w) for x in c for w in x.split(" ")), default=0), min(n, 8))
            for c, n in zip(zip(*rows, strict=True), natural, strict=True)
        ]
        for room in (sum(natural), sum(natural) - 1, sum(least), sum(least) - 1, (sum(natural) + sum(least)) // 2):
            found = widths_of(rows, room)
            if room < sum(least) and sum(natural) > room:
                assert found is None
                continue
            assert found is not None
            assert sum(found) == min(room, sum(natural))
            assert all(low <= w <= high for low, w, high in zip(least, found, natural, strict=True))
            widest = max((w for w, low in zip(found, least, strict=True) if w > low), default=0)
            gave_way = [w for w, low, n in zip(found, least, natural, strict=True) if low < w < n]
            assert all(w >= widest - 1 for w in gave_way)


def test_a_page_that_goes_to_no_terminal_has_96_columns() -> None:
    shown = plain(Document("T", (), (Paragraph("x" * 47 + " " + "y" * 48 + " " + "z" * 48 + " " + "w" * 48),))).split(
        "\n"
    )
    assert [len(x) for x in shown[2:-1]] == [96, 48, 48]


def test_a_cell_is_broken_between_words_and_never_at_a_hyphen_or_within_one() -> None:
    word = "frequency-dependent"
    rows = ((" ".join([word] * 3), "x " * 30),)
    shown = page(Table((Column("a"), Column("b")), rows, ""), columns=44)
    assert sum(x.count(word) for x in shown) == 3
    assert not any(x.rstrip().endswith("-") for x in shown if "─" not in x)


def test_rows_of_a_table_without_room_go_on_in_lines_set_in_by_four() -> None:
    long = "y" * 30
    shown = page(Table((Column("first"), Column("")), ((f"{long} {long}", long), ("z", ""))), columns=40)
    assert shown == [f"  first: {long}", f"    {long}", f"  {long}", "", "  first: z"]
