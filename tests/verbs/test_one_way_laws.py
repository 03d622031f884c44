"""Where roots cross one way alone, and how far a clock's number is followed: tables of what may be known on the way."""

from __future__ import annotations

from fractions import Fraction
from itertools import product
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from flint import arb
from sympy import Integer, Rational, Symbol, exp, lambdify

from haptisym.judge.peaks import ValueAt
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.far import Far, Sense
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.response import RealFunction
from haptisym.kernel.symbols import omega, s
from haptisym.model.parameters import Rule
from haptisym.verbs.stability import clockrange, tendency
from haptisym.verbs.stability.clockcritical import Passage
from haptisym.verbs.stability.curves import Curve, curve_of
from haptisym.verbs.stability.loops import Loop
from haptisym.verbs.stability.tendency import Tendency, _Settled

q = Symbol("q", positive=True)


def exact(x: Any) -> ExactNumber:
    return ExactNumber(Rational(x))


def test_of_a_delay_all_beyond_one_have_roots_if_more_have_come_than_gone_there_or_for_ever_before(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked: list[Any] = []
    loop: Any = SimpleNamespace(turns=True)
    for still, last, come, low in product((False, True), (None, 2, 5), (-1, 0, 1), (None, 2, 4, 5, 9)):

        def count(delay: Any, come: int = come) -> int:
            asked.append(delay)
            return come

        found = SimpleNamespace(is_still=still, unstable_from=last and Rational(last), come=count)
        monkeypatch.setattr(tendency, "Switches", SimpleNamespace(of=lambda _, found=found: found))
        told = Tendency(loop).everywhere(None if low is None else exact(low), None)
        assert told is (low is not None and still and ((last is not None and low >= last) or come > 0))

    def fails(_: Any) -> Any:
        raise UndecidedError("why")

    monkeypatch.setattr(tendency, "Switches", SimpleNamespace(of=fails))
    assert Tendency(loop).everywhere(exact(3), None) is False


@pytest.mark.parametrize("sense", [-1, 1])
def test_of_a_number_one_end_tells_all_if_from_there_on_roots_only_come(
    sense: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """From the low end on if they come as a positive number grows, or as a negative one falls; with none known in between."""
    asked: list[Any] = []
    loop: Any = SimpleNamespace(turns=False)
    ends = (None, -5, -2, 0, 3, 7)
    for known, has_some in product(((), (5,), (-3,), (3,), (-2, 7)), (False, True)):
        settled = _Settled(sense, *(None,) * 2, tuple(map(exact, known)))  # type: ignore[arg-type]
        monkeypatch.setattr(Tendency, "_settled", settled)

        def has(_: Any, start: Any, found: Any, told: bool = has_some) -> bool:  # noqa: FBT001
            asked.append((start, found))
            return told

        monkeypatch.setattr(Tendency, "_has_some_beyond", has)
        for low, high in product(ends, ends):
            if low is not None and high is not None and low >= high:
                continue
            asked.clear()
            found = Tendency(loop).everywhere(*(None if x is None else exact(x) for x in (low, high)))
            side = 1 if low is not None and low >= 0 else -1 if high is not None and high <= 0 else 0
            inside = any((low is None or low < x) and (high is None or x < high) for x in known)
            start = low if side * sense > 0 else high
            is_asked = bool(side) and not inside and start is not None
            assert asked == ([(exact(start), settled)] if is_asked else [])
            assert found is (is_asked and has_some)
    monkeypatch.setattr(Tendency, "_settled", None)
    assert Tendency(loop).everywhere(exact(1), exact(2)) is False


def test_at_a_rational_end_roots_are_counted_and_at_a_critical_one_its_own_tell(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """u = 5 - (omega - 2)^2, v = omega - 2: at 2 rad/s the value 5, with a rate of 3."""
    axis = Ring().axis
    own, zero = axis.convert(5 - (omega - 2) ** 2), axis.convert(omega - 2)
    for right, sense, rate in product((None, 0, 2), (-1, 1), (-3, 0, 3)):
        loop: Any = SimpleNamespace(at=lambda x, right=right: SimpleNamespace(right=right if x == 5 else 7))
        curve = Curve(zero, own, own)
        settled = _Settled(sense, axis.convert(Integer(rate) + 0 * omega), curve, ())
        told = Tendency(loop)._has_some_beyond
        assert told(exact(5), settled) is bool(right)
        at_2, at_3 = (ValueAt(RealFunction(own), exact(n)) for n in (2, 3))
        assert told(at_2, settled) is (sense * rate > 0)
        assert told(at_3, settled) is False  # there the condition is not 0
        other = ValueAt(RealFunction(own + axis.convert(Integer(1))), exact(2))
        assert told(other, settled) is False  # another value
        assert told(SimpleNamespace(), settled) is False  # type: ignore[arg-type]


def test_a_phase_is_settled_where_its_rate_keeps_one_sign_before_delays_turn_too_often(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    reaches: list[Any] = []
    met = (SimpleNamespace(value=exact(4)),)

    def meetings(reach: Any) -> Any:
        reaches.append(reach)
        return met

    monkeypatch.setattr(tendency, "_rate", lambda _: "rate")
    monkeypatch.setattr(tendency, "Characteristic", lambda _: SimpleNamespace(at_0=lambda: [exact(1)]))
    monkeypatch.setattr(tendency, "from_infinity", lambda _: (SimpleNamespace(value=exact(9)),))
    for powers, there, zero, sense, radius, lags in product(
        (1, 2, 3),
        (False, True),
        (False, True),
        Sense,
        (Rational(1, 2), Rational(100)),
        ((), (Rational(4),), (Rational(5), Rational(1))),
    ):
        curve = SimpleNamespace(condition=SimpleNamespace(is_zero=zero), meetings=meetings) if there else None
        monkeypatch.setattr(tendency, "curve_of", lambda _, curve=curve: curve)
        monkeypatch.setattr(tendency, "far", lambda _, sense=sense, radius=radius: Far(sense, radius))
        loop: Any = SimpleNamespace(powers=[0] * powers, ring=SimpleNamespace(lags=lags))
        found = Tendency(loop)._settled
        late = any(radius * x > 400 for x in lags)
        if powers != 2 or not there or zero or sense not in (Sense.POSITIVE, Sense.NEGATIVE) or late:
            assert found is None
            continue
        assert found == _Settled(sense.value, "rate", curve, (exact(1), exact(4), exact(9)))  # type: ignore[arg-type]
        assert reaches[-1] == max(radius, 1)


def test_the_rate_of_a_phase_is_that_of_u_less_j_v() -> None:
    """Of u = omega^2 - 3, v = 2 omega + 1: (u' v - v' u)/..., of which the sign is that of the phase's slope, turned about."""
    loop = Loop(
        ring := Ring.of([s**2 + q * (s + 2), exp(-s)]),
        ring.convert(s**2 + 3 * s + q * (s + 2) * exp(-s)).numerator,
        ring.constant(1),
        q,
    )
    curve = curve_of(loop)
    assert curve is not None
    rate = tendency._rate(curve)
    f = lambdify(s, -(s**2 + 3 * s) / ((s + 2) * exp(-s)), "numpy")
    for w in np.linspace(0.3, 12, 40):
        slope = np.angle(f(1j * (w + 1e-6)) / f(1j * (w - 1e-6))) / 2e-6
        ball = RealFunction(rate).ball(arb(float(w)))
        assert abs(slope) < 1e-3 or (float(ball.mid()) > 0) == (slope > 0), w


# How far a clock's number is followed


def passage(value: int, below: int, above: int) -> Passage:
    return Passage(exact(value), exact(0), below, above)


PLACES, COUNTS = [-6, -1, 1, 3, 7, 11, 20], [5, 4, 3, 2, 0, 2, 4, 6]


def walked(monkeypatch: pytest.MonkeyPatch) -> Any:
    """A loop whose count changes at places, each known to a tenth beyond; from -10 and up to 25 nothing more is found."""

    def half(walk: Any, side: int) -> Any:
        ahead = [n for n, x in enumerate(PLACES) if (x - walk.start) * side > 0]
        if not ahead:
            return None, Fraction(25 if side > 0 else -10)
        n = ahead[0] if side > 0 else ahead[-1]
        assert walk.home == COUNTS[sum(x < walk.start for x in PLACES)]
        return passage(PLACES[n], COUNTS[n], COUNTS[n + 1]), PLACES[n] + Fraction(side, 10)

    loop: Any = SimpleNamespace(is_fixed=False, count=lambda value: (COUNTS[sum(bool(x < value) for x in PLACES)], 0))
    monkeypatch.setattr(clockrange, "opened", lambda *_: loop)
    monkeypatch.setattr(clockrange, "start_of", lambda _, value: value)
    monkeypatch.setattr(clockrange, "in_half_the_time", half)
    monkeypatch.setattr(clockrange, "is_held", lambda *_: False)
    monkeypatch.setattr(clockrange, "inverted", lambda *_: None)
    return loop


FREE: Any = SimpleNamespace(value=Rational(5), rule=Rule.ANY)


@pytest.mark.parametrize(("low", "high"), [(None, None), (2, 9), (-7, 30), (4, 6), (-1, 12)])
def test_changes_are_followed_on_either_side_until_one_lies_beyond_what_is_asked_about(
    low: int | None, high: int | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    loop = walked(monkeypatch)
    ends = tuple(None if x is None else Rational(x) for x in (low, high))
    own, found = clockrange.passages_in(None, None, FREE, ends)  # type: ignore[arg-type]
    assert (own,) == (loop,)
    expected, reached = [], []
    for side, last in ((-1, low), (1, high)):
        at: Any = Rational(25 if side > 0 else -10)
        for x in sorted((x for x in PLACES if (x - 5) * side > 0), key=lambda x: abs(x - 5)):
            n = PLACES.index(x)
            expected.append(passage(x, COUNTS[n], COUNTS[n + 1]))
            if last is not None and (x + Rational(side, 10) - last) * side > 0:
                at = x + Rational(side, 10)
                break
        reached.append(at)
    assert [*found.found] == expected
    assert [found.low, found.high] == reached


def test_so_many_changes_are_followed_on_either_side_and_none_where_roots_lie_on_the_circle_now(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    loop, both = walked(monkeypatch), (None, None)
    monkeypatch.setattr(clockrange, "_MOST_PASSAGES", 2)
    _, few = clockrange.passages_in(None, None, FREE, both)  # type: ignore[arg-type]
    assert [int(x.value.value) for x in few.found] == [3, 1, 7, 11]  # type: ignore[attr-defined]
    assert (few.low, few.high) == (Fraction(9, 10), Fraction(111, 10))
    loop.count = lambda _: (3, 1)
    with pytest.raises(UndecidedError, match="on the unit circle now"):
        clockrange.passages_in(None, None, FREE, both)  # type: ignore[arg-type]
    loop.is_fixed = True
    assert clockrange.passages_in(None, None, FREE, both) == (loop, clockrange.Passages(()))  # type: ignore[arg-type]
