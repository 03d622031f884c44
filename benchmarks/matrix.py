"""How long users wait: every question of every shipped scene as a command, start included, as a ratio to ``import sympy``.

    python benchmarks/matrix.py                          all questions of all scenes (half an hour of processor time)
    python benchmarks/matrix.py --only "fu2019|--json"   the cells whose command matches
    python benchmarks/matrix.py --against ../other       another working tree as well, both in turn
    python benchmarks/matrix.py --rounds 3 --csv FILE    the least of three; where the table goes (matrix.csv beside this file)

Processor time of whole processes, user and system, byte code in place, one thread for linear algebra. ``import sympy`` is
measured between them, after every fourth: what was measured last is the unit, so that tables of different machines can be
compared, and of one whose other users come and go. A parameter that a
question needs is the first number of the scene's last effect, and the second or the environment's first for a map.

Left out: recordings, measured scenes, ``identify`` and ``jnd``, whose time is that of their files.
"""

from __future__ import annotations

import argparse
import csv
import os
import re
import statistics
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from timing import machine, noted

TREE = Path(__file__).parents[1]
SHIPPED = TREE / "src" / "haptisym"
LIMIT = 300.0
"""Seconds that a cell gets."""
COMMAND = "from haptisym.__main__ import main; main()"
"""What the shell starts."""
ONE = ("--hand", "postural-arm")
RANGES = ("--range", "LOW", "HIGH", "--range", "LEAST", "MOST")
QUESTIONS: dict[str, tuple[str, ...]] = {
    "evaluate --json": ("evaluate", "SCENE", "--json"),
    "evaluate": ("evaluate", "SCENE"),
    "evaluate --regions": ("evaluate", "SCENE", "--regions"),
    "evaluate --figures": ("evaluate", "SCENE", "--figures", "figures"),
    "evaluate --report html": ("evaluate", "SCENE", "--report", "report.html"),
    "evaluate --report pdf": ("evaluate", "SCENE", "--report", "report.pdf"),
    "evaluate --certificate": ("evaluate", "SCENE", "--certificate", "certificate.json"),
    "derive": ("derive", "SCENE"),
    "derive --latex": ("derive", "SCENE", "--latex", "derivation.tex"),
    "effects": ("effects", "SCENE"),
    "sensitivity": ("sensitivity", "SCENE"),
    "tolerances": ("tolerances", "SCENE"),
    "metrics": ("metrics", "SCENE"),
    "simulate": ("simulate", "SCENE"),
    "simulate --check": ("simulate", "SCENE", "--check"),
    "stability": ("stability", "SCENE"),
    "stability --hand": ("stability", "SCENE", *ONE),
    "stability --free": ("stability", "SCENE", *ONE, "--free", "FREE"),
    "require": ("require", "SCENE", "--free", "FREE"),
    "require --any-environment": ("require", "SCENE", "--free", "FREE", "--any-environment"),
    "require --that passive": ("require", "SCENE", "--free", "FREE", "--that", "passive"),
    "require --that stable": ("require", "SCENE", "--free", "FREE", "--that", "stable", *ONE),
    "require, a map": ("require", "SCENE", "--free", "FREE", "--free", "OTHER", *RANGES),
    "sweep, 20 sets": ("sweep", "SCENE", "--vary", "FREE=LOW:HIGH:20"),
}
"""By what a person would call them; the scene, one or two of its parameters and half and twice their values are put in."""
IMPORT = 0.32
"""Seconds that ``import sympy`` takes on the machine of which the next table speaks."""
MAY = {
    "other": 2.0, "evaluate --json": 1.2 * IMPORT, "evaluate --figures": 2.5, "evaluate --report pdf": 4.0, "require, a map": 3.0,
    "--version": 0.1, "--help": 0.1, "schemas": 0.1, "scenes": 0.1, "sweep, 20 sets": LIMIT, "simulate --check": LIMIT,
}  # fmt: skip
"""Seconds that a question may take; those of ``sweep`` and recordings are not limited."""
OF_NO_SCENE = {"--version": ("--version",), "--help": ("--help",), "schemas": ("schemas",), "scenes": ("scenes",)}


@dataclass
class Cell:
    """One command, and what it took: seconds of each tree, in the order of the rounds."""

    question: str
    scene: str
    words: tuple[str, ...]
    seconds: dict[str, list[float]] = field(default_factory=dict)
    ratios: dict[str, list[float]] = field(default_factory=dict)
    status: int = 0

    def least(self, tree: str) -> float:
        """In that tree."""
        return min(self.seconds[tree])

    def ratio(self, tree: str) -> float:
        """The least in that tree, in the times that ``import sympy`` took beside."""
        return min(self.ratios[tree])

    @property
    def most(self) -> float:
        """As many of these as it may take."""
        return MAY.get(self.question, MAY["other"]) / IMPORT


def cells(only: str) -> Iterator[Cell]:
    """All whose command matches."""
    every = [Cell(name, "", words) for name, words in OF_NO_SCENE.items()]
    for path in sorted((SHIPPED / "scenes").glob("*.toml")):
        put = {"SCENE": path.stem, **free(tomllib.loads(path.read_text(encoding="utf-8")))}
        key = re.compile("|".join(put))
        for name, words in QUESTIONS.items():
            every.append(Cell(name, path.stem, tuple(key.sub(lambda x, put=put: put[x[0]], word) for word in words)))
    return (x for x in every if re.search(only, f"{x.question} {' '.join(x.words)}"))


def free(scene: dict[str, object]) -> dict[str, str]:
    """What may vary in a scene: two paths, and from half to twice the value of each."""
    *_, last = scene["effects"]  # type: ignore[misc]
    own = [(f"effects.{last.get('name', last['model'])}.{key}", x) for key, x in numbers(last)]
    own += [(f"environment.{key}", x) for key, x in numbers(scene["environment"])]  # type: ignore[arg-type]
    (path, given), (other, and_given), *_ = own
    (low, high), (least, most) = halved(str(given)), halved(str(and_given))
    return {"FREE": path, "OTHER": other, "LOW": low, "HIGH": high, "LEAST": least, "MOST": most}


def halved(given: str) -> list[str]:
    """Half a value and twice it, in its unit."""
    value, unit = re.fullmatch(r"([\d.eE+-]+)\s*(.*)", given).groups()  # type: ignore[union-attr]
    return [f"{share * float(value):g} {re.split(' *[+]- *', unit)[0]}".strip() for share in (0.5, 2)]


def numbers(table: dict[str, object]) -> Iterator[tuple[str, object]]:
    """Keys whose value begins with a number, those of own formulas among them."""
    for key, x in table.items():
        if isinstance(x, dict):
            yield from numbers(x)
        elif key not in ("name", "model", "order", "method") and re.match(r"[\d.]", str(x)):
            yield key, x


def spent(words: Sequence[str], tree: Path, folder: str) -> tuple[float, int]:
    """Processor time of a process and its exit status, 124 where it took longer than the limit."""
    environment = {**os.environ, "PYTHONPATH": str(tree / "src"), "OPENBLAS_NUM_THREADS": "1", "MPLBACKEND": "agg"}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    before = os.times()
    try:
        done = subprocess.run(
            [sys.executable, *words], check=False, env=environment, cwd=folder, timeout=LIMIT, **quiet
        ).returncode
    except subprocess.TimeoutExpired:
        done = 124
    after = os.times()
    return after.children_user + after.children_system - before.children_user - before.children_system, done


def measured(chosen: Sequence[Cell], trees: dict[str, Path], rounds: int) -> float:
    """Fill the cells, all trees in turn; the least time of ``import sympy``, which is measured between them."""
    imports = list[float]()
    with tempfile.TemporaryDirectory() as folder:
        for tree in trees.values():  # byte code is written, as an installer does
            spent(["-c", COMMAND, "evaluate", "fu2019"], tree, folder)
        for turn in range(rounds):
            for place, cell in enumerate(chosen):
                if place % 4 == 0:
                    imports.append(spent(["-c", "import sympy"], TREE, folder)[0])
                for name, tree in trees.items():
                    seconds, cell.status = spent(["-c", COMMAND, *cell.words], tree, folder)
                    cell.seconds.setdefault(name, []).append(seconds)
                    cell.ratios.setdefault(name, []).append(seconds / imports[-1])
                print(f"\r{turn + 1}: {place + 1} of {len(chosen)}", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)
    return min(imports)


def told(chosen: Sequence[Cell], trees: dict[str, Path], unit: float, most: int) -> None:
    """Those first that are longest beyond, or nearest to, what they may take, then each question."""
    first, *others = trees
    print(f"import sympy: {unit:.3f} s of processor time\n")
    print("=== slowest, against what they may take ===")
    heads = "".join(f"{name:>10}" for name in trees)
    print(f"  times import sympy{heads}   seconds  status   command")
    for x in sorted(chosen, key=lambda x: -x.ratio(first) / x.most)[:most]:
        ratios = "".join(f"{x.ratio(name):10.2f}" for name in trees)
        print(f"{'':20}{ratios}{x.least(first):10.2f}{x.status:8}   {' '.join(x.words)}")
    over = sum(x.ratio(first) > x.most for x in chosen)
    print(f"\n{over} of {len(chosen)} take longer than they may")
    print("\n=== questions ===")
    print(f"  {'question':<28} scenes   median    worst   of" + ("      median of new/old" if others else ""))
    for name in dict.fromkeys(x.question for x in chosen):
        own = [x for x in chosen if x.question == name]
        worst = max(own, key=lambda x: x.ratio(first))
        median = statistics.median(x.ratio(first) for x in own)
        change = [x.ratio(first) / x.ratio(other) for x in own for other in others]
        more = f"      {statistics.median(change):.2f}" if change else ""
        print(f"  {name:<28} {len(own):6} {median:8.2f} {worst.ratio(first):8.2f}   {worst.scene}{more}")
    if others:
        print("\n=== changed ===")
        for x in sorted(chosen, key=lambda x: x.ratio(first) / x.ratio(others[0])):
            quotient = x.ratio(first) / x.ratio(others[0])
            if not 0.8 < quotient < 1.25:
                print(f"  {quotient:6.2f} {x.least(others[0]):8.2f} -> {x.least(first):6.2f} s   {' '.join(x.words)}")


def main() -> None:
    """Measure, print, and write the table."""
    asked = argparse.ArgumentParser(description="How long users wait.")
    asked.add_argument("--only", default="", metavar="REGEX")
    asked.add_argument("--against", type=Path, metavar="TREE")
    asked.add_argument("--rounds", type=int, default=1)
    asked.add_argument("--most", type=int, default=40, help="rows of the first table")
    asked.add_argument("--csv", type=Path, default=Path(__file__).with_suffix(".csv"))
    given = asked.parse_args()
    trees = {"here": TREE, **({"there": given.against.resolve()} if given.against else {})}
    chosen = list(cells(given.only))
    unit = measured(chosen, trees, given.rounds)
    noted({" ".join(x.words): x.least("here") for x in chosen})
    print(machine())
    told(chosen, trees, unit, given.most)
    with given.csv.open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file)
        table.writerow(
            ["question", "scene", *(f"{name}_s" for name in trees), *(f"{name}_ratio" for name in trees), "status"]
        )
        for x in chosen:
            least = [x.least(name) for name in trees]
            table.writerow(
                [x.question, x.scene, *(f"{y:.3f}" for y in least), *(f"{x.ratio(y):.3f}" for y in trees), x.status]
            )


if __name__ == "__main__":
    main()
