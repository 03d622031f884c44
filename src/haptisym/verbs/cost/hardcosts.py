"""The hard cases: scenes and questions on which the usual methods fail, answered by haptisym's
methods and by the usual ones.

They are values, made here once, for the tests and for ``haptisym cost --hard-cases``, in families
by what makes them hard (``FAMILIES``). Each answer has correct digits, a time and a verdict.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache, partial
from math import isinf
from typing import Any, ClassVar

from sympy import Integer, Rational, pi

from haptisym import effects, environments
from haptisym.judge.answers import Answer, NoScene
from haptisym.kernel.errors import HaptisymError
from haptisym.kernel.objects import counted
from haptisym.model.catalogue import Effect
from haptisym.model.distortion import Distortion, distort
from haptisym.model.jnd import Threshold
from haptisym.model.quantities import Number
from haptisym.verbs.cost.entry import CostMeasurement, interleaved, machine, wrong_words
from haptisym.verbs.cost.methods import (
    CROSSINGS,
    RATIO_METHODS,
    Crossings,
    Method,
    Question,
    RatioQuestion,
    Score,
)

PAPER = (Rational(9, 5), 15, 100)
"""m, b, k of the paper's example."""
_RESONANCE = 7.453559924999299
"""The double next to sqrt(k/m), rad/s."""
_HALF = Rational(1, 2)
_BAND = (Integer(0), Integer(15))


@dataclass(frozen=True)
class HardCase:
    """A question about a scene, and the family of difficulties that it belongs to."""

    family: str
    name: str
    question: Question = field(repr=False)


FAMILIES: dict[str, str] = {}
"""Each family of hard cases, and why it is hard."""
_MAKERS: dict[str, Callable[[], Iterable[tuple[str, Question]]]] = {}
_Made = Iterator[tuple[str, Question]]


def _family(name: str, why: str) -> Callable[[Callable[[], _Made]], Callable[[], _Made]]:
    """Enter a function that makes cases into the tables, under a name and with a reason."""

    def enter(make: Callable[[], _Made]) -> Callable[[], _Made]:
        FAMILIES[name], _MAKERS[name] = why, make
        return make

    return enter


def hard_cases(*families: str) -> tuple[HardCase, ...]:
    """All hard cases, or those of some families."""
    return tuple(
        HardCase(family, name, question)
        for family in families or FAMILIES
        for name, question in _MAKERS[family]()
    )


# Scenes


def _lowpass(omega_n: Number = 80, zeta: Number = _HALF) -> Effect:
    return effects.second_order_lowpass(omega_n, zeta)


@cache
def _filtered(b: Number = 15, zeta: Number = _HALF) -> Distortion:
    """The paper's example with another damping of environment or filter."""
    return distort(environments.mass_spring_damper(PAPER[0], b, PAPER[2]), _lowpass(zeta=zeta))


def _spring(*between: Effect) -> Distortion:
    return distort(environments.mass_spring_damper(k=100), *between)


def _power(k: int) -> Rational:
    return Rational(10) ** k


_c = Threshold.of


# Values


@_family("low frequencies", "dH vanishes as omega does: H_perc - H_env cancels digit by digit")
def _low() -> _Made:
    for k in (2, 5, 7, 8, 10, 20, 50, 100, 150):
        yield f"at 10^-{k} rad/s", RatioQuestion(_filtered(), (10.0**-k,))


@_family("wide ranges", "parameters from 1e-9 to 1e9, frequencies up to 1e150: powers overflow")
def _wide() -> _Made:
    # the square of 1e150 is a double, its cube is infinite
    omegas = (1e-9, 1.0, 1e9, 1e30, 1e80, 1e150)
    # powers of ten of m, b, k, of omega_n and of zeta
    for name, (m, b, k), omega_n, zeta in (
        ("light and stiff", (-9, 0, 9), 9, -9),
        ("heavy and soft", (9, 0, -9), -9, 9),
        ("light damping", (0, -9, 0), 0, -9),
    ):
        felt = environments.mass_spring_damper(_power(m), _power(b), _power(k))
        device = _lowpass(_power(omega_n), _power(zeta))
        yield name, RatioQuestion(distort(felt, device), omegas)


@_family("light damping", "k - m omega^2 cancels at resonance, where |H_env| collapses to b omega")
def _light() -> _Made:
    omegas = (
        _RESONANCE,
        _RESONANCE * (1 + 1e-12),
        _RESONANCE * (1 - 1e-9),
        _RESONANCE * (1 + 1e-3),
    )
    for k in range(13):
        yield f"b = 10^-{k} N s/m", RatioQuestion(_filtered(_power(-k)), omegas)


@_family("zeta = 1/2", "the leading terms of the distortion cancel")
def _half() -> _Made:
    omegas = tuple(10.0**-k for k in range(9))
    for name, zeta in (("exactly", _HALF), ("nearly", _HALF + _power(-12))):
        yield name, RatioQuestion(_filtered(_power(-6), zeta), omegas)


@_family("cascades, values", "expanded coefficients of many low-passes span hundreds of decades")
def _cascades() -> _Made:
    for n in (10, 20, 40):
        yield (
            f"{n} low-passes",
            RatioQuestion(_cascade(n), (1e-6, 1e-2, 1.0, 15.0, 80.0, 300.0, 1e4)),
        )


@cache
def _cascade(n: int) -> Distortion:
    felt = environments.mass_spring_damper(*PAPER)
    return distort(felt, *(_lowpass(80 + 7 * i, Rational(1, 2 + i % 5)) for i in range(n)))


@_family(
    "stiff delays, values",
    "exp(-j omega tau) - 1 cancels for short delays, turns many times for long ones",
)
def _delays() -> _Made:
    for k in (-9, -6, -3, 0, 3):
        d = distort(environments.mass_spring_damper(*PAPER), effects.delay(_power(k)))
        yield f"10^{k} s", RatioQuestion(d, (1e-6, 1e-3, 1.0, 15.0, 1e3))


@_family("identities", "dH is zero: what floats leave of it is noise")
def _identity() -> _Made:
    omegas = (1e-3, 1.0, 7.0, 1e3)
    yield "a gain of 1", RatioQuestion(_spring(effects.series("1")), omegas)
    device = effects.four_channel_teleoperator(0.3, 5.1, 307, 0.7, 7.3, 511)
    yield (
        "four channels without delay",
        RatioQuestion(distort(environments.mass_spring_damper(*PAPER), device), omegas),
    )
    yield (
        "a lag and its inverse",
        RatioQuestion(_spring(effects.first_order_lag(20), effects.series("1 + s/20")), omegas),
    )


@_family("poles on the axis", "an undamped filter answers without bound at its frequency")
def _poles() -> _Made:
    d = distort(environments.mass_spring_damper(*PAPER), _lowpass(80, 0))
    yield "at the pole", RatioQuestion(d, (80.0,))
    yield "next to the pole", RatioQuestion(d, (80 * (1 + 1e-12), 80 * (1 - 1e-9), 79.0))


@_family("H_env(0) = 0", "both dH and H_env vanish at omega = 0: the ratio is a limit")
def _nothing_at_rest() -> _Made:
    damped = environments.mass_spring_damper(m=2, b=5)
    yield "a shunt damper", RatioQuestion(distort(damped, effects.shunt(b=1)), (0.0, 1e-150, 1.0))
    yield (
        "a lag",
        RatioQuestion(distort(damped, effects.first_order_lag(20)), (0.0, 1e-150, 1e-8, 1.0)),
    )
    yield (
        "a mass alone",
        RatioQuestion(
            distort(environments.mass_spring_damper(m=2), _lowpass()), (0.0, 1e-100, 1e-8, 1.0)
        ),
    )


# Crossings


@_family("tangency ladder", "c nears a maximum of r: two crossings, a touch, none")
def _tangency() -> _Made:
    # r_r is at most 1/5, at 3 rad/s: on a spring dH/|H_env| is the second term of the series effect
    d = _spring(effects.series("1 + 0.4*s/(s^2 + 2*s + 9)"))
    yield "touch", Crossings(d, _c(Rational(1, 5), 1), _BAND)
    for k in range(1, 41):
        for sign, word in ((-1, "below"), (1, "above")):
            yield f"10^-{k} {word}", Crossings(d, _c(Rational(1, 5) + sign * _power(-k), 1), _BAND)


@_family("tangency ladder, delayed", "the same where the ratio is a sine")
def _delayed_tangency() -> _Made:
    d = _spring(effects.delay(Rational(1, 5)))  # r_i = |sin(omega/5)| is at most 1, at 5 pi/2 rad/s
    for k in range(1, 41, 3):
        for sign, word in ((-1, "below"), (1, "above")):
            yield (
                f"10^-{k} {word}",
                Crossings(d, _c(3, 1 + sign * _power(-k)), (Integer(0), Integer(12))),
            )


@_family("cascades, crossings", "the threshold polynomial has degree up to 160")
def _cascade_crossings() -> _Made:
    for n in (10, 20, 40):
        yield f"{n} low-passes", Crossings(_cascade(n), _c(Rational(1, 10)), _BAND)


@_family(
    "clustered thresholds",
    "crossings 1e-4 apart, ten and twenty of them, coefficients of both signs",
)
def _clustered() -> _Made:
    for n in (4, 10, 20):
        roots = [1 + Rational(i, 10_000) for i in range(1, n + 1)]
        yield (
            f"{n} crossings",
            _prescribed("*".join(f"(-s^2 - {x})" for x in map(_quotient, roots))),
        )


@_family(
    "Mignotte-like thresholds", "two crossings far closer to each other than floats distinguish"
)
def _mignotte() -> _Made:
    # Mignotte's polynomials x^n - 2 (a x - 1)^2 have two zeros next to 1/a whose distance is about
    # a^-(n + 2)/2, as small as it can be for coefficients of that size
    for n, a in ((6, 10), (10, 100), (20, 1000)):
        yield f"degree {n}", _prescribed(f"(s^2)^{n} - 2*({a}*s^2 + 1)^2")


def _quotient(x: Rational) -> str:
    return f"{x.p}/{x.q}"


def _prescribed(polynomial: str) -> Crossings:
    """r_r = |c + p(s)| behind a series effect 1 + c + p(s), p even: crossings where p is 0 or -2
    c."""
    d = _spring(effects.series(f"1 + 1/10 + {polynomial}"))
    return Crossings(d, _c(Rational(1, 10), 1), (Integer(0), Integer(2)))


@_family(
    "resonance behind a delay",
    "|H_env| collapses over a width of b/m, and r rises and falls within",
)
def _delayed_resonance() -> _Made:
    between = (_lowpass(), effects.delay(Rational(1, 1000)))
    for k in (3, 6, 9, 12):
        d = distort(environments.mass_spring_damper(PAPER[0], _power(-k), PAPER[2]), *between)
        yield f"b = 10^-{k} N s/m", Crossings(d, _c(Rational(1, 20)), _BAND)


@_family("long delays", "many crossings")
def _long_delays() -> _Made:
    for tau, high in ((Rational(1, 2), 150), (Rational(2), 60)):
        d = distort(environments.mass_spring_damper(*PAPER), _lowpass(), effects.delay(tau))
        yield (
            f"{float(tau):g} s up to {high} rad/s",
            Crossings(d, _c(Rational(1, 10)), (Integer(0), Integer(high))),
        )


@_family("rational crossings", "crossings exactly on the ends of the band and on points of a grid")
def _rational() -> _Made:
    d = _spring(effects.first_order_lag("0.3 rad/s"))  # r_r = 1/5 at exactly 0.15 rad/s
    for low, high in (("0", "0.15"), ("0.15", "1"), ("0.05", "0.25"), ("0", "1")):
        yield (
            f"band {low} to {high} rad/s",
            Crossings(d, _c(Rational(1, 5), 1), (Rational(low), Rational(high))),
        )
    turned = _spring(effects.first_order_lag(10 * pi))
    yield "at 5 pi rad/s", Crossings(turned, _c(Rational(1, 5), 1), (Integer(0), 5 * pi))
    sprung = distort(environments.mass_spring_damper(m=1, k=100), effects.shunt(k=10))
    yield "at 0 rad/s", Crossings(sprung, _c(Rational(1, 10)), (Integer(0), Integer(5)))


@_family("cancelled resonance", "H_env and dH vanish together, where a grid invents crossings")
def _cancelled() -> _Made:
    for m in (1, Rational(9, 5)):
        d = distort(environments.mass_spring_damper(m=m, k=100), _lowpass(100, Rational(1, 5)))
        yield f"m = {float(m):g} kg", Crossings(d, _c(Rational(1, 10)), (Integer(0), Integer(40)))


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
_CLOSE = 1.5  # digits that may be lost: some 30 units in the last place of a double
_SPARE = 8  # digits of the reference beyond those of the methods


@dataclass(frozen=True, kw_only=True)
class HardRow(CostMeasurement):
    """One method's answer to one hard case; ``verdict``: right, how many digits are lost, what is
    wrong, or why there is none."""

    family: str
    case: str
    condition: float
    ours: bool
    verdict: str

    @property
    def answered(self) -> bool:
        """Whether the method fits the question at all."""
        return not self.verdict.startswith("cannot")


def worst_verdict(rows: Iterable[HardRow]) -> str:
    """The worst of several verdicts, with the counts of all cases; "" where all are right."""
    # a wrong count is worse than a place reported as undecided, and that than lost digits
    listed = list(rows)
    if told := wrong_words(sum(row.missed for row in listed), sum(row.invented for row in listed)):
        return told
    if undecided := sum(row.verdict == "undecided" for row in listed):
        return f"{undecided} undecided, and reported so"
    bad = [row for row in listed if row.verdict != "right"]
    return min(bad, key=lambda row: row.digits).verdict if bad else ""


@dataclass(frozen=True, repr=False)
class HardCosts(Answer):
    """Cases on which usual methods fail, each by every method, measured on this ``machine``. Made
    by ``hard_costs``.

    ``rows`` : correct decimal digits, time in s and ``verdict`` of each: "right", or how many
    digits are lost, how many crossings missed or invented. References are proven.
    """

    _schema: ClassVar[str] = "haptisym.cost/1"
    settled = True
    _page: ClassVar[str] = "haptisym.pages.cost:hard_page"
    _figure: ClassVar[str] = "haptisym.figures.cost:HARD"

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
        """How many of the questions each side answers right, in a sentence."""
        count = len({(row.family, row.case) for row in self.rows})
        proven = [row for row in self.rows if row.ours and row.proven]
        wrong = sum(row.verdict != "right" for row in proven)
        usual = [row for row in self.rows if not row.ours and row.answered]
        failed = sum(row.verdict != "right" for row in usual)
        said = f"{wrong} of them WRONG" if wrong else "none of them wrong"
        return (
            f"{count} hard questions: haptisym gives {len(proven)} proven answers, {said}; "
            f"of {len(usual)} answers by the usual "
            f"ways {failed} lose digits, miss crossings or invent some, and none reports it."
        )

    @property
    def _about(self) -> NoScene:
        return NoScene("The hard cases")

    def _body(self) -> dict[str, Any]:
        rows = [
            {**row.row(), "condition": None if isinf(row.condition) else row.condition}
            for row in self.rows
        ]
        return {
            "summary": self.summary,
            "families": FAMILIES,
            "rows": rows,
            "machine": dict(self.machine),
        }


def hard_costs(
    cases: Iterable[HardCase] | None = None,
    *,
    told: Callable[[str, float], None] = lambda what, share: None,
) -> HardCosts:
    """Put hard cases, all if none are given, to all methods. ``told`` : called with what is next
    and the share that is done.

    >>> from haptisym.verbs.cost.hardcosts import hard_cases
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
    is_ratio = isinstance(question, RatioQuestion)
    chosen = methods or (
        [RATIO_METHODS[x] for x in VALUES] if is_ratio else [CROSSINGS[x] for x in COUNTS]
    )
    # a method may refuse a question beforehand, or only when it runs
    attempts, refused = {}, {}
    for method in chosen:
        try:
            attempts[method] = method.ready(question)
        except HaptisymError as error:
            refused[method] = error
    timed = interleaved(attempts, _BUDGET, rounds=3)
    refused |= {
        method: x.answer for method, x in timed.items() if isinstance(x.answer, HaptisymError)
    }
    # one reference for all methods, with more digits than any of them holds
    digits = int(max(method.held for method in chosen)) + _SPARE
    truth: Any = (
        question.truth(digits)
        if isinstance(question, RatioQuestion)
        else question.certified(digits)
    )
    condition = question.condition
    assert condition is not None, "no hard case has a region"
    rows = []
    for method in chosen:
        about: dict[str, Any] = {
            "family": case.family,
            "case": case.name,
            "condition": condition,
            "ours": method.ours,
        }
        row: Any = partial(HardRow, "evaluate" if is_ratio else "crossings", method.name, **about)
        if method in refused:
            rows.append(row(0.0, 0.0, proven=False, verdict=f"cannot: {refused[method]}"))
            continue
        x = timed[method]
        score = question.score(x.answer, truth, method.held)
        undecided = getattr(x.answer, "undecided", 0)
        verdict = "undecided" if undecided else _verdict(score, method.held)
        proven = method.proves and not undecided
        rows.append(
            row(score.digits, x.seconds, proven, score.missed, score.invented, verdict=verdict)
        )
    return rows


def _verdict(score: Score, held: float) -> str:
    """Right but for a digit, worse by so many digits, wrong, or a wrong count."""
    if told := wrong_words(score.missed, score.invented):
        return told
    if score.digits >= held - _CLOSE:
        return "right"
    return f"loses {held - score.digits:.0f} digits" if score.digits >= 1 else "wrong"
