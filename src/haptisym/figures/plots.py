"""What ``plot`` of every answer draws: on axes of the caller, several scenes on the same ones."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from inspect import signature
from pkgutil import resolve_name
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from haptisym.figures import pen
from haptisym.figures.style import entries
from haptisym.kernel.errors import NothingToDrawError, meant
from haptisym.model.jnd import Part

if TYPE_CHECKING:
    from haptisym.judge.answers import Answer

Drawing = tuple[Any, ...]
"""The name of what draws, below ``haptisym.figures``, and what it is given besides the answer."""
_PARTS = (("real", Part.REAL), ("imag", Part.IMAG))
_RUNS = {f"recovered-{name}": ("simulate:draw_recovered", part) for name, part in _PARTS}

KINDS: Mapping[str, Mapping[str, Drawing]] = MappingProxyType({
    "evaluation": {
        "ratios": ("ratios:draw_ratios",),
        "nyquist": ("nyquist:draw_nyquist",),
        **{f"projections-{name}": ("projections:draw_projections", part) for name, part in _PARTS},
        "bandwidths": ("bandwidths:draw_bandwidths",),
        "regions": ("regions:draw_regions",),
    },
    "evaluations": {
        "real": ("family:draw_worst", 0),
        "imag": ("family:draw_worst", 1),
        "regions": ("regions:draw_family_regions",),
    },
    "measured": {"ratios": ("measured:draw_measured_ratios",), "nyquist": ("measured:draw_measured_nyquist",)},
    "derivation": {"ratios": ("ratios:draw_formulas",)},
    "effects": {
        **{name: ("effects:draw_influences", part) for name, part in _PARTS},
        "dominance": ("effects:draw_dominance",),
    },
    "requirement": {"worst": ("require:draw_requirement",)},
    "designmap": {"map": ("designmap:draw_map",), "wishes": ("designmap:draw_wishes",)},
    "stability": {"hands": ("stability:draw_stability",)},
    "sensitivity": {"elasticities": ("sensitivity:draw_first",)},
    "tolerances": {"enclosures": ("tolerances:draw_tolerances",), "hands": ("stability:draw_held",)},
    "metrics": {"measures": ("metrics:draw_measures",), "verdicts": ("metrics:draw_verdicts",)},
    "cost": {"time": ("cost:draw_task",)},
    "hardcosts": {"cases": ("cost:draw_cases",)},
    "simulation": {"time": ("simulate:draw_time",), "loop": ("simulate:draw_loop",), **_RUNS},
    "release": {"motion": ("simulate:draw_release",)},
    "identification": {
        "magnitude": ("identify:draw_magnitude",),
        "phase": ("identify:draw_phase",),
        "residuals": ("identify:draw_residuals",),
    },
    "jnd": {"answers": ("jnd:draw_jnd",)},
    "published": {"fractions": ("jnd:draw_published",)},
    "peaks": {"ratios": ("ratios:draw_peaks",)},
    "sweep": {"chart": ("sweep:draw_swept",)},
})  # fmt: skip
"""Of each kind of document what can be drawn of it; the first is drawn unasked."""
_GROUP = "haptisym plot "
_BEFORE = "\u200b"
"""Behind entries of the legend while a further scene is drawn: its own of the same words would be taken for them."""


def plot(found: Answer, ax: Axes | None, kind: str, color: str | None, label: str, style: Mapping[str, Any]) -> Axes:
    """Draw an answer; the axes. ``kind`` : a key of ``KINDS``; the first if empty. Raises NothingToDrawError for any other."""
    name, *given = _drawing(found, kind)
    axes = _axes() if ax is None else ax
    drawn, limits = set(axes.get_children()), (axes.get_xlim(), axes.get_ylim())
    number = len({x.get_gid() for x in drawn if str(x.get_gid()).startswith(_GROUP)})
    draw: Callable[..., Any] = resolve_name(f"haptisym.figures.{name}")
    takes = {"color": color, "label": label} if "label" in signature(draw).parameters else {}
    if number and not takes:
        _renamed(axes, lambda text: f"{text}{_BEFORE}")
    told, suffix = set(entries(axes)), f", {label}" if label else f" ({number + 1})" if number else ""
    try:
        made = _curves(axes, draw(axes, _subject(found, name), *given, **takes), drawn)
        styled = _with_entries(axes, made, told)
    finally:
        if not takes:
            _renamed(axes, lambda text: text.removesuffix(_BEFORE) if text in told else f"{text}{suffix}")
    for artist in set(axes.get_children()) - drawn:
        artist.set_gid(f"{_GROUP}{number + 1}")
    if number:
        _widen(axes, limits)
    own = None if takes else color or (pen.SCENES[number % len(pen.SCENES)] if number else None)
    for artist in styled:
        _coloured(artist, own)
        artist.set(**style)
    return axes


def _drawing(found: Answer, kind: str) -> Drawing:
    kinds = KINDS[_key(found)]
    if kind and kind not in kinds:
        raise NothingToDrawError(
            f'kind: "{kind}" is none of this answer: {meant(kind, kinds)}these are {", ".join(kinds)}'
        )
    if not kind and _key(found) == "designmap" and getattr(found, "that", ()) != ("transparent",):
        kind = "wishes"
    if kind == "regions" and not getattr(found, "regions", ()):
        asked = "evaluate_all(scenes" if _key(found) == "evaluations" else "evaluate(scene"
        raise NothingToDrawError(f"kind: no regions were compared: ask for them with {asked}, regions=True)")
    return kinds[kind or next(iter(kinds))]


def _key(found: Answer) -> str:
    name = found._schema.removeprefix("haptisym.").partition("/")[0]
    return "hardcosts" if type(found).__name__ == "HardCosts" else name


def _subject(found: Any, name: str) -> Any:
    """Of simulations one run, or all of them."""
    if not name.startswith("simulate:") or not hasattr(found, "runs"):
        return found
    runs = found.runs
    return runs if name.endswith("recovered") else runs[len(runs) // 2]


def _axes() -> Axes:
    """New ones, of pyplot: notebooks show them by themselves, and ``plt.show()`` does in a script."""
    from matplotlib import pyplot

    figure = pyplot.figure(figsize=(1.5 * pen.WIDTH, pen.WIDTH), layout="constrained")
    return figure.add_subplot()


def _curves(axes: Axes, returned: Any, before: set[Artist]) -> list[Artist]:
    """What style is for: the curves that a drawing returns, else all its lines."""
    new = set(axes.get_children()) - before
    listed = returned if isinstance(returned, list | tuple) else []
    curves: list[Artist] = [x for x in listed if isinstance(x, Line2D | Patch) and x in new]
    return curves or [x for x in new if isinstance(x, Line2D)]


def _widen(axes: Axes, limits: tuple[tuple[float, float], tuple[float, float]]) -> None:
    """What was drawn before stays in sight."""
    (left, right), (bottom, top) = limits
    x, y = axes.get_xlim(), axes.get_ylim()
    if x[0] < x[1]:
        axes.set_xlim(min(left, x[0]), max(right, x[1]))
    if y[0] < y[1]:
        axes.set_ylim(min(bottom, y[0]), max(top, y[1]))


def _renamed(axes: Axes, name: Callable[[str], str]) -> None:
    """The entries of the legend with other words."""
    legend = axes.get_legend()
    for text in legend.get_texts() if legend else []:
        text.set_text(name(text.get_text()))


def _with_entries(axes: Axes, made: list[Artist], told: set[str]) -> list[Artist]:
    """Curves, and their new entries in the legend: of their label, or of their look where they bear none."""
    labels = {str(x.get_label()) for x in made}
    looks = {_look(x) for x in made if str(x.get_label()).startswith("_")} - {None}
    new = {name: x for name, x in entries(axes).items() if name not in told}
    return [*made, *(x for name, x in new.items() if name in labels or _look(x) in looks)]


def _look(x: Artist) -> tuple[str, str] | None:
    """The colour and stroke of a line."""
    return (to_hex(x.get_color()), str(x.get_linestyle())) if isinstance(x, Line2D) else None


def _coloured(artist: Artist, color: str | None) -> None:
    """A line and its marks, but for what is hollow; a ground stays as it is."""
    if color is not None and isinstance(artist, Line2D):
        hollow = str(artist.get_markerfacecolor()) in ("none", "white")
        artist.set(color=color, markeredgecolor=color)
        if not hollow:
            artist.set_markerfacecolor(color)
