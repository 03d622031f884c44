"""What a region is asked for and does not have, or has in a way of its own: smooth squares, names of its ratio, ranges that meet."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import pytest

import haptisym as hs
from haptisym.judge.criteria import noticed
from haptisym.judge.regions import InTerms, Term
from haptisym.model.distortion import Distortion

PAPER = hs.load_scene("fu2019")
CORNERS = [["1/10", 0], [0, "1/10"], ["-1/10", 0], [0, "-1/10"]]
SHAPES: dict[str, tuple[Any, int | None]] = {
    "ellipse": ({"shape": "ellipse", "real": 0.1, "imag": 0.1}, 1),
    "diamond": ({"shape": "diamond", "real": 0.1, "imag": 0.1}, 2),
    "polygon": ({"shape": "polygon", "corners": CORNERS}, None),
    "floor": ({"real": 0.1, "imag": 0.1, "floor": "5 N/m"}, None),
    "sides": ({"real": {"higher": 0.1, "lower": 0.2}, "imag": 0.1}, None),
    "sides and floor": ({"real": {"higher": 0.1, "lower": 0.2}, "imag": 0.1, "floor": "5 N/m"}, None),
}


def judged(jnd: Any) -> hs.Scene:
    return hs.Scene(PAPER.environment, PAPER.effects, PAPER.band, jnd)


@pytest.mark.parametrize("name", SHAPES)
def test_squares_of_which_the_largest_counts_are_had_where_no_condition_and_no_least_is_between(name: str) -> None:
    jnd, count = SHAPES[name]
    scene = judged(jnd)
    region, d = noticed(scene.threshold)[0].region, scene.distortion()
    assert region is not None
    if count is None:
        with pytest.raises(hs.SceneError, match="makes no smooth ratio"):
            region.squares(d)
    else:
        assert len(region.squares(d)) == count
    if count == 1:
        assert region(d).function.equals(region.squares(d)[0].function)
    else:
        with pytest.raises(hs.SceneError, match="makes no smooth ratio"):
            region(d)


@dataclass(frozen=True)
class Pieced(InTerms):
    """A region of given terms."""

    given: tuple[Term, ...]

    @property
    def words(self) -> str:
        return "a region of pieces"

    def terms(self, d: Distortion) -> tuple[Term, ...]:
        return self.given

    def opened(self, limits: Any) -> Pieced:
        return self


def test_one_way_to_be_outside_that_is_not_smooth_is_enough() -> None:
    d = PAPER.distortion()
    f, g = (x.measure(d) for x in noticed(PAPER.threshold))
    plain, least, there = Term((), (f,)), Term((), (f, g)), Term((g,), (f,))
    assert Pieced((plain, Term((), (g,)))).squares(d) == (f, g)
    for other in (least, there):
        for terms in ((plain, other), (other, plain), (other,)):
            with pytest.raises(hs.SceneError, match="a region of pieces makes no smooth ratio"):
                Pieced(terms).squares(d)


@pytest.mark.parametrize(
    ("jnd", "said"),
    [
        (0.1, ["r_r"]),
        ({"real": 0.1, "imag": 0.1, "floor": "0.01 N/m"}, ["r_r over its limit"]),
        ({"shape": "ellipse", "real": 0.1, "imag": 0.1}, ["r_j"]),
    ],
    ids=str,
)
def test_a_peak_is_told_as_one_over_its_limit_where_it_is_that_of_a_part_with_more_than_a_number(
    jnd: Any, said: list[str]
) -> None:
    """A gain that peaks at 3 rad/s, in Re alone there."""
    spring = hs.environments.mass_spring_damper(k=100)
    found = hs.peaks(hs.Scene(spring, (hs.effects.series("1 + 0.4*s/(s^2 + 2*s + 9)"),), (0, 20), jnd))
    told = [repr(x) for x in found if abs(float(x.omega) - 3) < 1e-9]
    assert [x.split(" = ")[0] for x in told] == [f"<Peak {x}" for x in said]


def test_two_ranges_in_one_limit_tell_the_ends_alone_and_in_limits_of_their_own_all() -> None:
    def found(jnd: Any) -> Any:
        return hs.evaluate(judged(jnd)).bandwidths

    def width(jnd: Any) -> Fraction:
        return hs.evaluate(judged(jnd)).bandwidth.bounds(100)[0]  # type: ignore[union-attr]

    both = {"real": ["0.09", "0.11"], "imag": 0.1, "floor": ["5 N/m", "15 N/m"]}
    ends = [width({"real": x, "imag": 0.1, "floor": y}) for x, y in (("0.09", "5 N/m"), ("0.11", "15 N/m"))]
    one = found(both)
    assert (one.ends_alone, one.jumps, one.one) == (True, (), False)
    assert [x.bounds(100)[0] for x in (one.least, one.most)] == ends
    other = found({"real": ["0.09", "0.11"], "imag": ["0.1", "0.2"], "floor": "5 N/m"})
    assert (other.ends_alone, other.one, other.certified) == (False, False, True)


FROM_REST = [{"m": 1}, {"b": 2}, {"m": 1, "b": 2}]
"""Environments that vanish at omega = 0, where a region is judged by the limit of dH/|H_env|, as the square is."""


@pytest.mark.parametrize("numbers", FROM_REST)
@pytest.mark.parametrize("gain", ["-1", "3/4", "5/2"])
def test_a_polygon_that_is_the_square_tells_what_the_square_does_where_the_environment_begins_at_0(
    numbers: dict[str, int], gain: str
) -> None:
    lag = hs.effects.series("g*w/(s + w)", parameters={"g": gain, "w": 5})
    corners = [[1, 1], [-1, 1], [-1, -1], [1, -1]]
    one, other = (
        hs.Scene(hs.environments.mass_spring_damper(**numbers), (lag,), (0, 3), jnd)
        for jnd in (1, {"shape": "polygon", "corners": corners})
    )
    square, polygon = map(hs.evaluate, (one, other))
    assert [str(x) for x in polygon.transparent] == [str(x) for x in square.transparent]
    assert str(polygon.bandwidth) == str(square.bandwidth)
    wide = hs.tolerances(other.with_values({"g": [Fraction(gain) - Fraction(1, 100), gain]}), samples=0)
    assert (wide.bandwidth is None) is (polygon.bandwidth is None)


@pytest.mark.parametrize("numbers", FROM_REST[:2])
@pytest.mark.parametrize(("gain", "bandwidth"), [("0.89", 3), ("1.11", None), ("0.87", None), ("1.09", 3)])
def test_a_gain_is_noticed_by_its_own_limit_from_0_on_where_the_environment_vanishes_there(
    numbers: dict[str, int], gain: str, bandwidth: int | None
) -> None:
    """It makes a mass or a damping larger, or smaller, by one share of it at all frequencies."""
    sides = {"higher": "0.1", "lower": "0.12"}
    series = hs.effects.series("g", parameters={"g": gain})
    scene = hs.Scene(hs.environments.mass_spring_damper(**numbers), (series,), (0, 3), {"real": sides, "imag": sides})
    found = hs.evaluate(scene)
    assert found.crossings == ()
    assert (found.bandwidth and float(found.bandwidth)) == bandwidth


@pytest.mark.parametrize("stiffness", [100, 200])
def test_a_polygon_is_touched_where_an_undamped_environment_gives_way_and_other_regions_go_by_the_limit(
    stiffness: int,
) -> None:
    lead, environment = hs.effects.series("1 + s/20"), hs.environments.mass_spring_damper(m=1, k=stiffness)

    def found(jnd: object) -> list[tuple[str, float]]:
        e = hs.evaluate(hs.Scene(environment, (lead,), (0, 30), jnd))  # type: ignore[arg-type]
        return [(x.kind.value, float(x.omega)) for x in e.crossings]

    corners = [["1/10", "1/10"], ["-1/10", "1/10"], ["-1/10", "-1/10"], ["1/10", "-1/10"]]
    leaves = ("exceeds", 2.0)
    others = (0.1, *({"shape": x, "real": 0.1, "imag": 0.1} for x in ("ellipse", "diamond")))
    assert [found(x) for x in others] == [[leaves]] * 3
    assert found({"shape": "polygon", "corners": corners}) == [leaves, ("touches", pytest.approx(stiffness**0.5))]
