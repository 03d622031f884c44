"""The command line: ``haptisym evaluate SCENE`` and its sisters.

What only some calls need (Rich for text, matplotlib for figures, the LaTeX printer) is imported where it is called
for, so that ``--json`` in a loop pays for none of it.
"""

from __future__ import annotations

import sys
from contextlib import suppress
from typing import Any

import click

from haptisym import __version__
from haptisym.commands.terminal import ReaderLeft, interrupts, note, prepare, to_standard_output
from haptisym.commands.verbs import VERBS
from haptisym.kernel.errors import HaptisymError, UndecidedError, meant


class _Sisters(click.Group):
    """The group of verbs, in their order."""

    def list_commands(self, _context: click.Context) -> list[str]:
        return list(self.commands)

    def resolve_command(self, ctx: click.Context, args: list[str]) -> Any:
        """As click; of a verb that there is not, the one that was meant."""
        name = args[0]
        if name not in self.commands and not name.startswith("-"):
            likely = meant(name, self.commands) or "haptisym --help lists them. "
            raise click.UsageError(f'no verb "{name[:60]}": {likely}'.rstrip(": "), ctx)
        return super().resolve_command(ctx, args)

    def make_context(self, *args: Any, **options: Any) -> click.Context:
        with to_standard_output():  # where the help goes
            return super().make_context(*args, **options)

    def invoke(self, ctx: click.Context) -> Any:
        with to_standard_output():
            return super().invoke(ctx)


_HELP = """Evaluate haptic displays symbolically.

A scene says what a hand should feel (the environment) and what stands in between (the effects). haptisym derives in
closed form what is felt instead, proves from which frequency a person notices, and as what: stiffness, mass, damping.

\b
Begin with:
  haptisym evaluate fu2019              the example of Fu, van Paassen and Mulder (2019)
  haptisym scenes                       what else the package ships
  haptisym scenes fu2019 > my.toml      a copy to start your own from
  haptisym evaluate my.toml
"""
app = click.version_option(__version__, prog_name="haptisym", message="%(prog)s %(version)s")(
    _Sisters("app", VERBS, help=_HELP, context_settings={"help_option_names": ["-h", "--help"]}, no_args_is_help=False)
)


_EXTRAS = {
    "scipy": "simulate",
    "xarray": "sweep",
    "dask": "sweep",
    "zarr": "sweep",
    "numba": "fast",
    "psignifit": "psychophysics",
}
"""Packages that only some verbs need, and the extra of each."""


def main() -> None:
    """Run the command line: exit status 0 done, 2 wrong scene or command line, 3 undecided, 130 interrupted."""
    prepare()
    with interrupts() as interrupted:
        try:
            status = app(sys.argv[1:] or ["--help"], standalone_mode=False, prog_name="haptisym")
        except Exception as error:  # noqa: BLE001  all that nobody foresaw is raised again
            status = _told(error, is_interrupted=bool(interrupted))
    sys.exit(status)


def _told(error: Exception, *, is_interrupted: bool) -> int:
    """Say what went wrong; the exit status of it."""
    if is_interrupted or isinstance(error, click.exceptions.Abort):
        reached = str(error.__cause__ or "") if isinstance(error, click.exceptions.Abort) else ""
        return _failed(f"interrupted{reached or ': there is no answer'}", 130)
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
            return _failed(f'error: {package} is missing: this needs pip install "haptisym[{_EXTRAS[package]}]"', 2)
        case OSError() if error.filename is not None:
            return _failed(f"error: {error.filename}: {error.strerror}", 2)
    raise error


def _failed(message: str, status: int) -> int:
    note(message)
    return status
