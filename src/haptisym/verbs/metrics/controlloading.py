"""A control loading by the tables of 14 CFR Part 60: each test with tolerance, value, margin and
result, and the JND's verdict.

What a pilot's control does on the ground is compared with the aircraft's, here the environment's.
The linear model decides

* static force (A2A 2.a.1 to 2.a.4, C2A 2.a.1 and 2.a.2): H_perc(0) against H_env(0), within 10 % or
  pounds at full travel A;
* breakout: the dry friction that the effects bring in, against pounds (the environment has none);
* free response (A2A 2.b.1 to 2.b.3, C2A 2.a.5): ``freeresponse``; C2A is flown with friction off,
  so that friction is left out;
* sweeps (A2A 2.b, the alternate method): of one sinusoidal period in T seconds the force above the
  slow one is abs(H(j w) - H(0)) A, w = 2 pi/T; what the display changes of it, abs(dH(j w) - dH(0))
  A, is within 10 % of it or 2 lb. How long moderate and rapid sweeps last is in a paragraph that
  was not read: the durations are given;
* freeplay (C2A 2.a.6, 0.10 in): a linear model has none, so that it is not tested.

A margin is the share of the tolerance that is left: 1 with no change at all, 0 at the limit,
negative beyond it. Where a rule offers two tolerances the wider one counts. Where pounds are needed
and the travel is not known, the travel up to which the test passes is said instead. Read: both
tables (edition of 2019), not the paragraphs of the attachments. EASA's CS-FSTD was not read.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar

import flint
from flint import arb
from sympy import Integer, Rational, pi

from haptisym.judge.answers import Answer
from haptisym.judge.evaluation import Evaluation, evaluate
from haptisym.judge.peaks import ValueAt
from haptisym.kernel.budget import SECONDS, limited
from haptisym.kernel.dynamics import RealFunction, Response
from haptisym.kernel.errors import SceneError, meant, within
from haptisym.kernel.objects import counted, titled
from haptisym.kernel.reals import Ball, ExactNumber, RealNumber, Scaled, short
from haptisym.kernel.rings import omega
from haptisym.kernel.roots import chart
from haptisym.model.distortion import Distortion
from haptisym.model.quantities import Dimension, MotionKind, Number, quantity
from haptisym.model.scene import Scene
from haptisym.model.scenefile import as_scene
from haptisym.verbs.metrics.freeresponse import FlightRule, at_most, free_response
from haptisym.verbs.metrics.metric import value_at

RULES = {"14cfr60-a2a": FlightRule.AEROPLANE, "14cfr60-c2a": FlightRule.HELICOPTER}
"""The tables by their names: aeroplanes, helicopters."""
POUND = quantity("1 lbf", Dimension.FORCE).value


@dataclass(frozen=True)
class Control:
    """A control of a table: the numbers of its entries for static force and dynamics (empty where
    the table has none), and its tolerances of breakout and force, lb."""

    static: str
    dynamic: str
    breakout: Rational
    force: Rational


_FIVE, _TWO, _HALF = Rational(5), Rational(2), Rational(1, 2)
CONTROLS: dict[FlightRule, dict[str, Control]] = {
    FlightRule.AEROPLANE: {
        "pitch": Control("2.a.1", "2.b.1", _TWO, _FIVE),
        "roll": Control("2.a.2", "2.b.2", _TWO, Rational(3)),
        "pedals": Control("2.a.3", "2.b.3", _FIVE, _FIVE),
        "nosewheel": Control("2.a.4", "", _TWO, Rational(3)),
    },
    FlightRule.HELICOPTER: {
        "cyclic": Control("2.a.1", "2.a.5", Rational(1, 4), Integer(1)),
        "collective": Control("2.a.2", "2.a.5", _HALF, Integer(1)),
        "pedals": Control("2.a.2", "2.a.5", _HALF, Integer(1)),
    },
}
"""The controls of each table; the first is the default."""


@dataclass(frozen=True)
class Trial:
    """One test: the environment's number, the display's, the share of the tolerance that is left,
    and whether it passes.

    ``passes`` None: not tested, for the reason ``why``. ``noticed``: what the JND says at the
    frequency of the test, on the whole band of a free response; None outside the band.
    """

    entry: str
    name: str
    tolerance: str
    environment: RealNumber | int | None = None
    display: RealNumber | int | None = None
    unit: str = ""
    margin: float | None = None
    passes: bool | None = None
    why: str = ""
    noticed: bool | None = None


@dataclass(frozen=True, repr=False)
class Increment(RealNumber):
    """|H(j omega) - H(0)|: what a sweep needs more than a slow one, per displacement."""

    response: Response
    static: RealNumber
    omega: RealNumber

    def ball(self, bits: int) -> Ball:
        # The static part is taken off in balls: at a slow sweep both are nearly equal, and what
        # floats would lose is had by asking for more bits.
        with flint.ctx.workprec(bits + 32):
            real, imag = (
                ValueAt(f, self.omega).ball(bits + 32)
                for f in (self.response.real, self.response.imag)
            )
            off = real - self.static.ball(bits + 32)
            return (off * off + imag * imag).sqrt()


@dataclass(frozen=True, repr=False)
class ControlLoading(Answer):
    """The tests of a control by a table of 14 CFR Part 60, and its JND evaluation. Made by
    ``control_loading``.

    ``trials`` : of each test the environment's number and the display's, in ``unit``, whether the
    latter is within the tolerance, and the share of that which is left; those that were not made
    have the reason. ``travel`` : from neutral to the stop, m; None where it was not given. Proven,
    but for ``undecided`` ones: then ``certified`` is False.
    """

    _schema: ClassVar[str] = "haptisym.controlloading/1"
    _page: ClassVar[str] = "haptisym.pages.metrics:control_page"
    _figure: ClassVar[str] = "haptisym.figures.effects:CONTROL"

    evaluation: Evaluation
    rule: FlightRule
    control: str
    trials: tuple[Trial, ...]
    travel: Any = None

    def _line(self) -> str:
        return (
            f"{titled(self.scene.title)}: {counted(len(self.trials), 'test')} of table "
            f"{self.rule.value}"
        )

    @property
    def scene(self) -> Scene:
        """The scene that was evaluated."""
        return self.evaluation.scene

    @property
    def distortion(self) -> Distortion:
        """The distortion of which the free response is judged: of a helicopter with its friction
        off."""
        return (
            _without_friction(self.scene)
            if self.rule is FlightRule.HELICOPTER
            else self.evaluation.distortion
        )

    @property
    def failed(self) -> tuple[Trial, ...]:
        """The tests that fail."""
        return tuple(x for x in self.trials if x.passes is False)

    @property
    def untested(self) -> tuple[Trial, ...]:
        """The tests that were not made."""
        return tuple(x for x in self.trials if x.passes is None)

    @property
    def certified(self) -> bool:
        """Whether nothing was left undecided."""
        return self.evaluation.certified and not any(
            x.why.startswith("undecided") for x in self.trials
        )

    def _body(self) -> dict[str, Any]:
        e = self.evaluation
        return {
            "rule": next(name for name, rule in RULES.items() if rule is self.rule),
            "control": self.control,
            **({} if self.travel is None else {"travel": float(self.travel)}),
            "passes": not self.failed,
            "tests": [_row(x) for x in self.trials],
            "jnd": {
                "transparent": [[float(x.low.omega), float(x.high.omega)] for x in e.transparent],
                "bandwidth": None if e.bandwidth is None else float(e.bandwidth),
            },
            "certified": self.certified,
        }


def _row(x: Trial) -> dict[str, Any]:
    numbers = {
        key: float(y) if isinstance(y, RealNumber) else y
        for key, y in (("environment", x.environment), ("display", x.display))
    }
    return {
        "entry": x.entry,
        "test": x.name,
        "tolerance": x.tolerance,
        **numbers,
        "unit": x.unit,
        "margin": x.margin,
        "passes": x.passes,
        "noticed": x.noticed,
        **({"why": x.why} if x.why else {}),
    }


def control_loading(
    scene: Scene | str | Path,
    rule: str = "14cfr60-a2a",
    control: str | None = None,
    *,
    travel: Number | None = None,
    sweeps: Iterable[Number] = (),
    limit: float | None = SECONDS,
) -> ControlLoading:
    """The tests of 14 CFR Part 60 on a control, its display against the scene's environment; each
    decided by proof.

    ``rule`` : "14cfr60-a2a" (aeroplanes) or "14cfr60-c2a" (helicopters). ``control`` : pitch, roll,
    pedals, nosewheel; cyclic, collective, pedals. ``travel`` : from neutral to the stop, m, for
    tolerances in pounds. ``sweeps`` : seconds that a full sweep lasts, each a test of table A2A.
    ``limit`` : as of ``metrics``. Raises SceneError for a name that there is not, and a travel or
    duration that is not positive.

    >>> found = control_loading("helicopter-cyclic", "14cfr60-c2a")
    >>> [x.name for x in found.trials][:2], [x.name for x in found.failed]
    (['static force', 'breakout'], [])
    """
    scene = as_scene(scene)
    if rule not in RULES:
        raise SceneError(
            f'rule: unknown "{str(rule)[:60]}": {meant(str(rule), RULES)}valid are '
            f"{', '.join(RULES)}"
        )
    known = CONTROLS[RULES[rule]]
    control = next(iter(known)) if control is None else control
    if control not in known:
        raise SceneError(
            f'control: unknown "{str(control)[:60]}": {meant(str(control), known)}of this '
            f"rule are {', '.join(known)}"
        )
    if travel is not None and scene.motion is MotionKind.ROTATION:
        raise SceneError(
            "travel: this control turns, and the rule is in pounds at the grip: leave it out"
        )
    # The limit holds for the evaluation and all tests together: they are computed inside.
    with limited(limit):
        asked = _Asked(
            evaluate(scene),
            RULES[rule],
            known[control],
            None if travel is None else _positive("travel", travel, Dimension.DISPLACEMENT),
            tuple(_positive("sweep", x, Dimension.TIME) for x in sweeps),
        )
        return ControlLoading(
            asked.evaluation, asked.rule, control, tuple(asked.trials()), asked.travel
        )


def _positive(key: str, given: Number, dimension: Dimension) -> Any:
    """Return a quantity in SI, exact; SceneError where it is not positive."""
    with within(key):
        value = quantity(given, dimension).value
    if not value.is_positive:
        raise SceneError(f'{key}: "{given}" must be positive')
    return value


def _without_friction(scene: Scene) -> Distortion:
    """Return the distortion of a scene whose dry friction is taken out."""
    effects = tuple(x for x in scene.effects if x.model != "coulomb-friction")
    return replace(scene, effects=effects).distortion()


@dataclass(frozen=True)
class _Asked:
    """The question that a table answers: a control, with its travel, m, and the durations of its
    sweeps, s, where they are known. ``friction`` : the display's dry friction, N or N m."""

    evaluation: Evaluation
    rule: FlightRule
    control: Control
    travel: Any
    sweeps: tuple[Any, ...]
    friction: Any = field(init=False)

    def __post_init__(self) -> None:
        # Several frictions act on one hand: their breakout forces add up.
        frictions = [x for x in self.evaluation.scene.effects if x.model == "coulomb-friction"]
        forces = [p.value for x in frictions for p in x.parameters if p.key == "force"]
        object.__setattr__(self, "friction", sum(forces, Integer(0)))

    @cached_property
    def turns(self) -> bool:
        """Whether the control turns: pounds then need a lever."""
        return self.evaluation.scene.motion is MotionKind.ROTATION

    @cached_property
    def d(self) -> Distortion:
        """The distortion that is judged; of a helicopter with its friction off."""
        scene = self.evaluation.scene
        return (
            _without_friction(scene)
            if self.rule is FlightRule.HELICOPTER
            else self.evaluation.distortion
        )

    def trials(self) -> Iterator[Trial]:
        """All tests of the table, in its order."""
        yield self.static_force()
        yield self.breakout()
        yield from self.free()
        if self.rule is FlightRule.AEROPLANE and self.control.dynamic:
            yield from self.swept()
        if self.rule is FlightRule.HELICOPTER:
            yield Trial(
                "2.a.6", "freeplay", "0.10 in", why="a linear model has no freeplay: measure it"
            )

    def at_rest(self, f: RealFunction) -> RealNumber | None:
        """Return a real part at 0 rad/s, exact where it is rational; None where it is infinite."""
        # A pole at 0 is known from the chart. A rational value is kept exact, so that a change of
        # exactly 10 % can be decided.
        value = value_at(f, chart({"": f}, Integer(0), Integer(1)).points[0], "")
        exact = f.expression().subs(omega, 0)
        return ExactNumber(exact) if value is not None and exact.is_Rational else value

    def noticed(self, omega: Any) -> bool | None:
        """Whether the distortion is noticed at a frequency, by the JND; None outside the band."""
        e, at = self.evaluation, float(omega)
        if not float(e.scene.band[0]) <= at <= float(e.scene.band[1]):
            return None
        return not any(float(x.low.omega) <= at <= float(x.high.omega) for x in e.transparent)

    def near(self, off: RealNumber, own: RealNumber, pounds: Rational) -> dict[str, Any]:
        """Return whether a change of force is within 10 % of the environment's, or within pounds at
        full travel, with the margin; or why that is not decided. ``off``, ``own`` : the change and
        the environment's number, per displacement.

        The verdict is decided in exact numbers or balls; margins are floats.
        """
        size = abs(float(own.ball(64).mid()))
        share = float(off.ball(64).mid()) / size if size else None
        # A change of exactly 10 % passes. Balls could not tell it from a larger one, rational
        # numbers can.
        if isinstance(off, ExactNumber) and isinstance(own, ExactNumber):
            keeps = bool(10 * off.value <= abs(own.value))
        else:
            keeps = at_most(lambda bits: off.ball(bits) - abs(own.ball(bits)) / 10, Rational(0))
        left = [] if share is None else [1 - 10 * share]
        most = None if self.turns else pounds * POUND
        # The wider of two tolerances counts: pounds are asked where they help, and are needed only
        # where 10 % is exceeded.
        if most is not None and self.travel is not None:
            left.append(1 - float(off) * float(self.travel) / float(most))
            keeps = keeps or at_most(lambda bits: Scaled(off, 1 / self.travel).ball(bits), most)
        elif not keeps and most is None:
            return {
                "why": (
                    f"a torque, and more than 10 %: {short(ExactNumber(pounds))} lb at the grip "
                    f"need the lever"
                )
            }
        elif not keeps and most is not None:
            upto = float(most) / float(off)
            why = f"needs the travel: {short(ExactNumber(pounds))} lb is enough up to {upto:.4g} m"
            return {"why": why}
        return {"passes": keeps, "margin": max(left, default=None)}

    def static_force(self) -> Trial:
        """Return the test of static force, by the stiffness at rest, to which force at full
        travel is proportional."""
        own, felt = (self.at_rest(x.real) for x in (self.d.env_response, self.d.perc_response))
        pounds = self.control.force
        trial = Trial(
            self.control.static,
            "static force",
            f"10 % or {pounds} lb",
            own,
            felt,
            "N m/rad" if self.turns else "N/m",
        )
        if own is None or felt is None:
            return replace(trial, why="the stiffness at rest is infinite")
        off: RealNumber = _Off(felt, own)
        if isinstance(own, ExactNumber) and isinstance(felt, ExactNumber):
            off = ExactNumber(abs(felt.value - own.value))
        verdict = self.near(off, own, pounds)
        return replace(trial, **verdict, noticed=self.noticed(0))

    def breakout(self) -> Trial:
        """Return the test of breakout, by the display's dry friction: the environment has none."""
        most, pounds = self.control.breakout * POUND, float(self.control.breakout)
        tolerance = f"{pounds:g} lb" + (" or 25 %" if self.rule is FlightRule.HELICOPTER else "")
        trial = Trial(
            self.control.static, "breakout", tolerance, 0, ExactNumber(self.friction), "N"
        )
        # A friction torque is no force at the grip without the lever's length.
        if self.turns:
            return replace(
                trial,
                environment=None,
                display=None,
                unit="",
                why="a torque: the rule is in pounds at the grip",
            )
        if self.friction == 0:
            return replace(
                trial,
                environment=None,
                display=None,
                unit="",
                why="the scene has no dry friction: measure it",
            )
        return replace(
            trial, passes=bool(self.friction <= most), margin=1 - float(self.friction / most)
        )

    def free(self) -> Iterator[Trial]:
        """Yield the tests of the free response; none where the table has no entry for the
        control."""
        entry = self.control.dynamic
        if not entry:
            return
        response = free_response(self.d, self.rule)
        if not response.checks:
            why = response.refused.removeprefix("not offered: ")
            yield Trial(entry, "free response", "10 %", why=why)
        e = self.evaluation
        # The bandwidth is the band's end itself, the same object, where nothing is noticed.
        noticed = e.bandwidth is not e.chart.points[-1].omega
        for x in response.checks:
            yield Trial(
                entry,
                x.name,
                x.tolerance,
                x.environment,
                x.perceived,
                x.unit,
                x.margin,
                x.passes,
                "",
                noticed,
            )

    def swept(self) -> Iterator[Trial]:
        """Yield the tests of moderate and rapid sweeps: the force above that of the slow one."""
        entry, tolerance = self.control.dynamic, "10 % or 2 lb above static"
        if not self.sweeps:
            why = (
                "how long they last was not read (paragraph 4 of attachment 2): give --sweep "
                "SECONDS"
            )
            yield Trial(entry, "moderate and rapid sweep", tolerance, why=why)
        rests = [
            self.at_rest(x.real)
            for x in (self.d.env_response, self.d.perc_response, self.d.difference_response)
        ]
        for duration in self.sweeps:
            w = ExactNumber(2 * pi / duration)
            trial = Trial(entry, f"sweep of {float(duration):g} s", tolerance)
            if any(x is None for x in rests):
                yield replace(trial, why="the stiffness at rest is infinite")
                continue
            # The change of the increment is |dH(j w) - dH(0)|, of dH itself: the difference of two
            # moduli would be smaller where the phase changes.
            responses = self.d.env_response, self.d.perc_response, self.d.difference_response
            own, felt, off = (
                Increment(x, rest, w)
                for x, rest in zip(responses, rests, strict=True)
                if rest is not None
            )
            unit = "N m/rad" if self.turns else "N/m"
            yield replace(
                trial,
                environment=own,
                display=felt,
                unit=unit,
                noticed=self.noticed(w),
                **self.near(off, own, _TWO),
            )


@dataclass(frozen=True, repr=False)
class _Off(RealNumber):
    """The distance |one - other| of two numbers."""

    one: RealNumber
    other: RealNumber

    def ball(self, bits: int) -> Ball:
        with flint.ctx.workprec(bits + 32):
            return abs(arb(self.one.ball(bits + 32) - self.other.ball(bits + 32)))
