"""Controls by 14 CFR Part 60: every number against a formula by hand, every limit from both sides."""

from __future__ import annotations

import json
from math import cos, exp, pi, sin, sqrt

import pytest
from click.testing import CliRunner
from scipy.optimize import brentq

import haptisym as hs
from haptisym.cli import app

POUND = 4.4482216152605


def stick(*effects: hs.Effect, m: float = 1.8, b: float = 3, k: float = 100) -> hs.Scene:
    return hs.Scene(hs.environments.mass_spring_damper(m, b, k), effects, (0, 15))


def named(found: hs.ControlLoading, name: str):
    [trial] = [x for x in found.trials if x.name.startswith(name)]
    return trial


def free(m: float, b: float, k: float, level: float) -> float:
    """When a mass on spring and damper first passes a level, from its closed form and Brent's method."""
    sigma, w = b / (2 * m), sqrt(k / m - (b / (2 * m)) ** 2)
    return brentq(lambda t: exp(-sigma * t) * (cos(w * t) + sigma / w * sin(w * t)) - level, 0, pi / w)


def test_a_free_response_is_the_closed_form_and_its_margin_what_is_left_of_ten_per_cent() -> None:
    found = hs.control_loading(stick(hs.effects.shunt(m=0.3384, b=0.6)))
    own, felt = (free(*x, 0) - free(*x, 0.9) for x in ((1.8, 3, 100), (2.1384, 3.6, 100)))
    trial = named(found, "P_0")
    assert float(trial.environment) == pytest.approx(own, rel=1e-12)
    assert float(trial.display) == pytest.approx(felt, rel=1e-12)
    assert trial.margin == pytest.approx(1 - 10 * (felt / own - 1), abs=1e-9)
    assert (trial.passes, trial.entry) == (False, "2.b.1")
    assert named(hs.control_loading(stick(hs.effects.shunt(m=0.3384, b=0.6)), "14cfr60-c2a"), "P_0").passes is True


def test_an_overdamped_control_is_timed_from_90_to_10_per_cent() -> None:
    found = hs.control_loading(stick(hs.effects.shunt(m=0.6), m=1, b=30, k=100), control="roll")
    trial = named(found, "time from 90 %")
    assert float(trial.environment) == pytest.approx(0.58582774, abs=1e-8)
    assert float(trial.display) / float(trial.environment) - 1 == pytest.approx(-0.07163, abs=1e-5)
    assert (trial.passes, trial.entry) == (True, "2.b.2")


@pytest.mark.parametrize(("more", "passes"), [(9.999, True), (10, True), ("-10", True)])
def test_static_force_within_ten_per_cent_passes_whatever_the_travel(more: float, passes: bool) -> None:  # noqa: FBT001
    assert named(hs.control_loading(stick(hs.effects.shunt(k=more))), "static").passes is passes


def test_static_force_beyond_ten_per_cent_passes_while_it_is_within_pounds_at_full_travel() -> None:
    scene = stick(hs.effects.shunt(k=40))
    unknown = named(hs.control_loading(scene), "static")
    assert unknown.passes is None
    assert "up to 0.556 m" in unknown.why
    assert pytest.approx(0.556, abs=1e-3) == 5 * POUND / 40
    near, far = (named(hs.control_loading(scene, travel=x), "static") for x in ("0.556 m", "0.5561 m"))
    assert (near.passes, far.passes) == (True, False)
    assert near.margin == pytest.approx(1 - 40 * 0.556 / (5 * POUND))
    roll = named(hs.control_loading(scene, control="roll", travel="0.34 m"), "static")
    assert (roll.passes, roll.entry) == (False, "2.a.2")


def test_a_sweep_is_the_force_above_the_static_one() -> None:
    m, b, d, w = 1.8, 3, 0.3384, 2 * pi / 4
    trial = named(hs.control_loading(stick(hs.effects.shunt(m=d)), sweeps=["4 s"], travel=0.1), "sweep")
    assert float(trial.environment) == pytest.approx(abs(complex(-m * w**2, b * w)))
    assert float(trial.display) == pytest.approx(abs(complex(-(m + d) * w**2, b * w)))
    assert trial.margin == pytest.approx(1 - d * w**2 * 0.1 / (2 * POUND))
    late = named(hs.control_loading(stick(hs.effects.delay("50 ms")), sweeps=[4]), "sweep")
    h = complex(100 - m * w**2, b * w)
    turned = h * complex(cos(w * 0.05), -sin(w * 0.05))
    assert float(late.display) == pytest.approx(abs(turned - 100))
    assert "needs the travel" in late.why
    assert f"{2 * POUND / abs(turned - h):.4g} m" in late.why


def test_breakout_is_the_friction_of_the_display_and_a_helicopter_is_let_go_without_it() -> None:
    rough = stick(hs.effects.coulomb_friction("1.2 N", "5 cm"))
    aeroplane, helicopter = hs.control_loading(rough), hs.control_loading(rough, "14cfr60-c2a")
    assert (named(aeroplane, "breakout").passes, named(helicopter, "breakout").passes) == (True, False)
    assert named(aeroplane, "breakout").margin == pytest.approx(1 - 1.2 / (2 * POUND))
    assert named(aeroplane, "free response").passes is None
    assert named(helicopter, "P_0").margin == 1


def test_what_was_not_tested_says_why_and_counts_for_nothing() -> None:
    found = hs.control_loading("sidestick", "14cfr60-c2a", "collective")
    why = {x.name: x.why for x in found.untested}
    assert set(why) == {"breakout", "freeplay"}
    assert "torque" in why["breakout"]
    body = json.loads(found.to_json())
    assert body["passes"] is (not found.failed)
    assert body["certified"] is True
    assert [x["passes"] for x in body["tests"]].count(None) == 2


def test_a_torque_beyond_ten_per_cent_is_not_judged_as_pounds_need_a_lever() -> None:
    sweep = named(hs.control_loading("sidestick", sweeps=["4 s"]), "sweep")
    assert (sweep.passes, sweep.margin) == (None, None)
    assert "need the lever" in sweep.why


def test_the_jnd_stands_beside_each_test() -> None:
    found = hs.control_loading(stick(hs.effects.shunt(m=0.3384)), sweeps=["4 s", "0.5 s", "0.1 s"])
    assert named(found, "static").noticed is False
    assert named(found, "P_0").noticed is True
    assert [x.noticed for x in found.trials if x.name.startswith("sweep")] == [False, True, None]


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"rule": "easa"}, 'unknown "easa"'),
        ({"control": "cyclic"}, "of this rule are pitch, roll, pedals, nosewheel"),
        ({"travel": "5 N"}, 'travel: "5 N" is not a'),
        ({"travel": 0}, "must be positive"),
        ({"sweeps": ["-4 s"]}, "must be positive"),
        ({"scene": "sidestick", "travel": 0.1}, "this control turns"),
    ],
)
def test_what_cannot_be_asked_is_refused(given: dict[str, object], words: str) -> None:
    with pytest.raises(hs.SceneError) as error:
        hs.control_loading(**{"scene": stick(), **given})
    assert words in str(error.value)


def test_the_command_prints_the_report_and_refuses_options_without_a_rule() -> None:
    call = CliRunner().invoke
    done = call(app, ["metrics", "sidestick", "--rule", "14cfr60-a2a", "--sweep", "4 s", "--json"])
    assert json.loads(done.stdout)["schema"] == "haptisym.controlloading/1"
    shown = call(app, ["metrics", "sidestick", "--rule", "14cfr60-a2a"]).stdout
    assert "fails 1 of" in shown
    alone = call(app, ["metrics", "sidestick", "--travel", "5 cm"])
    assert alone.exit_code


def test_a_figure_shows_both_responses_or_says_that_there_is_none(tmp_path) -> None:
    found = hs.control_loading(stick(hs.effects.shunt(m=0.3)))
    assert found.save_figure(tmp_path / "a.svg").stat().st_size > 1000
    [first, *_] = found.figure().axes
    assert first.lines[0].get_ydata()[0] == pytest.approx(1)
    late = hs.control_loading(stick(hs.effects.coulomb_friction(1, "5 cm")))
    with pytest.raises(hs.HaptisymError, match="no free response"):
        late.figure()
