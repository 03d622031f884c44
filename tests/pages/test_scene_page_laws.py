"""The pages of a scene and of a derivation: chains, parameters with their values and units, and what their documents of JSON hold."""

from __future__ import annotations

from functools import cache
from types import SimpleNamespace as Made
from typing import Any

import pytest
from pagewords import flat, lines
from sympy import Rational, Symbol, pi, sqrt

import haptisym as hs
from haptisym.model.quantities import Dimension, MotionKind
from haptisym.pages import derive
from haptisym.pages import scene as page
from haptisym.pages.sections import sections
from haptisym.writing.document import Flow, Notes, Table
from haptisym.writing.plain import plain, said

E, F = hs.environments, hs.effects


def text(phrase: Any) -> str:
    return said(phrase).replace("\xa0", " ")


WALL = hs.Scene(
    E.mass_spring_damper(m="1/3 kg", k=100, b=pi), (F.second_order_lowpass("80 rad/s", "0.5", name="filter"), F.delay("5 ms")), (1, 12), {"real": "0.1", "imag": "0.2"},
)  # fmt: skip


def shown(scene: hs.Scene, **own: Any) -> tuple[list[str], list[list[str]], str]:
    """The links of its chain, the rows of its table, and the sentence about band and threshold."""
    flow, *tables, last = page.scene_blocks(scene, **own)
    assert isinstance(flow, Flow)
    rows = [[text(x) for x in row] for t in tables if isinstance(t, Table) for row in t.rows]
    return [text(x) for x in flow.links], rows, text(last.words)  # type: ignore[union-attr]


def test_the_chain_goes_from_the_environment_to_the_hand_and_says_what_each_link_is() -> None:
    links, _, _ = shown(WALL)
    assert links[-1] == "hand feels H_perc"
    assert [x.split(" (")[0] for x in links[:-1]] == ["environment", "filter", "delay"]
    assert links[0].startswith("environment (mass-spring-damper: ")
    assert links[1].startswith("filter (second-order-lowpass: ")
    assert "(delay:" not in links[2]  # what is called as its kind is told that once
    assert not any(x.rstrip(")").endswith(".") for x in links)
    rendered = hs.Scene(E.mass_spring_damper(k=1), (), rendered=E.mass_spring_damper(k=2))
    assert len(shown(rendered)[0]) == 3


def test_each_parameter_has_a_row_with_its_exact_value_or_a_rounded_one_beside_it() -> None:
    _, rows, _ = shown(WALL)
    assert rows == [
        ["m", "environment", "m", "mass", "1/3", "kg"], ["b", "environment", "b", "damping", "π ≈ 3.14159", "N·s/m"], ["k", "environment", "k", "stiffness", "100", "N/m"],
        ["ω_n", "filter", "omega_n", rows[3][3], "80", "rad/s"], ["ζ", "filter", "zeta", "ratio", "0.5", rows[4][5]], ["τ", "delay", "tau", "time", "0.005", "s"],
    ]  # fmt: skip
    short = {WALL.effects[0].parameters[0].symbol: Symbol("w_1")}
    assert shown(WALL, short_names=short)[1][3][0] == "w_1"
    symbolic = hs.Scene(E.mass_spring_damper(k=hs.symbols("k_0")), (), (1, 2))
    assert shown(symbolic)[1][0][4] == "k_0"
    turned = hs.Scene(E.mass_spring_damper(k="2 N*m/rad"), (), (1, 2))
    assert shown(turned)[1][0][5] == "N·m/rad"
    bare = hs.Scene(E.expression("s + 2"), (), (1, 2))
    assert shown(bare)[1] == []


@pytest.mark.parametrize(
    ("value", "told"),
    [
        (Rational(99999989, 10000019), "99999989/10000019"), (Rational(100000007, 10000019), "≈ 9.99998"), (Rational(1, 3), "1/3"), (pi, "π ≈ 3.14159"),
        (sqrt(2), "sqrt(2) ≈ 1.41421"), (Symbol("k") * 2, "2 k"), (Rational(-5, 2), "-2.5"),
    ],
)  # fmt: skip
def test_a_value_is_exact_while_it_has_sixteen_digits(value: Any, told: str) -> None:
    assert text(page._value(value)) == told


@pytest.mark.parametrize(
    ("jnd", "told"),
    [
        ("0.1", "exceeds the fraction c = 0.1 of |H_env|."), ({"real": "0.1", "imag": "1/3"}, "exceeds the fraction c_real = 0.1 (real) or c_imag = 1/3 (imaginary) of |H_env|."),
        (sqrt(2) / 10, "exceeds the fraction c ≈ 0.141421 of |H_env|."), ({"real": "0.1", "imag": "0.1", "floor": "2 N/m"}, "is noticed when it exceeds 10 % of |H_env|, and at least 2 N/m."),
        ({"shape": "ellipse", "real": "0.1", "imag": "0.2"}, "A change, both parts together, is noticed when it leaves the region: an ellipse, 10 % (real) and 20 % (imaginary) of |H_env|."),
    ],
)  # fmt: skip
def test_the_band_and_what_is_noticed_are_told_in_a_sentence(jnd: Any, told: str) -> None:
    own = hs.Scene(E.mass_spring_damper(k=1), (), (1, 12), jnd)
    last = shown(own)[2]
    assert last.startswith("The band of interest goes from 1 rad/s (0.15915 Hz) to 12 rad/s (1.9099 Hz). A change")
    assert last.endswith(told)
    if not own.threshold.is_plain:
        assert text(page.threshold(own.threshold)) in last
    assert "Untitled scene" in plain(page.page(own))


# Derivations


@cache
def derived(*kept: str) -> Any:
    return hs.derive(WALL, kept or None)


def test_each_parameter_of_a_derivation_says_what_it_is_and_whether_it_stays_a_symbol() -> None:
    body = lines(derived("omega_n", "k"))
    for line in ("m mass, kg 1/3", "k stiffness, N/m a symbol; 100 in the scene", "τ time, s 0.005"):
        assert body.count(line) == 1, line
    assert any(x.startswith("ω_n ") and x.endswith("a symbol; 80 in the scene") for x in body)
    assert any(x.startswith("ζ number") and x.endswith("0.5") for x in body)
    assert "symbol what it is value" in body
    for dimension, unit, told in (
        (Dimension.ANY, "", "number"),
        (Dimension.ANY, "kg", "number, kg"),
        (Dimension.RATIO, "1", "number"),
        (Dimension.FORCE, "N", "force, N"),
        (Dimension.TIME, "", "time"),
    ):
        p: Any = Made(dimension=dimension, unit_in=lambda _, unit=unit: unit)
        assert derive._meaning(p, MotionKind.TRANSLATION) == told
    nothing = hs.derive(hs.Scene(E.expression("s + 2"), (), (1, 2)))
    assert "symbol what it is" not in flat(nothing)


def test_the_document_of_a_derivation_holds_what_its_page_says_in_three_languages() -> None:
    d = derived("omega_n", "k")
    told = derive.body(d)
    own = sections(d)
    assert told["operations"] == d.steps.operations
    assert [x["name"] for x in told["parameters"]] == [p.symbol.name for p in WALL.parameters]
    assert {x["name"]: x["symbol"] for x in told["parameters"]} == {
        p.symbol.name: p.key in ("omega_n", "k") for p in WALL.parameters
    }
    assert len(told["sections"]) == len(own)
    for row, section in zip(told["sections"], own, strict=True):
        assert row["title"] == said(section.title)
        assert len(row["equations"]) == len(list(derive.lines_of(section)))
        assert row["notes"] == [said(x) for block in section.blocks if isinstance(block, Notes) for x in block.entries]
        for e in row["equations"]:
            assert e["mathml"].startswith("<math ")
            assert ("~" in e["text"]) == (r"\approx" in e["latex"])
    assert any(row["notes"] for row in told["sections"])
    assert derive.latex(d).count(r"\begin{align*}") == sum(1 for row in told["sections"] if row["equations"])


def test_formulas_in_symbols_hold_for_all_values_of_ranges_and_others_for_the_nominal_ones() -> None:
    ranged = hs.Scene(E.mass_spring_damper(k="100 N/m +- 10 %"), (F.first_order_lag(20),), (1, 12))
    note = "Formulas in their symbols hold for all values."
    for kept, holds in ((("k",), True), (("omega_c",), False)):
        d = hs.derive(ranged, kept)
        assert (note in flat(d)) is holds
        assert (note in derive.latex(d)) is holds
    assert note not in flat(derived("omega_n", "k"))
