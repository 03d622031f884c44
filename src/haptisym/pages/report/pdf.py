"""The LaTeX document of an evaluation, set by pdflatex."""

from __future__ import annotations

import subprocess
from os import environ
from pathlib import Path
from shutil import which
from tempfile import TemporaryDirectory

from haptisym.figures.files import save_figures
from haptisym.judge.evaluation import Evaluation
from haptisym.kernel.errors import SceneError
from haptisym.pages.tex.document import document

_RUNS = 2  # the second one knows the numbers of the tables
_DATED = {"FORCE_SOURCE_DATE": "1"}
"""Makes the day of the document that of SOURCE_DATE_EPOCH, where that is set: then the same evaluation gives the same file."""
_SECONDS = 300  # for one run; the longest document of a scene takes a few


def pdf(evaluation: Evaluation) -> bytes:
    """The document as PDF. Raises SceneError if pdflatex is missing or fails."""
    program = which("pdflatex")
    if program is None:
        raise SceneError(
            "report: a PDF needs pdflatex, which was not found (Debian: texlive-latex-base, texlive-latex-recommended); "
            "an .html report needs nothing"
        )
    with TemporaryDirectory() as folder:
        files = {path.stem: path.name for path in save_figures(evaluation, folder, [".pdf"])}
        (Path(folder) / "report.tex").write_text(document(evaluation, files), encoding="ascii")
        for _ in range(_RUNS):
            _run(program, folder)
        return (Path(folder) / "report.pdf").read_bytes()


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
