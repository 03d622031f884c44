r"""Which changes would decide between models of the JND: the square, the disc, and ellipses tilted
to either side.

The paper judges both parts of dH apart, which is a square, and leaves open how they interact. In
the direction phi, with x/a = r cos(phi) and y/b = r sin(phi) and the half widths a and b of the
JND, a model notices what is larger than its reach::

    square              1/max(|cos phi|, |sin phi|),
    ellipse of tilt t   sqrt((1 - t^2)/(1 - t sin 2 phi)),   disc: t = 0.

The quotient of the reaches of two of them is largest on a diagonal: for two ellipses it is
monotonic in sin 2 phi; for the square and an ellipse its square is (1 + q^2 - 2 t q)/(1 - t^2) with
q = tan phi (or its inverse) in [-1, 1], which is convex.
On the diagonals the reaches are sqrt(2), 1 and sqrt(1 +- t). A change of the geometric mean of two
reaches exceeds the one and stays below the other by the same factor, the margin, the square root of
their quotient; no other change has a larger one.

A change (x, y) is one of stiffness x |H_env|, or of mass -x |H_env|/omega^2, with one of damping y
|H_env|/omega, at any frequency: the models differ equally at all of them where the JND is a number.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from itertools import combinations
from typing import Any

import numpy as np
from sympy import Expr, Rational

from haptisym.judge.crossings import noticed
from haptisym.judge.evaluation import Evaluation, half_widths
from haptisym.kernel.objects import Shown
from haptisym.kernel.reals import RealNumber
from haptisym.kernel.roots import Chart, Interval, Signs, chart
from haptisym.model.jnd import RegionDetails, Shape, Threshold
from haptisym.programs.floats import floats_of
from haptisym.programs.values import Array

TILT = Rational(1, 2)
"""Tilt of the ellipses where the scene's JND has none: no tilt was measured."""
_SAMPLES = 401
"""Samples of an interval, among which the frequency of the largest margin is chosen."""


@dataclass(frozen=True, repr=False)
class Stimulus(Shown):
    """A change of an environment at one frequency which one model of the JND notices and another
    does not.

    ``noticed_by``, ``not_by`` : the models. ``omega`` : rad/s. ``real``, ``imag`` : Re dH and Im dH
    over ``|H_env|``.
    ``stiffness`` : Re dH, N/m or N m/rad; ``damping`` : Im dH/omega, N s/m or N m s/rad. ``margin``
    : by which factor the change at least exceeds the one model's limit and stays below the other's.
    ``interval`` : of a display's own change, where the two judge it so, proven; ``omega`` is then
    where the margin is largest. All else is computed.
    """

    noticed_by: str
    not_by: str
    omega: float
    real: float
    imag: float
    stiffness: float
    damping: float
    margin: float
    interval: Interval | None = None

    def _line(self) -> str:
        return (
            f"{self.noticed_by}, not {self.not_by}: ({self.real:.4g}, {self.imag:.4g}) at "
            f"{self.omega:.5g} rad/s"
        )

    def row(self) -> dict[str, Any]:
        """As a row of a document."""
        names = ("noticed_by", "not_by", "omega", "real", "imag", "stiffness", "damping", "margin")
        found = {x: getattr(self, x) for x in names}
        x = self.interval
        return (
            found if x is None else found | {"interval": [float(x.low.omega), float(x.high.omega)]}
        )


@dataclass(frozen=True, repr=False)
class Discrimination(Shown):
    """The changes that would decide between square, disc and both tilted ellipses of the half
    widths of a scene's JND.

    ``models`` : of each name the JND. ``stimuli`` : for each two models the change of the largest
    margin. ``display`` : where the scene's display is itself such a change. ``undecided`` : where
    its verdict stayed open at the precision limit, rad/s.
    Predictions of the models, not of what persons do: the half widths are the scene's, and the tilt
    is its own or 1/2.

    >>> from haptisym import evaluate
    >>> found = evaluate("fu2019", discriminate=True).discrimination
    >>> [(x.noticed_by, x.not_by, round(x.margin**4, 12)) for x in found.stimuli[:2]]
    [('disc', 'square', 2.0), ('ellipse +0.5', 'square', 4.0)]
    """

    models: Mapping[str, Threshold]
    stimuli: tuple[Stimulus, ...]
    display: tuple[Stimulus, ...]
    undecided: tuple[RealNumber, ...]

    def _line(self) -> str:
        return f"{len(self.stimuli)} stimuli; the display decides on {len(self.display)} intervals"

    def row(self) -> dict[str, Any]:
        """As a part of a document."""
        found = {name: [x.row() for x in getattr(self, name)] for name in ("stimuli", "display")}
        return {
            "models": {name: x.row() for name, x in self.models.items()},
            **found,
            "certified": not self.undecided,
        }


def discriminate(e: Evaluation) -> Discrimination:
    """The discrimination of a scene that is evaluated; SceneError as of ``half_widths``."""
    tilt = e.scene.threshold.region.tilt or TILT
    plain = Threshold.of(*half_widths(e.scene.threshold))
    regions = {"square": plain.region, "disc": RegionDetails(Shape.ELLIPSE)}
    for t in (tilt, -tilt):
        regions[f"ellipse {float(t):+g}" if t.is_number else f"ellipse {t}"] = RegionDetails(
            Shape.ELLIPSE, t
        )
    models = {name: Threshold(plain.real, plain.imag, region=x) for name, x in regions.items()}
    judged = {(name, x): x.function(e.distortion) for name, t in models.items() for x in noticed(t)}
    table = chart(judged, *e.scene.band)
    display = tuple(
        x for pair in combinations(models, 2) for x in _displayed(e, models, table, pair)
    )
    stimuli = tuple(_designed(e, models, pair, display) for pair in combinations(models, 2))
    return Discrimination(models, stimuli, display, tuple(p.omega for p in table.undecided))


def _displayed(
    e: Evaluation, models: Mapping[str, Threshold], table: Chart, pair: tuple[str, str]
) -> Iterator[Stimulus]:
    """The intervals on which two models judge the display differently, each with the change at the
    frequency of the largest margin."""

    def exceeds(name: str, signs: Signs) -> bool:
        return any(signs[name, x] > 0 for x in noticed(models[name]))

    def by_one_alone(one: str, other: str, signs: Signs) -> bool:
        return exceeds(one, signs) and not exceeds(other, signs)

    for one, other in (pair, pair[::-1]):
        for found in table.where(partial(by_one_alone, one, other)):
            ends = float(found.low.omega), float(found.high.omega)
            # at a tangency the change is on the border: no margin
            if found.low is found.high:
                continue
            # the interval is proven; where in it the margin is largest is computed
            omega = np.linspace(*ends, _SAMPLES)[1:-1]
            f = e.distortion.compile()(omega)
            x, y = np.copysign(f.ratio_real, f.real), np.copysign(f.ratio_imag, f.imag)
            above, below = (_multiple(models[name], x, y, omega) for name in (one, other))
            # By which factor the change could shrink before the one model misses it, or grow before
            # the other notices it.
            margin = np.minimum(above, 1 / below)
            i = int(np.argmax(margin))
            dk, db = float(f.real[i]), float(f.imag[i] / omega[i])
            yield Stimulus(
                one,
                other,
                float(omega[i]),
                float(x[i]),
                float(y[i]),
                dk,
                db,
                float(margin[i]),
                found,
            )


def _multiple(t: Threshold, x: Array, y: Array, omega: Array) -> Array:
    """The factor by which a region must be enlarged to contain a change, at each frequency."""

    def number(c: Expr) -> Any:
        return floats_of(c, omega)

    (region, *_) = (c.joint for c in noticed(t))
    square = np.maximum(np.abs(x / number(t.real)), np.abs(y / number(t.imag)))
    found: Array = region.enlarged(x, y, number) if region else square
    return found


def _designed(
    e: Evaluation,
    models: Mapping[str, Threshold],
    pair: tuple[str, str],
    display: tuple[Stimulus, ...],
) -> Stimulus:
    """The change between the reaches of two models on the diagonal on which these are furthest
    apart.

    At the frequency at which the display itself decides best between the two; else at the first
    crossing of any region, or in the middle of the band.
    """
    omega, size = _place(e, [x for x in display if {x.noticed_by, x.not_by} == {*pair}])
    wide, high = (floats_of(c, omega) for c in half_widths(e.scene.threshold))

    def reaches(turn: int) -> list[tuple[float, str]]:
        return sorted((float(_reach(models[name], turn, omega)), name) for name in pair)

    def quotient(turn: int) -> float:
        (least, _), (most, _) = reaches(turn)
        # rounded: where both diagonals are equally good, roundings must not choose
        return round(most / least, 12)

    turn = max((1, -1), key=quotient)
    (least, tight), (most, loose) = reaches(turn)
    # the geometric mean of both reaches; half widths along the axes are 1/sqrt(2) of a diagonal
    reach = (least * most) ** 0.5 / 2**0.5
    x, y = turn * wide * reach, high * reach
    stiffness, damping = x * size, y * size / omega
    margin = (most / least) ** 0.5
    return Stimulus(tight, loose, omega, x, y, stiffness, damping, margin)


def _reach(t: Threshold, turn: int, omega: float) -> float:
    """How far a region reaches on a diagonal, in half widths; ``turn`` : the sign of x where y is
    positive."""
    return (
        2**0.5
        if t.region.shape is Shape.SQUARE
        else float(1 + turn * floats_of(t.region.tilt, omega)) ** 0.5
    )


def _place(e: Evaluation, display: list[Stimulus]) -> tuple[float, float]:
    """The frequency of a stimulus, and ``|H_env|`` there."""
    low, high = map(float, e.scene.band)
    best = [max(display, key=lambda x: x.margin).omega] if display else []
    first = sorted(float(x.crossing.omega) for x in e.regions if x.crossing)
    # several inside the band, as |H_env| may vanish or be infinite at one of them
    inside = [low + share * (high - low) for share in (0.5, 0.4, 0.6, 0.45)]
    places = [*best, *first, *inside]
    function = e.distortion.compile(of=["environment_real", "environment_imag"])
    f = function(np.array(places))
    sizes = np.hypot(f.environment_real, f.environment_imag).tolist()
    pairs = zip(places, sizes, strict=True)
    return next((w, size) for w, size in pairs if w > 0 and 0 < size < np.inf)
