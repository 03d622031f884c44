"""Pages by laws: what a cell holds is read back from its column, and lines are as full as they may be, counted a second time."""

from __future__ import annotations

import random
import re
from html.parser import HTMLParser
from xml.etree import ElementTree

import pytest
from sympy import Add, I, Integer, Mul, Rational, Symbol, pi, symbols

from haptisym.kernel.symbols import omega, s
from haptisym.programs.program import Writer
from haptisym.writing.boxes import Box, Fraction
from haptisym.writing.code.expressions import DIALECTS, CodeReader
from haptisym.writing.code.names import Language
from haptisym.writing.document import (
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
    Section,
    Strong,
    Table,
    coded,
    listed,
)
from haptisym.writing.html import fragment
from haptisym.writing.layout import layout
from haptisym.writing.mathematics import ROOM, Parts, display
from haptisym.writing.mathtext import plain as formula_text
from haptisym.writing.names import CAPITALS, named
from haptisym.writing.plain import plain
from haptisym.writing.texlines import LINE, Names, align, broken, width
from haptisym.writing.texprinter import tex

WORDS = ("a", "of", "the", "force", "stiffness", "changes", "frequency-dependent", "10^4")


def page(*blocks: object, columns: int = 96) -> list[str]:
    """The lines of a page below its title."""
    lines = plain(Document("T", (), blocks), columns).split("\n")  # type: ignore[arg-type]
    assert lines[:2] == ["T", ""]
    assert lines[-1] == ""
    return lines[2:-1]


# Tables in text


def cells(pick: random.Random, rows: int, kinds: list[bool], most: int) -> list[tuple[str, ...]]:
    def cell(*, number: bool) -> str:
        if number:
            return pick.choice(
                ["-", f"{pick.choice(['', '-', '='])}{pick.randint(0, 9999)}{pick.choice(['', '.5', '.125'])}"]
            )
        return " ".join(pick.choice(WORDS) for _ in range(pick.randint(1, most)))

    return [tuple(cell(number=x) for x in kinds) for _ in range(rows)]


def test_a_table_with_room_has_columns_as_wide_as_their_longest_cell_and_points_below_each_other() -> None:
    pick = random.Random(4)
    for _ in range(20):
        kinds = [pick.random() < 0.5 for _ in range(pick.randint(1, 4))]
        heads, rows = [pick.choice(WORDS) for _ in kinds], cells(pick, pick.randint(1, 4), kinds, 2)
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


def test_a_table_without_room_loses_no_word_and_is_no_wider_than_the_page() -> None:
    """Columns give way from the widest on, a character at a time; where the longest words have no room rows become lists."""
    pick, lists = random.Random(9), 0
    for _ in range(40):
        columns, count = pick.randint(40, 80), pick.randint(2, 4)
        heads, rows = [pick.choice(WORDS) for _ in range(count)], cells(pick, 2, [False] * count, 6)
        shown = page(Table(tuple(Column(x) for x in heads), tuple(rows), ""), columns=columns)
        least = [
            max(max(map(len, " ".join(c).split())), min(8, max(map(len, c)))) for c in zip(heads, *rows, strict=True)
        ]
        wide, room = [max(map(len, c)) for c in zip(heads, *rows, strict=True)], columns - 2 - 3 * (count - 1)
        if sum(least) > room and sum(wide) > room:
            lists += 1
            told = "\n".join(shown).replace("\n      ", " ").replace("\n    ", " ").split("\n")
            assert told == [
                *(f"  {h}: {x}" for h, x in zip(heads, rows[0], strict=True)),
                "",
                *(f"  {h}: {x}" for h, x in zip(heads, rows[1], strict=True)),
            ]
            continue
        while sum(wide) > room:
            wide[max((w, -i) for i, (w, n) in enumerate(zip(wide, least, strict=True)) if w > n)[1] * -1] -= 1
        assert shown[[x.strip("─ ") == "" for x in shown].index(True)] == "  " + "─" * (sum(wide) + 3 * (count - 1))
        assert max(map(len, shown)) <= columns
        at = [2 + sum(wide[:i]) + 3 * i for i in range(count)]
        for i, own in enumerate(zip(heads, *rows, strict=True)):
            read = " ".join(line[at[i] : at[i] + wide[i]].strip() for line in shown if "─" not in line).split()
            assert read == " ".join(own).split()
    assert 3 < lists < 37


def test_facts_stand_beside_their_keys_while_22_columns_are_left_and_below_them_with_fewer() -> None:
    """Formulas that go on are set in by four more."""
    short, long = "k", "a key that takes twenty"
    told = " ".join(["word"] * 16)
    assert page(Facts(((short, "one"), (long, "two"))), columns=96) == [
        f"  {short.ljust(len(long))}  one",
        f"  {long}  two",
    ]
    for columns in (48, 49):
        shown = page(Facts(((short, told), (long, Code("x")))), columns=columns)
        after = 2 + len(long) + 2
        if columns - after >= 22:
            assert shown[0].startswith(f"  {short.ljust(len(long))}  word")
            assert all(x.startswith(" " * after + "word") for x in shown[1:-1])
            assert shown[-1] == f"  {long}  `x`"
        else:
            assert shown[0] == f"  {short}"
            assert all(x.startswith("      word") for x in shown[1:-2])
            assert shown[-2:] == [f"  {long}", "      `x`"]
        assert max(map(len, shown)) <= columns
    formula = layout(Add(*symbols("first second third fourth fifth sixth seventh eighth ninth tenth")))
    below = page(Facts((("F", formula),)), columns=40)
    assert len(below) > 1
    assert all(x.startswith(" " * 9) and x[9] != " " for x in below[1:])


def test_a_table_without_rows_is_its_head() -> None:
    shown = page(Table((Column("h"), Column("mass", number=True)), (), ""), columns=80)
    assert [x.split() for x in shown if "h" in x.split()] == [["h", "mass"]]


def test_blocks_stand_apart_but_for_lists_that_follow_lists() -> None:
    one, two = Notes(("first", "second")), Facts((("k", "v"),))
    equation = Equations((Line(named("H"), s),))
    text, table = Paragraph("words"), Table((Column("h"),), (("x",),), "")
    shown = page(
        text,
        one,
        two,
        equation,
        text,
        table,
        Section("Title", (one, text)),
        Section("Other", (text,)),
        Section("", (one,)),
    )
    assert shown == [
        "words", "", "first", "second", "  k  v", "    H = s", "", "words", "", "  h", "  ─", "  x", "",
        "Title", "  first", "  second", "", "  words", "", "Other", "", "  words", "", "first", "second",
    ]  # fmt: skip
    assert page(Flow(("hand", "filter", "wall"))) == ["hand → filter → wall"]
    assert page(Paragraph(("5 % of ", Strong(("all ", Number("2.5", 2.5))), ", ", Code("cmd")))) == [
        "5 % of all 2.5, `cmd`"
    ]
    assert max(map(len, page(Paragraph("5 % " * 60), columns=43))) <= 43
    assert all(not x.startswith("%") for x in page(Paragraph("5 % " * 60), columns=43))


def test_phrases_in_a_row_and_code_between_backticks() -> None:
    assert [listed(x) for x in (["a"], ["a", "b"], ["a", "b", "c"])] == [
        ("a",),
        ("a", " and ", "b"),
        ("a", ", ", "b", " and ", "c"),
    ]
    assert listed(["a", "b"], "or") == ("a", " or ", "b")
    assert coded("run `x` or `y`") == ("run ", Code("x"), " or ", Code("y"))
    assert coded("`x`") == (Code("x"),)


# Tables in HTML


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
    return Cells(fragment(Document("T", (), (table,)))).rows


def test_long_cells_are_set_on_several_lines_and_in_a_full_table_shorter_ones_too() -> None:
    """More than 34 characters; in a row of more than 90, where such a column counts 24, more than 18."""
    for lengths in (
        [34, 5],
        [35, 5],
        [34, 34, 22],
        [34, 34, 23],
        [35, 34, 32],
        [35, 34, 33],
        [18, 19, 34, 34],
        [40, 40, 40, 18],
        [40, 40, 40, 19],
    ):
        counted = sum(24 if n > 34 else n for n in lengths)
        most = 34 if counted <= 90 else 18
        rows = html_rows(
            Table(tuple(Column("h") for _ in lengths), (tuple("x" * n for n in lengths), ("",) * len(lengths)), "")
        )
        expected = ["words" if n > 34 else "words tight" if n > most else "" for n in lengths]
        assert [[kind for kind, _ in row] for row in rows] == [expected] * 3, lengths
    assert html_rows(Table((Column("h", number=True), Column("y" * 40)), (("1", "x"),), ""))[1] == [
        ["number", "1"],
        ["", "x"],
    ]


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
    long = fragment(Document("T", (), (Paragraph(Number("1" * 26, 1.0)), Paragraph(Number("1" * 25, 1.0)))))
    assert long.count('class="long"') == 1


# Formulas on lines


def spread(pick: random.Random, count: int) -> list[Symbol]:
    """Symbols of many widths, in the order in which a sum has them."""
    names = sorted({"".join(pick.choice("abcfghm") for _ in range(pick.randint(1, 6))) + "x" for _ in range(count)})
    return [Symbol(x) for x in names]


def rows_of(markup: str) -> list[tuple[str, str]]:
    """The text of both cells of each line."""
    table = ElementTree.fromstring(markup.replace("&#x2062;", "⁢"))
    return [
        tuple("".join(cell.itertext()) for cell in row) for row in table.iter("{http://www.w3.org/1998/Math/MathML}mtr")
    ]  # type: ignore[misc]


def test_a_long_sum_fills_its_lines_up_to_the_page_and_breaks_before_signs() -> None:
    pick = random.Random(2)
    for _ in range(8):
        left, value = named(pick.choice(["H", "H_perc"])), Add(*spread(pick, pick.randint(2, 40)))
        box = layout(value)
        widths = [width(tex(x)) + (1.2 if i else 0) for i, (_, x) in enumerate(box.terms)]  # type: ignore[union-attr]
        room, lines = ROOM - width(tex(left)), [0]
        whole = width(tex(box)) <= room
        if whole:
            lines = [len(widths)]
        else:
            total, here = 0.0, room
            for w in widths:
                if lines[-1] and total + w > here:
                    lines.append(0)
                    total, here = 0.0, room - 3
                lines[-1] += 1
                total += w
        rows = rows_of(display([Line(left, value)]))
        assert [
            1 + text[1:].count("+") - text[1:].count("=+") if i == 0 else text.count("+")
            for i, (_, text) in enumerate(rows)
        ] == lines
        assert [bool(x) for x, _ in rows] == [True] + [False] * (len(rows) - 1)
        assert "".join(text for _, text in rows) == "=" + "".join(
            rows_of(display([Line(left, box)]))[i][1][i == 0 :] for i in range(len(rows))
        )


def test_a_meaning_shares_the_line_with_its_value_while_there_is_room() -> None:
    left, meaning = named("H"), named("G")
    seen = set()
    for n in range(1, 100, 3):
        value = Symbol("a" * n) * s
        fits = width(tex(meaning)) + width(tex(layout(value))) <= ROOM - width(tex(left))
        seen.add(fits)
        rows = rows_of(display([Line(left, value, "≈", meaning)]))
        assert (len(rows) == 1) == fits
        assert [x for x, _ in rows] == ["H", *[""] * (len(rows) - 1)]
        assert rows[0][1].startswith("=G≈") if fits else (rows[0][1], rows[1][1][0]) == ("=G", "≈")
        room = LINE - width("H")
        text = align([Line(left, value, "≈", meaning)])
        one = width(f"G = {tex(layout(value))}") <= room
        assert (text.count(r" \\") == 0) == one
    assert seen == {True, False}


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


@pytest.mark.parametrize(("above", "below"), [(60, 2), (2, 60), (60, 60), (60, 50)])
def test_long_parts_of_a_fraction_get_names_that_are_used_again(above: int, below: int) -> None:
    top, bottom = (Add(*(Symbol(f"{letter}{i}") for i in range(n))) for letter, n in (("p", above), ("q", below)))
    box = Fraction(layout(top), layout(bottom))
    parts, names = Parts(), Names()
    named_parts = (above > 40, below > 40)
    for again in (False, True):
        for sign in (1, -1):
            shown: Box = box if sign > 0 else layout(-top / bottom)
            rows = rows_of(display([Line(named("H"), shown)], parts))
            lines = align([Line(named("H"), shown)], names)
            fresh = not again and sign > 0
            assert rows[0][0] == "H"
            assert rows[0][1].startswith("=" if sign > 0 else "=−")
            for letter, tex_letter, is_long in (
                ("𝒩", r"\mathcal{N}_{1}", named_parts[0]),
                ("𝒟", r"\mathcal{D}_{1}", named_parts[1]),
            ):
                assert (letter in rows[0][1]) == is_long
                assert [x for x, _ in rows].count(f"{letter}1") == (is_long and fresh)
                assert (tex_letter in lines.split("\\\\")[0]) == is_long
                assert lines.count(rf"{tex_letter} &= ") == (is_long and fresh)
    other = rows_of(display([Line(named("H"), Fraction(layout(top + s), layout(bottom + s)))], parts))
    assert ("𝒩2" in other[0][1], "𝒟2" in other[0][1]) == named_parts


def test_a_line_of_latex_is_broken_where_the_fewest_parentheses_are_open() -> None:
    """Of the breaks in the line's second half that fit; a sign rather than between factors, the last of the best."""
    pick = random.Random(5)
    for _ in range(30):
        pieces, text, depth = [], "", 0
        for i in range(pick.randint(4, 14)):
            sign = i > 0 and pick.random() < 0.8
            word = f"{'+ ' if sign else ''}{pick.choice(['a', 'bb', 'ccc'])}"
            penalty = depth + (0 if sign else 10) if i else 0
            if sign and pick.random() < 0.3:
                word, depth = word.replace("+ ", "+ ("), depth + 1
            elif depth and pick.random() < 0.5:
                word, depth = word + ")", depth - 1
            if i and pieces[-1][0].endswith("("):
                continue
            pieces.append((word, penalty))
        text = " ".join(word for word, _ in pieces)
        room, expected, left = pick.choice([4.0, 6.0, 9.0]), [], pieces
        while left:
            here = room - 3 if expected else room
            sums = [sum(width(w) for w, _ in left[: n + 1]) for n in range(len(left))]
            fit = max(1, sum(x <= here for x in sums))
            if fit < len(left):
                late = [n for n in range(1, fit + 1) if sums[n - 1] > here / 2] or [fit]
                fit = min(late, key=lambda n: (left[n][1], -n))
            line = " ".join(w for w, _ in left[:fit])
            expected.append(line if not expected else f"{{}} {line}" if line[0] in "+-" else rf"{{}} \times {line}")
            left = left[fit:]
        assert broken(text, room) == expected


# Terms in order


def test_a_sum_descends_in_powers_and_ascends_where_that_avoids_a_minus_in_front() -> None:
    pick, letters = random.Random(7), symbols("a b c d")
    for variable, shown in ((s, "s"), (omega, "omega")):
        for _ in range(30):
            powers = sorted(pick.sample(range(4), pick.randint(2, 4)), reverse=True)
            signs = [pick.choice([1, -1]) for _ in powers]
            value = Add(*(sign * letters[n] * variable**n for n, sign in zip(powers, signs, strict=True)))
            terms = [
                (sign, " ".join([str(letters[n]), *([shown if n == 1 else f"{shown}^{n}"] if n else [])]))
                for n, sign in zip(powers, signs, strict=True)
            ]
            if signs[0] < 0 and not all(x < 0 for x in signs) and signs[-1] > 0:
                terms.reverse()
            text = (
                ("-" if terms[0][0] < 0 else "")
                + terms[0][1]
                + "".join(f" {'-' if sign < 0 else '+'} {x}" for sign, x in terms[1:])
            )
            assert formula_text(value) == text


@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        (Symbol("k") * s - Symbol("a") - Symbol("b"), "k s - a - b"),
        (Symbol("k") * s + Symbol("a") + Symbol("b"), "k s + a + b"),
        (-(Symbol("a") + Symbol("b")) * s + Symbol("k"), "k - (a + b) s"),
        (Rational(2, 9) * pi / Symbol("x"), "2 pi/(9 x)"),
        (Rational(2, 10) * pi / Symbol("x"), "pi/(5 x)"),
        (Rational(3, 10) * pi / Symbol("x"), "0.3 pi/x"),
        (pi / (10 * Symbol("x")), "pi/(10 x)"),
        ((Symbol("a") - Symbol("b")) * (Symbol("c") - s), "(a - b) (c - s)"),
        (-(Symbol("a") - Symbol("b")) * Symbol("k"), "k (b - a)"),
        (-(Symbol("a") - Symbol("b")) ** 2 * Symbol("k"), "-k (a - b)^2"),
        (-(Symbol("a") + Symbol("b")) * Symbol("k"), "-k (a + b)"),
        (I * Symbol("omega_n") * Symbol("b") * omega, "b omega_n omega j"),
        (Symbol("X") * Symbol("b") * 3, "3 X b"),
    ],
)  # fmt: skip
def test_factors_and_signs_stand_where_a_person_writes_them(expression: Mul, expected: str) -> None:
    assert formula_text(expression) == expected


# Code


@pytest.mark.parametrize("language", list(Language))
def test_a_number_in_code_has_the_digits_of_its_opposite_and_stands_first_in_a_product(language: Language) -> None:
    a, b = symbols("a b")

    def written(value: object) -> str:
        write = Writer((a, b))
        program = write.program({"y": write.expression(value)})
        return CodeReader(program, {"a", "b"}, dialect=DIALECTS[language], names={a: "a", b: "b"}).results()["y"].text

    for number in (Integer(7), Integer(10) ** 14, Integer(10) ** 15, Integer(10) ** 16, Rational(1, 3), Rational(7, 2)):
        assert written(-number) == "-" + written(number)
        whole = DIALECTS[language].whole and number.is_Integer and number < 10**15
        assert written(number) == (str(number) if whole else repr(float(number)))
    times, seven = DIALECTS[language].times, written(Integer(7))
    assert written(-7 * a * b) in (f"-{seven}{times}a{times}b", f"-{seven}{times}b{times}a")


def test_a_name_is_a_letter_with_what_follows_it_below() -> None:
    """Greek capitals are letters, however many Latin ones they are spelt with; two Latin ones are a letter and what it is of."""
    for head in (*CAPITALS, "omega", "k", "zeta"):
        for digits in ("", "2", "13"):
            for below in ([], ["n"], ["n", "3"]):
                name = named("_".join([head + digits, *below]))
                assert name.head.letters == head
                assert [x.letters for x in name.below] == [*([digits] if digits else []), *below]
    for text, head, below in (
        ("Mm", "M", ["m"]),
        ("Ks_2", "K", ["s", "2"]),
        ("force", "F", []),
        ("amplitude_n", "A", ["n"]),
        ("_", "_", []),
    ):
        assert (named(text).head.letters, [x.letters for x in named(text).below]) == (head, below)
