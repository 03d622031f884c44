"""The characteristic polynomial of a sampled-data loop, exact in its delays, and its roots outside
of the unit circle.

A plant sits between a zero-order hold and a sampler; a discrete controller closes the loop. The
plant G(s) = sum over i of exp(-s tau_i) N_i(s)/Q(s) is proper. It is driven by a force held for T
at a time, and read the moment before the force changes. In w = 1/z its samples are w^l (w F_1(w) +
w^2 F_2(w))/|1 - w exp(A T)|, with A the companion matrix of Q and tau = l T + theta: F_1 belongs to
the force held last, F_2 to the one before, which a delay that is no whole sample lets in (the
modified z-transform). The loop is 1 + D G = 0, a polynomial C(w) (``SampledLoop``).

Fast clocks put all roots of the loop near z = 1. There exp(A T) - 1 = A int_0^T exp(A t) dt has
balls as narrow, relatively, as those of the numbers that it is made of; the coefficients of z^n
have not. So polynomials are written in z - 1, and then in v, z = (1 + v)/(1 - v): roots with |z| <
1 are those with Re v < 0, Routh's array counts the others, and Hurwitz' determinants show where one
leaves. Counts and statements are proven, in balls; where these stay open at a limit of bits the
answer is None, or an UndecidedError.

A *ball* is an interval of any precision, middle and radius (``arb`` of FLINT; complex: ``acb``); it
is *clear of* a number that it does not contain. Begin with ``SampledLoop.unstable`` for a count,
with ``circle_tests`` for where a root reaches the circle, and with ``_moved`` for the pulse
transfer function.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import comb, frexp
from types import MappingProxyType
from typing import Any, TypeAlias

import flint
from flint import acb, acb_mat, acb_poly, arb, arb_mat, arb_poly, fmpq
from sympy import Add, Expr, Integer, Symbol

from haptisym.kernel.enclosures import LinearEnclosure, over_ellipse
from haptisym.kernel.errors import SceneError, UndecidedError
from haptisym.kernel.reals import Ball, at_rising_precision, expression_ball
from haptisym.kernel.rootcount import routh

Numbers: TypeAlias = Sequence[Expr]
"""Coefficients, ascending: rational numbers times powers of pi, and sums of such."""

_MOST_DOUBLINGS = 64  # of X/2^n in ``States.integral``: beyond it nothing is known of the plant
_MOST_BITS = 2048  # of working precision, up to which a root is distinguished from the circle
_MOST_PIECES = 200  # intervals of the axis examined for one polynomial (``has_no_pair``)


def matrix(rows: list[list[Any]], columns: int | None = None) -> Any:
    """A matrix of real or complex balls, which may have no rows or columns."""
    width = len(rows) if columns is None else columns
    entries = [x for row in rows for x in row] if width else []
    kind = acb_mat if _are_complex(entries) else arb_mat
    return kind(len(rows), width, entries)


@lru_cache(maxsize=64)
def _identity(n: int) -> Any:
    return matrix([[arb(int(i == j)) for j in range(n)] for i in range(n)])


def _polynomial(row: Sequence[Any]) -> Any:
    """A polynomial with these coefficients, ascending, in real or complex balls."""
    kind = acb_poly if _are_complex(row) else arb_poly
    return kind(row)


def _are_complex(numbers: Iterable[Any]) -> bool:
    """Whether any of these balls is complex."""
    return acb in map(type, numbers)


@dataclass(frozen=True)
class States:
    """The companion form of a monic denominator Q(s), coefficients ascending, in balls.

    The i-th state is the i-th derivative times rate^(n - 1 - i). That gives the entries of A about
    one size; the truncation error of a matrix exponential, which is one bound for all of its
    entries, then is small against each of them.
    """

    Q: Sequence[Ball]

    @property
    def size(self) -> int:
        """The number of states: the degree of Q."""
        return len(self.Q) - 1

    @cached_property
    def rate(self) -> Ball:
        """About how fast the plant is, 1/s."""
        # The largest |q_i|^(1/(n - i)) bounds the roots of Q up to a factor 2. Only a scale: its
        # middle is as good as any number near it, so that it adds no radius.
        n = self.size
        sizes = []
        for i, q in enumerate(self.Q[:n]):
            size = float(abs(q).mid())
            sizes.append(size ** (1 / (n - i)))
        return arb(max([*sizes, 1.0]))

    @cached_property
    def A(self) -> Any:
        """The companion matrix of Q, its states scaled by the rate."""
        n = self.size
        rate = self.rate
        rows = [[rate * int(j == i + 1) for j in range(n)] for i in range(n - 1)]
        if n:
            rows.append([-x for x in self._scaled(self.Q[:n])])
        return matrix(rows)

    @cached_property
    def size_of_A(self) -> Ball:
        """The infinity norm of A, the largest sum of absolute values in a row."""
        if not self.size:
            return arb(0)
        last = sum((abs(self.A[self.size - 1, j]).upper() for j in range(self.size)), arb(0))
        return last if self.size == 1 else max(last, self.rate)

    def _scaled(self, row: Sequence[Ball]) -> list[Ball]:
        """Coefficients of y, y', ... as those of the states."""
        n = self.size
        return [x / self.rate ** (n - 1 - i) for i, x in enumerate(row)]

    def row(self, C: Sequence[Ball]) -> Any:
        """The row vector that gives c_0 y + c_1 y' + ... from the states."""
        return matrix([self._scaled(C)], self.size)

    def integral(self, time: Ball) -> Any:
        """int_0^time exp(A t) dt = time S(A time), S(X) = 1 + X/2! + X^2/3! + ...: the series at
        X/2^n, then n doublings.

        As S(2 X) = S(X) + X S(X)^2/2, numbers that are nearly equal are nowhere subtracted. Not a
        number where the plant is so fast that too many doublings were needed.
        """
        X = self.A * time
        one = total = _identity(self.size)
        # frexp gives e with |X| < 2^e.
        _, exponent = frexp(float((self.size_of_A * abs(time)).upper()))
        doublings = max(0, exponent + 2)  # then |X| <= 1/4
        if doublings > _MOST_DOUBLINGS:
            return total * arb("nan")
        X = X * arb(2) ** -doublings
        rest, blocks = _series(flint.ctx.prec)
        # Horner's rule in X^4, with polynomials of degree 3 as its coefficients.
        square = X * X
        cube, fourth = square * X, square * square
        total = one * arb(0)
        for a, b, c, d in blocks:
            total = fourth * total + (one * a + X * b + square * c + cube * d)
        # With Q = s^n, masses alone, A^n = 0: the series ends, nothing is left out of it.
        if not all(q.is_zero() for q in self.Q[:-1]):
            total = widened(total, rest)
        for _ in range(doublings):
            total = total + X * total * total * arb(0.5)
            X = X * 2
        return total * time


@lru_cache(maxsize=16)
def _series(bits: int) -> tuple[Ball, list[list[Ball]]]:
    """For the series S of ``States.integral`` with |X| <= 1/4: a bound of the sum of all terms that
    are left out, and its coefficients 1/(n + 1)! in fours, ascending in each, the last four
    first."""
    with flint.ctx.workprec(bits):
        rest = arb(1)
        k = 1
        # 4^(1 - k)/k!, more than all terms from X^k/(k + 1)! on; below the rounding in the end.
        while rest > arb(2) ** -(bits + 8) or k % 4:
            k += 1
            rest = rest / (4 * k)
        shares = [1 / arb(n + 1).fac() for n in range(k)]
        return rest, [shares[n : n + 4] for n in range(k - 4, -1, -4)]


def column(M: Any, j: int) -> Any:
    """The j-th column of a matrix, as a matrix."""
    return matrix([[M[i, j]] for i in range(M.nrows())], 1)


def widened(M: Any, radius: Ball) -> Any:
    """A matrix with balls wider by ``radius``, in both parts where they are complex."""
    more = arb(0, radius.upper())
    more = acb(more, more) if isinstance(M, acb_mat) else more
    rows, columns = M.nrows(), M.ncols()
    return M + type(M)(rows, columns, [more] * (rows * columns))


def opposite_response(states: States, C: Any, period: Ball) -> Ball | None:
    """The output C x just before the force changes, of a force that changes its sign each period:
    the pulse transfer function at z = -1.

    C tanh(X)/A e, X = A T/2, is T/2 C e + T/2 C (tanh(X)/X - 1) e, by Taylor's series: where the
    plant is slow compared with the clock little of it is left, and numbers that are nearly equal
    are not subtracted. None where |X| is too large for the series.
    """
    n = states.size
    X = states.A * (period / 2)
    # The series converges for |X| < pi/2; up to half of that each term is at most 1/4 of the one
    # before it.
    if not 2 * states.size_of_A * abs(period) < arb.pi():
        return None
    if not n:
        return arb(0) * period / 2
    # e is the last unit vector: the force acts on the last state alone.
    power = matrix([[arb(int(i == n - 1))] for i in range(n)], 1)
    total = matrix([[arb(0)] for _ in range(n)], 1)
    shares, after = _tanh_balls(flint.ctx.prec)
    for share in shares:
        power = X * (X * power)
        total += power * share
    largest = max(abs(power[i, 0]).upper() for i in range(n))
    total = widened(total, largest * after)
    direct = C[0, n - 1]
    later = C * total
    return (direct + later[0, 0]) * period / 2


def _tanh(count: int) -> list[fmpq]:
    """The first coefficients of tanh(x)/x in powers of x^2, from tanh' = 1 - tanh^2."""
    row = [fmpq(1)]
    for k in range(1, count):
        of_square = fmpq(0)
        for x, y in zip(row, reversed(row), strict=True):
            of_square += x * y
        row.append(-of_square / (2 * k + 1))
    return row


_TANH = _tanh(16)
"""Each at most (4/pi^2)^k large: tanh(x)/x is the sum of 8/((2 j - 1)^2 pi^2 + 4 x^2)."""


@lru_cache(maxsize=16)
def _tanh_balls(bits: int) -> tuple[list[Ball], Ball]:
    """The coefficients of tanh(x)/x after the first; and a bound of what all that are left out add,
    relative to the last power."""
    with flint.ctx.workprec(bits):
        # A geometric series: coefficients fall by 4/pi^2, X^2 by (pi/4)^2, so that all terms left
        # out add up to at most 1/4 + 1/16 + ... = 1/3 of that of the last one.
        last_coefficient = (4 / arb.pi() ** 2) ** (len(_TANH) - 1)
        return [arb(x) for x in _TANH[1:]], last_coefficient / 3


@dataclass(frozen=True)
class Plant:
    """G(s) = sum of exp(-s tau) N(s)/Q(s): the coefficients of Q, ascending, and for each delay (in
    seconds) those of N; proper, or a SceneError.
    """

    denominator: tuple[Expr, ...]
    terms: tuple[tuple[Expr, tuple[Expr, ...]], ...]

    def __post_init__(self) -> None:
        if any(len(above) > len(self.denominator) for _, above in self.terms):
            raise SceneError("a force that jumps would move the sampled position by an impulse")

    def samples(self, period: Expr, known: Mapping[Expr, Ball]) -> tuple[int, ...]:
        """The number of whole sampling periods in each delay."""
        return tuple(_floor(x, known) for x in _ratios(self, period))


@lru_cache(maxsize=64)
def _ratios(plant: Plant, period: Expr) -> list[Expr]:
    """The delays of a plant, in sampling periods."""
    return [lag / period for lag, _ in plant.terms]


@lru_cache(maxsize=64)
def _rests(plant: Plant, period: Expr, whole: tuple[int, ...]) -> list[Expr]:
    """What of its delays is left beyond whole sampling periods."""
    return [lag - ell * period for (lag, _), ell in zip(plant.terms, whole, strict=True)]


@dataclass(frozen=True)
class Timed(Plant):
    """A plant with open parameters in its delays, each of which is known to hold ``whole`` sampling
    periods and a part of one more (or all of it), for all values that are asked about."""

    whole: tuple[int, ...] = ()

    def samples(self, period: Expr, known: Mapping[Expr, Ball]) -> tuple[int, ...]:
        return self.whole


def _floor(ratio: Expr, known: Mapping[Expr, Ball]) -> int:
    """The whole part of a number; UndecidedError where balls do not show on which side of a whole
    number it lies."""

    def whole(_: int) -> int | None:
        # A parameter may be a disc (``over_circle``): the real part then covers all within it.
        part = acb(expression_ball(ratio, known)).real.floor().unique_fmpz()
        return None if part is None else int(part)

    if ratio.is_Rational:
        return int(ratio.p // ratio.q)
    part = at_rising_precision(whole)
    if part is None:
        raise UndecidedError("whether a delay is a whole number of samples")
    return part


@dataclass(frozen=True)
class SampledLoop:
    """The loop of a sampled plant G and a controller D(w) = above/below, w = 1/z, with the period
    T, s: 1 + D G = 0, as a polynomial C(w).

    >>> from sympy import Integer, Rational
    >>> half = Rational(1, 2)
    >>> plant = Plant((Integer(0), Integer(1)), ((Integer(0), (Integer(1),)),))            # 1/s, T = 1
    >>> loop = SampledLoop(plant, Integer(1), (half,), (Integer(1),))
    >>> loop.balls()                                                                       # 1 - w + w/2
    [1.00000000000000, -0.500000000000000]
    >>> loop.unstable()
    (0, 0)
    """

    plant: Plant
    T: Expr
    above: tuple[Expr, ...]
    below: tuple[Expr, ...]

    def at(self, values: Mapping[Symbol, Expr]) -> SampledLoop:
        """The loop with numbers in place of symbols; common factors are not cancelled."""

        def put(row: Numbers) -> tuple[Expr, ...]:
            # A highest coefficient may become 0: degrees must be those of the numbers.
            known = [x.xreplace(values) for x in row]
            while len(known) > 1 and known[-1] == 0:
                known.pop()
            return tuple(known)

        terms = tuple((lag.xreplace(values), put(N)) for lag, N in self.plant.terms)
        return SampledLoop(
            plant=Plant(put(self.plant.denominator), terms),
            T=self.T.xreplace(values),
            above=put(self.above),
            below=put(self.below),
        )

    @property
    def _of_plant(self) -> list[Expr]:
        """All numbers of the plant, and the period."""
        numbers = [self.T, *self.plant.denominator]
        for lag, N in self.plant.terms:
            numbers += lag, *N
        return numbers

    @cached_property
    def symbols(self) -> frozenset[Symbol]:
        """The symbols that are left in it."""
        numbers = [*self._of_plant, *self.above, *self.below]
        return frozenset[Symbol]().union(*(x.free_symbols for x in numbers))

    def unstable(self) -> tuple[int, int]:
        """How many roots have |z| > 1, and how many lie at z = 1; UndecidedError where any other
        may lie on the circle."""
        at_1 = self.roots_at_one
        count = lambda _: _count_right(self.in_v({}, at_1))  # noqa: E731
        outside = at_rising_precision(count, 128, _MOST_BITS)
        if outside is None:
            raise UndecidedError("whether a root lies on the unit circle")
        return outside, at_1

    @cached_property
    def roots_at_one(self) -> int:
        """How many roots of a loop of numbers lie at z = 1; UndecidedError where that may be more
        than one in a loop that is closed."""
        if self.at_one != 0:
            return 0
        # An open loop has the plant's poles: those at s = 0 go to z = 1, and their number is exact.
        moves = any(any(N) for _, N in self.plant.terms)
        is_closed = any(self.above) and moves
        if not is_closed:
            return next(n for n, x in enumerate(self.plant.denominator) if x != 0)
        # C(1) = 0 exactly; the root is a simple one where the next coefficient is clear of 0.
        with flint.ctx.workprec(256):
            if self.about_one({})[1].contains(0):
                raise UndecidedError("how many roots of a sampled loop lie at z = 1")
        return 1

    @cached_property
    def at_one(self) -> Expr:
        """B(1) Q(0) + A(1) N(0), with A = above and B = below: C(1) up to a factor that is nowhere
        0. Exact, so that a root at z = 1 is recognised."""
        Q = self.plant.denominator[0]
        N = Add(*(above[0] for _, above in self.plant.terms))
        at_1 = Add(*self.below) * Q + Add(*self.above) * N
        return at_1.expand()

    @cached_property
    def at_minus_one(self) -> tuple[Expr, Expr]:
        """A(-1) and B(-1), exact: the factors of N(-1) and Q(-1) in C at z = -1."""
        size = self._size

        def value(row: Numbers) -> Expr:
            # z^size times the polynomial in w = 1/z.
            terms = [x * (-1) ** (size - k) for k, x in enumerate(row)]
            return Add(*terms).expand()

        return value(self.above), value(self.below)

    @property
    def _size(self) -> int:
        """The degree of the controller: the larger of those of its numerator and denominator."""
        return max(len(self.above), len(self.below)) - 1

    def balls(self, known: Mapping[Expr, Ball] = MappingProxyType({})) -> list[Ball]:
        """The coefficients of C in w, ascending, at the current working precision; ``known`` : what
        symbols stand for."""
        n = len(self.plant.denominator) - 1
        degree = len(self.below) - 1
        if any(self.above):
            whole = self.plant.samples(self.T, known)
            shifts = []
            for (lag, N), ell in zip(self.plant.terms, whole, strict=True):
                theta = (lag - ell * self.T).expand()
                is_later = len(N) > n or theta != 0
                shifts.append(ell + int(is_later))
            degree = max(degree, len(self.above) - 1 + max(shifts))
        about_1 = arb_poly(self.about_one(known))
        in_z = about_1(arb_poly([-1, 1])).coeffs()
        in_w = in_z[::-1]
        # Without the roots at z = 0 that ``about_one`` may have added.
        return list(in_w[: degree + n + 1])

    def about_one(self, known: Mapping[Expr, Ball]) -> list[Ball]:
        """The coefficients of z^N C(1/z) in z - 1, ascending; roots at z = 0 may be added."""
        return self._row(self._moved(known), known)

    def _row(self, moved: _Moved, known: Mapping[Expr, Ball]) -> list[Ball]:
        """The coefficients of the sum of both sides, in z - 1."""
        above, below = self._both(moved, known)
        return list((above + below).coeffs())

    def _both(self, moved: _Moved, known: Mapping[Expr, Ball]) -> tuple[Any, Any]:
        """A N and B Q, polynomials in z - 1."""

        def in_balls(row: tuple[Expr, ...]) -> Any:
            return _polynomial([_ball(x, known) for x in _shifted(row, self._size)])

        above, below = in_balls(self.above), in_balls(self.below)
        return above * moved.above, below * moved.below

    def sides(self, known: Mapping[Expr, Ball]) -> tuple[Any, Any]:
        """The two summands of C, polynomials in z - 1: the part that the controller brings, and the
        part that is left without it."""
        return self._both(self._moved(known), known)

    def in_v(self, known: Mapping[Expr, Ball], always: int = 0) -> list[Ball]:
        """The coefficients of C in v, ascending, with ``always`` roots at z = 1 divided out.

        The highest one is C at z = -1, and is computed there by itself: with Tustin's rule the
        controller has a pole at z = -1, and nearly all of the sum would cancel.
        """
        moved = self._moved(known)
        c = about_axis(self._row(moved, known)[always:])
        above, below = (_ball(x, known) for x in self.at_minus_one)
        there = below * moved.below(arb(-2)) + above * moved.opposite
        there = there / (-2) ** always
        n = len(c) - 1
        # The highest power of v in (1 - v)^n C is (-1)^n C(z = -1) v^n.
        return [*c[:-1], -there if n % 2 else there]

    @cached_property
    def _is_of_numbers(self) -> bool:
        """Whether plant and period hold no symbols, so that only the controller may vary."""
        return not any(x.free_symbols for x in self._of_plant)

    def _moved(self, known: Mapping[Expr, Ball]) -> _Moved:
        """The pulse transfer function of the plant, from the cache where it does not vary."""
        if self._is_of_numbers:
            return _of_numbers(self.plant, self.T, flint.ctx.prec)
        return _moved(self.plant, self.T, known)


def _count_right(c: Sequence[Ball]) -> int | None:
    """How many roots of a polynomial have Re v > 0, given that none is on the axis; None where
    balls do not decide.

    Routh's array is tried first. A zero in it that does not come of two roots that add up to 0
    mostly goes with a further root at -7/5; where two do add up to 0, the roots themselves are
    computed.
    """
    # Times v + 7/5: the root is on the left, and leaves the count as it is.
    neighbours = zip([*c, arb(0)], [arb(0), *c], strict=True)
    further = [7 * x / 5 + y for x, y in neighbours]
    for row in (c, further):
        count = routh(row)
        if count is not None:
            return count
    if c[-1].contains(0):
        return None
    try:
        sides = [v.real for v in acb_poly(c).roots()]
    except ValueError:
        return None
    if any(x.contains(0) for x in sides):
        return None
    return sum(bool(x > 0) for x in sides)


def about_axis(row: Sequence[Ball]) -> list[Ball]:
    """The coefficients in v, ascending, of (1 - v)^n p(z - 1), where z - 1 = 2 v/(1 - v) and n is
    the degree of p."""
    c: list[Ball] = (_turned(len(row) - 1) * matrix([[x] for x in row], 1)).entries()
    return c


def hurwitz(c: Sequence[Ball]) -> Ball:
    """The last but one of Hurwitz' determinants: 0 where two roots v add up to 0 (Orlando's
    formula), among them a pair on the axis."""
    return matrix(hurwitz_rows(c)).det() if len(c) > 2 else arb(1)


def hurwitz_rows(c: Sequence[Ball]) -> list[list[Ball]]:
    """The rows of Hurwitz' matrix of order n - 1, of a polynomial of degree n with ascending
    coefficients; none for n < 2."""
    padded = [*c[::-1], arb(0)]
    return [[padded[k] for k in row] for row in _hurwitz_places(len(c) - 1)]


@lru_cache(maxsize=64)
def _hurwitz_places(n: int) -> list[list[int]]:
    """Which coefficient stands where in Hurwitz' matrix of order n - 1, the highest one being
    number 0; n + 1 is none."""
    rows = []
    for i in range(1, n):
        places = [2 * j - i for j in range(1, n)]
        rows.append([k if 0 <= k <= n else n + 1 for k in places])
    return rows


def has_no_pair(c: Sequence[Ball], lines: Sequence[LinearEnclosure] = ()) -> bool:
    """Whether it is proven that no polynomial with coefficients in these balls has roots v = +-j
    nu, nu > 0. False proves nothing.

    A pair would be a common zero x = nu^2 of E = c_0 - c_2 x + c_4 x^2 - ... and O = c_1 - c_3 x +
    ...; intervals of x are cut until one of both is clear of 0 on each. In wide balls that shows
    more than the determinant, in which their widths are multiplied.
    ``lines`` : how the coefficients move together with a parameter y. With E = E_0 + E_1 y and O
    likewise, E_1 O_0 - O_1 E_0 would be zero as well, in which y does not occur.
    """
    if len(c) < 3:
        return True
    if not all(x.is_finite() for x in c):
        return False
    halves = _halves(c)
    if lines:
        E_0, O_0 = map(arb_poly, _halves([y.at for y in lines]))
        E_1, O_1 = map(arb_poly, _halves([y.slope for y in lines]))
        halves.append((E_1 * O_0 - O_1 * E_0).coeffs())
    # In x over [0, 1] and, with the coefficients reversed, in 1/x over [0, 1]: all of x >= 0.
    in_x = [arb_poly(row) for row in halves]
    in_inverse = [arb_poly(row[::-1]) for row in halves]
    waiting = deque([(in_x, 0.0, 1.0), (in_inverse, 0.0, 1.0)])
    for _ in range(_MOST_PIECES):
        if not waiting:
            return True
        parts, low, high = waiting.popleft()
        at = arb(low).union(arb(high))
        if not all(p(at).contains(0) for p in parts):
            continue
        middle = (low + high) / 2
        if all(p(arb(middle)).contains(0) for p in parts):
            return False  # open at a single place, it stays so however small the interval is
        waiting.append((parts, low, middle))
        waiting.append((parts, middle, high))
    return not waiting


def _halves(c: Sequence[Ball]) -> list[list[Ball]]:
    """The coefficients in x of the even part E and the odd part O of a polynomial on v = j nu."""
    even, odd = c[::2], c[1::2]
    return [[x * (-1) ** i for i, x in enumerate(half)] for half in (even, odd)]


def circle_tests(
    loop: SampledLoop, known: Mapping[Expr, Ball], one: Expr, always: int = 0
) -> tuple[Ball, Ball, Ball]:
    """Three numbers, for roots at z = 1, at z = -1 and for pairs: one of them is 0 wherever a root
    is on the unit circle.

    ``one`` : the loop's ``at_one``; ``always`` : how many roots lie at z = 1 whatever the numbers
    are, which do not count.
    """
    c = loop.in_v(known, always)
    at_1 = c[0] if always else expression_ball(one, known)
    return at_1, c[-1], hurwitz(c)


def is_clear(loop: SampledLoop, known: Mapping[Expr, Ball], one: Expr, always: int = 0) -> bool:
    """Whether it is proven that no root is on the circle for any numbers in the balls ``known``."""
    return most_on_circle(loop, known, one, always) == 0


def most_on_circle(
    loop: SampledLoop, known: Mapping[Expr, Ball], one: Expr, always: int = 0
) -> int | None:
    """A proven bound of the number of values in a ball at which each of the ``circle_tests`` is 0:
    0 or 1; None where neither is proven.

    With 0 no root is on the circle for any value. Where one parameter varies, tests and
    coefficients are enclosed by interpolation, too: with a resonance between
    clock and hand, as behind a compliance, balls are up to a thousand times as wide as the range of
    the coefficients. A test whose derivative has one sign all over is 0 at most once.
    """

    def told(numbers: Mapping[Expr, Any]) -> list[Any]:
        """C at z = 1, and the coefficients in v/T, fewer of which change where the period T is the
        parameter."""
        T = expression_ball(loop.T, numbers)
        c = loop.in_v(numbers, always)
        at_1 = c[0] if always else expression_ball(one, numbers)
        return [at_1, *(x * T**i for i, x in enumerate(c))]

    def tested(numbers: Mapping[Expr, Any]) -> list[Any]:
        tests = told(numbers)
        return [hurwitz(tests[1:]), *tests]

    if _is_clear(told(known)):
        return 0
    if len(known) > 1:
        return None
    [(symbol, q)] = known.items()
    pair, *lines = over_ellipse(lambda x: tested({symbol: x}), q.mid(), q.rad())
    at_1, *c = lines
    ends = at_1, c[-1]
    if not all(x.ball.is_finite() for x in lines):
        return None
    is_pair_open = pair.ball.contains(0) and not has_no_pair([x.ball for x in c], c)
    is_end_open = any(x.ball.contains(0) for x in ends)
    if not is_pair_open and not is_end_open:
        return 0
    # Each test is clear of 0, or monotone in the parameter.
    for test in (*ends, pair):
        if test.ball.contains(0) and test.rate.contains(0):
            return None
    return 1


def _is_clear(told: Sequence[Ball]) -> bool:
    """Whether no root is on the circle, from C at z = 1 and the coefficients in v, the last of
    which is C at z = -1 up to its sign."""
    at_1, *c = told
    for end in (at_1, c[-1]):
        if end.contains(0) or not end.is_finite():
            return False
    return not hurwitz(c).contains(0) or has_no_pair(c)


@dataclass(frozen=True)
class _Moved:
    """A pulse transfer function ``above``/``below``, polynomials in z - 1, and the value
    ``opposite`` of ``above`` at z = -1, which is computed there by itself."""

    above: Any
    below: Any
    opposite: Ball


@lru_cache(maxsize=64)
def _of_numbers(plant: Plant, period: Expr, bits: int) -> _Moved:
    """The pulse transfer function of a plant without symbols, at the working precision ``bits``:
    one matrix exponential serves all values of a controller."""
    assert bits == flint.ctx.prec
    return _moved(plant, period, {})


def _ball(x: Expr, known: Mapping[Expr, Ball]) -> Ball:
    """``expression_ball``, from the cache where no symbol is in it."""
    number = _number_ball(x, flint.ctx.prec)
    return expression_ball(x, known) if number is None else number


@lru_cache(maxsize=512)
def _number_ball(x: Expr, bits: int) -> Ball | None:
    """A ball around a number at the working precision ``bits``; None of what holds symbols."""
    # A key of the cache, no choice: ``_ball`` alone calls this, with the precision of FLINT, at
    # which ``expression_ball`` computes.
    assert bits == flint.ctx.prec
    return None if x.free_symbols else expression_ball(x)


def _moved(plant: Plant, period: Expr, known: Mapping[Expr, Ball]) -> _Moved:
    """The pulse transfer function of a plant where symbols have the values ``known``."""
    whole = plant.samples(period, known)
    T = _ball(period, known)
    *_, lead = row = [_ball(x, known) for x in plant.denominator]
    Q = [x / lead for x in row]
    n = len(Q) - 1
    states = States(Q)
    integral = states.integral(T)
    held = column(integral, n - 1)
    # M = exp(A T) - 1, without the subtraction; |z - exp(A T)| is |x - M| at x = z - 1.
    M = states.A * integral
    den, adjugate = _leverrier(M)
    den_opposite = den(arb(-2))
    total = arb_poly([])
    opposite = arb(0)
    longest = max(whole) + 1
    rests = _rests(plant, period, whole)
    for (_, above), ell, rest in zip(plant.terms, whole, rests, strict=True):
        N = [_ball(x, known) / lead for x in above]
        N += [arb(0)] * (n + 1 - len(N))
        direct = N[n]
        # N/Q = N_n + C (s - A)^-1 e: the direct term apart, the rest is strictly proper.
        proper = [x - direct * q for x, q in zip(N, Q, strict=True)]
        C = states.row(proper[:n])
        theta = _ball(rest, known)
        by_series = None
        if theta.is_zero():
            # A delay of whole samples only shifts.
            response = _power(1) * _between(C, adjugate, held) + direct * den
            by_series = opposite_response(states, C, T)
        else:
            # A broken part theta of a delay splits each period: for T - theta the new force acts,
            # for theta still the one before.
            early = states.integral(T - theta)
            newer = column(early, n - 1)
            older = column(states.integral(theta), n - 1)
            response = _power(1) * _between(C, adjugate, newer) + direct * den
            # exp(A (T - theta)) = 1 + A early carries what the older force did on to the sample.
            response += _between(C, adjugate, older + states.A * (early * older))
        shift = longest - 1 - ell
        total += response * _power(shift)
        # At z = -1 the narrower of two balls counts: the polynomial's, and that of the series,
        # which is as narrow as its numbers, but no narrower than the terms it leaves out.
        values = [response(arb(-2))]
        if by_series is not None:
            values.append((by_series + direct) * den_opposite)
        narrowest = min(values, key=lambda x: float(x.rad()))
        opposite += (-1) ** shift * narrowest
    return _Moved(total, den * _power(longest), opposite)


def _leverrier(M: Any) -> tuple[Any, list[Any]]:
    """|x - M|, and the matrix coefficients of adj(x - M), ascending in x (the Faddeev-LeVerrier
    algorithm)."""
    n = M.nrows()
    one = N = _identity(n)
    row = [arb(1)]
    adjugate = [one] if n else []
    for k in range(1, n + 1):
        moved = N * M
        c = -moved.trace() / k
        row.append(c)
        N = moved + one * c
        if k < n:
            adjugate.append(N)
    return _polynomial(row[::-1]), adjugate[::-1]


def _between(C: Any, adjugate: list[Any], start: Any) -> Any:
    """C adj(x - M) start, a polynomial in x."""
    products = [C * N * start for N in adjugate]
    return _polynomial([x[0, 0] for x in products])


@lru_cache(maxsize=64)
def _turned(n: int) -> Any:
    """The matrix whose columns are the coefficients in v of (z - 1)^k (1 - v)^n = (2 v)^k (1 -
    v)^(n - k), k = 0, ..., n."""
    rows = []
    for power in range(n + 1):
        of_powers = [(k, power - k) for k in range(n + 1)]
        rows.append(
            [arb(2**k * (-1) ** i * comb(n - k, i)) if i >= 0 else arb(0) for k, i in of_powers]
        )
    return arb_mat(rows)


@lru_cache(maxsize=64)
def _power(k: int) -> Any:
    """z^k as a polynomial in z - 1."""
    return arb_poly([comb(k, i) for i in range(k + 1)])


@lru_cache(maxsize=64)
def _shifted(row: tuple[Expr, ...], size: int) -> tuple[Expr, ...]:
    """The coefficients in z - 1 of z^size times a polynomial in 1/z: exact, so that what cancels
    leaves nothing behind."""
    sums = [Integer(0)] * (size + 1)
    for k, x in enumerate(row):
        for i in range(size - k + 1):
            sums[i] += x * comb(size - k, i)
    return tuple(x.expand() for x in sums)
