"""``haptisym metrics``: what other measures of transparency say of a scene, beside the JND verdict."""

from __future__ import annotations

from pathlib import Path

import click

from haptisym.commands.options import (
    drawn,
    end,
    figure_option,
    json_option,
    keep_pages,
    scene_argument,
    show,
    verb,
    within_limit,
    write,
)
from haptisym.model.scene import Scene


@verb(formulas="--all", apart=[("--json", "--to", "--json prints one document, and --to another output")])
@scene_argument
@click.option(
    "--to",
    "language",
    type=click.Choice(["text", "latex"]),
    default="text",
    show_default=True,
    help="Language of the output.",
)
@figure_option("the measures over the band")
@click.option("--absolute-stability", is_flag=True, help="Print absolute stability even where it does not hold.")
@json_option
@within_limit
def metrics(
    scene: Scene,
    language: str,
    figure: Path | None,
    absolute_stability: bool,
    as_json: bool,
) -> None:
    """Compare the JND with other measures of transparency.

    SCENE is a scene file (TOML) or the name of a shipped scene.

    Transmitted over environment impedance and its 3 dB edges, relative distortion, Z_min, Z_max and Z_width, sensitivity,
    passivity and absolute stability, effective stiffness, mass and damping, and the free-response tolerances of flight
    simulators; --all prints formulas and values of each.

    \b
    Examples:
      haptisym metrics fu2019
      haptisym metrics steering-wheel --figure metrics.svg
      haptisym metrics fu2019 --to latex > metrics.tex
    """
    from haptisym.verbs.metrics.entry import metrics as measure

    found = measure(scene, absolute_stability=absolute_stability, limit=None)
    drawn(found, figure)
    if language == "latex":
        from haptisym.writing.latex import piece

        keep_pages(found.document, found.to_json)
        write(piece(found.document()) + "\n")
    else:
        show(found, as_json=as_json)
    end(found)
