"""What a verb of the command line is: a list of options, a question, and an answer that is handed
over.

A verb is a function of one value, ``ask``, which has an attribute for each option, and its
docstring is the help. It returns the answer; what the options ask for besides (figures, a
certificate, pages as files), the output and the exit status follow from the answer alone, in
``hand_over``, the same for all verbs. An option that several verbs have stands here, once.

What would be ignored or lost is refused before the work begins: an option given twice, two that
contradict each other, one that means nothing without another, an output that would be written over
a file that the call reads, or over another output.
"""

from __future__ import annotations

import os
import sys
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from copy import copy
from functools import cache, partial
from inspect import cleandoc
from pathlib import Path
from pkgutil import resolve_name
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, TypeAlias

import click
from click.core import ParameterSource

from haptisym.commands.terminal import (
    ends_with_what_is_proven,
    note,
    progress,
    say,
    say_document,
    says_help,
    to_file,
)
from haptisym.figures.pen import STYLES, UNDATED, checked, checked_report
from haptisym.kernel.budget import SECONDS, limited
from haptisym.kernel.errors import NothingToDrawError, SceneError, UndecidedError, meant
from haptisym.model.files import write_whole

if TYPE_CHECKING:
    from haptisym.judge.answers import Answer

Ask: TypeAlias = Any
"""The values of a verb's options, by their names."""
Rule: TypeAlias = tuple[str, str, str]
"""Two options, and what is to be said of them. In a rule of ``needs`` the other one may be several
of which any will do: ``--figure or --figures``."""


# Options.


def option(flags: str, words: str, **given: Any) -> click.Option:
    """An option by its flag and what it takes (``--hand NAME``; a bare flag takes nothing), its
    help, and all else as click has it.

    >>> option("--hand NAME", "A hand; repeatable.", multiple=True).metavar
    'NAME'
    """
    flag, _, metavar = flags.partition(" ")
    # Click would take a value for an option without a metavar, unless told otherwise; one with a
    # type shows its own.
    takes_nothing = not metavar and not {"type", "flag_value"} & {*given}
    names = [flag, *([given.pop("name")] if "name" in given else [])]
    return click.Option(
        names,
        metavar=metavar or None,
        is_flag=given.pop("is_flag", takes_nothing or None),
        help=words,
        **given,
    )


def output(flags: str, words: str, checked: Callable[[Path], Path] = Path) -> click.Option:
    """An option that names a file to be written; a path that will not do is refused before the work
    begins."""
    what = flags.partition(" ")[0].removeprefix("--")

    def writable(
        _context: click.Context, _option: click.Parameter, path: Path | None
    ) -> Path | None:
        return None if path is None else checked(_can_be_written(what, path))

    return option(flags, words, type=PathType(dir_okay=False, path_type=Path), callback=writable)


class PathType(click.Path):
    """A path; no name at all, which would be the folder of the call, is refused."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Convert as click does, but refuse an empty name."""
        # Path("") is the folder of the call.
        if value == "":
            raise SceneError(f'{param.opts[-1] if param else "file"} "": give a name')
        return super().convert(value, param, ctx)


def choice(flags: str, words: str, *values: str, **given: Any) -> click.Option:
    """An option that takes one of some words."""
    return option(flags, words, type=_Choice(values), **given)


class _Choice(click.Choice[str]):
    """One of some words; the nearest is offered for another."""

    def get_invalid_choice_message(self, value: Any, ctx: click.Context | None) -> str:
        return (
            f'"{value}" is unknown: {meant(str(value), self.choices)}valid are '
            f"{', '.join(self.choices)}"
        )


def number(
    flags: str, words: str, low: int, high: int | None = None, default: int | None = None
) -> click.Option:
    """An option that takes a whole number of a range; its default, where it has one, is in its
    help."""
    kind = click.IntRange(low, high)
    kind.name = "whole number"  # in messages, where click says "integer range"
    return option(flags, words, type=kind, default=default, show_default=default is not None)


def figure(what: str) -> click.Option:
    """The option ``--figure FILE``, for a drawing of the answer; a name without an ending gets that
    of ``--format``."""

    def in_format(path: Path) -> Path:
        return checked(path, click.get_current_context().params.get("format") or "")

    return output("--figure FILE", f"Draw {what} (.svg, .pdf or .png).", in_format)


def _hidden(given: click.Option) -> click.Option:
    """An option that works, and that help does not list."""
    option = copy(given)
    option.hidden = True
    return option


def optional(name: str, **given: Any) -> click.Argument:
    """An argument that may be left out."""
    return click.Argument([name], required=False, **given)


def _checked_latex(path: Path) -> Path:
    """The path of a LaTeX file; SceneError for one that is named as another page."""
    if path.suffix.lower() in (".pdf", ".html"):
        raise SceneError(
            f'latex: the name "{path.name}" must end in .tex; for this page as a PDF: '
            f"--report {path.name}"
        )
    return path


ENVIRONMENT = option("--environment NAME", "Use this environment, where a scene has several.")
NO_FILES = option("--no-files", "Read no file that a scene names, as scenes of strangers may.")
SCENE = (click.Argument(["scene"]), ENVIRONMENT, NO_FILES)
"""SCENE and, of a scene with several environments, ``--environment NAME``: the verb gets the loaded
scene.

It is one of formulas, which names no file: ``--no-files`` has nothing to refuse there.
"""
JSON = option("--json", "Print one JSON document.")
CERTIFICATE = output(
    "--certificate FILE", "Write a certificate, for python -m haptisym_check FILE SCENE.toml."
)
FIGURES = option(
    "--figures DIR",
    "Write the figures to this folder.",
    type=PathType(file_okay=False, path_type=Path),
)
_DRAWN = (
    choice(
        "--format",
        "Write figures in this format alone.",
        *(x.removeprefix(".") for x in UNDATED),
        is_eager=True,  # read before --figure, whose name it may complete
    ),
    choice("--style", "Set figures for one column of a journal, in greys.", *filter(None, STYLES)),
)
LIMIT = option(
    "--limit SECONDS",
    (
        "Stop after this many seconds of processor time; print what is proven and mark the rest "
        "undecided."
    ),
    type=click.FloatRange(min=0, min_open=True, max=1e9),
    default=SECONDS,
    show_default=True,
)
"""Of a verb that one Ctrl-C ends as the limit does: with what is proven so far."""
_DIGITS = option(
    "--digits N", "Digits to print (4 if not given; 15 in --json).", type=click.IntRange(1, 10_000)
)
_PAGES = (
    output("--latex FILE", "Write the page as a LaTeX document.", _checked_latex),
    output("--report FILE", "Write the page as a report (.html or .pdf).", checked_report),
    _DIGITS,
)
TABLE = output(
    "--latex-table FILE",
    "Write the main table for a paper, as one tabular of booktabs.",
    _checked_latex,
)
FORMULAS = option("--formulas", "Print the formulas, too.")
EVERYTHING = option("--all", "Print every measure with its formulas and values.", name="formulas")


# Verbs.


def verb(
    *options: click.Parameter | tuple[click.Parameter, ...],
    apart: Sequence[Rule] = (),
    needs: Sequence[Rule] = (),
    pages: bool = True,
    each: bool = False,
) -> Callable[[Callable[[Ask], Any]], Verb]:
    """The decorator of a verb: its arguments and options in the order of its help.

    ``apart`` : options that may not both be given, and why: a sentence to which "leave out one of
    them" is added. ``needs`` : an option that means nothing without another one, and what it is
    about. ``pages`` : whether it answers with a page, which
    ``--latex`` and ``--report`` write to files. ``each`` : whether it is asked about each of
    several environments.
    """
    listed: list[click.Parameter] = []
    for x in options:
        listed += x if isinstance(x, tuple) else (x,)
        if isinstance(x, click.Parameter) and x.name == "hand":
            listed.append(_LEVER)
            needs = [*needs, ("--lever", "--hand", "the hand of --hand")]
    # What adds to a page stands behind the options of pages, at the end of the help.
    last = [x for x in listed if x in (TABLE, FORMULAS, EVERYTHING)]
    listed = [*(x for x in listed if x not in last), *(_PAGES if pages else ()), *last]
    # One figure as a file, or all of them in a folder: both work, and help names the usual one.
    names = {x.name for x in listed}
    if "figure" in names and "figures" not in names:
        listed.append(_hidden(FIGURES))
    elif "figures" in names and "figure" not in names:
        listed.append(_hidden(figure("the answer")))
    if names & {"figure", "figures"}:
        listed += _DRAWN
        needs = [*needs, *((x.opts[0], "--figure or --figures", "figures") for x in _DRAWN)]
    return lambda question: Verb(question, listed, apart, needs, each=each)


_LEVER = option("--lever LENGTH", "Lever that the hand holds: m, b, k times its square.")


class Verb(click.Command):
    """A command that asks one question, and refuses what would be ignored or lost."""

    def __init__(
        self,
        question: Callable[[Ask], Any],
        params: list[click.Parameter],
        apart: Sequence[Rule],
        needs: Sequence[Rule],
        *,
        each: bool = False,
    ) -> None:
        super().__init__(question.__name__, params=params, help=cleandoc(question.__doc__ or ""))
        self.question, self.apart, self.needs, self.each = question, apart, needs, each

    def get_help_option(self, ctx: click.Context) -> click.Option | None:
        """The option of click, which prints a sentence where the help cannot be written."""
        return says_help(super().get_help_option(ctx))

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Parse as click does; an option that is given twice is refused, and for an unknown one the
        commands are named that have it."""
        try:
            # Click lets the last of two win without a word. Completion parses unfinished lines.
            if not ctx.resilient_parsing:
                _once_each(self.make_parser(ctx).parse_args(args=list(args))[2])
            return super().parse_args(ctx, args)
        except click.NoSuchOption as error:
            near = any(x.startswith(error.option_name) for x in error.possibilities or ())
            if not near and (others := _with_option(error.option_name, ctx)):
                words = f"{error.message.rstrip('.')}: {others}"
                raise click.NoSuchOption(error.option_name, words, ctx=ctx) from None
            raise

    def invoke(self, ctx: click.Context) -> None:
        """Ask, and hand the answer over; what contradicts itself, is ignored or would be lost is
        refused before."""
        try:
            self._invoke(ctx)
        except SceneError as error:
            # What the error of a scene file proposes stays a line of that file.
            raise error.typed([y for x in self.params for y in x.opts]) from None

    def _invoke(self, ctx: click.Context) -> None:
        for one, other, why in self.apart:
            if given(one) and given(other):
                raise SceneError(f"{why}: leave out one of them")
        for one, other, about in self.needs:
            if given(one) and not any(map(given, other.split(" or "))):
                raise SceneError(f"{one} is about {about}: it needs {other}, or leave it out")
        _nothing_lost(ctx)
        # A verb without pages has their options too, as None: ``hand_over`` is the same for all.
        ask = SimpleNamespace(**{str(x.name): None for x in (*_PAGES, FORMULAS)} | ctx.params)
        if ask.__dict__.get("lever"):
            on_lever = partial("{1} at {0}".format, ask.lever)
            is_one = isinstance(ask.hand, str)
            ask.hand = on_lever(ask.hand) if is_one else tuple(map(on_lever, ask.hand))
        if SCENE[0] in self.params:
            ask.scene = self._opened(ask)
        # In this order: the limit reports to the bar, and Ctrl-C stops the limit's budget.
        with ExitStack() as stack:
            if LIMIT in self.params:
                bar = stack.enter_context(progress())
                budget = stack.enter_context(limited(ask.limit, bar))
                stack.enter_context(ends_with_what_is_proven(budget))
            answer = self._answer(ask)
        # Outside of the limit: what is proven is printed, however long that takes.
        if answer is not None:
            hand_over(answer, ask)

    def _opened(self, ask: Ask) -> Any:
        """The scene, or the family that is asked about as a whole."""
        from haptisym.model.scenefile import (
            load_scene,
            load_scenes,
        )  # SymPy, which help does not need

        if not self.each or ask.environment is not None:
            return load_scene(ask.scene, ask.environment)
        # A file with one environment is an ordinary scene, whichever way it is written.
        family = load_scenes(ask.scene)
        if len(family) == 1:
            return family.first
        for one in ("--certificate", "--to"):
            if given(one):
                raise SceneError(f"{one} takes one environment: choose it with --environment NAME")
        return family

    def _answer(self, ask: Ask) -> Any:
        """The answer of the question, or of the question about each of a family's scenes."""
        if not self.each or not hasattr(ask.scene, "scenes"):
            return self.question(ask)
        from haptisym.verbs.family.answers import answer_each

        return answer_each(
            ask.scene, lambda scene: self.question(SimpleNamespace(**{**vars(ask), "scene": scene}))
        )


def given(option: str) -> bool:
    """Whether an option such as ``--digits`` stands on the command line."""
    # Not by its value: a default may be equal to what was given.
    context = click.get_current_context()
    names = (str(x.name) for x in context.command.params if option in (*x.opts, x.name))
    return any(context.get_parameter_source(name) is ParameterSource.COMMANDLINE for name in names)


def _with_option(flag: str, ctx: click.Context) -> str:
    """A clause that names the other commands that have an option; "" where none has."""
    group = ctx.parent.command if ctx.parent is not None else None
    if not isinstance(group, click.Group):
        return ""
    commands = filter(None, (group.get_command(ctx, name) for name in group.list_commands(ctx)))
    having = [str(x.name) for x in commands if any(flag in y.opts for y in x.params)]
    found = [f"it is an option of {', '.join(having)}"] if having else []
    if key := _IN_SCENES.get(flag):
        found = [f"write {key} into the scene file", *found]
    return "; ".join(found)


_IN_SCENES = {"--band": "[evaluation] band", "--jnd": "[evaluation] jnd"}
"""Keys of a scene that are looked for among the options."""


def _once_each(order: Sequence[click.Parameter]) -> None:
    """Refuse an option that is given twice, and two flags of which only the last would count."""
    options = [x for x in order if isinstance(x, click.Option) and not x.multiple]
    for key in dict.fromkeys(x.name for x in options):
        same = list(dict.fromkeys(x.opts[-1] for x in options if x.name == key))
        if len(same) > 1:
            raise SceneError(
                f"{same[0]} and {same[1]} contradict each other: leave out one of them"
            )
    # A flag that is given twice means the same as once.
    for one, times in Counter(options).items():
        if times > 1 and not one.is_flag:
            words = (
                f"is given {times} times, and only one of them would count: leave out the others"
            )
            raise SceneError(f"{one.opts[-1]} {words}")


def _nothing_lost(ctx: click.Context) -> None:
    """Refuse an output that would be written over a file that is read, whatever its name, or over
    another output."""
    values = [(x.opts[-1], ctx.params.get(str(x.name))) for x in ctx.command.params]
    outputs = [(name.removeprefix("--"), x) for name, x in values if isinstance(x, Path)]
    # Any text of the command line may name a file; one that names none is the same as no output.
    texts = (x for _, x in values)
    not_over((path for x in texts for path in _files(x)), dict(outputs), "")
    for i, (name, path) in enumerate(outputs):
        for other, taken in outputs[:i]:
            if path == taken or _is_same(path, taken):
                both = f"--{other} and --{name} would both be written to {path}"
                raise SceneError(f"{both}: choose another name for one of them")


def not_over(
    read: Iterable[Path | None], outputs: Mapping[str, Path | None], flag: str = "--"
) -> None:
    """SceneError where an output would be written over a file that a scene names."""
    for path in filter(None, read):
        for name, target in outputs.items():
            if target is not None and _is_same(target, path):
                lost = f"--{name}: {target} is read by this very call, and would be overwritten"
                raise SceneError(f"{lost}: choose another name")


def _files(value: Any) -> Iterator[Path]:
    """The files that a text of the command line names, if it names any."""
    if isinstance(value, tuple):
        for one in value:
            yield from _files(one)
    elif isinstance(value, str) and "\0" not in value:
        yield Path(value)


def _is_same(one: Path, other: Path) -> bool:
    """Whether two paths lead to one file that is there, by whatever links."""
    try:
        return one.is_file() and other.is_file() and one.samefile(other)
    except OSError:  # a name too long to be one
        return False


def _can_be_written(what: str, path: Path) -> Path:
    """The path; SceneError where nothing can be written there."""
    folder = path.resolve().parent  # that of a link is where it leads
    # Asked before the work, which may take minutes. Another process may still change it: writing
    # itself reports what goes wrong.
    if not folder.is_dir():
        raise SceneError(f"{what}: {path} cannot be written: there is no folder {path.parent}")
    if not os.access(folder, os.W_OK) or (path.exists() and not os.access(path, os.W_OK)):
        raise SceneError(f"{what}: {path} cannot be written: permission denied")
    return path


# Answers.


def keep(what: str, path: Path, save: Callable[[], Any]) -> None:
    """Write a file (or a folder of them) and report it on standard error; what it cannot be written
    for is a sentence."""
    with to_file(what, path):
        saved = save()
    note(f"{f'{len(saved)} figures' if what == 'figures' else what} written to {path}")


def keep_text(what: str, path: Path | None, text: Callable[[], str]) -> None:
    """Write a text, where a file was asked for."""
    if path is not None:
        # Outside of ``keep``: what goes wrong with the text is no error of writing a file.
        content = text()
        keep(what, path, lambda: write_whole(path, content))


def keep_pages(found: Answer, ask: Ask) -> Callable[[], Any]:
    """Write the page of an answer to the files that ``--latex`` and ``--report`` name; a function
    that gives it, made once."""
    # For files and screen alike, so it is made at most once, and not at all for --json alone.
    page = cache(found.document)
    if ask.latex is not None:
        latex: Callable[..., str] = resolve_name("haptisym.writing.latex:latex")
        keep("LaTeX", ask.latex, lambda: write_whole(ask.latex, latex(page()), "ascii"))
    if getattr(ask, "latex_table", None) is not None:
        tabular: Callable[..., str] = resolve_name("haptisym.writing.latex:tabular")
        kind = found._schema.partition(".")[2].partition("/")[0]
        text = tabular(page(), ask.digits, kind=kind, lines=found._is_in_lines)
        keep("LaTeX table", ask.latex_table, lambda: write_whole(ask.latex_table, text, "ascii"))
    if ask.report is not None:
        save = resolve_name("haptisym.pages.report:save")
        keep("report", ask.report, lambda: save(page(), found.to_json(), ask.report))
    return page


def hand_over(found: Answer, ask: Ask) -> None:
    """Write the files that were asked for, print the answer; exit status 3 where something in it is
    undecided.

    Else 2 where a figure was asked for and could not be drawn. For a certificate there is the limit
    once more.
    """
    # Files before the page: printing ends early where the reader leaves.
    is_drawn, is_proven = draw(found, ask), True
    if getattr(ask, "certificate", None) is not None:
        try:
            with limited(ask.limit):
                keep_text("certificate", ask.certificate, found.certificate)
        except UndecidedError as error:
            note(f"no certificate: {error}")
            is_proven = False
    page = keep_pages(found, ask)
    if ask.json:
        say_document(found.to_json())
    else:
        say(page(), ask.digits, formulas=bool(ask.formulas))
    # Undecided (3) outweighs a figure that could not be drawn (2).
    end(found)
    if not (is_drawn and is_proven):
        sys.exit(2 if is_proven else 3)


def draw(found: Answer, ask: Ask) -> bool:
    """Write the figure, or the figures, of an answer where they were asked for; say why where there
    is nothing to draw.

    False where a figure was asked for and is not there.
    """
    figures, figure = (getattr(ask, name, None) for name in ("figures", "figure"))
    style = getattr(ask, "style", None) or ""
    try:
        if figures is not None:
            keep(
                "figures",
                figures,
                lambda: found.save_figures(figures, format=ask.format or "", style=style),
            )
        if figure is not None:
            keep("figure", figure, lambda: found.save_figure(figure, style=style))
    except (NothingToDrawError, UndecidedError) as error:
        note(f"no figure: {error}")
        return False
    return True


def end(found: Answer) -> None:
    """Exit status 3 where something in an answer stayed undecided."""
    if not found.settled:
        sys.exit(3)
