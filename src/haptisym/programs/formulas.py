"""Rational formulas in omega, in floats."""

from __future__ import annotations

from typing import Any

import numpy as np
from sympy import Expr, Poly, fraction, together

from haptisym.kernel.symbols import omega


def floats_of(x: Expr, at: Any) -> Any:
    """A number, or a formula in omega at frequencies."""
    if not x.has(omega):
        return float(x)
    above, below = (np.array([float(c) for c in Poly(p, omega).all_coeffs()]) for p in fraction(together(x)))
    return np.polyval(above, at) / np.polyval(below, at)
