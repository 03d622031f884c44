"""The verb ``haptisym identify``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from haptisym.commands.options import (
    PAGES,
    drawn,
    figure_option,
    file_option,
    json_option,
    keep,
    not_over,
    show,
    verb,
    within_limit,
)
from haptisym.kernel.errors import SceneError
from haptisym.model.catalogue import EFFECTS, ENVIRONMENTS
from haptisym.verbs.identify import entry as identification

_MISSING = ""
"""The value of an option that needs a model and was given none."""


def _need_a_model(_context: click.Context, option: click.Parameter, given: Any) -> Any:
    """What was given; SceneError with the names of all models where that is none."""
    if given == _MISSING or (isinstance(given, tuple) and _MISSING in given):
        models = EFFECTS if option.multiple else ENVIRONMENTS
        raise SceneError(f"{option.opts[0]} needs a model: valid are {', '.join(models)}")
    return given


def _no_such_option(_context: click.Context, _option: click.Parameter, given: str | None) -> None:
    """SceneError for an option by which one looks for models."""
    if given is not None:
        raise SceneError(
            "--model: what is felt is --environment MODEL, and what stands behind it --effect MODEL; or --degrees N D. "
            f"Environments are {', '.join(ENVIRONMENTS)}; effects are {', '.join(EFFECTS)}"
        )


@verb()
@click.argument("file")
@click.option(
    "--environment",
    metavar="MODEL",
    is_flag=False,
    flag_value=_MISSING,
    callback=_need_a_model,
    help="Environment model, as mass-spring-damper.",
)
@click.option(
    "--effect",
    "effects",
    multiple=True,
    metavar="MODEL",
    is_flag=False,
    flag_value=_MISSING,
    callback=_need_a_model,
    help="Effect model, nearest the environment first; repeatable.",
)
@click.option("--model", is_flag=False, flag_value=_MISSING, hidden=True, expose_value=False, callback=_no_such_option)
@click.option(
    "--degrees", nargs=2, type=int, metavar="N D", help="Degrees of numerator and denominator, in place of a model."
)
@click.option("--band", nargs=2, metavar="LOW HIGH", help='Use only this band, as "1 Hz" "20 Hz".')
@click.option("--averages", type=float, metavar="N", help="Number of averages of the column coherence.")
@click.option("--confidence", type=float, metavar="P", help="Confidence of all intervals (0.95 if not given).")
@click.option("--estimator", metavar="NAME", help="Estimator for records in time: H1, H2 or joint.")
@click.option("--segment", metavar="TIME", help='Length of Welch segments of records in time, as "4 s".')
@click.option("--title", default="", help="Title of the scene that is written.")
@json_option
@file_option("scene", "Write the fitted scene, each parameter with its range.")
@figure_option("the model over what was measured, and the residuals")
@within_limit
def identify(
    file: str,
    environment: str | None,
    effects: tuple[str, ...],
    degrees: tuple[int, int] | None,
    band: tuple[str, str] | None,
    averages: float | None,
    confidence: float | None,
    estimator: str | None,
    segment: str | None,
    title: str,
    as_json: bool,
    scene: Path | None,
    figure: Path | None,
) -> None:
    """Fit a model to a measured response.

    FILE holds frequency points, or with --estimator records in time (CSV); or it is a scene with [perceived] (TOML), whose
    environment is known and whose effects are fitted.

    MODEL is a model of the catalogue. After a colon follow the parameters that it has, where some are optional, and given
    values: shunt:m,b or second-order-lowpass:zeta=0.5.

    Weighted least squares. Estimated: parameters with confidence intervals, and a test whether the model fits.

    \b
    Examples:
      haptisym identify device.csv --averages 20 --environment mass-spring-damper --effect delay
      haptisym identify device.csv --degrees 2 2 --effect delay --figure fit.svg
      haptisym identify bench.toml --effect second-order-lowpass --scene device.toml
      haptisym identify records.csv --estimator H1 --segment "4 s" --environment mass-spring-damper
      haptisym identify device.csv --environment kelvin-voigt --effect shunt:m --band "1 Hz" "20 Hz"
    """
    records = {key: x for key, x in (("estimator", estimator), ("segment", segment)) if x is not None}
    given = identification.opened(file, averages, confidence, **records)
    outputs = {"scene": scene, "figure": figure, **click.get_current_context().meta[PAGES]}
    not_over(given.files, outputs)
    found = identification.identify(given, environment, effects, degrees=degrees, band=band, title=title, limit=None)
    if scene is not None:
        keep("scene", scene, lambda: scene.write_text(found.text, encoding="utf-8"))
    drawn(found, figure)
    show(found, as_json=as_json)
