"""A document as PDF, set by pdflatex."""

from __future__ import annotations

import subprocess
from contextlib import suppress
from os import environ
from pathlib import Path
from shutil import which
from tempfile import TemporaryDirectory

from haptisym.figures.sheet import save_as
from haptisym.kernel.errors import NothingToDrawError, SceneError
from haptisym.writing.document import Document, figures_of
from haptisym.writing.latex import latex

_RUNS = 2  # the second one knows the numbers of the tables
_DATED = {"FORCE_SOURCE_DATE": "1"}
"""Makes the day of the document that of SOURCE_DATE_EPOCH, where that is set: then the same evaluation gives the same file."""
_SECONDS = 300  # for one run; the longest document of a scene takes a few


def pdf(document: Document) -> bytes:
    """The document in full as PDF. Raises SceneError if pdflatex is missing or fails."""
    program = which("pdflatex")
    if program is None:
        raise SceneError(
            "report: a PDF needs pdflatex, which was not found (Debian: texlive-latex-base, texlive-latex-recommended); "
            "an .html report needs nothing"
        )
    with TemporaryDirectory() as folder:
        (Path(folder) / "report.tex").write_text(latex(document, _figures(document, Path(folder))), encoding="ascii")
        for _ in range(_RUNS):
            _run(program, folder)
        return (Path(folder) / "report.pdf").read_bytes()


def _figures(document: Document, folder: Path) -> dict[str, str]:
    """The files of the document's figures, by their names."""
    found = {}
    for figure in figures_of(document.blocks):
        with suppress(NothingToDrawError):
            found[figure.name] = save_as(figure.draw(), folder / f"{figure.name}.pdf").name
    return found


def _run(program: str, folder: str) -> None:
    command = [program, "-interaction=nonstopmode", "-halt-on-error", "-no-shell-escape", "report.tex"]
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
        wrong = [line for line in said.splitlines() if line.startswith("!")] or said.splitlines()[-1:]
        raise SceneError(f"report: pdflatex could not set the document: {' '.join(wrong)}")
