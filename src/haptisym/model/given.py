"""What a scene is made of, as it is given in Python: each thing of its type, one clear sentence for any other."""

from __future__ import annotations

from collections.abc import Iterable
from pkgutil import resolve_name
from typing import Any

from haptisym.kernel.errors import SceneError, need, several
from haptisym.model.catalogue import Effect, Environment, is_system
from haptisym.model.hand import Hand

_ENVIRONMENT = (
    "give one of haptisym.environments, as environments.kelvin_voigt(100, 2), or a system, as 3*s + 100 of SymPy"
)
_EFFECTS = "give effects of haptisym.effects, or systems in series, in a tuple, as (effects.delay(0.01),)"
_HANDS = "give hands in a tuple, as (Hand(...),)"
_BAND = "give its two ends, as (0, 15)"


def given_environment(key: str, given: object) -> Environment:
    """An environment, or any system that ``interop`` takes; SceneError for anything else."""
    found = given if isinstance(given, Environment) or not is_system(given) else _read(key, "environment", given)
    need(key, found, Environment, _ENVIRONMENT)
    assert isinstance(found, Environment)
    return found


def given_effects(given: Iterable[Any]) -> tuple[Effect, ...]:
    """Effects in their order, a system being one in series; SceneError for anything else among them, or for one alone."""
    listed = several("effects", given, _EFFECTS)
    found = [_read(f"effects[{i}]", "series", x) if is_system(x) else x for i, x in enumerate(listed, 1)]
    for x in found:
        need("effects", x, Effect, _EFFECTS)
    return tuple(found)


def _read(key: str, how: str, given: object) -> Any:
    try:
        return resolve_name(f"haptisym.interop:{how}")(given)
    except SceneError as error:
        raise error.within(key) from None


def given_hands(given: Iterable[Hand]) -> tuple[Hand, ...]:
    """Hands; SceneError for anything else among them, or for one alone."""
    listed = several("hands", given, _HANDS)
    for x in listed:
        need("hands", x, Hand, _HANDS)
    return listed


def given_band(given: Iterable[Any]) -> tuple[Any, Any]:
    """Two ends, as they were given."""
    ends = several("band", given, _BAND)
    if len(ends) != 2:
        raise SceneError(f"band: {ends} must be a low and a high end")
    return ends[0], ends[1]
