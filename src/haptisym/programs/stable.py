"""A distortion as a straight-line program whose floats keep their digits.

What cancels for every parameter is cancelled before there are numbers: each effect gives its relative distortion p + j q =
G - 1 in lowest terms. Effects in a row are put together by 1 + P' + j Q' = (g + j Q)(1 + p + j q), with g = Re G of those so
far: P' = P + g p - Q q telescopes and keeps its digits at low frequencies, and Q' = g q + Q (1 + p) is taken from the
product, where it keeps them at high ones. What is felt is the product, never the sum H_env + dH.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from sympy import Add, Expr, Symbol

from haptisym.kernel.dynamics import Ring
from haptisym.kernel.response import RealFunction, on_axis
from haptisym.kernel.rings import RationalFunction, cleared, degree_in
from haptisym.kernel.symbols import omega
from haptisym.programs.program import Program, Writer, sincm1

Pair: TypeAlias = tuple[int, int]
"""Steps for real and imaginary part."""


def stable_program(
    environment: Expr, rendered: Expr, matrices: Sequence[Sequence[Expr]], inputs: Sequence[Symbol]
) -> Callable[[Sequence[str], Collection[str]], Program]:
    """What writes the program of some fields of ``numeric.Values``, some of them known to be 0, for a chain of dynamics.

    Each matrix is taken in a ring of its own: the angles of one effect are no multiples of those of another, and stay short.
    ``inputs`` : the parameters, after omega.
    """
    author = _Author(Writer((omega, *inputs)))
    found, nothing = author.fields(environment, rendered, matrices), author.write.constant(0)
    return lambda of, zero: author.write.program({name: nothing if name in zero else found[name] for name in of})


@dataclass
class _Author:
    write: Writer

    def fields(self, environment: Expr, rendered: Expr, matrices: Sequence[Sequence[Expr]]) -> dict[str, int]:
        H = self.sum_of_fractions(environment)
        felt, dH = H, self.pair(0, 0)
        if rendered != environment:
            ring = Ring.of([rendered, environment])
            more = (ring.convert(rendered) - ring.convert(environment)).reduced()
            felt, dH = self.sum_of_fractions(rendered), self.closed(more)
        runs = _runs([list(map(Ring.of(matrix).convert, matrix)) for matrix in matrices])
        for run in runs:
            felt, dH = self.after(run, felt, dH)
        fraction, relative = (dH, self.write.constant(1)), None
        if rendered == environment and len(runs) == 1 and _is_series(runs[0][0]):
            relative = self.series([row[0] for row in runs[0]])[1]
            if len(runs[0]) == 1:  # the one effect's denominator stays below the line: a division less
                above, below = self.fraction(_less_one(runs[0][0][0]))
                fraction = self.times(H, above), below
        return self.results(H, felt, fraction, relative)

    def after(self, run: Sequence[Sequence[RationalFunction]], felt: Pair, dH: Pair) -> tuple[Pair, Pair]:
        """What is felt, and by how much it differs, behind some more effects."""
        if not _is_series(run[0]):
            return self.port(run[0], felt, dH)
        gain, change = self.series([row[0] for row in run])
        return self.times(felt, gain), self.plus(dH, self.times(felt, change))

    def results(self, H: Pair, felt: Pair, fraction: tuple[Pair, int], relative: Pair | None) -> dict[str, int]:
        w, (R, X), dH = self.write, H, self.over(*fraction)
        if w.number(X) == 0 or w.number(R) == 0:  # H on an axis: no squares, and no 0/0 where it has a zero
            found = relative or ((self.over(dH, R)) if w.number(X) == 0 else self.over((dH[1], w.neg(dH[0])), X))
            ratios = found if w.number(X) == 0 else (found[1], found[0])
            real, imag = (w.abs(x) for x in ratios)
        else:
            N = w.add(w.mul(R, R), w.mul(X, X))
            found = relative or self.over(self.times(dH, (R, w.neg(X))), N)
            above, below = fraction
            scale = w.div(w.constant(1), w.mul(below, w.sqrt(N)))
            real, imag = (w.mul(w.abs(x), scale) for x in above)
        pairs = {"": dH, "ratio_": (real, imag), "relative_": found, "environment_": H, "perceived_": felt}
        return {
            f"{kind}{part}": x for kind, pair in pairs.items() for part, x in zip(("real", "imag"), pair, strict=True)
        }

    def sum_of_fractions(self, H: Expr) -> Pair:
        """The polynomial of a dynamics and each of its fractions for itself, as they are written in the model."""
        ring = Ring.of([H])
        terms = [ring.convert(term).reduced() for term in Add.make_args(H)]
        whole, total = ring.zero, self.pair(0, 0)
        for term in terms:
            if term.denominator.is_constant():
                whole = whole + term
            else:
                total = self.plus(total, self.closed(term))
        return self.plus(self.closed(whole.reduced()), total)

    def series(self, gains: Sequence[RationalFunction]) -> tuple[Pair, Pair]:
        """G and G - 1 of effects in a row."""
        G, (P, Q) = self.pair(1, 0), self.pair(0, 0)
        for gain in gains:
            own, (p, q) = self.closed(gain), self.closed(_less_one(gain))
            telescoped = self.write.sub(self.write.add(P, self.write.mul(G[0], p)), self.write.mul(Q, q))
            G = self.times(G, own)
            P, Q = telescoped, G[1]
        return G, (P, Q)

    def port(self, matrix: Sequence[RationalFunction], felt: Pair, dH: Pair) -> tuple[Pair, Pair]:
        """(A H + B)/(C H + D), and what it adds, ((A - D) H + B - C H^2)/(C H + D)."""
        A, B, C, D = map(matrix[0].ring.function, cleared(matrix))
        if C.is_zero:  # beside the environment
            Z = self.closed((B / D).reduced())
            gain, change = self.series([(A / D).reduced()])
            moved = self.plus(self.times(felt, change), Z)
            return self.plus(self.times(felt, gain), Z), self.plus(dH, moved)
        a, b, c, d, difference = (self.entry(x) for x in (A, B, C, D, A - D))
        c_H = self.times(c, felt)
        below = self.plus(c_H, d)
        modulus = self.write.add(self.write.mul(below[0], below[0]), self.write.mul(below[1], below[1]))
        turned = (below[0], self.write.neg(below[1]))
        above = self.plus(self.times(a, felt), b)
        added = self.plus(self.times(self.minus(difference, c_H), felt), b)
        result, more = (self.over(self.times(x, turned), modulus) for x in (above, added))
        return result, self.plus(dH, more)

    def entry(self, entry: RationalFunction) -> Pair:
        """An entry of a chain matrix, a polynomial: the product of its factors."""
        unit, factors = entry.ring.factors(entry.numerator, in_square=False)
        total: Pair = (self.write.expression(unit), self.write.constant(0))
        for factor, n in factors:
            for _ in range(n):
                total = self.times(total, self.closed(entry.ring.function(factor)))
        return total

    def closed(self, f: RationalFunction) -> Pair:
        """Re and Im of a dynamics on s = j omega."""
        return self.over(*self.fraction(f))

    def fraction(self, f: RationalFunction) -> tuple[Pair, int]:
        """The same, over the squared modulus U^2 + V^2 of its denominator, or over 1 where that is no common one."""
        axis, f, one = _ring(f).axis, f.cleared(), self.write.constant(1)
        if f.is_zero:
            return self.pair(0, 0), one
        if self.has_functions(f):
            response = on_axis(f)
            return (self.quotient(response.real), self.quotient(response.imag)), one
        (p, q), (u, v) = axis.parts([f.numerator, f.denominator])
        above, square = (p * u + q * v, q * u - p * v), u * u + v * v
        if f.denominator.is_constant() or any(not x.is_zero() and not x.gcd(square).is_constant() for x in above):
            response = on_axis(f)
            return (self.quotient(response.real), self.quotient(response.imag)), one
        U, V = (self.write.polynomial(axis, x) for x in (u, v))
        M = self.write.add(self.write.mul(U, U), self.write.mul(V, V))
        return (self.write.product(axis, above[0]), self.write.product(axis, above[1])), M

    def has_functions(self, f: RationalFunction) -> bool:
        later = range(f.ring.size, len(f.ring.meanings))
        return any(degree_in([f.numerator, f.denominator], i) for i in later)

    def quotient(self, real: RealFunction) -> int:
        hold = without_sinc_less_one(real)
        if hold is not None:
            angle, rest = hold
            return self.write.mul(self.write.expression(sincm1(angle)), self.quotient(rest))
        f = real.half_angled
        if f.denominator.is_constant():
            return self.write.product(f.ring, f.numerator / f.denominator.leading_coefficient())
        f = f.cleared()
        return self.write.div(self.write.product(f.ring, f.numerator), self.write.product(f.ring, f.denominator))

    def pair(self, real: int, imag: int) -> Pair:
        return self.write.constant(real), self.write.constant(imag)

    def plus(self, x: Pair, y: Pair) -> Pair:
        return self.write.add(x[0], y[0]), self.write.add(x[1], y[1])

    def minus(self, x: Pair, y: Pair) -> Pair:
        return self.write.sub(x[0], y[0]), self.write.sub(x[1], y[1])

    def times(self, x: Pair, y: Pair) -> Pair:
        mul = self.write.mul
        real = self.write.sub(mul(x[0], y[0]), mul(x[1], y[1]))
        return real, self.write.add(mul(x[0], y[1]), mul(x[1], y[0]))

    def over(self, x: Pair, y: int) -> Pair:
        return self.write.div(x[0], y), self.write.div(x[1], y)


def without_sinc_less_one(real: RealFunction) -> tuple[Expr, RealFunction] | None:
    """An angle a and a function f, where f (sin(a)/a - 1) is the given one: what a sample-and-hold brings."""
    axis, f = real.axis, real.function
    for angle, t in zip(axis.angles, axis.context.gens()[axis.size :], strict=False):
        if angle.constant or f.is_zero:
            continue
        a = axis.convert(angle.rate * omega)
        factor = 2 * t * a.denominator - (1 + t**2) * a.numerator  # sin a = 2 t/(1 + t^2), t = tan(a/2)
        above, remainder = divmod(f.numerator, factor)
        if remainder.is_zero():
            other = axis.function(above * (1 + t**2) * a.numerator, f.denominator)
            return angle.rate * omega, RealFunction(other.reduced())
    return None


def _ring(f: RationalFunction) -> Ring:
    assert isinstance(f.ring, Ring)
    return f.ring


def _less_one(gain: RationalFunction) -> RationalFunction:
    return (gain - gain.ring.one).reduced()


def _runs(matrices: Sequence[Sequence[RationalFunction]]) -> list[list[tuple[RationalFunction, ...]]]:
    """Series effects that follow each other together, as (G, 0, 0, 1); everything else alone."""
    runs: list[list[tuple[RationalFunction, ...]]] = []
    for matrix in matrices:
        ring = matrix[0].ring
        if matrix[1].is_zero and matrix[2].is_zero:
            row = ((matrix[0] / matrix[3]).reduced(), ring.zero, ring.zero, ring.one)
            if runs and _is_series(runs[-1][0]):
                runs[-1].append(row)
            else:
                runs.append([row])
        else:
            runs.append([tuple(matrix)])
    return runs


def _is_series(matrix: Sequence[RationalFunction]) -> bool:
    return matrix[1].is_zero and matrix[2].is_zero
