"""The largest of the smallest of functions over cells, and excesses of ratios: against logic of three values and closed forms."""

from __future__ import annotations

from fractions import Fraction
from random import Random
from typing import Any

import numpy as np
import pytest

import haptisym as hs
from haptisym.judge.bounds import for_any_environment
from haptisym.judge.criteria import noticed
from haptisym.programs.taylormodels import Model
from haptisym.verbs.tolerances.box import box_of
from haptisym.verbs.tolerances.excess import Excess, LargerExcess
from haptisym.verbs.tolerances.joined import enclosing, joined

CELLS = 40


def drawn(rng: Any) -> Model:
    """A function of two variables over cells, in a third of them above 0, in a third below, in a third of unknown sign."""
    around = rng.choice([-3.0, 0.0, 3.0], size=CELLS)
    c0, c1 = rng.uniform(-0.3, 0.3, (CELLS, 3)), rng.uniform(-0.3, 0.3, (CELLS, 3, 2))
    c0[:, 0] += around
    c1[:, 0, 0] += 0.5
    return Model(c0, c1, rng.uniform(-0.1, 0.1, (CELLS, 3, 2, 2)), rng.uniform(0, 0.1, (CELLS, 3)))


def sign(x: Model, i: int) -> int | None:
    low, high = x.bounds()
    return 1 if low[i, 0] > 0 else -1 if high[i, 0] < 0 else None


def smallest(signs: list[int | None]) -> int | None:
    return -1 if -1 in signs else None if None in signs else 1


@pytest.mark.parametrize("seed", range(3))
def test_of_several_functions_those_decide_whose_sign_is_open_where_it_is_that_of_the_whole(seed: int) -> None:
    """By three values: the whole is positive, or negative, or open; then it encloses those that decide, and hardly more."""
    pick, rng = Random(seed), np.random.default_rng(seed)
    terms = [[drawn(rng) for _ in range(pick.randint(1, 3))] for _ in range(pick.randint(1, 3))]
    found = joined(terms)
    low, high = found.bounds()
    opened = 0
    for i in range(CELLS):
        signs = [[sign(f, i) for f in term] for term in terms]
        of_terms = [smallest(x) for x in signs]
        whole = 1 if 1 in of_terms else None if None in of_terms else -1
        if whole is not None:
            assert bool(low[i, 0] > 0) is (whole > 0)
            assert bool(high[i, 0] < 0) is (whole < 0)
            assert np.abs(found.c0[i, 1:]).sum() == np.abs(found.c1[i]).sum() == 0
            continue
        opened += 1
        assert low[i, 0] <= 0 <= high[i, 0]
        own = [
            f for term, x, y in zip(terms, signs, of_terms, strict=True) if y is None
            for f, n in zip(term, x, strict=True) if n is None
        ]  # fmt: skip
        ends = [(f.bounds()[0][i], f.bounds()[1][i]) for f in own]
        least, most = np.min([a for a, _ in ends], 0), np.max([b for _, b in ends], 0)
        assert (low[i] <= least + 1e-12).all()
        assert (high[i] >= most - 1e-12).all()
        assert (high[i] - low[i] <= 2 ** len(own) * sum(b - a for a, b in ends)).all()
        if len(own) == 1:
            for a, b in zip(found.arrays, own[0].arrays, strict=True):
                assert (a[i] == b[i]).all()
        if len(own) == 2:
            for a, b in zip(found.arrays, enclosing(*own[::-1]).arrays, strict=True):
                assert np.allclose(a[i], b[i], rtol=1e-12, atol=1e-12)
    assert opened > 5


def test_one_function_alone_is_itself_where_its_sign_is_open_and_else_a_number_of_its_sign() -> None:
    f = drawn(np.random.default_rng(8))
    found = joined([[f]])
    for i in range(CELLS):
        known = sign(f, i)
        if known is None:
            assert (found.c0[i] == f.c0[i]).all()
            assert (found.r[i] == f.r[i]).all()
        else:
            assert (found.c0[i, 0], found.c1[i, 0].tolist()) == (known, [0, 0])


# --- excesses ---------------------------------------------------------------------------------------------------------


def spring(*effects: Any, c: Any = "0.1", band: Any = (0, 10), k: Any = ("90", "110")) -> hs.Scene:
    return hs.Scene(
        hs.environments.mass_spring_damper(k=list(k) if isinstance(k, tuple) else k), effects, band, hs.Threshold.of(c)
    )


def values(box: Any, shares: Any) -> dict[str, float]:
    return {x.name: float(x.low) + float(x.high - x.low) * y for x, y in zip(box.sides, shares, strict=True)}


@pytest.mark.parametrize(("c", "band"), [("0.1", (2, 30)), (["0.05", "0.2"], (0, 10))])
@pytest.mark.parametrize("slopes", [0, 1, 2, None])
def test_an_excess_of_points_and_of_small_cells_is_that_of_the_closed_form(c: Any, band: Any, slopes: Any) -> None:
    """Behind a lag r_r = x^2/(1 + x^2) and r_i = x/(1 + x^2), x = omega/omega_c; slopes by differences of this."""
    box = box_of(spring(hs.effects.first_order_lag(["36", "44"]), c=c, band=band))
    rng = np.random.default_rng(1)
    points = rng.uniform(0.1, 0.9, (6, 1 + len(box.sides)))
    low, high = (float(x) for x in box.scene.band)

    def true(name: str, at: Any) -> float:
        own = values(box, at[1:])
        x = (low + (high - low) * at[0]) / own["omega_c"]
        r = x ** (2 if name == "real" else 1) / (1 + x * x)
        return float(r**2 - own.get("c", 0.1) ** 2)

    for criterion in noticed(box.scene.threshold):
        form = Excess(box, criterion)
        assert (form.sides, form.is_zero, form.order) == (1 + len(box.sides), False, 2)
        names = ["omega", *(x.name for x in box.sides)]
        assert form.matters.tolist() == [x != "k" for x in names]
        width = 2.0**-12
        cells = np.stack([points - width, points + width], -1)
        model = form.model(cells) if slopes is None else form.model(cells, slopes=slopes)
        assert model.c0.shape[1] == (1 if slopes == 0 else 1 + form.sides)
        assert model.is_linear is (slopes == 1)
        least, most = model.bounds()
        for i, at in enumerate(points):
            assert least[i, 0] <= true(criterion.name, at) <= most[i, 0]
            assert most[i, 0] - least[i, 0] < 1e-2
            for side in range(model.c0.shape[1] - 1):
                step = np.eye(form.sides)[side] * 1e-4
                rise = (true(criterion.name, at + step) - true(criterion.name, at - step)) / 2e-4 * width
                assert least[i, 1 + side] - 1e-9 <= rise <= most[i, 1 + side] + 1e-9
                assert most[i, 1 + side] - least[i, 1 + side] < 0.05 * abs(rise) + 1e-4


def test_of_up_to_seven_sides_slopes_are_bent_and_of_more_straight() -> None:
    for count, order in ((5, 2), (6, 2), (7, 1)):  # and omega
        lags = [hs.effects.first_order_lag(["36", "44"], name=f"lag{i}") for i in range(count - 1)]
        box = box_of(spring(*lags))
        assert len(box.sides) == count
        assert Excess(box, noticed(box.scene.threshold)[0]).order == order


def test_nothing_felt_but_what_is_there_is_an_excess_that_is_zero() -> None:
    for effects, zero in (
        ((), [True, True]),
        ((hs.effects.shunt(m=1),), [False, True]),
        ((hs.effects.shunt(b=1),), [True, False]),
    ):
        box = box_of(spring(*effects))
        assert [Excess(box, x).is_zero for x in noticed(box.scene.threshold)] == zero
    box = box_of(spring(hs.effects.shunt(m=1)))
    with pytest.raises(hs.SceneError, match="one part alone"):
        Excess(box, for_any_environment(box.scene.threshold))


def test_a_damper_and_a_spring_pair_parts_the_other_way_round() -> None:
    """H_env = j omega b: without its zero at 0 a real part is an imaginary one: behind a lag r_r and r_i change places."""
    felt = hs.environments.mass_spring_damper(b=["3", "5"])
    box = box_of(hs.Scene(felt, (hs.effects.first_order_lag(40),), (0, 20)))
    for criterion, power in zip(noticed(box.scene.threshold), (1, 2), strict=True):
        low, high = Excess(box, criterion).model(np.array([[[0.5, 0.5], [0.3, 0.3]]])).bounds()
        x = 10 / 40
        assert low[0, 0] <= (x**power / (1 + x * x)) ** 2 - 0.01 <= high[0, 0] <= low[0, 0] + 1e-10


@pytest.mark.parametrize("seed", range(3))
def test_whatever_is_felt_a_gain_is_off_by_the_modulus_of_what_it_is_more_than_1(seed: int) -> None:
    """|g/(1 + j x) - 1|^2 - c^2, behind a gain and a lag in series, for any environment; the threshold varies or does not."""
    rng = np.random.default_rng(seed)
    c = ["0.05", "0.2"] if seed else "0.1"
    effects = hs.effects.first_order_lag(["36", "44"]), hs.effects.series("g", parameters={"g": ["0.9", "1.05"]})
    box = box_of(spring(*effects, c=c, k=100))
    form = LargerExcess(box, noticed(box.scene.threshold)[seed % 2])
    assert form.matters.tolist() == [True] * (3 + bool(seed))
    for _ in range(4):
        at = rng.uniform(0.1, 0.9, form.sides)
        own = values(box, at[1:])
        change = own["g"] / (1 + 10j * at[0] / own["omega_c"]) - 1
        exact = abs(change) ** 2 - own.get("c", 0.1) ** 2
        low, high = form.model(np.stack([at, at], -1)[None]).bounds()
        assert low[0, 0] <= exact <= high[0, 0] <= low[0, 0] + 1e-10
        wide = form.model(np.stack([at - 0.05, at + 0.05], -1)[None])
        assert wide.bounds()[0][0, 0] <= exact <= wide.bounds()[1][0, 0]


def test_a_share_of_a_side_is_told_from_its_low_end_to_its_high_one() -> None:
    box = box_of(spring(hs.effects.shunt(b=[-5, 3]), band=(2, 12)))
    form = Excess(box, noticed(box.scene.threshold)[1])
    names = ["omega", *(x.name for x in box.sides)]
    spans = {"omega": (2, 12), "b": (-5, 3), "k": (90, 110)}
    for i, name in enumerate(names):
        low, high = spans[name]
        model = form._variable(i, np.tile([0.25, 0.75], (1, form.sides, 1)), slopes=2)
        half = (high - low) / 2
        assert model.c0[0, 0] == low + half
        assert model.c1[0, 0].tolist() == [half / 2 if n == i else 0 for n in range(form.sides)]
        assert model.c0[0, 1:].tolist() == [half / 2 if n == i else 0 for n in range(form.sides)]
        size = abs(Fraction(low)) + Fraction(high - low) * Fraction(3, 4)
        assert 4 * 2.0**-53 * float(size) <= model.r[0, 0] <= 1e-12 * float(size)
