"""Whether a characteristic function has zeros on the imaginary axis for some values of a box:
excluded by branch and bound.

D(s) is a polynomial in s, delays exp(-s tau) and powers s^alpha; coefficients, delays and orders
are functions of the box.
Beyond a reach R the highest power of s outweighs all others in Re s >= 0, whatever the values. Up
to it cells of omega and box are left out where D(j omega) lies, proven in Taylor models, on one
side of a line through 0. If none is left, no zero comes to the axis anywhere in the box, and the
number of zeros in Re s >= 0 is one for all values.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from math import prod
from typing import TypeAlias

from sympy import Expr, Rational, Symbol, pi

from haptisym.kernel.arrays import np
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.rings import Polynomial
from haptisym.kernel.roots import sign_of_number
from haptisym.kernel.where import Array, Batches, LineBound, halves
from haptisym.programs.taylormodels import TaylorModel, floated, valued, variable

_BATCH = 512  # cells that are bounded together
_MOST_CELLS = 40_000
_PIECES = 512  # of the box, over which coefficients are bounded
_FARTHEST = 2.0**60


_Key: TypeAlias = tuple[tuple[int, ...], tuple[int, ...]]
"""How often each unit delay, and each power of s, is in a term."""
_Terms: TypeAlias = dict[int, list[tuple[Rational, tuple[int, ...]]]]
"""By whole powers of s, numbers and the exponents of the symbols that they multiply."""


class OnAxis:
    """D(j omega) of a polynomial of a ring, over the values that some of its symbols may have.

    Cells are arrays (cells, 1 + symbols, 2) of shares, 0 at the low end, 1 at the high one; omega
    goes from 0 to the reach.
    """

    def __init__(
        self, ring: Ring, polynomial: Polynomial, ranges: Mapping[Symbol, tuple[Expr, Expr]]
    ) -> None:
        self._lags, self._orders = ring.lags, ring.orders
        self._ranges = [(floated(low), floated(high - low)) for low, high in ranges.values()]
        self._symbols, self.sides = list(ranges), 1 + len(ranges)
        self._never_negative = all(sign_of_number(low) >= 0 for low, _ in ranges.values())
        self._groups: dict[_Key, _Terms] = {}
        first, last = ring.size, ring.size + len(ring.lags)
        for exponents, value in polynomial.to_dict().items():
            own = [int(n) for n in exponents]
            powers = dict(zip(ring.symbols, own[2:first], strict=True))
            term = (
                Rational(int(value.p), int(value.q)) * pi ** own[1],
                tuple(powers.get(x, 0) for x in self._symbols),
            )
            group = self._groups.setdefault((tuple(own[first:last]), tuple(own[last:])), {})
            group.setdefault(own[0], []).append(term)

    @cached_property
    def reach(self) -> float | None:
        """A frequency from which on the highest power prevails, for all values; None where that is
        not known."""
        cells = np.broadcast_to([0.0, 1.0], (1, self.sides, 2)).copy()
        for i in range(9 * (self.sides - 1)):
            if len(cells) < _PIECES:
                cells = halves(cells, np.full(len(cells), 1 + i % (self.sides - 1)))
        with np.errstate(all="ignore"):
            values = self._values(cells, 0.0)
            found: dict[tuple[Expr, tuple[int, ...]], list[TaylorModel]] = {}
            for (turns, powers), group in self._groups.items():
                for power, model in self._coefficients(group, values).items():
                    found.setdefault((power + _weighted(powers, self._orders), turns), []).append(
                        model
                    )
            sizes = {key: _sizes(_total(models)) for key, models in found.items()}
            return self._prevailing(sizes, values)

    def _prevailing(
        self,
        sizes: Mapping[tuple[Expr, tuple[int, ...]], tuple[Array, Array]],
        values: Sequence[TaylorModel],
    ) -> float | None:
        """From least and largest sizes of the terms, by their power and how late they come: of
        other delays phases may oppose."""
        zero = np.zeros(len(values[0].c0))
        for top in {power for power, _ in sizes}:
            gaps = {
                power: self._valued(top - power, values).bounds()
                for power, _ in sizes
                if power != top
            }
            if all((low > 0).all() for low, _ in gaps.values()):
                break
        else:
            return None
        own = [(any(turns), size) for (power, turns), size in sizes.items() if power == top]
        least = sum((-most if late else low for late, (low, most) in own), zero)
        next_one = (
            self._next(top)
            if all(power == top - 1 or (low > 1).all() for power, (low, _) in gaps.items())
            else None
        )
        helping = sizes[next_one][0] if next_one else zero
        more = [
            (gaps[key[0]], most)
            for key, (_, most) in sizes.items()
            if key[0] != top and key != next_one
        ]
        radius = 2.0**-20
        while radius < _FARTHEST:
            rest = sum(
                (most * np.maximum(*(radius ** -x[:, 0] for x in gap)) for gap, most in more), zero
            )
            if (np.maximum(least, helping / radius) * (1 - 1e-9) > rest * (1 + 1e-9)).all():
                return radius
            radius *= 2
        return None

    def _next(self, top: Expr) -> tuple[Expr, tuple[int, ...]] | None:
        """The power below the highest, if |a s + b| >= |a s|, |b| in Re s >= 0: neither comes late,
        and both have one sign."""
        signs: dict[tuple[Expr, tuple[int, ...]], set[int]] = {}
        for (turns, powers), group in self._groups.items():
            for power, terms in group.items():
                signs.setdefault((power + _weighted(powers, self._orders), turns), set()).update(
                    1 if c > 0 else -1 for c, _ in terms
                )
        (turns, own), *others = (
            (turns, own) for (power, turns), own in signs.items() if power == top
        )
        found = top - 1, turns
        alike = not any(turns) and not others and len(own | signs.get(found, {1, -1})) == 1
        return found if alike and self._never_negative else None

    def left(self) -> Array:
        """Cells outside which there are no zeros on the axis, and in which there may be: none where
        that is proven."""
        cells = np.zeros((64, self.sides, 2))
        cells[:, :, 1] = 1.0
        edges = np.concatenate([[0.0], np.geomspace(1e-4, 1.0, 64)])
        cells[:, 0, 0], cells[:, 0, 1] = edges[:-1], edges[1:]
        waiting = Batches(
            cells, size=_BATCH, most=_MOST_CELLS, what="cells of frequency and ranges"
        )
        for own in waiting:
            clear, rates = self.bounded(own)
            waiting.add(halves(own[~clear], np.argmax(rates, -1)[~clear]))
        return waiting.rest

    def bounded(
        self, cells: Array, parts: tuple[TaylorModel, TaylorModel] | None = None
    ) -> tuple[Array, Array]:
        """Whether D is nowhere 0 in a cell, proven, and how much it varies along each side, in
        shares of its size there."""
        c0, c1, c2, r = self._along(cells, parts)
        with np.errstate(all="ignore"):
            rates = (np.abs(c1) + np.abs(c2).sum(-1)) / -c0[:, None]
        width = cells[:, :, 1] - cells[:, :, 0]
        rates = np.where(np.isfinite(rates).all(-1, keepdims=True), rates, width)
        return LineBound.of(c0, c1, c2, r).negative, rates * (width > 0) + 1e-12 * width

    def curve(self, cells: Array) -> LineBound:
        """As a judge of the one search: negative where D is not 0, and told nowhere to be positive,
        which would mean nothing."""
        return LineBound.of(*self._along(cells)).never_positive()

    def _along(
        self, cells: Array, parts: tuple[TaylorModel, TaylorModel] | None = None
    ) -> tuple[Array, Array, Array, Array]:
        """A Taylor model of minus D's share along what D is in the middle of a cell: D is not 0
        where that is negative."""
        with np.errstate(all="ignore"):
            real, imag = parts or self.parts(cells)
            size = np.hypot(real.c0, imag.c0)
            a, b = -real.c0 / size, -imag.c0 / size
            c1 = a[..., None] * real.c1 + b[..., None] * imag.c1
            c2 = a[..., None, None] * real.c2 + b[..., None, None] * imag.c2
            r = np.abs(a) * real.r + np.abs(b) * imag.r
            r = r + 1e-13 * (np.abs(a) * real.deviation + np.abs(b) * imag.deviation)
            return -size[:, 0] * (1 - 1e-12), c1[:, 0], c2[:, 0], r[:, 0]

    def parts(self, cells: Array) -> tuple[TaylorModel, TaylorModel]:
        """Real and imaginary part of D(j omega) over cells."""
        assert self.reach
        values = self._values(cells, self.reach)
        omega = values[0]
        real, imag = omega.number(0.0), omega.number(0.0)
        for (turns, powers), group in self._groups.items():
            x, y = self._polynomial(self._coefficients(group, values), omega)
            if any(powers):  # (j omega)^a
                a = self._valued(_weighted(powers, self._orders), values)
                size, (c, s) = omega.to_the(a), a.times(np.pi / 2).cosine_and_sine()
                x, y = (x * c - y * s) * size, (x * s + y * c) * size
            if any(turns):
                c, s = (
                    omega * self._valued(_weighted(turns, self._lags), values)
                ).cosine_and_sine()
                x, y = x * c + y * s, y * c - x * s
            real, imag = real + x, imag + y
        return real, imag

    def _valued(self, formula: Expr, values: Sequence[TaylorModel]) -> TaylorModel:
        """A formula of what varies."""
        return valued(formula, dict(zip(self._symbols, values[1:], strict=True)), values[0])

    def _values(self, cells: Array, reach: float) -> list[TaylorModel]:
        found = []
        for i, (low, width) in enumerate([(0.0, reach), *self._ranges]):
            start, end = cells[:, i].T
            middle, radius = low + width * (start + end) / 2, width * (end - start) / 2
            found.append(variable(middle, radius, abs(low) + width, i, self.sides, slopes=0))
        return found

    def _coefficients(
        self,
        group: Mapping[int, Sequence[tuple[Rational, tuple[int, ...]]]],
        values: Sequence[TaylorModel],
    ) -> dict[int, TaylorModel]:
        one = values[0].number(1.0)

        def monomial(exponents: tuple[int, ...]) -> TaylorModel:
            return prod(
                (x for x, n in zip(values[1:], exponents, strict=True) for _ in range(n)), start=one
            )

        return {
            power: _total(monomial(e).times(floated(c)) for c, e in terms)
            for power, terms in group.items()
        }

    @staticmethod
    def _polynomial(
        coefficients: Mapping[int, TaylorModel], omega: TaylorModel
    ) -> tuple[TaylorModel, TaylorModel]:
        """Its value at j omega."""
        found = [omega.number(0.0), omega.number(0.0)]
        for power in range(max(coefficients), -1, -1):
            found = [-found[1] * omega, found[0] * omega]
            if power in coefficients:
                found[0] = found[0] + coefficients[power]
        return found[0], found[1]


def _total(terms: Iterable[TaylorModel]) -> TaylorModel:
    first, *others = terms
    return sum(others, first)


def _weighted(times: Iterable[int], what: Iterable[Expr]) -> Expr:
    return sum((n * x for n, x in zip(times, what, strict=True)), Rational(0))


def _sizes(model: TaylorModel) -> tuple[Array, Array]:
    """The least and the largest absolute value over each cell."""
    low, high = (x[:, 0] for x in model.bounds())
    return np.maximum(np.maximum(low, -high), 0), np.maximum(-low, high)
