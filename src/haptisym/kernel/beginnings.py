"""How a function with powers of omega begins at omega = 0: the first term of its expansion that is not zero, exact.

f = sum over l of omega^(alpha l) A_l with A_l analytic. Where alpha is rational, terms of different l meet at one exponent, and
their coefficients, sums of products of cosines and sines of parts of a turn, may cancel: Re s^(2 alpha) is 0 for alpha = 1/2.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache, reduce
from heapq import heapify, heapreplace
from itertools import islice
from typing import TypeAlias

import flint
from flint import arb
from sympy import Expr, Integer

from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.exactwaves import exact_waves, taylor_coefficients
from haptisym.kernel.precision import at_rising_precision
from haptisym.kernel.reals import Ball, expression_ball
from haptisym.kernel.rings import Polynomial, RationalFunction
from haptisym.kernel.turns import is_zero
from haptisym.kernel.wavesums import WaveSum, WaveTerm
from haptisym.kernel.zeros import is_clear

NEARER = 3.0  # between the ends of a piece: Taylor's terms of omega^alpha fall as (1/2)^n, the remainder's bound does not grow
_NEAR = 4  # of such places, before larger steps are taken
_MOST_TERMS = 2000  # of an expansion that are tried: orders 1/5 and 1/12 meet sixty times between two powers of omega

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
    """Whether Taylor coefficients at 0 add up to zero: balls first, then exact, finer balls where that is not told exactly."""

    def in_balls(_: int) -> bool | None:
        total = sum(f.before(arb(0), meeting), arb(0))
        return False if is_clear(total) else True if total.is_zero() else None

    if (told := at_rising_precision(in_balls, 128, 128)) is not None:
        return told
    waves, parts = exact_waves(f, Integer(0)), by_powers(f)
    assert waves is not None
    exact = [next(islice(taylor_coefficients(parts[powers], Integer(0), waves), n, None)) for powers, n in meeting]
    top = reduce(lambda x, y: RationalFunction(x.ring, *_sum(x, y)), exact).numerator
    found = is_zero(top, [rate for rate, _ in f.rates])
    if found is None:
        found = at_rising_precision(in_balls, 256)
    if found is None:
        raise UndecidedError("whether a function vanishes near omega = 0")
    return found


def _sum(x: RationalFunction, y: RationalFunction) -> tuple[Polynomial, Polynomial]:
    return x.numerator * y.denominator + y.numerator * x.denominator, x.denominator * y.denominator


def clear_of_zero(f: WaveSum, first: Ball) -> Ball:
    """A dyadic number above 0, with no zero in between; ``first`` is tried first.

    Divided by the lowest power omega^e of all, what remains is the sum of omega^(alpha l + n_l - e) times the n_l-th Taylor
    coefficient of A_l about some place in between, alpha l + n_l being e or the next exponent above: all terms below cancel.
    """
    start = beginning(f)
    wanted = [(powers, order) for powers, _, order in start.parts]
    with flint.ctx.workprec(128):
        rises = [expression_ball(own + order - start.exponent) for _, own, order in start.parts]
        reach = first.mid()
        for n in range(200):
            total, lengths = arb(0), reach.log()
            for rise, own in zip(rises, f.before(arb(0).union(reach), wanted), strict=True):
                total = total + (own if rise.is_zero() else own * arb(0).union((rise * lengths).exp()))
            if is_clear(total):
                return reach
            reach = (reach / (NEARER if n < _NEAR else 16)).mid()
    raise UndecidedError("whether a function vanishes near omega = 0")
