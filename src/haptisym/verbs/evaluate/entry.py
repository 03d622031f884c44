"""The evaluation of a scene from which effects that do not matter may be left out."""

from __future__ import annotations

from pathlib import Path

from haptisym.judge import evaluation
from haptisym.judge.evaluation import Evaluation
from haptisym.model.quantities import Number
from haptisym.model.scene import Scene
from haptisym.model.scenefile import as_scene


def evaluate(
    scene: Scene | str | Path,
    digits: int = 15,
    *,
    tolerance: Number | None = None,
    regions: bool = False,
    proportion: Number | None = None,
) -> Evaluation:
    """Evaluate a scene with numbers for all parameters; ``digits`` decimal digits of each crossing, as many as wanted.

    ``tolerance`` : if given, only the effects that matter for it are used (see ``relevance``); the answers are those of the scene
    without the others, and ``relevance`` says by how much the full scene's ratios may differ, and where its crossings are.
    ``regions`` : whether ``regions`` is to tell what square, disc and diamond of the JND's half widths say, beside its own.
    ``proportion`` : of right answers, to which a JND that tells its own is converted. Raises SceneError if a parameter is still a
    symbol.

    >>> [c.omega.digits(20) for c in evaluate("fu2019").crossings]
    ['7.9789167901747077028', '11.937310924322057781']
    """
    if proportion is not None:
        scene = as_scene(scene).at_proportion(proportion)
    found = _evaluated(scene, digits, tolerance)
    return found.with_regions() if regions else found


def _evaluated(scene: Scene | str | Path, digits: int, tolerance: Number | None) -> Evaluation:
    if tolerance is None:
        return evaluation.evaluate(scene, digits)
    from haptisym.verbs.effects.entry import relevance  # loaded where it is asked for

    found = relevance(scene, tolerance)
    return evaluation.evaluate(found.pruned, digits, left_out=found)
