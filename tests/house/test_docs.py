"""What the documents claim, checked; what the site is made of; and that every definition says what it is. The site runs its scripts itself."""

from __future__ import annotations

import ast
import doctest
import importlib
import inspect
import json
import os
import pkgutil
import re
import runpy
import shlex
import subprocess
import sys
from collections.abc import Iterator
from importlib import util
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType
from xml.etree import ElementTree

import pytest
from click.testing import CliRunner
from marks import required

import haptisym as hs
import haptisym_check
from haptisym import figures
from haptisym.cli import VERBS, app
from haptisym.figures.files import Drawings
from haptisym.model.catalogue import EFFECTS, ENVIRONMENTS, Model

ROOT = Path(__file__).parents[2]
REFERENCE = (ROOT / "docs" / "scenes.md").read_text(encoding="utf-8")


def test_the_examples_of_the_readme_run() -> None:
    result = doctest.testfile(str(ROOT / "README.md"), module_relative=False)
    assert result.attempted >= 8
    assert result.failed == 0


FILES = {
    name: text
    for path in sorted((ROOT / "docs").glob("*.md"))
    for name, text in re.findall(r"<!-- file: (\S+) -->\n```\w*\n(.*?)```", path.read_text(encoding="utf-8"), re.DOTALL)
}
"""The files that a reader of the pages saves: each in a block after its name."""


@pytest.fixture
def readers_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The working folder, with these files alone."""
    for name, text in FILES.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


PAGES = [path for path in sorted((ROOT / "docs").glob("*.md")) if ">>>" in path.read_text(encoding="utf-8")]


@pytest.mark.slow
@pytest.mark.core
@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.stem)
@pytest.mark.usefixtures("readers_folder")
def test_the_examples_of_a_page_run(page: Path) -> None:
    result = doctest.testfile(str(page), module_relative=False)
    assert result.failed == 0


@pytest.mark.slow
@pytest.mark.parametrize("page", ["start", "scene", "shake", "build", "bench", "paper"])
def test_the_commands_of_the_path_run(page: str, readers_folder: Path) -> None:
    text = (ROOT / "docs" / f"{page}.md").read_text(encoding="utf-8")
    lines = "".join(re.findall(r"^```sh\n(.*?)```", text, re.DOTALL | re.MULTILINE)).replace("\\\n", "").splitlines()
    run = [line for line in lines if not line.startswith("pip ")]
    assert run
    for line in run:
        command, _, target = line.partition(" > ")
        program, *words = shlex.split(command)
        if program == "python":
            subprocess.run([sys.executable, *words], check=True, capture_output=True)
            continue
        assert program == "haptisym"
        done = CliRunner().invoke(app, words)
        assert done.exit_code == 0, f"{line}: {done.output}"
        if target:
            (readers_folder / target).write_text(done.stdout, encoding="utf-8")


assert hs.effects.__name__ < hs.environments.__name__  # asked for, they fill the catalogue


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
    assert "lists 23 to start" in (ROOT / "README.md").read_text(encoding="utf-8")
    assert len(hs.scene_names()) == 23


def test_every_document_that_the_readme_links_is_there() -> None:
    for target in re.findall(r"\]\((?!https?:)([^)#]+)\)", (ROOT / "README.md").read_text(encoding="utf-8")):
        assert (ROOT / target).exists(), target


def test_the_readme_of_a_package_index_has_no_relative_link_where_the_project_has_addresses() -> None:
    required("hatchling, of the extra ci,", find_spec("hatchling"))
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    absolute = script("building/readme.py").absolute
    assert absolute(text, {}, "1.2") == text
    urls = {"Repository": "https://x.org/me/haptisym/", "Documentation": "https://me.x.org/haptisym"}
    made = absolute(text, urls, "1.2")
    assert "![Distortion" in made
    assert "](https://x.org/me/haptisym/raw/v1.2/docs/figures/ratios.svg)" in made
    assert "[how to write them](https://x.org/me/haptisym/blob/v1.2/docs/scene.md)" in made
    assert "[the page with sliders](https://me.x.org/haptisym/try/)" in made
    assert [x for x in re.findall(r"\]\(([^)]+)\)", made) if not x.startswith("https://")] == []


@pytest.mark.slow
def test_the_picture_of_the_house_is_that_of_the_source() -> None:
    house = script("house.py")
    words = [x.strip() for x in ElementTree.parse(ROOT / "docs" / "figures" / "house.svg").getroot().itertext()]
    assert house.description() in words
    drawn = "".join(" ".join(words).split())
    for folder in house.folders():
        assert "".join(house.sentence(folder).split()) in drawn, folder
    inside = {path.name for path in house.SOURCE.iterdir() if list(path.glob("*.py"))}
    assert inside == set(house.folders())


def test_every_page_is_in_the_contents() -> None:
    contents = "".join((ROOT / "docs" / f"{name}.md").read_text(encoding="utf-8") for name in ("index", "reference"))
    for path in (ROOT / "docs").glob("*.md"):
        assert path.stem == "index" or re.search(rf"^(\w+ <)?{path.stem}>?$", contents, re.MULTILINE), path.name


def test_the_readme_names_every_command() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert [name for name in VERBS if f"`{name}" not in text.replace("haptisym ", "")] == []


# The site


def script(name: str) -> ModuleType:
    """A module of those that build the site."""
    spec = util.spec_from_file_location(f"site_{Path(name).stem}", ROOT / "docs" / name)
    assert spec is not None
    assert spec.loader is not None
    found = util.module_from_spec(spec)
    spec.loader.exec_module(found)
    return found


def test_the_reference_has_every_public_name_once() -> None:
    api = script("building/api.py")
    listed = [name for page in api.TOPICS for name in api.listed(page)] + [name for _, name in api.MODULES.values()]
    assert sorted(listed) == sorted(hs.__all__)


def test_a_site_without_the_packages_of_the_browsers_page_says_how_they_are_had(tmp_path: Path) -> None:
    script("building/inbrowser.py").place(tmp_path / "none", tmp_path)
    page = (tmp_path / "try" / "index.html").read_text(encoding="utf-8")
    assert "python docs/building/inbrowser.py build/browser build/site" in page
    assert "<script" not in page
    assert [*script("building/outside.py").outside(tmp_path)] == []


@pytest.mark.parametrize(
    ("does", "status"),
    [("print('npm error code ENOTFOUND'); exit(1)", 69), ("print('npm error code ETARGET'); exit(1)", 1), ("1/0", 1)],
)
def test_a_registry_that_is_out_of_reach_is_told_from_what_is_broken(tmp_path: Path, does: str, status: int) -> None:
    """.ci/run leaves tests out for the one and fails for the other."""
    module = script("building/inbrowser.py")
    with pytest.raises(SystemExit) as stop:
        module.download([sys.executable, "-c", does], tmp_path)
    assert stop.value.code == status
    with pytest.raises(SystemExit) as stop:
        module.download(["no-such-program"], tmp_path)
    assert stop.value.code == module.OUT_OF_REACH == 69
    assert module.download([sys.executable, "-c", "print('a.tgz')"], tmp_path).split() == ["a.tgz"]


def test_what_a_page_loads_from_outside_is_found(tmp_path: Path) -> None:
    outside = script("building/outside.py")
    good = '<a href="https://x.org">x</a><img src="a.png"><link rel="stylesheet" href="_static/a.css">'
    (tmp_path / "good.html").write_text(good)
    assert list(outside.outside(tmp_path)) == []
    bad = (
        '<script src="https://cdn.x.org/a.js">', '<link href="//x.org/a.css">', '<img src="http://x.org/a.png">',
        "<style>@import 'https://x.org/a.css'</style>", "<p style='background: url(https://x.org/a.png)'>", '<iframe src="https://x.org">',
    )  # fmt: skip
    for i, text in enumerate(bad):
        (tmp_path / f"bad{i}.html").write_text(text)
    assert len(list(outside.outside(tmp_path))) == len(bad)


def test_the_page_of_figures_asks_for_every_kind() -> None:
    tree = ast.parse((ROOT / "docs" / "plots.py").read_text(encoding="utf-8"))
    asked = {x.value.value for x in ast.walk(tree) if isinstance(x, ast.keyword) and isinstance(x.value, ast.Constant)}
    modules = [importlib.import_module(f"haptisym.figures.{x.name}") for x in pkgutil.iter_modules(figures.__path__)]
    every = {id(x): x for module in modules for x in vars(module).values() if isinstance(x, Drawings)}
    kinds = {kind for x in every.values() for kind in list(x.kinds)[1:]}
    assert kinds <= asked | {
        "wishes",
        "slices",
        "plane",
        "jnd-square",
    }  # drawn unasked of several, and by their own functions


def test_the_notebook_has_the_scripts_cells(tmp_path: Path) -> None:
    source, target = ROOT / "docs" / "plots.py", tmp_path / "plots.ipynb"
    subprocess.run(
        [sys.executable, ROOT / "docs" / "make_notebook.py", source, target], check=True, capture_output=True
    )
    text, found = source.read_text(encoding="utf-8"), json.loads(target.read_text(encoding="utf-8"))
    kinds = ["markdown" if "[markdown]" in line else "code" for line in text.splitlines() if line.startswith("# %%")]
    cells = found["cells"]
    assert (found["nbformat"], found["nbformat_minor"]) == (4, 5)
    assert [cell["cell_type"] for cell in cells] == kinds
    assert len({cell["id"] for cell in cells}) == len(cells) > 20
    assert all("outputs" in cell for cell in cells if cell["cell_type"] == "code")


# Docstrings


def function_of(member: object) -> object:
    """The function that stands behind a method or a property."""
    for key in ("fget", "func", "__func__"):
        member = getattr(member, key, None) or member
    return member


def modules(package: ModuleType) -> Iterator[ModuleType]:
    """Of a package, however deep, but for what runs when it is imported."""
    for found in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
        if not found.name.endswith("__main__"):
            yield importlib.import_module(found.name)


def definitions(module: ModuleType) -> Iterator[tuple[str, list[object]]]:
    """Public functions, classes and their public methods, each with what may explain it: itself, and the same of its bases."""
    for name, thing in vars(module).items():
        if name.startswith("_") or getattr(thing, "__module__", None) != module.__name__:
            continue
        if inspect.isfunction(thing) or inspect.isclass(thing):
            yield name, [thing]
        for key, member in vars(thing).items() if inspect.isclass(thing) else ():
            function = function_of(member)
            if key.startswith("_") or not inspect.isfunction(function) or function.__module__ != module.__name__:
                continue
            if function.__name__ != "<lambda>":
                yield f"{name}.{key}", [function_of(vars(x)[key]) for x in thing.__mro__ if key in vars(x)]


def told(thing: object) -> bool:
    """Whether it has a docstring of its own: a data class is given its signature."""
    text = getattr(thing, "__doc__", None) or ""
    return bool(text) and not (inspect.isclass(thing) and text.startswith(f"{thing.__name__}("))


def untold(package: ModuleType) -> list[str]:
    """Definitions that neither they themselves nor a base explain."""
    return [
        f"{module.__name__}: {name}"
        for module in modules(package)
        for name, told_by in definitions(module)
        if not any(map(told, told_by))
    ]


@pytest.mark.parametrize("package", [hs, haptisym_check])
def test_each_public_definition_says_what_it_is(package: ModuleType) -> None:
    assert untold(package) == []


REPRODUCTIONS = Path(__file__).parents[2] / "docs" / "reproductions"
INDEX = (REPRODUCTIONS / "index.md").read_text(encoding="utf-8")


@pytest.fixture
def book(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """What the pages import; they are run as scripts of their folder."""
    monkeypatch.syspath_prepend(str(REPRODUCTIONS))
    spec = util.spec_from_file_location("book", REPRODUCTIONS / "book.py")
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


# The derivations are programs that prove something: they must run, and their table of contents must be true.

DERIVATIONS = ROOT / "derivations"
SCRIPTS = sorted(DERIVATIONS.glob("[0-9][0-9]_*.py"))


PAPER = pytest.param(SCRIPTS[0], marks=pytest.mark.core)


@pytest.mark.slow
@pytest.mark.parametrize("script", [PAPER, *SCRIPTS[1:]], ids=lambda x: x.stem)
def test_a_derivation_runs_by_itself(script: Path, tmp_path: Path) -> None:
    """In a fresh interpreter, elsewhere, with its assertions switched on whatever the environment says."""
    environment = {**os.environ, "PYTHONOPTIMIZE": ""}
    done = subprocess.run(
        [sys.executable, script], cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr


BESIDE = [*SCRIPTS, *(p for x in ("benchmarks", "docs") for p in sorted((DERIVATIONS.parent / x).glob("*.py")))]


@pytest.mark.parametrize("script", BESIDE, ids=lambda x: x.stem)
def test_what_a_script_imports_is_there(script: Path) -> None:
    """Each quickly, where running them is slow: a module that moves is missed here first."""
    tree = ast.parse(script.read_text(encoding="utf-8"))
    imports = [x for x in ast.walk(tree) if isinstance(x, ast.ImportFrom) and (x.module or "").startswith("haptisym")]
    for one in imports:
        module = importlib.import_module(one.module)
        for alias in one.names:
            assert hasattr(module, alias.name) or importlib.import_module(f"{one.module}.{alias.name}")


def test_the_readme_lists_exactly_the_derivations() -> None:
    table = (DERIVATIONS / "README.md").read_text(encoding="utf-8")
    listed = re.findall(r"^\| \[`(\d\d_\w+\.py)`\]\(\1\) \|", table, re.MULTILINE)
    assert listed == [script.name for script in SCRIPTS]
    assert listed


@pytest.mark.slow
def test_the_numbers_of_the_paper_are_the_programs() -> None:
    make = runpy.run_path(str(ROOT / "paper" / "make.py"))
    assert make["text"]() == (ROOT / "paper" / "paper.md").read_text(encoding="utf-8")


def test_the_measured_numbers_of_the_pages_are_those_of_the_results() -> None:
    measured = runpy.run_path(str(ROOT / "docs" / "building" / "measured.py"))
    for page, numbers in measured["PAGES"].items():
        text = (ROOT / "docs" / f"{page}.md").read_text(encoding="utf-8")
        assert measured["with_numbers"](page, text) == text, "run python docs/building/measured.py"
        old = text
        for pattern in numbers():
            [found] = re.finditer(pattern, old)
            old = old[: found.start(1)] + "777" + old[found.end(1) :]
        assert old.count("777") == len(numbers())
        assert measured["with_numbers"](page, old) == text
    assert measured["with_numbers"]("theory", "Any other text, 1.5 times.") == "Any other text, 1.5 times."
