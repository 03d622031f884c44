"""What the command line refuses before any work: outputs over inputs, and options that contradict each other or say nothing."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import click
import pytest

from haptisym.cli import app
from haptisym.commands.verb import Verb
from haptisym.verbs.cost import entry as costs

SCENE = 'environment = { model = "maxwell", k = 100, b = 5 }\neffects = [{ model = "delay", tau = "2 ms" }]\n'


def test_every_verb_is_held_to_the_same_rules() -> None:
    with click.Context(app) as context:
        verbs = [app.get_command(context, name) for name in app.list_commands(context)]
    assert all(isinstance(x, Verb) for x in verbs)
    outputs = {x.opts[-1] for verb in verbs for x in verb.params if isinstance(x.type, click.Path)}
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


@pytest.mark.slow
def test_an_older_output_is_written_anew(call, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    scene, latex = tmp_path / "my.toml", tmp_path / "my.tex"
    scene.write_text(SCENE, encoding="utf-8")
    latex.write_text("older", encoding="utf-8")
    assert call("evaluate", str(scene), "--latex", str(latex))[0] == 0
    assert latex.read_text(encoding="utf-8").startswith("\\documentclass")


@pytest.mark.few(1)
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
        ("derive fu2019 --to c --keep c", "evaluation.jnd is a threshold, of which code holds nothing"),
        ("metrics fu2019 --json --to latex", "--json prints one document"),
        ("metrics fu2019 --to text --json", "--json prints one document"),
        ("require fu2019 --free zeta --slices 5", "--slices is about a map"),
        ("require fu2019 --free zeta --free omega_n --range 0 1 --range 1 2 --digits 9", "--digits is about the ends"),
        ("require fu2019 --free zeta --part real --any-environment", "for any environment there are no parts"),
        ("sensitivity fu2019 --digits 30", "--digits is about the document: it needs --json"),
        ("tolerances fu2019-tolerances --samples 0 --seed 1", "--samples 0 draws none"),
        ("sweep fu2019 --vary evaluation.jnd=0.1:0.2:3 --workers 2 --cluster tcp://x", "--workers computes on this machine"),
        ("sweep fu2019 --vary evaluation.jnd=.1:.2:3 --vary environment.m=1:2:3 --vary environment.k=1:2:3 --figure a.svg", "one or two parameters, not 3"),
        ("sweep fu2019 --vary evaluation.jnd=.1:.2:3 --vary evaluation.jnd=.1:.2:3", "each path may be given only once"),
        ("sweep fu2019 --vary evaluation.jnd=0.1:0.2:3 --workers 2", "--workers and --cluster need --out"),
        ("cost --hard-cases --environment liver", "--hard-cases brings its own scenes"),
        ("cost --hard-cases --quick", "--hard-cases brings its own scenes"),
        ("cost --hard-cases --simulation", "--hard-cases brings its own scenes"),
        ("cost fu2019 --hard-cases", "--hard-cases brings its own scenes"),
        ("cost", "name a SCENE, or ask for --hard-cases"),
        ("evaluate fu2019 sidestick", "unexpected argument (sidestick)"),
        ("evaluate palpation-device --tolerance 0.1", "--tolerance takes one environment"),
        ("require fu2019 --free zeta --free omega_n", "needs a --range for each"),
        ("require fu2019 --free zeta --range 0 1 --range 1 2", "--range not at all or as often"),
        ("derive fu2019 --keep m --numeric", "--keep says which parameters stay symbols, and so does --numeric"),
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


@pytest.mark.slow
def test_three_parameters_are_swept_where_nothing_is_drawn_and_by_this_process_alone(  # type: ignore[no-untyped-def]
    call, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)  # as if it were not installed
    vary = ("evaluation.jnd=0.1:0.2:2", "environment.m=1:2:2", "environment.k=90:100:2")
    status, out, _ = call("sweep", "fu2019", *(word for x in vary for word in ("--vary", x)))
    assert status == 0
    assert "8 sets" in out
    assert call("sweep", "fu2019", "--vary", vary[0], "--workers", "2", "--out", "a.zarr")[0] == 2
    assert call("tolerances", "fu2019-tolerances", "--samples", "1", "--seed", "3")[0] == 0


def test_what_disagrees_or_stayed_undecided_is_status_3_with_its_page(call, monkeypatch: pytest.MonkeyPatch) -> None:  # type: ignore[no-untyped-def]
    monkeypatch.setattr("haptisym.verbs.simulate.entry.Simulation.agrees", property(lambda _: False))
    status, out, _ = call("simulate", "fu2019")
    assert status == 3
    assert "H_perc" in out
    monkeypatch.setattr("haptisym.verbs.metrics.measured.Measured.certified", property(lambda _: False))
    status, out, _ = call("metrics", "fu2019")
    assert status == 3
    assert "UNDECIDED" in out


def test_code_and_documents_are_not_fitted_to_a_terminal_but_pages_are(call, monkeypatch: pytest.MonkeyPatch) -> None:  # type: ignore[no-untyped-def]
    piped = {
        words: call(*words)[1]
        for words in (("derive", "fu2019"), ("derive", "fu2019", "--to", "c"), ("derive", "fu2019", "--json"))
    }
    monkeypatch.setattr("sys.stdout.isatty", lambda: True, raising=False)
    monkeypatch.setenv("COLUMNS", "50")
    page, code, document = (call(*words)[1] for words in piped)
    assert max(map(len, page.split("\n"))) <= 50
    narrow, wide = (sorted(x for x in text.split() if "─" not in x) for text in (page, next(iter(piped.values()))))
    assert narrow == wide  # columns of a table are narrower
    assert [code, document] == [*piped.values()][1:]


@pytest.mark.slow
def test_a_figure_of_what_accuracy_costs_is_where_it_was_asked_for(
    call, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:  # type: ignore[no-untyped-def]
    monkeypatch.setattr("haptisym.verbs.cost.entry._BUDGETS", dict.fromkeys(costs._BUDGETS, 0.0))
    figure = tmp_path / "cost.svg"
    status, _, err = call("cost", "fu2019", "--quick", "--figure", str(figure))
    assert (status, err) == (0, f"figure written to {figure}\n")
    assert figure.stat().st_size > 1000
