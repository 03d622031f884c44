"""The perceived dynamics H_perc of a chain of effects, and its closed forms.

**Question.** A controller renders an environment (force over motion, H = F/X, a function of s);
between it and the hand there are n effects (filters, delays, samplers, elastic parts). What does
the hand feel, and in which closed form is that short?

**The map.** Each effect is a chain matrix (A, B; C, D) over functions of s, the transmission matrix
of a two-port (Feldtkeller 1937): with H on the side of the environment the hand's side has

    H' = (A H + B)/(C H + D),

a Moebius map. Maps compose as matrices multiply: H_perc is the map of all effects, nearest the
environment first, of H_rendered, what the controller renders. dH = H_perc - H_env is the distortion
against H_env, what should be felt (mostly H_rendered = H_env). On s = j omega the ratios are r_r =
abs(Re dH)/abs(H_env) and r_i = abs(Im dH)/abs(H_env); a difference is noticed where a ratio exceeds
a threshold c (Fu, van Paassen and Mulder 2019, doi:10.1016/j.ifacol.2019.12.119).

**Exact.** All dynamics are quotients of polynomials in s, pi, the parameters, delays exp(-s tau) and
fractional powers of s (a ``Ring``); all parameters are positive symbols or exact numbers. *Lowest
terms*: numerator and denominator have no common factor as such polynomials. A *response* has real
and imaginary part on s = j omega as real functions of omega, a *chart* all zeros, poles and signs
of such functions, a *solution* a formula for a frequency and the conditions under which it is one.

**Three closed forms** of Re and Im. In *lowest terms*, a single fraction: unique, but for n devices
with parameters of their own of some 2^n terms. In *magnitudes and angles*, for effects in series
(B = C = 0, so that each multiplies the force by G_i = A/D):

    H_perc = |H| prod |G_i| exp(j (arg H + sum arg G_i)),

which grows by one magnitude and one angle for each effect. Else as Re or Im of H_perc(j omega) as
the chain builds it. ``shortest`` chooses. Named steps (``Chain.steps``) are short for all.

**Guaranteed.** Formulas are identities, for all positive values of the parameters at which no
denominator vanishes. Frequencies (``zeros``, ``sign_changes``, ``bandwidth``) are certified: none is
missing, and each has any number of digits. What cannot be had raises SceneError and says why; None
(``lowest``) means undecided.

Begin with ``Chain``: ``dynamics`` computes H_env and H_perc. Sections below: closed forms; what a
person makes of a dynamics (stiffness, mass, damping); crossings of a threshold and bandwidth.
Leading terms at low and high frequency are in ``asymptotes``. ``Distortion`` (model.distortion) is
the object by which all are used.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache, reduce
from operator import itemgetter
from typing import TYPE_CHECKING, Any, NamedTuple

from sympy import (
    Add,
    Expr,
    I,
    Integer,
    Mul,
    Poly,
    Rational,
    Symbol,
    atan2,
    cos,
    count_ops,
    exp,
    factor_terms,
    im,
    oo,
    pi,
    re,
    sin,
    sqrt,
)

from haptisym.kernel.asymptoticsign import Sense, asymptotic_sign
from haptisym.kernel.dynamics import RealFunction, Response, Ring, on_axis
from haptisym.kernel.errors import SceneError, quoted, within
from haptisym.kernel.harmonics import Harmonic
from haptisym.kernel.objects import viewed
from haptisym.kernel.reals import RealNumber
from haptisym.kernel.rings import Polynomial, RationalFunction, X, cleared, monomials, omega, s
from haptisym.kernel.rings import c as symbol_c
from haptisym.kernel.roots import Chart, chart, sign_of_number
from haptisym.kernel.solutions import Solution, solve
from haptisym.model.catalogue import Matrix, given_band
from haptisym.model.jnd import Part
from haptisym.model.parameters import in_place
from haptisym.model.quantities import Dimension, number, quantity

if TYPE_CHECKING:
    from haptisym.programs.program import Program
    from haptisym.programs.steps import Steps


NOTHING_TO_FEEL = (
    "the environment is zero at every frequency: add mass, damping or stiffness (haptisym "
    "stability takes free air)"
)
_SAMPLE_BITS = 128
"""Precision, bits, at which a program is tried at one point: there the ball of a field that is not 0
everywhere hardly ever holds 0."""
_COSINE_OR_SINE = {Part.REAL: cos, Part.IMAG: sin}
_PART_OF = {Part.REAL: re, Part.IMAG: im}


@dataclass(frozen=True)
class Chain:
    """A display as exact dynamics in s; stiffness, damping and mass in SI, s in rad/s.

    ``environment`` : H_env, what should be felt.
    ``rendered`` : H_rendered, what the controller renders for it.
    ``matrices`` : the chain matrices (A, B, C, D) of the effects, nearest the environment first.
    """

    environment: Expr
    rendered: Expr
    matrices: tuple[Matrix, ...]

    def dynamics(
        self, ring: Ring | None = None, *, free_air: bool = False
    ) -> tuple[RationalFunction, RationalFunction]:
        """H_env and H_perc in lowest terms, in ``ring`` or else in that of the chain.

        SceneError where H_perc is infinite at every frequency, and, unless ``free_air``, where
        H_env is zero everywhere: then there is no ratio to it.
        """
        ring = ring or self.ring
        environment = ring.convert(self.environment).reduced()
        if environment.is_zero and not free_air:
            raise SceneError(NOTHING_TO_FEEL)
        return environment, self.perceived(range(len(self.matrices)), ring)

    def perceived(self, effects: Iterable[int], ring: Ring | None = None) -> RationalFunction:
        """H_perc in lowest terms with some of the effects alone, in ``ring`` or else in that of the
        chain.

        ``effects`` : their indices in ``matrices``, ascending. SceneError where H_perc is infinite
        at every frequency.
        """
        ring = ring or self.ring
        H = ring.convert(self.rendered)
        for i in effects:
            matrix = [ring.convert(entry) for entry in self.matrices[i]]
            H = _moebius(H, matrix)
        return H.reduced()

    @cached_property
    def ring(self) -> Ring:
        """The smallest ring that holds all dynamics of the chain, and ``stand_in``."""
        # With the symbol of a threshold crossings have formulas in it; a variable that does not
        # occur costs nothing.
        return Ring.of([*self.entries(), self.stand_in])

    @cached_property
    def stand_in(self) -> Symbol:
        """The symbol that stands for a threshold in the ring: c, or c_, c__ where a parameter has
        that name."""
        return unused(symbol_c, self.parameters)

    def entries(self) -> tuple[Expr, ...]:
        """All dynamics of the chain: H_env, H_rendered, and the entries of the matrices."""
        entries = [self.environment, self.rendered]
        for matrix in self.matrices:
            entries += matrix
        return tuple(entries)

    @property
    def parameters(self) -> tuple[Symbol, ...]:
        """The symbols of the chain except s, in the order of their names."""
        symbols = {x for entry in self.entries() for x in entry.free_symbols}
        return tuple(sorted(symbols - {s}, key=str))

    @property
    def harmonics(self) -> tuple[Expr, ...]:
        """The first harmonics (describing functions of friction, backlash and the like) in the chain
        whose sizes are still symbols."""
        harmonics = {x for entry in self.entries() for x in entry.atoms(Harmonic)}
        return tuple(sorted(harmonics, key=str))

    @property
    def described(self) -> frozenset[Symbol]:
        """The symbols in the first harmonics: sizes that can be set, but not be searched, as no
        quotient of polynomials has them."""
        return frozenset().union(*(x.free_symbols for x in self.harmonics))

    def program(self, fields: Sequence[str]) -> Program:
        """The straight-line program, a list of elementary operations, that computes some fields of
        ``programs.values.Values`` from omega and the parameters. A field that is 0 for all arguments
        is written as 0."""
        return self._program(fields, ())

    def _program(self, fields: Sequence[str], harmonics: tuple[Expr, ...]) -> Program:
        """As ``program``, with ``harmonics`` as further inputs, and all other first harmonics
        computed."""
        from haptisym.programs.balls import BallPoint  # a certified answer needs no program

        inputs = (*self.parameters, *harmonics)
        write = _writer(self.environment, self.rendered, self.matrices, inputs)
        program = write(fields, ())
        # A value that is not 0 at one point settles that a field is not 0 everywhere. Only fields
        # whose ball holds 0 at this arbitrary point need the exact, slower test.
        point = tuple(1.25 + n / 8 for n in range(len(program.inputs)))
        balls = BallPoint(program, point).balls(_SAMPLE_BITS)
        vanishing = [name for name in fields if balls[name].contains(0) and self.vanishes(name)]
        return write(fields, vanishing) if vanishing else program

    def vanishes(self, field: str) -> bool:
        """Whether a field is 0 at all frequencies and for all parameters, decided exactly.

        ``field`` : of ``programs.values.Values``, a kind and a part, as "perceived_real": real or
        imaginary part of H_perc ("perceived"), H_env ("environment") or dH/H_env ("relative"). All
        others, as "real" and "ratio_real", vanish where that part of dH does.
        """
        kind, _, part = field.rpartition("_")
        environment, perceived = self.dynamics(free_air=kind == "perceived")
        dynamics = perceived - environment
        if kind == "relative":
            dynamics = dynamics / environment
        elif kind == "environment":
            dynamics = environment
        elif kind == "perceived":
            dynamics = perceived
        response = on_axis(dynamics)
        return (response.raw_real if part == "real" else response.raw_imag).is_zero

    @cached_property
    def steps(self) -> Steps:
        """All fields of ``programs.values.Values`` in named steps, as a page shows them: equations
        with names for what occurs more than once. H_perc is given as H_env + dH."""
        from haptisym.programs.steps import DISTORTION, Steps, page_steps

        fields = (*DISTORTION, "environment_real", "environment_imag")
        # For a reader a first harmonic is a name, which is explained once.
        page = page_steps(self._program(fields, self.harmonics))
        results = dict(page.results)
        for part in Part:
            perceived = results[f"environment_{part.value}"] + results[part.value]
            results[f"perceived_{part.value}"] = perceived
        return Steps(page.definitions, results)

    @property
    def in_series(self) -> bool:
        """Whether each effect only multiplies the force: B = C = 0 in its chain matrix."""
        return all(b == 0 and c == 0 for _, b, c, _ in self.matrices)

    def part_of_distortion(self, part: Part, environment: Expr) -> Expr:
        """Re or Im of dH = H_perc - H_env, that of H_perc in magnitudes and angles if the effects are
        in series, else as the chain builds it.

        ``environment`` : that part of H_env(j omega).
        """
        if not self.in_series:
            return _PART_OF[part](self.formula, evaluate=False) - environment
        return self._part_of_product(part, [self.rendered, *self._gains]) - environment

    def part_of_relative(self, part: Part) -> Expr:
        """Re or Im of dH/H_env = H_perc/H_env - 1, that of the quotient in magnitudes and angles if
        the effects are in series, else as the chain builds it."""
        one = Integer(part is Part.REAL)
        if not self.in_series:
            H = self.environment.xreplace({s: I * omega})
            return _PART_OF[part](self.formula / H, evaluate=False) - one
        # Where the environment itself is rendered, H_perc/H_env is the product of the gains alone.
        factors = self._gains
        if self.rendered != self.environment:
            factors = [self.rendered, 1 / self.environment, *factors]
        return self._part_of_product(part, factors) - one

    @property
    def formula(self) -> Expr:
        """H_perc(j omega), as the chain builds it: fractions within fractions."""
        H = self.rendered
        for a, b, c, d in self.matrices:
            H = (a * H + b) / (c * H + d)
        return H.xreplace({s: I * omega})

    @property
    def _gains(self) -> list[Expr]:
        """The factors G_i = A/D by which effects in series multiply the dynamics behind them."""
        return [a / d for a, _, _, d in self.matrices]

    @staticmethod
    def _part_of_product(part: Part, factors: Sequence[Expr]) -> Expr:
        """Re or Im of a product on s = j omega: the product of the magnitudes of its factors times
        the cosine or sine of the sum of their angles."""
        polar = [_polar(x) for x in factors]
        magnitude = Mul(*(size for size, _ in polar))
        angle = Add(*(phase for _, phase in polar))
        return magnitude * _COSINE_OR_SINE[part](angle)

    def without_axis_zeros(self) -> tuple[Chain, bool]:
        """A chain with the same ratios whose H_env has no zeros on s = j omega, and whether the
        parts have changed places: r_r of this chain is then r_i of that one.

        At a frequency where H_env vanishes the ratio abs(Re dH)/abs(H_env) is then a value and not
        0/0. All dynamics are divided by the product Z of the factors of H_env that can vanish
        there:

        - (A H + B)/(C H + D) over Z is the map of [[A, B/Z], [C Z, D]] applied to H/Z.
        - Z(j omega) is real, or it is imaginary. If real, Re dH and Im dH of the quotient are those
          of dH over abs(Z), up to the sign; if imaginary, they change places.
        """
        H_env = self.ring.convert(self.environment).reduced()
        Z = self.ring.function(_axis_zeros(self.ring, H_env.numerator))
        if Z.numerator.is_constant():
            return self, False
        # All factors of Z but s itself are even in s, so that any term has the parity of Z. An odd
        # Z is imaginary on the axis.
        is_odd = int(Z.numerator.monoms()[0][0]) % 2 == 1
        return self.over(Z), is_odd

    def over(self, Z: RationalFunction) -> Chain:
        """The chain with all dynamics divided by Z, in lowest terms."""

        def times(x: Expr, power: int) -> Expr:
            """A dynamics times that power of Z, in lowest terms; 0 stays as it is."""
            return (self.ring.convert(x) * Z**power).reduced().expression() if x else x

        matrices = []
        for a, b, c, d in self.matrices:
            matrices.append((a, times(b, -1), times(c, 1), d))
        return Chain(times(self.environment, -1), times(self.rendered, -1), tuple(matrices))

    def put(self, values: Mapping[Symbol, Expr]) -> Chain:
        """The same chain with values for some of its symbols."""
        return self.map(lambda entry: in_place(entry, values))

    def at(self, values: Mapping[Symbol, Expr]) -> Chain:
        """As ``put``, for what searches values of the other symbols.

        SceneError where numbers are put in and a first harmonic, which is no quotient of
        polynomials, keeps a symbol.
        """
        chain = self.put(values)
        if chain.harmonics and any(x.is_number for x in values.values()):
            names = ", ".join(sorted(map(str, chain.described)))
            raise SceneError(
                f"{names}: a number of a describing function can be set, not varied: write "
                "another value into the scene (with_values in Python; haptisym compare SCENE "
                "--with PATH=VALUE), and ask again"
            )
        return chain

    def map(self, change: Callable[[Expr], Expr]) -> Chain:
        """The chain with a function applied to every dynamics in it."""
        matrices = []
        for a, b, c, d in self.matrices:
            matrices.append((change(a), change(b), change(c), change(d)))
        return Chain(change(self.environment), change(self.rendered), tuple(matrices))


def unused(symbol: Symbol, taken: Iterable[Symbol]) -> Symbol:
    """The symbol, with as many _ after its name as it takes that no symbol of ``taken`` has it."""
    name, names = symbol.name, {x.name for x in taken}
    while name in names:
        name += "_"
    return Symbol(name, positive=symbol.is_positive)


@lru_cache(maxsize=8)
def _writer(
    environment: Expr, rendered: Expr, matrices: tuple[Matrix, ...], inputs: tuple[Symbol, ...]
) -> Callable[[Sequence[str], Collection[str]], Program]:
    """Return a function that writes programs of a chain, from the fields wanted and those known to
    be 0.

    All of its programs share their first steps, which are computed here: it is cached, as several
    sets of fields are asked of one chain.
    """
    from haptisym.programs.distortion import stable_program

    return stable_program(environment, rendered, matrices, inputs)


def _axis_zeros(ring: Ring, polynomial: Polynomial) -> Polynomial:
    """The product of the irreducible factors of a polynomial that are real or imaginary on s = j
    omega: s itself, and those in s^2.

    These can vanish there, as it takes one equation. Any other factor f takes two, Re f = Im f = 0,
    for one unknown omega: with numbers it has no zero there, as f(s) and f(-s) would share it, and
    an irreducible f would be even or odd; with parameters it has one for isolated values alone.
    """
    zeros_on_axis = ring.constant(1)
    if not polynomial:
        return zeros_on_axis
    for factor, multiplicity in ring.factors(polynomial, in_square=False)[1]:
        # With powers of s of one parity only (irreducible: s, or a polynomial in s^2) the factor is
        # real or imaginary on the axis. One with a delay, or a fractional power, is neither.
        parities = {int(exponents[0]) % 2 for exponents in factor.monoms()}
        degrees = factor.degrees()
        if degrees[0] and len(parities) == 1 and not any(degrees[ring.size :]):
            zeros_on_axis = zeros_on_axis * factor**multiplicity
    return zeros_on_axis


def real_factor(ring: Ring, polynomial: Polynomial) -> Polynomial:
    """The largest factor of a polynomial, not 0, that is real on s = j omega, as k + m s^2: it is
    even in s, without delays and powers s^alpha.

    >>> ring = Ring.of([Symbol("k"), exp(-s)])
    >>> ring.expression(real_factor(ring, ring.convert((Symbol("k") + s**2) * (1 + s * exp(-s))).numerator))
    k + s**2
    """
    # It divides the even and the odd part of the coefficient of each product of delays and powers.
    parts: dict[tuple[int, ...], dict[tuple[int, ...], Any]] = {}
    for exponents, value in monomials(polynomial):
        powers = tuple(map(int, exponents))
        own, others = powers[: ring.size], powers[ring.size :]
        rest = own + (0,) * len(others)
        parts.setdefault((own[0] % 2, *others), {})[rest] = value
    first, *more = (ring.context.from_dict(x) for x in parts.values())
    common = reduce(lambda x, y: x.gcd(y), more, first)
    power = int(common.deflation_index()[1][0])
    return common / ring.variable ** (power % 2)


def _moebius(H: RationalFunction, matrix: Sequence[RationalFunction]) -> RationalFunction:
    """(A H + B)/(C H + D), not yet in lowest terms; SceneError where the denominator is zero at
    every frequency."""
    # Over one common denominator the four entries are polynomials; it cancels in the quotient.
    a, b, c, d = cleared(matrix)
    numerator = a * H.numerator + b * H.denominator
    denominator = c * H.numerator + d * H.denominator
    if denominator.is_zero():
        raise SceneError(
            "the effects make H_perc infinite at every frequency (C H + D = 0): change one of them"
        )
    return RationalFunction(H.ring, numerator, denominator)


# Closed forms of Re and Im: the choice between them, and magnitudes and angles.

# Which closed form is made, by the number of terms of numerator and denominator of the dynamics
# together: Re and Im in lowest terms have about its square. The numbers are what is readable (ten)
# and what takes seconds at most; they choose between equal formulas alone.
_ALWAYS_LOWEST = 10
"""Up to here lowest terms are taken as they are."""
_MOST_COMPARED = 80
"""Up to here lowest terms are compared with the form in magnitudes and angles."""
_MOST_LOWEST = 300
"""Up to here lowest terms are taken where the effects are not in series."""
LOWEST_MAY_EXCEED = 1.3
"""Lowest terms are preferred up to this many times the operations of the other form."""


def shortest(
    dynamics: RationalFunction,
    lowest: Callable[[], Expr],
    others: Callable[[], Expr],
    *,
    in_series: bool,
) -> tuple[Expr, bool]:
    """The shorter of two equal forms of Re or Im of a dynamics; and whether that is the one in
    lowest terms. Lowest terms are preferred where they are short, and not made where that would
    take long.

    ``lowest`` : makes the form in lowest terms.
    ``others`` : makes the other one, in magnitudes and angles if all effects are ``in_series``, else
    Re or Im of H_perc as the chain builds it.
    """
    terms = len(dynamics.numerator) + len(dynamics.denominator)
    if terms <= _ALWAYS_LOWEST or (terms <= _MOST_LOWEST and not in_series):
        return lowest(), True
    other = others()
    if terms > _MOST_COMPARED:
        return other, False
    reduced = lowest()
    is_lowest = count_ops(reduced) <= LOWEST_MAY_EXCEED * count_ops(other)
    return (reduced, True) if is_lowest else (other, False)


def _polar(product: Expr) -> tuple[Expr, Expr]:
    """Magnitude and angle, rad, of a product of factors on s = j omega.

    The magnitude is real, and negative where a sine of a hold is: the product is the magnitude times
    exp(j angle) all the same.
    """
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
    return sqrt(real**2 + imag**2), atan2(imag, real)


# What a person makes of a dynamics. Equations are those of Fu, van Paassen and Mulder (2019),
# doi:10.1016/j.ifacol.2019.12.119.


@dataclass(frozen=True)
class Properties:
    """What a person makes of a dynamics H at a frequency (section 2.3): closed forms in omega.

    ``real``, ``imag`` : Re H and Im H, N/m; for a rotation N m/rad. Forces (eqs. 5 and 6) are
    phasors, N or N m, for a motion of the complex ``amplitude`` X.
    """

    real: Expr
    imag: Expr
    frequency: Expr = omega
    """The symbol of omega, or a value."""
    amplitude: Symbol = X

    @property
    def stiffness(self) -> Expr:
        """Re H, N/m or N m/rad: a spring where it is positive."""
        return self.real

    @property
    def mass(self) -> Expr:
        """-Re H/omega^2, kg or kg m^2: an inertia where it is positive."""
        return -self.real / self.frequency**2

    @property
    def damping(self) -> Expr:
        """Im H/omega: N s/m or N m s/rad."""
        return self.imag / self.frequency

    @property
    def spring_inertia_force(self) -> Expr:
        """The force of spring and inertia together, for a motion of amplitude X: X Re H."""
        return self.amplitude * self.real

    @property
    def damping_force(self) -> Expr:
        """The force of the damper, for a motion of amplitude X: j X Im H."""
        return I * self.amplitude * self.imag


@dataclass(frozen=True)
class ParameterJND:
    """How much a single parameter must change to be noticed, for a threshold c: dk = c abs(H), db =
    c abs(H)/omega, dm = c abs(H)/omega^2, in N/m, N s/m and kg (for a rotation N m/rad, N m s/rad,
    kg m^2).

    By eq. (4) a change is noticed where Re H or Im H moves by c abs(H); dk moves Re H by dk, dm by
    -omega^2 dm, and db moves Im H by omega db.
    """

    stiffness: Expr
    damping: Expr
    mass: Expr


def properties(response: Response, frequency: Expr = omega, amplitude: Symbol = X) -> Properties:
    """The properties of a dynamics from its response on s = j omega.

    ``frequency`` : what stands for omega in them; ``amplitude`` : what stands for the amplitude of
    the motion.
    """
    named = {omega: frequency}
    real = in_place(response.real.factored(), named)
    imag = in_place(response.imag.factored(), named)
    return Properties(real, imag, frequency, amplitude)


_SAME_FREQUENCY = 1e-9
"""Frequencies, as doubles, that differ relatively by less are not distinguished: far above their
rounding, far below what a formula means to a reader."""


def lowest(
    solutions: Sequence[Solution], values: Mapping[Symbol, Expr] | None = None
) -> Expr | None:
    """The formula of the lowest frequency among ``solutions``: for these ``values`` of all
    parameters, or without them for all values at which it is in force.

    None : which one is lowest is not decided, or none is in force.

    >>> from haptisym.kernel.rings import symbols
    >>> k, m = symbols("k m")
    >>> both = [Solution(x, k, conditions=(y,)) for x, y in ((sqrt(k - m), k - m), (sqrt(m - k), m - k))]
    >>> lowest(both), lowest(both, {k: Integer(5), m: Integer(1)})
    (None, sqrt(k - m))
    """
    # A solution without omega is an equation that has no formula.
    if any(x.omega is None for x in solutions):
        return None
    if values is None:
        for x in solutions:
            if all(x is other or _is_lower(x, other) for other in solutions):
                return x.omega
        return None
    by_frequency = []
    for x in solutions:
        with_values = x.replaced(values)
        # None, or without omega: with these values the solution is not in force.
        if with_values and with_values.omega is not None:
            if with_values.conditions or not with_values.omega.is_real:
                return None
            by_frequency.append((float(with_values.omega), x.omega))
    if not by_frequency:
        return None
    by_frequency.sort(key=itemgetter(0))
    frequency, formula = by_frequency[0]
    # Two zeros that meet as doubles may be one that is touched, where no sign changes.
    if len(by_frequency) > 1 and by_frequency[1][0] - frequency <= _SAME_FREQUENCY * frequency:
        return None
    return formula


def _is_lower(one: Solution, other: Solution) -> bool:
    """Whether ``one`` is proven to be in force wherever ``other`` is, and not above it there; False
    proves nothing."""
    assert one.omega is not None
    assert other.omega is not None
    if not set(one.conditions) <= set(other.conditions):
        return False
    if (one.omega - other.omega).is_negative:
        return True
    # Both are positive where they are in force: they are in the order of their squares. Of the two
    # roots of a quadratic in omega^2 the squares differ by sqrt(discriminant)/a. The square root is
    # not negative where it is real, so that the signs of the other factors decide.
    gap = factor_terms((other.omega**2 - one.omega**2).expand())
    for factor in Mul.make_args(gap):
        is_root = factor.is_Pow and factor.exp == Rational(1, 2)
        if not is_root and not factor.is_positive:
            return False
    return True


# Changeovers, crossings of a threshold and bandwidth. A ratio r is given as its square, a function
# of omega: in squares there is no square root of |H_env|^2, and zeros and signs stay those of
# polynomials.

_OMEGA_SQUARED = Symbol("W", positive=True)
"""omega^2, the unknown of a threshold polynomial."""

Frequencies = tuple[Solution, ...] | tuple[RealNumber, ...]
"""Formulas, each with the conditions under which it is in force; or, where all are numbers,
certified frequencies."""


class Changeovers(NamedTuple):
    """All frequencies at which Re H_env and Re H_perc change their sign."""

    environment: Frequencies
    perceived: Frequencies

    def _repr_latex_(self) -> str | None:
        return viewed(self, "latex")


class CrossingSolutions(NamedTuple):
    """All values at which r_r, and at which r_i, equals a threshold."""

    real: tuple[Solution, ...]
    imag: tuple[Solution, ...]

    def _repr_latex_(self) -> str | None:
        return viewed(self, "latex")


def part_named(given: Any) -> Part:
    """Return the part that is given itself or by its name, "real" or "imag"; SceneError for anything
    else."""
    if given in [x.value for x in Part]:
        return Part(given)
    if not isinstance(given, Part):
        raise SceneError(f"part: {quoted(given)}: give real or imag")
    return given


def threshold(given: Any, named: Mapping[str, str]) -> Expr:
    """Read a threshold c: a fraction > 0, as a number or in symbols of its own.

    ``named`` : the names that its symbols must not have, and what they mean. SceneError for anything
    else.
    """
    with within("c"):
        value = quantity(given, Dimension.RATIO).value
    if (value.is_number and sign_of_number(value) <= 0) or value.is_positive is False:
        raise SceneError(f"c: {quoted(given)}: give a fraction > 0")
    for x in sorted(value.free_symbols, key=str):
        if x.name in named:
            raise SceneError(
                f'c: {x} is {named[x.name]}: give the threshold another symbol, as Symbol("eps")'
            )
    return value


def excess(squared_ratio: RealFunction, c: Expr) -> RealFunction:
    """r^2 - c^2 in lowest terms: positive exactly where a ratio r exceeds a threshold c > 0."""
    f = squared_ratio.function
    square = f.ring.convert(c**2)
    numerator = f.numerator * square.denominator - square.numerator * f.denominator
    denominator = f.denominator * square.denominator
    return RealFunction(f.ring.function(numerator, denominator).reduced())


def crossings(
    squared_ratio: RealFunction,
    c: Expr,
    stand_in: Symbol,
    by: Callable[[RealFunction], tuple[Solution, ...]] = solve,
) -> tuple[Solution, ...]:
    """The frequencies at which a ratio equals a threshold, as formulas with the conditions under
    which they are in force.

    ``stand_in`` : the symbol that the ring has for a threshold.
    ``by`` : what solves r^2 - c^2 = 0, given its left-hand side.
    """
    if not c.free_symbols:
        return by(excess(squared_ratio, c))
    solutions = by(excess(squared_ratio, stand_in))
    # r^2 = c^2 is r = c for c >= 0 alone: that is one more condition, which ``at`` leaves out where
    # it is known to hold.
    in_c = []
    for x in solutions:
        conditional = replace(x, conditions=(*x.conditions, stand_in))
        with_c = conditional.replaced({stand_in: c})
        if with_c is not None:
            in_c.append(with_c)
    return tuple(in_c)


def zeros(f: RealFunction, band: tuple[Any, Any] | None) -> tuple[RealNumber, ...]:
    """All positive zeros of a function without free parameters, certified: on a band, rad/s, if one
    is given. SceneError without a band where there may be infinitely many, as with a delay."""
    points = (p for p in _chart(f, band).points if p.orders.get(0, 0) > 0)
    return tuple(p.omega for p in points if float(p.omega))


def sign_changes(f: RealFunction) -> tuple[RealNumber, ...]:
    """All positive frequencies at which a function without free parameters changes its sign, poles
    of odd order among them, certified. SceneError as of ``zeros``."""
    # N D has the sign of N/D and no poles: a zero at which it changes its sign is a zero of N or a
    # pole, both of odd order.
    same_sign = RealFunction(f.axis.function(f.function.numerator * f.function.denominator))
    points = _chart(same_sign, None).sign_changes(0)
    return tuple(p.omega for p in points if float(p.omega))


def _chart(f: RealFunction, band: tuple[Any, Any] | None) -> Chart:
    """The chart of a function, under the key 0, on a band, or on all frequencies at which it has
    zeros."""
    low, high = _band_ends(band) if band else (Integer(0), _above_all_zeros(f))
    return chart({0: f}, low, high)


def unknown(*functions: RealFunction) -> set[Symbol]:
    """The parameters on which some functions depend."""
    return {x for f in functions for x in f.expression().free_symbols} - {omega}


def _band_ends(band: tuple[Any, Any]) -> tuple[Expr, Expr]:
    """The two ends of a band, rad/s, exact; SceneError unless 0 <= low < high."""
    low, high = (number(x, Dimension.FREQUENCY).value for x in given_band(band))
    if not 0 <= low < high:
        raise SceneError(f"band: {band}: give a low end >= 0 and a higher one, as (0, 15)")
    return low, high


def _above_all_zeros(f: RealFunction) -> Expr:
    """A frequency > 0, rad/s, above which a function has no zero; SceneError where none is known, as
    with a delay. Any frequency will do for the function 0."""
    if f.function.is_zero:
        return Integer(1)
    # A delay turns the phase for ever: r^2 - c^2 can change its sign at arbitrarily high omega.
    if any(not angle.constant for angle in f.axis.angles):
        raise SceneError(
            "with a delay there may be infinitely many crossings: give a band, as band=(0, 100); "
            "changeovers on a band are those of hs.evaluate"
        )
    # Without delays the highest power of the numerator exceeds all others together for omega >=
    # ``radius``: the function is not 0 there.
    at_infinity = asymptotic_sign(f.function)
    if at_infinity.sense not in (Sense.POSITIVE, Sense.NEGATIVE):
        raise SceneError("the highest crossing is not known: give a band, as band=(0, 100)")
    return max(at_infinity.radius, Integer(1))


def threshold_polynomial(squared_ratio: RealFunction, c: Expr, stand_in: Symbol) -> Poly | Expr:
    """The polynomial in W = omega^2 (W_ where W is a parameter) that vanishes where a ratio equals a
    threshold; with delays or fractional powers an expression in omega.

    ``stand_in`` : the symbol that the ring has for a threshold.
    """
    f = excess(squared_ratio, stand_in if c.free_symbols else c)
    numerator = f.expression().as_numer_denom()[0]
    polynomial = numerator.expand().xreplace({stand_in: c})
    if not polynomial.is_polynomial(omega):
        return polynomial
    if any(n % 2 for (n,) in Poly(polynomial, omega).monoms()):
        return polynomial
    square = unused(_OMEGA_SQUARED, polynomial.free_symbols)
    return Poly(polynomial.subs(omega, sqrt(square)), square)


_WIDENED = 4
"""How many bands, each eight times as wide as the one before, are searched for the end of a
bandwidth behind a delay: up to eighty turns of the longest."""


def bandwidth(
    squared_ratios: Mapping[Part, RealFunction], c: Expr, band: tuple[Any, Any] | None
) -> RealNumber | Expr:
    """The upper end, rad/s, of the interval from 0 or from the low end of the band on which no ratio
    exceeds c; 0 where there is no such interval, oo where it has no end.

    SceneError where a parameter has no value, and, without a band, where no ratio exceeds c within
    some eighty turns of a delay.
    """
    free = unknown(*squared_ratios.values()) | c.free_symbols
    if free:
        named = ", ".join(sorted(map(str, free)))
        raise SceneError(
            f"a bandwidth needs values for {named}; crossings(part, c) has the formulas"
        )
    functions = {part: excess(f, c) for part, f in squared_ratios.items()}
    turning = [x.rate for f in functions.values() for x in f.axis.angles if not x.constant]
    if band:
        bands = [_band_ends(band)]
    elif turning:
        # Behind a delay the highest crossing is not known; the first one is mostly within its first
        # turns, and there are no more zeros than are searched.
        first = 1 / max(map(abs, turning), key=float)
        bands = [(Integer(0), first * 8**n) for n in range(_WIDENED)]
    else:
        bands = [(Integer(0), max(map(_above_all_zeros, functions.values())))]
    for low, high in bands:
        table = chart(functions, low, high)
        unnoticed = table.where(lambda signs: all(x <= 0 for x in signs.values()))
        # It is the end of the first interval, if that begins at the low end: an interval further
        # up, behind frequencies at which a ratio exceeds c, is no bandwidth.
        end = table.reach(unnoticed)
        if end is None:
            return Integer(0)
        if band or end is not table.points[-1].omega:
            return end
    if turning:
        raise SceneError(
            f"no ratio exceeds c up to {float(high):.5g} rad/s, and with a delay none is known to "
            f"be the last: give a band, as band=(0, {float(10 * high):.5g})"
        )
    # Above the last point of a chart without a band no ratio crosses c any more: there, as from
    # ``_above_all_zeros`` on, each function has one sign.
    return oo
