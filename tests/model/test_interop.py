"""Systems of other packages come in exactly as they are written, and go out so that they come back the same."""

from __future__ import annotations

import subprocess
import sys
from decimal import Decimal
from fractions import Fraction
from itertools import product

import control
import numpy as np
import pytest
import scipy.signal
from sympy import Float, Matrix, Rational, Symbol, cancel, exp, pi, symbols
from sympy.physics.control import Feedback, Parallel, Series, StateSpace, TransferFunction, TransferFunctionMatrix

import haptisym as hs
from haptisym import effects, environments, interop

s = hs.s
FILTER = Rational(6400) / (s**2 + 80 * s + 6400)
MSD = Rational(9, 5) * s**2 + 15 * s + 100
LEAD = (Rational(3, 10) * s + 1) / (Rational(7, 100) * s + 1)
p, k, m = symbols("p k m")
w = Symbol("s", complex=True)

SAME = {
    "an expression": (6400 / (s**2 + 80.0 * s + 6400), FILTER),
    "another symbol s": (6400 / (w**2 + 80 * w + 6400), FILTER),
    "a pair of lists": (([6400], [1, 80, 6400]), FILTER),
    "a pair of arrays": ((np.array([6400]), np.array([1.0, 80.0, 6400.0])), FILTER),
    "numbers of every kind": (([Decimal("0.3"), "1"], [Fraction(7, 100), np.int64(1)]), LEAD),
    "single precision": (([np.float32(0.3), 1], [0.07, 1]), LEAD),
    "an improper pair": (([1.8, 15, 100], [1]), MSD),
    "an environment": (environments.mass_spring_damper("1.8 kg", 15, 100), MSD),
    "an effect": (effects.second_order_lowpass(80, 0.5), FILTER),
    "SymPy": (TransferFunction(6400, p**2 + 80 * p + 6400, p), FILTER),
    "SymPy with floats": (TransferFunction(0.3 * p + 1, 0.07 * p + 1, p), LEAD),
    "SymPy with parameters": (TransferFunction(k, m * p**2 + k, p), k / (m * s**2 + k)),
    "SymPy in series": (Series(TransferFunction(2, p, p), TransferFunction(3, p + 1, p)), 6 / (s * (s + 1))),
    "SymPy in parallel": (Parallel(TransferFunction(2, p, p), TransferFunction(3, p + 1, p)), 2 / s + 3 / (s + 1)),
    "SymPy in feedback": (Feedback(TransferFunction(5, p, p), TransferFunction(1, 1, p)), 5 / (s + 5)),
    "SymPy with a delay": (TransferFunction(exp(-p / 50), p + 1, p), exp(-s / 50) / (s + 1)),
    "SymPy's state space": (StateSpace(Matrix([[0, 1], [-k, -3]]), Matrix([0, 1]), Matrix([[k, 0]]), Matrix([[0]])), k / (s**2 + 3 * s + k)),
    "control": (control.tf([6400], [1, 80, 6400]), FILTER),
    "control, improper": (control.tf([1.8, 15, 100], [1]), MSD),
    "control, dt = None": (control.TransferFunction([0.3, 1], [0.07, 1], None), LEAD),
    "control, series": (control.tf([2], [1, 0]) * control.tf([3], [1, 1]), 6 / (s * (s + 1))),
    "control's state space": (control.ss([[0, 1], [-6400, -80]], [[0], [6400]], [[1, 0]], [[0]]), FILTER),
    "control's feedthrough": (control.ss([[-0.1]], [[1]], [[0.3]], [[2]]), 2 + Rational(3, 10) / (s + Rational(1, 10))),
    "control's gain": (control.ss([], [], [], [[2.5]]), Rational(5, 2)),
    "SciPy": (scipy.signal.TransferFunction([6400], [1, 80, 6400]), FILTER),
    "SciPy's lti": (scipy.signal.lti([6400], [1, 80, 6400]), FILTER),
    "SciPy's zeros and poles": (scipy.signal.ZerosPolesGain([-2], [-1 + 3j, -1 - 3j, -0.1], 0.5), Rational(1, 2) * (s + 2) / ((s**2 + 2 * s + 10) * (s + Rational(1, 10)))),
    "SciPy's poles alone": (scipy.signal.lti([], [-4.0], 4), 4 / (s + 4)),
    "SciPy's state space": (scipy.signal.StateSpace([[0, 1], [-6400, -80]], [[0], [6400]], [[1, 0]], [[0]]), FILTER),
}  # fmt: skip


@pytest.mark.parametrize(("system", "wanted"), SAME.values(), ids=SAME.keys())
def test_a_system_comes_in_exactly(system, wanted):
    found = interop.dynamics(system)
    assert not found.atoms(Float)
    assert cancel(found - wanted) == 0
    assert interop.environment(system).model == "expression"
    assert cancel(interop.environment(system).H - wanted) == 0
    assert cancel(interop.series(system, name="given").matrix[0] - wanted) == 0
    assert interop.series(system, name="given").name == "given"


def test_a_system_can_be_evaluated_like_a_scene_file():
    ours = hs.evaluate(hs.load_scene("fu2019"))
    theirs = hs.evaluate(
        hs.Scene(
            interop.environment(control.tf([1.8, 15, 100], [1])),
            (interop.series(scipy.signal.lti([6400], [1, 80, 6400])),),
        )
    )
    assert [c.omega.digits(20) for c in ours.crossings] == [c.omega.digits(20) for c in theirs.crossings]


def test_a_fourth_order_state_space_has_the_response_that_its_own_package_computes():
    rng = np.random.default_rng(1)
    system = control.ss(
        rng.normal(size=(4, 4)).round(3), rng.normal(size=(4, 1)).round(3), rng.normal(size=(1, 4)).round(3), [[0.25]]
    )
    H = interop.dynamics(system)
    for omega in (0, 1, 12):
        assert abs(complex(H.subs(s, 1j * omega)) - system(1j * omega)) < 1e-9


REFUSED = {
    "two inputs": (control.ss([[-1]], [[1, 2]], [[1]], [[0, 0]]), "2 inputs and 1 outputs"),
    "a matrix of SymPy": (TransferFunctionMatrix([[TransferFunction(1, p, p)], [TransferFunction(2, p, p)]]), "1 inputs and 2 outputs"),
    "two outputs in SciPy": (scipy.signal.TransferFunction([[1, 2], [3, 4]], [1, 1]), "several outputs"),
    "two inputs in SciPy": (scipy.signal.StateSpace([[-1]], [[1, 2]], [[1]], [[0, 0]]), "2 inputs and 1 outputs"),
    "discrete in control": (control.tf([1], [1, 0.5], 0.001), r"discrete time \(dt = 0.001\).*zero-order-hold"),
    "discrete without dt": (control.tf([1], [1, 0.5], dt=True), "discrete time"),
    "discrete in SciPy": (scipy.signal.dlti([1], [1, 0.5], dt=0.01), "discrete time"),
    "lonely complex roots": (scipy.signal.ZerosPolesGain([], [-1 + 3j, -2], 1), "conjugate pairs"),
    "complex coefficients": (([1], [1, 2j]), "complex coefficient"),
    "not a number": (([1], [1, float("nan")]), "nan"),
    "a zero denominator": (([1], [0, 0]), "denominator is zero"),
    "a string": ("1/(s + 1)", "no system known here"),
    "three things": (([1], [1], [1]), "no system known here"),
    "a shunt": (effects.shunt(m="1 kg"), "not an effect in series"),
    "frequency data": (control.frd([1, 2], [1, 2]), "no system known here"),
}  # fmt: skip


@pytest.mark.parametrize(("system", "message"), REFUSED.values(), ids=REFUSED.keys())
def test_what_is_no_continuous_system_with_one_input_and_one_output_is_refused(system, message):
    with pytest.raises(hs.SceneError, match=message):
        interop.dynamics(system)


MONIC = [FILTER, MSD, Rational(1, 10) / s, s / 10**6, MSD / (s + 1), (s + 2) / (s**2 + s / 10 + 400)]
SCALED = [LEAD, 1 / (3 * s + 1), (s + 1) / (s * (7 * s + 3))]
EXPORTS = [interop.to_sympy, interop.to_control, interop.to_scipy]


def named(x):
    return getattr(x, "__name__", None) or str(x)


@pytest.mark.parametrize(("H", "export"), [*product(MONIC, EXPORTS), *product(SCALED, EXPORTS[:2])], ids=named)
def test_there_and_back_is_the_same_system_exactly(H, export):
    assert cancel(interop.dynamics(export(H)) - H) == 0


@pytest.mark.parametrize("H", SCALED, ids=str)
def test_scipy_divides_by_the_leading_coefficient_and_rounds(H):
    back = interop.dynamics(interop.to_scipy(H))
    assert abs(complex((back / H).subs(s, 3j)) - 1) < 1e-15


def test_the_exported_system_is_one_of_the_other_package_with_the_coefficients_as_they_are_written():
    there = interop.to_control(environments.mass_spring_damper("1.8 kg", 15, 100))
    assert (there.num[0][0].tolist(), there.den[0][0].tolist()) == ([1.8, 15, 100], [1])
    assert there.isctime()
    there = interop.to_scipy(effects.second_order_lowpass(80, 0.5))
    assert isinstance(there, scipy.signal.TransferFunction)
    assert (there.num.tolist(), there.den.tolist()) == ([6400], [1, 80, 6400])
    assert interop.to_sympy(k / (m * s**2 + k)) == TransferFunction(k, k + m * s**2, s)


def test_irrational_coefficients_are_the_nearest_doubles():
    assert interop.to_control(effects.first_order_lag("20 Hz")).den[0][0].tolist() == [1, 125.66370614359172]
    assert interop.dynamics(interop.to_sympy(1 / (s + 40 * pi))) == 1 / (s + 40 * pi)


def test_all_parts_of_a_distortion_can_be_exported():
    d = hs.load_scene("fu2019").distortion()
    assert cancel(interop.dynamics(interop.to_control(d.perceived)) - MSD * FILTER) == 0
    assert cancel(interop.dynamics(interop.to_scipy(d.distortion)) - MSD * (FILTER - 1)) == 0
    omega = 7.5
    assert abs(interop.to_control(d.distortion)(1j * omega).real - float(d.real.subs(hs.omega, omega))) < 1e-11


@pytest.mark.parametrize("export", EXPORTS, ids=lambda f: f.__name__)
@pytest.mark.parametrize(
    ("system", "message"),
    [
        (effects.delay("5 ms"), r"exp\(-s/200\) is not rational in s.*pade-delay"),
        (environments.spring_pot(80, "0.25"), "not rational in s"),
        (hs.load_scene("stick-with-friction").distortion().perceived, "I"),
    ],
)
def test_a_delay_a_fraction_of_a_derivative_and_friction_cannot_be_exported(system, message, export):
    with pytest.raises(hs.SceneError, match=message):
        export(system)


@pytest.mark.parametrize("export", [interop.to_control, interop.to_scipy], ids=lambda f: f.__name__)
def test_symbols_must_have_values_before_numbers_are_exported(export):
    with pytest.raises(hs.SceneError, match="k, m must have values: they are symbols"):
        export(k / (m * s**2 + k))


def test_a_delay_that_cancels_does_not_stand_in_the_way():
    assert cancel(interop.dynamics(interop.to_control(exp(-s) / (s * exp(-s) + exp(-s)))) - 1 / (s + 1)) == 0


@pytest.mark.slow
def test_nothing_is_imported_that_is_not_asked_for():
    probe = (
        "import sys, haptisym as hs\n"
        "from haptisym import interop\n"
        "interop.environment(([1.8, 15, 100], [1]))\n"
        "assert not {'control', 'scipy.signal', 'sympy.physics.control'} & set(sys.modules)\n"
        "sys.modules['control'] = sys.modules['scipy.signal'] = None\n"
        "for export, name in ((interop.to_control, 'python-control'), (interop.to_scipy, 'SciPy')):\n"
        "    try: export(([1], [1, 1]))\n"
        "    except hs.SceneError as error: assert name in str(error)\n"
        "    else: raise AssertionError\n"
    )
    subprocess.run([sys.executable, "-c", probe], check=True)
