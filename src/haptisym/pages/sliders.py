"""The sliders of the explorer: numbers that can be moved or typed, those of the JND among them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

from sympy import Expr, Poly, fraction, together

from haptisym.kernel.rings import omega
from haptisym.model.jnd import Part, Shape, Threshold
from haptisym.model.parameters import Rule
from haptisym.model.quantities import Dimension
from haptisym.model.scene import Scene
from haptisym.pages.words import PART_NAMES, unit
from haptisym.writing.code.code import nearest_double
from haptisym.writing.html import Html, element, inline, joined
from haptisym.writing.layout import named


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


Limits: TypeAlias = dict[str, tuple[Slider, str]]
"""By the name of a number: ``real``, ``real.lower``, ``floor``, ``tilt``, ``size``; a slider, and words for a screen reader."""


def limit_sliders(scene: Scene) -> Limits:
    """One for both half widths where they are the same number; one for how large a polygon is."""
    t = scene.threshold
    if t.region.shape is Shape.POLYGON:
        size = Slider("explorer-size", Html("size"), "×", 1.0, 0.1, 10.0, Rule.POSITIVE, is_logarithmic=True)
        return {"size": (size, "how many times the polygon is as large")}
    alike = t.real == t.imag and not t.real.has(omega) and t.region.lower == (None, None)
    found: Limits = {}
    if alike:
        found = dict.fromkeys(("real", "imag"), (_share("explorer-c", inline(named("c")), t.real), "threshold c"))
    else:
        found = {key: own for part in Part for key, own in _of_part(t, part)}
    return found | dict(_others(scene))


def _of_part(t: Threshold, part: Part) -> Iterator[tuple[str, tuple[Slider, str]]]:
    name, identity, lower = inline(named(f"c_{part.value}")), f"explorer-c-{part.value}", t.lower(part)
    words = f"threshold c of the {PART_NAMES[part]} part"
    if not t[part].has(omega):
        label, way = (name, "") if lower is None else (joined([name, Html(" ↑")]), " where it grows")
        yield part.value, (_share(identity, label, t[part]), f"{words}{way}")
    if lower is not None and not lower.has(omega):
        slider = _share(f"{identity}-lower", joined([name, Html(" ↓")]), lower)
        yield f"{part.value}.lower", (slider, f"{words} where it shrinks")


def _share(identity: str, label: Html, value: Expr) -> Slider:
    return Slider(identity, label, "", nearest_double(value), 0.01, 1.0, Rule.POSITIVE).reaching()


def _others(scene: Scene) -> Iterator[tuple[str, tuple[Slider, str]]]:
    region = scene.threshold.region
    if region.floor is not None and not region.floor.has(omega):
        stiffness = unit(Dimension.STIFFNESS, scene.motion)
        value = nearest_double(region.floor)
        slider = Slider(
            "explorer-floor",
            Html("floor"),
            stiffness,
            value,
            value / 10,
            value * 10,
            Rule.POSITIVE,
            is_logarithmic=True,
        )
        yield "floor", (slider, "least change that is noticed")
    if region.shape is Shape.ELLIPSE and not region.tilt.has(omega):
        value = nearest_double(region.tilt)
        slider = Slider(
            "explorer-tilt", Html("tilt"), "", value, -0.99, 0.99, Rule.ANY, most=1 - 2**-53, least=-1 + 2**-53
        )
        yield "tilt", (slider, "tilt of the ellipse")


def region_record(t: Threshold, limits: Limits) -> dict[str, Any]:
    """The region's shape, and each of its numbers: a slider, or a quotient of polynomials in omega."""
    region = t.region
    if region.shape is Shape.POLYGON:
        corners = [[_quotient(x) for x in corner] for corner in region.corners]
        return {"shape": region.shape.value, "numbers": _numbers({}, limits), "corners": corners}
    named_ = {part.value: t[part] for part in Part}
    named_ |= {f"{part.value}.lower": x for part in Part if (x := t.lower(part)) is not None}
    named_ |= {"floor": region.floor} if region.floor is not None else {}
    named_ |= {"tilt": region.tilt} if region.shape is Shape.ELLIPSE else {}
    return {"shape": region.shape.value, "numbers": _numbers(named_, limits), "corners": []}


def _numbers(values: Mapping[str, Expr], limits: Limits) -> dict[str, Any]:
    fixed = {key: _quotient(x) for key, x in values.items() if key not in limits}
    return fixed | {key: {"slider": slider.identity} for key, (slider, _) in limits.items()}


def _quotient(x: Expr) -> dict[str, list[float]]:
    """Coefficients in omega, ascending."""
    if not x.has(omega):
        return {"top": [nearest_double(x)], "bottom": [1.0]}
    top, bottom = (Poly(p, omega).all_coeffs()[::-1] for p in fraction(together(x)))
    return {"top": [nearest_double(c) for c in top], "bottom": [nearest_double(c) for c in bottom]}
