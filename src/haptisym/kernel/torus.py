"""How small a polynomial of several exp(-s tau_i) becomes on s = j omega, whatever the delays are: on a torus of angles.

A polynomial without a zero on the torus, where all |z_i| = 1, has one where all |z_i| <= 1 only if it has one where all z_i are
alike (DeCarlo, Murray and Saeks, 1977); if it has none, it is nowhere there smaller than on the torus, by the maximum principle
for 1/L.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TypeAlias

import flint
from flint import acb, arb
from sympy import Expr, Rational

from haptisym.kernel.reals import Ball, expression_ball
from haptisym.kernel.subdivision import Waiting

_BITS = 64
_MOST_CELLS = 20_000
_LEAST = 1e-3  # of all sizes together: less takes many cells
_SHARE = 0.5  # of the least value that was met: a bound that is as good as that will do

_Box: TypeAlias = tuple[tuple[Ball, Ball], ...]
"""Middle and half of what each angle is, in turns."""


def least_on_torus(group: Mapping[tuple[int, ...], Expr]) -> Rational | None:
    """A number > 0 that |L| is nowhere less than, where all |z_i| = 1: branch and bound. None where it is 0 somewhere, or nearly.

    ``group`` : what stands before each product of powers of the z_i, real.

    >>> from sympy import Integer
    >>> least_on_torus({(0, 0): Integer(4), (1, 0): Integer(1), (0, 1): Integer(2)}) > Rational(1, 2)
    True
    >>> least_on_torus({(0, 0): Integer(3), (1, 0): Integer(1), (0, 1): Integer(2)}) is None
    True
    """
    units = range(len(next(iter(group))))
    with flint.ctx.workprec(_BITS):
        terms = [(expression_ball(c), turns) for turns, c in group.items()]
        slopes = [2 * arb.pi() * sum((n[k] * abs(c) for c, n in terms), arb(0)) for k in units]
        whole = sum((abs(c) for c, _ in terms), arb(0))
        best = whole.upper()

        def cell(box: _Box) -> tuple[float, _Box]:
            nonlocal best
            angles = [acb(0, 2) * arb.pi() * middle for middle, _ in box]
            size = abs(sum((c * sum(x * k for x, k in zip(angles, n, strict=True)).exp() for c, n in terms), acb(0)))
            best = min(best, size.upper())
            bound = size - sum((slope * half for slope, (_, half) in zip(slopes, box, strict=True)), arb(0))
            return float(bound.lower()), box

        start = tuple((arb(0.5), arb(0.5)) for _ in units)
        cells = Waiting([cell(start)], rank=lambda x: x[0], most=_MOST_CELLS, what="phases of delays")
        for bound, box in cells:
            if bound > 0 and bound >= _SHARE * float(best):
                return Rational(bound)
            if best < _LEAST * whole:
                break
            cells.add(*map(cell, _halves(box, slopes)))
    return None


def is_mirrored(group: Mapping[tuple[int, ...], Expr]) -> bool:
    """Whether L(1/z) is L(z) or -L(z) but for powers of z: with each zero in s, -s is one too, however long the delays are.

    >>> from sympy import Integer
    >>> of = [{(0, 0): 3, (1, 0): 1, (0, 1): 1, (1, 1): 3}, {(0, 0): 3, (1, 0): 1, (0, 1): 2, (1, 1): 3}, {(0, 0): 3}]
    >>> [is_mirrored({turns: Integer(c) for turns, c in group.items()}) for group in of]
    [True, False, False]
    """
    most = [max(column) for column in zip(*group, strict=True)]
    other = {turns: group.get(tuple(n - k for n, k in zip(most, turns, strict=True)), 0) for turns in group}
    return len(group) > 1 and any(all(c == side * other[turns] for turns, c in group.items()) for side in (1, -1))


def _halves(box: _Box, slopes: Sequence[Ball]) -> list[_Box]:
    """A box in two, across the angle along which L may change most."""
    k = max(range(len(box)), key=lambda i: float(slopes[i] * box[i][1]))
    middle, half = box[k][0], box[k][1] / 2
    return [(*box[:k], (middle + side * half, half), *box[k + 1 :]) for side in (-1, 1)]
