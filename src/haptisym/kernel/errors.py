"""What can go wrong, by name: every message says the thing, the value, the rule and the way out."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import TypeVar

T = TypeVar("T")


class HaptisymError(ValueError):
    """Base of all errors that haptisym raises on purpose; the command line prints its text and exits with status 2."""


class SceneError(HaptisymError):
    """A scene, a model or one of its parameters breaks a rule."""

    def within(self, place: str) -> SceneError:
        """The same error, saying where: ``place: message``."""
        return type(self)(f"{place}: {self}")


@contextmanager
def within(place: str) -> Iterator[None]:
    """A SceneError of what is done inside says where."""
    try:
        yield
    except SceneError as error:
        raise error.within(place) from None


class SignError(SceneError):
    """A parameter has a sign that its model does not allow."""


class ExpressionError(SceneError):
    """A formula in a scene is not in the grammar; the message points at the place."""


class NothingToDrawError(SceneError):
    """An answer holds nothing that its figure would show."""


class UndecidedError(HaptisymError):
    """A question stayed open at the precision limit; no guess is returned instead (exit status 3)."""


class LimitError(UndecidedError):
    """A question stayed open because the time that it was given is over; more of it may answer it (exit status 3)."""


def meant(given: str, valid: Iterable[str]) -> str:
    """A question to stand before the list of valid names: what a name that is none of them is close to, or the end of.

    >>> meant("zta", ["zeta", "omega_n"]), meant("zeta", ["effects.filter.zeta"]), meant("x", ["zeta"])
    ('did you mean "zeta"? ', 'did you mean "effects.filter.zeta"? ', '')
    """
    from difflib import get_close_matches  # where something went wrong

    names = list(valid)
    close = [x for x in names if x.endswith(f".{given}")][:1] or get_close_matches(given, names, n=1)
    return f'did you mean "{close[0]}"? ' if close else ""


def quoted(given: object) -> str:
    """What was given, in quotes, not at length.

    >>> quoted("9" * 100) == '"' + "9" * 60 + '..."'
    True
    """
    text = str(given)
    return f'"{text[:60]}..."' if len(text) > 60 else f'"{text}"'


def need(key: str, given: object, kind: type | tuple[type, ...], told: str) -> None:
    """SceneError where something is of another type than it must be. ``told`` : what to give instead.

    >>> need("environment", 3, str, "give a name")
    Traceback (most recent call last):
    haptisym.kernel.errors.SceneError: environment: "3" will not do: give a name
    """
    if not isinstance(given, kind):
        raise SceneError(f"{key}: {quoted(given)} will not do: {told}")


def several(key: str, given: Iterable[T], told: str) -> tuple[T, ...]:
    """What was given as several things, in a tuple; SceneError for a single one. ``told`` : what to give instead."""
    if isinstance(given, str | bytes) or not isinstance(given, Iterable):
        raise SceneError(f"{key}: {quoted(given)} will not do: {told}")
    return tuple(given)
