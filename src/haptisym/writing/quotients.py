"""A product taken apart as it is written: a number, what stands above the line and what stands below it."""

from __future__ import annotations

from sympy import Add, Expr, Mul, Pow, S, sqrt

from haptisym.writing.order import base_of


def fraction(expr: Expr) -> tuple[Expr, list[Expr], list[Expr]]:
    """Number, other factors above and other factors below the line; square roots gathered under one root.

    >>> from sympy import symbols
    >>> k, m = symbols("k m", positive=True)
    >>> fraction(3 * k / m), fraction(2 * sqrt(k / m))
    ((3, [k], [m]), (2, [sqrt(k/m)], []))
    """
    coefficient, rest = expr.as_coeff_Mul()
    above: list[Expr] = []
    below: list[Expr] = []
    for f in Mul.make_args(rest):
        if isinstance(f, Pow) and f.exp.could_extract_minus_sign():
            below.append(Pow(f.base, -f.exp))
        elif f != 1:
            above.append(f)
    roots = [f.base for f in (*above, *below) if _is_root(f)]
    if len(roots) < 2 or sum(not root.is_nonnegative for root in roots) > 1:
        return coefficient, above, below
    return _one_root(coefficient, above, below)


def _one_root(coefficient: Expr, above: list[Expr], below: list[Expr]) -> tuple[Expr, list[Expr], list[Expr]]:
    """The same quotient with one root above the line; the coefficient goes under it if a number is there already."""
    if not any(map(_is_root, above)):
        root = sqrt(Mul(*(f.base for f in below if _is_root(f))), evaluate=False)
        return coefficient, above, [*(f for f in below if not _is_root(f)), root]
    inside = [f.base for f in above if _is_root(f)] + [1 / f.base for f in below if _is_root(f)]
    numbers, others = [x for x in inside if x.is_Rational], Mul(*(x for x in inside if not x.is_Rational))
    under = Mul(Mul(coefficient**2, *numbers), *Mul.make_args(others), evaluate=False) if numbers else others
    root = sqrt(under, evaluate=False)
    outside = (S.One if coefficient > 0 else S.NegativeOne) if numbers else coefficient
    return outside, [*(f for f in above if not _is_root(f)), root], [f for f in below if not _is_root(f)]


def _is_root(factor: Expr) -> bool:
    return isinstance(factor, Pow) and factor.exp == S.Half


def exponent(factor: Expr) -> int:
    """A factor's whole exponent; 0 for any other one."""
    if not isinstance(factor, Pow):
        return 1
    return int(factor.exp) if factor.exp.is_Integer else 0


def is_flippable(factor: Expr) -> bool:
    """Whether a factor is a sum, or a power of one, whose sign can be drawn out."""
    return isinstance(base_of(factor), Add) and exponent(factor) > 0


def flipped(factor: Expr) -> Expr:
    """The same factor with the signs of its sum turned around."""
    return Pow(-base_of(factor), exponent(factor))
