"""The published thresholds as an answer: a table for reading, and for a program."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, ClassVar

from haptisym.judge.answers import Answer
from haptisym.kernel.shown import counted
from haptisym.model.published import Published, published_by_name
from haptisym.verbs.jnd.entry import File


class PublishedThresholds(Answer, tuple[Published, ...]):
    """Published just-noticeable differences, each usable by its name: ``jnd = { like = "viscosity-forced-choice" }``."""

    _schema: ClassVar[str] = "haptisym.published/1"
    _page: ClassVar[str] = "haptisym.pages.jnd:published_page"

    def __new__(cls, found: Iterable[Published]) -> PublishedThresholds:
        return super().__new__(cls, found)

    def _line(self) -> str:
        return counted(len(self), "published threshold")

    @property
    def certified(self) -> bool:
        """False: they were measured."""
        return False

    @property
    def _about(self) -> File:
        return File("Published thresholds")

    def _body(self) -> dict[str, Any]:
        return {"thresholds": [_row(x) for x in self], "certified": self.certified}


def _row(x: Published) -> dict[str, Any]:
    return {
        "name": x.name,
        "quantity": x.quantity,
        "fraction": [float(x.low), float(x.high)],
        "criterion": None if x.criterion is None else float(x.criterion),
        "reference": x.reference,
        "source": x.source,
        "doi": x.doi or None,
        "read": x.read,
        "usable": not x.apart,
    }


def published() -> PublishedThresholds:
    """All published thresholds that the package knows, with their sources.

    >>> [x.name for x in published() if x.criterion]
    ['steering-wheel', 'viscosity-forced-choice', 'viscosity-matching']
    """
    return PublishedThresholds(published_by_name().values())
