"""The fuzz finds what is wrong, and writes it down so that it can be asked again."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests import fuzz

import haptisym as hs


@pytest.mark.slow
@pytest.mark.core
def test_every_verb_is_right_about_scenes_of_each_kind(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert fuzz.main(["--count", "4", "--minutes", "5", "--keep", str(tmp_path)]) == 0
    assert "seeds 0 to 3, 0 wrong" in capsys.readouterr().out
    assert list(tmp_path.iterdir()) == []


def test_an_oracle_that_denies_an_answer_leaves_a_scene_to_ask_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(fuzz.Sampled, "sizes", lambda _: fuzz.np.array([2.0] * 40))  # of the oracle's own
    assert fuzz.main(["--seed", "7", "--count", "1", "--only", "sampled", "--keep", str(tmp_path)]) == 1
    assert "again: python -m tests.fuzz --seed 7 --only sampled --count 1" in capsys.readouterr().out
    [written] = tmp_path.iterdir()
    assert written.read_text(encoding="utf-8").startswith("# AssertionError")
    assert hs.stability(hs.load_scene(written)).held[0].unstable is not None
