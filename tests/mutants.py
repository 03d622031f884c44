"""Small wrong changes of the source, and whether the tests notice them: ``python -m tests.mutants kernel judge --count 15 --seed 1``.

A change (a mutant) is planted in a copy of the checkout, and the quick tests that reach the changed function are run there, the
quickest first, until one fails. What is printed is the share that was noticed, and each change that was not: either it changes no answer,
or a test is missing. Which test reaches which function is found by one run of the tests, kept in ``build/reached.json`` and made anew
with ``--map``. A thermometer, no goal. Needs a system with ``fork``.
"""

from __future__ import annotations

import argparse
import ast
import importlib
import json
import os
import random
import resource
import shutil
import signal
import sys
import tempfile
import time
import traceback
from collections.abc import Callable, Iterator
from compileall import compile_dir
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from importlib.util import cache_from_source
from pathlib import Path
from py_compile import PycInvalidationMode
from typing import Any

import pytest

ROOT = Path(__file__).parents[1]
SOURCE = "src/haptisym"
CHECKER = "haptisym_check"
PROVING = (
    "kernel",
    "programs",
    "judge",
    "verbs/evaluate",
    "verbs/sweep",
    "verbs/tolerances",
    "verbs/effects",
    "verbs/require",
    "verbs/stability",
    CHECKER,
)
"""The folders whose answers are called proven; the checker of certificates lies beside the program."""
ASKED = (
    "tests/kernel",
    "tests/programs",
    "tests/judge",
    "tests/model",
    "tests/verbs",
    "tests/commands",
    "tests/writing",
    "src",
)
"""The tests that are asked: not those of how the source is written, of pages and of pictures."""
LOADED = ("numpy", "sympy", "flint", "scipy.optimize", "mpmath", "pint", "click", "rich.console", "matplotlib.figure")
"""What every run of tests imports, imported once before it is forked."""

SWAPPED = {
    "min": "max",
    "any": "all",
    "upper": "lower",
    "ceil": "floor",
    "minimum": "maximum",
    "fmin": "fmax",
    "low": "high",
    "lo": "hi",
}
SWAPPED |= {b: a for a, b in SWAPPED.items()}
COMPARED: dict[type[ast.cmpop], type[ast.cmpop]] = {
    ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq,
    ast.In: ast.NotIn, ast.NotIn: ast.In, ast.Is: ast.IsNot, ast.IsNot: ast.Is,
}  # fmt: skip
COMPUTED: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.FloorDiv: ast.Div, ast.Pow: ast.Mult,
    ast.BitOr: ast.BitAnd, ast.BitAnd: ast.BitOr, ast.LShift: ast.RShift, ast.RShift: ast.LShift,
}  # fmt: skip


@dataclass(frozen=True)
class Mutant:
    """One change: these bytes of a module are another text; ``function`` is the one it lies in, "" outside of all."""

    module: str
    function: str
    kind: str
    line: int
    start: int
    end: int
    text: str

    def planted(self, source: bytes) -> bytes:
        return source[: self.start] + self.text.encode() + source[self.end :]


def place_of(root: Path, module: str) -> Path:
    """Where a module lies, or a folder of them."""
    return root / ("src" if module.split("/")[0] == CHECKER else SOURCE) / module


def modules(root: Path, folder: str) -> list[str]:
    """The modules of a folder, as ``kernel/roots.py``."""
    inside = place_of(root, folder)
    return sorted(f"{folder}/{path.relative_to(inside)}".removeprefix("./") for path in inside.rglob("*.py"))


# What can go wrong at a node of the syntax tree: a kind, the node that is replaced, and by what


def _wrong(node: ast.AST) -> Iterator[tuple[str, ast.AST, str]]:
    if isinstance(node, ast.expr):
        yield from _wrong_value(node)
    elif isinstance(node, ast.If | ast.While):
        yield "branch", node.test, f"(False and ({ast.unparse(node.test)}))"
        yield "not", node.test, f"(not ({ast.unparse(node.test)}))"
    elif isinstance(node, ast.AugAssign):
        yield "left out", node, "pass"
        if other := COMPUTED.get(type(node.op)):
            yield "operation", node, ast.unparse(ast.AugAssign(node.target, other(), node.value))
    elif isinstance(node, ast.Continue | ast.Break) or (
        isinstance(node, ast.Expr) and isinstance(node.value, ast.Call)
    ):
        yield "left out", node, "pass"


def _wrong_value(node: ast.expr) -> Iterator[tuple[str, ast.AST, str]]:
    match node:
        case ast.Compare(left, [operator], [right]) if other := COMPARED.get(type(operator)):
            yield "comparison", node, f"({ast.unparse(ast.Compare(left, [other()], [right]))})"
        case ast.BinOp(left, ast.Add() | ast.Sub(), right) if not isinstance(
            right, ast.JoinedStr | ast.List | ast.Tuple
        ):
            yield "operation", node, f"({ast.unparse(ast.BinOp(left, COMPUTED[type(node.op)](), right))})"
            yield "addend", node, f"({ast.unparse(left)})"
        case ast.BinOp(left, operator, right) if other := COMPUTED.get(type(operator)):
            yield "operation", node, f"({ast.unparse(ast.BinOp(left, other(), right))})"
        case ast.BoolOp(operator, values):
            switched = ast.Or() if isinstance(operator, ast.And) else ast.And()
            yield "logic", node, f"({ast.unparse(ast.BoolOp(switched, values))})"
            yield "condition", node, f"({ast.unparse(ast.BoolOp(operator, values[:-1]) if values[2:] else values[0])})"
        case ast.UnaryOp(ast.Not() | ast.USub() | ast.Invert(), operand) if not isinstance(operand, ast.Constant):
            yield "not" if isinstance(node.op, ast.Not) else "sign", node, f"({ast.unparse(operand)})"
        case ast.IfExp(_, body, orelse):
            yield "branch", node, f"({ast.unparse(body)})"
            yield "branch", node, f"({ast.unparse(orelse)})"
        case ast.Constant(bool()):
            yield "constant", node, str(not node.value)
        case ast.Constant(int()):
            yield "constant", node, str(node.value + 1)
        case ast.Constant(float()):
            yield "constant", node, repr(2 * node.value or 1.0)
        case ast.Attribute(value, name) if name in SWAPPED:
            yield "end", node, f"{ast.unparse(value)}.{SWAPPED[name]}"
        case ast.Call(ast.Name("abs"), [argument]):
            yield "abs", node, f"({ast.unparse(argument)})"
        case ast.Call(ast.Name(name), _) if name in SWAPPED:
            yield "end", node.func, SWAPPED[name]
        case ast.ListComp(_, [*_, ast.comprehension(ifs=[_, *_])]) | ast.GeneratorExp(
            _, [*_, ast.comprehension(ifs=[_, *_])]
        ):
            for condition in node.generators[-1].ifs:
                yield "condition", condition, "True"


def _is_for_types(node: ast.AST) -> bool:
    return isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"


class Places(ast.NodeVisitor):
    """All changes of a module; what is raised, asserted, printed for people, annotated or imported is left as it is."""

    def __init__(self, root: Path, module: str) -> None:
        self.module, self.source = module, place_of(root, module).read_bytes()
        lines = self.source.splitlines(keepends=True)
        self.starts = [sum(map(len, lines[:n])) for n in range(len(lines))]
        self.within, self.function = list[str](), ""
        self.found: list[Mutant] = []
        for statement in ast.parse(self.source).body:
            self.visit(statement)

    def visit(self, node: ast.AST) -> None:
        for kind, place, text in () if _is_for_types(node) else _wrong(node):
            start = self.starts[place.lineno - 1] + place.col_offset  # type: ignore[attr-defined]
            end = self.starts[place.end_lineno - 1] + place.end_col_offset  # type: ignore[attr-defined]
            mutant = Mutant(self.module, self.function, kind, node.lineno, start, end, text)  # type: ignore[attr-defined]
            self.found.append(mutant)
        super().visit(node)

    def visit_FunctionDef(self, node: ast.FunctionDef) -> None:
        if node.name in ("__repr__", "__str__", "_repr_html_", "_repr_latex_"):
            return
        outer, self.function = self.function, self.function or ".".join([*self.within, node.name])
        for part in (*node.args.defaults, *filter(None, node.args.kw_defaults), *node.body):
            self.visit(part)
        self.function = outer

    def visit_ClassDef(self, node: ast.ClassDef) -> None:
        self.within.append(node.name)
        for part in node.body:
            self.visit(part)
        self.within.pop()

    def visit_AnnAssign(self, node: ast.AnnAssign) -> None:
        if node.value is not None:
            self.visit(node.value)

    def visit_Call(self, node: ast.Call) -> None:
        if ast.unparse(node.func).split(".")[-1] not in ("dataclass", "lru_cache", "TypeVar", "NewType"):
            self.generic_visit(node)

    def visit_keyword(self, node: ast.keyword) -> None:
        if node.arg != "strict":  # of zip: an assertion
            self.visit(node.value)

    def visit_If(self, node: ast.If) -> None:
        if not _is_for_types(node):
            self.generic_visit(node)

    def nothing(self, node: ast.AST) -> None: ...

    visit_Raise = visit_Assert = visit_Import = visit_ImportFrom = visit_JoinedStr = nothing


def drawn(root: Path, folder: str, seed: int, count: int) -> list[Mutant]:
    """So many changes of a folder: a kind by lot, then one of it; no line twice, and each leaves a program."""
    pool: dict[str, list[Mutant]] = {}
    for module in modules(root, folder):
        for mutant in Places(root, module).found:
            pool.setdefault(mutant.kind, []).append(mutant)
    pick, found = random.Random(f"{folder} {seed}"), dict[tuple[str, int], Mutant]()
    while len(found) < count and any(pool.values()):
        kind = pick.choice(sorted(name for name, left in pool.items() if left))
        mutant = pool[kind].pop(pick.randrange(len(pool[kind])))
        with suppress(SyntaxError):
            ast.parse(mutant.planted(place_of(root, mutant.module).read_bytes()))
            found.setdefault((mutant.module, mutant.line), mutant)
    return list(found.values())


# The copy, and tests that are run in it


_LEFT_BEHIND = ("build", "dist", "__pycache__", "*.egg-info", ".git", ".venv", ".*_cache", ".hypothesis", ".benchmarks")


@contextmanager
def copied() -> Iterator[Path]:
    """A copy of the checkout as it is, compiled."""
    with tempfile.TemporaryDirectory() as name:
        shutil.copytree(ROOT, name, dirs_exist_ok=True, ignore=shutil.ignore_patterns(*_LEFT_BEHIND))
        compiled(Path(name))
        yield Path(name)


def compiled(root: Path) -> None:
    """A run then compiles only what was changed."""
    compile_dir(root / "src", quiet=2, workers=1, invalidation_mode=PycInvalidationMode.UNCHECKED_HASH)


class Chosen:
    """Which tests are run and in which order, and what they did."""

    def __init__(self, order: Callable[[str], float | None]) -> None:
        self.order = order
        self.seconds: dict[str, float] = {}
        self.failed: list[str] = []

    def pytest_collection_modifyitems(self, config: pytest.Config, items: list[pytest.Item]) -> None:
        ranked = {item: self.order(item.nodeid) for item in items}
        config.hook.pytest_deselected(items=[item for item, rank in ranked.items() if rank is None])
        items[:] = sorted((x for x, rank in ranked.items() if rank is not None), key=lambda x: ranked[x] or 0.0)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        self.seconds[report.nodeid] = self.seconds.get(report.nodeid, 0.0) + report.duration
        if report.failed:
            self.failed.append(report.nodeid)

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        if report.failed:
            self.failed.append(report.nodeid or "collection")


def in_a_fork(root: Path, seconds: float, work: Callable[[], Any]) -> Any:
    """What a function gives in a process of its own, in the copy; None if it dies, or takes more than so many seconds of a processor."""
    answer = root / "answer.json"
    answer.unlink(missing_ok=True)
    child = os.fork()
    if child == 0:
        try:
            os.setsid()
            resource.setrlimit(resource.RLIMIT_CPU, (int(seconds), int(seconds) + 5))
            _moved(root)
            answer.write_text(json.dumps(work()))
        except BaseException:  # noqa: BLE001  it is told where the output goes
            traceback.print_exc()
            sys.stderr.flush()
        finally:
            os._exit(0)
    end = time.monotonic() + 8 * seconds  # for what waits: other processes use processors too
    while not os.waitpid(child, os.WNOHANG)[0]:
        time.sleep(0.05)
        if time.monotonic() > end:
            os.killpg(child, signal.SIGKILL)
    return json.loads(answer.read_text()) if answer.exists() else None


def _moved(root: Path) -> None:
    """This process imports from the copy, and is silent."""
    os.chdir(root)
    sys.path[:] = [str(root / "src"), str(root), *(x for x in sys.path if Path(x or ".").resolve() != ROOT)]
    os.environ["PYTHONPATH"] = str(root / "src")
    with (root / "said.txt").open("wb") as said:
        os.dup2(said.fileno(), 1)
        os.dup2(said.fileno(), 2)


def tested(chosen: Chosen, *words: str) -> int:
    return int(pytest.main(["-q", "-p", "no:cacheprovider", "--tb=no", "--disable-warnings", *words], plugins=[chosen]))


# Which test reaches which function


class Noted(ast.NodeTransformer):
    """Functions that note that they were called; what lies inside of one is part of it."""

    def __init__(self, module: str, names: list[str]) -> None:
        self.module, self.names, self.within = module, names, list[str]()

    def visit_ClassDef(self, node: ast.ClassDef) -> ast.AST:
        self.within.append(node.name)
        self.generic_visit(node)
        self.within.pop()
        return node

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.AST:
        self.names.append(f"{self.module}:{'.'.join([*self.within, node.name])}")
        node.body.insert(
            ast.get_docstring(node) is not None, ast.parse(f"_noted_calls[{len(self.names) - 1}] = 1").body[0]
        )
        return node


def mapped() -> dict[str, Any]:
    """One run of all quick tests: ``reached`` tells of each test which functions it calls, ``seconds`` how long it takes; ``failed`` are not asked."""
    with copied() as root:
        names: list[str] = []
        for module in (*modules(root, "."), *modules(root, CHECKER)):
            path = place_of(root, module)
            tree = Noted(module, names).visit(ast.parse(path.read_bytes()))
            setup = ast.parse(
                "import sys\n_noted_calls = sys.__dict__.setdefault('_noted_calls', bytearray(10 ** 5))"
            ).body
            first = next((n for n, x in enumerate(tree.body) if not isinstance(x, ast.Expr | ast.ImportFrom)), 0)
            tree.body[first:first] = setup
            path.write_text(ast.unparse(ast.fix_missing_locations(tree)), encoding="utf-8")
        compiled(root)
        found = in_a_fork(root, 3 * 3600, lambda: _followed(names))
        return found or sys.exit(f"the run died: {(root / 'said.txt').read_text()[-2000:]}")


def _followed(names: list[str]) -> dict[str, Any]:
    called = sys.__dict__.setdefault("_noted_calls", bytearray(10**5))
    reached: dict[str, list[str]] = {}

    class Follows(Chosen):
        @pytest.hookimpl(wrapper=True)
        def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[None]:
            called[:] = bytes(len(called))
            given = yield
            reached[item.nodeid] = sorted({name for name, seen in zip(names, called, strict=False) if seen})
            return given  # type: ignore[return-value]

    follows = Follows(lambda _: 0.0)
    tested(follows, *ASKED)
    return {"reached": reached, "seconds": follows.seconds, "failed": follows.failed}


# The changes, one by one


MOST_FILES = 8
"""Of tests, for one change: to collect them takes its time."""


def file_of(test: str) -> str:
    return test.split("::")[0]


def reaches(name: str, key: str) -> bool:
    return name == key or (key.endswith(":") and name.startswith(key))


@dataclass(frozen=True)
class Known:
    """What the map tells."""

    reached: dict[str, list[str]]
    seconds: dict[str, float]
    failed: list[str]

    def near(self, module: str, function: str) -> list[str]:
        """The tests that reach a function ("": any of the module), in the files of those that reach the fewest others; the quickest first."""
        key = f"{module}:{function}"
        found = [x for x, names in self.reached.items() if any(reaches(name, key) for name in names)]
        narrow = list(dict.fromkeys(map(file_of, sorted(found, key=lambda test: len(self.reached[test])))))
        return sorted((test for test in found if file_of(test) in narrow[:MOST_FILES]), key=self.cost)

    def taken(self, near: list[str], most: float) -> list[str]:
        """These tests, and then their neighbours, as many as take so many seconds."""
        files = set(map(file_of, near))
        others = {x for x in self.reached if file_of(x) in files} - set(near)
        left, found = most, []
        for test in (*near, *sorted(others, key=self.cost)):
            if self.cost(test) < left and test not in self.failed:
                left -= self.cost(test)
                found.append(test)
        return found

    def cost(self, test: str) -> float:
        return self.seconds.get(test, 0.0)


def noticed(root: Path, mutant: Mutant, known: Known, most: float) -> tuple[str, str]:
    """``noticed``, ``endless``, ``not noticed`` or ``not reached``; and the test that failed."""
    near = known.near(mutant.module, mutant.function)
    if not near:
        return "not reached", ""
    taken = set(known.taken(near, most))
    chosen = Chosen(lambda test: known.cost(test) if test in taken else None)

    def run() -> tuple[int, list[str]]:
        return tested(chosen, "-x", *sorted(set(map(file_of, taken)))), chosen.failed

    with planted(root, mutant):
        answer = in_a_fork(root, 5 * sum(map(known.cost, taken)) + 60, run)
    if answer is None:
        return "endless", ""
    return ("noticed" if answer[0] else "not noticed"), (answer[1] or [""])[0]


@contextmanager
def planted(root: Path, mutant: Mutant) -> Iterator[None]:
    """The module is changed, and compiled by whoever imports it."""
    path = place_of(root, mutant.module)
    compiled_path = Path(cache_from_source(path))
    before = path.read_bytes(), compiled_path.read_bytes()
    try:
        path.write_bytes(mutant.planted(before[0]))
        compiled_path.unlink()
        yield
    finally:
        path.write_bytes(before[0])
        compiled_path.write_bytes(before[1])


def told(root: Path, mutant: Mutant) -> str:
    """Where a change is, and what it is."""
    source = place_of(root, mutant.module).read_bytes()
    old = " ".join(source[mutant.start : mutant.end].decode().split())
    return f"{mutant.module}:{mutant.line} {mutant.function}, {mutant.kind}: {old} -> {mutant.text}"


def main(words: list[str] | None = None) -> int:
    """The command line; status 1 where a change was not noticed."""
    parser = argparse.ArgumentParser(prog="python -m tests.mutants", description=__doc__)
    parser.add_argument(
        "folders", nargs="*", default=PROVING, help=f"of {SOURCE}, or {CHECKER}; those that prove, if none is given"
    )
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--count", type=int, default=12, help="of changes in each folder")
    parser.add_argument("--seconds", type=float, default=12.0, help="of tests for one change")
    parser.add_argument("--map", action="store_true", help="find anew which test reaches which function")
    parser.add_argument("--known", type=Path, default=ROOT / "build" / "reached.json", help="where that is kept")
    given = parser.parse_args(words)
    for name in LOADED:
        importlib.import_module(name)
    if given.map or not given.known.exists():
        given.known.parent.mkdir(exist_ok=True)
        given.known.write_text(json.dumps(mapped()), encoding="utf-8")
    known = Known(**json.loads(given.known.read_text(encoding="utf-8")))
    missed = 0
    with copied() as root:
        for folder in given.folders:
            found = []
            for mutant in drawn(root, folder, given.seed, given.count):
                word, test = noticed(root, mutant, known, given.seconds)
                found.append(word)
                print(f"  {word:12} {told(root, mutant)}  {test}", flush=True)
            seen = sum(word in ("noticed", "endless") for word in found)
            missed += len(found) - seen
            print(f"{folder}: {seen} of {len(found)} noticed, seed {given.seed}", flush=True)
    return missed > 0


if __name__ == "__main__":
    sys.exit(main())
