"""Displays in hands drawn at random, with and without a clock: against eigenvalues, winding numbers and samples of boxes."""

from __future__ import annotations

import random
from itertools import product
from typing import Any

import numpy as np
import pytest
from flint import arb
from scipy.linalg import expm
from sympy import exp, lambdify
from windings import winding

import haptisym as hs
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.response import RealFunction
from haptisym.kernel.symbols import s
from haptisym.verbs.stability.answer import _hand
from haptisym.verbs.stability.boxes import Share, _functions, whole_box
from haptisym.verbs.stability.clocked import clocked_roots
from haptisym.verbs.stability.held import held, imposed, roots_in_hand, zeros_of

E, F = hs.environments, hs.effects


def number(draw: random.Random, low: float, high: float) -> str:
    return f"{draw.uniform(low, high):.3g}"


def display(draw: random.Random, *, late: bool) -> hs.Scene:
    environment = E.mass_spring_damper(
        **{
            x: number(draw, low, high)
            for x, low, high in (("m", 0.05, 2), ("b", 0.1, 9), ("k", 5, 300))
            if x == "k" or draw.random() < 0.5
        }
    )
    effects = [F.second_order_lowpass(number(draw, 5, 60), number(draw, 0.2, 1))] if draw.random() < 0.6 else []
    if late:
        effects.append(F.delay(f"{draw.randint(5, 90)} ms"))
    if draw.random() < 0.4:
        effects.append(F.shunt(m=number(draw, 0.05, 0.5), b=number(draw, 0.1, 3)))
    return hs.Scene(environment, tuple(effects))


def range_of(draw: random.Random, low: float, high: float) -> Any:
    """A number, a range, or one from 0 on."""
    a, b = sorted(draw.uniform(low, high) for _ in range(2))
    return draw.choice([f"{a:.3g}", [f"{a:.3g}", f"{b:.3g}"], [0, f"{b:.3g}"]])


@pytest.mark.few(3)
@pytest.mark.parametrize("seed", range(40))
def test_what_is_said_of_a_box_of_hands_holds_for_each_of_them(seed: int) -> None:
    draw = random.Random(seed)
    scene = display(draw, late=seed % 2 == 0)
    hand = hs.Hand(
        "any", range_of(draw, 0.05, 3), range_of(draw, 0.1, 25), [number(draw, 0, 50), number(draw, 51, 300)]
    )
    box = whole_box(scene, hand)
    assert box is not None
    f = lambdify(s, scene.distortion().perceived, "numpy")
    denominator = lambdify(s, scene.distortion().perc.ring.expression(scene.distortion().perc.denominator), "numpy")
    counts = set()
    for n in range(12):
        m, b, k = (
            float(p.value)
            if p.interval is None
            else float(p.interval[0]) + float(p.interval[1] - p.interval[0]) * (draw.random() if n > 1 else n)
            for p in hand.parameters
        )

        def closed(z: Any, m: float = m, b: float = b, k: float = k) -> Any:
            return (f(z) + m * z * z + b * z + k) * denominator(z)

        if m > 0.02:  # the others have roots further out
            counts.add(winding(closed, 400.0))
    counts -= {None}
    if box.share is Share.ALL:
        assert counts <= {0}
    elif box.share is Share.NONE:
        assert 0 not in counts
    elif box.share is None:
        assert box.reason
    else:
        verdicts = {roots_in_hand(scene.distortion().perc, x).number == 0 for x in corners(hand)}
        assert verdicts == {True, False} or box.meeting is not None
    if len(counts) > 1:
        assert box.share in (Share.SOME, None) or (box.share is Share.NONE and 0 not in counts)
    assert whole_box(scene, hs.Hand("one", 1, 2, 3)) is None


def test_a_mass_behind_a_delay_leaves_a_chain_of_roots_in_hands_that_are_lighter_and_in_no_others() -> None:
    """H_perc = (s^2 + s + 5) exp(-s tau): of masses below 1 kg none is stable, with much damping all above that are."""
    scene = hs.Scene(hs.environments.mass_spring_damper(m=1, b=1, k=5), (hs.effects.delay("10 ms"),))
    for low, high, share in (("1/5", "1/2", Share.NONE), ("99/100", "999/1000", Share.NONE), (2, 3, Share.ALL), ("1/5", 3, Share.SOME)):  # fmt: skip
        hand = hs.Hand("any", [low, high], 20, 50)
        box = whole_box(scene, hand)
        assert box is not None
        assert (box.share, box.meeting, box.reason) == (share, None, "")
        assert {roots_in_hand(scene.distortion().perc, x).number == 0 for x in corners(hand)[1:]} == {
            Share.NONE: {False}, Share.ALL: {True}, Share.SOME: {False, True},
        }[share]  # fmt: skip
    open_one = whole_box(scene, hs.Hand("any", ["1/5", 1], 20, 50))  # beside 1 kg the chain comes to the axis
    assert open_one is not None
    assert (open_one.share, bool(open_one.reason)) == (None, True)


def corners(hand: hs.Hand) -> list[hs.Hand]:
    ends = [p.interval or (p.value, p.value) for p in hand.parameters]
    return [hand, *(hs.Hand("corner", *x) for x in product(*ends))]


@pytest.mark.few(7)
@pytest.mark.parametrize("seed", range(40))
def test_held_and_imposed_are_what_contours_wind_around(seed: int) -> None:
    draw = random.Random(seed)
    scene = display(draw, late=seed % 3 > 0)
    hand = hs.Hand("any", number(draw, 0.1, 3), number(draw, 0, 9), number(draw, 0, 300))
    told = held(scene, hand)
    assert told.roots is not None
    perc = scene.distortion().perc
    f = lambdify(s, perc.ring.expression(perc.numerator), "numpy")
    g = lambdify(s, perc.ring.expression(perc.denominator), "numpy")
    m, b, k = (float(p.value) for p in hand.parameters)
    count = winding(lambda z: f(z) + (m * z * z + b * z + k) * g(z), 500.0)
    if count is not None and told.roots.chain is None and not told.on_axis:
        assert told.unstable == count
        assert told.stable is (count == 0)
    poles = imposed(scene)
    right = winding(lambda z: g(z) + 0 * z, 500.0)
    if right is not None and poles.unstable is not None:
        assert poles.stable is (right == 0)
        assert poles.unstable == right


@pytest.mark.parametrize("order", range(4))
@pytest.mark.parametrize("below", range(4))
def test_what_top_and_bottom_share_at_0_is_no_root(order: int, below: int) -> None:
    """s^a (1 - exp(-s))^b (s^2 + 1) (s - 2) over s^c."""
    for late in range(order + 1):
        top = s ** (order - late) * (1 - exp(-s)) ** late * (s**2 + 1) * (s - 2)
        ring = Ring.of([top, exp(-s)])
        found = zeros_of(ring.convert(top.expand()).numerator, ring.convert(s**below).numerator, ring)
        left = max(order - below, 0)
        if found.chain is None:
            assert (found.number, found.right) == (3 + left, 1)
            assert [float(x) for x in found.on_axis] == [0.0] * bool(left) + [1.0]
    ring = Ring.of([s])
    with pytest.raises(UndecidedError, match="resists no motion"):
        zeros_of(ring.constant(0), ring.constant(1), ring)


# With a clock: states of everything that moves, from one sample to the next


def sampled(draw: random.Random) -> tuple[hs.Scene, hs.Hand, Any]:
    """A wall of a spring and a damper by backward differences, held through a handle, a drive train, and the matrix of a period."""
    T = draw.choice([1, 2, 5]) / 1000
    k, b, delay = draw.uniform(50, 4000), draw.choice([0, draw.uniform(0.5, 15)]), draw.randint(0, 2)
    m, damping = draw.uniform(0.02, 0.4), draw.uniform(0.1, 3)
    mh, bh, kh = draw.uniform(0.05, 1), draw.uniform(0.1, 9), draw.uniform(0, 400)
    ck, cb = draw.uniform(2000, 20000), draw.uniform(0.5, 9)
    soft = draw.random() < 0.6
    text = {
        x: repr(y)
        for x, y in zip(
            ("k", "b", "m", "d", "mh", "bh", "kh", "ck", "cb"), (k, b, m, damping, mh, bh, kh, ck, cb), strict=True
        )
    }
    wall = E.kelvin_voigt(text["k"], text["b"]) if b else E.mass_spring_damper(k=text["k"])
    effects = [F.sampled_loop(f"{T * 1000:.0f} ms", "backward-difference", delay), F.shunt(m=text["m"], b=text["d"])]
    if soft:
        effects.append(F.compliance(k=text["ck"], b=text["cb"]))
        A = np.array([
            [0, 1, 0, 0], [-ck / m, -(cb + damping) / m, ck / m, cb / m],
            [0, 0, 0, 1], [ck / mh, cb / mh, -(ck + kh) / mh, -(cb + bh) / mh],
        ])  # fmt: skip
        B = np.array([0, 1 / m, 0, 0])
    else:
        total = m + mh
        A, B = np.array([[0, 1], [-kh / total, -(damping + bh) / total]]), np.array([0, 1 / total])
    n = len(B)
    moved = np.zeros((n + 1, n + 1))
    moved[:n, :n], moved[:n, n] = A, B
    step = expm(moved * T)
    Phi, Gamma = step[:n, :n], step[:n, n]
    size = n + 1 + delay  # states, the position before, the forces on their way
    M = np.zeros((size, size))
    force = np.zeros(size)
    force[0], force[n] = -(k + b / T), b / T
    held_now = force.copy() if not delay else np.eye(size)[size - 1]
    M[:n, :n] = Phi
    M[:n] += np.outer(Gamma, held_now)
    M[n, 0] = 1
    for i in range(delay):
        M[n + 1 + i] = force if i == 0 else np.eye(size)[n + i]
    return hs.Scene(wall, tuple(effects)), hs.Hand("any", text["mh"], text["bh"], text["kh"]), M


@pytest.mark.few(5)
@pytest.mark.parametrize("seed", range(40))
def test_roots_with_a_clock_are_eigenvalues_of_what_a_period_does(seed: int) -> None:
    scene, hand, M = sampled(random.Random(seed))
    sizes = abs(np.linalg.eigvals(M))
    if abs(sizes - 1).min() < 1e-9:
        return
    found = clocked_roots(scene, hand)
    assert (found.number, found.right) == (int((sizes >= 1).sum()),) * 2
    told = held(scene, hand)
    assert (told.unstable, told.stable) == (found.number, found.number == 0)


def test_a_document_holds_all_that_is_known_of_a_hand() -> None:
    own = hs.Hand("mine", "0.2 kg", ["1", "3"], "5 N/m +- 20 %", source="measured")
    for hand in (own, *hs.hands.values(), hs.Hand("plain", 1, 2, 3)):
        told = _hand(hand)
        ranges = {p.key: [float(x) for x in p.interval] for p in hand.parameters if p.interval}
        expected = {"name": hand.name, "m": float(hand.m.value), "b": float(hand.b.value), "k": float(hand.k.value)}
        expected |= ({"ranges": ranges} if ranges else {}) | ({"source": hand.source} if hand.source else {})
        assert told == expected


@pytest.mark.parametrize("seed", range(6))
def test_roots_are_on_the_axis_for_some_hand_of_a_box_where_its_four_functions_are_not_negative(seed: int) -> None:
    """-Im H_perc/omega is a damping of the box, and -Re H_perc some k - m omega^2 of it: by complex numbers."""
    draw = random.Random(seed)
    scene = display(draw, late=seed % 2 == 0)
    ends = [sorted(draw.uniform(0, most) for _ in range(2)) for most in (3, 25, 300)]
    hand = hs.Hand("any", *([f"{a:.6g}", f"{b:.6g}"] for a, b in ends))
    (m, m_high), (b, b_high), (k, k_high) = ([float(x) for x in p.interval or ()] for p in hand.parameters)
    functions = [RealFunction(x.reduced()) for x in _functions(scene.distortion().perc, hand)]
    f = lambdify(s, scene.distortion().perceived, "numpy")
    seen = set()
    for w in np.geomspace(0.3, 200, 150):
        H = f(1j * w)
        true = [-H.imag - b * w, H.imag + b_high * w, m_high * w * w - k - H.real, H.real + k_high - m * w * w]
        told = [float(x.ball(arb(float(w))).mid()) for x in functions]
        clear = [n for n, x in enumerate(true) if abs(x) > 1e-9 * (abs(H) + k_high + m_high * w * w)]
        assert [told[n] > 0 for n in clear] == [true[n] > 0 for n in clear]
        seen |= {(n, true[n] > 0) for n in clear}
    assert len(seen) >= 5
