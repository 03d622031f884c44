"""All values of a number at which roots of a loop with a clock reach the unit circle, between two values."""

from __future__ import annotations

from fractions import Fraction

from sympy import Expr, Rational

from haptisym.kernel.errors import UndecidedError
from haptisym.model.hand import Hand
from haptisym.model.knobs import Knob
from haptisym.model.scene import Scene
from haptisym.verbs.stability.clockcritical import Opened, Passage, Walk, in_half_the_time, opened, start_of

_MOST_PASSAGES = 24


def passages_in(
    scene: Scene, hand: Hand, free: Knob, between: tuple[Expr | None, Expr | None]
) -> tuple[Opened, tuple[Passage, ...], tuple[Rational | None, Rational | None]]:
    """The loop, all passages between two values, and between which values these are all; None where they are everywhere.

    UndecidedError where that stays open from the value on that the number has.
    """
    loop = opened(scene, hand, free)
    if loop.is_fixed:
        return loop, (), (None, None)
    start = start_of(loop, free.value)
    home, on = loop.count(start)
    if on:
        raise UndecidedError("how far a number may go that has roots on the unit circle now")
    found, ends = list[Passage](), list[Rational]()
    for side, last in zip((-1, 1), between, strict=True):
        at, count = Fraction(int(start.p), int(start.q)), home
        for _ in range(_MOST_PASSAGES):
            passage, known = in_half_the_time(Walk(loop, at, count, free.rule), side)
            if passage is None or (last is not None and (known - Fraction(float(last))) * side > 0):
                found += [passage] if passage else []
                at = known
                break
            found.append(passage)
            at, count = known, passage.above if side > 0 else passage.below
        ends.append(Rational(at.numerator, at.denominator))
    return loop, tuple(found), (ends[0], ends[1])
