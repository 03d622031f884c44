"""Where poles may lie of what no passive hand can drive: F(s)/s, with F a dynamic stiffness, must be positive real.

Beside Im F(j omega) >= 0 that asks of F/s: no poles in Re s > 0; those on the axis, at 0 and at infinity simple, with positive
residues.
"""

from __future__ import annotations

from math import prod
from typing import Any

from sympy import Expr, Integer

from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.far import Sense, far
from haptisym.kernel.response import RealFunction, Response, on_axis
from haptisym.kernel.rings import RationalFunction
from haptisym.kernel.rootcount import count_roots
from haptisym.kernel.roots import chart, sign_of_number
from haptisym.kernel.terms import order_at_0


def poles_allow(F: RationalFunction) -> bool | None:
    """Whether the poles of F/s, F in lowest terms, are as those of a positive real function; None where not decided.

    >>> from haptisym.kernel.symbols import s
    >>> def of(Z): return poles_allow(Ring.of([s * Z]).convert(s * Z).reduced())
    >>> of(1 / s), of(-1 / s), of(s / (s - 1)), of(s / (s**2 + 1)), of(s**2), of(-s)
    (True, False, False, True, False, False)
    """
    if F.is_zero:
        return True
    try:
        return _allowed(F, on_axis(F))
    except UndecidedError:
        return None


def has_no_pole_right(f: RationalFunction) -> bool | None:
    """Whether a function in lowest terms has no pole in Re s > 0; None where not decided."""
    try:
        found = count_roots(f.denominator, _ring(f))
    except UndecidedError:
        return None
    return None if found.right is None else found.right == 0


def _ring(f: RationalFunction) -> Ring:
    assert isinstance(f.ring, Ring)
    return f.ring


def _allowed(F: RationalFunction, response: Response) -> bool:
    ring = _ring(F)
    if order_at_0(F.denominator, ring) > order_at_0(F.numerator, ring) or not _allowed_far_out(response):
        return False
    found = count_roots(F.denominator, ring)
    if found.right is None:
        raise UndecidedError("where infinitely many poles lie")
    if found.right or _sign_at_0(response.real) < 0:  # F(0) is the residue of F/s at 0
        return False
    places = [float(x) for x in found.on_axis if float(x) > 0]
    if not places:
        return True
    table = chart({"real": response.real, "imag": response.imag}, Integer(0), Integer(int(max(places)) + 1))
    poles = [p for p in table.points if min(p.orders.get(name, 0) for name in ("real", "imag")) < 0]
    # with the residue r > 0 F is near omega_0 r/(omega - omega_0): real, it comes back from -infinity as +infinity
    return all(
        p.orders.get("real") == -1 and (p.before["real"], p.after["real"]) == (-1, 1) and p.orders.get("imag", 0) >= 0
        for p in poles
    )


def _sign_at_0(real: RealFunction) -> int:
    """Of F(0)."""
    if not real.axis.functions:
        f = real.function
        return prod(sign_of_number(f.ring.coefficients(p)[0]) for p in (f.numerator, f.denominator))
    first = chart({"real": real}, Integer(0), Integer(1)).points[0]
    return 0 if first.orders.get("real", 0) else first.after["real"]


def _allowed_far_out(response: Response) -> bool:
    """Whether F grows more slowly than s^2, or as a positive mass does."""
    raw = response.raw_real
    grown = max(power(x.numerator, x) - power(x.denominator, x) for x in (raw, response.raw_imag) if not x.is_zero)
    faster = sign_of_number(grown - 2)
    if faster:
        return faster < 0
    found = far(raw).sense
    if found in (Sense.BOTH, Sense.UNKNOWN):
        raise UndecidedError("whether a display is a positive mass far out")
    return found is Sense.NEGATIVE


def power(polynomial: Any, f: RationalFunction) -> Expr:
    """The highest power of omega in a polynomial of an axis, powers omega^alpha among them."""
    axis: Any = f.ring
    first = axis.size + len(axis.angles)
    return max(
        sum((int(n) * x for n, x in zip(e[first:], axis.orders, strict=False)), Integer(int(e[0])))
        for e in polynomial.monoms()
    )
