"""A scene on a page: the chain from the environment to the hand, the parameters, the band and the threshold."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from types import MappingProxyType

from sympy import Expr, Symbol

from haptisym.kernel.reals import ExactNumber
from haptisym.model.catalogue import EFFECTS, ENVIRONMENTS, Effect, Environment
from haptisym.model.jnd import Threshold, is_irrational_algebraic
from haptisym.model.knobs import Knob
from haptisym.model.quantities import Dimension, MotionKind, unit_text
from haptisym.model.regions import Shape
from haptisym.model.scene import Scene
from haptisym.pages.words import H_ENV, H_PERC, both, page_about, region
from haptisym.writing.boxes import Absolute, Equation
from haptisym.writing.document import Block, Column, Document, Flow, Paragraph, Phrase, Strong, Table
from haptisym.writing.layout import layout
from haptisym.writing.mathtext import plain
from haptisym.writing.names import named
from haptisym.writing.numerals import rounded

_AS_THEY_ARE: Mapping[Symbol, Symbol] = MappingProxyType({})


def page(scene: Scene) -> Document:
    """A scene as a notebook shows it."""
    return page_about(scene, scene_blocks(scene))


def scene_blocks(scene: Scene, short_names: Mapping[Symbol, Symbol] = _AS_THEY_ARE) -> Iterator[Block]:
    """The chain, the table of parameters, and what is judged; ``short_names`` : other symbols for parameters."""
    hand = (Strong("hand"), " feels ", H_PERC)
    yield Flow((*(_link(place, part) for place, part in scene.elements()), hand))
    rows = tuple(_parameter(scene, short_names, x) for x in scene.parameters)
    if rows:
        columns = ("symbol", "of", "parameter", "quantity", "value", "unit")
        yield Table(tuple(Column(x, number=x == "value") for x in columns), rows, "The parameters, in SI units.")
    low, high = (both(ExactNumber(x)) for x in scene.band)
    yield Paragraph(("The band of interest goes from ", low, " to ", high, ". ", noticeable(scene.threshold)))


def noticeable(c: Threshold) -> Phrase:
    """Which changes are noticed, in a sentence."""
    if c.is_plain:
        return (
            "A change of the real or the imaginary part is noticed when it exceeds the fraction ", threshold(c), " of ",
            Absolute(H_ENV), ".",
        )  # fmt: skip
    if c.region.shape is Shape.SQUARE:
        return "A change of the real or the imaginary part is noticed when it exceeds ", region(c), "."
    return "A change, both parts together, is noticed when it leaves the region: ", region(c), "."


def threshold(c: Threshold) -> Phrase:
    """``c = 0.1``, or the thresholds of both parts where they differ; the region in words where it is none of that."""
    if not c.is_plain:
        return region(c)
    if c.real == c.imag:
        return _equality("c", c.real)
    return _equality("c_real", c.real), " (real) or ", _equality("c_imag", c.imag), " (imaginary)"


def _equality(name: str, value: Expr) -> Phrase:
    """``c = 0.1``, or with ≈ where the number is not rational and was rounded."""
    decimal = value.evalf(6) if is_irrational_algebraic(value) else value if value.is_Rational else rounded(value)
    return Equation((named(name), layout(decimal)), ("=" if value.is_Rational else "≈",))


def _link(place: str, part: Environment | Effect) -> Phrase:
    catalogue = ENVIRONMENTS if isinstance(part, Environment) else EFFECTS
    name = place.removeprefix("effects.")
    about = catalogue[part.model].summary.partition(":")[0].rstrip(".")
    return Strong(name), f" ({about if name == part.model else f'{part.model}: {about}'})"


def _parameter(scene: Scene, short_names: Mapping[Symbol, Symbol], p: Knob) -> tuple[Phrase, ...]:
    quantity = "" if p.dimension is Dimension.ANY else p.dimension.name.lower()
    own = unit_text(p.unit_in(scene.motion or MotionKind.TRANSLATION))
    symbol = named(short_names.get(p.symbol, p.symbol).name)
    places = ", ".join(x.removeprefix("effects.").rpartition(".")[0] for x in p.paths)
    return symbol, places, p.key, quantity, _value(p.value), own or "SI"


def _value(value: Expr) -> Phrase:
    """The exact value; a decimal beside it, or instead of it, where that says more."""
    if value.free_symbols:
        return layout(value)
    if value.is_Rational:
        return plain(value) if len(f"{value.p}{value.q}") <= 16 else f"≈ {plain(rounded(value))}"
    return Equation((layout(value), layout(rounded(value))), ("≈",))
