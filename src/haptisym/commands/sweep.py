"""``haptisym sweep``: a scene for every combination of values of some of its parameters."""

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

import click

from haptisym.commands.options import drawn, figure_option, hand_over, json_option, progress, scene_argument, verb
from haptisym.kernel.errors import SceneError
from haptisym.model.scene import Scene


@verb(apart=[("--workers", "--cluster", "--workers computes on this machine, --cluster on others")])
@scene_argument
@click.option(
    "--vary",
    "vary",
    multiple=True,
    required=True,
    metavar="PATH=LO:HI:N[:log]",
    help='N values of a parameter, as "omega_n=40 rad/s:200 rad/s:100"; repeatable.',
)
@click.option(
    "--hand",
    "names",
    multiple=True,
    metavar="NAME",
    help="Count unstable poles in this hand; repeatable.",
)
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Write to FILE.zarr or FILE.nc; continues what is there.",
)
@json_option
@figure_option("the design chart of one or two parameters")
@click.option(
    "--workers", type=click.IntRange(1, 1024), metavar="N", help="Processes on this machine (1 if not given)."
)
@click.option("--cluster", metavar="ADDRESS", help='Address of a dask scheduler, as "tcp://10.0.0.1:8786".')
def sweep(
    scene: Scene,
    vary: tuple[str, ...],
    names: tuple[str, ...],
    out: Path | None,
    as_json: bool,
    figure: Path | None,
    workers: int | None,
    cluster: str | None,
) -> None:
    """Evaluate a scene for every combination of values.

    SCENE is a scene file (TOML) or the name of a shipped scene. PATH is effects.NAME.KEY, environment.KEY,
    evaluation.jnd, hand.KEY, or a symbol.

    For each set: the first crossing and the number of crossings of each part, the bandwidth, the transparent fraction of
    the band, the changeover frequencies, and in each hand the number of unstable poles. Counts are proven, frequencies to
    a relative 1e-10. The same command continues an interrupted sweep.

    \b
    Examples:
      haptisym sweep fu2019 --vary effects.filter.omega_n=20:200:100 --figure bandwidth.svg
      haptisym sweep fu2019 --vary "effects.filter.omega_n=5 Hz:50 Hz:1000:log" \\
          --vary environment.m=0.5:5:1000 --out design.zarr --workers 2
      haptisym sweep fu2019 --hand light-touch --vary effects.filter.omega_n=5:200:100
    """
    if (workers or cluster) and out is None:
        raise SceneError("--workers and --cluster need --out FILE, to which the workers write")
    from haptisym.verbs.stability.entry import in_hands
    from haptisym.verbs.sweep.axes import spaced
    from haptisym.verbs.sweep.entry import Swept
    from haptisym.verbs.sweep.entry import sweep as sweep_scene

    scene = in_hands(scene, names or None)
    asked = [spaced(text, scene) for text in vary]
    if len({path for path, _ in asked}) < len(asked):
        raise SceneError("--vary: each path may be given only once")
    if figure is not None and len(asked) > 2:
        raise SceneError(f"figure: {figure} would show one or two parameters, not {len(asked)}")
    with ExitStack() as stack:
        stack.enter_context(_engine(workers, cluster))
        told = stack.enter_context(progress("sets", kept=_kept(out)))
        found = Swept(scene, sweep_scene(scene, dict(asked), out=out, progress=told), out)
    drawn(found, figure)
    hand_over(found, as_json=as_json)


def _kept(out: Path | None) -> str:
    """What there is of a sweep that was interrupted."""
    if out is None:
        return "nothing is kept; with --out FILE.zarr the same command would go on from there"
    return f"what is done is in {out}, and the same command goes on from there"


@contextmanager
def _engine(workers: int | None, cluster: str | None) -> Iterator[None]:
    """What computes the blocks: this process, some processes of this machine, or a cluster."""
    if not workers and not cluster:
        with _in_this_process():
            yield
        return
    try:
        distributed: Any = import_module("distributed")
    except ImportError:
        raise SceneError('distributed is missing: --workers and --cluster need "pip install haptisym[sweep]"') from None
    with ExitStack() as stack:
        address: Any = cluster
        if workers:
            local = partial(distributed.LocalCluster, n_workers=workers, threads_per_worker=1, dashboard_address=None)
            with _deaf_children():
                address = stack.enter_context(local(silence_logs=logging.CRITICAL))
        try:
            stack.enter_context(distributed.Client(address, timeout="10s"))
        except (OSError, ValueError):
            raise SceneError(f"--cluster {cluster}: no dask scheduler answers there") from None
        try:
            yield
        except KeyboardInterrupt:
            logging.disable()  # dask would tell at length what became of the tasks that nobody waits for
            raise


@contextmanager
def _deaf_children() -> Iterator[None]:
    """Threads and processes that are started inside do not hear Ctrl-C; this process hears it when they are there."""
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
    try:
        from dask import config
    except ImportError:  # only needed for a file, where its absence is told
        yield
        return
    with config.set(scheduler="synchronous", num_workers=1):
        yield
