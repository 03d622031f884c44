"""A release test: a display is held displaced and let go. Does it come to rest, shake, or rattle?

The hand has held the display displaced for so long that everything rests; then the force with which
it holds fades within a moment, and its mass, damping and stiffness alone stay. Clocks, delay lines
and friction are real ones; the closed form of H_perc is not used. From the motion that follows,
rate and frequency of what lasts longest are read by a matrix pencil (Hua and Sarkar, 1990) on even
samples (``slowest``), and compared with the rightmost root of H_perc(s) + m s^2 + b s + k.

With an encoder, friction or a limit of the force the loop is not linear. It comes to rest, grows,
or rattles: a motion whose size stays as it is while the linear loop's would not. Amplitude and
frequency of that are read from the last half of the run; what is proven is still the verdict on the
linear loop. Read from ``release`` and ``_Run``.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import inf, pi
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from haptisym.judge.answers import Answer
from haptisym.kernel.budget import ONE_THREAD, SECONDS, limited
from haptisym.kernel.dynamics import ring_of
from haptisym.kernel.errors import SceneError
from haptisym.kernel.objects import titled
from haptisym.kernel.rootcount import RootChain, at_least, order_at_0
from haptisym.model.catalogue import DESCRIBED, Hand, how_to_give
from haptisym.model.motions import LettingGo, positive
from haptisym.model.quantities import Dimension, Number, quantity
from haptisym.model.quantities import MotionKind as Kind
from haptisym.model.scene import Scene, chosen_hand, clocks
from haptisym.model.scenefile import as_scene
from haptisym.programs.values import Array
from haptisym.verbs.simulate.engine import EndlessSwitchingError, Engine
from haptisym.verbs.simulate.entry import Extra, build, check_extras, in_time, same_kind
from haptisym.verbs.simulate.network import (
    MOTION,
    Network,
    Port,
    SignalSum,
    at_rest,
    exact,
    name_of,
)
from haptisym.verbs.simulate.rightmost import Rightmost, clocked_root, rightmost_root
from haptisym.verbs.simulate.statespace import Record
from haptisym.verbs.stability.held import Held, characteristic, held, need_roots
from haptisym.verbs.stability.limitcycles import LimitCycle, cycle_caveats, limit_cycles, linear

_WINDOWS = 6
# Radians between two samples, at the most: beyond pi a sampled oscillation looks like a slower one.
_PER_TURN = 1.5
# Samples of a window, at the most and usually: the singular value decomposition of the Hankel
# matrix grows with their cube.
_MOST = 480
_COUNT = 240
_RANK = 1e-9  # relative: smaller singular values are rounding
_SHARE = 1e-3  # of the largest amplitude at the end of the window: less is no mode of the motion


@dataclass(frozen=True)
class Mode:
    """A mode x = a exp(rate t) cos(omega t + phase) of a motion, with s = rate + j omega in 1/s
    and rad/s, read from that many samples."""

    s: complex
    samples: int

    @property
    def rate(self) -> float:
        """The rate of growth, 1/s; negative where the mode decays."""
        return self.s.real

    @property
    def omega(self) -> float:
        """The frequency at which the mode oscillates, rad/s."""
        return self.s.imag


def slowest(
    record: Record,
    column: int,
    start: float,
    period: float,
    *,
    waving: bool = False,
    turn: float = 0.0,
) -> Mode | None:
    """Return the mode that is left at the end of a record, read from what comes after the share
    ``start`` of it; None where nothing moves.

    ``waving`` : only modes that oscillate count, as a creep that fades as a power of time is none.
    ``period`` : of a clock, s; 0 without one. ``turn`` : a frequency, rad/s, that the samples must
    still resolve.
    """
    last = record.count - 1
    end = float(record.times[last] + record.lengths[last])
    first = start * end
    if period:
        # A sampled loop repeats with its clock: it is linear and does not change with time only
        # from one instant to another that is whole periods later.
        most = int(_PER_TURN / (turn * period)) if turn else _COUNT
        step = period * max(1, min(int((end - first) / (_COUNT * period)), most))
        first = max(first, end - _MOST * step)
    else:
        step = (end - first) / _COUNT
    # Whole multiples of the step, and so of the period: samples at one phase of the clock.
    numbers = np.arange(np.ceil(first / step), np.floor(end / step), dtype=np.float64)
    times = numbers * np.float64(step)
    if len(times) < 8:
        return None
    x = record.at(times, [column])[:, 0]
    if not np.abs(x).max():
        return None
    s, weights = modes(x, step)
    if not len(s):
        return None
    # What is small at the end of the window has decayed, or stands for noise in the pencil.
    last_sizes = np.abs(weights) * np.exp(s.real * step * (len(x) - 1))
    strong = last_sizes > _SHARE * last_sizes.max()
    if waving:
        # Creep outlasts every exponential, so that an oscillation may be small at the end: sizes
        # are compared where the window begins, and slow real exponents, which imitate creep, left
        # out.
        is_large = np.abs(weights) > _SHARE * _SHARE * np.abs(weights).max()
        strong = is_large & (np.abs(s.imag) > np.abs(s.real) / 10)
    if not strong.any():
        return None
    rightmost = max(s[strong], key=lambda y: y.real)
    return Mode(complex(rightmost.real, abs(rightmost.imag)), len(x))


def envelope(record: Record, column: int, start: float) -> tuple[Mode, float]:
    """Return the mean rate at which the largest values rise or fall after the share ``start`` of
    a record, and by how much it varies, 1/s; for motions of so many modes that none can be
    singled out."""
    values = np.abs(record.values[: record.count, :, column])
    times = record.times[: record.count]
    end = float(times[-1])
    edges = np.linspace(start * end, end, _WINDOWS + 1)
    # The logarithm of the largest value of each window over time; its slope is the rate.
    places = np.searchsorted(times, edges)
    sizes = [float(values[a : max(b, a + 1)].max()) for a, b in pairwise(places)]
    steps = np.diff(np.log(np.maximum(sizes, 1e-300))) / (edges[1] - edges[0])
    return Mode(complex(float(steps.mean()), 0), _WINDOWS), float(
        np.abs(steps - steps.mean()).max()
    )


def modes(x: Array, step: float) -> tuple[Array, Array]:
    """Exponents, 1/s, and amplitudes of a sum of exponentials, sampled every ``step`` seconds.

    >>> t = 0.01 * np.arange(200)
    >>> s, _ = modes(np.exp(-0.5 * t) * np.cos(7 * t), 0.01)
    >>> sorted(round(float(y.imag), 6) for y in s), round(float(s[0].real), 6)
    ([-7.0, 7.0], -0.5)
    """
    n = len(x)
    # The pencil's width: from a third of the samples on the exponents vary least with noise.
    width = n // 3
    hankel = np.lib.stride_tricks.sliding_window_view(x, width + 1)
    _, sizes, v = np.linalg.svd(hankel, full_matrices=False)
    # The columns of a Hankel matrix of r exponentials span r dimensions, and shifting it by a
    # sample multiplies each exponential by its z = exp(s step): z are eigenvalues of that shift
    # within the span.
    rank = max(1, int((sizes > _RANK * sizes[0]).sum()))
    basis = v[:rank].T
    z = np.linalg.eigvals(np.linalg.lstsq(basis[:-1], basis[1:], rcond=None)[0])
    # z = 0 is an exponential that is over after one sample, and has no logarithm.
    z = z[np.abs(z) > 0]
    powers = np.vander(z, n, increasing=True).T
    # Columns z^n of growing and decaying motions differ by many powers of ten: scaled alike, least
    # squares loses none of them.
    scale = np.abs(powers).max(axis=0)
    weights = np.linalg.lstsq(powers / scale, x.astype(complex), rcond=None)[0] / scale
    return np.log(z) / step, weights


@dataclass(frozen=True)
class Rattle:
    """A motion that neither dies away nor grows: half its peak-to-peak value, m or rad, and its
    mean frequency, rad/s."""

    amplitude: float
    omega: float


def rattle(time: Array, x: Array) -> tuple[float, float, float | None]:
    """Half the peak-to-peak value of a motion, how that changes along it, and the motion's mean
    frequency, rad/s.

    The change is the logarithm of the second half's size (mean of three windows) over the first
    half's. The frequency is that of upward crossings of a level above the middle that each follow
    one of a level below; None for fewer than twenty of them.

    >>> t = np.linspace(0, 10 * np.pi, 15001)
    >>> size, change, omega = rattle(t, 3 + 2 * np.sin(5 * t))
    >>> f"{size:.4f} {change:.3f} {omega:.4f}"
    '2.0000 0.000 5.0000'
    """
    edges = np.searchsorted(time, np.linspace(time[0], time[-1], _WINDOWS + 1))
    windows = [x[a : max(b, a + 1)] for a, b in pairwise(edges)]
    sizes = np.array([np.ptp(window) / 2 for window in windows])
    first, last = np.maximum((sizes[:3].mean(), sizes[3:].mean()), 1e-300)
    change = float(np.log(last / first))
    size = float(np.ptp(x)) / 2
    # Two levels, as of a trigger with hysteresis: ripple about a single one, of an encoder or a
    # clock, would be counted as crossings.
    above = float(x.min() + x.max()) / 2 + _LEVEL * size
    below = above - 2 * _LEVEL * size
    sides = np.where(x > above, 1, np.where(x < below, -1, 0))
    clear = np.flatnonzero(sides)
    before, after = sides[clear[:-1]], sides[clear[1:]]
    up = clear[1:][(after == 1) & (before == -1)]
    if len(up) < _LEAST_CROSSINGS:
        return size, change, None
    # The sample before each crossing is not above the level: a line between both samples crosses
    # it.
    share = (x[up] - above) / (x[up] - x[up - 1])
    crossings = time[up] - share * (time[up] - time[up - 1])
    omega = float(2 * pi * (len(crossings) - 1) / (crossings[-1] - crossings[0]))
    return size, change, omega


_LEVEL = 0.2  # of the amplitude: how far from the middle a crossing counts
_LEAST_CROSSINGS = 20
# rad/s. Roots above it may belong to the chain itself: the chain is compared with slower ones.
_FAST = 1e3
_NEAR = 1e-6  # relative: how well a mode is read at best


@dataclass(frozen=True)
class Closed:
    """The closed form's prediction: the rightmost root of H_perc(s) + m s^2 + b s + k, proven where
    ``root.certified``.

    With a clock: ln z/T of the largest root z of the loop through controller, hold and what moves.
    Friction is in neither.
    """

    root: Rightmost

    @property
    def s(self) -> complex:
        """The root."""
        return self.root.s

    @property
    def rate(self) -> float:
        """The real part, 1/s; where it is positive the motion grows."""
        return self.root.s.real

    @property
    def omega(self) -> float:
        """The imaginary part, rad/s."""
        return self.root.s.imag

    @property
    def chain(self) -> float | None:
        """The real part, 1/s, to which infinitely many roots tend, of a neutral system; None
        where there is no such chain or it is not computed."""
        return self.root.function.chain if self.root.function else None

    @property
    def is_endless(self) -> bool:
        """Whether a chain of infinitely many roots lies right of all slow roots, or ends there:
        then no single one of them lasts longest."""
        chain = self.chain
        slow = [x.real for x in self.root.others if abs(x) < _FAST]
        return chain is not None and chain > max(slow, default=-inf) - _NEAR


@dataclass(frozen=True, eq=False, repr=False)
class Release(Answer):
    """A display that a hand held at ``displacement`` and let go. ``hand_motion`` and ``force`` over
    ``time``, s.

    ``fitted`` : what lasts longest in the motion, None where nothing is left to read; ``error`` its
    estimated error, 1/s.
    ``closed`` : the closed form's, None where it has no root, or that of a sampled loop is not
    known. ``stopped`` : why the run ended early.
    ``approximate`` : why the closed form is not what was simulated; empty where it is. ``held`` :
    the certified verdict.
    """

    _schema: ClassVar[str] = "haptisym.release/1"
    _page: ClassVar[str] = "haptisym.pages.simulate:page_release"
    _figure: ClassVar[str] = "haptisym.figures.simulate:RELEASE"

    scene: Scene
    hand: Hand
    displacement: float
    time: Array
    hand_motion: Array
    force: Array
    fitted: Mode | None
    error: float
    closed: Closed | None
    stopped: str
    built: tuple[str, ...]
    approximate: str
    held: Held
    rattle: Rattle | None = None
    """The motion that neither grows nor decays, with an encoder, friction or a limit of the
    force; None where there is none."""
    extras: tuple[Extra, ...] = ()
    limit_cycles: tuple[LimitCycle, ...] | None = ()
    """Those that the describing function of the one element that is not linear makes possible;
    estimated. None where they are not known."""

    def _line(self) -> str:
        verdict = (
            "rattles"
            if self.rattle
            else {True: "grows", False: "dies away", None: "is left open"}[self.grows]
        )
        return f"{titled(self.scene.title)} in {self.hand.name}, let go: {verdict}"

    @property
    def certified(self) -> bool:
        """False: what is read from a simulation is estimated."""
        return False

    @property
    def settled(self) -> bool:
        """Whether neither the motion nor its sign contradicts the closed form; True where there
        is nothing to compare."""
        return self.agrees is not False and self.sign_agrees is not False

    @property
    def sign_agrees(self) -> bool | None:
        """Whether the motion grows exactly if the display is not stable in this hand; None where
        either is open."""
        # A chain that ends near the axis crosses it, if at all, at frequencies far above those that
        # a release excites: the run cannot show the sign.
        near = self.held.roots is not None and self.held.roots.chain is RootChain.NEAR
        if self.grows is None or self.held.stable is None or near or self.rattle:
            return None
        agrees = self.grows is not self.held.stable
        # Friction and limits of the force may hold what the linear loop would let grow: no
        # contradiction.
        return None if self.approximate and not agrees else agrees

    @property
    def unit(self) -> str:
        """The unit of the displacement, m or rad."""
        return "rad" if self.scene.motion is Kind.ROTATION else "m"

    @property
    def grows(self) -> bool | None:
        """Whether the simulated motion grows; None where neither is
        clear."""
        if self.fitted is None:
            return False if self.stopped == "come to rest" or self.rattle else None
        return None if abs(self.fitted.rate) <= self.error else self.fitted.rate > 0

    @property
    def is_envelope(self) -> bool:
        """Whether what was read is the rate of the largest values: of a chain of infinitely many
        roots none lasts longest."""
        return self.closed is not None and self.closed.is_endless

    @property
    def agrees(self) -> bool | None:
        """Whether rate and frequency are the closed form's; None where there is none to compare
        with, or nothing to read.

        Of a chain of infinitely many roots it is the sign of the rate that is compared, where it is
        clear of 0.
        """
        if self.closed is None or self.fitted is None or self.approximate:
            return None
        if self.is_envelope:
            chain = self.closed.chain or 0.0
            return (
                self.grows == (chain > 0) if abs(chain) > _NEAR and self.grows is not None else None
            )
        # An error e of the samples moves an n-fold root by about e^(1/n): so coarse is what can be
        # read of roots that coincide.
        near = _NEAR ** (1 / self.closed.root.order)
        return bool(
            abs(self.closed.s - self.fitted.s) <= 3 * self.error + near * abs(self.closed.s)
        )

    def to_csv(self) -> str:
        """The run in time as a table, units in its header."""
        return in_time(self.scene, self.time, {"": (self.hand_motion, self.force)})

    def _body(self) -> dict[str, Any]:
        fitted = self.fitted and {
            "rate": self.fitted.rate,
            "omega": self.fitted.omega,
            "error": self.error,
        }
        return {
            "hand": {
                "name": self.hand.name,
                **{p.key: float(p.value) for p in self.hand.parameters},
            },
            "displacement": self.displacement,
            "time": [0.0, float(self.time[-1])],
            "samples": len(self.time),
            "built": list(self.built),
            "stopped": self.stopped or None,
            "grows": self.grows,
            "simulated": fitted,
            "rattle": self.rattle
            and {"amplitude": self.rattle.amplitude, "frequency": self.rattle.omega},
            **({"limit_cycles": [x.row() for x in self.limit_cycles]} if self.limit_cycles else {}),
            "closed": self._closed(),
            "held": self.held.stable,
            "agrees": self.agrees,
            **({"approximate": self.approximate} if self.approximate else {}),
            **({"caveats": list(caveats)} if (caveats := self.caveats) else {}),
        }

    @property
    def caveats(self) -> tuple[str, ...]:
        """Sentences on limit cycles that are not known."""
        return cycle_caveats(self.scene, {self.hand.name: self.limit_cycles}, released=True)

    def _closed(self) -> dict[str, Any] | None:
        if self.closed is None:
            return None
        rate, omega = self.closed.root.digits()
        root = {"rate": self.closed.rate, "omega": self.closed.omega, "digits": [rate, omega]}
        return {**root, "chain": self.closed.chain, "certified": self.closed.root.certified}


_SETTLED = 16.0  # powers of e by which a motion falls or grows in a run
_PERIODS = (6, 80)  # of the closed form's oscillation: the shortest and the longest run
_GROWN, _GONE = 1e7, 1e-10  # times the displacement: where a run may end
_STEP = 0.9
_MOST_STEPS = 300_000
_CHUNKS = 60
_NOTHING = 1e-25  # N: what the limit of statics leaves of no force
_CLEAR = 0.02  # relative: readings further apart are none
_HIGHEST = 1e4  # rad/s: what is faster is not what a hand is let go with
# Times that a run may be doubled while a motion that is not linear neither settles nor grows: it
# has no rate from which its duration would follow.
_LONGER = 4
_STEADY = 0.02  # change of the amplitude, as a logarithm, up to which a motion stays as it is
_LINEAR = 0.2  # of the change that the linear loop's motion would have
_BROAD = 10  # times the scale: the frequencies at which a release moves anything


def release(
    scene: Scene | str | Path,
    displacement: Number,
    hand: str | Hand | None = None,
    *,
    duration: Number | None = None,
    extras: Sequence[Extra] = (),
    progress: Callable[[float, float], None] | None = None,
    limit: float | None = SECONDS,
) -> Release:
    """Let a display go that a hand has held displaced: at which rate does the motion decay or grow,
    or does it rattle?

    ``displacement`` : m or rad, or with a unit. ``hand`` : one of the scene, or one that the
    package ships, by name, or a
    ``Hand``; the scene's if it has one and none is given. ``duration`` : s, or with a unit; as long
    as a verdict needs if not given. ``extras`` : encoder quantisation or force saturation.
    ``limit`` : seconds of processor time that it may take, LimitError after them; None for none.
    Proven: ``held``, the verdict on the linear loop. What is read from the motion,
    ``rattle`` with it, is computed. Raises SceneError where nothing holds the display (no static
    stiffness), and for what cannot be simulated.

    >>> from haptisym.model.scenefile import load_scene
    >>> found = release(load_scene("delayed-spring"), "1 cm", Hand("light", m="0.5 kg", b="3.3 N*s/m"))
    >>> found.grows, found.agrees, f"{found.fitted.rate:.6f}", f"{found.closed.rate:.6f}"
    (True, True, '0.145472', '0.145472')
    """
    scene = as_scene(scene)
    check_extras(extras)
    scene.knobs.need_numbers()
    hand = _the_hand(scene, hand)
    size = positive("release", displacement, Dimension.DISPLACEMENT)
    same_kind("release", quantity(displacement, Dimension.DISPLACEMENT).motion, scene)
    same_kind(f"hand {hand.name}", hand.motion, scene)
    length = None if duration is None else positive("duration", duration, Dimension.TIME)
    with ONE_THREAD, limited(limit):
        try:
            return _Run(scene, hand, size, closed_form(scene, hand), extras).go(length, progress)
        except EndlessSwitchingError as error:
            if not held(linear(scene), hand).shakes:
                raise
            # A motion that grows crosses ever more steps in each period.
            why = (
                f": the linear model is unstable in {hand.name} (haptisym stability), the motion "
                "grows; simulate a shorter time (--duration)"
            )
            raise EndlessSwitchingError(error.args[0], why) from None


def _the_hand(scene: Scene, given: str | Hand | None) -> Hand:
    if given is not None:
        return chosen_hand(scene, given)
    if len(scene.hands) == 1:
        return scene.hands[0]
    several = (
        f"which one of {', '.join(x.name for x in scene.hands)}"
        if scene.hands
        else "and the scene has none"
    )
    raise SceneError(f"a release test needs a hand, {several}: {how_to_give()}")


def closed_form(scene: Scene, hand: Hand) -> Closed | None:
    """The rightmost root of H_perc + m s^2 + b s + k, or that of the loop with its clock; None
    where there is none to find.

    It is that of the loop without what is not linear: friction and play have j among their numbers,
    and no roots in s; an encoder, a dead zone or a limit has as many loops as amplitudes.
    """
    # Left out before the loop is made: with j in a coefficient the roots would not be conjugate.
    scene = linear(scene)
    if clocks(scene):
        sampled = clocked_root(scene, hand)
        return None if sampled is None else Closed(sampled)
    perceived = scene.closed.perc
    ring = ring_of(perceived)
    top = characteristic(perceived, ring.convert(hand.Z))
    need_roots(top, ring)
    # What H_perc = N/D shares with its denominator at s = 0 cancels, and is no root of the loop.
    shared = min(order_at_0(top, ring), order_at_0(perceived.denominator, ring))
    root = rightmost_root(top, ring, at_least(shared))
    return None if root is None else Closed(root)


class _Run:
    """A release test that is being simulated: network, engine, and how its motion is read."""

    def __init__(
        self,
        scene: Scene,
        hand: Hand,
        size: float,
        closed: Closed | None,
        extras: Sequence[Extra] = (),
    ) -> None:
        self.scene, self.hand, self.size, self.closed, self.extras = (
            scene,
            hand,
            size,
            closed,
            tuple(extras),
        )
        self.periods = [float(x) for x in clocks(scene)]
        # A root of a chain says nothing of how fast the release moves, and one that is too fast
        # would only make the steps short: then the band alone does.
        modulus = abs(closed.s) if closed and closed.chain is None else 0.0
        self.scale = max(modulus if modulus < _HIGHEST else 0.0, float(scene.band[1]) / 3)
        """The frequency, rad/s, on which steps and the fading of the force are laid out."""
        self.lead = self._lead()
        # Frequencies for which fractional derivatives are built: slow creep to fast ripple.
        span = (1e-3 * self.scale, max(30 * self.scale, 3 * float(scene.band[1])))
        self.net = Network(span)
        self.port = _held(self.net, scene, hand, self.extras)
        self.linear = not self.extras and linear(scene) == scene
        rest = self._rest(span)
        force = rest[MOTION]
        if abs(force) < _NOTHING:
            raise SceneError(
                "a release test needs a static stiffness, of the display or of the hand"
            )
        letting_go = LettingGo(force, 0.5 / self.scale, span)
        outputs = [(name_of(self.port.X), 0), (name_of(self.port.F), 0)]
        try:
            self.engine = Engine(self.net, letting_go, outputs, _STEP / (3 * self.scale), rest)
        except SceneError as error:
            # Raised by the engine without a word of the hand, which is what made the equations so.
            raise SceneError(
                f"with the hand {hand.name} there is no motion in time: {error}"
            ) from None

    def _lead(self) -> complex:
        """Return the exponent, 1/s, that is expected to last longest: only the duration of a run
        follows from it."""
        if self.closed is None:
            return complex(0, self.scale)
        low = [x for x in self.closed.root.others if abs(x) < _BROAD * self.scale]
        return low[0] if low else complex(self.closed.chain or 0, self.scale)

    def _rest(self, span: tuple[float, float]) -> dict[str, float]:
        """Return every signal while the display is held displaced; the force that holds it
        replaces the prescribed motion."""
        net = Network(span)
        port = build(net, self.scene, self.extras)[-1]
        net.equal(port.X, SignalSum.of(MOTION))
        signals = at_rest(net, self.size)
        # At rest of the hand's dynamics only its spring acts.
        force = signals[name_of(port.F)] + float(self.hand.k.value) * self.size
        return {**signals, MOTION: force}

    def go(self, length: float | None, progress: Callable[[float, float], None] | None) -> Release:
        """Simulate for ``length`` seconds, or as long as a verdict needs, and read the motion."""
        most = _MOST_STEPS * self.engine.longest
        until, stopped = min(length or self._duration(), most), ""
        for _ in range(1 if length or self.linear else 1 + _LONGER):
            stopped = self._advanced(until, length is None, progress)
            if stopped or until >= most or self._stays() is not None:
                break
            until = min(2 * until, most)
        return self._result(stopped)

    def _advanced(
        self,
        until: float,
        may_end: bool,  # noqa: FBT001
        progress: Callable[[float, float], None] | None,
    ) -> str:
        """Simulate up to a time, s; return why the run ended before, or an empty text."""
        for end in np.linspace(self.engine.t, until, _CHUNKS + 1)[1:]:
            try:
                self.engine.advance(
                    float(end), None if progress is None else lambda t: progress(t, until)
                )
            except SceneError as error:
                # Overflow is an answer here: the motion grows. What was recorded is kept.
                if "without bound" not in str(error):
                    raise
                return "grown beyond all measure"
            if may_end and (stopped := self._ended(float(end), until)):
                return stopped
        return ""

    def _stays(self) -> Rattle | None:
        """Return the motion of the run's last half where it keeps its size although the linear
        loop's would not; else None."""
        x, time = (
            y.ravel()
            for y in (self.engine.signal(name_of(self.port.X)), self.engine.record.instants)
        )
        half = int(np.searchsorted(time, time[-1] / 2))
        size, change, omega = rattle(time[half:], x[half:])
        # The change is measured between the middles of the run's third and fourth quarter. So much
        # would the linear loop's motion grow or fall in that time; a rattle changes by far less.
        linear = abs(self.lead.real) * time[-1] / 4 or inf
        if (
            self.linear
            or omega is None
            or size < _GONE * self.size
            or abs(change) > min(_STEADY, _LINEAR * linear)
        ):
            return None
        return Rattle(size, omega)

    def _duration(self) -> float:
        """Return how long a verdict needs, s."""
        s = self.lead
        # Heavily damped motions have no period to speak of: a fifth of |s| stands for the
        # frequency.
        period = 2 * pi / max(abs(s.imag), 0.2 * abs(s), 1e-9)
        wanted = _SETTLED / max(abs(s.real), 1e-9)
        return min(max(wanted, _PERIODS[0] * period), _PERIODS[1] * period)

    def _ended(self, end: float, until: float) -> str:
        """Return why the run may end now, or an empty text."""
        record = self.engine.record
        ending = self.engine.signal(name_of(self.port.X))[-max(8, record.count // 20) :]
        last = np.abs(ending).max()
        if last > _GROWN * self.size and end > 0.2 * until:
            return "grown ten million times"
        # A linear motion rests at 0. Within a step of an encoder, or with friction, it may rest
        # elsewhere: then the motion left counts, not the place.
        resting = last if self.linear else np.ptp(ending)
        return "come to rest" if resting < _GONE * self.size else ""

    def _result(self, stopped: str) -> Release:
        engine = self.engine
        time = engine.record.instants.ravel()
        x, force = (engine.signal(name_of(y)).ravel() for y in (self.port.X, self.port.F))
        fitted, error = self._read(x)
        if np.ptp(x[-max(8, len(x) // 20) :]) < _GONE * self.size and not stopped:
            stopped, fitted = "come to rest", None
        # What rests, or rattles, decays at no rate that could be compared with the closed form's.
        stays = None if stopped else self._stays()
        if stays or (stopped == "come to rest" and not self.linear):
            fitted = None
        return Release(
            self.scene,
            self.hand,
            self.size,
            time,
            x,
            force,
            fitted,
            error,
            self.closed,
            stopped,
            tuple(self.net.built),
            self._why(),
            held(linear(self.scene), self.hand),
            stays,
            self.extras,
            limit_cycles(self.scene, self.hand),
        )

    def _read(self, x: Array) -> tuple[Mode | None, float]:
        """Return the mode that lasts longest and how far two readings of it are apart, 1/s.
        Where they do not agree: None and infinity of a linear loop, of another one the envelope."""
        record, column = self.engine.record, self.engine.column(name_of(self.port.X))
        if self.closed and self.closed.is_endless:
            return envelope(record, column, 0.3)
        period, waving = max(self.periods, default=0.0), bool(self.net.fractional)
        turn = abs(self.lead.imag)
        # Two windows, of which the later begins later: what decays faster is still in the first
        # one, so that their difference estimates the error.
        one, other = (
            slowest(record, column, part, period, waving=waving, turn=turn) for part in (0.35, 0.5)
        )
        if one is None or other is None or abs(one.s - other.s) > _CLEAR * abs(other.s):
            return (None, inf) if self.linear else envelope(record, column, 0.5)
        return other, float(abs(one.s - other.s))

    def _why(self) -> str:
        """Why the closed form is not what was simulated; empty where it is."""
        if self.extras:
            return "quantisation and saturation are in no closed form"
        described = [x.name for x in self.scene.effects if x.model in DESCRIBED]
        if described:
            return (
                f"{', '.join(described)}, for which a closed form has a describing function of "
                f"one amplitude"
            )
        return (
            "a sampled loop that has no closed form here"
            if self.periods and self.closed is None
            else ""
        )


def _held(net: Network, scene: Scene, hand: Hand, extras: Sequence[Extra]) -> Port:
    """The display with the hand on it, and a force that holds both: F + m x'' + b x' + k x = the
    force."""
    port = build(net, scene, extras)[-1]
    hand_force = port.X.through(*(exact(p.value) for p in (hand.k, hand.b, hand.m)))
    net.equal(port.F + hand_force, SignalSum.of(MOTION))
    return port
