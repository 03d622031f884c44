"""The verb ``haptisym sensitivity``."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from haptisym.options import json_option
from haptisym.scenefile import load_scene


@click.command()
@click.argument("scene")
@json_option
@click.option(
    "--digits", type=click.IntRange(1, 1000), default=15, show_default=True, help="Correct decimal digits in --json."
)
@click.option(
    "--figure",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE",
    help="Write bars of the elasticities (.svg, .pdf or .png).",
)
def sensitivity(scene: str, as_json: bool, digits: int, figure: Path | None) -> None:  # noqa: FBT001
    """Tell how each frequency moves with each parameter, exactly.

    SCENE is a scene file (TOML) or the name of a shipped scene.

    For every crossing, changeover and the bandwidth, and every parameter p and the threshold c: the derivative d omega/dp, in
    rad/s per unit of p, and the elasticity (p/omega) d omega/dp. Undefined, and said so, where the display only touches its
    threshold.

    \b
    Examples:
      haptisym sensitivity fu2019
      haptisym sensitivity my-device.toml --figure elasticities.pdf
      haptisym sensitivity my-device.toml --json --digits 50
    """
    from haptisym.sensitivities.answers import sensitivity as of

    found = of(load_scene(scene), digits)
    if figure is not None:
        from haptisym.sensitivities.figure import save_elasticities

        save_elasticities(found, figure)
        click.echo(f"figure written to {figure}", err=True)
    click.echo(found.to_json() if as_json else str(found), nl=as_json)
    if not found.certified:
        sys.exit(3)
