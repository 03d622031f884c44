"""Measured responses, records and motions in files of any kind (``tablefile``), in SI.

With X the motion, F the force, H = F/X::

    impedance F/V          H = j omega Z        receptance X/F      H = 1/R
    apparent mass F/A      H = -omega^2 M       mobility V/F        H = j omega/Y
                                                accelerance A/F     H = -omega^2/A

A disc of radius rho |Y| about Y becomes one about 1/Y within rho/(1 - rho) |1/Y|; for rho >= 1 it
is unbounded.

FRD and ZMA files are Hz, magnitude (dB of 1 N/m; as it is) and degrees. A rig without its load is
subtracted in H. Begin with ``read_file``.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import takewhile
from pathlib import Path
from typing import Any

import numpy as np

from haptisym.kernel.errors import SceneError, Setting, meant, within
from haptisym.kernel.objects import counted
from haptisym.model.columns import (
    QUANTITIES,
    RECORD,
    RESPONSE,
    ColumnHeader,
    Layout,
    Scale,
    assigned,
    known_role,
    scales_of,
)
from haptisym.model.estimating import estimated
from haptisym.model.measured import CONFIDENCE, Estimator, Measurement, check_certainty, check_lines
from haptisym.model.quantities import Dimension, MotionKind, quantity
from haptisym.model.tablefile import ARRAYS, open_table, reading


@dataclass(frozen=True, eq=False)
class Given:
    """The content of a file: its columns, the numbers in SI of those in use by role, and ``place``,
    which gives the place of a row in words."""

    path: Path
    head: Sequence[ColumnHeader]
    roles: Mapping[str, int]
    scales: Mapping[str, Scale]
    rows: Mapping[str, Any]
    place: Callable[[int], str]
    notes: tuple[str, ...] = ()

    def understood(self, *more: str) -> str:
        """How the file was understood, for a page: ``10 lines; Hz, dB, deg; sorted``."""
        units = [x.unit for role, x in self.scales.items() if x.unit and role != "radius"]
        used = self.roles.values()
        unused = [x.text for i, x in enumerate(self.head) if x.text and i not in used]
        spare = ""
        if unused:
            spare = f"not used: {', '.join(unused[:5])}"
            spare += ", ..." if len(unused) > 5 else ""
        lines = counted(len(next(iter(self.rows.values()))), "line")
        notes = (lines, ", ".join(dict.fromkeys(units)), *self.notes, *more, spare)
        return "; ".join(x for x in notes if x)

    @property
    def motion(self) -> MotionKind | None:
        """The motion that the units imply; None where none does."""
        return next((x.motion for x in self.scales.values() if x.motion), None)


Check = Callable[[Sequence[ColumnHeader], Layout], dict[str, int]]
"""A function that finds the column of each role. SceneError where one is missing."""


def _read(path: Path, layout: Layout, check: Check, example: str) -> Given:
    """Read a table; ``example`` : a header for the message where there is none."""
    table, roles = open_table(
        path,
        lambda columns: check(columns, layout),
        example,
        without_header=_without_header(path, layout),
        is_counted=any(isinstance(x, int) for x in layout.columns.values()),
    )
    columns, used = table.columns, sorted(set(roles.values()))
    scales = scales_of(columns, roles, layout)
    numbers = table.numbers(used, roles.get("H"))
    rows = {role: numbers.columns[used.index(i)] for role, i in roles.items()}
    # A column called H with real numbers alone is most likely a magnitude; 799+0j says it is not.
    if "H" in rows and not rows["H"].imag.any() and not table.is_written_complex():
        raise SceneError(
            f"{columns[roles['H']].text}: has no complex numbers, as 799+30j: add a column of the "
            f"phase"
        )
    in_si = {role: row * scales[role].factor for role, row in rows.items()}
    notes = (*table.notes, *numbers.notes)

    def place(row: int) -> str:
        return f"{table.line} {numbers.places[row]}"

    return Given(path, columns, roles, scales, in_si, place, notes)


def _without_header(path: Path, layout: Layout) -> list[str]:
    """The columns of FRD and ZMA files; a unit that the scene gives stands in for the usual one."""
    usual = {"frequency": "Hz", "magnitude": "dB", "phase": "deg"}
    if path.suffix.lower() not in (".frd", ".zma"):
        return []
    if path.suffix.lower() == ".zma":
        usual["magnitude"] = "-"
    return [role if role in layout.unit else f"{role} ({unit})" for role, unit in usual.items()]


# Responses.


def _response_roles(columns: Sequence[ColumnHeader], layout: Layout) -> dict[str, int]:
    """The columns of a response: a frequency, and H, real and imag, or magnitude and phase."""
    roles = assigned(columns, RESPONSE, layout)
    listed = ", ".join(x.text for x in columns)
    if "frequency" not in roles:
        if any(known_role(x.text) == "time" for x in columns):
            raise SceneError(
                'column "time": for records in time add an estimator, as ',
                Setting("estimator", "H1"),
                " with ",
                Setting("segment", "4 s"),
                "; valid are H1, H2, joint",
            )
        raise SceneError(
            "no column of frequencies: give one, omega (rad/s) or frequency_hz, or name it, as ",
            Setting("columns", {"frequency": 1}),
            f": there are {listed}",
        )
    # "FRF" beside a phase is a magnitude.
    if "H" in roles and "phase" in roles and "magnitude" not in roles:
        roles["magnitude"] = roles.pop("H")
    forms = [x for x in ({"H"}, {"real", "imag"}, {"magnitude", "phase"}) if x & set(roles)]
    if len(forms) != 1 or not forms[0] <= set(roles):
        lacking = ", ".join(sorted(forms[0] - set(roles))) if len(forms) == 1 else "the response"
        what = "the response is there twice" if len(forms) > 1 else f"no column of {lacking}"
        raise SceneError(
            f"{what}: give the response in columns real, imag or magnitude, phase_deg, or complex "
            "as H",
            *_named(columns, roles, forms),
            f": there are {listed}",
        )
    return roles


def _named(
    columns: Sequence[ColumnHeader], roles: Mapping[str, int], forms: Sequence[set[str]]
) -> tuple[str | Setting, ...]:
    """A proposal to name the columns that lack; of the others none that has a role already."""
    spare = [x.text for i, x in enumerate(columns) if i not in roles.values()]
    wanted = ["H"] if len(spare) == 1 else ["magnitude", "phase"]
    if len(forms) == 1:
        wanted = [x for x in RESPONSE if x in forms[0] - set(roles)]
    if len(forms) > 1 or len(spare) < len(wanted):
        return ()
    named = dict(zip(wanted, spare, strict=False))
    return (" or name the columns, as " if len(named) > 1 else ", or name it, as "), Setting(
        "columns", named
    )


def _measurement(
    given: Given, layout: Layout, averages: float | None, confidence: float
) -> Measurement:
    """The measured response of a file: checked, in rising order, as force per position."""
    rows = given.rows
    omega, H, coherence, radius = (
        rows["frequency"],
        _response(given),
        rows.get("coherence"),
        rows.get("radius"),
    )
    check_certainty(coherence is not None, radius is not None, averages, confidence)
    # A sweep from high to low is a response as well: it is turned round, and errors still name the
    # lines of the file.
    place, notes = given.place, []
    last = len(omega) - 1
    if last and (np.diff(omega) < 0).all():
        omega, H, coherence, radius = (
            None if x is None else x[::-1] for x in (omega, H, coherence, radius)
        )
        place = lambda i: given.place(last - i)  # noqa: E731
        notes.append("sorted")
    check_lines(omega, H, coherence, radius, place)
    response = Measurement(
        omega, H, coherence, averages, confidence, radius, given.motion, given.path.name, given.path
    )
    if layout.sign < 0:
        response = replace(response, H=-response.H)
        notes.append("sign turned round")
    if (layout.quantity or "stiffness") != "stiffness":
        response, left = _converted(response, str(layout.quantity), place)
        notes += [str(layout.quantity).replace("-", " "), left]
    in_hertz = given.scales["frequency"].unit.endswith("Hz")
    return replace(response, understood=given.understood(*notes), in_hertz=in_hertz)


_MOST_DECIBELS = 300
"""A ratio of 1e15: above it a magnitude that a file calls dB is not in dB."""


def _response(given: Given) -> Any:
    """The complex response of a file, in its own quantity and SI."""
    rows = given.rows
    if "H" in rows:
        return rows["H"]
    if "real" in rows:
        return rows["real"] + 1j * rows["imag"]
    size, scale = rows["magnitude"], given.scales["magnitude"]
    # The factor of the unit in dB re 1 N/mm, say, was put on the dB themselves: it is taken off,
    # and put on the number that they mean.
    if scale.decibel:
        if (size / scale.factor > _MOST_DECIBELS).any():
            most = (size / scale.factor).max()
            raise SceneError(
                f"magnitude: {most:.6g} dB would be 1e{most / 20:.0f} of the unit: if it is not in "
                "dB, add ",
                Setting("unit", {"magnitude": "N/m"}),
            )
        size = scale.factor * 10 ** (size / scale.factor / 20)
    elif (size < 0).any():
        first = int(np.argmax(size < 0))
        raise SceneError(
            f"{given.place(first)}: magnitude: {size[first]:.6g} must be 0 or above; if it is in "
            "dB, add ",
            Setting("unit", {"magnitude": "dB"}),
        )
    return size * np.exp(1j * rows["phase"])


def _converted(m: Measurement, kind: str, place: Callable[[int], str]) -> tuple[Measurement, str]:
    """The response as force per position, from another quantity, and a note on what was left out:
    at 0 rad/s a derivative of motion is 0 whatever the motion."""
    order, power = QUANTITIES[kind]
    kept = m.omega > 0 if order else np.isfinite(m.omega)
    if not kept.any():
        raise SceneError(f"{kind}: there is no line above 0 rad/s")
    if power < 0 and not m.H[kept].all():
        first = int(np.argmax(kept & (m.H == 0)))
        raise SceneError(f"{place(first)}: {kind}: is 0, and force per position would be infinite")
    lines = m.at(kept)
    factor = (1j * lines.omega) ** order
    note = "" if kept.all() else "line at 0 left out"
    if power > 0:
        radius = None if lines.radius is None else lines.radius * np.abs(factor)
        return replace(lines, H=lines.H * factor, radius=radius), note
    H, radius = factor / lines.H, None
    # The disc of relative radius rho about Y becomes one within rho/(1 - rho) of 1/Y, unbounded
    # where it holds 0. It is given as a radius: coherence does not describe a disc off its centre.
    if lines.discs is not None:
        with np.errstate(divide="ignore", invalid="ignore"):
            share = lines.discs / np.abs(lines.H)
            radius = np.where(share < 1, np.abs(H) * share / (1 - share), np.inf)
    return replace(lines, H=H, coherence=None, averages=None, radius=radius), note


# Records in time.

_OFF = 0.75
"""The share of the spacing by which a sample may stand off its even place, or a step differ from
the mean step: times are rounded in files."""


def _record_roles(columns: Sequence[ColumnHeader], layout: Layout) -> dict[str, int]:
    """The columns of records in time: time, position, force, and a reference if there is one."""
    roles = assigned(columns, RECORD, layout)
    listed = ", ".join(x.text for x in columns[:20])
    if missing := [x for x in ("time", "position", "force") if x not in roles]:
        raise SceneError(
            f"no column {missing[0]}: records in time have time, position and force; or name it, "
            "as ",
            Setting("columns", {missing[0]: 1}),
            f": there are {listed}",
        )
    return roles


def read_record(
    path: Path, estimator: str, *, layout: Layout | None = None, **settings: Any
) -> Measurement:
    """The response of the records in a file; ``settings`` : as of ``estimated``. SceneError says
    what is wrong, and where."""
    stated = layout or Layout()
    with reading(path):
        given = _read(path, stated, _record_roles, "time,position,force")
        rows = given.rows
        joint = estimator.lower() == Estimator.JOINT.value
        if joint and "reference" not in rows:
            raise SceneError(
                "estimator: joint needs the column reference, the signal that drives the loop"
            )
        rate, note = _rate(given)
        response = estimated(
            rows["position"],
            stated.sign * rows["force"],
            rate,
            estimator=estimator,
            reference=rows["reference"] if joint else None,
            name=path.name,
            motion=given.motion,
            **settings,
        )
    turned = "sign turned round" if stated.sign < 0 else ""
    understood = given.understood(note, turned)
    return replace(response, path=path, understood=understood, in_hertz=True)


def _rate(given: Given) -> tuple[float, str]:
    """The samples a second, and a note where times without a unit count ns, us or ms from 1970, as
    logging programs write them. SceneError where samples are not evenly spaced."""
    t = given.rows["time"]
    for key, row in given.rows.items():
        if not np.isfinite(row).all():
            raise SceneError(
                f"{given.place(int(np.argmin(np.isfinite(row))))}: {key}: must be finite"
            )
    # Each bound is 3.2 years in its unit: no record is so long, and every clock since 1973 is
    # above.
    counts = ((1e17, 1e-9, "ns"), (1e14, 1e-6, "us"), (1e11, 1e-3, "ms"))
    unit_in_s, note = next(
        ((x, f"time in {unit} since 1970") for least, x, unit in counts if t[0] > least), (1.0, "")
    )
    if not note or given.scales["time"].unit != "SI":
        unit_in_s, note = 1.0, ""
    # The difference first: of nearby doubles it is exact, and products would be rounded again.
    t = (t - t[0]) * unit_in_s if note else t
    if len(t) < 2 or t[-1] <= t[0]:
        raise SceneError("time: must rise from sample to sample")
    step = (t[-1] - t[0]) / (len(t) - 1)
    even = t[0] + step * np.arange(len(t))
    is_off = np.abs(t - even) > _OFF * step
    jumps = np.abs(np.diff(t) - step) > _OFF * step
    if jumps.any() or is_off.any():
        first = int(np.argmax(jumps)) + 1 if jumps.any() else int(np.argmax(is_off))
        gap = f"{t[first]:.6g} s follows {t[first - 1]:.6g} s, and samples are {step:.4g} s apart"
        raise SceneError(f"{given.place(first)}: time: {gap}: resample the record evenly")
    return _plain_rate(t, step), note


def _plain_rate(t: Any, step: float) -> float:
    """The rate of samples with the fewest digits that their times allow, per second.

    Times are rounded, or shaken: a rate of 50 Hz read as 50.0000003 Hz would move every line by as
    much, and those at the ends of a band off it. The mean step is known to about its standard error
    in a fit of a straight line, and to the spacing of floats at the times.
    """
    # The least squares of t - mean = step (i - mean of all i), and three standard errors of it.
    places = np.arange(len(t)) - (len(t) - 1) / 2
    spread = float((places**2).sum())
    centred = t - t.mean()
    mean_step = float((places * centred).sum()) / spread
    residuals = centred - mean_step * places
    variance = (residuals**2).sum() / max(len(t) - 2, 1)
    error = 3 * float(np.sqrt(variance / spread))
    error += float(np.spacing(np.abs(t).max())) / len(t)
    for digits in range(1, 17):
        # Some instruments have a round rate, others a round step.
        round_rate = float(f"{1 / mean_step:.{digits}g}")
        round_step = float(f"{mean_step:.{digits}g}")
        for rate in (round_rate, 1 / round_step):
            if abs(1 / rate - mean_step) <= error:
                return rate
    return 1 / step


# Motions.


def read_motion(path: Path) -> Given:
    """Time and position of a recorded motion: columns with such names, or the only two of a table.
    SceneError otherwise."""
    return _read(path, Layout(columns={"time": 1, "position": 2}), _motion_roles, "t,x")


def _motion_roles(columns: Sequence[ColumnHeader], _: Layout) -> dict[str, int]:
    """The columns of a motion: of two columns the first is time, of more they go by their names."""
    if len(columns) == 2 and known_role(columns[1].text) != "time":
        return {"time": 0, "position": 1}
    roles = assigned(columns, {key: RECORD[key] for key in ("time", "position")}, Layout())
    if len(roles) < 2:
        listed = ", ".join(x.text for x in columns[:20])
        raise SceneError(f"give a time and a displacement, in columns t and x: there are {listed}")
    return roles


RECORDS = ("estimator", "segment", "overlap", "window", "every")
"""The keys, in a scene, of a response that is estimated from records in time."""
LAYOUT = ("columns", "unit", "quantity", "sign")
"""The keys, in a scene, that say what the columns of a file are."""

_STATED = re.compile(r"# haptisym: (averages|confidence|slope)\s*=\s*(\S.*)")


def _stated(path: Path) -> dict[str, str]:
    """The certainty that comments at the head of a file state, as ``Measurement.to_csv`` writes
    them: values by the keys averages, confidence and slope."""
    with path.open(encoding="utf-8-sig", errors="replace") as file:
        matches = takewhile(bool, map(_STATED.match, file))
        return {x[1]: x[2].strip() for x in matches if x}


def read_file(
    path: Path, averages: float | None, confidence: float | None, settings: Mapping[str, Any]
) -> Measurement:
    """The response in a file; of records in time where an estimator is named. ``settings`` : by
    ``RECORDS`` and ``LAYOUT``, and ``minus``, the path of the rig without load, read alike.

    What the file states of its lines holds where it is not given.
    """
    valid = (*RECORDS, *LAYOUT, "minus")
    for key in settings:
        if key not in valid:
            raise SceneError(
                f'unknown key "{key}": {meant(key, valid)}valid are {", ".join(valid)}'
            )
    layout = Layout(**{key: x for key, x in settings.items() if key in LAYOUT and x is not None})
    records = {key: x for key, x in settings.items() if key in RECORDS}
    if records:
        response = _estimated(path, averages, confidence, layout, records)
    else:
        with reading(path):
            response = _stated_response(path, averages, confidence, layout)
    if not (unloaded := settings.get("minus")):
        return response
    same = {key: x for key, x in settings.items() if key != "minus"}
    with within("minus"):
        return _without_rig(response, read_file(Path(unloaded), averages, confidence, same))


def _stated_response(
    path: Path, averages: float | None, confidence: float | None, layout: Layout
) -> Measurement:
    """The response in a file; its certainty as given, or else as comments in the file state it."""
    given = _read(path, layout, _response_roles, "omega,real,imag,coherence")
    comments = {} if path.suffix.lower() in ARRAYS else _stated(path)
    slope = comments.pop("slope", None)
    stated = {key: float(quantity(text, Dimension.RATIO).value) for key, text in comments.items()}
    averages = stated.get("averages") if averages is None else averages
    level = stated.get("confidence", CONFIDENCE) if confidence is None else confidence
    return replace(_measurement(given, layout, averages, level), slope=slope)


def _estimated(
    path: Path,
    averages: float | None,
    confidence: float | None,
    layout: Layout,
    records: Mapping[str, Any],
) -> Measurement:
    """The response of records in time, with what a scene states of them."""
    if not isinstance(records.get("estimator"), str):
        raise SceneError("estimator is missing: add ", Setting("estimator", "H1"), ", H2 or joint")
    if averages is not None:
        raise SceneError("averages: leave it out, as it follows from the segments")
    if layout.quantity not in (None, "stiffness"):
        raise SceneError("quantity: leave it out: of records force per position is estimated")
    level = CONFIDENCE if confidence is None else confidence
    return read_record(path, confidence=level, layout=layout, **records)


def _without_rig(loaded: Measurement, unloaded: Measurement) -> Measurement:
    """The response less that of the rig without load, H - H_0 at each line.

    If both discs hold the truth, the disc of the sum of their radii holds that of the difference.
    """
    is_same = len(loaded) == len(unloaded) and np.allclose(loaded.omega, unloaded.omega, 1e-6, 0)
    names = f"{loaded.name} and {unloaded.name}"
    if not is_same:
        raise SceneError(f"{names} have other frequencies: measure both at the same")
    radii = [x for x in (loaded.discs, unloaded.discs) if x is not None]
    if len(radii) == 1:
        raise SceneError(f"of {names} one has no discs: give coherence or radius in both")
    if len({loaded.motion, unloaded.motion} - {None}) > 1:
        raise SceneError(f"{names}: translation and rotation cannot be mixed")
    return replace(
        loaded,
        H=loaded.H - unloaded.H,
        coherence=None,
        averages=None,
        radius=sum(radii) if radii else None,
        understood=f"{loaded.understood}; less {unloaded.name}",
    )


def refuse_universal(path: Path) -> None:
    """SceneError for the name of a universal file, which is read and not written."""
    if path.suffix.lower() in (".uff", ".unv"):
        raise SceneError(f"{path.name}: universal files are not written: use CSV")
