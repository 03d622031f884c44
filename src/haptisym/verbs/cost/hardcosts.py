"""The hard cases, each put to our methods and to the usual ones: digits, time, and a verdict."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from math import isinf
from typing import Any, ClassVar

from haptisym.judge.answers import Answer, Subject
from haptisym.kernel.errors import HaptisymError
from haptisym.kernel.shown import counted
from haptisym.verbs.cost.hardcases import FAMILIES, HardCase, hard_cases
from haptisym.verbs.cost.measurement import HardRow
from haptisym.verbs.cost.methods import CROSSINGS, RATIO_METHODS, Method
from haptisym.verbs.cost.questions import Crossings, RatioQuestion
from haptisym.verbs.cost.stopwatch import interleaved, machine
from haptisym.verbs.cost.summary import hard_summary

VALUES = (
    "H_perc - H_env in floats",
    "python-control",
    "scipy.signal",
    "fast",
    "double-double",
    "certified",
    "30 digits",
)
"""The methods that the questions about values are put to."""
COUNTS = ("grid of 10^4 + Brent", "numpy.roots", "certified, 15 digits", "certified, 50 digits")
"""Those that the questions about crossings are put to."""
_BUDGET = 0.02  # s for the repeats of one case
_CLOSE = 1.5  # digits: 30 units in the last place of a double
_SPARE = 8  # digits of the reference beyond those of the methods


class HardCases:
    """What the question is about: no scene of the user's, and so nothing is to be said beside the answer."""

    title = "The hard cases"

    def asides(self, *_: object) -> list[str]:
        """Nothing."""
        return []

    def aside_keys(self, *_: object) -> dict[str, Any]:
        """Nothing."""
        return {}


@dataclass(frozen=True, repr=False)
class HardCosts(Answer):
    """Every hard case with every method, measured."""

    _schema: ClassVar[str] = "haptisym.cost/1"
    _page: ClassVar[str] = "haptisym.pages.cost:hard_page"
    _figure: ClassVar[str] = "haptisym.figures.hardcosts:hard_costs_figure"

    rows: tuple[HardRow, ...]
    machine: Mapping[str, str] = field(default_factory=machine)

    def _line(self) -> str:
        return counted(len(self.rows), "answer")

    @property
    def certified(self) -> bool:
        """False: times are measured."""
        return False

    @property
    def summary(self) -> str:
        """How many of the questions each side answers right."""
        return hard_summary(self.rows)

    @property
    def _about(self) -> Subject:
        return HardCases()

    def _body(self) -> dict[str, Any]:
        rows = [{**row.row(), "condition": None if isinf(row.condition) else row.condition} for row in self.rows]
        return {"summary": self.summary, "families": FAMILIES, "rows": rows, "machine": dict(self.machine)}


def hard_costs(
    cases: Iterable[HardCase] | None = None, *, told: Callable[[str, float], None] = lambda what, share: None
) -> HardCosts:
    """Put hard cases, all if none are given, to all methods. ``told`` : called with what is next and the share that is done.

    >>> from haptisym.verbs.cost.hardcases import hard_cases
    >>> found = hard_costs(hard_cases("identities"))
    >>> {row.verdict for row in found.rows if row.ours and row.proven}
    {'right'}
    """
    listed = hard_cases() if cases is None else tuple(cases)
    rows: list[HardRow] = []
    for i, case in enumerate(listed):
        told(f"{case.family}: {case.name}", i / len(listed))
        rows += put(case)
    told("", 1.0)
    return HardCosts(tuple(rows))


def put(case: HardCase, methods: Sequence[Method] | None = None) -> list[HardRow]:
    """One hard case, put to some methods, or to all that fit its question."""
    question = case.question
    chosen = methods or _methods(question)
    attempts, refused = {}, {}
    for method in chosen:
        try:
            attempts[method] = method.ready(question)
        except HaptisymError as error:
            refused[method] = str(error)
    timed = interleaved(attempts, _BUDGET, rounds=3)
    digits = int(max(method.held for method in chosen)) + _SPARE
    truth: Any = question.truth(digits) if isinstance(question, RatioQuestion) else question.certified(digits)
    rows = []
    for method in chosen:
        if method in refused or isinstance(timed[method].answer, HaptisymError):
            reason = refused.get(method) or str(timed[method].answer)
            rows.append(_row(case, method, verdict=f"cannot: {reason}"))
            continue
        answer, seconds = timed[method].answer, timed[method].seconds
        score = question.score(answer, truth, method.held)
        undecided = getattr(answer, "undecided", 0)
        rows.append(
            _row(
                case,
                method,
                digits=score.digits,
                seconds=seconds,
                proven=method.proves and not undecided,
                missed=score.missed,
                invented=score.invented,
                verdict="undecided" if undecided else _verdict(score.digits, score.missed, score.invented, method.held),
            )
        )
    return rows


def _methods(question: RatioQuestion | Crossings) -> list[Method]:
    return [RATIO_METHODS[x] for x in VALUES] if isinstance(question, RatioQuestion) else [CROSSINGS[x] for x in COUNTS]


def _row(case: HardCase, method: Method, **found: Any) -> HardRow:
    task = "evaluate" if isinstance(case.question, RatioQuestion) else "crossings"
    condition = case.question.condition
    assert condition is not None, "no hard case has a region"
    return HardRow(
        **{"task": task, "method": method.name, "digits": 0.0, "seconds": 0.0, "proven": False, **found},
        family=case.family,
        case=case.name,
        condition=condition,
        ours=method.ours,
    )


def _verdict(digits: float, missed: int, invented: int, held: float) -> str:
    """Right but for a digit, worse by so many digits, wrong, or a wrong count."""
    if missed or invented:
        return " and ".join(f"{word} {n}" for word, n in (("misses", missed), ("invents", invented)) if n)
    if digits >= held - _CLOSE:
        return "right"
    return f"loses {held - digits:.0f} digits" if digits >= 1 else "wrong"
