"""How long formulas are, and what they cost, against the usual ways, in one run.

    python benchmarks/formulas.py [most]

A mass, a damper and a spring behind 1, 2, ..., 12 lags, then behind compliances and shunts, every parameter a symbol. Each way
makes Re dH and Im dH; told are
operations of both (SymPy's ``count_ops``) and, in brackets, milliseconds of processor time; each gets ten seconds. "plain" is
``as_real_imag``, which from two lags on leaves re(1/(...)) and im(1/(...)) in its answer: it is no closed form there. Lcapy and
symengine stand where they are installed; symengine has no real part of symbols, so that its number is that of the numerator times
the conjugate denominator, multiplied out.
"""

from __future__ import annotations

import multiprocessing
import sys
import time
from collections.abc import Callable
from importlib.util import find_spec
from typing import Any, TypeAlias

import sympy
from timing import machine

import haptisym as hs

LIMIT = 10.0
"""Seconds that each way gets."""
M, B, K = hs.symbols("m b k")


def compliance(i: int) -> hs.Effect:
    return hs.effects.compliance(*sympy.symbols(f"k_{i} b_{i}", positive=True))


def shunt(i: int) -> hs.Effect:
    return hs.effects.shunt(*sympy.symbols(f"m_{i} b_{i}", positive=True))


CHAINS: dict[str, tuple[hs.Effect, ...]] = {
    "compliance": (compliance(1),),
    "compliance, shunt": (compliance(1), shunt(2)),
    "two compliances": (compliance(1), compliance(2)),
}
Count: TypeAlias = int | str
"""How many lags, or which of the chains."""


def effects(count: Count) -> tuple[hs.Effect, ...]:
    return CHAINS[count] if isinstance(count, str) else tuple(map(hs.effects.first_order_lag, lags(count)))


def lags(count: int) -> list[sympy.Symbol]:
    return [sympy.Symbol(f"w_{i}", positive=True) for i in range(1, count + 1)]


def change(count: Count) -> sympy.Expr:
    """DH at s = j omega, as a person writes it down."""
    environment = M * hs.s**2 + B * hs.s + K
    H = environment
    for effect in effects(count):
        a, b, c, d = effect.matrix
        H = (a * H + b) / (c * H + d)
    return (H - environment).subs(hs.s, sympy.I * hs.omega)


def distortion(count: Count) -> hs.Distortion:
    return hs.distort(hs.environments.mass_spring_damper(M, B, K), *effects(count))


def by_plain(count: Count) -> tuple[sympy.Expr, ...]:
    return tuple(change(count).as_real_imag())


def by_cancel(count: Count) -> tuple[sympy.Expr, ...]:
    return tuple(map(sympy.cancel, by_plain(count)))


def by_simplify(count: Count) -> tuple[sympy.Expr, ...]:
    return tuple(map(sympy.simplify, by_plain(count)))


def by_lcapy(count: int) -> tuple[sympy.Expr, ...]:
    import lcapy

    G = "*".join(f"w_{i}/(s + w_{i})" for i in range(1, count + 1))
    response = lcapy.expr(f"(m*s**2 + b*s + k)*({G} - 1)", positive=True)(lcapy.jw)
    return response.real.sympy, response.imag.sympy


def by_symengine(count: int) -> tuple[sympy.Expr, ...]:
    import symengine

    names = [w.name for w in lags(count)]
    m, b, k, omega, *each = symengine.symbols(" ".join(["m b k omega", *names]))
    j = symengine.I * omega
    above, below, other = m * j**2 + b * j + k, symengine.Integer(1), symengine.Integer(1)
    for w in each:
        below, other = below * (w + j), other * (w - j)
    product = symengine.expand(above * (symengine.Mul(*each) - below) * other)
    parts: tuple[list[Any], list[Any]] = ([], [])
    for term in product.args:
        turned = symengine.expand(term / symengine.I)
        (parts[0] if turned.has(symengine.I) or "I" in str(turned) else parts[1]).append(term)
    size = symengine.Mul(*(omega**2 + w**2 for w in each))
    return tuple(sympy.sympify(symengine.Add(*x) / size) for x in parts)


def by_haptisym(count: Count) -> tuple[sympy.Expr, ...]:
    d = distortion(count)
    return d.real, d.imag


def by_steps(count: Count) -> int:
    return distortion(count).steps().operations


WAYS: dict[str, Callable[[int], Any]] = {
    "plain": by_plain, "cancel": by_cancel, "simplify": by_simplify, "Lcapy": by_lcapy, "symengine": by_symengine,
    "d.real, d.imag": by_haptisym, "d.steps()": by_steps,
}  # fmt: skip
NEEDED = {"Lcapy": "lcapy", "symengine": "symengine"}


def measured(way: str, count: Count, queue: Any) -> None:
    WAYS[way](1)  # imports are not timed
    sympy.core.cache.clear_cache()
    started = time.process_time()
    found = WAYS[way](count)
    seconds = time.process_time() - started
    queue.put((found if isinstance(found, int) else sum(int(x.count_ops()) for x in found), seconds))


def limited(way: str, count: Count) -> tuple[int, float] | None:
    """Operations and seconds; None beyond the limit."""
    queue: Any = multiprocessing.Queue()
    worker = multiprocessing.Process(target=measured, args=(way, count, queue))
    worker.start()
    worker.join(LIMIT)
    if worker.is_alive() or queue.empty():
        worker.kill()
        worker.join()
        return None
    return queue.get()


def main(most: int) -> None:
    """Print one table: operations, and milliseconds in brackets."""
    print(machine())
    ways = [x for x in WAYS if x not in NEEDED or find_spec(NEEDED[x])]
    print(f"\n{'lags':<18}" + "".join(f"{x:>20}" for x in ways))
    over: set[str] = set()
    counts: list[Count] = [*range(1, most + 1), *CHAINS]
    for count in counts:
        cells = []
        for way in ways:
            lagged = isinstance(count, int)
            if way in (over if lagged else NEEDED):
                cells.append("> 10 s" if lagged else "-")
                continue
            found = limited(way, count)
            over |= {way} if lagged and not found else set()
            cells.append(f"{found[0]} ({1000 * found[1]:.0f})" if found else "> 10 s")
        print(f"{count:<18}" + "".join(f"{x:>20}" for x in cells), flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 12)
