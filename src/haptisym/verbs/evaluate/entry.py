"""The evaluation of a scene from which effects that do not matter may be left out."""

from __future__ import annotations

from pathlib import Path

from haptisym.judge import evaluation
from haptisym.judge.evaluation import Evaluation
from haptisym.model.quantities import Number
from haptisym.model.scene import Scene


def evaluate(scene: Scene | str | Path, digits: int = 15, *, tolerance: Number | None = None) -> Evaluation:
    """Evaluate a scene with numbers for all parameters; ``digits`` decimal digits of each crossing, as many as wanted.

    ``tolerance`` : if given, only the effects that matter for it are used (see ``relevance``); the answers are those of the scene
    without the others, and ``relevance`` says by how much the full scene's ratios may differ, and where its crossings are.
    Raises SceneError if a parameter is still a symbol.

    >>> [c.omega.digits(20) for c in evaluate("fu2019").crossings]
    ['7.9789167901747077028', '11.937310924322057781']
    """
    if tolerance is None:
        return evaluation.evaluate(scene, digits)
    from haptisym.verbs.effects.entry import relevance  # loaded where it is asked for

    found = relevance(scene, tolerance)
    return evaluation.evaluate(found.pruned, digits, left_out=found)
