"""Straight-line programs for a distortion dH = H_perc - H_env whose floats keep their digits: one
of the chain of effects (``stable_program``), one of its closed forms (``closed_program``).

What cancels for every parameter is cancelled before there are numbers: each effect gives its
relative distortion p + j q = G - 1 in lowest terms. Effects in a row are put together by 1 + P' + j
Q' = (g + j Q)(1 + p + j q), with g = Re G of those so far: P' = P + g p - Q q telescopes and keeps
its digits at low frequencies, and Q' = g q + Q (1 + p) is taken from the product, where it keeps
them at high ones. H_perc is computed as the product, never as the sum H_env + dH.

The steps that a reader would name have labels: R + j X of an environment, and R_n + j X_n of what
is felt behind effect n, N = |H_env|^2, P_n + j Q_n of an effect, G_n = 1 + P_n, S_n + j T_n of a
shunt, Y_n + j Z_n of a factor in a two-port, U + j V of a denominator and M = U^2 + V^2, K + j L of
what stands over it, E + j F of dH.

Closed forms in lowest terms have the limit where the steps of a chain are 0/0. A factor of them
that is the squared modulus of a factor R + j X of the dynamics is computed as R^2 + X^2, which is
never negative, and keeps its digits at a resonance.

A *step* is an operation of a program, named by its number; a *ring* (``kernel.dynamics``) holds
polynomials in s, its *axis* (``kernel.axis``) their real and imaginary parts in omega. Begin with
``stable_program`` and ``Author.fields``.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

from flint import fmpq
from sympy import Add, Expr, Integer, Rational, Symbol, sqrt

from haptisym.kernel.axis import Axis
from haptisym.kernel.dynamics import RealFunction, Ring, on_axis, ring_of
from haptisym.kernel.rings import (
    Polynomial,
    PolynomialRing,
    RationalFunction,
    cleared,
    degree_in,
    omega,
)
from haptisym.programs.program import Program, Writer, sincm1

ComplexStep: TypeAlias = tuple[int, int]
"""The steps that compute the real and the imaginary part of a complex number."""


def stable_program(
    environment: Expr, rendered: Expr, matrices: Sequence[Sequence[Expr]], inputs: Sequence[Symbol]
) -> Callable[[Sequence[str], Collection[str]], Program]:
    """For a chain of dynamics, a function that gives the program of some fields of
    ``programs.values.Values``: of the names of the fields, and of those among them known to be 0.

    Each matrix is taken in a ring of its own: the angles of one effect are no multiples of those of
    another, and stay short.
    ``inputs`` : the parameters, after omega.
    """
    # All fields are written once; every program takes from them the steps that it needs.
    write = Writer((omega, *inputs))
    fields = Author(write).fields(environment, rendered, matrices)
    nothing = write.constant(0)

    def program(of: Sequence[str], zero: Collection[str]) -> Program:
        return write.program({name: nothing if name in zero else fields[name] for name in of})

    return program


@dataclass
class Author:
    """Writes dynamics on s = j omega as steps for their real and imaginary parts."""

    write: Writer
    factors: dict[ComplexStep, int] = field(default_factory=dict)

    def fields(
        self, environment: Expr, rendered: Expr, matrices: Sequence[Sequence[Expr]]
    ) -> dict[str, int]:
        """The steps of environment, felt dynamics and change, labelled by the fields of the record
        they fill."""
        H = self.named("RX", self.sum_of_fractions(environment, "_e"))
        felt = H
        dH = self.pair(0, 0)
        if rendered != environment:
            # Subtracted as fractions: in floats a small difference of both would have no digits.
            ring = Ring.of([rendered, environment])
            more = ring.convert(rendered) - ring.convert(environment)
            felt = self.named("RX", self.sum_of_fractions(rendered, "_r"), "_r")
            dH = self.named("EF", self.closed(more.reduced(), "_d"), "_r")
        parts = runs([list(map(Ring.of(matrix).convert, matrix)) for matrix in matrices])
        last = len(matrices)
        labels = [f"_{n}" for n in range(1, last + 1)] if last > 1 else [""]
        fraction, relative = None, None
        # With series effects alone dH/H_env is G - 1, without a division by H_env.
        one_run = rendered == environment and len(parts) == 1
        if one_run and _is_series(parts[0][0]):
            gains = [row[0] for row in parts[0]]
            if last == 1:  # the one effect's denominator stays below the line: a division less
                above, below = self.fraction(less_one(gains[0]), "")
                letters = "PQ" if self.write.number(below) == 1 else "KL"
                change = self.named(letters, above)
                fraction = self.named("EF", self.times(H, change)), below
            _, relative = self.series(gains, labels)
        for run in parts:
            run_labels = labels[: len(run)]
            labels = labels[len(run) :]
            felt, dH = self.after(run, felt, dH, run_labels)
            if labels:
                last_label = run_labels[-1]
                felt = self.named("RX", felt, last_label)
                dH = self.named("EF", dH, last_label)
        whole = fraction or (self.named("EF", dH), self.write.constant(1))
        return self.results(H, felt, whole, relative)

    def after(
        self,
        run: Sequence[Sequence[RationalFunction]],
        felt: ComplexStep,
        dH: ComplexStep,
        labels: Sequence[str],
    ) -> tuple[ComplexStep, ComplexStep]:
        """H_perc and dH behind a further run of effects, from those in front of it."""
        if not _is_series(run[0]):
            return self.port(run[0], felt, dH, labels[0])
        gains = [row[0] for row in run]
        gain, change = self.series(gains, labels)
        behind = self.times(felt, gain)
        return behind, self.plus(dH, self.times(felt, change))

    def results(
        self,
        H: ComplexStep,
        felt: ComplexStep,
        fraction: tuple[ComplexStep, int],
        relative: ComplexStep | None,
    ) -> dict[str, int]:
        """The steps of all fields, with no square and no 0/0 where the environment lies on an
        axis."""
        w = self.write
        R, X = H
        dH = self.over(*fraction)
        is_real = w.number(X) == 0
        is_imaginary = w.number(R) == 0
        if is_real or is_imaginary:
            # |H_env| is |R| or |X|: no squares, whose quotient would be 0/0 at a zero of H_env. Of
            # H_env = j X the quotient (E + j F)/(j X) is (F - j E)/X.
            if relative is None:
                E, F = dH
                relative = self.over(dH, R) if is_real else self.over((F, w.neg(E)), X)
            P, Q = relative
            ratios = (P, Q) if is_real else (Q, P)
            sizes = [w.abs(x) for x in ratios]
            squares = [w.mul(x, x) for x in ratios]
        else:
            N = w.label(self.square(H), "N")
            if relative is None:
                conjugate = R, w.neg(X)
                relative = self.over(self.times(dH, conjugate), N)
            above, below = fraction
            one = w.constant(1)
            scale = w.div(one, w.mul(below, w.sqrt(N)))
            sizes = [w.mul(w.abs(x), scale) for x in above]
            squares = []
            for x in above:
                square = w.power(w.div(x, below), 2)
                squares.append(w.div(square, N))
        pairs: dict[str, Sequence[int]] = {
            "": dH,
            "ratio_": sizes,
            "squared_": squares,
            "relative_": relative,
            "environment_": H,
            "perceived_": felt,
        }
        fields = {}
        for kind, (real, imag) in pairs.items():
            fields[f"{kind}real"] = real
            fields[f"{kind}imag"] = imag
        return fields

    def sum_of_fractions(self, H: Expr, label: str) -> ComplexStep:
        """The steps of a dynamics: its polynomial, and each of its fractions for itself, as they
        are written in the model."""
        # Over one denominator a small term would be added to products of large ones.
        ring = Ring.of([H])
        terms = [ring.convert(term).reduced() for term in Add.make_args(H)]
        whole = ring.zero
        total = self.pair(0, 0)
        fractions = [term for term in terms if not term.denominator.is_constant()]
        numbered = len(fractions) > 1
        for n, term in enumerate(terms, 1):
            if term.denominator.is_constant():
                whole = whole + term
            else:
                closed = self.closed(term, f"{label}{n}" if numbered else label)
                total = self.plus(total, closed)
        return self.plus(self.closed(whole.reduced(), label), total)

    def series(
        self, gains: Sequence[RationalFunction], labels: Sequence[str]
    ) -> tuple[ComplexStep, ComplexStep]:
        """G and G - 1 of effects in a row."""
        write = self.write
        G = self.pair(1, 0)
        P, Q = self.pair(0, 0)
        for gain, label in zip(gains, labels, strict=True):
            p, q = self.named("PQ", self.closed(less_one(gain), label), label)
            factor = self.named("GQ", self.closed(gain, label), label)
            # P' = P + g p - Q q, as in the docstring of the module: small terms alone are added.
            g, _ = G
            added = write.add(P, write.mul(g, p))
            telescoped = write.sub(added, write.mul(Q, q))
            G = self.times(G, factor)
            g, product_imag = G
            P, Q = self.named("PQ", (telescoped, product_imag), f"{labels[0]}{label}")
            write.label(g, f"G{labels[0]}{label}")
        return G, (P, Q)

    def port(
        self, matrix: Sequence[RationalFunction], felt: ComplexStep, dH: ComplexStep, label: str
    ) -> tuple[ComplexStep, ComplexStep]:
        """(A H + B)/(C H + D), and what it adds, ((A - D) H + B - C H^2)/(C H + D)."""
        A, B, C, D = map(matrix[0].ring.function, cleared(matrix))
        if C.is_zero:
            # An impedance beside the environment, with a gain: (A H + B)/D = (A/D) (H + B/A). What
            # a sampled loop adds is short before its gain.
            before = (B / A).reduced() if not A.is_zero else B
            Z = self.named("ST", self.closed(before, label), label)
            gain, change = self.series([(A / D).reduced()], [label])
            felt = self.plus(felt, Z)
            behind = self.times(felt, gain)
            added = self.plus(self.times(felt, change), Z)
            return behind, self.plus(dH, added)
        # Without the power of s that all entries share C H + D is not 0 at s = 0.
        orders = [ring_of(x).order_at_0(x.numerator) for x in (A, B, C, D)]
        common = int(min(orders))
        a, b, c, d, difference = (self.entry(x, common) for x in (A, B, C, D, A - D))
        c_H = self.times(c, felt)
        over = self.division(self.plus(c_H, d), label)
        above = self.plus(self.times(a, felt), b)
        # ((A - D) - C H) H + B
        slope = self.minus(difference, c_H)
        added = self.plus(self.times(slope, felt), b)
        added = self.named("KL", added, label)
        behind = over(above)
        return behind, self.plus(dH, over(added))

    def entry(self, entry: RationalFunction, zeros: int) -> ComplexStep:
        """An entry of a chain matrix, a polynomial, over s^zeros: the product of its factors."""
        ring = ring_of(entry)
        unit, factors = ring.factors(entry.numerator, in_square=False)
        total = self.pair(unit, 0)
        # Each factor gives up as many zeros at s = 0 as it has, until all that are asked for are
        # gone.
        for factor, n in factors:
            for _ in range(n):
                order = int(min(ring.order_at_0(factor), zeros))
                over = ring.function(factor, ring.variable**order)
                total = self.times(total, self.factor(over.reduced()))
                zeros -= order
        return total

    def factor(self, f: RationalFunction) -> ComplexStep:
        """Re and Im of a factor, numbered unless it is a mere parameter."""
        pair = self.closed(f, "")
        if all(self.write.operations[x].name in ("input", "constant") for x in pair):
            return pair
        number = self.factors.setdefault(pair, len(self.factors) + 1)
        return self.named("YZ", pair, f"_{number}")

    def closed(self, f: RationalFunction, label: str) -> ComplexStep:
        """Re and Im of a dynamics on s = j omega; ``label`` : what its U, V and M are marked
        with."""
        return self.over(*self.fraction(f, label))

    def fraction(self, f: RationalFunction, label: str) -> tuple[ComplexStep, int]:
        """Re and Im of a dynamics as numerators over one real denominator: the squared modulus M =
        U^2 + V^2 of its denominator U + j V, or 1 where that is not common to both."""
        axis = ring_of(f).axis
        f = f.cleared()
        one = self.write.constant(1)
        if f.is_zero:
            return self.pair(0, 0), one
        if self.has_functions(f):
            return self.parts_in_lowest_terms(f), one
        # (p + j q)/(u + j v) = (p + j q) (u - j v)/(u^2 + v^2)
        (p, q), (u, v) = axis.parts([f.numerator, f.denominator])
        real = p * u + q * v
        imag = q * u - p * v
        square = u * u + v * v
        # Re^2 + Im^2 is |N|^2 |D|^2: a factor that one part shares with |D|^2 is one of both
        if f.denominator.is_constant() or not real.gcd(square).is_constant():
            return self.parts_in_lowest_terms(f), one
        U = self.write.polynomial(axis, u)
        V = self.write.polynomial(axis, v)
        below = self.named("UV", (U, V), label)
        M = self.write.label(self.square(below), f"M{label}")
        above = self.write.product(axis, real), self.write.product(axis, imag)
        return above, M

    def parts_in_lowest_terms(self, f: RationalFunction) -> ComplexStep:
        """Re and Im of a dynamics on s = j omega, each a quotient of its own."""
        response = on_axis(f)
        return self.quotient(response.real), self.quotient(response.imag)

    def has_functions(self, f: RationalFunction) -> bool:
        """Whether delays or fractional powers of s occur in it, so that it is more than a rational
        function of omega."""
        later = range(f.ring.size, len(f.ring.meanings))
        return any(degree_in([f.numerator, f.denominator], i) for i in later)

    def quotient(self, real: RealFunction) -> int:
        """The step of a real function, numerator over denominator; a factor sinc x - 1 without
        cancellation."""
        hold = without_sinc_less_one(real)
        if hold is not None:
            angle, rest = hold
            factor = self.write.expression(sincm1(angle))
            return self.write.mul(factor, self.quotient(rest))
        # In half angles 1 - cos x is 2 sin^2(x/2), which keeps its digits where x is small.
        f = real.half_angled
        if f.denominator.is_constant():
            number = f.denominator.leading_coefficient()
            return self.product(f.ring, f.numerator / number)
        f = f.cleared()
        above = self.product(f.ring, f.numerator)
        return self.write.div(above, self.product(f.ring, f.denominator))

    def product(self, ring: PolynomialRing, polynomial: Polynomial) -> int:
        """A polynomial as the product of its factors."""
        return self.write.product(ring, polynomial)

    def named(self, letters: str, pair: ComplexStep, label: str = "") -> ComplexStep:
        """The pair, labelled with the letters of its real and its imaginary part."""
        real, imag = pair
        real = self.write.label(real, f"{letters[0]}{label}")
        return real, self.write.label(imag, f"{letters[1]}{label}")

    def division(self, below: ComplexStep, label: str) -> Callable[[ComplexStep], ComplexStep]:
        """A function that divides by a complex number, whose steps are written once."""
        U, V = self.named("UV", below, label)
        modulus = self.write.label(self.square((U, V)), f"M{label}")
        conjugate = U, self.write.neg(V)
        return lambda above: self.over(self.times(above, conjugate), modulus)

    def square(self, x: ComplexStep) -> int:
        """|x|^2"""
        real, imag = x
        real_square = self.write.mul(real, real)
        return self.write.add(real_square, self.write.mul(imag, imag))

    def pair(self, real: int | Rational, imag: int) -> ComplexStep:
        """A complex constant."""
        return self.write.expression(Rational(real)), self.write.constant(imag)

    def plus(self, x: ComplexStep, y: ComplexStep) -> ComplexStep:
        """x + y."""
        return self.write.add(x[0], y[0]), self.write.add(x[1], y[1])

    def minus(self, x: ComplexStep, y: ComplexStep) -> ComplexStep:
        """x - y."""
        return self.write.sub(x[0], y[0]), self.write.sub(x[1], y[1])

    def times(self, x: ComplexStep, y: ComplexStep) -> ComplexStep:
        """x y."""
        a, b = x
        c, d = y
        mul = self.write.mul
        real = self.write.sub(mul(a, c), mul(b, d))
        return real, self.write.add(mul(a, d), mul(b, c))

    def over(self, x: ComplexStep, y: int) -> ComplexStep:
        """x / y for a real y."""
        return self.write.div(x[0], y), self.write.div(x[1], y)


def without_sinc_less_one(real: RealFunction) -> tuple[Expr, RealFunction] | None:
    """An angle a and a function f, where f (sin(a)/a - 1) is the given one, as with a
    sample-and-hold; None where the given function has no such factor."""
    axis = real.axis
    f = real.function
    tangents = axis.context.gens()[axis.size :]
    for angle, t in zip(axis.angles, tangents, strict=False):
        if angle.constant or f.is_zero:
            continue
        # With t = tan(a/2), sin a = 2 t/(1 + t^2): sin(a) - a has this numerator.
        a = axis.convert(angle.rate * omega)
        circle = 1 + t**2
        factor = 2 * t * a.denominator - circle * a.numerator
        above, remainder = divmod(f.numerator, factor)
        if remainder.is_zero():
            other = axis.function(above * circle * a.numerator, f.denominator)
            return angle.rate * omega, RealFunction(other.reduced())
    return None


def less_one(gain: RationalFunction) -> RationalFunction:
    """A gain minus 1, as one fraction: nothing cancels near 1."""
    return (gain - gain.ring.one).reduced()


def runs(
    matrices: Sequence[Sequence[RationalFunction]],
) -> list[list[tuple[RationalFunction, ...]]]:
    """Series effects that follow each other together, as (G, 0, 0, 1); everything else alone."""
    runs: list[list[tuple[RationalFunction, ...]]] = []
    for matrix in matrices:
        if not _is_series(matrix):
            runs.append([tuple(matrix)])
            continue
        A, _, _, D = matrix
        ring = A.ring
        gain = (A / D).reduced()
        row = (gain, ring.zero, ring.zero, ring.one)
        if runs and _is_series(runs[-1][0]):
            runs[-1].append(row)
        else:
            runs.append([row])
    return runs


def _is_series(matrix: Sequence[RationalFunction]) -> bool:
    """Whether an effect (A, B, C, D) multiplies a dynamics by a gain A/D."""
    _, B, C, _ = matrix
    return B.is_zero and C.is_zero


def closed_program(
    forms: Mapping[str, RealFunction], dynamics: Iterable[Polynomial], inputs: Sequence[Symbol]
) -> Program:
    """The program of some closed forms by name, of the ratios those of their squares.

    ``dynamics`` : the irreducible factors of H_env and of the denominators, polynomials in s.
    ``inputs`` : the parameters.

    >>> from haptisym import effects, environments
    >>> from haptisym.model.distortion import distort
    >>> d = distort(environments.maxwell(90, 4), effects.first_order_lag(20))
    >>> closed_program(d.functions(["ratio_real"]), [d.env.denominator], ()).results.keys()
    dict_keys(['ratio_real'])
    """
    author = _ClosedForms(Writer((omega, *inputs)))
    any_form = next(iter(forms.values()))
    author.moduli = list(author.squares(any_form.axis, dynamics))
    results = {}
    for name, f in forms.items():
        of_form = author.root if name.startswith("ratio") else author.quotient
        results[name] = of_form(f)
    return author.write.program(results)


@dataclass(frozen=True)
class _Modulus:
    """A squared modulus: as a polynomial with leading coefficient 1, that coefficient, and the step
    that computes it."""

    monic: Polynomial
    lead: fmpq
    step: int


class _ClosedForms(Author):
    """Writes closed forms, with squared moduli of the dynamics in place of equal factors."""

    moduli: Sequence[_Modulus] = ()

    def squares(self, axis: Axis, dynamics: Iterable[Polynomial]) -> Iterator[_Modulus]:
        """|R + j X|^2 for each factor of the dynamics that is not a square already."""
        for p in dynamics:
            [(R, X)] = axis.parts([p])
            if R.is_zero() or X.is_zero():
                continue
            # Written as a function R/X to take both in half angles at once; a factor that both
            # share is divided out.
            halves = axis.function(R, X)
            if axis.angles:
                halves = axis.half_angles(halves)
            common = halves.numerator.gcd(halves.denominator)
            R = halves.numerator / common
            X = halves.denominator / common
            whole = R**2 + X**2
            lead = whole.leading_coefficient()
            real = self.write.polynomial(halves.ring, R)
            imag = self.write.polynomial(halves.ring, X)
            yield _Modulus(whole / lead, lead, self.square((real, imag)))

    def product(self, ring: PolynomialRing, polynomial: Polynomial) -> int:
        unit, factors = self.factors_of(ring, polynomial)
        total = self.write.expression(unit)
        for step, n, _ in factors:
            total = self.write.mul(total, self.write.power(step, n))
        return total

    def root(self, square: RealFunction) -> int:
        """The step of the root of a real function that is nowhere negative: of each square in it,
        the magnitude."""
        # In the square of a ratio such a factor comes twice.
        hold = without_sinc_less_one(square)
        twice = hold and without_sinc_less_one(hold[1])
        if twice:
            angle, rest = twice
            size = self.write.abs(self.write.expression(sincm1(angle)))
            return self.write.mul(size, self.root(rest))
        f = square.half_angled.cleared()
        above = self.root_of(f.ring, f.numerator)
        return self.write.div(above, self.root_of(f.ring, f.denominator))

    def root_of(self, ring: PolynomialRing, polynomial: Polynomial) -> int:
        """The step of the root of a polynomial, as the product of the roots of its factors."""
        # An even power of a factor needs no root, only its magnitude.
        write = self.write
        unit, factors = self.factors_of(ring, polynomial)
        total = write.expression(sqrt(unit))
        for step, n, positive in factors:
            size = step if positive else write.abs(step)
            total = write.mul(total, write.power(size, n // 2))
            if n % 2:
                total = write.mul(total, write.sqrt(size))
        return total

    def factors_of(
        self, ring: PolynomialRing, polynomial: Polynomial
    ) -> tuple[Any, list[tuple[int, int, bool]]]:
        """A number; and of each factor its step, its exponent, and whether the step is nowhere
        negative as it is written."""
        unit, factors = ring.factors(polynomial) if polynomial else (Integer(0), [])
        written = []
        for factor, n in factors:
            # Factors are known up to a number, so both are compared with leading coefficient 1;
            # what the modulus has more or less goes to the number in front.
            lead = factor.leading_coefficient()
            modulus = next((x for x in self.moduli if x.monic * lead == factor), None)
            if modulus:
                ratio = lead / modulus.lead
                unit *= Rational(int(ratio.p), int(ratio.q)) ** n
                written.append((modulus.step, n, True))
            else:
                written.append((self.write.polynomial(ring, factor), n, False))
        return unit, written
