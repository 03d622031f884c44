"""A page as text without its line breaks: what a reader reads, word by word."""

from __future__ import annotations


def lines(page: object) -> list[str]:
    """Of a page, with single spaces."""
    return [" ".join(line.split()) for line in str(page).splitlines()]


def flat(page: object) -> str:
    """The whole of it on one line."""
    return " ".join(" ".join(lines(page)).split())


def row(page: object, head: str) -> str:
    """The first line that begins so, without that beginning."""
    return next(line.removeprefix(f"{head} ") for line in lines(page) if line.startswith(f"{head} "))
