"""Whether a characteristic function D(s) has zeros on the imaginary axis for some values of its
parameters in a box of ranges: excluded by branch and bound.

D(s) is a polynomial in s, delays exp(-s tau) and powers s^alpha; its coefficients, delays and
orders are functions of the parameters. There is a reach R from which on the highest power of s
outweighs all other terms in Re s >= 0, whatever the values. Up to R, cells of frequency and
parameters are excluded in which D(j omega) lies, proven in Taylor models, on one side of a line
through 0. If no cell is left, no zero crosses the axis or reaches it from infinity anywhere in the
box, so the number of zeros in Re s >= 0 is the same for all values. Begin with ``OnAxis.left``.
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
_FARTHEST = 2.0**60  # rad/s: beyond it no reach is looked for


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
        # Generators of the ring in order: s, pi, symbols; from ``first`` on delays, from ``last``
        # on fractional powers of s.
        first, last = ring.size, ring.size + len(ring.lags)
        for exponents, value in polynomial.to_dict().items():
            power_of_s, power_of_pi, *powers = [int(n) for n in exponents]
            of_symbols = dict(zip(ring.symbols, powers[: first - 2], strict=True))
            number = Rational(int(value.p), int(value.q)) * pi**power_of_pi
            monomial = tuple(of_symbols.get(x, 0) for x in self._symbols)
            key = tuple(powers[first - 2 : last - 2]), tuple(powers[last - 2 :])
            group = self._groups.setdefault(key, {})
            group.setdefault(power_of_s, []).append((number, monomial))

    @cached_property
    def reach(self) -> float | None:
        """A frequency from which on the highest power prevails, for all values; None where that is
        not known."""
        # Over the whole box bounds of coefficients may contain 0 that are nowhere 0; 2^9 pieces of
        # one side, fewer of each of several, usually separate them from it.
        cells = np.broadcast_to([0.0, 1.0], (1, self.sides, 2)).copy()
        for i in range(9 * (self.sides - 1)):
            if len(cells) < _PIECES:
                cells = halves(cells, np.full(len(cells), 1 + i % (self.sides - 1)))
        with np.errstate(all="ignore"):
            values = self._values(cells, 0.0)
            # Coefficients of the same power and delay are added as models, and bounded afterwards:
            # bounds of each would lose what cancels between them.
            coefficients: dict[tuple[Expr, tuple[int, ...]], list[TaylorModel]] = {}
            for (turns, powers), group in self._groups.items():
                fractional = _weighted(powers, self._orders)
                for power, model in self._coefficients(group, values).items():
                    coefficients.setdefault((power + fractional, turns), []).append(model)
            sizes = {key: _sizes(_total(models)) for key, models in coefficients.items()}
            return self._prevailing(sizes, values)

    def _prevailing(
        self,
        sizes: Mapping[tuple[Expr, tuple[int, ...]], tuple[Array, Array]],
        values: Sequence[TaylorModel],
    ) -> float | None:
        """From least and largest sizes of the terms, by their power and how late they come: of
        other delays phases may oppose."""
        zero = np.zeros(len(values[0].c0))
        # With open orders which power is the highest may depend on the values: then none is.
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
        # |exp(-s tau)| <= 1 in Re s >= 0, and any phase is possible: a delayed term of the highest
        # power counts against the undelayed one with all of its size.
        leading = [(any(turns), size) for (power, turns), size in sizes.items() if power == top]
        least = sum((-most if late else low for late, (low, most) in leading), zero)
        # The inequality is tried at one radius and must stay true beyond it. Divided by the highest
        # power, the next one falls as 1/R: it may help where all else falls at least as fast.
        falls_fast = all(power == top - 1 or (low > 1).all() for power, (low, _) in gaps.items())
        next_key = self._next(top) if falls_fast else None
        helping = sizes[next_key][0] if next_key else zero
        opposing = [
            (gaps[key[0]], most)
            for key, (_, most) in sizes.items()
            if key[0] != top and key != next_key
        ]
        radius = 2.0**-20
        while radius < _FARTHEST:
            # R^-gap is monotone in the gap, so its bounds are at the ends: below 1 rad/s at the
            # larger gap, above at the smaller.
            rest = sum(
                (most * np.maximum(*(radius ** -x[:, 0] for x in gap)) for gap, most in opposing),
                zero,
            )
            # 1e-9 is far more than all roundings here: nothing is decided at equality.
            if (np.maximum(least, helping / radius) * (1 - 1e-9) > rest * (1 + 1e-9)).all():
                return radius
            radius *= 2
        return None

    def _next(self, top: Expr) -> tuple[Expr, tuple[int, ...]] | None:
        """The power below the highest, if |a s + b| >= |a s|, |b| in Re s >= 0: neither comes late,
        and both have one sign."""
        # Signs are read off the numbers before monomials in parameters that are never negative.
        signs: dict[tuple[Expr, tuple[int, ...]], set[int]] = {}
        for (turns, powers), group in self._groups.items():
            fractional = _weighted(powers, self._orders)
            for power, terms in group.items():
                key = power + fractional, turns
                signs.setdefault(key, set()).update(1 if c > 0 else -1 for c, _ in terms)
        leading = [(turns, found) for (power, turns), found in signs.items() if power == top]
        (turns, top_signs), *others = leading
        next_key = top - 1, turns
        both_signs = top_signs | signs.get(next_key, {1, -1})
        alike = not any(turns) and not others and len(both_signs) == 1
        return next_key if alike and self._never_negative else None

    def left(self) -> Array:
        """Cells outside which there are no zeros on the axis, and in which there may be: none where
        that is proven."""
        # Zeros lie at any scale between 0 and the reach, so the first cut of frequency is
        # geometric.
        cells = np.zeros((64, self.sides, 2))
        cells[:, :, 1] = 1.0
        edges = np.concatenate([[0.0], np.geomspace(1e-4, 1.0, 64)])
        cells[:, 0, 0], cells[:, 0, 1] = edges[:-1], edges[1:]
        waiting = Batches(
            cells, size=_BATCH, most=_MOST_CELLS, what="cells of frequency and ranges"
        )
        for batch in waiting:
            clear, rates = self.bounded(batch)
            waiting.add(halves(batch[~clear], np.argmax(rates, -1)[~clear]))
        return waiting.rest

    def bounded(
        self, cells: Array, parts: tuple[TaylorModel, TaylorModel] | None = None
    ) -> tuple[Array, Array]:
        """Whether D is nowhere 0 in a cell, proven, and how much it varies along each side, in
        shares of its size there."""
        c0, c1, c2, r = self._along(cells, parts)
        with np.errstate(all="ignore"):
            changes = np.abs(c1) + np.abs(c2).sum(-1)
            rates = changes / -c0[:, None]
        # Rates only choose which side of a cell is cut; the proof rests on ``negative`` alone.
        # Where they are unknown the widest side is cut, and a side without width never.
        width = cells[:, :, 1] - cells[:, :, 0]
        rates = np.where(np.isfinite(rates).all(-1, keepdims=True), rates, width)
        rates = rates * (width > 0) + 1e-12 * width
        return LineBound.of(c0, c1, c2, r).negative, rates

    def curve(self, cells: Array) -> LineBound:
        """A bound for the search of ``kernel.where``: negative where D is not 0. It is never
        positive, as that would prove nothing about D."""
        return LineBound.of(*self._along(cells)).never_positive()

    def _along(
        self, cells: Array, parts: tuple[TaylorModel, TaylorModel] | None = None
    ) -> tuple[Array, Array, Array, Array]:
        """A Taylor model of -Re(D conj(D_0))/|D_0|, D_0 being D in the middle of the cell: where it
        is negative D is not 0. As the arrays c0, c1, c2 and r of its value alone."""
        with np.errstate(all="ignore"):
            real, imag = parts or self.parts(cells)
            size = np.hypot(real.c0, imag.c0)
            a, b = -real.c0 / size, -imag.c0 / size
            c1 = _combined(a[..., None], real.c1, b[..., None], imag.c1)
            c2 = _combined(a[..., None, None], real.c2, b[..., None, None], imag.c2)
            # The direction may be any: that a and b are rounded costs nothing. The roundings of the
            # sums above, and of the size, are counted in r and in the factor of c0.
            a, b = np.abs(a), np.abs(b)
            r = _combined(a, real.r, b, imag.r)
            r = r + 1e-13 * _combined(a, real.deviation, b, imag.deviation)
            c0 = -size * (1 - 1e-12)
            return c0[:, 0], c1[:, 0], c2[:, 0], r[:, 0]

    def parts(self, cells: Array) -> tuple[TaylorModel, TaylorModel]:
        """Real and imaginary part of D(j omega) over cells."""
        # A term is a polynomial in s, times a fractional power of s, times a delay.
        assert self.reach
        values = self._values(cells, self.reach)
        omega = values[0]
        real, imag = omega.number(0.0), omega.number(0.0)
        for (turns, powers), group in self._groups.items():
            x, y = self._polynomial(self._coefficients(group, values), omega)
            # (j omega)^a = omega^a (cos(a pi/2) + j sin(a pi/2))
            if any(powers):
                a = self._valued(_weighted(powers, self._orders), values)
                size, (c, s) = omega.to_the(a), a.times(np.pi / 2).cosine_and_sine()
                x, y = (x * c - y * s) * size, (x * s + y * c) * size
            # exp(-j omega tau) = cos(omega tau) - j sin(omega tau)
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
        """The models of omega and of the symbols over cells; without slopes, as only values
        count."""
        models = []
        for i, (low, width) in enumerate([(0.0, reach), *self._ranges]):
            start, end = cells[:, i].T
            middle = low + width * (start + end) / 2
            radius = width * (end - start) / 2
            models.append(variable(middle, radius, abs(low) + width, i, self.sides, slopes=0))
        return models

    def _coefficients(
        self,
        group: Mapping[int, Sequence[tuple[Rational, tuple[int, ...]]]],
        values: Sequence[TaylorModel],
    ) -> dict[int, TaylorModel]:
        """The coefficients of a group by whole powers of s: polynomials in the symbols."""
        one = values[0].number(1.0)

        def monomial(exponents: tuple[int, ...]) -> TaylorModel:
            factors = (x for x, n in zip(values[1:], exponents, strict=True) for _ in range(n))
            return prod(factors, start=one)

        return {
            power: _total(monomial(e).times(floated(c)) for c, e in terms)
            for power, terms in group.items()
        }

    @staticmethod
    def _polynomial(
        coefficients: Mapping[int, TaylorModel], omega: TaylorModel
    ) -> tuple[TaylorModel, TaylorModel]:
        """Real and imaginary part of a polynomial in s at s = j omega."""
        # Horner's rule, with (x + j y) j omega = -y omega + j x omega.
        real, imag = omega.number(0.0), omega.number(0.0)
        for power in range(max(coefficients), -1, -1):
            real, imag = -imag * omega, real * omega
            if power in coefficients:
                real = real + coefficients[power]
        return real, imag


def _combined(a: Array, x: Array, b: Array, y: Array) -> Array:
    """a x + b y."""
    return a * x + b * y


def _total(terms: Iterable[TaylorModel]) -> TaylorModel:
    # The sum starts with a model: 0 + model is not defined.
    first, *others = terms
    return sum(others, first)


def _weighted(times: Iterable[int], what: Iterable[Expr]) -> Expr:
    return sum((n * x for n, x in zip(times, what, strict=True)), Rational(0))


def _sizes(model: TaylorModel) -> tuple[Array, Array]:
    """The least and the largest absolute value over each cell."""
    low, high = (x[:, 0] for x in model.bounds())
    return np.maximum(np.maximum(low, -high), 0), np.maximum(-low, high)
