"""sin x/x in floats, to within some roundings."""

from __future__ import annotations

from collections.abc import Sequence
from math import factorial, prod
from typing import Any

import numpy as np

from haptisym.programs.program import LAST, SMALL

_TERMS = [(-1.0) ** k / factorial(2 * k + 1) for k in range(LAST // 2 + 1)]
"""Of sin x/x, by powers of x^2."""
_NEAR = 1.5
_SLOPES = [[c * prod(range(2 * k - n + 1, 2 * k + 1)) for k, c in enumerate(_TERMS) if 2 * k >= n] for n in range(4)]
"""The same and three derivatives, those of odd order over x."""


def sinc(x: Any, out: Any = None) -> Any:
    """sin(x)/x, and 1 at 0."""
    return _put(np.where(x == 0, 1.0, np.sin(x) / x), out)


def sincm1(x: Any, out: Any = None) -> Any:
    """sin(x)/x - 1, by its series while it is small."""
    size = np.abs(x)
    square, far = np.minimum(size, SMALL) ** 2, np.maximum(size, SMALL)
    return _put(np.where(size <= SMALL, _horner(_TERMS[1:], square) * square, np.sin(far) / far - 1.0), out)


def sinc_and_slopes(x: Any) -> tuple[Any, ...]:
    """sin x/x and three derivatives: near 0 by their series, else by x f'' + 2 f' + x f = 0."""
    near = [_horner(terms, x * x) * (x if n % 2 else 1.0) for n, terms in enumerate(_SLOPES)]
    far = np.where(np.abs(x) < _NEAR, _NEAR, x)
    f = np.sin(far) / far
    df = (np.cos(far) - f) / far
    d2f = -f - 2 * df / far
    d3f = -df - (3 * d2f + f) / far
    return tuple(np.where(np.abs(x) < _NEAR, p, y) for p, y in zip(near, (f, df, d2f, d3f), strict=True))


def _horner(row: Sequence[float], x: Any) -> Any:
    found = np.full_like(x, row[-1])
    for c in row[-2::-1]:
        found *= x
        found += c
    return found


def _put(found: Any, out: Any) -> Any:
    if out is None:
        return found
    out[...] = found
    return out
