"""How the command line meets its terminal: pages as wide, characters that it has, nobody who reads, Ctrl-C."""

from __future__ import annotations

import _thread
import os
import shutil
import signal
import sys
import threading
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from io import TextIOWrapper
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING

from haptisym.commands.spelling import HANDLER, escaped, register, spelt
from haptisym.kernel.errors import HaptisymError

if TYPE_CHECKING:
    from haptisym.writing.document import Document


_MOMENT = 0.02  # s


class ReaderLeft(Exception):  # noqa: N818  it is nobody's error
    """Whoever read standard output has closed it, as ``head`` does."""


class CannotWriteError(HaptisymError):
    """A file or standard output does not take what is written."""


def prepare() -> None:
    """Let both streams spell what their encoding lacks; ASCII in a terminal whose locale was set to C or POSIX."""
    register()
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(encoding="ascii" if _is_plain(stream) else stream.encoding, errors=HANDLER)


def _is_plain(stream: TextIOWrapper) -> bool:
    """Python writes UTF-8 where the locale is C, as containers have it unasked; a terminal that was told so has ASCII."""
    if not stream.isatty() or os.environ.get("PYTHONIOENCODING") or os.environ.get("PYTHONUTF8"):
        return False
    locale = next((x for name in ("LC_ALL", "LC_CTYPE", "LANG") if (x := os.environ.get(name))), "")
    return locale in ("C", "POSIX")


def say(page: Document) -> None:
    """A page on standard output: as wide as the terminal, 96 columns anywhere else so that it can be compared."""
    from haptisym.writing.plain import PAGE, plain  # only a page needs the writer

    is_terminal = sys.stdout is not None and sys.stdout.isatty()
    write(plain(page, min(shutil.get_terminal_size((PAGE, 24)).columns, PAGE) if is_terminal else PAGE, _spell))


def say_document(document: Iterable[str]) -> None:
    """A JSON document on standard output, in parts, or as one text."""
    encoding = _encoding()
    for part in (document,) if isinstance(document, str) else document:
        write(escaped(part, encoding))
    write("\n")


def write(text: str) -> None:
    """Text on standard output as it is. ReaderLeft or CannotWriteError where it does not get there."""
    if sys.stdout is None:
        raise CannotWriteError("standard output cannot be written: it is closed")
    with to_standard_output():
        sys.stdout.write(text)
        sys.stdout.flush()


def note(message: str) -> None:
    """A message on standard error; lost where that is closed or full."""
    if sys.stderr is None:
        return
    with suppress(OSError, ValueError):
        if sys.stderr.isatty():
            message = "\n".join(map(_narrowed, message.split("\n")))
        sys.stderr.write(f"{message}\n")
        sys.stderr.flush()


def _narrowed(line: str) -> str:
    """A line of a message in the terminal's width; what is indented is typed, and stays."""
    width = min(max(os.get_terminal_size(sys.stderr.fileno()).columns, 40), 96)
    return line if line.startswith("    ") else fill(line, width, break_long_words=False, break_on_hyphens=False)


def _spell(words: str) -> str:
    return spelt(words, _encoding())


def _encoding() -> str:
    return getattr(sys.stdout, "encoding", None) or "utf-8"


@contextmanager
def to_standard_output() -> Iterator[None]:
    """What goes wrong inside with standard output, by name; nothing more is then tried to be written there."""
    try:
        yield
    except BrokenPipeError:
        _close()
        raise ReaderLeft from None
    except OSError as error:
        if error.filename is not None:
            raise
        _close()
        raise CannotWriteError(f"standard output cannot be written: {_reason(error)}") from None


@contextmanager
def to_file(what: str, path: Path) -> Iterator[None]:
    """What goes wrong inside with writing a file, as a sentence that names it."""
    try:
        yield
    except OSError as error:
        raise CannotWriteError(f"{what}: {path} cannot be written: {_reason(error)}") from None


def _reason(error: OSError) -> str:
    return (error.strerror or str(error)).lower()


def _close() -> None:
    """What is still in the buffer goes nowhere, so that the end of the process does not try again."""
    with suppress(OSError, ValueError, AttributeError):
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stdout.fileno())
        os.close(nowhere)


def _interrupt() -> None:
    """Ctrl-C to the main thread, which may wait for others."""
    if sys.platform == "win32":
        _thread.interrupt_main()
    else:
        signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGINT)


@contextmanager
def interrupts() -> Iterator[list[int]]:
    """Ctrl-C raises KeyboardInterrupt, once; what it yields then is not empty, even if an import made another error of it.

    Whoever presses it again while things are being tidied up does not wait any longer: status 130 at once. Where it falls into
    code whose errors Python drops (a finalizer, a callback of an import's lock) it comes again a moment later.
    """
    seen: list[int] = []
    dropped = sys.unraisablehook
    is_ours = (
        threading.current_thread() is threading.main_thread()
        and signal.getsignal(signal.SIGINT) is signal.default_int_handler
    )

    def interrupted(number: int, _frame: object) -> None:
        if seen:
            note("\x1b[?25h" if sys.stderr and sys.stderr.isatty() else "")  # a bar of progress hides the cursor
            os._exit(130)
        seen.append(number)
        raise KeyboardInterrupt

    def again(lost: sys.UnraisableHookArgs) -> None:
        if not issubclass(lost.exc_type, KeyboardInterrupt):
            dropped(lost)
            return
        seen.clear()
        later = threading.Timer(_MOMENT, _interrupt)
        later.daemon = True
        later.start()

    if is_ours:
        signal.signal(signal.SIGINT, interrupted)
        sys.unraisablehook = again
    try:
        yield seen
    finally:
        if is_ours:
            sys.unraisablehook = dropped
            signal.signal(signal.SIGINT, signal.default_int_handler)
