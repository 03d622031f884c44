"""What holds of every figure that the package writes, and the files: readable words, real signs, no text on another, the same bytes again."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import pytest
from drawn import overlaps, texts
from eyes import lightness
from marks import FLEXIBLE
from matplotlib.colors import to_hex, to_rgba_array
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.text import Annotation

import haptisym as hs
from haptisym.figures import evaluation as evaluation_charts
from haptisym.figures import pen
from haptisym.figures.files import draw_figure, save_as, save_figures, sheet
from haptisym.figures.layers import DrawnAxis, Panel, Polyline, draw
from haptisym.figures.pen import checked_report
from haptisym.verbs.jnd.tables import Answers, LevelAnswers
from haptisym.verbs.sweep.entry import Swept

SHEETS = ["ratios", "nyquist", "projections-real", "projections-imag", "jnd-square"]
HEAVY = hs.Hand("heavy", m="600 kg", b="5 kN*s/m", k="20 kN/m")


@cache
def paper() -> hs.Evaluation:
    return hs.evaluate("fu2019")


def sheets(scene: str, *names: str, style: str = "", **more: Any) -> list[Figure]:
    e = hs.evaluate(hs.load_scene(scene).with_values(more) if more else scene)
    return [draw_figure(e, name, style=style) for name in names or SHEETS]


def swept(style: str, **values: Any) -> list[Figure]:
    scene = hs.load_scene("fu2019")
    return [Swept(scene, hs.sweep(scene, values)).figure(style=style)]


def answered(alternatives: int | None, style: str) -> list[Figure]:
    base = 20 if alternatives else 3
    rows = tuple(LevelAnswers(4.4 + 0.3 * i, base + (i * (30 - base)) // 5, 40) for i in range(6))
    return [hs.jnd(Answers("answers", rows), alternatives=alternatives).figure(style=style)]


def loose() -> hs.Scene:
    """Two parameters that vary, whose box is searched in a moment."""
    spring = hs.environments.mass_spring_damper(k="100 N/m +- 10 %")
    return hs.Scene(spring, (hs.effects.first_order_lag("40 rad/s +- 10 %"),))


def measured() -> hs.MeasuredEvaluation:
    exact = hs.sampled("fu2019", np.linspace(1, 15, 15))
    felt = hs.measured(exact.omega, exact.H * 1.02, radius=[4.0] * 15)
    return hs.evaluate(hs.MeasuredScene(hs.load_scene("fu2019").environment, felt))


FIGURES: dict[str, Callable[[str], list[Figure]]] = {
    "evaluation": lambda s: [draw_figure(paper(), name, style=s) for name in SHEETS],
    "in Hz": lambda s: sheets("steering-wheel", style=s),
    "resonance": lambda s: sheets(FLEXIBLE, style=s),
    "thresholds": lambda s: sheets(FLEXIBLE, "bandwidths", style=s, c=["0.02", "0.1", "0.4"]),
    "family": lambda s: [hs.evaluate_all(hs.load_scenes("palpation-device")).figure(style=s)],
    "family, regions": lambda s: [draw_figure(hs.evaluate_all(hs.load_scenes("palpation-device"), regions=True), "regions", style=s)],
    "jnd": lambda s: answered(None, s),
    "forced choice": lambda s: answered(2, s),
    "requirement": lambda s: [hs.require("fu2019", "omega_n").figure(style=s)],
    "requirement on a JND": lambda s: [hs.require("fu2019", "evaluation.jnd").figure(style=s)],
    "requirement, in vain": lambda s: [hs.require("fu2019", "omega_n", (5, 20)).figure(style=s)],
    "map": lambda s: [hs.design_map("fu2019", ["omega_n", "zeta"], [(60, 200), ("0.1", 1)], slices=5).figure(style=s)],
    "map, in vain": lambda s: [hs.design_map("fu2019", ["omega_n", "zeta"], [(10, 20), ("0.1", 1)], slices=5).figure(style=s)],
    "sweep": lambda s: swept(s, m=np.linspace(0.5, 5, 30)),
    "sweep in the plane": lambda s: swept(s, omega_n=np.linspace(20, 200, 12), m=np.linspace(0.5, 5, 12)),
    "comparison": lambda s: [hs.compare("fu2019", "helicopter-cyclic", "sidestick").figure(style=s)],
    "sensitivity": lambda s: [hs.sensitivity(FLEXIBLE).figure(style=s)],
    "tolerances": lambda s: [hs.tolerances(loose(), samples=20).figure(style=s)],
    "effects": lambda s: [hs.relevance("sidestick").figure(style=s)],
    "metrics": lambda s: [hs.metrics("fu2019").figure(style=s)],
    "hands": lambda s: [hs.stability("fu2019", "postural-arm").figure(style=s)],
    "design": lambda s: [hs.design("palpation-device", ["omega_c"]).figure(style=s)],
    "measured": lambda s: [measured().figure(style=s)],
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.few("requirement", "tolerances")
@pytest.mark.parametrize("name", FIGURES)
def test_a_figure_is_one_readable_size_with_words_and_signs_of_print_and_no_text_on_another(name: str) -> None:
    for figure in FIGURES[name](""):
        figure.draw_without_rendering()
        assert overlaps(figure) == []
        assert legend_share(figure) <= 1 / 6
        assert pen.WIDTH - 1e-9 <= figure.get_figwidth() <= 1.5 * pen.WIDTH
        for text in texts(figure):
            said = text.get_text()
            assert text.get_fontsize() >= 6, said
            assert not re.search(r"\b(effects|environments?|evaluation|rendered)\.|\w_\w+\.\w", said), "a path"
            assert not re.search(r"(?<!\w)-\d|\d\^|\de[-+]?\d|\bus\b", re.sub(r"\$[^$]*\$", "", said)), said
        for ax in figure.axes:
            entries = [x.get_text() for x in ax.get_legend().get_texts()] if ax.get_legend() else []
            assert len(entries) == len(set(entries))
            labels = {str(x.get_label()) for x in (*ax.lines, *ax.patches, *ax.collections)}
            own = {x for x in labels if x and not x.startswith("_")} - {
                "tolerance"
            }  # that is named where its line ends
            assert own <= set(entries), own - set(entries)


@pytest.mark.slow
@pytest.mark.few("evaluation", "comparison")
@pytest.mark.parametrize("name", FIGURES)
def test_a_figure_for_print_is_one_column_of_greys_and_eight_points_whose_looks_differ(name: str) -> None:
    for figure in FIGURES[name]("paper"):
        figure.draw_without_rendering()
        assert figure.get_figwidth() == pen.WIDTH
        assert {x.get_fontsize() for x in texts(figure)} == {8}
        assert overlaps(figure) == []
        assert legend_share(figure) <= 1 / 6
        assert all(red == green == blue for red, green, blue in colors(figure))
        for ax in figure.axes:
            entries = ax.get_legend().legend_handles if ax.get_legend() else []
            looks = [look for x in entries if (look := look_of(x))]
            for i, (shape, light) in enumerate(looks):
                same = [other for kind, other in looks[:i] if kind == shape]
                assert all(abs(other - light) > 10 for other in same), (shape, light)


def colors(figure: Figure) -> set[tuple[float, ...]]:
    """The colours of all lines, grounds and texts, red, green and blue."""
    found: list[Any] = []
    for x in figure.findobj():
        for get in ("get_color", "get_facecolor", "get_edgecolor", "get_markerfacecolor"):
            if hasattr(x, get):
                found += to_rgba_array(getattr(x, get)()).tolist()
    return {tuple(row[:3]) for row in found}


def look_of(entry: Any) -> tuple[tuple[Any, ...], float] | None:
    """What tells an entry of a legend from others in print, and how light it is; None of words alone."""
    if isinstance(entry, Line2D):
        stroke = str(entry._unscaled_dash_pattern) if entry.get_linestyle() != "None" else ""  # type: ignore[attr-defined]
        filled = to_hex(entry.get_markerfacecolor()) != "#ffffff"
        shape = (stroke, str(entry.get_marker()), filled, entry.get_linewidth() if stroke else 0)
        return (shape, lightness(to_hex(entry.get_color()))) if stroke or shape[1] != "None" else None
    return ("ground", entry.get_hatch()), lightness(to_hex(entry.get_facecolor()))


@pytest.mark.slow
@pytest.mark.parametrize("name", hs.scene_names())
def test_no_text_lies_on_another_in_any_shipped_scene(name: str) -> None:
    e = hs.evaluate(name)
    drawings: list[Callable[[], Figure]] = [
        *(lambda own=own: draw_figure(e, own) for own in SHEETS),  # type: ignore[misc]
        lambda: hs.sensitivity(name).figure(), lambda: hs.relevance(name).figure(),
        lambda: hs.metrics(name).figure(), lambda: hs.stability(name, "postural-arm").figure(),
    ]  # fmt: skip
    for made in drawings:
        try:
            figure = made()
        except hs.SceneError:  # nothing to draw
            continue
        figure.draw_without_rendering()
        assert overlaps(figure) == []
        assert legend_share(figure) <= 1 / 6


def legend_share(figure: Figure) -> float:
    """The area of all legends, as a share of that of the figure."""
    boxes = [ax.get_legend().get_window_extent() for ax in figure.axes if ax.get_legend()]
    return sum(box.width * box.height for box in boxes) / (figure.bbox.width * figure.bbox.height)


@pytest.mark.slow
def test_where_a_peak_is_cut_is_told_with_an_exponent_of_print() -> None:
    """It was 5·10⁸ at 1e+12."""
    spring = hs.environments.mass_spring_damper(m="1e-12 kg", k="1e12 N/m")
    ringing = hs.Scene(spring, (hs.effects.second_order_lowpass("1e12 rad/s", "1e-9"),), (0, "1e13 rad/s"))
    e = hs.evaluate(ringing)
    for name in SHEETS:
        figure = draw_figure(e, name)
        figure.draw_without_rendering()
        assert not [x.get_text() for x in texts(figure) if re.search(r"\de[+-]?\d", x.get_text())]


@pytest.mark.slow
def test_environments_of_long_names_leave_room_for_what_is_drawn() -> None:
    """A name of thirty letters took the axes' whole width; matplotlib warned, which is an error here."""
    names = (
        "soft",
        "hard with a long name, indeed",
        "of so many words that no figure of one column has the room for them all",
    )
    found = hs.evaluate_all(hs.SceneFamily(dict.fromkeys(names, hs.load_scene("fu2019"))), regions=True)
    for figure in (found.figure(), draw_figure(found, "regions")):
        figure.draw_without_rendering()
        assert overlaps(figure) == []
        assert all(ax.get_window_extent().width > 0.4 * figure.bbox.width for ax in figure.axes)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["fu2019", "delayed-spring"])
def test_names_of_hands_stand_free(name: str) -> None:
    """At fu2019 one lay on the line of the root at 0; behind a delay two left the axes or met the number."""
    figure = hs.stability(name, "postural-arm").figure()
    figure.draw_without_rendering()
    [ax] = figure.axes
    boxes = [x.get_window_extent() for x in ax.texts if isinstance(x, Annotation)]
    assert len(boxes) >= 6
    at_0, edge = float(ax.transData.transform((-100.0, 0.0))[0]), ax.get_window_extent()  # both have 100 N/m
    for i, box in enumerate(boxes):
        assert edge.x0 < box.x0
        assert box.x1 < edge.x1
        if box.height < 12 * figure.dpi / 72 and box.width > 3 * box.height:  # a name, no number
            assert not box.x0 < at_0 < box.x1
        others = [x for x in boxes[:i] if box.overlaps(x)]
        assert all(box.intersection(box, x).height <= 0.3 * box.height for x in others)


@pytest.mark.slow
def test_hands_whose_marks_cover_each_other_have_one_name() -> None:
    """Beside a hand of 20 kN/m all published ones lie in one mark; their names lay on each other."""
    [ax] = hs.stability("satellite-contact", HEAVY).figure().axes
    names = [x.get_text() for x in ax.texts if isinstance(x, Annotation) and not x.get_text().isdigit()]
    assert sorted(names) == [f"{len(hs.hands)} published hands", "heavy"]


# Sheets.


def legended(count: int, height: float = 2.2) -> Panel:
    """A drawing with a legend of so many rows above it."""
    return Panel(
        [Polyline([0, 1], [0, 1], label=f"a long entry that has a row of its own, {n}") for n in range(count)],
        height=height,
    )


@pytest.mark.slow
def test_a_legend_has_room_above_a_drawing_that_keeps_its_height() -> None:
    few, many = sheet(legended(1)), sheet(legended(4))
    assert few.get_figwidth() == many.get_figwidth() == pytest.approx(pen.WIDTH)
    heights = [ax.get_window_extent().height / figure.dpi for figure in (few, many) for ax in figure.axes]
    assert heights[0] == pytest.approx(heights[1], abs=0.03)
    assert all(x.axes[0].get_legend().get_window_extent().y1 <= x.bbox.y1 + 1 for x in (few, many))


@pytest.mark.slow
def test_a_drawing_at_equal_scales_is_as_high_as_it_needs() -> None:
    figure = sheet(Panel([], DrawnAxis(ends=(0, 4)), DrawnAxis(ends=(0, 2)), 2.6, equal=True))
    box = figure.axes[0].get_window_extent()
    assert box.width / box.height == pytest.approx(2, rel=0.02)
    assert figure.get_figheight() < 2.6


@pytest.mark.slow
def test_drawings_above_each_other_share_their_frequencies_whose_numbers_stand_below_the_last() -> None:
    figure = sheet(legended(1, 1), legended(1, 2))
    first, last = figure.axes
    first.set_xlim(3, 5)
    assert last.get_xlim() == (3, 5)
    assert not first.xaxis.get_tick_params()["labelbottom"]
    assert last.get_position().height == pytest.approx(2 * first.get_position().height, rel=0.01)


# Files.


def test_a_picture_has_400_points_an_inch_and_the_name_that_was_given(tmp_path: Path) -> None:
    assert save_as(Figure(figsize=(0.5, 0.25)), tmp_path / "a.b.png").name == "a.b.png"
    data = (tmp_path / "a.b.png").read_bytes()
    assert data[:4] == b"\x89PNG"
    assert (int.from_bytes(data[16:20], "big"), int.from_bytes(data[20:24], "big")) == (200, 100)  # 400 per inch


def test_an_ending_is_read_in_any_case_and_another_one_is_told(tmp_path: Path) -> None:
    assert save_as(Figure(figsize=(0.1, 0.1)), tmp_path / "loud.PNG").exists()
    with pytest.raises(hs.SceneError, match=r'"x\.jpeg" must end in \.svg, \.pdf or \.png'):
        save_as(Figure(), tmp_path / "x.jpeg")
    with pytest.raises(hs.SceneError, match=r'"x\.txt" must end in \.html or \.pdf'):
        checked_report("x.txt")


@pytest.mark.slow
def test_figures_of_an_evaluation_are_one_column_wide_without_a_date_and_the_same_bytes_again(tmp_path: Path) -> None:
    before = dict(mpl.rcParams)
    first, again = (save_figures(paper(), tmp_path / name) for name in ("not/there", "again"))
    assert dict(mpl.rcParams) == before
    assert [x.name for x in first] == [f"{name}.{kind}" for name in SHEETS for kind in ("svg", "pdf", "png")]
    for one, two in zip(first, again, strict=True):
        data = one.read_bytes()
        assert data == two.read_bytes(), one.name
        assert not re.search(rb"CreationDate|<dc:date>|/Type3", data)
        if one.suffix == ".svg":
            assert re.search(rb'<svg [^>]*width="244\.8pt"', data)
        elif one.suffix == ".pdf":
            assert re.search(rb"/MediaBox \[ 0 0 244\.8 ", data)
        else:
            assert int.from_bytes(data[16:20], "big") == 3.4 * 400


@pytest.mark.slow
@pytest.mark.parametrize("regions", [False, True])
def test_a_family_saves_its_worst_case_and_its_regions_where_they_were_asked_for(
    tmp_path: Path, *, regions: bool
) -> None:
    found = hs.evaluate_all(hs.load_scenes("fu2019", ["fu2019"]), regions=regions)
    names = ["worst-case", *(["regions"] if regions else [])]
    assert sorted({x.stem for x in save_figures(found, tmp_path)}) == sorted(names)


@pytest.mark.slow
def test_the_square_drawn_is_of_the_middle_of_the_first_percept() -> None:
    [ax] = draw_figure(paper(), "jnd-square").axes
    middle = (float(paper().percepts[0].band.low.omega) + float(paper().percepts[0].band.high.omega)) / 2
    assert float(re.findall(r"= ([\d.]+) rad/s", ax.get_title())[0]) == pytest.approx(middle, rel=1e-3)


def test_drawing_touches_only_the_axes_given() -> None:
    before, figure = dict(mpl.rcParams), Figure()
    first, second = figure.subplots(1, 2)
    draw(first, evaluation_charts.ratios(paper()))
    assert dict(mpl.rcParams) == before
    assert figure.axes == [first, second]
    assert [*second.lines, *second.patches, *second.texts, *figure.texts, *figure.legends] == []


@pytest.mark.slow
def test_drawing_needs_no_pyplot_and_new_axes_are_those_of_pyplot() -> None:
    script = """
import sys, matplotlib
matplotlib.use("agg")
import haptisym as hs
from haptisym.figures.evaluation import ratios
from haptisym.figures.layers import draw
from matplotlib.figure import Figure
e, before = hs.evaluate("fu2019"), dict(matplotlib.rcParams)
draw(Figure().add_subplot(), ratios(e))
assert "matplotlib.pyplot" not in sys.modules
ax = e.plot()
from matplotlib import pyplot
assert pyplot.gcf() is ax.figure and pyplot.get_fignums() == [1]
assert dict(matplotlib.rcParams) == before
"""
    subprocess.run([sys.executable, "-W", "error", "-c", script], check=True)
