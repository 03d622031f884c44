"""What tells a cell of one number, as to whether every passive hand may hold the display: signs, poles and single verdicts."""

from __future__ import annotations

from itertools import product
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from sympy import Expr, Integer, Rational, Symbol, exp, sqrt

from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import LimitError, SceneError, UndecidedError
from haptisym.kernel.reals import ExactNumber, SquareRoot
from haptisym.kernel.symbols import s
from haptisym.verbs.require import passivecells
from haptisym.verbs.require.energy import Energy
from haptisym.verbs.require.exactsigns import ExactSign
from haptisym.verbs.require.feasible import Kind
from haptisym.verbs.require.passivecells import _Cell, _Search

Q = Symbol("q", real=True)


def search(**known: Any) -> Any:
    found: Any = _Search.__new__(_Search)
    found.free = SimpleNamespace(symbol=Q, path="q")
    found.gone = []
    found.__dict__.update(known)
    return found


def test_a_cell_is_told_by_the_first_thing_that_settles_it() -> None:
    """Active near rest or far out, or at one frequency; not clear; poles that move, or on the right; not steady; one verdict."""
    low, high = Rational(1), Rational(3)
    yes_no = (True, False)
    rows = product((None, 2, 0), yes_no, yes_no, yes_no, yes_no, yes_no, (True, False, None))
    for ends, active, clear, poles, right, steady, holds in rows:
        at = {None: [], 2: [ExactSign(2 - Q * 0 - Q, Q)], 0: [ExactSign(-Q * Q + 9, Q), ExactSign(1 - Q, Q)]}[ends]
        asked: list[Any] = []
        form = SimpleNamespace(active_at=lambda q, x=active: 1.0 if x else None, clear=lambda q, x=clear: x)
        own = search(_ends=at, energy=form, _turn=lambda a, b: ("turn", a, b))
        own._has_steady_poles = lambda a, b, x=poles: x
        own._is_steady = lambda a, b, x=steady: x
        own._has_no_pole_right = lambda x, told=right, asked=asked: (asked.append(x), told)[1]
        own._holds = lambda a, b, x=holds: x
        found = own._told(low, high)
        if ends == 0:  # 1 - q < 0 between 1 and 3, and 0 at 1
            assert found == _Cell(low, high, verdict=False, alone=(low,))
        elif active:
            assert found == _Cell(low, high, verdict=False)
        elif not clear:
            assert found == _Cell(low, high, None, ("turn", low, high))  # type: ignore[arg-type]
        elif not poles:
            assert found == _Cell(low, high, None)
        elif not right:
            assert found == _Cell(low, high, None, is_last=True)
            assert asked == [2]
        elif not steady:
            assert found == _Cell(low, high, None)
        else:
            assert found == _Cell(low, high, holds, alone=(low, high) if holds is False else ())


def test_values_beyond_an_end_are_active_where_a_sign_is_negative_there_or_else_as_the_last_cell() -> None:
    for lead, offset, side, here, told in product((-1, 1), (0, 5), (-1, 1), (True, False, None), (True, False, None)):
        form = lead * (Q - offset)
        own = search(
            _ends=[ExactSign(Q**2 + 1, Q), ExactSign(form, Q)], energy=SimpleNamespace(beyond=lambda *_, x=told: x)
        )
        end = Rational(1) * offset
        negative = lead * side < 0
        assert own.beyond(end, side, here=here) is (False if negative else told if told == here else None)


def test_a_value_is_active_where_one_of_the_signs_is_negative_and_not_where_all_are_0_or_more() -> None:
    own = search(_ends=[ExactSign(Q - 1, Q), ExactSign(3 - Q, Q)])
    assert [own.is_active(Integer(x)) for x in range(5)] == [True, False, False, False, True]
    assert not search(_ends=[]).is_active(Integer(0))


def test_a_value_is_told_where_it_is_active_or_clear() -> None:
    for active, clear in product((None, 0.0, 2.0), (True, False)):
        asked: list[Any] = []
        form = SimpleNamespace()
        form.active_at = lambda q, x=active, asked=asked: (asked.append(q), x)[1]
        form.clear = lambda q, x=clear, asked=asked: (asked.append(q), x)[1]
        own = search(energy=form)
        assert own.is_told(Rational(1, 3)) is (active is not None or clear)
        assert set(asked) == {(1 / 3, 1 / 3)}


def test_one_verdict_is_asked_for_inside_where_the_scene_exists(monkeypatch: pytest.MonkeyPatch) -> None:
    """At a half, else a third, a quarter, ... of the way; of values that are no fractions none is meant."""
    monkeypatch.setattr(passivecells, "passivity", lambda scene: SimpleNamespace(holds=scene))
    put = SimpleNamespace(symbol=Q, put=lambda scene, value: value)
    for gone, expected in (
        ([], 3), ([ExactNumber(Integer(3))], Rational(7, 3)), ([ExactNumber(Integer(3)), ExactNumber(Rational(7, 3))], 2),
        ([SquareRoot(ExactNumber(Integer(9)))], 3), ([ExactNumber(Integer(2))], 3),
    ):  # fmt: skip
        own = search(gone=gone, free=put, scene=None)
        assert own._holds(Rational(1), Rational(5)) == expected
    assert search(free=put, scene=None).holds_at(Rational(4)) == 4
    for error in (LimitError("over"), SceneError("none"), UndecidedError("open")):

        def refused(*_: Any, error: Exception = error) -> Any:
            raise error

        own = search(free=SimpleNamespace(symbol=Q, put=refused), scene=None)
        assert own.holds_at(Rational(4)) is None


def of(top: Expr, bottom: Expr, **known: Any) -> Any:
    """A search about one dynamics."""
    ring = Ring.of([top, bottom, Q, s])
    H = ring.convert(top) / ring.convert(bottom)
    return search(H=H, ring=ring, energy=Energy.of(H, Q), **known)


@pytest.mark.parametrize(
    ("bottom", "span", "steady"),
    [
        (s + Q, (1, 3), True), (Q * s + 1, (1, 3), True), (Q * s + 1, (-1, 1), False),
        (s**2 + Q * s + 4, (1, 3), True), (s**2 + Q * s + 4, (-1, 3), False), (s - Q, (1, 3), True),
        (s + Q + exp(-s) / 2, (1, 3), True),
    ],
)  # fmt: skip
def test_poles_are_steady_where_none_comes_to_the_axis_nor_from_infinity(
    bottom: Expr, span: Any, *, steady: bool
) -> None:
    own = of(s**2 + exp(-s), bottom)
    assert own._has_steady_poles(*map(Rational, span)) is steady


@pytest.mark.parametrize(
    ("bottom", "none"), [(s + Q, True), (s - Q, False), ((s + 1) * (s - Q), False), (Integer(3), True)]
)
def test_a_pole_on_the_right_is_seen(bottom: Expr, *, none: bool) -> None:
    assert of(s**2 + exp(-s), bottom.expand())._has_no_pole_right(Rational(2)) is none


@pytest.mark.parametrize(
    ("top", "span", "steady"),
    [
        (s**2 + s + Q, (1, 3), True), (s**2 + s + Q, (-1, 3), False), (s**2 + s + Q, (0, 3), True),
        *((Q * s**2 + s + 1 + exp(-s), *x) for x in (((1, 3), True), ((-1, 3), False), ((0, 3), True))),
        (s**2 + Q * s, (-1, 3), True), (s**2 + s + Q + 2 * s**2 * exp(-s), (1, 3), False),
        (s**2 + s + Q - 2 * exp(-s), (1, 3), False), (s**2 + s + Q - 2 * exp(-s), (2, 3), True),
        (s**3 + 3 * s**2 + Q * exp(-s), (1, 2), True), (3 * s**2 + (Q - 1) * s**2 * exp(-s) + s + 1, (1, 2), True),
    ],
)  # fmt: skip
def test_a_dynamics_is_steady_where_its_value_at_0_and_its_highest_power_keep_their_signs(
    top: Expr, span: Any, *, steady: bool
) -> None:
    """At an end they may vanish; a value that is 0 throughout has no sign to keep, nor has a power of which all comes late."""
    assert of(top, s + 1)._is_steady(*map(Rational, span)) is steady


def test_cells_end_at_fractions_where_a_sign_may_change() -> None:
    """Of H_perc(0), of the highest power and of what prevails far out; what lies between fractions is no mark."""
    own = of(((Q - 2) * s**2 + 5 * s + 4 * (Q - 3)).expand(), s + Q + 10)
    far = [ExactSign(2 * Q - 1, Q), ExactSign(Q**2 - 3, Q), ExactSign(Integer(1), Q)]
    own.__dict__["_opening"] = ExactSign(Q - 7, Q)
    own.__dict__["_ends"] = [own._opening, *far]
    assert own._at_0.expand() == 4 * Q - 12
    assert own.marks == {Rational(2): Kind.FAR, Rational(1, 2): Kind.FAR, Rational(3): Kind.START}
    late = of(Q * s**2 * exp(-s) + (Q - 1) * exp(-s) + 4 + sqrt(s), s + 1)
    late.__dict__["_ends"] = []
    late.__dict__["_opening"] = None
    assert late.marks == {Rational(-3): Kind.START}
    assert late.openings == ()


def test_signs_near_rest_and_far_out_are_those_that_can_be_told() -> None:
    """q s + 20 s^(1/2): far out q decides, near rest the power; what is late there tells nothing."""
    own = of(Q * s + 20 * sqrt(s), Integer(1))
    assert [x.at(Integer(-1)) for x in own._ends] == [-1, -1]
    assert own.openings == ()
    own = of(Q * s + 20 * s**2 * sqrt(s), Integer(1))
    assert [float(x) for x in own.openings] == [0]
    assert own._ends[0] is own._opening
    own = of(Q * s + s**2 * exp(-s), s**2 * exp(-s) + s)
    assert all(np.isfinite(float(x)) for x in own.openings)
