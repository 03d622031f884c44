"""What is given in Python and is of another type than it must be: one sentence that says what to give, and no other error."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sympy import Integer

import haptisym as hs
from haptisym.kernel.errors import HaptisymError
from haptisym.verbs.sweep.swept import Swept

SPRING = hs.environments.mass_spring_damper(k="100 N/m")
LAG = hs.effects.first_order_lag("80 rad/s")

WRONG: dict[str, tuple[Callable[[], object], str]] = {
    "one effect": (lambda: hs.Scene(SPRING, LAG), "effects: "),  # type: ignore[arg-type]
    "a name for effects": (lambda: hs.Scene(SPRING, "delay"), 'effects: "delay" will not do'),  # type: ignore[arg-type]
    "a name among effects": (lambda: hs.Scene(SPRING, ("delay",)), 'effects: "delay" will not do'),  # type: ignore[arg-type]
    "an environment among effects": (lambda: hs.Scene(SPRING, (SPRING,)), "give effects of haptisym.effects"),  # type: ignore[arg-type]
    "an effect to feel": (lambda: hs.Scene(LAG), "give one of haptisym.environments"),  # type: ignore[arg-type]
    "an effect to render": (lambda: hs.Scene(SPRING, rendered=LAG), "rendered: "),  # type: ignore[arg-type]
    "a band of one end": (lambda: hs.Scene(SPRING, (LAG,), 15), 'band: "15" will not do'),  # type: ignore[arg-type]
    "one hand": (lambda: hs.Scene(SPRING, hands=hs.Hand("h", m=1)), "hands: "),  # type: ignore[arg-type]
    "effects in a list": (lambda: hs.distort(SPRING, [LAG]), "effects: "),  # type: ignore[arg-type]
    "a scene's name to distort": (lambda: hs.distort("fu2019"), 'environment: "fu2019"'),  # type: ignore[arg-type]
    "no digits": (lambda: hs.evaluate("fu2019").crossings[0].omega.digits(0), "digits: 0 must be a whole number"),
    "half a digit": (lambda: hs.evaluate("fu2019").crossings[0].omega.digits(2.5), "digits: 2.5"),  # type: ignore[arg-type]
    "a range of one end": (lambda: hs.require("fu2019", "zeta", 5), "the range has two ends"),  # type: ignore[arg-type]
    "one range for two": (lambda: hs.design_map("fu2019", ["omega_n", "zeta"], [(60, 200)]), "one for each of the two"),
    "a list to vary": (lambda: hs.sweep("fu2019", ["zeta"]), "vary: "),  # type: ignore[arg-type]
    "a number for a hand": (lambda: hs.stability("fu2019", 5), 'hand: "5" will not do'),  # type: ignore[arg-type]
    "a number to be free": (lambda: hs.stability("fu2019", "light-touch", free=3), 'free: "3"'),  # type: ignore[arg-type]
    "a number to keep": (lambda: hs.derive("fu2019", keep=-1), 'keep: "-1"'),  # type: ignore[arg-type]
    "a language that is none": (lambda: hs.scene_code("fu2019", "python"), "is none of numpy, c, octave"),
    "one frequency": (lambda: hs.multisine("5 cm", 5), 'omegas: "5"'),  # type: ignore[arg-type]
    "names for scenes": (lambda: hs.SceneFamily({"a": "fu2019"}), 'environments: a: "fu2019"'),  # type: ignore[dict-item]
    "a list of scenes": (lambda: hs.SceneFamily(["fu2019"]), "environments: "),  # type: ignore[arg-type]
    "a path for a text": (lambda: hs.parse_scene(Path("x.toml")), "load_scene reads a file"),  # type: ignore[arg-type]
    "bytes for a text": (lambda: hs.parse_scene(b"title = 1"), "load_scene reads a file"),  # type: ignore[arg-type]
    "a list of answers": (lambda: hs.jnd([(1, 2, 3)]), "data: "),  # type: ignore[arg-type]
    "no recording": (lambda: hs.recording(None), 'recording: "None"'),  # type: ignore[arg-type]
    "a list of symbols": (lambda: hs.symbols(["m", "b"]), "give names in one string"),  # type: ignore[arg-type]
}


@pytest.mark.parametrize(("give", "told"), WRONG.values(), ids=WRONG)
def test_what_is_of_another_type_is_refused_in_one_sentence(give: Callable[[], object], told: str) -> None:
    with pytest.raises(HaptisymError) as raised:
        give()
    assert told in str(raised.value)
    assert "\n" not in str(raised.value)


def test_a_language_goes_by_its_name_too() -> None:
    assert hs.scene_code("fu2019", "c", parameters=()) == hs.scene_code("fu2019", hs.Language.C, parameters=())


def test_the_published_hands_show_their_names() -> None:
    assert repr(hs.hands) == f"<hands {', '.join(hs.hands)}>"


@pytest.mark.slow
def test_an_end_is_told_once_where_both_are_alike_and_nobody_is_other_where_none_is_left() -> None:
    """A changeover of the environment does not move with the filter; a tolerance of 200 leaves no effect."""
    flat = " ".join(str(hs.relevance("fu2019", tolerance=200)).split())
    assert "Leaving out all of them together changes" in flat
    paper = hs.load_scene("fu2019")
    swept = str(Swept(paper, hs.sweep(paper, {"omega_n": [60, 80]})))
    [row] = [x for x in swept.splitlines() if "of the environment" in x]
    assert " to " not in row


def test_a_point_is_a_number_of_rad_per_second() -> None:
    [transparent] = hs.evaluate("fu2019").transparent
    assert (float(transparent.low), float(transparent.high)) == (0, pytest.approx(7.978916790174708))


COUNTS: list[tuple[str, int, Callable[[Any], object]]] = [
    ("digits", 1, lambda n: hs.evaluate("fu2019", digits=n)),
    ("digits", 1, lambda n: hs.evaluate("fu2019").crossings[0].omega.digits(n)),
    ("digits", 1, lambda n: hs.require("fu2019", "omega_n", digits=n)),
    ("digits", 1, lambda n: hs.stability("fu2019", digits=n)),
    ("samples", 0, lambda n: hs.tolerances("fu2019-tolerances", samples=n)),
    ("block", 1, lambda n: hs.sweep("fu2019", {"zeta": [0.4, 0.5]}, block=n)),
]


@pytest.mark.parametrize(("name", "least", "ask"), COUNTS)
def test_a_count_is_a_whole_number_of_any_kind_and_nothing_else_is(
    name: str, least: int, ask: Callable[[Any], object]
) -> None:
    for few in (least, np.int16(least), Integer(least)):
        ask(few)
    for wrong in (least - 1, True, 2.0, "3", None, [2]):
        with pytest.raises(hs.SceneError, match=rf"{name}: .* must be a whole number.* at least {least}"):
            ask(wrong)
