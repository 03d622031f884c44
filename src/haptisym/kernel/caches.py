"""The caches of certified zeros and of what is moved by a clock, to be emptied where time is measured."""

from __future__ import annotations

from haptisym.kernel import analytic, polynomials, pulse, waves, zeros

_CACHES = [
    found
    for module in (analytic, polynomials, pulse, waves, zeros)
    for found in vars(module).values()
    if hasattr(found, "cache_clear")
]


def forget() -> None:
    """Empty these caches, so that what is timed does all of the work."""
    for cache in _CACHES:
        cache.cache_clear()
