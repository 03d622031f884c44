"""The words of all pages: numbers that would look alike, intervals, thresholds and regions, of values drawn by lot."""

from __future__ import annotations

import random
from decimal import Decimal
from math import inf, nextafter, pi
from types import SimpleNamespace as Made
from typing import Any

import pytest
from sympy import Rational

import haptisym as hs
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.roots import Interval, Point
from haptisym.kernel.symbols import omega
from haptisym.model.jnd import Part
from haptisym.model.quantities import Dimension, MotionKind
from haptisym.pages import words
from haptisym.pages.bandwidths import published_words
from haptisym.pages.solved import Written
from haptisym.writing.document import Number, Phrase, Strong
from haptisym.writing.plain import said

SPRING = hs.environments.mass_spring_damper(k=100)


def text(phrase: Phrase) -> str:
    return said(phrase).replace("\xa0", " ")


def number(x: object) -> ExactNumber:
    return ExactNumber(Rational(str(x)))


def interval(low: object, high: object = None) -> Interval:
    first = Point(number(low), {}, {}, {})
    return Interval(first, first if high is None else Point(number(high), {}, {}, {}))


# Numbers


def test_numbers_in_order_are_told_apart_with_the_fewest_digits_that_do_it() -> None:
    pick = random.Random(6)
    for _ in range(80):
        start = Rational(pick.randint(1, 9999), pick.choice([1, 10, 1000]))
        steps = [
            pick.choice([Rational(0), Rational(1, 10**9), Rational(1, 10**7), Rational(1, 100), Rational(5)])
            for _ in range(4)
        ]
        values = [start + sum(steps[:n], Rational(0)) for n in range(5)]
        shown = words.unlike([ExactNumber(x) for x in values])
        alone = [words.short(ExactNumber(x)).digits for x in values]
        assert [x.value for x in shown] == [float(x) for x in values]
        for i, step in enumerate(steps):
            assert step == 0 or shown[i].digits != shown[i + 1].digits
        for i, x in enumerate(shown):
            beside = [alone[j] for j in (i - 1, i + 1) if 0 <= j < 5 and values[j] != values[i]]
            if alone[i] not in beside:
                assert x.digits == alone[i] or any(values[j] == values[i] for j in (i - 1, i + 1) if 0 <= j < 5)
    assert words.unlike([]) == []
    assert [x.digits for x in words.unlike([number("1.00000001"), number("1.00000002")])] == [
        "1.00000001",
        "1.00000002",
    ]
    near = [number(1), ExactNumber(1 + Rational(1, 10**49))]
    assert len({x.digits for x in words.unlike(near)}) == 2
    assert [x.digits for x in words.unlike([number("2.34"), number("2.341")], 3)] == ["2.34", "2.341"]


def test_bounds_are_rounded_up_to_three_digits() -> None:
    pick = random.Random(1)
    for _ in range(200):
        value = pick.random() * 10 ** pick.randint(-8, 8)
        told = Decimal(words.rounded_up(value))
        assert Decimal(value) <= told < Decimal(value) * Decimal("1.0101")
        assert len(told.normalize().as_tuple().digits) <= 3
    assert words.rounded_up(0.5) == "0.5"
    assert Decimal(words.rounded_up(nextafter(0.5, 1))) == Decimal("0.501")
    assert words.rounded_up(inf) == "unbounded"
    assert Decimal(words.rounded_up(0.0)) == 0


def test_a_number_is_told_with_its_double_and_a_frequency_in_hertz_too() -> None:
    x = number("20/3")
    assert words.short(x) == Number("6.6667", 20 / 3)
    assert words.exactly(x, 10) == Number("6.666666667", 20 / 3)
    assert (words.rounded(20 / 3), words.rounded(20 / 3, 2)) == (Number("6.6667", 20 / 3), Number("6.7", 20 / 3))
    assert words.hertz(x) == f"{20 / 3 / 2 / pi:.5g}"
    assert text(words.both(x)) == f"6.6667 rad/s ({20 / 3 / 2 / pi:.5g} Hz)"


def test_an_interval_is_told_by_its_ends_and_a_single_place_alone() -> None:
    assert text(words.span(interval(2, 3))) == "from 2 to 3 rad/s"
    assert text(words.span(interval(2))) == "at 2 rad/s (0.31831 Hz) alone"
    assert (text(words.ends(interval(2, 3))), text(words.ends(interval(2)))) == ("2 to 3", "2")
    assert text(words.ends(interval("2", "2.0000001"))) == "2 to 2.0000001"
    assert (
        text(words.spans([interval(1, 2), interval(3), interval(4, 5)]))
        == "from 1 to 2 rad/s, at 3 rad/s (0.47746 Hz) alone and from 4 to 5 rad/s"
    )
    assert text(words.places([interval(2).low, interval(3).low])) == "2 and 3 rad/s"


def test_a_page_has_the_title_of_its_scene_and_below_it_the_source_and_what_holds_besides() -> None:
    scene: Any = Made(title="", source="a book", asides=lambda: ["mind `x`", ""])
    assert words.title(scene) == "Untitled scene"
    assert words.title(Made(title="Wall")) == "Wall"  # type: ignore[arg-type]
    assert [text(x) for x in words.lead(scene)] == ["a book", "mind `x`"]
    assert [text(x) for x in words.lead(scene, [])] == ["a book"]
    assert [text(x) for x in words.lead(Made(source="", asides=lambda: ["no"]), ["yes"])] == ["yes"]  # type: ignore[arg-type]
    page = words.page_about(scene, [], "Kind", ["beside"])
    assert (page.title, page.kind, [text(x) for x in page.lead], page.blocks) == (
        "Untitled scene",
        "Kind",
        ["a book", "beside"],
        (),
    )


# Thresholds


def threshold(jnd: Any) -> hs.Threshold:
    found = hs.Scene(SPRING, (hs.effects.first_order_lag(20),), (1, 12), jnd).threshold
    assert isinstance(found, hs.Threshold)
    return found


@pytest.mark.parametrize(
    ("jnd", "told"),
    [
        ("0.1", "10 % of |H_env|"), ({"real": "0.05", "imag": "0.125"}, "5 % (real) and 12.5 % (imaginary) of |H_env|"), ("1/3", "33.3333 % of |H_env|"),
        ({"real": "omega/100", "imag": "omega/100"}, "0.01 omega of |H_env|"),
        ({"real": "omega/100", "imag": "0.2"}, "0.01 omega (real) and 20 % (imaginary) of |H_env|"),
        ({"real": {"higher": "0.1", "lower": "0.05"}, "imag": "0.1"}, "10 % higher or 5 % lower (real) and 10 % (imaginary) of |H_env|"),
        ({"real": {"higher": "0.1", "lower": "0.05"}, "imag": {"higher": "0.1", "lower": "0.05"}}, "10 % higher or 5 % lower (real) and 10 % higher or 5 % lower (imaginary) of |H_env|"),
        ({"real": "0.1", "imag": "0.1", "floor": "2 N/m"}, "10 % of |H_env|, and at least 2 N/m"),
        ({"shape": "ellipse", "real": "0.1", "imag": "0.1"}, "an ellipse, 10 % of |H_env|"),
        ({"shape": "ellipse", "real": "0.1", "imag": "0.2"}, "an ellipse, 10 % (real) and 20 % (imaginary) of |H_env|"),
        ({"shape": "ellipse", "real": "0.1", "imag": "0.2", "tilt": "0.5"}, "an ellipse, 10 % (real) and 20 % (imaginary) of |H_env|, tilt 0.5"),
        ({"shape": "polygon", "corners": [["0.1", "0"], ["0", "0.2"], ["-0.1", "-0.1"]]}, "a polygon with the corners (10 %, 0 %), (0 %, 20 %) and (-10 %, -10 %) of |H_env|"),
    ],
)  # fmt: skip
def test_a_threshold_is_told_by_its_numbers_and_a_region_by_its_shape_too(jnd: Any, told: str) -> None:
    assert text(words.limits(threshold(jnd))).replace("ω", "omega") == told


def test_rules_and_symbols_are_set_as_formulas_and_words_stay_words() -> None:
    assert text(words.rule(Made(rule="r_r <= c_real"))) == "r_r ≤ c_real"  # type: ignore[arg-type]
    assert text(words.rule(Made(rule="|G - 1| <= c"))) == "|G - 1| ≤ c"  # type: ignore[arg-type]
    assert text(words.rule(Made(rule="Re s >= 0"))) == "Re s ≥ 0"  # type: ignore[arg-type]
    assert text(words.symbol("omega_n")) == "ω_n"
    assert words.symbol("two words") == "two words"
    assert (text(words.amount(Rational(1, 8))), text(words.amount(omega / 2))) == ("12.5 %", "0.5 ω")
    assert text(words.compared(words.H_PERC, "<")) == "H_perc < 0"
    most: Any = {Part.REAL: Made(most=0.015625), Part.IMAG: Made(most=0.25)}
    assert text(words.bounds(most)) == "r_r by at most 0.0157 and r_i by at most 0.25"


def test_units_are_those_of_translation_where_nothing_tells_the_motion() -> None:
    assert [words.unit(Dimension.STIFFNESS, x) for x in (None, MotionKind.TRANSLATION, MotionKind.ROTATION)] == [
        "N/m",
        "N/m",
        "N·m/rad",
    ]
    assert words.stiffness_unit(hs.Scene(hs.environments.mass_spring_damper(k="2 N*m/rad"))) == "N·m/rad"


def test_remarks_are_a_block_and_none_are_none() -> None:
    assert words.noted([]) == ()
    assert [x.entries for x in words.noted(iter(["a", "b"]))] == [("a", "b")]
    assert words.caveats([]) == ()
    assert [x.entries for x in words.caveats(["it creaks"])] == [((Strong("But:"), " it creaks"),)]
    written = Written()
    assert written.section("T").blocks == ()


def test_a_display_is_transparent_throughout_only_from_one_end_of_the_band_to_the_other() -> None:
    ends = [Point(number(x), {}, {}, {}) for x in (0, 4, 15)]
    for found, told in (((ends[0], ends[2]), True), ((ends[0], ends[1]), False), ((ends[1], ends[2]), False)):
        e: Any = Made(transparent=(Interval(*found),), chart=Made(points=ends))
        assert words.is_transparent_throughout(e) is told
    for several in ((), (Interval(ends[0], ends[1]), Interval(ends[1], ends[2]))):
        assert not words.is_transparent_throughout(Made(transparent=several, chart=Made(points=ends)))  # type: ignore[arg-type]


def test_a_published_threshold_is_told_by_its_name_and_criterion_where_that_is_known() -> None:
    assert published_words(threshold("0.1")) == ""
    for x in hs.published():
        if x.apart:
            continue
        own = text(published_words(threshold({"like": x.name})))
        assert own.startswith(f", as `{x.name}`: {x.quantity}")
        assert own.endswith(f" ({x.source})")
        assert (" at " in own.removeprefix(f", as `{x.name}`: {x.quantity}").removesuffix(f" ({x.source})")) == (
            x.criterion is not None
        )
