"""Certificates: claims with proofs that another program can check (docs/certificates.md).

A certificate is a document of JSON with the hash of a scene's file, a claim and its proof;
``document`` writes it for each question (those of ``require`` and ``stability`` stand with these
verbs). The proof of an evaluation are its functions as
``products`` and ``breakpoints``: rational numbers so close that in the cells between them signs of
coefficients show that nothing else happens. That of poles and roots are ``zeros``: a function of s
as a product, and cells in which its turns on the axis can be counted.

Whether a cell shows what it must is asked of the checker's own objects, of ``haptisym_check``: so
there are no second signs here that could differ from those by which a certificate is accepted. The
checker itself takes nothing from this package.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise
from math import prod
from typing import Any

import flint
from flint import fmpz_poly
from sympy import I, pi

from haptisym.judge.crossings import PerceptFunction, curves
from haptisym.judge.evaluation import Evaluation
from haptisym.judge.percepts import find_percepts
from haptisym.kernel.budget import Waiting
from haptisym.kernel.dynamics import RealFunction, Ring
from haptisym.kernel.errors import SceneError, UndecidedError
from haptisym.kernel.reals import ExactNumber, RealNumber, Sliver, bounds, rational_between
from haptisym.kernel.rings import RationalFunction
from haptisym.kernel.roots import Interval, Point
from haptisym.model.scene import Scene
from haptisym.model.scenefile import read_scenes
from haptisym.verbs.evaluate.products import Factors, Linked, products, rectangular
from haptisym_check import RefusedError, check
from haptisym_check.polynomials import OmegaFactor, affordable, signs, sliced, turns

FORMAT = "haptisym.certificate/1"
TOO_LONG = "a certificate of this scene would take a checker too long"


# The document


def document(
    scene: Scene, claim: dict[str, Any], proof: dict[str, Any], linked: Linked | None = None
) -> str:
    """A certificate of any question, as JSON. SceneError where no checker would accept it.

    ``linked`` : the functions of the proof, if there are such.
    """
    told = {
        "format": FORMAT,
        "scene_sha256": hashlib.sha256(scene.text.encode()).hexdigest(),
        "environment": name_in_file(scene),
        "claim": claim,
        "proof": proof,
    }
    text = json.dumps(told, ensure_ascii=False)
    if has_broken_powers(scene.text) or (linked and _points(linked) * len(text) > _MOST_CHECKABLE):
        try:
            check(text.encode(), scene.text.encode())
        except RefusedError as error:
            raise SceneError(f"certificate: too large for the checker: {error}") from None
    return text


_FORMULA = re.compile(r"""\b[A-Z]["']?\s*=\s*("{3}|'{3}|["'])(.*?)\1""", re.DOTALL)
_BROKEN = re.compile(r"\bs\s*(\^|\*\*)[\s(+-]*[0-9]*\.")  # a power of s that is not whole
_MOST_CHECKABLE = (
    10**7
)  # no shipped scene needs more than two thirds of it; some three times as much may be refused


def has_broken_powers(scene: str) -> bool:
    """Whether formulas of a scene's text hold powers of s that are not whole: a checker may not see
    that they cancel."""
    return any(_BROKEN.search(found[2]) for found in _FORMULA.finditer(scene))


def _points(linked: Linked) -> int:
    """About so many has the grid on which it is shown that the functions are those of the scene."""
    degrees = [x.degrees for x in linked.factors]
    powers = [
        [(abs(n), degrees[i]) for i, n in told["powers"] if n * side > 0]
        for told in linked.told.values()
        for side in (1, -1)
    ]
    most = [
        max(sum(n * own[v] for n, own in row) for row in powers) + 1
        for v in range(min(map(len, degrees), default=0))
    ]
    count = 2 + len(linked.delays)  # of each power Re and Im together
    found: int = prod(most[:count]) * prod(n * (n + 1) // 2 for n in most[count:])
    return found


def name_in_file(scene: Scene) -> str | None:
    """Which of several environments it is of the file that it was read from. SceneError where a
    checker cannot read that."""
    scene.threshold.need_plain("a certificate")
    if scene.threshold.source:
        name = scene.threshold.source
        raise SceneError(
            f'certificate: write the JND as a number in the scene file, not like = "{name}"'
        )
    if not scene.text:
        raise SceneError("certificate: write the scene to a file, and evaluate that")
    family = read_scenes(scene.text)
    for name, one in family.scenes.items():
        if replace(one, title="", hands=()) == replace(scene, title="", hands=()):
            return name if len(family) > 1 or "[[environments]]" in scene.text else None
    raise SceneError(
        "certificate: the scene was changed since its file was read: write it to a file, and "
        "evaluate that"
    )


def shown(ask: Callable[..., Any], *given: Any) -> Any:
    """What the checker finds; None where it refuses."""
    try:
        return ask(*given)
    except RefusedError:
        return None


def afford(numbers: Iterable[Fraction], cost: int) -> None:
    """SceneError where signs at so many numbers, with that cost for each bit, take a checker too
    long."""
    try:
        affordable(numbers, cost)
    except RefusedError:
        raise SceneError(TOO_LONG) from None


# Cells of a band


def breakpoints(places: Sequence[RealNumber], factors: Sequence[OmegaFactor]) -> list[Fraction]:
    """Ascending, from the low end of the band (or a little below) to its high end (or a little
    above).

    ``places`` : the ends of the band and all zeros of the factors between them, in order. In each
    cell at most one factor has a variation of sign (Descartes), and that one only. UndecidedError
    where so many cells as a certificate may have are not enough.
    """
    ends = [_exact(places[0]), _exact(places[-1])]
    inner = [simplest(a, b) for a, b in pairwise(places[1:-1])]
    if len(places) > 2 or None in ends:
        first = [] if ends[0] is not None else [simplest(*places[:2])]
        last = [] if ends[1] is not None else [simplest(*places[-2:])]
        inner = sorted({*first, *inner, *last})
    low, high = _beside(places[0], -1), _beside(places[-1], 1)
    found, waiting, asked = [low], Waiting(pairwise([low, *inner, high])), [*factors]
    for a, b in waiting:
        if _is_shown(asked, a, b):
            found.append(b)
        elif len(found) + len(waiting.rest) < _MOST:
            middle = _between(factors, a, b)
            waiting.add((a, middle), (middle, b))
        else:
            raise UndecidedError("a certificate: it would need too many cells")
    return found


def simplest(low: RealNumber, high: RealNumber) -> Fraction:
    """The simplest rational number between two."""
    found = rational_between(low, high)
    return Fraction(int(found.p), int(found.q))


def _exact(place: RealNumber) -> Fraction | None:
    value = place.value if isinstance(place, ExactNumber) else None
    return Fraction(int(value.p), int(value.q)) if value is not None and value.is_Rational else None


def _beside(end: RealNumber, side: int) -> Fraction:
    """An end of the band, or a rational number a little beyond it."""
    exact = _exact(end)
    if exact is not None:
        return exact
    return Fraction(end.enclosure()[side > 0])


def _is_shown(factors: list[OmegaFactor], low: Fraction, high: Fraction) -> bool:
    """Whether signs show that there is at most one zero in a cell, of one factor; one that fails is
    asked first again."""
    count = 0
    for i, factor in enumerate(factors):
        found = shown(factor.signs, low, high)
        if found is None:
            factors.insert(0, factors.pop(i))
            return False
        count += turns(found[1])
    return count < 2


def _between(factors: Sequence[OmegaFactor], low: Fraction, high: Fraction) -> Fraction:
    """A number well inside, at which no factor vanishes."""
    flat = {*factors}
    for n in range(2, 100):
        middle, reach = low + (high - low) / n, (high - low) / (4 * n)
        point = simplest(*(Sliver(x, x) for x in (middle - reach, middle + reach)))
        flat -= {factor for factor in flat if shown(factor.sign, point)}
        if not flat and all(shown(factor.sign, point) for factor in factors):
            return point
    if flat:
        raise SceneError(
            "certificate: functions that are zero because of the value of an order, as Re "
            "s^0.5 s^0.5, are not in its format"
        )
    raise UndecidedError("a number at which no polynomial of a certificate vanishes")


# Zeros in Re s >= 0


_BITS = 128  # of roots that only say where to look: what is found is checked
_MOST_ZEROS = 300


def zeros(function: RationalFunction) -> dict[str, Any]:
    """A function in lowest terms as a product of factors, with cells in which the turns of each can
    be counted.

    SceneError where it is no quotient of polynomials with real coefficients, UndecidedError where
    the cells do not suffice.
    """
    ring = function.ring
    assert isinstance(ring, Ring)
    if any(
        any(p.degrees()[i] for p in (function.numerator, function.denominator))
        for i, x in enumerate(ring.meanings)
        if x == I
    ):
        raise SceneError(
            "certificate: claims about poles need real coefficients, and coulomb-friction "
            "has none: leave it out"
        )
    if function.denominator.is_zero() or function.numerator.is_zero():
        raise SceneError(
            "certificate: the force is zero everywhere, so that there are no poles to claim"
        )
    factors = Factors()
    product = factors.quotient(ring, function.numerator, function.denominator)
    above = {i for i, n in product["powers"] if n > 0}
    rows = [json.loads(x)["polynomial"] for x in factors.listed]
    cells = [[str(x) for x in _cells(x)] if i in above else [] for i, x in enumerate(rows)]
    return {"factors": rows, "function": product, "cells": cells}


def inverse(x: RationalFunction) -> RationalFunction:
    """1/x, whose zeros are the poles of x."""
    return RationalFunction(x.ring, x.denominator, x.numerator)


def _cells(polynomial: Sequence[Sequence[str]]) -> list[Fraction]:
    """Numbers of omega^2, ascending, between which E or O of p(j omega) = E + j omega O has one
    zero, or E none."""
    rows = [[int(c) for c in row] for row in polynomial]
    if not any(rows[0]):
        return []  # s itself
    even, odd = (
        sliced([[c * (-1) ** k for c in row] for k, row in enumerate(rows[i::2])] or [[0]])
        for i in (0, 1)
    )
    places = sorted([*_positive(even[0]), *_positive(odd[0])], key=lambda x: x.bounds(0)[0])
    found, between = [Fraction(0)], [simplest(a, b) for a, b in pairwise(places)]
    waiting: Waiting[tuple[Fraction, Fraction | None]] = Waiting(
        zip([found[0], *between], [*between, None], strict=True)
    )
    for low, high in waiting:
        if _turns_are_shown(even, odd, low, high):
            found += [] if high is None else [high]
        elif len(found) + len(waiting.rest) < _MOST_ZEROS:
            tried = [
                2 * low + n - 1 if high is None else low + (high - low) / n
                for n in range(2, 2 + len(even[0]))
            ]
            middle = next(
                (x for x in tried if any((_signs(even, x, None) or [0])[:1])), tried[0]
            )  # E is not zero
            waiting.add((low, middle), (middle, high))
        else:
            raise UndecidedError("a certificate: whether zeros of Re or Im p(j omega) are distinct")
    return found[1:]


def _signs(slices: list[list[int]], low: Fraction, high: Fraction | None) -> list[int] | None:
    """Of the coefficients in a cell; None where they stay open."""
    found: list[int] | None = shown(
        signs, slices, low.as_integer_ratio(), high.as_integer_ratio() if high else (1, 0)
    )
    return found


def _turns_are_shown(
    even: list[list[int]], odd: list[list[int]], low: Fraction, high: Fraction | None
) -> bool:
    """E is not zero at ``low``: 0, or where a cell ended."""
    own, other = _signs(even, low, high), _signs(odd, low, high)
    if own is None or other is None or not (own[0] and (own[-1] or high is None)):
        return False
    return turns(own) == 0 or turns(own) + turns(other) == 1


def _positive(plain: Sequence[int]) -> list[RealNumber]:
    """The positive zeros of a polynomial, nearly."""
    with flint.ctx.workprec(_BITS):
        found = fmpz_poly(list(plain)).complex_roots() if any(plain[1:]) else []
        return [Sliver(*bounds(z.real)) for z, _ in found if z.imag.contains(0) and z.real > 0]


# An evaluation


_MOST = 2000  # cells
_MOST_DIGITS = 1000  # of an enclosure: a checker need not read many more
_MOST_BESIDE_PI = 90  # a checker knows 100 of pi
_MOST_AMONG_WAVES = 50  # where there are delays or powers: a checker computes with 80
_NAMES = {
    PerceptFunction.ENVIRONMENT: "environment",
    PerceptFunction.PERCEIVED: "perceived",
    PerceptFunction.DIFFERENCE: "difference",
    PerceptFunction.SUM: "sum",
}


def certificate(e: Evaluation) -> str:
    """The document of JSON. SceneError, a sentence, where the format has no room for the scene or
    the answer.

    >>> from haptisym.verbs.evaluate.entry import evaluate
    >>> json.loads(certificate(evaluate("fu2019")))["claim"]["crossings"][0]
    {'at': 5, 'part': 'real', 'kind': 'exceeds', 'sign': 1, 'multiplicity': 1}
    """
    scene = e.scene
    if e.relevance is not None:
        raise SceneError("certificate: leave out the tolerance, as it is about all effects")
    name_in_file(scene)
    linked = products(_functions(e))
    factors = shown(lambda: linked.factors)
    if factors is None:
        raise SceneError(TOO_LONG)
    frequencies = _enclosures(e, _room(e, linked))
    inner = [Sliver(Fraction(x), Fraction(y)) for x, y in frequencies[1:-1]]
    points = breakpoints([e.chart.points[0].omega, *inner, e.chart.points[-1].omega], factors)
    costs = [x.cost for x in factors]
    afford(points, sum(costs))
    afford((Fraction(x) for pair in frequencies for x in pair), max(costs, default=0) // 10)
    about_poles = _poles(e)
    claim = (
        {"frequencies": frequencies}
        | _claim(e)
        | {"stable": None if about_poles is None else e.stable}
    )
    proof = linked.proof(breakpoints=[str(x) for x in points]) | {"poles": about_poles}
    return document(scene, {"question": "evaluation"} | claim, proof, linked)


def _room(e: Evaluation, linked: Linked) -> int:
    """How many digits of a frequency may have."""
    if linked.delays or linked.orders:
        return _MOST_AMONG_WAVES
    has_pi = any(x.degrees[1] for x in linked.factors) or any(x.has(pi) for x in e.scene.band)
    return _MOST_BESIDE_PI if has_pi else _MOST_DIGITS


def _poles(e: Evaluation) -> dict[str, Any] | None:
    """Those of H_perc in Re s >= 0; None where they are not decided, or no certificate has room for
    them."""
    try:
        return None if e.stable is None else zeros(inverse(e.distortion.perc))
    except (SceneError, UndecidedError):
        return None


def _functions(e: Evaluation) -> dict[str, RealFunction]:
    found: dict[str, RealFunction] = {}
    for key, f in curves(rectangular(e.distortion), e.criteria).items():
        if not isinstance(f, RealFunction):
            raise SceneError("certificate: give a JND that is rational, or rational in pi")
        if isinstance(key, tuple):
            curve, part = key
            found[f"{_NAMES[curve]}.{part.value}"] = f
        else:
            found[f"excess.{key.name}"] = f  # type: ignore[attr-defined]
    return found


def _claim(e: Evaluation) -> dict[str, Any]:
    """What the evaluation answers, each frequency by its place among all at which something
    happens."""
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
    }


def _enclosures(e: Evaluation, most: int) -> list[list[str]]:
    """Of all places, with as many digits as were asked for, or more where that does not tell them
    apart."""
    digits = e.digits
    if digits > most:
        raise SceneError(f"certificate: at most {most} digits, not {digits}")
    while True:
        found = [list(point.omega.enclosure(digits)) for point in e.chart.points]
        if all(Fraction(a[1]) < Fraction(b[0]) for a, b in pairwise(found)):
            return found
        digits *= 2
