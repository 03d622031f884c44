"""One Hypothesis profile for the whole suite, the same examples on every machine and every run; and the command line, called.

With HAPTISYM_EXAMPLES=N there are N examples (where a test wants more, as many as it wants), drawn with the seed that
``pytest --hypothesis-seed`` gives: CI does that with one of each commit's own, and says which.
"""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, settings
from marks import EXAMPLES
from schemas import IS_THERE, faults, parsed

from haptisym.cli import main

settings.register_profile(
    "drawn" if EXAMPLES else "repeatable",
    derandomize=not EXAMPLES,
    deadline=None,
    max_examples=EXAMPLES or 20,
    database=None,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("drawn" if EXAMPLES else "repeatable")


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    """How to repeat a run whose examples were drawn anew."""
    if EXAMPLES and terminalreporter.stats.get("failed"):
        seed = config.getoption("--hypothesis-seed") or "that of the failure above"
        again = f"HAPTISYM_EXAMPLES={EXAMPLES} pytest -m hypothesis --hypothesis-seed={seed}"
        terminalreporter.write_line(f"The same examples once more: {again}")


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
