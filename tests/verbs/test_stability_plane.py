"""Planes of two numbers in which a display is held or shakes: by Hurwitz, by counts at single values, by roots on the boundary; margins."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from itertools import count
from math import log10
from random import Random
from typing import Any

import mpmath
import numpy as np
import pytest
from lagged import lagged, room, text
from sampledloops import Wall
from scipy.linalg import expm
from scipy.optimize import brentq
from strategies import Seeded, case, scene
from sympy import Expr, Integer, Rational, Symbol

import haptisym as hs
from haptisym.judge.bindings import stable_in
from haptisym.kernel.budget import limited, timed_by
from haptisym.kernel.dynamics import RealFunction, Ring
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import ExactNumber
from haptisym.model.valueranges import ALLOWED
from haptisym.programs.taylormodels import Array
from haptisym.verbs.require.designmap import held_rectangles
from haptisym.verbs.stability.held import held, unstable_roots
from haptisym.verbs.stability.limits import stable_values
from haptisym.verbs.stability.margins import Turned, margins
from haptisym.verbs.stability.plane import boundary, plane, wall_plane
from haptisym.verbs.stability.ranges import HeldPlane, held_plane

ZERO = ExactNumber(Integer(0))

E, F = hs.environments, hs.effects
SPRING, ARM = hs.load_scene("delayed-spring"), hs.hands["postural-arm"]
Spans = Mapping[str, tuple[Any, Any]]

# --- the plane of a hand of one mass, as it is drawn ---------------------------------------------------------------------


@pytest.mark.dear("position-force-teleoperation-postural-arm-counts3")
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
    scene, own = hs.load_scene(name), hs.hands[hand]
    low, high, least, most = window = (-130.0 if name in ("fu2019", "delayed-spring") else -25.0, 1800.0, -0.6, 12.5)
    found = plane(scene, own, window)
    assert {x.roots.number for x in found.cells if x.roots} == counts
    for x in found.cells:
        rows, columns = (i + 0.5 for i in np.nonzero(x.pixels))
        k, b = low + rows * (high - low) / len(x.pixels), least + columns * (most - least) / len(x.pixels)
        for i in (i for i in range(0, len(k), len(k) // 5 + 1) if k[i] >= 0 and b[i] >= 0):
            inside = hs.Hand("inside", own.m.value, Rational(float(b[i])), Rational(float(k[i])))
            assert x.roots is not None
            assert held(scene, inside).unstable == x.roots.number


@pytest.mark.parametrize(("name", "hand"), [("virtual-wall", "light-touch"), ("sampled-wall", "none")])
def test_the_cells_of_a_walls_plane_bear_the_number_of_roots_that_every_wall_in_them_has(name: str, hand: str) -> None:
    scene, own = hs.load_scene(name), hs.Hand("none") if hand == "none" else hs.hands[hand]
    found = wall_plane(scene, own, (0.0, 1500.0, 0.0, 8.0))
    assert {x.roots.number for x in found.cells if x.roots} == {0, 2}
    for x in found.cells:
        rows, columns = (i + 0.5 for i in np.nonzero(x.pixels))
        for i in range(0, len(rows), len(rows) // 5 + 1):
            k, b = (Rational(float(share * most / len(x.pixels))) for share, most in ((rows[i], 1500), (columns[i], 8)))
            assert x.roots is not None
            assert held(scene.with_values({"environment.k": k, "environment.b": b}), own).unstable == x.roots.number


def test_a_wall_that_is_not_rendered_has_no_plane() -> None:
    clock = F.zero_order_hold("1 ms"), F.shunt(m="0.1 kg", b=1)
    spring = E.expression("k", parameters={"k": 300})
    other = hs.Scene(E.kelvin_voigt(300, 2), clock, rendered=spring)
    with pytest.raises(UndecidedError, match="not what is rendered"):
        wall_plane(other, hs.Hand("none"), (0.0, 900.0, 0.0, 8.0))


def test_the_boundary_is_where_roots_lie_on_the_axis() -> None:
    """K exp(-j w tau) - m w^2 + j w b + k = 0 at every point of it."""
    found = boundary(SPRING, hs.Hand("hand", "0.5 kg"), (-130.0, 500.0, 0.0, 10.0))
    for x in np.linspace(1, 34, 300):
        at = (0.5 * x**2 - 100 * np.cos(0.036 * x), 100 * np.sin(0.036 * x) / x)
        assert np.hypot((found.k - at[0]) / 100, found.b - at[1]).min() < 0.02
    assert found.at_0 == -100


# --- rectangles of any two numbers -----------------------------------------------------------------------------------------


def told_of(found: hs.Scene, spans: Spans, others: tuple[str, ...] = (), **how: Any) -> HeldPlane:
    """The plane of two numbers by their paths; ``others`` vary as the scene says."""
    knobs = [found.knobs[x] for x in spans]
    ends: dict[Symbol, tuple[Expr, Expr]] = {
        x.symbol: (x.number(a), x.number(b)) for x, (a, b) in zip(knobs, spans.values(), strict=True)
    }
    more: Any = {found.knobs[x].symbol: found.knobs[x].interval for x in others}
    return held_plane(found, found.hands, ends, more, **how)


def area(cells: Array) -> float:
    return float((cells[..., 1] - cells[..., 0]).prod(-1).sum())


def need_filled(told: HeldPlane, pixels: int) -> None:
    """Rectangles fill the plane once."""
    filled = np.zeros((pixels, pixels), int)
    for x in np.concatenate([told.stable, told.unstable, told.left]):
        (a, b), (c, d) = (x * pixels).astype(int).tolist()
        filled[a:b, c:d] += 1
    assert (filled == 1).all()


def need_counted(found: hs.Scene, told: HeldPlane, spans: Spans, others: tuple[str, ...] = (), times: int = 6) -> None:
    """Sets of values, within rectangles and at their ends, count as is told of them."""
    rng = np.random.default_rng(7)
    for cells, is_stable in ((told.stable, True), (told.unstable, False)):
        for cell in cells[rng.integers(0, len(cells), times)] if len(cells) else ():
            values: dict[str, Expr] = {}
            for (path, (a, b)), (low, high) in zip(spans.items(), cell.tolist(), strict=True):
                share = Rational(low) + Rational(int(rng.integers(0, 5)), 4) * (Rational(high) - Rational(low))
                start, end = found.knobs[path].number(a), found.knobs[path].number(b)
                values[path] = start + share * (end - start)
            for path in others:
                low, high = found.knobs[path].interval or (0, 0)
                values[path] = low + Rational(int(rng.integers(0, 5)), 4) * (high - low)
            now = found.with_values(values)
            assert all(unstable_roots(now, x).number == 0 for x in now.hands) is is_stable, values


@pytest.mark.few("False-1")
@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("varies", [False, True])
def test_a_plane_of_stiffness_and_damping_is_told_as_the_condition_says(seed: int, *, varies: bool) -> None:
    """The room falls with k and grows with b: of a rectangle one corner decides that all are stable, the other that none is."""
    pick = Random(seed)
    m, omega_c = Fraction(pick.randint(5, 20), 10), Fraction(pick.randint(5, 12))
    heavy = [m, m * Fraction(11, 10)] if varies else [m, m]
    spans: Spans = {"environment.k": (1, pick.randint(40, 80)), "hand.b": (Rational(1, 2), pick.randint(3, 5))}
    told = told_of(lagged(20, text(heavy), 2, omega_c), spans, ("hand.m",) if varies else (), finest=2.0**-5)
    need_filled(told, 32)
    assert area(told.left) < 0.25

    def worst(cell: Any, way: int) -> Any:
        ends = [(Fraction(int(a)) if a == int(a) else Fraction(1, 2), Fraction(b)) for a, b in spans.values()]
        (k0, k1), (b0, b1) = (
            tuple(low + Fraction(x) * (high - low) for x in side) for side, (low, high) in zip(cell, ends, strict=True)
        )
        k, b = (k1, b0) if way < 0 else (k0, b1)
        return (min if way < 0 else max)(room(k, y, b, omega_c) for y in heavy)

    assert all(worst(x, -1) > 0 for x in told.stable.tolist())
    assert all(worst(x, 1) < 0 for x in told.unstable.tolist())
    near = [x for x in told.left.tolist() if worst(x, -1) <= 0 <= worst(x, 1)]
    assert len(near) > 0.3 * len(told.left)
    assert (told.left[..., 1] - told.left[..., 0] == 2.0**-5).all()


@pytest.mark.slow
def test_the_boundary_of_a_late_spring_in_an_arm_lies_in_what_is_left() -> None:
    """36 ms: up to K = 199.8521; in between less than a hundredth of the area."""
    own, spans = SPRING.with_hands(ARM), {"tau": ("1 ms", "60 ms"), "environment.k": (10, 1000)}
    told = told_of(own, spans)
    need_filled(told, 256)
    assert area(told.left) < 0.01
    at = 35 / 59, (199.8521022587101 - 10) / 990
    assert any((x[:, 0] <= at).all() and (x[:, 1] >= at).all() for x in told.left)
    need_counted(own, told, spans)


@pytest.mark.few("how2-5")
@pytest.mark.parametrize(("how", "seconds"), [({"most": 20}, None), ({"most": 400}, None), ({}, 5)])
def test_whatever_ends_the_search_all_of_a_plane_is_told_and_nothing_wrong(
    how: dict[str, int], seconds: int | None
) -> None:
    clock = count()
    own, spans = lagged(20, 1, 2, 10), {"environment.k": (1, 60), "hand.b": (Rational(1, 2), 4)}
    with timed_by(lambda: float(next(clock))), limited(seconds):
        told = told_of(own, spans, finest=2.0**-6, **how)
    need_filled(told, 64)
    assert area(told.left) > 0.1
    need_counted(own, told, spans)


SOFT = hs.load_scene("sampled-wall").with_hands(hs.Hand("soft", m="45 g +- 10 %", b=1, k=100))
TWO = F.delay("1 ms"), F.shunt(b="-20 N*s/m"), F.delay("1 s")  # m s^2 + b s + k + 20 s (e^(-s (1 + tau)) - e^(-s))
VARIED: dict[str, tuple[hs.Scene, Spans, tuple[str, ...], int, tuple[float, float]]] = {  # and least areas of stable and unstable
    "a stiffness varies": (SPRING.with_values({"environment.k": "100 N/m +- 20 %"}).with_hands(ARM), {"hand.k": (0, 500), "hand.b": (0, 10)}, ("environment.k",), 6, (0.2, 0.2)),
    "five roots, whose coefficients all vary with the mass": (SOFT, {"hand.k": (90, 110), "hand.b": (2, 4)}, ("hand.m",), 3, (0.9, 0)),
    "two delays cancel at 0 and add up far from it": (hs.Scene(E.mass_spring_damper(b=20), TWO, hands=(hs.Hand("mine", 1, 1, 1),)), {"effects.delay.tau": ("1 ms", "100 ms"), "hand.b": (1, 2)}, (), 4, (0.1, 0.1)),
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("case", VARIED)
def test_what_else_varies_is_counted_in(case: str) -> None:
    found, spans, others, finest, least = VARIED[case]
    told = told_of(found, spans, others, finest=2.0**-finest)
    assert area(told.stable) > least[0]
    assert area(told.unstable) >= least[1]
    need_counted(found, told, spans, others)


@pytest.mark.slow
def test_a_sampled_wall_is_told_all_over_its_plane() -> None:
    """Held by nothing but its device, 0.04 kg and 0.8 N s/m, T = 1 ms: K < 1605.35 for B = 0, 2384.3034697805 for B = 0.4."""
    loop = F.sampled_loop("1 ms", "backward-difference"), F.shunt(m="40 g", b="0.8 N*s/m")
    own = hs.Scene(E.kelvin_voigt(1000, "0.4 N*s/m"), loop, hands=(hs.Hand("none"),))
    spans = {"environment.b": (0, 1), "environment.k": (1000, 3000)}
    told = told_of(own, spans, finest=2.0**-6)
    need_filled(told, 64)
    assert area(told.left) < 0.2
    for at, critical in ((0.0, 1605.35113477512), (0.4, 2384.3034697805)):  # cells beside them may be undecided
        for cells, side in ((told.stable, 1), (told.unstable, -1)):
            there = cells[(cells[:, 0, 0] <= at) & (cells[:, 0, 1] >= at)]
            assert (side * (critical - 1000 - 2000 * there[:, 1, (1 + side) // 2]) > 0).all()
    need_counted(own, told, spans)


@pytest.mark.dear("1")
@pytest.mark.parametrize("hidden", [1, 2])
def test_what_is_hidden_at_one_value_alone_is_a_root_there_as_at_its_neighbours(hidden: int) -> None:
    """s^2 - c s + 4 over s^2 - s + 4 between hold and sampler: at c = 1, the middle of the first rectangles, alone it cancels."""
    wall = E.expression("k*(s^2 - c*s + 4)/(s + 3)^2", parameters={"k": 1, "c": 1})
    device = F.shunt(Z=f"(s^2 - s + 4)*(s + 5)/(s + {hidden})", parameters={})
    own = hs.Scene(wall, (F.zero_order_hold("10 ms"), device), hands=(hs.Hand("none"),))
    spans = {"environment.c": ("0.9875", "1.1875"), "environment.k": (1, 2)}
    assert [unstable_roots(own.with_values({"environment.c": c}), own.hands[0]).number for c in (1, "1.1")] == [2, 2]
    need_counted(own, told_of(own, spans, finest=2.0**-3), spans)


def test_what_shakes_by_more_roots_than_could_be_hidden_is_told_to_shake() -> None:
    """(s^2 + s + 4 + k) (s - 1) + b s (s - 2) over s - 1, which could hide one root on the right, and no more."""
    own = hs.Scene(
        E.expression("k + b*s*(s - c)/(s - 1)", parameters={"k": 2, "b": -3, "c": 2}), hands=(hs.Hand("mine", 1, 1, 4),)
    )
    spans = {"environment.b": (-5, 5), "environment.k": (1, 40)}
    told = told_of(own, spans, finest=2.0**-4)
    assert area(told.unstable) > 0.1
    need_filled(told, 16)
    need_counted(own, told, spans, times=12)


@pytest.mark.slow
def test_stable_in_several_hands_is_stable_in_each() -> None:
    spans = {"tau": ("1 ms", "60 ms"), "environment.k": (10, 1000)}
    loose = hs.Hand("loose", m="0.1 kg", b="3 N*s/m")
    both, one = (told_of(SPRING.with_hands(*x), spans, finest=2.0**-4) for x in ((ARM, loose), (ARM,)))
    assert 0 < area(both.stable) < area(one.stable)
    need_counted(SPRING.with_hands(ARM, loose), both, spans)


@pytest.mark.parametrize("hands", [(ARM,), (hs.Hand("heavy", m=2000, b=10), ARM)])
def test_a_plane_into_which_roots_come_from_infinity_is_told_as_open_in_all_hands(hands: tuple[hs.Hand, ...]) -> None:
    own = hs.load_scene("satellite-contact").with_hands(*hands)
    path = f"hands.{ARM.name}" if len(hands) > 1 else "hand"
    with pytest.raises(UndecidedError, match="infinity"):
        told_of(own, {f"{path}.m": (100, 1000), f"{path}.b": (0, 10)})


@pytest.mark.dear("10", "21")
@pytest.mark.few(3)
@pytest.mark.parametrize("seed", range(5, 29))
def test_no_set_of_values_of_a_random_plane_is_against_it(seed: int) -> None:
    rng = np.random.default_rng(seed)
    plain = scene(case(Seeded(7000 + seed), order=4))
    m, b, k = (Rational(int(x), 8) for x in rng.integers(1, 60, 3))
    own = plain.with_hands(hs.Hand("mine", m=m, b=b, k=k))
    free = [p.path for p in plain.parameters if p.value.is_Rational and p.value > 0][:1]
    spans = {path: (own.knobs[path].value / 2, own.knobs[path].value * 2) for path in [*free, "hand.b", "hand.k"][:2]}
    need_counted(own, told_of(own, spans, finest=2.0**-5), spans, times=3)


def test_thresholds_are_sides_of_a_plane_that_move_no_root() -> None:
    """Of two of them all is stable, or nothing; beside a damper its own condition decides, b (b + 10) > 20."""
    jnds = "evaluation.jnd.real", "evaluation.jnd.imag"
    ranges = [(Rational(1, 10), Rational(1, 2)), (Rational(1), Rational(4))]
    for k, part in ((20, 0), (90, 1)):
        now = lagged(k, 1, 2, 10)
        found = held_rectangles(now, (now.knobs[jnds[0]], now.knobs[jnds[1]]), ranges)
        assert found is not None
        assert [i for i, x in enumerate(found.parts) if len(x)] == [part]
        whole = np.concatenate(found.parts)
        assert [whole[:, i, 0].min() for i in (0, 1)] == pytest.approx([0.1, 1])
        assert [whole[:, i, 1].max() for i in (0, 1)] == pytest.approx([0.5, 4])
    loose, least = lagged(20, 1, 2, 10), -5 + 45**0.5
    own = held_rectangles(loose, (loose.knobs["evaluation.jnd"], loose.knobs["hand.b"]), ranges)
    assert own is not None
    assert (own.kept[:, 1, 0] > least).all()
    assert (own.broken[:, 1, 1] < least).all()
    assert (own.left[:, 1, 0] <= least).all()
    assert (own.left[:, 1, 1] >= least).all()
    assert own.share_left == pytest.approx(1 / 512, rel=1e-9)


# Margins: by how much the rendered force may change until a display shakes


def test_margins_of_a_delayed_spring_are_those_of_its_loop() -> None:
    """m s^2 + b s + k + g K exp(-s (tau + more)) in the arm that was measured."""
    [found] = hs.stability("delayed-spring", "postural-arm", "k").to_dict()["held"]
    m, b, k, K, tau = 0.554, 6.45, 135.0, 100.0, 0.036
    own: dict[str, Any] = found["margins"]

    def g(w: float, late: float = tau) -> complex:
        return complex(-(-m * w**2 + 1j * b * w + k) / (K * np.exp(-1j * w * late)))

    above, delay = own["gain"], own["delay"]
    assert above["below"] is None
    assert abs(g(above["omega"]) - above["above"]) < 1e-9
    assert abs(g(delay["omega"], tau + delay["above"]) - 1) < 1e-9
    assert (
        0
        <= delay["above"]
        <= min(np.angle(1 / g(w)) % (2 * np.pi) / w for w in (10.560751818161899, 15.501129766124679)) + 1e-9
    )
    grid = np.linspace(1e-3, 100, 100_001)
    rises = [i for i in range(len(grid) - 1) if (abs(g(grid[i])) - 1) * (abs(g(grid[i + 1])) - 1) < 0]
    angles = [abs(np.angle(g(brentq(lambda w: abs(g(w)) - 1, grid[i], grid[i + 1], xtol=1e-13)))) for i in rises]
    assert abs(own["phase_deg"] - np.degrees(min(angles))) < 1e-6


def test_a_rational_loop_has_the_margins_of_its_open_loop() -> None:
    """A spring of 100 N/m behind a lag of 10 rad/s in a hand of 1 kg, 1 N s/m: g 1000/((s^2 + s)(s + 10)), as from textbooks."""
    scene = hs.Scene(E.mass_spring_damper(k="1 N/m"), (F.first_order_lag("10 rad/s"),))
    [x] = hs.stability(scene, hs.Hand("own", m="1 kg", b="1 N*s/m")).margins
    assert x
    assert x.above
    assert x.phase
    delay, phase = (y.end(ZERO, 1) for y in (x.delay, x.phase))
    assert delay
    assert phase
    assert (x.above.value.digits(10), x.below) == ("11.00000000", None)  # Routh: 10 g < 11 * 10
    w = mpmath.findroot(lambda y: y * mpmath.sqrt(y**2 + 1) * mpmath.sqrt(y**2 / 100 + 1) - 1, 0.8)
    angle = mpmath.pi / 2 - mpmath.atan(w) - mpmath.atan(w / 10)
    assert abs(float(phase.value) - float(mpmath.degrees(angle))) < 1e-9
    assert abs(float(delay.value) - float(angle / w)) < 1e-9


@pytest.mark.parametrize(("real", "imag"), [(3, 4), (3, -4), (-3, 4), (-3, -4), (5, 0), (-5, 0), (0, 2), (0, -2)])
def test_a_phase_is_the_angle_to_minus_one_on_either_side(real: int, imag: int) -> None:
    ratio = tuple(RealFunction(Ring().axis.convert(Integer(x))) for x in (real, imag))
    found = Turned(ratio, ExactNumber(Integer(7))).ball(64)  # type: ignore[arg-type]
    assert float(found.mid()) == pytest.approx(float(abs(np.degrees(np.angle(complex(-real, -imag + 0.0))))), abs=1e-12)


def period(K: float, B: float, hand: tuple[float, float, float], T: float, late: float) -> np.ndarray:
    """What a period does to place, speed, and the last forces: K x + B (x - last x)/T, so much late, held for T."""
    m, b, k = hand
    A = np.array([[0, 1, 0], [-k / m, -b / m, 1 / m], [0, 0, 0]])
    whole = int(late // T)
    rest = late - whole * T
    n = 3 + whole + 1  # place, speed, last place, and the forces that are under way, the newest first
    first, second = expm(A * rest), expm(A * (T - rest))
    step, force = np.zeros((n, n)), np.zeros(n)
    force[0], force[2] = -K - B / T, B / T
    row = [force, *(np.eye(n)[3 + i] for i in range(whole + 1))]  # the force now, and those before it
    old, new = row[whole + 1], row[whole]
    motion = np.eye(n)[:2]
    moved = first[:2, :2] @ motion + np.outer(first[:2, 2], old)
    step[:2] = second[:2, :2] @ moved + np.outer(second[:2, 2], new)
    step[2] = np.eye(n)[0]
    for i in range(whole + 1):
        step[3 + i] = row[i]
    return step


@pytest.mark.few("postural-arm-3")
@pytest.mark.parametrize(("hand", "late"), [("light-touch", 1), ("postural-arm", 1), ("postural-arm", 3)])
def test_margins_of_a_sampled_wall_are_where_an_eigenvalue_of_a_period_leaves_the_circle(hand: str, late: int) -> None:
    loop = F.sampled_loop("1 ms", "backward-difference", late)
    scene, own = hs.Scene(E.kelvin_voigt(400, "0.4"), (loop, F.shunt(m="40 g", b="0.8"))), hs.hands[hand]
    x = margins(scene, own)
    delay = x.delay.end(ZERO, 1)
    assert x.above
    assert delay
    assert x.phase is None
    assert x.below is None
    device = {p.key: float(p.value) for p in scene.effects[1].parameters}
    held = tuple(float(p.value) + device.get(p.key, 0.0) for p in own.parameters)

    def largest(g: float, more: float) -> complex:
        found = np.linalg.eigvals(period(400 * g, 0.4 * g, held, 1e-3, late * 1e-3 + more))
        return complex(found[abs(found).argmax()])

    def radius(g: float, more: float) -> float:
        return abs(largest(g, more))

    g, more = float(x.above.value), float(delay.value)
    for low, high in (
        (radius(g * (1 - 1e-7), 0), radius(g * (1 + 1e-7), 0)),
        (radius(1, more * (1 - 1e-7)), radius(1, more * (1 + 1e-7))),
    ):
        assert low < 1 < high
    row = x.row()
    assert (row["gain"]["below"], row["gain"]["above"], row["delay"]["above"], row["phase_deg"]) == (
        None,
        g,
        more,
        None,
    )
    for name, at in (("gain", (g, 0.0)), ("delay", (1.0, more))):
        assert row[name]["omega"] == pytest.approx(abs(np.angle(largest(*at))) / 1e-3, rel=1e-5)
    assert row["searched"] == {"gain": [1e-3, 1e3], "delay": [0, 1e3]}
    assert all(radius(10 ** (log10(g) * i / 40 - 3 * (i % 2)), 0) < 1 for i in range(40))
    assert all(radius(1, more * i / 40) < 1 for i in range(40))


TUSTIN = {"k": "500", "b": "2", "T": "0.001", "m": "0.1", "d": "-2.5", "m_h": "0.1", "b_h": "2", "k_h": "0"}
HELD = {"k": "40", "b": "3", "T": "0.02", "m": "0.05", "d": "0.1", "m_h": "0.2", "b_h": "30", "k_h": "5"}


@pytest.mark.slow
@pytest.mark.parametrize(
    "wall",
    [
        Wall(TUSTIN, "tustin"),  # a pole of the controller at z = -1, and a root next to it
        Wall(HELD | {"k": "900", "b": "2", "d": "0.2"}, "tustin", samples=1, late="0.0013"),
        Wall(HELD | {"b": "0.5", "m_h": "0.1", "b_h": "4", "k_h": "200"}, "tustin", samples=1),
        Wall(HELD | {"b_h": "4"}, late="0.0013"),  # many samples late
        Wall(HELD | {"k": "900", "b": "0", "T": "0.001", "k_h": "200"}, "tustin"),
    ],
)
def test_a_delay_comes_to_a_margin_at_which_the_first_eigenvalue_leaves(wall: Wall) -> None:
    delay = margins(wall.scene, wall.scene.hands[0]).delay.end(ZERO, 1)
    assert delay
    more = float(delay.value)

    def radius(share: float) -> float:
        return replace(wall, late=repr(float(wall.late) + more * float(share))).radius()

    assert radius(0.99999) < 1 < radius(1.00001)
    assert max(map(radius, np.linspace(0, 0.99999, 120))) < 1
    if more < 30 * float(wall.late):  # the limit of that delay is the same, as far as it is searched
        own, knob = wall.scene.hands[0], wall.scene.knobs["effects.delay.tau"]
        found = stable_values(wall.scene, own, knob, ALLOWED[knob.rule], stable_in(own), near=True)
        tau = found.ends[-1].value
        assert float(tau) == pytest.approx(float(wall.late) + more, rel=1e-12)


@pytest.mark.slow
def test_a_margin_that_is_not_reached_is_told_as_far_as_it_was_searched() -> None:
    wall, told, ticks = Wall(TUSTIN, "tustin"), list[float](), count()
    with timed_by(ticks.__next__), limited(10**9):
        whole = margins(wall.scene, wall.scene.hands[0])
    most = next(ticks)
    for seconds in range(1, most, most // 40):
        with timed_by(count().__next__), limited(seconds):
            found = margins(wall.scene, wall.scene.hands[0])
        assert "delay" in dict(found.undecided)
        told += [float(x.high or 0) for x in found.delay.feasible]
    end = whole.delay.end(ZERO, 1)
    assert end is not None
    assert "delay" not in dict(whole.undecided)
    assert told == sorted(told)
    assert 0.0004 < told[-1] <= float(end.value) * (1 + 1e-9)


def test_a_sampled_wall_as_stiff_as_the_hand_may_be_late_by_any_time() -> None:
    """The loop has a gain of 1 at 0 rad/s, and less at all other frequencies."""
    own, wall = hs.hands["firm-grip"], (400, 0.4)
    x = margins(hs.load_scene("virtual-wall"), own)
    assert (x.delay.end(ZERO, 1), x.undecided) == (None, ())
    held = tuple(float(p.value) + y for p, y in zip(own.parameters, (0.04, 0.8, 0), strict=True))
    for late in (0.0003, 0.0047, 0.031, 0.11):
        assert abs(np.linalg.eigvals(period(*wall, held, 1e-3, late))).max() < 1


@pytest.mark.slow
def test_a_filtered_late_mass_in_a_clock_has_its_margin_at_once() -> None:
    """0.5 kg, 5 N s/m, 300 N/m at 1 kHz through 40 Hz and 5 ms: whole samples and a part, 76 more than there are."""
    chain = (
        F.sampled_loop("1 ms", "backward-difference"), F.first_order_lag("40 Hz"), F.delay("5 ms"),
        F.shunt(m="80 g", b="0.3 N*s/m"),
    )  # fmt: skip
    scene, hand = hs.Scene(E.mass_spring_damper(m="0.5 kg", b="5 N*s/m", k="300 N/m"), chain), hs.hands["postural-arm"]
    x = margins(scene, hand)
    late = x.delay.end(ZERO, 1)
    assert late
    more = float(late.value)

    def radius(late: float) -> float:
        """Of the exact step: place, speed and filter held for a period, two samples before, and the forces under way."""
        m, b, k = (float(p.value) + y for p, y in zip(hand.parameters, (0.08, 0.3, 0.0), strict=True))
        T, corner = 1e-3, 80 * np.pi
        A = np.array([[0, 1, 0, 0], [-k / m, -b / m, 1 / m, 0], [0, 0, -corner, corner], [0, 0, 0, 0]])
        whole = int(late // T)
        rest, n = late - whole * T, 5 + whole + 1
        first, second = expm(A * rest), expm(A * (T - rest))
        now = np.zeros(n)
        now[[0, 3, 4]] = -(300 + 5 / T + 0.5 / T**2), 5 / T + 1 / T**2, -0.5 / T**2
        forces = [now, *np.eye(n)[5:]]
        moved = first[:3, :3] @ np.eye(n)[:3] + np.outer(first[:3, 3], forces[whole + 1])
        step = np.zeros((n, n))
        step[:3] = second[:3, :3] @ moved + np.outer(second[:3, 3], forces[whole])
        step[3], step[4] = np.eye(n)[0], np.eye(n)[3]
        step[5:] = forces[: whole + 1]
        return float(abs(np.linalg.eigvals(step)).max())

    assert radius(0.005 + more * (1 - 1e-5)) < 1 < radius(0.005 + more * (1 + 1e-5))
    assert max(radius(0.005 + more * x) for x in np.linspace(0, 0.999, 40)) < 1


def test_of_a_factor_that_is_not_told_without_end_is_told_how_far_it_is_known() -> None:
    x = margins(hs.load_scene("virtual-coupling"), hs.hands["postural-arm"])
    known = x.gain.about(ExactNumber(Integer(1)))
    assert (known.verdict.value, float(known.low), float(known.high)) == ("holds", 0.001, 9)
    assert (x.above, [name for name, _ in x.undecided]) == (None, ["gain"])
    wider = hs.load_scene("virtual-coupling")
    for factor in ("1/1000", "9"):
        own = replace(wider, effects=(F.series("g", parameters={"g": factor}, name="more"), *wider.effects))
        assert held(own, hs.hands["postural-arm"]).stable


def test_what_shakes_or_renders_nothing_has_no_margin() -> None:
    assert hs.stability("delayed-spring", "light-touch", "k").margins == (None,)
    loop = F.sampled_loop("1 ms", "backward-difference"), F.shunt(m="0.2 kg", b="0.1 N*s/m")
    [free] = hs.stability(hs.Scene(E.kelvin_voigt(k=0, b=0), loop), "light-touch", "environment.k").margins
    assert free
    assert free.row() == {
        "gain": {"below": None, "above": None, "omega": None},
        "delay": {"above": None, "omega": None},
        "phase_deg": None,
        "searched": {"gain": [0.001, 1000.0], "delay": [0.0, 1000.0]},
    }
