"""The command line in a pseudo-terminal: as wide as wanted, with real Ctrl-C, and what then stands on the screen."""

from __future__ import annotations

import fcntl
import json
import os
import pty
import re
import select
import signal
import struct
import subprocess
import sys
import termios
import time
from collections.abc import Sequence
from typing import NamedTuple

COMMAND = [sys.executable, "-c", "from haptisym.__main__ import main; main()"]
"""What the installed ``haptisym`` does."""

_SEVERAL = """
import json, sys
from haptisym.cli import main
for words in json.loads(sys.argv[1]):
    sys.argv = ["haptisym", *words]
    try:
        main()
    except SystemExit as end:
        print(f"\\x1e{end.code or 0}\\x1e", flush=True)
"""


Key = tuple[float | bytes, bytes]
"""What is typed so many seconds after the key before, or as soon as some text is on the screen."""


class Shown(NamedTuple):
    """What a call left: its exit status, and all that it wrote to the terminal, standard error included."""

    status: int
    text: str

    @property
    def screen(self) -> list[str]:
        """What stands there at the end: without colours, and without what was written over or wiped."""
        lines, row = [""], 0
        for mark, text in re.findall(r"(\x1b\[[0-9;?]*[A-Za-z]|\r|\n)|([^\x1b\r\n]+)", self.text):
            if mark == "\n":
                row += 1
                lines += [""] * (row == len(lines))
            elif mark.endswith("A"):
                row -= int(mark[2:-1])
            elif mark.endswith("K"):
                lines[row] = ""
            elif text:
                lines[row] += text
        return lines


def environment(columns: int, **more: str | None) -> dict[str, str]:
    """This process's environment for a terminal of that width; None takes a variable away."""
    plain = {name: value for name, value in os.environ.items() if name not in ("NO_COLOR", "FORCE_COLOR", "LINES")}
    given = {"TERM": "xterm-256color", "COLUMNS": None, "PYTHONUTF8": None, "LC_ALL": "C.UTF-8", **more}
    return {name: value for name, value in {**plain, **given}.items() if value is not None}


def in_terminal(words: Sequence[str], *, columns: int = 80, keys: Sequence[Key] = (), **more: str | None) -> Shown:
    """One call in a terminal. ``keys`` : what is typed, and when; ``more`` : of its environment."""
    return _run([*COMMAND, *words], columns, keys, more)


def all_in_terminal(calls: Sequence[Sequence[str]], *, columns: int = 80, **more: str | None) -> list[Shown]:
    """Several calls in a terminal, one process for all."""
    told = _run([sys.executable, "-c", _SEVERAL, json.dumps(calls)], columns, (), more).text
    fields = told.split("\x1e")
    assert len(fields) == 2 * len(calls) + 1, told
    return [Shown(int(status), text) for text, status in zip(fields[:-1:2], fields[1::2], strict=True)]


def _in_front() -> None:
    """Ctrl-C reaches it and ends it, also where the tests themselves run in the background."""
    fcntl.ioctl(0, termios.TIOCSCTTY, 0)
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def _run(command: list[str], columns: int, keys: Sequence[Key], more: dict[str, str | None]) -> Shown:
    master, slave = pty.openpty()
    fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("HHHH", 40, columns, 0, 0))
    process = subprocess.Popen(
        command, stdin=slave, stdout=slave, stderr=slave, start_new_session=True, env=environment(columns, **more),
        preexec_fn=_in_front,
    )  # fmt: skip
    os.close(slave)
    try:
        found, waiting, last = bytearray(), list(keys), time.monotonic()
        while True:
            sign = waiting[0][0] if waiting else 120.0
            patience = 120.0 if isinstance(sign, bytes) else max(0.0, last + sign - time.monotonic())
            ready, _, _ = select.select([master], [], [], patience)
            assert ready or waiting, f"no sign of life for two minutes: {found!r}"
            if waiting and (sign in found if isinstance(sign, bytes) else time.monotonic() >= last + sign):
                os.write(master, waiting.pop(0)[1])
                last = time.monotonic()
            if ready:
                try:
                    found += os.read(master, 65536)
                except OSError:  # the other end is closed
                    break
        return Shown(process.wait(timeout=60), found.decode(more.get("PYTHONIOENCODING") or "utf-8", errors="strict"))
    finally:
        process.kill()
        process.wait()
        os.close(master)
