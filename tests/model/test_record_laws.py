"""Records in time against spectra that are summed by hand: estimates, their discs, how many averages, the cube, even sampling."""

from __future__ import annotations

from pathlib import Path
from statistics import NormalDist
from typing import Any

import numpy as np
import pytest
from scipy.stats import beta

import haptisym as hs
from haptisym.model.estimating import WINDOWS
from haptisym.model.quantities import MotionKind
from haptisym.model.recordfile import read_record
from haptisym.model.welch import Welch

COSINES = {"hann": (0.5, 0.5), "hamming": (0.54, 0.46), "blackman": (0.42, 0.5, 0.08), "boxcar": (1.0,)}


def window(name: str, length: int) -> Any:
    """A sum of cosines, of which the next one would begin another period."""
    at = 2 * np.pi * np.arange(length) / length
    return sum((-1) ** k * a * np.cos(k * at) for k, a in enumerate(COSINES[name]))


def segments(w: Any, shift: int, row: Any) -> Any:
    """The spectrum of every segment, its mean taken off."""
    starts = range(0, len(row) - len(w) + 1, shift)
    return np.array([np.fft.rfft(w * (row[i : i + len(w)] - row[i : i + len(w)].mean())) for i in starts])


def alike(w: Any, shift: int, count: int) -> float:
    """How many segments there would be if none shared samples: count^2 over the sum of all squared correlations."""
    rows = np.zeros((count, shift * count + len(w)))
    for i in range(count):
        rows[i, i * shift : i * shift + len(w)] = w
    return float(count**2 / np.square(rows @ rows.T / (w @ w)).sum())


def runs(seed: int, noise: float, size: int = 400) -> tuple[Any, Any, Any]:
    """A reference, the motion that it drives, and the force."""
    rng = np.random.default_rng(seed)
    r = rng.normal(size=size)
    x = np.convolve(r, [0.3, 0.5, 0.2])[:size] + noise * rng.normal(size=size) + 2
    return r, x, np.convolve(x, [90, -25, 8])[:size] + 40 * noise * rng.normal(size=size)


CASES = [
    ("H1", "hann", 0.5, 1, None),
    ("H1", "hamming", 0.75, 3, 0.5),
    ("H2", "blackman", 0.6, 2, 0.64),
    ("H2", "boxcar", 0.0, 1, 0.4),
    ("joint", "hamming", 0.25, 2, 0.72),
    ("Joint", "hann", 0.9, 1, 0.8),
]


@pytest.mark.parametrize(("way", "name", "overlap", "every", "segment"), CASES)
def test_an_estimate_and_its_discs_are_those_of_segments_that_are_cut_by_hand(
    way: str, name: str, overlap: float, every: int, segment: float | None
) -> None:
    r, x, f = runs(3, 0.2)
    kind = way if way in ("H1", "H2") else "joint"
    given = {"reference": r} if kind == "joint" else {}
    found = hs.estimated(
        x,
        f,
        "50 Hz",
        estimator=way,
        segment=segment,
        overlap=overlap,
        window=name,
        every=every,
        confidence=0.9,
        **given,
    )
    length = 400 // 8 if segment is None else round(segment * 50)
    shift = round(length * (1 - overlap))
    R, X, F = (segments(window(name, length), shift, row)[:, every : length // 2 : every] for row in (r, x, f))
    n = alike(window(name, length), shift, len(X))
    hertz = (np.fft.rfftfreq(length, 1 / 50))[every : length // 2 : every]
    assert found.omega == pytest.approx(2 * np.pi * hertz, rel=1e-12)
    assert found.welch is not None
    assert found.welch.averages == pytest.approx(n, rel=1e-9)
    assert (found.welch.segments, found.welch.shift, found.welch.length) == (len(X), shift, length)
    xx, ff, xf = (np.mean(np.conj(a) * b, axis=0) for a, b in ((X, X), (F, F), (X, F)))
    g2 = np.abs(xf) ** 2 / (xx * ff).real
    chance = float(beta(1, n - 1).ppf(0.9))  # of the coherence of what has nothing to do with each other
    if kind == "H1":
        assert pytest.approx(xf / xx, rel=1e-9) == found.H
        assert found.coherence == pytest.approx(g2, rel=1e-9)
        assert found.averages == found.welch.averages
        return
    assert found.coherence is found.averages is None
    turns = np.exp(1j * np.linspace(0, 2 * np.pi, 401))
    if kind == "H2":
        assert pytest.approx(ff / np.conj(xf), rel=1e-9) == found.H
        share = np.sqrt(chance / (1 - chance) * (1 - g2) / g2)
        for H, own, radius in zip(found.H, share, found.radius, strict=True):
            farthest = np.inf if own >= 1 else np.abs(H / (1 + own * turns) - H).max()  # of X/F a disc, turned over
            assert radius == pytest.approx(farthest, rel=1e-4)
        return
    for i, (H, radius) in enumerate(zip(found.H, found.radius, strict=True)):
        rr, rx, rf = (np.mean(np.conj(R[:, i]) * row) for row in (R[:, i], X[:, i], F[:, i]))
        assert pytest.approx(rf / rx, rel=1e-9) == H
        if abs(rx) ** 2 <= chance * rr.real * xx[i].real:
            assert radius == np.inf
            continue

        def excess(z: Any, i: int = i, of: Any = (rr, rx, rf)) -> Any:
            rest = np.mean(np.abs(F[:, i] - z[..., None] * X[:, i]) ** 2, axis=-1)
            return np.abs(of[2] - z * of[1]) ** 2 - chance * of[0].real * rest

        a, b, c = (excess(H + k * turns) for k in (-1.0, 0.0, 1.0))  # a parabola on each ray
        bend, slope = (a + c) / 2 - b, (c - a) / 2
        farthest = ((-slope + np.sqrt(slope**2 - 4 * bend * b)) / (2 * bend)).max()
        assert radius == pytest.approx(farthest, rel=1e-4)


@pytest.mark.few(1)
@pytest.mark.parametrize("name", WINDOWS)
def test_as_many_independent_segments_as_the_mean_has_the_variance_of(name: str) -> None:
    x, f = np.random.default_rng(1).normal(size=(2, 203))
    for overlap in (0, 0.3, 0.5, 0.77, 0.9):
        found = hs.estimated(x, f, 1, segment=31, overlap=overlap, window=name).welch
        assert found is not None
        assert (found.shift, found.segments) == (round(31 * (1 - overlap)), 1 + (203 - 31) // found.shift)
        assert found.averages == pytest.approx(alike(window(name, 31), found.shift, found.segments), rel=1e-9)


def cube_by_hand(x: Any, f: Any, length: int, shift: int, averages: float) -> float | None:
    """Conditioned spectra of the cube of the predicted force, on every second line."""
    w = window("hann", length)
    X, F = segments(w, shift, x), segments(w, shift, f)
    xx, ff = np.mean(np.abs(X) ** 2, axis=0), np.mean(np.abs(F) ** 2, axis=0)
    xf = np.mean(np.conj(X) * F, axis=0)
    told = np.abs(xf) ** 2 > 0.5 * xx * ff
    told[0] = False
    spectrum = np.fft.rfft(x)
    for i in range(len(spectrum)):
        place = i * length / len(x)
        low = min(int(place), length // 2)
        high, share = min(low + 1, length // 2), place - low
        known = told[low] if share < 1e-9 else told[low] and told[high]
        h = (1 - share) * (xf / xx)[low] + share * (xf / xx)[high]
        spectrum[i] *= h if known else 0
    predicted = np.fft.irfft(spectrum, len(x))
    if not predicted.any():
        return None
    u = predicted / predicted.std()
    C = segments(w, shift, u**3 - 3 * u)
    above = below = 0.0
    for i in range(2, length // 2, 2):
        line = [z[:, i] for z in (C, F)]
        c, y = (z - X[:, i] * (np.vdot(X[:, i], z) / np.vdot(X[:, i], X[:, i])) for z in line)  # less what x explains
        above += np.vdot(c, y).real / np.vdot(y, y).real
        below += np.vdot(c, c).real / np.vdot(y, y).real
    return float(above / below * np.sqrt(2 * (averages - 1) * below))


@pytest.mark.parametrize(("seed", "most"), [(1, np.inf), (2, 1.5), (3, 0.8)])
def test_the_cube_is_what_conditioned_spectra_tell_of_the_predicted_force(seed: int, most: float) -> None:
    rng = np.random.default_rng(seed)
    x = rng.normal(size=997)
    slow = np.convolve(x, np.ones(9) / 9, "same")  # the lines above have no coherence
    force = 100 * np.clip(slow, -most, most) + 15 * rng.normal(size=997)
    found = hs.estimated(x, force, 1, segment=48).welch
    assert found is not None
    by_hand = cube_by_hand(x, force, 48, 24, found.averages)
    assert found.cube == pytest.approx(by_hand, rel=1e-6)
    assert by_hand is not None
    assert most > 1 or by_hand < -1.5


def test_of_what_does_not_follow_the_motion_no_cube_is_told() -> None:
    x, f = np.random.default_rng(8).normal(size=(2, 4000))
    found = hs.estimated(x, f, 1, segment=50).welch
    assert found is not None
    assert found.cube is found.cube_chance is None


def test_the_chance_of_a_cube_is_that_of_a_normal_number_either_way_and_settings_are_told_in_a_sentence() -> None:
    way = hs.estimated(*runs(1, 0.1)[1:], 50, segment=1.28, overlap=0.75).welch
    assert way is not None
    for errors in (-2.5, -0.3, 0.0, 1.7):
        own = Welch(**{**vars(way), "cube": errors})
        assert own.cube_chance == pytest.approx(2 * NormalDist().cdf(-abs(errors)), rel=1e-12)
    assert way.words == (
        "H1 by Welch's method: 400 samples at 50 Hz, 22 segments of 64 samples (1.28 s), window hann, overlap 75 %, mean taken "
        f"off; as good as {way.averages:.4g} independent averages; one line of 2"
    )
    assert Welch(**{**vars(way), "every": 1}).words.endswith("averages; every line")
    told = way.row()
    assert told == {
        "estimator": "H1", "samples": 400, "rate_hz": 50.0, "window": "hann", "segment": 64, "shift": 16, "segments": 22,
        "averages": way.averages, "every": 2, "cube": way.cube, "cube_probability": way.cube_chance,
    }  # fmt: skip


@pytest.mark.parametrize(
    ("size", "ways", "told"),
    [
        (64, {"segment": 16, "overlap": 0}, ""),
        (63, {"segment": 16, "overlap": 0}, "63 samples make 3 segments of 16"),
        (64, {"segment": 15, "overlap": 0}, "64 samples make 4 segments of 15"),
        (40, {"segment": 16, "overlap": 0.5}, ""),
        (9, {"segment": 16}, "9 samples make 0 segments of 16"),
        (128, {}, ""),
        (127, {}, "segments of 15"),
        (400, {"overlap": 0.9}, ""),
        (400, {"overlap": 0.91}, "overlap: 0.91 must lie from 0 to 0.9"),
        (400, {"overlap": -0.01}, "overlap: -0.01 must"),
        (400, {"overlap": True}, "overlap: True must"),
        (400, {"overlap": "0.5"}, "overlap: 0.5 must"),
        (900, {"every": 55}, ""),
        (900, {"every": 56}, "no line that is kept"),
        (9000, {"every": 100}, ""),
        (9000, {"every": 101}, "every: 101 must"),
        (400, {"segment": 0}, "segment: 0 must be > 0"),
        (400, {"window": "gauss"}, 'window: "gauss" is none'),
        (400, {"estimator": "h1"}, ""),
        (400, {"estimator": "H4"}, 'estimator: "H4" is none: valid are H1, H2, joint'),
    ],
)
def test_settings_are_taken_up_to_their_limits_and_refused_beyond(size: int, ways: dict[str, Any], told: str) -> None:
    x, f = np.random.default_rng(2).normal(size=(2, size))
    if not told:
        assert len(hs.estimated(x, f, 1, **ways)) > 0
        return
    with pytest.raises(hs.SceneError) as error:
        hs.estimated(x, f, 1, **ways)
    assert told in str(error.value)


def test_a_rate_is_samples_a_second_or_has_a_unit_and_rows_must_be_finite_and_move() -> None:
    _, x, f = runs(5, 0.1)
    plain = hs.estimated(x, f, 50)
    for rate in ("50 Hz", "50", "0.05 kHz", "50 1/s"):
        assert hs.estimated(x, f, rate).omega == pytest.approx(
            plain.omega / (2 * np.pi if "1/s" in rate else 1), rel=1e-14
        )
    bad = np.where(np.arange(400) == 7, np.inf, f)
    for given, told in (((x, bad, 50), "force: sample 8 is not finite"), ((x, f, 0), "rate: 0 must be > 0"),
                        ((x, f[1:], 50), "force has 399 samples, and position 400"), ((0 * x + 3, f, 50), "position: all samples are 3")):  # fmt: skip
        with pytest.raises(hs.SceneError) as error:
            hs.estimated(*given)
        assert told in str(error.value)


def table(t: Any, rows: Any, header: str) -> str:
    return (
        header
        + "\n"
        + "".join(f"{a!r},{b!r},{c!r}\n" for a, b, c in zip(t.tolist(), *(x.tolist() for x in rows), strict=True))
    )


def test_a_file_of_records_is_the_estimate_of_its_columns_in_si_at_the_mean_rate(tmp_path: Path) -> None:
    r, x, f = runs(6, 0.1)
    t = 3 + np.arange(400) / 50
    shaken = t + np.random.default_rng(1).uniform(-0.3, 0.3, 400) / 50  # two neighbours are at most 0.6 of a step off
    shaken[[0, -1]] = t[[0, -1]]
    path = tmp_path / "run.csv"
    path.write_text(table(1000 * shaken, (x, f), "t [ms],position [mm],force [N]"), encoding="utf-8")
    found, plain = read_record(path, "H1", segment="1 s"), hs.estimated(x / 1000, f, 50, segment=1)
    assert pytest.approx(plain.H, rel=1e-9) == found.H
    assert found.omega == pytest.approx(plain.omega, rel=1e-12)
    assert (found.path, found.name, found.motion, found.files) == (path, "run.csv", MotionKind.TRANSLATION, (path,))
    rows = zip(t.tolist(), x.tolist(), f.tolist(), r.tolist(), strict=True)
    path.write_text(
        "t,position,force,reference [V]\n" + "".join(f"{','.join(map(repr, row))}\n" for row in rows), encoding="utf-8"
    )
    found, plain = read_record(path, "joint"), hs.estimated(x, f, 50, estimator="joint", reference=r)
    assert pytest.approx(plain.H, rel=1e-9) == found.H
    assert found.motion is None
    assert pytest.approx(read_record(path, "H1").H, rel=1e-9) == hs.estimated(x, f, 50).H  # which asks for no reference


def even(size: int) -> Any:
    return np.arange(size) / 50


@pytest.mark.parametrize(
    ("t", "told"),
    [
        (even(400) + np.where(np.arange(400) == 100, 0.0148, 0), ""),
        (even(400) + np.where(np.arange(400) == 100, 0.0152, 0), "line 102: t: 2.0152 s follows 1.98 s"),
        (even(400) - np.where(np.arange(400) == 100, 0.0152, 0), "line 102: t: 1.9848 s follows 1.98 s"),
        (even(400) + 0.0148 * np.sin(np.pi * np.arange(400) / 399), ""),
        (
            even(400) + 0.03 * np.sin(np.pi * np.arange(400) / 399),
            "line 69: t: 1.3551 s follows 1.3349 s, and samples are 0.02 s apart",
        ),
        (even(400)[::-1], "t: must rise"),
        (0 * even(400), "t: must rise"),
    ],
)
def test_samples_stand_at_most_three_quarters_of_a_step_from_their_places_and_the_first_beyond_is_named(
    tmp_path: Path, t: Any, told: str
) -> None:
    _, x, f = runs(6, 0.1)
    path = tmp_path / "run.csv"
    path.write_text(table(t, (x, f), "t,position,force"), encoding="utf-8")
    if not told:
        assert read_record(path, "H1").welch.rate == pytest.approx(50, rel=1e-12)  # type: ignore[union-attr]
        return
    with pytest.raises(hs.SceneError) as error:
        read_record(path, "H1")
    assert told in str(error.value)
