"""The report of an answer as a file: a page of HTML that holds all it needs, or a PDF that pdflatex
sets.

The same answer gives the same page, byte for byte. The page of HTML holds its figures as drawings
whose colours follow the reader's choice of light or dark, and the answer as JSON.
"""

from __future__ import annotations

import json
import re
import subprocess
from contextlib import suppress
from io import StringIO
from os import environ
from pathlib import Path
from shutil import which
from tempfile import TemporaryDirectory

import matplotlib as mpl
from matplotlib.figure import Figure as Canvas

from haptisym import __version__
from haptisym.figures import pen
from haptisym.figures.files import save_as
from haptisym.figures.pen import checked_report
from haptisym.judge.answers import Answer
from haptisym.kernel.errors import NothingToDrawError, SceneError
from haptisym.model.files import replacing, write_whole
from haptisym.writing.document import Document, Figure
from haptisym.writing.html import Html, element, html, phrase
from haptisym.writing.latex import latex
from haptisym.writing.plain import said


def save(document: Document, record: str, path: str | Path) -> None:
    """Write the report of an answer to a file: ``.html`` a page, ``.pdf`` the LaTeX document, set
    by pdflatex.

    ``document`` : the page; ``record`` : the answer's document of JSON. Raises SceneError if the
    name ends otherwise, and for a PDF if there is no pdflatex; OSError if it cannot be written.
    """
    target = checked_report(path)
    if target.suffix.lower() == ".pdf":
        made = pdf(document)
        with replacing(target) as fresh:
            fresh.write_bytes(made)
    else:
        write_whole(target, _page(document, record))


def page(answer: Answer) -> str:
    """The page of HTML. The document of ``to_json`` is in it, and so is each number of it, as the
    nearest double.

    >>> from haptisym import effects, environments
    >>> from haptisym.verbs.evaluate.entry import evaluate
    >>> from haptisym.model.scene import Scene
    >>> wall, lag = environments.kelvin_voigt(290, 2), effects.first_order_lag(100)
    >>> text = page(evaluate(Scene(wall, (lag,), title="<b>")))
    >>> text.startswith("<!DOCTYPE html>"), text.count("<h1>&lt;b&gt;</h1>")
    (True, 1)
    """
    return _page(answer.document(), answer.to_json())


def _page(document: Document, record: str) -> str:
    """Return the page of HTML of a document, with the answer's JSON in it."""
    told = json.loads(record)
    # The record stands in the page under the name of its question: haptisym.evaluation/1 as
    # evaluation.
    name = told["schema"].partition("/")[0].removeprefix("haptisym.")
    return html(document, _drawn, (name, json.dumps(told)), f"Made by haptisym {__version__}.")


_COLOURS = {
    pen.INK: "ink",
    pen.BLUE: "env",
    pen.RED: "perc",
    pen.GREY: "grey",
    pen.SHADE: "shade",
    pen.UNSTABLE: "unstable",
    "#ffffff": "paper",
}
"""The figures' colours, and the names by which the page's style sheet gives them, in the light and
in the dark."""


def _drawn(figure: Figure) -> Html:
    """A figure as a drawing within a page."""
    with suppress(NothingToDrawError):
        drawing = _inline(_svg(figure.draw()), figure.name, said(figure.caption))
        below = element("figcaption", phrase(figure.caption))
        return element(
            "figure", drawing, below, given={"class": "wide" if figure.wide else figure.name}
        )
    return Html()


def _svg(canvas: Canvas) -> str:
    """Return a figure as the text of an SVG file, the same for the same figure."""
    text = StringIO()
    # Letters as paths, so that a page looks the same without the font; a fixed salt, so that ids
    # are the same each time.
    with mpl.rc_context({"svg.hashsalt": "haptisym", "svg.fonttype": "path"}):
        canvas.savefig(text, format="svg", metadata={"Date": None}, facecolor="none")
    return text.getvalue()


def _inline(svg: str, name: str, label: str) -> Html:
    """A drawing as an element of the page: no prologue, no comments, own names for its parts, the
    page's colours."""
    body = re.sub(
        r"<!--.*?-->|<metadata>.*?</metadata>|<style\b.*?</style>",
        "",
        svg[svg.index("<svg") :],
        flags=re.DOTALL,
    )
    # Several drawings share the page: an id that two of them use would mix up their clips and
    # glyphs.
    body = re.sub(r'(\bid="|url\(#|xlink:href="#)', rf"\g<1>{name}-", body)
    body = re.sub(r"\s*\n\s*", " ", body)
    for colour, variable in _COLOURS.items():
        body = body.replace(colour, f"var(--{variable})")
    words = element("title", label)
    # Without width and height the drawing follows the width of the page; viewBox keeps its
    # proportions.
    head = re.sub(r' (width|height)="[^"]*"', "", body[: body.index(">")], count=2)
    return Html(f'{head} role="img">{words}{body[body.index(">") + 1 :]}')


_RUNS = 2
"""Runs of pdflatex: the second one knows the numbers of the tables."""
_DATED = {"FORCE_SOURCE_DATE": "1"}
"""Makes the day of the document that of SOURCE_DATE_EPOCH, where that is set: then the same
evaluation gives the same file."""
_SECONDS = 300  # for one run; the longest document of a scene takes a few


def pdf(document: Document) -> bytes:
    """The document in full as PDF. Raises SceneError if pdflatex is missing or fails."""
    program = which("pdflatex")
    if program is None:
        raise SceneError(
            "report: a PDF needs pdflatex, which was not found (Debian: texlive-latex-base, "
            "texlive-latex-recommended); "
            "an .html report needs nothing"
        )
    with TemporaryDirectory() as folder:
        (Path(folder) / "report.tex").write_text(
            latex(document, _figures(document, Path(folder))), encoding="ascii"
        )
        for _ in range(_RUNS):
            _run(program, folder)
        return (Path(folder) / "report.pdf").read_bytes()


def _figures(document: Document, folder: Path) -> dict[str, str]:
    """The files of the document's figures, by their names."""
    found = {}
    for figure in document.figures():
        with suppress(NothingToDrawError):
            found[figure.name] = save_as(figure.draw(), folder / f"{figure.name}.pdf").name
    return found


def _run(program: str, folder: str) -> None:
    """Run pdflatex once in a folder; SceneError, with its own message, where it fails."""
    command = [
        program,
        "-interaction=nonstopmode",
        "-halt-on-error",
        # The document holds texts from scene files: none of them may run a program.
        "-no-shell-escape",
        "report.tex",
    ]
    try:
        done = subprocess.run(
            command,
            cwd=folder,
            env=environ | _DATED,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=_SECONDS,
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise SceneError(f"report: pdflatex was not done after {_SECONDS} s") from None
    if done.returncode:
        said = done.stdout.decode(errors="replace")
        wrong = [line for line in said.splitlines() if line.startswith("!")] or said.splitlines()[
            -1:
        ]
        raise SceneError(f"report: pdflatex could not set the document: {' '.join(wrong)}")
