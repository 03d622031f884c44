"""Questions that take long, or that once broke: a limit in time, what is proven when it is spent, and no exception but ours."""

from __future__ import annotations

import json
from collections.abc import Callable
from itertools import count

import pytest
from marks import QUICK_SCENES, often
from sympy import Rational

import haptisym as hs
from haptisym import effects, environments
from haptisym.kernel import budget
from haptisym.kernel.budget import limited, share, tick
from haptisym.kernel.errors import LimitError, SceneError, UndecidedError
from haptisym.kernel.reals import RealNumber
from haptisym.verbs.require.designmap import design_map
from haptisym.verbs.require.entry import require
from haptisym.verbs.require.required import Requirement
from haptisym.verbs.tolerances.entry import tolerances

# Long delays: one that is free, beside other things that turn


@pytest.mark.slow
@pytest.mark.parametrize("name", ["organ-tissue", "sampled-wall"])
def test_a_free_delay_beside_other_angles_is_answered(name: str) -> None:
    """Both scenes are noticed without any delay, and no delay mends that."""
    found = require(hs.load_scene(name), "tau")
    assert (found.feasible, found.undecided) == ((), ())
    for tau in (0, Rational(1, 1000), Rational(1, 10), 3):
        assert hs.evaluate(hs.load_scene(name).with_values({"tau": Rational(tau)})).crossings


# The limit itself


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Callable[[float], None]:
    """A clock that goes on by one second each time somebody looks: a limit of n is then n ticks, on every machine."""
    ticks = count()
    monkeypatch.setattr(budget, "monotonic", lambda: float(next(ticks)))
    return lambda seconds: [next(ticks) for _ in range(int(seconds))] and None  # type: ignore[func-returns-value]


def test_without_a_limit_nothing_is_cut_short(clock: Callable[[float], None]) -> None:
    tick()
    with limited() as none:
        for _ in range(1000):
            tick()
        assert (none.deadline, none.reached) == (None, False)


def test_a_limit_holds_inside_and_is_gone_outside(clock: Callable[[float], None]) -> None:
    with limited(10) as own:
        tick()
        clock(10)
        with pytest.raises(LimitError, match="10 s"):
            tick()
        assert own.reached
    tick()  # no limit out here


def test_what_is_inside_cannot_take_longer_than_what_is_around_it(clock: Callable[[float], None]) -> None:
    with limited(10) as outer:
        with limited(1000) as inner:
            assert inner.deadline == outer.deadline
            clock(10)
            with pytest.raises(LimitError):
                tick()
        assert outer.reached


def test_a_share_ends_before_the_whole(clock: Callable[[float], None]) -> None:
    with limited(100):
        with share(0.5):
            clock(60)
            with pytest.raises(LimitError):
                tick()
        tick()
        with share(0.5):
            tick()


def test_who_is_told_hears_how_far_it_is_and_not_too_often(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [0.0]
    monkeypatch.setattr(budget, "monotonic", lambda: now[0])
    heard: list[tuple[float, float | None, str]] = []
    with limited(None, lambda *said: heard.append(said)):
        for n in range(100):
            now[0] += 0.01
            tick(n, 100, "things")
            tick()  # deep inside: it goes on
    assert 9 <= len(heard) <= 11
    assert all(said[1:] == (100, "things") for said in heard)


@pytest.mark.parametrize("seconds", [0, -1, float("nan"), float("inf"), "5"])
def test_a_limit_is_a_positive_number(seconds: object) -> None:
    with pytest.raises(SceneError, match="limit"):
        require(hs.load_scene("fu2019"), "omega_n", limit=seconds)  # type: ignore[arg-type]


# What is proven when it is spent

SHORT = [1, 3, 10, 30, 100, 300, 1000, 3000]
QUESTIONS = {
    "rational": (hs.load_scene("fu2019"), "omega_n", None),
    "rational, both ends": (hs.load_scene("fu2019"), "zeta", ("0.1", 1)),
    "delayed": (hs.load_scene("delayed-spring"), "k", ("10", "500")),
    "a delay": (hs.load_scene("delayed-spring"), "tau", None),
    "threshold": (hs.load_scene("fu2019"), "evaluation.jnd", None),
    "set of two": (
        hs.Scene(environments.mass_spring_damper(m=1, b=10, k=100), (effects.compliance(k=2000, b=3),), (0, 9)),
        "environment.k",
        (1, 400),
    ),
}


def _number(x: RealNumber | None, otherwise: float) -> float:
    return otherwise if x is None else float(x)


def _spans(found: Requirement) -> list[tuple[float, float]]:
    return [(_number(x.low.value, -1e300), _number(x.high.value, 1e300)) for x in found.feasible]


def _open(found: Requirement) -> list[tuple[float, float]]:
    return [(_number(a, -1e300), _number(b, 1e300)) for a, b in found.undecided]


def _holds(spans: list[tuple[float, float]], x: float) -> bool:
    return any(a <= x <= b for a, b in spans)


@pytest.mark.few(4)
@pytest.mark.parametrize("ticks", SHORT)
@pytest.mark.parametrize("question", QUESTIONS)
def test_what_is_said_after_a_limit_is_true(question: str, ticks: int, clock: Callable[[float], None]) -> None:
    """Values said to do, do; values said not to, do not; the rest is said to be undecided."""
    scene, path, asked = QUESTIONS[question]
    whole = require(scene, path, asked)
    cut = require(scene, path, asked, limit=ticks)
    assert whole.undecided == ()
    assert cut.certified == (cut.undecided == ())
    ends = [x for pair in (*_spans(whole), *_spans(cut), *_open(cut)) for x in pair if abs(x) < 1e299]
    scale = max(map(abs, ends), default=1.0)
    for x in [x * (1 + e) for x in ends for e in (-1e-6, 1e-6)] + [scale * n / 50 for n in range(1, 100)]:
        low, high = (None if v is None else float(v) for v in (whole.domain.low, whole.domain.high))
        if (low is not None and x <= low) or (high is not None and x >= high) or x in ends:
            continue  # neighbours share an end
        if not _holds(_open(cut), x):
            assert _holds(_spans(cut), x) == _holds(_spans(whole), x), x
        elif _holds(_spans(cut), x):
            pytest.fail(f"{x} is said to do and to be undecided")
    if cut.certified:
        assert [x for pair in _spans(cut) for x in pair] == pytest.approx([x for pair in _spans(whole) for x in pair])
    assert require(scene, path, asked).to_dict() == whole.to_dict()  # nothing half done is kept


def test_a_spent_limit_is_said(clock: Callable[[float], None]) -> None:
    found = require(hs.load_scene("fu2019"), "omega_n", limit=2)
    assert (found.feasible, found.certified, found.limit) == ((), False, 2)
    assert "within the limit of 2 s" in str(found)
    document = found.to_dict()
    assert (document["undecided"], document["certified"], document["limit"]) == ([[0.0, None]], False, 2)
    assert "limit" not in require(hs.load_scene("fu2019"), "omega_n", limit=10**6).to_dict()


def test_slices_that_were_not_reached_are_undecided(clock: Callable[[float], None]) -> None:
    ranges = [("0.4", "0.6"), (50, 500)]
    found = design_map(hs.load_scene("fu2019"), ["zeta", "omega_n"], ranges, slices=9, limit=1000)  # type: ignore[arg-type]
    decided = [x.requirement.certified for x in found.slices]
    assert True in decided
    assert False in decided
    rows = found.to_dict()["slices"]
    assert [row["undecided"] == [] for row in rows] == decided
    assert rows[-1]["undecided"] == [[50.0, 500.0]]
    assert not found.certified


RANGES = hs.Scene(
    environments.mass_spring_damper(m="1.8 kg +- 3 %", b="15 N*s/m +- 5 %", k="100 N/m"),
    (effects.second_order_lowpass("80 rad/s +- 2 %", "0.5"),),
    (0, 15),
)


def test_a_limit_that_was_not_reached_is_not_said_to_be() -> None:
    soft = hs.Scene(environments.mass_spring_damper(k="100 N/m +- 2 %"), (effects.first_order_lag(50),), (0, 15))
    found = tolerances(soft, samples=1, limit=10**6)
    assert (found.limit, "limit" in found.to_dict()) == (None, False)


@pytest.mark.slow
@pytest.mark.parametrize("ticks", [30, 100, 300, 1000, 3000, 10_000])
def test_enclosures_after_a_limit_hold_all_crossings(ticks: int, clock: Callable[[float], None]) -> None:
    whole = tolerances(RANGES, samples=20)
    try:
        cut = tolerances(RANGES, samples=20, limit=ticks)
    except LimitError:
        return  # not even the nominal values
    assert cut.verdict in (whole.verdict, type(whole.verdict).UNDECIDED)
    for one in (whole.nominal, *whole.samples):
        for name, crossings in one.crossings.items():
            for x in crossings:
                held = [
                    e for e in cut.enclosures if e.criterion.name == name and float(e.low) <= float(x) <= float(e.high)
                ]
                assert held
    for x in cut.enclosures:
        inside = [c for c in whole.nominal.crossings[x.criterion.name] if float(x.low) <= float(c) <= float(x.high)]
        assert x.count in (None, len(inside))
    if cut.limit is None:
        assert cut.to_dict() == whole.to_dict()
    else:
        assert cut.to_dict()["limit"] == ticks
        assert f"to keep within the limit of {ticks:g} s" in " ".join(str(cut).split())


@pytest.mark.parametrize(
    "words",
    [
        ("require", "control-stick-in-detail", "--free", "effects.force-loop.omega_c"),
        ("require", "control-stick-in-detail", "--free", "b", "--free", "m", "--range", "1", "2", "--range", "1", "2"),
        ("effects", "control-stick-in-detail"),
        ("evaluate", "organ-tissue"),
        ("sensitivity", "organ-tissue"),
    ],
)
def test_a_limit_on_the_command_line_is_kept_and_ends_with_status_3(words: tuple[str, ...], call) -> None:  # type: ignore[no-untyped-def]
    status, out, err = call(*words, "--json", "--limit", "1e-6")
    assert status == 3
    if words[0] == "require":
        assert json.loads(out)["certified"] is False
    else:
        assert "within the limit of 1e-06 s" in err


# Every parameter of every shipped scene

PARAMETERS = [
    (name, f"{place}.{p.key}")
    for name in hs.scene_names()
    for place, element in hs.load_scene(name).elements()
    for p in element.parameters
]


@pytest.mark.few(
    "delayed-spring-effects.delay.tau",
    "fu2019-environment.m",
    "fu2019-environment.b",
    "fu2019-environment.k",
    "fu2019-effects.filter.omega_n",
    "fu2019-effects.filter.zeta",
    "undamped-resonance-environment.m",
    "undamped-resonance-effects.filter.zeta",
)
@pytest.mark.parametrize(
    ("name", "path"), often(PARAMETERS, lambda case: case[0] in QUICK_SCENES - {"stick-with-friction"}, 2)
)
def test_every_parameter_of_every_scene_is_answered_or_undecided(name: str, path: str) -> None:
    """Where a value is said to do (not to), the scene at it shows to be transparent (not to be) on the whole band."""
    scene = hs.load_scene(name)
    try:
        found = require(scene, path, limit=3)
    except (SceneError, UndecidedError):
        return
    [p] = [x for place, e in scene.elements() for x in e.parameters if f"{place}.{x.key}" == path]
    own = float(p.value)
    assert found.to_json()
    if found.certified:
        low, high = (float(x) for x in scene.band)
        whole = [x for x in hs.evaluate(scene).transparent if (float(x.low.omega), float(x.high.omega)) == (low, high)]
        assert _holds(_spans(found), own) == bool(whole)
