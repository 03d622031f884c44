"""Where a region may, and where it must, be left by a scene whose distortion is known but for a bound on each part.

The changes of Re dH and Im dH, relative to ``|H_env|``, by what was left out are at most e_r and e_i large. Of a region that
judges both parts, how many times it must be enlarged is sublinear: it changes at most by what the box of these changes takes.
Of one part |x| changes at most by e, and ``P^2 - E^2``, P and E that part of H_perc and H_env, whose sign tells whether it
grows, at most by e P^2 + (e + e^2) |H_env|^2; |X| > F + e |H_env| where X^2 > (1 + e) F^2 + (e + e^2) |H_env|^2.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import inf, nextafter, sqrt
from typing import NamedTuple

from sympy import Expr, Rational

from haptisym.judge.peaks import largest
from haptisym.judge.regions import Change, Diamond, Ellipse, Polygon, Region, Sided
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.lattices import Lattice, Signed
from haptisym.kernel.response import RealFunction
from haptisym.kernel.rings import RationalFunction
from haptisym.kernel.symbols import omega
from haptisym.model.distortion import Distortion, part_of
from haptisym.model.jnd import Part, positive

Bounds = Mapping[Part, Rational]
"""Of the change of each part, relative to |H_env|."""


class Levels(NamedTuple):
    """Not positive: the region is not left for certain; ``must`` : positive where it is left for certain."""

    may: Signed | None
    """None where it may be left anywhere."""
    must: Signed


def levels(region: Region, d: Distortion, change: Bounds, band: tuple[Expr, Expr]) -> Levels:
    """The functions of a scene without some effects that tell where the full one may, and must, leave a region."""
    if isinstance(region, Sided):
        return _of_part(region, d, change[region.part], band)
    reach = _reach(region, change, band)
    must = _at(region, d, 1 + reach)
    return Levels(_at(region, d, 1 - reach) if reach < 1 else None, must)


def _at(region: Region, d: Distortion, times: Expr) -> Lattice:
    """Positive where a region must be enlarged more often than that."""
    number = Change(d).number(times**2)
    return Lattice(
        tuple((*x.where, *(RealFunction((f.function - number).reduced()) for f in x.squares)) for x in region.terms(d))
    )


def _reach(region: Region, change: Bounds, band: tuple[Expr, Expr]) -> Rational:
    """How many times a region must be enlarged to hold every change within the bounds; rounded up."""
    e, f = change[Part.REAL], change[Part.IMAG]
    if isinstance(region, Polygon):
        edges = [[_root(_most(x**2, band)) for x in edge] for edge in region.edges]
        return max(p * e + q * f for p, q in edges)
    assert isinstance(region, Diamond | Ellipse)
    u, v = e / region.real, f / region.imag
    if isinstance(region, Diamond):
        return _most(u + v, band)
    return _root(_most((u + v) ** 2 / (1 - region.tilt**2), band))


def _most(x: Expr, band: tuple[Expr, Expr]) -> Rational:
    """The largest value of a number, or of a formula that is never negative, on the band; rounded up."""
    if not x.has(omega):
        return Rational(x)
    found = largest(RealFunction(Ring().axis.convert(x).reduced()), *band)
    assert found is not None  # a region is one on the whole band
    high = found.bounds(60)[1]
    return Rational(high.numerator, high.denominator)


def _root(x: Rational) -> Rational:
    return Rational(nextafter(sqrt(nextafter(float(x), inf)), inf))


def _of_part(x: Sided, d: Distortion, e: Rational, band: tuple[Expr, Expr]) -> Levels:
    w = Change(d)
    own, size = w.part(x.part), w.square
    square = w.over(own * own).function
    spread = w.number(e + e**2) * size
    env, perc = (part_of(f, x.part).function for f in (d.env_response, d.perc_response))
    grown, unsure = perc * perc - env * env, w.number(e) * perc * perc + spread
    floor = [] if x.floor is None else [w.number(x.floor) ** 2]
    far = [w.number(1 + e) * own * own + spread - f for f in floor]
    sure = [own * own - w.number(1 + e) * f - spread for f in floor]

    def above(limit: Expr) -> list[RationalFunction]:
        """|x| above a limit; nothing where the limit is not positive."""
        return [square - w.number(limit) ** 2] if _is_positive(limit, band) else []

    ways = [((), x.higher)] if not x.has_sides else [((grown,), x.higher), ((-grown,), x.lower)]
    may = [[*(g + unsure for g in way), *above(limit - e), *far] for way, limit in ways]
    must = [[*(g - unsure for g in way), *above(limit + e), *sure] for way, limit in ways]
    must.append([*above(x.higher + e), *above(x.lower + e), *sure])
    return Levels(_lattice(may) if all(may) else None, _lattice(must))


def _is_positive(limit: Expr, band: tuple[Expr, Expr]) -> bool:
    return positive(limit, *band) if limit.has(omega) else bool(limit > 0)


def _lattice(terms: list[list[RationalFunction]]) -> Lattice:
    return Lattice(tuple(tuple(RealFunction(f.reduced()) for f in term) for term in terms))
