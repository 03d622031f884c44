"""What a user meets says what it is, and so does what stands inside."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from types import ModuleType

import pytest

import haptisym as hs
import haptisym_check


def function_of(member: object) -> object:
    """The function that stands behind a method or a property."""
    for key in ("fget", "func", "__func__"):
        member = getattr(member, key, None) or member
    return member


def modules(package: ModuleType) -> Iterator[ModuleType]:
    """Of a package, however deep, but for what runs when it is imported."""
    for found in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
        if not found.name.endswith("__main__"):
            yield importlib.import_module(found.name)


def definitions(module: ModuleType) -> Iterator[tuple[str, list[object]]]:
    """Public functions, classes and their public methods, each with what may explain it: itself, and the same of its bases."""
    for name, thing in vars(module).items():
        if name.startswith("_") or getattr(thing, "__module__", None) != module.__name__:
            continue
        if inspect.isfunction(thing) or inspect.isclass(thing):
            yield name, [thing]
        for key, member in vars(thing).items() if inspect.isclass(thing) else ():
            function = function_of(member)
            if key.startswith("_") or not inspect.isfunction(function) or function.__module__ != module.__name__:
                continue
            if function.__name__ != "<lambda>":
                yield f"{name}.{key}", [function_of(vars(x)[key]) for x in thing.__mro__ if key in vars(x)]


def told(thing: object) -> bool:
    """Whether it has a docstring of its own: a data class is given its signature."""
    text = getattr(thing, "__doc__", None) or ""
    return bool(text) and not (inspect.isclass(thing) and text.startswith(f"{thing.__name__}("))


def untold(package: ModuleType) -> list[str]:
    """Definitions that neither they themselves nor a base explain."""
    return [
        f"{module.__name__}: {name}"
        for module in modules(package)
        for name, told_by in definitions(module)
        if not any(map(told, told_by))
    ]


@pytest.mark.parametrize("package", [hs, haptisym_check])
def test_each_public_definition_says_what_it_is(package: ModuleType) -> None:
    assert untold(package) == []


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
