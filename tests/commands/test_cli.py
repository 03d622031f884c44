"""The command line as a user meets it."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest
from matplotlib.figure import Figure

import haptisym as hs


def test_the_contract_document_of_the_papers_example(call) -> None:  # type: ignore[no-untyped-def]
    status, out, err = call("evaluate", "fu2019", "--json")
    document = json.loads(out)
    assert (status, err) == (0, "")
    enclosures = [crossing.pop("enclosure") for crossing in document["crossings"]]
    assert [
        float(low) <= omega <= float(high)
        for (low, high), omega in zip(enclosures, (7.978916790174708, 11.937310924322059), strict=True)
    ]
    assert document == {
        "schema": "haptisym.evaluation/1",
        "title": "Numerical example of Fu, van Paassen and Mulder (2019)",
        "band": [0.0, 15.0],
        "threshold": {"real": "1/10", "imag": "1/10"},
        "crossings": [
            {
                "part": "real",
                "omega": 7.978916790174708,
                "digits": "7.97891679017471",
                "kind": "exceeds",
                "sign": 1,
                "multiplicity": 1,
            },
            {
                "part": "imag",
                "omega": 11.937310924322057,
                "digits": "11.9373109243221",
                "kind": "exceeds",
                "sign": 1,
                "multiplicity": 1,
            },
        ],
        "transparent": [[0.0, 7.978916790174708]],
        "bandwidth": 7.978916790174708,
        "changeovers": {"environment": [7.453559924999299], "perceived": [7.879481229194869]},
        "percepts": [
            {"part": "real", "band": [7.978916790174708, 15.0], "property": "mass", "change": "lower"},
            {"part": "imag", "band": [11.937310924322057, 15.0], "property": "damping", "change": "higher"},
        ],
        "outside_model": [],
        "unbounded": [],
        "stable": True,
        "any_environment": {"transparent_below": 7.92231185714061, "opaque_above": 11.100053432368274},
        "certified": True,
    }


def test_digits_are_as_many_as_asked_for(call) -> None:  # type: ignore[no-untyped-def]
    _, out, _ = call("evaluate", "fu2019", "--json", "--digits", "50")
    real, imag = json.loads(out)["crossings"]
    assert real["digits"] == "7.9789167901747077028158954471820345477715919238094"
    assert len(imag["digits"]) == 51


def test_the_text_answers_both_questions(call) -> None:  # type: ignore[no-untyped-def]
    status, out, _ = call("evaluate", "fu2019")
    assert status == 0
    for words in (
        "1.8 s^2 + 15 s + 100",
        "At 7.9789 rad/s (1.2699 Hz)",
        "lower mass",
        "higher damping",
    ):
        assert words in out
    assert max(map(len, out.splitlines())) <= 96


def test_text_and_python_say_the_same(call) -> None:  # type: ignore[no-untyped-def]
    _, out, _ = call("evaluate", "sidestick")
    assert out == str(hs.evaluate(hs.load_scene("sidestick")))


@pytest.mark.slow
def test_every_shipped_scene_has_a_source_and_is_evaluated(call) -> None:  # type: ignore[no-untyped-def]
    _, out, _ = call("scenes", "--json")
    scenes = json.loads(out)["scenes"]
    assert len(scenes) >= 8
    for row in scenes:
        assert row["title"]
        assert row["source"]
        status, text, _ = call("evaluate", row["name"])
        assert status == 0
        assert row["title"].split(":")[0][:20] in text


def test_a_bare_call_prints_help(call) -> None:  # type: ignore[no-untyped-def]
    status, out, _ = call()
    assert status == 0
    assert "haptisym evaluate fu2019" in out


@pytest.mark.parametrize(
    "arguments",
    [("evaluate",), ("evaluat", "fu2019"), ("evaluate", "fu2019", "--digits", "0"), ("evaluate", "fu2019", "--jsn")],
)
def test_a_wrong_command_line_is_status_2_without_a_traceback(call, arguments) -> None:  # type: ignore[no-untyped-def]
    status, out, err = call(*arguments)
    assert (status, out) == (2, "")
    assert "Error" in err


def test_an_output_that_cannot_be_written_is_said(call, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    status, _, err = call("evaluate", "fu2019", "--latex", str(tmp_path / "no" / "such" / "folder.tex"))
    assert status == 2
    assert "folder.tex" in err


def test_figures_and_latex_are_written_beside_the_json(  # type: ignore[no-untyped-def]
    call, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        Figure, "savefig", lambda _, path, **__: Path(path).touch()
    )  # what files hold is tested with the figures
    status, out, _ = call(
        "evaluate", "fu2019", "--json", "--figures", str(tmp_path / "figures"), "--latex", str(tmp_path / "x.tex")
    )
    assert status == 0
    assert json.loads(out)["certified"]
    assert len(list((tmp_path / "figures").iterdir())) >= 12
    assert (tmp_path / "x.tex").read_text(encoding="utf-8").startswith("\\documentclass")


def test_the_installed_command_runs() -> None:
    command = Path(sys.executable).with_name("haptisym")
    shown = subprocess.run([command, "--version"], capture_output=True, text=True, check=True)
    assert shown.stdout == f"haptisym {hs.__version__}\n"


def test_a_shipped_scene_can_be_copied_and_is_the_same(call, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    status, text, _ = call("scenes", "fu2019")
    (tmp_path / "my.toml").write_text(text, encoding="utf-8")
    copied = call("evaluate", str(tmp_path / "my.toml"), "--json")
    assert status == 0
    assert copied == call("evaluate", "fu2019", "--json")
    assert call("scenes", "no-such-scene")[0] == 2


@pytest.mark.slow
def test_a_package_that_a_verb_needs_and_that_is_missing_is_named_with_its_extra() -> None:
    probe = "import sys; sys.modules['scipy'] = None; sys.argv = ['haptisym', 'simulate', 'fu2019']; from haptisym.cli import main; main()"
    done = subprocess.run([sys.executable, "-c", probe], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == 'error: scipy is missing: this needs pip install "haptisym[simulate]"\n'


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["derive", "fu2019", "--keep", "m", "--symbolic"], "--keep says which parameters stay symbols"),
        (["derive", "fu2019", "--json", "--to", "c"], "--json is one document"),
        (["require", "fu2019", "--free", "zeta", "--slices", "5"], "--slices is about a map of two parameters"),
        (["tolerances", "fu2019-tolerances", "--samples", "0", "--seed", "3"], "--seed is about the random numbers"),
    ],
)
def test_options_that_contradict_each_other_are_refused(call, words: list[str], said: str) -> None:  # type: ignore[no-untyped-def]
    status, out, err = call(*words)
    assert (status, out) == (2, "")
    assert said in err


TRANSPARENT = '[environment]\nmodel = "mass-spring-damper"\nk = {k}\n[[effects]]\nmodel = "delay"\ntau = "1 us"\n'


@pytest.mark.slow
@pytest.mark.parametrize(("verb", "k"), [("sensitivity", "100"), ("tolerances", '"100 N/m +- 5 %"')])
def test_an_answer_with_nothing_to_draw_is_given_all_the_same(call, tmp_path: Path, verb: str, k: str) -> None:  # type: ignore[no-untyped-def]
    scene, figure = tmp_path / "clear.toml", tmp_path / "figure.svg"
    scene.write_text(TRANSPARENT.format(k=k), encoding="utf-8")
    status, out, err = call(verb, str(scene), "--figure", str(figure))
    assert status == 0
    assert "No ratio meets its threshold" in out
    assert err.startswith("no figure: ")
    assert not figure.exists()


def test_what_is_wrong_with_a_band_is_said_in_the_units_it_was_given_in(call, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    scene = tmp_path / "band.toml"
    scene.write_text(TRANSPARENT.format(k=100) + '[evaluation]\nband = ["3 Hz", "2 Hz"]\n', encoding="utf-8")
    assert '"2 Hz", must be above the low end, "3 Hz"' in call("evaluate", str(scene))[2]
