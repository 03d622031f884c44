"""Formulas and quantities with units, as a scene file writes them: exact."""

import re
import tomllib
from collections.abc import Callable
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from haptisym_check.values import ZERO, Ratio, Value, degree, need

T = TypeVar("T")
NUMBER = r"(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]{1,3}(?![0-9]))?"
EXPONENT = r"[+-]?(?:[0-9]{1,2}(?:\.[0-9]{0,12})?|\.[0-9]{1,12})"
POWER = rf"(?:\^|\*\*)\s*(?:\(\s*(?:[+-]?[0-9]{{1,2}}\s*/\s*[1-9][0-9]?|{EXPONENT})\s*\)|{EXPONENT}(?![\w.]))"
WORD = re.compile(rf"{NUMBER}|[^\W\d]\w*|[°%]|{POWER}|[-+*/()]")
BINDS = {"+": 1, "-": 1, "*": 2, "/": 2}


@cache
def words_of(text: str) -> list[str]:
    """Numbers, names, signs and powers, in reverse."""
    found = WORD.findall(text) if len(text) <= 4000 else []
    whole = "".join("".join(found).split()) == "".join(text.split())
    need(found and len(found) <= 400 and whole, f"{text[:60]!r} is not understood")
    return found[::-1]


def evaluated(text: str, leaf: Callable[[str], T], combine: Callable[[str, T, T], T], *, spaced: bool = False) -> T:
    """A formula's value, from what numbers, names and their broken powers are and how two combine; ``spaced``: N m is N*m."""
    words = [*words_of(text)]

    def value(least: int) -> T:
        """Of what signs hold together that bind more than that."""
        word = words.pop() if words else ")"
        if word in BINDS:
            need(BINDS[word] == 1, f"{text[:60]!r} is not understood")
            found = combine("*", leaf(f"{word}1"), value(2))
        elif word == "(":
            found = value(0)
            need(words and words.pop() == ")", f"{text[:60]!r} is not understood")
        else:
            need(word[0] not in ")^*", f"{text[:60]!r} is not understood")
            found = leaf(word)
        if word not in BINDS and words and re.match(r"\^|\*\*", words[-1]):
            base, n = found, Fraction(re.sub("[^-0-9./]", "", words.pop()))
            found = leaf("1" if n.denominator == 1 else f"{word}^{n}")
            for _ in range(abs(int(n)) if n.denominator == 1 else 0):
                found = combine("*" if n > 0 else "/", found, base)
        while words and words[-1] != ")" and BINDS.get(words[-1], BINDS["*"]) > least:
            sign = words[-1] if words[-1] in BINDS else "*"
            unsaid = words[-1] != sign and (not spaced or (words[-1] != "1" and words[-1][0] in ".0123456789"))
            need(not unsaid, f"{text[:60]!r} is not understood")
            found = combine(sign, found, value(BINDS[words.pop() if words[-1] == sign else sign]))
        return found

    result = value(0)
    need(not words, f"{text[:60]!r} is not understood")
    return result


class Number(NamedTuple):
    """value * pi^pi, and its dimension, powers of kg, m and s; None without a unit."""

    value: Fraction
    pi: int = 0
    dimension: list[Any] | None = None

    def at(self, pi: int) -> Ratio:
        """With a whole number in place of pi."""
        up, down = max(self.pi, 0), max(-self.pi, 0)
        top = Value(self.value.numerator * pi**up, 0, degree(1, up)) if self.value else ZERO
        return top, Value(self.value.denominator * pi**down, 0, degree(1, down))


FREE = Number(Fraction(1), 1)  # a parameter that is left free takes the place of pi
CATALOGUE = tomllib.loads((Path(__file__).parent / "catalogue.toml").read_text(encoding="utf-8"))
SPELLED: dict[int, str] = {ord(x): y for x, y in zip("·×⋅²³", ("*", "*", "*", "^2", "^3"), strict=True)}


def unit(word: str) -> Number:
    """A number, or a unit by its name, perhaps with a prefix."""
    if word[0] in "+-.0123456789" and "^" not in word:
        return Number(Fraction(word))
    name, _, power = word.partition("^")
    prefix, base = ("", name) if name in CATALOGUE["units"] else (name[:1], name[1:])
    factor, pi, dimension, prefixed = CATALOGUE["units"].get(base, ["1", 0, [], ""])
    fits = dimension and (not prefix or (prefix in CATALOGUE["prefixes"] and prefixed))
    need(fits, f"the unit {word!r} is not understood")
    value = Fraction(factor) * Fraction(10) ** CATALOGUE["prefixes"].get(prefix, 0)
    need(not power or (value == 1 and not pi), f"the power {word!r} is not rational")
    return Number(value, pi, [Fraction(power or 1) * n for n in dimension])


def units(sign: str, x: Number, y: Number) -> Number:
    """The product or the quotient of two."""
    need(sign in "*/", "a quantity is a product of powers")
    n = 1 if sign == "*" else -1
    need(n > 0 or y.value, "a division by zero")
    value = x.value * y.value**n
    need(value.numerator.bit_length() + value.denominator.bit_length() < 10**5, "a number is too large")
    both = [a + n * b for a, b in zip(x.dimension or [0, 0, 0], y.dimension or [0, 0, 0], strict=True)]
    return Number(value, x.pi + n * y.pi, None if x.dimension is y.dimension is None else both)


def quantity(given: Any, kind: str = "") -> Number:
    """A number with or without a unit, exactly; of a range the nominal value. ``kind``: a key of the dimensions."""
    if isinstance(given, list):
        need(2 <= len(given) <= 3, "a range has two ends, and perhaps its nominal value between them")
        low, *between, high = (quantity(x, kind) for x in given)
        need(low[1:] == high[1:], "the ends of a range have different units")
        return between[0] if between else low._replace(value=(low.value + high.value) / 2)
    if isinstance(given, Number):
        return given
    if isinstance(given, int | Fraction) and not isinstance(given, bool):
        return Number(Fraction(given))
    need(isinstance(given, str) and len(given) < 500, "a value is neither a number nor a text")
    text, *deviation = re.split(r"\+/?-|±", given)
    found = evaluated(text.translate(SPELLED), unit, units, spaced=True)
    own = CATALOGUE["dimensions"][kind] if kind else []
    need(len(deviation) < 2 and (not own or found.dimension in (None, *own)), f"{given[:60]!r} has the wrong dimension")
    return found
