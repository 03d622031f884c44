"""Docstrings of the package are prose with ``names`` and examples; here they become what Sphinx reads, word for word."""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import groupby
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sphinx.application import Sphinx


def escaped(line: str) -> str:
    """A line of prose whose only marks are double backquotes.

    >>> escaped("r_r = |Re dH|/|H_env|, *not* ``a|b`` omega_")
    'r_r = \\\\|Re dH\\\\|/\\\\|H_env\\\\|, \\\\*not\\\\* ``a|b`` omega\\\\_'
    """
    return "".join(
        x if x.startswith("``") else re.sub(r"([\\*|`]|_(?!\w))", r"\\\1", x) for x in re.split(r"(``.+?``)", line)
    )


def paragraphs(lines: list[str]) -> Iterator[list[str]]:
    """Prose escaped; examples, tables and what is indented as they are."""
    for is_blank, group in groupby(lines, key=lambda line: not line.strip()):
        block = list(group)
        if is_blank or block[0].startswith(">>>"):
            yield block
        elif all(line.startswith("    ") for line in block):
            yield ["::", "", *block]
        else:
            yield entries(block)


def entries(block: list[str]) -> list[str]:
    """A paragraph; one that tells of names, ``name`` : what it is, as a list of them."""
    text = " ".join(line.strip() for line in block)
    parts = re.split(r"(?:^|(?<=[.;] ))(?=``[^`]+``(?:, ``[^`]+``)* ?: |Guaranteed: |Raises |SceneError )", text)
    told = [x.strip() for x in parts if x.strip()]
    if not any(re.match(r"``[^`]+``(, ``[^`]+``)* ?: ", x) for x in told):
        return [escaped(line.strip()) for line in block]
    return [line for x in told for line in (("- " if x.startswith("``") else "") + escaped(x), "")]


def plain(_app: object, _what: str, _name: str, _thing: object, _options: object, lines: list[str]) -> None:
    """In place, as autodoc wants it."""
    lines[:] = [line for block in paragraphs(lines) for line in block] + [""]


def setup(app: Sphinx) -> None:
    """For every docstring that autodoc reads."""
    app.connect("autodoc-process-docstring", plain)
