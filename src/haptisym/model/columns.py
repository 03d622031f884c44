"""The meaning of the columns of a measured file: their roles, by name or as a scene states them,
and their units in SI.

Each column of a table, or variable of MATLAB, has a role: with a frequency it is part of a
response, with a time part of a record, from which a response is estimated. A role follows from the
name and its unit ("Magnitude (dB)", "position [mm]", "/joint_states/position[0]"), or a scene
states it: ``columns`` (role to header, or number from 1), ``unit`` (of a role), and
``quantity`` (what the response is). A role that two columns could have, and a column without a unit
where several units are usual, are refused: a wrong guess would be a wrong response in silence.

``assigned`` finds the roles, ``scales_of`` the units.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from fractions import Fraction
from functools import partial
from typing import NamedTuple

import numpy as np

from haptisym.kernel.errors import SceneError, Setting, meant, quoted
from haptisym.model.quantities import Dimension, MotionKind, quantity, read_unit


@dataclass(frozen=True)
class Layout:
    """What a scene states about a file. SceneError for an unknown role, quantity or sign.

    ``columns`` : role to header or number from 1. ``unit`` : role to unit. ``quantity`` : what the
    response is, a key of QUANTITIES. ``sign`` : -1 where the force that was measured is the
    reaction to the one that is meant.
    """

    columns: Mapping[str, str | int] = field(default_factory=dict)
    unit: Mapping[str, str] = field(default_factory=dict)
    quantity: str | None = None
    sign: int = 1

    def __post_init__(self) -> None:
        for key, kinds in (("columns", str | int), ("unit", str)):
            given = getattr(self, key)
            example, kind = (
                ("F", "a header, or a number from 1") if key == "columns" else ("Hz", "a unit")
            )
            if not isinstance(given, Mapping):
                raise SceneError(f'{key}: give a table, as {key} = {{ frequency = "{example}" }}')
            for role, x in given.items():
                if role not in _ROLES:
                    valid = ", ".join(_ROLES)
                    raise SceneError(
                        f"{key}: unknown column {quoted(role)}: {meant(role, _ROLES)}valid "
                        f"are {valid}"
                    )
                if (
                    not isinstance(x, kinds)
                    or isinstance(x, bool)
                    or (isinstance(x, str) and not x.strip())
                ):
                    raise SceneError(f"{key}: {role}: {quoted(x)} must be {kind}")
        if self.quantity is not None and self.quantity not in list(QUANTITIES):
            near, valid = meant(str(self.quantity), QUANTITIES), ", ".join(QUANTITIES)
            raise SceneError(
                f"quantity: {quoted(self.quantity)} is unknown: {near}valid are {valid}"
            )
        if isinstance(self.sign, bool) or self.sign not in (1, -1):
            raise SceneError(
                f"sign: {quoted(self.sign)} must be 1, or -1 for a force that is measured as "
                f"the reaction"
            )


QUANTITIES = {
    "stiffness": (0, 1),
    "impedance": (1, 1),
    "apparent-mass": (2, 1),
    "receptance": (0, -1),
    "mobility": (1, -1),
    "accelerance": (2, -1),
}
"""The quantities that a response may be: (n, 1) is force over the n-th derivative of motion, and
(n, -1) the inverse of that."""
RESPONSE = {
    "frequency": "omega w wout frequency freq f hz angular_frequency x_value",
    "H": "h frf txy tf response responsedata z " + " ".join(QUANTITIES).replace("-", "_"),
    "real": "real re",
    "imag": "imag im imaginary",
    "magnitude": "magnitude mag gain amplitude modulus abs spl |h|",
    "phase": "phase angle arg",
    "coherence": "coherence coh cxy gamma2",
    "radius": "radius",
}
RECORD = {
    "time": "t time timestamp x_value",
    "position": "position pos x q displacement",
    "force": "force effort torque f",
    "reference": "reference ref",
}
# Roles go by the last word of a header in lower letters. x_value is LabVIEW's name of the first
# column, which is frequency in a response and time in a record.
_PLURAL = {"frequency": "frequencies", "time": "times"}
_ROLES = (*RESPONSE, *RECORD)
# Where a scene states a column of one form, those of the other forms are not looked for by name.
_FORMS = [[{"H"}, {"real", "imag"}, {"magnitude", "phase"}], [{"coherence"}, {"radius"}]]
# Units that may end a column's name, as in phase_deg.
_SUFFIXES = {
    "hz": "Hz",
    "khz": "kHz",
    "deg": "deg",
    "rad": "rad",
    "n": "N",
    "s": "s",
    "ms": "ms",
    "us": "us",
    "ns": "ns",
    "m": "m",
    "mm": "mm",
}


_HERTZ = {"hz": 2 * np.pi, "khz": 2000 * np.pi}
_RADIANS = {"rad/s": 1.0, "1/s": 1.0, "rad/sec": 1.0}
_DEGREES = dict.fromkeys(("deg", "°", "degree", "degrees", "*"), np.pi / 180)
"""``*`` is how Digilent's WaveForms writes the sign of degrees."""
_RAD = dict.fromkeys(("rad", "radian", "radians"), 1.0)


class ColumnHeader(NamedTuple):
    """A column by its header, in name and unit: ``real [N/m]`` has both, and so has
    ``phase_deg``."""

    text: str
    name: str
    unit: str

    @property
    def bare(self) -> str:
        """The name without topic, namespace and index, in lower letters: ``position`` for
        ``/joint_states/position[0]`` and ``field.position0``."""
        last = re.split(r"[/.]", re.sub(r"[\[.]?\d+\]?$", "", self.name).rstrip("."))[-1]
        return re.sub(r"[\s_-]+", "_", last.lstrip("%#_ ").lower()).strip("_")


# dB as a word of a header, and what 0 dB is where that follows: "dB re 1 N/m".
_DECIBEL = re.compile(
    r"(?:\bin\s+)?(?:(?<![^\W_])(?i:db)|(?<=[a-z])dB)(?![^\W_])(?:\s*re\b([^\])]*))?"
)


def column_of(cell: str) -> ColumnHeader:
    """Name and unit of a header, in dB where that stands anywhere in it; SceneError where two units
    contradict each other.

    >>> column_of("Gain (N/m) in dB")[1:], column_of("Gain [dB re 1 N/m]")[1:], column_of("mag_dB")[1:]
    (('Gain', 'dB re 1 N/m'), ('Gain', 'dB re 1 N/m'), ('mag', 'dB'))
    """
    found = _DECIBEL.search(cell)
    if found is None:
        return _linear(cell)
    rest = _linear(re.sub(r"\(\s*\)|\[\s*\]", "", _DECIBEL.sub("", cell)).strip())
    reference = re.sub(r"^1\s*(?=[^\d.])", "", (found[1] or rest.unit).strip(" ,;:/([)]"))
    name = rest.name.strip(" ,;:-_") or cell
    return ColumnHeader(cell, name, f"dB re 1 {reference}" if reference else "dB")


def _linear(cell: str) -> ColumnHeader:
    """Name and unit of a header, dB aside; SceneError where two units contradict each other."""
    # A number in brackets is an index of an array, and V(out) a voltage: no unit.
    match = not re.match(r"[VI]\(", cell) and re.fullmatch(
        r"(.*\S)\s*[\[(]((?:[^\[\]()]|\([^()]*\))*)[\])]", cell
    )
    name, unit = (
        (match[1].strip(), match[2].strip())
        if match and not match[2].strip().isdigit()
        else (cell, "")
    )
    suffix = re.fullmatch(r"(.+)_([A-Za-z]+)", name)
    if suffix and suffix[2].lower() in _SUFFIXES:
        return ColumnHeader(cell, suffix[1], agreed(name, _SUFFIXES[suffix[2].lower()], unit))
    return ColumnHeader(cell, name, unit)


def agreed(name: str, implied: str, unit: str) -> str:
    """The unit of a column whose name implies one, as ``phase_deg``; SceneError where the unit that
    is written contradicts it."""
    own, other = implied.lower(), unit.lower()
    if unit in ("", "-") or own == other or any({own, other} <= set(x) for x in (_HERTZ, _DEGREES)):
        return implied if unit in ("", "-") else unit
    hint = f": call the column {'omega' if other in _RADIANS else name.rpartition('_')[0]}"
    raise SceneError(f"{name}: the unit must be {implied}, not {quoted(unit)}{hint}")


def assigned(
    columns: Sequence[ColumnHeader], names: Mapping[str, str], layout: Layout
) -> dict[str, int]:
    """The index of the column of each role in ``names``. SceneError where a role has two columns,
    or where an unknown name resembles one of a role."""
    roles = {role: _place(columns, role, x) for role, x in layout.columns.items() if role in names}
    if misplaced := [x for x in layout.columns if x not in names]:
        raise SceneError(f"columns: {misplaced[0]}: here it is one of {', '.join(names)}")
    others = {role for forms in _FORMS for role in _others(forms, set(roles))}
    role_of = {word: role for role, words in names.items() for word in words.split()}
    for i, x in enumerate(columns):
        role = role_of.get(x.bare)
        # What the scene states goes before names.
        if i in roles.values() or role in layout.columns or role in others:
            continue
        # An unknown column is left out, unless it looks like a misspelt role: "freqency" left out
        # would end in a message about a missing column. Short words resemble too much.
        if role is None:
            if (
                layout.columns
                or known_role(x.text)
                or "(" in x.name
                or not (hint := meant(x.bare, [y for y in role_of if len(y) > 3]))
            ):
                continue
            raise SceneError(
                f"unknown column {quoted(x.text)}: {hint}else name the columns, as ",
                Setting("columns", {next(iter(names)): 1}),
            )
        if role in roles:
            both = f"{quoted(columns[roles[role]].text)} and {quoted(x.text)}"
            raise SceneError(
                f"two columns of {_PLURAL.get(role, role)}, {both}: leave out one, or write ",
                Setting("columns", {role: x.text}),
            )
        roles[role] = i
    return roles


def _others(forms: Sequence[set[str]], stated: set[str]) -> set[str]:
    """The roles of the forms of which none is stated, where another form is."""
    apart = [form for form in forms if not form & stated]
    return set().union(*apart) if len(apart) < len(forms) else set()


def _place(columns: Sequence[ColumnHeader], role: str, wanted: str | int) -> int:
    """The index of the column that a scene states for a role, by its number or its header."""
    if isinstance(wanted, int):
        if not 1 <= wanted <= len(columns):
            raise SceneError(
                f"columns: {role}: there are {len(columns)} columns, and {wanted} is none of them"
            )
        return wanted - 1
    # As it is written first; letters of another case only where that finds nothing.
    spelt = [{x.text, x.name} for x in columns]
    for names, name in ((spelt, wanted), ([{y.lower() for y in x} for x in spelt], wanted.lower())):
        places = [i for i, spellings in enumerate(names) if name in spellings]
        if len(places) == 1:
            return places[0]
        if places:
            raise SceneError(
                f"columns: {role}: {len(places)} columns have the name {quoted(wanted)}: "
                f"give a number from 1"
            )
    listed = ", ".join(x.text for x in columns)
    raise SceneError(f"columns: {role}: there is no column {quoted(wanted)}: there are {listed}")


def _unit(role: str, column: ColumnHeader, layout: Layout) -> str:
    """The unit of a column: the header's, or else the scene's; SceneError where both state one and
    they differ in size."""
    if not column.unit and column.text.count("[") != column.text.count("]"):
        name = column.text.partition("[")[0].strip() or role
        raise SceneError(f'{quoted(column.text)}: write the unit in brackets, as in "{name} [mm]"')
    own = "" if column.unit == "-" else column.unit
    stated = layout.unit.get(role, "")
    if not (own and stated) or own.lower() == stated.lower():
        return own or stated
    # "dB" alone leaves to the header what 0 dB is. Else two spellings of one unit agree. A header
    # that is not understood leaves the word to the scene; one that is understood and has another
    # scale contradicts it.
    if stated.lower() == "db" and own.lower().startswith("db "):
        return own
    wanted = _scale(role, stated, column, layout)
    with suppress(SceneError):
        if _scale(role, own, column, layout)._replace(unit=wanted.unit) != wanted:
            own = stated
    if own == stated:
        raise SceneError(
            f"unit: {role}: the file has {quoted(column.unit)}: leave out {quoted(stated)}"
        )
    return stated


# Units.


class Scale(NamedTuple):
    """How numbers of a column become SI: the ``factor`` by which they are multiplied, their unit as
    it was understood, the motion that it implies, and whether they are in decibels of that unit."""

    factor: float
    unit: str
    motion: MotionKind | None = None
    decibel: bool = False


def scales_of(
    columns: Sequence[ColumnHeader], roles: Mapping[str, int], layout: Layout
) -> dict[str, Scale]:
    """The scale of the column of each role. SceneError where a unit is missing, is another
    quantity's or is unknown."""
    if unused := [x for x in layout.unit if x not in roles]:
        raise SceneError(f"unit: {unused[0]}: the columns in use are {', '.join(roles)}")
    units = {role: _unit(role, columns[i], layout) for role, i in roles.items()}
    sizes = [x for x in ("H", "real", "imag", "magnitude") if x in roles]
    named, bare = [x for x in sizes if units[x]], [x for x in sizes if not units[x]]
    if named and bare:
        unit = units[named[0]]
        raise SceneError(
            f"{bare[0]} has no unit, and {named[0]} has {unit}: write {bare[0]} [{unit}]"
        )
    if named and not units.get("radius", "is not there"):
        units["radius"] = units[named[0]]
    if units.get("radius", "").lower().startswith("db"):
        raise SceneError("radius: a radius in dB is none of a disc: give its unit, as radius [N/m]")
    scales = {
        role: _scale(role, unit, columns[roles[role]], layout) for role, unit in units.items()
    }
    if len({x.motion for x in scales.values() if x.motion}) > 1:
        raise SceneError("units: translation and rotation cannot be mixed")
    return scales


def _scale(role: str, unit: str, column: ColumnHeader, layout: Layout) -> Scale:
    """The scale of a column with this role and unit."""
    if role == "frequency":
        return _frequency_scale(unit, column)
    if role == "phase":
        if not unit:
            raise SceneError(
                f"{column.text}: the phase has no unit: add ",
                Setting("unit", {"phase": "deg"}),
                ", or rad",
            )
        return Scale(
            _listed(column.text, unit, _DEGREES | _RAD),
            "deg" if unit.lower() in _DEGREES else "rad",
        )
    if role == "coherence":
        return Scale(_listed(column.text, unit or "1", {"1": 1.0, "%": 0.01}), "")
    if role in RECORD:
        return _record_scale(role, unit)
    return _size_scale(role, unit, column, layout)


def _listed(name: str, unit: str, known: Mapping[str, float], hint: str = "") -> float:
    """The factor of a unit from a list; SceneError with the first two of the list for another."""
    if unit.lower() not in known:
        raise SceneError(
            f"{name}: the unit must be {' or '.join(list(known)[:2])}, not {quoted(unit)}{hint}"
        )
    return known[unit.lower()]


def _frequency_scale(unit: str, column: ColumnHeader) -> Scale:
    """The scale of frequencies: to rad/s. Without a unit the name must tell it."""
    if column.bare == "omega":
        hint = ": call the column frequency_hz" if unit.lower() in _HERTZ else ""
        return Scale(_listed("omega", unit or "rad/s", _RADIANS, hint), "rad/s")
    # As MATLAB and python-control name frequencies in rad/s.
    if not unit and column.bare in ("w", "wout", "angular_frequency"):
        return Scale(1.0, "rad/s")
    # LabVIEW writes spectra over Hz, and LTspice names them "Freq."
    if not unit and column.bare not in ("hz", "x_value") and column.text != "Freq.":
        raise SceneError(
            f"{column.text}: the frequency has no unit: add ",
            Setting("unit", {"frequency": "Hz"}),
            ", or rad/s",
        )
    known = _HERTZ | _RADIANS
    if unit and unit.lower() not in known:
        try:
            return Scale(float(quantity(f"1 {unit}", Dimension.FREQUENCY).value), unit)
        except SceneError as error:
            raise error.within(column.text) from None
    factor = known[(unit or "Hz").lower()]
    return Scale(factor, "rad/s" if factor == 1 else "Hz" if factor < 10 else "kHz")


def _size_scale(role: str, unit: str, column: ColumnHeader, layout: Layout) -> Scale:
    """The scale of a response or a radius: to N/m and its multiples by s, or to their inverses."""
    order, power = QUANTITIES[layout.quantity or "stiffness"]
    by_name = column.bare.replace("_", "-")
    if (
        role != "radius"
        and layout.quantity is None
        and by_name in QUANTITIES
        and by_name != "stiffness"
    ):
        raise SceneError(
            f"{column.text}: add ",
            Setting("quantity", by_name),
            ", or stiffness if it is force per position",
        )
    # "dB", "dB re 1 N/m", "dB (N/m)": the unit behind dB is what 0 dB is.
    decibel = re.fullmatch(r"(?i:db)\s*(?:\(|\[|(?i:re)\b)?\s*1?\s*(.*?)[\])]?", unit)
    if decibel and role not in ("H", "magnitude"):
        raise SceneError(f"{column.text}: {quoted(unit)}: only a magnitude is in dB")
    linear_unit = decibel[1] if decibel else unit
    if not linear_unit:
        # A magnitude may be in dB as well: what it is taken for is said in full.
        si = "N/m or N·m/rad" if (order, power) == (0, 1) else "SI"
        bare = f"magnitude: {si} (no unit in the file)" if role == "magnitude" else "SI"
        return Scale(1.0, "dB" if decibel else bare, decibel=bool(decibel))
    try:
        if (order, power) == (0, 1):
            read = quantity(f"1 {linear_unit}", Dimension.STIFFNESS)
            return Scale(float(read.value), unit, read.motion, bool(decibel))
        value, powers = read_unit(linear_unit, linear_unit, "", partial(_measures, order, power))
    except SceneError as error:
        raise SceneError(
            f"{column.text}: {str(error).rstrip('.')}", *_otherwise(linear_unit)
        ) from None
    # About an axis N m per rad: force over motion has the length squared, along a line none.
    length = power * powers.get("length", 0)
    if not _measures(order, power, powers):
        raise SceneError(
            f"{column.text}: {quoted(linear_unit)} is no unit of {layout.quantity}",
            *_otherwise(linear_unit, layout.quantity),
        )
    return Scale(
        float(value), unit, MotionKind.ROTATION if length else MotionKind.TRANSLATION, bool(decibel)
    )


def _measures(order: int, power: int, powers: Mapping[str, Fraction]) -> bool:
    """Whether base dimensions are those of force over the derivative of this order, along a line or
    about an axis."""
    # [F]/[d^n x/dt^n] = kg m s^-2/(m s^-n) = kg s^(n-2); N m/rad adds m^2.
    mass, length, time = (power * powers.get(x, 0) for x in ("mass", "length", "time"))
    return (mass, time) == (1, order - 2) and length in (0, 2)


def _otherwise(unit: str, own: str | None = "stiffness") -> tuple[str | Setting, ...]:
    """A hint at the quantity that has this unit, except ``own``; empty where none has."""
    for name, (order, power) in QUANTITIES.items():
        fits = partial(_measures, order, power)
        with suppress(SceneError):
            if name != own and fits(read_unit(unit, unit, "", fits)[1]):
                return f"; this is {name.replace('-', ' ')}: add ", Setting("quantity", name)
    return ()


_DIMENSIONS = {
    "time": Dimension.TIME,
    "position": Dimension.DISPLACEMENT,
    "force": Dimension.FORCE,
    "reference": Dimension.ANY,
}


def _record_scale(role: str, unit: str) -> Scale:
    """The scale of a column of a record; that of a reference is 1, as any other would cancel."""
    if not unit or role == "reference":
        return Scale(1.0, unit or "SI")
    try:
        read = quantity(f"1 {unit}", _DIMENSIONS[role])
    except SceneError as error:
        raise SceneError(f"{'t' if role == 'time' else role}: {error}") from None
    return Scale(float(read.value), unit, read.motion)


def is_unit(cell: str) -> bool:
    """Whether a cell can stand in a row of units: a unit, or nothing."""
    if cell.lower() in ("", "-", *_HERTZ, *_RADIANS, *_DEGREES, *_RAD) or _DECIBEL.match(cell):
        return True
    with suppress(SceneError):
        read_unit(cell, cell, "")
        return True
    return False


def known_role(name: str) -> str:
    """The role that a header has by its name; empty where it has none."""
    bare = column_of(name).bare
    return next((role for role, words in (RESPONSE | RECORD).items() if bare in words.split()), "")
