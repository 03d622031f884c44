"""What a measured just-noticeable difference is of: which curve, and a size."""

from __future__ import annotations

from pathlib import Path

import pytest
from scipy.stats import norm

import haptisym as hs

STAIR = [(0.5, "1111"), (0.4, "1111110"), (0.3, "111100"), (0.2, "0")]


def answers(folder: Path, rows: list[tuple[float, str]]) -> Path:
    path = folder / "answers.csv"
    lines = [f"{level},{x}" for level, given in rows for x in given]
    path.write_text("\n".join(["level,answer", *lines]), encoding="utf-8")
    return path


def test_a_jnd_of_a_forced_choice_is_a_size(tmp_path: Path) -> None:
    found = hs.jnd(answers(tmp_path, STAIR), alternatives=2, proportion=0.707, reference=1)
    assert found.jnd.value > 0
    assert found.jnd.low == 0
    assert found.to_dict()["fraction"]["interval"][0] == 0
    assert "-" not in str(found).partition("fit ")[0].partition("JND")[2].replace("—", "")


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
