"""Values of one parameter told by cells, of scenes with delays, holds and powers of s: against dense samples and closed forms."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from itertools import count, pairwise
from random import Random
from typing import Any

import mpmath
import numpy as np
import pytest
from sympy import Expr, Integer, Poly, Rational, Symbol, discriminant, lambdify, pi, real_roots, resultant

import haptisym as hs
from haptisym.judge.bindings import Kind
from haptisym.judge.crossings import noticed
from haptisym.kernel.budget import timed_by
from haptisym.kernel.dynamics import RealFunction, Ring
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import ExactNumber, Sliver, expression_ball
from haptisym.kernel.rings import omega as w
from haptisym.kernel.sets import Bisected, SingleValue, Stretch, ValueSet
from haptisym.verbs.require import solving
from haptisym.verbs.require.floatcells import FloatCells
from haptisym.verbs.require.freeparameter import allowed, critical, edge_polynomial, missing, touch_polynomial
from haptisym.verbs.require.freeparameter import real_roots as roots_in_parameter

E, F = hs.environments, hs.effects
REAL, IMAG = noticed(hs.Threshold())
q = Symbol("q", positive=True)


def ends(r: Any) -> list[tuple[float | None, float | None]]:
    return [tuple(None if e is None else float(e) for e in (x.low, x.high)) for x in r.feasible]  # type: ignore[misc]


def holds(r: Any, x: float) -> bool:
    return any((a is None or a <= x) and (b is None or x <= b) for a, b in ends(r))


# --- answers about scenes, against samples of both dynamics ---------------------------------------------------------------


@dataclass(frozen=True)
class Case:
    """A scene, what is free in it and from where to where; what is felt, and what should be, at s and a value; the excess."""

    scene: hs.Scene
    free: str
    span: tuple[Any, Any] | None
    felt: Callable[[Any, float], Any]
    excess: Callable[[Any, Any], Any]

    def most(self, value: float) -> tuple[float, float]:
        """The largest excess over the band, and where."""
        low, high = map(float, self.scene.band)
        omega = np.linspace(low, high, 1501)[0 if low else 1 :]
        found = self.excess(self.felt(1j * omega, value), omega)
        return float(found.max()), float(omega[found.argmax()])


@cache
def drawn(kind: str, seed: int) -> Case:
    """One of which some values keep the condition and others do not."""
    pick = Random(f"{kind} {seed}")
    while True:
        found = some(pick, kind)
        low, high = (0.0001, 0.2) if found.span is None else map(float, found.span)
        if {found.most(float(x))[0] < 0 for x in np.linspace(low, high, 20)} == {True, False}:
            return found


def some(pick: Random, kind: str) -> Case:
    """A wall behind a filter and a delay, a hold, or of a tissue with a power of s; a number of it, a region, or a gain is free."""
    k, b, c = pick.uniform(50, 200), pick.uniform(0.5, 9), pick.uniform(0.08, 0.3)
    corner, late, alpha = pick.uniform(15, 90), pick.uniform(0.001, 0.008), pick.uniform(0.3, 0.8)
    k, b, c, corner, late, alpha = (float(f"{x:.3g}") for x in (k, b, c, corner, late, alpha))
    low, high = pick.choice([0, 1]), pick.choice([8, 14])
    damped = pick.choice([0.3, 0.6, 1.0])

    def behind(z: Any, *, tau: float = late, w_n: float = corner, zeta: float = damped) -> Any:
        return np.exp(-z * tau) / (1 + 2 * zeta * z / w_n + (z / w_n) ** 2)

    def parts(ratio: Any, _: Any) -> Any:
        return np.maximum(abs(ratio.real), abs(ratio.imag)) - c

    def relative(H: Any, G: Any) -> Any:
        return H * (G - 1) / abs(H)

    wall, chain = E.kelvin_voigt(k, b), (F.second_order_lowpass(corner, damped), F.delay(late))
    jnd: Any = c
    excess: Any = parts
    free, span, felt = "omega_n", (5, 300), lambda z, x: relative(k + b * z, behind(z, w_n=x))
    if kind == "filter":
        free, span, felt = "zeta", ("0.05", 3), lambda z, x: relative(k + b * z, behind(z, zeta=x))
    elif kind == "delay":
        free, span, felt = "tau", None, lambda z, x: relative(k + b * z, behind(z, tau=x))
    elif kind == "stiffness":
        free, span, felt = "environment.k", (0.01, 30 * k), lambda z, x: relative(x + b * z, behind(z))
    elif kind == "damping":
        free, span, felt = "environment.b", (0, 30), lambda z, x: relative(k + x * z, behind(z))
    elif kind == "mass":
        wall = E.mass_spring_damper("1/2", b, k)
        free, span, felt = "environment.m", (0, 9), lambda z, x: relative(k + b * z + x * z * z, behind(z))
    elif kind == "hold":
        chain = (F.zero_order_hold(late),)
        free, span = "T", (0.0001, 0.2)
        felt = lambda z, x: relative(k + b * z, (1 - np.exp(-z * x)) / (z * x))  # noqa: E731
    elif kind == "power":
        wall, chain = E.spring_pot(b, alpha, k=k), chain[:1]
        felt = lambda z, x: relative(k + b * z**alpha, behind(z, tau=0, w_n=x))  # noqa: E731
    elif kind == "order":
        wall, chain, low = E.spring_pot(k / 5, alpha, k=k), (F.first_order_lag(5 * corner),), 1
        free, span = "alpha", ("0.1", "0.9")
        felt = lambda z, x: relative(k + k / 5 * z**x, 1 / (1 + z / (5 * corner)))  # noqa: E731
    elif kind == "ellipse":
        jnd = {"shape": "ellipse", "real": c, "imag": 2 * c}
        excess = lambda r, _: (r.real / c) ** 2 + (r.imag / (2 * c)) ** 2 - 1  # noqa: E731
    elif kind == "polygon":
        jnd = {"shape": "polygon", "corners": [[c, 0], [0, 1.5 * c], [-2 * c, 0], [0, -1.5 * c]]}
        excess = lambda r, _: r.real / np.where(r.real > 0, c, -2 * c) + abs(r.imag) / (1.5 * c) - 1  # noqa: E731
    elif kind == "threshold":
        jnd = {"real": c, "imag": f"{c} + omega/90"}
        excess = lambda r, omega: np.maximum(abs(r.real) - c, abs(r.imag) - c - omega / 90)  # noqa: E731
    elif kind == "gain":
        wall, high = E.mass_spring_damper(k=k), 3
        chain = (F.series("1 + t/10 + s^2/50 + t^2*s/9", parameters={"t": "1/10"}), F.delay(late))
        free, span = "t", (-9, 9)
        felt = lambda z, x: (1 + x / 10 + z * z / 50 + x * x * z / 9) * np.exp(-z * late) - 1  # noqa: E731
    return Case(hs.Scene(wall, chain, (low, high), jnd), free, span, felt, excess)


KINDS = (
    "corner", "filter", "delay", "stiffness", "damping", "mass", "hold", "power", "order", "ellipse", "polygon", "threshold", "gain",
)  # fmt: skip


@pytest.mark.few("power-0", "delay-1", "ellipse-0", "gain-1", "hold-2")
@pytest.mark.parametrize(("kind", "seed"), [(kind, n) for kind in KINDS for n in range(1 if kind == "order" else 3)])
def test_a_value_is_in_the_answer_just_where_samples_keep_the_condition(kind: str, seed: int) -> None:
    """With what binds at each end: there the excess is 0, is the largest one, and lies at the frequency and side that is told."""
    case = drawn(kind, seed)
    r = hs.require(case.scene, case.free, case.span)
    open_ = [tuple(None if x is None else float(x) for x in pair) for pair in ((p.low, p.high) for p in r.undecided)]
    low, high = (0.0 if case.span is None else float(case.span[0])), (0.3 if case.span is None else float(case.span[1]))
    checked = 0
    for x in [*np.linspace(low, high, 25), *np.geomspace(max(low, high / 1e4), high, 25)]:
        most, _ = case.most(float(x))
        if not any((a is None or a <= x) and (b is None or x <= b) for a, b in open_):
            checked += 1
            assert abs(most) < 1e-5 or holds(r, x) is (most < 0), (x, most)
    assert checked > 10
    if open_:  # what is proven is right; ends beside what is undecided are none
        return
    for end in r.ends:
        assert end.value is not None
        most, at = case.most(float(end.value))
        assert abs(most) < 1e-4
        for x in end.bindings:
            assert x.omega is not None
            place = float(x.omega)
            assert case.excess(case.felt(1j * np.array([place or 1e-9]), float(end.value)), place)[0] == pytest.approx(
                0, abs=1e-9
            )
            edges = dict(zip((Kind.START, Kind.EDGE), map(float, case.scene.band), strict=True))
            assert place == edges[x.kind] if x.kind in edges else edges[Kind.START] < place < edges[Kind.EDGE]
            assert x.kind is Kind.TOUCH or abs(at - place) < 0.02
    for span in r.feasible:
        for end, closed in zip((span.first, span.last), span.closed, strict=True):
            assert end is None or not end.bindings or closed


@pytest.mark.parametrize(("tau", "count"), [("6.677 ms", 1), ("6.679 ms", 0)])
def test_a_delay_that_is_noticed_whatever_the_stiffness_is_decided_beside_its_threshold(tau: str, count: int) -> None:
    """sin(15 tau) = 1/10 at 6.67781 ms."""
    spring = hs.Scene(E.mass_spring_damper(k=100), (F.delay(tau),), (0, 15))
    found = hs.require(spring, "environment.k", (10, 1000))
    assert (len(found.feasible), found.undecided) == (count, ())


def test_the_longest_delay_before_a_spring_is_known_to_any_digits() -> None:
    """2 sin(W tau/2)^2 <= c and sin(W tau) <= c: asin(c)/W, which binds at the end W of the band."""
    [span] = hs.require(hs.Scene(E.mass_spring_damper(k=100), (F.delay("1 ms"),), (0, 15)), "tau").feasible
    assert span.high is not None
    with mpmath.workdps(45):
        assert span.high.digits(30) == mpmath.nstr(mpmath.asin(mpmath.mpf(1) / 10) / 15, 30)


@pytest.mark.slow
def test_late_by_a_microsecond_a_polygon_is_met_at_the_maximum_next_to_0_and_not_at_0() -> None:
    """x = t - w^2, y = d w beside x + y <= 1/2: largest at w = d/2; sampled densely beside the end that is told."""
    gain = F.series("1 + t + s^2 + d*s", parameters={"t": "1/10", "d": "1/25"})
    region = {"shape": "polygon", "corners": [["1/2", "0"], ["0", "1/2"], ["-300", "0"], ["0", "-1/2"]]}
    scene = hs.Scene(E.mass_spring_damper(k=100), (gain, F.delay("1 us")), (0, 5), region)
    [span] = hs.require(scene, "t", (-9, 9)).feasible
    assert span.high is not None
    grid, end = np.concatenate([np.linspace(0, 0.1, 4001), np.linspace(0.1, 5, 2001)]), float(span.high)
    for t, kept in ((end - 1e-7, True), (end + 1e-7, False)):
        z = (1 + t - grid**2 + 0.04j * grid) * np.exp(-1e-6j * grid) - 1
        assert (np.max(z.real + np.abs(z.imag)) <= 0.5) is np.bool_(kept)
    [binding] = span.last.bindings
    assert binding.kind is Kind.TOUCH
    assert binding.omega is not None
    assert float(binding.omega) == pytest.approx(0.02, rel=1e-3)


# --- floats that tell most values at once ---------------------------------------------------------------------------------


@pytest.mark.few("virtual-wall-environment.b-100.0-ends2")
@pytest.mark.parametrize(
    ("name", "path", "high", "ends"),
    [
        ("four-channel-teleoperation", "environment.b", 1e4, [6.47280, 36.8130]),
        ("four-channel-teleoperation", "effects.teleoperator.tau", 0.05, [0.00576773]),
        ("virtual-wall", "environment.b", 100.0, [14.2773, 35.4501]),
        ("organ-tissue", "effects.communication.tau", 0.05, []),
        ("sampled-wall", "effects.sampling.T", 0.05, []),
    ],
)
def test_floats_tell_all_values_but_those_next_to_an_end(name: str, path: str, high: float, ends: list[float]) -> None:
    """As an exact evaluation at each of them does."""
    scene = hs.load_scene(name)
    free = scene.knobs[path]
    found = FloatCells(scene, free, noticed(scene.threshold), abs(float(free.value))).told(1e-4, high)
    assert (found[0].low, found[-1].high) == (1e-4, high)
    assert all(a.high == b.low for a, b in pairwise(found))
    left = [x for x in found if x.kept is None]
    assert all(x.slant is not None for x in left)
    assert all(any(x.low < end < x.high for x in left) for end in ends)
    assert all(any(x.low <= end <= x.high for end in ends) and x.high < 1.01 * x.low for x in left)
    for x in found:
        if x.kept is not None:
            e = hs.evaluate(free.put(scene, Rational((x.low + x.high) / 2)))
            whole = [(e.chart.points[0], e.chart.points[-1])]
            assert ([(y.low, y.high) for y in e.transparent] == whole) is x.kept


@pytest.mark.parametrize(("power", "bits", "most"), [(1, 400, 60), (2, 400, 60), (3, 60, 70)])
def test_a_value_between_two_is_closed_in_on_by_few_verdicts_where_it_shows_how_far_others_fail(
    power: int, bits: int, most: int
) -> None:
    """sqrt(2), above which q fails, by (q^2 - 2)^power or its root; by halves where neither is linear."""
    asked = list[Rational]()

    def holds(x: Rational) -> bool:
        asked.append(x)
        return bool(x * x <= 2)

    def excess(x: Rational) -> Any:
        return (expression_ball(x) ** 2 - 2) ** power

    low, high = Bisected(holds, Fraction(1), Fraction(3, 2), low_holds=True, excess=excess).between(bits)
    assert low**2 < 2 < high**2
    assert high - low < Fraction(2, 2**bits)
    assert len(asked) < most


QUESTIONS = [
    ("omega_n", hs.Part.IMAG, "122.355814770431"), ("zeta", hs.Part.REAL, "0.445250007278434"), ("environment.m", None, None),
]  # fmt: skip


@pytest.mark.dear("omega_n-Part.IMAG-122.355814770431")
@pytest.mark.parametrize(("path", "part", "end"), QUESTIONS)
def test_without_numpy_balls_tell_the_same(
    path: str, part: Any, end: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As the paper's example is known to need."""
    monkeypatch.setattr(solving, "has_arrays", lambda: False)
    found = hs.require("fu2019", path, part=part)
    assert found.certified
    assert [x.value.digits(15) for x in found.ends if x.value] == ([end] if end else [])


@pytest.mark.dear("False")
@pytest.mark.parametrize("arrays", [True, False])
def test_values_that_the_time_did_not_reach_are_told_as_that(*, arrays: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """Not as values of which bounds tell nothing; the one that the parameter has is asked first."""
    monkeypatch.setattr(solving, "has_arrays", lambda: arrays)
    with timed_by(count().__next__):
        found = hs.require("four-channel-teleoperation", "Ms", limit=400)
    assert found.undecided
    assert all("stopped at the limit" in x.reason for x in found.undecided)
    assert found.values.about(ExactNumber(Integer(2))).verdict == "holds"


def bound(end: Any) -> list[Any]:
    """An end and what binds there, to digits."""
    listed = [(x.criterion.name, x.kind, x.omega.digits(12)) for x in end.bindings]
    return [end.value.digits(15), *listed]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("scene", "path"),
    [
        ("delayed-spring", "tau"),
        ("steering-wheel", "m_w"),
        ("four-channel-teleoperation", "Ks"),
        ("organ-tissue", "environment.alpha"),
    ],
)
def test_without_numpy_balls_tell_what_floats_do(scene: str, path: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of delays and fractional powers, with both ends at tangencies, with every value and with none."""
    by_floats = hs.require(scene, path)
    monkeypatch.setattr(solving, "has_arrays", lambda: False)
    by_balls = hs.require(scene, path)
    assert by_floats.certified
    assert by_balls.certified
    assert [bound(x) for x in by_balls.ends] == [bound(x) for x in by_floats.ends]


# --- polynomials that bound a rational condition --------------------------------------------------------------------------

AXIS = Ring.of([q]).axis
BOUNDED = Integer(2), Rational(7, 2)


def polynomials(functions: list[Expr], band: tuple[Expr, Expr] = BOUNDED) -> list[tuple[Kind | None, Expr]]:
    pieces = [RealFunction(AXIS.convert(x)) for x in functions]
    found = critical(REAL, pieces, band)
    return [(None if reason is None else reason[1], AXIS.expression(p)) for reason, p in found]


def alike(x: Expr, y: Expr) -> bool:
    return bool((x / y).cancel().is_Rational)


@pytest.mark.parametrize(
    ("functions", "value"),
    [
        ([w**2 - q, w**2 - 4], 4), ([w**2 - q, w - 2], 4), ([w - 2, w**2 - q], 4), ([w - q, w - 3], 3),
        ([w**2 - q * w + 1, w**4 - 16], Rational(5, 2)), ([w**4 - q * w**2 + 3, w**2 - 2], Rational(7, 2)),
        ([(w**2 - q) * (w**2 - 4)], 4), ([w**4 - q * w**2 + 1], 2), ([w**2 - q * w + 9], 6), ([w**4 - 6 * w**2 + q], 9),
        ([w**3 - 3 * w + q], 2),
    ],
)  # fmt: skip
def test_a_touch_is_critical_where_zeros_of_one_function_or_of_two_meet(functions: list[Expr], value: Expr) -> None:
    touches = [x for kind, x in polynomials(functions) if kind is Kind.TOUCH]
    assert any(x.subs(q, value) == 0 for x in touches)
    assert not any(x.subs(q, Rational(77, 10)) == 0 for x in touches)
    if len(functions) == 2:
        assert touch_polynomial([RealFunction(AXIS.convert(x)) for x in functions]).subs(q, value) == 0


@pytest.mark.parametrize("seed", range(4))
def test_what_bounds_a_condition_is_what_sympy_eliminates(seed: int) -> None:
    """At both ends of the band, where one touches, where two meet, and where one is not defined; even powers bind nowhere."""
    pick = Random(seed)
    f, g = w**2 * pick.randint(1, 4) + q * w + pick.randint(1, 5), w**3 + pick.randint(1, 4) * w + q
    pieces = [RealFunction(AXIS.convert(x)) for x in (f, g)]
    eliminated = [discriminant(f, w), discriminant(g, w), resultant(f, g, w)]
    found = polynomials([f, g])
    for kind, true in (
        (Kind.START, [x.subs(w, 2) for x in (f, g)]),
        (Kind.EDGE, [x.subs(w, Rational(7, 2)) for x in (f, g)]),
        (Kind.TOUCH, eliminated),
    ):
        own = [x for reason, x in found if reason is kind]
        assert len(own) == len(true)
        assert all(any(alike(x, y) for x in own) for y in true)
    assert alike(touch_polynomial(pieces), eliminated[0] * eliminated[1] * eliminated[2])
    assert alike(edge_polynomial(pieces, Integer(3)), (f * g).subs(w, 3))
    undefined = [x for kind, x in polynomials([f / (w**2 + q) / (q - 3)]) if kind is None]
    assert any(x.has(q) and x.subs(q, 3) == 0 for x in undefined)
    assert not any(x.has(w) for x in undefined)
    assert touch_polynomial([RealFunction(AXIS.convert(f**2))]) == 1
    assert not [x for kind, x in polynomials([f**2]) if kind is Kind.TOUCH]


@pytest.mark.few("1", "4", "7")
@pytest.mark.parametrize("seed", range(10))
def test_a_condition_changes_at_critical_values_alone(seed: int) -> None:
    pick, grid = Random(seed), np.linspace(1, 4, 2001)
    functions: list[Expr] = []
    while len(functions) < pick.choice([1, 1, 2]):
        x = pick.choice([w, w**2])
        f = sum((pick.randint(-4, 4) * x**i * q**k for i in range(3) for k in range(2)), pick.choice([1, -2, 3]) * x**2)
        if f.has(q) and f.has(w):
            functions.append(f if pick.random() < 0.7 else f / (w**2 * q + pick.randint(1, 3)))
    values = [
        float(r)
        for _, p in polynomials(functions, (Integer(1), Integer(4)))
        if p.has(q)
        for r in real_roots(Poly(p, q))
    ]
    compiled = [lambdify((w, q), f, "numpy") for f in functions]

    def broken(t: float) -> bool:
        return bool((np.min([np.broadcast_to(f(grid, t), grid.shape) for f in compiled], 0) > 0).any())

    for low in np.arange(0.1, 6, 0.1):
        a, b = low, low + 0.1
        if broken(a) != broken(b):
            for _ in range(12):
                a, b = ((a + b) / 2, b) if broken((a + b) / 2) == broken(a) else (a, (a + b) / 2)
            assert (abs(np.array(values) - a) < 3e-3 * (1 + a)).any(), (functions, a, values)


@pytest.mark.parametrize(
    ("polynomial", "roots"),
    [
        (3 * q - 7, [7 / 3]), (2 * q + 5, [-2.5]), (pi * w + 3, []), (pi * q - 3 + 2 * pi**2, [3 / np.pi - 2 * np.pi]),
        (q**2 - 5, [-(5**0.5), 5**0.5]), (q**2 - pi, [-(np.pi**0.5), np.pi**0.5]), (q**3 - 2 * pi, [(2 * np.pi) ** (1 / 3)]),
        (q**3 + 2, [-(2 ** (1 / 3))]), (q**2 + q + 5, []), ((pi + 2) * q - 3 * pi**2, [3 * np.pi**2 / (np.pi + 2)]),
    ],
)  # fmt: skip
def test_roots_in_the_parameter_are_told_whatever_powers_of_pi_stand_before_it(
    polynomial: Expr, roots: list[float]
) -> None:
    top, index = AXIS.convert(polynomial).numerator, AXIS.meanings.index(q)
    both = sorted(map(float, roots_in_parameter(top, index, negative=True)))
    assert both == pytest.approx(roots, rel=1e-15)
    positive = [float(x) for x in roots_in_parameter(top, index, negative=False)]
    assert [x for x in positive if x > 0] == pytest.approx([x for x in roots if x > 0], rel=1e-15)


# --- values without a scene, and values that a hand bears -----------------------------------------------------------------


@pytest.mark.parametrize("seed", range(4))
def test_values_that_divide_by_0_or_leave_nothing_to_feel_are_all_missing_and_no_others(seed: int) -> None:
    """(q - a)(q + b)(q^2 - d) before all of the environment, q - c below the line; q + s and q - e before a part are no such."""
    pick = Random(seed)
    a, b, c, e = (Rational(x, pick.choice([1, 2])) for x in pick.sample(range(3, 30, 2), 4))
    d, turn = pick.choice([2, 3, 5]), seed % 2
    whole = f"(q - {a})*(q + {b})*(q^2 - {d})*(s*(q - {e}) + q + 7)/(s + q)"
    scene = hs.Scene(E.expression(whole, parameters={"q": "1/7"}), (F.first_order_lag(40),), (0, 9))
    knob = scene.knobs["environment.q"]
    found = sorted(map(float, missing(scene, knob)))
    assert found == pytest.approx(sorted([float(a), -float(b), d**0.5, -(d**0.5)]), rel=1e-14)
    assert not allowed(scene, knob, a)
    assert allowed(scene, knob, e)
    assert missing(scene, scene.knobs["omega_c"]) == []
    below = f"1 + s/(q - {c})" + ("/(q - v)" if turn else "")
    lead = F.series(below, parameters={"q": "1/7", **({"v": "3 Hz"} if turn else {})})
    other = hs.Scene(E.kelvin_voigt(90, 3), (lead,), (0, 9))
    found = sorted(map(float, missing(other, other.knobs["q"])))
    assert found == pytest.approx(sorted([float(c), *([6 * np.pi] if turn else [])]), rel=1e-14)


@pytest.mark.parametrize("seed", range(3))
def test_behind_a_lag_the_hand_bears_what_rouths_rule_says(seed: int) -> None:
    """m s^3 + (b + m w) s^2 + (k + b w) s + w (k + K) over s + w: stable for (b + m w)(k + b w) > m w (k + K)."""
    pick = Random(seed)
    m, b, k, corner, K = (pick.randint(*x) for x in ((1, 5), (1, 9), (0, 90), (2, 60), (100, 900)))
    scene = hs.Scene(E.mass_spring_damper(k=K), (F.first_order_lag(corner),), (0, 5))
    hand = hs.Hand("own", m=m, b=b, k=k)
    stiffest = Rational((b + m * corner) * (k + b * corner), m * corner) - k
    for span in ((1, 10**6), None):
        r = hs.require(scene, "environment.k", span, that="stable", hand=hand)
        [(low, _)] = ends(r)
        [found] = r.feasible
        assert (low, found.closed[0], found.closed[1]) == (1 if span else 0, bool(span), False)
        assert found.high is not None
        assert found.high.digits(25) == ExactNumber(stiffest).digits(25)
        assert found.last is not None
        [binding] = found.last.bindings
        assert binding.omega is not None
        assert float(binding.omega) == pytest.approx(((k + b * corner) / m) ** 0.5)
        assert binding.kind is Kind.AXIS
    damped = hs.require(scene, "hand.b", (0, 10**5), that="stable", hand=hand)
    p = k + m * corner**2
    least = (-p + (p * p + 4 * corner * m * corner * K) ** 0.5) / (2 * corner)  # w b^2 + (k + m w^2) b - m w K
    assert ends(damped) == [(pytest.approx(least, rel=1e-12), 10**5)]
    assert (damped.feasible[0].closed[0], damped.certified) == (False, True)


@pytest.mark.parametrize(("hand", "m"), [(None, 4), ("one", 1), ("two", 4), (hs.Hand("three", m=9, b=1), 9)])
def test_a_hand_is_the_one_that_is_given_or_each_of_those_of_the_scene(hand: Any, m: int) -> None:
    """Behind a lag of 10 rad/s a hand of m and 1 N s/m bears K < (1 + 10 m)/m, the heaviest one the least."""
    own = (hs.Hand("one", m=1, b=1), hs.Hand("two", m=4, b=1))
    scene = hs.Scene(E.mass_spring_damper(k=1), (F.first_order_lag(10),), (0, 5), hands=own)
    r = hs.require(scene, "environment.k", that="stable", hand=hand)
    assert ends(r) == [(0, pytest.approx((1 + 10 * m) / m, rel=1e-15))]


def test_stability_is_asked_of_a_display_in_a_hand() -> None:
    with pytest.raises(hs.SceneError, match="hand"):
        hs.require(hs.Scene(E.mass_spring_damper(k=100), ()), "environment.k", that="stable")


# --- sets from single verdicts, and what several sets have in common ------------------------------------------------------

"""Fractions, roots and pi by their sizes, -6 to 6."""


@pytest.mark.parametrize("arrays", [True, False])
@pytest.mark.parametrize("own", ["1/2", "3/4"])
def test_a_value_without_a_scene_says_nothing_of_the_values_beside_it(
    *, arrays: bool, own: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """H_perc = (q - 1)(1 + q s/200) H/(q - 1) is 0/0 at q = 1 alone; with H = 100 + s, |Im dH| = q omega/2 <= 0.1 |H| at 15 rad/s."""
    monkeypatch.setattr(solving, "has_arrays", lambda: arrays)
    port = F.two_port("(q - 1)*(1 + q*s/200)", "0", "0", "q - 1", parameters={"q": own})
    scene = hs.Scene(E.mass_spring_damper(k=100, b=1), (port,))
    found = hs.require(scene, "q", (0, 3), part=hs.Part.IMAG)
    end = 0.1 * abs(100 + 15j) / (15 / 2)
    assert [x[1] for x in ends(found)] == [1, pytest.approx(end, rel=1e-12)]
    assert 1 not in found.values
    assert Rational(13, 10) in found.values


def test_of_a_single_value_in_an_end_that_is_known_by_its_enclosure_alone_nothing_is_said() -> None:
    end = SingleValue(Sliver(Fraction(1), Fraction(1025, 1024)), holds=True)
    found = ValueSet((end,), (Stretch(holds=True), Stretch(holds=False)))
    assert 1 - Rational(1, 100) in found
    assert 1 + Rational(1, 100) not in found
    with pytest.raises(UndecidedError):
        1 + Rational(1, 4096) in found  # noqa: B015
