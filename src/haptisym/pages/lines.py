"""Words and tables of pages of text."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from decimal import ROUND_CEILING, Context
from io import StringIO
from math import inf, pi
from textwrap import fill

from sympy import Expr

from haptisym.kernel.reals import RealNumber
from haptisym.kernel.roots import Interval

WIDTH = 96
_DIGITS = 5  # of frequencies in sentences; the table of crossings shows all that were asked for


def rounded_up(value: float) -> str:
    """Three digits, rounded up, so that a bound stays one."""
    if value == inf:
        return "unbounded"
    return f"{Context(prec=3, rounding=ROUND_CEILING).create_decimal_from_float(value):.3g}"


def span(x: Interval) -> str:
    if x.low is x.high:
        return f"at {both(x.low.omega)} alone"
    return f"from {short(x.low.omega)} to {short(x.high.omega)} rad/s"


def caveats_text(caveats: Iterable[str]) -> str:
    """What the answers do not say, a paragraph each."""
    return "\n".join(fill(f"But: {caveat}", WIDTH) for caveat in caveats)


def listed(items: Iterable[str], word: str = "and") -> str:
    """Items in a sentence: "one, two and three"."""
    *first, last = [*items] or [""]
    return f"{', '.join(first)} {word} {last}" if first else last


def both(x: RealNumber) -> str:
    """A frequency in rad/s and Hz."""
    return f"{short(x)} rad/s ({_hertz(x)} Hz)"


def short(x: RealNumber) -> str:
    """A number with the digits that a sentence takes."""
    return _trimmed(x.digits(_DIGITS))


def _hertz(x: RealNumber) -> str:
    return f"{float(x) / (2 * pi):.5g}"


def _trimmed(digits: str) -> str:
    return digits.rstrip("0").rstrip(".") if "." in digits and "E" not in digits else digits


def percent(c: Expr) -> str:
    return f"{float(100 * c):.6g} %"


def table(headings: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table as lines of text."""
    from rich import box  # Rich is loaded only where a page of text is wanted
    from rich.console import Console
    from rich.table import Table

    made = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, padding=(0, 2, 0, 0))
    for heading in headings:
        made.add_column(heading, overflow="fold")
    for row in rows:
        made.add_row(*row)
    console = Console(file=StringIO(), width=WIDTH - 2, color_system=None, legacy_windows=False)
    with console.capture() as captured:
        console.print(made)
    return "\n".join(f"  {line}".rstrip() for line in captured.get().rstrip("\n").splitlines())
