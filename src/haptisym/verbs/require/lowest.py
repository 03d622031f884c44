"""Taylor's coefficients of sums of waves at omega = 0, whatever their constant angles: exact."""

from __future__ import annotations

from collections.abc import Sequence

from flint import fmpq, fmpq_series
from sympy import Expr, Rational

from haptisym.kernel.axis import Axis
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.monomials import monomials
from haptisym.kernel.rings import Polynomial

_LENGTH = 40


def beginning(axis: Axis, polynomial: Polynomial, degrees: Sequence[int]) -> list[dict[tuple[int, ...], fmpq]]:
    """By the powers of omega, numbers by the exponents of all else (pi, tangents of constant angles) they are multiplied with.

    The polynomial has neither parameters nor powers omega^alpha; a tangent^k stands for sin^k cos^(degree - k) of the half angle.

    >>> from haptisym.kernel.dynamics import Ring
    >>> from sympy import Rational
    >>> axis = Ring([], [Rational(1, 10)]).axis
    >>> w, _, T = axis.context.gens()
    >>> beginning(axis, T - w / 20, [2])[3]      # (sin(omega/20) - omega/20 cos(omega/20)) cos(omega/20)
    {(0, 0, 0): 1/24000}
    """
    turning = [i for i, angle in enumerate(axis.angles, axis.size) if not angle.constant]
    waves = {i: _waves(axis.angles[i - axis.size].rate, degrees[i - axis.size]) for i in turning}
    rows: dict[tuple[tuple[int, ...], tuple[int, ...]], list[fmpq]] = {}
    for exponents, value in monomials(polynomial):
        own = [int(n) for n in exponents]
        if own[0] < _LENGTH:
            key = tuple(0 if i == 0 or i in waves else n for i, n in enumerate(own))
            row = rows.setdefault((key, tuple(own[i] for i in turning)), [fmpq(0)] * _LENGTH)
            row[own[0]] += value
    total: dict[tuple[int, ...], fmpq_series] = {}
    for (key, turns), row in rows.items():
        series = _product([waves[i][k] for i, k in zip(turning, turns, strict=True)]) * fmpq_series(row, prec=_LENGTH)
        total[key] = total[key] + series if key in total else series
    return [{key: series[n] for key, series in total.items()} for n in range(_LENGTH)]


def _waves(rate: Expr, degree: int) -> list[fmpq_series]:
    """sin^k cos^(degree - k) of half an angle."""
    if not isinstance(rate, Rational):
        raise UndecidedError("how a condition begins at omega = 0")
    half = fmpq_series([0, fmpq(int(rate.p), 2 * int(rate.q))], prec=_LENGTH)
    sine, cosine = half.sin(), half.cos()
    return [_power(sine, k) * _power(cosine, degree - k) for k in range(degree + 1)]


def _power(x: fmpq_series, n: int) -> fmpq_series:
    found = fmpq_series([1], prec=_LENGTH)
    for _ in range(n):
        found = found * x
    return found


def _product(series: Sequence[fmpq_series]) -> fmpq_series:
    found = fmpq_series([1], prec=_LENGTH)
    for x in series:
        found = found * x
    return found
