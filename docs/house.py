"""Draw the folders of the package and what stands on what: ``python docs/house.py [FILE]``, else ``docs/figures/house.svg``.

Boxes, sentences and arrows are read from the source: a folder's sentence is that of its ``__init__``, and an arrow goes from a
folder to each one that its modules import, but for those that are reached through another anyway.
"""

from __future__ import annotations

import ast
import sys
from pathlib import Path
from textwrap import fill

import matplotlib as mpl
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch

SOURCE = Path(__file__).parents[1] / "src" / "haptisym"
ROWS = (
    ("commands",),
    ("pages",),
    ("figures",),
    ("verbs", "writing"),
    ("judge", "writing"),
    ("model",),
    ("programs",),
    ("kernel",),
)
"""From top to bottom; what stands in two rows is as high as both."""
PUBLIC = {"effects", "environments", "interop"}
"""Modules beside the folders that stand with the model."""
INK, BLUE, PALE = "#222222", "#1f4e9e", "#eef2f9"
HEIGHT, GAP, WIDTH, SPLIT = 0.98, 0.42, 10.0, 6.2


def folders() -> list[str]:
    """All folders of modules, from top to bottom."""
    return list(dict.fromkeys(name for row in ROWS for name in row))


def sentence(folder: str) -> str:
    """What a folder holds, as its ``__init__`` says it."""
    text = (SOURCE / folder / "__init__.py").read_text(encoding="utf-8")
    return (ast.get_docstring(ast.parse(text)) or "").replace("``", "").rstrip(".")


def imports() -> set[tuple[str, str]]:
    """Pairs of a folder and another one that it imports."""
    found = set()
    for path in SOURCE.rglob("*.py"):
        own = _folder(path.relative_to(SOURCE).with_suffix("").parts)
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("haptisym."):
                found.add((own, _folder(tuple((node.module or "").split(".")[1:]))))
    return {(a, b) for a, b in found if a != b and {a, b} <= set(folders())}


def _folder(parts: tuple[str, ...]) -> str:
    return "model" if parts[0] in PUBLIC else parts[0]


def arrows() -> set[tuple[str, str]]:
    """The imports without those that lead where a chain of others leads as well."""
    direct = imports()
    return {(a, b) for a, b in direct if not any(_reaches(c, b, direct) for x, c in direct if x == a and c != b)}


def _reaches(a: str, b: str, direct: set[tuple[str, str]]) -> bool:
    return a == b or any(_reaches(c, b, direct) for x, c in direct if x == a)


def description() -> str:
    """The arrows in words, for those who do not see them: "commands stands on pages; ..."."""
    found = arrows()
    below = {name: [b for b in folders() if (name, b) in found] for name in folders()}
    return "; ".join(f"{name} stands on {' and '.join(names)}" for name, names in below.items() if names)


def boxes() -> dict[str, tuple[float, float, float, float]]:
    """Left, bottom, width and height of each folder."""
    found: dict[str, tuple[float, float, float, float]] = {}
    for i, row in enumerate(reversed(ROWS)):
        bottom = i * (HEIGHT + GAP)
        for j, name in enumerate(row):
            left, width = (0.0, WIDTH) if len(row) == 1 else ((0.0, SPLIT - GAP) if j == 0 else (SPLIT, WIDTH - SPLIT))
            start = found[name][1] if name in found else bottom
            found[name] = left, start, width, bottom + HEIGHT - start
    return found


def draw() -> Figure:
    """The figure."""
    figure = Figure(figsize=(7.2, 6.6))
    ax = figure.add_axes((0.02, 0.01, 0.96, 0.98))
    places = boxes()
    for name, (x, y, width, height) in places.items():
        ax.add_patch(
            FancyBboxPatch(
                (x, y), width, height, boxstyle="round,pad=0,rounding_size=0.12", facecolor=PALE, edgecolor=BLUE
            )
        )
        words = fill(sentence(name), int(11.4 * (width - 0.35)))
        ax.text(x + 0.2, y + height - 0.13, name, va="top", color=BLUE, fontsize=10, fontweight="bold")
        ax.text(x + 0.2, y + height - 0.45, words, va="top", color=INK, fontsize=7.5, linespacing=1.25)
    for above, below in sorted(arrows()):
        _arrow(ax, places[above], places[below])
    ax.set(xlim=(-0.1, WIDTH + 0.1), ylim=(-0.1, len(ROWS) * (HEIGHT + GAP) - GAP + 0.1))
    ax.axis("off")
    return figure


def _arrow(ax: mpl.axes.Axes, above: tuple[float, ...], below: tuple[float, ...]) -> None:
    """From the lower edge of one box straight down to the upper edge of another, or across where they stand side by side."""
    style = {"arrowstyle": "-|>", "color": INK, "linewidth": 1.1, "shrinkA": 0, "shrinkB": 0}
    left, right = max(above[0], below[0]), min(above[0] + above[2], below[0] + below[2])
    if left < right:
        x = (left + right) / 2
        start, end = (x, above[1]), (x, below[1] + below[3])
    else:
        y = (max(above[1], below[1]) + min(above[1] + above[3], below[1] + below[3])) / 2
        start, end = (
            ((above[0], y), (below[0] + below[2], y))
            if above[0] > below[0]
            else ((above[0] + above[2], y), (below[0], y))
        )
    ax.annotate("", end, start, arrowprops=style)


if __name__ == "__main__":
    target = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent / "figures" / "house.svg"
    with mpl.rc_context({"svg.fonttype": "none", "svg.hashsalt": "haptisym", "font.family": "sans-serif"}):
        draw().savefig(target, metadata={"Date": None, "Title": "The house", "Description": description()})
