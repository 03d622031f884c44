"""What is known of one cell of band and box: signs, where crossings may lie, and the side that is cut; against plain loops."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from forms import Form

from haptisym.programs.taylormodels import Model
from haptisym.verbs.tolerances.search import bounded


def drawn_models(rng: Any, count: int, sides: int, rows: int) -> Model:
    """Models of which some rows are known in sign and some are not, and some are not known at all."""
    c0 = rng.normal(size=(count, 1 + sides)) * rng.choice([0.1, 1, 4], size=(count, 1 + sides))
    c1 = rng.normal(size=(count, 1 + sides, sides)) * 0.5
    c2 = rng.normal(size=(count, rows, sides, sides)) * 0.1
    r = rng.uniform(0, 0.2, (count, 1 + sides))
    r[rng.random(r.shape) < 0.05] = np.inf
    return Model(c0, c1, c2, r)


def plain_split(cell: Any, c1: Any, c2: Any, low: Any, high: Any) -> set[int]:
    """The sides along which what is not known in sign changes most, as a share of its own width; the widest if none is told."""
    sides = range(len(cell))
    change = [[abs(c1[k][i]) + (sum(map(abs, c2[k][i])) if k < len(c2) else 0) for i in sides] for k in range(len(c1))]
    unknown = [k for k in range(len(c1)) if low[k] <= 0 <= high[k] and np.isfinite(high[k])]
    score = [sum(change[k][i] / (high[k] - low[k]) for k in unknown) for i in sides]
    if 0 not in unknown:
        score = change[0]
    width = [b - a for a, b in cell]
    if not max(score) > 0 or not np.isfinite(score).all():
        score = width
    most = max(x for x, y in zip(score, width, strict=True) if y > 0)
    return {i for i in sides if width[i] > 0 and score[i] >= most * (1 - 1e-12)}


@pytest.mark.parametrize("rows", [1, 4])
@pytest.mark.parametrize("seed", range(3))
def test_a_cell_is_cut_along_the_side_on_which_most_of_what_is_not_known_depends(seed: int, rows: int) -> None:
    """Slopes to second order, or to first: models as they may come, of sides of which some have no width."""
    rng, count, sides = np.random.default_rng(seed), 60, 3
    model = drawn_models(rng, count, sides, rows)
    model.c1[:5, 0] = 0
    model.c2[:5, 0] = 0
    start = rng.uniform(0, 0.5, (count, sides))
    cells = np.stack([start, start + rng.choice([0.0, 0.1, 0.3], size=start.shape)], -1)
    cells[:, 0, 1] = cells[:, 0, 0] + 0.2

    class Drawn:
        def model(self, own: Any) -> Model:
            assert own is cells
            return model

    found = bounded(Drawn(), cells)  # type: ignore[arg-type]
    assert found.cells is cells
    for i in range(count):
        spread = np.abs(model.c1[i]).sum(-1) + model.r[i]
        spread[:rows] += np.abs(model.c2[i]).sum((-1, -2))
        low, high = model.c0[i] - spread, model.c0[i] + spread
        assert found.signs[i].tolist() == [1 if a > 0 else -1 if b < 0 else 0 for a, b in zip(low, high, strict=True)]
        assert found.split[i] in plain_split(cells[i], model.c1[i], model.c2[i], low, high)
        assert cells[i, 0, 0] - 1e-14 <= found.omega[i, 0] <= found.omega[i, 1] <= cells[i, 0, 1] + 1e-14
        if not np.isfinite(model.r[i, 0]) or low[1] <= 0 <= high[1]:
            assert found.omega[i, 0] <= cells[i, 0, 0] < cells[i, 0, 1] <= found.omega[i, 1]


@pytest.mark.parametrize("seed", range(4))
def test_where_the_slope_is_known_no_zero_of_a_drawn_parabola_lies_outside_of_what_is_left_of_its_cell(
    seed: int,
) -> None:
    """c0 + c1 t + t c2 t with its own slopes, over a cell of two sides: zeros along omega at many t of the other side."""
    rng = np.random.default_rng(seed)
    c1, c2 = rng.uniform(-1, 1, 2), rng.uniform(-0.3, 0.3, (2, 2))
    c2 = (c2 + c2.T) / 2
    c0 = rng.uniform(-0.5, 0.5)
    steep = 2.0 if rng.random() < 0.5 else -2.0
    c1[0] = steep

    def of(w: Model, p: Model, c: Callable[[float], Model]) -> Model:
        t, u = (x.times(2.0) - c(1.0) for x in (w, p))
        bent = (t * t).times(c2[0, 0]) + (t * u).times(2 * c2[0, 1]) + (u * u).times(c2[1, 1])
        return c(c0) + t.times(c1[0]) + u.times(c1[1]) + bent

    found = bounded(Form(of, 1), np.array([[[0.0, 1.0], [0.0, 1.0]]]))  # type: ignore[arg-type]
    assert found.signs[0, 1] == np.sign(steep)
    zeros = []
    for u in np.linspace(-1, 1, 41):
        roots = np.roots([c2[0, 0], c1[0] + 2 * c2[0, 1] * u, c0 + c1[1] * u + c2[1, 1] * u * u])
        zeros += [(1 + t.real) / 2 for t in roots if abs(t.imag) < 1e-12 and abs(t.real) <= 1]
    low, high = found.omega[0]
    assert zeros
    assert all(low - 1e-12 <= x <= high + 1e-12 for x in zeros)
    rest = abs(c1[1]) + abs(c2[1, 1]) + 1e-9
    least = abs(steep) - 2 * (abs(c2[0, 0]) + abs(c2[0, 1])) - 1e-9
    assert high - low <= (rest / least + abs(c0) * (1 / least - 1 / (2 * abs(steep) - least))) * 1.001 + 1e-9
