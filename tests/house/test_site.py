"""The site: it lists every public name, loads nothing from outside, and its scripts run."""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator
from importlib import import_module, util
from inspect import isfunction, signature
from pathlib import Path
from pkgutil import iter_modules
from types import FrameType, ModuleType
from typing import Any

import pytest

import haptisym as hs
from haptisym import figures
from haptisym.figures.plots import KINDS

DOCS = Path(__file__).parents[2] / "docs"


def tool(name: str) -> ModuleType:
    """A module of those that build the site."""
    spec = util.spec_from_file_location(f"site_{name}", DOCS / "building" / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    found = util.module_from_spec(spec)
    spec.loader.exec_module(found)
    return found


def test_the_reference_has_every_public_name_once() -> None:
    api = tool("api")
    listed = [name for page in api.TOPICS for name in api.listed(page)] + [name for _, name in api.MODULES.values()]
    assert sorted(listed) == sorted(hs.__all__)


def test_what_a_page_loads_from_outside_is_found(tmp_path: Path) -> None:
    outside = tool("outside")
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


def run(script: str, monkeypatch: pytest.MonkeyPatch) -> int:
    """Run the cells of a script of the docs, one after the other, each with new figures; how many there are."""
    monkeypatch.syspath_prepend(str(DOCS))
    from make_notebook import cells  # type: ignore[import-not-found]
    from matplotlib import pyplot

    pyplot.switch_backend("agg")
    space: dict[str, Any] = {"__name__": "__main__"}
    codes = [text for kind, text in cells((DOCS / script).read_text(encoding="utf-8")) if kind == "code"]
    for code in codes:
        exec(compile(ast.parse(code), "cell", "exec"), space)  # noqa: S102  the cells are the package's own
        pyplot.close("all")
    return len(codes)


@pytest.mark.slow
def test_every_cell_of_the_how_to_runs(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    assert run("how-to.py", monkeypatch) > 15
    assert "make_notebook" in sys.modules


def drawings() -> Iterator[str]:
    """What draws on axes of a user: each public ``draw_`` function of the figures."""
    for found in iter_modules(figures.__path__):
        module = import_module(f"{figures.__name__}.{found.name}")
        for name, value in vars(module).items():
            own = name.startswith("draw_") and isfunction(value) and value.__module__ == module.__name__
            if own and "ax" in signature(value).parameters:
                yield f"{module.__name__}.{name}"


def test_the_page_of_figures_asks_for_every_kind() -> None:
    tree = ast.parse((DOCS / "plots.py").read_text(encoding="utf-8"))
    asked = {x.value.value for x in ast.walk(tree) if isinstance(x, ast.keyword) and isinstance(x.value, ast.Constant)}
    assert {kind for kinds in KINDS.values() for kind in list(kinds)[1:]} <= asked | {
        "wishes"
    }  # drawn unasked of several


@pytest.mark.slow
def test_the_page_of_figures_calls_every_function_that_draws(monkeypatch: pytest.MonkeyPatch) -> None:
    called = set()

    def noted(frame: FrameType, event: str, _: object) -> None:
        if event == "call" and frame.f_code.co_name.startswith("draw_"):
            called.add(f"{frame.f_globals['__name__']}.{frame.f_code.co_name}")

    before = sys.getprofile()
    sys.setprofile(noted)
    try:
        run("plots.py", monkeypatch)
    finally:
        sys.setprofile(before)
    assert set(drawings()) <= called
