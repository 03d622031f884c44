"""Sliders in a notebook: computed while they move, the result of evaluate when they rest. Widgets are moved as a notebook moves them."""

from __future__ import annotations

import asyncio
import re
import sys
from importlib.util import find_spec
from math import log10
from types import SimpleNamespace

import pytest
from marks import required

import haptisym as hs


@pytest.fixture
def notebook(monkeypatch: pytest.MonkeyPatch) -> None:
    """The shell of a notebook."""
    required("ipywidgets", find_spec("ipywidgets") and find_spec("IPython"))
    monkeypatch.setattr("IPython.get_ipython", lambda: SimpleNamespace(kernel=object()))


def unwrapped(text: str) -> str:
    """A text in one line."""
    return " ".join(text.split())


@pytest.mark.usefixtures("notebook")
@pytest.mark.parametrize("name", ["fu2019", "steering-wheel"])
def test_at_rest_the_lines_are_those_of_the_command_line_in_the_units_of_the_scene(name: str) -> None:
    *lines, proven = hs.explore(name).text.splitlines()
    page = unwrapped(str(hs.evaluate(name)))
    assert len(lines) == 3
    assert proven.startswith("Proven: ")
    for line in [*lines, proven]:
        assert unwrapped(line) in page


@pytest.mark.usefixtures("notebook")
def test_at_rest_the_evaluation_is_that_of_the_scene_with_the_values_of_the_sliders() -> None:
    found = hs.explore("fu2019")
    drawn = bytes(found.widget.children[1].value)
    assert drawn.startswith(b"\x89PNG")
    found.sliders["effects.filter.omega_n"].value = 47.5
    found.sliders["evaluation.jnd"].value = 0.15
    own = hs.evaluate(hs.load_scene("fu2019").with_values({"omega_n": "47.5 rad/s", "evaluation.jnd": "0.15"}))
    assert found.evaluation.to_json() == own.to_json()
    assert found.text.splitlines()[:3] == str(own).splitlines()[2:5]
    assert "Proven" in found.text
    assert bytes(found.widget.children[1].value) != drawn
    found.widget.children[-1].click()
    assert found.evaluation.to_json() == hs.evaluate("fu2019").to_json()


@pytest.mark.usefixtures("notebook")
def test_sliders_are_in_the_units_of_the_scene() -> None:
    found = hs.explore("steering-wheel")
    slider = found.sliders["effects.motor.omega_c"]
    assert "(Hz)" in slider.description
    assert (slider.value, slider.min) == (pytest.approx(6), pytest.approx(-0.2218487))  # a decade down: log10(0.6)
    slider.value = 7
    own = hs.evaluate(hs.load_scene("steering-wheel").with_values({"effects.motor.omega_c": "7 Hz"}))
    assert found.evaluation.to_json() == own.to_json()


@pytest.mark.usefixtures("notebook")
@pytest.mark.parametrize(
    ("name", "names"), [("fu2019", ["m (kg)", "ω_n (rad/s)", "c"]), ("steering-wheel", ["ω_c (Hz)"])]
)
def test_a_slider_takes_what_is_typed_to_four_digits_and_has_the_name_of_the_report(
    name: str, names: list[str]
) -> None:
    """What is typed is put on the nearest step: 0.1 became 0.096."""
    sliders = hs.explore(name).sliders.values()
    assert set(names) <= {x.description for x in sliders}
    for x in sliders:
        is_logarithmic = hasattr(x, "base")
        for digits in (1, 1.001, 2.347, 9.987, 9.999):
            typed = x.value * digits / float(f"{x.value:e}".split("e")[0])
            place = log10(typed) if is_logarithmic else typed
            if x.min <= place <= x.max:
                step = x.min + round((place - x.min) / x.step) * x.step
                assert f"{10**step if is_logarithmic else step:.4g}" == f"{typed:.4g}"


@pytest.mark.usefixtures("notebook")
@pytest.mark.few("steering-wheel")
@pytest.mark.parametrize("name", ["fu2019", "wave-variable-link", "organ-tissue", "steering-wheel"])
def test_while_a_slider_moves_the_first_frequency_that_is_noticed_is_computed_and_said_to_be(name: str) -> None:
    async def drag() -> None:
        found = hs.explore(name)
        rested = found.evaluation
        path, slider = next(iter(found.sliders.items()))
        slider.value = slider.value * 1.1
        own = hs.evaluate(rested.scene.with_values({path: float(f"{slider.value:.4g}")}))
        assert "no error bound" in found.text
        assert "Proven" not in found.text
        assert found.evaluation is rested
        if own.bandwidth is None:
            assert found.text.startswith("Bandwidth  none: noticed at the lower end of the band")
        else:
            ends = re.match(r"Bandwidth  ([\d.e-]+) to ([\d.e-]+) (\S+)", found.text)
            assert ends, found.text
            assert ends[3] == own.scene.frequency.text
            bandwidth = float(own.bandwidth) / float(own.scene.frequency.size)
            assert 0.9995 * float(ends[1]) <= bandwidth <= 1.0005 * float(ends[2])  # four digits
        slider.value = slider.value * 1.1  # again before it rests: evaluated once, at the last value
        while "Proven" not in found.text:
            await asyncio.sleep(0.05)
        own = hs.evaluate(rested.scene.with_values({path: float(f"{slider.value:.4g}")}))
        assert found.evaluation.to_json() == own.to_json()

    asyncio.run(drag())


def test_without_ipywidgets_or_a_notebook_it_says_what_to_do(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(hs.SceneError, match=r"notebook.*haptisym evaluate SCENE --report"):
        hs.explore("fu2019")
    monkeypatch.setitem(sys.modules, "ipywidgets", None)
    with pytest.raises(hs.SceneError, match=r'ipywidgets is missing: "pip install haptisym\[notebook\]"'):
        hs.explore("fu2019")
    with pytest.raises(hs.SceneError, match="no-such"):
        hs.explore("no-such")
