"""A scene on a page: the chain from the environment to the hand, the parameters, the band and the threshold."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from sympy import Expr, Symbol

from haptisym.kernel.reals import ExactNumber
from haptisym.model.catalogue import EFFECTS, ENVIRONMENTS, Effect, Environment
from haptisym.model.jnd import Threshold
from haptisym.model.knobs import Knob
from haptisym.model.quantities import Dimension, Motion, unit_text
from haptisym.model.scene import Scene
from haptisym.pages.report.results import H_ENV, H_PERC, both, equality
from haptisym.writing.boxes import Equation
from haptisym.writing.htmltext import Html, element, joined, table
from haptisym.writing.layout import layout
from haptisym.writing.mathematics import inline
from haptisym.writing.names import named
from haptisym.writing.numerals import rounded


def scene_parts(scene: Scene, short_names: Mapping[Symbol, Symbol]) -> Iterator[Html]:
    """The chain, the table of parameters, and what is judged; ``short_names``: other symbols for parameters."""
    yield _chain(scene)
    rows = [_parameter(scene, short_names, x) for x in scene.parameters]
    if rows:
        head = ["symbol", "of", "parameter", "quantity", "value", "unit"]
        yield table(head, rows, "The parameters, in SI units.", numbers=(4,))
    low, high = (both(ExactNumber(x)) for x in scene.band)
    yield element(
        "p", "The band of interest goes from ", low, " to ", high, ". A change of the real or the imaginary part is noticed "
        "when it exceeds the fraction ", threshold(scene.threshold), " of |", H_ENV, "|.",
    )  # fmt: skip


def threshold(c: Threshold) -> Html:
    """``c = 0.1``, or the thresholds of both parts where they differ."""
    if c.real == c.imag:
        return equality("c", c.real)
    real, imag = equality("c_real", c.real), equality("c_imag", c.imag)
    return joined([real, " (real) or ", imag, " (imaginary)"])


def _chain(scene: Scene) -> Html:
    """What stands between environment and hand, in order."""
    items = [_link(place, part) for place, part in scene.elements()]
    hand = element("li", element("strong", "hand"), " ", element("span", "feels ", H_PERC))
    return element("ol", *items, hand, given={"class": "chain"})


def _link(place: str, part: Environment | Effect) -> Html:
    catalogue = ENVIRONMENTS if isinstance(part, Environment) else EFFECTS
    name = place.removeprefix("effects.")
    kind = ["" if name == part.model else element("em", part.model)]
    about = catalogue[part.model].summary.partition(":")[0].rstrip(".")
    return element("li", joined([element("strong", name), *kind, element("span", about)], " "))


def _parameter(scene: Scene, short_names: Mapping[Symbol, Symbol], p: Knob) -> list[str]:
    quantity = "" if p.dimension is Dimension.ANY else p.dimension.name.lower()
    unit = unit_text(p.dimension.unit(scene.motion or Motion.TRANSLATION))
    symbol = inline(named(short_names.get(p.symbol, p.symbol).name))
    places = ", ".join(x.removeprefix("effects.").rpartition(".")[0] for x in p.paths)
    return [symbol, places, p.key, quantity, _value(p.value), unit or "SI"]


def _value(value: Expr) -> Html:
    """The exact value; a decimal beside it, or instead of it, where that says more."""
    if value.free_symbols or (value.is_Rational and len(f"{value.p}{value.q}") <= 16):
        return inline(value)
    shown = layout(rounded(value))
    return joined(["≈ ", inline(shown)]) if value.is_Rational else inline(Equation((layout(value), shown), ("≈",)))
