"""Figures of what matters: influences of effects, sensitivities to parameters, and other measures
beside the JND's.

Influences: what each effect changes along the band, and which one changes most. Sensitivities: for
each frequency bars of the elasticities, the parameter that moves it most on top. Measures:
``|Gamma|``, relative distortion and ratios, with the bands of each.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np
from flint import arb
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.text import Annotation
from sympy import Symbol

from haptisym.figures import pen
from haptisym.figures.curves import ends_of, is_share, limit_of, sampled, written
from haptisym.figures.evaluation import along
from haptisym.figures.files import Drawings, sheet
from haptisym.figures.layers import (
    DrawnAxis,
    Layer,
    Limit,
    On,
    Panel,
    Polyline,
    fill,
    frame,
    frequency,
    number,
    small,
    spread,
    text_width,
)
from haptisym.kernel.errors import NothingToDrawError, SceneError
from haptisym.model.jnd import Part
from haptisym.model.quantities import Unit
from haptisym.programs.links import series_arithmetic
from haptisym.programs.values import Array
from haptisym.verbs.effects.differences import BandPiece
from haptisym.verbs.effects.relevance import Relevance
from haptisym.verbs.metrics.controlloading import ControlLoading
from haptisym.verbs.metrics.freeresponse import motion_of
from haptisym.verbs.metrics.metric import Metrics
from haptisym.verbs.sensitivity.entry import Sensitive, Sensitivities
from haptisym.writing.characters import printable
from haptisym.writing.latex import formula

# Effects.

_DEPTH = 8  # 2^8 samples along the band
_DECADES = 3.5  # below the tolerance that are shown
_STYLES: tuple[Any, ...] = ("-", (0, (5, 1.5)), (0, (1, 1)), (0, (5, 1.5, 1, 1.5)))


def influences(found: Relevance, part: Part) -> Panel:
    """``|r(full) - r(without it)|`` of each effect over the band: bold where it matters, thin grey
    where it is left out.

    Each curve bears its name at its end.

    >>> from haptisym import load_scene, relevance
    >>> chart = influences(relevance(load_scene("sidestick")), Part.REAL)
    >>> len([layer for layer in chart.layers if isinstance(layer, Polyline)])
    2
    """
    grid, curves = _changes(found, part)
    tolerance, largest = float(found.tolerance), max((float(x.max()) for x in curves), default=0.0)
    middle = tolerance or largest or 1.0
    floor, top = middle * 10**-_DECADES, 2 * max(largest, middle)
    styles = iter(_STYLES * len(curves))
    lines = list[Layer]()
    ends = list[tuple[str, float, bool]]()
    for x, values in zip(found.effects, curves, strict=True):
        color, width, stroke = (pen.INK, 1.2, next(styles)) if x.kept else (pen.GREY, 0.6, "-")
        # A logarithmic axis has no 0. What is a little below the floor stays, so that lines leave
        # the axes and do not end above the rim.
        shown = np.where(values >= floor / 10, values, np.nan)
        kind = Polyline if x.kept else _Quiet
        lines.append(kind(grid, shown, color, stroke, width))
        ends.append((printable(x.effect.name), float(values[-1]), x.kept))
    limit = Limit(tolerance, stroke=pen.DOTTED)
    symbol = r"r_\mathrm{r}" if part is Part.REAL else r"r_\mathrm{i}"
    low, high = (float(x) for x in found.scene.band)
    upright = DrawnAxis(f"change of ${symbol}$", ends=(floor, top), log=True)
    return Panel(
        [limit, *lines, _Ends(ends, tolerance)],
        frequency(found.scene.frequency, (low, high)),
        upright,
        height=1.9,
    )


class _Quiet(Polyline):
    """A curve in its own colour, whatever the scene's."""

    def draw(self, on: On) -> list[Artist]:
        return super().draw(replace(on, number=0, given=False))


def _changes(found: Relevance, part: Part) -> tuple[Array, list[Array]]:
    """Frequencies, and each effect's change of a ratio there."""
    pieces = [BandPiece(_DEPTH, i) for i in range(1 << _DEPTH)]
    with series_arithmetic():
        grid = np.array([float(found.balls.middle(piece)) for piece in pieces])
        indices = range(len(found.effects))
        curves = [
            np.array([found.without(i, part).at_middle(piece) for piece in pieces]) for i in indices
        ]
    return grid, curves


_END = "_end"
"""The mark of names beside the axes, by which those of a scene drawn before are found."""


@dataclass(frozen=True)
class _Ends(Layer):
    """The name of each curve beside its end. Names that would overlap are moved apart, with those
    of earlier scenes."""

    ends: Sequence[tuple[str, float, bool]]
    tolerance: float

    def draw(self, on: On) -> list[Artist]:
        ax = on.ax
        # Names of earlier scenes are placed anew with those of this one, so that none overlap.
        before = [x for x in ax.texts if isinstance(x, Annotation) and x.get_label() == _END]
        rows = [(x.get_text(), float(x.xy[1]), str(x.get_color())) for x in before]
        for old in before:
            old.remove()
        rows += [
            (on.labelled(name), y, on.color if kept else pen.GREY) for name, y, kept in self.ends
        ]
        rows += (
            [("tolerance", self.tolerance, pen.GREY)]
            if not any(name == "tolerance" for name, *_ in rows)
            else []
        )
        # Places are fractions of a logarithmic axis; a value below the axis is named at its lower
        # end, and a curve that is 0 not at all.
        low, high = np.log10(ax.get_ylim())
        seen = sorted(
            (max((np.log10(value) - low) / (high - low), 0.0), name, max(value, 10**low), color)
            for name, value, color in rows
            if value
        )
        height = small(ax) * 1.15 * ax.figure.dpi / (72 * ax.bbox.height)
        places = spread([share for share, *_ in seen], [height] * len(seen))
        leader = {
            "arrowstyle": "-",
            "linewidth": 0.4,
            "color": pen.GREY,
            "shrinkA": 0,
            "shrinkB": 0,
            "relpos": (0, 0.5),
        }
        return [
            ax.annotate(
                name,
                xy=(1, value),
                xytext=(1.05, place),
                xycoords=ax.get_yaxis_transform(),
                textcoords="axes fraction",
                va="center",
                fontsize=small(ax),
                color=color,
                label=_END,
                arrowprops=leader,
            )
            for (_, name, value, color), place in zip(seen, places, strict=True)
        ]


def dominance(found: Relevance) -> Panel:
    """Which effect changes the ratios most, as a strip along the band; a name that has no room is a
    number, told above."""
    low, high = (float(x) for x in found.scene.band)
    return Panel(
        [_Strip(found, styled=True)],
        frequency(found.scene.frequency, (low, high)),
        DrawnAxis(ends=(0, 1)),
        height=0.25,
    )


@dataclass(frozen=True)
class _Strip(Layer):
    """A strip of intervals side by side, each with the name of the effect that changes the ratios
    most there."""

    found: Relevance

    def draw(self, on: On) -> list[Artist]:
        ax, found = on.ax, self.found
        names = list(dict.fromkeys(x.effect.name for x in found.dominance))
        start, end = (float(x) for x in found.scene.band)
        made, narrow, slivers, seen = list[Artist](), list[str](), list[str](), set[str]()
        for x in found.dominance:
            low, high = float(x.low), float(x.high)
            face = pen.SHADE if names.index(x.effect.name) % 2 == 0 else "#c4c4c4"
            made.append(ax.axvspan(*on.x.of((low, high)), facecolor=face, linewidth=0))
            room, name = (high - low) / (end - start), printable(x.effect.name)
            # Three cases: a number where the name does not fit, nothing where a number does not fit
            # either, else the name.
            if text_width(ax, name) >= room > text_width(ax, "1"):
                narrow += [] if name in narrow else [name]
                name = str(narrow.index(name) + 1)
            elif text_width(ax, name) >= room:
                slivers.append(name)
                name = ""
            else:
                seen.add(name)
            middle = float(on.x.of((low + high) / 2))
            ax.text(middle, 0.45, name, ha="center", va="center", fontsize=small(ax), color=pen.INK)
        ax.axis("off")
        title = _dominance_title(narrow, sorted(set(slivers) - seen - set(narrow)))
        ax.set_title(title, fontsize=small(ax), color=pen.GREY, loc="left", pad=2)
        return made


def _dominance_title(narrow: list[str], slivers: list[str]) -> str:
    """Return the title of the strip: what it shows, the names that stand as numbers in it, and
    those of intervals too narrow for a number."""
    names = [", ".join(f"{i} {name}" for i, name in enumerate(narrow, 1))] if narrow else []
    names += [f"too narrow for a name: {', '.join(slivers)}"] if slivers else []
    title = "changes the ratios most"
    full = "; ".join([title, *names])
    # About 70 letters fit above the strip.
    return (
        full if len(full) <= 70 else f"{title}: {len(narrow) + len(slivers)} more in narrow pieces"
    )


def relevance(found: Relevance, style: pen.FigureStyle = pen.SCREEN) -> Figure:
    """Return the influences on both parts, below the strip of which effect changes them most; raise
    SceneError where there are no effects."""
    if not found.effects:
        raise SceneError("figure: the scene has no effects to draw")
    return sheet(
        dominance(found), *(influences(found, part) for part in Part), wide=True, style=style
    )


EFFECTS = Drawings[Relevance](
    {
        **{
            name: partial(influences, part=part)
            for name, part in (("real", Part.REAL), ("imag", Part.IMAG))
        },
        "dominance": dominance,
    },
    {"influences": relevance},
)


# Sensitivities.

_MOST, _MOST_FREQUENCIES = 12, 12
"""Bars of one frequency, and frequencies; the text has them all."""
_ROW, _HEAD, _FOOT, _SIDE = 0.19, 0.46, 0.62, 0.45
"""Inches: a bar with the space around it, a panel's title, the axis below, the names at the left,
at least."""
_NOTHING = "there is no crossing nor changeover on the band that parameters could move"


def elasticities(found: Sensitivities, which: int = -1) -> Panel:
    """A bar for each parameter: per cent by which the frequency moves when the parameter grows by 1
    per cent.

    ``which`` : of the crossings and changeovers; -1 is the bandwidth, or the first where there is
    none. The bars of a further scene on the same axes are narrower, and lie on those of the first.

    >>> from haptisym import load_scene, sensitivity
    >>> len(elasticities(sensitivity(load_scene("fu2019")), 0).y.names)
    6
    """
    listed = _panels(found)
    if not listed:
        raise NothingToDrawError(_NOTHING)
    title, x = (
        ("bandwidth", found.bandwidth) if which < 0 and found.bandwidth else listed[max(which, 0)]
    )
    rows = [(_symbol(p.name), float(p.elasticity)) for p in _moved(x)][:_MOST]
    unit = found.evaluation.scene.frequency
    where = f"{frequency(unit).digits(x.omega, 4)} {unit.text}{': undefined' if x.reason else ''}"
    layers = [_Elastic(rows, f"{title}\n{where}", label="elasticity", styled=True)]
    return Panel(
        layers,
        DrawnAxis(),
        DrawnAxis(names=[name for name, _ in rows]),
        height=_ROW * len(rows) + _HEAD,
    )


def _symbol(name: str) -> str:
    """Return the symbol of a parameter as a formula."""
    return f"${formula(Symbol(name))}$"


def _moved(x: Sensitive) -> list[Any]:
    """Return the parameters that move a frequency, the one that moves it most first."""
    return [p for p in x.ranked if p.elasticity is not None and float(p.elasticity)]


def _panels(found: Sensitivities) -> Sequence[tuple[str, Sensitive]]:
    """Return the crossings and changeovers that are drawn, each with its title."""
    crossings = [
        (f"{written(x.criterion)} crosses its threshold", x) for x in found.crossings if x.criterion
    ]
    env, perc = found.changeovers_environment, found.changeovers_perceived
    systems = ((r"H_\mathrm{env}", env), (r"H_\mathrm{perc}", perc))
    changeovers = [(rf"$\mathrm{{Re}}\,{name} = 0$", x) for name, listed in systems for x in listed]
    return (crossings + changeovers)[:_MOST_FREQUENCIES]


@dataclass(frozen=True)
class _Elastic(Layer):
    """Bars with their values at their ends, and a title."""

    rows: Sequence[tuple[str, float]]
    title: str

    def draw(self, on: On) -> list[Artist]:
        ax, values = on.ax, [v for _, v in self.rows]
        places = [list(on.y.names).index(name) for name, _ in self.rows]
        # In the first scene colours show the sign; bars of a further one have that scene's colour.
        is_first = not (on.number or on.given)
        colors = [pen.BLUE if v > 0 else pen.RED for v in values]
        bars = ax.barh(
            places,
            values,
            height=0.28 if on.number else 0.62,
            color=colors if is_first else on.color,
        )
        if not on.number:
            ax.axvline(0, color=pen.INK, linewidth=0.6)
            ax.set_title(self.title, fontsize=pen.TEXT, loc="left")
            for i, v in zip(places, values, strict=True):
                shown = f"+{number(v, 3)}" if v > 0 else number(v, 3)
                ax.annotate(
                    shown,
                    (v, i),
                    (3 if v > 0 else -3, 0),
                    textcoords="offset points",
                    va="center",
                    ha="left" if v > 0 else "right",
                    fontsize=small(ax),
                    color=pen.GREY,
                )
        ax.margins(x=0.28)
        return list(bars)

    def keys(self, on: On, _made: list[Artist]) -> list[tuple[str, Artist]]:
        is_named = on.number or on.label
        return [(self.label, Patch(color=on.ink(pen.BLUE)))] if is_named else []


def sensitivities(found: Sensitivities, style: pen.FigureStyle = pen.SCREEN) -> Figure:
    """The bars of all crossings and changeovers, a panel each; NothingToDrawError where there are
    none."""
    shown = _panels(found)
    if not shown:
        raise NothingToDrawError(_NOTHING)
    rows = [max(1, min(len(_moved(x)), _MOST)) for _, x in shown]
    # Bars are equally thick in all panels: so heights are in inches, and no layout engine moves the
    # axes.
    figure = Figure(figsize=(pen.WIDTH, sum(_ROW * n + _HEAD for n in rows) + _FOOT))
    axes = list[Axes]()
    for i in range(len(shown)):
        axes.append(
            figure.add_axes((0.1, 0.1, 0.8, 0.8), sharex=axes[0] if axes else None, label=str(i))
        )
        chart = elasticities(found, i)
        fill(frame(axes[-1], chart, style=style), chart)
        axes[-1].tick_params(labelbottom=False)
    longest = max(
        (
            # A letter is about 0.52 of the size of the font wide; points to inches.
            0.52 * style.small * len(x.get_text().strip("$")) / 72
            for ax in axes
            for x in ax.get_yticklabels()
        ),
        default=0.0,
    )
    (width, height), side, top = figure.get_size_inches(), min(max(_SIDE, longest), 1.2), 0.0
    for ax, n in zip(axes, rows, strict=True):
        top += _HEAD + _ROW * n
        ax.set_position(
            (side / width, 1 - top / height, 1 - (side + 0.12) / width, _ROW * n / height)
        )
    more = (
        len(found.crossings)
        + len(found.changeovers_environment)
        + len(found.changeovers_perceived)
        - len(shown)
    )
    rest = f"\n({more} more frequencies in the text)" if more > 0 else ""
    axes[-1].tick_params(labelbottom=True)
    axes[-1].set_xlabel(
        rf"elasticity, $(p/\omega)\,\mathrm{{d}}\omega/\mathrm{{d}}p${rest}", fontsize=pen.TEXT
    )
    return figure


SENSITIVITY = Drawings[Sensitivities](
    {"elasticities": elasticities}, {"elasticities": sensitivities}
)


# Other measures.

_DOTS_AND_DASHES: Any = (0, (5, 1.5, 1, 1.5))
_FINE: Any = (0, (1, 1))
_BAR = 5.0
"""Points: how thick the bars are."""


def measures(m: Metrics) -> Panel:
    """r_r, r_i, |dH/H_env| and | |Gamma| - 1 | over the band, with the thresholds: all are
    fractions of |H_env|.

    >>> from haptisym import load_scene, metrics
    >>> [layer.label for layer in measures(metrics(load_scene("fu2019"))).layers][:2]
    ['$r_\\\\mathrm{r}$', '$r_\\\\mathrm{i}$']
    """
    e = m.evaluation
    omega = sampled(e)
    v = e.distortion.compile()(omega)
    env = np.hypot(v.environment_real, v.environment_imag)
    perc = np.hypot(v.perceived_real, v.perceived_imag)
    relative = np.hypot(v.ratio_real, v.ratio_imag)
    # |Gamma| has no value where H_env is 0, and is drawn as a gap there.
    with np.errstate(divide="ignore", invalid="ignore"):
        size = np.abs(perc / env - 1)
    rows = (
        (v.ratio_real, pen.INK, pen.SOLID, r"$r_\mathrm{r}$"),
        (v.ratio_imag, pen.INK, pen.DASHED, r"$r_\mathrm{i}$"),
        (relative, pen.RED, _DOTS_AND_DASHES, r"$|\Delta H/H_\mathrm{env}|$"),
        (size, pen.BLUE, _FINE, r"$||\Gamma| - 1|$"),
    )
    limits = sorted({limit_of(x) for x in e.criteria if not is_share(x)})
    finite, most = relative[np.isfinite(relative)], max(limits, default=0.1)
    top = max(1.06 * float(finite.max()) if finite.size else 0.0, 1.6 * most)
    layers: list[Layer] = [
        Polyline(omega, values, color, stroke, label=name) for values, color, stroke, name in rows
    ]
    layers += [Limit(c, label=f"$c = {c:.3g}$", shared=True) for c in limits]
    return Panel(
        layers,
        along(e),
        DrawnAxis(r"fraction of $|H_\mathrm{env}|$", ends=(0, min(top, 8 * most))),
        height=2.0,
    )


def verdicts(m: Metrics) -> Panel:
    """A bar for each measure where it is content, the JND's at the top; those of a further scene
    below in its colour."""
    rows, layers = verdict_bands(m), list[Layer]()
    for i, (_, bands) in enumerate(rows):
        layers += [_Verdict(ends, i, label="content") for ends in bands]
    return Panel(
        layers, along(m.evaluation), DrawnAxis(names=[name for name, _ in rows]), height=1.1
    )


@dataclass(frozen=True)
class _Verdict(Layer):
    """A bar in a row, named in the legend where there are several scenes; a stroke at a single
    frequency."""

    ends: tuple[float, float]
    row: int
    styled: bool = field(default=True, kw_only=True)

    def draw(self, on: On) -> list[Artist]:
        (low, high), y = on.x.of(self.ends), [self.row + 0.24 * on.number] * 2
        mark: dict[str, Any] = (
            {"marker": "|", "markersize": 6, "clip_on": False} if low == high else {}
        )
        return list(
            on.ax.plot(
                [low, high], y, color=on.color, linewidth=_BAR, solid_capstyle="butt", **mark
            )
        )

    def keys(self, on: On, made: list[Artist]) -> list[tuple[str, Artist]]:
        return [(self.label, made[0])] if on.label else []


def verdict_bands(m: Metrics) -> list[tuple[str, list[tuple[float, float]]]]:
    """Return the bands on which each verdict is a good one, rad/s, for those that depend on the
    frequency."""
    measured = m.measured
    rows = [
        ("JND", m.evaluation.transparent),
        (r"$|\Delta H/H_\mathrm{env}| \leq c$", measured.within),
        ("within 3 dB", measured.inside),
        (r"$\mathrm{Im}\,H_\mathrm{perc} \geq 0$", measured.passive),
        *([("Llewellyn, axis", measured.llewellyn)] if measured.llewellyn is not None else []),
    ]
    return [(name, [ends_of(x) for x in bands]) for name, bands in rows]


def released(found: ControlLoading) -> Panel:
    """The free response of environment and display, over the displacement; the 5 % from which
    overshoots count."""
    d, layers = found.distortion, list[Layer]()
    motions = [motion_of(x) for x in (d.env, d.perc)]
    known = [x for x in motions if not isinstance(x, str)]
    if len(known) < 2:
        raise NothingToDrawError(
            f"there is no free response to draw: {next(x for x in motions if isinstance(x, str))}"
        )
    end = max(float(x.end) for x in known)
    time = np.linspace(0, end, _TIMES)
    for motion, color, stroke, name in zip(
        known, (pen.INK, pen.RED), (pen.SOLID, pen.DASHED), ("aircraft", "display"), strict=True
    ):
        # The closed form is evaluated in balls, of which a figure takes the middles.
        height = [float(motion.value(arb(t)).mid()) for t in time]
        layers.append(Polyline(time, np.array(height), color, stroke, label=name))
    layers += [Limit(y, stroke=pen.DOTTED, label="5 %", shared=True) for y in (0.05, -0.05)]
    return Panel(
        layers,
        DrawnAxis("time", Unit("s"), (0, end)),
        DrawnAxis("displacement / $A_d$"),
        height=2.0,
    )


_TIMES = 400  # of a drawn free response

CONTROL = Drawings[ControlLoading]({"free-response": released})
METRICS = Drawings[Metrics](
    {"measures": measures, "verdicts": verdicts},
    {"metrics": lambda m, style: sheet(measures(m), verdicts(m), style=style)},
)
