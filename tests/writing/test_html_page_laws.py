"""A page of HTML, and a piece of one for notebooks, of blocks put together by hand."""

from __future__ import annotations

import re

from blocks import figure
from sympy import Symbol

from haptisym.kernel.symbols import s
from haptisym.writing.boxes import Numeral
from haptisym.writing.document import (
    Block,
    Code,
    Column,
    Document,
    Equations,
    Facts,
    Flow,
    Line,
    Live,
    Notes,
    Number,
    Paragraph,
    Phrase,
    Section,
    Strong,
    Table,
    Versions,
)
from haptisym.writing.html import fragment, html, phrase
from haptisym.writing.htmltext import Html, data, element, joined, script
from haptisym.writing.names import named

WORDS, LIVE = Paragraph("Words."), Live(lambda: "<i>live</i>")


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


def test_headings_go_down_to_the_sixth_and_sections_with_a_name_are_elements_of_it() -> None:
    block: Block = WORDS
    for title in "GFEDCBA":
        block = Section(title, (block,))
    assert re.findall(r"<h(\d)>(\w)</h\d>", inside(block)) == [
        ("2", "A"),
        ("3", "B"),
        ("4", "C"),
        ("5", "D"),
        ("6", "E"),
        ("6", "F"),
        ("6", "G"),
    ]
    assert inside(Section("A", (WORDS,), "a")) == '<section id="a"><h2>A</h2><p>Words.</p></section>'
    assert inside(Section("A", (WORDS,))) == "<h2>A</h2><p>Words.</p>"
    assert inside(Section("", (WORDS,), "a")) == "<p>Words.</p>"
    assert inside(Section("", (Section("B", (WORDS,)),))) == "<h3>B</h3><p>Words.</p>"


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
    full = inside(Table((Column("h", full=True),), (("x",),), ""))
    assert full.count('class="words"') == 2


def test_in_a_notebook_a_document_is_one_element_in_brief() -> None:
    document = Document(
        "A < B",
        ("from there",),
        (WORDS, figure("f"), LIVE, Versions((Paragraph("brief"),), lambda: (Paragraph("full"),))),
        "Kind",
    )
    assert (
        fragment(document)
        == '<div class="haptisym"><p><strong>A &lt; B</strong></p><p>from there</p><p>Words.</p><p>brief</p></div>'
    )


def test_named_parts_of_fractions_are_shared_by_all_equations_of_a_page() -> None:
    long = sum((Symbol(f"x{n}") for n in range(60)), Symbol("y")) / s
    block = Equations((Line(named("H"), long),))
    text = inside(block, Section("A", (block,)))
    assert text.count('<mtd style="text-align: left"><msub><mi mathvariant="normal">𝒩') <= 1
    assert text.count("𝒩") == 3  # used twice, defined once


def test_numbers_of_html_have_their_double_and_long_ones_may_be_broken() -> None:
    for digits in (25, 26):
        shown = phrase(Number("1" * digits, 0.1))
        assert shown.startswith('<data value="0.1">')
        assert ('<span class="long">' in shown) == (digits > 25)
    assert phrase(("a", Code("<b>"), named("k"))).startswith("a<code>&lt;b&gt;</code><math")
    told: Phrase = Numeral("3")
    assert "<mn>3</mn>" in phrase(told)


def test_text_is_escaped_and_nothing_ends_a_script() -> None:
    assert joined(["<", Html("<b>"), "&"], ", ") == "&lt;, <b>, &amp;"
    assert joined(["a", "b"], "<") == "a&lt;b"
    assert element("br") == "<br>"
    assert element("p") == "<p></p>"
    assert (
        element("p", "\x00\ud800\tx\n\uffff", given={"title": "\x01"})
        == '<p title="\ufffd">\ufffd\ufffd\tx\n\ufffd</p>'
    )
    assert "</script" not in script("x</script><!--y").removesuffix("</script>")
    assert data("</script><!--", "i") == '<script type="application/json" id="i">\\u003c/script>\\u003c!--</script>'
    assert script("1", {"id": "i"}) == '<script id="i">1</script>'
