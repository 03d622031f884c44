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


@verb(apart=[("--json", "--to", "--json prints one document, and --to another output")])
@scene_argument
@click.option(
    "--to", "language", type=click.Choice(["text", "latex"]), default="text", show_default=True, help="What to write."
)
@figure_option("the measures over the band")
@click.option(
    "--absolute-stability", is_flag=True, help="Tell that a display is not absolutely stable, too: most are not."
)
@json_option
@within_limit
def metrics(
    scene: Scene,
    language: str,
    figure: Path | None,
    absolute_stability: bool,
    as_json: bool,
) -> None:
    """Compare the measures of transparency that the field uses with what a hand notices.

    SCENE is a scene file (TOML) or the name of a shipped scene.

    Each measure has its closed form, its proven numbers (frequencies in rad/s) and a verdict: transmitted over environment
    impedance and its 3 dB edges, relative distortion, Z_min, Z_max and Z_width, sensitivity, the conditions on the axis
    for passivity and absolute stability, effective stiffness, mass and damping, and the free-response tolerances of flight
    simulators.

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
