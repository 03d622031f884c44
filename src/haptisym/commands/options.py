"""What the verbs of the command line share: the scene that they are about, options alike, and how an answer is handed over."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sized
from functools import wraps
from pathlib import Path
from typing import Any

import click

from haptisym.commands.progress import quiet
from haptisym.commands.streams import note, say, say_document, to_file
from haptisym.commands.verb import PAGES, can_be_written
from haptisym.figures.kinds import checked
from haptisym.judge.answers import Answer
from haptisym.kernel.errors import NothingToDrawError
from haptisym.model.scenefile import load_scene

Command = Callable[..., Any]


def scene_argument(command: Command) -> Command:
    """SCENE and, of a scene with several environments, ``--environment NAME``: the command gets the loaded scene."""

    @click.argument("scene")
    @environment_option
    @wraps(command)
    def loaded(*args: Any, scene: str, environment: str | None, **options: Any) -> Any:
        return command(*args, scene=load_scene(scene, environment), **options)

    return loaded


def environment_option(command: Command) -> Command:
    """The option ``--environment NAME``."""
    return click.option(
        "--environment", "environment", metavar="NAME", help="Of a scene with several environments, only this one."
    )(command)


def json_option(command: Command) -> Command:
    """The option ``--json``."""
    return click.option("--json", "as_json", is_flag=True, help="Print one JSON document and nothing else.")(command)


def figure_option(what: str) -> Callable[[Command], Command]:
    """The option ``--figure FILE``, for a drawing of what is said; a path that will not do is refused before the work begins."""
    kind = click.Path(dir_okay=False, path_type=Path)
    help_text = f"Draw {what} (.svg, .pdf or .png)."
    return click.option("--figure", type=kind, metavar="FILE", callback=_writable, help=help_text)


def _writable(_context: click.Context, _option: click.Parameter, path: Path | None) -> Path | None:
    return None if path is None else checked(can_be_written("figure", path))


def file_option(name: str, help_text: str) -> Callable[[Command], Command]:
    """An option that names a file to be written; a path that will not do is refused before the work begins."""

    def writable(_context: click.Context, _option: click.Parameter, path: Path | None) -> Path | None:
        return None if path is None else can_be_written(name, path)

    kind = click.Path(dir_okay=False, path_type=Path)
    return click.option(f"--{name}", type=kind, metavar="FILE", callback=writable, help=help_text)


def figures_option(command: Command) -> Command:
    """The option ``--figures DIR``."""
    kind = click.Path(file_okay=False, path_type=Path)
    return click.option("--figures", type=kind, metavar="DIR", help="Write the figures there.")(command)


def certificate_option(command: Command) -> Command:
    """The option ``--certificate FILE``."""
    return file_option(
        "certificate", "Write the answer with a proof that `python -m haptisym_check FILE SCENE.toml` checks."
    )(command)


def written(what: str, path: Path) -> None:
    """Tell on standard error that a file is there."""
    quiet()
    note(f"{what} written to {path}")


def keep(what: str, path: Path, save: Callable[[], Any]) -> None:
    """Write a file and tell so on standard error; what it cannot be written for is a sentence that names it."""
    with to_file(what, path):
        save()
    written(what, path)


def keep_figures(folder: Path, save: Callable[[], Sized]) -> None:
    """Write figures to a folder, and tell how many."""
    with to_file("figures", folder):
        count = len(save())
    written(f"{count} figures", folder)


def drawn(found: Answer, path: Path | None) -> None:
    """Write the figure of an answer where one was asked for, and tell so on standard error, or that there is nothing to draw."""
    if path is None:
        return
    try:
        keep("figure", path, lambda: found.save_figure(path))
    except NothingToDrawError as error:
        quiet()
        note(f"no figure: {error}")


def proven(found: Answer, path: Path | None) -> None:
    """Write the certificate of an answer where one was asked for, and tell so on standard error."""
    if path is not None:
        proof = found.certificate()
        keep("certificate", path, lambda: path.write_text(proof, encoding="utf-8"))


def keep_pages(document: Callable[[], Any], record: Callable[[], str]) -> None:
    """Write the page of an answer to the files that ``--latex`` and ``--report`` name; ``record`` : its document of JSON."""
    asked = click.get_current_context().meta[PAGES]
    if (path := asked["latex"]) is not None:
        from haptisym.writing.latex import latex

        keep("LaTeX", path, lambda: path.write_text(latex(document()), encoding="ascii"))
    if (report := asked["report"]) is not None:
        from haptisym.pages.report import save

        keep("report", report, lambda: save(document(), record(), report))


def hand_over(found: Answer, *, as_json: bool) -> None:
    """Print an answer; exit status 3 where something in it stayed undecided."""
    show(found, as_json=as_json)
    end(found)


def show(found: Answer, *, as_json: bool) -> None:
    """Print an answer, as its page or as its document."""
    keep_pages(found.document, found.to_json)
    if as_json:
        quiet()
        say_document(found.json_parts())
        return
    told = found.document()
    quiet()
    say(told)


def end(found: Answer) -> None:
    """Exit status 3 where something in an answer stayed undecided."""
    if not found.certified:
        sys.exit(3)
