"""What can go wrong, by name: every message gives the place, the value, the rule and what to write
instead."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import TypeVar

T = TypeVar("T")


class HaptisymError(ValueError):
    """Base of all errors that haptisym raises on purpose; the command line prints its text and
    exits with status 2."""


class SceneError(HaptisymError):
    """A scene, a model or one of its parameters breaks a rule."""

    def within(self, place: str) -> SceneError:
        """The same error with its place: ``place: message``."""
        return type(self)(f"{place}: {self}")


@contextmanager
def within(place: str) -> Iterator[None]:
    """Add the place to a SceneError that is raised inside."""
    try:
        yield
    except SceneError as error:
        raise error.within(place) from None


class SignError(SceneError):
    """A parameter has a sign that its model does not allow; ``bound`` : ``k >= 0 (is -5 N/m)``;
    ``zero`` : the value is 0."""

    bound: str = ""
    zero: bool = False


class ExpressionError(SceneError):
    """A formula in a scene is not in the grammar; the message points at the character."""


class NothingToDrawError(SceneError):
    """A result contains nothing that its figure would show."""


class UndecidedError(HaptisymError):
    """A question is undecided at the precision limit; no guess is returned instead (exit status
    3)."""


class LimitError(UndecidedError):
    """A question is undecided at the limit in time; a longer limit may decide it (exit status
    3)."""


def meant(given: str, valid: Iterable[str]) -> str:
    """``did you mean "x"? ``: the valid name that an unknown one is near to, part of or begins;
    empty if there is none.

    >>> meant("zta", ["zeta", "omega_n"]), meant("zeta", ["effects.filter.zeta"]), meant("K", ["k"]), meant("x", ["zeta"])
    ('did you mean "zeta"? ', 'did you mean "effects.filter.zeta"? ', 'did you mean "k"? ', '')
    """
    from difflib import get_close_matches  # where something went wrong

    names, small = list(valid), given.lower()
    parts = [x for x in names if f".{small}." in f".{x.lower()}."]
    begun = [x for x in names if len(small) > 2 and x.lower().startswith(small)]
    close = [
        *parts,
        *get_close_matches(given, names, n=1),
        *begun,
        *get_close_matches(small, names, n=1),
    ]
    return f'did you mean "{close[0]}"? ' if close else ""


def quoted(given: object) -> str:
    """A value in quotes, at most 60 characters of it.

    >>> quoted("9" * 100) == '"' + "9" * 60 + '..."'
    True
    """
    text = str(given)
    return f'"{text[:60]}..."' if len(text) > 60 else f'"{text}"'


def need(key: str, given: object, kind: type | tuple[type, ...], instead: str) -> None:
    """SceneError for a value of another type. ``instead`` : what to give.

    >>> need("environment", 3, str, "give a name")
    Traceback (most recent call last):
    haptisym.kernel.errors.SceneError: environment: "3": give a name
    """
    if not isinstance(given, kind):
        raise SceneError(f"{key}: {quoted(given)}: {instead}")


def several(key: str, given: Iterable[T], instead: str) -> tuple[T, ...]:
    """Several values, as a tuple; SceneError for a single one. ``instead`` : what to give."""
    if isinstance(given, str | bytes) or not isinstance(given, Iterable):
        raise SceneError(f"{key}: {quoted(given)}: {instead}")
    return tuple(given)
