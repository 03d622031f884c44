"""The certificate of an evaluation: its claim, with a proof that another program can check (docs/certificates.md)."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise
from typing import Any

from sympy import pi

from haptisym.judge.crossings import Curve, curves
from haptisym.judge.evaluation import Evaluation
from haptisym.judge.percepts import find_percepts
from haptisym.kernel.errors import SceneError, UndecidedError
from haptisym.kernel.reals import Sliver
from haptisym.kernel.response import RealFunction
from haptisym.kernel.rings import RationalFunction
from haptisym.kernel.roots import Interval, Point
from haptisym.model.scene import Scene
from haptisym.model.scenetables import read_scenes
from haptisym.verbs.evaluate.breakpoints import breakpoints
from haptisym.verbs.evaluate.checkable import need_checkable
from haptisym.verbs.evaluate.powers import rectangular
from haptisym.verbs.evaluate.products import Factor, Linked, products
from haptisym.verbs.evaluate.zeros import zeros

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
