"""In which unit an axis of frequencies is drawn: Hz where the scene says Hz, rad/s elsewhere."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from math import tau
from typing import Any

from matplotlib.axes import Axes
from sympy import Expr, pi

from haptisym.kernel.hertz import Hertz
from haptisym.kernel.reals import RealNumber


@dataclass(frozen=True)
class Scale:
    """A unit of frequency: its name, the label of its axis, and how many rad/s it is."""

    unit: str
    label: str
    factor: float

    def of(self, omega: Any) -> Any:
        """Frequencies, rad/s, in this unit."""
        return omega if self.factor == 1 else omega / self.factor

    def digits(self, omega: RealNumber, count: int) -> str:
        """A frequency to that many correct digits in this unit."""
        return (omega if self.factor == 1 else Hertz(omega)).digits(count)


RADIANS = Scale("rad/s", r"$\omega$ (rad/s)", 1.0)
HERTZ = Scale("Hz", "frequency (Hz)", tau)


def scale_of(ax: Axes, band: Iterable[Expr], *, hertz: bool | None = None) -> Scale:
    """The unit of the horizontal axis: what was asked for, else the one that it has, else that of the band."""
    return wanted_scale(hertz=hertz) or labelled_scale(ax.get_xlabel()) or band_scale(band)


def wanted_scale(*, hertz: bool | None) -> Scale | None:
    """What was asked for; None where nothing was."""
    return None if hertz is None else HERTZ if hertz else RADIANS


def labelled_scale(label: str) -> Scale | None:
    """That of an axis with this label; None where that tells none."""
    return next((x for x in (HERTZ, RADIANS) if x.label == label), None)


def band_scale(band: Iterable[Expr]) -> Scale:
    """Hz where a frequency is a multiple of pi rad/s: then it was written in Hz, or in turns of another kind.

    >>> from haptisym.model.scenefile import load_scene
    >>> band_scale(load_scene("steering-wheel").band).unit, band_scale(load_scene("fu2019").band).unit
    ('Hz', 'rad/s')
    """
    return HERTZ if any(x.has(pi) for x in band) else RADIANS


def floats_scale(values: Iterable[float]) -> Scale:
    """The same of floats: Hz where all are short decimals in Hz, and not all are in rad/s.

    >>> floats_scale([0.0, 31.41592653589793]).unit, floats_scale([20.0, 200.0]).unit
    ('Hz', 'rad/s')
    """
    given = [float(x) for x in values]
    return (
        HERTZ if all(map(_is_short, (x / HERTZ.factor for x in given))) and not all(map(_is_short, given)) else RADIANS
    )


def _is_short(x: float) -> bool:
    return abs(x - float(f"{x:.6g}")) <= 1e-13 * abs(x)
