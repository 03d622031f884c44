"""Pictures of stability: the plane of stiffness and damping of a hand of one mass, or of a sampled
wall, cut into cells of equally many unstable roots.

Along the boundary of a cell a root is on the imaginary axis: for a hand, H_perc(j omega) - m
omega^2 + j omega b + k = 0, a curve k(omega), b(omega) (D-decomposition), and the line k =
-H_perc(0) of a root at s = 0. It is drawn in floats on a grid of pixels; the parts that it leaves
connected are the cells. So where a cell is, and whether a narrow one was missed, is computed and
not proven. The number of roots is counted exactly, at one point of each cell. Begin with ``plane``;
``wall_plane`` is the same for a loop with a clock, of which the pixels themselves are counted in
floats.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import pairwise, product
from typing import Any, TypeAlias

import flint
from sympy import Rational

from haptisym.kernel.arrays import np
from haptisym.kernel.dynamics import ring_of
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.rings import s
from haptisym.kernel.rootcount import Roots
from haptisym.model.catalogue import Hand
from haptisym.model.scene import Scene
from haptisym.programs.values import Array
from haptisym.verbs.stability.clockedloop import clocked_roots, loop_of
from haptisym.verbs.stability.entry import WALL
from haptisym.verbs.stability.held import characteristic, zeros_of

# Pixels along each axis.
_PIXELS = 200
# Pixels of the smallest cell that is counted.
_LEAST = 60
# Points of the boundary in each of its two grids of frequencies.
_FREQUENCIES = 4000
# The largest cells, whose roots are counted.
_MOST_CELLS = 12
# Of the balls whose middles are the coefficients of a loop.
_BITS = 128
# What coefficients of a loop may be off by, as a share of the largest, and still be linear.
_ROUNDING = 1e-9
# Turns of the longest delay that are drawn: from each on the boundary winds once more around.
_TURNS = 12

# The steps from a pixel to those that share a side with it.
_NEIGHBOURS = (-1, 0), (1, 0), (0, -1), (0, 1)

Window: TypeAlias = tuple[float, float, float, float]
"""Lowest and highest stiffness, lowest and highest damping."""


@dataclass(frozen=True)
class HandCell:
    """A cell of the plane: its ``pixels``, the point ``k``, ``b`` in its middle, and the roots in
    Re s >= 0 there, counted exactly; None where that was not decided."""

    k: float
    b: float
    roots: Roots | None
    pixels: Any

    @property
    def is_stable(self) -> bool:
        """Whether the display is stable in its hands."""
        return self.roots is not None and self.roots.number == 0


@dataclass(frozen=True)
class Plane:
    """The plane of hands of one mass: its boundary ``k``, ``b`` along omega, the stiffness ``at_0``
    with a root at s = 0, and the cells in a window.

    k = m omega^2 - Re H_perc and b = -Im H_perc/omega. ``window`` : lowest and highest k, lowest
    and highest b. What is drawn is floats, and finds the cells; the count of each is certified at
    one hand in it.
    """

    mass: float
    k: Array
    b: Array
    at_0: float | None
    window: Window
    cells: tuple[HandCell, ...] = ()


def plane(scene: Scene, hand: Hand, window: Window) -> Plane:
    """The plane of the hands that have a hand's mass, with its cells."""
    drawn = boundary(scene, hand, window)
    labels = _labels(drawn.k, drawn.b, drawn.at_0, window)
    cells = _cells(lambda k, b: _roots(scene, hand, k, b), labels, window)
    return replace(drawn, cells=tuple(cells))


def boundary(scene: Scene, hand: Hand, window: Window) -> Plane:
    """The plane without its cells: its boundary alone, in floats."""
    mass = float(hand.m.value)
    response = scene.closed.compile(of=("perceived_real", "perceived_imag"))

    def at(omega: Array) -> tuple[Array, Array]:
        values = response(omega)
        stiffness = mass * omega**2 - values.perceived_real
        damping = -values.perceived_imag / omega
        return stiffness, damping

    lags = [float(x) for x in ring_of(scene.closed.perc).lags]
    end = _end(at, window, lags)
    begin = 1e-5 * end
    # Equal steps show the turns of a delay, steps of the logarithm where the boundary begins.
    by_ratio = np.geomspace(begin, end, _FREQUENCIES)
    by_step = np.linspace(begin, end, _FREQUENCIES)
    grid = np.unique(np.concatenate([by_ratio, by_step]))
    k, b = at(grid)
    static = response(np.array([0.0]))
    at_0 = -float(static.perceived_real[0])
    return Plane(mass, k, b, at_0 if np.isfinite(at_0) else None, window)


def wall_plane(scene: Scene, hand: Hand, window: Window) -> Plane:
    """Stiffness and damping of the wall that a display with a clock renders, in a hand.

    UndecidedError where the loop's polynomial is not linear in them, as it is of a spring with a
    damper.
    """
    low, high, least, most = window
    middles = (np.arange(_PIXELS) + 0.5) / _PIXELS
    k = low + middles * (high - low)
    b = least + middles * (most - least)
    # The polynomial is c(k, b) = c0 + k c1 + b c2: made at four points, the fourth of which shows
    # whether it is so. They lie amid the window, where no coefficient is lost.
    first, last = _PIXELS // 4, -_PIXELS // 4
    k0, k1 = k[first], k[last]
    b0, b1 = b[first], b[last]
    polynomials = []
    for x, y in product((k0, k1), (b0, b1)):
        polynomials.append(_coefficients(scene, hand, x, y))
    size = max(map(len, polynomials))
    padded = [np.pad(row, (0, size - len(row))) for row in polynomials]
    start, at_b1, at_k1, at_both = padded
    step_k, step_b = k1 - k0, b1 - b0
    along = (at_k1 - start) / step_k
    across = (at_b1 - start) / step_b
    bent = at_both - start - along * step_k - across * step_b
    largest = max(np.abs(x).max() for x in padded)
    if np.abs(bent).max() > _ROUNDING * largest:
        raise UndecidedError("the plane of a wall of which the loop is no linear function")
    if not along.any() and not across.any():
        raise UndecidedError("the plane of a wall that is not what is rendered")
    by_k = (k - k0)[:, None, None] * along
    by_b = (b - b0)[None, :, None] * across
    counts = _outside(start + by_k + by_b)
    # One count may belong to several cells that do not touch: each gets a number of its own.
    labels = np.zeros(counts.shape, dtype=int)
    for number in np.unique(counts):
        part = _filled(counts == number)
        labels += np.where(part > 0, part + labels.max(), 0)
    nowhere = np.array([])

    def at(k: float, b: float) -> Roots | None:
        try:
            return clocked_roots(_wall(scene, k, b), hand)
        except UndecidedError:
            return None

    cells = tuple(_cells(at, labels, window))
    return Plane(float(hand.m.value), nowhere, nowhere, None, window, cells)


def _wall(scene: Scene, k: float, b: float) -> Scene:
    """The scene with a wall of k and b, of three digits each, as they are written."""
    walls = zip(WALL, (k, b), strict=True)
    return scene.with_values({path: Rational(f"{x:.3g}") for path, x in walls})


def _coefficients(scene: Scene, hand: Hand, k: float, b: float) -> Array:
    """The coefficients of the loop's polynomial in 1/z, ascending, at a wall of k and b."""
    wall = zip(WALL, (k, b), strict=True)
    own = scene.with_values({path: Rational(x) for path, x in wall})
    with flint.ctx.workprec(_BITS):
        balls = loop_of(own, hand).balls()
        return np.array([float(x.mid()) for x in balls])


def _outside(rows: Array) -> Array:
    """How many roots z of polynomials in 1/z with these coefficients have ``|z|`` >= 1."""
    n = rows.shape[-1] - 1
    # The eigenvalues of the companion matrix, all pixels at once, are the roots z.
    companion = np.zeros((*rows.shape[:-1], n, n))
    leading = rows[..., :1]
    companion[..., 0, :] = -rows[..., 1:] / leading
    below = np.arange(1, n)
    diagonal = np.arange(n - 1)
    companion[..., below, diagonal] = 1
    sizes = np.abs(np.linalg.eigvals(companion))
    return np.asarray((sizes >= 1).sum(-1))


def _end(
    boundary: Callable[[Array], tuple[Array, Array]], window: Window, lags: list[float]
) -> float:
    """The frequency at which the boundary leaves the window for good, as far as floats show."""
    rough = np.geomspace(1e-3, 1e6, 20_000)
    k, b = boundary(rough)
    low, high, least, most = window
    k_inside = (k > low) & (k < high)
    b_inside = (b > least) & (b < most)
    inside = rough[k_inside & b_inside]
    # A fifth beyond the last point inside, so that the way out is drawn too.
    end = float(1.2 * inside[-1]) if len(inside) else 100.0
    if not lags:
        return end
    return min(end, 2 * np.pi * _TURNS / max(lags))


def _labels(k: Array, b: Array, at_0: float | None, window: Window) -> Array:
    """A number for each pixel: 0 on the boundary, else that of its cell."""
    low, high, least, most = window
    open_ones = np.ones((_PIXELS, _PIXELS), dtype=bool)
    x = (k - low) / (high - low) * _PIXELS
    y = (b - least) / (most - least) * _PIXELS
    for (x0, x1), (y0, y1) in zip(pairwise(x), pairwise(y), strict=True):
        left, right = min(x0, x1), max(x0, x1)
        lower, upper = min(y0, y1), max(y0, y1)
        x_outside = right < 0 or left > _PIXELS
        if x_outside or upper < 0 or lower > _PIXELS:
            continue
        # Two points to each pixel of the line, so that it has no holes through which two cells
        # would become one; no more on a line that comes from far away, as at a pole.
        length = max(right - left, upper - lower)
        count = int(min(2 * length, 4 * _PIXELS)) + 2
        i = np.linspace(x0, x1, count).astype(int)
        j = np.linspace(y0, y1, count).astype(int)
        i_is_seen = (i >= 0) & (i < _PIXELS)
        j_is_seen = (j >= 0) & (j < _PIXELS)
        is_seen = i_is_seen & j_is_seen
        open_ones[i[is_seen], j[is_seen]] = False
    if at_0 is not None and low < at_0 < high:
        i_of_line = int((at_0 - low) / (high - low) * _PIXELS)
        open_ones[i_of_line, :] = False
    return _filled(open_ones)


def _filled(open_ones: Array) -> Array:
    """A number, from 1, for each pixel of a connected part, and 0 elsewhere: flood filling.

    Pixels touch by their sides alone: a boundary that goes diagonally parts them.
    """
    labels = np.zeros(open_ones.shape, dtype=int)
    for start in zip(*np.nonzero(open_ones), strict=True):
        if labels[start]:
            continue
        number = int(labels.max()) + 1
        waiting = [start]
        labels[start] = number
        while waiting:
            i, j = waiting.pop()
            for di, dj in _NEIGHBOURS:
                x = i + di
                y = j + dj
                on_grid = 0 <= x < _PIXELS and 0 <= y < _PIXELS
                if on_grid and open_ones[x, y] and not labels[x, y]:
                    labels[x, y] = number
                    waiting.append((x, y))
    return labels


def _cells(
    roots: Callable[[float, float], Roots | None], labels: Array, window: Window
) -> Iterator[HandCell]:
    """The largest parts, each with the certified count at its pixel that is farthest from the
    boundary."""
    low, high, least, most = window
    sizes = np.bincount(labels.ravel())
    by_size = sorted(range(1, len(sizes)), key=lambda n: -int(sizes[n]))
    for number in by_size[:_MOST_CELLS]:
        if sizes[number] < _LEAST:
            return
        pixels = labels == number
        i, j = _deepest(pixels)
        k = low + (i + 0.5) * (high - low) / _PIXELS
        b = least + (j + 0.5) * (most - least) / _PIXELS
        yield HandCell(k, b, roots(k, b), pixels)


def _deepest(part: Any) -> tuple[int, int]:
    """The pixel that is left longest where the rim is taken away again and again."""
    # The frame of False counts the window's edge as boundary: 1 is taken off again below.
    left = np.pad(part, 1)
    while True:
        inner = left
        for axis in (0, 1):
            for shift in (1, -1):
                inner = inner & np.roll(left, shift, axis)
        if not inner.any():
            rows, columns = np.nonzero(left)
            middle = len(rows) // 2
            return int(rows[middle]) - 1, int(columns[middle]) - 1
        left = inner


def _roots(scene: Scene, hand: Hand, k: float, b: float) -> Roots | None:
    """The roots in Re s >= 0 in a hand of a hand's mass; None where that is not decided."""
    perceived = scene.closed.perc
    ring = ring_of(perceived)
    # Three digits, as they are written into the picture: far inside of a cell the others do not
    # matter.
    near_k = Rational(f"{k:.3g}")
    near_b = Rational(f"{b:.3g}")
    impedance = hand.m.value * s**2 + near_b * s + near_k
    Z = ring.convert(impedance)
    try:
        polynomial = characteristic(perceived, Z)
        return zeros_of(polynomial, perceived.denominator, ring)
    except UndecidedError:
        return None
