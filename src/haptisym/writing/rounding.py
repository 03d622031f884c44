"""Formulas whose numbers are rounded, and which are true as they are printed: that is found out before they are.

Where large terms cancel, a formula with six digits of each has none left. So a rounded formula is read as it is printed, each
number the decimal that it looks like, and compared with the exact one; if it is not true with few digits it gets more, and if
it is not with many it is not printed. Arguments of functions stay exact: a phase that is rounded drifts.

True is a formula of which each value that is tried is the exact one to four digits, or the exact one at a frequency that is the
same to four digits: near a zero it may move as the zero may. A polynomial that is printed for its zeros must have the exact
one's on the band to four digits, each once, and no other: these are certified.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import reduce
from operator import add, mul

import flint
from flint import acb, arb, fmpq
from sympy import Abs, Expr, Float, I, Integer, Pow, Rational, Symbol, atan2, pi

from haptisym.kernel.dynamics import RealFunction
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import expression_ball
from haptisym.kernel.rings import omega, s
from haptisym.kernel.roots import chart

DIGITS = (6, 8, 10, 12)
"""Of each number of a formula, as few of these as do."""
_WITHIN = Rational(1, 20000)
"""Half a unit of the fourth digit of 1: of a value, and of a frequency."""
_SHARES = (Rational(1, 100), Rational(1, 20), *(Rational(n, 8) for n in range(1, 9)))
"""Where on a band values are compared."""
_BITS = (128, 512, 2048)

Band = tuple[Expr, Expr]
ANYWHERE: Band = (Integer(0), Integer(100))
"""The band of a formula that is about none, rad/s."""


def faithful(
    form: Callable[[int | None], Expr], band: Band, digits: Sequence[int] = DIGITS
) -> tuple[Expr, str] | None:  # fmt: skip
    """A formula with its numbers rounded to as few digits as keep it true, and the sign to print before it; None where none do.

    ``form`` : the formula with so many digits, exact for None.

    >>> from sympy import cos
    >>> from haptisym.writing.layout import approximate
    >>> exact = Rational(10**7 + 1, 3) - Rational(10**7, 3) * cos(omega / 10**6)
    >>> faithful(lambda n: exact if n is None else approximate(exact, n), ANYWHERE)
    (3333333.66667 - 3333333.33333*cos(omega/1000000), '≈')
    """
    exact = form(None)
    true: list[tuple[Expr, acb, arb]] | None = None
    for count in digits:
        shown = form(count)
        printed = as_printed(shown)
        if printed == exact:
            return shown, "="
        true = _values(exact, band) if true is None else true
        if all(abs(_value(printed, at) - y) <= room for at, y, room in true):
            return shown, "≈"
    return None


def as_printed(shown: Expr) -> Expr:
    """A formula in which each rounded number is the decimal that is printed."""
    return shown.xreplace({x: Rational(str(x)) for x in shown.atoms(Float)})


def _values(exact: Expr, band: Band) -> list[tuple[Expr, acb, arb]]:
    """Frequencies, the values there, and how far a value may be off."""
    low, high = band
    found = []
    for share in _SHARES:
        at = low + (high - low) * share
        here, before, after = (_value(exact, at * (1 + n * _WITHIN)) for n in (0, -1, 1))
        room = arb(fmpq(1, 20000)) * abs(here) + max(abs(before - here), abs(after - here), key=lambda x: x.mid())
        found.append((at, here, room))
    return found


def _value(form: Expr, at: Expr) -> acb:
    """The value at a frequency, with so many digits that some are left where terms cancel."""
    for bits in _BITS:
        with flint.ctx.workprec(bits):
            x = expression_ball(at)
            found = _ball(form, {omega: acb(x), s: acb(0, x)}, {})
        if found.rel_accuracy_bits() > 40:
            break
    return found


def _ball(form: Expr, at: Mapping[Symbol, acb], known: dict[Expr, acb]) -> acb:
    """A ball around the value of a formula, a parameter that is left being 1; ``known`` : those of its parts."""
    if form.is_Symbol:
        return at.get(form, acb(1))
    if form.is_Rational:
        return acb(fmpq(int(form.p), int(form.q)))
    if form in known:
        return known[form]
    inside = [_ball(x, at, known) for x in form.args]
    if form.is_Add or form.is_Mul:
        known[form] = reduce(add if form.is_Add else mul, inside)
    elif isinstance(form, Pow):
        known[form] = inside[0] ** (int(form.exp) if form.exp.is_Integer else inside[1])
    elif form is pi or form is I:
        known[form] = acb.pi() if form is pi else acb(0, 1)
    elif isinstance(form, Abs):
        known[form] = acb(abs(inside[0]))
    elif isinstance(form, atan2):
        known[form] = acb((inside[1] + inside[0] * acb(0, 1)).log().imag)
    else:
        known[form] = getattr(acb, form.func.__name__)(*inside)
    return known[form]


# Zeros.


def keeps_zeros(shown: Expr, found: RealFunction, band: Band) -> bool:
    """Whether a polynomial as it is printed has the zeros on a band that the numerator of a function has, and no other."""
    printed = found.axis.convert(as_printed(shown))
    both = [RealFunction(found.axis.function(x.numerator)) for x in (found.function, printed)]
    try:
        exact, other = (_zeros(x, band) for x in both)
    except UndecidedError:
        return False
    if exact is None or other is None or [n for _, n in exact] != [n for _, n in other]:
        return False
    return all(abs(x - y) <= float(_WITHIN) * x for (x, _), (y, _) in zip(exact, other, strict=True))


def _zeros(f: RealFunction, band: Band) -> list[tuple[float, float]] | None:
    """Each zero on a band, and its order; None where some is undecided."""
    points = chart({"p": f}, *band).points
    if any(x.undecided for x in points):
        return None
    return [(float(x.omega), x.orders["p"]) for x in points if x.orders.get("p", 0)]
