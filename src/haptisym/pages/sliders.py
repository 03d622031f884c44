"""A slider of the explorer: a number that can be moved or typed."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from haptisym.model.parameters import Rule
from haptisym.writing.htmltext import Html, element


@dataclass(frozen=True)
class Slider:
    """A number that can be moved: from ``low`` to ``high`` by the slider, to any value that ``rule`` allows by typing."""

    identity: str
    label: str
    unit: str
    value: float
    low: float
    high: float
    rule: Rule
    is_logarithmic: bool = False
    most: float | None = None
    least: float | None = None
    """The largest and the smallest value that may be typed, if the rule does not say."""

    def record(self) -> dict[str, Any]:
        """What the script needs to know."""
        return {
            "id": self.identity, "unit": self.unit, "value": self.value, "low": self.low, "high": self.high,
            "log": self.is_logarithmic, "least": self.least if self.rule is Rule.ANY else 0,
            "open": self.rule in (Rule.POSITIVE, Rule.FRACTION),
            "most": 1 - 2**-53 if self.rule is Rule.FRACTION else self.most,
        }  # fmt: skip

    def control(self, words: str) -> Html:
        """The slider and the box that shows its value, each with its label; ``words``: what it is, for a screen reader."""
        unit = f", {self.unit}" if self.unit else ""
        label = element("label", self.label, given={"for": self.identity, "title": words})
        slide = element("input", given={"type": "range", "id": self.identity, "aria-label": words, "step": "1"})
        box = {"type": "number", "id": f"{self.identity}-value", "step": "any", "aria-label": f"{words}{unit}"}
        shown = element("span", element("input", given=box), element("span", self.unit), given={"class": "readout"})
        return element("div", label, slide, shown, given={"class": "control"})

    def reaching(self) -> Slider:
        """The same, on a logarithmic scale that holds its value with a decade to each side."""
        low, high = min(self.low, self.value / 10), max(self.high, self.value * 10)
        return replace(self, low=low, high=high, is_logarithmic=True)
