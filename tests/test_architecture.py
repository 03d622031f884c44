"""The house: a module imports only from lower ranks, and importing the package costs and changes nothing else."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import haptisym

SOURCE = Path(haptisym.__file__).parent

LAYERS = """
errors symbols typeset.boxes report.html options pruning.suprema
expressions exact.rings exact.reals numeric.values typeset.names formulas.steps codegen.names
quantities exact.response exact.factors typeset.numerals typeset.order codegen.printers codegen.languages
exact.levels
exact.roots exact.solutions typeset.formula typeset.quotients
catalogue jnd exact.stability typeset.layout
environments effects distortion simulation.network
scene crossings interop codegen.code simulation.motions simulation.recordings simulation.propagate simulation.descriptor simulation.fractional simulation.rightmost
peaks codegen.forms formulas.structure formulas.groups bounds pruning.ballchain
formulas.asymptotics simulation.blocks simulation.linear simulation.lockin simulation.results pruning.differences
percepts typeset.plain typeset.mathml typeset.equations pruning.subsets
pruning.relevance
answers scenefile simulation.events simulation.text
text simulation.engine
pruning.text
evaluation codegen.scene simulation.approximations simulation.run
formulas.derivation
formulas.sections
tex.names figures simulation.simulate
simulation.command pruning.figure
simulation.figures commands.effects
tex.printer
tex.lines
tex.results
tex.latex
tex.forms
tex.document report.mathematics formulas.text
report.pdf report.results
report.forms report.figures report.explorer report.scene report.findings
report.page report.notebook
cli
__main__
"""
RANK = {name: rank for rank, layer in enumerate(LAYERS.split("\n")) for name in layer.split()}


MODULES = sorted(path for path in SOURCE.glob("*.py") if path.stem != "__init__")


def imported(path: Path) -> set[str]:
    """The sister modules that a file imports, also inside functions."""
    nodes = [
        n for n in ast.walk(ast.parse(path.read_text(encoding="utf-8"))) if isinstance(n, ast.ImportFrom) and n.level
    ]
    return {n.module or alias.name for n in nodes for alias in n.names} - {"__version__"}


@pytest.mark.parametrize("path", MODULES, ids=lambda p: p.stem)
def test_a_module_imports_only_from_lower_ranks(path: Path) -> None:
    assert path.stem in RANK, f"give {path.stem} a rank"
    for name in imported(path):
        assert RANK[name] < RANK[path.stem], f"{path.stem} imports {name}"


def test_every_rank_names_a_module() -> None:
    assert set(RANK) == {path.stem for path in MODULES}


def test_importing_the_package_loads_no_matplotlib_and_changes_no_global_state() -> None:
    probe = (
        "import sys, numpy, mpmath, flint, sympy\n"
        "x = sympy.Symbol('x')\n"
        "before = (numpy.geterr(), mpmath.mp.prec, flint.ctx.prec, str(x**2 + 1), sympy.latex(x**2 + 1))\n"
        "import haptisym as hs\n"
        "hs.evaluate(hs.load_scene('fu2019')).to_json()\n"
        "after = (numpy.geterr(), mpmath.mp.prec, flint.ctx.prec, str(x**2 + 1), sympy.latex(x**2 + 1))\n"
        "assert before == after\n"
        "assert 'matplotlib' not in sys.modules\n"
    )
    subprocess.run([sys.executable, "-c", probe], check=True)


def test_no_source_evaluates_text_or_simplifies() -> None:
    forbidden = {"eval", "exec", "simplify", "nsimplify", "sympify", "parse_expr"}
    for path in SOURCE.rglob("*.py"):
        calls = [n.func for n in ast.walk(ast.parse(path.read_text(encoding="utf-8"))) if isinstance(n, ast.Call)]
        names = {f.id if isinstance(f, ast.Name) else f.attr if isinstance(f, ast.Attribute) else "" for f in calls}
        assert not names & forbidden, path.name
