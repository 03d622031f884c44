"""Text and names in LaTeX, for pdflatex and nothing but amsmath."""

from __future__ import annotations

import re
import unicodedata

from haptisym.writing.boxes import Name, Word
from haptisym.writing.names import CAPITALS, GREEK, greek, named

_SPECIAL = {
    "\\": r"\textbackslash{}", "{": r"\{", "}": r"\}", "$": r"\$", "&": r"\&", "#": r"\#", "%": r"\%", "_": r"\_",
    "^": r"\textasciicircum{}", "~": r"\textasciitilde{}", "<": r"\textless{}", ">": r"\textgreater{}",
    "|": r"\textbar{}", '"': "''", "`": r"\`{}", "–": r"\textendash{}", "—": r"\textemdash{}", "‘": "`{}", "’": "'",
    "“": "``{}", "”": "''{}", "„": ",,", "«": r"\ensuremath{\ll}", "»": r"\ensuremath{\gg}", "…": r"\dots{}", "ß": r"\ss{}",
    "æ": r"\ae{}", "Æ": r"\AE{}", "œ": r"\oe{}", "Œ": r"\OE{}", "ø": r"\o{}", "Ø": r"\O{}", "ł": r"\l{}", "Ł": r"\L{}",
    "ı": r"\i{}", "ȷ": r"\j{}", "§": r"\S{}", "¶": r"\P{}", "©": r"\copyright{}", "£": r"\pounds{}", "đ": "d", "Đ": "D",
    "ð": "d", "Ð": "D", "þ": "th", "Þ": "Th", "€": "EUR", "†": r"\dag{}",
}  # fmt: skip
_MATH = {
    "°": r"^{\circ}", "±": r"\pm", "∓": r"\mp", "×": r"\times", "·": r"\cdot", "⋅": r"\cdot", "−": "-", "÷": r"\div",
    "≤": r"\le", "≥": r"\ge", "≠": r"\ne", "≈": r"\approx", "≡": r"\equiv", "∞": r"\infty", "√": r"\surd", "∂": r"\partial",
    "∫": r"\int", "∑": r"\sum", "∏": r"\prod", "∆": r"\Delta", "Ω": r"\Omega", "ℜ": r"\Re", "ℑ": r"\Im", "∠": r"\angle",
    "→": r"\to", "←": r"\leftarrow", "↔": r"\leftrightarrow", "⇒": r"\Rightarrow", "∈": r"\in", "µ": r"\mu", "¬": r"\neg",
    "ϵ": r"\epsilon", "ϕ": r"\phi", "φ": r"\varphi", "ε": r"\varepsilon", "ς": r"\varsigma", "′": "'", "″": "''",
}  # fmt: skip
_ACCENTS = {
    "\u0300": "`", "\u0301": "'", "\u0302": "^", "\u0303": "~", "\u0304": "=", "\u0306": "u", "\u0307": ".", "\u0308": '"',
    "\u030a": "r", "\u030b": "H", "\u030c": "v", "\u0323": "d", "\u0327": "c", "\u0331": "b",
}  # fmt: skip
_SIGNS = {"∞": r"\infty"}
_LONG_WORD = 20  # letters; a longer one gets places to break
_BREAK = re.compile(r"\d{5}(?=\d{5})|[^\W_]{5}(?=[^\W_]{20})|[^\w\s](?=\w)|_(?=[^\W_])")


def escape(text: str) -> str:
    r"""Any text for pdflatex: special characters, accents, Greek, signs and subscripts; what it lacks, by code point.

    Long words get places to break. A letter that the font lacks loses its mark (ę is e).

    >>> escape("50% of ω₀_x é"), escape("中")
    ("50\\% of \\ensuremath{\\omega}\\textsubscript{0}\\_x \\'{e}", '[U+4E2D]\\allowbreak{}')
    """
    words = text.replace("\0", " ").split()
    marked = " ".join(_BREAK.sub(r"\g<0>\0", word) if len(word) > _LONG_WORD else word for word in words)
    return re.sub("-(?=-)", "-{}", _escaped(marked))  # no ligature


def _escaped(text: str) -> str:
    return "".join(r"\allowbreak{}" if c == "\0" else _character(c) for c in unicodedata.normalize("NFC", text))


def _character(c: str) -> str:
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
    base, *marks = list(unicodedata.normalize("NFKD", c))
    if not base.isascii():
        return "" if unicodedata.combining(base) else " " if base.isspace() else rf"[U+{ord(c):04X}]\allowbreak{{}}"
    if len(marks) == 1 and marks[0] in _ACCENTS and base.isalpha():
        dotless = "\\" if base in "ij" else ""
        return rf"\{_ACCENTS[marks[0]]}{{{dotless}{base}}}"
    return "".join(map(_character, [base, *(mark for mark in marks if mark.isascii())]))


def coded(words: str) -> str:
    r"""Words in which what stands between backticks is code.

    >>> coded("5 % more: see `x_1`.")
    '5 \\% more: see \\texttt{x\\_1}.'
    """
    return "".join(rf"\texttt{{{escape(x)}}}" if i % 2 else spaced(x) for i, x in enumerate(words.split("`")))


def spaced(words: str) -> str:
    """Words in LaTeX, with a space at their ends where they have one."""
    before, after = (" " if x.isspace() else "" for x in (words[:1], words[-1:]))
    return f"{before}{escape(words)}{after}"


def symbol_name(name: str) -> str:
    r"""A parameter's name as people write it: ``_`` starts subscripts, several letters stand upright.

    >>> symbol_name("omega_n"), symbol_name("omega_n_filter"), symbol_name("k1"), symbol_name("Mm")
    ('\\omega_n', '\\omega_{n,\\mathrm{filter}}', 'k_1', 'M_m')
    """
    return set_name(named(name))


def set_name(name: Name) -> str:
    """The same of a name that is taken apart already."""
    head, subscript = _word(name.head), ",".join(map(_word, name.below))
    if not subscript:
        return head
    is_plain = len(subscript) == 1 or subscript[1:].isalpha()
    return f"{head}_{subscript}" if is_plain else f"{head}_{{{subscript}}}"


def _word(word: Word) -> str:
    letters = word.letters
    if letters in GREEK or letters in CAPITALS:
        return "o" if letters == "omicron" else rf"\{letters}"
    if letters.isascii() and letters.replace(" ", "").isalnum():
        return rf"\mathrm{{{letters}}}".replace(" ", r"\,") if word.upright else letters
    return _SIGNS.get(letters) or rf"\text{{{_escaped(letters)}}}"
