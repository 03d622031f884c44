"""Magnitudes of the parts and what is felt of them, by laws: closed forms in complex numbers, and words that lie in their bands."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.text import Annotation, Text

import haptisym as hs
from haptisym import Part
from haptisym.effects import first_order_lag, shunt
from haptisym.environments import mass_spring_damper
from haptisym.figures import pen
from haptisym.figures.projections import _Label, _write_percepts, draw_projections
from haptisym.model.regions import Region, Shape

LAG = (mass_spring_damper(k=100, b=3), (first_order_lag(20),), (0, 30))
DISC = hs.Threshold("0.1", "0.1", region=Region(Shape.ELLIPSE))
UNDAMPED = hs.Scene(mass_spring_damper(m=1, k=100), (shunt(m="0.1"),))
"""100 - ω² and 100 - 1.1 ω²: bands end at √50, √(1000/11), √(200/2.1) and 10 rad/s."""
BELOW, BETWEEN, OVER = np.sqrt([50, 1000 / 11, 200 / 2.1])


def axes() -> Axes:
    return Figure(figsize=(5, 4)).add_subplot()


def told(ax: Axes) -> list[str]:
    return [x.get_text() for x in ax.get_legend().get_texts()]


def env(omega: Any) -> Any:
    return 100 + 3j * omega


def perc(omega: Any) -> Any:
    return env(omega) / (1 + 1j * omega / 20)


@cache
def evaluated(scene: hs.Scene) -> hs.Evaluation:
    return hs.evaluate(scene)


def lagged(threshold: hs.Threshold | None = None) -> hs.Evaluation:
    return evaluated(hs.Scene(*LAG, threshold or hs.Threshold.of("0.1")))


def shown(line: Line2D) -> tuple[Any, Any]:
    """The frequencies and values at which a line is."""
    x, y = np.asarray(line.get_xdata(), float), np.asarray(line.get_ydata(), float)
    return x[np.isfinite(y)], y[np.isfinite(y)]


def grounds(ax: Axes) -> list[tuple[float, float]]:
    return [(x.get_x(), x.get_x() + x.get_width()) for x in ax.patches]  # type: ignore[attr-defined]


def words(ax: Axes) -> dict[str, Annotation]:
    return {x.get_text(): x for x in ax.texts if isinstance(x, Annotation)}


def boundaries(ax: Axes) -> list[float]:
    return [float(x.get_xdata()[0]) for x in ax.lines if len(x.get_xdata()) == 2]  # type: ignore[index]


# What is bold


@pytest.mark.parametrize("part", Part)
@pytest.mark.parametrize("threshold", [hs.Threshold.of("0.1", "0.3"), DISC], ids=["square", "disc"])
def test_curves_are_bold_where_a_part_is_told_alone_or_both_are_together(part: Part, threshold: hs.Threshold) -> None:
    """Of the disc a part has its share where it alone leaves it, and where neither alone does."""
    ax, e = axes(), lagged(threshold)
    lines = draw_projections(ax, e, part)
    for bold, thin, dynamics in ((*lines[:2], env), (*lines[2:], perc)):
        assert (bold.get_linewidth(), thin.get_linewidth()) == (1.6, 0.7)
        for line, is_bold in ((bold, True), (thin, False)):
            omega, magnitude = shown(line)
            assert magnitude == pytest.approx(np.abs(getattr(dynamics(omega), part.value)), abs=1e-9)
            change = (perc(omega) - env(omega)) / np.abs(env(omega))
            x, y = (np.abs(change.real), np.abs(change.imag))[:: 1 if part is Part.REAL else -1]
            if threshold is DISC:
                noticed = (np.hypot(x, y) > 0.1) & ((x > 0.1) | (y <= 0.1))
                sure = np.min(np.abs([np.hypot(x, y) - 0.1, x - 0.1, y - 0.1]), axis=0) > 1e-9
            else:
                noticed = x > (0.1 if part is Part.REAL else 0.3)
                sure = np.abs(x - (0.1 if part is Part.REAL else 0.3)) > 1e-9
            assert sure.sum() > 100
            assert (noticed[sure] == is_bold).all()
    every = [np.concatenate([shown(x)[0] for x in pair]) for pair in (lines[:2], lines[2:])]
    assert all((x.min(), x.max()) == (0, 30) for x in every)


def test_a_part_that_a_disc_is_left_in_is_never_said_not_to_exceed() -> None:
    """An active display: Im H_perc < 0, so that what is noticed has no name; it was drawn bold and denied in words."""
    ax, e = axes(), lagged(DISC)
    draw_projections(ax, e, Part.IMAG)
    assert list(words(ax)) == ["noticed, not named"]
    first = float(e.crossings[0].omega)
    omega = np.linspace(first - 1e-6, first + 1e-6, 2)
    change = np.abs(perc(omega) - env(omega)) / np.abs(env(omega))
    assert change[0] < 0.1 < change[1]
    assert words(ax)["noticed, not named"].xy[0] == pytest.approx((first + 30) / 2 / 30)
    assert boundaries(ax) == [pytest.approx(first)]
    ax = axes()
    draw_projections(ax, e, Part.REAL)
    assert set(words(ax)) == {"lower stiffness", "1"}
    assert told(ax)[-1] == "noticed, not named"
    assert words(ax)["1"].xy[0] * 30 == pytest.approx((first + 2.0117) / 2, abs=1e-4)
    assert words(ax)["1"].xyann[0] < words(ax)["lower stiffness"].xyann[0]  # strokes to their bands do not cross


def test_what_both_parts_tell_together_is_named_in_both_charts() -> None:
    """A mass of 1/10 more and a damper of 0.9 less: no part leaves its own limit before both leave the disc."""
    scene = hs.Scene(mass_spring_damper(1, 12, 100), (shunt(m="0.12", b="-1.1"),), (0, 14), DISC)
    e = evaluated(scene)
    both = [x for x in e.percepts if x.part is None]
    assert both
    for part, own in ((Part.REAL, "stiffness"), (Part.IMAG, "lower damping")):
        ax = axes()
        draw_projections(ax, e, part)
        said = [x.replace("\n", " ") for x in (*words(ax), *told(ax))]
        assert any(own in x for x in said)
        assert not any(x.get_text() == "never exceeds the threshold" for x in ax.texts)


def test_damping_that_is_wholly_taken_away_has_a_name() -> None:
    """Im H_perc is 0: the display is not active yet."""
    ax = axes()
    lost = evaluated(hs.Scene(mass_spring_damper(k=100, b=12), (shunt(b=-12),), (0, 14), DISC))
    draw_projections(ax, lost, Part.IMAG)
    assert list(words(ax)) == ["lower damping"]
    first = boundaries(ax)[0]
    assert 12 * first == pytest.approx(0.1 * abs(100 + 12j * first))


# What is told beside the curves


@pytest.mark.parametrize(("part", "name"), [(Part.REAL, "Re"), (Part.IMAG, "Im")])
def test_axes_and_entries_are_named_after_the_part(part: Part, name: str) -> None:
    ax = axes()
    lines = draw_projections(ax, lagged(hs.Threshold.of("0.05")), part)
    entries = [rf"$|\mathrm{{{name}}}\,H_\mathrm{{{x}}}|$" for x in ("env", "perc")]
    assert told(ax) == [*entries, "not noticed"]
    assert [x.get_label() for x in lines[::2]] == entries
    assert all(x.get_label().startswith("_") for x in lines[1::2])
    assert (ax.get_xlabel(), ax.get_ylabel()) == (r"$\omega$ (rad/s)", rf"$|\mathrm{{{name}}}\,H|$ (N/m)")
    looks = [(to_hex(x.get_color()), x.get_linestyle()) for x in lines]
    assert looks == [(pen.BLUE, "-")] * 2 + [(pen.RED, "--")] * 2


def test_the_axes_reach_from_0_to_a_third_above_the_largest_magnitude_so_that_words_have_room() -> None:
    for part in Part:
        ax, omega = axes(), np.linspace(0, 30, 20_001)
        draw_projections(ax, lagged(), part)
        most = max(np.abs(getattr(H(omega), part.value)).max() for H in (env, perc))
        assert ax.get_ylim() == (0, pytest.approx(1.3 * 1.06 * most, rel=1e-6))
        assert ax.get_xlim() == (0, 30)
    flat = axes()
    draw_projections(flat, evaluated(hs.Scene(mass_spring_damper(k=100), (shunt(k=20),))), Part.IMAG)
    assert flat.get_ylim() == (0, 1)


def test_the_ground_is_grey_where_nothing_is_noticed_and_strokes_stand_where_percepts_end() -> None:
    ax = axes()
    draw_projections(ax, evaluated(UNDAMPED), Part.REAL)
    assert grounds(ax) == [(0, pytest.approx(BELOW))]
    assert {to_hex(x.get_facecolor()) for x in ax.patches} == {pen.SHADE}
    assert boundaries(ax) == pytest.approx([BELOW, BETWEEN, OVER, 10])  # none at the end of the band
    assert told(ax)[2] == "not noticed"


def test_of_several_grey_bands_one_has_an_entry() -> None:
    """A tenth of ``|100 - 2 ω²|`` is more than 0.1 ω² below √(100/3) rad/s and above 10."""
    ax = axes()
    draw_projections(ax, evaluated(hs.Scene(mass_spring_damper(m=2, k=100), UNDAMPED.effects, (0, 30))), Part.REAL)
    assert np.array(grounds(ax)) == pytest.approx(np.array([(0, np.sqrt(100 / 3)), (10, 30)]))
    assert told(ax)[2:3] == ["not noticed"]
    assert not any(x.startswith("_") for x in told(ax))


def test_words_stand_in_the_middle_of_their_band_or_are_tied_to_it() -> None:
    ax = axes()
    draw_projections(ax, evaluated(UNDAMPED), Part.REAL)
    middles = {
        "lower\nstiffness": (BELOW + BETWEEN) / 2, "1": (BETWEEN + OVER) / 2, "2": (OVER + 10) / 2, "higher mass": 12.5,
    }  # fmt: skip
    halves = {"lower\nstiffness": BETWEEN - BELOW, "1": OVER - BETWEEN, "2": 10 - OVER, "higher mass": 5}
    assert list(words(ax)) == list(middles)
    for text, x in words(ax).items():
        assert x.xy == (pytest.approx(middles[text] / 15), 0.82)
        assert x.xyann[1] == 0.98
        off = abs(x.xyann[0] - x.xy[0]) * 15
        assert (x.arrow_patch is not None) == (off > halves[text] / 2)
    assert told(ax)[3:] == [f"mass instead of stiffness, with {x} force" for x in ("lower", "higher")]
    marks = [x.get_marker() for x in ax.get_legend().legend_handles[3:]]
    assert marks == ["$1$", "$2$"]


def test_a_part_that_is_never_noticed_has_no_words_but_that() -> None:
    ax = axes()
    draw_projections(ax, evaluated(UNDAMPED), Part.IMAG)
    assert [x.get_text() for x in ax.texts] == ["never exceeds the threshold"]
    assert grounds(ax) == [(0, 15)]
    assert boundaries(ax) == []


def test_a_change_of_just_the_threshold_is_not_noticed_anywhere() -> None:
    """A spring of 100 N/m and 10 N/m more."""
    ax = axes()
    bold, thin, *_ = draw_projections(ax, evaluated(hs.Scene(mass_spring_damper(k=100), (shunt(k=10),))), Part.REAL)
    assert not len(shown(bold)[0])
    assert shown(thin)[1] == pytest.approx(100)
    assert grounds(ax) == [(0, 15)]


def test_eight_of_many_narrow_bands_are_numbered_the_widest_and_the_others_counted() -> None:
    """Bands of 0.1 to 1 from 0 to 110, the same words twice: one number for these."""
    ax = axes()
    ax.set_xlim(0, 110)
    labels = [_Label(10.0 * n, 10 * n + 0.1 * n, f"felt as {n}" if n != 10 else "felt as 7") for n in range(1, 11)]
    handles = _write_percepts(ax, labels)
    expected = ["3", "4", "5", "6", "7", "8", "9"]
    assert [x.get_label() for x in handles] == [*(f"felt as {n}" for n in expected), "and 2 narrower"]
    assert [x.get_marker() for x in handles[:-1]] == [f"${n}$" for n in range(1, 8)]
    assert [x.get_text() for x in ax.texts] == ["1", "2", "3", "4", "5", "6", "7", "5"]
    places = [x.xy[0] * 110 for x in ax.texts if isinstance(x, Annotation)]
    assert places == pytest.approx([10.05 * n for n in range(3, 11)])


def test_words_are_broken_after_their_first_comma_or_space_where_one_line_has_no_room() -> None:
    ax = axes()
    ax.set_xlim(0, 10)
    letters = [_Label(0, 1.6, "higher damping"), _Label(1.7, 5, "mass instead, with lower force"), _Label(6, 10, "a b")]
    assert _write_percepts(ax, letters) == []
    assert [x.get_text() for x in ax.texts] == ["higher\ndamping", "mass instead,\nwith lower force", "a b"]
    ax.figure.draw_without_rendering()
    for x, label in zip(ax.texts, letters, strict=True):
        box = Text.get_window_extent(x)
        assert ax.transData.transform((label.low, 0))[0] <= box.x0
        assert box.x1 <= ax.transData.transform((label.high, 0))[0]


# A further scene, and Hz


def test_a_further_scene_has_bars_at_the_top_for_its_bands_and_no_words_of_its_own() -> None:
    ax = axes()
    first = draw_projections(ax, lagged(hs.Threshold.of("0.05")), Part.REAL)
    texts, strokes, top = list(words(ax)), boundaries(ax), ax.get_ylim()[1]
    second = draw_projections(ax, evaluated(UNDAMPED), Part.REAL, label="stiff")
    assert list(words(ax)) == texts
    [bar] = [x for x in ax.lines if x.get_linewidth() == 2.5]
    assert list(bar.get_xdata()) == pytest.approx([0, BELOW])
    assert bar.get_label() == "not noticed, stiff"
    assert boundaries(ax) == [*strokes, *bar.get_xdata()[:1]]  # type: ignore[index]
    assert {to_hex(x.get_color()) for x in (*second, bar)} == {pen.SCENES[1]}
    assert {to_hex(x.get_color()) for x in first} == {pen.BLUE, pen.RED}
    assert ax.get_ylim() == (0, pytest.approx(max(top, 1.3 * 1.06 * (1.1 * 225 - 100))))
    assert ax.get_xlim() == (0, 30)
    assert told(ax)[:3] == [r"$|\mathrm{Re}\,H_\mathrm{env}|$", r"$|\mathrm{Re}\,H_\mathrm{perc}|$", "not noticed"]
    assert told(ax)[-3:] == [
        r"$|\mathrm{Re}\,H_\mathrm{env}|$, stiff", r"$|\mathrm{Re}\,H_\mathrm{perc}|$, stiff", "not noticed, stiff",
    ]  # fmt: skip


def test_in_hertz_curves_bands_words_and_strokes_are_in_hertz() -> None:
    ax = axes()
    lines = draw_projections(ax, evaluated(UNDAMPED), Part.REAL, hertz=True)
    turn = 2 * np.pi
    assert grounds(ax) == [(0, pytest.approx(BELOW / turn))]
    assert boundaries(ax) == pytest.approx(np.array([BELOW, BETWEEN, OVER, 10]) / turn)
    assert ax.get_xlim() == (0, pytest.approx(15 / turn))
    assert ax.get_xlabel() == "frequency (Hz)"
    at, values = shown(lines[2])
    assert values == pytest.approx(np.abs(100 - 1.1 * (turn * at) ** 2))
    assert words(ax)["higher mass"].xy[0] == pytest.approx(12.5 / 15)


def test_a_pole_leaves_a_gap_in_the_curve_and_does_not_stretch_the_axes() -> None:
    """500 ω/(100 - ω²) at 10 rad/s."""
    ax = axes()
    ringing = evaluated(hs.Scene(mass_spring_damper(1, 5, 100), (hs.effects.second_order_lowpass(10, 0),)))
    lines = draw_projections(ax, ringing, Part.IMAG)
    bold = lines[2]
    x, y = np.asarray(bold.get_xdata(), float), np.asarray(bold.get_ydata(), float)
    assert np.isnan(y[x == 10]).all()
    near = (x > 9.99) & (x < 10.01) & np.isfinite(y)
    assert y[near] == pytest.approx(np.abs(500 * x[near] / (100 - x[near] ** 2)), rel=1e-6)
    assert ax.get_ylim()[1] < 2000
