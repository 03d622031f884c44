"""The gallery: every shipped scene, evaluated at every build, with its result, figures and command."""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any

import generated
from generated import Page

import haptisym as hs
from haptisym.figures.files import draw_figure, save_as
from haptisym.writing.html import fragment

FIGURES = {
    "ratios": "Distortion ratios along the band",
    "nyquist": "H_env and H_perc in the plane",
    "projections-real": "Real parts along the band",
    "projections-imag": "Imaginary parts along the band",
}


def pages(folder: Path) -> dict[str, Page]:
    """Return a page for each scene, and the gallery of all. ``folder`` : where the figures go."""
    (folder / "figures").mkdir(exist_ok=True)
    names = [*hs.scene_names(), *hs.family_names()]
    with ProcessPoolExecutor() as pool:
        texts = list(pool.map(partial(_one, folder), names))
    return {"gallery": partial(_all, names)} | {
        f"scene-{name}": partial(str, text) for name, text in zip(names, texts, strict=True)
    }


def _answer(name: str) -> Any:
    return hs.evaluate_all(hs.load_scenes(name)) if name in hs.family_names() else hs.evaluate(name)


def _one(folder: Path, name: str) -> str:
    found = _answer(name)
    family = name in hs.family_names()
    figures = {"worst-case": "The worst case along the band"} if family else FIGURES
    listed = []
    for kind, words in figures.items():
        save_as(draw_figure(found, kind), folder / "figures" / f"{name}-{kind}.svg")
        listed.append(f"![{words}](figures/{name}-{kind}.svg)\n")
    shown = fragment(found.document()).replace("<h2", "<h4").replace("</h2>", "</h4>")
    return "\n".join(
        [
            f"# {found._about.title}\n",
            f"```sh\nhaptisym evaluate {name} --figures figures\n```\n",
            "````{container} pair\n", *listed, "````\n",
            f"```{{raw}} html\n{shown}\n```\n",
            f"The scene's file, to copy with `haptisym scenes {name} > my.toml`:\n",
            f"```toml\n{generated.scene_file(name)}\n```\n",
        ]
    )  # fmt: skip


def _all(names: list[str]) -> str:
    lead = (
        "After this page you can choose a shipped scene to start from. Each has its command, figures, result and file, evaluated when this site was built. "
        "Scenes whose source is *illustrative* or *recalled* are examples, not data. [Every kind of figure](../plots.py) has a page of its own.\n"
    )
    cards = []
    for name in names:
        kind = "worst-case" if name in hs.family_names() else "ratios"
        cards.append(f"[![{name}](figures/{name}-{kind}.svg)](scene-{name}.md)\n")
        cards.append(f"[{name}](scene-{name}.md)\n")
    pairs = [f"````{{container}} card\n{a}\n{b}````\n" for a, b in zip(cards[::2], cards[1::2], strict=True)]
    listed = "\n".join(["../plots", *(f"scene-{name}" for name in names)])
    grid = "\n".join(["`````{container} gallery\n", *pairs, "`````\n"])
    return "\n".join(["# Gallery\n", lead, grid, f"```{{toctree}}\n:hidden:\n:maxdepth: 1\n\n{listed}\n```\n"])
