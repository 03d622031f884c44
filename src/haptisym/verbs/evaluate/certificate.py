"""The certificate of an evaluation: its claim, with a proof that another program can check.

Rational numbers between everything that happens on a band, so close that signs of coefficients show that nothing else does.

Whether a certificate is one for which a checker works long enough (docs/certificates.md, "Limits").

What shows how many zeros a function of s has in Re s >= 0: where the real and the imaginary part on the axis change sign.

The certificate of an evaluation: its claim, with a proof that another program can check (docs/certificates.md).
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Iterable, Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise
from math import prod
from typing import Any

import flint
from flint import fmpz_poly
from sympy import I, Rational, pi

from haptisym.judge.crossings import Curve, curves
from haptisym.judge.evaluation import Evaluation
from haptisym.judge.percepts import find_percepts
from haptisym.kernel.budget import tick
from haptisym.kernel.dynamics import RealFunction, Ring
from haptisym.kernel.errors import SceneError, UndecidedError
from haptisym.kernel.reals import ExactNumber, RealNumber, Sliver, bounds, rational_between
from haptisym.kernel.rings import RationalFunction
from haptisym.kernel.roots import Interval, Point
from haptisym.model.scene import Scene
from haptisym.model.scenefile import read_scenes
from haptisym.verbs.evaluate.products import Factor, Factors, Linked, Rows, WaveFactor, products, rectangular, told_rows

_MOST = 2000


def breakpoints(places: Sequence[RealNumber], factors: Sequence[Factor | WaveFactor]) -> list[Fraction]:
    """Ascending, from the low end of the band (or a little below) to its high end (or a little above).

    ``places`` : the ends of the band and all zeros of the factors between them, in order. In each cell at most one factor has a
    variation of sign (Descartes), and that one only. UndecidedError where so many cells as a certificate may have are not enough.
    """
    ends = [_exact(places[0]), _exact(places[-1])]
    inner = [_fraction(rational_between(a, b)) for a, b in pairwise(places[1:-1])]
    if len(places) > 2 or None in ends:
        first = [] if ends[0] is not None else [_fraction(rational_between(places[0], places[1]))]
        last = [] if ends[1] is not None else [_fraction(rational_between(places[-2], places[-1]))]
        inner = sorted({*first, *inner, *last})
    low, high = _beside(places[0], -1), _beside(places[-1], 1)
    found, waiting, asked = [low], [high, *inner[::-1]], [*factors]
    while waiting:
        tick()
        if _is_told(asked, found[-1], waiting[-1]):
            found.append(waiting.pop())
        elif len(found) + len(waiting) < _MOST:
            waiting.append(_between(factors, found[-1], waiting[-1]))
        else:
            raise UndecidedError("a certificate: it would take too many cells")
    return found


def _exact(place: RealNumber) -> Fraction | None:
    value = place.value if isinstance(place, ExactNumber) else None
    return Fraction(int(value.p), int(value.q)) if value is not None and value.is_Rational else None


def _beside(end: RealNumber, side: int) -> Fraction:
    """An end of the band, or a rational number a little beyond it."""
    exact = _exact(end)
    if exact is not None:
        return exact
    return Fraction(end.enclosure()[side > 0])


def _is_told(factors: list[Factor | WaveFactor], low: Fraction, high: Fraction) -> bool:
    """Whether signs show that there is at most one zero in a cell, of one factor; one that fails is asked first again."""
    turns = 0
    for i, factor in enumerate(factors):
        signs = factor.moved(low, high)
        if signs is None:
            factors.insert(0, factors.pop(i))
            return False
        turns += sum(a != b for a, b in pairwise(x for x in signs if x))
    return turns < 2


def _between(factors: Sequence[Factor | WaveFactor], low: Fraction, high: Fraction) -> Fraction:
    """A number well inside, at which no factor vanishes."""
    flat = {*factors}
    for n in range(2, 100):
        middle, reach = low + (high - low) / n, (high - low) / (4 * n)
        point = _fraction(rational_between(*(Sliver(x, x) for x in (middle - reach, middle + reach))))
        flat -= {factor for factor in flat if factor.sign_at(point)}
        if not flat and all(factor.sign_at(point) for factor in factors):
            return point
    if flat:
        raise SceneError(
            "a certificate has no room for functions that are zero everywhere because of what an order is, as Re s^0.5 s^0.5"
        )
    raise UndecidedError("a number at which no polynomial of a certificate vanishes")


def _fraction(x: Rational) -> Fraction:
    return Fraction(int(x.p), int(x.q))


_FORMULA = re.compile(r"""\b[A-Z]["']?\s*=\s*("{3}|'{3}|["'])(.*?)\1""", re.DOTALL)
_BROKEN = re.compile(r"\bs\s*(\^|\*\*)[\s(+-]*[0-9]*\.")  # a power of s that is not whole
_MOST_CHECKABLE = (
    10**7
)  # no scene of the package needs more than two thirds of it; some three times as much may be refused


def need_checkable(certificate: str, proof: dict[str, Any], scene: str) -> None:
    """SceneError where a checker refuses the certificate of a scene.

    It is asked where its work may be beyond its limits, and where a formula has powers of s: it may not see that they cancel.
    """
    powers = any(_BROKEN.search(found[2]) for found in _FORMULA.finditer(scene))
    if not powers and _points(proof) * len(certificate) <= _MOST_CHECKABLE:
        return
    from haptisym_check import RefusedError, check  # it is asked of few scenes

    try:
        check(certificate.encode(), scene.encode())
    except RefusedError as error:
        raise SceneError(f"no checker accepts a certificate of this scene: {error}") from None


def _points(proof: dict[str, Any]) -> int:
    """About so many has the grid on which it is shown that the functions are those of the scene."""
    if "functions" not in proof:
        return 0
    factors, count = [_degrees(x) for x in proof["factors"]], 2 + len(proof.get("delays", ()))
    sides = [
        [(abs(n), factors[i]) for i, n in told["powers"] if n * side > 0]
        for told in proof["functions"].values()
        for side in (1, -1)
    ]
    places = range(max(map(len, factors), default=0))
    most = [max(sum(n * own[v] for n, own in row if v < len(own)) for row in sides) + 1 for v in places]
    corners = [n * (n + 1) // 2 for n in most[count:]]
    return int(prod(most[:count] + corners))


def _degrees(factor: dict[str, Any]) -> Sequence[int]:
    """In omega, in pi, in the tangent of each delay, in the two parts of each power together."""
    terms = factor.get("terms") or [[[], factor["polynomial"]]]
    waves = factor.get("waves", [])
    high = factor.get("step", 1) * (max(len(p) for _, p in terms) - 1), max(len(row) for _, p in terms for row in p) - 1
    powers = range(len(waves), len(terms[0][0]), 2)
    return [*high, *waves, *(max(sum(turns[i : i + 2]) for turns, _ in terms) for i in powers)]


_BITS = 128  # of roots that only say where to look: what is found is checked
_MOST_ZEROS = 300


def zeros(function: RationalFunction) -> dict[str, Any]:
    """A function in lowest terms as a product of factors, with cells in which the turns of each can be counted.

    SceneError where it is no quotient of polynomials with real coefficients, UndecidedError where the cells do not suffice.
    """
    ring = function.ring
    assert isinstance(ring, Ring)
    if any(
        any(p.degrees()[i] for p in (function.numerator, function.denominator))
        for i, x in enumerate(ring.meanings)
        if x == I
    ):
        raise SceneError(
            "a certificate about poles needs real coefficients: the describing function of friction has none"
        )
    if function.denominator.is_zero() or function.numerator.is_zero():
        raise SceneError(
            "a certificate about poles and roots needs a display that is felt: its force is zero everywhere"
        )
    factors = Factors()
    product = factors.quotient(ring, function.numerator, function.denominator, in_square=False)
    above = {i for i, n in product["powers"] if n > 0}
    return {
        "factors": [told_rows(f.rows) for f in factors.listed],
        "function": product,
        "cells": [[str(x) for x in _cells(f.rows)] if i in above else [] for i, f in enumerate(factors.listed)],
    }


def _cells(rows: Rows) -> list[Fraction]:
    """Numbers of omega^2, ascending, between which E or O of p(j omega) = E + j omega O has one zero, or E none."""
    if not any(rows[0]):
        return []  # s itself
    halves = (tuple(tuple(n * (-1) ** k for n in row) for k, row in enumerate(rows[i::2])) for i in (0, 1))
    even, odd = (Factor(x or ((0,),), 1) for x in halves)
    places = sorted([*_positive(even), *_positive(odd)], key=lambda x: x.bounds(0)[0])
    between = (rational_between(a, b) for a, b in pairwise(places))
    found, waiting = [Fraction(0)], [None, *[Fraction(int(x.p), int(x.q)) for x in between][::-1]]
    while waiting:
        tick()
        low, high = found[-1], waiting[-1]
        if _is_told_in_zeros(even, odd, low, high):
            waiting.pop()
            found += [] if high is None else [high]
        elif len(found) + len(waiting) < _MOST_ZEROS:
            waiting.append(_between_in_zeros(even, low, high))
        else:
            raise UndecidedError(
                "a certificate: the real or the imaginary part of p(j omega) has zeros that cells do not part, as a double one"
            )
    return found[1:]


def _between_in_zeros(even: Factor, low: Fraction, high: Fraction | None) -> Fraction:
    """A number at which E does not vanish: no cell can end where it does."""
    tried = [2 * low + n - 1 if high is None else low + (high - low) / n for n in range(2, 2 + len(even.rows))]
    return next(filter(even.sign_at, tried), tried[0])


def _is_told_in_zeros(even: Factor, odd: Factor, low: Fraction, high: Fraction | None) -> bool:
    """E is not zero at ``low``: 0, or where a cell ended."""
    own, other = even.moved(low, high), odd.moved(low, high)
    if own is None or other is None or not (own[-1] or high is None):
        return False
    turns, others = (sum(a != b for a, b in pairwise(x for x in signs if x)) for signs in (own, other))
    return turns == 0 or turns + others == 1


def _positive(factor: Factor) -> Sequence[RealNumber]:
    """The positive zeros, nearly."""
    plain = factor.bounds[0]
    if plain.degree() < 1:
        return []
    with flint.ctx.workprec(_BITS):
        roots = [
            z.real for z, _ in fmpz_poly(plain.numer().coeffs()).complex_roots() if z.imag.contains(0) and z.real > 0
        ]
        return [Sliver(*bounds(x)) for x in roots]


FORMAT = "haptisym.certificate/1"
_MOST_WORK = 5 * 10**9  # of a checker, in bits times cost
_MOST_DIGITS = 1000  # of an enclosure: a checker need not read many more
_MOST_BESIDE_PI = 90  # a checker knows 100 of pi
_MOST_AMONG_WAVES = 50  # where there are delays or powers: a checker computes with 80

_NAMES = {
    Curve.ENVIRONMENT: "environment",
    Curve.PERCEIVED: "perceived",
    Curve.DIFFERENCE: "difference",
    Curve.SUM: "sum",
}


def certificate(e: Evaluation) -> str:
    """The document of JSON. SceneError, a sentence, where the format has no room for the scene or the answer.

    >>> from haptisym.verbs.evaluate.entry import evaluate
    >>> json.loads(certificate(evaluate("fu2019")))["claim"]["crossings"][0]
    {'at': 5, 'part': 'real', 'kind': 'exceeds', 'sign': 1, 'multiplicity': 1}
    """
    scene = e.scene
    if e.relevance is not None:
        raise SceneError("a certificate is about all effects of a scene: ask for it without a tolerance")
    environment = named(scene)
    functions = _functions(e)
    linked = products(functions)
    frequencies = _enclosures(e, _room(e, linked))
    inner = [Sliver(Fraction(x), Fraction(y)) for x, y in frequencies[1:-1]]
    points = breakpoints([e.chart.points[0].omega, *inner, e.chart.points[-1].omega], linked.factors)
    _afford(points, [x for pair in frequencies for x in pair], [f.cost for f in linked.factors])
    about_poles = _poles(e)
    claim = {"frequencies": frequencies} | _claim(e) | {"stable": None if about_poles is None else e.stable}
    proof = {
        "delays": [str(x) for x in linked.delays],
        "orders": [str(x) for x in linked.orders],
        "breakpoints": [str(x) for x in points],
        "factors": [f.told() for f in linked.factors],
        "functions": linked.told,
        "poles": about_poles,
    }
    return document(scene, environment, {"question": "evaluation"} | claim, proof)


def _room(e: Evaluation, linked: Linked) -> int:
    """How many digits of a frequency may have."""
    if linked.delays or linked.orders:
        return _MOST_AMONG_WAVES
    has_pi = any(isinstance(f, Factor) and len(f.bounds) > 1 for f in linked.factors)
    return _MOST_BESIDE_PI if has_pi or any(x.has(pi) for x in e.scene.band) else _MOST_DIGITS


def _afford(points: Sequence[Fraction], ends: Sequence[str], costs: Sequence[int]) -> None:
    """SceneError where a checker would refuse to find so many signs."""
    for numbers, cost in ((points, sum(costs)), (map(Fraction, ends), max(costs, default=0) // 10)):
        afford(numbers, cost)


def afford(numbers: Iterable[Fraction], cost: int) -> None:
    """SceneError where signs at so many numbers, with that cost for each bit, take a checker too long."""
    if sum(x.numerator.bit_length() + x.denominator.bit_length() for x in numbers) * cost >= _MOST_WORK:
        raise SceneError(TOO_LONG)


TOO_LONG = "a certificate of this scene would take a checker too long"


def _poles(e: Evaluation) -> dict[str, Any] | None:
    """Those of H_perc in Re s >= 0; None where they are not decided, or no certificate has room for them."""
    try:
        return None if e.stable is None else zeros(inverse(e.distortion.perc))
    except (SceneError, UndecidedError):
        return None


def inverse(x: RationalFunction) -> RationalFunction:
    """1/x, whose zeros are the poles of x."""
    return RationalFunction(x.ring, x.denominator, x.numerator)


def document(scene: Scene, environment: str | None, claim: dict[str, Any], proof: dict[str, Any]) -> str:
    """A certificate of any question, as JSON. SceneError where no checker would accept it."""
    told = {
        "format": FORMAT,
        "scene_sha256": hashlib.sha256(scene.text.encode()).hexdigest(),
        "environment": environment,
        "claim": claim,
        "proof": proof,
    }
    text = json.dumps(told, ensure_ascii=False)
    need_checkable(text, proof, scene.text)
    return text


def named(scene: Scene) -> str | None:
    """Which of several environments it is of the file that it was read from. SceneError where a checker cannot read that."""
    scene.threshold.need_plain("a certificate")
    return named_in_file(scene)


def named_in_file(scene: Scene) -> str | None:
    """Likewise, whatever the JND."""
    if scene.threshold.source:
        name = scene.threshold.source
        raise SceneError(f'a certificate needs the threshold as a number in the scene file, not by the name "{name}"')
    if not scene.text:
        raise SceneError("a certificate is about a scene file: write the scene to one, and evaluate that")
    family = read_scenes(scene.text)
    for name, one in family.scenes.items():
        if replace(one, title="", hands=()) == replace(scene, title="", hands=()):
            return name if len(family) > 1 or "[[environments]]" in scene.text else None
    raise SceneError("a certificate is about a scene as its file has it: this one was changed since it was read")


def _functions(e: Evaluation) -> dict[str, RealFunction]:
    found: dict[str, RealFunction] = {}
    for key, f in curves(rectangular(e.distortion), e.criteria).items():
        if not isinstance(f, RealFunction):
            raise SceneError("a certificate needs thresholds that are rational, or rational in pi")
        if isinstance(key, tuple):
            curve, part = key
            found[f"{_NAMES[curve]}.{part.value}"] = f
        else:
            found[f"excess.{key.name}"] = f  # type: ignore[attr-defined]
    return found


def _claim(e: Evaluation) -> dict[str, Any]:
    """What the evaluation answers, each frequency by its place among all at which something happens."""
    points = e.chart.points
    place = {id(point.omega): i for i, point in enumerate(points)}

    def at(point: Point) -> int:
        return place[id(point.omega)]

    def ends(intervals: Sequence[Interval]) -> list[list[int]]:
        return [[at(x.low), at(x.high)] for x in intervals]

    return {
        "crossings": [
            {"at": place[id(x.omega)], "part": x.criterion.name}
            | {"kind": x.kind.value, "sign": x.sign, "multiplicity": x.multiplicity}
            for x in e.crossings
        ],
        "transparent": ends(e.transparent),
        "changeovers": {
            "environment": [at(x) for x in e.changeovers_environment],
            "perceived": [at(x) for x in e.changeovers_perceived],
        },
        "percepts": [
            {"part": x.part.value, "from": at(x.band.low), "to": at(x.band.high)}
            | {"property": x.property.value, "change": x.change.value}
            for x in find_percepts(e.chart)  # of friction the property alone is another
            if x.part
        ],
        "outside_model": ends(e.outside_model),
        "unbounded": [at(x) for x in e.unbounded],
    }  # fmt: skip


def _enclosures(e: Evaluation, most: int) -> list[list[str]]:
    """Of all places, with as many digits as were asked for, or more where that does not tell them apart."""
    digits = e.digits
    if digits > most:
        raise SceneError(f"a certificate has room for {most} digits of a frequency, not for {digits}")
    while True:
        found = [list(point.omega.enclosure(digits)) for point in e.chart.points]
        if all(Fraction(a[1]) < Fraction(b[0]) for a, b in pairwise(found)):
            return found
        digits *= 2
