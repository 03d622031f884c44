"""What a criterion judges, over cells of band and parameters, in Taylor models: proven bounds on it
and on its slopes.

The excess r^2 - c^2 of one part is a program of the scene's chain. That of a JND region, or of a
limit that depends on the frequency, is the largest of the smallest of smooth functions, as far as
its sign and its zeros go, in one model (``joined``):
of an ellipse it is one function, of a diamond two; a polygon has one for each edge. |G - 1|^2 -
c^2, of effects in series, is what is judged whatever the environment, and nowhere less than the
excess of one part.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import TypeAlias

from sympy import Expr, Rational, S, Symbol

from haptisym.judge.bounds import ANY_ENVIRONMENT
from haptisym.judge.crossings import Criterion
from haptisym.judge.regions import Cornered, Ellipse, Sided
from haptisym.kernel.arrays import np
from haptisym.kernel.errors import SceneError
from haptisym.kernel.rings import c, omega
from haptisym.kernel.where import LineBound
from haptisym.model.chain import Chain
from haptisym.model.jnd import Part
from haptisym.model.quantities import MotionKind
from haptisym.model.scene import Knob, Scene
from haptisym.programs.program import Program
from haptisym.programs.taylormodels import Array, Modelled, TaylorModel, floated, valued, variable


@dataclass(frozen=True)
class Side:
    """A parameter that varies: its symbol's name (``c``, ``c_real`` or ``c_imag`` for a threshold),
    lowest and highest value."""

    name: str
    low: Expr
    high: Expr
    unit: str = "1"

    def at(self, share: Fraction) -> Expr:
        """The exact value that share of the way from the lowest to the highest."""
        return self.low + Rational(share.numerator, share.denominator) * (self.high - self.low)


@dataclass(frozen=True)
class Box:
    """All values of a scene's parameters within their ranges."""

    scene: Scene

    @cached_property
    def sides(self) -> tuple[Side, ...]:
        """What varies, in the order of the scene; the threshold last."""
        return tuple(_side(x) for x in self.scene.ranges().values())

    def values(self, shares: Mapping[str, Fraction]) -> dict[str, Expr]:
        """The exact values of what varies, each that share of its way."""
        return {side.name: side.at(shares[side.name]) for side in self.sides}

    @cached_property
    def fixed(self) -> dict[Symbol, Expr]:
        """The numbers of the scene that do not vary."""
        names = [side.name for side in self.sides]
        return {p.symbol: p.value for p in self.scene.parameters if p.symbol.name not in names}

    @cached_property
    def chain(self) -> tuple[Chain, bool]:
        """The scene's with these numbers, without zeros on the axis; whether real and imaginary
        part are exchanged by that."""
        return self.scene.chain.at(self.fixed).without_axis_zeros()

    def part_name(self, part: Part) -> str:
        """The name of the side that is a part's threshold, if it varies."""
        return self.scene.knobs.limits[part].name


def _side(x: Knob) -> Side:
    assert x.interval
    return Side(x.name, *x.interval, x.unit_in(x.motion or MotionKind.TRANSLATION))


def box_of(scene: Scene) -> Box:
    """The box of a scene, without sides where ranges are of its hands alone; SceneError without
    any, or with a symbol."""
    if not scene.threshold.is_box:
        names = " and ".join(scene.threshold.ranges)
        raise SceneError(
            f"jnd: a range of {names} is for haptisym evaluate, which gives its bandwidths: "
            f"give a number here"
        )
    box = Box(scene)
    scene.knobs.need_numbers()
    if not box.sides and not any(x.has_ranges for x in scene.hands):
        raise SceneError(
            'no parameter has a range: write one as "1.8 kg +- 5 %" or ["1.7 kg", "1.9 kg"]'
        )
    return box


_BENT = 7  # sides: with more of them the curvature of all slopes costs more than the cells that it spares


class Excess:
    """r^2 - c^2 of a criterion of one part, for every frequency of the band and every set of values
    of the box.

    ``model`` takes cells, an array (cells, sides, 2): for omega, then for each side of the box,
    from which share of its way to which, 0 the low end and 1 the high end.
    """

    def __init__(self, box: Box, criterion: Criterion) -> None:
        part = criterion.part
        if part is None:
            raise SceneError(
                f"{criterion.words}: tolerances need a JND with a limit for each part: a square"
            )
        self._over(box)
        self._judges(box, criterion, part)
        chain, exchanged = box.chain
        seen = part if not exchanged else Part.IMAG if part is Part.REAL else Part.REAL
        self._name = f"squared_{seen.value}"
        self._program = chain.program([self._name])
        self._inputs = self._places(self._program)

    def _judges(self, box: Box, criterion: Criterion, part: Part) -> None:
        """By which threshold."""
        c = box.part_name(part)
        self._limit = 1 + self._names.index(c) if c in self._names else None
        self._c = floated(criterion.threshold)

    def _over(self, box: Box) -> None:
        """What varies, and within which ends."""
        self._names = [side.name for side in box.sides]
        self._fixed = box.fixed
        ends = [box.scene.band, *((side.low, side.high) for side in box.sides)]
        self._intervals = [(floated(low), floated(high - low)) for low, high in ends]
        self.sides = len(ends)
        self.order = 2 if self.sides <= _BENT else 1

    def _places(self, program: Program) -> list[int]:
        """Of each input of a program the number of its side, omega being that of 0."""
        return [0, *(1 + self._names.index(x.name) for x in program.inputs[1:])]

    @cached_property
    def is_zero(self) -> bool:
        """Whether r is 0 everywhere."""
        return bool(self._program.operations[self._program.results[self._name]].value == 0)

    def model(self, cells: Array, *, slopes: int | None = None) -> TaylorModel:
        """The excess over each cell; t_i goes from -1 to 1 along its side i. Unknown where a pole
        may lie in the cell.

        ``slopes`` : of which order; none if 0, and whatever suits so many sides if not said.
        """
        slopes = self.order if slopes is None else slopes
        with np.errstate(
            all="ignore"
        ):  # what is not finite is unknown, which every caller asks about
            inputs = [self._variable(i, cells, slopes=slopes) for i in self._inputs]
            square = self._square(inputs)
            c = (
                inputs[0].number(self._c)
                if self._limit is None
                else self._variable(self._limit, cells, slopes=slopes)
            )
            minus = -(c * c)
            return minus + square if isinstance(square, TaylorModel) else minus.plus(square)

    def terms(self, cells: Array, *, slopes: int | None = None) -> Terms:
        """The functions of which the excess is the largest of the smallest, as of ``model``."""
        return [[self.model(cells, slopes=slopes)]]

    def curve(self, cells: Array) -> LineBound:
        """The excess over each cell as a judge of the one search."""
        found = LineBound.of(*(x[:, 0] for x in self.model(cells, slopes=0).arrays))
        unknown = ~(np.isfinite(found.changes).all(-1) & (found.changes.max(-1) > 0))
        found.changes[unknown] = self._spread(cells[unknown])
        return found

    def _spread(self, cells: Array) -> Array:
        """How wide cells are, relative to the values in them: by what is cut of which nothing is
        known."""
        low, width = np.array(self._intervals).T
        ends = low[:, None] + width[:, None] * cells
        return (ends[..., 1] - ends[..., 0]) / np.maximum(np.abs(ends).max(-1), 1e-300)

    def _square(self, inputs: Sequence[TaylorModel]) -> TaylorModel | float:
        return Modelled(self._program).run(inputs)[self._name]

    @cached_property
    def matters(self) -> Array:
        """For omega and each side, whether the excess depends on it."""
        limit = np.array([i == self._limit for i in range(self.sides)])
        return limit | self._used(self._program)

    def _used(self, program: Program) -> Array:
        """For omega and each side, whether the results of a program depend on it; of omega it is
        said anyway."""
        steps = [program.operations[i] for i in program.needed(program.results.values())]
        used = {step.arguments[0] for step in steps if step.name == "input"}
        inputs = self._places(program)
        places = {0, *(inputs[i] for i in used)}
        return np.array([i in places for i in range(self.sides)])

    def _variable(self, i: int, cells: Array, *, slopes: int) -> TaylorModel:
        (low, width), (start, end) = self._intervals[i], cells[:, i].T
        middle, radius = low + width * (start + end) / 2, width * (end - start) / 2
        size = abs(low) + width * np.maximum(np.abs(start), np.abs(end))
        return variable(middle, radius, size, i, self.sides, slopes=slopes)


class LargerExcess(Excess):
    """|G - 1|^2 - c^2 of a criterion of one part, or for any environment: of effects in series r is
    never larger."""

    def __init__(self, box: Box, criterion: Criterion) -> None:
        self._over(box)
        self._judges(box, criterion, criterion.part or Part.REAL)
        self._program = box.scene.chain.at(self._fixed).program(_RELATIVE)
        self._inputs = self._places(self._program)

    @cached_property
    def is_zero(self) -> bool:
        """Whether G is 1 everywhere."""
        return all(self._program.operations[self._program.results[x]].value == 0 for x in _RELATIVE)

    def _square(self, inputs: Sequence[TaylorModel]) -> TaylorModel:
        found = Modelled(self._program).run(inputs)
        x, y = (
            v if isinstance(v, TaylorModel) else inputs[0].number(v)
            for v in (found[name] for name in _RELATIVE)
        )
        return x * x + y * y


_RELATIVE = ("relative_real", "relative_imag")


def joined(terms: Sequence[Sequence[TaylorModel]]) -> TaylorModel:
    """A model with the sign and the zeros of max over ``terms`` of the min over each.

    In a cell only those functions count whose sign is not known there while it decides that of the
    whole. The model encloses each of them, value and slopes: a slope that keeps its sign is that of
    all of them, and so of what they make. Where none counts it is a number of the known sign.
    """
    signs = [[_sign(f) for f in term] for term in terms]
    alive = [np.logical_and.reduce([sign >= 0 for sign in term]) for term in signs]
    positive = np.logical_or.reduce(
        [np.logical_and.reduce([sign > 0 for sign in term]) for term in signs]
    )
    first = terms[0][0]
    found, known = (
        first.number(1.0).where(positive, first.number(-1.0)),
        np.zeros(len(positive), dtype=bool),
    )
    for own, term, of_term in zip(alive, terms, signs, strict=True):
        for f, sign in zip(term, of_term, strict=True):
            counts = own & (sign == 0) & ~positive
            found = f.where(counts & ~known, enclosing(found, f).where(counts & known, found))
            known |= counts
    return found


def _sign(f: TaylorModel) -> Array:
    """Of the value: 0 where it is not known."""
    low, high = (x[:, 0] for x in f.bounds())
    return np.where(low > 0, 1, np.where(high < 0, -1, 0))


def enclosing(f: TaylorModel, g: TaylorModel) -> TaylorModel:
    """A model within which both lie, with their slopes."""
    middle = [(a + b) / 2 for a, b in zip(f.arrays[:3], g.arrays[:3], strict=True)]
    c0, c1, c2 = (np.abs(a - b) / 2 for a, b in zip(f.arrays[:3], g.arrays[:3], strict=True))
    r = (c0 + TaylorModel(c0, c1, c2, np.maximum(f.r, g.r)).deviation) * (1 + 1e-14)
    return TaylorModel(
        middle[0], middle[1], middle[2], r + 1e-14 * (np.abs(middle[0]) + np.abs(f.c0))
    )


Terms: TypeAlias = list[list[TaylorModel]]
_FIELDS = ("real", "imag", "environment_real", "environment_imag")
_SQUARED = ("squared_real", "squared_imag")


def excess_of(box: Box, criterion: Criterion) -> Excess:
    """What must not be positive of a criterion, over cells."""
    if criterion.name == ANY_ENVIRONMENT.name:
        return LargerExcess(box, criterion)
    is_plain = criterion.region is None and not criterion.threshold.has(omega)
    return Excess(box, criterion) if is_plain else RegionalExcess(box, criterion)


class RegionalExcess(Excess):
    """Of a criterion with a region, or with a formula in omega as its limit; has the sign and the
    zeros of what it judges."""

    def __init__(self, box: Box, criterion: Criterion) -> None:
        self._over(box)
        self._criterion, self._limit = criterion, None
        threshold = box.scene.threshold
        if criterion.region and threshold.interval(Part.REAL):  # one for both half widths
            self._criterion = replace(
                criterion, region=criterion.region.opened(dict.fromkeys(Part, c))
            )
            self._limit = 1 + self._names.index(box.part_name(Part.REAL))
        chain = box.scene.chain.at(self._fixed)
        relative, _ = chain.without_axis_zeros()
        environments = (chain.ring.convert(x.environment) for x in (chain, relative))
        powers = [
            int(n)
            for n, *_ in (next(environments) / next(environments)).reduced().numerator.monoms()
        ]
        sided = isinstance(criterion.region, Cornered) and not criterion.region.pairs
        if len(powers) > 1 and sided:  # changes its side where H_env changes its sign
            relative, powers = chain, [0]
        self._turns, self._from_rest = max(powers) % 4, len(powers) == 1
        self._relative, self._plain = (
            relative.program([*_SQUARED, *_FIELDS]),
            chain.program(_FIELDS),
        )

    @cached_property
    def is_zero(self) -> bool:
        """Whether nothing of what is judged changes anywhere."""
        parts = [self._criterion.part] if self._criterion.part else list(Part)
        steps, results = self._relative.operations, self._relative.results
        return all(
            steps[results[f"squared_{seen_as(part, self._turns).value}"]].value == 0
            for part in parts
        )

    @cached_property
    def matters(self) -> Array:
        """For omega and each side, whether the excess may depend on it."""
        limit = np.array([i == self._limit for i in range(self.sides)])
        return limit | self._used(self._relative) | self._used(self._plain)

    def model(self, cells: Array, *, slopes: int | None = None) -> TaylorModel:
        """The excess over each cell; t_i goes from -1 to 1 along its side i. Unknown where a pole
        may lie in the cell."""
        with np.errstate(all="ignore"):
            return joined(self.terms(cells, slopes=slopes))

    def terms(self, cells: Array, *, slopes: int | None = None) -> Terms:
        """The functions of which the excess is the largest of the smallest, as of ``model``."""
        slopes = self.order if slopes is None else slopes
        with np.errstate(
            all="ignore"
        ):  # what is not finite is unknown, which every caller asks about
            at = self._variable(0, cells, slopes=slopes)
            relative, plain = (
                self._run(x, cells, at, slopes=slopes) for x in (self._relative, self._plain)
            )
            known: dict[Expr, TaylorModel] = {omega: at}
            if self._limit is not None:
                known[c] = self._variable(self._limit, cells, slopes=slopes)
            return RelativeChange(relative, plain, known, self._turns, self._from_rest).terms(
                self._criterion
            )

    def _run(
        self, program: Program, cells: Array, at: TaylorModel, *, slopes: int
    ) -> dict[str, TaylorModel]:
        found = Modelled(program).run(
            [self._variable(i, cells, slopes=slopes) for i in self._places(program)]
        )
        return {
            name: x if isinstance(x, TaylorModel) else at.number(x) for name, x in found.items()
        }


def seen_as(part: Part, turns: int) -> Part:
    """Which part shows a part of what was turned by a number of quarters."""
    return part if turns % 2 == 0 else Part.IMAG if part is Part.REAL else Part.REAL


@dataclass(frozen=True)
class RelativeChange:
    """x = Re dH/|H_env| and y = Im dH/|H_env| over cells, and what a criterion makes of them.

    ``relative`` : fields of a chain with the same ratios, in which all is ``turns`` quarters
    behind; ``plain``: of the chain.
    ``known`` : what omega, and the half width c where it varies, are over the cells. ``from_rest``
    : whether these chains differ by a power of s alone.
    """

    relative: Mapping[str, TaylorModel]
    plain: Mapping[str, TaylorModel]
    known: Mapping[Expr, TaylorModel]
    turns: int
    from_rest: bool = False

    def terms(self, criterion: Criterion) -> Terms:
        """The functions of which the largest of the smallest is positive where a change is
        noticed."""
        region = criterion.region
        if isinstance(region, Ellipse):
            return [[self._quadric(region, (S.One, -region.tilt, S.One), 1 - region.tilt**2)]]
        if isinstance(region, Cornered) and region.pairs:
            return [[self._quadric(region, (p * p, p * q, q * q), S.One)] for p, q in region.pairs]
        if isinstance(region, Cornered):
            (x, y), (a, b) = self._xy, (region.real, region.imag)
            return [
                [(self._times(p / a, x) + self._times(q / b, y)).plus(-1.0)]
                for p, q in region.edges
            ]
        if isinstance(region, Sided):
            return self._sided(region)
        assert criterion.part
        return [[self._beyond(criterion.part, criterion.threshold)]]

    def _quadric(
        self, region: Ellipse | Cornered, form: tuple[Expr, Expr, Expr], whole: Expr
    ) -> TaylorModel:
        """a b times xx (x/a)^2 + 2 xy (x/a)(y/b) + yy (y/b)^2 - whole."""
        (a, b), (xx, xy, yy) = (region.real, region.imag), form
        squares = self._times(xx * b / a, self._square(Part.REAL)) + self._times(
            yy * a / b, self._square(Part.IMAG)
        )
        found = squares - self._constant(a * b * whole)
        return found if xy == 0 else found + self._times(2 * xy, self._product)

    def _sided(self, region: Sided) -> Terms:
        own = self.plain[region.part.value]
        larger, smaller = (self._beyond(region.part, x) for x in (region.higher, region.lower))
        least = [] if region.floor is None else [own * own - self._constant(region.floor**2)]
        if not region.has_sides:
            return [[larger, *least]]
        growth = self._growth(region.part)
        return [[growth, larger, *least], [-growth, smaller, *least], [larger, smaller, *least]]

    def _growth(self, part: Part) -> TaylorModel:
        """|H_perc|^2 - |H_env|^2 of a part: of what H_env vanishes with at omega = 0 alone nothing
        is left in it."""
        fields, seen = (
            (self.relative, seen_as(part, self.turns)) if self.from_rest else (self.plain, part)
        )
        return fields[seen.value] * (
            fields[seen.value] + fields[f"environment_{seen.value}"].times(2.0)
        )

    def _beyond(self, part: Part, limit: Expr) -> TaylorModel:
        return self._square(part) - self._constant(limit**2)

    def _square(self, part: Part) -> TaylorModel:
        return self.relative[f"squared_{seen_as(part, self.turns).value}"]

    @cached_property
    def _product(self) -> TaylorModel:
        """x y."""
        found = self.relative["real"] * self.relative["imag"] / self._modulus
        return -found if self.turns % 2 else found

    @cached_property
    def _modulus(self) -> TaylorModel:
        R, X = self.relative["environment_real"], self.relative["environment_imag"]
        return R * R + X * X

    @cached_property
    def _xy(self) -> tuple[TaylorModel, TaylorModel]:
        size = self._modulus.to_the(self._at.number(0.5))
        x, y = self.relative["real"] / size, self.relative["imag"] / size
        for _ in range(self.turns):
            x, y = -y, x
        return x, y

    def _times(self, factor: Expr, x: TaylorModel) -> TaylorModel:
        return x * self._constant(factor) if factor.free_symbols else x.times(floated(factor))

    def _constant(self, x: Expr) -> TaylorModel:
        return valued(x, self.known, self._at)

    @property
    def _at(self) -> TaylorModel:
        return self.known[omega]
