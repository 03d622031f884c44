"""The fuzz finds what is wrong, tells how to see it again, and goes on where it stopped."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

import haptisym as hs

ROOT = Path(__file__).parents[2]


def fuzz(*words: str) -> tuple[int, str]:
    done = subprocess.run(
        [sys.executable, "-m", "tests.fuzz", *words], cwd=ROOT, capture_output=True, text=True, check=False, timeout=300
    )
    assert done.stderr == ""
    return done.returncode, done.stdout


@pytest.mark.slow
def test_every_verb_is_right_about_a_few_scenes_and_a_second_run_goes_on(tmp_path: Path) -> None:
    state = str(tmp_path / "state.json")
    status, out = fuzz("--count", "3", "--minutes", "5", "--state", state)
    assert status == 0, out
    assert "seeds 0 to 2, 0 wrong" in out
    assert json.loads(Path(state).read_text()) == {"next": 3, "failures": []}
    assert "seeds 3 to 3, 0 wrong" in fuzz("--count", "1", "--only", "evaluate", "--state", state)[1]


def test_what_is_wrong_is_found_and_told(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    from tests import fuzz as fuzzed

    right = hs.Evaluation.crossings.func  # type: ignore[attr-defined]
    monkeypatch.setattr(hs.Evaluation, "crossings", property(lambda e: right(e)[1:]))
    assert fuzzed.main(["--seed", "1", "--count", "4", "--only", "evaluate"]) == 1
    out = capsys.readouterr().out
    assert "Sturm counts" in out
    assert "again: python -m tests.fuzz --seed" in out
