"""The command as it is started: in terminals, pipes and encodings, with each way in which it may end."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from hypothesis import given
from hypothesis import strategies as st
from terminal import COMMAND, all_in_terminal, environment, in_terminal

import haptisym as hs
from haptisym.commands.terminal import escaped, say_document, spelt
from haptisym.writing.document import Document, Section, Style
from haptisym.writing.plain import plain


def started(*words: str, **more: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([*COMMAND, *words], capture_output=True, text=True, check=False, env=environment(80, **more))


@pytest.mark.slow
@pytest.mark.core
@pytest.mark.parametrize(
    ("words", "status", "out", "err"),
    [
        ("evaluate fu2019 --json", 0, '"certified": true', ""),
        ("", 0, "Commands:", ""),
        ("evaluate fu2091", 2, "", "fu2019"),
        ("evaluate fu2019 --digits x", 2, "", "digits"),
        ("evaluate organ-tissue --limit 1e-9", 3, "", "the limit of 1e-09 s"),
    ],
)
def test_a_call_ends_with_its_status_and_says_what_belongs_on_each_stream(
    words: str, status: int, out: str, err: str
) -> None:
    done = started(*words.split())
    assert done.returncode == status
    assert "Traceback" not in done.stderr
    for said, shown in ((out, done.stdout), (err, done.stderr)):
        assert said in shown
        assert bool(said) == bool(shown)


@pytest.mark.slow
@pytest.mark.core
def test_in_forty_columns_of_ascii_every_verb_answers_in_what_there_is() -> None:
    calls = ["evaluate fu2019", "derive fu2019", "effects sidestick", "require fu2019 --free zeta", "scenes"]
    shown = all_in_terminal([x.split() for x in calls], columns=40, PYTHONIOENCODING="ascii", NO_COLOR="1")
    for words, one in zip(calls, shown, strict=True):
        assert one.status == 0, (words, one.text)
        assert one.text.isascii()
        assert "\x1b[3" not in one.text
        assert not [x for x in one.screen if len(x) > 40 and " " in x.strip()], words


@pytest.mark.slow
@pytest.mark.core
def test_a_pipe_that_is_closed_ends_it_quietly_and_a_full_disk_in_a_sentence() -> None:
    words = [*COMMAND, "evaluate", "fu2019"]
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        assert (process.stderr.read(), process.wait()) == (b"", 141)
    if Path("/dev/full").exists():
        with Path("/dev/full").open("w") as full:
            done = subprocess.run(words, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
        assert done.returncode == 2
        assert "standard output cannot be written: no space left on device" in done.stderr


@pytest.mark.slow
@pytest.mark.core
@pytest.mark.parametrize("seconds", [0.15, 1.5])
def test_ctrl_c_ends_a_verb_from_the_first_moment_on_without_a_traceback(seconds: float) -> None:
    words = ("sweep", "delayed-spring", "--vary", "effects.delay.tau=0.001:0.1:2000000")
    shown = in_terminal(words, keys=[(seconds, b"\x03")])
    assert shown.status == 130
    assert "Traceback" not in shown.text


INTERRUPTED = """
import os, signal, sys
from haptisym.cli import main
from haptisym.verbs.stability import entry
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background job is born deaf to it
times, found = int(sys.argv.pop(1)), entry.every_passive_hand
def pressed(scene):
    for _ in range(times):
        os.kill(os.getpid(), signal.SIGINT)
    return found(scene)
entry.every_passive_hand = pressed
main()
"""
"""Ctrl-C when the verdicts on hands are there, and neither passivity nor limits nor margins."""


@pytest.mark.slow
@pytest.mark.core
@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
@pytest.mark.parametrize("to", [(), ("--json",)])
def test_the_first_ctrl_c_prints_what_is_proven_and_the_second_one_nothing(to: tuple[str, ...]) -> None:
    asked = ("stability", "delayed-spring", "--hand", "postural-arm", *to)
    once, twice = (
        subprocess.run([sys.executable, "-c", INTERRUPTED, n, *asked], capture_output=True, text=True, check=False)
        for n in "12"
    )
    assert (once.returncode, once.stderr) == (3, "")
    assert "(interrupted)" in once.stdout
    if to:
        [held] = json.loads(once.stdout)["held"]
        assert (held["stable"], held["critical"]) == (True, [])
        assert {x["reason"] for x in held["undecided"]} == {"stopped at the limit"}
    else:
        assert "postural-arm  stable" in once.stdout
    assert (twice.returncode, twice.stdout, twice.stderr) == (130, "", "")


@pytest.mark.slow
@pytest.mark.core
def test_ctrl_c_that_a_package_drops_comes_again_with_the_next_report_of_progress() -> None:
    probe = """
import signal
from haptisym.commands.terminal import interrupts, progress
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell without jobs ignores it in the background
with interrupts(), progress("sets") as told:
    try:
        signal.raise_signal(signal.SIGINT)
    except BaseException:
        print("dropped")
    told(1, 10)
    print("went on")
"""
    done = subprocess.run([sys.executable, "-c", probe], capture_output=True, text=True, check=False)
    assert done.stdout == "dropped\n"
    assert "KeyboardInterrupt" in done.stderr


@pytest.mark.slow
def test_a_package_that_a_verb_needs_and_that_is_missing_is_named_with_its_extra() -> None:
    probe = "import sys; sys.modules['scipy'] = None; sys.argv = ['haptisym', 'simulate', 'fu2019']; from haptisym.cli import main; main()"
    done = subprocess.run([sys.executable, "-c", probe], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (2, "")
    assert 'pip install "haptisym[simulate]"' in done.stderr


@pytest.mark.slow
@pytest.mark.core
def test_what_an_encoding_lacks_is_said_in_words_on_both_streams() -> None:
    calls = [("evaluate", "fu2019"), ("evaluate", "fu2019ω")]
    page, refused = all_in_terminal(calls, columns=100, PYTHONIOENCODING="ascii")
    assert "omega (rad/s)" in page.text
    headings, rule, first, *_ = page.screen[page.screen.index(next(x for x in page.screen if "omega (rad/s)" in x)) :]
    assert headings.index("Hz") == first.index("1.270")
    assert set(rule.strip()) == {"-"}
    assert refused.status == 2
    assert "error: fu2019 omega: no such scene" in refused.text.replace("\r\n", " ")


@pytest.mark.few("40")
@pytest.mark.parametrize("columns", [40, 66, 95])
def test_a_page_made_narrower_says_the_same_words_in_the_same_order(columns: int) -> None:
    page = hs.evaluate(hs.load_scene("organ-tissue")).document()
    told = Document(
        page.title, page.lead, tuple(x for x in Style(full=False).chosen(page.blocks) if not isinstance(x, Section))
    )
    narrow = plain(told, columns)
    assert narrow.split() == plain(told).split()
    assert max(map(len, narrow.split("\n"))) <= columns


@given(st.text(), st.sampled_from(["ascii", "latin-1", "cp1252", "utf-8"]))
def test_any_text_can_be_spelt_in_any_encoding_and_documents_keep_every_character(text: str, encoding: str) -> None:
    text = text.encode("utf-8", "ignore").decode()
    spelt(text, encoding).encode(encoding)
    written = escaped(json.dumps({"title": text}, ensure_ascii=False), encoding)
    assert json.loads(written.encode(encoding).decode(encoding)) == {"title": text}


HOSTILE = "\x1b]0;title\x07\x1b[25F\x1b[2K\x9b31m\x85\u202edegg\u202c\u2066x\u2069\x7f\u2028"
ACTS = re.compile("[\x00-\x09\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069]")
"""What speaks to a terminal or turns text around: C0, C1, separators of lines, overrides and isolates of direction."""


@pytest.mark.few(
    "evaluate-first-order-lag-0", "evaluate --json-first-order-lag-0", "stability --hand x-first-order-lag-2"
)
@pytest.mark.parametrize(
    ("words", "model", "status"),
    [
        ("evaluate", "first-order-lag", 0), ("evaluate --json", "first-order-lag", 0), ("effects", "first-order-lag", 0),
        ("derive --to python", "first-order-lag", 0), ("derive --to latex", "first-order-lag", 0),
        ("evaluate", f"lag{HOSTILE}", 2), ("stability --hand x", "first-order-lag", 2),
    ],
)  # fmt: skip
def test_nothing_that_a_scene_says_reaches_a_terminal_as_a_command(
    call: Any, tmp_path: Path, words: str, model: str, status: int
) -> None:
    """Neither on standard output nor in an error that quotes a name; a document keeps it, in JSON's escapes."""
    scene = tmp_path / "scene.toml"
    hostile, kind = (json.dumps(x).replace("\x7f", "\\u007f") for x in (f"a{HOSTILE}b", model))
    effect = f"[[effects]]\nname = {hostile}\nmodel = {kind}\nomega_c = 20\n[[hands]]\nname = {hostile}\nk = 1\n"
    environment = "[environment]\nmodel = 'kelvin-voigt'\nk = 100\nb = 2\n"
    scene.write_text(f"title = {hostile}\nsource = {hostile}\n{environment}{effect}", encoding="utf-8")
    verb, *options = words.split()
    ended, out, err = call(verb, str(scene), *options)
    assert ended == status
    assert not ACTS.search(out + err)
    assert ("\ufffd" in out + err) == (not {"--json", "--to"} & {*options})
    if "--json" in options:
        assert json.loads(out)["title"] == f"a{HOSTILE}b"


@pytest.mark.slow
def test_a_figure_of_such_a_scene_is_a_document(tmp_path: Path) -> None:
    """Which no control character may stand in."""
    scene = hs.Scene(hs.environments.kelvin_voigt(k=100, b=2), (hs.effects.first_order_lag(20, name=f"a{HOSTILE}"),))
    for answer in (hs.relevance(scene), hs.stability(scene)):
        for path in answer.save_figures(tmp_path):
            if path.suffix == ".svg":
                assert not ACTS.search(" ".join(ElementTree.parse(path).getroot().itertext()).replace("\n", ""))
        assert not ACTS.search(repr(answer))


@pytest.mark.slow
def test_a_json_document_in_an_ascii_pipe_keeps_every_character(tmp_path: Path) -> None:
    scene = tmp_path / "prüfstand.toml"
    scene.write_text(
        'title = "Prüfstand für ω, 振動"\nenvironment = { model = "maxwell", k = 1, b = 2 }\n', encoding="utf-8"
    )
    done = subprocess.run(
        [*COMMAND, "evaluate", str(scene), "--json"],
        capture_output=True, check=True, env=environment(80, PYTHONIOENCODING="ascii"),
    )  # fmt: skip
    assert json.loads(done.stdout.decode("ascii"))["title"] == "Prüfstand für ω, 振動"


@pytest.mark.slow
@pytest.mark.core
def test_ctrl_c_that_falls_into_a_finalizer_comes_again() -> None:
    """Python drops what is raised there: the verb went on to its end as if nothing had been pressed."""
    code = """
import os, signal, sys, threading, time
from haptisym.commands.terminal import interrupts
class Pressed:
    def __del__(self):
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(0.001)
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background job is born deaf to it
with interrupts() as seen:
    Pressed()
    try:
        threading.Event().wait(20)
    except KeyboardInterrupt:
        print("ended", seen)
assert sys.unraisablehook is sys.__unraisablehook__
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False, timeout=30)
    assert (done.stdout, done.stderr, done.returncode) == ("ended [2]\n", "", 0)


@pytest.mark.slow
def test_a_sweep_that_is_interrupted_says_how_it_is_continued(tmp_path: Path) -> None:
    out = tmp_path / "swept.zarr"
    words = ("sweep", "delayed-spring", "--vary", "effects.delay.tau=0.001:0.1:100000", "--out", str(out))
    shown = in_terminal(words, columns=400, keys=[(b" sets", b"\x03")])
    assert shown.status == 130
    said = f"of 100,000 sets: what is done is in {out}.part.zarr, and the same command goes on from there"
    assert said in shown.text.replace("\r\n", " ")
    assert [x.name for x in tmp_path.iterdir()] == ["swept.zarr.part.zarr"]


@pytest.mark.slow
def test_a_bar_of_progress_leaves_nothing_behind() -> None:
    [shown] = all_in_terminal([("sweep", "delayed-spring", "--vary", "effects.delay.tau=0.001:0.1:200")], columns=40)
    assert shown.status == 0
    assert shown.screen[0].startswith("Delayed spring")


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_what_the_shell_started_in_the_background_is_not_ended_by_ctrl_c() -> None:
    probe = "import signal; signal.signal(signal.SIGINT, signal.SIG_IGN); from haptisym.__main__ import main; import sys, os; sys.argv = ['haptisym', '--help']; os.kill(os.getpid(), signal.SIGINT); main()"
    assert subprocess.run([sys.executable, "-c", probe], capture_output=True, check=True).returncode == 0


@pytest.mark.parametrize(
    ("text", "plain"),
    [
        ("x²", "x^2"), ("10⁻³", "10^-3"), ("x²³", "x^23"), ("²", "^2"), ("a₁₂", "a_1_2"), ("ω", "omega"), ("2ω", "2 omega"), ("(ω", "(omega"), ("Ω", "Omega"),
        ("aΓ", "a Gamma"), ("λ", "lambda"), ("ﬁ", "fi"), ("é", "e"), ("e\u0301", "e"), ("½", "\\u00bd"), ("振", "\\u632f"), ("😀", "\\U0001f600"), ("−≤≥≠±", "-<=>=!=+-"),
        ("√∞∂…", "sqrtinfd..."), ("ß", "ss"), ("§3", "section 3"), ("\u00a0", " "), ("plain", "plain"), ("°", "deg"), ("µ", "u"), ("Å", "A"),
    ],
)  # fmt: skip
def test_what_ascii_lacks_is_spelt(text: str, plain: str) -> None:
    assert spelt(text, "ascii") == plain
    assert spelt(text, "utf-8") == spelt(text, "no-such-encoding") == text


def test_documents_keep_every_character_in_the_escapes_of_json(capsys: pytest.CaptureFixture[str]) -> None:
    assert escaped("aé😀ω", "ascii") == "a\\u00e9\\ud83d\\ude00\\u03c9"
    assert escaped("aéω", "latin-1") == "aé\\u03c9"
    assert escaped("aω", "utf-8") == escaped("aω", "no-such-encoding") == "aω"
    say_document("{}")
    assert capsys.readouterr().out == "{}\n"
