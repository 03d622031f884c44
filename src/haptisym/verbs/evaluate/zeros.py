"""What shows how many zeros a function of s has in Re s >= 0: where the real and the imaginary part on the axis change sign."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from itertools import pairwise
from typing import Any

import flint
from flint import fmpz_poly
from sympy import I

from haptisym.kernel.budget import tick
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import SceneError, UndecidedError
from haptisym.kernel.reals import RealNumber, Sliver, bounds, rational_between
from haptisym.kernel.rings import RationalFunction
from haptisym.verbs.evaluate.products import Factor, Factors, told_rows
from haptisym.verbs.evaluate.waves import Rows

_BITS = 128  # of roots that only say where to look: what is found is checked
_MOST = 300


def zeros(function: RationalFunction) -> dict[str, Any]:
    """A function in lowest terms as a product of factors, with cells in which the turns of each can be counted.

    SceneError where it is no quotient of polynomials with real coefficients, UndecidedError where the cells do not suffice.
    """
    ring = function.ring
    assert isinstance(ring, Ring)
    if any(
        any(p.degrees()[i] for p in (function.numerator, function.denominator))
        for i, x in enumerate(ring.meanings)
        if x == I
    ):
        raise SceneError(
            "a certificate about poles needs real coefficients: the describing function of friction has none"
        )
    if function.denominator.is_zero() or function.numerator.is_zero():
        raise SceneError(
            "a certificate about poles and roots needs a display that is felt: its force is zero everywhere"
        )
    factors = Factors()
    product = factors.quotient(ring, function.numerator, function.denominator, in_square=False)
    above = {i for i, n in product["powers"] if n > 0}
    return {
        "factors": [told_rows(f.rows) for f in factors.listed],
        "function": product,
        "cells": [[str(x) for x in _cells(f.rows)] if i in above else [] for i, f in enumerate(factors.listed)],
    }


def _cells(rows: Rows) -> list[Fraction]:
    """Numbers of omega^2, ascending, between which E or O of p(j omega) = E + j omega O has one zero, or E none."""
    if not any(rows[0]):
        return []  # s itself
    halves = (tuple(tuple(n * (-1) ** k for n in row) for k, row in enumerate(rows[i::2])) for i in (0, 1))
    even, odd = (Factor(x or ((0,),), 1) for x in halves)
    places = sorted([*_positive(even), *_positive(odd)], key=lambda x: x.bounds(0)[0])
    between = (rational_between(a, b) for a, b in pairwise(places))
    found, waiting = [Fraction(0)], [None, *[Fraction(int(x.p), int(x.q)) for x in between][::-1]]
    while waiting:
        tick()
        low, high = found[-1], waiting[-1]
        if _is_told(even, odd, low, high):
            waiting.pop()
            found += [] if high is None else [high]
        elif len(found) + len(waiting) < _MOST:
            waiting.append(_between(even, low, high))
        else:
            raise UndecidedError(
                "a certificate: the real or the imaginary part of p(j omega) has zeros that cells do not part, as a double one"
            )
    return found[1:]


def _between(even: Factor, low: Fraction, high: Fraction | None) -> Fraction:
    """A number at which E does not vanish: no cell can end where it does."""
    tried = [2 * low + n - 1 if high is None else low + (high - low) / n for n in range(2, 2 + len(even.rows))]
    return next(filter(even.sign_at, tried), tried[0])


def _is_told(even: Factor, odd: Factor, low: Fraction, high: Fraction | None) -> bool:
    """E is not zero at ``low``: 0, or where a cell ended."""
    own, other = even.moved(low, high), odd.moved(low, high)
    if own is None or other is None or not (own[-1] or high is None):
        return False
    turns, others = (sum(a != b for a, b in pairwise(x for x in signs if x)) for signs in (own, other))
    return turns == 0 or turns + others == 1


def _positive(factor: Factor) -> Sequence[RealNumber]:
    """The positive zeros, nearly."""
    plain = factor.bounds[0]
    if plain.degree() < 1:
        return []
    with flint.ctx.workprec(_BITS):
        roots = [
            z.real for z, _ in fmpz_poly(plain.numer().coeffs()).complex_roots() if z.imag.contains(0) and z.real > 0
        ]
        return [Sliver(*bounds(x)) for x in roots]
