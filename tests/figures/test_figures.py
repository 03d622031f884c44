"""What the figures show is what the evaluation proves, and drawing it changes nothing else."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Callable
from itertools import combinations
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.text import Annotation, Text
from sympy import Integer

import haptisym as hs
from haptisym import Part
from haptisym.effects import first_order_lag, second_order_lowpass, series, shunt
from haptisym.environments import mass_spring_damper
from haptisym.figures.effects import draw_dominance
from haptisym.figures.files import save_figures
from haptisym.figures.hardcosts import draw_table
from haptisym.figures.nyquist import draw_nyquist
from haptisym.figures.projections import draw_projections
from haptisym.figures.ratios import draw_ratios
from haptisym.figures.release import draw_release
from haptisym.figures.square import draw_jnd_square
from haptisym.figures.sweep import swept_figure
from haptisym.judge.percepts import felt
from haptisym.verbs.cost.measurement import HardRow
from haptisym.verbs.sweep.swept import Swept

PAPER = hs.Scene(mass_spring_damper("1.8 kg", "15 N*s/m", "100 N/m"), (second_order_lowpass("80 rad/s", "0.5"),))
UNDAMPED = hs.Scene(mass_spring_damper(m=1, k=100), (shunt(m="0.1"),))
LIGHTLY_DAMPED = hs.Scene(mass_spring_damper(1, "0.002", 100), (shunt(m="0.1"),))
IDENTITY = hs.Scene(mass_spring_damper(1, 5, 100))
MASS = hs.Scene(mass_spring_damper(m=2), (first_order_lag(20),))
NOTCH = hs.Scene(mass_spring_damper(1, 5, 100), (series("(s^2 + 0.01*s + 49)/(s^2 + 0.2*s + 49)"),))
RINGING = hs.Scene(mass_spring_damper(1, 5, 100), (second_order_lowpass(10, 0),))
RINGING_AT_SQRT_50 = hs.Scene(mass_spring_damper(1, 5, 50), (series("50/(s^2 + 50)"),))
ACTIVE = hs.Scene(mass_spring_damper(1, 5, 100), (shunt(b=-8),))
STIFFENED = hs.Scene(mass_spring_damper(k=100), (shunt(k=20),))
ROTATION = hs.Scene(
    mass_spring_damper("0.01 kg*m^2", "0.2 N*m*s/rad", "3 N*m/rad"),
    (shunt(m="0.002 kg*m^2"),),
    (Integer(3), Integer(30)),
    hs.Threshold.of("0.05", "0.2"),
)
SCENES = {
    "paper": PAPER,
    "paper to 200 rad/s": PAPER.with_band(0, 200),
    "undamped": UNDAMPED,
    "lightly damped": LIGHTLY_DAMPED,
    "identity": IDENTITY,
    "mass": MASS,
    "notch": NOTCH,
    "ringing": RINGING,
    "active": ACTIVE,
    "stiffened": STIFFENED,
    "rotation": ROTATION,
    "far above": PAPER.with_band(1000, 5000),
}
FIGURES: dict[str, Callable[[Axes, hs.Evaluation], None]] = {
    "ratios": draw_ratios,
    "nyquist": draw_nyquist,
    "projections-real": lambda ax, result: draw_projections(ax, result, Part.REAL),
    "projections-imag": lambda ax, result: draw_projections(ax, result, Part.IMAG),
    "jnd-square": lambda ax, result: draw_jnd_square(ax, result, sum(result.to_dict()["band"]) / 2),
}
NAMES = list(FIGURES)


def drawn(scene: hs.Scene, draw: Callable[[Axes, hs.Evaluation], None]) -> tuple[Axes, hs.Evaluation]:
    result = hs.evaluate(scene)
    ax = Figure(figsize=(3.4, 3.0), layout="compressed").add_subplot()
    draw(ax, result)
    return ax, result


def curves(ax: Axes) -> list[Line2D]:
    """The sampled lines, not the straight ones."""
    return [line for line in ax.lines if len(line.get_xdata()) > 100]


def values(line: Line2D) -> tuple[np.ndarray, np.ndarray]:
    return np.asarray(line.get_xdata()), np.asarray(line.get_ydata())


def shaded(ax: Axes) -> list[list[float]]:
    """Low and high end of each shaded band."""
    paths = [patch.get_patch_transform().transform_path(patch.get_path()).vertices for patch in ax.patches]
    return [[path[:, 0].min(), path[:, 0].max()] for path in paths]


def words(ax: Axes) -> list[str]:
    return [text.get_text() for text in texts(ax)]


def texts(ax: Axes) -> list[Text]:
    legend = ax.get_legend()
    assert legend is not None
    every = [*ax.texts, ax.title, ax.xaxis.label, ax.yaxis.label, *legend.get_texts()]
    return [text for text in every if text.get_text()]


def paper_environment(omega: np.ndarray) -> np.ndarray:
    return 1.8 * (1j * omega) ** 2 + 15 * 1j * omega + 100


def paper_perceived(omega: np.ndarray) -> np.ndarray:
    return paper_environment(omega) * 6400 / ((1j * omega) ** 2 + 80 * 1j * omega + 6400)


# The ratios.


def test_the_ratios_drawn_are_those_of_eq_10() -> None:
    ax, _ = drawn(PAPER, draw_ratios)
    real, imag = curves(ax)
    assert (real.get_linestyle(), imag.get_linestyle()) == ("-", "--")
    for line, part in ((real, np.real), (imag, np.imag)):
        omega, ratio = values(line)
        env, perc = paper_environment(omega), paper_perceived(omega)
        assert ratio == pytest.approx(np.abs(part(perc - env)) / np.abs(env), rel=1e-9, abs=1e-12)
        assert (omega[0], omega[-1]) == (0.0, 15.0)


@pytest.mark.parametrize("scene", [PAPER, PAPER.with_band(0, 200), NOTCH, ROTATION], ids=lambda s: str(s.band))
def test_the_grey_bands_are_the_transparent_set(scene: hs.Scene) -> None:
    ax, result = drawn(scene, draw_ratios)
    assert shaded(ax) == [pytest.approx(interval) for interval in result.to_dict()["transparent"]]


def test_every_proven_frequency_is_a_sample() -> None:
    for draw in (draw_ratios, FIGURES["projections-real"]):
        ax, result = drawn(NOTCH, draw)
        document = result.to_dict()
        proven = [c["omega"] for c in document["crossings"]]
        proven += [*document["changeovers"]["environment"], *document["changeovers"]["perceived"]]
        assert set(proven) <= set(values(curves(ax)[0])[0].tolist())


def test_crossings_are_marked_on_the_threshold_and_labelled_with_their_frequency() -> None:
    ax, result = drawn(PAPER, draw_ratios)
    marks = [line for line in ax.lines if line.get_marker() == "o"]
    assert [values(mark) for mark in marks] == [(float(c.omega), 0.1) for c in result.crossings]
    assert [mark.get_markerfacecolor() == "white" for mark in marks] == [c.part is Part.IMAG for c in result.crossings]
    assert {"7.979", "11.94"} <= set(words(ax))


def test_many_crossings_are_counted_instead_of_labelled() -> None:
    ax, result = drawn(NOTCH, draw_ratios)
    assert len(result.crossings) == 6
    assert "6 crossings" in words(ax)
    assert not {c.omega.digits(4) for c in result.crossings} & set(words(ax))
    assert sum(len(line.get_xdata()) for line in ax.lines if line.get_marker() == "o") == 6


def test_each_ratio_has_its_own_threshold_line_where_they_differ() -> None:
    def levels(scene: hs.Scene) -> list[float]:
        lines = [values(line)[1] for line in drawn(scene, draw_ratios)[0].lines]
        return sorted({float(y[0]) for y in lines if len(y) == 2 and y[0] == y[1]})

    assert levels(PAPER) == [0.1]
    assert levels(ROTATION) == [0.05, 0.2]


def test_a_peak_of_500_that_is_a_thousandth_of_the_band_wide_is_drawn_to_its_top() -> None:
    """At omega = 10 exactly, H_env = 0.02 j and dH = -0.1 omega^2 = -10."""
    ax, _ = drawn(LIGHTLY_DAMPED, draw_ratios)
    omega, ratio = values(curves(ax)[0])
    assert ratio[omega == 10] == pytest.approx([500])
    assert ratio.max() < 500.1
    assert "500 at 10" in words(ax)


@pytest.mark.parametrize("scene", [PAPER, NOTCH, LIGHTLY_DAMPED], ids=["paper", "notch", "lightly damped"])
def test_straight_lines_between_samples_are_the_curve_to_the_eye(scene: hs.Scene) -> None:
    ax, result = drawn(scene, draw_ratios)
    top = ax.get_ylim()[1]
    f, near = result.distortion.compile(), np.geomspace(1e-7, 3, 20_001)
    omega = np.concatenate([np.linspace(0, 15, 50_001), 7 - near, 7 + near, 10 - near, 10 + near])
    for line, exact in zip(curves(ax), (f(omega).ratio_real, f(omega).ratio_imag), strict=True):
        seen = np.interp(omega, *values(line))
        assert np.abs(np.minimum(seen, top) - np.minimum(exact, top)).max() < 0.002 * top


def test_an_unbounded_ratio_leaves_the_axes_and_says_where() -> None:
    ax, result = drawn(UNDAMPED, draw_ratios)
    [pole] = [float(point.omega) for point in result.unbounded]
    omega, ratio = values(curves(ax)[0])
    assert np.isnan(ratio[omega == pole]).all()
    assert ratio[~np.isnan(ratio)].max() > 1e6
    assert ax.get_ylim()[0] == 0
    assert 0.2 < ax.get_ylim()[1] < 5
    assert "∞ at 10" in words(ax)


def test_an_identity_lies_on_the_zero_line_and_is_grey_throughout() -> None:
    ax, _ = drawn(IDENTITY, draw_ratios)
    assert [float(np.abs(values(line)[1]).max()) for line in curves(ax)] == [0, 0]
    assert shaded(ax) == [[0, 15]]
    assert ax.get_ylim() == (0, pytest.approx(0.2))


def test_a_display_that_is_nowhere_transparent_is_nowhere_grey() -> None:
    ax, _ = drawn(STIFFENED, draw_ratios)
    assert shaded(ax) == []
    assert "nowhere transparent" in words(ax)


# The Nyquist plot.


def test_the_nyquist_plot_traces_both_dynamics() -> None:
    ax, _ = drawn(PAPER, draw_nyquist)
    env, perc = (values(line) for line in curves(ax))
    omega = env[1] / 15  # Im H_env = 15 omega
    assert (omega.min(), omega.max()) == (0, 15)
    assert env[0] == pytest.approx(paper_environment(omega).real)
    assert perc[0] + 1j * perc[1] == pytest.approx(paper_perceived(omega))
    assert ax.get_aspect() == 1


@pytest.mark.parametrize("marks", [None, (3.0, 7.0, 14.5)])
def test_matched_frequencies_bear_the_same_marker_on_both_curves(marks: tuple[float, ...] | None) -> None:
    ax, _ = drawn(PAPER, lambda ax, result: draw_nyquist(ax, result, marks))
    spots = [line for line in ax.lines if line.get_linestyle() == "None"]
    expected = np.array(marks or (5.0, 10.0, 15.0))
    assert [len(spots), len({spot.get_marker() for spot in spots})] == [6, 3]
    for pair, omega in zip(zip(spots[::2], spots[1::2], strict=True), expected, strict=True):
        assert pair[0].get_marker() == pair[1].get_marker()
        places = [complex(x.item(), y.item()) for x, y in map(values, pair)]
        assert places == pytest.approx([paper_environment(omega), paper_perceived(omega)])
        assert f"{omega:g} rad/s" in words(ax)


def test_arrows_point_towards_higher_frequencies() -> None:
    ax, _ = drawn(PAPER, draw_nyquist)
    arrows = [text for text in ax.texts if isinstance(text, Annotation)]
    assert len(arrows) == 4
    for arrow in arrows:
        assert arrow.xy[1] > arrow.xyann[1]  # Im H grows throughout
        assert arrow.xy[0] < arrow.xyann[0]  # Re H falls throughout


@pytest.mark.parametrize("scene", [RINGING, RINGING_AT_SQRT_50], ids=["a pole at 10", "a pole at no float"])
def test_a_pole_of_the_dynamics_breaks_the_curve_and_spares_the_axes(scene: hs.Scene) -> None:
    ax, _ = drawn(scene, draw_nyquist)
    _, (real, imag) = (values(line) for line in curves(ax))
    [gap] = np.flatnonzero(np.isnan(imag))
    assert imag[gap - 1] > 1e6
    assert imag[gap + 1] < -1e6
    assert real[~np.isnan(real)] == pytest.approx(float(scene.environment.H.subs(hs.s, 0)))
    assert max(map(abs, (*ax.get_xlim(), *ax.get_ylim()))) < 2000


def test_a_dynamics_that_stays_in_one_spot_is_still_marked() -> None:
    ax, _ = drawn(STIFFENED, draw_nyquist)
    spots = [values(line) for line in ax.lines if line.get_linestyle() == "None"]
    assert {(float(x.item()), float(y.item())) for x, y in spots} == {(100, 0), (120, 0)}
    assert not [text for text in ax.texts if isinstance(text, Annotation)]


# The projections.


@pytest.mark.parametrize(("part", "of"), [(Part.REAL, np.real), (Part.IMAG, np.imag)])
def test_projections_are_bold_exactly_where_the_distortion_is_noticed(
    part: Part, of: Callable[..., np.ndarray]
) -> None:
    ax, result = drawn(PAPER, lambda ax, result: draw_projections(ax, result, part))
    [percept] = [p for p in result.percepts if p.part is part]
    for bold, thin, dynamics in zip(
        curves(ax)[::2], curves(ax)[1::2], (paper_environment, paper_perceived), strict=True
    ):
        assert bold.get_linewidth() > thin.get_linewidth()
        for line, ends in ((bold, (float(percept.band.low.omega), 15.0)), (thin, (0.0, float(percept.band.low.omega)))):
            omega, magnitude = (x[~np.isnan(values(line)[1])] for x in values(line))
            assert (omega[0], omega[-1]) == ends
            assert magnitude == pytest.approx(np.abs(of(dynamics(omega))))
    assert shaded(ax) == [[0, pytest.approx(float(percept.band.low.omega))]]
    assert felt(percept) in [text.replace("\n", " ") for text in words(ax)]


def test_a_part_that_is_never_noticed_is_shown_on_the_whole_band_with_a_note() -> None:
    ax, _ = drawn(IDENTITY, FIGURES["projections-real"])
    assert "never exceeds the threshold" in words(ax)
    thin = [line for line in curves(ax) if not np.isnan(values(line)[1]).any()]
    assert len(thin) == 2
    assert shaded(ax) == [[0, 15]]


def test_an_active_display_is_noticed_but_has_no_percept() -> None:
    ax, result = drawn(ACTIVE, FIGURES["projections-imag"])
    assert result.percepts == ()
    assert "noticed, not named" in [text.replace("\n", " ") for text in words(ax)]
    assert "never exceeds the threshold" not in words(ax)


@pytest.mark.slow
def test_percepts_in_narrow_bands_are_numbered_and_told_in_the_legend() -> None:
    ax, result = drawn(UNDAMPED, FIGURES["projections-real"])
    assert len(result.percepts) == 4
    for percept in result.percepts:
        assert felt(percept) in [text.replace("\n", " ") for text in words(ax)]
    assert {"1", "2", "3"} <= set(words(ax))


# The JND square.


def test_the_jnd_square_is_c_times_the_modulus_around_the_tip_of_the_environment() -> None:
    ax, _ = drawn(ROTATION, lambda ax, result: draw_jnd_square(ax, result, 20.0))
    tip = 3 + 0.2 * 20j + 0.01 * (20j) ** 2
    [square] = [patch for patch in ax.patches if isinstance(patch, Rectangle)]
    assert complex(*square.get_center()) == pytest.approx(tip)
    assert (square.get_width(), square.get_height()) == pytest.approx((0.1 * abs(tip), 0.4 * abs(tip)))
    ends = [complex(*arrow.xy) for arrow in ax.texts if isinstance(arrow, Annotation)]
    assert pytest.approx(tip) in ends
    assert pytest.approx(tip + 0.002 * (20j) ** 2) in ends
    assert ax.get_aspect() == 1


@pytest.mark.parametrize(
    ("omega", "verdict"),
    [(5.0, "not noticed"), (10.0, "noticed in the real part"), (13.0, "noticed in both parts")],
)
def test_the_title_says_the_frequency_and_what_is_noticed(omega: float, verdict: str) -> None:
    ax, _ = drawn(PAPER, lambda ax, result: draw_jnd_square(ax, result, omega))
    assert ax.get_title() == rf"$\omega$ = {omega:g} rad/s: {verdict}"
    [square] = [patch for patch in ax.patches if isinstance(patch, Rectangle)]
    x, y = (square.get_x(), square.get_y()), (square.get_width(), square.get_height())
    tip = paper_perceived(np.array(omega))
    outside = [not low <= t <= low + size for low, size, t in zip(x, y, (tip.real, tip.imag), strict=True)]
    assert sum(outside) == {"not noticed": 0, "noticed in the real part": 1, "noticed in both parts": 2}[verdict]


def test_at_the_very_crossing_nothing_is_noticed_yet() -> None:
    first = float(hs.evaluate(PAPER).crossings[0].omega)
    ax, _ = drawn(PAPER, lambda ax, result: draw_jnd_square(ax, result, first))
    assert ax.get_title().endswith(": not noticed")


def test_a_frequency_off_the_band_or_at_a_pole_has_no_square() -> None:
    result, ringing = hs.evaluate(PAPER), hs.evaluate(RINGING)
    with pytest.raises(hs.SceneError, match=r"15\.1 rad/s is not on the band, 0 to 15"):
        draw_jnd_square(Figure().add_subplot(), result, 15.1)
    with pytest.raises(hs.SceneError, match="infinite at 10 rad/s"):
        draw_jnd_square(Figure().add_subplot(), ringing, 10.0)


# All of them.


@pytest.mark.few(5)
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES)
def test_no_text_is_cut_off_or_lies_on_another(scene: hs.Scene, name: str) -> None:
    ax, _ = drawn(scene, FIGURES[name])
    figure = ax.figure
    assert isinstance(figure, Figure)
    figure.draw_without_rendering()
    boxes = [(text.get_text(), Text.get_window_extent(text)) for text in texts(ax)]
    for text, box in boxes:
        assert box.x0 > -1, text
        assert box.y0 > -1, text
        assert box.x1 < figure.bbox.x1 + 1, text
        assert box.y1 < figure.bbox.y1 + 1, text
    for (text, box), (other_text, other) in combinations(boxes, 2):
        wide = min(box.x1, other.x1) - max(box.x0, other.x0)
        high = min(box.y1, other.y1) - max(box.y0, other.y0)
        assert min(wide, high) < 1.5, (text, other_text)


def test_a_rotation_has_units_of_its_own() -> None:
    for name in NAMES[1:]:
        assert any("(N·m/rad)" in label for label in words(drawn(ROTATION, FIGURES[name])[0]))
        assert any("(N/m)" in label for label in words(drawn(PAPER, FIGURES[name])[0]))
        assert r"$\omega$ (rad/s)" in words(drawn(PAPER, FIGURES["ratios"])[0])


def test_large_numbers_are_told_in_thousands() -> None:
    ax, _ = drawn(PAPER.with_band(1000, 5000), FIGURES["projections-real"])
    assert "(kN/m)" in ax.get_ylabel()
    assert ax.yaxis.get_major_formatter()(2.0e7) == "20000"
    assert ax.get_ylim()[1] > 1.8 * 5000**2


def test_drawing_touches_only_the_axes_given() -> None:
    before = dict(mpl.rcParams)
    figure = Figure()
    first, second = figure.subplots(1, 2)
    draw_ratios(first, hs.evaluate(PAPER))
    assert dict(mpl.rcParams) == before
    assert figure.axes == [first, second]
    assert [*second.lines, *second.patches, *second.texts, *figure.texts, *figure.legends] == []
    assert second.get_xlabel() == ""


# Files.


@pytest.fixture(scope="module")
def saved(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    before = dict(mpl.rcParams)
    paths = save_figures(hs.evaluate(PAPER), tmp_path_factory.mktemp("figures") / "not" / "there yet")
    assert dict(mpl.rcParams) == before
    return paths


@pytest.mark.slow
def test_all_figures_are_saved_in_all_formats(saved: list[Path]) -> None:
    assert [path.name for path in saved] == [f"{name}.{kind}" for name in NAMES for kind in ("svg", "pdf", "png")]
    assert all(path.stat().st_size > 1000 for path in saved)


@pytest.mark.slow
def test_saved_figures_are_one_column_wide(saved: list[Path]) -> None:
    for path in saved:
        data = path.read_bytes()
        if path.suffix == ".svg":
            assert re.search(rb'<svg [^>]*width="244\.8pt"', data)
        elif path.suffix == ".pdf":
            assert re.search(rb"/MediaBox \[ 0 0 244\.8 ", data)
        else:
            assert int.from_bytes(data[16:20], "big") == 3.4 * 400


@pytest.mark.slow
def test_a_saved_figure_bears_no_date_and_real_letters(saved: list[Path]) -> None:
    for path in saved:
        assert b"CreationDate" not in path.read_bytes()
        assert b"<dc:date>" not in path.read_bytes()
        assert path.suffix != ".pdf" or b"/Type3" not in path.read_bytes()


@pytest.mark.slow
def test_the_square_saved_is_of_the_middle_of_the_first_percept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[float] = []
    monkeypatch.setattr("haptisym.figures.files.draw_jnd_square", lambda _ax, _result, omega: asked.append(omega))
    monkeypatch.setattr(Figure, "savefig", lambda *_args, **_options: None)
    for scene in (PAPER, IDENTITY):
        save_figures(hs.evaluate(scene), tmp_path)
    assert asked == [pytest.approx((7.978916790174708 + 15) / 2), 15]


@pytest.mark.slow
def test_the_same_evaluation_gives_the_same_files(saved: list[Path], tmp_path: Path) -> None:
    for first, second in zip(saved, save_figures(hs.evaluate(PAPER), tmp_path), strict=True):
        assert first.read_bytes() == second.read_bytes(), first.name


@pytest.mark.slow
def test_no_figure_needs_pyplot() -> None:
    probe = (
        "import sys, haptisym as hs\n"
        "from matplotlib.figure import Figure\n"
        "from haptisym.figures.ratios import draw_ratios\n"
        "scene = hs.Scene(hs.environments.mass_spring_damper(1, 5, 100), (hs.effects.first_order_lag(20),))\n"
        "draw_ratios(Figure().add_subplot(), hs.evaluate(scene))\n"
        "assert 'matplotlib.pyplot' not in sys.modules\n"
    )
    subprocess.run([sys.executable, "-W", "error", "-c", probe], check=True)


# Numbers and words of figures, held against the answers that they draw.


@pytest.mark.slow
def test_a_hand_that_is_let_go_is_drawn_in_millimetres_from_where_it_was() -> None:
    run = hs.release("delayed-spring", "1 cm", hs.Hand("own", m="0.5 kg", b="3.6 N*s/m"))
    ax = Figure().add_subplot()
    motion, *_ = draw_release(ax, run)
    assert motion.get_ydata()[0] == pytest.approx(10)  # type: ignore[index]
    assert ax.get_ylabel() == "motion (mm)"


def test_the_method_of_the_package_alone_is_bold_in_the_table_of_hard_cases() -> None:
    rows = [
        HardRow(
            "evaluate",
            method,
            15,
            1e-3,
            proven=ours,
            family="cancelled",
            case="s",
            condition=1,
            ours=ours,
            verdict="right",
        )
        for method, ours in (("proof", True), ("grid", False))
    ]
    ax = Figure().add_subplot()
    draw_table(ax, rows)
    assert {x.get_text(): x.get_fontweight() for x in ax.texts if x.get_text() in ("proof", "grid")} == {
        "proof": "bold", "grid": "normal",
    }  # fmt: skip


@pytest.mark.slow
def test_the_legend_of_a_swept_plane_tells_where_the_whole_band_is_transparent() -> None:
    swept = Swept(PAPER, hs.sweep(PAPER, {"omega_n": [50.0, 90.0, 150.0], "zeta": [0.3, 0.5, 0.7]}))
    assert float(swept.data["bandwidth"].max()) == 15
    words = [text.get_text() for text in swept_figure(swept).findobj(Text)]
    assert "whole band, 15 rad/s" in words


def test_over_each_piece_of_the_band_stands_the_effect_that_dominates_it() -> None:
    """By its name where there is room, else by a number that the title explains."""
    found = hs.relevance("control-stick-in-detail")
    ax = Figure().add_subplot()
    pieces = draw_dominance(ax, found)
    assert len(pieces) == len(found.dominance)
    start, end = (float(x) for x in found.scene.band)
    for x in found.dominance:
        low, high = float(x.low), float(x.high)
        [name] = [t.get_text() for t in ax.texts if low < t.get_position()[0] < high]
        if (high - low) > 0.5 * (end - start):
            assert name == x.effect.name
        assert name in ("", x.effect.name) or f"{name} {x.effect.name}" in ax.get_title(loc="left")
