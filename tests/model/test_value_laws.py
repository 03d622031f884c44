"""Numbers, ranges, formulas, parameters and JNDs of a scene: fractions, round trips and exact sentences at every limit."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st
from jnds import jnds, same_rows
from refusals import refusal
from sympy import Integer, Rational, Symbol, pi, sqrt

import haptisym as hs
from haptisym.kernel.symbols import omega
from haptisym.model.expressions import evaluate
from haptisym.model.family import SceneFamily, named
from haptisym.model.hand import Hand
from haptisym.model.jnd import Part, Threshold
from haptisym.model.jndtables import read_threshold
from haptisym.model.naming import with_names
from haptisym.model.parameters import Rule, free_name
from haptisym.model.quantities import Dimension, MotionKind, dimension_exponents, fits, implied_motion, quantity
from haptisym.model.ranges import ranged, spread
from haptisym.model.regions import Region, Shape, positive, turning
from haptisym.model.scene import Scene

K = Dimension.STIFFNESS
FRACTIONS = st.fractions(-50, 50, max_denominator=20)
POSITIVE = st.fractions(Fraction(1, 20), 50, max_denominator=20)


def exact(x: Fraction) -> Rational:
    return Rational(x.numerator, x.denominator)


# Ranges.


@given(FRACTIONS, st.fractions(0, 50, max_denominator=20), st.sampled_from(["+-", "+/-", "±"]))
def test_a_range_lies_around_its_centre_by_its_deviation_or_its_share(c: Fraction, d: Fraction, sign: str) -> None:
    found = ranged(f"{c} N/m {sign} {d} N/m", K)
    assert found.nominal.value == exact(c)
    assert found.interval == (None if d == 0 else (exact(c - d), exact(c + d)))
    assert ranged(f"{c}{sign}{d}", K).interval == found.interval
    assume(c != 0)
    off = abs(c) * d / 100
    assert ranged(f"{c} N/m {sign} {d} %", K).interval == (None if d == 0 else (exact(c - off), exact(c + off)))


@given(st.lists(FRACTIONS, min_size=2, max_size=3))
def test_a_list_is_a_range_where_it_rises(row: list[Fraction]) -> None:
    told = [f"{x} N/m" for x in row]
    if row != sorted(row):
        assert "must not be above" in refusal(ranged, told, K) or "must lie between" in refusal(ranged, told, K)
        return
    found = ranged(told, K)
    middle = row[1] if len(row) == 3 else (row[0] + row[1]) / 2
    assert (found.nominal.value, found.nominal.motion) == (exact(middle), MotionKind.TRANSLATION)
    assert found.interval == (None if row[0] == row[-1] else (exact(row[0]), exact(row[-1])))


@given(FRACTIONS, FRACTIONS, FRACTIONS)
def test_a_range_is_told_by_its_per_cent_only_where_it_is_even_and_leaves_out_zero(
    a: Fraction, b: Fraction, c: Fraction
) -> None:
    low, nominal, high = sorted([a, b, c])
    assume(low < high)
    for middle in (nominal, (low + high) / 2):
        even = middle - low == high - middle and low * high > 0
        words = (
            f"by {float(50 * (high - low) / abs(middle)):.4g} %"
            if even
            else f"from {float(low):.6g} to {float(high):.6g}"
        )
        assert spread(exact(middle), (exact(low), exact(high))) == words


@pytest.mark.parametrize(
    ("given_", "told"),
    [
        ("0 N/m +- 5 %", "a percentage of zero is no range"),
        ("0 N/m +- 5 N/m", ""),
        ("3 N/m +- -1 N/m", "the deviation after +- must be >= 0"),
        ("3 N/m +- -5 %", "the deviation after +- must be >= 0"),
        ("3 N/m +- 1", "give the value and its deviation units alike"),
        ("3 +- 1 N/m", "units alike"),
        ("3 +- 1 +- 1", "is not a range: write it as"),
        ("+- 1", "is not a range: write it as"),
        ("3 +-", "is not a range: write it as"),
        ("3 N/m +- 2 m", "is not a stiffness"),
        ([1], "a list here must be a pair"),
        ([1, 2, 3, 4], "or three, the nominal between"),
        ([2, 1], "the lower end of a range must not be above the upper end"),
        ([1, 3, 2], "the value in the middle, the nominal one, must lie between"),
        ([1, "2 N/m"], "must have units of the same kind"),
        (["1 N/m", 2, "3 N/m"], "must have units of the same kind"),
        (["1 N/m", "2 N*m/rad"], "must have units of the same kind"),
        ([1, Symbol("x")], "its ends must be numbers"),
        ([1, Symbol("x"), 2], "its ends must be numbers"),
        ([1, 1], ""),
        ([1, 1, 2], ""),
        ([1, 2, 2], ""),
    ],
)
def test_what_is_no_range_is_told_in_a_sentence(given_: Any, told: str) -> None:
    said = refusal(ranged, given_, K)
    assert told in said
    assert bool(told) == bool(said)


# Numbers and units.


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("1" * 200, ""), ("1" * 201, "a number may have at most 200 characters"), ("1/" + "3" * 200, ""),
        ("1/" + "3" * 201, "at most 200 characters"), ("1e300", ""), ("1e301", "exponents of ten may go from -300 to 300"),
        ("1e-300", ""), ("1e-301", "exponents of ten"), ("1e0300", ""), ("1e00001", "exponents of ten"), ("1/0", "divides by zero"),
        ("0/7", ""), ("1,5 N/m", "decimals are written with a point, as in 1.5 N/m"), ("1.5/2.5", "is not a unit"), ("3/4e2", "is not"),
        ("x", "does not start with a finite number: expected N/m or N*m/rad"), ("1e299 kN/m", "must lie between 1e-300 and 1e300"),
        ("1e-299 mN/m", "must lie between 1e-300"), ("1e296 kN/m", ""), ("0 kN/m", ""), (" 3 N/m ", ""), ("3 N/m^2", "is not a stiffness"),
    ],
)  # fmt: skip
def test_a_number_may_be_as_long_and_as_large_as_a_float_can_show(text: str, told: str) -> None:
    said = refusal(quantity, text, K)
    assert told in said
    assert bool(told) == bool(said)


def test_a_dimension_fits_by_what_it_measures_or_by_the_exponents_that_its_unit_told() -> None:
    for own in Dimension:
        for motion in MotionKind:
            exponents = dimension_exponents(own, motion)
            for wanted in Dimension:
                both = [dimension_exponents(wanted, m) for m in MotionKind]
                assert fits(own, exponents, wanted) == (
                    own is wanted or wanted is Dimension.ANY or (own is Dimension.ANY)
                )
                assert fits(Dimension.ANY, exponents, wanted) == (
                    wanted is Dimension.ANY or own is Dimension.ANY or exponents in both
                )
                known = [m for m in MotionKind if dimension_exponents(wanted, m) == exponents]
                assert implied_motion(wanted, exponents) is (known[0] if len(known) == 1 else None)


def test_a_number_that_is_written_in_pi_is_exact_and_a_root_is_none() -> None:
    for given_ in (pi, 2 / pi + 1, pi**-3, Rational(1, 3) * pi):
        assert quantity(given_, K).value == given_
    assert quantity(0.1 * pi, K).value == pi / 10
    for bad in (sqrt(2), pi ** Rational(1, 2), 2**pi, Integer(1) / 0):
        assert "is not a finite number that is rational, or rational in pi" in refusal(quantity, bad, K)
    assert refusal(quantity, True, K) == "true is not a number, nor a string of a number and a unit"  # noqa: FBT003
    assert refusal(quantity, None, K) == '"None" is not a number, nor a string of a number and a unit'


# Formulas.


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("x^2^3", "a power of a power needs parentheses\n    x^2^3\n       ^"),
        ("x**2**3", "a power of a power needs parentheses\n    x**2**3\n        ^"),
        ("2*exp(x)", "a formula has no exp(...): a delay is an effect"),
        ("2*exq(x)", 'a formula has no functions, and "exq(" would be one: if a product is meant, write "exq*("\n    2*exq(x)\n      ^'),
        ("sqrt(x)", '"sqrt(" would be one: a root is a power, as in s^0.5'),
        ("1+cosh(x)", 'is the effect model = "wave-variables"\n    1+cosh(x)\n      ^'),
        ("abs(x)", "it is built of numbers, names"),
        ("x(2)", 'write "x*("'),
        ("e^x", "a formula has no powers of e: a delay"),
        ("e**(-x)", "a formula has no powers of e"),
        ("e^2", ""), ("e*x", ""), ("e", ""), ("exp", 'unknown name "exp"'),
        ("x^y", "an exponent must be a number\n    x^y\n      ^"),
        ("x^1e3", "an exponent must be a short plain number"),
        ("x^0.1234567890", ""), ("x^0.12345678901", "an exponent must be a short plain number"),
        ("x^(1/99)", ""), ("x^(1/100)", "is one of whole numbers up to 99, as in s^(1/3)\n    x^(1/100)\n       ^"),
        ("x^(100/99)", "whole numbers up to 99"), ("x^(1/0)", "whole numbers up to 99"), ("x^(1.5/2)", "whole numbers up to 99"),
        ("x^(3/1.5)", "whole numbers up to 99"), ("x^1/100", ""), ("x^(2", 'expected ")"\n    x^(2\n        ^'),
        ("x^(2+1)", "an exponent must be one number, as in s^2 or s^(-1/2), not a formula"), ("x^(-2)", ""), ("x^(+2)", ""),
        ("(x", 'expected ")"'), ("x)", 'expected an operator such as *, found ")"'), ("x y", 'expected an operator such as *, found "y"'),
        ("", "expected a number, a name or a parenthesis, found the end"), ("x*", "found the end\n    x*\n      ^"),
        ("x^60", ""), ("x^61", "the degree, 61, is higher than 60\n    x^61\n     ^"), ("x^30*x^30", ""), ("x^30*x^31", "the degree, 61,"),
        ("x^30/x^31", "the degree, 61,"), ("x^60+x^60", ""), ("x^(-61)", "the degree, 61,"), ("x^59.5", ""), ("x^60.5", "the degree, 61,"),
        ("(x+1)^60", ""), ("(x*x)^30", ""), ("(x*x)^31", "the degree, 62,"), ("2^61", ""), ("1/0", "division by zero\n    1/0\n     ^"),
        ("0^(-1)", "division by zero"), ("0^0", ""), ("1/(x-x)", "division by zero"), ("1" * 2000, ""), ("1" * 2000 + "*1", "more than 2000 digits"),
        ("1" * 1000 + "+" + "1" * 1000, ""), ("1" * 1000 + "-" + "1" * 1001, "more than 2000 digits"), ("10^1000", ""),
        ("10^1001", "more than 2000 digits"), ("x" + " " * 3999, ""), ("x" + " " * 4000, "a formula may have at most 4000 characters; this one has 4001"),
        ("-" * 60 + "x", ""), ("-" * 61 + "x", "a formula may be nested at most 60 deep"), ("(" * 61 + "x" + ")" * 61, "nested at most 60 deep"),
        ("x # y", '"#" is not allowed in a formula (only numbers, names, + - * / ^ and parentheses)\n    x # y\n      ^'),
        ("1\n+\ty", 'unknown name "y"\n    1 + y\n        ^'),
        ("x" + "+x" * 40 + "+y" + "+x" * 30, 'unknown name "y"\n    ' + "x+" * 25 + "y" + "+x" * 14 + "+" + "\n    " + " " * 50 + "^"),
    ],
)  # fmt: skip
def test_what_a_formula_may_not_be_is_told_with_a_mark_under_the_place(text: str, told: str) -> None:
    names = {"x": Fraction(7, 3), "e": Fraction(2)}
    if any(f"^{x}" in text for x in ("(1/99)", "0.1", "59.5", "60.5")):
        names["x"] = Fraction(1)
    said = refusal(evaluate, text, number=Fraction, name=names.__getitem__)
    assert told in said
    assert bool(told) == bool(said)


def test_a_unit_has_no_sums_and_no_signs() -> None:
    def of(text: str) -> str:
        return refusal(evaluate, text, number=Fraction, name={"x": Fraction(3)}.__getitem__, sums=False)

    assert not of("x/x^-2*(x*x)^(1/1)")
    assert 'expected an operator such as *, found "+"' in of("x+x")
    assert "expected a number, a name or a parenthesis, found -" in of("-x")


# Parameters.


def test_a_rule_allows_the_numbers_that_it_names_and_of_two_the_stricter_holds() -> None:
    values = [Rational(x) for x in ("-1", "-1/9", "0", "1/9", "8/9", "1", "3/2", "10", "11", "100", "101")]
    witness = {
        Rule.POSITIVE: lambda x: x > 0, Rule.NONNEGATIVE: lambda x: x >= 0, Rule.ANY: lambda _: True, Rule.FRACTION: lambda x: 0 < x < 1,
        Rule.ORDER: lambda x: x.q == 1 and 1 <= x <= 10, Rule.WHOLE: lambda x: x.q == 1 and 0 <= x <= 100,
    }  # fmt: skip
    symbol = Symbol("k")
    for rule, allows in witness.items():
        assert [rule.allows(x) for x in values] == [allows(x) for x in values]
        assert rule.allows(symbol) == (rule not in (Rule.ORDER, Rule.WHOLE))
        for other in witness:
            both = rule.and_also(other)
            assert both in (rule, other)
            assert rule.and_also(rule) is rule
            assert both is other.and_also(rule)
            if {rule, other} <= {Rule.ANY, Rule.NONNEGATIVE, Rule.POSITIVE, Rule.FRACTION}:
                assert [both.allows(x) for x in values] == [allows(x) and witness[other](x) for x in values]


@given(st.lists(st.sampled_from(["a", "a-2", "a-3", "b"]), min_size=1, max_size=6))
def test_effects_of_one_name_are_numbered_past_the_names_that_there_are(names: list[str]) -> None:
    found = [x.name for x in with_names([hs.effects.delay(1, name=name) for name in names])]
    taken, expected = set(names), list[str]()
    for name in names:
        own = name
        if own in expected:
            i = 2
            while f"{name}-{i}" in taken:
                i += 1
            own = f"{name}-{i}"
            taken.add(own)
        expected.append(own)
    assert found == expected
    assert len(set(found)) == len(found)
    assert free_name("a", names) == next(x for x in ("a", *(f"a_{i}" for i in range(2, 9))) if x not in names)


def test_parameters_are_stated_with_their_units_and_ranges() -> None:
    told = {
        "m = 9/5 kg": hs.environments.mass_spring_damper(m="1.8 kg"),
        "m = 2 kg·m²": hs.environments.mass_spring_damper(m="2 kg*m^2"),
        "k = 3 N/m, from 2 to 4 N/m": hs.environments.mass_spring_damper(k=[2, 4]),
        "zeta = 1/2": hs.effects.second_order_lowpass(80, 0.5),
        "tau": hs.effects.delay(hs.symbols("tau")),
        "tau = x": hs.effects.delay(Symbol("x", positive=True)),
    }
    for words, element in told.items():
        stated = [p.stated().replace("kg*m^2", "kg·m²") for p in element.parameters]
        assert any(words == x or (words == "tau = x" and x.startswith("tau = x")) for x in stated), stated


# Hands, families, scenes.


def test_a_hand_is_its_mass_damping_and_stiffness_in_that_order_and_nothing_below_zero() -> None:
    hand = Hand("mine", "0.5 kg", ["5 N*s/m", "7 N*s/m"], 30)
    assert ([p.key for p in hand.parameters], [p.value for p in hand.parameters]) == (
        ["m", "b", "k"],
        [Rational(1, 2), 6, 30],
    )
    assert hs.symbols("s") ** 2 / 2 + 6 * hs.symbols("s") + 30 == hand.Z or str(hand.Z) == "s**2/2 + 6*s + 30"
    assert (hand.has_ranges, hand.motion) == (True, MotionKind.TRANSLATION)
    assert (Hand("light").Z, Hand("light").has_ranges, Hand("light").motion) == (0, False, None)
    moved = hand.with_values({"b_h": 9, "k_h": 0})
    assert [(p.value, p.interval) for p in moved.parameters] == [(Rational(1, 2), None), (9, None), (0, None)]
    for keys, said in (({"m": -1}, "m: "), ({"b": "1 kg"}, "b: "), ({"m": "1 kg", "b": "1 N*m*s/rad"}, "cannot be mixed: m is translational but b"),
                       ({"name": ""}, "must be a string that is not empty"), ({"name": 3}, "must be a string")):  # fmt: skip
        assert said in refusal(Hand, **({"name": "x"} | keys))
    assert "postural-arm" in hs.hands
    assert "arm" not in hs.hands
    assert 'there is no hand "postural_arm": did you mean "postural-arm"?' in refusal(
        hs.hands.__getitem__, "postural_arm"
    )
    assert len(hs.hands) == len(list(hs.hands))
    assert refusal(Scene, hs.environments.kelvin_voigt(1, 2), hands=(hand, hand)) == (
        'hands: "mine" is there twice: give each a name of its own'
    )


def soft(k: Any = 100, *effects: hs.Effect, **keys: Any) -> Scene:
    return Scene(hs.environments.kelvin_voigt(k, 2), effects or (hs.effects.first_order_lag(20),), **keys)


def test_a_family_has_one_to_a_hundred_scenes_of_one_display() -> None:
    one = soft()
    assert len(named(("x", one) for _ in range(100))) == 100
    assert "101 were given: at least 1, at most 100" in refusal(named, [("x", one)] * 101)
    assert "0 were given" in refusal(SceneFamily, {})
    assert list(named([("x", one), ("x", one), ("x-2", one), ("y", one)])) == ["x", "x-2", "x-2-2", "y"]
    other = "has other effects, another band or another threshold"
    lag = hs.effects.first_order_lag
    for scene in (
        soft(100, lag(21)),
        soft(100, lag(20, name="b")),
        soft(band=(0, 16)),
        soft(threshold=0.2),
        soft(100, lag(20), lag(20)),
    ):
        assert refusal(SceneFamily, {"a": one, "b": scene}) == f'environments: "b" {other}'
    pade = hs.effects.pade_delay
    assert other in refusal(SceneFamily, {"a": soft(1, pade(0, 1)), "b": soft(2, pade(0, 2))})
    family = SceneFamily({"a": one, "b": soft(200)}, "Two")
    assert refusal(family.__getitem__, "c") == 'there is no environment "c": these are "a", "b"'
    assert refusal(SceneFamily({"a": one}).__getitem__, "c") == 'there is no environment "c": there is only "a"'
    assert 'this scene has 2 environments ("a", "b"): choose one with --environment NAME' in refusal(family.only)
    assert SceneFamily({"a": one}).only() is one
    assert (family.band, family.threshold, family.first) == ((0, 15), Threshold(), one)
    assert repr(family) == '<SceneFamily "Two": a, b>'


def test_what_is_nominal_is_said_of_the_scenes_of_a_family_in_which_it_varies() -> None:
    def asides(*scenes: Scene) -> list[str]:
        return [x.partition(" var")[0] for x in SceneFamily({f"e{i}": x for i, x in enumerate(scenes)}).asides()]

    assert asides(soft(), soft(200)) == []
    assert asides(soft([90, 110]), soft()) == ["e0: k"]
    assert asides(soft([90, 110]), soft([90, 110]), soft(3)) == ["e0, e1: k"]
    assert asides(soft([90, 110]), soft([90, 110])) == ["k"]
    lag = hs.effects.first_order_lag([10, 30])
    assert asides(soft(1, lag), soft(2, lag)) == ["omega_c"]
    keys = SceneFamily({"a": soft([90, 110]), "b": soft(100)}).aside_keys()
    assert keys == {"nominal": {"a": {"environment.k": [90.0, 110.0]}}}
    assert SceneFamily({"a": soft()}).aside_keys() == {}


@pytest.mark.parametrize(
    ("band", "told"),
    [
        ((0, 1), ""), ((-1, 1), "band: the low end, -1 rad/s, must be >= 0"), (("-1 Hz", 1), 'band: the low end, "-1 Hz", must be >= 0'),
        ((1, 1), "band: the high end, 1 rad/s, must be above the low end, 1 rad/s"), (("2 Hz", "1 Hz"), 'the high end, "1 Hz", must be above'),
        ((1,), "must be a low and a high end"), ((1, 2, 3), "must be a low and a high end"), (("1 kg", 2), "band: "), (("6.28", "1 Hz"), ""),
        (("6.29", "1 Hz"), "must be above the low end"), (3, "give its two ends"),
    ],
)  # fmt: skip
def test_a_band_goes_from_zero_or_above_to_a_higher_end(band: Any, told: str) -> None:
    said = refusal(soft, band=band)
    assert told in said
    assert bool(told) == bool(said)


# JNDs.


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
def test_a_jnd_is_called_what_it_is_and_only_the_papers_is_plain(kind: str) -> None:
    own = read_threshold(KINDS[kind])
    assert own.kind == kind
    plain = kind in ("a square", "a rectangle")
    assert own.is_plain == plain
    said = refusal(own.need_plain, "area")
    assert said == ("" if plain else f"area: the JND is {kind}; this is answered for one number for each part alone")
    if kind == "a polygon":
        assert own.row() == {"shape": "polygon", "corners": [["1", "0"], ["0", "1"], ["-1", "-1"]]}
        assert "a polygon is given by its corners: it has no limit for one part" in refusal(
            own.with_limits, {Part.REAL: 1}
        )
        assert own.with_limits({}).region == own.region
        return
    moved = own.with_limits({Part.IMAG: "30 %"})
    assert (moved.real, moved.imag, moved.lower(Part.REAL)) == (own.real, Rational(3, 10), own.lower(Part.REAL))
    assert own.with_limits({Part.REAL: [0.1, 0.3]}).real_interval == (Rational(1, 10), Rational(3, 10))
    assert own.with_limits({Part.REAL: 1}).lower(Part.REAL) is None
    if plain:
        moving = read_threshold({**SQUARE, "real": "0.1 + omega"})
        assert refusal(moving.need_plain, "area").startswith("area: the JND is a rectangle that depends on omega; ")


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


BAND = (Integer(0), Integer(10))


@pytest.mark.parametrize(
    ("table", "told"),
    [
        ({"shape": "ellipse", "real": 1, "imag": 1, "tilt": "99/100"}, ""),
        ({"shape": "ellipse", "real": 1, "imag": 1, "tilt": 1}, "tilt: 1 must lie strictly between -1 and 1"),
        ({"shape": "ellipse", "real": 1, "imag": 1, "tilt": "omega/10"}, "must lie strictly between -1 and 1 on the whole band"),
        ({"shape": "ellipse", "real": 1, "imag": 1, "tilt": "omega/11"}, ""),
        ({"real": "1 - omega/10", "imag": 1}, "real: 1 - omega/10 must be > 0 on the whole band"),
        ({"real": "1 - omega/11", "imag": 1}, ""),
        ({"real": 1, "imag": "1/(omega - 5)^2"}, "imag: (omega - 5)**(-2) must be > 0 on the whole band"),
        ({"real": 1, "imag": "(omega - 5)^2"}, "must be > 0 on the whole band"),
        ({"real": 1, "imag": 1, "floor": "10 - omega"}, "floor: 10 - omega must be > 0"),
        ({"real": {"higher": 1, "lower": "10 - omega"}, "imag": 1}, "real: lower: 10 - omega must be > 0"),
        ({"shape": "polygon", "corners": [[1, 0], [0, 1], [-1, -1]]}, ""),
        ({"shape": "polygon", "corners": [[1, 0], [0, 1], [0, 1], [-1, -1]]}, "corners: 2 and 3 are one point, [0, 1]"),
        ({"shape": "polygon", "corners": [["1 + omega", 0], ["11 - omega", 0], [0, 1], [-1, -1]]}, "corners: 1 and 2 are one point"),
        ({"shape": "polygon", "corners": [[1, 0], [0, 1], [-1, 0]]}, "0 must lie inside, not on an edge"),
        ({"shape": "polygon", "corners": [[1, 0], [0, 1], [-1, "omega/10 - 1"]]}, "follow in their order around it on the whole band"),
        ({"shape": "polygon", "corners": [[2, 0], [1, 1], [0, 2], [-1, -1]]}, "the polygon must be convex, without corners on a straight edge"),
        ({"shape": "polygon", "corners": [[1, 0], [-1, 1], [-1, -1], [1, 1], [-1, 2], [-2, -1]]}, "follow in their order"),
        (
            {"shape": "polygon", "corners": [[5, 0], [0, 1], [-1, 3], [-5, 0], [-3, -3], [0, -5]]},
            "[[5, 0], [0, 1], [-1, 3], [-5, 0], [-3, -3], ...]: the polygon must be convex",
        ),
        ({"shape": "polygon", "corners": [[5, 0], [0, 1], [-1, 3], [-5, 0], [0, -5]]}, "[-5, 0], [0, -5]]: the polygon must be convex"),
    ],
)  # fmt: skip
def test_a_region_must_hold_zero_and_be_convex_at_every_frequency_of_the_band(table: dict[str, Any], told: str) -> None:
    said = refusal(read_threshold(table).check, *BAND, None)
    assert told in said
    assert bool(told) == bool(said)
    if "shape" in table and table["shape"] == "polygon":
        assert turning(read_threshold(table).region.corners, Integer(5)) >= 0


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


@pytest.mark.parametrize(
    ("table", "told"),
    [
        ({"shape": "circle", "real": 1, "imag": 1}, 'shape: unknown shape "circle": valid are square, ellipse, diamond, polygon'),
        ({"shape": "diamnd", "real": 1, "imag": 1}, 'did you mean "diamond"?'),
        ({"real": 1}, "must give both real and imag"), ({"shape": "polygon"}, "corners is missing"),
        ({"real": 1, "imag": 1, "tilt": 0}, 'unknown key "tilt": it is of a ellipse; valid are shape, real, imag, floor, scale, proportion'),
        ({"shape": "ellipse", "real": 1, "imag": 1, "flor": 1}, 'unknown key "flor" of a ellipse: valid are shape, real, imag, tilt, scale'),
        ({"shape": "ellipse", "real": {"higher": 1, "lower": 2}, "imag": 1}, "real: limits for higher and lower are of a square alone"),
        ({"real": {"higher": 1}, "imag": 1}, "real: must be a number, or give both higher and lower"),
        ({"real": {"higher": 0, "lower": 1}, "imag": 1}, 'real: higher: "0" must be > 0'),
        ({"real": {"higher": 1, "lower": -1}, "imag": 1}, 'real: lower: "-1" must be > 0'),
        ({"real": 1, "imag": 1, "floor": 0}, 'floor: "0" must be > 0'), ({"real": 1, "imag": 1, "floor": [0, 1]}, "must be > 0"),
        ({"real": 1, "imag": 1, "floor": "1 kg"}, "floor: "), ({"real": [0, 1], "imag": 1}, 'real: "[0, 1]" must be > 0'),
        ({"like": "fu2019", "real": 1}, "a published threshold stands alone"), ({"real": 1, "imag": 1, "scale": 2}, "scale: must be a range"),
        ({"real": [1, 2], "imag": 1, "scale": [1, 2]}, "scale: has a range where no other number of the JND has one"),
        ({"shape": "polygon", "corners": [[1, 0], [0, 1]]}, "corners: must be a list of 3 to 24 pairs [x, y]"),
        ({"shape": "polygon", "corners": [[1, 0], [0, 1], [1]]}, "corners: 3: must be a pair [x, y]"),
        ({"shape": "polygon", "corners": [[1, 0], [0, "x"], [-1, -1]]}, "corners: 2: "),
        ({"shape": "polygon", "corners": "abc"}, "corners: must be a list"), ({"shape": "polygon", "corners": [[1, 0], "ab", [0, 1]]}, "corners: 2: must"),
        ({"shape": "polygon", "corners": [[i, i * i] for i in range(24)]}, ""),
        ({"shape": "polygon", "corners": [[i, i * i] for i in range(25)]}, "a list of 3 to 24 pairs"),
        ({"shape": "ellipse", "real": [1, 2], "imag": 1, "tilt": 0.5}, "a tilted ellipse of which one half width is larger"),
        ({"shape": "ellipse", "real": [1, 2], "imag": [1, 2], "tilt": 0.5}, ""), ({"shape": "ellipse", "real": [1, 2], "imag": 1}, ""),
        ({"real": "2*x", "imag": 1}, "a threshold is a number, a percentage, or a formula in omega (rad/s) and nothing else"),
        ({"real": "omega^0.5", "imag": 1}, "is no rational formula in omega"), ({"real": "omega*x", "imag": 1}, 'real: unknown name "x"'),
        ({"real": 1, "imag": 1, "proportion": 0.5}, "above 0.5"), ({"real": 1, "imag": 1, "proportion": 0.75}, ""),
    ],
)  # fmt: skip
def test_what_a_jnd_may_not_be_is_told_with_its_key(table: dict[str, Any], told: str) -> None:
    said = refusal(read_threshold, table)
    assert told in said
    assert bool(told) == bool(said)


def test_clockwise_corners_are_those_of_the_same_polygon_turned_round() -> None:
    corners = [[1, 0], [0, 2], [-1, -1]]
    one, other = (read_threshold({"shape": "polygon", "corners": x}).region.corners for x in (corners, corners[::-1]))
    assert one == other == tuple((Integer(x), Integer(y)) for x, y in corners)
    assert Region(Shape.POLYGON, corners=one).numbers == {}


def test_a_motion_of_a_floor_is_that_of_the_scene() -> None:
    table = {"real": 1, "imag": 1, "floor": "1 N*m/rad"}
    spring = hs.environments.mass_spring_damper
    assert "jnd: floor: is rotational, but the scene is translational" in refusal(
        Scene, spring(k="1 N/m"), threshold=table
    )
    for k in ("1 N*m/rad", 1):
        assert not refusal(Scene, spring(k=k), threshold=table)


def test_a_scene_that_is_not_there_is_sought_beside_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.toml").write_text('environment = { model = "kelvin-voigt", k = 1, b = 2 }', encoding="utf-8")
    for name, said in (("mine", 'did you mean "mine.toml"?'), ("mine.tml", 'did you mean "mine.toml"?'), ("fu2018", 'did you mean "fu2019"?'),
                       ("zzz", "the package ships "), ("\n", "this is a scene's text")):  # fmt: skip
        assert said in refusal(hs.load_scene, name)
    path = tmp_path / "long.toml"
    text = (tmp_path / "mine.toml").read_text(encoding="utf-8") + "\n#"
    path.write_text(text + " " * (1_000_000 - len(text)), encoding="utf-8")
    assert hs.load_scene(path).environment.model == "kelvin-voigt"
    path.write_text(text + " " * (1_000_001 - len(text)), encoding="utf-8")
    assert "the file has more than 1000000 bytes" in refusal(hs.load_scene, path)


@pytest.mark.parametrize("call", [hs.evaluate, lambda x: hs.tolerances(x)])
def test_values_that_divide_a_formula_by_zero_are_told_with_it(call: Any) -> None:
    given = ["0", "500"] if call is not hs.evaluate else 0
    link = hs.effects.two_port(A="1", B="0", C="1/q", D="1", parameters={"q": given})
    told = refusal(call, hs.Scene(hs.environments.kelvin_voigt(100, 2), (link,)))
    assert "1/q is divided by zero with q = 0" in told
