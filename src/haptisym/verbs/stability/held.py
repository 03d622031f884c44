"""Held in a hand: how many roots H_perc + m s^2 + b s + k has in Re s >= 0, in lowest terms."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import count

from sympy import I, Integer, prime

from haptisym.judge.imposed import force_is_stable
from haptisym.judge.passiveparts import environment_alone, rests
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import SceneError, UndecidedError
from haptisym.kernel.reals import RealNumber
from haptisym.kernel.rings import Polynomial, RationalFunction, degree_in
from haptisym.kernel.rootcount import RootChain, Roots, count_roots
from haptisym.kernel.roots import sign_of_number
from haptisym.kernel.shown import Shown
from haptisym.kernel.terms import at_least, order_at_0
from haptisym.model.caveats import clocks
from haptisym.model.hand import Hand
from haptisym.model.parameters import WHOLE_NUMBERS, values
from haptisym.model.scene import Scene
from haptisym.verbs.stability.clocked import clocked_roots, loop_of, roots_at_one


def unstable_roots(scene: Scene, hand: Hand) -> Roots:
    """The roots in Re s >= 0 of a display in a hand: the one place where that is decided. UndecidedError where it stays open."""
    if clocks(scene):
        return clocked_roots(scene, hand)
    at_rest = sign_of_number(hand.b.value) > 0 and rests(scene, scene.chain.at(values(scene.parameters)))
    return roots_in_hand(scene.closed.perc, hand, at_rest=at_rest)


def roots_in_hand(perceived: RationalFunction, hand: Hand, *, at_rest: bool = False) -> Roots:
    """The same of a dynamics without a clock; ``at_rest``: whether none but one at 0 can lie in Re s >= 0."""
    ring = ring_of(perceived)
    return zeros_of(characteristic(perceived, ring.convert(hand.Z)), perceived.denominator, ring, rests=at_rest)


def characteristic(perceived: RationalFunction, Z: RationalFunction) -> Polynomial:
    """The numerator of H_perc + Z. H_perc being in lowest terms, so is this over its denominator, but at s = 0."""
    return perceived.numerator * Z.denominator + Z.numerator * perceived.denominator


def ring_of(dynamics: RationalFunction) -> Ring:
    """The ring of a dynamics."""
    assert isinstance(dynamics.ring, Ring)
    return dynamics.ring


def zeros_of(top: Polynomial, bottom: Polynomial, ring: Ring, *, rests: bool = False) -> Roots:
    """The zeros of top/bottom in Re s >= 0; what both have at s = 0, as with 1 - exp(-s tau) over s, is none.

    ``rests`` : whether none but one at 0 can lie there.
    """
    if top.is_zero():
        raise UndecidedError("the roots of what resists no motion at all")
    need_roots(top, ring)
    found = count_roots(top, ring, rests=rests)
    order = order_at_0(top, ring)
    shared = min(order, order_at_0(bottom, ring))
    if found.number is None or not shared:
        return found
    on_axis = found.on_axis if order > shared else found.on_axis[1:]
    return Roots(found.number - at_least(order) + at_least(order - shared), found.right, on_axis, found.chain)


def need_roots(top: Polynomial, ring: Ring) -> None:
    """UndecidedError for a function that is none of s alone: with j among its numbers."""
    if I in ring.generators and degree_in([top], len(ring.meanings) - 1):
        raise UndecidedError(
            "sliding friction stands as a describing function of one amplitude, which has no roots in s"
        )


@dataclass(frozen=True, repr=False)
class Held(Shown):
    """Whether a display is stable in a hand. ``roots`` : those in Re s >= 0; None where not decided, for that ``reason``.

    ``drifts`` : how many of them lie at s = 0 (z = 1) as nothing in scene and hand holds the handle in place; None: not decided.
    """

    hand: Hand
    roots: Roots | None
    reason: str = ""
    drifts: int | None = None

    def _line(self) -> str:
        return f"{self.hand.name}: {'undecided' if self.stable is None else 'stable' if self.stable else 'not stable'}"

    @property
    def stable(self) -> bool | None:
        """No root in Re s >= 0, nor a chain of them that comes to the axis; None where not decided."""
        return None if self.roots is None else self.roots.number == 0

    @property
    def unstable(self) -> int | None:
        """The number of roots in Re s >= 0; None where there are infinitely many, or it was not decided."""
        return None if self.roots is None else self.roots.number

    @property
    def shakes(self) -> bool | None:
        """Whether there is a root in Re s >= 0 that is no drift; None where that was not decided, or a chain hides it."""
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

    >>> from haptisym.model.hand import hands
    >>> from haptisym.model.scenefile import load_scene
    >>> found = held(load_scene("satellite-contact"), hands["postural-arm"])
    >>> found.stable, found.unstable, found.roots.chain.value
    (False, None, 'to the right of the imaginary axis')
    """
    try:
        roots = unstable_roots(scene, hand)
    except UndecidedError as error:
        return Held(hand, None, str(error))
    return Held(hand, roots, drifts=drifts(scene, hand) if roots.number else 0)


def drifts(scene: Scene, hand: Hand) -> int | None:
    """How many roots lie at s = 0 (z = 1) as nothing holds the handle in place; None where that is not decided.

    Those that stay there when every number that is not 0 is another one: a spring that a negative one happens to cancel is none.
    """
    try:
        here = _at_rest(scene, hand)
        return min(here, _at_rest(*_otherwise(scene, hand))) if here else 0
    except (UndecidedError, SceneError):
        return None


def _at_rest(scene: Scene, hand: Hand) -> int:
    """The number of roots at s = 0, or z = 1."""
    if clocks(scene):
        return roots_at_one(loop_of(scene, hand))
    perceived = scene.closed.perc
    ring = ring_of(perceived)
    top = characteristic(perceived, ring.convert(hand.Z))
    order = order_at_0(top, ring)
    return at_least(order) - at_least(min(order, order_at_0(perceived.denominator, ring)))


def _otherwise(scene: Scene, hand: Hand) -> tuple[Scene, Hand]:
    """With every number another one, by a share of its own; what is 0 stays 0, as do whole numbers."""
    primes = (Integer(prime(n)) for n in count(20))
    moved = {
        x.path: x.value * (1 - 1 / next(primes)) for x in scene.parameters if x.value and x.rule not in WHOLE_NUMBERS
    }
    own = {p.symbol.name: p.value * (1 - 1 / next(primes)) for p in hand.parameters}
    return scene.with_values(moved), hand.with_values(own)


@dataclass(frozen=True)
class Imposed:
    """Whether the force under imposed motion is stable, and the number of poles of H_perc in Re s >= 0; None: not decided.

    ``chain`` : of infinitely many poles; of a stable force it may come as near to the axis as one likes.
    """

    stable: bool | None
    unstable: int | None
    chain: RootChain | None = None


def imposed(scene: Scene) -> Imposed:
    """The poles of H_perc."""
    perceived = scene.closed.perc
    stable = force_is_stable(scene, scene.closed)
    if stable is None:
        return Imposed(stable=None, unstable=None)
    if stable and not (ring_of(perceived).lags and environment_alone(scene)):
        return Imposed(stable=True, unstable=0)
    try:
        found = zeros_of(perceived.denominator, perceived.numerator, ring_of(perceived))
    except UndecidedError:
        return Imposed(stable=stable, unstable=0 if stable else None)
    return Imposed(stable, 0 if stable else found.number, found.chain)
