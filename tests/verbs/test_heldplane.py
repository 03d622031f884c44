"""Stable, or not, all over a plane of two numbers: against roots counted at single values, ends of rectangles among them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from strategies import Seeded, case, scene
from sympy import Expr, Rational, Symbol, pi

import haptisym as hs
from haptisym.kernel.budget import limited
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import UndecidedError
from haptisym.programs.taylormodels import Array
from haptisym.verbs.stability.held import unstable_roots
from haptisym.verbs.tolerances.clockplane import ClockPlane
from haptisym.verbs.tolerances.heldplane import _NONE, HeldPlane, _first, _Loop, _middle, _Search, _told, held_plane

Cell = tuple[tuple[Fraction, Fraction], ...]


@dataclass(frozen=True)
class Line:
    """In place of a loop: clear where no point of a cell is on the line (or plane) of points that a linear form sends to 0."""

    weights: tuple[int, ...]
    number: Fraction

    @property
    def ranges(self) -> tuple[int, ...]:
        return self.weights

    def is_clear(self, cell: Cell) -> bool:
        ends = [sorted((w * a, w * b)) for w, (a, b) in zip(self.weights, cell, strict=True)]
        return not sum(x[0] for x in ends) <= self.number <= sum(x[1] for x in ends)


@pytest.mark.parametrize("more", [0, 1])
@pytest.mark.parametrize(("most", "seconds"), [(10**6, None), (60, None), (10**6, 1e-9)])
@pytest.mark.parametrize("lines", [[((1, 1), "1/2")], [((2, -1), "1/3"), ((1, 3), "9/4")], [((1, 0), "5/16")], []])
def test_rectangles_of_a_plane_are_clear_or_left_and_none_is_lost(
    more: int, most: int, seconds: float | None, lines: list[tuple[tuple[int, ...], str]]
) -> None:
    """Whatever ends the search: all is told, nothing twice, and what is clear is so for all that else varies."""
    loops = [Line((*w, *[1] * more), Fraction(x)) for w, x in lines] or [Line((1,) * (2 + more), Fraction(9))]
    with limited(seconds):
        clear, left = ClockPlane(loops, 1 / 16, most).rectangles()  # type: ignore[arg-type]
    assert area(clear) + area(left) == 1
    cells = np.concatenate([clear, left])
    for i, x in enumerate(cells):
        meets = np.minimum(x[:, 1], cells[:i, :, 1]) - np.maximum(x[:, 0], cells[:i, :, 0])
        assert not (meets > 0).all(-1).any()
    for x in clear.tolist():
        whole = tuple((Fraction(a), Fraction(b)) for a, b in [*x, *[[0, 1]] * more])
        assert all(loop.is_clear(whole) for loop in loops)
    if most > 60 and seconds is None:
        assert (left[..., 1] - left[..., 0] == 1 / 16).all()
        assert (clear[..., 1] - clear[..., 0] >= 1 / 16).all()
        for x in left.tolist():
            whole = tuple((Fraction(a), Fraction(b)) for a, b in [*x, *[[0, 1]] * more])
            assert not all(loop.is_clear(whole) for loop in loops)


SPRING = hs.load_scene("delayed-spring")
ARM = hs.hands["postural-arm"]


def of(
    found: hs.Scene, plane: Mapping[str, tuple[object, object]], others: tuple[str, ...] = (), **how: object
) -> HeldPlane:
    """The plane of two numbers by their paths."""
    knobs = [found.knobs[x] for x in plane]
    ends: dict[Symbol, tuple[Expr, Expr]] = {
        x.symbol: (x.number(a), x.number(b)) for x, (a, b) in zip(knobs, plane.values(), strict=True)
    }
    more = {found.knobs[x].symbol: found.knobs[x].interval for x in others}
    return held_plane(found, found.hands, ends, more, **how)  # type: ignore[arg-type]


def area(cells: Array) -> float:
    return float((cells[..., 1] - cells[..., 0]).prod(-1).sum())


def is_refuted(
    found: hs.Scene,
    told: HeldPlane,
    plane: Mapping[str, tuple[object, object]],
    others: tuple[str, ...] = (),
    times: int = 6,
) -> list[object]:
    """Sets of values, within rectangles and at their ends, that count otherwise."""
    rng, wrong = np.random.default_rng(7), list[object]()
    for cells, is_stable in ((told.stable, True), (told.unstable, False)):
        for cell in cells[rng.integers(0, len(cells), times)] if len(cells) else ():
            values: dict[str, Expr] = {}
            for (path, (a, b)), (low, high) in zip(plane.items(), cell.tolist(), strict=True):
                share = Rational(low) + Rational(int(rng.integers(0, 5)), 4) * (Rational(high) - Rational(low))
                start, end = found.knobs[path].number(a), found.knobs[path].number(b)
                values[path] = start + share * (end - start)
            for path in others:
                low, high = found.knobs[path].interval or (0, 0)
                values[path] = low + Rational(int(rng.integers(0, 5)), 4) * (high - low)
            now = found.with_values(values)
            if all(unstable_roots(now, x).number == 0 for x in now.hands) is not is_stable:
                wrong.append(values)
    return wrong


def test_the_boundary_of_a_late_spring_in_an_arm_lies_in_what_is_left() -> None:
    """36 ms: up to K = 199.8521; in between less than a hundredth of the area."""
    held = SPRING.with_hands(ARM)
    plane = {"tau": ("1 ms", "60 ms"), "environment.k": (10, 1000)}
    told = of(held, plane)
    assert area(told.left) < 0.01
    assert sum(map(area, (told.stable, told.unstable, told.left))) == pytest.approx(1)
    at = 35 / 59, (199.8521022587101 - 10) / 990
    assert any((x[:, 0] <= at).all() and (x[:, 1] >= at).all() for x in told.left)
    assert not is_refuted(held, told, plane)


@pytest.mark.slow
def test_what_else_varies_is_counted_in() -> None:
    held = SPRING.with_values({"environment.k": "100 N/m +- 20 %"}).with_hands(ARM)
    plane = {"hand.k": (0, 500), "hand.b": (0, 10)}
    told = of(held, plane, ("environment.k",), finest=2.0**-6)
    assert min(area(told.stable), area(told.unstable)) > 0.2
    assert not is_refuted(held, told, plane, ("environment.k",))


@pytest.mark.slow
def test_a_sampled_wall_is_told_all_over_its_plane() -> None:
    """Held by nothing but its device, 0.04 kg and 0.8 N s/m, T = 1 ms: K < 1605.35 for B = 0, 2384.3034697805 for B = 0.4."""
    wall = hs.environments.kelvin_voigt(1000, "0.4 N*s/m")
    loop = hs.effects.sampled_loop("1 ms", "backward-difference"), hs.effects.shunt(m="40 g", b="0.8 N*s/m")
    held = hs.Scene(wall, loop, hands=(hs.Hand("none"),))
    plane = {"environment.b": (0, 1), "environment.k": (1000, 3000)}
    told = of(held, plane, finest=2.0**-6)
    assert area(told.left) < 0.2
    for at, critical in ((0.0, 1605.35113477512), (0.4, 2384.3034697805)):
        for cells, side in ((told.stable, 1), (told.unstable, -1)):
            own = cells[(cells[:, 0, 0] <= at) & (cells[:, 0, 1] >= at)]
            assert len(own)
            assert (side * (critical - 1000 - 2000 * own[:, 1, (1 + side) // 2]) > 0).all()
    assert not is_refuted(held, told, plane)


@pytest.mark.slow
def test_a_late_filtered_wall_is_told_in_hands_of_a_mass_that_varies() -> None:
    """Five roots, whose coefficients all vary with the mass: it is stable in all such hands."""
    held = hs.load_scene("sampled-wall").with_hands(hs.Hand("soft", m="45 g +- 10 %", b=1, k=100))
    plane = {"hand.k": (90, 110), "hand.b": (2, 4)}
    told = of(held, plane, ("hand.m",), finest=2.0**-3)
    assert area(told.stable) > 0.9
    assert not len(told.unstable)
    assert not is_refuted(held, told, plane, ("hand.m",))


@pytest.mark.slow
def test_two_delays_that_cancel_at_0_add_up_far_from_it() -> None:
    """m s^2 + b s + k + 20 s (e^(-s (1 + tau)) - e^(-s)): stable at 1 ms; not at 100 ms, by roots at tens of rad/s."""
    loop = hs.effects.delay("1 ms"), hs.effects.shunt(b="-20 N*s/m"), hs.effects.delay("1 s")
    held = hs.Scene(hs.environments.mass_spring_damper(b="20 N*s/m"), loop, hands=(hs.Hand("mine", m=1, b=1, k=1),))
    plane = {"effects.delay.tau": ("1 ms", "100 ms"), "hand.b": (1, 2)}
    told = of(held, plane, finest=2.0**-4)
    assert min(area(told.stable), area(told.unstable)) > 0.1
    assert not is_refuted(held, told, plane)


def test_what_is_hidden_at_one_value_alone_does_not_make_its_neighbours_stable() -> None:
    """s^2 - c s + 4 over s^2 - s + 4 between hold and sampler: at c = 1, the middle of the first rectangles, alone it cancels."""
    wall = hs.environments.expression("k*(s^2 - c*s + 4)/(s + 3)^2", parameters={"k": 1, "c": 1})
    device = hs.effects.shunt(Z="(s^2 - s + 4)*(s + 5)/(s + 1)", parameters={})
    held = hs.Scene(wall, (hs.effects.zero_order_hold("10 ms"), device), hands=(hs.Hand("none"),))
    plane = {"environment.c": ("0.9875", "1.1875"), "environment.k": (1, 2)}
    assert [unstable_roots(held.with_values({"environment.c": c}), held.hands[0]).number for c in (1, "1.1")] == [0, 2]
    assert not is_refuted(held, of(held, plane, finest=2.0**-3), plane)


@pytest.mark.parametrize("seed", range(4))
def test_rectangles_that_touch_have_the_verdict_of_the_largest_and_all_hands_must_hold(seed: int) -> None:
    """Of up to sixty heaps of rectangles the largest ones are counted; what no hand is known to break is left."""
    rng = np.random.default_rng(seed)
    clear, heaps = list[list[list[float]]](), list[list[int]]()
    for n in range(int(rng.integers(3, 60))):
        left, widths = 100.0 * n, rng.permutation([1.0, 2.0, 4.0])[: rng.integers(1, 4)] * (1 + n / 8)
        heaps.append([])
        for width in widths:
            heaps[-1].append(len(clear))
            clear.append([[left, left + width], [0.0, width]])
            left += width
    verdicts = [{n: [True, False, None][rng.integers(0, 3)] for n in range(len(heaps))} for _ in range(2)]
    known = [np.array(x) for x in clear]

    class Hand:
        def __init__(self, told: dict[int, bool | None]) -> None:
            self.told = told

        def is_stable(self, rectangle: Array) -> bool | None:
            [i] = [i for i, x in enumerate(known) if (x == rectangle).all()]
            [n] = [n for n, own in enumerate(heaps) if i in own]
            assert all(known[i][1, 1] >= known[k][1, 1] for k in heaps[n])
            return self.told[n]

    own_left = np.array([[[-2.0, -1.0], [0.0, 1.0]]])
    found = _told([Hand(x) for x in verdicts], np.array(clear), own_left)  # type: ignore[misc]
    area_of = [sum(known[i][1, 1] ** 2 for i in own) for own in heaps]
    counted = sorted(range(len(heaps)), key=lambda n: -area_of[n])[:48]
    for n, own in enumerate(heaps):
        told = [x[n] for x in verdicts] if n in counted else [None]
        where = found.stable if all(told) else found.unstable if False in told else found.left
        assert all(any((x == known[i]).all() for x in where) for i in own)
    assert sum(map(len, (found.stable, found.unstable, found.left))) == len(clear) + 1
    assert (found.left[0] == own_left[0]).all()


@pytest.mark.slow
def test_stable_in_several_hands_is_stable_in_each() -> None:
    plane = {"tau": ("1 ms", "60 ms"), "environment.k": (10, 1000)}
    loose = hs.Hand("loose", m="0.1 kg", b="3 N*s/m")
    both, one = (of(SPRING.with_hands(*x), plane, finest=2.0**-6) for x in ((ARM, loose), (ARM,)))
    assert 0 < area(both.stable) < area(one.stable)
    assert not is_refuted(SPRING.with_hands(ARM, loose), both, plane)


def test_a_plane_into_which_roots_come_from_infinity_is_told_as_open() -> None:
    held = hs.load_scene("satellite-contact").with_hands(ARM)
    with pytest.raises(UndecidedError, match="infinity"):
        of(held, {"hand.m": (100, 1000), "hand.b": (0, 10)})


@pytest.mark.parametrize("seed", [5, 6, 7, *(pytest.param(n, marks=pytest.mark.slow) for n in range(8, 40))])
def test_no_set_of_values_of_a_random_plane_is_against_it(seed: int) -> None:
    rng = np.random.default_rng(seed)
    plain = scene(case(Seeded(7000 + seed), order=4))
    m, b, k = (Rational(int(x), 8) for x in rng.integers(1, 60, 3))
    held = plain.with_hands(hs.Hand("mine", m=m, b=b, k=k))
    free = [p.path for p in plain.parameters if p.value.is_Rational and p.value > 0][:1]
    plane = {path: (held.knobs[path].value / 2, held.knobs[path].value * 2) for path in [*free, "hand.b", "hand.k"][:2]}
    try:
        told = of(held, plane, finest=2.0**-5)
    except UndecidedError:
        return
    assert not is_refuted(held, told, plane, times=3)


class Sheet:
    """In place of the axis: shares of frequency, plane and what else varies at which a linear form has a value."""

    def __init__(self, weights: tuple[float, ...], number: float) -> None:
        self.weights, self.number, self.sides = np.array(weights), number, len(weights)

    def bounded(self, cells: Array) -> tuple[Array, Array]:
        ends = np.sort(self.weights[:, None] * cells, -1).sum(1)
        rates = abs(self.weights) * (cells[..., 1] - cells[..., 0])
        return (ends[:, 0] > self.number) | (ends[:, 1] < self.number), rates

    def is_clear(self, rectangle: Array) -> bool:
        rest = np.tile([0.0, 1.0], (self.sides - 3, 1))
        return bool(self.bounded(np.concatenate([[[0.0, 1.0]], rectangle, rest])[None])[0][0])


SHEETS = {
    "none": [Sheet((1, 1, 1), 9)],
    "across": [Sheet((0.25, 1, 1), 1.3)],
    "two": [Sheet((0.1, 1, -1), 0.21), Sheet((-0.2, 0.1, 1, 0.125), 0.8)],
    "frequencies alone": [Sheet((8, 0.001, 0.002), 4)],
    "along one side": [Sheet((0, 0, 1), 0.3)],
}


@pytest.mark.parametrize("case", SHEETS)
@pytest.mark.parametrize("most", [10**6, 20_000, 0])
def test_a_rectangle_is_clear_where_no_frequency_meets_a_zero_in_it_and_what_is_left_is_small(
    case: str, most: int
) -> None:
    """Whatever ends the search, rectangles fill the plane once."""
    forms, finest = SHEETS[case], 2.0**-4
    search = _Search(finest, most, forms)  # type: ignore[arg-type]
    search.go()
    clear, left = (np.concatenate([_NONE, *x]) for x in (search.clear, search.left))
    assert area(clear) + area(left) == 1
    pixels = np.zeros((16, 16), int)
    for x in np.concatenate([clear, left]):
        (a, b), (c, d) = (x / finest).astype(int).tolist()
        pixels[a:b, c:d] += 1
    assert (pixels == 1).all()
    assert all(form.is_clear(x) for x in clear for form in forms)
    assert not any(all(form.is_clear(x) for form in forms) for x in left)
    if most == 10**6:
        assert (left[..., 1] - left[..., 0] == finest).all()
        assert search.looked < most
        if case == "along one side":
            assert (clear[:, 0, 1] - clear[:, 0, 0] == 1 / 8).all()  # what it does not depend on is not cut


def test_a_set_of_values_in_the_middle_of_a_rectangle_is_told_exactly() -> None:
    """Shares of both ranges, and of what else varies the middle."""
    x, y, z = (Symbol(n) for n in "xyz")
    ranges: dict[Symbol, tuple[Expr, Expr]] = {
        x: (Rational(1, 3), Rational(7, 3)),
        y: (pi, 3 * pi),
        z: (Rational(-1), Rational(4, 5)),
    }
    rectangle = np.array([[0.25, 0.5], [0.5, 1.0]])
    assert _middle(ranges, rectangle) == {x: Rational(13, 12), y: Rational(5, 2) * pi, z: Rational(-1, 10)}


@pytest.mark.parametrize("sides", [3, 4, 6])
def test_a_plane_is_asked_about_all_frequencies_and_all_that_varies_besides(sides: int) -> None:
    cells = _first(sides)
    assert cells.shape[1:] == (sides - 2, 2)
    assert (cells[0, 0, 0], cells[-1, 0, 1]) == (0, 1)
    assert (cells[1:, 0, 0] == cells[:-1, 0, 1]).all()
    assert (cells[:, 0, 0] < cells[:, 0, 1]).all()
    assert (cells[:, 1:] == [0, 1]).all()


@pytest.mark.parametrize(
    ("bottom", "shared"),
    [
        (lambda q, s: s + 3 + q, 0),
        (lambda q, s: s - 3 + q, 1),
        (lambda q, s: (s - 3 + q) * (s - 2 - q), 2),
        (lambda q, s: s + q, None),  # its zero goes over the axis
        (lambda q, s: q * s + 1, None),  # or comes from infinity
    ],
)
def test_zeros_that_may_cancel_are_counted_where_none_of_them_goes_over_the_axis(
    bottom: Any, shared: int | None
) -> None:
    """q from -1 to 1."""
    q, p = Symbol("q", real=True), Symbol("p", real=True)
    forms = [bottom(q, hs.s).expand(), (hs.s**2 + p * hs.s + q).expand()]
    ring = Ring.of(forms)
    low, top = (ring.convert(x).numerator for x in forms)
    loop = _Loop(ring, top, low, {q: (Rational(-1), Rational(1)), p: (Rational(1), Rational(2))})
    assert loop._shared == shared
