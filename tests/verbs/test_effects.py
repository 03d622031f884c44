"""Which effects matter: every bound against values computed with other means, closed forms, and all sets of effects gone through."""

from __future__ import annotations

import json
from fractions import Fraction
from itertools import combinations
from math import inf, isclose, nextafter, prod, sqrt
from random import Random
from typing import Any

import flint
import mpmath
import pytest
import strategies
from marks import QUICK_SCENES
from sympy import Expr, Rational, exp, lambdify, pi

import haptisym as hs
from haptisym.judge.crossings import noticed
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.rings import s
from haptisym.programs.links import series_arithmetic
from haptisym.verbs.effects.differences import WIDTH, BallChain, BandPiece, Difference, Kept
from haptisym.verbs.effects.relevance import CrossingEnclosure, Relevance

MP = mpmath.MPContext()
MP.dps = 40
MANY = "control-stick-in-detail"
SPRING = hs.environments.mass_spring_damper(k=100)
LAG = hs.effects.first_order_lag(10)
"""Behind it a spring has r_r = x^2/(1 + x^2) and r_i = x/(1 + x^2), x = omega/10."""


class Witness:
    """Ratios at 40 digits, from the matrices as they are written, with nothing of the package's algebra."""

    def __init__(self, scene: hs.Scene) -> None:
        self.scene = scene
        self.environment, self.rendered = (
            function(x.H) for x in (scene.environment, scene.rendered or scene.environment)
        )
        self.matrices = [[function(entry) for entry in effect.matrix] for effect in scene.effects]

    def change(self, omega: Any, kept: Kept) -> Any:
        """dH over |H_env|."""
        at = MP.mpc(0, omega)
        force, position = self.rendered(at), MP.mpf(1)
        for i in sorted(kept):
            a, b, c, d = (entry(at) for entry in self.matrices[i])
            force, position = a * force + b * position, c * force + d * position
        environment = self.environment(at)
        return (force / position - environment) / abs(environment)

    def changes(self, omega: Any, kept: Kept) -> dict[hs.Part, Any]:
        """By how much both ratios differ from those with all effects."""
        full, some = (self.change(omega, x) for x in (frozenset(range(len(self.matrices))), kept))
        return {
            hs.Part.REAL: abs(abs(full.real) - abs(some.real)), hs.Part.IMAG: abs(abs(full.imag) - abs(some.imag)),
        }  # fmt: skip

    def grid(self, count: int) -> list[Any]:
        low, high = (MP.mpf(str(x.evalf(40))) for x in self.scene.band)
        return [low + (high - low) * MP.mpf(2 * i + 1) / (2 * count) for i in range(count)]


def function(entry: Expr) -> Any:
    """An entry as a function of s at 40 digits."""
    exact = {x: MP.mpf(x.p) / x.q for x in entry.atoms(Rational) if not x.is_Integer}
    names = {x: hs.symbols(f"q{i}") for i, x in enumerate(exact)}
    known = {"exp": MP.exp, "cosh": MP.cosh, "sinh": MP.sinh, "pi": MP.pi, "I": MP.j}
    run = lambdify([s, *names.values()], entry.xreplace(names), [known])
    return lambda at: MP.mpc(run(at, *exact.values()))


def change(scene: hs.Scene, kept: set[int] | Kept, part: hs.Part) -> Difference:
    return Difference(scene, BallChain(scene), frozenset(kept), part)


def check(scene: hs.Scene, kept: Kept, count: int = 100) -> None:
    """No sample is above the certified supremum, and the best of them comes close to it; what has none grows towards 0 rad/s."""
    balls, witness = BallChain(scene), Witness(scene)
    grid = witness.grid(count)
    changes = [witness.changes(omega, kept) for omega in grid]
    for part in hs.Part:
        found = Difference(scene, balls, kept, part).supremum()
        values = [row[part] for row in changes]
        best = max(range(count), key=values.__getitem__)
        assert all(value <= found.most + 1e-30 for value in values), (part, found, float(values[best]))
        if not found.is_finite:
            assert witness.changes(MP.mpf(10) ** -9, kept)[part] > 1e6
            continue
        assert found.most - found.least <= max(WIDTH * found.most * 1.01, 1e-12)
        if found.most > 1e-9:
            step = (grid[1] - grid[0]) / 2
            near = [grid[best] + step * MP.mpf(k) / 20 for k in range(-19, 20)]
            reached = max(witness.changes(omega, kept)[part] for omega in near)
            assert reached >= found.least * (1 - MP.mpf("0.02")), (part, found, float(reached))


# --- influences ------------------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("name", [*sorted(QUICK_SCENES), "organ-tissue", "sampled-wall", "four-channel-teleoperation"])
def test_no_sample_exceeds_a_certified_influence_and_the_best_one_comes_near(name: str) -> None:
    scene = hs.load_scene(name)
    for i in range(len(scene.effects)):
        check(scene, frozenset(range(len(scene.effects))) - {i})


ELSEWHERE = {
    "a free mass with delay": hs.Scene(
        hs.environments.mass_spring_damper(m=2), (hs.effects.delay("5 ms"), hs.effects.shunt(m="0.1 kg"))
    ),
    "a resonance without damping": hs.Scene(
        hs.environments.mass_spring_damper(m=1, k=49), (hs.effects.first_order_lag(20), hs.effects.zero_order_hold("5 ms"))
    ),
    "powers of s from 0 on": hs.Scene(
        hs.environments.spring_pot(k_alpha=50, alpha="0.37"), (hs.effects.first_order_lag(20), hs.effects.delay("5 ms"))
    ),
    "waves on a free mass": hs.Scene(
        hs.environments.mass_spring_damper(m=2), (hs.effects.wave_variables(20, "5 ms"), hs.effects.delay("3 ms"))
    ),
    "a free mass that is rendered as tissue": hs.Scene(
        hs.environments.mass_spring_damper(m=2),
        (hs.effects.first_order_lag(20), hs.effects.pade_delay("100 ms", 1), hs.effects.first_order_lag(2)),
        (0, 2), rendered=hs.environments.kelvin_voigt(9, 1),
    ),
}  # fmt: skip
"""Where ratios are limits, 0/0, unbounded at 0, or powers that are not whole."""


@pytest.mark.dear("a resonance without damping", "powers of s from 0 on")
@pytest.mark.few("a free mass with delay", "a resonance without damping", "powers of s from 0 on")
@pytest.mark.parametrize("name", ELSEWHERE)
def test_influences_hold_where_ratios_are_limits(name: str) -> None:
    scene = ELSEWHERE[name]
    everything = frozenset(range(len(scene.effects)))
    for i in range(2) if name != "a free mass that is rendered as tissue" else (0,):
        check(scene, everything - {i}, 40)


@pytest.mark.dear("3")
@pytest.mark.few("15", "3")
@pytest.mark.parametrize("seed", range(24))
def test_influences_of_random_scenes_hold_between_samples(seed: int) -> None:
    scene = strategies.scene(strategies.case(strategies.Seeded(seed)))
    if any(x.evalf() > 1000 for x in scene.band):
        scene = scene.with_band(scene.band[0], scene.band[0] + 100)
    balls, everything, witness = BallChain(scene), frozenset(range(len(scene.effects))), Witness(scene)
    for i in everything:
        rows = [witness.changes(omega, everything - {i}) for omega in witness.grid(60)]
        for part in hs.Part:
            found = Difference(scene, balls, everything - {i}, part).supremum()
            assert max(row[part] for row in rows) <= found.most + 1e-30  # the witness rounds too
            assert found.least <= found.most


KNOWN = {
    "a lag to its corner and beyond": (hs.Scene(SPRING, (LAG,), (0, 20)), 0.8, 0.5),
    "a lag below its corner": (hs.Scene(SPRING, (LAG,), (0, 5)), 0.2, 0.4),
    # 1 - cos and sin
    "a delay for half a turn": (hs.Scene(SPRING, (hs.effects.delay("0.1"),), (0, 35)), 2.0, 1.0),
    # |k - m omega^2| and |b omega| over k
    "a device": (hs.Scene(SPRING, (hs.effects.shunt(m=1, b=3),), (0, 15)), 2.25, 0.45),
    "a mass on a mass": (hs.Scene(hs.environments.mass_spring_damper(m=2), (hs.effects.shunt(m="-0.5"),), (0, 15)), 0.25, 0.0),
    "a damper on a mass, away from 0": (hs.Scene(hs.environments.mass_spring_damper(m=2), (hs.effects.shunt(b=3),), (2, 15)), 0.0, 0.75),
    # j (-j x)/(1 + j x) = (x - j x^2)/(1 + x^2) with x = 3 omega/60
    "a compliance on a damper": (hs.Scene(hs.environments.mass_spring_damper(b=3), (hs.effects.compliance(k=60),), (0, 40)), 0.5, 0.8),
    "no effect": (hs.Scene(SPRING, (hs.effects.series("1"),), (0, 40)), 0.0, 0.0),
    # -sin(omega tau), next to 15e-30 at the band's end
    "next to no delay": (hs.Scene(SPRING, (hs.effects.delay(Rational(1, 10**30)),)), None, 15e-30),
}  # fmt: skip


@pytest.mark.parametrize("name", KNOWN)
def test_the_largest_change_of_one_effect_is_the_one_known_in_closed_form(name: str) -> None:
    scene, *known = KNOWN[name]
    parts = [(part, value) for part, value in zip(hs.Part, known, strict=True) if value is not None]
    assert parts
    for part, value in parts:
        found = change(scene, set(), part).supremum()
        assert found.least <= value * (1 + 1e-12)
        assert value * (1 - 1e-12) <= found.most <= found.least + max(1.01e-6 * value, 1e-12)
        # no narrower than it takes to tell the side
        for limit in (0.9 * value, 1.1 * value) if value > 1e-9 else ():
            told = change(scene, set(), part).supremum(limit)
            assert (told.least > limit, told.most <= limit) == (value > limit, value < limit)


def test_a_change_is_that_of_the_modulus_not_of_the_part() -> None:
    """Springs of +30 and -40 N/m on one of 100: r_r is 0.1 with both and 0.3 with the first, though dH goes from 30 to -10."""
    scene = hs.Scene(SPRING, (hs.effects.shunt(k=30), hs.effects.shunt(k=-40)))
    for kept, exact in (({0}, 0.2), ({1}, 0.3), (set(), 0.1)):
        found = change(scene, kept, hs.Part.REAL).supremum()
        assert found.least <= exact <= found.most < exact * (1 + 1e-5)


def test_whether_a_change_stays_within_a_number_is_decided_exactly_where_it_just_does() -> None:
    tiny, lag = Rational(1, 10**40), change(hs.Scene(SPRING, (LAG,), (0, 20)), set(), hs.Part.IMAG)
    assert [lag.stays_within(Rational(1, 2) + x) for x in (-tiny, 0, tiny)] == [False, True, True]
    both = change(hs.Scene(SPRING, (hs.effects.shunt(k=30), hs.effects.shunt(k=-40))), {0}, hs.Part.REAL)
    assert [both.stays_within(Rational(1, 5) + x) for x in (-tiny, 0)] == [False, True]


def resonances(first: str, second: str) -> hs.Scene:
    """With its second effect of one value at the first resonance and of the opposite one at the second.

    So a - b is bounded at the one and a + b at the other, and the change, the smaller of both, everywhere.
    """
    p, q = Rational(first) ** 2, Rational(second) ** 2
    poles = hs.effects.series(f"({p}*{q})/((s^2 + {p})*(s^2 + {q}))")
    return hs.Scene(SPRING, (poles, hs.effects.series(f"1 + 2*(s^2 + {p})/({q} - {p})")), (0, 15))


def test_a_change_with_poles_of_each_of_its_functions_but_none_of_both_is_bounded() -> None:
    scene = resonances("3", "3.01")
    found, witness = change(scene, {0}, hs.Part.REAL).supremum(), Witness(scene)
    places = [MP.mpf(n) / 4000 + MP.mpf(10) ** -20 for n in range(12000, 12041)]
    values = [witness.changes(omega, frozenset({0}))[hs.Part.REAL] for omega in places]
    assert max(values) <= found.most < inf
    assert max(values) > found.least * MP.mpf("0.99")
    assert found.most - found.least <= 1.01e-6 * found.most


@pytest.mark.slow
def test_two_poles_too_near_each_other_to_be_told_apart_are_said_to_be_undecided() -> None:
    with pytest.raises(hs.UndecidedError, match=r"bounded near (3\.0000|2\.9999)"):
        change(resonances("3", "3.000000001"), {0}, hs.Part.REAL).supremum()


def test_a_common_pole_makes_a_change_unbounded_wherever_it_lies() -> None:
    scene = hs.Scene(SPRING, (hs.effects.series("9/(s^2 + 9)"), hs.effects.shunt(m=1, b=2)), (0, 15))
    assert change(scene, set(), hs.Part.REAL).supremum().least == inf
    alone = change(scene, {0}, hs.Part.IMAG).supremum()  # the damper's own ratio: no pole
    assert alone.least <= 0.3 <= alone.most < 0.3001


@pytest.mark.slow
def test_an_unbounded_influence_is_told_and_never_left_out_but_a_bounded_one_of_unbounded_ratios_may_be() -> None:
    undamped = hs.environments.mass_spring_damper(m=1, k=100)
    scene = hs.Scene(undamped, (hs.effects.second_order_lowpass(900, 1), hs.effects.shunt(b=1)))
    assert hs.evaluate(scene).unbounded  # at the resonance, with the filter and without it
    found = hs.relevance(scene, "0.1")
    assert [[x.change[part].is_finite for part in hs.Part] for x in found.effects] == [[True, True], [True, False]]
    assert names(found) == ["shunt"]
    check(scene, frozenset({1}))
    assert [x["influence"]["imag"] is None for x in found.to_dict()["effects"]] == [False, True]
    assert "Unbounded: " in str(found)


# --- on pieces of the band -------------------------------------------------------------------------------------------

CHAINS = {
    **ELSEWHERE,
    "a damper alone": hs.Scene(
        hs.environments.mass_spring_damper(b=3), (hs.effects.shunt(m="0.2 kg"), hs.effects.delay("9 ms")), (0, 40)
    ),
    "pi beside whole numbers, and what is rendered is another": hs.Scene(
        hs.environments.mass_spring_damper(2, 9, 150),
        (
            hs.effects.series("(s + a)*(s + b)/(s + 9)^2", parameters={"a": "2 Hz", "b": "7 rad/s"}),
            hs.effects.first_order_lag("8 Hz"),
        ),
        ("0.5 Hz", "3 Hz"), rendered=hs.environments.kelvin_voigt(120, 2),
    ),
    "a teleoperator with delay at fractional tissue": hs.Scene(
        hs.environments.spring_pot(k_alpha=50, alpha="0.37", k=20),
        (
            hs.effects.position_force_teleoperator(Mm="0.1 kg", Ms="0.1 kg", Bs=60, Ks=4000, tau="5 ms"),
            hs.effects.compliance(k=3000, b=2),
        ),
        (2, 30),
    ),
    "two resonances without damping": hs.Scene(
        hs.environments.expression("(s^2 + 49)*(s^2 + 121)*s/(s + 5)", parameters={}),
        (hs.effects.first_order_lag(30), hs.effects.zero_order_hold("5 ms"), hs.effects.series("-1.1")),
        (0, 20),
    ),
}  # fmt: skip


@pytest.mark.dear("a teleoperator with delay at fractional tissue")
@pytest.mark.few("a damper alone", "two resonances without damping", "a teleoperator with delay at fractional tissue")
@pytest.mark.parametrize("name", CHAINS)
def test_ranges_on_pieces_hold_all_values_and_are_reached(name: str) -> None:
    scene = CHAINS[name]
    balls, witness = BallChain(scene), Witness(scene)
    for piece in (BandPiece(), BandPiece(3, 6), BandPiece(9, 300), BandPiece(12, 0), BandPiece(12, 4095)):
        kept, (low, high) = frozenset({piece.depth % 2}), (MP.mpf(str(x.evalf(40))) for x in balls.ends(piece))
        shares = [MP.mpf(10) ** -12, MP.mpf("0.5"), 1 - MP.mpf(10) ** -12, *(MP.mpf(i) / 12 for i in range(1, 12))]
        rows = [witness.changes(low + (high - low) * x, kept) for x in shares]
        for part in hs.Part:
            with series_arithmetic():
                own = Difference(scene, balls, kept, part)
                found, middle = own.range(piece), own.at_middle(piece)
            values = [row[part] for row in rows]
            assert found.least <= min(values) * (1 + MP.mpf(10) ** -15)
            assert max(values) <= found.most
            assert middle <= values[1] <= middle * (1 + 1e-14) + 1e-24
            if found.most < inf:
                assert found.reached <= max(values) * (1 + MP.mpf(10) ** -8)
            if piece.depth >= 9 and found.most < inf:
                spread, rounding = max(values) - min(values), 1e-13 * max(values) + 1e-20
                assert found.most <= max(values) + spread + rounding
                assert found.least >= min(values) - spread - rounding
                assert found.reached == pytest.approx(float(max(values[:3])), rel=1e-6, abs=1e-15)


def test_pieces_tile_the_band() -> None:
    balls = BallChain(CHAINS["a teleoperator with delay at fractional tissue"])
    assert balls.ends(BandPiece()) == (2, 30)
    for piece in (BandPiece(), BandPiece(1, 1), BandPiece(5, 11)):
        (low, high), (a, b), (x, y) = (balls.ends(p) for p in (piece, *piece.halves()))
        assert (a, b, y) == (low, x, high)
        assert b - a == y - x > 0
        with series_arithmetic():
            assert balls.middle(piece).overlaps(flint.arb(flint.fmpq(int((low + high).p), int((low + high).q))) / 2)
            assert float(balls.radius(piece)) == float(high - low) / 2
    third = BallChain(hs.Scene(SPRING, (), (0, Rational(1, 3))))
    with series_arithmetic():
        assert third.radius(BandPiece()) > flint.arb(flint.fmpq(1, 6))  # rounded up, as it is no binary number


def test_the_order_of_a_zero_at_0_counts_delays_as_what_they_are() -> None:
    """sT - (1 - exp(-sT)) and products of 1 - exp(-sT) with delays that have no common measure."""
    effects = (hs.effects.zero_order_hold("5 ms"), hs.effects.zero_order_hold(pi / 1000), hs.effects.first_order_lag(9))
    ring = hs.Scene(SPRING, effects).distortion().chain.ring
    e, f = exp(-s / 200), exp(-s * pi / 1000)
    for form, order in (
        (1 - e, 1), (1 - f, 1), (e - f, 1), (s, 1), (s * (1 - e) ** 2, 3), (s / 200 - (1 - e), 2), (s + 1, 0), (e, 0),
        ((1 - e) * (1 - f), 2), ((1 - e) * pi / 1000 - (1 - f) / 200, 2), (1 - e * f, 1), (s**4, 4), (s - s, inf),
    ):  # fmt: skip
        assert ring.order_at_0(ring.convert(form).numerator) == order, form


def test_one_effect_dominates_up_to_where_another_one_changes_as_much() -> None:
    """A spring of 20 N/m and a damper of 4 N s/m on 100 N/m: 0.2 and 0.04 omega, alike at 5 rad/s."""
    scene = hs.Scene(SPRING, (hs.effects.shunt(k=20, name="spring"), hs.effects.shunt(b=4, name="damper")), (0, 20))
    first, second = hs.relevance(scene).dominance
    assert (first.effect.name, first.low, second.effect.name, second.high) == ("spring", 0, "damper", 20)
    assert 5 - Rational(20, 1000) <= first.high <= 5 <= second.low <= 5 + Rational(20, 1000)
    [alone] = hs.relevance(hs.Scene(SPRING, (LAG,), (1, 20))).dominance
    assert (alone.low, alone.high) == (1, 20)


@pytest.mark.few("sidestick")
@pytest.mark.parametrize("name", ["sidestick", "zener-tissue"])
def test_where_an_effect_is_said_to_dominate_it_does(name: str) -> None:
    scene = hs.load_scene(name)
    found, witness = hs.relevance(scene), Witness(scene)
    everything = frozenset(range(len(scene.effects)))
    assert len({x.effect.name for x in found.dominance}) == 2
    for x in found.dominance:
        low, high = (MP.mpf(str(end.evalf(40))) for end in (x.low, x.high))
        for k in range(1, 12):
            omega = low + (high - low) * k / 12
            sizes = [max(witness.changes(omega, everything - {i}).values()) for i in everything]
            assert sizes.index(max(sizes)) == scene.effects.index(x.effect)


# --- choices ---------------------------------------------------------------------------------------------------------


def gains(*values: Any) -> hs.Scene:
    return hs.Scene(SPRING, tuple(hs.effects.series(str(x), name=f"g{i}") for i, x in enumerate(values)), (0, 15))


def names(found: Relevance) -> list[str]:
    return [e.name for e in found.pruned.effects]


@pytest.mark.dear("0", "3")
@pytest.mark.parametrize("seed", range(6))
def test_of_all_sets_that_stay_within_the_tolerance_the_smallest_with_the_lowest_bound_is_kept(seed: int) -> None:
    """Gains g_i on a spring: r_r is the distance of their product from 1. All sets are gone through in fractions."""
    pick = Random(seed)
    for _ in range(3):
        own = [1 + Fraction(pick.choice([-1, 1]) * pick.randint(1, 40), 10 ** pick.choice([2, 3, 4])) for _ in range(pick.randint(1, 4))]  # fmt: skip
        tolerance = Fraction(pick.randint(1, 300), 7001)
        ratio = {
            frozenset(kept): abs(prod((own[i] for i in kept), start=Fraction(1)) - 1)
            for n in range(len(own) + 1)
            for kept in combinations(range(len(own)), n)
        }
        everything = frozenset(range(len(own)))
        off = {kept: abs(x - ratio[everything]) for kept, x in ratio.items()}
        allowed = [kept for kept, x in off.items() if x <= tolerance]
        best = min(allowed, key=lambda kept: (len(kept), off[kept]))
        found = hs.relevance(gains(*own), Rational(tolerance))
        assert (names(found), found.smallest) == ([f"g{i}" for i in sorted(best)], True)
        bound = found.bound[hs.Part.REAL]
        assert Fraction(bound.least) <= off[best] + Fraction(1, 10**15)
        assert off[best] <= Fraction(bound.most) <= off[best] * (1 + Fraction(1, 10**6)) + Fraction(1, 10**11)
        assert found.to_dict()["bound"]["real"] == bound.most


def test_of_many_effects_a_small_set_is_found_if_not_surely_the_smallest() -> None:
    """More than twelve: they are left out one by one."""
    values = ["1.5", "0.5", "1.3", "1.2", "0.7", "1.9", "0.6", *(f"1.00{n}" for n in range(1, 10))]
    found = hs.relevance(gains(*values[:14]), "0.05")
    product = prod(Rational(x) for x in values[:14])
    off = abs(product - 1) - abs(prod(Rational(values[int(x[1:])]) for x in names(found)) - 1)
    bound = found.bound[hs.Part.REAL]
    assert bound.least <= abs(off) <= bound.most <= 0.05
    assert len(names(found)) < 10


def test_a_tolerance_that_is_just_reached_is_kept() -> None:
    """By a gain; and at one frequency alone, which no sample meets: 1/2 at the corner of a lag, the ends of a band."""
    for limit in (Rational(1, 100), Rational(1, 3), Rational(5, 3)):
        found = hs.relevance(hs.Scene(SPRING, (hs.effects.series(str(1 - limit)),)), limit)
        bound = found.bound[hs.Part.REAL].most
        assert names(found) == []
        assert limit <= Rational(*bound.as_integer_ratio())
        assert bound <= nextafter(nextafter(float(limit), inf), inf)
    gain = hs.Scene(SPRING, (hs.effects.series("0.99"),))
    assert len(names(hs.relevance(gain, "0.00999999999999"))) == 1
    lag = hs.Scene(SPRING, (LAG,), (0, 11), hs.Threshold.of(5, 5))  # r_r is 121/221 at the end of the band
    assert [names(hs.relevance(lag, x)) for x in ("0.54", "0.55", "0.5476")] == [["first-order-lag"], [], []]
    imag = hs.Scene(hs.environments.mass_spring_damper(b=3), (hs.effects.shunt(k=10),), (2, 15))  # r_r = 10/(3 omega)
    ends = [names(hs.relevance(imag, x)) for x in (Rational(5, 3), Rational(5, 3) - Rational(1, 10**30))]
    assert ends == [[], ["shunt"]]


def test_effects_without_influence_and_those_that_make_up_for_each_other_are_left_out() -> None:
    nothing = (
        hs.effects.series("(s + 3)/(3 + s)", name="nothing"),
        hs.effects.first_order_lag(20),
        hs.effects.delay(0),
    )
    found = hs.relevance(hs.Scene(SPRING, nothing), 0)
    assert names(found) == ["first-order-lag"]
    influences = [{part: x.change[part].most for part in hs.Part} for x in found.effects]
    assert influences[0] == influences[2] == {hs.Part.REAL: 0.0, hs.Part.IMAG: 0.0}
    mass = (hs.effects.shunt(m="2 kg", name="mass"), hs.effects.shunt(m="-2 kg", name="compensation"))
    found = hs.relevance(hs.Scene(SPRING, (*mass, hs.effects.first_order_lag(20))))
    assert names(found) == ["first-order-lag"]
    assert all(x.change[hs.Part.REAL].least > 1 for x in found.effects[:2])
    assert all(x.most == 0 for x in found.bound.values())
    alone = hs.relevance(hs.Scene(SPRING))
    assert (alone.effects, alone.dominance, alone.crossings, alone.bound[hs.Part.REAL].most) == ((), (), (), 0)


def test_a_larger_tolerance_keeps_no_more_effects() -> None:
    scene = hs.load_scene("steering-wheel")
    sizes = [len(names(hs.relevance(scene, t))) for t in ("0", "0.03", "0.5", "10")]
    assert sizes == sorted(sizes, reverse=True)
    assert (sizes[0], sizes[-1]) == (3, 0)


@pytest.mark.slow
def test_units_of_force_do_not_change_influences() -> None:
    case = strategies.case(strategies.Seeded(3))
    ones, others = (hs.relevance(strategies.scene(x)) for x in (case, strategies.scaled(case, force=Fraction(7))))
    assert [x.kept for x in ones.effects] == [x.kept for x in others.effects]
    for a, b in zip(ones.effects, others.effects, strict=True):
        for part in hs.Part:
            assert isclose(a.change[part].most, b.change[part].most, rel_tol=2 * WIDTH, abs_tol=2e-12)


# --- a scene of many effects -----------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def many() -> Relevance:
    return hs.relevance(hs.load_scene(MANY))


def test_two_of_ten_effects_matter_and_the_formula_is_five_times_shorter(many: Relevance) -> None:
    assert (len(many.scene.effects), names(many), many.smallest) == (10, ["force-loop", "grip"], True)
    full, kept = many.operations
    assert full >= 5 * kept


def test_an_evaluation_with_a_tolerance_and_a_simulation_are_those_of_the_pruned_scene() -> None:
    scene = hs.Scene(SPRING, (LAG, hs.effects.series("1.004", name="gain")))
    told, found = hs.evaluate(scene, tolerance="0.01"), hs.relevance(scene, "0.01")
    assert [x.omega.digits(15) for x in told.crossings] == [
        x.omega.digits(15) for x in hs.evaluate(found.pruned).crossings
    ]
    row = told.to_dict()["relevance"]
    assert (row["kept"], row["dropped"], row["tolerance"]) == (["first-order-lag"], ["gain"], 0.01)
    assert row["bound"] == {part.value: x.most for part, x in found.bound.items()}
    assert "Without gain" in str(told)
    run = hs.simulate(found.pruned, hs.sine("1 cm", 5), duration="0.1 s")
    assert run.built == ("mass-spring-damper", "first-order-lag")


def test_every_smaller_set_of_effects_breaks_the_tolerance_somewhere(many: Relevance) -> None:
    witness = Witness(many.scene)
    grid = witness.grid(10)
    for kept in (frozenset(), *(frozenset({i}) for i in range(10))):
        assert any(max(witness.changes(omega, kept).values()) > 0.01 for omega in reversed(grid)), kept


@pytest.mark.slow
def test_the_joint_bound_holds_for_all_left_out_effects_together(many: Relevance) -> None:
    check(many.scene, frozenset(i for i, e in enumerate(many.scene.effects) if e in many.pruned.effects))
    assert all(x.most <= 0.01 for x in many.bound.values())
    told = json.loads(json.dumps(many.to_dict()))
    assert set(told["effects"][0]) == {"name", "model", "influence", "kept"}
    assert [x["name"] for x in told["effects"] if x["kept"]] == ["force-loop", "grip"]


# --- crossings of the full scene -------------------------------------------------------------------------------------


def encloses(scene: hs.Scene, found: Relevance) -> None:
    """All crossings of the full scene lie in the intervals, at least one in each that is certain."""
    full = [(x.criterion.name, float(x.omega)) for x in hs.evaluate(scene).crossings]
    for name, omega in full:
        assert any(x.criterion.name == name and x.bounds[0] <= omega <= x.bounds[1] for x in found.crossings)
    for x in found.crossings:
        inside = [w for name, w in full if name == x.criterion.name and x.bounds[0] <= w <= x.bounds[1]]
        assert inside or not x.certain
    lows = [float(x.low) for x in found.crossings]
    assert lows == sorted(lows)


@pytest.mark.few("helicopter-cyclic")
@pytest.mark.parametrize("name", [MANY, "helicopter-cyclic", "desktop-device-soft-tissue"])
def test_the_enclosures_hold_all_crossings_of_the_full_scene(name: str) -> None:
    encloses(hs.load_scene(name), hs.relevance(hs.load_scene(name), "0.05"))


QUICK = "{name = 'quick', model = 'first-order-lag', omega_c = 4000}"


@pytest.mark.parametrize("jnd", ["'0.08 + 0.001*omega'", "'0.005 + 0.004*omega'"])
def test_crossings_of_limits_that_grow_are_enclosed_though_an_effect_is_left_out(jnd: str) -> None:
    """Of the second limit the tolerance itself is more, next to 0 rad/s."""
    found = hs.relevance(quick(jnd))
    assert [x.name for x in found.dropped] == ["quick"]
    assert found.crossings
    encloses(quick(jnd), found)


def quick(jnd: str) -> hs.Scene:
    return hs.parse_scene(f"""
        environment = {{model = "mass-spring-damper", m = 1.8, b = 15, k = 100}}
        effects = [{{model = "second-order-lowpass", omega_n = 80, zeta = "0.5"}}, {QUICK}]
        evaluation = {{band = [0, 15], jnd = {jnd}}}
    """)


@pytest.mark.parametrize("jnd", ["{shape = 'diamond', real = 0.1, imag = 0.1}", "{real = 0.1, imag = 0.1, floor = 5}"])
def test_crossings_of_a_region_may_be_anywhere_on_the_band(jnd: str) -> None:
    found = hs.relevance(quick(jnd))
    assert {(x.bounds, x.certain) for x in found.crossings} == {((0, 15), False)}


def test_crossings_lie_between_those_of_both_levels() -> None:
    """Behind a lag r_i = x/(1 + x^2); a gain of 1.02 after it adds 0.02 at most, so the levels are 0.1 -+ 0.02 and a bit."""
    scene = hs.Scene(SPRING, (LAG, hs.effects.series("1.02", name="gain")), (0, 5))
    found = hs.relevance(scene, "0.03")
    assert names(found) == ["first-order-lag"]
    [imag] = [x for x in found.crossings if x.part is hs.Part.IMAG]
    bound = found.bound[hs.Part.IMAG].most
    ends = [10 * (1 - sqrt(1 - 4 * c * c)) / (2 * c) for c in (0.1 - bound, 0.1 + bound)]
    assert [float(imag.low), float(imag.high)] == pytest.approx(ends, rel=1e-12)
    assert imag.certain
    encloses(scene, found)


def test_the_ends_of_an_enclosure_are_the_nearest_floats_that_hold_it() -> None:
    """What a float can say exactly is said so."""
    draw, criterion = Random(1), noticed(hs.Scene(SPRING).threshold)[0]
    for _ in range(60):
        low, high = sorted(Rational(draw.randint(1, 10**6), draw.choice([1, 3, 8, 2**20])) for _ in range(2))
        down, up = CrossingEnclosure(criterion, ExactNumber(low), ExactNumber(high), certain=True).bounds
        assert Fraction(down) <= low < Fraction(nextafter(down, inf))
        assert Fraction(nextafter(up, 0)) < high <= Fraction(up)


def test_with_nothing_left_out_crossings_are_those_of_the_scene() -> None:
    scene = hs.load_scene("fu2019")
    found = hs.relevance(scene, 0)
    assert found.dropped == ()
    assert [(x.part, float(x.low), float(x.high)) for x in found.crossings] == [
        (c.part, float(c.omega), float(c.omega)) for c in hs.evaluate(scene).crossings
    ]


def test_with_a_tolerance_above_the_threshold_crossings_may_lie_anywhere_below_the_upper_level() -> None:
    """A change of up to 0.2 beside a threshold of 0.1: where the kept ratio is below 0.3 nothing is known."""
    scene = hs.Scene(SPRING, (LAG, hs.effects.series("1.2", name="gain")), (0, 40))
    found = hs.relevance(scene, "0.3")
    assert names(found) == ["first-order-lag"]
    assert not any(x.certain for x in found.crossings)
    encloses(scene, found)
    [real], c = [x for x in found.crossings if x.part is hs.Part.REAL], 0.1 + found.bound[hs.Part.REAL].most
    assert (float(real.low), float(real.high)) == (0, pytest.approx(10 * sqrt(c / (1 - c)), rel=1e-12))
    [exact] = hs.relevance(hs.Scene(SPRING, (hs.effects.series("1.1"),), (0, 40)), "0.1").crossings  # the threshold
    assert (exact.part, float(exact.low), float(exact.high), exact.certain) == (hs.Part.REAL, 0, 40, False)


@pytest.mark.dear("0.4-band2-told2")
@pytest.mark.parametrize(
    ("limit", "band", "told"),
    [
        ("0.5", (0, 40), [(10, False)]),  # returns to the same side: of the levels 0.46 and 0.54 only the lower is met
        ("0.4", (0, 40), [(5, True), (20, True)]),
        ("0.4", (5, 20), [(5, False), (20, False)]),  # cut by the end of the band
        ("0.4", (0, 5), [(5, False)]),
        ("0.4", (20, 40), [(20, False)]),
    ],
)
def test_an_interval_is_certain_where_the_ratio_comes_from_one_side_and_leaves_to_the_other(
    limit: str, band: tuple[int, int], told: list[tuple[int, bool]]
) -> None:
    """r_i of a lag, at most 1/2 at 10 rad/s, and 0.4 at 5 and 20 rad/s."""
    effects = (LAG, hs.effects.series("1.04", name="gain"))
    found = hs.relevance(hs.Scene(SPRING, effects, band, hs.Threshold.of(5, limit)), "0.05")
    assert names(found) == ["first-order-lag"]
    assert [x.certain for x in found.crossings] == [certain for _, certain in told]
    for x, (omega, _) in zip(found.crossings, told, strict=True):
        assert x.part is hs.Part.IMAG
        assert band[0] <= float(x.low) <= omega <= float(x.high) <= band[1]
        assert float(x.low) < float(x.high)


# --- what is refused -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("scene", "tolerance", "words"),
    [
        *((hs.Scene(SPRING, (LAG,)), given, "tolerance") for given in ("-0.01", "nan", "much", "1 kg", True)),
        (hs.Scene(SPRING, (hs.effects.first_order_lag(hs.symbols("w")),)), "0.01", "omega_c = w is a symbol"),
    ],
)
def test_a_tolerance_that_is_none_and_open_parameters_are_refused(scene: hs.Scene, tolerance: Any, words: str) -> None:
    with pytest.raises(hs.SceneError, match=words):
        hs.relevance(scene, tolerance)


@pytest.mark.parametrize(("k", "kept"), [("5", []), ("5.00000000000000000000001", ["shunt"])])
def test_what_just_reaches_the_tolerance_stays_within_it(k: str, kept: list[str]) -> None:
    """Leaving out a shunt changes r_r by k/100 at all frequencies, and by a lag no ratio by more than its own 1.5 %."""
    scene = hs.Scene(SPRING, (hs.effects.shunt(k=k), hs.effects.first_order_lag(1000)), (0, 15))
    assert [x.name for x in hs.relevance(scene, "5 %").pruned.effects] == kept
