"""How a function with powers of omega begins at omega = 0: the first term of its expansion that is not zero, exact.

f = sum over l of omega^(alpha l) A_l with A_l analytic. Where alpha is rational, terms of different l meet at one exponent, and
their coefficients, sums of products of cosines and sines of parts of a turn, may cancel: Re s^(2 alpha) is 0 for alpha = 1/2.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from heapq import heapify, heapreplace
from itertools import islice
from math import lcm
from typing import TypeAlias

import flint
from flint import arb, fmpq, fmpz_poly
from sympy import Expr, Integer, pi

from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.exactwaves import exact_waves, taylor_coefficients
from haptisym.kernel.reals import Ball, expression_ball
from haptisym.kernel.rings import Polynomial, RationalFunction
from haptisym.kernel.wavesums import WaveSum, WaveTerm
from haptisym.kernel.zeros import is_clear

_MOST_TERMS = 64  # of an expansion that are tried
_FINEST = 20_000  # parts of a turn, of which exact cosines are added up

Powers: TypeAlias = tuple[int, ...]
"""Which product of powers omega^alpha it is that an analytic function stands before."""


@dataclass(frozen=True)
class Beginning:
    """The exponent of the first term; ``parts``: each with its own exponent and its order up to which all terms cancel."""

    exponent: Expr
    parts: tuple[tuple[Powers, Expr, int], ...]


def by_powers(f: WaveSum) -> dict[Powers, WaveSum]:
    """A sum as a sum of analytic functions, each times powers omega^alpha."""
    groups: dict[Powers, list[WaveTerm]] = {}
    for term in f.terms:
        groups.setdefault(term.powers, []).append(WaveTerm(term.turns, (), term.coefficients))
    return {powers: WaveSum(tuple(terms), f.rates, f.degrees, ()) for powers, terms in groups.items()}


@lru_cache(maxsize=1024)
def beginning(f: WaveSum) -> Beginning:
    """The first term of the expansion at 0; UndecidedError where none of the first ones shows."""
    own = [
        (powers, sum((a * n for a, n in zip(f.orders, powers, strict=True)), Integer(0)))
        for powers in dict.fromkeys(term.powers for term in f.terms)
    ]
    for exponent, meeting in _exponents(own):
        if not _cancels(f, meeting):
            return Beginning(exponent, tuple((powers, e, _order(exponent - e)) for powers, e in own))
    raise UndecidedError("whether a function vanishes near omega = 0")


def _exponents(parts: list[tuple[Powers, Expr]]) -> Iterator[tuple[Expr, list[tuple[Powers, int]]]]:
    """The exponents of omega in ascending order, and the Taylor coefficients of the parts that meet at each."""
    waiting = [(_sortable(e), i, 0) for i, (_, e) in enumerate(parts)]
    heapify(waiting)
    for _ in range(_MOST_TERMS):
        least, first, order = waiting[0]
        exponent, meeting = parts[first][1] + order, list[tuple[Powers, int]]()
        while _is(parts, waiting[0], least, exponent):
            key, i, n = waiting[0]
            meeting.append((parts[i][0], n))
            heapreplace(waiting, (key + 1, i, n + 1))
        yield exponent, meeting


def _sortable(exponent: Expr) -> Fraction | float:
    return Fraction(int(exponent.p), int(exponent.q)) if exponent.is_Rational else float(exponent)


def _is(
    parts: list[tuple[Powers, Expr]], entry: tuple[Fraction | float, int, int], key: Fraction | float, exponent: Expr
) -> bool:
    own, i, n = entry
    if isinstance(own, Fraction) and isinstance(key, Fraction):
        return own == key
    return bool((parts[i][1] + n - exponent).expand() == 0)


def _order(rise: Expr) -> int:
    """The lowest order of a part of which the terms may not all lie below the first one: the ceiling, and 0 or more."""
    return max(0, -int((-rise).p // (-rise).q) if rise.is_Rational else int(rise.evalf(30) // 1) + 1)


def _cancels(f: WaveSum, meeting: list[tuple[Powers, int]]) -> bool:
    """Whether Taylor coefficients at 0 add up to zero: balls first, then exact."""
    with flint.ctx.workprec(128):
        if is_clear(sum((f.before(powers, arb(0), n, n + 1)[0] for powers, n in meeting), arb(0))):
            return False
    waves, parts = exact_waves(f, Integer(0)), by_powers(f)
    assert waves is not None
    exact = [next(islice(taylor_coefficients(parts[powers], Integer(0), waves), n, None)) for powers, n in meeting]
    total: RationalFunction | None = None
    for x in exact:
        total = x if total is None else RationalFunction(total.ring, *_sum(total, x))
    assert total is not None
    return _is_zero(total.numerator, [rate for rate, _ in f.rates])


def _sum(x: RationalFunction, y: RationalFunction) -> tuple[Polynomial, Polynomial]:
    return x.numerator * y.denominator + y.numerator * x.denominator, x.denominator * y.denominator


def _is_zero(polynomial: Polynomial, angles: list[Expr]) -> bool:
    """Whether a polynomial in pi and the cosines and sines of half of some angles is the number zero: exact.

    With z a root of unity, cos = (z^k + z^-k)/2 and sin = (z^k - z^-k)/(2 i): each coefficient of a power of pi, which is
    transcendental, must be a multiple of z's cyclotomic polynomial.
    """
    if polynomial.is_zero():
        return True
    exponents = [tuple(map(int, e)) for e in polynomial.monoms()]
    used = [i for i in range(len(angles)) if any(e[2 + 2 * i] or e[3 + 2 * i] for e in exponents)]
    turns = {i: angles[i] / (4 * pi) for i in used}  # half an angle, as parts of a turn
    if not all(x.is_Rational for x in turns.values()):
        return False  # of an angle that is no part of a turn, they are taken to be independent
    whole = lcm(4, *(int(x.q) for x in turns.values()))
    if whole > _FINEST:
        raise UndecidedError("whether a function vanishes near omega = 0")
    rows: dict[int, dict[int, fmpq]] = {}
    for exponent, value in zip(exponents, polynomial.coeffs(), strict=True):
        product = {0: value}
        for i in used:
            k = int(turns[i] * whole)
            product = _times(product, {k: fmpq(1, 2), -k: fmpq(1, 2)}, exponent[2 + 2 * i], whole)
            quarter = whole // 4  # 1/i = -i
            product = _times(product, {k - quarter: fmpq(1, 2), -k - quarter: fmpq(-1, 2)}, exponent[3 + 2 * i], whole)
        row = rows.setdefault(exponent[1], {})
        for n, x in product.items():
            row[n] = row.get(n, fmpq(0)) + x
    return all(_is_multiple(row, whole) for row in rows.values())


def _times(x: dict[int, fmpq], y: dict[int, fmpq], count: int, whole: int) -> dict[int, fmpq]:
    """A sum of powers of a root of unity times another one, that many times."""
    for _ in range(count):
        found: dict[int, fmpq] = {}
        for i, a in x.items():
            for j, b in y.items():
                found[(i + j) % whole] = found.get((i + j) % whole, fmpq(0)) + a * b
        x = found
    return x


def _is_multiple(row: dict[int, fmpq], whole: int) -> bool:
    """Whether a sum of powers of a root of unity is zero."""
    below = lcm(*(int(x.q) for x in row.values()))
    coefficients = [0] * whole
    for n, x in row.items():
        coefficients[n] = int(x.p) * (below // int(x.q))
    return bool((fmpz_poly(coefficients) % fmpz_poly.cyclotomic(whole)) == 0)


def clear_of_zero(f: WaveSum, first: Ball) -> Ball:
    """A dyadic number above 0, with no zero in between; ``first`` is tried first.

    Divided by the lowest power omega^e of all, what remains is the sum of omega^(alpha l + n_l - e) times the n_l-th Taylor
    coefficient of A_l about some place in between, alpha l + n_l being e or the next exponent above: all terms below cancel.
    """
    start = beginning(f)
    with flint.ctx.workprec(128):
        reach = first.mid()
        for _ in range(200):
            piece, total = arb(0).union(reach), arb(0)
            for powers, own, order in start.parts:
                rise = own + order - start.exponent
                power = arb(1) if rise == 0 else arb(0).union((expression_ball(rise) * reach.log()).exp())
                total = total + power * f.before(powers, piece, order, order + 1)[0]
            if is_clear(total):
                return reach
            reach = reach / 16
    raise UndecidedError("whether a function vanishes near omega = 0")
