"""The checker of report pages, in another language, run by Node: of rational scenes it accepts and refuses as the first, and finds crossings."""

from __future__ import annotations

import hashlib
import json
import tomllib
from collections.abc import Sequence
from decimal import Decimal
from fractions import Fraction
from typing import Any

import pytest
from certificates import (
    DELAYED,
    HELD,
    OWN,
    RAISED,
    RATIONAL,
    SCENES,
    WAVED,
    certificate,
    hostile,
    mutants,
    of_requirement,
    of_stability,
    random_scene,
    text_of,
    verdict,
)
from hypothesis import given
from hypothesis import strategies as st
from marks import examples
from secondchecker import catalogue, run, verdicts
from sympy import pi

import haptisym as hs
from haptisym.judge.crossings import CrossingKind

FEW = ("fu2019", "integrator", "touches")
"""Scenes of few effects."""
OTHERS = [x for x in (*RATIONAL, *OWN) if x not in FEW]


@pytest.mark.slow
@pytest.mark.parametrize("names", [FEW, pytest.param(OTHERS, marks=pytest.mark.slow)], ids=["a few", "the others"])
def test_the_certificate_of_every_scene_is_accepted_and_that_of_another_scene_is_not(names: Sequence[str]) -> None:
    said = verdicts([(certificate(x), text_of(x)) for x in names])
    for name, (claim, why) in zip(names, said, strict=True):
        assert claim == json.loads(certificate(name))["claim"], (name, why)
    for claim, why in verdicts([(certificate(names[0]), text) for text in (text_of(names[0]) + "\n", "")]):
        assert claim is None
        assert "another scene" in why


@pytest.mark.parametrize("name", ["delayed-spring", pytest.param([*DELAYED, *RAISED, *WAVED], marks=pytest.mark.slow)])
def test_what_is_proven_of_a_scene_that_is_not_rational_is_for_the_first_checker_alone(name: Any) -> None:
    names = [name] if isinstance(name, str) else name
    asked = [of_requirement(x) if x in WAVED else (certificate(x), text_of(x)) for x in names]
    assert [x for x, (proof, scene) in zip(names, asked, strict=True) if "Proven" not in verdict(proof, scene)] == []
    assert [x for x, (claim, why) in zip(names, verdicts(asked), strict=True) if claim or not why] == []


@pytest.mark.slow
@pytest.mark.parametrize("first", [0, 400])
def test_certificates_of_random_scenes_are_accepted(first: int) -> None:
    texts = [random_scene(seed) for seed in range(first, first + 40)]
    asked = [(hs.evaluate(hs.parse_scene(text)).certificate(), text) for text in texts]
    assert [why for _, why in verdicts(asked)] == [""] * len(asked)


@pytest.mark.slow
def test_a_scene_of_several_environments_is_checked_by_name() -> None:
    text = (SCENES.parent / "families" / "palpation-device.toml").read_text(encoding="utf-8")
    proof = json.loads(hs.evaluate(hs.load_scene("palpation-device", "liver")).certificate())
    asked = [json.dumps({**proof, "environment": x}) for x in ("liver", "muscle", "none", None, 3)]
    assert [not why for _, why in verdicts([(x, text) for x in asked])] == [True, False, False, False, False]


REQUIRED = ("from a value on", "up to a value", "none", "a threshold")


@pytest.mark.slow
@pytest.mark.few("stability")
@pytest.mark.parametrize("kind", ["stability", "requirements"])
def test_certificates_of_other_questions_are_accepted(kind: str) -> None:
    asked = [of_stability(x) for x in HELD] if kind == "stability" else [of_requirement(x) for x in REQUIRED]
    for (proof, _), (claim, why) in zip(asked, verdicts(asked), strict=True):
        assert claim == json.loads(proof)["claim"], why


QUESTIONS = {
    "integrator": lambda: (certificate("integrator"), text_of("integrator")),
    "fu2019": lambda: (certificate("fu2019"), text_of("fu2019")),
    "a hand": lambda: of_stability("a hand"),
    "a threshold": lambda: of_requirement("a threshold"),
}


@pytest.mark.slow
@pytest.mark.few("integrator")
@pytest.mark.parametrize("name", QUESTIONS)
def test_every_mutant_is_refused(name: str) -> None:
    proof, text = QUESTIONS[name]()
    listed = [(what, json.dumps(x)) for what, x in mutants(json.loads(proof))]
    listed = listed[:: 1 + len(listed) // 60]
    said = verdicts([(x, text) for _, x in listed])
    assert [what for (what, _), (claim, _) in zip(listed, said, strict=True) if claim] == []


@pytest.mark.slow
def test_hostile_documents_are_refused_in_bounded_time_and_memory() -> None:
    listed = list(hostile())
    said = verdicts([(x, text_of("fu2019")) for _, x in listed], seconds=60)
    assert [name for (name, _), (claim, why) in zip(listed, said, strict=True) if claim or not why] == []


# What it reads


@pytest.mark.slow
def test_its_sha_256_is_that_of_the_standard() -> None:
    texts = ["", "abc", "a" * 55, "a" * 56, "a" * 64, "ω Δ \N{SNOWMAN} \U0001f600" * 99]
    code = "const c = require(process.argv[1]); const t = JSON.parse(require('fs').readFileSync(0, 'utf8'));"
    said = run(code + "process.stdout.write(JSON.stringify(t.map(c.sha256)))", texts, 60)
    assert said == [hashlib.sha256(x.encode()).hexdigest() for x in texts]


TOML = """
const c = require(process.argv[1]);
const plain = (x) => x instanceof Map ? Object.fromEntries([...x].map(([k, y]) => [k, plain(y)])) : Array.isArray(x) ? x.map(plain)
  : x && x.whole ? `${x.whole.n}` : x && x.d ? `${x.n}/${x.d}` : x;
const read = (t) => { try { return plain(c.toml(t)); } catch (error) { return null; } };
process.stdout.write(JSON.stringify(JSON.parse(require("fs").readFileSync(0, "utf8")).map(read)));
"""


def plain(x: Any) -> Any:
    """The same of what Python reads."""
    if isinstance(x, dict):
        return {key: plain(y) for key, y in x.items()}
    if isinstance(x, list):
        return [plain(y) for y in x]
    if isinstance(x, Fraction):
        return f"{x.numerator}/{x.denominator}"
    return str(x) if type(x) is int else x


def python_reads(text: str) -> Any:
    try:
        return plain(tomllib.loads(text, parse_float=Fraction))
    except ValueError:
        return None


ODD = [
    "a = 1\na = 2\n", "[a]\n[a]\n", "[[a]]\n[a]\n", "a.b = 1\n[a.c]\nd = 1.50\n", "a = [1, [2], ]\n", "a = { b = 1, c = [1] }\n",
    "a = { b = 1 }\na.c = 2\n", "a = [{}]\n[[a]]\n", 'a = "\\u00e9\\t\\\\"\n', "a = 'it\\n'\n", "a = 1 b = 2\n", "a = \n", "a = 01\n",
    "a = 1.\n", "a = -1.5e+3 # c\n", '"a b" = 1\n', "[a]b = 1\n", "a = [1 2]\n", "a = [\n1, # x\n2\n]\n", "a = {\nb = 1 }\n", "a\n",
    "[a.b]\n[a]\nc = 1\n", "[[a.b]]\nc = 1\n[[a.b]]\n[a.b.d]\ne = 2\n", "a = 'x\ny'\n", "a = 1979-05-27\n", "= 1\n", "a = \"\x01\"\n",
]  # fmt: skip


@pytest.mark.slow
def test_it_reads_toml_as_python_does_or_refuses() -> None:
    texts = [*ODD, *(path.read_text(encoding="utf-8") for path in SCENES.glob("*.toml"))]
    said = run(TOML, texts, 60)
    for text, mine in zip(texts, said, strict=True):
        assert mine is None or mine == python_reads(text), text
    assert None not in said[len(ODD) :]


@pytest.mark.slow
@examples(20)
@given(st.lists(st.text("ab.=[]{}\"'\\,#1-e \n", max_size=30), min_size=50, max_size=50))
def test_whatever_it_reads_python_reads_alike(texts: list[str]) -> None:
    for text, mine in zip(texts, run(TOML, texts, 60), strict=True):
        assert mine is None or mine == python_reads(text), text


# The explorer's crossings

CROSSINGS = """
const c = require(process.argv[1]);
const { asked, catalogue } = JSON.parse(require("fs").readFileSync(0, "utf8"));
process.stdout.write(JSON.stringify(asked.map(([text, given]) => c.crossings(text, null, catalogue, given))));
"""


def exactly(asked: list[tuple[str, dict[str, Any]]]) -> list[dict[str, Any]]:
    return run(CROSSINGS, {"asked": asked, "catalogue": catalogue()}, 300)  # type: ignore[no-any-return]


def decimal(x: object) -> str:
    exact = Fraction(str(x))
    return str(Decimal(exact.numerator) / Decimal(exact.denominator))


def inside(e: hs.Evaluation) -> list[tuple[float, str, bool]]:
    """Where a border is passed, strictly within the band."""
    ends = (e.chart.points[0].omega, e.chart.points[-1].omega)
    rows = [x for x in e.crossings if x.kind is not CrossingKind.TOUCHES and x.omega not in ends]
    return sorted((float(x.omega), x.criterion.name, x.kind is CrossingKind.EXCEEDS) for x in rows)


@pytest.mark.slow
@pytest.mark.parametrize("first", [0, pytest.param(200, marks=pytest.mark.slow)])
def test_all_crossings_of_random_scenes_are_found_exactly(first: int) -> None:
    texts = [random_scene(seed) for seed in range(first, first + (20 if first else 4))]
    every = [(text, hs.evaluate(hs.parse_scene(text))) for text in texts]
    listed = [(text, e) for text, e in every if not any(x.has(pi) for x in e.scene.band)]
    asked = [(text, {"values": [], "threshold": {}, "band": [decimal(x) for x in e.scene.band]}) for text, e in listed]
    found_any = False
    for (text, e), said in zip(listed, exactly(asked), strict=True):
        if said["crossings"] is None:
            assert said["why"] == "the degrees are too high for that", said
            continue
        found_any = True
        found = sorted((x["omega"], x["part"], x["rising"]) for x in said["crossings"])
        assert [x[1:] for x in found] == [x[1:] for x in inside(e)], text
        assert [x[0] for x in found] == pytest.approx([x[0] for x in inside(e)], rel=1e-8), text
    assert found_any


@pytest.mark.slow
def test_what_cannot_be_found_exactly_is_said() -> None:
    given = {"values": [], "threshold": {"real": "0.1", "imag": "0.1"}, "band": ["0", "15"]}
    for text, change, why in (
        (text_of("stick-with-friction"), {}, "pi is among the numbers"),
        (text_of("control-stick-in-detail"), {}, "the degrees are too high"),
        (text_of("fu2019"), {"values": [[3, "omega_n", "1"]]}, "not one of a rational scene"),
        (text_of("fu2019"), {"values": [[0, "omega_n", "1e9999"]]}, "not understood"),
        (text_of("fu2019"), {"values": [[0, "omega_n", ""]]}, "not understood"),
        (text_of("fu2019"), {"band": ["2", "1"]}, "the band is empty"),
        (text_of("delayed-spring"), {}, "for rational scenes"),
        (text_of("fu2019").replace("jnd = 0.10", 'jnd = "0.08 + 0.004*omega"'), {}, "not understood"),
    ):
        [said] = exactly([(text, {**given, **change})])
        assert said["crossings"] is None
        assert why in said["why"]
