"""A chain in links, each a program in s of its own: what is felt behind an effect from what is felt before it.

The formulas are those of ``stable``, in complex numbers: felt G and dH + felt (G - 1) behind a gain, and so on.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from sympy import Expr, Rational, Symbol

from haptisym.kernel.dynamics import Ring
from haptisym.kernel.rings import Polynomial, RationalFunction, s
from haptisym.programs.program import Program, Writer, phi
from haptisym.programs.stable import Author, less_one, runs

FELT, CHANGE = Symbol("felt"), Symbol("change")


@dataclass(frozen=True, eq=False)
class Links:
    """``start`` : from s to H_env, what is rendered ("felt") and their difference ("change"); ``effects`` : both behind each."""

    start: Program
    effects: tuple[Program, ...]


def links(environment: Expr, rendered: Expr, matrices: Sequence[Sequence[Expr]]) -> Links:
    """The links of a chain whose parameters are numbers, effects nearest the environment first."""
    return Links(_start(environment, rendered), tuple(_effect(matrix) for matrix in matrices))


def _start(environment: Expr, rendered: Expr) -> Program:
    author = _InS(Writer((s,)))
    ring = Ring.of([rendered, environment])
    change: Any = author.closed((ring.convert(rendered) - ring.convert(environment)).reduced(), "")
    H: Any = author.sum_of_fractions(environment, "")
    felt: Any = author.sum_of_fractions(rendered, "")
    return author.write.program({"environment": H, "felt": felt, "change": change})


def _effect(matrix: Sequence[Expr]) -> Program:
    author = _InS(Writer((s, FELT, CHANGE)))
    before: tuple[Any, Any] = author.write.input(FELT), author.write.input(CHANGE)
    [run] = runs([list(map(Ring.of(matrix).convert, matrix))])
    after: tuple[Any, Any] = author.after(run, *before, [""])
    felt, change = after
    return author.write.program({"felt": felt, "change": change})


class _InS(Author):
    """Writes dynamics as steps in s: a complex number is one step."""

    def pair(self, real: int | Rational, imag: int) -> Any:
        return self.write.expression(Rational(real))

    def plus(self, x: Any, y: Any) -> Any:
        return self.write.add(x, y)

    def minus(self, x: Any, y: Any) -> Any:
        return self.write.sub(x, y)

    def times(self, x: Any, y: Any) -> Any:
        return self.write.mul(x, y)

    def named(self, letters: str, pair: Any, label: str = "") -> Any:
        return pair

    def division(self, below: Any, label: str) -> Callable[[Any], Any]:
        return lambda above: self.write.div(above, below)

    def factor(self, f: RationalFunction) -> Any:
        return self.closed(f, "")

    def series(self, gains: Sequence[RationalFunction], labels: Sequence[str]) -> Any:
        [gain] = gains
        return self.closed(gain, ""), self.closed(less_one(gain), "")

    def closed(self, f: RationalFunction, label: str) -> Any:
        f = f.cleared()
        above, below, meanings = _smooth(f)
        return self.write.div(*(self.write.polynomial(f.ring, x, meanings) for x in (above, below)))


def _smooth(f: RationalFunction) -> tuple[Polynomial, Polynomial, Sequence[Expr]]:
    """Numerator, denominator and what their variables mean: phi for the delays, 1 - s lag phi, where f is 0/0 at s = 0."""
    ring, both = f.ring, (f.numerator, f.denominator)
    assert isinstance(ring, Ring)
    if not ring.lags or f.is_zero or not all(ring.at_0(x).is_zero() for x in both):
        return *both, ring.meanings
    gens, meanings = list(ring.context.gens()), list(ring.meanings)
    for i, lag in enumerate(ring.lags, ring.size):
        time = ring.convert(lag)
        gens[i] = 1 - gens[0] * gens[i] * time.numerator / time.denominator.leading_coefficient()
        meanings[i] = phi(s * lag)
    above, below = (x.compose(*gens) for x in both)
    common = ring.variable ** min(int(e[0]) for x in (above, below) for e in x.monoms())
    return above / common, below / common, meanings
