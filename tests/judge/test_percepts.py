"""How: as which property a distortion is felt, as more or less of it, and where the model says nothing."""

from __future__ import annotations

import dataclasses
import json
import random
from collections.abc import Callable, Sequence
from fractions import Fraction
from itertools import pairwise
from typing import Any

import pytest
from answers import floats, intervals
from marks import often
from matplotlib.figure import Figure
from oracles import MP
from pdflatex import set_document
from reports import undrawn
from sympy import Integer, Rational, sqrt

import haptisym as hs
from haptisym import Change, Property
from haptisym.effects import first_order_lag, second_order_lowpass, series, shunt
from haptisym.environments import expression, kelvin_voigt, mass_spring_damper
from haptisym.figures.projections import draw_projections
from haptisym.judge.criteria import kept, noticed
from haptisym.judge.crossings import Curve, find_crossings, unbounded_points
from haptisym.judge.percepts import (
    NOT_NAMED,
    Percept,
    changeovers,
    felt_of,
    felt_words,
    find_felt,
    find_percepts,
    outside_model,
    unnamed,
)
from haptisym.judge.percepts import felt as percept_words
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.roots import Chart, Interval, Point, Signs

PAPER = hs.Scene(
    mass_spring_damper("1.8 kg", "15 N*s/m", "100 N/m"),
    (second_order_lowpass("80 rad/s", 0.5, name="filter"),),
    title="Numerical example",
)


def felt(result: hs.Evaluation, part: str) -> list[tuple[str, str, float, float]]:
    """Property, change and band of the percepts of one part."""
    return [
        (p.property.value, p.change.value, *intervals([p.band])[0]) for p in result.percepts if p.part.value == part
    ]


def ask(environment: hs.Environment, *chain: hs.Effect, high: object = 15, c: object = "0.1") -> hs.Evaluation:
    return hs.evaluate(hs.Scene(environment, chain, (Rational(0), Rational(str(high))), hs.Threshold.of(c)))


def test_the_paper_s_display_feels_lighter_from_8_and_more_damped_from_12() -> None:
    result = hs.evaluate(PAPER)
    [mass], [damping] = felt(result, "real"), felt(result, "imag")
    assert mass == ("mass", "lower", pytest.approx(7.979, abs=5e-4), 15.0)
    assert damping == ("damping", "higher", pytest.approx(11.94, abs=5e-3), 15.0)
    assert mass[2] == float(result.crossings[0].omega)
    assert damping[2] == float(result.crossings[1].omega)
    assert result.outside_model == ()
    assert result.stable is True


def test_the_document_of_the_paper_s_scene_says_the_same() -> None:
    document = json.loads(hs.evaluate(PAPER).to_json())
    real, imag = 7.978916790174708, 11.937310924322058
    assert document["schema"] == "haptisym.evaluation/1"
    assert document["title"] == "Numerical example"
    assert document["band"] == [0.0, 15.0]
    assert document["threshold"] == {"real": "1/10", "imag": "1/10"}
    assert [
        (c["part"], c["omega"], c["digits"], c["kind"], c["sign"], c["multiplicity"]) for c in document["crossings"]
    ] == [("real", real, "7.97891679017471", "exceeds", 1, 1), ("imag", imag, "11.9373109243221", "exceeds", 1, 1)]
    assert document["transparent"] == [[0.0, real]]
    assert document["bandwidth"] == real
    assert document["changeovers"]["environment"] == [float(MP.sqrt(MP.mpf(500) / 9))]
    assert document["changeovers"]["perceived"] == [pytest.approx(7.8794812291942, abs=1e-12)]
    assert document["percepts"] == [
        {"part": "real", "band": [real, 15.0], "property": "mass", "change": "lower"},
        {"part": "imag", "band": [imag, 15.0], "property": "damping", "change": "higher"},
    ]
    assert (document["outside_model"], document["unbounded"]) == ([], [])
    assert (document["stable"], document["certified"]) == (True, True)


def test_half_the_force_of_a_spring_feels_like_less_stiffness() -> None:
    assert felt(ask(mass_spring_damper(k=100), series("1/2")), "real") == [("stiffness", "lower", 0.0, 15.0)]


def test_twice_the_force_of_a_mass_feels_like_more_mass() -> None:
    assert felt(ask(mass_spring_damper(m=2), series("2")), "real") == [("mass", "higher", 0.0, 15.0)]


def test_half_and_twice_the_force_of_a_damper_feel_like_less_and_more_damping() -> None:
    assert felt(ask(mass_spring_damper(b=2), series("1/2")), "imag") == [("damping", "lower", 0.0, 15.0)]
    assert felt(ask(mass_spring_damper(b=2), series("2")), "imag") == [("damping", "higher", 0.0, 15.0)]


def test_a_spring_with_a_mass_before_it_turns_from_less_stiffness_into_mass() -> None:
    # H_perc = 100 - W: noticed from W = 10; mass from 100; more than the spring's 100 from 200
    assert felt(ask(mass_spring_damper(k=100), shunt(m=1)), "real") == [
        ("stiffness", "lower", float(MP.sqrt(10)), 10.0),
        ("stiffness-to-mass", "lower", 10.0, float(MP.sqrt(200))),
        ("stiffness-to-mass", "higher", float(MP.sqrt(200)), 15.0),
    ]


def test_a_mass_beside_a_spring_turns_from_stiffness_into_less_mass() -> None:
    # H_env = -W, H_perc = 1 - W: |1 - W| < W from W = 1/2; mass from 1; unnoticed from 10
    assert felt(ask(mass_spring_damper(m=1), shunt(k=1)), "real") == [
        ("mass-to-stiffness", "higher", 0.0, float(MP.sqrt(0.5))),
        ("mass-to-stiffness", "lower", float(MP.sqrt(0.5)), 1.0),
        ("mass", "lower", 1.0, float(MP.sqrt(10))),
    ]


def test_a_spring_that_leaks_into_the_real_part_of_a_damper_feels_like_stiffness_added() -> None:
    # Re H_env is zero throughout: it takes the side of what is felt; r_r = 2/w
    result = ask(mass_spring_damper(b=1), shunt(k=2))
    assert felt(result, "real") == [("stiffness", "higher", 0.0, 15.0)]


def test_a_damper_turned_into_nothing_is_less_damping_up_to_none() -> None:
    result = ask(mass_spring_damper(b=1), shunt(b=-1, k=1), high=5)
    assert felt(result, "imag") == [("damping", "lower", 0.0, 5.0)]
    assert result.outside_model == ()


def test_no_damping_is_claimed_where_the_display_is_active() -> None:
    # Im H_perc = w(5 - w^2/5): active beyond 5; Im H_env = 5w: noticed where r_i = w^2/25/... exceeds c
    result = ask(mass_spring_damper(b=5), shunt(Z="s^3/5"), high=8)
    # r_i = W/25: noticed from sqrt(2.5); Im H_perc = w (5 - W/5) < 0 beyond 5
    assert felt(result, "imag") == [("damping", "lower", float(MP.sqrt(2.5)), 5.0)]
    assert intervals(result.outside_model) == [(5.0, 8.0)]


def test_a_lag_on_a_spring_is_active_everywhere() -> None:
    result = ask(mass_spring_damper(k=100), first_order_lag(20))
    assert intervals(result.outside_model) == [(0.0, 15.0)]
    assert felt(result, "imag") == []
    assert felt(result, "real") == [("stiffness", "lower", float(Fraction(20, 3)), 15.0)]


def test_a_lag_on_a_spring_and_damper_is_active_while_the_lag_is_the_slower() -> None:
    # Im H_perc has the sign of b w_c - k, at every frequency
    passive = ask(kelvin_voigt(100, "5.1"), first_order_lag(20))
    active = ask(kelvin_voigt(100, "4.9"), first_order_lag(20))
    even = ask(kelvin_voigt(100, 5), first_order_lag(20))
    assert (passive.outside_model, even.outside_model) == ((), ())
    assert intervals(active.outside_model) == [(0.0, 15.0)]


def test_activity_that_vanishes_at_one_frequency_is_two_intervals() -> None:
    # Im H_perc = -w (W - 4)^2
    result = ask(expression("s"), shunt(Z="-s - s*(s^2 + 4)^2"), high=3)
    assert intervals(result.outside_model) == [(0.0, 2.0), (2.0, 3.0)]


def test_an_active_environment_may_be_felt_as_damping() -> None:
    # Im H_env = -w, Im H_perc = 2 w
    result = ask(expression("100 - s"), shunt(b=3), high=20)
    # r_i = 3w/|100 - j w| > 1/10 beyond 900 W = 10^4 + W
    assert felt(result, "imag") == [("damping", "higher", float(MP.sqrt(MP.mpf(10000) / 899)), 20.0)]


def test_percepts_are_split_where_the_ratio_falls_to_the_threshold() -> None:
    # r_r = 1/10 + (W - 4)^2/10^3
    result = ask(mass_spring_damper(k=1), shunt(Z="0.1 + (s^2 + 4)^2/1000"), high=3)
    assert felt(result, "real") == [("stiffness", "higher", 0.0, 2.0), ("stiffness", "higher", 2.0, 3.0)]


def test_percepts_are_not_split_where_the_other_part_crosses() -> None:
    # r_r = 1/2 throughout; r_i crosses 1/10 at 1
    result = ask(mass_spring_damper(k=1), shunt(k="0.5", b="0.1"), high=3)
    assert felt(result, "real") == [("stiffness", "higher", 0.0, 3.0)]
    assert felt(result, "imag") == [("damping", "higher", 1.0, 3.0)]


def test_a_reversed_resonance_trades_stiffness_and_mass() -> None:
    # H_perc = -H: r_r = 2 |100 - W|/|H|, r_i = 4 w/|H|, with |H|^2 = (100 - W)^2 + 4 W
    result = ask(mass_spring_damper(m=1, b=2, k=100), series("-1"))
    # r_r = 1/10 where 399 (100 - W)^2 = 4 W
    low, high = (float(w) for w in sorted(MP.polyroots([399, 0, -79804, 0, 3990000]))[2:])
    assert felt(result, "real") == [
        ("stiffness-to-mass", "equal", 0.0, pytest.approx(low, rel=1e-14)),
        ("mass-to-stiffness", "equal", pytest.approx(high, rel=1e-14), 15.0),
    ]
    assert felt(result, "imag") == []


# --- changeovers -----------------------------------------------------------------------------------------------------


def test_a_changeover_is_a_change_of_sign() -> None:
    # Re H = (1 - W)^2: touches zero at 1
    touching = ask(expression("(s^2 + 1)^2"))
    assert touching.changeovers_environment == ()
    crossing = ask(expression("(s^2 + 1)^3*(s^2 + 9)"))
    assert floats(crossing.changeovers_environment) == [1.0, 3.0]


def test_a_two_mass_environment_goes_from_spring_to_inertia_and_back_through_its_antiresonance() -> None:
    # H = -W + 100 (-W)/(100 - W) + 50: Re H = 0 where W^2 - 250 W + 5000 = 0, and a pole at 10
    environment = hs.environments.two_mass(1, 0, 50, 1, 0, 100)
    zeros = [float(MP.sqrt(125 - z * MP.sqrt(10625))) for z in (1, -1)]
    assert floats(ask(environment, high=20).changeovers_environment) == [zeros[0], 10.0, zeros[1]]


def test_changeovers_at_the_ends_of_the_band_count() -> None:
    scene = hs.Scene(mass_spring_damper(m=1, b=1, k=49), (), (Rational(7), Rational(9)))
    assert floats(hs.evaluate(scene).changeovers_environment) == [7.0]
    assert floats(hs.evaluate(scene.with_band(1, 7)).changeovers_environment) == [7.0]
    assert floats(hs.evaluate(scene.with_band(8, 9)).changeovers_environment) == []


def test_an_environment_that_is_zero_at_rest_changes_over_nowhere() -> None:
    assert ask(mass_spring_damper(m=1, b=1)).changeovers_environment == ()


# --- what is rendered ------------------------------------------------------------------------------------------------


def test_the_distortion_of_what_is_rendered_compares_with_the_environment() -> None:
    # rendered with half the damping: Re dH = 0 and Im dH = -b w/2
    scene = hs.Scene(kelvin_voigt(100, 10), (), (Rational(0), Rational(15)), rendered=kelvin_voigt(100, 5))
    result = hs.evaluate(scene)
    # 5 w = |100 + 10 j w|/10 at 2500 W = 100 + W
    assert felt(result, "real") == []
    assert felt(result, "imag") == [("damping", "lower", float(MP.sqrt(MP.mpf(100) / 24)), 15.0)]


def test_effects_act_on_what_is_rendered() -> None:
    scene = hs.Scene(mass_spring_damper(k=100), (series("1/2"),), rendered=mass_spring_damper(k=200))
    result = hs.evaluate(scene)
    assert (result.crossings, result.percepts) == ((), ())


# --- charts of any signs ---------------------------------------------------------------------------------------------

JND = dict(zip(hs.Part, noticed(hs.Threshold()), strict=True))
FELT = {
    (1, 1): "stiffness", (-1, -1): "mass", (1, -1): "stiffness-to-mass", (-1, 1): "mass-to-stiffness",
    (0, 1): "stiffness", (1, 0): "stiffness", (0, -1): "mass", (-1, 0): "mass",
}  # fmt: skip


def any_chart(seed: int) -> Chart:
    """Up to nine points with signs drawn for each cell; some repeat, so that there is something to join."""
    pick = random.Random(seed)
    keys = [*JND.values(), *((curve, part) for curve in Curve for part in hs.Part)]
    cells: list[dict[object, int]] = []
    for _ in range(pick.randint(1, 8)):
        fresh = {key: pick.choice((-1, 0, 1)) for key in keys}
        cell = dict(cells[-1]) if cells and pick.random() < 0.6 else fresh
        for part in hs.Part:
            if pick.random() < 0.5:
                cell[JND[part]] = 1
            if not cell[Curve.ENVIRONMENT, part] and not cell[Curve.PERCEIVED, part]:
                cell[JND[part]] = -1  # what is zero throughout in both is not noticed
        cells.append(cell)
    points = []
    for n, (before, after) in enumerate(pairwise([cells[0], *cells, cells[-1]])):
        orders = {key: pick.choice((2, 2, -2, 0)) for key in keys if before[key] == after[key] and pick.random() < 0.4}
        points.append(Point(ExactNumber(Integer(n)), {k: n for k, n in orders.items() if n}, before, after))
    return Chart(tuple(points))


@pytest.mark.parametrize("seed", range(150))
def test_percepts_cover_exactly_the_cells_above_and_are_joined_where_nothing_changes(seed: int) -> None:
    chart = any_chart(seed)
    found = find_percepts(chart)
    assert [p.part for p in found] == sorted((p.part for p in found), key=list(hs.Part).index)
    for part in hs.Part:
        own = [p for p in found if p.part is part]
        bands = [(int(float(p.band.low.omega)), int(float(p.band.high.omega))) for p in own]
        told = {
            n: (i, p.property.value, p.change.value)
            for i, (p, (a, b)) in enumerate(zip(own, bands, strict=True))
            for n in range(a, b)
        }
        assert sum(b - a for a, b in bands) == len(told)
        labels = {}
        for n, point in enumerate(chart.points[:-1]):
            signs = {curve: point.after[curve, part] for curve in Curve}
            if point.after[JND[part]] <= 0 or (part is hs.Part.IMAG and signs[Curve.PERCEIVED] < 0):
                continue
            kind = "damping" if part is hs.Part.IMAG else FELT[signs[Curve.ENVIRONMENT], signs[Curve.PERCEIVED]]
            larger = signs[Curve.DIFFERENCE] * signs[Curve.SUM]  # of |perc|^2 - |env|^2
            labels[n] = (kind, {1: "higher", -1: "lower", 0: "equal"}[larger])
        assert {n: x[1:] for n, x in told.items()} == labels
        for n in labels:
            if n + 1 in labels:
                at = chart.points[n + 1].orders.get(JND[part], 0)
                assert (told[n][0] == told[n + 1][0]) == (labels[n] == labels[n + 1] and at <= 0)


@pytest.mark.parametrize("seed", range(60))
def test_what_is_transparent_active_or_unbounded_is_read_off_the_signs_of_every_cell_and_point(seed: int) -> None:
    chart = any_chart(seed)

    def spans(test: Callable[[Signs], bool]) -> list[tuple[int, int]]:
        """Runs of what passes among point 0, cell 0, point 1, cell 1, ...: numbers of the points they begin and end with."""
        row = [test(x) for point in chart.points for x in (point.at, point.after)][:-1]
        ends = [n for n in range(len(row) + 1) if (n > 0 and row[n - 1]) != (n < len(row) and row[n])]
        return [(a // 2, b // 2) for a, b in zip(ends[::2], ends[1::2], strict=True)]

    def told(found: tuple[Interval, ...]) -> list[tuple[int, int]]:
        return [(int(float(x.low.omega)), int(float(x.high.omega))) for x in found]

    assert told(kept(chart)) == spans(lambda s: max(s[x] for x in JND.values()) <= 0)
    assert told(outside_model(chart)) == spans(lambda s: s[Curve.PERCEIVED, hs.Part.IMAG] < 0)
    infinite = [p for p in chart.points if min(p.orders.get(JND[part], 0) for part in hs.Part) < 0]
    assert list(unbounded_points(chart)) == infinite
    for curve in (Curve.ENVIRONMENT, Curve.PERCEIVED):
        signs = [(p.before[curve, hs.Part.REAL], p.after[curve, hs.Part.REAL]) for p in chart.points]
        changed = [p for p, pair in zip(chart.points, signs, strict=True) if set(pair) == {1, -1}]
        assert list(changeovers(chart, curve)) == changed


@pytest.mark.parametrize("part", hs.Part)
@pytest.mark.parametrize("omega", [0, 3])
@pytest.mark.parametrize("signs", [(a, b) for a in (-1, 1) for b in (-1, 1)])
def test_a_crossing_is_named_by_the_signs_beside_it(part: hs.Part, omega: int, signs: tuple[int, int]) -> None:
    """At rest, below which there is nothing, a ratio above it exceeds and one below it touches."""
    other = next(p for p in hs.Part if p is not part)
    (before, after), quiet = (
        signs,
        dict.fromkeys([*JND.values(), *((curve, p) for curve in Curve for p in hs.Part)], -1),
    )
    for order in (1, 2, 3):
        for difference in (-1, 1):
            orders = {JND[part]: order, (Curve.ENVIRONMENT, other): 4, JND[other]: -2}
            point = Point(
                ExactNumber(Integer(omega)),
                orders,
                {**quiet, JND[part]: before},
                {**quiet, JND[part]: after, (Curve.DIFFERENCE, part): difference},
            )
            [found] = find_crossings(Chart((point,)))
            kinds = {
                (-1, 1): "exceeds",
                (1, -1): "returns",
                (-1, -1): "touches",
                (1, 1): "touches" if omega else "exceeds",
            }
            assert (found.part, found.sign, found.multiplicity) == (part, difference, order)
            assert found.kind.value == kinds[signs]
            open_ = dataclasses.replace(point, undecided=frozenset({JND[part]}))
            assert find_crossings(Chart((open_,))) == ()
            beside = dataclasses.replace(point, undecided=frozenset({JND[other], (Curve.ENVIRONMENT, part)}))
            assert find_crossings(Chart((beside,))) == (found,)


def test_an_irrational_threshold_splits_percepts_where_it_says() -> None:
    """A spring of 1 with a mass before it: r_r = W, compared with the golden section, whose square is irrational too."""
    result = hs.evaluate(hs.Scene(mass_spring_damper(k=1), (shunt(m=1),), (0, 3), hs.Threshold((sqrt(5) - 1) / 2, 1)))
    edge, double = float(MP.sqrt((MP.sqrt(5) - 1) / 2)), float(MP.sqrt(2))
    assert felt(result, "real") == [
        ("stiffness", "lower", edge, 1.0),
        ("stiffness-to-mass", "lower", 1.0, double),
        ("stiffness-to-mass", "higher", double, 3.0),
    ]


SPRING_BEHIND_DELAY = hs.Scene(mass_spring_damper(k=100), (hs.effects.delay("0.1 s"),), (0, 50))
"""H_perc = 100 exp(-0.1 j omega): Im H_perc = -100 sin(omega/10) < 0 up to 10 pi rad/s, and noticed from 10 asin(0.1) on."""


def test_what_is_noticed_while_the_display_is_active_is_told_without_a_name() -> None:
    result = hs.evaluate(SPRING_BEHIND_DELAY)
    start, end = 10 * MP.asin(MP.mpf("0.1")), 10 * MP.pi
    # r_i falls below 10 % shortly before the half turn, so that nothing is noticed from there to the half turn
    [unnamed] = [(float(x.low.omega), float(x.high.omega)) for x in result.unnamed]
    assert unnamed == (pytest.approx(float(start), rel=1e-15), pytest.approx(float(end - start), rel=1e-15))
    assert result.to_dict()["unnamed"] == [list(unnamed)]
    told = [(x.part.value, float(x.band.low.omega), x.words) for x in result.felt]
    assert ("imag", unnamed[0], NOT_NAMED) in told
    assert [x for x in told if x[2] != NOT_NAMED] == [
        (p.part.value, float(p.band.low.omega), percept_words(p)) for p in result.percepts
    ]


def test_an_active_display_that_is_not_noticed_has_nothing_without_a_name() -> None:
    """H_perc = 100 - 5 j omega: active everywhere, but less than 10 % of |H_env| up to 2 rad/s."""
    scene = hs.Scene(mass_spring_damper(k=100), (hs.effects.shunt(b=-5),), (0, "19/10"))
    result = hs.evaluate(scene)
    assert (len(result.outside_model), result.unnamed, result.felt) == (1, (), ())
    assert "from 0 to 1.9 rad/s, but not noticed there: the display is active" in " ".join(str(result).split())


@pytest.mark.parametrize(
    ("given", "change", "words"),
    [
        (Property.MASS, Change.LOWER, "lower mass"),
        (Property.STIFFNESS, Change.HIGHER, "higher stiffness"),
        (Property.DAMPING, Change.EQUAL, "equal damping"),
        (Property.STIFFNESS_TO_MASS, Change.EQUAL, "mass instead of stiffness, with equal force"),
        (Property.MASS_TO_STIFFNESS, Change.HIGHER, "stiffness instead of mass, with higher force"),
    ],
)
def test_the_words_for_a_percept(given: Property, change: Change, words: str) -> None:
    [percept, *_] = hs.evaluate("fu2019").percepts
    assert percept_words(dataclasses.replace(percept, property=given, change=change)) == words


EXCHANGED = hs.Scene(mass_spring_damper(m=1, k=100), (hs.effects.series("-1"),), (0, 15))


@pytest.mark.slow
@pytest.mark.parametrize(
    "scene",
    often(["fu2019", SPRING_BEHIND_DELAY, EXCHANGED, "undamped-resonance"], lambda x: x == "fu2019"),
    ids=range(4),
)
def test_a_percept_has_the_same_words_in_text_page_notebook_latex_and_figure(scene: hs.Scene | str) -> None:
    result = hs.evaluate(scene)
    assert result.felt
    for part in hs.Part:
        ax = Figure().add_subplot()
        draw_projections(ax, result, part)
        legend = ax.get_legend()
        assert legend is not None
        drawn = {x.get_text().replace("\n", " ") for x in [*ax.texts, *legend.get_texts()]}
        assert {x.words for x in result.felt if x.part is part} <= drawn
    whole = str(result), undrawn(result), result._repr_html_(), set_document(result)  # type: ignore[attr-defined]
    for text in (*whole, hs.latex(result)):
        assert all(row.words in text for row in result.felt)
    for text in whole:
        said = "no property is named for what is noticed there" in " ".join(text.split())
        assert said == bool(result.unnamed)


def test_a_table_is_never_empty_without_a_word() -> None:
    """Where something is noticed every output names it, or says that it has no name; where nothing is, that."""
    silent = hs.Scene(mass_spring_damper(k=100), (hs.effects.delay("0.1 s"),), (1.1, 4))
    result = hs.evaluate(silent)
    assert result.percepts == ()
    assert NOT_NAMED in str(result)
    nothing = hs.evaluate(hs.Scene(mass_spring_damper(k=100), (), (0, 15)))
    for text in (str(nothing), undrawn(nothing), set_document(nothing)):
        assert "Nothing is noticed on the band: neither ratio exceeds its threshold" in text


# --- in words --------------------------------------------------------------------------------------------------------


def test_percepts_are_told_in_the_words_of_what_is_felt() -> None:
    words = {
        ("stiffness", "higher"): "higher stiffness", ("mass", "lower"): "lower mass", ("damping", "equal"): "equal damping",
        ("stiffness-to-mass", "equal"): "mass instead of stiffness, with equal force",
        ("mass-to-stiffness", "higher"): "stiffness instead of mass, with higher force",
    }  # fmt: skip
    ends = [Point(ExactNumber(Integer(n)), {}, {}, {}) for n in (2, 3)]
    for (kind, change), expected in words.items():
        percept = Percept(hs.Part.REAL, Interval(*ends), Property(kind), Change(change))
        assert percept_words(percept) == expected
        assert repr(percept) == f"<Percept {expected} (real part) from 2.0000 to 3.0000 rad/s>"


def test_of_what_is_noticed_of_both_parts_together_each_part_has_its_words() -> None:
    ends = [Point(ExactNumber(Integer(n)), {}, {}, {}) for n in (2, 3)]
    mass, damping = (Property.MASS, Change.LOWER), (Property.DAMPING, Change.HIGHER)
    for own, other in ((mass, damping), (damping, mass)):
        both = Percept(None, Interval(*ends), *own, other)
        assert (felt_of(both, hs.Part.REAL), felt_of(both, hs.Part.IMAG)) == ("lower mass", "higher damping")
        words = f"{felt_words(*other)} and {felt_words(*own)}"
        assert repr(both) == f"<Percept {words} (both parts together) from 2.0000 to 3.0000 rad/s>"
    assert felt_of(Percept(hs.Part.REAL, Interval(*ends), *mass), hs.Part.REAL) == "lower mass"


@pytest.mark.parametrize("seed", range(60))
def test_all_that_is_noticed_has_its_words_part_by_part_in_order(seed: int) -> None:
    chart = any_chart(seed)

    def spans(found: Sequence[Any]) -> list[tuple[float, float]]:
        return [(float(x.low.omega), float(x.high.omega)) for x in found]

    def active(signs: Signs) -> bool:
        return signs[JND[hs.Part.IMAG]] == 1 and signs[Curve.PERCEIVED, hs.Part.IMAG] == -1

    without_name = unnamed(chart)
    assert without_name == chart.where(active)
    cells = [active(p.after) for p in chart.points[:-1]]
    assert all(any(a <= n + 0.5 <= b for a, b in spans(without_name)) == cell for n, cell in enumerate(cells))
    rows = find_felt(chart)
    for part in hs.Part:
        own = [row for row in rows if row.part is part]
        named = [(percept_words(p), p.band) for p in find_percepts(chart) if p.part is part]
        if part is hs.Part.IMAG:
            named += [(NOT_NAMED, band) for band in without_name]
        assert sorted(spans([row.band for row in own])) == spans([row.band for row in own])
        told = [(row.words, *spans([row.band])) for row in own]
        assert sorted(told) == sorted((words, *spans([band])) for words, band in named)
    assert [row.part for row in rows] == sorted((row.part for row in rows), key=list(hs.Part).index)


def test_the_document_has_what_is_noticed_without_a_name_where_there_is_some() -> None:
    active = ask(mass_spring_damper(b=5), shunt(Z="s^3/5"), high=8)
    assert active.to_dict()["unnamed"] == [[5.0, 8.0]]
    assert active.to_dict()["outside_model"] == [[5.0, 8.0]]
    assert [row.words for row in active.felt] == ["lower damping", NOT_NAMED]
    quiet = ask(mass_spring_damper(b=5), shunt(Z="s^3/5"), high=8, c=10)
    assert "unnamed" not in quiet.to_dict()
    assert quiet.to_dict()["outside_model"] == [[5.0, 8.0]]
