"""Files that are written whole or not at all: under another name in the same folder, by one writer,
and renamed when they are complete."""

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
    """An unused hidden name for an incomplete file, in the same folder and with the same ending."""
    # In the same folder, as only within one file system a rename is atomic.
    return path.with_name(f".{uuid4().hex[:12]}{path.suffix}")


@contextmanager
def replacing(path: str | Path) -> Iterator[Path]:
    """A name to write to; what is written there takes the place of the file when all of it is
    there.

    Where that does not happen (a full disk, Ctrl-C) the old file stays as it was, and nothing is
    left beside it. What is no file, as a pipe or a device, is written to as it is. A link stays a
    link, to the new file.
    """
    # A pipe or a device cannot be replaced.
    given = Path(path)
    if given.exists() and not given.is_file():
        yield given
        return
    # Through links, so that a link goes on pointing to the new file.
    target = given.resolve()
    fresh = beside(target)
    try:
        # A rename needs no right to write the old file: without this test it would replace a file
        # that is protected against writing.
        if target.exists() and not os.access(target, os.W_OK):
            raise PermissionError(EACCES, os.strerror(EACCES), str(given))
        yield fresh
        with suppress(FileNotFoundError):
            shutil.copymode(target, fresh)
        fresh.replace(target)
    except OSError as error:
        # The user must read the name that was given, not the hidden one.
        if error.filename == str(fresh):
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
    """A context in which no other process makes this file; SceneError where one is at it already.

    The system drops the claim of a process that was killed. The file that carries it is taken away
    at the end.
    """
    lock = path.with_name(f".{path.name}.lock")
    handle = os.open(lock, os.O_RDWR | os.O_CREAT, 0o666)
    try:
        _lock(handle)
        # The process that had it before may have removed the file between open and lock: the lock
        # is then on a file without a name, which nobody else will look at.
        if lock.stat().st_ino != os.fstat(handle).st_ino:
            raise BlockingIOError
    except OSError:
        os.close(handle)
        told = "another process is writing it: wait until it is done, or choose another name"
        raise SceneError(f"{path}: {told}") from None
    try:
        yield
    finally:
        # Windows does not remove an open file.
        with suppress(OSError):
            lock.unlink()
        os.close(handle)


def _lock(handle: int) -> None:
    """Lock an open file; OSError where another process has it locked."""
    if sys.platform == "win32":
        windows: Any = import_module("msvcrt")
        windows.locking(handle, windows.LK_NBLCK, 1)
    else:
        import fcntl  # not there on Windows

        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
