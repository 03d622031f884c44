"""What a sweep tells of each set: names, kinds and meanings of its variables, as criteria and hands of the scene have them."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from haptisym.judge.crossings import noticed
from haptisym.model.catalogue import Hand
from haptisym.model.scene import Scene

ABSENT, UNKNOWN = float("nan"), -1
INFINITE = 32767
"""Stands for infinitely many roots, a chain of them that lies on the right or comes as near to the axis as one likes."""
FLOAT, EXACT, OPEN = 0, 1, 2
"""By which method a set was answered: floats with a bound; exactly; not at all, as it stayed undecided or has no dynamics."""
HELD = "unstable_"
"""What the variable of a hand begins with."""
SYSTEMS = ("environment", "perceived")
_PER_SECOND, _ONE = "rad/s", "1"


@dataclass(frozen=True)
class Told:
    """The variables of a sweep of a scene; ``criteria``: the names of what is judged; ``hands``: by their variables."""

    criteria: tuple[str, ...]
    hands: Mapping[str, str]

    @classmethod
    def of(cls, scene: Scene) -> Told:
        """Of a scene: its criteria and its hands."""
        return cls(tuple(x.name for x in noticed(scene.threshold)), {held_name(scene, x): x.name for x in scene.hands})

    @property
    def floats(self) -> tuple[str, ...]:
        """Those that are frequencies, or a fraction of the band."""
        crossings = (f"first_crossing_{name}" for name in self.criteria)
        return *crossings, "bandwidth", "transparent", *(f"changeover_{name}" for name in SYSTEMS)

    @property
    def counts(self) -> tuple[str, ...]:
        """Those that count."""
        return *(f"crossings_{name}" for name in self.criteria), *(f"changeovers_{name}" for name in SYSTEMS)

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
            name: (kind, {"units": units.get(name, _ONE), "long_name": meanings[name], **hands.get(name, {})})
            for name, kind in kinds.items()
        }

    def _meanings(self) -> dict[str, str]:
        found = {
            "bandwidth": "end of the transparent interval that starts at the band's low end; NaN if none does",
            "transparent": f"fraction of the band on which {_TRANSPARENT[self.criteria]}",
            "method": f"{FLOAT}: certified by floats with an error bound; {EXACT}: exact; {OPEN}: not answered, or not in all",
        }
        for name in self.criteria:
            found[f"first_crossing_{name}"] = f"lowest frequency of the band at which {_MEETS[name]}; NaN if none"
            found[f"crossings_{name}"] = f"number of frequencies of the band at which {_MEETS[name]}"
        for name, symbol in zip(SYSTEMS, ("H_env", "H_perc"), strict=True):
            found[f"changeover_{name}"] = f"lowest frequency of the band at which Re {symbol} changes sign; NaN if none"
            found[f"changeovers_{name}"] = f"number of sign changes of Re {symbol} on the band"
        for name, hand in self.hands.items():
            found[name] = f"number of roots in Re s >= 0 (with a clock |z| >= 1), held in {hand}; {_NUMBERS}"
        return found

    def no_answer(self) -> dict[str, float]:
        """The row of a set without answers."""
        return {**dict.fromkeys(self.floats, ABSENT), **dict.fromkeys(self.counts, UNKNOWN), "method": OPEN}


def held_name(scene: Scene, hand: Hand) -> str:
    """The variable of a hand: ``unstable_`` and its name, in letters, digits and underscores; numbered where two are alike."""
    names = [f"{HELD}{re.sub(r'[^0-9A-Za-z]+', '_', x.name).strip('_')}" for x in scene.hands]
    place = [x.name for x in scene.hands].index(hand.name)
    return names[place] + (f"_{place + 1}" if names.count(names[place]) > 1 else "")


_NUMBERS = f"{INFINITE}: infinitely many, on the right or as near to the axis as one likes; {UNKNOWN}: not decided"
_MEETS = {
    "real": "r_r meets its threshold",
    "imag": "r_i meets its threshold",
    "joint": "dH/|H_env| meets the border of the JND region",
}
_TRANSPARENT = {
    ("real", "imag"): "neither ratio exceeds its threshold",
    ("joint",): "dH/|H_env| lies in the JND region",
}
