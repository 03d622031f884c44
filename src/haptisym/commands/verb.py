"""A verb of the command line: what holds for the options of all of them."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import click
from click.core import ParameterSource

from haptisym.figures.kinds import checked_report
from haptisym.kernel.errors import SceneError

OptionRule = tuple[str, str, str]
"""Two options, and what is to be said of them."""


def verb(
    *, apart: Sequence[OptionRule] = (), needs: Sequence[OptionRule] = (), pages: bool = True
) -> Callable[[Callable[..., Any]], click.Command]:
    """The decorator of a verb, in place of ``click.command()``.

    ``apart`` : options that may not both be given, and why: a sentence to which "leave out one of them" is added. ``needs`` : an
    option that means nothing without another one, and what it is about. ``pages`` : whether it answers with a page, which
    ``--latex`` and ``--report`` write to files.
    """
    return click.command(cls=Verb, apart=apart, needs=needs, pages=pages)


PAGES = "haptisym.pages"
"""What ``--latex`` and ``--report`` name, in the context's ``meta``: whoever hands an answer over writes them."""


class Verb(click.Command):
    """A command that refuses what would be ignored or lost.

    Each option is given once, unless it may be repeated; options of ``apart`` are not given together, those of ``needs`` only
    together; no output is written over a file that the call reads, or over another output. All that is found before the work
    begins.
    """

    def __init__(
        self,
        *args: Any,
        apart: Sequence[OptionRule] = (),
        needs: Sequence[OptionRule] = (),
        pages: bool = True,
        **options: Any,
    ) -> None:
        super().__init__(*args, **options)
        self.apart, self.needs = apart, needs
        if pages:
            self.params += [
                _file("latex", "Write the page as a document of LaTeX."),
                _file("report", "Write the page as a report: of HTML (.html), or a document (.pdf).", checked_report),
            ]

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """As click; an option that is given twice is refused."""
        if not ctx.resilient_parsing:
            _once_each(self.make_parser(ctx).parse_args(args=list(args))[2])
        return super().parse_args(ctx, args)

    def invoke(self, ctx: click.Context) -> Any:
        """As click; what contradicts itself, is ignored or would be lost is refused before."""
        for one, other, why in self.apart:
            if given(ctx, one) and given(ctx, other):
                raise SceneError(f"{why}: leave out one of them")
        for one, other, about in self.needs:
            if given(ctx, one) and not given(ctx, other):
                raise SceneError(f"{one} is about {about}: it needs {other}, or leave it out")
        _nothing_lost(ctx)
        ctx.meta[PAGES] = {name: ctx.params.pop(name, None) for name in ("latex", "report")}
        return super().invoke(ctx)


def _file(name: str, words: str, checked: Callable[[Path], Path] = Path) -> click.Option:
    def writable(_context: click.Context, _option: click.Parameter, path: Path | None) -> Path | None:
        return None if path is None else can_be_written(name, checked(path))

    kind = click.Path(dir_okay=False, path_type=Path)
    return click.Option([f"--{name}"], type=kind, metavar="FILE", callback=writable, help=words)


def can_be_written(what: str, path: Path) -> Path:
    """The path; SceneError where nothing can be written there, before the work begins."""
    if not path.parent.is_dir():
        raise SceneError(f"{what}: {path} cannot be written: there is no folder {path.parent}")
    if not os.access(path.parent, os.W_OK) or (path.exists() and not os.access(path, os.W_OK)):
        raise SceneError(f"{what}: {path} cannot be written: permission denied")
    return path


def given(ctx: click.Context, option: str) -> bool:
    """Whether an option such as ``--digits`` stands on the command line."""
    return any(
        option in (*x.opts, x.name) and ctx.get_parameter_source(str(x.name)) is ParameterSource.COMMANDLINE
        for x in ctx.command.params
    )


def _once_each(order: Sequence[click.Parameter]) -> None:
    """Refuse an option that is given twice, and two flags of which only the last would count."""
    options = [x for x in order if isinstance(x, click.Option) and not x.multiple]
    for name in dict.fromkeys(x.name for x in options):
        same = list(dict.fromkeys(x.opts[-1] for x in options if x.name == name))
        if len(same) > 1:
            raise SceneError(f"{same[0]} and {same[1]} contradict each other: leave out one of them")
    for option, times in Counter(options).items():
        if times > 1 and not option.is_flag:
            raise SceneError(
                f"{option.opts[-1]} is given {times} times, and only one of them would count: leave out the others"
            )


def _nothing_lost(ctx: click.Context) -> None:
    """Refuse an output that would be written over a file that is read, whatever its name, or over another output."""
    outputs = [
        (x.opts[-1], ctx.params[str(x.name)])
        for x in ctx.command.params
        if isinstance(ctx.params.get(str(x.name)), Path)
    ]
    inputs = [path for x in ctx.command.params for path in _files(ctx.params.get(str(x.name)))]
    for i, (option, path) in enumerate(outputs):
        for read in inputs:
            if _is_same(path, read):
                raise SceneError(
                    f"{option}: {path} is read by this very call, and would be overwritten: choose another name"
                )
        for other, taken in outputs[:i]:
            if path == taken or _is_same(path, taken):
                raise SceneError(
                    f"{other} and {option} would both be written to {path}: choose another name for one of them"
                )


def not_over(read: Iterable[Path | None], outputs: Mapping[str, Path | None]) -> None:
    """SceneError where an output would be written over a file that a scene names."""
    for path in filter(None, read):
        for option, target in outputs.items():
            if target is not None and _is_same(target, path):
                raise SceneError(
                    f"--{option}: {target} is read by this very call, and would be overwritten: choose another name"
                )


def _files(value: Any) -> Iterator[Path]:
    """The files that a text of the command line names, if it names any."""
    if isinstance(value, tuple):
        for one in value:
            yield from _files(one)
    elif isinstance(value, str) and "\0" not in value:
        yield Path(value)


def _is_same(one: Path, other: Path) -> bool:
    try:
        return one.is_file() and other.is_file() and one.samefile(other)
    except OSError:  # a name too long to be one
        return False
