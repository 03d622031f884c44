"""JNDs: the regions that a table means, scaled, with ranges, published, and at another proportion of right answers; and what is none."""

from __future__ import annotations

import json
from fractions import Fraction
from statistics import NormalDist
from typing import Any

import mpmath
import pytest
from click.testing import CliRunner
from hypothesis import assume, example, given
from hypothesis import strategies as st
from jnds import jnds, same_rows
from refusals import refusal
from sympy import I, Integer, Rational, pi, sqrt

import haptisym as hs
from haptisym.cli import app
from haptisym.kernel.rings import omega
from haptisym.model.jnd import DIGITS, Conversion, Part, positive, read_threshold

PAPER = hs.load_scene("fu2019")
FRACTIONS = st.fractions(-50, 50, max_denominator=20)


def exact(x: Fraction) -> Rational:
    return Rational(x.numerator, x.denominator)


def with_jnd(jnd: Any) -> hs.Scene:
    return hs.Scene(PAPER.environment, PAPER.effects, PAPER.band, jnd)


def test_thresholds_are_positive_fractions() -> None:
    assert hs.Threshold.of("12 %", "1/3") == hs.Threshold(Rational(3, 25), Rational(1, 3))
    assert hs.Threshold.of(0.1) == hs.Threshold()
    for bad in (0, -1, "-0.1", "0.1 +- 150 %", "0.1 +- 100 %", "0.1 m", "nan", float("inf"), True, None):
        assert "real" in refusal(hs.Threshold.of, bad, "0.1")
        assert (
            "imag" in refusal(hs.Threshold.of, "0.1", bad) or bad is None
        )  # the imaginary part's is then that of the real part
    for c in (sqrt(2) / 10, -sqrt(2), I, sqrt(-2), pi * sqrt(2), 1 - sqrt(2)):
        assert "real: " in refusal(hs.Threshold, c)


@pytest.mark.parametrize("key", ["real", "floor", "lower"])
def test_a_formula_in_which_omega_cancels_is_the_number_that_is_left(key: str) -> None:
    def read(x: str) -> hs.Threshold:
        sided = {"real": {"higher": 1, "lower": x}} if key == "lower" else {key: x}
        return read_threshold({"real": 1, "imag": 1, **sided})

    assert read("3 + 0*omega") == read("3")
    assert read("2*omega/omega") == read("2")
    for x in ("omega - omega", "0*omega - 3"):
        assert f"{key}: " in refusal(read, x)
        assert "must be > 0" in refusal(read, x)


@example({"real": {"higher": "1/10", "lower": "1/5"}, "imag": "0.1 + omega", "floor": "3"})
@example({"shape": "ellipse", "real": "1/10", "imag": "1/5", "tilt": "-1/2"})
@example({"shape": "polygon", "corners": [["1", "0"], ["0", "1 + omega"], ["-1", "-1"]]})
@given(jnds())
def test_a_jnd_is_the_one_that_its_row_says(table: dict[str, Any]) -> None:
    own = read_threshold(table)
    row = own.row()
    for part, below in row.pop("lower", {}).items():
        row[part] = {"higher": row[part], "lower": below}
    again = read_threshold(row)
    assert same_rows(again.row(), own.row())
    assert (again.kind, again.is_constant, again.is_plain) == (own.kind, own.is_constant, own.is_plain)
    for part in Part:
        assert same_rows(str(again[part]), str(own[part]))
        assert same_rows(str(again.lower(part)), str(own.lower(part)))
    assert own.is_plain == (set(own.row()) == {"real", "imag"} and own.is_constant)
    text = str(own.row())
    assert own.is_constant == ("omega" not in text)


@example(c=Fraction(3), table={"real": {"higher": "1/10", "lower": "1/5"}, "imag": "0.1 + omega", "floor": "3"})
@example(c=Fraction(3), table={"shape": "ellipse", "real": "1/10", "imag": "1/5", "tilt": "-1/2"})
@example(c=Fraction(3), table={"shape": "polygon", "corners": [["1", "0"], ["0", "1 + omega"], ["-1", "-1"]]})
@given(jnds(), st.fractions(Fraction(1, 9), 9, max_denominator=9))
def test_a_jnd_that_is_so_many_times_as_large_has_every_length_so_many_times(
    table: dict[str, Any], c: Fraction
) -> None:
    own, large = read_threshold(table), read_threshold(table).scaled(exact(c))
    assert large.region.tilt == own.region.tilt
    assert (large.region.shape, large.kind) == (own.region.shape, own.kind)
    lengths = [
        (x.real, x.imag, *x.region.numbers.values(), *(y for corner in x.region.corners for y in corner))
        for x in (own, large)
    ]
    if own.region.corners:
        lengths = [x[2:] for x in lengths]
    assert all(
        (b - a * exact(c)).expand() == 0 or (b / a - exact(c)).simplify() == 0 for a, b in zip(*lengths, strict=True)
    )


SQUARE = {"real": 0.1, "imag": 0.2}

KINDS = {
    "a square": 0.1, "a rectangle": SQUARE, "a diamond": {"shape": "diamond", **SQUARE}, "an ellipse": {"shape": "ellipse", **SQUARE},
    "a square with a floor": {**SQUARE, "floor": 1}, "a square with limits for higher and lower": {**SQUARE, "real": {"higher": 1, "lower": 2}},
    "a polygon": {"shape": "polygon", "corners": [[1, 0], [0, 1], [-1, -1]]},
}  # fmt: skip


@pytest.mark.parametrize("kind", KINDS)
def test_a_jnd_is_called_what_it_is_and_takes_other_limits(kind: str) -> None:
    own = read_threshold(KINDS[kind])
    assert own.kind == kind
    plain = kind in ("a square", "a rectangle")
    assert own.is_plain == plain
    assert plain == (not refusal(own.need_plain, "area"))
    if kind == "a polygon":
        assert "no limit for one part" in refusal(own.with_limits, {Part.REAL: 1})
        return
    moved = own.with_limits({Part.IMAG: "30 %"})
    assert (moved.real, moved.imag, moved.lower(Part.REAL)) == (own.real, Rational(3, 10), own.lower(Part.REAL))
    assert own.with_limits({Part.REAL: [0.1, 0.3]}).real_interval == (Rational(1, 10), Rational(3, 10))
    assert own.with_limits({Part.REAL: 1}).lower(Part.REAL) is None


def test_the_ends_of_a_jnd_with_ranges_are_the_smallest_and_the_largest_region() -> None:
    table = {"real": {"higher": [0.1, 0.2], "lower": [0.3, 0.5]}, "imag": "0.2 +- 50 %", "floor": ["1 N/m", "3 N/m"]}
    own = read_threshold(table)
    assert set(own.ranges) == {"real", "imag", "real.lower", "floor"}
    assert (own.is_box, own.is_plain, own.is_scaled) == (False, False, False)
    for end, (real, lower, imag, floor) in enumerate([("1/10", "3/10", "1/10", 1), ("1/5", "1/2", "3/10", 3)]):
        found = own.at_end(end)
        assert (found.real, found.lower(Part.REAL), found.imag, found.region.floor) == (
            *map(Rational, (real, lower, imag)),
            floor,
        )
        assert (found.ranges, found.lower(Part.IMAG)) == ({}, None)
    gone = own.with_limits({Part.REAL: 0.1})
    assert (set(gone.ranges), gone.region.floor, gone.imag_interval) == ({"imag", "floor"}, 2, own.imag_interval)
    scaled = read_threshold({"shape": "ellipse", "real": 0.1, "imag": 0.2, "tilt": 0.5, "scale": [0.5, 2, 3]})
    assert (scaled.real, scaled.imag, scaled.region.size, scaled.ranges) == (
        Rational(1, 5),
        Rational(2, 5),
        2,
        {"scale": (Rational(1, 2), 3)},
    )
    assert [(x.real, x.imag, x.region.size) for x in map(scaled.at_end, (0, 1))] == [
        (Rational(1, 20), Rational(1, 10), 1), (Rational(3, 10), Rational(3, 5), 1),
    ]  # fmt: skip
    corners = [[1, 0], [0, 1], [-1, -1]]
    polygon = read_threshold({"shape": "polygon", "corners": corners, "scale": "1 +- 50 %"})
    assert polygon.at_end(0).region.corners == (
        (Rational(1, 2), 0),
        (0, Rational(1, 2)),
        (Rational(-1, 2), Rational(-1, 2)),
    )
    even = read_threshold({"shape": "diamond", "real": [0.1, 0.2], "imag": [0.1, 0.2]})
    uneven = [
        read_threshold({"shape": "diamond", "real": [0.1, 0.2], "imag": x})
        for x in (0.15, [0.1, 0.3], [0.1, 0.15, 0.2])
    ]
    assert (even.is_scaled, even.is_box, [x.is_scaled for x in uneven]) == (True, True, [False, False, True])
    assert not read_threshold([0.1, 0.2]).is_scaled


def test_clockwise_corners_are_those_of_the_same_polygon_turned_round() -> None:
    corners = [[1, 0], [0, 2], [-1, -1]]
    one, other = (read_threshold({"shape": "polygon", "corners": x}).region.corners for x in (corners, corners[::-1]))
    assert one == other == tuple((Integer(x), Integer(y)) for x, y in corners)


@given(st.lists(FRACTIONS, min_size=1, max_size=3), st.fractions(0, 5), st.fractions(Fraction(1, 9), 5))
def test_a_formula_is_positive_on_a_band_where_no_root_and_no_pole_of_it_lies_there(
    roots: list[Fraction], low: Fraction, length: Fraction
) -> None:
    value = Integer(1)
    for i, x in enumerate(roots):
        value = value / (omega - exact(x)) ** 2 if i == 1 else value * (omega - exact(x))
    high = low + length
    assume(value.has(omega))
    sign = 1
    for i, x in enumerate(roots):
        if i != 1 and low < x:
            sign = -sign
    inside = any(low <= x <= high for x in roots)
    cancelled = len(roots) > 1 and roots[1] in (roots[0], *roots[2:])
    assume(not cancelled)
    assert positive(value, exact(low), exact(high)) == (sign > 0 and not inside)


SQUARE_CORNERS = [[1, 0], [0, 1], [-1, -1]]


def polygon(corners: Any) -> dict[str, Any]:
    return {"shape": "polygon", "corners": corners}


REFUSED: list[tuple[Any, str]] = [
    ({"shape": "ellipse", "real": 1, "imag": 1, "tilt": 1}, "strictly between -1 and 1"), ({"shape": "ellipse", "real": 1, "imag": 1, "tilt": "omega/15"}, "on the whole band"),
    ({"real": "1 - omega/15", "imag": 1}, "must be > 0 on the whole band"), ({"real": 1, "imag": "1/(omega - 5)^2"}, "on the whole band"),
    ({"real": 1, "imag": "(omega - 5)^2"}, "must be > 0"), ({"real": 1, "imag": 1, "floor": "15 - omega"}, "floor: "), ({"real": {"higher": 1, "lower": "15 - omega"}, "imag": 1}, "real: lower: "),
    (polygon([[1, 0], [0, 1], [0, 1], [-1, -1]]), "2 and 3 are the same point"), (polygon([["1 + omega", 0], ["11 - omega", 0], [0, 1], [-1, -1]]), "1 and 2 are the same point"),
    (polygon([[1, 0], [0, 1], [-1, 0]]), "0 must be inside"), (polygon([[0.1, 0.1], [0.3, 0.1], [0.2, 0.3]]), "0 must be inside"), (polygon([[0, 0], [0.1, 0], [0, 0.1]]), "0 must be inside"),
    (polygon([["0.1 - omega/150", 0.1], ["0.1 - omega/150", -0.1], [-0.1, 0]]), "0 must be inside"), (polygon([[1, 0], [0, 1], [-1, "omega/15 - 1"]]), "0 must be inside"),
    (polygon([[2, 0], [1, 1], [0, 2], [-1, -1]]), "convex"), (polygon([[0.1, 0], [0.01, 0.01], [0, 0.1], [-0.1, 0], [0, -0.1]]), "convex"),
    (polygon([[0.1, 0], ["0.06 - 0.003*omega", "0.06 - 0.003*omega"], [0, 0.1], [-0.1, 0], [0, -0.1]]), "convex"),
    (polygon([[0.1, 0], [-0.0809, 0.0588], [0.0309, -0.0951], [0.0309, 0.0951], [-0.0809, -0.0588]]), "in order around"),
    (polygon([[1, 0], [-1, 1], [-1, -1], [1, 1], [-1, 2], [-2, -1]]), "in order around"),
    (polygon([[1, 0], [0, 1]]), "3 to 24 pairs"), (polygon([[i, i * i] for i in range(25)]), "3 to 24 pairs"), (polygon([[1, 0], [0, 1], [1]]), "give a pair"), (polygon("abc"), "give a list"),
    (polygon([["0.1 + omga", 0], [0, 0.1], [-0.1, -0.1]]), "omga"), ({"shape": "polygon"}, "corners is missing"),
    ({"shape": "circle", "real": 1, "imag": 1}, "valid are square, ellipse, diamond, polygon"), ({"shape": "diamnd", "real": 1, "imag": 1}, 'did you mean "diamond"'),
    ({"real": 1}, "both real and imag"), ({"real": 1, "imag": 1, "tilt": 0}, 'unknown key "tilt"'), ({"shape": "ellipse", "real": 1, "imag": 1, "flor": 1}, 'unknown key "flor"'),
    ({"shape": "ellipse", "real": 1, "imag": 1, "floor": 1}, 'shape = "square"'), ({"shape": "ellipse", "real": {"higher": 1, "lower": 2}, "imag": 1}, "only a square"),
    ({"real": {"higher": 1}, "imag": 1}, "both higher and lower"), ({"real": {"higher": 0, "lower": 1}, "imag": 1}, "real: higher: .* must be > 0"),
    ({"real": {"higher": 1, "lower": -1}, "imag": 1}, "real: lower: .* must be > 0"), ({"real": 1, "imag": 1, "floor": 0}, "floor: .* must be > 0"),
    ({"real": 1, "imag": 1, "floor": ["0 N/m", "5 N/m"]}, "must be > 0"), ({"real": 1, "imag": 1, "floor": "1 kg"}, "floor: "), ({"real": 1, "imag": 1, "floor": "3 N*m/rad"}, "rotational"),
    ({"real": {"higher": 1, "lower": [2, 1]}, "imag": 1}, "real: lower: "), ({"real": [0, 1], "imag": 1}, "must be > 0"), ([0.2, 0.1], "the lower end"),
    ({"like": "fu2019", "real": 1}, "takes no other key"), ({"like": "viscosity"}, 'unknown published threshold "viscosity"'), ({"like": "wieght"}, 'did you mean "weight"'), ({"like": 3}, '"3"'),
    ({"real": 1, "imag": 1, "scale": 2}, "give a range"), ({**polygon(SQUARE_CORNERS), "scale": [-1, 1]}, "must be > 0"), ({"real": [1, 2], "imag": 1, "scale": [1, 2]}, "leave out the other ranges"),
    ({"shape": "ellipse", "real": [1, 2], "imag": 1, "tilt": 0.5}, "tilted ellipse are not supported"), ({"real": "2*x", "imag": 1}, "formula in omega"), ({"real": "omega^0.5", "imag": 1}, "not a rational formula"),
    ({"real": "omega*x", "imag": 1}, 'unknown name "x"'), ({"real": 1, "imag": 1, "proportion": 0.5}, "above 0.5"),
]  # fmt: skip


@pytest.mark.parametrize(("jnd", "told"), REFUSED, ids=range(len(REFUSED)))
def test_what_is_no_jnd_on_the_band_is_refused_with_the_reason(jnd: Any, told: str) -> None:
    with pytest.raises(hs.SceneError, match=told) as raised:
        with_jnd(jnd)
    assert "Decimal" not in str(raised.value)


@pytest.mark.parametrize(
    "jnd",
    [
        {"shape": "ellipse", "real": 1, "imag": 1, "tilt": "99/100"}, {"shape": "ellipse", "real": 1, "imag": 1, "tilt": "omega/16"}, {"real": "1 - omega/16", "imag": 1},
        polygon([[i, i * i - 1] for i in range(-2, 22)]), {"shape": "ellipse", "real": [1, 2], "imag": [1, 2], "tilt": 0.5}, {"shape": "ellipse", "real": [1, 2], "imag": 1},
        {"real": 1, "imag": 1, "proportion": 0.75}, polygon(SQUARE_CORNERS),
    ],
    ids=str,
)  # fmt: skip
def test_a_jnd_may_lie_at_its_limits(jnd: Any) -> None:
    assert not refusal(with_jnd, jnd)


def test_a_motion_of_a_floor_is_that_of_the_scene() -> None:
    spring, jnd = hs.environments.mass_spring_damper, {"real": 1, "imag": 1, "floor": "1 N*m/rad"}
    assert "rotational" in refusal(hs.Scene, spring(k="1 N/m"), threshold=jnd)
    for k in ("1 N*m/rad", 1):
        assert not refusal(hs.Scene, spring(k=k), threshold=jnd)


# --- published -------------------------------------------------------------------------------------------------------

SCENE = 'environment = {{ model = "mass-spring-damper", k = 1 }}\n[evaluation]\njnd = {{ like = "{}" }}\n'


@pytest.mark.parametrize("name", [x.name for x in hs.published()])
def test_a_scene_takes_one_by_its_name_unless_it_is_no_threshold_for_one(name: str) -> None:
    [x] = [x for x in hs.published() if x.name == name]
    if x.apart:
        with pytest.raises(hs.SceneError, match="is no threshold for a scene"):
            hs.parse_scene(SCENE.format(name))
        return
    found = hs.parse_scene(SCENE.format(name)).threshold
    assert found == hs.Threshold.like(name)
    assert (found.real_interval or (found.real, found.real)) == (x.low, x.high)
    assert found.source == name


def test_a_range_of_a_source_gives_its_range_of_bandwidths() -> None:
    scene = hs.load_scene("fu2019").with_band(0, 60)
    own = hs.evaluate(hs.Scene(scene.environment, scene.effects, scene.band, hs.Threshold.like("weight")))
    ends = [hs.evaluate(scene.with_values({"c": c})).bandwidth for c in ("0.22", "0.44")]
    assert own.bandwidths is not None
    assert [own.bandwidths.least.digits(20), own.bandwidths.most.digits(20)] == [x.digits(20) for x in ends]
    assert own.to_dict()["like"] == "weight"
    assert "as `weight`: static weight" in " ".join(str(own).split())


def test_another_value_is_no_longer_the_published_one() -> None:
    scene = hs.parse_scene(SCENE.format("force-pinch"))
    assert scene.with_values({"c": "0.08"}).threshold.source == ""
    assert "like" not in hs.evaluate(scene.with_values({"c": "0.08"})).to_dict()


def test_two_jnd_of_one_paper_are_one_by_their_criteria() -> None:
    """19 % at 71 % correct is 34.14 % at 84 %: as the same Gaussian has it, and as the paper says."""
    one, other = (
        next(x for x in hs.published() if x.name == name) for name in ("viscosity-forced-choice", "viscosity-matching")
    )
    z = NormalDist().inv_cdf
    assert float(one.low) * z(float(other.criterion)) / z(float(one.criterion)) == pytest.approx(
        0.3414387697, abs=1e-10
    )
    assert float(other.low) == pytest.approx(0.34)


def test_every_entry_is_a_fraction_with_a_source_and_says_how_far_that_was_read() -> None:
    for x in hs.published():
        assert 0 < x.low <= x.high <= 1
        assert x.criterion is None or 0.5 < x.criterion < 1
        assert x.source
        assert x.read


def test_the_command_lists_them() -> None:
    done = CliRunner().invoke(app, ["jnd", "--published", "--json"])
    assert done.exit_code == 0
    assert json.loads(done.stdout) == hs.published().to_dict()
    for wrong in (["jnd", "a.csv", "--published"], ["jnd", "--published", "--reference", "3"], ["jnd"]):
        assert isinstance(CliRunner().invoke(app, wrong).exception, hs.SceneError)


# --- at another proportion of right answers --------------------------------------------------------------------------

AT_75 = {"real": 0.1, "imag": 0.1, "proportion": 0.75}


def test_two_different_jnds_of_one_paper_are_one() -> None:
    """19 % at 71 % right answers is 34.14 % at 84 %."""
    found = read_threshold({"real": 0.19, "imag": 0.19, "proportion": 0.71}).at_proportion(0.84)
    assert float(found.real) == pytest.approx(0.3414387697, abs=1e-10)


@given(st.integers(51, 99), st.integers(51, 99))
def test_the_factor_is_the_quotient_of_two_quantiles_to_all_its_digits(start: int, end: int) -> None:
    p, q = Rational(start, 100), Rational(end, 100)
    mp = mpmath.mp.clone()
    mp.dps = 60
    one, other = (mp.erfinv(2 * mp.mpf(n) / 100 - 1) for n in (start, end))
    found = Conversion(p, q).factor
    assert abs(mp.mpf(int(found.p)) / int(found.q) - other / one) <= abs(other / one) * mp.mpf(10) ** (1 - DIGITS)


def test_the_papers_example_at_84_percent_loses_the_crossing_of_its_real_part() -> None:
    [crossing] = hs.evaluate(with_jnd(AT_75), proportion="84 %").crossings
    assert crossing.criterion.name == "imag"
    assert float(crossing.omega) == pytest.approx(14.5345990489774, rel=1e-14)
    [rounded] = hs.evaluate(with_jnd(0.14744)).crossings  # the reference's digits are those of the rounded c
    assert float(rounded.omega) == pytest.approx(14.534683158, abs=5e-10)


def test_a_region_is_scaled_as_a_whole() -> None:
    c = Conversion(Rational(3, 4), Rational(21, 25)).factor
    tilted = read_threshold(
        {"shape": "ellipse", "real": 0.1, "imag": "0.1 + omega/50", "tilt": 0.5, "proportion": 0.75}
    )
    found = tilted.at_proportion(0.84)
    assert (found.real, found.region.tilt) == (c / 10, Rational(1, 2))
    assert (found.imag - tilted.imag * c).expand() == 0
    corners = [[0.1, 0], [0, 0.1], [-0.1, -0.1]]
    polygon = read_threshold({"shape": "polygon", "corners": corners, "proportion": 0.75}).at_proportion(0.84)
    assert polygon.region.corners[0] == (c / 10, 0)
    sided = read_threshold({"real": {"higher": 0.1, "lower": 0.2}, "imag": 0.1, "floor": 2, "proportion": 0.75})
    assert sided.at_proportion(0.84).region.numbers == {"real: lower": c / 5, "floor": 2 * c}


def test_the_document_tells_the_conversion_and_how_exact_it_is() -> None:
    row = hs.evaluate(with_jnd(AT_75), proportion=0.84).to_dict()["threshold"]
    assert row["proportion"] == 0.84
    assert row["conversion"]["factor"].startswith("1.4743854638571647")
    low, high = map(Rational, row["conversion"]["enclosure"])
    assert 0 < high - low < Rational(1, 10**DIGITS)


@pytest.mark.parametrize(
    ("jnd", "proportion", "told"),
    [
        (0.1, 0.84, "has none of its own"),
        (AT_75, 0.5, "above 0.5"),
        (AT_75, 1, "below 1"),
        (AT_75, "x", "proportion"),
        ({**AT_75, "proportion": 0.4}, 0.84, "above 0.5"),
    ],
)
def test_what_cannot_be_converted_is_told(jnd: object, proportion: object, told: str) -> None:
    with pytest.raises(hs.SceneError, match=told):
        hs.evaluate(with_jnd(jnd), proportion=proportion)
