"""The verb ``haptisym simulate``: a scene in time."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path

import click

from haptisym.commands.options import (
    figures_option,
    file_option,
    json_option,
    keep,
    keep_figures,
    progress,
    scene_argument,
    show,
    verb,
    within_limit,
)
from haptisym.model.scene import Scene

_MOVED = ("--motion", "--amplitude", "--omega", "--check", "--quantise", "--saturate", "--lowpass")


@verb(
    apart=[
        ("--check", "--motion", "--check chooses the motion itself"),
        ("--check", "--force", "--check compares frequencies, --force writes one run in time"),
        *(("--release", x, f"--release lets the hand go, {x} is about a hand that moves") for x in _MOVED),
    ],
    needs=[("--lowpass-order", "--lowpass", "the low-pass"), ("--hand", "--release", "a hand that lets go")],
)
@scene_argument
@json_option
@click.option(
    "--motion",
    "kind",
    metavar="sine|multisine|chirp|FILE.csv",
    default="sine",
    show_default=True,
    help="Motion of the hand.",
)
@click.option("--amplitude", metavar="LENGTH", help='Amplitude of the motion, as "5 cm" or "3 deg".')
@click.option("--omega", metavar="FREQUENCY", help='Frequency of a sine, or the highest; as "2 Hz".')
@click.option("--duration", metavar="TIME", help='Simulated time, as "20 s".')
@click.option("--release", metavar="LENGTH", help="Release test: hold displaced by LENGTH, then let go.")
@click.option("--hand", metavar="NAME", help="Hand of the release test, of the scene or shipped.")
@click.option("--check", is_flag=True, help="Compare with the closed form at ten frequencies.")
@click.option("--quantise", metavar="LENGTH", help='Resolution of the position encoder, as "0.1 mm".')
@click.option("--saturate", metavar="FORCE", help='Largest force that can be rendered, as "5 N".')
@click.option("--lowpass", metavar="FREQUENCY", help='Smooth a recorded motion (zero phase), as "20 Hz".')
@click.option(
    "--lowpass-order",
    metavar="ORDER",
    type=click.Choice(["2", "4", "6", "8"]),
    help="Order of the low-pass filter (4 if not given).",
)
@file_option("force", "Write the force in time, with the motion, as CSV.")
@figures_option
@within_limit
def simulate(
    scene: Scene, as_json: bool, check: bool, figures: Path | None, force: Path | None, **options: str | None
) -> None:
    """Simulate a scene in time, and compare with the closed form.

    The force at the hand follows from the equations of motion of the elements of the scene (delay lines, sampling, sliding
    friction), not from the closed form; a lock-in recovers Re and Im of H_perc. With --release the hand holds the display
    displaced and lets go: does it shake, at which rate and frequency?

    \b
    Examples:
      haptisym simulate fu2019 --omega "10 rad/s"
      haptisym simulate sampled-wall --check
      haptisym simulate stick-with-friction --amplitude "5 cm" --figures figures
      haptisym simulate delayed-spring --release "1 cm" --hand light-touch
      haptisym simulate fu2019 --motion hand.csv --lowpass "20 Hz" --force force.csv
    """
    if options.get("release"):
        _let_go(scene, options, as_json, figures, force)
        return
    from haptisym.verbs.simulate.entry import run  # SciPy is loaded for this verb alone

    with progress("s simulated") as told:
        runs = run(scene, check, options, told)
    if force is not None:
        keep("force", force, lambda: force.write_text(runs[0].to_csv(), encoding="utf-8"))
    if figures is not None:
        from haptisym.figures.sheet import save_figures

        keep_figures(figures, lambda: save_figures(runs, figures))
    show(runs, as_json=as_json)
    if runs.agrees is False:
        sys.exit(3)


def _let_go(
    scene: Scene,
    options: Mapping[str, str | None],
    as_json: bool,
    figures: Path | None,
    force: Path | None,
) -> None:
    """The hand holds the display displaced, and lets go."""
    from haptisym.verbs.simulate.release import release

    with progress("s simulated") as told:
        found = release(
            scene,
            str(options["release"]),
            options.get("hand"),
            duration=options.get("duration"),
            progress=told,
            limit=None,
        )
    if force is not None:
        keep("force", force, lambda: force.write_text(found.to_csv(), encoding="utf-8"))
    if figures is not None:
        from haptisym.figures.sheet import save_figures

        keep_figures(figures, lambda: save_figures(found, figures))
    show(found, as_json=as_json)
    if found.agrees is False or found.sign_agrees is False:
        sys.exit(3)
