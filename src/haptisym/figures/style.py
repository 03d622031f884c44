"""What figures share: thin lines, colours, numbers and names as they are set, legends above the axes."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.collections import PolyCollection
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, MaxNLocator, ScalarFormatter
from matplotlib.transforms import ScaledTranslation
from sympy import Symbol

from haptisym.figures import pen
from haptisym.figures.scales import Scale
from haptisym.judge.criteria import Criterion
from haptisym.model.quantities import MotionKind, unit_text
from haptisym.programs.values import Array
from haptisym.writing.texprinter import formula

CURVES = ((pen.BLUE, pen.SOLID, r"H_\mathrm{env}"), (pen.RED, pen.DASHED, r"H_\mathrm{perc}"))
MOST_LABELS, MOST_NUMBERS = 4, 8


def written(x: Criterion) -> str:
    """The symbol of what a criterion judges, for a legend or an axis."""
    return f"${_index(x.symbol)}$"


def threshold_symbol(x: Criterion) -> str:
    """Its threshold, with the index that the symbol has."""
    return f"${_index(re.sub('^[^_]*', 'c', x.symbol))}$"


def _index(symbol: str) -> str:
    return re.sub(r"_(\w+)", r"_\\mathrm{\1}", symbol)


@dataclass(frozen=True)
class Look:
    """How one of perhaps several scenes is drawn on the same axes.

    ``color``: the caller's, or the next one; ``given``: whether the caller chose it. ``suffix``: what its entries in the legend
    end with. ``number``: of scenes that were drawn before.
    """

    color: str
    given: bool
    suffix: str
    number: int

    @classmethod
    def on(cls, ax: Axes, name: str, color: str | None, label: str) -> Look:
        """The look of a scene on axes where each one has an entry of that name in the legend."""
        number = sum(text.startswith((f"{name}, ", f"{name} (")) or text == name for text in entries(ax))
        suffix = f", {label}" if label else f" ({number + 1})" if number else ""
        return cls(color or pen.SCENES[number % len(pen.SCENES)], color is not None, suffix, number)

    @property
    def plain(self) -> bool:
        """Whether the scene is alone so far, and drawn in the usual colours."""
        return not (self.given or self.number)

    def ink(self, usual: str) -> str:
        """The colour of something that usually has one of its own."""
        return usual if self.plain else self.color


def thin(ax: Axes) -> None:
    """Thin lines and no box."""
    ax.tick_params(labelsize=pen.SMALL, width=0.5, length=2.5, color=pen.GREY)
    ax.spines[["top", "right"]].set_visible(False)
    for spine in ax.spines.values():
        spine.set(linewidth=0.5, color=pen.GREY)


def dress(ax: Axes, x: str = "", y: str = "") -> None:
    """Thin lines, no box, few and plain numbers; ``x``, ``y`` : the labels of the axes, which stay as they are if not given."""
    thin(ax)
    for axis, label in ((ax.xaxis, x), (ax.yaxis, y)):
        axis.set_major_formatter(_Plain())
        axis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10]))
        if label:
            axis.set_label_text(label, fontsize=pen.TEXT)


def dress_rows(ax: Axes, names: Sequence[str], size: float = pen.SMALL) -> None:
    """Of axes with rows that have names, the first on top: no lines but the lower one."""
    ax.set_yticks(range(len(names)), names, fontsize=size)
    ax.set_ylim(len(names) - 0.5, -0.5)
    ax.tick_params(labelsize=pen.SMALL, length=2, width=0.5, color=pen.INK)
    ax.tick_params(axis="y", length=0, labelsize=size)
    ax.spines[["top", "right", "left"]].set_visible(False)


def draw_origin(ax: Axes) -> None:
    """Thin lines through 0, both ways."""
    ax.axhline(0, color=pen.GREY, linewidth=0.4, zorder=0)
    ax.axvline(0, color=pen.GREY, linewidth=0.4, zorder=0)


class _Plain(ScalarFormatter):
    """All decimals of all ticks; powers of ten only where numbers would be long."""

    def __init__(self) -> None:
        super().__init__(useOffset=False)
        self.set_scientific(False)

    def __call__(self, x: float, pos: int | None = None) -> str:
        most = float(np.abs(self.axis.get_view_interval()).max()) if self.axis else 1.0
        return number(x) if not 1e-3 <= most < 1e6 else super().__call__(x, pos)


_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def number(value: float, digits: int = 6) -> str:
    """A number as print has it: a real minus, and powers of ten with an exponent that is raised.

    >>> number(-0.5), number(2.79e-05, 3), number(1e-7), number(12.0)
    ('−0.5', '2.79·10⁻⁵', '10⁻⁷', '12')
    """
    mantissa, _, exponent = f"{value:.{digits}g}".partition("e")
    power = f"10{str(int(exponent)).translate(_RAISED)}" if exponent else ""
    shown = {"1": power, "-1": f"-{power}"}.get(mantissa, f"{mantissa}·{power}") if power else mantissa
    return shown.replace("-", "−")


def raised(text: str) -> str:
    """A text with its powers and differences as print has them.

    >>> raised("grid of 10^4, 10^-3"), raised("H_perc - H_env")
    ('grid of 10⁴, 10⁻³', 'H_perc − H_env')
    """
    text = text.replace(" - ", " − ")
    return re.sub(r"\^(-?\d+)", lambda found: found[1].translate(_RAISED), text)


class _Moving(Protocol):
    @property
    def motion(self) -> MotionKind | None: ...


def name_dynamics(axis: Axis, name: str, scene: _Moving) -> None:
    """The label of an axis of force per position, in thousands or millions of its unit where numbers are large."""
    most = np.abs(axis.get_view_interval()).max()
    factor, prefix = next(((f, p) for f, p in ((1e6, "M"), (1e3, "k")) if most >= 100 * f), (1.0, ""))
    unit = "N·m/rad" if scene.motion is MotionKind.ROTATION else "N/m"
    axis.set_label_text(f"${name}$ ({prefix}{unit})", fontsize=pen.TEXT)
    if prefix:
        axis.set_major_formatter(FuncFormatter(lambda value, _: number(value / factor)))


def dress_plane(ax: Axes, scene: _Moving) -> None:
    """The complex plane of dynamics."""
    dress(ax)
    name_dynamics(ax.xaxis, r"\mathrm{Re}\,H", scene)
    name_dynamics(ax.yaxis, r"\mathrm{Im}\,H", scene)


def dress_changes(ax: Axes) -> None:
    """The complex plane of what is noticed: changes as fractions of the environment."""
    dress(ax, r"$\mathrm{Re}\,\Delta H/|H_\mathrm{env}|$", r"$\mathrm{Im}\,\Delta H/|H_\mathrm{env}|$")


def keep_scales(ax: Axes) -> None:
    """Equal scales both ways, where that leaves a drawing."""
    width, height = np.ptp(ax.get_xlim()), np.ptp(ax.get_ylim())
    ax.set_aspect("equal" if 0.25 < width / height < 4 else "auto", adjustable="box")


def shown_length(largest: float, unit: str) -> tuple[float, str]:
    """How many of the unit in which lengths are drawn make one of their own, and that unit: mm for small ones."""
    return (1e3, "mm") if unit == "m" and largest < 0.2 else (1.0, unit)


def name_parameter(name: str, unit: str) -> str:
    """The label of an axis of a parameter: its symbol and its unit.

    >>> name_parameter("omega_n", "rad/s"), name_parameter("zeta", "1")
    ('$\\\\omega_n$ (rad/s)', '$\\\\zeta$')
    """
    symbol = f"${formula(Symbol(name))}$"
    return symbol if unit in ("", "1") else f"{symbol} ({unit_text(unit)})"


def name_frequency(ax: Axes, scale: Scale) -> None:
    """The label of the horizontal axis where that is frequency."""
    ax.set_xlabel(scale.label, fontsize=pen.TEXT)


def limit(ax: Axes, x: tuple[float, float], y: tuple[float, float], *, number: int = 0) -> None:
    """Limits of the axes; wide enough for what was drawn before, too, if that is some number of scenes."""
    for asked, get, put in ((x, ax.get_xlim, ax.set_xlim), (y, ax.get_ylim, ax.set_ylim)):
        low, high = get() if number else asked
        put(min(low, asked[0]), max(high, asked[1]))


def rectangles(ax: Axes, x: Array, y: Array, color: str, zorder: float = 0) -> None:
    """Rectangles side by side, without a seam: from where to where they go, a column each."""
    (a, b), (c, d) = x, y
    corners = np.stack([np.stack(corner, -1) for corner in ((a, c), (b, c), (b, d), (a, d))], 1)
    ax.add_collection(PolyCollection(list(corners), facecolors=color, linewidths=0, antialiased=False, zorder=zorder))


def text_width(ax: Axes, text: str) -> float:
    """About the width of a small text with a margin, as a fraction of the axes."""
    return (0.54 * max(map(len, text.split("\n"))) + 0.7) * em(ax)


def em(ax: Axes) -> float:
    """The size of a small text, as a fraction of the width of the axes."""
    return pen.SMALL * ax.figure.dpi / (72 * ax.bbox.width)


def entries(ax: Axes) -> dict[str, Any]:
    """What the legend of the axes holds: from each label to its handle."""
    found = ax.get_legend()
    return dict(zip([x.get_text() for x in found.get_texts()], found.legend_handles, strict=True)) if found else {}


def legend(ax: Axes, handles: Iterable[Artist], *, lines: int = 0) -> int:
    """The legend above the axes, where no curve is, and above that many lines of other text; how many rows it has.

    Entries of a legend that is there already stay; no label occurs twice.
    """
    told = entries(ax)
    for x in handles:
        told.setdefault(str(x.get_label()), x)
    columns = _columns(ax, list(told))
    raised = ScaledTranslation(0, (0.5 + 1.9 * lines) * pen.SMALL / 72, ax.figure.dpi_scale_trans)
    ax.legend(
        handles=list(told.values()), labels=list(told), ncols=columns, loc="lower left",
        bbox_to_anchor=(0, 1), bbox_transform=ax.transAxes + raised, borderaxespad=0, borderpad=0, fontsize=pen.SMALL,
        frameon=False, handlelength=2.2, handletextpad=0.5, columnspacing=1.2, labelspacing=0.3,
    )  # fmt: skip
    return -(-len(told) // columns)


def _columns(ax: Axes, labels: Sequence[str]) -> int:
    """The most columns of a legend that together are no wider than the axes."""
    widths = [text_width(ax, _as_seen(label)) + 3.2 * em(ax) for label in labels]
    for columns in range(len(labels), 1, -1):
        if sum(max(column) for column in np.array_split(widths, columns)) - 1.2 * em(ax) <= 1.05:
            return columns
    return 1


def _as_seen(label: str) -> str:
    """A label without the marks of its mathematics."""
    return re.sub(r"\\[a-z]+|[\\${}_,]", "", label)


def curves(look: Look) -> tuple[tuple[str, Any, str], ...]:
    """Colour, style and name of the curves of H_env and H_perc: blue and red, or both in the colour of a scene."""
    return CURVES if look.plain else tuple((look.color, style, name) for _, style, name in CURVES)


def curve_handles(look: Look, before: str = "", after: str = "") -> list[Line2D]:
    """Entries of the legend for the curves of H_env and H_perc."""
    rows = curves(look)
    return [handle(color, style, f"${before}{name}{after}${look.suffix}") for color, style, name in rows]


def handle(color: str, style: Any, label: str, width: float = 1.1, **marker: Any) -> Line2D:
    """An entry of the legend: a line, a mark, or words alone."""
    return Line2D([], [], color=color, linestyle=style, linewidth=width, label=label, **marker)


def dots(size: float, shape: str = "o", **more: Any) -> dict[str, Any]:
    """The style of marks that no line joins."""
    return {"linestyle": "none", "marker": shape, "markersize": size, **more}


def entry(label: str) -> Line2D:
    """A legend entry of words alone."""
    return handle(pen.INK, "none", label)


def plate(color: str) -> dict[str, Any]:
    """What keeps a text readable on a curve."""
    return {"facecolor": color, "edgecolor": "none", "pad": 0.6}


def write_note(ax: Axes, text: str) -> None:
    """A sentence in the middle of the axes, at the top."""
    ax.text(0.5, 0.97, text, transform=ax.transAxes, ha="center", va="top", fontsize=pen.SMALL, bbox=plate(pen.SHADE))
