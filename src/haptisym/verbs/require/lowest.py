"""Taylor's coefficients of sums of waves at omega = 0, whatever their constant angles: exact."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache, reduce
from itertools import accumulate, repeat

from flint import fmpq, fmpq_poly
from sympy import Expr, Rational

from haptisym.kernel.axis import Axis
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.monomials import monomials
from haptisym.kernel.rings import Polynomial


def beginning(
    axis: Axis, polynomial: Polynomial, degrees: Sequence[int], length: int
) -> list[dict[tuple[int, ...], fmpq]]:
    """By the powers of omega, as many as asked for, numbers by the exponents of all else (pi, tangents of constant angles).

    The polynomial has neither parameters nor powers omega^alpha; a tangent^k stands for sin^k cos^(degree - k) of the half angle.

    >>> from haptisym.kernel.dynamics import Ring
    >>> from sympy import Rational
    >>> axis = Ring([], [Rational(1, 10)]).axis
    >>> w, _, T = axis.context.gens()
    >>> beginning(axis, T - w / 20, [2], 4)[3]   # (sin(omega/20) - omega/20 cos(omega/20)) cos(omega/20)
    {(0, 0, 0): 1/24000}
    """
    turning = [i for i, angle in enumerate(axis.angles, axis.size) if not angle.constant]
    waves = {i: _waves(axis.angles[i - axis.size].rate, degrees[i - axis.size], length) for i in turning}
    rows: dict[tuple[tuple[int, ...], tuple[int, ...]], list[fmpq]] = {}
    for exponents, value in monomials(polynomial):
        own = [int(n) for n in exponents]
        if own[0] < length:
            key = tuple(0 if i == 0 or i in waves else n for i, n in enumerate(own))
            row = rows.setdefault((key, tuple(own[i] for i in turning)), [fmpq(0)] * length)
            row[own[0]] += value
    total: dict[tuple[int, ...], fmpq_poly] = {}
    for (key, turns), row in rows.items():
        factors = (waves[i][k] for i, k in zip(turning, turns, strict=True))
        series = reduce(lambda x, y: x.mul_low(y, length), factors, fmpq_poly(row))
        total[key] = total[key] + series if key in total else series
    return [{key: series[n] for key, series in total.items()} for n in range(length)]


@lru_cache(maxsize=64)
def _waves(rate: Expr, degree: int, length: int) -> list[fmpq_poly]:
    """sin^k cos^(degree - k) of half an angle, as far as omega^length. Series of FLINT's in Python end at 10 terms: not these."""
    if not isinstance(rate, Rational):
        raise UndecidedError("how a condition begins at omega = 0")
    half = fmpq(int(rate.p), 2 * int(rate.q))
    terms = [fmpq(1)]
    for n in range(1, length):
        terms.append(terms[-1] * half / n)
    signs = (1, 1, -1, -1)
    sine, cosine = (fmpq_poly([x * signs[n % 4] if n % 2 == odd else 0 for n, x in enumerate(terms)]) for odd in (1, 0))
    sines, cosines = (_powers(x, degree, length) for x in (sine, cosine))
    return [x.mul_low(y, length) for x, y in zip(sines, reversed(cosines), strict=True)]


def _powers(x: fmpq_poly, degree: int, length: int) -> list[fmpq_poly]:
    """1, x, x^2, ..."""
    return list(accumulate(repeat(x, degree), lambda a, b: a.mul_low(b, length), initial=fmpq_poly([1])))
