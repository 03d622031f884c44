"""A loop with a clock that is later by d whole samples and a share theta of one: z^d Q(z; theta) + N(z; theta) = 0.

On z = exp(j phi) that asks for |Q| = |N|, whatever d is, and then d phi is an angle of -N/Q: cells of theta and phi tell the
least d at which they allow it. Before that no root is on the circle; from there on thin cells close in on the first theta.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from math import ceil, floor, pi
from typing import Any, TypeAlias

from flint import acb, arb, arb_poly, ctx
from sympy import Integer

from haptisym.kernel.budget import Waiting
from haptisym.kernel.enclosures import over_circle
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import Ball, fraction_ball
from haptisym.verbs.stability.opened import Opened, Passage

Phis: TypeAlias = "list[tuple[float, float]]"
Piece: TypeAlias = "tuple[Opened, Fraction, Fraction]"

_PI = 3.1415926535897936  # a little more
_COARSE, _FINE, _FINEST, _SLOWEST, _MORE, _TURNS, _PARTS = 2.0**-6, 2.0**-12, 2.0**-16, 2.0**-14, 16, 64, 4
_SHARPEST, _ROUNDED = 2.0**-40, 1e-9
_BITS, _DEEPEST, _MOST_CELLS, _MOST_CUTS = 128, 128, 20_000, 1000


@dataclass(frozen=True)
class Late:
    """The first ``passage`` there is, of a loop so many ``samples`` later; None: none ``known`` up to a delay, s, and ``why``."""

    passage: Passage | None
    samples: int
    known: Fraction
    why: str = ""


@dataclass(frozen=True)
class Later:
    """``pieces`` : of one period ``T`` those within which all delays keep their whole samples, with the loop there.

    ``close`` : gives the passage between two shares that are near to each other, of a loop with its whole samples; None: none.
    """

    pieces: Sequence[Piece]
    T: Fraction
    close: Callable[[Opened, Fraction, Fraction], Passage | None]

    def first(self, after: Fraction, last: Fraction) -> Late:
        """The least delay above one, and up to another one, at which a root comes to the circle."""
        own, most = int(after // self.T), ceil(last / self.T)
        try:
            known = [*self._likely(own, most)]
        except UndecidedError as error:
            return Late(None, own, after, str(error))
        least = min((d for d, _, _ in known), default=most)
        samples = least
        while samples < min(most, least + _MORE) and least <= own + _DEEPEST:
            for loop, low, high in self.pieces:
                low = max(low, after - samples * self.T)
                phis = [*dict.fromkeys(phi for _, phi, piece in known if piece is loop)]
                found = self._in(loop, low, high, samples, phis) if low < high else None
                if found is not None:
                    return replace(found, known=found.known + samples * self.T)
            samples += 1
        up_to = max(after, samples * self.T)
        return Late(None, samples, min(up_to, last), "" if up_to >= last else "too many samples")

    def _likely(self, own: int, most: int) -> Iterator[tuple[int, tuple[float, float], Opened]]:
        """Cells of phi with a root that may be on the circle, from ``own`` to ``most`` samples late: with how many at least."""
        for loop, a, b in self.pieces:
            for i in range(_PARTS):
                low, high = (a + (b - a) * (i + n) / _PARTS for n in (0, 1))
                cells = self._allowed(loop, low, high, _FINE, [(0.0, _PI)], (own, most))
                yield from ((d, phi, loop) for d, phi in cells)

    def _allowed(
        self, loop: Opened, low: Fraction, high: Fraction, finest: float, phis: Phis, samples: tuple[int, int]
    ) -> Iterator[tuple[int, tuple[float, float]]]:
        """Cells of phi with a root that may be on the circle, and with how many whole samples, of those asked for, at least."""
        own, most = samples
        with ctx.workprec(_BITS):
            q = fraction_ball(low).union(fraction_ball(high))
            lines = over_circle(lambda x: loop.loop.sides({loop.symbol: x})[0].coeffs(), q.mid(), q.rad())
            N, slope, _ = (arb_poly(list(x)) for x in zip(*lines, strict=True))
            Q, either = loop.loop.sides({loop.symbol: q})[1], arb(0, 1)
            waiting, looked = [*phis], 0
            while waiting:
                a, b = waiting.pop()
                looked += 1
                if looked > _MOST_CELLS:
                    raise UndecidedError("too many cells of frequency")
                phi = arb(a).union(arb(b))
                above, below = _all_over(N, phi) + _all_over(slope, phi) * either, _all_over(Q, phi)
                if not abs(above).overlaps(abs(below)):
                    continue
                d = own if below.contains(0) else _least(_angle(-above / below), a, b, own)
                if d > most:
                    continue
                is_sharp = below.abs_upper() < 2 * below.abs_lower()  # not next to a zero of Q, of which there are few
                if b - a > (finest * max(b, _SLOWEST) if is_sharp else _SHARPEST):
                    waiting += [(a, (a + b) / 2), ((a + b) / 2, b)]
                else:
                    yield d, (a, b)

    def _in(self, loop: Opened, low: Fraction, high: Fraction, d: int, phis: Phis) -> Late | None:
        """The first in a piece that is later by so many samples, by shares of one; None where none is there."""
        late = replace(loop, loop=replace(loop.loop, above=(*[Integer(0)] * d, *loop.loop.above)))
        waiting, why = Waiting([(low, high, phis)], most=_MOST_CUTS), "too many pieces of delay"
        try:
            for start, end, whole in waiting:
                width = float((end - start) / self.T)
                finest = min(_COARSE, width / (4 * d + 4))
                cells = self._allowed(loop, start, end, finest, whole, (d, d))
                if not (likely := [phi for _, phi in cells]):
                    continue
                if width <= _FINEST:
                    if (found := self.close(late, start, end)) is not None:
                        return Late(found, d, end)
                    if width < _FINEST**2:
                        raise UndecidedError("whether a root comes to the unit circle and goes back")
                middle = Fraction(float((start + end) / 2))
                waiting.add((start, middle, likely), (middle, end, likely))
        except UndecidedError as error:
            why = str(error)
        return Late(None, d, min(start for start, _, _ in waiting.rest), why) if waiting.rest else None


def _all_over(polynomial: Any, phi: Ball) -> acb:
    """A polynomial in z - 1 all over a piece of the circle, by its slope: powers of a ball grow faster than what they are of."""
    x, middle = (acb(-2 * (angle / 2).sin() ** 2, angle.sin()) for angle in (phi, phi.mid()))
    return polynomial(middle) + polynomial.derivative()(x) * (x - middle)


def _angle(x: acb) -> Ball:
    """Of a number, all over its ball: about pi where it is about -1, not both pi and -pi."""
    return x.arg() if not x.real < 0 else (-x).arg() + arb.pi()


def _least(angle: Ball, a: float, b: float, own: int) -> int:
    """A least d >= ``own`` for which d phi may be an angle, all over its ball, but for whole turns, with phi from a to b."""
    if not angle.is_finite() or angle.rad() > 1:
        return own
    first, last = float(angle.lower()) - _ROUNDED, float(angle.upper()) + _ROUNDED
    turn, low = max(0, floor((own * a - last) / (2 * pi))), own
    for k in range(turn, turn + _TURNS):
        low = max(own, ceil((first + 2 * pi * k) / b))
        if last + 2 * pi * k >= low * a:
            break
    return low
