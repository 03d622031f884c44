"""The derivations are programs that prove something: they must run, and their table of contents must be true."""

import ast
import importlib
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

DERIVATIONS = Path(__file__).parents[2] / "derivations"
SCRIPTS = sorted(DERIVATIONS.glob("[0-9][0-9]_*.py"))


PAPER = pytest.param(SCRIPTS[0], marks=pytest.mark.core)


@pytest.mark.slow
@pytest.mark.parametrize("script", [PAPER, *SCRIPTS[1:]], ids=lambda x: x.stem)
def test_a_derivation_runs_by_itself(script, tmp_path):
    """In a fresh interpreter, elsewhere, with its assertions switched on whatever the environment says."""
    environment = {**os.environ, "PYTHONOPTIMIZE": ""}
    done = subprocess.run(
        [sys.executable, script], cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr


BESIDE = [*SCRIPTS, *(p for x in ("benchmarks", "docs") for p in sorted((DERIVATIONS.parent / x).glob("*.py")))]


@pytest.mark.parametrize("script", BESIDE, ids=lambda x: x.stem)
def test_what_a_script_imports_is_there(script):
    """Each quickly, where running them is slow: a module that moves is missed here first."""
    tree = ast.parse(script.read_text(encoding="utf-8"))
    imports = [x for x in ast.walk(tree) if isinstance(x, ast.ImportFrom) and (x.module or "").startswith("haptisym")]
    for one in imports:
        module = importlib.import_module(one.module)
        for alias in one.names:
            assert hasattr(module, alias.name) or importlib.import_module(f"{one.module}.{alias.name}")


def test_the_readme_lists_exactly_the_derivations():
    table = (DERIVATIONS / "README.md").read_text(encoding="utf-8")
    listed = re.findall(r"^\| \[`(\d\d_\w+\.py)`\]\(\1\) \|", table, re.MULTILINE)
    assert listed == [script.name for script in SCRIPTS]
    assert listed
