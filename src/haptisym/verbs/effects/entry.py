"""Which effects matter, as a result: a page of text and the document of the command line."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from haptisym.kernel.shown import Answer
from haptisym.model.quantities import Number
from haptisym.model.scene import Scene
from haptisym.pages.effects import document, page
from haptisym.verbs.effects.relevance import TOLERANCE
from haptisym.verbs.effects.relevance import Relevance as Pruned
from haptisym.verbs.effects.relevance import relevance as pruned


class Relevance(Answer, Pruned):
    __doc__ = Pruned.__doc__

    def __str__(self) -> str:
        return page(self)

    def to_dict(self) -> dict[str, Any]:
        """The document of ``haptisym effects --json``, schema ``haptisym.effects/1``."""
        return document(self)

    def to_json(self) -> str:
        """The document of ``haptisym effects --json`` as text."""
        return json.dumps(self.to_dict(), indent=2, ensure_ascii=False)


def relevance(scene: Scene | str | Path, tolerance: Number = TOLERANCE) -> Relevance:
    """Find which effects of a scene matter: the fewest with which r_r and r_i stay within a tolerance of the full scene's.

    ``tolerance`` : a number >= 0, of the ratios. Guaranteed: the bound holds at every frequency of the band for both
    ratios and all left-out effects together; of 12 effects or fewer no smaller set does. Raises SceneError for a scene with
    symbols for numbers, and for a tolerance that is none.

    >>> relevance("fu2019", "1 %")
    <Relevance "Numerical example of Fu, van Paassen and ...": 1 of 1 effects matter for a tolerance of 1/100>
    """
    found = pruned(scene, tolerance)
    return Relevance(found.scene, found.tolerance, found.pruned, found.bound, found.smallest, found.balls)
