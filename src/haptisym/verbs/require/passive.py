"""For which values of one parameter a display is passive: stable in the hand of any passive
operator.

*Of a rational display*: exact verdicts between critical values. *With delays or powers of s* by
cells, each proven: a cell of values is not passive where Im H_perc < 0 at one frequency for all of
them, and passive where Im H_perc > 0 at all frequencies, no pole comes to the axis and no highest
power is lost in it, and one exact verdict in it is yes. Where the sign turns first at frequency 0,
it turns at a root of a polynomial: an exact end. What none of these shows is left open.

*Of a sampled loop*: Colgate and Schenkel's condition. The damping that a device has left over is
rational in tan(theta/2) and the parameter. It can become 0 at some angle, or the controller's poles
can reach the unit circle, at roots of resultants and discriminants alone, and the stiffness at rest
at roots of its numerator; between these one verdict tells.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import cached_property
from itertools import count

import flint
from flint import acb_poly, arb
from sympy import Expr, Integer, Rational, pi

from haptisym.judge.bindings import Binding, Kind
from haptisym.judge.colgate import SampledPassivity, loop_of, sampled_passivity
from haptisym.judge.crossings import PASSIVE
from haptisym.judge.passivity import environment_alone, passivity
from haptisym.kernel.budget import Waiting
from haptisym.kernel.dynamics import RealFunction, Ring
from haptisym.kernel.errors import LimitError, UndecidedError
from haptisym.kernel.reals import ExactNumber, RealNumber, expression_ball, rational_between
from haptisym.kernel.rings import Polynomial, RationalFunction, monomials
from haptisym.kernel.sets import (
    STOPPED,
    Cell,
    CriticalValue,
    CriticalValues,
    Domain,
    Open,
    Question,
    ValueSet,
    solve,
)
from haptisym.model.distortion import Distortion
from haptisym.model.parameters import Rule, values
from haptisym.model.scene import Knob, Scene
from haptisym.programs.onaxis import OnAxis
from haptisym.verbs.require.floatcells import Energy, span
from haptisym.verbs.require.freeparameter import (
    ExactSign,
    allowed,
    conditions,
    critical,
    irreducible,
    missing,
    pieces,
    real_roots,
    zeros_of,
)
from haptisym.verbs.stability.ranges import count_at

_BITS = 256

_FAR = 1000
"""How many times the value that a parameter has cells go, where the range has no end."""
_FINEST, _LEAST = Rational(1, 1 << 11), Rational(1, 1 << 14)
"""Cells are cut no further: shares of their values, and of the value that the parameter has."""
_MOST = 200
_ROUNDING_BITS = 64

_TOO_NEAR = "passivity: Im H_perc comes too near to 0 somewhere for cells to decide"
_LEFT = "passivity: the sign of Im H_perc is not proven there"
_BEYOND = "values further out are not tested"


def _by_cells(scene: Scene, free: Knob, asked: Domain) -> ValueSet:
    """All values for which a display is passive, where cells prove it."""
    display = _Display(scene, free)
    return _between(scene, free, asked, display.changes(), display.holds_at, cells=display.cells)


def _enclosed(value: RealNumber) -> tuple[Rational, Rational]:
    """Rational numbers between which one lies; itself where it is rational."""
    if isinstance(value, ExactNumber) and value.value.is_Rational:
        return value.value, value.value
    low, high = value.bounds(_ROUNDING_BITS)
    return Rational(low.numerator, low.denominator), Rational(high.numerator, high.denominator)


class _Display:
    """A display with delays or powers of s and one open number, and for which of its values it is
    passive."""

    def __init__(self, scene: Scene, free: Knob) -> None:
        self.scene, self.free = scene, free
        chain = scene.chain.at(values(x for x in scene.parameters if x.path != free.path))
        self.H: RationalFunction = Distortion.of(chain).perc
        assert isinstance(self.H.ring, Ring)
        self.ring, self.energy = self.H.ring, Energy.of(self.H, free.symbol)
        self.gone = missing(scene, free)
        self.scale = abs(_enclosed(ExactNumber(free.value))[0]) or Rational(1)

    def holds_at(self, value: Rational) -> bool | None:
        """The exact verdict on one value."""
        return passivity(self.free.put(self.scene, value)).holds

    # Signs that are those of polynomials: they are told for all values between two of their zeros
    # at once

    @cached_property
    def _at_rest(self) -> ExactSign | None:
        """The sign of Im H_perc just above frequency 0, where it is that of a polynomial."""
        try:
            form = self.energy.at_0
        except UndecidedError:
            return None
        return ExactSign(form, self.free.symbol) if self._is_polynomial(form) else None

    @cached_property
    def _signs(self) -> list[ExactSign]:
        """What must not be negative: Im H_perc at rest and far out, where it turns, and H_perc for
        large s."""
        far = self.energy.far
        found = self._at_rest, far and far[1], self.energy.turning, self.energy.far_right
        return [x for x in found if x]

    @cached_property
    def _stiffness(self) -> Expr:
        """What has the sign of H_perc(0) where no pole is there, to a factor that is nowhere 0."""
        first = self.ring.size + len(self.ring.lags)
        powers = dict.fromkeys(range(first, first + len(self.ring.orders)), 0)
        return self.ring.expression(self.ring.at_0(self.H.numerator).subs(powers))

    def _is_polynomial(self, form: Expr) -> bool:
        return bool(form.is_polynomial(self.free.symbol))

    def changes(self) -> Iterator[CriticalValue]:
        """The zeros of these, of H_perc(0), and of the highest power of the numerator."""
        rest = self._at_rest
        forms = [(x.form, Kind.START if x is rest else Kind.FAR) for x in self._signs]
        forms.append((self._stiffness, Kind.START))
        if self.energy.top is not None:
            forms.append((self.energy.top, Kind.FAR))
        for form, kind in forms:
            if form.has(self.free.symbol) and self._is_polynomial(form):
                omega = ExactNumber(Integer(0)) if kind is Kind.START else None
                for value in zeros_of(form, self.free.symbol):
                    yield CriticalValue(value, (Binding(PASSIVE, omega, kind),))

    # Cells of values between two of these zeros

    def cells(self, low: RealNumber | None, high: RealNumber | None) -> Iterator[Cell]:
        """Cells that fill the values between two, in order."""
        inner = rational_between(low, high, self.free.value)
        if any(x.at(inner) < 0 for x in self._signs):
            yield Cell(low, high, holds=False)
            return
        start, end = self._window(low, high)
        tried = inner, start + (end - start) / 3, end
        if not any(self._is_told(x) for x in tried):
            yield Cell(low, high, None, _TOO_NEAR)
            return
        found = [*self._within(start, end)]
        found[0] = replace(found[0], low=low or found[0].low)
        found[-1] = replace(found[-1], high=high or found[-1].high)
        if low is None:
            yield Cell(None, found[0].low, *self._beyond(start, -1, here=found[0].holds))
        yield from found
        if high is None:
            yield Cell(found[-1].high, None, *self._beyond(end, 1, here=found[-1].holds))

    def _window(self, low: RealNumber | None, high: RealNumber | None) -> tuple[Rational, Rational]:
        """As far as cells go; beyond an end that is not rational by hardly more than a rounding."""
        reach = _FAR * self.scale
        start = None if low is None else _enclosed(low)[0]
        end = None if high is None else _enclosed(high)[1]
        if start is None:
            start = -reach if end is None else min(-reach, end - self.scale)
        return start, max(reach, start + self.scale) if end is None else end

    def _within(self, start: Rational, end: Rational) -> Iterator[Cell]:
        """Cells from one value to another. Where the time is over, what is left is open."""
        waiting = Waiting([(start, end)], most=_MOST, what="cells of values")
        why = _LEFT
        try:
            for low, high in waiting:
                holds, is_last = self._told_if_it_can_be(low, high)
                width = high - low
                is_small = width <= max(_FINEST * max(-low, high), _LEAST * self.scale)
                if holds is not None or is_last or is_small:
                    yield self._cell(low, high, holds=holds, why=_LEFT)
                else:
                    middle = (low + high) / 2
                    waiting.add((low, middle), (middle, high))
        except LimitError:
            why = STOPPED
        for low, high in sorted(waiting.rest):  # far out a wide cell may be told as it is
            holds = self._told_if_it_can_be(low, high)[0] if why is _LEFT else None
            yield self._cell(low, high, holds=holds, why=why)

    @staticmethod
    def _cell(low: Rational, high: Rational, *, holds: bool | None, why: str) -> Cell:
        return Cell(ExactNumber(low), ExactNumber(high), holds, why if holds is None else "")

    def _is_told(self, value: Rational) -> bool:
        """Whether a sign is shown for one value, be it which it may."""
        q = float(value), float(value)
        return self.energy.active_at(q) is not None or self.energy.clear(q)

    def _beyond(self, end: Rational, side: int, *, here: bool | None) -> tuple[bool | None, str]:
        """Of all values from an end on, where the cell before it is told; else why that is not
        known."""
        found = self.energy.beyond(span(end, end)[side < 0], side)
        return (found, "") if found is not None and found == here else (None, _BEYOND)

    def _told_if_it_can_be(self, low: Rational, high: Rational) -> tuple[bool | None, bool]:
        try:
            return self._told(low, high)
        except UndecidedError as error:
            if isinstance(error, LimitError):
                raise
            return None, False

    def _told(self, low: Rational, high: Rational) -> tuple[bool | None, bool]:
        """Whether all values are passive, None where it is not shown; and whether no part of them
        will be shown either."""
        q = span(low, high)
        if self.energy.active_at(q) is not None:
            return False, False
        if not (self.energy.clear(q) or self._is_clear_above_rest(q)):
            return None, False
        if not self._has_steady_poles(low, high):
            return None, False
        if count_at(self.ring, self.H.denominator, {self.free.symbol: (low + high) / 2}) != 0:
            return None, True  # of poles on the right some may be hidden at single values
        return (self._holds(low, high), False) if self._is_steady(low, high) else (None, False)

    def _is_clear_above_rest(self, q: tuple[float, float]) -> bool:
        """Whether Im H_perc > 0 at all frequencies for all values at which it is so at rest.

        From rest it rises up to a frequency from which on it is positive: so it is where it comes
        to 0 at rest.
        """
        if self._at_rest is None:
            return False
        risen = self.energy.rises(q)
        return risen is not None and self.energy.clear(q, risen)

    def _holds(self, low: Rational, high: Rational) -> bool | None:
        """Of a value between two, at which the scene exists."""
        known = {x.value for x in self.gone if isinstance(x, ExactNumber)}
        shares = (low + (high - low) / n for n in count(2))
        return self.holds_at(next(x for x in shares if x not in known))

    def _has_steady_poles(self, low: Rational, high: Rational) -> bool:
        """Whether no pole comes to the axis, nor from infinity, for all values."""
        below = OnAxis(self.ring, self.H.denominator, {self.free.symbol: (low, high)})
        return below.reach is not None and not len(below.left())

    def _is_steady(self, low: Rational, high: Rational) -> bool:
        """Whether H_perc(0) keeps its sign and no highest power of its numerator is lost, but at an
        end, for all values.

        The zeros of polynomials that tell it are critical values, and lie in no cell.
        """
        if not self._is_polynomial(self._stiffness):
            return False
        if self.energy.top is not None and self._is_polynomial(self.energy.top):
            return True
        return (
            OnAxis(self.ring, self.H.numerator, {self.free.symbol: (low, high)}).reach is not None
        )


def solve_passive(scene: Scene, free: Knob, asked: Domain) -> ValueSet:
    """All values for which a continuous-time display is passive; with delays, those that
    subdivision proves."""
    perceived = Distortion.of(
        scene.chain.at(values(x for x in scene.parameters if x.path != free.path))
    ).perc
    turns = list[CriticalValue]()
    lone: Callable[[CriticalValue], bool | None] | None = None
    if free.symbol in perceived.expression().free_symbols:
        [condition] = pieces(conditions(scene, [free], [PASSIVE])[PASSIVE])
        if condition.axis.functions:
            if _is_of_passive_parts(scene, free, asked):
                return _all(scene, free, asked)
            return _by_cells(scene, free, asked)
        turns = [*_of_signs(condition, free), *turns_of_poles(perceived, free)]

        def lone(x: CriticalValue) -> bool | None:
            if _is_denied_by_poles(perceived, free, x.value):
                return False
            return _alone_by_signs(scene, condition, free, x)

    def verdict(value: Rational) -> bool | None:
        return passivity(free.put(scene, value)).holds

    return _between(scene, free, asked, turns, verdict, lone=lone)


def _between(
    scene: Scene,
    free: Knob,
    asked: Domain,
    turns: Iterable[CriticalValue],
    verdict: Callable[[Rational], bool | None],
    at: Callable[[CriticalValue], bool | None] | None = None,
    cells: Callable[[RealNumber | None, RealNumber | None], Iterable[Cell]] | None = None,
    lone: Callable[[CriticalValue], bool | None] | None = None,
) -> ValueSet:
    """The values with a verdict that changes at some alone; none at which there is no scene.

    ``cells`` : settle the values between these, where one verdict does not.
    """
    gone = missing(scene, free)
    ends = {x.value for x in (*gone, *asked.ends) if isinstance(x, ExactNumber)}

    nowhere = {x for x in ends if not allowed(scene, free, x)}

    def exact(value: Rational) -> bool | None:
        return False if value in nowhere else verdict(value)

    def bound(x: CriticalValue) -> CriticalValue:
        """Nothing binds where there is no scene."""
        return (
            CriticalValue(x.value)
            if isinstance(x.value, ExactNumber) and x.value.value in nowhere
            else x
        )

    critical_values = [*map(bound, turns), *map(CriticalValue, gone)]
    changes = CriticalValues(critical_values, [Open(None, None, _LEFT)] if cells else [])
    question = Question(exact, free.value, lambda: [changes], at=at, cells=cells, lone=lone)
    return solve(question, asked).without(gone)


def _is_of_passive_parts(scene: Scene, free: Knob, asked: Domain) -> bool:
    """Whether the environment alone is passive for all values, and all effects take energy with
    each of them."""
    alone = environment_alone(scene)
    if (
        alone is None or free.rule is Rule.ANY
    ):  # a shunt's may be negative, and a formula may do anything with a number
        return False
    knob = next((x for x in alone.knobs if x.path == free.path), None)
    if knob is None:
        return passivity(alone).holds is True
    found = solve_passive(alone, knob, asked)
    return found.feasible == _all(alone, knob, asked).feasible


def _all(scene: Scene, free: Knob, asked: Domain) -> ValueSet:
    """All values with which there is a scene."""
    return _between(scene, free, asked, (), lambda _: True)


def _is_denied_by_poles(function: RationalFunction, free: Knob, value: RealNumber) -> bool:
    """Whether poles are proven to prevent passivity at a value: in Re s > 0, or of H/s more than a
    simple one at infinity.

    A pole is a zero of the denominator that is none of the numerator.
    """
    ring = function.ring
    with flint.ctx.workprec(_BITS), suppress(ValueError):  # where balls do not tell roots apart
        known = {free.symbol: value.ball(_BITS)}
        above, below = (
            acb_poly([expression_ball(c, known) for c in ring.coefficients(f)])
            for f in (function.numerator, function.denominator)
        )
        is_steep = above.degree() - below.degree() > 2 and not above[above.degree()].contains(0)
        return is_steep or any(x.real > 0 and not above(x).contains(0) for x in below.roots())
    return False


def _alone_by_signs(
    scene: Scene, condition: RealFunction, free: Knob, x: CriticalValue
) -> bool | None:
    """Whether a display is passive at a value between others at which it is not: no where Im H_perc
    < 0 shows; else not known.

    It is looked for in the middle of where it is active at a rational value next to that one, and
    at whole octaves.
    """
    near, _ = x.value.bounds(_NEXT)
    there = free.put(scene, Rational(near.numerator, near.denominator))
    active = passivity(there).row()["active"]
    middles = [(low + (2 * low + 1 if high is None else high)) / 2 for low, high in active]
    octaves = [2.0**power for power in range(-_OCTAVES, _OCTAVES)]
    with flint.ctx.workprec(_BITS):
        known = {free.symbol: x.value.ball(_BITS), pi: arb.pi()}
        for place in (*middles, *octaves):
            at = known | {condition.axis.meanings[0]: arb(place)}
            above, below = (
                condition.axis.ball(f, at)
                for f in (condition.function.numerator, condition.function.denominator)
            )
            if above * below > 0:
                return False
    return None


_OCTAVES, _NEXT = 40, 40
"""Of frequencies about 1 rad/s, at each of which a sign is looked for; bits of a value that is next
to another one."""


def _of_signs(condition: RealFunction, free: Knob) -> Iterator[CriticalValue]:
    """Where Im H_perc begins or ceases to be negative somewhere on (0, infinity)."""
    if free.symbol not in condition.axis.meanings:
        return
    index = condition.axis.meanings.index(free.symbol)
    found = [
        (x[1], p)
        for x, p in critical(PASSIVE, [condition], (Integer(0), Integer(1)))
        if x and x[1] is not Kind.EDGE
    ]
    found += [(Kind.FAR, _leading(f)) for f, _ in irreducible(condition.function.numerator)]
    for kind, polynomial in found:
        omega = None
        for factor, _ in polynomial.factor()[1]:
            for value in real_roots(factor, index, negative=True):
                yield CriticalValue(value, (Binding(PASSIVE, omega, kind),))


def _end(polynomial: Polynomial, power: int) -> Polynomial:
    """The coefficient of one power of the ring's variable."""
    terms = {(0, *e[1:]): value for e, value in monomials(polynomial) if int(e[0]) == power}
    return polynomial.context().from_dict(terms)


def _leading(polynomial: Polynomial) -> Polynomial:
    return _end(polynomial, int(polynomial.degrees()[0]))


def turns_of_poles(function: RationalFunction, free: Knob) -> Iterator[CriticalValue]:
    """Where poles of a function cross the axis, or poles or zeros come from infinity or to 0."""
    ring = function.ring
    assert isinstance(ring, Ring)
    if free.symbol not in ring.meanings:
        return
    index, found = ring.meanings.index(free.symbol), list[tuple[Kind, Polynomial]]()
    for polynomial in (function.numerator, function.denominator):
        for f, _ in polynomial.factor()[1]:
            found += [
                (Kind.FAR, _leading(f)),
                (Kind.START, _end(f, min(int(e[0]) for e in f.monoms()))),
            ]
    for f, _ in function.denominator.factor()[1]:
        [(real, imag)] = ring.axis.parts([f])
        common = real.gcd(imag)
        if real and imag and f.degrees()[0]:
            found.append((Kind.AXIS, (real / common).resultant(imag / common, 0)))
    for kind, polynomial in found:
        for factor, _ in polynomial.factor()[1] if polynomial else ():
            for value in real_roots(factor, index, negative=True):
                yield CriticalValue(value, (Binding(PASSIVE, None, kind),))


_PIECES, _MOST_PIECES = 16, 2000


def solve_sampled(scene: Scene, free: Knob, asked: Domain) -> ValueSet:
    """All values for which it is passive. UndecidedError where the condition does not apply."""
    if free.is_of_hand or free.parts:
        return ValueSet.all_of(asked, holds=sampled_verdict(scene))
    loop = loop_of(scene.with_values({free.path: free.symbol}))
    if isinstance(loop, SampledPassivity):
        raise UndecidedError(f"passivity: {loop.reason}")
    ring = Ring.of([loop.T, loop.C, loop.damping])
    if ring.functions:
        raise UndecidedError("passivity, with a free delay in a sampled loop")
    margins = [
        RealFunction((f.axis.convert(loop.damping) - f.function).reduced())
        for f in loop.sides(ring)
    ]
    turns = [*_of_margins(margins, free), *turns_of_poles(ring.convert(loop.C).reduced(), free)]
    at_rest = loop.at_rest(ring)[1]
    if at_rest.has(free.symbol):
        turns += [
            CriticalValue(x, (Binding(PASSIVE, None, Kind.START),))
            for x in zeros_of(at_rest, free.symbol)
        ]
    for held in (loop.mass, loop.stiffness, loop.damping):  # of a device they may be negative
        turns += (
            [CriticalValue(x, ()) for x in zeros_of(held, free.symbol)]
            if held.has(free.symbol)
            else []
        )

    def verdict(value: Rational) -> bool | None:
        return sampled_verdict(free.put(scene, value))

    def spared_at(x: CriticalValue) -> bool:
        return _is_positive(margins, free, x.value)

    return _between(scene, free, asked, turns, verdict, at=spared_at)


def sampled_verdict(scene: Scene) -> bool | None:
    """Of a scene with numbers. UndecidedError with the reason where the condition does not
    apply."""
    found = sampled_passivity(scene)
    assert found is not None
    if found.passive is None:
        raise UndecidedError(f"passivity: {found.reason}")
    return found.passive


def _of_margins(margins: Sequence[RealFunction], free: Knob) -> Iterator[CriticalValue]:
    """Where the damping that is left over becomes 0 at some angle, or begins to have a pole
    there."""
    for margin, start in zip(margins, (Kind.START, Kind.FAR), strict=True):
        if free.symbol not in margin.axis.meanings:
            continue
        index = margin.axis.meanings.index(free.symbol)
        for reason, polynomial in critical(PASSIVE, [margin], (Integer(0), Integer(1))):
            kind = start if reason and reason[1] is Kind.START else Kind.TOUCH
            for factor, _ in polynomial.factor()[1] if polynomial else ():
                for value in real_roots(factor, index, negative=True):
                    yield CriticalValue(value, (Binding(PASSIVE, None, kind),))


def _is_positive(margins: Sequence[RealFunction], free: Knob, value: RealNumber) -> bool:
    """Whether damping is left over at all angles, proven, at a value that is known by balls."""
    with flint.ctx.workprec(_BITS):
        known = {free.symbol: value.ball(_BITS), pi: arb.pi()}
        pieces = [
            (f, arb(k) / _PIECES, arb(k + 1) / _PIECES) for f in margins for k in range(_PIECES)
        ]
        waiting = Waiting(pieces, most=_MOST_PIECES)
        for f, low, high in waiting:
            at = known | {f.axis.meanings[0]: low.union(high)}
            above, below = (
                f.axis.ball(x, at) for x in (f.function.numerator, f.function.denominator)
            )
            if not above * below > 0:
                middle = (low + high) / 2
                waiting.add((f, low, middle), (f, middle, high))
        return not waiting.rest
