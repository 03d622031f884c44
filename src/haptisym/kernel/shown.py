"""How values show themselves: a short line each in a session, and in a notebook the formula, table or sentence that they are."""

from __future__ import annotations

from abc import ABC, abstractmethod
from textwrap import shorten

_LINE = 150
"""Characters of a line at most."""
_NOTEBOOK = "haptisym.pages.notebook"


class Viewed:
    """A value that a notebook shows as LaTeX or HTML; what writes them is loaded where one is shown."""

    __slots__ = ()

    def _repr_latex_(self) -> str | None:
        return self._view("latex")

    def _repr_html_(self) -> str | None:
        return self._view("html")

    def _view(self, language: str) -> str | None:
        """None where that language has nothing for such a value."""
        from pkgutil import resolve_name

        found: str | None = resolve_name(f"{_NOTEBOOK}:{language}")(self)
        return found


class Shown(Viewed, ABC):
    """A value that a session shows as one short line: its kind, and what ``_line`` says of it."""

    __slots__ = ()

    @abstractmethod
    def _line(self) -> str:
        """What there is to say of it, in a line."""

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {shorten(self._line(), _LINE, placeholder=' ...')}>"


def titled(title: str) -> str:
    """A title in quotation marks, shortened.

    >>> titled("Numerical example of Fu, van Paassen and Mulder (2019), section 3"), titled("")
    ('"Numerical example of Fu, van Paassen and ..."', '"Untitled scene"')
    """
    return f'"{shorten(title or "Untitled scene", 45, placeholder=" ...")}"'


def counted(number: int, singular: str, plural: str = "") -> str:
    """``1 crossing``, ``2 crossings``, ``no crossings``."""
    return f"{number or 'no'} {singular if number == 1 else plural or f'{singular}s'}"
