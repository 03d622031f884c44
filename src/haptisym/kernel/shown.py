"""How values show themselves in a session: a short line each; an answer in print and in a notebook as its page of text."""

from __future__ import annotations

from html import escape
from importlib import import_module
from textwrap import shorten
from typing import Any, ClassVar

_LINE = 150
"""Characters of a line at most."""


class Shown:
    """A value that a session shows as one short line: its kind, and what ``_line`` says of it."""

    __slots__ = ()

    def _line(self) -> str:
        raise NotImplementedError

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {shorten(self._line(), _LINE, placeholder=' ...')}>"


class Answer(Shown):
    """What a verb answers: ``print`` shows the command line's page of text (``str``), and so does a notebook."""

    __slots__ = ()
    _page: ClassVar[str] = ""
    """Where the page of such an answer is written, ``module:function``: loaded when a page is wanted."""

    def document(self) -> Any:
        """The page, a ``haptisym.writing.document.Document`` for any of its writers."""
        module, _, function = self._page.partition(":")
        return getattr(import_module(module), function)(self)

    def __str__(self) -> str:
        return str(import_module("haptisym.writing.plain").plain(self.document()))

    def _repr_html_(self) -> str:
        return f'<pre class="haptisym">{escape(str(self))}</pre>'


def titled(title: str) -> str:
    """A title in quotation marks, shortened.

    >>> titled("Numerical example of Fu, van Paassen and Mulder (2019), section 3"), titled("")
    ('"Numerical example of Fu, van Paassen and ..."', '"Untitled scene"')
    """
    return f'"{shorten(title or "Untitled scene", 45, placeholder=" ...")}"'


def counted(number: int, singular: str, plural: str = "") -> str:
    """``1 crossing``, ``2 crossings``, ``no crossings``."""
    return f"{number or 'no'} {singular if number == 1 else plural or f'{singular}s'}"
