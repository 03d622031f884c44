"""List what the pages of a built site would load from outside: ``python docs/building/outside.py build/site``; must be none."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path

LOADED = {"src", "srcset", "data", "poster", "xlink:href", "action", "formaction"}
"""Attributes that make a browser load something; of ``link`` it is ``href``, of ``a`` it is not."""
OUTSIDE = re.compile(r"^\s*(?:[a-z]+:)?//", re.IGNORECASE)
IN_STYLES = re.compile(r"(?:url\(|@import)\s*[\"']?\s*((?:https?:)?//[^\"')\s]+)", re.IGNORECASE)
IN_SCRIPTS = re.compile(r"(?:fetch|import|importScripts|WebSocket|EventSource)\s*\(\s*[\"'`]((?:https?|wss?):[^\"'`]+)")


class Page(HTMLParser):
    """Collects the addresses that a page loads."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.found: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """One element."""
        for name, value in attrs:
            loads = name in LOADED or (name == "href" and tag in ("link", "image", "use", "base"))
            if loads and tag != "form" and OUTSIDE.match(value or ""):
                self.found.append(f"<{tag} {name}={value}>")


def outside(folder: Path) -> Iterator[str]:
    """Where in a site something is loaded from outside, and what."""
    for path in sorted(folder.rglob("*")):
        if path.suffix not in (".html", ".css", ".js", ".svg"):
            continue
        text = path.read_text(encoding="utf-8")
        found = Page(text).found if path.suffix in (".html", ".svg") else []
        found += IN_STYLES.findall(text) if path.suffix != ".js" else IN_SCRIPTS.findall(text)
        yield from (f"{path.relative_to(folder)}: {x}" for x in found)


if __name__ == "__main__":
    faults = list(outside(Path(sys.argv[1])))
    print("\n".join(faults) or "nothing is loaded from outside")
    sys.exit(bool(faults))
