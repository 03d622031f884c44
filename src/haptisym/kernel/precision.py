"""How precision is raised, and where it ends: a question about balls is asked with twice as many bits until it has an answer."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import flint

from haptisym.kernel.budget import tick

T = TypeVar("T")

MOST_BITS = 1 << 13
"""Where a question that may have no answer is given up as undecided: whether a number or an analytic function is 0."""
SURE_BITS = 1 << 20
"""Where a question that has an answer for certain is: algebraic numbers always show that they differ; it bounds our mistakes."""


def at_rising_precision(ask: Callable[[int], T | None], first: int = 128, most: int = MOST_BITS) -> T | None:
    """The first answer there is, asked at working precisions of ``first``, twice that, ... bits; None if none up to ``most``.

    >>> at_rising_precision(lambda bits: None if bits < 1000 else bits)
    1024
    """
    bits = first
    while bits <= most:
        with flint.ctx.workprec(bits):
            answer = ask(bits)
        if answer is not None:
            return answer
        bits *= 2
        tick()
    return None
