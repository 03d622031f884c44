"""What was measured, in a sentence, and the words for times and counts that go with it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from statistics import median

from haptisym.verbs.cost.measurement import HardRow, Measurement

_SCATTER = 0.15  # of the middle half of the repeats: quiet machines have 0.02 to 0.1
BUSY = "This machine is busy: times are not to be trusted."


def is_busy(rows: Sequence[Measurement]) -> bool:
    """Whether the repeats scatter so much that something else was running."""
    spreads = [x.spread for x in rows if x.spread is not None]
    return bool(spreads) and median(spreads) > _SCATTER


def summary(rows: Sequence[Measurement]) -> str:
    """What a digit costs, in a sentence; of a sweep what certainty costs; of times that scatter that they do."""
    if is_busy(rows):
        return BUSY
    if rows and rows[0].task == "sweep":
        return _of_sweep(rows)
    proven = sorted((x for x in rows if x.task == "crossings" and x.proven), key=lambda x: x.digits)
    if len(proven) < 2:
        return _best(rows)
    first, last = proven[0], proven[-1]
    each = (last.seconds - first.seconds) / (last.digits - first.digits)
    lost = sum((x.spread or 0) * x.seconds for x in (first, last))
    grids = [x for x in rows if x.task == "crossings" and x.method.startswith("grid") and x.method[-1].isdigit()]
    finest = max(grids, key=lambda x: x.seconds, default=None)
    price = f"{duration(each)} a digit" if last.seconds - first.seconds > lost else "no time that shows"
    return (
        f"Here all crossings, proven, to {first.digits:.0f} digits take {duration(first.seconds)}; more digits cost {price}: "
        f"{last.digits:.0f} of them take {duration(last.seconds)}" + (f"; {_grid(finest)}" if finest else "") + "."
    )


def _of_sweep(rows: Sequence[Measurement]) -> str:
    ours = next((x for x in rows if x.proven), None)
    if ours is None:
        return "Here no set was answered with proof."
    grids = [x for x in rows if not x.proven and x.sets]
    told = [
        f"a {x.method.partition(',')[0]} points takes {duration(x.seconds)} and counts {share_wrong(x)} wrong"
        for x in grids
    ]
    said = f" ({not_reached(ours)})" if ours.left_open else ""
    return (
        f"Here a set is answered with proof in {duration(ours.seconds)}{said}" + "".join(f"; {x}" for x in told) + "."
    )


def not_reached(row: Measurement) -> str:
    """Of a sweep, for how many sets the time was too short."""
    return f"{row.left_open} of {row.asked} sets were not reached within the limit of time"


def share_wrong(row: Measurement) -> str:
    """``1.6 % of 500 sets``; "" of what is no sweep."""
    if row.wrong is None or not row.sets:
        return ""
    share = f"{100 * row.wrong / row.sets:.2g} %" if row.wrong else "none"
    return f"{share} of {row.sets} sets"


def _grid(row: Measurement) -> str:
    if not row.complete:
        return f"a {row.method} points takes {duration(row.seconds)} and {wrong(row)}"
    return f"a {row.method} points takes {duration(row.seconds)} for {row.digits:.1f} digits, and proves nothing"


def _best(rows: Sequence[Measurement]) -> str:
    best = max((x for x in rows if x.complete), key=lambda x: x.digits, default=None)
    if best is None:
        return "Here no method found all crossings and no others."
    low = min((x for x in rows if x.complete), key=lambda x: x.seconds)
    return (
        f"Here {best.digits:.1f} digits take {duration(best.seconds)} ({best.method}), and the fastest way gives "
        f"{low.digits:.1f} digits in {duration(low.seconds)} ({low.method})."
    )


def wrong(row: Measurement) -> str:
    """What is wrong with a count of crossings; "" where nothing is."""
    parts = [f"{word} {n}" for word, n in (("misses", row.missed), ("invents", row.invented)) if n]
    return " and ".join(parts)


def duration(seconds: float) -> str:
    """A time with three digits and a readable unit.

    >>> duration(0.00123456), duration(3.2e-7)
    ('1.23 ms', '320 ns')
    """
    for unit, name in ((1.0, "s"), (1e-3, "ms"), (1e-6, "us")):
        if seconds >= unit:
            return f"{float(f'{seconds / unit:.3g}'):g} {name}"
    return f"{float(f'{seconds / 1e-9:.3g}'):g} ns"


def hard_summary(rows: Sequence[HardRow]) -> str:
    """How many of the questions each side answers right, in a sentence."""
    count = len({(row.family, row.case) for row in rows})
    proven = [row for row in rows if row.ours and row.proven]
    wrong = sum(row.verdict != "right" for row in proven)
    usual = [row for row in rows if not row.ours and row.answered]
    failed = sum(row.verdict != "right" for row in usual)
    said = "none of them wrong" if not wrong else f"{wrong} of them WRONG"
    return (
        f"{count} hard questions: haptisym gives {len(proven)} proven answers, {said}; of {len(usual)} answers by the usual ways "
        f"{failed} lose digits, miss crossings or invent some, and none says so."
    )


def worst_verdict(rows: Iterable[HardRow]) -> str:
    """What goes wrong in some cases, all together; "" where nothing does."""
    listed = list(rows)
    missed, invented = sum(row.missed for row in listed), sum(row.invented for row in listed)
    if missed or invented:
        return " and ".join(f"{word} {n}" for word, n in (("misses", missed), ("invents", invented)) if n)
    if any(row.verdict == "undecided" for row in listed):
        return f"{sum(row.verdict == 'undecided' for row in listed)} undecided, and said so"
    bad = [row for row in listed if row.verdict != "right"]
    return min(bad, key=lambda row: row.digits).verdict if bad else ""
