"""The designer's questions on a page: which values of each parameter would keep the display transparent on its whole band."""

from __future__ import annotations

from collections.abc import Iterator

from haptisym.judge.evaluation import Evaluation
from haptisym.model.knobs import THRESHOLD, Knob
from haptisym.pages.report.results import ratio
from haptisym.pages.require import sets
from haptisym.pages.words import both
from haptisym.verbs.require.entry import is_quick, require
from haptisym.verbs.require.required import Requirement
from haptisym.writing.boxes import Box
from haptisym.writing.document import Phrase
from haptisym.writing.htmltext import Html, element, joined, listed, table
from haptisym.writing.layout import layout
from haptisym.writing.mathematics import inline
from haptisym.writing.numerals import rounded
from haptisym.writing.plain import said

_MOST_PARAMETERS = 8  # for more, ``haptisym require`` has the time


def design(e: Evaluation) -> Iterator[Html]:
    """A row for each parameter: the exact set of values, and what binds at its ends; all others keep the scene's values."""
    found = requirements(e)
    if not found:
        return
    yield element(
        "p", "All values of one parameter for which neither ratio exceeds its threshold anywhere on the band, the others "
        "being as they are in the scene: exact, by critical values and one exact test between each two of them.",
    )  # fmt: skip
    if e.scene.untied():
        yield element("p", e.scene.untied_note())
    caption = "Values for which the display is transparent on its whole band, proven."
    yield table(["parameter", "in the scene", "transparent for", "what binds"], [_row(r) for r in found], caption)


def requirements(e: Evaluation) -> list[Requirement]:
    """For each parameter and for the threshold, where that takes no more than moments; none for other scenes."""
    if len(e.scene.parameters) > _MOST_PARAMETERS or not is_quick(e.scene):
        return []
    return [require(e.scene, path) for path in (*(x.path for x in e.scene.parameters), THRESHOLD)]


def _row(r: Requirement) -> list[str]:
    own = joined([inline(layout(rounded(r.free.value))), _unit(r.free)])
    return [inline(layout(r.free.symbol)), own, _set(r), _binding(r)]


def _set(r: Requirement) -> Html:
    return _marked(sets(r))


def _marked(phrase: Phrase) -> Html:
    if isinstance(phrase, tuple):
        return joined(map(_marked, phrase))
    return joined([inline(phrase) if isinstance(phrase, Box) else said(phrase)])


def _unit(free: Knob) -> str:
    return "" if free.unit == "1" else f" {free.unit.replace('*', '·')}"


def _binding(r: Requirement) -> Html:
    bindings = [b for end in r.ends for b in end.bindings]
    rows = [
        joined([ratio(b.criterion), " at ", _marked(both(b.omega))]) if b.omega is not None else ratio(b.criterion)
        for b in bindings
    ]
    return listed(rows) if rows else joined(["–"])
