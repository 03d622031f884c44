"""Output, help, errors and docs are in the terms of the field, and short."""

from __future__ import annotations

import ast
import inspect
import re
from collections.abc import Iterator
from html import unescape
from pathlib import Path

import click
import pytest
from explorers import undrawn

import haptisym as hs
from haptisym import effects, environments, interop
from haptisym.cli import VERBS, app
from haptisym.writing.latex import latex

ROOT = Path(__file__).parents[2]
SOURCE = ROOT / "src" / "haptisym"

DIALECT = {
    r"\bimposed\b": "prescribed",
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


def dialect(text: str) -> list[str]:
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
    assert path.stem == "certificates" or dialect("\n".join(lines)) == []


@pytest.mark.parametrize("verb", VERBS)
def test_every_option_has_help_and_that_is_in_the_terms_of_the_field(verb: str) -> None:
    """The page of every option is made of it. What has none does nothing but say what to write instead."""
    command = app.get_command(click.Context(app), verb)
    assert command is not None
    options = [x for x in command.params if isinstance(x, click.Option)]
    assert [x.name for x in options if not x.help and (x.expose_value or not x.hidden)] == []
    assert dialect("\n".join([command.help or "", *(x.help or "" for x in options)])) == []


PROSE = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]


@pytest.mark.parametrize("path", PROSE, ids=lambda path: path.stem)
def test_docs_are_in_the_terms_of_the_field(path: Path) -> None:
    prose = re.sub(r"```.*?```", " ", path.read_text(encoding="utf-8"), flags=re.DOTALL)
    assert dialect(prose) == []


def public_docstrings() -> Iterator[tuple[str, str]]:
    """Each public name, and each public member of a class, with its docstring without examples."""
    named = {name: getattr(hs, name) for name in hs.__all__}
    for module in (environments, effects, interop):
        own = {name: x for name, x in vars(module).items() if getattr(x, "__module__", "") == module.__name__}
        named |= {f"{module.__name__}.{name}": x for name, x in own.items() if name[0] != "_"}
    members = {
        f"{owner}.{name}": x.fget if isinstance(x, property) else x
        for owner, thing in named.items()
        if isinstance(thing, type)
        for name, x in vars(thing).items()
        if name[0] != "_"
    }
    for name, thing in {**named, **members}.items():
        if callable(thing) and str(getattr(thing, "__module__", "")).startswith("haptisym"):
            yield (
                name,
                re.sub(r"``.*?``|^>>>.*?(?=\n\n|\Z)", " ", inspect.getdoc(thing) or "", flags=re.DOTALL | re.MULTILINE),
            )


def test_the_reference_of_python_is_in_the_terms_of_the_field() -> None:
    documented = dict(public_docstrings())
    assert len(documented) > 300
    assert {name: found for name, text in documented.items() if (found := dialect(text))} == {}


ELSEWHERE = ("verbs/stability/margins.py",)
"""Modules with errors that are still to be rewritten."""


def errors(path: Path) -> str:
    """The texts of all errors that a module raises."""
    raised = [
        x.exc for x in ast.walk(ast.parse(path.read_text(encoding="utf-8"))) if isinstance(x, ast.Raise) and x.exc
    ]
    texts = [x.value for error in raised for x in ast.walk(error) if isinstance(x, ast.Constant)]
    return "\n".join(x for x in texts if isinstance(x, str))


def test_errors_are_in_the_terms_of_the_field() -> None:
    paths = [x for x in SOURCE.rglob("*.py") if not x.relative_to(SOURCE).as_posix().startswith(ELSEWHERE)]
    assert {path.name: found for path in paths if (found := dialect(errors(path)))} == {}


def test_the_docs_have_at_most_19000_words() -> None:
    assert sum(len(x.read_text(encoding="utf-8").split()) for x in (ROOT / "docs").glob("*.md")) <= 19_000
    assert len((ROOT / "README.md").read_text(encoding="utf-8").splitlines()) <= 120


def test_each_page_of_the_docs_opens_with_what_one_can_do_after_it() -> None:
    pages = [x for x in (ROOT / "docs").glob("*.md") if x.stem != "index"]
    opening = {x.stem: x.read_text(encoding="utf-8").split("\n\n")[1] for x in pages}
    assert [name for name, words in opening.items() if not re.match(r"After this page you (can|know) ", words)] == []


def test_paragraphs_of_the_docs_have_at_most_five_lines() -> None:
    for path in PROSE:
        prose = re.sub(r"```.*?```", " ", path.read_text(encoding="utf-8"), flags=re.DOTALL)
        for paragraph in prose.split("\n\n"):
            lines = paragraph.strip().splitlines()
            assert len(lines) <= 5 or re.match(r"[|#-]|\d\.|\$\$", lines[0]), (path.name, lines[0])


DOCUMENTS = {
    "a continuous device": lambda: hs.evaluate("fu2019"),
    "a sampled device": lambda: hs.evaluate("sampled-wall"),
    "a teleoperator": lambda: hs.evaluate("position-force-teleoperation"),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", DOCUMENTS)
def test_documents_are_in_the_terms_of_the_field(name: str) -> None:
    """All that a document of LaTeX and a report contain in full, but for formulas."""
    answer = DOCUMENTS[name]()
    formulas = r"\$[^$]*\$|\\\[.*?\\\]|\\begin\{(align\*)\}.*?\\end\{\1\}|\\[A-Za-z]+\*?"
    paper = re.sub(formulas, " ", latex(answer.document()), flags=re.DOTALL)
    report = unescape(re.sub(r"<(style|script|math)\b.*?</\1>|<[^>]*>", " ", undrawn(answer), flags=re.DOTALL))
    for text in (paper, report):
        words = " ".join(text.split())
        assert "The relative distortion, not to be confused with them, is" in words  # the derivation is there
        assert dialect(words) == []
