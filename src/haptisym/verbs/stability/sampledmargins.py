"""Gain and delay margins of a sampled loop: for which factors on the rendered force, and for which
further delays, it is stable in a hand.

The factor multiplies the controller's numerator, the delay is added to all delays of the plant: an
open parameter of the loop either way, searched outward from 1 or 0 as in ``sampled``.
"""

from __future__ import annotations

from dataclasses import replace

from sympy import Expr, Integer, Symbol

from haptisym.judge.bindings import stable_in
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.sampledloop import SampledLoop
from haptisym.kernel.sets import Domain, ValueSet, solve
from haptisym.model.catalogue import Hand
from haptisym.model.scene import Scene
from haptisym.verbs.stability.clockedloop import loop_of, series_alone
from haptisym.verbs.stability.opened import Opened
from haptisym.verbs.stability.sampled import OutwardSearch, question_of


def factors(scene: Scene, hand: Hand, asked: Domain) -> ValueSet:
    """The factors on the force, about 1, for which the loop is stable. UndecidedError where more
    than series effects lie before the clock."""
    g = Symbol("g_margin", positive=True)
    loop = _loop(scene, hand)
    return _found(replace(loop, above=tuple(g * x for x in loop.above)), g, Integer(1), hand, asked)


def delays(scene: Scene, hand: Hand, asked: Domain) -> ValueSet:
    """The delays, s, from 0 on, that may be added so that the loop stays stable."""
    late = Symbol("tau_margin", positive=True)
    loop = _loop(scene, hand)
    terms = tuple((lag + late, row) for lag, row in loop.plant.terms)
    return _found(
        replace(loop, plant=replace(loop.plant, terms=terms)), late, Integer(0), hand, asked
    )


def _loop(scene: Scene, hand: Hand) -> SampledLoop:
    if not series_alone(scene):
        raise UndecidedError("margins of a loop with more than series effects before the clock")
    return loop_of(scene, hand)


def _found(loop: SampledLoop, symbol: Symbol, own: Expr, hand: Hand, asked: Domain) -> ValueSet:
    assert asked.low is not None
    assert asked.high is not None
    search = OutwardSearch(Opened(loop, symbol), own, asked, (asked.low, asked.high), near=True)
    return solve(question_of(lambda: search, own, stable_in(hand)), asked, near=True)
