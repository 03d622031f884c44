"""The base of all values: they show themselves in a line, as a formula or as a table, and can be
copied exactly, also to another process.

In a session a value is one short line; in a notebook it is the formula, table or sentence that it
is. FLINT's numbers have no pickles of their own: balls, polynomials and their contexts are packed
part by part, so that an answer can go to another process.
"""

from __future__ import annotations

import pickle
from abc import ABC, abstractmethod
from functools import cached_property
from io import BytesIO
from textwrap import shorten
from typing import Any

from flint import (
    Ordering,
    acb,
    arb,
    arb_mat,
    arb_poly,
    fmpq_mpoly,
    fmpq_mpoly_ctx,
    fmpq_poly,
    fmpz_poly,
)

_LINE = 150
"""Characters of a line at most."""
_NOTEBOOK = "haptisym.pages.notebook"


class Viewed:
    """A value that a notebook shows as LaTeX or HTML; what writes them is loaded where one is
    shown."""

    __slots__ = ()

    def _repr_latex_(self) -> str | None:
        return viewed(self, "latex")

    def _repr_html_(self) -> str | None:
        return viewed(self, "html")


def viewed(thing: object, language: str) -> str | None:
    """The text of a value in a language of notebooks; None where its kind has none."""
    from pkgutil import resolve_name

    found: str | None = resolve_name(f"{_NOTEBOOK}:as_{language}")(thing)
    return found


class Shown(Viewed, ABC):
    """A value that a session shows as one short line: its kind, and what ``_line`` says of it."""

    __slots__ = ()

    @abstractmethod
    def _line(self) -> str:
        """What there is to say of it, in a line."""

    def __repr__(self) -> str:
        from pkgutil import resolve_name

        line = shorten(self._line(), _LINE, placeholder=" ...")
        return (
            f"<{type(self).__name__} {resolve_name('haptisym.writing.characters:printable')(line)}>"
        )


def titled(title: str) -> str:
    """A title in quotation marks, shortened.

    >>> titled("Numerical example of Fu, van Paassen and Mulder (2019), section 3"), titled("")
    ('"Numerical example of Fu, van Paassen and ..."', '"Untitled scene"')
    """
    return f'"{shorten(title or "Untitled scene", 45, placeholder=" ...")}"'


def counted(number: int, singular: str, plural: str = "") -> str:
    """``1 crossing``, ``2 crossings``, ``no crossings``."""
    return f"{number or 'no'} {singular if number == 1 else plural or f'{singular}s'}"


def packed(thing: object) -> bytes:
    """An object as bytes, without what was computed from it and kept with it; ``unpacked`` gives
    its like.

    Middles of balls are the same to the last bit, radii never smaller, and larger by a billionth at
    most.

    >>> unpacked(packed([arb(1) / 3]))[0].contains(arb(1) / 3)
    True
    """
    into = BytesIO()
    _Pickler(into, protocol=pickle.HIGHEST_PROTOCOL).dump(thing)
    return into.getvalue()


def unpacked(found: bytes) -> Any:
    """A copy of the object that was packed."""
    return pickle.loads(found)


def copied(thing: Any) -> tuple[Any, ...]:
    """The ``__reduce__`` of a class whose values go to other processes and files: a copy has the
    same attributes, and its ``__init__`` is not run again."""
    if not hasattr(thing, "__dict__"):  # as of a dataclass with slots
        return object.__new__, (type(thing),), thing.__getstate__()
    items = tuple(thing) if isinstance(thing, tuple) else None
    return _restored, (type(thing), packed((items, state(thing))))


def _restored(kind: type, content: bytes) -> Any:
    items, attributes = unpacked(content)
    found = made(kind, items)
    vars(found).update(attributes)
    return found


def state(thing: object) -> dict[str, Any]:
    """The attributes of an object, without cached properties, which can be computed from them."""
    kept = {
        k for c in type(thing).__mro__ for k, v in vars(c).items() if isinstance(v, cached_property)
    }
    return {name: value for name, value in vars(thing).items() if name not in kept}


def made(kind: type, items: tuple[Any, ...] | None) -> Any:
    """An object before it has attributes; ``items`` : of a tuple."""
    return object.__new__(kind) if items is None else tuple.__new__(kind, items)


class _Pickler(pickle.Pickler):
    def reducer_override(self, thing: Any) -> Any:
        kind = type(thing)
        # FLINT's values have no pickles; values of this package are made again from their
        # attributes, in the same stream, in place of ``copied``, which would pack each of them by
        # itself. Classes that define another way keep it.
        if kind in _PARTS:
            return _again, (kind, _PARTS[kind](thing))
        reducers = (
            vars(c).get(name) for c in kind.__mro__[:-1] for name in ("__reduce__", "__reduce_ex__")
        )
        is_special = any(x not in (None, copied) for x in reducers)
        if (
            not is_special
            and kind.__module__.startswith("haptisym.")
            and hasattr(thing, "__dict__")
        ):
            return made, (kind, tuple(thing) if isinstance(thing, tuple) else None), state(thing)
        return NotImplemented


def _exact(x: arb) -> Any:
    """A number without radius: mantissa and power of 2, or the name of one that is not finite."""
    if x.is_finite():
        return x.man_exp()
    return "nan" if x.is_nan() else "inf" if x > 0 else "-inf"


_PARTS: dict[type, Any] = {
    arb: lambda x: (_exact(x.mid()), _exact(x.rad())),
    acb: lambda z: (z.real, z.imag),
    arb_poly: lambda p: (p.coeffs(),),
    fmpq_poly: lambda p: (p.coeffs(),),
    fmpz_poly: lambda p: (p.coeffs(),),
    arb_mat: lambda A: (A.nrows(), A.ncols(), A.entries()),
    fmpq_mpoly_ctx: lambda c: (c.names(), c.ordering().name),
    fmpq_mpoly: lambda p: (p.context(), p.to_dict()),
}
"""For each kind of FLINT's values the parts from which ``_again`` makes an equal one."""


def _again(kind: type, parts: tuple[Any, ...]) -> Any:
    if kind is fmpq_mpoly:
        context, terms = parts
        return context.from_dict(terms)
    if kind is fmpq_mpoly_ctx:
        names, ordering = parts
        return kind.get(names, Ordering[ordering])
    return kind(*parts)
