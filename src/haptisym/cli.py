"""The command line: ``haptisym evaluate SCENE`` and its sisters."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from . import __version__
from .errors import HaptisymError, UndecidedError
from .evaluation import evaluate as evaluate_scene
from .scenefile import load_scene, scene_names
from .text import report

app = typer.Typer(
    add_completion=False,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
    help=(
        "Evaluate haptic displays symbolically: what is felt instead of the environment, from which frequency a hand "
        "notices, and as what (stiffness, mass, damping). Begin with: haptisym evaluate fu2019"
    ),
)

SceneArgument = Annotated[
    str, typer.Argument(metavar="SCENE", help="A scene file (TOML), or the name of a shipped scene.")
]
JsonOption = Annotated[bool, typer.Option("--json", help="Print one JSON document and nothing else.")]


def _version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"haptisym {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """Options before any verb."""


@app.command()
def evaluate(
    scene: SceneArgument,
    json: JsonOption = False,
    digits: Annotated[int, typer.Option(min=1, max=10_000, help="Correct decimal digits of each crossing.")] = 15,
    figures: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Write the figures there, as SVG, PDF and PNG.", file_okay=False)
    ] = None,
    latex: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write the derivation as a LaTeX document.", dir_okay=False)
    ] = None,
) -> None:
    """Find when a display begins to be noticed, and how it is felt, with proof.

    Step 1 finds every frequency of the band at which the ratios r_r = |Re dH|/|H_env| and r_i = |Im dH|/|H_env| cross
    the threshold. Step 2 says as which mechanical property the distortion is felt beyond it. Frequencies are in rad/s.

    Examples:

    haptisym evaluate fu2019

    haptisym evaluate fu2019 --figures figures --latex fu2019.tex

    haptisym evaluate my-device.toml --json --digits 50
    """
    result = evaluate_scene(load_scene(scene), digits)
    if figures is not None:
        from .figures import save_figures  # matplotlib is loaded only where a figure is asked for

        written = save_figures(result, figures)
        typer.echo(f"{len(written)} figures written to {figures}", err=True)
    if latex is not None:
        from .texdocument import document

        latex.write_text(document(result), encoding="utf-8")
        typer.echo(f"LaTeX written to {latex}", err=True)
    typer.echo(result.to_json() if json else report(result), nl=json)


@app.command()
def scenes(json: JsonOption = False) -> None:
    """List the scenes that the package ships."""
    from json import dumps

    listed = [(name, load_scene(name)) for name in scene_names()]
    if json:
        rows = [
            {"name": name, "title": x.title, "source": x.source, "effects": [e.name for e in x.effects]}
            for name, x in listed
        ]
        typer.echo(dumps({"schema": "haptisym.scenes/1", "scenes": rows}, indent=2, ensure_ascii=False))
        return
    width = max(len(name) for name, _ in listed)
    for name, x in listed:
        typer.echo(f"{name:<{width}}  {x.title}")


def main() -> None:
    """Run the command line: exit status 0 done, 2 wrong scene or command line, 3 undecided."""
    try:
        app()
    except UndecidedError as error:
        typer.echo(f"undecided: {error}", err=True)
        sys.exit(3)
    except HaptisymError as error:
        typer.echo(f"error: {error}", err=True)
        sys.exit(2)
    except OSError as error:
        typer.echo(f"error: {error.filename}: {error.strerror}", err=True)
        sys.exit(2)
