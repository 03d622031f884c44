"""The fuzz writes down what is wrong so that it can be asked again; small wrong changes are planted where they should be."""

from __future__ import annotations

import ast
import json
import runpy
from pathlib import Path

import pytest

pytest.importorskip("resource", reason="mutants are planted where processes fork")

from tests import fuzz, mutants

import haptisym as hs


@pytest.mark.slow
@pytest.mark.core
def test_every_verb_is_right_about_scenes_of_each_kind(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert fuzz.main(["--count", "4", "--minutes", "5", "--keep", str(tmp_path)]) == 0
    assert "seeds 0 to 3, 0 wrong" in capsys.readouterr().out
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
@pytest.mark.core
def test_an_oracle_that_denies_an_answer_leaves_a_scene_to_ask_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(fuzz.Sampled, "sizes", lambda _: fuzz.np.array([2.0] * 40))  # of the oracle's own
    assert fuzz.main(["--seed", "7", "--count", "1", "--only", "sampled", "--keep", str(tmp_path)]) == 1
    assert "again: python -m tests.fuzz --seed 7 --only sampled --count 1" in capsys.readouterr().out
    [written] = tmp_path.iterdir()
    assert written.read_text(encoding="utf-8").startswith("# AssertionError")
    assert hs.stability(hs.load_scene(written)).held[0].unstable is not None


MODULE = '''
"""Sums."""

def total(numbers, scale=2):
    """2 + 2 is 4."""
    if not numbers:
        raise ValueError("1 + 1")
    for x in numbers:
        scale += abs(x)
    return scale * max(numbers) - numbers[0]
'''


@pytest.fixture
def root(tmp_path: Path) -> Path:
    folder = tmp_path / mutants.SOURCE / "kernel"
    folder.mkdir(parents=True)
    (folder / "sums.py").write_text(MODULE, encoding="utf-8")
    return tmp_path


def test_every_change_is_one_of_the_code_and_leaves_a_program(root: Path) -> None:
    found = mutants.Places(root, "kernel/sums.py").found
    for mutant in found:
        changed = mutant.planted(MODULE.encode()).decode()
        ast.parse(changed)
        assert ast.dump(ast.parse(changed)) != ast.dump(ast.parse(MODULE))
        assert ('"""2 + 2 is 4."""' in changed) & ("1 + 1" in changed)
        assert mutant.function == "total"
    texts = {mutant.text for mutant in found}
    assert {"3", "(numbers)", "pass", "scale -= abs(x)", "(x)", "min", "(scale * max(numbers))"} <= texts


def test_what_only_asserts_or_is_for_types_is_left_as_it_is(root: Path) -> None:
    text = "if TYPE_CHECKING:\n    a = 1 + 1\nb = list(zip('x', 'y', strict=True))\nc = sorted([2], reverse=True)\n"
    (root / mutants.SOURCE / "kernel" / "types.py").write_text(text, encoding="utf-8")
    found = mutants.Places(root, "kernel/types.py").found
    assert {mutant.line for mutant in found} == {4}
    assert "False" in {mutant.text for mutant in found}


def test_a_seed_draws_the_same_changes_again_and_never_two_of_a_line(root: Path) -> None:
    first, again, other = (mutants.drawn(root, "kernel", seed, 4) for seed in (1, 1, 2))
    assert first == again != other
    assert len({mutant.line for mutant in first}) == len(first) == 4


def test_the_checker_beside_the_program_is_a_folder_too(root: Path) -> None:
    beside = root / "src" / mutants.CHECKER
    beside.mkdir()
    (beside / "sums.py").write_text(MODULE, encoding="utf-8")
    assert mutants.modules(root, mutants.CHECKER) == ["haptisym_check/sums.py"]
    assert mutants.modules(root, ".") == ["kernel/sums.py"]
    here, there = (mutants.drawn(root, x, 1, 3) for x in ("kernel", mutants.CHECKER))
    assert {x.module for x in here} == {"kernel/sums.py"}
    assert {x.module for x in there} == {"haptisym_check/sums.py"}
    assert mutants.told(root, there[0]).startswith("haptisym_check/sums.py:")
    assert set(mutants.PROVING) >= {mutants.CHECKER, "verbs/evaluate", "verbs/stability"}


def test_tests_that_reach_a_function_are_asked_first_and_the_quickest_before_others() -> None:
    known = mutants.Known(
        {"a.py::1": ["kernel/sums.py:total"], "a.py::2": [], "a.py::3": ["kernel/sums.py:total"], "b.py::1": ["kernel/sums.py:totals"]},
        {"a.py::1": 2.0, "a.py::2": 0.5, "a.py::3": 1.0, "b.py::1": 0.1}, [],
    )  # fmt: skip
    change = mutants.Mutant("kernel/sums.py", "total", "constant", 1, 0, 1, "2")
    assert known.near(change.module, change.function) == ["a.py::3", "a.py::1"]
    assert known.taken(known.near(change.module, change.function), 3.6) == ["a.py::3", "a.py::1", "a.py::2"]
    assert known.taken(known.near(change.module, change.function), 2.0) == ["a.py::3", "a.py::2"]


def test_what_became_slower_is_listed_in_times_of_the_machine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    benchmarks = Path(__file__).parents[2] / "benchmarks"
    monkeypatch.syspath_prepend(benchmarks)
    slower = runpy.run_path(str(benchmarks / "all.py"))["slower"]

    def ran(day: int, commit: str, unit: float, **seconds: float) -> None:
        run = {"date": f"2026-11-{day}", "commit": commit, "scripts": {"sweep": {"unit": unit, "seconds": seconds}}}
        (tmp_path / f"{run['date']}-{commit}.json").write_text(json.dumps(run), encoding="utf-8")

    ran(28, "ffff", 0.1, alike=1.0, longer=1.0, gone=1.0)
    assert [*slower(tmp_path)] == []
    # The machine, too, is half as fast as before.
    ran(29, "aaaa", 0.2, alike=2.1, longer=2.4, new=9.0)
    assert [*slower(tmp_path)] == ["  1.20 times  sweep: longer  (2026-11-28 ffff -> 2026-11-29 aaaa)"]
    # Another script alone: the last two runs of the first one are compared as before.
    other = {"date": "2026-11-30", "commit": "bbbb", "scripts": {"cost": {"unit": 0.1, "seconds": {"alike": 9.0}}}}
    (tmp_path / "2026-11-30-bbbb.json").write_text(json.dumps(other), encoding="utf-8")
    assert len([*slower(tmp_path)]) == 1
