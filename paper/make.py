"""The figure and the numbers of the paper, by the program: ``python paper/make.py`` writes both.

A test fails where the text has other numbers than the program computes.
"""

import re
from dataclasses import replace
from pathlib import Path

from sympy import Integer

import haptisym as hs

HERE = Path(__file__).parent
PAPER = HERE / "paper.md"
WORDS = dict(
    enumerate(["ten", "eleven", "twelve", "thirteen", "fourteen", "fifteen", "sixteen", "seventeen", "eighteen"], 10)
)


def numbers() -> dict[str, str]:
    """Each number of the text: what stands around it, with one group for it, and what the group should be."""
    given = hs.evaluate("fu2019")
    real, imag = given.crossings
    # The best damping ratio lies beyond the example's band, which ends at 15 rad/s.
    wide = replace(hs.load_scene("fu2019"), band=(Integer(0), Integer(60)))
    best = hs.design(wide, {"zeta": (0.01, 1)}, gap="1e-7")
    assert best.best is not None
    [zeta] = best.best.values
    pages = {x.stem for x in (HERE.parent / "docs" / "reproductions").glob("*.py")} - {"book"}
    return {
        r"published results of (\w+) sources": WORDS[len(pages)],
        r"a damping ratio of ([\d.]+) instead": f"{float(zeta):.3g}",
        r"is transparent ([\d.]+) times": f"{best.bandwidth[0] / float(real.omega):.2g}",
        r"proven to be ([\d.]+) and": real.omega.digits(9),
        r"proven to be [\d.]+ and ([\d.]+) rad/s": imag.omega.digits(9),
        r"\bversion ([\d.]+)\b": hs.__version__,
    }


def text() -> str:
    """The text of the paper with the numbers of the program."""
    written = PAPER.read_text(encoding="utf-8")
    for pattern, number in numbers().items():
        [found] = re.finditer(pattern, written)
        written = written[: found.start(1)] + number + written[found.end(1) :]
    return written


if __name__ == "__main__":
    PAPER.write_text(text(), encoding="utf-8")
    hs.evaluate("fu2019").save_figure(HERE / "ratios.png")
