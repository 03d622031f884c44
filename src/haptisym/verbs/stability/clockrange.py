"""All values of a number at which roots of a loop with a clock reach the unit circle, between two values.

Without end in two ways. Where the number stands in the controller, or over a polynomial of what moves, as stiffness and damping
of a wall do, the loop is a polynomial in u = 1/q or -1/q, times a power of u, and is looked at down to u = 0. And what damps, or
is mass or stiffness beside that, puts no root on the circle where that damps as Colgate and Schenkel's condition asks.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property

from sympy import Expr, Poly, Rational, Symbol

from haptisym.judge.colgate import sampled_passivity
from haptisym.kernel.budget import left, limited, tick
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.nearone import at_minus_one, at_one
from haptisym.kernel.pulse import Numbers, Plant, SampledLoop
from haptisym.model.devices import device
from haptisym.model.hand import Hand
from haptisym.model.knobs import Knob
from haptisym.model.parameters import Rule
from haptisym.model.scene import Scene
from haptisym.verbs.stability.clockcritical import Opened, Walk, opened, start_of
from haptisym.verbs.stability.clocked import clock_of
from haptisym.verbs.stability.clockvalues import Passage

_MOST_PASSAGES = 24
_MOST_WALKS = 5  # of which each goes on to a thousandth of the inverse


@dataclass(frozen=True)
class Passages:
    """Those ``found``, and between which values (``low``, ``high``) all are; None where nothing ends that on a side."""

    found: tuple[Passage, ...]
    low: Fraction | None = None
    high: Fraction | None = None


def passages(scene: Scene, hand: Hand, free: Knob) -> Passages:
    """The nearest below the value that a number has, and the nearest above it. UndecidedError where that stays open."""
    if free.rule not in (Rule.POSITIVE, Rule.NONNEGATIVE, Rule.ANY):
        raise UndecidedError("an order in a loop with a clock")
    found = _Found(scene, hand, free)
    if found.loop.is_fixed:
        return Passages(())
    (below, low), (above, high) = (found.along(side, None, most=1) for side in (-1, 1))
    if low is not None and low == high:
        tick()
        raise UndecidedError("how far a number may go next to whose value roots come to the unit circle")
    is_whole = low == 0 and free.rule is not Rule.ANY
    return Passages((*below, *above), None if is_whole else low, high)


def passages_in(
    scene: Scene, hand: Hand, free: Knob, between: tuple[Expr | None, Expr | None]
) -> tuple[Opened, Passages]:
    """The loop, and all passages between two values, as far as they are found.

    UndecidedError where that stays open from the value on that the number has.
    """
    found = _Found(scene, hand, free)
    if found.loop.is_fixed:
        return found.loop, Passages(())
    (below, low), (above, high) = (found.along(side, last) for side, last in zip((-1, 1), between, strict=True))
    return found.loop, Passages((*below, *above), low, high)


@dataclass(frozen=True)
class _Found:
    """The passages of a number from the value on that it has."""

    scene: Scene
    hand: Hand
    free: Knob

    @cached_property
    def loop(self) -> Opened:
        return opened(self.scene, self.hand, self.free)

    @cached_property
    def _start(self) -> Walk:
        start = start_of(self.loop, self.free.value)
        home, on = self.loop.count(start)
        if on:
            raise UndecidedError("how far a number may go that has roots on the unit circle now")
        return Walk(self.loop, Fraction(int(start.p), int(start.q)), home, self.free.rule)

    def along(self, side: int, last: Expr | None, most: int = 0) -> tuple[list[Passage], Fraction | None]:
        """The first on a side, as many as that or may be looked for, up to a last value, and how far these are all."""
        most = most or _MOST_PASSAGES
        if side > 0 and self._is_held(self._start.start):
            return [], None
        found, walk, is_ended = _along(self._start, side, last, most)
        at = walk.start
        if is_ended:
            return found, at
        if side > 0 and self._is_held(at):
            return found, None
        far = inverted(self.loop, side) if at * side > 0 else None
        if far is None:
            return found, at
        walk = Walk(far, 1 / abs(at), walk.home, Rule.POSITIVE)
        for _ in range(_MOST_WALKS):
            beyond, walk, is_ended = _along(walk, -1, None, most - len(found))
            found += [x.inverse(side) for x in beyond]
            if is_ended or walk.start == 0:
                break
        return found, side / walk.start if walk.start else None

    def _is_held(self, value: Fraction) -> bool:
        return is_held(self.scene, self.hand, self.free, Rational(value.numerator, value.denominator))


def _along(walk: Walk, side: int, last: Expr | None, most: int) -> tuple[list[Passage], Walk, bool]:
    """The first passages on a side, the walk from behind them; whether these are as many as may be, or up to a value."""
    found = list[Passage]()
    while True:
        passage, known = in_half_the_time(walk, side)
        walk = replace(walk, start=known)
        if passage is not None:
            found.append(passage)
            walk = replace(walk, home=passage.above if side > 0 else passage.below)
        is_ended = len(found) == most or (last is not None and (known - Fraction(float(last))) * side >= 0)
        if passage is None or is_ended:
            return found, walk, is_ended


def in_half_the_time(walk: Walk, side: int) -> tuple[Passage | None, Fraction]:
    """Something is left for the other side, and for other numbers."""
    seconds = left()
    with limited(seconds / 2 if seconds else None):
        return walk.towards(side)


@dataclass(frozen=True)
class Inverted(Opened):
    """A loop in which the symbol is 1/q > 0, all times a power of it."""

    @cached_property
    def at_one(self) -> Expr:
        """C(1) times what is nowhere 0, a power of the symbol among it."""
        return self._without_powers(at_one(self.loop))[0]

    @cached_property
    def opposite(self) -> tuple[Expr, Expr]:
        """What is at z = -1, as the symbol may be a factor there: with Tustin's rule a damper is alone, its spring is not."""
        above, below = self._without_powers(*at_minus_one(self.loop))
        return above, below

    def _without_powers(self, *given: Expr) -> list[Expr]:
        """Polynomials without the power of the symbol that they have in common."""
        powers = [n for x in given if x != 0 for (n,) in Poly(x, self.symbol).monoms()]
        return [(x / self.symbol ** min(powers, default=0)).expand() for x in given]


def inverted(loop: Opened, side: int) -> Inverted | None:
    """The loop in u, q = 1/u or (side -1) q = -1/u; None where the number stands elsewhere than in what is multiplied out."""
    own, q = loop.loop, loop.symbol
    plant = own.plant
    fixed = own.T, *plant.denominator, *(lag for lag, _ in plant.terms)
    over = [N for _, N in plant.terms]
    if any(x.has(q) for x in fixed) or not all(
        x.is_polynomial(q) for row in (own.above, own.below, *over) for x in row
    ):
        return None
    moved = max(_degree(row, q) for row in over)
    most = max(_degree(own.above, q) + moved, _degree(own.below, q))

    def turned(row: Numbers, power: int) -> tuple[Expr, ...]:
        return tuple((x.xreplace({q: side / q}) * q**power).expand() for x in row)

    terms = tuple((lag, turned(N, moved)) for lag, N in plant.terms)
    above, below = turned(own.above, most - moved), turned(own.below, most)
    return Inverted(SampledLoop(Plant(plant.denominator, terms), own.T, above, below), q)


def _degree(row: Numbers, q: Symbol) -> int:
    return max((int(Poly(x, q).degree()) for x in row if x.has(q)), default=0)


def is_held(scene: Scene, hand: Hand, free: Knob, value: Rational) -> bool:
    """Whether from a value of a number on the hand holds the display by what it damps, whatever its mass, proven."""
    symbol = free.symbol
    if any(p.symbol == symbol for p in hand.parameters):
        hand = hand.with_values({symbol.name: value})
    elif _only_adds(scene.with_values({free.path: symbol}), symbol):
        scene = scene.with_values({free.path: value})
    else:
        return False
    found = sampled_passivity(scene)
    try:
        return found is not None and found.is_held_by(hand.b.value, hand.k.value)
    except UndecidedError:
        return False


def _only_adds(scene: Scene, symbol: Symbol) -> bool:
    """Whether a symbol adds mass, damping or stiffness behind the clock, and is nowhere else."""
    place, clock = clock_of(scene)
    felt = (scene.rendered or scene.environment).H
    before = [x for effect in scene.effects[:place] for x in effect.matrix]
    if any(x.has(symbol) for x in (felt, *before, *clock.matrix, *(p.value for p in clock.parameters))):
        return False
    devices = [device(x) for x in scene.effects[place + 1 :] if any(y.has(symbol) for y in x.matrix)]
    slopes = [x.diff(symbol) for own in devices if own for x in own]
    return None not in devices and all(x.is_number and x >= 0 for x in slopes)
