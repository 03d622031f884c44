"""What a user sees of the package: every public name in ``dir``, ``help``, completion and for a type checker."""

from __future__ import annotations

import ast
import importlib
import os
import pydoc
import re
import subprocess
import sys
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path

import pytest
from marks import required

import haptisym as hs

STUB = files("haptisym") / "__init__.pyi"
MYPY = "mypy, of the extra ci,"
DOCS = [Path(__file__).parents[2] / "README.md", *(Path(__file__).parents[2] / "docs").glob("*.md")]


def stubbed() -> dict[str, str]:
    """The names of the stub, and the modules that it has them from."""
    tree = ast.parse(STUB.read_text(encoding="utf-8"))
    found = {}
    for node in tree.body:
        if isinstance(node, ast.ImportFrom):
            found |= {x.name: node.module or "" for x in node.names}
    return found


def listed_in_stub() -> list[str]:
    tree = ast.parse(STUB.read_text(encoding="utf-8"))
    [found] = [node.value for node in tree.body if isinstance(node, ast.Assign)]
    return list(ast.literal_eval(found))


def python(*arguments: str) -> str:
    """What a fresh interpreter prints."""
    done = subprocess.run([sys.executable, *arguments], capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.mark.parametrize("name", hs.__all__)
def test_a_public_name_is_listed_and_means_what_type_checkers_are_told(name: str) -> None:
    assert name in dir(hs)
    module = stubbed()[name]
    source = importlib.import_module(module if module != "haptisym" else f"haptisym.{name}")
    assert getattr(hs, name) is (source if module == "haptisym" else getattr(source, name))


def test_the_stub_lists_the_same_names_as_the_package() -> None:
    assert listed_in_stub() == hs.__all__ == sorted(set(hs.__all__))
    assert set(stubbed()) == set(hs.__all__)
    assert isinstance(hs.__version__, str)


def test_type_checkers_are_told_to_read_the_package() -> None:
    assert (files("haptisym") / "py.typed").is_file()
    assert STUB.is_file()


def test_a_star_import_brings_every_public_name() -> None:
    names: dict[str, object] = {}
    exec("from haptisym import *", names)  # noqa: S102 - the statement is the test
    assert set(hs.__all__) <= set(names)


def test_a_name_that_does_not_exist_is_an_attribute_error_that_says_so() -> None:
    with pytest.raises(AttributeError, match="'haptisym' has no attribute 'evaluat'"):
        _ = hs.evaluat  # type: ignore[attr-defined]


def test_every_name_that_the_documents_use_is_public() -> None:
    used = {name for path in DOCS for name in re.findall(r"\bhs\.(\w+)", path.read_text(encoding="utf-8"))}
    assert used - {"__version__"} <= set(hs.__all__)
    assert len(used) > 30


@pytest.mark.slow
def test_help_shows_every_public_name_also_without_the_optional_packages() -> None:
    script = """
import sys
for name in ("scipy", "threadpoolctl", "xarray", "dask", "distributed", "zarr", "numba"):
    sys.modules[name] = None
import pydoc
import haptisym as hs
print(pydoc.plain(pydoc.render_doc(hs)))
"""
    text = python("-c", script)
    for name in hs.__all__:
        assert re.search(rf"^ *(class )?{name}\b", text, re.MULTILINE), name


def test_help_of_a_verb_is_its_data_sheet() -> None:
    text = pydoc.plain(pydoc.render_doc(hs.require))
    assert "The values of one parameter" in text
    assert "path" in text


@pytest.mark.slow
def test_completion_offers_what_is_loaded_on_demand() -> None:
    script = """
import rlcompleter
import haptisym as hs
completer = rlcompleter.Completer({"hs": hs})
found = []
while (word := completer.complete("hs.re", len(found))) is not None:
    found.append(word)
print(*found)
"""
    assert {"hs.require(", "hs.relevance(", "hs.recording("} <= set(python("-c", script).split())


@pytest.mark.slow
def test_importing_the_package_loads_nothing_that_only_some_verbs_need() -> None:
    script = "import sys, haptisym; print(*sorted({x.partition('.')[0] for x in sys.modules}))"
    loaded = set(python("-c", script).split())
    assert not loaded & {"matplotlib", "xarray", "zarr", "numba", "rich", "click", "IPython"}


@pytest.mark.slow
def test_importing_the_package_loads_no_verb_but_evaluate() -> None:
    script = "import sys, haptisym; print(*sorted(x for x in sys.modules if x.startswith('haptisym.')))"
    loaded = [x.removeprefix("haptisym.") for x in python("-c", script).split()]
    assert not [
        x
        for x in loaded
        if x.startswith(("verbs.", "commands", "figures", "pages", "writing")) and not x.startswith("verbs.evaluate")
    ]


@pytest.mark.slow
def test_a_document_on_the_command_line_loads_neither_writers_nor_other_verbs() -> None:
    script = """
import contextlib, io, sys
sys.argv = ["haptisym", "evaluate", "fu2019", "--json"]
from haptisym.cli import main
with contextlib.redirect_stdout(io.TextIOWrapper(io.BytesIO())), contextlib.suppress(SystemExit):
    main()
print(*sorted(sys.modules))
"""
    loaded = set(python("-c", script).split())
    ours = {x.removeprefix("haptisym.") for x in loaded if x.startswith("haptisym.")}
    assert "judge.evaluation" in ours
    assert not [x for x in ours if x.startswith(("pages", "writing", "figures.style"))]
    assert {x for x in ours if x.startswith("verbs.")} == {"verbs.evaluate", "verbs.evaluate.entry"}
    assert not ours & {"commands.sweep", "commands.simulate", "programs.program"}
    assert not loaded & {"multiprocessing", "pint", "numpy", "matplotlib", "rich", "IPython"}


USER = '''
"""A user's script with every verb."""

from pathlib import Path

import haptisym as hs


def answers(path: Path) -> list[str]:
    scene: hs.Scene = hs.load_scene("fu2019")
    own = hs.Scene(
        hs.environments.mass_spring_damper("1.8 kg", 15, 100),
        (hs.effects.first_order_lag("3 Hz"), hs.effects.shunt(m="10 g")),
        ("0 rad/s", "15 rad/s"),
        hs.Threshold.of("0.1", 0.12),
        title="own",
    )
    e: hs.Evaluation = hs.evaluate(scene, 20)
    crossings: tuple[hs.Crossing, ...] = e.crossings
    width: hs.RealNumber | None = e.bandwidth
    spans: tuple[hs.Interval, ...] = e.transparent
    felt: list[tuple[hs.Part | None, hs.Property, hs.Change]] = [(p.part, p.property, p.change) for p in e.percepts]
    points: tuple[hs.Point, ...] = e.changeovers_perceived
    kinds: set[hs.CrossingKind] = {x.kind for x in crossings}
    high: tuple[hs.Peak, ...] = hs.peaks(own)
    derived: hs.Derivation = hs.derive(scene, keep=["m"])
    needed: hs.Requirement = hs.require(Path("own.toml"), "effects.filter.omega_n", (50, "200 rad/s"), part=hs.Part.REAL)
    design: hs.DesignMap = hs.design_map(scene, ["zeta", "omega_n"], [(0.4, "0.6"), (50, 500)], slices=3)
    slopes: hs.Sensitivities = hs.sensitivity(scene)
    boxes: hs.Tolerances = hs.tolerances(hs.load_scene("fu2019-tolerances"), samples=0)
    person: hs.Psychometric = hs.jnd("answers.csv", reference=5, lapse=None)
    known: hs.PublishedThresholds = hs.published()
    first: hs.Published = known[0]
    kept: hs.Relevance = hs.relevance(scene, "1 %")
    measures: hs.Metrics = hs.metrics("fu2019")
    costs: hs.Cost = hs.cost(scene, quick=True)
    harder: hs.HardCosts = hs.hard_costs(told=lambda what, share: None)
    simulated: hs.Cost = hs.simulation_cost(scene, quick=True)
    swept: hs.Cost = hs.sweep_cost(scene, ["omega_n"], quick=True)
    run: hs.Simulation = hs.simulate(scene, hs.sine(1, 3), extras=(hs.EncoderQuantisation(1e-6), hs.ForceSaturation(50)))
    both: tuple[hs.Simulation, ...] = hs.check(scene, amplitude="1 cm", count=3)
    motions = [hs.multisine(0.01, [1, 2]), hs.chirp(0.01, 1, 10, 5)]
    family: hs.SceneFamily = hs.load_scenes("fu2019", ["fu2019", "helicopter-cyclic"])
    together: hs.FamilyEvaluation = hs.evaluate_all(family)
    arm: hs.Hand = hs.hands["postural-arm"]
    let_go: hs.Release = hs.release(scene, "1 cm", arm)
    shakes: hs.Stability = hs.stability(scene, [arm, "firm-grip", hs.Hand("own", m="0.5 kg")])
    lines: hs.Measurement = hs.measured([1.0, 2.0], [99 + 2j, 98 + 4j], coherence=[0.9, 0.9], averages=10)
    exact: hs.Measurement = hs.sampled(scene, [1.0, 2.0])
    bench: hs.MeasuredEvaluation = hs.evaluate(hs.MeasuredScene(hs.environments.kelvin_voigt(100, 2), lines))
    recorded: hs.Measurement = hs.estimated([0.0, 1.0], [0.0, 100.0], "1 kHz", estimator="H2", segment="1 s")
    fitted: hs.Identification = hs.identify(recorded, "kelvin-voigt", ["shunt:m", "delay"], band=("1 Hz", 20))
    sets = hs.sweep(scene, {"effects.filter.omega_n": [60, 80]})
    code: str = hs.scene_code(scene, hs.Language.NUMPY) + hs.distortion_code(scene.distortion(), hs.Language.C)
    d: hs.Distortion = hs.distort(hs.environments.mass_spring_damper(*hs.symbols("m b k")), hs.effects.delay("5 ms"))
    f = d.compile(hs.Accuracy.FAST)
    written: list[str] = [hs.latex(e), hs.latex(d), hs.mathml(d), e.to_json(), code, str(together), str(hs.omega + hs.s)]
    try:
        hs.parse_scene("nonsense")
    except hs.SceneError as error:
        written.append(str(error))
    shown: list[object] = [width, spans, felt, points, kinds, high, derived, needed, design, slopes, boxes, kept]
    shown += [person, known, first, measures, shakes, costs, harder, simulated, run, let_go, both, motions, sets, f, bench, exact, fitted]
    return [*written, *map(str, shown), str(path)]
'''


def typed(source: str, folder: Path) -> str:
    """What mypy, with the user's own strict settings, says about a script that imports the installed package."""
    required(MYPY, find_spec("mypy"))
    (folder / "script.py").write_text(source, encoding="utf-8")
    (folder / "mypy.ini").write_text("[mypy]\nstrict = True\n", encoding="utf-8")
    environment = {key: value for key, value in os.environ.items() if key != "MYPYPATH"}
    done = subprocess.run(
        [sys.executable, "-m", "mypy", "--cache-dir", str(folder / "cache"), "script.py"],
        cwd=folder, env=environment, capture_output=True, text=True, check=False, timeout=600,
    )  # fmt: skip
    return done.stdout + done.stderr


@pytest.mark.slow
def test_a_users_script_with_every_verb_is_well_typed(tmp_path: Path) -> None:
    assert "Success: no issues found" in typed(USER, tmp_path)


@pytest.mark.slow
def test_a_users_mistakes_are_found_by_a_type_checker(tmp_path: Path) -> None:
    wrong = (
        "import haptisym as hs\nhs.require(1.5, part='real')\nhs.nothing\nlen(hs.metrics(hs.load_scene('fu2019')))\n"
    )
    found = typed(wrong, tmp_path)
    assert {int(line.split(":")[1]) for line in found.splitlines() if " error: " in line} == {2, 3, 4}


def test_a_users_script_uses_every_function_and_type() -> None:
    used = set(re.findall(r"\bhs\.(\w+)", USER))
    spared = "Effect Environment ExpressionError HaptisymError Peaks Percept UndecidedError family_names interop json_schema parse_scenes recording"
    assert used <= set(hs.__all__)
    assert set(hs.__all__) - used == {*spared.split(), "scene_names"}


@pytest.mark.slow
def test_stub_and_package_agree_by_the_type_checkers_own_test(tmp_path: Path) -> None:
    required(MYPY, find_spec("mypy"))
    (tmp_path / "mypy.ini").write_text(
        "[mypy]\nignore_missing_imports = True\nfollow_imports = skip\n", encoding="utf-8"
    )
    done = subprocess.run(
        [sys.executable, "-m", "mypy.stubtest", "haptisym", "--concise", "--mypy-config-file", str(tmp_path / "mypy.ini")],
        cwd=tmp_path, capture_output=True, text=True, check=False, timeout=600,
    )  # fmt: skip
    lines = (done.stdout + done.stderr).splitlines()
    assert lines
    # what lies below the top level is not written twice: stubs are the sources themselves there
    assert not [line for line in lines if re.match(r"haptisym(\.(?!__main__)\w+)? ", line)]
