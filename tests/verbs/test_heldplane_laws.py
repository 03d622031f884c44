"""Planes of two numbers in which a display is held: by Hurwitz' condition of third order, and by zeros that were placed."""

from __future__ import annotations

from fractions import Fraction
from random import Random
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from lagged import lagged, room, text
from sympy import Integer, Rational, Symbol

import haptisym as hs
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import LimitError, UndecidedError
from haptisym.kernel.symbols import s
from haptisym.verbs.require.plane import held_rectangles
from haptisym.verbs.tolerances.heldbox import count_at
from haptisym.verbs.tolerances.heldplane import HeldPlane, _Loop, _Sampled, held_plane


def plane_of(found: hs.Scene, spans: dict[str, tuple[Any, Any]], others: Any = (), **how: Any) -> HeldPlane:
    knobs = [found.knobs[x] for x in spans]
    ends = {x.symbol: (Rational(a), Rational(b)) for x, (a, b) in zip(knobs, spans.values(), strict=True)}
    more = {found.knobs[x].symbol: found.knobs[x].interval for x in others}
    return held_plane(found, found.hands, ends, *([more] if others else []), **how)  # type: ignore[arg-type]


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("varies", [False, True])
def test_a_plane_of_stiffness_and_damping_is_told_as_the_condition_says(seed: int, *, varies: bool) -> None:
    """The room falls with k and grows with b: of a rectangle one corner decides that all are stable, the other that none is."""
    pick = Random(seed)
    m, omega_c = Fraction(pick.randint(5, 20), 10), Fraction(pick.randint(5, 12))
    heavy = [m, m * Fraction(11, 10)] if varies else [m, m]
    spans: dict[str, Any] = {"environment.k": (1, pick.randint(40, 80)), "hand.b": (Fraction(1, 2), pick.randint(3, 5))}
    told = plane_of(lagged(20, text(heavy), 2, omega_c), spans, ("hand.m",) if varies else (), finest=2.0**-5)
    areas = [float((x[..., 1] - x[..., 0]).prod(-1).sum()) for x in (told.stable, told.unstable, told.left)]
    assert sum(areas) == pytest.approx(1)
    assert areas[2] < 0.25

    whole = [(Fraction(a), Fraction(b)) for a, b in spans.values()]

    def worst(cell: Any, way: int) -> Any:
        (k0, k1), (b0, b1) = (
            tuple(low + Fraction(x) * (high - low) for x in side) for side, (low, high) in zip(cell, whole, strict=True)
        )
        k, b = (k1, b0) if way < 0 else (k0, b1)
        return (min if way < 0 else max)(room(k, y, b, omega_c) for y in heavy)

    assert all(worst(x, -1) > 0 for x in told.stable.tolist())
    assert all(worst(x, 1) < 0 for x in told.unstable.tolist())
    near = [x for x in told.left.tolist() if worst(x, -1) <= 0 <= worst(x, 1)]
    assert len(near) > 0.3 * len(told.left)
    assert (told.left[..., 1] - told.left[..., 0] == 2.0**-5).all()


def test_a_loop_is_stable_without_roots_and_never_with_more_than_poles_could_hide() -> None:
    """Zeros of numerator and denominator that were placed; at a middle of the plane, of what else varies the middle."""
    q, p = Symbol("q", real=True), Symbol("p", real=True)
    ranges: Any = {q: (Rational(1), Rational(3)), p: (Rational(1), Rational(2))}
    for zeros, poles in ((0, 0), (0, None), (1, 0), (1, 1), (1, None), (2, 1), (2, 2)):
        top = ((s + q) * (s - q) ** zeros).expand()
        bottom = (s * q - 2 * s + 1 if poles is None else (s + p) * (s - p) ** poles).expand()
        ring = Ring.of([top, bottom])
        loop = _Loop(ring, ring.convert(top).numerator, ring.convert(bottom).numerator, ranges)
        assert count_at(ring, loop.top, {q: Rational(2), p: Rational(1)}) == zeros
        assert loop._shared == poles
        expected = True if not zeros else False if poles is not None and zeros > poles else None
        assert loop.is_stable(np.array([[0.0, 0.5], [0.0, 1.0]])) is expected


def test_a_loop_with_a_clock_is_told_by_the_middle_of_a_rectangle_or_stays_open() -> None:
    q, p, r = (Symbol(x) for x in "qpr")
    ranges: Any = {q: (Integer(0), Integer(8)), p: (Integer(1), Integer(3)), r: (Integer(0), Integer(1))}
    for told in (True, False, None):
        form: Any = SimpleNamespace(ranges=ranges, is_stable=lambda x, told=told: (told, x))
        at = {q: Integer(3), p: Integer(2), r: Rational(1, 2)}
        found: Any = _Sampled(form).is_stable(np.array([[0.25, 0.5], [0.0, 1.0]]))
        assert found == (told, at)
    for error in (UndecidedError("open"), LimitError("over")):

        def stays_open(_: Any, error: Exception = error) -> bool:
            raise error

        form = SimpleNamespace(ranges=ranges, is_stable=stays_open)
        assert _Sampled(form).is_stable(np.array([[0.25, 0.5], [0.0, 1.0]])) is None


def test_a_plane_with_a_clock_is_cut_no_finer_than_it_pays(monkeypatch: pytest.MonkeyPatch) -> None:
    """As finely as is asked, but to a 256th at most; a sixtieth of the cells, which are dearer."""
    asked: list[Any] = []

    class Plane:
        def __init__(self, forms: Any, finest: float, most: int) -> None:
            asked.append((len(forms), finest, most))

        def rectangles(self) -> Any:
            return np.empty((0, 2, 2)), np.array([[[0.0, 1.0], [0.0, 1.0]]])

    monkeypatch.setattr("haptisym.verbs.tolerances.heldplane.ClockPlane", Plane)
    wall = hs.environments.kelvin_voigt(1000, "0.4 N*s/m")
    loop = hs.effects.sampled_loop("1 ms", "backward-difference"), hs.effects.shunt(m="40 g", b="0.8 N*s/m")
    found = hs.Scene(wall, loop, hands=(hs.Hand("none"), hs.Hand("some", 1, 1, 1)))
    spans = {"environment.b": (0, 1), "environment.k": (1000, 3000)}
    hows: list[dict[str, Any]] = [{"finest": 2.0**-4, "most": 659}, {"finest": 2.0**-9}]
    for how in hows:
        told = plane_of(found, spans, **how)
        assert (len(told.stable), len(told.unstable), told.left.tolist()) == (0, 0, [[[0, 1], [0, 1]]])
    assert asked == [(2, 2.0**-4, 10), (2, 2.0**-8, 1000)]


@pytest.mark.parametrize("names", ["ab", "ba", "b", "a"])
def test_one_hand_into_which_roots_come_from_infinity_leaves_the_plane_open(
    names: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    q, p = Symbol("q", real=True), Symbol("p", real=True)
    tops = {"a": s + q + p, "b": (q - 2) * s + 1}

    def quotient(scene: Any, hand: Any, symbols: Any) -> Any:
        assert symbols == {q, p}
        ring = Ring.of([*tops.values(), s])
        return ring, ring.convert(tops[hand.name].expand()).numerator, ring.convert(Integer(1)).numerator

    monkeypatch.setattr("haptisym.verbs.tolerances.heldplane.quotient", quotient)
    ranges: Any = {q: (Integer(1), Integer(3)), p: (Integer(1), Integer(2))}
    hands = [hs.Hand(x, 1, 1, 1) for x in names]
    if "b" in names:
        with pytest.raises(UndecidedError, match="infinity"):
            held_plane(lagged(1, 1, 1, 1), hands, ranges)
    else:
        told = held_plane(lagged(1, 1, 1, 1), hands, ranges)
        assert (len(told.stable), len(told.unstable), len(told.left)) == (64, 0, 0)


def test_thresholds_are_sides_of_a_plane_that_move_no_root() -> None:
    """Of two of them all is stable, or nothing; beside a damper its own condition decides, b (b + 10) > 20."""
    loose = lagged(20, 1, 2, 10)
    jnds = "evaluation.jnd.real", "evaluation.jnd.imag"
    ranges = [(Rational(1, 10), Rational(1, 2)), (Rational(1), Rational(4))]
    for k, parts in ((20, (16, 0, 0)), (90, (0, 16, 0))):
        now = lagged(k, 1, 2, 10)
        found = held_rectangles(now, (now.knobs[jnds[0]], now.knobs[jnds[1]]), ranges)
        assert found is not None
        assert [bool(len(x)) for x in found.parts] == [bool(x) for x in parts]
        whole = np.concatenate(found.parts)
        assert [whole[:, i, 0].min() for i in (0, 1)] == pytest.approx([0.1, 1])
        assert [whole[:, i, 1].max() for i in (0, 1)] == pytest.approx([0.5, 4])
    least = -5 + 45**0.5
    own = held_rectangles(loose, (loose.knobs["evaluation.jnd"], loose.knobs["hand.b"]), ranges)
    assert own is not None
    assert (own.kept[:, 1, 0] > least).all()
    assert (own.broken[:, 1, 1] < least).all()
    assert (own.left[:, 1, 0] <= least).all()
    assert (own.left[:, 1, 1] >= least).all()
    assert own.share_left == pytest.approx(1 / 512, rel=1e-9)
