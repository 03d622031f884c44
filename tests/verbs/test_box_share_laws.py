"""Boxes of hands: what is said of all of them, against a table of what corners may tell, placed zeros and expansions."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator
from fractions import Fraction
from itertools import product
from math import prod
from types import SimpleNamespace
from typing import Any

import pytest
from sympy import Expr, Integer, Rational, exp, lambdify

import haptisym as hs
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.response import on_axis
from haptisym.kernel.rootcount import RootChain, Roots
from haptisym.kernel.symbols import omega, s
from haptisym.verbs.stability import boxes
from haptisym.verbs.stability.boxes import Box, Share

HAND = hs.Hand("any", [1, 2], [3, 4], [5, 6])
SEVEN = ExactNumber(Integer(7))
KINDS: list[tuple[int | None, RootChain | None]] = [
    (0, None), (1, None), (2, None), (None, RootChain.RIGHT), (None, RootChain.NEAR),
]  # fmt: skip


def given(monkeypatch: pytest.MonkeyPatch, kinds: list[Any], meeting: Any, *, outweighed: bool) -> None:
    """The nine hands have roots of these kinds; where roots meet the axis in between is a number, None, or an error."""
    roots = iter(Roots(number, number, chain=chain) for number, chain in kinds)

    def met(*_: Any) -> Any:
        if isinstance(meeting, str):
            raise UndecidedError(meeting)
        return meeting

    monkeypatch.setattr(boxes, "roots_in_hand", lambda *_: next(roots))
    monkeypatch.setattr(boxes, "_meeting", met)
    monkeypatch.setattr(boxes, "_is_outweighed", lambda *_: outweighed)


def known_of(kinds: list[Any], meeting: Any, *, outweighed: bool) -> Box | str:
    """What follows of nine hands and of where roots meet the axis for some hand; a text where it stays open."""
    good = sum(number == 0 for number, _ in kinds)
    if outweighed and {chain for _, chain in kinds} == {RootChain.RIGHT}:
        return Box(Share.NONE)
    if isinstance(meeting, str):
        return Box(Share.SOME) if 0 < good < 9 else meeting
    if meeting is not None:
        return Box(Share.SOME, meeting) if good else "whether any hand of the box is stable"
    if 0 < good < 9:
        return Box(Share.SOME)
    return "come from infinity" if len(set(kinds)) > 1 else Box(Share.ALL if good else Share.NONE)


@pytest.mark.parametrize("meeting", [None, SEVEN, "the axis"])
@pytest.mark.parametrize("outweighed", [False, True])
def test_what_is_said_of_a_box_follows_of_its_corners_and_of_where_roots_meet_the_axis(
    meeting: Any, monkeypatch: pytest.MonkeyPatch, *, outweighed: bool
) -> None:
    own: Any = SimpleNamespace(distortion=lambda: SimpleNamespace(perc=None), effects=())
    monkeypatch.setattr(boxes, "clocks", lambda _: ())
    rows = [[a] * n + [b] * (9 - n) for a, b in product(KINDS, repeat=2) for n in (1, 4, 8, 9)]
    for kinds in rows:
        given(monkeypatch, kinds, meeting, outweighed=outweighed)
        expected = known_of(kinds, meeting, outweighed=outweighed)
        found = boxes.whole_box(own, HAND)
        assert found is not None
        if isinstance(expected, Box):
            assert found == expected, kinds
        else:
            assert (found.share, found.meeting) == (None, None), kinds
            assert expected in found.reason


def test_a_hand_without_ranges_is_no_box_and_the_hands_of_one_are_its_own_and_its_corners() -> None:
    own: Any = SimpleNamespace()
    assert boxes.whole_box(own, hs.Hand("one", 1, 2, 3)) is None
    for m, b, k in product((2, [1, 3]), (0, [0, 5]), (7, [6, 9])):
        hand = hs.Hand("any", m, b, k)
        ends = [x if isinstance(x, list) else [x, x] for x in (m, b, k)]
        first, *others = ([*map(Rational, (x.m.value, x.b.value, x.k.value))] for x in boxes._corners(hand))
        assert first == [hand.m.value, hand.b.value, hand.k.value]
        assert sorted(others) == sorted(map(list, product(*ends)))


@pytest.mark.parametrize("stays", [False, True])
@pytest.mark.parametrize("whole", [True, False, None])
def test_with_a_clock_a_box_is_told_by_its_corners_where_no_root_comes_to_the_circle(
    monkeypatch: pytest.MonkeyPatch, *, whole: bool | None, stays: bool
) -> None:
    asked: dict[str, Any] = {}

    def of(scene: Any, hand: Any, ranges: Any) -> Any:
        asked.update(scene=scene, hand=hand, ranges=ranges)
        return SimpleNamespace(left=lambda: [1] * stays, is_stable=lambda x: (asked.update(at=x), whole)[1])

    own: Any = SimpleNamespace()
    monkeypatch.setattr(boxes, "clocks", lambda _: ("clock",))
    monkeypatch.setattr(boxes, "OnCircle", SimpleNamespace(of=of))
    hand = hs.Hand("any", [1, 2], 3, [5, 6])
    for numbers in ([0] * 9, [1] * 9, [2, 1, 3] * 3, [0] * 8 + [2], [1] + [0] * 8, [0, 1] * 4 + [0]):
        left = iter(numbers)
        monkeypatch.setattr(boxes, "clocked_roots", lambda *_, left=left: Roots(next(left), 0))
        found = boxes.whole_box(own, hand)
        assert found is not None
        if len({n == 0 for n in numbers}) == 2:
            assert found == Box(Share.SOME)
        elif stays or whole is None:
            assert found.share is None
            assert ("come to the unit circle" if stays else "is hidden") in found.reason
        else:
            assert found == Box(Share.ALL if whole else Share.NONE)
            m, _, k = hand.parameters
            assert asked["ranges"] == {m.symbol: (1, 2), k.symbol: (5, 6)}
            assert asked["at"] == {m.symbol: m.value, k.symbol: k.value}
            assert (asked["scene"], asked["hand"]) == (own, hand)


# Which term outweighs all others in all hands


@pytest.mark.parametrize("seed", range(3))
def test_one_delayed_term_outweighs_in_all_hands_where_it_is_the_only_one_and_keeps_its_sign(seed: int) -> None:
    """N + (m s^2 + b s + k) (1 + a x + c y), x and y being delays: of the highest power of s, term by term at each corner."""
    draw, told = random.Random(seed), set()
    x, y = exp(-s), exp(-s * Rational(1, 3))
    ring = Ring.of([s, x, y])
    waves = {(0, 0): ring.one, (1, 0): ring.convert(x), (0, 1): ring.convert(y)}
    powers = [ring.convert(s**n) for n in range(4)]
    for _ in range(30):
        top = {(n, w): draw.randint(-3, 3) for n in range(draw.randint(1, 4)) for w in draw.sample(sorted(waves), 2)}
        below = {(0, 0): 1, (1, 0): draw.choice([-2, -1, 0, 1]), (0, 1): draw.choice([0, 0, 0, 1])}
        upper = sum((powers[n] * waves[w] * ring.convert(Integer(c)) for (n, w), c in top.items()), ring.zero)
        hand = hs.Hand("any", draw.choice([[0, 1], [0, 3], [1, 2]]), draw.choice([0, [0, 2]]), 1)
        signatures: dict[int, set[Any]] = {}
        for own in [hand, *(hs.Hand("corner", *z) for z in product(*map(boxes._ends, hand.parameters)))]:
            whole = dict(top)
            for (n, p), (w, c) in product(zip((2, 1, 0), own.parameters, strict=True), below.items()):
                whole[n, w] = whole.get((n, w), 0) + p.value * c
            degree = max(n for (n, _), c in whole.items() if c)
            late = ((w, c > 0) for (n, w), c in whole.items() if n == degree and c and w != (0, 0))
            signatures.setdefault(degree, set()).add(frozenset(late))
        expected = all(len(z) == 1 and all(len(w) == 1 for w in z) for z in signatures.values())
        lower = sum((waves[w] * ring.convert(Integer(c)) for w, c in below.items()), ring.zero)
        found = boxes._is_outweighed(ring.function(upper.numerator, lower.numerator), hand)
        assert found is expected, (top, below, hand)
        told.add(found)
    assert told == {True, False}


# Where roots meet the axis for some hand: functions with zeros and poles at frequencies that were put there


def placed(draw: random.Random) -> tuple[Expr, list[int], list[int], int]:
    """sign * (omega - z_1) ... over (omega - p_1)^2 ...: with its zeros, its poles, each twice, and its sign."""
    zeros = [draw.randint(0, 6) for _ in range(draw.randint(0, 3))]
    zeros += draw.choice([[], zeros[:1], [9]])
    poles = draw.choice([[], [], [draw.randint(0, 6)], zeros[:1]])
    sign = draw.choice([-1, -1, 1])
    half = Rational(1, 2)
    top = sign * prod((omega - half * z for z in zeros), start=Integer(1))
    return top / prod(((omega - half * p) ** 2 for p in poles), start=Integer(1)), zeros, poles, sign


def sign_at(zeros: list[int], poles: list[int], sign: int, at: Fraction) -> int:
    """Of such a function in between; at a zero, and at a pole where it changes sign, 0."""
    order = zeros.count(2 * at) - 2 * poles.count(2 * at)  # type: ignore[arg-type]
    if order > 0 or order % 2:
        return 0
    return -sign if sum(Fraction(z, 2) > at for z in zeros) % 2 else sign


def first_meeting(rows: list[Any]) -> Fraction | None:
    """By one place after another, and by the middle of what follows it."""
    marks = sorted({Fraction(0), *(Fraction(z, 2) for _, zeros, poles, _ in rows for z in [*zeros, *poles])})

    def passes(at: Fraction) -> bool:
        return all(sign_at(zeros, poles, sign, at) >= 0 for _, zeros, poles, sign in rows)

    for mark, following in zip(marks, [*marks[1:], marks[-1] + 2], strict=True):
        has_pole = any(zeros.count(2 * mark) < 2 * poles.count(2 * mark) for _, zeros, poles, _ in rows)
        if passes((mark + following) / 2) or (passes(mark) and not has_pole):
            return mark
    return None


@pytest.mark.parametrize("seed", range(6))
def test_the_lowest_frequency_at_which_no_function_is_negative_is_told(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    draw, told = random.Random(seed), set()
    axis = Ring().axis
    own: Any = None
    for _ in range(25):
        rows = [placed(draw) for _ in range(draw.choice([1, 2, 2, 3]))]
        functions = [axis.function(*map(poly_of(axis), row[0].as_numer_denom())) for row in rows]
        monkeypatch.setattr(boxes, "_functions", lambda *_, functions=functions: functions)
        if not any(sign < 0 for *_, sign in rows):
            with pytest.raises(UndecidedError, match="at ever higher frequencies"):
                boxes._meeting(own, HAND)
            continue
        expected, found = first_meeting(rows), boxes._meeting(own, HAND)
        assert (found is None) is (expected is None), rows
        assert found is None or expected is None or float(found) == pytest.approx(float(expected), abs=1e-12), rows
        told.add(expected)
    assert len(told) > 3


def poly_of(axis: Any) -> Callable[[Expr], Any]:
    return lambda x: axis.convert(x.expand()).numerator


def touching() -> Iterator[tuple[list[Expr], str]]:
    """Real parts of these: cos omega - 1 <= 0 touches 0 for ever; (omega^2 - 4)^2 (cos omega - 2) does so once, at 2."""
    yield [exp(-s) - 1, Integer(1)], "at ever higher frequencies"
    yield [(s**2 + 4) ** 2 * (exp(-s) - 2)], ""


def test_where_functions_touch_0_for_ever_it_is_open_and_a_touch_alone_is_a_meeting(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    own: Any = None
    for rows, reason in touching():
        ring = Ring.of([exp(-s)])
        functions = [on_axis(ring.convert(x.expand())).raw_real for x in rows]
        monkeypatch.setattr(boxes, "_functions", lambda *_, functions=functions: functions)
        if reason:
            with pytest.raises(UndecidedError, match=reason):
                boxes._meeting(own, HAND)
        else:
            found = boxes._meeting(own, HAND)
            assert found is not None
            assert float(found) == 2
    monkeypatch.setattr(boxes, "chart", lambda *_: SimpleNamespace(undecided=(1,), where=lambda _: []))
    with pytest.raises(UndecidedError, match="touches the boundary"):
        boxes._meeting(own, HAND)


@pytest.mark.parametrize("seed", range(3))
def test_four_functions_tell_how_much_is_left_of_the_ranges_of_damping_and_of_stiffness(seed: int) -> None:
    """-Im H/omega - b and b_high + Im H/omega times omega; m_high omega^2 - k - Re H and k_high - m omega^2 + Re H."""
    draw = random.Random(seed)
    a = [draw.randint(-9, 9) for _ in range(3)]
    H = a[0] * s**2 + a[1] * s + a[2] + draw.randint(1, 9) / (s + draw.randint(1, 4))
    ends = [sorted(draw.sample(range(9), 2)) for _ in range(3)]
    hand = hs.Hand("any", ends[0], ends[1], ends[2])
    (m, m_high), (b, b_high), (k, k_high) = ends
    functions = boxes._functions(Ring.of([s]).convert(H), hand)
    assert len(functions) == 4
    for w in (0.25, 1.0, 3.5):
        at = complex(lambdify(s, H)(1j * w))
        true = [-at.imag - b * w, at.imag + b_high * w, m_high * w**2 - k - at.real, k_high - m * w**2 + at.real]
        for f, value in zip(functions, true, strict=True):
            assert float(f.expression().subs(omega, Rational(w))) == pytest.approx(value, rel=1e-12, abs=1e-9)
