"""Closed forms as programs: their values are those of the matrices of a chain; sin(x)/x - 1 in floats."""

from __future__ import annotations

from random import Random

import flint
import numpy as np
import pytest
from chainballs import error_in_ulps, truth
from flint import arb
from mpmath import mp

import haptisym as hs
from haptisym.programs.balls import BallPoint
from haptisym.programs.floats import UFUNCS
from haptisym.writing.code.computed import closed

E, F = hs.environments, hs.effects
LAG = F.second_order_lowpass(70, "0.6")
CHAINS = {
    "a wave line": hs.Scene(E.mass_spring_damper(2, 3, 90), (F.wave_variables(3, "20 ms"),)),
    "a wave line to a damped spring": hs.Scene(E.kelvin_voigt(90, 3), (F.wave_variables("7/2", "20 ms"),)),
    "a delay": hs.Scene(E.kelvin_voigt(90, 3), (F.delay("20 ms"),)),
    "a low-pass": hs.Scene(E.mass_spring_damper("1/2", 3, 90), (LAG,)),
    "a lag of a link": hs.Scene(E.maxwell(90, 4), (F.first_order_lag(20), F.compliance(k=500))),
    "an undamped wall": hs.Scene(E.mass_spring_damper("1/2", 0, 90), (LAG,)),
}


@pytest.mark.parametrize("name", CHAINS)
def test_a_program_of_closed_forms_has_the_values_of_the_matrices(name: str) -> None:
    scene, pick = CHAINS[name], Random(name)
    chain = scene.chain
    program = closed(chain)
    for _ in range(3):
        at = pick.randint(1, 900) / 16
        values = {p.symbol.name: float(p.value) * pick.randint(9, 24) / 16 for p in scene.parameters}
        point = BallPoint(program, (at, *(values[x.name] for x in program.inputs[1:])))
        with flint.ctx.workprec(400):
            expected = truth(chain, at, values, 400)
            found = point.balls(400)
            assert found.keys() == expected.keys()
            for field, true in expected.items():
                assert abs(found[field] - true) < arb(2) ** -300 * (1 + abs(true)), field


@pytest.mark.parametrize("sign", [1, -1])
def test_sin_x_over_x_less_1_keeps_its_digits_as_a_float_of_any_size(sign: int) -> None:
    x = sign * np.concatenate([np.geomspace(1e-150, 1.0, 60), np.linspace(1.0, 9.0, 161)])
    found = UFUNCS["sincm1"](x)
    with mp.workprec(1200):
        true = [mp.sinc(mp.mpf(float(a))) - 1 for a in x]
        assert max(error_in_ulps(float(a), arb(str(b))) for a, b in zip(found, true, strict=True)) < 8
