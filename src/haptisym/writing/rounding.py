"""Formulas whose numbers are rounded, and which are true as they are printed: this is tested before
they are.

Where large terms cancel, a formula with six digits of each has none left. So a rounded formula is
read as it is printed, each number the decimal that it looks like, and compared with the exact one;
if it is not true with few digits it gets more, and if it is not with many it is not printed.
Arguments of functions stay exact: a phase that is rounded drifts.

True is a formula of which each value that is tried is the exact one to four digits, or the exact
one at a frequency that is the same to four digits: near a zero it may move as the zero may. A
polynomial that is printed for its zeros must have the exact one's on the band to four digits, each
once, and no other: these are certified.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import mpmath
from sympy import Expr, Float, Integer, Rational, lambdify

from haptisym.kernel.dynamics import RealFunction
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.rings import omega, s
from haptisym.kernel.roots import chart

DIGITS = (6, 8, 10, 12)
"""Of each number of a formula, as few of these as do."""
_WITHIN = 0.5e-4
"""Half a unit of the fourth digit of 1: of a value, and of a frequency."""
_SHARES = (0.01, 0.05, *(n / 8 for n in range(1, 9)))
"""Where on a band values are compared."""
_INSIDE = 300
"""Digits of that comparison, so that some are left where terms cancel."""

Band = tuple[Expr, Expr]
ANYWHERE: Band = (Integer(0), Integer(100))
"""The band of a formula that is about none, rad/s."""


def faithful(
    form: Callable[[int | None], Expr], band: Band, digits: Sequence[int] = DIGITS
) -> tuple[Expr, str] | None:
    """A formula with its numbers rounded to as few digits as keep it true, and the sign to print
    before it; None where none do.

    ``form`` : the formula with so many digits, exact for None.

    >>> from sympy import cos
    >>> from haptisym.writing.layout import approximate
    >>> exact = Rational(10**7 + 1, 3) - Rational(10**7, 3) * cos(omega / 10**6)
    >>> faithful(lambda n: exact if n is None else approximate(exact, n), ANYWHERE)
    (3333333.66667 - 3333333.33333*cos(omega/1000000), '≈')
    """
    exact = form(None)
    # Computed once, when the first rounded formula has to be compared.
    true: list[tuple[float, Any, Any]] | None = None
    for count in digits:
        shown = form(count)
        printed = as_printed(shown)
        # Rounding may change nothing at all: then the formula is exact, and may have "=".
        if printed == exact:
            return shown, "="
        with mpmath.workdps(_INSIDE):
            true = _values(exact, band) if true is None else true
            value = _compiled(printed)
            if all(abs(value(at) - y) <= room for at, y, room in true):
                return shown, "≈"
    return None


def as_printed(shown: Expr) -> Expr:
    """A formula in which each rounded number is the decimal that is printed."""
    return shown.xreplace({x: Rational(str(x)) for x in shown.atoms(Float)})


def _values(exact: Expr, band: Band) -> list[tuple[float, Any, Any]]:
    """Frequencies, rad/s, the values there, and how far a value may be off."""
    low, high = map(float, band)
    value = _compiled(exact)
    samples = []
    for share in _SHARES:
        frequency = low + (high - low) * share
        exactly = value(frequency)
        # Half a unit of the fourth digit of the value, and what the value changes by if the
        # frequency does so: near a zero or a steep slope the first alone would ask for too much.
        near = [value(frequency * x) for x in (1 - _WITHIN, 1 + _WITHIN)]
        change = max(abs(x - exactly) for x in near)
        samples.append((frequency, exactly, _WITHIN * abs(exactly) + change))
    return samples


def _compiled(form: Expr) -> Callable[[float], Any]:
    """The value at a frequency, a parameter that is left being 1; not a number where it is
    infinite."""
    symbols = [*form.free_symbols]
    function = lambdify(symbols, form, "mpmath")

    def value(at: float) -> Any:
        """The value at a frequency; not a number is within no bound, so it proves nothing."""
        known = {omega: mpmath.mpf(at), s: mpmath.mpc(0, at)}
        try:
            return function(*(known.get(x, mpmath.mpf(1)) for x in symbols))
        except ZeroDivisionError:
            return mpmath.nan

    return value


# Zeros.


def keeps_zeros(shown: Expr, found: RealFunction, band: Band) -> bool:
    """Whether a polynomial as it is printed has the zeros on a band that the numerator of a
    function has, to four digits and with their orders, and no other; False if that is
    undecided."""
    printed = found.axis.convert(as_printed(shown))
    both = [RealFunction(found.axis.function(x.numerator)) for x in (found.function, printed)]
    try:
        exact, other = (_zeros(x, band) for x in both)
    except UndecidedError:
        return False
    # Values may agree to four digits where zeros do not: rounding can part a double zero, or lose
    # both of it.
    if exact is None or other is None or [n for _, n in exact] != [n for _, n in other]:
        return False
    pairs = zip(exact, other, strict=True)
    return all(abs(x - y) <= _WITHIN * x for (x, _), (y, _) in pairs)


def _zeros(f: RealFunction, band: Band) -> list[tuple[float, float]] | None:
    """Each zero on a band, and its order; None where some is undecided."""
    points = chart({"p": f}, *band).points
    if any(x.undecided for x in points):
        return None
    return [(float(x.omega), x.orders["p"]) for x in points if x.orders.get("p", 0)]
