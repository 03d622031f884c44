"""What a user writes, read exactly: formulas, units and quantities. ``"1.8 kg"`` is 9/5, ``"15
Hz"`` is 30 pi rad/s.

Formulas and units are in one small grammar, and nothing is ever executed: a formula is data. The
caller of ``evaluate`` says what numbers and names mean. Begin with ``quantity``::

    sum      = product {("+" | "-") product}
    product  = signed {("*" | "/") signed}
    signed   = ["+" | "-"] signed | power
    power    = atom [("^" | "**") exponent]
    exponent = ["+" | "-"] number | "(" ["+" | "-"] (number | whole "/" whole) ")"
    atom     = number | name | "(" sum ")"

Units are exact by their definitions: a rational number times a power of pi, and base dimensions.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from decimal import Decimal
from enum import Enum
from fractions import Fraction
from functools import cache
from itertools import chain, islice, product
from math import ceil
from numbers import Real
from operator import add, mul, sub, truediv
from typing import Any, Generic, NamedTuple, NoReturn, TypeAlias, TypeVar

from sympy import (
    Add,
    Dummy,
    Expr,
    Float,
    I,
    Integer,
    Mul,
    Pow,
    Rational,
    Symbol,
    cos,
    cosh,
    coth,
    exp,
    expand,
    fraction,
    nan,
    oo,
    pi,
    preorder_traversal,
    sin,
    sinh,
    tan,
    tanh,
    together,
    zoo,
)

from haptisym.kernel.errors import ExpressionError, SceneError, meant, quoted
from haptisym.kernel.reals import Proven, RealNumber, in_sympy
from haptisym.kernel.rings import omega, s

T = TypeVar("T")

_TOKEN = re.compile(
    r"(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)"
    r"|(?P<name>[^\W\d]\w*|[°%])|(?P<operator>\*\*|[-+*/^()])|(?P<space>\s+)"
)
# Bounds on a formula, which may come from a stranger's file: each keeps the time to read it small.
# The largest whole number in an exponent that is a quotient
_LARGEST = 99
# Characters of a formula
LONGEST = 4000
# Nested parentheses or signs; far below Python's recursion limit
DEEPEST = 60
# Degree of the expanded formula; the threshold polynomial has about four times that degree
HIGHEST_DEGREE = 60
# Digits of all numbers in the expanded formula together
MOST_DIGITS = 2000


_DELAY = 'use an effect, [[effects]] with model = "delay" and tau, which is exact'
_INSTEAD = {
    "sqrt": "a root is a power, as in s^0.5",
    **dict.fromkeys(
        ("cosh", "sinh", "tanh"), 'a delayed link is the effect model = "wave-variables"'
    ),
    **dict.fromkeys(("sin", "cos", "tan", "log", "ln", "abs"), "use numbers, names, + - * / and ^"),
}


class _Token(NamedTuple):
    kind: str
    text: str
    at: int


class _Value(NamedTuple):
    """A value with upper bounds on its expanded form: the degree in the names, and the number of
    digits."""

    value: Any
    degree: int
    digits: int


def evaluate(
    text: str, *, number: Callable[[str], T], name: Callable[[str], T], sums: bool = True
) -> T:
    """The value of a formula, in whatever ring ``number`` and ``name`` map to (they may raise
    KeyError or ValueError).

    Without ``sums`` only products, quotients and powers are in the grammar, as in a unit.

    Raises ExpressionError, with a caret under the place, for whatever is not in the grammar, too
    deep or too large.

    >>> evaluate("2*x^2 - (x + 1)/4", number=Fraction, name={"x": Fraction(3)}.__getitem__)
    Fraction(17, 1)
    >>> evaluate("2*y", number=Fraction, name={"x": Fraction(3)}.__getitem__)
    Traceback (most recent call last):
      ...
    haptisym.kernel.errors.ExpressionError: unknown name "y"
        2*y
          ^
    """
    if len(text) > LONGEST:
        raise ExpressionError(
            f"a formula may have at most {LONGEST} characters; this one has {len(text)}"
        )
    reader = _Reader(text, number, name, sums)
    result = reader.sum(0)
    if reader.token.kind != "end":
        reader.fail(f'expected an operator such as *, found "{reader.token.text}"')
    value: T = result.value
    return value


class _Reader(Generic[T]):
    """A recursive-descent reader: one method for each line of the grammar."""

    def __init__(
        self,
        text: str,
        number: Callable[[str], T],
        name: Callable[[str], T],
        sums: bool,  # noqa: FBT001
    ) -> None:
        self.text, self.number, self.name = text, number, name
        self.signs = ("+", "-") if sums else ()
        self.tokens = self._tokens()
        self.position = 0

    @property
    def token(self) -> _Token:
        """The token that is read next."""
        return self.tokens[self.position]

    def fail(self, why: str, at: int | None = None) -> NoReturn:
        """ExpressionError with a caret under the place: that of the next token unless given."""
        at = self.token.at if at is None else at
        start = max(0, at - 50)
        shown = self.text[start : at + 30].replace("\n", " ").replace("\t", " ")
        raise ExpressionError(f"{why}\n    {shown}\n    {' ' * (at - start)}^") from None

    def _tokens(self) -> list[_Token]:
        """The formula in tokens without blanks, with one of the kind ``end`` behind them."""
        tokens, at = [], 0
        while at < len(self.text):
            match = _TOKEN.match(self.text, at)
            if match is None:
                self.tokens, self.position = [_Token("bad", self.text[at], at)], 0
                self.fail(
                    f'"{self.text[at]}" is not allowed in a formula (only numbers, names, + '
                    f"- * / ^ and parentheses)"
                )
            if match.lastgroup != "space":
                tokens.append(_Token(str(match.lastgroup), match[0], at))
            at = match.end()
        return [*tokens, _Token("end", "the end", len(self.text))]

    def take(self, *operators: str) -> _Token | None:
        """Read the next token if it is one of these operators; else None, and nothing is read."""
        token = self.token
        if token.kind == "operator" and token.text in operators:
            self.position += 1
            return token
        return None

    def sum(self, depth: int) -> _Value:
        """Read a sum; ``depth`` : of parentheses and signs around it."""
        left = self.product(depth)
        while sign := self.take(*self.signs):
            right = self.product(depth)
            degree, digits = max(left.degree, right.degree), left.digits + right.digits
            left = self._combine(
                add if sign.text == "+" else sub, left, right, (degree, digits), sign
            )
        return left

    def product(self, depth: int) -> _Value:
        """Read a product."""
        left = self.signed(depth)
        while sign := self.take("*", "/"):
            right = self.signed(depth)
            grown = left.degree + right.degree, left.digits + right.digits
            left = self._combine(mul if sign.text == "*" else truediv, left, right, grown, sign)
        return left

    def signed(self, depth: int) -> _Value:
        """Read a power with signs before it: -x^2 is -(x^2)."""
        if depth > DEEPEST:
            self.fail(f"a formula may be nested at most {DEEPEST} deep")
        if sign := self.take(*self.signs):
            operand = self.signed(depth + 1)
            return operand._replace(value=-operand.value) if sign.text == "-" else operand
        return self.power(depth)

    def power(self, depth: int) -> _Value:
        """Read an atom, and an exponent if there is one."""
        base = self.atom(depth)
        sign = self.take("^", "**")
        if sign is None:
            return base
        exponent = self.exponent()
        if self.take("^", "**"):
            self.position -= 1
            self.fail("a power of a power needs parentheses")
        # Bounds with the exponent's absolute value, a fractional one rounded up: 1/x has the degree
        # of x.
        size = abs(int(exponent)) + 1 if exponent.denominator != 1 else abs(int(exponent))
        whole = int(exponent) if exponent.denominator == 1 else exponent
        return self._combine(
            pow, base, _Value(whole, 0, 0), (base.degree * size, base.digits * max(size, 1)), sign
        )

    def exponent(self) -> Fraction:
        """Read a number, or in parentheses a quotient of whole numbers: an exponent is never a
        formula, so that degrees are known."""
        bracket = self.take("(")
        sign = self.take("+", "-")
        first, value = self.token, self._short()
        if bracket and self.take("/"):
            second, below = self.token, self._short()
            whole = first.text.isdigit() and second.text.isdigit()
            if not whole or not below or max(value, below) > _LARGEST:
                self.fail(
                    (
                        f"a quotient as an exponent is one of whole numbers up to {_LARGEST}, as "
                        f"in s^(1/3)"
                    ),
                    first.at,
                )
            value /= below
        if bracket and not self.take(")"):
            is_open = self.token.kind == "end"
            self.fail(
                'expected ")"'
                if is_open
                else "an exponent must be one number, as in s^2 or s^(-1/2), not a formula"
            )
        return -value if sign and sign.text == "-" else value

    def _short(self) -> Fraction:
        """Read a plain number in an exponent; short, as it bounds a degree."""
        token = self.token
        if token.kind != "number":
            self.fail("an exponent must be a number")
        if len(token.text) > 12 or "e" in token.text.lower():
            self.fail("an exponent must be a short plain number")
        self.position += 1
        return Fraction(token.text)

    def atom(self, depth: int) -> _Value:
        """Read a number, a name or a sum in parentheses."""
        token = self.token
        if self.take("("):
            inner = self.sum(depth + 1)
            if not self.take(")"):
                self.fail('expected ")"')
            return inner
        if token.kind not in ("number", "name"):
            self.fail(f"expected a number, a name or a parenthesis, found {token.text}")
        self.position += 1
        if token.kind == "number":
            return _Value(self._meaning(self.number, token, "not a number"), 0, len(token.text))
        self._no_function(token)
        return _Value(self._meaning(self.name, token, "unknown name"), 1, 1)

    def _no_function(self, token: _Token) -> None:
        """A name with a parenthesis after it is no function, and e to a power of s no number: say
        what to write instead."""
        after = self.token.text
        if token.text == "exp" and after == "(":
            self.fail(f"a formula has no exp(...): {_DELAY}", token.at)
        if (
            token.text == "e"
            and after in ("^", "**")
            and self.tokens[self.position + 1].kind != "number"
        ):
            self.fail(f"a formula has no powers of e: {_DELAY}", token.at)
        if after == "(":
            instead = _INSTEAD.get(token.text, f'if a product is meant, write "{token.text}*("')
            self.fail(
                f'a formula has no functions, and "{token.text}(" would be one: {instead}', token.at
            )

    def _meaning(self, read: Callable[[str], T], token: _Token, otherwise: str) -> T:
        """What the caller makes of a number or name; ``otherwise`` : the error where it is none."""
        try:
            return read(token.text)
        except KeyError:
            self.fail(f'{otherwise} "{token.text}"', token.at)
        except ValueError as error:
            self.fail(str(error), token.at)

    def _combine(
        self,
        operation: Callable[[Any, Any], Any],
        left: _Value,
        right: _Value,
        grown: tuple[int, int],
        sign: _Token,
    ) -> _Value:
        """Apply an operator; ``grown`` : bounds on degree and digits of the result."""
        # Bounds first: 9^999999999 must be refused before anything so large is computed.
        degree, digits = grown
        if degree > HIGHEST_DEGREE:
            self.fail(f"the degree, {degree}, is higher than {HIGHEST_DEGREE}", sign.at)
        if digits > MOST_DIGITS:
            self.fail(f"expanded, this has more than {MOST_DIGITS} digits", sign.at)
        try:
            # SymPy would answer zoo in silence where numbers of Python raise.
            if (operation is truediv and not right.value) or (
                operation is pow and right.value < 0 and not left.value
            ):
                raise ZeroDivisionError
            return _Value(operation(left.value, right.value), degree, digits)
        except ZeroDivisionError:
            self.fail("division by zero", sign.at)
        except (TypeError, ValueError) as error:
            self.fail(str(error), sign.at)


_JUXTAPOSED = re.compile(r"(?<=[\w)°%])\s+(?=[^\W\d]|[(°%])")  # "N s/m" is N*s/m
_PLAIN = str.maketrans({"·": "*", "×": "*", "⋅": "*", "¹": "^1", "²": "^2", "³": "^3", "⁻": "^-"})


def _plain(unit: str) -> str:
    """A unit with the operators of the grammar."""
    return _JUXTAPOSED.sub("*", unit.translate(_PLAIN).replace("-^", "-"))


Powers: TypeAlias = dict[str, Fraction]


def read_unit(
    unit: str, text: str, hint: str, fits: Callable[[Powers], bool] = lambda _: True
) -> tuple[Expr, Powers]:
    """Its value in SI and its base dimensions, exact. ``text``, ``hint``: the text and the end of
    an error.

    A unit is read as it is written where that ``fits`` the dimension that is wanted, and else as
    engineers write it (``Nms/rad``,
    ``N-m``, ``kg.m2``, ``g`` of an acceleration). Raises SceneError where it is unknown, or where
    two such readings fit that differ in size.

    >>> read_unit("Nm/rad", "", "") == read_unit("N*m/rad", "", ""), read_unit("rad/Nm", "", "") == read_unit("rad/(N*m)", "", "")
    (True, True)
    """
    plain = _plain(unit)
    if (known := _reading(plain, text, fits)) is not None:
        return known
    near = _proposal(plain, fits)
    raise SceneError(f"unknown unit {quoted(unit)}{f': {near}' if near else '.'}{hint}")


def _reading(plain: str, text: str, fits: Callable[[Powers], bool]) -> tuple[Expr, Powers] | None:
    """The one meaning of a unit that fits, or any where none does; None where it is unknown."""
    # Readings that differ in spelling only, as N*m and m*N, have one key: value and dimensions.
    readings: dict[tuple[Expr, tuple[tuple[str, Fraction], ...]], str] = {}
    for spelt in chain([plain], _as_engineers_write(plain)):
        try:
            value, powers = _unit_value(
                evaluate(spelt, number=_unit_number, name=_named_unit, sums=False), text
            )
        except (ExpressionError, ArithmeticError):
            continue
        # As it is written goes before all other readings.
        if spelt == plain and fits(powers):
            return value, powers
        readings.setdefault((value, tuple(sorted(powers.items()))), spelt)
    fitting = [x for x in readings if fits(dict(x[1]))]
    if len(fitting) > 1:
        both = " or ".join(f'"{readings[x]}"' for x in fitting[:2])
        raise SceneError(f"{quoted(text)} has two meanings: write {both}")
    # Where none fits, the caller's error says which dimension is wanted.
    for value, powers_of in [*fitting, *readings]:
        return value, dict(powers_of)
    return None


def _unit_value(size: _Size, text: str) -> tuple[Expr, Powers]:
    """The exact value of a unit in SI, and its base dimensions."""
    # A fractional power of a factor, as of ft^(1/2), is a float; only 1 is exact then.
    turns, *powers = size.powers
    if turns.denominator != 1 or (isinstance(size.factor, float) and size.factor != 1.0):
        raise SceneError(f"{quoted(text)}: use m, s, kg, N, rad in a fractional power")
    exact = Fraction(size.factor)
    value = Rational(exact.numerator, exact.denominator) * pi ** Integer(int(turns))
    dimensions = zip(("mass", "length", "time"), powers, strict=True)
    return value, {name: power for name, power in dimensions if power}


_BETWEEN = re.compile(r"(?<=\w)[-.](?=[^\W\d_])")  # "N-m", "N.m", "m2.s"
_POWER_BEHIND = re.compile(r"(?<=[^\W\d_])(-?\d)(?!\d)")  # "m2", "s-1"
_RUN_TOGETHER = re.compile(r"[^\W\d_]+")
# Letters of a word that is taken apart, as "kgfcmsec": the ways to do so double with each letter.
_LONGEST_RUN = 8
_GRAVITY = re.compile(r"\b(m?)g\b")
_POUND = re.compile(r"\b(lb|oz)s?\b")


def _as_engineers_write(plain: str) -> Iterator[str]:
    """Other readings of a unit: signs between names as products, names run together taken apart, g
    as an acceleration, lb and oz as forces."""
    # rad/Nm is rad/(N*m): what is run together behind a stroke stands below it as a whole.
    below = re.sub(r"/([^*/()\s]+)", r"/(\1)", plain)
    spelt = _POWER_BEHIND.sub(r"^\1", _BETWEEN.sub("*", below))
    spelt = re.sub(r"\^(-\d)", r"^(\1)", spelt)
    words = list(dict.fromkeys(_RUN_TOGETHER.findall(spelt)))
    spellings = [[word, *_taken_apart(word)] for word in words if len(word) <= _LONGEST_RUN]
    for chosen in islice(product(*spellings), _MOST_READINGS):
        parts = dict(zip(words, chosen, strict=False))
        yield _respelt(spelt, parts)
    yield _GRAVITY.sub(r"\1g_n", spelt)
    yield _POUND.sub(r"\1f", spelt)


_MOST_READINGS = 200
"""Of a unit: a word of eight letters can be taken apart in 127 ways at most."""


def _respelt(unit: str, parts: Mapping[str, str]) -> str:
    """The unit with some of its names replaced."""
    return _RUN_TOGETHER.sub(lambda found: parts.get(found[0], found[0]), unit)


def _taken_apart(word: str) -> Iterator[str]:
    """``Nms`` as ``N*ms`` and ``N*m*s``: all ways in which units that are written one after the
    other give a word."""
    for i in range(1, len(word)):
        first, rest = word[:i], word[i:]
        if not _is_named(first):
            continue
        # Nobody writes m*m as mm: in kgmm an exponent is missing.
        others = [rest, *_taken_apart(rest)] if _is_named(rest) else _taken_apart(rest)
        yield from (f"{first}*{other}" for other in others if first not in other.split("*"))


def _is_named(name: str) -> bool:
    """Whether a name is that of a known unit."""
    try:
        _named_unit(name)
    except KeyError:
        return False
    return True


def _proposal(plain: str, fits: Callable[[Powers], bool]) -> str:
    """A hint at what may be meant: the unit with its unknown names replaced by the nearest known
    ones, where that fits; else empty.

    All else stays as it was written, so that a proposal has the size of what was meant.
    """
    # Of several units in the same letters, as mHz and MHz, the first and the last.
    fitting: list[str] = []
    for k in (0, -1):
        respelt = _RUN_TOGETHER.sub(lambda found, k=k: _nearest(found[0])[k], plain)  # type: ignore[misc]
        with suppress(SceneError):
            known = None if respelt in (plain, *fitting) else _reading(respelt, respelt, fits)
            if known is not None and fits(known[1]):
                fitting.append(respelt)
    return f"did you mean {' or '.join(map(quoted, fitting))}?" if fitting else ""


def _nearest(word: str) -> list[str]:
    """The known units nearest to an unknown name: the same in other letters (khz), or the most
    similar spelling; the name itself where there is none."""
    if _is_named(word):
        return [word]
    same = [x for x in _SPELT if x.lower() == word.lower()]
    likely = re.search('"(.*)"', meant(word, [*_units(), *_SPELT]))
    # What differs in a prefix alone has another size.
    if likely and not word.endswith(likely[1]) and not likely[1].endswith(word):
        same = same or [likely[1]]
    return same or [word]


@dataclass(frozen=True, slots=True)
class _Size:
    """A unit in SI: a number, which a root may leave as a float, and powers of pi, kg, m and s.
    Radians are 1."""

    factor: Fraction | float
    powers: tuple[Fraction, ...] = (Fraction(0),) * 4

    def __mul__(self, other: _Size) -> _Size:
        return _Size(self.factor * other.factor, tuple(map(add, self.powers, other.powers)))

    def __truediv__(self, other: _Size) -> _Size:
        return self * other**-1

    def __pow__(self, n: int | Fraction) -> _Size:
        return _Size(self.factor**n, tuple(n * x for x in self.powers))


def _unit_number(text: str) -> _Size:
    """The number 1 in a unit, as in 1/s; ValueError for another, which belongs to the quantity."""
    if text != "1":
        raise ValueError("a unit has no number but 1")
    return _Size(Fraction(1))


def _named_unit(name: str) -> _Size:
    """The size of a unit by its name or symbol, also with a prefix or in the plural; KeyError for
    an unknown name."""
    known = _units()
    # The name itself first: "ms" is a millisecond. Only words have a plural: "mms" is no plural of
    # mm, as a prefix before a single letter makes a symbol.
    singular = [name[:-1]] if name.endswith("s") and len(name) > 2 else []
    for spelt in (name, *singular):
        if spelt in known:
            return known[spelt]
        for prefix, power in _PREFIXES.items():
            unit = spelt[len(prefix) :]
            is_word = spelt == name or len(unit) > 1
            if spelt.startswith(prefix) and is_word and unit in known:
                return _Size(Fraction(10) ** power) * known[unit]
    raise KeyError(name)


_PREFIXES = {
    name: power
    for power, names in {
        12: "tera T",
        9: "giga G",
        6: "mega M",
        3: "kilo k",
        2: "hecto h",
        1: "deca da",
        -1: "deci d",
        -2: "centi c",
        -3: "milli m",
        -6: "micro \N{MICRO SIGN} \N{GREEK SMALL LETTER MU} u",
        -9: "nano n",
    }.items()
    for name in names.split()
}
_DEFINED = (
    ("gram g", "0.001", "kg"),
    ("tonne t", "1000", "kg"),
    ("metre", "1", "m"),
    ("second sec", "1", "s"),
    ("pound lb lbm", "0.45359237", "kg"),
    ("ounce oz", "1/16", "lb"),
    ("inch inches in", "0.0254", "m"),
    ("foot feet ft", "12", "in"),
    ("minute min", "60", "s"),
    ("radian", "1", "rad"),
    ("hertz Hz", "2", "pi*rad/s"),
    ("degree deg °", "1/180", "pi*rad"),
    ("revolution rev", "2", "pi*rad"),
    ("revolutions_per_minute rpm", "1", "rev/min"),
    ("percent %", "0.01", "rad"),
    ("newton N", "1", "kg*m/s^2"),
    ("joule J", "1", "N*m"),
    ("force_pound lbf", "9.80665", "lb*m/s^2"),
    ("force_ounce ozf", "1/16", "lbf"),
    ("force_gram gf", "0.00980665", "N"),
    ("kilopond kp", "1000", "gf"),
    ("dyne dyn", "0.00001", "N"),
    ("slug", "1", "lbf*s^2/ft"),
    ("standard_gravity g_n G", "9.80665", "m/s^2"),
)
"""Names, and what they are of a unit that stands before: exact, by definition."""


@cache
def _units() -> dict[str, _Size]:
    """All units by name, without prefixes."""
    one = Fraction(1)
    base = {
        name: _Size(one, tuple(Fraction(i == k) for k in range(4)))
        for i, name in enumerate(("pi", "kg", "m", "s"))
    }
    known = {**base, "kilogram": base["kg"], "meter": base["m"], "rad": _Size(one)}
    for names, factor, of in _DEFINED:
        size = _Size(Fraction(factor)) * evaluate(
            of, number=_unit_number, name=known.__getitem__, sums=False
        )
        known |= dict.fromkeys(names.split(), size)
    return known


_OWN = {"": {}, "kg": {"mass": 1}, "kg*m^2": {"mass": 1, "length": 2}, "rad/s": {"time": -1}}
"""Units that are not written with newtons, metres and seconds."""


def si_unit(exponents: tuple[tuple[str, Fraction], ...]) -> str:
    """The SI unit with these base dimensions; empty where they have none that is written without
    fractions.

    >>> si_unit((("time", Fraction(-1)),)), si_unit((("length", Fraction(-1)), ("mass", Fraction(1))))
    ('rad/s', 'N*s^2/m^2')
    """
    remaining = dict(exponents)
    for name, dimensions in _OWN.items():
        if remaining == dimensions:
            return name
    # kg = N s^2/m: mass is written in newtons, as an engineer writes N*s/m for kg/s.
    newtons = remaining.pop("mass", Fraction(0))
    metres, seconds = (
        remaining.pop("length", Fraction(0)) - newtons,
        remaining.pop("time", Fraction(0)) + 2 * newtons,
    )
    # Units are printed with superscripts of one digit.
    powers = {"N": newtons, "m": metres, "s": seconds}
    if remaining or any(x.denominator > 1 or abs(x) > 9 for x in powers.values()):
        return ""
    above, below = (
        [name if abs(x) == 1 else f"{name}^{abs(x)}" for name, x in powers.items() if sign * x > 0]
        for sign in (1, -1)
    )
    return "/".join(["*".join(above) or "1", *below])


_SPELT = [
    f"{prefix}{unit}"
    for unit in ("Hz", "N", "J", "m", "s", "g", "rad")
    for prefix in ("", "k", "m", "M", "c", "u")
]
"""The spellings that are meant where a unit is written in other letters, as HZ or khz."""


Number: TypeAlias = "str | int | float | Decimal | Fraction | Expr"

Exponents: TypeAlias = tuple[tuple[str, Fraction], ...]

_NUMBER = re.compile(
    r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)(?:\s*/\s*(\d+)(?![\w.]))?\s*(.*?)\s*",
    re.DOTALL,
)
_POWER = re.compile(r"\^(\d)")
# Characters of a number; 200 digits are more than any measurement has.
_LONGEST = 200
# Of ten; beyond it a float could not show the result.
_LARGEST_EXPONENT = 300


class MotionKind(Enum):
    """Whether the hand moves along a line (m, N) or about an axis (rad, N m)."""

    TRANSLATION = "translational"
    ROTATION = "rotational"


class Dimension(Enum):
    """What a parameter measures: its unit for a translation and for a rotation."""

    MASS = ("kg", "kg*m^2")
    DAMPING = ("N*s/m", "N*m*s/rad")
    STIFFNESS = ("N/m", "N*m/rad")
    FORCE = ("N", "N*m")
    DISPLACEMENT = ("m", "rad")
    FREQUENCY = ("rad/s", "rad/s")
    TIME = ("s", "s")
    RATIO = ("1", "1")
    ANY = ("", "")

    def unit(self, motion: MotionKind | None) -> str:
        """The unit's name, for a known kind of motion; both names where the motion is not known.

        >>> Dimension.MASS.unit(MotionKind.ROTATION), Dimension.MASS.unit(None), Dimension.TIME.unit(None)
        ('kg*m^2', 'kg or kg*m^2', 's')
        """
        translation, rotation = self.value
        if motion is None and translation != rotation:
            return f"{translation} or {rotation}"
        return rotation if motion is MotionKind.ROTATION else translation


def unit_text(unit: str) -> str:
    """The name of a unit as it is printed.

    >>> unit_text("kg*m^2"), unit_text("N s/m^3"), unit_text("N/m or N*m/rad")
    ('kg·m²', 'N·s/m³', 'N/m or N·m/rad')
    """
    each = (x.replace("*", "·").replace(" ", "·") for x in unit.split(" or "))
    return _POWER.sub(lambda x: "⁰¹²³⁴⁵⁶⁷⁸⁹"[int(x[1])], " or ".join(each))


@dataclass(frozen=True, slots=True)
class Unit:
    """A unit by its name, and its size in SI (rad/s of a frequency)."""

    name: str
    size: Expr = Integer(1)

    @property
    def text(self) -> str:
        """The name as it is printed: ``N·m/rad``."""
        return unit_text(self.name)


RADIANS, HERTZ = Unit("rad/s"), Unit("Hz", 2 * pi)


@dataclass(frozen=True, slots=True)
class Quantity:
    """An exact SI value (rational times a power of pi, or a symbolic expression) and the motion its
    unit implies."""

    value: Expr
    motion: MotionKind | None = None
    exponents: Exponents | None = None
    """Exponents of the base dimensions, ``(("mass", 1), ("time", -2))`` for N/m; None where no unit
    was given."""
    unit: Unit | None = field(default=None, repr=False, compare=False)
    """The unit as it was written, in which pages print; None where it is the SI unit."""


def quantity(given: Number, dimension: Dimension) -> Quantity:
    """Read a number, or a string of number and unit, exactly.

    ``given``: an int, Decimal, Fraction, float (read as its shortest decimal text), NumPy's of any
    width, SymPy expression, or a string such as ``"1.8 kg"``, ``"9/5 kg"`` or ``"0.5"``. Bare
    numbers are SI and rad/s. Raises SceneError, naming the value and the unit expected, for
    anything else: NaN, infinities, unknown units, wrong dimensions.

    >>> quantity("1.8 kg", Dimension.MASS)
    Quantity(value=9/5, motion=<MotionKind.TRANSLATION: 'translational'>, exponents=(('mass', Fraction(1, 1)),))
    >>> quantity("15 Hz", Dimension.FREQUENCY).value, quantity(0.1, Dimension.RATIO).value
    (30*pi, 1/10)
    >>> quantity("15 N", Dimension.STIFFNESS)
    Traceback (most recent call last):
      ...
    haptisym.kernel.errors.SceneError: "15 N" is not a stiffness. Stiffnesses: N/m, N/mm, N*m/rad.
    """
    refuse_units(given)
    if isinstance(given, str):
        return _from_text(given, dimension)
    if isinstance(given, Expr | RealNumber):
        exact = in_sympy(given) if isinstance(given, RealNumber) else given
        if exact.has(Proven):
            raise SceneError(f"{quoted(given)} is no rational number: give digits, as x.digits(20)")
        return Quantity(_exact_expression(exact))
    if isinstance(given, Fraction):
        return Quantity(Rational(given.numerator, given.denominator))
    if isinstance(given, Real | Decimal) and not isinstance(given, bool):
        return Quantity(decimal(str(given)))
    # A bool is an int of Python, and is no number here; it is shown as TOML writes it.
    shown = str(given).lower() if isinstance(given, bool) else quoted(given)
    raise SceneError(f"{shown} is not a quantity: give a number, or a string of number and unit")


def refuse_units(given: object) -> None:
    """SceneError for a quantity with a unit of Pint or SymPy, with how to write it."""
    parts = preorder_traversal(given) if isinstance(given, Expr) else ()
    # The class of an applied function of SymPy, f(x), has None for its module.
    is_of_sympy = any(str(type(x).__module__).startswith("sympy.physics.units") for x in parts)
    if is_of_sympy or (hasattr(given, "magnitude") and hasattr(given, "units")):
        raise SceneError(
            f'{quoted(given)} has units of another package: give text, as "100 N/m", or a number '
            f"in SI units"
        )


def number(given: Number, dimension: Dimension) -> Quantity:
    """Read a number, or a string of number and unit, as ``quantity``; SceneError for a symbol, too.

    >>> from sympy import Symbol
    >>> number(Symbol("k"), Dimension.STIFFNESS)
    Traceback (most recent call last):
      ...
    haptisym.kernel.errors.SceneError: "k" must be a number
    """
    return require_number(given, quantity(given, dimension))


def require_number(given: object, read: Quantity) -> Quantity:
    """Return the quantity that was read from ``given``; SceneError where it has a symbol in it."""
    if read.value.free_symbols:
        raise SceneError(f"{quoted(given)} must be a number")
    return read


def decimal(text: str) -> Rational:
    """The exact rational number that a decimal text means.

    >>> decimal("1.8"), decimal("-2.5e-3")
    (9/5, -1/400)
    """
    match = _NUMBER.fullmatch(text)
    if match is None or match[3]:
        raise SceneError(f"{quoted(text)} is not a finite decimal number")
    return _rational(match, text)


def with_decimals(given: Expr) -> Expr:
    """The expression with each Float as the decimal that it is written as: of a double the
    shortest, of others all digits.

    SceneError for one that is too large or too small to be read as a number.

    >>> with_decimals(Float("0.12345678901234567890123", 23) * Symbol("k") + 0.1)
    12345678901234567890123*k/100000000000000000000000 + 1/10
    """
    return given.xreplace(
        {x: decimal(str(float(x) if float(x) == x else x)) for x in given.atoms(Float)}
    )


def _rational(match: re.Match[str], text: str) -> Rational:
    """The exact number of a match of _NUMBER, a decimal or a decimal over a whole number."""
    # Lengths first: Fraction("1e999999999") would be computed to its last digit.
    number = match[1]
    exponent = re.split("[eE]", number)[1:] or ["0"]
    if len(number) > _LONGEST or len(match[2] or "") > _LONGEST:
        raise SceneError(f"{quoted(text)}: a number may have at most {_LONGEST} characters")
    if len(exponent[0]) > 4 or abs(int(exponent[0])) > _LARGEST_EXPONENT:
        raise SceneError(
            f"{quoted(text)}: an exponent of ten must lie from -{_LARGEST_EXPONENT} to "
            f"{_LARGEST_EXPONENT}"
        )
    below = int(match[2] or 1)
    if below == 0:
        raise SceneError(f"{quoted(text)} divides by zero")
    exact = Fraction(number) / below
    return Rational(exact.numerator, exact.denominator)


_BELOW = re.compile(r"/\s*\(?\s*([.\d].*?)\s*\)?")
"""The end of a text such as ``1/(4 ms)``."""


def _inverse(value: Expr, below: str, dimension: Dimension) -> str:
    """Return an example for what a number over a time is; empty where it is no frequency."""
    with suppress(SceneError):
        if dimension is Dimension.FREQUENCY and (time := quantity(below, Dimension.TIME)).exponents:
            return f', as "{_decimal(value / time.value)} rad/s"'
    return ""


def _decimal(value: Expr) -> str:
    """Return a number in a sentence, to six digits."""
    return f"{float(value):.6g}"


def _from_text(text: str, dimension: Dimension) -> Quantity:
    """Read a string of a number and maybe a unit."""
    match = _NUMBER.fullmatch(text)
    if match is None:
        unit = "" if dimension.value[0] in ("", "1") else " with a unit"
        raise SceneError(f"{quoted(text)} is not a finite number{unit}.{expected(dimension)}")
    # "1,8 kg" matches as 1 with the unit ",8 kg".
    if match[3] and re.match(r",\d", match[3]):
        raise SceneError(
            f"{quoted(text)}: decimals are written with a point, as in {text.replace(',', '.', 1)}"
        )
    value, unit = _rational(match, text), match[3]
    if not unit:
        return Quantity(value)
    if below := _BELOW.fullmatch(unit):
        raise SceneError(
            f"{quoted(text)}: a quotient of quantities is not computed: write its value with a "
            f"unit{_inverse(value, below[1], dimension)}.{expected(dimension)}"
        )
    factor, exponents = read_unit(
        unit, text, expected(dimension), lambda powers: _has_dimension(powers, dimension)
    )
    # A sampling time given as a rate, "1 kHz": the message says the period.
    if dimension is Dimension.TIME and exponents == {"time": -1} and value > 0:
        raise SceneError(
            f"{quoted(text)} is not a time; its period is {2 * pi / (value * factor)} "
            f"s.{expected(dimension)}"
        )
    if dimension is Dimension.FREQUENCY and exponents == {"time": 1} and value > 0:
        raise SceneError(
            f"{quoted(text)} is not a frequency; as a time constant it belongs to "
            f"{_decimal(1 / (value * factor))} rad/s.{expected(dimension)}"
        )
    motion = _motion(exponents, text, dimension)
    written = None if factor == 1 else Unit(_plain(unit), factor)
    return Quantity(_sized(value * factor, text), motion, tuple(sorted(exponents.items())), written)


def _has_dimension(powers: Powers, dimension: Dimension) -> bool:
    """Whether a unit with these base dimensions is one of a dimension, for either motion."""
    return dimension is Dimension.ANY or powers in _dimension_exponents(dimension)


def _motion(exponents: dict[str, Fraction], text: str, dimension: Dimension) -> MotionKind | None:
    """The motion that a unit implies for a dimension; None where both have the same unit.

    SceneError where the unit is another dimension's.
    """
    translation, rotation = _dimension_exponents(dimension)
    if dimension is Dimension.ANY:
        return None
    if exponents == translation:
        return None if translation == rotation else MotionKind.TRANSLATION
    if exponents == rotation:
        return MotionKind.ROTATION
    raise SceneError(f"{quoted(text)} is not a {dimension.name.lower()}.{expected(dimension)}")


def dimension_exponents(dimension: Dimension, motion: MotionKind | None) -> Exponents | None:
    """The base dimensions of what a parameter measures; None for one of any dimension.

    >>> dimension_exponents(Dimension.DAMPING, MotionKind.ROTATION)
    (('length', Fraction(2, 1)), ('mass', Fraction(1, 1)), ('time', Fraction(-1, 1)))
    """
    if dimension is Dimension.ANY:
        return None
    return tuple(sorted(_dimension_exponents(dimension)[motion is MotionKind.ROTATION].items()))


def fits(dimension: Dimension, exponents: Exponents | None, wanted: Dimension) -> bool:
    """Whether a quantity of a dimension (with these exponents, if any unit told them) may stand
    where one is wanted.

    >>> fits(Dimension.MASS, None, Dimension.STIFFNESS), fits(Dimension.ANY, None, Dimension.STIFFNESS)
    (False, True)
    """
    if Dimension.ANY not in (dimension, wanted):
        return dimension is wanted
    return wanted is Dimension.ANY or exponents in (
        None,
        *(dimension_exponents(wanted, motion) for motion in MotionKind),
    )


def implied_motion(dimension: Dimension, exponents: Exponents | None) -> MotionKind | None:
    """The motion for which a dimension has these exponents; None where neither or both have.

    >>> implied_motion(Dimension.MASS, (("length", Fraction(2)), ("mass", Fraction(1))))
    <MotionKind.ROTATION: 'rotational'>
    """
    motions = [
        motion for motion in MotionKind if dimension_exponents(dimension, motion) == exponents
    ]
    return motions[0] if len(motions) == 1 else None


@cache
def _dimension_exponents(dimension: Dimension) -> tuple[dict[str, Fraction], dict[str, Fraction]]:
    """The base dimensions of its units for translation and for rotation, from the units' names."""
    translation, rotation = (
        {} if unit in ("", "1") else read_unit(unit, unit, "")[1] for unit in dimension.value
    )
    return translation, rotation


def refuse_unreal(symbols: Iterable[Symbol]) -> None:
    """SceneError, by name, for a symbol that was declared to be something else than a real number
    that may be varied.

    >>> refuse_unreal([Symbol("q", imaginary=True)])
    Traceback (most recent call last):
      ...
    haptisym.kernel.errors.SceneError: the symbol q is declared imaginary: a parameter is real, as Symbol("q", positive=True)
    """
    for x in sorted(symbols, key=str):
        declared = [word for word in ("imaginary", "zero", "infinite") if getattr(x, f"is_{word}")]
        declared += [
            f"not {word}" for word in ("commutative", "real") if getattr(x, f"is_{word}") is False
        ]
        if declared:
            way = f'a parameter is real, as Symbol("{x}", positive=True)'
            raise SceneError(f"the symbol {x} is declared {declared[0]}: {way}")


def in_laplace(given: Expr, variable: Symbol | None = None, frequency: Symbol = omega) -> Expr:
    """A user's expression in ``variable`` (None: a symbol called s), or in I times ``frequency`` or
    omega, as one in haptisym's ``s``, with floats read as decimals.

    Its other symbols are real parameters. Raises SceneError, by name, where it is no real function
    of s: an I that does not cancel, a symbol that was declared not to be real, a parameter called
    s, or another letter, p or S, that may be meant as s.

    >>> in_laplace(1 / (1 + Symbol("p") * 0.1), Symbol("p"))
    1/(s/10 + 1)
    >>> in_laplace(3 * I * omega + 100 - omega**2)
    s**2 + 3*s + 100
    >>> in_laplace(3 * I * Symbol("w") + 100)
    Traceback (most recent call last):
      ...
    haptisym.kernel.errors.SceneError: "3*I*w + 100" contains I: write the system in s, or in I*w, as distort(..., omega=w)
    """
    # A user's own Symbol("s") is the Laplace variable where no other one is named. With an
    # assumption, as real, it was meant as a parameter, and two symbols called s are ambiguous.
    refuse_units(given)
    known, free = (variable or s).name, given.free_symbols
    laplace = {x for x in free if x.name == known}
    if len(laplace) > 1 or (known != s.name and s.name in {x.name for x in free}):
        raise SceneError(
            f"{quoted(given)}: s is the Laplace variable: a parameter needs another name"
        )
    if variable is None and any(
        x.is_real is not None or x.is_commutative is False for x in laplace
    ):
        raise SceneError(f'{quoted(given)}: declare s without assumptions: Symbol("s")')
    waves = {x for x in free - laplace if x.name in (omega.name, frequency.name)}
    others = free - laplace - waves
    # A parameter called omega beside s would be taken for the frequency.
    if laplace and waves:
        letter = min(x.name for x in waves)
        raise SceneError(
            f"{quoted(given)} contains {known} and {letter}, which is omega: write it in one of "
            f"them, and give a parameter another name"
        )
    if "j" in {x.name for x in others}:
        raise SceneError(f"{quoted(given)} contains j: write SymPy's I, or give it another name")
    refuse_unreal(others)
    if given.has(nan, oo, -oo, zoo):
        raise SceneError(f"{quoted(given)} is not finite")
    # Nobody leaves out both s and omega in dynamics, and a parameter is seldom called p or S.
    asked = {x.name for x in others if x.is_real is None} & {"p", "S"}
    if asked and variable is None and not laplace and not waves:
        name = min(asked)
        raise SceneError(
            f"{quoted(given)}: is {name} the Laplace variable? Write s, or distort(..., "
            f'laplace={name}); a parameter is Symbol("{name}", positive=True)'
        )
    form = with_decimals(_turned(given, waves).xreplace(dict.fromkeys(laplace, s)))
    if (degree := _degree(form)) > HIGHEST_DEGREE:
        most = HIGHEST_DEGREE
        raise SceneError(
            f"{quoted(given)} has the degree {degree} in s; at most {most} is possible"
        )
    return _without_i(form, given, waves) if form.has(I) else form


_ANALYTIC = Add | Mul | Pow | exp | cos | sin | tan | cosh | sinh | tanh | coth


def _turned(given: Expr, waves: set[Symbol]) -> Expr:
    """An expression with s/j in place of frequencies; SceneError where that is not exact, as in
    |omega|, which is no analytic function."""
    for x in preorder_traversal(given) if waves else ():
        if not x.args or not x.has(*waves):
            continue
        # Of all roots only those of a multiple of omega itself are what they are in s, too.
        root = x.is_Pow and not x.exp.is_Integer and x.base.as_independent(*waves)[1] not in waves
        if root or not isinstance(x, _ANALYTIC):
            raise SceneError(f"{quoted(given)}: {x} is no function of I*omega: write it in s")
    # As a positive symbol, s leaves fractional powers of j omega in one piece.
    laplace = Dummy(positive=True)
    form = given.xreplace(dict.fromkeys(waves, -I * laplace))
    # Of j^a and (-j)^a, as powers of -1, SymPy sees that they cancel.
    units = {x: Pow(-1, x.exp / (2 * x.base / I)) for x in form.atoms(Pow) if x.base in (I, -I)}
    return form.xreplace(units).xreplace({laplace: s})


def _degree(x: Expr) -> int:
    """An upper bound on the degree in s of the expanded expression: of sums the largest, of
    products and quotients the sum."""
    if x == s:
        return 1
    if isinstance(x, Pow) and x.exp.is_Rational:
        degree: int = ceil(abs(x.exp) * _degree(x.base))
        return degree
    degrees = [_degree(y) for y in x.args] if isinstance(x, Add | Mul) else []
    return sum(degrees) if isinstance(x, Mul) else max(degrees, default=0)


def _without_i(expression: Expr, given: Expr, waves: set[Symbol]) -> Expr:
    """The expression as a quotient of real polynomials; SceneError where an I does not cancel."""
    # Over one denominator and expanded, I^2 = -1 is put in and pairs of conjugates become real.
    above, below = (expand(x) for x in fraction(together(expression)))
    if above.has(I) or below.has(I):
        letter = min((x.name for x in waves), default="w")
        contents, way = (letter, "") if waves else ("I", "write it in s, with real numbers")
        if not given.has(s):
            end = " with real numbers" if waves else f", as distort(..., omega={letter})"
            way = f"write the system in s, or in I*{letter}{end}"
        raise SceneError(f"{quoted(given)} contains {contents}: {way}")
    return above / below


def constant(given: Number) -> Expr:
    """A value for a parameter, exact: a number, a string of number and unit, or an expression in
    parameters; SceneError for one in s or omega, and for anything else.

    >>> constant("2 ms"), constant(2 * Symbol("b", positive=True)**0.5)
    (1/500, 2*sqrt(b))
    """
    if isinstance(given, RealNumber):
        given = in_sympy(given)
    if not isinstance(given, Expr):
        return quantity(given, Dimension.ANY).value
    refuse_unreal(given.free_symbols)
    if frequencies := sorted({x.name for x in given.free_symbols} & {"s", "omega", "j"}):
        raise SceneError(f"{quoted(given)} contains {frequencies[0]}: give a constant")
    return in_laplace(given, s)


def _exact_expression(given: Expr) -> Expr:
    """The expression with its floats read as decimals; SceneError for a number that is not finite,
    not real or not rational in pi."""
    refuse_unreal(given.free_symbols)
    exact = with_decimals(given)
    # Values are rational, or rational in pi, which all rings hold as a variable; nothing else.
    known = all(
        isinstance(x, Rational) or x == pi or x.args
        for x in preorder_traversal(exact)
        if x.is_number
    )
    if exact.has(nan, zoo, oo, -oo, I) or (
        exact.is_number and (not known or any(not x.exp.is_Integer for x in exact.atoms(Pow)))
    ):
        raise SceneError(f"{quoted(given)} is not a finite number, rational or rational in pi")
    return exact


def _sized(value: Expr, text: str) -> Expr:
    """Return the value; SceneError where it is not 0 and no float could show it."""
    if value != 0 and not Float("1e-300") < abs(value.evalf(5)) < Float("1e300"):
        raise SceneError(f"{quoted(text)}: in SI units it must lie between 1e-300 and 1e300")
    return value


_UNITS = {
    Dimension.MASS: "Masses: kg, g, kg*m^2",
    Dimension.DAMPING: "Dampings: N*s/m, N*m*s/rad",
    Dimension.STIFFNESS: "Stiffnesses: N/m, N/mm, N*m/rad",
    Dimension.FORCE: "Forces: N, mN, N*m",
    Dimension.DISPLACEMENT: "Displacements: m, mm, rad, deg",
    Dimension.FREQUENCY: "Frequencies: rad/s, Hz, rpm",
    Dimension.TIME: "Times: s, ms, us",
    Dimension.RATIO: "Ratios: a plain number, %",
}


def expected(dimension: Dimension) -> str:
    """The units that a dimension may have, the end of a message; empty where any may be.

    >>> expected(Dimension.TIME), expected(Dimension.ANY)
    (' Times: s, ms, us.', '')
    """
    return f" {_UNITS[dimension]}." if dimension in _UNITS else ""


def is_number(text: str) -> bool:
    """Whether a cell of a file is a number."""
    try:
        float(text)
    except ValueError:
        return False
    return True
