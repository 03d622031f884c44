"""``haptisym cost SCENE``: what accuracy costs in time."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import click

from haptisym.commands.options import (
    drawn,
    environment_option,
    figure_option,
    given,
    json_option,
    limit_option,
    progress,
    show,
    verb,
)
from haptisym.judge.answers import Answer
from haptisym.kernel.errors import SceneError
from haptisym.model.scene import Scene
from haptisym.model.scenefile import load_scene


@verb()
@click.argument("scene", required=False)
@environment_option
@json_option
@figure_option("digits against time")
@click.option("--quick", is_flag=True, help="Fewer methods and repeats, for a first look.")
@click.option("--simulation", is_flag=True, help="Measure the simulation in time instead.")
@click.option("--sweep", is_flag=True, help="Measure a sweep instead.")
@click.option("--free", multiple=True, metavar="PATH", help="Parameter to vary with --sweep (all if not given).")
@limit_option
@click.option("--hard-cases", is_flag=True, help="Measure cases on which usual methods fail, instead of a scene.")
def cost(
    scene: str | None,
    environment: str | None,
    as_json: bool,
    figure: Path | None,
    quick: bool,
    simulation: bool,
    sweep: bool,
    free: tuple[str, ...],
    limit: float,
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
      haptisym cost fu2019 --simulation
      haptisym cost fu2019 --sweep --free omega_n --free m
      haptisym cost --hard-cases --json
    """
    if hard_cases and (scene or quick or simulation or sweep or environment):
        raise SceneError(
            "--hard-cases brings its own scenes: leave out SCENE, --environment, --quick, --simulation and --sweep"
        )
    if free and not sweep:
        raise SceneError("--free: tells what varies in a sweep: add --sweep")
    if not sweep and given(click.get_current_context(), "--limit"):
        raise SceneError(
            "--limit: of what is measured a sweep alone can be cut short: add --sweep, or ask for less with --quick"
        )
    if sweep and simulation:
        raise SceneError("--sweep and --simulation are two questions: ask one of them")
    if scene is None and not hard_cases:
        raise SceneError("cost: name a SCENE, or ask for --hard-cases")
    with progress() as told:
        found = _measured(
            load_scene(scene, environment) if scene else None,
            quick,
            simulation,
            (free, limit) if sweep else None,
            lambda what, share: told(share, 1.0, what),
        )
    drawn(found, figure)
    show(found, as_json=as_json)


def _measured(
    scene: Scene | None,
    quick: bool,
    simulation: bool,
    swept: tuple[tuple[str, ...], float] | None,
    told: Callable[[str, float], None],
) -> Answer:
    if scene is None:
        from haptisym.verbs.cost.hardcosts import hard_costs

        return hard_costs(told=told)
    from haptisym.verbs.cost.entry import cost, simulation_cost, sweep_cost

    if swept is not None:
        free, limit = swept
        return sweep_cost(scene, free, quick=quick, limit=limit, told=told)
    measure = simulation_cost if simulation else cost
    return measure(scene, quick=quick, told=told)
