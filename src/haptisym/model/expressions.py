"""The small safe grammar of formulas and units in scene files: numbers, names, ``+ - * / ^ **`` and parentheses.

::

    sum      = product {("+" | "-") product}
    product  = signed {("*" | "/") signed}
    signed   = ["+" | "-"] signed | power
    power    = atom [("^" | "**") exponent]
    exponent = ["+" | "-"] number | "(" ["+" | "-"] (number | whole "/" whole) ")"
    atom     = number | name | "(" sum ")"

Nothing is ever executed: a formula is data. Whoever evaluates it says what numbers and names mean.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from fractions import Fraction
from operator import add, mul, sub, truediv
from typing import Any, Generic, NamedTuple, NoReturn, TypeVar

from haptisym.kernel.errors import ExpressionError

T = TypeVar("T")

_TOKEN = re.compile(
    r"(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)|(?P<name>[^\W\d]\w*|[°%])|(?P<operator>\*\*|[-+*/^()])|(?P<space>\s+)"
)
_LARGEST = 99  # whole number in an exponent that is a quotient
LONGEST = 4000  # characters of a formula
DEEPEST = 60  # nested parentheses or signs; far below Python's recursion limit
HIGHEST_DEGREE = 60  # of the written-out formula; the threshold polynomial has about four times that degree
MOST_DIGITS = 2000  # of the numbers in the written-out formula


_DELAY = 'a delay is an effect of its own, [[effects]] with model = "delay" and tau, and is exact there'
_INSTEAD = {
    "sqrt": "a root is a power, as in s^0.5",
    **dict.fromkeys(("cosh", "sinh", "tanh"), 'a line with delay is the effect model = "wave-variables"'),
    **dict.fromkeys(("sin", "cos", "tan", "log", "ln", "abs"), "it is built of numbers, names, + - * / and ^ alone"),
}


class _Token(NamedTuple):
    kind: str
    text: str
    at: int


class _Value(NamedTuple):
    """A value with bounds on what it would be when written out: its degree in the names, its digits."""

    value: Any
    degree: int
    digits: int


def evaluate(text: str, *, number: Callable[[str], T], name: Callable[[str], T], sums: bool = True) -> T:
    """The value of a formula, in whatever ring ``number`` and ``name`` map to (they may raise KeyError or ValueError).

    Without ``sums`` only products, quotients and powers are in the grammar, as in a unit.

    Raises ExpressionError, with a caret under the place, for whatever is not in the grammar, too deep or too large.

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
        raise ExpressionError(f"a formula may have at most {LONGEST} characters; this one has {len(text)}")
    reader = _Reader(text, number, name, sums)
    result = reader.sum(0)
    if reader.token.kind != "end":
        reader.fail(f'expected an operator such as *, found "{reader.token.text}"')
    value: T = result.value
    return value


class _Reader(Generic[T]):
    """A recursive-descent reader: one method for each line of the grammar."""

    def __init__(self, text: str, number: Callable[[str], T], name: Callable[[str], T], sums: bool) -> None:  # noqa: FBT001
        self.text, self.number, self.name = text, number, name
        self.signs = ("+", "-") if sums else ()
        self.tokens = self._tokens()
        self.position = 0

    @property
    def token(self) -> _Token:
        return self.tokens[self.position]

    def fail(self, why: str, at: int | None = None) -> NoReturn:
        at = self.token.at if at is None else at
        start = max(0, at - 50)
        shown = self.text[start : at + 30].replace("\n", " ").replace("\t", " ")
        raise ExpressionError(f"{why}\n    {shown}\n    {' ' * (at - start)}^") from None

    def _tokens(self) -> list[_Token]:
        found, at = [], 0
        while at < len(self.text):
            match = _TOKEN.match(self.text, at)
            if match is None:
                self.tokens, self.position = [_Token("bad", self.text[at], at)], 0
                self.fail(
                    f'"{self.text[at]}" is not allowed in a formula (only numbers, names, + - * / ^ and parentheses)'
                )
            if match.lastgroup != "space":
                found.append(_Token(str(match.lastgroup), match[0], at))
            at = match.end()
        return [*found, _Token("end", "the end", len(self.text))]

    def take(self, *operators: str) -> _Token | None:
        token = self.token
        if token.kind == "operator" and token.text in operators:
            self.position += 1
            return token
        return None

    def sum(self, depth: int) -> _Value:
        left = self.product(depth)
        while sign := self.take(*self.signs):
            right = self.product(depth)
            degree, digits = max(left.degree, right.degree), left.digits + right.digits
            left = self._combine(add if sign.text == "+" else sub, left, right, (degree, digits), sign)
        return left

    def product(self, depth: int) -> _Value:
        left = self.signed(depth)
        while sign := self.take("*", "/"):
            right = self.signed(depth)
            grown = left.degree + right.degree, left.digits + right.digits
            left = self._combine(mul if sign.text == "*" else truediv, left, right, grown, sign)
        return left

    def signed(self, depth: int) -> _Value:
        if depth > DEEPEST:
            self.fail(f"a formula may be nested at most {DEEPEST} deep")
        if sign := self.take(*self.signs):
            operand = self.signed(depth + 1)
            return operand._replace(value=-operand.value) if sign.text == "-" else operand
        return self.power(depth)

    def power(self, depth: int) -> _Value:
        base = self.atom(depth)
        sign = self.take("^", "**")
        if sign is None:
            return base
        exponent = self.exponent()
        if self.take("^", "**"):
            self.position -= 1
            self.fail("a power of a power needs parentheses")
        size = abs(int(exponent)) + 1 if exponent.denominator != 1 else abs(int(exponent))
        whole = int(exponent) if exponent.denominator == 1 else exponent
        return self._combine(pow, base, _Value(whole, 0, 0), (base.degree * size, base.digits * max(size, 1)), sign)

    def exponent(self) -> Fraction:
        bracket = self.take("(")
        sign = self.take("+", "-")
        first, value = self.token, self._short()
        if bracket and self.take("/"):
            second, below = self.token, self._short()
            whole = first.text.isdigit() and second.text.isdigit()
            if not whole or not below or max(value, below) > _LARGEST:
                self.fail(
                    f"a quotient as an exponent is one of whole numbers up to {_LARGEST}, as in s^(1/3)", first.at
                )
            value /= below
        if bracket and not self.take(")"):
            is_open = self.token.kind == "end"
            self.fail(
                'expected ")"' if is_open else "an exponent must be one number, as in s^2 or s^(-1/2), not a formula"
            )
        return -value if sign and sign.text == "-" else value

    def _short(self) -> Fraction:
        """A number of an exponent."""
        token = self.token
        if token.kind != "number":
            self.fail("an exponent must be a number")
        if len(token.text) > 12 or "e" in token.text.lower():
            self.fail("an exponent must be a short plain number")
        self.position += 1
        return Fraction(token.text)

    def atom(self, depth: int) -> _Value:
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
        """A name with a parenthesis after it is no function, and e to a power of s no number: say what to write instead."""
        after = self.token.text
        if token.text == "exp" and after == "(":
            self.fail(f"a formula has no exp(...): {_DELAY}", token.at)
        if token.text == "e" and after in ("^", "**") and self.tokens[self.position + 1].kind != "number":
            self.fail(f"a formula has no powers of e: {_DELAY}", token.at)
        if after == "(":
            instead = _INSTEAD.get(token.text, f'if a product is meant, write "{token.text}*("')
            self.fail(f'a formula has no functions, and "{token.text}(" would be one: {instead}', token.at)

    def _meaning(self, read: Callable[[str], T], token: _Token, otherwise: str) -> T:
        try:
            return read(token.text)
        except KeyError:
            self.fail(f'{otherwise} "{token.text}"', token.at)
        except ValueError as error:
            self.fail(str(error), token.at)

    def _combine(
        self, operation: Callable[[Any, Any], Any], left: _Value, right: _Value, grown: tuple[int, int], sign: _Token
    ) -> _Value:
        degree, digits = grown
        if degree > HIGHEST_DEGREE:
            self.fail(f"the degree, {degree}, is higher than {HIGHEST_DEGREE}", sign.at)
        if digits > MOST_DIGITS:
            self.fail(f"written out, this has more than {MOST_DIGITS} digits", sign.at)
        try:
            if (operation is truediv and not right.value) or (operation is pow and right.value < 0 and not left.value):
                raise ZeroDivisionError
            return _Value(operation(left.value, right.value), degree, digits)
        except ZeroDivisionError:
            self.fail("division by zero", sign.at)
        except (TypeError, ValueError) as error:
            self.fail(str(error), sign.at)
