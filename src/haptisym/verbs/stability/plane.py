"""The plane of a hand of one mass, or of a wall with a clock: cells drawn in floats, and the
certified count in each of them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
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

_PIXELS = 200  # along each axis, that find the cells
_LEAST = 60  # pixels of a cell that is counted
_FREQUENCIES = 4000
_MOST_CELLS = 12
_BITS = 128
_ROUNDING = 1e-9  # in shares
_TURNS = 12  # of the longest delay, at most, that are drawn

Window: TypeAlias = tuple[float, float, float, float]


@dataclass(frozen=True)
class HandCell:
    """Hands of one count: where that is written, and the certified roots of the hand there; None
    where not decided."""

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
    """Of hands of one mass: the boundary ``k``, ``b`` along ``omega``, the stiffness with a root at
    0, and the cells in a window.

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
    """The plane of a hand's mass."""
    found = boundary(scene, hand, window)
    labels = _labels(found.k, found.b, found.at_0, window)
    return replace(
        found, cells=tuple(_cells(lambda k, b: _roots(scene, hand, k, b), labels, window))
    )


def boundary(scene: Scene, hand: Hand, window: Window) -> Plane:
    """The same without its cells."""
    mass = float(hand.m.value)
    response = scene.closed.compile(of=("perceived_real", "perceived_imag"))

    def at(omega: Array) -> tuple[Array, Array]:
        values = response(omega)
        return mass * omega**2 - values.perceived_real, -values.perceived_imag / omega

    end = _end(at, window, [float(x) for x in ring_of(scene.closed.perc).lags])
    grids = np.geomspace(1e-5 * end, end, _FREQUENCIES), np.linspace(1e-5 * end, end, _FREQUENCIES)
    k, b = at(np.unique(np.concatenate(grids)))
    start = -float(response(np.array([0.0])).perceived_real[0])
    at_0 = start if np.isfinite(start) else None
    return Plane(mass, k, b, at_0, window)


def wall_plane(scene: Scene, hand: Hand, window: Window) -> Plane:
    """Stiffness and damping of the wall that a display with a clock renders, in a hand.

    UndecidedError where the loop's polynomial is not linear in them, as it is of a spring with a
    damper.
    """
    low, high, least, most = window
    middles = (np.arange(_PIXELS) + 0.5) / _PIXELS
    k, b = low + middles * (high - low), least + middles * (most - least)
    k0, k1, b0, b1 = (
        k[_PIXELS // 4],
        k[-_PIXELS // 4],
        b[_PIXELS // 4],
        b[-_PIXELS // 4],
    )  # nothing cancels within
    c = {(x, y): _coefficients(scene, hand, x, y) for x in (k0, k1) for y in (b0, b1)}
    size = max(map(len, c.values()))
    c = {at: np.pad(row, (0, size - len(row))) for at, row in c.items()}
    along, across = (c[k1, b0] - c[k0, b0]) / (k1 - k0), (c[k0, b1] - c[k0, b0]) / (b1 - b0)
    bent = c[k1, b1] - c[k0, b0] - along * (k1 - k0) - across * (b1 - b0)
    if np.abs(bent).max() > _ROUNDING * max(np.abs(x).max() for x in c.values()):
        raise UndecidedError("the plane of a wall of which the loop is no linear function")
    if not along.any() and not across.any():
        raise UndecidedError("the plane of a wall that is not what is rendered")
    rows = c[k0, b0] + (k - k0)[:, None, None] * along + (b - b0)[None, :, None] * across
    counts = _outside(rows)
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

    return Plane(
        float(hand.m.value), nowhere, nowhere, None, window, tuple(_cells(at, labels, window))
    )


def _wall(scene: Scene, k: float, b: float) -> Scene:
    return scene.with_values(
        {path: Rational(f"{x:.3g}") for path, x in zip(WALL, (k, b), strict=True)}
    )


def _coefficients(scene: Scene, hand: Hand, k: float, b: float) -> Array:
    """Of the loop's polynomial in 1/z, ascending."""
    own = scene.with_values({path: Rational(x) for path, x in zip(WALL, (k, b), strict=True)})
    with flint.ctx.workprec(_BITS):
        return np.array([float(x.mid()) for x in loop_of(own, hand).balls()])


def _outside(rows: Array) -> Array:
    """How many roots z of polynomials in 1/z with these coefficients have ``|z|`` >= 1."""
    n = rows.shape[-1] - 1
    companion = np.zeros((*rows.shape[:-1], n, n))
    companion[..., 0, :] = -rows[..., 1:] / rows[..., :1]
    companion[..., np.arange(1, n), np.arange(n - 1)] = 1
    return np.asarray((np.abs(np.linalg.eigvals(companion)) >= 1).sum(-1))


def _end(
    boundary: Callable[[Array], tuple[Array, Array]], window: Window, lags: list[float]
) -> float:
    """The frequency at which the boundary leaves the window for good, as far as floats show."""
    rough = np.geomspace(1e-3, 1e6, 20_000)
    k, b = boundary(rough)
    low, high, least, most = window
    inside = (k > low) & (k < high) & (b > least) & (b < most)
    last = float(1.2 * rough[inside][-1]) if inside.any() else 100.0
    return min(last, 2 * np.pi * _TURNS / max(lags)) if lags else last


def _labels(k: Array, b: Array, at_0: float | None, window: Window) -> Array:
    """A number for each pixel: 0 on the boundary, else that of its cell."""
    low, high, least, most = window
    open_ones = np.ones((_PIXELS, _PIXELS), dtype=bool)
    x, y = (k - low) / (high - low) * _PIXELS, (b - least) / (most - least) * _PIXELS
    for (x0, x1), (y0, y1) in zip(pairwise(x), pairwise(y), strict=True):
        if max(x0, x1) < 0 or min(x0, x1) > _PIXELS or max(y0, y1) < 0 or min(y0, y1) > _PIXELS:
            continue
        count = int(min(2 * max(abs(x1 - x0), abs(y1 - y0)), 4 * _PIXELS)) + 2
        i, j = (np.linspace(*ends, count).astype(int) for ends in ((x0, x1), (y0, y1)))
        kept = (i >= 0) & (i < _PIXELS) & (j >= 0) & (j < _PIXELS)
        open_ones[i[kept], j[kept]] = False
    if at_0 is not None and low < at_0 < high:
        open_ones[int((at_0 - low) / (high - low) * _PIXELS), :] = False
    return _filled(open_ones)


def _filled(open_ones: Array) -> Array:
    """Numbers of the connected parts, from 1."""
    labels = np.zeros(open_ones.shape, dtype=int)
    for start in zip(*np.nonzero(open_ones), strict=True):
        if labels[start]:
            continue
        number, waiting = int(labels.max()) + 1, [start]
        labels[start] = number
        while waiting:
            i, j = waiting.pop()
            for place in ((i - 1, j), (i + 1, j), (i, j - 1), (i, j + 1)):
                if (
                    0 <= place[0] < _PIXELS
                    and 0 <= place[1] < _PIXELS
                    and open_ones[place]
                    and not labels[place]
                ):
                    labels[place] = number
                    waiting.append(place)
    return labels


def _cells(
    roots: Callable[[float, float], Roots | None], labels: Array, window: Window
) -> Iterator[HandCell]:
    """The largest parts, each with the certified count at its pixel that is farthest from the
    boundary."""
    low, high, least, most = window
    sizes = np.bincount(labels.ravel())
    for number in sorted(range(1, len(sizes)), key=lambda n: -int(sizes[n]))[:_MOST_CELLS]:
        if sizes[number] < _LEAST:
            return
        i, j = _deepest(labels == number)
        k, b = (
            low + (i + 0.5) * (high - low) / _PIXELS,
            least + (j + 0.5) * (most - least) / _PIXELS,
        )
        yield HandCell(k, b, roots(k, b), labels == number)


def _deepest(part: Any) -> tuple[int, int]:
    """The pixel that is left longest where the rim is taken away again and again."""
    left = np.pad(part, 1)
    while True:
        inner = (
            left
            & np.roll(left, 1, 0)
            & np.roll(left, -1, 0)
            & np.roll(left, 1, 1)
            & np.roll(left, -1, 1)
        )
        if not inner.any():
            rows, columns = np.nonzero(left)
            middle = len(rows) // 2
            return int(rows[middle]) - 1, int(columns[middle]) - 1
        left = inner


def _roots(scene: Scene, hand: Hand, k: float, b: float) -> Roots | None:
    perceived = scene.closed.perc
    ring = ring_of(perceived)
    near_k, near_b = (Rational(f"{x:.3g}") for x in (k, b))
    Z = ring.convert(hand.m.value * s**2 + near_b * s + near_k)
    try:
        return zeros_of(characteristic(perceived, Z), perceived.denominator, ring)
    except UndecidedError:
        return None
