"""Which effects of a scene matter for a tolerance."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from sympy import Expr, Rational

from haptisym.kernel.budget import SECONDS, limited
from haptisym.kernel.errors import SceneError
from haptisym.kernel.roots import sign_of_number
from haptisym.model.quantities import Dimension, Number, number
from haptisym.model.scene import Scene
from haptisym.model.scenefile import as_scene
from haptisym.verbs.effects.ballchain import BallChain
from haptisym.verbs.effects.relevance import Relevance
from haptisym.verbs.effects.subsets import SubsetSearch

TOLERANCE = Rational(1, 100)
"""Unless told otherwise: a tenth of the usual JND."""


def relevance(scene: Scene | str | Path, tolerance: Number = TOLERANCE, *, limit: float | None = SECONDS) -> Relevance:
    """Find which effects of a scene matter: the fewest with which r_r and r_i stay within a tolerance of the full scene's.

    ``tolerance`` : a number >= 0, of the ratios. Guaranteed: the bound holds at every frequency of the band for both
    ratios and all left-out effects together; of 12 effects or fewer no smaller set does. ``limit`` : seconds after which a
    LimitError says that it is not decided; None for none. Raises SceneError for a scene with symbols for numbers, and for a
    tolerance that is none.

    >>> from haptisym import effects, environments
    >>> from haptisym.model.jnd import Part
    >>> between = (effects.first_order_lag("20 rad/s"), effects.first_order_lag("1 MHz", name="cable"))
    >>> found = relevance(Scene(environments.mass_spring_damper(1.8, 15, 100), between))
    >>> [e.name for e in found.pruned.effects], found.bound[Part.REAL].most < 1e-5
    (['first-order-lag'], True)
    """
    scene = as_scene(scene)
    most = _tolerance(tolerance)
    scene.knobs.need_numbers()
    balls = BallChain(scene)
    with limited(limit):
        choice = SubsetSearch(scene, balls, most).choose()
    kept = tuple(effect for i, effect in enumerate(scene.effects) if i in choice.kept)
    return Relevance(scene, most, replace(scene, effects=kept), choice.bound, choice.smallest, balls)


def _tolerance(given: Number) -> Expr:
    try:
        value = number(given, Dimension.RATIO).value
    except SceneError as error:
        raise error.within("tolerance") from None
    if not value.is_Rational or sign_of_number(value) < 0:
        raise SceneError(f'tolerance: "{given}" must be rational and >= 0')
    return value
