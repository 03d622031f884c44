"""Figures of answers, by laws: closed forms written out by hand go through every place that a reader can read off."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PatchCollection
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from sympy import Rational

import haptisym as hs
from haptisym.figures import pen
from haptisym.figures.bandwidths import draw_bandwidths
from haptisym.figures.jnd import draw_jnd
from haptisym.figures.measured import draw_measured_ratios
from haptisym.figures.measuredplane import draw_measured_nyquist, draw_measured_plane
from haptisym.figures.metrics import draw_measures
from haptisym.figures.outlines import outline
from haptisym.figures.require import draw_requirement
from haptisym.figures.scales import floats_scale
from haptisym.figures.simulate import draw_loop, draw_recovered, draw_time
from haptisym.judge.criteria import noticed
from haptisym.kernel.reals import ExactNumber
from haptisym.verbs.jnd.answers import Answers, Row

STIFF = hs.environments.mass_spring_damper(k=100, b=3)
LAGGED = hs.Scene(STIFF, (hs.effects.first_order_lag(20),), (0, 15), "0.1")


def env(omega: Any) -> Any:
    return 100 + 3j * np.asarray(omega)


def perc(omega: Any) -> Any:
    return env(omega) / (1 + 1j * np.asarray(omega) / 20)


def axes() -> Axes:
    return Figure(figsize=(6, 4)).add_subplot()


def told(ax: Axes) -> list[str]:
    return [x.get_text() for x in ax.get_legend().get_texts()]


def places(line: Line2D) -> Any:
    return np.asarray(line.get_xdata(), dtype=float), np.asarray(line.get_ydata(), dtype=float)


# Measures


def test_measures_are_the_two_ratios_the_whole_change_and_that_of_the_size() -> None:
    ax = axes()
    lines = draw_measures(ax, hs.metrics(LAGGED))
    omega, _ = places(lines[0])
    change = (perc(omega) - env(omega)) / np.abs(env(omega))
    expected = (np.abs(change.real), np.abs(change.imag), np.abs(change), np.abs(np.abs(perc(omega) / env(omega)) - 1))
    for line, values in zip(lines, expected, strict=True):
        assert places(line)[0] == pytest.approx(omega)
        assert places(line)[1] == pytest.approx(values, abs=1e-12)
    assert [to_hex(x.get_color()) for x in lines] == [pen.INK, pen.INK, pen.RED, pen.BLUE]
    assert [x.get_label() for x in lines[2:]] == [r"$|\Delta H/H_\mathrm{env}|$", r"$||\Gamma| - 1|$"]
    assert told(ax) == [*(x.get_label() for x in lines), "$c = 0.1$"]
    [level] = [x for x in ax.lines if x.get_label() == "$c = 0.1$"]
    assert list(level.get_ydata()) == [0.1, 0.1]
    assert (ax.get_xlim(), ax.get_ylim()) == ((0, 15), (0, pytest.approx(1.06 * np.abs(change).max())))
    assert (ax.get_xlabel(), ax.get_ylabel()) == (r"$\omega$ (rad/s)", r"fraction of $|H_\mathrm{env}|$")
    for c, top in (("0.01", 0.08), ("0.9", 1.44)):
        other = axes()
        draw_measures(other, hs.metrics(replace(LAGGED, threshold=hs.Threshold.of(c, c))))
        assert other.get_ylim() == (0, pytest.approx(top))


# Bandwidths


def test_a_bandwidth_grows_with_its_threshold_as_the_larger_ratio_does() -> None:
    """A spring of 100 N/m felt with 2 N s/m beside it: r_i = 2 w/100, without a jump."""
    scene = hs.Scene(hs.environments.mass_spring_damper(k=100), (hs.effects.shunt(b=2),), (0, 15), "0.1 +- 50 %")
    ax = axes()
    [line] = draw_bandwidths(ax, hs.evaluate(scene), label="mine", color="#009900")
    c, omega = places(line)
    assert omega == pytest.approx(c / 100 * 100 / 2)
    assert (c[0], c[-1]) == (pytest.approx(5), pytest.approx(15))
    assert (np.diff(c) >= 0).all()
    assert (np.diff(omega) >= 0).all()
    [square] = [x for x in ax.lines if x.get_marker() == "s"]
    assert [float(v[0]) for v in places(square)] == pytest.approx([10, 5])
    [ends] = [x for x in ax.lines if x.get_marker() == "o"]
    assert [v.tolist() for v in places(ends)] == [pytest.approx([5, 15]), pytest.approx([2.5, 7.5])]
    assert ax.get_xlim() == (pytest.approx(4.7), pytest.approx(15.3))
    assert ax.get_ylim()[0] == 0
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("threshold $c$ (%)", "bandwidth (rad/s)")
    assert told(ax) == ["bandwidth, mine", "nominal, mine"]
    assert {to_hex(x.get_color()) for x in ax.lines} == {"#009900"}


# Simulations


@cache
def run() -> hs.Simulation:
    return hs.simulate(LAGGED, hs.sine("5 cm", "10 rad/s"))


def test_a_loop_is_the_ellipse_of_either_dynamics_and_time_shows_three_periods() -> None:
    """x = 0.05 sin(10 t), in mm; f = Im(H 0.05 exp(10 j t))."""
    ax = axes()
    for line, H, color, stroke in zip(
        draw_loop(ax, run()), (env(10), perc(10)), (pen.BLUE, pen.RED), ("-", "--"), strict=True
    ):
        x, force = places(line)
        assert np.abs(x).max() == pytest.approx(50, rel=1e-3)
        # (f - Re H x)/Im H is the motion a quarter of a turn on
        assert np.hypot(x / 1e3, (force - H.real * x / 1e3) / H.imag) == pytest.approx(0.05, rel=2e-3)
        assert (to_hex(line.get_color()), line.get_linestyle()) == (color, stroke)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("displacement (mm)", "force (N)")
    assert told(ax) == ["environment alone", "at the hand"]
    draw_loop(ax, run(), label="again")
    assert told(ax)[2:] == ["environment alone, again", "at the hand, again"]
    time = axes()
    force_line, motion = draw_time(time, run())
    t, f = places(force_line)
    assert t[-1] - t[0] == pytest.approx(3 * 2 * np.pi / 10, abs=0.05)
    assert f == pytest.approx((0.05 * perc(10) * np.exp(10j * t)).imag, abs=2e-3 * np.abs(f).max())
    assert np.abs(places(motion)[1]).max() == pytest.approx(np.abs(f).max())
    assert time.get_xlim() == (t[0], t[-1])
    assert time.get_ylim() == (pytest.approx(-1.08 * np.abs(f).max()), pytest.approx(1.08 * np.abs(f).max()))
    assert (to_hex(motion.get_color()), motion.get_linestyle()) == (pen.BLUE, "--")
    assert time.get_xlabel() == "time (s)"


def test_what_is_recovered_are_rings_on_the_closed_form() -> None:
    for part, of, name in ((hs.Part.REAL, np.real, "Re"), (hs.Part.IMAG, np.imag, "Im")):
        ax = axes()
        curve, rings = draw_recovered(ax, [run()], part)
        omega, values = places(curve)
        assert values == pytest.approx(of(perc(omega)))
        assert (omega[0], omega[-1], len(omega)) == (pytest.approx(9), pytest.approx(11), 601)
        assert [v.tolist() for v in places(rings)] == [[10.0], [pytest.approx(of(perc(10)), rel=1e-3)]]
        assert (rings.get_marker(), rings.get_markerfacecolor()) == ("o", "white")
        assert ax.get_xlim() == (pytest.approx(9), pytest.approx(11))
        room = 0.1 * abs(of(perc(10)))
        seen = values[np.abs(values - of(perc(10))) < room]
        assert ax.get_ylim() == (
            pytest.approx(seen.min() - 0.08 * room, rel=1e-3),
            pytest.approx(seen.max() + 0.08 * room, rel=1e-3),
        )
        assert ax.get_ylabel() == rf"$\mathrm{{{name}}}\,H_\mathrm{{perc}}$ (N/m)"
        assert told(ax) == ["closed form", "from the simulated force"]


# Measured lines


OMEGA = np.arange(1.0, 15.0)


def lines(radius: float, slope: str | None = None, threshold: Any = None) -> hs.MeasuredEvaluation:
    more = {"slope": slope} if slope else {}
    felt = hs.measured(OMEGA, perc(OMEGA), radius=[radius] * len(OMEGA), **more)
    return hs.evaluate(hs.MeasuredScene(STIFF, felt, threshold=hs.Threshold.of(*(threshold or ("0.1", "0.2")))))


@pytest.mark.parametrize("slope", [None, "20 N*s/m"])
def test_measured_ratios_have_bars_as_far_as_their_discs_reach(slope: str | None) -> None:
    e, ax = lines(4.0, slope), axes()
    dots = draw_measured_ratios(ax, e)
    change, radius = (perc(OMEGA) - env(OMEGA)) / np.abs(env(OMEGA)), 4 / np.abs(env(OMEGA))
    parts = ((np.abs(change.real), 0.1, pen.BLUE, "o"), (np.abs(change.imag), 0.2, pen.RED, "s"))
    bars = [c for c in ax.collections if isinstance(c, LineCollection)]
    for (ratio, c, color, mark), bar in zip(parts, bars, strict=True):
        own = [x for x in dots if to_hex(x.get_color()) == color]
        assert {x.get_marker() for x in own} == {mark}
        for line, wanted in zip(own, (np.abs(ratio - c) > radius, np.abs(ratio - c) <= radius), strict=True):
            assert places(line)[0].tolist() == OMEGA[wanted].tolist()
            assert places(line)[1] == pytest.approx(ratio[wanted])
        assert [str(x.get_markerfacecolor()) for x in own] == [color, "white"]
        ends = np.array([s[:, 1] for s in bar.get_segments()])
        top = ax.get_ylim()[1]
        assert ends == pytest.approx(
            np.stack([np.maximum(ratio - radius, 0), np.minimum(ratio + radius, 2 * top)], axis=1)
        )
    levels = {
        str(x.get_label()): (float(x.get_ydata()[0]), x.get_linestyle()) for x in ax.lines if len(x.get_xdata()) == 2
    }
    assert {k: v for k, v in levels.items() if k.startswith("$c")} == {
        r"$c_\mathrm{r} = 0.1$": (0.1, "-"),
        r"$c_\mathrm{i} = 0.2$": (0.2, "--"),
    }
    names = [r"$r_\mathrm{r}$", r"$r_\mathrm{i}$", "unresolved", "95 % disc"]
    assert told(ax) == [*names, *(["swept discs"] if slope else []), r"$c_\mathrm{r} = 0.1$", r"$c_\mathrm{i} = 0.2$"]
    assert ax.get_xlim() == (pytest.approx(1 - 0.39), pytest.approx(14.39))
    assert (ax.get_ylim()[0], ax.get_xlabel(), ax.get_ylabel()) == (
        0,
        r"$\omega$ (rad/s)",
        r"ratio to $|H_\mathrm{env}|$",
    )
    bands = [c for c in ax.collections if c.get_alpha() == 0.16]
    assert [to_hex(c.get_facecolor()[0]) for c in bands] == ([pen.BLUE, pen.RED] if slope else [])
    for band, (ratio, *_) in zip(bands, parts, strict=False):
        vertices = np.concatenate([p.vertices for p in band.get_paths()])
        for w, r, rho in zip(OMEGA, ratio, radius, strict=True):
            here = vertices[np.abs(vertices[:, 0] - w) < 1e-9][:, 1]
            assert (here.min(), here.max()) == (
                pytest.approx(max(0, r - rho), abs=1e-6),
                pytest.approx(r + rho, abs=1e-6),
            )


def test_measured_lines_stand_in_the_plane_with_their_discs_by_what_they_tell() -> None:
    e, ax = lines(4.0), axes()
    curve, *dots = draw_measured_nyquist(ax, e)
    x, y = places(curve)
    assert x + 1j * y == pytest.approx(env(y / 3))
    change, radius = (perc(OMEGA) - env(OMEGA)) / np.abs(env(OMEGA)), 4 / np.abs(env(OMEGA))
    excess = np.stack([np.abs(change.real) - 0.1, np.abs(change.imag) - 0.2])
    above, below = (excess > radius).any(axis=0), (excess < -radius).all(axis=0)
    expected = {
        "exceeds in a part": (pen.RED, above), "unresolved": (pen.GREY, ~above & ~below), "below in both parts": (pen.BLUE, below),
    }  # fmt: skip
    wanted = {k: v for k, v in expected.items() if v[1].any()}
    assert told(ax) == [r"$H_\mathrm{env}$", *wanted]
    discs = [c for c in ax.collections if isinstance(c, PatchCollection)]
    for line, disc, (color, which) in zip(dots, discs, wanted.values(), strict=True):
        own = perc(OMEGA[which])
        assert places(line)[0] + 1j * places(line)[1] == pytest.approx(own)
        assert to_hex(line.get_color()) == to_hex(disc.get_facecolor()[0]) == color
        extents = np.array([p.get_extents().extents for p in disc.get_paths()])
        box = np.stack([own.real - 4, own.imag - 4, own.real + 4, own.imag + 4], axis=1)
        assert extents == pytest.approx(box, abs=1e-3)
    marks = [z for z in ax.lines if z.get_marker() == "|"]
    assert [places(z)[0] + 1j * places(z)[1] for z in marks] == [pytest.approx(env(OMEGA))]
    every = np.concatenate([env(OMEGA), perc(OMEGA)])
    sides = [(v.min() - 4, v.max() + 4) for v in (every.real, every.imag)]
    margin = 0.05 * max(b - a for a, b in sides)
    assert (ax.get_xlim(), ax.get_ylim()) == tuple(
        (pytest.approx(a - margin), pytest.approx(b + margin)) for a, b in sides
    )
    assert (ax.get_xlabel(), ax.get_ylabel()) == (r"$\mathrm{Re}\,H$ (N/m)", r"$\mathrm{Im}\,H$ (N/m)")


def test_changes_of_measured_lines_stand_about_the_border_of_a_region() -> None:
    felt = hs.measured(OMEGA, perc(OMEGA), radius=[4.0] * len(OMEGA))
    circle = hs.Scene(STIFF, (), (0, 15), {"shape": "ellipse", "real": "0.2", "imag": "0.3"}).threshold
    e, ax = hs.evaluate(hs.MeasuredScene(STIFF, felt, threshold=circle)), axes()
    dots = draw_measured_plane(ax, e)
    change = (perc(OMEGA) - env(OMEGA)) / np.abs(env(OMEGA))
    seen = np.concatenate([places(x)[0] + 1j * places(x)[1] for x in dots])
    assert np.sort_complex(seen) == pytest.approx(np.sort_complex(change))
    for line in dots:
        x, y = places(line)
        far = np.hypot(x / 0.2, y / 0.3)
        assert {pen.RED: far.min() > 1, pen.BLUE: far.max() < 1, pen.GREY: True}[to_hex(line.get_color())]
    border = [p.vertices for c in ax.collections for p in c.get_paths() if len(p.vertices) > 200]
    assert np.hypot(border[0][:, 0] / 0.2, border[0][:, 1] / 0.3) == pytest.approx(1, abs=1e-3)
    reach = max(0.2, 1.15 * float(np.quantile(np.abs(change), 0.9)))
    assert (ax.get_xlim(), ax.get_ylim()) == ((pytest.approx(-reach), pytest.approx(reach)),) * 2
    assert told(ax)[-1] == "ellipse"
    assert ax.get_aspect() == 1


# JNDs, regions, requirements, units


def judged(low: float | None, high: float | None, *, fits: bool, alternatives: int | None = None) -> Any:
    """Levels 4 to 6, a curve whose middle is 5, and a JND of 0.5."""
    of = SimpleNamespace
    return of(
        answers=Answers("answers", tuple(Row(4 + 0.5 * i, 4 * i, 20) for i in range(5))),
        fit=of(curve=lambda x: 1 / (1 + np.exp(-4 * (x - 5)))), middle=of(value=5.0), confidence=0.9,
        jnd=of(value=0.5, low=low, high=high), asked=of(alternatives=alternatives, proportion=0.75), deviance=of(fits=fits),
    )  # fmt: skip


def test_the_interval_of_a_jnd_is_a_bar_where_it_has_both_ends() -> None:
    for low, high in ((0.4, 0.7), (None, 0.7), (0.4, None)):
        ax = axes()
        draw_jnd(ax, judged(low, high, fits=True))
        bars = [places(x)[0].tolist() for x in ax.lines if x.get_linewidth() == 3]
        both = low is not None and high is not None
        assert bars == ([[5.4, 5.7]] if both else [])
        assert [x for x in told(ax) if "interval" in x] == (["90 % interval"] if both else [])
        assert "JND at 75 %" in told(ax)
        assert ax.get_xlim() == (pytest.approx(4 - 0.12), pytest.approx(6.12))
        assert (ax.get_ylabel(), list(ax.texts)) == ("share of “more”", [])
    choice = axes()
    draw_jnd(choice, judged(0.4, 0.7, fits=False, alternatives=2))
    assert choice.get_ylabel() == "share of right answers"
    assert [x.get_text() for x in choice.texts] == ["the curve does not fit these answers"]
    assert "subjective equality" not in told(choice)
    assert [places(x)[0].tolist() for x in choice.lines if x.get_linewidth() == 3] == [[0.4, 0.7]]


def test_limits_for_each_way_bound_what_grows_and_what_shrinks() -> None:
    """Noticed: more than 0.4 of the size when a part grows, 0.1 when it shrinks, or the other way round."""
    for tip in ((30.0, 40.0), (-30.0, 40.0), (-30.0, -40.0), (3.0, -40.0), (-24.0, 7.0)):
        for higher, lower in ((0.4, 0.1), (0.1, 0.4), (1.9, 1.5)):
            way = {"higher": str(higher), "lower": str(lower)}
            criteria = noticed(hs.Scene(STIFF, (), (0, 15), {"real": way, "imag": way}).threshold)
            found = outline(criteria, np.array(tip), 1.0, {})
            size = float(np.hypot(*tip))
            for own, stretches in zip(tip, found.stretches, strict=True):
                values = np.linspace(-200, 200, 4001) + 1e-3  # no end lies on one
                limit = np.where(np.abs(values) > abs(own), higher, lower) * size
                inside = np.zeros(values.shape, bool)
                for low, high in stretches:
                    inside |= (values > low) & (values < high)
                assert (inside == (np.abs(values - own) < limit)).all()
            assert len(found.patches) == len(found.stretches[0]) * len(found.stretches[1])
            assert all(isinstance(x, Rectangle) for x in found.patches)


def test_what_is_undecided_of_a_requirement_is_hatched_and_open_intervals_end_with_the_axis() -> None:
    found = hs.require(
        hs.Scene(hs.environments.mass_spring_damper(k=100), (hs.effects.shunt(b=2),), (0, 15), "0.1"), "effects.shunt.b"
    )
    two, nine = ExactNumber(Rational(1)), ExactNumber(Rational(2))
    for undecided in (((None, two),), ((two, nine), (nine, None))):
        ax = axes()
        draw_requirement(ax, replace(found, undecided=undecided))
        low, high = ax.get_xlim()
        hatched = [(x.get_x(), x.get_x() + x.get_width()) for x in ax.patches if x.get_hatch()]
        ends = [(low if a is None else float(a), high if b is None else float(b)) for a, b in undecided]
        assert hatched == [(pytest.approx(a), pytest.approx(b)) for a, b in ends]
        assert told(ax).count("undecided") == 1
    ground = [(x.get_x(), x.get_x() + x.get_width()) for x in ax.patches if to_hex(x.get_facecolor()) == pen.SHADE]
    assert ground == [
        (
            low if s.low.value is None else pytest.approx(float(s.low.value)),
            high if s.high.value is None else pytest.approx(float(s.high.value)),
        )
        for s in found.feasible
    ]


def test_frequencies_are_in_hz_where_they_are_short_there_and_not_in_rad_per_s() -> None:
    for hertz in ([0.5, 12.5], [-3.0, 7.25], [0.0, 100.0]):
        assert floats_scale([2 * np.pi * x for x in hertz]).unit == "Hz"
        assert floats_scale(hertz).unit == "rad/s"
        assert floats_scale([2 * np.pi * hertz[0] or 0.0, 2 * np.pi * hertz[1] + 0.123456789]).unit == "rad/s"
    assert floats_scale([-np.sqrt(2), -np.sqrt(3)]).unit == "rad/s"
