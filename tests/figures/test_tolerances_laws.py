"""Charts of tolerances, by laws: a spring behind a lag, whose crossings are roots of numbers for every set of values."""

from __future__ import annotations

from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

import haptisym as hs
from haptisym.effects import first_order_lag
from haptisym.environments import mass_spring_damper
from haptisym.figures import pen
from haptisym.figures.tolerances import draw_tolerances, enclosures_figure, tolerances_figure
from haptisym.kernel.errors import NothingToDrawError

GUARANTEED, RANDOM, NOMINAL = "guaranteed for all values", "drawn at random", "nominal values"


def scene(cutoff: str = "40 rad/s +- 10 %", jnd: Any = "0.1", band: Any = (0, 20)) -> hs.Scene:
    """Behind 1/(1 + jω/a) r_r is ω²/(a² + ω²) and r_i is aω/(a² + ω²): they meet 1/10 at a/3 and at a (5 - √24)."""
    return hs.Scene(mass_spring_damper(k=100), (first_order_lag(cutoff),), band, jnd)


REAL, IMAG = 1 / 3, 5 - np.sqrt(24)


@cache
def found(cutoff: str = "40 rad/s +- 10 %", samples: int = 4) -> hs.Tolerances:
    return hs.tolerances(scene(cutoff), samples=samples)


def axes() -> Axes:
    return Figure(figsize=(5, 3)).add_subplot()


def told(ax: Axes) -> list[str]:
    return [x.get_text() for x in ax.get_legend().get_texts()]


def spans(bars: list[Any]) -> list[tuple[float, float, float]]:
    """From where to where bars go, and their rows."""
    return [(x.get_x(), x.get_x() + x.get_width(), x.get_y() + x.get_height() / 2) for x in bars]


def dots(ax: Axes) -> list[Any]:
    """The places of each row's dots."""
    return [np.stack(x.get_data(), 1) for x in ax.lines if x.get_marker() == "."]


def strokes(ax: Axes) -> list[Any]:
    """The ends of each row's strokes."""
    return [np.array(x.get_segments()) for x in ax.collections if isinstance(x, LineCollection)]


def test_bars_go_from_the_crossing_of_the_lowest_value_to_that_of_the_highest_in_the_row_of_their_ratio() -> None:
    ax = axes()
    bars = draw_tolerances(ax, found())
    (low, high, first), (left, right, second) = spans(bars)
    assert (first, second) == (pytest.approx(0), pytest.approx(1))
    assert (low, high) == (pytest.approx(36 * REAL, rel=1e-6), pytest.approx(44 * REAL, rel=1e-6))
    assert (left, right) == (pytest.approx(36 * IMAG, rel=1e-6), pytest.approx(44 * IMAG, rel=1e-6))
    for bar in bars:
        assert isinstance(bar, Rectangle)
        assert bar.get_height() == pytest.approx(0.7)
        assert (to_hex(bar.get_facecolor()), to_hex(bar.get_edgecolor())) == (pen.SHADE, pen.GREY)
    assert [x.get_text() for x in ax.get_yticklabels()] == [
        r"$r_\mathrm{r} = c_\mathrm{r}$", r"$r_\mathrm{i} = c_\mathrm{i}$",
    ]  # fmt: skip
    assert (ax.get_xlim(), ax.get_ylim()) == ((0, 20), (1.5, -0.5))  # the first row on top
    assert ax.get_xlabel() == r"$\omega$ (rad/s)"


def test_dots_stand_at_the_crossings_of_the_values_drawn_within_their_bar_and_each_at_a_height_of_its_own() -> None:
    ax = axes()
    draw_tolerances(ax, found(samples=8))
    cutoffs = [float(next(iter(x.values.values()))) for x in found(samples=8).samples]
    assert len(set(cutoffs)) == 8
    for row, (own, at) in enumerate(zip(dots(ax), (REAL, IMAG), strict=True)):
        assert own[:, 0] == pytest.approx(np.multiply(cutoffs, at), rel=1e-9)
        assert (np.abs(own[:, 1] - row) <= 0.25).all()
        assert np.diff(np.sort(own[:, 1])).min() > 0.02
        assert own[0, 1] == pytest.approx(row - 0.25)
    assert np.ptp(dots(ax)[0][:, 1]) > 0.3


def test_strokes_stand_at_the_nominal_crossings_as_high_as_the_bars() -> None:
    ax = axes()
    draw_tolerances(ax, found())
    for row, (own, at) in enumerate(zip(strokes(ax), (REAL, IMAG), strict=True)):
        assert own == pytest.approx(np.array([[[40 * at, row - 0.35], [40 * at, row + 0.35]]]))
    looks = [(to_hex(x.get_color()[0]), x.get_linewidth()[0]) for x in ax.collections]  # type: ignore[index]
    assert looks == [(pen.INK, 1.4)] * 2
    order = [x.get_zorder() for x in (ax.patches[0], ax.lines[0], ax.collections[0])]
    assert order == sorted(set(order))


def test_the_legend_shows_bars_dots_and_strokes_as_they_are_drawn() -> None:
    ax = axes()
    draw_tolerances(ax, found())
    assert told(ax) == [GUARANTEED, RANDOM, NOMINAL]
    ground, dot, stroke = ax.get_legend().legend_handles
    assert to_hex(ground.get_facecolor()) == pen.SHADE
    assert (dot.get_marker(), to_hex(dot.get_color())) == ("o", pen.BLUE)
    assert (stroke.get_marker(), to_hex(stroke.get_color()), stroke.get_linestyle()) == ("|", pen.INK, "None")
    assert {to_hex(x.get_color()) for x in ax.lines} == {pen.BLUE}


def test_the_legend_tells_only_what_there_is() -> None:
    """No samples; or of 60 to 100 rad/s on a band to 10 only r_i, and on one to 9 not for the nominal 90."""
    ax = axes()
    draw_tolerances(ax, found(samples=0))
    assert told(ax) == [GUARANTEED, NOMINAL]
    ax = axes()
    draw_tolerances(ax, hs.tolerances(scene(band=(0, 9)), samples=2))  # r_r is met beyond the band
    assert told(ax) == [GUARANTEED, RANDOM, NOMINAL]
    ax = axes()
    bars = draw_tolerances(ax, hs.tolerances(scene("92 rad/s +- 10 %", band=(0, 9)), samples=0))
    assert told(ax) == [GUARANTEED]
    assert spans(bars) == [(pytest.approx(82.8 * IMAG, rel=1e-6), pytest.approx(9), pytest.approx(1))]
    assert [len(x) for x in strokes(ax)] == [0, 0]


def test_where_no_values_bring_a_crossing_there_is_nothing_to_draw_unless_another_scene_is_there() -> None:
    never = hs.tolerances(scene("400 rad/s +- 10 %"), samples=2)
    for draw in (
        lambda: draw_tolerances(axes(), never),
        lambda: enclosures_figure(never),
        lambda: tolerances_figure(never),
    ):
        with pytest.raises(NothingToDrawError, match="nothing is met on the band"):
            draw()
    ax = axes()
    draw_tolerances(ax, found())
    assert draw_tolerances(ax, never) == []


def test_a_further_scene_is_outlined_in_its_colour_and_its_entries_bear_its_label() -> None:
    ax = axes()
    draw_tolerances(ax, found(), label="slow")
    wide = hs.tolerances(scene("60 rad/s +- 10 %", band=(0, 30)), samples=2)
    bars = draw_tolerances(ax, wide, label="quick")
    assert spans(bars)[0][:2] == (pytest.approx(18, rel=1e-6), pytest.approx(22, rel=1e-6))
    for bar in bars:
        assert bar.get_facecolor()[3] == 0  # type: ignore[attr-defined]
        assert to_hex(bar.get_edgecolor()) == pen.SCENES[1]  # type: ignore[attr-defined]
        assert bar.get_linewidth() == 1.0  # type: ignore[attr-defined]
    assert told(ax) == [f"{x}, {label}" for label in ("slow", "quick") for x in (GUARANTEED, RANDOM, NOMINAL)]
    assert [to_hex(x.get_color()) for x in ax.lines] == [pen.BLUE, pen.BLUE, pen.SCENES[1], pen.SCENES[1]]
    assert [to_hex(x.get_color()[0]) for x in ax.collections] == [pen.INK] * 2 + [pen.SCENES[1]] * 2  # type: ignore[index]
    outline, *others = ax.get_legend().legend_handles[3:]
    assert outline.get_facecolor()[3] == 0
    assert {to_hex(x.get_color()) for x in others} == {pen.SCENES[1]}
    assert ax.get_xlim() == (0, 30)


def test_what_a_further_scene_meets_stands_in_the_row_of_that_or_in_one_of_its_own() -> None:
    """The disc of a second scene was drawn in the row of r_r, and both rows were named anew."""
    ax = axes()
    draw_tolerances(ax, found())
    disc = hs.tolerances(scene(jnd={"shape": "ellipse", "real": "0.1", "imag": "0.1"}), samples=1)
    [bar] = draw_tolerances(ax, disc)
    assert [x.get_text() for x in ax.get_yticklabels()] == [
        r"$r_\mathrm{r} = c_\mathrm{r}$", r"$r_\mathrm{i} = c_\mathrm{i}$", "ellipse",
    ]  # fmt: skip
    assert spans([bar])[0][2] == pytest.approx(2)
    assert dots(ax)[2][0, 1] == pytest.approx(1.75)
    assert strokes(ax)[2] == pytest.approx(np.array([[[40 / 99**0.5, 1.65], [40 / 99**0.5, 2.35]]]))
    assert ax.get_ylim() == (2.5, -0.5)
    again = draw_tolerances(ax, found())
    assert [row for *_, row in spans(again)] == pytest.approx([0, 1])


def test_in_hertz_bars_dots_and_strokes_are_in_hertz() -> None:
    ax, turn = axes(), 2 * np.pi
    bars = draw_tolerances(ax, found(), hertz=True)
    assert spans(bars)[0][:2] == (pytest.approx(12 / turn, rel=1e-6), pytest.approx(44 / 3 / turn, rel=1e-6))
    cutoffs = [float(next(iter(x.values.values()))) for x in found().samples]
    assert dots(ax)[0][:, 0] == pytest.approx(np.multiply(cutoffs, REAL / turn))
    assert strokes(ax)[0][0, 0, 0] == pytest.approx(40 * REAL / turn)
    assert (ax.get_xlim(), ax.get_xlabel()) == ((0, pytest.approx(20 / turn)), "frequency (Hz)")


# The sheet


def legends(figure: Figure) -> float:
    return sum(x.get_legend().get_window_extent().height for x in figure.axes) / figure.dpi


def test_a_sheet_of_two_rows_is_one_and_a_half_inches_high_below_its_legend() -> None:
    two = tolerances_figure(found())
    assert (two.get_figheight(), two.get_figwidth()) == (pytest.approx(1.5 + legends(two)), pen.WIDTH)


def test_a_region_of_both_parts_has_one_row_named_after_it_on_a_lower_sheet() -> None:
    disc = hs.tolerances(scene(jnd={"shape": "ellipse", "real": "0.1", "imag": "0.1"}), samples=0)
    one = tolerances_figure(disc)
    assert one.get_figheight() == pytest.approx(1.3 + legends(one))
    assert [x.get_text() for x in one.axes[0].get_yticklabels()] == ["ellipse"]
    [bar] = one.axes[0].patches
    # |jω/(a + jω)| is a tenth at a/√99
    assert spans([bar])[0][:2] == (pytest.approx(36 / 99**0.5, rel=1e-6), pytest.approx(44 / 99**0.5, rel=1e-6))


def stub(monkeypatch: pytest.MonkeyPatch, *, rows: bool, hands: bool, held: bool = True) -> tuple[Any, list[str]]:
    """An answer with a hand or without, of which rows and plane can be drawn or not; and what was drawn."""
    drawn: list[str] = []
    answer = SimpleNamespace(
        held=(1,) if held else (), enclosures=(1,) if rows else (), nominal=SimpleNamespace(crossings={}), samples=(),
        criteria=(1, 2),
    )  # fmt: skip

    def draws(name: str, *, can: bool) -> Any:
        def draw(*_: Any) -> Figure:
            if not can:
                raise NothingToDrawError(name)
            drawn.append(name)
            return Figure()

        return draw

    where = "haptisym.figures.tolerances."
    monkeypatch.setattr(f"{where}draw_tolerances", draws("rows", can=rows))
    monkeypatch.setattr(f"{where}draw_held", draws("hands", can=hands))
    monkeypatch.setattr(f"{where}hands_figure", draws("hands alone", can=hands))
    return answer, drawn


@pytest.mark.parametrize(
    ("has", "expected"),
    [
        ({"rows": True, "hands": True}, ["rows", "hands"]),
        ({"rows": False, "hands": True}, ["hands alone"]),
        ({"rows": True, "hands": False}, ["rows", "rows"]),
        ({"rows": True, "hands": True, "held": False}, ["rows"]),
    ],
)
def test_the_plane_of_the_hand_stands_below_the_rows_or_alone_where_there_is_no_crossing(
    monkeypatch: pytest.MonkeyPatch, has: Any, expected: list[str]
) -> None:
    answer, drawn = stub(monkeypatch, **has)
    figure = tolerances_figure(answer)
    assert drawn == expected
    if expected == ["rows", "hands"]:
        upper, lower = figure.axes
        assert figure.get_figheight() == pytest.approx(1.5 + 2.6)
        assert upper.get_position().y0 > lower.get_position().y1
        assert lower.get_position().height > 1.5 * upper.get_position().height


def test_where_neither_can_be_drawn_that_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    answer, _ = stub(monkeypatch, rows=False, hands=False)
    with pytest.raises(NothingToDrawError):
        tolerances_figure(answer)


def test_crossings_of_a_sample_alone_are_a_row() -> None:
    """As where a search was cut short."""
    one = hs.tolerances(scene(), samples=2)
    object.__setattr__(one, "enclosures", ())
    ax = axes()
    assert draw_tolerances(ax, one) == []
    assert told(ax) == [RANDOM, NOMINAL]
    assert isinstance(ax.lines[0], Line2D)
