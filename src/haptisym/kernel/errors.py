"""What can go wrong, by name: every message gives the place, the value, the rule and what to write
instead."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple, TypeVar

T = TypeVar("T")


class Setting(NamedTuple):
    """What an error proposes to state: a key with its value, or with a value for each role.

    It is a line of a scene file, unless the question came from a command line.

    >>> str(Setting("averages", 10)), Setting("averages", 10).option
    ('averages = 10', '--averages 10')
    >>> str(Setting("unit", {"phase": "deg"})), Setting("unit", {"phase": "deg"}).option
    ('unit = { phase = "deg" }', '--unit phase=deg')
    """

    key: str
    value: Any

    def __str__(self) -> str:
        if not isinstance(self.value, dict):
            return f"{self.key} = {_literal(self.value)}"
        inside = ", ".join(f"{role} = {_literal(x)}" for role, x in self.value.items())
        return f"{self.key} = {{ {inside} }}"

    @property
    def option(self) -> str:
        """The option of the command line that states the same, once for each role."""
        values = [self.value]
        if isinstance(self.value, dict):
            values = [f"{role}={x}" for role, x in self.value.items()]
        return " ".join(f"--{self.key} {_word(str(x))}" for x in values)


def _literal(value: Any) -> str:
    """A value of a scene file."""
    return _in_quotes(value) if isinstance(value, str) else str(value)


def _word(text: str) -> str:
    """A word of a command line, in quotes where it needs them."""
    is_plain = all(x.isalnum() or x in "-_./:=%+" for x in text)
    return text if is_plain else _in_quotes(text)


def _in_quotes(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'


class HaptisymError(ValueError):
    """Base of all errors that haptisym raises on purpose; the command line prints its text and
    exits with status 2."""


class SceneError(HaptisymError):
    """A scene, a model or one of its parameters breaks a rule.

    Its arguments are the parts of the message: texts, and any ``Setting`` that it proposes.
    """

    def __str__(self) -> str:
        return "".join(map(str, self.args))

    def within(self, place: str) -> SceneError:
        """The same error with its place: ``place: message``."""
        return type(self)(f"{place}: ", *self.args)

    def typed(self, options: Collection[str]) -> SceneError:
        """The same error for a command line that has these options: with them for settings."""
        return type(self)(
            *(
                x.option if isinstance(x, Setting) and f"--{x.key}" in options else x
                for x in self.args
            )
        )

    def written(self) -> SceneError:
        """The same error for a scene file, where settings are lines of that file."""
        return type(self)(str(self))


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
