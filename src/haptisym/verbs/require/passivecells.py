"""For which values of one parameter every passive hand may hold a display with delays or powers of s: by cells, each proven.

A cell of values is told as not passive where Im H_perc < 0 at one frequency for all of them; as passive where Im H_perc > 0 at
all frequencies, no pole comes to the axis and no highest power is lost in it, and one exact verdict in it is yes. Where the sign
turns first at frequency 0, it turns at a root of a polynomial: an exact end. What none of these shows is left open.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import inf, nextafter

from sympy import Expr, Integer, Poly, Rational

from haptisym.judge.criteria import PASSIVE
from haptisym.judge.passivity import passivity
from haptisym.kernel.budget import tick
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import LimitError, UndecidedError
from haptisym.kernel.reals import ExactNumber, RealNumber
from haptisym.kernel.rings import RationalFunction
from haptisym.kernel.roots import sign_of_number
from haptisym.model.distortion import Distortion
from haptisym.model.knobs import Knob
from haptisym.model.parameters import values
from haptisym.model.scene import Scene
from haptisym.verbs.require.energy import Energy, Span, keeps_sign
from haptisym.verbs.require.feasible import Binding, Kind, Solved
from haptisym.verbs.require.freeparameter import Domain
from haptisym.verbs.require.solving import allowed
from haptisym.verbs.require.verdicts import Question, Turn
from haptisym.verbs.stability.loops import zeros
from haptisym.verbs.tolerances.heldbox import count_at
from haptisym.verbs.tolerances.onaxis import OnAxis

_FAR = 1000  # times the value that a parameter has, where the range has no end
_FINEST, _LEAST = Rational(1, 1 << 11), Rational(1, 1 << 24)  # of the values, and of the range
_MOST = 200


@dataclass(frozen=True)
class _Cell:
    """Values, and whether all are passive; None: not shown, and if it ``is_last`` no part of it will be.

    ``turn`` : where they turn at a root of G(0, q). ``alone`` : ends that are to be asked about by themselves.
    """

    low: Rational
    high: Rational
    verdict: bool | None
    turn: RealNumber | None = None
    alone: tuple[Rational, ...] = ()
    is_last: bool = False


def solve_by_cells(scene: Scene, free: Knob, asked: Domain) -> Solved:
    """All values with which every passive hand may hold the display, as far as cells tell."""
    search = _Search(scene, free)
    start, end = _window(free, asked)
    if not any(search.is_told(x) for x in (Rational(free.value), start + (end - start) / 3, end)):
        raise UndecidedError(
            "whether every passive hand may hold it: Im H_perc comes too near to 0 somewhere to be told by cells"
        )
    cells = list(search.cells(start, end))
    turns = [Turn(x.turn, (Binding(PASSIVE, ExactNumber(Integer(0)), Kind.START),)) for x in cells if x.turn]
    turns += [Turn(ExactNumber(end), ()) for x in cells if x.verdict is None and not x.turn for end in (x.low, x.high)]

    alone = {end for x in cells for end in x.alone}
    turns += [Turn(ExactNumber(end), ()) for end in alone]

    def verdict(value: Expr) -> bool | None:
        if value in alone:
            return passivity(free.put(scene, value)).holds
        if not start <= value <= end:
            return further[value > end]
        own = [x for x in cells if x.low <= value <= x.high]
        if any(x.turn for x in own):
            return sign_of_number(search.energy.at_0.xreplace({free.symbol: value})) >= 0
        told = {x.verdict for x in own}
        return True if True in told else False if False in told else None

    first, last = (x.verdict for x in (cells[0], cells[-1]))
    below = asked.low is None and search.beyond(start, -1, here=first)
    above = asked.high is None and search.beyond(end, 1, here=last)
    further = {False: below, True: above}
    beyond = (start if below is None else None, end if above is None else None)
    found = Question(
        turns, verdict, asked, closed=True, beyond=beyond, exists=lambda x: allowed(scene, free, x)
    ).solve()
    return Solved(found.feasible, found.undecided, found.reason or (_LEFT if found.undecided else ""))


_LEFT = "whether Im H_perc is negative somewhere is not shown for values so near to each other, or so far out"


def _window(free: Knob, asked: Domain) -> tuple[Rational, Rational]:
    """As far as cells go."""
    own = abs(Rational(free.value)) or Rational(1)
    low = -_FAR * own if asked.low is None else asked.low
    high = _FAR * own if asked.high is None else asked.high
    if not (low.is_Rational and high.is_Rational):
        raise UndecidedError("whether every passive hand may hold it, in a range whose ends are no rational numbers")
    return low, high


def _span(low: Rational, high: Rational) -> Span:
    """The ends as floats, rounded outward."""
    a, b = float(low), float(high)
    return a if Rational(a) <= low else nextafter(a, -inf), b if Rational(b) >= high else nextafter(b, inf)


class _Search:
    """One parameter of one scene."""

    def __init__(self, scene: Scene, free: Knob) -> None:
        self.scene, self.free = scene, free
        display = scene.chain.at(values(x for x in scene.parameters if x.path != free.path))
        self.H: RationalFunction = Distortion.of(display).perc
        assert isinstance(self.H.ring, Ring)
        self.ring, self.energy = self.H.ring, Energy(self.H, free.symbol)

    def cells(self, start: Rational, end: Rational) -> Iterator[_Cell]:
        """Cells that fill a range, in order."""
        waiting, looked = [(start, end)], 0
        while waiting:
            low, high = waiting.pop()
            looked += 1
            try:
                tick(looked, _MOST, "cells of values")
                found = self._told(low, high)
            except LimitError:
                found, looked = _Cell(low, high, None), _MOST
            except UndecidedError:
                found = _Cell(low, high, None)
            is_small = high - low <= max(_FINEST * max(abs(low), abs(high)), _LEAST * (end - start))
            if found.verdict is not None or found.turn or found.is_last or looked >= _MOST or is_small:
                yield found
                continue
            middle = (low + high) / 2
            waiting += [(middle, high), (low, middle)]

    def is_told(self, value: Rational) -> bool:
        """Whether a sign is shown for one value, be it which it may."""
        q = float(value), float(value)
        return self.energy.active_at(q) is not None or self.energy.clear(q)

    def beyond(self, end: Rational, side: int, *, here: bool | None) -> bool | None:
        """Of all values from an end on, where the last cell is told; None where it is not known."""
        found = self.energy.beyond(float(end), side)
        return found if found == here else None

    def _told(self, low: Rational, high: Rational) -> _Cell:
        q = _span(low, high)
        if self.energy.active_at(q) is not None:
            return _Cell(low, high, verdict=False)
        if not self.energy.clear(q):
            return _Cell(low, high, None, self._turn(low, high))
        if not self._has_steady_poles(low, high):
            return _Cell(low, high, None)
        if count_at(self.ring, self.H.denominator, {self.free.symbol: (low + high) / 2}):
            return _Cell(low, high, None, is_last=True)  # of poles on the right some may be hidden at single values
        if not self._is_steady(low, high):
            return _Cell(low, high, None)
        if self._holds((low + high) / 2):
            return _Cell(low, high, verdict=True)
        return _Cell(low, high, verdict=False, alone=(low, high))

    def _turn(self, low: Rational, high: Rational) -> RealNumber | None:
        """The one value at which Im H_perc ceases to be negative just above frequency 0, and so everywhere; None: not shown."""
        try:
            form, q = self.energy.at_0, _span(low, high)
        except UndecidedError:
            return None
        if not form.is_polynomial(self.free.symbol) or not form.has(self.free.symbol):
            return None
        if low < 0 and Poly(form, self.free.symbol).degree() > 1:
            return None
        row = Poly(form, self.free.symbol).all_coeffs()[::-1]
        inside = [x for x in zeros(row) if float(low) < float(x) < float(high)]
        ends = [sign_of_number(form.xreplace({self.free.symbol: x})) for x in (low, high)]
        if len(inside) != 1 or ends[0] * ends[1] >= 0:
            return None
        risen = self.energy.rises(q)
        if risen is None or not self.energy.clear(q, risen) or not self._has_steady_poles(low, high):
            return None
        if count_at(self.ring, self.H.denominator, {self.free.symbol: low}) or not self._is_steady(low, high):
            return None
        passive = low if ends[0] > 0 else high
        return inside[0] if self._holds(passive + (Rational(float(inside[0])) - passive) / 2) else None

    def _holds(self, value: Rational) -> bool:
        return passivity(self.free.put(self.scene, value)).holds is True

    def _has_steady_poles(self, low: Rational, high: Rational) -> bool:
        """Whether no pole comes to the axis, nor from infinity, for all values."""
        below = OnAxis(self.ring, self.H.denominator, {self.free.symbol: (low, high)})
        return below.reach is not None and not len(below.left())

    def _is_steady(self, low: Rational, high: Rational) -> bool:
        """Whether H_perc(0) keeps its sign and no highest power of its numerator is lost, but at an end, for all values."""
        first = self.ring.size + len(self.ring.lags)
        powers = dict.fromkeys(range(first, first + len(self.ring.orders)), 0)
        at_0 = self.ring.expression(self.ring.at_0(self.H.numerator).subs(powers))
        if at_0 != 0 and not keeps_sign(at_0, self.free.symbol, low, high):
            return False
        steady = self.energy.has_steady_top(low, high)
        return steady or OnAxis(self.ring, self.H.numerator, {self.free.symbol: (low, high)}).reach is not None
