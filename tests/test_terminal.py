"""Every verb as it meets terminals."""

from __future__ import annotations

import pytest
from terminal import all_in_terminal

CALLS = [
    ("evaluate", "fu2019"),
    ("derive", "fu2019"),
    ("effects", "sidestick"),
    ("require", "fu2019", "--free", "zeta"),
    ("sensitivity", "fu2019"),
    ("tolerances", "fu2019-tolerances", "--samples", "20"),
    ("sweep", "fu2019", "--vary", "effects.filter.omega_n=40:200:3"),
    ("metrics", "fu2019"),
    ("cost", "fu2019", "--quick"),
    ("simulate", "fu2019"),
    ("scenes",),
]
"""Each verb, as quick as it gets."""


@pytest.mark.parametrize("columns", [120, pytest.param(40, marks=pytest.mark.slow)])
def test_every_verb_answers_in_a_terminal(columns: int) -> None:
    for words, shown in zip(CALLS, all_in_terminal(CALLS, columns=columns), strict=True):
        assert shown.status == 0, (words, shown.text)
        assert len(shown.screen) > 3, words
        assert "Traceback" not in shown.text, words


def test_a_bar_of_progress_leaves_nothing_behind() -> None:
    [shown] = all_in_terminal([("sweep", "delayed-spring", "--vary", "effects.delay.tau=0.001:0.1:200")], columns=40)
    assert shown.status == 0
    assert " sets" in shown.text
    assert shown.screen[0].startswith("Delayed spring")
