"""Polynomials times sines and cosines of half angles: their derivatives, which are of the same kind, and short Taylor series."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache, reduce
from itertools import accumulate, repeat
from math import factorial
from operator import add, mul
from typing import TypeAlias

import flint
from flint import arb, arb_mat, arb_poly

from haptisym.kernel.budget import tick
from haptisym.kernel.reals import Ball

NOTHING, ONE = arb(0), arb(1)

Turns: TypeAlias = tuple[int, ...]
_Blocks: TypeAlias = Mapping[Turns, arb_mat]
"""Coefficients of powers of omega (columns) times waves of the last angle (rows), by the turns of the other angles."""
Place: TypeAlias = tuple[Mapping[Turns, Ball], arb_mat, arb_mat]
"""Products of sines and cosines of all half angles but the last, by turns; those of the last one in a row; powers of omega."""


class Derivatives:
    """A sum of polynomials times waves and its derivatives, which are of the same kind: exact, and no longer.

    d sin(a)^k cos(a)^(n - k) = (k sin(a)^(k - 1) cos(a)^(n - k + 1) - (n - k) sin(a)^(k + 1) cos(a)^(n - k - 1)) da.
    """

    def __init__(self, angles: Sequence[tuple[Ball, int]], width: int, terms: Mapping[Turns, Sequence[Ball]]) -> None:
        *self._outer, (rate, degree) = angles
        self._turn, self._shift = _turning(rate, degree), _shift(width)
        entries: dict[Turns, list[Ball]] = {}
        for (*others, k), row in terms.items():
            block = entries.setdefault(tuple(others), [NOTHING] * (width * (degree + 1)))
            block[k * width : k * width + len(row)] = row
        self._known: list[_Blocks] = [{o: arb_mat(degree + 1, width, block) for o, block in entries.items()}]

    def series(self, place: Place, start: int, stop: int) -> list[Ball]:
        """The Taylor coefficients of these orders."""
        outer, last, columns = place
        while len(self._known) < stop:
            self._known.append(self._derived(self._known[-1]))
        if () in outer:
            found = [(last * (blocks[()] * columns))[0, 0] for blocks in self._known[start:stop]]
        else:
            found = [
                sum((outer[turns] * (last * (block * columns))[0, 0] for turns, block in blocks.items()), NOTHING)
                for blocks in self._known[start:stop]
            ]
        return list(map(mul, found, _shares(stop, flint.ctx.prec)[start:])) if stop > 2 else found

    def _derived(self, blocks: _Blocks) -> _Blocks:
        found: dict[Turns, arb_mat] = {}
        for others, block in blocks.items():
            tick()
            parts = [(others, block * self._shift + self._turn * block)]
            for i, (rate, degree) in enumerate(self._outer):
                k = others[i]
                if k:
                    parts.append(((*others[:i], k - 1, *others[i + 1 :]), block * (rate * k)))
                if k < degree:
                    parts.append(((*others[:i], k + 1, *others[i + 1 :]), block * (rate * (k - degree))))
            for turns, part in parts:
                found[turns] = found[turns] + part if turns in found else part
        return found


@lru_cache(maxsize=64)
def _shares(count: int, bits: int) -> list[Ball]:
    """1/0!, 1/1!, 1/2!, ..."""
    with flint.ctx.workprec(bits):
        return [arb(1) / factorial(n) for n in range(count)]


@lru_cache(maxsize=64)
def _shift(width: int) -> arb_mat:
    """What d/d omega does to the coefficients of 1, omega, omega^2, ... in a row: whole numbers, exact at any precision."""
    shift = arb_mat(width, width)
    for n in range(1, width):
        shift[n, n - 1] = n
    return shift


def _turning(rate: Ball, degree: int) -> arb_mat:
    """What d/d omega does to the coefficients of sin^k cos^(degree - k), k = 0 ... degree, of one half angle."""
    turn = arb_mat(degree + 1, degree + 1)
    for k in range(degree):
        turn[k, k + 1] = rate * (k + 1)
        turn[k + 1, k] = rate * (k - degree)
    return turn


def powers_of(x: Ball, count: int) -> list[Ball]:
    """1, x, x^2, ..."""
    return list(accumulate(repeat(x, count - 1), mul, initial=ONE))


def waves_of(half: Ball, degree: int) -> list[Ball]:
    """sin^k cos^(degree - k) of a half angle, k = 0 ... degree."""
    sine, cosine = half.sin_cos()
    if degree == 1:
        return [cosine, sine]
    if degree == 2:
        return [cosine**2, sine * cosine, sine**2]
    return list(map(mul, powers_of(sine, degree + 1), reversed(powers_of(cosine, degree + 1))))


def power_series(x: Ball, exponent: Ball, length: int) -> list[Ball]:
    """The Taylor coefficients of x^exponent."""
    found = [(x.log() * exponent).exp()]
    inverse = 1 / x if length > 1 else x
    for n in range(length - 1):
        found.append(found[-1] * ((exponent - n) / (n + 1)) * inverse)
    return found


def product(a: Sequence[Ball], b: Sequence[Ball], start: int = 0) -> list[Ball]:
    """The product of two Taylor series, as long as they are, from an order on."""
    if start == len(a) - 1:
        return [reduce(add, map(mul, a, reversed(b)))]
    found = arb_poly(a) * arb_poly(b)
    return [found[n] for n in range(start, len(a))]
