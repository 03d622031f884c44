"""A figure of sensitivities: bars of the elasticities, for each frequency the parameter that moves it most on top."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from sympy import Symbol

from haptisym.errors import NothingToDrawError
from haptisym.figures.style import BLUE, GREY, INK, RED, SMALL, TEXT, WIDTH, save_as
from haptisym.jnd import Part
from haptisym.tex.printer import formula

from .slopes import Sensitive, Slopes

_MOST = 12  # bars of one frequency; the text has them all
_MOST_FREQUENCIES = 12
_TITLES = {Part.REAL: r"$r_\mathrm{r}$ meets its threshold", Part.IMAG: r"$r_\mathrm{i}$ meets its threshold"}


def draw_elasticities(ax: Axes, found: Sensitive, title: str) -> None:
    """A bar for each parameter: per cent by which the frequency moves when the parameter grows by 1 per cent."""
    rows = [x for x in found.ranked if x.elasticity is not None and float(x.elasticity)][:_MOST]
    values = [float(x.elasticity) for x in rows if x.elasticity is not None]
    ax.barh(range(len(rows)), values, height=0.62, color=[BLUE if v > 0 else RED for v in values])
    ax.axvline(0, color=INK, linewidth=0.6)
    ax.set_yticks(range(len(rows)), [f"${formula(Symbol(x.name))}$" for x in rows], fontsize=SMALL)
    ax.invert_yaxis()
    ax.tick_params(labelsize=SMALL, length=2, width=0.5, color=INK)
    ax.tick_params(axis="y", length=0)
    for side in ("top", "right", "left"):
        ax.spines[side].set_visible(False)
    ax.margins(x=0.22)
    for i, v in enumerate(values):
        ax.annotate(f"{v:+.3g}", (v, i), (3 if v > 0 else -3, 0), textcoords="offset points",
                    ha="left" if v > 0 else "right", va="center", fontsize=SMALL, color=GREY)  # fmt: skip
    where = f"{found.omega.digits(5)} rad/s{': undefined' if found.reason else ''}"
    ax.set_title(f"{title}\n{where}", fontsize=TEXT, loc="left")


def save_elasticities(found: Slopes, path: Path) -> None:
    """The bars of all crossings in one file; SceneError for another ending than .svg, .pdf or .png, or where there are none."""
    panels = _panels(found)
    if not panels:
        raise NothingToDrawError("there is no crossing nor changeover on the band that parameters could move")
    rows = [min(sum(bool(p.elasticity and float(p.elasticity)) for p in x.parameters), _MOST) for _, x in panels]
    figure = Figure(figsize=(WIDTH, sum(0.19 * n + 0.62 for n in rows) + 0.3), layout="constrained")
    axes = figure.subplots(len(panels), 1, squeeze=False, sharex=True, height_ratios=[n + 1 for n in rows])[:, 0]
    for ax, (title, x) in zip(axes, panels, strict=True):
        draw_elasticities(ax, x, title)
    more = len(found.crossings) + len(found.changeovers_environment) + len(found.changeovers_perceived) - len(panels)
    rest = f"\n({more} more frequencies in the text)" if more > 0 else ""
    axes[-1].set_xlabel(rf"elasticity, $(p/\omega)\,\mathrm{{d}}\omega/\mathrm{{d}}p${rest}", fontsize=TEXT)
    save_as(figure, path)


def _panels(found: Slopes) -> Sequence[tuple[str, Sensitive]]:
    crossings = [(_TITLES[x.part], x) for x in found.crossings if x.part]
    env, perc = found.changeovers_environment, found.changeovers_perceived
    systems = ((r"H_\mathrm{env}", env), (r"H_\mathrm{perc}", perc))
    changeovers = [(rf"$\mathrm{{Re}}\,{name} = 0$", x) for name, listed in systems for x in listed]
    return (crossings + changeovers)[:_MOST_FREQUENCIES]
