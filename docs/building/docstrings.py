"""Docstrings of the package, which are prose with ``names`` and examples, as reStructuredText."""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import groupby
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sphinx.application import Sphinx


def escaped(line: str) -> str:
    """Escape a line of prose whose only marks are double backquotes.

    >>> escaped("r_r = |Re dH|/|H_env|, *not* ``a|b`` omega_")
    'r_r = \\\\|Re dH\\\\|/\\\\|H_env\\\\|, \\\\*not\\\\* ``a|b`` omega\\\\_'
    """
    return "".join(
        x if x.startswith("``") else re.sub(r"([\\*|`]|_(?!\w))", r"\\\1", x) for x in re.split(r"(``.+?``)", line)
    )


def paragraphs(lines: list[str]) -> Iterator[list[str]]:
    """Escape prose; leave examples, tables and indented text."""
    for is_blank, group in groupby(lines, key=lambda line: not line.strip()):
        block = list(group)
        if is_blank or block[0].startswith(">>>"):
            yield block
        elif all(line.startswith("    ") for line in block):
            yield ["::", "", *block]
        else:
            yield entries(block)


def entries(block: list[str]) -> list[str]:
    """Return a paragraph; one that explains names, ``name`` : meaning, becomes a list."""
    text = " ".join(line.strip() for line in block)
    parts = re.split(r"(?:^|(?<=[.;] ))(?=``[^`]+``(?:, ``[^`]+``)* ?: |Guaranteed: |Raises |SceneError )", text)
    named = [x.strip() for x in parts if x.strip()]
    if not any(re.match(r"``[^`]+``(, ``[^`]+``)* ?: ", x) for x in named):
        return [escaped(line.strip()) for line in block]
    return [line for x in named for line in (("- " if x.startswith("``") else "") + escaped(x), "")]


def plain(_app: object, _what: str, _name: str, _thing: object, _options: object, lines: list[str]) -> None:
    """Convert a docstring in place, for autodoc."""
    lines[:] = [line for block in paragraphs(lines) for line in block] + [""]


def setup(app: Sphinx) -> None:
    """Connect to every docstring that autodoc reads."""
    app.connect("autodoc-process-docstring", plain)
