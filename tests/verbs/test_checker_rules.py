"""The rules of the checker of certificates, one by one: against roots placed by hand, dense samples, mpmath, Pint and Python's own formulas."""

from __future__ import annotations

import itertools
import random
from fractions import Fraction
from functools import reduce
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import mpmath
import pint
import pytest

from haptisym_check import RefusedError, chart, formulas, link, requirement, slices, waves, zeros
from haptisym_check.balls import SCALE
from haptisym_check.formulas import FREE, Number
from haptisym_check.link import PARTS, Product
from haptisym_check.polynomials import PI, Factor
from haptisym_check.series import ORDER
from haptisym_check.values import ONE, Point, Ratio, Value, combined, degree

MP = mpmath.mp.clone()
MP.prec = 600
SEEDS = range(20)


def refused(function: Any, *given: Any, **named: Any) -> bool:
    try:
        function(*given, **named)
    except RefusedError:
        return True
    return False


def expanded(roots: list[tuple[int, int]]) -> list[list[int]]:
    """Rows of the product of all (a + b x)."""
    p = [1]
    for a, b in roots:
        p = [a * x + b * y for x, y in zip([*p, 0], [0, *p], strict=True)]
    return [[c] for c in p]


def sign(x: Any) -> int:
    return int(x > 0) - int(x < 0)


# Charts: what is claimed of a band, against signs of the functions at and between all of their zeros


def own_number(value: Fraction, pi: int = 0) -> Number:
    return Number(value, pi)


def band(low: Fraction | int, high: Fraction | int) -> Any:
    return SimpleNamespace(band=[own_number(Fraction(low)), own_number(Fraction(high))])


class Drawn:
    """Ten products of linear factors with known roots, on the band from 0 or 1 to 6, and their cells."""

    def __init__(self, seed: int) -> None:
        draw = random.Random(seed)
        self.low, self.high = draw.choice([0, 1]), 6
        places = draw.sample(range(self.low, 7), draw.randint(1, 5))
        self.roots = [Fraction(n) + (Fraction(draw.randint(-1, 1), 5) if self.low < n < 6 else 0) for n in places]
        self.factors = [Factor(expanded([(-x.numerator, x.denominator)])) for x in self.roots]
        self.factors.append(Factor([[9], [0], [1]]))
        self.told: dict[str, Product] = {}
        for name in (f"{x}.{part}" for x in chart.CURVES for part in PARTS):
            powers = [[i, draw.choice([-2, -1, 1, 1, 2])] for i in range(len(self.factors)) if draw.random() < 0.6]
            number = draw.choice(["1", "-1", "3/7", "-2", "0"]) if draw.random() < 0.9 else "0"
            row = {"number": number, "powers": [] if number == "0" else powers}
            self.told[name] = Product(row, self.factors)
        self.inside = sorted(x for x in self.roots if self.low < x < 6)
        self.places = [Fraction(self.low), *self.inside, Fraction(6)]
        self.points = sorted({*map(Fraction, (self.low, 6)), *((a + b) / 2 for a, b in pairwise(self.places))})
        self.enclosures = [
            [x, x] if draw.random() < 0.5 or x in (self.low, 6) else [x - Fraction(1, 50), x + Fraction(1, 60)]
            for x in self.places
        ]
        self.between = [(a + b) / 2 for a, b in pairwise(self.places)]

    def chart(self) -> chart.Chart:
        return chart.Chart(band(self.low, 6), self.points, self.factors, self.enclosures)  # type: ignore[arg-type]

    def value(self, name: str, x: Fraction) -> int | None:
        """The sign at a place; None at a pole."""
        found = self.told[name].number
        for i, n in self.told[name].powers.items():
            own = (x - self.roots[i]) if i < len(self.roots) else x**2 + 9
            if own == 0 and n < 0:
                return None
            found *= own**n
        return sign(found)

    def order(self, name: str, x: Fraction) -> int:
        return sum(n for i, n in self.told[name].powers.items() if i < len(self.roots) and self.roots[i] == x)

    def around(self, name: str, x: Fraction) -> tuple[int, int]:
        """The signs just before and just after."""
        found = [self.value(name, x + way * Fraction(1, 10**6)) for way in (-1, 1)]
        assert found[0] is not None
        assert found[1] is not None
        return found[0], found[1]

    def limit(self, name: str, x: Fraction) -> int:
        """The sign at a place; at a pole that on both sides, 0 if they differ."""
        own = self.value(name, x)
        before, after = self.around(name, x)
        return own if own is not None else (before if before == after else 0)


def merged(line: list[Any]) -> list[tuple[int, int, Any]]:
    """Of values at places and between them in turn: where one stays, from place to place."""
    found: list[tuple[int, int, Any]] = []
    for n, x in enumerate(line):
        a, b = n // 2, (n + 1) // 2
        if x and n and line[n - 1] == x:
            found[-1] = (found[-1][0], b, x)
        elif x:
            found.append((a, b, x))
    return found


def percept(own: Drawn, part: str, x: Fraction) -> tuple[str, str] | None:
    """What is felt at a frequency that is no zero: eqs. (11) to (14) of the paper."""
    env, perc, excess, change, both = (own.value(f"{name}.{part}", x) for name in chart.CURVES)
    assert env is not None
    assert perc is not None
    assert change is not None
    assert both is not None
    assert excess is not None
    if excess <= 0 or (part == "imag" and perc < 0):
        return None
    louder = change * both  # of |G|^2 - |H|^2
    word = "higher" if louder > 0 else "lower" if louder < 0 else "equal"
    if part == "imag":
        return "damping", word
    a, b = env or perc, perc or env
    names = {(1, 1): "stiffness", (-1, -1): "mass", (1, -1): "stiffness-to-mass", (-1, 1): "mass-to-stiffness"}
    return names[a, b], word


@pytest.mark.few(4)
@pytest.mark.parametrize("seed", [range(n, n + 25) for n in range(0, 500, 25)])
def test_what_is_claimed_of_a_band_is_what_signs_at_and_between_zeros_say(seed: range) -> None:
    for n in seed:
        own = Drawn(n)
        made = own.chart()
        curves = {name: chart.Curve(x, made) for name, x in own.told.items()}
        if any(not curves[f"{x}.real"].between[0] for x in ("environment", "perceived")) and any(
            x > 0 for x in curves["excess.real"].between
        ):
            continue  # a real part that is zero everywhere has the other's name; both have none
        found = chart.claimed(curves, from_0=made.from_0)
        places = own.places

        def holding(test: Any, *names: str, own: Drawn = own, places: Any = places) -> list[list[int]]:
            every = [x for pair in zip(places, [*own.between, None], strict=True) for x in pair][:-1]
            return [[a, b] for a, b, _ in merged([all(test(own.limit(name, x)) for name in names) for x in every])]

        assert found["transparent"] == holding(lambda x: x <= 0, "excess.real", "excess.imag")
        assert found["outside_model"] == holding(lambda x: x < 0, "perceived.imag")
        assert found["unbounded"] == [
            i for i, x in enumerate(places) if any(own.order(f"excess.{part}", x) < 0 for part in PARTS)
        ]
        for name in ("environment", "perceived"):
            turning = [i for i, x in enumerate(places) if set(own.around(f"{name}.real", x)) == {1, -1}]
            assert found["changeovers"][name] == turning
        crossings = []
        for i, x in enumerate(places):
            for part in PARTS:
                name = f"excess.{part}"
                if (order := own.order(name, x)) > 0 and own.told[name].number:
                    before, after = own.around(name, x)
                    from_rest = x == 0 and after > 0
                    kind = "touches" if before == after and not from_rest else "exceeds" if after > 0 else "returns"
                    change = own.around(f"difference.{part}", x)[1]
                    crossings.append({"at": i, "part": part, "kind": kind, "sign": change, "multiplicity": order})
        assert found["crossings"] == crossings
        felt = []
        for part in PARTS:
            line: list[Any] = []
            for x, y in zip(places, [*own.between, None], strict=True):
                now = percept(own, part, y) if y is not None else None
                stays = line and now == line[-1] and own.limit(f"excess.{part}", x) > 0
                line += [now if stays else None, now]
            felt += [
                {"part": part, "from": a, "to": b, "property": name, "change": word}
                for a, b, (name, word) in merged(line[:-1])
            ]
        assert found["percepts"] == felt


@pytest.mark.few(11)
@pytest.mark.parametrize("seed", SEEDS)
def test_a_chart_whose_cells_or_enclosures_do_not_hold_is_refused(seed: int) -> None:
    own = next(x for n in range(100 * seed, 100 * seed + 99) if len((x := Drawn(n)).inside) > 1 and x.low)
    own.chart()
    points, told, a = own.points, own.enclosures, own.inside[0]
    scene: Any = band(1, 6)

    def fails(points: list[Fraction], told: list[list[Fraction]], scene: Any = scene) -> bool:
        return refused(chart.Chart, scene, points, own.factors, told)

    assert not fails(points, told)
    assert fails([*points[:2], *points[3:]], told)  # two zeros in a cell
    assert fails([*points[:1], a, *points[1:]], told)  # a zero at a breakpoint
    assert fails(points, told[:-1])
    assert fails(points, [*told, told[-1]])
    assert fails(points, [told[0], *told[2:], told[-1]])
    beside = [
        [a + Fraction(1, 90), a + Fraction(1, 70)],
        [a - Fraction(1, 70), a - Fraction(1, 90)],
        [points[0], a],
        [a, points[1]],
    ]
    for wrong in (*beside, [a + Fraction(1, 70), a - Fraction(1, 70)]):
        assert fails(points, [told[0], wrong, *told[2:]])
    assert not fails(points, [told[0], [a, a + Fraction(1, 90)], *told[2:]])
    assert not fails(points, [told[0], [a - Fraction(1, 90), a], *told[2:]])
    assert fails(points, [[Fraction(101, 100)] * 2, *told[1:]])
    assert fails(points, [*told[:-1], [Fraction(599, 100)] * 2])
    assert not fails(points, [[Fraction(1, 2), Fraction(1)], *told[1:-1], [Fraction(6), Fraction(7)]])
    low, high = Fraction(1), Fraction(6)
    assert fails([Fraction(11, 10), *points[1:]], told)
    assert fails([*points[:-1], Fraction(59, 10)], told)
    if (
        own.roots.count(low) == own.roots.count(high) == 0
        and own.inside[0] > Fraction(6, 5)
        and own.inside[-1] < Fraction(28, 5)
    ):
        wide = [Fraction(1, 2), Fraction(11, 10), *points[1:-1], Fraction(58, 10), Fraction(7)]
        assert not fails(wide, told)
        assert fails([Fraction(-1, 2), *wide[1:]], told)
        assert fails([Fraction(1, 2), *points[2:]], told)  # a zero in the cell of the low end may lie before it
        assert fails([*points[:-2], Fraction(7)], told)
    for own_band in (band(6, 6), band(6, 1)):
        assert fails(points, told, own_band)


def test_a_cell_of_an_end_of_the_band_holds_no_zero() -> None:
    factor = Factor(expanded([(-2, 1), (-5, 1)]))
    told = [[Fraction(n)] * 2 for n in (1, 2, 5, 6)]

    def fails(*points: str) -> bool:
        return refused(chart.Chart, band(1, 6), list(map(Fraction, points)), [factor], told)

    assert [fails(*x.split()) for x in ("1 3 6", "1/2 3/2 3 11/2 7", "1 3 11/2 7", "1/2 3/2 3 6")] == [False] * 4
    assert [fails(*x.split()) for x in ("1/2 3 6", "1 3 7", "1 6", "1 2 6", "1 5 6")] == [True] * 5
    beyond = (
        "1/2 3/4 3/2 3 6",
        "1/2 3/4 1 3 6",
        "1 3 13/2 7",
        "1 3 13/2 27/4 7",
        "1/4 1/2 3 6",
    )  # a cell too many
    assert [fails(*x.split()) for x in beyond] == [True] * 5


def test_at_the_outer_end_of_a_cell_that_reaches_beyond_the_band_no_factor_is_zero_whatever_others_are() -> None:
    told, other = [[Fraction(n)] * 2 for n in (1, 6)], Factor([[9], [0], [1]])
    for own, zero in ((Factor(expanded([(-1, 2)])), "1/2 6"), (Factor(expanded([(-7, 1)])), "1 7")):
        for factors in ([own, other], [other, own], [own]):
            for points, fits in ((zero, False), ("1 6", True), ("3/4 6", True), ("1 27/4", True), ("2/3 20/3", True)):
                given = list(map(Fraction, points.split()))
                assert refused(chart.Chart, band(1, 6), given, factors, told) is not fits


def test_the_ends_of_a_band_in_hertz_lie_between_those_with_numbers_below_and_above_pi() -> None:
    scene: Any = SimpleNamespace(band=[own_number(Fraction(2), -1), own_number(Fraction(3), 1)])
    (a, b), (c, d) = chart.ends_of_band(scene)
    low, high = (Fraction(*x) for x in PI)
    assert (a, b, c, d) == (2 / high, 2 / low, 3 * low, 3 * high)
    assert chart.holds([a, b], [a, b])
    assert not chart.holds([a, b], [a, d])
    assert not chart.holds([b, d], [a, d])
    assert [chart.away(Fraction(n, 2)) for n in range(-3, 4)] == [-2, -1, -1, 0, 1, 1, 2]


# Roots in Re s >= 0


@pytest.mark.few(11)
@pytest.mark.parametrize("seed", SEEDS)
def test_roots_placed_by_hand_are_counted(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(12):
        roots: list[complex] = []
        p = [1]
        for _ in range(draw.randint(1, 4)):
            a, b = draw.randint(-3, 3), draw.randint(1, 4)
            if draw.random() < 0.5:
                by, found = [a * a + b * b, -2 * a, 1], [complex(a, b), complex(a, -b)]
            else:
                by, found = [-a, 1], [complex(a)]
            p = [
                sum(p[i] * by[n - i] for i in range(len(p)) if 0 <= n - i < len(by))
                for n in range(len(p) + len(by) - 1)
            ]
            roots += found
        if any(x.real == 0 and x.imag for x in roots) or any(-x in roots for x in roots if x):
            continue  # E and O have a zero in common
        own = p[roots.count(0) :]
        even = [c * (-1) ** k for k, c in enumerate(own[::2])]
        square = sorted(x.real for x in map(complex, _roots(even)) if abs(x.imag) < 1e-9 and x.real > 0)
        odd = sorted(
            x.real
            for x in map(complex, _roots([c * (-1) ** k for k, c in enumerate(own[1::2])]))
            if abs(x.imag) < 1e-9 and x.real > 0
        )
        if any(b - a < 1e-4 for a, b in pairwise(sorted([*square, *odd]))):
            continue
        near = [min([abs(x - y) for y in (*square, *odd) if x != y] + [x, 1.0]) / 3 for x in square]
        cuts = sorted(
            {Fraction(0), *(Fraction(x + way * r) for x, r in zip(square, near, strict=True) for way in (-1, 1))}
        )
        sign_of = draw.choice([-1, 1])
        rows = [[sign_of * c] for c in p]
        while refused(zeros.to_the_right, rows, cuts):  # Descartes' rule sees more zeros than there are
            cuts = sorted({*cuts, *((a + b) / 2 for a, b in pairwise(cuts)), 2 * cuts[-1] + 1})
        assert zeros.to_the_right(rows, cuts) == sum(x.real >= 0 for x in roots), p


def _roots(p: list[int]) -> list[Any]:
    p = p[: len(p) - next((i for i, c in enumerate(p[::-1]) if c), len(p))]
    return list(MP.polyroots(p[::-1], maxsteps=200, extraprec=200)) if len(p) > 1 else []


@pytest.mark.parametrize("seed", range(4))
def test_roots_are_counted_where_powers_are_missing(seed: int) -> None:
    """Coefficients of which many are 0, so that E or O begins late, ends early or is 0: against mpmath's roots."""
    draw, counted = random.Random(seed), 0
    for _ in range(40):
        p = [draw.choice([0, 0, draw.randint(-5, 5)]) for _ in range(draw.randint(1, 5))] + [draw.choice([-2, 1, 3])]
        roots = _roots(p[next(i for i, c in enumerate(p) if c) :])
        if any(abs(x.real) < 1e-6 for x in roots):
            continue
        at_0 = next(i for i, c in enumerate(p) if c)
        even = _roots([c * (-1) ** k for k, c in enumerate(p[at_0::2])])
        ends = draw.choice([(1.07,), (0.93, 1.07)])  # the first cell may hold a zero
        cuts = {Fraction(0), *(Fraction(float(x.real * way)) for x in even if x.real > 0 for way in ends)}
        rows = [[c] for c in p]
        for _ in range(6):
            if not refused(zeros.to_the_right, rows, sorted(cuts)):
                counted += 1
                assert zeros.to_the_right(rows, sorted(cuts)) == at_0 + sum(x.real > 0 for x in roots), (p, cuts)
                break
            cuts |= {(a + b) / 2 for a, b in pairwise(sorted(cuts))} | {2 * max(cuts) + 1}
    assert counted > 25


def test_an_even_part_may_vanish_in_the_last_cell() -> None:
    """(s + 2) (s^2 - s + 3) and (s + 3) (s^2 - 2 s + 5): E = 6 - W and O = 1 - W, E = 15 - W and O = -1 - W; and one at 0 more."""
    for p, cuts in (
        ([6, 1, 1, 1], (0, 2)),
        ([15, -1, 1, 1], (0,)),
        ([15, -1, 1, 1], (0, 9)),
        ([15, -1, 1, 1], (0, 20)),
    ):
        for side, more in itertools.product((1, -1), (0, 1)):
            rows = [*[[0]] * more, *([side * c] for c in p)]
            assert zeros.to_the_right(rows, list(map(Fraction, cuts))) == 2 + more


def test_cells_that_do_not_part_zeros_of_even_and_odd_parts_are_refused() -> None:
    rows = expanded([(1, 1), (2, 1), (3, 1), (4, 1)])  # E = W^2 - 35 W + 24, O = 50 - 10 W
    assert zeros.to_the_right(rows, list(map(Fraction, (0, 1, 20)))) == 0
    for cuts in ((0,), (0, 40), (0, 1), (0, 4, 40)):
        assert refused(zeros.to_the_right, rows, list(map(Fraction, cuts)))
    assert refused(zeros.to_the_right, [[6], [1], [1]], list(map(Fraction, (0, 6))))  # E = 6 - W is zero there
    assert not refused(zeros.to_the_right, [[6], [1], [1]], list(map(Fraction, (0, 5))))


@pytest.mark.few(11)
@pytest.mark.parametrize("seed", SEEDS)
def test_polynomials_have_a_zero_in_common_if_they_share_one(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(30):
        p, q = ([(draw.randint(-6, 6), draw.randint(1, 3)) for _ in range(draw.randint(0, 4))] for _ in range(2))
        shared = {Fraction(-a, b) for a, b in p} & {Fraction(-a, b) for a, b in q}
        assert zeros.coprime(expanded(p), expanded(q)) == (not shared)
    with_pi, other = [[0, 1], [1]], [[0, 2], [3]]
    assert zeros.coprime(with_pi, other)
    assert not zeros.coprime(with_pi, [[0, 0, 1], [0, 2], [1]])
    assert zeros.coprime([[5]], [[7]])
    lost = [[1], [zeros.PRIME]]  # nothing is known where a leading coefficient vanishes
    for p in ([[1]], [[2], [1]], [[3], [5], [1]], lost):
        assert not zeros.coprime(lost, p)
        assert not zeros.coprime(p, lost)


def test_zeros_are_counted_with_multiplicity_and_poles_left_out() -> None:
    factors = [[["-1"], ["1"]], [["2"], ["1"]], [["3"], ["1"]]]

    def function(point: Point) -> Ratio:
        """(s - 1)^3 (s + 2)/(s + 3)."""
        s = point.s
        n = lambda k: (Value(k), ONE)  # noqa: E731
        top = combined("-", s, n(1))
        found = combined("*", combined("*", top, top), combined("*", top, combined("+", s, n(2))))
        return combined("/", found, combined("+", s, n(3)))

    told = {"factors": factors, "function": {"number": "1", "powers": [[0, 3], [1, 1], [2, -1]]}, "cells": [[], [], []]}
    assert zeros.zeros(told, function, 20) == 3
    assert refused(zeros.zeros, told | {"cells": [[], []]}, function, 20)
    for powers in ([[0, 2], [1, 1], [2, -1]], [[0, 3], [1, 1]], [[0, 3], [1, 1], [2, 1]]):
        assert refused(zeros.zeros, told | {"function": {"number": "1", "powers": powers}}, function, 20)
    assert refused(
        zeros.zeros, told | {"function": {"number": "2", "powers": told["function"]["powers"]}}, function, 20
    )  # type: ignore[index]
    nothing = {"factors": [], "function": {"number": "0", "powers": []}, "cells": []}
    assert refused(zeros.zeros, nothing, lambda _: (Value(0), ONE), 20)

    def cancelled(point: Point) -> Ratio:
        return combined("/", function(point), combined("-", point.s, (Value(1), ONE)))

    twice = {
        "factors": [*factors, factors[0]],
        "function": {"number": "1", "powers": [[0, 3], [1, 1], [2, -1], [3, -1]]},
    }
    assert refused(zeros.zeros, twice | {"cells": [[]] * 4}, cancelled, 20)
    assert zeros.zeros(told | {"function": {"number": "1", "powers": [[0, 2], [1, 1], [2, -1]]}}, cancelled, 20) == 2


# Formulas and units


def written(draw: random.Random, depth: int) -> tuple[str, str]:
    """A formula, and the same for Python."""
    if depth == 0 or draw.random() < 0.2:
        text = draw.choice(["7", "3", "0.5", "2.5e1", "1.25E-1", ".5", "4.", "a", "bc"])
        number = (
            text if text in ("a", "bc") else f"Fraction('{text.rstrip('.')}')" if text != ".5" else "Fraction('0.5')"
        )
        return text, number
    (x, a), (y, b) = written(draw, depth - 1), written(draw, depth - 1)
    match draw.randint(0, 6):
        case 0:
            n = draw.choice(["2", "3", "-1", "0", "(2)", "( -2 )", "1", "+2"])
            return f"({x}){draw.choice(['^', '**', ' ^ '])}{n}", f"({a})**{n}"
        case 1:
            return f"-({x})", f"(-({a}))"
        case 2:
            return f"({x})", f"({a})"
        case 3 | 4:
            sign_of = draw.choice("*/")
            return f"({x}){sign_of}({y})", f"({a}){sign_of}({b})"
        case _:
            sign_of = draw.choice("+-")
            y, b = (f"({y})", f"({b})") if y[0] in "+-" or sign_of == "-" else (y, b)
            return f"{x} {sign_of} {y}", f"({a} {sign_of} {b})"


NAMES = {"a": Fraction(3, 2), "bc": Fraction(-5)}


def leaf(word: str) -> Fraction:
    return NAMES[word] if word in NAMES else Fraction(word)


def joined(sign_of: str, x: Fraction, y: Fraction) -> Fraction:
    return x + y if sign_of == "+" else x - y if sign_of == "-" else x * y if sign_of == "*" else x / y


@pytest.mark.few(9)
@pytest.mark.parametrize("seed", SEEDS)
def test_formulas_have_the_values_that_python_gives_them(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(60):
        text, code = written(draw, 4)
        if len(text) > 900 or len(formulas.WORD.findall(text)) > 400:
            continue
        try:
            true = eval(code, {"Fraction": Fraction, **NAMES})  # noqa: S307  an independent reader of the same formula
        except (ZeroDivisionError, OverflowError):
            continue
        assert formulas.evaluated(text, leaf, joined) == true, text


def test_signs_bind_as_in_mathematics() -> None:
    for text in ("2 - 3 - 4", "12/3/2", "12/3*2", "2 + 3*4", "-3*2", "-2 + 3", "2*(-3)", "2*-3", "+3", "2-(-3)"):
        assert formulas.evaluated(text, leaf, joined) == eval(text)  # noqa: S307
    for text, value in (
        ("-2^2", -4),
        ("2^2^1", None),
        ("2*3^2", 18),
        ("(2*3)^2", 36),
        ("2^-2", Fraction(1, 4)),
        ("a^2", Fraction(9, 4)),
    ):
        if value is None:
            assert refused(formulas.evaluated, text, leaf, joined)
        else:
            assert formulas.evaluated(text, leaf, joined) == value
    for text in (
        "",
        "2 3",
        "2(3)",
        "(2)(3)",
        "2)",
        "(2",
        "*2",
        "2*",
        "2 + ",
        "2 ** ",
        "^2",
        "2 $ 3",
        "2$",
        "$a",
        "2 é",
        "2^x",
        "2^1000",
        "()",
        "2 * * 3",
        "a b",
    ):
        assert refused(formulas.evaluated, text, leaf, joined), text
    assert not refused(formulas.evaluated, "+".join(["1"] * 200), leaf, joined)
    assert refused(formulas.evaluated, "+".join(["1"] * 201), leaf, joined)
    assert formulas.evaluated("1" + " " * 3999, leaf, joined) == 1
    assert refused(formulas.evaluated, "1" + " " * 4000, leaf, joined)
    assert formulas.evaluated("a^0.5", lambda word: word, lambda *x: str(x)) == "a^1/2"
    assert formulas.evaluated("2 a", leaf, joined, spaced=True) == 3
    assert formulas.evaluated("a/bc a", leaf, joined, spaced=True) == Fraction(3, 2) / -5 * Fraction(3, 2)
    assert refused(formulas.evaluated, "a 2", leaf, joined, spaced=True)


@pytest.mark.few(10)
@pytest.mark.parametrize("seed", SEEDS)
def test_quantities_are_those_of_pint(seed: int) -> None:
    draw, registry = random.Random(seed), pint.get_application_registry()
    names = {
        **{x: x for x in ("rad", "deg", "g", "lb", "m", "ft", "s", "min", "N", "lbf", "kgf", "J")},
        "t": "metric_ton", "rev": "turn", "in": "inch", "Hz": "(turn/s)", "rpm": "rpm", "kg": "kg", "mm": "mm", "cm": "cm", "kN": "kN", "ms": "ms", "µs": "us", "mN": "mN", "MHz": "(1e6*turn/s)", "nm": "nm", "dm": "dm",
    }  # fmt: skip
    for _ in range(10):
        number, words = (
            draw.choice(["3", "0.25", "1e2", "-7"]),
            [draw.choice(list(names)) for _ in range(draw.randint(1, 3))],
        )
        signs = [draw.choice(["*", "/", " ", "·", "⋅"]) for _ in words[1:]]
        text = number + " " + words[0] + "".join(a + b for a, b in zip(signs, words[1:], strict=True))
        own = "".join(("/" if a == "/" else "*") + names[b] for a, b in zip(["*", *signs], words, strict=True))
        found = formulas.quantity(text)
        true = registry.Quantity(f"1.0{own}").to_base_units()
        assert float(found.value) * float(MP.pi) ** found.pi == pytest.approx(float(number) * true.magnitude, rel=1e-12)
        dimension = [true.dimensionality.get(f"[{x}]", 0) for x in ("mass", "length", "time")]
        assert found.dimension == pytest.approx(dimension)


def test_quantities_of_a_wrong_dimension_or_shape_are_refused() -> None:
    number = lambda value, pi=0, dimension=None: Number(Fraction(value), pi, dimension)  # noqa: E731
    assert formulas.quantity("5") == number(5)
    assert formulas.quantity(["1", "4"]) == number(Fraction(5, 2))
    assert formulas.quantity([1, 2, 4]) == number(2)
    assert formulas.quantity(["1 N/m", "3 N/m"], "k") == number(2, 0, [1, 0, -2])
    assert formulas.quantity("5 N/m +/- 1") == formulas.quantity("5 N/m ± 2 N/m") == number(5, 0, [1, 0, -2])
    assert formulas.quantity("5 N/m +- 1") == number(5, 0, [1, 0, -2])
    for text in (
        "6 N/2",
        "3/4*4 N",
        "N*3",
        "(3) N",
        "12 N/(2*2)",
        "3*1 N",
        "6 rad N/2",
    ):  # numbers before, between and behind
        assert formulas.quantity(text) == number(3, 0, [1, 1, -2])
    assert formulas.quantity("6/2") == formulas.quantity("3*1") == number(3)
    assert formulas.quantity("6/2/s") == number(3, 0, [0, 0, -1])
    assert formulas.quantity("-3 °") == number(-Fraction(3, 180), 1, [0, 0, 0])
    assert formulas.quantity("80 N s^0.3/m", "k_alpha").dimension == [1, 0, -Fraction(17, 10)]
    assert formulas.quantity("2 m²").dimension == formulas.quantity("2 m^2").dimension == [0, 2, 0]
    assert formulas.quantity("3 m³").dimension == [0, 3, 0]
    assert formulas.quantity(FREE) is FREE
    assert formulas.quantity("20 %") == number(Fraction(1, 5), 0, [0, 0, 0])
    for wrong in ([1], [1, 2, 3, 4], ["1 s", "2"], ["1 s", "2 m"], ["1 °", "2 rad"], True, None, 1.5, "x", "1 kmin", "1 xs", "1 kk", "5 +/- 1 +/- 2",
                  "5 + 1", "1/0", "1 µ%", "1 kin", "5 mm^0.5", "1 Hz^0.5", "4^0.5", "4^0.5 N", "1" * 500):  # fmt: skip
        assert refused(formulas.quantity, wrong), wrong
    for text, kind in (("1 N/m", "m"), ("1 kg", "k"), ("1 s", "o"), ("1 Hz", "t"), ("1 N", "z")):
        assert refused(formulas.quantity, text, kind)
    for text, kind in (("1 kg m^2", "m"), ("1 N m/rad", "k"), ("1 Hz", "o"), ("1 min", "t"), ("1 %", "z"), ("1", "k")):
        assert not refused(formulas.quantity, text, kind)
    assert Number(Fraction(3, 4), 2).at(5) == (Value(75, 0, degree(1, 2)), Value(4, 0, degree(1, 0)))
    assert Number(Fraction(3, 4), -1).at(5) == (Value(3, 0, degree(1, 0)), Value(20, 0, degree(1, 1)))
    assert Number(Fraction(0)).at(5)[0].degrees[0] < 0


# A requirement


def test_a_slab_has_one_sign_if_all_coefficients_have_it() -> None:
    one = Fraction(1), Fraction(3, 2)
    assert side([[-2, 1]], *one) == -1  # x - 2
    assert side([[-2, 1]], Fraction(3), Fraction(4), (True, True)) == 1
    assert refused(side, [[-2, 1]], Fraction(1), Fraction(3))
    assert refused(side, [[0, 0]], *one)
    assert side([[-2, 1]], Fraction(1), Fraction(2), (True, True)) == -1
    assert slices.point(None, -1) == (-1, 0)
    assert slices.point("-3/6", 1) == (-1, 2)
    ordered = [(-1, 0), (-3, 1), (-1, 2), (0, 1), (2, 3), (5, 1), (1, 0)]
    for i, x in enumerate(ordered):
        for k, y in enumerate(ordered):
            assert slices.is_less(x, y) == (i < k) or (x[1] == y[1] == 0)


def side(rows: list[list[int]], a: Fraction, b: Fraction, closed: tuple[bool, bool] = (False, False)) -> int:
    """Of a factor with these slices."""
    found = object.__new__(slices.Slices)
    found.step, found.rows, found.waves = 1, rows, []
    return found.side(a, b, closed)


@pytest.mark.parametrize("closed", [(True, False), (False, True), (False, False), (True, True)])
def test_an_end_belongs_to_a_slab_where_the_slice_there_is_not_zero(closed: tuple[bool, bool]) -> None:
    """At a point, or everywhere in a cell: a zero at the end of a cell alone is none inside."""
    at, there, zero = Fraction(1), [3, 1], [0, 0]
    vanishing = [-1, 1]  # at 1 alone
    for low, high in ((vanishing, there), (there, vanishing)):
        assert side([low, high], at, Fraction(2), closed) == 1
    for first, last, kept in (
        ([vanishing, there], at, not closed[0]),
        ([there, vanishing], at, not closed[1]),
        ([zero, there], Fraction(2), not closed[0]),
        ([there, zero, zero], Fraction(2), not closed[1]),
        ([there, zero, there], Fraction(2), True),
    ):
        assert refused(side, first, at, last, closed) is not kept
    assert refused(side, [zero, vanishing], at, at, closed)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_the_slices_of_a_factor_with_waves_have_the_sign_of_all_its_values(seed: int) -> None:
    """Against its values in mpmath at values and frequencies between, ends of the slab and omega = 0 among them."""
    draw, told = random.Random(seed), 0
    for _ in range(60):
        delays = tuple(Fraction(n, 7) for n in draw.sample(range(1, 9), draw.randint(0, 2)))
        orders = tuple(Fraction(n, 10) for n in draw.sample(range(1, 10), draw.randint(0 if delays else 1, 1)))
        factor, value = wave_factor(draw, delays, orders, constant=draw.choice([0, 30, -30]))
        first = draw.choice([None, Fraction(draw.randint(-4, 4), 2)])
        last = None if first is not None and draw.random() < 0.3 else (first or 0) + Fraction(draw.randint(1, 8), 8)
        a = draw.choice([Fraction(0), Fraction(draw.randint(1, 20), 10)])
        b = a + draw.choice([0, Fraction(1, 50), Fraction(1, 2)])
        closed = draw.random() < 0.5 and first is not None, draw.random() < 0.5 and last is not None
        low, high = (
            (-1, 0) if first is None else first.as_integer_ratio(),
            (1, 0) if last is None else last.as_integer_ratio(),
        )
        try:
            found = slices.Slices(factor, low, high).side(a, b, closed)
        except RefusedError:
            continue
        told += 1
        start = first if first is not None else (last or 0) - 50
        end = last if last is not None else start + 50
        for u in range(0 if closed[0] else 1, 6 if closed[1] else 5):
            for v in range(1, 4):
                q, omega = start + (end - start) * Fraction(u, 5), a + (b - a) * Fraction(v, 4)
                assert (
                    found * value(MP.mpf(omega.numerator) / omega.denominator, MP.mpf(q.numerator) / q.denominator) > 0
                )
    assert told > 8


def slab(low: str | None, high: str | None, points: list[str], part: str | None = None) -> dict[str, Any]:
    return {"from": low, "to": high, "points": points, "part": part}


def test_values_of_a_requirement_follow_from_their_slabs() -> None:
    """excess = (omega^2 - 3 + p) p, of p in place of pi: on the band from 0 to 1 positive where p > 3, or p < 0 and omega^2 < 3 - p; and omega - 9."""
    factors = [Factor([[-3, 1], [1]], 2), Factor([[0, 1]]), Factor([[-9], [1]])]
    scene: Any = band(0, 1)
    real = Product({"number": "1", "powers": [[0, 1], [1, 1]]}, factors)
    imag = Product({"number": "2", "powers": [[2, 1]]}, factors)
    told = {"excess.real": real, "excess.imag": imag}

    def found(*slabs: dict[str, Any], told: dict[str, Product] = told) -> Any:
        return requirement.values(told, factors, list(slabs), scene)

    below, good, above = slab(None, "0", ["1/2"], "real"), slab("0", "2", ["0", "1"]), slab("3", None, ["1/2"], "real")
    assert found(below, good, above) == [[[None, "0", False], ["0", "2", True], ["3", None, False]], ["real", "real"]]
    assert found(below) == [[[None, "0", False]], []]
    halves = slab("0", "1", ["0", "1"]), slab("1", "2", ["0", "1/2", "1"])
    assert found(*halves) == [[["0", "2", True]], []]
    high = slab("3", "4", ["1/2"], "real"), slab("4", None, ["3/4"], "real")
    assert found(*high) == [[["3", None, False]], []]
    assert found(good, *high)[1] == ["real"]
    for wrong in (
        [above, good], [good, good], [slab("0", "1", ["0", "1"]), slab("3/2", "2", ["0", "1"])], [slab("2", "0", ["0", "1"])],
        [slab("0", "0", ["0", "1"])], [slab("0", "2", ["0", "1/2"])], [slab("0", "2", ["1/2", "1"])], [slab("0", "2", ["-1", "1"])],
        [slab("3", None, ["2"], "real")], [slab("3", None, ["1/2", "3/4"], "real")], [slab("3", None, ["1/2"], "imag")], [slab("1", "4", ["0", "1"])],
        [slab("0", "2", ["1/2"], "real")], [slab("3", None, ["0", "1"])], [slab("-1", "2", ["0", "1"])],
        [slab("0", "2", ["0", "1"]), slab(None, "3", ["0", "1"])], [slab("2", "3", ["0", "1"]), slab("3", "5", ["0"], "real"), slab("4", None, ["1/2"], "real")],
    ):  # fmt: skip
        assert refused(found, *wrong), wrong
    assert refused(found, slab("3", None, ["1/2"], "imag"), told={"excess.real": real})
    nothing = {"excess.real": Product({"number": "0", "powers": []}, factors)}  # it does not exceed its threshold
    assert found(slab("0", "2", ["0", "1"]), told=nothing) == [[["0", "2", True]], []]
    assert refused(found, slab("0", "2", ["1/2"], "real"), told=nothing)
    assert refused(found, slab("0", "2", ["0", "2"]))
    assert found(slab("3", "4", ["0"], "real"))[0] == [["3", "4", False]]  # p (p - 3) > 0 inside alone
    assert refused(found, slab("3", "7/2", ["0"], "real"), slab("7/2", "4", ["0"], "real")) is False
    assert refused(found, slab("2", "3", ["0"], "real"))
    square = {"excess.real": Product({"number": "1", "powers": [[0, 2], [1, 1]]}, factors)}
    assert found(
        slab("3", "4", ["0", "1"], None),
        told={"excess.real": Product({"number": "-1", "powers": [[0, 1], [1, 1]]}, factors)},
    )
    assert refused(found, slab("1", "4", ["0"], "real"), told=square)
    over = {"excess.real": Product({"number": "-1", "powers": [[0, -1]]}, factors)}
    assert refused(found, slab("3", "4", ["0", "1"]), told=over) is False
    assert refused(found, slab("3", "4", ["0", "1"]), slab("4", "5", ["0", "1"]), told=over) is False
    assert refused(found, slab("2", "3", ["0"], "real"), slab("3", "4", ["0"], "real"), told=over)


def test_where_two_slabs_join_an_excess_may_vanish_but_has_no_pole_and_a_part_exceeds_there_too() -> None:
    """-(p - 1)^2 and -1/(p - 1)^2, of p in place of pi, at the end p = 1 of two slabs; 1/(p - 4)^2 and its root below 4."""
    factors, scene = [Factor([[-1, 1]]), Factor([[-4, 1]])], band(0, 1)
    cells = slab("0", "1", ["0", "1"]), slab("1", "2", ["0", "1/2", "1"])
    points = slab("0", "1", ["1/2"], "real"), slab("1", "2", ["3/4"], "real")

    def accepted(slabs: Any, number: int, *powers: tuple[int, int]) -> bool:
        told = {"excess.real": Product({"number": f"{number}/3", "powers": [list(x) for x in powers]}, factors)}
        return not refused(requirement.values, told, factors, list(slabs), scene)

    for slabs, number in ((cells, -1), (points, 1)):
        for n, joined in ((2, number < 0), (-2, False)):
            assert accepted(slabs, number, (0, n)) is joined
            assert all(accepted([one], number, (0, n)) for one in slabs)
            assert not any(accepted(x, -number, (0, n)) for x in (slabs, slabs[:1], slabs[1:]))
        for n, fits in ((1, -1), (3, -1), (-1, -1), (2, 1), (-2, 1), (4, 1)):
            assert accepted(slabs, fits * number, (1, n))
            assert not accepted(slabs, -fits * number, (1, n))


# Sines, cosines and powers


def wave_factor(
    draw: random.Random, delays: tuple[Fraction, ...], orders: tuple[Fraction, ...], constant: int = 0
) -> tuple[waves.WaveFactor, Any]:
    """A random one, and its value in mpmath, with pi unless a value takes its place; ``constant`` is added to one term."""
    most = [draw.randint(0, 2) for _ in delays]
    rows: dict[tuple[int, ...], list[list[int]]] = {}
    for _ in range(draw.randint(1, 4)):
        turns = tuple(draw.randint(0, k) for k in most) + tuple(draw.randint(0, 2) for _ in range(2 * len(orders)))
        p = [[draw.randint(-9, 9) for _ in range(draw.randint(1, 2))] for _ in range(draw.randint(1, 3))]
        p[-1][-1] = draw.choice([-3, 2])
        p[0][0] += 0 if rows else constant
        rows[turns] = p
    told = {"waves": most, "terms": [[list(k), [[str(c) for c in row] for row in p]] for k, p in rows.items()]}

    def value(w: Any, q: Any = MP.pi) -> Any:
        total = MP.mpf(0)
        for turns, p in rows.items():
            term = MP.fsum(MP.fsum(c * q**k for k, c in enumerate(row)) * w**n for n, row in enumerate(p))
            for tau, k, m in zip(delays, turns, most, strict=False):
                angle = w * tau.numerator / tau.denominator / 2
                term *= MP.sin(angle) ** k * MP.cos(angle) ** (m - k)
            for i, alpha in enumerate(orders):
                exponent = MP.mpf(alpha.numerator) / alpha.denominator
                k, m = turns[len(delays) + 2 * i :][:2]
                term *= (w**exponent * MP.cos(MP.pi * exponent / 2)) ** k * (
                    w**exponent * MP.sin(MP.pi * exponent / 2)
                ) ** m
            total += term
        return total

    return waves.WaveFactor(told, delays, orders), value


@pytest.mark.few(3)
@pytest.mark.parametrize("seed", SEEDS)
def test_taylors_sums_of_wave_factors_hold_their_values(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(3):
        delays = tuple(Fraction(n, 7) for n in draw.sample(range(1, 9), draw.randint(0, 2)))
        orders = tuple(Fraction(n, 10) for n in draw.sample(range(1, 10), draw.randint(0 if delays else 1, 1)))
        factor, value = wave_factor(draw, delays, orders)
        a = Fraction(draw.randint(8, 30), 4)
        b = a + Fraction(1, draw.choice([4, 8, 30]))
        row, lost = factor.model(factor.all, a, b)
        assert len(row) == ORDER
        for n in (-6, -1, 0, 5, 6):
            v, w = MP.mpf(n) / 6, (a + b) / 2 + (b - a) * Fraction(n, 12)
            at, half = MP.mpf(w.numerator) / w.denominator, MP.mpf((b - a).numerator) / (b - a).denominator / 2
            true, slope, most = value(at), MP.diff(value, at) * half, MP.mpf(lost) / SCALE
            assert abs(MP.fsum(c * v**i for i, c in enumerate(row)) / SCALE - true) <= most < 1e-6 * (1 + abs(true))
            assert (
                abs(MP.fsum(i * c * v ** (i - 1) for i, c in enumerate(row) if i) / SCALE - slope)
                <= ORDER * most + 1e-40
            )
        true = value(MP.mpf(a.numerator) / a.denominator)
        if abs(true) > 1e-9:
            assert factor.sign(a) == sign(true)
        every = [value(MP.mpf(w.numerator) / w.denominator) for w in (a + (b - a) * n / 12 for n in range(13))]
        try:
            order, found = factor.signs(a, b)
        except RefusedError:
            continue
        assert order == 0
        assert found == ([sign(every[0])] if len(found) == 1 else [sign(every[0]), sign(every[-1])])
        assert len(found) == 2 or len({sign(x) for x in every}) == 1


@pytest.mark.few(5)
@pytest.mark.parametrize("seed", SEEDS)
def test_wave_factors_begin_at_0_with_the_power_that_mpmath_sees(seed: int) -> None:
    draw = random.Random(seed)
    for cancels in (False, True, False, True):
        delays = tuple(Fraction(n, 7) for n in draw.sample(range(1, 9), draw.randint(1, 2)))
        orders = tuple(Fraction(n, 10) for n in draw.sample(range(1, 10), draw.randint(0, 1)))
        factor, value = beginning(draw, delays[0]) if cancels else wave_factor(draw, delays, orders)
        order, found = factor.signs(Fraction(0), Fraction(1, 10**6))
        tiny = MP.mpf(10) ** -40, MP.mpf(10) ** -42
        slope = (MP.log(abs(value(tiny[0]))) - MP.log(abs(value(tiny[1])))) / MP.log(100)
        assert abs(slope - MP.mpf(Fraction(order).numerator) / Fraction(order).denominator) < 1e-3
        assert found == [sign(value(tiny[1]))]
        try:
            assert factor.signs(Fraction(0), Fraction(1, 20)) == (order, found)
        except RefusedError:
            continue
        assert all(sign(value(MP.mpf(n) / 200)) == found[0] for n in range(1, 11))


def beginning(draw: random.Random, tau: Fraction) -> tuple[waves.WaveFactor, Any]:
    """pi (sin x - x cos x) + c omega^n cos x, x = omega tau/2: it begins with x^3 or with omega^n."""
    c, n, (p, q) = draw.choice([-2, 3]), draw.choice([2, 3, 5]), tau.as_integer_ratio()
    cosine = [["0"], ["0", str(-p)], *([["0"]] * (n - 2)), [str(c)]]
    told = {"waves": [1], "terms": [[[1], [["0", str(2 * q)]]], [[0], cosine]]}

    def value(w: Any) -> Any:
        x = w * p / (2 * q)
        return 2 * q * MP.pi * (MP.sin(x) - x * MP.cos(x)) + c * w**n * MP.cos(x)

    return waves.WaveFactor(told, (tau,)), value


@pytest.mark.few(4)
@pytest.mark.parametrize("seed", SEEDS)
def test_signs_are_told_where_cells_are_small(seed: int) -> None:
    """One where nothing happens, two around a simple zero, none where there may be more."""
    draw = random.Random(seed)
    for delays, orders in (((Fraction(3, 7),), ()), ((Fraction(1, 2), Fraction(2, 3)), ()), ((), (Fraction(1, 3),))):
        factor, value = wave_factor(draw, delays, orders)
        for n in draw.sample(range(16, 70), 3):
            a, b = MP.mpf(n) / 16, MP.mpf(n + 1) / 16
            ends, slopes = (value(a), value(b)), (MP.diff(value, a), MP.diff(value, b))
            steady = slopes[0] * slopes[1] > 0 and abs(slopes[0]) < 1.5 * abs(slopes[1]) < 3 * abs(slopes[0])
            if steady and abs(ends[0] - ends[1]) > 1e-9:
                own = [sign(x) for x in ends]
                fewer = own[:1] if own[0] == own[1] else own
                assert factor.signs(Fraction(n, 16), Fraction(n + 1, 16)) in ((0, fewer), (0, own))


def test_cells_that_hold_more_than_one_zero_of_a_wave_are_refused() -> None:
    one = (Fraction(2),)
    cosine = lambda *p: waves.WaveFactor({"waves": [1], "terms": [[[0], [[str(c)] for c in p]]]}, one)  # noqa: E731
    sine = waves.WaveFactor({"waves": [1], "terms": [[[1], [["1"]]]]}, one)  # sin omega
    assert sine.signs(Fraction(3), Fraction(33, 10)) == (0, [1, -1])
    assert sine.signs(Fraction(4), Fraction(5)) == (0, [-1])
    assert refused(sine.signs, Fraction(3), Fraction(19, 2))
    assert refused(sine.signs, Fraction(0), Fraction(7, 2))
    assert sine.signs(Fraction(0), Fraction(1)) == (1, [1])
    assert refused(cosine(2525, -1005, 100).signs, Fraction(49, 10), Fraction(51, 10))  # 100 (omega - 5) (omega - 5.05)
    assert refused(cosine(25, -10, 1).signs, Fraction(49, 10), Fraction(51, 10))
    assert cosine(-5, 1).signs(Fraction(49, 10), Fraction(51, 10)) == (0, [-1, 1])
    assert refused(cosine(-1, 100).signs, Fraction(0), Fraction(1, 50))
    assert cosine(-1, 50).signs(Fraction(0), Fraction(1, 100)) == (0, [-1])
    raised = waves.WaveFactor({"waves": [], "terms": [[[1, 0], [["1"]]], [[0, 0], [["-1"]]]]}, (), (Fraction(1, 2),))
    assert refused(raised.signs, Fraction(0), Fraction(4))  # sqrt(omega/2) - 1
    assert raised.signs(Fraction(0), Fraction(1)) == (0, [-1])
    assert raised.signs(Fraction(19, 10), Fraction(21, 10)) == (0, [-1, 1])


def test_beginnings_that_stay_open_are_refused_and_sides_are_bernsteins() -> None:
    assert (waves.strict(5, 4), waves.strict(-5, 4)) == (1, -1)
    assert refused(waves.strict, 5, 5)
    assert refused(waves.strict, -5, 5)
    assert waves.side([5, 0], 4) == waves.side([9, 4], 4) == waves.side([1], 0) == 1
    assert waves.side([-5, 0], 4) == waves.side([-9, 4], 4) == -1
    assert waves.side([8, 4], 4) == waves.side([8, -4], 4) == waves.side([-8, 4], 4) == waves.side([1], 1) == 0
    assert waves.side([2, 0, -1], 0) == waves.side([5, 0, 2], 2) == 1
    assert waves.side([5, 0, 2], 3) == 0  # 7, 6, 7 for 1, 2, 1
    assert waves.side([0, 0, 1], 0) == waves.side([1, 0, -1], 0) == waves.side([1, 0, 2], 0) == 0
    for row in ([3, 1, -1, 0, 1], [7, -2, 3, 1, 0, -2]):
        n = len(row) - 1
        every = [sum(c * x[k] for k, c in enumerate(row)) for x in waves.bernstein(n + 1)]
        for u in range(5):  # v = (u - 1)/(u + 1)
            told = sum(c * u**i for i, c in enumerate(every))
            assert told == sum(c * (u - 1) ** k * (u + 1) ** (n - k) for k, c in enumerate(row))


def test_what_a_model_is_off_by_is_bounded_where_hardly_anything_is_given_away() -> None:
    """A cosine from 0 on, whose sizes are those at 0 and not at the end; a power at the low end of its cell."""
    tau, alpha = Fraction(1), Fraction(1, 2)
    cosine = waves.WaveFactor({"waves": [1], "terms": [[[0], [["1"]]]]}, (tau,))
    power = waves.WaveFactor({"waves": [], "terms": [[[1, 0], [["1"]]]]}, (), (alpha,))
    for factor, a, b, v, true in (
        (cosine, Fraction(0), Fraction(3), 1, MP.cos(MP.mpf(3) / 2)),
        (power, Fraction(1), Fraction(3, 2), -1, MP.cos(MP.pi / 4)),
    ):
        row, lost = factor.model(factor.all, a, b)
        off = abs(sum(c * v**n for n, c in enumerate(row)) - true * SCALE)
        assert off <= lost < 100 * off


def test_what_models_leave_open_refuses_a_cell(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a derivative N times as much as of the function, and from 0 on the sum of all groups; c_N stands in its place."""
    factor = waves.WaveFactor({"waves": [], "terms": [[[1, 0], [["-1"]]], [[0, 0], [["-1"]]]]}, (), (Fraction(1, 2),))
    for lost, fits in ((1, True), (2, False)):
        monkeypatch.setattr(factor, "model", lambda *_, lost=lost: ([0, 2 * ORDER, *[0] * (ORDER - 2)], lost))
        assert refused(factor.signs, Fraction(1), Fraction(2)) != fits
    for each, fits in (((2, 2), True), ((4, 2), False), ((2, 4), False)):
        told = iter(each)
        monkeypatch.setattr(factor, "model", lambda *_, told=told: ([-5, *[0] * (ORDER - 1)], next(told)))
        assert refused(factor.signs, Fraction(0), Fraction(1)) != fits
    late = [[[0, 30, 0], [["1000000"]]]]  # omega^15 cos^14, and sin^14 before it
    for terms, fits in ((late, True), ([*late, [[14, 0, 0], [["1"]]]], False)):
        factor = waves.WaveFactor({"waves": [14], "terms": terms}, (Fraction(1, 10),), (Fraction(1, 2),))
        assert refused(factor.signs, Fraction(0), Fraction(1)) != fits


def test_wave_factors_are_measured_and_read() -> None:
    delays, orders = (Fraction(1, 3),), (Fraction(1, 2),)
    term = [[1, 0, 2], [["1", "2"], ["-3"]]]
    told = {"waves": [1], "terms": [term, [[0, 0, 0], [["8"]]]]}
    factor = waves.WaveFactor(told, delays, orders)
    assert factor.degrees == (1, 1, 1, 2, 0, 0)
    assert factor.powers
    sizes = (2 + 2 + 40) + (2 + 1 + 40) + (4 + 1 + 40)
    assert factor.cost == (sizes + 500 * 2 * (1 + 3)) * 2
    assert not waves.WaveFactor({"waves": [1], "terms": [[[1], [["1"]]]]}, delays).powers
    wrong = [{"waves": [41], "terms": [term]}, {"waves": [1], "terms": [term, term]}, {"waves": [0], "terms": [term]}, {"waves": [1], "terms": []},
             {"waves": [], "terms": [term]}, {"waves": [1], "terms": [[[1, 0], [["1"]]]]}, {"waves": [1], "terms": [[[1, 0, 41], [["1"]]]]},
             {"waves": [1], "terms": [[[1, 0, -1], [["1"]]]]}]  # fmt: skip
    assert all(refused(waves.WaveFactor, x, delays, orders) for x in wrong)
    assert not refused(waves.WaveFactor, {"waves": [40], "terms": [[[40, 0, 40], [["1"]]]]}, delays, orders)
    plain = waves.factor_of({"step": 2, "polynomial": [["1"], ["1"]]}, delays, orders)
    assert (plain.step, plain.waves, plain.terms) == (2, (0,), [((0, 0, 0), [[1], [1]])])
    assert refused(waves.factor_of, {"step": 3, "polynomial": [["1"]]}, delays, orders)
    assert isinstance(waves.factor_of(told, delays, orders), waves.WaveFactor)


# What links a proof to its scene


def test_products_are_measured_and_read() -> None:
    factors = [Factor([[1], [1]]), Factor([[2], [1]])]
    found = Product({"number": "-3/2", "powers": [[1, -2], [0, 3]]}, factors)
    assert (found.number, found.powers, found.circles) == (Fraction(-3, 2), {1: -2, 0: 3}, [])
    assert found.size == 5 * factors[0].size
    top, bottom = found.at([Value(5), Value(7)], [])
    assert (top.re, bottom.re) == (-3 * 125, 2 * 49)
    for powers in ([[0, 1], [0, 2]], [[2, 1]], [[-1, 1]], [[0, 101]], [[0, -101]], [[0]], [[0, 1, 1]]):
        assert refused(Product, {"number": "1", "powers": powers}, factors)
    assert refused(Product, {"number": "0", "powers": [[0, 1]]}, factors)
    assert not refused(Product, {"number": "1", "powers": [[0, 100], [1, -100]]}, factors)
    turned = [waves.WaveFactor({"waves": [n], "terms": [[[0], [["1"]]]]}, (Fraction(1),)) for n in (1, 2)]
    assert refused(Product, {"number": "1", "powers": [[0, 1]]}, turned)
    found = Product({"number": "1", "powers": [[0, 2], [1, -3]]}, turned)
    assert found.circles == [2]
    assert Product({"number": "1", "powers": [[1, 1]]}, turned).circles == [-1]
    top, bottom = found.at([Value(5), Value(7)], [Value(10)])
    assert (top.re, bottom.re) == (25 * 100, 343)


@pytest.mark.few(10)
@pytest.mark.parametrize("seed", SEEDS)
def test_the_ten_functions_are_those_of_two_dynamics(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(20):
        h, g = (
            (Value(draw.randint(-9, 9), draw.randint(1, 9)), Value(draw.randint(-9, 9), draw.randint(1, 9)))
            for _ in range(2)
        )
        limits = {
            "real": own_number(Fraction(draw.randint(1, 9), 10), draw.randint(-1, 1)),
            "imag": own_number(Fraction(draw.randint(1, 9), 7)),
        }
        scene: Any = SimpleNamespace(at=lambda point, h=h, g=g: (h, g), threshold=limits)
        found = link.functions(scene, (), (), Value(3), 5)
        H, G = (MP.mpc(x[0].re, x[0].im) / MP.mpc(x[1].re, x[1].im) for x in (h, g))
        for name, value in {"environment": H, "perceived": G, "difference": G - H, "sum": G + H}.items():
            for part, true in (("real", value.real), ("imag", value.imag)):
                top, bottom = found[f"{name}.{part}"]
                assert abs(MP.mpf(top.re) / bottom.re - true) < 1e-60 * (1 + abs(true))
                assert top.im == bottom.im == 0
        for part, value in (("real", (G - H).real), ("imag", (G - H).imag)):
            top, bottom = found[f"excess.{part}"]
            limit = MP.mpf(limits[part].value.numerator) / limits[part].value.denominator * MP.mpf(5) ** limits[part].pi
            assert abs(MP.mpf(top.re) / bottom.re - (value**2 / abs(H) ** 2 - limit**2)) < 1e-60


def test_a_function_that_differs_anywhere_is_not_that_of_the_scene() -> None:
    """omega^2 + pi and polynomials that have its value at many places, not at all."""
    good = Factor([[0, 1], [0], [1]])
    square = lambda x, pi, *_: {"it": (x.times(x).plus(Value(pi, 0, degree(1))), ONE)}  # noqa: E731
    own = {"it": {"number": "1", "powers": [[0, 1]]}}
    assert link.link(own, ["it"], [good], square, 5)["it"].number == 1
    assert refused(link.link, {"it": {"number": "2", "powers": [[0, 1]]}}, ["it"], [good], square, 5)
    for rows in ([[0, 1], [1], [1]], [[1, 1], [0], [1]], [[0, 1], [0, 1], [1]], [[0, 0, 1], [0], [1]], [[3], [0], [1]]):
        assert refused(link.link, own, ["it"], [Factor(rows)], square, 5)
    for roots in range(4):
        away = expanded([(-n, 1) for n in range(roots)])  # zero at the first places of a grid
        rows = [
            [(good.rows[n][0] if n < 3 else 0) + (away[n][0] if n < len(away) else 0), int(n == 0)]
            for n in range(max(3, len(away)))
        ]
        assert refused(link.link, own, ["it"], [Factor(rows)], square, 5)
    for n in range(
        2, 6
    ):  # x (x - 1) ... over one denominator, and over one that differs nowhere on a grid but at zeros above
        above = Factor(expanded([(-k, 1) for k in range(n)]))
        below, wrong = expanded([(5, 1)]), expanded([(-k, 1) for k in range(n, 2 * n)])
        rows = [[(below[i][0] if i < 2 else 0) + x] for i, (x,) in enumerate(wrong)]
        ratio = lambda x, *_, n=n: {  # noqa: E731
            "it": (reduce(Value.times, [x.plus(Value(-k)) for k in range(n)]), x.plus(Value(5)))
        }
        quotient = {"it": {"number": "1", "powers": [[0, 1], [1, -1]]}}
        assert not refused(link.link, quotient, ["it"], [above, Factor(below)], ratio, 5)
        for more in (1, -1):
            other = Factor([[more * c if i > 1 else c] for i, (c,) in enumerate(rows)])
            assert refused(link.link, quotient, ["it"], [above, other], ratio, 5)
    twice = {"it": {"number": "1", "powers": [[0, 1], [1, 1], [2, -1]]}}
    half = [good, Factor([[7], [1]]), Factor([[7], [1]])]
    assert link.link(twice, ["it"], half, square, 5)["it"].powers == {0: 1, 1: 1, 2: -1}
    with pytest.raises(RefusedError, match="too high"):
        link.link(own, ["it"], [good], square, 10**7)
    with pytest.raises(RefusedError, match="nowhere defined"):
        link.link(own, ["it"], [good], lambda x, *_: {"it": (x, Value(0))}, 5)


@pytest.mark.few(5)
@pytest.mark.parametrize("seed", SEEDS)
def test_functions_with_tangents_and_powers_are_told_from_others(seed: int) -> None:
    """A sum of tangents and of Re and Im of powers, with one coefficient wrong or none."""
    draw = random.Random(seed)
    delays, orders = (Fraction(1, 3),), (Fraction(1, 2),)
    rows = {
        (k, n, m): draw.randint(1, 9) for k in range(3) for n in range(3) for m in range(3 - n) if draw.random() < 0.5
    }
    rows[2, 0, 1] = 3

    def scene(x: Value, pi: int, *others: Any) -> dict[str, Ratio]:
        t, (re, im) = others
        total = Value(0)
        for (k, n, m), c in rows.items():
            total = total.plus(Value(c * t**k * re**n * im**m, 0, (0, 0, k, n + m, 0, 0)))
        return {"it": (total, Value(1 + t * t, 0, degree(2, 2)))}

    def accepted(own: dict[tuple[int, int, int], int]) -> bool:
        told = {"waves": [2], "terms": [[list(key), [[str(c)]]] for key, c in own.items() if c]}
        factor = waves.WaveFactor(told, delays, orders)
        return not refused(link.link, {"it": {"number": "1", "powers": [[0, 1]]}}, ["it"], [factor], scene, 5, (1, 1))

    assert accepted(rows)
    for key in [(k, n, m) for k in range(3) for n in range(3) for m in range(3 - n)]:
        assert not accepted(rows | {key: rows.get(key, 0) + draw.choice([-1, 1])})
