"""A chain of dynamics between environment and hand, and its closed forms.

A ``Chain`` is H_env, what is rendered for it and the effects' chain matrices, nearest the
environment first; H_perc is one Moebius map of what is rendered.

Closed forms are the shortest Re and Im, stiffness, mass and damping, crossings, changeovers and
leading terms. In lowest terms a chain of n devices with parameters of their own has some 2^n terms.
Effects in series are factors G_i instead:
H_perc = |H| prod |G_i| exp(j (arg H + sum arg G_i)) grows by one magnitude and one angle with each.
What is neither short nor in series is left as Re or Im of H_perc(j omega) as the chain builds it.
Named steps (``Distortion.steps``) are short for all.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property, lru_cache, partial
from math import factorial
from operator import itemgetter
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

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
from haptisym.kernel.dynamics import RealFunction, Response, Ring, on_axis, ring_of
from haptisym.kernel.errors import SceneError, quoted, within
from haptisym.kernel.harmonics import Harmonic
from haptisym.kernel.reals import RealNumber
from haptisym.kernel.rings import Polynomial, RationalFunction, X, cleared, omega, s
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


@dataclass(frozen=True)
class Chain:
    """A display as dynamics in s, exact: the environment H_env, what the controller renders for it,
    and the effects' chain matrices (A, B, C, D), nearest the environment first."""

    environment: Expr
    rendered: Expr
    matrices: tuple[Matrix, ...]

    def dynamics(
        self, ring: Ring | None = None, *, free_air: bool = False
    ) -> tuple[RationalFunction, RationalFunction]:
        """H_env and H_perc in lowest terms, in a ring that holds them (the smallest one unless
        given).

        Raises SceneError where H_perc is not a dynamics, and where H_env is zero everywhere but in
        ``free_air``.
        """
        ring = ring or self.ring
        environment = ring.convert(self.environment).reduced()
        if environment.is_zero and not free_air:
            raise SceneError(NOTHING_TO_FEEL)
        return environment, self.perceived(range(len(self.matrices)), ring)

    def perceived(self, places: Iterable[int], ring: Ring | None = None) -> RationalFunction:
        """H_perc in lowest terms, of the effects at these places alone, in the ring of all unless
        given another."""
        ring = ring or self.ring
        H = ring.convert(self.rendered)
        for i in places:
            H = _through(H, [ring.convert(entry) for entry in self.matrices[i]])
        return H.reduced()

    @cached_property
    def ring(self) -> Ring:
        """The ring that holds them all."""
        # A threshold comes along so that it may stay a symbol; a variable that does not occur costs
        # nothing.
        return Ring.of([*self.entries(), self.stand_in])

    @cached_property
    def stand_in(self) -> Symbol:
        """The symbol that stands for a threshold in the ring: c, or c_, c__ where a parameter has
        that name."""
        taken = {x.name for entry in self.entries() for x in entry.free_symbols}
        name = symbol_c.name
        while name in taken:
            name += "_"
        return Symbol(name, positive=True)

    def entries(self) -> tuple[Expr, ...]:
        """All dynamics in it: H_env, what is rendered, and the entries of the matrices."""
        return (
            self.environment,
            self.rendered,
            *(entry for matrix in self.matrices for entry in matrix),
        )

    @property
    def parameters(self) -> tuple[Symbol, ...]:
        """The symbols in it, in the order of their names."""
        return tuple(
            sorted({x for entry in self.entries() for x in entry.free_symbols} - {s}, key=str)
        )

    @property
    def harmonics(self) -> tuple[Expr, ...]:
        """The first harmonics in it whose sizes are still symbols."""
        return tuple(sorted({x for e in self.entries() for x in e.atoms(Harmonic)}, key=str))

    @property
    def described(self) -> frozenset[Symbol]:
        """The symbols in its first harmonics: sizes that can be set, not varied."""
        return frozenset().union(*(x.free_symbols for x in self.harmonics))

    def program(self, fields: Sequence[str]) -> Program:
        """The straight-line program of some fields of ``numeric.Values``; what is 0 everywhere is
        written as 0."""
        from haptisym.programs.balls import BallPoint  # a certified answer needs no program

        inputs = (*self.parameters, *self.harmonics)
        write = _writer(self.environment, self.rendered, self.matrices, inputs)
        program = write(fields, ())
        # A value that is not 0 at one point settles that a field is not 0 everywhere. Only fields
        # whose ball holds 0 at this arbitrary point need the exact, slower test.
        sample = BallPoint(program, tuple(1.25 + n / 8 for n in range(len(program.inputs)))).balls(
            128
        )
        zero = [name for name in fields if sample[name].contains(0) and self.vanishes(name)]
        return write(fields, zero) if zero else program

    def vanishes(self, name: str) -> bool:
        """Whether a field is 0 at all frequencies and for all parameters: decided exactly, both
        ways."""
        kind, _, part = name.rpartition("_")
        env, perc = self.dynamics(free_air=kind == "perceived")
        change = perc - env
        dynamics = (
            change / env
            if kind == "relative"
            else {"environment": env, "perceived": perc}.get(kind, change)
        )
        raw = on_axis(dynamics)
        return (raw.raw_real if part == "real" else raw.raw_imag).is_zero

    @cached_property
    def steps(self) -> Steps:
        """All fields of ``numeric.Values`` in named steps, as a page shows them; H_perc is given as
        H_env + dH."""
        from haptisym.programs.steps import DISTORTION, Steps, page_steps

        page = page_steps(self.program((*DISTORTION, "environment_real", "environment_imag")))
        results = page.results
        felt = {
            f"perceived_{part.value}": results[f"environment_{part.value}"] + results[part.value]
            for part in Part
        }
        return Steps(page.definitions, {**results, **felt})

    @property
    def in_series(self) -> bool:
        """Whether each effect only multiplies the force: B = C = 0 in its chain matrix."""
        return all(b == 0 and c == 0 for _, b, c, _ in self.matrices)

    def part_of_distortion(self, part: Part, environment: Expr) -> Expr:
        """Re or Im dH, less that part of H_env as it is given: in series in magnitudes and
        angles."""
        if not self.in_series:
            return _PART[part](self.formula, evaluate=False) - environment
        return self._turned(part, [self.rendered, *self._gains]) - environment

    def part_of_relative(self, part: Part) -> Expr:
        """Re or Im(dH/H_env), that of H_perc/H_env - 1."""
        one = Integer(part is Part.REAL)
        if not self.in_series:
            H = self.environment.xreplace({s: I * omega})
            return _PART[part](self.formula / H, evaluate=False) - one
        # Where the environment itself is rendered, H_perc/H_env is the product of the gains alone.
        outer = [] if self.rendered == self.environment else [self.rendered, 1 / self.environment]
        return self._turned(part, [*outer, *self._gains]) - one

    @property
    def formula(self) -> Expr:
        """H_perc(j omega), as the chain builds it."""
        H = self.rendered
        for a, b, c, d in self.matrices:
            H = (a * H + b) / (c * H + d)
        return H.xreplace({s: I * omega})

    @property
    def _gains(self) -> list[Expr]:
        """The factors A/D by which effects in series multiply the dynamics behind them."""
        return [a / d for a, _, _, d in self.matrices]

    @staticmethod
    def _turned(part: Part, factors: Sequence[Expr]) -> Expr:
        """Re or Im of a product of factors on s = j omega, as the product of their magnitudes times
        the cosine or sine of the sum of their angles."""
        polar = [_polar(x) for x in factors]
        return Mul(*(size for size, _ in polar)) * _TURN[part](Add(*(angle for _, angle in polar)))

    def without_axis_zeros(self) -> tuple[Chain, bool]:
        """A chain with the same ratios whose H_env has no zeros on s = j omega; and whether the
        parts have changed places, r_r being its r_i.

        All dynamics are taken over the factors Z of H_env that are real or imaginary there: H/Z
        behind [[A, B/Z], [C Z, D]].
        """
        environment = self.ring.convert(self.environment).reduced()
        # Of a ratio |Re dH|/|H_env| a common factor that is real or imaginary on the axis cancels:
        # at a frequency where H_env vanishes the ratio is then a value and no 0/0.
        Z = self.ring.function(_axis_zeros(self.ring, environment.numerator))
        if Z.numerator.is_constant():
            return self, False

        def times(x: Expr, power: int) -> Expr:
            """A dynamics times that power of Z, in lowest terms."""
            return (self.ring.convert(x) * Z**power).reduced().expression() if x else x

        matrices = tuple((a, times(b, -1), times(c, 1), d) for a, b, c, d in self.matrices)
        # All factors of Z but s itself are even in s, so that any term has the parity of Z. An odd
        # Z is imaginary on the axis and changes Re and Im about.
        odd = int(Z.numerator.monoms()[0][0]) % 2 == 1
        return Chain(times(self.environment, -1), times(self.rendered, -1), matrices), odd

    def at(self, values: Mapping[Symbol, Expr]) -> Chain:
        """The same chain with values for some of its symbols; SceneError where numbers are put in
        and a first harmonic, which is no quotient of polynomials, keeps a symbol."""
        found = self.map(lambda entry: in_place(entry, values))
        if found.harmonics and any(x.is_number for x in values.values()):
            names = ", ".join(sorted(map(str, found.described)))
            raise SceneError(
                f"{names}: a number of a describing function can be set, not varied: write "
                f"another value into the scene (with_values), and ask again"
            )
        return found

    def map(self, change: Callable[[Expr], Expr]) -> Chain:
        """The chain with every dynamics in it changed."""
        matrices = tuple(
            (change(a), change(b), change(c), change(d)) for a, b, c, d in self.matrices
        )
        return Chain(change(self.environment), change(self.rendered), matrices)


@lru_cache(maxsize=8)
def _writer(
    environment: Expr, rendered: Expr, matrices: tuple[Matrix, ...], inputs: tuple[Symbol, ...]
) -> Callable[[Sequence[str], Collection[str]], Program]:
    """The function that writes the programs of a chain, all from the same steps; cached, as several
    sets of fields are asked of one chain."""
    from haptisym.programs.distortion import stable_program

    return stable_program(environment, rendered, matrices, inputs)


def _axis_zeros(ring: Ring, polynomial: Polynomial) -> Polynomial:
    """The factors of a polynomial that can vanish on s = j omega: s itself, and those in s^2."""
    zeros_on_axis = ring.constant(1)
    for factor, n in ring.factors(polynomial, in_square=False)[1] if polynomial else ():
        # With powers of s of one parity only (irreducible: s, or a polynomial in s^2) the factor is
        # real or imaginary on the axis. One with a delay is neither.
        even = len({int(exponents[0]) % 2 for exponents in factor.monoms()}) == 1
        if factor.degrees()[0] and even and not any(factor.degrees()[ring.size :]):
            zeros_on_axis = zeros_on_axis * factor**n
    return zeros_on_axis


def _through(H: RationalFunction, matrix: Sequence[RationalFunction]) -> RationalFunction:
    """The Moebius map (A H + B)/(C H + D), without fractions inside."""
    # Over one common denominator the four entries are polynomials; it cancels in the quotient.
    a, b, c, d = cleared(matrix)
    top = a * H.numerator + b * H.denominator
    bottom = c * H.numerator + d * H.denominator
    if bottom.is_zero():
        raise SceneError(
            "the effects make H_perc infinite at every frequency (C H + D = 0): change one of them"
        )
    return RationalFunction(H.ring, top, bottom)


# Terms of numerator and denominator together: up to _SHORT the form in lowest terms is taken as it
# is; up to _FEW it is compared with the form in factors; up to _MOST it is made where there are no
# factors. Above, Re and Im would have some square of that many terms.
_SHORT, _FEW, _MOST = 10, 80, 300
# Lowest terms are preferred up to this many times the operations of the other form.
_LONGER = 1.3
_TURN = {Part.REAL: cos, Part.IMAG: sin}
_PART = {Part.REAL: re, Part.IMAG: im}


def shortest(
    dynamics: RationalFunction,
    lowest: Callable[[], Expr],
    others: Callable[[], Expr],
    *,
    in_series: bool,
) -> tuple[Expr, bool]:
    """The shorter of two forms of Re or Im of a dynamics; and whether that is the one in lowest
    terms.

    ``others`` : in factors, if all effects are ``in_series``, or as Re or Im of H_perc. Lowest
    terms are preferred where they are short, and not made where that would take long.
    """
    terms = len(dynamics.numerator) + len(dynamics.denominator)
    if terms <= _SHORT or (terms <= _MOST and not in_series):
        return lowest(), True
    other = others()
    if terms > _FEW:
        return other, False
    reduced = lowest()
    return (reduced, True) if count_ops(reduced) <= _LONGER * count_ops(other) else (other, False)


def _polar(factor: Expr) -> tuple[Expr, Expr]:
    """Magnitude (which may be negative, its sign being no part of the angle) and angle, rad, of a
    product on s = j omega."""
    above, below = factor.as_numer_denom()
    signed = [(x, 1) for x in Mul.make_args(above)] + [(x, -1) for x in Mul.make_args(below)]
    size, angle = Integer(1), Integer(0)
    for x, sign in signed:
        # exp(-s tau) is a factor of its own: SymPy would call it the power -s tau of e.
        base, power = x.as_base_exp() if not isinstance(x, exp) else (x, Integer(1))
        n = sign * power if power.is_Integer else Integer(sign)
        magnitude, phase = _polar_of_one(base if power.is_Integer else x)
        size, angle = size * magnitude**n, angle + phase * n
    return size, angle


def _polar_of_one(x: Expr) -> tuple[Expr, Expr]:
    """Magnitude and angle, rad, of one factor on s = j omega: a delay, a power of s, the numerator
    of a hold, or any polynomial."""
    is_exponential = isinstance(x, exp)
    base, power = (s, x.args[0] / s) if is_exponential else x.as_base_exp()
    # A delay exp(s a): magnitude 1, angle omega a.
    if is_exponential and not power.has(s):
        return Integer(1), omega * power
    if base == s and not power.has(s):
        return omega**power, pi * power / 2
    # A hold: +-(exp(s T) - 1) = +-exp(s T/2) 2 sinh(s T/2), and sinh(j y) = j sin y.
    for sign, rest in ((1, x + 1), (-1, 1 - x)):
        if isinstance(rest, exp) and not (lag := rest.args[0] / s).has(s):
            return 2 * sign * sin(omega * lag / 2), (pi + omega * lag) / 2
    ring = Ring.of([x])
    response = on_axis(ring.convert(x))
    a, b = (f.function.reduced().expression() for f in (response.real, response.imag))
    return sqrt(a**2 + b**2), atan2(b, a)


@dataclass(frozen=True)
class Properties:
    """What a person makes of a dynamics at a frequency (section 2.3): closed forms in omega.

    ``real``, ``imag``: Re H and Im H, N/m. ``stiffness`` = Re H, N/m; ``mass`` = -Re H/omega^2, kg;
    ``damping`` = Im H/omega, N s/m. ``spring_inertia_force`` = X Re H (eq. 5) and ``damping_force``
    = j X Im H (eq. 6): phasors of the force, N, for a motion of complex amplitude X. For a rotation
    read N m/rad, kg m^2, N m s/rad and N m.
    """

    real: Expr
    imag: Expr
    frequency: Symbol = omega
    """The symbol of omega."""

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
        return X * self.real

    @property
    def damping_force(self) -> Expr:
        """The force of the damper, for a motion of amplitude X: j X Im H."""
        return I * X * self.imag


@dataclass(frozen=True)
class ParameterJND:
    """How much a single parameter must change to be noticed: dk = c|H|, db = c|H|/omega, dm =
    c|H|/omega^2.

    N/m, N s/m and kg (for a rotation N m/rad, N m s/rad, kg m^2). Derived from eq. (4): a change of
    one parameter by p moves Re H by dk or -omega^2 dm, or Im H by omega db.
    """

    stiffness: Expr
    damping: Expr
    mass: Expr


def properties(response: Response, frequency: Symbol = omega) -> Properties:
    """The properties of a dynamics by its response on s = j omega; ``frequency`` : the symbol for
    omega in them."""
    real, imag = (x.factored().xreplace({omega: frequency}) for x in (response.real, response.imag))
    return Properties(real, imag, frequency)


def lowest(found: Sequence[Solution], values: Mapping[Symbol, Expr] | None = None) -> Expr | None:
    """The formula among ``found`` that is the lowest frequency: for these ``values`` of all
    parameters, or without them for all values at which it is in force. None where it is open.

    >>> from haptisym.kernel.rings import symbols
    >>> k, m = symbols("k m")
    >>> both = [Solution(x, k, conditions=(y,)) for x, y in ((sqrt(k - m), k - m), (sqrt(m - k), m - k))]
    >>> lowest(both), lowest(both, {k: Integer(5), m: Integer(1)})
    (None, sqrt(k - m))
    """
    if any(x.omega is None for x in found):
        return None
    if values is None:
        return next(
            (x.omega for x in found if all(x is other or _is_lower(x, other) for other in found)),
            None,
        )
    put = [
        (y.omega, y.conditions, x.omega)
        for x in found
        if (y := x.put(values)) and y.omega is not None
    ]
    if not put or any(conditions or not here.is_real for here, conditions, _ in put):
        return None
    (low, formula), *others = sorted(
        ((float(here), form) for here, _, form in put), key=itemgetter(0)
    )
    # Two zeros that meet as doubles may be one that is touched, where no sign changes.
    return None if others and others[0][0] - low <= 1e-9 * low else formula


def _is_lower(one: Solution, other: Solution) -> bool:
    """Whether ``one`` is proven to be in force wherever ``other`` is, and not above it there; False
    proves nothing."""
    assert one.omega is not None
    assert other.omega is not None
    if not set(one.conditions) <= set(other.conditions):
        return False
    # Both are positive where they are in force: they are in the order of their squares. Of the two
    # roots of a quadratic in omega^2 the squares differ by sqrt(discriminant)/a. The root is not
    # negative where it is real, so that the signs of the other factors decide.
    gap = factor_terms((other.omega**2 - one.omega**2).expand())
    known = (
        x.is_positive for x in Mul.make_args(gap) if not (x.is_Pow and x.exp == Rational(1, 2))
    )
    return bool((one.omega - other.omega).is_negative) or all(known)


# omega^2, the unknown of a threshold polynomial
_SQUARE = Symbol("W", positive=True)
# How many coefficients of numerator and denominator an expansion looks at before it gives up.
_TERMS = 24
# After this many coefficients without a leading term of Re or Im, the part is tested for being 0.
_SOON = 8
# Terms of a coefficient up to which it is factored for the reader.
_SHORT_TERM = 16

Frequencies = tuple[Solution, ...] | tuple[RealNumber, ...]
"""Formulas, each with the conditions under which it is in force; or, where all are numbers,
certified frequencies."""


class Changeovers(NamedTuple):
    """All frequencies at which Re H_env and Re H_perc change their sign."""

    environment: Frequencies
    perceived: Frequencies


class Asymptote(NamedTuple):
    """The leading terms of dH(s), of Re dH and of Im dH in omega."""

    distortion: Expr
    real: Expr
    imag: Expr


class LowFrequency(NamedTuple):
    """The perceived dynamics of slow motions: H_perc(s) = stiffness + damping s + mass s^2 + terms
    of higher order."""

    stiffness: Expr
    damping: Expr
    mass: Expr


def part_named(given: Any) -> Part:
    """Return the part that is given, or that has the given name, "real" or "imag"; SceneError for
    anything else."""
    if given in [x.value for x in Part]:
        return Part(given)
    if not isinstance(given, Part):
        raise SceneError(f"part: {quoted(given)}: give real or imag")
    return given


def threshold(given: Any, named: Mapping[str, str]) -> Expr:
    """Read a threshold: a fraction > 0, as a number or in symbols of its own. ``named`` : the names
    that are taken, and what they mean. SceneError for any other."""
    if isinstance(given, str):
        raise SceneError(
            f"c: {quoted(given)}: give a number or a symbol, as 0.1 or Rational(1, 10)"
        )
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
    # In squares there is no square root of |H_env|^2: zeros and signs stay those of polynomials.
    f = squared_ratio.function
    square = f.ring.convert(c**2)
    top = f.numerator * square.denominator - square.numerator * f.denominator
    return RealFunction(f.ring.function(top, f.denominator * square.denominator).reduced())


def crossings(squared_ratio: RealFunction, c: Expr, stand_in: Symbol) -> tuple[Solution, ...]:
    """The frequencies at which a ratio equals a threshold, as formulas; ``stand_in`` : the symbol
    that the ring has for a threshold."""
    if not c.free_symbols:
        return solve(excess(squared_ratio, c))
    solutions = solve(excess(squared_ratio, stand_in))
    # Squaring loses the sign of c: the condition c >= 0 goes along, and is left out where known.
    in_c = (replace(x, conditions=(*x.conditions, stand_in)).put({stand_in: c}) for x in solutions)
    return tuple(x for x in in_c if x is not None)


def zeros(f: RealFunction, band: tuple[Any, Any] | None) -> tuple[RealNumber, ...]:
    """All positive zeros of a function without free parameters, on a band if one is given, as
    certified numbers; none is missed."""
    return tuple(p.omega for p in _chart(f, band).points if p.orders.get(0, 0) > 0)


def sign_changes(f: RealFunction) -> tuple[RealNumber, ...]:
    """All positive frequencies at which a function without free parameters changes its sign, poles
    of odd order among them, as certified numbers."""
    # N D has the sign of N/D and no poles: a zero at which it changes its sign is a zero of N or a
    # pole, both of odd order.
    same_sign = RealFunction(f.axis.function(f.function.numerator * f.function.denominator))
    return tuple(p.omega for p in _chart(same_sign, None).sign_changes(0) if float(p.omega))


def _chart(f: RealFunction, band: tuple[Any, Any] | None) -> Chart:
    """The zeros and poles of a function on a band, or on all frequencies at which it has any."""
    low, high = _ends(band) if band else (Integer(0), _far(f))
    return chart({0: f}, low, high)


def unknown(*functions: RealFunction) -> set[Symbol]:
    """The parameters on which some functions depend."""
    return {x for f in functions for x in f.expression().free_symbols} - {omega}


def _ends(band: tuple[Any, Any]) -> tuple[Expr, Expr]:
    """The two ends of a band, rad/s, exact; SceneError unless 0 <= low < high."""
    low, high = (number(x, Dimension.FREQUENCY).value for x in given_band(band))
    if not 0 <= low < high:
        raise SceneError(f"band: {band}: give a low end >= 0 and a higher one, as (0, 15)")
    return low, high


def _far(f: RealFunction) -> Expr:
    """A frequency, rad/s, above which a function has no zero; SceneError where none is
    known, as with a delay."""
    if f.function.is_zero:
        return Integer(1)
    # A delay turns the phase for ever: r^2 - c^2 can change its sign at arbitrarily high omega.
    if any(not angle.constant for angle in f.axis.angles):
        raise SceneError(
            "with a delay there may be infinitely many crossings: give a band, as band=(0, 100)"
        )
    at_infinity = asymptotic_sign(f.function)
    if at_infinity.sense not in (Sense.POSITIVE, Sense.NEGATIVE):
        raise SceneError("the highest crossing is not known: give a band, as band=(0, 100)")
    return max(at_infinity.radius, Integer(1))


def threshold_polynomial(squared_ratio: RealFunction, c: Expr, stand_in: Symbol) -> Poly | Expr:
    """The polynomial in W = omega^2 that vanishes where a ratio equals a threshold; with delays or
    fractional powers an expression in omega. ``stand_in`` : the ring's symbol for a threshold."""
    f = excess(squared_ratio, stand_in if c.free_symbols else c)
    polynomial = f.function.expression().as_numer_denom()[0].expand().xreplace({stand_in: c})
    if not polynomial.is_polynomial(omega):
        return polynomial
    if any(n % 2 for (n,) in Poly(polynomial, omega).monoms()):
        return polynomial
    if _SQUARE.name in {x.name for x in polynomial.free_symbols}:
        raise SceneError(f"{_SQUARE} is reserved for omega^2: give the parameter another name")
    return Poly(polynomial.subs(omega, sqrt(_SQUARE)), _SQUARE)


def bandwidth(
    squared_ratios: Mapping[Part, RealFunction], c: Expr, band: tuple[Any, Any] | None
) -> RealNumber | Expr:
    """The upper end of the interval, from 0 or from the band's low end, on which no ratio exceeds
    c, rad/s; 0 where there is no such interval, oo where it has no end."""
    if free := unknown(*squared_ratios.values()) | c.free_symbols:
        named = ", ".join(sorted(map(str, free)))
        raise SceneError(
            f"a bandwidth needs values for {named}; crossings(part, c) has the formulas"
        )
    functions = {part: excess(f, c) for part, f in squared_ratios.items()}
    low, high = _ends(band) if band else (Integer(0), max(map(_far, functions.values())))
    table = chart(functions, low, high)
    satisfied = table.where(lambda signs: all(x <= 0 for x in signs.values()))
    # The bandwidth is the end of the interval that begins at the low end: one further up, behind
    # frequencies at which a ratio exceeds c, is none.
    if not satisfied or satisfied[0].low is not table.points[0]:
        return Integer(0)
    # Above the last point of a chart without a band no ratio crosses c any more.
    return oo if satisfied[0].high is table.points[-1] and not band else satisfied[0].high.omega


def asymptote(difference: RationalFunction, at: Any) -> Asymptote:
    """The leading terms of dH, Re dH and Im dH at 0 or oo; SceneError where an expansion in powers
    does not exist or does not show one within _TERMS terms."""
    if at not in (0, oo):
        raise SceneError(f"at: {quoted(at)}: give 0 or oo")
    if at == oo and ring_of(difference).lags:
        raise SceneError("at = oo: with a delay there is no leading term")
    if difference.is_zero:
        return Asymptote(Integer(0), Integer(0), Integer(0))
    leading: list[Expr | None] = [None, None, None]
    for n, (power, h) in enumerate(_expansion(difference, at)):
        # A part that does not come soon may vanish at all frequencies, and then never comes. That
        # is asked late, as Re and Im in lowest terms take longer than some coefficients.
        if n == _SOON:
            exact = on_axis(difference)
            vanishing = (False, exact.raw_real.is_zero, exact.raw_imag.is_zero)
            leading = [
                Integer(0) if gone else x for x, gone in zip(leading, vanishing, strict=True)
            ]
        if h != 0:
            # (j omega)^n = (-1)^(n//2) omega^n, times j for an odd n, whose term belongs to Im.
            sign = (-1) ** (power // 2)
            for place, term in ((0, h * s**power), (1 + power % 2, sign * h * omega**power)):
                if leading[place] is None:
                    leading[place] = term
        if None not in leading:
            return Asymptote(*leading)
    raise SceneError(f"no leading term up to order {_TERMS - 1}")


def low_frequency(perceived: RationalFunction) -> LowFrequency:
    """Stiffness, damping and mass at low frequency: the coefficients of s^0, s^1 and s^2 of H_perc.
    SceneError where H_perc has a pole at s = 0."""
    if perceived.is_zero:
        return LowFrequency(Integer(0), Integer(0), Integer(0))
    coefficients = {0: Integer(0), 1: Integer(0), 2: Integer(0)}
    for power, h in _expansion(perceived, 0):
        if power < 0 and h != 0:
            raise SceneError(
                "H_perc is infinite at rest: it has no stiffness, damping and mass there"
            )
        if power > 2:
            break
        if power >= 0:
            coefficients[power] = h
    return LowFrequency(*coefficients.values())


def _expansion(dynamics: RationalFunction, at: Any) -> Iterator[tuple[int, Expr]]:
    """Powers of s with their coefficients, from the leading one on: ascending at 0, descending at
    oo. Exact: a delay at 0 is its Taylor series.

    SceneError for a display with fractional powers of s.
    """
    ring = ring_of(dynamics)
    if ring.orders:
        raise SceneError("a display with fractional powers of s has no leading term")
    rows = [_Coefficients(p, ring, at == oo) for p in (dynamics.numerator, dynamics.denominator)]
    starts = [next((n for n in range(_TERMS) if row(n) != 0), _TERMS) for row in rows]
    if max(starts) == _TERMS:
        raise SceneError(f"no leading term up to order {_TERMS - 1}")
    above, below = (partial(row.from_, n) for row, n in zip(rows, starts, strict=True))
    degrees = [
        max(int(e[0]) for e in p.monoms()) for p in (dynamics.numerator, dynamics.denominator)
    ]
    first = starts[0] - starts[1]
    # Over a leading sum each coefficient is a quotient that must be reduced in a ring to stay
    # short; over a single product nothing has to be brought to one fraction.
    divide = _divided if below(0).is_Add else _over_one_term
    for n, h in enumerate(divide(above, below, ring, _TERMS - max(starts))):
        yield (first + n if at == 0 else degrees[0] - degrees[1] - first - n), h


_Row: TypeAlias = Callable[[int], Expr]


def _over_one_term(above: _Row, below: _Row, _: Ring, count: int) -> Iterator[Expr]:
    """The coefficients of a quotient of series whose denominator begins with one product, as of a
    chain of lags; nothing is brought to one fraction."""
    # q_n = a_n/b_0 - sum over i < n of q_i b_(n-i)/b_0: division of power series
    ratios: list[Expr] = []
    quotient: list[Expr] = []
    for n in range(count):
        ratios.append((below(n) / below(0)).expand())
        earlier = Add(*(h * ratios[n - i] for i, h in enumerate(quotient)))
        term = (above(n) / below(0) - earlier).expand()
        quotient.append(term)
        yield term.factor() if len(Add.make_args(term)) <= _SHORT_TERM else term


def _divided(above: _Row, below: _Row, ring: Ring, count: int) -> Iterator[Expr]:
    """The coefficients of a quotient of two power series, each in lowest terms."""
    into = Ring.of([*ring.symbols, *ring.lags, pi])
    bottom: list[RationalFunction] = []
    quotient: list[RationalFunction] = []
    for n in range(count):
        bottom.append(into.convert(below(n)))
        remainder = into.convert(above(n))
        for i, h in enumerate(quotient):
            remainder = remainder - h * bottom[n - i]
        term = (remainder / bottom[0]).reduced()
        quotient.append(term)
        is_short = len(term.numerator) + len(term.denominator) <= _SHORT_TERM
        yield term.factored() if is_short else term.expression()


class _Coefficients:
    """The coefficients of a polynomial in s: of s^0, s^1, ... with each delay as its series, or
    (``down``) of the highest power of s and of those below it; expanded."""

    def __init__(self, polynomial: Polynomial, ring: Ring, down: bool) -> None:  # noqa: FBT001
        self.ring = ring
        self.by_power: dict[int, list[tuple[list[int], Any]]] = {}
        highest = max(int(e[0]) for e in polynomial.monoms())
        for exponents, value in polynomial.to_dict().items():
            powers = [int(x) for x in exponents]
            index = highest - powers[0] if down else powers[0]
            self.by_power.setdefault(index, []).append((powers, value))

    def from_(self, start: int, n: int) -> Expr:
        """The n-th coefficient after the one of index ``start``."""
        return self(start + n)

    @cache  # noqa: B019 - as short-lived as the question
    def __call__(self, n: int) -> Expr:
        ring, total = self.ring, []
        for power in (x for x in self.by_power if x <= n):
            for powers, value in self.by_power[power]:
                # A monomial is s^e pi^e ... times delays exp(-s lag). It adds to s^n by the term of
                # order n - power of the delays' series; without a delay only to its own power.
                lag = Add(*(m * x for x, m in zip(ring.lags, powers[ring.size :], strict=False)))
                if power < n and lag == 0:
                    continue
                factors = (x**m for x, m in zip(ring.symbols, powers[2 : ring.size], strict=True))
                taylor = (-lag) ** (n - power) / factorial(n - power)
                total.append(
                    Mul(Rational(int(value.p), int(value.q)), pi ** powers[1], *factors, taylor)
                )
        return Add(*total).expand()
