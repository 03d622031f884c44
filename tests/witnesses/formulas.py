"""Formulas to set and to read back, and the proof that two of them are the same."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

import sympy as sp
from hypothesis import strategies as st
from sympy import Abs, Expr, Function, I, Integer, Pow, Rational, Symbol, pi

import haptisym as hs
from haptisym.kernel.harmonics import Harmonic, named_harmonics
from haptisym.kernel.rings import PolynomialRing, omega, s
from haptisym.pages.scene import ClosedForms

m, b, k, omega_n, zeta, omega_c, tau, J_w = hs.symbols("m b k omega_n zeta omega_c tau J_w")
ATOMS = [m, b, k, omega_n, omega_c, zeta, J_w, tau, s, omega, Symbol("p"), Symbol("q", real=True), Symbol("k_1")]
_NUMBERS = st.one_of(
    st.integers(-9, 9).map(Integer),
    st.fractions(-20, 20, max_denominator=12).map(lambda x: Rational(x.numerator, x.denominator)),
    st.decimals(-9, 9, places=3).map(lambda x: Rational(str(x))),
    st.just(pi),
)


def _combined(parts: st.SearchStrategy[Expr]) -> st.SearchStrategy[Expr]:
    several = st.lists(parts, min_size=2, max_size=4)
    powers = st.builds(Pow, parts.filter(lambda x: x != 0), st.sampled_from([2, 3, -1, -2]))
    return st.one_of(several.map(lambda x: sp.Add(*x)), several.map(lambda x: sp.Mul(*x)), powers, parts.map(Abs))


EXPRESSIONS = st.recursive(st.sampled_from(ATOMS) | _NUMBERS, _combined, max_leaves=12).filter(
    lambda x: not x.has(sp.zoo, sp.nan, sp.oo)
)


@cache
def closed_forms(name: str) -> list[Expr]:
    """Every closed form that the package hands out for a shipped scene, in symbols and in numbers.

    First harmonics have their names, as on a page.
    """
    scene = hs.load_scene(name)
    found: list[Expr] = []
    for d in (scene.symbolic_distortion(), scene.distortion()):
        forms = ClosedForms(d)
        groups = [forms.dynamics(), forms.difference(), forms.ratios(), forms.relative(), forms.parameter_jnds()]
        groups += [f(x) for f in (forms.properties, forms.forces) for x in ("env", "perc")]
        found += [row.value for group in groups for row in group]
        found += [x for x in (d.changeover_environment, d.changeover_perceived) if x is not None]
    names, _ = named_harmonics({x for form in found for x in form.atoms(Harmonic)}, ())
    # The readers know no function of two arguments.
    return [x.xreplace(names) for x in found if not x.has(sp.atan2)]


def are_identical(one: Expr, other: Expr) -> bool:
    """Whether two formulas are the same function: proven by polynomials, each root, modulus and function one more variable.

    Roots may have been taken together: then their squares are the same, and so is their sign, at one place and hence at all.
    Roots within roots have more than one shape: there the values at one place must agree to sixty digits.
    """
    if one == other or _same(one, other) or (_same(one**2, other**2) and _is_one(one / other)):
        return True
    return _has_nested_roots(other) and _is_one(one / other)


def _is_one(expr: Expr) -> bool:
    """Whether the value at some place is 1, to sixty digits."""
    found = sorted(expr.free_symbols, key=str)
    value = expr.xreplace({x: Rational(37 + 29 * i, 100) for i, x in enumerate(found)}).evalf(80)
    return bool(abs(value - 1) < Rational(1, 10**60))


def _has_nested_roots(expr: Expr) -> bool:
    return any(
        any(y.exp.is_Rational and not y.exp.is_Integer for y in x.base.atoms(Pow))
        for x in expr.atoms(Pow)
        if x.exp == sp.S.Half
    )


def _same(one: Expr, other: Expr) -> bool:
    known: dict[Expr, Symbol] = {}
    one, other = (_algebraic(x, known) for x in (one, other))
    ring = PolynomialRing(omega, (one.free_symbols | other.free_symbols) - {omega})
    return bool(ring.convert(one).equals(ring.convert(other)))


def _algebraic(expr: Expr, known: dict[Expr, Symbol]) -> Expr:
    """The same with a symbol for each part that is no quotient of polynomials; parts with equal arguments share it."""
    if expr == I or isinstance(expr, Function) or (isinstance(expr, Pow) and not expr.exp.is_Integer):
        key = expr.func(*map(sp.expand, expr.args)) if expr.args else expr
        return known.setdefault(key, Symbol(f"g{len(known)}"))
    return expr.func(*(_algebraic(x, known) for x in expr.args)) if expr.args else expr


def key(name: str) -> str:
    """A symbol's name without what only says how to set it, as the readers see it."""
    word, _, rest = name.partition("_")
    return {"force": "F", "amplitude": "A"}.get(word, word) + rest.replace("_", "")


def by_key(expr: Expr) -> Mapping[str, Symbol]:
    """The symbols of a formula by the names that a reader finds."""
    found = {key(x.name): x for x in expr.free_symbols}
    assert len(found) == len(expr.free_symbols)
    return found


def value_at(expr: Expr) -> Expr:
    """The exact value where every symbol, and pi, is some rational number."""
    places = {x: Rational(37 + 29 * i, 100 + 7 * i) for i, x in enumerate(ATOMS)}
    return expr.xreplace({**places, pi: Rational(333, 106)})
