"""The truth for compiled functions: the chain matrices themselves in complex ball arithmetic, at 1000 bits.

Nothing here knows the closed forms: the entries of the matrices are evaluated at s = j omega as they stand in the catalogue,
multiplied, and H_perc - H_env is a difference of balls.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import flint
import numpy as np
from flint import acb, arb, fmpq
from sympy import Add, Expr, I, Integer, Mul, Pow, Rational, Symbol, cosh, exp, pi, sinh

from haptisym.kernel.rings import s
from haptisym.model.chain import Chain

BITS = 1000


def complex_ball(e: Expr, known: Mapping[Symbol, Any]) -> Any:
    if e in known:
        return known[e]
    if isinstance(e, Rational):
        return acb(arb(fmpq(int(e.p), int(e.q))))
    if e in (pi, I):
        return acb.pi() if e == pi else acb(0, 1)
    if isinstance(e, Add | Mul):
        total, *others = (complex_ball(x, known) for x in e.args)
        for x in others:
            total = total + x if isinstance(e, Add) else total * x
        return total
    if isinstance(e, Pow) and isinstance(e.exp, Integer):
        whole = complex_ball(e.base, known) ** abs(int(e.exp))
        return whole if e.exp > 0 else 1 / whole
    if isinstance(e, Pow):
        return (complex_ball(e.base, known).log() * complex_ball(e.exp, known)).exp()
    for kind, function in ((exp, acb.exp), (cosh, acb.cosh), (sinh, acb.sinh)):
        if isinstance(e, kind):
            return function(complex_ball(e.args[0], known))
    if e.func.__name__ in _HARMONICS:
        return acb(_HARMONICS[e.func.__name__](complex_ball(e.args[0], known).real))
    raise AssertionError(e)


def _limited(u: Any) -> Any:
    """2/pi (asin u + u sqrt(1 - u^2)) within a limit, and 1 or -1 beyond it."""
    if not abs(u) < 1:
        return u.sgn()
    return 2 * (u.asin() + u * (1 - u * u).sqrt()) / arb.pi()


def _stairs(u: Any) -> Any:
    """8 u/pi times the sum of the roots of 1 - (i u)^2 over odd i, as long as these are positive."""
    roots, i = [], 1
    while i * u < 1:
        roots.append((1 - (i * u) ** 2).sqrt())
        i += 2
    return 8 * u / arb.pi() * sum(roots, arb(0))


_HARMONICS: Mapping[str, Callable[[Any], Any]] = {
    "quantiser": _stairs,
    "limiter": _limited,
    "deadband": lambda u: 1 - _limited(u),
    "following": lambda u: (1 + _limited(u)) / 2,
    "lagging": lambda u: (u * u - 1) / arb.pi() if u > -1 else arb(0),
}


def truth(chain: Chain, omega: float, values: Mapping[str, float], bits: int = BITS) -> dict[str, Any]:
    """Balls around the fields of ``Values``; omega and the values are the doubles that they are."""
    with flint.ctx.workprec(bits):
        known: dict[Any, Any] = {
            x: acb(values[x.name]) for x in (*chain.ring.symbols, *chain.parameters) if x.name in values
        }
        known[s] = acb(0, arb(omega))
        H = complex_ball(chain.environment, known)
        F, X = complex_ball(chain.rendered, known), acb(1)
        for matrix in chain.matrices:
            A, B, C, D = (complex_ball(Integer(x) if isinstance(x, int) else x, known) for x in matrix)
            F, X = A * F + B * X, C * F + D * X
        G = F / X
        d = G - H
        size, relative = abs(H), d / H
        return {
            "real": d.real, "imag": d.imag, "ratio_real": abs(d.real) / size, "ratio_imag": abs(d.imag) / size,
            "relative_real": relative.real, "relative_imag": relative.imag, "environment_real": H.real,
            "environment_imag": H.imag, "perceived_real": G.real, "perceived_imag": G.imag,
        }  # fmt: skip


def error_in_ulps(found: float, true: Any, bits: int = BITS) -> float:
    """The largest distance of a double from any number of a ball, in units of the double's last place; overflow counts as 0."""
    with flint.ctx.workprec(bits):
        if np.isinf(found):
            return 0.0 if abs(true) > arb(2) ** 1024 - arb(2) ** 970 else np.inf
        return float(abs(true - arb(found)).upper() / arb(float(np.spacing(abs(found)))))
