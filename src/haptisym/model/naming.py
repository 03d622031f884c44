"""Names of their own for the effects of a scene, and symbols of their own for its parameters."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable
from dataclasses import replace
from typing import Protocol

from sympy import Symbol

from haptisym.model.catalogue import Effect
from haptisym.model.parameters import Parameter, free_name


class HasParameters(Protocol):
    """An environment, an effect or a hand."""

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Its parameters, in the order of the catalogue."""


def with_names(effects: Iterable[Effect]) -> list[Effect]:
    """The effects under names of their own: the second "filter" becomes "filter-2"."""
    listed = list(effects)
    taken = {effect.name for effect in listed}
    named: list[Effect] = []
    for effect in listed:
        own = effect.name
        if any(own == other.name for other in named):
            own = free_name(own, taken, "-")
            taken.add(own)
        named.append(replace(effect, name=own))
    return named


def symbol_names(elements: Iterable[tuple[str, HasParameters | None]]) -> list[dict[Symbol, Symbol]]:
    """For each element, new symbols for those that another element names alike: ``zeta`` becomes ``zeta_filter``.

    The first element, which has no label, is the environment: it keeps its names but for the threshold's, as ``c``, which
    becomes ``c_env``.
    """
    listed = list(elements)
    uses = Counter([p.symbol.name for _, element in listed if element for p in element.parameters])
    uses.update(_OF_THRESHOLDS)
    taken = set(uses)
    renamed: list[dict[Symbol, Symbol]] = []
    for label, element in listed:
        suffix, held = "_" + re.sub(r"\W", "_", label or "env"), element.parameters if element else ()
        own = [p.symbol for p in held if not p.tie and (label or p.symbol.name in _OF_THRESHOLDS)]
        shared = [symbol for symbol in own if uses[symbol.name] > 1]
        names = {symbol: free_name(f"{symbol.name}{suffix}", taken) for symbol in shared}
        taken |= set(names.values())
        tied = {p.symbol: renamed[0][p.symbol] for p in held if p.tie and p.symbol in renamed[0]}
        renamed.append({**tied, **{symbol: _like(symbol, name) for symbol, name in names.items()}})
    return renamed


_OF_THRESHOLDS = ("c", "c_real", "c_imag")


def _like(symbol: Symbol, name: str) -> Symbol:
    return Symbol(name, **symbol.assumptions0)
