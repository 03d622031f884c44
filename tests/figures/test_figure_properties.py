"""What holds of every figure that the package writes: readable words, real signs, a legend for what is drawn, no text on another."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from functools import cache
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from marks import often
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.text import Annotation, Text

import haptisym as hs
from haptisym.figures.bandwidths import draw_bandwidths
from haptisym.figures.effects import draw_influences
from haptisym.figures.family import save_family_figures
from haptisym.figures.files import save_figures
from haptisym.figures.jnd import draw_jnd
from haptisym.figures.metrics import draw_measures, draw_verdicts
from haptisym.figures.nyquist import HEAD, draw_nyquist
from haptisym.figures.pen import SHADE
from haptisym.figures.projections import draw_projections
from haptisym.figures.ratios import draw_ratios
from haptisym.figures.sensitivity import draw_elasticities
from haptisym.figures.simulate import draw_loop, draw_recovered, draw_time, save_simulation_figures
from haptisym.figures.square import draw_jnd_square
from haptisym.figures.tolerances import draw_tolerances
from haptisym.verbs.jnd.answers import Answers, Row
from haptisym.verbs.sweep.swept import Swept

NATURAL, MASS = "effects.filter.omega_n", "environment.m"
RESONANT = "two-mass-resonance"


def paper() -> hs.Scene:
    return hs.load_scene("fu2019")


def evaluated(name: str) -> Callable[[Path], object]:
    return lambda folder: save_figures(hs.evaluate(hs.load_scene(name)), folder, [".svg"])


def ranged(cutoff: str) -> hs.Scene:
    """Two parameters that vary, whose box is searched in a moment."""
    spring = hs.environments.mass_spring_damper(k="100 N/m +- 10 %")
    return hs.Scene(spring, (hs.effects.first_order_lag(f"{cutoff} +- 10 %"),))


def mapped(*ranges: tuple[Any, Any]) -> Callable[[Path], object]:
    return lambda folder: hs.design_map(paper(), ["omega_n", "zeta"], list(ranges), slices=5).save_figure(
        folder / "x.svg"
    )


def swept(values: dict[str, Any]) -> Swept:
    return Swept(paper(), hs.sweep(paper(), values))


def answered(*shifts: int, alternatives: int | None = None) -> tuple[hs.Psychometric, ...]:
    """What people answered, each with counts that are a little larger."""
    base = 20 if alternatives else 3
    counts = [[base + shift + (x * (30 - base)) // 5 for x in range(6)] for shift in shifts]
    rows = [tuple(Row(4.4 + 0.3 * i, k, 40) for i, k in enumerate(row)) for row in counts]
    return tuple(hs.jnd(Answers("answers", x), alternatives=alternatives) for x in rows)


KINDS: dict[str, Callable[[Path], object]] = {
    "evaluate": evaluated("fu2019"),
    "evaluate in Hz": evaluated("steering-wheel"),
    "evaluate a resonance": evaluated(RESONANT),
    "several environments": lambda folder: save_family_figures(
        hs.evaluate_all(hs.load_scenes("palpation-device")), folder
    ),
    "evaluate a range of thresholds": lambda folder: save_figures(
        hs.evaluate(hs.load_scene(RESONANT).with_values({"c": ["0.02", "0.1", "0.4"]})), folder
    ),
    "a measured JND": lambda folder: answered(3)[0].save_figure(folder / "x.svg"),
    "a JND of a forced choice": lambda folder: answered(3, alternatives=2)[0].save_figure(folder / "x.svg"),
    "require": lambda folder: hs.require(paper(), "omega_n").save_figure(folder / "x.svg"),
    "require a JND": lambda folder: hs.require(paper(), "evaluation.jnd").save_figure(folder / "x.svg"),
    "require, in vain": lambda folder: hs.require(paper(), "omega_n", (5, 20)).save_figure(folder / "x.svg"),
    "map": mapped((60, 200), ("0.1", 1)),
    "map, in vain": mapped((10, 20), ("0.1", 1)),
    "sweep": lambda folder: swept({MASS: np.linspace(0.5, 5, 30)}).save_figure(folder / "x.svg"),
    "sweep in the plane": lambda folder: swept(
        {NATURAL: np.linspace(20, 200, 12), MASS: np.linspace(0.5, 5, 12)}
    ).save_figure(folder / "x.svg"),
    "sensitivity": lambda folder: hs.sensitivity(hs.load_scene(RESONANT)).save_figure(folder / "x.svg"),
    "tolerances": lambda folder: hs.tolerances(ranged("40 rad/s"), samples=20).save_figure(folder / "x.svg"),
    "effects": lambda folder: hs.relevance(hs.load_scene("sidestick")).save_figure(folder / "x.svg"),
    "metrics": lambda folder: hs.metrics(paper()).save_figure(folder / "x.svg"),
    "simulate": lambda folder: save_simulation_figures([hs.simulate(paper(), hs.sine("5 cm", "10 rad/s"))], folder),
}


SLOW_KINDS = {
    "evaluate in Hz", "evaluate a resonance", "evaluate a range of thresholds", "a measured JND", "require a JND", "require, in vain",
    "map, in vain", "sweep in the plane", "a JND of a forced choice", "several environments", "metrics",
}  # fmt: skip
"""Those that draw as others do, and take longer."""


@pytest.fixture(scope="module", params=often(KINDS, lambda kind: kind not in SLOW_KINDS))
def figures(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> list[Figure]:
    return written(KINDS[request.param], tmp_path_factory.mktemp("figures"))


def written(draw: Callable[[Path], object], folder: Path) -> list[Figure]:
    """The figures that are written, each once, though not to files."""
    found: dict[int, Figure] = {}
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(Figure, "savefig", lambda self, *_args, **_options: found.setdefault(id(self), self))
        draw(folder)
    assert found
    for figure in found.values():
        figure.draw_without_rendering()
    return list(found.values())


def texts(figure: Figure) -> list[Text]:
    """What can be read, on axes and beside them; labels of ticks off the axes cannot."""
    hidden = {id(text) for ax in figure.findobj(Axes) for text in _unseen(ax)}
    every = [text for text in figure.findobj(Text) if text.get_visible() and text.get_text().strip()]
    return [text for text in every if id(text) not in hidden]


def _unseen(ax: Any) -> Iterator[Text]:
    if not ax.axison:
        yield from (
            *ax.get_xticklabels(which="both"),
            *ax.get_yticklabels(which="both"),
            ax.xaxis.label,
            ax.yaxis.label,
        )
        return
    for axis, is_x in ((ax.xaxis, True), (ax.yaxis, False)):
        seen = {id(x) for tick in axis._update_ticks() for x in (tick.label1, tick.label2) if x.get_visible()}
        every = [x for tick in (*axis.majorTicks, *axis.minorTicks) for x in (tick.label1, tick.label2)]
        yield from (x for x in every if id(x) not in seen)
        assert is_x or not axis.get_offset_text().get_text()


@pytest.mark.few(4)
def test_no_text_is_a_path_of_the_configuration(figures: list[Figure]) -> None:
    for text in (x for figure in figures for x in texts(figure)):
        assert not re.search(r"\b(effects|environments?|evaluation|rendered)\.|\w_\w+\.\w", text.get_text()), text


@pytest.mark.few(4)
def test_signs_and_powers_are_those_of_print(figures: list[Figure]) -> None:
    """Formulas (between dollars) are set by matplotlib, which does it well."""
    for text in (x for figure in figures for x in texts(figure)):
        plain = re.sub(r"\$[^$]*\$", "", text.get_text())
        assert not re.search(r"(?<!\w)-\d|\d\^|\de[-+]?\d|\bus\b", plain), text


@pytest.mark.few(4)
def test_what_is_labelled_is_in_the_legend_once(figures: list[Figure]) -> None:
    for ax in (x for figure in figures for x in figure.axes):
        legend = ax.get_legend()
        entries = [text.get_text() for text in legend.get_texts()] if legend else []
        assert len(entries) == len(set(entries))
        labels = {str(x.get_label()) for x in (*ax.lines, *ax.patches, *ax.collections)}
        own = {x for x in labels if x and not x.startswith("_")} - {"tolerance"}  # that is named where its line ends
        assert own <= set(entries), own - set(entries)


def look(line: Line2D) -> tuple[str, str, str]:
    """Colour, stroke and mark."""
    stroke = str(line.get_linestyle()) if len(line.get_xdata()) != 1 else "None"
    return to_hex(line.get_color()), stroke, str(line.get_marker())


@pytest.mark.few(4)
def test_every_line_drawn_looks_like_an_entry_of_the_legend(figures: list[Figure]) -> None:
    """Thin grey ones apart: axes through 0, and what ties a text to its place."""
    for ax in (x for figure in figures for x in figure.axes if x.get_legend()):
        told = {look(x) for x in ax.get_legend().legend_handles if isinstance(x, Line2D)}
        strokes = {x[:2] for x in told}
        for line in ax.lines:
            is_aid = line.get_linewidth() <= 0.6 and line.get_linestyle() in (":", "--", "-")
            if len(line.get_xdata()) and not is_aid and line.get_marker() == "None":
                assert look(line)[:2] in strokes or line.get_alpha(), (look(line), told)


def overlaps(figure: Figure) -> list[tuple[str, str]]:
    """Pairs of texts that lie on each other, and texts that leave the figure beside nothing."""
    boxes = [(text.get_text(), Text.get_window_extent(text)) for text in texts(figure)]
    frame = figure.bbox
    found = [
        (text, "")
        for text, box in boxes
        if box.x0 < frame.x0 - 1 or box.y0 < frame.y0 - 1 or box.x1 > frame.x1 + 1 or box.y1 > frame.y1 + 1
    ]
    for (text, box), (other_text, other) in combinations(boxes, 2):
        wide = min(box.x1, other.x1) - max(box.x0, other.x0)
        high = min(box.y1, other.y1) - max(box.y0, other.y0)
        if min(wide, high) >= 1.5:
            found.append((text, other_text))
    return found


@pytest.mark.few(4)
def test_no_text_lies_on_another_or_leaves_the_figure(figures: list[Figure]) -> None:
    for figure in figures:
        assert overlaps(figure) == []


@pytest.mark.slow
def test_where_a_peak_is_cut_is_told_with_an_exponent_of_print(tmp_path: Path) -> None:
    """It was 5·10⁸ at 1e+12."""
    spring = hs.environments.mass_spring_damper(m="1e-12 kg", k="1e12 N/m")
    ringing = hs.Scene(spring, (hs.effects.second_order_lowpass("1e12 rad/s", "1e-9"),), (0, "1e13 rad/s"))
    for figure in written(lambda folder: save_figures(hs.evaluate(ringing), folder, [".svg"]), tmp_path):
        assert not [x.get_text() for x in texts(figure) if re.search(r"\de[+-]?\d", x.get_text())]


@pytest.mark.slow
def test_environments_of_long_names_leave_room_for_what_is_drawn(tmp_path: Path) -> None:
    """A name of thirty letters took the axes' whole width; matplotlib warned, which is an error here."""
    paper_like = hs.load_scene("fu2019")
    names = (
        "soft",
        "hard with a long name, indeed",
        "of so many words that no figure of one column has the room for them all",
    )
    found = hs.evaluate_all(hs.SceneFamily(dict.fromkeys(names, paper_like)), regions=True)
    for figure in written(lambda folder: save_family_figures(found, folder), tmp_path):
        assert overlaps(figure) == []
        for ax in figure.axes:
            assert ax.get_window_extent().width > 0.4 * figure.bbox.width


@pytest.mark.few(4)
def test_bars_are_equally_thick(figures: list[Figure]) -> None:
    heights = {
        round(bar.get_window_extent().height, 1)
        for figure in figures
        for ax in figure.axes
        for bars in ax.containers
        for bar in bars
    }
    assert len(heights) <= 1


# Two scenes on one axes.


def scenes() -> tuple[hs.Scene, hs.Scene]:
    return paper(), paper().with_values({"omega_n": 50})


@cache
def evaluations() -> tuple[hs.Evaluation, ...]:
    return tuple(map(hs.evaluate, scenes()))


@cache
def runs() -> tuple[Any, ...]:
    return tuple(hs.simulate(scene, hs.sine("5 cm", "10 rad/s")) for scene in scenes())


def bandwidths() -> tuple[hs.Evaluation, ...]:
    return tuple(hs.evaluate(x.with_values({"c": ["0.02", "0.1", "0.16"]})) for x in scenes())


Draw = Callable[..., Any]
PAIRS: dict[str, tuple[Draw, Callable[[], tuple[Any, ...]]]] = {
    "ratios": (draw_ratios, evaluations),
    "bandwidths": (draw_bandwidths, bandwidths),
    "JND": (draw_jnd, lambda: answered(0, 4)),
    "nyquist": (draw_nyquist, evaluations),
    "projections": (lambda ax, e, **look: draw_projections(ax, e, hs.Part.REAL, **look), evaluations),
    "square": (lambda ax, e, **look: draw_jnd_square(ax, e, 10, **look), evaluations),
    "time": (draw_time, runs),
    "loop": (draw_loop, runs),
    "recovered": (lambda ax, run, **look: draw_recovered(ax, [run], hs.Part.REAL, **look), runs),
    "measures": (draw_measures, lambda: tuple(map(hs.metrics, scenes()))),
    "verdicts": (draw_verdicts, lambda: tuple(map(hs.metrics, scenes()))),
    "influences": (
        lambda ax, found, **look: draw_influences(ax, found, hs.Part.REAL, **look),
        lambda: tuple(map(hs.relevance, scenes())),
    ),
    "elasticities": (
        lambda ax, found, **look: draw_elasticities(ax, found.crossings[0], "first", **look),
        lambda: tuple(map(hs.sensitivity, scenes())),
    ),
    "tolerances": (
        draw_tolerances,
        lambda: tuple(hs.tolerances(ranged(x), samples=5) for x in ("40 rad/s", "25 rad/s")),
    ),
}


def drawn_twice(name: str, *looks: dict[str, Any]) -> tuple[Axes, list[list[Artist]]]:
    draw, made = PAIRS[name]
    ax = Figure(figsize=(6, 5)).add_subplot()
    return ax, [list(draw(ax, one, **look)) for one, look in zip(made(), looks, strict=True)]


def colours(artists: list[Artist]) -> set[str]:
    own = [x.get_color() if isinstance(x, Line2D) else getattr(x, "get_edgecolor", lambda: "none")() for x in artists]
    faces = [x.get_facecolor() for x in artists if isinstance(x, Rectangle)]
    return {to_hex(x) for x in (*own, *faces) if not isinstance(x, str) or x != "none"}


@pytest.mark.few(3)
@pytest.mark.parametrize("name", PAIRS)
def test_two_scenes_are_drawn_on_one_axes(name: str) -> None:
    ax, (first, second) = drawn_twice(name, {"label": "quick"}, {"label": "slow", "color": "#009900"})
    assert first
    assert second
    legend = ax.get_legend()
    words = [text.get_text() for text in (legend.get_texts() if legend else ax.texts)]
    assert len(words) == len(set(words))
    for label in ("quick", "slow"):
        assert any(label in word for word in words)
    assert name == "square" or "#009900" in colours(second)
    assert "#009900" not in colours(first)
    shaded = {
        tuple(np.round(x.get_window_extent().extents, 3)) for x in ax.patches if to_hex(x.get_facecolor()) == SHADE
    }
    assert len(shaded) == sum(to_hex(x.get_facecolor()) == SHADE for x in ax.patches)  # none twice


@pytest.mark.parametrize("name", ["ratios", "nyquist", "projections", "measures", "recovered"])
def test_scenes_without_labels_are_numbered_and_limits_hold_both(name: str) -> None:
    ax, both = drawn_twice(name, {}, {})
    words = [text.get_text() for text in ax.get_legend().get_texts()]
    assert len(words) == len(set(words))
    assert any(word.endswith("(2)") for word in words)
    low, high = ax.get_xlim()
    for line in (x for artists in both for x in artists if isinstance(x, Line2D)):
        x = np.asarray(line.get_xdata(), dtype=float)
        assert low - 1e-9 <= np.nanmin(x)
        assert np.nanmax(x) <= high + 1e-9


def test_an_axes_keeps_its_unit_of_frequency() -> None:
    ax = Figure().add_subplot()
    draw_ratios(ax, hs.evaluate("steering-wheel"))
    [line, _] = draw_ratios(ax, evaluations()[0])
    assert ax.get_xlabel() == "frequency (Hz)"
    assert np.max(line.get_xdata()) == pytest.approx(15 / (2 * np.pi))
    [line, _] = draw_ratios(Figure().add_subplot(), evaluations()[0], hertz=True)
    assert np.max(line.get_xdata()) == pytest.approx(15 / (2 * np.pi))


def test_the_shaft_of_an_arrow_ends_where_its_head_begins() -> None:
    figure = Figure(figsize=(4, 4))
    ax = figure.add_subplot()
    draw_jnd_square(ax, evaluations()[0], 10)
    figure.draw_without_rendering()
    arrows = [text for text in ax.texts if isinstance(text, Annotation)]
    for shaft, head in zip(arrows[::2], arrows[1::2], strict=True):
        tip = ax.transData.transform(head.xy)
        end = shaft.arrow_patch.get_path().vertices[-1]
        seen = shaft.arrow_patch.get_transform().transform(end)
        assert np.hypot(*(tip - seen)) == pytest.approx(HEAD * figure.dpi / 72, rel=0.1)


def test_force_in_time_is_in_newtons_and_the_motion_has_an_axis() -> None:
    ax = Figure().add_subplot()
    force, motion = draw_time(ax, runs()[0])
    assert ax.get_ylabel() == "force (N)"
    exact = abs(complex(scenes()[0].distortion().perceived.subs(hs.s, 10j)))  # N/m
    assert np.abs(force.get_ydata()).max() == pytest.approx(0.05 * exact, rel=1e-3)
    [right] = ax.child_axes
    assert right.get_ylabel() == "motion (mm)"
    share = np.abs(motion.get_ydata()).max() / 50  # of 5 cm
    assert right._functions[0](share) == pytest.approx(1, rel=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("name", hs.scene_names())
def test_no_text_lies_on_another_in_any_shipped_scene(name: str, tmp_path: Path) -> None:
    scene = hs.load_scene(name)
    drawings: list[Callable[[Path], object]] = [
        lambda folder: save_figures(hs.evaluate(scene), folder, [".svg"]),
        lambda folder: hs.sensitivity(scene).save_figure(folder / "x.svg"),
        lambda folder: hs.relevance(scene).save_figure(folder / "x.svg"),
        lambda folder: hs.metrics(scene).save_figure(folder / "x.svg"),
    ]
    for draw in drawings:
        try:
            found = written(draw, tmp_path)
        except hs.SceneError:  # nothing to draw
            continue
        for figure in found:
            assert overlaps(figure) == []
