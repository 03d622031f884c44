"""What Im H_perc is made of: terms of numerator and denominator, and their parts over cells by powers of omega."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from math import inf, nextafter
from typing import TypeAlias

import flint
import numpy as np
from sympy import Expr, Integer, Rational, pi

from haptisym.kernel.dynamics import Ring
from haptisym.kernel.monomials import monomials
from haptisym.kernel.reals import expression_ball
from haptisym.kernel.rings import Polynomial
from haptisym.programs.taylormodels import Array, Model, between, floated, variable

Span: TypeAlias = tuple[float, float]
Parts: TypeAlias = dict[Expr, list[Model | None]]
"""By powers of omega real and imaginary part; None for 0."""
_BITS = 160
_QUARTERS = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))


@dataclass(frozen=True)
class Term:
    """number(q) s^power exp(-s lag(q))."""

    power: Expr
    lag: Expr
    number: Expr

    @property
    def turned(self) -> tuple[float, float]:
        """Cosine and sine of a quarter turn for each power."""
        if isinstance(self.power, Integer):
            return _QUARTERS[int(self.power) % 4]
        with flint.ctx.workprec(
            _BITS
        ):  # near an odd power a cosine in floats loses digits, which Model.times takes for known
            half = expression_ball(self.power) / 2
            return float(half.cos_pi()), float(half.sin_pi())


def terms_in(ring: Ring, polynomial: Polynomial) -> list[Term]:
    """A polynomial as terms, of each power and delay one."""
    found: dict[tuple[Expr, Expr], Expr] = {}
    first, last = ring.size, ring.size + len(ring.lags)
    for exponents, value in monomials(polynomial):
        own = [int(n) for n in exponents]
        number = Rational(int(value.p), int(value.q)) * pi ** own[1]
        for symbol, n in zip(ring.symbols, own[2:first], strict=True):
            number *= symbol**n
        lag = sum((n * x for n, x in zip(own[first:last], ring.lags, strict=True)), Integer(0))
        more = sum((n * x for n, x in zip(own[last:], ring.orders, strict=False)), Integer(0))
        place = own[0] + more, lag
        found[place] = found.get(place, Integer(0)) + number
    return [Term(*place, number) for place, number in found.items()]


Turned: TypeAlias = tuple[Expr, Expr, Expr | None]
"""A power of omega, by how many quarters it is turned, and what stands before it; None: not known."""


def beginnings(row: Sequence[Term]) -> Iterator[Turned]:
    """Of each term what is left with delays as 1 - s lag."""
    for x in row:
        yield x.power, x.power, x.number
        if x.lag != 0:
            yield x.power + 1, x.power - 1, x.number * x.lag


def endings(row: Sequence[Term]) -> Iterator[Turned]:
    """The terms, of which those that come late turn on and on."""
    for x in row:
        yield x.power, x.power, x.number if x.lag == 0 else None


def paired(above: Iterable[Turned], below: Iterable[Turned]) -> tuple[dict[Expr, Expr], list[Expr]]:
    """Im of above times the conjugate of below, by powers of omega, but what cancels; and powers of which it is not known."""
    found, unknown = dict[Expr, Expr](), list[Expr]()
    for (p, a, x), (n, b, y) in product(above, below):
        if x is None or y is None or not isinstance(a - b, Integer):
            unknown.append(p + n)
        else:
            found[p + n] = found.get(p + n, Integer(0)) + (0, 1, 0, -1)[int(a - b) % 4] * x * y
    return {p: form for p, x in found.items() if (form := x.expand()) != 0}, unknown


def add_to(found: Parts, power: Expr, model: Model, C: float, S: float) -> None:
    """Add a model times C to the real part of what stands at a power of omega, and times S to the imaginary part."""
    pair = found.setdefault(power, [None, None])
    for i, factor in enumerate((C, S)):
        if factor:
            more, known = model.times(factor), pair[i]
            pair[i] = more if known is None else known + more


def imaginary(above: Parts, below: Parts) -> dict[Expr, Model]:
    """Of above times the conjugate of below."""
    found: dict[Expr, Model] = {}

    def add(power: Expr, x: Model | None, y: Model | None, sign: float) -> None:
        if x is not None and y is not None:
            more = (x * y).times(sign)
            found[power] = found[power] + more if power in found else more

    for p, (a, b) in above.items():
        for n, (c, d) in below.items():
            add(p + n, b, c, 1.0)
            add(p + n, a, d, -1.0)
    return found


def powered(omega: Model, p: Expr) -> Model:
    """omega^p, for p >= 0."""
    if not isinstance(p, Integer):
        return omega.to_the(omega.number(floated(p)))
    found = omega.number(1.0)
    for _ in range(int(p)):
        found = found * omega
    return found


def bent_sinc(angle: Model) -> Model:
    """(sinc x - 1)/x^2, which lies between -1/6 and -1/6 + x^2/120."""
    most = np.abs(np.stack(angle.bounds()))[:, :, 0].max(0)
    low = np.full(len(most), -1 / 6 * (1 + 1e-12))
    return between(low, np.maximum(low, -1 / 6 + most**2 / 120 + 1e-12), angle)


def variables(cells: Array) -> tuple[Model, Model]:
    """Frequency and parameter, over cells of their values."""
    found = []
    for i in (0, 1):
        low, high = cells[:, i].T
        size = np.maximum(-low, high)
        with np.errstate(all="ignore"):  # what is not finite is unknown
            found.append(variable((low + high) / 2, (high - low) / 2, size, i, 2, slopes=0))
    return found[0], found[1]


def ends_of(model: Model) -> tuple[float, float]:
    """The least and the largest that a model is in any of its cells."""
    low, high = model.bounds()
    return float(low.min()), float(high.max())


def span(low: Rational, high: Rational) -> Span:
    """The ends as floats, rounded outward."""
    a, b = float(low), float(high)
    return a if Rational(a) <= low else nextafter(a, -inf), b if Rational(b) >= high else nextafter(b, inf)
