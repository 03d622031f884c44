"""Questions that take long, or that once broke: a limit in time, what is proven when it is spent, and no exception but ours."""

from __future__ import annotations

import pytest
from sympy import Rational

import haptisym as hs
from haptisym.requirement.question import require

# Long delays: one that is free, beside other things that turn


@pytest.mark.parametrize("name", ["organ-tissue", "sampled-wall"])
def test_a_free_delay_beside_other_angles_is_answered(name: str) -> None:
    """Both scenes are noticed without any delay, and no delay mends that."""
    found = require(hs.load_scene(name), "tau")
    assert (found.feasible, found.undecided) == ((), ())
    for tau in (0, Rational(1, 1000), Rational(1, 10), 3):
        assert hs.evaluate(hs.load_scene(name).with_values({"tau": Rational(tau)})).crossings
