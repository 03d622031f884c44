"""Bounds on the band over which a chain of series effects is transparent with every environment,
and with none.

A *series effect* multiplies the dynamics: together H_perc = G H_env, and on s = j omega the
distortion dH = (G - 1) H_env has the modulus |G - 1| |H_env| and a direction in the complex plane
that depends on the environment. A change is noticed where |Re dH| > c_real |H_env| or |Im dH| >
c_imag |H_env|. Hence, at each frequency,

- every environment is transparent where |G - 1| <= min(c_real, c_imag), as no part of dH is larger
  than its modulus,
- none is where |G - 1| > sqrt(c_real^2 + c_imag^2), as a dH within both limits has at most that
  modulus.

Both bounds are attained, by environments whose phase is the right one. Derivation:
11_any_environment. Begin with ``any_environment``; ``around`` does the same for a JND region, by
the circles inside and around it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from sympy import Expr, Integer, S, sqrt

from haptisym.judge.crossings import Criterion, noticed
from haptisym.judge.regions import Cornered
from haptisym.kernel.dynamics import RealFunction, squared_modulus
from haptisym.kernel.errors import SceneError
from haptisym.kernel.reals import RealNumber
from haptisym.kernel.roots import Lattice, Signed, chart
from haptisym.model.chain import Chain
from haptisym.model.distortion import Distortion
from haptisym.model.jnd import Shape, Threshold
from haptisym.model.scene import Scene


@dataclass(frozen=True)
class AnyEnvironment:
    """Bounds on the band that hold for all environments, rad/s, proven.

    ``transparent_below`` : from the band's low end up to here the distortion of no environment is
    noticed; None if it may be at the low end. ``opaque_above`` : from here up to the band's high
    end that of every environment is noticed; None if it may not be at the high end.
    """

    transparent_below: RealNumber | None
    opaque_above: RealNumber | None

    def row(self) -> dict[str, float | None]:
        """The bounds as a row of a document, rad/s."""
        ends = {"transparent_below": self.transparent_below, "opaque_above": self.opaque_above}
        return {name: None if omega is None else float(omega) for name, omega in ends.items()}


def relative_square(distortion: Distortion) -> RealFunction | None:
    """|G - 1|^2 of a chain of series effects, a function of omega without the environment; None for
    any other chain.

    >>> from haptisym import effects, environments
    >>> from haptisym.model.distortion import distort
    >>> spring = environments.mass_spring_damper(k=100)
    >>> relative_square(distort(spring, effects.first_order_lag(20))).factored()
    omega**2/(omega**2 + 400)
    >>> relative_square(distort(spring, effects.shunt(m=1))) is None
    True
    """
    if not is_series(distortion.chain):
        return None
    return squared_modulus((distortion.difference / distortion.env).reduced())


def is_series(chain: Chain) -> bool:
    """Whether H_perc is G H_env."""
    # ``is_zero`` of a symbol, m s^2 say, is None: it counts as not zero.
    series = all(b.is_zero and c.is_zero for _, b, c, _ in chain.matrices)
    return series and chain.rendered == chain.environment


def _square(distortion: Distortion) -> RealFunction:
    """As ``relative_square``; SceneError where effects are not in series."""
    square = relative_square(distortion)
    if square is None:
        raise SceneError(
            "a bound for any environment needs effects in series only: evaluate this scene "
            "for its environment"
        )
    return square


def _modulus(values: Any) -> Any:
    return abs(values.relative_real + 1j * values.relative_imag)


ANY_ENVIRONMENT = Criterion(
    "any environment",
    "any environment",
    "|G - 1|",
    "|G - 1| <= c",
    _square,
    _modulus,
    kept="transparent with any environment",
)
"""The criterion that judges the effects of a scene alone, for any environment."""


def for_any_environment(threshold: Threshold) -> Criterion:
    """The criterion |G - 1| <= c, with the smaller of both thresholds as c."""
    threshold.need_plain("for any environment")
    return replace(ANY_ENVIRONMENT, threshold=min(threshold.real, threshold.imag))


def around(threshold: Threshold, square: RealFunction) -> tuple[Signed, Signed]:
    """For a region two functions: positive where some change of this squared length leaves it, and
    where every change does.

    They compare the length with the largest circle inside the region and with the smallest one
    around it, both about 0. With a floor, or limits for each way, the first is on the careful side,
    and the second proves nothing.
    """
    region, axis, q = threshold.region, square.axis, square.function

    def over(x: Expr, minus: int = 1) -> RealFunction:
        return RealFunction((q * axis.convert(x) - axis.convert(Integer(minus))).reduced())

    # On the border of an ellipse a quadratic form is 1, with eigenvalues e1 and e2: a change of the
    # squared length q leaves it for some direction where max(e1, e2) q > 1, for all where both are.
    # Without their roots: (1 - e1 q)(1 - e2 q) = 1 - trace q + determinant q^2, and trace q - 2.
    if region.shape is Shape.ELLIPSE:
        upright = 1 - region.tilt**2
        trace = (threshold.real**-2 + threshold.imag**-2) / upright
        determinant = (threshold.real * threshold.imag) ** -2 / upright
        whole = over(-trace, -1).function + q * q * axis.convert(determinant)
        form, sum_ = RealFunction(whole.reduced()), over(trace, 2)
        return Lattice.largest([sum_, RealFunction(-form.function)]), Lattice(((sum_, form),))
    inner, outer = _circles(threshold)
    return Lattice.largest(map(over, inner)), Lattice((tuple(map(over, outer)),))


def _circles(threshold: Threshold) -> tuple[list[Expr], list[Expr]]:
    """Values 1/radius^2 of circles about 0: within all of the first no change leaves the region,
    outside all of the others every one does."""
    region, (a, b) = threshold.region, (threshold.real, threshold.imag)
    # The line p x + q y = 1 of an edge is 1/sqrt(p^2 + q^2) from 0; the farthest points of a
    # polygon are corners. Which one decides may depend on frequency, so all are kept, equal ones
    # once.
    if corners := threshold.corners:
        edges = Cornered(S.One, S.One, corners).edges
        inner = [p * p + q * q for p, q in edges]
        outer = [1 / (x * x + y * y) for x, y in corners]
        return list(dict.fromkeys(inner)), list(dict.fromkeys(outer))
    distances = [x for x in (a, b, *region.lower) if x is not None]
    return [x**-2 for x in distances], [1 / (a * a + b * b)]


def any_environment(scene: Scene) -> AnyEnvironment | None:
    """The bounds for a scene whose effects are all in series; None for any other.

    >>> from haptisym.model.scenefile import load_scene
    >>> found = any_environment(load_scene("fu2019"))
    >>> found.transparent_below.digits(5), found.opaque_above.digits(6)
    ('7.9223', '11.1001')
    """
    d = scene.distortion()
    if relative_square(d) is None:
        return None
    if scene.threshold.is_plain:
        least = for_any_environment(scene.threshold)
        most: Expr = sqrt(sum(x.limit for x in noticed(scene.threshold)))
        asked: tuple[Signed, Signed] = least.function(d), replace(least, threshold=most).function(d)
    else:
        # With a floor, or limits for each way, more than the length of a change matters.
        region = scene.threshold.region
        if region.floor is not None or region.lower != (None, None):
            return None
        asked = around(scene.threshold, _square(d))
    # Only an interval from the low end of the band, and one up to its high end, is a bound.
    table = chart(dict(zip(("all", "none"), asked, strict=True)), *scene.band)
    transparent = table.where(lambda signs: signs["all"] <= 0)
    opaque = table.where(lambda signs: signs["none"] > 0)
    is_last = bool(opaque) and opaque[-1].high is table.points[-1]
    return AnyEnvironment(table.reach(transparent), opaque[-1].low.omega if is_last else None)
