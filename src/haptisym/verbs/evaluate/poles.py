"""What shows that all poles of a dynamics lie in the open left half plane, or that one does not."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import pairwise
from math import comb
from typing import Any, TypeAlias

import flint
from flint import fmpz_poly
from sympy import Integer, Rational

from haptisym.kernel.dynamics import Ring
from haptisym.kernel.reals import ExactNumber, RealNumber, Sliver, bounds, rational_between
from haptisym.kernel.rings import Polynomial, RationalFunction
from haptisym.verbs.evaluate.products import Factor, Rows, rows_of

_BITS = 128  # of roots that only say where to look: what is found is checked, or left out


def poles(dynamics: RationalFunction, *, stable: bool | None) -> dict[str, Any] | None:
    """The poles of a dynamics in lowest terms, with a witness that they are stable, or not; None where none is found."""
    ring = dynamics.ring
    assert isinstance(ring, Ring)
    if stable is None or any(any(e[2:]) for p in (dynamics.numerator, dynamics.denominator) for e in p.monoms()):
        return None
    unit, factors = ring.factors(dynamics.denominator, in_square=False)
    top, number = _whole(dynamics.numerator)
    rows = [rows_of(p) for p, _ in factors]
    shared = rows_of(top)
    disc = None if stable else next((x for i, p in enumerate(rows) if (x := _beyond(i, p, shared))), None)
    if not stable and disc is None:
        return None
    return {
        "number": str(number / unit),
        "numerator": _texts(shared),
        "factors": [[_texts(x), n] for x, (_, n) in zip(rows, factors, strict=True)],
        "turns": [_turns(x) for x in rows] if stable else None,
        "disc": disc,
    }


def _whole(polynomial: Polynomial) -> tuple[Polynomial, Rational]:
    """A polynomial with whole coefficients, and by what it is to be multiplied."""
    scale = 1
    for c in polynomial.coeffs():
        scale = scale * int(c.q) // flint.fmpz(scale).gcd(int(c.q))
    return polynomial * int(scale), Rational(1, int(scale))


def _texts(rows: Rows) -> list[list[str]]:
    return [[str(n) for n in row] for row in rows]


def _even_odd(rows: Rows) -> tuple[Factor, Factor]:
    """E and O of p(j omega) = E + j omega O."""
    halves = (tuple(tuple(n * (-1) ** k for n in row) for k, row in enumerate(rows[i::2])) for i in (0, 1))
    even, odd = (Factor(x, 2) for x in halves)
    return even, odd


def _zeros(factor: Factor) -> list[RealNumber]:
    """The positive frequencies near which a factor in omega^2 vanishes, ascending."""
    with flint.ctx.workprec(_BITS):
        roots = [z.real for z, _ in _roots(factor) if z.imag.contains(0) and z.real > 0]
        return [Sliver(*bounds(x.sqrt())) for x in sorted(roots, key=lambda x: x.mid())]


def _roots(factor: Factor) -> list[Any]:
    plain = factor.bounds[0]
    return fmpz_poly(plain.numer().coeffs()).complex_roots() if plain.degree() > 0 else []


def _turns(rows: Rows) -> list[str]:
    """Frequencies in one quadrant after the other: between the zeros of E and O, which interlace where p is stable."""
    zeros = sorted([x for half in _even_odd(rows) if half.rows for x in _zeros(half)], key=float)
    if len(rows) == 1:
        return []
    return [str(rational_between(a, b)) for a, b in pairwise([ExactNumber(Integer(0)), *zeros, None]) if a is not None]


def _beyond(index: int, rows: Rows, numerator: Rows) -> list[Any] | None:
    """A disc about a zero of a factor on the imaginary axis, or right of it, in which the numerator has none."""
    tried = _on_axis(rows) if _is_even(rows) else _in_the_right_half(rows)
    found = next((x for x in tried if _alone(Factor(numerator, 1), *x, 0)), None)
    return None if found is None else [index, *map(str, found)]


_Disc: TypeAlias = tuple[Fraction, Fraction, Fraction]


def _is_even(rows: Rows) -> bool:
    return rows == ((0,), (1,)) or (not any(any(row) for row in rows[1::2]) and bool(_zeros(_even_odd(rows)[0])))


def _on_axis(rows: Rows) -> Iterator[_Disc]:
    if rows == ((0,), (1,)):
        yield Fraction(0), Fraction(0), Fraction(1, 10**9)
        return
    low, high = _zeros(_even_odd(rows)[0])[0].bounds(0)
    yield Fraction(0), (low + high) / 2, (high - low) / 2


def _in_the_right_half(rows: Rows) -> Iterator[_Disc]:
    """Discs that hold one zero, by Rouche."""
    p = Factor(rows, 1)
    for z, _ in _roots(p):
        with flint.ctx.workprec(_BITS):
            x, y = (sum(bounds(part), Fraction(0)) / 2 for part in (z.real, z.imag))
        for n in range(0, 64, 4):
            if x > 0 and _alone(p, x, y, x / 2**n, 1):
                yield x, y, x / 2**n


def _alone(p: Factor, x: Fraction, y: Fraction, r: Fraction, k: int) -> bool:
    """Whether the Taylor coefficient of order k outweighs all others within r of x + j y: there are k zeros."""
    low, high = ([Fraction(int(c.p), int(c.q)) for c in ends.coeffs()] for ends in (p.bounds[0], p.bounds[-1]))
    found = [_derivative(low, x, y, n) for n in range(len(low))]
    sizes = [(abs(a) + abs(b)) * r**n for n, (a, b) in enumerate(found)]
    reach = abs(x) + abs(y) + r
    left = sum((b - a) * reach**n for n, (a, b) in enumerate(zip(low, high, strict=True)))
    return len(found) > k and max(map(abs, found[k])) * r**k > sum(sizes) - sizes[k] + left


def _derivative(p: Sequence[Fraction], x: Fraction, y: Fraction, k: int) -> tuple[Fraction, Fraction]:
    """The Taylor coefficient of order k at x + j y, real and imaginary part."""
    re, im = Fraction(0), Fraction(0)
    for i in range(len(p) - 1, k - 1, -1):
        re, im = re * x - im * y + comb(i, k) * p[i], re * y + im * x
    return re, im
