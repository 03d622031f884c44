"""How far crossings go over a box: on faces of a world whose one crossing is bilinear in two parameters, extreme at corners."""

from __future__ import annotations

from fractions import Fraction
from itertools import product
from random import Random
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from sympy import Rational

from haptisym.kernel.reals import ExactNumber
from haptisym.verbs.tolerances import ends
from haptisym.verbs.tolerances.box import Side
from haptisym.verbs.tolerances.ends import Face, end_of
from haptisym.verbs.tolerances.search import Cluster
from haptisym.verbs.tolerances.single import One

SIDES = (Side("p", Rational(1), Rational(3)), Side("q", Rational(-1), Rational(0)))
LOW, HIGH = Rational(2), Rational(12)


class World:
    """A crossing at the share a + b p + c q + d p q of the band, by shares p and q; ``slope`` : of the excess there."""

    def __init__(self, pick: Random) -> None:
        self.b, self.c, self.d = (Fraction(pick.randint(-8, 8), 100) for _ in range(3))
        self.a, self.slope = Fraction(1, 2), pick.choice([-1, 1])
        self.asked: list[Any] = []

    def at(self, shares: Any) -> Fraction:
        p, q = Fraction(shares["p"]), Fraction(shares["q"])
        return self.a + self.b * p + self.c * q + self.d * p * q

    def corners(self, fixed: Any) -> list[dict[str, Fraction]]:
        choices = [[fixed[x]] if x in fixed else [Fraction(0), Fraction(1)] for x in "pq"]
        return [dict(zip("pq", x, strict=True)) for x in product(*choices)]

    def signs(self, fixed: Any) -> tuple[int, ...]:
        """Of the slopes of the excess on a face: by omega, and by each side that is not fixed; 0 where it changes or is 0."""
        found = [self.slope]
        for name, own, other in (("p", self.b, "q"), ("q", self.c, "p")):
            if name not in fixed:
                rates = [own + self.d * y for y in ([fixed[other]] if other in fixed else [0, 1])]
                found.append(-self.slope * ((min(rates) > 0) - (max(rates) < 0)))
        return tuple(found)

    def cluster(self, fixed: Any) -> Cluster:
        places = [float(self.at(x)) for x in self.corners(fixed)]
        cells = np.zeros((1, 3 - len(fixed), 2))
        return Cluster(cells, self.signs(fixed), min(places) - 0.01, max(places) + 0.01)

    def one(self, values: Any) -> One:
        shares = {x.name: Fraction(str((values[x.name] - x.low) / (x.high - x.low))) for x in SIDES}
        share = self.at(shares)
        omega = LOW + Rational(share.numerator, share.denominator) * (HIGH - LOW)
        far = ExactNumber(Rational(11))  # another crossing, which is none of the cluster
        return One(values, {"real": (ExactNumber(omega), far), "imag": ()}, None, None)


def box() -> Any:
    return SimpleNamespace(sides=SIDES, scene=SimpleNamespace(band=(LOW, HIGH)))


def on_faces(world: World, monkeypatch: pytest.MonkeyPatch) -> None:
    """Faces, their forms and clusters are those of the world; nothing lies beyond what is reached."""

    def beyond(form: Any, cells: Any, reached: float, *, highest: bool) -> float:
        assert cells.shape[1] == 3 - len(form.fixed)
        world.asked.append(reached)
        return reached

    def clusters(form: Any, within: Any) -> tuple[Cluster, ...]:
        known = [world.cluster(x) for x in ({}, *({y: form.fixed[y]} for y in form.fixed))]
        assert within in [(x.low, x.high) for x in known]
        return (world.cluster(form.fixed),)

    def form(face: Face) -> Any:
        return SimpleNamespace(fixed=dict(face.fixed), matters=np.ones(3 - len(face.fixed), bool))

    monkeypatch.setattr(ends, "beyond", beyond)
    monkeypatch.setattr(ends, "clusters", clusters)
    monkeypatch.setattr(Face, "form", property(form))
    monkeypatch.setattr(
        Face, "box", property(lambda x: SimpleNamespace(sides=[y for y in SIDES if y.name not in x.fixed]))
    )


@pytest.mark.parametrize("highest", [True, False])
@pytest.mark.parametrize("seed", range(20))
def test_an_end_is_exact_at_its_corner_where_one_side_after_the_other_is_known_to_move_it(
    seed: int, monkeypatch: pytest.MonkeyPatch, *, highest: bool
) -> None:
    """Else it is what the best corner reaches and a thousandth more, but not beyond the cluster."""
    world = World(Random(seed))
    on_faces(world, monkeypatch)
    whole = world.cluster({})
    best = (max if highest else min)(world.corners({}), key=world.at)
    true = float(LOW) + float(world.at(best)) * 10
    criterion: Any = SimpleNamespace(name="real")
    form: Any = SimpleNamespace(fixed={}, matters=np.ones(3, bool))
    found, corner = end_of(box(), criterion, form, whole, world.one, highest=highest)
    known = [x for x in whole.signs[1:] if x]
    exact = len(known) == 2
    if len(known) == 1:  # then the other one is known on that face, unless it does nothing there
        first = "p" if whole.signs[1] else "q"
        exact = 0 not in world.signs({first: best[first]})
    if exact:
        assert corner == {x.name: x.at(best[x.name]) for x in SIDES}
        assert float(found) == pytest.approx(true, rel=1e-15)
        assert world.asked == []
    else:
        out = 1 if highest else -1
        limit = whole.high if highest else whole.low
        assert corner is None
        assert [x * 10 + 2 for x in world.asked] == [pytest.approx(true * (1 + out * 1e-3), rel=1e-13)]
        farthest = (min if highest else max)(true * (1 + out * 1e-3), limit * 10 + 2)
        assert float(found) == pytest.approx(farthest)


@pytest.mark.parametrize("highest", [True, False])
def test_without_a_crossing_at_its_one_corner_a_cluster_inside_the_band_has_none_and_ends_where_it_does(
    monkeypatch: pytest.MonkeyPatch, *, highest: bool
) -> None:
    world = World(Random(1))
    on_faces(world, monkeypatch)

    def none(values: Any) -> One:
        return One(values, {"real": ()}, None, None)

    criterion: Any = SimpleNamespace(name="real")
    form: Any = SimpleNamespace(fixed={}, matters=np.ones(3, bool))
    cells = np.zeros((1, 3, 2))
    for low, high, inside in ((0.25, 0.75, True), (0.0, 0.75, False), (0.25, 1.0, False)):
        own = Cluster(cells, (1, 1, -1), low, high)
        face = Face(box(), "real", {}, none)
        found = face.end(form, own, highest=highest)
        share = high if highest else low
        assert (found is None) is inside
        if found is not None:
            assert (float(found[0]), found[1]) == (2 + 10 * share, None)
        end, corner = end_of(box(), criterion, form, own, none, highest=highest)
        assert (float(end), corner) == (2 + 10 * share, None)
    loose = Cluster(cells, (0, 1, -1), 0.25, 0.75)  # the slope by omega does not keep its sign: all corners are tried
    end, corner = end_of(box(), criterion, form, loose, world.one, highest=highest)
    assert corner is None
    assert len(world.asked) == 1


def test_a_side_that_does_not_matter_is_taken_at_its_low_end_and_hinders_nothing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    world = World(Random(3))
    world.b, world.c, world.d = Fraction(1, 10), Fraction(0), Fraction(0)
    on_faces(world, monkeypatch)
    form: Any = SimpleNamespace(fixed={}, matters=np.array([True, True, False]))
    for highest, p in ((True, 3), (False, 1)):
        criterion: Any = SimpleNamespace(name="real")
        _, corner = end_of(box(), criterion, form, world.cluster({}), world.one, highest=highest)
        assert corner == {"p": p, "q": -1}


@pytest.mark.parametrize("highest", [True, False])
def test_of_several_crossings_on_a_face_the_farthest_that_is_there_is_the_end(
    monkeypatch: pytest.MonkeyPatch, *, highest: bool
) -> None:
    """On a face one cluster without a crossing below the world's, one with that of 11 rad/s above it, and one without beyond."""
    world = World(Random(3))
    world.b, world.c, world.d = Fraction(1, 10), Fraction(-1, 100), Fraction(3, 100)  # q moves it one way or the other
    on_faces(world, monkeypatch)
    cells = np.zeros((1, 2, 2))
    others = [Cluster(cells, (1, 1), *x) for x in ((0.1, 0.12), (0.89, 0.91), (0.95, 0.96))]
    monkeypatch.setattr(ends, "clusters", lambda form, _: (others[0], world.cluster(form.fixed), others[1], others[2]))
    face = Face(box(), "real", {}, world.one)
    form: Any = SimpleNamespace(fixed={}, matters=np.ones(3, bool))
    found = face.end(form, world.cluster({}), highest=highest)
    assert found is not None
    least = 2 + 10 * float(min(world.at(x) for x in world.corners({"p": Fraction(0)})))
    assert float(found[0]) == pytest.approx(11 if highest else least, rel=1e-15)
