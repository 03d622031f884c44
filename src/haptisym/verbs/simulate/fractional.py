"""The derivative of fractional order in time, as a bank of first-order relaxations: no history to carry along.

From s^(alpha-1) = sin(pi alpha)/pi * integral of lambda^(alpha-1)/(s + lambda) over lambda > 0: with lambda = e^y the integrand
is analytic in a strip, so that the trapezoidal rule converges exponentially (relative error about exp(-pi^2/step) on the
imaginary axis). What lies below the slowest and beyond the fastest relaxation is a spring and a damper, whose strengths are
geometric series and therefore known exactly.
"""

from __future__ import annotations

from math import ceil, exp, floor, log, pi, sin

import numpy as np
from flint import fmpq

from haptisym.programs.values import Array
from haptisym.verbs.simulate.network import Exact, Network, SignalSum

_STEP = 0.4  # in ln(lambda): exp(-pi^2/0.4) is 2e-11
_ACCURACY = 1e-9  # of the two ends


def rates_and_weights(alpha: float, span: tuple[float, float]) -> tuple[list[float], list[float], float, float]:
    """Rates, 1/s, and weights of the bank, and the spring and the damper that stand for the rest.

    s^alpha is about spring + damper s + sum of weight s/(s + rate), for frequencies of ``span``, rad/s.

    >>> rates, weights, spring, damper = rates_and_weights(0.5, (1.0, 10.0))
    >>> value = spring + damper * 3j + sum(w * 3j / (3j + r) for r, w in zip(rates, weights))
    >>> abs(value / 3j**0.5 - 1) < 1e-8
    True
    """
    slowest = span[0] * _ACCURACY ** (1 / (1 + alpha))
    fastest = span[1] * _ACCURACY ** (-1 / (2 - alpha))
    first, last = floor(log(slowest) / _STEP), ceil(log(fastest) / _STEP)
    scale = _STEP * sin(pi * alpha) / pi
    rates = [exp(_STEP * n) for n in range(first, last + 1)]
    weights = [scale * rate**alpha for rate in rates]
    spring = scale * rates[0] ** alpha / (exp(_STEP * alpha) - 1)
    damper = scale * rates[-1] ** (alpha - 1) / (exp(_STEP * (1 - alpha)) - 1)
    return rates, weights, spring, damper


def derivative(net: Network, x: SignalSum, alpha: Exact) -> SignalSum:
    """A signal that is the derivative of order alpha, 0 < alpha < 1, of a sum."""
    order = int(alpha.p) / int(alpha.q)
    net.fractional.append((order, *net.span))
    rates, weights, spring, damper = rates_and_weights(order, net.span)
    total = x.through(_rational(spring), _rational(damper))
    for rate, weight in zip(rates, weights, strict=True):
        lagging = net.signal("relaxation")
        net.equal(lagging.d(), _rational(rate) * (x - lagging))
        total = total + _rational(weight) * (x - lagging)
    result = net.signal("fractional")
    net.equal(result, total)
    return result


def _rational(number: float) -> Exact:
    return fmpq(*number.as_integer_ratio())


def bank_error(alpha: float, span: tuple[float, float], omegas: Array) -> float:
    """The largest relative deviation of the bank from (j omega)^alpha at given frequencies, rad/s."""
    rates, weights, spring, damper = rates_and_weights(alpha, span)
    s = 1j * np.asarray(omegas)[:, None]
    value = spring + damper * s[:, 0] + (np.array(weights) * s / (s + np.array(rates))).sum(axis=1)
    return float(np.abs(value / s[:, 0] ** alpha - 1).max())
