"""A chain as a row of links, each a program in complex s of its own, and the two arithmetics that
run them: power series over complex balls, and arrays of complex floats.

A link takes the perceived dynamics F and the change dH before an effect to those behind it: behind
a gain G these are F G and dH + F (G - 1). The formulas are those of ``programs.distortion``,
written in complex numbers instead of pairs of real ones. ``links`` makes the programs, ``InSteps``
runs one.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeAlias

import flint
from flint import acb, acb_series, arb
from sympy import Expr, I, Rational, Symbol

from haptisym.kernel.arrays import np
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.rings import Polynomial, RationalFunction, s
from haptisym.programs.balls import constant_ball
from haptisym.programs.distortion import Author, less_one, runs
from haptisym.programs.program import Program, Writer, phi

FELT, CHANGE = Symbol("felt"), Symbol("change")


@dataclass(frozen=True, eq=False)
class Links:
    """``start`` : from s to H_env, what is rendered ("felt") and their difference ("change");
    ``effects`` : both behind each."""

    start: Program
    effects: tuple[Program, ...]


def links(environment: Expr, rendered: Expr, matrices: Sequence[Sequence[Expr]]) -> Links:
    """The links of a chain whose parameters are numbers, effects nearest the environment first."""
    return Links(_start(environment, rendered), tuple(_effect(matrix) for matrix in matrices))


def _start(environment: Expr, rendered: Expr) -> Program:
    """The program of H_env, of what is rendered, and of their difference."""
    author = _InS(Writer((s,)))
    # Subtracted as fractions, so that what both have in common cancels exactly.
    ring = Ring.of([rendered, environment])
    change: Any = author.closed((ring.convert(rendered) - ring.convert(environment)).reduced(), "")
    H: Any = author.sum_of_fractions(environment, "")
    felt: Any = author.sum_of_fractions(rendered, "")
    return author.write.program({"environment": H, "felt": felt, "change": change})


def _effect(matrix: Sequence[Expr]) -> Program:
    """The program of one effect: from s, felt and change before it to both behind it."""
    author = _InS(Writer((s, FELT, CHANGE)))
    felt: Any = author.write.input(FELT)
    change: Any = author.write.input(CHANGE)
    ring = Ring.of(matrix)
    [run] = runs([[ring.convert(x) for x in matrix]])
    felt, change = author.after(run, felt, change, [""])
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
    """Numerator, denominator and what their variables mean: phi for the delays, 1 - s lag phi,
    where f is 0/0 at s = 0."""
    ring, both = f.ring, (f.numerator, f.denominator)
    assert isinstance(ring, Ring)
    if not ring.lags or f.is_zero or not all(ring.at_0(x).is_zero() for x in both):
        return *both, ring.meanings
    # exp(-s lag) = 1 - s lag phi(s lag): written so, numerator and denominator show their common
    # power of s, which is divided out, and phi is finite at 0.
    generators, meanings = list(ring.context.gens()), list(ring.meanings)
    for i, lag in enumerate(ring.lags, ring.size):
        time = ring.convert(lag)
        whole = generators[0] * generators[i] * time.numerator
        generators[i] = 1 - whole / time.denominator.leading_coefficient()
        meanings[i] = phi(s * lag)
    above, below = (x.compose(*generators) for x in both)
    orders = [int(exponents[0]) for x in (above, below) for exponents in x.monoms()]
    common = ring.variable ** min(orders)
    return above / common, below / common, meanings


Series: TypeAlias = Any  # flint's acb_series and arb_series, which ship no types

_BITS, _LONGEST = 96, 64  # of series: precision of their coefficients, and their greatest length


@contextmanager
def series_arithmetic() -> Iterator[None]:
    """The precision and length of series that are computed inside; what was set before is
    restored."""
    longest = flint.ctx.cap
    with flint.ctx.workprec(_BITS):
        flint.ctx.cap = _LONGEST
        try:
            yield
        finally:
            flint.ctx.cap = longest


def along_axis(x: Any, terms: int) -> Series:
    """s = j omega as a series in the distance from the frequency x, or from each in a ball x."""
    return acb_series([acb(0, x), acb(0, 1)], prec=terms)


def divided(above: Series, below: Series) -> Series:
    """The quotient, not a number where the denominator may vanish."""
    # flint raises an error for a series whose constant term may be 0; not-a-number says that
    # nothing is known, and is carried through all further steps.
    if isinstance(below, acb_series):
        if below[0].contains(0):
            return acb_series([acb(arb.nan(), arb.nan())] * below.prec, prec=below.prec)
        if not isinstance(above, acb_series):
            above = acb_series([above], prec=below.prec)
        return above / below
    return above / below if isinstance(above, acb) else above * (1 / below)


def _phi(x: Series) -> Series:
    """(1 - exp(-x))/x: near 0 as the mean of exp(-x u) for u from 0 to 1, so is each derivative,
    times (-u)^k."""
    z = x[0]
    if not z.contains(0):
        return divided(1 - (-x).exp(), x)
    # The rectangle around -z and 0 holds -z u for all u from 0 to 1, so its exponential holds all
    # exp(-z u). The k-th derivative is their mean with the weights (-u)^k, which add to
    # (-1)^k/(k + 1); divided by k! it is the coefficient.
    mean, factor, coefficients = (-z).union(acb(0)).exp(), acb(1), []
    for k in range(x.prec):
        factor = factor / (k + 1)
        coefficients.append(mean * factor * (-1) ** k)
    moved = x - z
    total = acb_series([0], prec=x.prec)
    for c in reversed(coefficients):
        total = total * moved + c
    return total


def _complex(value: Any) -> Any:
    return acb(0, 1) if value == I else acb(constant_ball(value))


_COMMON: dict[str, Callable[..., Any]] = {
    "add": operator.add,
    "sub": operator.sub,
    "mul": operator.mul,
    "neg": operator.neg,
}
BALL_SERIES: Mapping[str, Callable[..., Any]] = {
    **_COMMON,
    "constant": _complex,
    "div": divided,
    "exp": lambda x: x.exp(),
    "phi": _phi,
    "power": lambda x, order: (x.log() * order).exp(),
}
FLOATS: Mapping[str, Callable[..., Any]] = {
    **_COMMON,
    "constant": lambda value: complex(_complex(value)),
    "div": operator.truediv,
    "exp": lambda x: np.exp(x),
    "phi": lambda x: -np.expm1(-x) / x,
    "power": lambda x, order: x**order,
}


_Step: TypeAlias = tuple[int, Callable[..., Any] | None, tuple[int, ...]]
"""A step of a program: its index, the function that computes it (None for an input), and the
indices of its arguments."""


@dataclass(frozen=True, eq=False)
class InSteps:
    """A program whose first input is s: what needs s alone is computed once, and then what needs
    the other inputs."""

    program: Program
    operations: Mapping[str, Callable[..., Any]]

    def known(self, s: Any) -> list[Any]:
        """The values of all steps that depend on s alone, None for the others."""
        values = list(self._constants)
        for i, f, arguments in self._steps[0]:
            values[i] = s if f is None else f(*[values[x] for x in arguments])
        return values

    def results(self, known: Sequence[Any], inputs: Sequence[Any] = ()) -> tuple[Any, ...]:
        """The results in order, for inputs after s."""
        values = list(known)
        for i, f, arguments in self._steps[1]:
            if f is None:
                values[i] = inputs[arguments[0] - 1]
            else:
                values[i] = f(*[values[x] for x in arguments])
        return tuple([values[x] for x in self.program.results.values()])

    @cached_property
    def _constants(self) -> list[Any]:
        """The constants at their places, None elsewhere; at the precision of the first use, which
        all others share."""
        constant = self.operations["constant"]
        return [
            constant(x.value) if x.name == "constant" else None for x in self.program.operations
        ]

    @cached_property
    def _steps(self) -> tuple[list[_Step], list[_Step]]:
        """The steps that depend on s alone, and the others, both in order."""
        first: list[_Step] = []
        later: list[_Step] = []
        of_s: set[int] = set()
        for i, step in enumerate(self.program.operations):
            if step.name == "constant":
                of_s.add(i)
                continue
            row = i, self.operations.get(step.name), step.arguments
            needs_s_alone = of_s.issuperset(step.arguments)
            if step.name == "input":
                needs_s_alone = step.arguments[0] == 0
            if needs_s_alone:
                of_s.add(i)
                first.append(row)
            else:
                later.append(row)
        return first, later
