"""What values show in a notebook: LaTeX that KaTeX reads, HTML that is well formed, and the right numbers in both."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest
from marks import required
from pagereader import Page, equations, value
from sympy import Integer, Rational, pi, sqrt

import haptisym as hs
from haptisym.kernel.reals import ExactNumber
from haptisym.pages.notebook import latex

E, F = hs.environments, hs.effects
m, b, k, omega_n, zeta, tau = hs.symbols("m b k omega_n zeta tau")
PAPER = hs.evaluate(hs.load_scene("fu2019"))
SYMBOLIC = hs.distort(E.mass_spring_damper(m, b, k), F.second_order_lowpass(omega_n, zeta))
FORMULAS: dict[str, Any] = {
    "environment": E.mass_spring_damper("1.8 kg", "15 N*s/m", k),
    "rotation": E.mass_spring_damper("0.01 kg*m^2", "0.2 N*m*s/rad", "3 N*m/rad"),
    "fractional": E.spring_pot(80, "0.2", 120),
    "irrational": F.first_order_lag("25 Hz"),
    "effect": F.shunt(m="0.1 kg"),
    "wave": F.wave_variables("10 N*s/m", "20 ms", name="a long name of a link"),
    "list": E.prony(100, [10, 20], [1, 2]),
    "distortion": SYMBOLIC,
    "delayed": hs.distort(E.mass_spring_damper(m, b, k), F.delay(tau)),
    "long": hs.load_scene("steering-wheel").symbolic_distortion(),
    "numbers": PAPER.distortion,
    "threshold": hs.Threshold.of("0.1"),
    "two thresholds": hs.Threshold.of("0.1", Rational(1, 3)),
    "algebraic threshold": hs.Threshold.of(sqrt(2) / 10),
    "crossing": PAPER.crossings[0],
    "number": PAPER.crossings[0].omega,
    "exact": ExactNumber(30 * pi),
    "rational": ExactNumber(Rational(1, 3)),
    "small": ExactNumber(pi / 10**9),
    "point": PAPER.chart.points[1],
    "interval": PAPER.transparent[0],
    "peak": hs.peaks(PAPER.scene)[0],
}
TABLES: dict[str, Any] = {
    "scene": PAPER.scene,
    "symbolic scene": hs.Scene(E.mass_spring_damper(m, b, k), (F.delay(tau),)),
    "hostile scene": hs.Scene(E.mass_spring_damper(k=1), title="<script>&"),
    "evaluation": PAPER,
    "undecided stability": hs.evaluate(hs.load_scene("wave-variable-link")),
    "distortion": SYMBOLIC,
    "long": FORMULAS["long"],
    "crossing": PAPER.crossings[0],
    "peak": FORMULAS["peak"],
    "percept": PAPER.percepts[0],
}


KATEX = Path("/usr/share/javascript/katex/katex.js")  # of the Debian package libjs-katex
READ = """
const katex = require(process.argv[1]);
for (const [name, text, displayMode] of JSON.parse(require("fs").readFileSync(0, "utf8"))) {
  try { katex.renderToString(text, { displayMode, strict: "error" }); } catch (error) { console.log(name, error.message); }
}
"""


def test_katex_reads_every_formula() -> None:
    required("katex or node", KATEX.exists() and shutil.which("node"))
    listed = []
    for name, shown in FORMULAS.items():
        found = re.fullmatch(r"\$\$(.*)\$\$|\$(.*)\$", shown._repr_latex_(), re.DOTALL)
        assert found
        listed.append((name, found[1] or found[2], bool(found[1])))
    wrong = [("no such command", r"\nonesuch", False)]
    done = subprocess.run(
        ["node", "-e", READ, str(KATEX)], input=json.dumps(listed + wrong), capture_output=True, text=True, check=True
    )
    assert re.fullmatch(r"no such command .*Undefined control sequence.*\n", done.stdout), done.stdout


@pytest.mark.parametrize("name", FORMULAS)
def test_the_latex_needs_no_package_and_is_balanced(name: str) -> None:
    text = FORMULAS[name]._repr_latex_()
    assert text.count("{") == text.count("}")
    assert text.count(r"\left") == text.count(r"\right")
    assert set(re.findall(r"\\begin\{(\w+\*?)\}", text)) <= {"aligned", "pmatrix"}
    assert text.isascii()


@pytest.mark.parametrize("name", TABLES)
def test_the_html_is_well_formed_and_loads_nothing(name: str) -> None:
    read = Page(TABLES[name]._repr_html_())
    assert read.loads == []
    assert "script" not in read.tags
    assert "".join(read.texts).strip()


def test_an_evaluation_shows_its_crossings_and_percepts() -> None:
    read, document = Page(PAPER._repr_html_()), PAPER.to_dict()
    shown = "".join(read.texts)
    assert read.tags.count("table") == 2
    assert {c["omega"] for c in document["crossings"]} <= set(read.numbers)
    for words in (
        *(c["digits"] for c in document["crossings"]),
        "lower mass",
        "higher damping",
        "force under imposed motion is stable",
    ):
        assert words in shown


def test_a_scene_shows_its_parameters() -> None:
    shown = "".join(Page(PAPER.scene._repr_html_()).texts)
    assert all(x in shown for x in ("second-order-lowpass", "1.8", "N·s/m", "2.3873 Hz"))


def test_formulas_say_what_they_stand_for() -> None:
    assert FORMULAS["environment"]._repr_latex_() == (
        r"$\displaystyle H(s) = m s^{2} + b s + k,\quad m = 1.8\,\mathrm{kg},\quad b = 15\,\mathrm{N\,s/m}$"
    )
    chain = r"\begin{pmatrix} F_h \\ X_h \end{pmatrix} = \begin{pmatrix} 1 & m s^{2} \\ 0 & 1 \end{pmatrix}"
    assert FORMULAS["effect"]._repr_latex_().startswith(rf"$\displaystyle {chain}")
    assert FORMULAS["exact"]._repr_latex_() == r"$\displaystyle 30 \pi \approx 94.2477796076938$"
    assert FORMULAS["number"]._repr_latex_() == r"$\displaystyle 7.97891679017471$"
    assert FORMULAS["two thresholds"]._repr_latex_().endswith(r"c_{\mathrm{imag}} = \tfrac{1}{3}$")
    assert FORMULAS["interval"]._repr_latex_() == r"$\displaystyle \left[ 0,\, 7.9789 \right]\,\mathrm{rad/s}$"
    assert PAPER.percepts[0]._repr_html_().startswith("lower mass (real part), from ")


def test_the_formulas_of_a_distortion_in_html_have_their_values() -> None:
    known = {"m": 1.8, "b": 15.0, "k": 100.0, "omega_n": 80.0, "zeta": 0.5, "omega": 10.0, "s": 10j}
    named = {left: value(sides[-1][1], known) for left, sides in equations(SYMBOLIC._repr_html_())}
    env = 1.8 * (10j) ** 2 + 150j + 100
    perc = env * 6400 / ((10j) ** 2 + 800j + 6400)
    assert named["H_percs"] == pytest.approx(perc, rel=1e-12)
    assert named["ReDeltaHomegaj"] == pytest.approx((perc - env).real, rel=1e-12)
    assert named["r_iomega"] == pytest.approx(abs((perc - env).imag) / abs(env), rel=1e-12)


def test_a_formula_that_nobody_can_read_is_left_out() -> None:
    assert len(FORMULAS["long"]._repr_latex_()) < 20_000
    assert "H_{\\mathrm{env}}" in FORMULAS["long"]._repr_latex_()


def test_what_is_no_fraction_has_a_decimal_of_six_digits_beside_it() -> None:
    for x, told in (
        (
            hs.Threshold(sqrt(2) / 10),
            r"c_{\mathrm{real}} = 0.1 \sqrt{2} \approx 0.141421,\quad c_{\mathrm{imag}} = 0.1",
        ),
        (
            hs.Threshold((sqrt(5) - 1) / 2, 1),
            r"c_{\mathrm{real}} = 0.5 \sqrt{5} - 0.5 \approx 0.618034,\quad c_{\mathrm{imag}} = 1",
        ),
        (hs.Threshold(Rational(1, 7)), r"c_{\mathrm{real}} = \tfrac{1}{7},\quad c_{\mathrm{imag}} = 0.1"),
        (
            hs.environments.mass_spring_damper(k=pi / 3),
            r"H(s) = k,\quad k = \tfrac{1}{3} \pi \approx 1.0472\,\mathrm{N/m}",
        ),
    ):
        assert latex(x) == rf"$\displaystyle {told}$"


def test_every_public_value_shows_itself() -> None:
    kinds = [
        hs.Scene,
        hs.Evaluation,
        hs.Environment,
        hs.Effect,
        hs.Distortion,
        hs.Crossing,
        hs.Percept,
        hs.Peak,
        hs.Threshold,
    ]
    assert all(hasattr(kind, "_repr_latex_") or hasattr(kind, "_repr_html_") for kind in kinds)


def test_what_has_no_formula_shows_none_and_nothing_of_the_users_process_is_touched() -> None:
    assert PAPER._repr_latex_() is None
    assert PAPER.crossings[0].omega._repr_html_() is None
    assert not hasattr(Integer, "_repr_html_")
