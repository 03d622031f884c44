"""Sums of waves at places where all that turns is known exactly: their Taylor coefficients, without error."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache, reduce
from itertools import accumulate, repeat
from typing import TypeAlias

from flint import fmpq, fmpq_poly
from sympy import Expr, Integer, Symbol, pi

from haptisym.kernel.monomials import monomials
from haptisym.kernel.rings import Polynomial, PolynomialRing, RationalFunction
from haptisym.kernel.symbols import omega
from haptisym.kernel.wavesums import WaveSum

Wave: TypeAlias = tuple[int, int] | None
_EIGHTHS = ((1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1))


def exact_waves(f: WaveSum, place: Expr) -> list[Wave] | None:
    """Cosine and sine of the half angles, up to a factor, at multiples of an eighth of a turn; None if one is at another angle.

    In all terms of a factor the powers of both add up to the same, so that a common factor is none of the zeros' business. The
    entry of a constant angle is None: its cosine and sine stay symbols.
    """
    if place != 0 and place.is_Rational and any(rate.is_Rational for rate, _ in f.rates):
        return None  # a rational angle, but 0, is no part of a turn
    found: list[Wave] = []
    for rate, constant in f.rates:
        eighths = Integer(0) if constant else 2 * rate * place / pi
        if not eighths.is_Integer:
            return None
        found.append(None if constant else _EIGHTHS[int(eighths) % 8])
    return found


def taylor_coefficients(f: WaveSum, place: Expr, waves: list[Wave]) -> Iterator[RationalFunction]:
    """The Taylor coefficients at a place where the waves are known, all times one number that is not 0.

    Each is a polynomial in the cosines and sines of the constant half angles, in this order from the third variable of its
    ring on, over a polynomial in pi.
    """
    names = [Symbol(f"{kind}{i}") for i in range(len(f.rates)) for kind in ("cos", "sin")]
    ring = PolynomialRing(omega, functions=names)
    derivative = _in_waves(f, ring)
    rates = [ring.convert(rate / 2) for rate, _ in f.rates]
    common = reduce(lambda x, y: x * y, (rate.denominator for rate in rates), ring.constant(1))
    scale, order = ring.one, 0
    while True:
        yield _at(ring, derivative, place, waves) / scale
        change = common * derivative.derivative(0)
        for i, (rate, (_, constant)) in enumerate(zip(rates, f.rates, strict=True)):
            if not constant:
                cosine, sine = (ring.context.gens()[2 + 2 * i + n] for n in (0, 1))
                turned = cosine * derivative.derivative(3 + 2 * i) - sine * derivative.derivative(2 + 2 * i)
                change += rate.numerator * (common / rate.denominator) * turned
        derivative, order = change, order + 1
        scale = scale * ring.function(common * order)


def order_at_0(f: WaveSum) -> int | None:
    """The order of the zero at omega = 0, where all angles turn at rational rates; None where they do not, or it is very high.

    The cosines of half angles are 1 there: it is that of the sum of polynomials times tangents, order by order.
    """
    if not all(rate.is_Rational and not constant for rate, constant in f.rates):
        return None
    for length in (8, 32, 128):
        tangents = [
            _tangent_powers(fmpq(int(r.p), 2 * int(r.q)), n, length)
            for (r, _), n in zip(f.rates, f.degrees, strict=True)
        ]
        in_pi: dict[int, fmpq_poly] = {}
        for term in f.terms:
            waves = reduce(
                lambda x, y: x.mul_low(y, length), (x[k] for x, k in zip(tangents, term.turns, strict=True)), _ONE
            )
            for i in range(max(map(len, term.coefficients))):
                row = fmpq_poly([c[i] if i < len(c) else 0 for c in term.coefficients])
                in_pi[i] = in_pi.get(i, _NOTHING) + row.mul_low(waves, length)
        # pi is transcendental: only what is zero before each of its powers is zero
        orders = [n for total in in_pi.values() for n, c in enumerate(total.coeffs()) if c]
        if orders:
            return min(orders)
    return None


_NOTHING, _ONE = fmpq_poly([0]), fmpq_poly([1])


def _tangent_powers(rate: fmpq, most: int, length: int) -> list[fmpq_poly]:
    """tan(rate omega)^k for k = 0, 1, ... ``most``, as Taylor polynomials at 0 with that many coefficients."""
    tangent = fmpq_poly([c * rate**n for n, c in enumerate(_tangent(length))])
    return list(accumulate(repeat(tangent, most), lambda x, y: x.mul_low(y, length), initial=_ONE))


@lru_cache(maxsize=8)
def _tangent(length: int) -> list[fmpq]:
    """The Taylor coefficients of the tangent at 0: t' = 1 + t^2."""
    found = [fmpq(0)]
    for n in range(1, length):
        square = sum((found[i] * found[n - 1 - i] for i in range(n)), fmpq(int(n == 1)))
        found.append(square / n)
    return found


def _in_waves(f: WaveSum, ring: PolynomialRing) -> Polynomial:
    terms: dict[tuple[int, ...], int] = {}
    for term in f.terms:
        waves = [n for k, degree in zip(term.turns, f.degrees, strict=True) for n in (degree - k, k)]
        for power, row in enumerate(term.coefficients):
            for of_pi, value in enumerate(row):
                if value:
                    terms[(power, of_pi, *waves)] = value
    return ring.context.from_dict(terms)


def _at(ring: PolynomialRing, polynomial: Polynomial, place: Expr, waves: list[Wave]) -> RationalFunction:
    """The value at an exact place, a polynomial in pi (and the constant angles' waves)."""
    where, total = ring.convert(place), ring.zero
    for (power, of_pi, *turns), value in monomials(polynomial):
        if power and place == 0:
            continue
        known, kept = value, [0, int(of_pi)]
        for wave, cosine, sine in zip(waves, turns[::2], turns[1::2], strict=True):
            kept += [int(cosine), int(sine)] if wave is None else [0, 0]
            known = known if wave is None else known * wave[0] ** int(cosine) * wave[1] ** int(sine)
        total = total + ring.function(ring.context.from_dict({tuple(kept): known})) * where ** int(power)
    return total
