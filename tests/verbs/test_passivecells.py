"""For which values every passive hand may hold a display with delays or powers of s: against conditions by hand, and single verdicts."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise, product
from math import prod
from random import Random
from types import SimpleNamespace
from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sympy import Integer, Rational, Symbol, exp, sqrt

import haptisym as hs
from haptisym.kernel.budget import _budget, limited, tick
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.symbols import s
from haptisym.model.distortion import Distortion
from haptisym.model.parameters import Rule, values
from haptisym.verbs.require import energyterms, passivecells
from haptisym.verbs.require.energy import Energy
from haptisym.verbs.require.energyterms import Term, ends_of, variables
from haptisym.verbs.require.exactsigns import ExactSign, is_between, keeps_sign, zeros_of
from haptisym.verbs.require.freeparameter import Domain
from haptisym.verbs.require.passivecells import _Cell, _Search, _window

LATE = hs.Scene(
    hs.environments.mass_spring_damper(k=100), (hs.effects.delay("5 ms"), hs.effects.shunt(m="0.1 kg", b="1 N*s/m"))
)
TISSUE = hs.Scene(
    hs.environments.spring_pot(k_alpha=20, alpha="0.5", k=100),
    (hs.effects.first_order_lag(80), hs.effects.shunt(b="1 N*s/m")),
)


def ends(r: Any) -> list[tuple[float | None, float | None]]:
    return [tuple(None if e.value is None else float(e.value) for e in (x.low, x.high)) for x in r.feasible]  # type: ignore[misc]


@pytest.mark.few("effects.shunt.m-span2")
@pytest.mark.parametrize(
    ("free", "span"),
    [
        ("environment.k", (0, 200)),
        ("effects.shunt.b", (0.5, None)),
        ("effects.shunt.m", (0, None)),
        ("tau", (0, 0.01)),
    ],
)
def test_a_late_spring_is_passive_where_its_damper_makes_up_for_the_delay(free: str, span: Any) -> None:
    """b omega - k sin(omega tau) >= 0 for all omega: k tau <= b, ends included; no mass changes that, and none below 0 will do."""
    r = hs.require(LATE, free, that="passive")
    [found] = ends(r)
    assert [x for x in found if x is not None] == pytest.approx([x for x in span if x is not None], rel=1e-15)
    assert (found[1] is None) is (span[1] is None)
    turned = [x for x in r.ends if x.bindings]
    if free == "effects.shunt.m":
        [end] = turned
        assert (end.closed, [(b.kind.value, b.omega) for b in end.bindings]) == (True, [("far-out", None)])
        assert r.certified
    else:
        [end] = turned
        assert end.closed
        assert [(b.kind.value, float(b.omega)) for b in end.bindings if b.omega] == [("start", 0.0)]


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_a_range_that_ends_where_passivity_does_is_told_up_to_its_end(seed: int) -> None:
    """k (tau + 1/omega_c) = b: from either side nothing is left open beside it."""
    random = Random(seed)
    tau, b, c = Rational(random.randint(1, 20), 1000), Rational(random.randint(1, 9), 4), random.randint(20, 90)
    lagging = seed % 2
    most = b / (tau + (Rational(1, c) if lagging else 0))
    late = hs.Scene(
        hs.environments.mass_spring_damper(k=50),
        (hs.effects.delay(tau), *([hs.effects.first_order_lag(c)] if lagging else []), hs.effects.shunt(m="1/10", b=b)),
    )
    for span, expected in (
        ((most / 2, most), (most / 2, most)),
        ((most, 3 * most), (most, most)),
        ((0, most), (0, most)),
    ):
        r = hs.require(late, "environment.k", span, that="passive")
        assert r.undecided == ()
        assert ends(r) == [pytest.approx([float(x) for x in expected], rel=1e-15)]
        assert r.feasible[0].high.closed
    b_least = hs.require(late.with_values({"environment.k": most}), "effects.shunt.b", (b, 2 * b), that="passive")
    assert (b_least.undecided, ends(b_least)) == ((), [pytest.approx([float(b), float(2 * b)], rel=1e-15)])


@pytest.mark.slow
def test_what_begins_active_is_told_for_all_values_however_small_or_large() -> None:
    """Just above frequency 0 Im H has the sign of b - k tau; without a damper a spring that is late at all is active."""
    late = hs.require(LATE, "tau", that="passive")
    assert late.certified
    assert ends(late) == [(0.0, pytest.approx(0.01, rel=1e-15))]
    assert (ends(hs.require("delayed-spring", "tau", that="passive")), ends(hs.require("delayed-spring", "k", that="passive"))) == (
        [(0.0, 0.0)], [],
    )  # fmt: skip


@pytest.mark.slow
def test_what_is_not_shown_is_said_to_be_open() -> None:
    damped = hs.Scene(hs.environments.kelvin_voigt(100, 1), (hs.effects.delay("5 ms"), hs.effects.shunt(b=3)))
    r = hs.require(damped, "environment.b", that="passive")
    [(low, high)] = r.undecided
    assert 0 < float(high) - float(low) < 0.01
    assert not r.certified
    assert 2.99 < float(low) < 3  # where it prevails far out, and as late, as the damper that is not
    link, base = hs.effects.wave_variables(10, "20 ms"), hs.effects.shunt(m="0.1 kg")
    scene = hs.Scene(hs.environments.mass_spring_damper("0.5 kg", 0, 30), (link, base))
    lossless = hs.require(scene, "effects.shunt.m", (0, 5), that="passive")
    assert not lossless.feasible
    said = " ".join(str(lossless).split())
    assert "for the values from 0 to 5 neither was proven: whether every passive hand may hold it: Im H_perc" in said
    assert "About all others" not in said  # there are none
    told = hs.require(
        "wave-variable-link", "environment.m", that="passive"
    )  # all of it takes energy, whatever the mass is
    assert (told.undecided, [x.high.value for x in told.feasible]) == ((), [None])
    assert "About all others everything is" in " ".join(str(r).split())


@pytest.mark.slow
@pytest.mark.parametrize("free", ["omega_c", "environment.k_alpha"])
def test_a_lagging_tissue_is_told_but_for_a_sliver_at_each_end(free: str) -> None:
    r = hs.require(TISSUE, free, (1, 1000), that="passive")
    [span] = r.feasible
    assert sum(float(b) - float(a) for a, b in r.undecided if a and b) < 0.2
    for at in np.linspace(1, 1000, 23).tolist() + [
        float(x) * y for x in (span.low.value, span.high.value) if x for y in (0.98, 1.02)
    ]:
        value = Rational(str(round(at, 6)))
        if not 1 <= value <= 1000:
            continue
        holds = hs.stability(TISSUE.with_values({free: value})).every_passive_hand.holds
        assert span.low.value is not None
        assert span.high.value is not None
        assert holds is (float(span.low.value) <= at <= float(span.high.value))


def test_friction_beside_a_delay_stays_open() -> None:
    rough = hs.Scene(
        hs.environments.mass_spring_damper(k=100),
        (hs.effects.delay("5 ms"), hs.effects.coulomb_friction("1 N", "1 cm")),
    )
    r = hs.require(rough, "environment.k", that="passive")
    assert (r.feasible, len(r.undecided)) == ((), 1)
    assert "friction" in str(r)


def test_a_pole_on_the_right_is_no_passivity_though_the_axis_shows_none() -> None:
    """-5/(s - 1) + ...: Im H > 0 at all frequencies, and a pole at 1."""
    lively = hs.environments.expression("k + 3*s + 5*s/(s - 1)", parameters={"k": "50 N/m"})
    found = hs.Scene(lively, (hs.effects.delay("1 ms"), hs.effects.shunt(b="100 N*s/m")))
    r = hs.require(found, "environment.k", (10, 100), that="passive")
    assert (r.feasible, len(r.undecided)) == ((), 1)


@pytest.mark.parametrize("seed", [2, *(pytest.param(n, marks=pytest.mark.slow) for n in range(3, 12))])
def test_single_verdicts_agree_with_the_cells(seed: int) -> None:
    rng = np.random.default_rng(seed)
    m, b, k, w, tau, B = (Rational(int(x), 100) for x in rng.integers(1, 2000, 6))
    late = hs.Scene(
        hs.environments.mass_spring_damper(b=b / 10, k=k),
        (hs.effects.first_order_lag(w * 20), hs.effects.delay(tau / 1000), hs.effects.shunt(m=m / 100, b=B / 10)),
    )
    free = ("environment.k", "environment.b", "omega_c", "effects.shunt.b")[seed % 4]
    at = late.knobs[free].value
    r = hs.require(late, free, (at / 10, at * 10), that="passive")
    for share in (2, 3, 8, 15, 40, 90):
        value = at * Rational(share, 10)
        if any(a is not None and b is not None and float(a) <= value <= float(b) for a, b in r.undecided):
            continue
        inside = any(
            float(s.low.value) <= value <= float(s.high.value) for s in r.feasible if s.low.value and s.high.value
        )
        assert hs.stability(late.with_values({free: value})).every_passive_hand.holds is inside


def test_the_function_of_the_cells_has_the_sign_of_the_imaginary_part() -> None:
    for scene, free, span in (
        (LATE, "tau", (0.004, 0.0042)),
        (TISSUE, "omega_c", (60.0, 62.0)),
        (LATE, "environment.k", (150.0, 160.0)),
    ):
        knob = scene.knobs[free]
        form = Energy.of(
            Distortion.of(scene.chain.at(values(x for x in scene.parameters if x.path != free))).perc, knob.symbol
        )
        for omega in (0.3, 7.0, 90.0, 700.0):
            low, high = form._bounds(np.array([omega]), span)
            for q in span:
                now = scene.with_values({free: q}).distortion().perceived
                s = next(iter(now.free_symbols))
                exact = mpmath.mpmathify(complex(now.subs(s, 1j * omega).evalf(30)).imag)
                assert low[0] * exact > 0 or high[0] * exact > 0 or low[0] <= 0 <= high[0]
                assert (low[0] <= 0) or exact > 0
                assert (high[0] >= 0) or exact < 0


@pytest.mark.parametrize("power", ["999999999/1000000000", "1/2", "13/3", "-7/5", "1000000001/1000000000"])
def test_the_turn_of_a_power_is_known_to_the_last_digits_near_an_odd_one_too(power: str) -> None:
    """cos(pi p/2) is some 1.6e-9 there, of which floats that come from pi p/2 have nine digits."""
    with mpmath.workdps(40):
        angle = mpmath.pi * mpmath.mpf(Rational(power).p) / Rational(power).q / 2
        expected = float(mpmath.cos(angle)), float(mpmath.sin(angle))
    found = Term(Rational(power), Integer(0), Integer(1)).turned
    assert found == pytest.approx(expected, rel=4e-16, abs=0)


@given(st.fractions(), st.fractions())
def test_the_floats_of_a_cell_hold_all_its_values_and_hardly_more(x: Fraction, y: Fraction) -> None:
    low, high = (Rational(z.numerator, z.denominator) for z in sorted((x, y)))
    a, b = (Fraction(z) for z in energyterms.span(low, high))
    assert a <= min(x, y) <= max(x, y) <= b
    assert min(x, y) - a <= abs(min(x, y)) * Fraction(1, 1 << 52)


def test_values_and_ranges_in_hertz_are_cut_like_any_others() -> None:
    """b >= k (tau + 1/omega_c): omega_c >= 200/3 rad/s, however the scene and the question write it."""
    late = hs.Scene(
        hs.environments.mass_spring_damper(k=100),
        (hs.effects.delay("5 ms"), hs.effects.first_order_lag("12 Hz"), hs.effects.shunt(m="0.1 kg", b="2 N*s/m")),
    )
    r = hs.require(late, "omega_c", ("10 Hz", "100 Hz"), that="passive")
    assert r.certified
    assert ends(r) == [pytest.approx((200 / 3, 200 * np.pi), rel=1e-15)]
    [span] = r.feasible
    assert span.low.closed
    assert span.high.closed


def test_what_h_perc_does_not_hold_settles_for_all_values_at_once() -> None:
    r = hs.require(TISSUE, "evaluation.jnd", that="passive")
    assert (r.certified, ends(r)) == (True, [(0, None)])


def test_a_cell_of_which_the_one_verdict_stays_open_is_not_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(passivecells, "passivity", lambda _: SimpleNamespace(holds=None))
    r = hs.require(LATE, "effects.shunt.b", (1, "1.0005"), that="passive")
    assert (r.feasible, [(float(a), float(b)) for a, b in r.undecided if a and b]) == ((), [(1, 1.0005)])


def test_values_beyond_an_end_are_asked_about_from_inside_of_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is shown from a float on holds from the end on only if the float is not beyond it."""
    asked = list[float]()
    search = _Search(LATE, LATE.knobs["effects.shunt.m"])
    monkeypatch.setattr(search.energy, "beyond", lambda end, _: asked.append(end))
    for end in (Rational(1, 10), Rational(1, 3), Rational(2, 3)):
        for side in (-1, 1):
            search.beyond(end, side, here=None)
            assert (Rational(asked[-1]) - end) * side <= 0


def test_a_growing_mass_says_nothing_of_what_comes_before_it_is_asked_for() -> None:
    """Of m s^2 exp(s tau) every one is active somewhere, however large its mass: only what is not early adds to what it takes."""
    ring = Ring.of([Symbol("m"), exp(-s)])
    early = ring.convert((s + s**2 * Symbol("m")) * exp(s))
    assert Energy.of(early, Symbol("m")).beyond(1.0, 1) is not True


def test_late_terms_of_one_delay_are_weighed_together() -> None:
    """(q - 1) s late beside a damper: |q - 1| <= 5, of which q s and s apart would tell no more than q <= 4."""
    late = hs.environments.expression("q*s - s", parameters={"q": "3/2"})
    r = hs.require(hs.Scene(late, (hs.effects.delay("1 ms"), hs.effects.shunt(b=5))), "q", (2, 8), that="passive")
    assert ends(r) == [(2, pytest.approx(6, rel=1e-3))]
    [(low, high)] = r.undecided
    assert low is not None
    assert high is not None
    assert 5.99 < float(low) < 6 < float(high) < 6.01


@pytest.mark.slow
def test_what_was_not_proven_is_not_rounded_away() -> None:
    """What is open is told from below to above, what is proven from above to below."""
    r = hs.require(TISSUE, "omega_c", (1, 1000), that="passive")
    [(low, high)] = r.undecided
    assert low is not None
    assert high is not None
    words = " ".join(str(r).split())
    proven = float(words.split("proven, for ")[1].split(" ≤")[0])
    first, last = (float(x) for x in words.split("for the values from ")[1].split(" neither")[0].split(" to "))
    assert first <= float(low) < float(high) <= last
    assert float(high) <= proven <= 1.001 * float(high)


def test_values_that_are_open_without_bound_below_begin_at_minus_infinity() -> None:
    squared = hs.Scene(hs.environments.expression("90 + g^2*s + 3*s^0.5", parameters={"g": 1}))
    words = " ".join(str(hs.require(squared, "g", that="passive")).split())
    assert (
        "UNDECIDED: for the values from minus infinity to -1000 and from 1000 to infinity neither was proven" in words
    )


@pytest.mark.parametrize(
    ("formula", "span"),
    [
        ("g*s + 20*s^0.5", (0, None)),
        ("g*s + 20*s^0.5 + 7", (0, None)),
        ("(g - 3)*s + 20*s^0.5", (3, None)),
        ("g*s^2 + s + 20*s^0.5", (0, None)),
        ("g*s^3 + s + 20*s^0.5", (0, 0)),
        ("100 + g*s + s^1.5", (0, None)),
        ("(5 - g)*s + s^1.5 + 100", (None, 5)),
    ],
)
def test_what_must_not_be_negative_far_out_or_near_rest_ends_the_values_exactly(formula: str, span: Any) -> None:
    """The damping where it prevails, at rest or far out; a mass; where a third power prevails only none of it will do."""
    scene = hs.Scene(hs.environments.expression(formula, parameters={"g": 1}))
    r = hs.require(scene, "g", that="passive")
    assert r.certified
    assert ends(r) == [span]
    assert all(x.closed for y in r.feasible for x in (y.low, y.high) if x.value is not None)


@pytest.mark.parametrize(
    ("scene", "free", "values"),
    [
        (hs.load_scene("satellite-contact"), "effects.loop-delay.tau", [(0, 0)]),
        (hs.load_scene("organ-tissue"), "tau", []),
        (hs.load_scene("organ-tissue"), "omega_c", []),
        (hs.load_scene("delayed-spring"), "tau", [(0, 0)]),
    ],
)
def test_where_all_that_prevails_far_out_comes_late_no_delay_will_do(
    scene: hs.Scene, free: str, values: list[tuple[float, float]]
) -> None:
    """It turns on and on, and is active again and again: however short the delay, and whatever else the number is."""
    r = hs.require(scene, free, that="passive")
    assert r.certified
    assert ends(r) == values
    if values:  # 0 is the end of what was asked about, and binds from above
        assert "far-out" in {b.kind.value for x in r.ends for b in x.bindings}
        assert "at high frequencies" in str(r)


@pytest.mark.parametrize("seed", range(6))
def test_what_stands_before_powers_of_omega_is_that_of_complex_numbers(seed: int) -> None:
    """Im(N conj D) at omega = 4 of sums of s^(n/2), but what is turned by no whole quarter."""
    pick = Random(seed)
    rows = [
        [
            energyterms.Term(Rational(n, 2), Integer(0), Integer(pick.randint(-5, 5)))
            for n in pick.sample(range(7), pick.randint(1, 4))
        ]
        for _ in range(2)
    ]
    found, unknown = energyterms.paired(*(energyterms.endings(row) for row in rows))
    true, left = 0.0, set()
    for x, y in product(*rows):
        power = x.power + y.power
        if (x.power - y.power).is_Integer:
            true += float(x.number * y.number) * ((4j) ** float(x.power) * ((4j) ** float(y.power)).conjugate()).imag
        else:
            left.add(power)
    assert set(unknown) == left
    assert sum(float(c) * 4.0 ** float(p) for p, c in found.items()) == pytest.approx(true, abs=1e-9)
    assert 0 not in found.values()


def test_the_sign_of_a_polynomial_between_two_values_is_that_of_samples() -> None:
    pick, q = Random(2), Symbol("q", real=True)
    for _ in range(60):
        zeros, lead = [Rational(pick.randint(-6, 6), 2) for _ in range(pick.randint(0, 3))], pick.choice([-2, 1])
        form = prod((q - x for x in zeros), start=Integer(lead)).expand()
        low, high = Rational(pick.randint(-9, 0), 2), Rational(pick.randint(1, 9), 2)
        for a, b in ((low, high), (None, high), (low, None), (None, None)):
            samples = np.linspace(-9 if a is None else float(a), 9 if b is None else float(b), 99)[1:-1]
            signs = {float(np.sign(lead * np.prod([x - float(y) for y in zeros]))) for x in samples}
            own = [x for x in zeros if (a is None or x > a) and (b is None or x < b)]
            assert [ExactSign(form, q).between(a, b)] == ([None] if own else [*signs])
        assert all(ExactSign(form, q).at(x) == 0 for x in zeros)


@pytest.mark.slow
def test_numbers_beyond_all_floats_leave_values_open() -> None:
    heavy = LATE.with_values({"effects.shunt.m": Integer(10) ** 320})
    r = hs.require(heavy, "effects.shunt.b", that="passive")
    assert (r.feasible, r.undecided) == ((), ((None, None),))
    assert "too large for floats" in str(r)
    stiff = LATE.with_values({"environment.k": Integer(10) ** 306})  # a thousand times as much is no float
    assert ends(hs.require(stiff, "environment.k", that="passive")) == [(200, 200)]


@pytest.mark.parametrize(
    ("free", "least", "kind"),
    [("environment.k", -3, "start"), ("effects.shunt.k", -5, "start"), ("effects.shunt.m", -0.25, "far-out")],
)
def test_where_stiffness_or_mass_of_all_runs_out_the_end_is_exact(free: str, least: float, kind: str) -> None:
    """k + 3 + b s + c s^(1/2) + (1/4 + m) s^2: neither the stiffness at rest nor the mass far out may be negative."""
    tissue = hs.environments.expression("k + 4*s + 2*s^0.5 + s^2/4", parameters={"k": 5})
    r = hs.require(hs.Scene(tissue, (hs.effects.shunt(m=1, k=3),)), free, (-10, 20), that="passive")
    assert (ends(r), r.certified) == ([(least, 20)], True)
    [end] = r.ends
    assert end.closed
    assert kind in [b.kind.value for b in end.bindings]


def test_of_powers_that_floats_do_not_tell_apart_the_higher_one_prevails() -> None:
    """s^(1/2) - s^(1/2 + 10^-18)/2 is active far out, however far that is, and s^(1/2) - s^(1/2 - 10^-18)/2 is not."""
    for step, passive in ((Rational(1, 10**18), False), (-Rational(1, 10**18), True)):
        q, near = Symbol("q"), Rational(1, 2) + step
        ring = Ring.of([q, sqrt(s), s**near])
        form = Energy.of(ring.convert(q * sqrt(s) - q * s**near / 2), q)
        assert (form._reach((1.0, 1.0)) is not None) is passive


def summed(rows: list[tuple[int, int, Any, Any]], z: Any, q: Any) -> Any:
    """c q^i s^p exp(-s lag) for each row, at 60 digits."""
    return mpmath.fsum(
        c * q**i * (z**p if z or p else 1) * mpmath.exp(-z * mpmath.mpf(lag.p) / lag.q) for c, i, p, lag in rows
    )


@pytest.mark.few("2", "5")
@pytest.mark.parametrize("seed", range(6))
def test_the_energy_of_cells_encloses_what_digits_say_from_rest_to_beyond_its_reach(seed: int) -> None:
    """Im(N conj D) over its lowest power of omega, of random N and D with delays: at frequencies and values of cells, and far out."""
    pick, q = Random(seed), Symbol("q")

    def rows(most: int) -> list[tuple[int, int, Any, Any]]:
        found = [(pick.choice([-3, -1, 2, 5]), pick.randint(0, 2), p, Integer(0)) for p in range(most + 1)]
        found += [
            (pick.choice([-1, 1, 2]), pick.randint(0, 1), pick.randint(0, most), Rational(pick.randint(1, 4), 8))
            for _ in range(2)
        ]
        return found

    above, below = rows(pick.randint(2, 3)), rows(1)
    N, D = (sum((c * q**i * s**p * exp(-s * lag) for c, i, p, lag in x), Integer(0)) for x in (above, below))
    ring = Ring.of([N, D, q])
    form = Energy.of(ring.convert(N) / ring.convert(D), q)
    span = (1.0, 1.25)
    with mpmath.workdps(60):

        def energy(omega: Any, value: Any) -> Any:
            z = mpmath.mpc(0, omega)
            product = summed(above, z, value) * mpmath.conj(summed(below, z, value))
            return product.imag / mpmath.mpf(omega) ** int(form._lowest)

        known = form._bounds(np.array([0.7]), (1.0, 1.0))[0][0]  # N and D are known but for a number
        scale = Fraction(float(energy(mpmath.mpf("0.7"), 1) / known)).limit_denominator(1000)

        def G(omega: Any, value: Any) -> Any:
            return energy(omega, value) / scale.numerator * scale.denominator

        near_0, values = mpmath.mpf("1e-25"), [mpmath.mpf(1) + mpmath.mpf(n) / 8 for n in range(3)]
        for omega in (1e-9, 0.01, 0.3, 2.0, 30.0, 400.0):
            low, high = (x[0] for x in form._bounds(np.array([omega]), span))
            assert all(low <= G(omega, value) <= high for value in values)
        at_0 = form.at_0.subs(q, Rational(9, 8))
        assert abs(G(near_0, values[1]) - mpmath.mpf(at_0.p) / at_0.q) < 1e-20
        reach, active, up = form._reach(span), form.active_at(span), form.rises(span)
        if reach is not None:
            assert all(G(reach * mpmath.mpf(1.3) ** n, value) > 0 for n in range(30) for value in values)
        if form.clear(span):
            assert all(G(mpmath.mpf(10) ** (n / 10), value) > 0 for n in range(-20, 30) for value in values)
        if active is not None:
            assert all(G(active, value) < 0 for value in values)
        if up is not None:
            assert all(G(up * n / 10, value) > G(near_0, value) for n in range(1, 11) for value in values)


def test_cells_that_were_told_in_time_are_kept_when_it_is_over(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of tau <= b/k the lower half of the range is told; of the upper one what a polynomial says just above frequency 0."""

    def ends_soon(done: float | None = None, *_: object) -> None:
        now = _budget.get()
        assert now is not None
        now.deadline = 0.0 if done == 3 else now.deadline
        tick(done)

    monkeypatch.setattr(passivecells, "tick", ends_soon)
    with limited(3600):
        r = hs.require(LATE, "tau", ("1 us", "16 ms"), that="passive")
    assert ends(r) == [(1e-6, 0.0080005)]
    [(low, high)] = r.undecided
    assert (low and float(low), high and float(high)) == (0.0080005, 0.01)  # beyond, it begins active


@pytest.mark.parametrize("seed", range(8))
def test_cells_go_a_thousand_times_as_far_as_a_value_without_a_range_and_else_hardly_beyond_it(seed: int) -> None:
    """Where a range ends at a value at which the sign may change, by a part of it, if the model has such values."""
    pick = Random(seed)
    own = Rational(pick.randint(-9, 9), 4)
    low, high = (Rational(n, 3) for n in sorted(pick.sample(range(-20, 20), 2)))
    ends = [pick.choice([None, low, sqrt(2) - 5]), pick.choice([None, high, sqrt(2) + 5])]
    openings = [ExactNumber(x) for x in (low, high) if pick.random() < 0.5]
    free = SimpleNamespace(value=own, rule=pick.choice([Rule.ANY, Rule.NONNEGATIVE]))
    found = _window(free, Domain(*ends), openings)  # type: ignore[arg-type]
    usual = 1000 * (abs(own) or 1)
    first, last = -usual if ends[0] is None else ends[0], usual if ends[1] is None else ends[1]
    for end, at, sign in ((found[0], first, -1), (found[1], last, 1)):
        assert end.is_Rational
        if (
            at.is_Rational
            and ExactNumber(at) in openings
            and (free.rule is Rule.ANY or at + sign * (last - first) / 64 >= 0)
        ):
            assert abs(end - at - sign * (last - first) / 64) < 1e-15
        elif at.is_Rational:
            assert end == at
        else:
            assert 0 < sign * (end - at).evalf(30) < 1e-18


@pytest.mark.parametrize("seed", range(6))
def test_cells_fill_a_range_in_order_and_those_that_are_open_are_small(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Between values at which the verdict changes; one between marks that nothing tells, one of which no part will be told."""
    pick = Random(seed)
    start, end = Rational(pick.randint(-9, 0)), Rational(pick.randint(1, 9))
    changes = sorted(Rational(pick.randint(-80, 80), 11) for _ in range(3))
    mark, last = Rational(pick.randint(-8, 8), 7), Rational(pick.randint(-80, 80), 13)
    search = _Search(LATE, LATE.knobs["environment.k"])
    search.__dict__["marks"] = {mark: None}
    asked = list[Any]()

    def told(low: Rational, high: Rational) -> _Cell:
        asked.append((low, high))
        assert low < high
        assert not low < mark < high
        if any(low <= x <= high for x in changes):
            if pick.random() < 0.3:
                raise UndecidedError("too near")
            return _Cell(low, high, None)
        if low <= last <= high:
            return _Cell(low, high, None, is_last=True)
        return _Cell(low, high, verdict=len([x for x in changes if x < low]) % 2 == 1)

    monkeypatch.setattr(search, "_told", told)
    found = [*search.cells(start, end)]
    assert (found[0].low, found[-1].high) == (start, end)
    assert all(a.high == b.low for a, b in pairwise(found))
    assert asked == sorted(asked, key=lambda x: (x[0], -x[1]))
    for x in found:
        if x.verdict is None and not x.is_last:
            width = x.high - x.low
            least = max(max(abs(x.low), abs(x.high)) / 2**11, (end - start) / 2**24)
            assert width <= least < 2 * width or len(asked) > 200
    assert bool(start <= mark <= end) is (mark in {x.low for x in found} | {end})


def test_after_two_hundred_cells_what_is_left_is_cut_no_further(monkeypatch: pytest.MonkeyPatch) -> None:
    search = _Search(LATE, LATE.knobs["environment.k"])
    search.__dict__["marks"] = {}
    monkeypatch.setattr(search, "_told", lambda low, high: _Cell(low, high, None))
    found = [*search.cells(Rational(0), Rational(1))]
    assert sum(x.high - x.low for x in found) == 1
    assert len(found) == pytest.approx(100, abs=25)
    assert [x.high - x.low for x in found[-2:]] == [Rational(1, 4), Rational(1, 2)]


@pytest.mark.parametrize("seed", range(2, 5))
def test_zeros_of_a_polynomial_are_those_that_were_placed_and_between_two_of_them_it_keeps_its_sign(seed: int) -> None:
    pick, q = Random(seed), Symbol("q")
    roots = [Rational(x, 2) for x in pick.sample(range(-9, 9), 3)] + pick.choice([[], [Integer(0)]])
    form = pick.choice([-3, 1, 2]) * (q**2 + 1) ** pick.choice([0, 1])
    for x in roots:
        form *= (q - x) ** pick.choice([1, 2])
    n = pick.choice([0, 2, 3])
    places = sorted({*roots, *((sqrt(n), -sqrt(n)) if n else ())}, key=float)
    form = (form * (q**2 - n if n else 1)).expand()
    found = zeros_of(form, q)
    assert sorted(map(float, found)) == pytest.approx(sorted(map(float, places)), rel=1e-15)
    assert len({x.digits(20) for x in found}) == len(found) == len(places)
    for _ in range(12):
        low, high = sorted(pick.choice([*roots, Rational(pick.randint(-90, 90), 17)]) for _ in range(2))
        inside = [x for x in places if bool(low < x) and bool(x < high)]
        assert keeps_sign(form, q, low, high) is (not inside)
        for x in found:
            near = min(places, key=lambda y, x=x: abs(float(y) - float(x)))
            assert is_between(low, x, high) is (near in inside)
            assert is_between(None, x, high) is bool(near < high)
            assert is_between(low, x, None) is bool(low < near)
    assert not keeps_sign(Integer(0) * q, q, Integer(0), Integer(1))
    assert not keeps_sign(sqrt(q), q, Integer(1), Integer(2))


def test_stiffness_behind_a_delay_beside_a_power_runs_out_at_an_exact_end() -> None:
    """(k + 4 s + 2 s^(1/2)) late, and 3 + 10 s + s^2: Im H > 0 at all frequencies, and H(0) = k + 3."""
    tissue = hs.environments.expression("k + 4*s + 2*s^0.5", parameters={"k": 5})
    scene = hs.Scene(tissue, (hs.effects.delay("1 ms"), hs.effects.shunt(m=1, b=10, k=3)))
    r = hs.require(scene, "environment.k", (-10, 20), that="passive")
    assert (ends(r), r.certified, r.feasible[0].low.closed) == ([(-3, 20)], True, True)


@pytest.mark.parametrize(("asked", "span"), [(None, (0, None)), ((1, 10), (1, 10))])
def test_parts_that_all_take_energy_are_fit_for_every_passive_hand_whatever_the_stiffness_is(
    asked: Any, span: Any
) -> None:
    """A wall behind a line of wave variables on a damped device: no cell is asked; of a device that may not damp it is not so."""
    link, device = hs.effects.wave_variables(10, "20 ms"), hs.effects.shunt(m="0.1 kg", b=1)
    scene = hs.Scene(hs.environments.kelvin_voigt(100, 1), (link, device))
    r = hs.require(scene, "environment.k", asked, that="passive")
    assert (ends(r), r.undecided, r.ends) == ([span], (), ())
    [found] = r.feasible
    assert found.low.closed
    assert found.high.closed is (asked is not None)


Q = Symbol("q")


def energy_of(top: Any, bottom: Any = 1) -> Energy:
    ring = Ring.of([Q, exp(-s), top, Integer(0) + bottom])
    return Energy.of(ring.convert(top) / ring.convert(Integer(0) + bottom), Q)


@pytest.mark.parametrize(
    ("top", "bottom", "signs"),
    [
        (s**2 - s, s + 1, [1, 1]),
        (Q * s - 3 * s, s + 1, [-1, -1]),
        (s**2 * exp(-s) - s, s + 1, [-1, -1]),  # what is late has faded
        (s**2 * exp(-Q * s) - s, s + 1, [0, -1]),  # but at 0 it is not late
        (exp(-s), s + 1, None),
    ],
)
def test_for_large_positive_s_the_sign_is_that_of_what_is_not_late(top: Any, bottom: Any, signs: Any) -> None:
    """For the numbers 0 and 2."""
    sign = energy_of(top, bottom).far_right
    assert (sign and [sign.at(Integer(x)) for x in (0, 2)]) == signs


@pytest.mark.parametrize(
    ("top", "bottom", "told"),
    [
        (5 * exp(-s) + 3 * exp(-2 * s), s + 1, -1),
        (Q * s * exp(-s) + 5, s + 1, -1),
        (Q * s * exp(-s) + s * exp(-2 * s), s + 1, -1),  # one of two terms is there for every number
        (s * exp(-s) + Q * s, s + 1, None),  # what is not late may make up for it
        (s * exp(-s * Q) + s * exp(-s), s + 1, None),  # and two that are equally late may cancel
        (s * exp(-s * Q) + 5, s + 1, -1),
        (s**2 * exp(-s), s**2 + s**2 * exp(-s) + 1, None),
    ],
)
def test_what_turns_far_out_is_known_by_the_highest_powers(top: Any, bottom: Any, told: int | None) -> None:
    """For numbers from 0 to 2; at 0 alone a delay, or what comes late, may be gone."""
    sign = energy_of(top, bottom).turning
    assert (sign and sign.between(Integer(0), Integer(2))) == told
    if told:
        gone = top in (Q * s * exp(-s) + 5, s * exp(-s * Q) + 5)
        assert sign.at(Integer(0)) == (0 if gone else -1)  # type: ignore[union-attr]


@pytest.mark.parametrize(
    ("top", "bottom", "end", "up", "down"),
    [
        (Q * s + 5 * exp(-s), 1, 1.0, True, False),  # a damper that grows makes up for more
        (Q * s + 5 * exp(-s), 1, 10.0, True, False),
        (s + Q * exp(-s), Q + s, 10.0, False, False),  # in the end exp(-s) is left
        (Q * s + 5 * exp(-s), 2, 1.0, True, False),
        (Q * s + 5 * exp(-s), -1, 1.0, False, True),
        (Q * s + 5 * exp(-s), s + 1, 1.0, None, False),
        (Q + 3 * s * exp(-s), 1, 1.0, True, None),
        (Q * s**2 + 3 * s * exp(-s), 1, 1.0, True, None),
        (3 * s + exp(-s) - Q * s, 1, 9.0, False, True),
        (3 * s + exp(-s) + Q * s, 1, -9.0, True, False),
        (Q * s**3 + s + exp(-s), 1, 2.0, False, None),
        (Q**2 * s + 5 * exp(-s), 1, 1.0, None, None),
        (Q * exp(-s) + s / 2, 1, 1.0, False, None),
    ],
)
def test_all_values_beyond_an_end_are_as_it_is_where_what_grows_is_known_to_help_or_to_harm(
    top: Any, bottom: Any, end: float, up: Any, down: Any
) -> None:
    form = energy_of(top, bottom)
    assert (form.beyond(end, 1), form.beyond(-abs(end), -1)) == (up, down)


@pytest.mark.parametrize("seed", range(20))
def test_where_im_h_over_its_lowest_power_rises_from_rest_it_does_so_for_all_values_and_is_told(seed: int) -> None:
    """q s + c s^3 + d s^5 and a late spring: the second power of omega decides, if there is one."""
    pick = Random(seed)
    c, d, k = (Rational(pick.randint(-5, 5), 2) for _ in range(3))
    c, d, k = (c, d, k) if seed % 2 else (4 * c - 1, abs(d), 0 * k)
    form = energy_of(Q * s + c * s**3 + d * s**5 + k * exp(-s))
    found = form.rises((1.0, 1.5))
    second = -c + k / 6  # of (q - k) - (c - k/6) w^2 + ...
    far_out = d > 0 or (d == 0 and c <= 0)  # from some frequency on Im H > 0: up to there it is looked at
    assert (found is not None) is bool(second > 0 and far_out)
    if found is not None:
        with mpmath.workdps(60):
            for n in range(1, 41):
                w = mpmath.mpf(found) * n / 40
                rise = -c * w**2 + d * w**4 + k * (1 - mpmath.sin(w) / w)
                assert rise > 0
        if not k:  # the first of reach, a quarter of it, ... at which the second power outweighs the third
            end = form._reach((1.0, 1.5))
            while not -c > abs(d) * Rational(end) ** 2:
                end /= 4
            assert found == end
    assert energy_of(Q * s).rises((1.0, 1.5)) is None


@given(st.floats(0, 1e6), st.floats(0, 1e6))
def test_frequency_and_values_over_cells_are_told_with_the_same_doubt_on_both_sides_of_0(x: float, y: float) -> None:
    low, high = sorted((x, y))
    one, other = (variables(np.array([[[0.0, 1.0], own]])) for own in ((low, high), (-high, -low)))
    for a, b in zip(one, other, strict=True):
        assert (a.r == b.r).all()
        assert (a.r >= 0).all()
        assert (np.abs(a.c0) == np.abs(b.c0)).all()
        assert (a.c1 == b.c1).all()
    bottom, top = (float(z[0, 0]) for z in one[1].bounds())
    assert bottom <= low <= high <= top


def test_values_turn_at_the_one_root_in_a_cell_where_all_else_is_shown() -> None:
    """Zeros of the sign above frequency 0 at known places; each thing that is not shown leaves the cell open."""
    pick, k, told = Random(23), Symbol("k", real=True), 0
    for _ in range(150):
        zeros = [Rational(pick.randint(-6, 6), 2) for _ in range(pick.randint(1, 3))]
        form = prod((k - x for x in zeros), start=Integer(pick.choice([-2, 1]))).expand()
        low = Rational(pick.randint(-7, 4), 2)
        high = low + Rational(pick.randint(1, 6), 2)
        shown = {x: pick.random() < 0.93 for x in ("rises", "clear", "poles", "steady", "holds")}
        asked: list[tuple[Any, Any]] = []
        search: Any = _Search.__new__(_Search)
        search.free = SimpleNamespace(symbol=k)
        search.__dict__ |= {"_opening": ExactSign(form, k), "openings": tuple(zeros_of(form, k))}
        search.energy = SimpleNamespace(
            rises=lambda q, own=shown: 3.0 if own["rises"] else None,
            clear=lambda q, start, own=shown: own["clear"] and start == 3.0,
        )
        search._has_steady_poles = lambda *_, own=shown: own["poles"]
        search._is_steady = lambda *_, own=shown: own["steady"]
        search._holds = lambda a, b, own=shown, asked=asked: (asked.append((a, b)), own["holds"])[1]
        found = search._turn(low, high)
        inside = {x for x in zeros if low <= x <= high}
        signs = [form.subs(k, x) for x in (low, high)]
        if len(inside) == 1 and signs[0] * signs[1] < 0 and all(shown.values()):
            [x] = inside
            assert float(found) == float(x)
            assert asked == [(low if signs[0] > 0 else high, x)]
            told += 1
        else:
            assert found is None
    assert told > 15


@pytest.mark.parametrize("expanded", [False, True])
@pytest.mark.parametrize("seed", range(6))
def test_what_stands_at_the_powers_of_frequency_adds_up_to_im_h_over_cells(seed: int, *, expanded: bool) -> None:
    """Im N(j omega) conj D(j omega), with delays above and below; in narrow cells hardly anything else is in the sum."""
    pick = Random(seed)

    def drawn() -> Any:
        lags = [exp(-s) ** pick.choice([0, 1, 2]) for _ in range(3)]
        return sum(
            Rational(pick.randint(1, 9), 4) * Q ** pick.randint(0, 1) * s ** pick.randint(0, 3) * x for x in lags
        )

    top, bottom = drawn(), drawn()
    form = energy_of(top, bottom)
    for low, high in ((0.0, 0.02), (0.1, 0.11), (0.2, 0.21) if expanded else (2.9, 2.95)):
        omega, q = variables(np.array([[[low, high], [1.25, 1.26]]]))
        parts = form._coefficients(omega, q, expanded=expanded)
        for share in (0, 0.3, 1):
            w, value = low + share * (high - low), 1.25 + 0.01 * (1 - share)
            at = {s: 1j * w, Q: value}
            true = float((top.subs(at) * bottom.subs(at).conjugate()).evalf(30).as_real_imag()[1])
            ends = np.array([[x * w ** int(p) for x in ends_of(model)] for p, model in parts.items()]).sum(0)
            assert ends[0] - 1e-12 <= true <= ends[1] + 1e-12
            assert (
                ends[1] - ends[0]
                <= 0.1 + 0.2 * np.abs([x * w ** int(p) for p, m in parts.items() for x in ends_of(m)]).sum()
            )
