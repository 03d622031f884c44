"""Every answer's page: a document that any width can be set in, whose figures can be drawn and whose numbers are numbers."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from math import isfinite
from typing import Any

import pytest
from marks import often
from sympy import Poly, Rational, Symbol

import haptisym as hs
from haptisym.commands.spelling import spelt
from haptisym.figures.pen import WIDTH
from haptisym.model.measuredscene import MeasuredScene
from haptisym.model.parameters import Parameter, Rule
from haptisym.model.quantities import Dimension, MotionKind
from haptisym.pages.explorer import _parameter
from haptisym.verbs.cost.hardcases import hard_cases
from haptisym.verbs.jnd.answers import Answers, Row
from haptisym.verbs.stability.loops import ALLOWED
from haptisym.verbs.sweep.swept import Swept
from haptisym.writing.document import (
    Block,
    Document,
    Equations,
    Figure,
    Number,
    Phrase,
    Section,
    Table,
    chosen,
    figures_of,
)
from haptisym.writing.plain import plain, said

SPRING = hs.environments.mass_spring_damper(k="100 N/m +- 10 %")
RANGED = hs.Scene(SPRING, (hs.effects.first_order_lag("40 rad/s +- 10 %"),))
TINY = hs.Scene(hs.environments.mass_spring_damper(1.8, 15, 100), (hs.effects.first_order_lag("1 MHz"),))

ANSWERED = Answers("stiffness", tuple(Row(4.4 + 0.3 * i, k, 40) for i, k in enumerate((5, 11, 19, 26, 33, 37))))
LINES = MeasuredScene(SPRING, hs.measured([1, 2, 3, 4], [100, 109, 130 + 20j, 90], radius=[2] * 4))

ANSWERS: dict[str, Callable[[], Any]] = {
    "effects": lambda: hs.relevance("sidestick"),
    "effects of none": lambda: hs.relevance(hs.Scene(SPRING)),
    "sensitivity": lambda: hs.sensitivity("fu2019"),
    "sensitivity, nothing noticed": lambda: hs.sensitivity(TINY),
    "tolerances": lambda: hs.tolerances(RANGED, samples=5),
    "require": lambda: hs.require("fu2019", "omega_n"),
    "require, in vain": lambda: hs.require("fu2019", "omega_n", (10, 50)),
    "map": lambda: hs.design_map("fu2019", ["zeta", "omega_n"], [("0.4", "0.6"), (50, 500)], slices=3),
    "family": lambda: hs.evaluate_all(hs.load_scenes("palpation-device")),
    "metrics": lambda: hs.metrics("steering-wheel"),
    "stability": lambda: hs.stability("delayed-spring", ["light-touch", "postural-arm"]),
    "stability, a neutral system": lambda: hs.stability("satellite-contact", "light-touch"),
    "stability, no hand": lambda: hs.stability("fu2019"),
    "sweep": lambda: Swept(TINY, hs.sweep(TINY, {"environment.m": [1.0, 2.0, 3.0]})),
    "identify": lambda: hs.identify(hs.sampled("fu2019", [1, 4, 7, 10]), "mass-spring-damper"),
    "simulate": lambda: hs.simulate("fu2019", hs.sine("5 cm", 10)),
    "release": lambda: hs.release("delayed-spring", "1 cm", hs.Hand("own", m="0.5 kg", b="3.6 N*s/m")),
    "release, a neutral system": lambda: hs.release("satellite-contact", "1 cm", "postural-arm"),
    "jnd": lambda: hs.jnd(ANSWERED, reference=5, lapse=0.02),
    "jnd that does not fit": lambda: hs.jnd(
        Answers("two people", tuple(Row(float(x), k, 40) for x, k in enumerate((2, 30, 8, 33, 12, 38))))
    ),
    "published": hs.published,
    "cost": lambda: hs.cost("fu2019", quick=True),
    "hard costs": lambda: hs.hard_costs(hard_cases("identities")),
    "evaluate": lambda: hs.evaluate("fu2019"),
    "measured": lambda: hs.evaluate(LINES),
    "peaks": lambda: hs.peaks("steering-wheel"),
}


DEAR = ("cost", "hard costs", "release", "jnd that does not fit")


@pytest.fixture(scope="module", params=often(ANSWERS, lambda name: name not in DEAR))
def page(request: pytest.FixtureRequest) -> Document:
    document = ANSWERS[request.param]().document()
    assert isinstance(document, Document)
    return document


def inside(blocks: Iterable[Block]) -> Iterator[Block]:
    """All blocks, those of sections too."""
    for block in blocks:
        yield block
        if isinstance(block, Section):
            yield from inside(block.blocks)


def numbers(words: Phrase) -> Iterator[Number]:
    if isinstance(words, tuple):
        for x in words:
            yield from numbers(x)
    elif isinstance(words, Number):
        yield words


@pytest.mark.few(8)
@pytest.mark.parametrize("columns", [40, 96])
def test_a_page_fits_its_columns(page: Document, columns: int) -> None:
    lines = plain(page, columns).split("\n")
    assert not [x for x in lines if len(x) > columns and " " in x.strip()]
    assert not [x for x in lines if x != x.rstrip()]


@pytest.mark.few(2)
def test_figures_of_a_page_can_be_drawn_and_have_names_of_their_own(page: Document) -> None:
    figures = [x for x in inside(chosen(page.blocks, full=True)) if isinstance(x, Figure)]
    assert len({x.name for x in figures}) == len(figures)
    for x in figures:
        assert x.draw().axes, x.name
        assert said(x.caption).endswith("."), x.name


@pytest.mark.slow
def test_a_figure_that_takes_the_width_of_the_page_is_drawn_wider_than_a_column() -> None:
    pages = hs.evaluate("fu2019").document(), hs.evaluate("fu2019-bench").document()
    drawn = [x for page in pages for x in figures_of(page.blocks) if x.name in ("ratios", "nyquist")]
    assert [(x.wide, x.draw().get_figwidth() > 1.4 * WIDTH) for x in drawn] == [(True, True), (False, False)] * 2


def test_tables_are_as_wide_as_their_headings_and_called_something(page: Document) -> None:
    for x in inside(chosen(page.blocks, full=True)):
        if isinstance(x, Table):
            assert said(x.caption).endswith(".")
            assert {len(row) for row in x.rows} == {len(x.columns)}
            digits = [n for row in x.rows for cell in row for n in numbers(cell)]
            assert all(isfinite(n.value) for n in digits)
            for n in digits:
                shown = n.digits.lstrip("=+").replace(",", "")
                assert float(shown) == pytest.approx(n.value, rel=0.1, abs=1e-12), n
        if isinstance(x, Equations):
            assert x.lines


def test_a_requirement_says_what_was_asked_of_the_display() -> None:
    said = " ".join(str(hs.require("fu2019", "zeta")).split())
    assert "condition r_r ≤ c_real and r_i ≤ c_imag on the whole band" in said


def test_a_greek_letter_stands_apart_from_a_word_but_not_from_a_bracket() -> None:
    assert spelt("(τ), cos ωτ", "ascii") == "(tau), cos omega tau"


VALUES = {
    Rule.ANY: [-3, Rational(-1, 7), 0, Rational(2, 9), 40],
    Rule.POSITIVE: [Rational(1, 10**6), 3, 10**5],
    Rule.NONNEGATIVE: [0, Rational(1, 90), 12],
    Rule.FRACTION: [Rational(1, 3), Rational(9, 10)],
}


@pytest.mark.parametrize("rule", VALUES)
@pytest.mark.parametrize("dimension", [Dimension.ANY, Dimension.MASS, Dimension.RATIO])
def test_a_slider_begins_between_its_ends_all_of_which_its_rule_allows(rule: Rule, dimension: Dimension) -> None:
    least, most, _ = ALLOWED[rule]
    for value in VALUES[rule]:
        slider = _parameter(
            Parameter(Symbol("q"), Rational(value), dimension, rule=rule), "q", "q", MotionKind.TRANSLATION
        )
        assert slider.value == float(value)
        assert slider.low < slider.high
        assert slider.low <= slider.value <= slider.high
        assert least is None or slider.low >= least
        assert most is None or slider.high <= most
        assert not slider.is_logarithmic or slider.low > 0
        assert rule is not Rule.ANY or slider.low == -slider.high


def test_text_names_symbols_and_relations_as_formulas_do_and_not_as_a_keyboard_does() -> None:
    """One name for each thing on a page: zeta is not ζ in the table and zeta in the formula."""
    pages = "".join(str(f("fu2019")) for f in (hs.evaluate, hs.derive, hs.metrics, hs.stability))
    assert "ω_n^2/(s^2 + 2 ζ ω_n s + ω_n^2)" in pages
    assert "(π - atan(ω_d/σ))/ω_d" in pages
    assert "Im H_perc ≥ 0" in pages
    assert "2 b ζ ω^2/ω_n" in pages
    assert "damping, N·s/m" in pages
    assert not re.search(r"\b(omega|zeta|sigma|pi)\b(?![.\w])|[<>!]=|N [ms]\b|N\*", pages)


def test_a_closed_form_is_written_out_while_it_can_be_read_and_counted_where_not() -> None:
    """Terms of a shipped scene's twelfth order, counted by SymPy."""
    short, long = str(hs.evaluate("fu2019")), hs.evaluate("control-stick-in-detail")
    assert "H_perc(s) = (11520 s^2 + 96000 s + 640000)/(s^2 + 80 s + 6400)  N/m" in short
    above, below = (len(Poly(x, Symbol("s")).terms()) for x in long.distortion.perceived.cancel().as_numer_denom())
    assert (above, below) == (13, 11)
    assert f"H_perc(s) has {above} terms over {below}: see `haptisym derive`\n" in str(long)


BARE = re.compile(r"[=+-]?[\d.,]+([eE][-+]?\d+)?( from (above|below))?")
INSTEAD = ("never", "none", "whole band", "infinite", "from infinity", "a chain near it")
RANGES = (
    "What is felt at the lines",
    "Least and largest of all sets",
    "Where crossings of the full scene are",
    "The motion that lasts longest",
)


def test_columns_of_numbers_are_those_whose_cells_are_numbers(page: Document) -> None:
    """So that their points stand below each other; a cell may be empty, or say that there is none; some tables have ranges too."""
    for x in inside(chosen(page.blocks, full=True)):
        for i, column in enumerate(x.columns if isinstance(x, Table) else ()):
            assert isinstance(x, Table)
            cells = [said(row[i]) for row in x.rows if said(row[i]) not in ("", "-")]
            of_numbers = all(BARE.fullmatch(cell) or cell in INSTEAD for cell in cells)
            assert of_numbers or not column.number, (said(x.caption), said(column.heading))
            if cells and not said(x.caption).startswith(RANGES):
                assert column.number or not of_numbers, (said(x.caption), said(column.heading))
