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
commands.fitting commands.progress commands.spelling \
errors shown symbols costs.measurement pruning.suprema report.html simulation.network simulation.threads sweeps.batch \
tolerance.taylormodels typeset.boxes
budget commands.streams commands.verb
expressions codegen.names exact.reals exact.rings figures.kinds formulas.steps numeric.accuracy simulation.descriptor \
sweeps.bernstein typeset.names
quantities simulation.rest codegen.printers exact.axis exact.bernstein exact.eliminants exact.zeros numeric.program sensitivities.implicit \
simulation.rightmost sweeps.families tex.names typeset.numerals typeset.order
codegen.languages codegen.short sensitivities.branches exact.dynamics exact.isolation exact.polynomials exact.wavesums numeric.balls numeric.floats \
typeset.formula typeset.quotients
exact.exactwaves
exact.beginnings
codegen.code exact.analytic exact.response numeric.doubled numeric.machine numeric.magnitudes typeset.layout
exact.caches exact.levels exact.periodic exact.solutions numeric.pointvalues numeric.stable requirement.strips \
requirement.touches tex.printer typeset.equations typeset.mathml typeset.plain
properties costs.stopwatch exact.factoring numeric.certified requirement.closedforms tex.lines
exact.roots numeric.values report.mathematics
ranges exact.stability simulation.fractional simulation.motions simulation.propagate
catalogue jnd simulation.frictions simulation.linear simulation.lockin simulation.recordings
distortion effects environments requirement.feasible simulation.blocks simulation.events
crossings interop scene codegen.forms formulas.structure measures.freeresponse measures.twoport requirement.places \
simulation.engine
family.family
scenefile
bounds caveats peaks percepts codegen.scene costs.text formulas.groups measures.forms pruning.ballchain \
simulation.approximations simulation.noise simulation.results tolerance.box
costs.questions formulas.asymptotics pruning.differences requirement.freeparameter simulation.run simulation.text \
sweeps.exactly tolerance.excess
requirement.nearest
commands.options costs.hardcases costs.usual pruning.subsets requirement.cells requirement.criticalvalues \
requirement.required requirement.thresholds simulation.simulate sweeps.axes sweeps.curves tolerance.search
commands.limit commands.scenes costs.hardtext costs.methods pruning.relevance simulation.command sweeps.kernel tolerance.proofs
answers costs.simulated costs.tasks sweeps.blocks tolerance.quantiles
text family.worstcase sweeps.store
family.text pruning.text requirement.text sweeps.designspace sweeps.text tolerance.text
pruning.answers
evaluation requirement.question tolerance.answers
family.evaluation figures.sampling formulas.derivation measures.measured requirement.designmap tex.results
figures.scales formulas.sections measures.disagreements measures.metric report.results sensitivities.slopes tex.latex
figures.style formulas.text measures.text report.design report.findings report.scene sensitivities.text tex.forms
formulas.answers costs.figure costs.hardfigure family.figure figures.nyquist figures.ratios measures.figure pruning.figure requirement.figures \
sensitivities.figure simulation.figures tolerance.figure
commands.derive commands.effects commands.require commands.simulate commands.tolerances costs.costs costs.hardcosts \
figures.projections figures.square measures.transparency report.explorer report.forms report.notebook sensitivities.answers \
sweeps.figure tex.document
commands.cost commands.metrics commands.sensitivity commands.sweep figures.files report.figures
report.pdf
report.page
commands.evaluate
cli
__main__
"""
RANK = {name: rank for rank, layer in enumerate(LAYERS.split("\n")) for name in layer.split()}


MODULES = {
    ".".join(path.relative_to(SOURCE).with_suffix("").parts): path
    for path in sorted(SOURCE.rglob("*.py"))
    if path.stem != "__init__"
}


def imported(name: str) -> set[str]:
    """The sister modules that a module imports, also inside functions."""
    nodes = [n for n in ast.walk(ast.parse(MODULES[name].read_text(encoding="utf-8"))) if isinstance(n, ast.ImportFrom)]
    found = set()
    for node in nodes:
        above = ["haptisym", *name.split(".")][: -node.level] if node.level else []
        base = ".".join([*above, *filter(None, [node.module])])
        if base.split(".")[0] == "haptisym":
            inside = base.removeprefix("haptisym").lstrip(".")
            found |= {inside} if inside in MODULES else {f"{inside}.{x.name}".lstrip(".") for x in node.names}
    return found - {"__version__"}


@pytest.mark.parametrize("name", MODULES)
def test_a_module_imports_only_from_lower_ranks(name: str) -> None:
    assert name in RANK, f"give {name} a rank"
    for other in imported(name):
        assert RANK[other] < RANK[name], f"{name} imports {other}"


def test_every_rank_names_a_module() -> None:
    assert set(RANK) == set(MODULES)


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
