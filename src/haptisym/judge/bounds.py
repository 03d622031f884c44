"""What a chain of series effects does to every environment at once.

Behind a series effect G the distortion is (G - 1) H: |G - 1| |H| long, in a direction that depends on the environment. So
every environment is transparent where |G - 1| is at most the smaller threshold, as then both parts of dH are; and none is
where |G - 1| exceeds sqrt(c_real^2 + c_imag^2), as then one part is too long whatever the direction. Both bounds are attained.
Derivation: 11_any_environment.
"""

from __future__ import annotations

from dataclasses import dataclass

from sympy import Integer

from haptisym.judge.crossings import level
from haptisym.kernel.reals import RealNumber
from haptisym.kernel.response import RealFunction, squared_modulus
from haptisym.kernel.roots import chart
from haptisym.model.distortion import Distortion
from haptisym.model.jnd import Part
from haptisym.model.scene import Scene


@dataclass(frozen=True)
class AnyEnvironment:
    """Bounds on the band for all environments, rad/s, certified.

    ``transparent_below`` : from the band's low end up to here no environment is felt distorted; None if not even there.
    ``opaque_above`` : from here up to the band's high end every environment is; None if not even there.
    """

    transparent_below: RealNumber | None
    opaque_above: RealNumber | None

    def row(self) -> dict[str, float | None]:
        """As a row of a document."""
        ends = {"transparent_below": self.transparent_below, "opaque_above": self.opaque_above}
        return {name: None if omega is None else float(omega) for name, omega in ends.items()}


def relative_square(distortion: Distortion) -> RealFunction | None:
    """|G - 1|^2 of a chain of series effects, a function of omega without the environment; None for any other chain.

    >>> from haptisym import effects, environments
    >>> from haptisym.model.distortion import distort
    >>> spring = environments.mass_spring_damper(k=100)
    >>> relative_square(distort(spring, effects.first_order_lag(20))).factored()
    omega**2/(omega**2 + 400)
    >>> relative_square(distort(spring, effects.shunt(m=1))) is None
    True
    """
    chain = distortion.chain
    series = all(b.is_zero and c.is_zero for _, b, c, _ in chain.matrices)  # a symbol, m s^2 say, is not zero
    if not series or chain.rendered != chain.environment:
        return None
    return squared_modulus((distortion.difference / distortion.env).reduced())


def any_environment(scene: Scene) -> AnyEnvironment | None:
    """The bounds for a scene whose effects are all in series; None for any other.

    >>> from haptisym.model.scenefile import load_scene
    >>> found = any_environment(load_scene("fu2019"))
    >>> found.transparent_below.digits(5), found.opaque_above.digits(6)
    ('7.9223', '11.1001')
    """
    square = relative_square(scene.distortion())
    if square is None:
        return None
    squares = [(scene.threshold[part] ** 2).expand() for part in Part]
    least, most = min(squares), sum(squares, Integer(0))
    table = chart({"all": level(square, least), "none": level(square, most)}, *scene.band)
    transparent = table.where(lambda signs: signs["all"] <= 0)
    opaque = table.where(lambda signs: signs["none"] > 0)
    starts = [x.high.omega for x in transparent[:1] if x.low is table.points[0]]
    ends = [x.low.omega for x in opaque[-1:] if x.high is table.points[-1]]
    return AnyEnvironment(*(found[0] if found else None for found in (starts, ends)))
