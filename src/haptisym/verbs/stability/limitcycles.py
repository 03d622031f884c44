"""Possible limit cycles of a display in a hand, by the describing function of its one element that
is not linear: amplitude, frequency, and whether the motion comes back to it.

With N(A) for the element the loop is linear, and swings on where it has a pole at s = j omega: where
the gain that the rest of it asks of the element, as a curve over omega, meets N as a curve over the
amplitude A of what enters the element. Near there a pole moves by N'(A)/asked'(s) dA: the cycle
attracts where a larger amplitude takes it to the left. Estimated: a describing function leaves out
all harmonics, and floats are searched on a grid. Read from ``limit_cycles``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np
from sympy import Integer, Rational, lambdify

from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.rings import s
from haptisym.model.catalogue import DESCRIBED, FRICTION, SAMPLED_LOOP, Effect, Hand
from haptisym.model.quantities import Dimension
from haptisym.model.scene import Scene, clocks
from haptisym.programs.values import Array
from haptisym.verbs.stability.clockedloop import loop_of

Asked: TypeAlias = Callable[[Any], Any]
"""The gain that the loop asks of its element for a pole at s, an array of complex numbers."""
Gain: TypeAlias = Callable[[float], complex]
_FREQUENCIES, _AMPLITUDES = 6000, 300
"""Points of the two curves; cycles nearer to each other than two of them may be missed."""
_DECADES = 3
"""Frequencies are searched so far below and above the band, amplitudes so far above the size."""


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


def limit_cycles(scene: Scene, hand: Hand) -> tuple[LimitCycle, ...]:
    """The possible limit cycles in a hand, by ascending amplitude; none where the scene has no
    element that is not linear, or several, or one that its clock does not read first.

    >>> from haptisym import effects, environments
    >>> wall, friction = environments.mass_spring_damper(k=100), effects.coulomb_friction("1 N", "1 mm")
    >>> late = Scene(wall, (effects.delay("10 ms"), friction))
    >>> [cycle] = limit_cycles(late, Hand("own", m="0.5 kg", b="0.5 N*s/m"))
    >>> f"{cycle.amplitude:.4f} {cycle.omega:.4f} {cycle.attracts}"
    '0.1822 14.0721 False'
    """
    elements = [x for x in scene.effects if x.model in DESCRIBED]
    if len(elements) != 1:
        return ()
    [element] = elements
    place = scene.effects.index(element)
    top = float(scene.band[1])
    if periods := clocks(scene):
        if place != 1 or scene.effects[0].model != SAMPLED_LOOP or element.model == FRICTION:
            return ()
        top = float(np.pi / periods[0])
    try:
        asked = _asked_by_clock(scene, hand) if periods else _asked(scene, hand, place)
    except UndecidedError:
        return ()
    highest = top if periods else top * 10**_DECADES
    omegas = np.geomspace(top / 10**_DECADES, highest * (1 - 1e-9), _FREQUENCIES)
    is_friction, gain = element.model == FRICTION, _gain(element)
    sizes = {x.key: float(x.value) for x in element.parameters}
    # Nothing passes below half a size; a friction force is no amplitude, and that of the scene is
    # where to begin.
    amplitude = sizes.pop("amplitude")
    least = amplitude / 10**_DECADES if is_friction else min(sizes.values()) / 2
    most = least * 10.0 ** (2 * _DECADES if is_friction else _DECADES)
    amplitudes = np.geomspace(least * (1 + 1e-6), most, _AMPLITUDES)
    with np.errstate(all="ignore"):
        found = _met(asked, gain, omegas, amplitudes)
        cycles = dict.fromkeys(_cycle(element, asked, gain, *x) for x in found)
    return tuple(sorted(cycles, key=lambda x: x.amplitude))


def _gain(element: Effect) -> Callable[[float], complex]:
    """The describing function of an amplitude: a factor, or of friction the force that is added."""
    entry = element.dynamics[1 if element.model == FRICTION else 0]
    [symbol] = [x.symbol for x in element.parameters if x.key == "amplitude"]
    own = entry.xreplace({x.symbol: x.value for x in element.parameters if x.symbol != symbol})
    return lambda amplitude: complex(own.xreplace({symbol: Rational(amplitude)}))


def _asked(scene: Scene, hand: Hand, place: int) -> Asked:
    """The gain asked for without a clock: of an impedance Z = -(B + D Zh)/(A + C Zh) towards the
    hand, and of what lies behind the element."""
    hers, rendered = lambdify(s, hand.Z), lambdify(s, scene.rendering.H)
    matrices = [[lambdify(s, x) for x in effect.matrix] for effect in scene.effects]

    def asked(at: Any) -> Any:
        H = rendered(at)
        for a, b, c, d in ([x(at) for x in row] for row in matrices[:place]):
            H = (a * H + b) / (c * H + d)
        wanted = -hers(at)
        for a, b, c, d in ([x(at) for x in row] for row in reversed(matrices[place + 1 :])):
            wanted = (d * wanted - b) / (a - c * wanted)
        is_added = scene.effects[place].model == FRICTION
        return wanted - H if is_added else wanted / H

    return asked


def _asked_by_clock(scene: Scene, hand: Hand) -> Asked:
    """The gain asked for with a clock: the loop's polynomial in w = exp(-s T) is linear in it."""
    loop = loop_of(linear(scene), hand)
    rows = loop.balls(), replace(loop, above=(Integer(0),)).balls()
    closed, opened = (np.array([float(x.mid()) for x in row]) for row in rows)
    opened = np.pad(opened, (0, len(closed) - len(opened)))
    T = float(loop.T)

    def asked(at: Any) -> Any:
        w = np.exp(-at * T)
        return -np.polyval(opened[::-1], w) / np.polyval((closed - opened)[::-1], w)

    return asked


def _met(asked: Asked, gain: Gain, omegas: Array, amplitudes: Array) -> list[tuple[float, float]]:
    """Frequencies and amplitudes at which the two curves meet: crossings of their chords, refined."""
    from scipy.optimize import root  # SciPy is an extra: asked for where it is needed

    one, other = asked(1j * omegas), np.array([gain(x) for x in amplitudes])
    r, q, apart = np.diff(one)[:, None], np.diff(other)[None, :], other[None, :-1] - one[:-1, None]
    cross = (r.conj() * q).imag
    places = (apart.conj() * q).imag / cross, (apart.conj() * r).imag / cross
    inside = np.logical_and.reduce([(x >= 0) & (x < 1) for x in places])

    def off(x: Array) -> list[float]:
        left = asked(1j * np.exp(x[0])) - gain(float(np.exp(x[1])))
        return [left.real, left.imag]

    found = []
    for i, j in np.argwhere(inside):
        start = np.log([omegas[i] * omegas[i + 1], amplitudes[j] * amplitudes[j + 1]]) / 2
        end = root(off, start, tol=1e-12)
        if end.success and np.abs(end.x - start).max() < _NEAR:
            found.append((float(np.exp(end.x[0])), float(np.exp(end.x[1]))))
    return found


_NEAR = 0.1  # as a logarithm: a crossing of curves is no farther from that of its chords
_SMALL = 1e-6  # relative: of the differences that slopes are taken from


def _cycle(element: Effect, asked: Asked, gain: Gain, omega: float, amplitude: float) -> LimitCycle:
    """The limit cycle where the curves meet: it attracts where a larger amplitude moves the pole
    to the left."""
    up, down = 1 + _SMALL, 1 - _SMALL
    slope = (asked(1j * omega * up) - asked(1j * omega * down)) / (2j * omega * _SMALL)
    change = gain(amplitude * up) - gain(amplitude * down)
    dimension = next(x.dimension for x in element.parameters if x.key == "amplitude")
    # Six digits, so that a crossing at a common end of two chords is one.
    amplitude, omega = float(f"{amplitude:.6g}"), float(f"{omega:.6g}")
    attracts = bool((change / slope).real < 0)
    return LimitCycle(element.name, amplitude, omega, attracts, dimension)
