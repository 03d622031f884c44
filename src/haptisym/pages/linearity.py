"""What records say of a display's linearity."""

from __future__ import annotations

from haptisym.model.welch import Welch
from haptisym.writing.document import Number, Phrase, Strong

_UNLIKELY = 0.01
"""A chance below which a display is called not linear."""


def linearity(w: Welch) -> Phrase | None:
    """How far the force follows the cube of what the response predicts; None where that was not asked."""
    if w.cube is None or w.cube_chance is None:
        return None
    told: Phrase = (
        "the force follows the cube of what the response predicts by ", Number(f"{w.cube:.3g}", w.cube), " standard errors; so ",
        "many or more have a chance of ", Number(f"{w.cube_chance:.3g}", w.cube_chance), " if the display is linear",
    )  # fmt: skip
    if w.cube_chance >= _UNLIKELY:
        return told
    as_if = "stays behind, as one that saturates" if w.cube < 0 else "grows beyond, as one that hardens or has play"
    return (
        Strong("NOT LINEAR"), f": it {as_if}: ", told, ". The response is that of a motion as large as this one; less motion ",
        "gives another",
    )  # fmt: skip
