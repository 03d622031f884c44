"""The explorer of a page: sliders for a scene's parameters, and its closed forms as JavaScript that is drawn anew."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import files
from typing import Any

from sympy import Symbol

from haptisym.judge.evaluation import Evaluation
from haptisym.model.jnd import Part
from haptisym.model.parameters import Parameter, Rule
from haptisym.model.quantities import Dimension, MotionKind
from haptisym.pages.checked import has_certificate
from haptisym.pages.sceneforms import SceneForms
from haptisym.pages.words import H_ENV, H_PERC, OMEGA, RATIOS
from haptisym.writing.code.entry import scene_program
from haptisym.writing.code.expressions import nearest_double
from haptisym.writing.code.names import Language
from haptisym.writing.html import phrase
from haptisym.writing.htmltext import Html, data, element, joined, script
from haptisym.writing.mathematics import inline
from haptisym.writing.names import named


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
    """The largest value that may be typed, if the rule does not say."""

    def record(self) -> dict[str, Any]:
        """What the script needs to know."""
        return {
            "id": self.identity, "unit": self.unit, "value": self.value, "low": self.low, "high": self.high,
            "log": self.is_logarithmic, "least": None if self.rule is Rule.ANY else 0,
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


def explorer(e: Evaluation, forms: SceneForms) -> Html:
    """The explorer's controls, plots, script and data; it needs ``data/explorer.js`` and nothing from elsewhere."""
    if not e.scene.threshold.is_plain:
        own = f"The JND of this scene is {e.scene.threshold.kind}."
        return element("p", own, " The explorer knows one number for each part alone: it is left out.")
    is_small = forms.symbolic is not None
    is_certified = is_small and has_certificate(e)
    program = scene_program(e.scene, None if is_small else ())
    sliders = _parameters(e, forms) if is_small else {}
    limits = _thresholds(e)
    probe = _probe(e)
    controls = dict([*sliders.values(), *limits.values(), probe])
    names = [a.symbol for a in program.arguments[1:]]
    record = {
        "band": [probe[0].low, probe[0].high],
        "unit": Dimension.STIFFNESS.unit(e.scene.motion or MotionKind.TRANSLATION).replace("*", "·"),
        "arguments": [sliders[x][0].identity for x in names],
        "thresholds": {part.value: slider.identity for part, (slider, _) in limits.items()},
        "sliders": [slider.record() for slider in controls],
        "paths": _paths(e, sliders) if is_certified else [],
    }
    code = program.code(Language.JAVASCRIPT)
    page = (files("haptisym") / "data" / "explorer.js").read_text(encoding="utf-8")
    return joined([
        _body([slider.control(words) for slider, words in controls.items()], is_small=is_small, is_certified=is_certified),
        data(json.dumps(record), "explorer-data"), script(code), script(page),
    ])  # fmt: skip


def _paths(e: Evaluation, sliders: Mapping[Symbol, tuple[Slider, str]]) -> list[list[Any]]:
    """Where in the scene file the number of each slider stands: a table, or the place of an effect, and its key there."""
    effects = {f"effects.{x.name}": i for i, x in enumerate(e.scene.effects)}
    found: list[list[Any]] = []
    for p in e.scene.parameters:
        if p.symbol in sliders:
            identity = sliders[p.symbol][0].identity
            also = [path.partition(".") for path in p.also]
            found += [[identity, effects.get(p.place, p.place), p.key], *([identity, x, key] for x, _, key in also)]
    return found


def _body(controls: list[Html], *, is_small: bool, is_certified: bool) -> Html:
    fixed = (
        "" if is_small else " The parameters are too many for a formula in all of them, so only the threshold moves."
    )
    proven = (
        " When the sliders rest, crossings are found once more in exact arithmetic: that line is proven."
        if is_certified
        else ""
    )
    note = element(
        "p", "Move the sliders, or type values: the closed forms are drawn anew, the scene's own curves stay in grey. ",
        element("strong", "This explorer computes in floating point and samples the band"),
        "; it sees no tangency, and says nothing of stability. The tables above are proven, for the scene as it is.",
        fixed, proven,
    )  # fmt: skip
    plots = element(
        "div", _plot("explorer-ratios", "Distortion ratios at the sliders' values",
                     phrase((RATIOS[Part.REAL], " (solid), ", RATIOS[Part.IMAG], " (dashed); transparent band in grey"))),
        _plot("explorer-nyquist", "Nyquist plot at the sliders' values", phrase((H_ENV, " (solid), ", H_PERC, " (dashed)"))),
        given={"class": "plots"},
    )  # fmt: skip
    lines = ("band", "crossings", *(("proven",) if is_certified else ()), "probe")
    says = [element("p", given={"id": f"explorer-{x}"}) for x in lines]
    told = element("div", *says, given={"aria-live": "polite", "class": "told"})
    reset = element("button", "Reset to the scene's values", given={"type": "button", "id": "explorer-reset"})
    form = element("div", *controls, given={"class": "controls"})
    whole = element("div", plots, told, form, reset, given={"id": "explorer-panel", "hidden": ""})
    return joined([note, whole, element("noscript", element("p", "The explorer needs JavaScript; all else does not."))])


def _plot(identity: str, title: str, caption: str) -> Html:
    given = {"id": identity, "viewBox": "0 0 480 300", "role": "img"}
    return element("figure", element("svg", element("title", title), given=given), element("figcaption", caption))


def _parameters(e: Evaluation, forms: SceneForms) -> dict[Symbol, tuple[Slider, str]]:
    """A slider for each parameter of the scene, with words that say what it is."""
    found: dict[Symbol, tuple[Slider, str]] = {}
    for p in e.scene.parameters:
        label = inline(named(forms.short_names.get(p.symbol, p.symbol).name))
        slider = _parameter(p, f"explorer-{len(found)}", label, e.scene.motion or MotionKind.TRANSLATION)
        found[p.symbol] = slider, f"{p.key} of {p.place.removeprefix('effects.')}"
    return found


_MOST_AT_ZERO = {Dimension.TIME: 0.1, Dimension.FORCE: 1.0}  # of a slider whose parameter is zero in the scene


def _parameter(p: Parameter, identity: str, label: str, motion: MotionKind) -> Slider:
    """A decade to each side of a positive value; else a range around it, or from zero."""
    unit = (
        {Dimension.ANY: "", Dimension.RATIO: ""}.get(p.dimension, p.dimension.unit(motion))
        .replace("*", "·")
        .replace("^2", "²")
    )
    value, rule = nearest_double(p.value), p.rule
    if rule is Rule.FRACTION:
        return Slider(identity, label, unit, value, 0.01, 0.99, rule)
    if rule is Rule.ANY:
        reach = 2 * abs(value) or 1.0
        return Slider(identity, label, unit, value, -reach, reach, rule)
    if value > 0:
        return Slider(identity, label, unit, value, value / 10, value * 10, rule, is_logarithmic=True)
    return Slider(identity, label, unit, value, 0.0, _MOST_AT_ZERO.get(p.dimension, 1.0), rule)


def _thresholds(e: Evaluation) -> dict[Part, tuple[Slider, str]]:
    """One slider for the threshold; two where the parts have different ones."""
    given = {part: float(e.scene.threshold[part]) for part in Part}
    if len(set(given.values())) == 1:
        only = Slider(
            "explorer-c", inline(named("c")), "", given[Part.REAL], 0.01, 1.0, Rule.POSITIVE, is_logarithmic=True
        )
        return dict.fromkeys(Part, (_reaching(only), "threshold c"))
    return {
        part: (
            _reaching(Slider(f"explorer-c-{part.value}", inline(named(f"c_{part.value}")), "", value, 0.01, 1.0,
                             Rule.POSITIVE, is_logarithmic=True)),
            f"threshold c of the {'real' if part is Part.REAL else 'imaginary'} part",
        )
        for part, value in given.items()
    }  # fmt: skip


def _reaching(x: Slider) -> Slider:
    """The slider with a range that holds its value."""
    low, high = min(x.low, x.value / 10), max(x.high, x.value * 10)
    return Slider(x.identity, x.label, x.unit, x.value, low, high, x.rule, is_logarithmic=True)


def _probe(e: Evaluation) -> tuple[Slider, str]:
    """The frequency at which the explorer says the values: at first the middle of the band."""
    low, high = (float(e.chart.points[i].omega) for i in (0, -1))
    middle = float(f"{(low + high) / 2:.4g}")
    slider = Slider("explorer-omega", inline(OMEGA), "rad/s", middle, low, high, Rule.NONNEGATIVE, most=high)
    return slider, "frequency at which values are told"
