"""The verb ``haptisym stability``."""

from __future__ import annotations

import sys
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
    help="Hand of the scene, or a shipped one; repeatable.",
)
@click.option(
    "--free",
    "paths",
    multiple=True,
    metavar="PATH",
    help="Parameter whose stability limits are searched; repeatable.",
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
    """Find whether a display shakes, and its stability limits.

    SCENE is a scene file (TOML) or the name of a shipped scene.

    Three statements, each proven by itself: stable in a hand (mass, damping and stiffness, of [hand] in the scene or a
    shipped one); stable under prescribed motion; passive, that is stable in the hand of any passive operator.

    Exit status 2 where a figure was asked for that cannot be drawn; the answer is printed all the same.

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
    is_drawn = drawn(found, figure)
    proven(found, certificate)
    hand_over(found, as_json=as_json)
    if not is_drawn:
        sys.exit(2)
