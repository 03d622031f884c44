"""When the time is over each search of a requirement or a certificate ends at once, and what it does not know it leaves open."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from flint import arb, fmpq
from sympy import Integer, Rational, Symbol

import haptisym as hs
from haptisym.judge.criteria import noticed
from haptisym.kernel.budget import limited
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import LimitError
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.response import RealFunction
from haptisym.kernel.symbols import omega, s
from haptisym.verbs.evaluate.breakpoints import breakpoints
from haptisym.verbs.evaluate.products import Factor
from haptisym.verbs.evaluate.zeros import _cells as cells_of
from haptisym.verbs.require.blowups import is_negative
from haptisym.verbs.require.criticalvalues import Problem
from haptisym.verbs.require.energy import Energy
from haptisym.verbs.require.floatcells import FloatCells, Told
from haptisym.verbs.require.freeparameter import Domain
from haptisym.verbs.require.passivecells import _Search
from haptisym.verbs.require.plane import _Search as PlaneSearch
from haptisym.verbs.require.slabs import Ends
from haptisym.verbs.require.slabs import Problem as Slabs
from haptisym.verbs.require.verdicts import Question

Q = Symbol("q", real=True)
LATE = hs.Scene(
    hs.environments.mass_spring_damper(k=100), (hs.effects.delay("5 ms"), hs.effects.shunt(m="0.1 kg", b="1 N*s/m"))
)


def _is_negative() -> object:
    return is_negative({(Fraction(0), Fraction(0)): fmpq(-1)}, arb(1), arb(1))


def _clear() -> object:
    ring = Ring.of([Q])
    return Energy.of(ring.convert(Q * s), Q).clear((1.0, 2.0))


def _slabs() -> object:
    problem = Slabs(
        [Factor(((1,),), 1)], {"r.real": {"number": "-1", "powers": []}}, (Fraction(0),) * 2 + (Fraction(1),) * 2, []
    )
    return [*problem.slabs(Ends(Fraction(0), Fraction(1)), holds=True)]


def _breakpoints() -> object:
    return breakpoints([ExactNumber(Integer(0)), ExactNumber(Integer(1))], [Factor(((-1,), (2,)), 1)])


def _zeros() -> object:
    return cells_of(((2,), (3,), (1,)))


@pytest.mark.parametrize("work", [_is_negative, _clear, _slabs, _breakpoints, _zeros])
def test_a_search_whose_time_is_over_is_cut_short(work: Callable[[], object]) -> None:
    assert work() not in (None, False)
    with limited(1e-9), pytest.raises(LimitError):
        work()


def _asked() -> Any:
    return Question([], lambda _: True, Domain(None, None), closed=True)


def _cells() -> Any:
    function = RealFunction(Ring([Q]).axis.convert(Q - omega**2))
    problem = Problem(
        {noticed(hs.Threshold())[0]: function}, Q, (Integer(0), Integer(1)), Domain(None, None), lambda _: True
    )
    problem.prepare()
    return problem


@pytest.mark.parametrize("question", [_asked, _cells])
def test_of_a_question_whose_time_is_over_all_is_open_between_what_is_known_already(
    question: Callable[[], Any],
) -> None:
    known = question().solve()
    assert (known.feasible != (), known.undecided) == (True, ())
    asked = question()
    with limited(1e-9):
        found = asked.solve()
    assert found.feasible == ()
    assert found.undecided[0][0] is found.undecided[-1][1] is None


def test_a_value_that_is_asked_about_by_itself_is_not_told_when_the_time_is_over() -> None:
    search = _Search(LATE, LATE.knobs["environment.k"])
    assert search.holds_at(Rational(100)) is True
    with limited(1e-9):
        assert search.holds_at(Rational(100)) is None


def test_floats_that_have_no_time_tell_nothing_and_leave_every_rectangle() -> None:
    class Down:
        is_zero = False

        def model(self, cells: Any, slopes: int) -> Any:
            raise AssertionError(cells, slopes)

    cells = object.__new__(FloatCells)
    object.__setattr__(cells, "scale", 1.0)
    cells.__dict__["_excesses"] = ((Down(), None),)
    plane = PlaneSearch(2.0**-4, 1000, [Down()])  # type: ignore[list-item]
    with limited(1e-9):
        assert cells.told(-1.0, 2.0) == [Told(-1.0, 2.0, None)]
        plane.go()
    assert (plane.kept, plane.broken) == ([], [])
    assert sum((x[..., 1] - x[..., 0]).prod(-1).sum() for x in plane.left) == pytest.approx(1)
    assert np.concatenate(plane.left).shape == (64, 2, 2)
