"""Values that a hand bears and values without a scene: windows put together, Routh's rule, poles placed by hand."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from math import inf
from random import Random
from types import SimpleNamespace
from typing import Any

import mpmath
import pytest
from flint import acb, arb
from sympy import Integer, Rational, pi, sqrt

import haptisym as hs
from haptisym.judge.criteria import noticed
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import ExactNumber, SquareRoot
from haptisym.verbs.require import held
from haptisym.verbs.require.existing import allowed, missing
from haptisym.verbs.require.feasible import Binding, Kind
from haptisym.verbs.require.freeparameter import Domain
from haptisym.verbs.require.held import _is_clear, _meets, _on_axis, _wider, window_of, with_hands
from haptisym.verbs.require.verdicts import Turn
from haptisym.verbs.stability.curves import Gap, Meeting, Meetings
from haptisym.verbs.stability.loops import Loop

REAL, _ = noticed(hs.Threshold())
FREE: Any = SimpleNamespace(value=Integer(0))


def number(x: Any) -> ExactNumber:
    return ExactNumber(Rational(x))


def window(found: Any, low: float | None, high: float | None, *gaps: Gap) -> Meetings:
    """Between two numbers, None or infinite for no bound."""
    a, b = (None if x is None or abs(x) == inf else Integer(x) for x in (low, high))
    return Meetings(tuple(found), a, b, gaps)


ROWS = [Meeting(number(x), None if x == 3 else number(7)) for x in range(-9, 10)]


def inside(low: float | None, high: float | None) -> tuple[Meeting, ...]:
    """Of the rows."""
    return tuple(x for x in ROWS if (low is None or low <= float(x.value)) and (high is None or float(x.value) <= high))


def ends(x: Meetings) -> tuple[Any, Any]:
    return x.above, x.below


class Growing:
    """Windows each four times as wide as the one before, without bound on some sides, with a gap in the first; one may fail."""

    def __init__(self, pick: Random) -> None:
        self.critical = sorted(pick.sample(range(-300000, 300000), 4) + pick.sample(range(-40, 40), 4))
        self.known = pick.choice([None, -inf]), pick.choice([None, inf])
        self.low, self.high = pick.choice([None, -2, -200, -(4**5), 3]), pick.choice([None, 5, 63, 4**4, 10**5])
        self.gapped, self.broken = pick.choice([-1, -1, 0, 2]), pick.choice([None, None, 1, 3])
        self.given = list[int]()

    def window(self, i: int) -> Meetings:
        a, b = (self.known[0] or -(4**i)), (self.known[1] or 4**i)
        gaps = (Gap(number(3), number(4)),) if i <= self.gapped else ()
        return window((Meeting(number(x), number(1)) for x in self.critical if a <= x <= b), a, b, *gaps)

    def meetings(self, _: Any, own: Any) -> Iterator[Meetings]:
        assert own == FREE.value
        for i in range(20):
            if i == self.broken:
                raise UndecidedError("they are many")
            self.given.append(i)
            yield self.window(i)

    def is_enough(self, i: int) -> bool:
        """Whether a window reaches as far as is asked, and no gap is left in there."""
        low = self.known[0] is not None or (self.low is not None and -(4**i) <= self.low)
        high = self.known[1] is not None or (self.high is not None and 4**i >= self.high)
        meets = (self.high is None or self.high > 3) and (self.low is None or self.low < 4)
        return low and high and not (meets and i <= self.gapped)


@pytest.mark.parametrize("seed", range(12))
def test_windows_grow_until_they_hold_all_that_is_asked_about_and_eight_at_most(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    pick = Random(seed)
    for _ in range(8):
        given = Growing(pick)
        monkeypatch.setattr(held, "meetings", given.meetings)
        asked: Any = Domain(*(None if x is None else Integer(x) for x in (given.low, given.high)))  # type: ignore[arg-type]
        found = window_of(SimpleNamespace(), FREE, asked)  # type: ignore[arg-type]
        last = next((i for i in range(8) if i == given.broken or given.is_enough(i)), 7)
        failed = last == given.broken
        last -= failed
        assert given.given == list(range(last + 1))
        true = given.window(last)
        assert [float(x.value) for x in found.found] == [float(x.value) for x in true.found]
        gaps = [*true.gaps]
        if failed:
            gaps += [] if true.above is None else [Gap(None, number(true.above), "they are many")]
            gaps += [] if true.below is None else [Gap(number(true.below), None, "they are many")]
        assert ends(found) == ((None, None) if failed else ends(true))
        assert [*found.gaps] == gaps


def test_where_no_window_is_known_nothing_is() -> None:
    def none(*_: Any) -> Iterator[Meetings]:
        raise UndecidedError("they are many")
        yield

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(held, "meetings", none)
        with pytest.raises(UndecidedError, match="they are many"):
            window_of(SimpleNamespace(), FREE, Domain(None, None))  # type: ignore[arg-type]
        patched.setattr(held, "meetings", lambda *_: iter(()))
        with pytest.raises(UndecidedError, match="where roots meet the imaginary axis"):
            window_of(SimpleNamespace(), FREE, Domain(None, None))  # type: ignore[arg-type]


@pytest.mark.parametrize("seed", range(6))
def test_two_windows_about_one_value_are_as_wide_as_the_wider_on_each_side(seed: int) -> None:
    pick = Random(seed)
    for _ in range(8):
        (a, b), (c, d) = (
            (pick.choice([None, -pick.randint(1, 9)]), pick.choice([None, pick.randint(1, 9)])) for _ in range(2)
        )
        found = _wider(
            window(inside(a, b), a, b, Gap(number(0), None)), window(inside(c, d), c, d, Gap(number(1), None))
        )
        low = None if a is None or c is None else min(a, c)
        high = None if b is None or d is None else max(b, d)
        assert ends(found) == (low, high)
        assert sorted(float(x.value) for x in found.found) == sorted(
            float(x.value) for x in {*inside(a, b), *inside(c, d)}
        )
        assert [*found.gaps] == [Gap(number(1), None)]


def test_a_gap_meets_what_is_asked_about_in_more_than_an_end_or_not_at_all() -> None:
    sides = [(None, -2, -1, 0, 1), (None, -1, 0, 1, 2)]
    for low, high, start, end in product(*sides, *sides):
        if (None not in (low, high) and low >= high) or (None not in (start, end) and start >= end):  # type: ignore[operator]
            continue
        gap = Gap(None if low is None else number(low), None if high is None else number(high))
        asked = Domain(*(None if x is None else Integer(x) for x in (start, end)))  # type: ignore[arg-type]
        below, above = (
            max(-inf if x is None else x for x in (low, start)),
            min(inf if x is None else x for x in (high, end)),
        )
        assert _meets(gap, asked) is (below < above)


# Routh's rule, and the axis


@pytest.mark.parametrize("seed", range(4))
def test_behind_a_lag_the_hand_bears_what_rouths_rule_says(seed: int) -> None:
    """m s^3 + (b + m w) s^2 + (k + b w) s + w (k + K) over s + w: stable for (b + m w)(k + b w) > m w (k + K)."""
    pick = Random(seed)
    m, b, k, w, K = (
        pick.randint(1, 5),
        pick.randint(1, 9),
        pick.randint(0, 90),
        pick.randint(2, 60),
        pick.randint(100, 900),
    )
    scene = hs.Scene(hs.environments.mass_spring_damper(k=K), (hs.effects.first_order_lag(w),), (0, 5))
    hand = hs.Hand("own", m=m, b=b, k=k)
    stiffest = Rational((b + m * w) * (k + b * w), m * w) - k
    r = hs.require(scene, "environment.k", (1, 10**6), that="stable", hand=hand)
    [span] = r.feasible
    assert (span.low.value, span.low.closed, span.high.closed) == (number(1), True, False)
    assert span.high.value is not None
    assert span.high.value.digits(25) == ExactNumber(stiffest).digits(25)
    [binding] = span.high.bindings
    assert binding.omega is not None
    assert float(binding.omega) == pytest.approx(((k + b * w) / m) ** 0.5)
    assert (binding.kind.value, binding.criterion.kept) == ("axis", "stable in own")
    damped = hs.require(scene, "hand.b", (0, 10**5), that="stable", hand=hand)
    p = k + m * w * w
    least = (-p + (p * p + 4 * w * m * w * K) ** 0.5) / (2 * w)  # w b^2 + (k + m w^2) b - m w K
    [span] = damped.feasible
    assert span.low.value is not None
    assert float(span.low.value) == pytest.approx(least, rel=1e-12)
    assert not span.low.closed
    assert damped.certified


def test_a_hand_is_the_one_that_is_given_or_those_of_the_scene() -> None:
    own = hs.Hand("own", m=1)
    scene = hs.Scene(hs.environments.mass_spring_damper(k=100), (), (0, 5), hands=(own, hs.Hand("other", m=2)))
    assert with_hands(scene, None) is scene
    assert [x.name for x in with_hands(scene, "other").hands] == ["other"]
    assert [x.m.value for x in with_hands(scene, hs.Hand("third", m=3)).hands] == [3]
    with pytest.raises(hs.SceneError, match="asked of it in a hand"):
        with_hands(hs.Scene(hs.environments.mass_spring_damper(k=100), ()), None)


@pytest.mark.parametrize("free", ["environment.k", "k_alpha", "hand.m", "hand.b"])
def test_the_characteristic_function_on_the_axis_is_that_of_the_loop(free: str) -> None:
    """(k + a s^(1/3)) exp(-s/10) + m s^2 + b s + 50, up to a constant."""
    values = {"environment.k": Rational(30), "k_alpha": Rational(7), "hand.m": Rational(2), "hand.b": Rational(3)}
    pot = hs.environments.spring_pot(7, "1/3", k=30)
    hand = hs.Hand("own", m=2, b=3, k=50)
    scene = hs.Scene(pot, (hs.effects.delay("0.1"),), (0, 5), hands=(hand,))
    knob = scene.knobs[free]
    loop = Loop.of(scene, hand, knob)
    ratios = []
    for value, w in ((values[free], Rational(2)), (values[free] * 2, Rational(5, 3)), (values[free] / 2, Rational(9))):
        own = {**values, free: value}
        k, a, m, b = (mpmath.mpf(own[x].p) / own[x].q for x in values)
        at = 1j * mpmath.mpf(w.p) / w.q
        true = (k + a * mpmath.cbrt(at)) * mpmath.exp(-at / 10) + m * at**2 + b * at + 50
        found = _on_axis(loop, ExactNumber(value), ExactNumber(w))
        ratios.append(complex(float(found.real), float(found.imag)) / complex(true))
    assert ratios == pytest.approx([ratios[0]] * 3, rel=1e-12)
    assert abs(ratios[0]) > 0


def test_a_turn_is_clear_where_nothing_turns_and_no_root_is_on_the_axis_at_any_of_its_frequencies(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(
        held, "_on_axis", lambda loop, value, omega: {1: acb(2), 2: acb(3), 0: acb(arb(0, 1))}[int(float(omega))]
    )
    for turns in (False, True, None):
        for places in ((1,), (1, 2), (2, 0), (0,), (None,), (1, None), ()):
            turn = Turn(number(5), tuple(Binding(REAL, None if x is None else number(x), Kind.AXIS) for x in places))
            clear = turns is False and None not in places and 0 not in places
            assert _is_clear(SimpleNamespace(turns=turns), turn) is clear  # type: ignore[arg-type]


# Values without a scene


@pytest.mark.parametrize("seed", range(8))
def test_values_that_divide_by_0_or_leave_nothing_to_feel_are_all_missing_and_no_others(seed: int) -> None:
    """(q - a)(q + b)(q^2 - d) before all of the environment, q - c below the line; q + s and q - e before a part are no such."""
    pick = Random(seed)
    a, b, c, e = (Rational(x, pick.choice([1, 2])) for x in pick.sample(range(3, 30, 2), 4))
    d, turn = pick.choice([2, 3, 5]), pick.choice([0, 1])
    formula = f"(q - {a})*(q + {b})*(q^2 - {d})*(s*(q - {e}) + q + 7)/(s + q)"
    lead = hs.effects.series(
        f"1 + s/(q - {c})" + ("/(q - v)" if turn else ""), parameters={"q": "1/7", **({"v": "3 Hz"} if turn else {})}
    )
    scene = hs.Scene(
        hs.environments.expression(formula, parameters={"q": "1/7"}), (hs.effects.first_order_lag(40),), (0, 9)
    )
    knob = scene.knobs["environment.q"]
    found = sorted(map(float, missing(scene, knob)))
    assert found == pytest.approx(sorted([float(a), -float(b), d**0.5, -(d**0.5)]), rel=1e-14)
    assert not allowed(scene, knob, a)
    assert allowed(scene, knob, e)
    other = hs.Scene(hs.environments.kelvin_voigt(90, 3), (lead,), (0, 9))
    below = sorted(map(float, missing(other, other.knobs["q"])))
    assert below == pytest.approx(sorted([float(c), *([6 * float(pi)] if turn else [])]), rel=1e-14)
    assert missing(scene, scene.knobs["omega_c"]) == []
    assert any(isinstance(x, SquareRoot) or float(x) == float(sqrt(d)) for x in missing(scene, knob))
