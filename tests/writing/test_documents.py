"""Documents of blocks put together by hand, as plain text, LaTeX and HTML: nothing is lost, lines fit, numbers stand below each other."""

from __future__ import annotations

import random
import re
from collections.abc import Iterator
from html.parser import HTMLParser
from itertools import pairwise
from typing import Any
from xml.etree import ElementTree

import pytest
from blocks import figure
from sympy import Add, Symbol

from haptisym.kernel.rings import s
from haptisym.writing.boxes import Fenced, Name, Numeral, SideBySide, Sum
from haptisym.writing.document import (
    Block,
    Code,
    Column,
    Document,
    Facts,
    Figure,
    Flow,
    Line,
    Live,
    Notes,
    Number,
    Paragraph,
    Phrase,
    Section,
    Strong,
    Style,
    Table,
    Versions,
    is_empty,
)
from haptisym.writing.html import Html, data, display, element, html, joined, script
from haptisym.writing.html import fragment as html_fragment
from haptisym.writing.html import phrase as html_phrase
from haptisym.writing.latex import align, broken, piece, tables
from haptisym.writing.latex import fragment as tex_fragment
from haptisym.writing.latex import phrase as tex_phrase
from haptisym.writing.layout import named
from haptisym.writing.mathml import markup
from haptisym.writing.plain import plain

WORDS, LIVE = Paragraph("Words."), Live(lambda: "<i>live</i>")


TABLE = Table((Column("h"), Column("more", full=True), Column("")), (("x", "y", ""), ("z", "", "")), "")


def test_in_brief_there_are_no_figures_and_of_versions_the_brief_one_and_in_full_the_other() -> None:
    blocks: tuple[Block, ...] = (
        WORDS,
        figure("f"),
        LIVE,
        Versions((Paragraph("brief"),), lambda: (Paragraph("full"), figure("g"))),
    )
    assert list(Style(full=False).chosen(blocks)) == [WORDS, Paragraph("brief")]
    assert [x.name if isinstance(x, Figure) else x for x in Style(full=True).chosen(blocks)] == [
        WORDS,
        "f",
        Paragraph("full"),
        "g",
    ]
    assert list(Style(full=False, live=True).chosen(blocks)) == [WORDS, LIVE, Paragraph("brief")]
    assert LIVE in Style(full=True, live=True).chosen(blocks)
    made: list[int] = []

    def noted() -> tuple[Block, ...]:
        made.append(1)
        return ()

    assert list(Style(full=False).chosen([Versions((WORDS,), noted)])) == [WORDS]
    assert made == []  # what is said in full is made only when it is wanted
    assert list(Style(full=True).chosen([Versions((WORDS,), noted)])) == []


def test_columns_for_reports_and_columns_that_say_nothing_are_left_out() -> None:
    assert TABLE.cut(full=False) == Table((Column("h"),), (("x",), ("z",)), "")
    assert TABLE.cut(full=True) == Table((Column("h"), Column("more", full=True)), (("x", "y"), ("z", "")), "")
    told = Table((Column(""), Column("")), (("", "x"), ("", "")), "caption")
    assert told.cut(full=False) == Table((Column(""),), (("x",), ("",)), "caption")
    headed = Table((Column("h"),), (("",),), "")
    assert headed.cut(full=False) == headed
    [cut] = Style(full=False).chosen([TABLE])
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


def page(*blocks: Block, columns: int = 96, **own: Any) -> list[str]:
    return plain(Document("T", (), blocks), columns, **own).split("\n")[2:-1]


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


VOCABULARY = ("a", "of", "the", "force", "stiffness", "changes", "frequency-dependent", "10^4")


def cells(pick: random.Random, rows: int, kinds: list[bool], most: int) -> list[tuple[str, ...]]:
    def cell(*, number: bool) -> str:
        if number:
            return pick.choice(
                ["-", f"{pick.choice(['', '-', '='])}{pick.randint(0, 9999)}{pick.choice(['', '.5', '.125'])}"]
            )
        return " ".join(pick.choice(VOCABULARY) for _ in range(pick.randint(1, most)))

    return [tuple(cell(number=x) for x in kinds) for _ in range(rows)]


def test_a_table_with_room_has_columns_as_wide_as_their_longest_cell_and_points_below_each_other() -> None:
    pick = random.Random(4)
    for _ in range(20):
        kinds = [pick.random() < 0.5 for _ in range(pick.randint(1, 4))]
        heads, rows = [pick.choice(VOCABULARY) for _ in kinds], cells(pick, pick.randint(1, 4), kinds, 2)
        table = Table(tuple(Column(x, number=k) for x, k in zip(heads, kinds, strict=True)), tuple(rows), "")
        shown = []
        for column, is_number in zip(zip(*rows, strict=True), kinds, strict=True):
            whole = [re.match(r"[=+-]?[\d,]+", x) for x in column] if is_number else [None] * len(column)
            before = [len(x[0]) if x else 0 for x in whole]
            shown.append([" " * (max(before) - n) * (n > 0) + x for n, x in zip(before, column, strict=True)])
        widths = [max(map(len, (head, *column))) for head, column in zip(heads, shown, strict=True)]
        lines = [
            "  " + "   ".join(x.ljust(w) for x, w in zip(row, widths, strict=True)).rstrip()
            for row in (heads, *zip(*shown, strict=True))
        ]
        rule = "  " + "─" * (sum(widths) + 3 * (len(widths) - 1))
        assert page(table, columns=300) == [lines[0].rstrip(), rule, *(x.rstrip() for x in lines[1:])]


class Cells(HTMLParser):
    """Class and text of each cell, row by row."""

    def __init__(self, markup: str) -> None:
        super().__init__()
        self.rows: list[list[list[str]]] = []
        self.feed(markup)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag == "tr":
            self.rows.append([])
        elif tag in ("td", "th"):
            self.rows[-1].append([dict(attrs).get("class") or "", ""])

    def handle_data(self, data: str) -> None:
        if self.rows and self.rows[-1]:
            self.rows[-1][-1][1] += data


def html_rows(table: Table) -> list[list[list[str]]]:
    return Cells(html_fragment(Document("T", (), (table,)))).rows


def test_points_of_numbers_stand_below_each_other_unless_they_are_very_long() -> None:
    def column(*shown: str) -> list[str]:
        return [row[0][1] for row in html_rows(Table((Column("h", number=True),), tuple((x,) for x in shown), ""))[1:]]

    assert column("1.5", "-100.25", "-", "=20", "3,000.1") == [
        "\u2007\u2007\u2007\u20071.5",
        "\u2007-100.25",
        "-",
        "\u2007\u2007=20",
        "3,000.1",
    ]
    assert column("1" * 25 + ".5", "2.5") == ["1" * 25 + ".5", "\u2007" * 24 + "2.5"]
    assert column("1" * 26 + ".5", "2.5") == ["1" * 26 + ".5", "2.5"]
    long = html_fragment(Document("T", (), (Paragraph(Number("1" * 26, 1.0)), Paragraph(Number("1" * 25, 1.0)))))
    assert long.count('class="long"') == 1


@pytest.mark.slow
def test_what_is_long_and_may_be_left_out_is_left_out_and_its_meaning_is_not() -> None:
    long, short = Add(*(Symbol(f"x{i}") ** i for i in range(2, 300))), s + 1
    for value, meaning, optional, rows in (
        (long, None, True, 0), (short, None, True, 1), (long, named("G"), True, 1), (short, named("G"), True, 1), (short, None, False, 1),
    ):  # fmt: skip
        line = Line(named("H"), value, "=", meaning, optional)
        assert display([line]).count("<mtr") == rows
        shown = align([line])
        assert (shown == "") == (rows == 0)
        assert shown.count("&=") == rows
        assert ("x" in shown) is False
    assert display([Line(named("H"), long)]).count("<mtr") > 10


def inside(*blocks: Block) -> str:
    text = html(Document("T", (), blocks), lambda x: element("figure", x.name), ("record", "{}"), "made")
    found = re.search(r"</header>(.*)<p class=\"source\">made</p>", text, re.DOTALL)
    assert found
    return found[1]


def test_a_page_of_html_has_title_kind_source_record_and_by_what_it_was_made() -> None:
    text = html(
        Document("A < B", ("from there", ("by ", Code("x"))), (WORDS,), "Peaks"),
        lambda _: Html(),
        ("answer", '{"a": "</script>"}'),
        "Made by me.",
    )
    assert text.startswith('<!DOCTYPE html>\n<html lang="en">')
    assert text.endswith("</html>\n")
    for part in (
        "<title>A &lt; B</title>", '<header><p class="kind">Peaks</p><h1>A &lt; B</h1><p class="source">from there</p><p class="source">by <code>x</code></p></header><p>Words.</p>',
        '<p class="source">Made by me.</p><script type="application/json" id="answer">{"a": "\\u003c/script>"}</script>', "default-src &#x27;none&#x27;",
    ):  # fmt: skip
        assert part in text
    assert (
        'class="kind"'
        not in html(Document("T", (), (WORDS,)), lambda _: Html(), ("r", "{}"), "m").partition("</style>")[2]
    )


def test_blocks_of_html_are_what_they_are() -> None:
    assert inside(Notes(("one", Strong("two")))) == "<p>one</p><p><strong>two</strong></p>"
    assert inside(Facts((("k", "v"),))) == '<dl class="facts"><div><dt>k</dt><dd>v</dd></div></dl>'
    assert inside(Facts((("k", "v"),), "own")).startswith('<dl class="own">')
    assert inside(Flow(("a", "b"))) == '<ol class="chain"><li>a</li><li>b</li></ol>'
    assert inside(LIVE) == "<i>live</i>"
    small, wide = [figure("a"), figure("b")], figure("w", wide=True)
    assert inside(*small, wide, *small[:1]) == (
        '<div class="pair"><figure>a</figure><figure>b</figure></div><figure>w</figure><div class="pair"><figure>a</figure></div>'
    )
    shown = inside(Table((Column("h"), Column("n", number=True)), (("x", "1"),), "All"))
    assert shown == (
        '<div class="scroll"><table><caption>All</caption><thead><tr><th scope="col">h</th><th scope="col" class="number">n</th></tr></thead>'
        '<tbody><tr><td>x</td><td class="number">1</td></tr></tbody></table></div>'
    )
    assert "caption" not in inside(Table((Column("h"),), (("x",),), ""))
    full = inside(Table((Column("h"),), (("several words " * 9,),), ""))
    assert full.count('class="words"') == 2


def test_in_a_notebook_a_document_is_one_element_in_brief() -> None:
    document = Document(
        "A < B",
        ("from there",),
        (WORDS, figure("f"), LIVE, Versions((Paragraph("brief"),), lambda: (Paragraph("full"),))),
        "Kind",
    )
    assert (
        html_fragment(document)
        == '<div class="haptisym"><p><strong>A &lt; B</strong></p><p>from there</p><p>Words.</p><p>brief</p></div>'
    )


def test_numbers_of_html_have_their_double_and_long_ones_may_be_broken() -> None:
    for digits in (25, 26):
        shown = html_phrase(Number("1" * digits, 0.1))
        assert shown.startswith('<data value="0.1">')
        assert ('<span class="long">' in shown) == (digits > 25)
    assert html_phrase(("a", Code("<b>"), named("k"))).startswith("a<code>&lt;b&gt;</code><math")
    told: Phrase = Numeral("3")
    assert "<mn>3</mn>" in html_phrase(told)


def test_text_is_escaped_and_nothing_ends_a_script() -> None:
    assert joined(["<", Html("<b>"), "&"]) == "&lt;<b>&amp;"
    assert element("br") == "<br>"
    assert element("p") == "<p></p>"
    assert (
        element("p", "\x00\ud800\tx\n\uffff", given={"title": "\x01"})
        == '<p title="\ufffd">\ufffd\ufffd\tx\n\ufffd</p>'
    )
    assert "</script" not in script("x</script><!--y").removesuffix("</script>")
    assert data("</script><!--", "i") == '<script type="application/json" id="i">\\u003c/script>\\u003c!--</script>'


def test_words_numbers_code_and_formulas_are_set_each_in_their_way() -> None:
    long = "1234567890" * 2 + "12345"
    for words, text in (
        (("5 % of ", named("r_r"), " is "), r"5 \% of $r_r$ is "), ("10\xa0%", r"10~\%"), (Strong(("NOT ", Number("2.5", 2.5))), r"\textbf{NOT 2.5}"),
        (Number(long, 1.0), r"12345\allowbreak{}67890\allowbreak{}12345\allowbreak{}67890\allowbreak{}12345"), (Number(long + "6", 1.0), r"12345\allowbreak 67890\allowbreak 12345\allowbreak 67890\allowbreak 12345\allowbreak 6"),
        (Code('jnd = "x"'), r"\texttt{jnd = \char34{}x\char34{}}"), (Code("a''b"), r"\texttt{a''b}"), (Code("a_b"), r"\texttt{a\_b}"),
    ):  # fmt: skip
        assert tex_phrase(words) == text


def table(
    *rows: tuple[Phrase, ...],
    heads: tuple[Phrase, ...] = ("h",),
    numbers: tuple[bool, ...] = (False,),
    caption: Phrase = "",
) -> str:
    return tex_fragment(
        (Table(tuple(Column(h, number=n) for h, n in zip(heads, numbers, strict=True)), rows, caption),)
    )


def body(text: str) -> list[list[str]]:
    inside = [
        y for x in text.split(r"\midrule")[1:] for y in x.partition(r"    \bottomrule")[0].strip("\n").split("\n")
    ]
    return [x.strip().removesuffix(r" \\").split(" & ") for x in inside]


def test_numbers_of_a_column_stand_with_their_points_below_each_other() -> None:
    shown = table(
        ("1.5", "1.5"), ("-100.25", "-"), ("-", "=20"), ("3,000", "x1"), heads=("n", "m"), numbers=(True, True)
    )
    assert body(shown) == [
        [r"\phantom{0000}1.5", r"\phantom{00}1.5"],
        [r"\phantom{0}\ensuremath{-}100.25", "-"],
        ["-", "=20"],
        ["3,000", "x1"],
    ]
    assert body(table(("1.5",), ("100",))) == [["1.5"], ["100"]]
    long = "1" * 25
    assert body(table((long,), ("2",), numbers=(True,)))[1] == [rf"\phantom{{{'0' * 24}}}2"]
    assert body(table((long + "1",), ("2",), numbers=(True,)))[1] == ["2"]


@pytest.mark.parametrize("count", [1, 31, 32, 33, 64, 65])
def test_a_table_of_more_than_32_lines_goes_on_in_another_one(count: int) -> None:
    text = table(*((str(n),) for n in range(count)), caption="All")
    assert text.count(r"\begin{table}[!htbp]") == text.count(r"\toprule") == -(-count // 32)
    assert text.count(r"\caption{All}") == 1
    assert text.count(r"\caption{All (Continued.)}") == -(-count // 32) - 1
    assert body(text) == [[str(n)] for n in range(count)]
    assert len(body(text.split(r"\end{table}")[0])) == min(count, 32)
    assert text.index(r"\caption{All}") < text.index(r"\begin{tabular}")
    assert r"\caption" not in table(("x",))


def test_tables_of_a_document_are_those_told_in_brief_and_what_is_said_below_the_title_but_for_the_source() -> None:
    brief, full = (Table((Column("h"), Column("more", full=True)), ((x, "y"),), "") for x in ("brief", "full"))
    blocks: tuple[Block, ...] = (
        WORDS,
        Section("S", (brief, Section("T", (brief,)))),
        Versions((brief,), lambda: (full,)),
    )
    text = tables(Document("T", ("a source", ("by ", Code("x"))), blocks))
    assert text.count(r"\begin{table}") == 3
    assert "full" not in text
    assert "more" not in text
    assert text.endswith("\n\nby \\texttt{x}")
    assert "a source" not in text
    assert "Words" not in text
    own = piece(Document("T", ("a source", ("by ", Code("x"))), (WORDS, Section("S", (WORDS,)))))
    assert own == "by \\texttt{x}\n\nWords.\n\n\\paragraph{S}\n\nWords."


def terms_of(pick: random.Random, count: int) -> Iterator[str]:
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
        text = "z " + " ".join(terms_of(pick, pick.randint(3, 9)))
        lines = broken(text, pick.choice([3.0, 8.0, 15.0]))
        assert len(lines) > 1
        for line in lines:
            assert line.count("{") == line.count("}")
            assert line.count(r"\left") == line.count(r"\right")
        joined = " ".join(re.sub(r"^\{\} (\\times )?", "", line) for line in lines)
        assert joined == text


SPACE = "{http://www.w3.org/1998/Math/MathML}"


def lines_of(markup_of_page: str) -> list[tuple[str, str]]:
    table = ElementTree.fromstring(markup_of_page.replace("&#x2062;", "⁢"))
    return [(one, two) for one, two in (tuple("".join(c.itertext()) for c in row) for row in table.iter(f"{SPACE}mtr"))]


def words_of(piece: str) -> str:
    return re.sub("<[^>]*>", "", piece).replace("&#x2062;", "⁢")


def wide(count: int) -> Name:
    """A name of so many digits, half an em each."""
    return named("5" * count)


def spread(pick: random.Random, count: int) -> Sum:
    return Sum(tuple((pick.choice([1, -1]), wide(pick.randint(2, 14))) for _ in range(count)))


def test_a_product_of_long_sums_loses_nothing_on_its_lines_and_each_begins_with_the_sign_of_what_it_goes_on_with() -> (
    None
):
    pick = random.Random(6)
    crossed = 0
    for _ in range(30):
        kinds = [pick.random() < 0.4 for _ in range(pick.randint(3, 9))]
        box = SideBySide(tuple(Fenced(spread(pick, 4)) if is_sum else wide(pick.randint(4, 22)) for is_sum in kinds))
        found = lines_of(display([Line(named("H"), box)]))
        assert [x for x, _ in found] == ["H"] + [""] * (len(found) - 1)
        assert found[0][1].startswith("=")
        for _, line in found[1:]:
            assert line[0] in "+−×"
            crossed += line[0] == "×"
            assert not line.startswith("×⁢")
        whole = found[0][1][1:] + "".join(line.replace("×", "⁢", 1) if line[0] == "×" else line for _, line in found[1:])
        assert whole == words_of(markup(box))
    assert crossed > 5


@pytest.mark.parametrize("seed", range(6))
def test_a_table_without_room_loses_no_word_and_is_no_wider_than_the_page(seed: int) -> None:
    pick = random.Random(seed)
    for _ in range(6):
        columns, count = pick.randint(40, 80), pick.randint(2, 4)
        heads, rows = [pick.choice(VOCABULARY) for _ in range(count)], cells(pick, 2, [False] * count, 6)
        shown = page(Table(tuple(Column(x) for x in heads), tuple(rows), ""), columns=columns)
        assert max(map(len, shown)) <= columns
        told = sorted(x.removesuffix(":") for line in shown for x in line.split() if "─" not in x)
        once = sorted(" ".join([*heads, *(" ".join(row) for row in rows)]).split())
        assert told in (once, sorted([*once, *heads]))  # in a list each row has the heads again


def test_facts_stand_beside_their_keys_while_there_is_room_and_below_them_with_less() -> None:
    told = " ".join(["word"] * 16)
    for columns, beside in ((49, True), (40, False)):
        shown = page(Facts((("k", told), ("a key that takes twenty", Code("x")))), columns=columns)
        assert (shown[0] == "  k") != beside
        assert " ".join(" ".join(shown).split()) == f"k {told} a key that takes twenty `x`"
        assert max(map(len, shown)) <= columns
