"""Whether a characteristic function D(s) has zeros on the imaginary axis for some values of its
parameters in a box of ranges: excluded by branch and bound.

D(s) is a polynomial in s, delays exp(-s tau) and powers s^alpha; its coefficients, delays and
orders are functions of the parameters. There is a reach R from which on the highest power of s
outweighs all other terms in Re s >= 0, whatever the values. Up to R, cells of frequency and
parameters are excluded in which D(j omega) lies, proven in Taylor models, on one side of a line
through 0. If no cell is left, no zero crosses the axis or reaches it from infinity anywhere in the
box, so the number of zeros in Re s >= 0 is the same for all values.

A *Taylor model* of a function has its value c0 in the middle of a cell, slopes c1, second-order
coefficients c2 and a proven radius r of the rest. A *ring* (``kernel.dynamics``) has s, pi, the
parameters, the unit delays exp(-s tau) and the powers s^alpha for generators. Begin with
``OnAxis.left``.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
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


_Exponents: TypeAlias = tuple[int, ...]
_Key: TypeAlias = tuple[_Exponents, _Exponents]
"""How often each unit delay, and each power of s, is in a term."""
_Terms: TypeAlias = dict[int, list[tuple[Rational, _Exponents]]]
"""By whole powers of s, numbers and the exponents of the symbols that they multiply."""
_Order: TypeAlias = tuple[Expr, _Exponents]
"""The whole power of s, with its fractional powers, and how often each unit delay is in a term."""


class OnAxis:
    """D(j omega) of a polynomial of a ring, over the values that some of its symbols may have.

    Cells are arrays (cells, 1 + symbols, 2) of shares, 0 at the low end, 1 at the high one; omega
    goes from 0 to the reach.
    """

    def __init__(
        self, ring: Ring, polynomial: Polynomial, ranges: Mapping[Symbol, tuple[Expr, Expr]]
    ) -> None:
        self._lags = ring.lags
        self._orders = ring.orders
        self._symbols = list(ranges)
        self.sides = 1 + len(ranges)
        self._ranges: list[tuple[float, float]] = []  # low ends and widths
        for low, high in ranges.values():
            self._ranges.append((floated(low), floated(high - low)))
        self._never_negative = all(sign_of_number(low) >= 0 for low, _ in ranges.values())
        self._groups: dict[_Key, _Terms] = {}
        # Generators of the ring in order: s, pi, symbols, delays, fractional powers of s. Without
        # s and pi the delays begin at ``first_delay``, the powers at ``first_power``.
        first_delay = ring.size - 2
        first_power = first_delay + len(ring.lags)
        for exponents, value in polynomial.to_dict().items():
            power_of_s, power_of_pi, *powers = [int(n) for n in exponents]
            of_symbols = dict(zip(ring.symbols, powers[:first_delay], strict=True))
            rational = Rational(int(value.p), int(value.q))
            number = rational * pi**power_of_pi
            monomial = tuple(of_symbols.get(x, 0) for x in self._symbols)
            of_delays = tuple(powers[first_delay:first_power])
            key = of_delays, tuple(powers[first_power:])
            group = self._groups.setdefault(key, {})
            group.setdefault(power_of_s, []).append((number, monomial))

    @cached_property
    def reach(self) -> float | None:
        """A frequency from which on the highest power prevails, for all values; None where that is
        not known."""
        # Over the whole box bounds of coefficients may contain 0 that are nowhere 0; 2^9 pieces of
        # one side, fewer of each of several, usually separate them from it.
        cells = np.broadcast_to([0.0, 1.0], (1, self.sides, 2)).copy()
        parameters = self.sides - 1
        for i in range(9 * parameters):
            if len(cells) < _PIECES:
                side = 1 + i % parameters
                cells = halves(cells, np.full(len(cells), side))
        with np.errstate(all="ignore"):
            values = self._values(cells, 0.0)
            # Coefficients of the same power and delay are added as models, and bounded afterwards:
            # bounds of each would lose what cancels between them.
            models: dict[_Order, list[TaylorModel]] = {}
            for (turns, powers), group in self._groups.items():
                fractional = _weighted(powers, self._orders)
                for power, model in self._coefficients(group, values).items():
                    key = power + fractional, turns
                    models.setdefault(key, []).append(model)
            sizes = {key: _sizes(_total(summands)) for key, summands in models.items()}
            return self._prevailing(sizes, values)

    def _prevailing(
        self, sizes: Mapping[_Order, tuple[Array, Array]], values: Sequence[TaylorModel]
    ) -> float | None:
        """From least and largest sizes of the terms, by their power and how late they come: of
        other delays phases may oppose."""
        zero = np.zeros(len(values[0].c0))
        powers = [power for power, _ in sizes]
        # With open orders which power is the highest may depend on the values: then none is.
        for top in set(powers):
            others = [power for power in powers if power != top]
            gaps = {power: self._valued(top - power, values).bounds() for power in others}
            if all((low > 0).all() for low, _ in gaps.values()):
                break
        else:
            return None
        # The inequality is tried at one radius and must stay true beyond it. Divided by the highest
        # power, the next one falls as 1/R: it may help where all else falls at least as fast.
        slower = [low for power, (low, _) in gaps.items() if power != top - 1]
        falls_fast = all((low > 1).all() for low in slower)
        next_key = self._next(top) if falls_fast else None
        helping = sizes[next_key][0] if next_key else zero
        least = zero
        opposing = []
        for key, (low, most) in sizes.items():
            power, turns = key
            if power == top:
                # |exp(-s tau)| <= 1 in Re s >= 0, and any phase is possible: a delayed term of the
                # highest power counts against the undelayed one with all of its size.
                least = least + (-most if any(turns) else low)
            elif key != next_key:
                least_gap, largest_gap = gaps[power]
                opposing.append((-least_gap[:, 0], -largest_gap[:, 0], most))
        radius = 2.0**-20
        while radius < _FARTHEST:
            rest = zero
            for shallow, steep, most in opposing:
                # R^-gap is monotone in the gap, so its bounds are at the ends: below 1 rad/s at the
                # larger gap, above at the smaller.
                share = np.maximum(radius**shallow, radius**steep)
                rest = rest + most * share
            prevails = np.maximum(least, helping / radius)
            # 1e-9 is far more than all roundings here: nothing is decided at equality.
            if (prevails * (1 - 1e-9) > rest * (1 + 1e-9)).all():
                return radius
            radius *= 2
        return None

    def _next(self, top: Expr) -> _Order | None:
        """The power below the highest, if |a s + b| >= |a s|, |b| in Re s >= 0: neither comes late,
        and both have one sign. None where that is not known."""
        # Signs are read off the numbers before monomials in parameters that are never negative.
        signs: dict[_Order, set[int]] = {}
        for (turns, powers), group in self._groups.items():
            fractional = _weighted(powers, self._orders)
            for power, terms in group.items():
                of_term = signs.setdefault((power + fractional, turns), set())
                of_term.update(1 if c > 0 else -1 for c, _ in terms)
        key, *others = [key for key in signs if key[0] == top]
        # A highest power with a delay, or with and without one, is not compared with the next.
        _, turns = key
        if others or any(turns) or not self._never_negative:
            return None
        next_key = top - 1, turns
        top_signs = signs[key]
        # Where there is no term of the next power its sign is not known: both are in the set.
        both_signs = top_signs | signs.get(next_key, {1, -1})
        return next_key if len(both_signs) == 1 else None

    def left(self) -> Array:
        """Cells outside which there are no zeros on the axis, and in which there may be: none where
        that is proven."""
        # Zeros lie at any scale between 0 and the reach, so the first cut of frequency is
        # geometric.
        cells = np.zeros((64, self.sides, 2))
        cells[:, :, 1] = 1.0
        edges = np.concatenate([[0.0], np.geomspace(1e-4, 1.0, 64)])
        cells[:, 0, 0] = edges[:-1]
        cells[:, 0, 1] = edges[1:]
        waiting = Batches(
            cells, size=_BATCH, most=_MOST_CELLS, what="cells of frequency and ranges"
        )
        for batch in waiting:
            clear, rates = self.bounded(batch)
            side = np.argmax(rates, -1)
            waiting.add(halves(batch[~clear], side[~clear]))
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
        known = np.isfinite(rates).all(-1, keepdims=True)
        rates = np.where(known, rates, width)
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
            a = -real.c0 / size
            b = -imag.c0 / size
            a_row, b_row = a[..., None], b[..., None]
            c1 = a_row * real.c1 + b_row * imag.c1
            a_matrix, b_matrix = a_row[..., None], b_row[..., None]
            c2 = a_matrix * real.c2 + b_matrix * imag.c2
            # The direction may be any: that a and b are rounded costs nothing. The roundings of the
            # sums above, and of the size, are counted in r and in the factor of c0.
            a = np.abs(a)
            b = np.abs(b)
            r = a * real.r + b * imag.r
            spread = a * real.deviation + b * imag.deviation
            r = r + 1e-13 * spread
            c0 = -size * (1 - 1e-12)
            return c0[:, 0], c1[:, 0], c2[:, 0], r[:, 0]

    def parts(self, cells: Array) -> tuple[TaylorModel, TaylorModel]:
        """Real and imaginary part of D(j omega) over cells."""
        # A term is a polynomial in s, times a fractional power of s, times a delay.
        assert self.reach
        values = self._values(cells, self.reach)
        omega = values[0]
        real = imag = omega.number(0.0)
        for (turns, powers), group in self._groups.items():
            coefficients = self._coefficients(group, values)
            x, y = self._polynomial(coefficients, omega)
            # (j omega)^a = omega^a (cos(a pi/2) + j sin(a pi/2))
            if any(powers):
                a = self._valued(_weighted(powers, self._orders), values)
                size = omega.to_the(a)
                c, s = a.times(np.pi / 2).cosine_and_sine()
                turned_real = x * c - y * s
                turned_imag = x * s + y * c
                x = turned_real * size
                y = turned_imag * size
            # exp(-j omega tau) = cos(omega tau) - j sin(omega tau)
            if any(turns):
                delay = self._valued(_weighted(turns, self._lags), values)
                angle = omega * delay
                c, s = angle.cosine_and_sine()
                turned_real = x * c + y * s
                y = y * c - x * s
                x = turned_real
            real = real + x
            imag = imag + y
        return real, imag

    def _valued(self, formula: Expr, values: Sequence[TaylorModel]) -> TaylorModel:
        """A formula of what varies."""
        omega, *of_symbols = values
        known = dict(zip(self._symbols, of_symbols, strict=True))
        return valued(formula, known, omega)

    def _values(self, cells: Array, reach: float) -> list[TaylorModel]:
        """The models of omega and of the symbols over cells; without slopes, as only values
        count."""
        models = []
        for i, (low, width) in enumerate([(0.0, reach), *self._ranges]):
            start, end = cells[:, i].T
            middle = low + width * (start + end) / 2
            radius = width * (end - start) / 2
            size = abs(low) + width
            models.append(variable(middle, radius, size, i, self.sides, slopes=0))
        return models

    def _coefficients(
        self,
        group: Mapping[int, Sequence[tuple[Rational, _Exponents]]],
        values: Sequence[TaylorModel],
    ) -> dict[int, TaylorModel]:
        """The coefficients of a group by whole powers of s: polynomials in the symbols."""
        omega, *of_symbols = values
        one = omega.number(1.0)
        coefficients = {}
        for power, terms in group.items():
            models = []
            for number, exponents in terms:
                monomial = one
                for x, n in zip(of_symbols, exponents, strict=True):
                    for _ in range(n):
                        monomial = monomial * x
                models.append(monomial.times(floated(number)))
            coefficients[power] = _total(models)
        return coefficients

    @staticmethod
    def _polynomial(
        coefficients: Mapping[int, TaylorModel], omega: TaylorModel
    ) -> tuple[TaylorModel, TaylorModel]:
        """Real and imaginary part of a polynomial in s at s = j omega."""
        # Horner's rule, with (x + j y) j omega = -y omega + j x omega.
        real = imag = omega.number(0.0)
        for power in range(max(coefficients), -1, -1):
            real, imag = -imag * omega, real * omega
            if power in coefficients:
                real = real + coefficients[power]
        return real, imag


def _total(terms: Iterable[TaylorModel]) -> TaylorModel:
    """The sum of at least one model."""
    # The sum starts with a model: 0 + model is not defined.
    first, *others = terms
    return sum(others, first)


def _weighted(times: Iterable[int], what: Iterable[Expr]) -> Expr:
    """The sum of the products of whole numbers and expressions."""
    total = Rational(0)
    for n, x in zip(times, what, strict=True):
        total += n * x
    return total


def _sizes(model: TaylorModel) -> tuple[Array, Array]:
    """The least and the largest absolute value over each cell."""
    low, high = (x[:, 0] for x in model.bounds())
    least = np.maximum(np.maximum(low, -high), 0)
    return least, np.maximum(-low, high)
