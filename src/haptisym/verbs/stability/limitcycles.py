"""Possible limit cycles of a display in a hand, by the describing function of its one element that
is not linear: amplitude, frequency, and whether the motion comes back to it.

With its describing function N(A) for the element (Gelb and Vander Velde, Multiple-Input Describing
Functions, 1968) the loop is linear, and swings on where it has a pole at s = j omega. That is where
N(A), a curve over the amplitude A of what enters the element, meets the gain g(s) that the rest of
the loop asks of the element for a pole at s, a curve over omega at s = j omega. With the amplitude
the pole moves by ds = N'(A)/g'(s) dA: the cycle attracts where a larger amplitude takes it to the
left.

Estimated: a describing function leaves out all harmonics, and floats are searched on a grid, so
that no result means no more than that none was found. Begin with ``limit_cycles``;
``cycle_caveats`` says of which hands they are not known.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any, TypeAlias

from sympy import Integer, Rational, lambdify

from haptisym.kernel.arrays import has_arrays, np
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.rings import s
from haptisym.model.catalogue import DESCRIBED, FRICTION, SAMPLED_LOOP, Effect, Hand
from haptisym.model.quantities import Dimension
from haptisym.model.scene import Scene, clocks
from haptisym.verbs.stability.clockedloop import loop_of

if TYPE_CHECKING:
    from haptisym.programs.values import Array

Asked: TypeAlias = Callable[[Any], Any]
"""The gain that the loop asks of its element for a pole at s, an array of complex numbers."""
Gain: TypeAlias = Callable[[float], complex]
"""The describing function N(A) of an amplitude A."""

# Points of the two curves: cycles nearer to each other than two of them may be missed.
_FREQUENCIES, _AMPLITUDES = 6000, 300
# Frequencies are searched so many decades below and above the band, amplitudes above the size.
_DECADES = 3
# How far a crossing of the curves may be from that of their chords, as a natural logarithm: a step
# of the grid is 0.003 in frequency and 0.02 in amplitude.
_NEAR = 0.1
# The relative difference that slopes are taken from: the root of what floats resolve, enlarged as
# values of sines at high frequencies have fewer digits.
_SMALL = 1e-6


@dataclass(frozen=True)
class LimitCycle:
    """A motion that may go on by itself: of the ``element`` by name, the ``amplitude`` of what
    enters it, m, rad, N or N m (``dimension``), the frequency ``omega``, rad/s, and whether it
    ``attracts``."""

    element: str
    amplitude: float
    omega: float
    attracts: bool
    dimension: Dimension = Dimension.DISPLACEMENT

    def row(self) -> dict[str, Any]:
        """As documents have it."""
        numbers = {"amplitude": self.amplitude, "omega": self.omega, "attracts": self.attracts}
        return {"element": self.element, **numbers}


def linear(scene: Scene) -> Scene:
    """Return the scene without its effects that are not linear."""
    return replace(scene, effects=tuple(x for x in scene.effects if x.model not in DESCRIBED))


def unsearched_cycles(scene: Scene, *, released: bool = False) -> str:
    """A sentence that says why possible limit cycles of a scene are not searched; empty where they
    are, or no element is one that is not linear. With ``released`` it proposes no release test."""
    elements = [x for x in scene.effects if x.model in DESCRIBED]
    lead, way_out = (
        "Limit cycles are not searched",
        "" if released else "use a release test: haptisym simulate --release",
    )
    or_else = f", or {way_out}" if way_out else ""
    if len(elements) > 1:
        names = ", ".join(x.name for x in elements)
        return f"{lead}: {names} are several elements; leave one in{or_else}."
    if not elements:
        return ""
    reads_first = scene.effects[0].model == SAMPLED_LOOP and scene.effects[1:2] == (elements[0],)
    if clocks(scene) and elements[0].model == FRICTION:
        return f"{lead}: {elements[0].name} is not what the clock reads{'; ' * bool(way_out)}{way_out}."
    if clocks(scene) and not reads_first:
        return (
            f"{lead}: {elements[0].name} is not what the clock reads. Place it directly after the "
            f"sampled controller (haptisym scenes wheel-with-encoder){or_else}."
        )
    if not (has_arrays() and find_spec("scipy")):
        return f"{lead}: NumPy or SciPy is missing: pip install 'haptisym[simulate]'."
    return ""


def cycle_caveats(
    scene: Scene, found: Mapping[str, tuple[LimitCycle, ...] | None], *, released: bool = False
) -> tuple[str, ...]:
    """The sentences on the hands, by name, whose limit cycles are not known: why none are searched,
    or that they are undecided; those of a release test where ``released``."""
    unknown = [name for name, cycles in found.items() if cycles is None]
    if unknown and (why := unsearched_cycles(scene, released=released)):
        return (why,)
    return tuple(f"Limit cycles in {name} are undecided." for name in unknown)


def limit_cycles(scene: Scene, hand: Hand) -> tuple[LimitCycle, ...] | None:
    """The possible limit cycles in a hand, by ascending amplitude. None where they are not known:
    not searched (``unsearched_cycles``), or the loop with a clock is undecided.

    >>> from haptisym import effects, environments
    >>> wall, friction = environments.mass_spring_damper(k=100), effects.coulomb_friction("1 N", "1 mm")
    >>> late = Scene(wall, (effects.delay("10 ms"), friction))
    >>> [cycle] = limit_cycles(late, Hand("own", m="0.5 kg", b="0.5 N*s/m"))
    >>> f"{cycle.amplitude:.4f} {cycle.omega:.4f} {cycle.attracts}"
    '0.1822 14.0721 False'
    """
    elements = [x for x in scene.effects if x.model in DESCRIBED]
    if not elements:
        return ()
    if unsearched_cycles(scene):
        return None
    [element] = elements
    place = scene.effects.index(element)
    has_clock = bool(clocks(scene))
    try:
        asked = _asked_by_clock(scene, hand) if has_clock else _asked(scene, hand, place)
    except UndecidedError:
        return None
    gain, omegas, amplitudes = _gain(element), _frequencies(scene), _amplitudes(element)
    with np.errstate(all="ignore"):
        meetings = _meetings(asked, gain, omegas, amplitudes)
        cycles = dict.fromkeys(_cycle(element, asked, gain, *x) for x in meetings)
    return tuple(sorted(cycles, key=lambda x: x.amplitude))


def _frequencies(scene: Scene) -> Array:
    """The frequencies that are searched, rad/s: with a clock of period T those below pi/T."""
    periods = clocks(scene)
    if periods:
        top = float(np.pi / periods[0])
        highest = top
    else:
        top = float(scene.band[1])
        highest = top * 10**_DECADES
    return np.geomspace(top / 10**_DECADES, highest * (1 - 1e-9), _FREQUENCIES)


def _amplitudes(element: Effect) -> Array:
    """The amplitudes that are searched, of what enters the element."""
    sizes = {x.key: float(x.value) for x in element.parameters}
    amplitude = sizes.pop("amplitude")
    if element.model == FRICTION:
        # A friction force is no amplitude: that of the scene is in the middle of the range.
        least = amplitude / 10**_DECADES
        most = least * 10.0 ** (2 * _DECADES)
    else:
        # Nothing passes below half a size.
        least = min(sizes.values()) / 2
        most = least * 10.0**_DECADES
    return np.geomspace(least * (1 + 1e-6), most, _AMPLITUDES)


def _gain(element: Effect) -> Gain:
    """The describing function N(A): a factor, or of friction the force that is added."""
    entry = element.dynamics[1 if element.model == FRICTION else 0]
    [symbol] = [x.symbol for x in element.parameters if x.key == "amplitude"]
    sizes = {x.symbol: x.value for x in element.parameters if x.symbol != symbol}
    of_amplitude = entry.xreplace(sizes)
    return lambda amplitude: complex(of_amplitude.xreplace({symbol: Rational(amplitude)}))


def _asked(scene: Scene, hand: Hand, place: int) -> Asked:
    """The gain asked for without a clock.

    ``place`` : which effect the element is. Behind it is H, what is rendered as the effects up to
    the element pass it on. Before it the hand's dynamics Z_h must balance what is felt, -Z_h;
    solved for what lies behind an effect, H' = (A H + B)/(C H + D) is H = (D H' - B)/(A - C H').
    The element must make the one of the other, as a factor or, friction, as a sum.
    """
    hand_dynamics, rendered = lambdify(s, hand.Z), lambdify(s, scene.rendering.H)
    matrices = [[lambdify(s, x) for x in effect.matrix] for effect in scene.effects]
    is_added = scene.effects[place].model == FRICTION

    def asked(at: Any) -> Any:
        H = rendered(at)
        for matrix in matrices[:place]:
            a, b, c, d = (entry(at) for entry in matrix)
            H = (a * H + b) / (c * H + d)
        wanted = -hand_dynamics(at)
        for matrix in reversed(matrices[place + 1 :]):
            a, b, c, d = (entry(at) for entry in matrix)
            wanted = (d * wanted - b) / (a - c * wanted)
        return wanted - H if is_added else wanted / H

    return asked


def _asked_by_clock(scene: Scene, hand: Hand) -> Asked:
    """The gain asked for with a clock. The characteristic polynomial of the linear loop in w =
    exp(-s T) is p + N q for a gain N of the element that the clock reads first: p is what is left
    without what is rendered, so that N = -p/q."""
    loop = loop_of(linear(scene), hand)
    without_rendered = replace(loop, above=(Integer(0),))
    whole = np.array([float(x.mid()) for x in loop.balls()])
    p = np.array([float(x.mid()) for x in without_rendered.balls()])
    p = np.pad(p, (0, len(whole) - len(p)))
    q = whole - p
    T = float(loop.T)

    def asked(at: Any) -> Any:
        w = np.exp(-at * T)
        # NumPy has the highest power first.
        return -np.polyval(p[::-1], w) / np.polyval(q[::-1], w)

    return asked


def _meetings(
    asked: Asked, gain: Gain, omegas: Array, amplitudes: Array
) -> list[tuple[float, float]]:
    """Frequencies and amplitudes at which the two curves meet: crossings of their chords, refined.

    The chords P + x r, from one frequency to the next, and Q + y q, from one amplitude to the next,
    cross where x r - y q = Q - P. By Cramer's rule, with a x b = Im(conj(a) b) in the plane, x =
    (Q - P) x q/(r x q) and y = (Q - P) x r/(r x q); both must be from 0 to 1.
    """
    from scipy.optimize import root  # SciPy is an extra: asked for where it is needed

    one, other = asked(1j * omegas), np.array([gain(x) for x in amplitudes])
    r, q = np.diff(one)[:, None], np.diff(other)[None, :]
    apart = other[None, :-1] - one[:-1, None]
    determinant = (r.conj() * q).imag
    x = (apart.conj() * q).imag / determinant
    y = (apart.conj() * r).imag / determinant
    is_inside = (x >= 0) & (x < 1) & (y >= 0) & (y < 1)

    def difference(logarithms: Array) -> list[float]:
        omega, amplitude = np.exp(logarithms)
        z = asked(1j * omega) - gain(float(amplitude))
        return [z.real, z.imag]

    meetings = []
    for i, j in np.argwhere(is_inside):
        start = np.log([omegas[i] * omegas[i + 1], amplitudes[j] * amplitudes[j + 1]]) / 2
        end = root(difference, start, tol=1e-12)
        if end.success and np.abs(end.x - start).max() < _NEAR:
            omega, amplitude = (float(np.exp(logarithm)) for logarithm in end.x)
            meetings.append((omega, amplitude))
    return meetings


def _cycle(element: Effect, asked: Asked, gain: Gain, omega: float, amplitude: float) -> LimitCycle:
    """The limit cycle where the curves meet, with its ``attracts``, by the sign of Re ds/dA."""
    up, down = 1 + _SMALL, 1 - _SMALL
    # g' over s = j omega, of which the step is j omega _SMALL to either side.
    rise = asked(1j * omega * up) - asked(1j * omega * down)
    slope = rise / (2j * omega * _SMALL)
    change = gain(amplitude * up) - gain(amplitude * down)
    dimension = next(x.dimension for x in element.parameters if x.key == "amplitude")
    # Six digits, so that a crossing at a common end of two chords is one.
    amplitude, omega = float(f"{amplitude:.6g}"), float(f"{omega:.6g}")
    attracts = bool((change / slope).real < 0)
    return LimitCycle(element.name, amplitude, omega, attracts, dimension)
