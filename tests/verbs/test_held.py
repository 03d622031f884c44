"""Imposed, held, every passive hand: against facts computed elsewhere, roots found by mpmath and winding numbers."""

from __future__ import annotations

import json
from itertools import product
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from marks import often
from sympy import Integer, Rational, lambdify

import haptisym as hs
from haptisym.kernel.reals import ExactNumber
from haptisym.verbs.require.freeparameter import Domain
from haptisym.verbs.require.held import _cut, _meets
from haptisym.verbs.stability.boxes import Share, whole_box
from haptisym.verbs.stability.curves import Gap, Meetings
from haptisym.verbs.stability.held import held

LATE = 'environment = {{ model = "mass-spring-damper", k = "{k} N/m" }}\neffects = [{{ model = "delay", tau = "36 ms" }}]\n'


def unstable(scene: hs.Scene | str, **hand: Any) -> int | None:
    own = hs.load_scene(scene) if isinstance(scene, str) else scene
    return held(own, hs.Hand("own", **hand)).unstable


@pytest.mark.parametrize(
    ("k", "critical"),
    [
        ("0", "3.4635997327677041"), ("100", "3.3297497532862284"), ("500", "2.81972833105523"), ("1000", "2.238659408552519"),
    ],
)  # fmt: skip
def test_a_spring_that_comes_late_is_held_from_a_certain_damping_on(k: str, critical: str) -> None:
    for change, expected in (("-1e-12", 2), ("1e-12", 0)):
        assert unstable("delayed-spring", m="0.5 kg", k=k, b=Rational(critical) + Rational(change)) == expected


def test_the_arm_that_was_measured_holds_a_late_spring_of_no_more_than_200_newtons_per_metre() -> None:
    arm = hs.hands["postural-arm"]
    for k, expected in (("199.8521022587101", 0), ("199.8521022587102", 2), ("290", 2)):
        assert held(hs.parse_scene(LATE.format(k=k)), arm).unstable == expected


CRITICAL = [  # scene, hand, path, value, rad/s, stable side: computed elsewhere
    (100, {"m": "0.5 kg", "b": 1}, "hand.b", "3.4635997327677041014", 13.320697368492448, "above"),
    (100, {"m": "0.5 kg", "b": 9, "k": 100}, "hand.b", "3.3297497532862287950", 18.858713273231587, "above"),
    (100, {"m": "0.5 kg", "b": 1, "k": 500}, "hand.b", "2.8197283310552300722", 32.802726231761795, "above"),
    (100, {"m": "0.5 kg", "b": 1, "k": 1000}, "hand.b", "2.2386594085525189552", 44.64024101711087, "above"),
    (290, {"m": "0.5 kg", "b": 1}, "hand.b", "9.5037390727713175455", 20.660047835266866, "above"),
    (290, {"m": "0.5 kg", "b": 1, "k": 100}, "hand.b", "9.1877001353127948759", 24.010212956148372, "above"),
    (290, {"m": "0.5 kg", "b": 1, "k": 500}, "hand.b", "7.9599529917453498043", 34.4665745428735, "above"),
    (290, {"m": "0.5 kg", "b": 1, "k": 1000}, "hand.b", "6.5113668307878865184", 44.515059476572006, "above"),
    (
        100,
        {"m": "0.554 kg", "b": "6.45", "k": 135},
        "environment.k",
        "199.85210225871012834",
        22.244306341605846,
        "below",
    ),
]


@pytest.mark.few(4)
@pytest.mark.parametrize(("k", "hand", "path", "value", "omega", "side"), CRITICAL)
def test_how_far_a_number_may_go_is_told_to_any_digits(
    k: int, hand: dict[str, Any], path: str, value: str, omega: float, side: str
) -> None:
    found = hs.stability(
        hs.parse_scene(LATE.format(k=k)), hs.Hand("hand", **hand), ["environment.k"], digits=20
    ).to_dict()
    [row] = [x for x in found["held"][0]["critical"] if x["path"] == path]
    assert (row["digits"], row["stable_side"]) == (value, side)
    assert row["omega"] == pytest.approx(omega, rel=1e-15)
    low, high = row["enclosure"]
    assert Rational(low) < Rational(high)
    assert float(low) == float(high) == pytest.approx(float(value), rel=1e-15)


def test_the_delay_that_a_hand_bears_is_the_one_at_which_its_spring_is_critical() -> None:
    """K exp(-j w tau) = -Z: at K = 199.85... and tau = 36 ms; the other way round tau is critical at 36 ms for that K."""
    scene = hs.parse_scene(LATE.format(k="199.85210225871012834"))
    [row] = [x for x in hs.stability(scene, "postural-arm", "tau").critical[0] if x.path.endswith("tau")]
    assert float(row.found[0].value) == pytest.approx(0.036, rel=1e-14)


def test_a_mass_of_500_kilograms_is_where_the_chain_of_a_satellite_is_lost() -> None:
    mass, damping, stiffness = hs.stability("satellite-contact", "postural-arm").critical[0]
    [found] = mass.found
    assert (found.value.digits(5), found.omega, found.below, found.stable_side) == ("500.00", None, None, None)
    assert (damping.found, stiffness.found) == ((), ())


@pytest.mark.slow
def test_beside_a_chain_that_is_lost_no_side_is_called_stable() -> None:
    """-0.002 s^2 that comes 4 ms late: in a hand of 2 kg no root lies on the right, in one of 2.1 g there are four."""
    wheel = hs.environments.mass_spring_damper("0.04 kg*m^2", "0.3 N*m*s/rad", "4 N*m/rad")
    column = hs.effects.compliance("600 N*m/rad", "0.2 N*m*s/rad")
    rim = hs.effects.shunt(m="-0.002 kg*m^2", b="-0.01 N*m*s/rad")
    scene = hs.Scene(wheel, (column, rim, hs.effects.delay("4 ms")))
    found = hs.stability(scene, hs.Hand("firm", b="1 N*m*s/rad"))
    [mass] = found.critical[0][0].found
    assert float(mass.value) == 0.002
    assert (mass.chain_side, mass.stable_side) == ("below", None)
    assert "not below" in str(found)
    heavier = [hs.Hand(m, m=f"{m} kg*m^2", b="1 N*m*s/rad") for m in ("0.0021", "2")]
    assert [x.unstable for x in hs.stability(scene, heavier).held] == [4, 0]


def third_order(k: float, b: float, w: float) -> list[float]:
    """(0.5 s^2 + b s + k) (s + w) + 100 w: a spring of 100 N/m behind a lag, in a hand of 0.5 kg."""
    return [0.5, b + 0.5 * w, k + b * w, (k + 100) * w]


def test_of_a_rational_display_the_critical_values_are_those_of_routh() -> None:
    """a1 a2 = a0 a3 of the third order; here in the hand's numbers, the spring and, squared, the lag's frequency."""
    scene = hs.Scene(hs.environments.mass_spring_damper(k=100), (hs.effects.first_order_lag("7 rad/s"),))
    hand = hs.Hand("hand", m="0.5 kg", b=1, k=20)
    rows = {x.path: x.found for x in hs.stability(scene, hand, ["environment.k", "omega_c"]).critical[0]}
    for path, found in rows.items():
        for x in found:
            own = {"k": 20.0, "b": 1.0, "w": 7.0}
            value = float(x.value)
            if path == "environment.k":
                row = [*third_order(20, 1, 7)[:3], (20 + value) * 7]
            elif path == "hand.m":
                row = [value, 1 + value * 7, 20 + 7, 120 * 7]
            else:
                row = third_order(
                    **(own | {{"hand.b": "b", "hand.k": "k", "effects.first-order-lag.omega_c": "w"}[path]: value})
                )
            assert row[1] * row[2] == pytest.approx(row[0] * row[3], rel=1e-9), path
            assert x.omega is not None
            assert float(x.omega) == pytest.approx((row[2] / row[0]) ** 0.5, rel=1e-9)
    assert all(rows[path] for path in ("hand.b", "hand.k", "environment.k"))


whole, positive = st.integers(-9, 9), st.integers(1, 9)


def on_the_right(row: list[int], q: list[int], m: float, b: float, k: float) -> int:
    """Roots of row + (m s^2 + b s + k) q in Re s > 0, by eigenvalues; none may be near the axis."""
    real = np.roots(np.trim_zeros(np.polyadd(row, np.polymul([m, b, k], q)), "f")).real
    assume(len(real) == 0 or np.abs(real).min() > 1e-6)
    return int((real > 0).sum())


@given(st.lists(whole, min_size=2, max_size=3).filter(any), st.tuples(positive, positive), positive, positive, positive)
def test_between_critical_values_nothing_changes_and_beyond_them_it_does(
    row: list[int], q: tuple[int, int], m: int, b: int, k: int
) -> None:
    """H_perc = row/(s^2 + q1 s + q0), against eigenvalues on a grid of each number of the hand."""
    top = "+".join(f"({c})*s^{n}" for n, c in enumerate(reversed(row)))
    scene = display(f"({top})/(s^2 + {q[0]}*s + {q[1]})")
    below = [1, *q]
    home = on_the_right(row, below, m, b, k)
    answer = hs.stability(scene, hs.Hand("hand", m=m, b=b, k=k))
    assert answer.held[0].unstable == home
    for key, near in zip("mbk", answer.critical[0], strict=True):
        assert not near.reason
        start = float({"m": m, "b": b, "k": k}[key])
        values = [float(x.value) for x in near.found]
        low, high = (
            max([v for v in values if v <= start], default=0.0),
            min([v for v in values if v > start], default=50 * start),
        )
        for share in (0.01, 0.1, 0.3, 0.5, 0.7, 0.9, 0.99):
            own = {"m": m, "b": b, "k": k} | {key: low + share * (high - low)}
            if all(abs(own[key] - v) > 1e-4 * v for v in values):
                assert on_the_right(row, below, **own) == home
        for x in near.found:
            for change, told in ((0.9999, x.below), (1.0001, x.above)):
                own = {"m": m, "b": b, "k": k} | {key: float(x.value) * change}
                if float(x.value) > 0 and x.omega is not None:
                    assert on_the_right(row, below, **own) == told


def winding(scene: hs.Scene, hand: hs.Hand) -> int:
    """Roots with 1e-6 < Re s, |s| < 3000 by the turns of H_perc + Z times its denominator around a half disc."""
    H = scene.distortion().perc
    top = H.ring.expression(H.numerator) + H.ring.expression(H.denominator) * hand.Z
    f = lambdify(H.ring.meanings[0], top, "numpy")
    arc = 1e-6 + 3000 * np.exp(1j * np.linspace(-np.pi / 2, np.pi / 2, 200_001))
    axis = 1e-6 + 1j * 3000 * np.linspace(1, -1, 600_001)
    values = f(np.concatenate([arc, axis]))
    turn = np.angle(values[1:] / values[:-1])
    assert np.abs(turn).max() < 2.5
    return round(float(turn.sum()) / (2 * np.pi))


@pytest.mark.parametrize(
    "name",
    often(["delayed-spring", "position-force-teleoperation", "zener-tissue", "fu2019"], "delayed-spring".__eq__),
)
def test_beside_each_critical_value_a_contour_winds_around_as_many_roots_as_are_counted(name: str) -> None:
    scene = hs.load_scene(name).with_hands(hs.hands["device-operator"])
    near = hs.stability(scene, free=[x.path for x in scene.parameters if x.key not in ("alpha", "m")]).critical[0]
    told = [x for row in near for x in row.found if x.omega is not None and 1 < float(x.omega) < 2000]
    assert told
    for x in told:
        for share, expected in ((0.98, x.below), (1.02, x.above)):
            moved = scene.with_values({x.path: Rational(float(x.value) * share)})
            assert winding(moved, moved.hands[0]) == expected, x


BOXES = [
    ("delayed-spring", ("0.3", "1"), ("4", "10"), ("0", "500"), "all"),  # beyond b* = 3.6
    ("delayed-spring", ("0.3", "1"), ("3", "10"), ("0", "500"), "some"),
    ("delayed-spring", ("0.3", "1"), ("3.4", "10"), ("400", "500"), "all"),
    ("delayed-spring", ("0.3", "1"), ("0.1", "0.4"), ("0", "500"), "none"),
    ("delayed-spring", ("0", "1"), ("4", "10"), ("0", "500"), "all"),
    ("fu2019", ("0", "1"), ("0", "10"), ("0", "500"), "all"),
    ("satellite-contact", ("1", "400"), ("1", "10"), ("0", "500"), "none"),
]


@pytest.mark.few(2)
@pytest.mark.parametrize(("name", "m", "b", "k", "share"), BOXES)
def test_a_box_of_hands_is_decided_as_a_whole(name: str, m: Any, b: Any, k: Any, share: str) -> None:
    """Held against a grid of hands inside the box: all, none, or both kinds are stable."""
    box = hs.Hand("box", [*m], [*b], [*k])
    answer = hs.stability(name, box)
    assert answer.to_dict()["held"][0]["whole_box"] == share
    assert {"all": "stable in all of these hands.", "some": "but in some.", "none": "NOT stable in any"}[
        share
    ] in " ".join(str(answer).split())
    scene = hs.load_scene(name)
    shares = [Rational(n, 3) for n in range(4)]
    inside = [
        held(
            scene,
            hs.Hand(
                "one",
                *(Rational(x[0]) + u * (Rational(x[1]) - Rational(x[0])) for x, u in zip((m, b, k), at, strict=True)),
            ),
        ).stable
        for at in product(shares, repeat=3)
    ]
    assert {(True,): "all", (False,): "none"}.get(tuple(set(inside)), "some") == share


def test_between_masses_with_a_chain_of_roots_there_may_be_one_without() -> None:
    """H_perc = -40 s^2 q/(1 + 20 q), q = exp(-s/1000): m s^2 outweighs (20 m - 40) q s^2 between 40/21 and 40/19 kg alone."""
    port = hs.effects.two_port("-40", "0", "20/s^2", "1")
    scene = hs.Scene(hs.environments.mass_spring_damper(m=1), (hs.effects.delay("1 ms"), port))
    box = whole_box(scene, hs.Hand("box", m=[1, "2.5"], b=1, k=1))
    corners = [hs.Hand("one", m=m, b=1, k=1) for m in (1, "1.75", 2, "2.5")]
    assert [held(scene, x).stable for x in corners] == [False, False, True, False]
    assert box
    assert box.share is not Share.NONE


def test_how_far_a_hand_is_from_shaking_is_told_of_its_nominal_values() -> None:
    [row] = hs.stability("delayed-spring", hs.Hand("hand", "0.5 kg", "5 N*s/m +- 10 %")).to_dict()["held"]
    assert (row["hand"]["ranges"], row["whole_box"]) == ({"b": [4.5, 5.5]}, "all")
    assert row["critical"][0]["digits"] == "3.46359973276770"


@pytest.mark.few(2)
@pytest.mark.parametrize(
    ("name", "hand", "counts"),
    [
        ("delayed-spring", "light-touch", {0, 1, 2}), ("fu2019", "postural-arm", {0, 1}), ("satellite-contact", "postural-arm", {None}),
        ("position-force-teleoperation", "postural-arm", {0, 2}),
    ],
)  # fmt: skip
def test_the_cells_of_a_hands_plane_bear_the_number_of_roots_that_every_hand_in_them_has(
    name: str, hand: str, counts: set[int | None]
) -> None:
    from haptisym.verbs.stability.plane import plane

    scene, own = hs.load_scene(name), hs.hands[hand]
    low, high, least, most = window = (-130.0 if name in ("fu2019", "delayed-spring") else -25.0, 1800.0, -0.6, 12.5)
    found = plane(scene, own, window)
    assert {x.roots.number for x in found.cells if x.roots} == counts
    for x in found.cells:
        rows, columns = np.nonzero(x.pixels)
        k, b = (
            low + (rows + 0.5) * (high - low) / len(x.pixels),
            least + (columns + 0.5) * (most - least) / len(x.pixels),
        )
        for i in range(0, len(k), len(k) // 5 + 1):
            if k[i] >= 0 and b[i] >= 0:
                inside = hs.Hand("inside", own.m.value, Rational(float(b[i])), Rational(float(k[i])))
                assert x.roots is not None
                assert held(scene, inside).unstable == x.roots.number


def test_the_boundary_is_where_roots_lie_on_the_axis() -> None:
    """K exp(-j w tau) - m w^2 + j w b + k = 0 at every point of it."""
    from haptisym.verbs.stability.plane import plane

    found = plane(hs.load_scene("delayed-spring"), hs.Hand("hand", "0.5 kg"), (-130.0, 500.0, 0.0, 10.0))
    w = np.linspace(1, 34, 300)
    for x in w:
        at = (0.5 * x**2 - 100 * np.cos(0.036 * x), 100 * np.sin(0.036 * x) / x)
        assert np.hypot((found.k - at[0]) / 100, found.b - at[1]).min() < 0.02
    assert found.at_0 == -100


@pytest.mark.slow
def test_a_display_with_a_clock_has_no_plane_of_h_perc(call: Any, tmp_path: Any) -> None:
    status, out, err = call(
        "stability", "virtual-wall", "--hand", "light-touch", "--figure", str(tmp_path / "plane.svg")
    )
    assert status in (0, 3)
    assert "Held" in out
    assert "no figure: with a clock" in err
    _, _, told = call("stability", "fu2019", "--figure", str(tmp_path / "plane.svg"))
    assert "figure written" in told


SPRING, LATE_BY = hs.environments.mass_spring_damper(k=100), hs.effects.delay("36 ms")
ODD: list[tuple[hs.Scene, dict[str, Any], bool]] = [
    (hs.Scene(SPRING), {}, True), (hs.Scene(SPRING), {"m": 1}, False), (hs.Scene(SPRING), {"b": 1}, True),
    (hs.Scene(hs.environments.mass_spring_damper(m=1)), {"m": 1}, False), (hs.Scene(hs.environments.mass_spring_damper(b=1)), {}, False),
    (hs.Scene(SPRING, (LATE_BY,)), {}, True), (hs.Scene(SPRING, (LATE_BY,)), {"k": 50}, False), (hs.Scene(SPRING, (LATE_BY,)), {"k": 100}, False),
    (hs.Scene(SPRING, (LATE_BY,)), {"k": 150}, True), (hs.Scene(SPRING, (LATE_BY,)), {"b": 3}, True),
    (hs.Scene(SPRING, (hs.effects.shunt(m="-0.2 kg"),)), {"m": "0.1 kg", "b": 1}, False),
    (hs.Scene(SPRING, (hs.effects.shunt(m="-0.2 kg"),)), {"m": "0.2 kg", "b": 1}, True),
    (hs.Scene(hs.environments.kelvin_voigt(100, 2), (LATE_BY,)), {"b": 1}, False), (hs.Scene(SPRING, (hs.effects.series("1/s"),)), {"m": 1, "b": 1}, False),
]  # fmt: skip


@pytest.mark.few(5)
@pytest.mark.parametrize(("scene", "hand", "stable"), ODD)
def test_displays_at_the_edge_of_sense_get_an_answer(scene: hs.Scene, hand: dict[str, Any], *, stable: bool) -> None:
    """A spring alone has no motion of its own; a late one bounces from a weaker spring more each time, from a stiffer one less."""
    own = hs.Hand("hand", **hand)
    answer = hs.stability(scene, own, [x.path for x in scene.parameters])
    assert str(answer)
    assert json.loads(answer.to_json())
    assert answer.held[0].stable is stable


def test_what_is_felt_is_not_asked_of_a_hand() -> None:
    scene = hs.parse_scene(LATE.format(k=100) + "[hand]\nb = 4\n")
    for ask in (
        lambda: hs.derive(scene, ["hand.b"]),
        lambda: hs.require(scene, "hand.b"),
        lambda: hs.scene_code(scene, hs.Language.C, parameters=["b_h"]),
    ):
        with pytest.raises(hs.SceneError, match=r"^hand\.b changes nothing of what is felt: haptisym stability tells"):
            ask()


def test_a_threshold_and_a_number_without_a_hand_are_refused() -> None:
    with pytest.raises(hs.SceneError, match="evaluation.jnd is a threshold, which moves no root"):
        hs.stability("fu2019", "light-touch", ["c"])
    with pytest.raises(hs.SceneError, match="depends on the hand"):
        hs.stability("fu2019", free=["omega_n"])


@pytest.mark.parametrize("name", hs.hands)
def test_a_satellite_is_held_by_no_lighter_hand(name: str) -> None:
    [found] = hs.stability("satellite-contact", name).held
    assert (found.stable, found.unstable) == (False, None)
    assert "right" in str(found.roots.chain.value)
    assert unstable("satellite-contact", m=499, b=10**3, k=10**5) is None
    assert unstable("satellite-contact", m=600, b=10**3, k=10**5) is not None


@pytest.mark.parametrize(
    "name", ["fu2019", "steering-wheel", "sidestick", "two-mass-resonance", "desktop-device-soft-tissue"]
)
def test_displays_that_are_nowhere_active_are_held_by_every_passive_hand(name: str) -> None:
    found = hs.stability(name).to_dict()["every_passive_hand"]
    assert (found["holds"], found["active"]) == (True, [])


def test_a_spring_of_290_newtons_per_metre_needs_ten_and_a_half() -> None:
    found = hs.stability(hs.parse_scene(LATE.format(k=290)), digits=20).to_dict()["every_passive_hand"]
    assert (found["damping"], found["digits"], found["omega"]) == (10.44, "10.440000000000000000", 0)  # K tau


def test_no_damping_is_enough_where_a_mass_comes_late() -> None:
    for name in ("satellite-contact", "four-channel-teleoperation"):
        found = hs.stability(name)
        assert found.to_dict()["every_passive_hand"]["damping"] is None
        assert "grows without bound" in " ".join(str(found).split())


def display(perceived: str) -> hs.Scene:
    """A display whose H_perc is what is written."""
    return hs.Scene(hs.environments.mass_spring_damper(k=1), (hs.effects.series(perceived),))


@pytest.mark.parametrize(
    ("perceived", "holds"),
    [
        ("1 + s", True), ("s^2 + 1", True), ("1", True), ("s", True), ("s - 1", False), ("s - s^2", False), ("1 - s", False), ("s^3 + s", False),
        ("s^2/(s^2 + 4)", True), ("4 - s^2/(s^2 + 4)", False), ("s/(s - 1)", False), ("1/s", False), ("s^2*1/(s^2 + 4)^2", False), ("s^4", False),
        ("2 + s^2*(s^2 + 5)/(s^2 + 4)", True), ("2 + s^2*(s^2 + 1)/(s^2 + 4)", False), ("s*(s - 2)/(s + 1)", False),
    ],
)  # fmt: skip
def test_impedances_of_textbooks_are_positive_real_or_not(perceived: str, *, holds: bool) -> None:
    """s^2/(s^2 + 4) is a mass on a spring; 4 - that is one of negative residue; 1/s integrates position to force."""
    assert hs.stability(display(perceived)).every_passive_hand.holds is holds


def count(a: list[float], m: float, b: float, k: float) -> int:
    """Roots of a polynomial plus a hand in Re s > 0, by eigenvalues of its companion matrix."""
    own = np.polyadd(a, [m, b, k])
    return int((np.roots(own).real > 0).sum())


@pytest.mark.parametrize("b", [0.1, 1, 5])
def test_a_display_of_negative_damping_is_held_where_the_hand_damps_more(b: float) -> None:
    assert unstable(display("1 - 2*s + s^2"), m=1, b=b, k=3) == count([1, -2, 1], 1, b, 3)


def test_the_three_statements_are_in_the_document_each_by_its_name() -> None:
    found = json.loads(hs.stability("delayed-spring", ["light-touch", "postural-arm"], digits=20).to_json())
    assert (found["schema"], found["imposed"]) == ("haptisym.stability/1", {"stable": True, "unstable": 0})
    light, arm = found["held"]
    assert (light["stable"], light["unstable"], arm["stable"], arm["unstable"]) == (False, 2, True, 0)
    assert {key: arm["hand"][key] for key in ("name", "m", "b", "k")} == {
        "name": "postural-arm",
        "m": 0.554,
        "b": 6.45,
        "k": 135.0,
    }
    every = found["every_passive_hand"]
    assert (every["holds"], every["damping"], every["omega"]) == (False, 3.6, 0.0)
    assert every["active"][0] == pytest.approx([0, np.pi / 0.036])
    assert (found["sampled"], found["certified"]) == (None, True)


def test_what_has_a_friction_is_not_decided() -> None:
    assert not hs.stability("stick-with-friction", "postural-arm").certified


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--hand", "postral-arm"], 'there is no hand "postral-arm": did you mean "postural-arm"? the package ships'),
        (["--hand", "light-touch", "--hand", "light-touch"], 'the hand "light-touch" is asked about twice'),
    ],
)
def test_a_wrong_hand_is_told_in_one_sentence(call: Any, words: list[str], told: str) -> None:
    status, out, err = call("stability", "fu2019", *words)
    assert (status, out) == (2, "")
    assert told in err.replace("\n", " ")


def test_a_hand_that_moves_along_a_line_does_not_turn_a_wheel(call: Any) -> None:
    status, _, err = call("stability", "steering-wheel", "--hand", "postural-arm")
    assert status == 2
    assert "translation and rotation cannot be mixed" in err


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ('[hand]\nm = "-1 kg"', 'hand: m: "-1 kg" must be >= 0'),
        ("[hand]\nmass = 1", 'hand: unknown key "mass": '),
        ("[[hands]]\nm = 1", "hands[1]: name: each of several hands needs one"),
        ("[[hand]]\nm = 1", "hand: one is written [hand]; several are written [[hands]], with an s"),
        ('[[hands]]\nname = "a"\n[[hands]]\nname = "a"', 'hands: "a" is there twice'),
        ('[hand]\nm = 1\n[[hands]]\nname = "a"', "hand: give either [hand] or [[hands]]"),
        ('[hand]\nm = "1 kg"\nb = "1 N*m*s/rad"', "translation and rotation cannot be mixed"),
        ('[hand]\nb = "1 N"', '"1 N" is not a damping: expected N*s/m or N*m*s/rad'),
        ("[hand]\nsource = 3", 'source: "3" must be a string'),
    ],
)
def test_a_wrong_hand_in_a_file_is_told_in_one_sentence(text: str, told: str) -> None:
    with pytest.raises(hs.SceneError) as error:
        hs.parse_scene(LATE.format(k=100) + text)
    assert told in str(error.value)
    assert "\n" not in str(error.value)


def test_hands_have_knobs_that_change_nothing_of_what_is_felt() -> None:
    text = (
        LATE.format(k=100) + '[[hands]]\nname = "weak"\nb = ["1 N*s/m", "2 N*s/m"]\n[[hands]]\nname = "strong"\nb = 9\n'
    )
    scene = hs.parse_scene(text)
    assert [x.path for x in scene.parameters] == ["environment.k", "effects.delay.tau"]
    assert scene.nominal_note == ""
    assert scene.knobs["hands.weak.b"].interval == (1, 2)
    moved = scene.with_values({"hands.strong.m": "2 kg"})
    assert [x.m.value for x in moved.hands] == [0, 2]
    one = hs.parse_scene(LATE.format(k=100) + "[hand]\nm = 1\n")
    assert {one.knobs[x].path for x in ("hand.m", "hands.hand.m", "m_h")} == {"hand.m"}
    for name in hs.hands:
        assert hs.hands[name].source


@pytest.mark.slow
def test_a_delay_is_free_beside_others_of_which_products_are_made() -> None:
    """The shunt makes the display neutral whatever the delay is: nowhere does it become stable, as each one asked alone says."""
    scene = hs.Scene(
        hs.environments.kelvin_voigt("300 N/m", "2 N*s/m"),
        (
            hs.effects.delay("20 ms", name="late"),
            hs.effects.shunt(m="0.1 kg", b="1 N*s/m"),
            hs.effects.wave_variables("8 N*s/m", "7 ms"),
        ),
    )
    hand = hs.Hand("light", m="0.5 kg", b="5 N*s/m", k="200 N/m")
    [free] = [x for x in hs.stability(scene, hand, ["late.tau"]).critical[0] if x.path.endswith("late.tau")]
    assert free.found == ()
    for tau in ("1 ms", "20 ms", "507 ms", "2 s"):
        assert hs.stability(scene.with_values({"late.tau": tau}), hand).held[0].stable is False


@given(*[st.one_of(st.none(), st.integers(-4, 4))] * 4)
def test_a_gap_meets_what_is_asked_about_where_they_have_more_than_an_end_in_common(
    low: int | None, high: int | None, start: int | None, end: int | None
) -> None:
    if (low is not None and high is not None and low >= high) or (
        start is not None and end is not None and start >= end
    ):
        return
    gap = Gap(*(None if x is None else ExactNumber(Integer(x)) for x in (low, high)))
    asked = Domain(*(None if x is None else Integer(x) for x in (start, end)))
    inner = [n + 0.5 for n in range(-6, 6)]
    both = [
        x
        for x in inner
        if (low is None or low < x)
        and (high is None or x < high)
        and (start is None or start < x)
        and (end is None or x < end)
    ]
    assert _meets(gap, asked) is bool(both)


def test_beyond_a_window_that_was_cut_all_is_open_for_a_reason() -> None:
    window = Meetings((), Integer(2), Integer(5), (Gap(None, None, "of its own"),))
    found = _cut(window, "too many")
    assert [(x.low, x.high, x.reason) for x in found.gaps] == [
        (None, None, "of its own"),
        (None, ExactNumber(Integer(2)), "too many"),
        (ExactNumber(Integer(5)), None, "too many"),
    ]
    assert (found.above, found.below, found.found) == (None, None, ())
    assert _cut(Meetings(()), "too many").gaps == ()
