"""A hand given by ranges: whether a display is stable in all hands of the box, in none, or in some.

Roots of H_perc + m s^2 + b s + k lie on the axis, at omega, for some hand of the box where four functions of omega are not
negative: -Im H_perc/omega lies in the range of b, and -Re H_perc is some k - m omega^2 of the box. Where that is nowhere so,
one count holds for all.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum
from itertools import product

from sympy import Expr, Integer, Rational

from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.far import Sense, far
from haptisym.kernel.reals import RealNumber
from haptisym.kernel.response import RealFunction, on_axis
from haptisym.kernel.rings import RationalFunction
from haptisym.kernel.rootcount import RootChain, Roots
from haptisym.kernel.roots import chart, sign_of_number
from haptisym.kernel.symbols import omega
from haptisym.kernel.terms import terms_of
from haptisym.model.caveats import clocks
from haptisym.model.hand import Hand
from haptisym.model.parameters import Parameter
from haptisym.model.scene import Scene
from haptisym.verbs.stability.clocked import OnCircle, clocked_roots
from haptisym.verbs.stability.held import characteristic, ring_of, roots_in_hand


class Share(Enum):
    """Of the hands of a box those in which a display is stable."""

    ALL = "all"
    SOME = "some"
    NONE = "none"


@dataclass(frozen=True)
class Box:
    """In which hands of the box a display is stable; None where not decided, for the ``reason``.

    ``meeting`` : a frequency at which roots lie on the axis for some hand of the box; None if there is none.
    """

    share: Share | None
    meeting: RealNumber | None = None
    reason: str = ""


def whole_box(scene: Scene, hand: Hand) -> Box | None:
    """In which hands of its box a display is stable; None for a hand without ranges."""
    if not hand.has_ranges:
        return None
    try:
        if clocks(scene):
            return _sampled(scene, hand)
        return _decided(scene.closed.perc, hand)
    except UndecidedError as error:
        return Box(None, reason=str(error))


def _sampled(scene: Scene, hand: Hand) -> Box:
    """With a clock: corners counted, and no root on the unit circle anywhere in the box, or both kinds among the corners."""
    verdicts = {clocked_roots(scene, x).number == 0 for x in _corners(hand)}
    if len(verdicts) > 1:
        return Box(Share.SOME)
    loop = OnCircle.of(scene, hand, {p.symbol: p.interval for p in hand.parameters if p.interval})
    if loop.left():
        raise UndecidedError("whether roots of the sampled loop come to the unit circle for some hand of the box")
    is_stable = loop.is_stable({p.symbol: p.value for p in hand.parameters if p.interval})
    if is_stable is None:
        raise UndecidedError("whether what does not decay is hidden in some hand of the box")
    return Box(Share.ALL if is_stable else Share.NONE)


def _decided(perceived: RationalFunction, hand: Hand) -> Box:
    counts = [roots_in_hand(perceived, x) for x in _corners(hand)]
    if all(x.chain is RootChain.RIGHT for x in counts) and _is_outweighed(perceived, hand):
        return Box(Share.NONE)
    stable = [x.number == 0 for x in counts]
    try:
        meeting = _meeting(perceived, hand)
    except UndecidedError:
        if any(stable) and not all(stable):  # both kinds are there, wherever they meet
            return Box(Share.SOME)
        raise
    if meeting is not None:
        if any(stable):
            return Box(Share.SOME, meeting)
        raise UndecidedError("whether any hand of the box is stable: its corners are not, and the count changes within")
    if len({_kind(x) for x in counts}) > 1 and any(stable) == all(stable):
        raise UndecidedError("the count of roots that come from infinity within the box")
    return Box(Share.ALL if all(stable) else Share.SOME if any(stable) else Share.NONE)


def _is_outweighed(perceived: RationalFunction, hand: Hand) -> bool:
    """Whether one delayed term outweighs what else stands with the highest power of s in all hands, if it does at the corners.

    Both are linear in the mass: where c + m e keeps its sign, the masses of |c + m e| > |a + m d| hang together.
    """
    ring, signs = ring_of(perceived), dict[Rational, set[tuple[object, ...]]]()
    for corner in _corners(hand):
        terms = terms_of(characteristic(perceived, ring.convert(corner.Z)), ring)
        degree = max(terms)
        signs.setdefault(degree, set()).add(
            tuple((turns, sign_of_number(c)) for turns, c in terms[degree].items() if any(turns))
        )
    return all(len(found) == 1 and all(len(delayed) == 1 for delayed in found) for found in signs.values())


def _kind(x: Roots) -> tuple[object, object]:
    return x.number, x.chain


def _meeting(perceived: RationalFunction, hand: Hand) -> RealNumber | None:
    """A frequency at which roots lie on the axis for some hand of the box."""
    functions = _functions(perceived, hand)
    reaches = [x.radius for f in functions if (x := far(f)).sense is Sense.NEGATIVE and x.radius]
    if not reaches:
        raise UndecidedError(
            "whether roots meet the imaginary axis at ever higher frequencies for some hand of the box"
        )
    table = chart(
        {i: RealFunction(f.reduced()) for i, f in enumerate(functions)}, Integer(0), max(min(reaches), Integer(1))
    )
    if table.undecided:
        raise UndecidedError("whether the box of the hand touches the boundary of stability")
    found = table.where(lambda signs: all(sign >= 0 for sign in signs.values()))
    finite = [x for x in found if x.low is not x.high or all(n >= 0 for n in x.low.orders.values())]
    return finite[0].low.omega if finite else None


def _functions(perceived: RationalFunction, hand: Hand) -> list[RationalFunction]:
    """Of omega, over squares: all >= 0 where roots lie on the axis for some hand of the box."""
    response = on_axis(perceived)
    (m, m_high), (b, b_high), (k, k_high) = map(_ends, hand.parameters)

    def with_hand(own: RationalFunction, sign: int, more: Expr) -> RationalFunction:
        x = own.ring.convert(more)
        top = own.numerator * sign * x.denominator + x.numerator * own.denominator
        return own.ring.function(top, own.denominator * x.denominator)

    return [
        with_hand(response.raw_imag, -1, -b * omega), with_hand(response.raw_imag, 1, b_high * omega),
        with_hand(response.raw_real, -1, m_high * omega**2 - k), with_hand(response.raw_real, 1, k_high - m * omega**2),
    ]  # fmt: skip


def _ends(p: Parameter) -> tuple[Expr, Expr]:
    return p.interval or (p.value, p.value)


def _corners(hand: Hand) -> Iterator[Hand]:
    """The nominal hand, and every corner of its box."""
    yield hand
    yield from (Hand(hand.name, m, b, k) for m, b, k in product(*map(_ends, hand.parameters)))
