"""The stiffest wall for each virtual damping: the exact boundary, classical lines beside it, contours of the JND."""

from __future__ import annotations

import json
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from random import Random

import pytest
from click.testing import CliRunner
from matplotlib.figure import Figure
from sympy import Rational

import haptisym as hs
from haptisym import effects, environments
from haptisym.cli import app
from haptisym.figures.wishes import draw_wishes
from haptisym.kernel.errors import SceneError
from haptisym.verbs.require.classical import Encoder, Line, lines
from haptisym.verbs.require.slices import Slice

NOTHING = hs.Hand("nothing")
PLANE = ["environment.b", "environment.k"]


def wall(b: object = "0.8 N*s/m", B: object = 0, delay: int = 0, k: object = 1000) -> hs.Scene:
    """A wall behind a clock of 1 ms on a device of 0.04 kg."""
    loop = hs.effects.sampled_loop(T="1 ms", method="backward-difference", delay=delay)
    device = hs.effects.shunt(m="0.04 kg", b=b, name="device") if b else hs.effects.shunt(m="0.04 kg", name="device")
    return hs.Scene(hs.environments.kelvin_voigt(k, B), (loop, device), ("0 Hz", "10 Hz"))


def abbott(scene: hs.Scene, free: list[str]) -> list[Line]:
    encoder = Encoder.of(scene, "0.05 N", "61.4 um")
    return [x for x in lines(scene, [scene.knobs[y] for y in free], encoder) if x.name == "Abbott and Okamura"]


@pytest.mark.slow
def test_the_boundary_of_an_undamped_device_is_the_closed_form() -> None:
    """alpha = 2 beta (2 - beta)/(2 + beta) with alpha = K T^2/m and beta = B T/m; the largest is 12 - 8 sqrt 2, at 2 sqrt 2 - 2."""
    scene = wall(b=0, B=1)
    found = hs.design_map(scene, PLANE, [(1, 79), (1, 40_000)], that=["stable"], hand=NOTHING, slices=4)
    for x in found.slices:
        beta = x.at / 40
        [span] = x.requirement.feasible
        assert float(span.high.value) == pytest.approx(float(40_000 * 2 * beta * (2 - beta) / (2 + beta)), rel=1e-13)
    assert found.stiffest is not None
    at, top = found.stiffest
    assert at.at == 27
    assert float(top) < 40_000 * 0.686291501015240
    assert "27451" not in str(found)
    assert f"below k = {float(top):.5g} N/m, at b = 27 N·s/m" in " ".join(str(found).split())


@pytest.mark.slow
def test_the_stiffest_wall_is_not_named_where_the_range_ends_before_it() -> None:
    found = hs.design_map(wall(b=0, B=1), PLANE, [(1, 79), (1, 500)], that=["stable"], hand=NOTHING, slices=3)
    assert found.stiffest is None
    assert "stiffest" not in str(found)


def test_abbott_and_okamura_is_the_bound_of_the_field() -> None:
    """f_c = 0.05 N, Delta = 61.4 um: 1628.66 N/m, whatever the damping of the device."""
    [line] = abbott(wall(), ["effects.device.b", "environment.k"])
    assert line.where == ()
    for b in (0.1, 3):
        assert -line.excess({"environment.k": 0.0, "effects.device.b": b}) == pytest.approx(1628.664495, rel=1e-9)
    assert "B = 0" in line.assumes
    assert "0.05" in line.assumes


def test_abbott_and_okamura_is_there_only_where_it_is_defined() -> None:
    device = ["effects.device.b", "environment.k"]
    assert abbott(wall(B=1), device) == []
    assert abbott(wall(delay=1), device) == []
    assert abbott(hs.load_scene("delayed-spring"), ["tau", "environment.k"]) == []
    assert abbott(wall(), ["effects.device.b", "effects.device.m"]) == []
    [line] = abbott(wall(B=1), PLANE)
    assert line.where == (("environment.b", 0.0),)


@pytest.mark.parametrize("B", [-0.3, 0.0, 0.5])
def test_colgate_and_schenkels_bound_counts_damping_of_either_sign_against_the_device(B: float) -> None:
    """K < 2 (b - |B|)/T, b = 0.8 and T = 1 ms."""
    [line] = [x for x in lines(wall(), [wall().knobs[y] for y in PLANE]) if x.name == "Colgate and Schenkel"]
    assert line.excess({"environment.k": 1000.0, "environment.b": B}) == pytest.approx(1000 - 2000 * (0.8 - abs(B)))


def test_a_device_that_is_a_formula_is_in_no_classical_bound_whatever_its_numbers_are_called() -> None:
    for formula, count in (("b*s^2", 0), ("b*s + q", 0), ("3*s", 0), ("b*s + m*s^2", 2)):
        given = {x: 1 for x in "bqm" if x in formula.replace("s", "")}
        scene = hs.Scene(
            hs.environments.kelvin_voigt(500, 1),
            (hs.effects.sampled_loop("1 ms", "backward-difference"), hs.effects.shunt(Z=formula, parameters=given)),
            hands=(hs.Hand("own", m=1, b=1, k=1),),
        )
        assert len(lines(scene, [scene.knobs["environment.k"]])) == count, formula


def test_a_rendered_mass_is_in_no_classical_bound() -> None:
    scene = hs.Scene(hs.environments.mass_spring_damper(m=1, k=1000), wall().effects)
    assert lines(scene, [scene.knobs["environment.k"]]) == ()


@pytest.mark.slow
def test_contours_are_the_requirements_with_other_thresholds(tmp_path: Path) -> None:
    scene = hs.Scene(
        hs.environments.kelvin_voigt(300, 1),
        (hs.effects.first_order_lag(300), hs.effects.shunt(m="0.04 kg", b="0.8 N*s/m")),
        (0, 10),
        hands=(hs.Hand("own", m="0.1 kg", b="0.2 N*s/m"),),
    )
    asked = {"that": ["transparent", "stable"], "jnd": ["5 %", 0.2, "0.05"], "slices": 3}
    found = hs.design_map(scene, PLANE, [(0, 2), (1, 1000)], **asked)  # type: ignore[arg-type]
    assert found.thresholds == (Rational(1, 20), Rational(1, 5))
    for x in found.slices:
        for c, own in zip(found.thresholds, x.contours, strict=True):
            here = scene.with_values({"environment.b": x.at, "evaluation.jnd": c})
            assert own.feasible[0].low.value.digits(15) == hs.require(here, "environment.k", (1, 1000)).feasible[
                0
            ].low.value.digits(15)
    row = json.loads(found.to_json())
    assert [y["jnd"] for y in row["slices"][0]["contours"]] == [0.05, 0.2]
    found.save_figure(tmp_path / "z.png")
    count = len(found.slices)
    assert f"With a threshold of 5 % {count} of them" in " ".join(str(found).replace("\xa0", " ").split())


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"friction": "0.05 N"}, "resolution is missing"),
        ({"friction": "0.05 N", "resolution": 0}, "must be > 0"),
        ({"friction": "0.05 N*m", "resolution": "1 um"}, "friction: 0.05 N*m is rotational"),
        ({"friction": "0.05 N", "resolution": "1 um"}, "which is not defined here"),
        ({"jnd": ["0.05"]}, "jnd: further thresholds are of what is noticed"),
    ],
)
def test_what_makes_no_sense_is_said(asked: dict[str, object], said: str) -> None:
    with pytest.raises(SceneError, match=said.replace("*", r"\*")):
        hs.design_map(wall(delay=1), PLANE, [(1, 9), (1, 99)], that=["stable"], hand=NOTHING, slices=3, **asked)  # type: ignore[arg-type]


def test_a_map_of_a_sampled_loop_says_what_time_did_not_last_for() -> None:
    found = hs.design_map(wall(), PLANE, [(1, 9), (1, 99)], slices=3, limit=1e-9)
    assert not found.certified
    assert str(found).count("UNDECIDED") == 4


def test_the_command_line_takes_what_belongs_to_a_map_with_a_map_alone() -> None:
    said = CliRunner().invoke(app, ["require", "virtual-wall", "--free", "environment.k", "--jnd", "0.05"])
    assert "--jnd is about a map of two parameters" in str(said.exception)
    said = CliRunner().invoke(app, ["require", "virtual-wall", "--free", "environment.k", "--friction", "1"])
    assert "it needs --resolution" in str(said.exception)


@pytest.mark.slow
def test_no_line_closes_a_set_between_slices_and_what_lies_between_unlike_ones_is_hatched() -> None:
    """Where a set ends between two slices is not known: a line halfway claimed a place."""
    ranges = [("0.2", "0.9"), (50, 100)]
    found = hs.design_map("fu2019", ["zeta", "omega_n"], ranges, slices=3, jnd=["0.2"])
    bare = replace(found, proofs=())
    unlike = {(float(a.at), float(b.at)) for a, b in pairwise(found.slices) if ends(a) != ends(b)}
    assert unlike
    assert (closings(found), hatched(found)) == (0, set())  # a band in which the boundary lies is proven
    assert (closings(bare), hatched(bare)) == (0, unlike)
    open_ = tuple(
        replace(x, requirement=unknown(x.requirement), contours=tuple(map(unknown, x.contours))) for x in found.slices
    )
    assert closings(replace(bare, slices=open_)) == 0
    assert not hatched(replace(bare, slices=open_)) & unlike


def ends(x: Slice) -> tuple[int, ...]:
    return tuple(len(r.feasible) for r in (x.requirement, *x.contours))


def unknown(r: hs.Requirement) -> hs.Requirement:
    return replace(r, feasible=(), undecided=((None, None),))


def closings(found: hs.DesignMap) -> int:
    """Lines of the figure that stand upright between two slices."""
    ax = Figure().add_subplot()
    draw_wishes(ax, found)
    return sum(len(set(map(float, line.get_xdata()))) == 1 < len(line.get_xdata()) for line in ax.lines)


def hatched(found: hs.DesignMap) -> set[tuple[float, float]]:
    """From where to where strips of the figure are hatched."""
    ax = Figure().add_subplot()
    draw_wishes(ax, found)
    boxes = [x.get_paths()[0].get_extents() for x in ax.collections if x.get_hatch()]
    return {(float(x.x0), float(x.x1)) for x in boxes}


# --- the bounds of random walls -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(6))
def test_classical_bounds_are_those_of_the_field_for_any_wall_and_depend_on_what_is_free(seed: int) -> None:
    """K < (b + b_hand + B)/(T/2 + t_d), K < 2 (b - |B|)/T without delay, K < 2 f_c/Delta of a spring alone: written once more."""
    pick = Random(seed)
    for _ in range(6):
        T, tau = (pick.choice([Rational(0), Rational(pick.randint(1, 9), 1000)]) for _ in range(2))
        late, hold = pick.choice([0, 1, 2]), pick.random() < 0.5
        K, B, b = Rational(pick.randint(1, 900)), Rational(pick.choice([0, 1, 3]), 4), Rational(pick.randint(0, 20), 4)
        clock = (
            effects.zero_order_hold(T or 1, name="clock")
            if hold
            else effects.sampled_loop(T or 1, "tustin", late, name="clock")
        )
        parts = [clock] if T else []
        parts += [effects.delay(tau, name="link")] if tau else []
        count = pick.randint(1, 2)
        devices = [effects.shunt(m="0.1", b=x, name=f"device{i}") for i, x in enumerate((b, Rational(1, 2))[:count])]
        hands = tuple(hs.Hand(f"hand{n}", m="0.2", b=Rational(n + 1), k=3) for n in range(pick.randint(0, 2)))
        wall = environments.kelvin_voigt(K, B) if pick.random() < 0.5 else environments.mass_spring_damper(0, B, K)
        scene = hs.Scene(wall, (*parts, *devices), ("0 Hz", "10 Hz"), hands=hands)
        known = [x.path for x in scene.knobs if x.path.startswith(("environment.", "effects.", "hand"))]
        free = pick.sample([x for x in known if x != "environment.m"], 2)
        encoder = Encoder.of(scene, "0.5 N", "1/1000 m") if pick.random() < 0.6 else None
        found = {x.name: x for x in lines(scene, [scene.knobs[x] for x in free], encoder)}
        held = {x for x in known if x.startswith("hand") and x.endswith(".b") and "hand1" not in x}
        at = {"environment.k": K, "environment.b": B, "effects.device0.b": b, **dict.fromkeys(held, 1)}
        at |= {"effects.clock.T": T} if T else {}
        at |= {"effects.link.tau": tau} if tau else {}
        at |= {"effects.device1.b": Rational(1, 2)} if count == 2 else {}
        moving, late = {x for x in free if x in at}, 0 if hold else late
        plain = T > 0 and not tau and not late
        names = {"Gil and Hulin"} if (T or tau) and moving else set()
        names |= {"Colgate and Schenkel"} if plain and moving else set()
        spring = "environment.k" in free and plain and (not B or "environment.b" in free)
        assert set(found) == names | ({"Abbott and Okamura"} if spring and encoder else set())
        given = {x: pick.randint(1, 9) / 7 for x in free}
        new = {x: given.get(x, float(v)) for x, v in at.items()}
        k, B2, T2 = new["environment.k"], new["environment.b"], new.get("effects.clock.T", 0.0)
        damping = sum(new.get(f"effects.device{i}.b", 0.0) for i in range(2))
        wait = T2 / 2 + late * T2 + new.get("effects.link.tau", 0.0)
        expected = {"Abbott and Okamura": 1000.0}
        if names:
            expected["Gil and Hulin"] = (damping + sum(new[x] for x in held) + B2) / wait
            expected["Colgate and Schenkel"] = 2 * (damping - abs(B2)) / T2 if T2 else 0.0
        for name, line in found.items():
            assert line.excess(given) == pytest.approx(k - expected[name], rel=1e-12)
            assert line.where == (
                (("environment.b", 0.0),) if spring and name[0] == "A" and "environment.b" in free else ()
            )
