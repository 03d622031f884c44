"""The certificate of a requirement: for which values a display is transparent, with a proof (docs/certificates.md)."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from functools import partial
from itertools import pairwise
from typing import Any, TypeAlias

from haptisym.kernel.errors import SceneError
from haptisym.kernel.reals import ExactNumber, RealNumber
from haptisym.kernel.response import RealFunction
from haptisym.model.scene import Scene
from haptisym.verbs.evaluate.certificate import TOO_LONG, afford, document, named
from haptisym.verbs.evaluate.powers import rectangular
from haptisym.verbs.evaluate.products import Linked, products
from haptisym.verbs.evaluate.waves import WaveFactor
from haptisym.verbs.require.feasible import End
from haptisym.verbs.require.freeparameter import conditions
from haptisym.verbs.require.required import Requirement
from haptisym.verbs.require.slabs import Ends, Problem, Value, ascending
from haptisym.verbs.require.slicing import cost, width

Bounds: TypeAlias = tuple[Fraction, Fraction]

_MOST_AMONG_WAVES = 10**8  # of a checker: points times cost
_MOST_BITS = 10**5  # of the ends of a slab, times the highest width of a factor


def certificate(found: Requirement) -> str:
    """The document of JSON. SceneError, a sentence, where the format has no room for the question or the scene.

    >>> import json
    >>> from haptisym.verbs.require.entry import require
    >>> [x[2] for x in json.loads(certificate(require("fu2019", "omega_n")))["claim"]["values"]]
    [False, True]
    """
    scene = found.scene
    environment = named(scene)
    _refuse(found)
    path = _keys(scene, found, environment)
    functions = _functions(found)
    linked = products(functions, next(iter(functions.values())).axis.meanings.index(found.free.symbol))
    problem = Problem(linked.factors, linked.told, _band(scene), _starts(found))
    bounds = partial(_end, digits=found.digits, apart=any(isinstance(f, WaveFactor) for f in linked.factors))
    values = _values(found, bounds)
    slabs = [[*problem.slabs(Ends(low, high), holds=holds)] for low, high, holds in values]
    _afford([x for row in slabs for x in row], linked)
    others = {"delays": [str(x) for x in linked.delays], "orders": [str(x) for x in linked.orders]}
    proof = {key: told for key, told in others.items() if told} | {
        "factors": [f.told() for f in linked.factors],
        "functions": linked.told,
        "slabs": [x for row in slabs for x in row],
    }
    claim = {
        "question": "requirement",
        "free": path,
        "parts": [name.partition(".")[2] for name in functions],
        "values": [[None if x is None else str(x) for x in row[:2]] + [row[2]] for row in values],
        "binds": _binds({bounds(x): x for x in found.ends}, values, slabs),
    }
    return document(scene, environment, claim, proof)


def _afford(slabs: Sequence[dict[str, Any]], linked: Linked) -> None:
    """SceneError where a checker would refuse to find so many signs, or to look at slabs between so long numbers."""
    ends = [
        sum(n.bit_length() for x in (row["from"], row["to"]) for n in Fraction(x or 0).as_integer_ratio())
        for row in slabs
    ]
    if (max(ends, default=0) + 2) * max(map(width, linked.factors), default=0) >= _MOST_BITS:
        raise SceneError(TOO_LONG)
    triples = [(x["from"], x["to"], point) for x in slabs for point in x["points"]]
    costs = [cost(f) for f in linked.factors]
    afford((Fraction(x) for triple in triples for x in triple if x is not None), sum(x for x, _ in costs))
    if len(triples) * sum(x for _, x in costs) >= _MOST_AMONG_WAVES:
        raise SceneError(TOO_LONG)


def _binds(
    ends: Mapping[Any, End], values: Sequence[tuple[Value, Value, bool]], slabs: Sequence[Sequence[Any]]
) -> list[str]:
    """The part that binds at each end; of several the one that exceeds in the slab beside it."""
    beside = (
        (a[-1]["part"] or b[0]["part"], [found.criterion.name for found in ends[x[1], y[0]].bindings])
        for (a, x), (b, y) in pairwise(zip(slabs, values, strict=True))
    )
    return [part if part in names else names[0] for part, names in beside]


def _refuse(found: Requirement) -> None:
    found.scene.threshold.need_plain("a certificate")
    if found.that != ("transparent",) or any(x.name not in ("real", "imag") for x in found.criteria):
        raise SceneError("a certificate of a requirement is about what is transparent in this environment alone")
    if found.undecided:
        raise SceneError("a certificate is about a whole answer: this one left values undecided")


def _functions(found: Requirement) -> dict[str, RealFunction]:
    """The excess of each part, the parameter being free."""
    told = conditions(found.scene, [found.free], found.criteria, rectangular)
    functions = {f"excess.{x.name}": f for x, f in told.items() if isinstance(f, RealFunction)}
    axis = next(iter(functions.values())).axis
    if any(found.free.symbol in x.free_symbols for x in (*axis.lags, *getattr(axis, "powers", ()))):
        raise SceneError("a certificate of a requirement needs a free number that is no delay and no power of s")
    return functions


def _keys(scene: Scene, found: Requirement, environment: str | None) -> list[str | int]:
    """Where the scene's file has the number; of one of several environments as if it were the only one."""
    table, free = tomllib.loads(scene.text), found.free
    for one in table.get("environments", []):
        if one.get("name", one.get("model")) == environment:
            table |= {"environment": one, "rendered": one.get("rendered", {})}
    place: list[str | int] = [free.place]
    if free.place.startswith("effects."):
        place = ["effects", [f"effects.{x.name}" for x in scene.effects].index(free.place)]
    own: Any = table
    for key in place:
        own = own[key] if isinstance(key, int) or key in own else {}
    name, _, index = free.key.partition("[")
    keys: list[str | int] = [*name.split("."), *([int(index.rstrip("]")) - 1] if index else [])]
    for path in ([*place, *keys], [*place, "parameters", *keys]):
        if _number_at(table, path):
            return path
    raise SceneError(f"a certificate needs {free.path} as a number of its own in the scene file")


def _number_at(table: Any, path: list[Any]) -> bool:
    for key in path:
        try:
            table = table[key]
        except (LookupError, TypeError):
            return False
    return not isinstance(table, dict)


def _band(scene: Scene) -> tuple[Fraction, Fraction, Fraction, Fraction]:
    """Bounds of the low end, and of the high end."""
    low, high = (_bounds(ExactNumber(x)) for x in scene.band)
    return max(low[0], Fraction(0)), low[1], high[0], high[1]


def _bounds(x: RealNumber, digits: int = 60) -> tuple[Fraction, Fraction]:
    value = x.value if isinstance(x, ExactNumber) else None
    if value is not None and value.is_Rational:
        return (Fraction(int(value.p), int(value.q)),) * 2
    low, high = x.enclosure(digits)
    return Fraction(low), Fraction(high)


def _starts(found: Requirement) -> list[Fraction]:
    """The frequencies at which something binds, nearly."""
    _, low, high, _ = _band(found.scene)
    places = [_bounds(b.omega)[0] for end in found.ends for b in end.bindings if b.omega is not None]
    return sorted({min(max(x, low), high) for x in places})


def _values(found: Requirement, bounds: Callable[[End], Bounds | None]) -> list[tuple[Value, Value, bool]]:
    """Intervals of values, ascending, each with whether it is feasible."""
    first, last = (None if x is None else _bounds(ExactNumber(x)) for x in (found.domain.low, found.domain.high))
    here, rows = None if first is None else first[1], list[tuple[Value, Value, bool]]()
    for span in found.feasible:
        low, high = bounds(span.low), bounds(span.high)
        if low and high and low[1] >= high[0]:
            raise SceneError("a certificate of a requirement has no room for a single value")
        if span.low.bindings and low is not None:
            rows.append((here, low[0], False))
        rows.append((None if low is None else low[1], None if high is None else high[0], True))
        here = None if high is None else high[1]
    if not found.feasible or found.feasible[-1].high.bindings:
        rows.append((here, None if last is None else last[0], False))
    rows = [x for x in rows if x[0] is None or x[1] is None or x[0] < x[1]]
    if not ascending(rows):
        raise SceneError("a certificate of a requirement needs ends that are told apart")
    return rows


def _end(x: End, *, digits: int, apart: bool) -> Bounds | None:
    """Bounds of an end; ``apart`` : where something binds it is neither of them, as no bounds of sines show that zero."""
    if x.value is None:
        return None
    low, high = _bounds(x.value, digits)
    beside = (abs(low) or 1) / Fraction(10) ** digits if apart and low == high and x.bindings else Fraction(0)
    return low - beside, high + beside
