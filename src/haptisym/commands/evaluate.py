"""The verb ``haptisym evaluate``: when a display is noticed, and how it is felt."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from haptisym.commands.options import (
    PAGES,
    certificate_option,
    environment_option,
    figures_option,
    file_option,
    given,
    hand_over,
    json_option,
    keep,
    keep_figures,
    limit_option,
    not_over,
    progress,
    show,
    verb,
)
from haptisym.judge.evaluation import Evaluation
from haptisym.kernel.budget import limited
from haptisym.kernel.errors import SceneError
from haptisym.model.measuredscene import MeasuredScene
from haptisym.model.scenefile import SceneFamily, chosen, felt_through, open_scenes
from haptisym.verbs.evaluate.entry import evaluate as evaluate_scene


@verb(needs=[("--points", "--response", "the lines of a file")], formulas="--formulas")
@click.argument("scene")
@click.argument("more", nargs=-1, metavar="")
@json_option
@environment_option
@click.option(
    "--environments",
    multiple=True,
    metavar="FILE...",
    help="Use the environments of these scenes instead.",
)
@click.option("--tolerance", metavar="X", help="Leave out effects that together change the ratios by at most X.")
@click.option("--regions", is_flag=True, help="Compare with square, disc and diamond of the same half widths.")
@click.option("--proportion", metavar="P", help="Convert the JND to this proportion of correct answers, as 0.84.")
@figures_option
@file_option("response", "Write the exact response, sampled on the band, as a CSV file that [perceived] reads.")
@click.option(
    "--points",
    type=click.IntRange(2, 1_000_000),
    default=200,
    show_default=True,
    help="Number of frequency points of --response.",
)
@certificate_option
@limit_option
def evaluate(
    scene: str,
    more: tuple[str, ...],
    as_json: bool,
    environment: str | None,
    environments: tuple[str, ...],
    digits: int | None,
    tolerance: str | None,
    regions: bool,
    proportion: str | None,
    figures: Path | None,
    response: Path | None,
    points: int,
    certificate: Path | None,
    limit: float,
) -> None:
    """Find when a hand notices a display, and as what.

    SCENE is a scene file (TOML) or the name of a shipped scene.

    Step 1: every frequency of the band at which r_r = |Re dH|/|H_env| or r_i = |Im dH|/|H_env| crosses the JND. Step 2:
    the mechanical property that changes there (stiffness, damping, mass). All crossings are proven.

    A scene with several environments ([[environments]], or --environments after SCENE) gives a row for each, and the band
    on which the display is transparent with all of them.

    \b
    Examples:
      haptisym evaluate fu2019
      haptisym evaluate palpation-device
      haptisym evaluate palpation-device --environment liver
      haptisym evaluate fu2019 --environments fu2019 helicopter-cyclic my-stick.toml
      haptisym evaluate fu2019 --figures figures --latex fu2019.tex
      haptisym evaluate fu2019 --report fu2019.html
      haptisym evaluate fu2019 --regions
      haptisym evaluate palpation-device --regions
      haptisym evaluate my-device.toml --proportion 0.84
      haptisym evaluate my-device.toml --certificate my-device.proof.json
      haptisym evaluate fu2019 --response fu2019.csv --points 60
      haptisym evaluate my-device.toml --json --digits 50
      haptisym evaluate control-stick-in-detail --tolerance 0.01
      haptisym evaluate fu2019-bench            a simulated bench run
      haptisym evaluate bench.toml              a scene with [perceived] from a file
    """
    if more and not environments:
        raise click.UsageError(f"got an unexpected argument ({more[0]})")
    opened, _ = open_scenes(scene)
    if isinstance(opened, MeasuredScene):
        _evaluate_measured(opened, figures, as_json)
        return
    family = felt_through(opened, scene, (*environments, *more))
    if environment is None and (environments or len(family) > 1):
        _of_one_environment()
        _evaluate_all(family, digits or 15, regions, proportion, limit, figures, as_json)
        return
    one = family[str(environment)] if environments else chosen(family, Path(scene).name, environment)
    with progress() as told, limited(limit, told):
        asked: dict[str, Any] = {"tolerance": tolerance, "regions": regions, "proportion": proportion}
        result = evaluate_scene(one, digits or 15, limit=None, **asked)
        _ = result.bandwidths  # of a range of thresholds: within the limit
        proof = result.certificate() if certificate else ""
    if certificate is not None:
        keep("certificate", certificate, lambda: certificate.write_text(proof, encoding="utf-8"))
    if response is not None:
        _keep_response(result, response, points)
    if figures is not None:
        _keep_figures(result, figures)
    hand_over(result, as_json=as_json)


def _of_one_environment() -> None:
    """Refuse what several environments at once are not asked."""
    for option in ("--tolerance", "--certificate", "--response"):
        if given(click.get_current_context(), option):
            raise SceneError(f"{option} takes one environment: choose it with --environment NAME")


def _keep_response(result: Evaluation, file: Path, points: int) -> None:
    """The exact response as a table."""
    from haptisym.model.measuring import write_sampled

    keep("response", file, lambda: write_sampled(result.given, file, points))


def _keep_figures(result: Evaluation, directory: Path) -> None:
    """The figures of one environment."""
    from haptisym.figures.sheet import save_figures

    keep_figures(directory, lambda: save_figures(result, directory))


_ABOUT_FORMULAS = (
    "--environments", "--environment", "--digits", "--tolerance", "--certificate", "--regions", "--proportion", "--response",
    "--points", "--limit",
)  # fmt: skip


def _evaluate_measured(scene: MeasuredScene, figures: Path | None, as_json: bool) -> None:
    """Measured lines."""
    from haptisym.verbs.measured.entry import judge

    context = click.get_current_context()
    for option in _ABOUT_FORMULAS:
        if given(context, option):
            raise SceneError(f"{option} is about scenes of formulas, and this one is measured: leave it out")
    not_over(scene.files, context.meta[PAGES])
    result = judge(scene)
    if figures is not None:
        from haptisym.figures.sheet import save_figures

        keep_figures(figures, lambda: save_figures(result, figures))
    show(result, as_json=as_json)


def _evaluate_all(
    family: SceneFamily,
    digits: int,
    regions: bool,
    proportion: str | None,
    limit: float,
    figures: Path | None,
    as_json: bool,
) -> None:
    """Several environments at once."""
    from haptisym.verbs.family.entry import evaluate_all  # loaded where it is asked for

    with progress() as told, limited(limit, told):
        result = evaluate_all(family, digits, regions=regions, proportion=proportion, limit=None)
    if figures is not None:
        from haptisym.figures.sheet import save_figures

        keep_figures(figures, lambda: save_figures(result, figures))
    hand_over(result, as_json=as_json)
