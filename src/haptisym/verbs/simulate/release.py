"""Held displaced, and let go: whether hand and display come to rest or shake, by their equations of motion in time.

The hand has held the display displaced for so long that everything rests; then the force with which it holds fades within a
moment, and its mass, damping and stiffness alone stay. Clocks, delay lines and friction are real ones (``blocks``,
``engine``); the closed form of H_perc is not used. From the motion that follows, rate and frequency of what lasts longest are
read by a matrix pencil, and held against the rightmost root of H_perc(s) + m s^2 + b s + k.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import inf, pi
from pathlib import Path

import numpy as np

from haptisym.kernel.budget import SECONDS, limited
from haptisym.kernel.errors import SceneError
from haptisym.kernel.terms import at_least, order_at_0
from haptisym.model.caveats import clocks
from haptisym.model.hand import Hand, how_to_give
from haptisym.model.quantities import Dimension, Number, quantity
from haptisym.model.quantities import MotionKind as Kind
from haptisym.model.scene import Scene
from haptisym.model.scenefile import as_scene
from haptisym.programs.values import Array
from haptisym.verbs.simulate.blocks import Port
from haptisym.verbs.simulate.clockroot import clocked_root
from haptisym.verbs.simulate.engine import Engine
from haptisym.verbs.simulate.frictions import join_frictions
from haptisym.verbs.simulate.motions import _fade, positive
from haptisym.verbs.simulate.network import MOTION, Network, SignalSum, exact, name_of
from haptisym.verbs.simulate.pencil import Mode, envelope, slowest
from haptisym.verbs.simulate.released import Closed, Release
from haptisym.verbs.simulate.rest import at_rest
from haptisym.verbs.simulate.rightmost import rightmost_root
from haptisym.verbs.simulate.run import build
from haptisym.verbs.simulate.threads import one_thread
from haptisym.verbs.stability.entry import chosen
from haptisym.verbs.stability.held import characteristic, held, ring_of

_SETTLED = 16.0  # powers of e by which a motion falls or grows in a run
_PERIODS = (6, 80)  # of the closed form's oscillation: the shortest and the longest run
_GROWN, _GONE = 1e7, 1e-10  # times the displacement: where a run may end
_STEP = 0.9
_MOST_STEPS = 300_000
_CHUNKS = 60
_NOTHING = 1e-25  # N: what the limit of statics leaves of no force
_CLEAR = 0.02  # relative: readings further apart are none
_HIGHEST = 1e4  # rad/s: what is faster is not what a hand is let go with
_BROAD = 10  # times the scale: the frequencies at which a release moves anything


@dataclass(frozen=True)
class LettingGo:
    """The force with which the hand holds: constant, then fading within ``fade`` seconds. As a ``Motion`` of an engine."""

    force: float
    fade: float
    span: tuple[float, float]
    name: str = "release"
    omegas: tuple[float, ...] = ()
    duration: float | None = None
    smoothness: int = 1000
    breaks: tuple[float, ...] = ()
    kind: Kind | None = None

    @property
    def amplitude(self) -> float:
        """The force that holds the hand displaced, N or N m."""
        return abs(self.force)

    def derivatives(self, t: Array, order: int) -> Array:
        """The force and its derivatives."""
        rows = -self.force * _fade(t, self.fade, order)
        rows[0] += self.force
        return rows


def release(
    scene: Scene | str | Path,
    displacement: Number,
    hand: str | Hand | None = None,
    *,
    duration: Number | None = None,
    progress: Callable[[float, float], None] | None = None,
    limit: float | None = SECONDS,
) -> Release:
    """Let a display go that a hand has held displaced, and tell at which rate the motion dies away or grows.

    ``displacement`` : m or rad, or with a unit. ``hand`` : one of the scene, or one that the package ships, by name, or a
    ``Hand``; the scene's if it has one and none is given. ``duration`` : s, or with a unit; as long as a verdict needs
    if not given. ``limit`` : seconds that it may take, LimitError after them; None for none.
    Raises SceneError where nothing holds the display (no static stiffness), and for what cannot be simulated.

    >>> from haptisym.model.scenefile import load_scene
    >>> found = release(load_scene("delayed-spring"), "1 cm", Hand("light", m="0.5 kg", b="3.3 N*s/m"))
    >>> found.grows, found.agrees, f"{found.fitted.rate:.6f}", f"{found.closed.rate:.6f}"
    (True, True, '0.145472', '0.145472')
    """
    scene = as_scene(scene)
    scene.knobs.need_numbers()
    hand = _the_hand(scene, hand)
    size = positive("release", displacement, Dimension.DISPLACEMENT)
    _one_kind(scene, quantity(displacement, Dimension.DISPLACEMENT).motion, hand)
    length = None if duration is None else positive("duration", duration, Dimension.TIME)
    with one_thread(), limited(limit):
        return _Run(scene, hand, size, closed_form(scene, hand)).go(length, progress)


def _the_hand(scene: Scene, given: str | Hand | None) -> Hand:
    if given is not None:
        return chosen(scene, given)
    if len(scene.hands) == 1:
        return scene.hands[0]
    several = (
        f"which one of {', '.join(x.name for x in scene.hands)}" if scene.hands else "of this scene nothing tells which"
    )
    raise SceneError(f"letting go needs a hand, {several}: {how_to_give()}")


def _one_kind(scene: Scene, kind: Kind | None, hand: Hand) -> None:
    for what, own in (("release", kind), (f"hand {hand.name}", hand.motion)):
        if own is not None and scene.motion is not None and own is not scene.motion:
            raise SceneError(f"{what}: its unit is {own.value}, but the scene is {scene.motion.value}")


def closed_form(scene: Scene, hand: Hand) -> Closed | None:
    """The rightmost root of H_perc + m s^2 + b s + k, or that of the loop with its clock; None where there is none to find."""
    if clocks(scene):
        sampled = clocked_root(scene, hand)
        return None if sampled is None else Closed(sampled)
    perceived = scene.closed.perc
    ring = ring_of(perceived)
    top = characteristic(perceived, ring.convert(hand.Z))
    shared = min(order_at_0(top, ring), order_at_0(perceived.denominator, ring))
    found = rightmost_root(top, ring, at_least(shared))
    return None if found is None else Closed(found)


class _Run:
    """A release that is being simulated."""

    def __init__(self, scene: Scene, hand: Hand, size: float, closed: Closed | None) -> None:
        self.scene, self.hand, self.size, self.closed = scene, hand, size, closed
        self.periods = [float(x) for x in clocks(scene)]
        self.scale = self._scale()
        self.lead = self._lead()
        span = (1e-3 * self.scale, max(30 * self.scale, 3 * float(scene.band[1])))
        self.net = Network(span)
        self.port = _held(self.net, scene, hand)
        rest = self._rest(span)
        force = rest[MOTION]
        if abs(force) < _NOTHING:
            raise SceneError(
                "neither display nor hand has a static stiffness: held displaced there is no force, and letting go moves nothing"
            )
        letting_go = LettingGo(force, 0.5 / self.scale, span)
        outputs = [(name_of(self.port.X), 0), (name_of(self.port.F), 0)]
        try:
            self.engine = Engine(self.net, letting_go, outputs, _STEP / (3 * self.scale), rest)
        except SceneError as error:
            raise SceneError(f"the hand {hand.name} does not make it a motion in time: {error}") from None

    def _scale(self) -> float:
        """The frequency, rad/s, on which steps and the fading of the force are laid out."""
        found = abs(self.closed.s) if self.closed and self.closed.chain is None else 0.0
        return max(found if found < _HIGHEST else 0.0, float(self.scene.band[1]) / 3)

    def _lead(self) -> complex:
        """What the motion is expected to last as: how long a run takes follows from it, and nothing else."""
        if self.closed is None:
            return complex(0, self.scale)
        low = [x for x in self.closed.root.others if abs(x) < _BROAD * self.scale]
        return low[0] if low else complex(self.closed.chain or 0, self.scale)

    def _rest(self, span: tuple[float, float]) -> dict[str, float]:
        """Every signal while the display is held displaced, and the force that holds it."""
        net = Network(span)
        port = build(net, self.scene)[-1]
        net.equal(port.X, SignalSum.of(MOTION))
        join_frictions(net)
        found = at_rest(net, self.size)
        force = found[name_of(port.F)] + float(self.hand.k.value) * self.size
        return {**found, MOTION: force}

    def go(self, length: float | None, progress: Callable[[float, float], None] | None) -> Release:
        until = min(length or self._duration(), _MOST_STEPS * self.engine.longest)
        stopped = ""
        for end in np.linspace(0, until, _CHUNKS + 1)[1:]:
            try:
                self.engine.advance(float(end), None if progress is None else lambda t: progress(t, until))
            except SceneError as error:
                if "without bound" not in str(error):
                    raise
                stopped = "grown beyond all measure"
                break
            if length is None and (stopped := self._ended(float(end), until)):
                break
        return self._result(stopped)

    def _duration(self) -> float:
        s = self.lead
        period = 2 * pi / max(abs(s.imag), 0.2 * abs(s), 1e-9)
        wanted = _SETTLED / max(abs(s.real), 1e-9)
        return min(max(wanted, _PERIODS[0] * period), _PERIODS[1] * period)

    def _ended(self, end: float, until: float) -> str:
        record = self.engine.record
        last = np.abs(self.engine.signal(name_of(self.port.X))[-max(8, record.count // 20) :]).max()
        if last > _GROWN * self.size and end > 0.2 * until:
            return "grown ten million times"
        return "come to rest" if last < _GONE * self.size else ""

    def _result(self, stopped: str) -> Release:
        engine = self.engine
        time = engine.record.instants.ravel()
        x, force = (engine.signal(name_of(y)).ravel() for y in (self.port.X, self.port.F))
        fitted, error = self._read(x)
        if np.ptp(x[-max(8, len(x) // 20) :]) < _GONE * self.size and not stopped:
            stopped, fitted = "come to rest", None
        return Release(
            self.scene, self.hand, self.size, time, x, force, fitted, error, self.closed, stopped, tuple(self.net.built),
            self._why(), held(self.scene, self.hand),
        )  # fmt: skip

    def _read(self, x: Array) -> tuple[Mode | None, float]:
        """What lasts longest, and how far two readings of it are apart, 1/s."""
        record, column = self.engine.record, self.engine.column(name_of(self.port.X))
        if self.closed and self.closed.is_endless:
            return envelope(record, column, 0.3)
        period, waving = max(self.periods, default=0.0), bool(self.net.fractional)
        turn = abs(self.lead.imag)
        one, other = (slowest(record, column, part, period, waving=waving, turn=turn) for part in (0.35, 0.5))
        if one is None or other is None or abs(one.s - other.s) > _CLEAR * abs(other.s):
            return None, inf
        return other, float(abs(one.s - other.s))

    def _why(self) -> str:
        """Why the closed form is not what was simulated; empty where it is."""
        if self.net.frictions:
            return "sliding friction, for which the closed form has a describing function of one amplitude"
        return "a clock whose loop has no closed form here" if self.periods and self.closed is None else ""


def _held(net: Network, scene: Scene, hand: Hand) -> Port:
    """The display with the hand on it, and a force that holds both: F + m x'' + b x' + k x = the force."""
    port = build(net, scene)[-1]
    own = port.X.through(*(exact(p.value) for p in (hand.k, hand.b, hand.m)))
    net.equal(port.F + own, SignalSum.of(MOTION))
    join_frictions(net)
    return port
