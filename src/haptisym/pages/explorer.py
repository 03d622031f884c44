"""The explorer of a page: sliders for a scene's parameters, and its closed forms as JavaScript that is drawn anew."""

from __future__ import annotations

import json
from collections.abc import Mapping
from importlib.resources import files
from typing import Any

from sympy import Symbol

from haptisym.judge.evaluation import Evaluation
from haptisym.model.jnd import Part, Shape, Threshold
from haptisym.model.parameters import Parameter, Rule
from haptisym.model.quantities import Dimension, MotionKind, unit_text
from haptisym.pages.checked import is_provable
from haptisym.pages.scene import SceneForms
from haptisym.pages.sliders import Slider, limit_sliders, region_record
from haptisym.pages.words import CHANGE, H_ENV, H_PERC, OMEGA, RATIOS, unit
from haptisym.verbs.evaluate.certificate import name_in_file
from haptisym.writing.code.code import nearest_double
from haptisym.writing.code.entry import scene_program
from haptisym.writing.code.languages import Language
from haptisym.writing.document import Phrase
from haptisym.writing.html import Html, data, element, inline, joined, phrase, script
from haptisym.writing.layout import named


def explorer(e: Evaluation, forms: SceneForms) -> Html:
    """The explorer's controls, plots, script and data; it needs ``data/explorer.js`` and nothing from elsewhere."""
    is_small = forms.symbolic is not None
    is_proven = is_small and is_provable(e)
    program = scene_program(e.scene, None if is_small else ())
    sliders = _parameters(e, forms) if is_small else {}
    limits = limit_sliders(e.scene)
    probe = _probe(e)
    controls = dict([*sliders.values(), *limits.values(), probe])
    names = [a.symbol for a in program.arguments[1:]]
    record = {
        "band": [probe[0].low, probe[0].high],
        "unit": unit(Dimension.STIFFNESS, e.scene.motion),
        "arguments": [sliders[x][0].identity for x in names],
        "region": region_record(e.scene.threshold, limits),
        "limits": list(dict.fromkeys(slider.identity for slider, _ in limits.values())),
        "sliders": [slider.record() for slider in controls],
        "paths": _paths(e, sliders) if is_proven else [],
        "environment": name_in_file(e.scene) if is_proven else None,
    }
    code = program.code(Language.JAVASCRIPT)
    own = files("haptisym") / "data"
    page = "".join((own / name).read_text(encoding="utf-8") for name in ("region.js", "explorer.js"))
    shown = [slider.control(words) for slider, words in controls.items()]
    return joined([
        _body(shown, e.scene.threshold, is_small=is_small, is_proven=is_proven),
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


def _body(controls: list[Html], threshold: Threshold, *, is_small: bool, is_proven: bool) -> Html:
    fixed = "" if is_small else " The parameters are too many for a formula in all of them, so only the JND moves."
    proven = (
        " When the sliders rest, crossings are found once more in exact arithmetic: that line is proven."
        if is_proven
        else ""
    )
    note = element(
        "p", "Move the sliders, or type values: the closed forms are drawn anew, the scene's own curves stay in grey. ",
        element("strong", "This explorer computes in floating point and samples the band"),
        "; it sees no tangency, and says nothing of stability. The tables above are proven, for the scene as it is.",
        fixed, proven,
    )  # fmt: skip
    lines = ("band", "crossings", *(("proven",) if is_proven else ()), "probe")
    says = [element("p", given={"id": f"explorer-{x}"}) for x in lines]
    told = element("div", *says, given={"aria-live": "polite", "class": "told"})
    reset = element("button", "Reset to the scene's values", given={"type": "button", "id": "explorer-reset"})
    form = element("div", *controls, given={"class": "controls"})
    plots = element("div", *_plots(threshold), told, given={"class": "plots"})
    whole = element("div", plots, form, reset, given={"id": "explorer-panel", "hidden": ""})
    return joined([note, whole, element("noscript", element("p", "The explorer needs JavaScript; all else does not."))])


def _plots(threshold: Threshold) -> list[Html]:
    shape = threshold.region.shape
    ratios: Phrase = (RATIOS[Part.REAL], " (solid), ", RATIOS[Part.IMAG], " (dashed)")
    if shape is not Shape.SQUARE:
        ratios = (
            f"how many times the {shape.value} must be enlarged to hold ",
            CHANGE,
            ", more than once where it is noticed",
        )
    region = "the changes that are not noticed at the frequency of the dot (grey), and ", CHANGE, " over the band"
    return [
        _plot(
            "explorer-ratios",
            "Distortion ratios at the sliders' values",
            phrase((ratios, "; transparent band in grey")),
        ),
        _plot(
            "explorer-nyquist",
            "Nyquist plot at the sliders' values",
            phrase((H_ENV, " (solid), ", H_PERC, " (dashed)")),
        ),
        _plot("explorer-region", "JND region at the sliders' values", phrase(region)),
    ]


def _plot(identity: str, title: str, caption: str) -> Html:
    given = {"id": identity, "viewBox": "0 0 480 300", "role": "img"}
    return element("figure", element("svg", element("title", title), given=given), element("figcaption", caption))


def _parameters(e: Evaluation, forms: SceneForms) -> dict[Symbol, tuple[Slider, str]]:
    """A slider for each parameter of the scene, with words that say what it is."""
    found: dict[Symbol, tuple[Slider, str]] = {}
    for p in e.scene.parameters:
        label = inline(named(forms.short_names.get(p.symbol, p.symbol).name))
        slider = _parameter(p, f"explorer-{len(found)}", label, e.scene.motion)
        found[p.symbol] = slider, f"{p.key} of {p.place.removeprefix('effects.')}"
    return found


_MOST_AT_ZERO = {Dimension.TIME: 0.1, Dimension.FORCE: 1.0}  # of a slider whose parameter is zero in the scene


def _parameter(p: Parameter, identity: str, label: str, motion: MotionKind | None) -> Slider:
    """A decade to each side of a positive value; else a range around it, or from zero."""
    own = "" if p.dimension is Dimension.RATIO else unit_text(p.unit_in(motion or MotionKind.TRANSLATION))
    value, rule = nearest_double(p.value), p.rule
    if rule is Rule.FRACTION:
        return Slider(identity, label, own, value, 0.01, 0.99, rule)
    if rule is Rule.ANY:
        reach = 2 * abs(value) or 1.0
        return Slider(identity, label, own, value, -reach, reach, rule)
    if value > 0:
        return Slider(identity, label, own, value, value / 10, value * 10, rule, is_logarithmic=True)
    return Slider(identity, label, own, value, 0.0, _MOST_AT_ZERO.get(p.dimension, 1.0), rule)


def _probe(e: Evaluation) -> tuple[Slider, str]:
    """The frequency at which the explorer says the values: at first the middle of the band."""
    low, high = (float(e.chart.points[i].omega) for i in (0, -1))
    middle = float(f"{(low + high) / 2:.4g}")
    slider = Slider("explorer-omega", inline(OMEGA), "rad/s", middle, low, high, Rule.NONNEGATIVE, most=high)
    return slider, "frequency at which values are told"
