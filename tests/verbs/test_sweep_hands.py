"""Unstable roots of each set of a sweep: against exact counts, eigenvalues, published values and polynomials made of their roots."""

from __future__ import annotations

import json
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import Seeded, case, scene
from sympy import Rational

import haptisym as hs
from haptisym.verbs.stability.held import held
from haptisym.verbs.sweep.batch import Batch
from haptisym.verbs.sweep.routh import count_right
from haptisym.verbs.sweep.told import INFINITE

PAPER = hs.load_scene("fu2019")


def exactly(x: float) -> Rational:
    return Rational(*Fraction(float(x)).as_integer_ratio())


# --- Routh's array ---------------------------------------------------------------------------------------------------


@given(
    st.lists(st.tuples(st.integers(-20, 20), st.integers(1, 12)), max_size=4),
    st.lists(st.integers(-15, 15), max_size=3),
    st.integers(-3, 3),
)
def test_zeros_on_the_right_are_counted_or_left_open(
    pairs: list[tuple[int, int]], single: list[int], scale: int
) -> None:
    """Polynomials made of their zeros: pairs x +- j y, and real ones; those on the axis are never called proven."""
    p = np.array([10.0**scale])
    for x, y in pairs:
        p = np.convolve(p, [x * x + y * y, -2 * x, 1])
    for x in single:
        p = np.convolve(p, [-x, 1])
    exact = p[:, None]
    [count], [proven] = count_right(Batch(exact, abs(exact), 4))
    zeros = [x for x, _ in pairs for _ in range(2)] + single
    assert not proven or count == sum(x > 0 for x in zeros)
    assert not (proven and 0 in zeros)
    if zeros and all(x < 0 for x in zeros) and len(zeros) < 5:
        assert proven


def test_a_leading_coefficient_that_is_perhaps_0_proves_nothing() -> None:
    p = np.array([[1.0, 1.0], [2.0, 2.0], [1.0, 1.0], [1e-20, 1e-3]])
    assert count_right(Batch(p, np.array([[1.0] * 2] * 4), 1))[1].tolist() == [False, True]


# --- against exact counts --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", [1, *(pytest.param(n, marks=pytest.mark.slow) for n in range(2, 40))])
def test_random_scenes_have_as_many_unstable_roots_as_stability_says(seed: int) -> None:
    pick = Seeded(7000 + seed)
    asked, rng = scene(case(pick, order=5)), np.random.default_rng(seed)
    m, b, k = (float(x) for x in 10.0 ** rng.uniform([-2, -1, 0], [1, 2, 3]))
    mine = hs.Hand("mine", m=m, b=b, k=k)
    paths = [p.path for p in asked.parameters if p.value.is_Rational and p.value > 0][:1]
    vary = {path: (float(asked.knobs[path].value) * np.geomspace(0.2, 5.0, 5)).tolist() for path in paths}
    found = hs.sweep(asked, {**vary, "hand.b": [b / 4, b]}, hand=mine)
    for at in np.ndindex(*found.unstable_mine.shape):
        one = found.isel(dict(zip(found.unstable_mine.dims, at, strict=True)))
        values = {str(path): exactly(float(one[path])) for path in found.unstable_mine.dims}
        try:
            exact = held(now := asked.with_hands(mine).with_values(values), now.hands[0]).unstable
        except hs.SceneError:
            exact = -1
        assert int(one.unstable_mine) == (-1 if exact is None else exact)


def test_floats_prove_nearly_all_sets_and_agree_with_eigenvalues() -> None:
    """The characteristic polynomial of the paper's example, written out."""
    natural, stiff = np.geomspace(2, 200, 25), np.geomspace(10, 3000, 20)
    found = hs.sweep(PAPER, {"omega_n": natural, "environment.k": stiff}, hand="light-touch")
    assert (found.method == 0).all()
    hand = hs.hands["light-touch"]
    m, b, k = (float(x.value) for x in hand.parameters)
    for i, w in enumerate(natural):
        for j, stiffness in enumerate(stiff):
            lag = np.array([1.0, w, w**2])
            roots = np.roots(np.polyadd(np.polymul([m, b, k], lag), w**2 * np.array([1.8, 15, stiffness])))
            if min(abs(roots.real)) > 1e-6 * max(abs(roots)):
                assert int(found.unstable_light_touch[i, j]) == (roots.real > 0).sum()


def test_beside_a_critical_value_no_set_is_counted_wrong() -> None:
    """The neighbouring doubles of the exact critical stiffness, where eigenvalues lie on the axis to within rounding."""
    filtered = PAPER.with_values({"omega_n": 20})
    [found] = hs.stability(filtered, "postural-arm", ["environment.k"]).critical
    near = next(x for row in found for x in row.found if x.path == "environment.k")
    at = float(near.value)
    values = sorted({at * (1 + n * 2.0**-52) for n in range(-3, 4)} | {0.5 * at, 2 * at})
    swept = hs.sweep(filtered, {"environment.k": values}, hand="postural-arm")
    low, high = near.value.bounds(400)
    for x, count in zip(values, swept.unstable_postural_arm.values, strict=True):
        assert low != high or Fraction(x) != low
        assert count == (0 if (Fraction(x) < low) == (near.stable_side == "below") else 2)


def test_a_root_that_the_quotient_shares_for_one_set_alone_is_none_there() -> None:
    """k (s - 1)/(s - p): with p = 1 a spring, else a display with an unstable zero of its own."""
    spring = hs.environments.mass_spring_damper(k=10)
    asked = hs.Scene(spring, (hs.effects.series("(s - 1)/(s - p)", parameters={"p": "1/2"}),))
    found = hs.sweep(asked, {"effects.series.p": [0.5, 1.0, 2.0]}, hand=hs.Hand("mine", m=1, b=20))
    for p, count in zip([0.5, 1.0, 2.0], found.unstable_mine.values, strict=True):
        roots = np.roots([1, 20, 10] if p == 1 else np.polyadd(np.polymul([1, 20, 0], [1, -p]), [10, -10]))
        assert count == (roots.real >= 0).sum()


# --- delays, clocks, several hands -----------------------------------------------------------------------------------


def test_a_delayed_spring_is_held_by_more_damping_than_published() -> None:
    """Critical damping of a mass of 0.5 kg on delayed-spring: 3.4635997327677037."""
    found = hs.sweep("delayed-spring", {"hand.b": [3.46, 3.4636]}, hand=hs.Hand("let go", m="0.5 kg", b=1))
    assert found.unstable_let_go.values.tolist() == [2, 0]
    assert found.method.values.tolist() == [1, 1]


def test_a_chain_of_roots_is_infinitely_many() -> None:
    found = hs.sweep("satellite-contact", {"environment.k": [5000.0]}, hand=["light-touch", "firm-grip"])
    assert [int(found[x].item()) for x in ("unstable_light_touch", "unstable_firm_grip")] == [INFINITE, INFINITE]
    assert found.method.item() == 1


WALL = """
environment = { model = "mass-spring-damper", k = "1000 N/m" }
effects = [{ model = "sampled-loop", T = "1 ms", method = "backward-difference" }, { model = "shunt", m = "0.04 kg", b = "0.8 N*s/m" }]
hand = { m = "0 kg" }
"""


def test_a_sampled_wall_is_unstable_above_the_stiffness_that_is_known() -> None:
    """A device of 0.04 kg and 0.8 N s/m, T = 1 ms, held by nothing: K < 1605.35113477512."""
    found = hs.sweep(hs.parse_scene(WALL), {"environment.k": [1605.0, 1606.0]})
    assert found.unstable_hand.values.tolist() == [0, 2]


@pytest.mark.slow
def test_hands_whose_names_are_alike_have_variables_of_their_own(tmp_path: Path) -> None:
    hands = [hs.Hand("a b", b=5), hs.Hand("a-b", b=6)]
    found = hs.sweep(PAPER, {"environment.m": [1.0]}, hand=hands)
    assert [found[f"unstable_a_b_{n}"].attrs["hand"] for n in (1, 2)] == ["a b", "a-b"]
    hs.sweep(PAPER, {"environment.m": [1.0]}, hand=hands, out=tmp_path / "a.zarr")
    with pytest.raises(hs.SceneError, match="another sweep"):
        hs.sweep(PAPER, {"environment.m": [1.0]}, out=tmp_path / "a.zarr")
    with pytest.raises(hs.SceneError, match="asked about twice"):
        hs.sweep(PAPER, {"environment.m": [1.0]}, hand=["firm-grip", "firm-grip"])


# --- as a user has it ------------------------------------------------------------------------------------------------


def test_the_command_tells_how_many_sets_are_stable_in_a_hand(call: Any, tmp_path: Path) -> None:
    words = ["sweep", "fu2019", "--hand", "light-touch", "--vary", "omega_n=2:31:30"]
    status, out, _ = call(*words, "--json", "--figure", str(tmp_path / "a.svg"))
    [row] = json.loads(out)["held"]
    assert status == 0
    assert row["stable"] + sum(n for roots, n in row["unstable"].items() if roots != "0") == 30
    assert 0 < row["stable"] < 30
    assert "not stable in light-touch" in (tmp_path / "a.svg").read_text(encoding="utf-8")
    status, out, _ = call(*words)
    assert status == 0
    assert f"{row['stable']} of 30 sets" in out
    assert "held" not in json.loads(call(*words[:2], *words[4:], "--json")[1])


def test_a_hand_that_there_is_not_is_told(call: Any) -> None:
    status, out, err = call("sweep", "fu2019", "--hand", "postural arm", "--vary", "omega_n=10:100:10")
    assert (status, out) == (2, "")
    assert 'did you mean "postural-arm"' in err
