r"""Equations of an ``align*`` that stay on the page: long ones broken at their signs, long fractions in named parts."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from sympy import Expr, preorder_traversal

from haptisym.writing.boxes import Box, Fraction, Sum
from haptisym.writing.document import Line
from haptisym.writing.texprinter import RELATIONS, formula, tex

LINE = 40.0
"""Width of a line, em: a page of A4 at 11 point with margins of 2.5 cm, and a little to spare."""


def align(rows: Sequence[Line], names: Names | None = None) -> str:
    r"""The rows as an ``align*``; nothing where all are left out.

    >>> from haptisym.kernel.symbols import s, symbols
    >>> from haptisym.writing.names import named
    >>> k, b = symbols("k b")
    >>> print(align([Line(named("H"), k + b * s)]))
    \begin{align*}
      H &= b s + k
    \end{align*}
    """
    names = Names() if names is None else names
    room = LINE - max((width(tex(row.left)) for row in rows), default=0)
    lines = [line for row in rows for line in _lines(row, room, names)]
    if not lines:
        return ""
    return "\\begin{align*}\n  " + " \\\\\n  ".join(lines) + "\n\\end{align*}"


@dataclass
class Names:
    """The numerators and denominators that were given names, so that one that occurs again is not written again."""

    given: dict[str, str] = field(default_factory=dict)

    def name(self, text: str, letter: str) -> tuple[str, bool]:
        """The name of a part, and whether it is new."""
        if text in self.given:
            return self.given[text], False
        count = sum(name.startswith(rf"\mathcal{{{letter}}}") for name in self.given.values()) + 1
        self.given[text] = rf"\mathcal{{{letter}}}_{{{count}}}"
        return self.given[text], True


def is_long(value: Expr | Box, lines: int = 10) -> bool:
    """Whether a formula would take more lines than that, or holds a number that does not fit on one."""
    if isinstance(value, Expr) and sum(1 for _ in preorder_traversal(value)) > 50 * lines:
        return True
    text = formula(value) if isinstance(value, Expr) else tex(value)
    return width(text) > lines * LINE or re.search(r"\d{40}", text) is not None


def _lines(row: Line, room: float, names: Names) -> Iterator[str]:
    relation = RELATIONS.get(row.relation, row.relation)
    start = f"{tex(row.left)} &{relation} "
    is_left_out = row.optional and is_long(row.value)
    if row.meaning is not None:
        meaning = tex(row.meaning)
        start = f"{tex(row.left)} &= {meaning}"
        if not is_left_out and width(f"{meaning} = {(shown := tex(row.box))}") <= room:
            yield f"{start} {relation} {shown}"
            return
        yield start
        start = f"&{relation} "
    if not row.optional or (row.meaning is None and not is_left_out):
        yield from _equation(start, row.box, room, names, relation)


def _equation(left: str, box: Box, room: float, names: Names, relation: str) -> Iterator[str]:
    minus, quotient = ("-", box.terms[0][1]) if isinstance(box, Sum) and len(box.terms) == 1 else ("", box)
    text = tex(box)
    if not isinstance(quotient, Fraction):
        yield from _broken(left, text, room)
    elif width(text) <= room:
        yield left + text
    else:
        yield from _parted(left + minus, quotient, room, names, relation)


def _parted(left: str, quotient: Fraction, room: float, names: Names, relation: str) -> Iterator[str]:
    """A fraction whose long parts get names, and what the names stand for, as exactly as the fraction does."""
    texts = {"N": tex(quotient.above), "D": tex(quotient.below)}
    named = [
        (text, *names.name(text, x)) if width(text) > room - 2 else (text, text, False) for x, text in texts.items()
    ]
    yield rf"{left}\frac{{{named[0][1]}}}{{{named[1][1]}}}"
    for text, name, is_new in named:
        if is_new:
            yield from _broken(f"{name} &{relation} ", text, room)


def _broken(left: str, text: str, room: float) -> Iterator[str]:
    first, *others = broken(text, room)
    yield left + first
    for line in others:
        yield rf"&\quad {line}"


_BREAK = re.compile(r"(?<![-+(]) (?!\\times|\\cdot|\)|\\[bB]igr)(?<!\\times )(?<!\\cdot )")


def broken(text: str, room: float) -> list[str]:
    """A formula in lines no wider than that, broken before signs (or factors) that are not inside a fraction or root.

    >>> broken("a + b + c + d", 5.0)
    ['a + b + c', '{} + d']
    """
    pieces = _pieces(text)
    lines: list[str] = []
    while pieces:
        count = _fitting(pieces, room if not lines else room - 3)
        line = " ".join(piece for piece, _ in pieces[:count])
        lines.append(line if not lines else f"{{}} {line}" if line[0] in "+-" else rf"{{}} \times {line}")
        pieces = pieces[count:]
    return lines


def _fitting(pieces: list[tuple[str, int]], room: float) -> int:
    """How many pieces to put on a line: as many as fit, fewer if that breaks outside of parentheses."""
    total, most = 0.0, 0
    ends: list[float] = []
    for piece, _ in pieces:
        total += width(piece)
        if total > room and most:
            break
        ends.append(total)
        most += 1
    if most == len(pieces):
        return most
    candidates = [n for n in range(1, most + 1) if ends[n - 1] > room / 2] or [most]
    return min(candidates, key=lambda n: (pieces[n][1], -n))


def _pieces(text: str) -> list[tuple[str, int]]:
    """A formula cut where lines may break; each piece with a penalty for a break before it.

    The penalty is the depth of parentheses, and more between factors than before a sign.
    """
    pieces, start, penalty = [], 0, 0
    for found in _BREAK.finditer(text):
        before, after = text[: found.start()], text[found.end() :]
        if before.count("{") == before.count("}") and before.count(r"\left") == before.count(r"\right"):
            pieces.append((text[start : found.start()], penalty))
            depth = before.count("(") - before.count(")")
            is_sign, is_sum = (
                after.startswith(("+ ", "- ")),
                before.endswith(")") and after.startswith(("(", r"\b", r"\B")),
            )
            start, penalty = found.end(), depth if is_sign or is_sum else depth + 10
    return [*pieces, (text[start:], penalty)]


_TOKEN = re.compile(r"\\[A-Za-z]+|\\.|[{}^_]|\S", re.DOTALL)
_WIDTHS = {
    **dict.fromkeys("+-=<>", 1.2), **dict.fromkeys("()|.,'", 0.35), **dict.fromkeys("0123456789", 0.5),
    **dict.fromkeys("mwMWHNX", 0.85),
    r"\quad": 1.0, r"\,": 0.17, r"\cdot": 0.7, r"\times": 1.2, r"\approx": 1.3, r"\Delta": 0.85, r"\omega": 0.65,
    **dict.fromkeys((r"\left", r"\right", r"\mathrm", r"\mathcal", r"\text", r"\operatorname"), 0.0),
    **dict.fromkeys((r"\bigl", r"\bigr", r"\Bigl", r"\Bigr"), 0.1),
}  # fmt: skip


def width(text: str) -> float:
    r"""About how wide a displayed formula is, em.

    >>> width("a") < width("a + b") < width(r"\frac{a + b + c}{d}") < width("a + b + c + d")
    True
    """
    tokens = _TOKEN.findall(text)
    return _row_width(tokens, 0)[0]


def _row_width(tokens: list[str], at: int) -> tuple[float, int]:
    """The width of the tokens up to the closing brace, and the place after it."""
    total = 0.0
    while at < len(tokens) and tokens[at] != "}":
        wide, at = _item_width(tokens, at)
        total += wide
    return total, at + 1


def _item_width(tokens: list[str], at: int) -> tuple[float, int]:
    token = tokens[at]
    if token == "{":
        return _row_width(tokens, at + 1)
    if token in ("^", "_") and at + 1 < len(tokens):
        wide, after = _item_width(tokens, at + 1)
        return 0.75 * wide, after
    if token in (r"\frac", r"\tfrac"):
        above, middle = _item_width(tokens, at + 1)
        below, after = _item_width(tokens, middle)
        return (max(above, below) if token == r"\frac" else 0.7 * max(above, below)) + 0.25, after
    return _WIDTHS.get(token, 0.95 if token == r"\sqrt" else 0.6), at + 1
