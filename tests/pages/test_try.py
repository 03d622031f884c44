"""What the page that runs haptisym asks of it, here in this Python: a question in, an answer or one clear sentence out."""

from __future__ import annotations

import html
import json
import re
from collections.abc import Callable
from pathlib import Path
from runpy import run_path
from typing import Any

import pytest
from certificates import text_of

import haptisym as hs

PAGE = run_path(str(Path(__file__).parents[2] / "docs" / "try" / "answers.py"))
SCENES: dict[str, str] = PAGE["listed"]()["scenes"]
OF_THE_COMMAND_LINE = re.compile(r"--\w|Next:|SCENE|haptisym (?!and)[a-z]+\b|haptisym\.\w|pip install")


def asked(question: str, told: Callable[[str], object] | None = None, **given: str) -> Any:
    return json.loads(PAGE["answer"](json.dumps({"ask": question, **given}), told))


def words(found: Any) -> str:
    """What is read, without the scene's source."""
    return html.unescape(re.sub(r"<[^>]*>", "", re.sub(r"<p>Source: .*?</p>", "", found["html"])))


@pytest.mark.few("fu2019", "sidestick", "steering-wheel")
@pytest.mark.parametrize("name", SCENES)
def test_answers_speak_of_the_page_and_never_of_the_command_line(name: str) -> None:
    found = asked("evaluate", scene=SCENES[name])
    held = asked("stability", scene=SCENES[name], hand=next(iter(found["hands"]), ""))
    for own in (found, held, *([asked("derive", scene=SCENES[name])] if name == "fu2019" else [])):
        assert not OF_THE_COMMAND_LINE.search(words(own)), OF_THE_COMMAND_LINE.search(words(own))


LONG = """[environment]
model = "kelvin-voigt"
k = 800
b = 2
[[effects]]
model = "sampled-loop"
T = "1 ms"
method = "backward-difference"
[[effects]]
model = "delay"
tau = "2 ms"
[[effects]]
model = "first-order-lag"
omega_c = 250
"""


def test_a_question_about_a_wrong_scene_is_told_what_is_wrong() -> None:
    wrong = SCENES["fu2019"].replace("zeta = 0.5", "zeta = -1")
    for question, given in (("evaluate", {}), ("stability", {"hand": "postural-arm"}), ("require", {"path": "zeta"})):
        assert "needs zeta >= 0" in asked(question, scene=wrong, **given)["error"]


def test_words_for_the_page_replace_their_sentence_and_nothing_behind_it() -> None:
    text = "<p>Undecided: this needs NumPy: pip install numpy.</p><p>Proven: the rest.</p>"
    for said, own in PAGE["ON_PAGE"].items():
        text = re.sub(said, own, text)
    assert text.endswith("its command line</p><p>Proven: the rest.</p>")


def test_what_is_too_long_to_be_expanded_is_named_in_whole_sentences() -> None:
    found = asked("derive", scene=LONG)
    assert "Longer than" in words(found)
    assert not OF_THE_COMMAND_LINE.search(words(found))
    assert not re.search(r"[;,]\s*</p>", html.unescape(found["html"]))
    page = " ".join(str(hs.derive(hs.parse_scene(LONG))).split())
    assert 'operations: Re dH and Im dH; --of "Re dH" prints one.' in page


def test_a_family_is_answered_for_each_environment_and_its_sliders_are_those_of_the_chosen_one() -> None:
    text = SCENES["palpation-device"]
    found = asked("evaluate", scene=text, environment="liver")
    assert found["json"] == hs.evaluate_all("palpation-device").to_json()
    assert found["environments"] == list(hs.load_scenes("palpation-device"))
    assert "k0 of environment" in found["explorer"]
    assert "effects.device.m" in found["paths"]
    assert "environment.k" not in found["paths"]  # which the liver does not have
    needed = json.loads(asked("require", scene=text, path="effects.amplifier.omega_c")["json"])
    own = hs.answer_each("palpation-device", lambda scene: hs.require(scene, "effects.amplifier.omega_c"))
    assert needed["common"] == own.to_dict()["common"]
    assert "one environment" in asked("certificate", scene=text)["error"]


MEASURED = '[environment]\nmodel = "mass-spring-damper"\nm = 1\n\n[perceived]\nfile = "device.csv"\n'
WRONG = {
    "nothing": ("", "[environment] is missing"),
    "an unknown key": (text_of("fu2019").replace("zeta", "zetta"), 'did you mean "zeta"?'),
    "a bad unit": (text_of("fu2019").replace("1.8 kg", "1.8 N"), "m"),
    "a negative mass": (text_of("fu2019").replace("1.8 kg", "-1.8 kg"), "needs m >= 0 (is -1.8 kg)"),
    "a measured scene": (MEASURED, "the page does not take measured responses; install haptisym"),
    "measured lines": ("omega,real,imag\n1,2,3\n", "the page does not take measured responses; install haptisym"),
}


@pytest.mark.parametrize("what", WRONG)
def test_what_is_wrong_is_one_sentence(what: str) -> None:
    text, said = WRONG[what]
    error = asked("evaluate", scene=text)["error"]
    assert said in error
    assert "\n" not in error


def test_lines_that_end_as_windows_ends_them_and_very_large_numbers_are_answered() -> None:
    plain = asked("evaluate", scene=text_of("fu2019"))["json"]
    assert asked("evaluate", scene=text_of("fu2019").replace("\n", "\r\n"))["json"] == plain
    assert "json" in asked("evaluate", scene=text_of("fu2019").replace("1.8 kg", "1e9 kg"))


def test_a_turning_scene_offers_no_hand_that_pushes_and_a_long_question_tells_how_far_it_is() -> None:
    assert asked("evaluate", scene=text_of("sidestick"))["hands"] == []
    assert asked("evaluate", scene=text_of("fu2019"))["hands"] == list(hs.hands)
    told: list[str] = []
    asked("require", told.append, scene=text_of("fu2019"), path="effects.filter.omega_n")
    assert told
    assert all(re.fullmatch(r"[\d.e+]+( of [\d.e+]+)? \D+", x) for x in told)
