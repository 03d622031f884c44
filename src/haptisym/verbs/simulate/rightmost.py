"""The rightmost root of a characteristic function: whether the slowest motion decays or grows.

Of a polynomial all roots are enclosed, also where several coincide (``enclosed_roots``). So are all
roots z of a sampled loop; the largest gives s = ln z/T, the growth rate and frequency of the motion
that lasts longest (``clocked_root``).

With delays or powers of s the function is sum of c_k s^p_k exp(-s lag_k), which may have infinitely
many roots. Newton's iteration in floating point runs from many starts. Interval Newton encloses the
roots that it found furthest to the right, and the argument principle proves that there are no
others: the proof is written out at ``QuasiPolynomial.is_rightmost``. Read from ``rightmost_root``.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property, reduce
from itertools import combinations
from math import gcd, inf, lcm, pi
from typing import Any

import flint
import numpy as np
from flint import acb, acb_poly, arb, fmpq, fmpq_poly
from sympy import Expr, Integer, Rational

from haptisym.kernel.budget import Waiting
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import expression_ball
from haptisym.kernel.rings import Polynomial, RationalFunction, degree_in
from haptisym.kernel.rootcount import at_least, order_at_0
from haptisym.model.catalogue import Hand
from haptisym.model.scene import Scene
from haptisym.programs.values import Array
from haptisym.verbs.stability.clockedloop import loop_of

# Interval Newton begins with boxes of relative radius 2^-100 (``enclosed``): 192 bits leave some 90
# for what cancels between the terms.
_BITS = 192
# A step is at most half of |s|: some twenty take a start from the largest modulus to the smallest,
# the others are for convergence.
_ITERATIONS = 80
_TURNS = 12  # of the longest delay, as far as Newton's method starts
_MOST_PIECES = 40_000  # of a contour
_MOST_DOUBLINGS = 34  # of the radius beyond which there is no root, from 2^-10 rad/s on
_MOST_POWER = 400  # of exp(-s unit), up to which a chain's polynomial is solved
# Roots of smaller modulus are those at 0, which are counted exactly, by the order of the polynomial
# at 0, and not by floats.
_SLACK = 1e-9


@dataclass(frozen=True)
class Term:
    """A term coefficient s^power exp(-s lag) of a quasi-polynomial, exact; lag in s."""

    coefficient: Expr
    power: Rational
    lag: Expr


@dataclass(frozen=True)
class Rightmost:
    """The rightmost root with Im s >= 0 that was found, rad/s.

    ``enclosure`` is a ball (flint ``acb``) around it, None where interval Newton did not enclose
    it. Its real part holds those of all roots that balls do not tell from it in that.
    ``certified``: it is proven that no root lies right of this ball.
    """

    s: complex
    enclosure: Any
    certified: bool
    function: QuasiPolynomial | None = field(default=None, repr=False)
    others: tuple[complex, ...] = ()
    """All roots that were found, this one too, from right to left."""
    order: int = 1
    """Number of roots that balls do not distinguish from this one, itself included: the motion may
    be t^(order - 1) exp(s t)."""

    @classmethod
    def of_all(cls, found: Sequence[tuple[Any, int]]) -> Rightmost:
        """Return the rightmost of all roots, given balls around each of them with its order."""
        balls = [ball for ball, _ in found]
        enclosure = _furthest(balls)
        # Any of the balls that overlap in their real parts may be the rightmost: the largest order
        # among them is the safe one.
        order = max(n for ball, n in found if ball.real.overlaps(enclosure.real))
        others = sorted(map(_middle, balls), key=lambda x: -x.real)
        return cls(_middle(enclosure), enclosure, certified=True, others=tuple(others), order=order)

    def digits(self, count: int = 15) -> tuple[str, str]:
        """Real and imaginary part with up to so many digits: where it is enclosed, those that its
        ball proves."""
        if self.enclosure is None:
            return f"{self.s.real:.9g}", f"{self.s.imag:.9g}"
        parts = self.enclosure.real, self.enclosure.imag
        real, imag = ("0" if x.contains(0) else str(x.str(count, radius=False)) for x in parts)
        return real, imag


def rightmost_pole(dynamics: RationalFunction) -> complex | None:
    """The pole with the largest real part, in floating point; None if none is found. What cancels
    at s = 0 is no pole.

    >>> from sympy import exp
    >>> from haptisym.kernel.rings import s
    >>> pole = rightmost_pole(Ring.of([exp(-s)]).convert(1 / (s + 2 * exp(-s))).reduced())
    >>> round(pole.real, 4), round(abs(pole.imag), 4)
    (0.1728, 1.6737)
    """
    ring = dynamics.ring
    assert isinstance(ring, Ring)
    # A float cannot tell whether a root at 0 cancels against the numerator: all roots near 0 are
    # dropped, and 0 is put back where the orders at 0, which are exact, leave a pole there.
    roots = [x for x in QuasiPolynomial.of(dynamics.denominator, ring).roots() if abs(x) > _SLACK]
    if order_at_0(dynamics.denominator, ring) > order_at_0(dynamics.numerator, ring):
        roots.append(0j)
    return max(roots, key=lambda x: x.real, default=None)


def rightmost_root(polynomial: Polynomial, ring: Ring, at_0: int = 0) -> Rightmost | None:
    """The rightmost root of a characteristic function with numbers only; None if there is none to
    find.

    ``at_0`` : that many roots at s = 0 are not meant, as they cancel. A root that is in several
    factors of the polynomial is looked for once, as balls are narrower about simple roots; its
    order is what it counts in all.
    """
    at_origin = max(at_least(order_at_0(polynomial, ring)) - at_0, 0)
    # Without what all terms share, powers of s and delays: it has no roots but s = 0, which are
    # counted above.
    bare = polynomial / polynomial.term_content()
    # Interval Newton needs f' != 0, so it encloses simple roots alone: each root is looked for in
    # the product of the square-free factors, where it is simple.
    factors = bare.factor_squarefree()[1]
    # In s alone all roots can be enclosed at once, and no contour is needed.
    if not any(degree_in([bare], i) for i in range(ring.size, len(ring.meanings))):
        with flint.ctx.workprec(_BITS_ALL):
            rows = [([expression_ball(c) for c in ring.coefficients(x)], n) for x, n in factors]
            # Coefficients are real, roots conjugate in pairs: one of each pair says all.
            roots = [
                (ball, n * nearby)
                for row, n in rows
                for ball, nearby in enclosed_roots(row)
                if ball.imag.mid() >= 0
            ]
        roots += [(acb(0), at_origin)] * bool(at_origin)
        return Rightmost.of_all(roots) if roots else None
    simple = reduce(lambda x, y: x * y, (x for x, _ in factors), ring.constant(1))
    function, zeros = QuasiPolynomial.of(simple, ring), at_least(order_at_0(simple, ring))
    found = [x for x in function.roots() if not zeros or abs(x) > _SLACK]
    listed = sorted([*found, *[0j] * bool(at_origin)], key=lambda x: -x.real)
    if not listed:
        return None
    first = listed[0]
    # Floats do not order roots whose real parts differ by less than the strip: all roots in it are
    # enclosed, and the line of the proof runs left of them.
    following = next(
        (x.real for x in listed if x.real < first.real - _STRIP * (1 + abs(first))), -inf
    )
    balls = [function.enclosed(x) if x else acb(0) for x in listed if x.real > following]
    # Which factor the rightmost root is of is not known any more: the largest exponent is safe. The
    # root at 0, which no factor has, counts where it lies in the strip.
    order = max(at_origin if following < 0 else 0, *(n for _, n in factors))
    if any(ball is None for ball in balls):
        return Rightmost(
            first, None, certified=False, function=function, others=tuple(listed), order=order
        )
    enclosure = _furthest(balls)
    certified = function.is_rightmost(found, first, following, zeros)
    return Rightmost(_middle(enclosure), enclosure, certified, function, tuple(listed), order)


# Relative to 1 + |s|. Newton's last step is below 1e-9 of |s|: what differs by 1e-7 in its real
# part is surely ordered by floats, what differs by less may not be.
_STRIP = 1e-7


def _furthest(balls: Sequence[Any]) -> Any:
    """Return, of the balls furthest to the right, the imaginary part nearest to the real axis,
    with the real parts of all of them united."""
    furthest = max(balls, key=lambda x: x.real.mid())
    level = [x for x in balls if x.real.overlaps(furthest.real)]
    # The union of the real parts holds the largest one whichever of the balls it belongs to.
    with flint.ctx.workprec(_BITS):
        return acb(
            reduce(arb.union, (x.real for x in level)),
            min((abs(x.imag) for x in level), key=arb.mid),
        )


def _middle(ball: Any) -> complex:
    """Return the middle of a ball as floats, with 0 for a part whose interval contains 0."""
    return complex(*(0.0 if x.contains(0) else float(x.mid()) for x in (ball.real, ball.imag)))


_BITS_ALL = 512
# The constant coefficient is changed by this many bits less than itself: an n-fold root then falls
# apart into n that are about 2^(-200/n) of their size away, and no product of differences is 0.
_APART = 200


def enclosed_roots(coefficients: Sequence[Any]) -> list[tuple[Any, int]]:
    """Balls around all roots of a real polynomial, each with the number of roots in the balls that
    hang together with it, its own too.

    ``coefficients`` : real balls, ascending, the first and the last of which are not 0; ValueError
    where that is not known.
    About any n different numbers x_i the discs |x - x_i| <= n |p(x_i)|/|a_n prod_{j != i} (x_i -
    x_j)| hold all roots, and those that hang together hold as many as they are (Smith, 1970). The
    x_i are roots of a polynomial that is hardly another one: where roots of this one coincide they
    are near. A root whose ball meets no other and the real axis is real.
    """
    n, polynomial = len(coefficients) - 1, acb_poly(coefficients)
    if n < 1:
        return []
    if any(coefficients[i].contains(0) for i in (0, n)):
        raise ValueError("a polynomial of which the degree, or a root at 0, is not known")
    beside = fmpq_poly([x.mid().fmpq() for x in coefficients])
    beside[0] *= 1 + fmpq(1, 2**_APART)
    points = [x.mid() for x, _ in beside.numer().complex_roots()]
    balls = []
    for i, x in enumerate(points):
        # The radius of the disc about x_i, in balls, and rounded up. The square around the disc is
        # kept: real and imaginary part are then intervals.
        product = reduce(
            lambda a, b: a * b, (x - y for j, y in enumerate(points) if j != i), coefficients[n]
        )
        radius = arb(0, (n * abs(polynomial(x) / product)).upper())
        balls.append(acb(x.real + radius, x.imag + radius))
    # The coefficients are real, so the balls are conjugate in pairs. One that contains a real
    # number meets its own mirror image: if it meets no other ball, its one root is real.
    return [
        (acb(x.real) if len(group) == 1 and x.imag.contains(0) else x, len(group))
        for group in _hanging_together(balls)
        for x in group
    ]


def _hanging_together(balls: Sequence[Any]) -> list[list[Any]]:
    """The balls in groups: what meets, or meets what meets, is in one."""
    groups = list[list[Any]]()
    for ball in balls:
        met, apart = [ball], list[list[Any]]()
        for group in groups:
            if any(ball.overlaps(x) for x in group):
                met += group
            else:
                apart.append(group)
        groups = [*apart, met]
    return groups


def _terms(polynomial: Polynomial, ring: Ring) -> Iterator[Term]:
    """Yield the terms of a polynomial of a ring: its exponents are of s, of pi, then of the delays
    exp(-s lag), then of the powers s^order."""
    lags = len(ring.lags)
    for exponents, value in polynomial.to_dict().items():
        powers = [int(n) for n in exponents]
        times_late = powers[ring.size : ring.size + lags]
        times_power = powers[ring.size + lags :]
        lag = sum((n * x for n, x in zip(times_late, ring.lags, strict=True)), Integer(0))
        # Not strict: a generator that stands for j may follow the powers of s.
        pairs = zip(times_power, ring.orders, strict=False)
        power = sum((n * x for n, x in pairs), Integer(powers[0]))
        number = Rational(int(value.p), int(value.q))
        yield Term(number * ring.meanings[1] ** powers[1], power, lag)


@dataclass(frozen=True)
class QuasiPolynomial:
    """A quasi-polynomial: a sum of terms c s^p exp(-s lag), evaluated in floats and in balls."""

    terms: tuple[Term, ...]

    @classmethod
    def of(cls, polynomial: Polynomial, ring: Ring) -> QuasiPolynomial:
        """Return the function of a polynomial of a ring that has numbers only."""
        merged: dict[tuple[Rational, Expr], Expr] = {}
        # Several powers of pi may stand before one power of s: as one term their sum may cancel.
        for t in _terms(polynomial, ring):
            merged[t.power, t.lag] = merged.get((t.power, t.lag), Integer(0)) + t.coefficient
        return cls(tuple(Term(c, *place) for place, c in merged.items()))

    @cached_property
    def chain(self) -> float | None:
        """The largest Re s to which infinitely many roots tend, in floats; None where there are
        none, or it is not computed.

        They are there where delays are in the highest power of s, and tend to the roots of what it
        is multiplied by: those of a polynomial, if the delays are multiples of one.
        """
        degree = max(t.power for t in self.terms)
        leading = {t.lag: float(t.coefficient) for t in self.terms if t.power == degree}
        first = min(leading, key=float)
        later = {(lag - first).expand(): c for lag, c in leading.items() if lag != first}
        if not later:
            return None
        unit = _common_measure(later)
        if unit is None or max(later, key=float) / unit > _MOST_POWER:
            return None
        # For large |s| the roots tend to those of the leading coefficient, a polynomial in x =
        # exp(-s unit) where the delays have a common measure: Re s = -ln|x|/unit.
        row = np.zeros(int(max(later, key=float) / unit) + 1)
        row[0] = leading[first]
        for lag, c in later.items():
            row[int(lag / unit)] = c
        return float(max(-np.log(np.abs(np.roots(row[::-1])))) / float(unit))

    @cached_property
    def _floats(self) -> tuple[Array, Array, Array]:
        rows = [(float(t.coefficient), float(t.power), float(t.lag)) for t in self.terms]
        c, p, lag = (np.array(column) for column in zip(*rows, strict=True))
        return c, p, lag

    @cached_property
    def _balls(self) -> list[tuple[Any, Rational, Any]]:
        with flint.ctx.workprec(_BITS):
            return [
                (expression_ball(t.coefficient), t.power, expression_ball(t.lag))
                for t in self.terms
            ]

    def values(self, s: Array) -> tuple[Array, Array]:
        """Return the function and its derivative, both divided by the largest term's modulus.

        Newton's step, their quotient, is unchanged by that, and no exponential overflows.
        """
        c, p, lag = self._floats
        logs = np.log(np.abs(c)) + p * np.log(s[:, None]) - lag * s[:, None]
        top = logs.real.max(axis=1, keepdims=True)
        terms = np.sign(c) * np.exp(logs - top)
        return terms.sum(axis=1), (terms * (p / s[:, None] - lag)).sum(axis=1)

    def roots(self) -> list[complex]:
        """Roots with Im s >= 0, each once: where Newton's method ends that starts from many
        places."""
        # Far from a root, where f' is small, Newton's step leaps: it is cut to half of |s|, so that
        # a start stays among sizes where the function has digits.
        s = self._starts()
        with np.errstate(all="ignore"):
            for _ in range(_ITERATIONS):
                value, slope = self.values(s)
                step = value / slope
                size = np.abs(step)
                s = s - np.where(
                    size > 0.5 * np.abs(s) + 1e-12, step * (0.5 * np.abs(s) + 1e-12) / size, step
                )
            value, slope = self.values(s)
            # Converged where one more step would change less than a billionth.
            good = np.isfinite(value) & (np.abs(value / slope) < 1e-9 * np.abs(s) + 1e-13)
        found: list[complex] = [0j] if min(t.power for t in self.terms) > 0 else []
        # Ends within 1e-7 are taken as one root. Two roots so close would be missed here, and then
        # the count of the argument principle differs: nothing wrong is certified.
        for x in sorted(map(complex, s[good]), key=lambda x: -x.real):
            root = (
                complex(x.real, abs(x.imag)) if abs(x.imag) > 1e-9 * abs(x) else complex(x.real, 0)
            )
            if all(abs(root - y) > 1e-7 * (abs(root) + 1e-9) for y in found):
                found.append(root)
        return found

    def _starts(self) -> Array:
        """Return starts of Newton's iteration with Im s >= 0."""
        _, _, lags = self._floats
        longest, shortest = lags.max(initial=0.0), min((x for x in lags if x > 0), default=0.0)
        # Rays, most of them close to the imaginary axis: there lie the lightly damped roots, of
        # which one is the rightmost.
        sizes = np.geomspace(1e-2, 1e5, 57)
        turns = np.exp(1j * np.pi * np.array([0.0, 0.2, 0.4, 0.47, 0.5, 0.53, 0.6, 0.8, 0.99]))
        starts = [np.multiply.outer(sizes, turns).ravel()]
        # The roots of a delay are about 2 pi/lag apart along the imaginary axis, with real parts of
        # some 1/lag: a grid of these units, two heights to a turn.
        for lag in {longest, shortest} - {0.0}:
            heights = np.arange(0.25, 2 * _TURNS, 0.5) * pi / lag
            widths = np.array([-8.0, -3.0, -1.0, -0.2, 0.2, 1.0, 3.0, 8.0]) / lag
            starts.append((widths[:, None] + 1j * heights).ravel())
        return np.concatenate(starts)

    def ball(self, s: Any) -> Any:
        """Return a ball that contains all values of the function on a ball."""
        return self._sum(s)[0]

    def _sum(self, s: Any) -> tuple[Any, Any]:
        """Return balls around the values of the function and of its derivative on a ball."""
        value, slope = acb(0), acb(0)
        for c, p, lag in self._balls:
            wave = c * (-lag * s).exp()
            power = s ** int(p) if p.is_Integer else (s.log() * expression_ball(p)).exp()
            lower = _lower(s, p)
            value += wave * power
            slope += wave * (lower - lag * power)
        return value, slope

    def enclosed(self, near: complex) -> Any:
        """Return a ball that is proven to hold exactly one root, by interval Newton from a float
        nearby; None where that is not proven."""
        with flint.ctx.workprec(_BITS):
            # Newton's steps at a point, its rounding dropped each time: they bring the float to the
            # digits of the working precision.
            middle = acb(near.real, near.imag)
            for _ in range(8):
                value, slope = self._sum(middle)
                if slope.contains(0):
                    return None
                middle = (middle - value / slope).mid()
            # A root that the floats call real is enclosed on the axis: ``_both`` counts it once,
            # without a conjugate.
            if near.imag == 0:
                middle = acb(middle.real)
            # N(X) = m - f(m)/f'(X) inside X proves that X holds exactly one root, and N(X) holds
            # it. A box hardly wider than rounding does not map into itself, so it grows until it
            # does.
            radius = arb(2) ** -100 * (abs(middle).mid() + arb(2) ** -40)
            for _ in range(40):
                box = acb(middle.real + arb(0, radius), middle.imag + arb(0, radius))
                value, slope = self._sum(box)
                if slope.contains(0):
                    return None
                image = middle - self.ball(middle) / slope
                if box.contains_interior(image):
                    return image
                radius *= 4
        return None

    # That no root is further right

    def is_rightmost(
        self, found: Sequence[complex], first: complex, following: float, at_0: int
    ) -> bool:
        """Whether the roots right of a line, which lies between ``following`` and ``first``, are
        those that were found there.

        The proof, for R = {Re s > line}: in R a root has |s| < radius (``_radius``). So it lies in
        the box of all s with line < Re s < max(line, 0) + radius and |Im s| < radius, and the
        argument principle counts the roots in there. Each that was found, and its conjugate, is
        alone in a ball in R, and no two of these balls meet. If that makes as many as were counted,
        there are no others. ``at_0`` : how often 0 is a root, which is in R if line < 0, and in
        none of ``found``.
        """
        # Halfway to the next roots, as on the contour the function must be told from 0, and near a
        # root that takes many pieces. The gap is bounded where no other root was found.
        gap = min(first.real - following, 0.2 * abs(first) + 1e-3)
        line = first.real - gap / 2
        if line <= 0 and any(not t.power.is_Integer for t in self.terms):
            return False  # powers of s have a cut on the negative real axis
        right = [x for x in found if x.real > line]
        balls = [ball for x in right for ball in self._both(x)]
        # Each ball holds one root only if it exists, lies right of the line and is not around 0,
        # and different roots are counted only if no two balls meet.
        if any(
            ball is None or not ball.real > line or (at_0 and ball.contains(0)) for ball in balls
        ):
            return False
        if any(x.overlaps(y) for x, y in combinations(balls, 2)):
            return False
        return self._count_right_of(line) == len(balls) + (at_0 if line < 0 else 0)

    def _both(self, root: complex) -> list[Any]:
        """Return a ball around a root, and one around its conjugate where it is not real; None
        in the list where a root is not enclosed."""
        ball = self.enclosed(root)
        return [ball] if ball is None or not root.imag else [ball, ball.conjugate()]

    def _count_right_of(self, line: float) -> int | None:
        """Count the roots right of a line, with multiplicity; None where the count is not proven.

        By the argument principle: the turns of f along a rectangle that holds all of these roots.
        """
        radius = self._radius(line)
        if radius is None:
            return None
        # No root right of the line has |s| >= radius. The right side must therefore not lie nearer
        # than at Re s = radius, also where the line itself is left of 0.
        right = max(line, 0.0) + radius
        corners = [
            complex(line, -radius),
            complex(right, -radius),
            complex(right, radius),
            complex(line, radius),
        ]
        # 64 bits are enough to tell an integer from the next one. The allowance of pieces is shared
        # by the four sides.
        with flint.ctx.workprec(64):
            total, allowance = arb(0), [_MOST_PIECES]
            for a, b in zip(corners, [*corners[1:], corners[0]], strict=True):
                turned = self._turned(a, b, allowance)
                if turned is None:
                    return None
                total += turned
            turns = total / (2 * arb.pi())
        whole = round(float(turns))
        return whole if abs(turns - whole) < arb(1) / 4 else None

    def _turned(self, start: complex, end: complex, allowance: list[int]) -> Any:
        """Return a ball around the change of arg f along a segment, rad; None where the allowance
        of pieces, from which those used are taken, is not enough."""
        total, pieces = arb(0), Waiting([(acb(start.real, start.imag), acb(end.real, end.imag))])
        for a, b in pieces:
            allowance[0] -= 1
            if allowance[0] < 0:
                return None
            over = self.ball(a.union(b))
            middle = over.mid()
            # Over the piece f stays in the half plane around f's middle value: its argument
            # relative to that lies in (-pi/2, pi/2), where the principal value has no jump.
            if not over.contains(0) and (over / middle).real > 0:
                total += (self.ball(b) / middle).arg() - (self.ball(a) / middle).arg()
                continue
            half = ((a + b) / 2).mid()
            pieces.add((a, half), (half, b))
        return total

    def _radius(self, line: float) -> float | None:
        """Return a modulus at and beyond which no root has Re s >= line; None where none is found.

        There |c s^p exp(-s lag)| <= |c| |s|^p exp(-lag line). With n the highest power it is 0 for
        no s where the term of s^n without a delay outweighs all others, each over |s|^n; and as
        those are of lower powers, or delayed, they do not grow with |s|.
        """
        degree = max(t.power for t in self.terms)
        with flint.ctx.workprec(_BITS):
            floor, others = arb(0), []
            for c, p, lag in self._balls:
                # Of the highest power the delayed terms may cancel the undelayed one: they count
                # against it.
                size = abs(c) * (-lag * line).exp()
                if p < degree:
                    others.append((size, expression_ball(p - degree)))
                else:
                    floor += abs(c) if lag == 0 else -size
            # A power of two is exact as a float. Any larger radius serves, too: what is compared
            # with the floor only falls.
            for n in range(_MOST_DOUBLINGS):
                radius = arb(2) ** (n - 10)
                if floor > sum((size * radius**power for size, power in others), arb(0)):
                    return float(radius)
        return None


def _common_measure(lags: Iterable[Expr]) -> Rational | None:
    """The largest number that all are whole multiples of; None where there is none."""
    first, *others = lags
    shares = [lag / first for lag in others]
    if not all(x.is_Rational for x in shares):
        return None
    below = lcm(*(int(x.q) for x in shares))
    return first * Rational(gcd(below, *(int(x * below) for x in shares)), below)


def _lower(s: Any, p: Rational) -> Any:
    """Return p s^(p - 1), the derivative of s^p."""
    if p == 0:
        return acb(0)
    return (
        int(p) * s ** (int(p) - 1)
        if p.is_Integer
        else expression_ball(p) * (s.log() * expression_ball(p - 1)).exp()
    )


def clocked_root(scene: Scene, hand: Hand) -> Rightmost | None:
    """Return s = ln z/T for the largest root z of a sampled loop; None where its polynomial is not
    known.

    It is ``certified``: all roots of the polynomial in w = 1/z are enclosed, and the real part that
    is given holds those of all roots whose real parts are not certain to be less than another's.
    """
    try:
        loop = loop_of(scene, hand)
        with flint.ctx.workprec(_BITS_ALL):
            roots, T = enclosed_roots(loop.balls()), expression_ball(loop.T)
            # s = ln z/T = -ln w/T: a ball around w that contains 0 has no logarithm.
            if any(w.contains(0) for w, _ in roots):
                return None
            found = [(-w.log() / T, order) for w, order in roots]
    except (UndecidedError, ValueError):
        return None
    return Rightmost.of_all(found) if found else None
