"""Every verb as it meets terminals, pipes, full disks and Ctrl-C."""

from __future__ import annotations

import errno
import io
import json
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from terminal import COMMAND, all_in_terminal, environment, in_terminal

import haptisym as hs
from haptisym.commands.progress import _figure
from haptisym.commands.spelling import escaped, spelt
from haptisym.writing.document import Document, Section, chosen
from haptisym.writing.plain import plain

CALLS = [
    ("evaluate", "fu2019"),
    ("derive", "fu2019"),
    ("effects", "sidestick"),
    ("require", "fu2019", "--free", "zeta"),
    ("sensitivity", "fu2019"),
    ("tolerances", "fu2019-tolerances", "--samples", "20"),
    ("sweep", "fu2019", "--vary", "effects.filter.omega_n=40:200:3"),
    ("metrics", "fu2019"),
    ("cost", "fu2019", "--quick"),
    ("simulate", "fu2019"),
    ("scenes",),
]
"""Each verb, as quick as it gets."""


@pytest.mark.parametrize(
    ("columns", "more", "calls"),
    [
        (40, {"PYTHONIOENCODING": "ascii", "NO_COLOR": "1"}, CALLS[:4]),
        pytest.param(40, {"PYTHONIOENCODING": "ascii", "NO_COLOR": "1"}, CALLS, marks=pytest.mark.slow),
        pytest.param(120, {}, CALLS, marks=pytest.mark.slow),
        pytest.param(80, {"PYTHONIOENCODING": "latin-1"}, CALLS, marks=pytest.mark.slow),
        pytest.param(60, {"LC_ALL": "C", "NO_COLOR": "1"}, CALLS, marks=pytest.mark.slow),
    ],
)
def test_every_verb_answers_in_a_terminal_in_characters_and_columns_that_it_has(
    columns: int, more: dict[str, str], calls: list[tuple[str, ...]]
) -> None:
    for words, shown in zip(calls, all_in_terminal(calls, columns=columns, **more), strict=True):
        assert shown.status == 0, (words, shown.text)
        assert "Traceback" not in shown.text, words
        too_long = [x for x in shown.screen if len(x) > min(columns, 96) and " " in x.strip()]
        assert not too_long, words
        assert max(map(len, shown.screen)) > 0.8 * min(columns, 96) or words[0] in ("scenes", "simulate", "sweep"), (
            words
        )
        if "NO_COLOR" in more:
            assert "\x1b[3" not in shown.text, words
        if more.get("LC_ALL") == "C":
            assert shown.text.isascii(), words


def test_what_an_encoding_lacks_is_said_in_words_on_both_streams() -> None:
    calls = [("evaluate", "fu2019"), ("evaluate", "fu2019ω")]
    page, refused = all_in_terminal(calls, columns=100, PYTHONIOENCODING="ascii")
    assert "Re dH = omega^2 (1.8 omega^4 - 100 omega^2 + 7680000)" in page.text
    headings, rule, first, *_ = page.screen[page.screen.index(next(x for x in page.screen if "omega (rad/s)" in x)) :]
    assert headings.index("Hz") == first.index("1.2699")
    assert set(rule.strip()) == {"-"}
    assert refused.status == 2
    assert "error: fu2019 omega: neither a scene file" in refused.text.replace("\r\n", " ")


@pytest.mark.few("40")
@pytest.mark.parametrize("columns", [40, 66, 95])
def test_a_page_made_narrower_says_the_same_words_in_the_same_order(columns: int) -> None:
    page = hs.evaluate(hs.load_scene("organ-tissue")).document()
    told = Document(
        page.title, page.lead, tuple(x for x in chosen(page.blocks, full=False) if not isinstance(x, Section))
    )
    narrow = plain(told, columns)
    assert narrow.split() == plain(told).split()
    assert max(map(len, narrow.split("\n"))) <= columns


def test_a_table_with_no_room_is_a_list_of_what_each_row_says() -> None:
    narrow = plain(hs.evaluate(hs.load_scene("fu2019")).document(), 40)
    assert "  part: real\n  ω (rad/s): 7.97891679017471\n  Hz: 1.2699\n  what happens: r_r rises above 10 %\n" in narrow


@given(st.text(), st.sampled_from(["ascii", "latin-1", "cp1252", "utf-8"]))
def test_any_text_can_be_spelt_in_any_encoding_and_documents_keep_every_character(text: str, encoding: str) -> None:
    text = text.encode("utf-8", "ignore").decode()
    spelt(text, encoding).encode(encoding)
    written = escaped(json.dumps({"title": text}, ensure_ascii=False), encoding)
    assert json.loads(written.encode(encoding).decode(encoding)) == {"title": text}


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
def test_a_page_in_a_pipe_is_the_same_whatever_the_terminal_is() -> None:
    narrow = subprocess.run(
        [*COMMAND, "evaluate", "fu2019"], capture_output=True, check=True, env=environment(80, COLUMNS="40")
    )
    assert narrow.stdout.decode() == str(hs.evaluate(hs.load_scene("fu2019")))


class Refusing(io.RawIOBase):
    """Standard output that takes nothing."""

    def __init__(self, number: int) -> None:
        self.number = number

    def writable(self) -> bool:
        return True

    def write(self, _data: object) -> int:
        raise OSError(self.number, errno.errorcode[self.number])


@pytest.mark.few(4)
@pytest.mark.parametrize(
    "words", [*CALLS, ("--help",), ("sweep", "--help"), ("scenes", "fu2019"), ("evaluate", "fu2019", "--json")]
)
def test_an_output_that_nobody_reads_ends_quietly_and_a_full_one_in_a_sentence(call, monkeypatch, words) -> None:  # type: ignore[no-untyped-def]
    if words[0] in ("cost", "tolerances", "simulate"):
        words = (words[0], "--help")  # all verbs write in the same place; these take their time
    for number, status, said in (
        (errno.EPIPE, 141, ""),
        (errno.ENOSPC, 2, "error: standard output cannot be written: enospc\n"),
    ):
        with monkeypatch.context() as patch:
            refusing = io.TextIOWrapper(io.BufferedWriter(Refusing(number), 1), write_through=True)
            patch.setattr("sys.stdout", refusing)
            found = call(*words)
            patch.setattr(refusing, "close", lambda: None, raising=False)
        assert found == (status, "", said)


@pytest.mark.slow
@pytest.mark.parametrize("words", [("--help",), *CALLS])
def test_a_pipe_that_is_closed_and_a_disk_that_is_full(words: tuple[str, ...]) -> None:
    with subprocess.Popen([*COMMAND, *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        assert (process.stderr.read(), process.wait()) == (b"", 141)
    if Path("/dev/full").exists():
        with Path("/dev/full").open("w") as full:
            done = subprocess.run([*COMMAND, *words], stdout=full, stderr=subprocess.PIPE, text=True, check=False)
        assert (done.returncode, done.stderr) == (
            2,
            "error: standard output cannot be written: no space left on device\n",
        )


@pytest.mark.parametrize(
    "seconds", [0.15, *(pytest.param(x, marks=pytest.mark.slow) for x in (0.1, 0.3, 0.6, 0.9, 1.2, 1.5, 2.0))]
)
def test_ctrl_c_ends_a_verb_from_the_first_moment_on_without_a_traceback(seconds: float) -> None:
    shown = in_terminal(
        ("sweep", "delayed-spring", "--vary", "effects.delay.tau=0.001:0.1:2000000"), keys=[(seconds, b"\x03")]
    )
    assert shown.status == 130
    assert "Traceback" not in shown.text


def test_ctrl_c_that_falls_into_a_finalizer_comes_again() -> None:
    """Python drops what is raised there: the verb went on to its end as if nothing had been pressed."""
    code = """
import os, signal, sys, threading, time
from haptisym.commands.streams import interrupts
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
    assert f"of 100,000 sets: what is done is in {out}, and the same command goes on from there" in shown.text.replace(
        "\r\n", " "
    )
    assert out.exists()


@given(st.integers(0, 10**9) | st.floats(1e-3, 1e9) | st.floats(999, 1001))
def test_how_far_something_came_is_written_in_plain_figures(x: float) -> None:
    text = _figure(x)
    assert set(text) <= set("0123456789.,")
    assert abs(float(text.replace(",", "")) - x) <= (0.005 * x if x < 999 else 0.5)
    assert isinstance(x, float) or text == f"{x:,}"


@pytest.mark.slow
def test_a_bar_of_progress_leaves_nothing_behind() -> None:
    [shown] = all_in_terminal([("sweep", "delayed-spring", "--vary", "effects.delay.tau=0.001:0.1:200")], columns=40)
    assert shown.status == 0
    assert shown.screen[0].startswith("Delayed spring")


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_what_the_shell_started_in_the_background_is_not_ended_by_ctrl_c() -> None:
    probe = "import signal; signal.signal(signal.SIGINT, signal.SIG_IGN); from haptisym_command import main; import sys, os; sys.argv = ['haptisym', '--help']; os.kill(os.getpid(), signal.SIGINT); main()"
    assert subprocess.run([sys.executable, "-c", probe], capture_output=True, check=True).returncode == 0
