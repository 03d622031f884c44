"""What the checker of certificates computes with: balls, polynomials and numbers, against mpmath, fractions and known roots."""

from __future__ import annotations

import random
from fractions import Fraction

import mpmath
import pytest

from haptisym_check import RefusedError, balls, polynomials, reading, series, values
from haptisym_check.balls import FINER, SCALE, Ball
from haptisym_check.polynomials import PI, Factor
from haptisym_check.series import ORDER, Place, Series
from haptisym_check.values import Point, Value, degree

MP = mpmath.mp.clone()
MP.prec = 600
SEEDS = range(12)


def exact(x: Fraction | int) -> mpmath.mpf:
    x = Fraction(x)
    return MP.mpf(x.numerator) / x.denominator


def drawn(draw: random.Random, size: int = 9) -> Fraction:
    """Often 0 or a whole number, of both signs."""
    return Fraction(draw.randint(-size, size), draw.choice([1, 1, 2, 7, 360]))


def off(x: Ball, true: mpmath.mpf) -> mpmath.mpf:
    """By how many parts of one a middle is wrong."""
    return abs(true * SCALE - x[0])


def refused(function: object, *given: object) -> bool:
    try:
        function(*given)  # type: ignore[operator]
    except RefusedError:
        return True
    return False


# Numbers and series


def drawn_series(draw: random.Random, length: int) -> Series:
    """Exact ones and wide ones, of small numbers and of large ones."""
    size = draw.choice([SCALE >> 200, SCALE, SCALE << 90])
    return [draw.choice([0, draw.randint(-size, size)]) for _ in range(length)], draw.choice([0, 1, SCALE // 7, size])


def held(draw: random.Random, x: Series) -> list[Fraction]:
    """One of those that a series stands for: at the edge, all errors in one coefficient or spread over all."""
    row, lost = x
    weights = [Fraction(draw.choice([0, 0, 1, 5])) for _ in row]
    weights[draw.randrange(len(row))] += 1
    return [Fraction(c) + draw.choice([-1, 1]) * lost * w / sum(weights) for c, w in zip(row, weights, strict=True)]


def errors(x: Series, true: list[Fraction]) -> Fraction:
    return sum((abs(a - b) for a, b in zip(x[0], true, strict=True)), Fraction(0))


@pytest.mark.few(5)
@pytest.mark.parametrize("seed", SEEDS)
def test_products_and_sums_of_series_hold_those_of_all_that_they_hold(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(8):
        length = draw.choice([1, 2, 5, ORDER + 1])
        p, q, r = (drawn_series(draw, n) for n in (length, length, draw.randint(1, length)))
        both, own, short = series.plus(p, q), series.times(p, q), series.times(r, q)
        assert both == ([x + y for x, y in zip(p[0], q[0], strict=True)], p[1] + q[1])
        for found, first in ((own, p), (short, ([*r[0], *[0] * (length - len(r[0]))], r[1]))):
            for _ in range(3):
                x, y = held(draw, first), held(draw, q)
                true = [sum((x[i] * y[n - i] for i in range(n + 1)), Fraction(0)) / SCALE for n in range(length)]
                assert errors(found, true) <= found[1]
            sizes = [sum(map(abs, row)) for row, _ in (first, q)]
            most = Fraction(sizes[0] * q[1] + sizes[1] * first[1] + first[1] * q[1], SCALE)
            assert found[1] <= most + length + 1


@pytest.mark.few(10)
@pytest.mark.parametrize("seed", SEEDS)
def test_sines_and_powers_are_those_of_mpmath(seed: int) -> None:
    draw = random.Random(seed)
    assert balls.circle(Fraction(0)) == [SCALE, 0, -SCALE, 0]
    large = Fraction(draw.randint(1, 10**40), draw.randint(10**26, 10**27))
    for x in (Fraction(1, 4), Fraction(1, 2), Fraction(10**14), large, *(abs(drawn(draw, 999)) for _ in range(12))):
        c, s = MP.cos(exact(x)), MP.sin(exact(x))
        assert all(off((found, 2), own) < 2 for found, own in zip(balls.circle(x), (c, -s, -c, s), strict=True))
    for x in (Fraction(1), Fraction(2), *(Fraction(draw.randint(1, 10**9), draw.randint(1, 10**9)) for _ in range(12))):
        alpha = Fraction(draw.randint(1, 29), 30)
        m, r = balls.power(x, alpha)
        true = exact(x) ** exact(alpha)
        assert off((m, r), true) <= r <= 2 + true
        assert abs(SCALE * exact(x) - balls.parts(x)) <= 1


def test_polynomials_in_pi_lie_within_their_bounds() -> None:
    for row in ([7], [0, 1], [0, 0, -3], [5, -2, 0, 0, 10**30], [1] * 60):
        true = MP.polyval([MP.mpf(c) for c in row[::-1]], MP.pi)
        m, r = balls.in_pi(row)
        assert off((m, r), true) <= r < Fraction(SCALE, 10**60) * sum(map(abs, row))


def row_errors(x: Series, true: list[mpmath.mpf]) -> mpmath.mpf:
    return MP.fsum(abs(a - SCALE * b) for a, b in zip(x[0], true, strict=True))


@pytest.mark.few(4)
@pytest.mark.parametrize("seed", SEEDS)
def test_series_of_sines_and_powers_are_those_of_mpmath_and_sizes_are_nowhere_exceeded(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(6):
        angle, ahead, count = abs(drawn(draw, 99)), abs(drawn(draw, 5)) + Fraction(1, 9), draw.choice([1, 4, ORDER + 1])
        weights = [exact(ahead) ** n / MP.factorial(n) for n in range(count)]
        for found, turn in zip(series.waves(balls.circle(angle), ahead, count), (0, 1), strict=True):
            true = [MP.sin(exact(angle) + (n + turn) * MP.pi / 2) * w for n, w in enumerate(weights)]
            assert row_errors(found, true) <= found[1] <= 2 * MP.fsum(weights) + 2 * count + 2
        for found in series.waves([SCALE] * 4, ahead, count):
            assert row_errors(found, weights) <= found[1]
        low = abs(drawn(draw)) + Fraction(1, 7)
        high, step, alpha = (
            low + abs(drawn(draw)),
            abs(drawn(draw)) + Fraction(1, 99),
            Fraction(draw.randint(1, 29), 30),
        )
        ratio = [MP.binomial(exact(alpha), n) * exact(step) ** n for n in range(count)]
        power = lambda x: [w * exact(x) ** (exact(alpha) - n) for n, w in enumerate(ratio)]  # noqa: B023, E731
        found = series.binomial(alpha, low, low, step, count)
        assert (
            row_errors(found, power(low))
            <= found[1]
            <= (2 + power(low)[0]) * MP.fsum(map(abs, ratio)) * (1 + exact(low) ** -count) + count + 6
        )
        if low < high:
            sizes, lost = series.binomial(alpha, low, high, step, count)
            for x in (low, (low + high) / 2, high):
                assert all(abs(y) * SCALE <= size + lost for y, size in zip(power(x), sizes, strict=True))
        sizes, lost = series.binomial(alpha, Fraction(0), high, step, count)
        assert off((sizes[0], lost), exact(step) ** exact(alpha)) <= lost
        assert sizes[1:] == [0] * (count - 1)


@pytest.mark.few(1)
@pytest.mark.parametrize("seed", SEEDS)
def test_products_and_polynomials_at_a_place_hold_what_mpmath_says(seed: int) -> None:
    """At a number to few parts of one, and from low to high nowhere exceeded: also with coefficients that are not known exactly."""
    draw = random.Random(seed)
    delays, orders = (Fraction(draw.randint(1, 9), 7),), (Fraction(draw.randint(1, 9), 10),)
    low, step = Fraction(draw.randint(16, 40), 4), Fraction(1, draw.randint(4, 40))
    high = low + 2 * step
    powers = tuple(draw.randint(0, 3) for _ in range(5))
    p = [(draw.randint(-9, 9) * SCALE, draw.choice([0, 1, SCALE >> 90])) for _ in range(draw.randint(1, 20))]
    edge = [exact(Fraction(m + draw.choice([-1, 1]) * r, SCALE)) for m, r in p]

    def value(w: mpmath.mpc) -> mpmath.mpc:
        angle, raised, turn = w * exact(delays[0]) / 2, w ** exact(orders[0]), exact(orders[0]) * MP.pi / 2
        factors = w, MP.sin(angle), MP.cos(angle), raised * MP.cos(turn), raised * MP.sin(turn)
        return MP.fprod(x**n for x, n in zip(factors, powers, strict=True)) * MP.polyval(edge[::-1], w)

    def coefficients(x: Fraction) -> list[mpmath.mpf]:
        """Cauchy's integral over the circle |v| = 1, by its values at 96 points: what they miss is below 16^-81."""
        turns = [MP.expjpi(MP.mpf(k) / 48) for k in range(96)]
        every = [value(exact(x) + exact(step) * v) for v in turns]
        return [MP.fsum(f * turns[-k * n % 96] for k, f in enumerate(every)).real / 96 for n in range(ORDER + 1)]

    middle = low + step
    found = Place(delays, orders, middle, middle, step).total([(powers, p)])
    assert row_errors(found, coefficients(middle)) <= found[1]
    assert max(r for _, r in p) > 1 or found[1] < SCALE * MP.mpf(10) ** -40
    sizes, lost = Place(delays, orders, low, high, step).total([(powers, [(abs(m) + r, 0) for m, r in p])])
    assert min(sizes) > -lost
    for x in (low, middle, high):
        assert all(abs(y) * SCALE <= size + lost for y, size in zip(coefficients(x), sizes, strict=True))
    [at], lost = Place(delays, orders, middle, middle, Fraction(0)).total([(powers, p)])
    assert off((at, lost), value(exact(middle))) <= lost


def test_numbers_too_large_for_sines_and_powers_are_refused() -> None:
    half, most = Fraction(1, 2), Fraction(2) ** 99_999
    assert refused(balls.circle, Fraction(2**48))
    assert not refused(balls.circle, Fraction(2**48 - 1))
    for x, too_large in ((Fraction(0), True), (Fraction(-1), True), (most, False), (1 / most, False), (2 * most, True)):
        assert refused(balls.power, x, half) == too_large
    assert refused(balls.power, 1 / (2 * most), half)


def test_artanh_and_pi_are_those_of_mpmath() -> None:
    for x in (Fraction(1, 3), Fraction(-1, 3), Fraction(1, 7), Fraction(0)):
        true = MP.atanh(exact(x)) * FINER
        assert abs(balls.artanh(x) - true) < 1000
    low, high = (Fraction(*x) for x in PI)
    assert MP.pi - exact(low) > 0
    assert exact(high) - MP.pi > 0
    assert high - low < Fraction(1, 10**98)
    for n, terms in ((2, 5), (5, 8), (3, 1)):
        low, high = polynomials.arctangent(n, terms)
        assert exact(low) < MP.atan(1 / MP.mpf(n)) < exact(high)
        assert high - low == Fraction(1, (2 * terms + 1) * n ** (2 * terms + 1))
    for row in ([3], [0, 1], [-2, 5, -7], [0, 0, 0, 0, -1]):
        found, true = balls.in_pi(row), sum(c * MP.pi**k for k, c in enumerate(row))
        assert off(found, true) <= found[1] <= sum(2 * abs(c) for c in row)


# Polynomials


def at(p: list[int], x: Fraction) -> Fraction:
    return sum((c * x**n for n, c in enumerate(p)), Fraction(0))


def whole_numbers(draw: random.Random, length: int) -> list[int]:
    return [draw.randint(-9, 9) for _ in range(length)]


@pytest.mark.few(5)
@pytest.mark.parametrize("seed", SEEDS)
def test_a_polynomial_that_is_moved_or_sliced_has_the_same_values(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(40):
        p, u = whole_numbers(draw, draw.randint(1, 6)), Fraction(draw.randint(1, 20), draw.randint(1, 9))
        (a, c), (b, d) = sorted((draw.randint(0, 9), draw.randint(1, 5)) for _ in range(2))
        low, high = (a, c), draw.choice([(b, d), (1, 0)])
        x, weight = (low[0] + high[0] * u) / (low[1] + high[1] * u), low[1] + high[1] * u
        assert at(polynomials.moved(p, low, high), u) == at(p, x) * weight ** (len(p) - 1)
        assert at(polynomials.times(p, a, b), u) == at(p, u) * (a + b * u)
        rows = [whole_numbers(draw, draw.randint(1, 4)) for _ in range(draw.randint(1, 4))]
        for ends in ((low, high), PI):
            (a, c), (b, d) = ends
            inner, weight = (a + b * u) / (c + d * u), c + d * u
            slices, w = polynomials.sliced(rows, *ends), drawn(draw)
            total = sum((u**k * at(q, w) for k, q in enumerate(slices)), Fraction(0))
            most = max(map(len, rows)) - 1
            assert total == sum(at(row, inner) * w**n for n, row in enumerate(rows)) * weight**most
            assert len(slices) == most + 1


def expanded(roots: list[tuple[Fraction, int]], square: int = 0) -> list[int]:
    """The polynomial with these roots, and perhaps without others."""
    p = [1] if not square else [square, 0, 1]
    for x, n in roots:
        for _ in range(n):
            p = [
                a + b
                for a, b in zip([*(-x.numerator * c for c in p), 0], [0, *(x.denominator * c for c in p)], strict=True)
            ]
    return p


@pytest.mark.few(10)
@pytest.mark.parametrize("seed", SEEDS)
def test_factors_have_the_zeros_that_they_were_made_of(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(40):
        step = draw.choice([1, 2])
        roots = {
            Fraction(draw.randint(0, 6), draw.choice([1, 2])): draw.choice([1, 1, 2]) for _ in range(draw.randint(0, 4))
        }
        a, b = sorted(draw.sample([Fraction(n, 2) for n in range(13)], 2))
        sign = draw.choice([-1, 1])
        own = [(x**step, n) for x, n in roots.items()]
        p = [sign * c for c in expanded(own, draw.choice([0, 40**2]))]
        factor = Factor([[c] for c in p], step)

        def value(x: Fraction, p: list[int] = p, step: int = step) -> int:
            found = at(p, x**step)
            return (found > 0) - (found < 0)

        order, found = factor.signs(a, b)
        assert order == roots.get(a, 0) * (step if a == 0 else 1)
        assert found[0] == value(min([x for x in (*roots, b) if x > a]) * Fraction(1, 2) + a / 2)
        inside = sum(n for x, n in roots.items() if a < x < b)
        assert polynomials.order(found[::-1]) == roots.get(b, 0)
        assert polynomials.turns(found) in range(inside, len(found), 2)
        assert len(p) > 5 or polynomials.turns(found) == inside  # as far apart as these are
        x = Fraction(draw.randint(0, 12), 4)
        assert factor.sign(x) == value(x)
        numbers = draw.randint(-5, 5), draw.randint(1, 9)
        assert factor.at(*numbers, []) == Value(int(at(p, Fraction(numbers[0] ** step))), 0, factor.degrees)


def test_signs_that_depend_on_pi_stay_open_where_its_bounds_do_not_tell() -> None:
    near = Factor([[-314159265358979323846, 10**20]])
    assert near.sign(Fraction(1)) == 1
    far = 10**99
    assert refused(Factor([[-int(MP.pi * far), far]]).sign, Fraction(1)) is False
    far = 10**130
    assert refused(Factor([[-int(MP.pi * far), far]]).sign, Fraction(1))
    assert Factor([[0, 1], [-1]]).signs(Fraction(3), Fraction(4)) == (0, [1, -1])


def test_sizes_costs_and_degrees_of_factors() -> None:
    rows = [[1, 0, 5], [2**64], [-(2**128), 1]]
    factor = Factor(rows, 2, 1, 1)
    assert (factor.degrees, factor.cost, factor.size) == ((4, 2, 0, 0, 0, 0), 27 * 3 + 1000, 10 + 6 + 1 + 2)
    assert factor.values(3, 2) == [(1 + 5 * 4) + 2**64 * 9 + (2 - 2**128) * 81]
    assert factor.at(3, 2, [7, 1, 1]).re == factor.values(3, 2)[0]
    assert polynomials.pairs([1, 2, 3, 4]) == [(1, 2), (3, 4)]
    assert polynomials.turns([0, 1, 0, -1, -1, 0, 1, 0]) == 2
    assert polynomials.order([0, 0, 5, 0]) == 2
    assert not refused(polynomials.affordable, [Fraction(3, 4), Fraction(1)], 5 * 10**9 // 7 - 1)
    assert refused(polynomials.affordable, [Fraction(3, 4), Fraction(1)], 5 * 10**9 // 7 + 1)


# Values


def gaussian(x: Value) -> tuple[Fraction, Fraction]:
    return Fraction(x.re), Fraction(x.im)


@pytest.mark.few(10)
@pytest.mark.parametrize("seed", SEEDS)
def test_values_are_gaussian_integers_with_degrees(seed: int) -> None:
    draw = random.Random(seed)

    def value() -> Value:
        return Value(draw.randint(-9, 9), draw.randint(-9, 9), tuple(draw.randint(0, 5) for _ in range(6)))

    for _ in range(60):
        x, y, n, sign = value(), value(), draw.randint(0, 4), draw.choice([-1, 1])
        z, w = (complex(a.re, a.im) for a in (x, y))
        assert complex(*x.plus(y, sign)[:2]) == z + sign * w
        assert x.plus(y)[:2] == x.plus(y, 1)[:2]
        assert x.plus(y).degrees == tuple(map(max, x.degrees, y.degrees))
        assert complex(*x.times(y)[:2]) == z * w
        assert x.times(y).degrees == tuple(a + b for a, b in zip(x.degrees, y.degrees, strict=True))
        assert complex(*x.power(n)[:2]) == z**n
        assert x.power(n).degrees == tuple(n * a for a in x.degrees)
        assert (complex(*x.conjugate()[:2]), x.conjugate().degrees) == (z.conjugate(), x.degrees)
        bottoms = [Value(draw.randint(1, 9), draw.randint(-3, 3)) for _ in range(2)]
        for sign_of, true in (("+", 1), ("-", -1)):
            top, bottom = values.combined(sign_of, (x, bottoms[0]), (y, bottoms[1]))
            c, d = (complex(a.re, a.im) for a in bottoms)
            assert complex(top.re, top.im) == z * d + true * w * c
            assert complex(bottom.re, bottom.im) == c * d
        assert values.combined("*", (x, bottoms[0]), (y, bottoms[1])) == (x.times(y), bottoms[0].times(bottoms[1]))
        assert values.combined("/", (x, bottoms[0]), (y, bottoms[1])) == (x.times(bottoms[1]), bottoms[0].times(y))


def test_numbers_of_more_than_thirty_thousand_bits_are_refused() -> None:
    x = Value(2**29_997)
    assert not refused(x.times, Value(2))
    assert refused(x.times, Value(4))
    assert refused(Value(2**14_999, 2**14_999).times, Value(1, 2))


def test_degrees_stand_at_their_places() -> None:
    assert [degree(i) for i in range(6)] == [tuple(int(k == i) for k in range(6)) for i in range(6)]
    assert degree(2, 5) == (0, 0, 5, 0, 0, 0)
    assert values.ONE == (1, 0, (0,) * 6)
    assert values.ZERO.times(Value(1, 0, (99,) * 6)).degrees < (0,) * 6


def test_powers_and_delays_at_a_point() -> None:
    s, half, third = (Value(2, 1, degree(0)), Value(3)), Fraction(1, 2), Fraction(1, 3)
    point = Point(s, 4, (Fraction(1, 5), Fraction(1, 7)), (third, half), (2, 5, (11, 13), (17, 19)))
    whole = {
        2: (Value(3, 4, degree(0, 2)), Value(9)),
        0: (values.ONE, values.ONE),
        -1: (Value(3), Value(2, 1, degree(0))),
    }
    for n, found in whole.items():
        assert point.raised(Fraction(n)) == found
    for exponent, root, i in ((Fraction(5, 2), Value(17, 19), 5), (Fraction(-2, 3), Value(11, 13), 4)):
        top, bottom = whole[int(exponent // 1)]
        assert point.raised(exponent) == (top.times(root._replace(degrees=degree(i))), bottom)
    assert refused(point.raised, Fraction(1, 4))
    assert refused(point.raised, Fraction(100))
    assert not refused(point.raised, Fraction(99))
    assert not refused(point.raised, Fraction(-99))
    assert refused(point.raised, Fraction(-100))
    assert point.delayed(Fraction(0)) == values.ONE
    assert point.delayed(Fraction(1, 5)) == Value(1, -2, degree(2))
    assert point.delayed(Fraction(1, 7)) == Value(1, -5, degree(3))
    assert point.delayed(Fraction(3, 7)) == Value(1, -5, degree(3)).power(3)
    assert not refused(point.delayed, Fraction(64, 7))
    assert refused(point.delayed, Fraction(65, 7))
    assert refused(point.delayed, Fraction(1, 10))


# What is read


def test_what_is_no_number_and_no_list_is_refused() -> None:
    good = {
        "0": 0,
        "-12": -12,
        "3/4": Fraction(3, 4),
        "-0.50": -Fraction(1, 2),
        "1E2": 100,
        "2.5E-3": Fraction(1, 400),
        "1E+3": 1000,
    }
    for text, number in good.items():
        assert reading.number(text) == number
    assert reading.number("7" * 2000) == int("7" * 2000)
    assert reading.number("1/1" + "0" * 1999) == Fraction(1, 10**1999)
    for text in (
        "",
        "+1",
        "1e2",
        "1.",
        ".5",
        "1/0",
        "1/02",
        "1/2E3",
        "0x1",
        " 1",
        "1\n",
        "1E1000",
        "7" * 2001,
        "1/1" + "0" * 2000,
        1,
        None,
    ):
        assert refused(reading.number, text)
    assert reading.numbers(["1", "2", "5/2"], 3) == [1, 2, Fraction(5, 2)]
    for row in (["1", "1"], ["2", "1"], ["1", "2", "3", "4"]):
        assert refused(reading.numbers, row, 3)
    assert refused(reading.numbers, ["1"], 3, 2)
    assert not refused(reading.numbers, [], 3)
    assert reading.keyed({"b": 2, "a": 1}, "a", "b") == [1, 2]
    for x in ({"a": 1}, {"a": 1, "b": 2, "c": 3}, ["a", "b"], None):
        assert refused(reading.keyed, x, "a", "b")
    assert [refused(reading.listed, [0] * n, 4, 2) for n in range(6)] == [True, True, False, False, False, True]
    assert refused(reading.listed, (1, 2, 3), 4)
    assert not refused(reading.listed, [], 4)
    assert [refused(reading.whole, n, 1, 3) for n in (0, 1, 2, 3, 4, True, "1", 1.0)] == [
        True,
        False,
        False,
        False,
        True,
        True,
        True,
        True,
    ]


def test_delays_and_orders_are_at_most_four_positive_numbers_of_a_hundred_bits() -> None:
    huge = 2**100
    assert reading.others([], []) == [(), ()]
    assert reading.others(["1/3", "5"], ["1/2"]) == [(Fraction(1, 3), 5), (Fraction(1, 2),)]
    for delays, orders, is_refused in (
        ([str(huge - 1), f"1/{huge - 1}"], [f"{huge - 2}/{huge - 1}", f"1/{huge - 1}"], False),
        ([str(huge)], [], True), ([f"1/{huge}"], [], True), ([f"3/{huge + 1}"], [], True), (["0"], [], True), (["-1/3"], [], True),
        ([], ["1"], True), ([], ["0"], True), ([], ["-1/3"], True), ([], ["4/3"], True), ([], [f"1/{huge}"], True), ([], [f"3/{huge + 1}"], True),
        (["1", "2", "3", "4"], [], False), ([], ["1/2", "1/3", "1/4", "1/5"], False), (["1", "2"], ["1/2", "1/3"], False),
        (["1", "2", "3", "4", "5"], [], True), (["1", "2", "3"], ["1/2", "1/3"], True), (["1", "2", "3", "4"], ["1/2"], True), (None, [], True), ([], "1/2", True),
    ):  # fmt: skip
        assert refused(reading.others, delays, orders) == is_refused, (delays, orders)


def test_polynomials_are_read_coefficient_by_coefficient() -> None:
    assert reading.polynomial([["0", "-1"], ["12"]]) == [[0, -1], [12]]
    assert reading.polynomial([["1"], ["0", "5"]]) == [[1], [0, 5]]
    assert reading.polynomial([["9" * 2000]] * 300)[299] == [int("9" * 2000)]
    assert len(reading.polynomial([["1"] * 100])[0]) == 100
    for rows in (
        [], [[]], [["1"], ["0"]], [["1"], ["-0"]], [["1.5"]], [[1]], [["1/2"]], [["9" * 2001]], [["1"]] * 301, [["1"] * 101], [["1"], []], "1", [["00"]],
    ):  # fmt: skip
        assert refused(reading.polynomial, rows)
