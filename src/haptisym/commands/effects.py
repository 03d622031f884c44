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
    help="Largest change of r_r and r_i that leaving out effects may make.",
)
@figure_option("the influences along the band")
@within_limit
def effects(scene: Scene, as_json: bool, tolerance: str, figure: Path | None) -> None:
    """Find which effects of a scene matter, with proof.

    SCENE is a scene file (TOML) or the name of a shipped scene.

    Of each effect: the largest change of r_r and r_i anywhere on the band if it is left out. Of all together: the fewest
    effects with which both ratios stay within the tolerance of the full scene's, what that changes at most, how much shorter
    the formulas get, and intervals that hold all crossings of the full scene. Ratios are fractions of |H_env|, frequencies
    in rad/s.

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
