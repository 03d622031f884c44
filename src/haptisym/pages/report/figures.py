"""The figures of an evaluation as SVG within a page: they take its colours, in the light and in the dark."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from contextlib import suppress
from io import StringIO

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from haptisym.figures.nyquist import draw_nyquist
from haptisym.figures.projections import draw_projections
from haptisym.figures.ratios import draw_ratios
from haptisym.figures.square import draw_jnd_square
from haptisym.figures.style import BLUE, GREY, INK, RED, SHADE
from haptisym.judge.evaluation import Evaluation
from haptisym.kernel.errors import SceneError
from haptisym.model.jnd import Part
from haptisym.writing.htmltext import Html, element

_COLOURS = {INK: "ink", BLUE: "env", RED: "perc", GREY: "grey", SHADE: "shade", "#ffffff": "paper"}
"""The figures' colours, and the names by which the page's style sheet gives them."""


def ratio_figure(e: Evaluation) -> Html:
    """r_r and r_i over the band, with thresholds, crossings and the transparent bands."""
    return _figure(
        "ratios", (5.0, 2.2), lambda ax: draw_ratios(ax, e),
        "Distortion ratios over the band. Grey: neither exceeds its threshold, the display is transparent. A dot marks "
        "where the ratio of the real part meets its threshold, a ring that of the imaginary part.",
    )  # fmt: skip


def nyquist_figure(e: Evaluation) -> Html:
    """H_env and H_perc in the complex plane."""
    return _figure(
        "nyquist", (3.4, 2.6), lambda ax: draw_nyquist(ax, e),
        "Environment (solid) and what is felt (dashed) in the complex plane; arrows towards higher frequencies.",
    )  # fmt: skip


def projection_figure(e: Evaluation, part: Part) -> Html:
    """The magnitudes of one part, with what is felt."""
    name = "real" if part is Part.REAL else "imaginary"
    return _figure(
        f"projections-{part.value}", (3.4, 2.2), lambda ax: draw_projections(ax, e, part),
        f"Magnitude of the {name} part of environment and of what is felt: bold where the difference is noticed, with "
        "what it is felt as.",
    )  # fmt: skip


def square_figure(e: Evaluation) -> Html:
    """H_env and H_perc at one telling frequency; nothing where the dynamics are infinite wherever one looks."""
    for omega in _telling_frequencies(e):
        with suppress(SceneError):  # infinite just here
            return _square_figure(e, omega)
    return Html()


def _square_figure(e: Evaluation, omega: float) -> Html:
    return _figure(
        "square", (3.4, 2.6), lambda ax: draw_jnd_square(ax, e, omega),
        f"Environment and what is felt at {omega:.4g} rad/s; the grey region holds the changes that are not noticed.",
    )  # fmt: skip


def _telling_frequencies(e: Evaluation) -> Iterator[float]:
    """The middle of the first percept band, else near the end of the band; others beside it."""
    low, high = (
        (e.percepts[0].band.low, e.percepts[0].band.high) if e.percepts else (e.chart.points[0], e.chart.points[-1])
    )
    for share in (0.5, 0.4, 0.6) if e.percepts else (0.95, 0.9, 0.8):
        yield float(low.omega) + share * (float(high.omega) - float(low.omega))


def _figure(name: str, size: tuple[float, float], draw: Callable[[Axes], object], caption: str) -> Html:
    figure = Figure(figsize=size, layout="compressed")
    ax = figure.add_subplot()
    draw(ax)
    figure.draw_without_rendering()
    if ax.get_aspect() == 1:  # equal scales: the height that the data need
        figure.set_figheight(min(0.7 + 2.8 * ax.get_data_ratio(), 3.6))
    legend = ax.get_legend()
    figure.set_figheight(figure.get_figheight() + (legend.get_window_extent().height / figure.dpi if legend else 0.0))
    drawing = _inline(_svg(figure), name, caption)
    return element("figure", drawing, element("figcaption", caption), given={"class": name})


def _svg(figure: Figure) -> str:
    text = StringIO()
    with mpl.rc_context({"svg.hashsalt": "haptisym", "svg.fonttype": "path"}):
        figure.savefig(text, format="svg", metadata={"Date": None}, facecolor="none")
    return text.getvalue()


def _inline(svg: str, name: str, label: str) -> Html:
    """A drawing as an element of the page: no prologue, no comments, own names for its parts, the page's colours."""
    body = re.sub(
        r"<!--.*?-->|<metadata>.*?</metadata>|<style\b.*?</style>", "", svg[svg.index("<svg") :], flags=re.DOTALL
    )
    body = re.sub(r'(\bid="|url\(#|xlink:href="#)', rf"\g<1>{name}-", body)
    body = re.sub(r"\s*\n\s*", " ", body)
    for colour, variable in _COLOURS.items():
        body = body.replace(colour, f"var(--{variable})")
    words = element("title", label)
    head = re.sub(r' (width|height)="[^"]*"', "", body[: body.index(">")], count=2)
    return Html(f'{head} role="img">{words}{body[body.index(">") + 1 :]}')
