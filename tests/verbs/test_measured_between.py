"""Between the lines, by a bound on the slope: what is told is true of every response that keeps to it, and told as far as it can."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from benches import bench
from hypothesis import given
from hypothesis import strategies as st

import haptisym as hs
from haptisym.model.jndtables import read_threshold

FU = hs.load_scene("fu2019")


def environment(omega: Any) -> Any:
    s = 1j * np.asarray(omega)
    return 1.8 * s**2 + 15 * s + 100


def evaluated(omega: Any, H: Any, slope: str, radius: Any = None, **keys: Any) -> hs.MeasuredEvaluation:
    felt = hs.measured(omega, H, radius=np.zeros(len(omega)) if radius is None else radius, slope=slope)
    return hs.evaluate(hs.MeasuredScene(FU.environment, felt, **keys))


def steepest() -> float:
    """Of the paper's display on 0 to 15 rad/s: of its closed form, by its own derivative, with what a grid can miss."""
    s = 1j * np.linspace(0, 15, 20_001)
    top, low = np.polynomial.Polynomial([100, 15, 1.8]), np.polynomial.Polynomial([6400, 80, 1])
    slope = 6400 * (top.deriv()(s) * low(s) - top(s) * low.deriv()(s)) / low(s) ** 2
    return float(np.abs(slope).max() * 1.001)


def stretches(e: hs.MeasuredEvaluation, part: hs.Part | None) -> list[tuple[float, float, int]]:
    assert e.between is not None
    own = e.between.told[part]
    return list(zip(own.low.tolist(), own.high.tolist(), own.code.tolist(), strict=True))


def truth(part: hs.Part) -> float:
    [crossing] = [c for c in hs.evaluate(FU).crossings if c.part is part]
    return float(crossing.omega)


def test_what_is_told_of_an_exact_scene_is_what_its_proven_crossings_say() -> None:
    omega = np.linspace(0.5, 15, 1000)
    e = evaluated(omega, hs.sampled("fu2019", omega).H, f"{steepest():.17g} N*s/m")
    assert e.between is not None
    assert e.between.contradicted == ()
    for part in hs.Part:
        cross, told = truth(part), stretches(e, part)
        assert (told[0][0], told[-1][1]) == (0.5, 15)
        assert [low for low, _, _ in told[1:]] == [high for _, high, _ in told[:-1]]
        for low, high, code in told:
            assert code != 1 or low >= cross
            assert code != -1 or high <= cross
        open_length = sum(high - low for low, high, code in told if code == 0)
        assert open_length < 1.2
        assert all(abs(low - cross) < 0.8 and abs(high - cross) < 0.8 for low, high, code in told if code == 0)


def margins(w: float, lines: list[tuple[float, complex, float]], slope: float, part: hs.Part) -> list[float]:
    """Of both neighbouring discs at a frequency, and of the smallest around both: by how much each tells. Plain geometry."""
    (w1, c1, r1), (w2, c2, r2) = lines
    r1, r2 = r1 + slope * (w - w1), r2 + slope * (w2 - w)
    discs = [(c1, r1), (c2, r2)]
    d = abs(c2 - c1)
    cosine = (r1**2 + d**2 - r2**2) / (
        2 * r1 * d
    )  # of the angle at c1 between the other centre and a corner of the lens
    if 0 < cosine * r1 < d:
        discs.append((c1 + (c2 - c1) / d * r1 * cosine, r1 * np.sqrt(max(1 - cosine**2, 0))))
    env = complex(environment(w))
    return [abs(abs((c - env).real if part is hs.Part.REAL else (c - env).imag) - 0.1 * abs(env)) - r for c, r in discs]


def test_stretches_end_where_no_swept_disc_tells_any_more() -> None:
    omega, slope = np.linspace(1, 15, 40), 75.0
    H, radius = hs.sampled("fu2019", omega).H, np.full(40, 0.4)
    e = evaluated(omega, H, f"{slope} N*s/m", radius)
    lines = list(zip(omega.tolist(), H.tolist(), radius.tolist(), strict=True))
    seen = 0
    for part in hs.Part:
        for low, high, code in stretches(e, part):
            assert high - low > 1e-9 or code == 0
            for end, inwards in ((low, 1), (high, -1)):
                gap = int(np.searchsorted(omega, end, side="right")) - 1
                if code == 0 or np.abs(omega - end).min() < 1e-6:
                    continue
                inside, outside = (
                    margins(end + step * inwards, lines[gap : gap + 2], slope, part) for step in (1e-7, -1e-7)
                )
                assert max(inside) > 0 > max(outside)
                seen += 1
    assert seen > 80


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(6))
def test_two_lines_contradict_a_slope_where_no_way_between_them_keeps_to_it(seed: int) -> None:
    """A relative slope lets a response grow and shrink like an exponential: where two ways meet soonest is found by trying."""
    rng = np.random.default_rng(seed)
    for _ in range(4):
        omega = np.sort(rng.uniform(1, 15, 2))
        apart = omega[1] - omega[0]
        steep, sizes = rng.uniform(0.1, 1.2) / apart, rng.uniform(40, 160, 2)
        radius = rng.uniform(0, 5, 2) * rng.integers(0, 2)
        ways = np.linspace(0, apart, 10_001)
        reach = sum(
            r + (a + r) * np.expm1(steep * way) for a, r, way in zip(sizes, radius, (ways, ways[::-1]), strict=True)
        ).min()
        low, high = abs(sizes[0] - sizes[1]), sizes.sum()
        for far in (reach * 0.999, reach * 1.001):
            if not low < far < high:
                continue
            turn = np.arccos((sizes @ sizes - far**2) / (2 * sizes.prod()))
            e = evaluated(omega, sizes * np.exp([0, 1j * turn]), f"{steep:.17g} s", radius)
            assert e.between is not None
            assert bool(e.between.contradicted) == (far > reach)
    # lines of one phase: the larger one shrinks or the smaller one grows, exp(2/10 2) = 1.49 times
    for ratio in (1.49, 1.492):
        e = evaluated(np.array([3.0, 5.0]), np.array([50.0, 50 * ratio]), "0.2 s")
        assert e.between is not None
        assert bool(e.between.contradicted) == (ratio > np.exp(0.4))


class Random:
    """A response with a bound on its slope that is known by hand, lines of it with errors within their discs, and an environment."""

    def __init__(self, seed: int, *, relative: bool) -> None:
        rng = np.random.default_rng(seed)
        self.relative = relative
        self.omega = np.sort(rng.uniform(0.5, 15, rng.integers(2, 60)))
        self.at = np.concatenate([self.omega, rng.uniform(self.omega[0], self.omega[-1], 400)])
        self.gains, self.delays = rng.uniform(-40, 40, 4), rng.uniform(0, 0.5, 4)
        self.corners, self.size = rng.uniform(3, 60, 4) * rng.choice([1, -1], 4), rng.uniform(20, 200)
        true = self.truth(self.omega)
        self.radius = rng.uniform(0, 0.03, len(true)) * np.abs(true)
        self.H = true + self.radius * np.sqrt(rng.uniform(size=len(true))) * np.exp(
            2j * np.pi * rng.uniform(size=len(true))
        )

    def truth(self, omega: Any) -> Any:
        s = 1j * np.asarray(omega)[:, None]
        if self.relative:
            return self.size * np.exp(-s[:, 0] * self.delays[0]) * (1 + s / self.corners).prod(1) / (1 + s / 30)[:, 0]
        return 80 + (self.gains * np.exp(-s * self.delays)).sum(1)

    @property
    def slope(self) -> str:
        """|d exp(-j w t)/dw| = t; and of each root p of H, |d ln(1 + j w/p)/dw| = 1/|p + j w| <= 1/|p|."""
        if self.relative:
            return f"{self.delays[0] + (1 / np.abs(self.corners)).sum() + 1 / 30:.17g} s"
        return f"{float((np.abs(self.gains) * self.delays).sum()):.17g} N*s/m"


def check(seed: int, *, relative: bool) -> float:
    """That all that is told of random lines is true. Returns on which share of the frequencies something is told."""
    bench = Random(seed, relative=relative)
    e = evaluated(bench.omega, bench.H, bench.slope, bench.radius)
    assert e.between is not None
    assert e.between.contradicted == ()
    env, true = environment(bench.at), bench.truth(bench.at)
    told = 0
    for part in hs.Part:
        change = (true - env).real if part is hs.Part.REAL else (true - env).imag
        exceeds = np.abs(change) > 0.1 * np.abs(env)
        for low, high, code in stretches(e, part):
            inside = (bench.at >= low) & (bench.at <= high)
            assert code == 0 or (exceeds[inside] == (code == 1)).all()
            told += int(inside.sum()) * (code != 0)
    return told / (2 * len(bench.at))


@given(st.integers(0, 10**6), st.booleans())
def test_what_is_told_between_random_lines_is_true(seed: int, relative: bool) -> None:  # noqa: FBT001
    check(seed, relative=relative)


def test_something_is_told() -> None:
    assert np.mean([check(seed, relative=bool(seed % 2)) for seed in range(6)]) > 0.25


def test_without_a_bound_nothing_is_told_between_the_lines() -> None:
    e = hs.evaluate(hs.MeasuredScene(FU.environment, hs.measured([2.0, 8.0], [93 + 30j, -30 + 120j])))
    assert e.between is None
    assert "between" not in e.to_dict()
    assert "nothing is said between the lines" in " ".join(str(e).split())


def test_lines_that_contradict_the_bound_are_said_to_and_nothing_is_told_there() -> None:
    e = evaluated([2, 4, 6], [93 + 30j, 93 + 31j, 300 + 30j], "20 N*s/m")
    assert e.between is not None
    assert e.between.contradicted == ((4.0, 6.0),)
    assert all(code == 0 or high <= 4 for _, high, code in stretches(e, hs.Part.REAL))
    assert e.to_dict()["between"]["contradicted"] == [[4.0, 6.0]]
    assert "CONTRADICTED: in 1 gap" in " ".join(str(e).split())


def test_a_line_whose_disc_is_the_whole_plane_is_passed_over() -> None:
    omega, H = np.array([2.0, 2.1, 2.2]), np.array([93 + 30j, 500, 93 + 30j])
    e = evaluated(omega, H, "20 N*s/m", [0.1, np.inf, 0.1])
    assert [code for _, _, code in stretches(e, hs.Part.REAL)] == [-1]
    assert e.rows[1].real.value == "unresolved"


def test_one_line_has_nothing_beside_it() -> None:
    e = evaluated([2.0], [93 + 30j], "20 N*s/m")
    assert e.to_dict()["between"]["real"] == []
    assert "no two lines" in " ".join(str(e).split())


def test_an_environment_that_is_measured_too_needs_a_bound_of_its_own() -> None:
    omega = np.linspace(1, 5, 30)
    felt = hs.measured(omega, 1.3 * environment(omega), slope="40 N*s/m", radius=np.full(30, 0.1))
    own = hs.measured(omega, environment(omega), slope="30 N*s/m", radius=np.full(30, 0.1))
    e = hs.evaluate(hs.MeasuredScene(own, felt))
    assert {code for low, _, code in stretches(e, hs.Part.REAL) if low < 3} >= {1}
    assert set(e.to_dict()["between"]["slope"]) == {"perceived", "environment"}
    at = np.linspace(1, 5, 999)
    for part in hs.Part:
        change = 0.3 * environment(at) / np.abs(environment(at))
        exceeds = np.abs(change.real if part is hs.Part.REAL else change.imag) > 0.1
        for low, high, code in stretches(e, part):
            assert code == 0 or (exceeds[(at >= low) & (at <= high)] == (code == 1)).all()
    for one, other, word in (
        (own, hs.measured(omega, felt.H), "perceived"),
        (hs.measured(omega, own.H), felt, "environment"),
    ):
        with pytest.raises(hs.SceneError, match=f"{word}: slope is missing"):
            hs.MeasuredScene(one, other)


@pytest.mark.slow
@pytest.mark.parametrize(
    "jnd", ["0.08 + 0.004*omega", {"shape": "ellipse", "real": "0.08 + 0.004*omega", "imag": 0.1, "tilt": "0.05*omega"}]
)
def test_limits_that_depend_on_the_frequency_are_followed_between_lines(jnd: Any) -> None:
    omega = np.linspace(0.5, 15, 400)
    threshold = read_threshold(jnd)
    e = evaluated(omega, hs.sampled("fu2019", omega).H, f"{steepest():.17g} N*s/m", threshold=threshold)
    proven = hs.evaluate(hs.Scene(FU.environment, FU.effects, (0, 15), threshold))
    bands = [(float(b.low.omega), float(b.high.omega)) for b in proven.transparent]
    key = None if isinstance(jnd, dict) else hs.Part.IMAG
    told = stretches(e, key)
    assert sum(high - low for low, high, code in told if code) > 8
    for low, high, code in told:
        if code == -1 and key is None:
            assert any(a <= low and high <= b for a, b in bands)
        if code == 1:
            assert all(high <= a or low >= b for a, b in bands)


# As a user sees it.


def steep(folder: Path, slope: str, unit: str = "N/m") -> Path:
    omega = np.linspace(1, 15, 57)
    H = hs.sampled("fu2019", omega).H
    rows = "".join(f"{w!r},{h.real!r},{h.imag!r},1\n" for w, h in zip(omega.tolist(), H.tolist(), strict=True))
    return bench(folder, f"omega,real,imag,radius\nrad/s,{unit},{unit},{unit}\n{rows}", slope=slope)


@pytest.mark.slow
def test_the_command_line_tells_it_in_every_form(tmp_path: Path, call: Callable[..., Any]) -> None:
    scene = steep(tmp_path, '"65 N*s/m"')
    status, out, _ = call("evaluate", str(scene), "--json")
    document = json.loads(out)
    assert status == 0
    assert document["certified"] is False
    assert document["between"]["slope"] == {"perceived": {"bound": 65.0, "unit": "N*s/m", "relative": False}}
    assert document["between"] == hs.evaluate(scene).to_dict()["between"]
    latex = tmp_path / "page.tex"
    status, out, _ = call("evaluate", str(scene), "--latex", str(latex))
    text = " ".join(out.split())
    assert "slope |dH/dω| at most 65 N·s/m" in text
    assert "which was stated and is not tested" in text
    assert "Between the lines" in latex.read_text(encoding="utf-8")
    picture = hs.evaluate(scene).save_figure(tmp_path / "ratios.svg")
    assert "swept discs" in picture.read_text(encoding="utf-8")


def test_a_bound_may_be_stated_per_hertz_and_as_a_share(tmp_path: Path) -> None:
    per_hertz = hs.evaluate(steep(tmp_path, '"408.4070449666731 N/m/Hz"')).to_dict()["between"]
    assert per_hertz["slope"]["perceived"]["bound"] == pytest.approx(65, rel=1e-12)
    share = hs.evaluate(steep(tmp_path, '"600 ms"'))
    assert share.to_dict()["between"]["slope"]["perceived"] == {"bound": 0.6, "unit": "s", "relative": True}
    assert "0.6 s times |H|" in str(share)


@pytest.mark.parametrize(
    ("slope", "words"),
    [
        ("65", 'slope: "65" has no unit: give |dH/domega| with its unit'),
        ('"65"', "has no unit"),
        ('"65 N/m"', "bounds no slope"),
        ('"-65 N*s/m"', "must be >= 0"),
        ('"65 N*m*s/rad"', "translation and rotation cannot be mixed"),
        ("true", "has no unit"),
        ("[1]", "has no unit"),
    ],
)
def test_a_bound_that_is_none_is_refused_in_one_sentence(
    tmp_path: Path, call: Callable[..., Any], slope: str, words: str
) -> None:
    status, out, err = call("evaluate", str(steep(tmp_path, slope)))
    assert (status, out, err.count("\n")) == (2, "", 1)
    assert words in err
    assert "slope" in err
