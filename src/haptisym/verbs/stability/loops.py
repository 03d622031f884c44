"""A display in a hand with one number left open: its characteristic function C(s; q), and where on its way C meets the axis."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import flint
from flint import fmpq
from sympy import Expr, Integer, Rational, Symbol

from haptisym.judge.passiveparts import rests
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.monomials import monomials
from haptisym.kernel.reals import ExactNumber, RealNumber, expression_ball
from haptisym.kernel.response import RealFunction
from haptisym.kernel.rings import Polynomial, RationalFunction, degree_in
from haptisym.kernel.rootcount import Roots
from haptisym.kernel.roots import chart, sign_of_number
from haptisym.kernel.squares import Row
from haptisym.kernel.symbols import omega
from haptisym.kernel.terms import terms_of
from haptisym.model.hand import Hand
from haptisym.model.knobs import Knob
from haptisym.model.parameters import Rule, values
from haptisym.model.scene import Scene
from haptisym.verbs.stability.held import zeros_of

ALLOWED: dict[Rule, tuple[Expr | None, Expr | None, bool]] = {
    Rule.POSITIVE: (Integer(0), None, False),
    Rule.NONNEGATIVE: (Integer(0), None, True),
    Rule.ANY: (None, None, True),
    Rule.FRACTION: (Integer(0), Integer(1), False),
}
"""The values that a rule allows, and whether its ends belong to them."""


@dataclass(frozen=True)
class Loop:
    """The characteristic function of a display in a hand, over the denominator of H_perc; ``symbol`` stays open in both.

    ``low``, ``high`` : between which values it may be, None where nothing bounds them. ``rests`` : whether with all > 0
    there are no roots in Re s >= 0 but at 0, as a hand that damps holds parts that only take energy.
    """

    ring: Ring
    top: Polynomial
    bottom: Polynomial
    symbol: Symbol
    low: Expr | None = None
    high: Expr | None = None
    rests: bool = False

    @classmethod
    def of(cls, scene: Scene, hand: Hand, free: Knob) -> Loop:
        """With ``free`` left open: a number of the hand, or of the display."""
        display = scene.chain.at(values(x for x in scene.parameters if x.path != free.path))
        Z = hand.dynamics.xreplace(values(p for p in hand.parameters if p.symbol != free.symbol))
        ring = Ring.of([*display.entries(), Z])
        H = display.perceived(range(len(display.matrices)), ring)
        z = ring.convert(Z)
        top = H.numerator * z.denominator + z.numerator * H.denominator
        low, high, _ = ALLOWED[free.rule]
        damps = hand.b.symbol == free.symbol or sign_of_number(hand.b.value) > 0
        return cls(
            ring, top, H.denominator, free.symbol, low, high, low is not None and damps and rests(scene, display)
        )

    @cached_property
    def turns(self) -> bool:
        """Whether the open number is in a delay, or in a power of s."""
        return any(self.symbol in x.free_symbols for x in (*self.ring.lags, *self.ring.orders))

    @property
    def _index(self) -> int:
        return self.ring.meanings.index(self.symbol)

    @cached_property
    def powers(self) -> list[Polynomial]:
        """C by ascending powers of the open number."""
        return coefficients(self.top, self._index if self.symbol in self.ring.meanings else None)

    def at(self, value: Rational) -> Roots:
        """The roots in Re s >= 0 at a number."""
        if self.turns:
            known = {self.symbol: value}
            meanings = [x.xreplace(known) for x in self.ring.meanings]
            ring = Ring.of(meanings)
            images = [ring.convert(x) for x in meanings]
            H = (_mapped(self.top, images) / _mapped(self.bottom, images)).reduced()
            return zeros_of(H.numerator, H.denominator, ring, rests=self.rests and value > 0)
        if self.symbol not in self.ring.meanings:
            return zeros_of(self.top, self.bottom, self.ring, rests=self.rests)
        here = {f"x{self._index}": fmpq(int(value.p), int(value.q))}
        found = RationalFunction(self.ring, self.top.subs(here), self.bottom.subs(here)).reduced()
        return zeros_of(found.numerator, found.denominator, self.ring, rests=self.rests and value > 0)

    def exists(self, value: Rational) -> bool:
        """Whether there is a dynamics at a number: not where it is divided by 0."""
        if self.turns or self.symbol not in self.ring.meanings:
            return True
        return not self.bottom.subs({f"x{self._index}": fmpq(int(value.p), int(value.q))}).is_zero()

    @cached_property
    def table(self) -> dict[Rational, dict[tuple[int, ...], Row]]:
        """By the power of s and by how often each unit delay is in it, by ascending powers of the open number."""
        found = [terms_of(p, self.ring) if p else {} for p in self.powers]
        table: dict[Rational, dict[tuple[int, ...], Row]] = {}
        for i, terms in enumerate(found):
            for power, group in terms.items():
                for turns, c in group.items():
                    table.setdefault(power, {}).setdefault(turns, [Integer(0)] * len(found))[i] = c
        return table

    @property
    def leading(self) -> dict[tuple[int, ...], Row]:
        """Of the table, the highest power of s; UndecidedError where an open order leaves that open."""
        if not any(self.symbol in x.free_symbols for x in self.ring.orders):
            return self.table[max(self.table)]
        ends = [{self.symbol: x} for x in (self.low, self.high) if x is not None]
        for (
            power,
            group,
        ) in self.table.items():  # a power is linear in an order: it is the highest between two ends as at both
            ahead = [[(power - x).xreplace(end) for end in ends] for x in self.table if x != power]
            if len(ends) == 2 and all(min(row) >= 0 and max(row) > 0 for row in ahead):
                return group
        raise UndecidedError("where roots meet the imaginary axis as a power of s changes")


def _mapped(polynomial: Polynomial, images: Sequence[RationalFunction]) -> RationalFunction:
    """A polynomial with other functions for its variables; SymPy would make one delay of a product of two."""
    total = images[0].ring.zero
    for exponents, value in monomials(polynomial):
        term = total.ring.function(total.ring.context.constant(value))
        for image, n in zip(images, exponents, strict=True):
            term = term * image ** int(n)
        total = total + term
    return total


def zeros(row: Sequence[Expr]) -> list[RealNumber]:
    """The zeros >= 0 of a polynomial with ascending coefficients; those of a linear one whatever their sign."""
    while row and row[-1] == 0:
        row = row[:-1]
    if len(row) < 2:
        return []
    if len(row) == 2:
        return [ExactNumber(-row[0] / row[1])]
    ring = Ring().axis
    f = RealFunction(ring.convert(sum((c * omega**n for n, c in enumerate(row)), Integer(0))))
    with flint.ctx.workprec(128):
        bound = max(abs(expression_ball(c / row[-1])).upper() for c in row[:-1]) + 1
    table = chart({"": f}, Integer(0), Integer(int(bound.ceil().unique_fmpz())))
    return [x.omega for x in table.points if x.orders.get("")]


def coefficients(polynomial: Polynomial, index: int | None) -> list[Polynomial]:
    """By ascending powers of one variable; one alone where there is none."""
    if index is None:
        return [polynomial]
    rows: list[dict[tuple[int, ...], object]] = [{} for _ in range(degree_in([polynomial], index) + 1)]
    for exponents, value in polynomial.to_dict().items():
        own = [int(n) for n in exponents]
        power, own[index] = own[index], 0
        rows[power][tuple(own)] = value
    context = polynomial.context()
    return [context.from_dict(row) for row in rows]
