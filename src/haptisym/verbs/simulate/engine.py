"""The simulation itself: from event to event through time.

Between events everything is linear and a chunk of equal steps is taken at once, as long as no step reads a delay line where
it has not been written yet. Events are hit exactly: sampling instants, and whatever a jump becomes after each delay, are
break points known beforehand; the end of stick or slip, of saturation, and the steps of a quantiser are roots of the
polynomials of the step in which they fall.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from functools import cached_property, lru_cache, reduce

import numpy as np

from haptisym.kernel.budget import tick
from haptisym.kernel.errors import SceneError
from haptisym.programs.values import Array
from haptisym.verbs.simulate.descriptor import Drive, Input, Linear, Reading, linear_systems
from haptisym.verbs.simulate.events import (
    Breaks,
    Guard,
    check_derivatives,
    check_jumps,
    common_measure,
    first_event,
    guards,
)
from haptisym.verbs.simulate.motions import Motion
from haptisym.verbs.simulate.network import MOTION, Network, Step
from haptisym.verbs.simulate.propagate import NODES, Record, at_end
from haptisym.verbs.simulate.rest import at_rest

_MOST_AT_ONCE = 256
_FINEST = 64  # steps to the shortest delay; delays with no such common measure are read between steps
_TINY = 1e-12  # of a step: closer instants are the same one
_UNBOUNDED = 1e15  # m, N: beyond any display
_MOST_EVENTS_AT_ONCE = 12
_MOST_EVENTS = 100_000


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
            raise SceneError(f"{len(net.switches)} elements with friction or saturation: at most 3 can be simulated")
        monitored = [(s.driver, 0) for s in net.switches] + [(s.driver, 1) for s in net.switches if s.offset == 0]
        targets = [(s.target, 0) for s in net.switches]
        sources = [(name, 0) for name in (*(h.source for h in net.holds), *(q.source for q in net.steps))]
        self.net, self.motion = net, motion
        self.systems = linear_systems(net, [*readings, *monitored, *targets, *sources])
        self.modes = [
            0 if s.offset or self.systems[frozenset([i])] is not None else 1 for i, s in enumerate(net.switches)
        ]
        self.driven = [i for i, mode in enumerate(self.modes) if mode and not net.switches[i].offset]
        """Frictions whose velocity is prescribed, so that they cannot stick: where it is exactly 0 they give no force."""
        self.resting = set(self.driven)
        check_jumps(net, self.systems)
        check_derivatives(motion, self.systems)
        self.z = np.zeros(self.system.exact.size)
        self.held = dict.fromkeys(net.jumps, 0.0)
        self.record = Record(len(self.system.readings))
        self.t, self.samples = 0.0, [0] * len(net.holds)
        self.breaks = Breaks(self._lags, motion.breaks)
        self.longest = self._regular(longest)
        self.stalled, self.events, self.calm = (0.0, 0), 0, _MOST_AT_ONCE
        self._update_forces()
        position = float(motion.derivatives(np.zeros(1), 0)[0, 0])
        if rest or position:  # the hand has rested at its first position for so long that everything else rests too
            self._begin(rest or at_rest(self.net, position))

    def _begin(self, rest: Mapping[str, float]) -> None:
        self.record.before = np.array([rest.get(name, 0.0) if k == 0 else 0.0 for name, k in self.system.readings])
        for hold in self.net.holds:
            self.held[hold.target] = rest[hold.source]
        for step in self.net.steps:
            self.held[step.target] = step.resolution * round(rest[step.source] / step.resolution)
        everything = {(name, k): rest.get(name, 0.0) if k == 0 else 0.0 for name, k in self.system.exact.columns}
        keys = list(self.system.exact.columns)
        known = {**rest, **self.held}
        inputs = [0.0 if k else (rest if x.lag else known)[x.name] for x, k in self.system.drives]
        self.z = np.array([everything[keys[i]] for i in self.system.exact.chosen]) - self.system.back @ inputs

    @property
    def system(self) -> Linear:
        """The linear equations while the switches are as they are; SceneError where they contradict each other."""
        found = self.systems[frozenset(i for i, mode in enumerate(self.modes) if mode == 0)]
        if found is None:
            names = ", ".join(s.name for s, mode in zip(self.net.switches, self.modes, strict=True) if mode == 0)
            raise SceneError(f"{names}: they cannot stick all at once; this cannot be simulated")
        return found

    @cached_property
    def _lags(self) -> tuple[float, ...]:
        """The delays of everything that is read from the record, s."""
        return tuple(sorted({int(x.lag.p) / int(x.lag.q) for x in self._late}))

    @cached_property
    def _late(self) -> set[Input]:
        """What is read from the record."""
        inputs = {x for system in self.systems.values() if system for x, _ in system.drives}
        return {x for x in inputs if x.lag != 0 and x.name != MOTION}

    def _regular(self, longest: float) -> float:
        """The longest step of a grid on which what is read from delay lines falls on whole steps, if there is one.

        Reading between steps would amplify the highest frequencies a little, again and again where they come back.
        """
        lags = [Fraction(int(x.lag.p), int(x.lag.q)) for x in self._late]
        unit = reduce(common_measure, lags) if lags else None
        usual = min([*self._lags, *(hold.period for hold in self.net.holds)], default=longest)
        base = float(unit) if unit is not None and usual / float(unit) <= _FINEST else usual
        return base / float(np.ceil(base / longest - 1e-9))

    def column(self, name: str, order: int = 0) -> int:
        """Where a signal is in the record."""
        return self.system.readings.index((name, order))

    def signal(self, name: str) -> Array:
        """A recorded signal at the nodes of all steps."""
        return self.record.values[: self.record.count, :, self.column(name)]

    # Going on

    def advance(self, until: float, watch: Callable[[float], None] | None = None) -> None:
        """Simulate up to a time, s; ``watch`` is called with the time that is reached."""
        while self.t < until * (1 - 1e-15):
            tick(self.t, until, "s simulated")
            if watch is not None:
                watch(self.t)
            self._sample()
            ticks = (n * hold.period for n, hold in zip(self.samples, self.net.holds, strict=True))
            end = min([until, *ticks, *self.breaks.next(self.t + _TINY * self.longest), *self._next_on_grid()])
            whole = int((end - self.t) / self.longest + 1e-9)
            h = self.longest if whole else float(f"{end - self.t:.13e}")  # equal steps are recognised as equal
            # no step may read a delay line where it has not been written yet
            chunk = max(1, min(whole, self.calm, int(self._lags[0] / h + 1e-9) if self._lags else whole))
            arrived = self.t + chunk * h
            self._take(chunk, h, end if abs(arrived - end) < _TINY * h else arrived)

    def _take(self, chunk: int, h: float, end: float) -> None:
        w, after, values = self._attempt(chunk, h)
        if self._moves_or_rests(values[0, 0]):
            w, after, values = self._attempt(chunk, h)
        event = first_event(guards(self.net, self.modes, self.held, self.resting), values, self.column, self.motion)
        if event is None:
            self._accept(h, values, after, end)
            self.calm = min(2 * self.calm, _MOST_AT_ONCE)
            return
        step, place, guard = event
        self.calm = max(
            1, step
        )  # what lies beyond an event is computed in vain: where they are frequent, look less far
        if step:
            _, after = self.system.propagator.march(self.z, w[:step], h)
            self._accept(h, values[:step], after, self.t + step * h)
        if place * h > _TINY * self.longest:
            _, after, values = self._attempt(1, place * h)
            self._accept(place * h, values, after, self.t + place * h)
        self._react(guard)

    def _moves_or_rests(self, now: Array) -> bool:
        """Whether a driven friction begins to slip, or comes to rest, with these readings: by the sign of its velocity."""
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

    def _attempt(self, chunk: int, h: float) -> tuple[Array, Array, Array]:
        times = self.t + h * (np.arange(chunk)[:, None] + NODES)
        w = self._inputs(times)
        inside, after = self.system.propagator.march(self.z, w, h)
        return w, after, self.system.outputs(inside, w)

    def _accept(self, h: float, values: Array, after: Array, end: float) -> None:
        if not np.isfinite(values).all() or np.abs(values).max(initial=0.0) > _UNBOUNDED:
            raise SceneError(
                f"the simulated force grows without bound (beyond all measure at {end:.4g} s): it is not stable"
            )
        self.record.append(self.t, h, values)
        self.z, self.t = after, end

    def _inputs(self, times: Array) -> Array:
        """The inputs of the state equation at given times, (..., drives)."""
        drives = self.system.drives
        w = np.zeros((*times.shape, len(drives)))
        for lag, members in self._by_lag(drives).items():
            hand = [i for i in members if drives[i][0].name == MOTION]
            if hand:
                waves = self._hand(times - lag, max(drives[i][1] for i in hand))
                for i in hand:
                    w[..., i] = waves[drives[i][1]]
            others = [i for i in members if drives[i][0].name != MOTION]
            if others and lag:
                w[..., others] = self.record.at(
                    times - lag, [self.column(drives[i][0].name, drives[i][1]) for i in others]
                )
            elif others:
                w[..., others] = [0.0 if drives[i][1] else self.held[drives[i][0].name] for i in others]
        return w

    @lru_cache(maxsize=16)  # noqa: B019 - an engine lives as long as its simulation
    def _by_lag(self, drives: tuple[Drive, ...]) -> dict[float, list[int]]:
        """The inputs in groups that are late by as many seconds."""
        found: dict[float, list[int]] = {}
        for i, (channel, _) in enumerate(drives):
            found.setdefault(int(channel.lag.p) / int(channel.lag.q), []).append(i)
        return found

    def _hand(self, times: Array, order: int) -> Array:
        needed = min(order, self.motion.smoothness)
        waves = self.motion.derivatives(np.maximum(times, 0.0), needed)
        waves[1:] = np.where(times >= 0, waves[1:], 0.0)  # before it begins the hand is at rest
        return np.concatenate([waves, np.zeros((order - needed, *times.shape))])

    # Clocks

    def _sample(self) -> None:
        """Let every clock whose time has come read its source, and hold that."""
        for i, hold in enumerate(self.net.holds):
            if self.samples[i] * hold.period <= self.t + _TINY * self.longest:
                self.held[hold.target] = self._now(hold.source)
                self.samples[i] += 1
                self.breaks.after(self.t)

    def _now(self, name: str, order: int = 0) -> float:
        if self.record.count == 0:
            return float(self.record.before[self.column(name, order)])
        last = self.record.values[self.record.count - 1, :, self.column(name, order)]
        return float(at_end(last[:, None])[0])

    def _next_on_grid(self) -> list[float]:
        """Back to the grid of the delay lines, after a step that ended beside it."""
        place = self.t / self.longest
        return [float(np.ceil(place) * self.longest)] if self._lags and abs(place - round(place)) > 1e-9 else []

    # Switches and quantisers

    def _react(self, guard: Guard) -> None:
        self.events += 1
        if self.events > _MOST_EVENTS:
            raise SceneError(
                f"{guard.element.name}: more than {_MOST_EVENTS} switches before {self.t:.4g} s: noise that crosses its "
                "steps, or a loop that chatters; smooth a recording (--lowpass), or simulate a shorter time"
            )
        at, count = self.stalled
        self.stalled = (self.t, count + 1 if self.t - at < _TINY * self.longest else 0)
        if self.stalled[1] > _MOST_EVENTS_AT_ONCE:
            raise SceneError(f"{guard.element.name}: it switches endlessly at {self.t:.6g} s; this cannot be simulated")
        if isinstance(guard.element, Step):
            self.held[guard.element.target] += -guard.sign * guard.element.resolution
        else:
            self._switch(self.net.switches.index(guard.element))
        self.breaks.after(self.t)

    def _switch(self, index: int) -> None:
        switch, old = self.net.switches[index], self.modes[index]
        before, everything = self.system, self._everything()
        force = everything.get((switch.target, 0), self.held[switch.target])
        after_closed = 1 if force > 0 else -1
        self.modes[index] = after_closed if old == 0 else 0 if switch.offset else self._after_slip(index)
        self._update_forces()
        if self.system is not before:
            self.z = self._state_from(everything)

    def _after_slip(self, index: int) -> int:
        """What follows when the sliding velocity reaches zero: slip the other way, if that force would let it; else stick."""
        switch, old = self.net.switches[index], self.modes[index]
        if not self._can_stick_now(index):
            return -old
        for order in (0, 1):
            row = self.system.rows[self.column(switch.driver, order)]
            found = tuple(self.system.weight(row, switch.target, k) for k in (1, 0))
            if found[0]:
                return 0  # the force cannot jump: it moves what it acts on
            if found[1]:
                now = float(
                    self.system.outputs(self.z, self._inputs(np.array(self.t)))[self.column(switch.driver, order)]
                )
                other = now - 2 * old * switch.limit * found[1]
                return -old if other * old < 0 else 0
        return -old

    def _can_stick_now(self, index: int) -> bool:
        closed = frozenset(i for i, mode in enumerate(self.modes) if mode == 0 or i == index)
        return self.systems[closed] is not None

    def _everything(self) -> dict[Reading, float]:
        """Every variable of the equations now."""
        w = self._inputs(np.array(self.t))
        values = self.system.everything @ np.concatenate([self.z, w])
        return dict(zip(self.system.exact.columns, map(float, values), strict=True))

    def _state_from(self, everything: dict[Reading, float]) -> Array:
        """The state of the present equations when these variables go on without a jump."""
        keys = list(self.system.exact.columns)
        chosen = [everything.get(keys[i], self.held.get(keys[i][0], 0.0)) for i in self.system.exact.chosen]
        result: Array = np.array(chosen) - self.system.back @ self._inputs(np.array(self.t))
        return result

    def _update_forces(self) -> None:
        for i, (switch, mode) in enumerate(zip(self.net.switches, self.modes, strict=True)):
            self.held[switch.target] = 0.0 if i in self.resting else mode * switch.limit
