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
    """The dynamics themselves: H_env, what is rendered for it, and the effects' chain matrices,
    nearest the environment first."""

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
        found = ring.convert(self.rendered)
        for i in places:
            found = _through(found, [ring.convert(entry) for entry in self.matrices[i]])
        return found.reduced()

    @cached_property
    def ring(self) -> Ring:
        """The ring that holds them all."""
        # a threshold comes along so that it may stay a symbol; a variable that does not occur costs
        # nothing
        return Ring.of([*self.entries(), self.stand_in])

    @cached_property
    def stand_in(self) -> Symbol:
        """What stands for a threshold in the ring: c, or a like name where a parameter has that."""
        own = {x.name for entry in self.entries() for x in entry.free_symbols}
        name = symbol_c.name
        while name in own:
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

    def program(self, fields: Sequence[str]) -> Program:
        """The straight-line program of some fields of ``numeric.Values``; what is 0 everywhere is
        written as 0."""
        from haptisym.programs.balls import BallPoint  # a certified answer needs no program

        write = _writer(self.environment, self.rendered, self.matrices, self.parameters)
        program = write(fields, ())
        # a value that is not 0 at some point settles that a field is not 0 everywhere
        sample = BallPoint(program, tuple(1.25 + n / 8 for n in range(len(program.inputs)))).balls(
            128
        )
        zero = [name for name in fields if sample[name].contains(0) and self.vanishes(name)]
        return write(fields, zero) if zero else program

    def vanishes(self, name: str) -> bool:
        """Whether a field is 0 at all frequencies, whatever the parameters."""
        kind, _, part = name.rpartition("_")
        env, perc = self.dynamics(free_air=kind == "perceived")
        change = perc - env
        of = (
            change / env
            if kind == "relative"
            else {"environment": env, "perceived": perc}.get(kind, change)
        )
        raw = on_axis(of)
        return (raw.raw_real if part == "real" else raw.raw_imag).is_zero

    @cached_property
    def steps(self) -> Steps:
        """All fields of ``numeric.Values`` in named steps, as a page shows them: of what is felt,
        H_env + dH."""
        from haptisym.programs.steps import DISTORTION, Steps, page_steps

        found = page_steps(self.program((*DISTORTION, "environment_real", "environment_imag")))
        of = found.results
        felt = {
            f"perceived_{part.value}": of[f"environment_{part.value}"] + of[part.value]
            for part in Part
        }
        return Steps(found.definitions, {**of, **felt})

    @property
    def in_series(self) -> bool:
        """Whether each effect multiplies the force, and does nothing else."""
        return all(b == 0 and c == 0 for _, b, c, _ in self.matrices)

    def part_of_distortion(self, part: Part, environment: Expr) -> Expr:
        """Re or Im dH, less that part of H_env as it is given: in series in magnitudes and
        angles."""
        if not self.in_series:
            return _PART[part](self.formula, evaluate=False) - environment
        return self._turned(part, [self.rendered, *self._gains]) - environment

    def part_of_relative(self, part: Part) -> Expr:
        """Re or Im(dH/H_env)."""
        if not self.in_series:
            H = self.environment.xreplace({s: I * omega})
            return _PART[part](self.formula / H, evaluate=False) - Integer(part is Part.REAL)
        own = [] if self.rendered == self.environment else [self.rendered, 1 / self.environment]
        return self._turned(part, [*own, *self._gains]) - Integer(part is Part.REAL)

    @property
    def formula(self) -> Expr:
        """H_perc(j omega), as the chain builds it."""
        H = self.rendered
        for a, b, c, d in self.matrices:
            H = (a * H + b) / (c * H + d)
        return H.xreplace({s: I * omega})

    @property
    def _gains(self) -> list[Expr]:
        return [a / d for a, _, _, d in self.matrices]

    @staticmethod
    def _turned(part: Part, factors: Sequence[Expr]) -> Expr:
        polar = [_polar(x) for x in factors]
        return Mul(*(size for size, _ in polar)) * _TURN[part](Add(*(angle for _, angle in polar)))

    def without_axis_zeros(self) -> tuple[Chain, bool]:
        """A chain with the same ratios, though H_env has no zeros on s = j omega; whether r_r is
        its r_i.

        All dynamics are taken over the factors Z of H_env that are real or imaginary there: H/Z
        behind [[A, B/Z], [C Z, D]].
        """
        environment = self.ring.convert(self.environment).reduced()
        Z = self.ring.function(_axis_zeros(self.ring, environment.numerator))
        if Z.numerator.is_constant():
            return self, False

        def times(x: Expr, power: int) -> Expr:
            return (self.ring.convert(x) * Z**power).reduced().expression() if x else x

        matrices = tuple((a, times(b, -1), times(c, 1), d) for a, b, c, d in self.matrices)
        odd = int(Z.numerator.monoms()[0][0]) % 2 == 1
        return Chain(times(self.environment, -1), times(self.rendered, -1), matrices), odd

    def at(self, values: Mapping[Symbol, Expr]) -> Chain:
        """The same chain with values for some of its symbols."""
        return self.map(lambda entry: in_place(entry, values))

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
    """What writes the programs of a chain, all from the same steps."""
    from haptisym.programs.distortion import stable_program

    return stable_program(environment, rendered, matrices, inputs)


def _axis_zeros(ring: Ring, polynomial: Polynomial) -> Polynomial:
    """The factors of a polynomial that can vanish on s = j omega: s itself, and those in s^2."""
    found = ring.constant(1)
    for factor, n in ring.factors(polynomial, in_square=False)[1] if polynomial else ():
        even = len({int(exponents[0]) % 2 for exponents in factor.monoms()}) == 1
        if factor.degrees()[0] and even and not any(factor.degrees()[ring.size :]):
            found = found * factor**n
    return found


def _through(H: RationalFunction, matrix: Sequence[RationalFunction]) -> RationalFunction:
    """The Moebius map (A H + B)/(C H + D), without fractions inside."""
    a, b, c, d = cleared(matrix)
    top = a * H.numerator + b * H.denominator
    bottom = c * H.numerator + d * H.denominator
    if bottom.is_zero():
        raise SceneError(
            "the effects make H_perc infinite at every frequency (C H + D = 0): change one of them"
        )
    return RationalFunction(H.ring, top, bottom)


_SHORT = 10  # terms of a dynamics up to which lowest terms are it
_FEW, _MOST = (
    80,
    300,
)  # up to which they are looked at beside factors, and are made where there are none
_LONGER = 1.3  # lowest terms are kept where they are no longer than this
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
    found = lowest()
    return (found, True) if count_ops(found) <= _LONGER * count_ops(other) else (other, False)


def _polar(factor: Expr) -> tuple[Expr, Expr]:
    """Magnitude, which may be negative, and angle of a factor on s = j omega."""
    above, below = factor.as_numer_denom()
    size, angle = Integer(1), Integer(0)
    for x, sign in [(x, 1) for x in Mul.make_args(above)] + [(x, -1) for x in Mul.make_args(below)]:
        base, power = x.as_base_exp() if not isinstance(x, exp) else (x, Integer(1))
        n = sign * power if power.is_Integer else Integer(sign)
        own = _own(base if power.is_Integer else x)
        size, angle = size * own[0] ** n, angle + own[1] * n
    return size, angle


def _own(x: Expr) -> tuple[Expr, Expr]:
    base, power = (s, x.args[0] / s) if isinstance(x, exp) else x.as_base_exp()
    if isinstance(x, exp) and not power.has(s):  # a delay
        return Integer(1), omega * power
    if base == s and not power.has(s):
        return omega**power, pi * power / 2
    for sign, rest in (
        (1, x + 1),
        (-1, 1 - x),
    ):  # of a hold: +-(exp(s T) - 1) = +-exp(s T/2) 2 sinh(s T/2)
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
    """Of the dynamics that has this response, with that symbol for omega."""
    real, imag = (x.factored().xreplace({omega: frequency}) for x in (response.real, response.imag))
    return Properties(real, imag, frequency)


def lowest(found: Sequence[Solution], values: Mapping[Symbol, Expr] | None = None) -> Expr | None:
    """The formula among some that is the lowest frequency, for these values if there are any; None
    where it is not known.

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
    # two zeros that meet as doubles may be one that is touched, where no sign changes
    return None if others and others[0][0] - low <= 1e-9 * low else formula


def _is_lower(one: Solution, other: Solution) -> bool:
    """Whether a formula is in force wherever another one is, and below it there: proven."""
    assert one.omega is not None
    assert other.omega is not None
    if not set(one.conditions) <= set(other.conditions):
        return False
    gap = factor_terms(
        (other.omega**2 - one.omega**2).expand()
    )  # of two roots: the root of a discriminant, over a
    known = (
        x.is_positive for x in Mul.make_args(gap) if not (x.is_Pow and x.exp == Rational(1, 2))
    )
    return bool((one.omega - other.omega).is_negative) or all(known)


_SQUARE = Symbol("W", positive=True)  # omega^2, the unknown of a threshold polynomial
_TERMS = 24  # of the expansions of numerator and denominator
_SOON = 8  # terms of an expansion
_SHORT_TERM = 16  # terms of a coefficient that is taken apart

Frequencies = tuple[Solution, ...] | tuple[RealNumber, ...]
"""Formulas, each with the conditions under which it is in force; or, where all are numbers,
certified frequencies."""


class Changeovers(NamedTuple):
    """Where Re H_env and Re H_perc change their sign, all of them."""

    environment: Frequencies
    perceived: Frequencies


class Asymptote(NamedTuple):
    """The leading terms of dH(s), of Re dH and of Im dH in omega."""

    distortion: Expr
    real: Expr
    imag: Expr


class LowFrequency(NamedTuple):
    """What a slow hand feels: H_perc(s) = stiffness + damping s + mass s^2 + terms of higher
    order."""

    stiffness: Expr
    damping: Expr
    mass: Expr


def part_named(given: Any) -> Part:
    """A part, or its name. SceneError for any other."""
    if given in [x.value for x in Part]:
        return Part(given)
    if not isinstance(given, Part):
        raise SceneError(f"part: {quoted(given)}: give real or imag")
    return given


def threshold(given: Any, named: Mapping[str, str]) -> Expr:
    """A fraction > 0, as a number or in symbols of its own; ``named`` : what other names mean.
    SceneError for any other."""
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
    """r^2 - c^2."""
    f = squared_ratio.function
    square = f.ring.convert(c**2)
    top = f.numerator * square.denominator - square.numerator * f.denominator
    return RealFunction(f.ring.function(top, f.denominator * square.denominator).reduced())


def crossings(squared_ratio: RealFunction, c: Expr, stand_in: Symbol) -> tuple[Solution, ...]:
    """Where a ratio meets a threshold, as formulas; ``stand_in`` : what the ring has for a
    threshold."""
    if not c.free_symbols:
        return solve(excess(squared_ratio, c))
    found = solve(excess(squared_ratio, stand_in))
    asked = (replace(x, conditions=(*x.conditions, stand_in)).put({stand_in: c}) for x in found)
    return tuple(x for x in asked if x is not None)


def zeros(f: RealFunction, band: tuple[Any, Any] | None) -> tuple[RealNumber, ...]:
    """All positive zeros of a function that is known, on a band if one is given: certified
    numbers."""
    return tuple(p.omega for p in _chart(f, band).points if p.orders.get(0, 0) > 0)


def sign_changes(f: RealFunction) -> tuple[RealNumber, ...]:
    """Where a function that is known changes its sign, poles among them: certified numbers."""
    alike = RealFunction(
        f.axis.function(f.function.numerator * f.function.denominator)
    )  # of its sign, and without poles
    return tuple(p.omega for p in _chart(alike, None).sign_changes(0) if float(p.omega))


def _chart(f: RealFunction, band: tuple[Any, Any] | None) -> Chart:
    low, high = _ends(band) if band else (Integer(0), _far(f))
    return chart({0: f}, low, high)


def unknown(*functions: RealFunction) -> set[Symbol]:
    """The parameters on which some functions depend."""
    return {x for f in functions for x in f.expression().free_symbols} - {omega}


def _ends(band: tuple[Any, Any]) -> tuple[Expr, Expr]:
    low, high = (number(x, Dimension.FREQUENCY).value for x in given_band(band))
    if not 0 <= low < high:
        raise SceneError(f"band: {band}: give a low end >= 0 and a higher one, as (0, 15)")
    return low, high


def _far(f: RealFunction) -> Expr:
    """A frequency beyond which a function has no zero."""
    if f.function.is_zero:
        return Integer(1)
    if any(not angle.constant for angle in f.axis.angles):
        raise SceneError(
            "with a delay there may be infinitely many crossings: give a band, as band=(0, 100)"
        )
    found = asymptotic_sign(f.function)
    if found.sense not in (Sense.POSITIVE, Sense.NEGATIVE):
        raise SceneError("the highest crossing is not known: give a band, as band=(0, 100)")
    return max(found.radius, Integer(1))


def threshold_polynomial(squared_ratio: RealFunction, c: Expr, stand_in: Symbol) -> Poly | Expr:
    """What vanishes where a ratio meets a threshold; ``stand_in`` : what the ring has for a
    threshold."""
    f = excess(squared_ratio, stand_in if c.free_symbols else c)
    found = f.function.expression().as_numer_denom()[0].expand().xreplace({stand_in: c})
    if not found.is_polynomial(omega) or any(n % 2 for (n,) in Poly(found, omega).monoms()):
        return found
    if _SQUARE.name in {x.name for x in found.free_symbols}:
        raise SceneError(f"{_SQUARE} is reserved for omega^2: give the parameter another name")
    return Poly(found.subs(omega, sqrt(_SQUARE)), _SQUARE)


def bandwidth(
    squared_ratios: Mapping[Part, RealFunction], c: Expr, band: tuple[Any, Any] | None
) -> RealNumber | Expr:
    """The end of the interval from 0, or the band's low end, on which no ratio exceeds c."""
    if free := unknown(*squared_ratios.values()) | c.free_symbols:
        named = ", ".join(sorted(map(str, free)))
        raise SceneError(
            f"a bandwidth needs values for {named}; crossings(part, c) has the formulas"
        )
    functions = {part: excess(f, c) for part, f in squared_ratios.items()}
    low, high = _ends(band) if band else (Integer(0), max(map(_far, functions.values())))
    table = chart(functions, low, high)
    kept = table.where(lambda signs: all(x <= 0 for x in signs.values()))
    if not kept or kept[0].low is not table.points[0]:
        return Integer(0)
    return oo if kept[0].high is table.points[-1] and not band else kept[0].high.omega


def asymptote(difference: RationalFunction, at: Any) -> Asymptote:
    """The leading terms at 0 or oo."""
    if at not in (0, oo):
        raise SceneError(f"at: {quoted(at)}: give 0 or oo")
    if at == oo and ring_of(difference).lags:
        raise SceneError("at = oo: with a delay there is no leading term")
    if difference.is_zero:
        return Asymptote(Integer(0), Integer(0), Integer(0))
    found: list[Expr | None] = [None, None, None]
    for n, (power, h) in enumerate(_expansion(difference, at)):
        if n == _SOON:  # a part that does not come soon may vanish: asked late, as it takes longer
            exact = on_axis(difference)
            vanishing = (False, exact.raw_real.is_zero, exact.raw_imag.is_zero)
            found = [Integer(0) if gone else x for x, gone in zip(found, vanishing, strict=True)]
        if h != 0:
            sign = (-1) ** (power // 2)  # of j^power, but for the j of an odd one
            for place, term in ((0, h * s**power), (1 + power % 2, sign * h * omega**power)):
                found[place] = term if found[place] is None else found[place]
        if None not in found:
            return Asymptote(*found)
    raise SceneError(f"no leading term up to order {_TERMS - 1}")


def low_frequency(perceived: RationalFunction) -> LowFrequency:
    """The first terms in s, from its static value on."""
    if perceived.is_zero:
        return LowFrequency(Integer(0), Integer(0), Integer(0))
    found = {0: Integer(0), 1: Integer(0), 2: Integer(0)}
    for power, h in _expansion(perceived, 0):
        if power < 0 and h != 0:
            raise SceneError(
                "H_perc is infinite at rest: it has no stiffness, damping and mass there"
            )
        if power > 2:
            break
        if power >= 0:
            found[power] = h
    return LowFrequency(*found.values())


def _expansion(dynamics: RationalFunction, at: Any) -> Iterator[tuple[int, Expr]]:
    """Powers of s and their coefficients, from the leading one on: ascending at 0, descending at
    oo. Exact.

    SceneError for what is not rational in s but for delays.
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
    divide = _divided if below(0).is_Add else _over_one_term
    for n, h in enumerate(divide(above, below, ring, _TERMS - max(starts))):
        yield (first + n if at == 0 else degrees[0] - degrees[1] - first - n), h


_Row: TypeAlias = Callable[[int], Expr]


def _over_one_term(above: _Row, below: _Row, _: Ring, count: int) -> Iterator[Expr]:
    """Of a quotient whose denominator begins with one product, as of a chain of lags: nothing is
    brought to one fraction."""
    ratios: list[Expr] = []
    found: list[Expr] = []
    for n in range(count):
        ratios.append((below(n) / below(0)).expand())
        found.append(
            (above(n) / below(0) - Add(*(h * ratios[n - i] for i, h in enumerate(found)))).expand()
        )
        yield found[-1].factor() if len(Add.make_args(found[-1])) <= _SHORT_TERM else found[-1]


def _divided(above: _Row, below: _Row, ring: Ring, count: int) -> Iterator[Expr]:
    into = Ring.of([*ring.symbols, *ring.lags, pi])
    bottom: list[RationalFunction] = []
    found: list[RationalFunction] = []
    for n in range(count):
        bottom.append(into.convert(below(n)))
        left = into.convert(above(n))
        for i, h in enumerate(found):
            left = left - h * bottom[n - i]
        found.append((left / bottom[0]).reduced())
        is_short = len(found[-1].numerator) + len(found[-1].denominator) <= _SHORT_TERM
        yield found[-1].factored() if is_short else found[-1].expression()


class _Coefficients:
    """Of s^0, s^1, ... with each delay as its series, or (``down``) of the highest power of s and
    those below it; expanded."""

    def __init__(self, polynomial: Polynomial, ring: Ring, down: bool) -> None:  # noqa: FBT001
        self.ring = ring
        self.by_power: dict[int, list[tuple[list[int], Any]]] = {}
        highest = max(int(e[0]) for e in polynomial.monoms())
        for exponents, value in polynomial.to_dict().items():
            own = [int(x) for x in exponents]
            self.by_power.setdefault(highest - own[0] if down else own[0], []).append((own, value))

    def from_(self, start: int, n: int) -> Expr:
        """The n-th from one on."""
        return self(start + n)

    @cache  # noqa: B019 - as short-lived as the question
    def __call__(self, n: int) -> Expr:
        ring, total = self.ring, []
        for power in (x for x in self.by_power if x <= n):
            for own, value in self.by_power[power]:
                lag = Add(*(m * x for x, m in zip(ring.lags, own[ring.size :], strict=False)))
                if power < n and lag == 0:
                    continue
                factors = (x**m for x, m in zip(ring.symbols, own[2 : ring.size], strict=True))
                late = (-lag) ** (n - power) / factorial(n - power)
                total.append(
                    Mul(Rational(int(value.p), int(value.q)), pi ** own[1], *factors, late)
                )
        return Add(*total).expand()
