"""The pages of simulations and of releases, of answers put together by hand: each fact, row and verdict."""

from __future__ import annotations

from math import pi
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from pagewords import flat, lines, row

import haptisym as hs
from haptisym.kernel.rootcount import RootChain, Roots
from haptisym.pages import release as release_page
from haptisym.verbs.simulate.results import Estimate, Simulations
from haptisym.verbs.stability.held import Held
from haptisym.writing.document import figures_of
from haptisym.writing.plain import plain

SPRING = hs.environments.mass_spring_damper(k=100)
SCENE = hs.Scene(SPRING, (hs.effects.delay("10 ms"),), (0, 15), "0.1")
TURNED = hs.Scene(hs.environments.mass_spring_damper(k="2 N*m/rad"), (hs.effects.delay("10 ms"),), (0, 15), "0.1")


# Simulations


def simulated(
    *estimates: Estimate, force: tuple[float, ...] = (0.0, -3.0, 2.0), end: float = 1.25, scene: hs.Scene = SCENE
) -> hs.Simulation:
    t = np.array([0.0, end / 2, end])
    return hs.Simulation(
        scene,
        hs.sine("2 cm" if scene is SCENE else "0.02 rad", 5),
        t,
        t,
        np.array(force),
        t,
        t,
        estimates,
        ("spring", "delay"),
        (),
        (),
    )


AGREES, DIFFERS = Estimate(5.0, 3 + 4j, 3 + 4.5j, 1.0), Estimate(2 * pi, 1.25 + 2j, 1 + 2j, 0.125)


def drawn(found: Any) -> list[str]:
    """Names of the figures in full."""
    return [x.name for x in figures_of(found.document().blocks)]


def test_a_simulation_tells_the_largest_force_of_all_its_runs_and_the_longest_time() -> None:
    runs = [simulated(AGREES, force=(1.0, 2.0, -7.5), end=2.5), simulated(DIFFERS, force=(5.0, 0.0, 1.0), end=1.0)]
    for several in (runs, runs[::-1]):
        found = Simulations(several)
        assert row(found, "force") == "up to 7.5 N at the hand"
        assert row(found, "time") == "0 to 2.5 s"
        assert row(found, "motion") == "sine, 2 runs, up to 0.02 m"
        assert row(found, "simulated") == "spring, delay"
    assert row(simulated(force=(-2.0, 1.0, 0.0)), "force") == "up to 2 N at the hand"
    assert row(simulated(), "motion") == "sine, up to 0.02 m"
    assert row(simulated(scene=TURNED), "motion") == "sine, up to 0.02 rad"
    assert row(simulated(scene=TURNED), "force") == "up to 3 N·m at the hand"


def test_what_is_recovered_is_drawn_only_where_some_run_recovers_anything() -> None:
    bare, whole = (
        ["simulated-time", "simulated-loop"],
        ["simulated-time", "simulated-loop", "recovered-real", "recovered-imag"],
    )
    assert drawn(simulated()) == bare
    assert drawn(simulated(AGREES)) == whole
    assert drawn(Simulations([simulated(), simulated(AGREES)])) == whole
    assert drawn(Simulations([simulated(), simulated()])) == bare


def test_a_row_has_both_parts_what_the_closed_form_is_off_by_and_whether_that_is_within_the_error() -> None:
    found = simulated(AGREES, DIFFERS, Estimate(7.0, 1 - 2j, 2 - 2j, 0.25, "it rattles"), scene=TURNED)
    shown = lines(found)
    for line in ("5 0.7958 3 4 0.5 1 yes", "6.283 1 1.25 2 0.25 0.12 NO", "7 1.114 1 -2 1 0.25 -"):
        assert shown.count(line) == 1, line
    long = simulated(Estimate(1.23456789, -12.3456789876 + 0.0123456789876j, -12.3456789876 + 0.0246913j, 0.0123999))
    assert "1.235 0.1965 -12.345679 0.012345679 0.012 0.012 yes" in lines(long)
    assert "H_perc recovered from the force, N·m/rad" in shown
    assert "rad/s Hz Re simulated Im simulated from closed error up to agrees" in shown


def test_a_verdict_names_every_reason_once_and_the_largest_share_of_those_that_are_not_exact() -> None:
    rattles = [
        Estimate(5.0, 1.1, 1, 9.0, "it rattles"),
        Estimate(6.0, 2.5, -2, 9.0, "it rattles"),
        Estimate(7.0, 9, 0, 0.0, "it creaks"),
    ]
    text = flat(simulated(*rattles, Estimate(8.0, 9, 1, 0.0)))
    assert text.endswith("The closed form is not exact here: it rattles; it creaks; it differs by up to 2.2e+02 %.")
    assert flat(simulated(rattles[2])).endswith("not exact here: it creaks.")
    wrong = [Estimate(float(n), 1, 2, 0.5) for n in (3, 4, 5)]
    assert flat(simulated(*wrong, AGREES)).endswith("Simulation and closed form DISAGREE at 3, 4 and 5 rad/s.")
    assert flat(simulated(AGREES)).endswith("agree within the estimated error of the simulation at every frequency.")
    assert flat(simulated()).endswith("No ratio is recovered from this motion or from so short a run.")


# Releases


def released(scene: hs.Scene = SCENE, **own: Any) -> str:
    """The page of a release that came out so, on one line."""
    hand = (
        hs.Hand("tight", m="0.5 kg", b=2, k="300 N/m")
        if scene is not TURNED
        else hs.Hand("tight", m="0.5 kg*m^2", b="2 N*m*s/rad", k="3 N*m/rad")
    )
    root = SimpleNamespace(certified=True, digits=lambda: ("-1.2345", "6.789"))
    given = {
        "scene": scene, "hand": hand, "displacement": 0.0123456789, "unit": "m", "time": np.array([0.0, 2.34567]), "built": ("spring", "delay"), "stopped": "",
        "fitted": SimpleNamespace(rate=-1.2345678912345, omega=6.78912345678), "error": 0.0123, "is_envelope": False, "grows": False, "approximate": "",
        "closed": SimpleNamespace(root=root, rate=-1.2345, omega=6.789, chain=None), "agrees": True, "sign_agrees": True,
        "held": Held(hand, Roots(0, 0)), "asides": list, "figure": None,
    }  # fmt: skip
    return plain(release_page.page(SimpleNamespace(**(given | own))))  # type: ignore[arg-type]


def test_a_release_tells_the_hand_the_displacement_and_the_time_until_it_was_stopped() -> None:
    page = released()
    assert row(page, "hand") == "tight: m = 0.5 kg, b = 2 N·s/m, k = 300 N/m"
    assert row(page, "held at") == "0.0123457 m, at rest, then let go"
    assert row(page, "time") == "0 to 2.346 s"
    assert row(page, "simulated") == "spring, delay"
    assert row(released(stopped="decayed"), "time") == "0 to 2.346 s, when it had decayed"
    assert row(released(TURNED), "hand") == "tight: m = 0.5 kg·m², b = 2 N·m·s/rad, k = 3 N·m/rad"


def test_the_motion_that_lasts_longest_is_told_as_read_and_by_its_root() -> None:
    page = released()
    assert row(page, "read from the motion") == "-1.23456789 6.78912346 0.012"
    assert row(page, "rightmost root") == "-1.2345 6.789 proven"
    doubtful = SimpleNamespace(
        root=SimpleNamespace(certified=False, digits=lambda: ("-1", "2")), rate=-1.0, omega=2.0, chain=None
    )
    assert row(released(closed=doubtful), "rightmost root").startswith("-1 2 not proven to be the")
    envelope = released(is_envelope=True)
    assert row(envelope, "read from the motion") == "-1.23456789 - 0.012"
    assert "rightmost root" not in envelope
    assert "what lasts longest" not in released(fitted=None, closed=None)
    assert "read from the motion" not in released(fitted=None)
    assert "rightmost root" not in released(closed=None)


def test_infinitely_many_roots_are_told_with_the_rate_that_theirs_tend_to() -> None:
    for chain, told in ((-2.5, "-2.5"), (None, "0")):
        closed = SimpleNamespace(root=None, rate=-1.0, omega=2.0, chain=chain)
        text = " ".join(released(is_envelope=True, closed=closed).split())
        assert (
            f"The closed form has infinitely many roots, whose rates tend to {told} 1/s: no single one lasts longest"
            in text
        )
    assert "infinitely many roots, whose" not in " ".join(released().split())
    assert "infinitely many roots, whose" not in " ".join(released(is_envelope=True, closed=None).split())


@pytest.mark.parametrize(
    ("roots", "told"),
    [
        (Roots(0, 0), "stable, no root has Re s ≥ 0."),
        (Roots(2, 2), "NOT stable."),
        (
            Roots(None, None, (), RootChain.NEAR),
            "NOT stable, infinitely many roots come as near to the axis as one likes, far above what a release moves.",
        ),
        (Roots(None, None, (), RootChain.RIGHT), "NOT stable."),
        (None, "not decided (too long)."),
    ],
)
def test_what_the_closed_form_says_of_this_hand_is_told_beside_the_motion(roots: Roots | None, told: str) -> None:
    hand = hs.Hand("tight", m="0.5 kg", b=2, k="300 N/m")
    text = " ".join(released(held=Held(hand, roots, "" if roots else "too long")).replace("\xa0", " ").split())
    assert f"Held in this hand, by the closed form (H_perc + m s^2 + b s + k): {told}" in text


def test_a_loop_with_a_clock_has_its_roots_at_z() -> None:
    clocked = hs.Scene(SPRING, (hs.effects.sampled_loop("10 ms", "tustin"),), (0, 15), "0.1", rendered=SPRING)
    text = " ".join(released(clocked).split())
    assert "by the closed form (the loop with its clock): stable, no root has |z| ≥ 1." in text
    assert "largest root z, ln z/T" in text
    assert "rightmost root" not in text


@pytest.mark.parametrize(
    ("own", "told"),
    [
        ({"grows": None}, "Whether the motion grows or dies away cannot be read from this run."),
        ({}, "After letting go the motion dies away. Simulation and closed form agree in rate and frequency."),
        ({"grows": True}, "After letting go the motion GROWS. Simulation and closed form agree in rate and frequency."),
        ({"agrees": None}, "dies away. Simulation and closed form agree in the sign of the rate."),
        ({"is_envelope": True}, "dies away. Simulation and closed form agree in the sign of the rate."),
        ({"sign_agrees": None}, "dies away. Simulation and closed form agree in rate and frequency."),
        ({"agrees": None, "sign_agrees": None}, "dies away. There is nothing to compare it with."),
        ({"agrees": False}, "dies away. Simulation and closed form DISAGREE."),
        ({"sign_agrees": False, "agrees": None}, "dies away. Simulation and closed form DISAGREE."),
        (
            {"approximate": "it creaks", "agrees": False},
            "dies away. The closed form is not what was simulated here: it creaks.",
        ),
    ],
)
def test_a_release_ends_with_whether_the_motion_grows_and_whether_that_was_foretold(
    own: dict[str, Any], told: str
) -> None:
    assert " ".join(released(**own).split()).endswith(told)
