"""What a page says of measured lines of a spring: shares of the environment's magnitude that anybody can count."""

from __future__ import annotations

import re
from dataclasses import replace
from math import erfc, pi, sqrt
from typing import Any

import numpy as np
import pytest
from pagewords import flat, lines, row
from scipy.stats import f as fisher

import haptisym as hs
from haptisym.model.measuredscene import MeasuredScene
from haptisym.pages.measuredlines import linearity, measured_words
from haptisym.writing.document import Figure, Section, Strong, Table
from haptisym.writing.plain import said

SPRING = hs.environments.mass_spring_damper(k=100)


def judged(change: Any, environment: Any = SPRING, *, threshold: Any = "0.1", band: Any = None, **own: Any) -> Any:
    """Lines at 1, 2, 3 ... rad/s at which the spring of 100 N/m is felt so much stiffer, in N/m."""
    d = np.asarray(change, dtype=complex)
    felt = hs.measured(np.arange(1, len(d) + 1), 100 + d, **own)
    return hs.evaluate(MeasuredScene(environment, felt, band, threshold))


def disc(radius: float, count: int) -> dict[str, Any]:
    return {"radius": [radius] * count}


def rows(page: object, head: str) -> list[str]:
    """The lines of the table below a heading that begins so."""
    shown = lines(page)
    first = next(n for n, x in enumerate(shown) if x.startswith(head)) + 2
    return shown[first : shown.index("", first)]


# Step 1


def test_of_each_part_the_lines_that_exceed_are_below_or_open_are_counted_and_the_first_named() -> None:
    """With discs of 2 N/m about changes of 0, 9, 11, 30 and 4j the limit of 10 N/m is open at two of them."""
    found = judged([0, 9, 11, 30, 4j], **disc(2, 5))
    text = flat(found)
    assert "r_r (real part) exceeds its threshold at 1 of 5 lines, is below it at 2 and unresolved at 2; the first line that exceeds is at 4 rad/s." in text  # fmt: skip
    assert (
        "r_i (imaginary part) exceeds its threshold at none of 5 lines, is below it at 5 and unresolved at none."
        in text
    )
    for n, line in enumerate(("0 0 0.02 below below", "0.09 0 0.02 unresolved below", "0.11 0 0.02 unresolved below", "0.3 0 0.02 exceeds below", "0 0.04 0.02 below below"), 1):  # fmt: skip
        assert row(found, f"{n}") == f"{n / 2 / pi:.5g} {line}"
    assert "Unresolved in a part or in both: 2 lines. If the estimates stay where they are, half of them are resolved by discs of at most 1 %, all of them by 1 % of the environment's magnitude." in text  # fmt: skip
    assert "averages" not in text


def test_half_of_the_open_lines_need_larger_discs_than_all_of_them() -> None:
    text = flat(judged([0, 5, 9, 7], **disc(6, 4)))
    assert "Unresolved in a part or in both: 3 lines." in text
    assert "half of them are resolved by discs of at most 3 %, all of them by 1 % of the environment's" in text
    assert "Unresolved in a part" not in flat(judged([0, 30], **disc(2, 2)))


def test_the_discs_of_a_coherence_are_told_with_what_would_resolve_the_open_lines() -> None:
    """An H1 estimate of n averages has a disc of radius^2 = F(2, 2 n - 2) (1 - C)/(C (n - 1)), of its own magnitude."""
    n, c = 20, np.array([0.97, 0.9999, 0.95])
    factor = fisher.ppf(0.95, 2, 2 * n - 2) / (n - 1)
    found = judged([5, 0, 30], coherence=c, averages=n)
    radius = np.sqrt(factor * (1 - c) / c) * np.array([1.05, 1.0, 1.3])
    assert row(found, "perceived") == "measured: 3 lines from 1 to 3 rad/s; coherence 0.95 to 0.9999, 20 averages"
    text = flat(found)
    assert f"discs 95 % confidence, radius {100 * radius.min():.4g} % to {100 * radius.max():.4g} % of the environment's magnitude; with 20 averages a disc of 10 % of what is felt needs a coherence of at least {factor / (factor + 0.01):.7g}" in text  # fmt: skip
    assert radius[0] > 0.05  # of the real part of the first line, and 0.1 of the imaginary part of the last
    assert radius[2] > 0.1
    both = re.search(r"With 20 averages that is a coherence of at least ([\d.]+) \(half\), ([\d.]+) \(all\); with the coherence that was measured, (\d+) \(half\), (\d+) \(all\) averages\.", text)  # fmt: skip
    assert both
    for told, need in zip(both.groups()[:2], (0.1 / 1.3, 0.05 / 1.05), strict=True):
        assert float(told) == pytest.approx(factor / (factor + need**2), rel=1e-5)
    for told, at, need in zip(both.groups()[2:], (c[2], c[0]), (0.1 / 1.3, 0.05 / 1.05), strict=True):
        m = float(told)
        own = [fisher.ppf(0.95, 2, 2 * x - 2) / (x - 1) * (1 - at) / at for x in (m - 1, m + 1)]
        assert own[1] < need**2 < own[0]


def test_of_a_limit_that_grows_with_frequency_the_smallest_sets_the_coherence_that_is_needed() -> None:
    n = 20
    factor = fisher.ppf(0.95, 2, 2 * n - 2) / (n - 1)
    found = judged([0, 0, 0], coherence=[0.99] * 3, averages=n, threshold={"real": "(1 + omega)/40", "imag": "0.2"})
    need = factor / (factor + (1 / 20) ** 2)
    assert f"a disc of 5 % of what is felt needs a coherence of at least {need:.7g}" in flat(found)


def test_between_the_lines_is_told_by_a_bound_on_the_slope_and_only_where_one_was_stated() -> None:
    """Discs of 1 N/m grow by 2 N/m to half-way between lines 1 rad/s apart: 0 +- 3 is below 10, 30 +- 3 exceeds."""
    found = judged([0, 0, 2, 30, 30], slope="4 N*s/m", **disc(1, 5))
    text = flat(found)
    assert "slope |dH/dω| at most 4 N·s/m" in text
    assert "Between the lines, by the bound on the slope" in lines(found)
    assert "half-way between lines its radius is at most 3 % of the environment's magnitude." in text
    assert "and between them as far as the bound on the slope tells, which was stated and is not tested" in text
    assert "nothing is said between the lines" not in text
    assert "CONTRADICTED: in 1 gap between lines, the first from 3 to 4 rad/s, lines differ by more than their discs and the bound allow." in text  # fmt: skip
    told = re.search(r"r_r \(real part\) exceeds its threshold on (\S+) of 4 rad/s, is below it on (\S+), and is unresolved on (\S+) rad/s\.", text)  # fmt: skip
    assert told
    assert [float(x) for x in told.groups()] == pytest.approx([1, 2, 1])
    bare = flat(judged([0, 0, 2], **disc(1, 3)))
    assert "at the measured frequencies alone, and nothing is said between the lines." in bare
    assert "slope" not in bare


def test_a_region_has_a_figure_of_the_plane_and_two_thresholds_have_none() -> None:
    ellipse = {"shape": "ellipse", "real": "0.1", "imag": "0.2"}
    for threshold, names in (("0.1", ["ratios"]), (ellipse, ["ratios", "plane"])):
        page = judged([0, 9, 30], threshold=threshold, **disc(2, 3)).document()
        step = next(x for x in page.blocks if isinstance(x, Section) and x.name == "step-1")
        assert [x.name for x in step.blocks if isinstance(x, Figure)] == names


def test_what_no_bench_resolves_is_said_to_be_more_than_can_be_measured() -> None:
    text = flat(judged([10, 5], coherence=[0.9, 0.98], averages=20))
    assert "more than can be measured (all); with the coherence that was measured," in text
    assert text.endswith("Whether the display is stable was not looked at.")


def test_lines_without_discs_are_told_to_be_judged_as_if_they_were_exact() -> None:
    text = flat(judged([0, 30]))
    assert "discs UNKNOWN: neither coherence nor radius is given, and every line is judged as if it were exact" in text
    assert text.endswith("How certain the lines themselves are, nothing here tells.")
    assert "misses the truth" not in text


def test_lines_off_the_band_are_counted_and_the_band_is_told() -> None:
    found = judged([0, 5, 30], band=(2, 3), **disc(1, 3))
    assert row(found, "left out") == "1 line, off the band or without a line of the environment"
    assert row(found, "band") == "2 to 3 rad/s"
    whole = judged([0, 5, 30], **disc(1, 3))
    assert not [x for x in lines(whole) if x.startswith(("left out", "band"))]


def test_a_region_is_judged_first_and_then_each_part_by_itself() -> None:
    """An ellipse of 10 and 20 N/m: outside is 8 + 16j, whose parts are both inside their limits."""
    found = judged(
        [0, 8 + 16j, 30, 9.9 + 1j], threshold={"shape": "ellipse", "real": "0.1", "imag": "0.2"}, **disc(0.2, 4)
    )
    text = flat(found)
    assert "The change lies outside the ellipse at 2 of 4 lines, is inside it at 1 and unresolved at 1; the first line outside is at 2 rad/s. A part by itself:" in text  # fmt: skip
    assert "r_r (real part) exceeds its threshold at 1 of 4 lines, is below it at 2 and unresolved at 1; the first line that exceeds is at 3 rad/s." in text  # fmt: skip
    assert "ellipse real alone imaginary alone" in text
    assert row(found, "2").endswith("exceeds below below")
    assert [x for x in rows(found, "ω (rad/s) lines part felt as") if x.startswith("2 1 both ")] == ["2 1 both higher stiffness and higher damping"]  # fmt: skip


# Tables of many lines


@pytest.mark.parametrize(("alike", "count"), [(1, 100), (2, 50), (3, 41), (4, 25)])
def test_of_many_lines_those_that_are_judged_alike_share_a_row_and_the_first_forty_groups_are_shown(
    alike: int, count: int
) -> None:
    """By turns as stiff as the environment and stiffer by 30 N/m."""
    total = alike * count
    found = judged(np.where(np.arange(total) // alike % 2, 30, 0), **disc(2, total))
    shown = rows(found, "ω (rad/s) lines real imaginary")
    assert len(shown) == min(40, count)
    first, last = (shown[0], shown[-1])
    ends = "1" if alike == 1 else f"1 to {alike}"
    assert first == f"{ends} {alike} below below"
    n = len(shown)
    ends = f"{n}" if alike == 1 else f"{alike * (n - 1) + 1} to {alike * n}"
    assert last == f"{ends} {alike} {'below' if n % 2 else 'exceeds'} below"
    told = f"The first 40 of {count} groups of lines that are judged alike; JSON has every line."
    assert (told in flat(found)) == (count > 40)
    assert ("groups of lines that are judged alike" in flat(found)) == (count > 40)


def test_forty_lines_have_a_row_each_and_one_more_makes_groups() -> None:
    for count in (40, 41):
        found = judged([0] * count, **disc(2, count))
        assert (flat(found).count("radius real imaginary") == 1) == (count == 40)
        assert ("1 to 41 41 below below" in flat(found)) == (count == 41)


@pytest.mark.parametrize("groups", [39, 40, 41])
def test_what_is_felt_is_told_in_forty_rows_and_that_there_are_more_only_where_there_are(groups: int) -> None:
    found = judged([30, 0] * groups, **disc(2, 2 * groups))
    shown = rows(found, "ω (rad/s) lines part felt as")
    assert shown == [f"{2 * n + 1} 1 real higher stiffness" for n in range(min(40, groups))]
    assert ("The first 40 groups of lines that are felt alike; JSON has every line." in flat(found)) == (groups > 40)


# Step 2


def test_what_is_felt_is_named_where_the_disc_tells_it_and_not_where_it_does_not() -> None:
    """A change of -100 N/m leaves nothing to be named: whether a spring or a mass is felt the disc about 0 does not tell."""
    found = judged([30, -30, 20j, -20j, -100, 0], **disc(2, 6))
    shown = rows(found, "ω (rad/s) lines part felt as")
    assert shown[:2] == ["1 1 real higher stiffness", "2 1 real lower stiffness"]
    assert "5 1 real noticed, not named" in shown
    assert "3 1 imag higher damping" in shown
    assert "4 1 imag noticed, not named" in shown
    assert len(shown) == 5
    nothing = "Nothing is noticed for certain at any line, or not in which part: nothing is named."
    assert nothing not in flat(found)
    assert nothing in flat(judged([0, 9], **disc(2, 2)))


# Where lines come from


def test_a_measurement_is_told_with_its_lines_its_ends_and_what_its_discs_come_from() -> None:
    one = hs.measured([2], [100], radius=[1], name="bench.csv")
    assert said(measured_words(one)).startswith("bench.csv: 1 line at 2 rad/s; ")
    two = hs.measured([2, 7], [100, 90], coherence=[0.5, 0.75], averages=12)
    assert said(measured_words(two)) == "measured: 2 lines from 2 to 7 rad/s; coherence 0.5 to 0.75, 12 averages"


def test_an_environment_that_was_measured_too_doubles_the_chance_that_a_disc_misses() -> None:
    environment = hs.measured([1, 2, 3, 4], [100] * 4, radius=[1] * 4, name="wall")
    text = flat(judged([0, 30, 5, 0], environment, **disc(1, 4)))
    assert "environment wall: 4 lines from 1 to 4 rad/s; " in text
    assert "of 4 lines about 0.4 may be judged by a disc that does." in text
    assert "misses the truth with a chance of 5 %" in text
    assert "of 4 lines about 0.2 may be judged" in flat(judged([0, 30, 5, 0], **disc(1, 4)))
    bare = hs.measured([1, 2, 3, 4], [100] * 4, name="wall")
    assert "of 4 lines about 0.2 may be judged" in flat(judged([0, 30, 5, 0], bare, **disc(1, 4)))


@pytest.mark.parametrize(("cube", "what"), [(-5.0, "stays behind, as one that saturates"), (4.0, "grows beyond, as one that hardens or has play"), (0.5, None), (-2.5, None)])  # fmt: skip
def test_a_display_is_called_not_linear_where_chance_makes_that_of_it_once_in_a_hundred(
    cube: float, what: str | None
) -> None:
    x = np.random.default_rng(1).standard_normal(4000)
    estimated = hs.estimated(x, 100 * x, 200, segment=2)
    assert estimated.welch is not None
    told = linearity(replace(estimated.welch, cube=cube))
    text = said(told) if told else ""
    chance = erfc(abs(cube) / sqrt(2))
    assert (
        f"by {cube:.3g} standard errors; so many or more have a chance of {chance:.3g} if the display is linear"
        in text.replace("−", "-")
    )
    assert text.startswith("NOT LINEAR: it ") == (chance < 0.01)
    assert (what is not None) == (chance < 0.01)
    assert what is None or f"it {what}: " in text
    assert linearity(replace(estimated.welch, cube=None)) is None


def test_a_line_that_exceeds_stands_out_and_no_other_does() -> None:
    page = judged([0, 9, 30], **disc(2, 3)).document()
    [table] = [
        x
        for part in page.blocks
        if isinstance(part, Section) and part.name == "step-1"
        for x in part.blocks
        if isinstance(x, Table)
    ]
    strong = {said(cell) for line in table.rows for cell in line if isinstance(cell, Strong)}
    plain = {cell for line in table.rows for cell in line if isinstance(cell, str)}
    assert strong == {"exceeds"}
    assert {"below", "unresolved"} <= plain
