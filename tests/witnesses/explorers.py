"""The explorer of a page in a browser, as a reader uses it."""

from __future__ import annotations

import time

from browser import Browser


def typed(opened: Browser, identity: str, value: str | float) -> None:
    """Replace the number in a box by another one, by the keyboard."""
    opened.value(f"(() => {{ const box = document.getElementById('{identity}-value'); box.focus(); box.select(); }})()")
    opened.call("Input.insertText", text=str(value))


def proven(opened: Browser) -> str:
    """What the explorer says in exact arithmetic once its sliders rest; "none" where it proves nothing."""
    for _ in range(200):
        if said := opened.value("(document.getElementById('explorer-proven') || {textContent: 'none'}).textContent"):
            return str(said)
        time.sleep(0.05)
    return ""
