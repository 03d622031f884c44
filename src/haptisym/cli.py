"""The command line: ``haptisym evaluate SCENE`` and its sisters.

What only some calls need (Rich for text, matplotlib for figures, the LaTeX printer) is imported where it is called
for, so that ``--json`` in a loop pays for none of it.
"""

from __future__ import annotations

import sys

import click

from . import __version__
from .commands.cost import cost
from .commands.derive import derive
from .commands.effects import effects
from .commands.evaluate import evaluate
from .commands.metrics import metrics
from .commands.require import require
from .commands.scenes import scenes
from .commands.sensitivity import sensitivity
from .commands.simulate import simulate
from .commands.sweep import sweep
from .commands.tolerances import tolerances
from .errors import HaptisymError, UndecidedError


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
      haptisym scenes fu2019 > my.toml      a copy to start your own from
      haptisym evaluate my.toml
    """


for verb in (
    evaluate, derive, effects, require, sensitivity, tolerances, sweep, metrics, cost, simulate, scenes,
):  # fmt: skip
    app.add_command(verb)


_EXTRAS = {"scipy": "simulate", "xarray": "sweep", "dask": "sweep", "zarr": "sweep", "numba": "fast"}
"""Packages that only some verbs need, and the extra of each."""


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
    except ModuleNotFoundError as error:
        package = (error.name or "").split(".")[0]
        if package not in _EXTRAS:
            raise
        _fail(f'error: {package} is missing: this needs pip install "haptisym[{_EXTRAS[package]}]"', 2)
    except OSError as error:
        _fail(f"error: {error.filename}: {error.strerror}", 2)


def _fail(message: str, status: int) -> None:
    click.echo(message, err=True)
    sys.exit(status)
