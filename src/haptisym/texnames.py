"""Text, names and numbers in LaTeX, for pdflatex and nothing but amsmath.

Numbers are exact. A whole number is printed as it is, without separators; a fraction as a decimal where that ends within
six digits, or is shorter (9/5 is ``1.8``), else as ``\\tfrac``. Only ``approximate`` rounds, and whoever uses it writes
``\\approx``.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Callable
from decimal import Decimal
from typing import Any

from sympy import Add, Expr, Float, I, Mul, Pow, Rational, S, Symbol, pi

from .reals import ExactNumber

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
_GREEK = (
    "alpha", "beta", "gamma", "delta", "epsilon", "zeta", "eta", "theta", "iota", "kappa", "lambda", "mu", "nu", "xi",
    "omicron", "pi", "rho", "sigma", "tau", "upsilon", "phi", "chi", "psi", "omega",
)  # fmt: skip
_CAPITAL = ("Gamma", "Delta", "Theta", "Lambda", "Xi", "Pi", "Sigma", "Upsilon", "Phi", "Psi", "Omega")
_LONG_WORD = 20  # letters; a longer one gets places to break
_BREAK = re.compile(r"[^\W_]{5}(?=[^\W_]{20})|[^\w\s](?=\w)|_(?=[^\W_])")


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
    if c in _MATH or _greek(c):
        return rf"\ensuremath{{{_MATH.get(c) or _word(_greek(c))}}}"
    kind, _, plain = unicodedata.decomposition(c).rpartition("> ")
    if kind in ("<sub", "<super"):
        letters = "".join(_character(chr(int(code, 16))) for code in plain.split())
        return rf"\text{'subscript' if kind == '<sub' else 'superscript'}{{{letters}}}"
    return _accented(c)


def _accented(c: str) -> str:
    base, *marks = list(unicodedata.normalize("NFKD", c))
    if not base.isascii():
        return "" if unicodedata.combining(base) else " " if base.isspace() else rf"[U+{ord(c):04X}]\allowbreak{{}}"
    if len(marks) == 1 and marks[0] in _ACCENTS and base.isalpha():
        dotless = "\\" if base in "ij" else ""
        return rf"\{_ACCENTS[marks[0]]}{{{dotless}{base}}}"
    return "".join(map(_character, [base, *(mark for mark in marks if mark.isascii())]))


def _greek(c: str) -> str:
    """The English name of a Greek letter, "" for any other character."""
    size, _, name = unicodedata.name(c, "").removeprefix("GREEK ").partition(" LETTER ")
    name = name.lower().replace("lamda", "lambda")
    return "" if name not in _GREEK else name if size == "SMALL" else name.capitalize()


def symbol_name(name: str) -> str:
    r"""A parameter's name as people write it: ``_`` starts subscripts, several letters stand upright.

    >>> symbol_name("omega_n"), symbol_name("omega_n_filter"), symbol_name("k1"), symbol_name("Mm")
    ('\\omega_n', '\\omega_{n,\\mathrm{filter}}', 'k_1', 'M_m')
    """
    head, *below = [word for word in name.split("_") if word] or [name]
    parted = re.fullmatch(r"(.*[^\d])(\d+)", head) or re.fullmatch("([A-Z])([a-z])", head)
    if parted and head not in _CAPITAL:
        head, below = parted[1], [parted[2], *below]
    subscript = re.sub(r"}(,)\\mathrm{", r"\\,", ",".join(map(_word, below)))
    if not below:
        return _word(head)
    is_plain = len(subscript) == 1 or subscript[1:].isalpha()
    return f"{_word(head)}_{subscript}" if is_plain else f"{_word(head)}_{{{subscript}}}"


def _word(word: str) -> str:
    word = "".join(_greek(c) or c for c in word) if len(word) == 1 else word
    if word in _GREEK or word in _CAPITAL:
        return "o" if word == "omicron" else rf"\{word}"
    if word.isascii() and word.isalnum():
        return word if len(word) == 1 or word.isdigit() else rf"\mathrm{{{word}}}"
    return rf"\text{{{_escaped(word)}}}"


def alphabetical(symbol: Symbol) -> tuple[Any, ...]:
    """Where a symbol stands in a product: Latin before Greek, each in the order of its alphabet."""
    head, _, below = symbol.name.partition("_")
    name = _greek(head) if len(head) == 1 else head
    greek = name.lower() in _GREEK
    return greek, _GREEK.index(name.lower()) if greek else 0, head.lower(), head, below


_SHORT = 6  # digits of a decimal that a paper would print


def number(value: Rational) -> str:
    r"""An exact rational number >= 0.

    >>> number(Rational(9, 5)), number(Rational(1, 3)), number(Rational(12000)), number(Rational(1, 10**6))
    ('1.8', '\\tfrac{1}{3}', '12000', '10^{-6}')
    """
    if value.q == 1:
        return str(value.p)
    exact = _terminating(value)
    if exact is not None:
        length = len(exact.as_tuple().digits)
        if length <= _SHORT or length < len(f"{value.p}{value.q}"):
            return decimal(exact)
    return rf"\tfrac{{{value.p}}}{{{value.q}}}"


def _terminating(value: Rational) -> Decimal | None:
    below, places = int(value.q), 0
    for prime in (2, 5):
        power = 0
        while below % prime == 0:
            below, power = below // prime, power + 1
        places = max(places, power)
    return None if below > 1 else Decimal(int(value.p) * 10**places // int(value.q)).scaleb(-places)


def decimal(value: Decimal) -> str:
    sign, digits, _ = value.as_tuple()
    if -4 <= value.adjusted() < 7:
        return f"{value:f}"
    whole, rest = str(digits[0]), "".join(map(str, digits[1:])).rstrip("0")
    mantissa = f"{whole}.{rest}" if rest else whole
    power = f"10^{{{value.adjusted()}}}"
    return ("-" if sign else "") + (power if mantissa == "1" else rf"{mantissa} \times {power}")


def approximate(expression: Expr, digits: int = 6) -> Expr:
    """The formula with long numbers, and if there are any then irrational ones too, rounded to that many digits.

    >>> from sympy import Symbol
    >>> s = Symbol("s")
    >>> approximate(Rational(408233133, 200000001) * s + 40 * pi), approximate(Rational(4, 3) * s + 40 * pi)
    (2.04117*s + 125.664, 4*s/3 + 40*pi)
    """
    if _with_numbers(expression, lambda x: x if _is_short(x) else rounded(x, digits)) == expression:
        return expression
    return _with_numbers(expression, lambda x: x if x.is_Integer and abs(x) < 10**digits else rounded(x, digits))


def _with_numbers(expression: Expr, change: Callable[[Expr], Expr]) -> Expr:
    if not expression.free_symbols:
        return change(expression)
    if isinstance(expression, Pow):
        return Pow(_with_numbers(expression.base, change), expression.exp)
    if not isinstance(expression, Add | Mul):
        return expression
    known, rest = expression.as_independent(*expression.free_symbols, as_Add=isinstance(expression, Add))
    others = (_with_numbers(x, change) for x in expression.func.make_args(rest))
    return expression.func(change(known), *others)


def rounded(value: Expr, digits: int = 6) -> Float:
    """A number, rational in pi, correctly rounded."""
    if value.has(I):  # the phase of friction
        return Add(*(x * rounded(y, digits) for x, y in zip((1, I), value.as_real_imag(), strict=True) if y))
    return Float(ExactNumber(value).digits(digits), digits)


def _is_short(value: Expr) -> bool:
    rational, rest = value.as_coeff_Mul()
    return len(number(abs(rational)).replace(r"\tfrac", "")) <= 12 and (rest.is_Symbol or rest in (S.One, pi, pi**2))
