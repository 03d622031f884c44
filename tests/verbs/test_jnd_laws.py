"""Psychometric functions against mpmath and plain counting: the likelihood, what is put together, columns and words of tables."""

from __future__ import annotations

import json
from collections import defaultdict
from dataclasses import replace
from decimal import ROUND_CEILING, ROUND_FLOOR, Decimal
from pathlib import Path
from statistics import NormalDist
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mpmath import mp, mpf
from refusals import refusal
from scipy.optimize import minimize_scalar
from scipy.stats import chi2

import haptisym as hs
from haptisym.verbs.jnd.answers import MOST_LEVELS, Answers, Row, collected, condensed
from haptisym.verbs.jnd.columns import ALIASES, TOLD, find_columns
from haptisym.verbs.jnd.curve import Asked, Curve
from haptisym.verbs.jnd.entry import Psychometric
from haptisym.verbs.jnd.fit import LEAST_TRIALS, Deviance, Estimate, Fit
from haptisym.verbs.jnd.fitting import deviance
from haptisym.verbs.jnd.likelihood import Likelihood, crossing
from haptisym.verbs.jnd.tables import read_answers
from haptisym.verbs.simulate.threads import one_thread

BLOCKS = st.lists(
    st.tuples(st.integers(-4, 12).map(lambda n: n / 4), st.integers(0, 9), st.integers(0, 9)), min_size=2, max_size=12
)


def blocks(drawn: list[tuple[float, int, int]]) -> list[tuple[float, int, int]]:
    return [(level, k, k + more) for level, k, more in drawn]


# Counting.


@given(BLOCKS)
def test_blocks_of_a_level_are_added_and_a_level_without_answers_is_none(drawn: list[tuple[float, int, int]]) -> None:
    sums: dict[float, list[int]] = defaultdict(lambda: [0, 0])
    for level, k, n in blocks(drawn):
        sums[level][0] += k
        sums[level][1] += n
    expected = tuple(Row(x, *sums[x]) for x in sorted(sums) if sums[x][1])
    assert collected(blocks(drawn)) == expected
    assert all(x.share == x.count / x.trials for x in expected)
    assert "2 of 1 answers cannot be" in refusal(collected, [(1.0, 2, 1)])
    assert "-1 of 1 answers cannot be" in refusal(collected, [(1.0, -1, 1)])
    assert "is not a finite number" in refusal(collected, [(float("inf"), 1, 1)])
    assert collected([(1.0, 1, 1), (1.0, 0, 1), (0.0, 0, 0)]) == (Row(1.0, 1, 2),)


@pytest.mark.parametrize(("rows", "told"), [
    ((), "there are no answers; a curve needs at least two levels"), ((Row(5.5, 1, 2),), "all answers are at one level, 5.5; a curve needs"),
    ((Row(1, 0, 2), Row(2, 0, 3)), "no answer counts (k = 0 of n = 5 in all)"), ((Row(1, 2, 2), Row(2, 3, 3)), "every answer counts (k = 5 of n = 5 in all)"),
    ((Row(1, 0, 2), Row(2, 3, 3)), ""),
])  # fmt: skip
def test_answers_of_one_kind_or_at_one_level_are_none(rows: tuple[Row, ...], told: str) -> None:
    said = refusal(Answers, "x", rows)
    assert told in said
    assert bool(told) == bool(said)


def test_more_than_a_thousand_levels_are_put_into_groups_of_neighbours_at_their_means() -> None:
    rng = np.random.default_rng(4)
    rows = tuple(
        Row(float(i), int(k), int(k + m)) for i, (k, m) in enumerate(rng.integers(1, 9, (MOST_LEVELS + 400, 2)))
    )
    few = Answers("x", rows[:MOST_LEVELS])
    assert condensed(few) is few
    found = condensed(Answers("x", rows, notes=("first",)))
    each = -(-sum(x.trials for x in rows) // MOST_LEVELS)
    at = 0
    for i, group in enumerate(found.rows):
        own: list[Row] = []
        while at < len(rows) and sum(x.trials for x in own) < each:
            own.append(rows[at])
            at += 1
        trials = sum(x.trials for x in own)
        assert (group.count, group.trials) == (sum(x.count for x in own), trials)
        assert group.level == pytest.approx(sum(x.level * x.trials for x in own) / trials, rel=1e-14)
        assert trials >= each or i == len(found.rows) - 1
    assert at == len(rows)
    assert found.notes == (
        "first",
        f"{MOST_LEVELS + 400} levels put into {len(found.rows)} groups of neighbours, each at its mean",
    )
    assert condensed(Answers("x", rows[: MOST_LEVELS + 1])).rows != rows[: MOST_LEVELS + 1]


# The likelihood.


def by_mpmath(rows: tuple[Row, ...], mu: Any, spread: Any, guess: Any, lapse: Any) -> Any:
    total = mpf(0)
    for x in rows:
        p = guess + (1 - guess - lapse) * mp.ncdf((mpf(x.level) - mu) / mp.exp(spread))
        total -= (x.count * mp.log(p) if x.count else 0) + (
            (x.trials - x.count) * mp.log(1 - p) if x.trials > x.count else 0
        )
    return total


@given(
    BLOCKS, st.integers(-8, 8), st.integers(-8, 8), st.sampled_from([0.0, 0.1, 0.5]), st.sampled_from([0.0, 0.02, 0.3])
)
def test_the_likelihood_and_its_slopes_are_those_of_many_digits(
    drawn: list[tuple[float, int, int]], a: int, b: int, guess: float, lapse: float
) -> None:
    rows, mu, spread = collected(blocks(drawn)), 1 + a / 3, b / 5
    if not rows:
        return
    with mp.workdps(400):  # of 1 - p, a p next to 1 takes most
        point = tuple(map(mpf, (mu, spread, lapse)))

        def f(m: Any, s: Any, lapses: Any) -> Any:
            return by_mpmath(rows, m, s, mpf(guess), lapses)

        loss, (by_mu, by_spread, by_lapse) = Likelihood(rows, guess, None).loss(mu, spread, lapse)
        assert loss == pytest.approx(float(f(*point)), rel=1e-11, abs=1e-12)
        exact = [float(mp.diff(f, point, order)) for order in ((1, 0, 0), (0, 1, 0))]
        assert [-by_mu, -by_spread] == pytest.approx([-x for x in exact], rel=1e-8, abs=1e-9)
        if lapse:
            assert by_lapse == pytest.approx(float(mp.diff(f, point, (0, 0, 1))), rel=1e-8, abs=1e-9)
        curve = Curve(mu, float(mp.exp(spread)), guess, lapse)
        kept = sum((x.count * mp.log(mpf(x.count) / x.trials) if x.count else 0)
                   + ((x.trials - x.count) * mp.log(1 - mpf(x.count) / x.trials) if x.trials > x.count else 0) for x in rows)  # fmt: skip
        assert Likelihood(rows, guess, lapse).deviance(curve) == pytest.approx(
            float(2 * (kept + f(*point))), rel=1e-9, abs=1e-9
        )
        assert float(curve(np.array([0.3]))[0]) == pytest.approx(
            float(guess + (1 - guess - lapse) * mp.ncdf((mpf("0.3") - mu) / mp.exp(spread))), rel=1e-12
        )
    assert [Likelihood(rows, guess, x).free for x in (None, 0.0)] == [3, 2]


@given(BLOCKS)
def test_the_fit_is_tested_by_groups_of_at_least_five_answers(drawn: list[tuple[float, int, int]]) -> None:
    rows = collected(blocks(drawn))
    if not rows:
        return
    groups: list[list[Row]] = []
    for x in rows:
        if groups and sum(y.trials for y in groups[-1]) < LEAST_TRIALS:
            groups[-1].append(x)
        else:
            groups.append([x])
    if len(groups) > 1 and sum(y.trials for y in groups[-1]) < LEAST_TRIALS:
        last = groups.pop()
        groups[-1] += last
    sums = [
        (
            sum(y.level * y.trials for y in g) / sum(y.trials for y in g),
            sum(y.count for y in g),
            sum(y.trials for y in g),
        )
        for g in groups
    ]
    curve, free = Curve(1.0, 0.8, 0.1, 0.05), 2
    found = deviance(rows, curve, free)
    total = 0.0
    for level, k, n in sums:
        p = float(curve(np.array([level]))[0])
        total += 2 * ((k * np.log(k / n / p) if k else 0) + ((n - k) * np.log((1 - k / n) / (1 - p)) if n > k else 0))
    assert (found.groups, found.degrees) == (len(groups), len(groups) - free)
    assert found.value == pytest.approx(total, rel=1e-9, abs=1e-9)
    assert (found.p is None) == (len(groups) <= free)
    if found.p is not None:
        assert found.p == pytest.approx(chi2(len(groups) - free).sf(total), rel=1e-7)
        assert found.fits is (found.p >= 0.05)
    assert Deviance(1.0, 1, 0.05, 2).fits
    assert Deviance(1.0, 1, 0.0499, 2).fits is False


ROWS = (Row(0.02, 21, 40), Row(0.06, 23, 40), Row(0.1, 28, 40), Row(0.14, 35, 40), Row(0.18, 36, 40), Row(0.24, 39, 40))


def test_counting_the_other_answers_on_levels_the_other_way_round_is_the_mirrored_curve() -> None:
    """Of levels that are too high mu is as far below them as above those of the mirror; so is what is held."""
    way = 5.0
    for counts in ((26, 30, 33, 35), (2, 5, 7, 13)):
        rows = tuple(Row(1.0 + x, k, 40) for x, k in zip((0.0, 0.2, 0.5, 0.7), counts, strict=True))
        turned = tuple(Row(way - x.level, x.trials - x.count, x.trials) for x in reversed(rows))
        one, other = Likelihood(rows, 0.01, 0.02), Likelihood(turned, 0.02, 0.01)
        best, mirrored = one.best(), other.best()
        assert best.loss == pytest.approx(mirrored.loss, rel=1e-9)
        assert [way - mirrored.curve.mu, mirrored.curve.sigma] == pytest.approx(
            [best.curve.mu, best.curve.sigma], rel=1e-5
        )
        assert (
            (best.steep, best.flat, best.outside) == (mirrored.steep, mirrored.flat, mirrored.outside) == (False,) * 3
        )
        for value in (0.6, 1.4, 1.9):
            held = one.best((1, 0.5, value), best.curve)
            same = other.best((1, -0.5, way - value), mirrored.curve)
            assert held.loss == pytest.approx(same.loss, rel=1e-9)
            assert held.curve.mu + 0.5 * held.curve.sigma == pytest.approx(value, rel=1e-9)
            assert held.loss >= best.loss - 1e-9


def test_a_loss_without_a_slope_is_a_wall() -> None:
    """One answer that the curve rules out, or all but: the logarithm of what is next to nothing, or of nothing."""
    for mu, rows in ((1e200, (Row(1.0, 3, 4),)), (-40.0, (Row(1.0, 3, 4),))):
        loss, slopes = Likelihood(rows, 0.0, None).loss(mu, 0.0, 0.0)
        assert (loss, slopes.tolist()) == (1e300, [0, 0, 0])


def test_a_file_that_cannot_be_opened_is_told_with_the_reason() -> None:
    assert refusal(read_answers, Path("a\0b.csv"), {}, {}) == "a\0b.csv: embedded null byte"
    assert refusal(read_answers, Path("x" * 300 + ".csv"), {}, {}).endswith(".csv: File name too long")


def test_the_interval_of_a_forced_choice_ends_where_its_profile_has_fallen_by_half_of_chi_squared() -> None:
    found = hs.jnd(Answers("choices", ROWS), alternatives=2, proportion=0.8, lapse=0.02, confidence=0.9)
    z = NormalDist().inv_cdf((0.8 - 0.5) / 0.5)
    own = Likelihood(ROWS, 0.5, 0.02)
    curve = found.fit.curve
    best = own.loss(curve.mu, float(np.log(curve.sigma)), 0.02)[0]
    assert (curve.guess, curve.lapse, found.jnd.value) == (
        0.5,
        0.02,
        pytest.approx(curve.mu + z * curve.sigma, rel=1e-12),
    )
    assert found.middle.value == curve.mu
    for value, weight in ((found.jnd, z), (found.middle, 0.0)):
        for end in (value.low, value.high):
            assert end is not None
            profile = minimize_scalar(
                lambda t, e=end, w=weight: own.loss(e - w * np.exp(t), t, 0.02)[0],
                bounds=(-8, 3),
                method="bounded",
                options={"xatol": 1e-9},
            )
            assert 2 * (profile.fun - best) == pytest.approx(chi2(1).ppf(0.9), abs=1e-5)
    assert found.to_dict()["curve"] == {"mu": curve.mu, "sigma": curve.sigma, "guess": 0.5, "lapse": 0.02}
    assert (found.line, found.fraction, found.to_dict()["line"]) == ("", None, None)


def test_a_comparison_with_guesses_has_its_jnd_at_its_share_of_the_curve_without_them() -> None:
    rows = tuple(Row(x, k, 40) for x, k in ((4.0, 4), (4.5, 9), (5.0, 22), (5.5, 30), (6.0, 35)))
    found = hs.jnd(Answers("compared", rows), guess=0.05, lapse=0.05, reference=5, proportion=0.8)
    curve = found.fit.curve
    z = NormalDist().inv_cdf(0.8)
    assert found.jnd.value == pytest.approx(z * curve.sigma, rel=1e-12)
    assert found.fraction == found.jnd.scaled(0.2)
    assert found.fraction is not None
    ends = [Decimal(x).normalize() for x in (found.fraction.low, found.fraction.value, found.fraction.high)]  # type: ignore[arg-type]
    digits = [
        f"{x.quantize(Decimal(1).scaleb(x.adjusted() - 3), way)}"
        for x, way in zip(ends, (ROUND_FLOOR, "ROUND_HALF_EVEN", ROUND_CEILING), strict=True)
    ]
    own = f"[{', '.join(digits)}]"
    assert found.table == {"real": own, "imag": own, "proportion": "0.8"}
    assert found.line == f"jnd = {{ real = {own}, imag = {own}, proportion = 0.8 }}"
    assert repr(found) == f"<Psychometric compared: fraction {found.fraction.value:.4g} at 0.8>"
    assert repr(replace(found, reference=None)).startswith("<Psychometric compared: JND ")
    told = found.to_dict()
    assert told["data"] == [{"level": x.level, "k": x.count, "n": x.trials} for x in rows]
    assert (told["reference"], told["confidence"], told["method"], told["proportion"]) == (
        5,
        0.95,
        "maximum likelihood",
        0.8,
    )
    assert told["jnd"] == {"value": found.jnd.value, "interval": [found.jnd.low, found.jnd.high]}
    assert (told["certified"], told["notes"], told["alternatives"]) == (False, [], None)
    with one_thread():
        free = Likelihood(rows, 0.0, None).best()
    for mu, sigma, lapse in ((0.05, 0, 0), (0, 0.05, 0), (0, 0, 0.01)):
        other = Likelihood(rows, 0.0, None).loss(
            free.curve.mu + mu, float(np.log(free.curve.sigma + sigma)), min(free.curve.lapse + lapse, 0.1)
        )[0]
        assert other >= free.loss - 1e-9
    assert (free.steep, free.flat, free.outside) == (False, False, False)


def test_a_number_without_an_end_has_a_line_without_a_range() -> None:
    assert Estimate(2.0, None, 3.0).scaled(0.5) == Estimate(1.0, None, 1.5)
    answers = Answers("few", (Row(1.0, 1, 3), Row(2.0, 2, 3)))
    for low, high, written in (
        (None, 9.0, "0.1235"),
        (2.0, None, "0.1235"),
        (-2.0, 9.0, "0.1235"),
        (0.0, 9.0, "0.1235"),
        (1.00004, 1.98765, "[0.1000, 0.1235, 0.1988]"),
    ):
        fit = Fit(Curve(1.5, 1), Estimate(1.5, None, None), Estimate(1.23456, low, high), Deviance(0.0, 0, None, 2))
        assert Psychometric(answers, Asked(0.75, 2), fit, reference=10).table == {"real": written, "imag": written}


def test_where_a_function_becomes_positive_is_found_within_so_many_steps() -> None:
    for root in (0.3, 2.0, 50.0, 820.0):
        for sign in (-1, 1):
            found = crossing(lambda x, r=root, s=sign: s * x - r, 0.0, sign * 0.1, 1e4)
            assert found == pytest.approx(sign * root, rel=1e-11)
    assert crossing(lambda x: x - 840, 0.0, 0.1, 1e4) is None  # steps grow by 1.7 up to 8272 of them
    assert crossing(lambda x: -1.0, 0.0, 0.1, 1e4) is None


@pytest.mark.parametrize(
    ("rows", "told"),
    [
        (((5, 9, 10), (6, 5, 10), (7, 1, 10)), "counts fall as levels rise; count the other answers"),
        (((5, 5, 10), (6, 5, 10), (7, 5, 10)), "the levels do not reach it"),
        (
            ((5, 0, 10), (6, 0, 10), (7, 10, 10), (8, 10, 10)),
            "jump from one kind to the other between 6 and 7: how steeply is not determined",
        ),
    ],
)
def test_answers_that_determine_no_curve_are_told_why(rows: tuple[tuple[int, int, int], ...], told: str) -> None:
    said = refusal(hs.jnd, Answers("x", tuple(Row(float(a), b, c) for a, b, c in rows)))
    assert told in said
    assert bool(told) == bool(said)


def test_a_jnd_of_a_forced_choice_is_above_zero() -> None:
    rows = tuple(Row(float(x), k, 40) for x, k in zip(range(-8, -2), (20, 22, 28, 33, 38, 40), strict=True))
    assert "x: the JND would be -" in refusal(hs.jnd, Answers("x", rows), alternatives=2)


# What is asked.


@pytest.mark.parametrize(
    ("proportion", "alternatives", "value"),
    [(None, None, (0, 0.75)), (0.84, None, (0, 0.84)), (None, 2, (1, 0.5)), (None, 4, (1, 0.5)), (0.9, 2, (1, 0.8)), (0.5, 4, (1, 1 / 3)), (0.51, None, (0, 0.51))],
)  # fmt: skip
def test_the_jnd_is_a_mu_plus_z_sigma(
    proportion: float | None, alternatives: int | None, value: tuple[int, float]
) -> None:
    asked = Asked.of(proportion, alternatives)
    assert asked.weights == (value[0], pytest.approx(NormalDist().inv_cdf(value[1]), abs=1e-12))
    assert asked.chance == (0.5 if alternatives is None else 1 / alternatives)


@pytest.mark.parametrize(
    ("keys", "told"),
    [
        ({"proportion": 1.0}, "must lie between chance, 0.5 of a comparison, and 1"), ({"proportion": 0.25, "alternatives": 4}, "chance, 0.25 of 4 alternatives"),
        ({"alternatives": 1}, "at least 2 alternatives, not 1"), ({"guess": 0.5}, "guess: 0.5 must lie from 0 to below 0.5"), ({"lapse": 0.5}, "lapse: 0.5 must lie"),
        ({"guess": -0.01}, "guess: -0.01 must"), ({"reference": -1.0}, "reference: -1 must be a level above 0"),
        ({"reference": float("inf")}, "reference: inf must"), ({"confidence": 0.0}, "confidence: 0 must lie between 0 and 1"), ({"confidence": 1}, "confidence: 1 must"),
        ({"method": "psignifit", "guess": 0.1}, "psignifit fits guesses and lapses itself"), ({"method": "other"}, 'method: "other": valid are likelihood, psignifit'),
        ({"alternatives": 2, "guess": 0.1}, "guess: a forced choice has its own"),
    ],
)  # fmt: skip
def test_what_may_be_asked_has_its_limits(keys: dict[str, Any], told: str) -> None:
    said = refusal(hs.jnd, Answers("x", (Row(1.0, 10, 40), Row(2.0, 30, 40))), **keys)
    assert told in said
    assert bool(told) == bool(said)


# Tables.


@pytest.mark.parametrize("key", ALIASES)
def test_each_name_that_a_column_may_have_is_known_however_it_is_written(key: str) -> None:
    for alias in ALIASES[key]:
        for name in (alias, alias.upper(), f"trials.{alias}", f"{alias[:1]}_{alias[1:]}", f" {alias} (2)"):
            rest = {"level": "zz", "count": "zz", "trials": "zz", "answer": "zz"}
            others = {"level": ["k", "n"], "count": ["x", "n"], "trials": ["x", "k"], "answer": ["x"]}[key]
            if name.strip().lower().partition(" ")[0] in others:
                continue
            found = find_columns(["zz", name, *others], {})
            assert {"level": found.level, "count": found.count, "trials": found.trials, "answer": found.answer}[
                key
            ] == 1, (name, rest)


@pytest.mark.parametrize(
    ("header", "named", "told"),
    [
        (["x", "k", "n"], {}, (0, 1, 2, None)), (["x", "k", "n", "response"], {}, (0, 1, 2, None)), (["x", "k", "n", "response"], {"answer": "response"}, (0, None, None, 3)),
        (["x", "k", "response"], {}, (0, None, None, 2)), (["x", "n", "correct"], {}, (0, 2, 1, None)), (["x", "correct"], {}, (0, None, None, 1)),
        (["f", "k", "n"], {"level": "f"}, (0, 1, 2, None)), (["x", "y"], {"level": "y"}, "how many answers counted (k) of how many (n), nor one answer a line"),
        (["f", "k", "n"], {}, "no column holds the levels: there are f, k, n; name it with --level COLUMN"), ([], {}, "there are none"),
        (["x", "k"], {}, "name it with --count and --trials, or --answer, COLUMN"), (["x", "a.corr", "b.corr"], {}, 'answer: it may be column "a.corr" or "b.corr"'),
        (["x", "k", "n"], {"level": "X"}, 'level: no column "X": there are x, k, n'), (["levle", "k", "n"], {"level": "level"}, 'did you mean "levle"?'),
        ([f"c{i}" for i in range(12)], {}, "c10, c11; name"), ([f"c{i}" for i in range(13)], {}, "c10, c11, ...; name"),
        (["q" * 50, "", "k"], {}, f"there are {'q' * 40}, k;"),
    ],
)  # fmt: skip
def test_columns_are_found_by_their_names_or_it_is_said_which_there_are(
    header: list[str], named: dict[str, str], told: Any
) -> None:
    if isinstance(told, str):
        assert told in refusal(find_columns, header, named)
        return
    found = find_columns(header, named)
    assert (found.level, found.count, found.trials, found.answer) == told
    assert found.used == tuple(x for x in told if x is not None)


def read(path: Path, text: str, **keys: Any) -> Any:
    path.write_text(text, encoding="utf-8")
    try:
        return read_answers(path, keys.get("named", {}), keys.get("where", {}))
    except hs.SceneError as error:
        return str(error)


def test_lines_of_a_table_are_counted_left_out_and_chosen_as_they_say(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    pair = "1,1,2\n2,3,4\n"
    for text, rows in (
        ("x,k,n\n" + pair, [(1, 1, 2), (2, 3, 4)]), ("x;k;n\n1,5;1;2\n2;3;4\n", [(1.5, 1, 2), (2, 3, 4)]), ("x\tk\tn\n1,5\t1\t2\n2\t3\t4\n", [(1.5, 1, 2), (2, 3, 4)]),
        ("x,k,n,note\n1,1,2\n2,3,4,late\n", [(1, 1, 2), (2, 3, 4)]), ("x,k,n\n1,1,2\n1,1,2\n\n2,3.0,4e0\n", [(1, 2, 4), (2, 3, 4)]),
        ("x,response\n1,yes\n1, NO \n2,True\n2,0.0\n2,1\n", [(1, 1, 2), (2, 2, 3)]), ("x,k,n\n1,1,2\n2,3,4\n ,5,6\n", [(1, 1, 2), (2, 3, 4)]),
        ("\n\nx,k,n\n" + pair, [(1, 1, 2), (2, 3, 4)]), ('x,k,n\n"1",1,2\n2,3,4\n', [(1, 1, 2), (2, 3, 4)]),
        ('[[1, 1, 2], [2, 3, 4.0]]', [(1, 1, 2), (2, 3, 4)]), ('{"data": [[1, 1, 2], [2, 3, 4]]}', [(1, 1, 2), (2, 3, 4)]),
    ):  # fmt: skip
        assert [(x.level, x.count, x.trials) for x in read(path, text).rows] == rows, text
    assert read(path, "x,k,n\n" + pair + "3,,5\n").notes == ("1 line without a level or an answer left out",)
    assert read(path, "x,k,n\n" + pair + ",,\n").notes == ()
    assert read(path, "x,k,n\n" + pair + "3,1\n4\n\n,\n").notes == ("2 lines without a level or an answer left out",)
    for told in TOLD:
        text = f"{told},x,k,n\n" + "".join(f"{who},{row}\n" for who in ("a", "b", "a") for row in pair.split())
        assert read(path, text).notes == (f"2 values of {told} put together; choose with --where {told}=...",)
        assert read(path, text, where={told: "b"}).notes == ()
        assert [x.trials for x in read(path, text, where={told: "a"}).rows] == [4, 8]
    text = "hand,who,x,k,n\nl,a,1,1,2\nl,a,2,3,4\nr,a,1,0,2\nr,b,2,1,4\n"
    assert [x.count for x in read(path, text, where={"hand": "l", "who": "a"}).rows] == [1, 3]
    for bad, words in (
        (("x,k,n\n" + pair, {"where": {"x": "7"}}), "a.csv: no line has x = 7"), ((text, {"where": {"hand": "r", "who": "c"}}), "no line has hand = r and who = c"),
        (("x,k,n\n1,3,2\n2,1,2\n", {}), "line 2: k = 3 is more than n = 2"), (("x,k,n\n1,1,2\n2,1,1.5\n", {}), 'line 3: n: "1.5" is no count of answers'),
        (("x,k,n\n1,-1,2\n2,1,2\n", {}), 'k: "-1" is no count'), (("x,k,n\n1,1,1e13\n2,1,2\n", {}), 'n: "1e13" is no count'),
        (("x,response\n1,\n,1\n", {}), "no line has both a level and an answer"), (("x,response\n1,maybe\n2,1\n", {}), 'line 2: answer: "maybe" must be 1 or 0'),
        (("1,2,3\n4,5,6\n", {}), "the first line holds numbers: it must name the columns"), (("x,k,n\n1;5,1,2\n2,1,2\n", {}), 'level: "1;5" is not a number'),
        (("x,k,n\n1e999,1,2\n2,1,2\n", {}), 'level: "1e999" is not a finite number'), (('{"data": [[1, 1, 2]]}', {"named": {"level": "x"}}), "a document of JSON, which has no columns"),
        (('{"data": [[1, 1, 2]]}', {"where": {"x": "1"}}), "which has no columns"), (('{"data": [[1, 1]]}', {}), "no result of psignifit 4"), (('{"dat": []}', {}), "no result of psignifit"),
        (('{"data": [[1, true, 2], [2, 1, 2]]}', {}), "must be three numbers, level, k and n"), (('[[1, 0.5, 2], [2, 1, 2]]', {}), "k and n must be whole numbers, and k at most n"),
        (('[[1, -1, 2], [2, 1, 2]]', {}), "k and n must be whole"), (('[[1, 1, 2.5], [2, 1, 2]]', {}), "k and n must be whole"), (('[[NaN, 1, 2], [2, 1, 2]]', {}), "must be three numbers"),
    ):  # fmt: skip
        assert words in read(path, bad[0], **bad[1]), bad


def test_what_psignifit_was_told_and_found_is_kept_where_it_is_a_forced_choice_of_a_gaussian(tmp_path: Path) -> None:
    data = [[1, 1, 4], [2, 3, 4]]
    told, map_ = (
        {"experiment_type": "nAFC", "experiment_choices": 3, "sigmoid": "norm"},
        {"threshold": 1.5, "width": 0.25},
    )
    words = "psignifit found threshold 1.5 and width 0.25"
    for settings, found, alternatives, earlier in (
        (told, map_, 3, words), (told | {"experiment_type": "yes/no"}, map_, None, words), (told | {"experiment_choices": 1}, map_, None, words),
        (told | {"experiment_choices": "3"}, map_, None, words), (told | {"sigmoid": "logistic"}, map_, 3, ""), (told, {"threshold": 1.5}, 3, ""),
        (told, {"threshold": 1.5, "width": float("inf")}, 3, ""), (told, None, 3, ""), (None, map_, None, ""),
    ):  # fmt: skip
        read_ = read(
            tmp_path / "p.json", json.dumps({"data": data, "configuration": settings, "parameter_estimate_MAP": found})
        )
        assert (read_.alternatives, read_.earlier, read_.name) == (alternatives, earlier, "p.json")


def test_published_thresholds_are_listed_as_their_table_says() -> None:
    told = hs.published().to_dict()
    assert repr(hs.published()) == f"<PublishedThresholds {len(hs.published())} published thresholds>"
    assert told["certified"] is False
    for row, x in zip(told["thresholds"], hs.published(), strict=True):
        assert row == {
            "name": x.name, "quantity": x.quantity, "fraction": [float(x.low), float(x.high)], "criterion": x.criterion and float(x.criterion),
            "reference": x.reference, "source": x.source, "doi": x.doi or None, "read": x.read, "usable": not x.apart,
        }  # fmt: skip
        low, high = f"{float(100 * x.low):.4g}", f"{float(100 * x.high):.4g}"
        assert x.written == (f"{low} %" if x.low == x.high else f"{low} to {high} %")
        assert x.given == (x.low if x.low == x.high else (x.low, x.high))
        assert x.low <= x.high
        said = refusal(hs.Threshold.like, x.name)
        assert said == (f'like: "{x.name}" is no threshold for a scene: {x.apart}' if x.apart else "")
