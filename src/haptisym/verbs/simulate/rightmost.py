"""The rightmost root of a characteristic function with delays and powers of s: found by Newton's method, certified in balls.

Newton's iteration in floating point runs from many starts; each root it finds is enclosed by interval Newton, and that none lies
further to the right is proven by the argument principle around what is left of the half plane, as far as roots can lie there.

Of a loop with a clock: the largest root, as rate and frequency of the motion that lasts longest.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import inf, pi
from typing import Any

import flint
import numpy as np
from flint import acb, acb_poly, arb
from sympy import Expr, Integer, Rational

from haptisym.kernel.budget import Waiting
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import expression_ball
from haptisym.kernel.rings import Polynomial, RationalFunction
from haptisym.model.catalogue import Hand
from haptisym.model.scene import Scene
from haptisym.programs.values import Array
from haptisym.verbs.stability.sampled import loop_of

_BITS = 192
_ITERATIONS = 80
_TURNS = 12  # of the longest delay, as far as Newton's method starts
_MOST_PIECES = 40_000  # of a contour
_MOST_RADIUS = 1e7
_SLACK = 1e-9


@dataclass(frozen=True)
class Term:
    """coefficient s^power exp(-s lag)."""

    coefficient: Expr
    power: Rational
    lag: Expr


@dataclass(frozen=True)
class Rightmost:
    """The rightmost root with Im s >= 0 that was found, rad/s, and its digits; ``certified`` : no root lies right of it, proven.

    ``enclosure`` : a ball (flint ``acb``) around it; None where interval Newton did not enclose it.
    """

    s: complex
    enclosure: Any
    certified: bool
    function: Characteristic | None = field(default=None, repr=False)
    others: tuple[complex, ...] = ()
    """All roots that were found, from the right to the left."""

    def digits(self, count: int = 15) -> tuple[str, str]:
        """Real and imaginary part, correctly rounded where it is enclosed."""
        if self.enclosure is None:
            return f"{self.s.real:.9g}", f"{self.s.imag:.9g}"
        return tuple(x.str(count, radius=False) for x in (self.enclosure.real, self.enclosure.imag))


def rightmost_pole(dynamics: RationalFunction) -> complex | None:
    """The pole with the largest real part; None if none is found.

    >>> from sympy import exp
    >>> from haptisym.kernel.rings import s
    >>> pole = rightmost_pole(Ring.of([exp(-s)]).convert(1 / (s + 2 * exp(-s))).reduced())
    >>> round(pole.real, 4), round(abs(pole.imag), 4)
    (0.1728, 1.6737)
    """
    assert isinstance(dynamics.ring, Ring)
    roots = Characteristic.of(dynamics.denominator, dynamics.ring).roots()
    return max((x for x in roots if abs(x) > _SLACK), key=lambda x: x.real, default=None)


def rightmost_root(polynomial: Polynomial, ring: Ring, at_0: int = 0) -> Rightmost | None:
    """The rightmost root of a characteristic function with numbers only; None if there is none to find.

    ``at_0`` : that many roots at s = 0 are not meant, as they cancel.
    """
    function = Characteristic.of(polynomial, ring)
    found = sorted((x for x in function.roots() if not at_0 or abs(x) > _SLACK), key=lambda x: -x.real)
    if not found:
        return None
    first = found[0]
    following = next((x.real for x in found if x.real < first.real - 1e-7 * (1 + abs(first))), -inf)
    enclosure = function.enclosed(first)
    certified = enclosure is not None and function.is_rightmost(found, first, following, at_0)
    return Rightmost(
        first if enclosure is None else complex(enclosure.mid()), enclosure, certified, function, tuple(found)
    )


def _terms(polynomial: Polynomial, ring: Ring) -> Iterator[Term]:
    lags = len(ring.lags)
    for exponents, value in polynomial.to_dict().items():
        own = [int(n) for n in exponents]
        turns, powers = own[ring.size : ring.size + lags], own[ring.size + lags :]
        lag = sum((n * x for n, x in zip(turns, ring.lags, strict=True)), Integer(0))
        power = sum((n * x for n, x in zip(powers, ring.orders, strict=False)), Integer(own[0]))
        yield Term(Rational(int(value.p), int(value.q)) * ring.meanings[1] ** own[1], power, lag)


@dataclass(frozen=True)
class Characteristic:
    """A sum of terms, as floats and as balls."""

    terms: tuple[Term, ...]

    @classmethod
    def of(cls, polynomial: Polynomial, ring: Ring) -> Characteristic:
        """That of a polynomial of a ring, with numbers only."""
        found: dict[tuple[Rational, Expr], Expr] = {}
        for t in _terms(polynomial, ring):  # several powers of pi may stand before one power of s
            found[t.power, t.lag] = found.get((t.power, t.lag), Integer(0)) + t.coefficient
        return cls(tuple(Term(c, *place) for place, c in found.items()))

    @cached_property
    def chain(self) -> float | None:
        """To which Re s infinitely many roots tend, where delays are in the highest power of s; None where there are none."""
        degree = max(t.power for t in self.terms)
        own = {float(t.lag): float(t.coefficient) for t in self.terms if t.power == degree}
        own = {lag - min(own): c for lag, c in own.items()}
        unit = min((lag for lag in own if lag > 0), default=0.0)
        if not unit or any(abs(lag / unit - round(lag / unit)) > _SLACK for lag in own):
            return None
        row = np.zeros(round(max(own) / unit) + 1)
        for lag, c in own.items():
            row[round(lag / unit)] = c
        return float(max(-np.log(np.abs(np.roots(row[::-1])))) / unit)

    @cached_property
    def _floats(self) -> tuple[Array, Array, Array]:
        rows = [(float(t.coefficient), float(t.power), float(t.lag)) for t in self.terms]
        c, p, lag = (np.array(column) for column in zip(*rows, strict=True))
        return c, p, lag

    @cached_property
    def _balls(self) -> list[tuple[Any, Rational, Any]]:
        with flint.ctx.workprec(_BITS):
            return [(expression_ball(t.coefficient), t.power, expression_ball(t.lag)) for t in self.terms]

    def values(self, s: Array) -> tuple[Array, Array]:
        """The function and its derivative, each over the largest term: no overflow where exponentials are large."""
        c, p, lag = self._floats
        logs = np.log(np.abs(c)) + p * np.log(s[:, None]) - lag * s[:, None]
        top = logs.real.max(axis=1, keepdims=True)
        terms = np.sign(c) * np.exp(logs - top)
        return terms.sum(axis=1), (terms * (p / s[:, None] - lag)).sum(axis=1)

    def roots(self) -> list[complex]:
        """Roots with Im s >= 0, each once: where Newton's method ends that starts from many places."""
        s = self._starts()
        with np.errstate(all="ignore"):
            for _ in range(_ITERATIONS):
                value, slope = self.values(s)
                step = value / slope
                size = np.abs(step)
                s = s - np.where(size > 0.5 * np.abs(s) + 1e-12, step * (0.5 * np.abs(s) + 1e-12) / size, step)
            value, slope = self.values(s)
            good = np.isfinite(value) & (np.abs(value / slope) < 1e-9 * np.abs(s) + 1e-13)
        found: list[complex] = [0j] if min(t.power for t in self.terms) > 0 else []
        for x in sorted(map(complex, s[good]), key=lambda x: -x.real):
            own = complex(x.real, abs(x.imag)) if abs(x.imag) > 1e-9 * abs(x) else complex(x.real, 0)
            if all(abs(own - y) > 1e-7 * (abs(own) + 1e-9) for y in found):
                found.append(own)
        return found

    def _starts(self) -> Array:
        _, _, lags = self._floats
        longest, shortest = lags.max(initial=0.0), min((x for x in lags if x > 0), default=0.0)
        sizes = np.geomspace(1e-2, 1e5, 57)
        turns = np.exp(1j * np.pi * np.array([0.0, 0.2, 0.4, 0.47, 0.5, 0.53, 0.6, 0.8, 0.99]))
        starts = [np.multiply.outer(sizes, turns).ravel()]
        for lag in {longest, shortest} - {0.0}:
            heights = np.arange(0.25, 2 * _TURNS, 0.5) * pi / lag
            widths = np.array([-8.0, -3.0, -1.0, -0.2, 0.2, 1.0, 3.0, 8.0]) / lag
            starts.append((widths[:, None] + 1j * heights).ravel())
        return np.concatenate(starts)

    def ball(self, s: Any) -> Any:
        """A ball around the values at a ball."""
        return self._sum(s)[0]

    def _sum(self, s: Any) -> tuple[Any, Any]:
        value, slope = acb(0), acb(0)
        for c, p, lag in self._balls:
            wave = c * (-lag * s).exp()
            power = s ** int(p) if p.is_Integer else (s.log() * expression_ball(p)).exp()
            lower = _lower(s, p)
            value += wave * power
            slope += wave * (lower - lag * power)
        return value, slope

    def enclosed(self, near: complex) -> Any:
        """A ball in which there is one root, by interval Newton; None where that is not shown."""
        with flint.ctx.workprec(_BITS):
            middle = acb(near.real, near.imag)
            for _ in range(8):
                value, slope = self._sum(middle)
                if slope.contains(0):
                    return None
                middle = (middle - value / slope).mid()
            if near.imag == 0:
                middle = acb(middle.real)
            radius = arb(2) ** -100 * (abs(middle).mid() + arb(2) ** -40)
            for _ in range(40):
                box = acb(middle.real + arb(0, radius), middle.imag + arb(0, radius))
                value, slope = self._sum(box)
                if slope.contains(0):
                    return None
                image = middle - self.ball(middle) / slope
                if box.contains_interior(image):
                    return image
                radius *= 4
        return None

    # That no root is further right

    def is_rightmost(self, found: Sequence[complex], first: complex, following: float, at_0: int) -> bool:
        """Whether the half plane right of a line just left of the first root holds only those that were found there."""
        if any(not t.power.is_Integer for t in self.terms) and following < 0:
            return False  # powers of s have a cut on the negative real axis
        gap = min(first.real - following, 0.2 * abs(first) + 1e-3)
        line = first.real - gap / 2
        number = sum(1 + bool(x.imag) for x in found if x.real > line) + (at_0 if line < 0 else 0)
        return self._count_right_of(line) == number

    def _count_right_of(self, line: float) -> int | None:
        radius = self._radius(line)
        if radius is None:
            return None
        right = line + radius
        corners = [complex(line, -radius), complex(right, -radius), complex(right, radius), complex(line, radius)]
        with flint.ctx.workprec(64):
            total, left = arb(0), [_MOST_PIECES]
            for a, b in zip(corners, [*corners[1:], corners[0]], strict=True):
                turned = self._turned(a, b, left)
                if turned is None:
                    return None
                total += turned
            turns = total / (2 * arb.pi())
        whole = round(float(turns))
        return whole if abs(turns - whole) < arb(1) / 4 else None

    def _turned(self, start: complex, end: complex, left: list[int]) -> Any:
        """By how much the function turns along a segment; None where that is not shown with so many pieces."""
        total, pieces = arb(0), Waiting([(acb(start.real, start.imag), acb(end.real, end.imag))])
        for a, b in pieces:
            left[0] -= 1
            if left[0] < 0:
                return None
            over = self.ball(a.union(b))
            middle = over.mid()
            if not over.contains(0) and (over / middle).real > 0:
                total += (self.ball(b) / middle).arg() - (self.ball(a) / middle).arg()
                continue
            half = ((a + b) / 2).mid()
            pieces.add((a, half), (half, b))
        return total

    def _radius(self, line: float) -> float | None:
        """Beyond which no root lies right of the line: there the highest power outweighs all others."""
        degree = max(t.power for t in self.terms)
        rows = [(abs(c), p, np.exp(min(-lag * line, 700.0))) for c, p, lag in zip(*self._floats, strict=True)]
        own = [(c, lag) for c, p, lag in zip(*self._floats, strict=True) if p == float(degree)]
        single = [c for c, lag in own if lag == 0]
        if not single:
            return None
        floor = abs(single[0]) - sum(abs(c) * np.exp(min(-lag * line, 700.0)) for c, lag in own if lag)
        if floor <= 0:
            return None
        radius = 1e-3
        while radius < _MOST_RADIUS:
            if 0.9 * floor > sum(c * e * radius ** (p - float(degree)) for c, p, e in rows if p < float(degree)):
                return float(radius)
            radius *= 1.5
        return None


def _lower(s: Any, p: Rational) -> Any:
    """p s^(p - 1)."""
    if p == 0:
        return acb(0)
    return int(p) * s ** (int(p) - 1) if p.is_Integer else expression_ball(p) * (s.log() * expression_ball(p - 1)).exp()


_BITS_CLOCKROOT = 256
_TINY = 1e-12


def clocked_root(scene: Scene, hand: Hand) -> Rightmost | None:
    """ln z/T of the largest root z, all of them being enclosed; None where that loop is not known."""
    try:
        loop = loop_of(scene, hand)
        with flint.ctx.workprec(_BITS_CLOCKROOT):
            found = acb_poly(loop.balls()).roots(tol=arb(2) ** -100, maxprec=8 * _BITS_CLOCKROOT)
            T = expression_ball(loop.T)
            rows = [(-w.log() / T) for w in found if abs(w) > _TINY]  # w = 1/z
    except (UndecidedError, ValueError):
        return None
    if not rows:
        return None
    rows.sort(key=lambda s: -float(s.real.mid()))
    first = next(s for s in rows if not s.real < rows[0].real)
    # an isolated root near the real axis is real, as its conjugate is a root too
    upper = acb(first.real) if first.imag.contains(0) else acb(first.real, abs(first.imag))
    apart = all(s.real < first.real or s.real.overlaps(first.real) for s in rows)
    return Rightmost(complex(upper.mid()), upper, certified=apart, others=tuple(complex(s.mid()) for s in rows))
