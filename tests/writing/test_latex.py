"""The LaTeX reads as a careful author writes it, means what it stands for, and compiles."""

import os
import re
import unicodedata
from dataclasses import replace
from fractions import Fraction
from functools import cache
from pathlib import Path

import pytest
import sympy as sp
from formulas import ATOMS, EXPRESSIONS
from hypothesis import given
from marks import FLEXIBLE, QUICK_SCENES, WRITTEN_OUT, often
from pdflatex import check_layout, compiled, set_document
from sympy import Abs, Float, I, Integer, Rational, Symbol, cos, exp, pi, sqrt
from texreader import equations, value

from haptisym import Scene, Threshold, effects, environments, evaluate, load_scene, scene_names, stability, symbols
from haptisym.judge.evaluation import Evaluation
from haptisym.kernel.reals import Way, in_unit, printed
from haptisym.kernel.rings import X, omega, s
from haptisym.model.distortion import Distortion, distort
from haptisym.pages.notebook import latex
from haptisym.writing.latex import broken, escape, set_name
from haptisym.writing.latex import latex as latex_document
from haptisym.writing.layout import named

SET = {"fu2019", "delayed-spring"}
"""Shipped scenes whose documents are set in a moment."""
GOLDEN = Path(__file__).parents[1] / "golden"
m, b, k, omega_n, zeta, omega_c, tau, J, J_w = symbols("m b k omega_n zeta omega_c tau J J_w")
alpha, k_alpha, m_d = symbols("alpha k_alpha m_d")

MSD = environments.mass_spring_damper("1.8 kg", "15 N*s/m", "100 N/m")
PAPER = Scene(
    MSD,
    (effects.second_order_lowpass("80 rad/s", "0.5", name="filter"),),
    title="Numerical example of Fu, van Paassen and Mulder (2019)",
    source="doi:10.1016/j.ifacol.2019.12.119, section 3",
)
SYMBOLIC = {
    "fu2019": distort(environments.mass_spring_damper(m, b, k), effects.second_order_lowpass(omega_n, zeta)),
    "lag_on_kelvin_voigt": distort(environments.kelvin_voigt(k, b), effects.first_order_lag(omega_c)),
    "shunt_mass": distort(environments.mass_spring_damper(m, b, k), effects.shunt(m=m_d)),
}


def golden(name: str, text: str) -> None:
    """Compare with a file that a person has read; ``UPDATE_GOLDEN=1`` writes it, to be read again, but never under CI."""
    path = GOLDEN / name
    if os.environ.get("UPDATE_GOLDEN"):
        assert not os.environ.get("CI"), "golden files are not refreshed under CI: what nobody reads proves nothing"
        path.write_text(text + "\n", encoding="ascii")
    assert text + "\n" == path.read_text(encoding="ascii")


@cache
def shipped(name: str) -> tuple[Evaluation, str]:
    """The evaluation of a shipped scene, and its document."""
    e = evaluate(load_scene(name))
    return e, set_document(e)


# Formulas as people write them.


@pytest.mark.dear("expression29-\\\\left| k - m \\\\omega^{2} \\\\right|")
@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        (m * s**2 + b * s + k, r"m s^{2} + b s + k"),
        (k - m * omega**2, r"k - m \omega^{2}"),
        (-m * omega**2 - k, r"-m \omega^{2} - k"),
        (sp.Mul(-1, b + k, evaluate=False), r"-(b + k)"),
        (m * s - b * omega_n - 2 * k * omega_n, r"m s - (b + 2 k) \omega_n"),
        (Rational(9, 5) * s**2 + 15 * s + 100, r"1.8 s^{2} + 15 s + 100"),
        (Rational(1, 3) * s + Rational(2, 7), r"\tfrac{1}{3} s + \tfrac{2}{7}"),
        (b * s + J * s + k, r"(b + J) s + k"),
        ((J - J_w) * s**2 + b * s, r"(J - J_w) s^{2} + b s"),
        (J_w - J, r"J_w - J"),
        (4 * zeta**2 - 1, r"4 \zeta^{2} - 1"),
        (1 - 4 * zeta**2, r"1 - 4 \zeta^{2}"),
        (4 * zeta**2 * omega_n**2 * s - 2 * omega_n**2 * s, r"2 (2 \zeta^{2} - 1) \omega_n^{2} s"),
        (2 * zeta * omega_n * s, r"2 \zeta \omega_n s"),
        (omega_c / (s + omega_c), r"\frac{\omega_c}{s + \omega_c}"),
        (-s / (s + omega_c), r"-\frac{s}{s + \omega_c}"),
        ((1 - s) / (1 + s), r"\frac{1 - s}{s + 1}"),
        (-(m * omega**2 - k) / omega, r"\frac{k - m \omega^{2}}{\omega}"),
        (k / (2 * m), r"\frac{k}{2 m}"),
        (Rational(3, 2) * k / m, r"\frac{1.5 k}{m}"),
        (sqrt(k / m), r"\sqrt{\frac{k}{m}}"),
        (2 * sqrt(k) / m, r"\frac{2 \sqrt{k}}{m}"),
        (k_alpha * s**alpha + k, r"k_\alpha s^{\alpha} + k"),
        (100 * s ** Rational(1, 4), r"100 s^{0.25}"),
        (b * s ** Rational(1, 3), r"b s^{1/3}"),
        (k + b * k * s / (b * s + k), r"k + \frac{b k s}{b s + k}"),
        (exp(-s * tau), r"e^{-\tau s}"),
        ((1 - exp(-s * tau)) / (s * tau), r"\frac{1 - e^{-\tau s}}{\tau s}"),
        (k * cos(omega * tau), r"k \cos(\tau \omega)"),
        (Abs(k - m * omega**2), r"\left| k - m \omega^{2} \right|"),
        (40 * pi * s + 1600 * pi**2, r"40 \pi s + 1600 \pi^{2}"),
        (I * X * b * omega, r"X b \omega j"),
        (Float("6.28319", 6) * s, r"6.28319 s"),
        (Float("4.0919e9", 5) * s, r"4.0919 \times 10^{9} s"),
        (Integer(12345678), r"12345678"),
        (Rational(1, 10**9) * s, r"10^{-9} s"),
        (-Rational(1, 3), r"-\tfrac{1}{3}"),
        (1 / s, r"\frac{1}{s}"),
        (Integer(0), "0"),
        (2 * 3 ** Rational(1, 3) * k, r"2 \cdot 3^{1/3} k"),
    ],
)
def test_a_formula_is_written_as_a_person_writes_it(expression, expected):
    assert latex(expression) == expected


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("k", "k"),
        ("omega_n", r"\omega_n"),
        ("omega_n_filter", r"\omega_{n,\mathrm{filter}}"),
        ("zeta_force_sensor", r"\zeta_{\mathrm{force\,sensor}}"),
        ("omega_c_first_order_lag_2", r"\omega_{c,\mathrm{first\,order\,lag},2}"),
        ("k_1", "k_1"),
        ("b12", "b_{12}"),
        ("Mm", "M_m"),
        ("tau", r"\tau"),
        ("k_alpha", r"k_\alpha"),
        ("Delta", r"\Delta"),
        ("mass", r"\mathrm{mass}"),
        ("ω_n", r"\omega_n"),
        ("H_é", r"H_{\text{\'{e}}}"),
        ("k_{env}", r"k_{\mathrm{env}}"),
        (r"\mu_{1}", r"\mu_1"),
        ("k'", "k'"),
        ("k'_1", "{k'}_1"),
        ("xdot", r"\dot{x}"),
        ("x^2}", r"\text{x\textasciicircum{}2\}}"),
    ],
)
def test_a_name_gets_greek_letters_and_upright_subscripts(name, expected):
    assert set_name(named(name)) == expected


@pytest.mark.dear("fu2019")
@pytest.mark.parametrize("name", SYMBOLIC)
def test_the_closed_forms_are_those_that_were_read_and_accepted(name):
    golden(f"{name}.tex", latex(SYMBOLIC[name]))


def test_the_tables_of_the_papers_example_are_those_that_were_read_and_accepted():
    golden("fu2019_tables.tex", latex(evaluate(PAPER)))


@pytest.mark.slow
def test_the_document_of_the_papers_example_is_the_one_that_was_read_and_accepted():
    golden("fu2019_document.tex", set_document(evaluate(PAPER)))


def test_other_things_have_no_latex():
    with pytest.raises(TypeError, match="no LaTeX for str"):
        latex("k")


# What is printed is what it stands for.

_AT = 3.7  # rad/s: any frequency would do
_VALUES = {
    "m": 1.83,
    "b": 15.2,
    "k": 97.1,
    "zeta": 0.43,
    "omega_n": 41.3,
    "omega_c": 11.9,
    "J": 0.06,
    "J_w": 0.035,
    "q": 0.11,
}


def assumed(d: Distortion) -> dict[Symbol, float]:
    """Some value for each parameter: any would do."""
    rest = sorted(d.free_symbols, key=str)
    return {x: _VALUES.get(x.name, 0.31 + 0.17 * i) for i, x in enumerate(rest)}


def expected_values(d: Distortion, known: dict[Symbol, float]) -> dict[str, float]:
    """What each left side of ``latex(d)`` stands for, worked out without the printer; c is 1, X is 1, j is 1."""
    H_env, H_perc = (complex(sp.sympify(x.xreplace(known)).subs(s, sp.I * _AT)) for x in (d.environment, d.perceived))
    dH, size = H_perc - H_env, abs(H_env)
    found = {
        r"\operatorname{Re} \Delta H(\omega j)": dH.real,
        r"\operatorname{Im} \Delta H(\omega j)": dH.imag,
        r"\left| H_{\mathrm{env}}(\omega j) \right|^{2}": size**2,
        r"r_r(\omega)": abs(dH.real) / size,
        r"r_i(\omega)": abs(dH.imag) / size,
        r"\operatorname{Re} \frac{\Delta H(\omega j)}{H_{\mathrm{env}}(\omega j)}": (dH / H_env).real,
        r"\operatorname{Im} \frac{\Delta H(\omega j)}{H_{\mathrm{env}}(\omega j)}": (dH / H_env).imag,
        r"\Delta_{\mathrm{jnd}} k": size,
        r"\Delta_{\mathrm{jnd}} b": size / _AT,
        r"\Delta_{\mathrm{jnd}} m": size / _AT**2,
    }
    for name, H in (("env", H_env), ("perc", H_perc)):
        found |= {
            rf"k_{{\mathrm{{{name}}}}}(\omega)": H.real,
            rf"m_{{\mathrm{{{name}}}}}(\omega)": -H.real / _AT**2,
            rf"b_{{\mathrm{{{name}}}}}(\omega)": H.imag / _AT,
            rf"F_{{\mathrm{{si}},\mathrm{{{name}}}}}(\omega j)": H.real,
            rf"F_{{\mathrm{{d}},\mathrm{{{name}}}}}(\omega j)": H.imag,
        }
    return found


DEFINED = ("u", "n_p", "n_q")


def read_values(aligned: str, known: dict[str, float]) -> dict[str, list[float]]:
    """The value of every side of every equation that is in closed form, named parts first."""
    sides = equations(aligned)
    known = dict(known)
    # First harmonics, by the definitions that are printed with them.
    for left in (x for x in sides if x in DEFINED):
        known[left] = value(sides[left][0], known)
    for left in sorted((x for x in sides if x.startswith(r"\mathcal")), key=lambda x: int(re.findall(r"\d+", x)[0])):
        known[left] = value(sides[left][0], known)
    closed = {
        left: [x for x in right if not re.search(r"H|k_\{\\mathrm\{(?:env|perc)\}\}", x)]
        for left, right in sides.items()
    }
    return {
        left: [value(x, known) for x in right]
        for left, right in closed.items()
        if not left.startswith(r"\mathcal") and left not in DEFINED
    }


@pytest.mark.few("shunt_mass", "delayed-spring")
@pytest.mark.parametrize(
    "name", [*SYMBOLIC, *(x for x in WRITTEN_OUT if x not in ("fu2019", "helicopter-cyclic", "lead-compensation"))]
)  # its phases are of two arguments
def test_every_printed_closed_form_has_the_value_that_it_stands_for(name):
    d = SYMBOLIC.get(name) or load_scene(name).symbolic_distortion()
    known = assumed(d)
    printed = {set_name(named(x.name)): number for x, number in known.items()}
    read = read_values(latex(d), {**printed, r"\omega": _AT, "s": 0.83, "c": 1.0, "X": 1.0, "j": 1.0})
    H_env, H_perc = (
        float(sp.sympify(x.xreplace(known)).subs({s: 0.83, sp.I: 1})) for x in (d.environment, d.perceived)
    )
    expected = {
        **expected_values(d, known), r"H_{\mathrm{env}}(s)": H_env, r"H_{\mathrm{perc}}(s)": H_perc,
    }  # fmt: skip
    assert set(read) == set(expected)
    for left, sides in read.items():
        assert sides == pytest.approx([expected[left]] * len(sides), rel=1e-9, abs=1e-9), left
    must = [left for left in expected if re.match(r"H_|\\operatorname|\\left|k_|b_", left)]
    assert all(read[left] for left in must)


@pytest.mark.slow
@pytest.mark.few("fu2019")
@pytest.mark.parametrize("name", often(scene_names(), QUICK_SCENES.__contains__))
def test_the_printed_threshold_polynomials_change_sign_at_the_crossings(name):
    e, text = shipped(name)
    sides = equations(_between(text, "up to a positive factor:\n", r"\end{align*}"))
    assert sides
    for c in e.crossings:
        polynomial = sides[rf"p_{c.part.value[0]}(\omega)"][0]
        if "Delta" in polynomial:  # by the distortion, where no readable numbers have its roots
            continue
        below, above = (value(polynomial, {r"\omega": float(c.omega) * (1 + sign * 1e-3)}) for sign in (-1, 1))
        assert (below < 0 < above) if c.kind.value == "exceeds" else (below > 0 > above)


@pytest.mark.slow
def test_the_exact_threshold_polynomial_of_the_paper_vanishes_between_the_bounds_of_its_crossing():
    e = evaluate(PAPER)
    sides = equations(_between(set_document(e), "up to a positive factor:\n", r"\end{align*}"))
    assert e.crossings
    for c in e.crossings:
        text = re.sub(r"\\omega\^\{(\d+)\}", r"*w**\1", sides[rf"p_{c.part.value[0]}(\omega)"][0]).replace("{}", "")
        polynomial = sp.Poly(sp.sympify(text), Symbol("w"))
        low, high = (polynomial.eval(Rational(Fraction(x))) for x in c.omega.enclosure(30))
        assert low < 0 < high


def _between(text: str, start: str, end: str) -> str:
    return text.split(start)[1].split(end)[0]


@pytest.mark.slow
@pytest.mark.parametrize("name", often(scene_names(), SET.__contains__))
def test_the_numbers_put_into_the_formulas_give_the_perceived_dynamics(name):
    """Rounded to six digits, a coefficient is right to 5e-6: so is a value far from where terms cancel."""
    e, text = shipped(name)
    sides = equations(_between(text, r"are correct):" + "\n", r"\end{align*}"))
    known = {}
    for left, right in sides.items():
        if left.startswith(r"\mathcal"):
            known[left] = value(right[0], {"s": 2.5, "j": 1.0})
    if r"H_{\mathrm{perc}}(s)" not in sides:
        assert r"Longer than 2 lines with numbers: $H_{\mathrm{perc}}" in text
        return
    printed = value(sides[r"H_{\mathrm{perc}}(s)"][0], {"s": 2.5, "j": 1.0, **known})
    assert printed == pytest.approx(float(e.distortion.perceived.subs({s: 2.5, sp.I: 1})), rel=2e-5)


@pytest.mark.dear("sidestick")
@pytest.mark.parametrize("name", often(scene_names(), QUICK_SCENES.__contains__))
def test_the_tables_hold_every_crossing_and_every_percept(name):
    e = evaluate(load_scene(name), digits=12)
    text = re.sub(r"\\phantom\{0+\}", "", latex(e, digits=12))
    assert [row.split(" & ")[1] for row in re.findall(r"^ +(?:real|imag) & .*\$r_.*$", text, re.MULTILINE)] == [
        printed(in_unit(c.omega, e.scene.frequency.size), 12, Way.NEAREST) for c in e.crossings
    ]
    assert re.findall(r"Delta H ([<>]) 0\$", text) == [">" if c.sign > 0 else "<" for c in e.crossings]
    felt = re.findall(r"^ +(real|imag) & [\d. to]+ & ([a-z, ():]+?) \\\\", text, re.MULTILINE)
    assert felt == [(x.part.value, x.words) for x in e.felt]
    assert text.count("proven") == bool(e.crossings) + bool(e.felt)


# Any formula.


@given(EXPRESSIONS)
def test_any_printed_formula_reads_back_with_the_same_value(expression):
    known = {x: 0.37 + 0.29 * i for i, x in enumerate(ATOMS)}
    expected = float(expression.xreplace({x: Float(number) for x, number in known.items()}))
    read = value(latex(expression), {set_name(named(x.name)): number for x, number in known.items()})
    assert read == pytest.approx(expected, rel=1e-6, abs=1e-6)


# Long formulas.


def test_no_line_is_broken_inside_a_fraction_a_root_or_an_absolute_value():
    text = r"\frac{a + b}{c + d} + \sqrt{a + b} + \left| a + b \right| + (a + b)"
    lines = broken(text, 0.1)
    assert lines[0] == r"\frac{a + b}{c + d}"
    assert r"{} + \sqrt{a + b}" in lines
    assert r"{} + \left| a + b \right|" in lines


def test_a_product_is_broken_between_its_sums_with_a_sign_for_the_product():
    assert broken("(a + b) (c + d) (e + f)", 8.0) == ["(a + b) (c + d)", r"{} \times (e + f)"]


# Text.


def test_no_character_of_a_users_text_reaches_latex_unescaped():
    every = "".join(map(chr, range(0x3000)))
    text = escape(every)
    assert text.isascii()
    assert text.isprintable()
    assert not re.search(r"(?<!\\)[$&#%_~^](?!\{|\d)", re.sub(r"\\ensuremath\{.*?\}|\\[~^]", "", text))


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("50% & $ x_1", r"50\% \& \$ x\_1"),
        ("Küçük naïve", r"K\"{u}\c{c}\"{u}k na\"{\i}ve"),
        ("ω₀ = 2πf²", r"\ensuremath{\omega}\textsubscript{0} = 2\ensuremath{\pi}f\textsuperscript{2}"),
        ("a -- b\n\n c", "a -{}- b c"),
        ("中", r"[U+4E2D]\allowbreak{}"),
    ],
)
def test_text_is_escaped_and_still_reads(text, expected):
    assert escape(text) == expected


# Documents compile.

EVERY_CHARACTER = "".join(chr(i) for i in range(0x20, 0x2300) if not unicodedata.category(chr(i)).startswith("C"))
DOCUMENTS = {
    "no effects": Scene(MSD, title="Nothing in between"),
    "whole band transparent": Scene(MSD, (effects.first_order_lag("1000 Hz"),)),
    "empty set, hostile text": Scene(
        MSD,
        (effects.series("2", name=r"\end{document}%_&"),),
        title=r"\input{x} $_{^} \\ % # & ~ }{" + "x" * 300,
        source=" ".join(EVERY_CHARACTER),
    ),
    "prony list": Scene(
        environments.prony("100 N/m", ["50 N/m", "70.5 N/m"], ["6 N*s/m", "2 N*s/m"]), (effects.first_order_lag("20 Hz"),)
    ),
    "many crossings": Scene(
        MSD, (effects.pade_delay("0.3 s", 10), effects.pade_delay("0.7 s", 10)), (Integer(0), Integer(200))
    ),
    "long names, long numbers": Scene(
        environments.expression("(s + 1.23456789)^9/(s + 2)^7 + stiffness_of_the_wall", parameters={"stiffness_of_the_wall": 3}),
        tuple(effects.second_order_lowpass(f"{350 + i} rad/s", "0.5") for i in range(4)),
        threshold=Threshold.of("0.1", "0.12"),
    ),
    "teleoperator": Scene(MSD, (effects.position_force_teleoperator("0.5 kg", "0.6 kg", "30 N*s/m", "1 kN/m"),)),
    "active and unstable": Scene(MSD, (effects.shunt(b="-20 N*s/m"), effects.admittance_display("(s + 1)/(s^2 - s + 2)"))),
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("name", [pytest.param(x, marks=[pytest.mark.core] * (x == "fu2019")) for x in scene_names()])
def test_the_document_of_a_shipped_scene_compiles(name, tmp_path):
    check_layout(compiled(shipped(name)[1], tmp_path))


@pytest.mark.slow
@pytest.mark.parametrize("name", DOCUMENTS)
def test_the_document_of_an_unusual_scene_compiles(name, tmp_path):
    check_layout(compiled(set_document(evaluate(DOCUMENTS[name])), tmp_path))


@pytest.mark.slow
def test_a_table_with_sixty_digits_compiles(tmp_path):
    scene = Scene(MSD, (effects.pade_delay("0.3 s", 4),), (Integer(0), Integer(100)))
    check_layout(compiled(set_document(evaluate(scene, digits=60)), tmp_path))


@pytest.mark.slow
def test_the_closed_forms_compile_in_a_plain_article(tmp_path):
    blocks = "\n\n".join(latex(d) for d in SYMBOLIC.values())
    result = latex(evaluate(PAPER))
    head = r"\documentclass{article}\usepackage[a4paper,margin=2.5cm]{geometry}\usepackage{amsmath,booktabs}\allowdisplaybreaks"
    check_layout(compiled(f"{head}\n\\begin{{document}}\n{blocks}\n\n{result}\n\\end{{document}}\n", tmp_path))


def test_the_table_for_a_paper_has_the_numbers_of_its_answer_and_needs_booktabs_alone(call, tmp_path):
    asked = {
        "evaluate": "fu2019", "compare": "fu2019 helicopter-cyclic", "require": "fu2019 --free zeta", "design": "fu2019 --free zeta=0.1:1",
        "stability": "fu2019 --hand firm-grip", "tolerances": "fu2019-tolerances --samples 0",
    }  # fmt: skip
    for verb, words in asked.items():
        status, _, err = call(verb, *words.split(), "--digits", "7", "--latex-table", str(tmp_path / f"{verb}.tex"))
        assert status == 0, err
    tables = {verb: (tmp_path / f"{verb}.tex").read_text(encoding="ascii") for verb in asked}
    assert all(x.count("tabular") == 2 and x.startswith("% \\caption{") and "\\ref" not in x for x in tables.values())
    rows = re.findall(
        r"^ +(real|imag) & ([\d.]+) & ([\d.]+) &", re.sub(r"\\phantom\{0+\}", "", tables["evaluate"]), re.MULTILINE
    )
    assert rows == [
        (c.criterion.name, c.omega.digits(7), printed(in_unit(c.omega, 2 * pi), 7, Way.NEAREST))
        for c in evaluate(PAPER).crossings
    ]
    assert "7.978917" in tables["compare"]
    assert len({re.search(r"label\{(.*)\}", x)[1] for x in tables.values()}) == len(tables)
    # Verdict, and the limit of each parameter that has one, of the hand that was asked about.
    [sets] = stability("fu2019", "firm-grip").critical
    assert "firm-grip: stable &" in tables["stability"]
    assert tables["stability"].count(r" \\") == 1 + sum(bool(x.ends) for x in sets.values())
    body = "\n\n".join(tables.values())
    head = r"\documentclass{article}\usepackage[landscape,margin=1cm]{geometry}\usepackage{booktabs}"
    check_layout(compiled(f"{head}\n\\begin{{document}}\n{body}\n\\end{{document}}\n", tmp_path))


@pytest.mark.slow
def test_what_is_named_is_numbered_as_it_is_read_and_defined_as_exactly_as_it_is_used():
    text = set_document(evaluate(load_scene(FLEXIBLE)))
    names = list(dict.fromkeys(re.findall(r"\\mathcal\{([ND])\}_\{(\d+)\}", text)))
    for letter in "ND":
        numbers = [int(number) for one, number in names if one == letter]
        assert numbers == list(range(1, len(numbers) + 1))
    definitions = dict(re.findall(r"(\\mathcal\{[ND]\}_\{\d+\}) &(=|\\approx)", text))
    assert set(definitions.values()) == {"=", r"\approx"}
    for line in text.splitlines():
        used = re.search(r"&(=|\\approx) -?\\frac\{(\\mathcal\{N\}_\{\d+\})\}", line)
        assert not used or definitions[used[2]] == used[1], line


@pytest.mark.slow
def test_the_document_has_title_date_and_an_appendix_of_threshold_polynomials():
    figures = {
        name: f"{name}.pdf" for name in ("ratios", "projections-real", "projections-imag", "nyquist", "jnd-square")
    }
    text = set_document(evaluate(PAPER), figures)
    for command in (r"{\LARGE ", r"\today"):
        assert text.index(command) < text.index(r"\section{Scene}")
    body, _, appendix = text.partition("\\appendix")
    assert ("p_r(\\omega) &=" in body, "p_r(\\omega) &=" in appendix) == (False, True)
    assert text.count(r"\caption{") == 4 + 5
    assert set(re.findall(r"\\includegraphics.*\{(.*)\}", text)) == set(figures.values())


@pytest.mark.slow
def test_what_is_undecided_is_listed_and_nothing_is_called_proven_without_it():
    """A tangency that stayed open, made from one that did not."""
    spring_late_by_a_second = Scene(
        environments.mass_spring_damper(k=1), (effects.delay(1),), (0, 6), Threshold.of(2, 5)
    )
    e = evaluate(spring_late_by_a_second)
    real = e.criteria[0]
    [touch] = [x for x in e.chart.points if x.orders.get(real)]
    opened = replace(touch, undecided=frozenset([real]))
    points = tuple(opened if x is touch else x for x in e.chart.points)
    text = set_document(replace(e, chart=replace(e.chart, points=points)))
    low, high = touch.omega.enclosure(15)
    assert f"[{low}, {high}]" in text.replace(r"\allowbreak{}", "")
    assert "proven: none missed" not in text
    assert "Undecided" in text
    assert "undecided" not in set_document(e).lower().replace("passivity undecided", "")


def test_the_parameters_of_a_report_have_their_ranges_and_each_column_of_frequencies_is_there_once() -> None:
    document = latex_document(evaluate(load_scene("fu2019-tolerances")).document())
    assert "value & range & unit" in document
    assert document.count("& \\ensuremath{\\pm}5~\\% &") == len(load_scene("fu2019-tolerances").parameters)
    assert "(rad/s) (rad/s)" not in document
    assert "Hz & Hz" not in document
