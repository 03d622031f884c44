"""Figures of measurements: ratios with their uncertainty discs against the thresholds, both
responses in the complex plane, and fitted models.

A verdict on a frequency point holds for its whole disc; between points nothing is drawn but what a
stated bound on the slope leaves possible. Of very many points every so many is drawn. Discs and
bars that are smaller than the marks which they belong to are left out, and so is their entry in the
legend.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.patches import Patch
from matplotlib.transforms import ScaledTranslation

from haptisym.figures import pen
from haptisym.figures.evaluation import Matched, changes, plane, short_thirds
from haptisym.figures.files import Drawings, sheet
from haptisym.figures.layers import (
    DrawnAxis,
    DrawnDiscs,
    Layer,
    Limit,
    Mark,
    On,
    Origin,
    Panel,
    Polyline,
    Words,
    dots,
    force_per_position,
    frequency,
    handle,
    parameter,
)
from haptisym.kernel.errors import NothingToDrawError
from haptisym.model.jnd import SQUARE, Part
from haptisym.model.measured import Measurement
from haptisym.model.quantities import Dimension, Unit, quantity
from haptisym.programs.values import Array
from haptisym.verbs.identify.entry import Identification
from haptisym.verbs.identify.fitting import WantedResponse as Fitted
from haptisym.verbs.identify.zwidth import ZWidthFit
from haptisym.verbs.measured.entry import BetweenLines, BoundedLines, MeasuredEvaluation
from haptisym.verbs.measured.judging import joint_distance, limits_of, values_of
from haptisym.verbs.stability.entry import WALL

_MOST_LINES, _MOST_POINTS = 800, 6000
"""Frequency points drawn, and points of swept discs."""
_SEEN = 0.012
"""Share of the height of the axes: bars and discs no larger than that are hidden by their marks."""
_PARTS = (
    (1, pen.RED, "exceeds in a part"),
    (0, pen.GREY, "unresolved"),
    (-1, pen.BLUE, "below in both parts"),
)
_JOINT = ((1, pen.RED, "outside"), (0, pen.GREY, "unresolved"), (-1, pen.BLUE, "inside"))
_COLORS = {Part.REAL: pen.BLUE, Part.IMAG: pen.RED}
_APART = 1.3
"""Points to the left and to the right of a frequency, so that the bars of both parts can be told
apart."""


def _thinned(count: int) -> Any:
    """Return the indices of the frequency points that are drawn: every so many, at most 800."""
    return np.arange(0, count, -(-count // _MOST_LINES))


def _left_out(drawn: int, count: int) -> list[Words]:
    """Return what the legend says where not all points are drawn."""
    return [Words(label=f"{drawn} of {count} points are drawn")] if drawn < count else []


def unit_of(omega: Array) -> Unit:
    """Hz where the first frequencies are short decimals in Hz, and not all are in rad/s.

    >>> unit_of(np.array([0.0, 31.41592653589793])).name, unit_of(np.array([20.0, 200.0])).name
    ('Hz', 'rad/s')
    """
    hertz = quantity("1 Hz", Dimension.FREQUENCY).unit
    assert hertz is not None
    given, size = np.abs(np.asarray(omega, dtype=float)[:50]), float(hertz.size)

    # A frequency in Hz comes as its product with 2 pi, rounded to a double: divided by 2 pi again
    # it is a short decimal but for some units of the last place.
    def is_short(x: float) -> bool:
        return abs(x - float(f"{x:.6g}")) <= 1e-13 * x

    return (
        hertz
        if all(map(is_short, given / size)) and not all(map(is_short, given))
        else Unit("rad/s")
    )


def _along(omega: Array, unit: Unit, margin: float = 0.03) -> DrawnAxis:
    """The axis of measured frequencies, logarithmic where they span decades."""
    low, high = float(omega[0]), float(omega[-1])
    room = margin * (high - low) or 0.5 * high or 1.0
    # From a ratio of 30 on, a linear axis would leave the low frequencies no room.
    is_log = low > 0 and high > 30 * low
    ends = (
        (0.9 * low, 1.1 * high)
        if is_log
        else (max(low - room, 0.0 if low == 0 else 0.5 * low), high + room)
    )
    axis = frequency(unit, ends)
    return DrawnAxis(axis.label, unit, ends, Dimension.FREQUENCY, log=is_log)


def _codes_of(e: MeasuredEvaluation, part: Part) -> Any:
    """Return the verdicts on a part, or those on both where the region judges them together."""
    return e.joint.verdict if e.joint else e.verdict[part]


def _disc_words(confidence: float) -> str:
    """Return the words of the legend for a disc."""
    return f"{100 * confidence:.4g} % disc"


# The plane of dynamics, and that of changes.


def nyquist(e: MeasuredEvaluation) -> Panel:
    """H_env and the measured H_perc in the complex plane, a disc around each point, in the colour
    of its verdict.

    Three frequencies bear the same mark on both.
    """
    drawn = _thinned(len(e))
    real, imag = (_codes_of(e, part) for part in Part)
    # One part that exceeds is enough to be noticed; both must be below for the opposite.
    codes = np.where((real == 1) | (imag == 1), 1, np.where((real == -1) & (imag == -1), -1, 0))[
        drawn
    ]
    env = e.lines.environment[drawn]
    felt = e.lines.perceived[drawn]
    radius = e.lines.perc_radius[drawn]
    x, y = _frame(np.concatenate([env, felt]), radius)
    least = _SEEN * max(x[1] - x[0], y[1] - y[0])
    layers: list[Layer] = [Origin(), *_environment(e, drawn, least)]
    for code, color, label in _PARTS:
        if (selected := codes == code).any():
            layers += [*_seen_discs(felt[selected], radius[selected], color, least)]
            layers.append(
                Mark(
                    felt[selected].real,
                    felt[selected].imag,
                    color,
                    size=2.4,
                    label=label,
                    styled=True,
                )
            )
    known = np.isfinite(radius) & (radius > least)
    disc = (
        [
            Words(
                label=_disc_words(e.scene.perceived.confidence),
                look=dots(7, alpha=0.3, color=pen.GREY),
            )
        ]
        if known.any()
        else []
    )
    layers += [*disc, _matched(e, env, felt, drawn), *_left_out(len(drawn), len(e))]
    return Panel(layers, *plane(e.scene, x, y), height=2.6, equal=True)


def _matched(e: MeasuredEvaluation, env: Array, felt: Array, drawn: Any) -> Matched:
    """Return marks of the measured frequencies that are nearest to thirds of the band."""
    omega, unit = e.lines.omega[drawn], _unit(e)
    axis = _along(omega, unit, 0.0)
    at = dict.fromkeys(int(np.argmin(np.abs(omega - w))) for w in short_thirds(omega, axis))
    rows = [
        (
            axis.short(omega[i]),
            np.array([env[i].real, env[i].imag]),
            np.array([felt[i].real, felt[i].imag]),
        )
        for i in at
    ]
    # Below the points, which they would hide where both are close.
    return Matched(rows, colors=(pen.INK, pen.INK), shared=True, look={"zorder": 3.5})


def _unit(e: MeasuredEvaluation) -> Unit:
    """Return the scene's unit of frequency, or that in which the measured frequencies are short."""
    return e.scene.frequency if e.scene.band else unit_of(e.lines.omega)


def _seen_discs(centres: Any, radii: Any, color: str, least: float) -> list[DrawnDiscs]:
    """Discs that are larger than their marks."""
    seen = np.isfinite(radii) & (radii > least)
    return [DrawnDiscs(centres[seen], radii[seen], color)] if seen.any() else []


def _environment(e: MeasuredEvaluation, drawn: Any, least: float) -> list[Layer]:
    """A curve of the model, or dots with discs where the environment is measured too."""
    x, label = e.lines, r"$H_\mathrm{env}$"
    env = x.environment[drawn]
    if isinstance(e.scene.environment, Measurement):
        marks = Mark(
            env.real, env.imag, shape="x", size=3, label=label, styled=True, look={"zorder": 3}
        )
        return [*_seen_discs(env, x.env_radius[drawn], pen.INK, least), marks]
    omega = np.union1d(np.linspace(x.omega[0], x.omega[-1], 801), x.omega[drawn])
    values = e.scene.frame.distortion().compile(of=["environment_real", "environment_imag"])(omega)
    return [
        Polyline(values.environment_real, values.environment_imag, label=label, look={"zorder": 2})
    ]


def _frame(points: Any, radius: Any) -> tuple[tuple[float, float], tuple[float, float]]:
    """Limits of both axes, (left, right) and (bottom, top), that hold all points and most of their
    discs."""
    finite = radius[np.isfinite(radius)]
    # Single huge discs would shrink all others: the largest tenth may leave the axes.
    reach = float(np.quantile(finite, 0.9)) if len(finite) else 0.0
    left = float(points.real.min()) - reach
    right = float(points.real.max()) + reach
    bottom = float(points.imag.min()) - reach
    top = float(points.imag.max()) + reach
    # Where all points are one, without discs, the frame would have no size.
    margin = 0.05 * max(right - left, top - bottom) or 1.0
    return (left - margin, right + margin), (bottom - margin, top + margin)


def measured_plane(e: MeasuredEvaluation) -> Panel:
    """dH/|H_env| of each point with its disc, and the region, where that is the same at all.

    NothingToDrawError where the region judges each part by itself.
    """
    if e.joint is None:
        raise NothingToDrawError("the JND judges each part by itself")
    drawn = _thinned(len(e))
    places, codes = e.lines.change[drawn], e.joint.verdict[drawn]
    radius = np.zeros(len(places)) if e.lines.radius is None else e.lines.radius[drawn]
    # As many as nine tenths of the points are in sight; at least 20 % of |H_env|.
    reach = max(0.2, 1.15 * float(np.quantile(np.abs(places[np.isfinite(places)]), 0.9)))
    layers: list[Layer] = []
    for code, color, label in _JOINT:
        if (selected := (codes == code) & np.isfinite(places)).any():
            layers += _seen_discs(places[selected], radius[selected], color, 2 * _SEEN * reach)
            layers.append(
                Mark(
                    places[selected].real,
                    places[selected].imag,
                    color,
                    size=2.4,
                    label=label,
                    styled=True,
                )
            )
    threshold = e.scene.threshold
    border = (
        [_Border(threshold, reach, label=str(threshold.region.shape.value))]
        if threshold.is_constant
        else []
    )
    return Panel([*layers, *border], *changes(reach), height=2.8, equal=True)


@dataclass(frozen=True)
class _Border(Layer):
    """The border of a region that judges both parts, where a distance is 0."""

    threshold: Any
    reach: float

    def draw(self, on: On) -> list[Artist]:
        side = np.linspace(-self.reach, self.reach, 401)
        x, y = np.meshgrid(side, side)
        # On |H_env| = 1 the changes are the fractions that the axes show.
        distance = joint_distance(self.threshold, np.ones(x.size), x.ravel(), y.ravel())
        assert distance is not None
        on.ax.contour(x, y, distance.reshape(x.shape), levels=[0], colors=pen.INK, linewidths=0.9)
        return [handle(pen.INK, "-", "", 0.9)]


# The ratios.


@dataclass(frozen=True)
class _Bars(Layer):
    """Upright bars at places, a little to one side; ``aside`` : points."""

    x: Any
    low: Any
    high: Any
    color: str
    aside: float = 0.0

    def draw(self, on: On) -> list[Artist]:
        place = _beside(on, self.aside)
        style: dict[str, Any] = {
            "color": on.ink(self.color),
            "linewidth": 0.8,
            "alpha": 0.6,
            "zorder": 2,
        }
        return [
            on.ax.vlines(
                on.x.of(self.x), on.y.of(self.low), on.y.of(self.high), transform=place, **style
            )
        ]

    def keys(self, _on: On, made: list[Artist]) -> list[tuple[str, Artist]]:
        key = handle(pen.GREY, "none", "", 0.7, marker="|", markersize=6)
        return [(self.label, key)] if self.label and made else []


def _beside(on: On, aside: float) -> Any:
    """Return a transform that shifts data by some points of the page to the right."""
    return on.ax.transData + ScaledTranslation(aside / 72, 0, on.ax.figure.dpi_scale_trans)


@dataclass(frozen=True)
class _Dots(Layer):
    """The ratios of one part: filled where the whole disc is on one side of the threshold, open
    where it is not."""

    x: Any
    y: Any
    open: Any
    part: Part

    def draw(self, on: On) -> list[Artist]:
        made: list[Artist] = []
        # Dots may lie over the rim of the axes, unless some are beyond it: these must not be drawn
        # on other panels.
        is_cut = bool((self.y > on.ax.get_ylim()[1]).any())
        color, shape = on.ink(_COLORS[self.part]), "os"[self.part is Part.IMAG]
        place = _beside(on, -_APART if self.part is Part.REAL else _APART)
        for where, face in ((~self.open, color), (self.open, "white")):
            if where.any():
                look = {"transform": place, "clip_on": is_cut, "markeredgewidth": 0.7, "zorder": 3}
                made += Mark(self.x[where], self.y[where], color, shape, 3.2, face, look=look).draw(
                    on
                )
        return made

    def keys(self, on: On, made: list[Artist]) -> list[tuple[str, Artist]]:
        key = handle(
            on.ink(_COLORS[self.part]), "none", "", **dots(3.2, "os"[self.part is Part.IMAG])
        )
        return [(self.label, key)] if made else []


_SYMBOLS = {Part.REAL: r"$r_\mathrm{r}$", Part.IMAG: r"$r_\mathrm{i}$"}


def ratios(e: MeasuredEvaluation) -> Panel:
    """r_r and r_i at the measured frequencies, a bar as far as each disc reaches, and the
    thresholds.

    Filled where the whole disc exceeds the threshold or is below it, open where it does not tell.
    Nothing joins the points but what discs leave possible that a bound on the slope sweeps.
    """
    drawn = _thinned(len(e))
    omega = e.lines.omega[drawn]
    radius = np.zeros(len(omega)) if e.lines.radius is None else e.lines.radius[drawn]
    top, bars, marks = _top(e, radius), list[Layer](), list[Layer]()
    is_seen = bool((radius[np.isfinite(radius)] > _SEEN * top).any())
    opened = False
    for part, change, side in zip(
        Part, (e.lines.change.real, e.lines.change.imag), (-1, 1), strict=True
    ):
        ratio, is_open = np.abs(change[drawn]), _codes_of(e, part)[drawn] == 0
        marks.append(_Dots(omega, ratio, is_open, part, label=_SYMBOLS[part], styled=True))
        opened |= bool(is_open.any())
        if is_seen:
            # A disc without a bound has a bar that leaves the axes, but is finite.
            ends = np.clip(ratio - radius, 0, None), np.minimum(ratio + radius, 2 * top)
            label = _disc_words(e.scene.perceived.confidence)
            bars.append(_Bars(omega, *ends, _COLORS[part], side * _APART, label=label, shared=True))
    unresolved = (
        [Words(label="unresolved", look=dots(3.2, markerfacecolor="white", markeredgewidth=0.7))]
        if opened
        else []
    )
    swept = _swept(e) if e.scene.slopes else []
    layers = [*marks, *unresolved, *bars, *swept, *_thresholds(e), *_left_out(len(drawn), len(e))]
    return Panel(
        layers, _along(omega, _unit(e)), DrawnAxis(r"ratio to $|H_\mathrm{env}|$", ends=(0, top))
    )


def _thresholds(e: MeasuredEvaluation) -> list[Layer]:
    """Lines, or curves where a threshold is a formula in omega."""
    threshold = e.scene.threshold
    if e.joint or threshold.region != SQUARE:
        # A limit that depends on the other part, or on the way of the change, is no line.
        return []
    parts = [Part.REAL] if threshold.real == threshold.imag else list(Part)
    omega, made = np.linspace(e.lines.omega[0], e.lines.omega[-1], 400), list[Layer]()
    for x, stroke in zip(parts, (pen.SOLID, pen.DASHED), strict=False):
        name, c = "c" if len(parts) == 1 else rf"c_\mathrm{{{x.value[0]}}}", threshold[x]
        if c.is_number:
            made.append(
                Limit(float(c), stroke=stroke, label=f"${name} = {float(c):.3g}$", shared=True)
            )
        else:
            curve = Polyline(
                omega,
                values_of(c, omega),
                pen.GREY,
                stroke,
                0.6,
                label=rf"${name}(\omega)$",
                shared=True,
                styled=False,
            )
            made.append(curve)
    return made


def _top(e: MeasuredEvaluation, radius: Any) -> float:
    """Return the upper end of the axis of ratios: nearly all dots with their bars, and twice the
    thresholds."""
    change = e.lines.change
    least = 2 * max(float(x.max()) for x in limits_of(e.scene, e.lines.omega).values())
    larger = np.maximum(np.abs(change.real), np.abs(change.imag))[_thinned(len(e))]
    ratios = larger[np.isfinite(larger)]
    ends = larger + radius
    bars = ends[np.isfinite(ends)]
    highest = [float(np.quantile(x, 0.95)) for x in (ratios, bars) if len(x)]
    most = float(ratios.max()) if len(ratios) else 0.0
    # The highest dot is in sight unless it is far above nearly all others.
    is_near = most < 3 * max(highest, default=0.0)
    return 1.08 * max(least, *highest, most if is_near else 0.0)


def _swept(e: MeasuredEvaluation) -> list[Layer]:
    """Return, for each part, a band of the ratios that swept discs leave possible between
    points."""
    swept = BoundedLines(e.scene, e.lines)
    gaps = np.flatnonzero(~swept.contradicted)
    steps = min(25, _MOST_POINTS // max(1, len(gaps)))
    if not len(gaps) or steps < 3:
        return []
    share = np.append(np.linspace(0, 1, steps), 1.0)
    low, high = swept.omega[gaps, None], swept.omega[gaps + 1, None]
    omega = (low + (high - low) * share).ravel()
    lines = list(swept.lines(BetweenLines(np.repeat(gaps, len(share)), omega, omega)))
    # The end of each gap is there twice, and the second one is not drawn: a break between gaps.
    drawn = np.tile(np.append(np.ones(steps, bool), False), len(gaps))
    made: list[Layer] = []
    for part in Part:
        with np.errstate(invalid="ignore"):
            # The true value is in every one of these discs: so the largest of the lower bounds and
            # the smallest of the upper ones bound it.
            ratios = [np.abs(x.change.real if part is Part.REAL else x.change.imag) for x in lines]
            least = np.max(
                [np.maximum(r - x.radius, 0) for r, x in zip(ratios, lines, strict=True)], axis=0
            )
            most = np.min([r + x.radius for r, x in zip(ratios, lines, strict=True)], axis=0)
        known = drawn & np.isfinite(least) & np.isfinite(most)
        made.append(
            _Possible(
                omega,
                least,
                np.maximum(least, most),
                known,
                _COLORS[part],
                label="swept discs",
                shared=True,
            )
        )
    return made


@dataclass(frozen=True)
class _Possible(Layer):
    """A band between two curves, where it is known."""

    x: Any
    low: Any
    high: Any
    known: Any
    color: str

    def draw(self, on: On) -> list[Artist]:
        style: dict[str, Any] = {
            "color": on.ink(self.color),
            "alpha": 0.16,
            "linewidth": 0,
            "zorder": 1,
        }
        return [on.ax.fill_between(on.x.of(self.x), self.low, self.high, where=self.known, **style)]

    def keys(self, _on: On, _made: list[Artist]) -> list[tuple[str, Artist]]:
        return [(self.label, Patch(facecolor=pen.GREY, alpha=0.3, linewidth=0))]


MEASURED = Drawings[MeasuredEvaluation](
    {"ratios": ratios, "nyquist": nyquist, "plane": measured_plane}
)


# A fitted model.

_MANY = 8000
"""Lines that show the course of the model by themselves."""


def magnitude(a: Identification) -> Panel:
    """``|H|`` of the model as a curve, and of the points with the reach of their discs."""
    drawn, (omega, model) = _thinned(len(a.fit.lines)), _model(a)
    at, H, reach = a.fit.lines.omega[drawn], a.fit.lines.H[drawn], _reach(a)[drawn]
    size = np.abs(H)
    is_log = bool(size.min() > 0 and size.max() > 8 * size.min())
    least = float(min(size.min(), np.abs(model).min()))
    most = float(max(size.max(), np.abs(model).max()))
    ends = (
        (0.8 * least, 1.25 * most)
        if is_log
        else (least - 0.06 * (most - least), most + 0.06 * (most - least))
    )
    # What is seen of a disc: on a logarithmic axis its size relative to |H|, else to the axis.
    share = reach / (size if is_log else ends[1] - ends[0])
    bars = [
        _Bars(
            at,
            # A bar to 0 has no end on a logarithmic axis.
            np.maximum(size - reach, 1e-3 * size),
            size + reach,
            pen.BLUE,
            label=_disc_words(a.fit.lines.confidence),
        )
    ]
    upright = force_per_position("|H|", a, ends)
    layers = [
        Polyline(omega, np.abs(model), pen.RED, label="model", look={"zorder": 3}),
        *(bars if share.max() > 2 * _SEEN else []),
        Mark(at, size, pen.BLUE, size=2.4, label="measured", styled=True, look={"zorder": 2}),
    ]
    return Panel(
        layers,
        _along(at, a.frequency),
        DrawnAxis(upright.label, upright.unit, ends, log=is_log, large=True),
        height=1.5,
    )


def phase(a: Identification) -> Panel:
    """Return the phase of both, degrees, without jumps."""
    drawn, (omega, model) = _thinned(len(a.fit.lines)), _model(a)
    at, H, reach = a.fit.lines.omega[drawn], a.fit.lines.H[drawn], _reach(a)[drawn]
    angle = np.unwrap(np.angle(model))
    # The measured phase is that of the model, which has no jumps, plus that of H/model, which is
    # small: unwrapping noisy points would add whole turns.
    measured = np.degrees(np.interp(at, omega, angle) + np.angle(H / a.fit.model[drawn]))
    # A disc of radius r about H is seen from 0 under the angle arcsin(r/|H|) to each side; one that
    # holds 0 leaves every phase, drawn as 90 degrees.
    half = np.degrees(np.arcsin(np.minimum(reach / np.maximum(np.abs(H), 1e-300), 1)))
    least = float(min(measured.min(), np.degrees(angle).min()))
    most = float(max(measured.max(), np.degrees(angle).max()))
    room = 0.06 * (most - least) or 1.0
    bars = (
        [_Bars(at, measured - half, measured + half, pen.BLUE)]
        if half.max() > 2 * _SEEN * (most - least)
        else []
    )
    layers = [
        Polyline(omega, np.degrees(angle), pen.RED, look={"zorder": 3}),
        *bars,
        Mark(at, measured, pen.BLUE, size=2.4, styled=True, look={"zorder": 2}),
    ]
    return Panel(
        layers,
        _along(at, a.frequency),
        DrawnAxis("phase (deg)", ends=(least - room, most + room)),
        height=1.1,
    )


def residuals(a: Identification) -> Panel:
    """Measured less model, real and imaginary part, in units of their standard error, between lines
    at plus and minus 2."""
    drawn = _thinned(len(a.fit.lines))
    at, errors = a.fit.lines.omega[drawn], a.fit.residuals[drawn]
    if a.fit.lines.discs is None:
        # Without discs no standard error is known: their own scatter is taken. The mean of |r|^2 is
        # the sum of the variances of both parts, hence the half.
        errors = errors / (np.sqrt(np.square(np.abs(errors)).mean() / 2) or 1.0)
    top = max(3.0, 1.1 * float(np.abs(np.concatenate([errors.real, errors.imag])).max()))
    lines = [
        Limit(y, stroke=pen.DASHED if y else pen.SOLID, width=0.5, look={"zorder": 0})
        for y in (-2, 0, 2)
    ]
    look = {"markeredgewidth": 0.6}
    layers = [
        *lines,
        Mark(at, errors.real, size=2.4, label=r"$\mathrm{Re}$", styled=True, look=look),
        Mark(
            at,
            errors.imag,
            shape="s",
            size=2.4,
            face="white",
            label=r"$\mathrm{Im}$",
            styled=True,
            look=look,
        ),
    ]
    return Panel(
        layers, _along(at, a.frequency), DrawnAxis("residual / error", ends=(-top, top)), height=1.0
    )


def _model(a: Identification) -> tuple[Any, Any]:
    """Return frequencies, rad/s, and the model's response there, close enough for a curve."""
    omega = a.fit.lines.omega
    # The same rule as of the axis: evenly spaced as it is seen.
    spread = np.geomspace if omega[-1] > 30 * omega[0] else np.linspace
    at = np.union1d(omega, spread(omega[0], omega[-1], 800)) if len(omega) < _MANY else omega
    return at, Fitted(a.wanted, at).at(a.fit.values)


def _reach(a: Identification) -> Any:
    """Return the radii of the discs; 0 where none are known."""
    discs = a.fit.lines.discs
    return np.zeros(len(a.fit.lines)) if discs is None else discs


IDENTIFICATION = Drawings[Identification](
    {"magnitude": magnitude, "phase": phase, "residuals": residuals},
    {"model": lambda a, style: sheet(magnitude(a), phase(a), residuals(a), style=style)},
)


def zwidth(a: ZWidthFit) -> Panel:
    """Damping against stiffness of walls: those that began to shake, and the limit of the device
    that was fitted to them."""
    k, b = (a.scene.knobs[x] for x in WALL)
    order = np.argsort(a.damping)
    layers = [
        Polyline(a.fitted[order], a.damping[order], label="limit of the fitted device"),
        Mark(a.stiffness, a.damping, label="began to shake"),
    ]
    return Panel(layers, parameter(k), parameter(b))


ZWIDTH = Drawings[ZWidthFit]({"zwidth": zwidth})
