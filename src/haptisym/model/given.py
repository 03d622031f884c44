"""What a scene is made of, as it is given in Python: each thing of its type, one clear sentence for any other."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from haptisym.kernel.errors import SceneError, need, several
from haptisym.model.catalogue import Effect, Environment
from haptisym.model.hand import Hand

_ENVIRONMENT = "give one of haptisym.environments, as environments.kelvin_voigt(100, 2)"
_EFFECTS = "give effects of haptisym.effects in a tuple, as (effects.delay(0.01),)"
_HANDS = "give hands in a tuple, as (Hand(...),)"
_BAND = "give its two ends, as (0, 15)"


def given_environment(key: str, given: object) -> None:
    """SceneError unless it is an environment."""
    need(key, given, Environment, _ENVIRONMENT)


def given_effects(given: Iterable[Effect]) -> tuple[Effect, ...]:
    """Effects in their order; SceneError for anything else among them, or for one alone."""
    listed = several("effects", given, _EFFECTS)
    for x in listed:
        need("effects", x, Effect, _EFFECTS)
    return listed


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
