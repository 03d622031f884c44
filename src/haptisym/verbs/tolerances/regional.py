"""The excess of a JND region, or of a limit that depends on the frequency, over cells of band and box, in Taylor models.

A region is the largest of the smallest of smooth functions (``joined``). Of an ellipse it is one, of a diamond two; a polygon has
one for each edge.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeAlias

import numpy as np
from sympy import Expr, Integer, S

from haptisym.judge.criteria import Criterion
from haptisym.judge.regions import Diamond, Ellipse, Polygon, Sided
from haptisym.kernel.symbols import c, omega
from haptisym.model.jnd import Part
from haptisym.programs.modelled import Modelled
from haptisym.programs.program import Program
from haptisym.programs.taylormodels import Array, Model
from haptisym.programs.valued import floated, valued
from haptisym.verbs.tolerances.box import Box
from haptisym.verbs.tolerances.excess import Excess
from haptisym.verbs.tolerances.joined import joined

Terms: TypeAlias = list[list[Model]]
_FIELDS = ("real", "imag", "environment_real", "environment_imag")
_SQUARED = ("squared_real", "squared_imag")


def excess_of(box: Box, criterion: Criterion) -> Excess:
    """What must not be positive of a criterion, over cells."""
    is_plain = criterion.region is None and not criterion.threshold.has(omega)
    return Excess(box, criterion) if is_plain else RegionalExcess(box, criterion)


class RegionalExcess(Excess):
    """Of a criterion with a region, or with a formula in omega as its limit; has the sign and the zeros of what it judges."""

    def __init__(self, box: Box, criterion: Criterion) -> None:
        self._over(box)
        self._criterion, self._limit = criterion, None
        threshold = box.scene.threshold
        if criterion.region and threshold.interval(Part.REAL):  # one for both half widths
            self._criterion = replace(criterion, region=criterion.region.opened(dict.fromkeys(Part, c)))
            self._limit = 1 + self._names.index(box.part_name(Part.REAL))
        chain = box.scene.chain.at(self._fixed)
        relative, _ = chain.without_axis_zeros()
        environments = (chain.ring.convert(x.environment) for x in (chain, relative))
        powers = [int(n) for n, *_ in (next(environments) / next(environments)).reduced().numerator.monoms()]
        if len(powers) > 1 and isinstance(criterion.region, Polygon):  # changes its side where H_env changes its sign
            relative, powers = chain, [0]
        self._turns, self._from_rest = max(powers) % 4, len(powers) == 1
        self._relative, self._plain = relative.program([*_SQUARED, *_FIELDS]), chain.program(_FIELDS)

    @cached_property
    def is_zero(self) -> bool:
        """Whether nothing of what is judged changes anywhere."""
        parts = [self._criterion.part] if self._criterion.part else list(Part)
        steps, results = self._relative.operations, self._relative.results
        return all(steps[results[f"squared_{seen_as(part, self._turns).value}"]].value == 0 for part in parts)

    @cached_property
    def matters(self) -> Array:
        """For omega and each side, whether the excess may depend on it."""
        limit = np.array([i == self._limit for i in range(self.sides)])
        return limit | self._used(self._relative) | self._used(self._plain)

    def model(self, cells: Array, *, slopes: int | None = None) -> Model:
        """The excess over each cell; t_i goes from -1 to 1 along its side i. Unknown where a pole may lie in the cell."""
        slopes = self.order if slopes is None else slopes
        with np.errstate(all="ignore"):  # what is not finite is unknown, which every caller asks about
            at = self._variable(0, cells, slopes=slopes)
            relative, plain = (self._run(x, cells, at, slopes=slopes) for x in (self._relative, self._plain))
            known: dict[Expr, Model] = {omega: at}
            if self._limit is not None:
                known[c] = self._variable(self._limit, cells, slopes=slopes)
            return joined(Changes(relative, plain, known, self._turns, self._from_rest).terms(self._criterion))

    def _run(self, program: Program, cells: Array, at: Model, *, slopes: int) -> dict[str, Model]:
        found = Modelled(program).run([self._variable(i, cells, slopes=slopes) for i in self._places(program)])
        return {name: x if isinstance(x, Model) else at.number(x) for name, x in found.items()}


def seen_as(part: Part, turns: int) -> Part:
    """Which part shows a part of what was turned by a number of quarters."""
    return part if turns % 2 == 0 else Part.IMAG if part is Part.REAL else Part.REAL


@dataclass(frozen=True)
class Changes:
    """x = Re dH/|H_env| and y = Im dH/|H_env| over cells, and what a criterion makes of them.

    ``relative`` : fields of a chain with the same ratios, in which all is ``turns`` quarters behind; ``plain``: of the chain.
    ``known`` : what omega, and the half width c where it varies, are over the cells. ``from_rest`` : whether these chains differ
    by a power of s alone.
    """

    relative: Mapping[str, Model]
    plain: Mapping[str, Model]
    known: Mapping[Expr, Model]
    turns: int
    from_rest: bool = False

    def terms(self, criterion: Criterion) -> Terms:
        """The functions of which the largest of the smallest is positive where a change is noticed."""
        region = criterion.region
        if isinstance(region, Ellipse):
            return [[self._ellipse(region)]]
        if isinstance(region, Diamond):
            return [[self._quadric(region.real, region.imag, Integer(sign))] for sign in (1, -1)]
        if isinstance(region, Polygon):
            x, y = self._xy
            return [[(self._times(p, x) + self._times(q, y)).plus(-1.0)] for p, q in region.edges]
        if isinstance(region, Sided):
            return self._sided(region)
        assert criterion.part
        return [[self._beyond(criterion.part, criterion.threshold)]]

    def _ellipse(self, region: Ellipse) -> Model:
        root = 1 - region.tilt**2
        return self._quadric(region.real, region.imag, -region.tilt, root)

    def _quadric(self, a: Expr, b: Expr, t: Expr, whole: Expr = S.One) -> Model:
        """a b times (x/a)^2 + 2 t (x/a)(y/b) + (y/b)^2 - whole."""
        squares = self._times(b / a, self._square(Part.REAL)) + self._times(a / b, self._square(Part.IMAG))
        found = squares - self._constant(a * b * whole)
        return found if t == 0 else found + self._times(2 * t, self._product)

    def _sided(self, region: Sided) -> Terms:
        own = self.plain[region.part.value]
        larger, smaller = (self._beyond(region.part, x) for x in (region.higher, region.lower))
        least = [] if region.floor is None else [own * own - self._constant(region.floor**2)]
        if not region.has_sides:
            return [[larger, *least]]
        growth = self._growth(region.part)
        return [[growth, larger, *least], [-growth, smaller, *least], [larger, smaller, *least]]

    def _growth(self, part: Part) -> Model:
        """|H_perc|^2 - |H_env|^2 of a part: of what H_env vanishes with at omega = 0 alone nothing is left in it."""
        fields, seen = (self.relative, seen_as(part, self.turns)) if self.from_rest else (self.plain, part)
        return fields[seen.value] * (fields[seen.value] + fields[f"environment_{seen.value}"].times(2.0))

    def _beyond(self, part: Part, limit: Expr) -> Model:
        return self._square(part) - self._constant(limit**2)

    def _square(self, part: Part) -> Model:
        return self.relative[f"squared_{seen_as(part, self.turns).value}"]

    @cached_property
    def _product(self) -> Model:
        """x y."""
        found = self.relative["real"] * self.relative["imag"] / self._modulus
        return -found if self.turns % 2 else found

    @cached_property
    def _modulus(self) -> Model:
        R, X = self.relative["environment_real"], self.relative["environment_imag"]
        return R * R + X * X

    @cached_property
    def _xy(self) -> tuple[Model, Model]:
        size = self._modulus.to_the(self._at.number(0.5))
        x, y = self.relative["real"] / size, self.relative["imag"] / size
        for _ in range(self.turns):
            x, y = -y, x
        return x, y

    def _times(self, factor: Expr, x: Model) -> Model:
        return x * self._constant(factor) if factor.free_symbols else x.times(floated(factor))

    def _constant(self, x: Expr) -> Model:
        return valued(x, self.known, self._at)

    @property
    def _at(self) -> Model:
        return self.known[omega]
