"""What exact formulas leave out is said wherever they are answered with."""

from __future__ import annotations

import json
import re

import pytest

import haptisym as hs
from haptisym.caveats import caveats, sampled_loop
from haptisym.exact.stability import is_stable
from haptisym.report.page import page
from haptisym.simulation.motions import sine
from haptisym.tex.document import document

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
    assert bool(found.caveats) == loop
    assert (found.stable is None) == loop


def test_a_sampled_loop_that_diverges_is_not_called_stable() -> None:
    """The closed form's poles are all in the left half plane; the simulation, which samples, grows without bound."""
    inertia = hs.environments.mass_spring_damper("0.5 kg", "10 N*s/m", "300 N/m")
    behind = hs.effects.first_order_lag(200), hs.effects.compliance(k=500, b=2)
    given = hs.Scene(inertia, (hs.effects.zero_order_hold("4 ms"), *behind))
    assert is_stable(given.distortion().perc) is True
    assert hs.evaluate(given).stable is None
    with pytest.raises(hs.HaptisymError, match="not stable"):
        hs.simulate(given, sine("1 mm", "3 rad/s"))


def test_a_band_beyond_the_nyquist_frequency_and_a_threshold_without_its_per_cent_are_said() -> None:
    assert caveats(scene(HOLD, band=("0 Hz", "125 Hz"))) == ()
    (beyond,) = caveats(scene(HOLD, band=("0 Hz", "126 Hz")))
    assert "785.4 rad/s, the Nyquist frequency of sampler" in beyond
    both = caveats(scene(jnd="12"))
    assert [re.search(r"the (\w+) part is 1200 %", x)[1] for x in both] == ["real", "imaginary"]  # type: ignore[index]


def test_caveats_stand_in_every_output() -> None:
    found = hs.evaluate(scene(HOLD, hs.effects.compliance(k=5000)))
    assert json.loads(found.to_json())["caveats"] == list(found.caveats)
    assert "But: sampler holds a force that compliance brings back to a clock" in str(found)
    assert "compliance brings back to a clock" in document(found)
    assert "compliance brings back to a clock" in page(found)
    assert "caveats" not in json.loads(hs.evaluate(hs.load_scene("sampled-wall")).to_json())
