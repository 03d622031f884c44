"""A device fitted to a Z-width plot: to the stiffness and damping at which a sampled wall began to
shake.

The loop's polynomial C(w), w = exp(-s T), is linear in the wall's stiffness K and damping B, so
that on the unit circle it is zero for one complex K; where that is real a pole crosses the circle,
and the least such K > 0 with all poles inside below it is the exact limit K(B). Least squares of ln
K over the free parameters' logarithms; intervals from resampled pairs (one-step bootstrap).
Estimated, not proven. Read from ``fit_zwidth``.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from flint import arb
from sympy import Expr

from haptisym.judge.answers import Answer
from haptisym.kernel.budget import SECONDS, limited, tick
from haptisym.kernel.errors import SceneError, UndecidedError, several
from haptisym.kernel.objects import titled
from haptisym.kernel.sampledloop import SampledLoop
from haptisym.model.catalogue import NOBODY, Hand
from haptisym.model.scene import Knob, Scene, chosen_hand, clocks
from haptisym.model.scenefile import as_scene
from haptisym.programs.values import Array
from haptisym.verbs.stability.clockedloop import loop_of
from haptisym.verbs.stability.entry import WALL

_ANGLES = 1500
"""Places on the half circle between which K(B) is searched for a real value."""
_RESAMPLED = 1000
"""Sets of pairs that are drawn, with repetition, for the intervals."""
_NO_LIMIT = 1e-12
"""The limit of a wall that is never stable, relative to the measured stiffness: far off any."""
_SEED = 1


@dataclass(frozen=True)
class DeviceEstimate:
    """A fitted parameter: its ``path`` in the scene, its ``value``, and the interval ``low`` to
    ``high`` of 95 % of the resampled fits, SI."""

    path: str
    value: float
    low: float
    high: float


@dataclass(frozen=True, eq=False, repr=False)
class ZWidthFit(Answer):
    """A device fitted to the walls at which it began to shake.

    ``stiffness``, ``damping`` : of the walls measured, SI; ``fitted`` : the exact limit of the
    stiffness at each damping, with the fitted device; ``estimates`` : of the free parameters.
    ``error`` : root mean square of ln K measured less fitted. ``together`` : paths of parameters
    that the data do not identify separately; empty where they do.
    Estimated: least squares and bootstrap.
    """

    _schema: ClassVar[str] = "haptisym.zwidth/1"
    _page: ClassVar[str] = "haptisym.pages.identify:page_zwidth"
    _figure: ClassVar[str] = "haptisym.figures.measured:ZWIDTH"

    scene: Scene
    hand: Hand
    stiffness: Array
    damping: Array
    fitted: Array
    estimates: tuple[DeviceEstimate, ...]
    error: float
    together: tuple[str, ...]

    def _line(self) -> str:
        found = ", ".join(f"{x.path} {x.value:.4g}" for x in self.estimates)
        return f"{titled(self.scene.title)}: {found}"

    @property
    def certified(self) -> bool:
        """False: a fit is estimated."""
        return False

    @property
    def settled(self) -> bool:
        """Whether the data identify all free parameters separately."""
        return not self.together

    def _body(self) -> dict[str, Any]:
        return {
            "hand": self.hand.name,
            "walls": [
                {"k": float(k), "b": float(b), "fitted": float(x)}
                for k, b, x in zip(self.stiffness, self.damping, self.fitted, strict=True)
            ],
            "estimates": [vars(x) for x in self.estimates],
            "error": self.error,
            "not_separately": list(self.together),
        }


def fit_zwidth(
    scene: Scene | str | Path,
    walls: Iterable[tuple[float, float]] | str | Path,
    free: Sequence[str] = (),
    hand: str | Hand = NOBODY,
    *,
    limit: float | None = SECONDS,
) -> ZWidthFit:
    """Fit parameters of a sampled display to the walls at which it began to shake.

    ``walls`` : pairs of stiffness and damping, SI, or a file of them: two columns with a heading,
    K and B in either order. ``free`` : parameters by path or symbol, all > 0; those with a range if
    none is named. ``hand`` : in which it was measured; none if not given. ``limit`` : seconds of
    processor time, LimitError after them; None for none. SceneError for a scene that is not
    sampled or has no wall of k and b, and for too few pairs.

    >>> from haptisym import effects, environments
    >>> clock = effects.sampled_loop("1 ms", "backward-difference")
    >>> device = effects.shunt(m="0.1 kg", b="1 N*s/m", name="device")
    >>> display = Scene(environments.kelvin_voigt(100, 1), (clock, device))
    >>> true = [(ZWidth.of(display, ()).limit([], B), B) for B in (0.0, 2.0, 5.0)]
    >>> found = fit_zwidth(display.with_values({"m": 1}), true, ["effects.device.m"])
    >>> f"{found.estimates[0].value:.6f}"
    '0.100000'
    """
    scene, asked = as_scene(scene), chosen_hand(as_scene(scene), hand)
    scene.knobs.need_numbers()
    pairs = read_walls(walls) if isinstance(walls, str | Path) else several("walls", walls, _PAIRS)
    K, B = (np.array([float(x[i]) for x in pairs]) for i in range(2))
    names = list(several("free", free, "give paths or symbols")) or [*scene.ranges()]
    knobs = scene.knobs.chosen(names)
    if not knobs:
        raise SceneError("zwidth: nothing is free: name parameters (--free), or give them ranges")
    if len(K) < len(knobs):
        raise SceneError(f"zwidth: {len(K)} walls for {len(knobs)} free parameters: too few")
    if not (K > 0).all() or not (B >= 0).all():
        raise SceneError("zwidth: K must be > 0 and B >= 0 in every pair")
    with limited(limit):
        return _fitted(ZWidth.of(scene, knobs, asked), asked, K, B)


_PAIRS = "give pairs of stiffness and damping, as [(500, 2), (800, 4)]"


def read_walls(path: str | Path) -> list[tuple[float, float]]:
    """Read pairs of stiffness and damping from a file of two columns, headed K and B."""
    rows = [x.split(",") for x in Path(path).read_text(encoding="utf-8").split("\n") if x.strip()]
    heads = [x.strip()[:1].upper() for x in rows[0]] if rows else []
    if sorted(heads) != ["B", "K"]:
        raise SceneError(f'{path}: the first line must name two columns, as "K [N/m],B [N s/m]"')
    try:
        pairs = [(float(x[heads.index("K")]), float(x[heads.index("B")])) for x in rows[1:]]
    except (ValueError, IndexError):
        raise SceneError(f"{path}: each line must have two numbers, K and B in SI") from None
    return pairs


@dataclass(frozen=True, eq=False)
class ZWidth:
    """The exact limit K(B) of a display's wall, as a function of its free parameters."""

    scene: Scene
    loop: SampledLoop
    free: tuple[Knob, ...]
    wall: tuple[Knob, Knob]

    @classmethod
    def of(cls, scene: Scene, free: Sequence[Knob], hand: Hand | None = None) -> ZWidth:
        """The limit of a scene in a hand. SceneError where it has no clock, or no wall."""
        if not clocks(scene) or not {*WALL} <= {x.path for x in scene.knobs}:
            raise SceneError(
                "zwidth: give a sampled scene (sampled-loop) with an environment of k and b: the "
                "wall that began to shake"
            )
        k, b = (scene.knobs[x] for x in WALL)
        for x in free:
            if x.path in WALL or x.parts or x.value.is_zero:
                raise SceneError(f"{x.path}: free is what the device has, > 0, not the wall")
        opened = scene.with_values({x.path: x.symbol for x in (*free, k, b)})
        try:
            loop = loop_of(opened, hand or Hand(NOBODY))
        except UndecidedError as error:
            raise SceneError(f"zwidth: {error}") from None
        return cls(scene, loop, tuple(free), (k, b))

    @cached_property
    def _circle(self) -> Array:
        """Angles omega T on the half circle, finer towards 0."""
        return np.geomspace(1e-4, np.pi, _ANGLES)

    def rows(self, values: Sequence[float]) -> list[Array]:
        """The loop's coefficients in w for (K, B) = (0, 0), (1, 0) and (0, 1)."""
        known: dict[Expr, Any] = {x.symbol: arb(v) for x, v in zip(self.free, values, strict=True)}
        k, b = (x.symbol for x in self.wall)
        corners = ((0, 0), (1, 0), (0, 1))
        rows = []
        for stiffness, damping in corners:
            balls = self.loop.balls({**known, k: arb(stiffness), b: arb(damping)})
            rows.append([float(x.mid()) for x in balls])
        size = max(map(len, rows))
        # Rows of one length, so that they can be added.
        return [np.pad(row, (0, size - len(row))) for row in rows]

    def limit(self, values: Sequence[float], damping: float) -> float:
        """The stiffness at which the wall begins to shake; 0 where it always does, infinite where
        it never does."""
        return self._limit(self.rows(values), damping)

    def limits(self, values: Sequence[float], dampings: Array) -> Array:
        """The same at several dampings."""
        rows = self.rows(values)
        return np.array([self._limit(rows, x) for x in dampings])

    def _limit(self, rows: Sequence[Array], damping: float) -> float:
        own = rows[0] + damping * (rows[2] - rows[0])
        slope = rows[1] - rows[0]

        if not np.isfinite([own, slope]).all():
            return 0.0

        def asked(angle: Any) -> Any:
            w = np.exp(-1j * angle)
            with np.errstate(all="ignore"):
                return -np.polyval(own[::-1], w) / np.polyval(slope[::-1], w)

        def is_stable(K: float) -> bool:
            # In w = 1/z all roots of a stable loop lie outside of the circle.
            roots = np.roots((own + K * slope)[::-1])
            return bool((np.abs(roots) > 1).all())

        parts = asked(self._circle)
        i = np.flatnonzero(np.diff(np.sign(parts.imag)) != 0)
        places = [_crossing(asked, *self._circle[n : n + 2]) for n in i]
        limits = sorted(K for x in (*places, np.pi) if (K := float(asked(x).real)) > 0)
        if not limits or not is_stable(limits[0] * (1 - 1e-6)):
            return 0.0 if not is_stable(1e-9) else np.inf
        return limits[0]


def _crossing(asked: Any, low: float, high: float) -> float:
    """The angle between two at which the gain asked for is real."""
    from scipy.optimize import brentq  # SciPy is an extra: asked for where it is needed

    try:
        return float(brentq(lambda x: asked(x).imag, low, high, xtol=1e-14))
    except ValueError:
        return high


def _fitted(model: ZWidth, hand: Hand, K: Array, B: Array) -> ZWidthFit:
    """Fit once to all pairs, then to sets of as many that are drawn from them."""
    from scipy.optimize import least_squares

    known: dict[tuple[float, ...], Array] = {}

    def residuals(logs: Array) -> Array:
        key = tuple(np.exp(logs))
        if key not in known:
            tick()
            known[key] = np.log(K / np.clip(model.limits(key, B), _NO_LIMIT * K, K / _NO_LIMIT))
        return known[key]

    start = np.log([float(x.value) for x in model.free])
    best = least_squares(
        residuals, start, bounds=(start - _REACH, start + _REACH), diff_step=1e-6, xtol=1e-12
    )
    _, sizes, directions = np.linalg.svd(best.jac)
    spread = float(np.sqrt(np.mean(best.fun**2)))
    # Along a direction in which the sum of squares hardly rises, parameters trade for each other.
    weak = sizes[-1] <= _WEAK * sizes[0] or spread > _TOLD * sizes[-1]
    moved = np.abs(directions[-1]) > _SHARE
    together = [x.path for x, is_moved in zip(model.free, moved, strict=True) if weak and is_moved]
    # One step of least squares takes each set of resampled pairs from the fit of all to its own
    # (one-step bootstrap): as exact as the interval of a fit that is near needs.
    draws = np.random.default_rng(_SEED).integers(0, len(K), (_RESAMPLED, len(K)))
    steps = [np.linalg.lstsq(best.jac[d], best.fun[d], rcond=None)[0] for d in draws]
    found = np.clip(best.x - steps, start - _REACH, start + _REACH)
    low, high = np.exp(np.quantile(found, [0.025, 0.975], axis=0))
    values = np.exp(best.x)
    estimates = tuple(
        DeviceEstimate(x.path, *map(float, numbers))
        for x, *numbers in zip(model.free, values, low, high, strict=True)
    )
    fitted = model.limits(values, B)
    return ZWidthFit(model.scene, hand, K, B, fitted, estimates, spread, tuple(together))


_REACH = 7.0  # ln 1000: no parameter is looked for farther from its value in the scene
_WEAK = 1e-4  # relative: of two slopes whose quotient only rounding of the slopes makes
_TOLD = 0.7  # ln 2: an error of a factor of two is no estimate
_SHARE = 0.3  # of a unit vector of logarithms: a parameter that has a part in it
