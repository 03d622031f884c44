"""Copies of what holds numbers of FLINT, which has no pickles of its own: balls, polynomials and their contexts, exactly."""

from __future__ import annotations

import pickle
from functools import cached_property
from io import BytesIO
from typing import Any

from flint import Ordering, acb, arb, arb_mat, arb_poly, fmpq_mpoly, fmpq_mpoly_ctx, fmpq_poly, fmpz_poly


def packed(thing: object) -> bytes:
    """An object as bytes, without what was computed from it and kept with it; ``unpacked`` gives its like.

    Middles of balls are the same to the last bit, radii never smaller, and larger by a billionth at most.

    >>> unpacked(packed([arb(1) / 3]))[0].contains(arb(1) / 3)
    True
    """
    into = BytesIO()
    _Pickler(into, protocol=pickle.HIGHEST_PROTOCOL).dump(thing)
    return into.getvalue()


def unpacked(found: bytes) -> Any:
    """What was packed."""
    return pickle.loads(found)


def state(thing: object) -> dict[str, Any]:
    """The attributes of an object, but for what it keeps of what was computed from them."""
    kept = {k for c in type(thing).__mro__ for k, v in vars(c).items() if isinstance(v, cached_property)}
    return {name: value for name, value in vars(thing).items() if name not in kept}


def made(kind: type, items: tuple[Any, ...] | None) -> Any:
    """An object before it has attributes; ``items`` : of a tuple."""
    return object.__new__(kind) if items is None else tuple.__new__(kind, items)


class _Pickler(pickle.Pickler):
    def reducer_override(self, thing: Any) -> Any:
        kind = type(thing)
        if kind in _PARTS:
            return _again, (kind, _PARTS[kind](thing))
        if not _has_its_own(kind) and kind.__module__.startswith("haptisym.") and hasattr(thing, "__dict__"):
            return made, (kind, tuple(thing) if isinstance(thing, tuple) else None), state(thing)
        return NotImplemented


def _has_its_own(kind: type) -> bool:
    """Whether a class says itself how it is copied, as enumerations do."""
    return any(name in vars(c) for c in kind.__mro__[:-1] for name in ("__reduce__", "__reduce_ex__"))


def _exact(x: arb) -> Any:
    """The middle of a ball: mantissa and power of 2, or a word."""
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
"""From what they are made again."""


def _again(kind: type, parts: tuple[Any, ...]) -> Any:
    if kind is fmpq_mpoly:
        context, terms = parts
        return context.from_dict(terms)
    if kind is fmpq_mpoly_ctx:
        names, ordering = parts
        return kind.get(names, Ordering[ordering])
    return kind(*parts)
