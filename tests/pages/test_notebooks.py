"""What a session shows: a short line for every value, formulas of values, and an answer's page in a notebook."""

from __future__ import annotations

import copy
import json
import pickle
import re
import shutil
import subprocess
from collections.abc import Callable
from functools import cache
from html import unescape
from pathlib import Path
from typing import Any

import pytest
from marks import often, required
from pagereader import Page, equations, value
from sympy import Rational, Symbol, pi

import haptisym as hs
from haptisym.kernel.reals import ExactNumber

E, F = hs.environments, hs.effects
m, b, k, omega_n, zeta, tau = hs.symbols("m b k omega_n zeta tau")
PAPER = hs.load_scene("fu2019")
SYMBOLIC = hs.distort(E.mass_spring_damper(m, b, k), F.second_order_lowpass(omega_n, zeta))
MOST = 200
"""Characters of one value's line."""


@cache
def paper() -> hs.Evaluation:
    return hs.evaluate(PAPER)


# Answers

ANSWERS: dict[str, Callable[[], Any]] = {
    "evaluation": paper,
    "requirement": lambda: hs.require("delayed-spring", "tau"),
    "map": lambda: hs.design_map("fu2019", ["zeta", "omega_n"], [("0.4", "0.6"), (50, 500)], slices=3),
    "comparison": lambda: hs.compare("fu2019", values={"zeta": "0.4"}),
    "sensitivities": lambda: hs.sensitivity("fu2019"),
    "tolerances": lambda: hs.tolerances("fu2019-tolerances", samples=3),
    "relevance": lambda: hs.relevance("fu2019", "0.01"),
    "metrics": lambda: hs.metrics("sidestick"),
    "derivation": lambda: hs.derive("fu2019"),
    "stability": lambda: hs.stability("fu2019", "firm-grip"),
    "peaks": lambda: hs.peaks("steering-wheel"),
    "family": lambda: hs.evaluate_all(hs.load_scenes("palpation-device")),
    "published": hs.published,
    "identification": lambda: hs.identify(hs.sampled("fu2019", [1, 4, 7, 10]), "mass-spring-damper"),
    "simulation": lambda: hs.simulate("fu2019", hs.sine("5 cm", 10)),
}
DEAR = ("map", "tolerances", "metrics", "derivation", "identification", "simulation")


@pytest.mark.dear("family", "requirement", "sensitivities")
@pytest.mark.parametrize("name", often(ANSWERS, lambda name: name not in DEAR))
def test_an_answer_is_one_short_line_and_a_page_of_html_that_loads_nothing(name: str) -> None:
    answer = ANSWERS[name]()
    assert re.fullmatch(rf"<{type(answer).__name__}[^\n]+>", repr(answer))
    assert len(repr(answer)) <= MOST
    page = answer._repr_html_()
    read = Page(page)
    assert read.loads == []
    assert "script" not in read.tags
    assert "".join(read.texts).strip()
    assert answer.to_dict()["schema"].startswith("haptisym.")


def test_an_evaluation_shows_its_crossings_with_their_digits() -> None:
    read, document = Page(paper()._repr_html_()), paper().to_dict()
    shown = "".join(read.texts)
    assert {c["omega"] for c in document["crossings"]} <= set(read.numbers)
    assert all(f"{c['omega']:.4g}" in shown for c in document["crossings"])
    assert all(f"{p['change']} {p['property']}" in shown for p in document["percepts"])


def test_hostile_titles_stay_text_and_on_one_line() -> None:
    scene = hs.Scene(PAPER.environment, PAPER.effects, title="<script>&\nalert")
    assert "\n" not in repr(scene)
    for shown in (hs.sensitivity(scene), scene):
        html = shown._repr_html_()
        assert "<script>" not in html
        assert "&lt;script&gt;&amp;" in html


@pytest.mark.slow
def test_what_was_evaluated_can_be_pickled_and_copied_and_answers_the_same() -> None:
    found = hs.evaluate(PAPER, 20, tolerance="1 %")
    for x in (PAPER, hs.load_scenes("palpation-device")):
        assert pickle.loads(pickle.dumps(x)) == x
        assert copy.deepcopy(x) == x
    for answer in (found, found.relevance, hs.peaks(PAPER), hs.evaluate("delayed-spring")):
        assert answer is not None
        for again in (pickle.loads(pickle.dumps(answer)), copy.copy(answer)):
            assert type(again) is type(answer)
            assert again.to_json() == answer.to_json()


# Values

LINES: dict[str, tuple[Callable[[], Any], str]] = {
    "a frequency": (lambda: paper().bandwidth, "7.97891679017471"),
    "a crossing": (lambda: paper().crossings[0], "<Crossing r_r exceeds its threshold at 7.97891679017471 rad/s>"),
    "a percept": (lambda: paper().percepts[0], "<Percept lower mass (real part) from 7.9789 to 15.000 rad/s>"),
    "an interval": (lambda: paper().transparent[0], "<Interval from 0 to 7.97891679017471 rad/s>"),
    "a peak": (lambda: hs.peaks(PAPER)[0], "<Peak r_i = 0.0387709 at 4.35101 rad/s>"),
    "an environment": (lambda: PAPER.environment, "<Environment mass-spring-damper: m = 9/5 kg; b = 15 N*s/m; k = 100 N/m>"),
    "an effect": (lambda: F.delay("5 ms"), "<Effect delay: tau = 1/200 s>"),
    "values that will do": (lambda: hs.require(PAPER, "omega_n").feasible, "(<Piece from 122.356 on>,)"),
    "a range": (
        lambda: E.mass_spring_damper(m="1.8 kg +- 5 %").parameters[0], "<Parameter m = 9/5 kg, from 171/100 to 189/100 kg>",
    ),
}  # fmt: skip


@pytest.mark.dear("values that will do")
@pytest.mark.parametrize("name", LINES)
def test_a_value_is_shown_as_a_person_would_write_it(name: str) -> None:
    made, line = LINES[name]
    assert repr(made()) == line


FORMULAS: dict[str, tuple[Callable[[], Any], str]] = {
    "environment": (
        lambda: E.mass_spring_damper("1.8 kg", "15 N*s/m", k),
        r"H(s) = m s^{2} + b s + k,\quad m = 1.8\,\mathrm{kg},\quad b = 15\,\mathrm{N\,s/m}",
    ),
    "rotation": (lambda: E.mass_spring_damper(k="2 N*m/rad"), r"H(s) = k,\quad k = 2\,\mathrm{N\,m/rad}"),
    "irrational": (
        lambda: E.mass_spring_damper(k=pi / 3), r"H(s) = k,\quad k = \tfrac{1}{3} \pi \approx 1.0472\,\mathrm{N/m}"
    ),
    "two-port": (
        lambda: F.first_order_lag("3 Hz"),
        (r"\begin{pmatrix} F_h \\ X_h \end{pmatrix} = \begin{pmatrix} \frac{\omega_c}{s + \omega_c} & 0 \\ 0 & 1 \end{pmatrix} "
        r"\begin{pmatrix} F_e \\ X_e \end{pmatrix},\quad \omega_c = 6 \pi \approx 18.8496\,\mathrm{rad/s}"),
    ),
    "thresholds": (lambda: hs.Threshold.of("0.1", Rational(1, 3)), r"c_{\mathrm{real}} = 0.1,\quad c_{\mathrm{imag}} = \tfrac{1}{3}"),
    "a threshold in pi": (lambda: hs.Threshold(pi / 30, pi / 30), r"c = \tfrac{1}{30} \pi \approx 0.10472"),
    "an exact number": (lambda: ExactNumber(30 * pi), r"30 \pi \approx 94.2477796076938"),
    "a small number": (lambda: ExactNumber(Rational(1, 3)), r"\tfrac{1}{3}"),
    "a number": (lambda: paper().crossings[0].omega, "7.97891679017471"),
    "an interval": (lambda: paper().transparent[0], r"\left[ 0,\, 7.979 \right]\,\mathrm{rad/s}"),
    "a crossing": (lambda: paper().crossings[0], r"r_r = c_{\mathrm{real}},\quad \omega = 7.97891679017471\,\mathrm{rad/s}"),
    "a peak": (
        lambda: hs.peaks(hs.Scene(E.mass_spring_damper(k=100), (F.first_order_lag(10),), (0, 15)))[0],
        r"r_i = 0.5000,\quad \omega = 10.00\,\mathrm{rad/s}",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", FORMULAS)
def test_a_formula_is_set_with_its_values_and_units(name: str) -> None:
    made, told = FORMULAS[name]
    assert made()._repr_latex_() == rf"$\displaystyle {told}$"


@pytest.mark.slow
def test_the_formulas_of_a_distortion_have_their_values() -> None:
    known = {"m": 1.8, "b": 15.0, "k": 100.0, "omega_n": 80.0, "zeta": 0.5, "omega": 10.0, "s": 10j}
    shown = SYMBOLIC._repr_html_()
    named = {left: value(sides[-1][1], known) for left, sides in equations(shown)}
    env = 1.8 * (10j) ** 2 + 150j + 100
    perc = env * 6400 / ((10j) ** 2 + 800j + 6400)
    assert named["H_percs"] == pytest.approx(perc, rel=1e-12)
    assert named["ReDeltaHomegaj"] == pytest.approx((perc - env).real, rel=1e-12)
    assert named["r_iomega"] == pytest.approx(abs((perc - env).imag) / abs(env), rel=1e-12)
    assert Page(shown).loads == []


KATEX = Path("/usr/share/javascript/katex/katex.js")  # of the Debian package libjs-katex
READ = """
const katex = require(process.argv[1]);
for (const [name, text, displayMode] of JSON.parse(require("fs").readFileSync(0, "utf8"))) {
  try { katex.renderToString(text, { displayMode, strict: "error" }); } catch (error) { console.log(name, error.message); }
}
"""


@pytest.mark.slow
def test_katex_reads_every_formula() -> None:
    required("katex or node", KATEX.exists() and shutil.which("node"))
    others = {
        "distortion": SYMBOLIC,
        "delayed": hs.distort(E.mass_spring_damper(m, b, k), F.delay(tau)),
        "long": hs.load_scene("steering-wheel").symbolic_distortion(),
        "fractional": E.spring_pot(80, "0.2", 120),
        "marks": hs.distort(
            hs.s * Symbol(r"\mu_{a}"), 1 / (1 + hs.s * Symbol("k'_1") ** 2 * Symbol("xdot"))
        ).low_frequency,
        "wave": F.wave_variables("10 N*s/m", "20 ms", name="a long name of a link"),
    }
    listed = []
    for name, x in ({key: made() for key, (made, _) in FORMULAS.items()} | others).items():
        text = x._repr_latex_()
        assert text.isascii()
        assert len(text) < 20_000
        found = re.fullmatch(r"\$\$(.*)\$\$|\$(.*)\$", text, re.DOTALL)
        assert found
        listed.append((name, found[1] or found[2], bool(found[1])))
    wrong = [("no such command", r"\nonesuch", False)]
    done = subprocess.run(
        ["node", "-e", READ, str(KATEX)], input=json.dumps(listed + wrong), capture_output=True, text=True, check=True
    )
    assert re.fullmatch(r"no such command .*Undefined control sequence.*\n", done.stdout), done.stdout


def test_a_scene_shows_its_parameters_in_its_units() -> None:
    shown = unescape("".join(Page(PAPER._repr_html_()).texts))
    assert all(x in shown for x in ("second-order-lowpass", "1.8", "N·s/m", "2.387\xa0Hz"))
