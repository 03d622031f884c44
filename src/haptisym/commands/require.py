"""The verb ``haptisym require``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from haptisym.commands.options import (
    certificate_option,
    drawn,
    figure_option,
    given,
    hand_over,
    json_option,
    limit_option,
    progress,
    proven,
    scene_argument,
    verb,
)
from haptisym.kernel.budget import limited
from haptisym.kernel.errors import SceneError
from haptisym.model.scene import Scene


@verb(
    needs=[
        ("--hand", "--that", "the hand of --that stable"),
        ("--friction", "--resolution", "Abbott and Okamura's bound 2 f_c/Delta"),
        ("--resolution", "--friction", "Abbott and Okamura's bound 2 f_c/Delta"),
    ]
)
@scene_argument
@click.option(
    "--free",
    "paths",
    multiple=True,
    required=True,
    metavar="PATH",
    help="Free parameter, by path or name; twice for a map.",
)
@click.option(
    "--range",
    "ranges",
    multiple=True,
    nargs=2,
    metavar="LO HI",
    help='Range searched, as "50 rad/s" "30 Hz"; 1e-6 to 1e6 times the value if not given.',
)
@click.option("--part", "name", type=click.Choice(["real", "imag"]), help="Require the condition of one part only.")
@click.option(
    "--that",
    multiple=True,
    type=click.Choice(["transparent", "stable", "passive"]),
    default=["transparent"],
    show_default=True,
    help="What is required; repeatable, for all of them together.",
)
@click.option("--hand", metavar="NAME", help="Hand of --that stable, of the scene or shipped.")
@click.option(
    "--jnd",
    multiple=True,
    metavar="C",
    help="Add the transparent set for this JND to a map; repeatable.",
)
@click.option("--friction", metavar="F", help="Coulomb friction of the device, for the bound 2 f_c/Delta in a map.")
@click.option("--resolution", metavar="DELTA", help="Step of the encoder, for the same bound.")
@click.option("--any-environment", is_flag=True, help="Require |G - 1| <= c, for every environment at once.")
@json_option
@figure_option("the set, or the map")
@certificate_option
@click.option(
    "--slices",
    type=click.IntRange(3, 2000),
    default=41,
    show_default=True,
    help="Largest number of exact slices of a map.",
)
@click.option("--uniform", is_flag=True, help="Space the slices of a map evenly.")
@click.option(
    "--within",
    metavar="SHARE",
    help="Estimated error of a map between slices, as a share (0.5 % if not given).",
)
@limit_option
@click.pass_context
def require(
    context: click.Context,
    /,
    *,
    scene: Scene,
    paths: tuple[str, ...],
    ranges: tuple[tuple[str, str], ...],
    name: str | None,
    as_json: bool,
    digits: int | None,
    figure: Path | None,
    certificate: Path | None,
    slices: int,
    uniform: bool,
    within: str | None,
    jnd: tuple[str, ...],
    friction: str | None,
    resolution: str | None,
    **asked: Any,
) -> None:
    """Find all values of a parameter that satisfy a requirement.

    SCENE is a scene file (TOML) or the name of a shipped scene.

    Required is that the display is transparent on its whole band, stable in a hand, or passive. The result is a proven
    union of intervals, with what limits it at each end.

    \b
    Examples:
      haptisym require fu2019 --free effects.filter.omega_n
      haptisym require fu2019 --free zeta --range 0 1 --json --digits 50
      haptisym require fu2019 --free omega_n --certificate proof.json
      haptisym require delayed-spring --free tau --any-environment
      haptisym require delayed-spring --free environment.k --range 1 1000 --that stable --hand postural-arm
      haptisym require virtual-wall --free environment.b --free environment.k --range 0 40 --range 10 4000 \\
          --that transparent --that stable --hand postural-arm --jnd 0.05 --jnd 0.2 --figure z-width.svg
      haptisym require fu2019 --free omega_n --free zeta --range 60 200 --range 0.1 1 --figure map.svg
    """
    from haptisym.model.jnd import Part
    from haptisym.verbs.require.required import require as ask

    _refuse_contradictions(context, len(paths), len(ranges))
    with progress() as told:
        asked |= {"part": Part(name) if name else None, "told": told}
        if len(paths) == 2:
            from haptisym.verbs.require.designmap import design_map

            drawn_beside: dict[str, Any] = {"jnd": jnd, "friction": friction, "resolution": resolution}
            placed: dict[str, Any] = {"slices": slices, "uniform": uniform, "within": within}
            found: Any = design_map(scene, paths, ranges, **placed, **drawn_beside, **asked)
        else:
            found = ask(scene, paths[0], *ranges, digits=digits or 15, **asked)
            with limited(None, told):
                _ = found.nearest  # which may take its time too
    drawn(found, figure)
    proven(found, certificate)
    hand_over(found, as_json=as_json)


def _refuse_contradictions(context: click.Context, free: int, ranges: int) -> None:
    """SceneError for options that do not go with so many parameters and ranges."""
    if free > 2 or (ranges and ranges != free):
        raise SceneError("--free may be given once or twice, and --range not at all or as often, in the same order")
    if given(context, "--slices") and free == 1:
        raise SceneError("--slices is about a map of two parameters: give --free twice, or leave it out")
    if given(context, "--certificate") and free == 2:
        raise SceneError("--certificate is about one parameter's values: give --free once, or leave it out")
    for option in (x for x in ("--jnd", "--friction", "--uniform", "--within") if given(context, x) and free == 1):
        raise SceneError(f"{option} is about a map of two parameters: give --free twice, or leave it out")
    if given(context, "--uniform") and given(context, "--within"):
        raise SceneError("--uniform places slices evenly, and --within where they are needed: leave out one of them")
    if free == 2 and not ranges:
        raise SceneError("a map of two parameters needs a --range for each")
