"""The verb ``haptisym tolerances``."""

from __future__ import annotations

from pathlib import Path

import click

from haptisym.commands.options import (
    drawn,
    figure_option,
    given,
    hand_over,
    json_option,
    limit_option,
    progress,
    scene_argument,
    verb,
)
from haptisym.kernel.errors import SceneError
from haptisym.model.scene import Scene


@verb()
@scene_argument
@json_option
@click.option(
    "--samples",
    type=click.IntRange(0, 100_000),
    default=200,
    show_default=True,
    help="Number of random sets for the estimates.",
)
@click.option("--seed", type=int, default=2019, show_default=True, help="Seed of the random sets.")
@click.option(
    "--hand",
    "names",
    multiple=True,
    metavar="NAME",
    help="Test stability in this hand, for all values; repeatable.",
)
@figure_option("enclosures and samples, with a hand the plane of hands below them")
@limit_option
def tolerances(
    scene: Scene, as_json: bool, samples: int, seed: int, names: tuple[str, ...], figure: Path | None, limit: float
) -> None:
    """Find what holds for all values in given ranges.

    SCENE is a scene file (TOML) or the name of a shipped scene; a parameter in it may be written "1.8 kg +- 5 %",
    "1.8 kg +- 0.1 kg" or ["1.7 kg", "1.9 kg"], the threshold likewise.

    Proven by branch and bound: whether the display is transparent for all values, for none or for some; where each
    crossing lies; with --hand, whether it is stable for all values, for none or for some. Estimated: quantiles over random
    values. Exit status 3 where a verdict is undecided within the limit.

    \b
    Examples:
      haptisym tolerances fu2019-tolerances
      haptisym tolerances my-device.toml --samples 1000 --figure tolerances.pdf
      haptisym tolerances fu2019-tolerances --hand light-touch
      haptisym tolerances my-device.toml --json
    """
    from haptisym.verbs.tolerances.proofs import tolerances as of

    if samples == 0 and given(click.get_current_context(), "--seed"):
        raise SceneError(
            "--seed is about the random numbers of the estimates, and --samples 0 draws none: leave out one of them"
        )

    with progress() as told:
        found = of(scene, samples, seed, hand=names or None, limit=limit, told=told)
    drawn(found, figure)
    hand_over(found, as_json=as_json)
