"""Importing and using the package leaves everything of the user's process as it was."""

from __future__ import annotations

import subprocess
import sys
from textwrap import dedent

import pytest

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


def run(script: str) -> str:
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", WATCH + dedent(script)], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.slow
def test_importing_the_package_changes_nothing() -> None:
    run("""
        before = state()
        import haptisym
        after = state()
        assert before == after, [key for key in before if before[key] != after[key]]
    """)


def test_an_evaluation_changes_nothing() -> None:
    run("""
        import haptisym as hs
        before = state()
        lag, spring = hs.effects.first_order_lag("3 Hz"), hs.environments.mass_spring_damper(1, 2, 300)
        scene = hs.Scene(spring, (lag, hs.effects.shunt(m="10 g")))
        result = hs.evaluate(scene, 60)
        result.to_json(), repr(result)
        f = scene.distortion().compile()
        f([0.0, 1.0])
        try:
            hs.environments.expression("1/0 + ")
        except hs.HaptisymError:
            pass
        after = state()
        assert before == after, [key for key in before if before[key] != after[key]]
    """)


def test_an_evaluation_does_not_depend_on_the_precision_the_user_set() -> None:
    run("""
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


@pytest.mark.slow
def test_importing_the_package_loads_no_plotting_library() -> None:
    loaded = run("""
        import haptisym
        hs_modules = sorted(sys.modules)
        print(*hs_modules)
    """).split()
    assert "haptisym.judge.evaluation" in loaded
    assert not {"matplotlib", "pandas", "IPython", "tkinter", "control"} & set(loaded)


def test_a_certified_evaluation_needs_neither_arrays_nor_figures_nor_a_registry_of_units() -> None:
    """Each of them takes as long to load as SymPy's own core; a command line in a loop pays for none."""
    script = """
        import sys
        import haptisym as hs
        hs.evaluate(hs.load_scene("fu2019")).to_json()
        print(*({"numpy", "pint", "matplotlib", "dask", "scipy", "rich"} & set(sys.modules)))
    """
    done = subprocess.run([sys.executable, "-c", dedent(script)], capture_output=True, text=True, check=True)
    assert done.stdout.split() == []


def test_the_command_starts_with_everything_loaded_out_of_the_collectors_way_and_leaves_it_on() -> None:
    script = """
        import gc, sys
        from haptisym_command import main
        sys.argv = ["haptisym", "--version"]
        try:
            main()
        except SystemExit:
            print(gc.isenabled(), gc.get_freeze_count() > 10_000, gc.get_stats()[2]["collections"])
    """
    done = subprocess.run([sys.executable, "-c", dedent(script)], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[1:] == ["True True 0"]
