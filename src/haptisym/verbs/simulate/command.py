"""What ``haptisym simulate`` asks for, as simulations."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import pi

from haptisym.kernel.errors import SceneError
from haptisym.model.quantities import Dimension
from haptisym.model.scene import Scene
from haptisym.verbs.simulate.entry import band_frequencies, check, default_amplitude, simulate
from haptisym.verbs.simulate.motions import Motion, chirp, multisine, positive, recording, sine
from haptisym.verbs.simulate.results import EncoderQuantisation, Extra, ForceSaturation, Simulations


def run(
    scene: Scene,
    along_band: bool,  # noqa: FBT001
    options: Mapping[str, str | None],
    progress: Callable[[float, float], None] | None = None,
) -> Simulations:
    """The runs of one call: one, or with ``along_band`` those of a check along the band. ``progress`` as in ``simulate``."""
    refused = [
        key for key in ("omega", "duration", "quantise", "saturate", "lowpass") if along_band and options.get(key)
    ]
    if along_band and (refused or options.get("kind") not in (None, "sine")):
        raise SceneError(f"--check chooses motion and time itself: leave out --{(refused or ['motion'])[0]}")
    if along_band:
        return check(scene, amplitude=options.get("amplitude"), progress=progress, limit=None)
    made = motion(scene, options)
    found = simulate(
        scene, made, duration=options.get("duration"), extras=_extras(options), progress=progress, limit=None
    )
    return Simulations([found])


def motion(scene: Scene, options: Mapping[str, str | None]) -> Motion:
    """The motion that the options describe; what they leave out follows from the scene."""
    kind, top = options.get("kind") or "sine", float(scene.band[1])
    if options.get("lowpass") and not kind.lower().endswith(".csv"):
        raise SceneError("--lowpass smooths a recorded motion: give one with --motion FILE.csv")
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
    return recording(kind, lowpass=options.get("lowpass"), order=int(options.get("lowpass_order") or 4))


def _extras(options: Mapping[str, str | None]) -> tuple[Extra, ...]:
    resolution, limit = options.get("quantise"), options.get("saturate")
    extras: list[Extra] = []
    if resolution:
        extras.append(EncoderQuantisation(resolution))
    if limit:
        extras.append(ForceSaturation(limit))
    return tuple(extras)
