"""Output, help and docs are in the field's terms: words of a dialect that had grown are not there, but for listed uses."""

from __future__ import annotations

import re
from pathlib import Path

import click
import pytest

from haptisym.cli import VERBS, app

ROOT = Path(__file__).parents[2]

DIALECT = {
    r"imposed motion": "prescribed motion",
    r"(every|any) passive hand": "any passive operator; passive",
    r"may hold it": "passive",
    r"gives energy away|draws (the )?energy": "generates energy",
    r"makes up for": "compensates",
    r"works? by a clock|with a clock|the clock's": "sampled",
    r"how far .{0,20} may go": "stability limits",
    r"on neither side": "unstable on both sides",
    r"looked at": "searched, tested",
    r"again and again|\bfor ever\b": "at infinitely many higher frequencies",
    r"whatever its|any .{0,20} whatever": "for any",
    r"\bbinds?\b": "limited by",
    r"will do\b": "satisfies",
    r"(left|stays?|stayed) open": "undecided",
    r"meets? (its|their|the) thresholds?": "crosses its threshold",
    r"none (is )?missed|none invented": "all",
    r"change over\b": "changeover frequency",
    r"written out": "expanded",
    r"in lowest terms": "common factors cancelled",
    r"without dimensions": "dimensionless",
    r"\bfar out\b": "at high frequency",
    r"\b(tell|tells|told)\b": "print, report",
    r"\b(says?|said)\b": "is, gives",
    r"\bbeside\b": "next to, compared with",
    r"\balike\b": "equal, in the same way",
    r"as far as": "up to, where",
    r"\bwitness": "independent check",
    r"right digits": "correct digits",
    r"made up\b": "synthetic",
    r"\b(certain|guaranteed|certainly)\b": "proven",
}
"""What is not written, and what is instead."""


def found(text: str) -> list[str]:
    """The words of the dialect in a text, with what stands around them."""
    plain = re.sub(r"`[^`]*`|```.*?```", " ", text, flags=re.DOTALL)
    return [
        f"{plain[max(0, x.start() - 30) : x.end() + 30]!r}: {better}"
        for pattern, better in DIALECT.items()
        for x in re.finditer(pattern, plain, re.IGNORECASE)
    ]


@pytest.mark.parametrize("path", sorted((ROOT / "tests" / "golden").glob("*.txt")), ids=lambda path: path.stem)
def test_pages_are_in_the_terms_of_the_field(path: Path) -> None:
    lines = [x for x in path.read_text(encoding="utf-8").splitlines() if "damper alike" not in x]  # a source's words
    assert path.stem == "certificates" or found("\n".join(lines)) == []


@pytest.mark.parametrize("verb", VERBS)
def test_help_is_in_the_terms_of_the_field(verb: str) -> None:
    command = app.get_command(click.Context(app), verb)
    assert command is not None
    text = "\n".join([command.help or "", *(x.help or "" for x in command.params if isinstance(x, click.Option))])
    assert found(text) == []


DOCS = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]


@pytest.mark.parametrize("path", DOCS, ids=lambda path: path.stem)
def test_docs_are_in_the_terms_of_the_field(path: Path) -> None:
    prose = re.sub(r"```.*?```", " ", path.read_text(encoding="utf-8"), flags=re.DOTALL)
    assert found(prose) == []
