"""A measured response on a bench: its table, and a scene file beside it."""

from __future__ import annotations

from pathlib import Path

SCENE = """
title = "On the bench"
[environment]
model = "mass-spring-damper"
m = "1.8 kg"
b = "15 N*s/m"
k = "100 N/m"
[perceived]
file = "bench.csv"
"""


def bench(folder: Path, table: str, scene: str = SCENE, **keys: object) -> Path:
    """The scene file, with further keys of what is perceived."""
    (folder / "bench.csv").write_text(table, encoding="utf-8")
    path = folder / "bench.toml"
    path.write_text(scene + "".join(f"{key} = {value}\n" for key, value in keys.items()), encoding="utf-8")
    return path
