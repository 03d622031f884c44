"""Is a display stable in a hand, in all hands of given ranges, with any passive operator: how many
roots H_perc + m s^2 + b s + k has in Re s >= 0.

The count is exact, for the model as written; None is undecided. Of hands in ranges, a box of m, b
and k: one of them puts roots on the axis, at omega, where four functions of omega are all >= 0,
which say that -Im H_perc/omega lies in the range of b, and -Re H_perc among the k - m omega^2 of
the box. Where that is at no omega so, one count holds for all hands. Begin with ``held``;
``whole_box`` is for ranges, ``every_passive_hand`` for any operator, ``imposed`` for prescribed
motion.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum
from itertools import count, product
from typing import Any

from sympy import Expr, I, Integer, prime

from haptisym.judge.colgate import SampledPassivity
from haptisym.judge.passivity import (
    Beyond,
    Passivity,
    environment_alone,
    force_is_stable,
    is_stable_by_parts,
    passivity,
)
from haptisym.kernel.asymptoticsign import Sense, sign_without_zeros
from haptisym.kernel.dynamics import RealFunction, Ring, on_axis, ring_of
from haptisym.kernel.errors import LimitError, SceneError, UndecidedError
from haptisym.kernel.objects import Shown
from haptisym.kernel.reals import RealNumber
from haptisym.kernel.rings import Polynomial, RationalFunction, degree_in, omega
from haptisym.kernel.rootcount import RootChain, Roots, at_least, count_roots, order_at_0
from haptisym.kernel.roots import chart, sign_of_number
from haptisym.model.catalogue import Hand
from haptisym.model.parameters import WHOLE_NUMBERS, Parameter, values
from haptisym.model.scene import Knob, Scene, clocks, unclocked
from haptisym.verbs.stability.clockedloop import clocked_roots, loop_of
from haptisym.verbs.stability.oncircle import OnCircle


def unstable_roots(scene: Scene, hand: Hand) -> Roots:
    """The roots in Re s >= 0 of a display in a hand: the one place where that is decided.
    UndecidedError where it stays open."""
    scene = unclocked(scene)
    if clocks(scene):
        return clocked_roots(scene, hand)
    at_rest = sign_of_number(hand.b.value) > 0 and is_stable_by_parts(
        scene, scene.chain.at(values(scene.parameters))
    )
    return roots_in_hand(scene.closed.perc, hand, at_rest=at_rest)


def roots_in_hand(perceived: RationalFunction, hand: Hand, *, at_rest: bool = False) -> Roots:
    """The roots of a dynamics without a clock in a hand; ``at_rest``: whether none but one at 0 can
    lie in Re s >= 0."""
    ring = ring_of(perceived)
    return zeros_of(
        characteristic(perceived, ring.convert(hand.Z)), perceived.denominator, ring, rests=at_rest
    )


def characteristic(perceived: RationalFunction, Z: RationalFunction) -> Polynomial:
    """The numerator of H_perc + Z, over the denominator of H_perc.

    They share no zero, as H_perc is in lowest terms, but at s = 0, where 1 - exp(-s tau) vanishes
    with s though no factor is common.
    """
    return perceived.numerator * Z.denominator + Z.numerator * perceived.denominator


def zeros_of(top: Polynomial, bottom: Polynomial, ring: Ring, *, rests: bool = False) -> Roots:
    """The zeros of top/bottom in Re s >= 0; what both have at s = 0, as with 1 - exp(-s tau) over
    s, is none.

    ``rests`` : whether none but one at 0 can lie there.
    """
    if top.is_zero():
        raise UndecidedError("the roots of a loop whose force is zero for any motion")
    need_roots(top, ring)
    found = count_roots(top, ring, rests=rests)
    order = order_at_0(top, ring)
    shared = min(order, order_at_0(bottom, ring))
    if found.number is None or not shared:
        return found
    # Frequencies ascend: the first one is that at 0, which goes if top vanishes there no more.
    on_axis = found.on_axis if order > shared else found.on_axis[1:]
    return Roots(
        found.number - at_least(order) + at_least(order - shared), found.right, on_axis, found.chain
    )


def need_roots(top: Polynomial, ring: Ring) -> None:
    """UndecidedError for a function that is none of s alone: with j among its numbers."""
    if I in ring.generators and degree_in([top], len(ring.meanings) - 1):
        raise UndecidedError(
            "friction or play is a describing function of one amplitude, which has no roots in s"
        )


@dataclass(frozen=True, repr=False)
class Held(Shown):
    """Whether a display is stable in a hand. ``roots`` : those in Re s >= 0; None where not
    decided, for that ``reason``.

    ``drifts`` : how many of them lie at s = 0 (z = 1) as nothing in scene and hand holds the handle
    in place; None: not decided.
    """

    hand: Hand
    roots: Roots | None
    reason: str = ""
    drifts: int | None = None

    def _line(self) -> str:
        return (
            f"{self.hand.name}: "
            f"{'undecided' if self.stable is None else 'stable' if self.stable else 'not stable'}"
        )

    @property
    def stable(self) -> bool | None:
        """No root in Re s >= 0, nor a chain of them that comes to the axis; None where not
        decided."""
        return None if self.roots is None else self.roots.number == 0

    @property
    def unstable(self) -> int | None:
        """The number of roots in Re s >= 0; None where there are infinitely many, or it was not
        decided."""
        return None if self.roots is None else self.roots.number

    @property
    def shakes(self) -> bool | None:
        """Whether there is a root in Re s >= 0 that is no drift; None where that was not decided,
        or a chain hides it."""
        if self.roots is None or self.roots.chain is RootChain.NEAR:
            return None
        if self.roots.number is None:
            return True
        return None if self.drifts is None else self.roots.number > self.drifts

    @property
    def is_decided(self) -> bool:
        """Whether nothing about it stayed open."""
        return self.roots is not None and (not self.roots.number or self.drifts is not None)

    @property
    def on_axis(self) -> tuple[RealNumber, ...]:
        """The frequencies of roots on the imaginary axis, rad/s."""
        return () if self.roots is None else self.roots.on_axis


def held(scene: Scene, hand: Hand) -> Held:
    """Whether a display is stable in a hand (at its nominal values).

    >>> from haptisym.model.catalogue import hands
    >>> from haptisym.model.scenefile import load_scene
    >>> found = held(load_scene("satellite-contact"), hands["postural-arm"])
    >>> found.stable, found.unstable, found.roots.chain.value
    (False, None, 'to the right of the imaginary axis')
    """
    try:
        roots = unstable_roots(scene, hand)
    except UndecidedError as error:
        return Held(hand, None, str(error))
    return Held(hand, roots, drifts=0 if roots.number == 0 else drifts(scene, hand))


def moved(scene: Scene, hand: Hand, free: Knob, value: Expr) -> tuple[Scene, Hand]:
    """Display and hand with a parameter of either at a value."""
    if any(p.symbol == free.symbol for p in hand.parameters):
        return scene, hand.with_values({free.symbol.name: value})
    return scene.with_values({free.path: value}), hand


def drifts(scene: Scene, hand: Hand) -> int | None:
    """How many roots lie at s = 0 (z = 1) as nothing holds the handle in place; None where that is
    not decided.

    The roots that are there at the given numbers and again where every number that is not 0 is
    another one: so springs that happen to cancel each other count as no drift. Both counts are
    exact; that one other set of numbers is asked is no proof for all.
    """
    try:
        here = _at_rest(scene, hand)
        return min(here, _at_rest(*_otherwise(scene, hand))) if here else 0
    except (UndecidedError, SceneError):
        return None


def _at_rest(scene: Scene, hand: Hand) -> int:
    """The number of roots at s = 0, with a clock at z = 1."""
    scene = unclocked(scene)
    if clocks(scene):
        return loop_of(scene, hand).roots_at_one
    perceived = scene.closed.perc
    ring = ring_of(perceived)
    top = characteristic(perceived, ring.convert(hand.Z))
    order = order_at_0(top, ring)
    return at_least(order) - at_least(min(order, order_at_0(perceived.denominator, ring)))


def _otherwise(scene: Scene, hand: Hand) -> tuple[Scene, Hand]:
    """Display and hand with every number changed by a small share of its own; what is 0 stays 0,
    and whole numbers stay as they are."""
    # Shares of 1/71, 1/73, ...: small, so that the scene stays one, and of primes, so that no two
    # numbers keep a ratio by which they might cancel.
    primes = (Integer(prime(n)) for n in count(20))
    moved = {
        x.path: x.value * (1 - 1 / next(primes))
        for x in scene.parameters
        if x.value and x.rule not in WHOLE_NUMBERS
    }
    own = {p.symbol.name: p.value * (1 - 1 / next(primes)) for p in hand.parameters}
    return scene.with_values(moved), hand.with_values(own)


@dataclass(frozen=True)
class Imposed:
    """Whether the force under prescribed motion is stable, and the number of poles of H_perc in Re
    s >= 0; None: not decided.

    ``chain`` : where infinitely many poles lie; those of a stable force may come near to the axis
    without end. ``reason`` : why it was not decided in time.
    """

    stable: bool | None
    unstable: int | None
    chain: RootChain | None = None
    reason: str = ""

    def row(self) -> dict[str, Any]:
        """As documents have it."""
        return {"stable": self.stable, "unstable": self.unstable} | (
            {"reason": self.reason} if self.reason else {}
        )


def imposed(scene: Scene) -> Imposed:
    """Whether the force under prescribed motion is stable, by the poles of H_perc."""
    try:
        perceived = scene.closed.perc
        stable = force_is_stable(scene, scene.closed)
    except LimitError as error:
        return Imposed(None, None, reason=str(error))
    if stable is None:
        return Imposed(stable=None, unstable=None)
    if stable and not (ring_of(perceived).lags and environment_alone(scene)):
        return Imposed(stable=True, unstable=0)
    try:
        found = zeros_of(perceived.denominator, perceived.numerator, ring_of(perceived))
    except UndecidedError:
        return Imposed(stable=stable, unstable=0 if stable else None)
    return Imposed(stable, 0 if stable else found.number, found.chain)


@dataclass(frozen=True)
class EveryPassiveHand:
    """Whether a display is stable with any passive operator: whether it is passive.

    ``passivity`` : of H_perc; None where that stayed open, for the ``reason``. ``sampled`` : with a
    clock, Colgate and Schenkel's condition, which decides unless Im H_perc < 0 does already.
    """

    passivity: Passivity | None
    reason: str = ""
    sampled: SampledPassivity | None = None

    @property
    def holds(self) -> bool | None:
        """Whether H_perc/s is positive real, with a clock Colgate and Schenkel's condition; None
        where undecided."""
        return None if self.passivity is None else self.passivity.holds

    @property
    def is_decided(self) -> bool:
        """Whether both passivity and b*, the damping that would make it passive, were decided."""
        p = self.passivity
        if self.sampled is not None:
            return self.holds is not None
        return p is not None and p.holds is not None and (p.damping is not None or p.is_unbounded)

    def row(self, digits: int) -> dict[str, Any]:
        """As documents have it."""
        p = self.passivity
        if self.sampled is not None:
            return self._sampled(self.sampled, digits)
        if p is None:
            return {
                "holds": None,
                "active": [],
                **_number(None, digits),
                "omega": None,
                "reason": self.reason,
            }
        found = p.row()
        best = p.damping
        omega = float(best.omega) if best and best.omega is not None else None
        key = {Beyond.AGAIN: "active_again_beyond", Beyond.LATE: "not_looked_at_beyond"}.get(
            p.beyond
        )
        again = {key: found["reach"]} if key else {}
        why = {"reason": p.beyond.value} if p.holds is None and p.beyond is not Beyond.NEVER else {}
        number = _number(best.value if best else None, digits)
        own = {
            "holds": p.holds,
            "active": found["active"],
            **number,
            "omega": omega,
            "poles_allow": p.poles_allow,
        }
        return own | again | why

    def _sampled(self, x: SampledPassivity, digits: int) -> dict[str, Any]:
        """The row of a document with a clock; its ``active`` frequencies are below the Nyquist
        frequency, for prescribed motion."""
        theta = x.needed.omega if x.needed else None
        omega = (
            None
            if theta is None or x.hand_needed is None or self.holds
            else float(theta) / float(x.T)
        )
        active = self.passivity.row()["active"] if self.passivity else []
        return {
            "holds": self.holds,
            "active": active,
            **_number(x.hand_needed, digits),
            "omega": omega,
        }


def _number(x: RealNumber | None, digits: int) -> dict[str, Any]:
    return {
        "damping": None if x is None else float(x),
        "digits": None if x is None else x.digits(digits),
    }


def every_passive_hand(scene: Scene) -> EveryPassiveHand:
    """Whether a display is stable with any passive operator: the one place where that is
    decided."""
    try:
        found = passivity(unclocked(scene))
        sampled = found.sampled
        # Asked for here, so that what raises does so now and not when the answer is shown.
        _ = (found.holds, found.damping) if sampled is None else (found.holds, sampled.hand_needed)
    except UndecidedError as error:
        return EveryPassiveHand(None, str(error))
    return EveryPassiveHand(found, sampled.reason if sampled else "", sampled)


class Share(Enum):
    """In how many hands of a box a display is stable."""

    ALL = "all"
    SOME = "some"
    NONE = "none"


@dataclass(frozen=True)
class HandsOfBox:
    """In which hands of the box a display is stable; None where not decided, for the ``reason``.

    ``meeting`` : a frequency at which roots lie on the axis for some hand of the box; None if there
    is none.
    """

    share: Share | None
    meeting: RealNumber | None = None
    reason: str = ""


def whole_box(scene: Scene, hand: Hand) -> HandsOfBox | None:
    """In which hands of its box a display is stable; None for a hand without ranges."""
    if not hand.has_ranges:
        return None
    scene = unclocked(scene)
    try:
        if clocks(scene):
            return _sampled(scene, hand)
        return _decided(scene.closed.perc, hand)
    except UndecidedError as error:
        return HandsOfBox(None, reason=str(error))


def _sampled(scene: Scene, hand: Hand) -> HandsOfBox:
    """The answer with a clock: some, by two corners that differ; all or none, as no root is on the
    unit circle anywhere in the box."""
    verdicts = {clocked_roots(scene, x).number == 0 for x in _corners(hand)}
    if len(verdicts) > 1:
        return HandsOfBox(Share.SOME)
    loop = OnCircle.of(scene, hand, {p.symbol: p.interval for p in hand.parameters if p.interval})
    if loop.left():
        raise UndecidedError(
            "whether roots of the sampled loop come to the unit circle for some hand of the box"
        )
    is_stable = loop.is_stable({p.symbol: p.value for p in hand.parameters if p.interval})
    if is_stable is None:
        raise UndecidedError("whether what does not decay is hidden in some hand of the box")
    return HandsOfBox(Share.ALL if is_stable else Share.NONE)


def _decided(perceived: RationalFunction, hand: Hand) -> HandsOfBox:
    """The answer without a clock, by the corners and by whether roots meet the axis in between."""
    counts = [roots_in_hand(perceived, x) for x in _corners(hand)]
    stable = [x.number == 0 for x in counts]
    try:
        meeting = _meeting(perceived, hand)
    except UndecidedError:
        if any(stable) and not all(stable):  # both kinds are there, wherever they meet
            return HandsOfBox(Share.SOME)
        raise
    if meeting is not None:
        if any(stable):
            return HandsOfBox(Share.SOME, meeting)
        raise UndecidedError(
            "whether any hand of the box is stable: its corners are not, and the count "
            "changes within"
        )
    # No root meets the axis, and still the count changes: roots come from infinity. That matters
    # only where all corners give one verdict, which inside may be another.
    if len({(x.number, x.chain) for x in counts}) > 1 and any(stable) == all(stable):
        raise UndecidedError("the count of roots that come from infinity within the box")
    return HandsOfBox(Share.ALL if all(stable) else Share.SOME if any(stable) else Share.NONE)


def _meeting(perceived: RationalFunction, hand: Hand) -> RealNumber | None:
    """A frequency at which roots lie on the axis for some hand of the box; None: there is none."""
    functions = _functions(perceived, hand)
    reaches = [
        x.radius
        for f in functions
        if (x := sign_without_zeros(f)).sense is Sense.NEGATIVE and x.radius
    ]
    # One function that is negative from some frequency on suffices: no hand has roots there.
    if not reaches:
        raise UndecidedError(
            "whether roots meet the imaginary axis at ever higher frequencies for some hand "
            "of the box"
        )
    table = chart(
        {i: RealFunction(f.reduced()) for i, f in enumerate(functions)},
        Integer(0),
        max(min(reaches), Integer(1)),
    )
    if table.undecided:
        raise UndecidedError("whether the box of the hand touches the boundary of stability")
    found = table.where(lambda signs: all(sign >= 0 for sign in signs.values()))
    # A single frequency that is a pole of one of them is no place where roots lie on the axis.
    finite = [x for x in found if x.low is not x.high or all(n >= 0 for n in x.low.orders.values())]
    return finite[0].low.omega if finite else None


def _functions(perceived: RationalFunction, hand: Hand) -> list[RationalFunction]:
    """Four functions of omega, over squares, which are all >= 0 where roots lie on the axis for
    some hand of the box."""
    response = on_axis(perceived)
    (m, m_high), (b, b_high), (k, k_high) = map(_ends, hand.parameters)

    def with_hand(part: RationalFunction, sign: int, more: Expr) -> RationalFunction:
        x = part.ring.convert(more)
        top = part.numerator * sign * x.denominator + x.numerator * part.denominator
        return part.ring.function(top, part.denominator * x.denominator)

    # b <= -Im H/omega <= b_high and k - m_high omega^2 <= -Re H <= k_high - m omega^2: each of m,
    # b and k enters by one end of its range, so that these four say all about the box.

    return [
        with_hand(response.raw_imag, -1, -b * omega),
        with_hand(response.raw_imag, 1, b_high * omega),
        with_hand(response.raw_real, -1, m_high * omega**2 - k),
        with_hand(response.raw_real, 1, k_high - m * omega**2),
    ]


def _ends(p: Parameter) -> tuple[Expr, Expr]:
    return p.interval or (p.value, p.value)


def _corners(hand: Hand) -> Iterator[Hand]:
    """The nominal hand, and every corner of its box."""
    yield hand
    yield from (Hand(hand.name, m, b, k) for m, b, k in product(*map(_ends, hand.parameters)))
