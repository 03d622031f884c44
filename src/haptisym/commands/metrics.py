"""``haptisym metrics``: what other measures of transparency say of a scene, beside the JND verdict."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from haptisym.options import environment_option, json_option


@click.command()
@click.argument("scene")
@environment_option
@click.option(
    "--to", "language", type=click.Choice(["text", "latex"]), default="text", show_default=True, help="What to write."
)
@click.option(
    "--figure",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE",
    help="Draw the measures over the band (.svg, .pdf or .png).",
)
@json_option
def metrics(
    scene: str,
    environment: str | None,
    language: str,
    figure: Path | None,
    as_json: bool,  # noqa: FBT001 - a flag of the command line
) -> None:
    """Compare the measures of transparency that the field uses with what a hand notices.

    SCENE is a scene file (TOML) or the name of a shipped scene.

    Each measure has its closed form, its proven numbers (frequencies in rad/s) and a verdict: transmitted over environment
    impedance and its 3 dB edges, relative distortion, Z_min, Z_max and Z_width, sensitivity, passivity and absolute
    stability, effective stiffness, mass and damping, and the free-response tolerances of flight simulators.

    \b
    Examples:
      haptisym metrics fu2019
      haptisym metrics steering-wheel --figure metrics.svg
      haptisym metrics fu2019 --to latex > metrics.tex
    """
    from haptisym.measures import text as metricstext
    from haptisym.measures.transparency import metrics as measure
    from haptisym.scenefile import load_scene

    found = measure(load_scene(scene, environment))
    if figure is not None:
        from haptisym.measures.figure import save_metrics_figure

        save_metrics_figure(found, figure)
        click.echo(f"figure written to {figure}", err=True)
    write = metricstext.as_json if as_json else metricstext.as_latex if language == "latex" else metricstext.as_text
    click.echo(write(found), nl=as_json)
    if not found.measured.certified:
        sys.exit(3)
