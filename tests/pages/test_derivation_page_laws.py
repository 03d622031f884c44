"""Every closed form in the derivation of a report, at a few frequencies, against the physics in complex numbers."""

from __future__ import annotations

import cmath
import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from itertools import islice
from math import cos, pi, sin
from typing import Any

import pytest
from sympy import Expr, sympify

import haptisym as hs
from haptisym.kernel.symbols import s
from haptisym.pages.derivation import derivation
from haptisym.pages.sceneforms import DIFFERENCE, DYNAMICS, FELT, RATIO_FORMS, RELATIVE, SceneForms
from haptisym.writing.document import Equations, Line, Paragraph, Section
from haptisym.writing.plain import said

E, F = hs.environments, hs.effects
SPRING = E.mass_spring_damper(k=100)
FREQUENCIES = (0.7, 3.0, 11.0, 29.0)
FORCE = {
    "multiplies the force by": lambda H, G: G * H,
    "adds the impedance": lambda H, Z: H + Z,
    "adds the compliance": lambda H, Y: H / (1 + Y * H),
}


@dataclass(frozen=True)
class Case:
    """A scene, its environment and what is felt as functions of s, and the numbers of its symbols by their names on the page."""

    scene: hs.Scene
    env: Any
    perc: Any
    values: dict[str, float]

    @property
    def shown(self) -> dict[str, Section]:
        return shown(self.scene)


@cache
def shown(scene: hs.Scene) -> dict[str, Section]:
    """The first four sections, by their titles; what follows has tests of its own."""
    found = islice(derivation(SceneForms(hs.evaluate(scene))), 4)
    return {str(x.title): x for x in found if isinstance(x, Section)}


M, B, K, WC, BS = 1.23456789, 3.1415926535, 97.531, 37.123456, 1.618033988
SCENES = {
    "lag": Case(
        hs.Scene(E.mass_spring_damper(m=2, b=3, k=100), (F.first_order_lag(20),)),
        lambda s: 2 * s * s + 3 * s + 100, lambda s: (2 * s * s + 3 * s + 100) * 20 / (s + 20),
        {"m": 2, "b": 3, "k": 100, "omega_c": 20},
    ),
    "long numbers": Case(
        hs.Scene(E.mass_spring_damper(m=str(M), b=str(B), k=str(K)), (F.first_order_lag(str(WC)),)),
        lambda s: M * s * s + B * s + K, lambda s: (M * s * s + B * s + K) * WC / (s + WC),
        {"m": M, "b": B, "k": K, "omega_c": WC},
    ),
    "long quotient": Case(
        hs.Scene(E.mass_spring_damper(b=str(B), k=str(K)), (F.first_order_lag(str(WC)), F.shunt(b=str(BS)))),
        lambda s: B * s + K, lambda s: (B * s + K) * WC / (s + WC) + BS * s,
        {"b": B, "k": K, "omega_c": WC, "b_shunt": BS},
    ),
    "long delay": Case(
        hs.Scene(E.mass_spring_damper(k=str(K)), (F.delay("12.3456789 ms"), F.shunt(b=str(BS)))),
        lambda s: K, lambda s: K * cmath.exp(-0.0123456789 * s) + BS * s, {"k": K, "tau": 0.0123456789, "b": BS},
    ),
    "in between": Case(
        hs.Scene(E.mass_spring_damper(k=100), (F.shunt(b=4), F.compliance(k=500))),
        lambda s: 100, lambda s: 1 / (1 / 500 + 1 / (100 + 4 * s)),
        {"k": 100, "b": 4, "k_2": 500},
    ),
    "delay": Case(
        hs.Scene(E.kelvin_voigt(k=100, b=3), (F.delay("10 ms"),)),
        lambda s: 100 + 3 * s, lambda s: (100 + 3 * s) * cmath.exp(-0.01 * s), {"k": 100, "b": 3, "tau": 0.01},
    ),
    "two-port": Case(
        hs.Scene(E.mass_spring_damper(b=3, k=100), (F.two_port("2", "s", "0.001*s", "3"), F.two_port("1", "0.5*s", "0", "1"))),
        lambda s: 3 * s + 100, lambda s: (2 * (3 * s + 100) + s) / (0.001 * s * (3 * s + 100) + 3) + 0.5 * s, {"b": 3, "k": 100},
    ),
    "clock": Case(
        hs.Scene(E.mass_spring_damper(k=100), (F.sampled_loop("10 ms", "tustin"),), rendered=E.kelvin_voigt(k=100, b=2)),
        lambda s: 100,
        lambda s: (100 + 2 * 200 * cmath.tanh(s * 0.005)) * (1 - cmath.exp(-0.01 * s)) / (0.01 * s),
        {"k": 100, "k_rendered": 100, "b": 2, "T": 0.01, "T_1": 0.01},
    ),
    "no effect": Case(hs.Scene(E.mass_spring_damper(b=3, k=100)), lambda s: 3 * s + 100, lambda s: 3 * s + 100, {"b": 3, "k": 100}),
}  # fmt: skip


def lines(section: Section) -> Iterator[Line]:
    for x in section.blocks:
        if isinstance(x, Equations):
            yield from x.lines


def words(section: Section) -> str:
    told = [said(x.words) for x in section.blocks if isinstance(x, Paragraph)]
    return " ".join(" ".join(told).replace("\xa0", " ").split())


def free_names(line: Line) -> set[str]:
    assert isinstance(line.value, Expr)
    return {x.name for x in line.value.free_symbols}


def value(form: Any, case: Case, omega: float) -> complex:
    assert isinstance(form, Expr)
    own = {**case.values, "omega": omega, "s": 1j * omega}
    return complex(form.xreplace({x: sympify(own[x.name]) for x in form.free_symbols}).evalf())


def truth(case: Case, omega: float) -> dict[str, complex]:
    env, perc = complex(case.env(1j * omega)), complex(case.perc(1j * omega))
    d = perc - env
    return {
        "H_env(s)": env, "H_perc(s)": perc, "H_env": env, "Re dH": d.real, "Im dH": d.imag, "|H_env|^2": abs(env) ** 2, "r_r": abs(d.real) / abs(env),
        "r_i": abs(d.imag) / abs(env), "Re(dH/H_env)": (d / env).real, "Im(dH/H_env)": (d / env).imag, "k_perc": perc.real,
        "m_perc": -perc.real / omega**2, "b_perc": perc.imag / omega,
    }  # fmt: skip


@pytest.mark.parametrize("name", SCENES)
def test_every_closed_form_of_a_derivation_has_the_value_that_the_physics_has(name: str) -> None:
    """Those after ≈ to six digits, all others exactly."""
    case, told = SCENES[name], set()
    for title in ("Dynamics", "Distortion", "Perceived properties"):
        for line in lines(case.shown[title]):
            left = said(line.left)
            for omega in FREQUENCIES:
                true = truth(case, omega)
                if left in true:
                    told.add(left)
                    close = 1e-4 if line.relation == "≈" else 1e-9
                    size = abs(true[left]) + close * abs(true["H_env"] if left[:3] in ("Re ", "Im ") else 1)
                    assert abs(value(line.value, case, omega) - true[left]) <= close * size, (left, omega)
    assert told >= set(truth(case, 1)) - {"H_env"}


@pytest.mark.parametrize("name", SCENES)
def test_the_effects_in_words_make_of_the_environment_what_is_felt(name: str) -> None:
    case = SCENES[name]
    told, forms = (
        words(case.shown["Dynamics"]),
        {said(x.left).replace("(s)", ""): x for x in lines(case.shown["Dynamics"])},
    )
    rows = re.findall(r"Effect (\d+), ([\w-]+), (.*?)\. ?(?=Effect|With|$)", told)
    assert [row[1] for row in rows] == [x.name for x in case.scene.effects]
    assert [int(row[0]) for row in rows] == [*range(1, len(rows) + 1)]
    for omega in FREQUENCIES:
        H = 100 + 2j * omega if name == "clock" else complex(case.env(1j * omega))  # what is rendered
        for number, _, what in rows:
            part = {x: value(forms[f"{x}_{number}"].value, case, omega) for x in "GZYABCD" if f"{x}_{number}" in forms}
            verb = next((x for x in FORCE if what.startswith(x)), None)
            if verb:
                [(letter, one)] = part.items()
                assert what.removeprefix(f"{verb} ").removesuffix(" in series") == f"{letter}_{number}"
                assert what.endswith(" in series") == (letter == "Y")
                H = FORCE[verb](H, one)
            elif what.startswith("is a two-port"):
                n = number
                assert what == f"is a two-port: H becomes (A_{n} H + B_{n})/(C_{n} H + D_{n})"
                H = (part["A"] * H + part["B"]) / (part["C"] * H + part["D"])
            else:
                assert what == "renders it with a clock (tustin): H becomes G_1 (H + Z_1)"
                H = part["G"] * (H + part["Z"])
        assert abs(H - case.perc(1j * omega)) <= 1e-9 * abs(H)


@pytest.mark.parametrize("name", SCENES)
def test_threshold_polynomials_are_positive_exactly_where_a_ratio_exceeds(name: str) -> None:
    case = SCENES[name]
    section = case.shown["Threshold polynomials"]
    kind = (
        "polynomials in ω, its powers, sines and cosines with"
        if name in ("delay", "long delay", "clock")
        else "polynomials in ω² with"
    )
    assert f"r_r exceeds exactly where p_r > 0 and r_i exceeds exactly where p_i > 0. These are {kind}" in words(
        section
    )
    forms = {said(x.left): x for x in lines(section)}
    assert set(forms) == {"p_r", "p_i"}
    both = set()
    for omega in (*FREQUENCIES, 0.2, 1.7, 5.0, 8.0, 17.0, 22.0, 50.0, 90.0):
        for part in "ri":
            excess = truth(case, omega)[f"r_{part}"].real - 0.1
            assert (value(forms[f"p_{part}"].value, case, omega).real > 0) == (excess > 0), (part, omega)
            both.add(excess > 0)
    assert both == ({False} if name == "no effect" else {True, False})


def test_what_is_rounded_is_marked_and_what_is_exact_is_not() -> None:
    for name, is_rounded in (("lag", False), ("long numbers", True)):
        case = SCENES[name]
        assert ("≈" in {x.relation for x in lines(case.shown["Threshold polynomials"])}) == is_rounded
        assert ("≈" in {x.relation for x in lines(case.shown["Distortion"])}) == is_rounded
        assert words(case.shown["Dynamics"]).endswith(
            "With the scene's values (here and below, long numbers are rounded to six digits after ≈):"
        )
        assert "With the scene's values the distortion is" in words(case.shown["Distortion"])
        assert "too long in symbols" not in words(case.shown["Distortion"])


def test_a_changeover_of_the_environment_and_as_felt_is_told_where_it_has_a_formula() -> None:
    """Re H_perc is zero, behind a lag, where (k - m w^2) wc + b w^2 is."""
    told = {said(x.left): value(x.value, SCENES["lag"], 1) for x in lines(SCENES["lag"].shown["Perceived properties"])}
    assert told["ω_env"] == pytest.approx(50**0.5)
    assert told["ω_perc"] == pytest.approx((100 * 20 / (2 * 20 - 3)) ** 0.5)
    assert "The lowest frequencies of changeover, while they are real and positive, are" in words(
        SCENES["lag"].shown["Perceived properties"]
    )
    assert "changeover" not in words(SCENES["no effect"].shown["Perceived properties"])


def test_what_stands_beside_adds_and_what_yields_adds_in_series() -> None:
    told = "Effect 1, shunt, adds the impedance Z_1. Effect 2, compliance, adds the compliance Y_2 in series."
    assert told in words(SCENES["in between"].shown["Dynamics"])
    assert "Effect 1, first-order-lag, multiplies the force by G_1." in words(SCENES["lag"].shown["Dynamics"])
    both = words(SCENES["two-port"].shown["Dynamics"])
    assert "Effect 1, two-port, is a two-port: H becomes (A_1 H + B_1)/(C_1 H + D_1)." in both
    assert "adds the impedance Z_2." in both


def test_what_a_controller_renders_is_told_as_dynamics_of_its_own() -> None:
    section = SCENES["clock"].shown["Dynamics"]
    assert "The controller renders H_rendered(s) for H_env(s)." in words(section)
    [rendered] = [x for x in lines(section) if said(x.left).startswith("H_rendered")][:1]
    assert value(rendered.value, SCENES["clock"], 3) == pytest.approx(100 + 6j)
    assert "The controller" not in words(SCENES["lag"].shown["Dynamics"])


def test_a_parameter_of_an_effect_with_a_long_name_has_its_number_below_and_one_with_a_short_name_keeps_it() -> None:
    """Unless another parameter is called so already."""
    text = " ".join(said(x.equation) for x in lines(SCENES["in between"].shown["Dynamics"]))
    assert "k_2" in text
    assert "Z_1(s) = b s" in text.replace("Z_1 =", "Z_1(s) =")
    assert "compliance" not in text
    taken = hs.Scene(
        E.expression("k_2 + 3*s", parameters={"k_2": "100 N/m"}), (F.shunt(b=4), F.compliance(k=500)),
    )  # fmt: skip
    both = {formula.name: short.name for formula, short in SceneForms(hs.evaluate(taken)).short_names.items()}
    assert both == {}
    free = SceneForms(hs.evaluate(SCENES["in between"].scene)).short_names
    assert {formula.name: short.name for formula, short in free.items()} == {"k_compliance": "k_2"}


def test_the_dynamics_stand_in_symbols_first_and_then_with_the_values_of_the_scene() -> None:
    for name in ("lag", "long numbers", "in between"):
        for title in ("Dynamics", "Distortion"):
            rows = [x for x in lines(SCENES[name].shown[title]) if said(x.left) in ("H_perc(s)", "Re dH")]
            assert [bool(free_names(x) - {"s", "omega"}) for x in rows] == [True, False]


def test_closed_forms_that_are_long_in_symbols_stand_in_numbers_and_say_so() -> None:
    chain = [F.shunt(m="0.1 kg", b=n) if n % 2 else F.compliance(k=400 + n, b=n) for n in range(1, 5)]
    found = shown(hs.Scene(SPRING, tuple(chain), (1, 9)))
    told = words(found["Distortion"])
    assert "has the parts (with the scene's values; too long in symbols)" in told
    assert "With the scene's values the distortion is" not in told
    for x in (x for section in (found["Distortion"], found["Perceived properties"]) for x in lines(section)):
        assert free_names(x) <= {"s", "omega"}
    [*_, perceived] = lines(found["Dynamics"])
    assert said(perceived.left) == "H_perc(s)"
    H = 100 + 0j
    for n in range(1, 5):
        z = 0.1 * 9 * -1 + 3j * n if n % 2 else 400 + n + 3j * n
        H = H + z if n % 2 else 1 / (1 / H + 1 / z)
    assert complex(perceived.value.subs(s, 3j).evalf()) == pytest.approx(H, rel=1e-4)  # type: ignore[union-attr]


@pytest.mark.parametrize("corners", [6, 7])
def test_the_functions_of_a_region_with_many_corners_are_counted_and_not_written(corners: int) -> None:
    """Two for each edge, and at most twelve are written."""
    turn = [2 * pi * n / corners for n in range(corners)]
    polygon = {"shape": "polygon", "corners": [[f"{0.1 * cos(x):.4f}", f"{0.1 * sin(x):.4f}"] for x in turn]}
    section = shown(hs.Scene(SPRING, (F.first_order_lag(20),), (1, 9), polygon))["Threshold polynomials"]
    told = "14 functions of ω decide what is noticed: too many to be written here."
    assert (words(section) == told) == (corners == 7)
    assert len([*lines(section)]) == (12 if corners == 6 else 0)
    assert ("Written up to a positive factor (to ten digits after ≈):" in words(section)) == (corners == 6)


@pytest.mark.parametrize("name", ["long numbers", "long quotient", "long delay", "in between"])
def test_closed_forms_in_numbers_are_near_and_those_that_are_not_rounded_exact(name: str) -> None:
    """Ratios too, which hold a root and a modulus."""
    case = SCENES[name]
    forms = SceneForms(hs.evaluate(case.scene))
    found = {
        said(x.left): x
        for group in (DYNAMICS, DIFFERENCE, RATIO_FORMS, RELATIVE, FELT)
        for x in forms.in_numbers(group)
    }
    assert set(found) == set(truth(case, 1.0)) - {"H_env"}
    assert ("≈" in {x.relation for x in found.values()}) == name.startswith("long")
    for left, line in found.items():
        assert free_names(line) <= {"s", "omega"}
        for at in FREQUENCIES:
            true = truth(case, at)[left]
            close = 2e-4 if line.relation == "≈" else 1e-9
            assert abs(value(line.value, case, at) - true) <= close * (
                abs(true) + 0.02 * abs(truth(case, at)["H_env"])
            ), (left, at)
