"""What ``haptisym simulate`` asks for, as simulations; with a bar of progress for long ones."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from math import pi
from time import monotonic

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn

from haptisym.errors import SceneError
from haptisym.quantities import Dimension
from haptisym.scene import Scene

from .motions import Motion, chirp, multisine, positive, sine
from .recordings import recording
from .results import EncoderQuantisation, Extra, ForceSaturation
from .simulate import Simulation, band_frequencies, check, default_amplitude, simulate

_PATIENCE = 1.0  # s; shorter runs show no progress


def run(scene: Scene, along_band: bool, options: Mapping[str, str | None]) -> tuple[Simulation, ...]:  # noqa: FBT001
    """The runs of one call: one, or with ``along_band`` those of a check along the band."""
    refused = [key for key in ("omega", "duration", "quantise", "saturate") if along_band and options.get(key)]
    if along_band and (refused or options.get("kind") not in (None, "sine")):
        raise SceneError(f"--check chooses motion and time itself: leave out --{(refused or ['motion'])[0]}")
    with _Progress() as progress:
        if along_band:
            return check(scene, amplitude=options.get("amplitude"), progress=progress.show)
        made = motion(scene, options)
        return (
            simulate(scene, made, duration=options.get("duration"), extras=_extras(options), progress=progress.show),
        )


def motion(scene: Scene, options: Mapping[str, str | None]) -> Motion:
    """The motion that the options describe; what they leave out follows from the scene."""
    kind, top = options.get("kind") or "sine", float(scene.band[1])
    amplitude = options.get("amplitude") or default_amplitude(scene)
    highest = positive("omega", options["omega"], Dimension.FREQUENCY) if options.get("omega") else None
    if kind == "sine":
        return sine(amplitude, highest or top / 3)
    if kind == "multisine":
        shares = [omega / top for omega in band_frequencies(scene, 10)]
        return multisine(amplitude, [share * (highest or top) for share in shares])
    if kind == "chirp":
        high = highest or top
        return chirp(amplitude, high / 20, high, options.get("duration") or 200 * pi / high)
    if not kind.lower().endswith(".csv"):
        raise SceneError(f'--motion: "{kind}" is none of sine, multisine, chirp, nor a file that ends in .csv')
    if options.get("amplitude") or options.get("omega"):
        raise SceneError(
            "--motion: a recording has its own amplitude and frequencies; leave out --amplitude and --omega"
        )
    return recording(kind)


def _extras(options: Mapping[str, str | None]) -> tuple[Extra, ...]:
    resolution, limit = options.get("quantise"), options.get("saturate")
    extras: list[Extra] = []
    if resolution:
        extras.append(EncoderQuantisation(resolution))
    if limit:
        extras.append(ForceSaturation(limit))
    return tuple(extras)


class _Progress:
    """A bar on standard error, once a run takes long, and only on a terminal."""

    def __init__(self) -> None:
        self.began = monotonic()
        self.bar: Progress | None = None

    def __enter__(self) -> _Progress:
        return self

    def __exit__(self, *_: object) -> None:
        if self.bar is not None:
            self.bar.stop()

    def show(self, time: float, until: float) -> None:
        if monotonic() - self.began < _PATIENCE or not sys.stderr.isatty():
            return
        if self.bar is None:
            columns = (BarColumn(), TextColumn("{task.completed:.3g} of {task.total:.3g} s simulated"))
            self.bar = Progress(*columns, console=Console(stderr=True), transient=True)
            self.bar.start()
            self.bar.add_task("")
        self.bar.update(self.bar.task_ids[0], completed=time, total=until)
