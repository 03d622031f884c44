"""Whether other values of a model's parameters give the very same response: a question of algebra, which no line answers.

Two responses are one where numerator and denominator are, but for one factor. With the values that were found (to three digits)
on the one side these are polynomial equations for the parameters, solved by a Groebner basis.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from functools import reduce
from math import lcm
from operator import mul
from typing import Any

import numpy as np
from flint import fmpz_mpoly_ctx, fmpz_mpoly_vec, fmpz_poly

from haptisym.model.distortion import distort
from haptisym.model.measured import Reals
from haptisym.verbs.identify.wanted import Wanted

_LIMITS = 60, 400, 20_000  # polynomials of a basis, terms of one, bits of a coefficient
_SAME = 1e-4  # relative: values and roots that differ by less are one, as the values have three digits


def twins(wanted: Wanted, values: Reals) -> tuple[Reals, ...] | None:
    """Other positive values that give the response of these, nearly; None where that was not decided.

    What stands in a delay or a power of s is left as it is.

    >>> from haptisym.verbs.identify.wanted import wanted
    >>> asked = wanted("maxwell", ["first-order-lag"], None, None)
    >>> [x.round(6).tolist() for x in twins(asked, np.array([300.0, 6.0, 12.0]))]
    [[72.0, 6.0, 50.0]]
    """
    own, effects = wanted.elements(lambda x: x.symbol)
    perceived = distort(own, *effects).perc.reduced()
    ring, parts = perceived.ring, (perceived.numerator, perceived.denominator)
    inside = {x for meaning in ring.meanings[ring.size :] for x in meaning.free_symbols}
    near = {x.symbol: Fraction(f"{value:.3g}") for x, value in zip(wanted.free, values.tolist(), strict=True)}
    free = [x for x in near if x not in inside]
    if not free or any(near[x] <= 0 for x in free):
        return None
    places = [ring.meanings.index(x) for x in near]
    context = fmpz_mpoly_ctx.get(["t", "factor", *map(str, free)], "lex")
    _, factor, *unknown = context.gens()
    equations = [reduce(mul, unknown, context.gens()[0] * factor) - 1]  # none of them is 0
    for part in parts:
        rows: dict[tuple[int, ...], dict[tuple[int, ...], Fraction]] = {}
        for powers, coefficient in part.to_dict().items():
            beside = tuple(0 if i in places else n for i, n in enumerate(powers))
            rows.setdefault(beside, {})[tuple(powers[i] for i in places)] = Fraction(
                int(coefficient.p), int(coefficient.q)
            )
        for terms in rows.values():
            total, known = _equation(context.constant(0), terms, near, dict(zip(free, unknown, strict=True)))
            equations.append(total * known.denominator - factor * known.numerator)
    basis, whole = fmpz_mpoly_vec(equations, context).buchberger_naive(limits=_LIMITS)
    if not whole:
        return None
    found = _solved([*basis.autoreduction()], len(unknown))
    if found is None:
        return None
    given = np.array([float(near[x]) for x in free])
    others = [x for x in found if not np.allclose(x, given, rtol=_SAME)]
    return tuple(np.array([x[free.index(y)] if y in free else values[i] for i, y in enumerate(near)]) for x in others)


def _equation(total: Any, terms: Any, near: Any, unknown: Any) -> tuple[Any, Fraction]:
    """A coefficient as a polynomial in what is unknown, times a whole number, and its value at the values that were found."""
    known, scale = Fraction(0), lcm(*(c.denominator for c in terms.values()))
    for powers, c in terms.items():
        term = total * 0 + int(c * scale)
        value = c * scale
        for (symbol, at), n in zip(near.items(), powers, strict=True):
            value *= at ** int(n)
            if n and symbol in unknown:
                term = term * unknown[symbol] ** int(n)
        known += value
        total = total + term
    return total, known


def _solved(basis: list[Any], count: int) -> list[Reals] | None:
    """The positive solutions of a basis in lexical order, from the last unknown on; None where there is no end of them."""
    found: list[list[float]] = [[]]
    for k in range(count):
        at = 2 + count - 1 - k  # its place in the context
        own = [p for p in basis if p.degrees()[at] and not any(p.degrees()[:at])]
        if not any(all(not n for i, n in enumerate(_leading(p)) if i != at) for p in own):
            return None
        found = [[x, *rest] for rest in found for x in _roots(own, at, rest)]
    return [np.array(x) for x in found]


def _leading(p: Any) -> tuple[int, ...]:
    powers: tuple[int, ...] = tuple(p.monomial(0))
    return powers


def _roots(own: Sequence[Any], at: int, rest: Sequence[float]) -> Iterator[float]:
    """The positive numbers at which polynomials in one unknown, the later ones being known, vanish together."""
    rows = []
    for p in own:
        row = [Fraction(0)] * (p.degrees()[at] + 1)
        for powers, c in p.to_dict().items():
            later = zip(powers[at + 1 :], rest, strict=True)
            row[int(powers[at])] += int(c) * Fraction(float(np.prod([x ** int(n) for n, x in later])))
        rows.append(row)
    row = min((x for x in rows if any(x[1:])), key=len, default=[Fraction(1)])
    scale = lcm(*(x.denominator for x in row))
    for root, _ in fmpz_poly([int(x * scale) for x in row]).complex_roots():
        x, y = float(root.real.mid()), float(root.imag.mid())
        if x > 0 and abs(y) < _SAME * x:
            yield x
