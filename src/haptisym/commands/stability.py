"""The verb ``haptisym stability``."""

from __future__ import annotations

from pathlib import Path

import click

from haptisym.commands.options import (
    certificate_option,
    drawn,
    figure_option,
    hand_over,
    json_option,
    proven,
    scene_argument,
    verb,
    within_limit,
)
from haptisym.model.scene import Scene


@verb()
@scene_argument
@click.option(
    "--hand",
    "names",
    multiple=True,
    metavar="NAME",
    help="A hand of the scene, or one that the package ships; may be repeated. Those of the scene if not given.",
)
@click.option(
    "--free",
    "paths",
    multiple=True,
    metavar="PATH",
    help="A number, as environment.k or its symbol, of which it is told how far it may go; may be repeated.",
)
@figure_option("the hand's plane: where the display is stable")
@json_option
@certificate_option
@within_limit
def stability(
    scene: Scene,
    names: tuple[str, ...],
    paths: tuple[str, ...],
    *,
    figure: Path | None,
    as_json: bool,
    digits: int | None,
    certificate: Path | None,
) -> None:
    """Tell whether a display shakes: imposed, held, in every passive hand.

    SCENE is a scene file (TOML) or the name of a shipped scene.

    Three statements, each proven apart. Imposed: the force under imposed motion is stable. Held: the display is stable in this
    hand, a mass, damping and stiffness of [hand] in the scene or a published one. Every passive hand: no hand that only takes
    energy can make it shake.

    \b
    Examples:
      haptisym stability delayed-spring --hand light-touch
      haptisym stability fu2019 --hand postural-arm --hand firm-grip
      haptisym stability delayed-spring --hand postural-arm --free environment.k --free tau
      haptisym stability delayed-spring --hand postural-arm --figure plane.svg
      haptisym stability my-device.toml --json --digits 50
      haptisym stability fu2019 --hand firm-grip --certificate proof.json
    """
    from haptisym.verbs.stability.entry import stability as of

    found = of(scene, names or None, paths, digits=digits or 15, limit=None)
    drawn(found, figure)
    proven(found, certificate)
    hand_over(found, as_json=as_json)
