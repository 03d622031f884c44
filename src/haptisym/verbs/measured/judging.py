"""Three-valued judgements of measured frequency points: where the uncertainty disc of a change lies
against the region of changes that are not noticed.

The change is dH/|H_env| = x + j y. How far it lies from the border of the region is computed for
regions of every shape, at all points at once: positive outside, negative inside. A disc of radius r
lies outside where the distance is above r, inside where it is at most -r; else nothing is decided.

A *disc* holds the true change at a frequency point with a stated probability; a *part* is the real
or the imaginary part; a *floor* is the least change of H, in its own unit, that is noticed whatever
its share. Arrays have one entry for each frequency point. Read from ``lines_of`` (the discs) and
``judged``.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import lru_cache
from itertools import pairwise
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
"""The corners of a polygon, counterclockwise: x and y of each at all frequency points."""
# Relative error of a value that is accepted in floats; and bits with which it is computed again
# where more may be lost.
_LOST = 1e-14
_BITS = 400
# Of the logarithm of a multiplier: its digits are exhausted after some sixty.
_HALVINGS = 60
# Of its half axis: a point on an axis of an ellipse is moved beside it by so much, as the equation
# for the foot of the perpendicular divides by 0 there.
_NEAR = 1e-30


def values_of(formula: Expr, at: Reals) -> Reals:
    """Return a number, or a rational formula in omega, at given frequencies, to within some
    roundings of the values themselves."""
    if not formula.has(omega):
        return np.full(len(at), float(formula))
    above, below = (_polynomial(x, at) for x in _coefficients(formula))
    return np.asarray(above / below)


def _polynomial(row: tuple[Expr, ...], at: Reals) -> Reals:
    """Return a polynomial's values in floats; where these lose digits, as terms cancel, in
    balls."""
    floats = np.array(row, float)
    # Horner's rule has an error of at most about n eps times the sum of the terms' moduli.
    values = np.polyval(floats, at)
    terms = np.polyval(np.abs(floats), np.abs(at))
    error = len(row) * 2.3e-16 * terms
    lost = np.flatnonzero(error > _LOST * np.abs(values))
    if len(lost):
        with flint.ctx.workprec(_BITS):
            exact = arb_poly([expression_ball(x) for x in row[::-1]])
            balls = [exact(arb(x)) for x in at[lost].tolist()]
            values[lost] = [float(ball.mid()) for ball in balls]
    return np.asarray(values)


@lru_cache(maxsize=64)
def _coefficients(formula: Expr) -> tuple[tuple[Expr, ...], ...]:
    """Return the coefficients of numerator and denominator, descending."""
    numerator, denominator = fraction(together(formula))
    return tuple(tuple(Poly(x, omega).all_coeffs()) for x in (numerator, denominator))


def ends_of(c: Threshold, part: Part, at: Reals) -> tuple[Reals, Reals]:
    """Return the ends between which a change of one part alone is not noticed, as shares of
    ``|H_env|``; the limit is that for changes that make the part larger."""
    region = c.region
    if region.corners:
        return _axis(_corners(c, at), 0 if part is Part.REAL else 1)
    limit = values_of(c[part], at)
    # A tilted ellipse meets an axis nearer than its largest extent along it: at a sqrt(1 - t^2).
    if region.shape is Shape.ELLIPSE:
        limit = limit * upright(values_of(region.tilt, at))
    return -limit, limit


def joint_distance(c: Threshold, at: Reals, x: Reals, y: Reals) -> Reals | None:
    """Return the distance of a change x + j y from an ellipse, a diamond or a polygon; None
    where each part is judged by itself."""
    region = c.region
    if region.shape is Shape.SQUARE:
        return None
    if region.shape is Shape.ELLIPSE:
        a, b = (values_of(c[part], at) for part in Part)
        return _from_ellipse(a, b, values_of(region.tilt, at), x, y)
    return _from_polygon(_corners(c, at), x, y)


def part_distance(
    c: Threshold, part: Part, at: Reals, x: Reals, env: Reals, size: tuple[Reals, Reals]
) -> Reals:
    """Return the distance of a change of one part alone from what is not noticed. ``x`` : the
    change of that part; ``env`` : the environment's part, both as shares of ``|H_env|``.

    ``size`` : the least and the largest ``|H_env|`` in the environment's disc. Where they differ,
    the limit for changes that make the part larger holds only by how much the part does become
    larger, and a floor is taken at its worst.
    """
    low, high = ends_of(c, part, at)
    lower = c.lower(part)
    if is_of_change_alone(c, part):
        return np.maximum(x - high, low - x)
    below = high if lower is None else values_of(lower, at)
    least_size, largest_size = size
    largest_floor = _floored(c, at, least_size)
    least_floor = _floored(c, at, largest_size)
    uncertain = least_size < largest_size
    up = np.maximum(high, least_floor)
    down = np.maximum(below, least_floor)
    largest_up = np.maximum(high, largest_floor)
    largest_down = np.maximum(below, largest_floor)
    exact = _two_way(up, down, x, env)
    moved = np.abs(x)
    grown = np.abs(env + x) - np.abs(env)
    # The floor over the least |H_env| is the largest limit: noticed with it is noticed for certain.
    # The other way round for what is not noticed; in between nothing is decided, which 0 says.
    outer = _either(moved, grown, largest_up, largest_down)
    inner = _either(moved, grown, up, down)
    worst = np.where(outer > 0, outer, np.minimum(inner, 0))
    return np.where(uncertain, worst, exact)


def is_of_change_alone(c: Threshold, part: Part) -> bool:
    """Whether the judgement of a part depends on the change alone and not on the environment: no
    floor, and limits that are the same for both ways."""
    return c.lower(part) is None and c.region.floor is None


def upright(tilt: Reals) -> Reals:
    """Return sqrt(1 - t^2), to its last digits also where t is close to 1."""
    # 1 - t is exact near 1, while t^2 is rounded before it cancels.
    root: Reals = np.sqrt((1 - tilt) * (1 + tilt))
    return root


def depth_of(c: Threshold, at: Reals) -> Reals:
    """Return how deep the origin, no change at all, lies inside a diamond or a polygon."""
    zero = np.zeros(len(at))
    return -_from_polygon(_corners(c, at), zero, zero)


def floor_of(c: Threshold, at: Reals) -> Reals:
    """Return the least change that is noticed, in the unit of H; 0 without a floor."""
    floor = c.region.floor
    return np.zeros(len(at)) if floor is None else values_of(floor, at)


def _floored(c: Threshold, at: Reals, size: Reals) -> Reals:
    """Return the floor as a share of ``|H_env|``, infinite where that is 0."""
    with np.errstate(divide="ignore", invalid="ignore"):
        share = floor_of(c, at) / size
    return np.nan_to_num(share, nan=0.0, posinf=np.inf)


def _either(moved: Reals, grown: Reals, up: Reals, down: Reals) -> Reals:
    """Return how far a change is noticed, or not noticed where negative, whichever of the two
    limits holds.

    ``moved`` : the size of the change; ``grown`` : by how much the part became larger in magnitude.
    That decides the limit, but only if the error of the environment is smaller than ``grown``.
    """
    # Beyond one limit while it is clear which one holds, or beyond both.
    beyond_up = np.minimum(grown, moved - up)
    beyond_down = np.minimum(-grown, moved - down)
    beyond = np.maximum(beyond_up, beyond_down)
    outer = np.maximum(moved - np.maximum(up, down), beyond)
    within_up = np.minimum(grown, up - moved)
    within_down = np.minimum(-grown, down - moved)
    within = np.maximum(within_up, within_down)
    inner = np.maximum(np.minimum(up, down) - moved, within)
    distance: Reals = np.where(outer > 0, outer, -np.maximum(inner, 0))
    return distance


def _two_way(up: Reals, down: Reals, x: Reals, env: Reals) -> Reals:
    """Return the distance with one limit for changes that make a part larger in magnitude, another
    for those that make it smaller.

    With env = e > 0 the part is smaller in magnitude for changes between -2 e and 0: not noticed is
    [-min(down, 2 e), up], and [-up, -2 e] where that is not empty.
    """
    # Mirrored where the environment's part is negative.
    x = np.where(env < 0, -x, x)
    turn = -2 * np.abs(env)
    first = np.maximum(-down, turn)
    beyond = -up <= turn
    # Where both intervals touch they are one, and its border is not in the middle.
    first = np.where(beyond & (first <= turn), -up, first)
    near = np.minimum(x - first, up - x)
    in_far_one = np.minimum(x + up, turn - x)
    far = np.where(beyond, in_far_one, -np.inf)
    distance: Reals = -np.maximum(near, far)
    return distance


# The plane.


def _corners(c: Threshold, at: Reals) -> Corners:
    """Return the corners of a region at given frequencies."""
    return [(values_of(x, at), values_of(y, at)) for x, y in c.corners]


def _edges(corners: Corners) -> Iterable[tuple[Reals, Reals, Reals, Reals]]:
    """Yield each edge of a polygon: the corner where it begins, and its direction."""
    for (px, py), (qx, qy) in pairwise([*corners, corners[0]]):
        yield px, py, qx - px, qy - py


def _axis(corners: Corners, i: int) -> tuple[Reals, Reals]:
    """Return where a convex polygon that holds the origin cuts an axis: x (0) or y (1)."""
    first_x, _ = corners[0]
    low = np.full(len(first_x), -np.inf)
    high = np.full(len(first_x), np.inf)
    # A point is inside where dy (x - px) - dx (y - py) <= 0 for all edges, counterclockwise. On an
    # axis that is a bound from above or from below, by the sign of its coefficient.
    for px, py, dx, dy in _edges(corners):
        slope = (dy, -dx)[i]
        reach = dy * px - dx * py
        with np.errstate(divide="ignore", invalid="ignore"):
            end = reach / slope
        high = np.where(slope > 0, np.minimum(high, end), high)
        low = np.where(slope < 0, np.maximum(low, end), low)
    return low, high


def _from_polygon(corners: Corners, x: Reals, y: Reals) -> Reals:
    """Return the distance from a convex polygon, corners counterclockwise."""
    depth = np.full(len(x), np.inf)
    away = np.full(len(x), np.inf)
    # Inside, the least distance from the lines through the edges; outside, from the edges
    # themselves.
    for px, py, dx, dy in _edges(corners):
        length = np.hypot(dx, dy)
        off_x = x - px
        off_y = y - py
        across = dx * off_y - dy * off_x
        along = off_x * dx + off_y * dy
        depth = np.minimum(depth, across / length)
        # The foot of the perpendicular, or the end of the edge that is nearer.
        share = np.clip(along / length**2, 0, 1)
        rest_x = off_x - share * dx
        rest_y = off_y - share * dy
        away = np.minimum(away, np.hypot(rest_x, rest_y))
    distance: Reals = np.where(depth >= 0, -depth, away)
    return distance


def _from_ellipse(a: Reals, b: Reals, tilt: Reals, x: Reals, y: Reals) -> Reals:
    """Return the distance from (x/a)^2 - 2 t (x/a)(y/b) + (y/b)^2 <= 1 - t^2: by the foot of the
    perpendicular, found by bisection in the principal axes.

    In these, with half axes long and short, the point is (u, v) and the foot (long^2 u/(m + long^2
    - short^2), short^2 v/m); the multiplier m may be close to 0, and is found to its last digits.
    """
    # The matrix [[a^2, t a b], [t a b, b^2]] has the squares of the half axes as eigenvalues: their
    # mean plus and minus ``spread``. The small one follows from the determinant, without
    # cancelling.
    mixed = tilt * a * b
    apart = (a - b) * (a + b) / 2
    spread = np.hypot(apart, mixed)
    turned = 0.5 * np.arctan2(mixed, apart)
    mean = (a**2 + b**2) / 2
    long = np.sqrt(mean + spread)
    short = a * b * upright(tilt) / long
    cos = np.cos(turned)
    sin = np.sin(turned)
    # By symmetry the first quadrant is enough.
    u = np.abs(x * cos + y * sin)
    v = np.abs(y * cos - x * sin)
    u = np.maximum(u, _NEAR * long)
    v = np.maximum(v, _NEAR * short)
    # The foot is on the ellipse for one multiplier, between these two. Halved on its logarithm, as
    # it may be many powers of ten below its upper end.
    low = short * v
    high = np.hypot(long * u, short * v)
    for _ in range(_HALVINGS):
        m = np.sqrt(low) * np.sqrt(high)
        foot_u = long * u / (m + 2 * spread)
        foot_v = short * v / m
        beyond = foot_u**2 + foot_v**2 > 1
        low = np.where(beyond, m, low)
        high = np.where(beyond, high, m)
    m = np.sqrt(low) * np.sqrt(high)
    # Point minus foot is (m - short^2) (u/(m + long^2 - short^2), v/m): no difference of near
    # numbers.
    scale = np.abs(m - short**2)
    along_u = u / (m + 2 * spread)
    distance: Any = scale * np.hypot(along_u, v / m)
    inside = (u / long) ** 2 + (v / short) ** 2 <= 1
    signed: Reals = np.where(inside, -distance, distance)
    return signed


OPEN = 2
"""Stands for a sign that a disc does not determine."""


class PartVerdict(Enum):
    """The verdict on a part at a frequency point."""

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
    felt = scene.perceived
    own = scene.environment
    if scene.band is not None:
        low, high = scene.band
        felt = felt.on_band(float(low), float(high))
    if isinstance(own, Environment):
        return felt, None
    # Two files of one bench round their frequencies differently.
    nearest = _nearest(own.omega, felt.omega)
    apart = np.abs(own.omega[nearest] - felt.omega)
    common = apart <= _SAME * felt.omega
    if not common.any():
        raise SceneError(
            f"{own.name} and {felt.name} have no frequency in common: measure both at the "
            f"same frequencies"
        )
    return felt.at(common), own.at(nearest[common])


_SAME = 1e-9
"""Frequencies that differ by no more than this share are one: files round them."""


def _nearest(among: Reals, wanted: Reals) -> Any:
    """Return for each wanted frequency the index of the nearest one among ascending others."""
    right = np.searchsorted(among, wanted).clip(0, len(among) - 1)
    left = np.maximum(right - 1, 0)
    from_left = wanted - among[left]
    from_right = among[right] - wanted
    return np.where(from_left <= from_right, left, right)


def lines_of(scene: MeasuredScene) -> Lines:
    """Return the frequency points that a scene judges. SceneError where H_env is infinite at one
    of them."""
    felt, own = matched(scene)
    env = _exact(scene, felt.omega) if own is None else own.H
    none = np.broadcast_to(0.0, len(felt))
    env_discs = None if own is None else own.discs
    inner = none if env_discs is None else env_discs
    outer = none if felt.discs is None else felt.discs
    known = env_discs is not None or felt.discs is not None
    size = np.abs(env)
    with np.errstate(divide="ignore", invalid="ignore"):
        change = (felt.H - env) / size
        # True values H_e + e and H_p + p, |e| <= inner, |p| <= outer: the true change differs from
        # this one, relative to the true |H_e| >= size - inner, by at most this. No bound is known
        # where the disc of H_env holds 0.
        share = inner / size
        moved = (inner + outer) / size + np.abs(change) * share
        radius = np.where(share < 1, moved / (1 - share), np.inf)
    return Lines(
        omega=felt.omega,
        environment=env,
        perceived=felt.H,
        env_radius=inner,
        perc_radius=outer,
        change=change,
        radius=radius if known else None,
        felt=felt,
        own=own,
    )


def _exact(scene: MeasuredScene, at: Reals) -> Complexes:
    """H_env of a model, at all frequencies."""
    program = scene.frame.distortion().compile(of=["environment_real", "environment_imag"])
    values = program(at)
    with np.errstate(invalid="ignore"):  # of what is infinite
        env: Complexes = values.environment_real + 1j * values.environment_imag
    if not np.isfinite(env).all():
        where = at[int(np.argmin(np.isfinite(env)))]
        raise SceneError(f"H_env is infinite at {where:.6g} rad/s: leave that frequency point out")
    return env


# Step 1.


def limits_of(scene: MeasuredScene, at: Reals) -> dict[Part, Reals]:
    """Return for each part the smaller of the two limits within which a change of that part alone
    is not noticed."""
    limits = {}
    for part in Part:
        low, high = ends_of(scene.threshold, part, at)
        limits[part] = np.minimum(-low, high)
    return limits


@dataclass(frozen=True, eq=False)
class JudgedLine:
    """The judgement of frequency points. ``distance`` : how far, relative to ``|H_env|``, a line's
    change lies outside the region, negative inside; ``verdict`` : 1 where the whole disc lies
    outside, -1 where it lies inside, 0 where it does not tell."""

    distance: Reals
    verdict: Any


def judged(scene: MeasuredScene, x: Lines, part: Part | None) -> JudgedLine | None:
    """Judge a part by itself, or both together (``part`` None); None where the region has no joint
    judgement."""
    c = scene.threshold
    with np.errstate(divide="ignore", invalid="ignore"):
        if part is None:
            distance = joint_distance(c, x.omega, x.change.real, x.change.imag)
            if distance is None:
                return None
        else:
            change = _side(x.change, part)
            # Where the change alone decides, the environment is not used: anything may stand for
            # it.
            env, reach = change, (change, change)
            if not is_of_change_alone(c, part):
                env, reach = _environment(x, part)
            distance = part_distance(c, part, x.omega, change, env, reach)
    return _told(x, distance, part, c)


def _side(z: Complexes, part: Part) -> Reals:
    """Return the real or the imaginary parts."""
    return z.real if part is Part.REAL else z.imag


def _environment(x: Lines, part: Part) -> tuple[Reals, tuple[Reals, Reals]]:
    """Return a part of H_env as a share of ``|H_env|``, and the least and the largest ``|H_env|``
    in its disc."""
    size = np.abs(x.environment)
    share = _side(x.environment, part) / size
    least = np.maximum(size - x.env_radius, 0)
    return share, (least, size + x.env_radius)


def _told(x: Lines, distance: Reals, part: Part | None, c: Threshold) -> JudgedLine:
    """Return the verdicts that follow from distances and discs.

    Where H_env is 0, there is no ratio: dH, or its part, is compared with the floor.
    """
    zero = (x.environment == 0) & (x.env_radius == 0)
    is_any = bool(zero.any())
    if is_any:
        dH = x.perceived - x.environment
        moved = np.abs(_side(dH, part) if part else dH)
        floor = floor_of(c, x.omega)
        by_floor = np.where(moved <= floor, -np.inf, np.inf)
        distance = np.where(zero, by_floor, distance)
    with np.errstate(invalid="ignore"):
        radius = 0.0 if x.radius is None else x.radius
        # The region is closed: a change on its border is not noticed.
        outside = distance > radius
        inside = distance <= -radius
    if is_any:
        outside = np.where(zero, moved > x.perc_radius + floor, outside)
        inside = np.where(zero, moved + x.perc_radius <= floor, inside)
    verdict = outside.astype(np.int8) - inside.astype(np.int8)
    return JudgedLine(distance, verdict)


# Step 2.


@dataclass(frozen=True, eq=False)
class Signs:
    """The signs of a part in H_env and H_perc, and whether it is felt larger (1), smaller (-1)
    or equal (0); OPEN where the discs do not decide."""

    environment: Any
    perceived: Any
    compared: Any

    @property
    def known(self) -> Any:
        """Where all three signs are determined."""
        both = (self.environment != OPEN) & (self.perceived != OPEN)
        return both & (self.compared != OPEN)

    def label(self, part: Part, line: int) -> tuple[Property, Change]:
        """Return how the change is felt at a point where all signs are known."""
        change = _CHANGES[int(self.compared[line])]
        if part is Part.IMAG:
            return Property.DAMPING, change
        env = int(self.environment[line])
        perc = int(self.perceived[line])
        return real_property(env, perc), change


_CHANGES = {1: Change.HIGHER, -1: Change.LOWER, 0: Change.EQUAL}


def signs(x: Lines, part: Part) -> Signs:
    """Return the signs of one part at all points."""
    env = _side(x.environment, part)
    perc = _side(x.perceived, part)
    grown = np.abs(perc) - np.abs(env)
    # ||a| - |b|| changes by no more than both radii together.
    compared = _sign(grown, x.env_radius + x.perc_radius)
    return Signs(_sign(env, x.env_radius), _sign(perc, x.perc_radius), compared)


def _sign(value: Reals, radius: Reals) -> Any:
    """Return the signs of values; OPEN where the radius reaches 0. An exact 0 has the sign 0."""
    is_known = (np.abs(value) > radius) | (radius == 0)
    sign: Any = np.where(is_known, np.sign(value), OPEN)
    return sign.astype(np.int8)


def certainty(m: Measurement) -> str:
    """Return words for what the discs of a response come from."""
    if m.coherence is not None:
        return f"coherence, {m.averages:g} averages"
    return "no disc is known" if m.radius is None else "radius in the file"
