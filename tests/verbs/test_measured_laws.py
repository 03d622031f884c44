"""Measured lines against plain arithmetic at every line: which are compared, their discs, signs, names, and what would resolve the open ones."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import haptisym as hs
from haptisym.model.jndtables import read_threshold
from haptisym.model.measured import averages_for, coherence_for
from haptisym.pages.measured import NOT_NAMED
from haptisym.verbs.measured.between import Stretches
from haptisym.verbs.measured.judging import OPEN, certainty, lines_of, matched, signs
from haptisym.verbs.measured.needed import MOST_AVERAGES, MOST_COHERENCE
from haptisym.verbs.measured.spread import spread
from haptisym.verbs.measured.swept import Discs, _common

SPRING = hs.environments.mass_spring_damper(k=100)
REAL, IMAG = hs.Part.REAL, hs.Part.IMAG


def judged(
    perceived: Any, environment: Any = SPRING, jnd: Any = 0.1, omega: Any = None, **certainty: Any
) -> hs.MeasuredEvaluation:
    at = np.arange(1.0, len(perceived) + 1) if omega is None else omega
    return hs.evaluate(hs.MeasuredScene(environment, hs.measured(at, perceived, **certainty), threshold=jnd))


# Lines.


def test_lines_are_compared_with_those_of_the_environment_at_the_same_frequency_to_a_billionth() -> None:
    own = hs.measured([1, 2, 3, 3 + 1e-6, 5], [10, 20, 30, 31, 50])
    felt = hs.measured([0.5, 1 + 0.9e-9, 2 * (1 - 0.9e-9), 3 + 1e-6, 4, 5 * (1 + 1.1e-9)], [1, 2, 3, 4, 5, 6])
    one, other = matched(hs.MeasuredScene(own, felt))
    assert other is not None
    assert (one.H.tolist(), other.H.tolist()) == ([2, 3, 4], [10, 20, 31])
    e = hs.evaluate(hs.MeasuredScene(own, felt))
    assert (len(e), e.left_out) == (3, 3)
    with pytest.raises(hs.SceneError, match="arm and hand have no frequency in common"):
        hs.evaluate(hs.MeasuredScene(hs.measured([1], [1], name="arm"), hs.measured([2], [1], name="hand")))
    with pytest.raises(hs.SceneError, match="H_env is infinite at 0 rad/s"):
        judged([1, 2], hs.environments.expression("1 + 1/s"), omega=[0, 1])


def test_the_disc_of_a_change_holds_every_quotient_of_what_both_discs_hold() -> None:
    rng = np.random.default_rng(3)
    env, perc = (rng.normal(size=40) + 1j * rng.normal(size=40) for _ in range(2))
    r_env, r_perc = (np.abs(env) * rng.uniform(0, x, 40) for x in (0.6, 0.5))
    omega = np.arange(1.0, 41)
    x = lines_of(hs.MeasuredScene(hs.measured(omega, env, radius=r_env), hs.measured(omega, perc, radius=r_perc)))
    size, share = np.abs(env), r_env / np.abs(env)
    assert x.change == pytest.approx((perc - env) / size, rel=1e-14)
    assert x.radius == pytest.approx(
        ((r_env + r_perc) / size + np.abs(perc - env) / size * share) / (1 - share), rel=1e-12
    )
    edge = np.exp(2j * np.pi * np.arange(60) / 60)
    a, b = (env + r_env * edge[:, None])[:, None], (perc + r_perc * edge[:, None])[None]
    assert (np.abs((b - a) / np.abs(a) - x.change) <= x.radius * (1 + 1e-12)).all()
    bare = lines_of(hs.MeasuredScene(SPRING, hs.measured([1, 2], [90, 100])))
    assert (bare.radius, bare.perc_radius.tolist(), bare.env_radius.tolist()) == (None, [0, 0], [0, 0])
    one = lines_of(hs.MeasuredScene(hs.measured([1], [10], radius=[10]), hs.measured([1], [10])))
    assert one.radius is not None
    assert one.radius.tolist() == [np.inf]


def test_signs_are_told_where_a_disc_leaves_no_other() -> None:
    env = np.array([100, 100, 100, -50, 100, 100, 2, 100.0])
    perc = np.array([120, 100, 80, -49, -30, 90, -3, 0.0])
    radius = np.array([5, 0, 5, 2, 29, 10, 4, 0.0])
    omega = np.arange(1.0, 9)
    for part, turn in ((REAL, 1), (IMAG, 1j)):
        x = lines_of(hs.MeasuredScene(hs.measured(omega, turn * env), hs.measured(omega, turn * perc, radius=radius)))
        found = signs(x, part)
        assert found.environment.tolist() == [1, 1, 1, -1, 1, 1, 1, 1]
        assert found.perceived.tolist() == [1, 1, 1, -1, -1, 1, OPEN, 0]
        assert found.compared.tolist() == [1, 0, -1, OPEN, -1, OPEN, OPEN, -1]
        assert found.known.tolist() == [True, True, True, False, True, False, False, True]
        labels = [tuple(y.value for y in found.label(part, i)) for i in (0, 1, 2)]
        what = "stiffness" if part is REAL else "damping"
        assert labels == [(what, "higher"), (what, "equal"), (what, "lower")]
    both = lines_of(hs.MeasuredScene(hs.measured([1], [10], radius=[1]), hs.measured([1], [13], radius=[1.9])))
    assert signs(both, REAL).compared.tolist() == [1]
    wider = lines_of(hs.MeasuredScene(hs.measured([1], [10], radius=[1.2]), hs.measured([1], [13], radius=[1.9])))
    assert signs(wider, REAL).compared.tolist() == [OPEN]


def test_a_line_exceeds_is_below_or_open_as_its_disc_lies() -> None:
    """Of a spring of 100 N/m and a JND of 10 %; the border belongs to what is not noticed."""
    cases = [
        (111, 0.5, 1),
        (111, 1, 0),
        (109, 1, -1),
        (109, 1.01, 0),
        (110, 0, -1),
        (110.001, 0, 1),
        (89, 0.9, 1),
        (100, 10, -1),
        (100, np.inf, 0),
    ]
    e = judged([x for x, _, _ in cases], radius=[r for _, r, _ in cases])
    assert e.verdict[REAL].tolist() == [code for _, _, code in cases]
    assert e.distance[REAL] == pytest.approx([abs(x - 100) / 100 - 0.1 for x, _, _ in cases], abs=1e-15)
    assert [row.real.value for row in e.rows] == [
        {1: "exceeds", -1: "below", 0: "unresolved"}[code] for _, _, code in cases
    ]
    zero = judged(
        [5 + 1j, 5 + 1j, 0.5],
        hs.environments.mass_spring_damper(m=1),
        omega=[0, 1e-200, 2e-200],
        radius=[2, 2, 2],
        jnd={"real": 0.1, "imag": 0.1, "floor": 3.5},
    )
    assert (zero.verdict[REAL].tolist()[0], zero.verdict[IMAG].tolist()[0]) == (0, -1)
    for floor, code in ((2.9, 1), (3, 0), (7, -1), (6.9, 0)):
        one = judged(
            [5],
            hs.environments.mass_spring_damper(m=1),
            omega=[0],
            radius=[2],
            jnd={"real": 0.1, "imag": 0.1, "floor": floor},
        )
        assert one.verdict[REAL].tolist() == [code]


SHAPES = [
    0.1, {"real": {"higher": 0.1, "lower": 0.2}, "imag": 0.3}, {"shape": "ellipse", "real": 0.2, "imag": 0.3, "tilt": 0.5}, {"shape": "diamond", "real": 0.2, "imag": 0.3},
    {"shape": "polygon", "corners": [[0.3, 0], [0, 0.2], [-0.2, -0.2]]}, {"real": 0.1, "imag": 0.2, "floor": "9 N/m"},
]  # fmt: skip


@pytest.mark.parametrize("jnd", SHAPES)
def test_rows_percepts_and_documents_are_the_same_answer(jnd: Any) -> None:
    rng = np.random.default_rng(5)
    perceived = 100 * (1 + 0.5 * rng.normal(size=60) + 0.5j * rng.normal(size=60))
    e = judged(
        perceived,
        hs.environments.kelvin_voigt(100, 2),
        jnd,
        omega=np.linspace(1, 20, 60),
        radius=rng.uniform(0, 12, 60),
    )
    change = (perceived - (100 + 2j * e.lines.omega)) / np.abs(100 + 2j * e.lines.omega)
    for i, row in enumerate(e.rows):
        assert (row.omega, row.ratio_real, row.ratio_imag) == pytest.approx(
            (e.lines.omega[i], abs(change[i].real), abs(change[i].imag)), rel=1e-12
        )
        assert (row.joint is None) == (e.joint is None)
    parsed = json.loads(e.to_json())
    assert parsed == json.loads(json.dumps(e.to_dict()))
    assert parsed["lines"] == 60
    told = {(p.part, p.omega): p for p in e.percepts}
    limits = read_threshold(jnd)
    for part in (REAL, IMAG, None):
        for i in np.flatnonzero(e.named(part)):
            p = told.pop((part, float(e.lines.omega[i])))
            if part is None:
                far, near = e.order(i)
                assert p.other is not None
                assert (p.property, p.change) == e.signs[near].label(near, i)
                assert p.other == e.signs[far].label(far, i)
            else:
                assert (p.property, p.change, p.other) == (*e.signs[part].label(part, i), None)
    assert told == {}
    if e.joint is None:
        assert not e.noticed(None).any()
    else:
        for i in np.flatnonzero(e.noticed(None)):
            assert (e.joint.verdict[i], e.verdict[REAL][i], e.verdict[IMAG][i]) == (1, -1, -1)
    if jnd == SHAPES[3]:
        nearer = np.abs(change.real) / float(limits.real) > np.abs(change.imag) / float(limits.imag)
        assert e.real_nearer.tolist() == nearer.tolist()
    counts = {part: [int((e.verdict[part] == code).sum()) for code in (1, -1, 0)] for part in (REAL, IMAG)}
    words = [
        f"{n} {word}"
        for part in (REAL, IMAG)
        for n, word in zip(counts[part], ("exceeds", "below", "unresolved"), strict=True)
    ]
    assert (
        repr(e)
        == f'<MeasuredEvaluation "Untitled scene": 60 lines, real {", ".join(words[:3])}, imaginary {", ".join(words[3:])}>'
    )


@given(st.lists(st.integers(2, 40), min_size=1, max_size=9), st.integers(0, 99))
def test_what_resolves_half_and_all_of_the_open_lines_is_the_least_that_does(percents: list[int], seed: int) -> None:
    """Of a spring of 100 N/m: each line lies so many per mille beside its threshold, with discs that are too large."""
    margins = np.array(percents) / 1000
    rng = np.random.default_rng(seed)
    perceived = 100 * (1.1 + margins * rng.choice([-1, 1], len(margins)))
    n, g2 = 9, np.full(len(margins), 0.5)
    e = judged(perceived, coherence=g2, averages=n)
    assert e.needed is not None
    assert e.needed.lines == len(margins)
    order = np.sort(margins)[::-1]
    half = order[(len(order) - 1) // 2]
    assert (e.needed.radius.half, e.needed.radius.all) == pytest.approx((half, order[-1]), rel=1e-9)
    relative = margins * 100 / perceived
    for share, values in (
        (e.needed.coherence, coherence_for(relative, n)),
        (e.needed.averages, averages_for(relative, g2)),
    ):
        assert share is not None
        ranked = np.sort(values)
        assert (share.half, share.all) == pytest.approx((ranked[(len(ranked) - 1) // 2], ranked[-1]), rel=1e-6)
    told = e.to_dict()["needed"]
    assert told == {
        "lines": len(margins),
        **{key: getattr(e.needed, key).row() for key in ("radius", "coherence", "averages")},
    }


def test_what_nobody_measures_is_not_asked_for_and_what_is_told_needs_nothing() -> None:
    near = judged([110 + 1e-5, 115], coherence=[0.5, 0.5], averages=9)
    assert near.needed is not None
    assert near.needed.coherence is not None
    assert near.needed.averages is not None
    assert (near.needed.coherence.all, near.needed.averages.all) == (None, None)
    assert near.needed.coherence.half is not None
    assert MOST_COHERENCE == 1 - 1e-6
    assert MOST_AVERAGES == 1e6
    assert judged([100, 150], radius=[1, 1]).needed is None
    plain = judged([111], radius=[5]).needed
    assert plain is not None
    assert (plain.coherence, plain.averages) == (None, None)
    both = judged([111], hs.measured([1], [100], radius=[3]), coherence=[0.9], averages=9).needed
    assert both is not None
    assert both.coherence is None
    own = judged([111], hs.measured([1], [100]), coherence=[0.5], averages=9).needed
    assert own is not None
    assert own.coherence is not None
    two = judged([111 + 9j], radius=[5], jnd={"real": 0.1, "imag": 0.1}).needed
    assert two is not None
    assert two.radius.all == pytest.approx(0.01, rel=1e-9)  # of the part that is nearer


# Between lines.


@given(st.integers(0, 999), st.sampled_from(["square", "floor", "ellipse", "tilt", "polygon"]))
def test_a_border_moves_over_a_cell_no_further_than_is_said(seed: int, kind: str) -> None:
    rng = np.random.default_rng(seed)
    (p, q), (u, v) = ((int(rng.integers(5, 40)), int(rng.integers(100, 900))) for _ in range(2))
    a, b = (f"{i}/100 + omega/{j}" for i, j in ((p, q), (u, v)))
    tables: dict[str, Any] = {
        "square": {"real": a, "imag": 0.3}, "floor": {"real": 0.1, "imag": 0.1, "floor": "2 + omega/7"}, "ellipse": {"shape": "ellipse", "real": a, "imag": b, "tilt": 0.4},
        "tilt": {"shape": "ellipse", "real": 0.2, "imag": 0.2, "tilt": "omega/40"}, "polygon": {"shape": "polygon", "corners": [[a, 0], [0, 0.2], ["-0.3", "-0.1 - omega/500"]]},
    }  # fmt: skip
    c = read_threshold(tables[kind])
    low = rng.uniform(1, 10, 3)
    high, least = low + rng.uniform(0.01, 2, 3), rng.uniform(10, 50, 3)
    found = spread(c, low, high, least)

    def extent(w: float, angle: float) -> float:
        """How far the region reaches in a direction; of a square its side, of a floor that."""
        if kind == "square":
            return p / 100 + w / q
        if kind == "floor":
            return 2 + w / 7
        x, y = np.cos(angle), np.sin(angle)
        if kind == "polygon":
            corners = ((p / 100 + w / q, 0), (0, 0.2), (-0.3, -0.1 - w / 500))
            return max(float(c * x + d * y) for c, d in corners)
        aa, bb, t = (0.2, 0.2, w / 40) if kind == "tilt" else (p / 100 + w / q, u / 100 + w / v, 0.4)
        return float(np.sqrt((aa * x) ** 2 + 2 * t * aa * bb * x * y + (bb * y) ** 2))

    for i in range(3):
        middle = (low[i] + high[i]) / 2
        seen = max(
            abs(extent(w, t) - extent(middle, t))
            for w in np.linspace(low[i], high[i], 5)
            for t in np.linspace(0, 6.3, 8)
        )
        seen /= least[i] if kind == "floor" else 1
        assert found[i] >= seen * (1 - 1e-9)
        if kind in ("square", "floor"):
            assert found[i] <= seen * (1 + 1e-9)
        if kind == "ellipse":  # whose sides move, and whose tilt does not
            assert found[i] == pytest.approx((high[i] - low[i]) * (1 / q + 1 / v), rel=1e-6)
    assert spread(read_threshold(0.1), low, high, least).tolist() == [0] * 3


def test_a_limit_that_grows_with_the_frequency_is_met_where_it_is_as_large_as_the_change() -> None:
    """Nothing moves but the limit, 0.1 + omega/100: a change by x is noticed below 100 x - 10, and what is told ends next to that."""
    for x, error in ((0.203, 0.0), (0.131, 0.02)):
        H = [100 * (1 + x)] * 2
        felt = hs.measured([1, 21], H, radius=[100 * error] * 2, slope="1e-9 N*s/m")
        jnd = {"real": "0.1 + omega/100", "imag": "0.1"}
        between = hs.evaluate(hs.MeasuredScene(SPRING, felt, threshold=read_threshold(jnd))).between
        assert between is not None
        told = between.told[REAL]
        ends = {c: [*zip(told.low[told.code == c], told.high[told.code == c], strict=True)] for c in (1, -1)}
        [(first, above)], [(below, last)] = ends[1], ends[-1]
        assert (first, last) == (1, 21)
        assert 100 * (x - error) - 10.5 < above <= 100 * (x - error) - 10 + 1e-6
        assert 100 * (x + error) - 10 - 1e-6 <= below < 100 * (x + error) - 9.5


def test_what_discs_come_from_is_said() -> None:
    for keys, told in (
        ({}, "no disc is known"),
        ({"radius": [1]}, "radius in the file"),
        ({"coherence": [0.9], "averages": 32}, "coherence, 32 averages"),
    ):
        assert certainty(hs.measured([1], [100], **keys)) == told


def test_of_a_display_that_gives_energy_away_stiffness_has_a_name_and_damping_has_none() -> None:
    """Both parts change by more than a tenth; where the imaginary part that is felt is negative, it is no damping."""
    for imag, named in ((5, {REAL}), (-20, {REAL}), (40, {REAL, IMAG})):
        e = judged([160 + imag * 1j], hs.measured([1], [100 + 10j]), radius=[0.1])
        assert {part for part in hs.Part if e.named(part).any()} == named | ({IMAG} if imag == 40 else set())


def test_the_page_has_a_row_for_each_group_of_lines_that_are_felt_alike() -> None:
    """Noticed and named, noticed without a name (the sign of what is felt is open), and not noticed: of that there is no row."""
    e = judged([130, 130, 100.5, 111, 70 + 30j, 1, 100 - 30j], radius=[1, 1, 1, 5, 1, 2, 1])
    told = str(e).partition("felt as\n")[2].partition("\n\n")[0].splitlines()[1:]
    assert [" ".join(x.split()) for x in told] == [
        "1 to 2 2 real higher stiffness", "5 1 real lower stiffness", f"6 1 real {NOT_NAMED}", "5 1 imag higher damping", f"7 1 imag {NOT_NAMED}",
    ]  # fmt: skip


def test_a_disc_around_what_two_have_in_common_holds_it_and_is_hardly_larger_than_the_least() -> None:
    rng = np.random.default_rng(9)
    x, y = (Discs(rng.normal(size=300) + 1j * rng.normal(size=300), rng.uniform(0.3, 2.5, 300)) for _ in range(2))
    found = _common(x, y)
    grid = (np.linspace(-1, 1, 41)[:, None] + 1j * np.linspace(-1, 1, 41)).ravel()
    for i in range(300):
        points = x.centre[i] + x.radius[i] * grid
        both = (np.abs(points - x.centre[i]) <= x.radius[i]) & (np.abs(points - y.centre[i]) <= y.radius[i])
        assert (np.abs(points[both] - found.centre[i]) <= found.radius[i] * (1 + 1e-12)).all()
        d, r, t = abs(x.centre[i] - y.centre[i]), x.radius[i], y.radius[i]
        if d > r + t:
            continue
        foot = (d**2 + r**2 - t**2) / (2 * d)
        least = min(r, t) if not 0 < foot < d else float(np.sqrt(max(r**2 - foot**2, 0)))
        assert found.radius[i] == pytest.approx(least, rel=1e-6, abs=1e-6)


def test_stretches_are_told_with_their_lengths() -> None:
    found = Stretches(np.array([0.0, 1, 3]), np.array([1.0, 3, 3.5]), np.array([-1, 1, 0]))
    assert found.rows() == [
        {"band": [0, 1], "verdict": "below"},
        {"band": [1, 3], "verdict": "exceeds"},
        {"band": [3, 3.5], "verdict": "unresolved"},
    ]
    assert [found.length(code) for code in (-1, 1, 0)] == [1, 2, 0.5]
    assert len(found) == 3


def test_the_document_tells_bounds_what_contradicts_them_and_how_large_discs_grow() -> None:
    felt = hs.measured([1, 2, 3], [100, 100, 180], radius=[1, 2, 1], slope="10 N*s/m")
    scene = hs.MeasuredScene(SPRING, felt, threshold=0.1)
    told = hs.evaluate(scene).to_dict()["between"]
    assert told["slope"] == {"perceived": {"bound": 10.0, "unit": "N*s/m", "relative": False}}
    assert told["contradicted"] == [[2.0, 3.0]]
    assert told["grown"] == pytest.approx(0.06, rel=1e-9)  # of 1 + 5 and 2 + 5 the smaller, over 100
    assert [x["verdict"] for x in told["real"]][-1] == "unresolved"
    assert told["real"][-1]["band"][1] == 3
    own = hs.measured([1, 2], [100, 101], slope="20 ms")
    both = hs.MeasuredScene(own, hs.measured([1, 2], [100, 101], slope="1 s"))
    bounds = hs.evaluate(both).to_dict()["between"]["slope"]
    assert bounds == {
        "perceived": {"bound": 1.0, "unit": "s", "relative": True},
        "environment": {"bound": 0.02, "unit": "s", "relative": True},
    }
    assert (
        hs.evaluate(hs.MeasuredScene(SPRING, hs.measured([1], [100], slope="1 s"))).to_dict()["between"]["grown"] == 0
    )
    with pytest.raises(hs.SceneError, match="environment: slope is missing"):
        hs.MeasuredScene(hs.measured([1, 2], [100, 101]), felt)
    with pytest.raises(hs.SceneError, match="perceived: slope is missing"):
        hs.MeasuredScene(own, hs.measured([1, 2], [100, 101]))


def test_a_measured_scene_is_made_of_what_was_measured_in_one_motion(tmp_path: Path) -> None:
    line = hs.measured(hs.measured([1, 2], [100, 101]).to_csv(tmp_path / "line.csv"))
    for keys, told in (({"environment": 3}, "environment: int is not an environment or a measured response"), ({"perceived": SPRING}, "perceived: Environment is not a measured response"),
                       ({"environment": hs.environments.mass_spring_damper(k=hs.symbols("k"))}, "is a symbol where a number is needed"),
                       ({"perceived": hs.measured([1], [1], slope="1 N*m*s/rad"), "environment": hs.environments.mass_spring_damper(k="1 N/m")}, "translation and rotation cannot be mixed")):  # fmt: skip
        with pytest.raises(hs.SceneError, match=told):
            hs.MeasuredScene(**({"environment": SPRING, "perceived": line} | keys))
    scene = hs.MeasuredScene(line, line, title="Mine")
    assert (scene.files, scene.motion, len(scene.slopes)) == ((line.path, line.path), None, 0)
    assert repr(scene) == '<MeasuredScene "Mine": line.csv, felt as measured at 2 lines>'
    assert hs.MeasuredScene(hs.environments.mass_spring_damper(k="1 N*m/rad"), line).motion is not None
    assert hs.MeasuredScene(SPRING, line, ("1 rad/s", 1.5)).band[0] == 1  # type: ignore[index]
    assert scene.aside_keys() == {}
    assert scene.asides() == []
