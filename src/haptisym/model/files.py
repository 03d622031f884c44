"""Files that are written whole or not at all: beside their place, by one writer, and put there when
they are complete."""

from __future__ import annotations

import os
import shutil
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from errno import EACCES
from importlib import import_module
from pathlib import Path
from typing import Any
from uuid import uuid4

from haptisym.kernel.errors import SceneError


def beside(path: Path) -> Path:
    """A name of its own for what is not yet complete, in the same folder and with the same
    ending."""
    return path.with_name(f".{uuid4().hex[:12]}{path.suffix}")


@contextmanager
def replacing(path: str | Path) -> Iterator[Path]:
    """A name to write to; what is written there takes the place of the file when all of it is
    there.

    Where that does not happen (a full disk, Ctrl-C) the old file stays as it was, and nothing is
    left beside it. What is no file, as a pipe or a device, is written to as it is. A link stays a
    link, to the new file.
    """
    given = Path(path)
    if given.exists() and not given.is_file():
        yield given
        return
    target = given.resolve()
    fresh = beside(target)
    try:
        if target.exists() and not os.access(target, os.W_OK):
            raise PermissionError(EACCES, os.strerror(EACCES), str(given))
        yield fresh
        with suppress(FileNotFoundError):
            shutil.copymode(target, fresh)
        fresh.replace(target)
    except OSError as error:
        if error.filename == str(fresh):  # nobody but us knows that name
            error.filename = str(given)
        raise
    finally:
        fresh.unlink(missing_ok=True)


def write_whole(path: str | Path, content: str, encoding: str = "utf-8") -> None:
    """Write a text to a file, all of it or nothing."""
    with replacing(path) as fresh:
        fresh.write_text(content, encoding=encoding)


@contextmanager
def claimed(path: Path) -> Iterator[None]:
    """As long as it lasts, nobody else makes this file: SceneError where another process is at it.

    The system drops the claim of a process that was killed. The file that carries it is taken away
    at the end.
    """
    lock = path.with_name(f".{path.name}.lock")
    handle = os.open(lock, os.O_RDWR | os.O_CREAT, 0o666)
    try:
        _lock(handle)
        if (
            lock.stat().st_ino != os.fstat(handle).st_ino
        ):  # whoever had it before is just taking it away
            raise BlockingIOError
    except OSError:
        os.close(handle)
        told = "another process is writing it: wait until it is done, or choose another name"
        raise SceneError(f"{path}: {told}") from None
    try:
        yield
    finally:
        with suppress(OSError):  # Windows: of an open file
            lock.unlink()
        os.close(handle)


def _lock(handle: int) -> None:
    """OSError where another process has it locked."""
    if sys.platform == "win32":
        windows: Any = import_module("msvcrt")
        windows.locking(handle, windows.LK_NBLCK, 1)
    else:
        import fcntl  # not there on Windows

        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
