"""Reports as files: one page that asks for nothing, says what is proven, and moves what the program moves; or a PDF."""

from __future__ import annotations

import json
import math
import re
import shutil
from collections.abc import Callable, Iterator
from functools import cache
from html import unescape
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from explorers import undrawn
from marks import required
from pagereader import Page, equations, value
from sympy import lambdify

import haptisym as hs
from haptisym.judge.answers import Answer
from haptisym.kernel.rings import s
from haptisym.model.parameters import Rule
from haptisym.pages import report
from haptisym.writing.html import Html, element, script
from haptisym.writing.layout import named

E, F = hs.environments, hs.effects
LAG = F.first_order_lag(20)
HOSTILE = "</title><script>alert(1)</script><!-- & \"quoted\" 'too' \x00\u202e"
OWN = {
    "hostile": hs.Scene(
        E.mass_spring_damper(1, 5, 100), (F.series("1/(1 + s/20)", name="</script><b>"),), title=HOSTILE, source=HOSTILE
    ),
    "two thresholds": hs.Scene(
        E.mass_spring_damper("0.01 kg*m^2", "0.2 N*m*s/rad", "3 N*m/rad"),
        (F.shunt(m="0.002 kg*m^2"), F.delay(0)), (3, 30), hs.Threshold.of("0.05", "0.2"),
    ),
}  # fmt: skip
SCENES = ("fu2019", "wave-variable-link", "stick-with-friction", "four-channel-teleoperation", *OWN)
ANSWERS: dict[str, Callable[[], Answer]] = {
    "require": lambda: hs.require("fu2019", "omega_n"),
    "stability": lambda: hs.stability("fu2019", "firm-grip"),
    "sensitivity": lambda: hs.sensitivity("fu2019"),
}


@cache
def evaluated(name: str) -> hs.Evaluation:
    return hs.evaluate(OWN.get(name, name))


@cache
def said(name: str) -> str:
    """The page of an answer but for its drawings, which take seconds."""
    return undrawn(ANSWERS[name]() if name in ANSWERS else evaluated(name))


def record_of(page: str) -> dict[str, Any]:
    """What the explorer's script reads."""
    found = re.search(r'id="explorer-data"[^>]*>(.*?)</script>', page, re.DOTALL)
    assert found
    return dict(json.loads(unescape(found[1])))


def flat(document: object) -> Iterator[float]:
    """All numbers of a document."""
    if isinstance(document, dict):
        document = list(document.values())
    if isinstance(document, list):
        for entry in document:
            yield from flat(entry)
    elif isinstance(document, float):
        yield document


# The page as a document


def is_whole(text: str) -> None:
    """Well formed, each name once, each reference to something within, and nothing loaded."""
    read = Page(text)
    assert len(set(read.ids)) == len(read.ids)
    assert [x for x in read.loads if not x.startswith("data:")] == []
    assert not {"link", "img", "iframe", "object", "embed", "base"} & set(read.tags)
    assert "default-src 'none'" in unescape(text)
    for drawing in re.findall(r"<(?:math|svg)\b.*?</(?:math|svg)>", text, re.DOTALL):
        ElementTree.fromstring(drawing)
    body = re.sub("<script.*?</script>", "", text, flags=re.DOTALL)
    assert set(re.findall(r'(?:xlink:href="#|url\(#)([^")]+)', body)) <= set(read.ids)
    inputs = [x for x in read.controls if x["type"] in ("range", "number")]
    assert len(inputs) == 2 * len(read.labels)
    assert all(x["aria-label"] for x in inputs)
    assert set(read.labels) <= set(read.ids)


@pytest.mark.dear("fu2019", "require", "sensitivity")
@pytest.mark.few("fu2019", "require", "stability", "sensitivity")
@pytest.mark.parametrize("name", [*SCENES, *ANSWERS])
def test_a_page_is_well_formed_refers_to_nothing_outside_and_holds_its_record(name: str) -> None:
    is_whole(said(name))
    answer = ANSWERS[name]() if name in ANSWERS else evaluated(name)
    kind = answer.to_dict()["schema"].partition("/")[0].removeprefix("haptisym.")
    [held] = re.findall(rf'<script type="application/json" id="{kind}">(.*?)</script>', said(name), re.DOTALL)
    assert json.loads(held) == answer.to_dict()


@pytest.mark.slow
@pytest.mark.core
def test_a_page_with_its_drawings_is_whole_too_and_small(tmp_path: Path) -> None:
    report.save(evaluated("fu2019").document(), evaluated("fu2019").to_json(), tmp_path / "x.html")
    text = (tmp_path / "x.html").read_text(encoding="utf-8")
    is_whole(text)
    assert len(text.encode()) < 1_500_000
    assert text.count("<figure") >= 5


@pytest.mark.slow
@pytest.mark.few("fu2019")
@pytest.mark.parametrize("name", SCENES)
def test_every_number_of_the_page_is_one_of_the_document(name: str) -> None:
    result, text = evaluated(name), said(name)
    document, read = result.to_dict(), Page(text)
    told = [*document["transparent"], *[p["band"] for p in document["percepts"]], *document["outside_model"]]
    told += [document["changeovers"], document["unbounded"], [c["omega"] for c in document["crossings"]]]
    assert set(flat(told)) <= set(read.numbers)
    shown = "".join(read.texts)
    for c in document["crossings"]:
        assert all(end in shown for end in c["enclosure"])


@pytest.mark.slow
def test_hostile_text_stays_text() -> None:
    text = said("hostile")
    read = Page(text)
    assert "alert(1)" in "".join(read.texts)
    assert "b" not in read.tags
    visible = HOSTILE.replace("\x00", "\ufffd").replace("\u202e", "\ufffd")
    assert [x for x in read.texts if x == visible]


def test_text_is_escaped_by_construction() -> None:
    assert element("p", "<b>", given={"title": '"<'}) == '<p title="&quot;&lt;">&lt;b&gt;</p>'
    assert element("p", Html("<b></b>")) == "<p><b></b></p>"
    assert element("p", "a\x00\ud800\uffffb") == "<p>a\ufffd\ufffd\ufffdb</p>"
    assert Page(script("x = '</script>'; // <!--")).tags == ["script"]


# Its formulas


def response(scene: hs.Scene, omega: float) -> tuple[complex, complex]:
    """H_env and H_perc at a frequency, by complex numbers and the effects one by one."""

    def at(form: Any) -> complex:
        return complex(lambdify(s, form, "mpmath")(1j * omega))

    H = at((scene.rendered or scene.environment).H)
    for effect in scene.effects:
        a, b, c, d = map(at, effect.matrix)
        H = (a * H + b) / (c * H + d)
    return at(scene.environment.H), H


def spelt(symbol: str) -> str:
    """A symbol's name as the reader spells it."""
    name = named(symbol)
    below = "".join(word.letters.replace(" ", "_") for word in name.below)
    return f"{name.head.letters}_{below}" if below else name.head.letters


NAMED = {
    "H_envs": lambda env, perc, w: env,
    "H_percs": lambda env, perc, w: perc,
    "ReDeltaHomegaj": lambda env, perc, w: (perc - env).real,
    "ImDeltaHomegaj": lambda env, perc, w: (perc - env).imag,
    "|H_envomegaj|2": lambda env, perc, w: abs(env) ** 2,
    "r_romega": lambda env, perc, w: abs((perc - env).real) / abs(env),
    "r_iomega": lambda env, perc, w: abs((perc - env).imag) / abs(env),
    "ReDeltaHomegaj/H_envomegaj": lambda env, perc, w: ((perc - env) / env).real,
    "ImDeltaHomegaj/H_envomegaj": lambda env, perc, w: ((perc - env) / env).imag,
    "k_percomega": lambda env, perc, w: perc.real,
    "m_percomega": lambda env, perc, w: -perc.real / w**2,
    "b_percomega": lambda env, perc, w: perc.imag / w,
}


@pytest.mark.few("4.5-fu2019")
@pytest.mark.parametrize("name", [x for x in SCENES if x != "hostile"])
@pytest.mark.parametrize("omega", [4.5, 11.25])
def test_every_formula_of_the_page_has_the_value_that_the_physics_has(name: str, omega: float) -> None:
    """Long formulas are broken in lines and named in parts: read together again, nothing is lost and no sign is turned."""
    # without dimensions names have other meanings, and leading terms are no values
    page_of_values = re.split("<h3>High-bandwidth", said(name))[0]
    scene, listed = evaluated(name).scene, equations(page_of_values)
    known: dict[str, complex] = {spelt(p.symbol.name): float(p.value) for p in scene.parameters}
    known |= {"s": 1j * omega, "omega": omega}
    for left, sides in [x for x in listed if re.fullmatch(r"[ND]_\d+", x[0])]:
        known[left] = value(sides[-1][1], known) if "N_" not in sides[-1][1] else math.nan
    env, perc = response(scene, omega)
    size, checked = {True: abs(env) + abs(perc), False: 1.0}, set()
    for left, sides in listed:
        relation, side = sides[-1]
        if re.fullmatch(r"[A-Z](?:_\w+)?|x_\d+", left) and left not in NAMED:
            known[left] = value(side, known)  # a named step
        elif left in NAMED and not ("Delta" in side or "H_perc" in side):
            expected = NAMED[left](env, perc, omega)
            scale = size[left.startswith(("H", "Re", "Im")) and "/" not in left] if left[0] != "|" else abs(env) ** 2
            assert value(side, known) == pytest.approx(
                expected, rel=2e-4 if relation == "≈" else 1e-9, abs=1e-6 * scale
            ), left
            checked.add(left)
    assert {"H_envs", "ReDeltaHomegaj", "ImDeltaHomegaj", "|H_envomegaj|2"} <= checked


@pytest.mark.few("fu2019")
@pytest.mark.parametrize("name", SCENES[:5])
def test_the_threshold_functions_are_positive_exactly_where_a_ratio_exceeds(name: str) -> None:
    scene = evaluated(name).scene
    forms = {left: sides[-1][1] for left, sides in equations(said(name)) if left in ("p_romega", "p_iomega")}
    low, high = (float(x) for x in scene.band)
    checked = 0
    for omega in np.linspace(low, high, 14)[1:-1]:
        env, perc = response(scene, omega)
        # Those too long to print are given by the distortion, whose own formulas are checked above.
        given = {
            "|H_env(omega*j)|": abs(env),
            "ReDeltaH(omega*j)": (perc - env).real,
            "ImDeltaH(omega*j)": (perc - env).imag,
        }
        for left, part in (("p_romega", (perc - env).real), ("p_iomega", (perc - env).imag)):
            excess, form = abs(part) / abs(env) - 0.1, forms[left]
            for written, number in given.items():
                form = form.replace(written, f"({number!r})")
            if abs(excess) > 1e-3:
                checked += 1
                assert (value(form, {"omega": omega}).real > 0) == (excess > 0), (left, omega)
    assert checked > 12


# Its sliders


@pytest.mark.few("fu2019")
@pytest.mark.parametrize("name", [*SCENES, "geared-arm", "wheel-with-encoder"])
def test_sliders_begin_at_the_scenes_values_between_ends_that_the_model_allows(name: str) -> None:
    told, scene = record_of(said(name)), evaluated(name).scene
    sliders = {x["id"]: x for x in told["sliders"]}
    low, high = (float(x) for x in scene.band)
    assert told["band"] == [low, high]
    assert [sliders[x]["value"] for x in told["limits"]] == [
        *dict.fromkeys([float(scene.threshold.real), float(scene.threshold.imag)])
    ]
    assert (sliders["explorer-omega"]["low"], sliders["explorer-omega"]["high"]) == (low, high)
    for i, p in enumerate(scene.parameters):
        assert sliders[f"explorer-{i}"]["value"] == float(p.value)
        assert sliders[f"explorer-{i}"]["open"] == (p.rule in (Rule.POSITIVE, Rule.FRACTION))
        if p.rule is Rule.FRACTION:
            assert sliders[f"explorer-{i}"]["high"] < 1
    for x in told["sliders"]:
        assert x["low"] <= x["value"] <= x["high"]
        assert x["low"] < x["high"]
        assert x["low"] > 0 or not x["log"]
        assert (x["least"] is None) or x["least"] <= x["low"]
        assert (x["most"] is None) or x["high"] <= x["most"]


FILES: dict[str, tuple[str, list[list[Any]]]] = {
    "tied": (
        """
environment = { model = "mass-spring-damper", k = 100, b = 2 }
rendered = { model = "mass-spring-damper", k = 120, b = "environment.b" }
""",
        [["environment", "b", 2.0], ["environment", "k", 100.0], ["rendered", "b", 2.0], ["rendered", "k", 120.0]],
    ),
    "stiff": (
        """
environments = [{ model = "mass-spring-damper", k = 100, name = "soft" }, { model = "mass-spring-damper", k = 900, name = "stiff" }]
""",
        [["environment", "k", 900.0]],
    ),
}
BEHIND = """
effects = [{ model = "first-order-lag", omega_c = 20 }, { model = "shunt", m = "0.1 kg" }]
evaluation = { band = [1, 12], jnd = "0.1" }
"""


@pytest.mark.slow
@pytest.mark.few("tied")
@pytest.mark.parametrize("name", FILES)
def test_the_record_says_where_in_the_file_each_number_stands(name: str) -> None:
    """Of a number that stands in two places both; of several environments the one of the page."""
    text, places = FILES[name]
    environment = name if "environments" in text else None
    told = record_of(undrawn(hs.evaluate(hs.parse_scene(text + BEHIND, environment=environment))))
    values = {x["id"]: x["value"] for x in told["sliders"]}
    found = sorted(([*place, values[x]] for x, *place in told["paths"]), key=str)
    assert found == [*places, [0, "omega_c", 20.0], [1, "m", 0.1]]


CORNERS = [["0.1", "0"], ["0", "omega/50"], ["-0.1", "0"], ["0", "-0.1"]]
REGIONS: dict[str, tuple[Any, dict[str, Callable[[float], float]]]] = {
    "ellipse": (
        {"shape": "ellipse", "real": "0.2", "imag": "(1 + omega)/(20 + omega^2)", "tilt": "omega/50"},
        {"real": lambda w: 0.2, "imag": lambda w: (1 + w) / (20 + w * w), "tilt": lambda w: w / 50},
    ),
    "sides and floor": (
        {"real": {"higher": "0.1", "lower": "omega/100"}, "imag": {"higher": "omega/40", "lower": "0.2"}, "floor": "3 + omega"},
        {"real": lambda w: 0.1, "real.lower": lambda w: w / 100, "imag": lambda w: w / 40, "imag.lower": lambda w: 0.2,
         "floor": lambda w: 3 + w},
    ),
    "floor": ({"real": "0.1", "imag": "0.3", "floor": "2 N/m"}, {"real": lambda w: 0.1, "imag": lambda w: 0.3, "floor": lambda w: 2}),
    "polygon": ({"shape": "polygon", "corners": CORNERS}, {"real": lambda w: 1.0, "imag": lambda w: 1.0}),
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.few("ellipse", "polygon")
@pytest.mark.parametrize("name", REGIONS)
def test_the_numbers_of_a_region_are_sliders_or_quotients_that_have_its_values(name: str) -> None:
    jnd, true = REGIONS[name]
    scene = hs.Scene(E.mass_spring_damper(k="100 N/m"), (LAG,), (1, 12), jnd)
    told = record_of(undrawn(hs.evaluate(scene)))
    sliders = {x["id"]: x["value"] for x in told["sliders"]}

    def at(number: dict[str, Any], w: float) -> float:
        if "slider" in number:
            return float(sliders[number["slider"]])
        top, bottom = (sum(c * w**n for n, c in enumerate(number[x])) for x in ("top", "bottom"))
        return float(top / bottom)

    region = told["region"]
    assert set(region["numbers"]) == set(true)
    for w in (1.0, 5.0, 12.0):
        for key, f in true.items():
            assert at(region["numbers"][key], w) == pytest.approx(f(w), rel=1e-12)
        if name == "polygon":
            corners = [[at(x, w) for x in corner] for corner in region["corners"]]
            assert np.allclose(corners, [[0.1, 0], [0, w / 50], [-0.1, 0], [0, -0.1]], rtol=1e-12)


# As a PDF


@pytest.mark.slow
@pytest.mark.core
def test_a_pdf_holds_all_figures_and_is_the_same_again_of_the_day_that_is_asked_for(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """SOURCE_DATE_EPOCH is the day of reproducible builds: 1551398400 s are the first of March 2019."""
    required("pdflatex", shutil.which("pdflatex"))
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1551398400")
    first, second = (report.pdf(hs.peaks("steering-wheel").document()) for _ in range(2))
    assert first.startswith(b"%PDF")
    assert first == second
    assert b"D:20190301" in first


def test_other_names_and_a_missing_program_are_errors_that_say_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    answer = hs.peaks("steering-wheel")
    with pytest.raises(hs.SceneError, match=r'"x\.docx" must end in|must end in \.html or \.pdf'):
        report.save(answer.document(), answer.to_json(), tmp_path / "x.docx")
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(hs.SceneError, match=r"needs pdflatex.*\.html"):
        report.save(answer.document(), answer.to_json(), tmp_path / "x.pdf")
    assert not [*tmp_path.iterdir()]


def test_a_report_of_a_fitted_scene_calls_nothing_of_the_device_proven() -> None:
    felt = E.mass_spring_damper(k=["90 N/m", "110 N/m"])
    report = undrawn(hs.evaluate(hs.Scene(felt, (F.first_order_lag(20),), (0, 15), confidence=0.95)))
    words = " ".join(re.sub("<[^>]*>", " ", re.sub("<(script|style).*?</\\1>", "", report, flags=re.DOTALL)).split())
    assert "95 % region of the fit" in words
    assert "Proven for the fitted model:" in words
    assert not re.search(r"\b(Certain:|[Gg]uaranteed|none invented\) proven)", words)


def test_a_half_width_in_omega_is_written_as_it_is() -> None:
    wide = {"shape": "ellipse", "real": "0.1 + 0.01*omega", "imag": 0.1}
    assert "which-values" in undrawn(hs.evaluate(hs.Scene(E.mass_spring_damper(k=100), (LAG,), (0, 15), wide)))
