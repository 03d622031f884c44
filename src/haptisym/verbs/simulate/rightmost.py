"""The rightmost pole of a dynamics with delays, found numerically: for a message, not for a decision."""

from __future__ import annotations

import warnings

import numpy as np
from sympy import lambdify

from haptisym.kernel.rings import RationalFunction
from haptisym.kernel.symbols import s


def rightmost_pole(dynamics: RationalFunction) -> complex | None:
    """The pole with the largest real part that Newton's method finds from a grid of starts; None if it finds none.

    >>> from sympy import exp
    >>> from haptisym.kernel.dynamics import Ring
    >>> pole = rightmost_pole(Ring.of([exp(-s)]).convert(1 / (s + 2 * exp(-s))).reduced())
    >>> round(pole.real, 4), round(abs(pole.imag), 4)
    (0.1728, 1.6737)
    """
    from scipy.optimize import newton  # SciPy is an extra: asked for where it is needed

    denominator = dynamics.ring.expression(dynamics.denominator)
    value = lambdify(s, denominator, "numpy")
    found: list[complex] = []
    scales = np.concatenate([[0.0], np.geomspace(0.1, 1e3, 33)])
    starts = (complex(real, imag) for imag in scales for real in (0.1, 1.0, 10.0))
    for start in starts:
        try:
            with warnings.catch_warnings(), np.errstate(all="ignore"):
                warnings.simplefilter("ignore")
                root = complex(newton(value, start, maxiter=60, tol=1e-12))
        except (RuntimeError, OverflowError):
            continue
        # Newton's method also stops where it cannot go on
        if np.isfinite(root) and abs(root) > 1e-9 and abs(value(root)) < 1e-9 * abs(value(start)):
            found.append(root)
    return max(found, key=lambda root: root.real, default=None)
