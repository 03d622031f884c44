"""The page of one question about several environments: what does for all, then the answer for each
of them."""

from __future__ import annotations

from collections.abc import Iterator

from haptisym.pages import words as w
from haptisym.pages.require import required
from haptisym.verbs.family.answers import FamilyAnswers
from haptisym.writing import document as doc
from haptisym.writing.document import Document, Phrase, Strong, listed


def page(many: FamilyAnswers) -> Document:
    """Return the page of all environments: a section for each with what its own page has, without
    model and source; remarks that all have, once."""
    pages = {name: x.document().blocks for name, x in many.answers.items()}
    # The last two blocks of a page are its proofs and remarks, and its model and source.
    notes = {
        name: x[-2].entries if isinstance(x[-2], doc.Notes) else () for name, x in pages.items()
    }
    # What every page says is said once, below all of them.
    shared = [x for x in next(iter(notes.values())) if all(x in own for own in notes.values())]
    sections = tuple(
        doc.Section(name, (*x[:-2], *w.noted(y for y in notes[name] if y not in shared)))
        for name, x in pages.items()
    )
    proof = (
        "Proven: the values common to all environments."
        if many.common
        else "Each environment is examined alone."
    )
    proven = *w.left_open(many.left), *shared, proof
    further = ("haptisym evaluate SCENE",)
    return w.page_about(
        many.family, _common(many), sections, proven, "Several environments", None, further
    )


def _common(many: FamilyAnswers) -> Iterator[tuple[Phrase, Phrase]]:
    """Yield the values that satisfy all environments, and what limits them."""
    if many.common is None:
        return
    first = next(iter(many.answers.values()))
    found = w.values_of(many.common, first.free) if many.common.feasible else Strong("no value")
    yield "For all environments", (required(first.criteria), " for ", found)
    if many.common.undecided:
        yield "Undecided", f"{len(many.common.undecided)} intervals of values"
    if many.binding:
        yield "Limited by", listed(dict.fromkeys(f"{name} ({x})" for _, name, x in many.binding))
