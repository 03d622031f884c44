"""Where what counts changes from one square to another: every pair of what rises, falls, stays or has a pole there, by hand."""

from __future__ import annotations

from typing import NamedTuple

import pytest
from sympy import Expr, Integer

import haptisym as hs
from haptisym.judge.criteria import noticed
from haptisym.judge.envelopes import Envelope, Maximum
from haptisym.judge.regions import Term
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.response import RealFunction
from haptisym.kernel.roots import chart
from haptisym.kernel.symbols import omega as w

CRITERION = noticed(hs.Threshold())[0]


class Piece(NamedTuple):
    """A square, with its value at 2 rad/s, and whether it rises (1), falls (-1) or stays (0)."""

    square: Expr
    value: float
    slope: int


NOTHING = None
PIECES = (
    NOTHING, Piece(Integer(1), 1, 0), Piece(Integer(2), 2, 0), Piece(w / 2, 1, 1), Piece(w, 2, 1), Piece(2 / w, 1, -1), Piece(4 / w, 2, -1),
)  # fmt: skip
POLES = 1 / (w - 2) ** 2, 3 / (w - 2) ** 2


def real(x: Expr) -> RealFunction:
    return RealFunction(Ring().axis.convert(x.together()).reduced())


def seen(terms: list[Term]) -> tuple[Maximum | None, Maximum | None]:
    """The maximum, and the begin of a plateau, at 2 rad/s."""
    envelope = Envelope(CRITERION, tuple(terms))
    table = chart(envelope.functions(), Integer(1), Integer(3))
    [point] = [x for x in table.points if float(x.omega) == 2]
    return envelope.top(point), envelope.plateau(point)


def beside(before: Expr | None, after: Expr | None) -> list[Term]:
    """The one holds below 2 rad/s, the other above."""
    sides = [(2 - w, before), (w - 2, after)]
    return [Term((real(where),), (real(x),)) for where, x in sides if x is not None]


def told(x: Maximum | None) -> tuple[Expr, bool, bool] | None:
    return None if x is None else (x.square.expression(), x.jump, x.after)


@pytest.mark.parametrize("before", PIECES, ids=str)
def test_there_is_a_maximum_where_the_larger_side_comes_to_it_and_a_plateau_where_a_larger_one_stays(
    before: Piece | None,
) -> None:
    for after in PIECES:
        if before is after is None:
            continue
        top, plateau = map(told, seen(beside(before and before.square, after and after.square)))
        drop = (before.value if before else -1) - (after.value if after else -1)
        if before and before.slope > 0 and (drop > 0 or (drop == 0 and after and after.slope < 0)):
            assert top == (before.square, drop > 0, False)
        elif after and after.slope < 0 and drop < 0:
            assert top == (after.square, True, True)
        else:
            assert top is None
        stays = after and not after.slope and (drop < 0 or (drop == 0 and before and before.slope > 0))
        assert plateau == ((after.square, drop < 0, drop < 0) if after and stays else None)


def test_a_pole_is_no_maximum_and_begins_no_plateau_on_whichever_side_it_is() -> None:
    for other in PIECES:
        for sides in ((POLES[0], other and other.square), (other and other.square, POLES[0])):
            top, plateau = seen(beside(*sides))
            assert top is None
            assert plateau is None
    assert seen(beside(*POLES)) == (None, None)


def test_of_a_term_the_least_square_counts_and_of_terms_the_largest() -> None:
    """At 2 rad/s all are 1; before, w/2 is the least of a term, and 2/w behind."""
    rises, falls, stays = (Term((), (real(x),)) for x in (w / 2, 2 / w, Integer(1)))
    both = Term((), (real(w / 2), real(2 / w)))
    turned = Term((), (real(2 / w), real(w / 2)))
    for term in (both, turned):
        assert told(seen([term])[0]) == (w / 2, False, False)
    assert seen([rises, falls]) == (None, None)  # a dent
    assert seen([both, stays]) == (None, None)
    capped = Term((), (real(Integer(1)), real(w / 2)))
    for terms in ([capped], [capped, both], [turned, capped]):
        top, plateau = seen(terms)
        assert top is None
        assert told(plateau) == (1, False, False)


def test_a_term_counts_where_all_of_its_conditions_are_positive_and_not_where_one_is_zero_throughout() -> None:
    above, below, never = (real(x) for x in (w - 2, 3 - w, 0 * w))
    falls = (real(4 / w),)
    assert told(seen([Term((above, below), falls)])[0]) == (4 / w, True, True)
    assert told(seen([Term((below, above), falls)])[0]) == (4 / w, True, True)
    for where in ((above, never), (never, above), (never,)):
        higher = Term(where, (real(Integer(3)),))
        assert told(seen([higher, Term((above,), falls)])[0]) == (4 / w, True, True)
