"""``haptisym jnd DATA``: the just-noticeable difference from a person's answers."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import click
from click.core import ParameterSource

from haptisym.commands.options import drawn, figure_option, json_option, show, verb
from haptisym.kernel.errors import SceneError
from haptisym.model.quantities import decimal


class _Number(click.ParamType[object]):
    """A decimal number, or one of some words."""

    name = "number"

    def __init__(self, *words: str) -> None:
        self.words = words

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> object:
        try:
            return value if isinstance(value, float) or value in self.words else float(decimal(str(value)))
        except SceneError as error:
            raise error.within(param.opts[-1] if param else "number") from None


@verb()
@click.argument("data", required=False)
@click.option("--published", is_flag=True, help="List published thresholds that a scene can use by name.")
@click.option(
    "--proportion",
    type=_Number(),
    metavar="P",
    help="Proportion of responses that defines the JND (0.75 if not given).",
)
@click.option(
    "--alternatives", type=int, metavar="M", help="Forced choice between M alternatives; levels are differences."
)
@click.option(
    "--reference", type=_Number(), metavar="X", help="Level of the standard, for the JND as a fraction of it."
)
@click.option("--guess", type=_Number(), default=0.0, metavar="G", help="Guess rate (0 if not given).")
@click.option("--lapse", type=_Number("free"), default=0.0, metavar="L", help='Lapse rate, or "free" (0 if not given).')
@click.option(
    "--confidence", type=_Number(), default=0.95, metavar="C", help="Confidence of the interval (0.95 if not given)."
)
@click.option(
    "--method",
    type=click.Choice(["likelihood", "psignifit"]),
    default="likelihood",
    show_default=True,
    help="Method of the fit.",
)
@click.option("--level", metavar="COLUMN", help="Column of the levels.")
@click.option("--count", metavar="COLUMN", help="Column of the counted responses, k.")
@click.option("--trials", metavar="COLUMN", help="Column of all responses, n.")
@click.option("--answer", metavar="COLUMN", help="Column of single responses, 1 or 0.")
@click.option("--where", multiple=True, metavar="COLUMN=VALUE", help="Use only rows with this value; repeatable.")
@figure_option("answers and curve")
@json_option
def jnd(
    data: str | None,
    published: bool,
    proportion: float | None,
    alternatives: int | None,
    reference: float | None,
    guess: float,
    lapse: float | str,
    confidence: float,
    method: str,
    level: str | None,
    count: str | None,
    trials: str | None,
    answer: str | None,
    where: tuple[str, ...],
    figure: Path | None,
    as_json: bool,
) -> None:
    """Fit a psychometric function to responses: the JND.

    DATA is a table (CSV) with a row for each level (level, k of n responses; as quickpsy and Palamedes write it) or for
    each trial (level, response; as PsychoPy writes it, staircases too), or a result of psignifit 4 (JSON).

    Without --alternatives responses are "more" or "less" than the standard: the JND is the distance from the point of
    subjective equality. With it they are correct or not, and the JND is the level itself.

    \b
    Examples:
      haptisym jnd answers.csv --reference 5
      haptisym jnd answers.csv --reference 5 --proportion 0.84 --figure answers.svg
      haptisym jnd staircase.csv --alternatives 2 --reference 1 --where participant=07
      haptisym jnd psignifit.json --method psignifit --json
      haptisym jnd --published
    """
    if published:
        _list(data, as_json)
        return
    if data is None:
        raise SceneError("jnd: name a file of answers as DATA, or ask for --published")
    from haptisym.verbs.jnd.entry import jnd as measure

    named = {"level": level, "count": count, "trials": trials, "answer": answer}
    found = measure(
        data, proportion=proportion, alternatives=alternatives, guess=guess, lapse=None if isinstance(lapse, str) else lapse,
        reference=reference, confidence=confidence, method=method, where=_pairs(where),
        columns={key: x for key, x in named.items() if x is not None},
    )  # fmt: skip
    drawn(found, figure)
    show(found, as_json=as_json)


def _list(data: str | None, as_json: bool) -> None:
    """What is published."""
    given = [
        x.name for x in click.get_current_context().command.params if x.name not in ("published", "as_json", *_PAGES)
    ]
    asked = [name for name in given if name and _is_given(name)]
    if data is not None or asked:
        raise SceneError("--published lists what others measured: leave out DATA and what is about it")
    from haptisym.verbs.jnd.entry import published

    show(published(), as_json=as_json)


_PAGES = ("latex", "report")


def _is_given(name: str) -> bool:
    return click.get_current_context().get_parameter_source(name) is ParameterSource.COMMANDLINE


def _pairs(given: Iterable[str]) -> dict[str, str]:
    found: dict[str, str] = {}
    for one in given:
        column, sign, value = one.partition("=")
        if not sign or not column:
            raise SceneError(f'--where "{one[:60]}": write it as COLUMN=VALUE')
        if column in found:
            raise SceneError(f"--where {column} is given twice: lines have one value in a column")
        found[column] = value
    return found
