"""How is an exact polynomial of a scene read as a family: a polynomial for floats whose
coefficients depend on the swept parameters?

**Given** is a polynomial in omega (or s), pi, the parameters, powers omega^alpha, and for each
angle a = omega tau of a delay cos(a/2) and sin(a/2)/omega, the variables of ``Axis.half_angles``.
(The sine is over omega, so that nothing cancels at low frequencies.) Of an angle that does not
depend on omega, as alpha pi/2, they are cosine and sine of the half angle themselves.

**Read** is the same function in the variables of ``delayterms``, all between -1 and 1: x =
(omega/scale)^step, C = cos(k x), S = sin(k x)/(k x) and z = x^alpha, with k the half angle at omega
= scale, the band's high end, and step 1 where there are waves. So

    omega^n = scale^n x^(n/step),      omega^alpha = scale^alpha z,
    cos(a/2) = C,                      sin(a/2)/omega = (tau/2) S.

The factors before these are gathered in the constant of each term, in balls, and rounded once, with
its exponents of the parameters (tau may hold some). Begin with ``FamilyReader.family``.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import flint
from flint import arb
from sympy import Expr, S, Symbol

from haptisym.kernel.dynamics import RealFunction
from haptisym.kernel.reals import expression_ball
from haptisym.kernel.rings import Polynomial, PolynomialRing
from haptisym.verbs.sweep.batch import BITS, Monomial, monomial
from haptisym.verbs.sweep.delayterms import Exponents, Family, Variables


class FamilyReader:
    """Reads polynomials of a ring, the ``parameters`` being the only symbols in them, as families
    on x = (omega/scale)^step; of a ring in s, as one in s, with scale and step 1.

    ``function`` : one whose axis has the angles and powers that are variables of the ring; None
    where there are none.
    """

    def __init__(
        self,
        parameters: Sequence[Symbol],
        scale: Expr,
        step: int = 1,
        function: RealFunction | None = None,
    ) -> None:
        self.parameters = tuple(parameters)
        self.scale, self.step = scale, step
        self.orders = function.axis.orders if function else ()
        self.angles = function.axis.angles if function else ()
        self.ring = function.half_angled.ring if function else None

    def constant(self, value: Monomial) -> Family:
        """The family of degree 0 in all variables whose only coefficient is this monomial."""
        degree_0 = (0,) * (1 + self._variables.waves)
        return Family((value,), self._variables, (degree_0,))

    def family(self, ring: PolynomialRing, polynomial: Polynomial, factor: Expr = S.One) -> Family:
        """The family of ``factor``, a number, times a polynomial of a ring.

        The exponents of a monomial of the ring are those of omega (or s), pi, its parameters,
        omega^alpha of each order, then for each angle a in turn of cos(a/2) and sin(a/2)/omega, or
        sin(a/2) for a constant angle. UndecidedError where too few digits of a constant are known.
        """
        index_of = {x: i for i, x in enumerate(ring.meanings)}
        parameter_indices = [index_of.get(x) for x in self.parameters]
        with flint.ctx.workprec(BITS):
            unit = expression_ball(factor)
            constants: dict[tuple[Exponents, Exponents], arb] = {}
            # Several terms may have one monomial, as powers of pi are constants here. They are
            # added in balls: of floats that cancel no bound on the roundings would be left.
            for given, coefficient in polynomial.to_dict().items():
                row, exponents, ball = self._term(
                    [int(n) for n in given], parameter_indices, ring.size
                )
                constant = ball * arb(coefficient) * unit
                key = row, exponents
                constants[key] = constants.get(key, arb(0)) + constant
            rows = sorted({row for row, _ in constants})
            index_of_row = {row: i for i, row in enumerate(rows)}
            terms: list[tuple[int, Exponents, Any]] = []
            for (row, exponents), ball in constants.items():
                if ball != 0:
                    terms.append((index_of_row[row], exponents, ball))
            terms.sort()
            coefficients = tuple(monomial(*term) for term in terms)
            return Family(coefficients, self._variables, tuple(rows))

    def _term(
        self, given: Sequence[int], parameter_indices: Sequence[int | None], start: int
    ) -> tuple[Exponents, Exponents, Any]:
        """A monomial of a ring, read as constant * parameters^exponents * variables^row: the row,
        the exponents, and a ball around the constant.

        The row of a family has the exponents of x, then of C and S for each angle that depends on
        omega, then of z for each order.
        ``given`` : its exponents, as in ``family``. ``parameter_indices`` : where those of the
        parameters stand; None for one that the ring does not have. ``start`` : where those of the
        omega^alpha begin.
        """
        # omega^n = scale^n x^(n/step): the step is 2 only where all powers of omega are even.
        assert not given[0] % self.step
        scale = expression_ball(self.scale)
        exponents = [given[i] if i is not None else 0 for i in parameter_indices]
        ball = arb.pi() ** given[1]
        ball *= scale ** given[0]
        after_powers = start + len(self.orders)
        powers, waves = given[start:after_powers], given[after_powers:]
        for order, n in zip(self.orders, powers, strict=True):
            ball *= (scale.log() * expression_ball(order)).exp() ** n
        wave_exponents: list[int] = []
        for angle, cosines, sines in zip(self.angles, waves[::2], waves[1::2], strict=True):
            if angle.constant:
                half = expression_ball(angle.rate) / 2
                ball *= half.cos() ** cosines * half.sin() ** sines
                continue
            # The ring has sin(a/2)/omega, the family S = sin(a/2)/(a/2): half the rate times it.
            constant, of_rate = self._half_rate(angle.rate)
            ball *= constant**sines
            exponents = [n + sines * m for n, m in zip(exponents, of_rate, strict=True)]
            wave_exponents += [cosines, sines]
        row = (given[0] // self.step, *wave_exponents, *powers)
        return row, tuple(exponents), ball

    def _half_rate(self, rate: Expr) -> tuple[Any, Exponents]:
        """Half of an angle's rate as a number times powers of the parameters: a ball around the
        number, and the exponents."""
        assert self.ring
        index_of = {x: i for i, x in enumerate(self.ring.meanings)}
        f = self.ring.convert(rate).reduced()
        [(given, coefficient)] = f.numerator.to_dict().items()
        quotient = arb(coefficient) / arb(f.denominator.leading_coefficient())
        ball = quotient * arb.pi() ** int(given[1]) / 2
        indices = [index_of.get(x) for x in self.parameters]
        return ball, tuple(int(given[i]) if i is not None else 0 for i in indices)

    @cached_property
    def _variables(self) -> Variables:
        """The rates of the angles that depend on omega, over the band's high end, and the orders of
        powers."""
        rates = []
        with flint.ctx.workprec(BITS):
            scale = expression_ball(self.scale)
            for angle in self.angles:
                if not angle.constant:
                    ball, exponents = self._half_rate(angle.rate)
                    rates.append(monomial(0, exponents, ball * scale))
        return Variables(tuple(rates), tuple(float(x) for x in self.orders))
