"""What a chain of series effects does to every environment at once.

Behind a series effect G the distortion is (G - 1) H: |G - 1| |H| long, in a direction that depends
on the environment. So every environment is transparent where |G - 1| is at most the smaller
threshold, as then both parts of dH are; and none is where |G - 1| exceeds sqrt(c_real^2 +
c_imag^2), as then one part is too long whatever the direction. Both bounds are attained.
Derivation: 11_any_environment.
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
    """Bounds on the band for all environments, rad/s, certified.

    ``transparent_below`` : from the band's low end up to here no environment is felt distorted;
    None if not even there.
    ``opaque_above`` : from here up to the band's high end every environment is; None if not even
    there.
    """

    transparent_below: RealNumber | None
    opaque_above: RealNumber | None

    def row(self) -> dict[str, float | None]:
        """As a row of a document."""
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
    series = all(
        b.is_zero and c.is_zero for _, b, c, _ in chain.matrices
    )  # a symbol, m s^2 say, is not zero
    return series and chain.rendered == chain.environment


def _square(distortion: Distortion) -> RealFunction:
    found = relative_square(distortion)
    if found is None:
        raise SceneError(
            "a bound for any environment needs effects in series only: evaluate this scene "
            "for its environment"
        )
    return found


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
"""Judges the effects of a scene alone, whatever stands behind them."""


def for_any_environment(threshold: Threshold) -> Criterion:
    """|G - 1| <= c, with the smaller threshold."""
    threshold.need_plain("for any environment")
    return replace(ANY_ENVIRONMENT, threshold=min(threshold.real, threshold.imag))


def around(threshold: Threshold, square: RealFunction) -> tuple[Signed, Signed]:
    """For a region what is positive where some, and where every, change of this squared length
    leaves it.

    By the largest circle inside it and the smallest one around it, both about 0. With a floor, or
    limits for each way, the first is on the careful side, and the second says nothing.
    """
    own, axis, q = threshold.region, square.axis, square.function

    def over(x: Expr, minus: int = 1) -> RealFunction:
        return RealFunction((q * axis.convert(x) - axis.convert(Integer(minus))).reduced())

    if own.shape is Shape.ELLIPSE:  # by trace and determinant of the quadratic form of its border
        upright = 1 - own.tilt**2
        trace = (threshold.real**-2 + threshold.imag**-2) / upright
        whole = over(-trace, -1).function + q * q * axis.convert(
            (threshold.real * threshold.imag) ** -2 / upright
        )
        form, sum_ = RealFunction(whole.reduced()), over(trace, 2)
        return Lattice.largest([sum_, RealFunction(-form.function)]), Lattice(((sum_, form),))
    inner, outer = _circles(threshold)
    return Lattice.largest(map(over, inner)), Lattice((tuple(map(over, outer)),))


def _circles(threshold: Threshold) -> tuple[list[Expr], list[Expr]]:
    """1/radius^2 of circles about 0: within all of the first no change leaves the region, outside
    all of the others every one."""
    region, (a, b) = threshold.region, (threshold.real, threshold.imag)
    if corners := threshold.corners:
        edges = Cornered(S.One, S.One, corners).edges
        inner, outer = (
            (p * p + q * q for p, q in edges),
            (1 / (x * x + y * y) for x, y in corners),
        )
        return list(dict.fromkeys(inner)), list(dict.fromkeys(outer))
    return [x**-2 for x in (a, b, *region.lower) if x is not None], [1 / (a * a + b * b)]


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
        region = scene.threshold.region
        if region.floor is not None or region.lower != (
            None,
            None,
        ):  # where more than the length of a change matters
            return None
        asked = around(scene.threshold, _square(d))
    table = chart(dict(zip(("all", "none"), asked, strict=True)), *scene.band)
    transparent = table.where(lambda signs: signs["all"] <= 0)
    opaque = table.where(lambda signs: signs["none"] > 0)
    starts = [x.high.omega for x in transparent[:1] if x.low is table.points[0]]
    ends = [x.low.omega for x in opaque[-1:] if x.high is table.points[-1]]
    return AnyEnvironment(*(places[0] if places else None for places in (starts, ends)))
