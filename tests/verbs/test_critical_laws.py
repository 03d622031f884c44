"""From meetings to critical values: whatever lies between gaps, what is told is where the number of roots changes next."""

from __future__ import annotations

import random
from types import SimpleNamespace
from typing import Any

import pytest
from sympy import Integer, Rational

from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.rootcount import Roots
from haptisym.model.parameters import Rule
from haptisym.verbs.stability import critical
from haptisym.verbs.stability.curves import Gap, Meeting, Meetings


def exact(value: int) -> ExactNumber:
    return ExactNumber(Integer(value))


@pytest.mark.parametrize("seed", range(30))
def test_the_nearest_change_is_told_unless_it_may_lie_in_a_gap(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Places at whole numbers, at some of which a count changes; those inside of a gap are hidden."""
    draw = random.Random(seed)
    changes = {place: draw.choice([-2, 0, 2]) for place in draw.sample(range(-9, 10), 8)}
    a = draw.choice([-6, -5, 2, 3])
    gaps = [] if seed % 3 == 0 else [(a, a + draw.randint(1, 4))]
    start = Rational(draw.choice([-1, 1, 3]), 2)
    hidden = {x for low, high in gaps for x in changes if low < x < high}

    def at(value: Any) -> Roots:
        number = 40 + sum(change for place, change in changes.items() if place < value)
        return Roots(number, number)

    def meetings(*_: Any) -> list[Meetings]:
        found = tuple(Meeting(exact(x), exact(1)) for x in changes if x not in hidden)
        return [Meetings(found, gaps=tuple(Gap(exact(low), exact(high)) for low, high in gaps))]

    monkeypatch.setattr(critical, "meetings", meetings)
    free: Any = SimpleNamespace(path="q", value=start, rule=Rule.ANY)
    loop: Any = SimpleNamespace(at=at, turns=False)
    told = critical._Walk(loop, free).nearest()
    for side in (-1, 1):
        ahead = sorted((x for x in changes if (x - start) * side > 0), key=lambda x: abs(x - start))
        true = next((x for x in ahead if changes[x]), None)
        first = min((abs(x - start) for gap in gaps for x in gap if (x - start) * side > 0), default=None)
        clear = true is not None and (first is None or abs(true - start) < first)
        row = next((x for x in told.found if (float(x.value) > start) == (side > 0)), None)
        assert (row is not None) == clear or (row is not None and true == float(row.value))
        if row is not None:
            assert (float(row.value), row.below, row.above) == (true, at(true).number, at(true + Rational(1, 2)).number)
        elif first is not None:
            assert told.reason
