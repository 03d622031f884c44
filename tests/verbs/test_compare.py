"""Several displays side by side: the order of their bandwidths against mpmath, equal ones proven, what differs, hands."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from mpmath import findroot, mp, mpf

import haptisym as hs
from haptisym.kernel.errors import SceneError
from haptisym.writing.latex import latex

E, F = hs.environments, hs.effects


def lagged(m: Any, b: Any, k: Any, *effects: Any, band: Any = (0, 15), jnd: Any = "0.1") -> hs.Scene:
    return hs.Scene(E.mass_spring_damper(m, b, k), effects, band, jnd)


def first_crossing(m: float, b: float, k: float, omega_c: float, jnd: float) -> Any:
    """The first frequency at which r_r or r_i of a spring-mass-damper behind a first-order lag is the JND, by mpmath."""

    def excess(omega: Any) -> Any:
        s = mp.mpc(0, omega)
        H = m * s**2 + b * s + k
        change = (H / (1 + s / omega_c) - H) / abs(H)
        return max(abs(change.real), abs(change.imag)) - mpf(jnd)

    grid = [mpf(i) / 100 for i in range(1, 1500)]
    low, high = next((x, y) for x, y in pairwise(grid) if excess(x) < 0 <= excess(y))
    with mp.workdps(30):
        return findroot(excess, (low, high), solver="anderson")


def test_the_order_and_the_differences_of_bandwidths_are_those_of_another_arithmetic() -> None:
    rows = [
        (1.0, 4.0, 100.0, 40.0, 0.1),
        (2.0, 15.0, 50.0, 60.0, 0.1),
        (0.5, 1.0, 300.0, 30.0, 0.05),
        (1.5, 9.0, 80.0, 90.0, 0.1),
    ]
    scenes = [lagged(m, b, k, F.first_order_lag(c), jnd=jnd) for m, b, k, c, jnd in rows]
    found, expected = hs.compare(*scenes), [first_crossing(*row) for row in rows]
    assert found.order == tuple((i,) for i in sorted(range(4), key=lambda i: -expected[i]))
    for i in range(1, 4):
        later = found.later(i)
        assert later is not None
        assert float(later) == pytest.approx(float(expected[i] - expected[0]), rel=1e-12)
    assert found.certified


def test_equal_bandwidths_are_proven_equal_and_nearly_equal_ones_are_told_apart() -> None:
    # H times a number changes no ratio: the bandwidth is the same number, from other formulas.
    one = lagged("1.8", 15, 100, F.second_order_lowpass(80, "0.5"))
    twice = lagged("3.6", 30, 200, F.second_order_lowpass(80, "0.5"), band=(0, 20))
    near = lagged("1.8", 15, 100, F.second_order_lowpass("80." + 40 * "0" + "1", "0.5"))
    found = hs.compare(near, one, twice)
    assert found.order == ((0,), (1, 2))
    assert hs.compare(one, twice).later(1) == hs.compare(one, one).later(1)
    # delays, too: two halves in series are one
    late = [
        hs.Scene(E.mass_spring_damper(k=100), x, (0, 15), "0.1")
        for x in ([F.delay("0.02")], [F.delay("0.01"), F.delay("0.01")])
    ]
    assert hs.compare(*late).order == ((0, 1),)


def test_of_displays_that_are_not_noticed_the_order_is_known_only_as_far_as_their_bands_reach() -> None:
    quiet, short = (lagged(1, 4, 100, F.first_order_lag(10_000), band=(0, high)) for high in (15, 5))
    loud = lagged(1, 4, 100, F.first_order_lag(40))
    at_once = lagged(1, 4, 100, F.shunt(k=50))
    assert hs.compare(quiet, quiet, loud, at_once).order == ((0, 1), (2,), (3,))
    found = hs.compare(quiet, short)
    assert found.order is None
    assert found.undecided == (("device 1", "device 2"),)
    assert not found.certified


def test_a_measured_display_is_put_in_order_only_where_its_points_decide_it() -> None:
    omega, spring = np.linspace(1, 10, 10), E.mass_spring_damper(k=100)
    # noticed from 6 rad/s on, with discs of 2 %
    H = np.where(omega < 5.5, 100, 130).astype(complex)
    device = hs.MeasuredScene(spring, hs.measured(omega, H, radius=np.full(10, 2.0)))
    early, late, between = (lagged(0, 0, 100, F.series(f"1 + (s/{x})^2/10")) for x in (3, 9, "5.5"))
    assert [float(x.bandwidth or 0) for x in hs.compare(early, late)] == pytest.approx([3, 9])
    assert hs.compare(device, early, late).order == ((2,), (0,), (1,))
    assert hs.compare(device, between).order is None
    assert hs.compare(device, early).settled
    assert not hs.compare(device, early).certified


def test_what_differs_is_told_with_exact_values_and_what_does_not_is_left_out() -> None:
    found = hs.compare("fu2019", values={"filter.zeta": "0.07", "omega_n": "10 Hz"})
    assert [(x["path"], x["values"]) for x in found.to_dict()["differences"]] == [
        ("effects.filter.omega_n", ["80", "20*pi"]),
        ("effects.filter.zeta", ["1/2", "7/100"]),
    ]
    other = hs.compare(
        "fu2019",
        lagged("1.8", 15, 100, F.delay("10 ms"), band=(0, 20), jnd={"real": "0.1", "imag": "0.1", "shape": "ellipse"}),
    )
    paths = {x.path: x.row()["values"] for x in other.differences}
    assert paths["effects.filter.model"] == ["second-order-lowpass", None]
    assert paths["effects.delay.tau"] == [None, "1/100"]
    assert paths["evaluation.band"] == [["0", "15"], ["0", "20"]]
    assert paths["evaluation.jnd.shape"] == ["square", "ellipse"]
    assert not {x for x in paths if x.startswith("environment")}


def test_choices_formulas_and_the_order_of_effects_differ_as_numbers_do() -> None:
    lag, mass, spring = F.first_order_lag("80 rad/s"), F.shunt(m="0.1 kg"), {"b": 2, "k": 100}

    def differences(one: hs.Scene, other: hs.Scene) -> dict[str, tuple[Any, ...]]:
        found = hs.compare(one, other)
        # Two displays that are not the same are never called so.
        assert "same models" not in str(found)
        return {x.path: x.values for x in found.differences}

    def of_formula(H: str) -> hs.Scene:
        return hs.Scene(E.expression(H, parameters=spring), [lag], (0, 15), "0.1")

    late = [lagged(1, 2, 100, F.pade_delay("10 ms", order=n)) for n in (2, 3)]
    assert differences(*late) == {"effects.pade-delay.order": ("2", "3")}
    assert differences(of_formula("k + b*s"), of_formula("k + 2*b*s")) == {"environment.H": ("b*s + k", "2*b*s + k")}
    assert differences(lagged(1, 2, 100, lag, mass), lagged(1, 2, 100, mass, lag)) == {
        "effects": ("first-order-lag, shunt", "shunt, first-order-lag")
    }
    spring_and_mass = hs.Scene(E.mass_spring_damper(m=1, k=100), [lag], (0, 15), "0.1")
    assert differences(spring_and_mass, lagged(1, 2, 100, lag)) == {"environment.b": (None, 2)}
    assert "same models" in str(hs.compare(late[0], lagged(1, 2, 100, F.pade_delay("10 ms", order=2))))


def test_each_display_is_asked_about_the_hands_that_all_have_or_about_those_that_are_named() -> None:
    light, firm = hs.Hand("light", m="0.1 kg", b="1 N*s/m", k="10 N/m"), hs.hands["firm-grip"]
    rows = [(1, 4, 100, 3, [light, firm]), (1, 1, 900, 20, [firm])]
    scenes = [lagged(m, b, k, F.first_order_lag(c)).with_hands(*own) for m, b, k, c, own in rows]
    assert [[y.hand.name for y in x.held] for x in hs.compare(*scenes)] == [["firm-grip"]] * 2
    named = hs.compare(*scenes, hand=["firm-grip", light])
    for (m, b, k, c, _), display in zip(rows, named, strict=True):
        for x in display.held:
            M, B, K = (float(p.value) for p in x.hand.parameters)
            # c (m s^2 + b s + k)/(s + c) + M s^2 + B s + K over one denominator
            above = np.polyadd(np.multiply(c, [m, b, k]), np.polymul([M, B, K], [1, c]))
            assert x.unstable == (np.roots(above).real >= 0).sum()
    assert {x.stable for display in named for x in display.held} == {True, False}


@pytest.mark.parametrize(
    ("ask", "words"),
    [
        (lambda: hs.compare("fu2019"), "2 to 6"),
        (lambda: hs.compare(*["fu2019"] * 7), "2 to 6"),
        (lambda: hs.compare("fu2019", "fu2019", values={"zeta": 1}), "values"),
        (lambda: hs.compare("fu2019-bench", values={"zeta": 1}), "measured"),
        (lambda: hs.compare("fu2019", "palpation-device"), "liver"),
        (lambda: hs.compare("fu2019", "sidestick", hand="postural-arm"), "sidestick"),
        (lambda: hs.compare("fu2019", lagged(hs.symbols("m"), 1, 2)), "symbol"),
    ],
)
def test_what_cannot_be_compared_is_refused_with_the_way_out(ask: Any, words: str) -> None:
    with pytest.raises(SceneError, match=words):
        ask()


def test_the_command_compares_files_and_values(call: Any) -> None:
    assert call("compare", "fu2019", "--with", "zeta=0.4", "--json")[0] == 0
    assert call("compare", "fu2019", "fu2019-bench", "--json")[0] == 3
    assert call("compare", "palpation-device", "fu2019", "--environment", "liver", "--json")[0] == 0
    status, _, err = call("compare", "fu2019", "--with", "zeta")
    assert (status, "PATH=VALUE" in err) == (2, True)


def test_the_next_command_stands_in_the_text_but_not_in_a_document() -> None:
    found = hs.compare(lagged(1, 4, 100, F.first_order_lag(40)), lagged(1, 4, 100, F.first_order_lag(60)))
    assert "Next: `haptisym evaluate SCENE`" in str(found)
    assert "Proven: every bandwidth" in latex(found.document())
    assert "Next" not in latex(found.document())
