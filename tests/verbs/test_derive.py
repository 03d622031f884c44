"""``derive``: formulas against the certified numbers and the physics; leading terms for fast devices; dimensionless groups."""

from __future__ import annotations

import json
import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from math import factorial, prod
from pathlib import Path
from typing import Annotated, Any

import mpmath
import numpy as np
import pytest
from jnds import picked
from marks import FLEXIBLE, QUICK_SCENES, UNDAMPED, often
from pdflatex import check_layout, compiled
from refusals import refusal
from regions import margin
from strategies import CATALOGUE, Seeded, case
from strategies import scene as random_scene
from sympy import Float, I, Rational, Symbol, asin, cosh, count_ops, exp, lambdify, oo, sinh, sqrt, symbols

import haptisym as hs
from haptisym.commands.terminal import spelt
from haptisym.kernel.rings import X, c, omega, s
from haptisym.kernel.roots import Lattice, LatticePiece
from haptisym.model.catalogue import EFFECTS, ENVIRONMENTS, effect
from haptisym.model.jnd import Part, read_threshold
from haptisym.model.parameters import Slot
from haptisym.model.quantities import Dimension
from haptisym.verbs.derive.derivation import QUANTITIES, bare, listed_name
from haptisym.verbs.derive.expansion import expansion
from haptisym.verbs.derive.groups import groups
from haptisym.writing.plain import plain

PAPER = hs.load_scene("fu2019")
SPRING = hs.environments.mass_spring_damper(k=100)
M, B, K, OMEGA_N, ZETA = symbols("m b k omega_n zeta", positive=True)


@cache
def paper() -> hs.Derivation:
    return hs.derive(PAPER)


# --- formulas --------------------------------------------------------------------------------------------------------

SHORT = ["fu2019", "delayed-spring", UNDAMPED, "zener-tissue", "stick-with-friction"]


@pytest.mark.dear("fu2019")
@pytest.mark.parametrize("name", often(SHORT, {"fu2019", "delayed-spring"}.__contains__))
def test_every_quantity_in_symbols_has_the_numeric_scenes_value(name: str) -> None:
    scene = hs.load_scene(name)
    symbolic, numeric = hs.derive(scene), hs.derive(scene, keep=())
    values = {p.symbol: p.value for p in scene.parameters} | {omega: Rational(37, 7), s: Rational(5, 3)}
    values |= {symbolic.threshold(Part.REAL): scene.threshold.real}
    for quantity in QUANTITIES:
        left, right = (x[quantity].xreplace(values).evalf(40) for x in (symbolic, numeric))
        if quantity in ("p_r", "p_i"):  # their scale is free
            assert (left > 0) == (right > 0)
        elif quantity.startswith("F_"):
            assert abs((left - right).expand().coeff(X).evalf(20)) < 1e-12
        else:
            assert abs(left - right) < 10**-30 * (1 + abs(right)), quantity


def test_the_sign_of_a_threshold_polynomial_is_that_of_ratio_minus_threshold() -> None:
    """Of the paper by its ratios; of a lag r_r = w^2/(w^2 + 400) and r_i = 20 w/(w^2 + 400) by hand."""
    d = hs.derive(PAPER, keep=())
    for w in (5, 7, 9, 11, 13, 15):
        for part, ratio in (("p_r", "r_r"), ("p_i", "r_i")):
            inside = d[ratio].xreplace({omega: Rational(w)}).evalf(30) - Rational(1, 10)
            assert (d[part].xreplace({omega: Rational(w)}) > 0) == (inside > 0)
    lag = hs.derive(hs.Scene(SPRING, (hs.effects.first_order_lag(20),), (0, 15), "0.2"), keep=())
    low, high = (20 * (5 / 2 + sign * (21 / 4) ** 0.5) for sign in (-1, 1))
    known = [
        ("p_r", 0, -1),
        ("p_r", 9, -1),
        ("p_r", 10, 0),
        ("p_r", 11, 1),
        ("p_r", 400, 1),
        ("p_i", 1, -1),
        ("p_i", 50, 1),
    ]
    known += [
        ("p_i", w + step, sign * turn) for w, turn in ((low, 1), (high, -1)) for step, sign in ((-0.01, -1), (0.01, 1))
    ]
    for name, w, expected in known:
        value = float(lag[name].xreplace({omega: Rational(str(w))}))
        assert (value > 0) - (value < 0) == expected, (name, w)


@pytest.mark.few("b", "k")
@pytest.mark.parametrize("parameter", ["m", "b", "k", "omega_n", "zeta"])
def test_a_sensitivity_is_the_slope_of_the_certified_crossing(parameter: str) -> None:
    d = paper()
    symbol = next(p for p in d.scene.parameters if p.symbol.name == parameter)
    values, step = {p.symbol: p.value for p in d.scene.parameters}, Rational(1, 10**12)
    up, down, here = (d.at(**{parameter: symbol.value * (1 + n * step)}).crossings for n in (1, -1, 0))
    for i, part in enumerate(Part):
        slope = (Rational(up[i].omega.digits(60)) - Rational(down[i].omega.digits(60))) / (2 * step * symbol.value)
        known = {**values, omega: Rational(here[i].omega.digits(60)), d.threshold(part): Rational(1, 10)}
        assert d.sensitivity(part, symbol.symbol).xreplace(known).evalf(30) == pytest.approx(float(slope), rel=1e-12)


def test_formulas_hold_where_their_conditions_say_so() -> None:
    d = paper()
    low, high = d.changeovers("perc")
    assert all(x.conditions for x in (low, high))
    values = {p.symbol: p.value for p in d.scene.parameters}
    wide = hs.evaluate(d.scene.with_band(0, 200))
    assert sorted(float(x.omega.xreplace(values)) for x in (low, high)) == pytest.approx(
        [float(p.omega) for p in wide.changeovers_perceived], rel=1e-14
    )
    assert [x.omega for x in d.changeovers("env")] == [sqrt(hs.symbols("k")) / sqrt(hs.symbols("m"))]


def test_other_values_are_answered_with_certainty() -> None:
    result = paper().at(omega_n="40 Hz", c=0.2)
    env = hs.environments.mass_spring_damper("1.8 kg", "15 N*s/m", "100 N/m")
    expected = hs.evaluate(hs.Scene(env, (hs.effects.second_order_lowpass("40 Hz", 0.5),), (0, 15), 0.2))
    assert [c.omega.digits(30) for c in result.crossings] == [c.omega.digits(30) for c in expected.crossings]


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"m": -1}, r'm: "-1" must be >= 0'),
        ({"q": 1}, 'unknown parameter "q"'),
        ({"omega_n": "3 kg"}, "is not a frequency"),
    ],
)
def test_a_wrong_value_is_an_error_that_names_it(values: dict[str, Any], words: str) -> None:
    with pytest.raises(hs.SceneError, match=words):
        paper().at(**values)


def chained(scene: hs.Scene, at: Any) -> Any:
    """H_perc - H_env, one chain matrix after the other."""
    H = found = lambdify(s, scene.environment.H, "mpmath")(at)
    for x in scene.effects:
        a, b, c, d = (lambdify(s, entry, "mpmath")(at) for entry in x.matrix)
        found = (a * found + b) / (c * found + d)
    return found - H


@pytest.mark.slow
@pytest.mark.few("7")
@pytest.mark.parametrize("seed", [1, 3, 5, 7, 10])
def test_what_is_judged_is_told_by_its_pieces_and_each_piece_by_its_factors(seed: int) -> None:
    """The largest of the smallest is positive where the JND is exceeded; the product of all factors changes its sign as a piece does."""
    felt, places = hs.environments.mass_spring_damper("0.5", 3, 40), [0.3, 1.1, 2.3, 3.7, 5.2, 7.1, 8.3, 11.9, 14.6]
    jnd = picked(Seeded(seed))
    between = hs.effects.first_order_lag(9) if seed % 2 else hs.effects.delay("200 ms")
    scene = hs.Scene(felt, (between,), (0, 15), read_threshold(jnd))
    d = hs.derive(scene, keep=())
    signs: dict[Any, list[int]] = {}
    lattices = {own: own.function(d.distortion) for own in d.criteria}
    for name, function in lattices.items():
        for key in function.pieces(name) if isinstance(function, Lattice) else (name,):
            at = lambdify(omega, (d.piece(key) if isinstance(key, LatticePiece) else d.excess(key)).factored(), "math")
            signs[key] = [1 if at(w) > 0 else -1 for w in places]
            factors = [(lambdify(omega, x.ring.expression(x.F), "math"), n) for x, n in d.factors(key)]
            product = [prod(f(w) ** n for f, n in factors) for w in places]
            assert len({x * y > 0 for x, y in zip(signs[key], product, strict=True)}) == 1, (jnd, key)
    for i, w in enumerate(places):
        now = {key: row[i] for key, row in signs.items()}
        H, dH = complex(lambdify(s, felt.H)(1j * w)), complex(chained(scene, 1j * w))
        noticed = max(
            x.sign(name, now.__getitem__) if isinstance(x, Lattice) else now[name] for name, x in lattices.items()
        )
        assert (noticed > 0) is (margin(jnd, H, H + dH, w) > 0), (jnd, w)


# --- leading terms for fast devices ----------------------------------------------------------------------------------


def test_leading_terms_are_those_of_the_series_known_by_hand() -> None:
    """A fast filter adds its damping and takes inertia in proportion; of a delay each order is that of the exponential series."""
    found = expansion(PAPER)
    assert found.part(Part.REAL) == 2 * B * omega**2 * ZETA / OMEGA_N
    assert (found.part(Part.IMAG) - 2 * ZETA * omega * (M * omega**2 - K) / OMEGA_N).expand() == 0
    x = omega * symbols("tau", positive=True)
    late = expansion(hs.Scene(SPRING, (hs.effects.delay("5 ms"),)), order=5)
    assert late.part(Part.REAL).expand() == -K * x**2 / 2 + K * x**4 / 24
    assert late.part(Part.IMAG).expand() == (-K * x + K * x**3 / 6 - K * x**5 / 120).expand()


DEVICES: dict[str, Any] = {
    "a lag": lambda x: hs.effects.first_order_lag(f"{20 / x} rad/s"),
    "a low-pass": lambda x: hs.effects.second_order_lowpass(f"{50 / x} rad/s", "0.7"),
    "a delay": lambda x: hs.effects.delay(f"{Rational(1, 30) * x} s"),
    "a hold": lambda x: hs.effects.zero_order_hold(f"{Rational(1, 40) * x} s"),
    "a Pade delay": lambda x: hs.effects.pade_delay(f"{Rational(1, 20) * x} s", 2),
    "wave variables": lambda x: hs.effects.wave_variables(12, f"{Rational(1, 50) * x} s"),
    "four channels": lambda x: hs.effects.four_channel_teleoperator(1, 2, 30, 2, 40, 50, f"{Rational(1, 60) * x} s"),
}
COUPLED: dict[str, tuple[list[hs.Effect], list[str]]] = {
    **{name: ([], [name]) for name in DEVICES},
    "two behind a damper": ([hs.effects.shunt(b=2)], ["a lag", "wave variables"]),
    "one behind a cable": ([hs.effects.compliance(900, 3)], ["a hold"]),
}


@pytest.mark.dear("a delay-3", "one behind a cable-1")
@pytest.mark.few("a lag-1", "a delay-3", "a hold-0", "wave variables-1", "one behind a cable-1")
@pytest.mark.parametrize("order", [0, 1, 3])
@pytest.mark.parametrize("name", COUPLED)
def test_what_leading_terms_leave_falls_with_the_next_power_of_how_fast_devices_are(name: str, order: int) -> None:
    """With time constants a thousandth and a two-thousandth it is smaller by 2 to that power."""
    between, devices = COUPLED[name]
    env = hs.environments.mass_spring_damper(2, 15, 100)
    made = [hs.Scene(env, (*between, *(DEVICES[x](Rational(1, k)) for x in devices))) for k in (1, 1000, 2000)]
    found = expansion(made[0], order)
    assert len(found.terms) == order + 1
    with mpmath.workdps(60):
        at, left, sums = mpmath.mpc(0, 3), [], []
        for scene in made[1:]:
            values = {p.symbol: p.value for p in scene.parameters}
            sums.append(sum(lambdify(s, x.expression().xreplace(values), "mpmath")(at) for x in found.terms))
            left.append(abs(chained(scene, at) - sums[-1]))
        assert left[0] < mpmath.mpf(10) ** (-3 * (order + 1) + 4)
        assert left[1] == 0 or abs(left[0] / left[1] / 2 ** (order + 1) - 1) < 0.02
        parts = [lambdify(omega, found.part(x).xreplace(values), "mpmath")(mpmath.mpf(3)) for x in Part]
        assert abs(mpmath.mpc(*parts) - sums[-1]) < 1e-40


@pytest.mark.few("fu2019", "delayed-spring")
@pytest.mark.parametrize(
    "name",
    [
        x
        for x in hs.scene_names()
        if x not in ("admittance-display", "control-stick-in-detail", "geared-arm", "inertia-compensation")
    ],
)
def test_no_frequency_of_the_band_has_a_larger_error_than_the_bound_and_one_has_it(name: str) -> None:
    scene = hs.load_scene(name)
    found = expansion(scene)
    values = {p.symbol: p.value for p in scene.parameters}
    low, high = (float(x) for x in scene.band)
    grid = np.append(np.linspace(low, high, 4001)[1:-1] + 1e-7 * high, high)  # beside the undamped resonance
    exact = scene.distortion().compile()(grid)
    modulus = np.hypot(exact.environment_real, exact.environment_imag)
    for part, own in ((Part.REAL, exact.real), (Part.IMAG, exact.imag)):
        terms = lambdify([omega], found.part(part).xreplace(values).evalf(30), "numpy")(grid)
        error, bound = np.max(np.abs(own - terms) / modulus), found.bounds[part]
        assert bound is None or error <= float(bound) * (1 + 1e-9)
        assert bound is None or float(bound) == 0 or error > 0.99 * float(bound)


def test_higher_orders_are_closer() -> None:
    errors = [float(expansion(PAPER, order).bounds[Part.REAL]) for order in range(6)]
    assert all(later < earlier / 9 for earlier, later in zip(errors, errors[3:], strict=False))


Time = Annotated[Any, Slot(Dimension.TIME)]


def of_time(name: str, form: Any) -> hs.Effect:
    """A device that is fast where its time constant is short: a function of s times that."""

    @effect(name)
    def own(late: Time) -> Any:
        return form(s * late), 0, 0, 1

    return own("5 ms")


@pytest.fixture
def own_models() -> Iterator[None]:
    before = dict(EFFECTS)
    yield
    EFFECTS.clear()
    EFFECTS.update(before)


MADE: dict[str, tuple[Any, Any]] = {
    "divided": (lambda x: (exp(x) - 1 - x - x**2 / 2 - x**3 / 6) * 24 / x**4, lambda n: Rational(24, factorial(n + 4))),
    "divided often": (
        lambda x: (exp(x) - sum(x**n / factorial(n) for n in range(9))) * factorial(9) / x**9,
        lambda n: Rational(factorial(9), factorial(n + 9)),
    ),
    "arched": (lambda x: 2 * (cosh(x) - 1) / x**2, lambda n: Rational(2 * (n % 2 == 0), factorial(n + 2))),
    "slanted": (lambda x: sinh(x) / x / (1 - 2 * x), lambda n: Rational(2) ** n * (1 + Rational(n > 1, 24))),
    "bent": (lambda x: (3 + x) / (3 - x), lambda n: Rational(2 if n else 1, 3**n)),
}


@pytest.mark.usefixtures("own_models")
@pytest.mark.parametrize("name", MADE)
def test_leading_terms_of_a_users_own_device_are_its_taylor_series(name: str) -> None:
    """Also of one that divides by a high power of its time constant."""
    (form, known), k, order = MADE[name], Symbol("k", real=True), 3
    found = expansion(hs.Scene(SPRING, (of_time(name, form),)), order)
    [late] = found.fast
    assert len(found.terms) == order + 1
    for n, term in enumerate(found.terms):
        own = term.expression().xreplace(dict.fromkeys(term.expression().free_symbols - {s, late}, k))
        assert (own - k * (known(n) - int(n == 0)) * (s * late) ** n).expand() == 0, n


@pytest.mark.usefixtures("own_models")
def test_what_has_no_leading_terms_says_so() -> None:
    for name, grows in {"pushing": lambda x: 1 / x + x, "pulling": lambda x: (1 + x**2) / (x + x**2)}.items():
        assert "increases without bound" in refusal(expansion, hs.Scene(SPRING, (of_time(name, grows),)))
    assert "there is no high-bandwidth approximation" in refusal(expansion, hs.Scene(SPRING, (hs.effects.shunt(m=1),)))


def test_a_parameter_without_a_number_leaves_terms_without_a_bound() -> None:
    scene = hs.Scene(hs.environments.mass_spring_damper(k=Symbol("k")), (hs.effects.first_order_lag(Symbol("a")),))
    found = expansion(scene)
    assert found.bounds == {}
    assert found.part(Part.IMAG) == -K * omega / found.fast[0]
    assert "What is left out" not in plain(hs.derive(scene).document(), 100)


# --- groups without a unit -------------------------------------------------------------------------------------------


def test_the_papers_five_parameters_become_three_groups_and_there_and_back_is_the_same_formula() -> None:
    found = groups(PAPER)
    assert {g.symbol.name: g.value for g in (found.frequency, *found.groups)} == {
        "x": omega * sqrt(M) / sqrt(K), "zeta_env": B / (2 * sqrt(K * M)), "rho": OMEGA_N * sqrt(M) / sqrt(K), "zeta": ZETA,
    }  # fmt: skip
    form, original = found.forwards(found.distortion.relative_imag), PAPER.symbolic_distortion().relative_imag
    assert (found.back(form) ** 2 - original**2).together().expand() == 0


@pytest.mark.dear("stick-with-friction")
@pytest.mark.parametrize("name", often(hs.scene_names(), QUICK_SCENES.__contains__))
def test_the_ratios_of_the_dimensionless_scene_are_the_scenes_own_at_other_values(name: str) -> None:
    """Exact: tenth powers of all units, so that the roots in the groups come out even; as many groups as Buckingham counts."""
    scene = hs.load_scene(name)
    found = groups(scene)
    orders = {x for o in scene.chain.ring.orders for x in o.free_symbols}
    fixed = {p.symbol: p.value for p in scene.parameters if p.symbol in orders}
    at = {omega: Rational(7, 5) ** 10}
    numbers = {p.symbol: Rational(n + 2, 3) ** 10 for n, p in enumerate(scene.parameters)} | fixed
    own = scene.chain.steps.at(numbers | at)
    values = {g.symbol: g.value.xreplace(numbers | at) for g in (found.frequency, *found.groups)}
    steps = found.chain.replaced(found.values).steps.at({**values, omega: values[found.frequency.symbol]})
    for key in ("ratio_real", "ratio_imag", "relative_real"):
        assert abs((own[key] - steps[key]).evalf(40)) < 10**-30
    perceived, scale = own["perceived_real"], found.stiffness.xreplace(numbers)
    assert abs((perceived - scale * steps["perceived_real"]).evalf(40)) < 10**-25 * abs(perceived.evalf())
    assert len(found.groups) == len(scene.parameters) - len(found.units) - len(orders)
    assert len({g.symbol for g in (found.frequency, *found.groups)}) == len(found.groups) + 1


SIZES = {
    "m1": (1, 0), "b1": (1, -1), "k1": (1, -2), "m2": (1, 0), "b2": (1, -1), "k2": (1, -2), "tau": (0, 1), "b": (1, -1),
    "omega_n": (0, -1), "zeta": (0, 0),
}  # fmt: skip
"""Powers of mass and of time."""


def test_groups_have_no_unit_and_say_which_sign_they_have() -> None:
    """Scaled by other units of mass and time each group is what it was; parameters > 0 make a group > 0."""
    scene = hs.Scene(
        hs.environments.two_mass("0.5 kg", "4 N*s/m", "200 N/m", "0.3 kg", "1 N*s/m", "120 N/m"),
        (hs.effects.delay("5 ms"), hs.effects.shunt(b="-1 N*s/m"), hs.effects.second_order_lowpass("30 rad/s", "0.5")),
    )
    found, mass, time = groups(scene), Rational(9), Rational(1, 4)
    powers = {p.symbol: SIZES[p.symbol.name.split("_shunt")[0]] for p in scene.parameters}
    scale = {x: x * mass**m * time**t for x, (m, t) in powers.items()} | {omega: omega / time}
    for group in (found.frequency, *found.groups):
        assert (group.value.xreplace(scale) / group.value).expand() == 1
        own = group.value.has(Symbol("b_shunt", real=True), Symbol("b", real=True))
        assert group.symbol.is_positive is (None if own else True)
    assert len({g.symbol.name for g in found.groups}) == len(found.groups) == len(scene.parameters) - len(found.units)


def test_an_order_of_a_power_of_s_is_no_group_and_without_a_scale_of_time_omega_stays() -> None:
    tissue = hs.environments.spring_pot("80 N*s^0.3/m", "0.3", "50 N/m")
    found = groups(hs.Scene(tissue, (hs.effects.first_order_lag("20 rad/s"),)))
    assert {str(x): v for x, v in found.values.items() if str(x) == "alpha"} == {"alpha": Rational(3, 10)}
    assert "alpha" not in {g.symbol.name for g in found.groups}
    still = groups(hs.Scene(hs.environments.mass_spring_damper(k="100 N/m"), (hs.effects.shunt(k="5 N/m"),)))
    assert still.frequency.value == omega
    assert [g.symbol.name for g in still.groups] == ["kappa"]


def test_names_of_groups_and_of_the_frequency_are_those_of_no_pure_number() -> None:
    values = {"x": 0.5, "zeta_env": 2, "b": "30 N*s/m", "k": "100 N/m", "m": "1.8 kg"}
    stick = hs.environments.expression("m*s^2 + x*b*s + zeta_env*k", parameters=values)
    found = groups(hs.Scene(stick, (hs.effects.second_order_lowpass("80 rad/s", 0.5),)))
    names = [g.symbol.name for g in (found.frequency, *found.groups)]
    assert len(set(names)) == len(names)
    assert {"x", "zeta_env", "zeta"} < set(names[1:])


@pytest.mark.parametrize("place", range(4))
def test_units_that_do_not_fit_in_any_entry_of_a_chain_matrix_are_refused(place: int) -> None:
    """A frequency where a number, a stiffness, a compliance and a number belong; the last entry may be nothing."""
    env = hs.environments.mass_spring_damper(m="2 kg", k="100 N/m")
    for others in (["1", "0", "0", "1"], ["1", "k*2", "1/k", "0"]):
        entries = [*others[:place], "w", *others[place + 1 :]]
        port = hs.effects.two_port(*entries, parameters={"k": "50 N/m", "w": "3 rad/s"})
        assert "its units contradict each other" in refusal(groups, hs.Scene(env, (port,)))
    unknown = hs.environments.expression("k + b*s", parameters={"k": "100 N/m", "b": 3})
    assert "give each parameter its unit" in refusal(groups, hs.Scene(unknown, (hs.effects.delay("1 ms"),)))


def test_a_ratio_that_is_the_threshold_everywhere_neither_exceeds_it_nor_stays_below() -> None:
    """A spring that is felt at 11/10 of its stiffness, with c = 1/10: p_r = 0; it was -1."""
    scene = hs.Scene(100, (), (0, 15), 0.1, rendered=110)
    assert hs.derive(scene, keep=())["p_r"] == 0
    assert hs.derive(scene, keep=()).changeovers("env") == ()
    with pytest.raises(hs.SceneError, match='"environment" is none: give "env" or "perc"'):
        hs.derive(scene).changeovers("environment")


# --- names, pages, the command ---------------------------------------------------------------------------------------


def test_every_name_of_a_quantity_is_found_however_it_is_typed(call: Any) -> None:
    for name in QUANTITIES:
        for typed in (name, name.lower(), name.replace(" ", "_"), f" {name.upper()}! "):
            assert bare(typed) == bare(name)
            assert bare(listed_name(typed) or "") == bare(name)
    assert listed_name("dq") is None
    for other in ("|H_env|", "|dH|", "-dH", "H_env^2"):  # bars, powers and a minus mean something
        assert listed_name(other) is None
    one, two = (call("derive", "fu2019", "--of", name)[1] for name in ("Re dH", "re_dh"))
    assert one == two
    assert "Re dH = " in one


def test_what_is_kept_as_a_symbol_is_what_was_asked_for() -> None:
    kept = hs.derive("fu2019", keep=["omega_n", "zeta"])
    assert ({x.name for x in kept.kept}, kept.kept_thresholds) == ({"omega_n", "zeta"}, ())
    assert hs.derive("fu2019", keep="evaluation.jnd").kept_thresholds == (Part.REAL, Part.IMAG)
    assert hs.derive("fu2019", keep=())["H_perc"].free_symbols == {s}


@pytest.mark.slow
@pytest.mark.few(1)
@pytest.mark.parametrize("kept", [(), ("omega_n",), ("m", "zeta"), ("m", "b", "k", "omega_n", "zeta")])
def test_the_table_of_parameters_says_which_stay_symbols_and_what_all_are_in_the_scene(kept: tuple[str, ...]) -> None:
    values = {"m": "1.8", "b": "15", "k": "100", "omega_n": "80", "zeta": "0.5"}
    shown = plain(hs.derive(PAPER, keep=kept).document())
    for name, value in values.items():
        written = {"omega_n": "ω_n", "zeta": "ζ"}.get(name, name)
        [row] = [x.split() for x in shown.splitlines() if x.split()[:1] == [written]]
        state = [] if len(kept) in (0, len(values)) else ["kept" if name in kept else "inserted"]
        assert row[-1 - len(state) :] == [value, *state]


@pytest.mark.dear("wheel-with-encoder")
@pytest.mark.parametrize("name", ["geared-arm", "wheel-with-encoder"])
def test_no_output_names_a_describing_function_that_it_does_not_explain(name: str, call: Any) -> None:
    unknown = re.compile("quantiser|limiter|deadband|following|lagging")
    for form in ("text", "latex", "json", "sympy"):
        status, out, _ = call("derive", name, "--to", form, "--dimensionless")
        assert (status, unknown.search(out)) == (0, None)
        assert out.count("n_p") > 2
    shown = call("derive", name, "--of", "Re dH")[1]
    assert [x.split(" = ")[0].strip() for x in shown.splitlines() if " = " in x][:3] == ["Re dH", "u", "n_p"]
    sizes = {p.symbol.name for p in hs.load_scene(name).parameters}
    assert sizes <= set(re.findall(r"\w+", call("derive", name, "--to", "c")[1].partition("(double omega")[2][:200]))


def test_a_sensitivity_to_a_size_of_a_describing_function_is_no_formula(call: Any) -> None:
    status, _, err = call("derive", "geared-arm", "--of", "d omega_r/d gap")
    assert status == 2
    assert "size in a describing function" in err


@pytest.mark.slow
@pytest.mark.few("delayed-spring")
@pytest.mark.parametrize("name", often(hs.scene_names(), QUICK_SCENES.__contains__))
def test_every_shipped_scene_has_a_page_in_each_form(name: str, call: Any) -> None:
    for form in ("text", "latex", "mathml", "json"):
        status, out, err = call("derive", name, "--to", form)
        assert (status, err) == (0, "")
        if form == "json":
            assert json.loads(out)["schema"] == "haptisym.derivation/1"
        if form == "mathml":
            ElementTree.fromstring(f"<div>{out}</div>")


@pytest.mark.slow
@pytest.mark.few("delayed-spring")
@pytest.mark.parametrize("name", ["delayed-spring", "fu2019"])
def test_the_json_of_a_page_says_the_same_as_its_text(name: str, call: Any) -> None:
    d = hs.derive(name)
    document = d.to_dict()
    assert json.loads(call("derive", name, "--json")[1]) == document
    assert document["operations"] == d.steps.operations
    flat = re.sub(r"\s+", " ", spelt(call("derive", name)[1].replace("≈", "~"), "ascii"))
    assert all(row["text"] in flat for section in document["sections"] for row in section["equations"])


@pytest.mark.slow
@pytest.mark.parametrize("name", ["fu2019", "organ-tissue"])
def test_the_latex_of_a_page_compiles(name: str, call: Any, tmp_path: Path) -> None:
    body = call("derive", name, "--to", "latex")[1]
    head = r"\documentclass[a4paper,11pt]{article}\usepackage{amsmath}\usepackage[margin=2.5cm]{geometry}"
    check_layout(compiled(rf"{head}\begin{{document}}{body}\end{{document}}", tmp_path))


@pytest.mark.parametrize("language", ["numpy", "c", "octave", "javascript"])
def test_code_keeps_the_parameters_that_are_asked_for(language: str, call: Any) -> None:
    out = call("derive", "fu2019", "--to", language, "--keep", "omega_n")[1]
    assert "omega_n" in out
    assert "zeta = 0.5" in out


@pytest.mark.parametrize(
    "arguments", [("--keep", "q"), ("--of", "Re dQ"), ("--to", "fortran"), ("--keep",), ("--to", "c", "--of", "dH")]
)
def test_a_wrong_request_is_one_clear_message(arguments: tuple[str, ...], call: Any) -> None:
    status, out, err = call("derive", "fu2019", *arguments)
    assert (status, out) == (2, "")
    assert len(err.strip()) > 20
    assert "Traceback" not in err


@pytest.mark.dear("d omega_r/d m")
@pytest.mark.parametrize("name", ["omega_env", "omega_perc", "omega_i", "d omega_r/d m", "F_si_perc", "F_d_env"])
def test_solutions_slopes_and_forces_can_be_asked_for(name: str, call: Any) -> None:
    status, out, err = call("derive", "delayed-spring" if name == "omega_i" else "fu2019", "--of", name)
    assert (status, err) == (0, "")
    assert name in out.replace("ω", "omega").replace("(d m)", "d m").replace("F_si_perc(omega j)", "F_si_perc")


@pytest.mark.slow
def test_a_chain_of_thirty_effects_is_derived_in_steps_without_being_multiplied_out() -> None:
    devices = [
        (hs.effects.shunt(m="0.001"), hs.effects.second_order_lowpass(9000 + i, "0.7"), hs.effects.compliance(10**6))
        for i in range(10)
    ]
    wall = hs.environments.mass_spring_damper(2, 15, 100)
    text = str(hs.derive(hs.Scene(wall, tuple(x for row in devices for x in row), (0, 15))))
    assert "H_env(s) = m s^2 + b s + k" in text
    assert "Closed forms of this chain are long" in text


# --- what a distortion answers by itself -------------------------------------------------------------------------------

MASS, Y = Symbol("x"), Symbol("y")
LAGS = hs.distort(MASS * Symbol("s") ** 2 + Y, 1 / (1 + Symbol("s") / OMEGA_N))


def ratios(d: hs.Distortion, at: float) -> dict[str, float]:
    """Of a distortion without symbols, from H_env and H_perc as they are written."""
    env, perc = (complex(lambdify(s, x, "mpmath")(mpmath.mpc(0, at))) for x in (d.environment, d.perceived))
    return {"real": abs((perc - env).real / abs(env)), "imag": abs((perc - env).imag / abs(env))}


@pytest.mark.parametrize("part", ["real", "imag"])
def test_crossings_of_a_distortion_are_where_its_ratio_is_the_threshold(part: str) -> None:
    numbers = hs.load_scene("fu2019").distortion()
    told = [float(x) for x in numbers.crossings(part, 0.1)]
    assert [ratios(numbers, x)[part] for x in told] == pytest.approx(len(told) * [0.1], rel=1e-12)
    on_band = [float(x.omega) for x in hs.evaluate("fu2019").crossings if x.criterion.name == part]
    assert [x for x in told if x < 15] == on_band
    assert [x.digits(30) for x in numbers.crossings(part, 0.1, band=(0, 9))] == [
        x.digits(30) for x in numbers.crossings(part, 0.1) if float(x) < 9
    ]


@pytest.mark.parametrize("part", ["real", "imag"])
def test_formulas_of_crossings_in_the_symbols_given_hold_where_their_conditions_do(part: str) -> None:
    level = Symbol("level")
    d = hs.distort(100 + 0 * Symbol("s"), 1 / (1 + Symbol("s") / Y))
    found = d.crossings(part, level)
    values = {level: Rational(3, 10), Y: 20}
    places = sorted(float(x.omega.subs(values)) for x in found if all(y.subs(values) >= 0 for y in x.conditions))
    x = 0.3  # x^2/(1 + x^2) = c, and x/(1 + x^2) = c
    own = (
        [20 * (x / (1 - x)) ** 0.5]
        if part == "real"
        else [20 * (1 + sign * (1 - 4 * x * x) ** 0.5) / (2 * x) for sign in (-1, 1)]
    )
    assert places == pytest.approx(own)
    poly = d.threshold_polynomial(part, level)
    assert [
        abs(float(poly.eval(w**2).subs(values))) < 1e-6 * abs(float(poly.LC().subs(values))) * w**4 for w in own
    ] == [True] * len(own)


def test_all_changeovers_are_told_not_the_lowest_alone() -> None:
    """k (w^2 - omega^2)/... of two springs and masses: three zeros of Re H_env; behind a lag the real part has others."""
    scene = hs.load_scene(FLEXIBLE)
    env, perc = scene.distortion().changeovers
    for told, system in ((env, "environment"), (perc, "perceived")):
        form = lambdify(s, getattr(scene.distortion(), system), "numpy")
        at = np.linspace(1e-3, 4 * float(told[-1]), 400_001)
        real = np.real(form(1j * at))
        near = at[1:][(np.sign(real[1:]) != np.sign(real[:-1])) & (abs(real[1:]) < 1e6 * np.median(abs(real)))]
        assert all(np.abs(near - float(x)).min() < 1e-3 * float(x) for x in told)
    [own] = hs.distort(M * Symbol("s") ** 2 + K).changeovers.environment
    assert own.omega == sqrt(K) / sqrt(M)


@pytest.mark.parametrize("name", ["fu2019", "delayed-spring", "zener-tissue", "admittance-display"])
def test_leading_terms_are_what_the_distortion_nears(name: str) -> None:
    d = hs.load_scene(name).distortion()
    ends = [0] if name == "delayed-spring" else [0, oo]
    for at in ends:
        w = 1e-4 if at == 0 else 1e7
        found, exact = d.asymptote(at), complex(lambdify(s, d.distortion, "mpmath")(mpmath.mpc(0, w)))
        own = complex(found.distortion.subs(s, 1j * w))
        assert abs(own - exact) < 1e-2 * abs(exact)
        for form, value in ((found.real, exact.real), (found.imag, exact.imag)):
            assert float(form.subs(omega, w)) == pytest.approx(value, rel=1e-2, abs=1e-9 * abs(exact))


def test_a_bandwidth_is_that_of_the_evaluation() -> None:
    for name in ("fu2019", "steering-wheel"):
        scene = hs.load_scene(name)
        assert scene.distortion().bandwidth(scene.threshold.real).digits(20) == hs.evaluate(scene).bandwidth.digits(20)
    assert hs.distort(100 + Symbol("s")).bandwidth(0.1) == oo
    # Behind a delay of 1/50 s, Im of exp(-j x) is -sin x and exceeds first; no ratio of it exceeds 2.
    late = hs.distort(100 + 0 * s, exp(-s / 50))
    assert late.bandwidth(0.1).digits(20) == str((50 * asin(Rational(1, 10))).evalf(20))
    with pytest.raises(hs.SceneError, match="no ratio exceeds c up to 25600 rad/s.*give a band"):
        late.bandwidth(2.1)
    assert hs.distort(100 + 0 * Symbol("s"), 2 + 0 * Symbol("s")).bandwidth(0.1) == 0


@pytest.mark.parametrize("modules", ["math", "numpy", "mpmath"])
def test_a_plain_function_has_the_values_of_the_closed_form(modules: str) -> None:
    f = LAGS.lambdify("ratio_imag", modules)
    own = LAGS.compile(of=["ratio_imag"])(3.0, omega_n=20.0, x=2.0, y=100.0).ratio_imag
    assert float(f(3.0, 20.0, 2.0, 100.0)) == pytest.approx(float(own), rel=1e-12)


def test_a_plain_function_computes_whole_numbers_lists_and_constants_as_floats() -> None:
    """Four lags at 499 rad/s, where whole numbers of 64 bits overflow, in exact complex fractions."""
    T, named = Symbol("T"), Symbol("lambda")
    d = hs.distort(named, *[1 / (1 + T * s)] * 4)
    lag = 1 / (1 + 499 * I)
    exact = (2 * (lag**4 - 1)).expand(complex=True).as_real_imag()[0]
    ratio = d.lambdify("real")
    for whole in (np.array([499]), [499], 499):
        assert ratio(whole, T=1, lambda_=2) == pytest.approx(float(exact), rel=1e-12)
    assert ratio([499], T=1, lambda_=2) == pytest.approx(d.compile()([499], T=1, lambda_=2).real, rel=1e-12)
    assert d.lambdify("modulus")([1, 2, 3], T=1, lambda_=2).tolist() == [2, 2, 2]


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        (lambda d: d.crossings("reel"), "part"), (lambda d: d.crossings("real", -1), "c: "), (lambda d: d.crossings("real", "0.1 m"), "c: "),
        (lambda d: d.bandwidth(0.1), "needs values for"), (lambda d: d.asymptote(1), "at: "), (lambda d: d.lambdify("rael"), 'did you mean "real"'),
        (lambda d: hs.distort(100 + s, exp(-s)).crossings("real", 0.1), "give a band"), (lambda d: hs.distort(100 + s, exp(-s)).asymptote(oo), "delay"),
        (lambda d: hs.distort(100 + s, exp(-s)).crossings("real", 0.1, band=(3, 2)), "band"),
    ],
)  # fmt: skip
def test_what_makes_no_sense_of_a_distortion_is_said(asked: Any, said: str) -> None:
    with pytest.raises(hs.SceneError, match=said):
        asked(LAGS)


def test_closed_forms_are_in_the_frequency_that_was_given() -> None:
    own, laplace = Symbol("omega"), Symbol("s")
    given = (M * laplace**2 + B * laplace + K, 1 / (1 + laplace / OMEGA_N))
    d, plain_one = hs.distort(*given, omega=own), hs.distort(*given)
    for name in ("real", "imag", "ratio_real", "ratio_imag", "relative_real", "relative_imag", "modulus"):
        assert getattr(d, name) == getattr(plain_one, name).xreplace({omega: own}), name
        assert not getattr(d, name).has(omega)
    assert not d.perceived_properties.mass.has(omega)
    assert d.perceived_properties.damping == plain_one.perceived_properties.damping.xreplace({omega: own})
    assert d.asymptote().imag == plain_one.asymptote().imag.xreplace({omega: own})
    values = {M: 2, B: 1, K: 100, OMEGA_N: 20}
    assert d.lambdify("real", "math")(8.0, 1.0, 100.0, 2.0, 20.0) == pytest.approx(
        float(d.real.subs(own, 8).subs(values))
    )
    with pytest.raises(hs.SceneError, match="omega"):
        hs.distort(*given, omega="w")


# --- one value by every way ------------------------------------------------------------------------------------------

CHAIN = 3e-20, 3e-20, 0.5000001  # ulp: sixty digits have room for cancellation; balls are rounded once


def agree(found: Any) -> None:
    assert found.points > 0
    assert all(
        found.worst[way] <= most
        for way, most in zip(("closed form", "named steps", "ball arithmetic"), CHAIN, strict=True)
    ), found
    assert found.worst["compiled"] < 1e12, found  # Re dH of a late mass is some 1e-9 of |H_env| at slow motion


@pytest.mark.few("zero-order-hold", "coulomb-friction", "two-port", "compliance")
@pytest.mark.parametrize("model", sorted({*EFFECTS, *ENVIRONMENTS}))
def test_every_model_in_symbols_has_one_value_by_every_way(model: str) -> None:
    agree(hs.verify(CATALOGUE[model].symbolic_distortion(), 8, seed=3))


@pytest.mark.few(6)
@pytest.mark.dear("89", "174")
@pytest.mark.parametrize("seed", range(200))
def test_a_random_chain_in_symbols_has_one_value_by_every_way(seed: int) -> None:
    agree(hs.verify(random_scene(case(Seeded(seed))).symbolic_distortion(), 3, seed=seed))


def lags(count: int, *others: hs.Effect) -> hs.Distortion:
    each = (hs.effects.first_order_lag(Symbol(f"w_{n}", positive=True)) for n in range(1, count + 1))
    return hs.distort(hs.environments.mass_spring_damper(M, B, K), *each, *others)


@pytest.mark.parametrize(
    "others",
    [
        (hs.effects.delay(Symbol("tau", positive=True)), hs.effects.zero_order_hold(Symbol("T", positive=True))),
        (hs.effects.shunt(m=Symbol("m_d"), b=Symbol("b_d")), *(hs.effects.compliance(Symbol(f"k_{n}", positive=True), Symbol(f"d_{n}", positive=True)) for n in range(2))),
    ],
    ids=["in series", "not in series"],
)  # fmt: skip
def test_the_formulas_of_a_long_chain_grow_by_as_much_with_each_effect_and_stay_true(
    others: tuple[hs.Effect, ...],
) -> None:
    chains = [lags(n, *others) for n in (4, 6, 8)]
    sizes = [count_ops(d.real) + count_ops(d.imag) for d in chains]
    assert sizes[2] - sizes[1] == sizes[1] - sizes[0] <= 2 * 140
    steps = [d.steps().operations for d in chains]
    assert steps[2] - steps[1] == steps[1] - steps[0] < 2 * 25
    agree(hs.verify(chains[1], 3))


def test_a_wrong_formula_is_noticed_by_where_it_stands() -> None:
    right, other = (
        lags(1),
        hs.distort(
            hs.environments.mass_spring_damper(M, B, 1.0001 * K),
            hs.effects.first_order_lag(Symbol("w_1", positive=True)),
        ),
    )
    found = hs.verify(replace(right, perc=other.perc), 5)  # the chain of one, the lowest terms of the other
    assert found.worst["closed form"] > 1e6
    assert found.worst["named steps"] < 1e-20
    assert found.worst["ball arithmetic"] <= 0.5


@pytest.mark.parametrize(
    "d",
    [
        hs.distort(hs.environments.mass_spring_damper(k=K), hs.effects.wave_variables(B, Symbol("tau", positive=True))),
        hs.distort(hs.environments.mass_spring_damper(M, B, K), hs.effects.delay(Symbol("tau", positive=True)), hs.effects.first_order_lag(OMEGA_N)),
        hs.distort(hs.environments.zener(K, M, B), hs.effects.compliance(Symbol("c", positive=True))),
    ],
    ids=["a spring behind a link", "late", "tissue behind a cable"],
)  # fmt: skip
def test_a_slow_hand_feels_what_the_taylor_series_begins_with(d: hs.Distortion) -> None:
    values = {x: Rational(n + 3, 4) for n, x in enumerate(sorted(d.free_symbols, key=str))}
    H = lambdify(s, d.chain.at(values).perceived(range(len(d.chain.matrices))).expression(), "mpmath")
    with mpmath.workdps(60):
        nodes = [mpmath.expjpi(mpmath.mpf(n) / 16) / 50 for n in range(32)]  # Cauchy's integral about 0
        series = [sum(H(z) / z**n for z in nodes) / 32 for n in range(3)]
        for found, expected in zip(d.low_frequency, series, strict=True):
            assert abs(mpmath.mpmathify(found.xreplace(values).evalf(30)) - expected) < 1e-12


def test_a_link_in_free_space_is_felt_as_the_mass_b_tau() -> None:
    tau = Symbol("tau", positive=True)
    felt = hs.distort(hs.environments.mass_spring_damper(k=K), hs.effects.wave_variables(B, tau)).low_frequency
    assert (felt.stiffness, felt.mass.subs(K, 0)) == (B * K / (B + K * tau), B * tau)


def test_a_distortion_is_derived_in_its_own_symbols() -> None:
    q, y = symbols("q y", positive=True)
    d = hs.distort(hs.environments.mass_spring_damper(k=y), hs.effects.first_order_lag(q))
    found = hs.derive(d)
    assert (found["Re dH"], found["H_perc"]) == (d.real, d.perceived)
    first = d.crossings("real", Symbol("c", positive=True))[0]
    assert found.crossings(Part.REAL)[0].omega == first.omega
    with pytest.raises(hs.SceneError, match="keep"):
        hs.derive(d, keep=["q"])


def test_of_a_distortion_of_expressions_no_units_are_told_or_taken_for_granted() -> None:
    k, tau, w, zeta = symbols("k tau w zeta", positive=True)
    device = w**2 / (hs.s**2 + 2 * zeta * w * hs.s + w**2)
    found = hs.derive(hs.distort(k + hs.s, exp(-hs.s * tau), device, 1 / (hs.s + 5)))
    page = str(found)
    assert page.startswith("Distortion\n\nDynamics")
    assert "--of" not in page
    assert found["p_r"].free_symbols == {k, tau, w, zeta, omega, c}
    assert 'derivation["p_r"] has it' in page
    assert "no unit of k is known" in refusal(getattr, found, "groups")
    assert "effects.delay(tau)" in refusal(found.expansion, 2)
    known = hs.derive(hs.distort(hs.environments.mass_spring_damper(k=k), hs.effects.delay(tau)))
    assert known.expansion(2).part(Part.REAL) == -k * tau**2 * omega**2 / 2


@pytest.mark.few("organ-tissue", "fu2019", "position-force-teleoperation")
@pytest.mark.parametrize("name", hs.scene_names())
def test_a_script_of_sympy_makes_the_parts_of_the_distortion(name: str, call: Any) -> None:
    """Line by line with numbers for its symbols, against its own H_perc - H_env at s = j omega."""
    lines = [x for x in call("derive", name, "--to", "sympy")[1].splitlines() if not x.startswith(("#", '"'))]
    known: dict[str, Any] = {}
    exec(next(x for x in lines if x.startswith("from sympy")), known)  # noqa: S102 - it is what was written
    made = [x.split(" = ")[0] for x in lines if " = Symbol(" in x]
    known |= {x: Float(Rational(n + 3, 7), 50) for n, x in enumerate(made)}
    known["s"] = I * known["omega"]
    for line in (x for x in lines if " = " in x and " = Symbol(" not in x):
        exec(line, known)  # noqa: S102
    change = complex(known["H_perc"] - known["H_env"])
    assert (complex(known["real"]), complex(known["imag"])) == pytest.approx((change.real, change.imag), rel=1e-13)
    assert float(known["ratio_imag"]) == pytest.approx(abs(change.imag) / abs(complex(known["H_env"])), rel=1e-13)


@pytest.mark.parametrize("count", [1, 6, 9])
def test_holds_one_after_the_other_keep_their_stiffness(count: int) -> None:
    """(1 - exp(-s T))/(s T) is exp(-s T/2) sinh(s T/2)/(s T/2): 1 - s T/2 + s^2 T^2/6 ..., and that to a power."""
    T, x = symbols("T x", positive=True)
    hold = (1 - exp(-x * T)) / (x * T)
    d = hs.distort(K + B * s, *[hs.effects.zero_order_hold(T)] * count)
    expected = ((K + B * x) * (hold.series(x, 0, 5).removeO()) ** count).expand()
    assert [(y - expected.coeff(x, n)).expand() for n, y in enumerate(d.low_frequency)] == [0, 0, 0]
    assert (d.asymptote().distortion + count * K * T * s / 2).expand() == 0


def test_names_that_meet_are_kept_apart_or_refused() -> None:
    T, c, W, q = symbols("T c W q", positive=True)
    spring, laplace = K + 0 * Symbol("s"), Symbol("s")
    steps = hs.distort(spring, 1 / (1 + T * laplace), omega=Symbol("M")).steps("real")
    plain_ones = hs.distort(spring, 1 / (1 + T * laplace)).steps("real")
    at = {K: Rational(3), T: Rational(2)}
    assert steps.at({**at, Symbol("M"): Rational(5)}) == plain_ones.at({**at, omega: Rational(5)})
    for wrong in (T, laplace):
        with pytest.raises(hs.SceneError, match="omega"):
            hs.distort(spring, 1 / (1 + T * laplace), omega=wrong)
    with pytest.raises(hs.SceneError, match="c is a parameter"):
        hs.distort(spring, 1 / (1 + c * laplace)).crossings("real", c)
    renamed, square = symbols("c_ W_", positive=True)
    for called in (c, W):
        d = hs.distort(spring, 1 / (1 + called * laplace))
        [found] = [x.omega for x in d.crossings("real")]
        plain_one = hs.distort(spring, 1 / (1 + T * laplace))
        [expected] = [x.omega for x in plain_one.crossings("real")]
        assert found == expected.xreplace({c: renamed if called == c else c, T: called})
        assert d.threshold_polynomial("real", 0.1).gen == (square if called == W else W)
    own = Symbol("w", positive=True)
    [found, *_] = hs.distort(spring, 1 / (1 + T * laplace), omega=own).crossings("imag", q)
    assert found.equation.has(own)
    assert not found.equation.has(omega)
    called = Symbol("sqrt", positive=True)
    d = hs.distort(called + 2 * laplace, 1 / (1 + T * laplace))
    assert d.lambdify("ratio_imag")(3.0, 2.0, 5.0) == pytest.approx(
        float(d.ratio_imag.subs({omega: 3, T: 2, called: 5}))
    )
    agree(hs.verify(d, 3))


def test_parameters_of_too_few_dimensions_make_no_groups() -> None:
    """A mass alone, beside a stiffness of 0, makes no unit of stiffness."""
    scene = hs.Scene(hs.environments.mass_spring_damper(m="1 kg", k=0), (hs.effects.series("0.9"),))
    assert "the unit of k cannot be made of that of m" in refusal(groups, scene)
