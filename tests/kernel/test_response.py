"""Rational functions on the imaginary axis, and the closed forms that people read, against SymPy and mpmath."""

from __future__ import annotations

import random
from fractions import Fraction

import flint
import numpy as np
import pytest
from flint import arb
from hypothesis import assume, given
from hypothesis import strategies as st
from marks import examples, often
from oracles import DIGITS, MP, Case, digits_of
from strategies import cases, exact, rationals, scene
from sympy import Abs, Expr, I, Integer, Rational, Symbol, exp, expand, fraction, pi, sin, sqrt, together

import haptisym as hs
from haptisym.effects import compliance, first_order_lag, second_order_lowpass, series, shunt
from haptisym.environments import kelvin_voigt, mass_spring_damper
from haptisym.kernel.axis import Axis, harmonics
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.response import RealFunction, on_axis, squared_modulus
from haptisym.kernel.rings import Polynomial, RationalFunction
from haptisym.kernel.symbols import omega, s

m, b, k = hs.symbols("m b k")
omega_c, omega_n, zeta = hs.symbols("omega_c omega_n zeta")

integers = st.integers(-5, 5)
polynomials = st.lists(integers, min_size=1, max_size=4).map(lambda c: sum(n * s**i for i, n in enumerate(c)))
denominators = polynomials.filter(lambda p: p != 0)
quotients = st.builds(lambda p, q: p / q, polynomials, denominators)


def is_zero(expression: Expr) -> bool:
    """Whether an expression is 0: its numerator over one denominator, multiplied out (``cancel`` may leave 1/2 - 1/2 unadded)."""
    return expand(fraction(together(expression))[0]) == 0


@given(quotients, quotients)
def test_arithmetic_is_that_of_rational_functions(f: Expr, g: Expr) -> None:
    ring = Ring()
    a, c = ring.convert(f), ring.convert(g)
    assert is_zero((a + c).expression() - (f + g))
    assert is_zero((a - c).expression() - (f - g))
    assert is_zero((a * c).expression() - f * g)
    if c.is_zero:
        with pytest.raises(hs.SceneError, match="zero"):
            a / c
    else:
        assert is_zero((a / c).expression() - f / g)
    assert a.equals(c) == is_zero(f - g)


@given(quotients)
def test_real_and_imaginary_part_are_those_of_sympy(f: Expr) -> None:
    response = on_axis(Ring().convert(f))
    real, imag = together(expand(f.subs(s, I * omega), complex=True)).as_real_imag()
    assert is_zero(expand(response.real.expression() - real, complex=True))
    assert is_zero(expand(response.imag.expression() - imag, complex=True))


@given(quotients)
def test_the_squared_modulus_is_that_of_both_parts(f: Expr) -> None:
    function = Ring().convert(f)
    response = on_axis(function)
    total = response.real.expression() ** 2 + response.imag.expression() ** 2
    assert is_zero(squared_modulus(function).expression() - total)


@given(quotients)
def test_lowest_terms_are_the_same_function_without_a_common_factor(f: Expr) -> None:
    function = Ring().convert(f)
    reduced: RationalFunction = function.reduced()
    assert reduced.equals(function)
    assert reduced.numerator.gcd(reduced.denominator).is_constant()
    assert is_zero(function.factored() - f)


@pytest.mark.parametrize("refused", [sqrt(2) * s, Abs(s), s * 1.5, s**s, sin(s)])
def test_what_is_not_rational_in_s_with_exact_coefficients_is_refused(refused: Expr) -> None:
    with pytest.raises(hs.SceneError, match="is not made of|must be a number"):
        Ring.of([refused]).convert(refused)


def test_two_symbols_of_one_name_are_refused_rather_than_mixed_up() -> None:
    with pytest.raises(hs.SceneError, match="both named k"):
        hs.distort(mass_spring_damper(k=Symbol("k")), shunt(k=Symbol("k", positive=True)))


# --- closed forms at numbers -----------------------------------------------------------------------------------------


def numeric(expression: Expr, at: Fraction) -> object:
    """A closed form in omega at a rational frequency, by SymPy's own arithmetic."""
    return MP.mpf(str(expression.subs(omega, exact(at)).evalf(50)))


@given(cases(order=3), rationals(-1, 2))
def test_closed_forms_have_the_values_of_mpmath(case: Case, at: Fraction) -> None:
    d = scene(case).distortion()
    H, G = case.dynamics(MP.mpc(0, digits_of(at)), DIGITS)
    D, size = G - H, abs(H)
    assume(size > MP.mpf(10) ** -40 * abs(G))  # at a zero of H_env there is no ratio
    expected = {
        "real": D.real, "imag": D.imag,
        "ratio_real": abs(D.real) / size, "ratio_imag": abs(D.imag) / size,
        "relative_real": (D / H).real, "relative_imag": (D / H).imag,
    }  # fmt: skip
    for name, value in expected.items():
        assert abs(numeric(getattr(d, name), at) - value) <= MP.mpf(10) ** -40 * (abs(value) + abs(D) + abs(G)), name
    for form, value in ((d.environment, H), (d.perceived, G), (d.distortion, D)):
        found = form.subs(s, I * exact(at)).evalf(50).as_real_imag()
        assert abs(MP.mpc(str(found[0]), str(found[1])) - value) <= MP.mpf(10) ** -40 * (abs(H) + abs(G))


@examples(10)
@given(cases(order=3))
def test_compiled_functions_have_the_values_of_mpmath(case: Case) -> None:
    f = scene(case).distortion().compile()
    at = np.array([[0.3, 2.0, 11.0], [47.0, 130.0, 900.0]])
    values = f(at)
    for position in np.ndindex(at.shape):
        H, G = case.dynamics(MP.mpc(0, MP.mpf(float(at[position]))), DIGITS)
        D = G - H
        expected = {
            "real": D.real, "imag": D.imag, "ratio_real": abs(D.real) / abs(H), "ratio_imag": abs(D.imag) / abs(H),
            "relative_real": (D / H).real, "relative_imag": (D / H).imag, "environment_real": H.real,
            "environment_imag": H.imag, "perceived_real": G.real, "perceived_imag": G.imag,
        }  # fmt: skip
        for name, value in expected.items():
            relative = name.startswith("r") and name not in ("real",)
            scale = 1 + abs(D / H) if relative else abs(H) + abs(G)
            found = getattr(values, name)
            assert found.shape == at.shape
            assert abs(float(found[position]) - value) <= 1e-6 * scale, (name, at[position])


# --- the paper's closed forms ----------------------------------------------------------------------------------------


def test_the_relative_distortion_of_a_series_effect_holds_no_environment() -> None:
    d = hs.distort(mass_spring_damper(m, b, k), second_order_lowpass(omega_n, zeta))
    assert (d.relative_real.free_symbols | d.relative_imag.free_symbols) <= {omega, omega_n, zeta}
    G = omega_n**2 / (s**2 + 2 * zeta * omega_n * s + omega_n**2)
    real, imag = (G.subs(s, I * omega) - 1).as_real_imag()
    assert is_zero(expand(d.relative_real - real, complex=True))
    assert is_zero(expand(d.relative_imag - imag, complex=True))


def test_a_lag_on_a_mass_spring_damper_by_hand() -> None:
    d = hs.distort(mass_spring_damper(m, b, k), first_order_lag(omega_c))
    # dH = -j w/(w_c + j w) (k - m w^2 + j b w)
    below = omega_c**2 + omega**2
    assert is_zero(d.real - omega**2 * (b * omega_c - k + m * omega**2) / below)
    assert is_zero(d.imag + omega * (omega_c * (k - m * omega**2) + b * omega**2) / below)
    assert is_zero(d.ratio_real**2 - d.real**2 / ((k - m * omega**2) ** 2 + b**2 * omega**2))


def test_a_shunt_and_a_compliance_by_hand() -> None:
    K = hs.symbols("K")
    assert hs.distort(kelvin_voigt(k, b), shunt(m=m)).distortion == m * s**2
    d = hs.distort(kelvin_voigt(k, b), compliance(k=K))
    assert is_zero(d.perceived - 1 / (1 / (k + b * s) + 1 / K))


def test_properties_are_those_of_section_2_3() -> None:
    d = hs.distort(mass_spring_damper(m, b, k), series("2"))
    felt, X = d.environment_properties, Symbol("X")
    assert is_zero(felt.stiffness - (k - m * omega**2))
    assert is_zero(felt.mass - (m - k / omega**2))
    assert is_zero(felt.damping - b)
    assert is_zero(felt.spring_inertia_force - X * (k - m * omega**2))
    assert is_zero(felt.damping_force - I * X * b * omega)
    assert is_zero(d.perceived_properties.damping - 2 * b)


def test_the_least_noticeable_parameter_moves_the_dynamics_by_the_threshold() -> None:
    c = hs.symbols("c")
    d = hs.distort(mass_spring_damper(m, b, k))
    least = d.parameter_jnd(c)
    modulus = sqrt((k - m * omega**2) ** 2 + (b * omega) ** 2)
    H = m * s**2 + b * s + k
    for symbol, change in ((k, least.stiffness), (b, least.damping), (m, least.mass)):
        moved = expand(H.subs(symbol, symbol + change) - H)
        assert is_zero(moved.subs(s, I * omega) * moved.subs(s, -I * omega) - (c * modulus) ** 2)


def test_changeovers_in_closed_form_are_where_the_evaluation_finds_them() -> None:
    environment = mass_spring_damper("1.8 kg", "15 N*s/m", "100 N/m")
    d = hs.distort(environment, second_order_lowpass(80, 0.5))
    result = hs.evaluate(hs.Scene(environment, (second_order_lowpass(80, 0.5),)))
    assert float(d.changeover_environment) == float(result.changeovers_environment[0].omega)
    assert float(d.changeover_perceived) == pytest.approx(float(result.changeovers_perceived[0].omega), rel=1e-14)


def test_a_rational_changeover_has_a_closed_form_too() -> None:
    assert hs.distort(mass_spring_damper(m=1, b=1, k=49)).changeover_environment == 7


def test_the_changeover_of_the_perceived_dynamics_with_symbols_makes_its_real_part_vanish() -> None:
    d = hs.distort(mass_spring_damper(m, b, k), first_order_lag(omega_c))
    found = d.changeover_perceived
    assert found is not None
    # Re H_perc = w_c (w_c (k - m W) + b W)/(w_c^2 + W): zero at W = w_c k/(w_c m - b)
    assert is_zero(found**2 - omega_c * k / (omega_c * m - b))


# --- compiled functions ----------------------------------------------------------------------------------------------


def test_compiled_functions_keep_the_shape_also_of_constants() -> None:
    f = hs.distort(mass_spring_damper(k=100), series("2")).compile()
    for at in (1.0, [1.0, 2.0], [[1.0], [2.0]], np.zeros((2, 0))):
        assert f(at).real.shape == np.shape(at)
        assert (f(at).real == 100.0).all()
        assert (f(at).imag == 0.0).all()


def test_compiled_functions_take_whole_numbers_larger_than_numpy_s() -> None:
    f = hs.distort(mass_spring_damper(m=10**25, b=10**24, k=10**25), first_order_lag(10**21)).compile()
    values = f(np.array([1.0, 2.0]))
    assert values.environment_real.tolist() == pytest.approx([0.0, -3e25], rel=1e-14)
    assert values.relative_imag.tolist() == pytest.approx([-1e-21, -2e-21], rel=1e-14)
    assert values.real.dtype == np.float64


def test_compiled_functions_broadcast_their_parameters() -> None:
    f = hs.distort(mass_spring_damper(k=k), first_order_lag(omega_c)).compile()
    values = f(np.array([1.0, 2.0, 3.0]), k=np.array([[10.0], [20.0]]), omega_c=2.0)
    assert values.real.shape == (2, 3)
    assert np.allclose(values.real, [[-2.0, -5.0, -10 * 9 / 13], [-4.0, -10.0, -20 * 9 / 13]], rtol=1e-14)


@pytest.mark.parametrize("given_values", [{}, {"k": 1.0}, {"k": 1.0, "omega_c": 1.0, "m": 1.0}])
def test_compiled_functions_name_the_parameters_they_need(given_values: dict[str, float]) -> None:
    f = hs.distort(mass_spring_damper(k=k), first_order_lag(omega_c)).compile()
    with pytest.raises(hs.SceneError, match="k, omega_c"):
        f(1.0, **given_values)


def test_at_rest_the_ratios_of_an_environment_that_is_zero_there_are_their_limits() -> None:
    f = hs.distort(mass_spring_damper(m=2, b=3), series("2")).compile()
    values = f([0.0, 1.0])
    assert values.ratio_imag[0] == 1.0
    assert values.ratio_real[0] == 0.0
    unbounded = hs.distort(mass_spring_damper(m=1), shunt(k=1)).compile()([0.0])
    assert np.isinf(unbounded.ratio_real[0])


# --- delays, powers of s, pi and the imaginary unit on the axis ------------------------------------------------------

DYNAMICS: dict[str, Expr] = {
    "polynomial": 3 * s**4 - s**3 + 2 * s**2 - 7 * s + 5,
    "quotient": (s**3 + 2) / (s**5 - 3 * s**2 + s + 1),
    "delay": (2 + s * exp(-s / 4)) / (s**2 + 3 * exp(-s / 4) + 5),
    "delay squared": exp(-s / 2) * (s + 1) - exp(-s / 4) * s**2 + 3,
    "two delays": (exp(-s / 4) - 2 * exp(-s * pi / 9)) / (s + 3 + exp(-s / 4 - s * pi / 9)),
    "three delays": exp(-s / 4) * (s - exp(-s * pi / 9)) + s**2 * exp(-s * pi**2 / 50) ** 2 - 1,
    "hold": (1 - exp(-s / 5)) / (s / 5),
    "hold and lag": (1 - exp(-s / 5)) * (s + 2) / (s * (s + 7)),
    "root": 3 * sqrt(s) + s + 2,
    "root below": (s + 1) / (s * sqrt(s) + 4),
    "two powers": s ** Rational(1, 3) * (s + 2) / (1 + s ** Rational(3, 4)) + s ** Rational(5, 3),
    "power and delay": (sqrt(s) + exp(-s / 4)) / (s + 2 * sqrt(s) * exp(-s / 4) + 3),
    "two powers and two delays": s ** Rational(1, 3) * exp(-s / 4) + s ** Rational(3, 4) * exp(-s * pi / 9),
    "friction": s**2 + 2 * s + 5 + 3 * I,
    "friction and delay": (s + 2 * I) * exp(-s / 4) / (s + 3 + I),
    "friction, power and delay": (sqrt(s) + I * s) * exp(-s / 4) + 2 * I + s**3,
    "pi": (pi * s**3 + s) / (s**2 + pi**2 * s + 1),
    "pi and delay": (pi * s + exp(-s / 4)) / (s + pi),
}
PLACES = [MP.mpf("0.37"), MP.mpf("1.9"), MP.mpf("6.1"), MP.mpf("17.3")]


def mp_value(expression: Expr, at: object) -> object:
    """An expression in s, or in omega, in mpmath."""
    known = {s: MP.mpc(0, at), omega: at, I: MP.mpc(0, 1), pi: MP.pi}
    if expression in known:
        return known[expression]
    if expression.is_Rational:
        return MP.mpf(int(expression.p)) / int(expression.q)
    arguments = [mp_value(x, at) for x in expression.args]
    if expression.is_Add:
        return MP.fsum(arguments)
    if expression.is_Mul:
        return MP.fprod(arguments)
    if expression.is_Pow:
        return arguments[0] ** (int(expression.exp) if expression.exp.is_Integer else arguments[1])
    return getattr(MP, type(expression).__name__)(*arguments)


SLOW = {"two powers and two delays", "three delays", "two powers"}


@pytest.mark.few(
    "polynomial",
    "quotient",
    "delay",
    "delay squared",
    "hold",
    "hold and lag",
    "root",
    "friction and delay",
    "pi",
)
@pytest.mark.parametrize("name", often(DYNAMICS, lambda name: name not in SLOW))
def test_on_the_axis_every_form_has_the_values_of_mpmath(name: str) -> None:
    f = DYNAMICS[name]
    dynamics = Ring.of([f]).convert(f).reduced()
    response, square = on_axis(dynamics), squared_modulus(dynamics)
    truths = {
        "real": (response.real, lambda x: mp_value(f, x).real),
        "imag": (response.imag, lambda x: mp_value(f, x).imag),
        "square": (square, lambda x: abs(mp_value(f, x)) ** 2),
        "product": (response.real * square, lambda x: mp_value(f, x).real * abs(mp_value(f, x)) ** 2),
        "quotient": (response.imag / square, lambda x: mp_value(f, x).imag / abs(mp_value(f, x)) ** 2),
        "difference": (response.imag - response.real, lambda x: mp_value(f, x).imag - mp_value(f, x).real),
        "slope of real": (response.real.derivative(), lambda x: MP.diff(lambda w: mp_value(f, w).real, x)),
        "slope of imag": (response.imag.derivative(), lambda x: MP.diff(lambda w: mp_value(f, w).imag, x)),
    }
    for kind, (found, true) in truths.items():
        forms = (
            (found.expression(), found.factored(), found.half_angled.factored())
            if "slope" not in kind
            else (found.half_angled.factored(),)
        )
        for x in PLACES:
            value = true(x)
            limit = MP.mpf(10) ** -25 * (1 + abs(value) + abs(mp_value(f, x)) ** 3)
            for form in forms:
                assert abs(mp_value(form, x) - value) <= limit, (kind, form)
            with flint.ctx.workprec(200):
                ball = found.ball(arb(str(x)))
                assert ball.rad() < 1e-30 * (1 + abs(float(value)) + abs(complex(mp_value(f, x))) ** 3)
                assert abs(MP.mpf(ball.mid().str(60, radius=False)) - value) <= limit, kind


@pytest.mark.parametrize("seed", range(6))
def test_at_rest_powers_of_s_that_are_not_whole_leave_the_limit_whatever_cancels(seed: int) -> None:
    """Sums of few powers over others, with and without a delay: at 10^-900 rad/s all but the first power is lost."""
    draw = random.Random(seed)
    for _ in range(4):
        order, first = Rational(draw.choice(["1/2", "1/3", "2/3", "3/4"])), draw.choice([0, 1, 2])
        late = draw.choice([1, 1, exp(-s / 7)])
        above, below = (
            sum(
                draw.choice([-3, 1, 2, 7]) * late ** draw.randint(0, 1) * s ** (first * order + n)
                for n in (0, *draw.sample([order, 3 * order, 1 + order], 2))
            )
            for _ in range(2)
        )
        f = above / below * draw.choice([1, 1, s])
        response, near = on_axis(Ring.of([f]).convert(f)), mp_value(f, MP.mpf(10) ** -900)
        for part, true in ((response.real, near.real), (response.imag, near.imag)):
            with flint.ctx.workprec(200):
                ball = part.ball(arb(0))
            assert ball.rad() < 1e-30
            assert abs(MP.mpf(ball.mid().str(40, radius=False)) - true) < 1e-30


@pytest.mark.parametrize("counts", [(0, 0), (1, 0), (0, 3), (2, 1), (4, 2)])
def test_all_factors_one_plus_tangent_squared_are_taken_out_and_counted(counts: tuple[int, int]) -> None:
    axis = Axis([], [Rational(1, 3), Rational(1, 7)], [])
    x, y = axis.context.gens()[axis.size : axis.size + 2]
    for rest in (axis.variable**2 + x * y + 3, (x**3 + 1) * (y - 2), axis.constant(5)):
        whole = rest * (x**2 + 1) ** counts[0] * (y**2 + 1) ** counts[1]
        assert axis.without_circles(whole) == (rest, list(counts))
    assert axis.without_circles(axis.constant(0)) == (axis.constant(0), [0, 0])


pieces = st.lists(st.integers(-3, 3).filter(bool), min_size=1, max_size=3)


@examples(30)
@given(pieces, pieces, pieces, st.tuples(*[st.integers(0, 2)] * 4))
def test_of_several_angles_lowest_terms_are_those_of_the_common_divisor(
    top: list[int], bottom: list[int], both: list[int], circles: tuple[int, int, int, int]
) -> None:
    """Factors 1 + tan^2 above and below the line, some of which cancel; the witness is the common divisor of the whole."""
    axis = Axis([], [Rational(1, 3), Rational(1, 7)], [])
    x, y = axis.context.gens()[axis.size : axis.size + 2]

    def of(row: list[int]) -> Polynomial:
        return sum((c * axis.variable**n * x ** (n % 2) for n, c in enumerate(row)), y + 7)

    a, b, c, d = circles
    above = of(top) * of(both) * (x**2 + 1) ** a * (y**2 + 1) ** b
    below = of(bottom) * of(both) * (x**2 + 1) ** c * (y**2 + 1) ** d
    function = axis.function(above, below)
    found, witness = axis.reduced(function), function.reduced()
    assert (found.numerator, found.denominator) == (witness.numerator, witness.denominator)


@examples(15)
@given(*[st.lists(st.integers(-2, 2).filter(bool), min_size=2, max_size=3)] * 3, st.integers(0, 3), st.integers(0, 3))
def test_a_square_over_a_function_is_in_lowest_terms(
    f: list[int], g: list[int], both: list[int], above: int, below: int
) -> None:
    """Common factors up to three times in each; the witness is the common divisor of the whole."""
    p, q, r = (sum(c * omega**n for n, c in enumerate(row)) for row in (f, g, both))
    one, other = (
        RealFunction(Ring().axis.convert(x).reduced())
        for x in (p * r**above / (q**2 + omega**2), q * r**below / (p**2 + 1))
    )
    found = one.square_over(other).function
    witness = (one.function * one.function / other.function).reduced()
    assert (found.numerator, found.denominator) == (witness.numerator, witness.denominator)
    with pytest.raises(hs.SceneError, match="zero"):
        one.square_over(RealFunction(Ring().axis.zero))


def test_half_angles_hold_no_more_of_cos_squared_plus_sin_squared_than_they_must() -> None:
    """|exp(-s tau)|^2 = 1 and |1 - exp(-s tau)|^2 = 4 sin(omega tau/2)^2: nothing cancels where omega is small."""
    for f, expected in (
        (exp(-s / 4), Integer(1)),
        ((s + 1) * exp(-s / 4) * exp(-s * pi / 9), omega**2 + 1),
    ):
        assert squared_modulus(Ring.of([f]).convert(f)).half_angled.factored().expand() == expected
    f = 1 - exp(-s / 4)
    form = squared_modulus(Ring.of([f]).convert(f)).half_angled.factored()
    tiny = MP.mpf(10) ** -30
    assert abs(mp_value(form, tiny) / (tiny / 4) ** 2 - 1) < MP.mpf(10) ** -40
    assert form.count_ops() <= 8
    hold = (1 - exp(-s / 4)) / s
    parts = on_axis(Ring.of([hold]).convert(hold).reduced())
    with flint.ctx.workprec(100):
        assert parts.real.ball(arb("1e-40")).rel_accuracy_bits() > 80  # of 1/4
        assert parts.imag.ball(arb("1e-40")).rel_accuracy_bits() > 80  # of -omega/32


@pytest.mark.parametrize(("k", "top"), [(k, top) for top in (0, 2, 4, 6, 8) for k in range(top + 1)])
def test_powers_of_half_angles_are_sums_of_waves(k: int, top: int) -> None:
    for x in (MP.mpf("0.3"), MP.mpf("2.2")):
        total = MP.mpf(0)
        for i, c in harmonics(k, top).items():
            wave = MP.mpf(1) if i < 0 else (MP.sin if i % 2 else MP.cos)((i // 2 + 1) * x)
            total += wave * int(c.p) / int(c.q)
            assert c != 0
        assert abs(total - MP.sin(x / 2) ** k * MP.cos(x / 2) ** (top - k)) < MP.mpf(10) ** -60


def test_dynamics_without_delays_stay_polynomials_on_the_axis() -> None:
    """Even powers of s are real, odd ones imaginary, and every second of either turns its sign."""
    for n in range(9):
        response = on_axis(Ring().convert(s**n))
        turned = (omega**n, 0, -(omega**n), 0)
        assert response.real.expression() == turned[n % 4]
        assert response.imag.expression() == (0, omega**n, 0, -(omega**n))[n % 4]
        assert response.real.half_angled is response.real.function
        assert response.real.written is response.real.function
