"""How parts of an answer on tolerances make the whole: verdict, bandwidth, examples and counts, whatever the parts are."""

from __future__ import annotations

from fractions import Fraction
from itertools import product
from random import Random
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from sympy import Expr, Rational, Symbol

import haptisym as hs
from haptisym.judge.criteria import noticed
from haptisym.kernel.budget import Budget, limited
from haptisym.kernel.errors import LimitError
from haptisym.kernel.reals import ExactNumber
from haptisym.verbs.tolerances.box import Box, Side, box_of
from haptisym.verbs.tolerances.ends import MOST_CORNERS, Face, at_share, within
from haptisym.verbs.tolerances.proofs import Tolerances
from haptisym.verbs.tolerances.search import Cluster
from haptisym.verbs.tolerances.single import One, in_time
from haptisym.verbs.tolerances.verdicts import Verdict

SIDES = (Side("p", Rational(1), Rational(3)), Side("q", Rational(-1), Rational(1, 2)))
CRITERIA = noticed(hs.load_scene("fu2019").threshold)


def number(x: Any) -> ExactNumber:
    return ExactNumber(Rational(x))


def values(shares: dict[str, Fraction]) -> dict[str, Expr]:
    return {x.name: x.at(shares[x.name]) for x in SIDES}


def asked(**known: Any) -> Any:
    """An answer of which these parts are known."""
    box: Any = SimpleNamespace(sides=SIDES, values=values, scene=SimpleNamespace(band=(Rational(2), Rational(12))))
    found: Any = Tolerances(known.pop("box", box), known.pop("samples", ()))
    found.__dict__.update(known)
    return found


def cluster(low: float, high: float, *signs: int) -> Cluster:
    return Cluster(np.zeros((1, len(signs), 2)), signs, low, high)


def one(transparent: Any, bandwidth: Any = None) -> One:
    return One({}, {}, bandwidth, transparent)


BOTH = (True, False)
TRANSPARENT, NOTICED = (One({}, {}, None, x) for x in BOTH)


def test_the_verdict_is_that_of_examples_of_both_kinds_or_of_a_proof_for_one_of_them() -> None:
    """All that may be known of examples, of clusters, of the nominal values, and of proofs that all or none are noticed."""
    open_ = (None, *BOTH)
    kinds: Any = product((None, TRANSPARENT), (None, NOTICED), (0, 1), BOTH, open_, BOTH, BOTH)
    for transparent, noticed_, clusters, sides, nominal, always, never in kinds:
        own = (cluster(0.1, 0.2, 1, 1),) * clusters
        box: Any = SimpleNamespace(sides=SIDES if sides else ())
        found = asked(
            box=box, transparent=transparent, noticed=noticed_, nominal=one(nominal),
            _search={"real": (None, ()), "imag": (None, own)},
            _always_noticed=lambda x=always: x, _never_noticed=lambda x=never: x,
        )  # fmt: skip
        if transparent and noticed_:
            expected = Verdict.DEPENDS
        elif nominal is not None and (not sides or not own):
            expected = Verdict.ALL if nominal else Verdict.NONE
        else:
            expected = Verdict.NONE if always else Verdict.ALL if never else Verdict.UNDECIDED
        assert found.verdict is expected


def test_examples_are_sought_among_nominal_values_drawn_ones_and_corners_in_this_order() -> None:
    """Corners are not asked for where a frequency is noticed whatever the values; what stays open is an example of nothing."""
    pick = Random(3)
    for _ in range(60):
        ones = [one(pick.choice([True, False, None])) for _ in range(6)]
        always = pick.random() < 0.4
        found = asked(
            samples=tuple(ones[1:4]), nominal=ones[0], _corners=tuple(ones[4:]), _always_noticed=lambda x=always: x
        )
        looked = ones[:4] if always else ones
        for kind, example in ((True, found.transparent), (False, found.noticed)):
            assert example is next((x for x in looked if x.transparent is kind), None)


@pytest.mark.parametrize("seed", range(4))
def test_nothing_is_noticed_where_nothing_is_at_the_corners_with_the_largest_ratios(seed: int) -> None:
    """Of each cluster: where the excess rises with a parameter its high end, else its low one; the high one of what is idle."""
    pick = Random(seed)
    for _ in range(40):
        matters = np.array([True, pick.random() < 0.7, pick.random() < 0.7])
        form: Any = SimpleNamespace(matters=matters)
        own = tuple(
            cluster(0.1, 0.2, *(pick.choice([-1, 1, 1, 0]) for _ in range(3))) for _ in range(pick.randint(0, 2))
        )
        corners = []
        for x in own:
            signs = [n if m else 1 for n, m in zip(x.signs[1:], matters[1:], strict=True)]
            ends = {s.name: s.high if n > 0 else s.low for s, n in zip(SIDES, signs, strict=True)}
            corners.append(None if 0 in signs else ends)
        kept = pick.choice([True, True, True, None, False])
        late = pick.random() < 0.1
        seen: list[Any] = []

        def told(at: Any, seen: Any = seen, kept: Any = kept, *, late: bool = late) -> One:
            seen.append(at)
            if late and at:
                raise LimitError("the time is over")
            return one(kept if at else True)

        found = asked(_search={"real": (form, own)}, one=told)
        answer = found._never_noticed()
        assert answer is (None not in corners and (not corners or (kept is True and not late)))
        if answer:
            assert seen == [{}, *corners]


@pytest.mark.parametrize("seed", range(4))
def test_a_crossing_moves_against_the_excess_over_its_slope_and_is_counted_where_it_is_alone(seed: int) -> None:
    """dw/dp = -(dF/dp)/(dF/dw); as many as at the nominal values where the slope has one sign, clear of both ends of the band."""
    pick = Random(seed)
    for _ in range(30):
        x = cluster(pick.choice([0.0, 0.1]), pick.choice([0.3, 1.0]), *(pick.choice([-1, 0, 1]) for _ in range(3)))
        places = sorted(pick.sample([3, 4, 6], pick.randint(0, 3)))
        found = asked(nominal=One({}, {"real": tuple(map(number, places))}, None, None), one=None)
        found.__dict__["_steady"] = lambda form, own, found=found: Tolerances._steady(found, form, own)
        ends = {False: (number(3), {"p": 1}), True: (number(7), None)}
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr("haptisym.verbs.tolerances.proofs.end_of", lambda *_, highest, own=ends: own[highest])
            row = found._enclosure(CRITERIA[0], None, x)
        inside = [y for y in places if x.low - 1e-9 <= (y - 2) / 10 <= x.high + 1e-9]
        alone = x.signs[0] != 0 and x.low > 0 and x.high < 1
        assert row.count == (len(inside) if alone and inside else None)
        assert row.monotonic == {s.name: -n * x.signs[0] for s, n in zip(SIDES, x.signs[1:], strict=True)}
        assert (row.low, row.at_low, row.high, row.at_high, row.criterion) == (*ends[False], *ends[True], CRITERIA[0])


def test_a_bandwidth_is_told_from_the_first_crossing_to_where_one_of_the_ratios_exceeds_for_all() -> None:
    """On a band from 2 to 12 rad/s; none where what is nominal has none, or where a crossing may lie at the low end."""
    rows = [(), ((3, 5),), ((5, 6), (4, 9)), ((2, 5),), ((1, 5), (4, 9))]
    for nominal, own, real, imag in product((None, number(4)), rows, (None, 5, 7), (None, 6)):
        at = {"real": real, "imag": imag}
        found = asked(
            nominal=one(None, nominal), criteria=CRITERIA,
            enclosures=tuple(SimpleNamespace(low=number(a), high=number(b)) for a, b in own),
            _end_of_first=lambda x, at=at: at[x.name] and number(at[x.name]),
        )  # fmt: skip
        if nominal is None or any(a <= 2 for a, _ in own):
            assert found.bandwidth is None
        else:
            least, most = min([a for a, _ in own], default=12), min([x for x in at.values() if x], default=12)
            assert tuple(map(float, found.bandwidth)) == (least, most)


def test_the_limit_is_named_where_it_cut_the_work_short_alone() -> None:
    for budget, expected in ((None, None), (Budget(3.0, None), None), (Budget(3.0, None, reached=True), 3.0)):
        found = Tolerances(asked().box, (), 0, budget)
        assert (found.limit, found._left()) == (expected, {} if expected is None else {"limit": 3.0})


# --- boxes, corners and shares ----------------------------------------------------------------------------------------


def test_corners_are_all_ends_of_all_sides_or_the_first_sixty_four() -> None:
    for count in (0, 1, 3, 6, 7):
        sides = [Side(f"p{i}", Rational(i), Rational(i + 1)) for i in range(count)]
        box: Any = SimpleNamespace(sides=sides, values=lambda x, own=sides: {y.name: y.at(x[y.name]) for y in own})
        found = asked(box=box, one=lambda at: One(at, {}, None, None))
        corners = [tuple(x.values.values()) for x in found._corners]
        assert len(set(corners)) == len(corners) == min(2**count, MOST_CORNERS)
        assert all(y in (i, i + 1) for x in corners for i, y in enumerate(x))

    def late(at: Any) -> One:
        if at["p"] == 3:
            raise LimitError("the time is over")
        return One(at, {}, None, None)

    assert [x.values["p"] for x in asked(one=late)._corners] == [1, 1]
    assert list(in_time(iter(()))) == []


def test_a_share_of_a_side_and_of_the_band_is_exact_and_of_the_band_never_outside() -> None:
    side = Side("x", Rational(1, 3), Rational(5, 3))
    assert [side.at(Fraction(n, 4)) for n in range(5)] == [Rational(1 + n, 3) for n in range(5)]
    box = asked().box
    for share, at in ((0.0, 2), (0.25, Rational(9, 2)), (1.0, 12), (-0.5, 2), (1.5, 12)):
        assert at_share(box, share) == number(at)


def test_a_crossing_is_one_of_a_cluster_up_to_a_quarter_of_what_parts_clusters() -> None:
    box, own = asked().box, cluster(0.25, 0.5, 1, 1)  # 4.5 to 7 rad/s
    for x, is_within in ((4.5, True), (7, True), (5, True), (4.4, False), (7.1, False)):
        assert within(box, number(x), own) is is_within
    for off, is_within in ((2e-9, True), (3e-9, False)):
        assert within(box, number(Fraction(4.5) - Fraction(10 * off)), own) is is_within
        assert within(box, number(7 + Fraction(10 * off)), own) is is_within


@pytest.mark.parametrize("highest", [True, False])
def test_crossings_are_highest_at_the_ends_to_which_known_slopes_move_them(*, highest: bool) -> None:
    """It rises where the slopes of the excess by omega and by the parameter differ in sign; what is idle stays low."""
    box: Any = SimpleNamespace(sides=SIDES)
    face = Face(box, "real", {}, None)  # type: ignore[arg-type]
    for omega, p, q, p_matters, q_matters in product((-1, 1, 0), (-1, 0, 1), (-1, 0, 1), (True, False), (True, False)):
        form: Any = SimpleNamespace(matters=np.array([True, p_matters, q_matters]))
        found = face.moves(form, cluster(0.1, 0.2, omega, p, q), highest=highest)
        for name, sign, matters in (("p", p, p_matters), ("q", q, q_matters)):
            rises = -omega * sign * (1 if highest else -1)
            assert found[name] == (None if rises == 0 and matters else Fraction(int(rises > 0)))


def test_a_box_needs_numbers_ranges_and_thresholds_that_are_one_interval() -> None:
    plain = hs.Scene(hs.environments.mass_spring_damper(k=100), (hs.effects.first_order_lag(["36", "44"]),))
    box = box_of(plain)
    assert [(x.name, x.low, x.high, x.unit) for x in box.sides] == [("omega_c", 36, 44, "rad/s")]
    assert box.values({"omega_c": Fraction(1, 4)}) == {"omega_c": 38}
    still = plain.with_values({"omega_c": 40})
    with pytest.raises(hs.SceneError, match="no parameter has a range"):
        box_of(still)
    for b, has_box in ((["1", "2"], True), (1, False)):
        held = still.with_hands(hs.Hand("x", 1, 1, 1), hs.Hand("mine", 1, b, 1))
        if has_box:
            assert box_of(held).sides == ()
        else:
            with pytest.raises(hs.SceneError, match="no parameter has a range"):
                box_of(held)
    with pytest.raises(hs.SceneError, match="is a symbol"):
        box_of(plain.with_values({"k": Symbol("k", positive=True)}))
    assert isinstance(box, Box)


def test_whatever_is_told_is_found_before_the_time_is_looked_at_no_more() -> None:
    """All parts are there once it is settled; with no time at all not even the nominal values are."""
    plain = hs.Scene(hs.environments.mass_spring_damper(k=100), (hs.effects.first_order_lag(["36", "44"]),), (0, 5))
    found = Tolerances(box_of(plain), ())
    found.settle()
    parts = ("nominal", "_search", "enclosures", "verdict", "transparent", "noticed", "bandwidth")
    assert set(parts) <= found.__dict__.keys()
    with limited(1e-9), pytest.raises(LimitError):
        Tolerances(box_of(plain), ()).settle()
