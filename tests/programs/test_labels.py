"""Formulas in steps: exactly the closed forms, and short where those are not."""

from __future__ import annotations

from functools import cache
from itertools import product
from random import Random

import pytest
from marks import often
from mpmath import mp
from sympy import Expr, Float, I, Rational

import haptisym as hs
from haptisym.model.catalogue import EFFECTS, ENVIRONMENTS
from haptisym.model.chain import Chain
from haptisym.model.distortion import Distortion
from haptisym.programs.floats import UFUNCS
from haptisym.programs.steps import _MADE, Steps, page_steps
from haptisym.programs.values import Values

E, F = hs.environments, hs.effects
GIVEN = {
    "expression": {"H": "k + b*s/(1 + s*T)", "parameters": {"k": 90, "b": 3, "T": "20 ms"}},
    "prony": {"k0": 50, "k": [10, 20], "b": [3, 4]},
    "series": {"G": "(1 + s*T)/(1 + s*T/9)", "parameters": {"T": "10 ms"}},
    "admittance-display": {"P": "1/(1 + s*T)", "parameters": {"T": "8 ms"}},
    "two-port": {"A": "1 + s*T", "B": "m*s^2", "C": "1/k", "D": "1", "parameters": {"T": "3 ms", "m": 0.2, "k": 3000}},
    "pade-delay": {"tau": "20 ms", "order": 2},
    "sampled-loop": {"T": "20 ms", "method": "backward-difference", "delay": 1},
}
VALUES = {"zeta": 0.6, "alpha": 0.5, "omega_n": 70, "omega_c": 40, "tau": 0.02, "T": 0.01}


def built(kind: str, models, build):  # type: ignore[no-untyped-def]
    slots = models[kind].slots
    given = GIVEN.get(kind) or {
        key: VALUES.get(key, Rational(3 + 7 * i, 2)) for i, (key, slot) in enumerate(slots.items()) if not slot.formula
    }
    return models[kind].build(**given)


@cache
def pair(environment: str, effect: str) -> hs.Scene:
    return hs.Scene(built(environment, ENVIRONMENTS, None), (built(effect, EFFECTS, None),), (0, 30))


HEAVY = {
    "spring-pot",
    "prony",
    "two-mass",
    "zener",
    "wave-variables",
    "four-channel-teleoperator",
    "position-position-teleoperator",
}
PLAIN = {"mass-spring-damper", "second-order-lowpass", "delay"}
PAIRS = often(
    (x for x in product(ENVIRONMENTS, EFFECTS) if x != ("spring-pot", "sampled-loop")),
    lambda pair: not HEAVY & set(pair) and bool(PLAIN & set(pair)),
    3,
)


def felt(scene: hs.Scene, values: dict[Expr, Expr]) -> dict[str, object]:
    """The witness: the chain matrix applied to H_env at s = j omega, in complex numbers of sixty digits."""

    def at(entry: Expr) -> object:
        return mp.mpmathify(entry.xreplace({**values, hs.s: I * values[hs.omega]}).evalf(60))

    chain = scene.chain
    H = at(chain.environment)
    perceived = H
    for a, b, c, d in chain.matrices:
        perceived = (at(a) * perceived + at(b)) / (at(c) * perceived + at(d))
    dH = perceived - H
    relative = dH / H
    return {
        "real": dH.real, "imag": dH.imag, "ratio_real": abs(dH.real) / abs(H), "ratio_imag": abs(dH.imag) / abs(H),
        "relative_real": relative.real, "relative_imag": relative.imag, "environment_real": H.real,
        "environment_imag": H.imag, "perceived_real": perceived.real, "perceived_imag": perceived.imag,
    }  # fmt: skip


@pytest.mark.few(4)
@pytest.mark.parametrize(("environment", "effect"), PAIRS)
def test_every_formula_of_every_pair_of_models_has_the_value_of_its_chain(environment: str, effect: str) -> None:
    """In steps with symbols for all parameters, and in lowest terms with numbers, at random values of the parameters."""
    scene = pair(environment, effect)
    steps = page_steps(scene.chain.program(Values._fields))
    pick = Random(f"{environment} {effect}")
    for _ in range(3):
        values = {p.symbol: p.value * Rational(pick.randint(60, 140), 100) for p in scene.parameters}
        d = Distortion.of(scene.chain.at(values))
        closed = dict(zip(Values._fields, (
            d.real, d.imag, d.ratio_real, d.ratio_imag, d.relative_real, d.relative_imag,
            d.env_response.real.factored(), d.env_response.imag.factored(),
            d.perc_response.real.factored(), d.perc_response.imag.factored()), strict=True))  # fmt: skip
        values[hs.omega] = Float(Rational(pick.randint(1, 6000), 97), 60)
        with mp.workdps(60):
            expected = felt(scene, values)
            found = [{name: x.xreplace(values) for name, x in closed.items()}, steps.at(values)]
            for forms in found:
                for name, value in expected.items():
                    assert abs(mp.mpmathify(forms[name].evalf(60)) - value) < 1e-30 * max(abs(value), 1e-6), name


def cascade(count: int) -> Chain:
    m, b, k = hs.symbols("m b k")
    filters = [F.second_order_lowpass(*hs.symbols(f"omega_{i} zeta_{i}")) for i in range(1, count + 1)]
    H = E.mass_spring_damper(m, b, k).H
    return Chain(H, H, tuple(f.matrix for f in filters))


def test_three_symbolic_low_passes_take_fewer_than_three_hundred_operations() -> None:
    assert cascade(3).steps.operations <= 140


@pytest.mark.few(2)
@pytest.mark.parametrize("count", [2, 4, 8, 16])
def test_each_further_device_costs_the_same(count: int) -> None:
    one, two = (cascade(n).steps.operations for n in (count, count + 1))
    assert two - one == cascade(3).steps.operations - cascade(2).steps.operations


def test_the_steps_of_a_cascade_multiply_out_to_its_closed_form_exactly() -> None:
    chain = cascade(2)
    d = Distortion.of(chain)
    numbers = {x: Rational(n + 2, 3) for n, x in enumerate(sorted({*d.free_symbols, hs.omega}, key=str))}
    found = chain.steps.at(numbers)
    assert found["real"] == d.real.xreplace(numbers)
    assert found["imag"] == d.imag.xreplace(numbers)
    assert (found["ratio_real"] ** 2).expand() == (d.ratio_real.xreplace(numbers) ** 2).expand()


def test_a_name_that_a_parameter_has_already_is_not_given_twice() -> None:
    R, U, P = hs.symbols("R U P")
    steps = hs.distort(E.mass_spring_damper(R, 1, U), F.second_order_lowpass(P, 1)).chain.steps
    names = [x.name for x, _ in steps.definitions]
    assert len(set(names)) == len(names)
    assert not {"R", "U", "P"} & set(names)


def test_steps_name_nothing_of_an_effect_that_is_absent() -> None:
    m, b, k, w = hs.symbols("m b k w")
    plain = hs.distort(E.mass_spring_damper(m, b, k)).chain.steps
    assert plain.results["real"] == plain.results["ratio_imag"] == 0
    lag = hs.distort(E.mass_spring_damper(m, b, k), F.first_order_lag(w)).chain.steps
    assert {x.name for x in lag.free_symbols} == {"m", "b", "k", "w", "omega"}


@pytest.mark.few(5)
@pytest.mark.parametrize("name", hs.scene_names())
def test_every_shipped_scene_in_symbols_has_short_steps(name: str) -> None:
    scene = hs.load_scene(name)
    steps = scene.chain.steps
    assert isinstance(steps, Steps)
    assert steps.operations < 400
    assert {x for x in steps.free_symbols if x != hs.omega} <= {p.symbol for p in scene.parameters}


@pytest.mark.parametrize("name", sorted(_MADE))
def test_an_operation_on_a_page_is_the_one_that_floats_compute(name: str) -> None:
    count = 2 if name in ("add", "sub", "mul", "div", "power") else 1
    for given in ((0.75, 2.5), (2.25, 0.5), (0.001, 3.0)):
        x = [Float(y, 40) for y in given[:count]]
        exact = _MADE[name](*hs.symbols("x y")[:count]).subs(dict(zip(hs.symbols("x y"), x, strict=False)))
        assert float(exact) == pytest.approx(float(UFUNCS[name](*given[:count])), rel=1e-14)
