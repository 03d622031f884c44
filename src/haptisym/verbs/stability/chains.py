"""Infinitely many roots: chains from infinity or at the axis, delays at which roots switch sides, what one count tells.

Where one open number puts roots of a neutral loop on the imaginary axis: between values at which chains of roots come to it.

Between two such values there is a chain on the right for all values, or for none. Where there is none no root comes from
infinity, and those on the axis lie below a frequency that is one for all values of an interval. Beside a value at which a chain
comes to the axis it may grow without bound: then there are as many critical values as one likes, and what is nearest to it
stays open.

At which values of one open number a root, or a chain of infinitely many, comes from infinity.

They do where what multiplies the highest power of s, L(z; q) with z = exp(-s tau), is lost or has a zero with |z| = 1.

The values of an open delay at which roots switch sides: A(s) + B(s) exp(-s tau) = 0 where |A| = |B|, again and again.

At a frequency where |A/B| grows through 1 roots go to the right, at every such delay, and to the left where it falls (Cooke
and van den Driessche, 1986). From each frequency omega they come once in 2 pi/omega seconds: the highest one is one of the
first kind, and so there are ever more roots on the right in the end.

Which way roots cross the imaginary axis as an open number grows: where it is one way alone, one count tells of endless values.

C = A + q B has a root at j omega where g = -A/B is q. It moves to the right as q > 0 grows if the phase of g grows with omega
there, and to the left if it falls (the root tendency). Beyond some frequency delays make it one of the two: then what meets the
axis there only adds roots on the right, or only takes them away, one infinitely long sequence after the other.

One root on the right for all values of an open number in an interval: enough to say that none of them is stable.

Newton's step in balls, over all these values at once, goes from a box into itself: so each of them has a root in it.
"""

from __future__ import annotations

from cmath import exp
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations, pairwise, product
from math import copysign, isfinite, sqrt

import flint
from flint import acb, arb
from sympy import Expr, Integer, Rational

from haptisym.judge.peaks import ValueAt
from haptisym.kernel.dynamics import RealFunction, Ring, on_axis, squared_modulus
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.far import Sense, far
from haptisym.kernel.reals import Ball, ExactNumber, RealNumber, expression_ball, rational_between
from haptisym.kernel.rings import RationalFunction, degree_in, s
from haptisym.kernel.rootcount import Row, is_mirrored, least_on_torus
from haptisym.kernel.roots import ALIKE_BITS, chart, each_once, ordered, sign_of_number
from haptisym.verbs.stability.loops import (
    Characteristic,
    Curve,
    Gap,
    Loop,
    Meeting,
    Meetings,
    Reach,
    coefficients,
    curve_of,
    lag_of,
    minus,
    reach_of,
    zeros,
)

_TURNINGS = (40, 120)  # radians that delays turn up to where roots are looked for
_DEEPEST = 40
_BALL = 192


@dataclass(frozen=True)
class _Cell:
    """Values between two; None where nothing bounds them."""

    low: RealNumber | None
    high: RealNumber | None

    @property
    def middle(self) -> Rational:
        """A number inside, twice as far out where there is no bound."""
        if self.low is None and self.high is None:
            return Integer(0)
        if self.low is None or self.high is None:
            inner = self.low or self.high
            assert inner is not None
            far = Rational(2 * abs(int(float(inner))) + 1)
            return far if self.high is None else -far
        a, b = float(self.low), float(self.high)
        middle = Rational((a + b) / 2)
        inside = ordered(self.low, ExactNumber(middle)) > 0 and ordered(ExactNumber(middle), self.high) > 0
        return middle if inside else rational_between(self.low, self.high)

    @property
    def halves(self) -> tuple[_Cell, _Cell]:
        """Before its middle, and beyond."""
        middle = ExactNumber(self.middle)
        return _Cell(self.low, middle), _Cell(middle, self.high)

    def radius(self, reach: Reach, turning: int) -> Rational | None:
        """Beyond which no value in it, nor its ends, puts roots on the axis."""
        low, high = (None if x is None else x.ball(_BALL) for x in (self.low, self.high))
        with flint.ctx.workprec(_BALL):
            if low is not None and high is not None:
                return reach.radius(low.union(high), turning, inverse=False)
            inner = low if high is None else high
            if inner is None or (not inner > 0 if high is None else not inner < 0):
                return None
            return reach.radius((1 / inner).union(arb(0)), turning, inverse=True)

    def is_hopeless(self, reach: Reach, turning: int) -> bool:
        """Whether nothing is known of either end, nor of its middle."""
        places = (self.low, ExactNumber(self.middle), self.high)
        ends = [(arb(0), True) if x is None else (x.ball(_BALL), False) for x in places]
        return all(reach.radius(q, turning, inverse=inverse) is None for q, inverse in ends)


def neutral_meetings(loop: Loop, curve: Curve, far_out: Sequence[Meeting]) -> Iterator[Meetings]:
    """All, but for those in gaps, which become smaller."""
    reach = reach_of(loop)
    clear = cells(loop, far_out)
    for turning in _TURNINGS:
        pieces = [piece for cell in clear for piece in _pieces(cell, reach, turning, _DEEPEST)]
        known = [radius for _, radius in pieces if radius is not None]
        found = curve.meetings(max(known)) if known else ()
        gaps = tuple(_joined([cell for cell, radius in pieces if radius is None]))
        yield Meetings((*far_out, *found), gaps=gaps)
        if not gaps:
            return


def cells(loop: Loop, far_out: Sequence[Meeting]) -> list[_Cell]:
    """Without chains on the right or at the axis, between the values at which these come, as far as a number may go."""
    low, high = (None if x is None else ExactNumber(x) for x in (loop.low, loop.high))
    inside = [
        x.value for x in far_out
        if (low is None or ordered(low, x.value) > 0) and (high is None or ordered(x.value, high) > 0)
    ]  # fmt: skip
    found = (_Cell(a, b) for a, b in pairwise([low, *each_once(inside, lambda x: x), high]))
    return [x for x in found if loop.at(rational_between(x.low, x.high)).chain is None]


def _pieces(cell: _Cell, reach: Reach, turning: int, depth: int) -> Iterator[tuple[_Cell, Rational | None]]:
    """A cell in pieces, each with its radius; None where none is known."""
    radius = cell.radius(reach, turning)
    if radius is not None or not depth or cell.is_hopeless(reach, turning):
        yield cell, radius
        return
    for half in cell.halves:
        yield from _pieces(half, reach, turning, depth - 1)


def _joined(cells: Sequence[_Cell]) -> Iterator[Gap]:
    """Cells that touch as one."""
    start: RealNumber | None = None
    for i, cell in enumerate(cells):
        if i == 0 or cells[i - 1].high is not cell.low or cell.low is None:
            start = cell.low
        if i + 1 == len(cells) or cells[i + 1].low is not cell.high or cell.high is None:
            yield Gap(start, cell.high)


_MOST_DELAYED = 5
Leading = Mapping[tuple[int, ...], Row]


def from_infinity(loop: Loop) -> tuple[Meeting, ...]:
    """All of these values, and perhaps others."""
    return tuple(Meeting(x, None) for x in _values(loop))


def _values(loop: Loop) -> Iterator[RealNumber]:
    leading = loop.leading
    _need_same_zeros(leading, loop)
    if not any(any(row[1:]) for row in leading.values()):
        return
    if loop.low is None and any(any(row[2:]) for row in leading.values()):
        raise UndecidedError("where a chain of roots comes to the axis, of a number that may be negative")
    if _is_product(leading):
        yield from zeros(next(iter(leading.values())))
        return
    delayed = [turns for turns in leading if any(turns)]
    units = {i for turns in delayed for i, n in enumerate(turns) if n}
    if len(delayed) > 1 and len(units) == 1:
        yield from _on_circle(leading, units.pop(), loop)
        return
    if len(delayed) > _MOST_DELAYED:
        raise UndecidedError("where a chain of roots comes to the axis, as many delays meet in the highest power of s")
    own = leading.get((0,) * len(loop.ring.lags), [Integer(0)])
    for signs in product((1, -1), repeat=len(delayed)):  # |own| = sum of |delayed|, whatever their signs are
        yield from zeros(_sum([own, *([sign * c for c in leading[x]] for sign, x in zip(signs, delayed, strict=True))]))


def _need_same_zeros(leading: Leading, loop: Loop) -> None:
    """UndecidedError where an open delay meets another one in L: its zeros turn on whether their ratio is rational."""
    least = [min(column) for column in zip(*leading, strict=True)]  # what is in all terms has no zeros
    own = {tuple(n - k for n, k in zip(turns, least, strict=True)): row[0] for turns, row in leading.items()}
    units = {i for turns in own for i, n in enumerate(turns) if n}
    if len(units) < 2 or not any(loop.symbol in loop.ring.lags[i].free_symbols for i in units):
        return
    if not (loop.rests and is_mirrored(own)) and least_on_torus(own) is None:
        raise UndecidedError("where a chain of roots comes to the axis, as delays meet that are no multiples of one")


def _is_product(leading: Leading) -> bool:
    """Whether L = c(q) A(z): its zeros are the same for all q, and all of them are lost where c is 0."""
    first, *others = leading.values()
    places = list(combinations(range(len(first)), 2))
    return not any(sign_of_number(first[i] * row[k] - first[k] * row[i]) for row in others for i, k in places)


def _sum(rows: list[Row]) -> Row:
    longest = max(map(len, rows))
    return [sum((row[i] for row in rows if i < len(row)), Integer(0)) for i in range(longest)]


def _on_circle(leading: Leading, unit: int, loop: Loop) -> Iterator[RealNumber]:
    """Of one unit delay: z = 1 and z = -1, where L is real, and the rest as z = (1 - w)/(1 + w), on the axis of w."""
    powers = {turns[unit]: row for turns, row in leading.items()}
    n = max(powers)
    for end in (1, -1):
        yield from zeros(_sum([[end**i * c for c in row] for i, row in powers.items()]))
    turned = sum(
        c * loop.symbol**k * (1 - s) ** i * (1 + s) ** (n - i) for i, row in powers.items() for k, c in enumerate(row)
    )
    plain = turned.expand()
    ring = Ring.of([plain])
    top = ring.convert(plain).numerator
    curve = curve_of(Loop(ring, top, top.context().constant(1), loop.symbol, loop.low, loop.high))
    if curve is None or curve.condition.is_zero:
        raise UndecidedError("where a chain of roots comes to the axis")
    settled = far(curve.condition)
    if settled.sense not in (Sense.POSITIVE, Sense.NEGATIVE):
        raise UndecidedError("where a chain of roots comes to the axis")
    yield from (x.value for x in curve.meetings(max(settled.radius, Integer(1))))


def is_neutral(loop: Loop) -> bool:
    """Whether the highest power of s comes late too."""
    return any(any(turns) for turns in loop.leading)


_FURTHER = 8  # turns of a delay beyond its value
_MOST_FURTHER = 300  # of all frequencies together, where that tells of all delays
_BITS = 192


@dataclass(frozen=True, repr=False)
class DelayAt(RealNumber):
    """The delay for which A + B exp(-j omega tau) vanishes at a frequency where both are of one size, and ``turn`` more turns.

    ``is_real`` : whether -A/B is a real number there, and so 1 or -1: balls around an angle of 0 or pi do not tell.
    """

    ratio: tuple[RealFunction, RealFunction]
    omega: RealNumber
    turn: int
    multiple: Expr
    is_real: bool = False

    def ball(self, bits: int) -> Ball:
        with flint.ctx.workprec(bits):
            x = self.omega.ball(bits)
            real, imag = (part.ball(x) for part in self.ratio)
            angle = -acb(real, 0 if self.is_real else imag).arg()  # exp(-j omega tau) = -A/B
            return (angle + 2 * arb.pi() * self.turn) / (x * expression_ball(self.multiple))


@dataclass(frozen=True)
class Switches:
    """The first delays >= 0 at the frequencies where |A| = |B|, each with the sense in which |A/B| goes through 1 there.

    ``is_still`` : whether |A| and |B| differ at omega = 0.
    """

    firsts: tuple[DelayAt, ...]
    senses: tuple[int, ...]
    is_still: bool

    @classmethod
    def of(cls, loop: Loop) -> Switches:
        """Of a loop with an open delay and without a chain of roots on the right. UndecidedError where it has another form."""
        ratio, multiple = _ratio(loop)
        condition = minus(squared_modulus(ratio).function, Integer(1))
        settled = far(condition)
        if settled.sense not in (Sense.POSITIVE, Sense.NEGATIVE):
            raise UndecidedError("where roots meet the imaginary axis")
        response = on_axis(ratio)
        functions = {"": RealFunction(condition.reduced()), "imag": response.imag}
        table = chart(functions, Integer(0), max(settled.radius, Integer(1)))
        if any("" in point.undecided for point in table.points):
            raise UndecidedError("whether a root touches the imaginary axis")
        first, *points = table.points
        found = [x for x in points if x.orders.get("", 0) > 0]
        real = [response.imag.is_zero or x.orders.get("imag", 0) > 0 for x in found]
        parts = response.real, response.imag
        each = (DelayAt(parts, x.omega, 0, multiple, is_real=y) for x, y in zip(found, real, strict=True))
        senses = tuple((x.after[""] - x.before[""]) // 2 for x in found)
        return cls(tuple(map(_first, each)), senses, first.orders.get("", 0) <= 0)

    def up_to(self, value: Expr) -> tuple[tuple[Meeting, ...], Rational | None]:
        """All delays >= 0 up to some turns beyond a value, and up to which delay these are all; None where no others come."""
        if not self.firsts:
            return (), None
        end = self._end(value)
        found = tuple(
            x
            for first, sense in self._each
            for x in _turned(first, _turns(first, end), sense if self.is_still else None)
        )
        last = min((2 * _turns(x, end) - 1) * 3.14 / _rate(x) for x in self.firsts)
        return found, Rational(last).limit_denominator(10**9)

    def _end(self, value: Expr) -> float:
        """As far as all that comes after can be told, if that is not too far."""
        last = self.unstable_from
        if last is None:
            return float(value)
        many = sum(float(last) * _rate(x) / 6.28 for x in self.firsts)
        return max(float(value), float(last)) if many < _MOST_FURTHER else float(value)

    @cached_property
    def unstable_from(self) -> Rational | None:
        """A delay beyond which there are roots on the right for all delays; None where that is not shown.

        Of a frequency whose delays begin at theta/omega, theta from 0 to 2 pi, at least (omega tau - theta)/(2 pi) have come at
        tau, and at most one more. So there are roots where the sum of senses omega tau is beyond what is lost at the beginning.
        """
        if not self.is_still:
            return None
        with flint.ctx.workprec(_BITS):
            slope, lost = arb(0), arb(0)
            for first, sense in self._each:
                rate = first.omega.ball(_BITS) * expression_ball(first.multiple)
                slope += sense * rate
                lost += sense * _beginning(first.ball(_BITS) * rate) + (2 * arb.pi() if sense < 0 else 0)
            if not slope > 0:
                return None
            return Rational(str(float((lost / slope).upper()) * (1 + 1e-9))) + Rational(1, 10**12)

    def come(self, delay: RealNumber) -> int:
        """How many pairs of roots have come to the right less those that have gone, from a delay on up to the next; at least.

        ``delay`` : a number, or one of those at which roots switch sides. What stays open of a number is taken as gone.
        """
        passed = (_passed(x, delay, sense > 0, self._is_of(x, delay)) for x, sense in self._each)
        return sum(sense * n for (_, sense), n in zip(self._each, passed, strict=True))

    @property
    def _each(self) -> list[tuple[DelayAt, int]]:
        return [*zip(self.firsts, self.senses, strict=True)]

    def _is_of(self, first: DelayAt, delay: RealNumber) -> bool:
        """Whether a delay at which roots switch sides belongs to the frequency of the ``first``: to no other, that is."""
        if not isinstance(delay, DelayAt):
            return False
        near = [x for x in self.firsts if x.omega.ball(_BITS).overlaps(delay.omega.ball(_BITS))]
        return near == [first]


def _passed(first: DelayAt, delay: RealNumber, surely: bool, own: bool) -> int:  # noqa: FBT001
    """How many delays of a frequency are not beyond one; ``surely`` : of which that is shown, else of which it may be."""
    if own and isinstance(delay, DelayAt):
        return delay.turn - first.turn + 1
    with flint.ctx.workprec(_BITS):
        rate = first.omega.ball(_BITS) * expression_ball(first.multiple)
        turns = (delay.ball(_BITS) - first.ball(_BITS)) * rate / (2 * arb.pi())
        return max(0, int((turns.lower() if surely else turns.upper()).floor().unique_fmpz()) + 1)


def _first(x: DelayAt) -> DelayAt:
    """Without a turn, or one turn later where that is negative."""
    return replace(x, turn=1) if x.ball(_BITS) < 0 else x


def _beginning(angle: Ball) -> Ball:
    """Of a frequency, the angle > 0 of the first delay that is one; all up to 2 pi where a ball does not tell."""
    return angle if angle > 0 else arb(0).union(2 * arb.pi())


def _rate(x: DelayAt) -> float:
    return float(x.omega) * float(x.multiple)


def _turns(x: DelayAt, end: float) -> int:
    return int(_rate(x) * end / 6.28) + _FURTHER


def _turned(first: DelayAt, turns: int, sense: int | None) -> Iterator[Meeting]:
    """Of one frequency, from its first delay on."""
    for turn in range(turns + 1):
        delay = replace(first, turn=first.turn + turn)
        if delay.ball(_BITS).is_zero():
            yield Meeting(ExactNumber(Integer(0)), first.omega)
        elif float(delay) > 0:
            yield Meeting(delay, first.omega, sense)


def _ratio(loop: Loop) -> tuple[RationalFunction, Expr]:
    """-A/B and how often the open delay is in the exponent."""
    ring, symbol = loop.ring, loop.symbol
    units = [i for i, lag in enumerate(ring.lags) if symbol in lag.free_symbols]
    if len(units) != 1 or any(symbol in x.free_symbols for x in ring.orders):
        raise UndecidedError("a number that is in several delays")
    rows = coefficients(loop.top, ring.size + units[0])
    late = [n for n, row in enumerate(rows) if n and row]
    if len(late) != 1:
        raise UndecidedError("a delay that comes back several times")
    multiple = late[0] * ring.lags[units[0]] / symbol
    if multiple.free_symbols or degree_in([loop.top], ring.meanings.index(symbol)):
        raise UndecidedError("a delay that comes back several times")
    plain = [ring.expression(x) for x in (rows[0], rows[-1])]
    target = Ring.of(plain)
    above, below = map(target.convert, plain)
    return (-above / below).reduced(), multiple


_MOST_TURNING = 400  # radians that a delay turns up to where roots cross either way


@dataclass(frozen=True)
class _Settled:
    """The ``sense`` of the ``rate`` of g's phase beyond a frequency.

    ``curve`` : of the loop. ``known`` : all values with roots on the axis below that frequency, or at infinity.
    """

    sense: int
    rate: RationalFunction
    curve: Curve
    known: tuple[RealNumber, ...]


@dataclass(frozen=True)
class Tendency:
    """Of a loop and its open number."""

    loop: Loop

    def everywhere(self, low: RealNumber | None, high: RealNumber | None) -> bool:
        """Whether each value from one to another is proven to have a root in Re s >= 0; an end that is None is endless."""
        with suppress(UndecidedError):
            return self._of_a_delay(low) if self.loop.turns else self._from_an_end(low, high)
        return False

    def _of_a_delay(self, low: RealNumber | None) -> bool:
        if low is None or not (found := Switches.of(self.loop)).is_still:
            return False
        last = found.unstable_from
        return (last is not None and ordered(ExactNumber(last), low) >= 0) or found.come(low) > 0

    def _from_an_end(self, low: RealNumber | None, high: RealNumber | None) -> bool:
        """From the end on at which roots lie on the right already, if from there on they cross to the right alone."""
        side = 1 if low is not None and float(low) >= 0 else -1 if high is not None and float(high) <= 0 else 0
        if not side or self._settled is None:
            return False
        found = self._settled
        if any(_is_between(x, low, high) for x in found.known):
            return False
        start = low if side * found.sense > 0 else high
        return start is not None and self._has_some_beyond(start, found)

    @cached_property
    def _settled(self) -> _Settled | None:
        """None where the phase goes both ways for ever, or up to a frequency to which delays turn very often."""
        if len(self.loop.powers) != 2 or (curve := curve_of(self.loop)) is None or curve.condition.is_zero:
            return None
        rate = _rate_in_tendency(curve)
        found = far(rate)
        if found.sense not in (Sense.POSITIVE, Sense.NEGATIVE):
            return None
        if any(float(found.radius * lag) > _MOST_TURNING for lag in self.loop.ring.lags):
            return None
        near = curve.meetings(max(found.radius, Integer(1)))
        known = (*Characteristic(self.loop).at_0(), *(x.value for x in (*near, *from_infinity(self.loop))))
        return _Settled(found.sense.value, rate, curve, known)

    def _has_some_beyond(self, start: RealNumber, found: _Settled) -> bool:
        """Whether roots lie on the right beside a value, on the side to which others can only join them."""
        if isinstance(start, ExactNumber) and isinstance(start.value, Rational):
            return bool(self.loop.at(start.value).right)
        if not isinstance(start, ValueAt):
            return False
        with flint.ctx.workprec(ALIKE_BITS):  # those on the axis itself, if it is there that the value puts them
            omega, curve = start.omega.ball(ALIKE_BITS), found.curve
            rate, own, zero = (RealFunction(f).ball(omega) for f in (found.rate, curve.value, curve.condition))
            return bool(own.overlaps(start.ball(ALIKE_BITS)) and zero.contains(0) and found.sense * rate > 0)


def _rate_in_tendency(curve: Curve) -> RationalFunction:
    """Of the phase of g over frequency, times something positive."""
    u, v = curve.value, curve.condition  # g is u - j v, both over the same square
    axis = RealFunction(u).axis
    turned = [axis.derivative(x.numerator) * axis.function(y.numerator) for x, y in ((u, v), (v, u))]
    return turned[0] - turned[1]


def _is_between(x: RealNumber, low: RealNumber | None, high: RealNumber | None) -> bool:
    return (low is None or ordered(low, x) > 0) and (high is None or ordered(x, high) > 0)


_STARTS = 120
_STEPS = 40
_TRIED = 6  # roots, those that lie farthest to the right
_DEEPEST_RIGHTROOT = 5
_FURTHER_RIGHTROOT = 16  # where values without an end are parted


@dataclass(frozen=True)
class _Values:
    """Those of the open number from one to another, in a ball; those without an end have their inverse there."""

    low: RealNumber | None
    high: RealNumber | None
    ball: Ball

    @classmethod
    def of(cls, low: RealNumber | None, high: RealNumber | None) -> _Values | None:
        """None where the end that there is does not keep 0 out."""
        with flint.ctx.workprec(_BITS):
            if low is not None and high is not None:
                return cls(low, high, low.ball(_BITS).union(high.ball(_BITS)))
            end = low if low is not None else high
            if end is None or not end.ball(_BITS) * (1 if low is not None else -1) > 0:
                return None
            return cls(low, high, (1 / end.ball(_BITS)).union(arb(0)))

    @property
    def middle(self) -> Rational:
        """Between both, as many times the lesser as it goes into the larger; without an end some times as far out."""
        ends = [float(x) for x in (self.low, self.high) if x is not None]
        if len(ends) == 1:
            return Rational(ends[0]) * _FURTHER_RIGHTROOT
        low, high = ends
        between = copysign(sqrt(low * high), low) if low * high > 0 else (low + high) / 2
        return Rational(between if low < between < high else (low + high) / 2)

    def of_row(self, row: Sequence[Ball], at: Ball) -> Ball:
        """A polynomial in the open number at a number of the ball."""
        total = 0 * at
        for c in row if self.low is None or self.high is None else reversed(row):
            total = total * at + c
        return total


@dataclass(frozen=True)
class RightRoots:
    """Of a loop whose delays are numbers."""

    loop: Loop

    def everywhere(self, low: RealNumber | None, high: RealNumber | None, depth: int = _DEEPEST_RIGHTROOT) -> bool:
        """Whether each value between two, and these, is proven to have a root in Re s > 0; None is no end."""
        if self.loop.turns or (values := _Values.of(low, high)) is None:
            return False
        if self._at_once(values):
            return True
        middle = ExactNumber(values.middle)
        return bool(depth) and self.everywhere(low, middle, depth - 1) and self.everywhere(middle, high, depth - 1)

    def _at_once(self, values: _Values) -> bool:
        roots = sorted(set(self._guesses(values)), key=lambda s: -s.real)
        with flint.ctx.workprec(_BITS):
            return any(self._stays(s, s.real / part, values) for s in roots[:_TRIED] for part in (2, 8, 32))

    def _stays(self, s: complex, size: float, values: _Values) -> bool:
        box = acb(arb(s.real, size), arb(s.imag, size))
        slope = self._value(box, values)[1]
        if not box.real > 0 or slope.contains(0):
            return False
        after = acb(s.real, s.imag) - self._value(acb(s.real, s.imag), values)[0] / slope
        return bool(box.contains_interior(after))

    def _value(self, s: Ball, values: _Values) -> tuple[Ball, Ball]:
        """C and its derivative, over the highest power of the open number where the values have no end."""
        length = len(self._balls[0][2])
        value, slope = [acb(0)] * length, [acb(0)] * length
        for p, lag, row in self._balls:
            wave = (-s * lag).exp()
            here = s**p * wave
            along = (p * s ** (p - 1) * wave if p else 0) - lag * here
            value = [x + c * here for x, c in zip(value, row, strict=True)]
            slope = [x + c * along for x, c in zip(slope, row, strict=True)]
        return values.of_row(value, values.ball), values.of_row(slope, values.ball)

    @cached_property
    def _balls(self) -> list[tuple[Ball, Ball, list[Ball]]]:
        """Of each term its power of s, its delay and its row; all rows are of one length."""
        longest = max(len(row) for group in self.loop.table.values() for row in group.values())
        with flint.ctx.workprec(_BITS):
            return [
                (
                    expression_ball(p),
                    expression_ball(lag_of(turns, self.loop)),
                    [*map(expression_ball, row)] + [arb(0)] * (longest - len(row)),
                )
                for p, group in self.loop.table.items()
                for turns, row in group.items()
            ]

    def _guesses(self, values: _Values) -> Iterator[complex]:
        """Where Newton's steps in floats end on the right, from starts along the axis."""
        middle = float(values.ball.mid())
        terms = [
            (float(p), float(lag), float(values.of_row([*map(float, row)], middle))) for p, lag, row in self._balls
        ]
        longest = max((lag for _, lag, _ in terms), default=0) or 1.0
        for i in range(_STARTS):
            found = _newton(terms, complex(0.05, 0.5 * (i + 1)) / longest)
            if found is not None and found.real * longest > 1e-9:
                yield complex(*(float(f"{x:.12g}") for x in (found.real, abs(found.imag))))


def _newton(terms: list[tuple[float, float, float]], s: complex) -> complex | None:
    try:
        for _ in range(_STEPS):
            each = [(p, lag, c * s**p * exp(-s * lag)) for p, lag, c in terms if c]
            slope = sum(x * (p / s - lag) for p, lag, x in each)
            step = sum(x for _, _, x in each) / slope
            s -= step
            if abs(step) < 1e-13 * abs(s):
                return s
    except (ZeroDivisionError, OverflowError):
        return None
    return s if isfinite(s.real) and abs(step) < 1e-9 * abs(s) else None
