"""The explorer of a page of HTML: sliders for a scene's parameters and those of its JND.

It has the scene's closed forms as JavaScript, which the page draws anew as the sliders move. What
it shows is computed: floating point on samples of the band, with no error bound. What haptisym has
proven of the scene's own values stands next to it, as a sentence that does not move. Begin with
``explorer``; ``data/explorer.js`` reads the record that it writes.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from importlib.resources import files
from typing import Any, TypeAlias

from sympy import Expr, Poly, Symbol, fraction, together

from haptisym.judge.evaluation import Evaluation
from haptisym.kernel.rings import omega
from haptisym.model.jnd import Part, Shape, Threshold
from haptisym.model.parameters import Parameter, Rule
from haptisym.model.quantities import RADIANS, Dimension, MotionKind, Unit
from haptisym.model.scene import Scene
from haptisym.pages.scene import SceneForms
from haptisym.pages.words import CHANGE, H_ENV, H_PERC, OMEGA, PART_NAMES, RATIOS, unit
from haptisym.writing.code import Language, nearest_double, scene_program
from haptisym.writing.document import Phrase, Style
from haptisym.writing.html import Html, data, element, inline, joined, phrase, script
from haptisym.writing.layout import named

# Sliders.


@dataclass(frozen=True)
class Slider:
    """A number, SI, that can be moved: from ``low`` to ``high`` by the slider, to any value that
    ``rule`` allows by typing. It is shown and typed in ``unit``."""

    identity: str
    label: str
    unit: Unit
    value: float
    low: float
    high: float
    rule: Rule
    is_logarithmic: bool = False
    most: float | None = None
    least: float | None = None
    """The largest and the smallest value that may be typed, if the rule does not say."""

    def record(self) -> dict[str, Any]:
        """Return what the script needs to know of the slider."""
        return {
            "id": self.identity,
            "unit": self.unit.text,
            "size": float(self.unit.size),
            "value": self.value,
            "low": self.low,
            "high": self.high,
            "log": self.is_logarithmic,
            "least": self.least if self.rule is Rule.ANY else 0,
            # The least value 0 is itself excluded where a rule asks for a positive number.
            "open": self.rule in (Rule.POSITIVE, Rule.FRACTION),
            # The largest double below 1.
            "most": 1 - 2**-53 if self.rule is Rule.FRACTION else self.most,
        }

    def control(self, words: str) -> Html:
        """The slider and the box that shows its value, each with its label; ``words``: what it is,
        for a screen reader."""
        unit = f", {self.unit.text}" if self.unit.text else ""
        label = element("label", self.label, given={"for": self.identity, "title": words})
        slide = element(
            "input", given={"type": "range", "id": self.identity, "aria-label": words, "step": "1"}
        )
        box = {
            "type": "number",
            "id": f"{self.identity}-value",
            "step": "any",
            "aria-label": f"{words}{unit}",
        }
        shown = element(
            "span",
            element("input", given=box),
            element("span", self.unit.text),
            given={"class": "readout"},
        )
        return element("div", label, slide, shown, given={"class": "control"})

    def shown(self) -> Slider:
        """Return the slider with its numbers in its unit in place of SI."""
        size = float(self.unit.size)
        value, low, high = self.value / size, self.low / size, self.high / size
        return replace(self, value=value, low=low, high=high)

    def reaching(self) -> Slider:
        """Return the slider with a logarithmic scale that holds its value, with a decade to each
        side."""
        low, high = min(self.low, self.value / 10), max(self.high, self.value * 10)
        return replace(self, low=low, high=high, is_logarithmic=True)


Limits: TypeAlias = dict[str, tuple[Slider, str]]
"""By the name of a number: ``real``, ``real.lower``, ``floor``, ``tilt``, ``size``; a slider, and
words for a screen reader."""


def limit_sliders(scene: Scene) -> Limits:
    """Return the sliders of the JND: one for both half widths where they are the same number, and
    one for the size of a polygon."""
    t = scene.threshold
    if t.region.corners:
        size = Slider(
            "explorer-size",
            Html("size"),
            Unit("×"),
            1.0,
            0.1,
            10.0,
            Rule.POSITIVE,
            is_logarithmic=True,
        )
        return {"size": (size, "how many times the polygon is as large")}
    # One slider moves both half widths only where they are one number, and no limit for shrinking
    # parts them.
    alike = t.real == t.imag and not t.real.has(omega) and t.region.lower == (None, None)
    sliders: Limits = {}
    if alike:
        sliders = dict.fromkeys(
            ("real", "imag"), (_share("explorer-c", inline(named("c")), t.real), "threshold c")
        )
    else:
        sliders = {key: own for part in Part for key, own in _of_part(t, part)}
    return sliders | dict(_others(scene))


def _of_part(threshold: Threshold, part: Part) -> Iterator[tuple[str, tuple[Slider, str]]]:
    """Yield the sliders of one part: its threshold, and that for a part that shrinks."""
    name = inline(named(f"c_{part.value}"))
    identity = f"explorer-c-{part.value}"
    lower = threshold.lower(part)
    words = f"threshold c of the {PART_NAMES[part]} part"
    if not threshold[part].has(omega):
        label, way = (
            (name, "") if lower is None else (joined([name, Html(" ↑")]), " where it grows")
        )
        yield part.value, (_share(identity, label, threshold[part]), f"{words}{way}")
    if lower is not None and not lower.has(omega):
        slider = _share(f"{identity}-lower", joined([name, Html(" ↓")]), lower)
        yield f"{part.value}.lower", (slider, f"{words} where it shrinks")


def _share(identity: str, label: Html, value: Expr) -> Slider:
    """Return the slider of a threshold, which is a fraction of |H_env|."""
    share = Slider(identity, label, Unit(""), nearest_double(value), 0.01, 1.0, Rule.POSITIVE)
    return share.reaching()


def _others(scene: Scene) -> Iterator[tuple[str, tuple[Slider, str]]]:
    """Yield the sliders of a floor and of a tilt, where the region has them."""
    region = scene.threshold.region
    if region.floor is not None and not region.floor.has(omega):
        stiffness = Unit(unit(Dimension.STIFFNESS, scene.motion))
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
        # The tilt of an ellipse lies between -1 and 1, and reaches neither.
        value = nearest_double(region.tilt)
        slider = Slider(
            "explorer-tilt",
            Html("tilt"),
            Unit(""),
            value,
            -0.99,
            0.99,
            Rule.ANY,
            most=1 - 2**-53,
            least=-1 + 2**-53,
        )
        yield "tilt", (slider, "tilt of the ellipse")


def region_record(t: Threshold, limits: Limits) -> dict[str, Any]:
    """The region's shape, and each of its numbers: a slider, or a quotient of polynomials in
    omega."""
    region = t.region
    corners = [[_quotient(x) for x in corner] for corner in region.corners or region.shape.corners]
    # A polygon is scaled as a whole: its corners stay in proportion.
    if region.corners:
        size = _numbers({}, limits)["size"]
        return {
            "shape": region.shape.value,
            "numbers": {"real": size, "imag": size},
            "corners": corners,
        }
    named_ = {part.value: t[part] for part in Part}
    named_ |= {f"{part.value}.lower": x for part in Part if (x := t.lower(part)) is not None}
    named_ |= {"floor": region.floor} if region.floor is not None else {}
    named_ |= {"tilt": region.tilt} if region.shape is Shape.ELLIPSE else {}
    return {"shape": region.shape.value, "numbers": _numbers(named_, limits), "corners": corners}


def _numbers(values: Mapping[str, Expr], limits: Limits) -> dict[str, Any]:
    """Return each number of a region: the slider that moves it, or its coefficients."""
    fixed = {key: _quotient(x) for key, x in values.items() if key not in limits}
    moved = {key: {"slider": slider.identity} for key, (slider, _) in limits.items()}
    return fixed | moved


def _quotient(x: Expr) -> dict[str, list[float]]:
    """Return the coefficients of a quotient of polynomials in omega, ascending, as doubles."""
    if not x.has(omega):
        return {"top": [nearest_double(x)], "bottom": [1.0]}
    # Poly gives the highest power first; the script evaluates from the lowest.
    top, bottom = (Poly(p, omega).all_coeffs()[::-1] for p in fraction(together(x)))
    return {"top": [nearest_double(c) for c in top], "bottom": [nearest_double(c) for c in bottom]}


# The explorer.


def explorer(e: Evaluation, forms: SceneForms, proven: Phrase = "") -> Html:
    """Return the explorer's controls, plots, script and data; it needs nothing from elsewhere.

    ``proven`` : what a report says of the scene's own values. A page that asks haptisym again when
    the sliders rest leaves it out, for there the answer itself follows them.
    """
    # A formula in all parameters that would be too long is replaced by one in omega alone: then
    # only the JND moves.
    is_small = forms.symbolic is not None
    program = scene_program(e.scene, None if is_small else ())
    sliders = parameter_sliders(e, forms) if is_small else {}
    limits = limit_sliders(e.scene)
    probe = _probe(e)
    controls = dict([*sliders.values(), *limits.values(), probe])
    names = [a.symbol for a in program.arguments[1:]]
    record = {
        "band": [probe[0].low, probe[0].high],
        "unit": unit(Dimension.STIFFNESS, e.scene.motion),
        "frequency": {"unit": e.scene.frequency.text, "size": float(e.scene.frequency.size)},
        "arguments": [sliders[x][0].identity for x in names],
        "region": region_record(e.scene.threshold, limits),
        "limits": list(dict.fromkeys(slider.identity for slider, _ in limits.values())),
        "sliders": [slider.record() for slider in controls],
        "paths": _paths(e, sliders),
    }
    code = program.code(Language.JAVASCRIPT)
    own = files("haptisym") / "data"
    page = "".join(
        (own / name).read_text(encoding="utf-8") for name in ("region.js", "explorer.js")
    )
    shown = [slider.control(words) for slider, words in controls.items()]
    in_unit = Style(frequency=e.scene.frequency)
    return joined(
        [
            _body(shown, e.scene.threshold, in_unit.phrase(proven), is_small=is_small),
            data(json.dumps(record), "explorer-data"),
            script(code),
            script(page),
        ]
    )


def _paths(e: Evaluation, sliders: Mapping[Symbol, tuple[Slider, str]]) -> list[list[Any]]:
    """Return where in the scene file the number of each slider stands: a table, or the place of an
    effect, and its key there."""
    effects = {f"effects.{x.name}": i for i, x in enumerate(e.scene.effects)}
    paths: list[list[Any]] = []
    for p in e.scene.parameters:
        if p.symbol in sliders:
            identity = sliders[p.symbol][0].identity
            # One parameter may stand in several places of the file, all of which the slider
            # changes.
            also = [path.partition(".") for path in p.also]
            paths += [
                [identity, effects.get(p.place, p.place), p.key],
                *([identity, x, key] for x, _, key in also),
            ]
    return paths


def _body(controls: list[Html], threshold: Threshold, proven: Phrase, *, is_small: bool) -> Html:
    """Return what the explorer says and shows: a note, plots, sliders, a button."""
    follows = (
        "The tables of this page do not follow; they are about the scene's values."
        if proven
        else "A moment after the sliders rest, their values are in the scene, and the result is "
        "proven for them."
    )
    fixed = (
        "" if is_small else " The scene has no short formula in all parameters: only the JND moves."
    )
    note = element(
        "p",
        (
            "Move the sliders, or type values: the closed forms are drawn again; the scene's own "
            "curves stay in grey. "
        ),
        element("strong", "What the sliders show is computed"),
        ": floating point on samples of the band, no error bound. A tangency is not found, and "
        "stability is not tested. ",
        follows,
        fixed,
    )
    says = [element("p", given={"id": f"explorer-{x}"}) for x in ("band", "crossings", "probe")]
    scene = [element("p", phrase(proven))] if proven else []
    results = element("div", *scene, *says, given={"aria-live": "polite", "class": "told"})
    reset = element(
        "button", "Reset to the scene's values", given={"type": "button", "id": "explorer-reset"}
    )
    form = element("div", *controls, given={"class": "controls"})
    plots = element("div", *_plots(threshold), results, given={"class": "plots"})
    # Hidden until the script runs; without JavaScript the sentence below stands there instead.
    whole = element("div", plots, form, reset, given={"id": "explorer-panel", "hidden": ""})
    return joined(
        [
            note,
            whole,
            element("noscript", element("p", "The explorer needs JavaScript; all else does not.")),
        ]
    )


def _plots(threshold: Threshold) -> list[Html]:
    """Return the three plots of the explorer, each with its caption."""
    shape = threshold.region.shape
    ratios: Phrase = (RATIOS[Part.REAL], " (solid), ", RATIOS[Part.IMAG], " (dashed)")
    if shape is not Shape.SQUARE:
        ratios = (
            f"how many times the {shape.value} must be enlarged to hold ",
            CHANGE,
            ", more than once where it is noticed",
        )
    region = (
        "the changes that are not noticed at the frequency of the dot (grey), and ",
        CHANGE,
        " over the band",
    )
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
    """Return a plot: an empty drawing that the script fills, and a caption."""
    given = {"id": identity, "viewBox": "0 0 480 300", "role": "img"}
    return element(
        "figure",
        element("svg", element("title", title), given=given),
        element("figcaption", caption),
    )


def parameter_sliders(e: Evaluation, forms: SceneForms) -> dict[Symbol, tuple[Slider, str]]:
    """A slider for each parameter of the scene, with words that say what it is."""
    sliders: dict[Symbol, tuple[Slider, str]] = {}
    for p in e.scene.parameters:
        symbol = forms.short_names.get(p.symbol, p.symbol)
        label = inline(named(symbol.name))
        slider = _parameter(p, f"explorer-{len(sliders)}", label, e.scene.motion)
        place = p.place.removeprefix("effects.")
        sliders[p.symbol] = slider, f"{p.key} of {place}"
    return sliders


_MOST_AT_ZERO = {Dimension.TIME: 0.1, Dimension.FORCE: 1.0}
"""Upper ends, SI, of sliders whose parameters are zero in the scene; 1 for all other dimensions."""


def _parameter(p: Parameter, identity: str, label: str, motion: MotionKind | None) -> Slider:
    """A decade to each side of a positive value; else a range around it, or from zero."""
    printed_unit = Unit("") if p.dimension is Dimension.RATIO else p.shown_unit(motion)
    value, rule = nearest_double(p.value), p.rule
    # Strictly between 0 and 1: the slider stays a hundredth away from both.
    if rule is Rule.FRACTION:
        return Slider(identity, label, printed_unit, value, 0.01, 0.99, rule)
    if rule is Rule.ANY:
        # Either sign is allowed: the slider is symmetric about 0.
        reach = 2 * abs(value) or 1.0
        return Slider(identity, label, printed_unit, value, -reach, reach, rule)
    if value > 0:
        return Slider(
            identity, label, printed_unit, value, value / 10, value * 10, rule, is_logarithmic=True
        )
    return Slider(
        identity, label, printed_unit, value, 0.0, _MOST_AT_ZERO.get(p.dimension, 1.0), rule
    )


def _probe(e: Evaluation) -> tuple[Slider, str]:
    """Return the slider of the frequency at which the explorer prints values: at first the middle
    of the band."""
    low, high = (float(e.chart.points[i].omega) for i in (0, -1))
    size = float(e.scene.frequency.size)
    middle = size * float(f"{(low + high) / (2 * size):.4g}")
    unit = e.scene.frequency
    label = inline(OMEGA if unit == RADIANS else named("f"))
    slider = Slider("explorer-omega", label, unit, middle, low, high, Rule.NONNEGATIVE, most=high)
    return slider, "frequency at which values are printed"
