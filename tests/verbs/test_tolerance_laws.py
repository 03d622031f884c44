"""Tolerances of ratios whose crossings are known in closed form: verdicts, enclosures and bandwidths of random boxes."""

from __future__ import annotations

from fractions import Fraction
from math import sqrt
from random import Random
from types import SimpleNamespace
from typing import Any

import pytest
from sympy import Rational

import haptisym as hs
from haptisym.judge.criteria import noticed
from haptisym.kernel.budget import Budget
from haptisym.kernel.reals import ExactNumber
from haptisym.verbs.stability.boxes import Share
from haptisym.verbs.tolerances.box import box_of
from haptisym.verbs.tolerances.heldbox import HeldInBox
from haptisym.verbs.tolerances.proofs import Tolerances
from haptisym.verbs.tolerances.single import One
from haptisym.verbs.tolerances.verdicts import Enclosure, Verdict

C = Fraction(1, 5)


def drawn(pick: Random) -> tuple[list[Fraction], list[Fraction], Fraction, Fraction]:
    """Ranges of a and b, a band of omega^2: r_r = |b - a omega^2| behind a spring, and r_i = 0."""
    a = Fraction(pick.randint(5, 40), 1000)
    b = pick.choice([Fraction(0), Fraction(1, 10), Fraction(15, 100), C, Fraction(3, 10), Fraction(1, 2)])
    across = [a, a * (1 + Fraction(pick.choice([0, 1, 5, 20, 60]), 100))]
    along = [b, b + Fraction(pick.choice([0, 1, 5, 10, 30]), 100)]
    low = pick.choice([0, 0, 1, 2])
    ends = [(C + x) / y for x in along for y in across] + [(x - C) / y for x in along for y in across if x > C]
    near = pick.choice(ends) * pick.choice(
        [Fraction(1, 2), Fraction(9, 10), Fraction(1), Fraction(11, 10), Fraction(2)]
    )
    high = max(Fraction(round(sqrt(near) * 100), 100), Fraction(low + 1))
    return across, along, Fraction(low), high


def _text(x: list[Fraction]) -> object:
    return str(x[0]) if x[0] == x[1] else [str(x[0]), str(x[1])]


def crossings(a: Fraction, b: Fraction, low: Fraction, high: Fraction) -> list[float]:
    """The frequencies between the ends of the band at which r goes through c."""
    return sorted(sqrt(w) for w in ((b - C) / a, (b + C) / a) if low**2 < w < high**2)


def width(a: Fraction, b: Fraction, low: Fraction, high: Fraction) -> float | None:
    """The bandwidth; None where it is noticed from the low end on."""
    if abs(b - a * low**2) > C:
        return None
    return min(sqrt((C + b) / a), float(high))


def _hold(pick: Random) -> Tolerances | None:
    across, along, low, high = drawn(pick)
    if across[0] == across[1] and along[0] == along[1]:
        return None
    gain = hs.effects.series("1 + b + a*s^2", parameters={"a": _text(across), "b": _text(along)})
    scene = hs.Scene(hs.environments.mass_spring_damper(k=100), (gain,), (low, high), hs.Threshold(str(C), str(C)))
    found = hs.tolerances(scene, samples=0)
    sets = [(x, y) for x in across for y in along]
    sets += [tuple(lo + (hi - lo) * Fraction(pick.randint(0, 16), 16) for lo, hi in (across, along)) for _ in range(20)]
    widths = [width(a, b, low, high) for a, b in sets]
    noticed = [max(abs(b - a * w**2) for w in (low, high)) > C for a, b in sets]
    verdict = found.verdict.value
    assert verdict != "all" or not any(noticed)
    assert verdict != "none" or all(noticed)
    touching = any(abs(b - a * w**2) == C for a, b in sets[:4] for w in (low, high))
    # that all are noticed, but no frequency at which all of them are, may stay open
    assert verdict != "undecided" or touching or all(noticed)
    if verdict == "depends":
        assert found.transparent is not None
        assert found.noticed is not None
    for a, b in sets:
        for x in crossings(a, b, low, high):
            assert any(float(e.low) * (1 - 1e-12) <= x <= float(e.high) * (1 + 1e-12) for e in found.enclosures)
    if found.bandwidth is not None:
        least, most = map(float, found.bandwidth)
        assert all(x is not None and least * (1 - 1e-12) <= x <= most * (1 + 1e-12) for x in widths)
        assert least >= 0.99 * min(x for x in widths if x is not None)
    return found


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(8))
def test_random_boxes_of_a_ratio_that_is_a_line_in_the_square_of_frequency_are_told_as_they_are(seed: int) -> None:
    pick = Random(seed)
    for _ in range(5):
        _hold(pick)


REAL = {"1/10": Fraction(1, 3), "1/5": Fraction(1, 2), "1/2": Fraction(1), "5": None}
IMAG = {"3/10": Fraction(1, 3), "2/5": Fraction(1, 2), "5": None}
"""Thresholds, and the t at which t^2/(1 + t^2), or t/(1 + t^2), gets there first."""


@pytest.mark.slow
@pytest.mark.parametrize("imag", IMAG)
@pytest.mark.parametrize("real", REAL)
def test_a_bandwidth_is_that_of_the_first_of_two_parts_or_the_end_of_the_band_whichever_is_nearer(
    real: str, imag: str
) -> None:
    """Behind a lag of 36 to 44 rad/s; bands that end before, in, at the ends of and beyond where either part may be noticed."""
    t = min((x for x in (REAL[real], IMAG[imag]) if x is not None), default=None)
    felt, lag = hs.environments.mass_spring_damper(k=100), hs.effects.first_order_lag(["36 rad/s", "44 rad/s"])
    for top in map(Fraction, ("10", "12", "13", "44/3", "16", "18", "20", "22", "25", "36", "40", "44", "50")):
        found = hs.tolerances(hs.Scene(felt, (lag,), (0, top), hs.Threshold(real, imag)), samples=0)
        ends = [top, top] if t is None else [min(top, 36 * t), min(top, 44 * t)]
        assert found.bandwidth is not None
        assert [float(x) for x in found.bandwidth] == pytest.approx([float(x) for x in ends], rel=1e-12)
        told = "all" if t is None or top <= 36 * t else "depends" if top <= 44 * t else "none"
        assert found.verdict.value == told
        assert (found.transparent is not None) is (told != "none")
        assert (found.noticed is not None) is (told != "all" and (t is None or top > 36 * t))


@pytest.mark.few(2)
@pytest.mark.parametrize(
    ("cutoff", "limit", "told"),
    [
        (["36", "44"], "1/10", "all"), (["35.99", "44"], "1/10", "depends"), (["30", "36"], "1/10", "depends"),
        ("36", ["1/10", "1/5"], "all"), ("36", ["1/20", "1/10"], "depends"), (["36", "44"], ["1/10", "1/5"], "all"),
        (["30", "36"], ["1/20", "1/10"], "depends"), (["30", "35.99"], "1/10", "none"),
    ],
)  # fmt: skip
def test_a_range_that_begins_where_a_requirement_ends_is_one_for_which_all_values_will_do(
    cutoff: Any, limit: Any, told: str
) -> None:
    """The least cutoff that keeps r_r to 1/10 up to 12 rad/s is 36 rad/s, exactly."""
    felt, lag = hs.environments.mass_spring_damper(k=100), hs.effects.first_order_lag
    [span] = hs.require(hs.Scene(felt, (lag(50),), (0, 12), hs.Threshold("1/10", 5)), "omega_c").feasible
    assert span.low.value is not None
    assert span.low.value.enclosure() == ("36", "36")
    found = hs.tolerances(hs.Scene(felt, (lag(cutoff),), (0, 12), hs.Threshold.of(limit, 5)), samples=0)
    assert found.verdict.value == told
    assert found.certified


# What an answer says, made of parts that are known


@pytest.mark.parametrize("seed", range(6))
def test_a_document_of_tolerances_holds_what_its_parts_say(seed: int) -> None:
    pick = Random(seed)
    spring = hs.environments.mass_spring_damper(k=["90 N/m", "110 N/m"])
    box = box_of(hs.Scene(spring, (hs.effects.first_order_lag(["36 rad/s", "44 rad/s"]),), (1, 9)))
    names = [x.name for x in box.sides]
    number = lambda x: ExactNumber(Rational(x))  # noqa: E731

    def values() -> dict[str, Any]:
        return {x: Rational(pick.randint(1, 99), 7) for x in names}

    def one(first: int | None, width: int | None, *, transparent: bool | None) -> One:
        crossings = {"real": () if first is None else (number(first), number(first + 1)), "imag": ()}
        return One(values(), crossings, None if width is None else number(width), transparent)

    for _ in range(10):
        samples = [
            one(pick.choice([None, 2, 3, 5]), pick.choice([None, 4, 6]), transparent=pick.choice([None, True, False]))
            for _ in range(pick.choice([0, 1, 7, 20]))
        ]
        held = tuple(HeldInBox(hs.Hand(x, 1, 2, 3), pick.choice([None, *Share])) for x in "ab"[: pick.randint(0, 2)])
        budget = pick.choice([None, Budget(7.0, None, reached=True), Budget(7.0, None)])
        found = Tolerances(box, tuple(samples), 33, budget, held)
        rows = [
            Enclosure(x, number(pick.randint(1, 4)), number(pick.randint(5, 9)), pick.choice([None, 1, 2]), pick.choice([None, values()]),
                pick.choice([None, values()]), {name: pick.choice([-1, 0, 1]) for name in names}) for x in found.criteria for _ in range(pick.randint(0, 2))
        ]  # fmt: skip
        verdict, witness = pick.choice([*Verdict]), pick.choice([None, one(1, 2, transparent=True)])
        width = pick.choice([None, (number(2), number(5))])
        found.__dict__.update(
            verdict=verdict, enclosures=tuple(rows), transparent=witness, noticed=None, bandwidth=width
        )
        told = found.to_dict()
        assert told["band"] == [1.0, 9.0]
        assert told["varying"] == [{"name": x.name, "low": float(x.low), "high": float(x.high)} for x in box.sides]
        text = lambda x: x and {name: str(y) for name, y in x.items()}  # noqa: E731
        assert told["verdict"] == verdict.value
        assert told["witnesses"] == {"transparent": text(witness and witness.values), "noticed": None}
        assert told["crossings"] == [
            {
                "part": x.criterion.name, "omega": [float(x.low), float(x.high)], "enclosure": [x.low.enclosure()[0], x.high.enclosure()[1]], "count": x.count,
                "reached_at": {"low": text(x.at_low), "high": text(x.at_high)}, "monotonic": x.monotonic,
            } for x in rows
        ]  # fmt: skip
        assert told["bandwidth"] == (width and [2.0, 5.0])
        assert told.get("held", []) == [x.row() for x in held]
        assert ("held" in told) == bool(held)
        assert told["certified"] == found.certified
        assert found.certified == (verdict is not Verdict.UNDECIDED and None not in [x.share for x in held])
        assert (told.get("limit"), found.limit) == ((7.0,) * 2 if budget and budget.reached else (None, None))
        counted = "1 enclosure" if len(rows) == 1 else f"{len(rows) or 'no'} enclosures"
        assert found._line().endswith(
            f": {', '.join(names)} in their ranges, transparent for {verdict.value}, {counted}"
        )
        estimates = told["estimates"]
        assert (estimates is None) == (not samples)
        if samples:
            assert (estimates["samples"], estimates["seed"]) == (len(samples), 33)
            assert estimates["transparent"] == sum(x.transparent is True for x in samples)
            for key, absent in (("first_crossing", float("inf")), ("bandwidth", -float("inf"))):
                each = [x.first if key == "first_crossing" else x.bandwidth for x in samples]
                row = sorted(absent if x is None else float(x) for x in each)
                for p in (5, 50, 95):
                    least = next(x for i, x in enumerate(row, 1) if 100 * i >= p * len(row))
                    assert estimates[key][str(p)] == (None if abs(least) == float("inf") else least)


@pytest.mark.parametrize(
    ("share", "expected"),
    [
        (0.61, 6.0),
        (0.6, 6.0),
        (0.6 - 1e-11, 6.0),
        (0.6 - 1e-7, 3.0),
        (0.59, 3.0),
        (0.3, 3.0),
        (0.1, None),
        (None, None),
        (1.0, 9.0),
    ],
)
def test_a_ratio_exceeds_at_the_latest_from_the_last_enclosure_before_it_does_for_all(
    share: float | None, expected: float | None
) -> None:
    """Its own enclosures alone: one that ends at 3 rad/s, one at 6 and one at 9, on a band from 0 to 10; edges meet to 1e-9."""
    own, other = SimpleNamespace(name="real"), SimpleNamespace(name="imag")
    rows = [(own, 9), (own, 3), (other, 5), (own, None), (own, 6), (other, 2)]
    asked: Any = SimpleNamespace(
        enclosures=[SimpleNamespace(criterion=x, high=y and ExactNumber(Rational(y))) for x, y in rows],
        box=SimpleNamespace(scene=SimpleNamespace(band=(Rational(0), Rational(10)))),
        _exceeds_between=lambda _: share,
    )
    found = Tolerances._end_of_first(asked, own)  # type: ignore[arg-type]
    assert (found and float(found)) == expected


def test_enclosures_are_told_from_the_lowest_on() -> None:
    """Of two ratios, of which one has a wide enclosure about the narrow one of the other."""
    criteria = noticed(hs.load_scene("fu2019").threshold)
    ends = {"real": [(2.0, 3.0), (7.0, 7.5)], "imag": [(1.0, 9.0), (2.0, 2.5)]}
    asked: Any = SimpleNamespace(
        _search={x: (None, ends[x.name]) for x in criteria},
        _enclosure=lambda x, _, y: SimpleNamespace(criterion=x, low=y[0], high=y[1]),
    )
    found = Tolerances.enclosures.func(asked)  # type: ignore[attr-defined]
    assert [(x.criterion.name, x.low) for x in found] == [("imag", 1.0), ("imag", 2.0), ("real", 2.0), ("real", 7.0)]
