"""Which cases of a large family are run every time and which only in CI (``-m slow``); programs that a test needs."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings

import haptisym as hs

EXAMPLES = int(os.environ.get("HAPTISYM_EXAMPLES", "0"))
"""How many examples each property is tried on, drawn anew; 0 for the same few as always."""

UNDAMPED, FLEXIBLE = (
    str(Path(__file__).parents[1] / "scenes" / f"{name}-resonance.toml") for name in ("undamped", "two-mass")
)
"""Scenes of mathematics and no device: H_env and dH vanish together; a second mass on a lightly damped spring."""

QUICK_SCENES = {"fu2019", "delayed-spring", "sidestick", "stick-with-friction"}
"""Shipped scenes whose formulas are short: a rational one, a delay, a rotation, friction."""

WRITTEN_OUT = tuple(name for name in hs.scene_names() if name != "control-stick-in-detail")
"""Shipped scenes whose closed forms are written out in all symbols: that of ten effects would fill a book."""


def examples(count: int) -> settings:
    """So many examples of a property, or as many as are asked for, if that is more; every time a fifth of them."""
    return settings(max_examples=max(count, EXAMPLES) if EXAMPLES else -(-count // 5), deadline=None)


def rarely(*strategies: Any, **named: Any) -> Callable[[Any], Any]:
    """``given``, of a property whose one example takes long: a fifth of the examples that are asked for."""
    few = settings(max_examples=max(EXAMPLES // 5, 3), deadline=None)
    return lambda test: few(given(*strategies, **named)(test))


def often(cases: Iterable[Any], quick: Callable[[Any], bool]) -> list[Any]:
    """All cases, those that are not quick marked as slow."""
    return [x if quick(x) else pytest.param(*_listed(x), marks=pytest.mark.slow) for x in cases]


def _listed(case: Any) -> tuple[Any, ...]:
    return case if isinstance(case, tuple) else (case,)


def required(program: str, found: object) -> None:
    """Skip a test whose program is missing on a user's machine; in CI nothing may be missing."""
    if not found:
        if os.environ.get("CI"):
            pytest.fail(f"{program} is missing: CI must run it")
        pytest.skip(f"{program} is missing", allow_module_level=True)
