"""Several environments in one chart, by laws: their ratios over a mass in the hand, with all ends known as roots of numbers."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.text import Annotation

import haptisym as hs
from haptisym.effects import first_order_lag, shunt
from haptisym.environments import mass_spring_damper
from haptisym.figures import pen
from haptisym.figures.family import draw_worst, family_figure, save_family_figures

LIGHT = (shunt(m="0.1"),)
SPRINGS = {"heavy": (2, 100), "stiff": (0, 400), "wall": (0, 10_000)}
"""In kg and N/m. 0.1 ω² is a tenth of ``|100 - 2 ω²|`` at √(100/3) and 10 rad/s, and of 400 at 20."""
ENDS = (np.sqrt(100 / 3), 10, 20)


def family(**given: Any) -> hs.FamilyEvaluation:
    own = {"effects": LIGHT, "band": (0, 30), "jnd": hs.Threshold.of("0.1", "0.3"), "names": tuple(SPRINGS)} | given
    scenes = {
        name: hs.Scene(mass_spring_damper(m, own.get("b", 0), k), own["effects"], own["band"], own["jnd"])
        for name, (m, k) in SPRINGS.items()
        if name in own["names"]
    }
    return hs.evaluate_all(hs.SceneFamily(scenes))


@cache
def found() -> hs.FamilyEvaluation:
    return family()


@cache
def sheet() -> Figure:
    return family_figure(found())


def drawn(which: int = 0, of: hs.FamilyEvaluation | None = None) -> tuple[Axes, list[Line2D]]:
    ax = Figure(figsize=(5, 4)).add_subplot()
    return ax, [x for x in draw_worst(ax, of or found(), which) if x.get_marker() != "o"]


def ratio(name: str, omega: Any) -> Any:
    m, k = SPRINGS[name]
    with np.errstate(divide="ignore", invalid="ignore"):
        return 0.1 * omega**2 / np.abs(k - m * omega**2)


def places(line: Line2D) -> tuple[Any, Any]:
    return np.asarray(line.get_xdata(), float), np.asarray(line.get_ydata(), float)


def told(ax: Axes) -> list[str]:
    return [x.get_text() for x in ax.get_legend().get_texts()]


def dots(ax: Axes) -> list[tuple[float, float, str]]:
    spots = [x for x in ax.lines if x.get_marker() == "o"]
    return [(*(float(v[0]) for v in places(x)), to_hex(x.get_color())) for x in spots]


def test_each_environment_has_its_ratio_and_the_broad_line_is_the_largest_of_them() -> None:
    ax, lines = drawn()
    omega = places(lines[0])[0]
    assert (omega[0], omega[-1]) == (0, 30)
    exact = np.stack([ratio(name, omega) for name in SPRINGS])
    for line, values in zip(lines, exact, strict=True):
        y = places(line)[1]
        assert np.isfinite(y).sum() >= len(y) - 1
        assert y[np.isfinite(y)] == pytest.approx(values[np.isfinite(y)], rel=1e-9)
    [broad] = [x for x in ax.lines if x.get_linewidth() == 2.2]
    y = places(broad)[1]
    seen = np.isfinite(y)
    assert y[seen] == pytest.approx(exact.max(axis=0)[seen], rel=1e-9)
    assert all(np.abs(omega - end).min() < 1e-12 for end in ENDS)
    assert (broad.get_alpha(), to_hex(broad.get_color())) == (0.35, pen.INK)
    assert broad.get_zorder() < min(x.get_zorder() for x in lines)


def test_at_a_pole_the_line_of_its_environment_has_a_gap_and_the_broad_one_is_infinite() -> None:
    """The heavy one rings at √50 rad/s without damping."""
    ax, (heavy, *_) = drawn()
    omega, y = places(heavy)
    [gap] = np.flatnonzero(np.isnan(y))
    assert omega[gap] == pytest.approx(np.sqrt(50))
    [broad] = [x for x in ax.lines if x.get_linewidth() == 2.2]
    assert places(broad)[1][gap] == np.inf
    assert ax.get_ylim() == (0, pytest.approx(0.4))  # four times the threshold, no more


def test_those_that_bind_have_colours_in_the_order_of_their_ends_and_others_are_thin_and_grey() -> None:
    ax, lines = drawn()
    looks = [(to_hex(x.get_color()), x.get_linewidth(), x.is_dashed()) for x in lines]
    assert looks == [(pen.BLUE, 1.1, False), (pen.RED, 1.1, True), (pen.GREY, 0.6, False)]
    assert told(ax) == ["largest", "heavy binds", "stiff binds", "others", "threshold", "all transparent"]
    handles = dict(zip(told(ax), ax.get_legend().legend_handles, strict=True))
    for name, line in zip(("heavy binds", "stiff binds"), lines, strict=False):
        shown = handles[name]
        assert to_hex(shown.get_color()) == to_hex(line.get_color())
        assert (shown.get_marker(), shown.is_dashed()) == ("o", line.is_dashed())
        assert shown.get_linewidth() == line.get_linewidth()
    assert (handles["largest"].get_linewidth(), handles["largest"].get_alpha()) == (2.2, 0.35)
    assert (handles["others"].get_linewidth(), to_hex(handles["others"].get_color())) == (0.6, pen.GREY)
    assert handles["threshold"].is_dashed()
    assert isinstance(handles["all transparent"], Patch)
    assert to_hex(handles["all transparent"].get_facecolor()) == pen.SHADE


def test_dots_stand_on_the_threshold_where_one_binds_and_the_ground_is_grey_where_none_is_noticed() -> None:
    ax, _ = drawn()
    assert dots(ax) == [
        (pytest.approx(ENDS[0]), 0.1, pen.BLUE), (pytest.approx(10), 0.1, pen.BLUE), (pytest.approx(20), 0.1, pen.RED),
    ]  # fmt: skip
    spans = [(x.get_x(), x.get_x() + x.get_width()) for x in ax.patches]  # type: ignore[attr-defined]
    assert np.array(spans) == pytest.approx(np.array([(0, ENDS[0]), (10, 20)]))
    [level] = [x for x in ax.lines if len(x.get_xdata()) == 2]
    assert list(level.get_ydata()) == [0.1, 0.1]
    assert level.is_dashed()
    assert (ax.get_xlim(), ax.get_xlabel(), ax.get_ylabel()) == ((0, 30), r"$\omega$ (rad/s)", r"$r_\mathrm{r}$")


def test_the_other_criterion_has_its_own_threshold_and_no_dots_of_the_first() -> None:
    """Without damping r_i is 0."""
    ax, lines = drawn(1)
    assert dots(ax) == []
    assert all(np.nanmax(places(x)[1]) == 0 for x in lines)
    [level] = [x for x in ax.lines if len(x.get_xdata()) == 2]
    assert list(level.get_ydata()) == [0.3, 0.3]
    assert ax.get_ylim() == (0, pytest.approx(1.6 * 0.3))
    assert ax.get_ylabel() == r"$r_\mathrm{i}$"


def test_an_envelope_that_is_not_far_above_the_threshold_is_seen_to_its_top() -> None:
    """0.1 ω²/400 reaches 0.225 at 30 rad/s."""
    ax, _ = drawn(0, family(names=("stiff", "wall")))
    assert ax.get_ylim() == (0, pytest.approx(1.08 * 0.225))


def test_where_all_bind_or_none_is_transparent_the_legend_tells_of_neither_others_nor_a_ground() -> None:
    ax, _ = drawn(0, family(names=("heavy", "stiff")))
    assert told(ax) == ["largest", "heavy binds", "stiff binds", "threshold", "all transparent"]
    springs = family(effects=(shunt(k="5000"),), names=("stiff", "wall"), band=(1, 9))
    ax, _ = drawn(0, springs)
    assert springs.transparent == ()
    assert "all transparent" not in told(ax)
    assert not ax.patches


def test_of_five_that_bind_the_fifth_has_the_look_of_the_first() -> None:
    """Masses on springs without damping, each noticed about its own resonance."""
    many = {f"{n}": hs.Scene(mass_spring_damper(m=10, k=10 * n**2), LIGHT, (0, 60), "0.1") for n in (5, 10, 20, 30, 40)}
    ax, lines = drawn(0, hs.evaluate_all(hs.SceneFamily(many)))
    assert [to_hex(x.get_color()) for x in lines] == [pen.BLUE, pen.RED, "#7cc0c8", "#d0701f", pen.BLUE]
    assert [x.is_dashed() for x in lines] == [False, True, False, True, False]
    assert len(dots(ax)) == 10


def test_a_long_name_is_broken_into_lines_of_forty_letters() -> None:
    name = "an environment of so many words that its entry would be wider than a column"
    ax, _ = drawn(
        0, hs.evaluate_all(hs.SceneFamily({name: hs.Scene(mass_spring_damper(k=400), LIGHT, (0, 30), "0.1")}))
    )
    lines = told(ax)[1].split("\n")
    assert " ".join(lines) == f"{name} binds"
    assert 30 < max(map(len, lines)) <= 40


def test_in_hertz_all_is_in_hertz() -> None:
    hertz = family(band=("0 Hz", "4 Hz"))
    ax, lines = drawn(0, hertz)
    assert (ax.get_xlim(), ax.get_xlabel()) == ((0, pytest.approx(4)), "frequency (Hz)")
    at, values = places(lines[1])
    assert values == pytest.approx(0.1 * (2 * np.pi * at) ** 2 / 400)
    assert [x for x, *_ in dots(ax)] == pytest.approx(np.divide(ENDS, 2 * np.pi))


def test_ends_above_a_sheet_in_hertz_are_in_hertz() -> None:
    top = family_figure(family(band=("0 Hz", "4 Hz"), names=("stiff",))).axes[0]
    assert [x.get_text() for x in top.texts] == ["3.183"]


# The sheet


def test_the_sheet_has_a_panel_for_each_criterion_with_ends_above_and_frequencies_below() -> None:
    real, imag = sheet().axes
    assert (real.get_ylabel(), imag.get_ylabel()) == (r"$r_\mathrm{r}$", r"$r_\mathrm{i}$")
    assert (real.get_xlabel(), imag.get_xlabel()) == ("", r"$\omega$ (rad/s)")
    assert real.xaxis.get_tick_params()["labelbottom"] is False
    assert imag.xaxis.get_tick_params().get("labelbottom", True)
    assert told(real)[1:3] == ["heavy binds", "stiff binds"]
    assert imag.get_legend() is None
    labels = [x for x in real.texts if isinstance(x, Annotation)]
    assert [(x.get_text(), x.xy[0]) for x in labels] == [
        ("5.774", pytest.approx(ENDS[0])), ("10.00", 10), ("20.00", 20),
    ]  # fmt: skip
    assert real.get_position().y0 > imag.get_position().y1
    assert sheet().get_figwidth() == pytest.approx(pen.WIDTH)
    legend = real.get_legend().get_window_extent().height / sheet().dpi
    assert sheet().get_figheight() == pytest.approx(0.7 + 2 * 1.3 + legend, abs=0.02)


def test_a_disc_has_one_panel_and_a_sheet_of_its_height() -> None:
    disc = family(
        jnd={"shape": "ellipse", "real": "0.1", "imag": "0.1"}, names=("stiff",), effects=(first_order_lag(90),)
    )
    figure = family_figure(disc)
    [ax] = figure.axes
    legend = ax.get_legend().get_window_extent().height / figure.dpi
    assert figure.get_figheight() == pytest.approx(2.0 + legend, abs=0.02)
    assert [x.get_text() for x in ax.texts] == ["9.045"]  # 90/√99: |jω/(90 + jω)| is a tenth
    assert ax.get_xlabel() == r"$\omega$ (rad/s)"


@pytest.mark.parametrize("regions", [False, True])
def test_a_family_saves_its_worst_case_and_its_regions_where_they_were_asked_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, *, regions: bool
) -> None:
    monkeypatch.setattr(Figure, "savefig", lambda *_args, **_options: None)
    monkeypatch.setattr("haptisym.figures.family.family_regions_figure", lambda _: Figure())
    stiff = hs.SceneFamily({"stiff": hs.Scene(mass_spring_damper(k=400), LIGHT, (0, 30), "0.1")})
    paths = save_family_figures(hs.evaluate_all(stiff, regions=regions), tmp_path)
    names = ["worst-case", *(["regions"] if regions else [])]
    assert sorted({x.stem for x in paths}) == sorted(names)
    assert len(paths) == 3 * len(names)
