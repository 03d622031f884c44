"""All measurements that the docs summarise, made anew with one command.

    python benchmarks/all.py             all scripts of this folder, one after the other; trust them on an idle machine
    python benchmarks/all.py cost        only this one
    python benchmarks/all.py --list      what there is, what each leaves out, versions and hardware; nothing is measured

Each script's output goes to benchmarks/results/NAME.txt, which the pages of docs/ summarise.
"""

from __future__ import annotations

import ast
import os
import platform
import re
import subprocess
import sys
from datetime import date
from pathlib import Path

from timing import machine

HERE = Path(__file__).parent
RESULTS = HERE / "results"


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


def measure(script: Path) -> bool:
    """Run a script and keep its output; False where it failed, whose earlier output is then left as it is."""
    done = subprocess.run([sys.executable, str(script)], cwd=HERE, capture_output=True, text=True, check=False)
    if done.returncode:
        print(f"{script.name} FAILED:\n{done.stderr}", file=sys.stderr)
        return False
    RESULTS.mkdir(exist_ok=True)
    head = f"{date.today().isoformat()}; {hardware()}"
    (RESULTS / f"{script.stem}.txt").write_text(f"{head}\n{done.stdout.rstrip()}\n", encoding="utf-8")
    print(f"\n{head}\n{done.stdout}")
    return True


def main() -> None:
    """Run what is asked for."""
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
    failed = [script.name for script in chosen if not measure(script)]
    if failed:
        sys.exit(f"failed: {', '.join(failed)}")


if __name__ == "__main__":
    main()
