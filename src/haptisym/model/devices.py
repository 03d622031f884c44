"""Haptic devices by name: what was read of each, every number with its source, and the effects by
which it stands between environment and hand.

The hand carries a device's mass and damping beside whatever it renders: a shunt, the last effect of
the chain. Its dry friction F is a describing function at the amplitude A of the motion, j 4 F/(pi
A). In a scene file

    [device]
    like = "one-axis"            # m, b and friction, and what is written here goes before them
    amplitude = "5 cm"           # of the motion; without it friction is left out

What the device renders at most (force, stiffness, damping), its resolution and its clock change
nothing of a linear chain: a clock is written as its first effect, resolution and force limit are
options of ``simulate``.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib.resources import files
from typing import Any, NamedTuple

from sympy import Expr

from haptisym.effects import coulomb_friction, shunt
from haptisym.kernel.errors import SceneError, meant, within
from haptisym.kernel.objects import Shown
from haptisym.model.catalogue import Effect, Named
from haptisym.model.quantities import Dimension, quantity

NUMBERS = {
    "m": Dimension.MASS,
    "b": Dimension.DAMPING,
    "friction": Dimension.FORCE,
    "resolution": Dimension.DISPLACEMENT,
    "clock": Dimension.TIME,
    "force": Dimension.FORCE,
    "stiffness": Dimension.STIFFNESS,
    "damping": Dimension.DAMPING,
}
"""The numbers that may be known of a device, and what each measures."""


class Sourced(NamedTuple):
    """A number as it is ``written``, its exact ``value`` in SI, the ``source`` in which it stands,
    and how much of that source was ``read``."""

    written: str
    value: Expr
    source: str
    read: str


@dataclass(frozen=True, repr=False)
class Device(Shown, Mapping[str, Sourced]):
    """A device: a mapping from names in ``NUMBERS`` to numbers; what was not read is not there.

    >>> from haptisym.model.devices import devices
    >>> devices["one-axis"]["b"].value, "clock" in devices["one-axis"]
    (181/50, False)
    """

    name: str
    numbers: Mapping[str, Sourced]

    def __getitem__(self, key: str) -> Sourced:
        if key not in NUMBERS:
            raise SceneError(
                f'unknown number "{key[:60]}" of a device: {meant(key, NUMBERS)}valid are '
                f"{', '.join(NUMBERS)}"
            )
        if key not in self.numbers:
            raise SceneError(
                f"device {self.name}: its {key} was not read; known are {', '.join(self)}"
            )
        return self.numbers[key]

    def __contains__(self, key: object) -> bool:
        return key in self.numbers

    def __iter__(self) -> Iterator[str]:
        return iter(self.numbers)

    def __len__(self) -> int:
        return len(self.numbers)

    def _line(self) -> str:
        return (
            f"{self.name}: {'; '.join(f'{key} = {x.written}' for key, x in self.numbers.items())}"
        )

    def effects(self, amplitude: Any = None, **given: Any) -> tuple[Effect, ...]:
        """What it puts at the hand: a shunt of its mass and damping, and its friction at an
        ``amplitude`` of the motion, m.

        ``given`` : m, b (kg, N s/m) or friction (N) in place of what was read, or where nothing
        was. SceneError where neither mass nor damping is known.

        >>> [x.name for x in devices["one-axis"].effects(amplitude="5 cm")]
        ['device', 'device-friction']
        """
        numbers: dict[str, Any] = {}
        for key in _CARRIED:
            if key in given:
                numbers[key] = given[key]
            elif key in self:
                # As it is written, so that its unit tells translation or rotation.
                numbers[key] = self[key].written
        carried = {key: numbers[key] for key in ("m", "b") if key in numbers}
        if not carried:
            raise SceneError(
                f'device {self.name}: neither mass nor damping was read: give them, as m = "45 g"'
            )
        # Friction alone has no linear dynamics: its describing function depends on the amplitude.
        if amplitude is not None and "friction" not in numbers:
            raise SceneError(
                f'device {self.name}: its friction was not read: give it, as friction = "0.2 N"'
            )
        impedance = (shunt(**carried, name="device"),)
        if amplitude is None:
            return impedance
        return *impedance, coulomb_friction(numbers["friction"], amplitude, name="device-friction")


_CARRIED = "m", "b", "friction"


def _known() -> Mapping[str, Device]:
    """The devices of the shipped table."""
    tables = tomllib.loads(
        (files("haptisym") / "data" / "devices.toml").read_text(encoding="utf-8")
    )
    return {name: Device(name, dict(_numbers(table))) for name, table in tables.items()}


devices: Mapping[str, Device] = Named("device", _known)
"""The devices that the package knows: mass, damping, friction, resolution, clock, and the most that
each renders.

>>> devices["touch"]["force"].written, devices["touch"]["force"].read
('3.3 N', 'the file')
"""


def _numbers(table: Mapping[str, Any]) -> Iterator[tuple[str, Sourced]]:
    """The numbers of a device by name. A bare value has the device's source; one in a table of its
    own may have another."""
    for key, dimension in NUMBERS.items():
        if key in table:
            entry = table[key] if isinstance(table[key], dict) else {"value": table[key]}
            row = {"source": table["source"], "read": table["read"], **entry}
            written = row["value"]
            value = quantity(written, dimension).value
            yield key, Sourced(written, value, row["source"], row["read"])


def read_device(given: Mapping[str, Any]) -> tuple[Effect, ...]:
    """The effects of a scene's table ``[device]``. SceneError names key, value and rule."""
    valid = ("like", "amplitude", *_CARRIED)
    for key in given:
        if key not in valid:
            raise SceneError(
                f'device: unknown key "{key[:60]}": {meant(key, valid)}valid are {", ".join(valid)}'
            )
    if "like" not in given:
        raise SceneError(
            'device: like is missing: give the name of a device, as like = "one-axis"; a '
            "device of your own is an effect: "
            f'[[effects]] with model = "shunt", m and b. Known are {", ".join(devices)}'
        )
    with within("device"):
        return devices[given["like"]].effects(
            **{key: x for key, x in given.items() if key != "like"}
        )
