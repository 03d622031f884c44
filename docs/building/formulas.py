"""LaTeX of pages and notebooks as MathML, which browsers draw without loading anything."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from docutils import nodes
from latex2mathml.converter import convert

if TYPE_CHECKING:
    from sphinx.application import Sphinx
    from sphinx.writers.html5 import HTML5Translator

_PAIRED = {r"\lvert": r"\left\lvert ", r"\rvert": r"\right\rvert "}
"""Bars that are fences, without the space of an operator."""


def mathml(latex: str, display: str) -> str:
    """Return a formula as MathML.

    >>> mathml("$ x $", "inline").count("<mi>x</mi>")
    1
    >>> mathml(r"c\\lvert x\\rvert", "inline").count("fence")
    2
    """
    bars = re.sub(r"(?<!\\left)\\lvert|(?<!\\right)\\rvert", lambda bar: _PAIRED[bar[0]], latex)
    return convert(bars.strip().strip("$").replace(r"\displaystyle", ""), display=display)


def inline(self: HTML5Translator, node: nodes.math) -> None:
    """Write an inline formula."""
    self.body.append(mathml(node.astext(), "inline"))
    raise nodes.SkipNode


def block(self: HTML5Translator, node: nodes.math_block) -> None:
    """Write a displayed formula; a wide one scrolls."""
    self.body.append(f'<div class="formula">{mathml(node.astext(), "block")}</div>')
    raise nodes.SkipNode


def setup(app: Sphinx) -> None:
    """Register the renderer ``mathml``."""
    app.add_html_math_renderer("mathml", (inline, None), (block, None))
