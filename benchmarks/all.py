"""All measurements that the docs summarise, made anew with one command.

    python benchmarks/all.py             all scripts of this folder, one after the other; trust them on an idle machine
    python benchmarks/all.py cost        only this one
    python benchmarks/all.py --list      what there is, what each leaves out, versions and hardware; nothing is measured
    python benchmarks/all.py --compare   what became slower by more than a tenth from the last run but one of each script to the
                                         last one, in times of a fixed computation; nothing is measured

Each script's output goes to benchmarks/results/NAME.txt, whose numbers ``python docs/building/measured.py`` puts into the pages
of docs/. What a run has timed is kept in benchmarks/results/history, by date and commit.
"""

from __future__ import annotations

import ast
import json
import os
import platform
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from datetime import datetime
from pathlib import Path
from typing import Any

from timing import NOTES, machine, yardstick

HERE = Path(__file__).parent
RESULTS = HERE / "results"
HISTORY = RESULTS / "history"
SLOWER = 1.1


def scripts() -> list[Path]:
    """Everything in this folder that measures: what can be run and is not this file."""
    return [
        x for x in sorted(HERE.glob("*.py")) if x != Path(__file__) and "\ndef main(" in x.read_text(encoding="utf-8")
    ]


def hardware() -> str:
    """The processor, as far as the system tells."""
    described = Path("/proc/cpuinfo")
    text = described.read_text(encoding="utf-8") if described.exists() else ""
    model = re.search(r"model name\s*: (.*)", text)
    load = f", load {os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else ""
    return f"{model[1] if model else platform.processor() or platform.machine()}, {platform.system()}{load}"


def left_out(script: Path) -> str:
    """What a script's docstring says that it leaves out, and why."""
    text = ast.get_docstring(ast.parse(script.read_text(encoding="utf-8"))) or ""
    found = re.search(r"Left out: (.*?)(?:\n\n|\Z)", text, re.DOTALL)
    return " ".join(found[1].split()) if found else "nothing beyond what its output names"


def measure(script: Path, run: dict[str, Any]) -> bool:
    """Run a script and keep its output and times; False where it failed, whose earlier output is left as it is."""
    with tempfile.TemporaryDirectory() as folder:
        notes = Path(folder) / "notes"
        before = yardstick()
        done = subprocess.run(
            [sys.executable, str(script)],
            cwd=HERE,
            capture_output=True,
            text=True,
            check=False,
            env={**os.environ, NOTES: str(notes)},
        )
        unit = min(before, yardstick())
        lines = notes.read_text(encoding="utf-8").splitlines() if notes.exists() else []
    if done.returncode:
        print(f"{script.name} FAILED:\n{done.stderr}", file=sys.stderr)
        return False
    RESULTS.mkdir(exist_ok=True)
    head = f"{run['date'][:10]}; {hardware()}"
    (RESULTS / f"{script.stem}.txt").write_text(f"{head}\n{done.stdout.rstrip()}\n", encoding="utf-8")
    print(f"\n{head}\n{done.stdout}")
    # Tables of one script may have rows of the same name: they are numbered.
    seconds = {f"{n} {name}": x for n, line in enumerate(lines, 1) for name, x in json.loads(line).items()}
    if seconds:
        run["scripts"][script.stem] = {"unit": unit, "seconds": seconds}
        HISTORY.mkdir(exist_ok=True)
        text = json.dumps(run, indent=1)
        (HISTORY / f"{run['date'].replace(':', '')}-{run['commit']}.json").write_text(f"{text}\n", encoding="utf-8")
    return True


def commit() -> str:
    """The commit that is measured, with a + where the package differs from it."""

    def git(*words: str) -> str:
        return subprocess.run(["git", *words], cwd=HERE, capture_output=True, text=True, check=False).stdout.strip()

    return (git("rev-parse", "--short", "HEAD") or "unknown") + ("+" if git("status", "--porcelain", "../src") else "")


def slower(history: Path) -> Iterator[str]:
    """A line for each time that is more than a tenth longer in the last run of a script than in the one before."""
    runs = [json.loads(x.read_text(encoding="utf-8")) for x in sorted(history.glob("*.json"))]
    for name in sorted({name for run in runs for name in run["scripts"]}):
        *_, old, new = [None, *(run for run in runs if name in run["scripts"])]
        if old is None:
            continue
        was, now = (run["scripts"][name] for run in (old, new))
        for row in now["seconds"].keys() & was["seconds"].keys():
            ratio = now["seconds"][row] / now["unit"] / (was["seconds"][row] / was["unit"])
            if ratio > SLOWER:
                between = f"{old['date']} {old['commit']} -> {new['date']} {new['commit']}"
                yield f"{ratio:6.2f} times  {name}: {row}  ({between})"


def main() -> None:
    """Run what is asked for."""
    if "--compare" in sys.argv:
        kept = len([*HISTORY.glob("*.json")])
        none = (
            f"nothing became slower by more than a tenth in {kept} runs" if kept > 1 else "fewer than two runs are kept"
        )
        print("\n".join(sorted(slower(HISTORY), reverse=True)) or none)
        return
    asked = [x.removesuffix(".py") for x in sys.argv[1:] if x != "--list"]
    chosen = [x for x in scripts() if not asked or x.stem in asked]
    unknown = set(asked) - {x.stem for x in chosen}
    if unknown:
        sys.exit(f"{', '.join(sorted(unknown))}: not here; there are {', '.join(x.stem for x in scripts())}")
    print(f"{machine()}\n{hardware()}")
    for script in chosen:
        print(f"{script.name} leaves out: {left_out(script)}")
    if "--list" in sys.argv:
        return
    now = datetime.now().astimezone()
    run = {"date": now.isoformat(timespec="minutes"), "commit": commit(), "hardware": hardware(), "scripts": {}}
    failed = [script.name for script in chosen if not measure(script, run)]
    if failed:
        sys.exit(f"failed: {', '.join(failed)}")


if __name__ == "__main__":
    main()
