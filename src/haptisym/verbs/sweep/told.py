"""What a sweep tells of each set: names, kinds and meanings of its variables, as the criteria of the scene have them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from haptisym.judge.criteria import noticed
from haptisym.model.scene import Scene

ABSENT, UNKNOWN = float("nan"), -1
FLOAT, EXACT, OPEN = 0, 1, 2
"""By which method a set was answered: floats with a bound; exactly; not at all, as it stayed undecided or has no dynamics."""
SYSTEMS = ("environment", "perceived")
_PER_SECOND, _ONE = "rad/s", "1"


@dataclass(frozen=True)
class Told:
    """The variables of a sweep of a scene; ``criteria``: the names of what is judged."""

    criteria: tuple[str, ...]

    @classmethod
    def of(cls, scene: Scene) -> Told:
        return cls(tuple(x.name for x in noticed(scene.threshold)))

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
            **{name: np.dtype(np.int16) for name in self.counts},
            "method": np.dtype(np.int8),
        }
        return {
            name: (kind, {"units": units.get(name, _ONE), "long_name": meanings[name]}) for name, kind in kinds.items()
        }

    def _meanings(self) -> dict[str, str]:
        found = {
            "bandwidth": "end of the transparent interval that starts at the band's low end; NaN if none does",
            "transparent": f"fraction of the band on which {_TRANSPARENT[self.criteria]}",
            "method": f"{FLOAT}: certified by floats with an error bound; {EXACT}: exact; {OPEN}: not answered",
        }
        for name in self.criteria:
            found[f"first_crossing_{name}"] = f"lowest frequency of the band at which {_MEETS[name]}; NaN if none"
            found[f"crossings_{name}"] = f"number of frequencies of the band at which {_MEETS[name]}"
        for name, symbol in zip(SYSTEMS, ("H_env", "H_perc"), strict=True):
            found[f"changeover_{name}"] = f"lowest frequency of the band at which Re {symbol} changes sign; NaN if none"
            found[f"changeovers_{name}"] = f"number of sign changes of Re {symbol} on the band"
        return found

    def no_answer(self) -> dict[str, float]:
        """The row of a set without answers."""
        return {**dict.fromkeys(self.floats, ABSENT), **dict.fromkeys(self.counts, UNKNOWN), "method": OPEN}


_MEETS = {
    "real": "r_r meets its threshold",
    "imag": "r_i meets its threshold",
    "joint": "dH/|H_env| meets the border of the JND region",
}
_TRANSPARENT = {
    ("real", "imag"): "neither ratio exceeds its threshold",
    ("joint",): "dH/|H_env| lies in the JND region",
}
