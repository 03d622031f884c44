"""Random scenes, every verb against an oracle that shares nothing with it: ``python -m tests.fuzz --minutes N``.

Each seed is one scene, the same on every machine: of two seeds in four a rational one; of one a scene with delays, holds, links,
friction or fractional tissue; of one a loop in a hand, a sampled loop, or a measured response. ``--seed N`` begins there, ``--only VERB`` asks
one verb. A scene with a wrong answer is written to ``build/fuzz`` (``--keep FOLDER``) with what was wrong and how to ask again.
Exit status 1 where an answer was wrong.
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
import numpy as np  # noqa: E402
import scan  # noqa: E402
import strategies  # noqa: E402
from answers import is_outside_model, is_transparent, of_part, percepts_at  # noqa: E402
from fits import CHI_95, best_probit, likelihood, polynomial_fit  # noqa: E402
from oracles import DIGITS, MP, SYMBOLS, Case, Facts, digits_of, excess_roots  # noqa: E402
from scenetexts import toml  # noqa: E402
from scipy.linalg import expm  # noqa: E402
from sympy import I  # noqa: E402
from windings import winding  # noqa: E402

import haptisym as hs  # noqa: E402
from haptisym.verbs.cost.methods import DOUBLE, RatioQuestion  # noqa: E402
from haptisym.verbs.stability.held import held  # noqa: E402
from haptisym_check import check as check_certificate  # noqa: E402

PARTS = ("real", "imag")
MOST_SECONDS = 20
"""For one verb and one scene; what takes longer is counted, and is no failure."""


class TakesLongError(Exception):
    """A verb was given up on."""


@dataclass(frozen=True)
class Trial:
    """One random scene, as the package has it, and as physics: rational here."""

    seed: int

    @cached_property
    def case(self) -> Any:
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

    @property
    def band(self) -> tuple[Fraction, Fraction]:
        low, high = self.case.band
        return low, high

    def frequencies(self, count: int) -> list[Fraction]:
        """Rational ones inside the band, in order."""
        pick, (low, high) = strategies.Seeded(self.seed + 1), self.band
        return sorted({low + (high - low) * Fraction(pick.whole(1, 99_999), 100_000) ** 2 for _ in range(count)})

    def dynamics(self, omega: Any) -> tuple[Any, Any]:
        """H_env and H_perc at a frequency in mpmath."""
        found: tuple[Any, Any] = self.case.dynamics(MP.mpc(0, omega), DIGITS)
        return found

    def ratio(self, part: str, omega: Any, case: Any = None) -> Any:
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

    def moved(self, path: str, share: Fraction) -> Any:
        """The case with one value changed by that share of it."""
        at = self.place(path)
        if at is None:
            return None
        elements = [self.case.felt, *self.case.between]
        old = elements[at[0]]
        value = self.value(old.values[at[1]]) * (1 + share)
        elements[at[0]] = replace(old, values={**old.values, at[1]: self.written(value)})
        return replace(self.case, felt=elements[0], between=tuple(elements[1:]))

    def value(self, own: Any) -> Any:
        return own

    def written(self, value: Any) -> Any:
        return value


class Late(Trial):
    """With delays, holds, links, friction or fractional tissue: as physics by ``scan``, which looks at thousands of frequencies."""

    @cached_property
    def case(self) -> Any:
        return scan.Draw(self.seed).case([*scan.FAMILIES][self.seed // 4 % len(scan.FAMILIES)])

    @cached_property
    def text(self) -> str:
        return str(self.case.text)

    @property
    def band(self) -> tuple[Fraction, Fraction]:
        low, high = map(Fraction, self.case.ends)
        return low, high

    def dynamics(self, omega: Any) -> tuple[Any, Any]:
        found: tuple[Any, Any] = self.case.dynamics(scan.MP.mpf(omega), scan.DIGITS)
        return found

    def ratio(self, part: str, omega: Any, case: Any = None) -> Any:
        found = (case or self.case).facts(scan.MP.mpf(omega), scan.DIGITS)
        return MP.mpf(abs(found.difference[part]) / found.size)

    def ratio_at(self, part: str, omega: Fraction) -> Any:
        return self.ratio(part, digits_of(omega))

    def value(self, own: Any) -> Any:
        return Fraction(own)

    def written(self, value: Any) -> Any:
        return scan.MP.nstr(scan.digits_of(value), 38)


def percepts(part: str, at: Facts) -> list[tuple[str, str]]:
    """Section 2.3 of the paper, for one frequency."""
    if at.excess <= 0 or (part == "imag" and at.perc < 0):
        return []
    change = {1: "higher", -1: "lower", 0: "equal"}[at.larger]
    env, perc = at.env or at.perc, at.perc or at.env
    sides = {(1, 1): "stiffness", (-1, -1): "mass", (1, -1): "stiffness-to-mass", (-1, 1): "mass-to-stiffness"}
    return [("damping" if part == "imag" else sides[env, perc], change)]


def evaluate(t: Trial) -> None:
    """Sturm's theorem counts the crossings; at rational frequencies exact signs tell the rest. Of a late scene a grid looks everywhere."""
    if isinstance(t, Late):
        assert (found := scan.disagreements(t.case, t.result)) == [], found[:3]
        return
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
            expected = t.dynamics(w)[i]
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
            assert change <= most + MP.mpf(10) ** -30, (omega, part.value)  # what 80 or 40 digits leave of an exact 0


def require(t: Trial) -> None:
    """The least threshold that nobody notices is met somewhere on the band, and no ratio exceeds it: mpmath and Sturm."""
    found = hs.require(t.scene, "evaluation.jnd")
    if not found.feasible:
        return
    least = MP.mpf(found.feasible[0].low.digits(25)) if found.feasible[0].low is not None else MP.mpf(0)
    for omega in t.frequencies(8):
        for part in PARTS:
            assert t.ratio_at(part, omega) <= least * (1 + MP.mpf(10) ** -20), (omega, part)
    if least > 0 and found.feasible[0].closed[0] and not isinstance(t, Late):
        share = Fraction(str(MP.nstr(least, 20))) * Fraction(10**9 - 1, 10**9)
        below = t.case.with_(c=dict.fromkeys(PARTS, share))
        start = digits_of(t.case.band[0]) + MP.mpf(10) ** -30  # at the end itself a ratio may be a limit
        exceeds = any(t.ratio(part, start) > digits_of(share) for part in PARTS)
        assert exceeds or any(below.counts.values()), f"nothing is met just below {least}"


def stability(t: Trial) -> None:
    """Roots of mpmath: of H_perc's denominator, and of H_perc + m s^2 + b s + k. Where there are delays ``Loop`` is asked."""
    if isinstance(t, Late):
        return
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
    tiny = Fraction(1, 10**15)
    h = MP.mpf(10) ** -13
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
        if isinstance(t, Late):  # a sign that changes between two frequencies has a crossing there
            points = scan.grid(case, count=200)
            for part in PARTS:
                above = case.facts(points, scan.FLOATS).excess[part] > 0
                for a, b in [(points[i], points[i + 1]) for i in np.flatnonzero(above[1:] != above[:-1])]:
                    told = [(float(x.low), float(x.high)) for x in found.enclosures if x.criterion.name == part]
                    assert any(low <= b * (1 + 1e-9) and a <= high * (1 + 1e-9) for low, high in told), (
                        knob.path,
                        part,
                        a,
                        b,
                    )
            continue
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
    json.loads(found.to_json(), parse_constant=_refused)
    if isinstance(t, Late):
        return
    for omega in t.frequencies(3):
        facts = t.case.facts(omega)
        assert is_transparent(found.evaluation, omega) == all(facts[part].excess <= 0 for part in PARTS), omega


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
        old = t.value([t.case.felt, *t.case.between][at[0]].values[at[1]])
        case = t.moved(knob.path, Fraction(value) / old - 1)  # the double that was swept, exactly
        assert case is not None
        if isinstance(t, Late):  # as many as signs change between neighbours, or more
            above = {part: case.facts(scan.grid(case), scan.FLOATS).excess[part] > 0 for part in PARTS}
            for part in PARTS:
                count = int(data[f"crossings_{part}"][i])
                assert count == -1 or count >= np.count_nonzero(above[part][1:] != above[part][:-1]), (knob.path, value)
            continue
        for part in PARTS:
            count = int(data[f"crossings_{part}"][i])
            assert count in (-1, case.counts[part]), (knob.path, value, part, count)


def cost(t: Trial) -> None:
    """80 digits of the equations of motion tell how right floats are."""
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


@dataclass(frozen=True)
class Loop(Trial):
    """A spring and damper behind a delay and perhaps a lag, held by a hand: the argument of one entire function is followed around Re s > 0."""

    def drawn(self) -> list[float]:
        """k, b, tau, omega_c (0: no lag), and the hand's m, b, k."""
        pick = scan.Draw(self.seed)
        lag = float(pick.decades(0.5, 2.5)) if self.seed % 3 else 0.0
        return [float(pick.decades(*x)) for x in ((1, 3), (-1, 1), (-3, -0.5))] + [
            lag,
            *(float(pick.decades(*x)) for x in ((-1, 1), (-0.5, 1.5), (0, 3))),
        ]

    @cached_property
    def text(self) -> str:
        k, b, tau, lag, m, B, K = self.drawn()
        filtered = f'[[effects]]\nmodel = "first-order-lag"\nomega_c = "{lag!r}"\n' if lag else ""
        return (
            f'[environment]\nmodel = "kelvin-voigt"\nk = "{k!r}"\nb = "{b!r}"\n{filtered}[[effects]]\nmodel = "delay"\n'
            f'tau = "{tau!r}"\n[hand]\nm = "{m!r}"\nb = "{B!r}"\nk = "{K!r}"\n[evaluation]\nband = ["0", "20"]\n'
        )

    def count(self) -> int | None:
        """Roots on the right; None where the way around is too near to one."""
        k, b, tau, lag, m, B, K = self.drawn()

        def f(s: Any) -> Any:
            return (k + b * s) * np.exp(-s * tau) + (m * s * s + B * s + K) * (1 + s / lag if lag else 1)

        return winding(f, 2 * max((b + B) / m, ((k + K) / m) ** 0.5, lag, 1 / tau))


def loop(t: Trial) -> None:
    """How often a function winds around 0 counts the roots of a loop with a delay."""
    assert isinstance(t, Loop)
    expected, found = t.count(), hs.stability(t.scene).held[0]
    if expected is not None and found.unstable is not None:
        assert found.unstable == expected


@dataclass(frozen=True)
class Sampled(Trial):
    """A wall that a computer renders, a device and a hand: the eigenvalues of the state that is sampled."""

    def drawn(self) -> dict[str, Any]:
        pick = scan.Draw(self.seed)
        scales = {
            "k": (1, 4),
            "b": (-1, 1.5),
            "T": (-3.3, -1.5),
            "md": (-1, 0.5),
            "bd": (-1, 0.5),
            "m": (-1, 1),
            "B": (-1, 1),
            "K": (0, 3),
        }
        return {name: float(pick.decades(*x)) for name, x in scales.items()} | {"delay": pick.random.randint(0, 2)}

    @cached_property
    def text(self) -> str:
        p = self.drawn()
        return (
            f'[environment]\nmodel = "kelvin-voigt"\nk = "{p["k"]!r}"\nb = "{p["b"]!r}"\n[[effects]]\nmodel = "sampled-loop"\nT = "{p["T"]!r}"\n'
            f'method = "backward-difference"\ndelay = {p["delay"]}\n[[effects]]\nmodel = "shunt"\nm = "{p["md"]!r}"\nb = "{p["bd"]!r}"\n'
            f'[hand]\nm = "{p["m"]!r}"\nb = "{p["B"]!r}"\nk = "{p["K"]!r}"\n[evaluation]\nband = ["0", "20"]\n'
        )

    def sizes(self) -> Any:
        """Of the eigenvalues: position and velocity over a period under a constant force, and the positions that the computer remembers."""
        p = self.drawn()
        mass, damping = p["m"] + p["md"], p["B"] + p["bd"]
        plant = np.array([[0, 1, 0], [-p["K"] / mass, -damping / mass, -1 / mass], [0, 0, 0]])
        over = expm(plant * p["T"])
        n = 2 + p["delay"] + 1  # x, v, and the positions at the last samples
        step = np.zeros((n, n))
        seen = [0, *range(2, n)]  # x now, one sample ago, ...
        step[:2, :2] = over[:2, :2]
        step[:2, seen[p["delay"]]] += over[:2, 2] * (p["k"] + p["b"] / p["T"])
        step[:2, seen[p["delay"] + 1]] -= over[:2, 2] * p["b"] / p["T"]
        step[2, 0] = 1
        step[range(3, n), range(2, n - 1)] = 1
        return np.abs(np.linalg.eigvals(step))


def sampled(t: Trial) -> None:
    """Eigenvalues outside the unit circle."""
    assert isinstance(t, Sampled)
    sizes, found = t.sizes(), held(t.scene, t.scene.hands[0])
    if found.unstable is not None and (abs(sizes - 1) > 1e-8).all():
        assert found.unstable == np.count_nonzero(sizes > 1), sizes


class Measured(Trial):
    """A measured response with a disc around each value: a verdict is one where no value of the disc says otherwise."""

    @cached_property
    def lines(self) -> list[tuple[float, complex, float]]:
        pick = scan.Draw(self.seed).random
        found = []
        for n in range(12):
            omega = 1.0 + n
            H = complex(100 - 1.8 * omega**2, 15 * omega)
            found.append(
                (omega, H * complex(1 + pick.gauss(0, 0.1), pick.gauss(0, 0.1)), pick.uniform(0, 0.05) * abs(H))
            )
        return found

    @property
    def table(self) -> str:
        rows = [f"{w!r},{H.real!r},{H.imag!r},{r!r}" for w, H, r in self.lines]
        return "\n".join(["omega,real,imag,radius", *rows])

    @cached_property
    def text(self) -> str:
        return (
            '[environment]\nmodel = "mass-spring-damper"\nm = "1.8 kg"\nb = "15 N*s/m"\nk = "100 N/m"\n'
            '[perceived]\nfile = "lines.csv"\n[evaluation]\nband = ["0 rad/s", "20 rad/s"]\njnd = 0.1\n'
        )


def measured(t: Trial) -> None:
    """Complex arithmetic, line by line."""
    assert isinstance(t, Measured)
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "lines.csv").write_text(t.table, encoding="utf-8")
        (Path(folder) / "scene.toml").write_text(t.text, encoding="utf-8")
        found = hs.evaluate(Path(folder) / "scene.toml")
    for x, (w, H, r) in zip(found.rows, t.lines, strict=True):
        env = complex(100 - 1.8 * w * w, 15 * w)
        for told, off in ((x.real, (H - env).real), (x.imag, (H - env).imag)):
            least, most = abs(off) - r, abs(off) + r
            true = "exceeds" if least > 0.1 * abs(env) else "below" if most <= 0.1 * abs(env) else "unresolved"
            if min(abs(least / abs(env) - 0.1), abs(most / abs(env) - 0.1)) > 1e-9:
                assert told.value == true, (w, told, true)
    json.loads(found.to_json(), parse_constant=_refused)


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
    exact = [complex(t.dynamics(digits_of(Fraction(w)))[1]) for w in omega]
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
        evaluate, derive, effects, require, stability, sensitivity, tolerances, peaks, metrics, certificate, sweep, simulate,
        cost, jnd, identify, loop, sampled, measured,
    )
}  # fmt: skip
"""``scenes`` and ``schemas`` ask nothing of a random scene that an oracle could tell."""
LATE = (
    "evaluate",
    "derive",
    "effects",
    "require",
    "sensitivity",
    "tolerances",
    "metrics",
    "certificate",
    "sweep",
    "simulate",
)
OTHERS: tuple[tuple[type[Trial], str], ...] = ((Loop, "loop"), (Sampled, "sampled"), (Measured, "measured"))
EVERY = {"sweep": 2, "cost": 2, "jnd": 2, "identify": 2, "simulate": 4, "tolerances": 2, "derive": 2}
"""What takes longest is asked of every so manieth scene."""


def trial_of(seed: int) -> tuple[Trial, tuple[str, ...]]:
    """The scene of a seed, and what it is asked."""
    if seed % 4 < 2:
        return Trial(seed), tuple(x for x in VERBS if x not in {name for _, name in OTHERS})
    if seed % 4 == 2:
        return Late(seed), LATE
    kind, verb = OTHERS[seed // 4 % len(OTHERS)]
    return kind(seed), (verb,)


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


def run(first: int, seconds: float, verbs: list[str], most: int, folder: Path) -> tuple[int, Counter[tuple[str, str]]]:
    """From a seed on, until the time is over or there were so many: the next seed, and how often what came out."""
    tally, seed, end = Counter[tuple[str, str]](), first, time.monotonic() + seconds
    while time.monotonic() < end and seed < first + most:
        trial, asked_for = trial_of(seed)
        for verb in asked_for:
            if verb not in verbs or (len(verbs) > 1 and seed // 4 % EVERY.get(verb, 1)):
                continue
            how, what = asked(verb, trial)
            tally[verb, how] += 1
            if how == "wrong":
                again = f"python -m tests.fuzz --seed {seed} --only {verb} --count 1"
                print(
                    f"seed {seed}, {verb}: {what}\n  again: {again}\n  scene: {kept(trial, verb, what, again, folder)}",
                    flush=True,
                )
            if time.monotonic() > end:
                break
        seed += 1
    return seed, tally


def kept(trial: Trial, verb: str, what: str, again: str, folder: Path) -> Path:
    """The scene as a file that the command line takes, with what was wrong."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{verb}-{trial.seed}.toml"
    words = "".join(f"# {line}\n" for line in (*what.splitlines(), again))
    path.write_text(words + trial.text, encoding="utf-8")
    if isinstance(trial, Measured):
        (folder / "lines.csv").write_text(trial.table, encoding="utf-8")
    return path


def main(words: list[str] | None = None) -> int:
    """The command line; the exit status."""
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz", description=__doc__)
    parser.add_argument("--minutes", type=float, default=1.0)
    parser.add_argument("--seed", type=int, default=0, help="the first")
    parser.add_argument("--count", type=int, default=10**9, help="of scenes at most")
    parser.add_argument("--only", choices=VERBS, action="append", help="this verb alone; may be repeated")
    parser.add_argument(
        "--keep", type=Path, default=Path("build") / "fuzz", help="a folder for the scenes with wrong answers"
    )
    given = parser.parse_args(words)
    after, tally = run(given.seed, 60 * given.minutes, given.only or list(VERBS), given.count, given.keep)
    for verb in VERBS:
        told = ", ".join(f"{n} {how}" for (name, how), n in sorted(tally.items()) if name == verb)
        print(f"{verb:12} {told or 'not asked'}")
    wrong = sum(n for (_, how), n in tally.items() if how == "wrong")
    print(f"seeds {given.seed} to {after - 1}, {wrong} wrong")
    return bool(wrong)


if __name__ == "__main__":
    sys.exit(main())
