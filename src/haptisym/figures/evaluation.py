"""Figures of an evaluation: when a display is noticed and what it is felt as (the paper's Figs. 2,
3 and 5 to 7).

Each figure is a function of the evaluation that returns a ``Panel``; begin with ``ratios``.
Crossings, bands, jumps and percepts are the proven ones of the evaluation; the curves between them
are sampled in floats.

``ratios``: r_r = |Re dH|/|H_env| and r_i = |Im dH|/|H_env| over the band with thresholds, crossings
and transparent bands. ``nyquist``: H_env and H_perc in the complex plane. ``projections``: the
magnitude of one part of both, with what is felt. ``square``: the JND at one frequency. ``regions``:
the distortion's way among other JND regions; ``discriminate``: what would decide between them.
``bandwidths``: the bandwidth over a threshold that has a range.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import groupby, product
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.patches import Patch, Polygon, Rectangle
from matplotlib.transforms import Affine2D

from haptisym.figures import pen
from haptisym.figures.curves import (
    band_of,
    broken,
    columns,
    ends_of,
    evenly,
    in_window,
    is_share,
    limit_of,
    name_of,
    points_of,
    poles_of,
    refined,
    responses,
    sampled,
    top_of,
)
from haptisym.figures.files import Drawings
from haptisym.figures.layers import (
    UPRIGHT,
    Above,
    DrawnAxis,
    Intervals,
    Layer,
    Limit,
    Mark,
    Note,
    On,
    Origin,
    Panel,
    Polyline,
    Words,
    dots,
    em,
    entries,
    force_per_position,
    frequency,
    handle,
    number,
    plate,
    share_of,
    small,
    spread,
    text_width,
)
from haptisym.judge.bandwidths import Bandwidths
from haptisym.judge.crossings import Criterion, noticed
from haptisym.judge.crossings import PerceptFunction as Dynamics
from haptisym.judge.evaluation import Compared, Evaluation, different, half_widths, region_label
from haptisym.judge.peaks import Peaks
from haptisym.judge.percepts import NOT_NAMED, felt_of
from haptisym.judge.regions import Cornered, Joint, Sided
from haptisym.kernel.errors import NothingToDrawError, SceneError
from haptisym.kernel.roots import Interval, Signs
from haptisym.model.jnd import Part
from haptisym.programs.floats import floats_of
from haptisym.programs.values import Array, Values
from haptisym.verbs.evaluate.entry import evaluate

if TYPE_CHECKING:
    from haptisym.verbs.derive.derivation import Derivation

_MOST_NUMBERS = 8
"""Narrow percepts that get a number, at most."""


def along(e: Evaluation) -> DrawnAxis:
    """The axis of the band, in the scene's unit."""
    return frequency(e.scene.frequency, band_of(e))


# When: the ratios (Fig. 5).


def ratios(e: Evaluation) -> Panel:
    """r_r and r_i over the band with their thresholds, crossings and the transparent bands in grey.

    The axis is cut where a ratio is unbounded or has a narrow high peak; how high that is, and
    where, stands above it.

    >>> from haptisym import evaluate, load_scene
    >>> from haptisym.figures.layers import draw
    >>> from matplotlib.figure import Figure
    >>> ax = Figure().add_subplot()
    >>> for name in ("fu2019", "lead-compensation"):
    ...     lines = draw(ax, ratios(evaluate(load_scene(name))), label=name)
    >>> len(lines), ax.get_xlabel(), ax.get_xlim() == (0, 50)
    (2, '$\\\\omega$ (rad/s)', True)
    """
    criteria, f, axis = e.criteria, e.distortion.compile(), along(e)
    limits = [limit_of(x) for x in criteria]

    def judged(omega: Array) -> Array:
        return columns(criteria, f(omega), omega)

    grid = sampled(e)
    # At least twice the largest threshold: it is never at the rim of the axes.
    top = max(top_of(judged(grid), judged(evenly(e)), max(limits)), 2 * max(limits))
    omega = refined(lambda w: in_window(judged(w), 0, top), grid)
    values = broken(judged(omega), omega, e.unbounded)
    lines = [
        Polyline(omega, column, stroke=stroke, label=name_of(x))
        for column, x, stroke in zip(values.T, criteria, pen.STROKES, strict=False)
    ]
    bands = (
        Intervals([ends_of(x) for x in e.transparent], label="transparent")
        if e.transparent
        else _words("nowhere transparent")
    )
    above = Above(_frequency_labels(e, axis, omega, values.max(axis=1), top))
    layers = [*lines, *_thresholds(criteria, limits), bands, *_crossings(e), above]
    return Panel(layers, axis, DrawnAxis(_judged(criteria), ends=(0, top)))


def formulas(found: Derivation) -> Panel:
    """The ratios that the formulas give with the scene's values."""
    return ratios(evaluate(found.scene))


def peaks(found: Peaks) -> Panel:
    """The ratios over the band, and a triangle at each of their local maxima."""
    chart = ratios(evaluate(found.scene))
    x, y = [float(p.omega) for p in found], [float(p.ratio) for p in found]
    return replace(
        chart,
        layers=[*chart.layers, Mark(x, y, shape="v", size=4, label="peaks", look={"zorder": 5})],
    )


def _words(text: str) -> Words:
    """Return an entry of the legend that is words alone."""
    return Words(label=text)


def _judged(criteria: Sequence[Criterion]) -> str:
    """Return the label of the axis of ratios and of multiples of limits."""
    shares = [is_share(x) for x in criteria]
    fraction, multiple = r"ratio to $|H_\mathrm{env}|$", "multiple of the limit"
    return multiple if all(shares) else f"{fraction}, or {multiple}" if any(shares) else fraction


def _thresholds(criteria: Sequence[Criterion], limits: Sequence[float]) -> list[Limit]:
    """Return a line for each threshold: one where both parts have the same."""
    names = (r"c_\mathrm{r}", r"c_\mathrm{i}") if len(set(limits)) > 1 else ("c",)
    shares = any(map(is_share, criteria))
    return [
        Limit(
            c,
            stroke=stroke,
            label="limit" if shares and c == 1 else f"${name} = {c:.3g}$",
            shared=True,
        )
        for name, c, stroke in zip(names, limits, (pen.SOLID, pen.DASHED), strict=False)
    ]


def _crossings(e: Evaluation) -> list[Mark]:
    """A dot where the first ratio, a ring where the other meets its threshold."""
    marks = []
    for x, face in zip(e.criteria, ("", "white"), strict=False):
        omega = [float(c.omega) for c in e.crossings if c.criterion == x]
        look = {"clip_on": False, "markeredgewidth": 0.8}
        marks.append(
            Mark(
                omega,
                [limit_of(x)] * len(omega),
                face=face,
                look=look,
                label=f"{name_of(x)} crosses",
            )
        )
    return marks


def _frequency_labels(
    e: Evaluation, axis: DrawnAxis, omega: Array, highest: Array, top: float
) -> list[tuple[float, str]]:
    """Return the labels above the axes, each with its frequency in rad/s: of all crossings, and of
    the two highest peaks that are cut.

    Where there are many crossings their numbers in the table of the page stand for them.
    """
    is_few = len(e.crossings) <= pen.MOST_LABELS
    crossings = [
        (float(c.omega), axis.digits(c.omega, 4) if is_few else str(number))
        for number, c in enumerate(e.crossings, 1)
    ]
    # A gap is a pole, and so the highest of all.
    values = np.where(np.isnan(highest), np.inf, highest)
    runs = [
        list(run)
        for above, run in groupby(range(len(values)), key=lambda i: bool(values[i] > top))
        if above
    ]
    # One label for each stretch of samples above the axis, at its highest; of these the two
    # highest.
    tops = sorted((max(run, key=lambda i: values[i]) for run in runs), key=lambda i: -values[i])[:2]
    at = axis.of(omega)
    cut = [
        (float(omega[i]), f"{_height(values[i])} at {number(at[i], 4 if at[i] < 1e4 else 6)}")
        for i in tops
    ]
    return crossings + cut


def _height(value: float) -> str:
    """Return the height of a cut peak in two or three digits."""
    return "∞" if np.isinf(value) else number(value, 2 if value < 100 else 3)


# How: the complex plane (Fig. 6).


def nyquist(e: Evaluation) -> Panel:
    """H_env and H_perc in the complex plane over the band, with arrows towards higher frequencies.

    About a third, two thirds and the end of the band are marked, with the same mark on both curves.
    Where a dynamics is infinite, or far from where it is on most of the band, its curve leaves the
    axes.

    >>> from haptisym import evaluate, load_scene
    >>> layers = nyquist(evaluate(load_scene("fu2019"))).layers
    >>> [layer.stroke for layer in layers if isinstance(layer, Polyline)][0]
    '-'
    """
    f, grid = e.distortion.compile(), sampled(e)
    low, high = _window(responses(f, grid), responses(f, evenly(e)))
    # Each sample has the parts of H_env, then of H_perc: the same window for both.
    lows, highs = np.tile(low, 2), np.tile(high, 2)
    omega = refined(lambda w: in_window(responses(f, w), lows, highs), grid)
    values = points_of(broken(responses(f, omega), omega, poles_of(e)))
    at = np.asarray(_default_marks(e, f, (low, high)), dtype=float)
    curves, arrows = list[Layer](), list[Layer]()
    # The arrows of both curves stand at different shares of their length: where the curves lie on
    # each other, the arrows do not.
    for points, (color, stroke, name), share in zip(values, pen.CURVES, (0.42, 0.58), strict=True):
        curves.append(Polyline(points[:, 0], points[:, 1], color, stroke, label=f"${name}$"))
        length = _visible_length((points - low) / (high - low))
        for tail, head in _directions(length, np.interp(at, omega, length), share):
            arrows.append(Arrow(points[tail], points[head], color))
    rising = [Words(label="rising frequency", look=dots(4.2, ">"))] if arrows else []
    # Marks are evaluated at their own frequencies, not taken from the samples.
    places = [points_of(responses(f, np.array([w]))) for w in at]
    axis = along(e)
    matched = Matched(
        [(axis.short(w, 6), env[0], perc[0]) for w, (env, perc) in zip(at, places, strict=True)],
        implied=True,
        shared=True,
    )
    layers = [Origin(), *curves, *arrows, *rising, matched]
    ends = [(float(low[i]), float(high[i])) for i in (0, 1)]
    return Panel(layers, *plane(e.scene, *ends), height=2.6, equal=True)


def plane(
    scene: Any, x: tuple[float, float], y: tuple[float, float]
) -> tuple[DrawnAxis, DrawnAxis]:
    """The axes of the complex plane of dynamics."""
    return force_per_position(r"\mathrm{Re}\,H", scene, x), force_per_position(
        r"\mathrm{Im}\,H", scene, y
    )


def changes(reach: float) -> tuple[DrawnAxis, DrawnAxis]:
    """The axes of the plane of what is noticed: changes as fractions of the environment."""
    return (
        DrawnAxis(r"$\mathrm{Re}\,\Delta H/|H_\mathrm{env}|$", ends=(-reach, reach)),
        DrawnAxis(r"$\mathrm{Im}\,\Delta H/|H_\mathrm{env}|$", ends=(-reach, reach)),
    )


@dataclass(frozen=True)
class Arrow(Layer):
    """An arrowhead on a curve of the plane; ``shaft`` : the stroke of a line from the tail, none if
    not given."""

    tail: Array
    head: Array
    color: str
    shaft: Any = None

    def draw(self, on: On) -> list[Artist]:
        ink, style = on.ink(self.color), f"-|>, head_length={_HEAD / 10}, head_width=0.27"
        look: dict[str, Any] = {
            "arrowstyle": style,
            "color": ink,
            "linewidth": 0,
            "mutation_scale": 10,
            "shrinkA": 0,
            "shrinkB": 0,
        }
        made: list[Artist] = []
        tail, head = self.tail, self.head
        if self.shaft is not None:
            shaft = {
                "arrowstyle": "-",
                "color": ink,
                "linewidth": 1.2,
                "linestyle": self.shaft,
                "shrinkA": 0,
                "shrinkB": _HEAD,
            }
            made.append(
                on.ax.annotate(
                    "", xy=(head[0], head[1]), xytext=(tail[0], tail[1]), arrowprops=shaft, zorder=3
                )
            )
            # Shafts begin at the origin, so that this lies on the shaft: the head needs a direction
            # alone.
            tail = 0.95 * head
        return [
            *made,
            on.ax.annotate("", xy=(head[0], head[1]), xytext=(tail[0], tail[1]), arrowprops=look),
        ]


_HEAD = 6.5
"""Points: the length of an arrow's head."""


@dataclass(frozen=True)
class Matched(Layer):
    """The same mark on both curves at each frequency, filled on the environment's; ``rows`` : its
    words, and both places.

    ``implied`` : nobody asked for them, so that a further scene has none. A frequency that bears a
    mark already keeps its shape.
    """

    rows: Sequence[tuple[str, Array, Array]]
    implied: bool = False
    colors: tuple[str, str] = (pen.BLUE, pen.RED)

    def draw(self, on: On) -> list[Artist]:
        if self.implied and on.number:
            return []
        made: list[Artist] = []
        look = {"markeredgewidth": 0.9, **self.look}
        for (_, env, perc), shape in zip(self.rows, self._shapes(on), strict=False):
            for (x, y), color, face in ((env, self.colors[0], ""), (perc, self.colors[1], "white")):
                made += Mark([x], [y], color, shape, 4.2, face, look=look).draw(on)
        return made

    def _shapes(self, on: On) -> list[str]:
        """Return a mark for each row: that of an entry of the legend with the same words, else one
        that is free."""
        known = entries(on.ax)
        taken = {str(x.get_marker()) for x in known.values() if hasattr(x, "get_marker")}
        free = iter([x for x in "osDv^*phPX" if x not in taken] * len(self.rows))
        return [
            str(known[words].get_marker()) if words in known else next(free, "o")
            for words, *_ in self.rows
        ]

    def keys(self, on: On, made: list[Artist]) -> list[tuple[str, Artist]]:
        # Marks were made in pairs, the environment's first.
        shapes = [str(x.get_marker()) for x in made[::2]]  # type: ignore[attr-defined]
        style = {"markerfacecolor": "none", "markeredgewidth": 0.9}
        return [
            (row[0], handle(pen.INK, "none", "", **dots(4.2, shape, **style)))
            for row, shape in zip(self.rows, shapes, strict=False)
        ]


def _window(everywhere: Array, evenly: Array) -> tuple[Array, Array]:
    """Return the lower left and the upper right corner of a window that holds both curves, except
    where they go far from most of the band."""
    stacked = [np.concatenate(points_of(x)) for x in (everywhere, evenly)]
    reached, common = (points[np.isfinite(points).all(axis=1)] for points in stacked)
    # Most of the band is what lies between the quantiles of 5 and 95 % of even samples. A curve
    # that goes more than four times its extent beyond that, as near a pole, leaves the axes.
    first, last = np.quantile(common, (0.05, 0.95), axis=0)
    least, most, span = reached.min(axis=0), reached.max(axis=0), last - first
    far = 4 * span.max()
    low = np.where(least < first - far, first - span, least)
    high = np.where(most > last + far, last + span, most)
    # A curve that is a point or a level line still has a window.
    size = np.maximum(high - low, 0.1 * (np.max(high - low) or np.abs(low).max() or 1.0))
    middle = (low + high) / 2
    return middle - 0.56 * size, middle + 0.56 * size


def _visible_length(points: Array) -> Array:
    """The length of a curve, given in fractions of the axes, from its start to each sample, as far
    as it is on them."""
    visible: Any = (np.abs(points - 0.5) <= 0.5).all(axis=1)
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(np.where(visible[1:] & visible[:-1], steps, 0.0))])


def _directions(length: Array, marked: Array, share: float) -> list[tuple[int, int]]:
    """Tail and head samples of arrows in the two longest pieces of a curve between its marks; none
    on mere spots."""
    edges = np.unique([0.0, *marked, length[-1]])
    longest = np.argsort(np.diff(edges))[-2:]
    heads = [
        edges[i] + share * (edges[i + 1] - edges[i])
        for i in longest
        if edges[i + 1] - edges[i] > 0.1
    ]
    return [
        (int(np.searchsorted(length, head - 0.01)) - 1, int(np.searchsorted(length, head)))
        for head in heads
    ]


def _default_marks(
    e: Evaluation, f: Callable[..., Values], window: tuple[Array, Array]
) -> tuple[float, ...]:
    """About a third, two thirds and the end of the frequencies at which both curves are on the
    axes, as short numbers."""
    omega = evenly(e)
    places = in_window(responses(f, omega), np.tile(window[0], 2), np.tile(window[1], 2))
    return short_thirds(omega[(np.abs(places - 0.5) <= 0.5).all(axis=1)], along(e))


def short_thirds(omega: Array, axis: DrawnAxis) -> tuple[float, ...]:
    """About a third, two thirds and the end of some frequencies, rad/s, as numbers that are short
    in the unit of the axis."""
    factor, (low, high) = float(axis.unit.size), axis.of(axis.ends)
    step = 10.0 ** (np.floor(np.log10(high - low)) - 1)
    inside = axis.of(omega)
    last = len(inside) - 1
    chosen = inside[[round(share * last) for share in (1 / 3, 2 / 3, 1)]]
    # The last mark must not lie beyond the end, so it is rounded down; 1e-9 of a step keeps an end
    # that is a short number, and in floats a hair less, from losing a whole step.
    highest = np.floor(inside[-1] / step + 1e-9)
    rounded = np.minimum(np.round(chosen / step), highest) * step
    # Twelve digits drop the error of the product with the step; equal marks are one.
    shown = (max(low, float(f"{x:.12g}")) for x in rounded)
    return tuple(dict.fromkeys(x * factor for x in shown))


# How: the magnitudes of a part, and what is felt (Fig. 7).


class FeltBand(NamedTuple):
    """What is felt from ``low`` to ``high``, rad/s, in words."""

    low: float
    high: float
    words: str


def projections(e: Evaluation, part: Part) -> Panel:
    """``|Re|`` or ``|Im|`` of H_env and H_perc over the band.

    Bold where the part's ratio exceeds its threshold, or both parts together leave a region, with
    the percept in words; thin on grey where it does not. H_perc is dotted where its part has the
    other sign than that of H_env, as magnitudes hide. The percepts of a further scene on the same
    axes are not written.

    >>> from haptisym import Part, evaluate, load_scene
    >>> chart = projections(evaluate(load_scene("fu2019")), Part.REAL)
    >>> [layer.width for layer in chart.layers if isinstance(layer, Polyline)]
    [1.6, 0.7, 1.6, 0.7]
    """
    name = rf"\mathrm{{{'Re' if part is Part.REAL else 'Im'}}}"
    f = e.distortion.compile()
    grid = sampled(e)
    exceeded = _exceeded(e, part)
    over, under = e.chart.where(exceeded), e.chart.where(lambda signs: not exceeded(signs))
    # The upper part of the axes is for the words.
    top = 1.3 * top_of(_magnitudes(f, grid, part), _magnitudes(f, evenly(e), part)) or 1.0
    omega = refined(lambda w: in_window(_magnitudes(f, w, part), 0, top), grid)
    values = broken(_magnitudes(f, omega, part), omega, poles_of(e))
    differs = _sign_differs(f, omega, part) & (np.min(values, axis=1) > _SIGN_SEEN * top)
    lines = list[Layer]()
    for magnitude, (color, stroke, curve) in zip(values.T, pen.CURVES, strict=True):
        for weight, among in ((1.6, over), (0.7, under)):
            within = _within(omega, among)
            for seen, kind in _strokes(stroke, differs):
                shown = np.where(within & seen, magnitude, np.nan)
                lines.append(
                    Polyline(omega, shown, color, kind, weight, name=f"$|{name}\\,{curve}|$")
                )
    if differs.any():
        lines.append(_opposite(name))
    ground = [ends_of(x) for x in under]
    felt = Percepts(_felt(e, part), ground, shared=True)
    return Panel(
        [_Unnoticed(ground, label=_UNNOTICED), *lines, felt],
        along(e),
        force_per_position(rf"|{name}\,H|", e.scene, (0, top)),
        height=2.0,
    )


def _exceeded(e: Evaluation, part: Part) -> Callable[[Signs], bool]:
    """Return a test of signs: whether a part is noticed, by itself or together with the other."""
    criteria = [x for x in e.criteria if x.part in (part, None)]
    other = Part.IMAG if part is Part.REAL else Part.REAL

    def exceeded(signs: Signs) -> bool:
        if not any(signs[x] > 0 for x in criteria):
            return False
        # A region of both parts may be left because of one of them: then the other, if it is not
        # outside by itself, is not named. Without such a region each part decides alone.
        alone = signs.get((Dynamics.OUTSIDE, part), 1) > 0
        return alone or signs.get((Dynamics.OUTSIDE, other), 0) <= 0

    return exceeded


_SIGN_SEEN = 0.02
"""Share of the axis: where one of two magnitudes is smaller, nobody sees which sign it has."""


def _sign_differs(f: Callable[..., Values], omega: Array, part: Part) -> Any:
    """Return where the part of H_perc has the other sign than that of H_env."""
    env, perc = responses(f, omega)[:, (0 if part is Part.REAL else 1) :: 2].T
    return np.sign(env) * np.sign(perc) < 0


def _strokes(stroke: Any, differs: Any) -> Iterator[tuple[Any, Any]]:
    """Yield where a curve has its own stroke, and where H_perc is dotted for its other sign."""
    if stroke == pen.SOLID or not differs.any():
        yield np.ones_like(differs), stroke
        return
    yield ~differs, stroke
    yield differs, pen.DOTTED


def _opposite(name: str) -> Layer:
    """Return the entry of the legend that says what is dotted."""
    color, _, perceived = pen.CURVES[1]
    _, _, environment = pen.CURVES[0]
    words = f"${name}\\,{perceived}$ of the opposite sign to ${name}\\,{environment}$"
    return Words(label=words, look=_line(color, pen.DOTTED, 1.6))


def _magnitudes(f: Callable[..., Values], omega: Array, part: Part) -> Array:
    """Return |Re| or |Im| of H_env and of H_perc, in two columns."""
    return np.abs(responses(f, omega)[:, (0 if part is Part.REAL else 1) :: 2])


def _felt(e: Evaluation, part: Part) -> list[FeltBand]:
    """Return what a part is felt as where it is noticed, in the words of all outputs and in the
    order of the bands."""
    together = [FeltBand(*ends_of(x.band), felt_of(x, part)) for x in e.percepts if x.part is None]
    own = [FeltBand(*ends_of(x.band), x.words) for x in e.felt if x.part is part]
    nameless = [FeltBand(*ends_of(x), NOT_NAMED) for x in _nameless(e, part)]
    return sorted(together + own + nameless, key=lambda x: x.low)


def _nameless(e: Evaluation, part: Part) -> tuple[Interval, ...]:
    """Return where a region of both parts is left in this one, and the display is active, so that
    no property applies."""
    if not any(x.joint for x in e.criteria):
        return ()
    exceeded = _exceeded(e, part)
    # Im H_perc < 0 is an active display, and no stiffness, damping or mass is felt as that.
    return e.chart.where(
        lambda signs: (
            exceeded(signs)
            and signs[Dynamics.PERCEIVED, Part.IMAG] < 0
            and (part is Part.IMAG or signs[Dynamics.OUTSIDE, part] <= 0)
        )
    )


def _within(omega: Array, intervals: Iterable[Interval]) -> Any:
    """Which samples lie on closed intervals."""
    found = np.zeros(omega.shape, dtype=bool)
    for low, high in map(ends_of, intervals):
        found |= (omega >= low) & (omega <= high)
    return found


@dataclass(frozen=True)
class Percepts(Layer):
    """The words of each percept inside its band, or a number that the legend explains where the
    band is too narrow; and lines between bands. ``unnoticed`` : where nothing is, which one ground
    says."""

    felt: Sequence[FeltBand]
    unnoticed: Sequence[tuple[float, float]] = ()

    def draw(self, on: On) -> list[Artist]:
        if on.number:
            return []
        ax = on.ax
        if not self.felt:
            return Note("never exceeds the threshold").draw(on)
        made: list[Artist] = []
        shown = [
            x._replace(low=float(on.x.of(x.low)), high=float(on.x.of(x.high))) for x in self.felt
        ]
        # Bands are divided by lines, except at the rims of the axes.
        ends = sorted({end for x in shown for end in (x.low, x.high)} - set(ax.get_xlim()))
        look: dict[str, Any] = {
            "color": pen.GREY,
            "linewidth": 0.5,
            "linestyle": pen.DOTTED,
            "zorder": 1,
        }
        made = [ax.axvline(omega, **look) for omega in ends]
        fitting, numbers, _ = self._parted(on)
        texts = [
            (x, fitting.get(i) or numbers.get(own.words, ""))
            for i, (x, own) in enumerate(zip(shown, self.felt, strict=True))
        ]
        widest, words = self._ground(on)
        if words:
            texts = sorted([*texts, (widest, words)])
        elif _is_upright(ax, widest):
            middle = share_of(ax, (widest.low + widest.high) / 2)
            place: dict[str, Any] = {"transform": ax.transAxes, "ha": "center", "va": "center"}
            made.append(
                ax.text(
                    middle,
                    0.45,
                    _UNNOTICED,
                    rotation=90,
                    fontsize=small(ax),
                    bbox=plate(pen.SHADE),
                    **place,
                )
            )
        return made + _beside_each_other(ax, [(x, text) for x, text in texts if text])

    def _ground(self, on: On) -> tuple[FeltBand, str]:
        """Return the widest ground, and its words if they fit."""
        low, high = max(self.unnoticed, key=lambda x: x[1] - x[0], default=(0.0, 0.0))
        widest = FeltBand(float(on.x.of(low)), float(on.x.of(high)), _UNNOTICED)
        return widest, _fitting(on.ax, widest) if low < high else ""

    def _parted(self, on: On) -> tuple[dict[int, str], dict[str, str], int]:
        """Return the words that fit, by their places; the numbers of others, by their words; and
        how many have neither."""
        shown = [
            x._replace(low=float(on.x.of(x.low)), high=float(on.x.of(x.high))) for x in self.felt
        ]
        fitting = {i: text for i, x in enumerate(shown) if (text := _fitting(on.ax, x))}
        # The widest of those without room come first: they get the numbers.
        narrow = sorted(
            (i for i in range(len(shown)) if i not in fitting),
            key=lambda i: shown[i].low - shown[i].high,
        )
        words = [self.felt[i].words for i in sorted(narrow[:_MOST_NUMBERS])]
        return (
            fitting,
            {x: str(n) for n, x in enumerate(dict.fromkeys(words), 1)},
            max(0, len(narrow) - _MOST_NUMBERS),
        )

    def keys(self, on: On, made: list[Artist]) -> list[tuple[str, Artist]]:
        if on.number or not self.felt:
            return []
        _, numbers, more = self._parted(on)
        style = {"markersize": 0.6 * small(on.ax), "markeredgewidth": 0}
        numbered: list[tuple[str, Artist]] = [
            (words, handle(pen.INK, "none", "", marker=f"${n}$", **style))
            for words, n in numbers.items()
        ]
        widest, words = self._ground(on)
        if self.unnoticed and not words and not _is_upright(on.ax, widest):
            numbered.insert(0, (_UNNOTICED, Patch(facecolor=pen.SHADE)))
        return numbered + ([(f"and {more} narrower", handle(pen.INK, "none", ""))] if more else [])


_UNNOTICED = "not noticed"


class _Unnoticed(Intervals):
    """Where nothing is noticed: of a first scene ``Percepts`` says so."""

    def keys(self, on: On, made: list[Artist]) -> list[tuple[str, Artist]]:
        return super().keys(on, made) if on.number else []


def _is_upright(ax: Axes, ground: FeltBand) -> bool:
    """Return whether words stand upright in a ground, which is too narrow for them otherwise."""
    return share_of(ax, ground.high) - share_of(ax, ground.low) > UPRIGHT * em(ax)


def _beside_each_other(ax: Axes, texts: Sequence[tuple[FeltBand, str]]) -> list[Artist]:
    """Texts side by side at the top of the axes, each in its band or tied to it."""
    centres = [share_of(ax, (x.low + x.high) / 2) for x, _ in texts]
    places, made = spread(centres, [text_width(ax, text) for _, text in texts]), list[Artist]()
    for (x, text), centre, place in zip(texts, centres, places, strict=True):
        # A text that was moved out of its band is tied to it by a line.
        beside = abs(place - centre) > share_of(ax, x.high) - centre
        made.append(
            ax.annotate(
                text,
                xy=(centre, 0.82),
                xytext=(place, 0.98),
                xycoords="axes fraction",
                textcoords="axes fraction",
                ha="center",
                va="top",
                fontsize=small(ax),
                linespacing=1.1,
                bbox=plate("white"),
                arrowprops=pen.LEADER if beside else None,
            )
        )
    return made


def _fitting(ax: Axes, band: FeltBand) -> str:
    """Return the words on one line or on two, if they fit into the band; else nothing."""
    room = share_of(ax, band.high) - share_of(ax, band.low)
    gap = ", " if ", " in band.words else " "
    # Two lines are broken after the first comma, or else after the first word.
    layouts = (band.words, band.words.replace(gap, f"{gap.strip()}\n", 1))
    return next((text for text in layouts if text_width(ax, text) <= room), "")


# The JND at one frequency (Figs. 2 and 3).

_DIRECTIONS = 720


@dataclass(frozen=True)
class Outline:
    """A region: ``patches`` about the tip, ``stretches`` of the real and of the imaginary part,
    ``corners`` of its frame."""

    patches: tuple[Patch, ...]
    stretches: tuple[tuple[tuple[float, float], ...], ...]
    corners: Array


def outline(
    criteria: Sequence[Criterion], tip: Array, omega: float, size: float | None = None
) -> Outline:
    """Return the region of the changes that are not noticed where H_env has this tip (and, if it is
    given, that size), at a frequency in rad/s."""
    size = float(np.hypot(*tip)) if size is None else size
    if criteria[0].joint:
        return _joint(criteria[0].joint, tip, omega, size)
    stretches = tuple(
        _stretches(x, float(part), size, omega) for x, part in zip(criteria, tip, strict=True)
    )
    # Each part is judged by itself, so the region is the product of its stretches: up to four
    # rectangles where a part has two.
    patches = tuple(
        Rectangle((x0, y0), x1 - x0, y1 - y0) for (x0, x1), (y0, y1) in product(*stretches)
    )
    ends = np.array([[part[0][0] for part in stretches], [part[-1][1] for part in stretches]])
    return Outline(patches, stretches, ends)


def _stretches(
    criterion: Criterion, value: float, size: float, omega: float
) -> tuple[tuple[float, float], ...]:
    """Return the intervals of one part, in force per position, within which a change is not
    noticed."""
    if not isinstance(criterion.region, Sided):
        reach = floats_of(criterion.threshold, omega) * size
        return ((value - reach, value + reach),)
    least = 0.0 if criterion.region.floor is None else floats_of(criterion.region.floor, omega)
    higher, lower = (
        max(least, floats_of(c, omega) * size)
        for c in (criterion.region.higher, criterion.region.lower)
    )
    # A part that changes against its sign shrinks until the change is 2|value|, where it is its own
    # mirror image; beyond that it grows again, and the limit for growing holds.
    way, turn = (1.0 if value >= 0 else -1.0), 2 * abs(value)
    grown, shrunk = value + way * higher, value - way * min(lower, turn)
    # The limit for growing ends before the mirror image: beyond that everything is noticed.
    if higher <= turn:
        return (_sorted(shrunk, grown),)
    again = value - way * higher
    # Neither limit ends before the mirror image: one stretch. Else there is a gap before it.
    if lower >= turn:
        return (_sorted(again, grown),)
    return tuple(sorted((_sorted(shrunk, grown), _sorted(again, value - way * turn))))


def _sorted(a: float, b: float) -> tuple[float, float]:
    """Return two numbers, the smaller one first."""
    return min(a, b), max(a, b)


def _joint(region: Joint, tip: Array, omega: float, size: float) -> Outline:
    """Return the outline of a region that judges both parts at once, from its border in many
    directions."""
    angles = np.linspace(0, 2 * np.pi, _DIRECTIONS, endpoint=False)
    if isinstance(region, Cornered):
        widths = region.real, region.imag
        corners = np.array(
            [
                [floats_of(c * a, omega) for c, a in zip(x, widths, strict=True)]
                for x in region.corners
            ]
        )
        # A corner between two of the even angles would be cut off.
        angles = np.sort(
            np.concatenate([angles, np.arctan2(corners[:, 1], corners[:, 0]) % (2 * np.pi)])
        )
    across, up = np.cos(angles), np.sin(angles)
    reach = size / region.enlarged(across, up, lambda x: floats_of(x, omega))
    border = tip + np.stack([across, up], axis=1) * reach[:, None]
    # 720 is a multiple of 4, so that the directions of both axes are among the angles.
    quarters = [reach[np.argmin(np.abs(angles - n * np.pi / 2))] for n in range(4)]
    stretches = tuple(
        ((float(tip[i] - quarters[i + 2]), float(tip[i] + quarters[i])),) for i in (0, 1)
    )
    return Outline(
        (Polygon(border, closed=True),),
        stretches,
        np.array([border.min(axis=0), border.max(axis=0)]),
    )


@dataclass(frozen=True)
class RegionLayer(Layer):
    """An outline: filled for the first scene, its border alone for a further one."""

    around: Outline
    color: str = pen.GREY
    filled: bool = True
    about: tuple[Array, float] | None = None
    """The tip that is moved to the origin, and the size that becomes 1."""

    def draw(self, on: On) -> list[Artist]:
        face = pen.SHADE if self.filled and not on.number else "none"
        style = {
            "facecolor": face,
            "edgecolor": on.ink(self.color),
            "linewidth": 0.6,
            "zorder": 1,
            **self.look,
        }
        for patch in self.around.patches:
            patch.set(**style)
            if self.about:
                tip, size = self.about
                patch.set_transform(Affine2D().translate(*-tip).scale(1 / size) + on.ax.transData)
            on.ax.add_patch(patch)
        return list(self.around.patches)


def square(e: Evaluation, omega: float | None = None) -> Panel:
    """H_env and H_perc at one frequency of the band, rad/s, with the region of changes that are not
    noticed (Fig. 2).

    The square is c_real ``|H_env|`` wide and c_imag ``|H_env|`` high to each side of the tip of
    H_env; other regions are drawn as they are. What is not noticed of one part alone are bars on
    the axes. The frequency is in the middle of the first percept if it is not given. Raises
    SceneError outside the band and where H_env or H_perc is infinite.

    >>> from haptisym import evaluate, load_scene
    >>> square(evaluate(load_scene("fu2019")), 10).title
    '$\\\\omega$ = 10 rad/s: noticed in the real part'
    """
    omega = _telling_frequency(e) if omega is None else omega
    exceeded = [x for x in e.criteria if _sign_at(e, omega, x) > 0]
    tips = np.concatenate(points_of(responses(e.distortion.compile(), np.array([omega]))))
    if not np.isfinite(tips).all():
        raise SceneError(f"omega: the dynamics are infinite at {omega:g} rad/s")
    # The region lies about the tip of H_env: what is noticed is a change from there.
    around, axis = outline(e.criteria, tips[0], omega), along(e)
    pairs = list(zip(tips, pen.CURVES, strict=True))
    arrows: list[Layer] = [
        Arrow(np.zeros(2), tip, color, stroke) if tip.any() else Mark([0], [0], color)
        for tip, (color, stroke, _) in pairs
    ]
    lines = [_Projected(tip, color) for tip, (color, *_) in pairs]
    names = [
        Words(label=f"${name}$", look=_line(color, stroke)) for color, stroke, name in pen.CURVES
    ]
    bars = _Bars(around.stretches, label="not noticed in one part", shared=True)
    shade = RegionLayer(around, label="not noticed", styled=True)
    dotted = Words(label="projections", look=_line(pen.INK, pen.DOTTED, 0.6), shared=True)
    at = (
        f"{axis.short(omega)}"
        if axis.label == "frequency"
        else f"{axis.label} = {axis.short(omega)}"
    )
    ends = _frame(np.array([[0, 0], *tips, *around.corners]))
    layers = [*names, shade, Origin(), dotted, bars, *lines, *arrows]
    return Panel(
        layers, *plane(e.scene, *ends), height=2.6, equal=True, title=f"{at}: {_verdict(exceeded)}"
    )


def _line(color: str, stroke: Any, width: float = 1.1) -> dict[str, Any]:
    """Return the look of a line in the legend."""
    return {"color": color, "linestyle": stroke, "linewidth": width}


@dataclass(frozen=True)
class _Projected(Layer):
    """The projections of a tip on both axes."""

    tip: Array
    color: str

    def draw(self, on: On) -> list[Artist]:
        (x, y), look = (
            self.tip,
            {"color": on.ink(self.color), "linewidth": 0.6, "linestyle": pen.DOTTED, "zorder": 2},
        )
        return list(on.ax.plot([x, x, 0], [0, y, y], **look))


@dataclass(frozen=True)
class _Bars(Layer):
    """Bars on the axes: the changes that are not noticed if they are of one part alone."""

    stretches: Sequence[Sequence[tuple[float, float]]]

    def draw(self, on: On) -> list[Artist]:
        look: dict[str, Any] = {
            "color": pen.GREY,
            "alpha": 0.5,
            "linewidth": 3,
            "solid_capstyle": "butt",
            "zorder": 1,
        }
        if on.number:
            return []
        level = [x for ends in self.stretches[0] for x in on.ax.plot(ends, [0, 0], **look)]
        return [
            *level,
            *(x for ends in self.stretches[1] for x in on.ax.plot([0, 0], ends, **look)),
        ]


def _verdict(found: Sequence[Criterion]) -> str:
    """Return in words which criteria are exceeded."""
    if not found:
        return "not noticed"
    if found[0].joint:
        return f"outside the {found[0].joint.kind}"
    return f"noticed in {'both parts' if len(found) == 2 else f'the {found[0].words}'}"


def _sign_at(e: Evaluation, omega: float, criterion: Criterion) -> int:
    """The proven sign of what is judged at a frequency."""
    points = e.chart.points
    below = [point for point in points if float(point.omega) <= omega]
    if not below or omega > float(points[-1].omega):
        raise SceneError(
            f"omega: {omega:g} rad/s is not on the band, "
            f"{' to '.join(f'{x:g}' for x in band_of(e))}"
        )
    # Between two points of the chart no sign changes: it is that after the point below.
    return (below[-1].at if float(below[-1].omega) == omega else below[-1].after)[criterion]


def _frame(points: Array) -> tuple[tuple[float, float], tuple[float, float]]:
    """Limits that hold the points with a margin, at equal scales, neither very wide nor very
    high."""
    low, high = points.min(axis=0), points.max(axis=0)
    size = high - low
    # The shorter side is at least 0.6 of the longer one; 0.57 is a half with a margin.
    half = 0.57 * np.maximum(size, 0.6 * np.max(size) or 1.0)
    middle = (low + high) / 2
    low, high = middle - half, middle + half
    return (low[0], high[0]), (low[1], high[1])


def _telling_frequency(e: Evaluation) -> float:
    """Return the middle of the first percept band, else the end of the band, rad/s; beside it if
    H_env or H_perc is infinite there."""
    low, high = ends_of(e.percepts[0].band) if e.percepts else band_of(e)
    # Further shares are for a pole exactly at the first one, where nothing can be drawn.
    shares = (0.5, 0.4, 0.6, 0.45, 0.55) if e.percepts else (1.0, 0.9, 0.8, 0.95, 0.85)
    infinite = {float(pole.omega) for pole in poles_of(e)}
    return next(x for x in (low + share * (high - low) for share in shares) if x not in infinite)


# Other JND regions.

REGIONS: Sequence[tuple[str, Any, str]] = (
    (pen.GREY, pen.SOLID, "s"),
    (pen.BLUE, pen.DASHED, "o"),
    (pen.RED, pen.DOTTED, "D"),
    (pen.SCENES[1], pen.SOLID, "x"),
)
"""For each region in its order: colour, stroke of its border, mark of its bandwidth."""


def regions(e: Evaluation) -> Panel:
    """(Re dH, Im dH)/``|H_env|`` over the band, with the regions of ``e.regions``; a dot where each
    is first met.

    A region that depends on the frequency, as a floor and limits for each way do, is drawn as it is
    where it is first met, or else at the high end of the band. NothingToDrawError where no regions
    were asked for.
    """
    if not e.regions:
        raise NothingToDrawError(
            "kind: no regions were compared: ask for them with evaluate(scene, regions=True)"
        )
    f = e.distortion.compile()
    rows = list(zip(different(e.regions), REGIONS, strict=False))
    shapes, reach = list[Layer](), 0.0
    for x, (color, stroke, _) in rows:
        shape, corners = _region(e, x)
        entry = Words(label=region_label(x), look=_line(color, stroke, 1.0))
        look: dict[str, Any] = {"linewidth": 1.0, "linestyle": stroke, "zorder": 2}
        shapes += [*([replace(shape, color=color, look=look)] if shape else []), entry]
        # The regions set the scale, and not the distortion, which may go far beyond them.
        reach = max(reach, 1.6 * float(np.abs(corners).max()))
    met = [(x, color) for x, (color, *_) in rows if x.crossing]
    at = [(_way(f(np.array([float(x.crossing.omega)]))), color) for x, color in met if x.crossing]
    spots = [Mark(place[:, 0], place[:, 1], color) for place, color in at]
    way = Polyline(*_way(f(sampled(e))).T, label=r"$\Delta H$ over the band")
    return Panel([way, Origin(), *shapes, *spots], *changes(reach), height=2.9, equal=True)


def discriminate(e: Evaluation) -> Panel:
    """(Re dH, Im dH)/``|H_env|`` over the band, the regions of models, and the numbers of the
    changes that decide between them.

    NothingToDrawError where that was not asked.
    """
    comparison = e.discrimination
    if comparison is None:
        raise NothingToDrawError(
            "kind: no models were compared: ask for it with evaluate(scene, discriminate=True)"
        )
    shapes, reach = list[Layer](), 0.0
    for (name, x), (color, stroke, _) in zip(comparison.models.items(), REGIONS, strict=True):
        around = outline(noticed(x), np.zeros(2), comparison.stimuli[0].omega, 1.0)
        look: dict[str, Any] = {"linewidth": 1.0, "linestyle": stroke, "zorder": 2}
        shapes += [
            RegionLayer(around, color, filled=False, look=look),
            Words(label=name, look=_line(color, stroke, 1.0)),
        ]
        # As for the regions: these are in sight, and the distortion where it is near them.
        reach = max(reach, 1.6 * float(np.abs(around.corners).max()))
    marks = [
        Mark([x.real], [x.imag], shape=f"${i}$", size=5, look={"markeredgewidth": 0.3})
        for i, x in enumerate(comparison.stimuli, 1)
    ]
    way = Polyline(*_way(e.distortion.compile()(sampled(e))).T, label=r"$\Delta H$ over the band")
    return Panel([way, Origin(), *shapes, *marks], *changes(reach), height=2.9, equal=True)


def _way(v: Values) -> Array:
    """Return both ratios with the signs of the distortion, as points of the plane."""
    return np.stack([np.copysign(v.ratio_real, v.real), np.copysign(v.ratio_imag, v.imag)], axis=1)


def _region(e: Evaluation, compared: Compared) -> tuple[RegionLayer | None, Array]:
    """Return one region about 0, relative to |H_env|, and its corners; None where it cannot be
    drawn."""
    at = float(compared.crossing.omega if compared.crossing else e.chart.points[-1].omega)
    criteria = noticed(compared.threshold)
    tip, size = np.zeros(2), 1.0
    # A floor, and which of two limits holds, depend on H_env: its tip is taken as it is there, and
    # scaled afterwards.
    if not criteria[0].joint:
        here = e.distortion.compile()(np.array([at]))
        tip = np.array([float(here.environment_real[0]), float(here.environment_imag[0])])
        size = float(np.hypot(*tip))
    if not np.isfinite(size) or not size:
        # H_env is 0 or infinite there: the region cannot be drawn relative to it.
        widths = np.array([floats_of(c, at) for c in half_widths(compared.threshold)])
        return None, np.array([-widths, widths])
    around = outline(criteria, tip, at, 1.0 if criteria[0].joint else None)
    return RegionLayer(around, filled=False, about=(tip, size)), (around.corners - tip) / size


# The bandwidth over a threshold that has a range.


class _Ranged(NamedTuple):
    """The number that has a range, as it is drawn: a threshold in per cent, or a scale."""

    ends: tuple[float, float]
    nominal: float
    unit: float
    label: str


def bandwidths(e: Evaluation) -> Panel:
    """The bandwidth over the threshold: dots at the proven ends; at a jump a dot for what is
    attained, a ring for what is not.

    NothingToDrawError where the threshold has no range, or several that move apart.

    >>> from haptisym import evaluate, load_scene
    >>> chart = bandwidths(evaluate(load_scene("fu2019").with_values({"c": "0.1 +- 20 %"})))
    >>> [float(round(y, 3)) for y in chart.layers[0].y[[0, -1]]]
    [6.534, 12.993]
    """
    if e.bandwidths is None or not e.bandwidths.is_one_curve:
        raise NothingToDrawError(
            "the JND has no one number with a range that gives a range of bandwidths"
        )
    moving = _ranged(e)
    low, high = moving.ends
    c, omega = _curve(e, e.bandwidths, moving)
    ends = [float(x) for x in (e.bandwidths.least, e.bandwidths.most) if x is not None]
    nominal = (
        []
        if e.bandwidth is None
        else [
            Mark(
                [moving.nominal],
                [float(e.bandwidth)],
                shape="s",
                size=4.5,
                face="white",
                label="nominal",
            )
        ]
    )
    layers = [
        Polyline(c, omega, label="bandwidth"),
        *_jumps(e.bandwidths, moving.unit),
        *nominal,
        # Where small thresholds have no bandwidth, the curve begins later than the range.
        Mark([max(low, c[0]), high], ends, look={"zorder": 3}),
    ]
    margin, top = 0.03 * (high - low), 1.06 * float(np.nanmax(omega))
    upright = replace(frequency(e.scene.frequency, (0, top)), label="bandwidth")
    return Panel(layers, DrawnAxis(moving.label, ends=(low - margin, high + margin)), upright)


def _ranged(e: Evaluation) -> _Ranged:
    """Return what has a range: the scale of a region, or the threshold in per cent."""
    threshold = e.scene.threshold
    if "scale" in threshold.ranges:
        low, high = map(float, threshold.ranges["scale"])
        return _Ranged((low, high), float(threshold.region.size), 1.0, "scale of the JND")
    low, high = (float(100 * x) for x in threshold.ranges["real"])
    return _Ranged((low, high), float(100 * threshold.real), 100.0, "threshold $c$ (%)")


def _curve(e: Evaluation, attained: Bandwidths, moving: _Ranged) -> tuple[Array, Array]:
    """Return the threshold (or scale) and the bandwidth along the curve, broken at the jumps:
    samples at which the ratio is higher than at all lower frequencies."""
    omega = np.unique(
        np.concatenate([sampled(e), [float(x) for j in attained.jumps for x in (j.low, j.high)]])
    )
    (low, high), nominal, unit, _ = moving
    limits = [limit_of(x) for x in e.criteria]
    ratio = nominal * (columns(e.criteria, e.distortion.compile()(omega), omega) / limits).max(
        axis=1
    )
    least, most = float(attained.least or 0), float(attained.most or 0)
    first = unit * float(next(iter(attained.blocked.values()))) if attained.blocked else low
    # The bandwidth at a threshold is the first frequency at which the ratio reaches it. So a sample
    # is on the curve only where the ratio is as high as at all frequencies below it.
    between = (
        (omega > least) & (omega < most) & (ratio >= np.maximum.accumulate(np.nan_to_num(ratio)))
    )
    inside = between & (ratio > first) & (ratio < high)
    for jump in attained.jumps:
        # The ends of a jump have rows of their own.
        inside &= (omega < float(jump.low)) | (omega > float(jump.high))
    # The second number orders rows of one threshold: below a jump, a gap that breaks the line,
    # above it.
    rows = [
        (first, 0, least),
        *((c, 0, w) for c, w in zip(ratio[inside], omega[inside], strict=True)),
        (high, 3, most),
    ]
    for jump in attained.jumps:
        at = unit * float(jump.threshold or 0)
        rows += [(at, 0, float(jump.low)), (at, 1, np.nan), (at, 2, float(jump.high))]
    ordered = sorted(rows, key=lambda row: row[:2])
    return np.array([c for c, _, _ in ordered]), np.array([w for _, _, w in ordered])


def _jumps(attained: Bandwidths, unit: float) -> list[Layer]:
    """Return a dotted line for each jump, with a ring at the end that is not attained and a dot at
    the one that is."""
    made: list[Layer] = []
    for jump in attained.jumps:
        at, low, high = unit * float(jump.threshold or 0), float(jump.low), float(jump.high)
        dotted = Polyline(
            [at, at],
            [low, high],
            pen.GREY,
            pen.DOTTED,
            0.6,
            label="jump at a peak of the ratio",
            styled=False,
            shared=True,
        )
        made += [
            dotted,
            Mark([at], [low], face="white", look={"zorder": 3}),
            Mark([at], [high], look={"zorder": 3}),
        ]
    return made


EVALUATION = Drawings[Evaluation](
    {
        "ratios": ratios,
        "bandwidths": bandwidths,
        "nyquist": nyquist,
        **{
            f"projections-{name}": partial(projections, part=part)
            for name, part in (("real", Part.REAL), ("imag", Part.IMAG))
        },
        "regions": regions,
        "discriminate": discriminate,
        "jnd-square": square,
    }
)
DERIVATION, PEAKS = Drawings[Any]({"ratios": formulas}), Drawings[Peaks]({"ratios": peaks})
