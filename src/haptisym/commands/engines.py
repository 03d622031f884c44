"""What computes the sets of a sweep (this process, some of this machine, or a cluster), and what
Ctrl-C leaves of it."""

from __future__ import annotations

import logging
import signal
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from functools import partial
from importlib import import_module
from multiprocessing import resource_tracker
from pathlib import Path
from typing import Any

from haptisym.kernel.errors import SceneError
from haptisym.verbs.sweep.entry import unfinished


@contextmanager
def engine(workers: int | None, cluster: str | None) -> Iterator[None]:
    """What computes the blocks: this process, some processes of this machine, or a cluster."""
    if not workers and not cluster:
        with _in_this_process():
            yield
        return
    try:
        distributed: Any = import_module("distributed")
    except ImportError:
        raise SceneError(
            'distributed is missing: --workers and --cluster need "pip install haptisym[sweep]"'
        ) from None
    with ExitStack() as stack:
        address: Any = cluster
        if workers:
            local = partial(
                distributed.LocalCluster,
                n_workers=workers,
                threads_per_worker=1,
                dashboard_address=None,
            )
            with _deaf_children():
                try:
                    address = stack.enter_context(local(silence_logs=logging.CRITICAL))
                except (OSError, RuntimeError) as error:
                    raise SceneError(
                        f"--workers {workers}: they could not be started: {error}"
                    ) from None
        try:
            stack.enter_context(distributed.Client(address, timeout="10s"))
        except (OSError, ValueError):
            raise SceneError(f"--cluster {cluster}: no dask scheduler answers there") from None
        try:
            yield
        except KeyboardInterrupt:
            # Dask would report at length what became of the tasks that nobody waits for.
            logging.disable()
            raise


@contextmanager
def _deaf_children() -> Iterator[None]:
    """Threads and processes that are started inside do not receive Ctrl-C; this process receives it
    once they are there."""
    # A terminal sends Ctrl-C to all processes of its group. Children inherit the mask of blocked
    # signals, so it must be set before they are started.
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    resource_tracker.ensure_running()  # later, it would let their signals through
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def _in_this_process() -> Iterator[None]:
    """Let dask, where it is installed, compute in this thread."""
    try:
        from dask import config
    except ImportError:  # only needed for a file, where its absence is told
        yield
        return
    with config.set(scheduler="synchronous", num_workers=1):
        yield


def left_of(out: Path | None, reached: str) -> str:
    """What is left of a sweep that Ctrl-C ended there; before anything is reached, its file has not
    been opened."""
    if out is None:
        return "nothing is kept; with --out FILE.zarr the same command would go on from there"
    if not reached:
        return f"{out} is as it was"
    if out.exists():
        return f"all sets are in {out}, and the same command prints the answer"
    return f"what is done is in {unfinished(out)}, and the same command goes on from there"
