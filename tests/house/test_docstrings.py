"""What a user meets says what it is; of what stands inside, nearly all does."""

from __future__ import annotations

import ast
import inspect
from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from pathlib import Path
from types import ModuleType

import pytest

import haptisym as hs
import haptisym_check

SOURCES = [Path(x.__file__).parent for x in (hs, haptisym_check) if x.__file__]
MOST_WITHOUT = 230
"""Definitions inside without a docstring, mostly one-line methods that a base class explains; never to be raised."""


def definitions(path: Path) -> Iterator[tuple[str, ast.AST]]:
    """Public functions, classes and their public methods."""
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef) and not node.name.startswith("_"):
            yield node.name, node
            for inner in node.body if isinstance(node, ast.ClassDef) else ():
                if isinstance(inner, ast.FunctionDef) and not inner.name.startswith("_"):
                    yield f"{node.name}.{inner.name}", inner


def test_fewer_definitions_than_ever_have_no_docstring() -> None:
    paths = sorted(path for folder in SOURCES for path in folder.rglob("*.py"))
    without = [
        f"{path.name}: {name}" for path in paths for name, node in definitions(path) if not ast.get_docstring(node)
    ]
    assert len(without) <= MOST_WITHOUT, without


def members(name: str) -> Iterator[tuple[str, object]]:
    """What a public name offers: itself, and of a class what the package gives it."""
    thing = getattr(hs, name)
    yield name, thing
    if not isinstance(thing, type):
        return
    data = {x.name for x in fields(thing)} if is_dataclass(thing) else set()
    for base in thing.__mro__:
        if base.__module__.partition(".")[0] != "haptisym":
            continue
        for key, value in vars(base).items():
            if not key.startswith("_") and key not in data and (callable(value) or hasattr(value, "__get__")):
                yield f"{name}.{key}", getattr(thing, key)


def is_told(what: str, thing: object) -> bool:
    """Whether it says what it is; values without a place for a docstring are spared."""
    if isinstance(thing, type | ModuleType) or callable(thing) or isinstance(thing, property) or hasattr(thing, "func"):
        return bool(inspect.getdoc(thing) or is_told_by_a_base(what))
    return True


def is_told_by_a_base(what: str) -> bool:
    """Whether a base of the class explains a member."""
    name, _, key = what.partition(".")
    bases = getattr(hs, name).__mro__ if key else ()
    return any(inspect.getdoc(vars(base)[key]) for base in bases if key in vars(base))


@pytest.mark.parametrize("name", hs.__all__)
def test_everything_that_a_public_name_offers_says_what_it_is(name: str) -> None:
    assert [what for what, thing in members(name) if not is_told(what, thing)] == []
