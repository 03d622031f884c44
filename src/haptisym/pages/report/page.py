"""The report of an evaluation: one page that holds all it needs, or the LaTeX document as PDF."""

from __future__ import annotations

import json
from collections.abc import Iterator
from importlib.resources import files
from pathlib import Path

from haptisym import __version__
from haptisym.judge.evaluation import Evaluation
from haptisym.kernel.errors import SceneError
from haptisym.model.jnd import Part
from haptisym.pages.report.design import design
from haptisym.pages.report.explorer import explorer
from haptisym.pages.report.figures import nyquist_figure, projection_figure, ratio_figure, square_figure
from haptisym.pages.report.findings import findings
from haptisym.pages.report.forms import derivation
from haptisym.pages.report.pdf import pdf
from haptisym.pages.report.results import (
    certainty,
    changeovers,
    crossing_table,
    percept_table,
    reservations,
    stability,
    transparency,
    undecided_table,
)
from haptisym.pages.report.scene import scene_parts
from haptisym.pages.tex.forms import SceneForms
from haptisym.writing.htmltext import Html, coded, data, element


def save_report(evaluation: Evaluation, path: str | Path) -> None:
    """Write the report of an evaluation to a file: ``.html`` the page, ``.pdf`` the LaTeX document, set by pdflatex.

    Raises SceneError if the name ends otherwise, and for a PDF if there is no pdflatex; OSError if it cannot be written.
    """
    target = Path(path)
    kind = target.suffix.lower()
    if kind not in (".html", ".htm", ".pdf"):
        raise SceneError(f'report: the name "{target.name}" must end in .html or .pdf')
    if kind == ".pdf":
        target.write_bytes(pdf(evaluation))
    else:
        target.write_text(page(evaluation), encoding="utf-8")


def page(evaluation: Evaluation) -> str:
    """The page: findings, scene, both steps with tables and figures, an explorer, the derivation, and what is certain.

    It loads nothing from anywhere, and forbids itself to. Text of the scene stays text. The document of ``to_json`` is in
    it (in the element ``evaluation``), and so is each number of the tables, as the nearest double.

    >>> from haptisym import effects, environments
    >>> from haptisym.judge.evaluation import evaluate
    >>> from haptisym.model.scene import Scene
    >>> text = page(evaluate(Scene(environments.kelvin_voigt(290, 2), (effects.first_order_lag(100),), title="<b>")))
    >>> text.startswith("<!DOCTYPE html>"), text.count("<h1>&lt;b&gt;</h1>")
    (True, 1)
    """
    title = evaluation.scene.title or "Untitled scene"
    style = Html((files("haptisym") / "data" / "report.css").read_text(encoding="utf-8"))
    head = element(
        "head", element("meta", given={"charset": "utf-8"}),
        element("meta", given={"http-equiv": "Content-Security-Policy", "content": _POLICY}),
        element("meta", given={"name": "viewport", "content": "width=device-width, initial-scale=1"}),
        element("meta", given={"name": "color-scheme", "content": "light dark"}),
        element("title", title), element("style", style),
    )  # fmt: skip
    body = element("body", element("main", *_sections(evaluation)))
    return f"<!DOCTYPE html>\n{element('html', head, body, given={'lang': 'en'})}\n"


_POLICY = (
    "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; base-uri 'none'; form-action 'none'"
)


def _sections(e: Evaluation) -> Iterator[Html]:
    forms = SceneForms(e)
    yield _heading(e)
    yield findings(e)
    parts = {
        "Scene": list(scene_parts(e.scene, forms.short_names)),
        "Step 1: when is it noticed?": list(_when(e)),
        "Step 2: how is it felt?": list(_how(e)),
        "Which values would do?": list(design(e)),
        "Explorer": [explorer(e, forms)],
        "Derivation": [derivation(forms)],
        "Certainty": list(_certain(e)),
    }
    for title, contents in parts.items():
        if not contents:
            continue
        name = title.partition(":")[0].lower().replace(" ", "-").rstrip("?")
        yield element("section", element("h2", title), *contents, given={"id": name})
    yield data(json.dumps(e.to_dict(), ensure_ascii=True), "evaluation")


def _heading(e: Evaluation) -> Html:
    lines = [element("p", "Two-step evaluation of a haptic display", given={"class": "kind"})]
    lines.append(element("h1", e.scene.title or "Untitled scene"))
    if e.scene.source:
        lines.append(element("p", f"Source of the scene: {e.scene.source}", given={"class": "source"}))
    lines += [element("p", coded(aside), given={"class": "source"}) for aside in e.given.asides()]
    return element("header", *lines)


# The steps.


def _when(e: Evaluation) -> Iterator[Html]:
    yield element("p", transparency(e))
    yield ratio_figure(e)
    yield crossing_table(e)
    yield undecided_table(e)


def _how(e: Evaluation) -> Iterator[Html]:
    yield percept_table(e)
    yield element("div", *(projection_figure(e, part) for part in Part), given={"class": "pair"})
    yield element("p", changeovers(e))
    yield from (element("p", x, given={"class": "reservation"}) for x in reservations(e))
    yield element("div", nyquist_figure(e), square_figure(e), given={"class": "pair"})


def _certain(e: Evaluation) -> Iterator[Html]:
    yield element("p", stability(e))
    yield element("p", certainty(e))
    yield element(
        "p", "The explorer is no proof: it computes in floating point, on samples. The figures are drawn in floating point, "
        "with every proven frequency among the samples.",
    )  # fmt: skip
    yield element("p", f"Made by haptisym {__version__}.", given={"class": "source"})
