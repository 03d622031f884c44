"""``haptisym effects``: which effects of a scene matter."""

from __future__ import annotations

from pathlib import Path

import click

from haptisym.commands.options import drawn, figure_option, hand_over, json_option, scene_argument, verb, within_limit
from haptisym.model.scene import Scene


@verb()
@scene_argument
@json_option
@click.option(
    "--tolerance",
    metavar="X",
    default="0.01",
    show_default=True,
    help="Allowed change of r_r and r_i by leaving out effects.",
)
@figure_option("the influences along the band")
@within_limit
def effects(scene: Scene, as_json: bool, tolerance: str, figure: Path | None) -> None:
    """Find which effects of a scene matter.

    SCENE is a scene file (TOML) or the name of a shipped scene.

    Prints, proven, the largest change of r_r and r_i on the band without each effect, the smallest set of effects with
    which both ratios stay within the tolerance, and intervals that hold all crossings of the full scene.

    \b
    Examples:
      haptisym effects control-stick-in-detail
      haptisym effects sidestick --tolerance 0.1 --figure influences.pdf
      haptisym effects my-device.toml --json
    """
    from haptisym.verbs.effects.relevance import relevance

    found = relevance(scene, tolerance, limit=None)
    drawn(found, figure)
    hand_over(found, as_json=as_json)
