"""What the command line refuses before any work: outputs over inputs, and options that contradict each other or say nothing."""

from __future__ import annotations

import os
from pathlib import Path

import click
import pytest

from haptisym.cli import app
from haptisym.commands.verb import Verb

SCENE = 'environment = { model = "maxwell", k = 100, b = 5 }\neffects = [{ model = "delay", tau = "2 ms" }]\n'


def test_every_verb_is_held_to_the_same_rules() -> None:
    assert all(isinstance(x, Verb) for x in app.commands.values())
    outputs = {x.opts[-1] for verb in app.commands.values() for x in verb.params if isinstance(x.type, click.Path)}
    assert {"--latex", "--report", "--figure", "--figures", "--out"} <= outputs


@pytest.mark.parametrize(
    "words",
    [
        ["evaluate", "{scene}", "--latex", "{scene}"],
        ["evaluate", "fu2019", "--environments", "fu2019", "{scene}", "--latex", "{same}"],
        ["evaluate", "{scene}", "--report", "{linked}"],
        ["simulate", "fu2019", "--motion", "{recording}", "--force", "{recording}"],
        ["effects", "{linked}", "--figure", "{scene}"],
        ["require", "{linked}", "--free", "k", "--figure", "{hard}"],
        ["sensitivity", "{scene}", "--figure", "{hard}"],
        ["sweep", "{hard}", "--vary", "environment.k=1:2:3", "--out", "{scene}"],
    ],
)
def test_no_output_takes_the_place_of_what_is_read_whatever_its_name(call, tmp_path: Path, words: list[str]) -> None:  # type: ignore[no-untyped-def]
    scene, recording = tmp_path / "my.svg", tmp_path / "hand.csv"
    scene.write_text(SCENE, encoding="utf-8")
    recording.write_text("t,x\n0,0\n1,1\n", encoding="utf-8")
    linked, hard = tmp_path / "linked.html", tmp_path / "hard.pdf"
    linked.symlink_to(scene)
    os.link(scene, hard)
    names = {
        "scene": scene,
        "linked": linked,
        "hard": hard,
        "recording": recording,
        "same": tmp_path / "." / ".." / tmp_path.name / "my.svg",
    }
    status, out, err = call(*(word.format(**names) for word in words))
    assert (status, out) == (2, "")
    assert "is read by this very call, and would be overwritten: choose another name" in err
    assert scene.read_text(encoding="utf-8") == SCENE


def test_two_outputs_are_not_written_to_one_file(call, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    one = str(tmp_path / "one.pdf")
    status, out, err = call("evaluate", "fu2019", "--latex", one, "--report", one)
    assert (status, out) == (2, "")
    assert "--latex and --report would both be written to" in err


def test_an_older_output_is_written_anew(call, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    scene, latex = tmp_path / "my.toml", tmp_path / "my.tex"
    scene.write_text(SCENE, encoding="utf-8")
    latex.write_text("older", encoding="utf-8")
    assert call("evaluate", str(scene), "--latex", str(latex))[0] == 0
    assert latex.read_text(encoding="utf-8").startswith("\\documentclass")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="a device of Linux")
@pytest.mark.parametrize(
    "words", [["evaluate", "fu2019", "--latex", "/dev/full"], ["simulate", "fu2019", "--force", "/dev/full"]]
)
def test_a_file_on_a_full_disk_is_named(call, words: list[str]) -> None:  # type: ignore[no-untyped-def]
    status, out, err = call(*words)
    assert (status, out) == (2, "")
    assert err.lower().endswith(f"{words[-2][2:]}: /dev/full cannot be written: no space left on device\n")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("derive fu2019 --symbolic --numeric", "--symbolic and --numeric contradict each other"),
        ("derive fu2019 --json --to latex", "--json is one document"),
        ("derive fu2019 --json --to text", "--json is one document"),
        ("derive fu2019 --to c --of dH", "--of chooses among formulas"),
        ("derive fu2019 --to c --keep c", "--keep c keeps the threshold"),
        ("metrics fu2019 --json --to latex", "--json prints one document"),
        ("metrics fu2019 --to text --json", "--json prints one document"),
        ("require fu2019 --free zeta --slices 5", "--slices is about a map"),
        ("require fu2019 --free zeta --free omega_n --range 0 1 --range 1 2 --digits 9", "--digits is about the ends"),
        ("require fu2019 --free zeta --part real --any-environment", "for any environment there are no parts"),
        ("sensitivity fu2019 --digits 30", "--digits is about the document: it needs --json"),
        ("tolerances fu2019-tolerances --samples 0 --seed 1", "--samples 0 draws none"),
        ("sweep fu2019 --vary evaluation.jnd=0.1:0.2:3 --workers 2 --cluster tcp://x", "--workers computes on this machine"),
        ("cost --hard-cases --environment liver", "--hard-cases brings its own scenes"),
        ("simulate fu2019 --check --motion sine", "--check chooses the motion itself"),
        ("simulate fu2019 --lowpass-order 2", "it needs --lowpass"),
        ("scenes fu2019 --json", "leave out --json"),
        ("evaluate fu2019 --digits 20 --digits 30", "--digits is given 2 times"),
        ("effects fu2019 --figure a.svg --figure b.svg", "--figure is given 2 times"),
    ],
)  # fmt: skip
def test_options_that_contradict_each_other_or_would_be_ignored_are_refused(call, words: str, said: str) -> None:  # type: ignore[no-untyped-def]
    status, out, err = call(*words.split())
    assert (status, out) == (2, "")
    assert said in err


def test_options_that_agree_are_not_refused(call) -> None:  # type: ignore[no-untyped-def]
    assert call("derive", "fu2019", "--json", "--json", "--to", "json", "--of", "dH")[0] == 0
    assert call("derive", "fu2019", "--symbolic", "--symbolic", "--of", "dH", "--of", "H_env")[0] == 0
