"""``haptisym cost SCENE``: what accuracy costs in time."""

from __future__ import annotations

from pathlib import Path

import click

from haptisym.commands.options import (
    drawn,
    environment_option,
    figure_option,
    json_option,
    progress,
    show,
    verb,
)
from haptisym.judge.answers import Answer
from haptisym.kernel.errors import SceneError
from haptisym.model.scenefile import load_scene


@verb()
@click.argument("scene", required=False)
@environment_option
@json_option
@figure_option("digits against time")
@click.option("--quick", is_flag=True, help="Fewer methods and repeats, for a first look.")
@click.option("--hard-cases", is_flag=True, help="Measure cases on which usual methods fail, instead of a scene.")
def cost(
    scene: str | None,
    environment: str | None,
    as_json: bool,
    figure: Path | None,
    quick: bool,
    hard_cases: bool,
) -> None:
    """Measure what accuracy costs in time, for a scene or on hard cases.

    SCENE is a scene file (TOML) or the name of a shipped scene.

    Correct digits and time, measured against proven references of higher precision: of the ratios in floats and to
    many digits, of the crossings by grids, eigenvalues and proof, of Pade approximants for delays, and of each effect
    left out.

    \b
    Examples:
      haptisym cost fu2019
      haptisym cost my-device.toml --quick --figure cost.png
      haptisym cost --hard-cases --json
    """
    if hard_cases and (scene or quick or environment):
        raise SceneError("--hard-cases brings its own scenes: leave out SCENE, --environment and --quick")
    if scene is None and not hard_cases:
        raise SceneError("cost: name a SCENE, or ask for --hard-cases")
    from haptisym.verbs.cost.entry import cost as of_scene
    from haptisym.verbs.cost.hardcosts import hard_costs

    with progress() as told:

        def said(what: str, share: float) -> None:
            told(share, 1.0, what)

        if scene is None:
            found: Answer = hard_costs(told=said)
        else:
            found = of_scene(load_scene(scene, environment), quick=quick, told=said)
    drawn(found, figure)
    show(found, as_json=as_json)
