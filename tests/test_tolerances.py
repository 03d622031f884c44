"""What is claimed for all values in a box, against sets of values answered one by one, and against boxes solved by hand."""

from __future__ import annotations

import json
from fractions import Fraction
from math import sqrt

import numpy as np
import pytest
from click.testing import CliRunner
from marks import often
from sympy import Rational

import haptisym as hs
from haptisym.cli import app
from haptisym.quantities import Dimension
from haptisym.ranges import ranged
from haptisym.tolerance.answers import tolerances
from haptisym.tolerance.box import box_of
from haptisym.tolerance.excess import Excess
from haptisym.tolerance.proofs import Verdict

QUICK = {"fu2019-tolerances", "delayed-spring"}.__contains__
HEAD = 'environment = {{ model = "mass-spring-damper", m = {m} }}\n'
SPRING = """
[environment]
model = "mass-spring-damper"
k = "100 N/m +- 10 %"
[[effects]]
model = "{model}"
{parameters}
[evaluation]
band = ["0 rad/s", "{top} rad/s"]
jnd = {jnd}
"""


def spring(model: str, parameters: str, top: float = 15, jnd: str = "0.1") -> hs.Scene:
    return hs.parse_scene(SPRING.format(model=model, parameters=parameters, top=top, jnd=jnd))


# Ranges as they are written


@pytest.mark.parametrize(
    "given", ["2 kg +- 10 %", "2 kg ± 10 %", "2 kg +- 200 g", "2 kg +/- 0.2 kg", ["1.8 kg", "2200 g"], [1.8, 2.2]]
)
def test_a_range_is_read_exactly_however_it_is_written(given: object) -> None:
    found = ranged(given, Dimension.MASS)
    assert (found.nominal.value, found.interval) == (2, (Rational(9, 5), Rational(11, 5)))


def test_a_range_around_a_negative_value_has_its_ends_in_order() -> None:
    assert ranged("-45 g +- 10 %", Dimension.MASS).interval == (Rational(-99, 2000), Rational(-81, 2000))


def test_a_range_of_no_width_is_a_number() -> None:
    assert ranged("2 kg +- 0 %", Dimension.MASS).interval is None
    assert ranged(["2 kg", "2 kg"], Dimension.MASS).interval is None


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ('["1.9 kg", "1.7 kg"]', ["m", "lower end", "above"]),
        ('["1.9 kg"]', ["m", "pair"]),
        ('["1.9 kg", "2 kg", "3 kg"]', ["m", "pair"]),
        ('["1.9 kg", "2 N"]', ["m", "not a mass"]),
        ('["1.9 kg", 2]', ["m", "units of the same kind"]),
        ('"0 kg +- 5 %"', ["m", "percentage of zero"]),
        ('"1 kg +- -5 %"', ["m", "must be >= 0"]),
        ('"1 kg +- 200 %"', ["m", "must be >= 0"]),
        ('["-1 kg", "1 kg"]', ["m", "must be >= 0"]),
        ('"1 kg +- 0.1"', ["m", "units alike"]),
        ('"1 +- 0.1 kg"', ["m", "units alike"]),
        ('"1 kg +- "', ["m", "not a range"]),
        ('"1 kg +- 1 % +- 1 %"', ["m", "not a range"]),
        ('"1 kg +- many %"', ["m", "finite decimal number"]),
    ],
)  # fmt: skip
def test_a_wrong_range_is_refused_with_one_message(given: str, words: list[str]) -> None:
    with pytest.raises(hs.SceneError) as error:
        hs.parse_scene(HEAD.format(m=given), "mine")
    assert all(word in str(error.value) for word in ["mine", "environment", *words])


def test_the_order_of_a_pade_approximant_cannot_vary_nor_can_the_band() -> None:
    with pytest.raises(hs.SceneError, match="and no range"):
        spring("pade-delay", 'tau = "5 ms"\norder = [1, 3]')
    with pytest.raises(hs.SceneError, match="band"):
        hs.parse_scene(HEAD.format(m=1) + '[evaluation]\nband = ["0 rad/s", "15 rad/s +- 5 %"]')
    with pytest.raises(hs.SceneError, match="jnd"):
        hs.parse_scene(HEAD.format(m=1) + "[evaluation]\njnd = [-0.1, 0.1]")


def test_other_verbs_take_the_nominal_values_and_say_so() -> None:
    plain, ranges = hs.evaluate(hs.load_scene("fu2019")), hs.evaluate(hs.load_scene("fu2019-tolerances"))
    assert [x.omega.digits(40) for x in plain.crossings] == [x.omega.digits(40) for x in ranges.crossings]
    note = "m, b, k, omega_n, zeta vary by 5 %: this is the nominal scene; see `haptisym tolerances`."
    assert note in str(ranges)
    assert "nominal scene" not in str(plain)
    assert hs.load_scene("fu2019-tolerances").with_values({"m": 2}).nominal_note.startswith("b, k,")


# Bounds over cells


@pytest.mark.parametrize(
    "name",
    often(
        [
            "fu2019-tolerances",
            "delayed-spring",
            "organ-tissue",
            "position-force-teleoperation",
            "sidestick",
            "sampled-wall",
        ],
        QUICK,
    ),
)
def test_a_model_encloses_the_excess_and_its_slopes_everywhere_in_a_cell(name: str) -> None:
    """Against the certified excess of single sets of values, and differences of it."""
    box = box_of(widened(hs.load_scene(name)))
    random = np.random.default_rng(7)
    for part in hs.Part:
        form = Excess(box, part)
        for width in (0.05, 0.4):
            start = random.uniform(0, 1 - width, (6, form.sides))
            cells = np.stack([start, start + width], -1)
            low, high = form.model(cells).bounds()
            for i, cell in enumerate(cells):
                point = cell[:, 0] + random.uniform(0, 1, form.sides) * width
                value = certified_excess(box, part, point)
                assert low[i, 0] <= value <= high[i, 0]
                for side in range(form.sides):
                    step = np.zeros(form.sides)
                    step[side] = 1e-6 * (1 if point[side] < 0.5 else -1)
                    difference = (certified_excess(box, part, point + step) - value) / step[side] * width / 2
                    slack = 1e-4 * (abs(difference) + abs(low[i, 1 + side]) + abs(high[i, 1 + side])) + 1e-9
                    assert low[i, 1 + side] - slack <= difference <= high[i, 1 + side] + slack


def widened(scene: hs.Scene) -> hs.Scene:
    """The scene with 10 per cent on all that is not 0 and has no range yet."""
    values = {
        p.symbol.name: [p.value * Rational(9, 10), p.value * Rational(11, 10)] for p in scene.parameters if p.value
    }
    return scene if any(p.interval for p in scene.parameters) else scene.with_values(values)


def certified_excess(box, part: hs.Part, shares: np.ndarray) -> float:  # type: ignore[no-untyped-def, type-arg]
    from flint import arb

    exact = {side.name: Fraction(float(x)) for side, x in zip(box.sides, shares[1:], strict=True)}
    scene = box.scene_at(box.values(exact))
    low, high = (float(x) for x in scene.band)
    omega = low + float(shares[0]) * (high - low)
    square = scene.distortion().squared_ratios[part].ball(arb(omega))
    return float(square) - float(scene.threshold[part]) ** 2


# Answers


def test_the_ends_of_a_boxs_crossing_are_known_by_hand() -> None:
    """Behind a lag, r_i of a spring is x/(1 + x^2), x = omega/omega_c: c at x = 5 - sqrt 24, whatever the stiffness."""
    found = tolerances(spring("first-order-lag", 'omega_c = "40 rad/s +- 10 %"', 10), samples=0)
    [x] = found.enclosures
    assert (x.part, x.count, x.monotonic["omega_c"]) == (hs.Part.IMAG, 1, 1)
    assert [float(end) for end in (x.low, x.high)] == pytest.approx([w * (5 - sqrt(24)) for w in (36, 44)], rel=1e-14)
    assert (x.at_low["omega_c"], x.at_high["omega_c"]) == (36, 44)
    assert [float(end) for end in found.bandwidth] == pytest.approx([float(x.low), float(x.high)])
    assert found.verdict is Verdict.NONE


def test_a_threshold_may_vary() -> None:
    """The larger the threshold the higher the crossing: asin(c)/tau behind a delay."""
    scene = spring("delay", 'tau = "10 ms"', 15, '["0.08", "0.12"]')
    found = tolerances(scene, samples=0)
    [x] = [x for x in found.enclosures if x.part is hs.Part.IMAG]
    assert [float(end) for end in (x.low, x.high)] == pytest.approx(
        [np.arcsin(c) / 0.01 for c in (0.08, 0.12)], rel=1e-14
    )
    assert x.monotonic["c"] == 1


@pytest.mark.parametrize(
    ("top", "verdict"), [(3, Verdict.ALL), (4, Verdict.DEPENDS), (5, Verdict.NONE)]
)  # the crossing lies between 3.64 and 4.44 rad/s
def test_the_verdict_is_for_all_for_some_or_for_none(top: int, verdict: Verdict) -> None:
    found = tolerances(spring("first-order-lag", 'omega_c = "40 rad/s +- 10 %"', top), samples=0)
    assert found.verdict is verdict
    if verdict is Verdict.DEPENDS:
        for one, expected in ((found.transparent, True), (found.noticed, False)):
            result = hs.evaluate(found.box.scene_at(one.values))
            whole = [(float(x.low.omega), float(x.high.omega)) for x in result.transparent] == [(0, top)]
            assert whole is expected


@pytest.mark.parametrize("model", ["delay", "zero-order-hold", "second-order-lowpass"])
def test_no_set_of_values_crosses_outside_the_enclosures(model: str) -> None:
    parameters = {
        "delay": 'tau = "10 ms +- 20 %"',
        "zero-order-hold": 'T = "20 ms +- 20 %"',
        "second-order-lowpass": 'omega_n = "60 rad/s +- 10 %"\nzeta = "0.5 +- 0.1"',
    }
    found = tolerances(spring(model, parameters[model]), samples=40)
    for one in (*found.samples, *found._corners):
        for part in hs.Part:
            own = [
                (float(x.low) * (1 - 1e-12), float(x.high) * (1 + 1e-12)) for x in found.enclosures if x.part is part
            ]
            assert all(any(low <= float(x) <= high for low, high in own) for x in one.crossings[part])
            counts = [x.count for x in found.enclosures if x.part is part]
            if None not in counts:
                assert len(one.crossings[part]) == sum(counts)
    low, high = found.bandwidth
    assert all(float(low) <= float(x.bandwidth) <= float(high) for x in found.samples)


def test_the_same_seed_draws_the_same_sets() -> None:
    scene = spring("first-order-lag", 'omega_c = "40 rad/s +- 10 %"')
    first, again, other = (tolerances(scene, 20, seed) for seed in (1, 1, 2))
    assert [x.values for x in first.samples] == [x.values for x in again.samples] != [x.values for x in other.samples]


def test_the_command_line_tells_proof_and_estimate_apart(tmp_path) -> None:  # type: ignore[no-untyped-def]
    path = tmp_path / "mine.toml"
    path.write_text(SPRING.format(model="first-order-lag", parameters='omega_c = "40 rad/s +- 10 %"', top=10, jnd=0.1))
    done = CliRunner().invoke(app, ["tolerances", str(path), "--samples", "20", "--figure", str(tmp_path / "x.svg")])
    assert done.exit_code == 0
    assert "Guaranteed: the bandwidth" in done.stdout
    assert "Estimated, NOT guaranteed" in done.stdout
    assert max(map(len, done.stdout.splitlines())) <= 96
    assert (tmp_path / "x.svg").exists()
    document = json.loads(CliRunner().invoke(app, ["tolerances", str(path), "--json", "--samples", "20"]).stdout)
    assert (document["schema"], document["verdict"]) == ("haptisym.tolerances/1", "none")
    assert document["estimates"]["samples"] == 20
    assert document["crossings"][0]["reached_at"]["low"]["omega_c"] == "36"


def test_a_scene_without_ranges_is_told_how_to_write_one() -> None:
    with pytest.raises(hs.SceneError, match=r"no parameter has a range.*\+-"):
        tolerances(hs.load_scene("fu2019"))


@pytest.mark.slow
def test_the_shipped_scene_crosses_where_it_is_said_to() -> None:
    found = hs.tolerances(hs.load_scene("fu2019-tolerances"), samples=200)
    assert found.verdict is Verdict.NONE
    [imag] = [x for x in found.enclosures if x.part is hs.Part.IMAG]
    assert (imag.count, imag.low.digits(6), imag.high.digits(6)) == (1, "11.0702", "12.8735")
    assert {len(x.crossings[hs.Part.REAL]) for x in found._corners} == {0, 1}  # at two corners r_r never reaches c
    low, high = found.bandwidth
    assert all(float(low) <= float(x.bandwidth) <= float(high) for x in found.samples)


def test_public_names() -> None:
    found = hs.tolerances(spring("first-order-lag", "omega_c = 40"), samples=0)
    assert isinstance(found, hs.Tolerances)
    assert callable(hs.tolerances)


def test_a_touch_at_a_corner_is_left_undecided_and_said_so(tmp_path) -> None:  # type: ignore[no-untyped-def]
    """r_r is at most a/2 (at 3 rad/s): for the largest a just the threshold, so that neither a proof nor a witness exists."""
    path = tmp_path / "touch.toml"
    path.write_text(
        'environment = { model = "mass-spring-damper", k = "100 N/m" }\n'
        'effects = [{ model = "series", G = "1 + a*s/(s^2 + 2*s + 9)", parameters = { a = [0.3, 0.4] } }]\n'
        "evaluation = { jnd = { real = 0.2, imag = 1 } }\n"
    )
    done = CliRunner().invoke(app, ["tolerances", str(path), "--samples", "5"])
    assert done.exit_code == 3
    assert "UNDECIDED within the work budget" in done.stdout
