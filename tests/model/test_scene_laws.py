"""Scenes and their closed forms against complex arithmetic at single frequencies; what is said beside an answer, at its limits."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from refusals import refusal
from strategies import cases, scene
from sympy import Expr, Integer, Rational, lambdify, sqrt

import haptisym as hs
from haptisym import effects, environments
from haptisym.kernel.symbols import X
from haptisym.model.caveats import caveats, clocks
from haptisym.model.chain import Chain
from haptisym.model.distortion import distort
from haptisym.model.sampled import BACK, METHODS, discretised
from haptisym.model.scene import Scene

LAG = effects.first_order_lag(20)
SCENES: dict[str, tuple[hs.Environment, tuple[hs.Effect, ...], hs.Environment | None]] = {
    "filter": (environments.mass_spring_damper("1.8", 15, 100), (effects.second_order_lowpass(80, Rational(1, 2)),), None),
    "joint": (environments.kelvin_voigt(100, 3), (effects.compliance(k=800, b=4), effects.shunt(m="0.1", b="-0.2")), None),
    "delay": (environments.zener(200, 300, 6), (effects.delay("5 ms"), effects.shunt(b=1)), None),
    "tissue": (environments.spring_pot(120, "0.5", k=10), (LAG,), None),
    "rendered": (environments.kelvin_voigt(100, 3), (effects.position_force_teleoperator("0.2", "0.3", 4, 500),), environments.kelvin_voigt(90, 5)),
    "nothing": (environments.maxwell(100, 5), (), None),
}  # fmt: skip


def number(form: Expr, w: float) -> complex:
    known = {hs.s: 1j * w, hs.omega: w, X: 0.3}
    free = sorted(form.free_symbols, key=str)
    return complex(lambdify(free, form, "numpy")(*(known[x] for x in free)))


@pytest.mark.parametrize("name", SCENES)
def test_every_closed_form_is_what_complex_arithmetic_gives(name: str) -> None:
    own, between, rendered = SCENES[name]
    d = distort(own, *between, rendered=rendered)
    for w in (0.7,):
        H, felt = number(own.H, w), number((rendered or own).H, w)
        for effect in between:
            A, B, C, D = (number(x, w) for x in effect.matrix)
            felt = (A * felt + B) / (C * felt + D)
        change, size = felt - H, abs(H)
        told: dict[str, Any] = {
            "environment": H, "perceived": felt, "distortion": change, "real": change.real, "imag": change.imag, "ratio_real": abs(change.real) / size,
            "ratio_imag": abs(change.imag) / size, "relative_real": (change / H).real, "relative_imag": (change / H).imag, "modulus": size,
        }  # fmt: skip
        for key, value in told.items():
            assert number(getattr(d, key), w) == pytest.approx(value, rel=1e-9, abs=1e-9 * size), key
        for p, h in ((d.environment_properties, H), (d.perceived_properties, felt)):
            found = [number(x, w) for x in (p.stiffness, p.mass, p.damping, p.spring_inertia_force, p.damping_force)]
            assert found == pytest.approx(
                [h.real, -h.real / w**2, h.imag / w, 0.3 * h.real, 0.3j * h.imag], rel=1e-8, abs=1e-10 * size
            )
        jnd = d.parameter_jnd(Rational(1, 10))
        assert [number(x, w) for x in (jnd.stiffness, jnd.damping, jnd.mass)] == pytest.approx(
            [size / 10, size / 10 / w, size / 10 / w**2], rel=1e-9
        )
        functions = d.functions(["real", "ratio_imag", "relative_real", "environment_imag", "perceived_real"])
        expected = {
            "real": change.real,
            "ratio_imag": (change.imag / size) ** 2,
            "relative_real": (change / H).real,
            "environment_imag": H.imag,
            "perceived_real": felt.real,
        }
        for key, f in functions.items():
            assert number(f.expression(), w) == pytest.approx(expected[key], rel=1e-8, abs=1e-9 * size), key
    assert repr(d).endswith({0: "no effects>", 1: "1 effect>", 2: "2 effects>"}[len(between)])


@given(st.lists(st.integers(1, 12), min_size=1, max_size=3), st.booleans())
def test_a_changeover_is_the_lowest_frequency_at_which_the_real_part_changes_its_sign(
    roots: list[int],
    twice: bool,  # noqa: FBT001
) -> None:
    """Re H is a product of w^2 - r^2; a root that is there twice changes nothing."""
    s = hs.s
    H = Integer(1)
    for r in roots:
        H = H * (s**2 + r**2)
    H = H * (s**2 + 7) ** 2 if twice else H
    times = {r: roots.count(r) for r in roots}
    odd = sorted(r for r, n in times.items() if n % 2)
    found = distort(environments.expression(H + 3 * s)).changeover_environment
    assert found == (odd[0] if odd else None)
    behind = distort(environments.kelvin_voigt(1, 1), rendered=environments.expression(H + 3 * s))
    assert (behind.changeover_environment, behind.changeover_perceived) == (None, found)


def test_a_changeover_in_symbols_is_a_formula_where_one_root_is_the_lowest() -> None:
    m, b, k, k2 = hs.symbols("m b k k_2")
    assert distort(environments.mass_spring_damper(m, b, k)).changeover_environment == sqrt(k) / sqrt(m)
    assert distort(environments.spring_pot(k, "0.3")).changeover_environment is None
    s = hs.s
    lower = environments.expression((s**2 + 4 * k) * (s**2 + k), parameters={"k": k})
    assert distort(lower).changeover_environment == sqrt(k)
    either = environments.expression((s**2 + k2) * (s**2 + k), parameters={"k": k, "k_2": k2})
    assert distort(either).changeover_environment is None
    pole = distort(environments.expression("1/(s^2 + 49)")).changeover_environment
    assert pole == 7


# The chain.


@given(cases(3))
def test_a_chain_of_some_effects_is_that_of_a_scene_without_the_others(case: Any) -> None:
    own = scene(case)
    chain = own.distortion().chain
    for places in ([], list(range(len(own.effects)))[1:], list(range(len(own.effects)))):
        other = distort(own.environment, *(own.effects[i] for i in places), rendered=own.rendered)
        assert (
            chain.perceived(places).equals(other.perc)
            or (chain.perceived(places).expression() - other.perceived).cancel() == 0
        )


@pytest.mark.parametrize(
    ("matrix", "zero"),
    [
        ((1, 0, 0, 1), {"real", "imag", "relative_real", "relative_imag", "environment_imag", "perceived_imag"}), ((1, hs.s**2, 0, 1), {"imag", "relative_imag", "environment_imag", "perceived_imag"}),
        ((1, 2 * hs.s, 0, 1), {"real", "relative_real", "environment_imag"}), ((1, 0, hs.s, 1), {"environment_imag"}),
    ],
)  # fmt: skip
def test_a_field_vanishes_where_it_is_zero_at_every_frequency(matrix: Any, zero: set[str]) -> None:
    chain = Chain(Integer(5), Integer(5), (tuple(x + Integer(0) for x in matrix),))  # type: ignore[arg-type]
    fields = [f"{kind}{part}" for kind in ("", "relative_", "environment_", "perceived_") for part in ("real", "imag")]
    assert {name for name in fields if chain.vanishes(name)} == zero


@pytest.mark.parametrize(
    ("H", "swapped"),
    [
        ("s^2 + 9", False),
        ("s*(s^2 + 9)", True),
        ("(s^2 + 9)*(s + 2)", False),
        ("s^3*(s + 1)", True),
        ("s + 1", False),
        ("s^2*(s^2 + 4)^2", False),
    ],
)
def test_a_chain_without_zeros_on_the_axis_has_the_same_ratios_perhaps_turned(H: str, swapped: bool) -> None:  # noqa: FBT001
    own = environments.expression(H)
    chain = distort(own, effects.compliance(k=50), effects.shunt(b=2), LAG).chain
    found, is_turned = chain.without_axis_zeros()
    assert is_turned is swapped
    for w in (0.7, 5.3):
        rows = []
        for x in (chain, found):
            h, felt = number(x.environment, w), number(x.rendered, w)
            for matrix in x.matrices:
                a, b, c, d = (number(y, w) for y in matrix)
                felt = (a * felt + b) / (c * felt + d)
            rows.append((abs((felt - h).real) / abs(h), abs((felt - h).imag) / abs(h)))
        assert rows[1] == pytest.approx(rows[0][::-1] if swapped else rows[0], rel=1e-9)
    for w in (0.0, 2.0, 3.0):
        assert abs(number(found.environment, w)) > 1e-9


def test_what_is_felt_of_nothing_or_infinite_everywhere_is_refused() -> None:
    for own, between, told in (
        (environments.expression("s - s"), (), "the environment is zero at every frequency"),
        (
            environments.kelvin_voigt(1, 1),
            (effects.two_port("1", "0", "1", "-1 - s"),),
            "make the perceived dynamics infinite at every frequency",
        ),
    ):
        with pytest.raises(hs.SceneError, match=told):
            distort(own, *between)


# Clocks.


@given(
    st.lists(st.integers(-5, 9), min_size=1, max_size=3),
    st.lists(st.integers(1, 9), min_size=1, max_size=3),
    st.sampled_from(METHODS),
    st.integers(1, 9),
)
def test_a_difference_equation_is_the_dynamics_with_what_the_method_makes_of_s(
    above: list[int], below: list[int], method: str, tenths: int
) -> None:
    s, T = hs.s, Rational(tenths, 10)
    assume(any(above))
    H = sum((Integer(a) * s**i for i, a in enumerate(above)), Integer(0)) / sum(
        (Integer(b) * s**i for i, b in enumerate(below)), Integer(0)
    )
    z = 1.7 + 0.4j
    of = {
        "backward-difference": (1 - 1 / z) / float(T),
        "tustin": 2 / float(T) * (1 - 1 / z) / (1 + 1 / z),
        "forward-difference": (z - 1) / float(T),
    }[method]
    bottom = sum(b * of**i for i, b in enumerate(below))
    assume(abs(bottom) > 1e-6)
    degree = max(i for i, a in enumerate(above) if a)
    if method == "forward-difference" and degree > len(below) - 1:
        assert "improper" in refusal(discretised, H, T, method)
        return
    found = discretised(H, T, method)
    value = complex(found.expression().subs(BACK, 1 / z))
    assert value == pytest.approx(sum(a * of**i for i, a in enumerate(above)) / bottom, rel=1e-9)


WALL = environments.kelvin_voigt(200, 2)
HOLD = effects.zero_order_hold("1/50 s", name="sampler")


@pytest.mark.parametrize(
    ("between", "band", "jnd", "starts"),
    [
        ((), (0, 15), "99.9 %", []), ((), (0, 15), 1, ["The threshold of the real part is 100 %", "The threshold of the imaginary part is 100 %"]),
        ((), (0, 15), {"real": 0.5, "imag": 12}, ["The threshold of the imaginary part is 1200 %"]), ((), (0, 15), {"shape": "polygon", "corners": [[2, 0], [0, 2], [-2, -2]]}, []),
        ((HOLD,), (0, 150), 0.1, ["sampler works by a clock"]), ((HOLD,), (0, "25 Hz"), 0.1, ["sampler works by a clock"]),
        ((HOLD,), (0, "25.01 Hz"), 0.1, ["The band reaches beyond 157.08 rad/s, the Nyquist frequency of sampler", "sampler works by a clock"]),
        ((HOLD, LAG), (0, 15), 0.1, ["sampler works by a clock"]),
        ((HOLD, LAG, effects.compliance(k=9)), (0, 15), 0.1, ["sampler holds a force that compliance brings back", "sampler works by a clock"]),
        ((effects.compliance(k=9), HOLD), (0, 15), 0.1, ["sampler works by a clock"]),
        ((HOLD, effects.zero_order_hold("1 ms", name="b")), (0, 15), 0.1, ["sampler holds a force that b brings back", "sampler and b work by a clock"]),
        ((effects.sampled_loop("1/50 s", "tustin", name="loop"),), (0, 158), 2, ["The threshold of the real", "The threshold of the imag", "The band reaches beyond", "loop works by a clock"]),
    ],
)  # fmt: skip
def test_what_a_scene_stands_for_beyond_its_formulas_is_said_from_its_limit_on(
    between: Any, band: Any, jnd: Any, starts: list[str]
) -> None:
    own = Scene(WALL, between, band, jnd)
    told = caveats(own)
    assert len(told) == len(starts)
    assert all(any(x.startswith(start) for x in told) for start in starts)
    assert clocks(own) == tuple(
        e.parameters[0].value for e in between if e.model in ("zero-order-hold", "sampled-loop")
    )


# Names, doubles and what is nominal.


def test_symbols_of_a_scene_are_told_apart_by_what_they_are_of() -> None:
    lags = (effects.first_order_lag(20, name="a-b"), effects.first_order_lag(30, name="c"), effects.shunt(k=3))
    own = Scene(environments.kelvin_voigt(100, 3), lags, rendered=environments.kelvin_voigt(90, 3))
    names = [p.symbol.name for p in own.parameters]
    assert len(set(names)) == len(names)
    assert names[:4] == ["k", "b", "k_rendered", "b_rendered"]
    assert {"omega_c_a_b", "omega_c_c", "k_shunt"} <= set(names)
    damped = Scene(environments.expression("c*s + 5", parameters={"c": 3}))
    assert [p.symbol.name for p in damped.parameters] == ["c_env"]
    assert own.knobs["rendered.k"].path == "rendered.k"
    assert "a symbol where a number is needed" in refusal(
        Scene(environments.kelvin_voigt(hs.symbols("k"), 1)).knobs.need_numbers
    )


def test_what_environment_and_rendered_have_by_one_name_is_told_as_two() -> None:
    own = Scene(environments.kelvin_voigt(100, 3), (LAG,), rendered=environments.mass_spring_damper(k=90, b=2, m=1))
    assert own.untied() == (("environment.k", "rendered.k"), ("environment.b", "rendered.b"))
    assert own.untied(["rendered.b"]) == (("environment.b", "rendered.b"),)
    assert own.untied(["effects.first-order-lag.omega_c"]) == ()
    assert own.untied_note(["environment.k"]) == (
        'environment.k and rendered.k are two parameters: where one varies the other keeps its value. If they are one, write k = "environment.k" in [rendered].'
    )
    assert (
        "environment.k and rendered.k, environment.b and rendered.b are two parameters each: where" in own.untied_note()
    )
    assert own.untied_note([]) == ""
    assert own.aside_keys(varied=None) == {"untied": [["environment.k", "rendered.k"], ["environment.b", "rendered.b"]]}
    tied = Scene(
        environments.kelvin_voigt(100, 3), (LAG,), rendered=environments.kelvin_voigt("environment.k", "environment.b")
    )
    assert (tied.untied(), tied.knobs["k"].also) == ((), ("rendered.k",))
    assert "only what is rendered can refer" in refusal(Scene, environments.kelvin_voigt("environment.k", 1))


def test_what_is_nominal_is_said_in_a_sentence_for_each_width() -> None:
    def note(jnd: Any, *besides: str, **keys: Any) -> str:
        values = {"k": "100 N/m +- 5 %", "b": "3 N*s/m +- 5 %"} | keys
        return Scene(
            environments.kelvin_voigt(**values), (effects.first_order_lag([10, 30]),), (0, 15), jnd
        ).nominal_but(besides)

    assert (
        note(0.1) == "k, b vary by 5 %; omega_c varies by 50 %: this is the nominal scene; see `haptisym tolerances`."
    )
    assert (
        note(0.1, "k")
        == "b varies by 5 %; omega_c varies by 50 %: these are the nominal values; see `haptisym tolerances`."
    )
    assert (
        note([0.1, 0.3], k=1, b=[0, 2])
        == "b varies from 0 to 2; omega_c, c vary by 50 %: this is the nominal scene; see `haptisym tolerances`."
    )
    assert (
        note([0.1, 0.3], "evaluation.jnd", k=1, b=2)
        == "omega_c varies by 50 %: these are the nominal values; see `haptisym tolerances`."
    )
    own = {"real": {"higher": 0.1, "lower": [0.1, 0.2]}, "imag": 0.1}
    assert note(own, k=1, b=2) == (
        "omega_c varies by 50 %; real.lower of the JND varies from 0.1 to 0.2: this is the nominal scene; `haptisym evaluate` tells which bandwidths the JND gives."
    )
    assert note(0.1, "effects.first-order-lag.omega_c", k=1, b=2) == ""
    two = Scene(environments.kelvin_voigt(1, 2), (), (0, 15), {"real": [0.1, 0.2], "imag": 0.1})
    assert list(two.ranges()) == ["evaluation.jnd.real"]
    assert two.ranges(["evaluation.jnd.real"]) == {}
    assert list(Scene(environments.kelvin_voigt(1, 2), (), (0, 15), [0.1, 0.2]).ranges(["evaluation.jnd.real"])) == [
        "evaluation.jnd.imag"
    ]


def test_knobs_are_chosen_once_each_and_thresholds_not_both_ways() -> None:
    own = Scene(environments.kelvin_voigt(100, 3), (LAG, effects.shunt(k=1)), hands=(hs.hands["light-touch"],))
    assert [x.path for x in own.knobs.chosen(["k", "c"])] == ["environment.k", "evaluation.jnd"]
    for names, told in ((("environment.k", "k"), "environment.k is given twice"), (("c", "evaluation.jnd.real"), "evaluation.jnd is both thresholds: give it, or"),
                        (("q",), 'the scene has no parameter "q"')):  # fmt: skip
        assert told in refusal(own.knobs.chosen, names)
    assert len(own.knobs.chosen(["evaluation.jnd.real", "evaluation.jnd.imag"])) == 2
    assert set(own.knobs.limits.values()) == {own.knobs["evaluation.jnd"]}
    other = own.with_values({"evaluation.jnd.real": 0.2})
    assert [x.path for x in other.knobs.limits.values()] == ["evaluation.jnd.real", "evaluation.jnd.imag"]
    assert "changes nothing of what is felt" in refusal(own.knobs["hand.m"].felt)
    assert own.knobs["hand.m"] is own.knobs["hands.light-touch.m"]
    assert own.knobs["environment.k"].felt() is own.knobs["environment.k"]
    assert not any(x.is_of_hand or x.parts for x in own.knobs.parameters)
    assert own.knobs["environment.k"] in own.knobs
    assert own.motion is None
    assert Scene(environments.kelvin_voigt("1 N/m", 2)).knobs["b"].unit == "N*s/m"
    assert Scene(environments.expression("q*s", parameters={"q": 1})).knobs["q"].unit == "SI"
    rotating = Scene(environments.kelvin_voigt("1 N*m/rad", 2))
    assert "is translational, but the scene is rotational" in refusal(rotating.knobs["b"].number, "1 N*s/m")
    assert rotating.knobs["b"].number("1 N*m*s/rad") == 1
