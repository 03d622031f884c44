"""The base class of the results of all commands: each prints a page, gives a JSON document and a
figure, and states what of it is proven."""

from __future__ import annotations

import json
from abc import abstractmethod
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path
from pkgutil import resolve_name
from typing import Any, ClassVar, Protocol

from haptisym.kernel.errors import SceneError
from haptisym.kernel.objects import Shown, copied


class Subject(Protocol):
    """The subject of an answer: a scene, or several."""

    @property
    def title(self) -> str:
        """Its title."""

    def asides(
        self, besides: Collection[str] = (), varied: Collection[str] | None = ()
    ) -> list[str]:
        """As ``Scene.asides``."""

    def aside_keys(
        self, besides: Collection[str] = (), varied: Collection[str] | None = ()
    ) -> dict[str, Any]:
        """As ``Scene.aside_keys``."""


@dataclass(frozen=True)
class NoScene:
    """The subject of an answer that is about no scene: it has a title, and no parameters to comment
    on."""

    title: str

    def asides(
        self, besides: Collection[str] = (), varied: Collection[str] | None = ()
    ) -> list[str]:
        """Nothing: no parameter is nominal."""
        return []

    def aside_keys(
        self, besides: Collection[str] = (), varied: Collection[str] | None = ()
    ) -> dict[str, Any]:
        """Nothing."""
        return {}


class Answer(Shown):
    """The result of a command: ``print`` and a notebook show the command line's page, ``to_json``
    gives the document.

    A subclass defines its subject, ``_about``, its document, ``_body``, the ``_schema`` of that,
    and the functions that write its ``_page``, draw its ``_figure`` (``figures.files.Drawings``)
    and prove it (``_certificate``): these by name, as ``"package.module:name"``, so that none is
    loaded before it is needed.
    """

    __slots__ = ()
    _schema: ClassVar[str]
    _page: ClassVar[str]
    _figure: ClassVar[str]
    _certificate: ClassVar[str] = ""
    _is_in_lines: ClassVar[bool] = False
    """Whether its main table, for a paper, is the lines of its page, whatever tables it has."""

    __reduce__ = copied

    @property
    def certified(self) -> bool:
        """Whether every number here is proven, none estimated, and nothing was left undecided."""
        return True

    @property
    def settled(self) -> bool:
        """Whether no question stayed undecided; else the command line exits with status 3."""
        return self.certified

    @property
    def _about(self) -> Subject:
        """The subject of the answer."""
        subject: Subject = self.scene  # type: ignore[attr-defined]
        return subject

    @property
    def _varied(self) -> tuple[Collection[str], Collection[str] | None]:
        """The two arguments of ``Scene.asides``: the parameters that the answer lets vary besides
        the scene's ranges, and those of which it is reported if they exist twice (None: all)."""
        return (), ()

    def asides(self) -> list[str]:
        """Notes to print with the answer: which parameters have ranges and are nominal here, and
        which exist twice."""
        return self._about.asides(*self._varied)

    @abstractmethod
    def _body(self) -> dict[str, Any]:
        """The keys of a document that only this kind of answer has."""

    def _left(self) -> dict[str, Any]:
        """The keys that are present only where something is undecided or was left out."""
        return {}

    def to_dict(self) -> dict[str, Any]:
        """The document that the command line prints with ``--json``."""
        # The order of the keys is that of the printed document.
        frame = {"schema": self._schema, "title": self._about.title}
        return frame | self._body() | self._about.aside_keys(*self._varied) | self._left()

    def to_json(self) -> str:
        """The same as text."""
        return json.dumps(self.to_dict(), indent=2, ensure_ascii=False)

    def figure(self, *, style: str = "") -> Any:
        """The figure, of matplotlib. NothingToDrawError where there is nothing in the answer to
        draw.

        ``style`` : "paper" for one column of a journal: 3.4 in wide, all text of 8 pt, in greys.
        """
        return resolve_name("haptisym.figures.files:draw_figure")(self, style=style)

    def save_figure(
        self,
        path: str | Path,
        *,
        format: str = "",  # noqa: A002  as matplotlib calls it
        style: str = "",
    ) -> Path:
        """Write the figure, as the name ends: .svg, .pdf or .png; the same file for the same
        answer.

        ``format`` : the ending of a name that has none. ``style`` : as of ``figure``.
        """
        checked = resolve_name("haptisym.figures.pen:checked")(path, format)
        figure = self.figure(style=style)
        target: Path = resolve_name("haptisym.figures.files:save_as")(figure, checked)
        return target

    def save_figures(
        self,
        folder: str | Path,
        *,
        format: str = "",  # noqa: A002
        style: str = "",
    ) -> list[Path]:
        """Write all figures to a folder, each as SVG, PDF and PNG. NothingToDrawError where there
        is nothing to draw.

        ``format`` : "svg", "pdf" or "png" for this one alone. ``style`` : as of ``figure``.
        """
        save = resolve_name("haptisym.figures.files:save_figures")
        files: list[Path] = save(self, folder, format, style)
        return files

    def plot(
        self,
        ax: Any = None,
        *,
        kind: str = "",
        color: str | None = None,
        label: str = "",
        style: str = "",
        **look: Any,
    ) -> Any:
        """Draw it on axes of matplotlib, which are returned; a further scene on the same axes has
        the next colour, and its label stands at its curves.

        ``ax`` : None for new ones, of pyplot, which a notebook shows. ``kind`` : what is drawn,
        where there are several kinds; an error lists them. ``color``, ``label`` : of the scene.
        ``style`` : as of ``figure``. ``look`` : of the curves, as matplotlib's ``Line2D`` takes it.

        >>> from haptisym import evaluate
        >>> from matplotlib.figure import Figure
        >>> ax = evaluate("fu2019").plot(Figure().add_subplot(), label="filter", linewidth=2)
        >>> evaluate("helicopter-cyclic").plot(ax, label="stick").get_xlabel()
        '$\\\\omega$ (rad/s)'
        """
        styled = resolve_name("haptisym.figures.pen:styled")(style)
        draw = resolve_name("haptisym.figures.files:plot")
        return draw(self, ax, kind, color, label, styled, look)

    def certificate(self) -> str:
        """The answer with a proof that ``python -m haptisym_check`` checks, as JSON. SceneError
        where there is none."""
        if not self._certificate:
            raise SceneError(
                f"{type(self).__name__} has no certificate: evaluate, require and stability "
                f"write one"
            )
        text: str = resolve_name(self._certificate)(self)
        return text

    def document(self) -> Any:
        """The page, a ``haptisym.writing.document.Document`` for any of its writers; text where it
        is not one yet."""
        return resolve_name(self._page)(self)

    def __str__(self) -> str:
        page = self.document()
        return (
            page
            if isinstance(page, str)
            else str(resolve_name("haptisym.writing.plain:plain")(page))
        )
