"""What symbolic formulas cost, against SymPy's own route, in one run.

    python benchmarks/formulas.py

A mass, a damper and a spring behind one, two and four second-order low-passes (device orders 2, 4 and 8), every parameter a
symbol. SymPy splits dH into real and imaginary part with ``as_real_imag`` and simplifies each, as its users do; it gets a minute,
and what it does not finish is reported as a lower bound. Order 8 of SymPy is left to that bound.
"""

from __future__ import annotations

import multiprocessing
import time

import sympy
from timing import machine, medians

import haptisym as hs
from haptisym.kernel.response import on_axis
from haptisym.model.chain import Chain
from haptisym.writing.mathtext import plain

LIMIT = 60.0
"""Seconds that SymPy gets."""


def cascade(count: int) -> Chain:
    """The chain of that many low-passes."""
    m, b, k = hs.symbols("m b k")
    filters = [hs.effects.second_order_lowpass(*hs.symbols(f"omega_{i} zeta_{i}")) for i in range(1, count + 1)]
    H = hs.environments.mass_spring_damper(m, b, k).H
    return Chain(H, H, tuple(f.matrix for f in filters))


def exact(count: int) -> object:
    """Re dH and Im dH as exact quotients of polynomials over a squared modulus."""
    chain = cascade(count)
    H = chain.ring.convert(chain.environment)
    G = chain.ring.one
    for matrix in chain.matrices:
        G = G * chain.ring.convert(matrix[0])
    response = on_axis(H * (G - chain.ring.one))
    return response.raw_real, response.raw_imag


def display(count: int) -> list[str]:
    """The formulas in named steps, written as text."""
    steps = cascade(count).steps
    return [f"{name} = {plain(value)}" for name, value in (*steps.definitions, *steps.results.items())]


def by_sympy(count: int) -> object:
    """The same with SymPy alone."""
    chain = cascade(count)
    s, omega = hs.s, hs.omega
    G = sympy.Mul(*(matrix[0] for matrix in chain.matrices))
    real, imag = (chain.environment * (G - 1)).subs(s, sympy.I * omega).as_real_imag()
    return sympy.simplify(real), sympy.simplify(imag)


def limited(count: int) -> float | None:
    """Seconds that SymPy takes; None beyond the limit."""
    worker = multiprocessing.Process(target=by_sympy, args=(count,))
    started = time.perf_counter()
    worker.start()
    worker.join(LIMIT)
    if worker.is_alive():
        worker.kill()
        worker.join()
        return None
    return time.perf_counter() - started


def main() -> None:
    """Print one table."""
    print(machine())
    print("\norder   exact closed forms   steps, as text   operations   SymPy as_real_imag + simplify")
    for count in (1, 2, 4):
        contenders = {"exact": lambda n=count: exact(n), "display": lambda n=count: display(n)}
        found = medians(contenders, 9 if count < 4 else 3)
        other = limited(count)
        said = (
            f"{other:8.2f} s  {other / found['exact']:8.0f} x"
            if other
            else f"> {LIMIT:.0f} s  > {LIMIT / found['exact']:.0f} x"
        )
        operations = cascade(count).steps.operations
        print(
            f"{2 * count:5d} {1000 * found['exact']:16.2f} ms {1000 * found['display']:13.2f} ms {operations:12d}   {said}"
        )


if __name__ == "__main__":
    main()
