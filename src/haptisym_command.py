"""What the shell starts as ``haptisym``: outside the package, so that Ctrl-C is understood while
the package is being loaded."""

from __future__ import annotations

import gc
import os
import signal


def main() -> None:
    """Run the command line. Ctrl-C ends it with status 130 and without a traceback, from the first
    moment to the last."""
    is_ours = (
        signal.getsignal(signal.SIGINT) is signal.default_int_handler
    )  # not so where the shell ignores it for us
    if is_ours:
        signal.signal(signal.SIGINT, _leave)
    gc.disable()  # all that is loaded stays: it need not be looked through, over and over, for what could be thrown away
    from haptisym.cli import main as run

    if is_ours:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        run(_loaded)
    finally:
        if is_ours:
            signal.signal(signal.SIGINT, _leave)


def _loaded() -> None:
    gc.freeze()
    gc.enable()


def _leave(_signal: int, _frame: object) -> None:
    os._exit(130)
