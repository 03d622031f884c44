"""A quick proof that a polynomial in several variables is irreducible."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import count
from typing import Any

from flint import fmpq, fmpq_poly

from haptisym.kernel.monomials import monomials


def irreducible(polynomial: Any, used: Sequence[int]) -> tuple[fmpq, list[tuple[Any, int]]] | None:
    """A polynomial as its only factor, where that is quickly proven; None where it is not. ``used``: its variables.

    At numbers for all variables but one it keeps its degree and is irreducible: of two factors one would be free of that
    variable. At two numbers for that variable it has no factor in common: there is none that is free of it. Most numbers
    show both (Hilbert), in a fraction of the time that factoring takes.
    """
    degrees = polynomial.degrees()
    main, *others = sorted(used, key=lambda i: int(degrees[i]))  # the shortest is the cheapest
    special = polynomial.subs({f"x{i}": number for i, number in zip(others, count(2))})
    row = {int(exponents[main]): value for exponents, value in monomials(special)}
    if max(row, default=0) < int(degrees[main]):
        return None
    _, factors = fmpq_poly([row.get(n, 0) for n in range(max(row) + 1)]).factor()
    if len(factors) != 1 or factors[0][1] != 1:
        return None
    one, other = (polynomial.subs({f"x{main}": number}) for number in (2, 3))
    if not one.gcd(other).is_constant():
        return None
    values = polynomial.coeffs()
    whole = fmpq_poly(values)
    unit = fmpq(whole.numer().content(), whole.denom()) * (1 if values[0] > 0 else -1)
    return unit, [(polynomial / unit, 1)]
