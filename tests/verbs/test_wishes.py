"""What is asked together: transparent, stable in a hand, fit for every passive hand; against scans and closed forms."""

from __future__ import annotations

import json
from itertools import pairwise
from math import asin
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from marks import examples
from sympy import Rational

import haptisym as hs
from haptisym.judge.criteria import noticed
from haptisym.judge.passivity import passivity
from haptisym.kernel.budget import limited
from haptisym.kernel.reals import ExactNumber
from haptisym.pages.require import page
from haptisym.verbs.require import nearest
from haptisym.verbs.require.classical import lines
from haptisym.verbs.require.feasible import End, Solved, Span
from haptisym.verbs.require.freeparameter import Domain
from haptisym.verbs.require.verdicts import together
from haptisym.verbs.require.wishes import WISHES
from haptisym.writing.document import Figure
from haptisym.writing.html import phrase


def put(scene: hs.Scene, values: dict[str, object]) -> hs.Scene:
    """The scene with other values at some paths."""
    for path, value in values.items():
        scene = scene.knobs[path].put(scene, value)  # type: ignore[arg-type]
    return scene


POSTURAL = "postural-arm"  # 0.554 kg, 6.45 N s/m, 135 N/m


def ends(r: hs.Requirement) -> list[tuple[float | None, float | None]]:
    return [tuple(None if x.value is None else float(x.value) for x in (y.low, y.high)) for y in r.feasible]  # type: ignore[misc]


def test_a_delayed_spring_is_stable_in_the_published_hand_up_to_the_known_stiffness() -> None:
    r = hs.require("delayed-spring", "environment.k", (1, 1000), that=["stable"], hand=POSTURAL)
    [span] = r.feasible
    assert span.high.value is not None
    assert span.high.value.digits(14) == "199.85210225871"
    assert not span.high.closed
    [binding] = span.high.bindings
    assert binding.omega is not None
    assert binding.omega.digits(14) == "22.244306341606"
    assert r.certified
    row = json.loads(r.to_json())
    assert row["criteria"] == ["stable"]
    assert row["binding"][0]["criterion"] == "stable"
    assert row["binding"][0]["kind"] == "axis"
    assert "The display is stable in postural-arm exactly for 1 ≤ k < 199.85 N/m" in " ".join(str(r).split())


@pytest.mark.parametrize(
    ("k", "b"), [(0, 3.4635997327677037), (100, 3.329749753286228), (500, 2.81972833105523), (1000, 2.238659408552519)]
)
def test_the_damping_that_a_hand_needs_is_the_known_one(k: int, b: float) -> None:
    hand = hs.Hand("own", m="0.5 kg", k=k)
    r = hs.require("delayed-spring", "hand.b", that="stable", hand=hand)
    assert ends(r) == [(pytest.approx(b, rel=1e-14), None)]
    assert r.certified


@pytest.mark.slow
def test_a_delay_has_islands_of_stability_and_a_simulation_agrees() -> None:
    r = hs.require("delayed-spring", "tau", ("1 ms", "0.6 s"), that="stable", hand=POSTURAL)
    found = ends(r)
    assert len(found) == 2
    for tau, inside in ((0.1, True), (0.105, False), (0.22, False), (0.23, True)):
        assert inside is any(low <= tau <= high for low, high in found if low is not None and high is not None)
        run = hs.release(
            put(hs.load_scene("delayed-spring"), {"effects.delay.tau": Rational(str(tau))}), "1 cm", POSTURAL
        )
        assert run.grows is not inside


@pytest.mark.slow
def test_two_things_asked_together_hold_where_each_holds() -> None:
    both = hs.require("delayed-spring", "environment.k", (1, 1000), that=["transparent", "stable"], hand=POSTURAL)
    assert ends(both) == []  # the delay is noticed whatever the stiffness
    slow = hs.load_scene("delayed-spring").with_band(0, 2)
    both = hs.require(slow, "tau", ("1 ms", "0.2 s"), that=["stable", "transparent"], hand=POSTURAL)
    [(_, high)] = ends(both)
    assert high == pytest.approx(asin(0.1) / 2)  # what is noticed comes first
    assert both.that == ("transparent", "stable")
    assert both.feasible[0].high.bindings[0].criterion.name == "imag"
    stiff = put(slow, {"environment.k": 2000})
    both = hs.require(stiff, "tau", ("1 ms", "0.2 s"), that=["stable", "transparent"], hand=POSTURAL)
    assert both.feasible[0].high.bindings[0].criterion.name == "stable"  # of a stiff wall it is stability
    [(_, alone)] = ends(hs.require(stiff, "tau", ("1 ms", "0.2 s"), that="stable", hand=POSTURAL))
    assert ends(both)[0][1] == alone


LAGGED = hs.Scene(
    hs.environments.mass_spring_damper(k=300, b=2),
    (hs.effects.first_order_lag(200), hs.effects.shunt(m="0.1 kg", b="0.5 N*s/m")),
)


def test_every_passive_hand_may_hold_a_lagging_spring_if_its_dampers_make_up_for_the_lag() -> None:
    """(300 + 2 s) w/(s + w) + 0.1 s^2 + 0.5 s: Im/omega is 2.5 - 300/w at 0, and larger above."""
    r = hs.require(LAGGED, "omega_c", that="passive")
    assert ends(r) == [(120.0, None)]
    assert r.feasible[0].low.closed
    assert r.certified
    assert "fit for every passive hand exactly for" in str(r)


def test_ends_that_are_no_fractions_belong_to_what_suits_every_passive_hand() -> None:
    """With a^2 for the stiffness Im/omega is 2.5 - a^2/200 at 0, and larger above: -10 sqrt 5 <= a <= 10 sqrt 5."""
    squared = hs.environments.expression("a^2 + 2*s", parameters={"a": 10})
    r = hs.require(hs.Scene(squared, LAGGED.effects), "a", that="passive")
    assert ends(r) == [(pytest.approx(-(500**0.5)), pytest.approx(500**0.5))]
    [span] = r.feasible
    assert (span.low.closed, span.high.closed) == (True, True)


def test_the_papers_filter_suits_every_passive_hand_from_a_frequency_on() -> None:
    assert ends(hs.require("fu2019", "omega_n", that="passive")) == [(pytest.approx(25 / 3), None)]
    together = hs.require("fu2019", "omega_n", that=["passive", "stable", "transparent"], hand=POSTURAL)
    assert ends(together) == ends(hs.require("fu2019", "omega_n"))
    assert together.that == ("transparent", "stable", "passive")


@pytest.mark.slow
@examples(12)
@given(
    k=st.integers(10, 400),
    b=st.integers(0, 10),
    own=st.fractions(0, 3, max_denominator=10),
    m=st.fractions(0, 1, max_denominator=10),
)
def test_verdicts_between_the_ends_are_those_of_each_scene(k: int, b: int, own: Rational, m: Rational) -> None:
    scene = hs.Scene(
        hs.environments.mass_spring_damper(k=k, b=b),
        (hs.effects.first_order_lag(50), hs.effects.shunt(m=str(float(m)), b=str(float(own)))),
    )
    passive = ends(hs.require(scene, "omega_c", (5, 500), that="passive"))
    hand = hs.Hand("own", m="0.2 kg", b="0.5 N*s/m")
    stable = ends(hs.require(scene, "omega_c", (5, 500), that="stable", hand=hand))
    for x in np.linspace(6.25, 499.5, 7):
        at = put(scene, {"omega_c": Rational(str(x))})
        for found, answer in ((passive, passivity(at).holds), (stable, hs.stability(at, hand).held[0].stable)):
            assert answer is any((low or 0) < x < (high or 1e9) for low, high in found)


def test_roots_of_the_characteristic_function_lie_on_the_axis_at_an_end() -> None:
    r = hs.require("zener-tissue", "omega_c", that="stable", hand=hs.Hand("light", m="0.1 kg", b="0.1 N*s/m"))
    [span] = r.feasible
    [binding] = span.low.bindings
    assert span.low.value is not None
    assert binding.omega is not None
    at = put(hs.load_scene("zener-tissue"), {"omega_c": Rational(span.low.value.digits(40))})
    values = at.distortion().perc
    H = mpmath.mpc(0)
    from sympy import lambdify

    with mpmath.workdps(40):
        w = mpmath.mpf(binding.omega.digits(40))
        H = lambdify(hs.s, values.expression(), "mpmath")(1j * w)
        assert abs(H - 0.1 * w**2 + 0.1j * w) < 1e-12 * abs(H)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("require fu2019 --free omega_n --that stable", "asked of it in a hand: --hand NAME"),
        ("require fu2019 --free omega_n --that stable --hand nobody", 'there is no hand "nobody"'),
        ("require fu2019 --free omega_n --that pretty", "pretty"),
        ("require fu2019 --free omega_n --hand light-touch", "it needs --that"),
    ],
)
def test_what_cannot_be_asked_is_said_in_one_sentence(call, words: str, said: str) -> None:  # type: ignore[no-untyped-def]
    status, out, err = call(*words.split())
    assert (status, out) == (2, "")
    assert said in " ".join(err.split())


def test_a_word_that_is_none_of_those_that_can_be_asked_is_named() -> None:
    with pytest.raises(hs.HaptisymError, match='"stabel" is none of transparent, stable, passive'):
        hs.require("fu2019", "omega_n", that=["stabel"])


def wall(T: str = "1 ms", delay: int = 0, B: object = 0) -> hs.Scene:
    """A virtual wall that a clock renders on a device of 0.04 kg and 0.8 N s/m."""
    loop = hs.effects.sampled_loop(T=T, method="backward-difference", delay=delay)
    device = hs.effects.shunt(m="0.04 kg", b="0.8 N*s/m", name="device")
    return hs.Scene(hs.environments.mass_spring_damper(k=1000, b=B), (loop, device), ("0 Hz", "10 Hz"))


NOTHING = hs.Hand("nothing")


@pytest.mark.few(3)
@pytest.mark.parametrize(
    ("scene", "hand", "stiffest"),
    [
        (wall(), NOTHING, 1605.35113477512),
        (wall(delay=1), NOTHING, 536.278559788946),
        (wall(T="5 ms"), NOTHING, 325.422809758905),
        (wall(), hs.Hand("firm", b=8, k=400), 18284.7872144337),
        (wall(B="0.4"), NOTHING, 2384.3034697805),
    ],
    ids=["free", "late", "slow", "held", "damped"],
)
def test_with_a_clock_the_stiffest_wall_is_the_known_one(scene: hs.Scene, hand: hs.Hand, stiffest: float) -> None:
    r = hs.require(scene, "environment.k", (1, 30_000), that="stable", hand=hand)
    assert r.certified
    assert ends(r) == [(1, pytest.approx(stiffest, rel=1e-13))]
    assert r.feasible[0].high.bindings[0].kind.value == "axis"


def test_with_a_clock_every_passive_hand_is_left_open_and_said_to_be() -> None:
    r = hs.require("sampled-wall", "environment.k", (1, 1000), that="passive")
    assert not r.certified
    assert "UNDECIDED" in str(r)


def test_samples_of_computation_are_counted_as_delay() -> None:
    """One sample late: K < 0.8/(0.5 ms + 1 ms), and Colgate and Schenkel's bound, which knows no delay, is not offered."""
    late = wall(delay=1)
    [line] = lines(late, [late.knobs[x] for x in ("environment.k", "effects.device.b")])
    assert -line.excess({"environment.k": 0.0, "effects.device.b": 0.8}) == pytest.approx(533.333, rel=1e-5)
    assert line.name == "Gil and Hulin"


@pytest.mark.slow
def test_a_sampled_wall_has_both_classical_lines_beside_the_exact_set() -> None:
    """Colgate's bound is safe; to first order Gil and Hulin's is exact, and not safe with much virtual damping."""
    free = ["effects.device.b", "environment.k"]
    found = hs.design_map(wall(), free, [("0.4", "1.2"), (1, 4000)], that=["stable"], hand=NOTHING, slices=3)
    assert [x.name for x in found.lines] == ["Gil and Hulin", "Colgate and Schenkel"]
    for x in found.slices:
        [(_, high)] = ends(x.requirement)
        assert high is not None
        assert 1 < high / (2000 * float(x.at)) < 1.006


def test_the_trade_off_of_a_late_spring_in_a_damped_hand() -> None:
    """Stable whatever mass and stiffness the hand has only if tau <= b/K: then nothing is noticed up to asin(c) K/b at least."""
    K, b = 100, Rational("5.5")
    scene = put(hs.load_scene("delayed-spring"), {"environment.k": K, "effects.delay.tau": b / K})
    found = passivity(scene).damping
    assert found is not None
    assert float(found.value) == pytest.approx(float(b))
    width = hs.evaluate(scene.with_band(0, 10)).bandwidth
    assert width is not None
    assert float(width) == pytest.approx(1.82122583930108720628, rel=1e-14)


FILTERED = hs.Scene(
    hs.environments.mass_spring_damper(k=300, b=1),
    (hs.effects.first_order_lag(300), hs.effects.shunt(m="0.04 kg", b="0.8 N*s/m")),
    (0, 10),
    hands=(hs.Hand("own", m="0.1 kg", b="0.2 N*s/m"),),
)


@pytest.mark.slow
def test_a_map_of_several_things_has_each_set_and_what_they_have_in_common() -> None:
    found = hs.design_map(
        FILTERED,
        ["omega_c", "environment.k"],
        [(100, 400), (10, 1000)],
        that=["transparent", "stable", "passive"],
        slices=4,
    )
    assert found.that == ("transparent", "stable", "passive")
    for x in found.slices:
        w = float(x.at)
        one, held, every = (ends(y) for y in x.apart)
        # (k + s) w/(s + w) + 0.04 s^2 + 0.8 s: Im/omega at 0 is 1.8 - k/w
        assert every == [(10, pytest.approx(1.8 * w))]
        # with the hand 0.14 s^3 + (1 + 0.14 w) s^2 + 2 w s + k w: Routh
        assert held == [(10, pytest.approx((1 + 0.14 * w) * 2 / 0.14))]
        assert ends(x.requirement) == [(one[0][0], every[0][1])]
        assert {b.criterion.name for e in x.requirement.ends for b in e.bindings} == {"imag", "passive"}
    row = json.loads(found.to_json())
    assert row["criteria"] == ["transparent", "stable", "passive"]
    assert set(row["slices"][0]["apart"]) == set(row["criteria"])
    assert found.lines == ()  # a filter is in neither classical bound


@pytest.mark.slow
def test_a_map_of_a_late_wall_has_the_classical_line_beside_the_exact_set(tmp_path: Path) -> None:
    found = hs.design_map(
        "delayed-spring",
        ["tau", "environment.k"],
        [("20 ms", "40 ms"), (10, 1000)],
        that=["stable"],
        hand=POSTURAL,
        slices=3,
    )
    [line] = found.lines
    assert line.name == "Gil and Hulin"
    for x in found.slices:
        [(_, high)] = ends(x.requirement)
        assert high is not None
        linear = 6.45 / float(x.at)
        assert line.excess({"effects.delay.tau": float(x.at), "environment.k": linear}) == pytest.approx(0, abs=1e-9)
        assert 1 < high / linear < 1.2  # to first order in tau, on the safe side here
    found.save_figure(tmp_path / "map.svg")
    text = (tmp_path / "map.svg").read_text(encoding="utf-8")
    assert text.startswith("<?xml")
    assert "Gil and Hulin" in " ".join(str(found).split())


@pytest.mark.parametrize("that", [["stable"], ["passive"], ["transparent", "stable", "passive"]])
def test_what_time_does_not_last_for_is_undecided(that: list[str]) -> None:
    for scene in (FILTERED, wall()):
        r = hs.require(
            scene, "environment.k", (1, 1000), that=that, hand=NOTHING if "stable" in that else None, limit=1e-9
        )
        assert (r.feasible, r.certified) == ((), False)
    few = hs.design_map(FILTERED, ["omega_c", "environment.k"], [(100, 400), (1, 9)], that=that, slices=3, limit=1e-9)
    assert not few.certified


def test_both_classical_lines_are_those_of_the_field() -> None:
    """b = 0.8, T = 1 ms: K < 1600 by both; a hand of 8 N s/m: 17600 by the linear one alone."""
    wall = hs.Scene(
        hs.environments.mass_spring_damper(k=1000),
        (hs.effects.zero_order_hold("1 ms"), hs.effects.shunt(m="0.04 kg", b="0.8 N*s/m")),
    )
    free = [wall.knobs[x] for x in ("environment.k", "effects.shunt.b")]
    for scene, linear in ((wall, 1600), (wall.with_hands(hs.Hand("firm", b=8, k=400)), 17600)):
        found = {x.name: x for x in lines(scene, free)}
        at = {"environment.k": 0.0, "effects.shunt.b": 0.8}
        assert -found["Gil and Hulin"].excess(at) == pytest.approx(linear)
        assert -found["Colgate and Schenkel"].excess(at) == pytest.approx(1600)


@pytest.mark.parametrize("that", ["stable", "passive"])
def test_a_value_at_which_there_is_no_dynamics_will_not_do(that: str) -> None:
    """k w/(s + w)/w has no value at w = 0, which the model of a formula does not exclude."""
    lag = hs.effects.series("1/(s/w + 1)", parameters={"w": 30})
    scene = hs.Scene(hs.environments.kelvin_voigt(100, 20), (lag,))
    r = hs.require(scene, "w", (0, 100), that=that, hand=POSTURAL if that == "stable" else None)
    assert r.certified
    assert r.feasible
    assert not (r.feasible[0].low.closed and float(r.feasible[0].low.value) == 0)  # type: ignore[arg-type]


def test_sets_are_put_together_even_where_the_time_is_over() -> None:
    wall = hs.load_scene("virtual-wall").with_values({"environment.b": 20})
    found = [hs.require(wall, "environment.k", (10, 4000), that=[x], hand="postural-arm") for x in WISHES[:2]]
    with limited(1e-9):
        both = together(found[0].domain, [Solved(x.feasible, x.undecided) for x in found])
    assert both.undecided == ()
    assert [float(x.high.value) for x in both.feasible if x.high.value] == pytest.approx([1819.838985492319])


GRID = st.lists(st.integers(0, 8), min_size=2, max_size=6, unique=True).map(sorted)


@st.composite
def sets(draw: st.DrawFn) -> Solved:
    """Feasible and undecided intervals between whole numbers from 0 to 8, some without bound, in any order of kinds."""
    places = draw(GRID)
    pairs = [draw(st.sampled_from(["yes", "no", "open"])) for _ in places[1:]]
    numbers = [ExactNumber(Rational(n)) for n in places]
    if draw(st.booleans()):
        numbers[0] = None  # type: ignore[call-overload]
    if draw(st.booleans()):
        numbers[-1] = None  # type: ignore[call-overload]
    cells = list(zip(pairs, pairwise(numbers), strict=True))
    spans = tuple(Span(End(a, draw(st.booleans())), End(b, draw(st.booleans()))) for x, (a, b) in cells if x == "yes")
    return Solved(spans, tuple(pair for x, pair in cells if x == "open"))


def told(x: Solved, value: Rational) -> bool | None:
    """Whether a value is in a set, by its ends; None where that is open."""
    for span in x.feasible:
        low, high = (None if end.value is None else end.value.value for end in (span.low, span.high))  # type: ignore[attr-defined]
        above = low is None or value > low or (value == low and span.low.closed)
        if above and (high is None or value < high or (value == high and span.high.closed)):
            return True
    for pair in x.undecided:
        low, high = (None if end is None else end.value for end in pair)  # type: ignore[attr-defined]
        if (low is None or low <= value) and (high is None or value <= high):
            return None
    return False


@given(st.lists(sets(), min_size=2, max_size=3))
def test_what_is_in_several_sets_is_in_each_of_them_and_what_is_out_is_out_of_one(found: list[Solved]) -> None:
    both = together(Domain(None, None), found)
    for half in range(-3, 20):
        value = Rational(half, 2)
        answers = [told(x, value) for x in found]
        expected = False if False in answers else None if None in answers else True
        said = told(both, value)
        assert (said is True) == (expected is True)
        assert said is not False or expected is False
        if half % 2:  # inside of a cell: an open set is told with its ends
            assert said is expected


@pytest.mark.parametrize(
    ("name", "other", "asked", "why"),
    [
        (
            "sliding",
            ("b", 1, 2),
            {"that": ["stable"], "hand": "postural-arm"},
            "sliding friction stands as a describing",
        ),
        ("sampled-wall", ("environment.b", 1, 2), {"that": ["passive"]}, "the clock samples a force"),
    ],
)
def test_what_is_undecided_for_a_reason_says_it(
    name: str, other: tuple[str, Any, Any], asked: dict[str, Any], why: str
) -> None:
    """On the page, in the document, and of each slice of a map."""
    rough = hs.Scene(
        hs.environments.mass_spring_damper(k=100, b=1), (hs.effects.coulomb_friction("1 N", "1 cm"),), (1, 99)
    )
    scene = rough if name == "sliding" else hs.load_scene(name)
    found = hs.require(scene, "environment.k", (10, 1000), **asked)
    assert (found.feasible, len(found.undecided)) == ((), 1)
    assert why in found.reason
    assert why in found.to_dict()["reason"]
    assert why in " ".join(str(found).split())
    chart = hs.design_map(scene, [other[0], "environment.k"], [other[1:], (10, 1000)], slices=2, **asked)
    assert all(why in x["reason"] for x in chart.to_dict()["slices"])
    assert why in " ".join(str(chart).split())


@pytest.mark.parametrize(
    ("that", "said"),
    [
        (
            ["transparent"],
            "The worst case over the band against the parameter, with the threshold; grey: transparent on the whole band.",
        ),
        (["passive"], "Grey: fit for every passive hand."),
        (
            ["transparent", "passive"],
            "with the threshold; grey: transparent on the whole band and fit for every passive hand.",
        ),
    ],
)
def test_a_figure_is_said_to_show_what_was_asked(that: list[str], said: str) -> None:
    r = hs.require(hs.load_scene("fu2019"), "omega_n", (50, 500), that=that)
    [figure] = [x for x in page(r).blocks if isinstance(x, Figure)]
    assert str(phrase(figure.caption)).endswith(said)


@pytest.mark.parametrize("nothing", [[], ()])
def test_nothing_that_is_asked_is_no_question(nothing: Any) -> None:
    with pytest.raises(hs.SceneError, match="that: nothing is asked: one or more of transparent, stable, passive"):
        hs.require(hs.load_scene("fu2019"), "omega_n", (50, 500), that=nothing)


@pytest.mark.parametrize(
    ("jnd", "told"),
    [
        (0.1, True),
        ({"real": 0.1, "imag": 0.2}, True),
        ({"real": 0.1, "imag": "0.1 + omega/1000"}, False),
        ({"real": {"higher": 0.1, "lower": 0.2}, "imag": 0.1}, False),
        ({"shape": "ellipse", "real": 0.1, "imag": 0.1}, False),
    ],
)
def test_which_value_comes_nearest_is_told_of_two_ratios_with_a_threshold_alone(
    jnd: Any,
    told: bool,  # noqa: FBT001
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Where both parts are judged at once, or one by a limit that changes over the band, no multiple of it is told."""
    scene = hs.Scene(hs.environments.kelvin_voigt(90, 3), (hs.effects.delay("2 s"),), (1, 5), jnd)
    asked: Any = SimpleNamespace(
        criteria=noticed(scene.threshold), feasible=(), undecided=(), free=scene.knobs["tau"], threshold=scene.threshold
    )
    best = SimpleNamespace(ratio=1)
    monkeypatch.setattr(nearest, "_ROUNDS", 0)
    monkeypatch.setattr(nearest, "_tried", lambda _: [1])
    monkeypatch.setattr(nearest, "_at", lambda *_: best)
    assert (nearest.nearest(asked) is not None) is told
