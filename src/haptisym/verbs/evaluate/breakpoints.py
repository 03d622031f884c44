"""Rational numbers between everything that happens on a band, so close that signs of coefficients show that nothing else does."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from itertools import pairwise

from sympy import Rational

from haptisym.kernel.budget import tick
from haptisym.kernel.errors import SceneError, UndecidedError
from haptisym.kernel.reals import ExactNumber, RealNumber, Sliver, rational_between
from haptisym.verbs.evaluate.products import Factor
from haptisym.verbs.evaluate.waves import WaveFactor

_MOST = 2000


def breakpoints(places: Sequence[RealNumber], factors: Sequence[Factor | WaveFactor]) -> list[Fraction]:
    """Ascending, from the low end of the band (or a little below) to its high end (or a little above).

    ``places`` : the ends of the band and all zeros of the factors between them, in order. In each cell at most one factor has a
    variation of sign (Descartes), and that one only. UndecidedError where so many cells as a certificate may have are not enough.
    """
    ends = [_exact(places[0]), _exact(places[-1])]
    inner = [_fraction(rational_between(a, b)) for a, b in pairwise(places[1:-1])]
    if len(places) > 2 or None in ends:
        first = [] if ends[0] is not None else [_fraction(rational_between(places[0], places[1]))]
        last = [] if ends[1] is not None else [_fraction(rational_between(places[-2], places[-1]))]
        inner = sorted({*first, *inner, *last})
    low, high = _beside(places[0], -1), _beside(places[-1], 1)
    found, waiting, asked = [low], [high, *inner[::-1]], [*factors]
    while waiting:
        tick()
        if _is_told(asked, found[-1], waiting[-1]):
            found.append(waiting.pop())
        elif len(found) + len(waiting) < _MOST:
            waiting.append(_between(factors, found[-1], waiting[-1]))
        else:
            raise UndecidedError("a certificate: it would take too many cells")
    return found


def _exact(place: RealNumber) -> Fraction | None:
    value = place.value if isinstance(place, ExactNumber) else None
    return Fraction(int(value.p), int(value.q)) if value is not None and value.is_Rational else None


def _beside(end: RealNumber, side: int) -> Fraction:
    """An end of the band, or a rational number a little beyond it."""
    exact = _exact(end)
    if exact is not None:
        return exact
    return Fraction(end.enclosure()[side > 0])


def _is_told(factors: list[Factor | WaveFactor], low: Fraction, high: Fraction) -> bool:
    """Whether signs show that there is at most one zero in a cell, of one factor; one that fails is asked first again."""
    turns = 0
    for i, factor in enumerate(factors):
        signs = factor.moved(low, high)
        if signs is None:
            factors.insert(0, factors.pop(i))
            return False
        turns += sum(a != b for a, b in pairwise(x for x in signs if x))
    return turns < 2


def _between(factors: Sequence[Factor | WaveFactor], low: Fraction, high: Fraction) -> Fraction:
    """A number well inside, at which no factor vanishes."""
    flat = {*factors}
    for n in range(2, 100):
        middle, reach = low + (high - low) / n, (high - low) / (4 * n)
        point = _fraction(rational_between(*(Sliver(x, x) for x in (middle - reach, middle + reach))))
        flat -= {factor for factor in flat if factor.sign_at(point)}
        if not flat and all(factor.sign_at(point) for factor in factors):
            return point
    if flat:
        raise SceneError(
            "a certificate has no room for functions that are zero everywhere because of what an order is, as Re s^0.5 s^0.5"
        )
    raise UndecidedError("a number at which no polynomial of a certificate vanishes")


def _fraction(x: Rational) -> Fraction:
    return Fraction(int(x.p), int(x.q))
