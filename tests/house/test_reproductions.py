"""The published numbers, computed again: the table that is committed is what the pages say when they are run."""

from __future__ import annotations

import re
from importlib import util
from pathlib import Path
from types import ModuleType

import pytest

PAGES = Path(__file__).parents[2] / "docs" / "reproductions"
INDEX = (PAGES / "index.md").read_text(encoding="utf-8")


@pytest.fixture
def book(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """What the pages import; they are run as scripts of their folder."""
    monkeypatch.syspath_prepend(str(PAGES))
    spec = util.spec_from_file_location("book", PAGES / "book.py")
    assert spec is not None
    assert spec.loader is not None
    found = util.module_from_spec(spec)
    spec.loader.exec_module(found)
    return found


@pytest.mark.slow
@pytest.mark.core
def test_the_table_is_what_the_pages_compute(book: ModuleType) -> None:
    assert book.index() == INDEX


def test_a_number_agrees_where_it_rounds_to_the_printed_one(book: ModuleType) -> None:
    assert book.number("", "", "7.45", "7.4549").verdict == "agrees"
    assert book.number("", "", "7.45", "7.4551").verdict == "disagrees"
    assert book.number("", "", "8", 7.49).verdict == "disagrees"


def test_every_row_has_a_verdict_and_every_page_says_what_was_read(book: ModuleType) -> None:
    rows = [
        line.split(" | ")[-1] for line in INDEX.splitlines() if line.startswith("| ") and not line.startswith("| **")
    ]
    assert len(rows) > 30
    for verdict in rows[1:]:
        assert re.fullmatch(r"(agrees|disagrees|cannot be compared, because .+) \|", verdict), verdict
    for page in book.pages():
        words = " ".join(x for x in page.read_text(encoding="utf-8").splitlines() if x.startswith("# ")).split()
        assert "Read:" in words, page.name
        assert len(words) < 150, page.name
        assert f"]({page.name})" in INDEX
