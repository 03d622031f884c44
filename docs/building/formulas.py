"""LaTeX of pages and of what notebooks show, set as MathML: browsers draw it themselves, and nothing is loaded for it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from docutils import nodes
from latex2mathml.converter import convert

if TYPE_CHECKING:
    from sphinx.application import Sphinx
    from sphinx.writers.html5 import HTML5Translator


def mathml(latex: str, display: str) -> str:
    """A formula.

    >>> mathml("$ x $", "inline").count("<mi>x</mi>")
    1
    """
    return convert(latex.strip().strip("$").replace(r"\displaystyle", ""), display=display)


def inline(self: HTML5Translator, node: nodes.math) -> None:
    """A formula in a line."""
    self.body.append(mathml(node.astext(), "inline"))
    raise nodes.SkipNode


def block(self: HTML5Translator, node: nodes.math_block) -> None:
    """A formula of its own; a wide one scrolls."""
    self.body.append(f'<div class="formula">{mathml(node.astext(), "block")}</div>')
    raise nodes.SkipNode


def setup(app: Sphinx) -> None:
    """Make it the renderer ``mathml``."""
    app.add_html_math_renderer("mathml", (inline, None), (block, None))
