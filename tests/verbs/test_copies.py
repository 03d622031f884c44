"""Answers go through pools of processes and files on disk: a copy says all that the answer says."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from typing import Any

import pytest
from flint import Ordering, acb, arb, arb_mat, arb_poly, fmpq, fmpq_mpoly_ctx, fmpq_poly, fmpz_poly

import haptisym as hs
from haptisym.kernel.copies import packed, unpacked
from haptisym.verbs.jnd.answers import Answers, Row

ARM = hs.hands["postural-arm"]
ANSWERS: dict[str, Callable[[], Any]] = {
    "evaluate": lambda: hs.evaluate("fu2019", 20, tolerance="1 %"),
    "evaluate, delayed": lambda: hs.evaluate("delayed-spring").with_regions(),
    "evaluate, fractional": lambda: hs.evaluate("organ-tissue"),
    "evaluate_all": lambda: hs.evaluate_all("palpation-device"),
    "evaluate, measured": lambda: hs.evaluate("fu2019-bench"),
    "derive": lambda: hs.derive("fu2019"),
    "peaks": lambda: hs.peaks("fu2019"),
    "metrics": lambda: hs.metrics("delayed-spring"),
    "metrics, with a free response": lambda: hs.metrics("fu2019"),
    "relevance": lambda: hs.relevance("control-stick-in-detail"),
    "stability": lambda: hs.stability("delayed-spring", hand=ARM),
    "stability, neutral": lambda: hs.stability("satellite-contact", hand=ARM),
    "stability, with a clock": lambda: hs.stability("virtual-wall", hand=ARM),
    "sensitivity": lambda: hs.sensitivity("delayed-spring"),
    "require": lambda: hs.require("fu2019", "omega_n"),
    "require, of a delay": lambda: hs.require("delayed-spring", "tau", that=["transparent", "stable"], hand=ARM),
    "require, passive": lambda: hs.require("virtual-wall", "environment.b", that="passive"),
    "design_map": lambda: hs.design_map("fu2019", ["omega_n", "zeta"], [(60, 200), ("0.1", 1)]),
    "tolerances": lambda: hs.tolerances("fu2019-tolerances"),
    "sweep": lambda: hs.sweep("fu2019", {"omega_n": [50, 100]}),
    "check": lambda: hs.check("fu2019"),
    "release": lambda: hs.release("delayed-spring", "1 cm", ARM),
    "cost": lambda: hs.cost("fu2019"),
    "published": hs.published,
    "jnd": lambda: hs.jnd(
        Answers("answers", tuple(Row(x, k, 40) for x, k in [(4.4, 5), (4.7, 11), (5.0, 19), (5.3, 26), (5.6, 33)]))
    ),
    "identify": lambda: hs.identify("fu2019-clipped-bench", effects=["second-order-lowpass"]),
}


def says(answer: Any) -> str:
    return str(answer.to_json() if hasattr(answer, "to_json") else answer)


@pytest.mark.slow
@pytest.mark.parametrize("asked", ANSWERS)
def test_a_pickled_answer_of_every_verb_says_the_same(asked: str) -> None:
    answer = ANSWERS[asked]()
    told = says(answer)
    for other in (pickle.loads(pickle.dumps(answer)), copy.copy(answer), copy.deepcopy(answer)):
        assert type(other) is type(answer)
        assert says(other) == told
    assert says(answer) == told  # nothing was taken from the answer itself


@pytest.mark.slow
def test_answers_come_back_from_other_processes() -> None:
    scenes = ["fu2019", "delayed-spring"]
    with ProcessPoolExecutor(2, get_context("spawn")) as pool:
        assert [*map(says, pool.map(hs.stability, scenes))] == [says(hs.stability(x)) for x in scenes]
        [found] = pool.map(hs.require, ["delayed-spring"], ["tau"])
    assert str(found) == str(hs.require("delayed-spring", "tau"))


def test_numbers_of_flint_come_back_with_all_of_their_digits() -> None:
    third = arb(1) / 3
    for x in (third, arb(-7), arb(0), third * arb(2) ** 900, arb(2, 0.5)):
        again = unpacked(packed(x))
        assert again.mid() == x.mid()
        assert x.rad() <= again.rad() <= x.rad() * arb("1.00000001")
    for x in (arb.pos_inf(), arb.neg_inf(), arb.nan(), arb(2, arb.pos_inf())):
        again = unpacked(packed(x))
        assert (again > 0, again < 0, again.is_nan()) == (x > 0, x < 0, x.is_nan())
        assert (str(again.mid()), str(again.rad())) == (str(x.mid()), str(x.rad()))
    with_terms = fmpq_mpoly_ctx.get(("x0", "x1"), Ordering.lex)
    x, y = with_terms.gens()
    for exact in (fmpq(2, 3), fmpq_poly([1, 0, 2]), fmpz_poly([3, 4]), x**2 / 3 - y, with_terms.constant(0)):
        again = unpacked(packed(exact))
        assert type(again) is type(exact)
        assert again == exact
    assert unpacked(packed(with_terms)) is with_terms
    matrix, row, z = arb_mat([[1, 2], [third, 4], [5, 6]]), arb_poly([1, third]), acb(third, -1)
    assert str(unpacked(packed(matrix))) == str(matrix)
    assert str(unpacked(packed(row))) == str(row)
    assert str(unpacked(packed(z))) == str(z)
