"""What CONTRIBUTING.md promises: its files and tests are there, and what is added half fails."""

from __future__ import annotations

import ast
import re
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import get_args

import pytest
from schemas import IS_THERE, faults
from sympy import Symbol

import haptisym as hs
from haptisym.model.jnd import Shape
from haptisym.model.scenefile import read_any
from haptisym.verbs.require.required import WISHES
from haptisym.writing import document as model
from haptisym.writing import html, latex, plain
from haptisym.writing.layout import named

ROOT = Path(__file__).parents[2]
TEXT = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
DOCS = {path.stem: path.read_text(encoding="utf-8") for path in (ROOT / "docs").glob("*.md")}

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


def test_whatever_takes_a_document_to_write_it_is_a_writer_here() -> None:
    """But for the module of reports, which puts what they write into files."""
    folders = (Path(hs.__file__).parent / name for name in ("writing", "pages"))
    takers = {
        f"haptisym.{path.parent.name}.{path.stem}"
        for path in (path for folder in folders for path in folder.glob("*.py"))
        for x in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(x, ast.arg) and x.annotation and re.fullmatch(r"(\w+\.)?Document", ast.unparse(x.annotation))
    }
    assert takers == {"haptisym.pages.report", *(x.__module__ for x in WRITERS.values())}


def test_every_shape_of_the_region_has_an_example_and_is_in_the_schema() -> None:
    [table] = re.findall(r"\n\| `jnd = ` \|.*?\n\|-.*?\n(.*?)\n\n", DOCS["jnd-regions"], re.DOTALL)
    shown = [x for row in table.splitlines() for x in re.findall("`([^`]+)`", row.split("|")[1])]
    examples = [tomllib.loads(f"jnd = {x}")["jnd"] for x in shown]
    paper = hs.load_scene("fu2019")
    answers = [hs.evaluate(hs.Scene(paper.environment, paper.effects, paper.band, jnd)) for jnd in examples]
    assert {x.scene.threshold.region.shape for x in answers} == set(Shape)
    assert not IS_THERE or [fault for x in answers for fault in faults(x.to_dict())] == []


TABLES = {
    "scenes": ["", "[evaluation]", "[evaluation.friction]", "[device]", "[hand]"],
    "jnd-regions": [f'[evaluation.jnd]\nshape = "{x.value}"' for x in Shape],
    "reference-measured": ["[perceived]"],
}
"""The tables of a scene file, by the page that explains their keys; those of models are in tests/house/test_docs.py."""


@pytest.mark.parametrize("page", TABLES)
def test_every_key_of_a_scene_file_is_documented(page: str) -> None:
    """An unknown key is refused with all that are known."""
    code = " ".join(re.findall(r"```.*?```|`[^`]+`", DOCS[page], re.DOTALL))
    for table in TABLES[page]:
        with pytest.raises(hs.SceneError, match='unknown key "nothing".*valid are ') as refused:
            read_any(f'environment = {{ model = "kelvin-voigt", k = 1, b = 1 }}\n{table}\nnothing = 1', ROOT)
        keys = str(refused.value).rpartition("valid are ")[2].split(", ")
        assert [x for x in keys if not re.search(rf"(?<![\w-]){x}(?![\w-])", code)] == [], table


@pytest.mark.parametrize("wish", WISHES)
def test_every_wish_is_answered_documented_and_in_the_schema(wish: str) -> None:
    found = hs.require(
        "fu2019", "omega_n", (50, 500), that=(wish,), hand="postural-arm" if wish in ("stable", "steady") else None
    )
    document = found.to_dict()
    assert document["criteria"] == [wish]
    assert f"--that {wish}" in DOCS["reference-requirements"]
    assert not IS_THERE or faults(document) == []
    assert {x["criterion"] for x in document["binding"]} <= {wish}
