"""The caches of certified zeros, to be emptied where time is measured."""

from __future__ import annotations

from haptisym.kernel import analytic, beginnings, polynomials, waves, wavesums, zeros

_CACHES = [
    found
    for module in (analytic, beginnings, polynomials, waves, wavesums, zeros)
    for found in vars(module).values()
    if hasattr(found, "cache_clear")
]


def forget() -> None:
    """Empty the caches of certified zeros, so that what is timed does all of the work."""
    for cache in _CACHES:
        cache.cache_clear()
