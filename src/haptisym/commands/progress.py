"""The bar of progress of every verb that may take long."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from time import monotonic
from types import TracebackType
from typing import TYPE_CHECKING, Self

import click

if TYPE_CHECKING:
    from rich.progress import Progress

PATIENCE = 0.5  # s; what is done sooner shows no bar


@contextmanager
def progress(unit: str = "", *, kept: str = "there is no answer") -> Iterator[ProgressBar]:
    """A bar on standard error, where that is a terminal: it comes after half a second and leaves nothing behind.

    ``unit`` : of what is counted, as in "1,200 of 65,536 sets"; percent are shown without it.

    ``kept`` : what there is after Ctrl-C, as the end of a sentence that says how far it came.

    What it yields is called with what is done, of how much (None: nobody knows, the bar then shows only that it lives) and, if
    there is something to say, at what it is; as often as one likes. It never raises, and does nothing where nobody looks.

    >>> with progress("sets") as told:
    ...     told(1, 10)
    ...     told(2, None, "the second half")
    """
    context = click.get_current_context(silent=True)
    with ProgressBar(unit) as told:
        if context is not None:
            context.meta[_BAR] = told
        try:
            yield told
        except KeyboardInterrupt:
            raise KeyboardInterrupt(f" at {told.reached}: {kept}" if told.reached else f": {kept}") from None


_BAR = "haptisym.progress"  # under which a call of the command line keeps its bar


def quiet() -> None:
    """Take the bar away for good, as something is about to be printed."""
    context = click.get_current_context(silent=True)
    told = context.meta.pop(_BAR, None) if context is not None else None
    if told is not None:
        told.stop()


class ProgressBar:
    """What ``progress`` yields."""

    def __init__(self, unit: str) -> None:
        self.unit, self.began = unit, monotonic()
        self.seen = bool(sys.stderr and sys.stderr.isatty())
        self.bar: Progress | None = None
        self.reached = ""
        """How far it came, in words."""

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, _kind: type[BaseException] | None, _what: BaseException | None, _at: TracebackType | None
    ) -> None:
        self.stop()

    def stop(self) -> None:
        """The bar leaves, and does not come again."""
        self.seen = False
        if self.bar is not None:
            self.bar.stop()

    def __call__(self, done: float, total: float | None = None, what: str = "") -> None:
        self.reached = self._count(done, total)
        if not self.seen or monotonic() - self.began < PATIENCE or (self.bar is None and done == total):
            return
        if self.bar is None:
            self.bar = _bar()
            self.bar.add_task(what, count="")
            self.bar.start()
        self.bar.update(self.bar.task_ids[0], description=what, count=self.reached)
        self.bar.tasks[0].total = total  # ``update`` takes None for "as before"
        self.bar.update(self.bar.task_ids[0], completed=done)

    def _count(self, done: float, total: float | None) -> str:
        if total is None:
            return f"{_figure(done)} {self.unit}" if self.unit else ""
        if self.unit:
            return f"{_figure(done)} of {_figure(total)} {self.unit}"
        return f"{100 * done / total if total else 100:.0f} %"


def _figure(x: float) -> str:
    return f"{x:,.0f}" if x >= 999.5 else f"{x:.3g}"


def _bar() -> Progress:
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn
    from rich.table import Column

    console = Console(stderr=True)
    roomy = console.width >= 60
    count, what = (
        TextColumn(x, markup=False, table_column=Column(no_wrap=True, overflow="crop"))
        for x in ("{task.fields[count]}", "{task.description}")
    )
    times = (TimeElapsedColumn(), TimeRemainingColumn()) if roomy else ()
    return Progress(BarColumn(30 if roomy else 8), count, *times, what, console=console, transient=True)
