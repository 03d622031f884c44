r"""A document in LaTeX, of blocks put together by hand: headings, figures, tables that go on, numbers below each other."""

from __future__ import annotations

import random
import re

import pytest
from blocks import figure
from sympy import Add, Symbol

from haptisym.kernel.symbols import s
from haptisym.writing.document import (
    Block,
    Code,
    Column,
    Document,
    Equations,
    Facts,
    Flow,
    Line,
    Notes,
    Number,
    Paragraph,
    Phrase,
    Section,
    Strong,
    Table,
    Versions,
)
from haptisym.writing.latex import fragment, latex, phrase, piece, tables
from haptisym.writing.names import named

WORDS, EQUATION = Paragraph("Words."), Equations((Line(named("H"), s + 1),))
ALIGN = "\\begin{align*}\n  H &= s + 1\n\\end{align*}"


def test_a_document_has_its_kind_above_its_title_and_knows_both() -> None:
    for kind, title, shown, told in (
        ("Evaluation", "A % b", r"Evaluation\\[1ex] \large A \% b", None), ("", "Wall (2019)", "Wall (2019)", "(Wall (2019))"),
        ("Peaks", "Wall", r"Peaks\\[1ex] \large Wall", "(Peaks: Wall)"), ("", "ω", r"\ensuremath{\omega}", "<FEFF03C9>"),
        ("", "a)b", "a)b", "<FEFF006100290062>"), ("K", "ω", r"K\\[1ex] \large \ensuremath{\omega}", "<FEFF004B003A002003C9>"),
    ):  # fmt: skip
        text = latex(Document(title, ("a source",), (WORDS,), kind))
        assert f"\\title{{{shown}}}" in text
        assert told is None or f"/Title {told} /Creator" in text
        assert text.index("\\maketitle") < text.index("a source\n\nWords.") < text.index("\\end{document}")
        assert "graphicx" not in text
    assert "\\usepackage{graphicx}\n\\allowdisplaybreaks" in latex(Document("T", (), (WORDS,)), {"one": "one.pdf"})


def test_blocks_stand_apart_and_a_display_belongs_to_the_words_before_it() -> None:
    empty = Section("", (Equations(()),))
    for blocks, text in (
        ((WORDS, WORDS), "Words.\n\nWords."), ((WORDS, EQUATION), f"Words.\n{ALIGN}"), ((EQUATION, WORDS), f"{ALIGN}\n\nWords."), ((WORDS, empty, WORDS), "Words.\n\nWords."),
        ((empty, WORDS), "Words."), ((WORDS, empty), "Words."), ((), ""), ((Notes(("one", "two")),), "one\n\ntwo"), ((Flow(("hand", "wall")),), "hand $\\to$ wall."),
    ):  # fmt: skip
        assert fragment(blocks) == text
    facts = fragment((Facts((("key", Code("x_1")), (named("k"), "2 %"))),)).split("\n")
    assert facts[1:-1] == [r"  \item[\normalfont key] \texttt{x\_1}", r"  \item[\normalfont $k$] 2 \%"]
    assert (facts[0][:19], facts[-1]) == (r"\begin{description}", r"\end{description}")


def test_sections_within_sections_have_smaller_headings_and_what_has_no_title_none() -> None:
    inner: Section = Section("D", (WORDS,))
    for title in "CBA":
        inner = Section(title, (inner,))
    text = fragment((inner,))
    assert re.findall(r"\\(\w+)\{([A-D])\}", text) == [
        ("section", "A"),
        ("subsection", "B"),
        ("paragraph", "C"),
        ("paragraph", "D"),
    ]
    assert text.endswith("\\paragraph{D}\n\nWords.")
    assert fragment((Section("", (WORDS,)),)) == "Words."
    assert fragment((Section("", (Section("B", (WORDS,)),)),)) == "\\subsection{B}\n\nWords."
    assert fragment((Section("A", (WORDS,), appendix=True),)) == "\\appendix\n\n\\section{A}\n\nWords."
    assert "appendix" not in text
    assert fragment((Section("A", (WORDS,)),), depth=1) == "\\subsection{A}\n\nWords."
    assert fragment((Section("A", ()),)) == ""


@pytest.mark.parametrize("count", range(6))
def test_figures_that_follow_each_other_stand_two_side_by_side_and_wide_ones_alone(count: int) -> None:
    own = [figure(f"f{n}") for n in range(count)]
    files = {x.name: f"{x.name}.pdf" for x in own} | {"wide": "wide.pdf"}
    text = fragment((*own, figure("wide", wide=True), figure("missing"), WORDS), files)
    groups = [re.findall(r"\]\{(\w+)\.pdf\}", x) for x in text.split(r"\begin{figure}[!htbp]")[1:]]
    assert groups == [*([f"f{n}", f"f{n + 1}"][: count - n] for n in range(0, count, 2)), ["wide"]]
    assert text.count(r"{0.48\linewidth}") == count
    assert text.count(r"{0.8\linewidth}") == 1
    assert re.findall(r"\\caption\{What (\w+) shows\}", text) == [*(f"f{n}" for n in range(count)), "wide"]
    assert text.count("\\hfill\n") == count // 2
    assert text.count(r"\begin{figure}") == text.count("\n\\end{figure}") == len(groups)
    assert "missing" not in text
    assert fragment((*own, WORDS)) == "Words."


def test_words_numbers_code_and_formulas_are_set_each_in_their_way() -> None:
    long = "1234567890" * 2 + "12345"
    for words, text in (
        (("5 % of ", named("r_r"), " is "), r"5 \% of $r_r$ is "), ("10\xa0%", r"10~\%"), (Strong(("NOT ", Number("2.5", 2.5))), r"\textbf{NOT 2.5}"),
        (Number(long, 1.0), r"12345\allowbreak{}67890\allowbreak{}12345\allowbreak{}67890\allowbreak{}12345"), (Number(long + "6", 1.0), r"12345\allowbreak 67890\allowbreak 12345\allowbreak 67890\allowbreak 12345\allowbreak 6"),
        (Code('jnd = "x"'), r"\texttt{jnd = \char34{}x\char34{}}"), (Code("a''b"), r"\texttt{a''b}"), (Code("a_b"), r"\texttt{a\_b}"),
    ):  # fmt: skip
        assert phrase(words) == text


# Tables


def table(
    *rows: tuple[Phrase, ...],
    heads: tuple[Phrase, ...] = ("h",),
    numbers: tuple[bool, ...] = (False,),
    caption: Phrase = "",
) -> str:
    return fragment((Table(tuple(Column(h, number=n) for h, n in zip(heads, numbers, strict=True)), rows, caption),))


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
        [r"\phantom{0}-100.25", "-"],
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


def test_a_row_of_several_lines_counts_as_many_of_the_32() -> None:
    """Cells of 170 characters in a column of 88 take two lines each: sixteen such rows fill a table."""
    words = " ".join(["wordy"] * 29)[:170]
    pieces = table(*((words,) for _ in range(17)), heads=("h",)).split("\n\n")
    assert [len(body(x)) for x in pieces] == [16, 1]


def columns_of(*cells: str) -> list[str]:
    text = table(tuple(cells), heads=tuple("h" for _ in cells), numbers=tuple(False for _ in cells))
    found = re.search(r"\\begin\{tabular\}\{(.*)\}\n", text)
    assert found
    return (
        found[1].split(" ")
        if "arraybackslash" not in found[1]
        else re.findall(r"l|>\{\\raggedright\\arraybackslash\}p\{[\d.]+cm\}", found[1])
    )


def test_columns_are_as_wide_as_they_are_while_a_line_of_88_characters_holds_them() -> None:
    """Between two columns lie three characters; a column that gives way is a paragraph, 0.175 cm for each of its characters."""

    def spaced(n: int) -> str:
        return ("ab " * n)[: n - 1] + "b"

    assert columns_of(spaced(88)) == ["l"]
    assert columns_of(spaced(89)) == [r">{\raggedright\arraybackslash}p{15.40cm}"]
    assert columns_of(spaced(40), spaced(45)) == ["l", "l"]
    assert columns_of(spaced(40), spaced(46)) == ["l", rf">{{\raggedright\arraybackslash}}p{{{45 * 0.175:.2f}cm}}"]
    assert columns_of("x" * 20, "y" * 24) == ["l", "l"]
    narrow = columns_of(
        *["z" * 24] * 4
    )  # words that are never torn: the widest columns give way although they do not fit
    widths = [float(x) for x in re.findall(r"p\{([\d.]+)cm\}", " ".join(narrow))]
    assert len(narrow) == 4
    assert all(w < 24 * 0.175 for w in widths)
    assert sum(round(w / 0.175) for w in widths) + 24 * narrow.count("l") == 88 - 9


def test_long_numbers_break_after_five_digits_and_so_need_less_room() -> None:
    assert columns_of("1" * 29, "x" * 24, "y" * 24) == ["l", "l", "l"]
    assert columns_of("1" * 30, "x" * 24, "y" * 24) != ["l", "l", "l"]
    pick = random.Random(1)
    for n in (24, 25, 60, 100):
        [column] = columns_of("".join(pick.choice("123456789") for _ in range(n)))
        spaces = (n - 1) // 5 if n >= 25 else 0
        assert (column == "l") == (n + spaces <= 88)


# Parts of documents


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


def test_named_parts_are_shared_by_all_equations_of_a_document() -> None:
    long = Add(*(Symbol(f"x{n}") for n in range(60))) / s
    text = fragment((Equations((Line(named("H"), long),)), Section("A", (Equations((Line(named("G"), long),)),))))
    assert text.count(r"\mathcal{N}_{1} &= ") == 1
    assert text.count(r"\frac{\mathcal{N}_{1}}{s}") == 2
