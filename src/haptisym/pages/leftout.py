"""What is said of the effects that an evaluation leaves out, and of what that changes at most."""

from __future__ import annotations

from collections.abc import Iterator

from haptisym.judge.evaluation import Evaluation
from haptisym.pages.words import bounds
from haptisym.writing.document import Block, Paragraph, listed


def left_out(e: Evaluation) -> Iterator[Block]:
    """What was left out of the scene, and what that changes at most."""
    r = e.relevance
    if r is None or not r.dropped:
        return
    found = listed(f"[{x.bounds[0]:.6g}, {x.bounds[1]:.6g}] ({x.criterion.name})" for x in r.crossings)
    yield Paragraph((
        "Without ", listed(x.name for x in r.dropped), ": leaving them out changes ", bounds(r.bound), " anywhere on the band, ",
        f"proven (tolerance {float(r.tolerance):g}). What follows is exact for the scene without them. The full scene differs ",
        "by no more than that. ", ("Its crossings lie in ", found, " rad/s.") if found else "It has no crossings on the band.",
    ))  # fmt: skip
