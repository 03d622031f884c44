"""Values of a coefficient beside delays, holds, clocks and powers of s: what a certificate claims of them is so, and both checkers accept it."""

from __future__ import annotations

import json
import random
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from certificates import fractional_scene, hostile_slabs, late_scene, of_requirement, text_of
from forgeries import LATE_GAIN, slab, with_slabs
from secondchecker import verdicts
from sympy import Rational

import haptisym as hs
from haptisym.kernel.reals import ExactNumber
from haptisym_check import RefusedError, check

POWERED = """[environment]
model = "spring-pot"
k_alpha = 17
alpha = 0.2
k = 100
[[effects]]
model = "series"
G = "6/5 - s/1000"
[evaluation]
band = [0, 1]
jnd = "1/10"
"""
LATE_QUESTIONS = [(late_scene, seed) for seed in range(16)] + [(fractional_scene, seed) for seed in range(16)]


@pytest.mark.slow
@pytest.mark.parametrize("first", range(0, 32, 8))
def test_certificates_of_requirements_about_random_scenes_with_waves_are_accepted(first: int) -> None:
    """By both checkers; and what they claim an evaluation says at values near both ends of each interval, and between."""
    asked, without = [], 0
    for make, seed in LATE_QUESTIONS[first : first + 8]:
        text = make(seed)
        scene = hs.parse_scene(text)
        names = [x.path for x in scene.knobs if x.key not in ("tau", "T", "alpha") and "jnd." not in x.path]
        path = random.Random(seed).choice(names)
        try:
            proof = hs.require(scene, path, limit=20).certificate()
        except (
            hs.SceneError,
            hs.UndecidedError,
        ):  # a threshold for each part, values left open, too many terms or slabs
            without += 1
            continue
        assert check(proof.encode(), text.encode()).startswith("Proven"), (seed, path)
        asked.append((proof, text))
        for row in json.loads(proof)["claim"]["values"]:
            assert_evaluated(scene, path, row)
    assert without < 6
    assert [why for claim, why in verdicts(asked) if claim is None] == []


def assert_evaluated(scene: hs.Scene, path: str, row: list[Any]) -> None:
    """That it is transparent on its whole band, or not, for values between two."""
    first, last = (None if x is None else Fraction(x) for x in row[:2])
    low = first if first is not None else last - 1000 if last is not None else Fraction(-1000)
    high = last if last is not None else low + max(abs(low), 1)
    for share in (Fraction(1, 10**12), Fraction(1, 7), Fraction(5, 9), 1 - Fraction(1, 10**12)):
        x = low + (high - low) * share
        found = hs.evaluate(scene.with_values({path: Rational(x.numerator, x.denominator)})).transparent
        ends = [(float(y.low.omega), float(y.high.omega)) for y in found]
        assert (ends == [tuple(map(float, scene.band))]) is row[2], (path, x)


@pytest.mark.slow
@pytest.mark.parametrize("wrong", ["0.51", "0.5141359", "0.51414", "0.52"])
def test_wrong_values_beside_a_delay_get_no_certificate(wrong: str) -> None:
    """Of a threshold 51.41359916... per cent are needed."""
    found = hs.require("delayed-spring", "evaluation.jnd")
    [span] = found.feasible
    low = replace(span.low, value=ExactNumber(Rational(wrong)))
    with pytest.raises(hs.UndecidedError):
        replace(found, feasible=(replace(span, low=low),)).certificate()


@pytest.mark.slow
def test_slabs_of_which_forgeries_are_made_are_accepted_where_what_they_say_is_true() -> None:
    """At omega = 0, or near it, the ratio exceeds its threshold for all values beside 2."""
    late = [slab("21/10", "5/2", ["0"]), slab("5/2", "3", ["1/1000"])], [slab("2000001/1000000", "3", ["0"])]
    asked = [(with_slabs(*told), LATE_GAIN) for told in late]
    assert all(check(proof.encode(), text.encode()).startswith("Proven") for proof, text in asked)
    assert all(claim is not None for claim, _ in verdicts(asked))


@pytest.mark.slow
@pytest.mark.parametrize("scene", ["LATE_GAIN", "POWERED"])
def test_an_end_that_is_a_rational_number_lies_between_two_intervals(scene: str) -> None:
    """At omega = 0 the ratio is 1/5, and nowhere larger: bounds of a sine, or of a power of omega, show no zero there."""
    text = {"LATE_GAIN": LATE_GAIN, "POWERED": POWERED}[scene]
    proof = hs.require(hs.parse_scene(text), "evaluation.jnd").certificate()
    (_, high, before), (low, _, after) = json.loads(proof)["claim"]["values"]
    assert (before, after) == (False, True)
    assert Fraction(high) < Fraction(1, 5) < Fraction(low)
    assert Fraction(low) - Fraction(high) < Fraction(1, 10**14)
    assert check(proof.encode(), text.encode()).startswith("Proven")


@pytest.mark.slow
def test_fifty_digits_of_an_end_are_proven() -> None:
    proof = hs.require("delayed-spring", "evaluation.jnd", digits=50).certificate()
    (_, high, _), (low, _, _) = json.loads(proof)["claim"]["values"]
    assert Fraction(low) - Fraction(high) < Fraction(1, 10**49)
    assert check(proof.encode(), text_of("delayed-spring").encode()).startswith("Proven")


@pytest.mark.slow
def test_lists_of_delays_and_orders_may_be_empty_where_there_are_none() -> None:
    """A rational scene's certificate has them or not."""
    for name in ("from a value on", "a threshold above a delay"):
        proof, text = of_requirement(name)
        told = json.loads(proof)
        told["proof"] = {"delays": [], "orders": []} | told["proof"]
        assert check(json.dumps(told).encode(), text.encode()).startswith("Proven")
        assert verdicts([(json.dumps(told), text)])[0][0] is not None


@pytest.mark.slow
def test_slabs_that_ask_for_more_work_than_there_is_are_refused() -> None:
    listed = list(hostile_slabs())
    for name, proof, text in listed:
        with pytest.raises(RefusedError):
            check(proof.encode(), text.encode())
        assert name
    said = verdicts([(proof, text) for _, proof, text in listed], seconds=60)
    assert [name for (name, _, _), (claim, why) in zip(listed, said, strict=True) if claim or not why] == []


SHIPPED = {
    "delayed-spring": (2, 1, 0, 0), "four-channel-teleoperation": (9, 1, 0, 1), "position-force-teleoperation": (7, 1, 0, 0),
    "sampled-wall": (1, 2, 4, 0), "satellite-contact": (4, 1, 0, 0), "virtual-wall": (5, 1, 0, 0), "wave-variable-link": (5, 1, 0, 0),
    "organ-tissue": (1, 2, 3, 0),
}  # fmt: skip
"""How many of their numbers have certificates; are delays or orders; stand beside pi; have slabs without end."""


def test_the_numbers_of_shipped_scenes_are_those_that_the_page_counts() -> None:
    page = " ".join((Path(__file__).parents[2] / "docs" / "requirements.md").read_text(encoding="utf-8").split())
    kept, delays, beside, _ = map(sum, zip(*SHIPPED.values(), strict=True))
    assert (
        f"Of the {sum(map(sum, SHIPPED.values()))} parameters and thresholds of shipped scenes with such elements {kept} have one"
        in page
    )
    assert f"{delays} others are delays and an order, {beside} stand beside a frequency in Hz, and for one" in page


@pytest.mark.slow
@pytest.mark.parametrize("name", SHIPPED)
def test_the_numbers_of_a_shipped_scene_have_certificates_or_a_reason_for_none(name: str) -> None:
    scene, said, asked = hs.load_scene(name), [0, 0, 0, 0], []
    for knob in scene.knobs:
        if knob.path.startswith("evaluation.jnd."):
            continue
        try:
            proof = hs.require(scene, knob.path).certificate()
        except (hs.SceneError, hs.UndecidedError) as error:
            reasons = ("no delay and no power", "a scene without pi", "slabs of values")
            [at] = [i for i, x in enumerate(reasons, 1) if x in str(error)]
            said[at] += 1
            continue
        said[0] += 1
        asked.append((proof, scene.text))
        assert check(proof.encode(), scene.text.encode()).startswith("Proven")
    assert tuple(said) == SHIPPED[name]
    assert [why for claim, why in verdicts(asked) if claim is None] == []
