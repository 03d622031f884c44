"""Does the conclusion survive another JND model? Square, disc and diamond of its half widths, beside the scene's own region."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from sympy import Expr

from haptisym.judge.criteria import kept, noticed
from haptisym.judge.crossings import Crossing, curves, find_crossings
from haptisym.judge.regions import Polygon
from haptisym.kernel.errors import SceneError
from haptisym.kernel.reals import RealNumber
from haptisym.kernel.roots import Interval, chart
from haptisym.kernel.shown import Shown
from haptisym.model.distortion import Distortion
from haptisym.model.jnd import SQUARE, Region, Shape, Threshold


@dataclass(frozen=True, repr=False)
class Compared(Shown):
    """What one region says of a scene: the first crossing on the band, and the bandwidth; None for what there is not."""

    name: str
    threshold: Threshold
    crossing: Crossing | None
    bandwidth: RealNumber | None
    transparent: tuple[Interval, ...]
    certified: bool

    def _line(self) -> str:
        return f"{self.name}: bandwidth {self.bandwidth.digits(5) if self.bandwidth else 'none'}"

    def row(self, digits: int) -> dict[str, Any]:
        """As a row of a document."""
        first: dict[str, Any] | None = None
        if self.crossing:
            x, omega = self.crossing, self.crossing.omega
            first = {"part": x.criterion.name, "omega": float(omega), "kind": x.kind.value}
            first |= {"digits": omega.digits(digits), "enclosure": list(omega.enclosure(digits))}
        return {
            "region": self.name,
            "threshold": self.threshold.row(),
            "bandwidth": None if self.bandwidth is None else float(self.bandwidth),
            "crossing": first,
            "certified": self.certified,
        }


OWN = "the scene's own"


def compared(d: Distortion, threshold: Threshold, band: tuple[Expr, Expr]) -> tuple[Compared, ...]:
    """Square, disc and diamond of the half widths of a JND, and the JND itself; all certified.

    The half widths of limits for each way are those for changes that make a part larger; those of a polygon the least that it
    reaches along each axis. SceneError for a polygon that depends on the frequency, which has none.
    """
    real, imag = half_widths(threshold)
    plain = Threshold.of(real, imag)
    shapes = {"square": SQUARE, "disc": Region(Shape.ELLIPSE), "diamond": Region(Shape.DIAMOND)}
    regions = {name: replace(plain, region=region) for name, region in shapes.items()} | {OWN: threshold}
    return tuple(_answered(name, d, x, band) for name, x in regions.items())


def half_widths(threshold: Threshold) -> tuple[Expr, Expr]:
    """How far a region reaches along the axes of x and y."""
    corners = threshold.region.corners
    if not corners:
        return threshold.real, threshold.imag
    if not threshold.is_constant:
        raise SceneError("regions: a polygon that depends on omega has no half widths that are numbers or formulas")
    edges = Polygon(corners).edges
    across, up = (1 / max(max(edge[i], -edge[i]) for edge in edges) for i in (0, 1))
    return across, up


def _answered(name: str, d: Distortion, threshold: Threshold, band: tuple[Expr, Expr]) -> Compared:
    table = chart(curves(d, noticed(threshold)), *band)
    found, clear = find_crossings(table), kept(table)
    starts = bool(clear) and clear[0].low is table.points[0]
    width = clear[0].high.omega if starts else None
    return Compared(name, threshold, found[0] if found else None, width, clear, not table.undecided)
