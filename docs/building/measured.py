"""The measured numbers in the pages of docs/: ``python docs/building/measured.py`` puts those of benchmarks/results into the
pages, and a build of the site shows them in any case. A test fails where a page and the results differ.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import cache
from pathlib import Path

DOCS = Path(__file__).parents[1]
RESULTS = DOCS.parent / "benchmarks" / "results"
MS = {"ns": 1e-6, "us": 1e-3, "ms": 1.0, "s": 1e3}


@cache
def result(name: str) -> str:
    """What a script printed."""
    return (RESULTS / f"{name}.txt").read_text(encoding="utf-8")


def row(text: str, label: str) -> list[str]:
    """The words behind a label at the beginning of a line of a table."""
    [line] = re.findall(rf"^ *{re.escape(label)}  +(.*)$", text, re.MULTILINE)
    return str(line).split()


def digits(x: float, count: int = 2) -> str:
    """So many digits, without an exponent."""
    return f"{float(f'{x:.{count}g}'):g}"


def accuracy() -> dict[str, str]:
    """Each number of the page on accuracy: what stands around it, with one group for it, and what the group should be."""
    # The paper's example is the first of the scenes, its crossings the second of the tables.
    table = result("cost").split("=== ")[1].split("The crossings on the band")[1]
    ways = {
        r"\| grid of 10 000 points \|": "grid of 10^4",
        r"\| grid of 1 000 000 points \|": "grid of 10^6",
        r"\| grid of 10 000 points, Brent \|": "grid of 10^4 + Brent",
        r"\| `numpy.roots` \|": "numpy.roots",
        r"\| haptisym, 15 digits \|": "certified, 15 digits",
        r"\| haptisym, 1000 digits \|": "certified, 1000 digits",
    }
    found = {way: row(table, label) for way, label in ways.items()}
    own = {way: digits(float(words[1]) * MS[words[2]]) for way, words in found.items()}
    numbers = {rf"{way} [\d.]+ \| ([\d.]+) ms": milliseconds for way, milliseconds in own.items()}
    numbers |= {rf"{way} ([\d.]+) \|": words[0].removesuffix(".0") for way, words in found.items()}
    listed = list(own.values())
    numbers |= {
        r"proven to 15 digits, take ([\d.]+) ms": listed[4],
        r"A thousand\s+proven digits take ([\d.]+) ms": listed[5],
        r"with 12 digits \(([\d.]+) ms\)": listed[1],
    }
    crossings = result("evaluate")
    control, exact, everything = (
        float(row(crossings, label)[2])
        for label in (
            "python-control grid + brentq: crossings only, not proven",
            "SymPy real_roots: crossings only",
            "haptisym evaluate(fu2019): everything, certified",
        )
    )
    numbers |= {
        r"take ([\d.]+) times as long as unproven": digits(1 / control),
        r"and are ([\d.]+) times as fast as SymPy's": digits(exact),
        r"finds takes ([\d.]+) times as long": digits(everything),
    }
    return numbers | commands()


def commands() -> dict[str, str]:
    """Those of commands on all scenes: the median, and the longest of all questions of that kind."""
    table = result("matrix").split("=== questions ===")[1]
    kinds = {
        "`evaluate`": ["evaluate"],
        "figures": ["evaluate --figures"],
        "HTML reports": ["evaluate --report html"],
        "PDF": ["evaluate --report pdf"],
        "`stability` in a hand": ["stability --hand", "stability --free"],
        "`require`": ["require", "require --any-environment", "require --that passive", "require --that stable"],
        "a map": ["require, a map"],
    }
    numbers = {}
    for kind, questions in kinds.items():
        rows = [row(table, question) for question in questions]
        numbers[rf"[\n ]{kind} ([\d.]+), [\d.]+[;,.]"] = f"{float(rows[0][1]):.1f}"
        numbers[rf"[\n ]{kind} [\d.]+, ([\d.]+)[;,.]"] = f"{max(float(x[2]) for x in rows):.1f}"
    return numbers


def functions() -> dict[str, str]:
    """Those of the page on functions: times of both numbers of frequencies, in times of NumPy by hand."""
    few, many = (part.split("\n\n")[0] for part in result("throughput").split("both ratios of fu2019")[1:3])
    kinds = {
        "`fast`": "fast",
        "with Numba into given arrays": "numba, into given arrays",
        "`lambdify`": "lambdify, cse",
        "`certified`": "certified",
    }
    numbers = {}
    for kind, label in kinds.items():
        words = kind.replace(" ", r"\s+")
        numbers[rf"[\n ]{words} ([\d.]+) and [\d.]+[,.]"] = digits(float(row(few, label)[2]))
        numbers[rf"[\n ]{words} [\d.]+ and ([\d.]+)[,.]"] = digits(float(row(many, label)[2]))
    return numbers


PAGES: dict[str, Callable[[], dict[str, str]]] = {"accuracy": accuracy, "functions": functions}


def with_numbers(page: str, text: str) -> str:
    """The text of a page with the numbers of the results."""
    for pattern, number in PAGES[page]().items() if page in PAGES else ():
        [found] = re.finditer(pattern, text)
        text = text[: found.start(1)] + number + text[found.end(1) :]
    return text


if __name__ == "__main__":
    for name in PAGES:
        path = DOCS / f"{name}.md"
        path.write_text(with_numbers(name, path.read_text(encoding="utf-8")), encoding="utf-8")
