"""Files as people have them: one response in many layouts, each converted here by hand, gives one set of verdicts."""

from __future__ import annotations

import cmath
import json
import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from refusals import refusal
from scipy.io import savemat

import haptisym as hs
from haptisym.model.quantities import MotionKind

# the response that tools of measurement wrote: Hz, N/m, degrees
LINES = [
    (0.5, 798.0817, -0.04336184), (1, 792.3286, -0.0768005), (2, 769.3415, -0.07127929), (3, 731.129, 0.1159328), (4, 677.8753, 0.6260677),
    (6, 528.0101, 3.728328), (8, 331.0191, 15.58046), (12, 405.8553, 128.8488), (16, 1257.982, 143.0886), (20, 2388.216, 142.1176),
]  # fmt: skip
OMEGA = [2 * math.pi * f for f, _, _ in LINES]
H = [m * cmath.exp(1j * math.radians(p)) for _, m, p in LINES]
SCENE = '[environment]\nmodel = "mass-spring-damper"\nm = "0.2 kg"\nb = "3 N*s/m"\nk = "800 N/m"\n[perceived]\nfile = "{}"\n{}\n'

POUND_PER_INCH = 0.45359237 * 9.80665 / 0.0254

Row = Callable[[float, complex], tuple[Any, ...]]


def table(header: str, row: Row, separator: str = ",", *, falling: bool = False, commas: bool = False) -> str:
    """Lines of f (Hz) and H."""
    order = range(len(H))[::-1] if falling else range(len(H))
    text = "\n".join(separator.join(str(x) for x in row(LINES[i][0], H[i])) for i in order) + "\n"
    return header + (text.replace(".", ",") if commas else text)


def polar(f: float, h: complex) -> tuple[Any, ...]:
    return f, abs(h), math.degrees(cmath.phase(h))


def decibels(f: float, h: complex) -> tuple[Any, ...]:
    return f, 20 * math.log10(abs(h)), math.degrees(cmath.phase(h))


def derived(order: int, power: int) -> Row:
    """Force over a derivative of motion, or that turned over, as real and imaginary part."""

    def row(f: float, h: complex) -> tuple[Any, ...]:
        z = (h / (2j * math.pi * f) ** order) ** power
        return f, z.real, z.imag

    return row


def plain(f: float, h: complex) -> tuple[Any, ...]:
    return f, h.real, h.imag


def rows(names: list[str], row: Row, separator: str = ",") -> str:
    """A name, and a number for each line."""
    columns = zip(*(row(f, h) for (f, _, _), h in zip(LINES, H, strict=True)), strict=True)
    return "".join(separator.join([name, *map(str, x)]) + "\n" for name, x in zip(names, columns, strict=True))


def ltspice_polar(f: float, h: complex) -> tuple[Any, ...]:
    return f"{f:.14e}", f"({20 * math.log10(abs(h)):.14e}dB,{math.degrees(cmath.phase(h)):.14e}°)"


def ltspice(f: float, h: complex) -> tuple[Any, ...]:
    return f"{f:.15e}", f"{h.real:.15e},{h.imag:.15e}"


def cell(f: float, h: complex) -> tuple[Any, ...]:
    return f, f"{h.real!r}{h.imag:+.17g}j"


LAYOUTS: dict[str, tuple[str, str, str, str]] = {
    "decibels": ("a.csv", table("Frequency (Hz),Magnitude (dB),Phase [deg]\n", decibels), "", "10 lines; Hz, dB, deg"),
    "falling": ("a.csv", table("Frequency (Hz);Magnitude (dB re 1 N/m);Phase [deg]\n", decibels, ";", falling=True), "",
                "10 lines; Hz, dB re 1 N/m, deg; sorted"),
    "dB behind the unit": ("a.csv", table("Frequency (Hz),Magnitude (N/m) in dB,Phase (deg)\n", decibels), "", "10 lines; Hz, dB re 1 N/m, deg"),
    "dB inside": ("a.csv", table("Frequency (Hz),|H| (N/mm dB),Phase (deg)\n", lambda f, h: decibels(f, h / 1000)), "",
                  "10 lines; Hz, dB re 1 N/mm, deg"),
    "dB before the unit": ("a.csv", table("Frequency (Hz);Magnitude in dB (N/m);Phase (deg)\n", decibels, ";", commas=True),
                           'unit = { magnitude = "dB" }', "10 lines; Hz, dB re 1 N/m, deg; decimal commas"),
    "dB alone": ("a.csv", table("Frequency (Hz),Magnitude dB,Phase (deg)\n", decibels), "", "10 lines; Hz, dB, deg"),
    "one column named": ("a.csv", table("Frequency (Hz),Gain of the stick [dB re 1 N/m],Phase (deg)\n", decibels),
                         "columns = { magnitude = 2 }", "10 lines; dB re 1 N/m, Hz, deg"),
    "commas": ("a.csv", table("frequency_hz;magnitude;phase_deg\n", polar, ";", commas=True), "",
               "10 lines; Hz, magnitude: N/m or N·m/rad (no unit in the file), deg; decimal commas"),
    "commas, tabs": ("a.txt", table("Freq [Hz]\tMag [N/m]\tPhase [deg]\n", polar, "\t", commas=True), "", "10 lines; Hz, N/m, deg; decimal commas"),
    "blanks": ("a.txt", table("% from the analyser\nFrequency (Hz)   Real   Imag\n", plain, "   "), "", "10 lines; Hz, SI"),
    "blanks, commas": ("a.dat", table("* bench\n* Frequency(Hz) Real Imag\n", plain, " ", commas=True), "", "10 lines; Hz, SI; decimal commas"),
    "radians": ("a.csv", table("omega,Gain [N/mm],Phase [rad]\n", lambda f, h: (2 * math.pi * f, abs(h) / 1000, cmath.phase(h))), "",
                "10 lines; rad/s, N/mm, rad"),
    "named": ("a.csv", table("no,F,Gain,Phase\n", lambda f, h: (0, *decibels(f, h))),
              'columns = { frequency = "F", magnitude = "Gain", phase = 4 }\nunit = { frequency = "Hz", magnitude = "dB", phase = "deg" }',
              "10 lines; Hz, dB, deg; not used: no"),
    "numbered": ("a.csv", table("", decibels),
                 'columns = { frequency = 1, magnitude = 2, phase = 3 }\nunit = { frequency = "Hz", magnitude = "dB", phase = "deg" }',
                 "10 lines; Hz, dB, deg"),
    "complex": ("a.csv", table("F,FRF\n", cell), 'unit = { frequency = "Hz" }', "10 lines; Hz, SI"),
    "MATLAB's bode": ("a.csv", table("wout,mag,phase_deg\n", lambda f, h: (2 * math.pi * f, *polar(f, h)[1:])), "",
                      "10 lines; rad/s, magnitude: N/m or N·m/rad (no unit in the file), deg"),
    "WaveForms": ("a.csv", table("#Digilent WaveForms\nFrequency (Hz),Channel 1 Magnitude (dB),Channel 2 Magnitude (dB),Channel 2 Phase (*)\n",
                                 lambda f, h: (f, 0, *decibels(f, h)[1:])), "columns = { magnitude = 3, phase = 4 }",
                  "10 lines; dB, deg, Hz; not used: Channel 1 Magnitude (dB)"),
    "a preamble, units below": ("a.txt", table("Project: rig 3\nRecorded\t2026-01-02\nAverages\t20\n\nFreq\tReal\tImag\nHz\tN/m\tN/m\n", plain, "\t"),
                                "", "10 lines; Hz, N/m"),
    "a preamble as wide": ("a.csv", table("Device,Rig 3,lab\nFrequency (Hz),Real (N/m),Imag (N/m)\n", plain), "", "10 lines; Hz, N/m"),
    "a preamble": ("a.csv", table("Hammer test\nWindow,Hann\n1024,0.5\nFrequency (Hz),Real (N/m),Imag (N/m)\n", plain), "", "10 lines; Hz, N/m"),
    "LabVIEW": ("a.lvm", table("LabVIEW Measurement\t\nWriter_Version\t2\n***End_of_Header***\t\n\t\nChannels\t2\t\nX_Value\tReal\tImag\tComment\n",
                               plain, "\t"), "", "10 lines; Hz, SI"),
    "blank rows": ("a.csv", table("Frequency (Hz),Real,Imag\n", plain) + ",,\n,,\n", "", "10 lines; Hz, SI; 2 blank rows left out"),
    "the reaction": ("a.csv", table("Frequency (Hz),Real,Imag\n", lambda f, h: plain(f, -h)), "sign = -1", "10 lines; Hz, SI; sign turned round"),
    "g over N": ("a.csv", table("Frequency (Hz),Real (g/N),Imag (g/N)\n", lambda f, h: (f, *(x / 9.80665 for x in derived(2, -1)(f, h)[1:]))),
                 'quantity = "accelerance"', "10 lines; Hz, g/N; accelerance"),
    "a unit told twice": ("a.csv", table("Frequency (Hz),Real (N/m),Imag (N/m)\n", plain), 'unit = { real = "N-m/m^2", imag = "N/m" }',
                          "10 lines; Hz, N-m/m^2, N/m"),
    "an unknown unit": ("a.csv", table("Frequency (Hz),Real (N per m),Imag (N per m)\n", plain), 'unit = { real = "N/m", imag = "N/m" }',
                        "10 lines; Hz, N/m"),
    "complex, i": ("a.csv", table("f [Hz];H [N/m]\n", lambda f, h: (f, f"({h.real!r} {h.imag:+.17g}*j)"), ";", commas=True), "",
                   "10 lines; Hz, N/m; decimal commas"),
    "frd": ("a.frd", table("* Freq(Hz) SPL(dB) Phase(degrees)\n", decibels, " "), "", "10 lines; Hz, dB, deg"),
    "zma": ("a.zma", table("", polar, "\t"), "", "10 lines; Hz, magnitude: N/m or N·m/rad (no unit in the file), deg"),
    "impedance": ("a.csv", table("Frequency (Hz),real [N*s/m],imag [N*s/m]\n", derived(1, 1)), 'quantity = "impedance"',
                  "10 lines; Hz, N*s/m; impedance"),
    "apparent mass": ("a.csv", table("Frequency (Hz),real [g],imag [g]\n", lambda f, h: (f, *(1000 * x for x in derived(2, 1)(f, h)[1:]))),
                      'quantity = "apparent-mass"', "10 lines; Hz, g; apparent mass"),
    "receptance": ("a.csv", table("Frequency (Hz),real [m/N],imag [m/N]\n", derived(0, -1)), 'quantity = "receptance"',
                   "10 lines; Hz, m/N; receptance"),
    "mobility": ("a.csv", table("Frequency (Hz),real [m/s/N],imag [m/s/N]\n0,0,0\n", derived(1, -1)), 'quantity = "mobility"',
                 "11 lines; Hz, m/s/N; mobility; line at 0 left out"),
    "rows": ("a.csv", rows(["frequency_hz", "real", "imag"], plain), "", "10 lines; Hz, SI"),
    "rows with units": ("a.txt", rows(["Frequency\tHz", "Magnitude\tdB", "Phase\tdeg"], decibels, "\t"), "", "10 lines; Hz, dB, deg"),
    "LTspice, polar": ("a.txt", table("Freq.\tV(out)\n", ltspice_polar, "\t"), 'columns = { H = "V(out)" }', "10 lines; SI, Hz"),
    "LTspice": ("a.txt", table("Freq.\tV(out)\n", ltspice, "\t"), "columns = { H = 2 }", "10 lines; SI, Hz"),
    "Windows": ("a.csv", table("Frequency (Hz),Magnitude (N/m),Phase (°)\n", polar), "", "10 lines; Hz, N/m, deg"),
    "incomplete rows": ("a.csv", table("Frequency (Hz),Real,Imag\n", plain) + "21,,7\n,,\n22,1,\n", "",
                        "10 lines; Hz, SI; 1 blank row left out; 2 incomplete rows left out"),
    "frd, not in dB": ("a.frd", table("* Freq(Hz) Mag(N/m) Phase(deg)\n", polar, " "), "", "10 lines; Hz, N/m, deg"),
    "frd, a unit": ("a.frd", table("", lambda f, h: (f, abs(h) / 1000, polar(f, h)[2]), " "), 'unit = { magnitude = "N/mm" }', "10 lines; Hz, N/mm, deg"),
    "pounds": ("a.csv", table("Frequency (Hz),Real (lb/in),Imag (lbf-in^-1)\n", lambda f, h: (f, *(x / POUND_PER_INCH for x in (h.real, h.imag)))), "",
               "10 lines; Hz, lb/in, lbf-in^-1"),
    "accelerance": ("a.csv", table("Frequency (Hz),real [m/s^2/N],imag [m/s^2/N]\n", derived(2, -1)), 'quantity = "accelerance"',
                    "10 lines; Hz, m/s^2/N; accelerance"),
}  # fmt: skip


def verdicts(path: Path) -> Iterator[tuple[str, str]]:
    yield from ((x["real"], x["imag"]) for x in json.loads(hs.evaluate(path).to_json())["rows"])


@pytest.fixture(scope="module")
def expected(tmp_path_factory: pytest.TempPathFactory) -> list[tuple[str, str]]:
    """Of arrays; by hand: the ratio of each line against 10 %."""
    environment = [800 + 3j * w - 0.2 * w * w for w in OMEGA]
    ratios = [((h - e).real / abs(e), (h - e).imag / abs(e)) for h, e in zip(H, environment, strict=True)]
    return [tuple("exceeds" if abs(x) > 0.1 else "below" for x in row) for row in ratios]  # type: ignore[misc]


@pytest.mark.parametrize("name", LAYOUTS)
def test_every_layout_of_one_response_has_the_same_verdicts_and_says_what_was_understood(
    tmp_path: Path, name: str, expected: list[tuple[str, str]]
) -> None:
    file, text, keys, understood = LAYOUTS[name]
    (tmp_path / file).write_text(text, encoding="cp1252" if "°" in text else "utf-8")
    scene = tmp_path / "scene.toml"
    scene.write_text(SCENE.format(file, keys), encoding="utf-8")
    found = hs.evaluate(scene)
    felt = found.scene.perceived
    assert felt.omega == pytest.approx(OMEGA, rel=1e-13)
    assert pytest.approx(H, rel=1e-12) == felt.H.tolist()
    assert list(verdicts(scene)) == expected
    assert felt.understood == understood
    assert json.loads(found.to_json())["understood"] == {"perceived": understood}
    assert understood in " ".join(str(found).split())
    assert expected.count(("exceeds", "exceeds")) == 3
    assert [x for _, x in expected].index("exceeds") == 4


@pytest.mark.parametrize(
    "table",
    [
        {"Txy": np.array(H)[:, None], "wout": np.array(OMEGA)[:, None], "fs": 1000.0, "x": np.zeros(7)},
        {"run": {"Txy": np.array(H), "w": np.array(OMEGA), "note": "of Tuesday"}, "fs": 1000.0},
        {"sys": {"ResponseData": np.array(H)[None, None], "Frequency": np.array(OMEGA)}},
        {
            "sys": {
                "ResponseData": np.array(H)[None, None],
                "Frequency": np.array(OMEGA) / (2 * np.pi),
                "FrequencyUnit": "Hz",
            }
        },
        {"frf": {"w": np.array(OMEGA), "mag": np.abs(H), "phase_deg": np.degrees(np.angle(H))}},
    ],
)
def test_variables_and_structs_of_matlab_have_the_same_verdicts(
    tmp_path: Path, table: dict[str, Any], expected: list[tuple[str, str]]
) -> None:
    savemat(tmp_path / "a.mat", table)
    if "wout" in table:
        np.savez(tmp_path / "a.npz", **{key: np.ravel(x) for key, x in table.items()})
        assert hs.measured(tmp_path / "a.npz").H.tolist() == hs.measured(tmp_path / "a.mat").H.tolist()
    scene = tmp_path / "scene.toml"
    scene.write_text(SCENE.format("a.mat", ""), encoding="utf-8")
    assert pytest.approx(H, rel=1e-12) == hs.measured(tmp_path / "a.mat").H.tolist()
    assert list(verdicts(scene)) == expected


def hdf5(path: Path) -> None:
    h5py = pytest.importorskip("h5py")
    with h5py.File(path, "w") as file:
        group = file.create_group("run 1")
        group["frequency"], group["H"] = np.array(OMEGA) / (2 * np.pi), np.array(H)
        group["frequency"].attrs["units"] = "Hz"
        file["temperature"] = 21.5


def parquet(path: Path) -> None:
    pytest.importorskip("pyarrow")
    frame = {"Frequency (Hz)": [f for f, _, _ in LINES], "Real (N/m)": np.real(H), "Imag (N/m)": np.imag(H)}
    pytest.importorskip("pandas").DataFrame(frame).to_parquet(path)


def universal(path: Path) -> None:
    pyuff = pytest.importorskip("pyuff")
    labels = {"ordinate_axis_units_lab": "g", "orddenom_axis_units_lab": "NONE", "abscissa_axis_units_lab": "Hz"}
    kinds = {
        "ordinate_spec_data_type": 12,
        "orddenom_spec_data_type": 13,
        "abscissa_spec_data_type": 18,
        "func_type": 4,
    }
    axes = dict.fromkeys(("ordinate_axis_lab", "orddenom_axis_lab", "abscissa_axis_lab"), "axis")
    data = -(np.array(OMEGA) ** 2) / np.array(H) / 9.80665
    made = pyuff.prepare_58(
        binary=0, data=data, x=np.array(OMEGA) / (2 * np.pi), return_full_dict=True, **labels, **kinds
    )
    empty = {key: "NONE" if "lab" in key or "name" in key or key.startswith("id") else 0 for key in made}
    full = empty | {key: x for key, x in made.items() if x is not None} | axes
    pyuff.UFF(str(path)).write_sets([full], mode="overwrite")


@pytest.mark.parametrize(
    ("write", "file", "keys"),
    [(hdf5, "a.h5", ""), (parquet, "a.parquet", ""), (universal, "a.uff", 'quantity = "accelerance"')],
    ids=["HDF5", "Parquet", "UFF 58"],
)
def test_files_that_other_packages_read_have_the_same_verdicts(
    tmp_path: Path, write: Callable[[Path], None], file: str, keys: str, expected: list[tuple[str, str]]
) -> None:
    write(tmp_path / file)
    scene = tmp_path / "scene.toml"
    scene.write_text(SCENE.format(file, keys), encoding="utf-8")
    assert list(verdicts(scene)) == expected
    with pytest.raises(hs.SceneError, match="no such file"):
        hs.measured(tmp_path / f"b{file}")
    (tmp_path / file).write_bytes(b"nothing of the kind")
    with pytest.raises(hs.SceneError, match=rf"{file}: not a readable|there is no dataset 58"):
        hs.measured(tmp_path / file)


def test_of_two_structs_that_hold_a_response_none_is_taken(tmp_path: Path) -> None:
    one = {"w": np.array(OMEGA), "H": np.array(H)}
    savemat(tmp_path / "a.mat", {"first": one, "second": one})
    assert "first and second both hold a table: keep one" in refusal(hs.measured, tmp_path / "a.mat")
    savemat(tmp_path / "a.mat", {"first": one, "second": {"x": 3.0}})
    assert hs.measured(tmp_path / "a.mat").H.tolist() == H


def test_the_rig_without_load_is_subtracted_with_both_discs(tmp_path: Path) -> None:
    """Of a rig of 0.3 kg and 2 N s/m; discs of 1 and 2 N/m make one of 3 N/m."""
    rig = [2j * w - 0.3 * w * w for w in OMEGA]
    for name, response, radius in (
        ("loaded.csv", [h + r for h, r in zip(H, rig, strict=True)], 1),
        ("rig.csv", rig, 2),
    ):
        lines = (f"{w!r},{h.real!r},{h.imag!r},{radius}\n" for w, h in zip(OMEGA, response, strict=True))
        (tmp_path / name).write_text("omega,real,imag,radius\n" + "".join(lines), encoding="utf-8")
    scene = tmp_path / "scene.toml"
    scene.write_text(SCENE.format("loaded.csv", 'minus = "rig.csv"'), encoding="utf-8")
    felt = hs.evaluate(scene).scene.perceived
    assert felt.H.tolist() == pytest.approx(H, rel=1e-12)
    assert felt.discs.tolist() == [3] * 10
    assert felt.understood.endswith("; less rig.csv")
    loaded, other = tmp_path / "loaded.csv", tmp_path / "other.csv"
    turned = hs.measured(loaded, minus=tmp_path / "rig.csv", sign=-1)
    assert turned.H.tolist() == pytest.approx([-h for h in H], rel=1e-12)
    for text, why in (
        ("omega,real,imag,radius\n1,2,3,4\n", "loaded.csv and other.csv have other frequencies"),
        ("omega,real,imag\n" + "".join(f"{w!r},1,1\n" for w in OMEGA), "one has no discs"),
        ("omega,real\n1,2\n", "minus: other.csv: no column of imag"),
    ):
        other.write_text(text, encoding="utf-8")
        assert why in refusal(hs.measured, loaded, minus=other)
    scene.write_text(SCENE.format("loaded.csv", "minus = 3"), encoding="utf-8")
    assert "minus: give the name of a file" in refusal(hs.evaluate, scene)


def test_a_sign_that_is_turned_round_is_noticed(tmp_path: Path) -> None:
    scene = tmp_path / "scene.toml"
    environment = [800 + 3j * w - 0.2 * w * w for w in OMEGA]
    for turn, said in (
        (lambda h: -h, "at every point H is nearer to -H_env"),
        (lambda h: h.conjugate(), "at every point Im H is negative"),
        (lambda h: h, ""),
    ):
        lines = "".join(f"{w!r},{turn(h).real!r},{turn(h).imag!r}\n" for w, h in zip(OMEGA, environment, strict=True))
        (tmp_path / "a.csv").write_text("omega,real,imag\n" + lines, encoding="utf-8")
        scene.write_text(SCENE.format("a.csv", ""), encoding="utf-8")
        page = " ".join(str(hs.evaluate(scene)).split())
        assert said in page
        assert ("turned round?" in page) == bool(said)


@pytest.mark.parametrize("start", [0.0, 1.7e9])
@pytest.mark.parametrize("jitter", [0.0, 0.2])
def test_times_that_are_rounded_or_shaken_keep_the_lines_at_the_ends_of_a_band(
    tmp_path: Path, start: float, jitter: float
) -> None:
    """A record at 50 Hz with segments of 2 s has lines at 1 and 3 Hz, exactly."""
    rng = np.random.default_rng(3)
    x, noise = rng.normal(size=(2, 600))
    at = start + (np.arange(600) + jitter * rng.uniform(-1, 1, 600)) / 50
    lines = (f"{t:.6f},{a!r},{f!r}\n" for t, a, f in zip(at, x.tolist(), (100 * x + noise).tolist(), strict=True))
    (tmp_path / "run.csv").write_text("time [s],position [m],force [N]\n" + "".join(lines), encoding="utf-8")
    found = hs.measured(tmp_path / "run.csv", estimator="H1", segment="2 s")
    assert found.welch.rate == 50
    on_band = found.on_band(2 * math.pi * 1, 2 * math.pi * 3)
    assert (on_band.omega[[0, -1]] / (2 * math.pi)).tolist() == pytest.approx([1, 3], rel=1e-12)


@pytest.mark.parametrize("power", [1, -1])
def test_discs_of_another_quantity_hold_what_its_own_discs_hold(tmp_path: Path, power: int) -> None:
    kind, unit = ("impedance", "N*s/m") if power > 0 else ("mobility", "m/s/N")
    rows = [derived(1, power)(f, h) for (f, _, _), h in zip(LINES, H, strict=True)]
    text = "".join(f"{f},{a!r},{b!r},{0.3 * abs(complex(a, b))!r}\n" for f, a, b in rows)
    (tmp_path / "a.csv").write_text(f"Frequency (Hz),real [{unit}],imag [{unit}],radius\n{text}", encoding="utf-8")
    felt = hs.measured(tmp_path / "a.csv", quantity=kind)
    edge = np.exp(1j * np.linspace(0, 2 * np.pi, 200))
    for (f, a, b), h, radius in zip(rows, felt.H, felt.radius, strict=True):
        z = complex(a, b)
        there = (z + 0.3 * abs(z) * edge) ** power * (2j * np.pi * f)
        assert np.abs(there - h).max() == pytest.approx(radius, rel=1e-3)
    lines = [f"{row.rpartition(',')[0]},0.9" for row in text.splitlines()]
    head = f"Frequency (Hz),real [{unit}],imag [{unit}],Coherence\n"
    (tmp_path / "c.csv").write_text(head + "\n".join(lines), encoding="utf-8")
    share = math.sqrt(math.expm1(-math.log(0.05) / 19) * (1 / 0.9 - 1))
    by_coherence = hs.measured(tmp_path / "c.csv", averages=20, quantity=kind)
    assert by_coherence.discs == pytest.approx(np.abs(H) * (share if power > 0 else share / (1 - share)), rel=1e-12)


@pytest.mark.parametrize(
    ("text", "keys", "told"),
    [
        ("Frequency (Hz),Magnitude,Phase\n1,2,3\n", {}, 'Phase: the phase has no unit: add unit = { phase = "deg" }'),
        ("Frequency (Hz),Magnitude,Phase [deg]\n1,-2,3\n", {}, 'add unit = { magnitude = "dB" }'),
        ("Frequency (Hz),Impedance,Phase [deg]\n1,2,3\n", {}, 'add quantity = "impedance"'),
        ("Frequency (Hz),real [N*s/m],imag [N*s/m]\n1,2,3\n", {}, 'this is impedance: add quantity = "impedance"'),
        ("Frequency (Hz),real [N/m],imag [N/m]\n1,2,3\n", {"quantity": "mobility"}, "is no unit of mobility; this is stiffness"),
        ("w,FRF\n1,2\n", {}, "FRF: has no complex numbers"), ("f,H\n1,3j\n", {}, 'f: the frequency has no unit: add unit = { frequency = "Hz" }'), ("f,w,H\n1,2,3j\n", {}, 'two columns of frequencies, "f" and "w"'),
        ("f,H,Coherance\n1,3j,1\n", {}, 'did you mean "coherence"'), ("f,H\n1,3j\n", {"columns": {"frequency": "g"}}, 'no column "g": there are f, H'),
        ("f,H\n1,3j\n", {"columns": {"frequency": 3}}, "there are 2 columns"), ("f,H\n1,3j\n", {"columns": {"pitch": 3}}, 'unknown column "pitch"'),
        ("f,H\n1,3j\n", {"columns": 3}, "columns: give a table"), ("f,H\n1,3j\n", {"unit": {"H": 3}}, "unit: H: "), ("f,H\n1,3j\n", {"quantity": "mass"}, "quantity: "),
        ("f [Hz],H\n1,3j\n", {"unit": {"frequency": "kHz"}}, 'unit: frequency: the file has "Hz"'), ("f,H\n1,3j\n", {"unit": {"frequency": "kg"}}, 'f: "1 kg" is not a frequency'), ("w,H\n1,3j\n", {"sign": 2}, "sign: "),
        ("w,H [dB],Phase [deg],radius\n1,3,0,1\n", {}, "radius: a radius in dB"), ("w,H\n1,1j\n2,0j\n", {"quantity": "receptance"}, "line 3: receptance: is 0"),
        ("[\n1,2,3\n", {}, "no column of frequencies"), ("Freq.\tV(out)\n1.0\t2.0,3.0\n", {}, 'columns = { H = "V(out)" }'), ("f [Hz],mag [dB],phase [deg]\n1,798,3\n", {}, "798 dB would be 1e40 of the unit"),
        ("w,H,x\n1,3j\n", {}, "line 2 has 2 cells"), ("w,H,x\n1,3j,1,7\n", {}, "line 2 has 4 cells"),
        ("w,H\n0,3j\n", {"quantity": "mobility"}, "no line above 0"),
        ("f,H,Phase [deg]\n1,2,3\n", {"unit": {"H": "N/m"}}, "unit: H: the columns in use are frequency, phase, magnitude"),
        ("phase_deg [rad],f,mag\n1,2,3\n", {}, 'phase_deg: the unit must be deg, not "rad"'),
        ("f,Size of H,Phase [deg],Coherence\n1,2,3,1\n", {}, 'no column of magnitude: give the response in columns real, imag or magnitude, phase_deg, or complex as H, or name it, as columns = { magnitude = "Size of H" }: there'),
        ("f [Hz],Size of H,Turn,Coherence\n1,2,3,1\n", {}, 'as columns = { magnitude = "Size of H", phase = "Turn" }'),
        ("f [Hz],Coherence\n1,1\n", {}, "or complex as H: there are f [Hz], Coherence"),
        ("f [Hz],Gain (N/m),Phase (deg)\n1,2,3\n", {"unit": {"magnitude": "dB"}}, 'unit: magnitude: the file has "N/m"'),
    ],
    ids=range(32),
)  # fmt: skip
def test_nothing_is_guessed_where_several_meanings_are_usual(
    tmp_path: Path, text: str, keys: dict[str, Any], told: str
) -> None:
    (tmp_path / "a.csv").write_text(text, encoding="utf-8")
    said = refusal(hs.measured, tmp_path / "a.csv", **keys)
    assert told in said
    assert said.startswith(("a.csv: ", "columns", "unit", "quantity", "sign"))


@pytest.mark.parametrize(
    ("header", "start", "tick"),
    [
        ("time,/joint_states/position[0],/joint_states/effort[0]", 0.0, 1.0),
        ("%time,field.header.seq,field.position0,field.effort0", 1.6e18, 1e9),
        ("__time,/arm/joint_states/elbow/velocity,/arm/joint_states/elbow/position,/wrench/force", 1.6e9, 1.0),
    ],
)
def test_records_with_the_headers_of_ros_are_estimated_as_their_columns_are(
    tmp_path: Path, header: str, start: float, tick: float
) -> None:
    rng = np.random.default_rng(4)
    x = rng.normal(size=400)
    f = 100 * x + rng.normal(size=400)
    more = [0.5] * (header.count(",") - 2)
    rows = (
        [f"{start + tick * i / 50:.6f}", *map(str, more), repr(a), repr(b)]
        for i, (a, b) in enumerate(zip(x.tolist(), f.tolist(), strict=True))
    )
    (tmp_path / "run.csv").write_text(header + "\n" + "\n".join(map(",".join, rows)) + "\n", encoding="utf-8")
    found = hs.measured(tmp_path / "run.csv", estimator="H1", segment="1 s")
    by_arrays = hs.estimated(x, f, 50, segment=1)
    assert found.omega == pytest.approx(by_arrays.omega, rel=1e-4)
    assert pytest.approx(by_arrays.H, rel=1e-9) == found.H
    assert ("since 1970" in found.understood) == (tick > 1)


def test_of_two_joints_the_scene_names_one(tmp_path: Path) -> None:
    first, second, force = np.random.default_rng(2).normal(size=(3, 400)).tolist()
    rows = "\n".join(f"{i / 50},{first[i]!r},{second[i]!r},{force[i]!r}" for i in range(400))
    path = tmp_path / "run.csv"
    path.write_text(f"time,position[0],position[1],effort[0]\n{rows}\n", encoding="utf-8")
    said = refusal(hs.measured, path, estimator="H1")
    assert 'two columns of position, "position[0]" and "position[1]"' in said
    found = hs.measured(path, estimator="H1", columns={"position": "position[1]"})
    one = hs.estimated(second, force, 50)
    assert pytest.approx(one.H, rel=1e-9) == found.H
    assert "not used: position[0]" in found.understood


def test_a_question_proposes_what_answers_it_where_it_is_asked(call, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    """The options that the errors propose are typed one after the other, until the file is read as by hand."""
    path, scene = tmp_path / "a.csv", tmp_path / "scene.toml"
    text = table("Frequency,Gain of it,Phase,Coherence\n", lambda f, h: (*decibels(f, h), 1 - 1e-6))
    path.write_text(text, encoding="utf-8")
    words: list[str] = []
    for option in (
        ["--columns", "magnitude=Gain of it"],
        ["--unit", "frequency=Hz"],
        ["--unit", "phase=deg"],
        ["--averages", "10"],
        ["--environment", "mass-spring-damper"],
    ):
        status, _, err = call("identify", str(path), *words)
        typed = f'{option[0]} "{option[1]}"' if " " in option[1] else " ".join(option)
        assert (status, typed in err, " = " in err) == (2, True, False), err
        words += option
    status, out, _ = call("identify", str(path), *words, "--unit", "magnitude=dB")
    assert (status, "10 lines; dB, Hz, deg" in out) == (0, True)
    scene.write_text(SCENE.format("a.csv", ""), encoding="utf-8")
    for verb in ("identify", "evaluate"):
        status, _, err = call(verb, str(scene))
        assert (status, 'columns = { magnitude = "Gain of it" }' in err, "--" in err) == (2, True, False)


NAMED = "--columns frequency=F --columns magnitude=Gain --columns phase=4 --unit frequency=Hz --unit magnitude=dB --unit phase=deg"


@pytest.mark.parametrize(
    ("text", "options"),
    [
        (table("no,F,Gain,Phase\n", lambda f, h: (0, *decibels(f, h))), NAMED),
        (table("frequency_hz,real,imag\n", derived(1, 1)), "--quantity impedance"),
    ],
)
def test_identify_takes_what_a_file_does_not_say(call, tmp_path: Path, text: str, options: str) -> None:  # type: ignore[no-untyped-def]
    plainly, other = tmp_path / "plain.csv", tmp_path / "other.csv"
    plainly.write_text(table("frequency_hz,real,imag\n", plain), encoding="utf-8")
    other.write_text(text, encoding="utf-8")
    found = []
    for words in ([str(plainly)], [str(other), *options.split()]):
        status, out, _ = call("identify", *words, "--environment", "mass-spring-damper", "--json")
        assert status == 0
        found.append([x["value"] for x in json.loads(out)["parameters"]])
        # No file has a unit of the response: in the scene each parameter has one all the same.
        scene = hs.parse_scene(json.loads(out)["scene"])
        assert [x.motion for x in scene.parameters] == [MotionKind.TRANSLATION] * 3
    assert found[1] == pytest.approx(found[0], rel=1e-6)
    status, _, err = call("identify", str(other), "--environment", "mass-spring-damper", "--columns", "F")
    assert (status, "--columns F: write it as ROLE=COLUMN" in err) == (2, True)
