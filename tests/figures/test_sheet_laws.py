"""Sheets, by laws: how wide and high they are, what stands where, and what is written to which file."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

import haptisym as hs
from haptisym.figures import pen
from haptisym.figures.sheet import Drawings, laid_out, one_column, save, save_all, save_as, stacked


def plain(ax: Axes) -> None:
    ax.plot([0, 1], [0, 1])


def told(count: int) -> Callable[[Axes], None]:
    """A drawing with a legend of so many rows above it."""

    def draw(ax: Axes) -> None:
        plain(ax)
        handles = [Line2D([], [], label=f"entry {n}") for n in range(count)]
        ax.legend(handles=handles, loc="lower left", bbox_to_anchor=(0, 1), borderaxespad=0, borderpad=0)

    return draw


def equal(wide: float, high: float) -> Callable[[Axes], None]:
    def draw(ax: Axes) -> None:
        ax.set(xlim=(0, wide), ylim=(0, high))
        ax.set_aspect("equal", adjustable="box")

    return draw


def legend_height(ax: Axes) -> float:
    return float(ax.get_legend().get_window_extent().height) / ax.figure.dpi


def size(figure: Figure) -> tuple[float, float]:
    return float(figure.get_figwidth()), float(figure.get_figheight())


# How high


def test_a_sheet_is_one_column_wide_and_as_high_as_was_asked_without_a_legend() -> None:
    assert size(one_column(2.2, plain)) == (pytest.approx(3.4), pytest.approx(2.2))
    assert size(one_column(2.2, plain, 5)) == (pytest.approx(5), pytest.approx(2.2))


def test_a_legend_has_room_above_that_height_and_the_axes_keep_theirs() -> None:
    few, many = one_column(2.2, told(1)), one_column(2.2, told(4))
    heights = []
    for figure in (few, many):
        [ax] = figure.axes
        assert figure.get_figheight() == pytest.approx(2.2 + legend_height(ax))
        heights.append(ax.get_window_extent().height / figure.dpi)
        assert ax.get_legend().get_window_extent().y1 <= figure.bbox.y1 + 1
    assert heights[0] == pytest.approx(heights[1], abs=0.02)
    assert many.get_figheight() - few.get_figheight() > 0.3


@pytest.mark.parametrize(
    ("wide", "high", "expected"), [(4, 2, 0.7 + 1.4), (1, 1, 3.5), (1, 3, 3.6), (5, 1, 0.7 + 0.56)]
)
def test_a_drawing_at_equal_scales_is_as_high_as_it_needs_but_not_higher_than_a_bit_over_a_column(
    wide: float, high: float, expected: float
) -> None:
    figure = one_column(2.6, equal(wide, high))
    assert size(figure) == (pytest.approx(pen.WIDTH), pytest.approx(expected))
    [ax] = figure.axes
    box = ax.get_window_extent()
    assert box.width / box.height == pytest.approx(wide / high, rel=0.02)


def test_of_several_drawings_none_takes_a_height_of_its_own_for_equal_scales() -> None:
    figure = Figure(figsize=(pen.WIDTH, 4), layout="compressed")
    first, second = figure.subplots(2, 1)
    equal(5, 1)(first)
    plain(second)
    assert laid_out(figure, 4, first, second).get_figheight() == pytest.approx(4)


def test_a_sheet_is_laid_out_once_so_that_all_files_look_the_same() -> None:
    figure = one_column(2, told(2))
    before = [ax.get_position().bounds for ax in figure.axes]
    figure.set_size_inches(5, 5)
    figure.draw_without_rendering()
    assert [ax.get_position().bounds for ax in figure.axes] == before


# Drawings above each other


def test_drawings_above_each_other_share_their_frequencies_and_the_height_as_they_ask() -> None:
    seen: list[str] = []

    def named(name: str) -> Callable[[Axes], None]:
        def draw(ax: Axes) -> None:
            told(1)(ax)
            ax.set_xlabel(name)
            ax.set_ylabel(name)
            seen.append(name)

        return draw

    figure = stacked(3.0, (1, named("top")), (1, named("middle")), (2, named("bottom")))
    axes = figure.axes
    assert seen == ["top", "middle", "bottom"]
    assert [ax.get_ylabel() for ax in axes] == seen
    assert [ax.get_xlabel() for ax in axes] == ["", "", "bottom"]
    assert [bool(ax.xaxis.get_tick_params().get("labelbottom", True)) for ax in axes] == [False, False, True]
    assert size(figure) == (pytest.approx(pen.WIDTH), pytest.approx(3 + sum(map(legend_height, axes))))
    heights = [ax.get_position().height for ax in axes]
    assert heights[1] == pytest.approx(heights[0], rel=0.01)
    assert heights[2] == pytest.approx(2 * heights[0], rel=0.01)
    tops = [ax.get_position().y1 for ax in axes]
    assert tops == sorted(tops, reverse=True)
    axes[0].set_xlim(3, 5)
    assert axes[2].get_xlim() == (3, 5)


@pytest.mark.parametrize("aligned", [False, True])
def test_labels_stand_below_each_other_where_that_is_asked(*, aligned: bool) -> None:
    def with_ticks(most: float) -> Callable[[Axes], None]:
        def draw(ax: Axes) -> None:
            ax.plot([0, 1], [0, most])
            ax.set_ylabel("y")

        return draw

    figure = stacked(3, (1, with_ticks(1)), (1, with_ticks(123456)), aligned=aligned)
    figure.draw_without_rendering()
    first, second = (ax.yaxis.label.get_window_extent().x0 for ax in figure.axes)
    assert bool(abs(first - second) < 0.5) is aligned


# Files


def test_all_figures_are_written_in_all_kinds_into_a_folder_that_is_made(tmp_path: Path) -> None:
    folder = tmp_path / "not" / "there"
    figures = {name: Figure(figsize=(0.5, 0.25)) for name in ("one", "two.b")}
    paths = save_all(figures, folder, (".svg", ".png"))
    assert [x.relative_to(folder).as_posix() for x in paths] == ["one.svg", "one.png", "two.b.svg", "two.b.png"]
    assert all(x.exists() for x in paths)
    assert save_all(figures, str(folder), (".svg",))[0] == folder / "one.svg"  # a folder that is there already
    data = paths[1].read_bytes()
    assert data[:4] == b"\x89PNG"
    assert (int.from_bytes(data[16:20], "big"), int.from_bytes(data[20:24], "big")) == (200, 100)  # 400 per inch


def test_unasked_a_figure_is_written_as_svg_pdf_and_png(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[tuple[str, Any, Any, Any]] = []

    def savefig(_: Figure, path: Path, *, metadata: Any, dpi: Any) -> None:
        rc = mpl.rcParams
        asked.append((path.name, metadata, dpi, (rc["svg.hashsalt"], rc["pdf.fonttype"])))

    monkeypatch.setattr(Figure, "savefig", savefig)
    assert [x.name for x in save(tmp_path / "a.b", Figure())] == ["a.b.svg", "a.b.pdf", "a.b.png"]
    nothing = [{"Date": None}, {"CreationDate": None}, {"Software": None}]
    assert asked == [
        (f"a.b{kind}", metadata, 400, ("haptisym", 42))
        for kind, metadata in zip((".svg", ".pdf", ".png"), nothing, strict=True)
    ]
    assert [x.name for x in save_all({"x": Figure()}, tmp_path)] == ["x.svg", "x.pdf", "x.png"]
    assert mpl.rcParams["svg.hashsalt"] != "haptisym"


def test_an_ending_is_read_in_any_case_and_another_one_is_told(tmp_path: Path) -> None:
    assert save_as(Figure(figsize=(0.1, 0.1)), tmp_path / "loud.PNG").exists()
    with pytest.raises(hs.SceneError, match=r'"x\.jpeg" must end in \.svg, \.pdf or \.png'):
        save_as(Figure(), tmp_path / "x.jpeg")


# Kinds of figures


def test_drawings_are_found_by_their_names_and_saved_but_for_those_without_anything(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def line(slope: float) -> Callable[[Axes, float], None]:
        return lambda ax, answer: ax.plot([0, 1], [0, slope * answer]) and None

    drawings = Drawings[float]({"flat": (2.0, line(0)), "steep": (3.0, line(5))}, lambda x: ["flat"] if x > 1 else [])
    figure = drawings.figure(2, "steep")
    assert size(figure) == (pytest.approx(3.4), pytest.approx(3))
    assert np.asarray(figure.axes[0].lines[0].get_ydata()).tolist() == [0, 10]
    assert size(drawings.figure(2, "flat", wide=True)) == (pytest.approx(5.1), pytest.approx(2))
    monkeypatch.setattr(Figure, "savefig", lambda *_args, **_options: None)
    assert [x.name for x in drawings.save(2, tmp_path, [".svg"])] == ["steep.svg"]
    assert [x.name for x in drawings.save(1, tmp_path)] == [
        f"{x}.{y}" for x in ("flat", "steep") for y in ("svg", "pdf", "png")
    ]
