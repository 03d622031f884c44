"""What all figures are drawn with: colours, strokes and sizes."""

from __future__ import annotations

from typing import Any

WIDTH = 3.4
"""Inches: one column of a journal."""
TEXT, SMALL = 8.0, 7.0
"""Points: labels of axes; ticks, legends and notes."""
INK, BLUE, RED, GREY, SHADE = "#222222", "#1f4e9e", "#c03028", "#7a7a7a", "#e6e6e6"
UNSTABLE = "#f3dcd8"  # the ground where a hand is shaken
SOLID: Any = "-"
DASHED: Any = (0, (4, 1.6))
DOTTED: Any = (0, (1, 2))
LEADER = {"arrowstyle": "-", "linewidth": 0.5, "color": GREY, "shrinkA": 0, "shrinkB": 0}
STROKES = (SOLID, DASHED, DOTTED)
"""Of the criteria of a scene, in their order."""
SCENES = (INK, "#d0701f", BLUE, "#7cc0c8", "#8f5a9e")
"""Colours of the first, second, ... scene that is drawn on the same axes."""
