"""Scripts with ``# %%`` cells as notebooks of Jupyter, for the site."""

from __future__ import annotations

import json

import nbformat
from make_notebook import notebook


def read(script: str) -> nbformat.NotebookNode:
    """Return the notebook of a script, without outputs."""
    return nbformat.reads(json.dumps(notebook(script)), as_version=4)
