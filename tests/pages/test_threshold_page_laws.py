"""The page of a just-noticeable difference that was measured, of fits put together by hand, and that of published ones."""

from __future__ import annotations

import itertools
from dataclasses import replace
from math import erf, sqrt
from typing import Any

import pytest
from pagewords import flat, lines, row
from sympy import Rational

import haptisym as hs
from haptisym.model.published import Published, published_by_name
from haptisym.verbs.jnd.answers import Answers, Row
from haptisym.verbs.jnd.curve import Asked, Curve
from haptisym.verbs.jnd.entry import Psychometric
from haptisym.verbs.jnd.fit import Deviance, Estimate, Fit
from haptisym.verbs.jnd.published import PublishedThresholds
from haptisym.writing.document import Section

ROWS = tuple(Row(10.0 + n, n + 1, 12) for n in range(8))
FIT = Fit(
    Curve(13.25, 2.125), Estimate(13.25, 12.5, 14.125), Estimate(1.5, 1.25, 1.875), Deviance(4.56789, 6, 0.61234, 8)
)


def measured(
    fit: Fit = FIT, rows: tuple[Row, ...] = ROWS, earlier: str = "", notes: tuple[str, ...] = (), **own: Any
) -> Psychometric:
    given: dict[str, Any] = {"asked": Asked(0.75, None)} | own
    return Psychometric(Answers("answers.csv", rows, None, notes, earlier), fit=fit, **given)


def titles(found: Any) -> list[str]:
    return [str(x.title) for x in found.document().blocks if isinstance(x, Section)]


def test_the_jnd_is_told_with_its_interval_and_what_it_is_the_threshold_of() -> None:
    assert row(measured(), "JND").startswith(
        "1.5 (95 %: 1.25 to 1.875), where 75 % of the answers are “more”, beyond the"
    )
    assert "are “more”, beyond the point of subjective equality" in flat(measured())
    forced = measured(asked=Asked(0.8, 2), confidence=0.9)
    assert "1.5 (90 %: 1.25 to 1.875), where 80 % of the answers are right, of 2 alternatives" in flat(forced)
    assert "more”" not in flat(forced)
    assert lines(measured())[:2] == ["answers.csv", "Fitted by maximum likelihood."]
    assert lines(measured(method="psignifit"))[1] == "Fitted by psignifit 4."


@pytest.mark.parametrize(("low", "high"), [*itertools.product([1.25, None], [1.875, None])])
def test_an_interval_without_an_end_says_so_and_one_without_both_is_none(low: float | None, high: float | None) -> None:
    found = measured(replace(FIT, jnd=Estimate(1.5, low, high)))
    ends = ["unbounded" if x is None else f"{x:g}" for x in (low, high)]
    told = row(found, "JND")
    if low is high is None:
        assert told.startswith("1.5, where")
    else:
        assert told.startswith(f"1.5 (95 %: {ends[0]} to {ends[1]}), where")
    assert ("The interval has NO upper end: these answers do not tell how large the JND is at most" in flat(found)) == (
        high is None
    )


def test_a_fraction_stands_where_the_level_of_the_standard_is_known_and_the_line_for_a_scene_with_it() -> None:
    known = measured(reference=12.5)
    assert row(known, "fraction") == "0.12 (95 %: 0.1 to 0.15) of the standard, 12.5"
    assert "In a scene" in titles(known)
    assert "[evaluation.jnd]" in flat(known)
    for key in ("real", "imag", "proportion"):
        assert sum(x.startswith(f"`{key} = ") for x in lines(known)) == 1
    assert "--reference" not in flat(known)
    bare = measured()
    assert not [x for x in lines(bare) if x.startswith(("fraction", "[evaluation"))]
    assert "In a scene" not in titles(bare)
    assert row(bare, "in a scene").startswith(
        "a threshold is a fraction of the standard: give its level with `--reference`"
    )


@pytest.mark.parametrize(
    ("p", "told"),
    [
        (0.61234, "deviance 4.568, 6 degrees of freedom, p = 0.61: within chance"),
        (0.05, "deviance 4.568, 6 degrees of freedom, p = 0.05: within chance"),
        (0.0123, "deviance 4.568, 6 degrees of freedom, p = 0.012: NOT within chance"),
        (None, "cannot be tested: no more levels with enough answers than numbers that are fitted"),
    ],
)
def test_whether_the_curve_fits_is_told_and_where_it_does_not_it_is_said_what_that_means(
    p: float | None, told: str
) -> None:
    found = measured(replace(FIT, deviance=Deviance(4.56789, 6, p, 8)))
    assert row(found, "fit") == told
    assert flat(found).count(
        "The curve does NOT fit these answers: neither the JND nor its interval can be relied on."
    ) == (p == 0.0123)


@pytest.mark.parametrize(("guess", "lapse"), [(0.0, 0.0), (0.5, 0.0), (0.0, 0.02), (0.5, 0.02)])
def test_the_curve_is_written_with_guesses_and_lapses_where_there_are_any(guess: float, lapse: float) -> None:
    found = measured(replace(FIT, curve=Curve(13.25, 2.125, guess, lapse)), asked=Asked(0.75, 2 if guess else None))
    whole = [x for x in lines(found) if x.startswith("ψ(x) = ")]
    plain = not guess and not lapse
    assert whole == ["ψ(x) = Φ((x - μ)/σ)" if plain else "ψ(x) = γ + (1 - γ - λ) Φ((x - μ)/σ)"]
    middle = "middle of the curve" if guess else "point of subjective equality"
    assert row(found, "μ") == f"13.25 (95 %: 12.5 to 14.12), the {middle}"
    assert row(found, "σ") == "2.125"
    shown = [x for x in lines(found) if x.startswith(("γ ", "λ "))]
    assert shown == ([] if plain else [f"γ {guess:g}, guesses", f"λ {lapse:g}, lapses"])


def test_each_level_has_a_line_with_its_answers_and_what_the_curve_has_there() -> None:
    found = measured()
    for x in ROWS:
        curve = (1 + erf((x.level - 13.25) / 2.125 / sqrt(2))) / 2
        assert lines(found).count(f"{x.level:g} {x.count} {x.trials} {x.count / x.trials:.3f} {curve:.3f}") == 1
    assert "level k n share curve" in lines(found)
    for count in (40, 41):
        rows = tuple(Row(0.5 * n, min(n, 3), 4) for n in range(count))
        text = flat(measured(rows=rows))
        assert (f"{4 * count} answers at {count} levels, from 0 to {0.5 * (count - 1):g}." in text) == (count > 40)
        assert ("level k n share curve" in text) == (count <= 40)


def test_what_another_program_found_and_what_was_put_together_is_told() -> None:
    found = measured(earlier="threshold 3", notes=("Two blocks were put together.",))
    assert row(found, "in the file") == "threshold 3"
    assert flat(found).count("Two blocks were put together.") == 1
    assert not [x for x in lines(measured()) if x.startswith("in the file")]
    assert titles(found) == ["The curve", "The answers"]
    assert flat(found).endswith("if the curve is the right one.")


# Published ones


def one(
    name: str, low: object = "0.1", high: object = "0.1", *, criterion: Any = None, doi: str = "", apart: str = ""
) -> Published:
    return Published(
        name,
        "stiffness",
        Rational(str(low)),
        Rational(str(high)),
        criterion,
        "Fig. 3",
        f"source of {name}",
        doi,
        "in full",
        apart,
    )


def test_published_thresholds_are_told_with_criterion_and_source_where_these_are_known() -> None:
    found = PublishedThresholds([
        one("a", "0.08", "0.12", doi="10.1/x"), one("b", criterion=Rational(3, 4), apart="it is of pitch"), one("c", "0.225", "0.225", criterion=Rational(4, 5)),
    ])  # fmt: skip
    shown, text = lines(found), flat(found)
    for line in ("`a` 8 to 12 % stiffness", "`b` 10 % 75 % stiffness", "`c` 22.5 % 80 % stiffness"):
        assert shown.count(line) == 1, line
    assert "`a`: source of a, doi:10.1/x [in full]; Fig. 3." in text
    assert "`b`: source of b [in full]; Fig. 3. Not for a scene: it is of pitch." in text
    assert "`c`: source of c [in full]; Fig. 3." in text
    assert text.count("Not for a scene") == text.count("doi:") == 1
    assert '`jnd = { like = "b" }`' in text  # the first whose criterion is known
    assert text.count("`jnd = {") == 1


def test_all_that_are_shipped_have_a_line() -> None:
    shown = lines(hs.published())
    for name, x in published_by_name().items():
        assert len([y for y in shown if y.startswith(f"`{name}` ") or y == f"`{name}`"]) == 1, name
        assert x.written in flat(hs.published())
