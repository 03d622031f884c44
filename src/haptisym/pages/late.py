"""What reports have besides words, loaded only where one is made: drawings, and what proves an answer anew."""

from __future__ import annotations

from pkgutil import resolve_name
from typing import Any

from haptisym.judge.answers import Answer
from haptisym.model.scene import Scene
from haptisym.writing.document import Figure, Live, Phrase


def drawing(name: str, caption: Phrase, function: str, *given: Any, wide: bool = False) -> Figure:
    """A figure, made by a function below ``haptisym.figures``, ``"module:function"``, of what is given; it is told ``wide``."""
    told = {"wide": True} if wide else {}
    return Figure(name, caption, lambda: resolve_name(f"haptisym.figures.{function}")(*given, **told), wide)


def proof(answer: Answer, scene: Scene) -> Live:
    """The certificate of an answer, with a program that proves it anew where the page is read."""
    return Live(lambda: str(resolve_name("haptisym.pages.checked:checked")(answer, scene)))
