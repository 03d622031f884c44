"""What a user sees of the package, and what importing and using it leaves alone."""

from __future__ import annotations

import ast
import importlib
import json
import os
import re
import subprocess
import sys
from collections.abc import Iterable
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path
from textwrap import dedent
from typing import Any

import pytest
from marks import required
from questions import answers

import haptisym as hs

STUB = files("haptisym") / "__init__.pyi"
MYPY = "mypy, of the extra ci,"
DOCS = [Path(__file__).parents[2] / "README.md", *(Path(__file__).parents[2] / "docs").glob("*.md")]

WATCH = """
import decimal, locale, sys, warnings
import flint, mpmath, numpy, sympy

def state():
    return {
        "numpy errors": numpy.geterr(),
        "numpy printing": numpy.get_printoptions(),
        "mpmath": (mpmath.mp.prec, mpmath.mp.pretty, mpmath.iv.prec),
        "flint": (flint.ctx.prec, flint.ctx.pretty, flint.ctx.cap),
        "sympy printing": (sympy.StrPrinter._global_settings.copy(), sympy.Basic.__str__, sympy.Basic.__repr__),
        "decimal": repr(decimal.getcontext()),
        "display": (sys.displayhook, sys.excepthook),
        "recursion": sys.getrecursionlimit(),
        "digits of whole numbers": sys.get_int_max_str_digits(),
        "warnings": list(warnings.filters),
        "locale": locale.setlocale(locale.LC_ALL),
        "path": list(sys.path),
    }
"""


def python(script: str, *options: str) -> str:
    """What a fresh interpreter prints."""
    done = subprocess.run([sys.executable, *options, "-c", dedent(script)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


# Names


def stubbed() -> dict[str, str]:
    """The names of the stub, and the modules that it has them from."""
    tree = ast.parse(STUB.read_text(encoding="utf-8"))
    return {x.name: node.module or "" for node in tree.body if isinstance(node, ast.ImportFrom) for x in node.names}


def test_a_public_name_is_listed_and_means_what_type_checkers_are_told() -> None:
    stub = stubbed()
    assert set(stub) == set(hs.__all__) <= set(dir(hs))
    assert hs.__all__ == sorted(set(hs.__all__))
    assert (files("haptisym") / "py.typed").is_file()
    for name, module in stub.items():
        source = importlib.import_module(module if module != "haptisym" else f"haptisym.{name}")
        assert getattr(hs, name) is (source if module == "haptisym" else getattr(source, name))


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
def test_help_and_completion_show_what_is_loaded_on_demand_also_without_the_optional_packages() -> None:
    text = python("""
        import sys
        for name in ("scipy", "threadpoolctl", "xarray", "dask", "distributed", "zarr", "numba"):
            sys.modules[name] = None
        import pydoc, rlcompleter
        import haptisym as hs
        print(pydoc.plain(pydoc.render_doc(hs)))
        completer = rlcompleter.Completer({"hs": hs})
        print(*iter(lambda found=[]: found.append(0) or completer.complete("hs.re", len(found) - 1), None))
    """)
    for name in hs.__all__:
        assert re.search(rf"^ *(class )?{name}\b", text, re.MULTILINE), name
    assert {"hs.require(", "hs.relevance(", "hs.recording("} <= set(text.splitlines()[-1].split())


# What is loaded, and what is changed


@pytest.mark.slow
@pytest.mark.core
def test_importing_and_evaluating_changes_nothing_and_loads_little() -> None:
    loaded = python(
        WATCH
        + dedent("""
        before = state()
        import haptisym as hs
        assert before == (after := state()), [key for key in before if before[key] != after[key]]
        lag, spring = hs.effects.first_order_lag("3 Hz"), hs.environments.mass_spring_damper(1, 2, 300)
        scene = hs.Scene(spring, (lag, hs.effects.shunt(m="10 g")))
        result = hs.evaluate(scene, 60)
        result.to_json(), repr(result)
        print(*sys.modules)
        f = scene.distortion().compile()
        f([0.0, 1.0])
        try:
            hs.environments.expression("1/0 + ")
        except hs.HaptisymError:
            pass
        assert before == (after := state()), [key for key in before if before[key] != after[key]]
    """),
        "-W",
        "error",
    ).split()
    assert "haptisym.judge.evaluation" in loaded
    assert not {"matplotlib", "pandas", "IPython", "tkinter", "control", "xarray", "zarr", "numba", "click"} & set(
        loaded
    )


@pytest.mark.slow
@pytest.mark.core
def test_an_evaluation_does_not_depend_on_the_precision_the_user_set() -> None:
    python(
        WATCH
        + dedent("""
        import haptisym as hs
        def answer():
            scene = hs.Scene(hs.environments.mass_spring_damper("1.8 kg", 15, 100),
                             (hs.effects.second_order_lowpass("12 Hz", 0.5),))
            return hs.evaluate(scene, 40).to_json()
        expected = answer()
        from decimal import getcontext
        flint.ctx.prec, mpmath.mp.prec, getcontext().prec = 5, 7, 3
        numpy.seterr(all="raise")
        assert answer() == expected
        assert (flint.ctx.prec, mpmath.mp.prec, getcontext().prec) == (5, 7, 3)
    """)
    )


@pytest.mark.slow
@pytest.mark.core
def test_a_document_on_the_command_line_loads_neither_arrays_figures_units_nor_other_verbs() -> None:
    """Each of them takes as long to load as SymPy's own core; a command line in a loop pays for none."""
    loaded = set(
        python("""
        import contextlib, io, sys
        sys.argv = ["haptisym", "evaluate", "fu2019", "--json"]
        from haptisym.cli import main
        with contextlib.redirect_stdout(io.TextIOWrapper(io.BytesIO())), contextlib.suppress(SystemExit):
            main()
        print(*sys.modules)
    """).split()
    )
    ours = {x.removeprefix("haptisym.") for x in loaded if x.startswith("haptisym.")}
    assert "judge.evaluation" in ours
    ours -= {"writing", "writing.characters"}  # which tells what may be printed, and loads nothing
    assert not [x for x in ours if x.startswith(("pages", "writing", "figures.style"))]
    assert {x for x in ours if x.startswith("verbs.")} == {"verbs.evaluate", "verbs.evaluate.entry"}
    assert not ours & {"commands.sweep", "commands.simulate", "programs.program"}
    assert not loaded & {"multiprocessing", "pint", "numpy", "matplotlib", "dask", "scipy", "rich", "IPython"}


@pytest.mark.slow
@pytest.mark.core
def test_the_command_starts_with_everything_loaded_out_of_the_collectors_way_and_leaves_it_on() -> None:
    told = python("""
        import gc, sys
        from haptisym.__main__ import main
        sys.argv = ["haptisym", "effects", "--help"]
        try:
            main()
        except SystemExit:
            print(gc.isenabled(), gc.get_freeze_count() > 10_000, gc.get_stats()[2]["collections"])
    """)
    assert told.splitlines()[-1] == "True True 0"


def test_what_needs_no_mathematics_loads_none() -> None:
    loaded = python("""
        import contextlib, io, sys
        from haptisym.cli import main
        for words in ("--version", "--help", "schemas", "scenes", "scenes --json"):
            sys.argv = ["haptisym", *words.split()]
            with contextlib.redirect_stdout(io.TextIOWrapper(io.BytesIO())), contextlib.suppress(SystemExit):
                main()
        print(*sys.modules)
    """).split()
    assert not {"sympy", "flint", "numpy", "rich"} & set(loaded)


# Types


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
    verified: hs.Verification = hs.verify(scene, 3)
    needed: hs.Requirement = hs.require(Path("own.toml"), "effects.filter.omega_n", (50, "200 rad/s"), part=hs.Part.REAL)
    doing: hs.ValueSet = needed.values
    design: hs.DesignMap = hs.design_map(scene, ["zeta", "omega_n"], [(0.4, "0.6"), (50, 500)], slices=3)
    best: hs.Design = hs.design(scene, {"zeta": (0.3, "1")}, keep="passive", limit=20)
    beside: hs.Comparison = hs.compare(e, "helicopter-cyclic", hand="postural-arm")
    slopes: hs.Sensitivities = hs.sensitivity(scene)
    boxes: hs.Tolerances = hs.tolerances(hs.load_scene("fu2019-tolerances"), samples=0)
    person: hs.Psychometric = hs.jnd("answers.csv", reference=5, lapse=None)
    known: hs.PublishedThresholds = hs.published()
    first: hs.Published = known[0]
    kept: hs.Relevance = hs.relevance(scene, "1 %")
    measures: hs.Metrics = hs.metrics("fu2019")
    costs: hs.Cost = hs.cost(scene, quick=True)
    harder: hs.HardCosts = hs.hard_costs(told=lambda what, share: None)
    run: hs.Simulation = hs.simulate(scene, hs.sine(1, 3), extras=(hs.EncoderQuantisation(1e-6), hs.ForceSaturation(50)))
    both: tuple[hs.Simulation, ...] = hs.check(scene, amplitude="1 cm", count=3)
    motions = [hs.multisine(0.01, [1, 2]), hs.chirp(0.01, 1, 10, 5)]
    family: hs.SceneFamily = hs.load_scenes("fu2019", ["fu2019", "helicopter-cyclic"])
    together: hs.FamilyEvaluation = hs.evaluate_all(family)
    shared: hs.FamilyAnswers = hs.answer_each(family, hs.stability)
    arm: hs.Hand = hs.hands["postural-arm"]
    loading: hs.ControlLoading = hs.control_loading(scene, sweeps=["4 s"])
    carried: tuple[hs.Effect, ...] = hs.devices["one-axis"].effects()
    let_go: hs.Release = hs.release(scene, "1 cm", arm)
    shakes: hs.Stability = hs.stability(scene, [arm, "firm-grip", hs.Hand("own", m="0.5 kg")])
    lines: hs.Measurement = hs.measured([1.0, 2.0], [99 + 2j, 98 + 4j], coherence=[0.9, 0.9], averages=10)
    exact: hs.Measurement = hs.sampled(scene, [1.0, 2.0])
    bench: hs.MeasuredEvaluation = hs.evaluate(hs.MeasuredScene(hs.environments.kelvin_voigt(100, 2), lines))
    recorded: hs.Measurement = hs.estimated([0.0, 1.0], [0.0, 100.0], "1 kHz", estimator="H2", segment="1 s")
    fitted: hs.Identification = hs.identify(recorded, "kelvin-voigt", ["shunt:m", "delay"], band=("1 Hz", 20))
    sliders: hs.Explorer = hs.explore("own.toml")
    device: hs.ZWidthFit = hs.fit_zwidth("wheel-with-encoder", [(0.4, 0), (0.5, 5e-5)], ["effects.wheel.b"])
    sets = hs.sweep(scene, {"effects.filter.omega_n": [60, 80]})
    code: str = hs.scene_code(scene, hs.Language.NUMPY) + hs.distortion_code(scene.distortion(), hs.Language.C)
    d: hs.Distortion = hs.distort(hs.environments.mass_spring_damper(*hs.symbols("m b k")), hs.effects.delay("5 ms"))
    mass: object = hs.solve_for(d, "changeover", "m").environment
    f = d.compile(hs.Accuracy.FAST)
    written: list[str] = [hs.latex(e), hs.latex(d), hs.mathml(d), e.to_json(), code, str(together), str(hs.omega + hs.s)]
    try:
        hs.parse_scene("nonsense")
    except hs.SceneError as error:
        written.append(str(error))
    shown: list[object] = [width, spans, felt, points, kinds, high, derived, needed, doing, design, beside, slopes, boxes, kept]
    shown += [person, known, first, measures, shakes, costs, harder, run, let_go, both, motions, sets, f, bench, exact, fitted, mass, sliders]
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
    spared = "Environment ExpressionError HaptisymError Peaks Percept UndecidedError family_names interop json_schema parse_scenes recording"
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


# The exact core without arrays and pictures


def asked(without: str, names: Iterable[str]) -> Any:
    script = Path(__file__).parents[1] / "witnesses" / "questions.py"
    done = subprocess.run([sys.executable, script, without, *names], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.mark.slow
@pytest.mark.core
def test_the_exact_core_gives_the_same_digits_without_numpy_and_matplotlib() -> None:
    told = asked("numpy,matplotlib,scipy", hs.scene_names())["answers"]
    for name in hs.scene_names():
        assert told[name] == answers(name)


@pytest.mark.slow
@pytest.mark.core
def test_evaluating_deriving_and_stability_load_neither_numpy_nor_matplotlib() -> None:
    loaded = python("""
        import sys
        import haptisym as hs
        scene = hs.load_scene("fu2019")
        for answer in (hs.evaluate(scene), hs.stability(scene, "firm-grip"), hs.derive(scene)):
            answer.to_json(), str(answer)
        hs.evaluate(scene).certificate()
        print(*sys.modules)
        scene.distortion().compile()([1.0, 2.0])
        print(*sys.modules)
    """).splitlines()
    arrays, pictures = {"numpy"}, {"matplotlib", "scipy", "click"}
    assert not (arrays | pictures) & set(loaded[0].split())
    assert arrays <= set(loaded[1].split())


@pytest.mark.slow
@pytest.mark.core
def test_a_sweep_in_memory_loads_neither_dask_nor_scipy_nor_units_before_they_are_asked_for() -> None:
    """Loading them takes longer than all else: xarray would do so when it is handed a plain array."""
    loaded = python("""
        import contextlib, io, sys
        sys.argv = ["haptisym", "sweep", "fu2019", "--vary", "effects.filter.omega_n=40:200:5", "--hand", "firm-grip"]
        from haptisym.cli import main
        with contextlib.redirect_stdout(io.TextIOWrapper(io.BytesIO())), contextlib.suppress(SystemExit):
            main()
        print(*sys.modules)
        import haptisym as hs
        found = hs.sweep("fu2019", {"environment.m": [1.0, 2.0]})
        print(*sys.modules)
        print(found.sel({"environment.m": 2.0}).crossings_real.item(), found["environment.m"].attrs["units"])
        print(found.chunk().bandwidth.max().compute().item() == found.bandwidth.max().item(), *sys.modules)
    """).splitlines()
    assert "xarray" in loaded[0].split()
    for modules in loaded[:2]:
        assert not {"dask", "pint", "scipy", "matplotlib"} & set(modules.split())
    assert loaded[2] == "1 kg"
    assert loaded[3].startswith("True ")
    assert "dask" in loaded[3].split()


@pytest.mark.slow
@pytest.mark.core
def test_what_needs_numpy_is_undecided_without_it_and_says_so() -> None:
    told = python("""
        import sys
        sys.modules["numpy"] = None
        import haptisym as hs
        try:
            hs.load_scene("fu2019").distortion().compile()([1.0, 2.0])
        except hs.UndecidedError as error:
            print(error)
        found = hs.require("virtual-coupling", "environment.b", that=["passive"])
        print(bool(found.undecided), found.reason)
    """)
    needs = "this needs NumPy, which is missing: pip install numpy"
    assert told.splitlines() == [needs, f"True {needs}"]
