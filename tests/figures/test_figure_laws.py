"""Figures, by laws: what is drawn lies where its numbers are, names stand clear of each other, and strokes are those of the house."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from itertools import combinations, pairwise
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from flint import acb
from matplotlib.axes import Axes
from matplotlib.colors import to_hex, to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Polygon, Rectangle
from matplotlib.text import Annotation, Text
from sympy import Rational

import haptisym as hs
from haptisym.figures import pen
from haptisym.figures.cost import cost_figure, draw_cost
from haptisym.figures.hardcosts import hard_costs_figure
from haptisym.figures.identify import identification_figure
from haptisym.figures.jnd import draw_jnd, draw_published
from haptisym.figures.lines import thinned
from haptisym.figures.metrics import draw_verdicts, verdict_bands
from haptisym.figures.names import Room
from haptisym.figures.outlines import outline
from haptisym.figures.regions import draw_family_regions, draw_regions
from haptisym.figures.release import draw_release, release_figure
from haptisym.figures.sensitivity import draw_elasticities, elasticities_figure
from haptisym.figures.stability import draw_plane, stability_figure
from haptisym.figures.style import number, raised
from haptisym.judge.criteria import noticed
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.rootcount import Roots
from haptisym.verbs.cost.entry import Cost
from haptisym.verbs.cost.hardcosts import HardCosts
from haptisym.verbs.cost.measurement import HardRow, Measurement, front
from haptisym.verbs.jnd.answers import Answers, Row
from haptisym.verbs.simulate.pencil import Mode
from haptisym.verbs.simulate.propagate import NODES
from haptisym.verbs.simulate.released import Closed, Release
from haptisym.verbs.simulate.rightmost import Rightmost
from haptisym.verbs.stability.answer import Stability
from haptisym.verbs.stability.critical import Critical, Nearest
from haptisym.verbs.stability.held import Held, Imposed
from haptisym.verbs.stability.passive import EveryPassiveHand

SPRING = hs.environments.mass_spring_damper(k=100)
WIDTHS = {0.0, 0.4, 0.5, 0.6, 0.7, 0.9, 1.0, 1.1, 1.2, 5.0}
SIZES = {6.0, 6.5, 7.0, 8.0, 9.0}
MARKS = {2.4, 3.2, 3.4, 3.5, 3.6, 4.6, 6.0}


def by_the_house(drawn: Figure | Axes) -> None:
    """Strokes, marks and letters have the sizes that figures of the house have, and nothing is drawn half."""
    for line in drawn.findobj(Line2D):
        if line.axes is not None and line in line.axes.lines:
            assert (
                round(line.get_linewidth(), 3) in WIDTHS or line.get_linestyle() == "None" or len(line.get_xdata()) == 1
            ), line
            assert line.get_marker() in ("None", None) or line.get_markersize() in MARKS, line
    for text in drawn.findobj(Text):
        if text.get_text().strip() and text.get_visible():
            assert text.get_fontsize() in SIZES, text


def boxes(texts: Iterable[Text]) -> list[Any]:
    return [Text.get_window_extent(x) for x in texts]


def are_apart(found: list[Any]) -> bool:
    return not any(a.overlaps(b) for a, b in combinations(found, 2))


# Costs


def measured(
    task: str, name: str, digits: float, seconds: float, *, proven: bool = False, missed: int = 0
) -> Measurement:
    return Measurement(task, name, digits, seconds, proven, missed)


CROSSINGS = [
    measured("crossings", "grid of 10^2", 4.8, 5.5e-4), measured("crossings", "grid of 10^3", 6.8, 3.6e-4),
    measured("crossings", "grid of 10^5", 10.8, 5e-2), measured("crossings", "numpy.roots", 15.5, 6e-4),
    measured("crossings", "lost", 9.0, 1e-3, missed=2), measured("crossings", "nothing right", 0.5, 2e-3),
    measured("crossings", "certified, 15 digits", 15, 2.4e-2, proven=True), measured("crossings", "certified, 50 digits", 50, 2.6e-2, proven=True),
    measured("crossings", "slower", 40, 0.5, proven=True),
]  # fmt: skip
OTHERS = [measured("evaluate", "fast", 14, 1e-7), measured("evaluate", "certified", 16, 5e-6, proven=True)]
OPEN = [measured("effects", "without it", 1, 1e-2)]


def test_marks_stand_at_time_and_digits_and_what_is_wrong_on_the_strip() -> None:
    ax = Figure(figsize=(4, 3)).add_subplot()
    draw_cost(ax, CROSSINGS)
    marks = [x for x in ax.lines if x.get_marker() == "o"]
    places = [(float(x.get_xdata()[0]), float(x.get_ydata()[0])) for x in marks]
    wrong = ("lost", "nothing right")
    assert places == [(x.seconds, 0.4 if x.method in wrong else x.digits) for x in CROSSINGS]
    assert [to_hex(x.get_markerfacecolor()) == pen.INK for x in marks] == [x.proven for x in CROSSINGS]
    strip = max(
        (x for x in ax.patches if to_hex(x.get_facecolor()) == pen.SHADE), key=lambda x: x.get_window_extent().width
    )
    assert (
        strip.get_window_extent().y0
        <= ax.transData.transform((1, 0.4))[1]
        <= strip.get_window_extent().y1
        < ax.transData.transform((1, 0.7))[1]
    )
    assert ax.get_xlim() == (pytest.approx(3.6e-4 / 3), pytest.approx(1.5))
    assert ax.get_ylim() == (pytest.approx(0.4 / 1.5), pytest.approx(125))
    fronts = [x for x in ax.lines if x.get_drawstyle() == "steps-post"]
    telling = [x for x in CROSSINGS if x.method != "nothing right"]
    for line, rows, color in zip(fronts, (telling, [x for x in telling if x.proven]), (pen.GREY, pen.INK), strict=True):
        best = front(rows)
        assert line.get_xdata()[:-1] == pytest.approx([x.seconds for x in best])
        assert list(line.get_ydata()) == pytest.approx([*(x.digits for x in best), best[-1].digits])
        assert line.get_xdata()[-1] == pytest.approx(1.5)
        assert to_hex(line.get_color()) == color
    assert ax.get_title(loc="left") == "Finding all crossings"
    assert [float(x) for x in ax.get_yticks()] == [1, 3, 10, 16, 30, 100]
    assert (ax.get_xscale(), ax.get_yscale()) == ("log", "log")
    assert ax.xaxis.get_major_formatter()(2e-6, 0) == "2 µs"
    few = Figure().add_subplot()
    draw_cost(few, OTHERS)
    assert few.get_ylim()[1] == pytest.approx(50)  # 20 digits have room at least
    by_the_house(ax)


def test_a_figure_of_costs_has_a_panel_for_each_question_and_names_that_stand_clear() -> None:
    groups, shape = [CROSSINGS, OTHERS, OPEN], (7.0, 5.7)
    rows = tuple(x for group in groups for x in group)
    figure = cost_figure(Cost(hs.Scene(SPRING, title="A spring alone"), rows, (), {}, {}))
    assert tuple(figure.get_size_inches()) == pytest.approx(shape)
    panels = [ax for ax in figure.axes if ax.get_title(loc="left")]
    order = ["Evaluating the ratios at one frequency", "Finding all crossings", "Leaving an effect out"]
    assert [ax.get_title(loc="left") for ax in panels] == [x for x in order if len(groups) > 1 or x == order[1]]
    figure.draw_without_rendering()
    assert figure.get_suptitle() == "A spring alone"
    for ax in panels:
        names = [x for x in ax.texts if x.get_text()]
        own = [
            x
            for x in rows
            if len(panels) == 1 or {"evaluate": 0, "crossings": 1, "effects": 2}[x.task] == panels.index(ax)
        ]
        expected = {raised(f"{x.method}: misses 2" if x.missed else x.method) for x in own}
        assert {x.get_text() for x in names} == expected
        found = boxes(names)
        assert are_apart(found)
        frame = ax.get_window_extent()
        marks = ax.transData.transform(
            [(float(x.get_xdata()[0]), float(x.get_ydata()[0])) for x in ax.lines if x.get_marker() == "o"]
        )
        for box in found:
            assert frame.x0 - 2 <= box.x0
            assert box.x1 <= frame.x1 + 2
            assert not any(box.x0 < x < box.x1 and box.y0 < y < box.y1 for x, y in marks)
        for text, x in zip(
            sorted(names, key=lambda y: y.get_text()), sorted(own, key=lambda y: raised(y.method)), strict=True
        ):
            mark = ax.transData.transform((x.seconds, x.digits if x.complete and x.digits > 0.7 else 0.4))
            box, em = Text.get_window_extent(text), 7 * figure.dpi / 72
            assert (
                np.hypot(max(box.x0 - mark[0], 0, mark[0] - box.x1), max(box.y0 - mark[1], 0, mark[1] - box.y1))
                < 6.5 * em
            )
    legends = [*figure.legends, *(x for ax in figure.axes if (x := ax.get_legend()))]
    words = ["proven", "not proven", "best of the proven", "best of all", "no digit right, or a wrong count"]
    assert [[x.get_text() for x in legend.get_texts()] for legend in legends] == [words]
    by_the_house(figure)
    if len(groups) > 1:
        said = " ".join(" ".join(x.get_text() for x in figure.axes[-1].texts).split())
        assert said.startswith("Here all crossings, proven, to 15 digits take 24 ms")
    unproven = cost_figure(Cost(hs.Scene(SPRING), tuple(OPEN), (), {}, {}))
    assert tuple(unproven.get_size_inches()) == pytest.approx((6.8, 3.9))
    assert [x.get_text() for x in unproven.legends[0].get_texts()] == [words[1], *words[3:]]


# Releases


def let_go(root: complex = -2 + 30j, end: float = 4.0, scale: float = 0.01, **given: Any) -> Release:
    t = (0.05 * (np.arange(round(end / 0.05))[:, None] + NODES)).ravel()
    hand = hs.Hand("own", m=1)
    own: dict[str, Any] = {
        "fitted": Mode(root, 9),
        "closed": Closed(Rightmost(root, acb(root.real, root.imag), certified=True, others=(root,))),
        "approximate": "",
    }
    own |= given
    x = scale * (np.exp(root * t)).real
    return Release(
        hs.Scene(SPRING),
        hand,
        scale,
        t,
        x,
        3 * x,
        own["fitted"],
        0.0,
        own["closed"],
        "",
        (),
        own["approximate"],
        Held(hand, Roots(0, 0)),
    )


def test_a_release_is_drawn_over_a_dozen_turns_or_five_powers_of_e_below_its_envelope() -> None:
    for root, end in (
        (-1 + 30j, 12 * 2 * np.pi / 30),
        (-4 + 10j, 5 / 4),
        (-0.1 + 3j, float(let_go().time[-1])),
        (-2 + 0j, 2.5),
    ):
        ax = Figure().add_subplot()
        motion, *envelopes = draw_release(ax, let_go(root))
        t, x = motion.get_xdata(), motion.get_ydata()
        assert ax.get_xlim() == (0, pytest.approx(end, rel=1e-9))
        assert end - 0.05 < t.max() <= end
        assert x == pytest.approx(10 * np.exp(root * t).real, abs=1e-3)  # in mm
        assert ax.get_ylim() == (pytest.approx(-1.08 * np.abs(x).max()), pytest.approx(1.08 * np.abs(x).max()))
        assert (ax.get_ylabel(), ax.get_xlabel()) == ("motion (mm)", "time (s)")
        curves = [y for y in ax.lines if to_hex(y.get_color()) == pen.RED]
        assert len(curves) == (2 if root.imag else 1)
        assert [y.get_label() for y in envelopes] == ["envelope of the closed form"]
        for y, sign in zip(curves, (1, -1), strict=False):
            assert y.get_ydata() == pytest.approx(sign * 10 * np.exp(root.real * y.get_xdata()), rel=0.03)
        if len(curves) == 2:
            late = t > t[-1] / 3
            assert (np.abs(x[late]) <= curves[0].get_ydata()[late] * (1 + 1e-9)).all()
        by_the_house(ax)
    large = Figure().add_subplot()
    draw_release(large, let_go(scale=0.3))
    assert large.get_ylabel() == "motion (m)"
    for given in ({"closed": None}, {"approximate": "a clock"}):
        assert [x.get_label() for x in draw_release(Figure().add_subplot(), let_go(**given))] == ["motion"]
    whole = Figure().add_subplot()
    draw_release(whole, let_go(fitted=None))
    assert whole.get_xlim()[1] == pytest.approx(let_go().time[-1])
    both = Figure().add_subplot()
    draw_release(both, let_go(), label="one")
    again = draw_release(both, let_go(-1 + 10j), label="two", color="#009900")
    assert [x.get_label() for x in again] == ["motion, two"]
    assert both.get_xlim()[1] == pytest.approx(max(12 * 2 * np.pi / 30, 4.0), rel=0.3)
    assert release_figure(let_go()).get_figwidth() == pen.WIDTH


# Sensitivities


@cache
def sensitivities() -> hs.Sensitivities:
    felt = hs.environments.kelvin_voigt(100, 3)
    return hs.sensitivity(hs.Scene(felt, (hs.effects.first_order_lag(20),), (0, 15), "0.1"))


def test_bars_of_elasticities_are_as_long_as_they_are_and_named_with_their_values() -> None:
    found = sensitivities()
    ax = Figure().add_subplot()
    first = found.crossings[0]
    bars = draw_elasticities(ax, first, "first")
    told = sorted(
        (
            (abs(float(x.elasticity)), x.name, float(x.elasticity))
            for x in first.parameters
            if x.elasticity is not None and float(x.elasticity)
        ),
        reverse=True,
    )
    assert [x.get_width() for x in bars] == pytest.approx([v for *_, v in told])
    assert [round(x.get_y() + x.get_height() / 2, 9) for x in bars] == list(range(len(told)))
    assert [to_hex(x.get_facecolor()) for x in bars] == [pen.BLUE if v > 0 else pen.RED for *_, v in told]
    values = [x.get_text() for x in ax.texts]
    assert values == [("+" if v > 0 else "") + number(v, 3) for *_, v in told]
    for text, (*_, v) in zip(ax.texts, told, strict=True):
        assert isinstance(text, Annotation)
        assert (text.xy[0], text.get_ha(), np.sign(text.xyann[0])) == (
            pytest.approx(v),
            "left" if v > 0 else "right",
            np.sign(v),
        )
    assert ax.get_ylim() == (len(told) - 0.5, -0.5)
    assert ax.get_title(loc="left").startswith(f"first\n{first.omega.digits(5)} rad/s")
    heights = {round(x.get_height(), 6) for x in bars}
    again = draw_elasticities(ax, first, "again", label="again")
    assert {round(x.get_height(), 6) for x in again} == {0.28}
    assert heights == {0.62}
    assert len(ax.texts) == len(told)
    by_the_house(ax)


def test_panels_of_elasticities_stand_below_each_other_each_as_high_as_its_bars() -> None:
    found = sensitivities()
    figure = elasticities_figure(found)
    figure.draw_without_rendering()
    counts = [len(ax.patches) for ax in figure.axes]
    assert figure.get_figheight() == pytest.approx(sum(0.19 * n + 0.46 for n in counts) + 0.62)
    assert figure.get_figwidth() == pen.WIDTH
    for ax, n in zip(figure.axes, counts, strict=True):
        assert ax.get_window_extent().height / figure.dpi == pytest.approx(0.19 * n)
        assert all(x.get_window_extent().x0 >= 0 for x in ax.get_yticklabels())
    extents = [ax.get_window_extent() for ax in figure.axes]
    assert all(a.y0 - b.y1 == pytest.approx(0.46 * figure.dpi) for a, b in pairwise(extents))
    assert extents[-1].y0 == pytest.approx(0.62 * figure.dpi)
    assert [bool(ax.get_xlabel()) for ax in figure.axes] == [False] * (len(counts) - 1) + [True]
    listed = [*found.crossings, *found.changeovers_environment, *found.changeovers_perceived]
    assert len(figure.axes) == min(len(listed), 12)
    titles = [ax.get_title(loc="left") for ax in figure.axes]
    assert all(f"{x.omega.digits(5)} rad/s" in title for x, title in zip(listed, titles, strict=False))


# Measures


def test_verdicts_are_bars_where_they_hold_one_row_for_each() -> None:
    m = hs.metrics("fu2019")
    ax = Figure().add_subplot()
    made = draw_verdicts(ax, m)
    rows = verdict_bands(m)
    assert [x.get_text() for x in ax.get_yticklabels()] == [name for name, _ in reversed(rows)]
    expected = [
        (i, float(x.low.omega), float(x.high.omega)) for i, (_, bands) in enumerate(reversed(rows)) for x in bands
    ]
    for line, (y, low, high) in zip(made, expected, strict=True):
        assert list(line.get_ydata()) == [y, y]
        assert list(line.get_xdata()) == pytest.approx([low, high])
        assert (line.get_linewidth(), line.get_marker() == "|") == (5.0, low == high)
    assert ax.get_xlim() == (0, 15)
    assert ax.get_ylim() == (-0.6, pytest.approx(len(rows) - 0.4))
    again = draw_verdicts(ax, m, label="again")
    assert {round(float(x.get_ydata()[0]) % 1, 6) for x in again} == {0.76}
    assert again[0].get_label() == "again"
    by_the_house(ax)


# Identified models


@pytest.mark.slow
def test_an_identified_model_is_drawn_through_its_lines_with_residuals_in_their_errors() -> None:
    at = np.array([1.0, 2.5, 4, 6, 8, 10, 40])
    exact = hs.sampled("fu2019", at)
    found = hs.identify(exact, "mass-spring-damper")
    figure = identification_figure(found)
    magnitude, phase, residuals = figure.axes
    H = found.fit.lines.H
    curve, dots = (x for x in magnitude.lines if len(x.get_xdata()) > 2)
    assert dots.get_xdata() == pytest.approx(at)
    assert dots.get_ydata() == pytest.approx(np.abs(H))
    omega = np.asarray(curve.get_xdata())
    assert (omega[0], omega[-1], len(omega) > 700) == (1, 40, True)
    m, b, k = (next(x.value for x in found.estimates if x.parameter.name == name) for name in ("m", "b", "k"))
    model = k - m * omega**2 + 1j * b * omega
    assert curve.get_ydata() == pytest.approx(np.abs(model), rel=1e-9)
    turned, marks = (x for x in phase.lines if len(x.get_xdata()) > 2)
    assert np.exp(1j * np.radians(turned.get_ydata())) == pytest.approx(model / np.abs(model), abs=1e-9)
    assert np.exp(1j * np.radians(marks.get_ydata())) == pytest.approx(H / np.abs(H), abs=1e-9)
    assert np.abs(np.diff(turned.get_ydata())).max() < 90
    levels = [float(x.get_ydata()[0]) for x in residuals.lines if len(x.get_xdata()) == 2]
    assert levels == [-2, 0, 2]
    real, imag = (x for x in residuals.lines if len(x.get_xdata()) > 2)
    raw = found.fit.residuals / np.sqrt(np.square(np.abs(found.fit.residuals)).mean() / 2)
    assert (real.get_ydata(), imag.get_ydata()) == (pytest.approx(raw.real), pytest.approx(raw.imag))
    top = max(3.0, 1.1 * max(np.abs(raw.real).max(), np.abs(raw.imag).max()))
    assert residuals.get_ylim() == (pytest.approx(-top), pytest.approx(top))
    assert {ax.get_xscale() for ax in figure.axes} == {"log"}  # 40 times the first
    assert magnitude.get_yscale() == ("log" if np.abs(H).max() > 8 * np.abs(H).min() else "linear")
    assert (phase.get_ylabel(), residuals.get_ylabel()) == ("phase (deg)", "residual / error")
    assert residuals.get_xlabel() == r"$\omega$ (rad/s)"
    assert (magnitude.get_xlabel(), phase.get_xlabel()) == ("", "")
    edges = {round(ax.get_window_extent().x0, 3) for ax in figure.axes}
    assert len(edges) == 1
    by_the_house(figure)


def test_of_many_lines_every_so_many_are_drawn() -> None:
    for count in (1, 799, 800, 801, 1601, 5000):
        found = thinned(count)
        step = -(-count // 800)
        assert found.tolist() == list(range(0, count, step))
        assert len(found) <= 800


# Hands


@pytest.mark.slow
def test_the_plane_of_a_hand_has_its_boundary_where_roots_lie_on_the_axis() -> None:
    """Held by a hand of 0.5 kg a spring of 100 N/m 36 ms late: m w^2 - k_h = 100 cos(0.036 w), b_h w = 100 sin(0.036 w)."""
    found = hs.stability(
        "delayed-spring",
        [
            hs.Hand("mine", m="0.5 kg", b="4 N*s/m", k="60 N/m"),
            hs.Hand("heavy", m="2 kg", b="3 N*s/m", k=["20 N/m", "40 N/m"]),
        ],
    )
    figure = Figure(figsize=(4, 4))
    ax = figure.add_subplot()
    draw_plane(ax, found)
    figure.draw_without_rendering()
    [boundary] = [x for x in ax.lines if to_hex(x.get_color()) == pen.BLUE]
    k, b = (np.asarray(x, dtype=float) for x in boundary.get_data())
    (low, high), (least, most) = ax.get_xlim(), ax.get_ylim()
    inside = (k > low) & (k < high) & (b > least) & (b < most)
    assert inside.sum() > 20
    w = np.linspace(1e-3, 90, 100_001)
    known = np.stack([0.5 * w**2 - 100 * np.cos(0.036 * w), 100 * np.sin(0.036 * w) / w], axis=1)
    scale = np.array([high - low, most - least])
    for place in np.stack([k, b], axis=1)[inside][::10]:
        assert np.hypot(*((known - place) / scale).T).min() < 2e-3
    marks = {(float(x.get_xdata()[0]), float(x.get_ydata()[0])): x for x in ax.lines if x.get_marker() == "o"}
    assert to_hex(marks[60.0, 4.0].get_markerfacecolor()) == pen.INK  # of this mass
    assert marks[30.0, 3.0].get_markerfacecolor() == "none"
    [box] = [x for x in ax.patches if isinstance(x, Rectangle) and not x.get_fill()]
    assert (box.get_xy(), box.get_width(), box.get_height()) == ((20, 3), 20, 0)
    names = [x for x in ax.texts if x.get_text() in ("mine", "heavy") or "hand" in x.get_text() or "-" in x.get_text()]
    assert are_apart(boxes(names))
    counts = {x.get_text() for x in ax.texts if x.get_text().isdigit()}
    assert counts == {"0", "2"}
    assert ax.get_xlabel() == r"$k_\mathrm{h}$ (N/m), for a hand of 0.5 kg"
    assert ax.get_ylabel() == r"$b_\mathrm{h}$ (N·s/m)"
    by_the_house(ax)


def cell(window: tuple[float, float, float, float], roots: Roots | None, k: float, left: float, right: float) -> Any:
    """A stretch of the plane from one share of its width to another, over its whole height."""
    pixels = np.zeros((100, 80), dtype=bool)
    pixels[round(100 * left) : round(100 * right)] = True
    return SimpleNamespace(
        pixels=pixels,
        roots=roots,
        is_stable=roots is not None and roots.number == 0,
        k=k,
        b=window[2] / 2 + window[3] / 2,
    )


def test_a_plane_of_hands_shows_grounds_boundary_hands_boxes_and_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Any] = []

    def plane(scene: hs.Scene, own: hs.Hand, window: Any) -> Any:
        asked.append((own.name, window))
        low, high = window[:2]
        cells = [
            cell(window, Roots(2, 2), low + 0.2 * (high - low), 0, 0.4), cell(window, Roots(0, 0), low + 0.5 * (high - low), 0.4, 0.6),
            cell(window, None, low + 0.7 * (high - low), 0.6, 0.8), cell(window, Roots(None, None), low + 0.85 * (high - low), 0.8, 0.95),
            cell(window, Roots(7, 7), low + 0.97 * (high - low), 0.95, 1),
        ]  # fmt: skip
        k = np.linspace(low - 10, high + 10, 50)
        return SimpleNamespace(window=window, mass=0.5, k=k, b=0.02 * k, at_0=-40.0, cells=cells)

    monkeypatch.setattr("haptisym.figures.stability.plane", plane)
    monkeypatch.setattr(
        "haptisym.figures.stability.hands",
        {
            "twin": hs.Hand("twin", m="1 kg", b=30, k="100 N/m"),
            "double": hs.Hand("double", m="1 kg", b=30, k="100 N/m"),
            "alone": hs.Hand("alone", m="0.5 kg", b=10, k="300 N/m"),
        },
    )
    scene = hs.Scene(SPRING, (hs.effects.first_order_lag(20),), (0, 15), "0.1")
    mine = hs.Hand("mine", m="0.5 kg", b="8 N*s/m", k="60 N/m")
    heavy = hs.Hand("heavy", m="2 kg", b=["30 N*s/m", "40 N*s/m"], k=["20 N/m", "40 N/m"])
    rows = (
        Nearest("hand.k", (Critical("hand.k", ExactNumber(Rational(5999)), None, 0, 2), Critical("hand.k", ExactNumber(Rational(6001)), None, 0, 2))),
        Nearest("hands.mine.b", (Critical("hands.mine.b", ExactNumber(Rational(799)), None, 0, 2),)), Nearest("environment.k", (Critical("environment.k", ExactNumber(Rational(700)), None, 0, 2),)),
    )  # fmt: skip
    found = Stability(
        scene,
        Imposed(stable=True, unstable=0),
        (Held(mine, Roots(0, 0)), Held(heavy, Roots(0, 0))),
        (rows, ()),
        (None, None),
        EveryPassiveHand(None),
    )
    figure = Figure(figsize=(5, 4))
    ax = figure.add_subplot()
    made = draw_plane(ax, found)
    figure.draw_without_rendering()
    # the largest numbers of hands are 300 N/m and 40 N s/m; critical ones count up to twenty times these
    assert asked == [
        (
            "mine",
            (pytest.approx(-130.0), pytest.approx(1.25 * 5999), pytest.approx(-0.05 * 799), pytest.approx(1.25 * 799)),
        )
    ]
    window = asked[0][1]
    assert (*ax.get_xlim(), *ax.get_ylim()) == pytest.approx(window)
    assert [x.get_label() for x in made] == [
        "boundary",
        "root at 0",
        "not stable",
        "not decided",
        "of this mass",
        "of another",
    ]
    [line] = [x for x in ax.lines if to_hex(x.get_color()) == pen.BLUE]
    assert line.get_ydata() == pytest.approx(0.02 * np.asarray(line.get_xdata()))
    [at_0] = [x for x in ax.lines if to_hex(x.get_color()) == pen.RED]
    assert list(at_0.get_xdata()) == [-40, -40]
    marks = {
        (float(x.get_xdata()[0]), float(x.get_ydata()[0])): (x.get_markerfacecolor(), to_hex(x.get_color()))
        for x in ax.lines
        if x.get_marker() == "o"
    }
    assert marks == {
        (60, 8): (pen.INK, pen.INK),
        (30, 35): ("none", pen.INK),
        (100, 30): ("none", pen.GREY),
        (300, 10): ("none", pen.GREY),
    }
    [box] = [x for x in ax.patches if isinstance(x, Rectangle) and not x.get_fill()]
    assert (box.get_xy(), box.get_width(), box.get_height()) == ((20, 30), 20, 10)
    words = [x.get_text() for x in ax.texts]
    assert sorted(words) == sorted(["mine", "heavy", "3 published hands", "2", "0", "?", "∞"]) or sorted(
        words
    ) == sorted(["mine", "heavy", "2 published hands", "alone", "2", "0", "?", "∞"])
    for text in ax.texts:
        if text.get_text() in ("2", "0", "?", "∞"):
            share = (text.xy[0] - window[0]) / (window[1] - window[0])  # type: ignore[attr-defined]
            low, high = {"2": (0, 0.4), "0": (0.4, 0.6), "?": (0.6, 0.8), "∞": (0.8, 0.95)}[text.get_text()]
            assert low <= share <= high
    grounds = {to_hex(x.get_facecolor()[0]): x for x in ax.collections if len(x.get_facecolor())}
    assert set(grounds) == {pen.UNSTABLE, pen.SHADE}
    assert ax.get_xlabel() == r"$k_\mathrm{h}$ (N/m), for a hand of 0.5 kg"
    assert ax.get_ylabel() == r"$b_\mathrm{h}$ (N·s/m)"
    by_the_house(ax)
    bare = Figure(figsize=(5, 4)).add_subplot()
    monkeypatch.setattr("haptisym.figures.stability.hands", {})
    draw_plane(bare, Stability(scene, Imposed(stable=True, unstable=0), (), (), (), EveryPassiveHand(None)))
    assert asked[-1] == ("none", (pytest.approx(-5.0), pytest.approx(125), pytest.approx(-0.05), pytest.approx(1.25)))
    with pytest.raises(hs.HaptisymError, match="with a clock the boundary"):
        stability_figure(
            Stability(
                hs.Scene(SPRING, (hs.effects.zero_order_hold("1 ms"),)),
                Imposed(stable=True, unstable=0),
                (),
                (),
                (),
                EveryPassiveHand(None),
            )
        )


# Regions


def test_regions_are_drawn_about_the_origin_as_large_as_they_are() -> None:
    scene = hs.Scene(
        hs.environments.mass_spring_damper(k=100, b=3),
        (hs.effects.first_order_lag(20),),
        (0, 15),
        {"real": "0.1", "imag": "0.2"},
    )
    found = hs.evaluate(scene, regions=True)
    ax = Figure().add_subplot()
    [line] = draw_regions(ax, found)
    w = np.linspace(0, 15, 200)
    H = 100 + 3j * w
    way = (H / (1 + 1j * w / 20) - H) / np.abs(H)
    drawn = line.get_xdata() + 1j * line.get_ydata()
    assert np.abs(drawn[:, None] - way[None, :]).min(axis=0).max() < 5e-3
    inverse = ax.transData.inverted()
    for patch, x in zip(ax.patches, found.regions, strict=True):
        corners = inverse.transform(patch.get_transform().transform(patch.get_path().vertices))
        assert np.abs(corners[:, 0]).max() == pytest.approx(0.1, rel=1e-3), x.name
        assert np.abs(corners[:, 1]).max() == pytest.approx(0.2, rel=1e-3), x.name
    for mark, x in zip(
        [y for y in ax.lines if y.get_marker() == "o"], [y for y in found.regions if y.crossing], strict=True
    ):
        w0 = float(x.crossing.omega)  # type: ignore[union-attr]
        h = 100 + 3j * w0
        at = (h / (1 + 1j * w0 / 20) - h) / abs(h)
        assert complex(mark.get_xdata()[0], mark.get_ydata()[0]) == pytest.approx(at, rel=1e-9)
    reach = ax.get_xlim()[1]
    assert (ax.get_xlim(), ax.get_ylim()) == ((-reach, reach), (-reach, reach))
    assert reach == pytest.approx(1.6 * 0.2, rel=1e-3)
    labels = [x.get_text() for x in ax.get_legend().get_texts()]
    assert labels == [r"$\Delta H$ over the band", *(x.name for x in found.regions)]
    by_the_house(ax)


def test_bandwidths_of_several_environments_by_each_region_stand_in_rows() -> None:
    lag = (hs.effects.first_order_lag(20),)
    scenes = {
        n: hs.Scene(hs.environments.mass_spring_damper(k=k, b=3), lag, (0, 15), "0.1")
        for n, k in (("soft", 50), ("hard", 900))
    }
    found = hs.evaluate_all(hs.SceneFamily(scenes), regions=True)
    ax = Figure().add_subplot()
    marks = draw_family_regions(ax, found)
    assert [x.get_text() for x in ax.get_yticklabels()] == ["soft", "hard", "all together"]
    for i, (mark, x) in enumerate(zip(marks, found.regions, strict=True)):
        widths = [x.answers["soft"].bandwidth, x.answers["hard"].bandwidth, x.bandwidth]
        assert np.asarray(mark.get_xdata()) == pytest.approx([float(w) if w else np.nan for w in widths], nan_ok=True)
        assert np.asarray(mark.get_ydata()) == pytest.approx(np.arange(3) + 0.2 * (i - 1.5))
        assert mark.get_label() == x.name
    assert (ax.get_xlim(), ax.get_ylim()) == ((0, 15), (2.5, -0.5))
    assert ax.get_xlabel() == "bandwidth (rad/s)"
    assert [float(x.get_ydata()[0]) for x in ax.lines if len(x.get_xdata()) == 2 and x not in marks] == [1.5]
    by_the_house(ax)


@pytest.mark.parametrize(
    ("jnd", "reach"),
    [
        ({"shape": "ellipse", "real": "0.1", "imag": "0.2"}, (0.1, 0.2)),
        ({"shape": "ellipse", "real": "0.1", "imag": "0.2", "tilt": "0.6"}, (0.1, 0.2)),
        ({"shape": "diamond", "real": "0.1", "imag": "0.2"}, (0.1, 0.2)),
        ({"shape": "polygon", "corners": [["0.1", "0"], ["0", "0.3"], ["-0.2", "0"], ["0", "-0.1"]]}, None),
        ({"real": "0.1", "imag": "0.2"}, (0.1, 0.2)),
    ],
)
def test_the_outline_of_a_region_is_where_a_change_is_just_noticed(
    jnd: dict[str, Any], reach: tuple[float, float] | None
) -> None:
    """About the tip of H_env, of size 5; an ellipse reaches a and b whatever its tilt is."""
    criteria = noticed(hs.Scene(SPRING, (), (0, 15), jnd).threshold)
    tip = np.array([3.0, 4.0])
    found = outline(criteria, tip, 2.0, {})
    [patch] = found.patches
    vertices = patch.get_path().vertices if isinstance(patch, Polygon) else patch.get_corners()  # type: ignore[attr-defined]
    offset = (np.asarray(vertices) - tip) / 5
    if reach is None:
        for corner in ((0.1, 0), (0, 0.3), (-0.2, 0), (0, -0.1)):
            assert np.hypot(*(offset - corner).T).min() < 1e-9
        assert found.stretches == (
            ((pytest.approx(3 - 1.0), pytest.approx(3.5)),),
            ((pytest.approx(4 - 0.5), pytest.approx(5.5)),),
        )
        return
    assert np.abs(offset).max(axis=0) == pytest.approx(reach, rel=1e-4)
    assert found.corners == pytest.approx(np.array([tip - 5 * np.array(reach), tip + 5 * np.array(reach)]), rel=1e-4)
    for part in range(2):
        [(low, high)] = found.stretches[part]
        assert (tip[part] - low, high - tip[part]) == (pytest.approx(high - tip[part]), pytest.approx(tip[part] - low))
        whole = (
            5 * reach[part] * ((1 - 0.36) ** 0.5 if jnd.get("tilt") else 1)
        )  # along the axis, a tilted one is narrower
        assert high - tip[part] == pytest.approx(whole, rel=1e-3)


# Names beside points


def test_a_name_stands_beside_its_point_where_nothing_else_is() -> None:
    figure = Figure(figsize=(5, 4))
    ax = figure.add_subplot()
    ax.set(xlim=(0, 10), ylim=(0, 10))
    room, size = Room(ax), 7.0
    places = [(5, 5), (5.3, 5), (5, 5.4), (9.7, 5), (0.3, 0.3), (5, 9.8), (2, 2)]
    room.take_line([2.1, 9.0], [2.0, 2.0])
    for x in places:
        room.take_point(*x)
    taken = []
    for x in places:
        right, up = room.beside(*x, "a name", size)
        a, b = room.at(*x)
        taken.append((a + right, b + up, a + right + 0.51 * size * 6, b + up + 0.95 * size))
    frame = ax.bbox.extents * 72 / figure.dpi
    for box, own in zip(taken, places, strict=True):
        assert frame[0] + 1 <= box[0]
        assert frame[1] + 1 <= box[1]
        assert box[2] <= frame[2] - 1
        assert box[3] <= frame[3] - 1
        for other in places:
            a, b = room.at(*other)
            assert not (box[0] < a + 3 and a - 3 < box[2] and box[1] < b + 3 and b - 3 < box[3]), (own, other)
    assert not any(a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3] for a, b in combinations(taken, 2))
    lonely = Room(ax)
    lonely.take_point(3, 7)
    right, up = lonely.beside(3, 7, "abc", size)
    assert (right, up) == (5.0, pytest.approx(-0.475 * size))  # to the right of it, at its height
    assert lonely.away((0, 0), (3, 4)) == pytest.approx(
        np.hypot(*(np.array([3, 4]) / 10 * ax.bbox.size * 72 / figure.dpi))
    )
    assert lonely.crowded((8, 2), size) == 0
    assert lonely.crowded((3, 7), size) > 0
    assert lonely.crowded((0, 5), size) >= 50
    lonely.take_line([7, 9], [2, 2])
    assert 0 < lonely.crowded((8, 2), size) < 20


# Hard cases, thresholds


def hard(task: str, family: str, method: str, verdict: str, digits: float, **more: Any) -> HardRow:
    own = {"proven": False, "ours": False, "case": "one", "missed": 0, "invented": 0} | more
    flags = own.pop("proven"), own.pop("missed"), own.pop("invented")
    return HardRow(task, method, digits, 1.0, *flags, family=family, condition=1.0, verdict=verdict, **own)


def test_a_table_of_hard_cases_has_a_cell_for_each_family_and_method_the_darker_the_worse() -> None:
    rows = (
        hard("evaluate", "identities", "certified", "right", 16.0, proven=True, ours=True),
        hard("evaluate", "identities", "in floats + Brent, old", "right", 15.2),
        hard("evaluate", "identities", "in floats + Brent, old", "loses 9 digits", 6.2, case="two"),
        hard("evaluate", "low frequencies", "certified", "right", 16.0, proven=True, ours=True),
        hard("evaluate", "low frequencies", "certified", "right", 15.6, ours=True, case="two"),
        hard("evaluate", "low frequencies", "in floats + Brent, old", "cannot: no", 0.0),
        hard("crossings", "long delays", "grid of 10^4", "misses 2 and invents 1", 0.0, missed=2, invented=1),
    )
    figure = hard_costs_figure(HardCosts(rows, {}))
    assert tuple(figure.get_size_inches()) == pytest.approx((1.95 + 2 * 0.98 + 0.1, 0.34 * (4 + 3) + 0.35))
    figure.draw_without_rendering()
    first, second = figure.axes
    words = [[x.get_text() for x in ax.texts] for ax in figure.axes]
    assert words[0] == [
        "Values of the ratios", "certified", "in floats\n+ Brent,\nold",
        "identities", "1 of 1", "16 digits", "1 of 2", "loses 9 digits", "low frequencies", "2 of 2", "16 digits", "cannot",
    ]  # fmt: skip
    assert words[1] == ["Crossings", "grid of 10⁴", "long delays", "0 of 1", "−2  +1"]
    bold = {x.get_text() for ax in figure.axes for x in ax.texts if x.get_fontweight() == "bold"}
    assert bold == {"Values of the ratios", "Crossings", "certified"}
    for ax, columns, lines in ((first, 2, 2), (second, 1, 1)):
        box = ax.get_window_extent()
        assert (box.width / figure.dpi, box.height / figure.dpi) == pytest.approx((0.98 * columns, 0.34 * lines))
        assert box.x0 / figure.dpi == pytest.approx(1.95)
    assert first.get_window_extent().y1 / figure.dpi == pytest.approx(figure.get_figheight() + 0.1 - 0.34 * 1.9)
    assert first.get_window_extent().y0 - second.get_window_extent().y1 == pytest.approx(0.34 * 1.9 * figure.dpi)
    shades = [to_rgb(x.get_facecolor())[0] for x in first.patches]
    ink = to_rgb(pen.INK)[0]
    assert shades == pytest.approx([1 - 0.42 * share * (1 - ink) for share in (0, 0.5, 0)])
    assert to_rgb(second.patches[0].get_facecolor())[0] == pytest.approx(1 - 0.42 * (1 - ink))
    assert [(x.get_x(), x.get_y()) for x in first.patches] == [(0.02, 0.05), (1.02, 0.05), (0.02, 1.05)]
    assert [to_hex(x.get_markerfacecolor()) == pen.INK for x in first.lines] == [True, False, False]
    assert [complex(x.get_xdata()[0], x.get_ydata()[0]) for x in first.lines] == pytest.approx(
        [0.13 + 0.34j, 1.13 + 0.34j, 0.13 + 1.34j]
    )
    for ax in figure.axes:
        inside = [x for x in ax.texts if x.get_position()[0] > 0]
        assert are_apart(boxes(inside))
        for text in inside:
            column = int(text.get_position()[0])
            left, right = (ax.transData.transform((column + n, 0))[0] for n in (0, 1))
            assert left - 1 <= Text.get_window_extent(text).x0
            assert Text.get_window_extent(text).x1 <= right + 1
    assert [x.get_text() for x in figure.legends[0].get_texts()] == [
        "proven",
        "not proven",
        "no answer right",
        "−  crossings missed   +  invented",
    ]


def test_a_measured_jnd_is_drawn_with_its_shares_its_curve_and_where_it_is_taken() -> None:
    counts = (3, 9, 14, 20, 25, 30)
    answers = Answers("answers", tuple(Row(4.4 + 0.3 * i, k, 40 - 5 * (i % 2)) for i, k in enumerate(counts)))
    p = hs.jnd(answers)
    ax = Figure().add_subplot()
    curve, *dots = draw_jnd(ax, p)
    rows = answers.rows
    assert [(float(x.get_xdata()[0]), float(x.get_ydata()[0])) for x in dots] == [(x.level, x.share) for x in rows]
    assert [x.get_markersize() for x in dots] == pytest.approx([max(3.0, 7 * (x.trials / 40) ** 0.5) for x in rows])
    assert curve.get_ydata() == pytest.approx(p.fit.curve(np.asarray(curve.get_xdata())))
    low, high = ax.get_xlim()
    assert (curve.get_xdata()[0], curve.get_xdata()[-1]) == pytest.approx((low, high))
    assert ax.get_ylim() == (-0.03, 1.03)
    at = p.middle.value + p.jnd.value
    share = float(p.fit.curve(np.array([at]))[0])
    red = [x for x in ax.lines if to_hex(x.get_color()) == pen.RED]
    ends = [[(float(a), float(b)) for a, b in zip(x.get_xdata(), x.get_ydata(), strict=True)] for x in red]
    assert ends[0] == [(pytest.approx(at), -0.03), (pytest.approx(at), pytest.approx(share))]
    assert ends[1][1] == (pytest.approx(at), pytest.approx(share))
    assert ends[2] == [(pytest.approx(p.middle.value + x), pytest.approx(share)) for x in (p.jnd.low, p.jnd.high)]
    [grey] = [x for x in ax.lines if to_hex(x.get_color()) == pen.GREY]
    assert list(grey.get_xdata()) == pytest.approx([p.middle.value] * 2)
    assert list(grey.get_ydata()) == pytest.approx([-0.03, 0.5], abs=0.02)
    labels = [x.get_text() for x in ax.get_legend().get_texts()]
    assert labels == [
        "fitted curve",
        "answers",
        "subjective equality",
        f"JND at {100 * p.asked.proportion:.4g} %",
        f"{100 * p.confidence:.4g} % interval",
    ]
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("level", "share of “more”")
    wide = [x for x in (at, p.middle.value + p.jnd.high, 4.4, 5.9) if x < 5.9 + 1.5]
    assert high == pytest.approx(max(wide) + 0.06 / 1.12 * (high - low))
    again, *_ = draw_jnd(ax, p, label="again")
    assert (to_hex(again.get_color()), again.get_label()) == (pen.SCENES[1], "fitted curve, again")


def test_published_thresholds_are_bars_from_their_least_to_their_largest() -> None:
    found = hs.published()
    ax = Figure().add_subplot()
    bars = draw_published(ax, found)
    rows = [x for x in found if not x.apart]
    assert [list(map(float, x.get_xdata())) for x in bars] == [
        pytest.approx([100 * float(x.low), 100 * float(x.high)]) for x in rows
    ]
    assert [x.get_text() for x in ax.get_yticklabels()] == [x.name for x in rows]
    assert [list(x.get_ydata()) for x in bars] == [[i, i] for i in range(len(rows))]
    assert ax.get_ylim()[0] > ax.get_ylim()[1]
    assert ax.get_xlabel() == "just-noticeable difference (%)"
    by_the_house(ax)
