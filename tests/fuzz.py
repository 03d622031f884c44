"""Random scenes, every verb against an oracle that shares nothing with it: ``python -m tests.fuzz --minutes N``.

Each seed is one scene, the same on every machine; ``--seed N`` begins there, ``--only VERB`` asks one verb. With ``--state FILE`` a run
goes on after the last seed of the one before, and failures are kept there. Exit status 1 where an answer was wrong.
"""

from __future__ import annotations

import argparse
import json
import math
import signal
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from pathlib import Path
from statistics import NormalDist
from typing import Any

sys.path[:0] = [str(Path(__file__).parent / "witnesses")]

import mpmath  # noqa: E402
import strategies  # noqa: E402
from answers import is_outside_model, is_transparent, of_part, percepts_at  # noqa: E402
from fits import CHI_95, best_probit, likelihood, polynomial_fit  # noqa: E402
from oracles import DIGITS, MP, SYMBOLS, Case, Element, Facts, digits_of, excess_roots  # noqa: E402
from scenetexts import toml  # noqa: E402
from sympy import I  # noqa: E402

import haptisym as hs  # noqa: E402
from haptisym.verbs.cost.questions import DOUBLE, RatioQuestion  # noqa: E402
from haptisym.verbs.cost.sweeps import SweepQuestion, certified_way  # noqa: E402
from haptisym_check import check as check_certificate  # noqa: E402

PARTS = ("real", "imag")
MOST_SECONDS = 20
"""For one verb and one scene; what takes longer is counted, and is no failure."""


class TakesLongError(Exception):
    """A verb was given up on."""


@dataclass(frozen=True)
class Trial:
    """One random scene, as physics (``case``) and as the package has it."""

    seed: int

    @cached_property
    def case(self) -> Case:
        """Of whole numbers, where zeros and poles coincide, every third time."""
        pick = strategies.Seeded(self.seed)
        return strategies.coincident_case(pick) if self.seed % 3 == 0 else strategies.case(pick, order=4)

    @cached_property
    def text(self) -> str:
        return toml(self.case)

    @cached_property
    def scene(self) -> hs.Scene:
        return hs.parse_scene(self.text)

    @cached_property
    def result(self) -> hs.Evaluation:
        return hs.evaluate(self.scene)

    def frequencies(self, count: int) -> list[Fraction]:
        """Rational ones inside the band, in order."""
        pick, (low, high) = strategies.Seeded(self.seed + 1), self.case.band
        return sorted({low + (high - low) * Fraction(pick.whole(1, 99_999), 100_000) ** 2 for _ in range(count)})

    def ratio(self, part: str, omega: Any, case: Case | None = None) -> Any:
        return (case or self.case).ratio(part, omega)

    def ratio_at(self, part: str, omega: Fraction) -> Any:
        """The ratio at a rational frequency: 0 where the facts tell no difference, of which 80 digits leave some 10^-82."""
        return self.ratio(part, digits_of(omega)) if self.case.facts(omega)[part].difference else MP.mpf(0)

    def place(self, path: str) -> tuple[int, str] | None:
        """Which element a path means (0 the environment) and which of its values; None where the oracle has no such value."""
        group, *middle, key = path.split(".")
        if group not in ("environment", "effects"):
            return None
        names = [x.name for x in self.scene.effects]
        i = 1 + names.index(".".join(middle)) if middle else 0
        element = [self.case.felt, *self.case.between][i]
        return (i, key) if element.values.get(key) else None

    def moved(self, path: str, share: Fraction) -> Case | None:
        """The case with one value changed by that share of it."""
        at = self.place(path)
        if at is None:
            return None
        elements = [self.case.felt, *self.case.between]
        old = elements[at[0]]
        elements[at[0]] = Element(old.kind, {**old.values, at[1]: old.values[at[1]] * (1 + share)})
        return replace(self.case, felt=elements[0], between=tuple(elements[1:]))


def percepts(part: str, at: Facts) -> list[tuple[str, str]]:
    """Section 2.3 of the paper, for one frequency."""
    if at.excess <= 0 or (part == "imag" and at.perc < 0):
        return []
    change = {1: "higher", -1: "lower", 0: "equal"}[at.larger]
    env, perc = at.env or at.perc, at.perc or at.env
    sides = {(1, 1): "stiffness", (-1, -1): "mass", (1, -1): "stiffness-to-mass", (-1, 1): "mass-to-stiffness"}
    return [("damping" if part == "imag" else sides[env, perc], change)]


def evaluate(t: Trial) -> None:
    """Sturm's theorem counts the crossings; at rational frequencies exact signs tell the rest."""
    for part in PARTS:
        assert len(of_part(t.result, part)) == t.case.counts[part], f"{part}: Sturm counts {t.case.counts[part]}"
    for omega in t.frequencies(5):
        facts = t.case.facts(omega)
        assert is_transparent(t.result, omega) == all(facts[part].excess <= 0 for part in PARTS), omega
        assert is_outside_model(t.result, omega) == (facts["imag"].perc < 0), omega
        for part in PARTS:
            assert percepts_at(t.result, part, omega) == percepts(part, facts[part]), (omega, part)


def derive(t: Trial) -> None:
    """The formulas, with the scene's values, are what the equations of motion give with 80 digits."""
    found = hs.derive(t.scene, keep=())
    for omega in t.frequencies(2):
        w = digits_of(omega)
        for i, name in enumerate(("H_env", "H_perc")):
            value = found[name].evalf(40, subs={hs.s: strategies.exact(omega) * I})
            real, imag = value.as_real_imag()
            expected = t.case.dynamics(MP.mpc(0, w), DIGITS)[i]
            got = MP.mpc(MP.mpf(str(real)), MP.mpf(str(imag)))
            assert abs(got - expected) <= MP.mpf(10) ** -25 * abs(expected), (name, omega)


def effects(t: Trial) -> None:
    """Without the effects that are left out, no ratio differs by more than the bound."""
    found = hs.relevance(t.scene, Fraction(1, 20))
    names = [x.name for x in found.pruned.effects]
    kept = [x for x, e in zip(t.case.between, t.scene.effects, strict=True) if e.name in names]
    pruned = replace(t.case, between=tuple(kept))
    for omega in t.frequencies(6):
        w = digits_of(omega)
        for part in hs.Part:
            change = abs(t.ratio(part.value, w) - t.ratio(part.value, w, pruned))
            most = MP.mpf(found.bound[part].most) * (1 + MP.mpf(10) ** -15)
            assert change <= most + MP.mpf(10) ** -60, (omega, part.value)  # what 80 digits leave of an exact 0


def require(t: Trial) -> None:
    """The least threshold that nobody notices is met somewhere on the band, and no ratio exceeds it: mpmath and Sturm."""
    found = hs.require(t.scene, "evaluation.jnd")
    if not found.feasible:
        return
    least = MP.mpf(found.feasible[0].low.value.digits(25)) if found.feasible[0].low.value is not None else MP.mpf(0)
    for omega in t.frequencies(8):
        for part in PARTS:
            assert t.ratio_at(part, omega) <= least * (1 + MP.mpf(10) ** -20), (omega, part)
    if least > 0 and found.feasible[0].low.closed:
        share = Fraction(str(MP.nstr(least, 20))) * Fraction(10**9 - 1, 10**9)
        below = t.case.with_(c=dict.fromkeys(PARTS, share))
        start = digits_of(t.case.band[0]) + MP.mpf(10) ** -30  # at the end itself a ratio may be a limit
        exceeds = any(t.ratio(part, start) > digits_of(share) for part in PARTS)
        assert exceeds or any(below.counts.values()), f"nothing is met just below {least}"


def stability(t: Trial) -> None:
    """Roots of mpmath: of H_perc's denominator, and of H_perc + m s^2 + b s + k."""
    hand = hs.Hand("fuzz", m="0.5 kg", b="4 N*s/m", k="200 N/m")
    found = hs.stability(t.scene, [hand])
    poles = t.case.poles
    if all(abs(x.real) > MP.mpf(10) ** -15 * (1 + abs(x)) for x in poles) and found.imposed.stable is not None:
        assert found.imposed.stable == all(x.real < 0 for x in poles), "imposed"
    roots = roots_in_hand(t.case)
    clear = all(abs(x.real) > MP.mpf(10) ** -12 * (1 + abs(x)) for x in roots)
    if clear and found.held[0].unstable is not None:
        assert found.held[0].unstable == sum(x.real >= 0 for x in roots), "held"


def roots_in_hand(case: Case) -> list[Any]:
    """The roots of H_perc + 0.5 s^2 + 4 s + 200, in lowest terms."""
    import oracles

    s = oracles._S
    numerator = (case.dynamics(s, SYMBOLS)[1] + s * s / 2 + 4 * s + 200).numer
    powers = {n: MP.mpf(int(x.numerator)) / int(x.denominator) for (n, _), x in numerator.terms()}
    c = [powers.get(n, MP.mpf(0)) for n in range(max(powers), -1, -1)]
    return list(MP.polyroots(c, maxsteps=1000, extraprec=1000)) if len(c) > 1 else []


def sensitivity(t: Trial) -> None:
    """Differences of the ratio, with 80 digits, give the derivative of each simple crossing."""
    tiny = Fraction(1, 10**30)
    h = MP.mpf(10) ** -25
    for x in hs.sensitivity(t.scene).crossings[:2]:
        w, part = MP.mpf(x.omega.digits(60)), x.criterion.name
        slope = (t.ratio(part, w * (1 + h)) - t.ratio(part, w * (1 - h))) / (2 * h) if w else MP.mpf(0)
        for p in x.parameters:
            up, down = t.moved(p.path, tiny), t.moved(p.path, -tiny)
            if p.elasticity is None or up is None or down is None or abs(slope) < MP.mpf(10) ** -8:
                continue
            rise = (t.ratio(part, w, up) - t.ratio(part, w, down)) / (2 * digits_of(tiny))
            told = MP.mpf(p.elasticity.digits(20))
            assert abs(-rise / slope - told) <= MP.mpf(10) ** -6 * (1 + abs(told)), (p.path, part)


def tolerances(t: Trial) -> None:
    """For values within a range, mpmath's crossings lie within the enclosures."""
    knob = next((x for x in t.scene.parameters if t.place(x.path)), None)
    if knob is None:
        return
    ranged = t.scene.with_values({knob.path: f"{knob.value} +- 3 %"})
    found = hs.tolerances(ranged, samples=0, limit=10)
    pick = strategies.Seeded(t.seed)
    for _ in range(2):
        case = t.moved(knob.path, Fraction(pick.whole(-300, 300), 10_000))
        assert case is not None
        for part in PARTS:
            inside = [x for x in found.enclosures if x.criterion.name == part]
            roots = excess_roots(case, part)
            for omega in (
                roots if len(roots) == case.counts[part] else ()
            ):  # else something cancels, which it does not see
                slack = MP.mpf(10) ** -9 * omega
                assert any(MP.mpf(float(x.low)) - slack <= omega <= MP.mpf(float(x.high)) + slack for x in inside), (
                    knob.path,
                    part,
                    omega,
                )


def peaks(t: Trial) -> None:
    """Just beside a local maximum the ratio is smaller, and at none of some frequencies it is above all of them and the ends."""
    found = [x for x in hs.peaks(t.scene) if x.criterion.name in PARTS]
    h = MP.mpf(10) ** -12
    for x in found[:3]:
        w, part = MP.mpf(x.omega.digits(40)), x.criterion.name
        try:
            top = t.ratio(part, w)
        except ZeroDivisionError:  # at a pole of H_env on the axis itself the ratio is a limit
            top = max(t.ratio(part, w * (1 + h * h)), t.ratio(part, w * (1 - h * h)))
        assert abs(top - MP.mpf(x.ratio.digits(20))) <= MP.mpf(10) ** -15 * top, part
        assert max(t.ratio(part, w * (1 + h)), t.ratio(part, w * (1 - h))) <= top * (1 + MP.mpf(10) ** -30), part


def metrics(t: Trial) -> None:
    """The JND verdict beside the measures is that of the evaluation, which Sturm's theorem judges; every document is JSON."""
    found = hs.metrics(t.scene)
    for omega in t.frequencies(3):
        facts = t.case.facts(omega)
        assert is_transparent(found.evaluation, omega) == all(facts[part].excess <= 0 for part in PARTS), omega
    json.loads(found.to_json(), parse_constant=_refused)


def certificate(t: Trial) -> None:
    """The checker that shares no line with the package accepts the proof, and refuses it for another scene."""
    proof = t.result.certificate().encode()
    assert check_certificate(proof, t.text.encode())
    try:
        check_certificate(proof, t.text.replace("band", "# other\nband", 1).encode())
    except Exception:  # noqa: BLE001  any refusal will do
        return
    raise AssertionError("the certificate was accepted for another file")


def simulate(t: Trial) -> None:
    """In time, from the equations of motion, without the closed forms."""
    assert hs.check(t.scene, count=2).agrees is not False


def sweep(t: Trial) -> None:
    """Sturm's theorem counts the crossings of every set of values."""
    knob = next((x for x in t.scene.parameters if t.place(x.path)), None)
    if knob is None:
        return
    shares = [Fraction(-1, 8), Fraction(0), Fraction(1, 8)]
    values = [float(knob.value * (1 + strategies.exact(x))) for x in shares]
    data = hs.sweep(t.scene, {knob.path: values})
    for i, value in enumerate(values):
        at = t.place(knob.path)
        assert at is not None
        old = [t.case.felt, *t.case.between][at[0]].values[at[1]]
        case = t.moved(knob.path, Fraction(value) / old - 1)  # the double that was swept, exactly
        assert case is not None
        for part in PARTS:
            count = int(data[f"crossings_{part}"][i])
            assert count in (-1, case.counts[part]), (knob.path, value, part, count)


def cost(t: Trial) -> None:
    """80 digits of the equations of motion tell how right floats are, Sturm's theorem what a sweep counts."""
    question = RatioQuestion(t.scene.distortion(), tuple(float(x) for x in t.frequencies(4)))
    answer = [t.scene.distortion().compile("fast", of=("ratio_real", "ratio_imag"))(x) for x in question.omegas]
    told = question.score(
        [(float(x.ratio_real), float(x.ratio_imag)) for x in answer], question.truth(30), DOUBLE
    ).digits
    errors = [
        abs(MP.mpf(float(x[i])) / true - 1)
        for x, omega in zip(answer, question.omegas, strict=True)
        for i, part in enumerate(PARTS)
        if (true := t.ratio(part, digits_of(Fraction(omega)))) > MP.mpf(10) ** -40
    ]
    if errors and len(errors) == 2 * len(answer):  # a ratio of 0 is right or wrong as a whole
        right = min(DOUBLE, float(-MP.log10(max(*errors, MP.mpf(10) ** -30))))
        assert abs(told - max(right, 0)) < 0.01, (told, right)
    knob = next((x for x in t.scene.parameters if t.place(x.path)), None)
    if knob is None or knob.value == 0:
        return
    swept = replace(SweepQuestion.of(t.scene, [knob.path], quick=True), patience=0.2)
    at = t.place(knob.path)
    assert at is not None
    old = [t.case.felt, *t.case.between][at[0]].values[at[1]]
    for value, true in list(zip(swept.values[0].tolist(), swept.truth, strict=False))[:2]:
        case = t.moved(knob.path, Fraction(value) / old - 1)
        assert case is not None
        for part in PARTS:
            assert true[f"crossings_{part}"] in (-1, case.counts[part]), (knob.path, value, part)
    found = swept.score(certified_way(swept)())
    assert (found.missed, found.invented, found.wrong[0] if found.wrong else 0) == (0, 0, 0)
    assert found.digits > 9.5 or found.wrong == (0, 0), found  # of no set there are no digits


def jnd(t: Trial) -> None:
    """Newton's method with 40 digits finds the same curve, and the likelihood falls by as much at the ends of the interval."""
    pick = strategies.Seeded(t.seed)
    mu, sigma = pick.whole(50, 150) / 100, pick.whole(10, 100) / 100
    levels = sorted({pick.whole(1, 200) / 100 for _ in range(pick.whole(3, 8))})
    shares = [NormalDist(mu, sigma).cdf(x) for x in levels]
    counts = [(n := pick.whole(5, 40), sum(pick.whole(0, 10**6) < share * 10**6 for _ in range(n))) for share in shares]
    answers = [(x, k, n) for x, (n, k) in zip(levels, counts, strict=True)]
    with tempfile.TemporaryDirectory() as folder:
        table = Path(folder) / "answers.csv"
        table.write_text("level,k,n\n" + "".join(f"{x},{k},{n}\n" for x, k, n in answers), encoding="utf-8")
        found = hs.jnd(table)
    a, b = best_probit(answers)
    if b <= MP.mpf(1) / 10:
        return  # hardly rises at all, or falls
    curve, top = found.fit.curve, likelihood(answers, a, b)
    assert abs(curve.mu + a / b) < 1e-7 * (1 + abs(a / b)), (curve, answers)
    assert abs(curve.sigma * b - 1) < 1e-7, (curve, answers)
    for end in (found.jnd.low, found.jnd.high):
        if end:
            held = MP.mpf(NormalDist().inv_cdf(0.75)) / end
            fallen = 2 * (top - likelihood(answers, *best_probit(answers, held)))
            assert abs(fallen - CHI_95) < 1e-4, (end, fallen, answers)


def identify(t: Trial) -> None:
    """Of a model that is linear in its parameters: normal equations with 40 digits; of the scene's own H_perc, with noise."""
    pick = strategies.Seeded(t.seed + 7)
    low, high = (float(x) for x in t.case.band)
    begin = low or high / 30
    omega = [begin * (high / begin) ** ((i + 0.5) / 15) for i in range(15)]  # not at the ends, where poles may lie
    exact = [complex(t.case.dynamics(MP.mpc(0, digits_of(Fraction(w))), DIGITS)[1]) for w in omega]
    size = max(map(abs, exact))
    sigma = [0.01 * size * pick.whole(50, 200) / 100 for _ in omega]
    H = [h + s * complex(pick.whole(-200, 200), pick.whole(-200, 200)) / 100 for h, s in zip(exact, sigma, strict=True)]
    count = pick.whole(1, 3)
    felt = hs.measured(omega, H, radius=[s * math.sqrt(-2 * math.log1p(-0.95)) for s in sigma])
    found = hs.identify(felt, degrees=(count - 1, 0))
    values, errors, square = polynomial_fit(omega, H, sigma, count)
    for x, value, error in zip(found.estimates, values, errors, strict=True):
        assert abs(x.value - value) < 1e-4 * error, (x.parameter.path, x.value, value)
        assert abs(x.error / error - 1) < 1e-5, (x.parameter.path, x.error, error)
    assert abs(found.verdict.square - square) < 1e-6 * (1 + square), (found.verdict.square, square)
    json.loads(found.to_json(), parse_constant=_refused)


def _refused(word: str) -> None:
    raise AssertionError(f"{word} in a document")


VERBS: dict[str, Callable[[Trial], None]] = {
    x.__name__: x
    for x in (
        evaluate,
        derive,
        effects,
        require,
        stability,
        sensitivity,
        tolerances,
        peaks,
        metrics,
        certificate,
        sweep,
        simulate,
        cost,
        jnd,
        identify,
    )
}
"""``scenes`` and ``schemas`` ask nothing of a random scene that an oracle could tell."""
EVERY = {"sweep": 4, "cost": 4, "jnd": 2, "identify": 2, "simulate": 8, "tolerances": 2, "derive": 2}
"""What takes longest is asked of every so manieth scene."""


@contextmanager
def limited(seconds: int) -> Iterator[None]:
    """TakesLongError after so many seconds, where the system can do that."""

    def over(*_: object) -> None:
        raise TakesLongError

    if not hasattr(signal, "SIGALRM"):
        yield
        return
    before = signal.signal(signal.SIGALRM, over)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def asked(verb: str, trial: Trial) -> tuple[str, str]:
    """How it went: ``right``, ``wrong``, ``undecided``, ``without oracle``, ``refused`` or ``too long``; and what is to be said."""
    try:
        with limited(MOST_SECONDS):
            VERBS[verb](trial)
    except TakesLongError:
        return "too long", ""
    except mpmath.libmp.NoConvergence:
        return "without oracle", ""
    except hs.UndecidedError:
        return "undecided", ""
    except hs.SceneError as error:
        return "refused", str(error)
    except Exception as error:  # noqa: BLE001  whatever it is, it is what the fuzz is for
        where = traceback.extract_tb(error.__traceback__)[-1]
        return "wrong", f"{type(error).__name__}: {error} ({Path(where.filename).name}:{where.lineno})"
    return "right", ""


def run(
    first: int, seconds: float, verbs: list[str], most: int
) -> tuple[int, Counter[tuple[str, str]], list[dict[str, Any]]]:
    """From a seed on, until the time is over or there were so many: the next seed, how often what came out, and failures."""
    tally, failures, seed, end = Counter[tuple[str, str]](), list[dict[str, Any]](), first, time.monotonic() + seconds
    while time.monotonic() < end and seed < first + most:
        trial = Trial(seed)
        for verb in verbs:
            if len(verbs) > 1 and seed % EVERY.get(verb, 1):
                continue
            how, what = asked(verb, trial)
            tally[verb, how] += 1
            if how == "wrong":
                failures.append({"seed": seed, "verb": verb, "what": what})
                print(
                    f"seed {seed}, {verb}: {what}\n  again: python -m tests.fuzz --seed {seed} --only {verb} --count 1",
                    flush=True,
                )
            if time.monotonic() > end:
                break
        seed += 1
    return seed, tally, failures


def main(words: list[str] | None = None) -> int:
    """The command line; the exit status."""
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz", description=__doc__)
    parser.add_argument("--minutes", type=float, default=1.0)
    parser.add_argument("--seed", type=int, help="the first; that of the state, or 0, if not given")
    parser.add_argument("--count", type=int, default=10**9, help="of scenes at most")
    parser.add_argument("--only", choices=VERBS, action="append", help="this verb alone; may be repeated")
    parser.add_argument("--state", type=Path, help="a file that keeps the next seed and all failures")
    given = parser.parse_args(words)
    state: dict[str, Any] = {"next": 0, "failures": []}
    if given.state and given.state.exists():
        state = json.loads(given.state.read_text(encoding="utf-8"))
    first = state["next"] if given.seed is None else given.seed
    after, tally, failures = run(first, 60 * given.minutes, given.only or list(VERBS), given.count)
    for verb in VERBS:
        told = ", ".join(f"{n} {how}" for (name, how), n in sorted(tally.items()) if name == verb)
        print(f"{verb:12} {told or 'not asked'}")
    print(f"seeds {first} to {after - 1}, {len(failures)} wrong")
    if given.state:
        kept = {"next": after, "failures": [*state["failures"], *failures]}
        given.state.write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8")
    return bool(failures)


if __name__ == "__main__":
    sys.exit(main())
