"""Programs in power series over balls: each operation against Taylor coefficients at 200 digits, at points of wide operands."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import flint
import mpmath
import numpy as np
import pytest
from flint import acb, acb_series, arb
from sympy import I, Rational, Symbol, exp

from haptisym.kernel.symbols import s
from haptisym.programs.links import CHANGE, FELT, links
from haptisym.programs.program import Program, Writer, phi
from haptisym.programs.series import BALL_SERIES, FLOATS, InSteps, along_axis, series_arithmetic

TERMS = 5
MP = mpmath.MPContext()
MP.dps = 200
TINY = MP.mpf(10) ** -40


Row = list[Any]


def times(x: Row, y: Row) -> Row:
    return [MP.fsum(x[i] * y[k - i] for i in range(k + 1)) for k in range(TERMS)]


def over(x: Row, y: Row) -> Row:
    found: Row = []
    for k in range(TERMS):
        found.append((x[k] - MP.fsum(found[i] * y[k - i] for i in range(k))) / y[0])
    return found


def exponential(x: Row) -> Row:
    found = [MP.exp(x[0])]
    for k in range(1, TERMS):  # f' = x' f
        found.append(MP.fsum(i * x[i] * found[k - i] for i in range(1, k + 1)) / k)
    return found


def mean(x: Row) -> Row:
    """(1 - exp(-x))/x, as the sum of (-x)^n/(n + 1)!."""
    total, power = [MP.mpc(0)] * TERMS, [MP.mpc(1)] + [MP.mpc(0)] * (TERMS - 1)
    for n in range(110):
        total = [a + b / MP.factorial(n + 1) for a, b in zip(total, power, strict=True)]
        power = times(power, [-c for c in x])
    return total


FUNCTIONS: dict[str, tuple[Callable[..., Row], int]] = {
    "add": (lambda x, y: [a + b for a, b in zip(x, y, strict=True)], 2),
    "sub": (lambda x, y: [a - b for a, b in zip(x, y, strict=True)], 2),
    "mul": (times, 2),
    "div": (over, 2),
    "neg": (lambda x: [-a for a in x], 1),
    "exp": (exponential, 1),
    "phi": (mean, 1),
}


def exactly(ball: Any) -> Any:
    mantissa, exponent = ball.mid().man_exp()
    return MP.mpf((int(mantissa), int(exponent)))


def holds(ball: Any, value: Any) -> bool:
    """Whether a complex ball holds a number, to within 1e-40 of its size."""
    slack = TINY * (1 + abs(value))
    return all(
        not part.is_finite() or abs(exactly(part.mid()) - own) <= exactly(part.rad()) + slack
        for part, own in ((ball.real, value.real), (ball.imag, value.imag))
    )


def operand(random: np.random.Generator, radius: float) -> tuple[Any, list[Any]]:
    """A series whose first coefficient is a ball, often near or around 0, and one of the series that it stands for."""
    middle = complex(*random.normal(0, random.choice([1e-3, 0.3, 3]), 2)) * random.choice([0, 1], p=[0.2, 0.8])
    shift = complex(*random.choice([-1.0, -0.6, 0.0, 1.0], 2)) * radius
    later = [complex(*random.normal(0, 2, 2)) for _ in range(TERMS - 1)]
    ball = acb(arb(middle.real, radius), arb(middle.imag, radius))
    own = MP.mpc(MP.mpf(middle.real) + MP.mpf(shift.real), MP.mpf(middle.imag) + MP.mpf(shift.imag))
    return acb_series([ball, *map(acb, later)], prec=TERMS), [own, *map(MP.mpc, later)]


@pytest.mark.few("mul", "exp")
@pytest.mark.parametrize("name", FUNCTIONS)
def test_an_operation_holds_the_taylor_coefficients_at_every_point_of_its_operands(name: str) -> None:
    function, count = FUNCTIONS[name]
    random = np.random.default_rng(sum(map(ord, name)))
    known = 0
    for _ in range(120 if name == "phi" else 1000):
        radius = random.choice([0.0, 1e-12, 1e-3, 0.3, 2.0])
        pairs = [operand(random, radius) for _ in range(count)]
        if name == "div" and abs(pairs[1][1][0]) == 0:
            continue
        with series_arithmetic():
            found = BALL_SERIES[name](*(x for x, _ in pairs))
        true = function(*(own for _, own in pairs))
        assert all(holds(found[k], MP.mpc(c)) for k, c in enumerate(true)), (pairs, true)
        known += all(found[k].is_finite() for k in range(TERMS))
    assert known > 50


def test_a_quotient_by_what_may_vanish_and_a_power_of_what_may_be_zero_are_unknown() -> None:
    with series_arithmetic():
        near = along_axis(arb(0.1, 0.2), TERMS)
        assert not BALL_SERIES["div"](acb(1), near)[0].is_finite()
        assert not BALL_SERIES["power"](near, acb(0.5))[0].is_finite()
        root = BALL_SERIES["power"](along_axis(arb(4, 0.1), TERMS), acb(0.5))
    for w in (3.9, 4.0, 4.1):
        true = MP.taylor(lambda t, w=w: MP.sqrt(MP.mpc(0, 1) * (MP.mpf(w) + t)), 0, TERMS - 1)
        slack = [abs(exactly(root[k].real.rad())) + 1e-12 for k in range(TERMS)]
        assert all(abs(exactly(root[k].real.mid()) - c.real) <= slack[k] for k, c in enumerate(true))


def test_phi_around_0_is_known_as_well_as_its_argument() -> None:
    with series_arithmetic():
        for radius in (1e-1, 1e-3, 1e-6):
            found = BALL_SERIES["phi"](along_axis(arb(radius / 2, radius / 2), TERMS))
            assert all(float(found[k].real.rad() + found[k].imag.rad()) < 3 * radius for k in range(TERMS))
            for share in (0, 0.3, 1):  # from 0 on, on one side
                true = mean([MP.mpc(0, share * MP.mpf(radius)), MP.mpc(0, 1), *[MP.mpc(0)] * (TERMS - 2)])
                assert all(holds(found[k], MP.mpc(c)) for k, c in enumerate(true))


def test_what_needs_s_alone_is_computed_once_and_floats_agree() -> None:
    x = Symbol("x")
    write = Writer((s, x))
    e = write.expression(exp(-s * Rational(1, 5)))
    lag = write.div(write.constant(20), write.add(write.input(s), write.constant(20)))
    held = write.mul(write.expression(phi(s / 7)), write.expression(I))
    results = {"y": write.add(write.mul(write.mul(e, lag), write.input(x)), held), "z": e}
    program = write.program(results)
    with series_arithmetic():
        balls = InSteps(program, BALL_SERIES)
        known = balls.known(along_axis(arb(3), TERMS))
        y, z = balls.results(known, [acb_series([acb(2), acb(1)], prec=TERMS)])
        assert sum(step is None for step in known) == 3  # x, its product, the sum
    floats = InSteps(program, FLOATS)
    omega = np.array([1.0, 3.0])
    near = floats.results(floats.known(1j * omega), [np.array([2.0, 2.0])])
    for ball, row in zip((y, z), near, strict=True):
        assert complex(float(ball[0].real), float(ball[0].imag)) == pytest.approx(row[1], rel=1e-13)


def test_links_are_the_chain_matrices_one_after_the_other() -> None:
    """At one frequency, from the entries of the matrices: a gain, a shunt, a compliance, waves."""
    c, w, tau = 5 + 2 * s, Rational(30), Rational(1, 50)
    waves = (
        (exp(s * tau) + exp(-s * tau)) / 2, 10 * s * (exp(s * tau) - exp(-s * tau)) / 2,
        (exp(s * tau) - exp(-s * tau)) / (20 * s), (exp(s * tau) + exp(-s * tau)) / 2,
    )  # fmt: skip
    one, none = Rational(1), Rational(0)
    matrices = [(w / (s + w), none, none, one), (one, 3 * s**2, none, one), (one, none, 1 / c, one), waves]
    H, rendered = 2 * s**2 + 7 * s + 90, 2 * s**2 + 7 * s + 80
    own = links(H, rendered, matrices)
    at = 11j
    felt, change = InSteps(own.start, FLOATS).results(InSteps(own.start, FLOATS).known(at))[1:]
    F, X = complex(rendered.subs(s, at)), 1 + 0j
    for matrix, program in zip(matrices, own.effects, strict=True):
        assert program.inputs == (s, FELT, CHANGE)
        link = InSteps(program, FLOATS)
        felt, change = link.results(link.known(at), (felt, change))
        A, B, C, D = (complex(entry.subs(s, at)) for entry in matrix)
        F, X = A * F + B * X, C * F + D * X
        assert felt == pytest.approx(F / X, rel=1e-12)
        assert change == pytest.approx(F / X - complex(H.subs(s, at)), rel=1e-11)
    with series_arithmetic():
        link = InSteps(own.effects[-1], BALL_SERIES)
        near = along_axis(arb(0, 0.01), TERMS)
        assert link.results(link.known(near), (acb_series([acb(90)], prec=TERMS),) * 2)[0][0].is_finite()


@pytest.mark.parametrize("order", [1, 2, 3])
def test_a_link_that_is_0_over_0_at_rest_has_its_limit_there(order: int) -> None:
    """(w (1 - exp(-s tau))/s)^n is (w tau)^n at s = 0; the change of it to what comes before is one less."""
    tau, w = Rational(1, 5), Rational(3)
    hold = (w * (1 - exp(-s * tau)) / s) ** order
    one, none = Rational(1), Rational(0)
    start, [effect] = (own := links(90 + s, 90 + s, [(hold, none, none, one)])).start, own.effects
    with series_arithmetic():
        for at in (arb(0), arb(0.25)):
            near = along_axis(at, TERMS)
            _, felt, change = InSteps(start, BALL_SERIES).results(InSteps(start, BALL_SERIES).known(near), [])
            link = InSteps(effect, BALL_SERIES)
            found, moved = (x[0] for x in link.results(link.known(near), (felt, change)))
            z = mpmath.mpc(0, float(at.mid()))
            gain = (3 * (1 - mpmath.exp(-z / 5)) / z if at != 0 else mpmath.mpf(3) / 5) ** order
            for ball, truth in ((found, (90 + z) * gain), (moved, (90 + z) * (gain - 1))):
                assert complex(float(ball.real), float(ball.imag)) == pytest.approx(complex(truth), rel=1e-13)


def test_the_caller_s_precision_and_length_come_back() -> None:
    before = flint.ctx.prec, flint.ctx.cap
    with series_arithmetic():
        assert (flint.ctx.prec, flint.ctx.cap) != before
    assert (flint.ctx.prec, flint.ctx.cap) == before
    assert isinstance(Writer((s,)).program({}), Program)
