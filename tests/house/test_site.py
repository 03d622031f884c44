"""The site: it lists every public name, loads nothing from outside, and its scripts run."""

from __future__ import annotations

import ast
import sys
from importlib import util
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

import haptisym as hs

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


@pytest.mark.slow
def test_every_cell_of_the_how_to_runs(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    monkeypatch.syspath_prepend(str(DOCS))
    from make_notebook import cells  # type: ignore[import-not-found]

    space: dict[str, Any] = {"__name__": "__main__"}
    script = (DOCS / "how-to.py").read_text(encoding="utf-8")
    codes = [text for kind, text in cells(script) if kind == "code"]
    for code in codes:
        exec(compile(ast.parse(code), "cell", "exec"), space)  # noqa: S102  the cells are the package's own
    assert len(codes) > 15
    assert "make_notebook" in sys.modules
