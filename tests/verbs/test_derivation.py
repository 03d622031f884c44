"""``derive``: formulas under the names of the field, their conditions, and the same answers as the certified ones."""

from __future__ import annotations

import json
import re
import xml.etree.ElementTree as ElementTree

import pytest
from marks import QUICK_SCENES, often
from pdflatex import check_layout, compiled
from sympy import Rational, sqrt

import haptisym as hs
from haptisym.commands.spelling import spelt
from haptisym.kernel import budget
from haptisym.kernel.symbols import X
from haptisym.verbs.derive.derivation import QUANTITIES
from haptisym.verbs.derive.entry import derive
from haptisym.writing.plain import plain

SHORT = ["fu2019", "delayed-spring", "undamped-resonance", "zener-tissue", "stick-with-friction"]


@pytest.mark.parametrize("name", often(SHORT, {"fu2019", "delayed-spring"}.__contains__))
def test_every_quantity_in_symbols_has_the_numeric_scenes_value(name: str) -> None:
    scene = hs.load_scene(name)
    symbolic, numeric = derive(scene), derive(scene, keep=())
    values = {p.symbol: p.value for p in scene.parameters} | {hs.omega: Rational(37, 7)}
    values |= {hs.s: Rational(5, 3)} | {symbolic.threshold(hs.Part.REAL): scene.threshold.real}
    for quantity in QUANTITIES:
        a, b = symbolic[quantity], numeric[quantity]
        left, right = (x.xreplace(values).evalf(40) for x in (a, b))
        if quantity in ("p_r", "p_i"):  # their scale is free
            assert (left > 0) == (right > 0)
        elif quantity.startswith("F_"):
            assert abs((left - right).expand().coeff(X).evalf(20)) < 1e-12
        else:
            assert abs(left - right) < 10**-30 * (1 + abs(right)), quantity


def test_the_sign_of_the_threshold_polynomial_is_that_of_ratio_minus_threshold() -> None:
    d = derive(hs.load_scene("fu2019"), keep=())
    for omega in (5, 7, 9, 11, 13, 15):
        for part, ratio in (("p_r", "r_r"), ("p_i", "r_i")):
            inside = d[ratio].xreplace({hs.omega: Rational(omega)}).evalf(30) - Rational(1, 10)
            assert (d[part].xreplace({hs.omega: Rational(omega)}) > 0) == (inside > 0)


@pytest.mark.parametrize("parameter", ["m", "b", "k", "omega_n", "zeta"])
def test_a_sensitivity_is_the_slope_of_the_certified_crossing(parameter: str) -> None:
    d = derive(hs.load_scene("fu2019"))
    symbol = next(p for p in d.scene.parameters if p.symbol.name == parameter)
    values = {p.symbol: p.value for p in d.scene.parameters}
    step = Rational(1, 10**12)
    for i, part in enumerate(hs.Part):
        up, down, here = (d.at(**{parameter: symbol.value * (1 + n * step)}).crossings[i].omega for n in (1, -1, 0))
        slope = (Rational(up.digits(60)) - Rational(down.digits(60))) / (2 * step * symbol.value)
        known = {**values, hs.omega: Rational(here.digits(60)), d.threshold(part): Rational(1, 10)}
        assert d.sensitivity(part, symbol.symbol).xreplace(known).evalf(30) == pytest.approx(float(slope), rel=1e-12)


def test_formulas_hold_where_their_conditions_say_so() -> None:
    m, k = hs.symbols("m k")
    d = derive(hs.load_scene("fu2019"))
    low, high = d.changeovers("perc")
    assert all(x.conditions for x in (low, high))
    values = {p.symbol: p.value for p in d.scene.parameters}
    found = sorted(float(x.omega.xreplace(values)) for x in (low, high))
    wide = hs.evaluate(d.scene.with_band(0, 200))
    assert found == pytest.approx([float(p.omega) for p in wide.changeovers_perceived], rel=1e-14)
    assert [x.omega for x in d.changeovers("env")] == [sqrt(k) / sqrt(m)]


def test_other_values_are_answered_with_certainty() -> None:
    result = derive(hs.load_scene("fu2019")).at(omega_n="40 Hz", c=0.2)
    expected = hs.evaluate(hs.Scene(
        hs.environments.mass_spring_damper("1.8 kg", "15 N*s/m", "100 N/m"),
        (hs.effects.second_order_lowpass("40 Hz", 0.5),), (0, 15), 0.2))  # fmt: skip
    assert [c.omega.digits(30) for c in result.crossings] == [c.omega.digits(30) for c in expected.crossings]


@pytest.mark.parametrize(("values", "words"), [({"m": -1}, "m: \"-1\" must be >= 0"), ({"q": 1}, "no parameter \"q\""),
                                               ({"omega_n": "3 kg"}, "is not a frequency")])  # fmt: skip
def test_a_wrong_value_is_an_error_that_names_it(values: dict[str, object], words: str) -> None:
    with pytest.raises(hs.SceneError, match=re.escape(words)):
        derive(hs.load_scene("fu2019")).at(**values)


@pytest.mark.few("fu2019")
@pytest.mark.parametrize("name", often(hs.scene_names(), QUICK_SCENES.__contains__))
def test_every_shipped_scene_has_a_page_in_each_form(name: str, call) -> None:  # type: ignore[no-untyped-def]
    for form in ("text", "latex", "mathml", "json"):
        status, out, err = call("derive", name, "--to", form)
        assert (status, err) == (0, "")
        if form == "json":
            assert json.loads(out)["schema"] == "haptisym.derivation/1"
        if form == "mathml":
            ElementTree.fromstring(f"<div>{out}</div>")


def test_the_json_of_a_page_says_the_same_as_its_text(call) -> None:  # type: ignore[no-untyped-def]
    d = derive(hs.load_scene("fu2019"))
    document = d.to_dict()
    assert json.loads(call("derive", "fu2019", "--json")[1]) == document
    assert document["operations"] == d.steps.operations
    _, text, _ = call("derive", "fu2019")
    flat = re.sub(r"\s+", " ", spelt(text.replace("≈", "~"), "ascii"))
    assert all(row["text"] in flat for section in document["sections"] for row in section["equations"])


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", often(["fu2019", "steering-wheel", "four-channel-teleoperation", "organ-tissue"], "fu2019".__eq__)
)
def test_the_latex_of_a_page_compiles(name: str, call, tmp_path) -> None:  # type: ignore[no-untyped-def]
    body = call("derive", name, "--to", "latex")[1]
    head = r"\documentclass[a4paper,11pt]{article}\usepackage{amsmath}\usepackage[margin=2.5cm]{geometry}"
    check_layout(compiled(rf"{head}\begin{{document}}{body}\end{{document}}", tmp_path))


@pytest.mark.parametrize("language", ["numpy", "c", "octave", "julia", "javascript"])
def test_code_keeps_the_parameters_that_are_asked_for(language: str, call) -> None:  # type: ignore[no-untyped-def]
    out = call("derive", "fu2019", "--to", language, "--keep", "omega_n")[1]
    assert "omega_n" in out
    assert "zeta = 0.5" in out


@pytest.mark.few(1)
@pytest.mark.parametrize("kept", [(), ("omega_n",), ("m", "zeta"), ("m", "b", "k", "omega_n", "zeta")])
def test_the_table_of_parameters_says_which_stay_symbols_and_what_all_are_in_the_scene(kept: tuple[str, ...]) -> None:
    values = {"m": "1.8", "b": "15", "k": "100", "omega_n": "80", "zeta": "0.5"}
    names = {"omega_n": "ω_n", "zeta": "ζ"}
    shown = plain(derive(hs.load_scene("fu2019"), keep=kept).document())
    for name, value in values.items():
        [row] = [x.split() for x in shown.splitlines() if x.split()[:1] == [names.get(name, name)]]
        assert " ".join(row).endswith(f"a symbol; {value} in the scene") == (name in kept)
        assert name in kept or row[-1] == value


@pytest.mark.parametrize(
    "arguments", [("--keep", "q"), ("--of", "Re dQ"), ("--to", "fortran"), ("--keep",), ("--to", "c", "--of", "dH")]
)
def test_a_wrong_request_is_one_clear_message(arguments: tuple[str, ...], call) -> None:  # type: ignore[no-untyped-def]
    status, out, err = call("derive", "fu2019", *arguments)
    assert (status, out) == (2, "")
    assert len(err.strip()) > 20
    assert "Traceback" not in err


@pytest.mark.parametrize("name", ["omega_env", "omega_perc", "omega_i", "d omega_r/d m", "F_si_perc", "F_d_env"])
def test_solutions_slopes_and_forces_can_be_asked_for(name: str, call) -> None:  # type: ignore[no-untyped-def]
    status, out, err = call("derive", "delayed-spring" if name == "omega_i" else "fu2019", "--of", name)
    assert (status, err) == (0, "")
    shown = out.replace("ω", "omega").replace("(d m)", "d m").replace("F_si_perc(omega j)", "F_si_perc")
    assert name in shown


def test_quantities_answer_to_names_as_a_shell_likes_them(call) -> None:  # type: ignore[no-untyped-def]
    one, two = (call("derive", "fu2019", "--of", name)[1] for name in ("Re dH", "re_dh"))
    assert one == two
    assert "Re dH = " in one


@pytest.mark.slow
def test_a_function_of_very_many_terms_is_named_and_not_looked_at() -> None:
    """With two devices on two masses p_r has 220 thousand terms, which took minutes to be found too long for a page."""
    tool = hs.environments.two_mass(1.56, 3.53, 103, 0.231, 0.323, 439)
    loop = hs.effects.admittance_display("w^2/(s^2+2*z*w*s+w^2)", parameters={"w": 97, "z": 0.9})
    port = hs.effects.two_port("w/(s+w)", "mm*s^2", "1/kk", "1", parameters={"w": 123, "mm": "0.0138", "kk": 2470})
    for jnd, told in (
        (0.1, r"p_r has \d{6} terms; ask for it by its name"),
        ({"shape": "ellipse", "real": 0.1, "imag": 0.1}, "which functions of ω decide it is not written out"),
    ):
        text = str(hs.derive(hs.Scene(tool, (loop, port), (0, 50), jnd)))
        assert re.search(told, text)


@pytest.mark.slow
@pytest.mark.parametrize("jnd", [0.1, {"shape": "diamond", "real": 0.1, "imag": 0.1}])
def test_a_chain_of_thirty_effects_is_derived_in_steps_without_being_multiplied_out(jnd: object) -> None:
    """H_env was had from all closed forms together: with thirty symbols in H_perc the page took minutes, or for ever."""
    wall = hs.environments.mass_spring_damper(2, 15, 100)
    devices = [
        (hs.effects.shunt(m="0.001"), hs.effects.second_order_lowpass(9000 + i, "0.7"), hs.effects.compliance(10**6))
        for i in range(10)
    ]
    with budget.limited(20):
        text = str(hs.derive(hs.Scene(wall, tuple(x for row in devices for x in row), (0, 15), jnd)))
    assert "H_env(s) = m s^2 + b s + k" in text
    assert "Closed forms of this chain are long" in text
