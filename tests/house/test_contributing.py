"""What CONTRIBUTING.md promises: its files and tests are there, and what is added half fails."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import get_args

import pytest
from schemas import IS_THERE, faults
from sympy import Symbol

import haptisym as hs
from haptisym.verbs.require.required import WISHES
from haptisym.writing import document as model
from haptisym.writing import html, latex, plain
from haptisym.writing.layout import named

ROOT = Path(__file__).parents[2]
TEXT = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
DOCUMENTS = (ROOT / "docs" / "reference-requirements.md").read_text(encoding="utf-8")

WRITERS: dict[str, Callable[[model.Document], str]] = {
    "plain": plain.plain,
    "latex": latex.latex,
    "html": html.fragment,
}
"""Each writer of pages; a new one stands here."""
BLOCKS: dict[type, model.Block] = {
    model.Paragraph: model.Paragraph("word"),
    model.Notes: model.Notes(("word",)),
    model.Facts: model.Facts((("key", "word"),)),
    model.Flow: model.Flow(("one", "word")),
    model.Table: model.Table((model.Column("heading"),), (("word",),)),
    model.Equations: model.Equations((model.Line(named("word"), Symbol("x", positive=True)),)),
    model.Versions: model.Versions((model.Paragraph("word"),), lambda: [model.Paragraph("word")]),
    model.Section: model.Section("title", (model.Paragraph("word"),)),
}
"""One of each kind of block; what only a report has (``Figure``, ``Live``) is not among them."""


def test_the_files_and_tests_that_are_named_are_there() -> None:
    named_ones = re.findall(r"`((?:src|tests|docs|derivations|\.ci)[\w/.*-]+)(?:::(\w+))?`", TEXT)
    assert len(named_ones) > 25
    for path, test in named_ones:
        found = list(ROOT.glob(path)) if "*" in path else [ROOT / path]
        assert found, path
        assert found[0].exists(), path
        if test:
            assert f"def {test}(" in found[0].read_text(encoding="utf-8"), f"{path}::{test}"


def test_there_is_a_sample_of_every_block() -> None:
    assert set(BLOCKS) | {model.Figure, model.Live, model.Formulas} == set(get_args(model.Block))


@pytest.mark.parametrize("writer", WRITERS)
@pytest.mark.parametrize("kind", BLOCKS, ids=lambda kind: kind.__name__)
def test_every_writer_writes_every_block_with_its_words(writer: str, kind: type) -> None:
    text = WRITERS[writer](model.Document("A title", (), (BLOCKS[kind],)))
    assert "word" in text
    assert "A title" in text


@pytest.mark.parametrize("wish", WISHES)
def test_every_wish_is_answered_documented_and_in_the_schema(wish: str) -> None:
    found = hs.require(
        "fu2019", "omega_n", (50, 500), that=(wish,), hand="postural-arm" if wish in ("stable", "steady") else None
    )
    document = found.to_dict()
    assert document["criteria"] == [wish]
    assert f"--that {wish}" in DOCUMENTS
    assert not IS_THERE or faults(document) == []
    assert {x["criterion"] for x in document["binding"]} <= {wish}
