"""``haptisym`` and ``python -m haptisym``: the command line, with Ctrl-C understood while the
package is being loaded."""

from __future__ import annotations

import gc
import os
import signal


def main() -> None:
    """Run the command line. Ctrl-C ends it with status 130 and without a traceback, from the first
    moment to the last."""
    # Where the shell ignores Ctrl-C for us, or a program has a handler of its own, it stays so.
    is_ours = signal.getsignal(signal.SIGINT) is signal.default_int_handler
    if is_ours:
        signal.signal(signal.SIGINT, _leave)
    # All that is loaded stays: it need not be searched, over and over, for what could be freed.
    gc.disable()
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


if __name__ == "__main__":
    main()
