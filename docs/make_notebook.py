"""Write a script with ``# %%`` cells as a notebook: ``python docs/make_notebook.py [SCRIPT [NOTEBOOK]]``.

Without arguments, the page of figures. Cells marked ``# %% [markdown]`` are text; the others are code, without output.
"""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path
from typing import Any


def cells(script: str) -> list[tuple[str, str]]:
    """The kind of each cell (``markdown`` or ``code``) and its text.

    >>> cells("# %% [markdown]\\n# Words\\n#\\n# more\\n\\n# %%\\nx = 1\\n")
    [('markdown', 'Words\\n\\nmore'), ('code', 'x = 1')]
    """
    parts = re.split(r"^# %%(.*)\n", script, flags=re.MULTILINE)
    return [_cell(mark, text.strip("\n")) for mark, text in zip(parts[1::2], parts[2::2], strict=True)]


def _cell(mark: str, text: str) -> tuple[str, str]:
    if "[markdown]" not in mark:
        return "code", text
    return "markdown", "\n".join(line.removeprefix("#").removeprefix(" ") for line in text.splitlines())


def notebook(script: str) -> dict[str, Any]:
    """The notebook, in format 4.5."""
    return {
        "cells": [_record(i, kind, text) for i, (kind, text) in enumerate(cells(script), 1)],
        "metadata": {
            "kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"},
            "language_info": {"name": "python"},
        },
        "nbformat": 4,
        "nbformat_minor": 5,
    }


def _record(i: int, kind: str, text: str) -> dict[str, Any]:
    record = {"cell_type": kind, "id": f"cell-{i}", "metadata": {}, "source": text.splitlines(keepends=True)}
    return {**record, "execution_count": None, "outputs": []} if kind == "code" else record


if __name__ == "__main__":
    source = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).with_name("plots.py")
    target = Path(sys.argv[2]) if len(sys.argv) > 2 else source.with_suffix(".ipynb")
    target.write_text(json.dumps(notebook(source.read_text(encoding="utf-8")), indent=1) + "\n", encoding="utf-8")
    print(f"notebook written to {target}")
