"""Three-valued judgements of measured lines: where the disc of a change lies against the region of
what is not noticed.

How far a change lies from the border of the region is exact, for regions of every shape, at all
lines at once: positive outside, negative inside. A disc of radius r lies outside where the distance
is above r, inside where it is at most -r.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import lru_cache
from typing import Any, TypeAlias

import flint
import numpy as np
from flint import arb, arb_poly
from sympy import Expr, Poly, fraction, together

from haptisym.judge.percepts import Change, Property, real_property
from haptisym.kernel.errors import SceneError
from haptisym.kernel.reals import expression_ball
from haptisym.kernel.rings import omega
from haptisym.model.catalogue import Environment
from haptisym.model.jnd import Part, Shape, Threshold
from haptisym.model.measured import Complexes, Measurement, Reals
from haptisym.model.measuredscene import MeasuredScene

Corners: TypeAlias = Sequence[tuple[Reals, Reals]]
_LOST, _BITS = 1e-14, 400
"""Of a value that may be lost in floats; and with how many bits it is computed where more is."""
_HALVINGS = 60
_NEAR = 1e-30  # of its half axis: beside an axis of an ellipse in place of on it


def values_of(formula: Expr, at: Reals) -> Reals:
    """A number, or a rational formula in omega, at frequencies, to within some roundings of the
    values themselves."""
    if not formula.has(omega):
        return np.full(len(at), float(formula))
    above, below = (_polynomial(x, at) for x in _coefficients(formula))
    return np.asarray(above / below)


def _polynomial(row: tuple[Expr, ...], at: Reals) -> Reals:
    """In floats; where these lose digits, as terms cancel, in balls."""
    floats = np.array(row, float)
    found, terms = np.polyval(floats, at), np.polyval(np.abs(floats), np.abs(at))
    lost = np.flatnonzero(len(row) * 2.3e-16 * terms > _LOST * np.abs(found))
    if len(lost):
        with flint.ctx.workprec(_BITS):
            exact = arb_poly([expression_ball(x) for x in row[::-1]])
            found[lost] = [float(exact(arb(x)).mid()) for x in at[lost].tolist()]
    return np.asarray(found)


@lru_cache(maxsize=64)
def _coefficients(formula: Expr) -> tuple[tuple[Expr, ...], ...]:
    return tuple(tuple(Poly(x, omega).all_coeffs()) for x in fraction(together(formula)))


def ends_of(c: Threshold, part: Part, at: Reals) -> tuple[Reals, Reals]:
    """From where to where a change of one part alone is not noticed, as a share of ``|H_env|``:
    changes that make it larger."""
    own, i = c.region, 0 if part is Part.REAL else 1
    if own.corners:
        return _axis(_corners(c, at), i)
    limit = values_of(c[part], at)
    if own.shape is Shape.ELLIPSE:
        limit = limit * upright(values_of(own.tilt, at))
    return -limit, limit


def joint_distance(c: Threshold, at: Reals, x: Reals, y: Reals) -> Reals | None:
    """Of a change x + j y from an ellipse, a diamond or a polygon; None where each part is judged
    by itself."""
    own = c.region
    if own.shape is Shape.SQUARE:
        return None
    if own.shape is Shape.ELLIPSE:
        a, b = (values_of(c[part], at) for part in Part)
        return _from_ellipse(a, b, values_of(own.tilt, at), x, y)
    return _from_polygon(_corners(c, at), x, y)


def part_distance(
    c: Threshold, part: Part, at: Reals, x: Reals, env: Reals, size: tuple[Reals, Reals]
) -> Reals:
    """Of a change of one part alone. ``x`` : that part's; ``env`` : the environment's part, both as
    shares of ``|H_env|``.

    ``size`` : the least and the largest ``|H_env|`` in the environment's disc; where they differ, a
    limit for changes that make the part larger is that only as far as the part does become larger,
    and a floor is taken at its worst.
    """
    low, high = ends_of(c, part, at)
    lower = c.lower(part)
    if is_of_change_alone(c, part):
        return np.maximum(x - high, low - x)
    below = high if lower is None else values_of(lower, at)
    least, largest = (_floored(c, at, s) for s in size)
    uncertain = size[0] < size[1]
    exact = _two_way(np.maximum(high, largest), np.maximum(below, largest), x, env)
    grown, moved = np.abs(env + x) - np.abs(env), np.abs(x)
    outer, inner = (
        _either(moved, grown, np.maximum(high, f), np.maximum(below, f)) for f in (least, largest)
    )
    worst = np.where(outer > 0, outer, np.minimum(inner, 0))
    return np.where(uncertain, worst, exact)


def is_of_change_alone(c: Threshold, part: Part) -> bool:
    """Whether it does not matter which environment a change is of: no floor, and limits that are
    the same for both ways."""
    return c.lower(part) is None and c.region.floor is None


def upright(tilt: Reals) -> Reals:
    """sqrt(1 - t^2), to its last digits where t is close to 1, too."""
    found: Reals = np.sqrt((1 - tilt) * (1 + tilt))
    return found


def depth_of(c: Threshold, at: Reals) -> Reals:
    """How far no change at all lies inside a diamond or a polygon."""
    zero = np.zeros(len(at))
    return -_from_polygon(_corners(c, at), zero, zero)


def floor_of(c: Threshold, at: Reals) -> Reals:
    """The least change that is noticed, in the unit of H; 0 without a floor."""
    return np.zeros(len(at)) if c.region.floor is None else values_of(c.region.floor, at)


def _floored(c: Threshold, at: Reals, size: Reals) -> Reals:
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.nan_to_num(floor_of(c, at) / size, nan=0.0, posinf=np.inf)


def _either(moved: Reals, grown: Reals, up: Reals, down: Reals) -> Reals:
    """How far a change is noticed, or not noticed where negative, whatever the disc makes of how
    the part has ``grown``."""
    beyond = np.maximum(np.minimum(grown, moved - up), np.minimum(-grown, moved - down))
    within = np.maximum(np.minimum(grown, up - moved), np.minimum(-grown, down - moved))
    outer = np.maximum(moved - np.maximum(up, down), beyond)
    inner = np.maximum(np.minimum(up, down) - moved, within)
    found: Reals = np.where(outer > 0, outer, -np.maximum(inner, 0))
    return found


def _two_way(up: Reals, down: Reals, x: Reals, env: Reals) -> Reals:
    """One limit for changes that make a part larger in magnitude, another for those that make it
    smaller.

    With env = e > 0 what is smaller lies between -2 e and 0: not noticed is [-min(down, 2 e), up],
    and [-up, -2 e] if there is one.
    """
    x, turn = np.where(env < 0, -x, x), -2 * np.abs(env)
    first, beyond = np.maximum(-down, turn), -up <= turn
    first = np.where(beyond & (first <= turn), -up, first)
    near = np.minimum(x - first, up - x)
    far = np.where(beyond, np.minimum(x + up, turn - x), -np.inf)
    found: Reals = -np.maximum(near, far)
    return found


# The plane.


def _corners(c: Threshold, at: Reals) -> Corners:
    return [(values_of(x, at), values_of(y, at)) for x, y in c.corners]


def _edges(corners: Corners) -> Iterable[tuple[Reals, Reals, Reals, Reals]]:
    for (px, py), (qx, qy) in zip(corners, [*corners[1:], corners[0]], strict=True):
        yield px, py, qx - px, qy - py


def _axis(corners: Corners, i: int) -> tuple[Reals, Reals]:
    """Where a polygon cuts an axis."""
    low, high = np.full(len(corners[0][0]), -np.inf), np.full(len(corners[0][0]), np.inf)
    for px, py, dx, dy in _edges(corners):
        slope, reach = (dy, -dx)[i], dy * px - dx * py
        with np.errstate(divide="ignore", invalid="ignore"):
            end = reach / slope
        high = np.where(slope > 0, np.minimum(high, end), high)
        low = np.where(slope < 0, np.maximum(low, end), low)
    return low, high


def _from_polygon(corners: Corners, x: Reals, y: Reals) -> Reals:
    """Of a convex polygon, corners counterclockwise."""
    depth, away = np.full(len(x), np.inf), np.full(len(x), np.inf)
    for px, py, dx, dy in _edges(corners):
        length = np.hypot(dx, dy)
        depth = np.minimum(depth, (dx * (y - py) - dy * (x - px)) / length)
        share = np.clip(((x - px) * dx + (y - py) * dy) / length**2, 0, 1)
        away = np.minimum(away, np.hypot(x - px - share * dx, y - py - share * dy))
    found: Reals = np.where(depth >= 0, -depth, away)
    return found


def _from_ellipse(a: Reals, b: Reals, tilt: Reals, x: Reals, y: Reals) -> Reals:
    """Of (x/a)^2 - 2 t (x/a)(y/b) + (y/b)^2 <= 1 - t^2: the foot of the perpendicular, by bisection
    in the principal axes.

    It is (long^2 u/(t + long^2 - short^2), short^2 v/t); t may be close to 0, and is found to its
    last digits.
    """
    mixed, apart = tilt * a * b, (a - b) * (a + b) / 2
    spread, turned = np.hypot(apart, mixed), 0.5 * np.arctan2(mixed, apart)
    long = np.sqrt((a**2 + b**2) / 2 + spread)
    short = a * b * upright(tilt) / long
    cos, sin = np.cos(turned), np.sin(turned)
    u = np.maximum(np.abs(x * cos + y * sin), _NEAR * long)
    v = np.maximum(np.abs(y * cos - x * sin), _NEAR * short)
    low, high = short * v, np.hypot(long * u, short * v)
    for _ in range(_HALVINGS):
        t = np.sqrt(low) * np.sqrt(high)
        beyond = (long * u / (t + 2 * spread)) ** 2 + (short * v / t) ** 2 > 1
        low, high = np.where(beyond, t, low), np.where(beyond, high, t)
    t = np.sqrt(low) * np.sqrt(high)
    found: Any = np.abs(t - short**2) * np.hypot(u / (t + 2 * spread), v / t)
    inside = (u / long) ** 2 + (v / short) ** 2 <= 1
    signed: Reals = np.where(inside, -found, found)
    return signed


OPEN = 2
"""A sign that a disc does not tell."""


class PartVerdict(Enum):
    """Of a part at a line."""

    EXCEEDS = "exceeds"
    BELOW = "below"
    UNRESOLVED = "unresolved"


CODES = {1: PartVerdict.EXCEEDS, -1: PartVerdict.BELOW, 0: PartVerdict.UNRESOLVED}


@dataclass(frozen=True, eq=False)
class Lines:
    """The measured lines as numbers: both responses, the radii of their discs, and the change with
    its own.

    ``environment``, ``perceived`` : H at ``omega``, rad/s. ``env_radius``, ``perc_radius`` : in the
    unit of H, 0 where a response is taken as it is. ``change`` : dH/|H_env|, x + j y. ``radius`` :
    of a disc around it that holds the true change, relative to the true ``|H_env|``, whenever both
    discs hold the truth; None where no disc is known. ``felt``, ``own`` : as they were measured;
    ``own`` is of the environment, None where that is a model.
    """

    omega: Reals
    environment: Complexes
    perceived: Complexes
    env_radius: Reals
    perc_radius: Reals
    change: Complexes
    radius: Reals | None
    felt: Measurement
    own: Measurement | None


def matched(scene: MeasuredScene) -> tuple[Measurement, Measurement | None]:
    """The perceived response on the band, and the environment's where that is measured, at the same
    frequencies. SceneError where there are none."""
    felt, own = scene.perceived, scene.environment
    if scene.band is not None:
        felt = felt.on_band(*map(float, scene.band))
    if isinstance(own, Environment):
        return felt, None
    nearest = _nearest(own.omega, felt.omega)
    common = np.abs(own.omega[nearest] - felt.omega) <= _SAME * felt.omega
    if not common.any():
        raise SceneError(
            f"{own.name} and {felt.name} have no frequency in common: measure both at the "
            f"same frequencies"
        )
    return felt.at(common), own.at(nearest[common])


_SAME = 1e-9
"""Frequencies that differ by no more than this share are one: files round them."""


def _nearest(among: Reals, wanted: Reals) -> Any:
    """For each wanted frequency the index of the nearest one among rising others."""
    right = np.searchsorted(among, wanted).clip(0, len(among) - 1)
    left = np.maximum(right - 1, 0)
    return np.where(wanted - among[left] <= among[right] - wanted, left, right)


def lines_of(scene: MeasuredScene) -> Lines:
    """The lines that a scene judges. SceneError where H_env is infinite at one of them."""
    felt, own = matched(scene)
    env = _exact(scene, felt.omega) if own is None else own.H
    none = np.broadcast_to(0.0, len(felt))
    inner, outer = (none if m is None or m.discs is None else m.discs for m in (own, felt))
    known = any(m is not None and m.discs is not None for m in (own, felt))
    size = np.abs(env)
    with np.errstate(divide="ignore", invalid="ignore"):
        change = (felt.H - env) / size
        share = inner / size
        radius = np.where(
            share < 1, ((inner + outer) / size + np.abs(change) * share) / (1 - share), np.inf
        )
    return Lines(
        felt.omega, env, felt.H, inner, outer, change, radius if known else None, felt, own
    )


def _exact(scene: MeasuredScene, at: Reals) -> Complexes:
    """H_env of a model, at all frequencies."""
    values = scene.frame.distortion().compile(of=["environment_real", "environment_imag"])(at)
    with np.errstate(invalid="ignore"):  # of what is infinite
        env: Complexes = values.environment_real + 1j * values.environment_imag
    if not np.isfinite(env).all():
        where = at[int(np.argmin(np.isfinite(env)))]
        raise SceneError(f"H_env is infinite at {where:.6g} rad/s: leave that frequency point out")
    return env


# Step 1.


def limits_of(scene: MeasuredScene, at: Reals) -> dict[Part, Reals]:
    """Of both parts the lesser of the two limits within which a change of that part alone is not
    noticed."""
    ends = {part: ends_of(scene.threshold, part, at) for part in Part}
    return {part: np.minimum(-low, high) for part, (low, high) in ends.items()}


@dataclass(frozen=True, eq=False)
class JudgedLine:
    """``distance`` : how far, relative to ``|H_env|``, a line's change lies outside the region,
    negative inside; ``verdict`` : 1 where the whole disc lies outside, -1 where it lies inside, 0
    where it does not tell."""

    distance: Reals
    verdict: Any


def judged(scene: MeasuredScene, x: Lines, part: Part | None) -> JudgedLine | None:
    """Of a part by itself, or of both together: None where the region judges each by itself."""
    c = scene.threshold
    with np.errstate(divide="ignore", invalid="ignore"):
        if part is None:
            distance = joint_distance(c, x.omega, x.change.real, x.change.imag)
            if distance is None:
                return None
        else:
            own = _side(x.change, part)
            env, reach = (
                (own, (own, own)) if is_of_change_alone(c, part) else _environment(x, part)
            )  # or not looked at
            distance = part_distance(c, part, x.omega, own, env, reach)
    return _told(x, distance, part, c)


def _side(z: Complexes, part: Part) -> Reals:
    return z.real if part is Part.REAL else z.imag


def _environment(x: Lines, part: Part) -> tuple[Reals, tuple[Reals, Reals]]:
    """Its part as a share of ``|H_env|``, and the least and the largest ``|H_env|`` in its disc."""
    size = np.abs(x.environment)
    return _side(x.environment, part) / size, (
        np.maximum(size - x.env_radius, 0),
        size + x.env_radius,
    )


def _told(x: Lines, distance: Reals, part: Part | None, c: Threshold) -> JudgedLine:
    """Where H_env is 0, what of dH is judged is compared with the floor."""
    zero = (x.environment == 0) & (x.env_radius == 0)
    is_any = bool(zero.any())
    if is_any:
        dH = x.perceived - x.environment
        moved, floor = np.abs(_side(dH, part) if part else dH), floor_of(c, x.omega)
        distance = np.where(zero, np.where(moved <= floor, -np.inf, np.inf), distance)
    with np.errstate(invalid="ignore"):
        radius = 0.0 if x.radius is None else x.radius
        outside, inside = distance > radius, distance <= -radius
    if is_any:
        outside = np.where(zero, moved > x.perc_radius + floor, outside)
        inside = np.where(zero, moved + x.perc_radius <= floor, inside)
    return JudgedLine(distance, outside.astype(np.int8) - inside.astype(np.int8))


# Step 2.


@dataclass(frozen=True, eq=False)
class Signs:
    """What discs tell of a part: its signs in H_env and H_perc, and whether it is felt larger; OPEN
    where they do not."""

    environment: Any
    perceived: Any
    compared: Any

    @property
    def known(self) -> Any:
        """Where all are told."""
        return (self.environment != OPEN) & (self.perceived != OPEN) & (self.compared != OPEN)

    def label(self, part: Part, line: int) -> tuple[Property, Change]:
        """How the change is felt at a line where all signs are known."""
        env, perc, compared = (
            int(self.environment[line]),
            int(self.perceived[line]),
            int(self.compared[line]),
        )
        change = {1: Change.HIGHER, -1: Change.LOWER, 0: Change.EQUAL}[compared]
        return (Property.DAMPING if part is Part.IMAG else real_property(env, perc)), change


def signs(x: Lines, part: Part) -> Signs:
    """Of one part, at all lines."""
    env, perc = (h.real if part is Part.REAL else h.imag for h in (x.environment, x.perceived))
    compared = _sign(np.abs(perc) - np.abs(env), x.env_radius + x.perc_radius)
    return Signs(_sign(env, x.env_radius), _sign(perc, x.perc_radius), compared)


def _sign(value: Reals, radius: Reals) -> Any:
    told: Any = np.where((np.abs(value) > radius) | (radius == 0), np.sign(value), OPEN)
    return told.astype(np.int8)


def certainty(m: Measurement) -> str:
    """What the discs of a response come from."""
    if m.coherence is not None:
        return f"coherence, {m.averages:g} averages"
    return "no disc is known" if m.radius is None else "radius in the file"
