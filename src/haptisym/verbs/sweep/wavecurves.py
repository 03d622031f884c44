"""What a sweep asks of a scene with delays, holds or powers s^alpha: the families of functions whose zeros answer it."""

from __future__ import annotations

from collections.abc import Sequence

from sympy import Expr

from haptisym.kernel.errors import HaptisymError
from haptisym.kernel.response import RealFunction
from haptisym.kernel.rings import Polynomial, PolynomialRing, RationalFunction
from haptisym.model.knobs import Knob
from haptisym.model.scene import Scene
from haptisym.verbs.sweep.curves import ClosedForms, Curves, Reader, closed_forms
from haptisym.verbs.sweep.families import Family, Monomial
from haptisym.verbs.sweep.waves import WaveFamily, WaveReader, is_readable, is_trusted


def wave_curves(scene: Scene, swept: Sequence[Knob]) -> Curves | None:
    """The curves of a scene; None where they are not made of such functions, or sines are not to be trusted here.

    A power s^alpha needs a number for alpha, a delay a number times powers of parameters.
    """
    asked = closed_forms(scene, swept)
    if asked is None or not is_trusted():
        return None
    functions = asked.functions
    if len({f.half_angled.ring.meanings for f in functions}) > 1 or not is_readable(functions[0]):
        return None
    try:
        return _Reader(scene, swept, asked).curves()
    except HaptisymError:
        return None  # a constant of which too few digits are known


class _Reader(Reader):
    """Reads half-angled forms.

    r^2 = A/B in lowest terms is not negative for any real values of its variables, the tangents and powers among them. So
    no factor of A or B of odd multiplicity changes its sign, and along any frequency A and B have zeros of even order only:
    where B vanishes, A - c^2 B has no simple zero, and nothing need be known of B (``needs_bounded_ratios``).
    """

    needs_bounded_ratios = False

    def __init__(self, scene: Scene, swept: Sequence[Knob], asked: ClosedForms) -> None:
        super().__init__(scene, swept, asked)
        self._waves = WaveReader(self.turning[0], self.symbols, scene.band[1])

    def _step(self, forms: Sequence[RationalFunction]) -> int:
        return 1

    def _form(self, f: RealFunction) -> RationalFunction:
        return f.half_angled

    def _family(self, ring: PolynomialRing, polynomial: Polynomial, number: Expr) -> WaveFamily:
        return self._waves.family(polynomial, number)

    def _constant(self, value: Monomial) -> Family:
        return self._waves.constant(value)

    def _is_0_at_0(self, ring: PolynomialRing, factor: Polynomial) -> bool:
        powers = ring.context.gens()[ring.size : ring.size + len(self._waves.orders)]
        return any(factor == x for x in [ring.variable, *powers])
