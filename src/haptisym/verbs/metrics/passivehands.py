"""Whether every passive hand may hold a display, and with every passive environment: two of the field's measures."""

from __future__ import annotations

from haptisym.judge.passivity import Beyond, Passivity
from haptisym.kernel.reals import ExactNumber, short
from haptisym.verbs.metrics.forms import MeasureForms
from haptisym.verbs.metrics.measured import Measured, covers
from haptisym.verbs.metrics.metric import Metric, Value

_ANSWERS = {True: "holds", False: "does not hold", None: "not decided"}


def passivity_measure(m: Measured, _: MeasureForms) -> Metric:
    """Im H_perc >= 0 on the band and beside it; the damping of a hand that makes up for what is given away."""
    found = m.evaluation.passivity
    return Metric(
        "passivity",
        (),
        (Value("Im H_perc >= 0 on the band", m.passive, "rad/s"), *(_values(m, found) if found else ())),
        "a display is stable with every passive hand exactly if H_perc/s is positive real",
        "per frequency derived (15_metrics); with a clock Colgate and Schenkel (1997), as quoted by Weir and Colgate: read",
        _verdict(m, found),
    )


def _values(m: Measured, found: Passivity) -> list[Value]:
    rows = [Value(f"Im H_perc < 0, looked at up to {short(ExactNumber(found.high))} rad/s", found.active, "rad/s")]
    rows += [Value("Im H_perc beyond that", found.beyond.value)]
    if (given := found.most_given) and found.active:
        where = f" at {short(given.omega)} rad/s" if given.omega else ""
        rows += [Value(f"most energy given per cycle, over π A²{where}", given.value, m.unit)]
    rows += [Value("every passive hand", _answer(found))]
    if found.is_active and found.damping:
        where = f", set at {short(found.damping.omega)} rad/s" if found.damping.omega else ", approached far out"
        rows += [Value(f"hand damping that makes up for it{where}", found.damping.value, m.units["b"])]
    elif found.is_unbounded:
        rows += [Value("hand damping that makes up for it", "none: what is given away grows without bound")]
    return [*rows, Value("force stable under imposed motion", _decided(m.evaluation.stable))]


def _decided(answer: bool | None) -> str:  # noqa: FBT001
    return {True: "yes", False: "no", None: "not decided"}[answer]


def _answer(found: Passivity) -> str:
    return (
        "not told by this with a clock"
        if found.holds is None and found.beyond is Beyond.CLOCK
        else _ANSWERS[found.holds]
    )


def _verdict(m: Measured, found: Passivity | None) -> str:
    kept = covers(m.passive, m.evaluation.chart)
    band = "Im H_perc >= 0 on the whole band" if kept else "Im H_perc < 0 somewhere on the band: active there"
    if found is None:
        return f"{band}; whether that is so at all frequencies was not decided"
    if found.holds and found.sampled:
        return f"{band}; every passive hand: holds, by Colgate and Schenkel's condition"
    if found.holds:
        return "every passive hand: holds, as Im H_perc >= 0 at all frequencies and no pole forbids it"
    if found.is_active and found.holds is False:
        above = (
            f", but < 0 above it, first from {short(found.active[0].low.omega)} rad/s" if kept and found.active else ""
        )
        return f"{band}{above}; every passive hand: does not hold"
    if found.beyond is Beyond.CLOCK and found.holds is False:
        return f"{band}; every passive hand: does not hold, by Colgate and Schenkel's condition"
    if found.beyond is Beyond.CLOCK:
        return f"{band} and up to half the clock's rate; with a clock that does not tell of every passive hand"
    if found.beyond is Beyond.NEVER and found.poles_allow is False:
        return "Im H_perc >= 0 at all frequencies, but poles forbid it; every passive hand: does not hold"
    return f"{band}; every passive hand: not decided"


def absolute_stability_measure(m: Measured, forms: MeasureForms) -> Metric:
    """Llewellyn's criterion: the band where its conditions on the axis hold, and all of it at all frequencies."""
    bands, whole = m.llewellyn, m.unconditional
    rows: tuple[Value, ...] = ()
    if bands is None:
        verdict = "not offered: D = 0, so that the hybrid matrix does not exist"
    else:
        rows = (
            Value("conditions on the axis hold, on the band", bands, "rad/s"),
            Value("conditions on the axis at all frequencies", _ANSWERS[whole.axis]),
            Value("conditions on the poles", _ANSWERS[whole.poles]),
        )
        verdict = _absolutely(m, covers(bands, m.evaluation.chart))
    return Metric(
        "absolute stability",
        forms("g"),
        rows,
        "Llewellyn's criterion, after Adams and Hannaford (1999)",
        "verified (tutorial chapter 9.3.3)",
        verdict,
    )


def _absolutely(m: Measured, kept: bool) -> str:  # noqa: FBT001
    whole = m.unconditional
    if whole.holds:
        return "absolutely stable: with every passive hand and every passive environment"
    if not kept:
        return (
            "not absolutely stable: the conditions on the axis fail somewhere on the band; energy can come out there, with some "
            "passive hand or environment"
        )
    if whole.axis is False:
        return "not absolutely stable: the conditions on the axis hold on the whole band, but fail above it"
    if whole.poles is False:
        return "not absolutely stable: the conditions on the axis hold on the whole band, but poles break those on the poles"
    return "the conditions on the axis hold on the whole band; whether it is absolutely stable was not decided"
