"""A JND from answers: tables as programs write them, the curve against an independent solution, and what cannot be fitted."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from statistics import NormalDist

import mpmath as mp
import numpy as np
import pytest
from click.testing import CliRunner
from fits import CHI_95, best_probit, likelihood
from marks import required
from scipy.optimize import minimize
from scipy.special import log_ndtr, ndtr

import haptisym as hs
from haptisym.cli import app
from haptisym.programs.values import Array
from haptisym.verbs.jnd.answers import Answers, Row, collected
from haptisym.verbs.jnd.curve import Curve
from haptisym.verbs.jnd.likelihood import Likelihood
from haptisym.verbs.simulate.threads import one_thread

LEVELS, COUNTS, TRIALS = (4.4, 4.7, 5.0, 5.3, 5.6, 5.9), (5, 11, 19, 26, 33, 37), 40
TABLE = "level,k,n\n" + "".join(f"{x},{k},{TRIALS}\n" for x, k in zip(LEVELS, COUNTS, strict=True))
ROWS = tuple(Row(x, k, TRIALS) for x, k in zip(LEVELS, COUNTS, strict=True))
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
    found = hs.jnd(Answers("flat", tuple(Row(*x) for x in told)))
    top = likelihood(told, *best_probit(told))
    for end in (found.jnd.low, found.jnd.high):
        assert end is not None
        slope = mp.mpf(NormalDist().inv_cdf(0.75)) / end
        assert abs(2 * (top - likelihood(told, *best_probit(told, slope))) - CHI_95) < 1e-6


@pytest.mark.slow
def test_a_parametric_bootstrap_gives_about_the_same_interval() -> None:
    found = hs.jnd(DATA)
    counts = np.random.default_rng(2026).binomial(TRIALS, found.fit.curve(np.array(LEVELS)), (200, len(LEVELS)))
    drawn = [
        Likelihood(tuple(Row(x, int(k), TRIALS) for x, k in zip(LEVELS, row, strict=True)), 0.0, 0.0) for row in counts
    ]
    with one_thread():
        fits = [x.best(begun=found.fit.curve).curve for x in drawn]
    low, high = np.quantile([0.6744897501960817 * x.sigma for x in fits], [0.025, 0.975])
    assert found.jnd.low == pytest.approx(low, rel=0.1)
    assert found.jnd.high == pytest.approx(high, rel=0.1)
    deviances = [x.deviance(curve) for x, curve in zip(drawn, fits, strict=True)]
    assert np.mean(deviances) == pytest.approx(found.deviance.degrees, abs=0.5)  # as chi-squared has it


def test_another_proportion_is_the_same_sigma() -> None:
    at_71, at_84 = (hs.jnd(DATA, proportion=p).jnd.value for p in (0.71, 0.84))
    assert at_84 / at_71 == pytest.approx(1.79704616, abs=1e-8)
    assert 19 * at_84 / at_71 == pytest.approx(34.14387697, abs=1e-7)


@pytest.mark.few(1)
@pytest.mark.parametrize("alternatives", [2, 3, 4])
def test_a_forced_choice_has_its_threshold_at_the_proportion_asked_for(alternatives: int) -> None:
    curve = Curve(0.12, 0.05, 1 / alternatives)
    level = np.array([0.02, 0.06, 0.1, 0.14, 0.18, 0.24])
    rows = tuple(Row(float(x), round(p * 10**7), 10**7) for x, p in zip(level, curve(level), strict=True))
    found = hs.jnd(Answers("choices", rows), alternatives=alternatives, reference=1)
    assert found.asked.proportion == (1 + 1 / alternatives) / 2
    assert found.fraction is not None
    assert found.fraction.value == pytest.approx(0.12, abs=1e-5)
    higher = hs.jnd(Answers("choices", rows), alternatives=alternatives, proportion=0.9)
    assert float(curve(np.array([higher.jnd.value]))[0]) == pytest.approx(0.9, abs=1e-4)


@pytest.mark.slow
def test_lapses_that_are_there_are_found_where_they_may_be() -> None:
    curve = Curve(5.0, 0.3, 0.0, 0.05)
    level = np.linspace(4, 6.5, 9)
    rows = tuple(Row(float(x), round(p * 10**6), 10**6) for x, p in zip(level, curve(level), strict=True))
    free, known, none = (hs.jnd(Answers("lapses", rows), lapse=x) for x in (None, 0.05, 0.0))
    assert free.fit.curve.lapse == pytest.approx(0.05, abs=1e-4)
    assert free.jnd.value == pytest.approx(0.3 * 0.6744897501960817, abs=1e-4)
    assert known.jnd.value == pytest.approx(free.jnd.value, abs=1e-4)
    assert known.deviance.fits
    assert none.deviance.fits is False
    assert none.jnd.value > 1.1 * free.jnd.value


@pytest.mark.parametrize("lapse", [None, 0.02])
@pytest.mark.parametrize("times", [1e3, 1e5])
def test_answers_given_many_times_over_have_the_same_curve(lapse: float | None, times: float) -> None:
    rows = Answers(
        "once", tuple(Row(x, k, 40) for x, k in zip((4.0, 4.5, 5.0, 5.5, 6.0), (2, 9, 19, 33, 38), strict=True))
    ).rows
    many = tuple(Row(r.level, r.count * int(times), r.trials * int(times)) for r in rows)
    once, often = (Likelihood(x, 0.0, lapse).best().curve for x in (rows, many))
    assert (often.mu, often.sigma) == pytest.approx((once.mu, once.sigma), rel=1e-5)


def test_a_curve_that_does_not_fit_is_said_not_to() -> None:
    rows = tuple(Row(float(x), k, 40) for x, k in enumerate((2, 30, 8, 33, 12, 38)))
    found = hs.jnd(Answers("two people", rows))
    assert found.deviance.fits is False
    assert found.to_dict()["deviance"]["fits"] is False
    assert "The curve does NOT fit" in str(found)


def test_two_levels_fit_exactly_and_cannot_be_tested() -> None:
    found = hs.jnd(Answers("two", (Row(1.0, 10, 40), Row(2.0, 30, 40))))
    assert found.jnd.value == pytest.approx(0.5, abs=1e-12)  # 25 % at 1, 75 % at 2
    assert found.deviance.p is None
    assert "cannot be tested" in str(found)


def test_single_answers_are_put_together_before_the_fit_is_tested() -> None:
    random = np.random.default_rng(7)
    level = random.uniform(4, 6, 300)
    rows = collected(
        (float(x), int(y), 1) for x, y in zip(level, random.random(300) < Curve(5, 0.4)(level), strict=True)
    )
    found = hs.jnd(Answers("trials", rows))
    assert found.deviance.groups == 60
    assert found.deviance.fits
    assert found.jnd.low < 0.4 * 0.6745 < found.jnd.high
    assert "300 levels put into 60 groups" in str(found)


@pytest.mark.slow
def test_very_many_levels_are_put_together_and_give_the_same_curve() -> None:
    random = np.random.default_rng(11)
    level = random.normal(5, 1, 20_000)
    answered = random.random(20_000) < Curve(5, 0.6)(level)
    many = tuple(Row(float(x), int(y), 1) for x, y in sorted(zip(level, answered, strict=True)))
    found = hs.jnd(Answers("many", many))
    whole = Likelihood(many, 0.0, 0.0).best(begun=found.fit.curve).curve
    assert len(found.answers.rows) == 1000
    assert found.notes[0] == "20000 levels put into 1000 groups of neighbours, each at its mean"
    assert found.fit.curve.sigma == pytest.approx(whole.sigma, rel=1e-3)
    assert found.jnd.low < 0.6744897501960817 * 0.6 < found.jnd.high


@pytest.mark.slow
def test_a_table_too_small_for_an_interval_has_no_upper_end() -> None:
    found = hs.jnd(Answers("few", (Row(1.0, 1, 4), Row(2.0, 2, 4), Row(3.0, 3, 4))), reference=2)
    assert found.jnd.high is None
    assert found.table["real"] == "0.5"  # 25 % at 1, 50 % at 2, 75 % at 3
    assert "unbounded" in str(found)
    assert "The interval has NO upper end" in str(found)


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
    "words": "stimulus,correct\n" + TRIALS_OF.replace(",1\n", ",True\n").replace(",0\n", ",no\n"),
    "PsychoPy": "participant,comparison,trials.thisN,key_resp.keys,key_resp.corr,key_resp.rt\n7,,,,,\n"
    + "".join(f"7,{line.split(',')[0]},{i},up,{line.split(',')[1]},0.5\n" for i, line in enumerate(TRIALS_OF.split())),
    "a staircase of PsychoPy": "trials.thisRepN,trials.intensity,trials.stepSize,trials.response,key_resp.corr\n"
    + "".join(f"0,{line.split(',')[0]},0.1,{line.split(',')[1]},{line.split(',')[1]}\n" for line in TRIALS_OF.split()),
}  # fmt: skip


@pytest.mark.few(2)
@pytest.mark.parametrize("text", SAME.values(), ids=SAME)
def test_tables_that_say_the_same_are_read_the_same(text: str, file: Callable[..., Path]) -> None:
    assert hs.jnd(file(text)).answers.rows == ROWS


def test_columns_can_be_named_and_lines_chosen(file: Callable[..., Path]) -> None:
    other = "".join(f"b,{x},1,7\n" for x in LEVELS)
    text = "who,f (N),more,of\n" + "".join(f"a,{x},{k},{TRIALS}\n" for x, k in zip(LEVELS, COUNTS, strict=True)) + other
    columns = {"level": "f (N)", "count": "more", "trials": "of"}
    assert hs.jnd(file(text), columns=columns, where={"who": "a"}).answers.rows == ROWS
    with pytest.raises(hs.SceneError, match="no line has who = c"):
        hs.jnd(file(text), columns=columns, where={"who": "c"})


def test_people_that_are_put_together_are_told(file: Callable[..., Path]) -> None:
    text = "participant,level,k,n\n" + "".join(
        f"{who},{x},{k},{TRIALS}\n" for who in "ab" for x, k in zip(LEVELS, COUNTS, strict=True)
    )
    found = hs.jnd(file(text))
    assert found.answers.rows[0] == Row(4.4, 10, 80)
    assert found.notes == ("2 values of participant put together; choose with --where participant=...",)
    assert hs.jnd(file(text), where={"participant": "b"}).answers.rows == ROWS


def test_lines_without_an_answer_are_left_out_and_counted(file: Callable[..., Path]) -> None:
    found = hs.jnd(file("level,response\n" + TRIALS_OF + "5.0,\n5.3,\n,\n"))
    assert found.answers.rows == ROWS
    assert found.notes == ("2 lines without a level or an answer left out",)


def test_what_psignifit_saves_is_read_with_what_it_was_told(file: Callable[..., Path]) -> None:
    settings = {"experiment_type": "nAFC", "experiment_choices": 2, "sigmoid": "norm"}
    found = {"threshold": 0.0046, "width": 0.0047, "lambda": 0.0, "gamma": 0.5, "eta": 0.0}
    data = [[0.002, 52, 90], [0.004, 65, 90], [0.006, 80, 90], [0.008, 88.0, 90.0]]
    text = json.dumps({"data": data, "configuration": settings, "parameter_estimate_MAP": found})
    read = hs.jnd(file(text, "saved.json"))
    assert read.asked.alternatives == 2
    assert [(x.count, x.trials) for x in read.answers.rows] == [(52, 90), (65, 90), (80, 90), (88, 90)]
    assert "psignifit found threshold 0.0046 and width 0.0047" in str(read)
    with pytest.raises(hs.SceneError, match="there were 2 alternatives, not 3"):
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
def test_psignifit_and_the_likelihood_agree_on_a_forced_choice() -> None:
    required("psignifit", find_spec("psignifit"))
    curve = Curve(0.12, 0.05, 0.5)
    level = np.array([0.02, 0.06, 0.1, 0.14, 0.18, 0.24])
    data = Answers(
        "choices", tuple(Row(float(x), round(p * 200), 200) for x, p in zip(level, curve(level), strict=True))
    )
    for proportion in (0.75, 0.8):
        one, other = (
            hs.jnd(data, alternatives=2, proportion=proportion, method=m) for m in ("likelihood", "psignifit")
        )
        assert other.jnd.value == pytest.approx(one.jnd.value, rel=0.03)
        assert other.jnd.low < one.jnd.value < other.jnd.high


def test_a_table_may_come_through_a_pipe() -> None:
    read, write = os.pipe()
    os.write(write, TABLE.encode())
    os.close(write)
    try:
        assert hs.jnd(f"/dev/fd/{read}").answers.rows == ROWS
    finally:
        os.close(read)


@pytest.mark.slow
def test_a_million_lines_are_read_as_their_counts(file: Callable[..., Path]) -> None:
    rows = hs.jnd(file("level,response\n" + TRIALS_OF * 4167)).answers.rows
    assert rows == tuple(Row(x, 4167 * k, 4167 * TRIALS) for x, k in zip(LEVELS, COUNTS, strict=True))


BAD = {
    "nothing": ("", "no column holds the levels: there are none"),
    "only a header": ("level,k,n\n", "there are no answers"),
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
    "no header": ("4.4,5,40\n4.7,11,40\n", "the first line holds numbers"),
    "never": ("level,k,n\n5,0,10\n6,0,10\n", "no answer counts"),
    "always": ("level,k,n\n5,10,10\n6,10,10\n", "every answer counts"),
    "a jump": ("level,k,n\n5,0,10\n6,0,10\n7,10,10\n8,10,10\n", "jump from one kind to the other between 6 and 7"),
    "one level in between": ("level,k,n\n5,0,10\n6,4,10\n7,10,10\n", "jump from one kind to the other"),
    "flat": ("level,k,n\n5,5,10\n6,5,10\n7,5,10\n", "do not go from one kind to the other"),
    "the wrong answers": ("level,k,n\n5,9,10\n6,5,10\n7,1,10\n", "count the other answers"),
    "two that may be it": ("level,a.corr,b.corr\n5,1,0\n", 'it may be column "a.corr" or "b.corr": name it with --answer'),
    "a null character": ("level,k,n\n5,1\0,10\n6,5,10\n", "answers.csv: "),
    "no JSON": ('{"data": [', "not valid JSON"),
    "another JSON": ('{"x": 1}', "no result of psignifit 4"),
    "JSON of words": ('{"data": [["a", 1, 2]]}', "must be three numbers"),
    "JSON with more": ('{"data": [[1, 3, 2]]}', "k at most n"),
    "deep JSON": ("[" * 100_000, "not valid JSON"),
}  # fmt: skip


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
        (b"MATLAB 5.0", "a.mat", "a MATLAB file"),
        ("level,k,n\n5,1,10\n".encode("utf-16"), "a.csv", "not text in UTF-8"),
    ):
        with pytest.raises(hs.SceneError, match=told):
            hs.jnd(file(content, name))
    with pytest.raises(hs.SceneError, match="is a folder"):
        hs.jnd(tmp_path)
    with pytest.raises(hs.SceneError, match="there is no such file"):
        hs.jnd(tmp_path / "none.csv")


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"proportion": 0.5}, "must lie between chance, 0.5 of a comparison, and 1"),
        ({"proportion": 0.3, "alternatives": 3}, "chance, 0.333333 of 3 alternatives"),
        ({"proportion": float("nan")}, "proportion"),
        ({"alternatives": 1}, "at least 2 alternatives"),
        ({"alternatives": 2, "guess": 0.1}, "a forced choice has its own"),
        ({"guess": 0.7}, "guess: 0.7 must lie"),
        ({"lapse": -0.1}, "lapse: -0.1 must lie"),
        ({"reference": 0.0}, "must be a level above 0"),
        ({"confidence": 1.0}, "confidence"),
        ({"method": "bayes"}, "valid are likelihood, psignifit"),
        ({"method": "psignifit", "lapse": None}, "psignifit fits guesses and lapses itself"),
    ],
)
def test_what_cannot_be_asked_is_refused(options: dict[str, object], told: str) -> None:
    with pytest.raises(hs.SceneError, match=told):
        hs.jnd(DATA, **options)


# For a scene.


@pytest.mark.slow
def test_the_line_for_a_scene_is_one_with_the_interval_as_its_range_and_its_proportion() -> None:
    found = hs.jnd(DATA, reference=5)
    own = 'environment = { model = "mass-spring-damper", k = 1 }\n'
    threshold = hs.parse_scene(f"{own}[evaluation]\n{found.line}\n").threshold
    assert float(threshold.real) == pytest.approx(found.jnd.value / 5, rel=1e-3)
    low, high = threshold.real_interval
    assert float(low) <= found.fraction.low < found.fraction.high <= float(high)
    assert threshold.imag_interval == (low, high)
    lines = [
        line.strip().strip("`")
        for line in str(found).split("In a scene")[1].split("The curve")[0].split("\n")
        if line.strip()
    ]
    assert hs.parse_scene(own + "\n".join(lines)).threshold == threshold
    there = threshold.at_proportion("0.84")  # as another fit at that proportion has it
    assert float(there.real) == pytest.approx(hs.jnd(DATA, reference=5, proportion=0.84).fraction.value, rel=1e-3)


def test_the_line_of_a_forced_choice_tells_no_proportion_that_could_be_converted() -> None:
    rows = tuple(Row(0.04 * i, k, 40) for i, k in enumerate((20, 24, 31, 36, 40)))
    found = hs.jnd(Answers("choices", rows), alternatives=2, reference=1)
    assert "proportion" not in found.table
    with pytest.raises(hs.SceneError, match="does not tell its own"):
        hs.parse_scene(
            f'environment = {{ model = "mass-spring-damper", k = 1 }}\n[evaluation]\n{found.line}\n'
        ).threshold.at_proportion("0.84")


def test_the_command_says_the_same_as_python(file: Callable[..., Path], tmp_path: Path) -> None:
    path, picture = file(TABLE), tmp_path / "a.svg"
    done = CliRunner().invoke(app, ["jnd", str(path), "--reference", "5", "--json", "--figure", str(picture)])
    assert done.exit_code == 0
    document = json.loads(done.stdout)
    assert document == hs.jnd(path, reference=5).to_dict()
    assert (document["schema"], document["certified"]) == ("haptisym.jnd/1", False)
    assert picture.read_text().startswith("<?xml")


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(6))
def test_no_curve_is_likelier_than_the_one_that_is_found(seed: int) -> None:
    """Without guesses and lapses minus the log-likelihood is convex in a and b of Phi(a + b x): it has one bottom."""
    draw = np.random.default_rng(seed)
    for _ in range(8):
        many = int(draw.integers(2, 9))
        levels = np.sort(draw.choice(np.arange(1, 300), many, replace=False)) / 100
        spread = (levels[-1] - levels[0]) * 10 ** draw.uniform(-1.3, 1.2)
        trials = draw.integers(3, 60, many)
        shares = ndtr((levels - draw.uniform(levels[0], levels[-1])) / spread)
        counts = draw.binomial(trials, shares)
        found = Likelihood(rows_of(levels, counts, trials), 0, 0.0).best()
        if not (found.steep or found.flat or found.outside):
            assert found.loss <= convex_bottom(levels, counts, trials) + 1e-7


def rows_of(levels: Array, counts: Array, trials: Array) -> tuple[Row, ...]:
    return tuple(Row(float(x), int(k), int(n)) for x, k, n in zip(levels, counts, trials, strict=True))


def convex_bottom(levels: Array, counts: Array, trials: Array) -> float:
    """The least loss, by a search without slopes."""
    x = (levels - levels.mean()) / (levels[-1] - levels[0])

    def lost(line: Array) -> float:
        z = line[0] + line[1] * x
        return -float((counts * log_ndtr(z) + (trials - counts) * log_ndtr(-z)).sum())

    return float(minimize(lost, [0, 1], method="Nelder-Mead", options={"xatol": 1e-9, "fatol": 1e-11}).fun)


def test_a_flat_curve_beside_close_levels_is_found() -> None:
    rows = (Row(1.15, 6, 14), Row(1.33, 10, 16), Row(1.34, 17, 34))
    found = Likelihood(rows, 0, 0.0).best()
    assert found.curve.sigma == pytest.approx(0.7107969972, rel=1e-9)
    assert found.loss == pytest.approx(44.0902272396582, abs=1e-12)
