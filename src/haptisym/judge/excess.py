"""By how much a criterion is exceeded, over cells of frequency and parameters: proven bounds on the
excess and on its slopes, in Taylor models.

A scene whose parameters have ranges is a ``Box``; a *cell* is a piece of the band and of these
ranges. On a cell each varying quantity i is an affine function of a variable t_i, -1 <= t_i <= 1,
and a *Taylor model* (``programs.taylormodels``) is a polynomial of low degree in these with a
proven bound on its error: so it bounds a function, and its slopes, over all of the cell.

The *excess* of a criterion is a function that is positive exactly where a change is noticed:

- of one part r^2 - c^2, with the ratio r = |Re dH|/|H_env| or |Im dH|/|H_env| of the distortion dH
  = H_perc - H_env and the threshold c (``Excess``),
- of a JND region, or of a limit that depends on frequency, the maximum of minima of smooth
  functions: one function for an ellipse, two for a diamond, one for each edge of a polygon
  (``RegionalExcess``). ``joined`` makes of them one model, with the same sign and the same zeros,
- with effects in series, that multiply the dynamics by G, |G - 1|^2 - c^2, judged for any
  environment; it is nowhere less than the excess of one part (``LargerExcess``).

Begin with ``excess_of``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import TypeAlias

from sympy import Expr, S, Symbol

from haptisym.judge.bounds import ANY_ENVIRONMENT
from haptisym.judge.crossings import Criterion
from haptisym.judge.regions import Cornered, Ellipse, Sided
from haptisym.kernel.arrays import np
from haptisym.kernel.errors import SceneError
from haptisym.kernel.reals import rational
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
        return self.low + rational(share) * (self.high - self.low)


@dataclass(frozen=True)
class Box:
    """A scene whose parameters have ranges: all combinations of values within them."""

    scene: Scene

    @cached_property
    def sides(self) -> tuple[Side, ...]:
        """The parameters that vary, in the order of the scene; the threshold last."""
        return tuple(_side(x) for x in self.scene.ranges().values())

    def values(self, shares: Mapping[str, Fraction]) -> dict[str, Expr]:
        """The exact values of the parameters that vary, each that share of the way through its
        range."""
        return {side.name: side.at(shares[side.name]) for side in self.sides}

    @cached_property
    def fixed(self) -> dict[Symbol, Expr]:
        """The numbers of the scene that do not vary."""
        names = [side.name for side in self.sides]
        return {p.symbol: p.value for p in self.scene.parameters if p.symbol.name not in names}

    @cached_property
    def chain(self) -> tuple[Chain, bool]:
        """The scene's chain with the fixed numbers, in a form in which H_env has no zeros on the
        imaginary axis; and whether that exchanges real and imaginary part."""
        # At such a zero the ratios are 0/0, and over a cell around it nothing would be known.
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


# Sides up to which models are of second order: with more the curvature of all slopes costs more
# than the cells that it spares.
_MOST_BENT = 7


class Excess:
    """The excess r^2 - c^2 of a criterion of one part, for every frequency of the band and every
    set of values of the box.

    ``model`` takes cells, an array (cells, sides, 2): for omega, then for each side of the box, the
    two ends of an interval, as shares of the way through its range: 0 the low end, 1 the high end.
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
        # The chain without zeros shows the imaginary part's ratio as the real part's, and vice
        # versa, where the factor taken out is imaginary on the axis.
        seen = seen_as(part, turns=int(exchanged))
        self._name = f"squared_{seen.value}"
        self._program = chain.program([self._name])
        self._inputs = self._places(self._program)

    def _judges(self, box: Box, criterion: Criterion, part: Part) -> None:
        """Set the threshold c: a side of the box if it varies, else a number."""
        c = box.part_name(part)
        self._limit = 1 + self._names.index(c) if c in self._names else None
        self._c = floated(criterion.threshold)

    def _over(self, box: Box) -> None:
        """Set the sides: omega over the band, then each parameter of the box over its range."""
        self._names = [side.name for side in box.sides]
        self._fixed = box.fixed
        ends = [box.scene.band, *((side.low, side.high) for side in box.sides)]
        self._intervals = [(floated(low), floated(high - low)) for low, high in ends]
        self.sides = len(ends)
        self.order = 2 if self.sides <= _MOST_BENT else 1

    def _places(self, program: Program) -> list[int]:
        """For each input of a program the number of its side; omega is side 0."""
        return [0, *(1 + self._names.index(x.name) for x in program.inputs[1:])]

    @cached_property
    def is_zero(self) -> bool:
        """Whether r is 0 everywhere."""
        return bool(self._program.operations[self._program.results[self._name]].value == 0)

    def model(self, cells: Array, *, slopes: int | None = None) -> TaylorModel:
        """The excess over each cell; t_i goes from -1 to 1 along its side i. Unknown where a pole
        may lie in the cell.

        ``slopes`` : their order; 0 for none, None for the order that suits the number of sides.
        """
        slopes = self.order if slopes is None else slopes
        # What is not finite is unknown, and every caller asks for that.
        with np.errstate(all="ignore"):
            inputs = [self._variable(i, cells, slopes=slopes) for i in self._inputs]
            square = self._square(inputs)
            c = inputs[0].number(self._c)
            if self._limit is not None:
                c = self._variable(self._limit, cells, slopes=slopes)
            minus = -(c * c)
            return minus + square if isinstance(square, TaylorModel) else minus.plus(square)

    def terms(self, cells: Array, *, slopes: int | None = None) -> Terms:
        """The functions whose maximum of minima is the excess, over the cells of ``model``."""
        return [[self.model(cells, slopes=slopes)]]

    def curve(self, cells: Array) -> LineBound:
        """The excess over each cell, as a bound for the search of ``kernel.where``."""
        bound = LineBound.of(*(x[:, 0] for x in self.model(cells, slopes=0).arrays))
        # Where no change is known, next to a pole or to cancelling numbers, the relatively widest
        # side is cut.
        unknown = ~(np.isfinite(bound.changes).all(-1) & (bound.changes.max(-1) > 0))
        bound.changes[unknown] = self._spread(cells[unknown])
        return bound

    def _spread(self, cells: Array) -> Array:
        """The relative width of cells along each side, by which those are cut of which nothing is
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
        """For omega and each side, whether the results of a program depend on it; omega always
        counts as one that matters."""
        steps = [program.operations[i] for i in program.needed(program.results.values())]
        used = {step.arguments[0] for step in steps if step.name == "input"}
        inputs = self._places(program)
        places = {0, *(inputs[i] for i in used)}
        return np.array([i in places for i in range(self.sides)])

    def _variable(self, i: int, cells: Array, *, slopes: int) -> TaylorModel:
        """The model of the variable of side i over each cell."""
        (low, width), (start, end) = self._intervals[i], cells[:, i].T
        middle, radius = low + width * (start + end) / 2, width * (end - start) / 2
        size = abs(low) + width * np.maximum(np.abs(start), np.abs(end))
        return variable(middle, radius, size, i, self.sides, slopes=slopes)


class LargerExcess(Excess):
    """The excess |G - 1|^2 - c^2 of effects in series, for any environment, or as an upper bound on
    that of one part: r_r and r_i are at most |G - 1|."""

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
        results = _all_models(Modelled(self._program).run(inputs), inputs[0])
        x, y = (results[name] for name in _RELATIVE)
        return x * x + y * y


_RELATIVE = ("relative_real", "relative_imag")


def _all_models(
    results: Mapping[str, TaylorModel | float], like: TaylorModel
) -> dict[str, TaylorModel]:
    """Results of a program, constants among them as models over the cells of another one."""
    models: dict[str, TaylorModel] = {}
    for name, x in results.items():
        models[name] = x if isinstance(x, TaylorModel) else like.number(x)
    return models


def joined(terms: Sequence[Sequence[TaylorModel]]) -> TaylorModel:
    """A model with the sign and the zeros of max over ``terms`` of the min over each.

    In a cell only those functions count whose sign is not known there while it decides that of the
    whole. The model encloses each of them, value and slopes: a slope that keeps its sign is that of
    all of them, and so of what they make. Where none counts it is a number of the known sign.
    """
    signs = [[_sign(f) for f in term] for term in terms]
    # A term with one negative function is negative, whatever the others are: none of it counts. One
    # whose functions are all positive settles the whole cell.
    alive = [np.logical_and.reduce([sign >= 0 for sign in term]) for term in signs]
    all_positive = [np.logical_and.reduce([sign > 0 for sign in term]) for term in signs]
    positive = np.logical_or.reduce(all_positive)
    first = terms[0][0]
    whole = first.number(1.0).where(positive, first.number(-1.0))
    begun = np.zeros(len(positive), dtype=bool)
    for term_alive, term, term_signs in zip(alive, terms, signs, strict=True):
        for f, sign in zip(term, term_signs, strict=True):
            # Of a living term the positive functions do not decide the sign of its minimum.
            counts = term_alive & (sign == 0) & ~positive
            whole = f.where(counts & ~begun, enclosing(whole, f).where(counts & begun, whole))
            begun |= counts
    return whole


def _sign(f: TaylorModel) -> Array:
    """The sign of the value over each cell: 1, -1, or 0 where it is not known."""
    low, high = (x[:, 0] for x in f.bounds())
    return np.where(low > 0, 1, np.where(high < 0, -1, 0))


def enclosing(f: TaylorModel, g: TaylorModel) -> TaylorModel:
    """A model that encloses two, value and slopes."""
    # Half way between both polynomials. From there either is as far as half their difference, whose
    # largest value is the sum of the sizes of its coefficients.
    middle: list[Array] = []
    half: list[Array] = []
    for a, b in zip(f.arrays[:3], g.arrays[:3], strict=True):
        middle.append((a + b) / 2)
        half.append(np.abs(a - b) / 2)
    c0, c1, c2 = half
    difference = TaylorModel(c0, c1, c2, np.maximum(f.r, g.r))
    r = (c0 + difference.deviation) * (1 + 1e-14)
    # The rounding of the middle itself.
    c0, c1, c2 = middle
    size = np.abs(c0) + np.abs(f.c0)
    return TaylorModel(c0, c1, c2, r + 1e-14 * size)


Terms: TypeAlias = list[list[TaylorModel]]
_FIELDS = ("real", "imag", "environment_real", "environment_imag")
_SQUARED = ("squared_real", "squared_imag")


def excess_of(box: Box, criterion: Criterion) -> Excess:
    """The excess of a criterion over cells: what must not be positive."""
    if criterion.name == ANY_ENVIRONMENT.name:
        return LargerExcess(box, criterion)
    is_plain = criterion.region is None and not criterion.threshold.has(omega)
    return Excess(box, criterion) if is_plain else RegionalExcess(box, criterion)


class RegionalExcess(Excess):
    """The excess of a criterion with a JND region, or with a formula in omega as its limit; in sign
    and zeros it is what the criterion judges."""

    def __init__(self, box: Box, criterion: Criterion) -> None:
        self._over(box)
        self._criterion, self._limit = criterion, None
        threshold = box.scene.threshold
        if criterion.region and threshold.interval(Part.REAL):
            # The range is one for both half widths.
            opened = criterion.region.opened(dict.fromkeys(Part, c))
            self._criterion = replace(criterion, region=opened)
            self._limit = 1 + self._names.index(box.part_name(Part.REAL))
        chain = box.scene.chain.at(self._fixed)
        relative, _ = chain.without_axis_zeros()
        # Z, the factor of H_env that was taken out. At s = j omega its highest power s^n has the
        # phase of j^n: by so many quarters of a turn ``relative`` lies behind.
        with_zeros, without = (chain.ring.convert(x.environment) for x in (chain, relative))
        Z = (with_zeros / without).reduced().numerator
        powers = [int(n) for n, *_ in Z.monoms()]
        # A Z of several terms has zeros at omega > 0, at which it changes its sign. Squares do not
        # see that; an edge without its opposite changes sides, and needs the chain as it is.
        sided = isinstance(criterion.region, Cornered) and not criterion.region.pairs
        if len(powers) > 1 and sided:
            relative, powers = chain, [0]
        self._turns, self._from_rest = max(powers) % 4, len(powers) == 1
        self._relative = relative.program([*_SQUARED, *_FIELDS])
        self._plain = chain.program(_FIELDS)

    @cached_property
    def is_zero(self) -> bool:
        """Whether the parts that are judged change nowhere."""
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
        # What is not finite is unknown, and every caller asks for that.
        with np.errstate(all="ignore"):
            at = self._variable(0, cells, slopes=slopes)
            programs = (self._relative, self._plain)
            relative, plain = (self._run(x, cells, at, slopes=slopes) for x in programs)
            known: dict[Expr, TaylorModel] = {omega: at}
            if self._limit is not None:
                known[c] = self._variable(self._limit, cells, slopes=slopes)
            change = RelativeChange(relative, plain, known, self._turns, self._from_rest)
            return change.terms(self._criterion)

    def _run(
        self, program: Program, cells: Array, at: TaylorModel, *, slopes: int
    ) -> dict[str, TaylorModel]:
        """The results of a program over cells, constants among them as models."""
        inputs = [self._variable(i, cells, slopes=slopes) for i in self._places(program)]
        return _all_models(Modelled(program).run(inputs), at)


def seen_as(part: Part, turns: int) -> Part:
    """The part that shows a part of a complex number turned by a number of quarters of a turn, up
    to its sign."""
    if turns % 2 == 0:
        return part
    return Part.IMAG if part is Part.REAL else Part.REAL


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
        """The functions whose maximum of minima is positive exactly where a change is noticed."""
        region = criterion.region
        if isinstance(region, Ellipse):
            return [[self._quadric(region, (S.One, -region.tilt, S.One), 1 - region.tilt**2)]]
        if isinstance(region, Cornered) and region.pairs:
            return [[self._quadric(region, (p * p, p * q, q * q), S.One)] for p, q in region.pairs]
        if isinstance(region, Cornered):
            (x, y), (a, b) = self._xy, (region.real, region.imag)
            terms: Terms = []
            for p, q in region.edges:
                beyond_edge = self._times(p / a, x) + self._times(q / b, y)
                terms.append([beyond_edge.plus(-1.0)])
            return terms
        if isinstance(region, Sided):
            return self._sided(region)
        assert criterion.part
        return [[self._beyond(criterion.part, criterion.threshold)]]

    def _quadric(
        self, region: Ellipse | Cornered, form: tuple[Expr, Expr, Expr], whole: Expr
    ) -> TaylorModel:
        """The quadric xx (x/a)^2 + 2 xy (x/a)(y/b) + yy (y/b)^2 - whole, times a b."""
        # Times a b, which changes no sign, the factor of x y is a number also where a or b varies;
        # and x^2, y^2 are programs of their own, which need no |H_env|.
        (a, b), (xx, xy, yy) = (region.real, region.imag), form
        x_square = self._times(xx * b / a, self._square(Part.REAL))
        y_square = self._times(yy * a / b, self._square(Part.IMAG))
        quadric = x_square + y_square - self._constant(a * b * whole)
        return quadric if xy == 0 else quadric + self._times(2 * xy, self._product)

    def _sided(self, region: Sided) -> Terms:
        """The terms of one part with limits for each way, or a floor: those of ``Sided.terms``."""
        above_higher = self._beyond(region.part, region.higher)
        above_lower = self._beyond(region.part, region.lower)
        above_floor: list[TaylorModel] = []
        if region.floor is not None:
            part = self.plain[region.part.value]
            above_floor = [part * part - self._constant(region.floor**2)]
        if not region.has_sides:
            return [[above_higher, *above_floor]]
        growth = self._growth(region.part)
        return [
            [growth, above_higher, *above_floor],
            [-growth, above_lower, *above_floor],
            [above_higher, above_lower, *above_floor],
        ]

    def _growth(self, part: Part) -> TaylorModel:
        """|H_perc|^2 - |H_env|^2 of a part, up to a positive factor: where H_env vanishes at omega
        = 0 alone, without its power of omega."""
        # (h + d)^2 - h^2 = d (d + 2 h), which does not cancel. A power of s taken out of both
        # divides it by an even power of omega; any other factor might change the sign.
        fields, seen = self.plain, part
        if self.from_rest:
            fields, seen = self.relative, seen_as(part, self.turns)
        change, environment = fields[seen.value], fields[f"environment_{seen.value}"]
        return change * (change + environment.times(2.0))

    def _beyond(self, part: Part, limit: Expr) -> TaylorModel:
        return self._square(part) - self._constant(limit**2)

    def _square(self, part: Part) -> TaylorModel:
        return self.relative[f"squared_{seen_as(part, self.turns).value}"]

    @cached_property
    def _product(self) -> TaylorModel:
        """The product x y."""
        # Turned by a quarter (x, y) becomes (-y, x): the product changes its sign.
        product = self.relative["real"] * self.relative["imag"] / self._modulus
        return -product if self.turns % 2 else product

    @cached_property
    def _modulus(self) -> TaylorModel:
        R, X = self.relative["environment_real"], self.relative["environment_imag"]
        return R * R + X * X

    @cached_property
    def _xy(self) -> tuple[TaylorModel, TaylorModel]:
        """x and y. Only an edge without its opposite needs them, and the root of |H_env|^2."""
        size = self._modulus.to_the(self._at.number(0.5))
        x, y = self.relative["real"] / size, self.relative["imag"] / size
        # Multiplied by j once for each quarter of a turn.
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
