"""A JND from answers: the curve against mpmath, its interval, tables as programs write them, and what cannot be fitted."""

from __future__ import annotations

import json
import os
from collections import defaultdict
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from statistics import NormalDist
from typing import Any

import mpmath as mp
import numpy as np
import pytest
from click.testing import CliRunner
from fits import CHI_95, best_probit, likelihood
from hypothesis import given
from hypothesis import strategies as st
from marks import required
from refusals import refusal
from scipy.io import savemat
from scipy.optimize import minimize, minimize_scalar
from scipy.special import log_ndtr, ndtr
from scipy.stats import chi2, norm

import haptisym as hs
from haptisym.cli import app
from haptisym.programs.values import Array
from haptisym.verbs.jnd.entry import (
    CurveFit,
    Deviance,
    IntervalEstimate,
    Likelihood,
    Psychometric,
    PsychometricCurve,
    WantedJnd,
)
from haptisym.verbs.jnd.tables import TOLD, Answers, Coding, LevelAnswers, collected, find_columns, read_answers

LEVELS, COUNTS, TRIALS = (4.4, 4.7, 5.0, 5.3, 5.6, 5.9), (5, 11, 19, 26, 33, 37), 40


TABLE = "level,k,n\n" + "".join(f"{x},{k},{TRIALS}\n" for x, k in zip(LEVELS, COUNTS, strict=True))


ROWS = tuple(LevelAnswers(x, k, TRIALS) for x, k in zip(LEVELS, COUNTS, strict=True))


DATA = Answers("answers", ROWS)


@pytest.fixture
def file(tmp_path: Path) -> Callable[..., Path]:
    def written(text: str | bytes, name: str = "answers.csv") -> Path:
        path = tmp_path / name
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return path

    return written


# The curve, against mpmath with 40 digits.


def loss(mu: mp.mpf, sigma: mp.mpf) -> mp.mpf:
    """Minus the log-likelihood of the table, by another way."""
    total = mp.mpf(0)
    for x, k in zip(LEVELS, COUNTS, strict=True):
        p = mp.erfc((mu - mp.mpf(str(x))) / (sigma * mp.sqrt(2))) / 2
        total -= k * mp.log(p) + (TRIALS - k) * mp.log(1 - p)
    return total


@pytest.mark.slow
def test_the_curve_is_the_most_likely_one_to_twelve_digits() -> None:
    with mp.workdps(40):
        mu, sigma = mp.findroot(
            lambda m, s: (mp.diff(loss, (m, s), (1, 0)), mp.diff(loss, (m, s), (0, 1))), (5.05, 0.58)
        )
        jnd = sigma * mp.sqrt(2) * mp.erfinv(mp.mpf(1) / 2)
    found = hs.jnd(DATA)
    assert abs(found.fit.curve.mu - mu) < 1e-12
    assert abs(found.fit.curve.sigma - sigma) < 1e-12
    assert abs(found.jnd.value - jnd) < 1e-12
    assert found.jnd.value == pytest.approx(0.39459214346893773, abs=1e-8)  # as published elsewhere, by a minimiser


@pytest.mark.slow
def test_the_ends_of_the_interval_are_where_the_profile_of_the_likelihood_has_fallen_by_half_of_chi_squared() -> None:
    found = hs.jnd(DATA, confidence=0.95)
    with mp.workdps(30):
        best, quantile = loss(mp.mpf(found.fit.curve.mu), mp.mpf(found.fit.curve.sigma)), mp.mpf("3.841458820694124")
        for end in (found.jnd.low, found.jnd.high):
            sigma = mp.mpf(end) / (mp.sqrt(2) * mp.erfinv(mp.mpf(1) / 2))
            mu = mp.findroot(lambda m, s=sigma: mp.diff(lambda x: loss(x, s), m), 5.05)
            assert abs(2 * (loss(mu, sigma) - best) - quantile) < 1e-8
        for end in (found.middle.low, found.middle.high):
            sigma = mp.findroot(lambda s, m=end: mp.diff(lambda x: loss(mp.mpf(m), x), s), 0.6)
            assert abs(2 * (loss(mp.mpf(end), sigma) - best) - quantile) < 1e-8


@pytest.mark.slow
def test_the_interval_reaches_to_curves_whose_middle_is_far_away() -> None:
    told = [(1.02, 11, 14), (1.23, 14, 22), (1.85, 26, 28)]
    found = hs.jnd(Answers("flat", tuple(LevelAnswers(*x) for x in told)))
    top = likelihood(told, *best_probit(told))
    for end in (found.jnd.low, found.jnd.high):
        assert end is not None
        slope = mp.mpf(NormalDist().inv_cdf(0.75)) / end
        assert abs(2 * (top - likelihood(told, *best_probit(told, slope))) - CHI_95) < 1e-6


@pytest.mark.slow
def test_another_proportion_is_the_same_sigma() -> None:
    at_71, at_84 = (hs.jnd(DATA, proportion=p).jnd.value for p in (0.71, 0.84))
    assert at_84 / at_71 == pytest.approx(1.79704616, abs=1e-8)
    assert 19 * at_84 / at_71 == pytest.approx(34.14387697, abs=1e-7)


@pytest.mark.slow
@pytest.mark.few(1)
@pytest.mark.parametrize("alternatives", [2, 3, 4])
def test_a_forced_choice_has_its_threshold_at_the_proportion_asked_for(alternatives: int) -> None:
    curve = PsychometricCurve(0.12, 0.05, 1 / alternatives)
    level = np.array([0.02, 0.06, 0.1, 0.14, 0.18, 0.24])
    rows = tuple(LevelAnswers(float(x), round(p * 10**7), 10**7) for x, p in zip(level, curve(level), strict=True))
    found = hs.jnd(Answers("choices", rows), alternatives=alternatives, reference=1)
    assert found.asked.proportion == (1 + 1 / alternatives) / 2
    assert found.fraction is not None
    assert found.fraction.value == pytest.approx(0.12, abs=1e-5)
    higher = hs.jnd(Answers("choices", rows), alternatives=alternatives, proportion=0.9)
    assert float(curve(np.array([higher.jnd.value]))[0]) == pytest.approx(0.9, abs=1e-4)


@pytest.mark.slow
def test_lapses_that_are_there_are_found_where_they_may_be() -> None:
    curve = PsychometricCurve(5.0, 0.3, 0.0, 0.05)
    level = np.linspace(4, 6.5, 9)
    rows = tuple(LevelAnswers(float(x), round(p * 10**6), 10**6) for x, p in zip(level, curve(level), strict=True))
    free, known, none = (hs.jnd(Answers("lapses", rows), lapse=x) for x in (None, 0.05, 0.0))
    assert free.fit.curve.lapse == pytest.approx(0.05, abs=1e-4)
    assert free.jnd.value == pytest.approx(0.3 * 0.6744897501960817, abs=1e-4)
    assert known.jnd.value == pytest.approx(free.jnd.value, abs=1e-4)
    assert known.deviance.fits
    assert none.deviance.fits is False
    assert none.jnd.value > 1.1 * free.jnd.value


@pytest.mark.few("1000.0-0.02")
@pytest.mark.parametrize("lapse", [None, 0.02])
@pytest.mark.parametrize("times", [1e3, 1e5])
def test_answers_given_many_times_over_have_the_same_curve(lapse: float | None, times: float) -> None:
    rows = Answers(
        "once",
        tuple(LevelAnswers(x, k, 40) for x, k in zip((4.0, 4.5, 5.0, 5.5, 6.0), (2, 9, 19, 33, 38), strict=True)),
    ).rows
    many = tuple(LevelAnswers(r.level, r.count * int(times), r.trials * int(times)) for r in rows)
    once, often = (Likelihood(x, 0.0, lapse).best().curve for x in (rows, many))
    assert (often.mu, often.sigma) == pytest.approx((once.mu, once.sigma), rel=1e-5)


@pytest.mark.slow
def test_a_curve_that_does_not_fit_is_said_not_to() -> None:
    rows = tuple(LevelAnswers(float(x), k, 40) for x, k in enumerate((2, 30, 8, 33, 12, 38)))
    found = hs.jnd(Answers("two people", rows))
    assert found.to_dict()["deviance"]["fits"] is False


@pytest.mark.slow
def test_the_fit_is_tested_by_chi_squared_of_what_the_likelihood_lacks_to_that_of_the_shares() -> None:
    found = hs.jnd(DATA)
    kept = sum(k * mp.log(mp.mpf(k) / TRIALS) + (TRIALS - k) * mp.log(1 - mp.mpf(k) / TRIALS) for k in COUNTS)
    lacking = 2 * (loss(mp.mpf(found.fit.curve.mu), mp.mpf(found.fit.curve.sigma)) + kept)
    told = found.to_dict()["deviance"]
    assert found.deviance.value == pytest.approx(float(lacking), rel=1e-9)
    assert (found.deviance.degrees, told["fits"]) == (4, True)
    assert found.deviance.p == pytest.approx(chi2(4).sf(float(lacking)), rel=1e-9)


@pytest.mark.slow
def test_two_levels_fit_exactly_and_cannot_be_tested() -> None:
    found = hs.jnd(Answers("two", (LevelAnswers(1.0, 10, 40), LevelAnswers(2.0, 30, 40))))
    assert found.jnd.value == pytest.approx(0.5, abs=1e-12)  # 25 % at 1, 75 % at 2
    assert found.deviance.p is None


@pytest.mark.slow
def test_single_answers_are_put_together_before_the_fit_is_tested() -> None:
    random = np.random.default_rng(7)
    level = random.uniform(4, 6, 300)
    rows = collected(
        (float(x), int(y), 1) for x, y in zip(level, random.random(300) < PsychometricCurve(5, 0.4)(level), strict=True)
    )
    found = hs.jnd(Answers("trials", rows))
    assert found.deviance.groups == 60
    assert found.deviance.fits
    assert found.jnd.low < 0.4 * 0.6745 < found.jnd.high


@pytest.mark.slow
def test_a_table_too_small_for_an_interval_has_no_upper_end() -> None:
    found = hs.jnd(
        Answers("few", (LevelAnswers(1.0, 1, 4), LevelAnswers(2.0, 2, 4), LevelAnswers(3.0, 3, 4))), reference=2
    )
    assert found.jnd.high is None
    assert float(found.table["real"]) == pytest.approx(0.5, abs=5e-5)  # 25 % at 1, 50 % at 2, 75 % at 3


# Tables.

TRIALS_OF = "".join(f"{x},{int(i < k)}\n" for x, k in zip(LEVELS, COUNTS, strict=True) for i in range(TRIALS))


SAME = {
    "counts": TABLE,
    "semicolons and decimal commas": TABLE.replace(",", ";").replace(".", ","),
    "tabs": TABLE.replace(",", "\t"),
    "a byte-order mark": "\ufeff" + TABLE,
    "carriage returns": TABLE.replace("\n", "\r\n"),
    "blank lines": "\n\n" + TABLE.replace("\n", "\n\n"),
    "quickpsy": "participant,x,k,n\n" + "".join(f"a,{x},{k},{TRIALS}\n" for x, k in zip(LEVELS, COUNTS, strict=True)),
    "Palamedes": TABLE.replace("level,k,n", "StimLevels,NumPos,OutOfNum"),
    "in halves": TABLE + "".join(f"{x},0,0\n" for x in LEVELS) + "6.2,0,0\n",
    "quoted": TABLE.replace("4.4", '"4.4"'),
    "trials": "level,response\n" + TRIALS_OF,
    "two words": "level,answer\n" + TRIALS_OF.replace(",1\n", ",Comp\n").replace(",0\n", ",Ref\n"),
    "1 or 2": "level,answer\n" + TRIALS_OF.replace(",1\n", ",2\n").replace(",0\n", ",1\n"),
    "1 or -1": "level,answer\n" + TRIALS_OF.replace(",0\n", ",-1\n"),
    "levels in per cent, with a number": "level (%),n,answer\n" + TRIALS_OF.replace(",", ",3,"),
    "a level beside a pair": "rt1,rt2,level,answer\n" + "".join(f"1,2,{x}\n" for x in TRIALS_OF.split()),
    "per cent of n": "level,n,percent_more\n" + "".join(f"{x},{TRIALS},{100 * k / TRIALS}\n" for x, k in zip(LEVELS, COUNTS, strict=True)),
    "words": "stimulus,correct\n" + TRIALS_OF.replace(",1\n", ",True\n").replace(",0\n", ",no\n"),
    "PsychoPy": "participant,comparison,trials.thisN,key_resp.keys,key_resp.corr,key_resp.rt\n7,,,,,\n"
    + "".join(f"7,{line.split(',')[0]},{i},up,{line.split(',')[1]},0.5\n" for i, line in enumerate(TRIALS_OF.split())),
    "a staircase of PsychoPy": "trials.thisRepN,trials.intensity,trials.stepSize,trials.response,key_resp.corr\n"
    + "".join(f"0,{line.split(',')[0]},0.1,{line.split(',')[1]},{line.split(',')[1]}\n" for line in TRIALS_OF.split()),
}  # fmt: skip


@pytest.mark.parametrize("text", SAME.values(), ids=SAME)
def test_tables_that_say_the_same_are_read_the_same(text: str, file: Callable[..., Path]) -> None:
    assert read_answers(file(text), {}, {}).rows == ROWS


# Answers about 40 to 130 against a standard of 85: JND 8.74437609, mean 84.0601925 (SciPy, by maximum likelihood).
STIFFER = {
    40: (0, 8),
    50: (0, 8),
    60: (0, 8),
    70: (1, 8),
    80: (4, 8),
    90: (6, 8),
    100: (6, 8),
    110: (8, 8),
    120: (8, 8),
    130: (8, 8),
}
SINGLE = [(x, i < k) for x, (k, n) in STIFFER.items() for i in range(n)]


def singles(header: str, more: str, less: str, separator: str = ",") -> str:
    rows = "".join(f"{x}{separator}{more if is_more else less}\n" for x, is_more in SINGLE)
    return f"{header}\n{rows}"


FILES: dict[str, tuple[str, dict[str, Any]]] = {
    "words of the reference": (singles("level,Answer", "Comp", "Ref"), {}),
    "other words": (singles("Level [N/m];Answer", "links", "rechts", ";"), {"more": "links"}),
    "1 and 2": (singles("level,outcome", "2", "1"), {}),
    "1 and -1": (singles("level,response", "1", "-1"), {}),
    "1 and 0": (singles("level\tresponse", "1", "0", "\t"), {}),
    "true and false": (singles("stimulus,correct", "TRUE", "FALSE"), {}),
    "a preamble": ("Subject,7\nMethod,constant stimuli\n" + singles("level,answer", "yes", "no"), {}),
    "two intervals": ("k1,k2,answer\n" + "".join(f"85,{x},{1 + a}\n" for x, a in SINGLE), {}),
    "counts": ("level,k,n\n" + "".join(f"{x},{k},{n}\n" for x, (k, n) in STIFFER.items()), {}),
    "per cent": ("level,n,percent\n" + "".join(f"{x},{n},{100 * k / n:.2f}\n" for x, (k, n) in STIFFER.items()), {}),
    "rows": ("\n".join(",".join(map(str, x)) for x in (
        ("level", *STIFFER), ("k", *(k for k, _ in STIFFER.values())), ("n", *(n for _, n in STIFFER.values())))), {}),
}  # fmt: skip
LEVEL, MORE = np.array([x for x, _ in SINGLE], float), np.array([int(a) for _, a in SINGLE])
TRIAL = [("stim", "O"), ("outcome", "O")]
VARIABLES: dict[str, dict[str, Any]] = {
    "Palamedes, adaptive, with the next level": {"PM": {"x": np.append(LEVEL, 84.0), "response": MORE, "stop": 1.0}},
    "Palamedes": {"StimLevels": np.array([*STIFFER]), "NumPos": np.array([k for k, _ in STIFFER.values()]), "OutOfNum": np.array([n for _, n in STIFFER.values()])},
    "QUEST+": {"questData": {"nOutcomes": 2, "trialData": np.array([(x, 1 + a) for x, a in zip(LEVEL, MORE, strict=True)], TRIAL)}},
    "QUEST+, vectors": {"QP": {"history_stim": LEVEL, "history_resp": MORE, "stimDomain": np.arange(40.0, 130)}},
    "words": {"level": LEVEL, "answer": np.array([("Ref", "Comp")[a] for a in MORE], object)},
}  # fmt: skip


@pytest.mark.parametrize("name", [*FILES, *VARIABLES])
def test_answers_that_say_the_same_have_the_same_jnd(name: str, file: Callable[..., Path], tmp_path: Path) -> None:
    options: dict[str, Any] = {}
    if name in FILES:
        text, options = FILES[name]
        path = file(text)
    else:
        path = tmp_path / "a.mat"
        savemat(path, VARIABLES[name])
    told = read_answers(path, {}, {}, Coding(options.get("more"), 85)).rows
    assert [(x.level, x.count, x.trials) for x in told] == [(x, k, n) for x, (k, n) in sorted(STIFFER.items())]
    if name in ("other words", "per cent", "QUEST+"):
        found = hs.jnd(path, reference=85, **options)
        assert (found.jnd.value, found.middle.value) == pytest.approx((8.74437609, 84.0601925), rel=1e-8)


def test_of_two_intervals_the_one_that_is_no_standard_is_the_level_and_a_word_means_more(
    file: Callable[..., Path],
) -> None:
    lines = [line.split(",") for line in TRIALS_OF.split()]
    first = [f"{x},5.01,{2 - int(a)}\n" for x, a in lines[::2]]  # the comparison comes first
    second = [f"5.01,{x},{1 + int(a)}\n" for x, a in lines[1::2]]
    table = file("k1,k2,answer\n" + "".join(first + second) + "5.01,5.01,1\n")
    assert hs.jnd(table, reference=5.01).answers.rows == ROWS
    assert "add --reference" in refusal(hs.jnd, table)
    assert "line 2: neither 4.4 nor 5.01 is the level" in refusal(hs.jnd, table, reference=5)
    words = file("level,answer\n" + TRIALS_OF.replace(",1\n", ",links\n").replace(",0\n", ",rechts\n"))
    assert hs.jnd(words, more="links").answers.rows == ROWS
    assert "name the one for more, as --more links" in refusal(hs.jnd, words)
    assert "no answer is" in refusal(hs.jnd, words, more="up")
    assert "is no whole number of responses" in refusal(hs.jnd, file("level,n,percent\n5,8,12.5\n6,8,13.1\n"))


def test_columns_can_be_named_and_lines_chosen(file: Callable[..., Path]) -> None:
    other = "".join(f"b,{x},1,7\n" for x in LEVELS)
    text = "who,f (N),more,of\n" + "".join(f"a,{x},{k},{TRIALS}\n" for x, k in zip(LEVELS, COUNTS, strict=True)) + other
    columns = {"level": "f (N)", "count": "more", "trials": "of"}
    assert read_answers(file(text), columns, {"who": "a"}).rows == ROWS
    with pytest.raises(hs.SceneError, match="no line has who = c"):
        read_answers(file(text), columns, {"who": "c"})
    twice = "".join(f"{x},{10 * x},{k},{TRIALS}\n" for x, k in zip(LEVELS, COUNTS, strict=True))
    for unit, size in (("level", 1), ("level (dB)", 10), ("level dB", 10)):
        header = unit if size > 1 else "level dB"
        found = read_answers(file(f"level,{header},k,n\n{twice}"), {"level": unit}, {})
        assert [x.level for x in found.rows] == pytest.approx([size * x for x in LEVELS])


def test_people_that_are_put_together_are_told(file: Callable[..., Path]) -> None:
    text = "participant,level,k,n\n" + "".join(
        f"{who},{x},{k},{TRIALS}\n" for who in "ab" for x, k in zip(LEVELS, COUNTS, strict=True)
    )
    found = read_answers(file(text), {}, {})
    assert found.rows[0] == LevelAnswers(4.4, 10, 80)
    assert found.notes == ("2 values of participant put together; choose with --where participant=...",)
    assert read_answers(file(text), {}, {"participant": "b"}).rows == ROWS


def test_lines_without_an_answer_are_left_out_and_counted(file: Callable[..., Path]) -> None:
    found = read_answers(file("level,response\n" + TRIALS_OF + "5.0,\n5.3,\n,\n"), {}, {})
    assert found.rows == ROWS
    assert found.notes == ("2 lines without a level or an answer left out",)


@pytest.mark.slow
def test_what_psignifit_saves_is_read_with_what_it_was_told(file: Callable[..., Path]) -> None:
    settings = {"experiment_type": "nAFC", "experiment_choices": 2, "sigmoid": "norm"}
    found = {"threshold": 0.0046, "width": 0.0047, "lambda": 0.0, "gamma": 0.5, "eta": 0.0}
    data = [[0.002, 52, 90], [0.004, 65, 90], [0.006, 80, 90], [0.008, 88.0, 90.0]]
    text = json.dumps({"data": data, "configuration": settings, "parameter_estimate_MAP": found})
    read = hs.jnd(file(text, "saved.json"))
    assert read.asked.alternatives == 2
    assert [(x.count, x.trials) for x in read.answers.rows] == [(52, 90), (65, 90), (80, 90), (88, 90)]
    assert "psignifit found threshold 0.0046 and width 0.0047" in str(read)
    with pytest.raises(hs.SceneError, match="gives 2 alternatives, not 3"):
        hs.jnd(file(text, "saved.json"), alternatives=3)


@pytest.mark.slow
def test_psignifit_itself_finds_what_it_is_known_to_find(file: Callable[..., Path]) -> None:
    """The middle, the JND and the interval that psignifit 4.3 gives for this table with equal asymptotes."""
    required("psignifit", find_spec("psignifit"))
    found = hs.jnd(file(TABLE), method="psignifit")
    assert found.fit.curve.mu == pytest.approx(5.056905256235305, abs=1e-6)
    assert found.jnd.value == pytest.approx(0.392169934, abs=1e-5)  # there with its lapses of 4e-6
    assert (found.middle.low, found.middle.high) == pytest.approx((4.9128, 5.1664), abs=1e-4)
    assert found.to_dict()["method"] == "psignifit 4"


@pytest.mark.slow
def test_a_table_may_come_through_a_pipe() -> None:
    read, write = os.pipe()
    os.write(write, TABLE.encode())
    os.close(write)
    try:
        assert hs.jnd(f"/dev/fd/{read}").answers.rows == ROWS
    finally:
        os.close(read)


BAD = {
    "nothing": ("", "there are no lines of numbers"),
    "only a header": ("level,k,n\n", "there are no lines of numbers"),
    "one level": ("level,k,n\n5,3,10\n5,4,10\n", "all answers are at one level, 5"),
    "no k": ("level,n\n5,10\n", "no column holds how many answers counted"),
    "no level": ("force,k,n\n5,1,10\n", "no column holds the levels: there are force, k, n"),
    "too many": ("level,k,n\n5,11,10\n6,12,13\n", "line 2: k = 11 is more than n = 10"),
    "less than none": ("level,k,n\n5,-1,10\n", 'line 2: k: "-1" is no count'),
    "half an answer": ("level,k,n\n5,1.5,10\n", 'line 2: k: "1.5" is no count'),
    "not a number": ("level,k,n\n5,1,10\nnan,2,10\n", 'line 3: level: "nan" is not a finite number'),
    "infinite": ("level,k,n\ninf,1,10\n", 'line 2: level: "inf" is not a finite number'),
    "a word": ("level,k,n\n5,1,10\nabc,2,10\n", 'line 3: level: "abc" is not a number'),
    "an answer that is none": ("level,response\n5,1\n6,left\n", 'line 3: answer: "left" must be 1 or 0'),
    "no header": ("4.4,5,40\n4.7,11,40\n", "line 1 has numbers"),
    "never": ("level,k,n\n5,0,10\n6,0,10\n", "no answer counts"),
    "always": ("level,k,n\n5,10,10\n6,10,10\n", "every answer counts"),
    "a jump": ("level,k,n\n5,0,10\n6,0,10\n7,10,10\n8,10,10\n", "change from one kind to the other between 6 and 7"),
    "one level in between": ("level,k,n\n5,0,10\n6,4,10\n7,10,10\n", "change from one kind to the other between 6 and 7"),
    "flat": ("level,k,n\n5,5,10\n6,5,10\n7,5,10\n", "do not change from one kind to the other"),
    "the wrong answers": ("level,k,n\n5,9,10\n6,5,10\n7,1,10\n", "count the other responses"),
    "two that may be it": ("level,a.corr,b.corr\n5,1,0\n", 'columns "a.corr" or "b.corr" both fit: choose one with --answer'),
    "a null character": ("level,k,n\n5,1\0,10\n6,5,10\n", "answers.csv: "),
    "no JSON": ('{"data": [', "not valid JSON"),
    "another JSON": ('{"x": 1}', "no result of psignifit 4"),
    "JSON of words": ('{"data": [["a", 1, 2]]}', 'data: level: "a" is not a number'),
    "JSON with more": ('{"data": [[1, 3, 2]]}', "k = 3 is more than n = 2"),
    "deep JSON": ("[" * 100_000, "not valid JSON"),
}  # fmt: skip


@pytest.mark.dear("a jump", "another JSON", "flat", "one level in between", "the wrong answers")
@pytest.mark.parametrize(("text", "told"), BAD.values(), ids=BAD)
def test_what_cannot_be_read_or_fitted_is_said_in_a_sentence(text: str, told: str, file: Callable[..., Path]) -> None:
    with pytest.raises(hs.SceneError) as raised:
        hs.jnd(file(text))
    assert told in str(raised.value)
    assert "\n" not in str(raised.value)
    assert str(raised.value).count("answers.csv") <= 1


def test_what_is_no_table_is_called_what_it_is(file: Callable[..., Path], tmp_path: Path) -> None:
    for content, name, told in (
        (b"\x80\x04\x95", "a.csv", "a pickle, which would run"),
        (b"level,k,n", "a.psydat", "a pickle, which would run"),
        (b"PK\x03\x04", "a.xlsx", "save its sheet as CSV"),
        (b"MATLAB 5.0", "a.mat", "not a readable file of MATLAB"),
        ("level,k,n\n5,1,10\n".encode("utf-16"), "a.csv", "not text in UTF-8"),
    ):
        with pytest.raises(hs.SceneError, match=told):
            hs.jnd(file(content, name))
    with pytest.raises(hs.SceneError, match="is a folder"):
        hs.jnd(tmp_path)
    with pytest.raises(hs.SceneError, match="there is no such file"):
        hs.jnd(tmp_path / "none.csv")


# For a scene.


@pytest.mark.slow
def test_the_line_for_a_scene_is_one_with_the_interval_as_its_range_and_its_proportion() -> None:
    found = hs.jnd(DATA, reference=5)
    own = 'environment = { model = "mass-spring-damper", k = 1 }\n'
    threshold = hs.parse_scene(f"{own}[evaluation]\n{found.line}\n").threshold
    assert float(threshold.real) == pytest.approx(found.jnd.value / 5, rel=1e-3)
    assert float(threshold.confidence) == 0.95
    low, high = threshold.real_interval
    assert float(low) <= found.fraction.low < found.fraction.high <= float(high)
    assert threshold.imag_interval == (low, high)
    there = threshold.at_proportion("0.84")  # as another fit at that proportion has it
    assert float(there.real) == pytest.approx(hs.jnd(DATA, reference=5, proportion=0.84).fraction.value, rel=1e-3)


@pytest.mark.slow
def test_the_line_of_a_forced_choice_tells_no_proportion_that_could_be_converted() -> None:
    rows = tuple(LevelAnswers(0.04 * i, k, 40) for i, k in enumerate((20, 24, 31, 36, 40)))
    found = hs.jnd(Answers("choices", rows), alternatives=2, reference=1)
    assert "proportion" not in found.table
    with pytest.raises(hs.SceneError, match="the JND has none of its own"):
        hs.parse_scene(
            f'environment = {{ model = "mass-spring-damper", k = 1 }}\n[evaluation]\n{found.line}\n'
        ).threshold.at_proportion("0.84")


@pytest.mark.slow
def test_the_command_says_the_same_as_python(file: Callable[..., Path]) -> None:
    path = file(TABLE)
    done = CliRunner().invoke(app, ["jnd", str(path), "--reference", "5", "--json"])
    assert done.exit_code == 0
    document = json.loads(done.stdout)
    assert document == hs.jnd(path, reference=5).to_dict()
    assert (document["schema"], document["certified"]) == ("haptisym.jnd/1", False)


@pytest.mark.slow
@pytest.mark.few(1)
@pytest.mark.parametrize("seed", range(3))
def test_no_curve_is_likelier_than_the_one_that_is_found(seed: int) -> None:
    """Without guesses and lapses minus the log-likelihood is convex in a and b of Phi(a + b x): it has one bottom."""
    draw, checked = np.random.default_rng(seed), 0
    for _ in range(4):
        many = int(draw.integers(2, 9))
        levels = np.sort(draw.choice(np.arange(1, 300), many, replace=False)) / 100
        spread = (levels[-1] - levels[0]) * 10 ** draw.uniform(-1.3, 1.2)
        trials = draw.integers(3, 60, many)
        shares = ndtr((levels - draw.uniform(levels[0], levels[-1])) / spread)
        counts = draw.binomial(trials, shares)
        found = Likelihood(rows_of(levels, counts, trials), 0, 0.0).best()
        if not (found.steep or found.flat or found.outside):
            checked += 1
            assert found.loss <= convex_bottom(levels, counts, trials) + 1e-7
    assert checked


def rows_of(levels: Array, counts: Array, trials: Array) -> tuple[LevelAnswers, ...]:
    return tuple(LevelAnswers(float(x), int(k), int(n)) for x, k, n in zip(levels, counts, trials, strict=True))


def convex_bottom(levels: Array, counts: Array, trials: Array) -> float:
    """The least loss, by a search without slopes."""
    x = (levels - levels.mean()) / (levels[-1] - levels[0])

    def lost(line: Array) -> float:
        z = line[0] + line[1] * x
        return -float((counts * log_ndtr(z) + (trials - counts) * log_ndtr(-z)).sum())

    return float(minimize(lost, [0, 1], method="Nelder-Mead", options={"xatol": 1e-9, "fatol": 1e-11}).fun)


def test_a_flat_curve_beside_close_levels_is_found() -> None:
    rows = (LevelAnswers(1.15, 6, 14), LevelAnswers(1.33, 10, 16), LevelAnswers(1.34, 17, 34))
    found = Likelihood(rows, 0, 0.0).best()
    assert found.curve.sigma == pytest.approx(0.7107969972, rel=1e-9)
    assert found.loss == pytest.approx(44.0902272396582, abs=1e-12)


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
    expected = tuple(LevelAnswers(x, *sums[x]) for x in sorted(sums) if sums[x][1])
    assert collected(blocks(drawn)) == expected
    assert all(x.share == x.count / x.trials for x in expected)
    assert "2 of 1 responses are impossible" in refusal(collected, [(1.0, 2, 1)])
    assert "-1 of 1 responses are impossible" in refusal(collected, [(1.0, -1, 1)])
    assert "is not a finite number" in refusal(collected, [(float("inf"), 1, 1)])
    assert collected([(1.0, 1, 1), (1.0, 0, 1), (0.0, 0, 0)]) == (LevelAnswers(1.0, 1, 2),)


# The likelihood.


def by_mpmath(rows: tuple[LevelAnswers, ...], mu: Any, spread: Any, guess: Any, lapse: Any) -> Any:
    total = mp.mpf(0)
    for x in rows:
        p = guess + (1 - guess - lapse) * mp.ncdf((mp.mpf(x.level) - mu) / mp.exp(spread))
        total -= (x.count * mp.log(p) if x.count else 0) + (
            (x.trials - x.count) * mp.log(1 - p) if x.trials > x.count else 0
        )
    return total


@pytest.mark.slow
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
        point = tuple(map(mp.mpf, (mu, spread, lapse)))

        def f(m: Any, s: Any, lapses: Any) -> Any:
            return by_mpmath(rows, m, s, mp.mpf(guess), lapses)

        loss, (by_mu, by_spread, by_lapse) = Likelihood(rows, guess, None).loss(mu, spread, lapse)
        assert loss == pytest.approx(float(f(*point)), rel=1e-11, abs=1e-12)
        exact = [float(mp.diff(f, point, order)) for order in ((1, 0, 0), (0, 1, 0))]
        assert [-by_mu, -by_spread] == pytest.approx([-x for x in exact], rel=1e-8, abs=1e-9)
        if lapse:
            assert by_lapse == pytest.approx(float(mp.diff(f, point, (0, 0, 1))), rel=1e-8, abs=1e-9)
        curve = PsychometricCurve(mu, float(mp.exp(spread)), guess, lapse)
        kept = sum((x.count * mp.log(mp.mpf(x.count) / x.trials) if x.count else 0)
                   + ((x.trials - x.count) * mp.log(1 - mp.mpf(x.count) / x.trials) if x.trials > x.count else 0) for x in rows)  # fmt: skip
        assert Likelihood(rows, guess, lapse).deviance(curve) == pytest.approx(
            float(2 * (kept + f(*point))), rel=1e-9, abs=1e-9
        )
        assert float(curve(np.array([0.3]))[0]) == pytest.approx(
            float(guess + (1 - guess - lapse) * mp.ncdf((mp.mpf("0.3") - mu) / mp.exp(spread))), rel=1e-12
        )
    assert [Likelihood(rows, guess, x).free for x in (None, 0.0)] == [3, 2]


CHOICES = (
    LevelAnswers(0.02, 21, 40),
    LevelAnswers(0.06, 23, 40),
    LevelAnswers(0.1, 28, 40),
    LevelAnswers(0.14, 35, 40),
    LevelAnswers(0.18, 36, 40),
    LevelAnswers(0.24, 39, 40),
)


@pytest.mark.slow
def test_counting_the_other_answers_on_levels_the_other_way_round_is_the_mirrored_curve() -> None:
    """Of levels that are too high mu is as far below them as above those of the mirror; so is what is held."""
    way = 5.0
    for counts in ((26, 30, 33, 35), (2, 5, 7, 13)):
        rows = tuple(LevelAnswers(1.0 + x, k, 40) for x, k in zip((0.0, 0.2, 0.5, 0.7), counts, strict=True))
        turned = tuple(LevelAnswers(way - x.level, x.trials - x.count, x.trials) for x in reversed(rows))
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


@pytest.mark.slow
def test_the_interval_of_a_forced_choice_ends_where_its_profile_has_fallen_by_half_of_chi_squared() -> None:
    found = hs.jnd(Answers("choices", CHOICES), alternatives=2, proportion=0.8, lapse=0.02, confidence=0.9)
    z = NormalDist().inv_cdf((0.8 - 0.5) / 0.5)
    own = Likelihood(CHOICES, 0.5, 0.02)
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


def test_a_number_without_an_end_has_a_line_without_a_range() -> None:
    assert IntervalEstimate(2.0, None, 3.0).scaled(0.5) == IntervalEstimate(1.0, None, 1.5)
    answers = Answers("few", (LevelAnswers(1.0, 1, 3), LevelAnswers(2.0, 2, 3)))
    for low, high, written in (
        (None, 9.0, "0.1235"),
        (2.0, None, "0.1235"),
        (-2.0, 9.0, "0.1235"),
        (0.0, 9.0, "0.1235"),
        (1.00004, 1.98765, "[0.1000, 0.1235, 0.1988]"),
    ):
        fit = CurveFit(
            PsychometricCurve(1.5, 1),
            IntervalEstimate(1.5, None, None),
            IntervalEstimate(1.23456, low, high),
            Deviance(0.0, 0, None, 2),
        )
        assert Psychometric(answers, WantedJnd(0.75, 2), fit, reference=10).table == {
            "real": written,
            "imag": written,
            "confidence": "0.95",
        }


@pytest.mark.slow
def test_a_jnd_of_a_forced_choice_is_above_zero() -> None:
    rows = tuple(LevelAnswers(float(x), k, 40) for x, k in zip(range(-8, -2), (20, 22, 28, 33, 38, 40), strict=True))
    assert "x: the JND would be -" in refusal(hs.jnd, Answers("x", rows), alternatives=2)


# What is asked.


@pytest.mark.parametrize(
    ("proportion", "alternatives", "value"),
    [(None, None, (0, 0.75)), (0.84, None, (0, 0.84)), (None, 2, (1, 0.5)), (None, 4, (1, 0.5)), (0.9, 2, (1, 0.8)), (0.5, 4, (1, 1 / 3)), (0.51, None, (0, 0.51))],
)  # fmt: skip
def test_the_jnd_is_a_mu_plus_z_sigma(
    proportion: float | None, alternatives: int | None, value: tuple[int, float]
) -> None:
    asked = WantedJnd.of(proportion, alternatives)
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
        ({"alternatives": 2, "guess": 0.1}, "guess: leave it out"),
    ],
)  # fmt: skip
def test_what_may_be_asked_has_its_limits(keys: dict[str, Any], told: str) -> None:
    said = refusal(hs.jnd, Answers("x", (LevelAnswers(1.0, 10, 40), LevelAnswers(2.0, 30, 40))), **keys)
    assert told in said
    assert bool(told) == bool(said)


@pytest.mark.parametrize(
    ("header", "named", "told"),
    [
        (["x", "k", "n"], {}, (0, 1, 2, None)), (["x", "k", "n", "response"], {}, (0, 1, 2, None)), (["x", "k", "n", "response"], {"answer": "response"}, (0, None, None, 3)),
        (["x", "k", "response"], {}, (0, None, None, 2)), (["x", "n", "correct"], {}, (0, 2, 1, None)), (["x", "correct"], {}, (0, None, None, 1)),
        (["f", "k", "n"], {"level": "f"}, (0, 1, 2, None)), (["x", "y"], {"level": "y"}, "how many answers counted (k) of how many (n), nor one answer a line"),
        (["f", "k", "n"], {}, "no column holds the levels: there are f, k, n; name it with --level COLUMN"), ([], {}, "there are none"),
        (["x", "k"], {}, "name it with --count and --trials, or --answer, COLUMN"), (["x", "a.corr", "b.corr"], {}, 'answer: columns "a.corr" or "b.corr" both fit'),
        (["x", "k", "n"], {"level": "X"}, 'level: no column "X": did you mean "x"? there are x, k, n'), (["levle", "k", "n"], {"level": "level"}, 'did you mean "levle"?'),
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
        (("x,k,n\n1,3,2\n2,1,2\n", {}), "line 2: k = 3 is more than n = 2"), (("x,k,n\n1,1,2\n2,1,1.5\n", {}), 'line 3: n: "1.5" is no count of responses'),
        (("x,k,n\n1,-1,2\n2,1,2\n", {}), 'k: "-1" is no count'), (("x,k,n\n1,1,1e13\n2,1,2\n", {}), 'n: "1e13" is no count'),
        (("x,response\n1,\n,1\n", {}), "no line has both a level and a response"), (("x,response\n1,maybe\n2,1\n", {}), 'line 2: answer: "maybe" must be 1 or 0'),
        (("1,2,3\n4,5,6\n", {}), "line 1 has numbers: name the columns"), (("x,k,n\n1;5,1,2\n2,1,2\n", {}), 'level: "1;5" is not a number'),
        (("x,k,n\n1e999,1,2\n2,1,2\n", {}), 'level: "1e999" is not a finite number'), (('{"data": [[1, 1, 2]]}', {"named": {"level": "x"}}), "JSON has no columns"),
        (('{"data": [[1, 1, 2]]}', {"where": {"x": "1"}}), "JSON has no columns"), (('{"data": [[1, 1]]}', {}), "no result of psignifit 4"), (('{"dat": []}', {}), "no result of psignifit"),
        (('{"data": [[1, true, 2], [2, 1, 2]]}', {}), 'data: k: "True" is not a number'), (('[[1, 0.5, 2], [2, 1, 2]]', {}), 'k: "0.5" is no count of responses'),
        (('[[1, -1, 2], [2, 1, 2]]', {}), 'k: "-1" is no count'), (('[[1, 1, 2.5], [2, 1, 2]]', {}), 'n: "2.5" is no count'), (('[[NaN, 1, 2], [2, 1, 2]]', {}), 'level: "nan" is not a finite number'),
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


def test_published_thresholds_are_listed_as_their_table_says_and_those_of_other_things_are_refused() -> None:
    told = hs.published().to_dict()
    assert len(told["thresholds"]) == len(hs.published()) > 9
    for row, x in zip(told["thresholds"], hs.published(), strict=True):
        assert (row["name"], row["fraction"], row["usable"]) == (x.name, [float(x.low), float(x.high)], not x.apart)
        assert x.low <= x.high
        if x.apart:
            assert x.apart in refusal(hs.Threshold.like, x.name)
        else:
            assert hs.Threshold.like(x.name).real_interval == (x.low, x.high) or x.low == x.high


STAIR = [(0.5, "1111"), (0.4, "1111110"), (0.3, "111100"), (0.2, "0")]


def answers(folder: Path, rows: list[tuple[float, str]]) -> Path:
    path = folder / "answers.csv"
    lines = [f"{level},{x}" for level, given in rows for x in given]
    path.write_text("\n".join(["level,answer", *lines]), encoding="utf-8")
    return path


@pytest.mark.slow
def test_a_jnd_of_a_forced_choice_is_a_size(tmp_path: Path) -> None:
    found = hs.jnd(answers(tmp_path, STAIR), alternatives=2, proportion=0.707, reference=1)
    assert found.jnd.value > 0
    assert found.jnd.low == 0
    assert found.to_dict()["fraction"]["interval"][0] == 0
    assert "-" not in str(found).partition("fit ")[0].partition("JND")[2].replace("—", "")


@pytest.mark.slow
def test_with_guesses_the_page_says_which_curve_a_jnd_is_of(tmp_path: Path) -> None:
    shares = [(x / 2, 0.1 + 0.8 * norm.cdf(x / 2 / 1.5)) for x in range(-8, 9)]
    rows = [(x, "1" * round(40 * share) + "0" * (40 - round(40 * share))) for x, share in shares]
    found = hs.jnd(answers(tmp_path, rows), guess=0.1, lapse=0.1)
    curve, page = found.fit.curve, " ".join(str(found).split())
    assert found.jnd.value == pytest.approx(curve.sigma * norm.ppf(0.75), rel=1e-9)
    assert "without guesses and lapses 75 % of the responses would be" in page.replace("\xa0", " ")
    of_all = curve.sigma * norm.ppf(0.65 / 0.8)
    assert f"75 % of all: {of_all:.4g}" in page.replace("\xa0", " ")


def test_a_threshold_has_parts_and_no_items() -> None:
    with pytest.raises(TypeError):
        list(hs.Threshold.of("0.1"))


def test_an_answer_that_is_none_is_left_out(tmp_path: Path) -> None:
    rows = [(1 + x / 10, int(x > 4 or x == 2)) for x in range(10)]
    lines = [f"{x},{y}" for x, y in rows]
    for name, extra in (("with", ["1.3,None", "1.4,NA"]), ("without", [])):
        (tmp_path / f"{name}.csv").write_text("\n".join(["x,answer", *lines, *extra]))
    told, own = (hs.jnd(tmp_path / f"{x}.csv", columns={"level": "x", "answer": "answer"}) for x in ("with", "without"))
    assert told.jnd.value == own.jnd.value
    assert "2 lines without a level or an answer left out" in " ".join(str(told).split())
