"""Re and Im of a perceived dynamics on s = j omega, each in the shortest of three closed forms.

**Problem.** H_perc of a chain of n effects is one quotient of polynomials (``model.chain``). On s =
j omega its real and imaginary part can be written in several ways, which are equal and differ in
length. Which one does a person read?

**Forms.**

- In *lowest terms*: a single fraction without common factors, as polynomials in the variables of
  its ring. It is the only such fraction, up to a number that both its parts are multiplied by,
  where the variables are independent. ``kernel.dynamics.Ring.of`` makes them so, but for powers
  s^alpha, and delays whose common unit is below a 32nd of the longest, which it takes as
  independent of s and of each other. For n effects with parameters of their own the fraction has
  some 2^n terms.
- In *magnitudes and angles*, for effects in series. B = C = 0 in their chain matrices: the force
  becomes A F, the motion D X, and so H becomes G H with G = A/D. With H_rendered = r_0 exp(j
  phi_0) and G_i = r_i exp(j phi_i) on the axis,

      H_perc = r_0 r_1 ... r_n exp(j (phi_0 + phi_1 + ... + phi_n)),

  which grows by one magnitude and one angle for each effect. Each r is real: a square root of a sum
  of two squares, or signed. It is signed for a factor that is real or imaginary on the axis (k + m
  s^2 is k - m omega^2, with the angle 0), and for a hold exp(s T) - 1, which is 2 sin(omega T/2)
  with the angle of j exp(j omega T/2).
- As the chain builds it: Re or Im, not computed, of fractions within fractions in j omega.

**Guaranteed.** All are identities, for all positive values of the parameters at which no
denominator vanishes. Not covered, in magnitudes and angles, is a zero of a factor that is neither
real nor imaginary on the axis (1 + s exp(-s T) has some for single values of T): its angle is
atan2(0, 0) there. ``shortest`` compares lengths, which changes no value.

Begin with ``shortest``. Named steps, which are short for every chain, are ``Chain.steps``.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from sympy import Add, Expr, I, Integer, Mul, atan2, cos, count_ops, exp, im, pi, re, sin, sqrt

from haptisym.kernel.dynamics import Ring, on_axis
from haptisym.kernel.rings import RationalFunction, omega, s
from haptisym.model.chain import Chain
from haptisym.model.jnd import Part

# Which closed form is made, by the number of terms of numerator and denominator of the dynamics
# together: Re and Im in lowest terms have about its square. The numbers are what is readable (ten)
# and what takes seconds at most; they choose between equal formulas alone.
_ALWAYS_LOWEST = 10
"""Up to here lowest terms are taken as they are."""
_MOST_COMPARED = 80
"""Up to here lowest terms are compared with the form in magnitudes and angles."""
_MOST_LOWEST = 300
"""Up to here lowest terms are taken where the effects are not in series."""
_FACTOR_FOR_LOWEST = 1.3
"""Lowest terms are preferred up to this many times the operations of another form."""


def shortest(
    dynamics: RationalFunction,
    lowest_terms: Callable[[], Expr],
    other_form: Callable[[], Expr],
    *,
    in_series: bool,
) -> tuple[Expr, bool]:
    """The shorter of two equal forms of Re or Im of a dynamics; and whether that is the one in
    lowest terms. Lowest terms are preferred where they are short, and not made where that would
    take long.

    ``lowest_terms`` : makes the form in lowest terms.
    ``other_form`` : makes the other one, in magnitudes and angles if all effects are ``in_series``,
    else Re or Im of H_perc as the chain builds it.
    """
    terms = len(dynamics.numerator) + len(dynamics.denominator)
    if terms <= _ALWAYS_LOWEST or (terms <= _MOST_LOWEST and not in_series):
        return lowest_terms(), True
    other = other_form()
    if terms > _MOST_COMPARED:
        return other, False
    reduced = lowest_terms()
    return (reduced, True) if prefers_lowest(reduced, other) else (other, False)


def prefers_lowest(reduced: Expr, other: Expr) -> bool:
    """Whether a form in lowest terms is preferred to another one of the same function: it shows
    leading powers of omega, which a few operations are worth."""
    return bool(count_ops(reduced) <= _FACTOR_FOR_LOWEST * count_ops(other))


_COSINE_OR_SINE = {Part.REAL: cos, Part.IMAG: sin}
_PART_OF = {Part.REAL: re, Part.IMAG: im}


def part_of_distortion(chain: Chain, part: Part, environment: Expr) -> Expr:
    """Re or Im of dH = H_perc - H_env, that of H_perc in magnitudes and angles if the effects are
    in series, else as the chain builds it.

    ``environment`` : that part of H_env(j omega).
    """
    if not chain.in_series:
        return _PART_OF[part](_as_built(chain), evaluate=False) - environment
    return _part_of_product(part, [chain.rendered, *_gains(chain)]) - environment


def part_of_relative(chain: Chain, part: Part) -> Expr:
    """Re or Im of dH/H_env = H_perc/H_env - 1, that of the quotient in magnitudes and angles if the
    effects are in series, else as the chain builds it."""
    one = Integer(part is Part.REAL)
    if not chain.in_series:
        H = chain.environment.xreplace({s: I * omega})
        return _PART_OF[part](_as_built(chain) / H, evaluate=False) - one
    # Where the environment itself is rendered, H_perc/H_env is the product of the gains alone.
    factors = _gains(chain)
    if chain.rendered != chain.environment:
        factors = [chain.rendered, 1 / chain.environment, *factors]
    return _part_of_product(part, factors) - one


def _as_built(chain: Chain) -> Expr:
    """H_perc(j omega) as the chain builds it: fractions within fractions."""
    H = chain.rendered
    for a, b, c, d in chain.matrices:
        H = (a * H + b) / (c * H + d)
    return H.xreplace({s: I * omega})


def _gains(chain: Chain) -> list[Expr]:
    """The factors G_i = A/D by which effects in series multiply the dynamics behind them."""
    return [a / d for a, _, _, d in chain.matrices]


def _part_of_product(part: Part, factors: Sequence[Expr]) -> Expr:
    """Re or Im of a product on s = j omega: the product of the magnitudes of its factors times the
    cosine or sine of the sum of their angles."""
    polar = [_polar(x) for x in factors]
    magnitude = Mul(*(size for size, _ in polar))
    angle = Add(*(phase for _, phase in polar))
    return magnitude * _COSINE_OR_SINE[part](angle)


def _polar(product: Expr) -> tuple[Expr, Expr]:
    """Magnitude r, which may be negative, and angle, rad, of a product of factors on s = j omega:
    the product is r exp(j angle)."""
    numerator, denominator = product.as_numer_denom()
    factors = [(x, 1) for x in Mul.make_args(numerator)]
    factors += [(x, -1) for x in Mul.make_args(denominator)]
    magnitude, angle = Integer(1), Integer(0)
    for factor, sign in factors:
        # exp(-s tau) is a factor of its own: SymPy would call it the power -s tau of e.
        is_exponential = isinstance(factor, exp)
        base, power = (factor, Integer(1)) if is_exponential else factor.as_base_exp()
        if not power.is_Integer:
            base, power = factor, Integer(1)
        base_magnitude, base_angle = _polar_of_one(base)
        n = sign * power
        magnitude *= base_magnitude**n
        angle += base_angle * n
    return magnitude, angle


def _polar_of_one(x: Expr) -> tuple[Expr, Expr]:
    """Magnitude and angle, as of ``_polar``, of one factor: a delay, a power of s, the numerator of
    a hold, or any polynomial."""
    if isinstance(x, exp):
        # A delay exp(s a): magnitude 1, angle omega a.
        advance = x.args[0] / s
        if not advance.has(s):
            return Integer(1), omega * advance
    else:
        base, power = x.as_base_exp()
        if base == s and not power.has(s):
            return omega**power, pi * power / 2
    # A hold: +-(exp(s T) - 1) = +-exp(s T/2) 2 sinh(s T/2), and sinh(j y) = j sin y.
    for sign, exponential in ((1, x + 1), (-1, 1 - x)):
        if isinstance(exponential, exp):
            period = exponential.args[0] / s
            if not period.has(s):
                phase = omega * period
                return 2 * sign * sin(phase / 2), (pi + phase) / 2
    ring = Ring.of([x])
    response = on_axis(ring.convert(x))
    real = response.real.function.reduced().expression()
    imag = response.imag.function.reduced().expression()
    # A factor on one axis keeps its sign: of a zero of k - m omega^2 there is no angle.
    if imag == 0:
        return real, Integer(0)
    if real == 0:
        return imag, pi / 2
    return sqrt(real**2 + imag**2), atan2(imag, real)
