"""Input that has two readings is asked back; what libraries and spreadsheets make of numbers is taken as meant."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from benches import bench
from scipy.io import savemat

import haptisym as hs

ROWS = [(0.5, 798.0817, -0.04336184), (1, 792.3286, -0.0768005), (12, 659.1, 5.25), (20, 820.5, 81.0)]


def verdicts(path: Path) -> list[tuple[str, str]]:
    return [(x.real.value, x.imag.value) for x in hs.evaluate(path).rows]


@pytest.mark.parametrize("delimiter", [";", "\t"])
def test_a_comma_that_does_not_separate_cells_stands_before_decimals(tmp_path: Path, delimiter: str) -> None:
    header = ["frequency_hz", "magnitude", "phase_deg"]
    tables = {
        "point": "\n".join([",".join(header), *(",".join(map(str, x)) for x in ROWS)]),
        "comma": "\n".join([delimiter.join(header), *(delimiter.join(map(str, x)).replace(".", ",") for x in ROWS)]),
    }
    found = {}
    for name, table in tables.items():
        (folder := tmp_path / name).mkdir()
        found[name] = hs.measured(bench(folder, table).parent / "bench.csv")
    assert (found["comma"].omega == found["point"].omega).all()
    assert (found["comma"].H == found["point"].H).all()


def test_a_radius_without_a_unit_has_that_of_h_beside_it(tmp_path: Path) -> None:
    """0.04 N/mm are 40 N/m: of |100 - 1.8 w^2 + 15 j w| at 2, 5 and 8 rad/s 0.41, 0.43 and 0.33."""
    rows = "2,0.0931,0.0294,0.04\n5,0.0551,0.0702,0.04\n8,-0.0209,0.1195,0.04\n"
    for header in ("omega,real [N/mm],imag [N/mm],radius\n", "omega,real,imag,radius\nrad/s,N/mm,N/mm,\n"):
        found = hs.evaluate(bench(tmp_path, header + rows))
        assert [round(x.radius, 2) for x in found.rows] == [0.41, 0.43, 0.33]
        assert {(x.real.value, x.imag.value) for x in found.rows} == {("unresolved", "unresolved")}


def test_a_column_without_a_unit_beside_one_that_has_one_is_asked_about(tmp_path: Path) -> None:
    with pytest.raises(hs.SceneError, match=r"imag has no unit, and real has N/mm: write imag \[N/mm\]"):
        hs.evaluate(bench(tmp_path, "omega,real [N/mm],imag\n2,0.09,0.03\n"))


def test_a_response_that_is_there_twice_is_asked_about(tmp_path: Path) -> None:
    path = tmp_path / "both.mat"
    savemat(path, {"omega": [1.0, 2.0], "H": [1 + 1j, 2 + 1j], "real": [1.0, 2.0], "imag": [1.0, 1.0]})
    with pytest.raises(hs.SceneError, match="twice, as H and as real and imag"):
        hs.measured(path)


def test_a_coherence_that_rounding_put_above_1_is_1() -> None:
    found = hs.measured([1, 2], [1 + 1j, 2 + 1j], coherence=[1 + 2**-52, 0.9], averages=10)
    assert found.coherence.tolist() == [1, 0.9]
    with pytest.raises(hs.SceneError, match="coherence: 1.01 must lie from 0 to 1"):
        hs.measured([1, 2], [1 + 1j, 2 + 1j], coherence=[1.01, 0.9], averages=10)


@pytest.mark.parametrize("sign", ["+-", "±", "+/-"])
def test_per_cent_of_per_cent_is_asked_about_with_both_readings(sign: str) -> None:
    text = '[environment]\nmodel = "kelvin-voigt"\nk = 100\nb = 2\n[evaluation]\nband = [0, 15]\n'
    with pytest.raises(hs.SceneError) as told:
        hs.parse_scene(text + f'jnd = "8 % {sign} 4 %"\n')
    assert '["4 %", "8 %", "12 %"]' in str(told.value)
    assert '["7.68 %", "8 %", "8.32 %"]' in str(told.value)
    scene = hs.parse_scene(text + 'jnd = ["4 %", "8 %", "12 %"]\n')
    assert [float(x) for x in scene.knobs["evaluation.jnd"].interval] == [0.04, 0.12]


def test_a_negative_stiffness_is_refused_with_the_way_out_and_answered_on_it() -> None:
    scene = """
[environment]
model = "{}"
[[effects]]
model = "first-order-lag"
omega_c = "500 Hz"
[evaluation]
band = ["0 Hz", "100 Hz"]
"""
    with pytest.raises(hs.SceneError, match="needs k >= 0 .*-100000 N/m.*expression.*shunt"):
        hs.parse_scene(scene.format('mass-spring-damper"\nm = "2 kg"\nk = "-100000 N/m'))
    way = 'expression"\nH = "m*s^2 + k"\nparameters = { m = "2 kg", k = "-100000 N/m" }\ntitle = "'
    found = hs.evaluate(hs.parse_scene(scene.format(way).replace('title = ""\n', "")))
    assert [(x.part.value, x.omega.digits(15)) for x in found.crossings] == [("imag", "317.365306006597")]


def test_lines_at_the_ends_of_a_band_are_in(tmp_path: Path) -> None:
    omega = 2 * np.pi * np.array([1.0, 5.0, 10.0])
    table = "omega,real,imag\n" + "".join(f"{w!r},{100.0},{5.0}\n" for w in omega.tolist())
    path = bench(tmp_path, table)
    path.write_text(path.read_text() + '\n[evaluation]\nband = ["1 Hz", "10 Hz"]\n', encoding="utf-8")
    assert len(verdicts(path)) == 3


def test_what_was_meant_is_named_where_another_was_written() -> None:
    with pytest.raises(hs.SceneError, match='did you mean "kHz"'):
        hs.effects.first_order_lag("1 khz")
    with pytest.raises(hs.SceneError, match='needs b .*model = "mass-spring-damper" with k only'):
        hs.environments.kelvin_voigt(k=100)
    with pytest.raises(hs.SceneError, match="omega: give real frequencies"):
        hs.distort(hs.environments.mass_spring_damper(k=100), hs.effects.first_order_lag(20)).compile()([1 + 2j])
