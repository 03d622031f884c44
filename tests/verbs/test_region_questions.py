"""Questions beside the evaluation, asked with other JND regions than the square: answered exactly, or refused."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from random import Random
from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from jnds import jnds
from marks import often
from matplotlib.figure import Figure
from regions import enlarged, margin, outside
from sympy import Rational, lambdify, symbols
from valuesets import ends

import haptisym as hs
from haptisym.figures import requirement as requirement_charts
from haptisym.figures.layers import draw
from haptisym.judge.bindings import Kind
from haptisym.kernel.rings import omega
from haptisym.kernel.sets import SingleValue
from haptisym.pages.derive import when_of_region
from haptisym.writing.boxes import Name
from haptisym.writing.code import Language, scene_code
from haptisym.writing.document import Equations

PAPER = hs.load_scene("fu2019")
ELLIPSE = {"shape": "ellipse", "real": 0.1, "imag": 0.12, "tilt": 0.5}
DIAMOND = {"shape": "diamond", "real": 0.1, "imag": 0.12}
POLYGON = {"shape": "polygon", "corners": [[0.1, 0], [0, 0.1], [-0.1, 0], [0, -0.1]]}
FLOOR = {"real": 0.1, "imag": 0.1, "floor": 15}
SIDED = {"real": {"higher": 0.08, "lower": 0.12}, "imag": 0.1}
FORMULA = "0.08 + 0.004*omega"


def with_jnd(jnd: Any, **values: Any) -> hs.Scene:
    return hs.Scene(PAPER.environment, PAPER.effects, PAPER.band, jnd).with_values(values)


def change(omega_n: float, omega: float) -> tuple[float, float]:
    """Re and Im of dH/|H_env| of the paper's example with another filter, written out."""
    s = 1j * omega
    H = 1.8 * s**2 + 15 * s + 100
    d = H * (omega_n**2 / (s**2 + omega_n * s + omega_n**2) - 1) / abs(H)
    return d.real, d.imag


PENTAGON = {
    "shape": "polygon",
    "corners": [[0.12, 0], [0.05, 0.1], [-0.1, "0.07 + omega/500"], [-0.09, -0.08], [0.06, -0.1]],
}
NARROW = {"real": {"higher": 0.01, "lower": 0.02}, "imag": {"higher": "0.05 + omega/200", "lower": 0.2}, "floor": 3}
REQUIRED = {
    "ellipse": ELLIPSE, "diamond": DIAMOND, "formula": {**ELLIPSE, "imag": FORMULA}, "polygon": POLYGON,
    "moving polygon": PENTAGON, "floor": FLOOR, "limits for each way": SIDED, "both": NARROW,
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.few("limits for each way")
@pytest.mark.parametrize("name", often(REQUIRED, lambda name: name in ("ellipse", "polygon", "limits for each way")))
def test_a_requirement_is_where_a_scan_of_the_band_leaves_the_region(name: str) -> None:
    jnd = REQUIRED[name]
    found = hs.require(with_jnd(jnd), "omega_n")
    [span] = found.feasible
    end = float(span.low)  # type: ignore[arg-type]
    [bound] = [x.omega for x in span.first.bindings]
    band = [*np.linspace(1e-3, 15, 1001), float(bound)]  # type: ignore[arg-type]

    def worst(omega_n: float) -> float:
        return max(noticed(jnd, omega_n, w) for w in band)

    assert worst(end * (1 + 1e-7)) < 0 < worst(end * (1 - 1e-7))
    assert span.high is None


def test_where_two_limits_meet_a_requirement_binds_at_a_corner_that_no_slope_tells() -> None:
    """A mass too much: the change omega^2 dm reaches the limit for lower just where the magnitude stops to shrink."""
    jnd = {"real": {"higher": 0.3, "lower": "1/20"}, "imag": 0.5}
    scene = hs.Scene(hs.environments.mass_spring_damper(1, 15, 100), (hs.effects.shunt(m=0.1),), (0, 25), jnd)
    found = hs.require(scene, "shunt.m", ("0.001", "0.9"))
    [span] = found.feasible
    [binding] = span.last.bindings
    assert binding.kind.value == "tangency"
    m, w = float(span.high), float(binding.omega)  # type: ignore[arg-type]
    env, perc = 100 - w**2, 100 - (1 + m) * w**2
    assert perc == pytest.approx(-env, rel=1e-12)  # as large as it was
    assert m * w**2 / abs(100 - w**2 + 15j * w) == pytest.approx(1 / 20, rel=1e-12)


@pytest.mark.slow
def test_with_a_delay_a_corner_is_known_to_any_digits() -> None:
    jnd = {"real": {"higher": 0.3, "lower": "1/20"}, "imag": 5}
    late = hs.Scene(
        hs.environments.mass_spring_damper(1, 15, 100), (hs.effects.shunt(m="1/25"), hs.effects.delay("1 ns")), (0, 25), jnd
    )  # fmt: skip
    found = hs.require(late, "shunt.m", ("0.0755", "0.0775"), digits=30)
    [span] = found.feasible
    [binding] = span.last.bindings
    m, w = (complex(x.digits(30)) for x in (span.high, binding.omega))  # type: ignore[union-attr]
    H = 100 - w**2 + 15j * w
    G = (H - m * w**2) * np.exp(-1e-9j * w)
    assert abs(G.real) == pytest.approx(abs(H.real), rel=1e-9)
    assert abs((G - H).real) == pytest.approx(abs(H) / 20, rel=1e-9)


@pytest.mark.slow
@pytest.mark.few("polygon", "lower")
@pytest.mark.parametrize(
    ("jnd", "condition"),
    [
        ({"shape": "polygon", "corners": [[0.1, 0], [0, 0.2], [-0.1, 0], [0, -0.2]]}, lambda x, y: 10 * x + 5 * y - 1),
        ({"shape": "diamond", "real": 0.3, "imag": 0.12}, lambda x, y: x / 0.3 + y / 0.12 - 1),
        ({"shape": "ellipse", "real": 0.1, "imag": 0.12}, lambda x, y: (x / 0.1) ** 2 + (y / 0.12) ** 2 - 1),
        ({"real": {"higher": 0.08, "lower": 0.02}, "imag": 0.3}, lambda x, _: x - 0.02),
    ],
    ids=["polygon", "diamond", "ellipse", "lower"],
)
def test_a_delay_of_a_spring_may_be_as_long_as_its_turn_stays_in_the_region_at_the_end_of_the_band(
    jnd: Any, condition: Any
) -> None:
    """exp(-j a) is 1 - x - j y with x = 1 - cos a and y = sin a: all delays that are longer leave it at some frequency."""
    late = hs.Scene(hs.environments.mass_spring_damper(k=100), (hs.effects.delay("5 ms"),), (0, 15), jnd)
    found = hs.require(late, "tau")
    angle = mpmath.findroot(lambda a: condition(1 - mpmath.cos(a), mpmath.sin(a)), (0.05, 0.2), solver="anderson")
    assert all(
        float(low) > 1000 for low, _ in ((p.low, p.high) for p in found.undecided)
    )  # seconds, thousands of turns within the band
    [span] = found.feasible
    assert (float(span.low), span.closed[0], span.closed[1]) == (0, True, True)
    assert float(span.high) == pytest.approx(float(angle) / 15, rel=1e-13)
    assert {b.kind for b in span.last.bindings} == {Kind.EDGE}


@pytest.mark.parametrize(
    ("formula", "expected"), [("g/(10*(g - 2))", [(None, 4 / 3)]), ("g/(10*(g + 2))", [(-4 / 3, None)])]
)
def test_with_a_limit_for_each_way_a_quotient_that_changes_its_sign_is_judged_on_both_sides_of_its_pole(
    formula: str, expected: list[Any]
) -> None:
    """From 20 % lower to 10 % higher: -2 <= g/(g - 2) <= 1."""
    gain = hs.effects.series(f"1 + {formula}", parameters={"g": "1/10"})
    jnd = {"real": {"higher": "0.1", "lower": "0.2"}, "imag": "0.1"}
    found = hs.require(hs.Scene(hs.environments.mass_spring_damper(k=100), (gain,), (0, 10), jnd), "g")
    assert found.certified
    assert ends(found) == [tuple(x and pytest.approx(x, rel=1e-14) for x in pair) for pair in expected]


def test_a_free_limit_leaves_a_floor_as_it_is() -> None:
    """With 15 N/m the change of the real part, 14.1 N/m at most below 8.2 rad/s, is felt whatever c is only beyond."""
    scene = with_jnd(FLOOR)
    [span] = hs.require(scene, "jnd.real", part=hs.Part.REAL).feasible
    c = float(span.low)  # type: ignore[arg-type]
    band = np.linspace(1e-3, 15, 20001)
    s = 1j * band
    H = 1.8 * s**2 + 15 * s + 100
    x = abs((H * (6400 / (s**2 + 80 * s + 6400) - 1)).real)
    assert c == pytest.approx(max((x / abs(H))[x > 15]), rel=1e-6)


@pytest.mark.few("formula")
@pytest.mark.parametrize("name", ["ellipse", "floor", "formula"])
def test_the_curve_over_a_free_limit_meets_1_where_the_set_ends(name: str) -> None:
    jnd = {**REQUIRED, "formula": FORMULA, "ellipse": {**ELLIPSE, "imag": 0.1}}[name]
    found = hs.require(with_jnd(jnd), "jnd")
    [end] = [float(x.value) for x in found.ends]  # type: ignore[arg-type]
    lines = draw(Figure().add_subplot(), requirement_charts.requirement(found))
    at = [np.interp(end, line.get_xdata(), line.get_ydata()) for line in lines]
    assert max(at) == pytest.approx(1, abs=2e-3)


@pytest.mark.slow
@given(jnds(), st.integers(0, 10**6))
def test_any_region_binds_a_requirement_where_plain_arithmetic_says_so(jnd: dict[str, Any], n: int) -> None:
    m, b, k, lag = 0.5 + n % 3, 1 + n % 7, 20 + n % 101, 15 + n % 53
    path = ["omega_c", "environment.k", "shunt.m"][n % 3]
    display = (hs.effects.shunt(m="3/50"), hs.effects.first_order_lag(lag))
    scene = hs.Scene(hs.environments.mass_spring_damper(m, b, k), display, (0, 12), jnd)
    own = scene.knobs[path].value
    found = hs.require(scene, path, (own / 4, own * 4))
    marks = [float(x.omega) for end in found.ends for x in end.bindings if x.omega is not None]
    band = [x for w in [0.0, *marks] for x in w + np.linspace(-1e-2, 1e-2, 201) if 0 < x <= 12] + [
        *np.linspace(0.01, 12, 400)
    ]

    def worst(value: float) -> float:
        dm, rate, stiff = (
            {path: value}.get(x, y) for x, y in (("shunt.m", 0.06), ("omega_c", lag), ("environment.k", k))
        )
        margins = []
        for w in band:
            H = m * (1j * w) ** 2 + b * 1j * w + stiff
            margins.append(margin(jnd, H, (H - dm * w**2) * rate / (1j * w + rate), w))
        return max(margins)

    ends = [float(end.value) for end in found.ends]  # type: ignore[arg-type]
    for value in [float(own) / 3.3, float(own) * 1.07, *(x * share for x in ends for share in (1 - 1e-4, 1 + 1e-4))]:
        if not float(own) / 4 < value < float(own) * 4 or abs(by := worst(value)) < 1e-5:
            continue
        inside = any(float(x.low) <= value <= float(x.high) for x in found.feasible)  # type: ignore[arg-type]
        assert inside == (by < 0) or (inside is False and by < 0 and by > -2e-3 and not marks), (value, by)


@pytest.mark.dear("ellipse")
@pytest.mark.parametrize("shape", ["ellipse", "diamond"])
def test_a_free_threshold_of_a_region_is_how_many_times_that_of_one_must_be_enlarged(shape: str) -> None:
    unit = (
        {"shape": shape, "real": 1, "imag": 1, "tilt": 0.5}
        if shape == "ellipse"
        else {"shape": shape, "real": 1, "imag": 1}
    )
    [span] = hs.require(with_jnd(unit), "jnd").feasible
    end = float(span.low)  # type: ignore[arg-type]
    scaled = {**unit, "real": end, "imag": end}
    found = max(outside(scaled, *change(80, w), w) for w in np.linspace(1e-3, 15, 3001))
    assert found == pytest.approx(0, abs=1e-9)


def noticed(jnd: dict[str, Any], omega_n: float, omega: float) -> float:
    """By how much a change of the paper's example is noticed."""
    s = 1j * omega
    H = 1.8 * s**2 + 15 * s + 100
    return margin(jnd, H, H * omega_n**2 / (s**2 + omega_n * s + omega_n**2), omega)


MOVED = {
    "ellipse": (ELLIPSE, 0), "formula": (FORMULA, 0), "diamond": (DIAMOND, 0), "polygon": (POLYGON, 0), "floor": (FLOOR, 0),
    "limit for higher": (SIDED, 0), "limit that jumps": (SIDED, 1), "moving polygon": (PENTAGON, 0),
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.few(2)
@pytest.mark.parametrize("name", often(MOVED, lambda name: name in ("ellipse", "diamond", "floor", "limit that jumps")))
def test_slopes_are_those_of_certified_crossings_nearby(name: str) -> None:
    jnd, n = MOVED[name]
    moved = hs.sensitivity(with_jnd(jnd)).crossings[n]
    assert moved.parameters
    for row in moved.parameters:
        step = Rational(1, 10**8)
        value = with_jnd(jnd).knobs[row.path].value
        low, high = (
            sum(hs.evaluate(with_jnd(jnd, **{row.path: value * (1 + sign * step)})).crossings[n].omega.bounds(200)) / 2
            for sign in (-1, 1)
        )
        slope = (high - low) / (2 * Fraction(str(value * step)))
        assert float(row.derivative) == pytest.approx(float(slope), rel=1e-9)  # type: ignore[arg-type]


def test_a_disc_keeps_the_laws_of_units_that_the_square_keeps() -> None:
    """Force in other units moves no crossing, time in other units moves all of them alike."""
    [first] = hs.sensitivity(with_jnd(ELLIPSE)).crossings
    e = {x.name: float(x.elasticity) for x in first.parameters}  # type: ignore[arg-type]
    assert e["m"] + e["b"] + e["k"] == pytest.approx(0, abs=1e-14)
    assert e["b"] + 2 * e["k"] + e["omega_n"] == pytest.approx(1, abs=1e-14)


def test_peaks_of_an_ellipse_are_where_it_must_be_enlarged_most() -> None:
    spring = hs.Scene(
        hs.environments.mass_spring_damper(k=100), (hs.effects.series("1 + 0.4*s/(s^2 + 2*s + 9)"),), (0, 15),
        {"shape": "ellipse", "real": 0.1, "imag": 0.1},
    )  # fmt: skip
    [peak] = hs.peaks(spring)
    assert (peak.criterion.name, peak.omega.digits(5), peak.ratio.digits(5)) == ("joint", "3.0000", "2.0000")


def test_peaks_of_a_diamond_are_those_of_a_dense_scan() -> None:
    filters = (hs.effects.series("1 + 0.4*s/(s^2 + 2*s + 9) - 0.2*s/(s^2 + 3*s + 60)"),)
    scene = hs.Scene(hs.environments.mass_spring_damper(1, 3, 20), filters, (0, 15), DIAMOND)
    band = np.linspace(0.01, 14.99, 300001)
    s = 1j * band
    H = s**2 + 3 * s + 20
    d = H * (0.4 * s / (s**2 + 2 * s + 9) - 0.2 * s / (s**2 + 3 * s + 60)) / abs(H)
    times = abs(d.real) / 0.1 + abs(d.imag) / 0.12
    tops = np.flatnonzero((times[1:-1] > times[:-2]) & (times[1:-1] > times[2:])) + 1
    found = hs.peaks(scene)
    assert [float(x.omega) for x in found] == pytest.approx(band[tops], abs=1e-4)
    assert [float(x.ratio) for x in found] == pytest.approx(times[tops], rel=1e-8)


PEAKED = {
    "polygon": PENTAGON, "floor": {"real": 0.1, "imag": 0.1, "floor": "1 + omega/5"}, "limits for each way": SIDED, "both": NARROW,
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.few("limits for each way")
@pytest.mark.parametrize("name", PEAKED)
def test_peaks_are_where_the_region_must_be_enlarged_most_by_a_dense_scan(name: str) -> None:
    jnd = PEAKED[name]
    filters = (hs.effects.series("1 + 0.4*s/(s^2 + 2*s + 9) - 0.2*s/(s^2 + 3*s + 60)"),)
    scene = hs.Scene(hs.environments.mass_spring_damper(1, 3, 20), filters, (0, 15), jnd)
    band = np.linspace(0.01, 14.99, 6001)
    s = 1j * band
    H = s**2 + 3 * s + 20
    G = H * (1 + 0.4 * s / (s**2 + 2 * s + 9) - 0.2 * s / (s**2 + 3 * s + 60))
    found = hs.peaks(scene)
    scanned = [enlarged(jnd, *row) for row in zip(H, G, band, strict=True)]
    checked = 0
    for part in scanned[0]:
        times = np.array([x[part] for x in scanned])
        tops = np.flatnonzero((times[1:-1] > times[:-2]) & (times[1:-1] > times[2:])) + 1
        own = [x for x in found if x.criterion.name == part and x.in_limits]
        if not own and part in jnd and not isinstance(jnd[part], dict):
            continue  # the ratio itself, as of the square
        checked += 1
        assert [float(x.omega) for x in own] == pytest.approx(band[tops], abs=4e-3)
        assert [float(x.ratio) for x in own] == pytest.approx(times[tops], rel=4e-3)
    assert checked


def test_a_peak_where_the_limit_changes_is_said_to_be_one() -> None:
    scene = hs.Scene(hs.environments.mass_spring_damper(1, 15, 100), (hs.effects.shunt(m=0.1),), (0, 25), {
        "real": {"higher": 0.3, "lower": "1/20"}, "imag": 0.5})  # fmt: skip
    [peak] = [x for x in hs.peaks(scene) if x.jump]
    w = float(peak.omega)
    assert 100 - w**2 == pytest.approx(-(100 - 1.1 * w**2), rel=1e-12)
    assert float(peak.ratio) == pytest.approx(0.1 * w**2 / abs(100 - w**2 + 15j * w) * 20, rel=1e-12)
    [row] = [x for x in hs.peaks(scene).to_dict()["peaks"] if "limit" in x]
    assert row["limit"] == "changes"
    assert "r_r over its limit" in str(hs.peaks(scene))
    assert "the limit changes" in str(hs.peaks(scene))


def test_several_environments_take_a_region() -> None:
    family = hs.SceneFamily({"paper": with_jnd(ELLIPSE), "heavy": with_jnd(ELLIPSE, m="3 kg")})
    found = hs.evaluate_all(family)
    alone = [float(hs.evaluate(x).bandwidth or 0) for x in family.scenes.values()]
    assert float(found.bandwidth or 0) == min(alone)
    assert {x.criterion.name for x in found.binding} == {"joint"}


DISC = {"shape": "ellipse", "real": 0.1, "imag": 0.1}


def told(d: hs.Derivation, name: str) -> list[Any]:
    """The formulas that a derivation has for names that begin so."""
    lines = [line for block in when_of_region(d).blocks if isinstance(block, Equations) for line in block.lines]
    return [line.value for line in lines if isinstance(line.left, Name) and line.left.text.startswith(name)]


@pytest.mark.slow
def test_a_disc_behind_a_filter_has_its_crossing_as_a_formula() -> None:
    """The paper's example: 7.922311857140609 rad/s."""
    [form] = told(hs.derive(with_jnd(DISC), ["omega_n", "zeta"]), "omega_joint")
    wn, zeta = symbols("omega_n zeta", positive=True)
    assert float(form.subs({wn: 80, zeta: Rational(1, 2)})) == pytest.approx(7.922311857140609, rel=1e-15)
    assert told(hs.derive(with_jnd(ELLIPSE), ["zeta"]), "omega_joint") == []


@pytest.mark.few("{'shape': 'diamond', 'real': 0.1, 'imag': 0.12}")
@pytest.mark.parametrize("jnd", [DIAMOND, POLYGON, SIDED, {"real": 0.1, "imag": 0.12, "floor": 3}], ids=str)
def test_each_crossing_behind_a_delay_is_among_the_solutions_or_where_a_limit_changes(jnd: Any) -> None:
    spring = hs.environments.mass_spring_damper(k=100)
    scene = hs.Scene(spring, (hs.effects.delay("10 ms"),), (0, 500), jnd)
    at = {"tau": Rational(1, 100), "k": 100}
    found = [float(x.subs({y: at[y.name] for y in x.free_symbols})) for x in told(hs.derive(scene), "omega_")]
    assert found
    for c in hs.evaluate(scene).to_dict()["crossings"]:
        once = [(c["omega"] - x) / 628.3185307179587 % 1 for x in found]
        assert c.get("limit") == "changes" or min(min(x, 1 - x) for x in once) < 1e-9, c


@pytest.mark.dear("polygon")
@pytest.mark.few("polygon", "diamond")
@pytest.mark.parametrize("jnd", [ELLIPSE, DIAMOND, POLYGON, PENTAGON], ids=["ellipse", "diamond", "polygon", "moving"])
def test_the_border_of_a_region_is_derived_as_it_is_defined(jnd: dict[str, Any]) -> None:
    names = [*symbols("x_r x_i", real=True), omega]
    borders = [lambdify(names, f) for f in told(hs.derive(with_jnd(jnd), ["zeta"]), "q_")]
    assert borders
    for x, y, w in np.random.default_rng(3).uniform((-0.2, -0.2, 0), (0.2, 0.2, 15), (200, 3)):
        assert (max(f(x, y, w) for f in borders) > 0) == (outside(jnd, x, y, w) > 0)


@pytest.mark.slow
@pytest.mark.few("Language.C", "Language.NUMPY")
@pytest.mark.parametrize("language", Language)
def test_generated_code_is_the_same_for_every_region(language: Language) -> None:
    """It has the dynamics, the distortion and the ratios: what is judged of them is not in it."""
    square = scene_code(PAPER, language)
    for jnd in (ELLIPSE, DIAMOND, POLYGON, FLOOR, SIDED, FORMULA):
        own = hs.Scene(
            PAPER.environment, PAPER.effects, PAPER.band, jnd, title=PAPER.title, source=PAPER.source
        )  # fmt: skip
        assert scene_code(own, language) == square


Asked = Callable[[hs.Scene], object]
REFUSED: dict[str, tuple[Asked, list[Any]]] = {
    "one limit of a joint region": (lambda s: hs.require(s, "jnd.real"), [ELLIPSE, DIAMOND, POLYGON]),
    "any environment": (lambda s: hs.require(s, "omega_n", any_environment=True), [ELLIPSE, POLYGON, FORMULA]),
    "a formula of the crossings": (lambda s: hs.derive(s)["p_r"], [ELLIPSE, POLYGON, FORMULA]),
    "a certificate": (lambda s: hs.evaluate(s).certificate(), [ELLIPSE, FORMULA]),
    "a range of one half width": (lambda s: hs.evaluate(s.with_values({"jnd.real": "0.1 +- 10 %"})), [ELLIPSE]),
}


@pytest.mark.parametrize("question", REFUSED)
def test_what_a_region_leaves_open_is_refused_and_never_answered_for_the_square(question: str) -> None:
    ask, jnds = REFUSED[question]
    for jnd in jnds:
        with pytest.raises(hs.SceneError) as refused:
            ask(with_jnd(jnd))
        assert "\n" not in str(refused.value)


@pytest.mark.dear("jnd2")
@pytest.mark.few(3)
@pytest.mark.parametrize("jnd", [ELLIPSE, DIAMOND, POLYGON, FLOOR, SIDED, FORMULA])
def test_the_disc_inside_a_region_is_where_no_environment_can_be_noticed(jnd: Any) -> None:
    """A filter's change behind environments of all phases: none leaves the region below, all do above."""
    found = hs.evaluate(with_jnd(jnd)).any_environment
    if found is None:  # where more than the length of a change matters
        assert jnd in (FLOOR, SIDED)
        return
    turns = np.exp(1j * np.linspace(0, 2 * np.pi, 721))
    table = jnd if isinstance(jnd, dict) else {"shape": "polygon", "corners": [[a, b] for a, b in (
        (FORMULA, FORMULA), (f"-({FORMULA})", FORMULA), (f"-({FORMULA})", f"-({FORMULA})"), (FORMULA, f"-({FORMULA})")
    )]}  # fmt: skip

    def outside_all(omega: float) -> list[bool]:
        s = 1j * omega
        d = 6400 / (s**2 + 80 * s + 6400) - 1
        return [outside(table, (d * turn).real, (d * turn).imag, omega) > 0 for turn in turns]

    below = float(found.transparent_below)  # type: ignore[arg-type]
    assert not any(outside_all(below * (1 - 1e-9)))
    assert any(outside_all(min(below * 1.02, 15)))
    if found.opaque_above is not None:
        above = float(found.opaque_above)
        assert all(outside_all(above * (1 + 1e-9)))
        assert not all(outside_all(above * 0.98))


# --- polygons of which all is known ----------------------------------------------------------------------------------

Corner = tuple[Fraction, Fraction]
SHAPES = [
    [(1, 0), (0, 1), (-1, 0), (0, -1)], [(2, 0), (0, 1), (-1, 0), (0, -2)], [(1, 1), (-1, 1), (-1, -1), (1, -1)],
    [(2, 1), (-1, 2), (-1, -1), (1, -1)], [(1, -1), (1, 2), (-2, 0)], [(2, 0), (1, 1), (-1, 1), (-2, 0), (0, -1)],
]  # fmt: skip


def edges(corners: list[Corner]) -> list[Corner]:
    """p x + q y = 1 along each."""
    found = []
    for (a, b), (c, d) in zip(corners, [*corners[1:], corners[0]], strict=True):
        size = a * d - b * c
        found.append(((d - b) / size, (a - c) / size))
    return found


def _extreme(rows: list[tuple[Fraction, Fraction, Fraction]], band: tuple[int, int], sign: int) -> Any:
    """The least (sign 1) or the largest (-1) of parabolas u + v w + x w^2 on a band, and where it is."""
    values: dict[Fraction, Fraction] = {}
    for u, v, x in rows:
        places = {Fraction(w) for w in band} | ({-v / (2 * x)} if x and band[0] < -v / (2 * x) < band[1] else set())
        for w in places:
            value = sign * (u + v * w + x * w**2)
            values[w] = min(value, values.get(w, value))
    least = min(values.values(), default=None)
    return (None, set()) if least is None else (sign * least, {w for w, y in values.items() if y == least})


def _is(end: SingleValue, value: Fraction, places: set[Fraction], band: tuple[int, int]) -> None:
    low, high = end.value.bounds(80)
    assert low <= value <= high
    assert end.bindings
    for binding in end.bindings:
        assert binding.omega is not None
        at = float(binding.omega)
        assert any(abs(at - float(w)) < 1e-12 for w in places)
        kind = Kind.START if at == band[0] else Kind.EDGE if at == band[1] else Kind.TOUCH
        assert binding.kind is kind


def _hold(pick: Random) -> bool:
    scale = Fraction(1, pick.choice([2, 3, 5]))
    corners = [(scale * x, scale * y) for x, y in pick.choice(SHAPES)]
    d, c = Fraction(pick.randint(-3, 3), 40), Fraction(pick.randint(-4, 4), 100)
    band = (pick.choice([0, 0, 1, 2]), pick.randint(3, 7))
    gain = hs.effects.series("1 + t + c*s^2 + d*s", parameters={"t": "1/10", "c": str(c), "d": str(d)})
    region = {"shape": "polygon", "corners": [[str(x), str(y)] for x, y in corners]}
    scene = hs.Scene(hs.environments.mass_spring_damper(k=100), (gain,), band, region)
    found = hs.require(scene, "t", (-9, 9))
    own = edges(corners)  # of x = t - c w^2 and y = d w
    tops = [(1 / p, -q * d / p, c) for p, q in own if p > 0]
    bottoms = [(1 / p, -q * d / p, c) for p, q in own if p < 0]
    kept = all(q * d * w <= 1 for p, q in own if p == 0 for w in band)
    (high, highest), (low, lowest) = _extreme(tops, band, 1), _extreme(bottoms, band, -1)
    if found.undecided:  # what is proven is right
        assert all(kept and low - 1e-12 <= float(x.low) and float(x.high) <= high + 1e-12 for x in found.feasible)
        return bool(kept and low <= high)
    if not kept or low > high:
        assert found.feasible == ()
        return False
    [span] = found.feasible
    if low == high:  # one value alone, at which both bind
        lowest = highest = lowest | highest
    assert span.closed == (True, True)
    _is(span.first, low, lowest, band)
    _is(span.last, high, highest, band)
    return True


@pytest.mark.slow
@pytest.mark.few("10")
@pytest.mark.parametrize("seed", range(11))
def test_values_in_a_polygon_are_those_between_the_extremes_of_parabolas(seed: int) -> None:
    pick = Random(seed)
    count = 8 if seed < 10 else 2
    assert sum(_hold(pick) for _ in range(count)) > count // 8
