"""What is said against a question that cannot be answered."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import haptisym as hs


def refusal(call: Callable[..., Any], *arguments: Any, **keys: Any) -> str:
    """The sentence of a ``SceneError``; empty where nothing is said against it."""
    try:
        call(*arguments, **keys)
    except hs.SceneError as error:
        return str(error)
    return ""
