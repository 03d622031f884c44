"""Which way to the meetings of a loop is taken, and in which windows they are told: tables of all that a loop may be."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from itertools import pairwise, product
from types import SimpleNamespace
from typing import Any

import pytest
from flint import arb
from sympy import Integer, Rational, pi

from haptisym.kernel.errors import LimitError, UndecidedError
from haptisym.kernel.far import Far, Sense
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.rootcount import RootChain, Roots
from haptisym.verbs.stability import boundary, neutral
from haptisym.verbs.stability.curves import Gap, Meeting, Meetings


def exact(x: Any) -> ExactNumber:
    return ExactNumber(Rational(x))


FAR, NOUGHT, CURVED, SWITCHED = (Meeting(exact(n), exact(n)) for n in (1, 2, 3, 4))
ZERO = Meeting(exact(0), None)


def stubs(monkeypatch: pytest.MonkeyPatch, *, chain: bool, late: bool, some: bool, curve: str) -> dict[str, Any]:
    """All that is asked of a loop: of infinity, of 0, of switches, of cells without a chain, and of its curve."""
    asked: dict[str, Any] = {}
    own = SimpleNamespace(
        condition=SimpleNamespace(is_zero=curve == "everywhere", name="condition"),
        value="value",
        meetings=lambda reach: (asked.update(reach=reach), (CURVED,))[1],
    )
    sense = {"above": Sense.POSITIVE, "below": Sense.NEGATIVE}.get(curve, Sense.BOTH)
    monkeypatch.setattr(boundary, "from_infinity", lambda _: (FAR,))
    monkeypatch.setattr(boundary, "Characteristic", lambda _: SimpleNamespace(at_0=lambda: [exact(2)]))
    monkeypatch.setattr(boundary, "_has_chain", lambda *_: chain)
    monkeypatch.setattr(boundary, "is_neutral", lambda _: late)
    monkeypatch.setattr(boundary, "cells", lambda *_: [1] * some)
    monkeypatch.setattr(boundary, "curve_of", lambda _: None if curve == "none" else own)
    monkeypatch.setattr(boundary, "far", lambda _: Far(sense, Rational(7)))
    monkeypatch.setattr(boundary, "RealFunction", lambda x: x)
    own.value = SimpleNamespace(reduced=lambda: "value")
    monkeypatch.setattr(boundary, "ValueAt", lambda value, omega: (value, omega))
    switched = SimpleNamespace(up_to=lambda value: ((SWITCHED,), value + 5))
    monkeypatch.setattr(boundary, "Switches", SimpleNamespace(of=lambda _: switched))
    monkeypatch.setattr(boundary, "neutral_meetings", lambda _, __, out: iter([("neutral", out)]))
    monkeypatch.setattr(boundary, "_windows", lambda _, __, value, out: iter([("windows", value, out)]))
    return asked


@pytest.mark.parametrize("curve", ["none", "everywhere", "above", "below", "both"])
def test_all_that_puts_roots_on_the_axis_is_asked_for_where_it_may_be(
    curve: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    zero = Meeting(exact(2), exact(0))
    for rests, lags, turns, chain, late, some in product((False, True), repeat=6):
        asked = stubs(monkeypatch, chain=chain, late=late, some=some, curve=curve)
        loop: Any = SimpleNamespace(rests=rests, turns=turns, ring=SimpleNamespace(lags=[Rational(1, 9)] * lags))
        found: list[Any] = [*boundary._eliminated(loop, Integer(3))]
        if rests and not lags:
            expected: Any = Meetings((zero,))
        elif turns:
            with_0 = Meetings((FAR, zero), below=None)
            expected = (
                Meetings((FAR, ZERO))
                if chain
                else with_0
                if rests
                else Meetings((FAR, zero, SWITCHED), below=Integer(8))
            )
        elif late and not some:
            expected = Meetings((FAR,))
        elif rests or curve == "none":
            expected = Meetings((FAR, zero))
        elif curve == "everywhere":
            expected = Meetings((FAR, zero, Meeting(("value", exact(1)), None)))  # type: ignore[arg-type]
        elif curve in ("above", "below"):
            expected = Meetings((FAR, zero, CURVED))
            assert asked["reach"] == 7
        else:
            expected = ("neutral", (FAR, zero)) if late else ("windows", 3, (FAR, zero))
        assert found == [expected], (rests, lags, turns, chain, late, some)


def test_what_one_equation_leaves_open_is_searched_for_unless_a_gap_or_the_time_ended_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    whole, gapped, own = Meetings((FAR,)), Meetings((FAR,), gaps=(Gap(None, None),)), Meetings((NOUGHT,))
    given: list[Any] = []

    def eliminated(*_: Any) -> Iterator[Meetings]:
        for x in given:
            if isinstance(x, Exception):
                raise x
            yield x

    monkeypatch.setattr(boundary, "_eliminated", eliminated)
    monkeypatch.setattr(boundary, "searched", lambda _, value, reason: iter([(own, value, reason)]))
    loop: Any = SimpleNamespace()
    searched = (own, 3, "why")
    for rows, expected in (
        ([whole], [whole]), ([gapped], [gapped]), ([UndecidedError("why")], [searched]),
        ([whole, UndecidedError("why")], [whole, searched]),
        ([gapped, whole, UndecidedError("why")], [gapped, whole, searched]),
    ):  # fmt: skip
        given[:] = rows
        assert [*boundary.meetings(loop, Integer(3))] == expected
    for last, kind in ((UndecidedError("why"), UndecidedError), (LimitError("late"), LimitError)):
        given[:] = [gapped, last]
        with pytest.raises(kind, match="why|late"):
            list(boundary.meetings(loop, Integer(3)))
    given[:] = [LimitError("late")]
    with pytest.raises(LimitError, match="late"):
        list(boundary.meetings(loop, Integer(3)))


@pytest.mark.parametrize("value", [Rational(8), Rational(-3), Rational(0)])
def test_windows_are_four_times_as_wide_each_and_those_above_a_part_of_the_value_begin_at_a_fourth_of_the_last(
    value: Rational, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Up to a size beyond which none is, and from one on below which none is: as the square of values far out tells."""
    asked: list[tuple[Any, Any]] = []
    loop: Any = SimpleNamespace(ring=SimpleNamespace(lags=[]))
    curve: Any = SimpleNamespace(square="square", meetings=lambda reach: (Meeting(exact(reach), None),))

    def less(f: Any, number: Any) -> Any:
        asked.append((f, number))
        return number

    monkeypatch.setattr(boundary, "minus", less)
    for sense in (Sense.POSITIVE, Sense.NEGATIVE, Sense.BOTH):
        monkeypatch.setattr(boundary, "far", lambda x, sense=sense: Far(sense, 1 + x))
        if sense is Sense.BOTH or (sense is Sense.NEGATIVE and value <= 0):
            with pytest.raises(UndecidedError, match="ever higher frequencies"):
                list(boundary._windows(loop, curve, value, (FAR,)))
            continue
        windows = [*boundary._windows(loop, curve, value, (FAR,))]
        assert len(windows) == 12
        assert {f for f, _ in asked} == {"square"}
        for x in windows:
            end = x.below if sense is Sense.POSITIVE else x.above
            assert end is not None
            assert end**2 in [number for _, number in asked]
            assert x.found == (FAR, Meeting(exact(1 + end**2), None))
        if sense is Sense.POSITIVE:
            assert all(x.above == -x.below for x in windows if x.below is not None)
            steps = [x.below - abs(value) for x in windows if x.below is not None]
            assert steps[0] == (1 + abs(value)) / 16
            assert all(b == 4 * a for a, b in pairwise(steps))
        else:
            assert all(x.below is None for x in windows)
            lows = [x.above for x in windows if x.above is not None]
            assert lows[:3] == [Rational(15, 2), 4, 1]
            assert all(b * 4 == a for a, b in pairwise(lows[1:]))


def test_a_chain_is_asked_for_at_the_delay_itself_or_at_a_second() -> None:
    asked: list[Any] = []

    def loop(chain: RootChain | None) -> Any:
        def at(value: Any) -> Roots:
            asked.append(value)
            return Roots(None, None, chain=chain)

        return SimpleNamespace(at=at)

    def fails(_: Any) -> Any:
        raise UndecidedError("why")

    for value, expected in ((Rational(2, 7), Rational(2, 7)), (Integer(0), 1), (pi / 9, 1), (Integer(5), 5)):
        for chain in (None, RootChain.NEAR, RootChain.RIGHT):
            assert boundary._has_chain(loop(chain), value) is (chain is not None)
            assert asked[-1] == expected
    own: Any = SimpleNamespace(at=fails)
    assert boundary._has_chain(own, Integer(1)) is False


def test_frequencies_are_looked_at_up_to_1_at_least_and_as_far_as_no_delay_turns_400_radians() -> None:
    for lags, radius in product(
        ([], [Rational(2)], [Rational(1, 9), Rational(2)]), (Rational(1, 3), Rational(200), Rational(201))
    ):
        loop: Any = SimpleNamespace(ring=SimpleNamespace(lags=lags))
        if lags and radius > 200:
            with pytest.raises(UndecidedError, match="turn very often"):
                boundary._near(radius, loop)
        else:
            assert boundary._near(radius, loop) == max(radius, 1)


# Of a neutral loop


@pytest.mark.parametrize("known", [(True, True), (False, True), (False, False), (False, None)])
def test_of_a_neutral_loop_gaps_are_what_no_radius_is_known_of_up_to_40_and_then_to_120_radians(
    known: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two cells that touch, one after them; what is known of the middle one of them at either turning, or of none."""
    asked: list[Any] = []
    ends = [exact(n) for n in range(5)]
    clear = [neutral._Cell(ends[i], ends[i + 1]) for i in (0, 1, 3)]
    at = dict(zip((40, 120), known, strict=True))

    def pieces(cell: Any, reach: str, turning: int, depth: int) -> Iterator[tuple[Any, Any]]:
        assert (reach, depth > 9) == ("reach", True)
        is_known = at[turning] or (at[turning] is False and cell is not clear[1])
        yield cell, Rational(10 + clear.index(cell)) if is_known else None

    monkeypatch.setattr(neutral, "reach_of", lambda _: "reach")
    monkeypatch.setattr(neutral, "cells", lambda *_: clear)
    monkeypatch.setattr(neutral, "_pieces", pieces)

    def meetings(reach: Any) -> Any:
        asked.append(reach)
        return (CURVED,)

    curve: Any = SimpleNamespace(meetings=meetings)
    found = [*neutral.neutral_meetings(SimpleNamespace(), curve, [FAR])]  # type: ignore[arg-type]
    one, both = (Gap(exact(1), exact(2)),), (Gap(exact(0), exact(2)), Gap(exact(3), exact(4)))
    expected = {
        True: Meetings((FAR, CURVED)),
        False: Meetings((FAR, CURVED), gaps=one),
        None: Meetings((FAR,), gaps=both),
    }
    assert found == [expected[x] for x in (known if not known[0] else known[:1])]
    assert asked == [12 for x in (known if not known[0] else known[:1]) if x is not None]


def test_a_cell_is_hopeless_if_nothing_is_known_of_its_ends_nor_of_its_middle() -> None:
    """An end that is not there is that of inverses."""
    for low, high in product((None, 0, 2), (None, 3, 8)):
        cell = neutral._Cell(*(None if x is None else exact(x) for x in (low, high)))
        middle = cell.middle
        places = {"low": low, "middle": middle, "high": high}
        for told in (None, *places):

            def radius(q: Any, turning: int, *, inverse: bool, told: str | None = told, places: Any = places) -> Any:
                assert turning == 40
                value = None if told is None else places[told]
                at = Fraction(
                    0 if value is None else int(value.p if hasattr(value, "p") else value), int(getattr(value, "q", 1))
                )
                here = (
                    told is not None and inverse is (value is None) and q.contains(arb(at.numerator) / at.denominator)
                )
                return Rational(5) if here else None

            reach: Any = SimpleNamespace(radius=radius)
            assert cell.is_hopeless(reach, 40) is (told is None)
