"""What each effect changes, by laws: differences of ratios in complex numbers, names at the ends of curves, and the strip."""

from __future__ import annotations

from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.text import Annotation, Text

import haptisym as hs
from haptisym import Part
from haptisym.effects import first_order_lag, shunt
from haptisym.environments import mass_spring_damper
from haptisym.figures import pen
from haptisym.figures.effects import draw_dominance, draw_influences, influences_figure

LAG, MASS, SPRING = first_order_lag(20), shunt(m="0.1"), shunt(k="0.01")


@cache
def found(*effects: Any, tolerance: Any = "0.01", band: Any = (0, 16)) -> hs.Relevance:
    return hs.relevance(
        hs.Scene(mass_spring_damper(k=100, b=3), effects or (LAG, MASS, SPRING), band, "0.1"), tolerance
    )


def ratio(omega: Any, part: Part, *, lag: bool = True, m: float = 0.1, k: float = 0.01) -> Any:
    """Of 100 + 3 jω behind a lag, and a mass and a spring in the hand."""
    env = 100 + 3j * omega
    perc = env / (1 + 1j * omega / 20 * lag) - m * omega**2 + k
    return np.abs(getattr((perc - env) / np.abs(env), part.value))


def changes(omega: Any, part: Part) -> list[Any]:
    without: tuple[dict[str, Any], ...] = ({"lag": False}, {"m": 0.0}, {"k": 0.0})
    return [np.abs(ratio(omega, part) - ratio(omega, part, **x)) for x in without]


def axes() -> Axes:
    return Figure(figsize=(5, 4)).add_subplot()


def names(ax: Axes) -> dict[str, Annotation]:
    return {x.get_text(): x for x in ax.texts if isinstance(x, Annotation)}


# Curves


@pytest.mark.parametrize("part", Part)
def test_each_curve_is_how_far_a_ratio_moves_when_that_effect_is_left_out(part: Part) -> None:
    ax = axes()
    lines = draw_influences(ax, found(), part)
    floor = ax.get_ylim()[0]
    for line, exact in zip(lines, (lambda w, i=i: changes(w, part)[i] for i in range(3)), strict=True):
        omega, values = np.asarray(line.get_xdata(), float), np.asarray(line.get_ydata(), float)
        assert omega == pytest.approx(16 * (np.arange(256) + 0.5) / 256)  # evenly, in the middle of pieces of the band
        shown = np.isfinite(values)
        assert values[shown] == pytest.approx(exact(omega)[shown], rel=1e-9, abs=1e-14)
        assert (exact(omega)[~shown] < floor / 9).all()
        assert (exact(omega)[shown] > floor / 11).all()


def test_what_matters_is_bold_each_with_a_stroke_of_its_own_and_what_does_not_is_thin_and_grey() -> None:
    """A spring of 0.01 N/m changes no ratio by more than a ten-thousandth."""
    ax = axes()
    e = found()
    assert [x.kept for x in e.effects] == [True, True, False]
    lines = draw_influences(ax, e, Part.REAL)
    looks = [(to_hex(x.get_color()), x.get_linewidth()) for x in lines]
    assert looks == [(pen.INK, 1.2), (pen.INK, 1.2), (pen.GREY, 0.6)]
    assert [x.is_dashed() for x in lines] == [False, True, False]
    assert [to_hex(x.get_color()) for x in names(ax).values()].count(pen.INK) == 2


def test_the_tolerance_is_a_dotted_level_with_its_name_at_the_end() -> None:
    ax = axes()
    draw_influences(ax, found(), Part.REAL)
    [level] = [x for x in ax.lines if x.get_label() == "tolerance"]
    assert list(level.get_ydata()) == [0.01, 0.01]
    assert to_hex(level.get_color()) == pen.GREY
    assert level.is_dashed()
    assert names(ax)["tolerance"].xy == (1, 0.01)


def test_the_axes_reach_from_three_and_a_half_decades_below_the_tolerance_to_twice_the_largest_change() -> None:
    for part, label in ((Part.REAL, r"change of $r_\mathrm{r}$"), (Part.IMAG, r"change of $r_\mathrm{i}$")):
        ax = axes()
        draw_influences(ax, found(), part)
        most = max(x.max() for x in changes(16 * (np.arange(256) + 0.5) / 256, part))
        assert most > 0.01
        assert ax.get_ylim() == (pytest.approx(0.01 * 10**-3.5), pytest.approx(2 * most))
        assert ax.get_xlim() == (0, 16)
        assert (ax.get_yscale(), ax.get_ylabel(), ax.get_xlabel()) == ("log", label, r"$\omega$ (rad/s)")


def test_without_a_tolerance_the_axes_hang_from_the_largest_change() -> None:
    ax = axes()
    draw_influences(ax, found(tolerance=0), Part.REAL)
    most = max(x.max() for x in changes(16 * (np.arange(256) + 0.5) / 256, Part.REAL))
    assert ax.get_ylim() == (pytest.approx(most * 10**-3.5), pytest.approx(2 * most))
    assert "tolerance" not in names(ax)
    quiet = axes()
    draw_influences(quiet, found(SPRING, tolerance="0.5"), Part.REAL)
    assert quiet.get_ylim() == (pytest.approx(0.5 * 10**-3.5), pytest.approx(1))


def test_names_stand_beside_the_ends_of_their_curves_in_the_order_of_these_and_apart() -> None:
    ax = axes()
    lines = draw_influences(ax, found(), Part.REAL)
    ends = {
        e.effect.name: float(np.asarray(x.get_ydata())[-1]) for e, x in zip(found().effects, lines, strict=True) if x
    }
    low, high = ax.get_ylim()
    for name, x in names(ax).items():
        if name in ("first-order-lag", "tolerance"):
            value = ends.get(name, 0.01)
            assert x.xy == (1, pytest.approx(value))
            share = np.log(value / low) / np.log(high / low)
            assert x.xyann == (1.05, pytest.approx(share, abs=0.08))
    ax.figure.draw_without_rendering()
    boxes = sorted((Text.get_window_extent(x) for x in names(ax).values()), key=lambda box: box.y0)
    assert all(a.y1 <= b.y0 + 1 for a, b in pairwise(boxes))
    assert all(box.x0 > ax.bbox.x1 for box in boxes)
    heights = [(x.xyann[1], x.xy[1]) for x in names(ax).values()]
    assert sorted(heights) == sorted(heights, key=lambda pair: (pair[1], pair[0]))


def test_a_name_of_what_ends_below_the_axes_stands_at_their_lower_end() -> None:
    """A spring of 10⁻⁷ N/m is far below all that is shown."""
    ax = axes()
    tiny = shunt(k="1e-7")
    draw_influences(ax, found(LAG, tiny), Part.REAL)
    x = names(ax)["shunt"]
    assert x.xy == (1, pytest.approx(ax.get_ylim()[0]))
    assert 0 <= x.xyann[1] < 0.06
    assert to_hex(x.get_color()) == pen.GREY


def test_a_further_scene_has_its_colour_its_names_and_its_tolerance_if_that_is_another() -> None:
    ax = axes()
    first = draw_influences(ax, found(), Part.REAL)
    limits = ax.get_ylim()
    second = draw_influences(ax, found(LAG, tolerance="0.0001"), Part.REAL)
    third = draw_influences(ax, found(LAG), Part.REAL, label="again", color="#009900")
    assert [to_hex(x.get_color()) for x in (first[0], *second, *third)] == [pen.INK, pen.SCENES[1], "#009900"]
    assert set(names(ax)) == {
        "first-order-lag", "shunt", "shunt-2", "tolerance", "first-order-lag (2)", "tolerance (2)",
        "first-order-lag, again",
    }  # fmt: skip
    assert names(ax)["tolerance (2)"].xy == (1, 0.0001)
    assert ax.get_ylim() == (pytest.approx(1e-4 * 10**-3.5), pytest.approx(limits[1]))
    assert to_hex(names(ax)["first-order-lag (2)"].get_color()) == pen.SCENES[1]


def test_what_the_caller_wrote_on_the_axes_stays_there() -> None:
    ax = axes()
    notes = {ax.annotate("mine", (1, 1)), ax.text(2, 2, "yours")}
    for _ in range(2):
        draw_influences(ax, found(LAG), Part.REAL)
    written = [x.get_text() for x in ax.texts]
    assert notes <= set(ax.texts)
    assert (written.count("mine"), written.count("yours")) == (1, 1)
    assert set(written) == {"mine", "yours", "first-order-lag", "first-order-lag (2)", "tolerance"}


@pytest.mark.parametrize(("tolerance", "middle"), [("0.01", 0.01), (0, 1)])
def test_without_effects_there_is_the_tolerance_alone(tolerance: Any, middle: float) -> None:
    bare = hs.relevance(hs.Scene(mass_spring_damper(k=100), (), (0, 15), "0.1"), tolerance)
    ax = axes()
    assert draw_influences(ax, bare, Part.REAL) == []
    assert ax.get_ylim() == (pytest.approx(middle * 10**-3.5), pytest.approx(2 * middle))
    assert list(names(ax)) == (["tolerance"] if tolerance else [])


def test_a_part_that_nothing_changes_is_an_empty_chart_without_a_word_of_matplotlib() -> None:
    """A spring alone leaves the imaginary part as it is; with a tolerance of 0 nothing at all is above 0."""
    ax = axes()
    [line] = draw_influences(
        ax, hs.relevance(hs.Scene(mass_spring_damper(k=100), (shunt(k=1),), (0, 15), "0.1"), 0), Part.IMAG
    )
    assert not np.isfinite(np.asarray(line.get_ydata(), float)).any()
    assert (ax.get_yscale(), ax.get_ylim()) == ("log", (pytest.approx(10**-3.5), pytest.approx(2)))


@pytest.mark.slow
def test_four_effects_that_matter_have_four_strokes() -> None:
    """Lags of 20 to 23 rad/s."""
    lags = tuple(first_order_lag(n) for n in (20, 21, 22, 23, 24))
    lines = draw_influences(axes(), found(*lags), Part.IMAG)
    strokes = [str(x._dash_pattern) for x in lines]  # type: ignore[attr-defined]
    assert len(set(strokes)) == 4
    assert strokes[4] == strokes[0]


def test_in_hertz_curves_and_limits_are_in_hertz() -> None:
    ax = axes()
    [line] = draw_influences(ax, found(LAG), Part.IMAG, hertz=True)
    assert ax.get_xlim() == (0, pytest.approx(16 / (2 * np.pi)))
    assert ax.get_xlabel() == "frequency (Hz)"
    assert np.asarray(line.get_xdata())[[0, -1]] == pytest.approx(np.array([1 / 32, 16 - 1 / 32]) / (2 * np.pi))


# The strip


def strip(*effects: Any) -> Axes:
    ax = axes()
    draw_dominance(ax, found(*effects))
    return ax


def test_the_strip_has_each_piece_under_the_effect_that_changes_most_there() -> None:
    """The lag against a mass of 0.1 kg: by the changes of both ratios."""
    ax, e = axes(), found(LAG, shunt(m="0.4"))
    pieces = draw_dominance(ax, e)
    spans = [(x.get_x(), x.get_x() + x.get_width()) for x in pieces]  # type: ignore[attr-defined]
    assert spans == [(float(x.low), float(x.high)) for x in e.dominance]
    assert len({x.effect.name for x in e.dominance}) == 2
    for (low, high), x in zip(spans, e.dominance, strict=True):
        omega = np.linspace(low, high, 12)[1:-1]
        lag, mass = (np.zeros(10), np.zeros(10))
        for part in Part:
            both = ratio(omega, part, m=0.4, k=0)
            lag = np.maximum(lag, np.abs(both - ratio(omega, part, lag=False, m=0.4, k=0)))
            mass = np.maximum(mass, np.abs(both - ratio(omega, part, m=0, k=0)))
        assert ((lag > mass) == (x.effect.name == "first-order-lag")).all()
    faces = {x.effect.name: to_hex(p.get_facecolor()) for p, x in zip(pieces, e.dominance, strict=True)}
    assert faces == {e.dominance[0].effect.name: pen.SHADE, e.dominance[-1].effect.name: "#c4c4c4"}
    assert (ax.get_xlim(), ax.get_ylim()) == ((0, 16), (0, 1))
    assert not ax.axison
    assert ax.get_title(loc="left").startswith("changes the ratios most")


class Named:
    """A dominance by hand: names from where to where."""

    def __init__(self, *rows: tuple[str, float, float], band: tuple[float, float] = (0, 100)) -> None:
        class Effect:
            def __init__(self, name: str) -> None:
                self.name = name

        class Row:
            def __init__(self, name: str, low: float, high: float) -> None:
                self.effect, self.low, self.high = Effect(name), low, high

        self.dominance = [Row(*x) for x in rows]
        self.scene = type("Scene", (), {"band": band})()


def drawn(*rows: tuple[str, float, float], band: tuple[float, float] = (0, 100)) -> tuple[list[tuple[str, float]], str]:
    ax = axes()
    draw_dominance(ax, Named(*rows, band=band))  # type: ignore[arg-type]
    return [(x.get_text(), x.get_position()[0]) for x in ax.texts], ax.get_title(loc="left")


def test_a_name_that_has_no_room_is_a_number_that_the_title_tells_the_same_for_the_same() -> None:
    texts, title = drawn(
        ("lag", 0, 50),
        ("second-order-lowpass", 50, 56),
        ("delay", 56, 70),
        ("shunt", 70, 76),
        ("second-order-lowpass", 76, 82),
    )
    assert texts == [("lag", 25), ("1", 53), ("delay", 63), ("2", 73), ("1", 79)]
    assert title == "changes the ratios most: 1 second-order-lowpass, 2 shunt"


def test_of_slivers_only_those_are_told_in_words_whose_name_stands_nowhere() -> None:
    texts, title = drawn(
        ("lag", 0, 49),
        ("delay", 49, 49.5),
        ("wave", 49.5, 50),
        ("lag", 50, 50.2),
        ("shunt", 50.2, 99),
        ("lag", 99, 100),
    )
    assert [x for x, _ in texts] == ["lag", "", "", "", "shunt", ""]
    assert title == "changes the ratios most: in slivers delay, wave"
    _, title = drawn(("shunt", 0, 6), ("delay", 6, 6.2), ("lag", 6.2, 99.8), ("shunt", 99.8, 100))
    assert title == "changes the ratios most: 1 shunt; in slivers delay"


def test_a_title_that_would_be_long_counts_what_it_does_not_name() -> None:
    long = [(f"effect-with-a-name-{n}", 6.0 * n, 6.0 * n + 5.9) for n in range(3)]
    _, title = drawn(*long, ("lag", 20, 99), ("delay", 99, 100))
    assert title == "changes the ratios most: 4 more in narrow pieces"


def test_how_narrow_a_piece_is_goes_by_the_width_of_the_band() -> None:
    assert drawn(("shunt", 1000, 1200), ("lag", 1200, 1400), band=(1000, 1400))[0] == [("shunt", 1100), ("lag", 1300)]


# The sheet


def test_the_sheet_has_the_strip_above_both_parts_and_frequencies_below_the_lower_one() -> None:
    figure = influences_figure(found())
    strip, real, imag = figure.axes
    assert strip.get_title(loc="left")
    assert (real.get_ylabel(), imag.get_ylabel()) == (r"change of $r_\mathrm{r}$", r"change of $r_\mathrm{i}$")
    assert (real.get_xlabel(), imag.get_xlabel()) == ("", r"$\omega$ (rad/s)")
    assert (real.xaxis.get_tick_params()["labelbottom"], imag.xaxis.get_tick_params().get("labelbottom", True)) == (
        False,
        True,
    )
    figure.draw_without_rendering()
    for text in strip.texts:
        box = Text.get_window_extent(text)
        assert not text.get_text() or (strip.bbox.y0 - 1 < box.y0 and box.y1 < strip.bbox.y1 + 1)
    assert {ax.get_position().x0 for ax in figure.axes} == {0.13}
    tops = [ax.get_position().y1 for ax in figure.axes]
    assert tops == sorted(tops, reverse=True)
    assert real.get_position().height == pytest.approx(imag.get_position().height)
    assert figure.get_figwidth() == pytest.approx(1.3 * pen.WIDTH)


def test_without_effects_there_is_nothing_to_draw() -> None:
    bare = hs.relevance(hs.Scene(mass_spring_damper(k=100), (), (0, 15), "0.1"))
    with pytest.raises(hs.SceneError, match="no effects to draw"):
        influences_figure(bare)
