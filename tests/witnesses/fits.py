"""Fits worked out a second time with 40 digits: linear least squares by normal equations, a cumulative Gaussian by Newton's method."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import mpmath

MP = mpmath.MPContext()
MP.dps = 40
CHI_95 = MP.mpf("3.841458820694124")
"""Of one degree of freedom."""


def polynomial_fit(
    omega: Sequence[float], H: Sequence[complex], sigma: Sequence[float], count: int
) -> tuple[Any, Any, Any]:
    """a0 + a1 s + ... to complex numbers with real a: values, standard errors, and the least sum of squares."""
    rows, right = [], []
    for w, h, size in zip(omega, H, sigma, strict=True):
        powers = [MP.mpc(0, w) ** n / MP.mpf(size) for n in range(count)]
        rows += [[x.real for x in powers], [x.imag for x in powers]]
        right += [MP.mpf(h.real) / MP.mpf(size), MP.mpf(h.imag) / MP.mpf(size)]
    A, b = MP.matrix(rows), MP.matrix(right)
    inverse = (A.T * A) ** -1
    values = inverse * (A.T * b)
    rest = A * values - b
    return list(values), [MP.sqrt(inverse[i, i]) for i in range(count)], sum(x * x for x in rest)


Answers = Sequence[tuple[float, int, int]]
"""Levels, counts of "more", and trials."""


def likelihood(answers: Answers, a: Any, b: Any) -> Any:
    """The logarithm of that of answers under Phi(a + b x), without its constant."""
    return sum(k * MP.log(MP.ncdf(a + b * x)) + (n - k) * MP.log(MP.ncdf(-a - b * x)) for x, k, n in answers)


def best_probit(answers: Answers, b: Any = None) -> tuple[Any, Any]:
    """a and b of the largest likelihood, which is concave; a alone where b is given. NoConvergence where there is none."""
    a, slope = MP.mpf(0), MP.mpf(1) if b is None else b
    for _ in range(60):
        g, h = _slopes(answers, a, slope)
        step = MP.lu_solve(h, -g) if b is None else MP.matrix([-g[0] / h[0, 0], 0])
        size, before = MP.mpf(1), likelihood(answers, a, slope)
        while size > 1e-12 and likelihood(answers, a + size * step[0], slope + size * step[1]) < before:
            size /= 2
        a, slope = a + size * step[0], slope + size * step[1]
        if MP.norm(step) < MP.mpf(10) ** -20 * (1 + abs(a) + abs(slope)):
            return a, slope
        if abs(a) + abs(slope) > 1e6:
            break
    raise mpmath.libmp.NoConvergence("the answers are kept apart by a step")


def _slopes(answers: Answers, a: Any, b: Any) -> tuple[Any, Any]:
    """First and second derivatives by a and b."""
    g, h = MP.matrix(2, 1), MP.matrix(2, 2)
    for x, k, n in answers:
        z, x = a + b * x, MP.mpf(x)
        up, down = MP.npdf(z) / MP.ncdf(z), MP.npdf(z) / MP.ncdf(-z)
        first = k * up - (n - k) * down
        second = -k * up * (z + up) - (n - k) * down * (down - z)
        for i, u in enumerate((MP.mpf(1), x)):
            g[i] += first * u
            for j, v in enumerate((MP.mpf(1), x)):
                h[i, j] += second * u * v
    return g, h
