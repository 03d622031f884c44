"""What a sweep varies, and the variables that it computes for each set of values.

Numbers of a scene are varied by their paths, with values that are checked like the scene's own
(``axes``). The variables of a set are named by the criteria and hands of the scene
(``SweepVariables``).
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from haptisym.judge.crossings import noticed
from haptisym.kernel.errors import SceneError, need
from haptisym.kernel.reals import ExactNumber
from haptisym.model.catalogue import Hand
from haptisym.model.scene import Knob, Scene

AxisValues: TypeAlias = "Sequence[Any] | ArrayLike"


@dataclass(frozen=True)
class SweepAxis:
    """One dimension of a sweep: a path such as ``effects.filter.omega_n``, its values (SI, rad/s)
    and their unit."""

    knob: Knob
    values: NDArray[np.float64]

    @property
    def path(self) -> str:
        """The path of what varies, as in a scene file."""
        return self.knob.path

    @property
    def unit(self) -> str:
        """The unit of the values; empty where it is not known."""
        return self.knob.unit_in(self.knob.motion)


def axes(scene: Scene, vary: Mapping[str, AxisValues]) -> tuple[SweepAxis, ...]:
    """The dimensions of a sweep. SceneError for an unknown path, no values, or a value that the
    model does not allow.

    Values are floats, taken as exactly these binary numbers, or strings with units, taken as the
    nearest double in SI units.
    """
    need("vary", vary, Mapping, 'give values by path, as {"effects.filter.omega_n": [20, 40]}')
    if not vary:
        raise SceneError(
            f"vary: name a parameter; valid are {', '.join(x.path for x in scene.knobs)}"
        )
    chosen = scene.knobs.chosen(vary)
    scene.knobs.need_numbers(chosen)
    return tuple(map(_axis, chosen, vary.values()))


def _axis(knob: Knob, values: AxisValues) -> SweepAxis:
    """One dimension; SceneError for values that are none, not finite, double, or not allowed."""
    # a string is one value, though it is a sequence
    each = (
        [values] if isinstance(values, str) else np.asarray(values, dtype=object).ravel().tolist()
    )
    floats = np.array([_float(knob, x) for x in each], dtype=np.float64)
    if not len(floats):
        raise SceneError(f"{knob.path}: give at least one value")
    if not np.isfinite(floats).all():
        raise SceneError(f'{knob.path}: "{floats[~np.isfinite(floats)][0]}" must be finite')
    if len(np.unique(floats)) < len(floats):
        raise SceneError(f"{knob.path}: each value may be given only once")
    # every rule for a value is one about an interval, so that the extremes decide for all
    for extreme in (floats.min(), floats.max()):
        knob.check(Decimal(repr(float(extreme))))
    return SweepAxis(knob, floats)


def _float(knob: Knob, given: Any) -> float:
    """A value as a float, SI; SceneError where it is no number."""
    if isinstance(given, str):
        return float(ExactNumber(knob.number(given)))
    try:
        return float(given)
    except (TypeError, ValueError):
        raise SceneError(
            f'{knob.path}: "{given}" is not a number, or a string of number and unit'
        ) from None


def spaced(text: str, scene: Scene) -> tuple[str, list[float]]:
    """A path and its values from ``PATH=LO:HI:N`` or ``PATH=LO:HI:N:log``: N values from LO to HI,
    evenly or by equal ratios.

    >>> from haptisym.model.scenefile import load_scene
    >>> spaced("effects.filter.omega_n=10 rad/s:20 Hz:3", load_scene("fu2019"))
    ('effects.filter.omega_n', [10.0, 67.83185307179586, 125.66370614359172])
    """
    path, _, span = text.partition("=")
    fields = [x.strip() for x in span.split(":")]
    if len(fields) not in (3, 4) or (len(fields) == 4 and fields[3] not in ("log", "lin")):
        raise SceneError(
            f'"{text}" is not PATH=LO:HI:N or PATH=LO:HI:N:log, as in '
            f"effects.filter.omega_n=40:200:100"
        )
    count = int(fields[2]) if fields[2].isdigit() else 0
    if not 2 <= count <= _MOST_VALUES:
        raise SceneError(
            f'{path}: "{fields[2]}" must be a whole number of values, from 2 to {_MOST_VALUES}'
        )
    low, high = _axis(scene.knobs[path], fields[:2]).values.tolist()
    if fields[-1] != "log":
        return path, np.linspace(low, high, count).tolist()
    if low * high <= 0:
        raise SceneError(
            f'{path}: "{span}": a logarithmic sweep needs ends of one sign, other than 0'
        )
    return path, np.geomspace(low, high, count).tolist()


_MOST_VALUES = 10_000_000


ABSENT, UNKNOWN = float("nan"), -1
# the largest signed number of 16 bits, in which counts are stored
INFINITE = 32767
"""Stands for infinitely many roots, a chain of them that lies on the right or comes as near to the
axis as one likes."""
FLOAT, EXACT, OPEN = 0, 1, 2
"""By which method a set was answered: floats with a bound; exactly; not at all, as it stayed
undecided or has no dynamics."""
HELD = "unstable_"
"""What the variable of a hand begins with."""
SYSTEMS = ("environment", "perceived")
_PER_SECOND, _ONE = "rad/s", "1"


@dataclass(frozen=True)
class SweepVariables:
    """The variables of a sweep of a scene; ``criteria``: the names of what is judged; ``hands``: by
    their variables."""

    criteria: tuple[str, ...]
    hands: Mapping[str, str]

    @classmethod
    def of(cls, scene: Scene) -> SweepVariables:
        """The variables of a sweep of this scene."""
        return cls(
            tuple(x.name for x in noticed(scene.threshold)),
            {held_name(scene, x): x.name for x in scene.hands},
        )

    @property
    def floats(self) -> tuple[str, ...]:
        """The names of the variables that are frequencies, or a fraction of the band."""
        crossings = (f"first_crossing_{name}" for name in self.criteria)
        return *crossings, "bandwidth", "transparent", *(f"changeover_{name}" for name in SYSTEMS)

    @property
    def counts(self) -> tuple[str, ...]:
        """The names of the variables that count crossings and changeovers."""
        return *(f"crossings_{name}" for name in self.criteria), *(
            f"changeovers_{name}" for name in SYSTEMS
        )

    @property
    def variables(self) -> dict[str, tuple[np.dtype[Any], dict[str, str]]]:
        """Name, kind, unit and meaning of each; the method, which is written last, at the end."""
        meanings = self._meanings()
        units = dict.fromkeys(self.floats, _PER_SECOND) | {"transparent": _ONE}
        kinds: dict[str, np.dtype[Any]] = {
            **{name: np.dtype(np.float64) for name in self.floats},
            **{name: np.dtype(np.int16) for name in (*self.counts, *self.hands)},
            "method": np.dtype(np.int8),
        }
        hands = {name: {"hand": hand} for name, hand in self.hands.items()}
        return {
            name: (
                kind,
                {
                    "units": units.get(name, _ONE),
                    "long_name": meanings[name],
                    **hands.get(name, {}),
                },
            )
            for name, kind in kinds.items()
        }

    def _meanings(self) -> dict[str, str]:
        """A sentence for each variable, as data sets have it."""
        found = {
            "bandwidth": (
                "end of the transparent interval that starts at the band's low end; NaN if none "
                "does"
            ),
            "transparent": f"fraction of the band on which {_TRANSPARENT[self.criteria]}",
            "method": (
                f"{FLOAT}: certified by floats with an error bound; {EXACT}: exact; {OPEN}: not "
                f"answered, or not in all"
            ),
        }
        for name in self.criteria:
            found[f"first_crossing_{name}"] = (
                f"lowest frequency of the band at which {_MEETS[name]}; NaN if none"
            )
            found[f"crossings_{name}"] = (
                f"number of frequencies of the band at which {_MEETS[name]}"
            )
        for name, symbol in zip(SYSTEMS, ("H_env", "H_perc"), strict=True):
            found[f"changeover_{name}"] = (
                f"lowest frequency of the band at which Re {symbol} changes sign; NaN if none"
            )
            found[f"changeovers_{name}"] = f"number of sign changes of Re {symbol} on the band"
        for name, hand in self.hands.items():
            found[name] = (
                f"number of roots in Re s >= 0 (with a clock |z| >= 1), held in {hand}; {_NUMBERS}"
            )
        return found

    def no_answer(self) -> dict[str, float]:
        """The row of a set without answers."""
        return {
            **dict.fromkeys(self.floats, ABSENT),
            **dict.fromkeys(self.counts, UNKNOWN),
            "method": OPEN,
        }


def held_name(scene: Scene, hand: Hand) -> str:
    """The variable of a hand: ``unstable_`` and its name, in letters, digits and underscores;
    with its number where two hands would have the same one."""
    names = [f"{HELD}{re.sub(r'[^0-9A-Za-z]+', '_', x.name).strip('_')}" for x in scene.hands]
    place = [x.name for x in scene.hands].index(hand.name)
    return names[place] + (f"_{place + 1}" if names.count(names[place]) > 1 else "")


_NUMBERS = (
    f"{INFINITE}: infinitely many, on the right or as near to the axis as one likes; {UNKNOWN}: "
    f"not decided"
)
_MEETS = {
    "real": "r_r crosses its threshold",
    "imag": "r_i crosses its threshold",
    "joint": "dH/|H_env| meets the border of the JND region",
}
_TRANSPARENT = {
    ("real", "imag"): "neither ratio exceeds its threshold",
    ("joint",): "dH/|H_env| lies in the JND region",
}
