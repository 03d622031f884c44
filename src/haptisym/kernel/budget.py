"""A limit in time for a question, and the queue of cells of a branch and bound.

Whatever may take long calls ``tick``, which ends it when the time is over, and reports the progress
to a callback. The limit is scoped: ``limited`` sets it for what is called inside and puts back what
was there before. Nothing else reads the clock, and a question that is asked without a limit is cut
short only by ``Budget.stop``. The clock counts the processor time of this process, all of its
threads together, so that an answer does not depend on what else the machine does; ``timed_by`` sets
another one. In a browser, which does not tell processor time, it is the wall clock. What other
processes compute for this one, such as the workers of a sweep, is not counted.

Branch and bound: cells are examined until each is settled; what is not is cut, and its pieces wait
their turn. Every loop of that kind runs on ``Waiting``, so that each has a limit in number and in
time, and says what it leaves open.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from contextvars import ContextVar
from dataclasses import dataclass, field
from heapq import heappop, heappush
from importlib import import_module
from math import isfinite
from os import cpu_count
from threading import Lock
from time import monotonic, process_time
from typing import Any, Generic, NoReturn, TypeAlias, TypeVar

from haptisym.kernel.errors import LimitError, SceneError, UndecidedError

Told: TypeAlias = Callable[[float, float | None, str], None]
"""A callback for progress: called with how much is done, of how much (None: unknown), and a name
for the work."""

SECONDS = 60.0
"""The limit of a question that is asked without one."""
_PAUSE = 0.1  # s, on the wall clock, between two calls of the callback

_PROCESSORS = cpu_count() or 1
_clock: ContextVar[Callable[[], float]] = ContextVar("clock", default=process_time)


@contextmanager
def timed_by(clock: Callable[[], float]) -> Iterator[None]:
    """Limits that are set inside are measured by that clock, in s, and so is the pause between two
    reports.

    A clock that counts its readings is the same on every machine.

    >>> from itertools import count
    >>> with timed_by(count().__next__), limited(3):  # a second passes whenever the clock is read
    ...     left(), left(), left()
    (2, 1, 0)
    """
    mark = _clock.set(clock)
    try:
        yield
    finally:
        _clock.reset(mark)


@dataclass(eq=False)
class Budget:
    """The time that a question may take: ``seconds`` of processor time, None without a limit; and
    the callback ``told`` for its progress.

    ``began``, ``deadline`` : when the limit was set, and when the time is over, by the clock. Of a
    ``share`` of the time the deadline comes before the limit is reached.
    """

    seconds: float | None
    began: float
    deadline: float | None
    told: Told | None = None
    outer: Budget | None = None
    clock: Callable[[], float] = process_time
    stopped: bool = False
    why: str = ""
    """Why something was cut short; empty where nothing was."""
    cut: float | None = None
    """The seconds of the limit that cut something short."""
    _last: tuple[float, float | None, str] = field(default=(0, None, ""), repr=False)
    _next: float = field(default=0.0, repr=False)
    _read: tuple[float, float] | None = field(default=None, repr=False)
    """When the processor time was read last, on the wall clock, and what it was."""

    @property
    def outermost(self) -> Budget:
        """The budget around all others."""
        return self if self.outer is None else self.outer.outermost

    @property
    def reached(self) -> bool:
        """Whether something was cut short."""
        return bool(self.why)

    def stop(self) -> None:
        """End the work at its next tick, with what is proven by then, as at a limit; also from a
        signal or another thread."""
        self.outermost.stopped = True

    def tick(self, done: float | None, total: float | None, what: str) -> None:
        """Raise LimitError when the time is over or the work was stopped; else report the progress
        now and then."""
        now = self.bound()
        if self.outermost.stopped:
            self.end("stopped at the limit (interrupted)")
        if self.deadline is not None and now > self.deadline and self.read() > self.deadline:
            self.end(
                f"stopped at the limit of {self.seconds:g} s; a longer limit may decide it",
                self.seconds,
            )
        # An inner loop without a name leaves the report of the outer one as it is.
        if done is not None and (what or not self._last[2]):
            self._last = done, total, what
        self._tell_now_and_then(now)

    def read(self) -> float:
        """What the clock shows."""
        now = self.clock()
        self._read = monotonic(), now
        return now

    def bound(self) -> float:
        """At least what the clock shows: processor time, which takes long to read, goes on by at
        most the wall clock's time on every processor."""
        if self.clock is not process_time or self._read is None:
            return self.read()
        wall, then = self._read
        return then + _PROCESSORS * (monotonic() - wall)

    def end(self, why: str, cut: float | None = None) -> NoReturn:
        """Raise a LimitError, and remember why."""
        self.why, self.cut = why, cut
        raise LimitError(why)

    def say(self, done: float, total: float | None, what: str) -> None:
        """Report how far the work is; never a LimitError."""
        self._last = done, total, what
        self._tell_now_and_then(self.bound())

    def _tell_now_and_then(self, now: float) -> None:
        # Reports are for a person: their pause is on the wall clock, even while workers compute and
        # this process uses no time. A clock that was set is used as it is, to be reproducible.
        now = monotonic() if self.clock is process_time else now
        if now >= self._next:
            self._next = now + _PAUSE
            self._tell(*self._last)

    def _tell(self, *word: Any) -> None:
        """Pass a report to the nearest callback. A budget around this one repeats its own last
        report, if it has one, in place of one from inside."""
        if self.told is not None:
            self.told(*word)
        elif self.outer is not None:
            self.outer._tell(*(self.outer._last if self.outer._last[2] else word))


_budget: ContextVar[Budget | None] = ContextVar("budget", default=None)


@contextmanager
def limited(seconds: float | None = None, told: Told | None = None) -> Iterator[Budget]:
    """Limit what is called inside to that many seconds of processor time, or to what is left of a
    limit around it, if that is less.

    ``seconds`` : None for no limit of its own.

    >>> with limited(3600) as outer, limited(None) as inner:
    ...     inner.deadline == outer.deadline
    True
    """
    if seconds is not None and not (
        isinstance(seconds, int | float) and isfinite(seconds) and seconds > 0
    ):
        raise SceneError(f"limit: {seconds}: give a number of seconds > 0, or None for no limit")
    outer, clock = _budget.get(), _clock.get()
    now = clock()
    deadline = None if seconds is None else now + seconds
    # ``same`` is the outer budget where its deadline comes first: messages then name its limit, and
    # it counts as cut short as well.
    bound = None if outer is None else outer.deadline
    ends_first = deadline is not None and bound is not None and bound < deadline
    same = outer if deadline is None or ends_first else None
    limit = (same.seconds, same.began, same.deadline) if same else (seconds, now, deadline)
    with _inside(Budget(*limit, told, outer, clock), same) as budget:
        yield budget


@contextmanager
def _inside(budget: Budget, same: Budget | None = None) -> Iterator[Budget]:
    """Make a budget the current one. ``same`` : the budget whose limit, or a share of it, this one
    has; it counts as cut short where this one was."""
    mark = _budget.set(budget)
    try:
        yield budget
    finally:
        _budget.reset(mark)
        if same is not None and budget.why:
            same.why, same.cut = budget.why, budget.cut


def left() -> float | None:
    """Seconds until the time is over, None without a limit."""
    budget = _budget.get()
    if budget is None or budget.deadline is None:
        return None
    return max(budget.deadline - budget.clock(), 0.0)


def spent() -> tuple[float, float] | None:
    """Processor time since the outermost limit was set, and that limit, s; None without one."""
    budget = _budget.get()
    outer = None if budget is None else budget.outermost
    if outer is None or outer.seconds is None:
        return None
    return outer.clock() - outer.began, outer.seconds


def tick(done: float | None = None, total: float | None = None, what: str = "") -> None:
    """Report that the work goes on, and how far it is; LimitError where the time for it is over."""
    budget = _budget.get()
    if budget is not None:
        budget.tick(done, total, what)


def afford(terms: int, others: int = 1) -> None:
    """LimitError if a multiplication of ``terms`` by ``others`` terms, which nothing can interrupt,
    would most likely outlast the limit.

    Dense polynomials are multiplied at about twice ``_PRODUCTS`` products of terms a second, sparse
    ones slower.
    """
    # One call into FLINT cannot be ended by a tick, so that it is better not begun.
    budget = _budget.get()
    if budget is not None and budget.deadline is not None:
        budget.tick(None, None, "")
        seconds = terms * others / _PRODUCTS
        if seconds > budget.deadline - budget.bound() and seconds > budget.deadline - budget.read():
            why = (
                "which formulas as long as these would probably exceed; a longer limit may "
                "decide it"
            )
            budget.end(f"stopped at the limit of {budget.seconds:g} s, {why}", budget.seconds)


def room(terms: int) -> None:
    """LimitError for a polynomial of more than ``MOST_TERMS`` terms, to be called before it is
    computed: memory would not hold it and what follows.

    This holds without a limit in time, too.
    """
    if terms > MOST_TERMS:
        why = (
            f"formulas of {terms:,} terms, which memory would not hold: at most {MOST_TERMS:,} "
            f"are computed with"
        )
        (_budget.get() or Budget(None, 0, None)).end(why)


_PRODUCTS = 5e7  # products of two terms, in a second of processor time
MOST_TERMS = 1_000_000
"""Terms of one polynomial at most. Each takes some hundred bytes, and a quotient needs several such
polynomials."""


T = TypeVar("T")
Left: TypeAlias = dict[str, str]
"""Parts of an answer that were not found in time, each with the reason."""


def in_time(part: Callable[[], T], name: str, left: Left) -> T | None:
    """A part of an answer; None, and the reason in ``left``, where it stays undecided.

    >>> from itertools import count
    >>> left = {}
    >>> with timed_by(count().__next__), limited(0.5):  # a second passes whenever the clock is read
    ...     in_time(tick, "the rest", left)
    >>> left
    {'the rest': 'stopped at the limit of 0.5 s; a longer limit may decide it'}
    """
    try:
        return part()
    except UndecidedError as error:
        left[name] = str(error)
        return None


@contextmanager
def spared() -> Iterator[None]:
    """Suspend the limit for what is called inside, which must be short: it is done even when the
    time is over.

    >>> with limited(1e-9), spared():
    ...     tick()
    """
    mark = _budget.set(None)
    try:
        yield
    finally:
        _budget.reset(mark)


@contextmanager
def share(part: float) -> Iterator[None]:
    """Limit what is called inside to a share of the time that is left, so that another way can be
    tried after it."""
    budget = _budget.get()
    if budget is None or budget.deadline is None:
        yield
        return
    now = budget.clock()
    deadline = now + part * (budget.deadline - now)
    with _inside(
        Budget(budget.seconds, budget.began, deadline, budget.told, budget, budget.clock), budget
    ):
        yield


class _OneThread:
    """A context in which every BLAS has one thread; it counts the calls that are in it now.

    A BLAS has one number of threads for the whole process, and simulations in two threads of a
    program overlap in any order: the first call notes the user's number, the last one restores it.
    """

    def __init__(self) -> None:
        self.lock, self.callers, self.limit = Lock(), 0, ExitStack()

    def __enter__(self) -> None:
        # The extra "simulate" brings threadpoolctl, but nothing fails without it: it is only
        # slower.
        with self.lock, suppress(ImportError):
            self.callers += 1
            if self.callers == 1:
                from threadpoolctl import ThreadpoolController

                # SciPy brings a BLAS of its own, which can be limited only once it is loaded.
                import_module("scipy.linalg")
                self.limit.enter_context(
                    ThreadpoolController().select(user_api="blas").limit(limits=1)
                )

    def __exit__(self, *_: object) -> None:
        with self.lock:
            self.callers -= 1
            if not self.callers:
                self.limit.close()


ONE_THREAD = _OneThread()
"""As a context: every BLAS that threadpoolctl knows (OpenBLAS, MKL, BLIS, FlexiBLAS) has one
thread. Where matrices are small, threads wait for each other, on a busy machine ten and more times
what one takes; results do not depend on it."""


def forget() -> None:
    """Empty all caches of the kernel's functions, so that a measurement of time covers all of the
    work."""
    for name, module in list(sys.modules.items()):
        for found in vars(module).values() if name.startswith(f"{__package__}.") else ():
            if hasattr(found, "cache_clear"):
                found.cache_clear()


C = TypeVar("C")


class Waiting(Generic[C]):
    """The queue of cells that wait to be examined: the best one first, or, without a ``rank``, in
    the order of the domain.

    Iterating gives one after the other, ticks the budget for each, and ends when none waits or
    ``most`` were given. A loop that goes on to the next cell has settled the last one, unless it
    put its pieces back with ``add``, in the order of the domain. The iteration raises LimitError
    when the time is over. ``rest`` holds all that is not settled, also the cell in which a loop was
    left.

    ``rank`` : a key of cells, the least one to be examined first. ``what`` : a name of the work,
    for a progress bar.

    >>> waiting, settled = Waiting([(0, 8)]), []
    >>> for low, high in waiting:
    ...     if high - low > 3:
    ...         waiting.add((low, (low + high) // 2), ((low + high) // 2, high))
    ...     else:
    ...         settled.append((low, high))
    >>> settled
    [(0, 2), (2, 4), (4, 6), (6, 8)]
    """

    def __init__(
        self,
        cells: Iterable[C],
        rank: Callable[[C], Any] | None = None,
        *,
        most: int | None = None,
        what: str = "",
    ) -> None:
        self.examined = 0
        self._rank, self._most, self._what = rank, most, what
        self._heap: list[tuple[Any, int, C]] = []
        self._number = 0
        self._given: list[C] = []
        self.add(*cells)

    def add(self, *cells: C) -> None:
        """Put cells into the queue in place of the one that was given last; of equal ranks the
        first one added comes first."""
        self._given = []
        # Without a rank the heap is a stack: pieces, added in reverse, come before all that waits,
        # so that cells are examined from the low end of the domain to the high one.
        for cell in cells if self._rank else reversed(cells):
            self._number += 1
            order = self._number if self._rank else -self._number
            heappush(self._heap, (self._rank(cell) if self._rank else 0, order, cell))

    def __iter__(self) -> Iterator[C]:
        while self._heap and (self._most is None or self.examined < self._most):
            tick(self.examined, self.examined + len(self._heap), self._what)
            self.examined += 1
            cell = heappop(self._heap)[-1]
            self._given = [cell]
            yield cell
            self._given = []

    @property
    def rest(self) -> list[C]:
        """All cells that are not settled, in no order."""
        return [*self._given, *(cell for _, _, cell in self._heap)]
