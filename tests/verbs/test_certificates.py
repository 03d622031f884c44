"""What is written as a certificate is accepted by a program that shares nothing with haptisym, and says what the answer says."""

from __future__ import annotations

import hashlib
import json
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
import pytest
from certificates import (
    ASKED,
    DELAYED,
    HELD,
    OWN,
    RAISED,
    RATIONAL,
    SCENES,
    WAVED,
    certificate,
    evaluated,
    fractional_scene,
    known_roots,
    late_scene,
    of_requirement,
    of_scene,
    of_stability,
    random_scene,
    stability,
    text_of,
    verdict,
)
from marks import often

import haptisym as hs
from haptisym import effects, environments
from haptisym.kernel.reals import RealNumber
from haptisym_check.__main__ import main as checker_main
from haptisym_check.scene import CATALOGUE, SceneFile
from haptisym_check.values import RefusedError

QUICK = {"fu2019", "a device", "zener-tissue", "integrator", "touches", "delayed-spring", "a clock", "a spring-pot"}
UNSTABLE = {"unstable", "pole on the axis", "integrator"}
LEFT_OPEN = {"stick-with-friction", "a device", *DELAYED, *RAISED}


@pytest.mark.dear("a clock", "a spring-pot", "fu2019", "zener-tissue")
@pytest.mark.parametrize("name", often([*RATIONAL, *OWN, *DELAYED, *RAISED], QUICK.__contains__))
def test_the_certificate_of_a_scene_is_accepted_and_claims_its_crossings(name: str) -> None:
    e, claim = evaluated(name), json.loads(certificate(name))["claim"]
    assert verdict(certificate(name), text_of(name)).startswith("Proven on the band")
    assert claim["stable"] == (None if name in LEFT_OPEN else name not in UNSTABLE)
    told = e.to_dict()["crossings"]
    keys = ("part", "kind", "sign", "multiplicity")
    assert [[row[key] for key in keys] for row in claim["crossings"]] == [[row[key] for key in keys] for row in told]
    for own, row in zip(claim["crossings"], told, strict=True):
        low, high = map(Fraction, claim["frequencies"][own["at"]])
        assert Fraction(row["enclosure"][0]) <= high
        assert low <= Fraction(row["enclosure"][1])


def evaluation_of(text: str) -> str:
    return hs.evaluate(hs.parse_scene(text)).certificate()


@pytest.mark.dear("10", "15", "5")
@pytest.mark.parametrize("seed", often(range(0, 300, 5), {0, 5, 10, 15}.__contains__))
def test_certificates_of_random_scenes_are_accepted(seed: int) -> None:
    text = random_scene(seed)
    assert verdict(evaluation_of(text), text).startswith("Proven")


@pytest.mark.slow
@pytest.mark.parametrize("make", [late_scene, fractional_scene])
@pytest.mark.parametrize("seed", range(0, 10, 2))
def test_certificates_of_random_scenes_with_delays_and_powers_are_accepted(
    make: Callable[[int], str], seed: int
) -> None:
    text = make(seed)
    assert verdict(evaluation_of(text), text).startswith("Proven")


@pytest.mark.few("imposed")
@pytest.mark.parametrize("name", HELD)
def test_certificates_about_stability_are_accepted_and_claim_what_was_counted(name: str) -> None:
    proof, text = of_stability(name)
    found, claim = stability(name), json.loads(proof)["claim"]
    assert verdict(proof, text).startswith(f"Proven: {found.imposed.unstable} poles of H_perc in Re s >= 0")
    assert [x["unstable"] for x in claim["held"]] == [x.unstable for x in found.held]


@pytest.mark.dear("a parameter of a formula", "from a value on", "none", "up to a value")
@pytest.mark.parametrize("name", often(ASKED, lambda x: x not in WAVED and x != "two intervals"))
def test_certificates_of_requirements_are_accepted_and_leave_no_value_out(name: str) -> None:
    """Where the answer says that a set ends, the claim goes from what fails to what holds."""
    proof, text = of_requirement(name)
    found, claim = hs.require(hs.parse_scene(text), ASKED[name][1]), json.loads(proof)["claim"]
    assert verdict(proof, text).startswith("Proven of ")
    assert [row[:2] for row in claim["values"] if row[2]] == [
        [None if x is None else str(inward(x, side)) for x, side in ((span.low, 1), (span.high, 0))]
        for span in found.feasible
    ]
    assert (claim["values"][0][0], claim["values"][-1][1]) == (None if found.domain.low is None else "0", None)
    assert claim["binds"] == [end.bindings[0].criterion.name for end in found.ends]
    for (_, high, a), (low, _, b) in pairwise(claim["values"]):
        assert a is not b
        assert 0 <= Fraction(low) - Fraction(high) <= Fraction(1, 10**13) * abs(Fraction(low))


def inward(x: RealNumber, side: int) -> Fraction:
    """An end of the enclosure of a number."""
    return Fraction(x.enclosure(15)[side])


@pytest.mark.slow
@pytest.mark.parametrize("seed", often(range(0, 40, 4), (8,).__contains__))
def test_certificates_of_requirements_about_random_scenes_are_accepted(seed: int) -> None:
    text, accepted = random_scene(seed), 0
    for knob in [*hs.parse_scene(text).knobs][:3]:
        try:
            proof = hs.require(hs.parse_scene(text), knob.path, limit=20).certificate()
        except (hs.SceneError, hs.UndecidedError):
            continue  # a single value, pi beside it, an end that many slabs do not tell from a touch
        assert verdict(proof, text).startswith("Proven"), knob.path
        accepted += 1
    assert accepted or seed != 8


# Roots in Re s >= 0 of which the number is known


def expression(formula: str) -> str:
    """A scene of this environment, in which w is 10 pi."""
    parameters = 'parameters = { w = "5 Hz" }\n' if "w" in formula else ""
    return f'[environment]\nmodel = "expression"\nH = "{formula}"\n{parameters}'


def in_known_hand(polynomial: str) -> str:
    """A scene whose H_perc has no poles, in a hand with which the zeros of this are all roots."""
    return expression(f"({polynomial}) - 3*s^2 - 2*s - 5") + "[hand]\nm = 3\nb = 2\nk = 5\n"


@pytest.mark.dear("0")
@pytest.mark.parametrize("seed", often(range(40), (0, 2).__contains__))
def test_roots_are_counted_where_it_is_known_how_many_there_are(seed: int) -> None:
    polynomial, count = known_roots(seed)
    text = in_known_hand(polynomial)
    proof = hs.stability(hs.parse_scene(text)).certificate()
    assert json.loads(proof)["claim"]["held"] == [{"hand": "hand", "unstable": count}], polynomial
    assert verdict(proof, text).startswith("Proven"), polynomial
    text = expression(f"(s^2 + s + 400)/({polynomial})")
    proof = hs.stability(hs.parse_scene(text)).certificate()
    assert verdict(proof, text).startswith(f"Proven: {count} poles"), polynomial


@pytest.mark.dear("1")
@pytest.mark.parametrize("seed", often(range(8), (0, 1).__contains__))
def test_poles_are_counted_where_powers_are_missing(seed: int) -> None:
    """So that the real or the imaginary part on the axis begins late, ends early or is 0: against NumPy's roots."""
    draw, counted = Random(seed), 0
    for _ in range(6):
        p = [
            draw.choice([-2, 1, 3]),
            *(draw.choice([0, 0, draw.randint(-5, 5)]) for _ in range(5)),
            draw.choice([1, 4]),
        ]
        roots = np.roots(p)
        if min(abs(roots.real)) < 1e-6:
            continue
        text = expression(f"1/({' + '.join(f'({c})*s^{6 - i}' for i, c in enumerate(p))})")
        try:
            proof = hs.stability(hs.parse_scene(text)).certificate()
        except hs.UndecidedError:
            continue  # the real part has a zero of order two, which no cells tell
        assert verdict(proof, text).startswith(f"Proven: {sum(roots.real > 0)} poles"), p
        counted += 1
    assert counted > 1


# Hands and environments of a file


@pytest.mark.slow
def test_a_hand_of_the_scene_is_that_of_the_scene() -> None:
    text = in_known_hand("s^3 + 2*s^2 + 3*s + 4")
    proof = hs.stability(hs.parse_scene(text)).certificate()
    other = text.replace("k = 5", "k = 6")
    assert "not that of the scene" in verdict(of_scene(json.loads(proof), other), other)
    named = text.replace("[hand]", '[[hands]]\nname = "left"\nsource = "a book"')
    proof = hs.stability(hs.parse_scene(named)).certificate()
    assert json.loads(proof)["claim"]["held"] == [{"hand": "left", "unstable": 0}]
    assert verdict(proof, named).startswith("Proven")
    changed = hs.stability(hs.parse_scene(text), hs.Hand("hand", m="3 kg", b=2, k="4 N/m")).certificate()
    assert json.loads(changed)["claim"]["held"][0]["hand"] == {"m": "3", "b": "2", "k": "4"}
    assert verdict(changed, text).startswith("Proven")


TWO = OWN["nothing between"].replace("[environment]", '[[environments]]\nname = "a"') + (
    '[[environments]]\nname = "b"\nmodel = "kelvin-voigt"\nk = 10\nb = 1\n'
    '[environments.rendered]\nmodel = "kelvin-voigt"\nk = "environment.k"\nb = 2\n'
)


def test_one_of_several_environments_is_checked_by_its_name() -> None:
    scene = hs.parse_scene(TWO, environment="b")
    proof = json.loads(hs.evaluate(scene).certificate())
    assert proof["environment"] == "b"
    assert verdict(proof, TWO).startswith("Proven on the band")
    for other in ("a", "none", None, 3):
        assert verdict({**proof, "environment": other}, TWO).startswith("refused")
    values = hs.require(scene, "environment.k").certificate()
    assert json.loads(values)["claim"]["free"] == ["environment", "k"]
    assert verdict(values, TWO).startswith("Proven of environment.k")


# The commands


@pytest.mark.few("asked2-lines2")
@pytest.mark.parametrize(
    ("asked", "lines"),
    [
        (("evaluate", "fu2019"), ["Proven on the band from 0 to 15 rad/s: 2 crossings, none missed."]),
        (
            ("require", "fu2019", "--free", "zeta"),
            ["Proven of effects.0.zeta, real and imag part, on the whole band:", "what binds: imag part"],
        ),
        (
            ("stability", "fu2019", "--hand", "firm-grip"),
            [
                "Proven: 0 poles of H_perc in Re s >= 0 (prescribed motion).",
                "held in the hand m = 0, b = 8, k = 400: 0 roots in Re s >= 0",
            ],
        ),
    ],
)
def test_a_command_writes_one_that_says_what_is_proven(
    asked: tuple[str, ...], lines: list[str], tmp_path: Path, call: Any
) -> None:
    target = tmp_path / "proof.json"
    status, _, err = call(*asked, "--certificate", str(target))
    assert (status, err) == (0, f"certificate written to {target}\n")
    said = [x.strip() for x in verdict(target.read_text(encoding="utf-8"), text_of("fu2019")).splitlines()]
    assert [x for x in said if x in lines] == lines


@pytest.mark.slow
def test_the_checker_is_a_program_that_proves(tmp_path: Path) -> None:
    proof, scene = tmp_path / "proof.json", SCENES / "fu2019.toml"
    proof.write_text(certificate("fu2019"), encoding="utf-8")
    command = [sys.executable, "-m", "haptisym_check", str(proof), str(scene)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, "2 crossings, none missed" in done.stdout) == (0, True)


def test_the_checker_tells_what_is_refused_and_what_cannot_be_read_by_its_status(tmp_path: Path, capsys: Any) -> None:
    proof, scene = tmp_path / "proof.json", SCENES / "fu2019.toml"
    proof.write_text(certificate("fu2019"), encoding="utf-8")
    changed, broken = tmp_path / "changed.toml", tmp_path / "broken.toml"
    changed.write_text(text_of("fu2019") + "\n", encoding="utf-8")
    assert checker_main([str(proof), str(changed)]) == 1
    assert capsys.readouterr().out == "NOT proven: the certificate is that of another scene file\n"
    broken.write_text("[environment", encoding="utf-8")
    told = json.loads(certificate("fu2019")) | {"scene_sha256": hashlib.sha256(broken.read_bytes()).hexdigest()}
    (tmp_path / "of_broken.json").write_text(json.dumps(told), encoding="utf-8")
    for asked, words in {
        ("missing.json",): "two files are needed",
        ("missing.json", str(scene)): "missing.json cannot be read",
        (str(scene), str(proof)): "the certificate is no JSON",
        (str(tmp_path / "of_broken.json"), str(broken)): "the scene is no TOML",
    }.items():
        assert checker_main([*asked]) == 2
        said = capsys.readouterr()
        assert (said.out, words in said.err, said.err.count("\n")) == ("", True, 1)


# What has no certificate


def with_jnd(jnd: str) -> hs.Scene:
    """The paper's example with another threshold."""
    return hs.parse_scene(text_of("fu2019").replace("jnd = 0.10", f"jnd = {jnd}"))


def in_a_row(count: int) -> str:
    """A scene of so many lags in Hz."""
    lag = '[[effects]]\nmodel = "second-order-lowpass"\nomega_n = "{} Hz"\nzeta = 0.5\n'
    behind = "".join(lag.format(12 + n) for n in range(count))
    return f'[environment]\nmodel = "kelvin-voigt"\nk = 290\nb = 2\n{behind}[evaluation]\nband = [0, 15]\n'


def with_powers(formula: str) -> str:
    """A scene of this environment, behind a lag."""
    lag = '[[effects]]\nmodel = "first-order-lag"\nomega_c = 20\n'
    return f'[environment]\nmodel = "expression"\nH = "{formula}"\n{lag}[evaluation]\nband = [1, 15]\n'


FAR_APART = (
    '[environment]\nmodel = "kelvin-voigt"\nk = 100\nb = 5\n[[effects]]\nmodel = "delay"\ntau = "1/7 s"\n'
    '[[effects]]\nmodel = "shunt"\nm = 1\n[[effects]]\nmodel = "delay"\ntau = "1/11 s"\n[evaluation]\nband = [0, 1]\n'
)
BUILT = hs.Scene(environments.kelvin_voigt(290, 2), (effects.first_order_lag(20),))
DIAMOND = '{ shape = "diamond", real = 0.1, imag = 0.1 }'
NONE: dict[str, tuple[Callable[[], Any], str]] = {
    "built in Python": (lambda: hs.evaluate(BUILT), "write the scene to a file"),
    "changed": (lambda: hs.evaluate(hs.load_scene("fu2019").with_values({"omega_n": 40})), "was changed since"),
    "with a tolerance": (lambda: hs.evaluate("fu2019", tolerance="0.1"), "leave out the tolerance"),
    "another verb": (lambda: hs.metrics("fu2019"), "has no certificate"),
    "a diamond": (lambda: hs.evaluate(with_jnd(DIAMOND)), "the JND is a diamond"),
    "a floor": (lambda: hs.evaluate(with_jnd("{ real = 0.1, imag = 0.1, floor = 15 }")), "with a floor"),
    "a formula": (lambda: hs.evaluate(with_jnd('"0.08 + 0.004*omega"')), "depends on omega"),
    "a named JND": (lambda: hs.evaluate(with_jnd('{ like = "weight" }')), "as a number in the scene file"),
    "a thousand digits": (lambda: hs.evaluate("fu2019", digits=1001), "at most 1000 digits"),
    "digits beside pi": (lambda: hs.evaluate("zener-tissue", digits=91), "at most 90 digits"),
    "digits beside a delay": (lambda: replace(evaluated("delayed-spring"), digits=51), "at most 50 digits"),
    "stability, a diamond": (lambda: hs.stability(with_jnd(DIAMOND)), "the JND is a diamond"),
    "stability, a delay": (lambda: hs.stability("delayed-spring", "firm-grip"), "needs a rational scene"),
    "stability, a clock": (lambda: hs.stability("sampled-wall"), "needs a rational scene"),
    "stability, friction": (lambda: hs.stability("stick-with-friction"), "need real coefficients"),
    "stability, nothing felt": (lambda: hs.stability(hs.parse_scene(with_powers("s - s + 1").replace("first-order-lag\"\nomega_c = 20", 'series"\nG = "s - s"'))), "the force is zero"),
    "stability, a hand in degrees": (lambda: hs.stability("sidestick", hs.Hand("odd", k="2 N*m/deg")), "needs the hand odd in the scene file"),
    "values, stable": (lambda: hs.require("fu2019", "omega_n", that=("stable",), hand="firm-grip"), "about what is transparent"),
    "values, a delay": (lambda: hs.require("delayed-spring", "tau"), "that is no delay and no power of s"),
    "values, pi": (lambda: hs.require("zener-tissue", "environment.k0"), "needs a scene without pi"),
    "values, half a JND": (lambda: hs.require("fu2019", "evaluation.jnd.real"), "as a number of its own in the scene file"),
    "an order with pi": (lambda: hs.evaluate(hs.parse_scene(text_of("a spring-pot").replace("0.3\n", '"20 deg"\n'))), "orders together, each a rational"),
    "forty sines": (lambda: hs.evaluate(hs.parse_scene(FAR_APART)), "about 40 times a common one"),
    "many lags": (lambda: hs.evaluate(hs.parse_scene(in_a_row(9))), "too large for the checker: the degrees are too high"),
    "powers that cancel": (lambda: hs.evaluate(hs.parse_scene(with_powers("300 + s^0.5 - s^0.5"))), "too large for the checker: .* no such order"),
}  # fmt: skip


@pytest.mark.dear("another verb")
@pytest.mark.few(
    "built in Python", "changed", "another verb", "a diamond", "a thousand digits", "digits beside a delay",
    "stability, friction", "values, stable", "values, half a JND",
)  # fmt: skip
@pytest.mark.parametrize("what", NONE)
def test_what_the_format_has_no_room_for_is_said(what: str) -> None:
    ask, words = NONE[what]
    with pytest.raises(hs.SceneError, match=words):
        ask().certificate()


@pytest.mark.slow
@pytest.mark.parametrize(("name", "digits"), often([("fu2019", 1000), ("zener-tissue", 90)], lambda x: x[1] == 90))
def test_digits_that_a_certificate_has_room_for_are_accepted(name: str, digits: int) -> None:
    proof = hs.evaluate(hs.parse_scene(text_of(name)), digits=digits).certificate()
    assert verdict(proof, text_of(name)).startswith("Proven")


def test_the_checker_knows_what_the_hand_carries_of_each_device() -> None:
    carried = {
        name: {key: x[key].written for key in ("m", "b", "friction") if key in x} for name, x in hs.devices.items()
    }
    assert CATALOGUE["devices"] == {name: x for name, x in carried.items() if "m" in x or "b" in x}


@pytest.mark.parametrize(
    ("old", "new", "why"),
    [
        ('"one-axis"', '"touch"', "the device is not known"), ('b = "1 N*s/m"', 'c = 1', "not understood"),
        ('like = "one-axis"', 'like = "phri-master"', "number of the device is missing"),
    ],
)  # fmt: skip
def test_a_device_that_the_checker_does_not_know_is_refused(old: str, new: str, why: str) -> None:
    with pytest.raises(RefusedError, match=why):
        SceneFile(text_of("a device").replace(old, new).encode(), None)


def test_a_device_of_other_numbers_is_not_what_was_proven() -> None:
    text, proof = text_of("a device"), json.loads(certificate("a device"))
    other = text.replace("1 N*s/m", "2 N*s/m")
    proof["scene_sha256"] = json.loads(evaluation_of(other))["scene_sha256"]
    assert not verdict(json.dumps(proof), other).startswith("Proven")


@pytest.mark.parametrize("name", ["geared-arm", "wheel-with-encoder"])
def test_a_scene_that_no_checker_reads_gets_no_certificate(name: str) -> None:
    with pytest.raises(hs.SceneError, match="a checker has no arc sines and staircases"):
        hs.evaluate(name).certificate()
