"""What values show in a notebook, of values put together by hand: formulas in LaTeX, sentences in HTML."""

from __future__ import annotations

import re
from html import unescape
from types import SimpleNamespace as Made
from typing import Any

import pytest
from sympy import Rational, pi, sqrt

import haptisym as hs
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.roots import Interval, Point
from haptisym.kernel.symbols import omega
from haptisym.pages import notebook
from haptisym.pages.notebook import html, latex

E, F = hs.environments, hs.effects
SPRING = E.mass_spring_damper(k=100)
k, b = hs.symbols("k b")


def evaluated(jnd: Any = "0.1", band: Any = (0, 15)) -> hs.Evaluation:
    return hs.evaluate(hs.Scene(SPRING, (F.first_order_lag(20),), band, jnd))


PLAIN, DISC = evaluated(), evaluated({"shape": "ellipse", "real": "0.1", "imag": "0.1"})


def shown(markup: str | None) -> str:
    assert markup is not None
    return " ".join(unescape(re.sub(r"<[^>]*>", "", markup)).replace("\u2061", "").replace("\xa0", " ").split())


# LaTeX

CHAIN = (
    r"\begin{pmatrix} F_h \\ X_h \end{pmatrix} = \begin{pmatrix} \frac{\omega_c}{s + \omega_c} & 0 \\ 0 & 1 \end{pmatrix} "
    r"\begin{pmatrix} F_e \\ X_e \end{pmatrix},\quad \omega_c = 6 \pi \approx 18.8496\,\mathrm{rad/s}"
)


@pytest.mark.parametrize(
    ("x", "told"),
    [
        (ExactNumber(Rational(1, 3)), r"\tfrac{1}{3}"), (ExactNumber(Rational(7)), "7"), (ExactNumber(pi / 4), r"0.25 \pi \approx 0.785398163397448"),
        (ExactNumber(Rational(3, 2)), "1.5"), (Point(ExactNumber(Rational(5, 2)), {}, {}, {}), r"\omega = 2.50000000000000\,\mathrm{rad/s}"),
        (Interval(Point(ExactNumber(Rational(1)), {}, {}, {}), Point(ExactNumber(Rational(10, 3)), {}, {}, {})), r"\left[ 1,\, 3.3333 \right]\,\mathrm{rad/s}"),
        (hs.Threshold.of("0.1"), "c = 0.1"), (hs.Threshold.of("0.1", "0.2"), r"c_{\mathrm{real}} = 0.1,\quad c_{\mathrm{imag}} = 0.2"),
        (hs.Threshold(sqrt(2) / 10, sqrt(2) / 10), r"c = 0.1 \sqrt{2} \approx 0.141421"),
        (E.mass_spring_damper(k=k), "H(s) = k"), (E.mass_spring_damper(k=k, b="3 N*s/m"), r"H(s) = b s + k,\quad b = 3\,\mathrm{N\,s/m}"),
        (E.mass_spring_damper(k="2 N*m/rad"), r"H(s) = k,\quad k = 2\,\mathrm{N\,m/rad}"),
        (F.first_order_lag("3 Hz"), CHAIN),
    ],
)  # fmt: skip
def test_a_formula_or_a_number_is_set_with_its_value_and_unit(x: Any, told: str) -> None:
    assert latex(x) == rf"$\displaystyle {told}$"


def test_numbers_very_large_or_small_have_powers_of_ten() -> None:
    assert notebook._decimal("1.5E-7") == r"1.5 \times 10^{-7}"
    assert notebook._decimal("2E+9") == r"2 \times 10^{9}"
    assert notebook._decimal("1.25") == "1.25"
    assert (
        latex(Point(ExactNumber(Rational(1, 10**9)), {}, {}, {}))
        == r"$\displaystyle \omega = 1.00000000000000 \times 10^{-9}\,\mathrm{rad/s}$"
    )


def test_a_ratio_without_unit_has_none_behind_its_value() -> None:
    told = latex(F.second_order_lowpass("80 rad/s", "0.5"))
    assert told is not None
    assert told.endswith(r"\omega_n = 80\,\mathrm{rad/s},\quad \zeta = 0.5$")


def test_a_crossing_is_an_equation_with_its_threshold_or_a_sentence_where_a_region_is_left() -> None:
    imag, real = PLAIN.crossings  # 20 (5 - sqrt(24)), and 20/3
    assert latex(real) == r"$\displaystyle r_r = c_{\mathrm{real}},\quad \omega = 6.66666666666667\,\mathrm{rad/s}$"
    assert latex(imag) == r"$\displaystyle r_i = c_{\mathrm{imag}},\quad \omega = 2.02041028867288\,\mathrm{rad/s}$"
    [leaves] = DISC.crossings
    told = latex(leaves)
    assert told is not None
    assert re.fullmatch(
        r"\$\\displaystyle \\text\{.* leaves the ellipse at\}\\ \\omega = [\d.]+\\,\\mathrm\{rad/s\}\$", told
    )
    moving = evaluated({"real": "(1 + omega)/100", "imag": "0.9"}, (1, 15)).crossings
    assert all(r"\text{" in str(latex(x)) for x in moving if x.criterion.threshold.has(omega))
    assert any(x.criterion.threshold.has(omega) for x in moving)


def test_a_distortion_is_set_in_full_where_it_can_be_read_and_its_dynamics_where_not() -> None:
    def names(number: int) -> list[str]:
        own = tuple(F.first_order_lag(hs.symbols(f"w_{n}"), name=f"l{n}") for n in range(number))
        told = latex(hs.distort(E.mass_spring_damper(k=k), *own))
        assert told is not None
        assert told.startswith("$$\\begin{aligned}\n")
        assert told.endswith("\\end{aligned}$$")
        return [x.strip().split(" &")[0] for x in told.splitlines()[1:-1] if not x.strip().startswith("&")]

    few, many = names(2), names(8)
    assert few[:2] == many == [r"H_{\mathrm{env}}(s)", r"H_{\mathrm{perc}}(s)"]
    assert len(few) == 7
    assert few[2].startswith(r"\Re \Delta H")


def test_what_is_no_formula_shows_none_and_what_is_no_table_no_html() -> None:
    for x in (3, "x", None, hs.Scene(SPRING), PLAIN):
        assert latex(x) is None
    others: tuple[Any, ...] = (3, "x", None, SPRING, hs.Threshold.of("0.1"), ExactNumber(Rational(1)))
    assert [html(x) for x in others] == [None] * 6


# HTML


def test_a_crossing_in_words_says_what_happens_where_and_with_which_sign() -> None:
    imag, real = PLAIN.crossings
    assert re.fullmatch(r"rr rises above its threshold at 6\.66666666666667 rad/s \(Re ?ΔH ?< ?0\)", shown(html(real)))
    assert shown(html(imag)).startswith("ri rises above its threshold at 2.02041028867288 rad/s (Im")
    [leaves] = DISC.crossings
    told = shown(html(leaves))
    assert re.fullmatch(r"ΔH ?.*leaves the ellipse at [\d.]+ rad/s", told), told


def test_a_percept_names_the_part_or_both_and_its_band() -> None:
    parts = {shown(html(x)).partition(" (")[2].partition(")")[0] for x in PLAIN.percepts}
    assert parts <= {"real part", "imaginary part"}
    assert {shown(html(x)).partition(" (")[2].partition(")")[0] for x in DISC.percepts} <= {
        "both parts together",
        "real part",
        "imaginary part",
    }
    for x in (*PLAIN.percepts, *DISC.percepts):
        assert shown(html(x)).endswith(" rad/s")
        assert ", from " in shown(html(x))


def test_a_peak_is_a_sentence_and_an_equation() -> None:
    """r_i of a lag is largest, a half, at its cutoff."""
    [peak] = hs.peaks(hs.Scene(SPRING, (F.first_order_lag(10),), (0, 15), "0.1"))
    assert shown(html(peak)) == "ri has a local maximum of 0.5 at 10 rad/s"
    assert latex(peak) == r"$\displaystyle r_i = 0.5,\quad \omega = 10\,\mathrm{rad/s}$"


def test_an_answer_whose_page_is_text_stays_text() -> None:
    class Told:
        def document(self) -> str:
            return "a < b"

    found: Any = Told()
    assert notebook._answer_html(found) == '<pre class="haptisym">a &lt; b</pre>'
    assert str(html(PLAIN)).startswith('<div class="haptisym">')
    assert str(html(PLAIN.distortion)).startswith('<div class="haptisym"><div class="scroll formulas">')
    assert "Untitled scene" in shown(html(PLAIN.scene))


def test_the_view_of_a_value_is_that_of_the_nearest_of_its_kinds() -> None:
    class Base: ...

    class Own(Base): ...

    views: Any = {Base: lambda _: "base", Own: lambda _: "own"}
    assert notebook._shown(views, Own()) == "own"
    assert notebook._shown({Base: lambda _: "base"}, Own()) == "base"
    assert notebook._shown({Own: lambda _: "own"}, Base()) is None
    assert notebook._unit(Made(unit_in=lambda _: "1", motion=None)) == ""  # type: ignore[arg-type]
    assert notebook._unit(Made(unit_in=lambda _: "N*s/m", motion=None)) == r"\,\mathrm{N\,s/m}"  # type: ignore[arg-type]
