"""A network that is simulated: steps from event to event, with clocks, delay lines, friction,
saturation and quantisers.

Between events the equations are linear, and each step is exact for them. Sampling instants, and
what jumps become behind delays, are known beforehand; reversals of a sliding velocity, break-away,
saturation and encoder steps are roots of a step's polynomials, and are hit exactly. While friction
sticks, "v = 0" takes the place of its law, and the force that holds it is watched.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, reduce
from heapq import heappop, heappush
from itertools import combinations
from typing import TypeAlias

import numpy as np
from flint import fmpq

from haptisym.kernel.budget import tick
from haptisym.kernel.errors import SceneError
from haptisym.model.motions import Motion
from haptisym.programs.values import Array
from haptisym.verbs.simulate.network import MOTION, Exact, Network, Step, Switch, at_rest, float_of
from haptisym.verbs.simulate.statespace import (
    NODES,
    Drive,
    Linear,
    Reading,
    Record,
    at_end,
    linear_systems,
    series,
)

# Of break points that a jump leaves behind delay lines: each passage through a filter smooths it by
# one derivative, and without an end they would multiply.
_GENERATIONS = 4
Systems: TypeAlias = dict[frozenset[int], Linear | None]


@dataclass(frozen=True)
class Guard:
    """A function of time, sign * signal - bound, that is >= 0 as long as an element stays as it
    is."""

    element: Switch | Step
    reading: Reading
    sign: int
    bound: float


def falls(course: Array, bad: int) -> float:
    """Return where on the step, from 0 to 1, a guard falls through zero before the node ``bad``."""
    from scipy.optimize import brentq  # SciPy is an extra: asked for where it is needed

    coefficients = series(course[:, None])[::-1, 0].tolist()
    places = [0.0, *NODES.tolist(), 1.0]

    def value(place: float) -> float:
        return float(reduce(lambda total, x: total * (2 * place - 1) + x, coefficients))

    # The nearest place before at which it is positive brackets the root. There is none where the
    # guard is 0 at the beginning of the step already, as just after its own event.
    start = next((i for i in range(bad, -1, -1) if value(places[i]) > 0), None)
    if start is None:
        return 0.0
    return float(brentq(value, places[start], places[bad + 1], xtol=1e-15))


def guards(
    net: Network, modes: Sequence[int], held: Mapping[str, float], resting: Container[int] = ()
) -> list[Guard]:
    """Return the guards of what ends the present state of each element: ``modes`` of the switches,
    and the values that are ``held``.

    A friction that is ``resting`` has none: it gives no force until the prescribed motion goes on.
    """
    watched = []
    for i, (switch, mode) in enumerate(zip(net.switches, modes, strict=True)):
        if i in resting:
            continue
        # Closed, its force must stay between the limits; open, its driver must keep its sign.
        if mode == 0:
            watched += [Guard(switch, (switch.target, 0), sign, -switch.limit) for sign in (1, -1)]
        else:
            watched.append(Guard(switch, (switch.driver, 0), mode, switch.offset))
    for step in net.steps:
        middle, half = held[step.target], step.resolution / 2
        watched += [Guard(step, (step.source, 0), sign, sign * middle - half) for sign in (1, -1)]
    return watched


def first_event(
    watched: Sequence[Guard], values: Array, column: Callable[[str, int], int], motion: Motion
) -> tuple[int, float, Guard] | None:
    """The first guard that falls below zero in a chunk of steps: in which of them, and where on it,
    from 0 to 1.

    ``values`` : of all readings at the nodes of each step, in the ``column`` of each.
    """
    if not watched:
        return None
    signs, bounds = np.array([(x.sign, x.bound) for x in watched], dtype=float).T
    course = signs * values[:, :, [column(*x.reading) for x in watched]] - bounds
    course = np.concatenate([course, at_end(course)[:, None]], axis=1)
    spans = [motion.span[1] if isinstance(x.element, Switch) else 1.0 for x in watched]
    # What a guard may be below zero by rounding: relative to its bound, to its values in this
    # chunk, and to the motion, as a velocity that starts from rest has no size of its own yet.
    scale = 1e-12 * motion.amplitude * np.array(spans)
    sizes = [np.abs(bounds), np.abs(course).max(axis=(0, 1)), scale]
    tolerance = 1e-12 * reduce(np.maximum, sizes)
    bad = course < -tolerance
    if not bad.any():
        return None
    step = int(bad.any(axis=(1, 2)).argmax())
    # Several guards may fall on the same step: the earliest root counts, the others are looked at
    # again after it, with the equations that hold then.
    fallen = np.flatnonzero(bad[step].any(axis=0)).tolist()
    place, i = min((falls(course[step, :-1, i], int(bad[step, :, i].argmax())), i) for i in fallen)
    return step, place, watched[i]


class Breaks:
    """Instants at which what jumped once comes out of a delay line; ``lags`` : of the lines, s."""

    def __init__(self, lags: Sequence[float], known: Iterable[float] = ()) -> None:
        self.lags = lags
        self.due: list[float] = []
        for t in known:
            heappush(self.due, t)
            self.after(t)

    def after(self, t: float) -> None:
        """Add the instants at which a jump at t comes out of the delay lines."""
        reached = {t}
        for _ in range(_GENERATIONS):
            reached = {t + lag for t in reached for lag in self.lags}
            for t in reached:
                heappush(self.due, t)

    def next(self, t: float) -> list[float]:
        """Return the first instant after t, or an empty list; drop those before."""
        while self.due and self.due[0] <= t:
            heappop(self.due)
        return self.due[:1]


def check_frictions(net: Network, systems: Systems) -> None:
    """Raise SceneError where two frictions act on one velocity: while it is 0 no equation tells
    what each of them holds."""
    # Each alone can stick and both together cannot: they hold the same velocity.
    for pair in combinations([i for i, s in enumerate(net.switches) if not s.offset], 2):
        if systems[frozenset(pair)] is None and all(systems[frozenset([i])] for i in pair):
            names = " and ".join(net.switches[i].name for i in pair)
            raise SceneError(
                f"{names} act on the same part: give one friction with the force of both"
            )


def check_jumps(net: Network, systems: Systems) -> None:
    """Raise SceneError where the derivative of something that jumps is needed."""
    allowed = {h.target: 0 for h in net.holds} | {s.target: 0 for s in net.steps}
    # saturation has kinks alone; friction has too where it acts on a spring and so cannot jump
    allowed |= {s.target: int(bool(s.offset) or _moves_itself(s, systems)) for s in net.switches}
    for system in systems.values():
        for drive in system.drives if system else ():
            # An input that is no element's has no entry, and is as smooth as needed.
            is_rougher = drive[1] > allowed.get(drive[0].name, drive[1])
            if is_rougher and system and _acts(system, drive, net):
                element = next(e for e in net.elements if e.target == drive[0].name)
                raise SceneError(
                    f"{element.name}: its output jumps, and the scene differentiates it: add "
                    f"a filter after it, "
                    "or render a filtered velocity ([rendered])"
                )


def check_derivatives(motion: Motion, systems: Systems) -> None:
    """Raise SceneError where the scene needs more derivatives of the motion than it has."""
    present = [system for system in systems.values() if system]
    needed = [
        k
        for x in present
        for drive in x.drives
        for k in [drive[1]]
        if drive[0].name == MOTION and _acts(x, drive)
    ]
    if max(needed, default=0) > motion.smoothness:
        raise SceneError(
            f"{motion.name}: the scene needs derivative {max(needed)} of the motion, a "
            f"recording has {motion.smoothness}"
        )


def _moves_itself(switch: Switch, systems: Systems) -> bool:
    """Whether the derivative of a friction force is in the velocity that it acts on: it then
    acts on a spring, and a jump would move that at once."""
    system = systems[frozenset()]
    assert system is not None
    row = system.rows[system.readings.index((switch.driver, 0))]
    places = [
        system.exact.size + i
        for i, (x, k) in enumerate(system.drives)
        if (x.name, k) == (switch.target, 1)
    ]
    return bool(row[places].any())


def _acts(system: Linear, drive: Drive, net: Network | None = None) -> bool:
    """Whether an input's derivative acts on anything but the velocities that only switches look
    at."""
    watched = [(s.driver, k) for s in net.switches for k in (0, 1)] if net else []
    rows = [i for i, reading in enumerate(system.readings) if reading not in watched]
    index = system.drives.index(drive)
    return bool(
        system.rows[rows, system.exact.size + index].any() or system.propagator.N[:, index].any()
    )


_MOST_AT_ONCE = 256
# Steps to the shortest delay, at the most; delays with no such common measure are read between
# steps.
_FINEST = 64
_TINY = 1e-12  # of a step: closer instants are the same one
_ROUNDING = 1e-14  # of the time
_UNBOUNDED = 1e15  # m, N: beyond any display
_MOST_EVENTS_AT_ONCE = 12
_MOST_EVENTS = 100_000


class EndlessSwitchingError(SceneError):
    """An element switches so often that a run does not end; its first argument says which, and
    until when."""


class Engine:
    """A network, a prescribed motion, and everything recorded so far; ``advance`` goes on."""

    def __init__(
        self,
        net: Network,
        motion: Motion,
        readings: Sequence[Reading],
        longest: float,
        rest: Mapping[str, float] | None = None,
    ) -> None:
        if len(net.switches) > 3:
            raise SceneError(
                f"{len(net.switches)} elements with friction or saturation: at most 3 can be "
                f"simulated"
            )
        # Of frictions the acceleration, too: it tells which way a part that comes to rest goes on.
        monitored = [(s.driver, 0) for s in net.switches]
        monitored += [(s.driver, 1) for s in net.switches if s.offset == 0]
        targets = [(s.target, 0) for s in net.switches]
        sources = [
            (name, 0) for name in (*(h.source for h in net.holds), *(q.source for q in net.steps))
        ]
        self.net, self.motion = net, motion
        self.systems = linear_systems(net, [*readings, *monitored, *targets, *sources])
        # 0: closed (stuck, or not saturated); 1 and -1: open, with a force of that sign. A friction
        # that no equations let stick, as the hand moves it, begins open.
        self.modes = [
            0 if s.offset or self.systems[frozenset([i])] is not None else 1
            for i, s in enumerate(net.switches)
        ]
        self.driven = [
            i for i, mode in enumerate(self.modes) if mode and not net.switches[i].offset
        ]
        """Frictions whose velocity is prescribed, so that they cannot stick: where it is exactly 0
        they give no force."""
        self.resting = set(self.driven)
        check_frictions(net, self.systems)
        check_jumps(net, self.systems)
        check_derivatives(motion, self.systems)
        self.held = dict.fromkeys(net.jumps, 0.0)
        self._update_forces()
        self.z = np.zeros(self.system.exact.size)
        self.record = Record(len(self.system.readings))
        self.t, self.samples = 0.0, [0] * len(net.holds)
        self.taken, self.given = (
            [[0.0] * max(len(x.above), len(x.below)) for x in net.holds] for _ in range(2)
        )
        """The samples of each clock and the values that it has held, before the start too."""
        self._lags = [float_of(lag) for lag in self._late]
        self.breaks = Breaks(self._lags, motion.breaks)
        self.longest = self._regular(longest)
        self.stalled, self.events, self.calm = (0.0, 0), 0, _MOST_AT_ONCE
        # The hand has rested at its first position for so long that everything else rests, too. At
        # 0 all is 0.
        position = float(motion.derivatives(np.zeros(1), 0)[0, 0])
        if rest or position:
            self._begin(rest or at_rest(self.net, position))

    def _begin(self, rest: Mapping[str, float]) -> None:
        """Set states, clocks, quantisers and the record's past to a state of rest."""
        for i, switch in enumerate(self.net.switches):
            if switch.offset and abs(rest[switch.driver]) > switch.limit:
                self.modes[i] = 1 if rest[switch.driver] > 0 else -1
        self._update_forces()
        self.record.before = np.array(
            [rest.get(name, 0.0) if k == 0 else 0.0 for name, k in self.system.readings]
        )
        for i, hold in enumerate(self.net.holds):
            # At rest an encoder reads a whole multiple: what is held follows in proportion, as the
            # difference equation is linear.
            sample = hold.read(rest[hold.source])
            share = sample / rest[hold.source] if sample else 0.0
            self.held[hold.target] = rest[hold.target] * share
            self.taken[i] = [sample] * len(self.taken[i])
            self.given[i] = [self.held[hold.target]] * len(self.taken[i])
        for step in self.net.steps:
            self.held[step.target] = step.resolution * round(rest[step.source] / step.resolution)
        keys = list(self.system.exact.columns)
        variables = [rest.get(name, 0.0) if k == 0 else 0.0 for name, k in keys]
        # What comes out of delay lines is still from before the encoders rounded.
        known = {**rest, **self.held}
        inputs = [0.0 if k else (rest if x.lag else known)[x.name] for x, k in self.system.drives]
        chosen = np.array([variables[i] for i in self.system.exact.chosen])
        self.z = chosen - self.system.back @ inputs

    @cached_property
    def _late(self) -> list[Exact]:
        """The delays of everything that is read from the record, s, in order."""
        inputs = {x for system in self.systems.values() if system for x, _ in system.drives}
        return sorted({x.lag for x in inputs if x.lag != 0 and x.name != MOTION})

    def _regular(self, longest: float) -> float:
        """The longest step of a grid on which what is read from delay lines falls on whole steps,
        if there is one.

        Reading between steps would amplify the highest frequencies a little, again and again where
        they come back.
        """
        # The longest time that all delays are whole multiples of: an exact greatest common divisor.
        unit = float_of(reduce(fmpq.gcd, self._late, fmpq(0)))
        usual = min([*self._lags, *(hold.period for hold in self.net.holds)], default=longest)
        base = unit if unit and usual / unit <= _FINEST else usual
        return base / float(np.ceil(base / longest - 1e-9))

    def column(self, name: str, order: int = 0) -> int:
        """Return the column of a signal in the record."""
        return self.system.columns[name, order]

    def signal(self, name: str) -> Array:
        """Return a recorded signal at the nodes of all steps, (steps, nodes)."""
        return self.record.values[: self.record.count, :, self.column(name)]

    @property
    def _tiny(self) -> float:
        """The distance, s, up to which two instants count as one: a share of a step, and more
        than the rounding of a sum of steps."""
        return max(_TINY * self.longest, _ROUNDING * self.t)

    # Going on

    def advance(self, until: float, watch: Callable[[float], None] | None = None) -> None:
        """Simulate up to a time, s; ``watch`` is called with the time that is reached."""
        while self.t < until * (1 - 1e-15):
            tick(self.t, until, "s simulated")
            if watch is not None:
                watch(self.t)
            self._sample()
            h = self.longest
            ends = [until, *self.breaks.next(self.t + self._tiny), *self._next_on_grid()]
            ticks = [n * hold.period for n, hold in zip(self.samples, self.net.holds, strict=True)]
            # Where all sampling instants fall on whole steps, clocks tick within a chunk
            # (``_attempt``) and many steps are taken at once; else a chunk ends at the next tick.
            in_steps = [
                *((x - self.t) / h for x in ticks),
                *(hold.period / h for hold in self.net.holds),
            ]
            if any(abs(x - round(x)) > 1e-9 for x in in_steps):
                ends += ticks
            end = min(ends)
            whole = int((end - self.t) / h + 1e-9)
            h = h if whole else float(f"{end - self.t:.13e}")  # equal steps are recognised as equal
            # no step may read a delay line where it has not been written yet
            chunk = max(
                1, min(whole, self.calm, int(self._lags[0] / h + 1e-9) if self._lags else whole)
            )
            arrived = self.t + chunk * h
            # A sum of many steps drifts by rounding: time is set to the instant that was meant.
            instants = [
                end,
                *(round(arrived / hold.period) * hold.period for hold in self.net.holds),
            ]
            self._take(
                chunk, h, next((x for x in instants if abs(arrived - x) < 1e-9 * h), arrived)
            )

    def _take(self, chunk: int, h: float, end: float) -> None:
        """Take as many of these steps as there are before the next event, and the event."""
        states, values = self._attempt(chunk, h)
        # Whether the prescribed motion goes on, and which way, is read off the first node: with
        # another force of the friction the attempt is made again.
        if self._moves_or_rests(values[0, 0]):
            self._undo(0)
            states, values = self._attempt(chunk, h)
        event = first_event(
            guards(self.net, self.modes, self.held, self.resting), values, self.column, self.motion
        )
        if event is None:
            self._accept(h, values, states[-1], end)
            self.calm = min(2 * self.calm, _MOST_AT_ONCE)
            return
        step, place, guard = event
        self._undo(step)
        # what lies beyond an event is computed in vain: where they are frequent, look less far
        self.calm = max(1, step)
        if step:
            self._accept(h, values[:step], states[step], self.t + step * h)
        # The step is cut at the event. Its polynomials end there, so that none is fitted across a
        # kink.
        if place * h > self._tiny:
            states, values = self._attempt(1, place * h)
            self._accept(place * h, values, states[-1], self.t + place * h)
        self._react(guard)

    def _moves_or_rests(self, now: Array) -> bool:
        """Whether a driven friction begins to slip, or comes to rest, with these readings: by the
        sign of its velocity."""
        before = set(self.resting), tuple(self.modes)
        for i in self.driven:
            velocity = now[self.column(self.net.switches[i].driver)]
            if velocity == 0:
                self.resting.add(i)
            elif i in self.resting:
                self.resting.discard(i)
                self.modes[i] = 1 if velocity > 0 else -1
        self._update_forces()
        return before != (self.resting, tuple(self.modes))

    def _attempt(self, chunk: int, h: float) -> tuple[Array, Array]:
        """Return states at the ends of steps and readings at their nodes; clocks tick on the way
        and must be undone (``_undo``) if the steps are not taken."""
        system, n = self.system, self.system.exact.size
        w = self._inputs(self.t + h * (np.arange(chunk)[:, None] + NODES))
        ends = at_end(w)
        # Before which of the steps each clock ticks. The tick at the beginning of the first one was
        # taken by ``_sample``.
        self.due = []
        for m, hold in zip(self.samples, self.net.holds, strict=True):
            first = max(1, round((m * hold.period - self.t) / h))
            self.due.append(range(first, chunk, max(1, round(hold.period / h))))
        places = [
            (system.columns[hold.source, 0], system.steady[hold.target]) for hold in self.net.holds
        ]

        def change(step: int, z: Array) -> None:
            for i, (due, (source, target)) in enumerate(zip(self.due, places, strict=True)):
                if step in due:
                    row = system.rows[source]
                    value = row[:n] @ z + row[n:] @ ends[step - 1]
                    w[step:, :, target] = ends[step:, target] = self._sampled(i, float(value))

        with np.errstate(over="ignore", invalid="ignore"):  # a loop may grow without bound
            inside, states = system.propagator.march(
                self.z, w, h, change if any(self.due) else None
            )
            return states, system.outputs(inside, w)

    def _undo(self, step: int) -> None:
        """Let no clock have sampled after the beginning of a step of what was attempted."""
        for i, (hold, due) in enumerate(zip(self.net.holds, self.due, strict=True)):
            if undone := sum(k > step for k in due):
                del self.taken[i][-undone:], self.given[i][-undone:]
                self.samples[i] -= undone
                self.held[hold.target] = self.given[i][-1]

    def _accept(self, h: float, values: Array, after: Array, end: float) -> None:
        """Record steps, and go on from the state after them; SceneError where signals grow without
        bound, with what came before recorded."""
        bounded = np.abs(values).max(axis=(1, 2), initial=0.0) <= _UNBOUNDED
        if not bounded.all():
            known = int(bounded.argmin())
            self.record.append(self.t, h, values[:known])
            where = f"overflow at {self.t + (known + 1) * h:.4g} s"
            raise SceneError(
                f"the simulated force grows without bound ({where}): the scene is not stable"
            )
        self.record.append(self.t, h, values)
        # A held value jumps at each tick, and again where it comes out of delay lines.
        ticks = [k for due in self.due for k in due if k <= len(values)] if self._lags else []
        for k in ticks:
            self.breaks.after(self.t + k * h)
        self.z, self.t = after, end

    def _inputs(self, times: Array) -> Array:
        """The inputs of the state equation at given times, (..., drives)."""
        drives = self.system.drives
        w = np.zeros((*times.shape, len(drives)))
        for x in self.system.groups:
            if x.hand:
                waves = self._hand(times - x.lag, max(x.orders))
                for i, k in zip(x.hand, x.orders, strict=True):
                    w[..., i] = waves[k]
            if x.others and x.lag:
                w[..., x.others] = self.record.at(times - x.lag, x.columns)
            elif x.others:
                w[..., x.others] = [
                    0.0 if drives[i][1] else self.held[drives[i][0].name] for i in x.others
                ]
        return w

    def _hand(self, times: Array, order: int) -> Array:
        """Return the prescribed motion and its derivatives; those that it does not have are 0."""
        needed = min(order, self.motion.smoothness)
        waves = self.motion.derivatives(np.maximum(times, 0.0), needed)
        waves[1:] = np.where(times >= 0, waves[1:], 0.0)  # before it begins the hand is at rest
        return np.concatenate([waves, np.zeros((order - needed, *times.shape))])

    # Clocks

    def _sample(self) -> None:
        """Let every clock whose time has come read its source, and hold what it computes of
        that."""
        for i, hold in enumerate(self.net.holds):
            if self.samples[i] * hold.period <= self.t + self._tiny:
                self._sampled(i, self._now(hold.source))
                self.breaks.after(self.t)

    def _sampled(self, index: int, value: float) -> float:
        """Let a clock take a sample; return what it holds from now on."""
        hold, taken, given = self.net.holds[index], self.taken[index], self.given[index]
        taken.append(hold.read(value))
        given.append(hold.computed(taken, given))
        self.samples[index] += 1
        self.held[hold.target] = given[-1]
        return given[-1]

    def _now(self, name: str, order: int = 0) -> float:
        """Return a signal at the present time, which is the end of the last step."""
        if self.record.count == 0:
            return float(self.record.before[self.column(name, order)])
        last = self.record.values[self.record.count - 1, :, self.column(name, order)]
        return float(at_end(last[:, None])[0])

    def _next_on_grid(self) -> list[float]:
        """Return the next instant on the grid of the delay lines after a step that ended beside
        it; else an empty list."""
        place = self.t / self.longest
        return (
            [float(np.ceil(place) * self.longest)]
            if self._lags and abs(place - round(place)) > 1e-9
            else []
        )

    # Switches and quantisers

    def _react(self, guard: Guard) -> None:
        """Change the element whose guard has fallen; SceneError where events do not end."""
        self.events += 1
        if self.events > _MOST_EVENTS:
            raise EndlessSwitchingError(
                f"{guard.element.name}: more than {_MOST_EVENTS} switches before {self.t:.4g} s",
                ": noise that crosses its steps, or a loop that chatters; smooth a recording "
                "(--lowpass), or simulate a shorter time",
            )
        # Events at one instant may follow from each other, but not for ever.
        last, count = self.stalled
        self.stalled = (self.t, count + 1 if self.t - last < self._tiny else 0)
        if self.stalled[1] > _MOST_EVENTS_AT_ONCE:
            raise SceneError(f"{guard.element.name}: it switches endlessly at {self.t:.6g} s")
        if isinstance(guard.element, Step):
            self.held[guard.element.target] += -guard.sign * guard.element.resolution
        else:
            self._switch(self.net.switches.index(guard.element))
        self.breaks.after(self.t)

    def _switch(self, index: int) -> None:
        """Open or close a switch, and carry the state over to the equations that hold then."""
        switch, old = self.net.switches[index], self.modes[index]
        before = self.system
        now = before.everything @ np.concatenate([self.z, self._inputs(np.array(self.t))])
        everything = dict(zip(before.exact.columns, map(float, now), strict=True))
        force = everything.get((switch.target, 0), self.held[switch.target])
        # A closed switch opens at the limit that its force has reached; an open saturation closes;
        # an open friction sticks or slips the other way.
        after_closed = 1 if force > 0 else -1
        self.modes[index] = (
            after_closed if old == 0 else 0 if switch.offset else self._after_slip(index)
        )
        self._update_forces()
        if self.system is not before:
            self.z = self._state_from(everything)

    def _after_slip(self, index: int) -> int:
        """Return the mode after the sliding velocity has reached zero: the other sign if the
        part then slips the other way, else 0, stuck."""
        switch, old = self.net.switches[index], self.modes[index]
        stuck = frozenset(i for i, mode in enumerate(self.modes) if mode == 0 or i == index)
        if self.systems[stuck] is None:
            return -old
        # The velocity or, where the force does not act on that at once, the acceleration. The force
        # that slips the other way differs by -2 old limit: if that reverses the motion, it slips.
        for order in (0, 1):
            column = self.column(switch.driver, order)
            row = self.system.rows[column]
            by_derivative, by_force = (self.system.weight(row, switch.target, k) for k in (1, 0))
            if by_derivative:
                return 0  # the force cannot jump: it moves what it acts on
            if by_force:
                now = float(self.system.outputs(self.z, self._inputs(np.array(self.t)))[column])
                other = now - 2 * old * switch.limit * by_force
                return -old if other * old < 0 else 0
        return -old

    def _state_from(self, everything: dict[Reading, float]) -> Array:
        """Return the state of the present equations when these variables go on without a jump."""
        keys = list(self.system.exact.columns)
        chosen = [
            everything.get(keys[i], self.held.get(keys[i][0], 0.0))
            for i in self.system.exact.chosen
        ]
        result: Array = np.array(chosen) - self.system.back @ self._inputs(np.array(self.t))
        return result

    def _update_forces(self) -> None:
        """Set forces and linear equations to those of the switches' modes; SceneError where the
        equations contradict each other."""
        system = self.systems[frozenset(i for i, mode in enumerate(self.modes) if mode == 0)]
        if system is None:
            names = ", ".join(
                s.name for s, mode in zip(self.net.switches, self.modes, strict=True) if mode == 0
            )
            raise SceneError(f"{names}: they cannot all stick at once")
        self.system = system
        for i, (switch, mode) in enumerate(zip(self.net.switches, self.modes, strict=True)):
            self.held[switch.target] = 0.0 if i in self.resting else mode * switch.limit
