"""What `haptisym evaluate` takes for a measured response of a million lines: the whole command, from its start to its end.

    python benchmarks/measured.py            a million lines
    python benchmarks/measured.py 100000     so many

Three files with the same numbers, all lines in the band, as programs write them: nine digits, the shortest that read back, and
e notation with 19; and one whose last line is none. Beside them a scene of 50 lines: what the start alone takes. Each command
is run in turn, several rounds; least processor and wall time, largest memory. Where bytecode is not kept, it is here.

Left out: other programs, as none judges discs against thresholds.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
from timing import machine

import haptisym as hs

COMMAND = [sys.executable, "-c", "from haptisym.__main__ import main; main()", "evaluate"]
ENVIRONMENT = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
ROUNDS = 5
FORMS = {"9 digits": "%.9g", "shortest": "%r", "19 digits": "%.18e"}
SCENE = """
[environment]
model = "mass-spring-damper"
m = "1.8 kg"
b = "15 N*s/m"
k = "100 N/m"
[perceived]
file = "FILE"
averages = 10
"""


def bench(folder: Path, name: str, lines: int, form: str, last: str = "") -> Path:
    """A scene whose perceived response has so many lines: that of fu2019 with noise of 0.1 %, and a coherence that varies."""
    chance = np.random.default_rng(1)
    exact = hs.sampled("fu2019", np.linspace(0.001, 14, 2000))
    omega = np.linspace(0.001, 14, lines)
    real, imag = (
        np.interp(omega, exact.omega, x) * chance.normal(1, 1e-3, lines) for x in (exact.H.real, exact.H.imag)
    )
    rows = zip(*(x.tolist() for x in (omega, real, imag, 1 - 0.02 * chance.random(lines))), strict=True)
    row = ",".join([form] * 4) + "\n"
    with (folder / f"{name}.csv").open("w", encoding="utf-8") as file:
        file.write("omega,real,imag,coherence\n")
        file.writelines(row % x for x in rows)
        file.write(last)
    path = folder / f"{name}.toml"
    path.write_text(SCENE.replace("FILE", f"{name}.csv"), encoding="utf-8")
    return path


def run(words: list[str]) -> tuple[float, float, float]:
    """Processor seconds, wall seconds and megabytes of one run of the command."""
    started = time.perf_counter()
    process = subprocess.Popen(
        [*COMMAND, *words], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=ENVIRONMENT
    )
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    return used.ru_utime + used.ru_stime, time.perf_counter() - started, used.ru_maxrss / 1024


def main() -> None:
    """Write the files, run, print."""
    lines = int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000
    print(machine())
    # files are written by another process: a command begins with the memory of whoever starts it
    with tempfile.TemporaryDirectory() as place, ProcessPoolExecutor(1) as other:
        folder = Path(place)
        commands = {"50 lines": [str(other.submit(bench, folder, "few", 50, "%.9g").result())]}
        for name, form in FORMS.items():
            path = other.submit(bench, folder, name.replace(" ", "-"), lines, form).result()
            size = path.with_suffix(".csv").stat().st_size / 1e6
            commands[f"{name} ({size:.0f} MB)"] = [str(path)]
            commands[f"{name}, --json"] = [str(path), "--json"]
        commands["a last line that is none"] = [
            str(other.submit(bench, folder, "bad", lines, "%.9g", "15,x,1,0.9\n").result())
        ]
        found = {name: [run(words)] for name, words in commands.items()}
        for _ in range(ROUNDS):
            for name, words in commands.items():
                found[name].append(run(words))
    print(f"\n=== {lines} lines ===\n\n  {'':<28} processor      wall    memory")
    for name, runs in found.items():
        processor, wall, memory = min(x[0] for x in runs), min(x[1] for x in runs), max(x[2] for x in runs)
        print(f"  {name:<28} {processor:7.2f} s {wall:7.2f} s {memory:6.0f} MB")


if __name__ == "__main__":
    main()
