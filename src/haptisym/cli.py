"""The command line: ``haptisym evaluate SCENE`` and its sisters.

What only some calls need (Rich for text, matplotlib for figures, the LaTeX printer) is imported where it is called
for, so that ``--json`` in a loop pays for none of it.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from json import dumps
from pathlib import Path
from typing import Any

import click

from . import __version__
from .errors import HaptisymError, UndecidedError
from .evaluation import evaluate as evaluate_scene
from .scenefile import load_scene, scene_names


class _Sisters(click.Group):
    """The group of verbs; a bare call prints the help."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(self.commands)  # in the order of the code, the main job first


@click.group(cls=_Sisters, context_settings={"help_option_names": ["-h", "--help"]}, no_args_is_help=False)
@click.version_option(__version__, prog_name="haptisym", message="%(prog)s %(version)s")
def app() -> None:
    """Evaluate haptic displays symbolically.

    A scene says what a hand should feel (the environment) and what stands in between (the effects). haptisym derives in
    closed form what is felt instead, proves from which frequency a person notices, and as what: stiffness, mass, damping.

    \b
    Begin with:
      haptisym evaluate fu2019              the example of Fu, van Paassen and Mulder (2019)
      haptisym scenes                       what else the package ships
      haptisym evaluate my-device.toml      your own; copy a shipped scene to start
    """


def json_option(command: Callable[..., Any]) -> Callable[..., Any]:
    """The option ``--json``, alike on every verb."""
    return click.option("--json", "as_json", is_flag=True, help="Print one JSON document and nothing else.")(command)


@app.command()
@click.argument("scene")
@json_option
@click.option(
    "--digits",
    type=click.IntRange(1, 10_000),
    default=15,
    show_default=True,
    help="Correct decimal digits of each crossing.",
)
@click.option(
    "--figures", type=click.Path(file_okay=False, path_type=Path), metavar="DIR", help="Write the figures there."
)
@click.option(
    "--latex", type=click.Path(dir_okay=False, path_type=Path), metavar="FILE", help="Write the derivation as LaTeX."
)
@click.option(
    "--report",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE",
    help="Write the report: a page (.html) with an explorer, or a document (.pdf).",
)
def evaluate(
    scene: str, as_json: bool, digits: int, figures: Path | None, latex: Path | None, report: Path | None
) -> None:
    """Find when a display begins to be noticed, and how it is felt, with proof.

    SCENE is a scene file (TOML) or the name of a shipped scene.

    Step 1 finds every frequency of the band at which r_r = |Re dH|/|H_env| or r_i = |Im dH|/|H_env| meets the JND
    threshold; step 2 says as which mechanical property the distortion is felt beyond it. Frequencies are in rad/s.

    \b
    Examples:
      haptisym evaluate fu2019
      haptisym evaluate fu2019 --figures figures --latex fu2019.tex
      haptisym evaluate fu2019 --report fu2019.html
      haptisym evaluate my-device.toml --json --digits 50
    """
    result = evaluate_scene(load_scene(scene), digits)
    if figures is not None:
        from .figures import save_figures

        written = save_figures(result, figures)
        click.echo(f"{len(written)} figures written to {figures}", err=True)
    if latex is not None:
        from .texdocument import document

        latex.write_text(document(result), encoding="utf-8")
        click.echo(f"LaTeX written to {latex}", err=True)
    if report is not None:
        from .report import save_report

        save_report(result, report)
        click.echo(f"report written to {report}", err=True)
    click.echo(result.to_json() if as_json else str(result), nl=as_json)
    if not result.certified:
        sys.exit(3)


@app.command()
@json_option
def scenes(as_json: bool) -> None:
    """List the scenes that the package ships."""
    listed = [(name, load_scene(name)) for name in scene_names()]
    if as_json:
        keys = [(name, x.title, x.source, [e.name for e in x.effects]) for name, x in listed]
        rows = [dict(zip(("name", "title", "source", "effects"), row, strict=True)) for row in keys]
        click.echo(dumps({"schema": "haptisym.scenes/1", "scenes": rows}, indent=2, ensure_ascii=False))
        return
    width = max(len(name) for name, _ in listed)
    for name, x in listed:
        click.echo(f"{name:<{width}}  {x.title}")


def main() -> None:
    """Run the command line: exit status 0 done, 2 wrong scene or command line, 3 undecided."""
    try:
        sys.exit(app(sys.argv[1:] or ["--help"], standalone_mode=False, prog_name="haptisym"))
    except click.exceptions.Abort:
        sys.exit(130)
    except click.ClickException as error:
        error.show()
        sys.exit(2)
    except UndecidedError as error:
        _fail(f"undecided: {error}", 3)
    except HaptisymError as error:
        _fail(f"error: {error}", 2)
    except OSError as error:
        _fail(f"error: {error.filename}: {error.strerror}", 2)


def _fail(message: str, status: int) -> None:
    click.echo(message, err=True)
    sys.exit(status)
