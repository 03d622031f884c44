"""The tutorial runs, cell by cell and as the notebook that it becomes."""

from __future__ import annotations

import ast
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

DOCS = Path(__file__).parents[2] / "docs"
TUTORIAL = DOCS / "tutorial.py"


@pytest.fixture(scope="module")
def notebook(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    target = tmp_path_factory.mktemp("notebook") / "tutorial.ipynb"
    subprocess.run([sys.executable, DOCS / "make_notebook.py", TUTORIAL, target], check=True, capture_output=True)
    return dict(json.loads(target.read_text(encoding="utf-8")))


def test_the_notebook_has_the_tutorials_cells(notebook: dict[str, Any]) -> None:
    text = TUTORIAL.read_text(encoding="utf-8")
    kinds = ["markdown" if "[markdown]" in line else "code" for line in text.splitlines() if line.startswith("# %%")]
    cells = notebook["cells"]
    assert (notebook["nbformat"], notebook["nbformat_minor"]) == (4, 5)
    assert [cell["cell_type"] for cell in cells] == kinds
    assert len({cell["id"] for cell in cells}) == len(cells) > 20
    assert all("outputs" in cell for cell in cells if cell["cell_type"] == "code")
    prose = "".join("".join(cell["source"]) for cell in cells if cell["cell_type"] == "markdown")
    assert prose.startswith("# haptisym in a quarter of an hour\n\nYou write")
    for chapter in (
        "The paper's example",
        "A delay",
        "Your own scene",
        "Formulas",
        "LaTeX, MathML and code",
        "A report",
    ):
        assert f"## {chapter}\n" in prose


@pytest.mark.slow
def test_every_cell_runs_and_most_of_them_show_something(
    notebook: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    space: dict[str, Any] = {"__name__": "__main__"}
    codes = ["".join(cell["source"]) for cell in notebook["cells"] if cell["cell_type"] == "code"]
    shown = [result(code, space) for code in codes]
    rich = [x for x in shown if hasattr(x, "_repr_html_") or hasattr(x, "_repr_latex_")]
    assert len(rich) >= 9
    assert capsys.readouterr().out.startswith(r"\frac{")
    assert [x.name for x in tmp_path.glob("*/*")] == ["tutorial.html"]


def result(code: str, space: dict[str, Any]) -> Any:
    """Run a cell; the value of the expression that ends it, if one does."""
    tree = ast.parse(code)
    last = ast.Expression(tree.body.pop().value) if isinstance(tree.body[-1], ast.Expr) else None
    exec(compile(tree, "cell", "exec"), space)  # noqa: S102  the cells are the package's own
    return eval(compile(last, "cell", "eval"), space) if last else None  # noqa: S307
