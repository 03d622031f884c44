"""The house: imports go one way through its folders, and importing the package costs and changes nothing else."""

from __future__ import annotations

import ast
import sys
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import pytest

import haptisym
import haptisym_check

pytestmark = [pytest.mark.slow, pytest.mark.core]
"""Every run of CI asks them; a user's run of the tests has no use for how the source is written."""

SOURCE = Path(haptisym.__file__).parent
CHECKER = Path(haptisym_check.__file__).parent

FOLDERS = ["kernel", "programs", "model", "judge", "verbs", "writing", "figures", "pages", "commands"]
"""From the ground up; what a folder holds is the sentence in its ``__init__``. Modules beside the folders are the public surface."""
PUBLIC = {"effects", "environments", "interop"}
"""Modules that a user imports by name; they stand with the model."""
SHELL = {"cli", "__main__"}

MODULES = {
    ".".join(path.relative_to(SOURCE).with_suffix("").parts): path
    for path in sorted(SOURCE.rglob("*.py"))
    if path.stem != "__init__"
}


def rank(name: str) -> int:
    """How high a module stands."""
    folder = name.partition(".")[0]
    if folder in SHELL:
        return len(FOLDERS)
    return FOLDERS.index("model" if folder in PUBLIC else folder)


def room(name: str) -> str:
    """The folder of a module; the public modules are in the model's."""
    return "model" if name in PUBLIC else name.rpartition(".")[0]


@dataclass(frozen=True)
class Told:
    """What the tests below ask of a module's text, which is parsed once."""

    imports: tuple[tuple[int, str, tuple[str, ...]], ...]
    """Level, module and names of each ``from ... import``, also inside functions."""
    calls: frozenset[str]
    """The last name of whatever is called."""
    functions: tuple[tuple[str, int], ...]
    """Each function with its size."""


@cache
def told(path: Path) -> Told:
    """What a module says."""
    nodes = list(ast.walk(ast.parse(path.read_text(encoding="utf-8"))))
    called = [n.func for n in nodes if isinstance(n, ast.Call)]
    return Told(
        tuple(
            (n.level, n.module or "", tuple(x.name for x in n.names)) for n in nodes if isinstance(n, ast.ImportFrom)
        ),
        frozenset(f.id if isinstance(f, ast.Name) else f.attr if isinstance(f, ast.Attribute) else "" for f in called),
        tuple((n.name, size(n)) for n in nodes if isinstance(n, ast.FunctionDef)),
    )


def imported(name: str) -> set[str]:
    """The sister modules that a module imports, also inside functions."""
    found = set()
    for level, base, names in told(MODULES[name]).imports:
        assert not level, f"{name}: imports are absolute"
        if base.split(".")[0] == "haptisym":
            inside = base.removeprefix("haptisym").lstrip(".")
            found |= {inside} if inside in MODULES else {f"{inside}.{x}".lstrip(".") for x in names}
    return found - {"__version__"}


@cache
def arrows() -> set[tuple[str, str]]:
    """Which module imports which."""
    return {(name, other) for name in MODULES for other in imported(name)}


def circle(arrows: set[tuple[str, str]]) -> list[str]:
    """What lies on circles of arrows: those that are left when all without an arrow in, or out, were taken away in turn."""
    left = {x for arrow in arrows for x in arrow}
    while True:
        inner = {(a, b) for a, b in arrows if a in left and b in left}
        kept = {a for a, _ in inner} & {b for _, b in inner}
        if kept == left:
            return sorted(left)
        left = kept


def test_modules_import_only_downwards() -> None:
    for name, other in arrows():
        assert other in MODULES, f"{name} imports {other}, which is no module"
        assert rank(other) <= rank(name), f"{name} imports {other}"


def test_no_module_is_imported_in_a_circle() -> None:
    assert circle(arrows()) == []


def test_no_folder_is_imported_in_a_circle() -> None:
    assert circle({(room(a), room(b)) for a, b in arrows() if room(a) != room(b)}) == []


def test_every_folder_says_in_a_sentence_what_it_holds() -> None:
    for folder in {path.parent for path in MODULES.values()} - {SOURCE}:
        [sentence] = ast.parse((folder / "__init__.py").read_text(encoding="utf-8")).body
        assert isinstance(sentence, ast.Expr), folder


def test_the_checker_imports_the_standard_library_alone() -> None:
    for path in CHECKER.glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = [x.name for x in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or "."] if isinstance(node, ast.ImportFrom) else []
            tops = {name.partition(".")[0] for name in names}
            assert tops <= {*sys.stdlib_module_names, "haptisym_check"}, path.name


def size(tree: ast.AST) -> int:
    """How much there is to understand: nodes of the syntax tree, without docstrings and imports."""
    skipped = ast.Import, ast.ImportFrom, ast.alias
    said = sum(2 for n in ast.walk(tree) if isinstance(n, ast.Expr) and isinstance(n.value, ast.Constant))
    return sum(1 for n in ast.walk(tree) if not isinstance(n, skipped)) - said


def size_of(path: Path) -> int:
    """That of a module."""
    return size(ast.parse(path.read_text(encoding="utf-8")))


def test_the_checker_is_read_in_one_sitting() -> None:
    """Scene files apart, with the functions that are made of them; then one file for each kind of rule."""
    sizes = {path.name: size_of(path) for path in CHECKER.glob("*.py")}
    assert sizes.pop("scene.py") < 7900
    assert sizes.pop("delayterms.py") < 4400
    assert sizes.pop("requirement.py") < 2100
    assert sum(sizes.values()) < 8300


def test_no_source_evaluates_text_or_simplifies() -> None:
    forbidden = {"eval", "exec", "simplify", "nsimplify", "sympify", "parse_expr"}
    for path in (*SOURCE.rglob("*.py"), *CHECKER.rglob("*.py")):
        assert not told(path).calls & forbidden, path.name


MOST_OF_A_FUNCTION, MOST_OF_A_MODULE = 800, 9600
"""Lines may grow as they will: what counts is how much there is to understand."""


def test_a_function_is_understood_as_a_whole() -> None:
    large = {
        f"{x.relative_to(SOURCE.parent)}: {name}": n
        for x in (*SOURCE.rglob("*.py"), *CHECKER.rglob("*.py"))
        for name, n in told(x).functions
        if n > MOST_OF_A_FUNCTION
    }
    assert large == {}


def test_a_module_is_read_in_a_sitting() -> None:
    paths = (*SOURCE.rglob("*.py"), *CHECKER.rglob("*.py"))
    sizes = {x.name: size_of(x) for x in paths}
    assert {name: n for name, n in sizes.items() if n > MOST_OF_A_MODULE} == {}


# Tests stand at seams


TESTS = Path(__file__).parents[1]


def is_private(name: str) -> bool:
    return name.startswith("_") and not name.startswith("__")


def test_tests_ask_what_a_neighbour_could_ask() -> None:
    """They import no underscore name and patch nothing of the package."""
    for path in sorted(TESTS.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("haptisym"):
                assert not [x.name for x in node.names if is_private(x.name)], path
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr == "setattr":
                place = ast.unparse(node.args[0]).split(".")[0] if node.args else ""
                assert place.strip("'\"") not in {"hs", "haptisym"}, path


def test_each_file_of_tests_has_a_name_of_its_own() -> None:
    paths = [x for x in TESTS.rglob("*.py") if x.name != "__init__.py"]
    assert len({x.name for x in paths}) == len(paths)
