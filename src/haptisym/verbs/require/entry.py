"""Inverse design: for which values of a parameter a display is transparent on its whole band, and what binds at the ends."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from haptisym.judge.crossings import noticed
from haptisym.kernel.budget import SECONDS, Told, limited
from haptisym.kernel.dynamics import RealFunction
from haptisym.kernel.reals import whole
from haptisym.model.catalogue import Hand
from haptisym.model.jnd import Part
from haptisym.model.quantities import Number
from haptisym.model.scene import Scene
from haptisym.model.scenefile import as_scene
from haptisym.verbs.require.freeparameter import asked_of, domain
from haptisym.verbs.require.required import STABLE, TRANSPARENT, Requirement, further, solve_all, wishes
from haptisym.verbs.require.verdicts import with_hands


def require(
    scene: Scene | str | Path,
    path: str,
    range: tuple[Number, Number] | None = None,  # noqa: A002 - the word that the question uses
    *,
    part: Part | None = None,
    any_environment: bool = False,
    that: Sequence[str] = (TRANSPARENT,),
    hand: str | Hand | None = None,
    digits: int = 15,
    limit: float | None = SECONDS,
    told: Told | None = None,
) -> Requirement:
    """The values of one parameter for which r_r <= c_real and r_i <= c_imag on the whole band: all of them, exactly.

    ``path`` : of the parameter, as ``effects.filter.omega_n``, ``environment.m``, ``evaluation.jnd``, or its symbol.
    ``range`` : the values asked about, numbers in SI or strings with a unit; all that the model allows if not given.
    ``part`` : ask for one part's condition only. ``any_environment`` : ask for |G - 1| <= c instead, which series effects G
    must keep to go unnoticed with every environment.
    ``that`` : what is asked of the display, together: "transparent", "stable" (in ``hand``, one of the scene or one that the
    package ships; in all hands of the scene if not given), "passive" (every passive hand may hold it, at all frequencies).

    ``limit`` : seconds after which what is proven so far is answered, all other values being undecided; None for no limit.
    ``told`` : is called now and then with how much is done, of how much, and what it is.

    For a rational scene the answer is exact and, without a limit, always complete. With delays, holds or powers of s it is
    certified by ball arithmetic; what that leaves open is in ``undecided``. SceneError where the path, the range or the scene
    is not fit.

    >>> from haptisym.model.scenefile import load_scene
    >>> found = require(load_scene("fu2019"), "effects.filter.omega_n")
    >>> [(x.low.value.digits(12), x.high.value) for x in found.feasible]
    [('122.355814770', None)]
    """
    scene = as_scene(scene)
    digits = whole("digits", digits)
    scene = with_hands(scene, hand) if STABLE in that else scene
    free = scene.knobs[path]
    wanted, asked = wishes(that), domain(free, range)
    judged = asked_of(scene, [free], part, any_environment=any_environment) if TRANSPARENT in wanted else ()
    criteria = (*judged, *further(scene, wanted))
    with limited(limit, told) as budget:
        found = solve_all(scene, free, asked, criteria)
    cut = budget.seconds if budget.reached else None
    return Requirement(
        scene, free, asked, found.feasible, found.undecided, criteria, digits, cut, tuple(wanted), found.reason
    )


def is_quick(scene: Scene) -> bool:
    """Whether exact sets take milliseconds: low order, no delays nor powers of s, rational numbers.

    >>> from haptisym.model.scenefile import load_scene
    >>> is_quick(load_scene("fu2019")), is_quick(load_scene("delayed-spring"))
    (True, False)
    """
    d = scene.distortion()
    for x in noticed(scene.threshold):
        f = x.function(d)
        if not isinstance(f, RealFunction) or f.axis.functions:
            return False
        coefficients = f.axis.univariate(f.function.numerator)
        if coefficients is None or len(coefficients) > _QUICK_DEGREE + 1:
            return False
    return True


_QUICK_DEGREE = 12  # of the threshold polynomial in omega: a device of order 2
