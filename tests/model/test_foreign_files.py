"""Measured responses in universal files (UFF58) and files of MATLAB: they come back as they went, and what they are not is said."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from marks import required
from scipy.io import savemat

import haptisym as hs

Called = Callable[..., tuple[int, str, str]]
OMEGA = np.array([1.0, 2.5, 7.0])
H = np.array([93 + 30j, -31 + 120j, 1 / 3 - 2j])
SCENE = '[environment]\nmodel = "kelvin-voigt"\nk = "100 N/m"\nb = "2 N*s/m"\n[perceived]\nfile = "{}"\n'


def refused(path: Path, call: Called, told: str, *lines: str) -> None:
    scene = path.parent / "bench.toml"
    scene.write_text(SCENE.format(path.name) + "\n".join(lines), encoding="utf-8")
    status, out, err = call("evaluate", str(scene))
    assert (status, out) == (2, "")
    assert err.count("\n") == 1
    assert told in err
    assert path.name in err


# MATLAB.


@pytest.mark.parametrize(
    "table",
    [
        {"omega": OMEGA, "H": H},
        {"frequency_hz": OMEGA / (2 * np.pi), "real": H.real, "imag": H.imag},
        {"omega": OMEGA[:, None], "H": H[:, None], "notes": "of Tuesday"},
    ],
)
def test_a_file_of_matlab_holds_a_response(tmp_path: Path, table: dict[str, Any]) -> None:
    savemat(tmp_path / "device.mat", table | {"coherence": [0.9, 0.99, 1]})
    felt = hs.measured(tmp_path / "device.mat", averages=9)
    assert felt.omega == pytest.approx(OMEGA, rel=1e-15)
    assert np.array_equal(felt.H, H)
    assert np.array_equal(felt.coherence, [0.9, 0.99, 1])


@pytest.mark.parametrize(
    ("table", "told"),
    [
        ({"H": H}, "hold the frequencies once"),
        ({"omega": OMEGA, "frequency_hz": OMEGA, "H": H}, "hold the frequencies once"),
        ({"omega": OMEGA, "real": H.real}, "H, or real and imag"),
        ({"omega": OMEGA, "H": H[:2]}, "as many numbers"),
        ({"omega": OMEGA, "H": np.ones((3, 2))}, "H: must be one row or column"),
        ({"omega": OMEGA, "H": "text"}, "H: must be one row or column"),
        ({"omega": H, "H": H}, "omega: must be real"),
        ({"omega": OMEGA[::-1], "H": H}, "sort the lines"),
        ({"omega": OMEGA, "H": H * np.nan}, "line 1: H"),
        ({"omega": OMEGA, "H": H, "coherence": OMEGA / 7}, "averages is missing"),
    ],
)
def test_a_bad_file_of_matlab_is_refused_in_one_sentence(
    tmp_path: Path, call: Called, table: dict[str, Any], told: str
) -> None:
    savemat(tmp_path / "device.mat", table)
    refused(tmp_path / "device.mat", call, told)


@pytest.mark.parametrize(
    "data", [b"", b"omega,real,imag\n", b"\x89HDF\r\n\x1a\n" + bytes(600), b"MATLAB 7.3 MAT-file" + bytes(500)]
)
def test_what_is_no_file_of_matlab_is_refused_in_one_sentence(tmp_path: Path, call: Called, data: bytes) -> None:
    (tmp_path / "device.mat").write_bytes(data)
    refused(tmp_path / "device.mat", call, "MATLAB" if b"7.3" not in data else "")


# Universal files.


@pytest.fixture
def pyuff() -> Any:
    required("pyuff, of the extra uff,", find_spec("pyuff"))
    return import_module("pyuff")


@pytest.mark.usefixtures("pyuff")
def test_a_universal_file_brings_back_what_was_written(tmp_path: Path) -> None:
    hertz = np.array([0.25, 1, 1.75])
    felt = hs.measured(2 * np.pi * hertz, H, coherence=[0.9, 0.99, 0.5], averages=9)
    again = hs.measured(hs.interop.to_uff(felt, tmp_path / "device.uff"), averages=9)
    assert again.omega == pytest.approx(felt.omega, rel=1e-15)
    assert np.abs(again.H - H).max() < 1e-11 * np.abs(H).max()
    assert again.coherence == pytest.approx(felt.coherence, rel=1e-11)


@pytest.mark.usefixtures("pyuff")
def test_a_scene_is_written_at_frequencies_that_the_file_can_say(tmp_path: Path, call: Called) -> None:
    path = tmp_path / "fu2019.unv"
    status, _, err = call("evaluate", "fu2019", "--response", str(path), "--points", "31")
    assert (status, "response written to" in err) == (0, True)
    felt = hs.measured(path)
    assert len(felt) == 31
    assert np.abs(felt.H / hs.sampled("fu2019", felt.omega).H - 1).max() < 1e-10
    (tmp_path / "bench.toml").write_text(SCENE.format(path.name), encoding="utf-8")
    assert call("evaluate", str(tmp_path / "bench.toml"))[0] == 0


def test_what_is_no_force_per_displacement_is_refused(tmp_path: Path, call: Called, pyuff: Any) -> None:
    path = hs.interop.to_uff(hs.measured(OMEGA, H), tmp_path / "device.uff")
    text = path.read_text(encoding="utf-8")
    path.write_text(
        text.replace("        13    0", "        12    0").replace("         8    0", "        13    0"),
        encoding="utf-8",
    )
    refused(path, call, "not force per displacement (data types 12 over 13)")


def test_none_or_two_responses_are_refused(tmp_path: Path, call: Called, pyuff: Any) -> None:
    path = hs.interop.to_uff(hs.measured(OMEGA, H), tmp_path / "device.uff")
    text = path.read_text(encoding="utf-8")
    path.write_text(text + "\n" + text.lstrip("\n"), encoding="utf-8")
    refused(path, call, "there are 2 frequency responses in it")
    for data in ("", "omega,real,imag\n1,1,1\n"):
        path.write_text(data, encoding="utf-8")
        refused(path, call, "device.uff")
    refused(tmp_path / "none.uff", call, "no such file")
