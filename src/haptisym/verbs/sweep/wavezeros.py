"""Certified zeros of many analytic functions at once: counts that are proven, or an explicit "undecided".

On a segment a function f is a polynomial p and a remainder (``chebyshev``). No zero, if p's Bernstein coefficients have one
sign and exceed the remainder. At most one, a simple one, if their differences have one sign and exceed the slope of the
remainder, for then f is monotone; the signs at the ends tell whether there is one. All else is cut in two: p a few times, by
de Casteljau's weights, then the segment, where f is computed anew. A sign counts only beyond all errors.

Powers x^alpha are not what polynomials come near to at x = 0. On a first segment [0, e] they are therefore variables of
their own between 0 and e^alpha, in which f is a polynomial: if its coefficients in both of Bernstein's bases have one sign, f
has no zero there.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TypeAlias

import numpy as np

from haptisym.verbs.sweep.batch import Array, error
from haptisym.verbs.sweep.bernstein import Zeros
from haptisym.verbs.sweep.chebyshev import Nodes, halving, nodes
from haptisym.verbs.sweep.wavevalues import WaveFunction

Segments: TypeAlias = tuple[Array, Array, Array]
"""Sets, which may be repeated, low ends, high ends."""
_DEGREES, _DEGREE_AT_0 = (5, 14), 6
"""Of polynomials: the lower one, for narrow segments, feels less of rounding errors."""
_NARROW = 2.0**-6
_READY, _READY_AT_0 = 1e-6, 1e-4
"""How much of the size a remainder may be: else a segment is cut before anything is computed on it."""
_MOST_CUTS, _MOST_CUTS_AT_0, _MOST_HALVINGS = 40, 9, 5
_AT_ONCE = 8192
_MOST_OPEN = 200  # segments of a set: rounding hides what is to be found


def isolate(f: WaveFunction, edges: Sequence[float], *, first_is_doubt: bool = False) -> Zeros:
    """All zeros between the first and the last edge (0 <= edges <= 1, exact), each alone where f is monotone.

    ``first_is_doubt``: the first segment only encloses the true low end, so that a zero on it leaves the set undecided.
    """
    with np.errstate(all="ignore"):  # what is not finite has no certain sign
        search = _Search(f, edges[0])
        parts = [search.segment(a, b) for a, b in pairwise(edges)]
        if first_is_doubt:
            begin = parts.pop(0)
            search.run(begin)
            search.doubtful[np.concatenate([x[0] for x in search.found])] = True
        elif edges[0] == 0 and any(f.power_degrees):
            parts[0] = search.beyond_0(edges[1])
        search.run(_joined(parts))
        return search.zeros()


class _Search:
    """The zeros of a function for each set, while they are looked for."""

    def __init__(self, f: WaveFunction, bottom: float) -> None:
        self.f, self.bottom = f, bottom
        self.doubtful = np.zeros(f.sets, dtype=bool)
        self.first = np.zeros(f.sets, dtype=np.int8)
        self.found: list[Segments] = [_chosen(self.segment(0, 0), np.zeros(f.sets, dtype=bool))]

    def segment(self, low: float, high: float) -> Segments:
        """One segment for each set."""
        return np.arange(self.f.sets), np.full(self.f.sets, low), np.full(self.f.sets, high)

    def run(self, left: Segments) -> None:
        """Cut segments until each holds one zero or none; sets where that fails are marked as doubtful."""
        for _ in range(_MOST_CUTS):
            self.doubtful |= np.bincount(left[0], minlength=self.f.sets) > _MOST_OPEN
            left = _chosen(left, ~self.doubtful[left[0]])
            if not len(left[0]):
                return
            narrow = left[2] - left[1] < _NARROW
            kinds = (_chosen(left, narrow), _DEGREES), (_chosen(left, ~narrow), _DEGREES[1:])
            left = _joined([self.narrowed(some, degrees) for part, degrees in kinds for some in _pieces(part)])
        self.doubtful[left[0]] = True

    def narrowed(self, segments: Segments, degrees: Sequence[int]) -> Segments:
        """What is left of segments to be looked at anew, after those that are near enough to polynomials were."""
        if not degrees or not len(segments[0]):
            return _halves(segments, by_ratio=any(self.f.power_degrees))
        degree, *others = degrees
        sets, low, high = segments
        f = self.f.of(sets)
        left_out, sizes = f.left_out(low, high, degree), f.sizes(high)
        ready = left_out[1] <= _READY * sizes
        rest, some = self.narrowed(_chosen(segments, ~ready), others), ready.nonzero()[0]
        if len(some) < len(sets):
            f, sizes, left_out = f.of(some), sizes[some], (left_out[0][some], left_out[1][some])
        segments = _chosen(segments, ready)
        ends, curves = _interpolated(f, segments, sizes, left_out, degree)
        self._told(segments, ends)
        return _joined([rest, *self._searched(segments, curves, ends)])

    def _told(self, segments: Segments, ends: Array) -> None:
        """Take note of the signs at the ends of segments: sets with one that is not certain become doubtful."""
        sets, low, high = segments
        self.doubtful[sets[(ends == 0).any(axis=0) | ~(low < high)]] = True
        at_bottom = low == self.bottom
        self.first[sets[at_bottom]] = ends[0][at_bottom]

    def _searched(self, segments: Segments, curves: Curves, ends: Array) -> list[Segments]:
        """Cut polynomials, as long as they tell enough; the segments on which they do not."""
        for _ in range(_MOST_HALVINGS):
            none, one = curves.judged(ends)
            self.found.append(_chosen(segments, one))
            open_ = ~(none | one) & ~self.doubtful[segments[0]]
            if not open_.any():
                return []
            curves, segments = curves.of(open_.nonzero()[0]).halves(), _halves(_chosen(segments, open_))
            ends = curves.ends()
        none, one = curves.judged(ends)
        self.found.append(_chosen(segments, one))
        sets, low, high = _chosen(segments, ~(none | one))
        # children end where floats round to: the next ones outside leave no gap
        return [(sets, np.maximum(np.nextafter(low, 0), self.bottom), np.minimum(np.nextafter(high, 1), 1.0))]

    def zeros(self) -> Zeros:
        found = _joined(self.found)
        sets, low, high = _chosen(found, ~self.doubtful[found[0]])
        order = np.lexsort((low, sets))
        return Zeros(sets[order], low[order], high[order], ~self.doubtful, self.first)

    def beyond_0(self, end: float) -> Segments:
        """What is left between a first segment without a zero, on which powers are variables of their own, and the end.

        That first segment is as long as it can be, in steps of 4.
        """
        left = self.segment(0.0, end)
        rest = [_chosen(left, np.zeros(self.f.sets, dtype=bool))]
        if sum(n > 0 for n in self.f.power_degrees) > 1:
            self.doubtful[:] = True
            return left
        for _ in range(_MOST_CUTS_AT_0):
            sets, low, high = left
            sign = _sign_from_0(self.f.of(sets), high)
            self.first[sets] = sign
            sets, high = sets[sign == 0], high[sign == 0]
            if not len(sets):
                break
            rest.append((sets, high / 4, high))
            left = sets, low[: len(sets)], high / 4
        self.doubtful[sets] = True
        return _joined(rest)


@dataclass(frozen=True)
class Curves:
    """Polynomials by their Bernstein coefficients, sets in columns; ``wrong``: a bound on the errors of all of them.

    ``left_out``: how much the function may differ from the polynomial, and its slope over the degree from that of this one.
    """

    coefficients: Array
    wrong: Array
    left_out: tuple[Array, Array]

    def of(self, some: Array) -> Curves:
        """For some of the sets."""
        value, slope = self.left_out
        return Curves(self.coefficients[:, some], self.wrong[some], (value[some], slope[some]))

    def ends(self) -> Array:
        """The certain signs at both ends."""
        return _certain(self.coefficients[[0, -1]], self.wrong + self.left_out[0])

    def judged(self, ends: Array) -> tuple[Array, Array]:
        """Whether there is no zero for certain, and whether there is one, given the signs at the ends."""
        value, slope = self.left_out
        none = _one_sign(self.coefficients, self.wrong + value)
        monotone = _one_sign(np.diff(self.coefficients, axis=0), (2 * self.wrong + slope) * _SLACK)
        known = monotone & (ends != 0).all(axis=0)
        return none | (known & (ends[0] == ends[1])), known & (ends[0] != ends[1])

    def halves(self) -> Curves:
        """Those on the first halves of the segments, then those on the second, by de Casteljau's weights."""
        halves = [np.einsum("ji,ib->jb", w, self.coefficients) for w in halving(len(self.coefficients) - 1)]
        value, slope = self.left_out
        both = np.concatenate(halves, axis=1)
        return Curves(both, np.tile(self.wrong, 2), (np.tile(value, 2), np.tile(slope / 2, 2)))


def _interpolated(
    f: WaveFunction, segments: Segments, sizes: Array, left_out: tuple[Array, Array], degree: int
) -> tuple[Array, Curves]:
    """Signs at the ends of segments, and what functions are there."""
    _, low, high = segments
    n = nodes(degree)
    values = f.values(low * n.low[:, None] + high * n.high[:, None])
    wrong = f.error(sizes, low, high)
    coefficients = np.einsum("ji,ib->jb", n.matrix, values)  # not a library's product: its order may depend on the sets
    # the sum here, and those of all halvings
    bound = n.amplified.max() * (wrong + error(sizes, (degree + 3) * (1 + _MOST_HALVINGS)))
    value, slope = left_out
    at_ends = np.array([f.error(f.sizes(low), low, low), wrong])  # at the low end sizes may be much smaller
    return _certain(values[[0, -1]], at_ends), Curves(coefficients, bound, (value, 2 * slope / degree))


def _one_sign(values: Array, bounds: Array) -> Array:
    found: Array = np.logical_or((values > bounds).all(axis=0), (values < -bounds).all(axis=0))
    return found


def _certain(values: Array, bounds: Array) -> Array:
    return (values > bounds).astype(np.int8) - (values < -bounds).astype(np.int8)


def _sign_from_0(f: WaveFunction, high: Array) -> Array:
    """The sign of each function on [0, high], if it is one: with its power as a variable of its own; else 0."""
    low = np.zeros_like(high)
    place = next(i for i, n in enumerate(f.power_degrees) if n)
    m, n = nodes(_DEGREE_AT_0), nodes(f.power_degrees[place])
    powers = np.zeros((len(f.power_degrees), len(high)))
    powers[place] = np.exp(f.variables.orders[place] * np.log(high)) * _SLACK
    value, _ = f.left_out(low, high, _DEGREE_AT_0, powers)
    sizes = f.sizes(high, powers=powers)
    x = high * m.high[:, None]
    coefficients, roundings = _in_both(n, m, f.values(x, powers[:, None, None] * n.high[:, None, None]))
    wrong = f.error(sizes, low, high, own_powers=True) + error(sizes, roundings)
    bounds = n.amplified[:, None, None] * (m.amplified[:, None] * wrong + value)
    same = _one_sign(coefficients.reshape(-1, len(high)), bounds.reshape(-1, len(high)))
    found: Array = np.where(same & (value < _READY_AT_0 * sizes), np.sign(coefficients[0, 0]), 0.0)
    return found


def _in_both(n: Nodes, m: Nodes, values: Array) -> tuple[Array, int]:
    """From values at nodes of the power and of x to coefficients in both of Bernstein's bases, and how often a term is rounded.

    One variable after the other: in a sum over both at once each term would be rounded with every one that follows it.
    """
    of_x = np.einsum("mj,ijb->imb", m.matrix, values)
    # each time the weight, the product, and with all terms but its own the sum
    return np.einsum("ki,imb->kmb", n.matrix, of_x), (m.degree + 2) + (n.degree + 2)


def _pieces(segments: Segments) -> Iterator[Segments]:
    """So many at a time that memory is no matter."""
    sets, low, high = segments
    for i in range(0, len(sets), _AT_ONCE):
        yield sets[i : i + _AT_ONCE], low[i : i + _AT_ONCE], high[i : i + _AT_ONCE]


def _chosen(segments: Segments, kept: Array) -> Segments:
    sets, low, high = segments
    return sets[kept], low[kept], high[kept]


def _joined(parts: Sequence[Segments]) -> Segments:
    sets, low, high = (np.concatenate(column) for column in zip(*parts, strict=True))
    return sets, low, high


def _halves(segments: Segments, *, by_ratio: bool = False) -> Segments:
    sets, low, high = segments
    middle = np.sqrt(low * high) if by_ratio else (low + high) / 2
    return np.tile(sets, 2), np.concatenate([low, middle]), np.concatenate([middle, high])


_SLACK = 1.001
