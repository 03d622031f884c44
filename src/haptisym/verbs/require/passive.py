"""For which values of one parameter a display is passive: stable in the hand of any passive
operator.

H_perc/s must be positive real: Im H_perc(j omega) >= 0 at all omega > 0, and neither a pole nor an
advance exp(s tau) may forbid it (``judge.passivity``).
Begin with ``solve_passive`` and ``solve_sampled``.

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
from sympy import Expr, I, Integer, Rational, pi

from haptisym.judge.bindings import Binding, Kind
from haptisym.judge.colgate import SampledPassivity, loop_of, sampled_passivity
from haptisym.judge.crossings import PASSIVE
from haptisym.judge.passivity import environment_alone, passivity
from haptisym.kernel.budget import Waiting
from haptisym.kernel.dynamics import RealFunction, Ring
from haptisym.kernel.errors import LimitError, UndecidedError
from haptisym.kernel.reals import (
    ExactNumber,
    RealNumber,
    expression_ball,
    rational,
    rational_between,
)
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

# Up to how many times the present value of the parameter cells go, where the range has no end.
_FAR = 1000
# Widths of cells that are cut no further: relative to their values, and to the present value.
_FINEST, _LEAST = Rational(1, 1 << 11), Rational(1, 1 << 14)
_MOST = 200
_ROUNDING_BITS = 64

_TOO_NEAR = "passivity: Im H_perc comes too near to 0 somewhere for cells to decide"
_LEFT = "passivity: the sign of Im H_perc is not proven there"
_BEYOND = "values further out are not tested"


def _by_cells(scene: Scene, free: Knob, asked: Domain) -> ValueSet:
    """All values for which a display is passive, where cells prove it."""
    display = _Display(scene, free)
    return _between(
        scene,
        free,
        asked,
        display.changes(),
        display.holds_at,
        cells=display.cells,
        lone=display.alone,
    )


def _enclosed(value: RealNumber) -> tuple[Rational, Rational]:
    """Two rational numbers between which a number lies; itself, twice, where it is rational."""
    if isinstance(value, ExactNumber) and value.value.is_Rational:
        return value.value, value.value
    low, high = value.bounds(_ROUNDING_BITS)
    return rational(low), rational(high)


class _Display:
    """A display with delays or powers of s and one open parameter q: the critical values that are
    exact, and cells with a verdict in between."""

    def __init__(self, scene: Scene, free: Knob) -> None:
        self.scene, self.free = scene, free
        others = values(x for x in scene.parameters if x.path != free.path)
        self.H: RationalFunction = Distortion.of(scene.chain.at(others)).perc
        assert isinstance(self.H.ring, Ring)
        self.ring = self.H.ring
        self.energy = Energy.of(self.H, free.symbol)
        self.gone = missing(scene, free)
        # The size of the present value, by which cells and their widths are measured.
        present, _ = _enclosed(ExactNumber(free.value))
        self.scale = abs(present) or Rational(1)

    def holds_at(self, value: Rational) -> bool | None:
        """The exact verdict on one value."""
        return passivity(self.free.put(self.scene, value)).holds

    def alone(self, x: CriticalValue) -> bool | None:
        """The verdict on a critical value with failing values on both sides: False where Im H_perc
        is proven to be negative at one frequency; else None."""
        return None if self.energy.active_at(span(*_enclosed(x.value))) is None else False

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
        """Polynomials in q that must not be negative where a display is passive: their signs are
        those of Im H_perc at rest and far out, of its turning there, and of H_perc for large s."""
        far = self.energy.far
        found = self._at_rest, far and far[1], self.energy.turning, self.energy.far_right
        return [x for x in found if x]

    @cached_property
    def _stiffness(self) -> Expr:
        """A form in q that has the sign of H_perc(0), where no pole is there, to a factor that is
        nowhere 0."""
        first = self.ring.size + len(self.ring.lags)
        powers = dict.fromkeys(range(first, first + len(self.ring.orders)), 0)
        return self.ring.expression(self.ring.at_0(self.H.numerator).subs(powers))

    def _is_polynomial(self, form: Expr) -> bool:
        return bool(form.is_polynomial(self.free.symbol))

    def changes(self) -> Iterator[CriticalValue]:
        """The critical values that are exact: the zeros of ``_signs``, of H_perc(0), and of the
        coefficient of the numerator's highest power."""
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

    def cells(self, low: RealNumber | None, high: RealNumber | None) -> Iterator[Cell]:
        """Cells with their verdicts that fill the values between two critical ones, in order."""
        # Each of these signs is one for all values in between: one value tells.
        inner = rational_between(low, high, self.free.value)
        if any(x.at(inner) < 0 for x in self._signs):
            yield Cell(low, high, holds=False)
            return
        start, end = self._window(low, high)
        # Where no single value is told, no cell will be: Im H_perc comes too near to 0 for all.
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
        """From where to where cells go: beyond an end that is not rational by hardly more than a
        rounding; at an end that is open up to many times the present value."""
        reach = _FAR * self.scale
        start = None if low is None else _enclosed(low)[0]
        end = None if high is None else _enclosed(high)[1]
        if start is None:
            start = -reach if end is None else min(-reach, end - self.scale)
        return start, max(reach, start + self.scale) if end is None else end

    def _within(self, start: Rational, end: Rational) -> Iterator[Cell]:
        """Cells with verdicts from one value to another. Where the time is over, what is left is
        open."""
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
        # Too many cells: those that are left are asked once as they are, as far out a wide one may
        # be told at once; not when the time is over.
        for low, high in sorted(waiting.rest):
            holds = self._told_if_it_can_be(low, high)[0] if why is _LEFT else None
            yield self._cell(low, high, holds=holds, why=why)

    @staticmethod
    def _cell(low: Rational, high: Rational, *, holds: bool | None, why: str) -> Cell:
        return Cell(ExactNumber(low), ExactNumber(high), holds, why if holds is None else "")

    def _is_told(self, value: Rational) -> bool:
        """Whether the sign of Im H_perc, either, is proven for one value."""
        q = float(value), float(value)
        return self.energy.active_at(q) is not None or self.energy.clear(q)

    def _beyond(self, end: Rational, side: int, *, here: bool | None) -> tuple[bool | None, str]:
        """The verdict on all values beyond an end, ``here`` being that on the cell before it; or
        None and why it is not known."""
        found = self.energy.beyond(span(end, end)[side < 0], side)
        return (found, "") if found is not None and found == here else (None, _BEYOND)

    def _told_if_it_can_be(self, low: Rational, high: Rational) -> tuple[bool | None, bool]:
        """What ``_told`` returns; not known where something stays undecided in it."""
        try:
            return self._told(low, high)
        except UndecidedError as error:
            if isinstance(error, LimitError):
                raise
            return None, False

    def _told(self, low: Rational, high: Rational) -> tuple[bool | None, bool]:
        """The verdict on all values between two, None where none is shown; and whether it is no
        use to cut them.

        The cheap tests come first: a frequency that denies it, then a sign that is right at all
        frequencies, and only then the poles. With all of them settled, one exact verdict tells for
        all values: an advance begins nowhere in between, as it needs a denominator all of whose
        terms are delayed, of which ``Energy.clear`` is False.
        """
        q = span(low, high)
        if self.energy.active_at(q) is not None:
            return False, False
        if not (self.energy.clear(q) or self._is_clear_above_rest(q)):
            return None, False
        if not self._has_steady_poles(low, high):
            return None, False
        if count_at(self.ring, self.H.denominator, {self.free.symbol: (low + high) / 2}) != 0:
            # Poles on the right forbid passivity, unless zeros hide them at single values.
            return None, True
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
        """The exact verdict on one value between two at which the scene exists: of the middle, or a
        third, a quarter of the way."""
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
    """Return all values for which a continuous-time display is passive; with delays, those that
    subdivision proves."""
    perceived = Distortion.of(
        scene.chain.at(values(x for x in scene.parameters if x.path != free.path))
    ).perc
    turns = list[CriticalValue]()
    lone: Callable[[CriticalValue], bool | None] | None = None
    if free.symbol in perceived.expression().free_symbols:
        [condition] = pieces(conditions(scene, [free], [PASSIVE])[PASSIVE])
        if condition.axis.functions:
            # A passive environment behind effects that take energy: true for any delays, without a
            # cell.
            if _is_of_passive_parts(scene, free, asked):
                return _all(scene, free, asked)
            return _by_cells(scene, free, asked)
        turns = [*_of_signs(condition, free), *turns_of_poles(perceived, free)]

        def lone(x: CriticalValue) -> bool | None:
            # With friction j is among the numbers of H_perc, which balls of real numbers do not
            # hold: what a value alone does is then not known.
            if I in perceived.ring.generators:
                return None
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
    """The set of values whose verdict changes at ``turns`` alone, without those at which there is
    no scene.

    ``cells`` : settle the values between these, where one verdict does not. ``at`` and ``lone`` :
    the verdict on an irrational critical value next to values that hold, and between values that
    fail, as of ``Question``.
    """
    gone = missing(scene, free)
    ends = {x.value for x in (*gone, *asked.ends) if isinstance(x, ExactNumber)}
    # Ends that are asked about may have no scene of which ``missing`` does not know.
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
    # A parameter of any sign may be a negative one of a shunt, or in a formula that does anything.
    if alone is None or free.rule is Rule.ANY:
        return False
    knob = next((x for x in alone.knobs if x.path == free.path), None)
    if knob is None:
        return passivity(alone).holds is True
    found = solve_passive(alone, knob, asked)
    return found.feasible == _all(alone, knob, asked).feasible


def _all(scene: Scene, free: Knob, asked: Domain) -> ValueSet:
    """The answer where a display is passive with all values: those with which there is a scene."""
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
    """The verdict on a critical value with failing values on both sides: False where Im H_perc < 0
    is proven at one frequency; else None.

    The frequency is looked for amid where the display is active at a rational value next to that
    one, and at whole octaves.
    """
    near, _ = x.value.bounds(_NEXT)
    there = free.put(scene, rational(near))
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
            # The condition is -Im H_perc <= 0, as a quotient: where that is positive, energy is
            # drawn.
            if above * below > 0:
                return False
    return None


# Octaves to each side of 1 rad/s at which a sign is looked for; and bits to which a rational value
# next to another one agrees with it.
_OCTAVES, _NEXT = 40, 40


def _of_signs(condition: RealFunction, free: Knob) -> Iterator[CriticalValue]:
    """The values at which Im H_perc begins or ceases to be negative somewhere on (0, infinity)."""
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
    """The coefficient of the highest power of the ring's variable."""
    return _end(polynomial, int(polynomial.degrees()[0]))


def turns_of_poles(function: RationalFunction, free: Knob) -> Iterator[CriticalValue]:
    """The values at which poles of a function cross the axis, or poles or zeros come from infinity
    or to 0.

    A root is at infinity where the coefficient of the highest power is 0, at 0 where that of the
    lowest is; on the axis where real and imaginary part share a zero: at a zero of their resultant.
    """
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
        # What they share would make the resultant 0 everywhere.
        common = real.gcd(imag)
        if real and imag and f.degrees()[0]:
            found.append((Kind.AXIS, (real / common).resultant(imag / common, 0)))
    for kind, polynomial in found:
        for factor, _ in polynomial.factor()[1] if polynomial else ():
            for value in real_roots(factor, index, negative=True):
                yield CriticalValue(value, (Binding(PASSIVE, None, kind),))


_PIECES, _MOST_PIECES = 16, 2000


def solve_sampled(scene: Scene, free: Knob, asked: Domain) -> ValueSet:
    """All values for which a sampled display is passive, by Colgate and Schenkel's condition.
    UndecidedError where that does not apply."""
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
    # Mass, stiffness and damping of a device may be negative: their signs count too. 0 will do for
    # each, so that such a value holds like those next to it, and nothing has to bind there.
    for held in (loop.mass, loop.stiffness, loop.damping):
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
    """The verdict of Colgate and Schenkel's condition on a scene of numbers. UndecidedError with
    the reason where it does not apply."""
    found = sampled_passivity(scene)
    assert found is not None
    if found.passive is None:
        raise UndecidedError(f"passivity: {found.reason}")
    return found.passive


def _of_margins(margins: Sequence[RealFunction], free: Knob) -> Iterator[CriticalValue]:
    """The values at which the damping that is left over becomes 0 at some angle, or begins to have
    a pole there."""
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
        # One margin is a function of tan(theta/2), the other of cot(theta/2): from 0 to 1 each,
        # they cover all angles.
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
