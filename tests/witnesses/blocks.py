"""Blocks of a page whose pictures are never drawn."""

from __future__ import annotations

from typing import Any

from haptisym.writing.document import Figure


def figure(name: str, *, wide: bool = False) -> Figure:
    """Only its name and caption may be asked for."""

    def never() -> Any:
        raise AssertionError("nothing is drawn here")

    return Figure(name, f"What {name} shows", never, wide)
