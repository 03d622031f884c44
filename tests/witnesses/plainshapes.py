"""Conditions over cells of values from plain formulas in omega and q, and steps of a search that are written down by hand."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from flint import arb
from sympy import Expr, Rational, Symbol

from haptisym.kernel.dynamics import RealFunction, Ring, on_axis
from haptisym.kernel.rings import s
from haptisym.verbs.require.limitingpoints import Shape, Strip, Strips

q = Symbol("q", positive=True)
"""The parameter of all of them."""


def function_of(x: Expr) -> RealFunction:
    """A formula in omega and q."""
    return RealFunction(Ring.of([q * s]).axis.convert(x))


def real_part(x: Expr) -> RealFunction:
    """Of a formula in s and q at s = j omega."""
    return on_axis(Ring.of([x, q * s]).convert(x)).real


def shape_of(x: Expr) -> Shape:
    return Shape.of(function_of(x), q)


def exact(x: Fraction | int) -> Any:
    """A ball around a fraction; a dyadic one without radius."""
    own = Fraction(x)
    return arb(own.numerator) / own.denominator


def rational(x: Fraction | int) -> Rational:
    own = Fraction(x)
    return Rational(own.numerator, own.denominator)


def strip_of(x: Expr, low: Fraction, high: Fraction) -> Strip:
    return Strip.of(shape_of(x), exact(low), exact(high))


def strips_of(low: Fraction, high: Fraction, *formulas: Expr) -> Strips:
    return Strips.of([shape_of(x) for x in formulas], exact(low), exact(high))
