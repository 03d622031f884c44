"""A report proves its own table in the browser: by a second checker, in another language, that accepts and refuses as the first."""

from __future__ import annotations

import contextlib
import hashlib
import json
import re
import time
import tomllib
from collections.abc import Callable, Iterator, Sequence
from decimal import Decimal
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

import browser
import pytest
from browser import Browser
from certificates import (
    ASKED,
    DELAYED,
    HELD,
    OWN,
    RAISED,
    RATIONAL,
    SCENES,
    certificate,
    evaluated,
    fractional_scene,
    hostile,
    mutants,
    of_requirement,
    of_stability,
    random_scene,
    requirement_mutants,
    stability_mutants,
    text_of,
)
from explorers import proven, typed
from hypothesis import given, settings
from hypothesis import strategies as st
from marks import often, required, spread
from reports import undrawn
from secondchecker import catalogue, run, verdicts

import haptisym as hs
from haptisym.judge.answers import Answer
from haptisym.judge.crossings import CrossingKind

EACH_KIND = (
    "fu2019",
    "undamped-resonance",
    "zener-tissue",
    *OWN,
    "delayed-spring",
    "virtual-wall",
    "a clock",
    "a spring-pot",
)
"""Scenes of few effects: rational ones, a resonance without damping, delays, a hold, a clock, a power of s."""


@pytest.mark.parametrize(
    "names",
    [
        EACH_KIND,
        pytest.param([x for x in (*RATIONAL, *DELAYED, *RAISED) if x not in EACH_KIND], marks=pytest.mark.slow),
    ],
    ids=["of each kind", "the others"],
)
def test_the_certificate_of_every_scene_is_accepted(names: Sequence[str]) -> None:
    for name, (claim, why) in zip(names, verdicts([(certificate(x), text_of(x)) for x in names]), strict=True):
        assert claim == json.loads(certificate(name))["claim"], (name, why)


@pytest.mark.slow
@pytest.mark.parametrize("first", often(range(0, 1000, 40), [0].__contains__, 3))
def test_certificates_of_random_scenes_are_accepted(first: int) -> None:
    texts = [random_scene(seed) for seed in range(first, first + 40)]
    asked = [(hs.evaluate(hs.parse_scene(text)).certificate(), text) for text in texts]
    assert [why for _, why in verdicts(asked)] == [""] * len(asked)


@pytest.mark.slow
@pytest.mark.parametrize("first", spread(range(0, 18, 6), 3))
def test_certificates_of_random_scenes_with_powers_are_accepted(first: int) -> None:
    asked = []
    for text in (fractional_scene(seed) for seed in range(first, first + 6)):
        with contextlib.suppress(hs.SceneError, hs.UndecidedError):  # more than 300 products of sines and powers
            asked.append((hs.evaluate(hs.parse_scene(text)).certificate(), text))
    assert len(asked) > 2
    assert [why for _, why in verdicts(asked)] == [""] * len(asked)


def test_a_scene_of_several_environments_is_checked_by_name() -> None:
    text = (SCENES.parent / "families" / "palpation-device.toml").read_text(encoding="utf-8")
    proof = json.loads(hs.evaluate(hs.load_scene("palpation-device", "liver")).certificate())
    asked = [
        json.dumps({**proof, "environment": name}, ensure_ascii=False) for name in ("liver", "muscle", "none", None, 3)
    ]
    assert [not why for _, why in verdicts([(x, text) for x in asked])] == [True, False, False, False, False]


@pytest.mark.slow
@pytest.mark.parametrize("name", often([*OWN, *RATIONAL, *DELAYED, *RAISED[:2]], "integrator".__eq__))
def test_every_mutant_is_refused(name: str) -> None:
    changed = spread([*mutants(json.loads(certificate(name)))], 1 if name in OWN else 3)
    listed = [(what, json.dumps(x)) for what, x in changed]
    said = verdicts([(x, text_of(name)) for _, x in listed])
    assert [what for (what, _), (claim, _) in zip(listed, said, strict=True) if claim] == []


def test_certificates_about_stability_are_accepted() -> None:
    for (proof, _), (claim, why) in zip(
        map(of_stability, HELD), verdicts([of_stability(name) for name in HELD]), strict=True
    ):
        assert claim == json.loads(proof)["claim"], why


@pytest.mark.slow
@pytest.mark.parametrize("name", often(HELD, {"a hand"}.__contains__))
def test_every_mutant_about_stability_is_refused(name: str) -> None:
    proof, text = of_stability(name)
    listed = list(stability_mutants(json.loads(proof)))
    said = verdicts([(json.dumps(x), text) for _, x in listed])
    assert [what for (what, _), (claim, _) in zip(listed, said, strict=True) if claim] == []


@pytest.mark.slow
def test_certificates_of_requirements_are_accepted() -> None:
    asked = [of_requirement(name) for name in ASKED]
    for (proof, _), (claim, why) in zip(asked, verdicts(asked), strict=True):
        assert claim == json.loads(proof)["claim"], why


@pytest.mark.slow
@pytest.mark.parametrize("name", often(ASKED, {"a threshold"}.__contains__))
def test_every_mutant_about_values_is_refused(name: str) -> None:
    proof, text = of_requirement(name)
    listed = spread([*requirement_mutants(json.loads(proof))], 1 if name == "a threshold" else 3)
    said = verdicts([(json.dumps(x), text) for _, x in listed])
    assert [what for (what, _), (claim, _) in zip(listed, said, strict=True) if claim] == []


@pytest.mark.slow
def test_hostile_documents_are_refused_in_bounded_time_and_memory() -> None:
    listed = list(hostile())
    said = verdicts([(x, text_of("fu2019")) for _, x in listed], seconds=60)
    assert [name for (name, _), (claim, why) in zip(listed, said, strict=True) if claim or not why] == []


def test_another_scene_is_refused() -> None:
    for text in (text_of("fu2019") + "\n", text_of("sidestick"), ""):
        assert verdicts([(certificate("fu2019"), text)]) == [[None, "the certificate is that of another scene file"]]


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


def test_it_reads_toml_as_python_does_or_refuses() -> None:
    texts = [*ODD, *(path.read_text(encoding="utf-8") for path in SCENES.glob("*.toml"))]
    said = run(TOML, texts, 60)
    for text, mine in zip(texts, said, strict=True):
        assert mine is None or mine == python_reads(text), text
    assert None not in said[len(ODD) :]


@pytest.mark.slow
@settings(max_examples=20, deadline=None)
@given(st.lists(st.text("ab.=[]{}\"'\\,#1-e \n", max_size=30), min_size=50, max_size=50))
def test_whatever_it_reads_python_reads_alike(texts: list[str]) -> None:
    for text, mine in zip(texts, run(TOML, texts, 60), strict=True):
        assert mine is None or mine == python_reads(text), text


# The explorer's crossings.

CROSSINGS = """
const c = require(process.argv[1]);
const { asked, catalogue } = JSON.parse(require("fs").readFileSync(0, "utf8"));
process.stdout.write(JSON.stringify(asked.map(([text, given]) => c.crossings(text, null, catalogue, given))));
"""


def found_exactly(asked: list[tuple[str, dict[str, Any]]]) -> list[dict[str, Any]]:
    return run(CROSSINGS, {"asked": asked, "catalogue": catalogue()}, 300)  # type: ignore[no-any-return]


def decimal(x: object) -> str:
    exact = Fraction(str(x))
    return str(Decimal(exact.numerator) / Decimal(exact.denominator))


def inside(e: hs.Evaluation) -> list[tuple[str, bool, float]]:
    """Where a ratio passes its threshold, strictly within the band."""
    ends = (e.chart.points[0].omega, e.chart.points[-1].omega)
    rows = [x for x in e.crossings if x.kind is not CrossingKind.TOUCHES and x.omega not in ends]
    return [(x.criterion.name, x.kind is CrossingKind.EXCEEDS, float(x.omega)) for x in rows]


@pytest.mark.slow
@pytest.mark.parametrize("first", often(range(0, 1000, 50), [0].__contains__, 3))
def test_all_crossings_of_random_scenes_are_found_exactly(first: int) -> None:
    texts = [random_scene(seed) for seed in range(first, first + 50)]
    evaluations = [hs.evaluate(hs.parse_scene(text)) for text in texts]
    asked = [
        (text, {"values": [], "threshold": {x: decimal(getattr(e.scene.threshold, x)) for x in ("real", "imag")},
                "band": [decimal(x) for x in e.scene.band]})
        for text, e in zip(texts, evaluations, strict=True)
    ]  # fmt: skip
    for text, e, said in zip(texts, evaluations, found_exactly(asked), strict=True):
        if said["crossings"] is None:
            assert said["why"] == "the degrees are too high for that", said
            continue
        found = [(x["part"], x["rising"], x["omega"]) for x in said["crossings"]]
        expected = inside(e)
        assert sorted(x[:2] for x in found) == sorted(x[:2] for x in expected), text
        assert [x[2] for x in found] == pytest.approx([x[2] for x in expected], rel=1e-8), text


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
        ((SCENES / "delayed-spring.toml").read_text(encoding="utf-8"), {}, "for rational scenes"),
    ):
        [said] = found_exactly([(text, {**given, **change})])
        assert said["crossings"] is None
        assert why in said["why"]


# The page.


@pytest.fixture(scope="module")
def shown(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """What a page says in Chromium of its own certificate."""
    required("chromium", browser.program())
    folder = tmp_path_factory.mktemp("pages")
    with browser.running() as opened:

        def show(text: str, *, page_of: bool = False) -> Any:
            file = folder / "page.html"
            file.write_text(text, encoding="utf-8")
            opened.open(file)
            return opened if page_of else _said(opened)

        yield show


def _said(opened: Browser) -> str:
    for _ in range(600):
        said = opened.value("(document.getElementById('checked') || {textContent: 'nothing'}).textContent")
        if not said.startswith("Checking"):
            assert opened.complaints() == []
            return str(said)
        time.sleep(0.05)
    return "still checking"


@cache
def written(name: str) -> str:
    return undrawn(evaluated(name))


SAID = {
    "fu2019": "Checked here: 2 crossings, none missed; H_perc has all its poles in Re s < 0.",
    "integrator": "Checked here: 1 crossing, none missed; H_perc has a pole in Re s ≥ 0.",
    "nothing between": "Checked here: no crossing, none missed; H_perc has all its poles in Re s < 0.",
    "touches": "Checked here: 1 crossing, none missed; H_perc has all its poles in Re s < 0.",
    "stick-with-friction": "Checked here: 2 crossings, none missed. Nothing was checked about poles.",
    "sidestick": "Checked here: 1 crossing, none missed; H_perc has all its poles in Re s < 0.",
    "organ-tissue": "Checked here: 1 crossing, none missed. Nothing was checked about poles.",
}


@pytest.mark.parametrize("name", often(SAID, "fu2019".__eq__))
def test_a_report_proves_its_own_table(name: str, shown: Any) -> None:
    assert shown(written(name)) == SAID[name]


ANSWERS: dict[str, tuple[Callable[[], Answer], str]] = {
    "stability": (
        lambda: hs.stability("fu2019", "firm-grip"),
        "Checked here: no poles of H_perc in Re s ≥ 0; in the hand firm-grip no roots.",
    ),
    "requirement": (
        lambda: hs.require("fu2019", "omega_n"),
        "Checked here: not transparent from 0 to 122.35581477, transparent from 122.35581477 to ∞.",
    ),
    "values beside a delay": (
        lambda: hs.require("four-channel-teleoperation", "environment.k"),
        (
            "Checked here: not transparent from 0 to 46.3105346477, transparent from 46.3105346477 to 432.928698841, "
            "not transparent from 432.928698841 to ∞."
        ),
    ),
    "roots on the right": (
        lambda: hs.stability(hs.parse_scene(OWN["unstable"]), "postural-arm"),
        "Checked here: 2 poles of H_perc in Re s ≥ 0; in the hand postural-arm no roots.",
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", often(ANSWERS, {"stability", "requirement"}.__contains__))
def test_reports_about_stability_and_values_prove_their_answers(name: str, shown: Any) -> None:
    asked, words = ANSWERS[name]
    text = undrawn(asked())
    assert shown(text) == words
    wrong = {
        '"unstable": 0': '"unstable": 1',
        '"feasible": [[122.3': '"feasible": [[121.3',
        '"feasible": [[46.3': '"feasible": [[46.4',
    }
    for old, new in wrong.items():
        if old in text:
            assert shown(text.replace(old, new)).startswith("NOT proven here: the page ")


def test_a_report_about_a_delay_says_that_nothing_is_proven_about_its_poles(shown: Any) -> None:
    text = undrawn(hs.stability("delayed-spring", "firm-grip"))
    assert "This page carries no certificate: " in text
    assert shown(text) == "nothing"


@pytest.mark.slow
def test_a_report_says_what_failed(shown: Any) -> None:
    text = written("fu2019")
    low = evaluated("fu2019").to_dict()["crossings"][0]["enclosure"][0]
    row = text[text.index("<tbody><tr><td>real</td>") :]
    row = row[len("<tbody>") : row.index("</tr>") + len("</tr>")]
    twofold = (r"multiplicity\": 1", r"multiplicity\": 2")
    for (old, new), words in {
        (f"[{low},", f"[{low[:-3]}000,"): "row 1 of the table is not what is proven",
        ("rises above 10", "falls below 10"): "row 1 of the table is not what is proven",
        (row, ""): "the table shows 1 crossings, and 2 are proven",
        ("zeta = 0.5", "zeta = 0.6"): "the certificate is that of another scene file",
        twofold: "crossings: something else is proven",
    }.items():
        assert old in text, old
        said = shown(text.replace(old, new))
        assert said.startswith("NOT proven here: "), said
        assert words in said


@pytest.mark.parametrize("name", ["an order in degrees", "built in Python"])
def test_a_report_without_a_certificate_says_so_and_claims_no_check(name: str, shown: Any) -> None:
    if name == "built in Python":
        scene = hs.Scene(hs.environments.kelvin_voigt(290, 2), (hs.effects.first_order_lag(20),))
    else:
        scene = hs.parse_scene(text_of("a spring-pot").replace("alpha = 0.3\n", 'alpha = "20 deg"\n'))
    text = undrawn(hs.evaluate(scene))
    assert "This page carries no certificate: " in text
    assert 'id="checked"' not in text
    assert 'id="certificate"' not in text
    assert shown(text) == "nothing"


def test_without_javascript_nothing_is_said_to_be_checked() -> None:
    assert '<p id="checked" role="status">Not checked here: that needs JavaScript.</p>' in written("fu2019")


@pytest.mark.slow
def test_a_page_of_a_scene_with_hostile_words_is_checked(shown: Any, tmp_path: Path) -> None:
    file = tmp_path / "x.toml"
    file.write_text('title = "</script><!-- \\" \\u2028 ω"\n' + text_of("nothing between"), encoding="utf-8")
    assert shown(undrawn(hs.evaluate(file))).startswith("Checked here: no crossing")


@pytest.mark.slow
def test_the_explorer_proves_the_crossings_at_the_decimals_shown(shown: Any) -> None:
    opened = shown(written("fu2019"), page_of=True)
    assert "at 7.97892; ri rises above its threshold at 11.9373. 2 crossings within" in proven(opened)
    typed(opened, "explorer-3", "47.5")
    typed(opened, "explorer-c", "0.15")
    scene = hs.parse_scene(text_of("fu2019").replace("80 rad/s", "47.5 rad/s").replace("jnd = 0.10", "jnd = 0.15"))
    expected = [f"at {float(x.omega):.6g}" for x in hs.evaluate(scene).crossings]
    said = proven(opened)
    assert re.findall(r"at [\d.]+\d", said) == expected
    assert said.startswith("Proven at the decimals shown, in exact arithmetic: r")
    typed(opened, "explorer-3", "-1")
    time.sleep(0.5)
    assert opened.value("document.getElementById('explorer-proven').textContent") == ""
    assert opened.complaints() == []


@pytest.mark.slow
def test_the_explorer_proves_a_scene_in_hertz_with_ties_between_its_parts(shown: Any) -> None:
    """Of the steering wheel, whose rendered mass is the environment's: all sliders are decimals in SI, and so is the band."""
    said = proven(shown(written("steering-wheel"), page_of=True))
    [crossing] = evaluated("steering-wheel").crossings
    assert f"at {float(crossing.omega):.4g}"[:6] in said
    assert "1 crossing within the band, none missed" in said


@pytest.mark.slow
def test_the_explorer_of_a_scene_without_a_certificate_proves_nothing(shown: Any) -> None:
    opened = shown(undrawn(hs.evaluate("delayed-spring")), page_of=True)
    assert proven(opened) == "none"
    assert "exact arithmetic" not in opened.value("document.querySelector('#explorer > p').textContent")
