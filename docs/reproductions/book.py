"""What the pages of reproductions share: a row for each published result, and one table of them all.

``python docs/reproductions/book.py`` runs every page and writes the table to ``index.md``; a slow test fails when a row changes.
"""

from __future__ import annotations

import re
import runpy
import sys
from collections.abc import Iterable, Iterator
from decimal import Decimal
from pathlib import Path
from typing import NamedTuple

HERE = Path(__file__).parent
HEAD = "| published result | where | published | computed | difference | verdict |\n|---|---|---|---|---|---|"


class Row(NamedTuple):
    """A published result beside the same computed here."""

    result: str
    where: str
    published: str
    computed: str
    difference: str
    verdict: str


class Table(tuple[Row, ...]):
    """Rows, shown as a table."""

    __slots__ = ()

    def _repr_markdown_(self) -> str:
        return "\n".join([HEAD, *(f"| {' | '.join(row)} |" for row in self)])


def number(result: str, where: str, published: str, computed: object, unit: str = "") -> Row:
    """Agrees where the computed number, rounded to the digits that are printed, is the published one.

    >>> number("onset", "section 3", "8", 7.97891679, "rad/s")[3:]
    ('7.97891679 rad/s', '-0.26 %', 'agrees')
    """
    printed, found = Decimal(published), float(str(computed))
    agrees = abs(Decimal(repr(found)) - printed) <= Decimal(1).scaleb(int(printed.as_tuple().exponent)) / 2
    verdict = "agrees" if agrees else "disagrees"
    return Row(
        result,
        where,
        f"{published} {unit}".strip(),
        f"{found:.10g} {unit}".strip(),
        _apart(found, float(published)),
        verdict,
    )


def _apart(found: float, published: float) -> str:
    """The difference, relative to what is published."""
    off = found / published - 1
    if found == published or abs(off) < 1e-5:
        return "0" if found == published else "< 0.001 %"
    return f"{found / published:.3g} times" if off > 9 else f"{100 * off:+.2g} %"


def statement(result: str, where: str, published: str, computed: str, holds: bool, difference: str = "") -> Row:  # noqa: FBT001
    """A result in words: agrees where it holds here."""
    return Row(result, where, published, computed, difference, "agrees" if holds else "disagrees")


def apart(result: str, where: str, published: str, computed: str, because: str) -> Row:
    """What cannot be compared, and the reason."""
    return Row(result, where, published, computed, "", f"cannot be compared, because {because}")


def pages() -> list[Path]:
    """All pages, in the order of their names."""
    return [path for path in sorted(HERE.glob("*.py")) if path != Path(__file__)]


def title(page: Path) -> str:
    """The heading of a page."""
    found = re.search(r"^# # (.*)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    assert found is not None
    return found[1]


def rows(page: Path) -> Table:
    """The rows of a page, by running it."""
    return Table(runpy.run_path(str(page))["rows"])


def _lines(listed: Iterable[Path]) -> Iterator[str]:
    for page in listed:
        yield f"| **[{title(page)}]({page.name})** | | | | | |"
        yield from (f"| {' | '.join(row)} |" for row in rows(page))


def index() -> str:
    """The page of all results, made by running all pages."""
    lead = (
        "After this page you know which published numbers haptisym reproduces, and which it does not. Each page computes its rows "
        "when the site is built, and says how far its source was read. A number agrees where it is the published one when rounded "
        "to the digits that are printed.\n\n`python docs/reproductions/book.py` makes this table by running the pages; a test fails "
        "when a row changes.\n"
    )
    names = "\n".join(page.stem for page in pages())
    contents = f"```{{toctree}}\n:hidden:\n:maxdepth: 1\n\n{names}\n```\n"
    return "\n".join(["# Reproductions\n", lead, HEAD, *_lines(pages()), "", contents])


if __name__ == "__main__":
    sys.path.insert(0, str(HERE))
    (HERE / "index.md").write_text(index(), encoding="utf-8")
