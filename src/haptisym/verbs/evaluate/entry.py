"""The evaluation of a scene as a command: with its tolerance, regions, proportion and movement; of
a measured scene frequency by frequency."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, overload

from haptisym.judge import evaluation
from haptisym.judge.evaluation import Evaluation
from haptisym.kernel.budget import SECONDS, in_time, limited
from haptisym.kernel.errors import SceneError
from haptisym.model.measuredscene import MeasuredScene
from haptisym.model.quantities import Number
from haptisym.model.scene import Scene
from haptisym.model.scenefile import as_scene, chosen, open_scenes

if TYPE_CHECKING:
    from haptisym.verbs.measured.entry import MeasuredEvaluation

_DIGITS = 15


@overload
def evaluate(scene: MeasuredScene) -> MeasuredEvaluation: ...
@overload
def evaluate(
    scene: Scene,
    digits: int = ...,
    *,
    tolerance: Number | None = ...,
    regions: bool = ...,
    proportion: Number | None = ...,
    movement: str | Path | None = ...,
    discriminate: bool = ...,
    limit: float | None = ...,
) -> Evaluation: ...
@overload
def evaluate(
    scene: str | Path,
    digits: int = ...,
    *,
    tolerance: Number | None = ...,
    regions: bool = ...,
    proportion: Number | None = ...,
    movement: str | Path | None = ...,
    discriminate: bool = ...,
    limit: float | None = ...,
) -> Evaluation | Any: ...
def evaluate(
    scene: Scene | MeasuredScene | str | Path,
    digits: int = _DIGITS,
    *,
    tolerance: Number | None = None,
    regions: bool = False,
    proportion: Number | None = None,
    movement: str | Path | None = None,
    discriminate: bool = False,
    limit: float | None = SECONDS,
) -> Evaluation | MeasuredEvaluation:
    """Evaluate a scene with numbers for all parameters; ``digits`` decimal digits of each crossing,
    as many as wanted.

    ``tolerance`` : if given, only the effects that matter for it are used (see ``relevance``); the
    answers are those of the scene without the others, and ``relevance`` has by how much the full
    scene's ratios may differ, and where its crossings are.
    ``regions`` : whether ``regions`` is to have the answers for square, disc and diamond of the
    JND's half widths as well.
    ``proportion`` : of right answers, to which a JND with a proportion of its own is converted.
    ``movement`` : such as "0:15" (rad/s), for which ``movement`` is to have what a fit of k, b and
    m to it reports (``verbs.evaluate.movement``). ``discriminate`` : whether ``discrimination`` is
    to have which changes would decide between square, disc and tilted ellipses.
    ``limit`` : seconds of processor time after which ``left`` names what is not decided; None for
    none. LimitError where the crossings are not.
    A scene whose perceived dynamics is measured is judged at its lines alone, and gives a
    ``MeasuredEvaluation``.
    Raises SceneError if a parameter is still a symbol.

    >>> [c.omega.digits(20) for c in evaluate("fu2019").crossings]
    ['7.9789167901747077028', '11.937310924322057781']
    """
    given = _opened(scene) if isinstance(scene, str | Path) else scene
    if isinstance(given, MeasuredScene):
        from haptisym.verbs.measured.entry import judge  # loaded where it is asked for

        if (
            any(x is not None for x in (tolerance, proportion, movement))
            or digits != _DIGITS
            or regions
            or discriminate
        ):
            raise SceneError(
                "a measured scene is evaluated without digits, tolerance, regions, "
                "discriminate, proportion and movement: "
                "leave them out"
            )
        return judge(given)
    if proportion is not None:
        given = as_scene(given).at_proportion(proportion)
    with limited(limit):
        found = _evaluated(given, digits, tolerance)
        if regions or discriminate:
            found = in_time(found.with_regions, "regions", found.left) or found
        if discriminate:
            found = _discriminated(found)
        if movement is not None:
            found = _moved(found, movement)
        # those of a range of thresholds are computed now, while the limit holds; where the time is
        # over they note it themselves
        _ = found.bandwidths
    return found


def _discriminated(found: Evaluation) -> Evaluation:
    """The evaluation with the changes that would decide between regions, if there is time for
    it."""
    from haptisym.verbs.evaluate.discriminate import discriminate  # loaded where it is asked for

    discrimination = in_time(partial(discriminate, found), "discriminate", found.left)
    return replace(found, discrimination=discrimination)


def _moved(found: Evaluation, given: str | Path) -> Evaluation:
    """The evaluation with what a fit to a movement reports, if there is time for it."""
    from haptisym.verbs.evaluate.movement import movement  # loaded where it is asked for

    fitted = in_time(partial(movement, found.scene, given), "movement", found.left)
    return replace(found, movement=fitted)


def _evaluated(scene: Scene, digits: int, tolerance: Number | None) -> Evaluation:
    """The evaluation of a scene, without the effects that do not matter for a tolerance."""
    if tolerance is None:
        return evaluation.evaluate(scene, digits)
    from haptisym.verbs.effects.relevance import relevance

    found = relevance(scene, tolerance, limit=None)
    return evaluation.evaluate(found.pruned, digits, left_out=found)


def _opened(scene: str | Path) -> Scene | MeasuredScene:
    found, name = open_scenes(scene)
    return found if isinstance(found, MeasuredScene) else chosen(found, name, None)
