"""Text for terminals and files that lack characters: what an encoding does not hold is spelt in words or ASCII signs."""

from __future__ import annotations

import codecs
import re
from unicodedata import combining, name, normalize

_SIGNS = {
    "−": "-", "–": "-", "—": "-", "─": "-", "━": "-", "═": "=", "│": "|", "·": "*", "⋅": "*", "×": "*", "∙": "*",
    "÷": "/", "⁄": "/", "≈": "~=", "≤": "<=", "≥": ">=", "≠": "!=", "≡": "==", "±": "+-", "∓": "-+", "∞": "inf",
    "√": "sqrt", "∂": "d", "∑": "sum", "∏": "product", "∫": "integral", "∈": "in", "∠": "angle", "→": "->",
    "←": "<-", "↔": "<->", "⇒": "=>", "°": "deg", "µ": "u", "‘": "'", "’": "'", "‚": "'", "“": '"', "”": '"',
    "„": '"', "′": "'", "″": "''", "…": "...", "•": "*", "†": "+", "ß": "ss", "æ": "ae", "Æ": "AE", "œ": "oe",
    "Œ": "OE", "ø": "o", "Ø": "O", "ł": "l", "Ł": "L", "đ": "d", "ð": "d", "þ": "th", "ı": "i", "ȷ": "j", "€": "EUR",
    "£": "GBP", "§": "section ", "©": "(c)", "®": "(R)", "«": '"', "»": '"', "∆": "Delta", "Ω": "Omega",
    "ϵ": "epsilon", "ϕ": "phi", "ς": "sigma", "ϑ": "theta", "\N{NO-BREAK SPACE}": " ",
    "\N{NARROW NO-BREAK SPACE}": " ",
}  # fmt: skip
_GREEK = re.compile(r"GREEK (SMALL|CAPITAL) LETTER (\w+)")
_ALIASES = {"LAMDA": "lambda"}


def spelt(text: str, encoding: str) -> str:
    """The text with words or ASCII signs for the characters that an encoding lacks.

    >>> spelt("ω² ≈ 40 °", "ascii"), spelt("ω² ≈ 40 °", "latin-1")
    ('omega^2 ~= 40 deg', 'omega² ~= 40 °')
    """
    try:
        text.encode(encoding)
    except UnicodeEncodeError:
        return "".join(x if _held(x, encoding) else _word(text, i) for i, x in enumerate(text))
    except LookupError:
        return text
    return text


def _held(character: str, encoding: str) -> bool:
    try:
        character.encode(encoding)
    except UnicodeEncodeError:
        return False
    return True


def _word(text: str, at: int) -> str:
    """The ASCII for one character of a text."""
    x = text[at]
    if x in _SIGNS:
        return _SIGNS[x]
    if greek := _GREEK.match(name(x, "")):
        kind, letter = greek.groups()
        word = _ALIASES.get(letter, letter.lower())
        apart = " " if at and text[at - 1].isalnum() else ""
        return apart + (word.capitalize() if kind == "CAPITAL" else word)
    is_small = any(word in name(x, "") for word in ("SUPERSCRIPT", "SUBSCRIPT"))
    plain = "".join(_SIGNS.get(y, y) if is_small else y for y in normalize("NFKD", x) if not combining(y))
    if plain.isascii() and plain:
        raised = "SUPERSCRIPT" in name(x, "") and not (at and "SUPERSCRIPT" in name(text[at - 1], ""))
        return f"^{plain}" if raised else f"_{plain}" if "SUBSCRIPT" in name(x, "") else plain
    return "" if combining(x) else f"\\u{ord(x):04x}" if ord(x) < 0x10000 else f"\\U{ord(x):08x}"


def escaped(document: str, encoding: str) -> str:
    r"""A JSON document with JSON's own escapes for the characters that an encoding lacks.

    >>> escaped('{"title": "Prüfstand ω"}', "latin-1")
    '{"title": "Prüfstand \\u03c9"}'
    """

    def escape(x: str) -> str:
        if _held(x, encoding):
            return x
        units = x.encode("utf-16-be", "surrogatepass")
        return "".join(f"\\u{units[i] << 8 | units[i + 1]:04x}" for i in range(0, len(units), 2))

    try:
        document.encode(encoding)
    except UnicodeEncodeError:
        return "".join(map(escape, document))
    except LookupError:
        return document
    return document


def _spell(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return "".join(_word(error.object, i) for i in range(error.start, error.end)), error.end


HANDLER = "haptisym.spelt"
"""Name of the error handler of codecs that spells what is lacking, once ``register`` was called."""


def register() -> None:
    """Make the handler known by its name; once is enough."""
    codecs.register_error(HANDLER, _spell)
