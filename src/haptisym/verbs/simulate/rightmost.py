"""Where is the rightmost root s of a characteristic function, and is it proven that no other root
lies further to the right?

The real part of that root is the rate at which the slowest motion exp(s t) decays or grows, its
imaginary part the frequency. There are three kinds of function:

- **Polynomials in s.** Balls around all roots, also where several coincide (``enclosed_roots``).
- **Quasi-polynomials** f(s) = sum of c_k s^p_k exp(-s lag_k), with delays lag_k >= 0 and powers
  p_k >= 0 that may be fractions (``QuasiPolynomial``). They may have infinitely many roots.
  Newton's iteration in floating point runs from many starts; it may miss roots. Interval Newton
  encloses the roots that it found furthest to the right, and the argument principle proves that
  there are no others: the proof is written out at ``QuasiPolynomial.is_rightmost``.
- **Sampled loops** with the period T: balls around all roots z of a polynomial. The largest gives
  s = ln z/T (``clocked_root``).

**Guaranteed** where ``Rightmost.certified``: the ball holds a root, and no root lies right of it.
Otherwise the root is the rightmost of those that Newton's iteration found.

The polynomials are those of a ``Ring``: their generators are s, pi, the unit delays exp(-s lag) and
fractional powers of s, in this order. A *ball* is a complex number with an error bound on its real
and its imaginary part (Arb's ``acb``, here typed as Any).

Begin reading at ``rightmost_root``.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property, reduce
from itertools import combinations, pairwise
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

# Bits for a quasi-polynomial. Interval Newton begins with boxes of relative radius 2^-100
# (``enclosed``): 192 bits leave some 90 for what cancels between the terms.
_BITS = 192
# Bits for a polynomial, whose roots are all enclosed.
_POLYNOMIAL_BITS = 512
# The constant coefficient is changed by this many bits less than itself: an n-fold root then falls
# apart into n that are about 2^(-200/n) of their size away, and no product of differences is 0.
_APART = 200

# Newton's iteration in floats. Its step is at most this share of |s|, so that a start stays among
# sizes where the function has digits.
_LONGEST_STEP = 0.5
# Some twenty such steps take a start from the largest modulus to the smallest, the others are for
# convergence.
_ITERATIONS = 80
# Converged where one more step would change s by less than a billionth of it.
_CONVERGED = 1e-9
# Ends that differ by less than this share are taken as one root. Two roots so close would be missed
# here, and then the count of the argument principle differs: nothing wrong is certified.
_SAME = 1e-7
# An end whose imaginary part is a smaller share of it is a real root.
_REAL = 1e-9
# Roots of smaller modulus, rad/s, are those at 0, which are counted exactly, by the order of the
# polynomial at 0, and not by floats.
_ORIGIN = 1e-9
# Relative to 1 + |s|: roots whose real parts differ by more are surely ordered by floats, as
# Newton's last step is below 1e-9 of |s|; by less they may not be.
_STRIP = 1e-7
# Up to so many turns of each delay, omega lag/(2 pi), there are starts.
_TURNS = 12

# The argument principle. The pieces into which a contour may be cut, all four sides together.
_MOST_PIECES = 40_000
# Doublings of the radius beyond which there is no root, from 2^-10 rad/s on: to 8e6 rad/s.
_MOST_DOUBLINGS = 34
# Degree of the polynomial in exp(-s unit), with all delays multiples of one unit, up to which the
# limit of a chain of roots is computed.
_MOST_POWER = 400


@dataclass(frozen=True)
class Term:
    """A term coefficient s^power exp(-s lag) of a quasi-polynomial, exact; lag in seconds."""

    coefficient: Expr
    power: Rational
    lag: Expr


@dataclass(frozen=True)
class Rightmost:
    """The rightmost root that was found, 1/s and rad/s; of two conjugate ones that with Im s >= 0.

    ``s`` : the root in floats. ``enclosure`` : a ball around it, None where interval Newton did not
    enclose it; where the real parts of several roots are not distinguished, its real part contains
    all of them.
    ``certified`` : whether it is proven that no root lies right of the ball.
    ``function`` : the quasi-polynomial that it is a root of; None of a polynomial and a sampled
    loop.
    """

    s: complex
    enclosure: Any
    certified: bool
    function: QuasiPolynomial | None = field(default=None, repr=False)
    others: tuple[complex, ...] = ()
    """All roots that were found, this one too, from right to left; of conjugate ones at least that
    with Im s >= 0."""
    order: int = 1
    """An upper bound of the multiplicity of the root: the number of roots that are not
    distinguished from it, itself included. The motion may be t^(order - 1) exp(s t)."""

    @classmethod
    def of_all(cls, roots: Sequence[tuple[Any, int]]) -> Rightmost:
        """Return the rightmost of all roots, given a ball around each, or around one of each
        conjugate pair, with its order. As no root is missing, it is certified."""
        balls = [ball for ball, _ in roots]
        enclosure = _furthest(balls)
        # Any of the balls that overlap in their real parts may be the rightmost: the largest order
        # among them is the safe one.
        order = max(n for ball, n in roots if ball.real.overlaps(enclosure.real))
        others = sorted(map(_middle, balls), key=lambda x: -x.real)
        return cls(_middle(enclosure), enclosure, certified=True, others=tuple(others), order=order)

    def digits(self, count: int = 15) -> tuple[str, str]:
        """Return real and imaginary part in decimals, of up to ``count`` digits that the ball
        proves, "0" where a part may be 0; nine digits of the float where there is no ball."""
        if self.enclosure is None:
            return f"{self.s.real:.9g}", f"{self.s.imag:.9g}"
        texts = list[str]()
        for x in (self.enclosure.real, self.enclosure.imag):
            decimals = str(x.str(count, radius=False))
            texts.append("0" if x.contains(0) else decimals)
        real, imag = texts
        return real, imag


def rightmost_pole(dynamics: RationalFunction) -> complex | None:
    """Return the pole with the largest real part, in floating point; None if none is found. What
    cancels at s = 0 is no pole.

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
    function = QuasiPolynomial.of(dynamics.denominator, ring)
    roots = [x for x in function.roots() if abs(x) > _ORIGIN]
    if order_at_0(dynamics.denominator, ring) > order_at_0(dynamics.numerator, ring):
        roots.append(0j)
    return max(roots, key=lambda x: x.real, default=None)


def rightmost_root(polynomial: Polynomial, ring: Ring, at_0: int = 0) -> Rightmost | None:
    """Return the rightmost root of a characteristic function; None if none is found.

    ``polynomial`` : of ``ring``, without symbols for parameters. ``at_0`` : the number of roots at
    s = 0 that are left out, as they cancel against a numerator.
    """
    at_origin = max(at_least(order_at_0(polynomial, ring)) - at_0, 0)
    # Without what all terms share, powers of s and delays: it has no roots but s = 0, which are
    # counted above.
    bare = polynomial / polynomial.term_content()
    # Square-free factors with their exponents: a root is simple in the one factor that has it.
    factors = bare.factor_squarefree()[1]
    # In s alone all roots can be enclosed at once, and no contour is needed.
    delays_and_orders = range(ring.size, len(ring.meanings))
    if any(degree_in([bare], i) for i in delays_and_orders):
        return _of_quasi_polynomial(factors, ring, at_origin)
    return _of_polynomial(factors, ring, at_origin)


def _of_polynomial(
    factors: Sequence[tuple[Polynomial, int]], ring: Ring, at_origin: int
) -> Rightmost | None:
    """Return the rightmost of all roots of polynomials in s with their exponents, and of
    ``at_origin`` roots at 0; None if there is none."""
    roots = list[tuple[Any, int]]()
    with flint.ctx.workprec(_POLYNOMIAL_BITS):
        for factor, exponent in factors:
            coefficients = [expression_ball(c) for c in ring.coefficients(factor)]
            for ball, nearby in enclosed_roots(coefficients):
                # Coefficients are real, roots conjugate in pairs: one of each pair is enough.
                if ball.imag.mid() >= 0:
                    roots.append((ball, exponent * nearby))
    if at_origin:
        roots.append((acb(0), at_origin))
    return Rightmost.of_all(roots) if roots else None


def _of_quasi_polynomial(
    factors: Sequence[tuple[Polynomial, int]], ring: Ring, at_origin: int
) -> Rightmost | None:
    """Return the rightmost root that is found of polynomials with delays or powers of s, with their
    exponents, and of ``at_origin`` roots at 0; None if none is found."""
    # Interval Newton needs f' != 0: it encloses simple roots alone.
    simple = ring.constant(1)
    for factor, _ in factors:
        simple = simple * factor
    function = QuasiPolynomial.of(simple, ring)
    zeros = at_least(order_at_0(simple, ring))
    nonzero = [x for x in function.roots() if not zeros or abs(x) > _ORIGIN]
    every = [*nonzero, 0j] if at_origin else nonzero
    roots = tuple(sorted(every, key=lambda x: -x.real))
    if not roots:
        return None
    first = roots[0]
    # Floats do not order roots whose real parts differ by less than the strip: all roots in it are
    # enclosed, and the line of the proof runs left of them.
    strip_end = first.real - _STRIP * (1 + abs(first))
    following = next((x.real for x in roots if x.real < strip_end), -inf)
    in_strip = [x for x in roots if x.real > following]
    balls = [function.enclosed(x) if x else acb(0) for x in in_strip]
    # Which factor the rightmost root is of is not known any more: the largest exponent is safe. The
    # root at 0, which no factor has, counts where it lies in the strip.
    exponents = [n for _, n in factors]
    order = max(at_origin if following < 0 else 0, *exponents)
    if any(ball is None for ball in balls):
        return Rightmost(first, None, certified=False, function=function, others=roots, order=order)
    enclosure = _furthest(balls)
    certified = function.is_rightmost(nonzero, first, following, zeros)
    return Rightmost(_middle(enclosure), enclosure, certified, function, roots, order)


def _furthest(balls: Sequence[Any]) -> Any:
    """Return a ball for the rightmost of the roots in some balls: its real part contains those of
    all balls that may be it, its imaginary part is that of the one nearest to the real axis."""
    furthest = max(balls, key=lambda x: x.real.mid())
    level = [x for x in balls if x.real.overlaps(furthest.real)]
    # The union of the real parts holds the largest one whichever of the balls it belongs to.
    with flint.ctx.workprec(_BITS):
        real = reduce(arb.union, (x.real for x in level))
        imag = min((abs(x.imag) for x in level), key=arb.mid)
        return acb(real, imag)


def _middle(ball: Any) -> complex:
    """Return the middle of a ball as floats, with 0 for a part whose interval contains 0."""
    real, imag = ball.real, ball.imag
    x = 0.0 if real.contains(0) else float(real.mid())
    y = 0.0 if imag.contains(0) else float(imag.mid())
    return complex(x, y)


# Polynomials


def enclosed_roots(coefficients: Sequence[Any]) -> list[tuple[Any, int]]:
    """Return balls around all roots of a real polynomial p, with multiplicity: as many as its
    degree n. With each comes the number of balls in its group, which are those that overlap with
    it, directly or through others; the group contains as many roots as balls.

    ``coefficients`` : real balls, ascending, the first and the last of which are not 0; ValueError
    where that is not known. A single one has no roots.

    About any n different numbers x_i the discs |x - x_i| <= n |p(x_i)|/|a_n prod_{j != i} (x_i -
    x_j)|, a_n the highest coefficient, contain all roots, and a group of discs as many as it has
    discs (Smith, 1970, by Gershgorin's theorem). The x_i are the roots of a polynomial that is p
    but for its constant coefficient: where roots of p coincide, the x_i differ, and are near. A
    root whose ball overlaps with no other, and with the real axis, is real.
    """
    polynomial = acb_poly(coefficients)
    n = len(coefficients) - 1
    if n < 1:
        return []
    if coefficients[0].contains(0) or coefficients[n].contains(0):
        raise ValueError("a polynomial of which the degree, or a root at 0, is not known")
    perturbed = fmpq_poly([x.mid().fmpq() for x in coefficients])
    points = list[Any]()
    # Multiple roots come once: only n - 1 constant coefficients, at most, leave fewer than n.
    while len(points) < n:
        perturbed[0] *= 1 + fmpq(1, 2**_APART)
        points = [x.mid() for x, _ in perturbed.numer().complex_roots()]
    balls = []
    for i, x in enumerate(points):
        product = coefficients[n]
        for j, y in enumerate(points):
            if j != i:
                product = product * (x - y)
        # The radius of the disc about x_i, in balls, and rounded up. The square around the disc is
        # kept: real and imaginary part are then intervals.
        radius = n * abs(polynomial(x) / product)
        interval = arb(0, radius.upper())
        balls.append(acb(x.real + interval, x.imag + interval))
    # The coefficients are real, so the balls are conjugate in pairs. One that contains a real
    # number meets its own mirror image: if it meets no other ball, its one root is real.
    roots = list[tuple[Any, int]]()
    for group in _groups(balls):
        count = len(group)
        for x in group:
            is_real = count == 1 and x.imag.contains(0)
            roots.append((acb(x.real) if is_real else x, count))
    return roots


def _groups(balls: Sequence[Any]) -> list[list[Any]]:
    """Return the balls in groups: two that overlap, directly or through others, are in one."""
    groups = list[list[Any]]()
    for ball in balls:
        joined, apart = [ball], list[list[Any]]()
        for group in groups:
            if any(ball.overlaps(x) for x in group):
                joined += group
            else:
                apart.append(group)
        groups = [*apart, joined]
    return groups


# Quasi-polynomials


@dataclass(frozen=True)
class QuasiPolynomial:
    """A quasi-polynomial f(s) = sum of c s^p exp(-s lag), evaluated in floats and in balls.

    Powers are taken with the cut of the logarithm on the negative real axis. Coefficients are real,
    so that roots are conjugate in pairs.
    """

    terms: tuple[Term, ...]

    @classmethod
    def of(cls, polynomial: Polynomial, ring: Ring) -> QuasiPolynomial:
        """Return the function of a polynomial of a ring without symbols for parameters."""
        merged: dict[tuple[Rational, Expr], Expr] = {}
        # Several powers of pi may stand before one power of s: as one term their sum may cancel.
        for t in _terms(polynomial, ring):
            key = t.power, t.lag
            merged[key] = merged.get(key, Integer(0)) + t.coefficient
        terms = [Term(c, power, lag) for (power, lag), c in merged.items()]
        return cls(tuple(terms))

    @cached_property
    def chain(self) -> float | None:
        """The largest real part to which infinitely many roots tend, in floats; None where there
        are no such roots, or where it is not computed.

        Such a neutral chain of roots exists where the highest power of s has delayed terms. For
        large |s| the roots tend to those of its coefficient, the sum of all c exp(-s lag). That is
        computed if the delays are multiples of one unit: then it is a polynomial in x = exp(-s
        unit), and Re s = -ln|x|/unit.
        """
        degree = max(t.power for t in self.terms)
        leading = {t.lag: float(t.coefficient) for t in self.terms if t.power == degree}
        first = min(leading, key=float)
        # Without the delay that all terms share, which has no roots.
        later = {(lag - first).expand(): c for lag, c in leading.items() if lag != first}
        if not later:
            return None
        unit = _common_measure(later)
        if unit is None:
            return None
        degree_in_x = max(later, key=float) / unit
        if degree_in_x > _MOST_POWER:
            return None
        ascending = np.zeros(int(degree_in_x) + 1)
        ascending[0] = leading[first]
        for lag, c in later.items():
            ascending[int(lag / unit)] = c
        x = np.roots(ascending[::-1])
        largest = max(-np.log(np.abs(x)))
        return float(largest / float(unit))

    @cached_property
    def _floats(self) -> tuple[Array, Array, Array]:
        """The coefficients, powers and delays of all terms."""
        c = np.array([float(t.coefficient) for t in self.terms])
        p = np.array([float(t.power) for t in self.terms])
        lag = np.array([float(t.lag) for t in self.terms])
        return c, p, lag

    @cached_property
    def _balls(self) -> list[tuple[Any, Rational, Any]]:
        """The coefficient, power and delay of each term; the first and the last as balls."""
        balls = []
        with flint.ctx.workprec(_BITS):
            for t in self.terms:
                coefficient = expression_ball(t.coefficient)
                balls.append((coefficient, t.power, expression_ball(t.lag)))
        return balls

    def values(self, s: Array) -> tuple[Array, Array]:
        """Return the function and its derivative at some points, both divided by the modulus of the
        largest term there.

        Newton's step, their quotient, is unchanged by that, and no exponential overflows.
        """
        c, p, lag = self._floats
        # A row for each point, a column for each term: the logarithm of the term's modulus and its
        # phase, but for the sign of c.
        column = s[:, None]
        logs = np.log(np.abs(c)) + p * np.log(column) - lag * column
        largest = logs.real.max(axis=1, keepdims=True)
        terms = np.sign(c) * np.exp(logs - largest)
        slopes = terms * (p / column - lag)
        return terms.sum(axis=1), slopes.sum(axis=1)

    def roots(self) -> list[complex]:
        """Return the different roots with Im s >= 0 at which Newton's iteration in floats ends,
        from many starts, and 0 first if it is one; roots may be missing."""
        s = self._starts()
        with np.errstate(all="ignore"):
            for _ in range(_ITERATIONS):
                value, slope = self.values(s)
                step = value / slope
                size = np.abs(step)
                # Far from a root, where f' is small, the step would leap.
                longest = _LONGEST_STEP * np.abs(s) + 1e-12
                s = s - np.where(size > longest, step * longest / size, step)
            # A start that ran into a pole of the step is nan, and not finite here.
            value, slope = self.values(s)
            last_step = np.abs(value / slope)
            is_small = last_step < _CONVERGED * np.abs(s) + 1e-13
            ends = s[np.isfinite(value) & is_small]
        has_root_at_0 = min(t.power for t in self.terms) > 0
        roots: list[complex] = [0j] if has_root_at_0 else []
        for x in sorted(map(complex, ends), key=lambda x: -x.real):
            is_complex = abs(x.imag) > _REAL * abs(x)
            root = complex(x.real, abs(x.imag) if is_complex else 0)
            least_distance = _SAME * (abs(root) + 1e-9)
            if all(abs(root - y) > least_distance for y in roots):
                roots.append(root)
        return roots

    def _starts(self) -> Array:
        """Return starts of Newton's iteration with Im s >= 0."""
        _, _, lags = self._floats
        longest = lags.max(initial=0.0)
        shortest = min((x for x in lags if x > 0), default=0.0)
        # Rays over all sizes of haptic devices, eight points a decade, most of the rays close to
        # the imaginary axis: there lie the lightly damped roots, of which one is the rightmost.
        sizes = np.geomspace(1e-2, 1e5, 57)
        half_turns = np.array([0.0, 0.2, 0.4, 0.47, 0.5, 0.53, 0.6, 0.8, 0.99])
        rays = np.exp(1j * np.pi * half_turns)
        starts = [np.multiply.outer(sizes, rays).ravel()]
        # The roots of a delay are about 2 pi/lag apart along the imaginary axis, with real parts of
        # some 1/lag: a grid of these units, four heights between two such roots.
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
        value = acb(0)
        slope = acb(0)
        for c, p, lag in self._balls:
            delayed = c * (-lag * s).exp()
            power = _power(s, p)
            value += delayed * power
            slope += delayed * (_slope_of_power(s, p) - lag * power)
        return value, slope

    def enclosed(self, near: complex) -> Any:
        """Return a ball that is proven to contain exactly one root, by interval Newton from a float
        ``near`` it; None where that is not proven."""
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
            size = abs(middle).mid() + arb(2) ** -40
            radius = arb(2) ** -100 * size
            for _ in range(40):
                interval = arb(0, radius)
                box = acb(middle.real + interval, middle.imag + interval)
                value, slope = self._sum(box)
                if slope.contains(0):
                    return None
                image = middle - self.ball(middle) / slope
                if box.contains_interior(image):
                    return image
                radius *= 4
        return None

    # The proof that no root is further right

    def is_rightmost(
        self, found: Sequence[complex], first: complex, following: float, at_0: int
    ) -> bool:
        """Whether it is proven that the roots right of a line Re s = line, which lies between the
        real parts ``following`` and that of ``first``, are those of ``found`` there and no others.
        False proves nothing.

        ``found`` : roots with Im s >= 0, 0 not among them. ``first`` : the rightmost root of all.
        ``following`` : the largest real part of those roots that are not to lie right of the line,
        -inf where there are none. ``at_0`` : the multiplicity of 0 as a root.

        The proof, for the half plane R = {Re s > line}:

        1. Each root in R has |s| < radius (``_radius``). So it lies in the box of all s with line <
           Re s < max(line, 0) + radius and |Im s| < radius.
        2. By the argument principle the number N of roots in the box, with multiplicity, is the
           number of turns of f along its border (``_count_right_of``).
        3. Each root of ``found`` in R, and its conjugate, is the only root in a ball in R, 0 is in
           none of these balls, and no two of them overlap. So they are different roots; 0 adds
           ``at_0`` more if it lies in R.
        4. If that makes N, there are no others.
        """
        # Halfway to the next roots, as on the contour it must be shown that f is not 0, and near a
        # root that takes many pieces. The gap is bounded where no other root was found.
        gap = min(first.real - following, 0.2 * abs(first) + 1e-3)
        line = first.real - gap / 2
        if line <= 0 and any(not t.power.is_Integer for t in self.terms):
            return False  # powers of s have a cut on the negative real axis
        right_of_line = [x for x in found if x.real > line]
        balls = [ball for x in right_of_line for ball in self._both(x)]
        for ball in balls:
            if ball is None or not ball.real > line:
                return False
            if at_0 and ball.contains(0):
                return False
        if any(x.overlaps(y) for x, y in combinations(balls, 2)):
            return False
        known = len(balls)
        if line < 0:
            known += at_0
        return self._count_right_of(line) == known

    def _both(self, root: complex) -> list[Any]:
        """Return a ball around a root, and one around its conjugate where it is not real; None
        in the list where a root is not enclosed."""
        ball = self.enclosed(root)
        if ball is None or root.imag == 0:
            return [ball]
        return [ball, ball.conjugate()]

    def _count_right_of(self, line: float) -> int | None:
        """Return the number of roots with Re s > line, with multiplicity; None where it is not
        proven.

        By the argument principle: f has no poles in the box of ``is_rightmost``, which contains all
        of these roots, so that it turns once about 0 along the border for each of them.
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
            total = arb(0)
            allowance = [_MOST_PIECES]
            for a, b in pairwise([*corners, corners[0]]):
                turned = self._turned(a, b, allowance)
                if turned is None:
                    return None
                total += turned
            turns = total / (2 * arb.pi())
        whole = round(float(turns))
        return whole if abs(turns - whole) < arb(1) / 4 else None

    def _turned(self, start: complex, end: complex, allowance: list[int]) -> Any:
        """Return a ball around the change of arg f along the segment from ``start`` to ``end``,
        rad; None where the pieces are not enough. ``allowance`` : one number, the pieces that may
        still be used, which goes down by those that are."""
        segment = acb(start.real, start.imag), acb(end.real, end.imag)
        total = arb(0)
        pieces = Waiting([segment])
        for a, b in pieces:
            allowance[0] -= 1
            if allowance[0] < 0:
                return None
            over = self.ball(a.union(b))
            middle = over.mid()
            # Over the piece f stays in the half plane around f's middle value: its argument
            # relative to that lies in (-pi/2, pi/2), where the principal value has no jump.
            if not over.contains(0) and (over / middle).real > 0:
                begin = self.ball(a) / middle
                stop = self.ball(b) / middle
                total += stop.arg() - begin.arg()
                continue
            half = ((a + b) / 2).mid()
            pieces.add((a, half), (half, b))
        return total

    def _radius(self, line: float) -> float | None:
        """Return a modulus r such that no root with Re s >= line has |s| >= r; None where none is
        found.

        Where Re s >= line, |c s^p exp(-s lag)| <= |c| |s|^p exp(-lag line). Let n be the highest
        power, and ``floor`` the modulus of its coefficient without a delay, less those bounds of
        its delayed terms over |s|^n. Then |f|/|s|^n >= floor - sum of |c| exp(-lag line)
        |s|^(p - n) over all lower powers p, which grows with |s|: if it is positive for |s| = r, f
        has no root at or beyond.
        """
        degree = max(t.power for t in self.terms)
        with flint.ctx.workprec(_BITS):
            floor = arb(0)
            lower_terms = []
            for c, p, lag in self._balls:
                bound = abs(c) * (-lag * line).exp()
                if p < degree:
                    lower_terms.append((bound, expression_ball(p - degree)))
                else:
                    floor += abs(c) if lag == 0 else -bound
            # A power of two is exact as a float.
            for n in range(_MOST_DOUBLINGS):
                radius = arb(2) ** (n - 10)
                rest = arb(0)
                for bound, power in lower_terms:
                    rest = rest + bound * radius**power
                if floor > rest:
                    return float(radius)
        return None


def _terms(polynomial: Polynomial, ring: Ring) -> Iterator[Term]:
    """Yield the terms of a polynomial of a ring. Its exponents are of s, of pi, then of the unit
    delays exp(-s lag), then of the powers s^order."""
    lags = len(ring.lags)
    for exponents, value in polynomial.to_dict().items():
        powers = [int(n) for n in exponents]
        of_delays = powers[ring.size : ring.size + lags]
        of_orders = powers[ring.size + lags :]
        lag = Integer(0)
        for n, x in zip(of_delays, ring.lags, strict=True):
            lag += n * x
        power = Integer(powers[0])
        # Not strict: a generator that stands for j may follow the powers of s.
        for n, x in zip(of_orders, ring.orders, strict=False):
            power += n * x
        number = Rational(int(value.p), int(value.q))
        # The generator after s stands for pi.
        power_of_pi = ring.meanings[1] ** powers[1]
        yield Term(number * power_of_pi, power, lag)


def _common_measure(lags: Iterable[Expr]) -> Rational | None:
    """Return the largest number that all lags are whole multiples of; None where there is none, as
    their ratios are not all rational."""
    first, *others = lags
    ratios = [lag / first for lag in others]
    if not all(x.is_Rational for x in ratios):
        return None
    denominator = lcm(*(int(x.q) for x in ratios))
    multiples = [int(x * denominator) for x in ratios]
    numerator = gcd(denominator, *multiples)
    return first * Rational(numerator, denominator)


def _power(s: Any, p: Rational) -> Any:
    """Return a ball around s^p."""
    if p.is_Integer:
        return s ** int(p)
    return (s.log() * expression_ball(p)).exp()


def _slope_of_power(s: Any, p: Rational) -> Any:
    """Return a ball around p s^(p - 1), the derivative of s^p."""
    if p == 0:
        return acb(0)
    factor = int(p) if p.is_Integer else expression_ball(p)
    return factor * _power(s, p - 1)


# Sampled loops


def clocked_root(scene: Scene, hand: Hand) -> Rightmost | None:
    """Return s = ln z/T for the largest root z of the sampled loop of a scene in a hand; None where
    its polynomial is not known, or has no root.

    It is ``certified``: the loop is a polynomial in w = 1/z, all of whose roots are enclosed.
    """
    try:
        loop = loop_of(scene, hand)
        with flint.ctx.workprec(_POLYNOMIAL_BITS):
            roots = enclosed_roots(loop.balls())
            T = expression_ball(loop.T)
            # s = ln z/T = -ln w/T: a ball around w that contains 0 has no logarithm.
            if any(w.contains(0) for w, _ in roots):
                return None
            in_s = [(-w.log() / T, order) for w, order in roots]
    except (UndecidedError, ValueError):
        return None
    return Rightmost.of_all(in_s) if in_s else None
