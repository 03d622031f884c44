"""Expressions as text in each language, by SymPy's printers: numbers as the nearest doubles, names of our choosing.

Every printer is made for one piece of code and thrown away: SymPy's own printers and their tables stay as they are.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from flint import ctx
from sympy import Add, Expr, Float, Integer, Pow, Symbol, pi, preorder_traversal
from sympy.printing.c import C99CodePrinter
from sympy.printing.codeprinter import CodePrinter
from sympy.printing.jscode import JavascriptCodePrinter
from sympy.printing.julia import JuliaCodePrinter
from sympy.printing.numpy import NumPyPrinter
from sympy.printing.octave import OctaveCodePrinter
from sympy.printing.precedence import PRECEDENCE

from haptisym.kernel.errors import SceneError
from haptisym.kernel.reals import ExactNumber, bounds, expression_ball
from haptisym.programs.steps import map_numbers
from haptisym.writing.code.names import Language

_MOST_FACTORS = 12  # of a whole power that is written as a product
_LARGEST_WHOLE = 2**53  # whole numbers up to here are doubles


class _Written:
    """What all languages share: numbers, names, and whole powers as products."""

    times = "*"
    whole_numbers = True
    """Whether a whole number may be written without a point."""

    def __init__(self, names: Mapping[Symbol, str], helpers: Mapping[str, str]) -> None:
        super().__init__()
        self.names, self.helpers = names, helpers

    def text(self, expression: Expr) -> str:
        """The expression in this language; its numbers are taken as ``in_doubles`` leaves them."""
        text: str = self.doprint(expression)  # type: ignore[attr-defined]
        return text[1:-1] if _is_product(expression) else text

    def _print_Symbol(self, symbol: Symbol) -> str:
        return self.names[symbol]

    def _print_Float(self, number: Expr) -> str:
        value = float(number)
        return str(int(value)) if self.whole_numbers and value.is_integer() and abs(value) < 1e15 else repr(value)

    _print_Rational = _print_Integer = _print_Zero = _print_One = _print_NegativeOne = _print_Half = _print_Float

    def _print_Pow(self, power: Expr) -> str:
        if power.exp.is_Rational and power.exp < 0:
            below = self.parenthesize(Pow(power.base, -power.exp), PRECEDENCE["Pow"], strict=True)  # type: ignore[attr-defined]
            return f"{self._print(Integer(1))}{self.times[:-1]}/{below}"  # type: ignore[attr-defined]
        if _is_product(power):
            base = self.parenthesize(power.base, PRECEDENCE["Mul"], strict=True)  # type: ignore[attr-defined]
            return f"({self.times.join([base] * int(power.exp))})"
        text: str = super()._print_Pow(power)  # type: ignore[misc]
        return text

    def _print_sinc(self, function: Expr) -> str:
        return f"{self.helpers[type(function).__name__]}({self._print(function.args[0])})"  # type: ignore[attr-defined]

    _print_sincm1 = _print_sinc


class _NumPy(_Written, NumPyPrinter):  # type: ignore[misc]  # SymPy ships no types
    def _module_format(self, fqn: str, register: bool = True) -> str:  # noqa: FBT001, FBT002 - SymPy's signature
        return fqn.replace("numpy.", "np.", 1)


class _C(_Written, C99CodePrinter):  # type: ignore[misc]
    whole_numbers = False

    def _print_Pi(self, number: Expr) -> str:
        return "pi"

    def _print_Exp1(self, number: Expr) -> str:
        return repr(float(number))


class _Octave(_Written, OctaveCodePrinter):  # type: ignore[misc]
    times = ".*"


class _Julia(_Written, JuliaCodePrinter):  # type: ignore[misc]
    """Scalars: a dotted call does the broadcasting, so no operator is dotted."""

    whole_numbers = False
    _print_Mul = CodePrinter._print_Mul

    def _print_Pow(self, power: Expr) -> str:
        return (
            super()._print_Pow(power).replace(" ./ ", "/").replace(" / ", "/").replace(" .^ ", "^").replace(" ^ ", "^")
        )


class _JavaScript(_Written, JavascriptCodePrinter):  # type: ignore[misc]
    pass


_PRINTERS: Mapping[Language, type[_Written]] = {
    Language.NUMPY: _NumPy,
    Language.C: _C,
    Language.OCTAVE: _Octave,
    Language.JULIA: _Julia,
    Language.JAVASCRIPT: _JavaScript,
}


def printer(
    language: Language, names: Mapping[Symbol, str], helpers: Mapping[str, str] = MappingProxyType({})
) -> _Written:
    """A printer for one piece of code; ``helpers`` : what the functions ``sinc`` and ``sincm1`` are called there.

    >>> from sympy import Rational, sqrt, symbols
    >>> a, b = symbols("a b")
    >>> for language in Language:
    ...     printer(language, {a: "a", b: "b"}).text(in_doubles(a**2 / (3 * sqrt(b)) + pi))
    '0.3333333333333333*(a*a)/np.sqrt(b) + np.pi'
    '0.3333333333333333*(a*a)/sqrt(b) + pi'
    '0.3333333333333333*(a.*a)./sqrt(b) + pi'
    '0.3333333333333333*(a*a)/sqrt(b) + pi'
    '0.3333333333333333*(a*a)/Math.sqrt(b) + Math.PI'
    """
    return _PRINTERS[language](names, helpers)


def _is_product(expression: Expr) -> bool:
    """Whether it is a whole power that is written as a product."""
    return isinstance(expression, Pow) and bool(expression.exp.is_Integer) and 1 < expression.exp <= _MOST_FACTORS


def in_doubles(expression: Expr) -> Expr:
    """The expression with each number in it as the double nearest to its exact value; pi by itself stays pi.

    Numbers that stand together, as in 2 sqrt(3) pi omega, are one. Raises SceneError where no double is near.
    """
    return map_numbers(expression, _in_double)


def _in_double(number: Expr) -> Expr:
    if number in (pi, -pi) or (isinstance(number, Integer) and abs(number) <= _LARGEST_WHOLE):
        return number
    return Float(nearest_double(number), precision=53)


def nearest_double(number: Expr) -> float:
    """The double nearest to an exact number.

    >>> from sympy import Rational
    >>> nearest_double(Rational(1, 3)), nearest_double(40 * pi)
    (0.3333333333333333, 125.66370614359172)
    """
    try:
        return 0.0 if _vanishes(number) else float(ExactNumber(number))
    except OverflowError:
        raise SceneError(f"{str(number)[:60]} is too large for a double, whose largest is 1.8e308") from None


def _vanishes(number: Expr) -> bool:
    """Whether a number made with roots is below 1e-600 of what it is a sum of: zero, or nothing beside any double."""
    if not any(isinstance(x, Add) for x in preorder_traversal(number)):
        return False
    with ctx.workprec(4096):
        low, high = bounds(expression_ball(number))
    return low <= 0 <= high
