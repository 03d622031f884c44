"""``plot``, by laws: which drawing a kind is, whose colour and label it bears, and what stays in sight, with drawings given here."""

from __future__ import annotations

from functools import cache
from types import SimpleNamespace
from typing import Any

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

import haptisym as hs
from haptisym.effects import first_order_lag, shunt
from haptisym.environments import mass_spring_damper
from haptisym.figures import pen
from haptisym.figures.plots import KINDS, plot
from haptisym.kernel.errors import NothingToDrawError

LAGGED = hs.Scene(mass_spring_damper(k=100, b=3), (first_order_lag(20), shunt(m="0.1")), (0, 15), "0.1")


def axes() -> Axes:
    return Figure(figsize=(5, 4)).add_subplot()


def told(ax: Axes) -> list[str]:
    return [x.get_text() for x in ax.get_legend().get_texts()] if ax.get_legend() else []


@cache
def evaluation() -> hs.Evaluation:
    return hs.evaluate(LAGGED)


# Which drawing


@pytest.mark.parametrize(
    ("kind", "label"),
    [
        ("", "ratio"), ("ratios", "ratio"), ("nyquist", r"$\mathrm{Im}\,H$ (N/m)"),
        ("projections-real", r"$|\mathrm{Re}\,H|$ (N/m)"), ("projections-imag", r"$|\mathrm{Im}\,H|$ (N/m)"),
    ],
)  # fmt: skip
def test_a_kind_of_an_evaluation_has_the_axis_that_its_name_says(kind: str, label: str) -> None:
    ax = evaluation().plot(axes(), kind=kind)
    assert label in ax.get_ylabel()


def test_parts_of_effects_of_families_and_their_order_are_those_of_their_names() -> None:
    effects = hs.relevance(LAGGED)
    for kind, symbol in (("real", r"r_\mathrm{r}"), ("imag", r"r_\mathrm{i}"), ("", r"r_\mathrm{r}")):
        assert effects.plot(axes(), kind=kind).get_ylabel() == f"change of ${symbol}$"
    assert effects.plot(axes(), kind="dominance").get_title(loc="left").startswith("changes the ratios most")
    family = hs.evaluate_all(hs.SceneFamily({"one": LAGGED}))
    for kind, symbol in (("real", r"$r_\mathrm{r}$"), ("imag", r"$r_\mathrm{i}$"), ("", r"$r_\mathrm{r}$")):
        assert family.plot(axes(), kind=kind).get_ylabel() == symbol


def given(schema: str, name: str = "Answer", **more: Any) -> Any:
    """An answer that has a schema and nothing else."""
    return type(name, (SimpleNamespace,), {"_schema": f"haptisym.{schema}/1"})(**more)


def drawing(
    monkeypatch: pytest.MonkeyPatch, *, labelled: bool = False, returns: Any = None, draws: Any = None
) -> list[Any]:
    """Every drawing is this one: what it was given."""
    asked: list[Any] = []

    def make(name: str) -> Any:
        def plainly(ax: Axes, *rest: Any) -> Any:
            asked.append((name, *rest))
            return (draws or (lambda ax: ax.plot([0, 1], [0, 1], label="line")))(ax) if returns is None else returns

        def with_label(ax: Axes, *rest: Any, color: str | None = None, label: str = "") -> Any:
            asked.append((name, *rest, color, label))
            return (draws or (lambda ax: ax.plot([0, 1], [0, 1], label="line")))(ax) if returns is None else returns

        return with_label if labelled else plainly

    monkeypatch.setattr("haptisym.figures.plots.resolve_name", make)
    return asked


def test_each_kind_is_drawn_by_what_the_table_names_with_the_answer_first(monkeypatch: pytest.MonkeyPatch) -> None:
    asked, ax = drawing(monkeypatch), axes()
    for schema, kinds in KINDS.items():
        answer = given(
            schema,
            "HardCosts" if schema == "hardcosts" else "Answer",
            regions=(1,),
            runs=("one", "two", "three"),
            that=("transparent",),
        )
        for kind, (name, *rest) in kinds.items():
            plot(answer, ax, kind, None, "", {})
            subject = answer if schema != "simulation" else answer.runs if "recovered" in kind else "two"
            assert asked[-1] == (f"haptisym.figures.{name}", subject, *rest)
        plot(answer, ax, "", None, "", {})
        assert asked[-1][0] == f"haptisym.figures.{next(iter(kinds.values()))[0]}"


def test_hard_cases_are_told_from_costs_by_their_class(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = drawing(monkeypatch)
    plot(given("cost", "HardCosts"), axes(), "", None, "", {})
    plot(given("cost"), axes(), "", None, "", {})
    assert [x[0].split(":")[1] for x in asked] == ["draw_cases", "draw_task"]


@pytest.mark.parametrize(
    ("that", "kind", "drawn"),
    [
        (("transparent",), "", "draw_map"), (("transparent", "stable"), "", "draw_wishes"), (("stable",), "", "draw_wishes"),
        (("stable",), "map", "draw_map"), (("transparent",), "wishes", "draw_wishes"),
    ],
)  # fmt: skip
def test_a_map_of_something_else_than_transparency_is_drawn_by_wishes_unless_asked_otherwise(
    that: Any, kind: str, drawn: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = drawing(monkeypatch)
    plot(given("designmap", that=that), axes(), kind, None, "", {})
    assert asked[0][0].endswith(f":{drawn}")


@pytest.mark.parametrize(
    ("schema", "words"), [("evaluation", r"evaluate\(scene, "), ("evaluations", r"evaluate_all\(scenes, ")]
)
def test_regions_that_were_not_asked_for_are_told_with_how_to_ask(schema: str, words: str) -> None:
    with pytest.raises(NothingToDrawError, match=f"{words}regions=True"):
        plot(given(schema, regions=()), axes(), "regions", None, "", {})
    with pytest.raises(NothingToDrawError, match="these are ratios, nyquist"):
        plot(given("evaluation"), axes(), "what", None, "", {})


# Colours and labels


def test_what_takes_a_label_is_given_colour_and_label_and_its_entries_stay_as_it_wrote_them(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def draws(ax: Axes) -> list[Line2D]:
        lines = ax.plot([0, 1], [0, 1], label="line", color="#123456")
        ax.legend()
        return lines

    asked = drawing(monkeypatch, labelled=True, draws=draws)
    ax = axes()
    plot(given("peaks"), ax, "", "#009900", "mine", {"linewidth": 3.0})
    assert asked == [("haptisym.figures.ratios:draw_peaks", given("peaks"), "#009900", "mine")]
    [line] = ax.lines
    assert (to_hex(line.get_color()), line.get_linewidth()) == ("#123456", 3)
    assert told(ax) == ["line"]
    assert ax.get_legend().legend_handles[0].get_linewidth() == 3


def rows(ax: Axes) -> list[Any]:
    """A filled, a hollow and a white mark, a line, and a ground; with a legend."""
    lines = [
        *ax.plot([0, 1], [0, 1], "o-", label="filled"), *ax.plot([0, 1], [1, 0], "s", markerfacecolor="none", label="hollow"),
        *ax.plot([0, 1], [1, 1], "s", markerfacecolor="white", label="white"),
    ]  # fmt: skip
    ground = ax.axvspan(0, 0.5, facecolor=pen.SHADE, label="ground")
    names = {
        **{x.get_text(): h for x, h in zip(*_legend(ax), strict=True)},
        **{str(x.get_label()): x for x in (*lines, ground)},
    }
    ax.legend(list(names.values()), list(names))
    return [*lines, ground]


def _legend(ax: Axes) -> tuple[list[Any], list[Any]]:
    found = ax.get_legend()
    return (found.get_texts(), found.legend_handles) if found else ([], [])


def test_what_takes_no_label_has_it_behind_its_entries_and_further_ones_a_number_and_the_next_colour(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    drawing(monkeypatch, draws=rows)
    ax = axes()
    plot(given("jnd"), ax, "", None, "", {})
    assert told(ax) == ["filled", "hollow", "white", "ground"]
    assert to_hex(ax.lines[0].get_color()) == to_hex("C0")  # of its own, where it is alone
    plot(given("jnd"), ax, "", None, "", {})
    assert told(ax) == [f"{x}{n}" for n in ("", " (2)") for x in ("filled", "hollow", "white", "ground")]
    filled, hollow, white = ax.lines[3:6]
    assert {to_hex(x.get_color()) for x in (filled, hollow, white)} == {pen.SCENES[1]}
    assert {to_hex(x.get_markeredgecolor()) for x in (filled, hollow, white)} == {pen.SCENES[1]}
    assert to_hex(filled.get_markerfacecolor()) == pen.SCENES[1]
    assert (hollow.get_markerfacecolor(), white.get_markerfacecolor()) == ("none", "white")
    assert to_hex(ax.patches[1].get_facecolor()) == pen.SHADE
    plot(given("jnd"), ax, "", None, "", {})
    assert {to_hex(x.get_color()) for x in ax.lines[6:]} == {pen.SCENES[2]}
    assert [x.get_gid() for x in (*ax.lines[::3], *ax.patches)] == [f"haptisym plot {n}" for n in (1, 2, 3)] * 2


def test_a_given_colour_is_that_of_lines_and_a_given_label_that_of_entries_also_of_the_first(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    drawing(monkeypatch, draws=rows)
    ax = axes()
    plot(given("jnd"), ax, "", "#009900", "mine", {"alpha": 0.4})
    assert told(ax) == ["filled, mine", "hollow, mine", "white, mine", "ground, mine"]
    assert {to_hex(x.get_color()) for x in ax.lines} == {"#009900"}
    assert {x.get_alpha() for x in (*ax.lines, *ax.patches)} == {0.4}


def test_new_entries_get_the_label_and_old_ones_keep_theirs(monkeypatch: pytest.MonkeyPatch) -> None:
    def draws(ax: Axes) -> Any:
        [line] = ax.plot([0, 1], [0, 1], label=f"line {len(ax.lines)}")
        old = dict(zip([x.get_text() for x in _legend(ax)[0]], _legend(ax)[1], strict=True))
        names = {**old, str(line.get_label()): line}
        ax.legend(list(names.values()), list(names))
        return [line]

    drawing(monkeypatch, draws=draws)
    ax = axes()
    plot(given("jnd"), ax, "", None, "first", {})
    plot(given("jnd"), ax, "", None, "second", {})
    plot(given("jnd"), ax, "", None, "", {})
    assert told(ax) == ["line 0, first", "line 1, second", "line 2 (3)"]
    colours = [to_hex(x.get_color()) for x in ax.get_legend().legend_handles]
    assert colours[1:] == [pen.SCENES[1], pen.SCENES[2]]


def test_style_is_for_the_curves_that_are_returned_else_for_all_new_lines(monkeypatch: pytest.MonkeyPatch) -> None:
    def some(ax: Axes) -> Any:
        ax.plot([0, 1], [3, 3])
        return [*ax.plot([0, 1], [0, 1]), Patch()]  # one is not on the axes

    for draws, widths in (
        (some, [9, 1, 5]),
        (lambda ax: some(ax) and None, [9, 5, 5]),
        (lambda ax: some(ax)[:0], [9, 5, 5]),
    ):
        drawing(monkeypatch, draws=draws)
        ax = axes()
        ax.plot([0, 1], [2, 2], linewidth=9)
        for line in ax.lines:
            line.set_linewidth(9)
        with mpl.rc_context({"lines.linewidth": 1}):
            plot(given("jnd"), ax, "", None, "", {"linewidth": 5})
        assert [x.get_linewidth() for x in ax.lines] == widths


# What stays in sight


def limited(*limits: tuple[float, float]) -> Any:
    def draws(ax: Axes) -> Any:
        ax.set(xlim=limits[0], ylim=limits[1])
        return ax.plot([0, 1], [0, 1])

    return draws


@pytest.mark.parametrize(
    ("second", "x", "y"),
    [
        (((2, 3), (5, 6)), (0, 10), (-1, 6)), (((-5, 30), (-7, 0)), (-5, 30), (-7, 1)),
        (((2, 3), (6, 5)), (0, 10), (6, 5)), (((3, 2), (0, 1)), (3, 2), (-1, 1)),
    ],
    ids=["within", "beyond", "rows from above", "turned"],
)  # fmt: skip
def test_what_was_drawn_before_stays_in_sight_unless_an_axis_runs_the_other_way(
    second: Any, x: Any, y: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    ax = axes()
    drawing(monkeypatch, draws=limited((0, 10), (-1, 1)))
    plot(given("jnd"), ax, "", None, "", {})
    drawing(monkeypatch, draws=limited(*second))
    plot(given("jnd"), ax, "", None, "", {})
    assert (ax.get_xlim(), ax.get_ylim()) == (x, y)


def test_the_first_drawing_decides_over_empty_axes_and_those_of_the_caller(monkeypatch: pytest.MonkeyPatch) -> None:
    ax = axes()
    ax.plot([0, 100], [0, 100])
    drawing(monkeypatch, draws=limited((2, 3), (4, 5)))
    plot(given("jnd"), ax, "", None, "", {})
    assert (ax.get_xlim(), ax.get_ylim()) == ((2, 3), (4, 5))


def test_without_axes_new_ones_are_made_one_and_a_half_columns_wide(monkeypatch: pytest.MonkeyPatch) -> None:
    from matplotlib import pyplot

    made: list[Any] = []

    def figure(*, figsize: Any, layout: str) -> Figure:
        made.append((figsize, layout))
        return Figure(figsize=figsize)

    monkeypatch.setattr(pyplot, "figure", figure)
    drawing(monkeypatch)
    ax = plot(given("jnd"), None, "", None, "", {})
    assert made == [((pytest.approx(5.1), pytest.approx(3.4)), "constrained")]
    assert np.asarray(ax.lines[0].get_ydata()).tolist() == [0, 1]


def test_curves_of_a_further_family_have_entries_in_the_legend_that_look_like_them() -> None:
    """Its entries bore the colours of the first, or, without a label, were missing."""
    first, second = (
        hs.evaluate_all(hs.SceneFamily({"soft": LAGGED, "wall": hs.Scene(mass_spring_damper(k=k), LAGGED.effects, (0, 15), "0.1")}))
        for k in (1000, 5000)
    )  # fmt: skip
    for labels in (("", ""), ("one", "two")):
        ax = axes()
        for found, label in zip((first, second), labels, strict=True):
            found.plot(ax, kind="imag", label=label)
        entries = dict(zip(told(ax), ax.get_legend().legend_handles, strict=True))
        old, new = (f", {labels[0]}", f", {labels[1]}") if labels[0] else ("", " (2)")
        names = ["largest", "soft binds", "others", "threshold", "all transparent"]
        assert list(entries) == [f"{x}{end}" for end in (old, new) for x in names]
        assert [to_hex(entries[f"soft binds{end}"].get_color()) for end in (old, new)] == [pen.BLUE, pen.SCENES[1]]
        assert [to_hex(entries[f"others{end}"].get_color()) for end in (old, new)] == [pen.GREY, pen.SCENES[1]]
        assert to_hex(entries[f"threshold{new}"].get_color()) == pen.GREY
        dots = [to_hex(x.get_color()) for x in ax.lines if x.get_marker() == "o"]
        assert dots == [pen.BLUE, pen.SCENES[1]]


def test_a_drawing_that_fails_leaves_the_legend_as_it_was(monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(ax: Axes) -> Any:
        raise NothingToDrawError("nothing")

    ax = axes()
    drawing(monkeypatch, draws=rows)
    plot(given("jnd"), ax, "", None, "", {})
    drawing(monkeypatch, draws=fails)
    with pytest.raises(NothingToDrawError, match="nothing"):
        plot(given("jnd"), ax, "", None, "", {})
    assert told(ax) == ["filled", "hollow", "white", "ground"]
