"""Small wrong changes are planted where they should be, the same ones every time, and noticed by a test that reaches them."""

from __future__ import annotations

import ast
import json
import subprocess
import sys
from dataclasses import asdict
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

pytest.importorskip("resource", reason="mutants are planted where processes fork")

from tests import mutants

ROOT = Path(__file__).parents[2]
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


def test_what_was_not_noticed_is_found_again_where_it_stands_now(root: Path) -> None:
    drawn, file = mutants.drawn(root, "kernel", 1, 4), root / "tried.jsonl"
    verdicts = ("noticed", "not noticed", "endless", "not reached")
    rows = ({**asdict(x), "verdict": verdict} for x, verdict in zip(drawn, verdicts, strict=True))
    file.write_text("".join(json.dumps(row) + "\n" for row in rows), encoding="utf-8")
    module = root / mutants.SOURCE / "kernel" / "sums.py"
    module.write_text("# a comment\n" + MODULE, encoding="utf-8")
    found = mutants.left(root, "kernel", file)
    asked = {(x.line, x.text) for x in found}
    assert {(drawn[i].line + 1, drawn[i].text) for i in (1, 3)} <= asked
    assert not {(drawn[i].line + 1, drawn[i].text) for i in (0, 2)} & asked


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
        {"a.py::1": 2.0, "a.py::2": 0.5, "a.py::3": 1.0, "b.py::1": 0.1}, [], [],
    )  # fmt: skip
    change = mutants.Mutant("kernel/sums.py", "total", "constant", 1, 0, 1, "2")
    assert known.near(change.module, change.function) == ["a.py::3", "a.py::1"]
    assert known.taken(known.near(change.module, change.function), 3.6) == ["a.py::3", "a.py::1", "a.py::2"]
    assert known.taken(known.near(change.module, change.function), 2.0) == ["a.py::3", "a.py::2"]


def test_slow_tests_are_asked_about_what_no_quick_one_noticed_alone(
    root: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    given: Any = SimpleNamespace(again=None, seed=1, count=3, only="", seconds=1.0, slow=1.0, out=None)
    asked: list[mutants.Mutant] = []
    monkeypatch.setattr(mutants, "noticed_slowly", lambda _, mutant, *__: (asked.append(mutant), "a slow one")[1])
    for word, told in (
        ("noticed", ("noticed", "a quick one")), ("endless", ("endless", "a quick one")), ("not noticed", ("noticed", "a slow one")), ("not reached", ("noticed", "a slow one")),
    ):  # fmt: skip
        asked.clear()
        monkeypatch.setattr(mutants, "noticed", lambda *_, word=word: (word, "a quick one"))
        rows = list(mutants.tried(root, "kernel", mutants.Known({}, {}, [], []), given))
        assert set(rows) == {told}
        assert len(asked) == (len(rows) if told[1] == "a slow one" else 0)


@pytest.mark.slow
def test_a_change_that_a_test_reaches_is_noticed_in_a_copy_and_the_source_is_left_alone(tmp_path: Path) -> None:
    before = {path: path.read_bytes() for path in (ROOT / mutants.SOURCE).rglob("*.py")}
    done = subprocess.run(
        [sys.executable, "-m", "tests.mutants", "kernel", "--only", "kernel/schurcohn.py", "--count", "2", "--seed", "1",
         "--known", str(tmp_path / "known.json"), "--tests", "tests/kernel/test_sampled_loops.py"],
        cwd=ROOT, capture_output=True, text=True, check=False, timeout=900,
    )  # fmt: skip
    assert done.returncode in (0, 1), done.stderr
    assert "of 2 noticed, seed 1" in done.stdout
    assert before == {path: path.read_bytes() for path in before}
