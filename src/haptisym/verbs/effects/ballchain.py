"""A scene along its band in ball arithmetic: on each piece of the band a power series whose coefficients are proven.

A chain is carried out on force and position themselves, ``[F; X] = T [F_e; X_e]`` with polynomial entries, so that nothing is
divided, expanded or cancelled before the end, and a subset of the effects costs no more than its matrices. H_env is taken
without its zeros on the axis: a free mass at omega = 0 and a resonance without damping, where ratios are limits, are
as good as any other place.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, TypeAlias

import flint
from flint import acb, acb_series, arb, arb_series
from sympy import Expr, Pow, Rational, exp

from haptisym.kernel.dynamics import Ring
from haptisym.kernel.reals import Ball, expression_ball
from haptisym.kernel.rings import Polynomial, RationalFunction, cleared
from haptisym.kernel.shown import Shown, counted
from haptisym.kernel.symbols import s
from haptisym.model.distortion import Chain
from haptisym.model.jnd import Part
from haptisym.model.scene import Scene

Series: TypeAlias = Any  # flint's acb_series and arb_series, which ship no types
Kept: TypeAlias = frozenset[int]
"""The effects of a scene that are there, by their places in it."""

TERMS = 6
"""Of a power series in the middle of a piece; its next term over the whole piece bounds the rest."""
_BITS, _LONGEST, _REMEMBERED = 96, 64, 1 << 13


@contextmanager
def series_arithmetic() -> Iterator[None]:
    """The precision and length of series that a ``BallChain`` needs; what was set before is restored."""
    longest = flint.ctx.cap
    with flint.ctx.workprec(_BITS):
        flint.ctx.cap = _LONGEST
        try:
            yield
        finally:
            flint.ctx.cap = longest


@dataclass(frozen=True, slots=True)
class Piece:
    """One of the 2^depth equal pieces of a band, counted from its low end."""

    depth: int = 0
    index: int = 0

    def halves(self) -> tuple[Piece, Piece]:
        return Piece(self.depth + 1, 2 * self.index), Piece(self.depth + 1, 2 * self.index + 1)


class BallChain(Shown):
    """A scene whose parameters are numbers, to be evaluated for any subset of its effects on pieces of its band.

    To be used within ``series_arithmetic``. Series are in the distance from the middle of a piece, rad/s: with their
    coefficients there, or with those that hold everywhere on the piece (``whole``).
    """

    def _line(self) -> str:
        return f"of {counted(len(self.chain.matrices), 'effect')} in ball arithmetic"

    def __init__(self, scene: Scene) -> None:
        self.low, self.width = scene.band[0], scene.band[1] - scene.band[0]
        rendered = scene.rendered or scene.environment
        self.chain = Chain(scene.environment.H, rendered.H, tuple(e.matrix for e in scene.effects))
        self.ring = self.chain.ring
        environment, source = (self.ring.convert(H).reduced() for H in (self.chain.environment, self.chain.rendered))
        zeros = self.ring.function(_axis_zeros(self.ring, environment.numerator))
        with series_arithmetic():
            self.band = expression_ball(self.low), expression_ball(self.width)
            self.environment = self._block([environment / zeros, self.ring.one])
            self.source = self._block([source / zeros, self.ring.one])
            self.effects = [self._effect(matrix, zeros) for matrix in self.chain.matrices]
        self.turn = acb(0, 1) ** int(zeros.numerator.deflation_index()[1][0])
        self.place = lru_cache(_REMEMBERED)(self._place)
        self.perceived = lru_cache(_REMEMBERED)(self._perceived)
        self.felt = lru_cache(_REMEMBERED)(self._felt)

    @property
    def everything(self) -> Kept:
        """All effects of the scene."""
        return frozenset(range(len(self.effects)))

    def _effect(self, matrix: Sequence[Expr], zeros: RationalFunction) -> _Block:
        a, b, c, d = (self.ring.convert(entry) for entry in matrix)
        return self._block([a, b / zeros, c * zeros, d])

    def _block(self, entries: Sequence[RationalFunction]) -> _Block:
        polynomials = cleared([x.reduced() for x in entries])
        order = min(self.ring.order_at_0(p) for p in polynomials)
        return _Block(tuple(_form(self.ring, p) for p in polynomials), int(order))

    def ends(self, piece: Piece) -> tuple[Expr, Expr]:
        """The exact ends of a piece, rad/s."""
        low, high = (self.low + self.width * Rational(piece.index + i, 2**piece.depth) for i in (0, 1))
        return low, high

    def middle(self, piece: Piece) -> Ball:
        low, width = self.band
        return low + width * arb(2 * piece.index + 1) * arb(2) ** (-piece.depth - 1)

    def radius(self, piece: Piece) -> Ball:
        """Half the width of a piece, rounded up."""
        return (self.band[1] * arb(2) ** (-piece.depth - 1)).upper()

    def _place(self, piece: Piece, whole: bool) -> _Place:  # noqa: FBT001 - as in all that is remembered by piece
        x = self.middle(piece)
        return _Place(self.ring, x + arb(0, self.radius(piece)), TERMS + 1) if whole else _Place(self.ring, x, TERMS)

    def _perceived(self, piece: Piece, whole: bool, kept: Kept) -> Series:  # noqa: FBT001
        """H_perc over the zeros of H_env, with some of the effects."""
        place = self.place(piece, whole)
        force, position = place.values(self.source)
        for i in sorted(kept):
            a, b, c, d = place.values(self.effects[i])
            force, position = _dot(a, force, b, position), _dot(c, force, d, position)
        return _quotient(force, position, place.terms)

    def _felt(self, piece: Piece, whole: bool) -> tuple[Series, Series]:  # noqa: FBT001
        """H_env over its zeros, and what its modulus divides by."""
        place = self.place(piece, whole)
        above, below = place.values(self.environment)
        H = _quotient(above, below, place.terms)
        re, im = _parts(H)
        return H, (re * re + im * im).rsqrt()

    def changes(self, piece: Piece, kept: Kept, part: Part, *, whole: bool) -> tuple[Series, Series]:
        """(a - b)/``|H_env|`` and (a + b)/``|H_env|``, where a and b are a part of dH with all effects and with some."""
        full, some = (self.perceived(piece, whole, which) for which in (self.everything, kept))
        H, scale = self.felt(piece, whole)
        both = (_parts(x * self.turn) for x in (full - some, full + some - 2 * H))
        minus, plus = (re if part is Part.REAL else im for re, im in both)
        return minus * scale, plus * scale


def _dot(a: Series | None, x: Series | None, b: Series | None, y: Series | None) -> Series | None:
    """a x + b y, where None is 0."""
    first = None if a is None or x is None else a * x
    second = None if b is None or y is None else b * y
    return first if second is None else second if first is None else first + second


def _quotient(above: Series | None, below: Series | None, terms: int) -> Series:
    """Their quotient, not a number where the denominator may vanish."""
    if below is None or below[0].contains(0):
        return acb_series([acb(arb.nan(), arb.nan())] * terms, prec=terms)
    return acb_series([0], prec=terms) if above is None else above / below


def _parts(x: Series) -> tuple[Series, Series]:
    """Real and imaginary part of a series in a real variable."""
    coefficients = x.coeffs()
    real, imag = ([getattr(c, part) for c in coefficients] for part in ("real", "imag"))
    return arb_series(real, prec=x.prec), arb_series(imag, prec=x.prec)


_Form: TypeAlias = dict[tuple[int, ...], list[Ball]]
"""A polynomial in s: its coefficients, ascending, for each product of delays and powers s^alpha."""


@dataclass(frozen=True, eq=False)
class _Block:
    """Polynomials without a common denominator, all of which vanish at s = 0 to this order."""

    forms: tuple[_Form, ...]
    order: int


def _form(ring: Ring, polynomial: Polynomial) -> _Form:
    found: _Form = {}
    for exponents, coefficient in polynomial.to_dict().items():
        power, of_pi, *others = map(int, exponents)
        row = found.setdefault(tuple(others[ring.size - 2 :]), [])
        row.extend([arb(0)] * (power + 1 - len(row)))
        row[power] = row[power] + arb(coefficient) * arb.pi() ** of_pi
    return found


class _Place:
    """A frequency, or a ball of frequencies, with what is known of the scene there."""

    def __init__(self, ring: Ring, x: Ball, terms: int) -> None:
        self.ring, self.x, self.terms = ring, x, terms
        self.known: dict[_Block, tuple[Series | None, ...]] = {}

    def values(self, block: _Block) -> tuple[Series | None, ...]:
        """The entries of a block as series, up to a common factor; None for one that is 0."""
        if block not in self.known:
            order = block.order if self.x.contains(0) else 0
            self.known[block] = tuple(self._value(form, order) for form in block.forms)
        return self.known[block]

    def _value(self, form: _Form, order: int) -> Series | None:
        """A polynomial over omega^order. At 0 that shifts its series, as f(x)/x is a mean of f' between 0 and x."""
        if not form:
            return None
        terms = self.terms + order
        at = acb_series([acb(0, self.x), acb(0, 1)], prec=terms)
        total = acb_series([0], prec=terms)
        for functions, coefficients in form.items():
            term = acb_series([0], prec=terms)
            for coefficient in reversed(coefficients):
                term = term * at + acb(coefficient)
            for meaning, n in zip(self.ring.functions, functions, strict=True):
                for _ in range(n):
                    term = term * _generator(meaning, at)
            total = total + term
        return acb_series(total.coeffs()[order:], prec=self.terms) if order else total


def _generator(meaning: Expr, at: Series) -> Series:
    """A delay exp(-s tau), a power s^alpha or j as a series."""
    if isinstance(meaning, exp):
        return (at * acb(expression_ball(meaning.args[0].coeff(s)))).exp()
    if isinstance(meaning, Pow):
        return (at.log() * acb(expression_ball(meaning.exp))).exp()
    return acb_series([acb(0, 1)], prec=at.prec)


def _axis_zeros(ring: Ring, polynomial: Polynomial) -> Polynomial:
    """The factors of a polynomial that can vanish on s = j omega: s itself, and those in s^2."""
    found = ring.constant(1)
    for factor, n in ring.factors(polynomial, in_square=False)[1]:
        even = not any(int(exponents[0]) % 2 for exponents in factor.to_dict())
        if factor == ring.variable or (even and not any(factor.degrees()[2:])):
            found = found * factor**n
    return found
