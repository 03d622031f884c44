"""At which values of one open number a root, or a chain of infinitely many, comes from infinity.

They do where what multiplies the highest power of s, L(z; q) with z = exp(-s tau), is lost or has a zero with |z| = 1.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import combinations, product

from sympy import Integer

from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.far import Sense, far
from haptisym.kernel.reals import RealNumber
from haptisym.kernel.roots import sign_of_number
from haptisym.kernel.squares import Row
from haptisym.kernel.symbols import s
from haptisym.kernel.torus import is_mirrored, least_on_torus
from haptisym.verbs.stability.curves import Meeting, curve_of
from haptisym.verbs.stability.loops import Loop, zeros

_MOST_DELAYED = 5
Leading = Mapping[tuple[int, ...], Row]


def from_infinity(loop: Loop) -> tuple[Meeting, ...]:
    """All of these values, and perhaps others."""
    return tuple(Meeting(x, None) for x in _values(loop))


def _values(loop: Loop) -> Iterator[RealNumber]:
    leading = loop.leading
    _need_same_zeros(leading, loop)
    if not any(any(row[1:]) for row in leading.values()):
        return
    if loop.low is None and any(any(row[2:]) for row in leading.values()):
        raise UndecidedError("where a chain of roots comes to the axis, of a number that may be negative")
    if _is_product(leading):
        yield from zeros(next(iter(leading.values())))
        return
    delayed = [turns for turns in leading if any(turns)]
    units = {i for turns in delayed for i, n in enumerate(turns) if n}
    if len(delayed) > 1 and len(units) == 1:
        yield from _on_circle(leading, units.pop(), loop)
        return
    if len(delayed) > _MOST_DELAYED:
        raise UndecidedError("where a chain of roots comes to the axis, as many delays meet in the highest power of s")
    own = leading.get((0,) * len(loop.ring.lags), [Integer(0)])
    for signs in product((1, -1), repeat=len(delayed)):  # |own| = sum of |delayed|, whatever their signs are
        yield from zeros(_sum([own, *([sign * c for c in leading[x]] for sign, x in zip(signs, delayed, strict=True))]))


def _need_same_zeros(leading: Leading, loop: Loop) -> None:
    """UndecidedError where an open delay meets another one in L: its zeros turn on whether their ratio is rational."""
    least = [min(column) for column in zip(*leading, strict=True)]  # what is in all terms has no zeros
    own = {tuple(n - k for n, k in zip(turns, least, strict=True)): row[0] for turns, row in leading.items()}
    units = {i for turns in own for i, n in enumerate(turns) if n}
    if len(units) < 2 or not any(loop.symbol in loop.ring.lags[i].free_symbols for i in units):
        return
    if not (loop.rests and is_mirrored(own)) and least_on_torus(own) is None:
        raise UndecidedError("where a chain of roots comes to the axis, as delays meet that are no multiples of one")


def _is_product(leading: Leading) -> bool:
    """Whether L = c(q) A(z): its zeros are the same for all q, and all of them are lost where c is 0."""
    first, *others = leading.values()
    places = list(combinations(range(len(first)), 2))
    return not any(sign_of_number(first[i] * row[k] - first[k] * row[i]) for row in others for i, k in places)


def _sum(rows: list[Row]) -> Row:
    longest = max(map(len, rows))
    return [sum((row[i] for row in rows if i < len(row)), Integer(0)) for i in range(longest)]


def _on_circle(leading: Leading, unit: int, loop: Loop) -> Iterator[RealNumber]:
    """Of one unit delay: z = 1 and z = -1, where L is real, and the rest as z = (1 - w)/(1 + w), on the axis of w."""
    powers = {turns[unit]: row for turns, row in leading.items()}
    n = max(powers)
    for end in (1, -1):
        yield from zeros(_sum([[end**i * c for c in row] for i, row in powers.items()]))
    turned = sum(
        c * loop.symbol**k * (1 - s) ** i * (1 + s) ** (n - i) for i, row in powers.items() for k, c in enumerate(row)
    )
    plain = turned.expand()
    ring = Ring.of([plain])
    top = ring.convert(plain).numerator
    curve = curve_of(Loop(ring, top, top.context().constant(1), loop.symbol, loop.low, loop.high))
    if curve is None or curve.condition.is_zero:
        raise UndecidedError("where a chain of roots comes to the axis")
    settled = far(curve.condition)
    if settled.sense not in (Sense.POSITIVE, Sense.NEGATIVE):
        raise UndecidedError("where a chain of roots comes to the axis")
    yield from (x.value for x in curve.meetings(max(settled.radius, Integer(1))))


def is_neutral(loop: Loop) -> bool:
    """Whether the highest power of s comes late too."""
    return any(any(turns) for turns in loop.leading)
