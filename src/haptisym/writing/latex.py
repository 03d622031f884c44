"""A document in LaTeX, for pdflatex with article, amsmath and booktabs (graphicx for figures);
plain ASCII.

From the letter up: text and names, formulas, equations of an ``align*`` that stay on the page (long
ones broken at their signs, long fractions in named parts), phrases, blocks, documents.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import singledispatchmethod
from itertools import accumulate, groupby, pairwise, zip_longest
from types import MappingProxyType
from typing import Any

from sympy import Basic, Expr, preorder_traversal

from haptisym.kernel.names import CAPITALS, GREEK, greek
from haptisym.writing import boxes
from haptisym.writing import document as doc
from haptisym.writing.boxes import Box
from haptisym.writing.document import Block, Document, Phrase, Strong
from haptisym.writing.layout import layout, named
from haptisym.writing.plain import NUMBER, said, widths_of

_SPECIAL = {
    "\\": r"\textbackslash{}",
    "{": r"\{",
    "}": r"\}",
    "$": r"\$",
    "&": r"\&",
    "#": r"\#",
    "%": r"\%",
    "_": r"\_",
    "^": r"\textasciicircum{}",
    "~": r"\textasciitilde{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "|": r"\textbar{}",
    '"': "''",
    "`": r"\`{}",
    "–": r"\textendash{}",
    "—": r"\textemdash{}",
    "‘": "`{}",
    "’": "'",
    "“": "``{}",
    "”": "''{}",
    "„": ",,",
    "«": r"\ensuremath{\ll}",
    "»": r"\ensuremath{\gg}",
    "…": r"\dots{}",
    "ß": r"\ss{}",
    "æ": r"\ae{}",
    "Æ": r"\AE{}",
    "œ": r"\oe{}",
    "Œ": r"\OE{}",
    "ø": r"\o{}",
    "Ø": r"\O{}",
    "ł": r"\l{}",
    "Ł": r"\L{}",
    "ı": r"\i{}",
    "ȷ": r"\j{}",
    "§": r"\S{}",
    "¶": r"\P{}",
    "©": r"\copyright{}",
    "£": r"\pounds{}",
    "đ": "d",
    "Đ": "D",
    "ð": "d",
    "Ð": "D",
    "þ": "th",
    "Þ": "Th",
    "€": "EUR",
    "†": r"\dag{}",
}
_MATH = {
    "°": r"^{\circ}",
    "±": r"\pm",
    "∓": r"\mp",
    "×": r"\times",
    "·": r"\cdot",
    "⋅": r"\cdot",
    "−": "-",
    "÷": r"\div",
    "≤": r"\le",
    "≥": r"\ge",
    "≠": r"\ne",
    "≈": r"\approx",
    "≡": r"\equiv",
    "∞": r"\infty",
    "√": r"\surd",
    "∂": r"\partial",
    "∫": r"\int",
    "∑": r"\sum",
    "∏": r"\prod",
    "∆": r"\Delta",
    "Ω": r"\Omega",
    "ℜ": r"\Re",
    "ℑ": r"\Im",
    "∠": r"\angle",
    "→": r"\to",
    "←": r"\leftarrow",
    "↔": r"\leftrightarrow",
    "⇒": r"\Rightarrow",
    "∈": r"\in",
    "µ": r"\mu",
    "¬": r"\neg",
    "ϵ": r"\epsilon",
    "ϕ": r"\phi",
    "φ": r"\varphi",
    "ε": r"\varepsilon",
    "ς": r"\varsigma",
    "′": "'",
    "″": "''",
}
_ACCENTS = {
    "\u0300": "`",
    "\u0301": "'",
    "\u0302": "^",
    "\u0303": "~",
    "\u0304": "=",
    "\u0306": "u",
    "\u0307": ".",
    "\u0308": '"',
    "\u030a": "r",
    "\u030b": "H",
    "\u030c": "v",
    "\u0323": "d",
    "\u0327": "c",
    "\u0331": "b",
}
_SIGNS = {"∞": r"\infty"}
_NEGATIVE, _MINUS = re.compile(r"(?<![\w.})-])-(?=\.?\d)"), r"\\ensuremath{-}"
_POWER, _TIMES = (
    re.compile(r"(?<![\w.])(\d[\d.]*)e(-?)\+?0*(\d+)(?!\w)"),
    r"\\ensuremath{\1\\times10^{\2\3}}",
)
_LONG_WORD = 20  # letters; a longer one gets places to break
_BREAK = re.compile(r"\d{5}(?=\d{5})|[^\W_]{5}(?=[^\W_]{20})|[^\w\s](?=\w)|_(?=[^\W_])")


def escape(text: str) -> str:
    r"""Any text for pdflatex: special characters, accents, Greek, signs and subscripts; what it
    lacks, by code point.

    Long words get places to break. A letter that the font lacks loses its mark (ę is e).

    >>> escape("50% of ω₀_x é"), escape("中")
    ("50\\% of \\ensuremath{\\omega}\\textsubscript{0}\\_x \\'{e}", '[U+4E2D]\\allowbreak{}')
    """
    # A null character marks where a line may break; those of the text itself become spaces first.
    words = text.replace("\0", " ").split()
    marked = " ".join(
        _BREAK.sub(r"\g<0>\0", word) if len(word) > _LONG_WORD else word for word in words
    )
    # TeX makes a dash of two hyphens, and options of a command line have two.
    return re.sub("-(?=-)", "-{}", _escaped(marked))


def _escaped(text: str) -> str:
    """Each character of a text for pdflatex; accents and letters are composed first, so that one
    command sets both."""
    return "".join(
        r"\allowbreak{}" if c == "\0" else _character(c) for c in unicodedata.normalize("NFC", text)
    )


def _character(c: str) -> str:
    """One character for pdflatex: by itself, by a command, or by what Unicode decomposes it to."""
    if c in _SPECIAL:
        return _SPECIAL[c]
    if c.isascii():
        return c if c.isprintable() else " "
    if c in _MATH or greek(c):
        return rf"\ensuremath{{{_MATH.get(c) or _word(named(c).head)}}}"
    kind, _, plain = unicodedata.decomposition(c).rpartition("> ")
    if kind in ("<sub", "<super"):
        letters = "".join(_character(chr(int(code, 16))) for code in plain.split())
        return rf"\text{'subscript' if kind == '<sub' else 'superscript'}{{{letters}}}"
    if kind == "<fraction":
        above, below = unicodedata.normalize("NFKD", c).split("\N{FRACTION SLASH}")
        return rf"\textsuperscript{{{above}}}/\textsubscript{{{below}}}"
    return _accented(c)


def _accented(c: str) -> str:
    """A letter with an accent; without one that TeX lacks; the code point of any other
    character."""
    base, *marks = list(unicodedata.normalize("NFKD", c))
    if not base.isascii():
        if unicodedata.combining(base):
            return ""
        return " " if base.isspace() else rf"[U+{ord(c):04X}]\allowbreak{{}}"
    if len(marks) == 1 and marks[0] in _ACCENTS and base.isalpha():
        # The dot of i and j gives way to the accent: \i and \j have none.
        dotless = "\\" if base in "ij" else ""
        return rf"\{_ACCENTS[marks[0]]}{{{dotless}{base}}}"
    return "".join(map(_character, [base, *(mark for mark in marks if mark.isascii())]))


def coded(words: str) -> str:
    r"""Words in which what stands between backticks is code.

    >>> coded("5 % more: see `x_1`.")
    '5 \\% more: see \\texttt{x\\_1}.'
    """
    return "".join(
        rf"\texttt{{{escape(x)}}}" if i % 2 else spaced(x) for i, x in enumerate(words.split("`"))
    )


def spaced(words: str) -> str:
    r"""Words in LaTeX, with a space at their ends where they have one; a negative number has a
    minus sign, not a hyphen; a power of ten is set as one.

    >>> spaced("from -1.5 to 2e-3 ")
    'from \\ensuremath{-}1.5 to \\ensuremath{2\\times10^{-3}} '
    """
    before, after = (" " if x.isspace() else "" for x in (words[:1], words[-1:]))
    return f"{before}{_POWER.sub(_TIMES, _NEGATIVE.sub(_MINUS, escape(words)))}{after}"


def set_name(name: boxes.Name) -> str:
    r"""Return a name in LaTeX; several letters stand upright.

    >>> set_name(named("omega_n")), set_name(named("omega_n_filter")), set_name(named("k1"))
    ('\\omega_n', '\\omega_{n,\\mathrm{filter}}', 'k_1')
    >>> set_name(named("xdot")), set_name(named(r"\mu_{hand}")), set_name(named("k'"))
    ('\\dot{x}', '\\mu_{\\mathrm{hand}}', "k'")
    """
    head, subscript = _word(name.head), ",".join(map(_word, name.below))
    if not subscript:
        return head
    # A prime is a superscript: a power behind the subscript would be a second one.
    head = f"{{{head}}}" if head.endswith("'") else head
    is_plain = len(subscript) == 1 or subscript[1:].isalpha()
    return f"{head}_{subscript}" if is_plain else f"{head}_{{{subscript}}}"


def _word(word: boxes.Word) -> str:
    """A part of a name in LaTeX."""
    letters = word.letters
    if marked := _MARKED.fullmatch(letters):
        base = _word(boxes.Word(marked[1], upright=False))
        return f"{base}{marked[3]}" if marked[3] else rf"\{marked[2]}{{{base}}}"
    # Omicron looks like o, so LaTeX has no command for it.
    if letters in GREEK or letters in CAPITALS:
        return "o" if letters == "omicron" else rf"\{letters}"
    if letters.isascii() and letters.replace(" ", "").isalnum():
        return rf"\mathrm{{{letters}}}".replace(" ", r"\,") if word.upright else letters
    return _SIGNS.get(letters) or rf"\text{{{_escaped(letters)}}}"


# A letter with what SymPy reads as a mark over it, as xdot, or with primes, as k'.
_MARKED = re.compile(
    rf"([A-Za-z]|{'|'.join((*GREEK, *CAPITALS))})(?:(d?dot|hat|bar|tilde|vec)|('+))"
)
_OPERATORS = re.compile("(arc)?(sin|cos|tan)|(sin|cos|tan|cot)h?|ln|max|min")
RELATIONS = {"≈": r"\approx", "≠": r"\ne", "≤": r"\le", "≥": r"\ge"}


def formula(expression: Basic) -> str:
    r"""A SymPy expression as LaTeX.

    >>> from haptisym.kernel.rings import omega, symbols
    >>> m, k = symbols("m k")
    >>> formula(k - m * omega**2)
    'k - m \\omega^{2}'
    """
    return tex(layout(expression))


def tex(box: Box) -> str:
    """LaTeX of a box."""
    return boxes.formed(box, _TEX)


def _numeral(x: boxes.Numeral) -> str:
    power = f"10^{{{x.exponent}}}"
    if not x.exponent:
        return x.digits
    return power if x.digits == "1" else rf"{x.digits} \times {power}"


def _product(x: boxes.SideBySide) -> str:
    parts = [tex(x.factors[0])]
    for left, right in pairwise(x.factors):
        sign = (
            r" \cdot "
            if boxes.needs_dot(left, right)
            else r" \, "
            if isinstance(right, boxes.Prefixed)
            else " "
        )
        parts.append(sign + tex(right))
    return "".join(parts)


def _power(x: boxes.Power) -> str:
    exponent = (
        f"{x.exponent.above}/{x.exponent.below}"
        if isinstance(x.exponent, boxes.Ratio)
        else tex(x.exponent)
    )
    if isinstance(x.base, boxes.Applied):
        return f"{tex(x.base.function)}^{{{exponent}}}{_arguments(x.base)}"
    return f"{tex(x.base)}^{{{exponent}}}"


def _arguments(x: boxes.Applied) -> str:
    return parenthesised(", ".join(map(tex, x.arguments)))


_TEX: Mapping[type, Callable[[Any], str]] = {
    boxes.Numeral: _numeral,
    boxes.Ratio: lambda x: rf"\tfrac{{{x.above}}}{{{x.below}}}",
    boxes.Name: lambda x: set_name(x),
    boxes.Operator: lambda x: (
        rf"\{x.name}" if _OPERATORS.fullmatch(x.name) else rf"\operatorname{{{x.name}}}"
    ),
    boxes.Sum: lambda x: boxes.signed(x.terms, tex),
    boxes.SideBySide: _product,
    boxes.Fraction: lambda x: rf"\frac{{{tex(x.above)}}}{{{tex(x.below)}}}",
    boxes.Power: _power,
    boxes.Radical: lambda x: rf"\sqrt{{{tex(x.inside)}}}",
    boxes.Exponential: lambda x: f"e^{{{tex(x.exponent)}}}",
    boxes.Applied: lambda x: tex(x.function) + _arguments(x),
    boxes.Series: lambda x: (
        rf"\sum_{{{tex(x.index)}={tex(x.first)}}}^{{{tex(x.last)}}} {tex(x.term)}"
    ),
    boxes.Prefixed: lambda x: f"{tex(x.operator)} {tex(x.operand)}",
    boxes.Fenced: lambda x: parenthesised(tex(x.inside)),
    boxes.Absolute: lambda x: rf"\left| {tex(x.inside)} \right|",
    boxes.MatrixBox: lambda x: (
        r"\begin{pmatrix} "
        + r" \\ ".join(" & ".join(map(tex, row)) for row in x.rows)
        + r" \end{pmatrix}"
    ),
    boxes.Titled: lambda x: tex(x.inside),
    boxes.Relation: lambda x: boxes.related(x, tex, RELATIONS),
}


def parenthesised(text: str) -> str:
    """Parentheses: of one size, so that lines can break inside, except around tall formulas."""
    if any(tall in text for tall in (r"\frac", r"\sqrt", r"\left", r"\begin")):
        return rf"\left( {text} \right)"
    if r"\bigl" in text:
        return rf"\Bigl( {text} \Bigr)"
    return rf"\bigl( {text} \bigr)" if "(" in text else f"({text})"


LINE = 40.0
"""Width of a line, em: a page of A4 at 11 point with margins of 2.5 cm, and a little to spare."""


def align(rows: Sequence[doc.Line], names: Names | None = None) -> str:
    r"""The rows as an ``align*``; nothing where all are left out.

    >>> from haptisym.kernel.rings import s, symbols
    >>> from haptisym.writing.document import Line
    >>> from haptisym.writing.layout import named
    >>> k, b = symbols("k b")
    >>> print(align([Line(named("H"), k + b * s)]))
    \begin{align*}
      H &= b s + k
    \end{align*}
    """
    names = Names() if names is None else names
    # The relations stand below each other, so the widest left side takes its room from all lines.
    room = LINE - max((width(tex(row.left)) for row in rows), default=0)
    lines = [line for row in rows for line in _lines(row, room, names)]
    if not lines:
        return ""
    if len(lines) == len(rows) >= _MANY and all(width(x) < LINE / 2 - _BETWEEN for x in lines):
        lines = _in_two_columns(lines)
    return "\\begin{align*}\n  " + " \\\\\n  ".join(lines) + "\n\\end{align*}"


_MANY = 6
"""Equations of one line each from which on they stand in two columns, where they are short."""
_BETWEEN = 3.0  # em between the columns


def _in_two_columns(lines: Sequence[str]) -> list[str]:
    """Equations in two columns, read downwards."""
    half = -(-len(lines) // 2)
    return [" & ".join(pair) for pair in zip_longest(lines[:half], lines[half:], fillvalue="&")]


@dataclass
class Names:
    """The numerators and denominators that were given names, so that one that occurs again is not
    written again."""

    given: dict[str, str] = field(default_factory=dict)

    def name(self, text: str, letter: str) -> tuple[str, bool]:
        """The name of a part, and whether it is new."""
        if text in self.given:
            return self.given[text], False
        count = sum(name.startswith(rf"\mathcal{{{letter}}}") for name in self.given.values()) + 1
        self.given[text] = rf"\mathcal{{{letter}}}_{{{count}}}"
        return self.given[text], True


def is_long(value: Expr | Box, lines: int = 10) -> bool:
    """Whether a formula would take more lines than that, or holds a number that does not fit on
    one."""
    # So many nodes are more lines than that; to set them only to see it would take long.
    if isinstance(value, Expr) and sum(1 for _ in preorder_traversal(value)) > 50 * lines:
        return True
    text = formula(value) if isinstance(value, Expr) else tex(value)
    return width(text) > lines * LINE or re.search(r"\d{40}", text) is not None


def _lines(row: doc.Line, room: float, names: Names) -> Iterator[str]:
    """The lines of a row: name, meaning and value on one where they fit, else the value below."""
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
    """An equation, and what the names stand for that long parts of its fractions get, as exactly as
    the fractions do."""
    text = tex(box)
    meant: list[tuple[str, str]] = []
    terms = [x for _, x in box.terms] if isinstance(box, boxes.Sum) else [box]
    # Terms after the first start on lines that are set in by 3 em and begin with a sign.
    is_sum = len(terms) > 1
    for term in terms:
        shown = tex(term)
        wide = width(shown if is_sum else text)
        # Lines cannot break inside a fraction: one that is too wide needs names for its parts.
        if isinstance(term, boxes.Fraction) and wide > room - 3 * is_sum:
            parts = []
            for letter, part in (("N", tex(term.above)), ("D", tex(term.below))):
                name, is_new = names.name(part, letter) if width(part) > room - 2 else (part, False)
                parts.append(name)
                meant += [(name, part)] * is_new
            text = text.replace(shown, rf"\frac{{{parts[0]}}}{{{parts[1]}}}", 1)
    yield from _broken(left, text, room)
    for name, part in meant:
        yield from _broken(f"{name} &{relation} ", part, room)


def _broken(left: str, text: str, room: float) -> Iterator[str]:
    """A formula after its left side; further lines are set in."""
    first, *others = broken(text, room)
    yield left + first
    for line in others:
        yield rf"&\quad {line}"


_BREAK_TEXLINES = re.compile(r"(?<![-+(]) (?!\\times|\\cdot|\)|\\[bB]igr)(?<!\\times )(?<!\\cdot )")


def broken(text: str, room: float) -> list[str]:
    """A formula in lines no wider than that, broken before signs (or factors) that are not inside a
    fraction or root.

    >>> broken("a + b + c + d", 5.0)
    ['a + b + c', '{} + d']
    """
    pieces = _pieces(text)
    lines: list[str] = []
    while pieces:
        count = _fitting(pieces, room if not lines else room - 3)
        line = " ".join(piece for piece, _ in pieces[:count])
        lines.append(
            line if not lines else f"{{}} {line}" if line[0] in "+-" else rf"{{}} \times {line}"
        )
        pieces = pieces[count:]
    return lines


def _fitting(pieces: list[tuple[str, int]], room: float) -> int:
    """How many pieces to put on a line: as many as fit, fewer if that breaks outside of
    parentheses."""
    # At least one piece goes on each line, however wide it is: there is nothing to break in it.
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
    # Half a line stays empty at most. Among those the least penalty, then the longest line.
    candidates = [n for n in range(1, most + 1) if ends[n - 1] > room / 2] or [most]
    return min(candidates, key=lambda n: (pieces[n][1], -n))


def _pieces(text: str) -> list[tuple[str, int]]:
    """A formula cut where lines may break; each piece with a penalty for a break before it.

    The penalty is the depth of parentheses, and more between factors than before a sign.
    """
    pieces, start, penalty = [], 0, 0
    for space in _BREAK_TEXLINES.finditer(text):
        before, after = text[: space.start()], text[space.end() :]
        # TeX must have a group, and \left with its \right, on one line.
        in_group = before.count("{") != before.count("}")
        if in_group or before.count(r"\left") != before.count(r"\right"):
            continue
        pieces.append((text[start : space.start()], penalty))
        depth = before.count("(") - before.count(")")
        is_sign = after.startswith(("+ ", "- "))
        between_sums = before.endswith(")") and after.startswith(("(", r"\b", r"\B"))
        start, penalty = space.end(), depth if is_sign or between_sums else depth + 10
    return [*pieces, (text[start:], penalty)]


# Widths of characters, em: rough, as they decide only where a line breaks. A sign has its spaces
# with it.
_TOKEN = re.compile(r"\\[A-Za-z]+|\\.|[{}^_]|\S", re.DOTALL)
_WIDTHS = {
    **dict.fromkeys("+-=<>", 1.2),
    **dict.fromkeys("()|.,'", 0.35),
    **dict.fromkeys("0123456789", 0.5),
    **dict.fromkeys("mwMWHNX", 0.85),
    r"\quad": 1.0,
    r"\,": 0.17,
    r"\cdot": 0.7,
    r"\times": 1.2,
    r"\approx": 1.3,
    r"\Delta": 0.85,
    r"\omega": 0.65,
    **dict.fromkeys(
        (r"\left", r"\right", r"\mathrm", r"\mathcal", r"\text", r"\operatorname"), 0.0
    ),
    **dict.fromkeys((r"\bigl", r"\bigr", r"\Bigl", r"\Bigr"), 0.1),
}


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
    """The width of one token, or of what a command takes, and the place after it."""
    token = tokens[at]
    if token == "{":
        return _row_width(tokens, at + 1)
    # Exponents and subscripts are set smaller, small fractions as well.
    if token in ("^", "_") and at + 1 < len(tokens):
        wide, after = _item_width(tokens, at + 1)
        return 0.75 * wide, after
    if token in (r"\frac", r"\tfrac"):
        above, middle = _item_width(tokens, at + 1)
        below, after = _item_width(tokens, middle)
        return (max(above, below) if token == r"\frac" else 0.7 * max(above, below)) + 0.25, after
    return _WIDTHS.get(token, 0.95 if token == r"\sqrt" else 0.6), at + 1


_NONE: Mapping[str, str] = MappingProxyType({})
_TEMPLATE = r"""\documentclass[a4paper]{article}
\usepackage[hmargin=2.5cm,vmargin=2cm]{geometry}
\usepackage{amsmath}
\usepackage{array}
\usepackage{booktabs}
%s\allowdisplaybreaks
\emergencystretch=3em
\setlength{\parindent}{0pt}
\setlength{\parskip}{\smallskipamount}
\setlength{\abovecaptionskip}{0pt}
\setlength{\belowcaptionskip}{1ex}
\renewcommand{\topfraction}{0.9}
\renewcommand{\textfraction}{0.05}
\renewcommand{\floatpagefraction}{0.85}
%% Tables and figures stand where they are named: no float, but captions that count as theirs.
\makeatletter
\newcommand{\here}[1]{\def\@captype{#1}}
\renewcommand{\section}{\@startsection{section}{1}{0pt}{-2.4ex plus -1ex}{1ex}{\large\bfseries}}
\renewcommand{\subsection}{\@startsection{subsection}{2}{0pt}{-2ex plus -1ex}{0.8ex}{\bfseries}}
\makeatother
%s
\AtBeginDocument{\setlength{\abovedisplayskip}{4pt plus 2pt} \setlength{\belowdisplayskip}{4pt plus 2pt}}

\begin{document}

\begin{center}
  {\LARGE %s} \\[1ex] \today
\end{center}

%s

\end{document}
"""


def latex(document: Document, figures: Mapping[str, str] = _NONE) -> str:
    """The whole document, in full. ``figures`` : the files of its figures, by their names; others
    are left out.

    >>> from haptisym.writing.document import Document, Paragraph
    >>> latex(Document("A title", (), (Paragraph("5 % more"),))).count("5 \\\\% more")
    1
    """
    document = document.prepared(full=True)
    kind, title = escape(document.kind), escape(document.title)
    graphics = "\\usepackage{graphicx}\n" if figures else ""
    information = _information(f"{document.kind}: {document.title}" if kind else document.title)
    blocks = list(doc.Style(full=True).chosen(document.blocks))
    written = _Writer(figures, is_whole=True).joined(blocks)
    body = "\n\n".join([*map(phrase, document.lead), written])
    return _TEMPLATE % (
        graphics,
        information,
        rf"{kind}\\[1ex] \large {title}" if kind else title,
        body,
    )


def fragment(blocks: Iterable[Block], figures: Mapping[str, str] = _NONE, *, depth: int = 0) -> str:
    """Blocks as a piece of a document, in full; ``depth`` : of their headings, 2 for paragraphs."""
    return _Writer(figures, depth=depth).joined(list(doc.Style(full=True).chosen(blocks)))


def piece(document: Document) -> str:
    """A document as a piece of another one, without title and source: remarks about its scene, and
    its blocks."""
    document = document.prepared(full=True)
    return fragment([*_asides(document), *document.blocks], depth=2)


def tables(document: Document, digits: int = doc.DIGITS) -> str:
    """The tables of a document in brief, and the lines below its title but for the source, which is
    a string."""
    document = document.prepared(full=False, digits=digits, typed=False)
    return fragment([*_tables(document.blocks), *_asides(document)])


def tabular(
    document: Document, digits: int | None = None, *, kind: str = "", lines: bool = False
) -> str:
    """The table of a document that goes into a paper: its main one, or the first; with ``lines``,
    or where there is none, the lines of the answer in two columns.

    One ``tabular`` in units of the scene, which needs booktabs alone. Its caption and a label,
    which begins with the ``kind`` of answer, are comments. ``digits`` : of each number; None for
    those of a page.
    """
    document = document.prepared(full=False, digits=digits or doc.DIGITS, typed=False)
    listed = sorted(_tables(document.blocks), key=lambda x: not x.main)
    table = next(iter(listed), None)
    if lines or table is None:
        facts = next(x for x in document.blocks if isinstance(x, doc.Facts))
        table = doc.Table((doc.Column(""), doc.Column("")), facts.rows, document.title)
    heads, rows = _cells(table)
    caption = phrase(table.caption).replace("\n", " ")
    named = f"{kind} {document.title}".lower()
    label = re.sub(r"\W+", "-", named, flags=re.ASCII).strip("-")
    comments = [f"% \\caption{{{caption}}}", f"% \\label{{tab:{label[:40].rstrip('-')}}}"]
    # Columns as wide as they are: paragraphs would need another package.
    columns = " ".join("l" for _ in table.columns)
    text = "\n".join([*comments, *_tabular(columns, heads, rows), ""])
    # \operatorname is of amsmath.
    return text.replace(r"\operatorname", r"\mathrm")


def _cells(table: doc.Table) -> tuple[list[str], list[str]]:
    """The headings and the rows of a table, numbers with their points below each other."""
    cells = [[*map(phrase, row)] for row in table.rows]
    for i, column in enumerate(table.columns):
        if column.number:
            _point([said(row[i]) for row in table.rows], cells, i)
    rows = [f"    {' & '.join(row)} \\\\" for row in cells]
    return [phrase(x.heading) for x in table.columns], rows


def _asides(document: Document) -> list[Block]:
    """The lines below the title as paragraphs, without the source, which is a plain string."""
    return [doc.Paragraph(x) for x in document.lead if not isinstance(x, str)]


def _tables(blocks: Iterable[Block]) -> Iterator[doc.Table]:
    """All tables of blocks, also of those within sections."""
    for block in blocks:
        if isinstance(block, doc.Section):
            yield from _tables(block.blocks)
        elif isinstance(block, doc.Table):
            yield block


def _information(title: str) -> str:
    """What the PDF says about itself, plain or in UTF-16, and an identity that does not depend on
    where it was made."""
    # A string of PDF in parentheses may hold only balanced ones, and none of TeX's special
    # characters may reach it. Any other title is written in hexadecimal.
    plain = re.fullmatch(r"[\w ,.:;'=/+-]*(?:\([\w ,.:;'=/+-]*\)[\w ,.:;'=/+-]*)*", title, re.ASCII)
    coded = ("\ufeff" + title).encode("utf-16-be").hex().upper()
    written = f"({title})" if plain else f"<{coded}>"
    return (
        rf"\ifdefined\pdfinfo \pdfinfo{{/Title {written} /Creator (haptisym)}} "
        r"\pdftrailerid{} \fi"
    )


def phrase(words: Phrase) -> str:
    r"""A phrase in LaTeX.

    >>> from haptisym.writing.layout import named
    >>> phrase((named("r_r"), " exceeds 10\xa0%"))
    '$r_r$ exceeds 10~\\%'
    """
    if isinstance(words, tuple):
        return "".join(map(phrase, words))
    if isinstance(words, str):
        return "~".join(map(spaced, words.split("\xa0")))
    if isinstance(words, doc.Real | doc.Frequency | doc.OfFrequency | doc.Brief):
        return phrase(doc.Style().phrase(words))
    if isinstance(words, doc.Number):
        return _digits(words.digits)
    if isinstance(words, Strong):
        return rf"\textbf{{{phrase(words.words)}}}"
    return rf"\texttt{{{_typed(words.text)}}}" if isinstance(words, doc.Code) else f"${tex(words)}$"


def _typed(text: str) -> str:
    """What is typed, its quotation marks straight."""
    return escape(text).replace("''", r"\char34{}") if '"' in text else escape(text)


_LONG_NUMBER = 25  # digits; a longer one is set on several lines


def _digits(digits: str) -> str:
    """The digits of a number; a long one may break after every five."""
    if len(digits) <= _LONG_NUMBER:
        return spaced(digits)
    return r"\allowbreak ".join(digits[i : i + 5] for i in range(0, len(digits), 5))


@dataclass(frozen=True)
class _Writer:
    """LaTeX of blocks. Named numerators and denominators are shared by all equations of a
    document."""

    figures: Mapping[str, str]
    names: Names = field(default_factory=Names)
    depth: int = 0
    is_whole: bool = False
    """Whether it is a document of ours, in which tables and figures stand where they are named; a
    piece for somebody else's has floats."""

    def joined(self, blocks: Sequence[Block]) -> str:
        """Blocks one after the other: a display belongs to the paragraph before it; figures stand
        side by side."""
        text = ""
        for kind, group in groupby(blocks, key=lambda x: isinstance(x, doc.Figure) and not x.wide):
            for written in [self._side_by_side(list(group))] if kind else map(self._written, group):
                between = "\n" if written.startswith(r"\begin{align*}") else "\n\n"
                text += (between if text and written else "") + written
        return text

    @singledispatchmethod
    def _written(self, block: Block) -> str:
        """The LaTeX of a block."""
        raise TypeError(f"not a block of LaTeX: {type(block).__name__}")

    @_written.register
    def _(self, block: doc.Paragraph) -> str:
        return phrase(block.words)

    @_written.register
    def _(self, block: doc.Notes) -> str:
        return "\n\n".join(map(phrase, block.entries))

    @_written.register
    def _(self, block: doc.Facts) -> str:
        rows = [rf"  \item[{phrase(key)}] {phrase(words)}" for key, words in block.rows]
        widest = phrase(max((key for key, _ in block.rows), key=lambda x: len(said(x))))
        return "\n".join([_FACTS % widest, *rows, r"\end{list}"])

    @_written.register
    def _(self, block: doc.Flow) -> str:
        return " $\\to$ ".join(map(phrase, block.links)) + "."

    @_written.register
    def _(self, block: doc.Equations) -> str:
        return align(block.lines, self.names)

    @_written.register
    def _(self, block: doc.Section) -> str:
        inside = replace(self, depth=self.depth + 1).joined(block.blocks)
        if not block.title:
            return inside
        command = ("section", "subsection", "paragraph")[min(self.depth, 2)]
        appendix = "\\appendix \\small\n\n" if block.appendix else ""
        return f"{appendix}\\{command}{{{phrase(block.title)}}}\n\n{inside}"

    @_written.register
    def _(self, block: doc.Figure) -> str:
        return self._floating([block], 0.8)

    def _side_by_side(self, figures: Sequence[Block]) -> str:
        drawn = [x for x in figures if isinstance(x, doc.Figure)]
        return "\n\n".join(
            filter(None, (self._floating(drawn[i : i + 2], 0.48) for i in range(0, len(drawn), 2)))
        )

    def _floating(self, figures: Iterable[doc.Figure], width: float) -> str:
        columns = "\\hfill\n".join(
            f"\\begin{{minipage}}[t]{{{width}\\linewidth}}\\centering\n"
            f"\\includegraphics[width=\\linewidth]{{{self.figures[x.name]}}}\n"
            f"\\caption{{{phrase(x.caption)}}}\n\\end{{minipage}}"
            for x in figures
            if x.name in self.figures
        )
        begin, end = self._float("figure")
        return f"{begin}\n{columns}\n{end}" if columns else ""

    def _float(self, kind: str) -> tuple[str, str]:
        """How a figure or a table begins and ends."""
        if self.is_whole:
            # No page ends between a table and the paragraph that names it.
            begin = r"\nopagebreak\smallskip\begin{minipage}{\linewidth}\centering\here"
            return f"{begin}{{{kind}}}", r"\end{minipage}\smallskip"
        return f"\\begin{{{kind}}}[!htbp]\n  \\centering", f"\\end{{{kind}}}"

    @_written.register
    def _(self, block: doc.Table) -> str:
        heads, rows = _cells(block)
        columns, lines = _columns(block)
        # A float cannot break over pages: a long table becomes several, cut where the lines so far
        # pass a multiple of what one page has.
        ends = list(accumulate(lines))
        numbered = groupby(zip(ends, rows, strict=True), lambda x: (x[0] - 1) // _MOST)
        pieces = [[row for _, row in group] for _, group in numbered]
        return "\n\n".join(
            _table(self._float("table"), block.caption, _tabular(columns, heads, x), is_first=not i)
            for i, x in enumerate(pieces)
        )


_FACTS = r"""\begin{list}{}{\settowidth{\labelwidth}{%s} \setlength{\leftmargin}{\labelwidth}
  \setlength{\labelsep}{1em} \addtolength{\leftmargin}{\labelsep}
  \setlength{\itemsep}{0pt} \setlength{\parsep}{0pt}
  \renewcommand{\makelabel}[1]{#1\hfil}}"""
"""How a list begins whose labels are as wide as the widest."""
_MOST = 32  # lines of a table, so that it fits on a page
_LINE = 88  # characters of a line of a table
_GAP = 3
_CHARACTER = 0.175  # cm, as wide as a character is on average
# Ragged, as a narrow column that is justified tears its words apart.
_PARAGRAPHS = r">{\raggedright\arraybackslash}p{%.2fcm}"


def _point(shown: Sequence[str], cells: list[list[str]], i: int) -> None:
    """Move the numbers of a column to the right until their points stand below each other."""
    before = [len(found[0]) if (found := NUMBER.match(x)) else 0 for x in shown]
    # An invisible 0 is as wide as a digit. Numbers so long that they break are left alone.
    for row, n in zip(cells, before, strict=True):
        if n and n < max(before) <= _LONG_NUMBER:
            row[i] = rf"\phantom{{{'0' * (max(before) - n)}}}{row[i]}"


def _table(
    around: tuple[str, str], caption: Phrase, tabular: Sequence[str], *, is_first: bool
) -> str:
    """A table with its caption, all of it or a part."""
    begin, end = around
    words = phrase(caption) + ("" if is_first else " (Continued.)")
    named = [f"  \\caption{{{words}}}"] if caption else []
    return "\n".join([begin, *named, *tabular, end])


def _tabular(columns: str, heads: Sequence[str], rows: Sequence[str]) -> list[str]:
    """The lines of a table without its float; no row of headings where all are empty."""
    headed = [f"    {' & '.join(heads)} \\\\", r"    \midrule"] if any(heads) else []
    return [
        rf"  \begin{{tabular}}{{{columns}}}",
        r"    \toprule",
        *headed,
        *rows,
        r"    \bottomrule",
        r"  \end{tabular}",
    ]


def _columns(table: doc.Table) -> tuple[str, list[int]]:
    """The columns of a table, as wide as they are, or paragraphs where the line would be too long;
    and lines of each row."""
    headings = [column.heading for column in table.columns]
    rows = [[_breakable(x) for x in row] for row in (headings, *table.rows)]
    natural = [max(map(len, column)) for column in zip(*rows, strict=True)]
    room = _LINE - _GAP * (len(natural) - 1)
    widths = widths_of(rows, room) or _narrowed(natural, room)
    columns = [
        "l" if given >= needed else _PARAGRAPHS % (given * _CHARACTER)
        for given, needed in zip(widths, natural, strict=True)
    ]
    lines = []
    for row in rows[1:]:
        # Rounded up: characters by columns. A row without any still takes a line.
        heights = [-(-len(x) // given) for x, given in zip(row, widths, strict=True)]
        lines.append(max(max(heights), 1))
    return " ".join(columns), lines


def _narrowed(natural: Sequence[int], room: int) -> list[int]:
    """Widths that fit, although some words then do not: the widest columns give way."""
    wide = list(natural)
    while sum(wide) > max(room, len(wide)):
        wide[wide.index(max(wide))] -= 1
    return wide


def _breakable(words: Phrase) -> str:
    """About the characters of a phrase, with spaces where long numbers may break."""

    def parted(word: re.Match[str]) -> str:
        """A word in pieces of five characters."""
        return " ".join(word[0][i : i + 5] for i in range(0, len(word[0]), 5))

    return re.sub(r"\S{25,}", parted, said(words))
