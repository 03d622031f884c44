"""What the documents claim, checked."""

from __future__ import annotations

import doctest
import importlib.util
import re
from pathlib import Path
from xml.etree import ElementTree

import pytest

import haptisym as hs
from haptisym.cli import VERBS
from haptisym.model.catalogue import EFFECTS, ENVIRONMENTS, Model

ROOT = Path(__file__).parents[2]
REFERENCE = (ROOT / "docs" / "scenes.md").read_text(encoding="utf-8")


def test_the_examples_of_the_readme_run() -> None:
    result = doctest.testfile(str(ROOT / "README.md"), module_relative=False)
    assert result.attempted >= 8
    assert result.failed == 0


PAGES = [path for path in sorted((ROOT / "docs").glob("*.md")) if ">>>" in path.read_text(encoding="utf-8")]


@pytest.mark.few(
    "command-line",
    "evidence",
    "formulas",
    "functions",
    "index",
    "jnd-regions",
    "metrics",
    "psychophysics",
    "scenes",
    "sensitivity",
    "several-environments",
)
@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.stem)
def test_the_examples_of_a_page_run(page: Path) -> None:
    result = doctest.testfile(str(page), module_relative=False)
    assert result.failed == 0


@pytest.mark.parametrize("model", [*ENVIRONMENTS.values(), *EFFECTS.values()], ids=lambda m: m.name)
def test_the_scene_reference_lists_every_model_with_its_parameters(model: Model) -> None:
    [row] = [line for line in REFERENCE.splitlines() if line.startswith(f"| `{model.name}` |")]
    named = re.findall(r"`(\w+)`", row.split("|")[2])
    formulas = any(slot.formula for slot in model.slots.values())
    assert named == [*model.slots, *(["parameters"] if formulas else [])]


def test_the_scene_reference_lists_nothing_else() -> None:
    listed = re.findall(r"^\| `([\w-]+)` \|", REFERENCE, re.MULTILINE)
    assert sorted(set(listed) - {"model"}) == sorted([*ENVIRONMENTS, *EFFECTS])


def test_the_readme_scene_is_the_papers_example() -> None:
    text = re.search(r"```toml\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.DOTALL)
    assert text is not None
    scene, paper = hs.parse_scene(text[1]), hs.load_scene("fu2019")
    assert (scene.environment, scene.effects, scene.band, scene.threshold) == (
        paper.environment,
        paper.effects,
        paper.band,
        paper.threshold,
    )


def test_the_readme_counts_the_scenes_right() -> None:
    assert "twenty to start" in (ROOT / "README.md").read_text(encoding="utf-8")
    assert len(hs.scene_names()) == 20


def test_every_document_that_the_readme_links_is_there() -> None:
    for target in re.findall(r"\]\((?!https?:)([^)#]+)\)", (ROOT / "README.md").read_text(encoding="utf-8")):
        assert (ROOT / target).exists(), target


@pytest.mark.slow
def test_the_picture_of_the_house_is_that_of_the_source() -> None:
    spec = importlib.util.spec_from_file_location("house", ROOT / "docs" / "house.py")
    assert spec is not None
    assert spec.loader is not None
    house = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(house)
    words = [x.strip() for x in ElementTree.parse(ROOT / "docs" / "figures" / "house.svg").getroot().itertext()]
    assert house.description() in words
    drawn = "".join(" ".join(words).split())
    for folder in house.folders():
        assert "".join(house.sentence(folder).split()) in drawn, folder
    inside = {path.name for path in house.SOURCE.iterdir() if list(path.glob("*.py"))}
    assert inside == set(house.folders())


def test_every_page_is_in_the_contents() -> None:
    contents = "".join(
        (ROOT / "docs" / f"{name}.md").read_text(encoding="utf-8") for name in ("index", "reference", "explanation")
    )
    for path in (ROOT / "docs").glob("*.md"):
        assert path.stem == "index" or re.search(rf"^(\w+ <)?{path.stem}>?$", contents, re.MULTILINE), path.name


def test_the_how_to_names_every_verb() -> None:
    script = (ROOT / "docs" / "how-to.py").read_text(encoding="utf-8")
    assert [name for name in VERBS if f"`{name}" not in script] == ["scenes", "schemas"]
    for anchor in re.findall(r"\]\(#([\w-]+)\)", script):
        titles = {
            re.sub(r"[^\w -]", "", x.lower()).replace(" ", "-")
            for x in re.findall(r"^# ## (.+)$", script, re.MULTILINE)
        }
        assert anchor in titles
