"""The verb ``haptisym sensitivity``."""

from __future__ import annotations

from pathlib import Path

from haptisym.commands.options import drawn, figure_option, hand_over, json_option, scene_argument, verb, within_limit
from haptisym.model.scene import Scene


@verb()
@scene_argument
@json_option
@figure_option("bars of the elasticities")
@within_limit
def sensitivity(scene: Scene, as_json: bool, digits: int | None, figure: Path | None) -> None:
    """Find how each frequency moves with each parameter.

    SCENE is a scene file (TOML) or the name of a shipped scene.

    For every crossing, changeover frequency and the bandwidth, and every parameter p and the threshold c: the derivative
    d omega/dp and the elasticity (p/omega) d omega/dp, proven. Undefined where a ratio is tangent to its threshold.

    \b
    Examples:
      haptisym sensitivity fu2019
      haptisym sensitivity my-device.toml --figure elasticities.pdf
      haptisym sensitivity my-device.toml --json --digits 50
    """
    from haptisym.verbs.sensitivity.entry import sensitivity as of

    found = of(scene, digits or 15, limit=None)
    drawn(found, figure)
    hand_over(found, as_json=as_json)
