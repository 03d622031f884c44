"""Figures of evaluations show what the evaluation proves: closed forms written out here go through every place that is drawn."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from drawn import at_curves, axes, curves, marked, places, points, shown, spans, told, words
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PatchCollection
from matplotlib.colors import to_hex
from matplotlib.lines import Line2D
from matplotlib.patches import Polygon, Rectangle
from matplotlib.text import Annotation, Text

import haptisym as hs
from haptisym import Part
from haptisym.effects import first_order_lag, second_order_lowpass, series, shunt
from haptisym.environments import mass_spring_damper
from haptisym.figures import compare as compare_charts
from haptisym.figures import effects as effect_charts
from haptisym.figures import evaluation as evaluation_charts
from haptisym.figures import family as family_charts
from haptisym.figures import measured as measured_charts
from haptisym.figures import pen
from haptisym.figures.effects import verdict_bands
from haptisym.figures.evaluation import outline
from haptisym.figures.family import worst_case
from haptisym.figures.layers import Panel, draw
from haptisym.figures.measured import unit_of
from haptisym.judge.crossings import noticed
from haptisym.judge.percepts import felt

PAPER = hs.Scene(mass_spring_damper("1.8 kg", "15 N*s/m", "100 N/m"), (second_order_lowpass("80 rad/s", "0.5"),))
STIFF = mass_spring_damper(k=100, b=3)
LAGGED = hs.Scene(STIFF, (first_order_lag(20),), (0, 15), "0.1")
UNDAMPED = hs.Scene(mass_spring_damper(m=1, k=100), (shunt(m="0.1"),))
"""100 - ω² and 100 - 1.1 ω²: bands end at √50, √(1000/11), √(200/2.1) and 10 rad/s."""
LIGHTLY_DAMPED = hs.Scene(mass_spring_damper(1, "0.002", 100), (shunt(m="0.1"),))
IDENTITY = hs.Scene(mass_spring_damper(1, 5, 100))
NOTCH = hs.Scene(mass_spring_damper(1, 5, 100), (series("(s^2 + 0.01*s + 49)/(s^2 + 0.2*s + 49)"),))
RINGING = hs.Scene(mass_spring_damper(1, 5, 100), (second_order_lowpass(10, 0),))
RINGING_AT_SQRT_50 = hs.Scene(mass_spring_damper(1, 5, 50), (series("50/(s^2 + 50)"),))
STIFFENED = hs.Scene(mass_spring_damper(k=100), (shunt(k=20),))
ROTATION = hs.Scene(
    mass_spring_damper("0.01 kg*m^2", "0.2 N*m*s/rad", "3 N*m/rad"),
    (shunt(m="0.002 kg*m^2"),),
    (3, 30),
    hs.Threshold.of("0.05", "0.2"),
)
ELLIPSE = {"shape": "ellipse", "real": "0.1", "imag": "0.1"}
DISC = replace(LAGGED, band=(0, 30), threshold=hs.Scene(STIFF, (), (0, 15), ELLIPSE).threshold)
"""Its display is active: Im H_perc < 0 from 3/20 of 100 on."""


@cache
def evaluated(scene: hs.Scene) -> hs.Evaluation:
    return hs.evaluate(scene)


def drawn(scene: hs.Scene, chart: Any, *more: Any) -> Axes:
    ax = axes()
    draw(ax, chart(evaluated(scene), *more))
    return ax


def env(omega: Any) -> Any:
    return 100 + 3j * np.asarray(omega)


def perc(omega: Any) -> Any:
    return env(omega) / (1 + 1j * np.asarray(omega) / 20)


def paper_env(omega: Any) -> Any:
    return 1.8 * (1j * omega) ** 2 + 15j * omega + 100


def paper_perc(omega: Any) -> Any:
    return paper_env(omega) * 6400 / ((1j * omega) ** 2 + 80j * omega + 6400)


# The ratios.


def test_the_ratios_drawn_are_those_of_eq_10() -> None:
    ax = drawn(PAPER, evaluation_charts.ratios)
    for line, part in zip(curves(ax), (np.real, np.imag), strict=True):
        omega, ratio = places(line)
        change = part(paper_perc(omega) - paper_env(omega))
        assert ratio == pytest.approx(np.abs(change) / np.abs(paper_env(omega)), rel=1e-9, abs=1e-12)
        assert (omega[0], omega[-1]) == (0.0, 15.0)
    assert ax.get_xlabel() == r"$\omega$ (rad/s)"


def test_crossings_are_marked_on_the_threshold_and_labelled_and_each_is_a_sample() -> None:
    ax, e = drawn(PAPER, evaluation_charts.ratios), evaluated(PAPER)
    assert [points(x) for x in marked(ax, "o")] == [[(float(c.omega), 0.1)] for c in e.crossings]
    assert {"7.979", "11.94"} <= set(words(ax))
    assert {float(c.omega) for c in e.crossings} <= set(places(curves(ax)[0])[0])


@pytest.mark.slow
def test_six_crossings_are_labelled_each() -> None:
    ax, e = drawn(NOTCH, evaluation_charts.ratios), evaluated(NOTCH)
    assert len(e.crossings) == 6
    assert {c.omega.digits(4) for c in e.crossings} <= set(words(ax))
    assert sum(len(x.get_xdata()) for x in marked(ax, "o")) == 6


@pytest.mark.dear("(0, 15)1", "(0, 15)3")
@pytest.mark.parametrize("scene", [PAPER, NOTCH, ROTATION, IDENTITY, STIFFENED], ids=lambda x: str(x.band))
def test_grey_bands_are_where_all_is_transparent_and_each_ratio_has_its_threshold(scene: hs.Scene) -> None:
    ax, document = drawn(scene, evaluation_charts.ratios), evaluated(scene).to_dict()
    assert np.array(spans(ax.patches)) == pytest.approx(np.array([tuple(x) for x in document["transparent"]]))
    assert ("nowhere transparent" in words(ax)) == (not document["transparent"])
    levels = {y[0] for x in ax.lines if len(y := places(x)[1]) == 2 and y[0] == y[1]}
    assert levels == ({0.05, 0.2} if scene is ROTATION else {0.1})


def test_a_peak_of_500_that_is_a_thousandth_of_the_band_wide_is_drawn_to_its_top() -> None:
    """At omega = 10 exactly, H_env = 0.02 j and dH = -0.1 omega^2 = -10."""
    ax = drawn(LIGHTLY_DAMPED, evaluation_charts.ratios)
    omega, ratio = places(curves(ax)[0])
    assert ratio[omega == 10] == pytest.approx([500])
    assert ratio.max() < 500.1
    assert "500 at 10" in words(ax)


@pytest.mark.dear("paper")
@pytest.mark.parametrize(
    "scene", [PAPER, LIGHTLY_DAMPED, pytest.param(NOTCH, marks=pytest.mark.slow)], ids=["paper", "peak", "notch"]
)
def test_straight_lines_between_samples_are_the_curve_to_the_eye(scene: hs.Scene) -> None:
    ax = drawn(scene, evaluation_charts.ratios)
    top, f, near = ax.get_ylim()[1], evaluated(scene).distortion.compile(), np.geomspace(1e-7, 3, 20_001)
    omega = np.concatenate([np.linspace(0, 15, 50_001), 7 - near, 7 + near, 10 - near, 10 + near])
    for line, exact in zip(curves(ax), (f(omega).ratio_real, f(omega).ratio_imag), strict=True):
        seen = np.interp(omega, *places(line))
        assert np.abs(np.minimum(seen, top) - np.minimum(exact, top)).max() < 0.002 * top


def test_an_unbounded_ratio_leaves_the_axes_and_says_where() -> None:
    ax = drawn(UNDAMPED, evaluation_charts.ratios)
    omega, ratio = places(curves(ax)[0])
    assert np.isnan(ratio[omega == 10]).all()
    assert ratio[np.isfinite(ratio)].max() > 1e6
    assert (ax.get_ylim()[0], ax.get_ylim()[1] < 5) == (0, True)
    assert "∞ at 10" in words(ax)


@pytest.mark.slow
def test_closed_forms_and_peaks_are_drawn_on_the_same_curves() -> None:
    for found, chart in ((hs.derive(PAPER), evaluation_charts.formulas), (hs.peaks(PAPER), evaluation_charts.peaks)):
        ax = axes()
        draw(ax, chart(found))
        omega, ratio = places(curves(ax)[0])
        exact = np.abs((paper_perc(omega) - paper_env(omega)).real) / np.abs(paper_env(omega))
        assert ratio == pytest.approx(exact, rel=1e-9, abs=1e-12)


@pytest.mark.slow
def test_an_axes_keeps_its_unit_of_frequency() -> None:
    ax = axes()
    draw(ax, evaluation_charts.ratios(hs.evaluate("steering-wheel")))
    [line, _] = draw(ax, evaluation_charts.ratios(evaluated(PAPER)))
    assert ax.get_xlabel() == "frequency (Hz)"
    assert np.max(line.get_xdata()) == pytest.approx(15 / (2 * np.pi))


def test_frequencies_are_in_hz_where_they_are_short_there_and_not_in_rad_per_s() -> None:
    for hertz in ([0.5, 12.5], [-3.0, 7.25], [0.0, 100.0]):
        assert unit_of(np.array([2 * np.pi * x for x in hertz])).name == "Hz"
        assert unit_of(np.array(hertz)).name == "rad/s"
        assert unit_of(np.array([2 * np.pi * hertz[0] or 0.0, 2 * np.pi * hertz[1] + 0.123456789])).name == "rad/s"
    assert unit_of(np.array([-np.sqrt(2), -np.sqrt(3)])).name == "rad/s"


# The curves in the complex plane.


def spots(ax: Axes) -> list[tuple[complex, str]]:
    found = [x for x in ax.lines if x.get_linestyle() == "None"]
    return [(complex(*points(x)[0]), str(x.get_marker())) for x in found]


def test_both_dynamics_are_traced_and_thirds_of_the_band_bear_the_same_marker() -> None:
    ax = drawn(PAPER, evaluation_charts.nyquist)
    (x, y), (u, v) = map(places, curves(ax))
    omega = y / 15
    assert (omega.min(), omega.max(), ax.get_aspect()) == (0, 15, 1)
    assert (x, u + 1j * v) == (pytest.approx(paper_env(omega).real), pytest.approx(paper_perc(omega)))
    seen = spots(ax)
    assert [len(seen), len({m for _, m in seen})] == [6, 3]
    for (one, mark), (other, same), at in zip(seen[::2], seen[1::2], (5.0, 10.0, 15.0), strict=True):
        assert (one, other, mark) == (pytest.approx(paper_env(at)), pytest.approx(paper_perc(at)), same)
        assert f"{at:g} rad/s" in told(ax)


@pytest.mark.dear("band3-marked_at3")
@pytest.mark.parametrize(
    ("band", "marked_at"),
    [
        ((0, 47), [16, 31, 47]), ((2, "9.96"), [4.7, 7.3, 9.9]), ((1000, 5000), [2300, 3700, 5000]),
        (("1 Hz", "7 Hz"), [3, 5, 7]),
    ],
)  # fmt: skip
def test_marks_are_thirds_of_the_band_as_short_numbers_in_its_unit(band: Any, marked_at: list[float]) -> None:
    """100 + 3 jω on both curves: upright lines along which the frequency is Im H/3."""
    ax = drawn(hs.Scene(STIFF, (), band), evaluation_charts.nyquist)
    unit, factor = ("Hz", 2 * np.pi) if "Hz" in str(band[1]) else ("rad/s", 1)
    assert [x.imag / 3 / factor for x, _ in spots(ax)[::2]] == pytest.approx(marked_at)
    assert told(ax)[3:] == [f"{x:g} {unit}" for x in marked_at]


def test_a_band_too_narrow_for_three_short_numbers_bears_no_mark_twice_and_none_below_it() -> None:
    ax = drawn(hs.Scene(STIFF, (), ("19.9", 20)), evaluation_charts.nyquist)
    at = [x.imag / 3 for x, _ in spots(ax)[::2]]
    assert at == sorted(set(at))
    assert (min(at) >= 19.9, max(at) <= 20 + 1e-9) == (True, True)
    assert len(told(ax)) == len(set(told(ax)))


def test_arrows_point_towards_higher_frequencies() -> None:
    """Of the paper's scene Im H grows and Re H falls throughout."""
    arrows = [x for x in drawn(PAPER, evaluation_charts.nyquist).texts if isinstance(x, Annotation)]
    assert len(arrows) == 4
    assert all(x.xy[1] > x.xyann[1] and x.xy[0] < x.xyann[0] for x in arrows)


@pytest.mark.dear("a pole at 10")
@pytest.mark.parametrize("scene", [RINGING, RINGING_AT_SQRT_50], ids=["a pole at 10", "a pole at no float"])
def test_a_pole_of_the_dynamics_breaks_the_curve_and_spares_the_axes(scene: hs.Scene) -> None:
    ax = drawn(scene, evaluation_charts.nyquist)
    _, (real, imag) = map(places, curves(ax))
    [gap] = np.flatnonzero(np.isnan(imag))
    assert (imag[gap - 1] > 1e6, imag[gap + 1] < -1e6) == (True, True)
    assert real[np.isfinite(real)] == pytest.approx(float(scene.environment.H.subs(hs.s, 0)))
    assert max(map(abs, (*ax.get_xlim(), *ax.get_ylim()))) < 2000
    (left, right), (bottom, top) = ax.get_xlim(), ax.get_ylim()
    assert all(left <= x.real <= right and bottom <= x.imag <= top for x, _ in spots(ax))


def test_a_dynamics_that_stays_in_one_spot_is_still_marked_within_the_axes() -> None:
    ax = drawn(STIFFENED, evaluation_charts.nyquist)
    assert {x for x, _ in spots(ax)} == {100, 120}
    assert ax.get_xlim()[0] < 100 < 120 < ax.get_xlim()[1]
    assert not [x for x in ax.texts if isinstance(x, Annotation)]


def test_a_frequency_marked_for_two_scenes_has_one_shape_and_one_entry() -> None:
    ax = axes()
    for label, texts in (("ideal", ("5 rad/s", "12 rad/s")), ("slow", ("12 rad/s", "30 rad/s"))):
        rows = [(words, np.zeros(2), np.ones(2)) for words in texts]
        draw(ax, Panel([evaluation_charts.Matched(rows, shared=True)]), label=label)
    shapes = [mark for _, mark in spots(ax)[::2]]
    assert (shapes[1] == shapes[2], len(set(shapes))) == (True, 3)
    assert told(ax).count("12 rad/s") == 1


# The projections.


@pytest.mark.parametrize("part", Part)
@pytest.mark.parametrize("scene", [replace(LAGGED, band=(0, 30), threshold=hs.Threshold.of("0.1", "0.3")), DISC], ids=["square", "disc"])  # fmt: skip
def test_curves_are_bold_where_a_part_is_told_alone_or_both_are_together(part: Part, scene: hs.Scene) -> None:
    """Of the disc a part has its share where it alone leaves it, and where neither alone does."""
    ax = axes()
    lines = draw(ax, evaluation_charts.projections(evaluated(scene), part))
    for group, dynamics in ((lines[:2], env), (lines[2:], perc)):
        for line in group:
            bold = line.get_linewidth() > 1
            omega, magnitude = shown(line)
            assert magnitude == pytest.approx(np.abs(getattr(dynamics(omega), part.value)), abs=1e-9)
            change = (perc(omega) - env(omega)) / np.abs(env(omega))
            x, y = (np.abs(change.real), np.abs(change.imag))[:: 1 if part is Part.REAL else -1]
            c = 0.1 if part is Part.REAL or scene is DISC else 0.3
            is_noticed = (np.hypot(x, y) > 0.1) & ((x > 0.1) | (y <= 0.1)) if scene is DISC else x > c
            edges = [np.hypot(x, y) - 0.1, x - 0.1, y - 0.1] if scene is DISC else [x - c]
            sure = np.min(np.abs(edges), axis=0) > 1e-9
            assert (is_noticed[sure] == bold).all()
        seen = np.concatenate([shown(line)[0] for line in group])
        assert (seen.min(), seen.max(), len(seen) > 200) == (0, 30, True)


@pytest.mark.parametrize("part", Part)
def test_a_part_whose_sign_the_magnitude_hides_is_dotted_and_the_legend_says_so(part: Part) -> None:
    """Im H_perc = (3 ω - 5 ω)/(1 + ω²/400) is negative throughout; Re H_perc = (100 + 3 ω²/20)/... never is."""
    ax = axes()
    lines = draw(ax, evaluation_charts.projections(evaluated(LAGGED), part))
    if part is Part.REAL:
        assert len(lines) == 4
        assert not any("opposite" in x for x in told(ax))
        return
    assert len(lines) == 6
    magnitudes = [shown(x)[1] for x in lines[2:]]
    top = ax.get_ylim()[1]
    assert [len(x) > 0 for x in magnitudes] == [False, True, True, True]
    assert max(magnitudes[2]) <= 0.02 * top <= min(np.concatenate(magnitudes[1::2]))
    assert sum("of the opposite sign" in x for x in told(ax)) == 1


@pytest.mark.parametrize("part", Part)
def test_the_ground_is_grey_where_nothing_is_noticed_and_what_is_felt_is_said(part: Part) -> None:
    ax, e = drawn(PAPER, evaluation_charts.projections, part), evaluated(PAPER)
    [percept] = [x for x in e.percepts if x.part is part]
    assert spans(ax.patches) == [(0, pytest.approx(float(percept.band.low.omega)))]
    assert felt(percept) in words(ax)
    name = "Re" if part is Part.REAL else "Im"
    assert (ax.get_xlabel(), ax.get_ylabel()) == (r"$\omega$ (rad/s)", rf"$|\mathrm{{{name}}}\,H|$ (N/m)")


def test_words_stand_in_the_middle_of_their_band_or_are_numbered_there() -> None:
    ax = drawn(UNDAMPED, evaluation_charts.projections, Part.REAL)
    below, between, over = np.sqrt([50, 1000 / 11, 200 / 2.1])
    assert spans(ax.patches) == [(0, pytest.approx(below))]
    assert [places(x)[0][0] for x in ax.lines if len(x.get_xdata()) == 2] == pytest.approx([below, between, over, 10])
    middles = {
        "lower stiffness": (below + between) / 2, "1": (between + over) / 2, "2": (over + 10) / 2, "higher mass": 12.5,
    }  # fmt: skip
    at = {x.get_text().replace("\n", " "): x.xy[0] * 15 for x in ax.texts if isinstance(x, Annotation)}
    middles["not noticed"] = below / 2
    assert {k: at[k] for k in set(at) - set(at_curves(ax))} == {k: pytest.approx(v) for k, v in middles.items()}
    assert told(ax)[1:] == [f"mass instead of stiffness, with {x} force" for x in ("lower", "higher")]


@pytest.mark.dear("active", "taken away")
@pytest.mark.parametrize(
    ("scene", "part", "word"),
    [
        (IDENTITY, Part.REAL, "never exceeds the threshold"), (UNDAMPED, Part.IMAG, "never exceeds the threshold"),
        (hs.Scene(mass_spring_damper(k=100), (shunt(k=10),)), Part.REAL, "never exceeds the threshold"),
        (hs.Scene(mass_spring_damper(1, 5, 100), (shunt(b=-8),)), Part.IMAG, "noticed (active)"),
        (DISC, Part.IMAG, "noticed (active)"),
        (hs.Scene(mass_spring_damper(k=100, b=12), (shunt(b=-12),), (0, 14), ELLIPSE), Part.IMAG, "lower damping"),
    ],
    ids=["identity", "no damping", "just the threshold", "active", "active in a disc", "taken away"],
)  # fmt: skip
def test_what_is_never_noticed_or_has_no_name_is_said_to_be_so(scene: hs.Scene, part: Part, word: str) -> None:
    ax = drawn(scene, evaluation_charts.projections, part)
    said = {x.get_text().replace("\n", " ") for x in ax.texts} - {*at_curves(ax), "not noticed"}
    assert said == {word}
    assert len(at_curves(ax)) == 2
    assert (spans(ax.patches) == [(0, 15)]) == ("never" in word)


def test_in_hertz_curves_bands_and_words_are_in_hertz() -> None:
    ax, turn = axes(), 2 * np.pi
    scene = replace(UNDAMPED, band=("0 Hz", f"{15 / turn:.17g} Hz"))
    lines = draw(ax, evaluation_charts.projections(evaluated(scene), Part.REAL))
    assert spans(ax.patches) == [(0, pytest.approx(np.sqrt(50) / turn))]
    assert (ax.get_xlim(), ax.get_xlabel()) == ((0, pytest.approx(15 / turn)), "frequency (Hz)")
    at, values = shown(lines[2])
    assert values == pytest.approx(np.abs(100 - 1.1 * (turn * at) ** 2))


def test_a_further_scene_has_bars_for_its_bands_and_no_words_of_its_own() -> None:
    ax = drawn(PAPER, evaluation_charts.projections, Part.REAL)
    before = {x.get_text() for x in ax.texts}
    draw(ax, evaluation_charts.projections(evaluated(UNDAMPED), Part.REAL), label="stiff")
    # A long name may stand in two lines.
    after = {" ".join(x.get_text().replace("\n,", ",").split()) for x in ax.texts}
    assert after == before | {f"{x}, stiff" for x in before if "H_" in x}
    [bar] = [x for x in ax.lines if x.get_label() == "not noticed, stiff"]
    assert places(bar)[0].tolist() == [0, pytest.approx(np.sqrt(50))]


# The JND square.

MASS = hs.Scene(mass_spring_damper(m=1, k=100, b=4), (shunt(m="0.5"),), (0, 30), hs.Threshold.of("0.1", "0.3"))
"""100 - ω² + 4 jω, and half a kilogram more: at 8 rad/s the tip is 36 + 32 j, of the size √2320."""


def test_the_square_reaches_from_the_tip_as_far_as_each_threshold_lets_and_arrows_end_at_both_tips() -> None:
    ax = axes()
    [region] = draw(ax, evaluation_charts.square(evaluated(MASS), 8))
    size = np.hypot(36, 32)
    assert isinstance(region, Rectangle)
    assert region.get_center() == pytest.approx((36, 32))
    assert (region.get_width(), region.get_height()) == pytest.approx((0.2 * size, 0.6 * size))
    shafts = [x for x in ax.texts if isinstance(x, Annotation) and x.xyann == (0, 0)]
    assert [x.xy for x in shafts] == [pytest.approx((36, 32)), pytest.approx((4, 32))]
    across, up = (points(x) for x in ax.lines if x.get_label() == "not noticed in one part" or x.get_linewidth() == 3)
    assert np.array(across) == pytest.approx(np.array([(36 - 0.1 * size, 0), (36 + 0.1 * size, 0)]))
    assert np.array(up) == pytest.approx(np.array([(0, 32 - 0.3 * size), (0, 32 + 0.3 * size)]))
    (left, right), (bottom, top) = ax.get_xlim(), ax.get_ylim()
    assert (left < 0, right > 36 + 0.1 * size, bottom < 0, top > 32 + 0.3 * size, ax.get_aspect()) == (*[True] * 4, 1)


def test_a_disc_is_drawn_as_one_and_limits_for_each_way_as_a_patch_for_each_stretch() -> None:
    ax = axes()
    region, *_ = draw(ax, evaluation_charts.square(evaluated(DISC), 5))
    assert isinstance(region, Polygon)
    border: Any = region.get_xy()
    assert np.abs(border @ [1, 1j] - env(5)) == pytest.approx(np.full(len(border), 0.1 * abs(env(5))))
    jnd = {"real": {"higher": "1.2", "lower": "0.1"}, "imag": "0.1"}
    ax = drawn(hs.Scene(mass_spring_damper(1, 4, 100), (), (0, 30), jnd), evaluation_charts.square, 9)
    size = np.hypot(19, 36)
    expected = [(19 - 1.2 * size, -19), (19 - 0.1 * size, 19 + 1.2 * size)]
    assert np.array(spans(x for x in ax.patches if isinstance(x, Rectangle))) == pytest.approx(np.array(expected))


@pytest.mark.parametrize(
    ("scene", "omega", "said"),
    [
        (PAPER, 5.0, "not noticed"), (PAPER, 10.0, "noticed in the real part"), (PAPER, 13.0, "noticed in both parts"),
        (replace(LAGGED, band=(0, 30)), 5, "noticed in the imaginary part"), (DISC, 5, "outside the ellipse"),
        (DISC, 1, "not noticed"), (MASS, 0, "not noticed"), (STIFFENED, 5, "noticed in the real part"),
        (hs.Scene(mass_spring_damper(k=100), (shunt(k=10),)), 5, "not noticed"),
    ],
)  # fmt: skip
def test_the_title_says_the_frequency_and_what_is_noticed(scene: hs.Scene, omega: float, said: str) -> None:
    assert drawn(scene, evaluation_charts.square, omega).get_title() == rf"$\omega$ = {omega:g} rad/s: {said}"


def test_at_the_very_crossing_nothing_is_noticed_yet() -> None:
    first = float(evaluated(PAPER).crossings[0].omega)
    assert drawn(PAPER, evaluation_charts.square, first).get_title().endswith(": not noticed")


def test_where_nothing_is_felt_there_is_a_spot_at_the_origin() -> None:
    damper = hs.Scene(mass_spring_damper(b=2), (first_order_lag(20),), (0, 15), "0.1")
    ax = drawn(damper, evaluation_charts.square, 0)
    assert [points(x) for x in marked(ax, "o")] == [[(0, 0)], [(0, 0)]]


def test_a_frequency_off_the_band_or_at_a_pole_has_no_square() -> None:
    with pytest.raises(hs.SceneError, match=r"15\.1 rad/s is not on the band, 0 to 15"):
        draw(axes(), evaluation_charts.square(evaluated(PAPER), 15.1))
    with pytest.raises(hs.SceneError, match="infinite at 10 rad/s"):
        draw(axes(), evaluation_charts.square(evaluated(RINGING), 10.0))


@pytest.mark.slow
def test_units_are_those_of_the_motion_and_large_numbers_are_told_in_thousands() -> None:
    for scene, unit in ((ROTATION, "(N·m/rad)"), (PAPER, "(N/m)"), (PAPER.with_band(1000, 5000), "(kN/m)")):
        for chart, *more in (
            (evaluation_charts.nyquist,),
            (evaluation_charts.projections, Part.REAL),
            (evaluation_charts.square, float(scene.band[1])),
        ):
            assert any(unit in x for x in words(drawn(scene, chart, *more))), (unit, chart)
    ax = drawn(PAPER.with_band(1000, 5000), evaluation_charts.projections, Part.REAL)
    assert ax.yaxis.get_major_formatter()(2.0e7) == "20000"
    assert ax.get_ylim()[1] > 1.8 * 5000**2


# Regions.


@pytest.mark.parametrize(
    ("jnd", "reach"),
    [
        ({"shape": "ellipse", "real": "0.1", "imag": "0.2"}, (0.1, 0.2)),
        ({"shape": "ellipse", "real": "0.1", "imag": "0.2", "tilt": "0.6"}, (0.1, 0.2)),
        ({"shape": "diamond", "real": "0.1", "imag": "0.2"}, (0.1, 0.2)),
        ({"real": "0.1", "imag": "0.2"}, (0.1, 0.2)),
    ],
)
def test_the_outline_of_a_region_is_where_a_change_is_just_noticed(jnd: Any, reach: Any) -> None:
    """About the tip of H_env, of size 5; an ellipse reaches a and b whatever its tilt is."""
    tip = np.array([3.0, 4.0])
    found = outline(noticed(hs.Scene(STIFF, (), (0, 15), jnd).threshold), tip, 2.0)
    [patch] = found.patches
    vertices = patch.get_path().vertices if isinstance(patch, Polygon) else patch.get_corners()  # type: ignore[attr-defined]
    assert np.abs((np.asarray(vertices) - tip) / 5).max(axis=0) == pytest.approx(reach, rel=1e-4)
    narrow = (1 - 0.36) ** 0.5 if jnd.get("tilt") else 1  # along an axis, a tilted one is narrower
    for own, [(low, high)], r in zip(tip, found.stretches, reach, strict=True):
        assert (own - low, high - own) == pytest.approx((5 * r * narrow,) * 2, rel=1e-3)


def test_the_outline_of_a_polygon_goes_through_its_corners() -> None:
    corners = ((0.1, 0), (0, 0.3), (-0.2, 0), (0, -0.1))
    jnd = {"shape": "polygon", "corners": [[str(x) for x in c] for c in corners]}
    tip = np.array([3.0, 4.0])
    found = outline(noticed(hs.Scene(STIFF, (), (0, 15), jnd).threshold), tip, 2.0)
    offset = (found.patches[0].get_path().vertices - tip) / 5
    assert all(np.hypot(*(offset - c).T).min() < 1e-9 for c in corners)
    assert found.stretches == (((pytest.approx(2.0), pytest.approx(3.5)),), ((pytest.approx(3.5), pytest.approx(5.5)),))


def test_limits_for_each_way_bound_what_grows_and_what_shrinks() -> None:
    for tip in ((30.0, 40.0), (-30.0, -40.0), (-24.0, 7.0)):
        for higher, lower in ((0.4, 0.1), (0.1, 0.4), (1.9, 1.5)):
            way = {"higher": str(higher), "lower": str(lower)}
            criteria = noticed(hs.Scene(STIFF, (), (0, 15), {"real": way, "imag": way}).threshold)
            for own, stretches in zip(tip, outline(criteria, np.array(tip), 1.0).stretches, strict=True):
                values = np.linspace(-200, 200, 4001) + 1e-3  # no end lies on one
                limit = np.where(np.abs(values) > abs(own), higher, lower) * np.hypot(*tip)
                inside = np.any([(values > low) & (values < high) for low, high in stretches], axis=0)
                assert (inside == (np.abs(values - own) < limit)).all()


def test_regions_are_drawn_about_the_origin_as_large_as_they_are_and_crossings_on_the_way() -> None:
    """The scene's region, a square, is drawn once."""
    found = hs.evaluate(replace(LAGGED, threshold=hs.Threshold.of("0.1", "0.2")), regions=True)
    shown, ax = found.regions[:-1], axes()
    [line] = draw(ax, evaluation_charts.regions(found))
    w = np.linspace(0, 15, 200)
    way = (perc(w) - env(w)) / np.abs(env(w))
    seen = places(line)[0] + 1j * places(line)[1]
    assert np.abs(seen[:, None] - way[None, :]).min(axis=0).max() < 5e-3
    inverse = ax.transData.inverted()
    for patch, x in zip(ax.patches, shown, strict=True):
        corners = inverse.transform(patch.get_transform().transform(patch.get_path().vertices))
        assert np.abs(corners).max(axis=0) == pytest.approx([0.1, 0.2], rel=1e-3), x.name
    at = np.array([float(x.crossing.omega) for x in shown if x.crossing])
    exact = (perc(at) - env(at)) / np.abs(env(at))
    assert np.array([complex(*points(x)[0]) for x in marked(ax, "o")]) == pytest.approx(exact, rel=1e-9)
    assert told(ax) == [r"$\Delta H$ over the band", *(x.name for x in shown)]


def test_a_bandwidth_grows_with_its_threshold_as_the_larger_ratio_does() -> None:
    """A spring of 100 N/m felt with 2 N s/m beside it: r_i = 2 w/100, without a jump."""
    ax = axes()
    [line] = draw(
        ax,
        evaluation_charts.bandwidths(
            hs.evaluate(hs.Scene(mass_spring_damper(k=100), (shunt(b=2),), (0, 15), "0.1 +- 50 %"))
        ),
    )
    c, omega = places(line)
    assert omega == pytest.approx(c / 2)
    assert (c[0], c[-1]) == pytest.approx((5, 15))
    assert [points(x) for x in marked(ax, "s")] == [[pytest.approx((10, 5))]]
    assert [points(x) for x in marked(ax, "o")] == [[pytest.approx((5, 2.5)), pytest.approx((15, 7.5))]]
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("threshold $c$ (%)", "bandwidth (rad/s)")


# Several environments.

SPRINGS = {"heavy": (2, 100), "stiff": (0, 400), "wall": (0, 10_000)}
"""In kg and N/m. 0.1 ω² is a tenth of ``|100 - 2 ω²|`` at √(100/3) and 10 rad/s, and of 400 at 20."""
PAIR = hs.Threshold.of("0.1", "0.3")
ENDS = (np.sqrt(100 / 3), 10, 20)


@cache
def family(*names: str, band: Any = (0, 30), k: Any = 0, regions: bool = False) -> hs.FamilyEvaluation:
    scenes = {
        name: hs.Scene(mass_spring_damper(SPRINGS[name][0], 0, SPRINGS[name][1]), (shunt(m="0.1", k=k),), band, PAIR)
        for name in names or SPRINGS
    }
    return hs.evaluate_all(hs.SceneFamily(scenes), regions=regions)


def ratio(name: str, omega: Any) -> Any:
    m, k = SPRINGS[name]
    with np.errstate(divide="ignore", invalid="ignore"):
        return 0.1 * omega**2 / np.abs(k - m * omega**2)


def test_each_environment_has_its_ratio_and_one_line_is_the_largest_of_them() -> None:
    """The heavy one rings at √50 rad/s: its line has a gap there, and the largest is infinite."""
    ax = axes()
    lines = [x for x in draw(ax, family_charts.worst(family())) if x.get_marker() != "o"]
    omega = places(lines[0])[0]
    exact = np.stack([ratio(name, omega) for name in SPRINGS])
    for line, values in zip(lines, exact, strict=True):
        x, y = shown(line)
        assert len(x) >= len(omega) - 1
        assert y == pytest.approx(values[np.isfinite(places(line)[1])], rel=1e-9)
    [largest] = [x for x in curves(ax) if x not in lines]
    y = places(largest)[1]
    assert y[np.isfinite(y)] == pytest.approx(exact.max(axis=0)[np.isfinite(y)], rel=1e-9)
    [gap] = np.flatnonzero(np.isnan(places(lines[0])[1]))
    assert (omega[gap], y[gap]) == (pytest.approx(np.sqrt(50)), np.inf)
    assert all(np.abs(omega - end).min() < 1e-12 for end in ENDS)
    assert told(ax) == ["largest", "others", "threshold", "all transparent"]
    on_their_curves = {name: float(ratio(name, x)) == pytest.approx(y) for name, (x, y) in at_curves(ax).items()}
    assert on_their_curves == {"heavy": True, "stiff": True}


def test_dots_stand_where_one_binds_and_the_ground_is_grey_where_none_is_noticed() -> None:
    ax = axes()
    draw(ax, family_charts.worst(family()))
    assert [points(x)[0] for x in marked(ax, "o")] == [(pytest.approx(x), 0.1) for x in ENDS]
    assert np.array(spans(ax.patches)) == pytest.approx(np.array([(0, ENDS[0]), (10, 20)]))
    assert (ax.get_xlabel(), ax.get_ylabel()) == (r"$\omega$ (rad/s)", r"$r_\mathrm{r}$")
    other = axes()
    imag = draw(other, family_charts.worst(family(), 1))  # without damping r_i is 0
    assert (marked(other, "o"), other.get_ylabel()) == ([], r"$r_\mathrm{i}$")
    assert all(np.nanmax(places(x)[1]) == 0 for x in imag)
    [level] = [x for x in other.lines if len(x.get_xdata()) == 2]
    assert places(level)[1].tolist() == [0.3, 0.3]


def test_where_none_is_transparent_the_legend_tells_of_no_ground() -> None:
    ax, springs = axes(), family("stiff", "wall", k=5000, band=(1, 9))
    draw(ax, family_charts.worst(springs))
    assert springs.transparent == ()
    assert "all transparent" not in told(ax)
    assert not ax.patches


@pytest.mark.slow
@pytest.mark.parametrize(
    ("names", "band", "ends"),
    [
        pytest.param((), (0, 30), ["5.774", "10.00", "20.00"], marks=pytest.mark.slow),
        (("stiff",), ("0 Hz", "4 Hz"), ["3.183"]),
    ],
)
def test_the_ends_of_several_environments_stand_above_their_sheet_in_its_unit(names: Any, band: Any, ends: Any) -> None:
    top = worst_case(family(*names, band=band)).axes[0]
    assert [x.get_text() for x in top.texts if x.get_text() not in at_curves(top)] == ends
    assert set(at_curves(top)) <= set(SPRINGS)


def test_bandwidths_of_several_environments_by_each_region_stand_in_rows() -> None:
    found, ax = family("stiff", "wall", regions=True), axes()
    marks = draw(ax, family_charts.regions(found))
    assert [x.get_text() for x in ax.get_yticklabels()] == ["stiff", "wall", "all together"]
    for mark, x in zip(marks, found.regions[:-1], strict=True):
        widths = [x.answers["stiff"].bandwidth, x.answers["wall"].bandwidth, x.bandwidth]
        assert places(mark)[0] == pytest.approx([float(w) if w else np.nan for w in widths], nan_ok=True)
        assert np.abs(places(mark)[1] - np.arange(3)).max() < 0.5
        assert mark.get_label() == x.name
    assert ax.get_xlabel() == "bandwidth (rad/s)"


# Measured lines.

OMEGA = np.arange(1.0, 15.0)
CHANGE, RADIUS = (perc(OMEGA) - env(OMEGA)) / np.abs(env(OMEGA)), 4 / np.abs(env(OMEGA))


def lines(threshold: Any, **more: Any) -> hs.MeasuredEvaluation:
    found = hs.measured(OMEGA, perc(OMEGA), radius=[4.0] * len(OMEGA), **more)
    return hs.evaluate(hs.MeasuredScene(STIFF, found, threshold=threshold))


@pytest.mark.parametrize("slope", [None, "20 N*s/m"])
def test_measured_ratios_have_bars_as_far_as_their_discs_reach(slope: str | None) -> None:
    ax = axes()
    dots = draw(ax, measured_charts.ratios(lines(hs.Threshold.of("0.1", "0.2"), **({"slope": slope} if slope else {}))))
    bars = [c for c in ax.collections if isinstance(c, LineCollection)]
    for part, c, mark, bar in ((CHANGE.real, 0.1, "o", bars[0]), (CHANGE.imag, 0.2, "s", bars[1])):
        own, resolved = np.abs(part), np.abs(np.abs(part) - c) > RADIUS
        told_, open_ = [x for x in dots if x.get_marker() == mark]
        assert (places(told_)[0].tolist(), places(open_)[0].tolist()) == (
            OMEGA[resolved].tolist(),
            OMEGA[~resolved].tolist(),
        )
        assert (places(told_)[1], places(open_)[1]) == (pytest.approx(own[resolved]), pytest.approx(own[~resolved]))
        ends = np.array([x[:, 1] for x in bar.get_segments()])
        assert ends[:, 0] == pytest.approx(np.maximum(own - RADIUS, 0))
        assert (np.isclose(ends[:, 1], own + RADIUS) | (ends[:, 1] > ax.get_ylim()[1])).all()
    assert ("swept discs" in told(ax), "95 % disc" in told(ax)) == (bool(slope), True)


@pytest.mark.parametrize("jnd", ["0.1", {"real": "0.15 + 0.01*omega", "imag": "0.1"}])
def test_measured_displays_are_compared_with_their_threshold_and_all_points_are_whole(jnd: Any) -> None:
    """A ratio, or a multiple of its threshold where that is a formula in omega."""
    felt = lines(hs.Scene(STIFF, (), (0, 15), jnd).threshold)
    limit = 0.1 if jnd == "0.1" else 0.15 + 0.01 * OMEGA
    for which, change, c in ((0, CHANGE.real, limit), (1, CHANGE.imag, 0.1)):
        ax, is_share = axes(), not np.isscalar(c)
        draw(ax, compare_charts.ratios(hs.compare(felt, felt), which))
        one, other, threshold = ax.lines
        for x in (one, other):
            assert places(x)[1] == pytest.approx(np.abs(change) / (c if is_share else 1))
            assert not x.get_clip_on()
            assert places(x)[1].max() < ax.get_ylim()[1]
        assert set(places(threshold)[1]) == {1.0 if is_share else c}
        assert ax.get_ylabel().startswith((r"$r_\mathrm{r}", r"$r_\mathrm{i}")[which])


def test_measured_lines_stand_in_the_plane_by_what_they_tell() -> None:
    e, ax = lines(hs.Threshold.of("0.1", "0.2")), axes()
    curve, *dots = draw(ax, measured_charts.nyquist(e))
    x, y = places(curve)
    assert x + 1j * y == pytest.approx(env(y / 3))
    excess = np.stack([np.abs(CHANGE.real) - 0.1, np.abs(CHANGE.imag) - 0.2])
    above, below = (excess > RADIUS).any(axis=0), (excess < -RADIUS).all(axis=0)
    kinds = {"exceeds in a part": above, "unresolved": ~above & ~below, "below in both parts": below}
    wanted = {k: v for k, v in kinds.items() if v.any()}
    names = told(ax)
    assert names[: 2 + len(wanted)] == [r"$H_\mathrm{env}$", *wanted, "95 % disc"]
    at = [float(x.partition(" ")[0]) for x in names[2 + len(wanted) :]]  # bear the same mark on both curves
    assert (len(at), set(at) <= set(OMEGA.tolist())) == (3, True)
    discs = [c for c in ax.collections if isinstance(c, PatchCollection)]
    for line, disc, which in zip(dots, discs, wanted.values(), strict=True):
        own = perc(OMEGA[which])
        assert places(line)[0] + 1j * places(line)[1] == pytest.approx(own)
        extents = np.array([p.get_extents().extents for p in disc.get_paths()])
        box = np.stack([own.real - 4, own.imag - 4, own.real + 4, own.imag + 4], axis=1)
        assert extents == pytest.approx(box, abs=1e-3)


@pytest.mark.slow
def test_changes_of_measured_lines_stand_about_the_border_of_a_region() -> None:
    jnd = {"shape": "ellipse", "real": "0.2", "imag": "0.3"}
    ax = axes()
    dots = draw(ax, measured_charts.measured_plane(lines(hs.Scene(STIFF, (), (0, 15), jnd).threshold)))
    seen = np.concatenate([places(x)[0] + 1j * places(x)[1] for x in dots])
    assert np.sort_complex(seen) == pytest.approx(np.sort_complex(CHANGE))
    for line in dots:
        far = np.hypot(places(line)[0] / 0.2, places(line)[1] / 0.3)
        assert {pen.RED: far.min() > 1, pen.BLUE: far.max() < 1, pen.GREY: True}[to_hex(line.get_color())]
    border = [p.vertices for c in ax.collections for p in c.get_paths() if len(p.vertices) > 200]
    assert np.hypot(border[0][:, 0] / 0.2, border[0][:, 1] / 0.3) == pytest.approx(1, abs=1e-3)


# Measures.


@pytest.mark.slow
def test_measures_are_the_two_ratios_the_whole_change_and_that_of_the_size() -> None:
    ax = axes()
    four = draw(ax, effect_charts.measures(hs.metrics(LAGGED)))
    omega = places(four[0])[0]
    change = (perc(omega) - env(omega)) / np.abs(env(omega))
    expected = (np.abs(change.real), np.abs(change.imag), np.abs(change), np.abs(np.abs(perc(omega) / env(omega)) - 1))
    assert [places(x)[1] for x in four] == [pytest.approx(x, abs=1e-12) for x in expected]
    assert [x.get_label() for x in four[2:]] == [r"$|\Delta H/H_\mathrm{env}|$", r"$||\Gamma| - 1|$"]
    assert told(ax)[-1] == "$c = 0.1$"


@pytest.mark.slow
def test_verdicts_are_bars_where_they_hold_one_row_for_each() -> None:
    m, ax = hs.metrics("fu2019"), axes()
    made, rows = draw(ax, effect_charts.verdicts(m)), verdict_bands(m)
    assert [x.get_text() for x in ax.get_yticklabels()] == [name for name, _ in rows]
    ends = [[(low, i), (high, i)] for i, (_, found) in enumerate(rows) for low, high in found]
    assert [points(x) for x in made] == [[pytest.approx(a), pytest.approx(b)] for a, b in ends]


# What each effect changes.

THREE = (first_order_lag(20), shunt(m="0.1"), shunt(k="0.01"))


@cache
def effects(*given: Any, tolerance: Any = "0.01") -> hs.Relevance:
    return hs.relevance(hs.Scene(STIFF, given or THREE, (0, 16), "0.1"), tolerance)


def part_of(omega: Any, part: Part, *, lag: bool = True, m: float = 0.1, k: float = 0.01) -> Any:
    """The ratio of 100 + 3 jω behind a lag, and a mass and a spring in the hand."""
    changed = env(omega) / (1 + 1j * omega / 20 * lag) - m * omega**2 + k
    return np.abs(getattr((changed - env(omega)) / np.abs(env(omega)), part.value))


def influences(ax: Axes, found: hs.Relevance, part: Part) -> list[Line2D]:
    """The curves of the effects, without the line of the tolerance."""
    made = [x for x in draw(ax, effect_charts.influences(found, part)) if isinstance(x, Line2D)]
    return [x for x in made if len(set(x.get_ydata())) != 1]


@pytest.mark.slow
@pytest.mark.parametrize("part", Part)
def test_each_curve_is_how_far_a_ratio_moves_when_that_effect_is_left_out(part: Part) -> None:
    ax = axes()
    without: tuple[dict[str, Any], ...] = ({"lag": False}, {"m": 0.0}, {"k": 0.0})
    for line, own in zip(influences(ax, effects(), part), without, strict=True):
        omega, values = places(line)
        exact, seen = np.abs(part_of(omega, part) - part_of(omega, part, **own)), np.isfinite(values)
        assert values[seen] == pytest.approx(exact[seen], rel=1e-9, abs=1e-14)
        assert (exact[~seen] < ax.get_ylim()[0]).all()
    assert any(places(x)[1].tolist() == [0.01, 0.01] for x in ax.lines)
    symbol = {Part.REAL: "r", Part.IMAG: "i"}[part]
    assert (ax.get_ylabel(), ax.get_xlabel()) == (rf"change of $r_\mathrm{{{symbol}}}$", r"$\omega$ (rad/s)")


@pytest.mark.slow
def test_names_stand_beside_the_ends_of_their_curves_and_what_matters_is_dark() -> None:
    ax = axes()
    made = influences(ax, effects(), Part.REAL)
    assert [x.kept for x in effects().effects] == [True, True, False]
    assert [to_hex(x.get_color()) for x in made] == [pen.INK, pen.INK, pen.GREY]
    names = {x.get_text(): x for x in ax.texts if isinstance(x, Annotation)}
    assert set(names) == {"first-order-lag", "shunt", "shunt-2", "tolerance"}
    assert names["first-order-lag"].xy == (1, pytest.approx(places(made[0])[1][-1]))
    ax.figure.draw_without_rendering()
    boxes = sorted((Text.get_window_extent(x) for x in names.values()), key=lambda box: box.y0)
    assert all(a.y1 <= b.y0 + 1 for a, b in pairwise(boxes))


@pytest.mark.slow
def test_a_part_that_nothing_changes_is_an_empty_chart() -> None:
    """A spring alone leaves the imaginary part as it is; with a tolerance of 0 nothing at all is above 0."""
    alone = hs.relevance(hs.Scene(mass_spring_damper(k=100), (shunt(k=1),), (0, 15), "0.1"), 0)
    [line] = influences(axes(), alone, Part.IMAG)
    assert not len(shown(line)[0])
    bare = hs.relevance(hs.Scene(mass_spring_damper(k=100), (), (0, 15), "0.1"))
    assert influences(axes(), bare, Part.REAL) == []
    with pytest.raises(hs.SceneError, match="no effects to draw"):
        effect_charts.relevance(bare)


def test_the_strip_has_each_piece_under_the_effect_that_changes_most_there() -> None:
    """The lag against a mass of 0.4 kg: by the changes of both ratios."""
    ax, e = axes(), effects(first_order_lag(20), shunt(m="0.4"))
    ends = spans(draw(ax, effect_charts.dominance(e)))
    assert ends == [(float(x.low), float(x.high)) for x in e.dominance]
    assert len({x.effect.name for x in e.dominance}) == 2
    for (low, high), x in zip(ends, e.dominance, strict=True):
        omega = np.linspace(low, high, 12)[1:-1]
        both = [part_of(omega, p, m=0.4, k=0) for p in Part]
        lag = np.max([np.abs(b - part_of(omega, p, lag=False, m=0.4, k=0)) for b, p in zip(both, Part, strict=True)], 0)
        mass = np.max([np.abs(b - part_of(omega, p, m=0, k=0)) for b, p in zip(both, Part, strict=True)], 0)
        assert ((lag > mass) == (x.effect.name == "first-order-lag")).all()


@pytest.mark.slow
def test_over_each_piece_of_the_band_stands_the_effect_that_dominates_it() -> None:
    """By its name where there is room, else by a number that the title explains."""
    found, ax = hs.relevance("control-stick-in-detail"), axes()
    assert len(draw(ax, effect_charts.dominance(found))) == len(found.dominance)
    for x in found.dominance:
        [name] = [t.get_text() for t in ax.texts if float(x.low) < t.get_position()[0] < float(x.high)]
        assert name in ("", x.effect.name) or f"{name} {x.effect.name}" in ax.get_title(loc="left")
