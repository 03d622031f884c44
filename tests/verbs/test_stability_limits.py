"""How far a number may go before a display in a hand shakes, and all values with which it does not: against counts of roots."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import inf
from random import Random
from typing import Any

import mpmath
import numpy as np
import pytest
from heldloops import by_eigenvalues, display, drawn, number, on_the_right
from hypothesis import assume, given
from hypothesis import strategies as st
from sympy import Poly, Rational, Symbol, expand, lambdify, pi, sympify
from windings import late_mass, winding

import haptisym as hs
from haptisym.judge.bindings import STABLE, STEADY, stable_in
from haptisym.judge.passivity import is_positive_real_by_signs
from haptisym.kernel.budget import limited, timed_by
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.rings import s
from haptisym.kernel.rootcount import RootChain
from haptisym.kernel.sets import STOPPED, SingleValue, Stretch, Verdict
from haptisym.model.catalogue import ENVIRONMENTS
from haptisym.model.parameters import FractionalOrder, FractionalStiffness, PositiveStiffness
from haptisym.model.valueranges import ALLOWED
from haptisym.verbs.require.required import Requirement
from haptisym.verbs.stability.held import held, roots_in_hand
from haptisym.verbs.stability.limits import open_beside, stable_values

E, F = hs.environments, hs.effects
LATE = 'environment = {{ model = "mass-spring-damper", k = "{k} N/m" }}\neffects = [{{ model = "delay", tau = "36 ms" }}]\n'
ARM = hs.hands["postural-arm"]
Count = Callable[[float], int | None]
q = Symbol("q")


def nearest(scene: hs.Scene, path: str) -> hs.ValueSet:
    """Of a number of a display or of its first hand, what is stable next to its value; steady where it drifts."""
    knob, hand = scene.knobs[scene.knobs.chosen([path])[0].path], scene.hands[0]
    what = STEADY if held(scene, hand).drifts else STABLE
    return stable_values(scene, hand, knob, ALLOWED[knob.rule], stable_in(hand, what), near=True)


def ends_of(scene: hs.Scene, path: str) -> list[tuple[SingleValue, str | None]]:
    """Where that ends, each end with the side that is stable; nothing next to the present value is open."""
    found = nearest(scene, path)
    assert open_beside(scene.knobs[scene.knobs.chosen([path])[0].path], found) == []
    return sides(found)


def sides(found: hs.ValueSet) -> list[tuple[SingleValue, str | None]]:
    return [
        (x, None if piece.is_single else "above" if x is piece.first else "below")
        for piece in found.feasible
        for x in piece.ends
        if x in found.ends
    ]


def said(found: hs.ValueSet, value: float) -> bool | None:
    """The verdict on a value; None where that is open."""
    verdict = found.about(ExactNumber(Rational(value))).verdict
    return None if verdict is Verdict.UNDECIDED else verdict is Verdict.HOLDS


def counted_at(scene: hs.Scene, path: str, reach: float = 500.0) -> Count:
    """Roots at one value after another, by winding numbers."""

    def count(value: float) -> int | None:
        return on_the_right(scene.with_values({scene.knobs.chosen([path])[0].path: Rational(value)}), reach)

    return count


def need_nearest(found: hs.ValueSet, start: float, count: Count, far: tuple[float, float]) -> None:
    """What is said agrees with a count beside each end that is told, and on the way out from a value, of which it is known."""
    assert said(found, start) is not None
    near = [float(x.value) * share for x in found.ends for share in (0.9999, 1.0001)]
    out = [start + x * (end - start) for end in far for x in (0.02, 0.3, 0.6, 0.9, 0.999)]
    for value in (x for x in (*near, *out) if min(far) <= x <= max(far)):
        told, wound = said(found, value), count(value)
        assert told is None or wound is None or told == (wound == 0), (found, value, wound)


# --- the nearest changes -----------------------------------------------------------------------------------------------

CRITICAL = [  # spring, hand, path, value, rad/s, stable side: computed elsewhere
    (100, {"m": "0.5 kg", "b": 1}, "hand.b", "3.4635997327677041014", 13.320697368492448, "above"),
    (100, {"m": "0.5 kg", "b": 9, "k": 100}, "hand.b", "3.3297497532862287950", 18.858713273231587, "above"),
    (100, {"m": "0.5 kg", "b": 1, "k": 500}, "hand.b", "2.8197283310552300722", 32.802726231761795, "above"),
    (100, {"m": "0.5 kg", "b": 1, "k": 1000}, "hand.b", "2.2386594085525189552", 44.64024101711087, "above"),
    (290, {"m": "0.5 kg", "b": 1}, "hand.b", "9.5037390727713175455", 20.660047835266866, "above"),
    (290, {"m": "0.5 kg", "b": 1, "k": 100}, "hand.b", "9.1877001353127948759", 24.010212956148372, "above"),
    (290, {"m": "0.5 kg", "b": 1, "k": 500}, "hand.b", "7.9599529917453498043", 34.4665745428735, "above"),
    (290, {"m": "0.5 kg", "b": 1, "k": 1000}, "hand.b", "6.5113668307878865184", 44.515059476572006, "above"),
    (100, {"m": "0.554 kg", "b": "6.45", "k": 135}, "environment.k", "199.85210225871012834", 22.244306341605846, "below"),
]  # fmt: skip


@pytest.mark.dear(
    "100-hand3-hand.b-2.2386594085525189552-44.64024101711087-above",
    "290-hand7-hand.b-6.5113668307878865184-44.515059476572006-above",
)
@pytest.mark.few(3)
@pytest.mark.parametrize(("k", "hand", "path", "value", "omega", "side"), CRITICAL)
def test_how_far_a_number_may_go_is_told_to_any_digits(
    k: int, hand: dict[str, Any], path: str, value: str, omega: float, side: str
) -> None:
    scene = hs.parse_scene(LATE.format(k=k))
    found = hs.stability(scene, hs.Hand("hand", **hand), ["environment.k"], digits=20).to_dict()
    [row] = [x for x in found["held"][0]["critical"] if x["path"] == path]
    assert (row["digits"], row["stable_side"]) == (value, side)
    assert row["omega"] == pytest.approx(omega, rel=1e-15)
    low, high = row["enclosure"]
    assert Rational(low) < Rational(high)
    assert float(low) == float(high) == pytest.approx(float(value), rel=1e-15)


def test_the_delay_that_a_hand_bears_is_the_one_at_which_its_spring_is_critical() -> None:
    """K exp(-j w tau) = -Z: at K = 199.85... and tau = 36 ms; the other way round tau is critical at 36 ms for that K."""
    scene = hs.parse_scene(LATE.format(k="199.85210225871012834")).with_hands(ARM)
    assert float(ends_of(scene, "tau")[0][0].value) == pytest.approx(0.036, rel=1e-14)


def test_a_damper_beside_its_late_self_leaves_single_stiffnesses_at_which_a_hand_without_damping_rings() -> None:
    """Of s^2 + s (1 + exp(-s)) + k the damping 1 + cos(omega) is 0 at odd multiples of pi: k = (n pi)^2 rings for ever."""
    late = (hs.effects.delay("1 s"), hs.effects.shunt(b=1))
    scene = hs.Scene(E.mass_spring_damper(b=1), late, hands=(hs.Hand("undamped", m=1, b=0, k=5),))
    found = nearest(scene, "hand.k")
    first = [float(x.value) for x in found.ends[:5]]  # each single value ends the one interval and begins the next
    assert first == pytest.approx([0, *2 * [np.pi**2], *2 * [9 * np.pi**2]], rel=1e-12)
    assert [said(found, x) for x in (0.1, 5, 9.86)] == [True] * 3
    assert held(scene, hs.Hand("stiffer", m=1, b=0, k="9.88")).stable


def test_how_far_a_hand_is_from_shaking_is_told_of_its_nominal_values() -> None:
    scene = hs.load_scene("delayed-spring").with_hands(hs.Hand("hand", "0.5 kg", "5 N*s/m +- 10 %"))
    [(row, _)] = ends_of(scene, "hand.b")
    assert row.value.digits(15) == "3.46359973276770"


def lagged(k: float = 20, b: float = 1, w: float = 7, m: float = 0.5) -> list[float]:
    """A spring of 100 N/m behind a lag of w, in a hand: (m s^2 + b s + k) (s + w) + 100 w."""
    return [m, b + m * w, k + b * w, (k + 100) * w]


@pytest.mark.parametrize("path", ["hand.m", "hand.b", "hand.k", "environment.k", "omega_c"])
def test_of_a_rational_display_the_critical_values_are_those_of_routh(path: str) -> None:
    """a1 a2 = a0 a3 of the third order, at sqrt(a2/a0)."""
    scene = hs.Scene(
        E.mass_spring_damper(k=100), (F.first_order_lag("7 rad/s"),), hands=(hs.Hand("hand", "0.5", 1, 20),)
    )
    found = ends_of(scene, path)
    assert found or path in ("hand.m", "omega_c")
    for x, _ in found:
        value = float(x.value)
        row = (
            [*lagged()[:3], (20 + value) * 7]
            if path == "environment.k"
            else lagged(**{path.replace("omega_c", "w")[-1]: value})
        )
        assert row[1] * row[2] == pytest.approx(row[0] * row[3], rel=1e-9)
        assert float(x.bindings[0].omega) == pytest.approx((row[2] / row[0]) ** 0.5, rel=1e-9)


@pytest.mark.few(8)
@pytest.mark.parametrize("seed", range(24))
def test_beside_a_rational_display_the_count_of_eigenvalues_changes_at_what_is_told_and_nowhere_nearer(
    seed: int,
) -> None:
    """H_perc = row/(s^2 + q1 s + q0), in each number of the hand."""
    draw = Random(seed)
    row, below = [draw.randint(-9, 9) for _ in range(draw.choice([2, 3]))], [1, draw.randint(1, 9), draw.randint(1, 9)]
    hand = {key: draw.randint(1, 9) for key in "mbk"}
    top = "+".join(f"({c})*s^{n}" for n, c in enumerate(reversed(row)))
    scene = display(f"({top})/(s^2 + {below[1]}*s + {below[2]})").with_hands(hs.Hand("hand", **hand))
    for key, start in hand.items():

        def count(value: float, key: str = key) -> int | None:
            own = {**hand, key: value}
            return by_eigenvalues(lambda _: np.polyadd(row, np.polymul([own[x] for x in "mbk"], below)), value)

        need_nearest(nearest(scene, f"hand.{key}"), start, count, (1e-3 * start, 50 * start))


@pytest.mark.dear("1-2", "4-3", "5-3", "6-2", "7-3")
@pytest.mark.few("5-3", "4-3", "7-3", "6-2", "1-2", "5-1")
@pytest.mark.parametrize("degree", [1, 2, 3])
@pytest.mark.parametrize("seed", range(8))
def test_a_number_may_stand_in_powers_in_all_coefficients(degree: int, seed: int) -> None:
    """C = (s^2 + w^2) A + (q - v) B, so that +-j w are roots at q = v."""
    draw = Random(10 * degree + seed)
    w, v = Rational(draw.randint(2, 9), draw.randint(1, 4)), Rational(draw.randint(1, 9), draw.randint(1, 4))

    def polynomial(most: int, powers: int) -> Any:
        return sum(draw.randint(-2, 3) * q**i * s**n for i in range(powers + 1) for n in range(most + 1))

    C = expand((s**2 + w**2) * (s + 2 + polynomial(1, degree - 1)) + (q - v) * (s**2 + 2 + polynomial(2, degree - 1)))
    start = v * Rational(draw.choice([9, 11]), 10)
    scene = display(str(expand(C - s**2 - 2 * s - 3)).replace("**", "^"), q=start).with_hands(hs.Hand("hand", 1, 2, 3))
    rows = lambdify(q, Poly(C, s).all_coeffs())

    def count(value: float) -> int | None:
        return by_eigenvalues(rows, value)

    need_nearest(nearest(scene, "q"), float(start), count, (float(start) - 8, float(start) + 8))


LAGS = {"one": ("1/40", 0), "multiples": ("1/50", "1/100"), "pi": (pi / 200, "3/200")}
PORTS: dict[str, tuple[Any, str, str, str]] = {
    "once": (Rational(1, 5), "q", "1", "1"),
    "twice": (2, "q", "q", "1"),
    "a damper": (2, "1", "q*s/5", "1"),
    "in all": (3, "9", "20*q", "1 + q/30"),
    "squared": (1, "q + 2", "q*s/9 + q^2/200", "1"),
    "squared, far": (40, "q", "q^2/200", "1"),
}


@pytest.mark.dear("a damper-pi", "once-one", "twice-pi")
@pytest.mark.few("once-one", "twice-pi", "a damper-pi", "in all-multiples")
@pytest.mark.parametrize("lags", LAGS)
@pytest.mark.parametrize("port", PORTS)
def test_a_number_may_stand_before_several_products_of_delays(port: str, lags: str) -> None:
    """C = 11 a exp(-s (t1 + t2)) + b exp(-s t2) + d (0.5 s^2 + 6 s + 50)."""
    start, a, b, d = PORTS[port]
    one, other = (Rational(x) if isinstance(x, str) else x for x in LAGS[lags])
    late = F.delay(one), F.two_port(a, b, "0", d, parameters={"q": start}), *([F.delay(other)] if other else [])
    scene = hs.Scene(E.mass_spring_damper(k=11), late, hands=(hs.Hand("hand", "1/2", 6, 50),))
    parts = [lambdify((s, q), sympify(x, {"s": s, "q": q}, convert_xor=True), "numpy") for x in (a, b, d)]

    def count(value: float) -> int | None:
        def f(z: Any) -> Any:
            A, B, D = (x(z, value) + 0 * z for x in parts)
            return (11 * A * np.exp(-z * float(one)) + B) * np.exp(-z * float(other)) + D * (z * z / 2 + 6 * z + 50)

        return winding(f, 3000.0)

    found = nearest(scene, "q")
    assert found.ends
    need_nearest(found, float(start), count, (float(start) - 5, float(start) + 20))


@pytest.mark.slow
def test_fifty_digits_of_a_number_in_two_products_of_delays_are_those_of_another_root_finder() -> None:
    port = F.two_port("q", "q^2/200", "0", "1", parameters={"q": 40})
    scene = hs.Scene(
        E.mass_spring_damper(k=11), (F.delay("1/50"), port, F.delay(pi / 200)), hands=(hs.Hand("hand", "1/2", 6, 50),)
    )
    found = ends_of(scene, "q")[0][0]
    exact = mpmath.mp.clone()
    exact.dps = 70

    def parts(omega: Any, x: Any) -> list[Any]:
        z = exact.mpc(0, omega)
        late = 11 * x * exact.exp(-z / 50) + x**2 / 200
        y = late * exact.exp(-z * exact.pi / 200) + z * z / 2 + 6 * z + 50
        return [y.real, y.imag]

    frequency = found.bindings[0].omega
    omega, value = exact.findroot(parts, (float(frequency), float(found.value)))
    assert exact.almosteq(exact.mpf(found.value.digits(52)), value, rel_eps=exact.mpf(10) ** -50)
    assert exact.almosteq(exact.mpf(frequency.digits(52)), omega, rel_eps=exact.mpf(10) ** -50)


@pytest.mark.dear("18", "8", "9")
@pytest.mark.few(4)
@pytest.mark.parametrize("seed", range(24))
def test_beside_a_late_display_the_winding_number_changes_at_what_is_told_and_nowhere_nearer(seed: int) -> None:
    draw = Random(seed)
    hand = hs.Hand("hand", number(draw, 0.5, 2), number(draw, 2, 25), number(draw, 1, 300))
    scene = drawn(draw, late=True).with_hands(hand)
    knob = draw.choice([x for x in scene.knobs if "jnd" not in x.path and not x.path.endswith(".m")])
    start = float(knob.value)
    need_nearest(nearest(scene, knob.path), start, counted_at(scene, knob.path), (start / 20, 6 * start))


@pytest.mark.few("delayed-spring")
@pytest.mark.parametrize(
    "name", ["delayed-spring", "position-force-teleoperation", "four-channel-teleoperation", "zener-tissue", "fu2019"]
)
def test_beside_each_critical_value_of_a_shipped_scene_a_contour_winds_around_as_many_roots_as_are_told(
    name: str,
) -> None:
    scene = hs.load_scene(name).with_hands(hs.hands["device-operator"])
    paths = [x.path for x in scene.parameters if x.key not in ("alpha", "m")]
    told = [(path, *row) for path in paths for row in sides(nearest(scene, path))]
    told = [(path, x, side) for path, x, side in told if (w := x.bindings[0].omega) is not None and 1 < float(w) < 2000]
    assert told
    for path, x, side in told:
        count = counted_at(scene, path, 3000.0)
        counts = [count(float(x.value) * share) for share in (0.98, 1.02)]
        assert [y == 0 for y in counts] == [side == "below", side == "above"], path


def test_a_root_passes_through_0_at_an_exact_value() -> None:
    """s^2 + (2 + q) s + q^2 + q/2 - 1: stable from the root of q^2 + q/2 = 1 on."""
    scene = display("q*s + q^2 + q/2 - 4", q=1).with_hands(hs.Hand("hand", 1, 2, 3))
    [(row, side)] = ends_of(scene, "q")
    assert (row.value.digits(12), float(row.bindings[0].omega), side) == ("0.780776406404", 0, "above")


@pytest.mark.parametrize(
    ("points", "verdicts", "told"),
    [
        ((1, 50), (True, True, None), ("50",)), ((1, 5), (None, True, True), ("1",)), ((1, 50), (True, None, True), ("1", "50")),
        ((), (None,), ()), ((1, 5, 50), (None, True, True, None), ("1", "50")),
    ],
)  # fmt: skip
def test_of_values_that_stay_open_the_ends_are_told_that_they_have(
    points: tuple[int, ...], verdicts: tuple[bool | None, ...], told: tuple[str, ...]
) -> None:
    knob = hs.load_scene("delayed-spring").knobs["tau"]  # 36 ms
    at = [SingleValue(ExactNumber(Rational(x, 1000)), holds=True) for x in points]
    found = hs.ValueSet(tuple(at), tuple(Stretch(x, "" if x else "why") for x in verdicts))
    said = [x.split() for x in open_beside(knob, found)]
    assert [word for words in said for word in words if word.isdigit()] == [*told]
    assert all(word[-1] in ("why", "ms") for word in said)


def test_beside_a_critical_value_that_is_also_the_end_of_what_was_looked_at_the_count_is_that_beside_it() -> None:
    """m s^2 + s + (1 + 15 s/8) exp(-s pi/2) is 0 at s = j for m = 15/8; at 0 there is a chain."""
    scene = hs.Scene(E.kelvin_voigt(1, "15/8"), (F.delay(pi / 2),), hands=(hs.Hand("hand", 2, 1),))
    [(row, side)] = ends_of(scene, "hand.m")
    assert (float(row.value), side) == (1.875, "above")
    count = counted_at(scene, "hand.m", 60)
    assert [count(x) for x in (1.85, 1.9)] == [2, 0]


@pytest.mark.slow
def test_a_root_that_comes_to_the_axis_and_goes_back_changes_no_count() -> None:
    """s^2 + (q - 2)^2 s (2 + exp(-s/10)) + 1: at q = 2 alone it has roots at +-j; that may stay open, but is never lost."""
    port = F.two_port("(q - 2)^2*s", "2*(q - 2)^2*s", "0", "1", parameters={"q": 1})
    scene = hs.Scene(E.mass_spring_damper(k=1), (F.delay("1/10"), port), hands=(hs.Hand("hand", 1, 0, 1),))
    assert not nearest(scene, "q").ends


@pytest.mark.slow
def test_what_moves_together_is_critical_by_its_sum() -> None:
    """The master's mass and the hand's stand in one place: 0.1 kg and 0.5 kg in the scene."""
    scene = hs.load_scene("position-force-teleoperation").with_hands(hs.hands["light-touch"])
    masses = []
    for path, other in (("effects.teleoperator.Mm", "0.1"), ("hand.m", "0.5")):
        [(row, side)] = ends_of(scene, path)
        assert side == "above"
        masses.append(mpmath.mpf(row.value.digits(15)) + mpmath.mpf(other))
    assert abs(masses[0] - masses[1]) < 1e-14


@pytest.mark.slow
def test_the_order_of_a_tissue_has_a_critical_value() -> None:
    """(80 s^alpha + 120) exp(-s/500) 50 pi/(s + 50 pi), held by 0.1 kg and 0.1 N s/m."""
    scene = hs.load_scene("organ-tissue").with_hands(hs.hands["light-touch"])
    [(value, side), (other, beyond)] = ends_of(scene, "environment.alpha")
    at = float(value.value)
    assert (side, beyond, at) == ("above", "below", pytest.approx(0.461113, abs=1e-6))

    def roots(alpha: float) -> int | None:
        def f(x: Any) -> Any:
            return (80 * x**alpha + 120) * np.exp(-x / 500) * 50 * np.pi + (x**2 / 10 + x / 10) * (x + 50 * np.pi)

        return winding(f, 5000.0)

    assert [roots(at * x) for x in (0.8, 0.9999, 1.0001, 1.2)] == [2, 2, 0, 0]
    allowed = hs.require(scene, "environment.alpha", that="stable")
    [(low, high)] = spans(allowed)
    assert (low, high, allowed.certified) == (at, pytest.approx(0.808841, abs=1e-6), True)
    assert float(other.value) == high
    assert [roots(high * x) for x in (0.9999, 1.0001, 1.1)] == [0, 2, 2]


# --- both sides of a limit ------------------------------------------------------------------------------------------------

HOLDS_NOTHING = hs.Hand("hand")
DAMPER = hs.Scene(E.mass_spring_damper(b=0), (F.delay("10 ms"),), hands=(hs.Hand("hand", m=1, k=10),))
SHUNTED = hs.Scene(
    E.mass_spring_damper(k=100, b=3), (F.delay("10 ms"), F.shunt(m="0.1", k=-100)), hands=(HOLDS_NOTHING,)
)
HELD = hs.Scene(E.mass_spring_damper(m=1), hands=(hs.Hand("hand", k=10),))
FREE, JERK = (hs.Scene(x, hands=(HOLDS_NOTHING,)) for x in (E.mass_spring_damper(m=1), E.expression("s^3 + 2*s^2")))
LEAD = F.delay("10 ms"), F.series("1 + s/w", parameters={"w": 180})
NEUTRAL = hs.Scene(E.mass_spring_damper(m=1), LEAD, hands=(hs.Hand("hand", b=1),))
LONE = hs.Scene(E.expression("q*s^2 + 10", parameters={"q": 1}), hands=(HOLDS_NOTHING,))
SIDES: dict[str, tuple[hs.Scene, str, list[tuple[float, float]]]] = {
    # s^2 + 10 + b s exp(-s/100) is 0 at j omega, omega = 50 pi, for b = (omega^2 - 10)/omega
    "a late damper": (DAMPER, "environment.b", [(0, 157.015970702253)]),
    "a mass beside a spring alone": (DAMPER, "hand.m", [(0, 0)]),
    "a delay of nothing": (DAMPER, "tau", []),
    # s^2/10 + K + (3 s + k) exp(-s/100): computed elsewhere
    "a hand beside a shunt": (SHUNTED, "hand.k", [(0, 1443.8396439066)]),
    "a late spring beside a shunt": (SHUNTED, "environment.k", [(100, 278.6171260293)]),
    "a shunt": (SHUNTED, "effects.shunt.k", [(-100, 1343.8396439066)]),
    # m s^2 + k has the root sqrt(-k/m), or two on the axis
    "damping of what has none": (HELD, "hand.b", [(0, inf)]),
    "stiffness of what has no damping": (HELD, "hand.k", []),
    "mass of what has no damping": (HELD, "environment.m", []),
    # s^2 + k and s^3 + 2 s^2 + k drift at k = 0, and shake for all others
    "a spring of a free mass": (FREE, "hand.k", [(0, 0)]),
    "a spring of a free jerk": (JERK, "hand.k", [(0, 0)]),
    "damping of a free mass": (FREE, "hand.b", []),
    # the highest power is delayed for all w != 0, and there is no display for w = 0
    "a lead behind a delay": (NEUTRAL, "w", []),
    # q s^2 + 10 has no root for q = 0, and else one on the right or two on the axis
    "a mass of either sign": (LONE, "q", [(0, 0)]),
}  # fmt: skip


def windows(found: hs.ValueSet) -> list[tuple[float, float]]:
    """What holds, with its ends: infinite, or 0, where there are none."""
    return [(-inf if x.low is None else float(x.low), inf if x.high is None else float(x.high)) for x in found.feasible]


@pytest.mark.few(
    "a hand beside a shunt", "a mass beside a spring alone", "a delay of nothing", "damping of what has none",
    "stiffness of what has no damping", "a spring of a free mass", "a lead behind a delay", "a mass of either sign",
)  # fmt: skip
@pytest.mark.parametrize("case", SIDES)
def test_next_to_a_limit_the_values_that_are_stable_are_told_with_both_ends_and_one_value_alone_as_one(
    case: str,
) -> None:
    scene, path, expected = SIDES[case]
    found = nearest(scene, path)
    shown = windows(found) if found.ends else []
    left = open_beside(scene.knobs[scene.knobs.chosen([path])[0].path], found)
    assert (left, shown) == ([], [pytest.approx(x, rel=1e-8) for x in expected])
    told = [(float(x.value), side) for x, side in sides(found) if side]
    known = [(x, side) for y in expected for x, side in zip(y, ("above", "below"), strict=True) if y[0] < y[1]]
    assert told == [(pytest.approx(x, rel=1e-8), side) for x, side in known if x < inf]


def need_agreement(scene: hs.Scene, path: str) -> None:
    """What is said of values next to the present one is what `require` says of them."""
    near, own = nearest(scene, path), scene.knobs[path]
    asked = hs.require(scene, path, that="steady" if held(scene, scene.hands[0]).drifts else "stable")
    places = [float(x.value) * share for x in near.ends for share in (0.999, 1.001)]
    for value in (*places, float(own.value), 0.5 * float(own.value), 3 * float(own.value)):
        if own.rule.allows(Rational(value)):
            assert None in (said(near, value), verdict(asked, value)) or said(near, value) == verdict(asked, value), (
                value
            )


SHIPPED = ["delayed-spring", "four-channel-teleoperation", "fu2019", "admittance-display", "satellite-contact", "organ-tissue",
           "position-force-teleoperation", "virtual-coupling", "wave-variable-link", "zener-tissue"]  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("hand", ["light-touch", "postural-arm", "firm-grip"])
@pytest.mark.parametrize("name", SHIPPED)
def test_limits_of_shipped_scenes_are_the_ends_of_what_is_required(name: str, hand: str) -> None:
    scene = hs.load_scene(name)
    own = scene.with_hands(hs.hands[hand]) if not scene.hands else scene
    for knob in (x for x in own.knobs if not x.parts):
        need_agreement(own, knob.path)


@st.composite
def balanced(draw: st.DrawFn) -> hs.Scene:
    """Scenes whose numbers are often limits: nothing damps them, or one spring takes away what another one gives."""
    m, b, k, hm, hb, hk = (
        draw(st.sampled_from(x)) for x in ([0, 1, 2], [0, 0, 3], [5, 100], [0, 1], [0, 0, 2], [0, 10])
    )
    late = [F.delay(x) for x in draw(st.sampled_from([[], ["10 ms"], ["2 ms"]]))]
    lag = [F.first_order_lag(20)] if draw(st.booleans()) else []
    shunt = [F.shunt(m=draw(st.sampled_from([0, "0.1"])), k=-k - hk)] if draw(st.booleans()) else []
    return hs.Scene(E.mass_spring_damper(m, b, k), (*lag, *late, *shunt), hands=(hs.Hand("hand", hm, hb, hk),))


@pytest.mark.slow
@pytest.mark.core
@given(balanced(), st.integers(0, 99))
def test_limits_at_the_present_value_are_the_ends_of_what_is_required_and_nothing_winds_beside_them(
    scene: hs.Scene, which: int
) -> None:
    knobs = [x for x in scene.knobs if not x.parts]
    path = knobs[which % len(knobs)].path
    assume(held(scene, scene.hands[0]).roots is not None)
    need_agreement(scene, path)
    count, checked = counted_at(scene, path, 2000.0), 0
    for low, high in windows(nearest(scene, path)):
        if low < high:
            inside = low + 0.5 * (min(high, low + 100) - low) if low > -inf else high - 0.1 * abs(high or 1)
            found = count(float(Rational(f"{inside:.6g}")))
            assert found in (0, None), (path, low, high)
            checked += found == 0
    assume(checked)


# --- all values ---------------------------------------------------------------------------------------------------------


def spans(found: Requirement) -> list[tuple[float, float]]:
    return [(-inf if x.low is None else float(x.low), inf if x.high is None else float(x.high)) for x in found.feasible]


def verdict(found: Requirement, value: float) -> bool | None:
    """Whether a value is in the set; None where that is open."""
    if any(
        (a is None or float(a) <= value) and (b is None or value <= float(b))
        for a, b in ((p.low, p.high) for p in found.undecided)
    ):
        return None
    return any(
        low < value < high or (low == value and x.closed[0]) or (high == value and x.closed[1])
        for (low, high), x in zip(spans(found), found.feasible, strict=True)
    )


def need_set(found: Requirement, count: Count, values: Sequence[float]) -> None:
    """What is said agrees with a count, on both sides of each end and at further values."""
    near = [end * share for span in spans(found) for end in span if 0 < abs(end) < inf for share in (0.9999, 1.0001)]
    for value in (x for x in (*near, *values) if min(values) <= x <= max(values)):
        told, wound = verdict(found, value), count(value)
        assert told is None or wound is None or told == (wound == 0), (value, told, wound)


def stable(scene: hs.Scene, path: str, *span: Any, **keys: Any) -> Requirement:
    return hs.require(scene, path, *span, that="stable", **keys)


@pytest.mark.dear("19", "29")
@pytest.mark.few(3)
@pytest.mark.parametrize("seed", range(32))
def test_all_values_of_a_random_display_are_told_with_which_a_contour_winds_around_no_root(seed: int) -> None:
    draw = Random(seed)
    hand = hs.Hand("hand", number(draw, 0.5, 2), number(draw, 1, 25), number(draw, 1, 300))
    scene = drawn(draw, late=seed % 3 > 0).with_hands(hand)
    knob = draw.choice([x for x in scene.knobs if "jnd" not in x.path])
    own = float(knob.value)
    found = stable(scene, knob.path, (own / 20, own * 8))
    need_set(found, counted_at(scene, knob.path), [own * x for x in (0.051, 0.3, 0.9, 1.6, 4, 7.9)])


@pytest.mark.few("400")
@pytest.mark.parametrize("high", [400, 10**6, None])
def test_a_stiffness_that_is_critical_is_the_end_of_all_that_will_do_however_wide_the_range(high: int | None) -> None:
    found = stable(
        hs.load_scene("delayed-spring").with_hands(ARM), "environment.k", *([] if high is None else [(0, high)])
    )
    assert [x.high and x.high.digits(15) for x in found.feasible] == ["199.852102258710"]
    assert ([x.closed[1] for x in found.feasible], found.undecided) == ([False], ())


SHAKING: dict[
    str, tuple[float, float, float, str, float, tuple[float, float]]
] = {  # hand and shunt, what comes late, and by how much
    "stiffer": (0.5, 8, 50, "k", 1 / 40, (1, 4000)),
    "a spring 25 ms late": (0.5, -8, 50, "k", 1 / 40, (0.3, 300)),
    "a spring 5 ms late": (1, -2, 50, "k", 1 / 200, (0.3, 300)),
    "a damper 25 ms late": (1, -2, 50, "b", 1 / 40, (0.3, 300)),
    "one that never holds": (0.5, -20, 50, "b", 1 / 40, (0.3, 300)),
}


@pytest.mark.slow
@pytest.mark.few("stiffer", "a spring 5 ms late", "one that never holds")
@pytest.mark.parametrize("case", SHAKING)
def test_what_shakes_shakes_for_all_values_unless_some_are_told_that_hold_it(case: str) -> None:
    """m s^2 + b s + k + q exp(-s tau), or with q s; with b < 0 two roots are on the right at q = 0."""
    m, b, k, key, lag, (low, high) = SHAKING[case]
    felt = E.mass_spring_damper(**{key: 3})
    scene = hs.Scene(felt, (F.delay(Rational(lag)), F.shunt(b=b)), hands=(hs.Hand("hand", Rational(m), 0, k),))
    found = stable(scene, f"environment.{key}")

    def count(value: float) -> int | None:
        return winding(lambda z: m * z * z + b * z + k + value * (z if key == "b" else 1) * np.exp(-z * lag), 3000)

    assert found.undecided == ()
    need_set(found, count, np.geomspace(low, high, 7).tolist())


CUBIC = "s^3 + 5/2*s^2"  # beside a hand of 1/2 kg
DELAYS: dict[str, tuple[str, str, tuple[Any, Any, Any]]] = {  # A and B of A + B exp(-s tau), the first less the hand
    "a spring": ("0", "120", ("1/2", 6, 50)),
    "spring and damper": ("0", "3*s + 30", ("1/2", 2, 50)),
    "several frequencies": (CUBIC, "40*s + 20", ("1/2", 60, 90)),
    "a mass": (CUBIC, "4*s^2 + 150", ("1/2", 60, 90)),
    "one that is held again and again": ("0", "1/5", (1, "1/50", 4)),
    "frequencies far apart": ("s^3/400 + s^2*7/60", "3*s^2/40 + 4*s + 700", ("2/45", "290/9", 600)),
}


def delays_of(A: list[float], B: list[float], limit: float) -> list[float]:
    """All from 0 to a limit at which A + B exp(-s tau) has roots on the axis, by NumPy."""
    a, b = np.poly1d(A), np.poly1d(B)
    mirrored = [np.poly1d([c * (-1) ** (len(x) - n) for n, c in enumerate(x.coeffs)]) for x in (a, b)]
    found: list[float] = []
    for w in (x.imag for x in (a * mirrored[0] - b * mirrored[1]).roots if abs(x.real) < 1e-7 and x.imag > 1e-7):
        angle = np.angle(-b(1j * w) / a(1j * w))
        found += [(angle + 2 * np.pi * n) / w for n in range(int(limit * w) + 2)]
    return sorted(x for x in found if 0 <= x < limit)


@pytest.mark.few("a mass", "frequencies far apart")
@pytest.mark.parametrize("case", DELAYS)
def test_of_a_delay_all_values_are_told_and_their_ends_are_delays_at_which_roots_are_on_the_axis(case: str) -> None:
    more, late, hand = DELAYS[case]
    device = () if more == "0" else (F.shunt(Z=more, parameters={}),)
    scene = hs.Scene(
        E.mass_spring_damper(k=1), (F.series(late), F.delay("1 ms"), *device), hands=(hs.Hand("hand", *hand),)
    )
    found = stable(scene, "tau")
    m, b, k = map(Rational, map(str, hand))
    A, B = (
        Poly(sympify(x, {"s": s}, convert_xor=True, rational=True) + z, s)
        for x, z in ((more, m * s**2 + b * s + k), (late, 0 * s))
    )
    rows = [[float(c) for c in x.all_coeffs()] for x in (A, B)]

    def count(tau: float) -> int | None:
        return winding(lambda z: np.polyval(rows[0], z) + np.polyval(rows[1], z) * np.exp(-z * tau), reach)

    values, reach = (
        ([0.1, *range(1, 41, 3)], 10) if "again" in case else ([1e-3, 0.0131, 0.112, 0.373, 0.92, 1.7, 3.3], 300)
    )
    assert found.undecided == ()
    need_set(found, count, values)
    known = delays_of(*rows, 60)
    for end in (x for span in spans(found) for x in span if 0 < x < inf):
        assert min(abs(end - x) for x in known) < 1e-9


def test_without_a_frequency_at_which_both_are_of_one_size_no_delay_changes_anything() -> None:
    scene = hs.Scene(E.mass_spring_damper(k=3), (F.delay("1 ms"),), hands=(hs.Hand("hand", 1, 20, 50),))
    assert spans(stable(scene, "tau")) == [(0, inf)]
    assert ends_of(scene, "tau") == []


@pytest.mark.few(1)
@pytest.mark.parametrize("order", [1, 2])
def test_an_all_pass_in_place_of_a_delay_is_held_up_to_where_its_order_allows_it(order: int) -> None:
    """Of second order at 14.54 rad/s both tau, and another one, are roots of real and imaginary part."""
    scene = hs.Scene(E.kelvin_voigt(120, 3), (F.pade_delay("10 ms", order),), hands=(hs.Hand("hand", "0.6", 1),))
    found = stable(scene, "effects.pade-delay.tau", ("1 ms", "100 ms"))
    assert found.certified
    assert order == 1 or spans(found)[-1][1] == pytest.approx(0.03182965, abs=1e-8)
    need_set(found, counted_at(scene, "effects.pade-delay.tau", 3000), [0.0011, 0.01, 0.04, 0.09])


@pytest.mark.slow
def test_a_long_delay_of_a_soft_display_is_told_though_the_rest_of_it_is_stiff() -> None:
    """5000 (200 + 2 s) exp(-s tau) + (5200 + 2 s) (0.7 s^2 + 31 s + 110): far out the rest has a root at -2600."""
    late, felt = F.delay("12 ms"), F.shunt(m="0.2 kg", b=1, k=10)
    own = hs.Scene(
        E.kelvin_voigt(200, 2), (F.compliance(k="5 kN/m"), late, felt), hands=(hs.Hand("hand", "0.5", 30, 100),)
    )
    [(found, side)] = ends_of(own, "tau")
    exact = mpmath.mp.clone()
    exact.dps = 30

    def loop(w: Any, tau: Any) -> list[Any]:
        z = exact.mpc(0, w)
        value = 5000 * (200 + 2 * z) * exact.exp(-z * tau) + (5200 + 2 * z) * (0.7 * z * z + 31 * z + 110)
        return [value.real, value.imag]

    w, tau = exact.findroot(loop, (5.5, 0.38))
    assert abs(exact.mpf(found.value.digits(14)) - tau) < 1e-13
    assert abs(exact.mpf(found.bindings[0].omega.digits(14)) - w) < 1e-12
    assert side == "below"
    for span in ((), ((0, 1),)):
        asked = stable(own, "tau", *span)
        assert (asked.undecided, spans(asked)) == ((), [(0, pytest.approx(float(tau)))])


# --- roots that come from infinity, and chains of them --------------------------------------------------------------------


def satellite(b: float, k: float, m: float = 600) -> hs.Scene:
    return hs.load_scene("satellite-contact").with_hands(hs.Hand("hand", m=m, b=b, k=k))


def late_roots(numbers: Sequence[float], lag: float, most: float = 1e4) -> float | None:
    """Of a late mass in a hand, by its contour; infinite beside a chain; None where the delay turns further than ``most``."""
    loop = late_mass(tuple(numbers[:3]), tuple(numbers[3:]), lag)  # type: ignore[arg-type]
    if loop is None:
        return inf
    f, reach = loop
    return winding(f, reach) if reach * lag < most else None


SATELLITES = [  # damping, stiffness and mass of the hand, the ends that are told, and other masses with their counts
    ((5000, 0, 600), [(500, "above")], {501: 0, 505: 0, 600: 0, 5000: 0}),
    ((300, 5000, 505), [(500, "above"), (576.650343874, "below")], {500.5: 0, 540: 0, 576.6: 0, 576.7: 2}),
    ((100, 0, 600), [], {500.5: 2, 505: 2, 600: 2, 5000: 2}),
]


@pytest.mark.few("hand2-rows2-counts2")
@pytest.mark.parametrize(("hand", "rows", "counts"), SATELLITES)
def test_masses_at_which_a_chain_is_lost_or_roots_go_over_are_told_with_the_counts_beside_them(
    hand: tuple[float, float, float], rows: list[Any], counts: dict[float, int]
) -> None:
    """Far out on the axis |m s^2 + b s + k| > |500 s^2 + 131.4 s + 11691| if b^2 - 2 m k + 2 500 11691 - 131.4^2 > 0."""
    found = ends_of(satellite(*hand), "hand.m")
    assert [(float(x.value), side) for x, side in found] == [(pytest.approx(x, rel=1e-11), side) for x, side in rows]
    for mass, expected in counts.items():
        assert late_roots([500, 131.4, 11691, mass, *hand[:2]], 0.108) == expected


def test_a_neutral_display_is_stable_up_to_where_a_chain_comes() -> None:
    """m s^2 exp(-s tau) (1 + s Td)/(1 + s Tf) beside a hand's mass: the chain comes at Td = m_h Tf/m."""
    lead = F.series("(1 + s*Td)/(1 + s*Tf)", parameters={"Td": "0.0176", "Tf": "0.00158"})
    felt, hand = E.mass_spring_damper("0.137", "6.02", 591), hs.Hand("hand", "0.606", "0.845", 299)
    own = hs.Scene(felt, (lead, F.delay("0.00854")), hands=(hand,))
    last = 0.606 * 0.00158 / 0.137
    found = stable(own, "effects.series.Td", ("0.00587", "0.0528"))
    assert (spans(found), found.undecided) == ([(0.00587, pytest.approx(last, rel=1e-14))], ())
    near = nearest(own, "effects.series.Td")
    assert [said(near, x) for x in (0.00587, 0.99999 * last, 1.00001 * last, 0.0176)] == [True, True, False, False]


def test_of_a_mass_that_comes_late_all_springs_are_told() -> None:
    """2 s^2 + s^2 exp(-s/100) + k is 0 at j omega, omega = 100 pi, for k = omega^2; nothing drifts but at k = 0."""
    own = hs.Scene(E.mass_spring_damper(m=1), (F.delay("10 ms"),), hands=(hs.Hand("hand", m=2),))
    found = hs.require(own, "hand.k", that="steady")
    assert (spans(found), found.undecided) == ([(0, pytest.approx((100 * np.pi) ** 2, rel=1e-14))], ())
    assert found.feasible[0].closed[0]


@pytest.mark.slow
def test_a_heavy_hand_is_held_between_two_masses() -> None:
    """Between them a part may stay undecided: a chain comes close there."""
    found = spans(stable(satellite(100, 20000), "hand.m", (501, 2000)))
    assert (found[0][0], found[-1][1]) == pytest.approx((509.842, 1151.41), rel=1e-5)
    for mass, expected in ((509.84, 2), (509.85, 0), (1151.4, 0), (1151.5, 2)):
        assert late_roots([500, 131.4, 11691, mass, 100, 20000], 0.108) == expected


@pytest.mark.slow
def test_where_more_and_more_roots_stay_behind_a_chain_no_value_beside_it_will_do() -> None:
    """A hand of 20 kN/m: m k outweighs 500 11691, and so roots lie on the axis at ever higher frequencies as m falls to 500."""
    found = stable(satellite(100, 20000, 400), "hand.m")
    assert all(509.842 * (1 - 1e-5) < low <= high < 1151.41 * (1 + 1e-5) for low, high in spans(found))
    for mass, expected in ((500.5, 4), (502, 2), (509.8, 2), (509.9, 0), (1151, 0), (1152, 2)):
        assert late_roots([500, 131.4, 11691, mass, 100, 20000], 0.108) == expected
        own = satellite(100, 20000, mass)
        assert held(own, own.hands[0]).unstable == expected


@pytest.mark.slow
def test_beside_a_chain_that_is_lost_no_side_is_called_stable() -> None:
    """-0.002 s^2 that comes 4 ms late: in a hand of 2 kg no root lies on the right, in one of 2.1 g there are four."""
    wheel, column = (
        E.mass_spring_damper("0.04 kg*m^2", "0.3 N*m*s/rad", "4 N*m/rad"),
        F.compliance("600 N*m/rad", "0.2 N*m*s/rad"),
    )
    scene = hs.Scene(wheel, (column, F.shunt(m="-0.002 kg*m^2", b="-0.01 N*m*s/rad"), F.delay("4 ms")))
    firm = hs.Hand("firm", b="1 N*m*s/rad")
    found = nearest(scene.with_hands(firm), "hand.m")
    assert said(found, 0.0019) is False
    assert said(found, 0.0021) in (None, False)
    heavier = [hs.Hand(m, m=f"{m} kg*m^2", b="1 N*m*s/rad") for m in ("0.0021", "2")]
    assert [held(scene, x).unstable for x in heavier] == [4, 0]


def test_a_chain_is_there_as_long_as_there_is_a_delay() -> None:
    light = satellite(100, 0, 400)
    [(delay, side)] = ends_of(light, "tau")
    assert (float(delay.value), side) == (0, None)
    found = stable(light, "tau")
    assert (spans(found), found.undecided) == ([(0, 0)], ())


@pytest.mark.dear("1/2")
@pytest.mark.few(3)
@pytest.mark.parametrize("mass", ["1/2", "99/100", "1", "101/100", "2"])
def test_the_delays_that_will_do_do_not_hang_on_the_one_that_a_scene_has_not_even_if_it_is_0(mass: str) -> None:
    """m s^2 + M s^2 exp(-s tau) + b s + k: with M >= m no delay but 0 will do, as a chain of roots comes."""
    felt, hand = E.mass_spring_damper(m=mass), hs.Hand("mine", m=1, b=1, k=1)
    found = [stable(hs.Scene(felt, (F.delay(x),), hands=(hand,)), "tau").to_dict() for x in ("0 ms", "1 ms", "3 s")]
    ranges = [x.pop("searched") for x in found]
    assert [high for _, high in ranges] == pytest.approx([1, 1, 3000])
    assert found[0] == found[1] == found[2]
    assert found[0]["certified"]
    assert (found[0]["feasible"] == [[0.0, 0.0]]) is bool(Rational(mass) >= 1)


@pytest.mark.dear("masses1-10 ms", "masses1-20 ms")
@pytest.mark.few("masses1-10 ms", "masses1-20 ms", "masses1-other2")
@pytest.mark.parametrize("other", ["10 ms", "20 ms", pi / 300])
@pytest.mark.parametrize("masses", [("1", "1/2"), ("1/3", "2"), ("2", "-1/2")])
def test_where_delayed_masses_meet_a_chain_is_lost_when_no_zero_is_left_inside_of_the_unit_circle(
    masses: tuple[str, str], other: Any
) -> None:
    """m + m2 z^a + m1 z^b: of multiples of one delay by their zeros, else at m = |m1| + |m2|."""
    m1, m2 = map(float, map(Rational, masses))
    own = hs.Scene(E.mass_spring_damper(masses[0], 1, 10), (F.delay("10 ms"), F.shunt(m=masses[1]), F.delay(other)))
    least = abs(m1) + abs(m2)
    if isinstance(other, str):
        a, b = {"10 ms": (1, 2), "20 ms": (2, 3)}[other]
        z = np.exp(1j * np.linspace(0, 2 * np.pi, 400_001))
        on_circle = -(m2 * z**a + m1 * z**b)
        i = np.flatnonzero(on_circle.imag[:-1] * on_circle.imag[1:] <= 0)
        least = float(on_circle.real[i].max())
    light = [(0.9 * abs(abs(m1) - abs(m2)), RootChain.RIGHT)] if isinstance(other, str) else []  # else that stays open
    for mass, chain in (*light, (1.2 * least, None)):
        assert (roots := held(own, hs.Hand("hand", f"{mass:.9g}", 8)).roots) is not None
        assert roots.chain is chain


def test_delays_that_are_multiples_of_one_for_few_values_alone_are_not_said_to_be_alike_for_all() -> None:
    """1 + 0.6 exp(-s/100) + 0.6 exp(-s/100 - s tau): no chain at tau = 10 ms, where zeros multiply to 1/0.6, one at 12 ms."""
    behind = F.delay("12 ms"), F.shunt(m="0.6 kg"), F.delay("10 ms")
    own = hs.Scene(E.mass_spring_damper("0.6 kg", 1, 10), behind, hands=(hs.Hand("hand", m=1, b=8, k=3),))
    found = nearest(own, "effects.delay.tau")
    assert (found.ends, bool(found.reason)) == ((), True)
    alike = own.with_values({"effects.delay.tau": "10 ms"})
    assert (held(own, own.hands[0]).stable, held(alike, own.hands[0]).stable) == (False, True)


@pytest.mark.slow
def test_a_chain_that_no_mass_of_a_hand_moves_is_there_for_all_of_them() -> None:
    """m s^2 D(exp(-s ms)), D of the display alone: its zeros inside the circle stay where they are."""
    late, link = F.delay("10 ms"), F.wave_variables("5 N*s/m", "7 ms")
    own = hs.Scene(E.kelvin_voigt("200 N/m", "2 N*s/m"), (late, link), hands=(hs.Hand("hand", "0.5", 30, 100),))
    assert ends_of(own, "hand.m") == []
    for mass in ("1 g", "100 t"):
        assert held(own, hs.Hand("hand", m=mass, b=30, k=100)).unstable is None


@pytest.mark.slow
def test_four_channels_are_held_again_by_a_stiffer_environment() -> None:
    own = hs.load_scene("four-channel-teleoperation").with_hands(hs.Hand("hand", m=1, b=1, k=10))
    assert [x for span in spans(stable(own, "environment.k")) for x in span] == pytest.approx(
        [0, 5972.49797743441, 775971, 1120950], rel=1e-5
    )


sizes = (
    [1, 2, 5],
    [1, 3, 10, 30],
    [3, 40, 700],
    ["0.5", 4, 12],
    [0, "0.7", 9, 80],
    [0, 6, 300, 2000],
    ["0.01", "0.06", "0.3"],
)
PATHS = ["environment.m", "environment.b", "environment.k", "hand.m", "hand.b", "hand.k"]


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(16))
def test_random_late_masses_are_held_where_their_contours_wind_around_no_root(seed: int) -> None:
    draw = Random(seed)
    *numbers, lag = (draw.choice(x) for x in sizes)
    i = draw.randrange(6)
    hand = hs.Hand("hand", *numbers[3:])
    scene = hs.Scene(E.mass_spring_damper(*numbers[:3]), (F.delay(lag),), hands=(hand,))
    row = [float(Rational(str(x))) for x in numbers]
    base = row[i] or 1.0

    def count(value: float) -> Any:
        return late_roots([*row[:i], value, *row[i + 1 :]], float(lag), 2e3)

    need_set(stable(scene, PATHS[i], (base / 20, base * 20)), count, [base * x for x in (0.051, 0.2, 0.9, 1.6, 7, 19)])


# --- values without end -----------------------------------------------------------------------------------------------------


def counts_as_told(
    scene: hs.Scene, path: str, values: Sequence[Any], found: Requirement | None = None
) -> list[bool | None]:
    """What is said of values, each of which is counted by itself as well: on a contour, without what is known of parts."""
    found = found or stable(scene, path)
    told = [verdict(found, float(Rational(x))) for x in values]
    for value, said in zip(values, told, strict=True):
        moved = scene.with_values({path: value})
        assert said is None or said is (roots_in_hand(moved.distortion().perc, moved.hands[0]).number == 0), value
    return told


def in_hand(felt: hs.Environment, *effects: hs.Effect, m: Any, b: Any, k: Any) -> hs.Scene:
    return hs.Scene(felt, effects, hands=(hs.Hand("hand", m, b, k),))


@pytest.mark.dear("1/2")
@pytest.mark.parametrize("alpha", ["1/10", "1/2"])
def test_fractional_tissue_behind_a_cable_is_stable_for_every_order(alpha: str) -> None:
    own = in_hand(E.spring_pot(30, alpha), F.compliance(k=5809), F.shunt(m="0.3 kg"), m="0.4 kg", b=3, k=391)
    for path, high in (("environment.alpha", 1), ("environment.k_alpha", inf)):
        found = stable(own, path)
        assert (found.undecided, spans(found)) == ((), [(0, high)])
    assert counts_as_told(own, "environment.alpha", ["1/50", "0.3", "0.97"]) == [True] * 3


@pytest.mark.slow
@pytest.mark.few(1)
@pytest.mark.parametrize("mass", ["0 kg", "0.4 kg"])
def test_an_order_behind_a_delay_is_answered_though_it_is_a_power_that_changes(mass: str) -> None:
    """The highest power of s is 2, whatever the order is; with a mass that comes late it is so twice."""
    own = in_hand(E.spring_pot(300, "1/2"), F.shunt(m=mass, b=1), F.delay("13 ms"), m="1.8 kg", b=14, k=196)
    told = counts_as_told(own, "environment.alpha", ["0.02", "0.35", "0.5", "0.65", "0.8", "0.98"])
    assert None not in told


@pytest.mark.slow
def test_a_chain_that_reflects_all_is_at_the_axis_for_every_order_and_delay() -> None:
    tissue, hand = E.spring_pot(30, "1/2"), {"m": "1.8 kg", "b": 14, "k": 196}
    link, other = F.wave_variables(13, "19 ms"), F.wave_variables(4, "15 ms")
    one, two = in_hand(tissue, link, **hand), in_hand(E.mass_spring_damper("0.2 kg", 2, 30), link, other, **hand)
    for own, path in (
        (one, "environment.alpha"),
        (two, "effects.wave-variables.tau"),
        (two, "effects.wave-variables-2.tau"),
    ):
        found = stable(own, path)
        assert found.feasible == (), path
        roots = roots_in_hand(own.distortion().perc, own.hands[0])
        assert roots.chain is RootChain.NEAR
        assert roots == held(own, own.hands[0]).roots
    far_apart = two.with_values({"effects.wave-variables.tau": "0.0193711"})
    assert (roots := held(far_apart, two.hands[0]).roots) is not None
    assert roots.chain is RootChain.NEAR


def test_a_link_with_nothing_that_damps_its_waves_is_stable_for_no_impedance() -> None:
    """A spring-pot reflects ever more, the higher the frequency: a chain comes to the axis, whatever the link's impedance is."""
    own = in_hand(E.spring_pot(30, "1/2"), F.wave_variables(21, "2 ms"), F.compliance(k=5809), m="0.4 kg", b=3, k=391)
    found = stable(own, "effects.wave-variables.b")
    assert (found.feasible, found.undecided) == ((), ())


@pytest.mark.slow
@pytest.mark.few(1)
@pytest.mark.parametrize(("free", "low"), [("hand.b", 8.819064481568287), ("effects.shunt.b", 5.0)])
def test_damping_without_end_is_told_though_two_delays_have_a_fine_common_unit(free: str, low: float) -> None:
    """14 ms and 24 ms are multiples of 1 ms: powers of a tangent of 0.5 ms that nearly cancel."""
    parts = F.delay("14 ms"), F.first_order_lag(543), F.delay("24 ms")
    device = (F.shunt(b=5),) if "shunt" in free else ()
    own = in_hand(E.kelvin_voigt(300, 3), *parts, *device, m="1.75 kg", b=39, k=9)
    found = stable(own, free)
    assert found.undecided == ()
    assert free != "hand.b" or spans(found)[-1] == (pytest.approx(low, rel=1e-12), inf)
    assert None not in counts_as_told(own, free, [1, 7, 30, 1000, 10**6, 10**9], found)


@pytest.mark.slow
def test_a_delay_behind_tissue_of_a_broken_order_is_told_without_end() -> None:
    """At rest tissue of order 1/2 does not pull, so that |A| > |B| there, and one frequency alone brings roots over."""
    own = in_hand(E.spring_pot(100, "1/2"), F.first_order_lag(352), F.delay("40 ms"), m="0.8 kg", b=4, k=109)
    found = stable(own, "effects.delay.tau")
    [(_, last)] = spans(found)
    assert found.undecided == ()
    values = [f"{x:.12g}" for x in (last * 0.9999, last * 1.0001, 3 * last, 0.9)]
    assert counts_as_told(own, "effects.delay.tau", values, found) == [True, False, False, False]


@pytest.mark.slow
def test_a_delay_is_free_beside_others_of_which_products_are_made() -> None:
    """The shunt makes the display neutral whatever the delay is: nowhere does it become stable, as each one asked alone says."""
    late, device = F.delay("20 ms", name="late"), F.shunt(m="0.1 kg", b="1 N*s/m")
    own = in_hand(E.kelvin_voigt(300, 2), late, device, F.wave_variables("8 N*s/m", "7 ms"), m="0.5 kg", b=5, k=200)
    assert nearest(own, "late.tau").feasible == ()
    for tau in ("1 ms", "20 ms", "507 ms", "2 s"):
        moved = own.with_values({"late.tau": tau})
        assert held(moved, moved.hands[0]).stable is False


def test_where_all_vanishes_at_rest_whatever_the_number_is_no_value_is_left_out() -> None:
    """Line and shunt share a zero at s = 0 that is no root: no value of the shunt has one there; nor does it take energy for all."""
    shunt = F.shunt(Z="(10-a)*s", parameters={"a": 5})
    own = in_hand(E.kelvin_voigt(100, 1), F.wave_variables(10, "5 ms"), shunt, m=1, b=5, k=20)
    found = stable(own, "effects.shunt.a", (0, 100))
    assert spans(found) == [(0, pytest.approx(15.909426991833095, rel=1e-14))]
    assert counts_as_told(own, "effects.shunt.a", [12, 20, 50], found) == [True, False, False]


@pytest.mark.slow
def test_a_highest_power_that_comes_late_in_all_its_terms_is_unstable_for_every_delay() -> None:
    """A late mass behind a line without losses: s^4 comes with exp(-s tau) alone."""
    block = E.mass_spring_damper("0.3 kg", 2, 100)
    own = in_hand(block, F.delay("29 ms"), F.wave_variables(21, "5 ms"), m="1.55 kg", b=19, k=56)
    for free in ("effects.delay.tau", "effects.wave-variables.tau"):
        assert stable(own, free).feasible == ()
    assert (roots := held(own, own.hands[0]).roots) is not None
    assert roots.chain is RootChain.RIGHT


@pytest.mark.parametrize(
    ("felt", "device", "path", "span"),
    [
        (E.kelvin_voigt(100, 1), F.shunt(b=1), "effects.shunt.b", (-6, inf)),
        (E.kelvin_voigt(100, 1), F.shunt(m=1), "effects.shunt.m", (-1, inf)),
        (E.expression("k+b*s", parameters={"k": 100, "b": 3}), F.compliance(k=5000), "environment.b", (0, inf)),
    ],
)
def test_a_number_that_may_be_negative_is_not_told_by_what_positive_ones_do(
    felt: hs.Environment, device: hs.Effect, path: str, span: tuple[float, float]
) -> None:
    """(m + m_h) s^2 + (b + 6) s + 120 of a shunt, and of a formula b s (s^2 + 5 s + 20)/5000 to the third power."""
    assert spans(stable(in_hand(felt, device, m=1, b=5, k=20), path)) == [span]


def test_in_a_hand_that_does_not_damp_passive_parts_are_stable_for_no_value() -> None:
    own = in_hand(E.mass_spring_damper(k=100), m=1, b=0, k=0)
    found = stable(own, "environment.k")
    assert (found.feasible, found.undecided) == ((), ())


def test_a_value_with_which_there_is_no_display_will_not_do() -> None:
    """3 + 1/(q - 3) > 0 for q < 8/3 and for q > 3."""
    found = stable(display("1/(q - 3)", q=1).with_hands(hs.Hand("hand", 1, 2, 3)), "q", (0, 10))
    assert (spans(found), found.undecided) == ([(0, pytest.approx(8 / 3)), (3, 10)], ())
    assert not found.feasible[1].closed[0]


def test_a_wave_variable_link_holds_whatever_the_damping_of_a_hand_without_mass() -> None:
    own = hs.load_scene("wave-variable-link").with_hands(hs.hands["firm-grip"])
    found = stable(own, "hand.b")
    assert (spans(found), found.feasible[0].closed[0], found.undecided) == ([(0, inf)], False, ())
    [(damping, side)] = ends_of(own, "hand.b")
    assert (float(damping.value), side) == (0, "above")


@pytest.mark.slow
def test_two_wave_variable_links_are_passive_and_stable_for_every_delay_and_impedance() -> None:
    links = F.wave_variables(13, "19 ms"), F.wave_variables(4, "15 ms")
    own = in_hand(E.kelvin_voigt(400, 3), *links, m="1.8 kg", b=14, k=196)
    for path in ("effects.wave-variables.tau", "effects.wave-variables-2.b", "environment.b", "hand.b"):
        found = hs.require(own, path, that="passive")
        assert (found.undecided, [high for _, high in spans(found)]) == ((), [inf]), path
    assert [high for _, high in spans(hs.require(own, "hand.b", that="stable"))] == [inf]


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(6))
def test_in_a_hand_that_damps_passive_parts_are_stable_for_all_values_or_where_a_chain_allows_it(seed: int) -> None:
    pick = Random(seed)
    tissue = pick.choice([E.kelvin_voigt(pick.randint(0, 900), pick.randint(1, 9)), E.maxwell(pick.randint(10, 500), pick.randint(1, 9)),
                          E.zener(pick.randint(10, 500), pick.randint(10, 500), pick.randint(1, 9))])  # fmt: skip
    parts = [pick.choice([F.wave_variables(pick.randint(2, 40), Rational(pick.randint(1, 30), 1000)),
                          F.compliance(k=pick.randint(100, 9000), b=pick.randint(1, 9)),
                          F.shunt(m=Rational(pick.randint(0, 20), 10), b=pick.randint(0, 4))]) for _ in range(pick.randint(1, 3))]  # fmt: skip
    own = in_hand(tissue, *parts, m=Rational(pick.randint(1, 30), 10), b=pick.randint(1, 40), k=pick.randint(0, 500))
    checked = 0
    for knob in (x for x in own.knobs if "jnd" not in x.path and "shunt" not in x.path and "hand.b" not in x.path):
        found = stable(own, knob.path, limit=10)
        for value in (knob.value * x for x in (Rational(1, 300), Rational(1, 7), 1, Rational(9, 2), 130)):
            moved = own.with_values({knob.path: value})
            try:
                with limited(1):
                    told = roots_in_hand(moved.distortion().perc, moved.hands[0]).number == 0
            except hs.HaptisymError:
                continue
            assert verdict(found, float(value)) in (told, None), (knob.path, value)
            checked += verdict(found, float(value)) is not None
    assert checked


x, y = Symbol("x", positive=True), Symbol("y", positive=True)
H = [x + q * s, x * s**2 + y * s + q, q * s**2 + y * s + x, x + q * s**y, x + y * s**q, q + x * y * s / (x + y * s), x * q * s / (x + q * s),
     x - q * s, q / (s + x), (s + q) / (s + x), (s**2 + q) / (s**2 + x), q * s / (s**2 + y * s + 1), s**4 + y * s + q, q * s**4 + s + x,
     (s**4 + q * s + 1) / (s**2 + 3 * s + 1), s ** Rational(9, 2) + q * s]  # fmt: skip


@pytest.mark.parametrize("form", range(len(H)))
def test_an_environment_that_is_said_to_take_energy_does_for_all_values_that_are_open(form: int) -> None:
    pick = Random(form)
    for _ in range(3):
        own = H[form].subs({x: Rational(pick.randint(1, 900), pick.randint(1, 9)), y: Rational(pick.randint(1, 9), 10)})
        if not is_positive_real_by_signs(own):
            continue
        value = lambdify((s, q), own, "numpy")
        values = np.array([pick.uniform(1e-3, 1) for _ in range(200)]) * (1 if own.has(s**q) else 1000)
        w, right = np.array([[10.0 ** pick.uniform(-3, n) for _ in range(200)] for n in (4, 3)])
        parts = np.imag(value(1j * w, values))
        assert parts.min() >= -1e-12 * abs(parts).max()
        inside = right + 1j * w
        ratio = value(inside, values[0]) / inside
        assert (ratio.real >= -1e-12 * abs(ratio)).all()


@pytest.mark.parametrize("behind", [F.shunt(m=1, b=2), F.compliance(k=500, b=1)])
def test_a_power_of_s_that_a_users_own_model_lets_grow_beyond_1_is_not_passive_for_all_its_values(
    behind: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """k s^p pushes for 2 < p < 4, and k s^(3 q) for 2/3 < q < 1: counted with numbers in place of them."""
    for name in ("own-power", "own-triple"):
        monkeypatch.setitem(ENVIRONMENTS, name, None)
        monkeypatch.delitem(ENVIRONMENTS, name)

    @E.environment("own-power")
    def own_power(k: FractionalStiffness, p: PositiveStiffness) -> Any:
        return k * s**p

    @E.environment("own-triple")
    def own_triple(k: FractionalStiffness, q: FractionalOrder) -> Any:
        return k * s ** (3 * q)

    for tissue, name, within, value in ((own_power, "p", (0.2, 3.5), "2.5"), (own_triple, "q", (0.1, 0.95), "0.9")):
        own = hs.Scene(tissue(3, "0.3"), (behind,), hands=(ARM,))
        assert held(own.with_values({f"environment.{name}": Rational(value)}), ARM).unstable == 2
        found = hs.require(own, f"environment.{name}", within, that="stable", hand=ARM)
        assert verdict(found, float(value)) is not True


# --- what stays open ----------------------------------------------------------------------------------------------------------


def late_link() -> hs.Scene:
    """Position-force teleoperation behind 13 ms: three products of delays."""
    link = F.position_force_teleoperator(Mm="0.5 kg", Ms="2 kg", Bs="64 N*s/m", Ks="40 N/m", tau="10 ms")
    return in_hand(E.kelvin_voigt("120 N/m", "3 N*s/m"), F.delay("13 ms"), link, m="0.6 kg", b=9, k=200)


@pytest.mark.slow
def test_a_stiffness_behind_three_late_products_is_required_up_to_its_critical_value() -> None:
    found = stable(late_link(), "environment.k", (50, 1000))
    assert (spans(found), found.undecided) == ([(50, pytest.approx(251.1710946, rel=1e-8))], ())
    counts_as_told(late_link(), "environment.k", ["251.17", "251.18", 600], found)


@pytest.mark.slow
def test_mass_in_the_hand_that_holds_three_late_products_is_told_without_end() -> None:
    found = stable(late_link(), "hand.m")
    assert found.certified
    counts_as_told(late_link(), "hand.m", ["0.003", "0.6", 40, 3000, 10**6, 10**9], found)


BOTH_WAYS = in_hand(
    E.mass_spring_damper("250 g", 0, 282), F.first_order_lag(348), F.delay("4 ms"), m="1.8 kg", b=14, k=196
)
OPEN: dict[str, tuple[Callable[[], hs.Scene], str, int, float, float]] = {  # ..., spans that are told, open from beyond, up to
    "a mass behind a lag and a delay holds again and again": (lambda: BOTH_WAYS, "hand.k", 1, 3000, inf),
    "chains": (lambda: in_hand(E.mass_spring_damper("0.15 kg", 0, 23), F.delay("20 ms"), m="1.8 kg", b=14, k=196), "hand.k", 1, 5e6, inf),
    "friction": (lambda: hs.Scene(late_link().environment, (*late_link().effects, F.coulomb_friction("0.2 N", "5 mm")), hands=late_link().hands), "hand.m", 0, 0, inf),
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.few("a mass behind a lag and a delay holds again and again")
@pytest.mark.parametrize("case", OPEN)
def test_values_of_which_nothing_is_known_are_told_as_open_for_a_reason(case: str) -> None:
    scene, path, least, beyond, high = OPEN[case]
    found = stable(scene(), path)
    assert not found.certified
    assert found.reason
    assert len(found.feasible) >= least
    last = found.undecided[-1]
    assert float(last.low or 0) >= beyond
    assert (inf if last.high is None else float(last.high)) == high


def test_a_question_is_cut_short_when_its_time_is_over() -> None:
    clock = iter(range(10**6))
    with timed_by(lambda: float(next(clock))), limited(3):
        found = nearest(late_link(), "environment.k")
    assert (found.ends, found.reason) == ((), STOPPED)
