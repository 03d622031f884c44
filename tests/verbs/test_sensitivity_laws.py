"""Sensitivities of scenes whose frequencies are powers of their parameters: every number and every reason is known by hand."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st
from mpmath import mp
from sympy import Rational, Symbol

import haptisym as hs
from haptisym import effects, environments
from haptisym.kernel.implicit import Equation
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.rings import PolynomialRing
from haptisym.kernel.symbols import omega
from haptisym.verbs.sensitivity.branches import Meeting, Slope
from haptisym.verbs.sensitivity.slopes import FLAT, TOUCH, Sensitive

NAMES = {
    "k": "environment.k",
    "m": "effects.shunt.m",
    "b": "effects.shunt.b",
    "c_real": "evaluation.jnd.real",
    "c_imag": "evaluation.jnd.imag",
    "c": "evaluation.jnd",
}
UNITS = {"k": "N/m", "m": "kg", "b": "N*s/m", "c_real": "1", "c_imag": "1", "c": "1"}
VALUES = st.fractions(Fraction(1, 4), 9, max_denominator=12)


def shunted(k: Any, m: Any, b: Any, jnd: Any, band: tuple[Any, Any] = (0, 60)) -> hs.Scene:
    """A spring that is felt with a mass and a damper beside it: r_r = m omega^2/k, r_i = b omega/k."""
    return hs.Scene(environments.mass_spring_damper(k=k), (effects.shunt(m=m, b=b),), band, jnd)


def elasticities(x: Sensitive) -> dict[str, Fraction | None]:
    return {
        p.name: None if p.elasticity is None else Fraction(p.elasticity.digits(25)).limit_denominator(10**9)
        for p in x.parameters
    }


@given(VALUES, VALUES, VALUES, st.integers(1, 9), st.integers(1, 9))
def test_frequencies_that_are_powers_of_parameters_have_these_powers_as_elasticities(
    k: Fraction, m: Fraction, b: Fraction, p: int, q: int
) -> None:
    real, imag = Fraction(p, 10), Fraction(q, 11)
    assume(real * k / m != (imag * k / b) ** 2)
    band = (0, 1000)
    e = hs.sensitivity(
        shunted(f"{k} N/m", f"{m} kg", f"{b} N*s/m", {"real": f"{real}", "imag": f"{imag}"}, band), digits=18
    )
    half = Fraction(1, 2)
    by_part = {
        "real": (mp.sqrt(float(real * k / m)), {"k": half, "m": -half, "b": 0, "c_real": half}),
        "imag": (mp.mpf(float(imag * k / b)), {"k": 1, "m": 0, "b": -1, "c_imag": 1}),
    }
    assert [x.criterion.name for x in e.crossings if x.criterion] == sorted(by_part, key=lambda part: by_part[part][0])
    values = {"k": k, "m": m, "b": b, "c_real": real, "c_imag": imag}
    for x, row in zip(e.crossings, e.to_dict()["crossings"], strict=True):
        assert x.criterion is not None
        omega, powers = by_part[x.criterion.name]
        assert float(x.omega) == pytest.approx(float(omega), rel=1e-12)
        assert elasticities(x) == powers
        assert (row["part"], row["kind"], row["omega"], "reason" in row) == (
            x.criterion.name,
            "exceeds",
            float(x.omega),
            False,
        )
        for p_, told in zip(x.parameters, row["parameters"], strict=True):
            derivative = float(powers[p_.name]) * float(omega) / float(values[p_.name])
            assert float(p_.derivative or 0) == pytest.approx(derivative, rel=1e-12)
            assert told == {
                "path": NAMES[p_.name], "name": p_.name, "unit": UNITS[p_.name], "derivative": float(p_.derivative or 0), "elasticity": float(p_.elasticity or 0),
                "digits": {"derivative": p_.derivative.digits(18), "elasticity": p_.elasticity.digits(18)},  # type: ignore[union-attr]
            }  # fmt: skip
        assert [abs(float(y.elasticity or 0)) for y in x.ranked] == sorted(
            (abs(float(v)) for v in powers.values()), reverse=True
        )
        assert x["environment.k"] is x["k"]
        assert repr(x) == f"<Sensitive {x.omega.digits(6)} rad/s: 4 parameters>"
    assert e.bandwidth is e.crossings[0]
    [turn] = e.changeovers_perceived
    assert (elasticities(turn), e.changeovers_environment) == ({"k": half, "m": -half, "b": 0}, ())
    assert e.to_dict()["bandwidth"] == e.to_dict()["crossings"][0]
    assert e.certified


def test_one_threshold_for_both_parts_is_one_parameter_and_its_formula_is_by_any_name() -> None:
    e = hs.sensitivity(shunted(100, "0.1", 1, 0.1))
    assert [elasticities(x)["c"] for x in e.crossings] == [Fraction(1, 2), 1] or [
        len(elasticities(x)) for x in e.crossings
    ]
    e = hs.sensitivity(shunted(100, "0.1", "0.5", 0.1))
    assert [elasticities(x) for x in e.crossings] == [
        {"k": Fraction(1, 2), "m": -Fraction(1, 2), "b": 0, "c": Fraction(1, 2)}, {"k": 1, "m": 0, "b": -1, "c": 1},
    ]  # fmt: skip
    here = {"omega": 10, "k": 100, "m": Rational(1, 10), "b": Rational(1, 2), "c": Rational(1, 10)}
    for name, value in (
        ("k", Rational(1, 20)),
        ("environment.k", Rational(1, 20)),
        ("m", -50),
        ("shunt.m", -50),
        ("c", 50),
        ("evaluation.jnd.real", 50),
    ):
        slope = e.formula(hs.Part.REAL, name)
        assert slope.subs({x: here[x.name] for x in slope.free_symbols}) == value
    with pytest.raises(hs.SceneError, match='no parameter "q"'):
        e.formula(hs.Part.REAL, "q")


BOTH = "undefined: both ratios meet their thresholds here"
WITHIN = "undefined: the display touches its threshold within the bandwidth"
VERY_END = "undefined: a ratio meets its threshold at the very end of the band"
LAGGED = hs.Scene(
    environments.mass_spring_damper(k=100), (effects.first_order_lag(10),), (0, 40), {"real": 0.9, "imag": 0.5}
)


@pytest.mark.parametrize(
    ("scene", "omega", "reason"),
    [
        (shunted(100, "0.1", 1, {"real": 0.1, "imag": 0.2}), 10, ""),
        (shunted(100, "0.1", 2, {"real": 0.1, "imag": 0.2}), 10, BOTH),
        (shunted(100, "0.1", 0, 0.1, (0, 10)), 10, VERY_END),
        (shunted(100, "0.1", 0, 0.1, (0, 9)), 9, ""),
        (shunted(100, "0.1", 0, 0.1, (10, 20)), 10, TOUCH),
        (LAGGED, 30, WITHIN),
        (LAGGED.with_band(11, 40), 30, ""),
        (LAGGED.with_band(0, 20), 20, WITHIN),
        (
            hs.Scene(
                environments.mass_spring_damper(k=100), (effects.compliance(k=900), effects.first_order_lag(50)), (0, 9)
            ),
            0,
            TOUCH,
        ),
    ],
)
def test_a_bandwidth_has_a_derivative_where_one_ratio_alone_ends_it_inside_the_band(
    scene: hs.Scene, omega: float, reason: str
) -> None:
    found = hs.sensitivity(scene).bandwidth
    assert found is not None
    assert float(found.omega) == pytest.approx(omega, abs=1e-12)
    assert found.reason == reason
    assert {p.derivative is None for p in found.parameters} == {bool(reason)}
    if not reason and omega in (9, 20):
        assert {float(p.derivative) for p in found.parameters} == {0.0}  # type: ignore[arg-type]
        assert [p.name for p in found.parameters] == ["k", "m", "b", "c"]


def test_without_a_bandwidth_there_is_none_that_moves() -> None:
    e = hs.sensitivity(shunted(100, "0.1", 0, 0.1, (11, 20)))
    assert (e.bandwidth, e.crossings, e.to_dict()["bandwidth"]) == (None, (), None)
    assert e.certified


def test_where_a_ratio_only_touches_what_matters_has_no_derivative_and_the_rest_does_not_move_it() -> None:
    """omega_c sqrt(c/(1 - c)) for the real part; the imaginary part's peak, 1/2 at omega_c, touches its threshold."""
    touch, cross = hs.sensitivity(LAGGED).crossings
    assert (touch.kind, float(touch.omega)) == (hs.CrossingKind.TOUCHES, 10)
    assert {p.name: (p.reason, p.derivative is None) for p in touch.parameters} == {
        "k": ("", False),
        "omega_c": (TOUCH, True),
        "c_imag": (TOUCH, True),
    }
    assert touch.reason == ""
    assert elasticities(cross) == {"k": 0, "omega_c": 1, "c_real": 5}
    row = hs.sensitivity(LAGGED).to_dict()["crossings"][0]["parameters"][1]
    assert (row["derivative"], row["elasticity"], row["digits"], row["reason"]) == (
        None,
        None,
        {"derivative": None, "elasticity": None},
        TOUCH,
    )


def test_at_zero_a_flat_ratio_has_no_derivative_by_what_it_depends_on() -> None:
    spring = environments.mass_spring_damper(k=100)
    [first, *_] = hs.sensitivity(
        hs.Scene(spring, (effects.compliance(k=900), effects.first_order_lag(50)), (0, 9))
    ).crossings
    assert float(first.omega) == 0
    assert {p.name: p.reason for p in first.parameters if p.derivative is None} == {
        x: FLAT for x in ("k_compliance", "k", "c") if x in {p.name for p in first.parameters}
    }


@pytest.mark.parametrize("jnd", [{"shape": "ellipse", "real": 0.2, "imag": 0.1}, {"shape": "diamond", "real": 0.2, "imag": 0.1},
                                 {"shape": "polygon", "corners": [[0.1, 0], [0, 0.2], [-0.3, 0], [0, -0.1]]}])  # fmt: skip
def test_where_a_region_is_left_the_slope_is_that_of_its_border(jnd: dict[str, Any]) -> None:
    """x = -m omega^2/k, y = b omega/k: differences of the root of the border, in floats of many digits."""
    e = hs.sensitivity(shunted(100, "0.1", "0.7", jnd))
    [x] = e.crossings
    assert [p.name for p in x.parameters] == ["k", "m", "b"]

    def border(w: Any, k: Any, m: Any, b: Any) -> Any:
        re, im = m * w**2 / k, b * w / k
        if jnd["shape"] == "ellipse":
            return (re / 0.2) ** 2 + (im / 0.1) ** 2 - 1
        return re / (0.3 if jnd["shape"] == "polygon" else 0.2) + im / (0.2 if jnd["shape"] == "polygon" else 0.1) - 1

    with mp.workdps(30):
        point = {"k": mp.mpf(100), "m": mp.mpf("0.1"), "b": mp.mpf("0.7")}

        def root(**values: Any) -> Any:
            return mp.findroot(lambda w: border(w, **(point | values)), float(x.omega))

        assert float(x.omega) == pytest.approx(float(root()), rel=1e-12)
        for p in x.parameters:
            slope = mp.diff(lambda v, name=p.name: root(**{name: v}), point[p.name])
            assert float(p.derivative) == pytest.approx(float(slope), rel=1e-9)  # type: ignore[arg-type]
            assert float(p.elasticity) == pytest.approx(float(slope * point[p.name] / root()), rel=1e-9)  # type: ignore[arg-type]


def test_at_a_corner_of_a_region_several_limits_meet_and_beside_it_one_alone() -> None:
    """The corner (-1/10, 1/10) is met at 10 rad/s where b = 1."""
    corners = [["0.1", "0.1"], ["-0.1", "0.1"], ["-0.1", "-0.1"], ["0.1", "-0.1"]]
    square = {"shape": "polygon", "corners": corners}
    [x] = hs.sensitivity(shunted(100, "0.1", 1, square)).crossings
    assert (float(x.omega), x.reason) == (10, "undefined: several limits of the region meet here")
    [x] = hs.sensitivity(shunted(100, "0.1", "0.9", square)).crossings
    assert elasticities(x) == {"k": Fraction(1, 2), "m": -Fraction(1, 2), "b": 0}
    [x] = hs.sensitivity(shunted(100, "0.1", "1.1", square)).crossings
    assert elasticities(x) == {"k": 1, "m": 0, "b": -1}


def test_a_slope_is_told_to_as_many_digits_as_wanted() -> None:
    x = hs.sensitivity(shunted(7, "0.3", "0.7", 0.1)).crossings[0]
    slope = x["k"].derivative
    assert isinstance(slope, Slope)
    assert slope.is_clear()
    with mp.workdps(80):
        exact = {"real": mp.sqrt(mp.mpf("0.7") / mp.mpf("0.3")) / 14, "imag": mp.mpf(1) / 7}[x.criterion.name]  # type: ignore[union-attr]
        for digits in (5, 30, 60):
            low, high = (mp.mpf(t) for t in slope.enclosure(digits))
            assert low <= exact <= high
            assert high - low <= exact * mp.mpf(10) ** (2 - digits)


def test_a_parameter_at_its_least_value_moves_a_frequency_upward_alone() -> None:
    """r_i = (b omega)/k beside b = 0 is nowhere noticed; Re H_perc = k - m omega^2 has no b in it."""
    e = hs.sensitivity(
        hs.Scene(environments.mass_spring_damper(m="0.1", k=100), (effects.second_order_lowpass(40, 0),), (0, 39))
    )
    for x in e.crossings:
        row = x["zeta"]
        assert row.elasticity is not None
        assert float(row.elasticity) == 0
        if row.side:
            assert (row.side, row.reason) == ("above", "from above; below there is no scene")
    assert e.crossings[0]["omega_n"].side == ""


# Where several zeros of one factor meet

PARAMETER = Symbol("p", real=True)


@given(
    st.fractions(1, 9, max_denominator=7),
    st.fractions(-5, 5, max_denominator=7),
    st.fractions(-4, 4, max_denominator=5),
    st.sampled_from([1, 2, 3]),
)
@example(w=Fraction(1), p=Fraction(1, 3), m=Fraction(0), order=1)
def test_branches_through_a_point_are_those_of_the_lowest_terms_there(
    w: Fraction, p: Fraction, m: Fraction, order: int
) -> None:
    """A loop's own crossing, a point alone and a cusp; a parabola to either side, an inflection, and a line."""
    x, y = PARAMETER - Rational(p), omega - Rational(w)
    slanted = y - Rational(m) * x
    for F, known in (
        (slanted**2 - x**2 * (x + 2), (2, 2)),
        (slanted**2 - x**2 * (x - 1), (0, 0)),
        (slanted**2 - x**3, None),
        (y**2 - 3 * x, (0, 2)),
        (y**4 + 5 * x, (2, 0)),
        (y**3 - x, (1, 1)),
        (slanted * (1 + omega**2) - 3 * x**2, (1, 1)),
    ):
        ring = PolynomialRing(omega, [PARAMETER])
        values = ((omega, ExactNumber(Rational(w))), (PARAMETER, ExactNumber(Rational(p))))
        sides = Meeting(((Equation(ring, ring.convert(F.expand()).numerator), order),), PARAMETER, values).sides()
        if order % 2 == 0:  # no sign changes
            assert sides == ([], [])
            continue
        assert (sides and tuple(map(len, sides))) == known
        if F.has(slanted * (1 + omega**2)):
            assert sides is not None
            assert [float(branch) for [branch] in sides] == [float(m)] * 2  # type: ignore[arg-type]
        else:
            assert sides is None or {*sides[0], *sides[1]} <= {None}
