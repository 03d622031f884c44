"""A figure of sensitivities: bars of the elasticities, for each frequency the parameter that moves it most on top."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.container import BarContainer
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from sympy import Symbol

from haptisym.figures import pen
from haptisym.figures.style import RADIANS, Scale, band_scale, dress_rows, entries, legend, number, written
from haptisym.kernel.errors import NothingToDrawError
from haptisym.verbs.sensitivity.entry import Sensitive, Sensitivities
from haptisym.writing.latex import formula

_MOST = 12  # bars of one frequency; the text has them all
_MOST_FREQUENCIES = 12
_ROW, _HEAD, _FOOT, _SIDE = 0.19, 0.46, 0.62, 0.45
"""Inches: a bar with the space around it, a panel's title, the axis below, the names at the left, at least."""


def draw_elasticities(
    ax: Axes, found: Sensitive, title: str, scale: Scale = RADIANS, *, color: str | None = None, label: str = ""
) -> BarContainer:
    """A bar for each parameter: per cent by which the frequency moves when the parameter grows by 1 per cent.

    ``scale`` : the unit of the frequency in the title. ``color``, ``label`` : of the scene; the bars of a further one on the same
    axes are narrower, and lie on those of the first. Returns the bars.

    >>> from haptisym import load_scene, sensitivity
    >>> bars = draw_elasticities(Figure().add_subplot(), sensitivity(load_scene("fu2019")).crossings[0], "first")
    >>> len(bars)
    6
    """
    before = len(ax.containers)
    rows = [x for x in found.ranked if x.elasticity is not None and float(x.elasticity)][:_MOST]
    values = [float(x.elasticity) for x in rows if x.elasticity is not None]
    names = [f"${formula(Symbol(x.name))}$" for x in rows]
    ticks = [text.get_text() for text in ax.get_yticklabels()] if before else []
    ticks += [name for name in names if name not in ticks]
    places = [ticks.index(name) for name in names]
    one = color or (pen.SCENES[before] if before else None)
    bars = ax.barh(
        places, values, height=0.28 if before else 0.62, color=one or [pen.BLUE if v > 0 else pen.RED for v in values]
    )
    if not before:
        ax.axvline(0, color=pen.INK, linewidth=0.6)
        where = f"{scale.digits(found.omega, 5)} {scale.unit}{': undefined' if found.reason else ''}"
        ax.set_title(f"{title}\n{where}", fontsize=pen.TEXT, loc="left")
        _write_values(ax, values)
    dress_rows(ax, ticks)
    ax.margins(x=0.28)
    if label:
        legend(ax, [*entries(ax).values(), Patch(color=one or pen.BLUE, label=label)], lines=2)
    return bars


def draw_first(ax: Axes, found: Sensitivities, *, color: str | None = None, label: str = "") -> list[Patch]:
    """The elasticities of the bandwidth, or of the first frequency where there is none. Returns the bars."""
    listed = [("bandwidth", found.bandwidth)] if found.bandwidth else panels(found)
    if not listed:
        raise NothingToDrawError("there is no crossing nor changeover on the band that parameters could move")
    title, first = listed[0]
    assert first is not None
    scale = band_scale(found.evaluation.scene.band)
    return list(draw_elasticities(ax, first, title, scale, color=color, label=label))


def _write_values(ax: Axes, values: Sequence[float]) -> None:
    """The value of each bar at its end."""
    for i, v in enumerate(values):
        shown = f"+{number(v, 3)}" if v > 0 else number(v, 3)
        ax.annotate(shown, (v, i), (3 if v > 0 else -3, 0), textcoords="offset points",
                    ha="left" if v > 0 else "right", va="center", fontsize=pen.SMALL, color=pen.GREY)  # fmt: skip


def elasticities_figure(found: Sensitivities) -> Figure:
    """The bars of all crossings and changeovers, a panel each; NothingToDrawError where there are none."""
    shown = panels(found)
    if not shown:
        raise NothingToDrawError("there is no crossing nor changeover on the band that parameters could move")
    rows = [max(1, min(sum(bool(p.elasticity and float(p.elasticity)) for p in x.parameters), _MOST)) for _, x in shown]
    figure = Figure(figsize=(pen.WIDTH, sum(_ROW * n + _HEAD for n in rows) + _FOOT))
    scale, axes = band_scale(found.evaluation.scene.band), list[Axes]()
    for title, x in shown:
        axes.append(figure.add_axes((0.1, 0.1, 0.8, 0.8), sharex=axes[0] if axes else None, label=str(len(axes))))
        draw_elasticities(axes[-1], x, title, scale)
        axes[-1].tick_params(labelbottom=False)
    _place(figure, axes, rows)
    more = len(found.crossings) + len(found.changeovers_environment) + len(found.changeovers_perceived) - len(shown)
    rest = f"\n({more} more frequencies in the text)" if more > 0 else ""
    axes[-1].tick_params(labelbottom=True)
    axes[-1].set_xlabel(rf"elasticity, $(p/\omega)\,\mathrm{{d}}\omega/\mathrm{{d}}p${rest}", fontsize=pen.TEXT)
    return figure


def _place(figure: Figure, axes: Sequence[Axes], rows: Sequence[int]) -> None:
    """The panels one below the other, each as high as its bars, beside the longest name."""
    figure.draw_without_rendering()
    longest = max(label.get_window_extent().width for ax in axes for label in ax.get_yticklabels()) / figure.dpi
    (width, height), side, top = figure.get_size_inches(), max(_SIDE, longest + 0.12), 0.0
    for ax, n in zip(axes, rows, strict=True):
        top += _HEAD + _ROW * n
        ax.set_position((side / width, 1 - top / height, 1 - (side + 0.12) / width, _ROW * n / height))


def panels(found: Sensitivities) -> Sequence[tuple[str, Sensitive]]:
    """What is drawn, each with its title."""
    crossings = [(f"{written(x.criterion)} crosses its threshold", x) for x in found.crossings if x.criterion]
    env, perc = found.changeovers_environment, found.changeovers_perceived
    systems = ((r"H_\mathrm{env}", env), (r"H_\mathrm{perc}", perc))
    changeovers = [(rf"$\mathrm{{Re}}\,{name} = 0$", x) for name, listed in systems for x in listed]
    return (crossings + changeovers)[:_MOST_FREQUENCIES]
