"""A certificate is accepted by a program that shares nothing with haptisym, and whatever is wrong in one is refused."""

from __future__ import annotations

import hashlib
import json
import os
import random
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise
from pathlib import Path
from typing import Any

import flint
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
    hostile,
    known_roots,
    late_scene,
    mutants,
    of_requirement,
    of_stability,
    random_scene,
    requirement_mutants,
    stability_mutants,
    text_of,
)
from marks import often, spread
from sympy import Rational, exp, pi

import haptisym as hs
from haptisym import effects, environments
from haptisym.cli import main
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.reals import ExactNumber, RealNumber
from haptisym.kernel.response import on_axis
from haptisym.kernel.symbols import s
from haptisym.model.expressions import evaluate
from haptisym.model.units import read_unit
from haptisym.verbs.evaluate.products import products
from haptisym.verbs.evaluate.waves import ORDER, wave_factor
from haptisym.verbs.evaluate.waves import WaveFactor as WrittenWaves
from haptisym_check import RefusedError, check
from haptisym_check.__main__ import main as checker_main
from haptisym_check.balls import SCALE, circle, power
from haptisym_check.formulas import CATALOGUE, Number, quantity, unit, units
from haptisym_check.formulas import evaluated as read_formula
from haptisym_check.link import Product
from haptisym_check.scene import Element, Scene
from haptisym_check.values import ONE, Point, Value, combined, degree
from haptisym_check.waves import WaveFactor, factor_of


def verdict(document: Any, scene: str) -> str:
    """What the checker says: the claim, or why not."""
    text = document if isinstance(document, str) else json.dumps(document)
    try:
        return check(text.encode(), scene.encode())
    except RefusedError as error:
        return f"refused: {error}"


# What is true is accepted.

QUICK = {
    "fu2019",
    "zener-tissue",
    "stick-with-friction",
    "integrator",
    "touches",
    "delayed-spring",
    "a clock",
    "a spring-pot",
}


@pytest.mark.parametrize("name", often([*RATIONAL, *OWN, *DELAYED, *RAISED], QUICK.__contains__))
def test_the_certificate_of_a_scene_is_accepted(name: str) -> None:
    e, claim = evaluated(name), json.loads(certificate(name))["claim"]
    assert verdict(certificate(name), text_of(name)).startswith("Proven on the band")
    assert claim["stable"] == (None if name in {"stick-with-friction", *DELAYED, *RAISED} else e.stable)
    ends = [[Fraction(x) for x in claim["frequencies"][row["at"]]] for row in claim["crossings"]]
    document = e.to_dict()
    assert [(row["part"], row["kind"], row["sign"], row["multiplicity"]) for row in claim["crossings"]] == [
        (row["part"], row["kind"], row["sign"], row["multiplicity"]) for row in document["crossings"]
    ]
    for (low, high), row in zip(ends, document["crossings"], strict=True):
        assert Fraction(row["enclosure"][0]) <= high
        assert low <= Fraction(row["enclosure"][1])


def test_what_the_witnesses_of_stability_are() -> None:
    stable = {name: json.loads(certificate(name))["claim"]["stable"] for name in OWN}
    assert stable == {
        **dict.fromkeys(OWN, True),
        **dict.fromkeys(("unstable", "pole on the axis", "integrator"), False),
    }


@pytest.mark.slow
@pytest.mark.parametrize("first", spread(range(0, 1000, 10), 3))
def test_certificates_of_random_scenes_are_accepted(first: int) -> None:
    for seed in range(first, first + 10):
        text = random_scene(seed)
        assert verdict(hs.evaluate(hs.parse_scene(text)).certificate(), text).startswith("Proven"), seed


WITHOUT_ROOM = {(fractional_scene, 7), (fractional_scene, 9)}
"""Of which a factor has more products of sines and powers than a certificate has room for."""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("make", "seed"),
    [
        *((late_scene, n) for n in (*spread(range(16), 2), 103)),
        *((fractional_scene, n) for n in (*spread(range(13), 2), 7, 9)),
    ],
)
def test_certificates_of_random_scenes_with_delays_and_powers_are_accepted(
    make: Callable[[int], str], seed: int
) -> None:
    text = make(seed)
    found = hs.evaluate(hs.parse_scene(text))
    if (make, seed) in WITHOUT_ROOM:
        with pytest.raises(hs.SceneError, match="a certificate has room for 300 products"):
            found.certificate()
    else:
        assert verdict(found.certificate(), text).startswith("Proven")


@pytest.mark.parametrize("name", HELD)
def test_certificates_about_stability_are_accepted(name: str) -> None:
    proof, text = of_stability(name)
    scene, hands = HELD[name]
    found, claim = hs.stability(hs.parse_scene(text_of(scene)), hands), json.loads(proof)["claim"]
    assert verdict(proof, text).startswith(f"Proven: {found.imposed.unstable} poles of H_perc in Re s >= 0")
    assert [x["unstable"] for x in claim["held"]] == [x.unstable for x in found.held]


@pytest.mark.parametrize("name", often(ASKED, lambda x: x not in WAVED))
def test_certificates_of_requirements_are_accepted(name: str) -> None:
    """Where the answer says that a set ends, the claim goes from what fails to what holds, and nothing is left out."""
    proof, text = of_requirement(name)
    found, claim = hs.require(hs.parse_scene(text), ASKED[name][1]), json.loads(proof)["claim"]
    assert verdict(proof, text).startswith("Proven of ")
    assert [row[:2] for row in claim["values"] if row[2]] == [
        [None if x is None else str(inward(x, side)) for x, side in ((span.low.value, 1), (span.high.value, 0))]
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


def test_a_requirement_of_one_of_several_environments_is_checked_by_name() -> None:
    text = OWN["nothing between"].replace("[environment]", '[[environments]]\nname = "a"') + FELT
    proof = hs.require(hs.parse_scene(text, environment="b"), "environment.k").certificate()
    assert json.loads(proof)["claim"]["free"] == ["environment", "k"]
    assert verdict(proof, text).startswith("Proven of environment.k")


FELT = """[[environments]]
name = "b"
model = "kelvin-voigt"
k = 10
b = 1
[environments.rendered]
model = "kelvin-voigt"
k = "environment.k"
b = 2
"""


@pytest.mark.parametrize("seed", often(range(0, 40, 4), (8,).__contains__))
def test_certificates_of_requirements_about_random_scenes_are_accepted(seed: int) -> None:
    text = random_scene(seed)
    for knob in [*hs.parse_scene(text).knobs][:3]:
        try:
            proof = hs.require(hs.parse_scene(text), knob.path, limit=20).certificate()
        except (hs.SceneError, hs.UndecidedError):
            continue  # a single value, pi beside it, an end that many slabs do not tell from a touch
        assert verdict(proof, text).startswith("Proven"), knob.path


def in_known_hand(polynomial: str) -> str:
    """A scene whose H_perc has these poles, in a hand with which 1 and these poles are all roots."""
    hand = "[hand]\nm = 3\nb = 2\nk = 5\n"
    return expression(f"({polynomial}) - 3*s^2 - 2*s - 5") + hand


def expression(formula: str) -> str:
    """A scene of this environment, in which w is 10 pi."""
    parameters = 'parameters = { w = "5 Hz" }\n' if "w" in formula else ""
    return f'[environment]\nmodel = "expression"\nH = "{formula}"\n{parameters}'


@pytest.mark.parametrize("first", often(range(0, 300, 3), (0,).__contains__, 3))
def test_roots_are_counted_where_it_is_known_how_many_there_are(first: int) -> None:
    for seed in range(first, first + 3):
        polynomial, count = known_roots(seed)
        text = in_known_hand(polynomial)
        proof = hs.stability(hs.parse_scene(text)).certificate()
        assert json.loads(proof)["claim"]["held"] == [{"hand": "hand", "unstable": count}], polynomial
        assert verdict(proof, text).startswith("Proven"), polynomial
        text = expression(f"(s^2 + s + 400)/({polynomial})")
        proof = hs.stability(hs.parse_scene(text)).certificate()
        assert verdict(proof, text).startswith(f"Proven: {count} poles"), polynomial


def test_a_hand_of_the_scene_is_that_of_the_scene() -> None:
    text = in_known_hand("s^3 + 2*s^2 + 3*s + 4")
    proof = hs.stability(hs.parse_scene(text)).certificate()
    other = text.replace("k = 5", "k = 6")
    forged = json.loads(proof) | {"scene_sha256": hashlib.sha256(other.encode()).hexdigest()}
    assert "not that of the scene" in verdict(forged, other)
    named = text.replace("[hand]", '[[hands]]\nname = "left"\nsource = "a book"')
    proof = hs.stability(hs.parse_scene(named)).certificate()
    assert json.loads(proof)["claim"]["held"] == [{"hand": "left", "unstable": 0}]
    assert verdict(proof, named).startswith("Proven")
    changed = hs.stability(hs.parse_scene(text), hs.Hand("hand", m="3 kg", b=2, k="4 N/m")).certificate()
    assert json.loads(changed)["claim"]["held"][0]["hand"] == {"m": "3", "b": "2", "k": "4"}
    assert verdict(changed, text).startswith("Proven")


def test_a_scene_of_several_environments_is_checked_by_name() -> None:
    text = (SCENES.parent / "families" / "palpation-device.toml").read_text(encoding="utf-8")
    proof = json.loads(hs.evaluate(hs.load_scene("palpation-device", "liver")).certificate())
    assert proof["environment"] == "liver"
    assert verdict(proof, text).startswith("Proven")
    for other in ("muscle", "none", None, 3):
        assert verdict({**proof, "environment": other}, text).startswith("refused")


def command(monkeypatch: pytest.MonkeyPatch, capsys: Any, *arguments: str) -> tuple[int, str]:
    """Exit status and standard error of haptisym."""
    monkeypatch.setattr("sys.argv", ["haptisym", *arguments])
    with pytest.raises(SystemExit) as stop:
        main()
    return int(stop.value.code or 0), capsys.readouterr().err


def test_the_commands_write_and_check(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    target, scene = tmp_path / "proof.json", tmp_path / "scene.toml"
    scene.write_text(text_of("fu2019"), encoding="utf-8")
    written = command(monkeypatch, capsys, "evaluate", str(scene), "--certificate", str(target))
    assert written == (0, f"certificate written to {target}\n")
    checker = [sys.executable, "-m", "haptisym_check", str(target), str(scene)]
    checked = subprocess.run(checker, capture_output=True, text=True, check=False)
    assert checked.returncode == 0
    assert "2 crossings, none missed" in checked.stdout
    scene.write_text(text_of("fu2019") + "\n", encoding="utf-8")
    refused = subprocess.run(checker, capture_output=True, text=True, check=False)
    assert (refused.returncode, refused.stdout) == (1, "NOT proven: the certificate is that of another scene file\n")
    assert subprocess.run(checker[:-1], capture_output=True, check=False).returncode == 2


def test_where_there_is_nothing_to_check_a_sentence_says_why(tmp_path: Path, capsys: Any) -> None:
    proof, scene, other = tmp_path / "proof.json", str(SCENES / "fu2019.toml"), tmp_path / "other.toml"
    proof.write_text(certificate("fu2019"), encoding="utf-8")
    other.write_text("[environment", encoding="utf-8")
    of_other = tmp_path / "of_other.json"
    digest = hashlib.sha256(other.read_bytes()).hexdigest()
    of_other.write_text(json.dumps(json.loads(certificate("fu2019")) | {"scene_sha256": digest}), encoding="utf-8")
    for asked, words in {
        ("missing.json",): "two files are needed: python -m haptisym_check FILE SCENE.toml",
        ("missing.json", scene): "missing.json cannot be read: No such file or directory",
        (str(proof), str(tmp_path)): f"{tmp_path} cannot be read: Is a directory",
        (str(proof), "a\0b"): "cannot be read: embedded null byte",
        (scene, str(proof)): "the certificate is no JSON: ",
        (str(of_other), str(other)): "the scene is no TOML: ",
    }.items():
        assert checker_main([*asked]) == 2
        said = capsys.readouterr()
        assert (said.out, words in said.err, said.err.count("\n")) == ("", True, 1)


def test_the_command_about_values_writes_one_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    target = tmp_path / "proof.json"
    asked = ("require", "fu2019", "--free", "zeta", "--certificate", str(target))
    assert command(monkeypatch, capsys, *asked) == (0, f"certificate written to {target}\n")
    said = verdict(target.read_text(encoding="utf-8"), text_of("fu2019")).splitlines()
    assert said[0] == "Proven of effects.0.zeta, real and imag part, on the whole band:"
    assert [line.split(" between ")[0].strip() for line in said[1:3]] == ["transparent", "not transparent"]
    assert said[3:] == ["  what binds: imag part"]
    twice = (*asked, "--free", "omega_n", "--range", "0.1", "1", "--range", "60", "90")
    assert "--certificate is about one parameter" in command(monkeypatch, capsys, *twice)[1]


def test_the_command_about_stability_writes_one_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    target = tmp_path / "proof.json"
    asked = ("stability", "fu2019", "--hand", "firm-grip", "--certificate", str(target))
    assert command(monkeypatch, capsys, *asked) == (0, f"certificate written to {target}\n")
    said = "Proven: 0 poles of H_perc in Re s >= 0 (imposed motion).\n  held in the hand m = 0, b = 8, k = 400: 0 roots in Re s >= 0"
    assert verdict(target.read_text(encoding="utf-8"), text_of("fu2019")) == said


def test_a_reader_that_has_gone_does_not_matter(tmp_path: Path) -> None:
    target = tmp_path / "proof.json"
    target.write_text(certificate("fu2019"), encoding="utf-8")
    reading, writing = os.pipe()
    os.close(reading)
    command = [sys.executable, "-m", "haptisym_check", str(target), str(SCENES / "fu2019.toml")]
    done = subprocess.run(command, stdout=writing, stderr=subprocess.PIPE, text=True, check=False)
    os.close(writing)
    assert (done.returncode, done.stderr) == (0, "")


def with_jnd(jnd: str) -> hs.Scene:
    """The paper's example with another threshold."""
    return hs.parse_scene(text_of("fu2019").replace("jnd = 0.10", f"jnd = {jnd}"))


def judged(jnd: str) -> hs.Evaluation:
    """The same, evaluated."""
    return hs.evaluate(with_jnd(jnd))


@pytest.mark.slow
def test_what_the_format_has_no_room_for_is_a_sentence(monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    lag = effects.first_order_lag(20)
    built = hs.Scene(environments.kelvin_voigt(290, 2), (lag,))
    fu2019 = hs.load_scene("fu2019")
    for question, words in {
        lambda: hs.evaluate(
            hs.parse_scene(text_of("a spring-pot").replace("0.3\n", '"20 deg"\n'))
        ): "orders together, each a rational",
        lambda: hs.stability("organ-tissue"): "needs a rational scene",
        lambda: hs.evaluate(built): "write the scene to one",
        lambda: hs.evaluate(fu2019.with_values({"omega_n": 40})): "was changed since it was read",
        lambda: hs.evaluate("fu2019", tolerance="0.1"): "without a tolerance",
        lambda: hs.metrics("fu2019"): "has no certificate",
        lambda: judged('{ shape = "diamond", real = 0.1, imag = 0.1 }'): "the JND is a diamond",
        lambda: judged("{ real = 0.1, imag = 0.1, floor = 15 }"): "with a floor",
        lambda: judged('"0.08 + 0.004*omega"'): "depends on omega",
        lambda: judged('{ like = "weight" }'): "as a number in the scene file",
        lambda: hs.evaluate("fu2019", digits=1001): "room for 1000 digits",
        lambda: hs.evaluate("zener-tissue", digits=91): "room for 90 digits",
        lambda: hs.stability(with_jnd('{ shape = "diamond", real = 0.1, imag = 0.1 }')): "the JND is a diamond",
        lambda: hs.require(
            with_jnd('{ shape = "ellipse", real = 0.1, imag = 0.1 }'), "omega_n"
        ): "the JND is an ellipse",
        lambda: hs.require(with_jnd('{ like = "weight" }'), "omega_n"): "as a number in the scene file",
        lambda: hs.require("fu2019", "omega_n", that=("stable",), hand="firm-grip"): "about what is transparent",
        lambda: hs.require("delayed-spring", "tau"): "a free number that is no delay and no power of s",
        lambda: hs.require("organ-tissue", "alpha"): "a free number that is no delay and no power of s",
        lambda: hs.require("organ-tissue", "k"): "needs a scene without pi",
        lambda: hs.require("zener-tissue", "environment.k0"): "needs a scene without pi",
        lambda: hs.require("fu2019", "evaluation.jnd.real"): "as a number of its own in the scene file",
        lambda: hs.stability("delayed-spring", "firm-grip"): "needs a rational scene",
        lambda: hs.stability("sampled-wall"): "needs a rational scene",
        lambda: hs.stability("stick-with-friction"): "needs real coefficients",
        lambda: hs.stability("sidestick", hs.Hand("odd", k="2 N*m/deg")): "needs the hand odd in the scene file",
    }.items():
        with pytest.raises(hs.SceneError, match=words):
            question().certificate()  # type: ignore[attr-defined]
    status, said = command(monkeypatch, capsys, "evaluate", "palpation-device", "--certificate", "x.json")
    assert (status, "--environment NAME" in said) == (2, True)


def test_a_requirement_of_stability_has_no_certificate_and_says_so() -> None:
    stable = hs.require("fu2019", "omega_n", that=("stable",), hand="firm-grip")
    with pytest.raises(hs.SceneError, match="about what is transparent"):
        stable.certificate()


FAR_APART = """[environment]
model = "kelvin-voigt"
k = 100
b = 5
[[effects]]
model = "delay"
tau = "1/7 s"
[[effects]]
model = "shunt"
m = 1
[[effects]]
model = "delay"
tau = "1/11 s"
[evaluation]
band = [0, 1]
"""


@pytest.mark.slow
def test_a_certificate_has_room_for_forty_sines() -> None:
    with pytest.raises(hs.SceneError, match="about 40 times a common one"):
        hs.evaluate(hs.parse_scene(FAR_APART)).certificate()


@pytest.mark.parametrize(("name", "digits"), often([("fu2019", 1000), ("zener-tissue", 90)], lambda x: x[1] == 90))
def test_digits_that_a_certificate_has_room_for_are_accepted(name: str, digits: int) -> None:
    proof = hs.evaluate(hs.parse_scene(text_of(name)), digits=digits).certificate()
    assert verdict(proof, text_of(name)).startswith("Proven")


@pytest.mark.parametrize("name", ["delayed-spring", "a spring-pot"])  # evaluated for other tests anyway
def test_among_delays_and_powers_there_is_room_for_50_digits(name: str) -> None:
    with pytest.raises(hs.SceneError, match="room for 50 digits"):
        replace(evaluated(name), digits=51).certificate()


# What is false is refused.


@pytest.mark.slow
@pytest.mark.parametrize("name", often([*OWN, *RATIONAL, *DELAYED, *RAISED[:2]], "integrator".__eq__))
def test_every_mutant_is_refused(name: str) -> None:
    passed = [
        what
        for what, x in spread([*mutants(json.loads(certificate(name)))], 1 if name in QUICK else 3)
        if not verdict(x, text_of(name)).startswith("refused")
    ]
    assert passed == []


@pytest.mark.few("on the axis")
@pytest.mark.parametrize("name", HELD)
def test_every_mutant_about_stability_is_refused(name: str) -> None:
    proof, text = of_stability(name)
    listed = stability_mutants(json.loads(proof))
    assert [what for what, x in listed if not verdict(x, text).startswith("refused")] == []


@pytest.mark.slow
@pytest.mark.parametrize("name", often(ASKED, {"a threshold"}.__contains__))
def test_every_mutant_about_values_is_refused(name: str) -> None:
    proof, text = of_requirement(name)
    listed = spread([*requirement_mutants(json.loads(proof))], 1 if name == "a threshold" else 3)
    assert [what for what, x in listed if not verdict(x, text).startswith("refused")] == []


@pytest.mark.slow
@pytest.mark.parametrize("wrong", often((15, 16), {16}.__contains__))
def test_wrong_values_get_no_certificate_that_passes(wrong: int) -> None:
    """Of a threshold 15.54 per cent are needed."""
    found = hs.require("fu2019", "evaluation.jnd")
    [span] = found.feasible
    low = replace(span.low, value=ExactNumber(Rational(wrong, 100)))
    with pytest.raises(hs.UndecidedError):
        replace(found, feasible=(replace(span, low=low),)).certificate()


def test_a_wrong_part_that_binds_gets_no_certificate_that_passes() -> None:
    found = hs.require("fu2019", "omega_n")
    [span] = found.feasible
    other = tuple(replace(x, criterion=next(y for y in found.criteria if y.name == "real")) for x in span.low.bindings)
    wrong = replace(found, feasible=(replace(span, low=replace(span.low, bindings=other)),))
    assert json.loads(wrong.certificate())["claim"]["binds"] == ["real"]
    assert verdict(wrong.certificate(), text_of("fu2019")).startswith("refused: binds: ")


@pytest.mark.parametrize("seed", often(range(40), (0, 1).__contains__))
def test_a_changed_character_is_refused_or_leaves_a_claim_that_is_true(seed: int) -> None:
    """A wider enclosure, or a breakpoint that is moved a little, proves what is true all the same."""
    source, e = random.Random(seed), evaluated("fu2019")
    text, own = certificate("fu2019"), json.loads(certificate("fu2019"))["claim"]
    for _ in range(40):
        at = source.randrange(len(text))
        other = text[:at] + source.choice('0123456789-/.E[]{}",: ant') + text[at + 1 :]
        if not verdict(other, text_of("fu2019")).startswith("refused"):
            claim = json.loads(other)["claim"]
            assert {**claim, "frequencies": None} == {**own, "frequencies": None}
            for (low, high), point in zip(claim["frequencies"], e.chart.points, strict=True):
                a, b = point.omega.bounds(200)
                assert Fraction(low) <= a <= b <= Fraction(high), other


def limited(code: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run with at most 20 seconds and 600 MB."""
    limit = "import resource\nresource.setrlimit(resource.RLIMIT_AS, (600_000_000, 600_000_000))\n"
    command = [sys.executable, "-c", limit + code, *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=20)


@pytest.mark.few(3)
@pytest.mark.parametrize("name", [name for name, _ in hostile()])
def test_hostile_documents_are_refused_in_bounded_time_and_memory(name: str, tmp_path: Path) -> None:
    file = tmp_path / "proof.json"
    file.write_text(dict(hostile())[name], encoding="utf-8", errors="surrogatepass")
    code = "import sys\nfrom haptisym_check.__main__ import main\nsys.exit(main(sys.argv[1:]))"
    done = limited(code, str(file), str(SCENES / "fu2019.toml"))
    if name in {"nothing", "deep", "deep objects", "a huge whole number"}:
        assert (done.returncode, done.stdout) == (2, "")
        assert done.stderr.startswith("the certificate is no JSON: ")
    else:
        assert (done.returncode, done.stderr) == (1, "")
        assert done.stdout.startswith("NOT proven: ")


@pytest.mark.few(6)
@pytest.mark.parametrize(
    "name",
    ["fu2019", "powers alone"],
)
@pytest.mark.parametrize(
    ("field", "wrong"),
    [("crossings", lambda x: x[:-1]), ("crossings", lambda x: (replace(x[0], sign=-x[0].sign), *x[1:])), ("transparent", lambda _: ()),
     ("percepts", lambda x: x[1:]), ("changeovers_perceived", lambda _: ()), ("outside_model", lambda _: None)],
)  # fmt: skip
def test_a_wrong_answer_gets_no_certificate_that_passes(field: str, wrong: Callable[[Any], Any], name: str) -> None:
    e = hs.evaluate(hs.parse_scene(text_of(name)))
    value = wrong(getattr(e, field))
    e.__dict__[field] = e.transparent if value is None else value
    assert verdict(e.certificate(), text_of(name)).startswith("refused")


def test_a_wrong_stability_gets_no_certificate_that_passes() -> None:
    for name, stable in (("fu2019", False), ("unstable", True)):
        assert verdict(replace(evaluated(name), stable=stable).certificate(), text_of(name)).startswith("refused")
    found = hs.stability("fu2019", "firm-grip")
    roots = replace(found.held[0].roots, number=1)
    wrong = replace(found, held=(replace(found.held[0], roots=roots),))
    assert verdict(wrong.certificate(), text_of("fu2019")).startswith("refused")
    assert verdict(
        replace(found, imposed=replace(found.imposed, unstable=2)).certificate(), text_of("fu2019")
    ).startswith("refused")


# What the checker reads.


def test_units_mean_what_haptisym_takes_them_for() -> None:
    known = [name for name in CATALOGUE["units"] if name != "1"]
    prefixed = [f"{x}{name}" for x in CATALOGUE["prefixes"] for name in known if CATALOGUE["units"][name][3]]
    for name in [*known, *prefixed, "N*s/m", "kg*m^2", "1/s"]:
        text = "1" if name == "1/s" else name
        factor, exponents = read_unit(name, name, "")
        mine = quantity(f"1 {name}") if name != "1/s" else units("/", unit("1"), unit("s"))
        assert [exponents.get(x, 0) for x in ("mass", "length", "time")] == mine.dimension, text
        assert factor == mine.value.numerator * pi**mine.pi / mine.value.denominator, text


@pytest.mark.parametrize(
    ("given", "value"),
    [([1, 3], 2), ([-3, 1], -1), (["1 mm", "4 mm"], Fraction(5, 2000)), ([1, 2, 9], 2), (["0.1", "0.2"], Fraction(3, 20)), ([5, 5], 5)],
)  # fmt: skip
def test_of_a_range_the_checker_takes_the_nominal_value_or_the_middle(given: list[Any], value: Any) -> None:
    assert quantity(given).value == value


@pytest.mark.parametrize(
    "change",
    [('model = "second-order-lowpass"', 'model = "third-order-lowpass"'), ('"80 rad/s"', '"80 rad"'), ('"80 rad/s"', '"80 furlong/s"'),
     ('"80 rad/s"', '"8O rad/s"'), ("zeta = 0.5", "zeta = 0.5\neta = 1"), ("zeta = 0.5", ""), ("[evaluation]", "[evaluation]\nx = 1"),
     ("jnd = 0.10", 'jnd = { shape = "diamond", real = 0.1, imag = 0.1 }'), ("jnd = 0.10", 'jnd = "0.08 + 0.004*omega"'),
     ("[evaluation]", "[x]\n[evaluation]"), ("zeta = 0.5", "zeta = nan"), ("zeta = 0.5", "zeta = 1e999999999"),
     ("[evaluation]", '[[effects]]\nmodel = "delay"\ntau = "1 ms"\n[evaluation]'),
     ("[evaluation]", '[[effects]]\nmodel = "series"\nG = "s(s)"\n[evaluation]'),
     ("[evaluation]", '[[effects]]\nmodel = "series"\nG = "__import__"\n[evaluation]'),
     ("[evaluation]", '[[effects]]\nmodel = "series"\nG = "((s^99)^99)^99"\n[evaluation]'),
     ("[evaluation]", f'[[effects]]\nmodel = "series"\nG = "{"(" * 900}s{")" * 900}"\n[evaluation]')],
)  # fmt: skip
def test_a_scene_that_is_not_understood_is_refused(change: tuple[str, str]) -> None:
    text = text_of("fu2019")
    assert change[0] in text
    with pytest.raises(RefusedError):
        Scene(text.replace(*change).encode(), None).at(Point((Value(0, 2, degree(0)), ONE), 1))


def test_formulas_are_read_as_haptisym_reads_them() -> None:
    for text in ("2*x^2 - (x + 1)/4", "-x^2", "2*-x", "x^-2 + x**(+3)", "1e-1*x/.5/x", "((x))", "- -x", "x^0"):
        top, bottom = read_formula(
            text, lambda word: (Value(3), ONE) if word == "x" else Number(Fraction(word)).at(1), combined
        )
        assert Fraction(top.re, bottom.re) == evaluate(text, number=Fraction, name={"x": Fraction(3)}.__getitem__), text


def test_cosines_and_sines_lie_within_their_bounds() -> None:
    with flint.ctx.workprec(500):
        for x in (
            Fraction(0),
            Fraction(1, 10**9),
            Fraction(1, 2),
            Fraction(355, 113),
            Fraction(22, 7) * 10**6,
            Fraction(10**12, 7),
        ):
            angle = flint.arb(flint.fmpq(x.numerator, x.denominator))
            for middle, true in zip(circle(x)[::3], (angle.cos(), angle.sin()), strict=True):
                assert abs(true * SCALE - middle) <= 2


@pytest.mark.parametrize("size", [Fraction(2**100_001), Fraction(1, 2**100_001), Fraction(0), Fraction(-1, 2)])
def test_powers_of_numbers_of_a_hundred_thousand_bits_or_below_0_are_refused(size: Fraction) -> None:
    with pytest.raises(RefusedError, match="too large, or too small"):
        power(size, Fraction(1, 2))


@pytest.mark.parametrize(
    ("told", "why"),
    [
        ({"number": "2", "powers": [[0, 1], [0, 2]]}, "stands twice"),
        ({"number": "2", "powers": [[0, 1], [0, 1]]}, "stands twice"),
        ({"number": "0", "powers": [[1, 1]]}, "zero everywhere"),
        ({"number": "2", "powers": [[2, 1]]}, "whole number from 0 to 1"),
        ({"number": "2", "powers": [[-1, 1]]}, "whole number from 0 to 1"),
        ({"number": "2", "powers": [[0, 101]]}, "whole number from -100 to 100"),
        ({"number": "2", "powers": [[0, True]]}, "whole number"),
        ({"number": "2", "powers": [[2.0, 1]]}, "whole number"),
        ({"number": 2, "powers": []}, "not written as one"),
        ({"number": "2", "powers": [[0, 1, 1]]}, "a list of 2 to 2"),
        ({"number": "2"}, "with the keys"),
    ],
)
def test_a_product_that_may_be_read_in_two_ways_is_refused(told: dict[str, Any], why: str) -> None:
    factors = [factor_of({"step": 1, "polynomial": [["-3"], [n]]}, (), ()) for n in ("1", "2")]
    assert Product({"number": "2/3", "powers": [[0, 1], [1, -2]]}, factors).powers == {0: 1, 1: -2}
    with pytest.raises(RefusedError, match=why):
        Product(told, factors)


@pytest.mark.parametrize(
    ("model", "least", "most"),
    [
        (lambda n: {"model": "sampled-loop", "T": "1 ms", "method": "tustin", "delay": n}, 0, 20),
        (lambda n: {"model": "pade-delay", "tau": "1 ms", "order": n}, 1, 10),
        (lambda n: {"model": "prony", "k0": 1, "k": [1] * n, "b": [2] * n}, 1, 20),
    ],
)
def test_the_checker_reads_elements_of_the_sizes_that_are_written_and_no_others(
    model: Any, least: int, most: int
) -> None:
    formulas = 1 if model(1)["model"] == "prony" else 4
    for n in (least, most):
        assert len(Element(model(n), formulas).texts) >= formulas
    for n in (least - 1, most + 1):
        with pytest.raises(RefusedError):
            Element(model(n), formulas)


FREE_BESIDE = """
environment = {{ model = "kelvin-voigt", k = 100, b = 2 }}
effects = [{{ model = "first-order-lag", omega_c = "{0}" }}]
hand = {{ m = 1 }}
evaluation = {{ band = ["0 rad/s", "{1}"], jnd = {2} }}
"""


@pytest.mark.parametrize(
    ("words", "path", "fits"),
    [
        (("80 rad/s", "15 rad/s", '"0.1"'), ["environment", "k"], True),
        (("80 rad/s", "15 rad/s", '"0.1"'), ["effects", 0, "omega_c"], True),
        (("80 rad/s", "15 rad/s", '"0.1"'), ["hand", "m"], False),
        (("80 rad/s", "15 rad/s", '"0.1"'), ["environment", "m"], False),
        (("13 Hz", "15 rad/s", '"0.1"'), ["environment", "k"], False),
        (("13 Hz", "15 rad/s", '"0.1"'), ["effects", 0, "omega_c"], True),
    ],
)
def test_a_number_is_left_free_where_it_counts_and_no_other_number_has_pi_in_it(
    words: tuple[str, str, str], path: list[str | int], *, fits: bool
) -> None:
    data = FREE_BESIDE.format(*words).encode()
    assert Scene(data, None).felt.numbers["k"].value == 100
    if fits:
        Scene(data, None, path)
        return
    with pytest.raises(RefusedError, match="free beside pi|has no such number"):
        Scene(data, None, path)


def test_powers_lie_within_their_bounds() -> None:
    with flint.ctx.workprec(12_000):
        for x in (
            Fraction(1),
            Fraction(1, 3),
            Fraction(10**9 + 7, 10**9),
            Fraction(7 * 10**40),
            Fraction(3, 10**300),
            Fraction(10**3000),
        ):
            for alpha in (Fraction(1, 5), Fraction(37, 100), Fraction(2**99, 2**100 - 1), Fraction(1, 2**99 + 1)):
                true = flint.arb(flint.fmpq(x.numerator, x.denominator)) ** flint.arb(
                    flint.fmpq(alpha.numerator, alpha.denominator)
                )
                middle, radius = power(x, alpha)
                assert abs(true * SCALE - middle) <= radius
                assert radius * 10**40 <= max(middle, SCALE)


@pytest.mark.parametrize("seed", often(range(200), range(10).__contains__))
def test_signs_of_sums_of_sines_are_true(seed: int) -> None:
    """What is told of a cell holds at 50 points of it, as balls of many bits have it; a sign at 0 is the one just above.

    Every other sum has powers of omega as well.
    """
    source = random.Random(seed)
    delays = [Fraction(source.randint(1, 9), source.randint(1, 9)) for _ in range(source.randint(1, 2))]
    waves = [source.randint(1, 3) for _ in delays]
    orders = [Fraction(source.randint(1, 8), 9) for _ in range(source.randint(1, 2) if seed % 2 else 0)]
    every = {tuple(source.randint(0, n) for n in [*waves, *[2] * (2 * len(orders))]) for _ in range(4)}
    terms = [
        [list(x), [[str(source.randint(-3, 3)), str(source.randint(-2, 2))] for _ in range(2)] + [["1"]]] for x in every
    ]
    a = Fraction(source.choice([0, source.randint(0, 60)]), 10)
    b = a + Fraction(source.randint(1, 60), 10)
    checker = WaveFactor({"waves": waves, "terms": terms}, tuple(delays), tuple(orders))
    rows = tuple((tuple(x), tuple(tuple(map(int, row)) for row in p)) for x, p in terms)
    writer = WrittenWaves(rows, tuple(waves), tuple(delays), tuple(orders))
    assert writer.told() == {"waves": waves, "terms": [[list(x), [*map(list, p)]] for x, p in terms]}
    assert writer.sign_at(b) == summed_at(delays, orders, waves, terms, b)
    there = {terms[0][0][1 + 2 * len(delays) :]: flags[:ORDER] for _, terms, flags in checker.beginnings}
    assert writer._beginnings == there
    try:
        _, told = checker.signs(a, b)
    except RefusedError:
        assert writer.moved(a, b) is None
        return
    assert writer.moved(a, b) == tuple(told)
    seen = [summed_at(delays, orders, waves, terms, a + (b - a) * Fraction(n, 50)) for n in range(1, 51)]
    assert seen[-1] == told[-1]
    assert summed_at(delays, orders, waves, terms, a + (b - a) / 10**9) == told[0]
    assert sum(x != y for x, y in pairwise([told[0], *seen])) == len(told) - 1


@pytest.mark.parametrize(
    ("terms", "there"),
    [
        ([[[0], [["1"]]], [[2], [["1"]]]], [0]),  # cos^2 + sin^2
        ([[[0], [["1"]]], [[2], [["-1"]]]], [0, 2, 4, 6, 8, 10, 12]),  # cos of the double angle
        ([[[1], [["1"]]]], [1, 3, 5, 7, 9, 11, 13]),
        ([[[0], [["0"], ["0"], ["-9"]]], [[2], [["4"], ["0"], ["-9"]]]], [4, 6, 8, 10, 12]),  # 4 sin^2 - 9 omega^2
        ([[[0], [["0", "1"]]], [[2], [["1", "1"]]]], [0, 2, 4, 6, 8, 10, 12]),  # pi + sin^2
    ],
)
def test_which_powers_of_omega_a_sum_of_waves_holds_at_0_is_exact(terms: list[Any], there: list[int]) -> None:
    """Of sines and cosines of 3 omega/2, of degree two together."""
    checker = WaveFactor({"waves": [2], "terms": terms}, (Fraction(3),))
    writer = WrittenWaves(
        tuple((tuple(x), tuple(tuple(map(int, r)) for r in p)) for x, p in terms), (2,), (Fraction(3),)
    )
    expected = [n in there for n in range(ORDER)]
    assert [flags[:ORDER] for _, _, flags in checker.beginnings] == [expected]
    assert writer._beginnings == {(): expected}


def test_a_sum_of_waves_that_is_0_at_a_number_has_no_sign_there() -> None:
    """cos^2 + sin^2 - omega."""
    one = ((1,), (-1,))
    writer = WrittenWaves((((0,), one), ((2,), one)), (2,), (Fraction(3),))
    places = [Fraction(1, 2), Fraction(1), 1 + Fraction(1, 10**40), 1 - Fraction(1, 10**40), Fraction(9)]
    assert [writer.sign_at(x) for x in places] == [1, 0, -1, 1, -1]
    assert writer.moved(Fraction(0), Fraction(1)) is None
    assert writer.moved(Fraction(1, 2), Fraction(9, 10)) == (1,)
    assert writer.moved(Fraction(9, 10), Fraction(11, 10)) == (1, -1)


@pytest.mark.parametrize("seed", range(20))
def test_a_polynomial_in_tangents_is_told_as_one_in_sines_and_cosines(seed: int) -> None:
    """Times the highest powers of the cosines; with any numbers for omega, pi, Re and Im of a power, sines and cosines."""
    source = random.Random(seed)
    count = source.randint(1, 2)
    names = ("omega", "pi", "x", "y", *(f"t{i}" for i in range(count)))
    context = flint.fmpq_mpoly_ctx.get(names, "lex")
    rows = {tuple(source.randint(0, 3) for _ in names): source.choice([-3, -1, 2, 5]) for _ in range(6)}
    factor = context.from_dict(rows)
    delays = tuple(Fraction(n + 1, 7) for n in range(count, 0, -1))
    found = wave_factor(factor, 4, delays, (Fraction(1, 3),))
    assert (found.delays, found.orders) == (delays, (Fraction(1, 3),))
    omega, number, x, y, *circles = (
        Fraction(source.randint(1, 30), source.randint(1, 9)) for _ in range(4 + 2 * count)
    )
    pairs = list(zip(circles[::2], circles[1::2], strict=True))  # sine and cosine, of the longest delay first
    value = Fraction(0)
    for turns, p in found.terms:
        term = x ** turns[count] * y ** turns[count + 1]
        for (sine, cosine), k, n in zip(pairs, turns, found.waves, strict=False):
            term *= sine**k * cosine ** (n - k)
        value += term * sum(c * number**i * omega**n for n, row in enumerate(p) for i, c in enumerate(row))
    expected = Fraction(0)
    for exponents, c in rows.items():
        term = c * omega ** exponents[0] * number ** exponents[1] * x ** exponents[2] * y ** exponents[3]
        for (sine, cosine), n in zip(pairs, exponents[:3:-1], strict=True):
            term *= (sine / cosine) ** n
        expected += term
    for (_, cosine), n in zip(pairs, found.waves, strict=True):
        expected *= cosine**n
    assert value == expected


def test_a_factor_has_room_for_forty_sines_of_a_delay_where_it_is_written_and_where_it_is_read() -> None:
    context = flint.fmpq_mpoly_ctx.get(("omega", "pi", "t"), "lex")
    for n in (40, 41):
        factor = context.from_dict({(1, 0, n): 2, (0, 0, 0): 3})
        told = {"waves": [n], "terms": [[[0], [["3"]]], [[n], [["0"], ["2"]]]]}
        if n == 40:
            assert wave_factor(factor, 2, (Fraction(1),)).told() == told
            assert WaveFactor(told, (Fraction(1),)).waves == (40,)
            continue
        with pytest.raises(hs.SceneError, match="about 40 times a common one"):
            wave_factor(factor, 2, (Fraction(1),))
        with pytest.raises(RefusedError):
            WaveFactor(told, (Fraction(1),))


@pytest.mark.parametrize(
    ("H", "fits"),
    [
        (exp(-s / 3), True),
        (exp(-s / (2**100 - 1)), True),
        (exp(-s / 2**100), False),
        (exp(-s * pi / 10), False),
    ],
)
def test_delays_of_a_certificate_are_rational_and_short(H: Any, *, fits: bool) -> None:
    f = on_axis(Ring.of([H]).convert(1 + H)).real
    if fits:
        assert products({"x": f}).factors
        return
    with pytest.raises(hs.SceneError, match="orders together, each a rational|of at most 30 digits"):
        products({"x": f})


def summed_at(delays: list[Fraction], orders: list[Fraction], waves: list[int], terms: list[Any], x: Fraction) -> int:
    """The sign of a sum of terms."""
    with flint.ctx.workprec(600):
        omega, total = flint.arb(flint.fmpq(x.numerator, x.denominator)), flint.arb(0)
        for turns, p in terms:
            own = sum(
                (int(c) * flint.arb.pi() ** i * omega**n for n, row in enumerate(p) for i, c in enumerate(row)),
                flint.arb(0),
            )
            for i, alpha in enumerate(orders):
                order = flint.arb(flint.fmpq(alpha.numerator, alpha.denominator))
                wave = (order * flint.arb.pi() / 2).sin_cos()[::-1]
                size = flint.arb(omega) ** order
                own *= (size * wave[0]) ** turns[len(delays) + 2 * i] * (size * wave[1]) ** turns[
                    len(delays) + 2 * i + 1
                ]
            for tau, k, n in zip(delays, turns, waves, strict=False):
                angle = omega * flint.fmpq(tau.numerator, 2 * tau.denominator)
                own *= angle.sin() ** k * angle.cos() ** (n - k)
            total += own
        assert not total.contains(0)
        return 1 if total > 0 else -1
