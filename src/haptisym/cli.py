"""The command line: ``haptisym evaluate SCENE`` and its sisters.

What only some calls need (Rich for text, matplotlib for figures, the LaTeX printer) is imported
where it is called for, so that ``--json`` in a loop pays for none of it.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from contextlib import suppress
from itertools import chain
from pkgutil import get_data, resolve_name

import click

from haptisym import __version__
from haptisym.commands.terminal import (
    ReaderLeft,
    interrupts,
    loading,
    note,
    prepare,
    says_help,
    write,
)
from haptisym.kernel.errors import HaptisymError, UndecidedError, meant

# The help of a bare call lists all verbs with their first sentences. They are read from the source,
# as importing the modules would load SymPy.
_COMMANDS = {
    module: re.findall(
        r'^def (\w+)\(ask: Ask\).*\n    """(.+?)(?:""")?$',
        (get_data("haptisym.commands", f"{module}.py") or b"").decode(),
        re.MULTILINE,
    )
    for module in ("verbs", "shipped")
}
VERBS = dict(chain(*_COMMANDS.values()))
"""Each verb with the first sentence of its help, as ``commands.verbs`` and ``commands.shipped``
say, which are only read."""
LIGHT = tuple(dict(_COMMANDS["shipped"]))
"""Those of ``commands.shipped``, which need no SymPy."""


class _Sisters(click.Group):
    """The group of verbs; a bare call prints the help, for which none of them is loaded."""

    def list_commands(self, _context: click.Context) -> list[str]:
        return list(VERBS)

    def get_command(self, context: click.Context, name: str) -> click.Command | None:
        if name not in VERBS:
            return None
        module = "shipped" if name in LIGHT else "verbs"
        with loading():
            command: click.Command = resolve_name(f"haptisym.commands.{module}:{name}")
        # ``loaded`` of ``main``: everything that the verb always needs is there.
        if context.obj is not None:
            context.obj()
        return command

    def format_commands(self, _context: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl(list(VERBS.items()))

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        # The name of a scene file in place of a verb: most likely it is to be evaluated.
        if args and args[0] not in VERBS:
            hint = meant(args[0], VERBS)
            if args[0].endswith(".toml"):
                hint = f'did you mean "haptisym evaluate {args[0]}"?'
            ctx.fail(
                f'unknown command "{args[0]}": {hint or "haptisym --help lists them"}'.rstrip()
            )
        return super().resolve_command(ctx, args)

    def get_help_option(self, ctx: click.Context) -> click.Option | None:
        return says_help(super().get_help_option(ctx))


def _say_version(
    context: click.Context,
    _option: click.Parameter,
    asked: bool,  # noqa: FBT001  as click calls it
) -> None:
    if asked and not context.resilient_parsing:
        write(f"haptisym {__version__}\n")
        context.exit()


@click.group(
    cls=_Sisters, context_settings={"help_option_names": ["-h", "--help"]}, no_args_is_help=False
)
@click.option(
    "--version",
    is_flag=True,
    is_eager=True,
    expose_value=False,
    callback=_say_version,
    help="Show the version and exit.",
)
def app() -> None:
    """Evaluate haptic displays symbolically.

    A scene says what a hand should feel (the environment) and what stands in between (the effects).
    haptisym derives in closed form what is felt instead, proves from which frequency a person
    notices, and as what: stiffness, mass, damping.

    \b
    Begin with:
      haptisym evaluate fu2019              the example of Fu, van Paassen and Mulder (2019)
      haptisym scenes                       what else the package ships
      haptisym scenes fu2019 > my.toml      a copy to start your own from
      haptisym evaluate my.toml
      haptisym evaluate --help              options and examples of a command
    """


_EXTRAS = {
    "scipy": "simulate",
    "xarray": "sweep",
    "dask": "sweep",
    "zarr": "sweep",
    "numba": "fast",
    "psignifit": "psychophysics",
}
"""Packages that only some verbs need, and the extra of each."""


def main(loaded: Callable[[], None] | None = None) -> None:
    """Run the command line: exit status 0 done, 2 wrong scene or command line, 3 undecided, 130
    interrupted.

    ``loaded`` : is called when everything that the verb always needs is there.
    """
    # Not in click's own way (standalone), which would print errors and exit by itself: here each
    # kind of error has a sentence and a status of its own.
    prepare()
    with interrupts() as interrupted:
        try:
            status = app(
                sys.argv[1:] or ["--help"], standalone_mode=False, prog_name="haptisym", obj=loaded
            )
        except Exception as error:  # noqa: BLE001  all that nobody foresaw is raised again
            status = _told(error, is_interrupted=bool(interrupted))
    sys.exit(status)


def _told(error: Exception, *, is_interrupted: bool) -> int:
    """Print what went wrong, and return the exit status for it; raise again what nobody foresaw."""
    # First: an interruption may arrive as another error, of the package that it fell into.
    if is_interrupted or isinstance(error, click.exceptions.Abort):
        return _failed(f"interrupted{_how_far(error)}", 130)
    match error:
        case ReaderLeft():
            return 128 + 13  # as whoever is ended by SIGPIPE
        case click.ClickException():
            with suppress(OSError):
                error.show()
            return 2
        case UndecidedError():
            return _failed(f"undecided: {error}", 3)
        case HaptisymError():
            return _failed(f"error: {error}", 2)
        case ModuleNotFoundError() if (package := (error.name or "").split(".")[0]) in _EXTRAS:
            return _failed(
                (
                    f"error: {package} is missing: this needs pip install "
                    f'"haptisym[{_EXTRAS[package]}]"'
                ),
                2,
            )
        case OSError():
            where = "" if error.filename is None else f"{error.filename}: "
            return _failed(f"error: {where}{error.strerror or error}", 2)
    raise error


def _how_far(error: BaseException) -> str:
    """How far a verb came when it was interrupted, in its own words."""
    # Click makes an Abort of a KeyboardInterrupt, whose text ``progress`` wrote.
    words = str(error.__cause__ or "") if isinstance(error, click.exceptions.Abort) else ""
    return words or ": there is no answer"


def _failed(message: str, status: int) -> int:
    """Print a message on standard error, and return the exit status."""
    note(message)
    return status
