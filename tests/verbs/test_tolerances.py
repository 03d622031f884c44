"""What is claimed for all values in a box, against sets of values answered one by one, and against boxes solved by hand."""

from __future__ import annotations

import json
import random
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from math import sqrt
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from forms import Form
from marks import often
from sympy import Rational, Symbol

import haptisym as hs
from haptisym.cli import app
from haptisym.judge.criteria import noticed
from haptisym.kernel.errors import LimitError
from haptisym.kernel.reals import ExactNumber
from haptisym.model.quantities import Dimension
from haptisym.model.ranges import ranged
from haptisym.pages.tolerances import page
from haptisym.programs.taylormodels import Model, halves
from haptisym.programs.valued import floated
from haptisym.verbs.tolerances import single
from haptisym.verbs.tolerances.box import Box, box_of
from haptisym.verbs.tolerances.ends import Face
from haptisym.verbs.tolerances.entry import tolerances
from haptisym.verbs.tolerances.excess import Excess
from haptisym.verbs.tolerances.proofs import One, Tolerances
from haptisym.verbs.tolerances.quantiles import Quantiles, quantiles
from haptisym.verbs.tolerances.search import (
    Cluster,
    _apart,
    _Bounded,
    _contracted,
    _unclear,
    beyond,
    bounded,
    clusters,
    together,
)
from haptisym.verbs.tolerances.verdicts import Verdict

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
        ('["1.9 kg", "2 kg", "3 kg", "4 kg"]', ["m", "pair"]),
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
        form = excess_of(box, part)
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


def excess_of(box: Box, part: hs.Part) -> Excess:
    [criterion] = [x for x in noticed(box.scene.threshold) if x.part is part]
    return Excess(box, criterion)


def certified_excess(box, part: hs.Part, shares: np.ndarray) -> float:  # type: ignore[no-untyped-def, type-arg]
    from flint import arb

    exact = {side.name: Fraction(float(x)) for side, x in zip(box.sides, shares[1:], strict=True)}
    scene = box.scene.with_values(box.values(exact))
    low, high = (float(x) for x in scene.band)
    omega = low + float(shares[0]) * (high - low)
    square = scene.distortion().squared_ratios[part].ball(arb(omega))
    return float(square) - float(scene.threshold[part]) ** 2


# Answers


def test_the_ends_of_a_boxs_crossing_are_known_by_hand() -> None:
    """Behind a lag, r_i of a spring is x/(1 + x^2), x = omega/omega_c: c at x = 5 - sqrt 24, whatever the stiffness."""
    found = tolerances(spring("first-order-lag", 'omega_c = "40 rad/s +- 10 %"', 10), samples=0)
    assert "drawn at random" not in repr(page(found))
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
            result = hs.evaluate(found.box.scene.with_values(one.values))
            whole = [(float(x.low.omega), float(x.high.omega)) for x in result.transparent] == [(0, top)]
            assert whole is expected


@pytest.mark.few("delay")
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
            assert all(any(low <= float(x) <= high for low, high in own) for x in one.crossings[part.value])
            counts = [x.count for x in found.enclosures if x.part is part]
            if None not in counts:
                assert len(one.crossings[part.value]) == sum(counts)
    low, high = found.bandwidth
    assert all(float(low) <= float(x.bandwidth) <= float(high) for x in found.samples)


@pytest.mark.slow
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
    spring = hs.environments.kelvin_voigt(["1 N/m", "2 N/m"], Symbol("b", positive=True))
    with pytest.raises(hs.SceneError, match="is a symbol where a number is needed"):
        tolerances(hs.Scene(spring, (LAG,)))


@pytest.mark.slow
def test_the_shipped_scene_crosses_where_it_is_said_to() -> None:
    found = hs.tolerances(hs.load_scene("fu2019-tolerances"), samples=200)
    assert found.verdict is Verdict.NONE
    [imag] = [x for x in found.enclosures if x.part is hs.Part.IMAG]
    assert (imag.count, imag.low.digits(6), imag.high.digits(6)) == (1, "11.0702", "12.8735")
    assert {len(x.crossings["real"]) for x in found._corners} == {0, 1}  # at two corners r_r never reaches c
    low, high = found.bandwidth
    assert all(float(low) <= float(x.bandwidth) <= float(high) for x in found.samples)


def test_public_names() -> None:
    assert {"tolerances", "Tolerances"} <= set(dir(hs))
    assert hs.tolerances is tolerances
    assert type(hs.tolerances(spring("first-order-lag", "omega_c = 40"), samples=0)) is hs.Tolerances


@pytest.mark.parametrize(
    ("gain", "status", "said"),
    [
        ("a", 0, "transparent on the whole band for ALL values"),  # r_r grows with a; below it is largest in the middle
        pytest.param("(0.4 - 100*(a - 0.35)^2)", 3, "UNDECIDED within the work budget", marks=pytest.mark.slow),
    ],
)
def test_a_touch_is_told_at_a_corner_and_elsewhere_left_undecided_and_said_so(
    tmp_path: Path, gain: str, status: int, said: str
) -> None:
    """r_r is at most half the gain (at 3 rad/s): at its largest just the threshold, so that neither a margin nor a witness exists."""
    path = tmp_path / "touch.toml"
    path.write_text(
        'environment = { model = "mass-spring-damper", k = "100 N/m" }\n'
        f'effects = [{{ model = "series", G = "1 + {gain}*s/(s^2 + 2*s + 9)", parameters = {{ a = [0.3, 0.4] }} }}]\n'
        "evaluation = { jnd = { real = 0.2, imag = 1 } }\n"
    )
    done = CliRunner().invoke(app, ["tolerances", str(path), "--samples", "5"])
    assert said in done.stdout
    assert done.exit_code == status


# --- boxes -----------------------------------------------------------------------------------------------------------

SOFT = hs.environments.mass_spring_damper(k="100 N/m +- 10 %")
LAG = hs.effects.first_order_lag("40 rad/s +- 10 %")


def test_numbers_without_a_unit_are_told_in_those_of_translation_as_all_pages_do() -> None:
    bare = hs.environments.mass_spring_damper([1, 2], [3, 4], [90, 110])
    assert [x.unit for x in box_of(hs.Scene(bare, (LAG,))).sides] == ["kg", "N*s/m", "N/m", "rad/s"]


def test_a_box_has_a_side_for_each_range_in_its_units_and_the_threshold_last() -> None:
    wheel = hs.environments.mass_spring_damper("0.05 kg*m^2 +- 5 %", "0.3 N*m*s/rad", "5 N*m/rad +- 10 %")
    for jnd, names in (
        (hs.Threshold.of("0.1 +- 20 %"), ["c"]),
        (hs.Threshold.of("0.1 +- 20 %", "0.1"), ["c_real"]),
        (hs.Threshold.of("0.2", "0.1 +- 20 %"), ["c_imag"]),
        (hs.Threshold.of("0.1 +- 20 %", "0.1 +- 10 %"), ["c_real", "c_imag"]),
    ):
        box = box_of(hs.Scene(wheel, (LAG,), (0, 15), jnd))
        assert [x.name for x in box.sides] == ["m", "k", "omega_c", *names]
        assert [x.unit for x in box.sides] == ["kg*m^2", "N*m/rad", "rad/s", *["1"] * len(names)]
        assert [box.part_name(part) for part in hs.Part] == (["c", "c"] if names == ["c"] else ["c_real", "c_imag"])
        own = box.values({x.name: Fraction(i, 7) for i, x in enumerate(box.sides)})
        assert own["k"] == Rational(9, 2) + Rational(1, 7)
        told = box.scene.with_values(own).threshold
        for part in hs.Part:
            assert told[part] == own.get(box.part_name(part), jnd[part])
        assert not any(p.interval for p in box.scene.with_values(own).parameters if p.symbol.name in own)
        assert box.scene.with_values({"k": Rational(5)}).threshold == jnd
    assert [x.unit for x in box_of(hs.Scene(SOFT, (LAG,))).sides] == ["N/m", "rad/s"]
    with pytest.raises(hs.SceneError, match="omega_c = w is a symbol"):
        box_of(hs.Scene(SOFT, (hs.effects.first_order_lag(hs.symbols("w")),)))


ODD = {
    "a pure mass behind a delay, with an odd factor of s in common": hs.Scene(
        hs.environments.mass_spring_damper(m="2 kg +- 10 %"),
        (hs.effects.delay("5 ms +- 20 %"), hs.effects.shunt(m=[-1, "0.5"], b="-2 +- 1")), (1, 30),
    ),
    "a pure damper, from 0 on": hs.Scene(
        hs.environments.mass_spring_damper(b="3 +- 10 %"),
        (hs.effects.zero_order_hold("9 ms +- 30 %"), hs.effects.first_order_lag("8 Hz +- 5 %")), (0, 25),
    ),
    "a resonance without damping": hs.Scene(
        hs.environments.mass_spring_damper(m="1 kg +- 1 %", k=49), (hs.effects.first_order_lag("20 +- 20 %"),), (0, 15),
    ),
    "fractional tissue": hs.Scene(
        hs.environments.spring_pot(k_alpha="50 +- 10 %", alpha=["0.3", "0.5"]),
        (hs.effects.first_order_lag("8 Hz"), hs.effects.compliance(k="3000 +- 20 %")), (0, 15),
        hs.Threshold.of("0.1 +- 10 %", "0.2 +- 20 %"),
    ),
    "waves, friction and thresholds that vary alone": hs.Scene(
        hs.environments.kelvin_voigt("200 +- 10 %", 3),
        (hs.effects.coulomb_friction("0.5 N +- 50 %", "2 cm"), hs.effects.wave_variables("20 +- 10 %", "5 ms +- 10 %")),
        (2, 20), hs.Threshold.of("0.15", "0.1 +- 20 %"),
    ),
    "a repeated factor and a parameter of both signs": hs.Scene(
        hs.environments.maxwell("300 +- 5 %", 9),
        (hs.effects.series("(s + a)^2*(s^2 + 2*q*s + 90)/(s + 30)^2/(s^2 + 90)", parameters={"a": [-5, 20], "q": "1 Hz"}),), (0, 9),
    ),
}  # fmt: skip


@pytest.mark.few(
    "a pure mass behind a delay, with an odd factor of s in common",
    "a pure damper, from 0 on",
    "a resonance without damping",
    "fractional tissue",
    "a repeated factor and a parameter of both signs",
)
@pytest.mark.parametrize("scene", ODD.values(), ids=ODD)
def test_a_model_of_an_odd_scene_holds_the_excess_and_its_slopes_and_narrows_with_the_cell(scene: hs.Scene) -> None:
    box = box_of(scene)
    random = np.random.default_rng(5)
    for part in hs.Part:
        form = excess_of(box, part)
        start = random.uniform(0.02, 0.6, (2, form.sides))
        points = start + 0.3 * random.uniform(0, 1, (2, form.sides))
        values = [certified_excess(box, part, x) for x in points]
        known = []
        for width in (0.3, 0.05, 0.005):
            near = points + (start - points) * width / 0.3  # the cells shrink upon the points
            low, high = form.model(np.stack([near, near + width], -1)).bounds()
            assert all(low[i, 0] <= values[i] <= high[i, 0] for i in (0, 1))
            known.append((low, high))
        low, high = known[-1]
        for i, point in enumerate(points):
            size = abs(values[i]) + float(scene.threshold[part]) ** 2
            assert high[i, 0] - low[i, 0] < 0.2 * size + 4 * abs(high[i, 1:]).sum() + 4 * abs(low[i, 1:]).sum()
            for side in range(form.sides):
                ends = [certified_excess(box, part, point + step * 1e-5 * np.eye(form.sides)[side]) for step in (-1, 1)]
                slope = (ends[1] - ends[0]) / 2e-5 * 0.0025
                slack = 1e-5 * abs(slope) + 1e-9 * size
                assert low[i, 1 + side] - slack <= slope <= high[i, 1 + side] + slack
                assert form.matters[side] or slope == pytest.approx(0, abs=1e-9 * size)
                assert (high - low)[i, 1 + side] < 0.5 * abs(slope) + 0.05 * size


def test_what_the_excess_does_not_depend_on_is_known() -> None:
    """A stiffness alone cancels from ratios of what is in series with it; one part's threshold is not the other's."""
    scene = hs.Scene(SOFT, (LAG,), (0, 15), hs.Threshold.of("0.1 +- 20 %", "0.2 +- 20 %"))
    box = box_of(scene)
    assert [x.name for x in box.sides] == ["k", "omega_c", "c_real", "c_imag"]
    assert excess_of(box, hs.Part.REAL).matters.tolist() == [True, False, True, True, False]
    assert excess_of(box, hs.Part.IMAG).matters.tolist() == [True, False, True, False, True]
    late = box_of(hs.Scene(SOFT, (hs.effects.delay("5 ms +- 10 %"),)))
    assert excess_of(late, hs.Part.IMAG).matters.tolist() == [True, False, True]
    assert [excess_of(box_of(hs.Scene(SOFT, x)), hs.Part.REAL).is_zero for x in ((), (LAG,))] == [True, False]


def test_a_variable_is_known_to_within_roundings_of_its_largest_size() -> None:
    """Of its largest in the cell; along a side from a negative number on, too: its values as fractions."""
    scene = hs.Scene(SOFT, (hs.effects.shunt(b=[-5, "-4.9"], m=["0.1", "0.7"]),), ("0.1", 15))
    form = excess_of(box_of(scene), hs.Part.REAL)
    shares = np.random.default_rng(6).uniform(0, 1, (200, form.sides))
    cells = np.stack([shares, shares], -1)
    for i, (low, width) in enumerate(form._intervals):
        model = form._variable(i, cells, slopes=2)
        assert (model.r[:, 0] >= 4 * 2.0**-53 * (abs(low) + width * shares[:, i])).all()
        least, most = (x[:, 0] for x in model.bounds())
        exact = [Fraction(low) + Fraction(width) * Fraction(x) for x in shares[:, i]]
        assert all(Fraction(a) <= x <= Fraction(b) for a, x, b in zip(least, exact, most, strict=True))
        assert (most - least <= 1e-12 * (abs(low) + width)).all()


@pytest.mark.slow
def test_a_variable_holds_its_values_and_its_slope_whatever_the_sizes_of_its_ends() -> None:
    """Ends of 10^-300 to 10^300, of both signs and alike but for a last digit, cells down to 2^-1000: against fractions."""
    chance = random.Random(20)
    form = Excess.__new__(Excess)
    form.sides = 1
    for _ in range(2000):
        low = (
            chance.choice([0, -1, 1]) * Rational(chance.getrandbits(80), 3) * Rational(10) ** chance.randint(-320, 250)
        )
        width = Rational(chance.getrandbits(80) + 1, 7) * Rational(10) ** chance.randint(-320, 250)
        if chance.random() < 0.3:
            width = (abs(low) or 1) * Rational(1, 10 ** chance.randint(0, 40))
        form._intervals = [(floated(low), floated(width))]
        start = chance.random() * 2.0 ** -chance.choice([0, 1, 30, 1000])
        end = min(1.0, start + chance.random() * 2.0 ** -chance.choice([0, 1, 30, 1000]))
        model = form._variable(0, np.array([[[start, end]]]), slopes=2)
        for t in (-1, Fraction(chance.getrandbits(20), 2**20), 1):
            share = Fraction(start) + (Fraction(end) - Fraction(start)) * (t + 1) / 2
            exact = Fraction(low.p, low.q) + Fraction(width.p, width.q) * share
            told = Fraction(float(model.c0[0, 0])) + Fraction(float(model.c1[0, 0, 0])) * t
            assert abs(exact - told) <= Fraction(float(model.r[0, 0]))
        slope = Fraction(width.p, width.q) * (Fraction(end) - Fraction(start)) / 2
        assert abs(slope - Fraction(float(model.c0[0, 1]))) <= Fraction(float(model.r[0, 1]))


# --- the search, on functions whose zeros are known ------------------------------------------------------------------


RISING = Form(lambda w, p, c: w - p.times(0.2) - c(0.3), 1)
FALLING = Form(lambda w, p, q, c: p.times(0.2) + q.times(-0.1) + c(0.4) - w, 2)
TWO = Form(lambda w, p, c: (w - p.times(0.05) - c(0.25)) * (w + p.times(0.1) - c(0.7)), 1)
BENT = Form(lambda w, p, c: w - c(0.3) - (p - c(0.4)) * (p - c(0.4)), 1)


def test_a_crossing_that_moves_one_way_lies_in_one_cluster_known_to_its_ends() -> None:
    [x] = clusters(RISING)  # at 0.3 + 0.2 p
    assert (x.signs, x.regular, x.inside) == ((1, -1), True, True)
    assert x.low <= 0.3 < x.low + 1e-9
    assert x.high - 1e-9 < 0.5 <= x.high
    [x] = clusters(FALLING)  # at 0.4 + 0.2 p - 0.1 q
    assert x.signs == (-1, 1, -1)
    assert x.low <= 0.3 < x.low + 1e-9
    assert x.high - 1e-9 < 0.6 <= x.high


def test_two_crossings_are_two_clusters_in_order_and_their_cells_hold_them() -> None:
    first, second = clusters(TWO)
    assert (first.signs, second.signs) == ((-1, 1), (1, 1))
    assert [first.low, first.high, second.low, second.high] == pytest.approx([0.25, 0.3, 0.6, 0.7], abs=0.02)
    assert first.low <= 0.25 < 0.3 <= first.high < second.low <= 0.6 < 0.7 <= second.high
    for p in np.linspace(0, 1, 23):
        for x, at in ((first, 0.25 + 0.05 * p), (second, 0.7 - 0.1 * p)):
            assert holds(x.cells, [at, p])


def holds(cells: np.ndarray, point: list[float]) -> bool:  # type: ignore[type-arg]
    return bool(((cells[:, :, 0] <= point) & (point <= cells[:, :, 1])).all(-1).any())


def test_crossings_that_merge_are_one_cluster_that_is_not_regular() -> None:
    touching = Form(lambda w, p, c: (w - c(0.5)) * (w - c(0.5)) - p.times(0.01), 1)  # at 0.5 -+ 0.1 sqrt p
    [x] = clusters(touching)
    assert (x.regular, x.signs[0]) == (False, 0)
    assert 0.38 < x.low <= 0.4
    assert 0.6 <= x.high < 0.62
    for p in np.linspace(0, 1, 13):
        assert all(holds(x.cells, [0.5 + s * 0.1 * sqrt(p), p]) for s in (-1, 1))


@pytest.mark.parametrize("sign", [1, -1])
def test_where_the_function_keeps_its_sign_there_is_no_cluster(sign: int) -> None:
    assert clusters(Form(lambda w, p, c: (w * w + p + c(0.1)).times(sign), 1)) == ()
    assert clusters(Form(lambda w, p, c: (w - p).times(sign), 1, is_zero=True)) == ()


def known_to(percent: int, name: str, under: str, also: tuple[str, ...] = ()) -> hs.Scene:
    """A shipped scene in which all numbers under a path, and others, are known to so many per cent."""
    scene = hs.load_scene(name)
    numbers = [x for x in scene.parameters if x.value and (x.path.startswith(under) or x.path in also)]
    off = Rational(percent, 100)
    return scene.with_values({x.path: [x.value * (1 - off), x.value * (1 + off)] for x in numbers})


def check_ends(scene: hs.Scene, drawn: int) -> list[tuple[bool, bool]]:
    """Ends that are said to be reached are crossings at their corners, none lies outside; which ends are reached."""
    found = tolerances(scene, samples=drawn)
    for one in found.samples:
        for name, crossings in one.crossings.items():
            own = [x for x in found.enclosures if x.criterion.name == name]
            assert all(any(float(y.low) <= float(x) <= float(y.high) for y in own) for x in crossings)
    for x in found.enclosures:
        for end, corner in ((x.low, x.at_low), (x.high, x.at_high)):
            if corner is not None:
                there = hs.evaluate(scene.with_values(corner)).crossings
                assert any(y.part is x.part and y.omega.digits(30) == end.digits(30) for y in there)
    return [(x.at_low is not None, x.at_high is not None) for x in found.enclosures]


@pytest.mark.slow
def test_an_end_lies_on_a_face_where_more_is_known_of_what_moves_it() -> None:
    """r_r of the paper's example moves one way over the whole box with omega_n alone, yet its high end is a corner."""
    scene = known_to(5, "fu2019", "environment", ("effects.filter.omega_n",))
    real = tolerances(scene, samples=0).enclosures[0]
    assert [name for name, sign in real.monotonic.items() if sign] == ["omega_n"]
    assert check_ends(scene, 40) == [(False, True), (True, True)]


@pytest.mark.slow
@pytest.mark.parametrize("under", ["effects", ""])
def test_ends_for_all_numbers_of_the_shipped_stick_are_reached_at_corners(under: str) -> None:
    """17 of ten effects, or all 20, known to 5 %: slopes are of first order then."""
    scene = known_to(5, "control-stick-in-detail", under)
    assert all(map(all, check_ends(scene, 60)))


def test_a_corner_that_was_not_answered_in_time_is_not_taken_for_one_without_a_crossing() -> None:
    box = box_of(hs.parse_scene(SPRING.format(model="delay", parameters='tau = ["18 ms", "22 ms"]', top=12, jnd=0.1)))

    def late(values: object) -> One:
        raise LimitError(1.0)

    asked = Face(box, "imag", {}, late)
    [cluster] = clusters(asked.form)
    for highest, share in ((False, cluster.low), (True, cluster.high)):
        found = asked.end(asked.form, cluster, highest=highest)
        assert found is not None
        assert (float(found[0]), found[1]) == (pytest.approx(12 * share, rel=1e-12), None)


@pytest.mark.slow
def test_when_the_time_is_over_on_a_face_its_cluster_is_the_bound(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = known_to(5, "fu2019", "environment", ("effects.filter.omega_n",))
    whole = tolerances(scene, samples=0).enclosures

    def late(box: Box, criterion: object) -> Excess:
        raise LimitError(1.0)

    monkeypatch.setattr("haptisym.verbs.tolerances.ends.excess_of", late)
    hurried = tolerances(scene, samples=0).enclosures
    for x, y in zip(whole, hurried, strict=True):
        assert float(y.low) <= float(x.low) < float(x.high) <= float(y.high)
    assert any(x.at_low is None or x.at_high is None for x in hurried)


def test_a_crossing_that_leaves_the_band_is_clear_of_the_other_end_alone() -> None:
    [out] = clusters(Form(lambda w, p, c: w - p.times(0.5) - c(0.7), 1))  # at 0.7 to 1.2
    assert (out.clear_of(highest=False), out.clear_of(highest=True), out.inside) == (True, False, False)
    assert out.low == pytest.approx(0.7, abs=1e-9)
    [down] = clusters(Form(lambda w, p, c: w - p.times(0.5) + c(0.2), 1))  # at -0.2 to 0.3
    assert (down.clear_of(highest=False), down.clear_of(highest=True), down.inside) == (False, True, False)
    assert down.high == pytest.approx(0.3, abs=1e-9)


def test_a_cluster_that_reaches_an_end_of_the_band_is_not_clear_of_it() -> None:
    for low, high, inside in ((0.0, 1.0, False), (0.0, 0.9, False), (0.1, 1.0, False), (1e-300, 1 - 2.0**-53, True), (-0.1, 0.9, False), (0.1, 1.1, False)):  # fmt: skip
        found = Cluster(np.zeros((1, 2, 2)), (0, 1), low, high)
        assert (found.clear_of(highest=False), found.clear_of(highest=True)) == (low > 0, high < 1)
        assert (found.inside, found.regular) == (inside, False)
    assert all(Cluster(np.zeros((1, 2, 2)), (n, 0), 0.1, 0.2).regular for n in (-1, 1))


def test_an_idle_parameter_hinders_nothing_and_an_unknown_piece_stays() -> None:
    idle = Form(lambda w, p, q, c: w - p.times(0.2) - c(0.3), 2, idle=(2,))
    [x] = clusters(idle)
    assert (x.signs, x.regular) == ((1, -1, 0), True)
    assert sum(map(len, idle.asked)) < 200
    unknown = Form(lambda w, p, c: w + p + c(0.1), 1, unknown=(0.6, 0.62))
    [x] = clusters(unknown)
    assert (x.low <= 0.6, x.high >= 0.62, x.regular) == (True, True, False)
    assert 0.5 < x.low < x.high < 0.75


def test_a_search_ends_within_its_budget_and_what_is_left_holds_all_crossings(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("haptisym.verbs.tolerances.search._MOST_CELLS", 300)
    waves = Form(lambda w, p, q, c: (w.times(20) + p * q).cosine_and_sine()[1] * (p - q + c(0.3)) + c(0.1), 2)
    found = clusters(waves)
    assert sum(map(len, waves.asked)) < 2000
    assert all(a.high < b.low for a, b in pairwise(found))
    random = np.random.default_rng(2)
    for w, p, q in random.uniform(0, 1, (3000, 3)):
        if abs(np.sin(20 * w + p * q) * (p - q + 0.3) + 0.1) < 1e-3:
            assert any(x.low - 1e-2 <= w <= x.high + 1e-2 for x in found)


def test_how_far_crossings_go_is_found_beyond_what_was_reached() -> None:
    """The root is 0.3 + (p - 0.4)^2: least, inside, 0.3 and largest, at p = 1, 0.66."""
    found = clusters(BENT)
    assert (found[0].low, found[-1].high) == (pytest.approx(0.3, abs=0.03), pytest.approx(0.66, abs=0.03))
    cells = np.concatenate([x.cells for x in found])
    assert beyond(BENT, cells, 0.67, highest=True) == 0.67
    assert beyond(BENT, cells, 0.2999, highest=False) == 0.2999
    assert beyond(BENT, cells, 0.65, highest=True) == pytest.approx(0.66, abs=2e-3)
    assert beyond(BENT, cells, 0.65, highest=True) >= 0.66
    assert beyond(BENT, cells, 0.31, highest=False) == pytest.approx(0.3, abs=2e-3)
    assert beyond(BENT, cells, 0.31, highest=False) <= 0.3
    assert beyond(BENT, cells, 0.6601, highest=True) == 0.6601


def test_without_budget_the_ends_of_the_cells_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("haptisym.verbs.tolerances.search._MOST_BEYOND", -1)
    cells = np.array([[[0.2, 0.5], [0, 1]], [[0.4, 0.8], [0, 1]]])
    assert beyond(BENT, cells, 0.6, highest=True) == 0.8
    assert beyond(BENT, cells, 0.3, highest=False) == 0.2


def test_what_is_known_of_cells_holds_in_them() -> None:
    random = np.random.default_rng(4)
    start = random.uniform(0, 0.8, (200, 2))
    width = random.uniform(0.001, 0.2, (200, 2))
    cells = np.stack([start, start + width], -1)
    for form, value, slope, move in (
        (BENT, lambda w, p: w - 0.3 - (p - 0.4) ** 2, lambda w, p: 1 + 0 * w, lambda w, p: -2 * (p - 0.4)),
        (TWO, lambda w, p: (w - 0.05 * p - 0.25) * (w + 0.1 * p - 0.7), lambda w, p: 2 * w + 0.05 * p - 0.95,
         lambda w, p: 0.1 * (w - 0.05 * p - 0.25) - 0.05 * (w + 0.1 * p - 0.7)),
    ):  # fmt: skip
        found = bounded(form, cells)
        w, p = (cells[:, i, :1] + (cells[:, i, 1:] - cells[:, i, :1]) * random.uniform(0, 1, (1, 400)) for i in (0, 1))
        for k, f in enumerate((value, slope, move)):
            sign, own = found.signs[:, k], f(w, p)
            assert ((sign[:, None] == 0) | (np.sign(own) == sign[:, None])).all()
            clear = np.abs(own).min(1) > 0.3 * np.ptp(own, axis=1) + 0.02
            assert (sign[clear & (np.ptp(np.sign(own), axis=1) == 0)] != 0).all()
        steep = found.signs[:, 1] != 0
        zero = np.abs(value(w, p)) < 1e-4
        assert (found.omega[:, 0] >= cells[:, 0, 0] - 1e-14).all()
        assert (found.omega[:, 1] <= cells[:, 0, 1] + 1e-14).all()
        inside = (found.omega[:, :1] - 1e-2 <= w) & (w <= found.omega[:, 1:] + 1e-2)
        assert inside[zero].all()
        narrower = (found.omega[:, 1] - found.omega[:, 0]) < 0.9 * width[:, 0]
        assert narrower[steep & (width[:, 0] > 0.1) & (width[:, 1] < 0.02)].all()
        assert set(found.split.tolist()) <= {0, 1}
    flat = np.array([[[0.2, 0.2], [0.0, 1.0]], [[0.2, 0.9], [0.5, 0.5]]])
    assert bounded(BENT, flat).split.tolist() == [1, 0]  # what has no width is not cut
    lower, upper = halves(cells[:3], np.array([0, 1, 0]))[:3], halves(cells[:3], np.array([0, 1, 0]))[3:]
    for i, side in enumerate((0, 1, 0)):
        assert lower[i, side, 1] == upper[i, side, 0] == cells[i, side].mean()
        assert (lower[i, side, 0], upper[i, side, 1]) == tuple(cells[i, side])
        assert (lower[i, 1 - side] == upper[i, 1 - side]).all()


def contracted(
    cell: list[list[float]], c0: float, c1: list[float], c2: list[list[float]], r: float, *slope: float
) -> list[float]:
    rows = (np.array([x], float) for x in (cell, c0, c1, c2, r, *slope))
    return _contracted(*rows)[0].tolist()


def test_crossings_in_a_cell_lie_where_a_line_of_the_least_or_the_greatest_slope_may_cross() -> None:
    """F = c0 + g t_0 + rest, the cell from 0.2 to 0.6: t_0 between -(c0 -+ rest)/g, and omega = 0.4 + 0.2 t_0."""
    cell, none = [[0.2, 0.6], [0, 1], [0, 1]], [[0.0] * 3] * 3
    for side in (1, -1):
        low, high = contracted(cell, 0.1, [2, side * 0.3, 0], none, 0.05, 2, 2)
        assert low <= 0.4 - 0.2 * 0.225 < 0.4 + 0.2 * 0.125 <= high
        assert [low, high] == pytest.approx([0.355, 0.425], abs=1e-12)
        mixed = [[5, 0.5, side * 0.7], [0.5, side * 0.04, 0.02], [0.7, -0.01, 0]]  # terms in t_0 are in the slope
        low, high = contracted(cell, 0.1, [2, side * 0.3, 0], mixed, 0.05, 2, 2)
        assert [low, high] == pytest.approx([0.4 - 0.1 * 0.52, 0.4 + 0.1 * 0.32], abs=1e-12)
        low, high = contracted(cell, side * 0.1, [2, 0.3, 0], none, 0.05, 2, 4)
        ends = sorted(-(side * 0.1 + x) / g for x in (-0.35, 0.35) for g in (2, 4))
        assert [low, high] == pytest.approx([0.4 + 0.2 * ends[0], 0.4 + 0.2 * ends[-1]], abs=1e-12)
        assert contracted(cell, 0.1, [2, 0.3, 0], none, 0.05, *sorted((-side, 2))) == pytest.approx(
            [0.2, 0.6] if side > 0 else [0.4 - 0.2 * 0.45, 0.4 + 0.2 * 0.25], abs=1e-12
        )
    assert contracted(cell, 0.1, [-2, 0.3, 0], none, 0.05, -2, -2) == pytest.approx([0.375, 0.445], abs=1e-12)
    for slope in ((0, 2), (-2, 0), (-1, 1), (-np.inf, np.inf), (np.nan, 1)):
        with np.errstate(all="ignore"):
            low, high = contracted(cell, 0.1, [2, 0.3, 0], none, 0.05, *slope)
        assert low <= 0.2 < 0.6 <= high
    with np.errstate(all="ignore"):
        low, high = contracted(cell, 0.1, [2, 0.3, 0], none, np.inf, 2, 2)
    assert low <= 0.2 < 0.6 <= high
    far = contracted(cell, 9.0, [2, 0.3, 0], none, 0.05, 2, 2)
    assert far == pytest.approx([0.2, 0.2], abs=1e-12)


def test_a_cell_is_clear_where_the_corner_with_the_least_or_the_greatest_value_is() -> None:
    cells = np.array([[[0.0, 1.0], [0.0, 1.0], [0.0, 1.0]]])

    def unclear(of: Callable[..., Model], *signs: int) -> bool:
        known = _Bounded(cells, np.array([[0, 0, *signs]]), cells[:, 0], np.array([0]))
        return bool(_unclear(Form(of, 2), known)[0])

    for sign in (1, -1):
        assert not unclear(lambda w, p, q, c, s=sign: (p + c(0.01)).times(s), sign, 0)  # least at p = 0: 0.01
        assert unclear(lambda w, p, q, c, s=sign: (p - c(0.01)).times(s), sign, 0)
        assert not unclear(lambda w, p, q, c, s=sign: (q - p + c(1.01)).times(s), -sign, sign)  # least at p = 1, q = 0
        assert not unclear(lambda w, p, q, c, s=sign: (q.times(0.1) - p + c(1.2)).times(s), -sign, 0)
        assert unclear(lambda w, p, q, c, s=sign: (q - p + c(0.9)).times(s), -sign, sign)
    told = _Bounded(cells, np.array([[1, 0, 0, 0]]), cells[:, 0], np.array([0]))
    assert not _unclear(Form(lambda w, p, q, c: w - p, 2), told)[0]


def test_cells_that_touch_hang_together_and_clusters_that_overlap_in_frequency_are_one() -> None:
    cells = np.array(
        [[[a, a + 1], [b, b + 1]] for a, b in ((0, 0), (5, 5), (1, 1), (2, 0), (7, 5), (6, 5), (0, 9))], float
    )
    assert together(cells).tolist() == [0, 1, 0, 0, 1, 1, 6]

    def cluster(low: float, high: float, *signs: int) -> Cluster:
        return Cluster(np.array([[[low, high], [0, 1]]]), signs, low, high)

    own = [cluster(0.1, 0.5, 1, -1), cluster(0.2, 0.3, 1, 1), cluster(0.5, 0.6, 1, -1), cluster(0.61, 0.7, -1, 1)]
    first, second = _apart(own)
    assert (first.low, first.high, first.signs, len(first.cells)) == (0.1, 0.6, (1, 0), 3)
    assert (second.low, second.high, second.signs) == (0.61, 0.7, (-1, 1))
    near = list(_apart([cluster(0.1, 0.2, 1, 1), cluster(0.2 + 0.5e-8, 0.3, 1, 1), cluster(0.3 + 2e-8, 0.4, 1, 1)]))
    assert [(x.low, x.high) for x in near] == [(0.1, 0.3), (0.3 + 2e-8, 0.4)]


@dataclass(frozen=True)
class Hurried(Form):
    """One whose time is over after so many questions."""

    questions: int = 0

    def model(self, cells: np.ndarray, *, slopes: int = 2) -> Model:  # type: ignore[type-arg]
        if len(self.asked) >= self.questions:
            raise LimitError(1.0)
        return super().model(cells, slopes=slopes)


@pytest.mark.parametrize("questions", [0, 1, 2, 3, 5])
def test_when_the_time_is_over_crossings_may_be_anywhere_in_what_is_left(questions: int) -> None:
    hurried = Hurried(TWO.of, 1, questions=questions)
    found = clusters(hurried)
    for p in np.linspace(0, 1, 11):
        for at in (0.25 + 0.05 * p, 0.7 - 0.1 * p):
            assert any(x.low <= at <= x.high and holds(x.cells, [at, p]) for x in found)
    if questions < 2:
        assert not any(x.regular for x in found)
    cells = np.concatenate([x.cells for x in clusters(BENT)])
    late = Hurried(BENT.of, 1, questions=questions)
    assert beyond(late, cells, 0.6, highest=True) >= 0.66
    assert beyond(Hurried(BENT.of, 1, questions=questions), cells, 0.32, highest=False) <= 0.3


def test_a_frequency_noticed_for_all_values_is_sought_between_the_clusters() -> None:
    box = box_of(hs.Scene(SOFT, (LAG,)))

    def between(form: Form, *ends: tuple[float, float]) -> float | None:
        own = tuple(Cluster(np.array([[[a, b], [0, 1]]]), (0, 0), a, b) for a, b in ends)
        answers = Tolerances(box, ())
        answers.__dict__["_search"] = dict.fromkeys(hs.Part, (form, own))
        return answers._exceeds_between(hs.Part.REAL)

    rising, falling = (Form(lambda w, p, c, s=s: (w - c(0.5)).times(s), 1, idle=(1,)) for s in (1, -1))
    assert between(rising, (0.48, 0.52)) == 0.52
    assert between(rising, (0.0, 0.1), (0.48, 0.52)) == 0.52
    assert between(rising, (0.48, 0.52), (0.3, 0.7)) == 0.7  # the second one starts before the first one ends
    assert between(rising, (0.48, 0.52), (0.49, 0.51)) == 0.52
    assert between(rising, (0.48, 1.0)) is None
    assert between(falling, (0.48, 0.52)) == 0.0
    assert between(falling, (0.0, 0.52)) is None
    assert between(falling, (0.0, 0.2), (0.48, 0.52)) == 0.2
    assert between(Form(lambda w, p, c: w + c(1.0), 1, is_zero=True)) is None
    assert between(Form(lambda w, p, c: w + c(1.0), 1)) == 0.0
    assert between(Form(lambda w, p, c: w - c(2.0), 1)) is None
    assert between(Hurried(lambda w, p, c: w + c(1.0), 1)) is None


# --- whole answers, solved by hand -----------------------------------------------------------------------------------


def test_with_a_band_from_above_zero_ends_and_bandwidth_are_those_of_the_crossing() -> None:
    [low, high] = [w * (5 - sqrt(24)) for w in (36, 44)]
    found = tolerances(hs.Scene(SOFT, (LAG,), (2, 10)), samples=0)
    [x] = found.enclosures
    assert [float(x.low), float(x.high)] == pytest.approx([low, high], rel=1e-14)
    assert (x.count, x.part, dict(x.monotonic)) == (1, hs.Part.IMAG, {"k": 0, "omega_c": 1})
    assert [float(x) for x in found.bandwidth] == pytest.approx([low, high], rel=1e-14)
    assert (found.verdict, found.certified) == (Verdict.NONE, True)
    within = tolerances(hs.Scene(SOFT, (LAG,), (2, 3)), samples=0)
    assert (within.verdict, [float(x) for x in within.bandwidth], within.enclosures) == (Verdict.ALL, [3, 3], ())
    assert (within.transparent.values.keys(), within.noticed) == ({"k", "omega_c"}, None)
    started = tolerances(hs.Scene(SOFT, (LAG,), (5, 10)), samples=0)
    assert (started.verdict, started.bandwidth, started.enclosures) == (Verdict.NONE, None, ())
    assert (started.transparent, started.noticed.transparent, started.noticed.bandwidth) == (None, False, None)
    some = tolerances(hs.Scene(SOFT, (LAG,), (4, 10)), samples=0)  # the low end lies within the enclosure
    assert (some.bandwidth, some.enclosures[0].count) == (None, None)
    assert some.nominal.bandwidth is not None
    edge = tolerances(hs.Scene(SOFT, (LAG,), (2, 4)), samples=0)
    assert (edge.verdict, edge.enclosures[0].count) == (Verdict.DEPENDS, None)
    assert [float(x) for x in edge.bandwidth] == [pytest.approx(low, rel=1e-14), 4]
    assert (edge.transparent.transparent, edge.noticed.transparent) == (True, False)


@pytest.mark.parametrize("low", [0, 1])
def test_an_end_that_no_corner_reaches_is_a_bound_a_thousandth_beyond_at_most(low: int) -> None:
    """r_i = omega T (1 + p^2): its crossing is highest at p = 0, which is no corner, and lowest at p = 2."""
    effect = hs.effects.series("1 + s*T*(1 + p^2)", parameters={"T": "10 ms", "p": [-1, 2]})
    spring = hs.environments.mass_spring_damper(k=100)
    found = tolerances(hs.Scene(spring, (effect,), (low, 20)), samples=0)
    [x] = found.enclosures
    assert (x.part, x.monotonic["p"]) == (hs.Part.IMAG, 0)
    assert 10 <= float(x.high) <= 10 * 1.002
    assert 2 * 0.998 <= float(x.low) <= 2
    assert (x.at_low, x.at_high) == (None, None)
    assert x.count == 1
    assert float(found.bandwidth[0]) == float(x.low)


def test_of_two_crossings_each_has_its_enclosure_and_the_bandwidth_ends_at_the_first() -> None:
    """1 + a s/(s^2 + 2 s + 9) on a spring: r_r = 2 a w^2/((9 - w^2)^2 + 4 w^2), up to a/2 at 3: it comes and goes."""
    effect = hs.effects.series("1 + a*s/(s^2 + 2*s + 9)", parameters={"a": ["0.3", "0.4"]})
    scene = hs.Scene(hs.environments.mass_spring_damper(k=100), (effect,), (0, 9), hs.Threshold.of("0.1", 1))
    found = tolerances(scene, samples=6)
    first, second = found.enclosures
    assert [x.count for x in (first, second)] == [1, 1]
    assert [dict(x.monotonic) for x in (first, second)] == [{"a": -1}, {"a": 1}]

    def ends(a: float) -> list[float]:
        """(9 - x)^2 + 4 x = 20 a x with x = w^2."""
        b = 14 + 20 * a
        return [sqrt((b + s * sqrt(b * b - 324)) / 2) for s in (-1, 1)]

    expected = [ends(0.4)[0], ends(0.3)[0], ends(0.3)[1], ends(0.4)[1]]
    assert [float(x) for x in (first.low, first.high, second.low, second.high)] == pytest.approx(expected, rel=1e-13)
    assert [float(x) for x in found.bandwidth] == pytest.approx(expected[:2], rel=1e-13)
    assert all(len(x.crossings["real"]) == 2 for x in found.samples)
    told = found.to_dict()
    assert [x["count"] for x in told["crossings"]] == [1, 1]
    for row, x in zip(told["crossings"], (first, second), strict=True):
        assert row["omega"] == [float(x.low), float(x.high)]
        assert float(row["enclosure"][0]) <= row["omega"][0] < row["omega"][1] <= float(row["enclosure"][1])
        assert row["reached_at"] == {"low": {"a": str(x.at_low["a"])}, "high": {"a": str(x.at_high["a"])}}
    assert told["varying"] == [{"name": "a", "low": 0.3, "high": 0.4}]
    assert told["witnesses"]["transparent"] is None
    assert told["witnesses"]["noticed"] == {"a": "7/20"}
    assert (told["estimates"]["samples"], told["certified"]) == (6, True)
    assert tolerances(scene, samples=0).to_dict()["estimates"] is None


def test_one_part_may_be_noticed_for_all_values_where_the_other_is_for_none() -> None:
    """A mass of 1 kg on 100 N/m: r_r = w^2/100, c at sqrt(10); r_i = b w/100 is at most 0.03."""
    device = hs.effects.shunt(m="1 kg +- 10 %", b="0.2 N*s/m")
    scene = hs.Scene(hs.environments.mass_spring_damper(k=100), (device,), (0, 15))
    found = tolerances(scene, samples=0)
    [x] = found.enclosures
    assert (x.part, x.count, dict(x.monotonic)) == (hs.Part.REAL, 1, {"m": -1})
    assert [float(x.low), float(x.high)] == pytest.approx([sqrt(10 / 1.1), sqrt(10 / 0.9)], rel=1e-14)
    assert x.at_high["m"] == Rational(9, 10)
    assert [float(x) for x in found.bandwidth] == [float(x.low), float(x.high)]
    assert found.verdict is Verdict.NONE


def test_thresholds_that_vary_move_the_crossings_of_their_own_part() -> None:
    """Behind a delay r_i = sin(omega tau) and r_r = 2 sin(omega tau/2)^2."""
    late = hs.effects.delay("10 ms")
    spring = hs.environments.mass_spring_damper(k=100)
    scene = hs.Scene(spring, (late,), (0, 60), hs.Threshold.of("0.1", ["0.08", "0.12"]))
    imag, real = tolerances(scene, samples=3).enclosures
    assert (imag.part, real.part) == (hs.Part.IMAG, hs.Part.REAL)
    assert [float(imag.low), float(imag.high)] == pytest.approx([np.arcsin(x) * 100 for x in (0.08, 0.12)], rel=1e-13)
    at = 2 * np.arcsin(sqrt(0.05)) * 100
    assert [float(real.low), float(real.high)] == pytest.approx([at, at], rel=1e-13)
    assert (imag.monotonic["c_imag"], real.monotonic["c_imag"]) == (1, 0)
    found = tolerances(hs.Scene(spring, (late,), (0, 60), hs.Threshold.of("0.1 +- 10 %", "0.3 +- 10 %")), samples=0)
    assert found.nominal.values == {"c_real": Rational(1, 10), "c_imag": Rational(3, 10)}
    assert sorted(float(x.low) for x in found.enclosures) == pytest.approx(
        [np.arcsin(0.27) * 100, 2 * np.arcsin(sqrt(0.045)) * 100], rel=1e-13
    )


def test_a_set_that_is_noticed_from_the_band_s_beginning_has_no_bandwidth_though_it_is_transparent_later() -> None:
    """A pole at 0.1 rad/s behind a spring: r_i is 0.1/omega, above 10 % up to 1 rad/s, then below."""
    spring = hs.environments.mass_spring_damper(k=["99 N/m", "101 N/m"])
    late = hs.Scene(spring, (hs.effects.series("1 + 1/(10*s)"),), ("0.5", 5))
    found = single.one(box_of(late), {})
    assert found.bandwidth is None
    assert found.transparent is False
    assert [float(x) for x in found.crossings["imag"]] == [pytest.approx(1)]
    assert single.one(box_of(late.with_band(2, 5)), {}).transparent is True


def one(first: float | None, bandwidth: float | None, transparent: bool | None = False) -> One:  # noqa: FBT001, FBT002
    exact = {x: None if x is None else ExactNumber(Rational(x)) for x in (first, bandwidth)}
    crossings = {hs.Part.REAL: () if first is None else (exact[first],), hs.Part.IMAG: ()}
    return One({}, crossings, exact[bandwidth], transparent)


def test_quantiles_are_values_that_so_many_per_cent_do_not_exceed() -> None:
    def of(*samples: One) -> Quantiles:
        return quantiles(samples)

    twenty = of(*(one(21 - n, 2 * n) for n in range(1, 21)))
    assert (twenty.first, twenty.bandwidth) == ({5: 1, 50: 10, 95: 19}, {5: 2, 50: 20, 95: 38})
    some = of(one(3, None), one(None, 8, transparent=True), one(5, 6, transparent=None), one(None, None))
    assert some.first == {5: 3, 50: 5, 95: None}  # without a crossing it lies beyond the band
    assert some.bandwidth == {5: None, 50: None, 95: 8}  # without a bandwidth it is less than any
    assert some.transparent == 1
    alone = of(one(-4, 7))
    assert (alone.first, alone.bandwidth) == ({5: -4, 50: -4, 95: -4}, {5: 7, 50: 7, 95: 7})


def test_the_first_crossing_is_the_lowest_of_either_part() -> None:
    numbers = {x: ExactNumber(Rational(x)) for x in (3, 4, 5)}
    own = {hs.Part.REAL: (numbers[4], numbers[5]), hs.Part.IMAG: (numbers[3],)}
    assert One({}, own, None, None).first is numbers[3]
    assert One({}, {hs.Part.REAL: (), hs.Part.IMAG: ()}, None, None).first is None


def test_touches_are_no_crossings_of_a_set_of_values() -> None:
    """1 + a s/(s^2 + 2 s + 9) with a = 0.2 touches r_r = 0.1 at 3 rad/s."""
    effect = hs.effects.series("1 + a*s/(s^2 + 2*s + 9)", parameters={"a": ["0.2", "0.4"]})
    scene = hs.Scene(hs.environments.mass_spring_damper(k=100), (effect,), (0, 9), hs.Threshold.of("0.1", 1))
    answers = tolerances(scene, samples=0)
    at = answers.one({"a": Rational(1, 5)})
    assert (at.crossings["real"], at.transparent, float(at.bandwidth)) == ((), True, 9)
    above = answers.one({"a": Rational(3, 10)})
    assert (len(above.crossings["real"]), above.transparent) == (2, False)
    assert float(above.bandwidth) == float(above.crossings["real"][0])


@pytest.mark.parametrize("samples", [-1, 2.5, "9"])
def test_samples_must_be_a_whole_number(samples: object) -> None:
    with pytest.raises(hs.SceneError, match="samples"):
        tolerances(hs.Scene(SOFT, (LAG,)), samples=samples)
