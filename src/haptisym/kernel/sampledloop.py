"""A plant between a hold and a sampler, and the loop with a clock that is closed over them: its
polynomial, and its roots.

The plant G(s) = sum over i of exp(-s tau_i) N_i(s)/Q(s) is proper. It is driven by a force held for
T at a time, and read the moment before the force changes. In w = 1/z its samples are w^l (w F_1(w)
+ w^2 F_2(w))/|1 - w exp(A T)|, with A the companion matrix of Q and tau = l T + theta: F_1 belongs
to the force held last, F_2 to the one before, which a delay that is no whole sample lets in (the
modified z-transform).

Fast clocks put all roots of the loop near z = 1. There exp(A T) - 1 = A int_0^T exp(A t) dt has
balls as narrow, relatively, as those of the numbers that it is made of; the coefficients of z^n
have not. So polynomials are written in z - 1, and then in v, z = (1 + v)/(1 - v): roots with |z| <
1 are those with Re v < 0, Routh's array counts the others, and Hurwitz' determinants say where one
leaves.
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

from haptisym.kernel.enclosures import LinearEnclosure, over_circle
from haptisym.kernel.errors import SceneError, UndecidedError
from haptisym.kernel.reals import Ball, at_rising_precision, expression_ball
from haptisym.kernel.rootcount import routh

Numbers: TypeAlias = Sequence[Expr]
"""Coefficients, ascending: rational numbers times powers of pi, and sums of such."""

_MOST_DOUBLINGS = 64
_MOST_BITS = 2048  # up to where a root is told from the circle
_MOST_PIECES = 200  # of the axis, that are looked at for one polynomial


def matrix(rows: list[list[Any]], columns: int | None = None) -> Any:
    """A matrix of real or complex balls, which may be of no size."""
    width = len(rows) if columns is None else columns
    entries = [x for row in rows for x in row] if width else []
    return (acb_mat if _are_complex(entries) else arb_mat)(len(rows), width, entries)


def _polynomial(row: Sequence[Any]) -> Any:
    """By its coefficients, ascending, in real or complex balls."""
    return (acb_poly if _are_complex(row) else arb_poly)(row)


def _are_complex(numbers: Iterable[Any]) -> bool:
    return any(isinstance(x, acb) for x in numbers)


@dataclass(frozen=True)
class States:
    """The companion form of a monic denominator Q(s), coefficients ascending, in balls.

    The i-th state is the i-th derivative times rate^(n - 1 - i): with entries of one size a matrix
    exponential, whose error is one for all of its entries, stays narrow where the numbers it is
    made of are.
    """

    Q: Sequence[Ball]

    @property
    def size(self) -> int:
        """How many states there are: the degree of Q."""
        return len(self.Q) - 1

    @cached_property
    def rate(self) -> Ball:
        """About how fast the plant is, 1/s."""
        n = self.size
        sizes = [float(abs(q).mid()) ** (1 / (n - i)) for i, q in enumerate(self.Q[:n])]
        return arb(max([*sizes, 1.0]))

    @cached_property
    def A(self) -> Any:
        """The companion matrix of Q, its states scaled by the rate."""
        n, rate = self.size, self.rate
        last = [-q / rate ** (n - 1 - j) for j, q in enumerate(self.Q[:n])]
        return matrix(
            [[rate * int(j == i + 1) for j in range(n)] for i in range(n - 1)]
            + ([last] if n else [])
        )

    def row(self, C: Sequence[Ball]) -> Any:
        """What reads c_0 y + c_1 y' + ... off the states."""
        n = self.size
        return matrix([[c / self.rate ** (n - 1 - j) for j, c in enumerate(C)]], n)

    def integral(self, time: Ball) -> Any:
        """int_0^time exp(A t) dt = time S(A time), S(X) = 1 + X/2! + X^2/3! + ...: by its series of
        a small X, which is doubled.

        As S(2 X) = S(X) + X S(X)^2/2, nothing is taken off what is nearly equal to it.
        """
        X, total = self.A * time, self._one
        doublings = max(0, frexp(float(norm(X).upper()))[1] + 2)  # then |X| <= 1/4
        if doublings > _MOST_DOUBLINGS:
            return total * arb("nan")
        X, (rest, shares) = X * arb(2) ** -doublings, _series(flint.ctx.prec)
        for share in shares:
            total = self._one + X * total * share
        if not all(
            q.is_zero() for q in self.Q[:-1]
        ):  # of masses alone nothing is left out, as no higher power is there
            total = widened(total, rest)
        for _ in range(doublings):
            total, X = total + X * total * total * arb(0.5), X * 2
        return total * time

    @cached_property
    def _one(self) -> Any:
        return matrix([[arb(int(i == j)) for j in range(self.size)] for i in range(self.size)])


@lru_cache(maxsize=16)
def _series(bits: int) -> tuple[Ball, list[Ball]]:
    """What terms that are left out of the series add up to at most, of |X| <= 1/4, and 1/n from its
    last term down to 1/2."""
    with flint.ctx.workprec(bits):
        rest, k = arb(1), 1
        while rest > arb(2) ** -(bits + 8):
            k, rest = (
                k + 1,
                rest / (4 * (k + 1)),
            )  # 4^(1 - k)/k!, more than the terms from X^k/(k + 1)! on
        return rest, [arb(1) / n for n in range(k, 1, -1)]


def column(M: Any, j: int) -> Any:
    """Of a matrix, as one."""
    return matrix([[M[i, j]] for i in range(M.nrows())], 1)


def norm(X: Any) -> Ball:
    """The largest sum of sizes in a row."""
    n = X.nrows()
    return max(
        (sum((abs(X[i, j]).upper() for j in range(n)), arb(0)) for i in range(n)), default=arb(0)
    )


def widened(M: Any, radius: Ball) -> Any:
    """With so much more in each entry."""
    more = arb(0, radius.upper())
    more = acb(more, more) if isinstance(M, acb_mat) else more
    rows = [[M[i, j] + more for j in range(M.ncols())] for i in range(M.nrows())]
    return matrix(rows, M.ncols())


def opposite_response(states: States, C: Any, period: Ball) -> Ball | None:
    """What C reads, just before the force changes, of a force that changes its sign each period: at
    z = -1.

    C tanh(X)/A e, X = A T/2, is T/2 C e + T/2 C (tanh(X)/X - 1) e, by Taylor's series: where the
    plant is slow compared with the clock little of it is left, without a difference of what is
    nearly equal. None where the series is of no use.
    """
    n = states.size
    X = states.A * (period / 2)
    if not 4 * norm(X) < arb.pi():
        return None
    column = matrix([[arb(int(i == n - 1))] for i in range(n)], 1)
    found = matrix([[arb(0)] for _ in range(n)], 1)
    for share in _TANH[1:]:
        column = X * (X * column)
        found += column * arb(share)
    most = max((abs(column[i, 0]).upper() for i in range(n)), default=arb(0))
    found = widened(found, most * (4 / arb.pi() ** 2) ** (len(_TANH) - 1) / 3)
    direct = C[0, n - 1] if n else arb(0)
    return (direct + (C * found)[0, 0] if n else direct) * period / 2


def _tanh(count: int) -> list[fmpq]:
    """The coefficients of tanh(x)/x in x^2: tanh' = 1 - tanh^2."""
    row = [fmpq(1)]
    for k in range(1, count):
        row.append(-sum((row[i] * row[k - 1 - i] for i in range(k)), fmpq(0)) / (2 * k + 1))
    return row


_TANH = _tanh(16)
"""Each at most (4/pi^2)^k large: tanh(x)/x is the sum of 8/((2 j - 1)^2 pi^2 + 4 x^2)."""


@dataclass(frozen=True)
class Plant:
    """G(s), by its denominator and, for each delay (s), a numerator; none of them improper."""

    denominator: tuple[Expr, ...]
    terms: tuple[tuple[Expr, tuple[Expr, ...]], ...]

    def __post_init__(self) -> None:
        if any(len(above) > len(self.denominator) for _, above in self.terms):
            raise SceneError("a force that jumps would move the sampled position by an impulse")

    def samples(self, period: Expr, known: Mapping[Expr, Ball]) -> tuple[int, ...]:
        """Of each delay the whole samples."""
        return tuple(_floor(lag / period, known) for lag, _ in self.terms)


@dataclass(frozen=True)
class Timed(Plant):
    """The same of which each delay is known to have so many ``whole`` samples, and up to one more,
    whatever the numbers are."""

    whole: tuple[int, ...] = ()

    def samples(self, period: Expr, known: Mapping[Expr, Ball]) -> tuple[int, ...]:
        return self.whole


def _floor(ratio: Expr, known: Mapping[Expr, Ball]) -> int:
    """The whole part of a number."""

    def whole(_: int) -> int | None:
        found = (
            acb(expression_ball(ratio, known)).real.floor().unique_fmpz()
        )  # of a disc, that of all within it
        return None if found is None else int(found)

    if ratio.is_Rational:
        return int(ratio.p // ratio.q)
    found = at_rising_precision(whole)
    if found is None:
        raise UndecidedError("whether a delay is a whole number of samples")
    return found


@dataclass(frozen=True)
class SampledLoop:
    """The loop of a plant and a controller D(w) = above/below, w = 1/z, with a clock: 1 + D G = 0,
    as a polynomial C(w).

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
        """With numbers in place of symbols, nothing cancelled."""

        def put(row: Numbers) -> tuple[Expr, ...]:
            known = [x.xreplace(values) for x in row]
            while len(known) > 1 and known[-1] == 0:
                known.pop()
            return tuple(known)

        terms = tuple((lag.xreplace(values), put(N)) for lag, N in self.plant.terms)
        return SampledLoop(
            Plant(put(self.plant.denominator), terms),
            self.T.xreplace(values),
            put(self.above),
            put(self.below),
        )

    @cached_property
    def symbols(self) -> frozenset[Symbol]:
        """That stand in it."""
        every = self.above, self.below, self.plant.denominator, *(N for _, N in self.plant.terms)
        numbers = self.T, *(lag for lag, _ in self.plant.terms), *(x for row in every for x in row)
        return frozenset[Symbol]().union(*(x.free_symbols for x in numbers))

    def unstable(self) -> tuple[int, int]:
        """How many roots have |z| > 1, and how many lie at z = 1; UndecidedError where any other
        may lie on the circle."""
        at_1 = self.roots_at_one
        found = at_rising_precision(lambda _: _count_right(self.in_v({}, at_1)), 128, _MOST_BITS)
        if found is None:
            raise UndecidedError("whether a root lies on the unit circle")
        return found, at_1

    @cached_property
    def roots_at_one(self) -> int:
        """How many roots of a loop of numbers lie at z = 1: exactly, as long as it is one where the
        controller does anything."""
        if self.at_one != 0:
            return 0
        if not any(self.above) or not any(
            x for _, N in self.plant.terms for x in N
        ):  # the poles of what moves, alone
            return next(n for n, x in enumerate(self.plant.denominator) if x != 0)
        with flint.ctx.workprec(256):
            if self.about_one({})[1].contains(0):
                raise UndecidedError("how many roots of a sampled loop lie at z = 1")
        return 1

    @cached_property
    def at_one(self) -> Expr:
        """B(1) Q(0) + A(1) N(0): C(1) times what is nowhere 0."""
        above, below = (Add(*row) for row in (self.above, self.below))
        return (
            below * self.plant.denominator[0] + above * Add(*(N[0] for _, N in self.plant.terms))
        ).expand()

    @cached_property
    def at_minus_one(self) -> tuple[Expr, Expr]:
        """A(-1) and B(-1), by which N(-1) and Q(-1) are multiplied there."""
        size = self._size
        above, below = (
            Add(*(x * (-1) ** (size - k) for k, x in enumerate(row))).expand()
            for row in (self.above, self.below)
        )
        return above, below

    @property
    def _size(self) -> int:
        return max(len(self.above), len(self.below)) - 1

    def balls(self, known: Mapping[Expr, Ball] = MappingProxyType({})) -> list[Ball]:
        """The coefficients of C in w, ascending, at the current working precision; ``known`` : what
        symbols stand for."""
        n, degree = len(self.plant.denominator) - 1, len(self.below) - 1
        if any(self.above):
            whole = self.plant.samples(self.T, known)
            more = (
                ell + int(len(N) > n or (lag - ell * self.T).expand() != 0)
                for (lag, N), ell in zip(self.plant.terms, whole, strict=True)
            )
            degree = max(degree, len(self.above) - 1 + max(more))
        row = [*arb_poly(self.about_one(known))(arb_poly([-1, 1])).coeffs()][::-1]
        return row[: degree + n + 1]  # without roots at z = 0 that were added

    def about_one(self, known: Mapping[Expr, Ball]) -> list[Ball]:
        """The coefficients of z^N C(1/z) in z - 1, ascending; roots at z = 0 may be added."""
        return self._row(self._moved(known), known)

    def _row(self, moved: _Moved, known: Mapping[Expr, Ball]) -> list[Ball]:
        above, below = self._both(moved, known)
        return list((above + below).coeffs())

    def _both(self, moved: _Moved, known: Mapping[Expr, Ball]) -> tuple[Any, Any]:
        above, below = (
            _polynomial([expression_ball(x, known) for x in _shifted(row, self._size)])
            for row in (self.above, self.below)
        )
        return above * moved.above, below * moved.below

    def sides(self, known: Mapping[Expr, Ball]) -> tuple[Any, Any]:
        """N and Q of C = N + Q, polynomials in z - 1: N what the controller makes, Q what moves
        without it."""
        return self._both(self._moved(known), known)

    def in_v(self, known: Mapping[Expr, Ball], always: int = 0) -> list[Ball]:
        """The coefficients in v, ascending, without so many roots that always lie at 1.

        The highest is told at z = -1 itself: with Tustin's rule the controller has a pole there,
        and all but little of it cancels.
        """
        moved = self._moved(known)
        c = about_axis(self._row(moved, known)[always:])
        above, below = (expression_ball(x, known) for x in self.at_minus_one)
        there = (below * moved.below(arb(-2)) + above * moved.opposite) / (-2) ** always
        return [*c[:-1], there if len(c) % 2 else -there]

    @cached_property
    def _is_of_numbers(self) -> bool:
        numbers = (
            self.T,
            *self.plant.denominator,
            *(x for lag, N in self.plant.terms for x in (lag, *N)),
        )
        return not any(x.free_symbols for x in numbers)

    def _moved(self, known: Mapping[Expr, Ball]) -> _Moved:
        if self._is_of_numbers:
            return _of_numbers(self.plant, self.T, flint.ctx.prec)
        return _moved(self.plant, self.T, known)


def _count_right(c: Sequence[Ball]) -> int | None:
    """How many roots of a polynomial have Re v > 0, none being on the axis; None where balls do not
    tell.

    By Routh's array; where that has a zero, with a further root at -7/5, by which no two roots come
    to add up to 0; and by the roots themselves where two of them do.
    """
    further = [7 * x / 5 + y for x, y in zip([*c, arb(0)], [arb(0), *c], strict=True)]
    if (found := routh(c)) is not None or (found := routh(further)) is not None:
        return found
    if c[-1].contains(0):
        return None
    try:
        sides = [v.real for v in acb_poly(c).roots()]
    except ValueError:
        return None
    return None if any(x.contains(0) for x in sides) else sum(bool(x > 0) for x in sides)


def about_axis(row: Sequence[Ball]) -> list[Ball]:
    """The coefficients in v, ascending, of a polynomial in z - 1 = 2 v/(1 - v)."""
    n = len(row) - 1
    turned = sum((x * own for x, own in zip(row, _turned(n), strict=True)), arb_poly([]))
    c = turned.coeffs()
    return [*c, *[arb(0)] * (n + 1 - len(c))]


def hurwitz(c: Sequence[Ball]) -> Ball:
    """The last determinant but one of Hurwitz: 0 where two roots v add up to 0, a pair on the axis
    among them."""
    n = len(c) - 1
    if n < 2:
        return arb(1)
    down = c[::-1]
    places = [[2 * (j + 1) - (i + 1) for j in range(n - 1)] for i in range(n - 1)]
    return matrix([[down[k] if 0 <= k <= n else arb(0) for k in line] for line in places]).det()


def has_no_pair(c: Sequence[Ball], lines: Sequence[LinearEnclosure] = ()) -> bool:
    """Whether no polynomial with coefficients in these balls has roots v = +-j nu, nu > 0, proven.

    They would be zeros of E = c_0 - c_2 x + c_4 x^2 - ... and of O = c_1 - c_3 x + ..., x = nu^2.
    In wide balls that says more than the determinant, in which their widths are multiplied.
    ``lines`` : how the coefficients move together. With E = E_0 + E_1 y and O likewise, E_1 O_0 -
    O_1 E_0 would be zero as well, in which y is not.
    """
    if len(c) < 3:
        return True
    if not all(x.is_finite() for x in c):
        return False
    halves = _halves(c)
    if lines:
        (E_0, O_0), (E_1, O_1) = (
            map(arb_poly, _halves(x)) for x in ([y.at for y in lines], [y.slope for y in lines])
        )
        halves.append((E_1 * O_0 - O_1 * E_0).coeffs())
    both = [arb_poly(x) for x in halves], [arb_poly(x[::-1]) for x in halves]  # in x, and in 1/x
    waiting = deque((parts, 0.0, 1.0) for parts in both)
    for _ in range(_MOST_PIECES):
        if not waiting:
            return True
        parts, low, high = waiting.popleft()
        at = arb(low).union(arb(high))
        if all(p(at).contains(0) for p in parts):
            middle = (low + high) / 2
            if all(p(arb(middle)).contains(0) for p in parts):
                return False  # at this very place it stays open, however small the piece
            waiting += [(parts, low, middle), (parts, middle, high)]
    return not waiting


def _halves(c: Sequence[Ball]) -> list[list[Ball]]:
    """The coefficients of E and O in x."""
    return [[x * (-1) ** i for i, x in enumerate(c[start::2])] for start in (0, 1)]


def circle_tests(
    loop: SampledLoop, known: Mapping[Expr, Ball], one: Expr, always: int = 0
) -> tuple[Ball, Ball, Ball]:
    """At z = 1, at z = -1, and where two roots v add up to 0: numbers that vanish where a root is
    on the circle.

    ``one`` : ``at_one``; ``always`` : how many roots lie at 1 whatever the numbers are.
    """
    c = loop.in_v(known, always)
    return c[0] if always else expression_ball(one, known), c[-1], hurwitz(c)


def is_clear(loop: SampledLoop, known: Mapping[Expr, Ball], one: Expr, always: int = 0) -> bool:
    """Whether no root is on the circle for any numbers in balls, proven; two real ones may add up
    to 0 in v."""
    return most_on_circle(loop, known, one, always) == 0


def most_on_circle(
    loop: SampledLoop, known: Mapping[Expr, Ball], one: Expr, always: int = 0
) -> int | None:
    """For how many values in a ball each of the tests is 0 at most, proven: for none (0), for one;
    None where that is open.

    Of one number also by what tests and coefficients are on circles about it: with a resonance
    between clock and hand, as behind a compliance, balls are up to a thousand times as wide as what
    the coefficients do. A test whose derivative has one sign all over is 0 once at most.
    """

    def told(numbers: Mapping[Expr, Any]) -> list[Any]:
        """At z = 1, and the coefficients in v/T, of which more stay as they are where the clock's
        period is open."""
        T, c = expression_ball(loop.T, numbers), loop.in_v(numbers, always)
        return [
            c[0] if always else expression_ball(one, numbers),
            *(x * T**i for i, x in enumerate(c)),
        ]

    def tested(numbers: Mapping[Expr, Any]) -> list[Any]:
        found = told(numbers)
        return [hurwitz(found[1:]), *found]

    if _is_clear(told(known)):
        return 0
    if len(known) > 1:
        return None
    [(symbol, q)] = known.items()
    pair, *lines = over_circle(lambda x: tested({symbol: x}), q.mid(), q.rad())
    at_1, *c = lines
    ends = at_1, c[-1]
    if not all(x.ball.is_finite() for x in lines):
        return None
    is_pair_open = pair.ball.contains(0) and not has_no_pair([x.ball for x in c], c)
    if not is_pair_open and not any(x.ball.contains(0) for x in ends):
        return 0
    return (
        1 if all(not (x.ball.contains(0) and x.rate.contains(0)) for x in (*ends, pair)) else None
    )


def _is_clear(told: Sequence[Ball]) -> bool:
    """By what is at z = 1, and the coefficients, the last of which tells what is at z = -1."""
    at_1, *c = told
    if any(x.contains(0) or not x.is_finite() for x in (at_1, c[-1])):
        return False
    return not hurwitz(c).contains(0) or has_no_pair(c)


@dataclass(frozen=True)
class _Moved:
    """``above`` and ``below`` of a pulse transfer function, polynomials in z - 1; ``opposite`` :
    the first at z = -1."""

    above: Any
    below: Any
    opposite: Ball


@lru_cache(maxsize=64)
def _of_numbers(plant: Plant, period: Expr, bits: int) -> _Moved:
    """Of a plant without symbols, at this working precision: one matrix exponential for all values
    of a controller."""
    assert bits == flint.ctx.prec
    return _moved(plant, period, {})


def _moved(plant: Plant, period: Expr, known: Mapping[Expr, Ball]) -> _Moved:
    """The pulse transfer function of a plant."""
    whole = plant.samples(period, known)
    T, lead = (expression_ball(x, known) for x in (period, plant.denominator[-1]))
    Q = [expression_ball(x, known) / lead for x in plant.denominator]
    n = len(Q) - 1
    states = States(Q)
    lates = [
        expression_ball(lag - ell * period, known)
        for (lag, _), ell in zip(plant.terms, whole, strict=True)
    ]
    parts = [None if x.is_zero() else (states.integral(T - x), states.integral(x)) for x in lates]
    integral = states.integral(T)
    M, held = states.A * integral, column(integral, n - 1)
    total, opposite, (den, adjugate) = arb_poly([]), arb(0), _leverrier(M)
    longest, there = max(whole) + 1, den(arb(-2))
    for (_, above), ell, part in zip(plant.terms, whole, parts, strict=True):
        N = [expression_ball(x, known) / lead for x in above]
        N += [arb(0)] * (n + 1 - len(N))
        C = states.row([x - N[n] * q for x, q in zip(N, Q, strict=True)][:n])
        own = (
            _power(1) * _between(C, adjugate, column(part[0], n - 1) if part else held) + N[n] * den
        )
        if part:
            early, late = part[0], column(part[1], n - 1)
            own += _between(C, adjugate, late + states.A * (early * late))
        total += own * _power(longest - 1 - ell)
        told = [own(arb(-2))]
        least = None if part else opposite_response(states, C, T)
        if least is not None:  # as narrow as its numbers, but no narrower than its series
            told.append((least + N[n]) * there)
        opposite += (-1) ** (longest - 1 - ell) * min(told, key=lambda x: float(x.rad()))
    return _Moved(total, den * _power(longest), opposite)


def _leverrier(M: Any) -> tuple[Any, list[Any]]:
    """|x - M|, and the coefficients of adj(x - M), ascending in x: without differences of what is
    nearly equal (Leverrier)."""
    n = M.nrows()
    one = matrix([[arb(int(i == j)) for j in range(n)] for i in range(n)])
    row, N = [arb(1)], one
    found = [one] if n else []
    for k in range(1, n + 1):
        moved = N * M
        row.append(-moved.trace() / k)
        N = moved + one * row[-1]
        if k < n:
            found.append(N)
    return _polynomial(row[::-1]), found[::-1]


def _between(C: Any, adjugate: list[Any], start: Any) -> Any:
    """C adj(x - M) start."""
    return _polynomial([(C * N * start)[0, 0] for N in adjugate])


@lru_cache(maxsize=64)
def _turned(n: int) -> list[Any]:
    """(z - 1)^k (1 - v)^n in v, k = 0, ..., n."""
    return [
        arb_poly([0] * k + [2**k])
        * arb_poly([(-1) ** i * comb(n - k, i) for i in range(n - k + 1)])
        for k in range(n + 1)
    ]


@lru_cache(maxsize=64)
def _power(k: int) -> Any:
    """z^k in z - 1."""
    return arb_poly([comb(k, i) for i in range(k + 1)])


@lru_cache(maxsize=64)
def _shifted(row: tuple[Expr, ...], size: int) -> tuple[Expr, ...]:
    """z^size times a polynomial in 1/z, in z - 1: what cancels does so exactly."""
    sums = [Integer(0)] * (size + 1)
    for k, x in enumerate(row):
        for i in range(size - k + 1):
            sums[i] += x * comb(size - k, i)
    return tuple(x.expand() for x in sums)
