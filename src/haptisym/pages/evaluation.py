"""The page of an evaluation, which reads like section 3 of the paper: the questions, the answers, what is certain."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from sympy import Add, Expr, Symbol

from haptisym.judge.criteria import JOINT
from haptisym.judge.evaluation import Evaluation
from haptisym.kernel.rings import RationalFunction
from haptisym.kernel.symbols import omega, s
from haptisym.model.jnd import Part
from haptisym.model.quantities import Dimension
from haptisym.pages.bandwidths import bandwidths, published_words
from haptisym.pages.crossings import crossings, joint, proven, ratios_caption, transparency, undecided
from haptisym.pages.held import held
from haptisym.pages.late import drawing, proof
from haptisym.pages.regions import regions
from haptisym.pages.words import (
    CHANGE,
    H_ENV,
    H_PERC,
    OPERATORS,
    both,
    bounds,
    caveats,
    certainty,
    compared,
    ends,
    limits,
    page_about,
    places,
    short,
    spans,
    stiffness_unit,
    unit,
)
from haptisym.writing.boxes import Prefixed
from haptisym.writing.document import (
    Block,
    Code,
    Column,
    Document,
    Facts,
    Figure,
    Live,
    Notes,
    Paragraph,
    Phrase,
    Section,
    Strong,
    Table,
    Versions,
    listed,
)
from haptisym.writing.equations import equation, quantity
from haptisym.writing.formula import readable
from haptisym.writing.mathtext import text

_MOST_LETTERS = 280  # of a formula: three lines

if TYPE_CHECKING:
    from haptisym.pages.sceneforms import SceneForms


def page(e: Evaluation) -> Document:
    """The whole page."""
    full = _InFull(e)
    certain: tuple[Block, ...] = (*caveats(e.caveats), Paragraph(_certain(e)))
    blocks = (
        *_left_out(e),
        Versions((Facts(tuple(_dynamics(e))),), full.findings),
        Section("Scene", (Versions((), full.scene),), "scene"),
        Section("Step 1. When does the hand begin to notice?", tuple(_step_1(e)), "step-1"),
        *regions(e),
        Section("Step 2. How is it felt?", tuple(_step_2(e)), "step-2"),
        Section("Which values would do?", (Versions((), full.design),), "which-values-would-do"),
        Section("Explorer", (Live(full.explorer),), "explorer"),
        Versions(
            certain, lambda: [Section("What is certain", (*certain, proof(e, e.scene), *_assumed()), "certainty")]
        ),
        Section("Derivation", (Versions((), full.derivation),), "derivation", appendix=True),
    )
    return page_about(e.scene, blocks, "Two-step evaluation of a haptic display", e.asides())


@dataclass(frozen=True)
class _InFull:
    """What reports alone say; what writes it is loaded where one is written."""

    evaluation: Evaluation

    @cached_property
    def _forms(self) -> SceneForms:
        from haptisym.pages.sceneforms import SceneForms

        return SceneForms(self.evaluation)

    def findings(self) -> Iterable[Block]:
        from haptisym.pages.findings import findings

        return [Facts(tuple(findings(self.evaluation)), "findings")]

    def scene(self) -> Iterable[Block]:
        from haptisym.pages.scene import scene_blocks

        return scene_blocks(self.evaluation.scene, self._forms.short_names)

    def design(self) -> Iterable[Block]:
        from haptisym.pages.design import design

        return design(self.evaluation)

    def explorer(self) -> str:
        from haptisym.pages.explorer import explorer

        return explorer(self.evaluation, self._forms)

    def derivation(self) -> Iterable[Block]:
        from haptisym.pages.derivation import derivation

        return derivation(self._forms)


def _left_out(e: Evaluation) -> Iterator[Block]:
    """What was left out of the scene, and what that changes at most."""
    r = e.relevance
    if r is None or not r.dropped:
        return
    found = listed(f"[{x.bounds[0]:.6g}, {x.bounds[1]:.6g}] ({x.criterion.name})" for x in r.crossings)
    them = "it" if len(r.dropped) == 1 else "them"
    lie: Phrase = ("Its crossings lie in ", found, " rad/s.") if found else "It has no crossings on the band."
    yield Paragraph((
        "Without ", listed(x.name for x in r.dropped), f": leaving {them} out changes ", bounds(r.bound), " anywhere on the ",
        f"band, proven (tolerance {float(r.tolerance):g}). What follows is exact for the scene without {them}. The full scene ",
        "differs by no more than that. ", lie,
    ))  # fmt: skip


def _dynamics(e: Evaluation) -> Iterator[tuple[str, Phrase]]:
    """Environment, effects and what they make of it; the band and the threshold."""
    d, rendered = e.distortion, e.scene.rendered
    unit = f"  {stiffness_unit(e.scene)}"
    yield "environment", _equation("H_env", d.env, s, unit)
    if rendered:
        yield "rendered", _equation("H_rendered", d.env.ring.convert(rendered.H), s, unit)
    yield "effects", ", ".join(_effect(x.name, x.model) for x in e.scene.effects) or "none"
    yield "perceived", _equation("H_perc", d.perc, s, unit)
    yield "distortion", _equation("Re dH", d.difference_response.real.written, omega)
    yield "", _equation("Im dH", d.difference_response.imag.written, omega)
    low, high = (e.chart.points[i].omega for i in (0, -1))
    yield "band", (both(low), " to ", both(high))
    yield "threshold", (limits(e.scene.threshold), published_words(e.scene.threshold))


def _equation(name: str, function: RationalFunction, variable: Symbol, unit: str = "") -> Phrase:
    """A closed form; of one that is too long to be read, how long it is."""
    form, is_rounded = readable(function, variable)
    written = equation(name, form, relation="≈" if is_rounded else "=")
    if len(text(written)) <= _MOST_LETTERS:
        return written, unit
    reduced = function.reduced()
    above, below = (_terms(reduced.ring.coefficients(p)) for p in (reduced.numerator, reduced.denominator))
    return quantity(name), f" has {above} terms over {below}: see ", Code("haptisym derive")


def _terms(coefficients: Iterable[Expr]) -> int:
    return sum(len(Add.make_args(c.expand())) for c in coefficients if c != 0)


def _effect(name: str, model: str) -> str:
    return name if name == model else f"{name} ({model})"


# Step 1, when.


def _step_1(e: Evaluation) -> Iterator[Block]:
    yield Paragraph(transparency(e))
    yield from bandwidths(e)
    yield _figure(e, "ratios", ratios_caption(e), wide=True)
    yield crossings(e)
    if e.undecided:
        yield undecided(e)
    yield from _any_environment(e)


def _any_environment(e: Evaluation) -> Iterator[Block]:
    found = e.any_environment
    if found is None or not e.scene.effects:
        return
    below, above, end = found.transparent_below, found.opaque_above, e.chart.points[-1].omega
    if below == end:
        yield Paragraph("These effects in series stay unnoticed with any environment whatever on this band.")
        return
    upto: Phrase = "Already at the low end of the band these effects in series are noticed with some environment"
    if below is not None:
        upto = ("With any environment whatever, up to ", short(below), " rad/s these effects in series stay unnoticed")
    beyond = () if above is None else ("; with every one they are noticed above ", short(above), " rad/s")
    yield Paragraph((upto, beyond, "."))


# Step 2, how.


def _step_2(e: Evaluation) -> Iterator[Block]:
    yield percepts(e)
    for part, name in ((Part.REAL, "real"), (Part.IMAG, "imaginary")):
        yield _figure(
            e, f"projections-{part.value}", f"Magnitude of the {name} part of environment and of what is felt: bold where "
            "the difference is noticed, with what it is felt as.",
        )  # fmt: skip
    yield Notes((*_friction(e), *_changeovers(e), *_outside_model(e), *_unbounded(e), *held(e)))
    yield _figure(
        e, "nyquist", "Environment (solid) and what is felt (dashed) in the complex plane; arrows towards higher frequencies.",
    )  # fmt: skip
    yield _figure(
        e, "jnd-square", "Environment and what is felt at one frequency; the grey region holds the changes that are not noticed.",
    )  # fmt: skip


def _figure(e: Evaluation, name: str, caption: str, *, wide: bool = False) -> Figure:
    return drawing(name, caption, "files:draw_figure", e, name, wide=wide)


def percepts(e: Evaluation) -> Block:
    """What is felt where a ratio exceeds its threshold."""
    region = joint(e.criteria)
    if not e.felt:
        why = f"the distortion never leaves the {region.kind}" if region else "neither ratio exceeds its threshold"
        return Paragraph(f"Nothing is noticed on the band: {why}.")
    rows = tuple((ends(x.band), x.part.value if x.part else JOINT, x.words) for x in e.felt)
    where = f"outside the {region.kind}" if region else "where a ratio exceeds its threshold"
    caption = f"What is felt {where}, {proven(e)}."
    return Table((Column("band (rad/s)"), Column("part"), Column("felt as")), rows, caption)


def _friction(e: Evaluation) -> Iterable[Phrase]:
    if e.friction is None:
        return
    newton = unit(Dimension.FORCE, e.scene.motion)
    found = f"Friction of {float(e.friction.force):.4g} {newton} in the display"
    source = "(Veldhuis, Mulder and van Paassen, 2024: a Weber fraction and a floor)"
    if e.friction.noticed is None or e.friction.least is None:
        how = Code('friction = { weber = ..., floor = "... N" }'), " in ", Code("[evaluation]"), "."
        yield f"{found} has a threshold of its own {source}, which the scene does not give: ", *how
    else:
        verdict: Phrase = Strong("noticed") if e.friction.noticed else "not noticed"
        least, reference = (float(x or 0) for x in (e.friction.least, e.friction.reference))
        more = "differs by more" if e.friction.noticed else "differs by no more"
        meant = f"the {reference:.4g} {newton} that should be felt {source}."
        limit = f" as friction, as it {more} than {least:.4g} {newton} from {meant}"
        yield f"{found} is ", verdict, limit


def _changeovers(e: Evaluation) -> Iterable[Phrase]:
    if e.changeovers_environment or e.changeovers_perceived:
        env, perc = (places(x) if x else "no frequency" for x in (e.changeovers_environment, e.changeovers_perceived))
        yield "Spring and inertia change over at ", env, " in the environment, at ", perc, " as felt."


def _outside_model(e: Evaluation) -> Iterable[Phrase]:
    if e.outside_model:
        noticed = "so that no property is named for what is noticed there" if e.unnamed else "but not noticed there"
        active = compared(Prefixed(OPERATORS[Part.IMAG], H_PERC), "<")
        yield (
            "The imaginary part is outside the paper's model ", spans(e.outside_model), f", {noticed}: the display is active (",
            active, ").",
        )  # fmt: skip


def _unbounded(e: Evaluation) -> Iterable[Phrase]:
    if e.unbounded:
        why = (compared(H_ENV, "="), ", or ", CHANGE, " infinite")
        yield "A ratio is unbounded at ", places(e.unbounded), ": nothing to compare with there (", why, ")."


def _certain(e: Evaluation) -> Phrase:
    if e.undecided:
        where = listed((short(point.omega), f" rad/s ({x.name})") for x, point in e.undecided)
        return (
            Strong("UNDECIDED"), " at the precision limit: whether a ratio touches its threshold, crosses it twice or stays ",
            "clear of it near ", where, ". Everything else is proven.",
        )  # fmt: skip
    return certainty(
        e.scene,
        "Certain: these are all crossings on the band, none is missed and none invented; every digit, sign and interval "
        "is proven by exact polynomials and ball arithmetic, not sampled.",
    )


def _assumed() -> Iterator[Block]:
    yield Paragraph((
        "Assumed: that the dynamics are linear, and the threshold of human perception (Fu, van Paassen and Mulder, 2019, eq. ",
        "4). Figures, and an explorer, are drawn in floating point; the figures have every proven frequency among their samples.",
    ))  # fmt: skip
