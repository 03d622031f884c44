"""Documents compiled by pdflatex, and what it says of them."""

from __future__ import annotations

import re
import shutil
import subprocess
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

from marks import required

from haptisym.judge.answers import Answer
from haptisym.writing.latex import latex


def compiled(text: str, folder: Path) -> str:
    """What pdflatex has to say about a document, which must compile."""
    required("pdflatex", shutil.which("pdflatex"))
    (folder / "scene.tex").write_text(text, encoding="ascii")
    command = ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "-no-shell-escape", "scene.tex"]
    for _ in range(2):  # the second time for the references
        done = subprocess.run(command, cwd=folder, capture_output=True, check=False)
    log = (folder / "scene.log").read_text(encoding="utf-8", errors="replace")
    assert done.returncode == 0, log[-3000:]
    return log


def check_layout(log: str) -> None:
    wide = [float(x) for x in re.findall(r"Overfull \\hbox \((\d+\.\d+)pt", log)]
    assert max(wide, default=0) <= 20
    assert "LaTeX Warning" not in log


def set_document(answer: Answer, figures: Mapping[str, str] = MappingProxyType({})) -> str:
    """An answer as a document of LaTeX."""
    return latex(answer.document(), figures)
