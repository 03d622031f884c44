"""Pages, documents and reports of a scene in Hz and ms are in Hz and ms, whatever is asked."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from explorers import undrawn

import haptisym as hs
from haptisym.writing.latex import latex

SCENE = hs.parse_scene("""
title = "In Hz and ms"
[environment]
model = "mass-spring-damper"
m = "1.8 kg"
b = "15 N*s/m"
k = "100 N/m"
[[effects]]
model = "delay"
tau = ["4 ms", "8 ms"]
[[effects]]
name = "filter"
model = "first-order-lag"
omega_c = ["8 Hz", "10 Hz", "13 Hz"]
[evaluation]
band = ["0 Hz", "5 Hz"]
jnd = 0.10
""")


def response(folder: Path) -> Path:
    hertz = np.linspace(0.5, 20, 30)
    exact = hs.sampled(SCENE, 2 * np.pi * hertz).H
    found = exact * (1 + 0.01 * np.exp(1j * np.arange(30)))
    file, head = folder / "device.csv", "f (Hz),re (N/m),im (N/m),radius (N/m)"
    columns = np.column_stack([hertz, found.real, found.imag, 0.03 * np.abs(found)])
    np.savetxt(file, columns, delimiter=",", header=head, comments="")
    return file


ASKED: dict[str, Callable[[], Any]] = {
    "evaluate": lambda: hs.evaluate(SCENE),
    "tolerances": lambda: hs.tolerances(SCENE, samples=3),
    "require": lambda: hs.require(SCENE, "tau"),
    "stability": lambda: hs.stability(SCENE, "postural-arm"),
    "sensitivity": lambda: hs.sensitivity(SCENE),
    "effects": lambda: hs.relevance(SCENE),
    "metrics": lambda: hs.metrics(SCENE),
    "derive": lambda: hs.derive(SCENE),
    "compare": lambda: hs.compare(SCENE, values={"omega_c": "12 Hz"}),
}


@pytest.mark.few("evaluate", "require")
@pytest.mark.parametrize("name", ASKED)
def test_a_scene_in_hertz_is_answered_in_hertz_everywhere(name: str) -> None:
    found = ASKED[name]()
    page = re.sub(r"<(script|svg|style).*?</\1>", "", undrawn(found), flags=re.DOTALL)
    for told in (str(found), latex(found.document()), re.sub("<[^>]+>", " ", page)):
        assert not re.search(r"rad\s*/\s*s\b", told.replace("rad/s^", "")), told[:200]


def test_ranges_searches_and_delays_are_in_the_units_that_were_written() -> None:
    assert "τ 4 to 8 ms" in str(hs.tolerances(SCENE, samples=2))
    assert "omega_c varies from 8 to 13 Hz" in str(hs.evaluate(SCENE))
    page = str(hs.require(SCENE, "tau"))
    assert "(is 6 ms)" in page
    assert "Range searched  0, and 6e-6 ms to 6 s" in page


def test_a_response_in_hertz_is_fitted_in_hertz_and_milliseconds(tmp_path: Path) -> None:
    found = hs.identify(response(tmp_path), "mass-spring-damper", ["delay", "first-order-lag"])
    page = str(found)
    assert "rad/s" not in page
    [lag] = [x for x in page.splitlines() if "ω_c" in x]
    [delay] = [x for x in page.splitlines() if "τ" in x]
    assert (lag.split()[-1], delay.split()[-1]) == ("Hz", "ms")
    by_name = {x.parameter.name: x for x in found.estimates}
    assert float(lag.split()[1]) == pytest.approx(by_name["omega_c"].value / (2 * np.pi), rel=1e-2)
    assert float(delay.split()[1]) == pytest.approx(1e3 * by_name["tau"].value, rel=1e-2)


def test_sliders_are_in_the_units_of_the_scene_and_the_script_in_si() -> None:
    page = undrawn(hs.evaluate(SCENE))
    spec = json.loads(re.search(r'id="explorer-data"[^>]*>(.*?)</script>', page, re.DOTALL)[1])  # type: ignore[index]
    shown = {(x["unit"], round(x["size"], 12)): x["value"] / x["size"] for x in spec["sliders"]}
    assert shown["ms", 0.001] == pytest.approx(6)
    assert spec["frequency"] == {"unit": "Hz", "size": pytest.approx(2 * np.pi)}
    hertz = [x["value"] / x["size"] for x in spec["sliders"] if x["unit"] == "Hz"]
    assert hertz == [pytest.approx(10), pytest.approx(2.5)]  # the filter, and the middle of the band
    assert Path(hs.__file__).with_name("data").joinpath("explorer.js").read_text(encoding="utf-8").count("rad/s") == 0
