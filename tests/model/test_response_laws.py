"""Measured responses: discs and slopes against SciPy and mpmath, lines and files up to the limits of what they may hold."""

from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from marks import required
from mpmath import mp, mpf
from scipy.io import savemat
from scipy.optimize import minimize_scalar
from scipy.stats import f as fisher

import haptisym as hs
from haptisym.model.measured import averages_for, coherence_for, disc_radius
from haptisym.model.measuring import write_sampled
from haptisym.model.quantities import MotionKind
from haptisym.model.slope import Slope, read_slope

PLAIN = "omega,real,imag\n2,93,30\n8,-30,120\n"
TRANSLATION, ROTATION = MotionKind.TRANSLATION, MotionKind.ROTATION


# Discs, and bounds on the slope.


def test_radius_coherence_and_averages_are_each_other_s_by_the_quantiles_of_f() -> None:
    rng = np.random.default_rng(7)
    for n, share in zip([2, 2.5, 4, 9, 40], rng.uniform(0.5, 0.999, 5), strict=True):
        g2 = rng.uniform(0.05, 0.999, 6)
        freedom = 2 * n - 2
        by_scipy = np.sqrt(2 / freedom * fisher(2, freedom).ppf(share) * (1 - g2) / g2)
        assert disc_radius(g2, n, share) == pytest.approx(by_scipy, rel=1e-9)
        assert coherence_for(by_scipy, n, share) == pytest.approx(g2, rel=1e-9)
        least = averages_for(by_scipy * (1 + 1e-9), g2, share)
        assert least.tolist() == [max(2, int(np.ceil(n - 1e-6)))] * 6
    assert disc_radius(0, 5) == np.inf
    assert disc_radius(1, 5) == 0
    assert averages_for(50, 0.9, 0.5) == 2  # of fewer nothing is known
    assert averages_for(0.1, 1) == 2
    assert averages_for(0.1, 0) == np.inf


def test_a_swept_disc_is_as_large_as_the_bound_allows_to_the_last_digits_and_never_smaller() -> None:
    rng = np.random.default_rng(11)
    size, radius, apart = (10.0 ** rng.uniform(-3, 3, 500) for _ in range(3))
    bound = 10.0 ** rng.uniform(-4, -0.5)
    with mp.workdps(40):
        for relative in (False, True):
            found = Slope(bound, relative, "").grown(size, radius, apart)
            for row in zip(found.tolist(), size.tolist(), radius.tolist(), apart.tolist(), strict=True):
                told, s, r, d = map(mpf, row)
                way = mpf(bound) * d
                exact = r + (s + r) * mp.expm1(way) if relative else r + way
                assert 0 <= told / exact - 1 < mpf(10) ** -14 * (1 + way)


def test_two_swept_discs_are_least_together_where_a_search_finds_it() -> None:
    rng = np.random.default_rng(12)
    for bound in (0.05, 0.4, 2.0):
        s = Slope(bound, relative=True, text="")
        first, second, apart = 10.0 ** rng.uniform(-1, 1, 20), 10.0 ** rng.uniform(-1, 1, 20), rng.uniform(0.1, 3, 20)
        for a, b, d, at in zip(first, second, apart, s.nearest((first, second), apart), strict=True):

            def together(x: float, a: float = a, b: float = b, d: float = d, s: Slope = s) -> float:
                return float(s.grown(a, 0, x) + s.grown(b, 0, d - x))

            best = min((minimize_scalar(together, bounds=(0, d), method="bounded").fun, together(0), together(d)))
            assert 0 <= at <= d
            assert together(at) <= best * (1 + 1e-9)
    for plain in (Slope(0.4, relative=False, text=""), Slope(0.0, relative=True, text="")):
        assert plain.nearest((np.array([1.0, 2]), np.array([3.0, 1])), np.array([1.0, 5])).tolist() == [0, 0]


@pytest.mark.parametrize(
    ("text", "bound", "relative", "motion", "unit"),
    [
        ("40 N*s/m", 40, False, TRANSLATION, "N*s/m"),
        ("3 N*m*s/rad", 3, False, ROTATION, "N*m*s/rad"),
        ("250 N/m/Hz", 250 / (2 * np.pi), False, TRANSLATION, "N*s/m"),
        ("20 ms", 0.02, True, None, "s"),
        ("0 s", 0, True, None, "s"),
        ("0 N*s/m", 0, False, TRANSLATION, "N*s/m"),
    ],
)
def test_a_bound_on_a_slope_tells_by_its_unit_what_it_bounds(
    text: str,
    bound: float,
    relative: bool,  # noqa: FBT001
    motion: MotionKind | None,
    unit: str,
) -> None:
    found = read_slope(text)
    assert (found.bound, found.relative, found.motion, found.text, found.unit) == (
        pytest.approx(bound, rel=1e-15), relative, motion, text, unit,
    )  # fmt: skip
    assert Slope(1.0, relative=False, text="1").unit == "N*s/m"


@pytest.mark.parametrize(
    ("given", "told"),
    [(40, '"40" has no unit'), ("40", "has no unit"), ("-1 ms", "must be >= 0"), ("-1 N*s/m", "must be >= 0"),
     ("3 kg", "bounds no slope"), ("1 N/m", "bounds no slope")],
)  # fmt: skip
def test_what_bounds_no_slope_is_said(given: Any, told: str) -> None:
    with pytest.raises(hs.SceneError) as error:
        read_slope(given)
    assert told in str(error.value)


# Lines.


@pytest.mark.parametrize(
    ("keys", "told"),
    [
        ({}, ""),
        ({"omega": [0, 1, 2]}, ""),
        ({"omega": [-1e-300, 1, 2]}, "mine: line 1: omega: -1e-300 must be a finite frequency, 0 or above"),
        ({"omega": [1, 2, np.inf]}, "line 3: omega: inf must"),
        ({"omega": [1, 3, 2]}, "line 3: the frequency 2 rad/s comes after 3: sort the lines"),
        ({"omega": [1, 2, 2]}, "line 3: the frequency 2 rad/s is there twice"),
        ({"H": [1, 2, np.inf]}, "line 3: H: "),
        ({"coherence": [0, 1, 0.5], "averages": 2}, ""),
        ({"coherence": [0, 1.0000001, 0.5], "averages": 2}, "line 2: coherence: 1 must lie from 0 to 1"),
        ({"coherence": [-1e-9, 1, 0.5], "averages": 2}, "line 1: coherence: -1e-09 must"),
        ({"coherence": [1, 1, 1], "averages": 1.99}, "averages: 1.99 must be a number from 2 on"),
        ({"coherence": [1, 1, 1], "averages": np.inf}, "averages: inf must"),
        ({"coherence": [1, 1, 1], "averages": True}, "averages: True must"),
        ({"coherence": [1, 1, 1], "averages": "9"}, "averages: 9 must"),
        ({"coherence": [1, 1, 1]}, "averages is missing"),
        ({"averages": 3}, "averages is given, but no coherence"),
        ({"radius": [0, np.inf, 1]}, ""),
        ({"radius": [0, 1, -1e-9]}, "line 3: radius: -1e-09 must be 0 or above"),
        ({"radius": [0, np.nan, 1]}, "line 2: radius: nan must"),
        ({"radius": [1, 1]}, "radius has 2 values, and omega 3"),
        ({"radius": [1, 1, 1j]}, "radius: must be real"),
        ({"radius": [1, 1, 1], "coherence": [1, 1, 1], "averages": 3}, "leave out one of them"),
        ({"radius": [1, 1, 1], "averages": 3}, "averages is given, but no coherence"),
        ({"confidence": 0}, "confidence: 0 must lie between 0 and 1"),
        ({"confidence": 1}, "confidence: 1 must"),
        ({"confidence": True}, "confidence: True must"),
        ({"confidence": "0.9"}, "confidence: 0.9 must"),
        ({"slope": "1 N*s/m"}, ""),
        ({"slope": "1 N*m*s/rad"}, ""),
    ],
)
def test_lines_may_lie_at_the_limits_of_what_they_can_be_and_not_beyond(keys: dict[str, Any], told: str) -> None:
    given: dict[str, Any] = {"omega": [1, 2, 3], "H": [1, 2j, 3], "name": "mine"} | keys
    if not told:
        assert len(hs.measured(given.pop("omega"), given.pop("H"), **given)) == 3
        return
    with pytest.raises(hs.SceneError) as error:
        hs.measured(given.pop("omega"), given.pop("H"), **given)
    assert told in str(error.value)


def test_lines_on_a_band_are_those_between_its_ends_and_a_billionth_beyond() -> None:
    at = np.array([0.9, 1 - 2e-9, 1 - 5e-10, 2, 3 * (1 + 5e-10), 3 * (1 + 2e-9), 4])
    felt = hs.measured(at, at + 1j, radius=0.1 * at)
    found = felt.on_band(1, 3)
    assert found.omega.tolist() == at[2:5].tolist()
    assert (found.H.real.tolist(), found.radius.tolist()) == (found.omega.tolist(), (0.1 * at)[2:5].tolist())
    assert not found.H.flags.writeable
    for low, high, told in (
        (3, 3, "must be above the low end"),
        (3, 1, "must be above"),
        (5, 6, "no line of measured lies"),
    ):
        with pytest.raises(hs.SceneError, match=told):
            felt.on_band(low, high)


def test_the_disc_of_a_line_without_coherence_is_the_plane_even_where_the_estimate_is_0() -> None:
    felt = hs.measured([1, 2, 3], [0, 0, 5j], coherence=[0, 0.5, 0.5], averages=9, confidence=0.8)
    assert felt.discs is not None
    assert felt.discs.tolist() == [np.inf, 0, pytest.approx(5 * float(disc_radius(0.5, 9, 0.8)), rel=1e-14)]
    assert hs.measured([1], [1]).discs is None
    assert repr(hs.measured([1], [1])) == "<Measurement measured: 1 line from 1 to 1 rad/s>"


@pytest.mark.parametrize(("motion", "unit"), [(TRANSLATION, "N/m"), (ROTATION, "N*m/rad"), (None, "")])
def test_a_table_that_is_written_names_its_columns_and_their_units_and_keeps_every_digit(
    tmp_path: Path, motion: MotionKind | None, unit: str
) -> None:
    more = {"coherence": [1 / 7, 0.9]}
    felt = hs.measured([1 / 3, 2], [0.1 + 1j / 7, -2e-30j], averages=5, **more)
    felt = type(felt)(felt.omega, felt.H, felt.coherence, 5, motion=motion)
    path = felt.to_csv(tmp_path / "out.csv")
    assert path.read_text(encoding="utf-8").splitlines() == [
        "omega,real,imag,coherence",
        f"rad/s,{unit},{unit},1",
        f"{1 / 3!r},0.1,{1 / 7!r},{1 / 7!r}",
        "2.0,-0.0,-2e-30,0.9",
    ]
    again = hs.measured(path, averages=5)
    assert again.motion is motion
    assert (again.files, felt.files) == ((path,), ())
    radius = hs.measured([1], [1], radius=[0.5]).to_csv(path).read_text(encoding="utf-8")
    assert radius == "omega,real,imag,radius\nrad/s,,,\n1.0,1.0,0.0,0.5\n"


# Files.


def told_of(path: Path, text: str, **keys: Any) -> str:
    """What is said of a table that is none; empty where nothing is."""
    path.write_text(text, encoding="utf-8")
    try:
        hs.measured(path, **keys)
    except hs.SceneError as error:
        return str(error)
    return ""


def test_units_are_by_column_in_the_header_or_in_a_row_of_their_own_and_not_in_both(tmp_path: Path) -> None:
    path = tmp_path / "bench.csv"
    known = {"omega": ("rad/s", "1/s", "-"), "real": ("N/mm", "", "-", "kN/m"), "coherence": ("1", "-")}
    for i in range(4):
        w, x, c = (known[key][i % len(known[key])] for key in ("omega", "real", "coherence"))
        times = 1000 if x in ("N/mm", "kN/m") else 1
        for text in (
            f"omega [{w}],real ({x}),imag[{x}],coherence [{c}]\n2,93,30,0.5\n",
            f"omega;real;imag;coherence\n{w};{x};{x};{c}\n2;93;30;0.5\n" if w != "-" else "",
        ):
            if text:
                path.write_text(text, encoding="utf-8")
                felt = hs.measured(path, averages=7)
                assert (felt.omega.tolist(), felt.H.tolist(), felt.coherence.tolist()) == (
                    [2],
                    [times * (93 + 30j)],
                    [0.5],
                )
                assert felt.motion is (TRANSLATION if times > 1 else None)
    polar = "frequency_hz,magnitude,phase_deg,radius\n{},N/mm,{},N/mm\n3,4,30,0.5\n"
    for hertz, factor in (("Hz", 1), ("kHz", 1000)):
        for degree in ("deg", "°", "degree", "degrees"):
            path.write_text(polar.format(hertz, degree), encoding="utf-8")
            felt = hs.measured(path)
            assert felt.omega == pytest.approx([6 * np.pi * factor], rel=1e-15)
            assert pytest.approx(4000 * (np.sqrt(3) + 1j) / 2, rel=1e-15) == felt.H[0]
            assert felt.radius == pytest.approx([500])
    row = "omega,real,imag\nrad/s,N/m,N/m\n1,2,3\n"
    for text, said in (
        (row.replace("omega,", "omega [rad/s],"), "line 2 has units, and so has the header"),
        (row.replace("rad/s,N/m,N/m", "rad/s,N/m"), "line 2 has 2 units, and the header names 3 columns"),
        (row.replace("1,2,3\n", ""), "there are no lines of numbers in it"),
        (row.replace("rad/s", "kHz"), 'omega: the unit is "kHz", and must be rad/s: call the column frequency_hz'),
        (row.replace("omega", "frequency_hz"), 'the unit is "rad/s", and must be Hz: call the column omega'),
        (row.replace("rad/s", "m"), 'the unit is "m", and must be rad/s'),
        (row.replace("N/m,N/m", "N*m/rad,N/m"), "units: translation and rotation cannot be mixed"),
        (row.replace("N/m,N/m", "kg,kg"), 'real: "1 kg" is not a stiffness: expected N/m or N*m/rad'),
        ("omega,real,imag\n1_0,2,3\n1,2,3\n", 'omega: the unit is "1_0"'),
        ("omega,real,imag\n1,2,3\n4,1_0,3\n", 'line 3: real: "1_0" is not a number'),
        ("omega,real,imag\n1,2,3\n4,5,6,7,8,9\n", "line 3 has 6 cells, and the header names 3 columns; if these are decimal"),
        ("omega;real;imag\n1;2;3\n4;5;6;7;8;9\n", "line 3 has 6 cells, and the header names 3 columns"),
        ("omega,real,imag\n1,2,3\n4,5,6,7\n", "line 3 has 4 cells, and the header names 3 columns"),
        ("omega;real;imag\n1;2;3\n4;+5,5e-1;6\n", 'line 3: real: "+5,5e-1": decimals are written with a point, as in +5.5e-1'),
        ("omega\treal\timag\n1\t2\t3\n0\t5\t6\n", "line 3: the frequency 0 rad/s comes after 1"),
        ("# a\n\nomega,real,imag\n\n1,2,3\n\n# c\n4,,6\n", "line 8: real: the cell is empty"),
        ("omega\n1\n", "the response is written real, imag or magnitude, phase_deg: there are omega"),
        ("1,2\n", "line 1 holds numbers: the first line must name the columns, as in omega,real,imag,coherence"),
        ("omega,real,imag,magnitude,phase_deg\n1,2,3,4,5\n", "the response is written real, imag or"),
        ("t,position,force\n1,2,3\n", 'column "t": a record in time'),
    ):  # fmt: skip
        assert said in told_of(path, text), text
    assert not told_of(path, "omega,real,imag\n1,2,3 # begun\n4,5,6\n")
    assert not told_of(path, '"omega";"real";"imag"\n"1";"2";"3"\n')
    for said in (told_of(path, "omega;real;imag\n1;2;3\n4;5;6;7;8;9\n"), told_of(path, row.replace("rad/s", "m"))):
        assert "decimal" not in said
        assert "call the column" not in said
    assert "; this is force per velocity" not in told_of(path, row.replace("N/m,N/m", "kg,kg"))


def test_a_line_far_down_is_named_by_its_number_whatever_stands_before_it(tmp_path: Path) -> None:
    path = tmp_path / "long.csv"
    for rows in (3, 5000, 20_001):
        lines = [f"{i + 1},{i}.5,-{i}" for i in range(rows)]
        for at in {1, rows // 2, rows - 1}:
            text = "\n".join(["# first", "omega,real,imag", "", *lines[:at], "0,1,2", *lines[at:]])
            assert f"line {at + 4}: the frequency 0 rad/s comes after {at}: sort" in told_of(path, text + "\n")
            text = text.replace("\n0,1,2\n", "\n\n# a pause\n77777,x,2\n")
            assert f'line {at + 6}: real: "x" is not a number' in told_of(path, text)


def test_what_is_no_file_is_told_by_where_it_was_looked_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "bench.csv").write_text(PLAIN, encoding="utf-8")
    (tmp_path / "sub.csv").mkdir()
    monkeypatch.chdir(tmp_path)
    for name, said in (
        (tmp_path / "xyz", f"xyz: there is no such file in {tmp_path.name}"),
        ("xyz", "xyz: there is no such file in this folder"),
        ("banch.csv", 'there is no such file; did you mean "bench.csv"?'),
        ("sup.csv", "there is no such file in this folder"),
        ("no/xyz.csv", "there is no such file, and no folder no"),
        ("sub.csv", "this is a folder: name a file in it"),
    ):
        with pytest.raises(hs.SceneError) as error:
            hs.measured(name)
        assert str(error.value).rstrip().endswith(said)
    for begins in (b"PK", b"\x89HDF", b"MATLAB", b"\x80\x04", b"\xff\xfeo", b"\xfe\xffo"):
        (tmp_path / "bench.csv").write_bytes(begins + b"mega,real,imag\n1,2,3\n")
        with pytest.raises(hs.SceneError, match="not text in UTF-8: export the columns as CSV"):
            hs.measured("bench.csv")


@pytest.mark.parametrize(
    ("keys", "told"),
    [
        ({}, ""),
        ({"H": [1, 2]}, "as many numbers as each other"),
        ({"coherence": [1, 1]}, "averages is missing"),
        ({"radius": [1, 2]}, "as many numbers as each other"),
        ({"radius": [[1], [2], [3]]}, ""),
        ({"omega": [[1, 2], [3, 4]]}, "omega: must be one row or column of numbers"),
        ({"omega": 1.0, "H": 2.0}, ""),
        ({"omega": [1, 2j, 3]}, "omega: must be real"),
        ({"omega": [1, 2, 3.5], "frequency_hz": [1, 2, 3]}, "must hold the frequencies once"),
        ({"omega": [True, False, True]}, "line 2: the frequency 0 rad/s comes after 1"),
        ({"omega": [1, 3, 3]}, "line 3: the frequency 3 rad/s is there twice"),
    ],
)
def test_variables_of_matlab_are_rows_of_one_length(tmp_path: Path, keys: dict[str, Any], told: str) -> None:
    path = tmp_path / "device.mat"
    savemat(path, {"omega": [1, 2, 3], "H": [1, 2j, 3]} | keys)
    if not told:
        found = hs.measured(path)
        assert (found.path, found.name) == (path, "device.mat")
        assert found.H.dtype == complex
        return
    with pytest.raises(hs.SceneError) as error:
        hs.measured(path)
    assert str(error.value).startswith("device.mat: ")
    assert told in str(error.value)


def test_universal_files_keep_the_digits_that_they_have_and_say_what_they_hold(tmp_path: Path) -> None:
    required("pyuff, of the extra uff,", find_spec("pyuff"))
    pyuff = import_module("pyuff")
    path, at = tmp_path / "device.uff", np.array([0.5, 1.5, 4.0])
    felt = hs.measured(2 * np.pi * at, [1 + 2j, 1 / 3, -2e-5j], coherence=[1, 1 / 7, 0], averages=5, name="n" * 99)
    hs.interop.to_uff(felt, path)
    again = hs.measured(path, averages=5)
    assert pytest.approx(felt.H, rel=1e-11, abs=1e-16) == again.H
    assert again.coherence == pytest.approx(felt.coherence, rel=1e-11)
    response, coherence = (pyuff.UFF(str(path)).read_sets(i) for i in (0, 1))
    assert response["id1"].strip() == "n" * 80
    assert [x["func_type"] for x in (response, coherence)] == [4, 6]
    assert [response[f"{x}_spec_data_type"] for x in ("abscissa", "ordinate", "orddenom")] == [18, 13, 8]
    assert [coherence[f"{x}_spec_data_type"] for x in ("abscissa", "ordinate", "orddenom")] == [18, 0, 0]
    hs.interop.to_uff(hs.measured(felt.omega, felt.H), path)  # written anew, not behind what is there
    assert hs.measured(path).coherence is None
    for above, below, fits in (
        (9, 8, True),
        (13, 0, True),
        (0, 0, True),
        (8, 8, False),
        (13, 12, False),
        (12, 8, False),
    ):
        one = response | {"ordinate_spec_data_type": above, "orddenom_spec_data_type": below}
        pyuff.UFF(str(path)).write_sets(one, "overwrite")
        told = f"not force per displacement (data types {above} over {below})"
        assert fits == (not _refusal(path)) == (told not in _refusal(path))
    for more, told in (([coherence, coherence], "must be one dataset"), ([coherence | {"x": coherence["x"] + 1}], "must be one"),
                       ([response], "2 frequency responses")):  # fmt: skip
        pyuff.UFF(str(path)).write_sets([response, *more], "overwrite")
        assert told in _refusal(path, averages=5)


def _refusal(path: Path, **keys: Any) -> str:
    try:
        hs.measured(path, **keys)
    except hs.SceneError as error:
        return str(error)
    return ""


def test_a_scene_is_sampled_evenly_and_in_a_universal_file_at_six_digits_of_each_frequency(tmp_path: Path) -> None:
    scene = hs.load_scene("fu2019").with_band("1 rad/s", "12 rad/s")
    assert hs.sampled(scene).omega.tolist() == np.linspace(1, 12, 200).tolist()
    assert len(hs.sampled(scene, points=2)) == 2
    table = hs.measured(write_sampled(scene, tmp_path / "out.csv", 7))
    assert table.omega.tolist() == np.linspace(1, 12, 7).tolist()
    required("pyuff, of the extra uff,", find_spec("pyuff"))
    for name in ("out.uff", "out.UNV"):
        found = hs.measured(write_sampled(scene, tmp_path / name, 7))
        hertz = [float(f"{w / (2 * np.pi):.5e}") for w in np.linspace(1, 12, 7)]
        assert found.omega == pytest.approx(2 * np.pi * np.array(hertz), rel=1e-14)
        assert pytest.approx(hs.sampled(scene, found.omega).H, rel=1e-10) == found.H
    for bad, told in ((1, "points: 1 must"), (2.5, "points: 2.5 must")):
        with pytest.raises(hs.SceneError, match=told):
            hs.sampled(scene, points=bad)  # type: ignore[arg-type]
    for keys, told in (({"H": [1]}, "a file has its own columns"), ({"coherence": [1]}, "its own columns"),
                       ({"radius": [1]}, "its own columns"), ({"windo": "hann"}, 'did you mean "window"?'),
                       ({"estimator": "H1", "averages": 3}, "leave it out"), ({"window": "hann"}, "estimator is missing")):  # fmt: skip
        assert told in _refusal(tmp_path / "out.csv", **keys)
    with pytest.raises(hs.SceneError, match="window: goes with a file of records in time; for arrays"):
        hs.measured([1], [1], window="hann")
    assert hs.measured(tmp_path / "out.csv", slope="1 ms").slope.bound == 1e-3
    assert (hs.measured([1], [1]).name, hs.measured([1], [1], name="arm").name) == ("measured", "arm")
