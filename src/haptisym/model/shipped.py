"""The scenes that the package ships, by name: with one environment, with several, and bench runs.

The module does not import SymPy, so that names are listed at once.
"""

from __future__ import annotations

from pathlib import Path

# ``importlib.resources`` takes longer than the evaluation of a scene.
SHIPPED = Path(__file__).parents[1]


def scene_names() -> tuple[str, ...]:
    """The names of the scenes with one environment that the package ships.

    >>> "fu2019" in scene_names()
    True
    """
    return _names("scenes")


def family_names() -> tuple[str, ...]:
    """The names of the scenes with several environments that the package ships.

    >>> family_names()
    ('palpation-device',)
    """
    return _names("families")


def bench_names() -> tuple[str, ...]:
    """The names of the measured scenes that the package ships: simulated bench runs, which
    ``evaluate``, ``compare`` and ``identify`` take.

    >>> bench_names()
    ('delayed-spring-bench', 'fu2019-bench', 'fu2019-clipped-bench')
    """
    return _names("benches")


def shipped_text(name: str) -> str | None:
    """The text of a shipped scene; None where there is none of that name."""
    for folder in ("scenes", "families", "benches"):
        if name in _names(folder):
            return (SHIPPED / folder / f"{name}.toml").read_text(encoding="utf-8")
    return None


def _names(folder: str) -> tuple[str, ...]:
    """The names of the scenes in a shipped folder, sorted."""
    entries = (SHIPPED / folder).iterdir()
    return tuple(
        sorted(
            entry.name.removesuffix(".toml") for entry in entries if entry.name.endswith(".toml")
        )
    )
