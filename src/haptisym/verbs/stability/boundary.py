"""At which values of one open number roots lie on the imaginary axis, and at which frequencies: all of them, certified."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress

from sympy import Expr, Integer, Rational

from haptisym.judge.peaks import ValueAt
from haptisym.kernel.errors import LimitError, UndecidedError
from haptisym.kernel.far import Sense, far
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.response import RealFunction
from haptisym.verbs.stability.chains import Switches, cells, from_infinity, is_neutral, neutral_meetings
from haptisym.verbs.stability.loops import Characteristic, Curve, Loop, Meeting, Meetings, curve_of, minus
from haptisym.verbs.stability.search import searched

_WINDOWS = 12
_MOST_TURNING = 400  # radians that a delay turns up to where roots are looked for
_LOWS = (Rational(15, 16), Rational(1, 2))
_SETTLED = (Sense.POSITIVE, Sense.NEGATIVE)


def meetings(loop: Loop, value: Expr) -> Iterator[Meetings]:
    """Where an open number puts roots on the axis: all, or in windows that grow. UndecidedError where that is open.

    By one equation in omega as far as that goes, and from there on by a search over both.
    """
    is_whole = True
    try:
        for window in _eliminated(loop, value):
            yield window
            is_whole = not window.gaps
    except LimitError:
        raise
    except UndecidedError as error:
        if not is_whole:
            raise
        yield from searched(loop, value, str(error))


def _eliminated(loop: Loop, value: Expr) -> Iterator[Meetings]:
    """By one equation in omega."""
    if loop.rests and not loop.ring.lags:  # nor does a root come from infinity, or a chain
        yield _at_0(loop, ())
        return
    far_out = from_infinity(loop)
    if loop.turns:
        if _has_chain(loop, value):  # whatever the delay, as long as there is one
            yield Meetings((*far_out, Meeting(ExactNumber(Integer(0)), None)))
        elif loop.rests:
            yield _at_0(loop, far_out)
        else:
            found, last = Switches.of(loop).up_to(value)
            yield Meetings((*_at_0(loop, far_out).found, *found), below=last)
        return
    if is_neutral(loop) and not cells(loop, far_out):
        yield Meetings(far_out)
        return
    if loop.rests:
        yield _at_0(loop, far_out)
        return
    far_out = _at_0(loop, far_out).found
    curve = curve_of(loop)
    if curve is None:
        yield Meetings(far_out)
        return
    if curve.condition.is_zero:  # one value alone puts roots there, everywhere
        here = ValueAt(RealFunction(curve.value.reduced()), ExactNumber(Integer(1)))
        yield Meetings((*far_out, Meeting(here, None)))
        return
    settled = far(curve.condition)
    if settled.sense in _SETTLED:
        yield Meetings((*far_out, *curve.meetings(_near(settled.radius, loop))))
        return
    if is_neutral(loop):
        yield from neutral_meetings(loop, curve, far_out)
    else:
        yield from _windows(loop, curve, value, far_out)


def _at_0(loop: Loop, far_out: tuple[Meeting, ...]) -> Meetings:
    """With the values that put a root at 0."""
    return Meetings((*far_out, *(Meeting(x, ExactNumber(Integer(0))) for x in Characteristic(loop).at_0())))


def _near(radius: Expr, loop: Loop) -> Expr:
    """How far to look; UndecidedError where delays turn too often on the way."""
    if any(float(radius * lag) > _MOST_TURNING for lag in loop.ring.lags):
        raise UndecidedError("where roots meet the imaginary axis: its delays turn very often")
    return max(radius, Integer(1))


def _windows(loop: Loop, curve: Curve, value: Expr, far_out: tuple[Meeting, ...]) -> Iterator[Meetings]:
    """Where frequencies never end: as far as values lie in a window, about the value that is asked about."""
    done = False
    for j in range(_WINDOWS):
        high, low = (
            abs(value) + (1 + abs(value)) * Rational(4) ** (j - 2),
            value * _LOWS[min(j, 1)] / 4 ** max(j - 1, 0),
        )
        for end, sense in ((high, Sense.POSITIVE), (low, Sense.NEGATIVE)):
            ahead = far(minus(curve.square, end**2))
            if ahead.sense is sense and end > 0:
                found = (*far_out, *curve.meetings(_near(ahead.radius, loop)))
                done = True
                yield Meetings(found, -high, high) if end is high else Meetings(found, low)
    if not done:
        raise UndecidedError("where roots meet the imaginary axis at ever higher frequencies")


# A delay that is open


def _has_chain(loop: Loop, value: Expr) -> bool:
    """Whether infinitely many roots lie on the right, or come to the axis, at a delay > 0: at all of them, or at none."""
    with suppress(UndecidedError):
        return loop.at(Rational(value) if value.is_Rational and value else Integer(1)).chain is not None
    return False
