"""Conditions as functions of one free parameter t, and what is exact about them: the values of t at
which they can change.

A condition N(omega, t) <= 0, N a polynomial, can change only where a zero of N in omega enters over
an end of the band, N(end, t) = 0, or where two zeros meet: where the discriminant of a factor of N
or the resultant of two factors vanishes. These *critical values* are roots of polynomials in t
(``critical``, ``real_roots``). The boundary of a map of two parameters is a zero of the same
polynomials, and so are the values at which signs at rest and at high frequency change
(``ExactSign``), and those at which a scene does not exist: where its environment is zero
everywhere, or it is divided by 0 (``missing``).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from itertools import combinations, product
from math import prod
from typing import TYPE_CHECKING, TypeAlias

import flint
from flint import fmpq
from sympy import Expr, Integer, Symbol

from haptisym.judge.bindings import Kind
from haptisym.judge.bounds import ANY_ENVIRONMENT, for_any_environment, is_series
from haptisym.judge.crossings import Criterion, noticed, opened
from haptisym.kernel.axis import Axis
from haptisym.kernel.dynamics import RealFunction, Ring
from haptisym.kernel.errors import SceneError
from haptisym.kernel.reals import ExactNumber, RealNumber, expression_ball
from haptisym.kernel.rings import Polynomial, RationalFunction, monomials, omega
from haptisym.kernel.roots import Lattice, sign_of_number
from haptisym.model.distortion import Distortion
from haptisym.model.existence import allowed as allowed
from haptisym.model.existence import missing as missing
from haptisym.model.existence import real_roots as real_roots
from haptisym.model.jnd import Part
from haptisym.model.parameters import values
from haptisym.model.scene import THRESHOLD, Knob, Scene

if TYPE_CHECKING:
    from haptisym.kernel.where import Cells


def asked_of(
    scene: Scene, free: Sequence[Knob], part: Part | None, *, any_environment: bool
) -> tuple[Criterion, ...]:
    """The criteria that are to hold on the whole band: those of one part, of both (None), or |G -
    1| <= c for any environment. SceneError for what does not go together."""
    if not any_environment:
        found = noticed(scene.threshold)
        if part is None:
            return found
        if any(x.part is None for x in found):
            raise SceneError(
                f"part: a JND region of the shape {scene.threshold.region.shape.value} judges both "
                "parts at once: leave the part out"
            )
        # What keeps one part alone below its threshold must not be called transparent.
        return tuple(replace(x, kept=f"{x.kept} in the {x.words}") for x in found if x.part is part)
    if part is not None:
        raise SceneError("for any environment there are no parts: ask for one or the other")
    if any(x.path.startswith("environment.") for x in free):
        raise SceneError("for any environment no parameter of the environment can be free")
    if any(len(x.parts) == 1 for x in free):
        raise SceneError(f"for any environment the thresholds are one: leave {THRESHOLD} free")
    return (for_any_environment(scene.threshold),)


@dataclass(frozen=True, eq=False)
class JudgedValues:
    """A verdict on all values between two: ``kept`` tells whether they keep all conditions on all
    of the band; None where that is not known.

    ``slant`` : not None where it is proven that an open interval, between values that keep the
    conditions and values that do not, holds just one end. What is broken at a frequency for one of
    its values is then broken for all beyond it, at a frequency that moves by no more than that,
    rad/s for one unit. ``open`` : the cells that are left in there.
    """

    low: Fraction
    high: Fraction
    kept: bool | None
    slant: float | None = None
    open: Cells | None = None

    @property
    def is_narrow(self) -> bool:
        """Whether it is as narrow as cells are that are cut no further, or nearly so."""
        return self.high - self.low <= _NARROW * max(-self.low, self.high)


# Relative width of an interval by which its end is known well enough to be told: ten digits.
_NARROW = Fraction(1, 10**9)


def merged(cells: Iterable[JudgedValues]) -> list[JudgedValues]:
    """Runs of values, neighbours with one verdict merged; what holds just one end stays apart."""
    runs = list[JudgedValues]()
    for x in cells:
        last = runs[-1] if runs else None
        if last is not None and last.kept is x.kept and last.slant is None and x.slant is None:
            runs[-1] = replace(last, high=x.high)
        else:
            runs.append(x)
    return runs


def ladder(low: float, high: float, scale: float) -> list[float]:
    """Numbers from one to another at which cells begin: powers of 2 times a usual size, on both
    sides of 0, so that within a cell values differ by no more than a factor of 2."""
    # Around 0 cells are cut as far as is needed: no use to begin with smaller ones.
    sizes = [scale * 2.0**n for n in range(-60 if low * high > 0 else -20, 60)]
    marks = [-x for x in sizes] + [0.0] + sizes
    return sorted({low, high, *(x for x in marks if low < x < high)})


Condition: TypeAlias = RealFunction | Lattice
"""A function of omega and the free parameters that must not be positive; as a lattice of one term,
several of which at least one must not be."""
Conditions: TypeAlias = Mapping[Criterion, Condition]


def pieces(condition: Condition) -> tuple[RealFunction, ...]:
    """The functions that must not all be positive: one, or those of a term."""
    if isinstance(condition, RealFunction):
        return (condition,)
    [term] = condition.terms
    return term


def conditions(
    scene: Scene,
    free: Iterable[Knob],
    criteria: Iterable[Criterion],
    seen: Callable[[Distortion], Distortion] = lambda d: d,
) -> dict[Criterion, Condition]:
    """What criteria ask, with the free parameters left as symbols; a region with several terms is
    one condition for each.

    ``seen`` : a map of the distortion to the form in which it is judged.
    """
    listed = [x.felt() for x in free]
    d, parts = seen(_distortion(scene, listed)), {part for x in listed for part in x.parts}
    found: dict[Criterion, Condition] = {}
    for x in opened(criteria, parts):
        own = x.function(d)
        terms = own.terms if isinstance(own, Lattice) else ((own,),)
        for i, term in enumerate(terms, 1):
            name = each(x, i) if len(terms) > 1 else x
            found[name] = Lattice((tuple(map(_upright, term)),)) if len(term) > 1 else term[0]
    return found


def each(x: Criterion, place: int) -> Criterion:
    """One of several conditions that a criterion is."""
    return replace(x, rule=f"{x.rule} ({place})")


def _distortion(scene: Scene, free: list[Knob]) -> Distortion:
    scene.knobs.need_numbers(free)
    return Distortion.of(scene.chain.at(values(x for x in scene.parameters if x not in free)))


def _upright(found: RealFunction) -> RealFunction:
    """The function with all factors that change sign in its numerator, so that this has its sign.

    Times a square: numerator and denominator are both multiplied with the factors of odd power.
    """
    f = found.function
    constant, factors = f.denominator.factor()
    turning = [factor for factor, n in factors if n % 2 and not _is_positive(factor)]
    if not turning and constant > 0:
        return RealFunction(f)
    top = prod(turning, start=f.numerator * constant)
    return RealFunction(
        f.ring.function(top, f.denominator * prod(turning, start=f.ring.constant(constant)))
    )


def _is_positive(polynomial: Polynomial) -> bool:
    """Whether a factor shows to be positive: by even powers with positive coefficients, or as |f(j
    omega)|^2."""
    even = not any(n % 2 for row in polynomial.monoms() for n in row)
    return (even and all(x > 0 for x in polynomial.coeffs())) or _is_modulus(polynomial)


def is_kept_anyway(scene: Scene, free: Sequence[Knob], x: Criterion, own: Condition) -> bool:
    """Whether a condition is kept for all free parameters, phases of delays and frequencies, as the
    signs of its factors show. False proves nothing.

    Either by itself, or as r <= |G - 1| for effects in series, whose bound may be shown to be kept.
    """
    if any(_is_never_positive(f.function.numerator) for f in pieces(own)):
        return True
    is_plain = x.part is not None and x.region is None and not x.threshold.has(omega)
    if (
        not is_plain
        or any(knob.parts for knob in free)
        or not any(f.axis.angles for f in pieces(own))
        or not is_series(scene.chain)
    ):
        return False
    larger = conditions(scene, free, [replace(ANY_ENVIRONMENT, threshold=x.threshold)]).values()
    return all(_is_never_positive(f.function.numerator) for bound in larger for f in pieces(bound))


# Terms of a polynomial that is factored: nothing interrupts FLINT while it does that.
_MOST_FACTORED = 300


def _is_never_positive(polynomial: Polynomial) -> bool:
    """Whether a polynomial is shown to be positive nowhere, for any real variables: by factors of
    even power or one sign. False proves nothing."""
    if len(polynomial) > _MOST_FACTORED:
        return False
    constant, factors = polynomial.factor()
    signs = [_sign_of_all(factor) for factor, n in factors if n % 2]
    return bool(None not in signs and prod(signs, start=constant) <= 0)  # type: ignore[arg-type]


def _sign_of_all(factor: Polynomial) -> int | None:
    """The sign of an irreducible polynomial that has one; None where that does not show."""
    if _is_positive(factor):
        return 1
    # A polynomial in one variable without a real zero has the sign of its value at 0.
    [*used] = (i for i, n in enumerate(factor.degrees()) if n)
    first = factor.to_dict().get((0,) * len(factor.degrees()))
    if (
        len(used) != 1
        or first is None
        or any(True for _ in real_roots(factor, used[0], negative=True))
    ):
        return None
    return 1 if first > 0 else -1


def _is_modulus(polynomial: Polynomial) -> bool:
    """Whether an irreducible polynomial in omega is |f(j omega)|^2 for some f, and so not negative.

    With s = j omega it is then f(s) f(-s), which factors; irreducible in omega, but not in s.
    """
    rows = dict(monomials(polynomial))
    if any(row[0] % 2 for row in rows) or polynomial.leading_coefficient() < 0:
        return False
    in_s = polynomial.context().from_dict({row: -x if row[0] % 4 else x for row, x in rows.items()})
    return len(in_s.factor()[1]) > 1


Reason: TypeAlias = tuple[Criterion, Kind] | None
"""Which condition is critical, and how; None: the condition is nowhere defined."""


def critical(
    criterion: Criterion, pieces: Sequence[RealFunction], band: tuple[Expr, Expr]
) -> Iterator[tuple[Reason, Polynomial]]:
    """The polynomials in pi and the parameter whose roots are critical for a condition on a band,
    and why each is.

    ``pieces`` : the functions of the condition, which must not all be positive.
    """
    ring = pieces[0].axis
    factors: list[Polynomial] = []
    for piece in pieces:
        for factor, _ in irreducible(piece.function.denominator):
            if not factor.degrees()[0]:
                yield None, factor
        # An even power changes no sign, unless it holds the parameter alone: then it is 0 at all
        # omega.
        own = [f for f, n in irreducible(piece.function.numerator) if n % 2 or not f.degrees()[0]]
        factors += [f for f in own if f not in factors]
    for f in factors:
        for kind, end in zip((Kind.START, Kind.EDGE), band, strict=True):
            yield (criterion, kind), substituted(f, 0, ring.convert(end))
        # Two zeros in omega^2 (in omega, where it is not even) must be there to meet.
        if f.degrees()[0] > (2 if is_even(f) else 1):
            yield (criterion, Kind.TOUCH), in_square(f).discriminant(0)
    for f, g in combinations([f for f in factors if f.degrees()[0] and f != ring.variable], 2):
        if is_even(f) and is_even(g):
            f, g = in_square(f), in_square(g)
        yield (criterion, Kind.TOUCH), f.resultant(g, 0)


def irreducible(polynomial: Polynomial) -> list[tuple[Polynomial, int]]:
    """Irreducible factors, in omega^2 where the whole is even in omega."""
    if not is_even(polynomial):
        return [(f, int(n)) for f, n in polynomial.factor()[1]]
    steps = [2, *[1] * (len(polynomial.degrees()) - 1)]
    return [(f.inflate(steps), int(n)) for f, n in polynomial.deflate(steps).factor()[1]]


def is_even(polynomial: Polynomial) -> bool:
    """Whether a polynomial is even in its first variable, omega."""
    return not any(int(e[0]) % 2 for e in polynomial.monoms())


def in_square(polynomial: Polynomial) -> Polynomial:
    """An even polynomial as one in omega^2."""
    return (
        polynomial.deflate([2, *[1] * (len(polynomial.degrees()) - 1)])
        if is_even(polynomial)
        else polynomial
    )


def substituted(polynomial: Polynomial, index: int, value: RationalFunction) -> Polynomial:
    """A polynomial with a number for one of its variables, times a positive number."""
    if value.denominator.is_constant() and value.numerator.is_constant():
        number = _constant(value.numerator) / _constant(value.denominator)
        return polynomial.subs({f"x{index}": number})
    degree = int(polynomial.degrees()[index])
    degree += degree % 2  # an even power of the denominator keeps the sign
    context = polynomial.context()
    powers: dict[int, dict[tuple[int, ...], fmpq]] = {}
    for exponents, coefficient in monomials(polynomial):
        own = [int(n) for n in exponents]
        power, own[index] = own[index], 0
        powers.setdefault(power, {})[tuple(own)] = coefficient
    return sum(
        (
            context.from_dict(terms) * value.numerator**n * value.denominator ** (degree - n)
            for n, terms in powers.items()
        ),
        context.constant(0),
    )


def _constant(polynomial: Polynomial) -> fmpq:
    return next(iter(polynomial.to_dict().values()), fmpq(0))


def edge_polynomial(pieces: Sequence[RealFunction], end: Expr) -> Expr:
    """The polynomial in the parameters that vanishes where a rational condition binds at a
    frequency."""
    axis = _without_functions(pieces)
    tops = [substituted(piece.function.numerator, 0, axis.convert(end)) for piece in pieces]
    return axis.factored_expression(prod(tops[1:], start=tops[0]))


def touch_polynomial(pieces: Sequence[RealFunction]) -> Expr:
    """The polynomial in the parameters that vanishes where a rational condition binds inside the
    band: a product of discriminants in omega^2, and of resultants where it has several
    functions."""
    axis = _without_functions(pieces)
    own = [
        [f for f, n in irreducible(piece.function.numerator) if n % 2 and f.degrees()[0]]
        for piece in pieces
    ]
    found = axis.constant(1)
    for f in (f for factors in own for f in factors):
        found *= in_square(f).discriminant(0) if f.degrees()[0] > (2 if is_even(f) else 1) else 1
    for f, g in (
        pair
        for one, other in combinations(own, 2)
        for pair in product(one, other)
        if pair[0] != pair[1]
    ):
        found *= (
            in_square(f).resultant(in_square(g), 0)
            if is_even(f) and is_even(g)
            else f.resultant(g, 0)
        )
    return axis.factored_expression(found)


def _without_functions(pieces: Sequence[RealFunction]) -> Axis:
    """The axis of rational functions. SceneError where they hold delays or powers of s."""
    if pieces[0].axis.functions:
        raise SceneError("with delays or powers of s the boundary is no polynomial's zero")
    return pieces[0].axis


_BITS = 256


def zeros_of(form: Expr, symbol: Symbol) -> list[RealNumber]:
    """The real zeros of a polynomial that is not 0 everywhere, each once; its coefficients are
    rational in pi."""
    axis = Ring.of([form * symbol]).axis
    index = axis.meanings.index(symbol)
    factors = [f for f, _ in axis.convert(form).numerator.factor()[1]]
    return [x for f in factors for x in real_roots(f, index, negative=True)]


def is_between(low: Expr | None, x: RealNumber, high: Expr | None) -> bool:
    """Whether a number lies between two others (None: without bound).

    True also where it is so near to one of them that 256 bits do not tell: then it counts as
    inside, and no sign is claimed for all values between the two.
    """
    if isinstance(x, ExactNumber) and x.value.is_Rational:
        is_above_low = low is None or bool(low < x.value)
        return is_above_low and (high is None or bool(x.value < high))
    with flint.ctx.workprec(_BITS):
        place = x.ball(_BITS)
        if low is not None and bool(place <= expression_ball(low)):
            return False
        return high is None or not bool(place >= expression_ball(high))


@dataclass(frozen=True)
class ExactSign:
    """The sign of a polynomial that is not 0 everywhere.

    >>> from sympy import symbols
    >>> q = symbols("q")
    >>> sign = ExactSign(q**2 - 4, q)
    >>> [sign.at(x) for x in map(Integer, (-3, 2, 0))], sign.between(Integer(2), None), sign.between(Integer(-3), Integer(3))
    ([1, 0, -1], 1, None)
    """

    form: Expr
    symbol: Symbol

    @cached_property
    def zeros(self) -> tuple[RealNumber, ...]:
        """The zeros of the polynomial, at which alone its sign may change."""
        return tuple(zeros_of(self.form, self.symbol)) if self.form.has(self.symbol) else ()

    def at(self, value: Expr) -> int:
        """The sign for one value."""
        return sign_of_number(self.form.xreplace({self.symbol: value}))

    def between(self, low: Expr | None, high: Expr | None) -> int | None:
        """The sign for all values between two (None: without bound); None where it is not one."""
        if any(is_between(low, x, high) for x in self.zeros):
            return None
        if low is None:
            return self.at(Integer(0) if high is None else high - 1)
        return self.at(low + 1 if high is None else (low + high) / 2)
