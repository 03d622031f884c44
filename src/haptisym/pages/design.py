"""The designer's questions in a report: which values of each parameter would keep the display transparent on its band."""

from __future__ import annotations

from collections.abc import Iterator

from haptisym.judge.evaluation import Evaluation
from haptisym.model.knobs import THRESHOLD, Knob
from haptisym.pages.require import sets
from haptisym.pages.words import both, symbol
from haptisym.verbs.require.entry import is_quick, require
from haptisym.verbs.require.required import Requirement
from haptisym.writing.document import Block, Column, Paragraph, Phrase, Table, listed
from haptisym.writing.layout import layout, rounded

_MOST_PARAMETERS = 8  # for more, ``haptisym require`` has the time


def design(e: Evaluation) -> Iterator[Block]:
    """A row for each parameter: the exact set of values, and what binds at its ends; all others keep the scene's values."""
    found = requirements(e)
    if not found:
        return
    yield Paragraph((
        "All values of one parameter for which neither ratio exceeds its threshold anywhere on the band, the others ",
        "being as they are in the scene: exact, by critical values and one exact test between each two of them.",
    ))  # fmt: skip
    if e.scene.untied():
        yield Paragraph(e.scene.untied_note())
    columns = tuple(map(Column, ("parameter", "in the scene", "transparent for", "what binds")))
    how = "proven" if e.scene.level is None else "of the fitted model"
    yield Table(
        columns, tuple(map(_row, found)), f"Values for which the display is transparent on its whole band, {how}."
    )


def requirements(e: Evaluation) -> list[Requirement]:
    """For each parameter and for the threshold, where that takes no more than moments; none for other scenes."""
    if len(e.scene.parameters) > _MOST_PARAMETERS or not is_quick(e.scene):
        return []
    return [require(e.scene, path) for path in (*(x.path for x in e.scene.parameters), THRESHOLD)]


def _row(r: Requirement) -> tuple[Phrase, ...]:
    value = r.free.value if r.free.value.free_symbols else rounded(r.free.value)  # a limit may be a formula in omega
    return layout(r.free.symbol), (layout(value), _unit(r.free)), sets(r), _binding(r)


def _unit(free: Knob) -> str:
    return "" if free.unit == "1" else f" {free.unit.replace('*', '·')}"


def _binding(r: Requirement) -> Phrase:
    found = [
        (symbol(b.criterion.symbol), "" if b.omega is None else (" at ", both(b.omega)))
        for end in r.ends
        for b in end.bindings
    ]
    return listed(found) if found else "–"
