"""Options that several verbs of the command line share."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import click


def json_option(command: Callable[..., Any]) -> Callable[..., Any]:
    """The option ``--json``, alike on every verb."""
    return click.option("--json", "as_json", is_flag=True, help="Print one JSON document and nothing else.")(command)


def environment_option(command: Callable[..., Any]) -> Callable[..., Any]:
    """The option ``--environment NAME``, alike on every verb that evaluates one environment at a time."""
    return click.option(
        "--environment", "environment", metavar="NAME", help="Of a scene with several environments, only this one."
    )(command)
