"""Linear algebra on one thread for a while: where matrices are small, threads of a BLAS wait for each other most of the time.

On a machine that is busy with something else the wait is nearly all: ten and more times what one thread takes.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from threading import Lock
from typing import Any


class _Limit:
    """How many calls want one thread now, and what gives the user's own number back.

    A BLAS has one number of threads for the whole process. Two simulations in two threads of a user's program overlap in any
    order: only the first may note that number, and only the last may give it back.
    """

    def __init__(self) -> None:
        self.lock = Lock()
        self.callers = 0
        self.limit: AbstractContextManager[Any] = nullcontext()

    def enter(self) -> None:
        with self.lock:
            if not self.callers:
                self.limit = _limited()
                self.limit.__enter__()
            self.callers += 1

    def leave(self) -> None:
        with self.lock:
            self.callers -= 1
            if not self.callers:
                self.limit.__exit__(None, None, None)


_LIMIT = _Limit()


@contextmanager
def one_thread() -> Iterator[None]:
    """Every BLAS that threadpoolctl knows (OpenBLAS, MKL, BLIS, FlexiBLAS) has one thread; the user's number is given back after.

    Without threadpoolctl, or with another BLAS, nothing changes but the time that it takes: results do not depend on it.
    """
    _LIMIT.enter()
    try:
        yield
    finally:
        _LIMIT.leave()


def _limited() -> AbstractContextManager[Any]:
    try:
        from threadpoolctl import ThreadpoolController  # of the extra "simulate", but nothing fails without it
    except ImportError:
        return nullcontext()
    import scipy.linalg  # noqa: F401 - brings a BLAS of its own, which can be limited only once it is there

    # selected first: what is limited is given back whole, and a pool of OpenMP is none of ours
    limit: AbstractContextManager[Any] = ThreadpoolController().select(user_api="blas").limit(limits=1)
    return limit
