"""Signs that show that a dynamics takes energy, numbers that are told apart, and what an evaluation says it left open: by hand."""

from __future__ import annotations

from dataclasses import dataclass, replace

import pytest
from sympy import Expr, Integer, Rational, exp, sqrt

import haptisym as hs
from haptisym.judge.climb import Bandwidths
from haptisym.judge.landings import Landing, above, settled
from haptisym.judge.passiveparts import takes_energy
from haptisym.kernel.reals import ExactNumber, RealNumber, SquareRoot
from haptisym.kernel.roots import Chart
from haptisym.kernel.symbols import s

TAKES: dict[Expr, bool] = {
    Integer(3) + 0 * s: True, s**2: True, 2 * s**2 + 3 * s + 5: True, s / 2 + 3: True, s**2 + s / (s + 1): True, s / (s + 1): True, sqrt(s): True,
    (s + 1) / (s + 2): True, (s**2 + 2 * s + 1) / (s**2 + s + 1) * s: True, s - 1: False, 1 - s: False, -s - 1: False, s**3: False,
    s**4: False, s**4 + s: False, (s + 2) / (s + 1): False, 1 / s: False, 1 / (s**2 + 1): False, (s + 1) / (s - 2): False, 2 * s + s * exp(-s): False,
    1 / (1 + sqrt(s)): False, s / (s**3 + s**2 + s + 1): False,
}  # fmt: skip


def test_what_takes_energy_by_signs_alone_is_told_and_of_all_else_nothing() -> None:
    """Im H >= 0, no pole in Re s >= 0 nor at 0, and no faster than s^2: False where one of these fails or signs do not show it."""
    for x, takes in TAKES.items():
        assert takes_energy(x.together()) is takes, x


def test_numbers_that_are_known_exactly_are_equal_and_others_that_do_not_part_stay_open() -> None:
    third, other = ExactNumber(Rational(1, 3)), ExactNumber(Rational(1, 3))
    assert not above(third, third)
    assert not above(third, other)
    quarter, root = ExactNumber(Rational(1, 4)), SquareRoot(ExactNumber(Rational(1, 16)))
    assert not above(quarter, root)
    assert not above(root, quarter)
    near = ExactNumber(Rational(1, 3) + Rational(1, 10**60))
    assert above(near, third)
    assert not above(third, near)
    with pytest.raises(hs.UndecidedError, match="which of two numbers is the larger"):
        above(third, SquareRoot(ExactNumber(Rational(1, 9))))


@dataclass(frozen=True, repr=False)
class Given(Landing):
    """At a height, and hardly below it without the peak."""

    here: RealNumber | None
    behind_it: RealNumber | None

    def at(self, height: Expr) -> RealNumber | None:
        return self.here

    def behind(self, height: Expr) -> RealNumber | None:
        return self.behind_it


def test_a_landing_is_what_both_sides_of_a_height_agree_about() -> None:
    third, exact = SquareRoot(ExactNumber(Integer(3))), ExactNumber(Rational(1, 2))
    two, three = ExactNumber(Integer(2)), ExactNumber(Integer(3))
    assert float(settled(Given(third, two, two))) == 2
    assert float(settled(Given(exact, two, None))) == 2  # at an exact height nobody asks beside it
    for here, behind in ((two, None), (None, two), (None, None), (two, three), (three, two)):
        with pytest.raises(hs.UndecidedError, match="whether two peaks of the ratios are equally high"):
            settled(Given(third, here, behind))


def test_an_evaluation_says_what_stayed_open_and_is_then_not_certified() -> None:
    found = hs.evaluate("fu2019")
    assert (found.certified, found.undecided) == (True, ())
    first, second = found.criteria
    points = list(found.chart.points)
    points[1] = replace(points[1], undecided=frozenset({second}))
    open_ = replace(found, chart=Chart(tuple(points)))
    assert open_.undecided == ((second, points[1]),)
    assert not open_.certified
    assert [x["part"] for x in open_.to_dict()["undecided"]] == [second.name] != [first.name]
    for width, certified in (
        (Bandwidths(None, None), True),
        (Bandwidths(None, None, undecided="x"), False),
        (None, True),
    ):
        own = hs.evaluate("fu2019")
        own.__dict__["bandwidths"] = width
        assert own.certified is certified
        assert own.to_dict()["certified"] is certified


def test_a_document_says_whose_threshold_it_is_and_where_formulas_stand_for_more_than_they_hold() -> None:
    scene = hs.load_scene("fu2019")
    assert "like" not in hs.evaluate(scene).to_dict()
    assert hs.evaluate(replace(scene, threshold=hs.Threshold.like("weight"))).to_dict()["like"] == "weight"
    felt, clock = hs.environments.kelvin_voigt(1500, 1), hs.effects.sampled_loop("1 ms", "backward-difference")
    loop = hs.evaluate(hs.Scene(felt, (clock, hs.effects.compliance(k=10**6, b=1))))
    assert loop.caveats
    assert loop.to_dict()["caveats"] == list(loop.caveats)
    assert "caveats" not in hs.evaluate(scene).to_dict()
