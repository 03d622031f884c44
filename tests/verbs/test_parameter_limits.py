"""Parameters that go to 0 or without bound: which sign a condition has there, beside exact sums and beside evaluations."""

from __future__ import annotations

from fractions import Fraction as Q
from math import comb, sqrt
from random import Random

import flint
import pytest
from flint import arb, fmpq, fmpq_poly
from mpmath import cosh, mpc, mpf, sinh
from mpmath import sqrt as root
from sympy import Rational, pi, symbols

import haptisym as hs
from haptisym import effects, environments
from haptisym.judge.criteria import noticed
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.response import RealFunction
from haptisym.kernel.symbols import omega
from haptisym.verbs.require.blowups import is_negative, positive_along
from haptisym.verbs.require.cells import ValueSearch
from haptisym.verbs.require.feasible import Kind
from haptisym.verbs.require.freeparameter import conditions, pieces
from haptisym.verbs.require.knownsums import Known, ball
from haptisym.verbs.require.limits import Limit, _expanded, _terms
from haptisym.verbs.require.lowest import beginning
from haptisym.verbs.require.monomials import Monomials, power
from haptisym.verbs.require.rows import Row
from haptisym.verbs.require.strips import Shape


def terms(**given: int) -> dict[tuple[Q, Q], fmpq]:
    """``x2y1=3`` is 3 x^2 y."""
    found = {}
    for name, value in given.items():
        a, b = name[1:].split("y")
        found[Q(int(a)), Q(int(b))] = fmpq(value)
    return found


SUMS = [
    ({"x4y0": -1, "x0y2": -1}, True),
    ({"x4y0": -1, "x2y1": 1, "x0y2": -1}, True),  # v - 1 - v^2 < 0
    ({"x4y0": -1, "x2y1": 3, "x0y2": -1}, False),  # 3 v - 1 - v^2 > 0 at v = 1
    (
        {"x4y0": -1, "x2y1": 2, "x0y2": -1, "x6y0": -1, "x4y1": -1},
        True,
    ),  # -(x^2 - y)^2, and what is left is negative there
    ({"x4y0": -1, "x2y1": 2, "x0y2": -1, "x4y1": 1}, False),
    ({"x5y0": -1, "x0y3": -1, "x1y1": -1, "x2y2": 7}, True),  # two slopes
    ({"x5y0": 1, "x0y3": -1, "x1y1": -1}, False),
]


@pytest.mark.parametrize(("given", "negative"), SUMS)
def test_the_sign_of_a_sum_next_to_a_corner(given: dict[str, int], *, negative: bool) -> None:
    own, x, y = terms(**given), arb(1) / 64, arb(1) / 64
    assert is_negative(own, x, y) is negative
    reach = positive_along(own, x, y)
    assert reach is None or not negative
    if reach is not None:  # at each such y there is an x
        for n in range(8):
            v = float(reach) / 4**n
            values = [sum(float(c.p) * u ** int(a) * v ** int(b) for (a, b), c in own.items()) for u in samples(v)]
            assert max(values) > 0


def beside_a_double_root(first: int, scale: Known | fmpq) -> dict[tuple[Q, Q], Known | fmpq]:
    """-w^4 + first x^6 w^2 - x^12, w = y - 7 x^2, times a number: as t^4 - first t^2 + 1 on w = t x^3."""
    found: dict[tuple[Q, Q], int] = {(Q(12), Q(0)): -1}
    for n in range(5):
        found[Q(8 - 2 * n), Q(n)] = -comb(4, n) * (-7) ** (4 - n)
    for n in range(3):
        place = Q(10 - 2 * n), Q(n)
        found[place] = found.get(place, 0) + first * comb(2, n) * (-7) ** (2 - n)
    if isinstance(scale, fmpq):
        return {place: value * scale for place, value in found.items()}
    return {
        place: Known({key: x * value for key, x in scale.parts.items()}, scale.units) for place, value in found.items()
    }


IRRATIONAL = Known({(): fmpq(1, 3), (1,): fmpq(2)}, {(): arb(1), (1,): arb.pi()})


@pytest.mark.parametrize("scale", [fmpq(1), IRRATIONAL], ids=["rational", "irrational"])
@pytest.mark.parametrize(("first", "negative"), [(1, True), (-1, True), (3, False)])
def test_the_sign_of_a_sum_beside_a_double_root_of_what_is_left_at_a_corner(
    first: int, scale: Known | fmpq, *, negative: bool
) -> None:
    own, x, y = beside_a_double_root(first, scale), arb(1) / 64, arb(1) / 64
    assert is_negative(own, x, y) is negative
    reach = positive_along(own, x, y)
    assert (reach is None) is negative
    for n in range(8 if reach is not None else 0):
        v = Q(float(reach)) / 4**n
        u = near = Q(sqrt(v / 7))
        values = []
        for t in (-1.5, -1.2, -1.0, 1.0, 1.2, 1.5):  # x of y = 7 x^2 + t x^3, about; the sum there, exactly
            u = near * (1 - Q(t) * near / 14)
            w = v - 7 * u**2
            values.append(-(w**4) + first * u**6 * w**2 - u**12)
        assert max(values) > 0


def test_a_double_root_at_an_irrational_number_is_left_open() -> None:
    own = terms(x0y4=-1, x4y2=4, x8y0=-4, x12y0=1)  # -(y^2 - 2 x^4)^2 + x^12
    assert not is_negative(own, arb(1) / 64, arb(1) / 64)
    assert positive_along(own, arb(1) / 64, arb(1) / 64) is None


def samples(y: float) -> list[float]:
    return [sqrt(y), *(2.0**-6 * 0.97**n for n in range(1500) if 2.0**-6 * 0.97**n > y / 1e3)]


SCENES = {
    "mass": ("environment.m", hs.Scene(environments.mass_spring_damper("0.4", 50, 170), (effects.delay("0.49 ms"),), (0, "4.8"), hs.Threshold.of("0.1"))),
    "link": ("effects.wave-variables.b", hs.Scene(environments.kelvin_voigt(1100, 28), (effects.wave_variables("9.2", "8.5 ms"),), (0, "3.6"), hs.Threshold.of("0.5"))),
    "hold": ("effects.zero-order-hold.T", hs.Scene(environments.maxwell(13, "4.7"), (effects.zero_order_hold("0.97 ms"),), (0, 15), hs.Threshold.of("0.1"))),
    "spring": ("environment.k", hs.Scene(environments.maxwell(150, "0.82"), (effects.delay("2.8 ms"),), (0, "3.7"), hs.Threshold.of("0.2"))),
    "pot": ("environment.k_alpha", hs.Scene(environments.spring_pot(27, "0.5", k=380), (effects.delay("4.6 ms"),), (0, 34), hs.Threshold.of("0.2"))),
}  # fmt: skip


REACH = dict.fromkeys(SCENES, 5) | {"hold": 1}
"""Powers of ten by which values go to both sides: evaluations at periods that are much longer take long."""


@pytest.mark.few("pot")
@pytest.mark.parametrize("name", SCENES)
def test_nothing_stays_open_at_0_nor_without_bound(name: str) -> None:
    path, scene = SCENES[name]
    found = hs.require(scene, path)
    assert found.undecided == ()
    draw = Random(name)
    for _ in range(5):
        value = Rational(10 ** draw.uniform(-REACH[name], REACH[name])) * found.free.value
        e = hs.evaluate(found.free.put(scene, value))
        said = any(
            (a is None or float(a) < value) and (b is None or value < float(b))
            for a, b in ((x.low.value, x.high.value) for x in found.feasible)
        )
        assert ([(x.low, x.high) for x in e.transparent] == [(e.chart.points[0], e.chart.points[-1])]) is said


def test_what_is_not_rational_in_a_coefficient_at_0_stays_in_it() -> None:
    T = symbols("t", real=True)
    condition = RealFunction(Ring([T]).axis.convert(pi * omega**2 - 2 * omega**4).reduced())
    found = dict(_expanded(Shape.of(condition, T), arb("0.1")))
    assert sorted(found) == [2, 4, 8]
    assert ball(found[2]).overlaps(arb.pi())
    assert (found[4], found[8].is_zero()) == (fmpq(-2), True)


def test_coefficients_at_0_are_those_of_the_function_also_beyond_the_tenth_power() -> None:
    axis = Ring([], [Rational(1, 10)]).axis
    w, _, tangent = axis.context.gens()
    rows = beginning(axis, tangent**12 - w**14, [12], 16)
    assert [list(row.values()) for row in rows[:12]] == [[0]] * 12
    # sin(a)^12 = a^12 (1 - 2 a^2 + ...), a = omega/20, and cos(a)^12 = 1 - ...
    assert list(rows[12].values()) == [fmpq(1, 20**12)]
    assert list(rows[14].values()) == [fmpq(-2, 20**14) - 1]


@pytest.mark.parametrize("order", [0, 1, 5, 9, 10, 11, 15, 16, 20, 33, 34])
def test_six_coefficients_are_taken_apart_from_the_first_that_is_not_0_on_however_far_that_is(order: int) -> None:
    T = symbols("t", real=True)
    w = omega
    shape = Shape.of(RealFunction(Ring([T]).axis.convert(w**order * (2 + 3 * w**2 - w**5 + 7 * w**6)).reduced()), T)
    if order == 34:
        with pytest.raises(UndecidedError, match="begins at omega = 0"):
            dict(_expanded(shape, arb("0.1")))
        return
    found = dict(_expanded(shape, arb("0.1")))
    assert {n - order: x for n, x in found.items() if n < order + 6} == {0: 2, 2: 3, 5: -1}
    assert found[order + 6].contains(7)


HEAVY = hs.Scene(
    environments.spring_pot(90, "0.9", k=1000),
    (effects.four_channel_teleoperator("0.25", "2.6", 66, "3.3", 25, 11, "2.7 ms"), effects.first_order_lag(43)),
    (0, 23),
    hs.Threshold.of("0.5"),
)


@pytest.mark.parametrize("inverse", [pytest.param(False, marks=pytest.mark.slow), True])
def test_monomials_at_0_add_up_to_the_condition(*, inverse: bool) -> None:
    free = HEAVY.knobs["effects.four-channel-teleoperator.Mm"]
    criteria = noticed(HEAVY.threshold)[:1]
    [f] = [f for own in conditions(HEAVY, [free], criteria).values() for f in pieces(own)]
    with flint.ctx.workprec(256):
        limit = Limit.of([f], free.symbol, HEAVY.band, inverse=inverse, sign=1)
        [shape] = limit.shapes
        known = _terms(shape, arb("0.01"))
        for w, u in (("0.001", "0"), ("0.001", "1.3e-8"), ("1e-4", "1e-11"), ("0.003", "1e-5")):
            x, y = arb(w), arb(u)
            total = sum(
                ball(value) * (x.log() * a.numerator / a.denominator).exp() * y ** int(b)
                for (a, b), value in known.items()
            )
            witness = shape.over(y).value(x)
            assert total.overlaps(witness), (w, u)
            assert total.rel_accuracy_bits() > 20, (w, u)


HEAVY_MASTERS = {
    "unnoticed": HEAVY,
    "noticed": hs.Scene(
        environments.zener(2400, 67, "0.91"),
        (
            effects.second_order_lowpass(12, "0.46"),
            effects.four_channel_teleoperator("0.61", 58, 14, "2.2", 50, 13, "58 ms"),
        ),
        (0, "7.2"),
        hs.Threshold.of("0.5"),
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", HEAVY_MASTERS)
def test_a_master_that_grows_heavy_is_decided_at_its_resonance(name: str) -> None:
    """There what is left of the condition has a root of order 4, up to one factor, a wave of the spring-pot's constant angle."""
    scene = HEAVY_MASTERS[name]
    found = hs.require(scene, "effects.four-channel-teleoperator.Mm")
    assert found.undecided == ()
    assert [(x.high.value, x.low.value.digits(6)) for x in found.feasible] == (
        [(None, "1.46758")] if name == "unnoticed" else []
    )
    for mass in ("1.4", "1.5", "5", "300", "1e4", "1e6"):
        e = hs.evaluate(found.free.put(scene, Rational(mass)))
        unnoticed = [(x.low, x.high) for x in e.transparent] == [(e.chart.points[0], e.chart.points[-1])]
        assert unnoticed is (name == "unnoticed" and float(mass) > 1.46758)


@pytest.mark.slow
def test_a_clock_is_asked_for_all_of_its_periods_also_beyond_the_nyquist_frequency() -> None:
    found = hs.require("sampled-wall", "effects.sampling.T")
    assert (found.feasible, found.undecided) == ((), ())


@pytest.mark.slow
@pytest.mark.parametrize(("path", "low"), [("effects.teleoperator.Bs", "14.8962"), ("effects.teleoperator.Ms", "0")])
def test_a_slave_that_is_heavy_or_damped_without_bound_stays_unnoticed(path: str, low: str) -> None:
    found = hs.require("four-channel-teleoperation", path)
    assert found.undecided == ()
    [span] = found.feasible
    assert (span.low.value.digits(6), span.high.value) == (low, None)


POT_BEHIND_A_HOLD = hs.Scene(
    environments.spring_pot(170, "0.2", k=1200),
    (effects.shunt(m="0.5", b="6.6"), effects.delay("0.73 ms"), effects.zero_order_hold("1.6 ms")),
    (0, 74),
    hs.Threshold.of("0.2"),
)


def test_a_condition_that_vanishes_at_0_with_powers_is_enclosed_over_what_it_vanishes_with() -> None:
    free = POT_BEHIND_A_HOLD.knobs["environment.k"]
    for own in conditions(POT_BEHIND_A_HOLD, [free], noticed(POT_BEHIND_A_HOLD.threshold)).values():
        shape = Shape.of(*pieces(own), free.symbol)
        assert shape.order_at_zero > 0
        with flint.ctx.workprec(256):
            compiled = shape.over(arb(13000))
            for end in (arb(1) / 8, arb(4)):
                whole = shape.from_zero(compiled, end)
                assert whole.is_finite()
                for n in range(1, 40):
                    x = (end * n / 40).mid()
                    assert whole.overlaps(compiled.value(x) / x ** arb(float(shape.order_at_zero)))


@pytest.mark.slow
def test_a_spring_pot_behind_a_hold_has_an_end_that_is_known_to_all_digits() -> None:
    found = hs.require(POT_BEHIND_A_HOLD, "environment.k")
    assert found.undecided == ()
    [span] = found.feasible
    assert span.low.bindings
    for value, kept in (("13344.8", False), ("13344.9", True)):
        e = hs.evaluate(found.free.put(POT_BEHIND_A_HOLD, value))
        assert ([(x.low, x.high) for x in e.transparent] == [(e.chart.points[0], e.chart.points[-1])]) is kept


@pytest.mark.slow
def test_a_spring_pot_that_has_no_force_at_rest_behind_waves_is_decided_from_0_on() -> None:
    scene = hs.Scene(environments.spring_pot(80, "1/2"), (effects.wave_variables(4, "0.05"),), (0, 1))
    found = hs.require(scene, "environment.k_alpha")
    assert found.undecided == ()
    [span] = found.feasible
    for end, part in ((span.low, "real"), (span.high, "imag")):
        [binding] = end.bindings
        assert (binding.criterion.name, float(binding.omega)) == (part, 1.0)
        k, s = mpf(end.value.digits(15)), mpc(0, 1)
        force, wave = k * root(s), s / 20
        felt = (force * cosh(wave) + 4 * s * sinh(wave)) / (cosh(wave) + force * sinh(wave) / (4 * s))
        change = felt - force
        assert abs(abs(change.real if part == "real" else change.imag) / abs(force) - mpf("0.1")) < 1e-13


def test_a_sum_over_a_box_holds_its_exact_values_at_each_point() -> None:
    draw = Random(5)
    for _ in range(40):
        given = {(Q(draw.randint(0, 9), 3), Q(draw.randint(0, 4))): fmpq(draw.randint(-9, 9), 7) for _ in range(12)}
        own = Monomials.of(given)
        ends = [sorted(Q(draw.randint(0, 8), 8) ** 3 for _ in range(2)) for _ in range(2)]
        sides = [tuple(arb(x.numerator) / x.denominator for x in pair) for pair in ends]
        over = own.reduced(*sides).over(*sides)
        left, low = (min(e[i] for e in given) if pair[0] == 0 else 0 for i, pair in enumerate(ends))
        for n in range(1, 5):
            x, y = (a + (b - a) * n / 4 for a, b in ends)
            if x > 0 and y > 0:
                cube = fmpq(round(x.numerator ** (1 / 3)), round(x.denominator ** (1 / 3)))
                if cube**3 != fmpq(x.numerator, x.denominator):
                    continue
                exact = sum((c * cube ** int(3 * (a - left)) * fmpq(y.numerator, y.denominator) ** int(b - low) for (a, b), c in given.items()), fmpq(0))  # fmt: skip
                assert over.contains(exact)


def test_a_sum_over_one_of_its_monomials_is_what_it_is_when_that_is_divided_out_first() -> None:
    draw = Random(7)
    for _ in range(40):
        given = {(Q(draw.randint(0, 9), 3), Q(draw.randint(0, 4))): fmpq(draw.randint(-9, 9), 7) for _ in range(9)}
        own, (a, b) = Monomials.of(given), draw.choice(list(given))
        x, y = ((arb(n), arb(n) + draw.randint(0, 3)) for n in (2, 5))
        for less in ((a, b), (a, Q(0)), (Q(0), b), (Q(0), Q(0))):
            found, divided = own.over(x, y, less), own.over_power(*less).over(x, y)
            assert abs(found.mid() - divided.mid()) < abs(divided).upper() * 1e-9
            assert abs(found.rad() - divided.rad()) <= divided.rad() * 1e-6 + abs(divided).upper() * 1e-9


LEFT_OPEN = {
    "overdamped": ("effects.second-order-lowpass.zeta", hs.Scene(environments.spring_pot(25, "0.9", k=320), (effects.second_order_lowpass(36, "0.92"), effects.first_order_lag(300), effects.delay("13 ms")), (0, 18), hs.Threshold.of(1)), [0.781069, 1.93020]),
    "heavy": ("environment.m", hs.Scene(environments.mass_spring_damper("9.8", "4.5", 170), (effects.first_order_lag(1500), effects.zero_order_hold("31 ms")), (0, "3.7"), hs.Threshold.of("0.5")), []),
    "stiff": ("environment.k", hs.Scene(environments.mass_spring_damper("0.34", "9.3", 360), (effects.zero_order_hold("3.4 ms"), effects.compliance(8300, "7.7"), effects.compliance(63000, "1.4")), (0, "9.2"), hs.Threshold.of("0.2")), [1833.45]),
}  # fmt: skip
"""With the ends of the sets: a limit at omega = 0 and damping without bound; a light resonance; a condition that binds at
omega = 0 behind a hold, 1/k = (1/8300 + 1/63000) (1/0.2 - 1)."""


@pytest.mark.few("heavy")
@pytest.mark.parametrize("name", LEFT_OPEN)
def test_next_to_a_limit_a_resonance_or_frequency_0_nothing_stays_open(name: str) -> None:
    path, scene, ends = LEFT_OPEN[name]
    found = hs.require(scene, path)
    assert found.undecided == ()
    assert [float(x.value) for x in found.ends if x.value is not None] == pytest.approx(ends, rel=1e-5)


@pytest.mark.slow
def test_what_binds_at_frequency_0_behind_a_hold_is_known_to_all_digits() -> None:
    path, scene, _ = LEFT_OPEN["stiff"]
    found = hs.require(scene, path, (1000, 3000), part=hs.Part.REAL)
    [span] = found.feasible
    exact = Rational(1, 4) / (Rational(1, 8300) + Rational(1, 63000))
    with flint.ctx.workprec(256):
        assert span.high.value.ball(256).contains(fmpq(exact.p, exact.q))
    assert [x.kind for x in span.high.bindings] == [Kind.START]


@pytest.mark.slow
def test_few_cells_of_values_are_asked_where_a_condition_falls_from_a_bound_on(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its slope is known from coefficients of Taylor's in the parameter: wide cells beside the end are kept, not cut."""
    asked = []
    judged = ValueSearch._judged
    monkeypatch.setattr(ValueSearch, "_judged", lambda own, *cell: asked.append(cell) or judged(own, *cell))
    path, scene, _ = LEFT_OPEN["stiff"]
    [span] = hs.require(scene, path).feasible
    exact = Rational(1, 4) / (Rational(1, 8300) + Rational(1, 63000))
    assert span.high.value.digits(12) == str(exact.evalf(12))
    assert 0 < len(asked) < 25  # 51 by slopes over whole cells


@pytest.mark.slow
def test_beyond_an_end_no_sliver_is_left_at_the_frequencies_that_were_tried() -> None:
    """Where one of these is on the border for a value, the maximum beside it is not: the condition is broken there."""
    scene = hs.Scene(
        environments.zener(1800, 15, "5.2"),
        (effects.wave_variables("1.8", "1.2 ms"), effects.second_order_lowpass(100, "0.21"), effects.delay("0.52 ms")),
        (0, "8.3"),
        hs.Threshold.of("0.1"),
    )
    found = hs.require(scene, "effects.wave-variables.tau")
    assert found.undecided == ()
    [span] = found.feasible
    end = Rational(span.high.value.digits(15))
    for factor, unnoticed in (
        (1 - Rational(1, 10**8), True),
        (1 + Rational(1, 10**8), False),
        (1 + Rational(4, 10**8), False),
    ):
        e = hs.evaluate(found.free.put(scene, end * factor))
        assert ([(x.low, x.high) for x in e.transparent] == [(e.chart.points[0], e.chart.points[-1])]) is unnoticed


def test_where_a_hold_is_kept_at_frequency_0_the_ends_are_found_beyond() -> None:
    found = hs.require("virtual-wall", "environment.b")
    [span] = found.feasible
    assert found.undecided == ()
    assert (span.low.value.digits(6), span.high.value.digits(6)) == ("14.2773", "35.4501")


@pytest.mark.parametrize("seed", range(4))
def test_a_sum_of_powers_is_said_to_be_nowhere_positive_where_it_is_not(seed: int) -> None:
    """In sqrt(Y), with zeros placed below, between, beyond and at the ends; what touches 0 changes no sign."""
    pick, told = Random(seed), [0, 0]
    for _ in range(60):
        low = Q(pick.randint(0, 6))
        high = low + pick.randint(1, 6)
        zeros = [(Q(pick.randint(0, 28), 2), pick.randint(1, 3)) for _ in range(pick.randint(0, 3))]
        lead = pick.choice([-1, -1, 1])
        poly = fmpq_poly([lead])
        for zero, n in zeros:
            poly *= fmpq_poly([fmpq(-zero.numerator, zero.denominator), 1]) ** n
        row = {Q(n, 2): c for n, c in enumerate(poly.coeffs()) if c}
        up = arb(fmpq(int(low**2))), arb(fmpq(int(high**2)))
        places = [low + (high - low) * Q(2 * n + 1, 128) for n in range(64)]
        values = [poly(fmpq(x.numerator, x.denominator)) for x in places]
        own = Row.of(row)
        assert own
        said = own.is_nowhere_positive(*(power(y, Q(1, own.below)) for y in up))
        told[said] += 1
        if said:
            assert max(values) <= 0
        elif not any(zero in (low, high) for zero, _ in zeros):  # at an end a ball does not tell the side
            assert max(values) > 0
    assert min(told) > 5
