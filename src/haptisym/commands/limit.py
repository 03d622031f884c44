"""The option ``--limit SECONDS``: verbs that may take long show a bar, and say in time what is proven so far."""

from __future__ import annotations

from functools import wraps
from typing import Any

import click

from haptisym.commands.options import Command
from haptisym.commands.progress import progress
from haptisym.kernel.budget import SECONDS, limited


def limit_option(command: Command) -> Command:
    """The option alone, for a verb whose answer says what is proven so far."""
    return click.option(
        "--limit",
        type=click.FloatRange(min=0, min_open=True, max=1e9),
        default=SECONDS,
        show_default=True,
        metavar="SECONDS",
        help="Time after which what is proven so far is told, and the rest is said to be undecided.",
    )(command)


def within_limit(command: Command) -> Command:
    """The option and its work, for a verb whose answer is whole or none: LimitError when the time is over."""

    @limit_option
    @wraps(command)
    def timed(*args: Any, limit: float, **options: Any) -> Any:
        with progress() as told, limited(limit, told):
            return command(*args, **options)

    return timed
