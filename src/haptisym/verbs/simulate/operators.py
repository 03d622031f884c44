"""Dynamics as equations: a rational function of s, powers of s and delays between signals of a network."""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from typing import Any

from sympy import Expr, I, exp

from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import SceneError
from haptisym.kernel.rings import Polynomial
from haptisym.verbs.simulate.network import Exact, Network, SignalSum, exact


def quotient(net: Network, formula: Expr, x: SignalSum, y: SignalSum) -> None:
    """y = (numerator/denominator) x as a differential equation: denominator(d/dt) y = numerator(d/dt) x."""
    combined(net, [formula], [x], y)


def combined(net: Network, formulas: Sequence[Expr], signals: Sequence[SignalSum], y: SignalSum) -> None:
    """y = G_1 x_1 + G_2 x_2 + ... over one denominator: what the formulas share is one motion in time, not several."""
    ring = Ring.of(formulas)
    quotients = [ring.convert(formula).reduced() for formula in formulas]
    common = reduce(_least_multiple, (q.denominator for q in quotients))
    total = SignalSum({})
    for q, x in zip(quotients, signals, strict=True):
        total = total + operator(net, q.numerator * (common // q.denominator), ring, x)
    net.equal(operator(net, common, ring, y), total)


def _least_multiple(one: Polynomial, other: Polynomial) -> Polynomial:
    return one * (other // one.gcd(other))


def operator(net: Network, polynomial: Polynomial, ring: Ring, x: SignalSum) -> SignalSum:
    """A polynomial in s, delays and powers s^alpha, applied to a signal."""
    total = SignalSum({})
    powers: dict[tuple[Any, int], SignalSum] = {}
    for exponents, coefficient in polynomial.to_dict().items():
        term = x
        factor = coefficient
        for meaning, n in zip(ring.meanings[1:], map(int, exponents[1:]), strict=True):
            if n and (meaning == I or meaning.free_symbols - {ring.meanings[0]}):
                raise SceneError(f"{meaning} has no meaning in time: this formula cannot be simulated")
            if isinstance(meaning, exp):
                term = term.late(n * exact(-meaning.args[0].coeff(ring.meanings[0])))
            elif n and meaning.is_number:
                factor = factor * exact(meaning) ** n
            elif n:
                term = _powers(net, powers, term, exact(meaning.exp), n)
        total = total + factor * term.d(int(exponents[0]))
    return total


def _powers(net: Network, made: dict[tuple[Any, int], SignalSum], x: SignalSum, alpha: Exact, times: int) -> SignalSum:
    """The derivative of order alpha, taken that many times; each is built once."""
    for n in range(1, times + 1):
        key = ((tuple(x.terms), alpha), n)
        if key not in made:
            made[key] = fractional(net, x, alpha)
        x = made[key]
    return x


def fractional(net: Network, x: SignalSum, alpha: Exact) -> SignalSum:
    """The derivative of an order that is not whole."""
    from haptisym.verbs.simulate.fractional import derivative  # only scenes with a power of s that is not whole need it

    return derivative(net, x, alpha)
