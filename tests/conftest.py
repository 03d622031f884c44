"""One Hypothesis profile for the whole suite, the same examples on every machine and every run; and the command line, called.

With HAPTISYM_EXAMPLES=N there are N examples (where a test wants more, as many as it wants), drawn with the seed that
``pytest --hypothesis-seed`` gives: CI does that with one of each commit's own, and says which.
"""

from __future__ import annotations

import gc
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from threading import current_thread, main_thread
from typing import Any
from zlib import crc32

os.environ.setdefault("SYMPY_CACHE_SIZE", "20000")  # many scenes in one process
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # matrices are small: a second thread waits at full speed

# Several processes run the tests, and tests start the command many times: without bytecode on disk each of
# them would compile anew what it imports. So it is written here, also where Python was asked not to.
if os.environ.pop("PYTHONDONTWRITEBYTECODE", None):
    sys.dont_write_bytecode = False

import pytest
from hypothesis import HealthCheck, settings
from marks import EXAMPLES
from schemas import IS_THERE, faults, parsed

from haptisym.cli import main

gc.set_threshold(50_000, 20, 50)  # the collector of garbage walked through ten thousand tests again and again

settings.register_profile(
    "drawn" if EXAMPLES else "repeatable",
    derandomize=not EXAMPLES,
    deadline=None,
    max_examples=EXAMPLES or 6,
    database=None,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("drawn" if EXAMPLES else "repeatable")


SHARES = 8

DOCSTRINGS = {
    "haptisym.figures.requirement.requirement",
    "haptisym.figures.requirement.slices",
    "haptisym.figures.simulate.release",
    "haptisym.figures.stability.enclosures",
    "haptisym.figures.stability.hand_plane",
    "haptisym.figures.stability.held",
    "haptisym.figures.sweep.curves",
    "haptisym.pages.report.page",
    "haptisym.verbs.cost.entry.cost",
    "haptisym.verbs.family.answers.answer_each",
    "haptisym.verbs.identify.entry.identify",
    "haptisym.verbs.require.designmap.design_map",
    "haptisym.verbs.simulate.release.release",
    "haptisym.verbs.stability.limitcycles.limit_cycles",
    "haptisym.verbs.tolerances.proofs.Tolerances",
}
"""Docstrings whose examples are slow: a mark cannot be put on them."""


def pytest_addoption(parser: pytest.Parser) -> None:
    """Of the slow tests those that are marked ``core`` and one of eight shares of the others are run, the next one with each commit."""
    word = "which share of the slow tests, a number (how many commits there are if none is given), or all"
    parser.addoption("--share", default="", metavar="N", help=word)


def pytest_configure(config: pytest.Config) -> None:
    share = config.option.share or commits()
    if share != "all" and not share.isdecimal():
        raise pytest.UsageError(f"--share {share}: which share is a number, or all")
    config.option.share = share if share == "all" else str(int(share) % SHARES)  # the processes are given it, too
    config.pluginmanager.register(EachTest(), "each-test")


@cache
def commits() -> str:
    """How many there are in the checkout; 0 outside of one."""
    asked = ["git", "rev-list", "--count", "HEAD"]
    try:
        found = subprocess.run(asked, capture_output=True, text=True, cwd=Path(__file__).parent)
    except OSError:
        return "0"
    return found.stdout.strip() or "0"


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Of a family marked ``few(n)`` n cases, chosen by their names, or those that are named, are quick; the others are slow,
    and so are the cases that ``dear`` names.

    Of the slow ones those that are marked ``core`` are kept, and a share.
    """
    whole = not config.option.file_or_dir
    if whole and (gone := DOCSTRINGS - {x.name for x in items}):
        raise pytest.UsageError(
            f"tests/conftest.py names what is no docstring with an example any more: {sorted(gone)}"
        )
    families: dict[str, list[pytest.Item]] = {}
    dear: dict[str, set[str]] = {}
    for item in items:
        family, _, case = item.nodeid.partition("[")
        named = {x for mark in item.iter_markers("dear") for x in mark.args}
        if item.name in DOCSTRINGS or case[:-1] in named:
            item.add_marker(pytest.mark.slow)
        if named:
            dear[family] = dear.get(family, named) - {case[:-1]}
        if item.get_closest_marker("few"):
            families.setdefault(item.nodeid.partition("[")[0], []).append(item)
    if whole and (gone := {x: y for x, y in dear.items() if y}):
        raise pytest.UsageError(f"marked dear are what is no case any more: {gone}")
    for cases in families.values():
        quick = set(cases_of(cases, next(cases[0].iter_markers("few")).args))
        if not quick and not any("[" in word for word in config.args):
            raise pytest.UsageError(f"{cases[0].nodeid}: no case has a name that it is marked few with")
        for item in cases:
            if item not in quick:
                item.add_marker(pytest.mark.slow)
    if config.option.share != "all" and not any("::" in word for word in config.args):  # what has a name is asked for
        share = dealt([x for x in items if x.get_closest_marker("slow") and not x.get_closest_marker("core")])
        left_out = [item for item in items if share.get(item, config.option.share) != config.option.share]
        items[:] = [item for item in items if share.get(item, config.option.share) == config.option.share]
        config.hook.pytest_deselected(items=left_out)


def dealt(slow: list[pytest.Item]) -> dict[pytest.Item, str]:
    """Which share each test is of. The cases of a function are dealt out in turn, from a share on that its name draws.

    So each share has as many of each, and takes about as long as another; all eight together hold every test.
    """
    families: dict[str, list[pytest.Item]] = {}
    for item in sorted(slow, key=lambda item: crc32(item.nodeid.encode())):
        families.setdefault(item.nodeid.partition("[")[0], []).append(item)
    return {
        item: str((crc32(family.encode()) + turn) % SHARES)
        for family, cases in families.items()
        for turn, item in enumerate(cases)
    }


def cases_of(cases: list[pytest.Item], wanted: tuple[object, ...]) -> list[pytest.Item]:
    """Those whose name between the brackets is wanted; of a number so many, by a hash of their names."""
    if wanted and isinstance(wanted[0], int):
        return sorted(cases, key=lambda item: crc32(item.nodeid.encode()))[: wanted[0]]
    named = {item.nodeid.partition("[")[2][:-1]: item for item in cases}
    return [named[name] for name in map(str, wanted) if name in named]


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """Several processes share the files, not the tests: what the tests of a file have in common is computed once.

    The quick ones in their own order, in which the small ones come last, so that all processes end together; of the slow
    ones those files first that have the most.
    """
    from xdist.scheduler import LoadFileScheduling

    config.option.loadscopereorder = config.option.markexpr != "not slow"
    return LoadFileScheduling(config, log) if config.getvalue("dist") == "load" else None


LIMITS = {"ITIMER_PROF": (120.0, 600.0), "ITIMER_REAL": (900.0, 1800.0)}
"""Seconds that a quick test and a slow one may take: of this process's time, which is the same whatever else runs, and of
the clock, for those that wait for another process for ever."""


@contextmanager
def limited(item: pytest.Item) -> Iterator[None]:
    """Within this a test that takes too long fails; where timers are POSIX's and Python's main thread runs the tests."""
    if not hasattr(signal, "setitimer") or current_thread() is not main_thread():
        yield
        return
    is_slow = item.get_closest_marker("slow") is not None
    signals = {"ITIMER_PROF": signal.SIGPROF, "ITIMER_REAL": signal.SIGALRM}
    before = {}
    for timer, seconds in LIMITS.items():
        most, number = seconds[is_slow], signals[timer]

        def over(*_: object, most: float = most, timer: str = timer) -> None:
            kind = "processor time" if timer == "ITIMER_PROF" else "the clock"
            pytest.fail(f"{item.nodeid} takes more than {most:.0f} s by {kind}")

        before[number] = signal.signal(number, over)
        signal.setitimer(getattr(signal, timer), most)
    try:
        yield
    finally:
        for timer in LIMITS:
            signal.setitimer(getattr(signal, timer), 0)
        for number, handler in before.items():
            signal.signal(number, handler)


NOT_THERE = "the packages could not be fetched"
"""What a machine without npm's or Python's registry lacks: the one reason to skip a test in CI on Linux."""


class EachTest:
    """What holds for each test, those in the docstrings of ``src`` too: a time that it may take, and no skipping in CI."""

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_setup(self, item: pytest.Item) -> Any:
        with limited(item):
            return (yield)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_call(self, item: pytest.Item) -> Any:
        with limited(item):
            return (yield)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(self, item: pytest.Item) -> Any:
        """In CI a test that is skipped has failed: what it needs is installed there."""
        report = yield
        if report.skipped and os.environ.get("CI") and not hasattr(report, "wasxfail") and sys.platform != "win32":
            reason = str(report.longrepr[-1] if isinstance(report.longrepr, tuple) else report.longrepr)
            if NOT_THERE not in reason:
                report.outcome, report.longrepr = "failed", f"{item.nodeid}: {reason}: in CI no test may be skipped"
        return report


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    """What was drawn by lot, and so how to run the same once more."""
    if "not slow" not in config.option.markexpr:
        drawn = (
            "all"
            if config.option.share == "all"
            else f"the core, and of the others one of {SHARES} shares: --share {config.option.share}"
        )
        terminalreporter.write_line(f"Slow tests: {drawn}")
    if EXAMPLES:
        seed = config.getoption("--hypothesis-seed") or "that of the failure above"
        terminalreporter.write_line(f"Properties: HAPTISYM_EXAMPLES={EXAMPLES}, --hypothesis-seed={seed}")


def pytest_collection_finish(session: pytest.Session) -> None:
    """What was collected stays, and is not looked through for garbage any more."""
    gc.freeze()


@pytest.fixture
def call(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch):  # type: ignore[no-untyped-def]
    """The command line with these words: exit status, standard output and standard error.

    A document of JSON on standard output must be what its schema says.
    """

    def called(*words: str) -> tuple[int, str, str]:
        monkeypatch.setattr("sys.argv", ["haptisym", *words])
        with pytest.raises(SystemExit) as stop:
            main()
        out, err = capsys.readouterr()
        if IS_THERE and "--json" in words and out:
            assert faults(parsed(out)) == []
        return int(stop.value.code or 0), out, err

    return called
