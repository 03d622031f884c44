"""|A|^2 - |B|^2 on the imaginary axis, of A(s) + B(s) exp(-s tau): where it is positive, no root of the sum lies on the axis."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product
from typing import TypeAlias

import flint
from flint import arb
from sympy import Expr, Integer, Rational

from haptisym.kernel.reals import expression_ball
from haptisym.kernel.terms import Terms

Row: TypeAlias = list[Expr]
"""The coefficients of a polynomial in one number that is open, ascending; one alone where none is."""

_BITS = 128
_FIRST, _MOST_DOUBLINGS = Rational(1, 1 << 20), 80


def late_turns(turns: set[tuple[int, ...]], powers: Sequence[Rational]) -> tuple[int, ...] | None:
    """The one product of unit delays that comes late; None where there are more or none, or powers of s are broken."""
    late = [x for x in turns if any(x)]
    return late[0] if len(late) == 1 and all(p.is_Integer for p in powers) else None


def squares(table: Mapping[Rational, Mapping[tuple[int, ...], Row]], late: tuple[int, ...]) -> list[Row]:
    """By falling powers of omega^2, from a table by the power of s and by how often each unit delay is in it."""
    none = (0,) * len(late)
    degree = int(max(table))
    longest = max(len(row) for group in table.values() for row in group.values())
    rows = [[Integer(0)] * (2 * longest - 1) for _ in range(degree + 1)]
    for p, r in product(table, repeat=2):
        if (p - r) % 2:
            continue
        row, sign = rows[degree - int(p + r) // 2], (-1) ** (int(abs(p - r)) // 2)
        for turns, side in ((none, sign), (late, -sign)):
            for i, x in enumerate(table[p].get(turns, ())):
                for k, y in enumerate(table[r].get(turns, ())):
                    row[i + k] += side * x * y
    return [[c.expand() for c in row] for row in rows]


def positive_from(terms: Terms, late: tuple[int, ...]) -> Rational | None:
    """A frequency beyond which |A|^2 - |B|^2 > 0; None where none is found. |A| must not be the less at infinity."""
    table = {p: {turns: [c] for turns, c in group.items()} for p, group in terms.items()}
    with flint.ctx.workprec(_BITS):
        first, *others = (expression_ball(row[0]).lower() for row in squares(table, late))
        weights = [first.max(arb(0)), *others[:1], *(x.min(arb(0)) for x in others[1:])]
        at = _FIRST
        for _ in range(_MOST_DOUBLINGS):
            ball = arb(int(at.p)) / int(at.q)
            if sum((x * ball ** (2 - 2 * i) for i, x in enumerate(weights)), arb(0)) > 0:
                return at
            at *= 2
    return None
