"""All values of a parameter q that put a root of a loop on the imaginary axis, and the frequencies
of these roots, for a q that is in coefficients alone.

**Question.** C(s; q) is the characteristic function of the loop (``loops``), here a polynomial in q
whose coefficients are polynomials in s, delays exp(-s lag) and powers s^alpha. For which real q is
C(j omega; q) = 0 at some omega > 0? These are the *critical values*, at which the number of roots
in Re s >= 0 may change.

**Method.** Re C = 0 and Im C = 0 are two real equations in omega and q. q is eliminated, which
leaves a *condition*, one function of omega that is 0 at each root, and the *value* of q there:

- *Degree 1*, C = A + q B: the equation is q = g(j omega) with g = -A/B. As q is real, the condition
  is Im g = 0 and the value Re g. (The D-decomposition; Neimark 1948.) Where A/B is real on all of
  the axis there is a root on it for each q that Re g takes: these intervals of q end where d(Re
  g)/d omega = 0, which then is the condition.
- *Higher degrees*: at a frequency at which Re C and Im C have a common root q, their resultant by
  q, a function of omega, is 0. The last remainder of Euclid's algorithm before it, c0 + c1 q with
  functions c0 and c1 of omega, is u Re C + v Im C with polynomials u and v in q, so that it has the
  common root too: q = -c0/c1. (Up to a factor it is the first subresultant; von zur Gathen and
  Gerhard, Modern Computer Algebra, chapter 6.)

**Guaranteed.** ``CrossingCurve.roots`` returns all critical values with 0 < omega <= a given
frequency, proven, but for those of a common factor of Re C and Im C (``_by_resultant`` says why no
verdict depends on them). Roots at omega = 0 and from infinity are found elsewhere (``critical``).
UndecidedError where elimination gives no single q for each frequency, or where a root that touches
the axis cannot be distinguished from one that stays away.

Begin with ``curve_of``, which makes the ``CrossingCurve`` of a loop, and with its ``roots``.

**Functions of omega** here are rational functions of an ``Axis``: quotients of polynomials in
omega, t = tan(omega lag/2) for each *unit delay* (all delays of a loop are sums of whole multiples
of these, ``loops``), and fractional powers of omega. On s = j omega, exp(-s lag) is
(1 - j t)/(1 + j t). A *chart* (``kernel.roots``) has all zeros and poles of such functions on a
band, and the signs between, proven; an *asymptotic sign* is the sign above some frequency, the
``radius``, proven as well.

**Half turns** are the frequencies at which omega lag is an odd multiple of pi: exp(-s lag) is -1
there, and t has a pole. A function of omega that is finite there has a value all the same, its
limit for t -> infinity, and a chart counts its zeros there: numerator and denominator are read as
homogeneous polynomials in cos(omega lag/2) and sin(omega lag/2). A polynomial in t alone has its
limit at infinity there instead, so that a zero of C would be lost (``_at_half_turns``).
"""

from __future__ import annotations

from dataclasses import dataclass

from sympy import Expr, Integer, pi

from haptisym.judge.peaks import ValueAt
from haptisym.kernel.asymptoticsign import Sense, asymptotic_sign, sign_without_zeros
from haptisym.kernel.axis import Axis
from haptisym.kernel.dynamics import RealFunction, on_axis, squared_modulus
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.rings import Polynomial, RationalFunction, coefficients
from haptisym.kernel.roots import Point, chart
from haptisym.verbs.stability.loops import CriticalRoot, Loop

_UNDECIDED = "where roots meet the imaginary axis"


def curve_of(loop: Loop) -> CrossingCurve | None:
    """The curve of a loop with q in its coefficients; None where C does not depend on q.

    Its condition is the function 0 where A/B is one real number: a single q then puts roots on the
    axis, at every omega. UndecidedError where elimination does not give one q for each frequency.
    """
    # A, B, ...: those of q^0, q^1, ...
    of_powers = loop.coefficients
    if len(of_powers) < 2:
        return None
    if len(of_powers) == 2:
        ratio = RationalFunction(loop.ring, *of_powers).reduced()
        # Not reduced: over |B|^2, so that their signs are those of their numerators.
        response = on_axis(ratio)
        value, condition = -response.raw_real, response.raw_imag
        square = squared_modulus(ratio).function
        curve = CrossingCurve(condition, value, square, is_linear=True)
    else:
        curve = _by_resultant(loop)
    return curve if not curve.condition.is_zero else _of_real_ratio(curve)


# The names under which the functions of a curve are on a chart (``kernel.roots``).
_CONDITION, _VALUE, _SHARED = "condition", "value", "shared"
_REMAINDER = ("c0", "c1")


@dataclass(frozen=True)
class CrossingCurve:
    """Where a loop has a root at j omega for some real q: at the zeros of ``condition``, and there
    q = ``value``.

    ``square`` : the square of that q, at a zero of the condition. For A + q B it is |A/B|^2:
    whether it is above or below a number at high frequency is often known, although the value
    itself, -Re(A/B), swings with the phase of the delays. ``critical`` bounds with it the
    frequencies at which q can be in an interval.
    ``is_linear`` : whether C is A + q B and g = value - j condition.
    ``remainder`` : c0 and c1 where it is not proven once for all that both are 0 at no zero of the
    condition; else empty.

    Condition, value and square are functions of omega whose denominators are squares or sums of
    squares, so that the sign of such a function is that of its numerator, as ``asymptotic_sign``
    needs it.
    """

    condition: RationalFunction
    value: RationalFunction
    square: RationalFunction
    is_linear: bool = False
    remainder: tuple[RationalFunction, ...] = ()

    def roots(self, reach: Expr) -> tuple[CriticalRoot, ...]:
        """All critical values with a root at 0 < omega <= ``reach``, rad/s, each with its frequency
        and sense.

        At omega = 0 the condition is 0 for every q, C being real there, and tells nothing.
        UndecidedError where a chart cannot say whether the condition has a zero, and where c0 and
        c1 are both 0 at one: any q may have a root on the axis there.
        """
        value = RealFunction(self.value.reduced())
        functions = {_CONDITION: RealFunction(self.condition.reduced()), _VALUE: value}
        # The remainder may be empty.
        for name, function in zip(_REMAINDER, self.remainder, strict=False):
            functions[name] = RealFunction(function.reduced())
        points = chart(functions, Integer(0), reach).points
        if any(_CONDITION in point.undecided for point in points):
            raise UndecidedError("whether a root touches the imaginary axis")
        roots = list[CriticalRoot]()
        # The first point is omega = 0.
        for point in points[1:]:
            if point.orders.get(_CONDITION, 0) <= 0:
                continue
            if self.remainder and all(_may_vanish(name, point) for name in _REMAINDER):
                raise UndecidedError(_UNDECIDED)
            # At a pole of the value no q puts a root on the axis: A + q B has B = 0 and A not 0
            # there, and c0 + c1 q, 0 at every common root, has c1 = 0 and c0 not 0.
            order_of_value = point.orders.get(_VALUE, 0)
            if order_of_value >= 0:
                q = ExactNumber(Integer(0)) if order_of_value else ValueAt(value, point.omega)
                roots.append(CriticalRoot(q, omega=point.omega, sense=self._sense(point)))
        return tuple(roots)

    @property
    def radius(self) -> Expr | None:
        """A frequency, rad/s, above which the condition has no zero; None where none is proven, as
        where it has zeros at arbitrarily high frequencies."""
        at_infinity = sign_without_zeros(self.condition)
        is_settled = at_infinity.sense in (Sense.POSITIVE, Sense.NEGATIVE)
        return at_infinity.radius if is_settled else None

    def _sense(self, point: Point) -> int | None:
        """How many pairs of roots go to the right at a zero of the condition as q increases, -1 for
        one that goes to the left; None where C is not linear in q.

        The root is where g(s) = q. g is analytic, so it maps what is on the right of the axis, seen
        along increasing omega, to the right of the curve g(j omega). Where Im g rises through 0
        that is the side of larger q: as q increases the root goes to the right. (At a simple zero
        ds/dq = 1/g', and d Im g(j omega)/d omega = Re g'.) Where Im g falls it goes to the left,
        and where Im g has no change of sign none crosses.
        """
        if not self.is_linear:
            return None
        # The condition is -Im g: it falls where Im g rises.
        return (point.before[_CONDITION] - point.after[_CONDITION]) // 2


def _may_vanish(name: str, point: Point) -> bool:
    """Whether a function is 0 at a point of a chart, or that is not known."""
    return point.orders.get(name, 0) > 0 or name in point.undecided


def _of_real_ratio(curve: CrossingCurve) -> CrossingCurve:
    """The curve where A/B is real on all of the axis: roots lie on the axis for all values of g,
    and leave it in pairs where two meet, at the extrema of g."""
    slope = RealFunction(curve.value.reduced()).derivative().function
    # Over the square of its denominator, so that its sign is that of its numerator.
    numerator, square = slope.numerator * slope.denominator, slope.denominator**2
    condition = slope.ring.function(numerator, square)
    return CrossingCurve(condition, curve.value, curve.square)


# Elimination for degrees above 1


def _by_resultant(loop: Loop) -> CrossingCurve:
    """The curve of a C of degree 2 or more in q.

    A common factor h(omega, q) of Re C and Im C is divided out, as with it the resultant would be 0
    everywhere. Critical values that h has are not on the curve: of (s^4 + q s^2 + 1)(s^2 + q s +
    q^2 + 1), q = 2. They change the number of roots in Re s >= 0 (here from 2 to 4), but not
    whether it is 0. For let h hold no power s^alpha, else UndecidedError, and take any q:

    1. h, times powers of cos(omega lag/2), is an exponential polynomial: a sum of terms c omega^n
       exp(b s) with real b. That is meant by h from here on; it is real for real omega.
    2. So with omega its conjugate is a zero (Schwarz reflection): with s = j omega also -conj(s).
       One of both is in Re s >= 0. If h has a zero for that q, C has a root there.
    3. If h has none, it is exp(a + b s), as an entire function of order 1 (Hadamard). b is real by
       1, and then it is real on the axis for b = 0 alone: h is constant in s. So the coefficient L
       of the highest power of s in C is 0, and q one of ``neutralchains.from_infinity``.

    An h of q alone is 0 where there is no loop.
    """
    axis = loop.ring.axis
    # As polynomials in omega, pi, q, then t of each angle, then each omega^alpha; ``index`` : the
    # number of the variable q.
    [(real, imag)] = axis.parts([loop.numerator])
    index = axis.meanings.index(loop.symbol)
    common = real.gcd(imag)
    degrees = common.degrees()
    has_power = any(degrees[axis.size + len(axis.angles) :])
    if degrees[index] and has_power:
        raise UndecidedError(_UNDECIDED)
    real, imag = real / common, imag / common
    resultant = real.resultant(imag, f"x{index}")
    linear = _linear_remainder(real, imag, index)
    if resultant.is_zero() or linear is None:
        raise UndecidedError(_UNDECIDED)
    c0, c1 = linear
    # At a common zero of resultant and c1, Re C and Im C may have more than one common root q, and
    # c0 + c1 q gives none.
    if not _are_apart(resultant, c1, axis):
        raise UndecidedError(_UNDECIDED)
    remainder: tuple[RationalFunction, ...] = ()
    if not _are_never_zero_together(resultant, c1, axis):
        remainder = axis.function(c0), axis.function(c1)
    return CrossingCurve(
        condition=_at_half_turns(resultant, real, imag, index, axis),
        value=axis.function(-c0 * c1, c1 * c1),
        square=axis.function(c0 * c0, c1 * c1),
        remainder=remainder,
    )


def _at_half_turns(
    resultant: Polynomial, real: Polynomial, imag: Polynomial, index: int, axis: Axis
) -> RationalFunction:
    """The resultant of two polynomials by the variable q, the one of number ``index``, as a
    function of omega that has its zeros at half turns too.

    Let M be the larger degree of both in a tangent t, and n and m their degrees in q.

    1. Over (1 + j t)^M, nowhere 0 for real t, both are finite at half turns, t -> infinity.
    2. The resultant is a determinant of Sylvester's, homogeneous of degree m in the coefficients of
       the one and n in those of the other. So over t^D, D = (m + n) M, it is finite at half turns,
       and that limit is the resultant of the two limits.
    3. If its own degree in t is D, the limit is not 0, as a coefficient that is a function of omega
       beside t: the resultant is returned as it is.
    4. If its degree is less, the limit is 0 at all half turns. Then its square over (1 + t^2)^D is
       returned: 0 at all half turns, and elsewhere where the resultant is.

    At the zeros of 4 the value -c0/c1 is the one common root q of both if their leading
    coefficients in t have no common factor of a higher degree in q; else UndecidedError. (The
    coefficient of 3 may be 0 at single half turns, if omega/pi is a number that the coefficients
    hold: these are undecided on a chart.)
    """
    condition = axis.function(resultant)
    sizes = [p.degrees() for p in (real, imag)]
    for i in range(axis.size, axis.size + axis.delays):  # the tangent of each unit delay
        largest = max(degrees[i] for degrees in sizes)
        degree = largest * sum(degrees[index] for degrees in sizes)
        if resultant.degrees()[i] == degree:
            continue
        first, second = (_coefficient(p, i, largest) for p in (real, imag))
        if first.gcd(second).degrees()[index] > 1:
            raise UndecidedError(_UNDECIDED)
        circle = axis.context.gens()[i] ** 2 + 1
        condition = condition * condition / axis.function(circle**degree)
    return condition


def _coefficient(polynomial: Polynomial, index: int, power: int) -> Polynomial:
    """The coefficient of a power of the variable of number ``index``, 0 where there is none."""
    rows = coefficients(polynomial, index)
    return rows[power] if power < len(rows) else 0 * polynomial


def _are_apart(f: Polynomial, g: Polynomial, axis: Axis) -> bool:
    """Whether no common factor of two polynomials has a zero omega > 0; False proves nothing."""
    shared = axis.function(f.gcd(g))
    at_infinity = asymptotic_sign(shared)
    if at_infinity.sense not in (Sense.POSITIVE, Sense.NEGATIVE):
        return False
    reach = max(at_infinity.radius, Integer(1))
    table = chart({_SHARED: RealFunction(shared)}, Integer(0), reach)
    is_zero = any(x.orders.get(_SHARED) for x in table.points[1:])
    return not table.undecided and not is_zero


def _are_never_zero_together(f: Polynomial, g: Polynomial, axis: Axis) -> bool:
    """Whether two polynomials that are apart (``_are_apart``) have no common zero omega > 0; False
    proves nothing.

    Without a common factor they are 0 together at finitely many pairs (omega, t), or for finitely
    many values of pi.

    - With neither delays nor fractional powers: these values of pi are algebraic, and pi is not.
    - With one lag, and no pi in coefficients and lag: omega and t are algebraic, but
      tan(omega lag/2) of an algebraic number that is not 0 is transcendental (Lindemann).

    With roots of numbers nothing is known: sqrt(2) is a variable of the ring, so that polynomials
    without a common factor there may have one, as x^2 - 2 and x - sqrt(2) have.
    """
    if axis.orders or axis.delays > 1 or axis.root_in(f, g) is not None:
        return False
    has_pi = any(p.degrees()[axis.meanings.index(pi)] for p in (f, g))
    return not axis.delays or not (has_pi or axis.lags[0].has(pi))


def _linear_remainder(
    f: Polynomial, g: Polynomial, index: int
) -> tuple[Polynomial, Polynomial] | None:
    """The first remainder of degree 1 in the variable x of number ``index``, c0 + c1 x, in Euclid's
    algorithm for f and g, as (c0, c1): f or g itself if it is one already. None where no remainder
    has degree 1."""
    if len(coefficients(f, index)) < len(coefficients(g, index)):
        f, g = g, f
    # The degree of f is never below that of g, the remainder, and that of g falls.
    while not g.is_zero():
        rows = coefficients(g, index)
        if len(rows) <= 2:
            return (rows[0], rows[1]) if len(rows) == 2 else None
        f, g = g, _pseudo_remainder(f, g, index)
    return None


def _pseudo_remainder(f: Polynomial, g: Polynomial, index: int) -> Polynomial:
    """The remainder of f by g in the variable of number ``index``, times powers of g's leading
    coefficient, so that no fraction arises."""
    a, b = coefficients(f, index), coefficients(g, index)
    x = f.context().gens()[index]
    while len(a) >= len(b) and not f.is_zero():
        shifted = x ** (len(a) - len(b)) * g
        f = b[-1] * f - a[-1] * shifted
        a = coefficients(f, index)
    return f
