"""Certificates: claims with proofs that another program can check (haptisym_check/FORMAT.md).

A certificate is a document of JSON with the hash of a scene's file, a claim and its proof;
``document`` writes it for each question (those of ``require`` and ``stability`` are in the folders
of these). The proof of an evaluation consists of its functions as ``products`` and of
``breakpoints``: rational numbers so close that in the cells between them signs of coefficients
(Descartes' rule) show that nothing else happens. That of poles and roots is ``zeros``: a function
of s as a product, and cells in which its turns on the axis can be counted (the argument principle).

Whether a cell shows what it must is decided by the checker's own objects, of ``haptisym_check``:
there are no second signs here that could differ from those by which a certificate is accepted. The
checker itself imports nothing from this package.
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
from haptisym.model.catalogue import DESCRIBED, FRICTION
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
    content = {
        "format": FORMAT,
        "scene_sha256": hashlib.sha256(scene.text.encode()).hexdigest(),
        "environment": name_in_file(scene),
        "claim": claim,
        "proof": proof,
    }
    text = json.dumps(content, ensure_ascii=False)
    # A checker has limits of its own. Only where one may be reached it is run on the document here,
    # as that takes long.
    if has_broken_powers(scene.text) or (linked and _points(linked) * len(text) > _MOST_CHECKABLE):
        try:
            check(text.encode(), scene.text.encode())
        except RefusedError as error:
            raise SceneError(f"certificate: too large for the checker: {error}") from None
    return text


_FORMULA = re.compile(r"""\b[A-Z]["']?\s*=\s*("{3}|'{3}|["'])(.*?)\1""", re.DOTALL)
_BROKEN = re.compile(r"\bs\s*(\^|\*\*)[\s(+-]*[0-9]*\.")  # a power of s that is not whole
# No shipped scene needs more than two thirds of it; some three times as much may be refused.
_MOST_CHECKABLE = 10**7


def has_broken_powers(scene: str) -> bool:
    """Whether formulas of a scene's text contain powers of s that are not whole: a checker may not
    find that they cancel."""
    return any(_BROKEN.search(found[2]) for found in _FORMULA.finditer(scene))


def _points(linked: Linked) -> int:
    """About how many points the grid has on which a checker compares the functions of the proof
    with those of the scene."""
    # A polynomial that is 0 at one more points than its degree, in each variable, is 0: for each
    # variable the largest degree of any numerator or denominator counts.
    degrees = [x.degrees for x in linked.factors]
    powers = [
        [(abs(n), degrees[i]) for i, n in function["powers"] if n * side > 0]
        for function in linked.told.values()
        for side in (1, -1)
    ]
    most = []
    for variable in range(min(map(len, degrees), default=0)):
        of_sides = (sum(n * of_factor[variable] for n, of_factor in row) for row in powers)
        most.append(max(of_sides) + 1)
    # omega, pi and the delays; then the powers, of each of which Re and Im have a joint degree
    count = 2 + len(linked.delays)
    points: int = prod(most[:count]) * prod(n * (n + 1) // 2 for n in most[count:])
    return points


def name_in_file(scene: Scene) -> str | None:
    """The name of a scene among several environments of its file; None where the file has one
    scene. SceneError where a checker cannot read the scene from that file."""
    scene.threshold.need_plain("a certificate")
    steps = [x.name for x in scene.effects if x.model in DESCRIBED and x.model != FRICTION]
    if steps:
        raise SceneError(
            f"certificate: {', '.join(steps)}: a checker has no arc sines and staircases: leave it "
            f"out of the scene, or the certificate"
        )
    if scene.threshold.source:
        name = scene.threshold.source
        raise SceneError(
            f'certificate: write the JND as a number in the scene file, not like = "{name}"'
        )
    if not scene.text:
        raise SceneError("certificate: write the scene to a file, and evaluate that")
    # the checker reads the file, not the scene: both must be the same, but for title and hands
    family = read_scenes(scene.text)
    for name, one in family.scenes.items():
        if replace(one, title="", hands=()) == replace(scene, title="", hands=()):
            return name if len(family) > 1 or "[[environments]]" in scene.text else None
    raise SceneError(
        "certificate: the scene was changed since its file was read: write it to a file, and "
        "evaluate that"
    )


def shown(ask: Callable[..., Any], *given: Any) -> Any:
    """The result of a function of the checker; None where it refuses."""
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
    # One number between each two zeros: then each cell holds one zero at most. A band that does not
    # end at a rational number begins or ends a little beyond it, and that gap needs one too.
    inner = [simplest(a, b) for a, b in pairwise(places[1:-1])]
    if len(places) > 2 or None in ends:
        first = [] if ends[0] is not None else [simplest(*places[:2])]
        last = [] if ends[1] is not None else [simplest(*places[-2:])]
        inner = sorted({*first, *inner, *last})
    low, high = _beside(places[0], -1), _beside(places[-1], 1)
    points, waiting, asked = [low], Waiting(pairwise([low, *inner, high])), [*factors]
    for a, b in waiting:
        if _is_shown(asked, a, b):
            points.append(b)
        elif len(points) + len(waiting.rest) < _MOST:
            # Descartes' rule may count complex zeros near a cell too, so that one is cut although
            # it holds one zero; in small enough cells the count is exact.
            middle = _between(factors, a, b)
            waiting.add((a, middle), (middle, b))
        else:
            raise UndecidedError("a certificate: it would need too many cells")
    return points


def simplest(low: RealNumber, high: RealNumber) -> Fraction:
    """The rational number of the smallest denominator between two, which is short to write."""
    between = rational_between(low, high)
    return Fraction(int(between.p), int(between.q))


def _exact(place: RealNumber) -> Fraction | None:
    """The value of a frequency that is a rational number, None for any other."""
    value = place.value if isinstance(place, ExactNumber) else None
    return Fraction(int(value.p), int(value.q)) if value is not None and value.is_Rational else None


def _beside(end: RealNumber, side: int) -> Fraction:
    """An end of the band, or a rational number a little beyond it."""
    exact = _exact(end)
    if exact is not None:
        return exact
    return Fraction(end.enclosure()[side > 0])


def _is_shown(factors: list[OmegaFactor], low: Fraction, high: Fraction) -> bool:
    """Whether signs show that there is at most one zero in a cell, of one factor; a factor that
    fails is tried first from then on, as it is the likeliest to fail in the halves too."""
    count = 0
    for i, factor in enumerate(factors):
        found = shown(factor.signs, low, high)
        if found is None:
            factors.insert(0, factors.pop(i))
            return False
        count += turns(found[1])
    return count < 2


def _between(factors: Sequence[OmegaFactor], low: Fraction, high: Fraction) -> Fraction:
    """A number well inside a cell, at which no factor vanishes."""
    # factors that have vanished wherever they were tried
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
    """A function in lowest terms as a product of factors, with cells in which the turns of each
    factor of its numerator can be counted: the number of its zeros in Re s >= 0.

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
    # s itself, whose zero is at 0
    if not any(rows[0]):
        return []

    def alternating(parity: int) -> list[list[int]]:
        """E or O in omega^2: every second coefficient, with (j omega)^2 = -omega^2."""
        chosen = [[c * (-1) ** k for c in row] for k, row in enumerate(rows[parity::2])]
        return sliced(chosen or [[0]])

    even, odd = alternating(0), alternating(1)
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
            # E must not vanish where cells meet; of more numbers than its degree one will do
            middle = next((x for x in tried if any((_signs(even, x, None) or [0])[:1])), tried[0])
            waiting.add((low, middle), (middle, high))
        else:
            raise UndecidedError("a certificate: whether zeros of Re or Im p(j omega) are distinct")
    return found[1:]


def _signs(slices: list[list[int]], low: Fraction, high: Fraction | None) -> list[int] | None:
    """The signs of the coefficients of a polynomial transformed to a cell, or above ``low`` where
    the cell has no end; None where the checker leaves them undecided."""
    end = high.as_integer_ratio() if high else (1, 0)
    coefficients: list[int] | None = shown(signs, slices, low.as_integer_ratio(), end)
    return coefficients


def _turns_are_shown(
    even: list[list[int]], odd: list[list[int]], low: Fraction, high: Fraction | None
) -> bool:
    """Whether the angle that p(j omega) turns by in a cell follows from signs at its ends.

    E is not zero at ``low``: 0, or where a cell ended.
    """
    of_even, of_odd = _signs(even, low, high), _signs(odd, low, high)
    if of_even is None or of_odd is None or not (of_even[0] and (of_even[-1] or high is None)):
        return False
    # where E keeps its sign p stays in a half plane; with one zero of E or O it crosses one axis
    return turns(of_even) == 0 or turns(of_even) + turns(of_odd) == 1


def _positive(plain: Sequence[int]) -> list[RealNumber]:
    """Approximations of the positive zeros of a polynomial, which only say where to cut."""
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
    """How many digits the enclosure of a frequency may have for a checker to decide signs there."""
    if linked.delays or linked.orders:
        return _MOST_AMONG_WAVES
    has_pi = any(x.degrees[1] for x in linked.factors) or any(x.has(pi) for x in e.scene.band)
    return _MOST_BESIDE_PI if has_pi else _MOST_DIGITS


def _poles(e: Evaluation) -> dict[str, Any] | None:
    """The proof of the number of poles of H_perc in Re s >= 0; None where that is undecided, or has
    no place in the format."""
    try:
        return None if e.stable is None else zeros(inverse(e.distortion.perc))
    except (SceneError, UndecidedError):
        return None


def _functions(e: Evaluation) -> dict[str, RealFunction]:
    """All functions whose signs an evaluation is read from, by their names in the format."""
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
    """The answers of an evaluation, with each frequency given by its number among all at which
    something happens."""
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
    """Decimal enclosures of all frequencies, with as many digits as requested, or more where these
    would overlap: a checker takes their order from them."""
    digits = e.digits
    if digits > most:
        raise SceneError(f"certificate: at most {most} digits, not {digits}")
    while True:
        found = [list(point.omega.enclosure(digits)) for point in e.chart.points]
        if all(Fraction(a[1]) < Fraction(b[0]) for a, b in pairwise(found)):
            return found
        digits *= 2
