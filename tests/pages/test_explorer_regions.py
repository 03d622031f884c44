"""The explorer takes every JND region: what it draws is what Python proves, and what it proves is found again."""

from __future__ import annotations

import re
from collections.abc import Iterator
from decimal import Decimal
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

import browser
import numpy as np
import pytest
from browser import Browser
from certificates import region_scene, text_of
from explorers import proven, typed
from jnds import inline
from marks import often, required
from reports import undrawn
from secondchecker import catalogue, run
from sympy import pi

import haptisym as hs
from haptisym.judge.crossings import CrossingKind

JNDS: dict[str, Any] = {
    "ellipse": {"shape": "ellipse", "real": 0.1, "imag": 0.12, "tilt": 0.5},
    "diamond": {"shape": "diamond", "real": 0.1, "imag": 0.1},
    "polygon": {"shape": "polygon", "corners": [[0.1, 0], ["0.02 + omega/1000", 0.1], [-0.1, 0.05], [0, -0.1]]},
    "sides and floor": {"real": {"higher": 0.08, "lower": 0.12}, "imag": "0.08 + 0.004*omega", "floor": "5 N/m"},
}
"""Of the paper's example."""
MOVED: dict[str, tuple[dict[str, str], Any]] = {
    "ellipse": ({"explorer-c-real": "0.08", "explorer-tilt": "-0.3"}, JNDS["ellipse"] | {"real": 0.08, "tilt": -0.3}),
    "diamond": ({"explorer-c": "0.15"}, JNDS["diamond"] | {"real": 0.15, "imag": 0.15}),
    "polygon": ({"explorer-size": "1.5"}, {"shape": "polygon", "corners": [
        ["0.15", 0], ["0.03 + 3*omega/2000", "0.15"], ["-0.15", "0.075"], [0, "-0.15"]]}),
    "sides and floor": (
        {"explorer-c-real-lower": "0.1", "explorer-floor": "12"},
        JNDS["sides and floor"] | {"real": {"higher": 0.08, "lower": 0.1}, "floor": "12 N/m"},
    ),
}  # fmt: skip
"""What is typed, and the JND that has these numbers."""


def with_jnd(jnd: Any) -> str:
    return re.sub("jnd = .*", f"jnd = {inline(jnd)}", text_of("fu2019"))


@cache
def evaluated(name: str) -> hs.Evaluation:
    return hs.evaluate(hs.parse_scene(with_jnd(JNDS[name])))


@cache
def written(name: str) -> str:
    return undrawn(evaluated(name))


@pytest.fixture(scope="module")
def shown(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """A page in Chromium."""
    required("chromium", browser.program())
    folder: Path = tmp_path_factory.mktemp("pages")
    with browser.running() as opened:

        def show(name: str) -> Browser:
            file = folder / "page.html"
            file.write_text(written(name), encoding="utf-8")
            opened.open(file)
            return opened

        yield show


def bands(opened: Browser) -> list[list[float]]:
    script = "[...document.querySelectorAll('#explorer-ratios rect.band')].map(x => [+x.getAttribute('x'), +x.getAttribute('width')])"
    return [[low, low + width] for low, width in opened.value(script)]


def told(opened: Browser) -> list[str]:
    return re.findall(r"at ([\d.]*\d)", opened.value("document.getElementById('explorer-crossings').textContent"))


def says(opened: Browser, e: hs.Evaluation) -> None:
    found = e.to_dict()
    assert bands(opened) == [pytest.approx(x, rel=1e-9, abs=1e-9) for x in found["transparent"]]
    assert told(opened) == [f"{c['omega']:.4g}" for c in found["crossings"]]
    said = proven(opened)
    assert said.startswith("Proven at the decimals shown, in exact arithmetic")
    assert re.findall(r"at (\d[\d.]*\d)", said) == [f"{c['omega']:.6g}" for c in found["crossings"]]
    assert opened.complaints() == []


@pytest.mark.slow
@pytest.mark.parametrize("name", often(JNDS, "ellipse".__eq__))
def test_the_explorer_draws_what_is_proven_of_a_region_and_of_one_with_other_numbers(name: str, shown: Any) -> None:
    opened = shown(name)
    says(opened, evaluated(name))
    changes, other = MOVED[name]
    for identity, text in changes.items():
        typed(opened, identity, text)
    says(opened, hs.evaluate(hs.parse_scene(with_jnd(other))))


def region(opened: Browser) -> list[np.ndarray]:
    """The closed lines of the region, in the data's own coordinates."""
    listed = opened.value(
        "[...document.querySelectorAll('#explorer-region path.region')].map(x => x.getAttribute('d'))"
    )
    return [np.array([[float(x) for x in p.split()] for p in re.split("[ML]", d.rstrip("Z"))[1:]]) for d in listed]


@pytest.mark.slow
@pytest.mark.parametrize("name", often(JNDS, "ellipse".__eq__))
def test_the_region_is_drawn_as_it_is_at_the_frequency_that_is_asked_about(name: str, shown: Any) -> None:
    """Just inside of each of its lines nothing is noticed, by the formulas of the region, just outside something is."""
    opened = shown(name)
    typed(opened, "explorer-omega", "4")
    lines = region(opened)
    assert lines
    for line in lines:
        middle = line.mean(axis=0)
        for p, q in zip(line, np.roll(line, -1, axis=0), strict=True):
            edge = (p + q) / 2
            assert not noticed(name, *(middle + 0.9999 * (edge - middle)))
            assert noticed(name, *(middle + 1.01 * (edge - middle)))


def noticed(name: str, x: float, y: float) -> bool:
    """Whether a change is noticed at 4 rad/s, where H_env of the paper's example is 71.2 + 60 j N/m."""
    if name == "ellipse":
        u, v = x / 0.1, y / 0.12
        return u * u - u * v + v * v > 0.75
    if name == "diamond":
        return abs(x) + abs(y) > 0.1
    if name == "polygon":
        corners = [(0.1, 0), (0.024, 0.1), (-0.1, 0.05), (0, -0.1)]
        sides = zip(corners, [*corners[1:], corners[0]], strict=True)
        return any((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]) < 0 for a, b in sides)
    size = float(np.hypot(71.2, 60))
    limits = {True: (0.08, 0.096), False: (0.12, 0.096)}
    for i, (own, change) in enumerate(((71.2 / size, x), (60 / size, y))):
        if abs(change) > max(limits[abs(own + change) > abs(own)][i], 5 / size):
            return True
    return False


@pytest.mark.slow
def test_the_way_through_the_plane_is_the_distortion(shown: Any) -> None:
    opened = shown("diamond")
    d = opened.value("document.querySelector('#explorer-region path.change').getAttribute('d')")
    points = np.array([[float(x) for x in p.split()] for p in re.split("[ML]", d)[1:]])
    omega = np.linspace(0, 15, 2000)
    s = 1j * omega
    H = 1.8 * s**2 + 15 * s + 100
    way = H * (6400 / (s**2 + 80 * s + 6400) - 1) / abs(H)
    away = np.abs(points[:, 0] + 1j * points[:, 1] - way[:, None]).min(axis=0)
    assert len(points) > 250
    assert away.max() < 1e-3


# In exact arithmetic.

CROSSINGS = """
const c = require(process.argv[1]);
const { asked, catalogue } = JSON.parse(require("fs").readFileSync(0, "utf8"));
process.stdout.write(JSON.stringify(asked.map(([text, given]) => c.crossings(text, null, catalogue, given))));
"""


def exactly(asked: list[tuple[str, dict[str, Any]]]) -> list[dict[str, Any]]:
    return run(CROSSINGS, {"asked": asked, "catalogue": catalogue()}, 300)  # type: ignore[no-any-return]


def inside(e: hs.Evaluation) -> list[tuple[float, str, bool]]:
    """Where a border is passed, strictly within the band."""
    ends = (e.chart.points[0].omega, e.chart.points[-1].omega)
    rows = [x for x in e.crossings if x.kind is not CrossingKind.TOUCHES and x.omega not in ends]
    return sorted((float(x.omega), x.criterion.name, x.kind is CrossingKind.EXCEEDS) for x in rows)


def decimal(x: object) -> str:
    exact = Fraction(str(x))
    return str(Decimal(exact.numerator) / Decimal(exact.denominator))


@pytest.mark.slow
@pytest.mark.parametrize("first", often(range(0, 600, 20), [0].__contains__))
def test_all_crossings_of_random_regions_are_found_exactly(first: int) -> None:
    texts = [region_scene(seed) for seed in range(first, first + (4 if not first else 20))]
    every = [(text, hs.evaluate(hs.parse_scene(text))) for text in texts]
    listed = [(text, e) for text, e in every if not any(x.has(pi) for x in e.scene.band)]
    asked = [(text, {"values": [], "threshold": {}, "band": [decimal(x) for x in e.scene.band]}) for text, e in listed]
    for (text, e), said in zip(listed, exactly(asked), strict=True):
        if said["crossings"] is None:
            assert said["why"] == "the degrees are too high for that", said
            continue
        found = sorted((x["omega"], x["part"], x["rising"]) for x in said["crossings"])
        assert [x[1:] for x in found] == [x[1:] for x in inside(e)], text
        assert [x[0] for x in found] == pytest.approx([x[0] for x in inside(e)], rel=1e-8), text


@pytest.mark.slow
def test_crossings_of_a_region_with_other_numbers_are_those_of_a_scene_that_has_them() -> None:
    given = {
        "ellipse": {"real": "0.08", "tilt": "-0.3"},
        "diamond": {"real": "0.15", "imag": "0.15"},
        "polygon": {"size": "1.5"},
        "sides and floor": {"real.lower": "0.1", "floor": "12"},
    }
    asked = [(with_jnd(JNDS[x]), {"values": [], "threshold": given[x], "band": ["0", "15"]}) for x in JNDS]
    for name, said in zip(JNDS, exactly(asked), strict=True):
        expected = inside(hs.evaluate(hs.parse_scene(with_jnd(MOVED[name][1]))))
        assert [x["omega"] for x in said["crossings"]] == pytest.approx([x[0] for x in expected], rel=1e-8), name
    [said] = exactly([(with_jnd(JNDS["ellipse"]), {"values": [], "threshold": {"floor": "1"}, "band": ["0", "15"]})])
    assert said == {"crossings": None, "why": "a limit is none of the scene"}
