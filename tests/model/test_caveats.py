"""What exact formulas leave out is said wherever they are answered with."""

from __future__ import annotations

import json
import re

import mpmath
import pytest
from marks import often
from pdflatex import set_document
from reports import undrawn

import haptisym as hs
from haptisym.kernel.stability import is_stable
from haptisym.model.caveats import caveats, clocks, sampled_loop
from haptisym.model.hand import Hand
from haptisym.verbs.simulate.motions import sine

WALL = hs.environments.mass_spring_damper(k=200, b=2)
HOLD = hs.effects.zero_order_hold("4 ms", name="sampler")


def scene(*effects: hs.Effect, band: tuple[str, str] = ("0 Hz", "20 Hz"), jnd: str = "0.1") -> hs.Scene:
    return hs.Scene(WALL, effects, band, jnd)


@pytest.mark.parametrize(
    ("effects", "loop"),
    [
        ((HOLD,), False),
        ((hs.effects.compliance(k=5000), HOLD), False),  # it yields on the environment's side of the clock
        ((HOLD, hs.effects.shunt(m="0.1 kg"), hs.effects.first_order_lag(200)), False),
        ((HOLD, hs.effects.compliance(k=5000)), True),
        ((HOLD, hs.effects.first_order_lag(200), hs.effects.compliance(k=5000)), True),
        ((HOLD, hs.effects.zero_order_hold("3 ms", name="second")), True),
    ],
)
def test_a_hold_is_in_a_loop_where_what_it_holds_comes_back_to_a_clock(
    effects: tuple[hs.Effect, ...],
    loop: bool,  # noqa: FBT001
) -> None:
    found = hs.evaluate(scene(*effects))
    assert (sampled_loop(found.scene) is not None) == loop
    assert any("brings back to a clock" in x for x in found.caveats) == loop
    assert (found.stable is None) == loop


def test_a_sampled_loop_that_diverges_is_not_called_stable() -> None:
    """The closed form's poles are all in the left half plane; the simulation, which samples, grows without bound."""
    inertia = hs.environments.mass_spring_damper("0.5 kg", "10 N*s/m", "300 N/m")
    behind = hs.effects.first_order_lag(200), hs.effects.compliance(k=500, b=2)
    given = hs.Scene(inertia, (hs.effects.zero_order_hold("4 ms"), *behind))
    assert is_stable(given.distortion().perc) is True
    assert hs.evaluate(given).stable is None
    with pytest.raises(hs.HaptisymError, match="grows without bound .* not stable"):
        hs.simulate(given, sine("1 mm", "3 rad/s"))


def test_a_band_beyond_the_nyquist_frequency_and_a_threshold_without_its_per_cent_are_said() -> None:
    (_,) = caveats(scene(HOLD, band=("0 Hz", "125 Hz")))
    beyond, _ = caveats(scene(HOLD, band=("0 Hz", "126 Hz")))
    assert "785.4 rad/s, the Nyquist frequency of sampler" in beyond
    both = caveats(scene(jnd="12"))
    assert [re.search(r"the (\w+) part is 1200 %", x)[1] for x in both] == ["real", "imaginary"]  # type: ignore[index]


@pytest.mark.slow
def test_caveats_stand_in_every_output() -> None:
    found = hs.evaluate(scene(HOLD, hs.effects.compliance(k=5000)))
    assert json.loads(found.to_json())["caveats"] == list(found.caveats)
    assert "But: sampler holds a force that compliance brings back to a clock" in str(found)
    assert "compliance brings back to a clock" in set_document(found)
    assert "compliance brings back to a clock" in undrawn(found)
    assert "caveats" not in json.loads(hs.evaluate(hs.load_scene("fu2019")).to_json())


STIFF = hs.Scene(
    hs.environments.mass_spring_damper(k="50 kN/m"),
    (hs.effects.zero_order_hold("1 ms", name="clock"), hs.effects.shunt(m="45 g", name="device")),
    ("0 Hz", "100 Hz"),
)
"""A stiff wall behind a clock and a light device."""


def growth_in_a_hand() -> float:
    """By how much the sampled loop of that wall grows each millisecond in a hand of 0.1 kg, 2 N s/m and 50 N/m.

    Between samples the moving mass, 0.145 kg, obeys M x'' + b x' + k x = -F with the force F = 50 kN/m x held: the exact
    solution of that over one period is a matrix, and the loop grows by its largest eigenvalue.
    """
    M, b, k, wall, T = (mpmath.mpf(x) for x in ("0.145", "2", "50", "50000", "0.001"))
    free = mpmath.matrix([[0, 1, 0], [-k / M, -b / M, -1 / M], [0, 0, 0]])  # position, speed, force held
    step = mpmath.expm(free * T) * mpmath.matrix([[1, 0, 0], [0, 1, 0], [wall, 0, 0]])
    eigenvalues, _ = mpmath.eig(step)
    return float(max(abs(x) for x in eigenvalues))


def test_a_wall_that_grows_in_a_hand_is_called_stable_under_imposed_motion_only() -> None:
    assert growth_in_a_hand() == pytest.approx(1.076, abs=5e-4)
    found = hs.evaluate(STIFF)
    assert found.stable is True
    (said,) = found.caveats
    assert said.startswith(
        "clock works by a clock, so that hand and display together are a sampled loop. What is said here"
    )
    for text in outputs(found):
        assert "under imposed motion is stable" in text
        assert "in a hand was not looked at" in text
        assert "haptisym stability decides that loop in a hand" in text
    assert "haptisym stability decides that loop in a hand" in " ".join(str(hs.metrics(STIFF)).split())
    (held,) = hs.stability(STIFF, Hand("this one", "0.1 kg", "2 N*s/m", "50 N/m")).held
    assert held.stable is False


@pytest.mark.slow
def test_every_shipped_scene_with_a_clock_says_who_decides_the_loop_through_the_hand() -> None:
    clocked = [x for x in map(hs.load_scene, hs.scene_names()) if clocks(x)]
    assert len(clocked) > 1
    for x in clocked:
        assert any("stability decides that loop in a hand" in words for words in caveats(x)), x.title
        assert all(held.stable is not None for held in hs.stability(x, "postural-arm").held), x.title


def outputs(found: hs.Evaluation) -> list[str]:
    """An evaluation in all writers, spaces and markup apart."""
    pages = [str(found), set_document(found), undrawn(found), found._repr_html_()]  # type: ignore[attr-defined]
    return [
        " ".join(re.sub(r"<script.*?</script>|<style.*?</style>|<[^>]*>", "", x, flags=re.DOTALL).split())
        for x in pages
    ]


@pytest.mark.parametrize(
    "name",
    often(
        ["fu2019", "sampled-wall", "wave-variable-link", "delayed-spring", "admittance-display"],
        {"delayed-spring"}.__contains__,
    ),
)
def test_no_output_calls_perceived_dynamics_stable_or_a_display_passive(name: str) -> None:
    """What was decided is the force under imposed motion, every passive hand, and absolute stability: each by its name."""
    found = hs.evaluate(name)
    for text in [*outputs(found), " ".join(str(hs.metrics(name)).split())]:
        assert "perceived dynamics are" not in text
        assert not re.search(r"\bpassive(?! hand| environment)", text), re.findall(r".{40}\bpassive.{20}", text)
        for words in re.findall(r".{60}\bstable\b.{30}", text):
            assert re.search(r"imposed motion|in a hand|that loop|absolutely|every passive hand", words), words
