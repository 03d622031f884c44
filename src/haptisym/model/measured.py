"""A measured frequency response: is it valid, and within which distance of each value does the true
response lie?

A *line* is one frequency omega_i with the measured value H_i, force over position. Around it lies a
*disc*: all H with |H - H_i| <= r_i. With a stated probability, the *confidence*, it contains the
true response at omega_i. The radius r_i is one of three:

- From the coherence g2 and the number of averages, by the F distribution: ``disc_radius``. This is
  the confidence region of an estimate H1, for noise in the force that is Gaussian and independent
  of the motion, and segments that are independent of each other.
- Given as ``radius``, in the unit of H. It is taken as it is, whatever the confidence.
- Unknown: then the response has no discs.

Between the lines nothing is known but by a bound on the slope |dH/domega| (``SlopeBound``). It is
an assumption of the person who measured, and is not tested. With it the disc of a line grows with
the distance from the line. How the lines were estimated, where they come from records in time, is
in ``Welch``.

**Guaranteed**: every ``Measurement`` was checked when it was made. Its frequencies are finite, >= 0
and rise strictly, H is finite, coherences lie from 0 to 1, radii are >= 0 or infinite, and no array
can be written to. Radii that grow are rounded up, so that they are no smaller than the bound says.

Begin reading at ``Measurement``; ``measuring.measured`` makes one of files and arrays.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum
from functools import cached_property
from math import erfc, isfinite, sqrt
from numbers import Real
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from haptisym.kernel.errors import SceneError, Setting, quoted
from haptisym.kernel.objects import Shown, counted
from haptisym.model.files import write_whole
from haptisym.model.quantities import Dimension, MotionKind, Number, number

Reals: TypeAlias = NDArray[np.float64]
Complexes: TypeAlias = NDArray[np.complex128]
LineName: TypeAlias = Callable[[int], str]
"""A function that names a line by its index, for an error: ``line 3``."""

CONFIDENCE = 0.95
"""The probability with which a disc contains the true response, unless another one is given."""
# The excess over 1 that a coherence may have: it is a quotient of sums over thousands of samples,
# each of which rounds by 2^-53.
_COHERENCE_EXCESS = 2.0**-40
# Files round frequencies, and 2 pi f rounds again: a line that stands at an end of a band is on it
# up to this share of the end.
_BAND_EXCESS = 1e-9
# Nine units in the last place: more than the roundings of the few operations that it follows, so
# that a product with it is an upper bound.
_ROUND_UP = 1 + 2e-15
_SLOPE_EXAMPLES = (
    'give |dH/domega| with its unit, as in "40 N*s/m" or "250 N/m/Hz", or as a share of |H|, as '
    'in "20 ms"'
)


@dataclass(frozen=True, eq=False, repr=False)
class Measurement(Shown):
    """A measured frequency response H, force over position, N/m or N m/rad. Valid by construction:
    SceneError, beginning with the ``name``, for values that no response can have.

    ``omega`` : the frequencies, rad/s, rising. ``H`` : the response at each, complex.
    ``coherence`` : of motion and force at each frequency, 0 to 1; it needs ``averages``, the number
    of independent segments that were averaged, at least 2.
    ``radius`` : in place of both, the radius of each disc in the unit of H; infinite where nothing
    is known.
    ``confidence`` : the probability with which a disc contains the true response.
    ``slope`` : a bound on |dH/domega| between the lines, as a ``SlopeBound`` or as a text that
    ``read_slope`` takes; None where nothing is known between them.
    ``motion`` : translation or rotation, as the units imply; None where none was given.
    ``name`` : what error messages and pages call the response. ``path`` : its file, if any.

    Rows may be given as lists; they are kept as arrays that cannot be written to.
    """

    omega: Any
    H: Any
    coherence: Any = None
    averages: float | None = None
    confidence: float = CONFIDENCE
    radius: Any = None
    motion: MotionKind | None = None
    name: str = "measured"
    path: Path | None = None
    welch: Welch | None = None
    """How the response was estimated, where it comes from records in time; else None."""
    slope: Any = None
    understood: str = ""
    """How its file was read, for a page: ``10 lines; Hz, dB, deg; sorted``."""
    in_hertz: bool = False
    """Whether its frequencies were given in Hz."""

    def __post_init__(self) -> None:
        try:
            self._check()
        except SceneError as error:
            raise error.within(self.name) from None

    def _check(self) -> None:
        """Put arrays and a SlopeBound in place of what was given; SceneError where it is wrong."""
        kinds = ("omega", float), ("H", complex), ("coherence", float), ("radius", float)
        for key, kind in kinds:
            given = getattr(self, key)
            if given is not None or key in ("omega", "H"):
                self._put(key, one_row(key, given, kind))
        for key in ("H", "coherence", "radius"):
            if (row := getattr(self, key)) is not None and len(row) != len(self.omega):
                raise SceneError(
                    f"{key} has {len(row)} values, and omega {len(self.omega)}: give as many"
                )
        if not len(self.omega):
            raise SceneError("there are no frequency points")
        check_certainty(
            self.coherence is not None, self.radius is not None, self.averages, self.confidence
        )
        check_lines(self.omega, self.H, self.coherence, self.radius, lambda i: f"line {i + 1}")
        # Above 1 by a rounding, or it would have been refused.
        if self.coherence is not None and (self.coherence > 1).any():
            self._put("coherence", one_row("coherence", np.minimum(self.coherence, 1.0), float))
        if self.slope is not None and not isinstance(self.slope, SlopeBound):
            self._put("slope", read_slope(self.slope))
        if self.slope and self.motion and self.slope.motion not in (None, self.motion):
            raise SceneError(
                "slope: translation and rotation cannot be mixed: use the unit of the response"
            )

    def _put(self, key: str, value: Any) -> None:
        """Set a field while the frozen value is being made."""
        object.__setattr__(self, key, value)

    def _line(self) -> str:
        low, high = float(self.omega[0]), float(self.omega[-1])
        return f"{self.name}: {counted(len(self.omega), 'line')} from {low:.5g} to {high:.5g} rad/s"

    def __len__(self) -> int:
        return len(self.omega)

    @property
    def files(self) -> tuple[Path, ...]:
        """The file that it was read from, if any."""
        return (self.path,) if self.path else ()

    @cached_property
    def discs(self) -> Reals | None:
        """The radius of each line's disc, in the unit of H, infinite where the disc is the whole
        plane; None where neither coherence nor radius is given. It cannot be written to."""
        if self.coherence is None:
            given: Reals | None = self.radius
            return given
        assert self.averages is not None
        size = np.abs(self.H)
        # Where coherence and H are both 0, 0 times infinity would be nan: the disc is the plane.
        with np.errstate(invalid="ignore"):
            relative = disc_radius(self.coherence, self.averages, self.confidence)
            radii = np.where(np.isinf(relative), np.inf, size * relative)
        radii.setflags(write=False)
        return radii

    def to_csv(self, path: str | Path) -> Path:
        """Write the lines as a file that ``measured`` and a scene's ``file`` read back, every digit
        of every float.

        Averages and confidence of the discs, and the slope, are comments before the header, and are
        read back too. Return the path.
        """
        stated: dict[str, Any] = {}
        if self.discs is not None:
            stated = {"averages": self.averages, "confidence": self.confidence}
        if self.slope is not None:
            stated["slope"] = self.slope.text
        columns = {"omega": self.omega, "real": self.H.real, "imag": self.H.imag}
        for key in ("coherence", "radius"):
            if getattr(self, key) is not None:
                columns[key] = getattr(self, key)
        unit = "" if self.motion is None else Dimension.STIFFNESS.unit(self.motion)
        units = {"omega": "rad/s", "coherence": "1"}
        rows = zip(*(x.tolist() for x in columns.values()), strict=True)
        lines = [
            *(f"# haptisym: {key} = {x}" for key, x in stated.items() if x is not None),
            ",".join(columns),
            ",".join(units.get(key, unit) for key in columns),
            *(",".join(map(repr, x)) for x in rows),
        ]
        write_whole(path, "\n".join(lines) + "\n")
        return Path(path)

    def on_band(self, low: float, high: float) -> Measurement:
        """The measurement with the lines from ``low`` to ``high``, rad/s, alone; SceneError if
        there are none."""
        if high <= low:
            raise SceneError(
                f"band: the high end, {high:.6g} rad/s, must be above the low end, {low:.6g} rad/s"
            )
        is_above = self.omega >= low * (1 - _BAND_EXCESS)
        inside = is_above & (self.omega <= high * (1 + _BAND_EXCESS))
        if not inside.any():
            raise SceneError(
                f"band: {self.name} has no frequency point from {low:.6g} to {high:.6g} rad/s"
            )
        return self.at(inside)

    def at(self, lines: NDArray[Any]) -> Measurement:
        """The measurement with some of its lines alone: ``lines`` is a mask, or the indices of
        those that are kept."""
        coherence, radius = (None if x is None else x[lines] for x in (self.coherence, self.radius))
        return replace(
            self, omega=self.omega[lines], H=self.H[lines], coherence=coherence, radius=radius
        )


def one_row(key: str, given: Any, kind: type) -> Any:
    """Return numbers as an array of one axis that cannot be written to; SceneError, beginning with
    the ``key``, for anything else. ``kind`` : float or complex."""
    # NumPy would drop an imaginary part with a warning only.
    try:
        if kind is float and np.iscomplexobj(given):
            raise SceneError(f"{key}: must be real")
        row: Any = np.array(given, dtype=kind)
    except SceneError:
        raise
    except (TypeError, ValueError):
        raise SceneError(f"{key}: must be a list or an array of numbers") from None
    if row.ndim != 1:
        raise SceneError(f"{key}: has the shape {row.shape}, and must be one row")
    # A copy, and read-only: what was checked once stays valid.
    row.setflags(write=False)
    return row


def check_certainty(
    coherence: bool,  # noqa: FBT001
    radius: bool,  # noqa: FBT001
    averages: float | None,
    confidence: float,
) -> None:
    """Raise SceneError unless the discs are given in one way or in none: by a coherence with the
    number of averages, or by a radius. ``coherence``, ``radius`` : whether that row is given."""
    if not isinstance(confidence, Real) or isinstance(confidence, bool) or not 0 < confidence < 1:
        raise SceneError(f"confidence: {confidence} must lie between 0 and 1")
    if coherence and radius:
        raise SceneError(
            "coherence and radius both give the size of the discs: leave out one of them"
        )
    if averages is None:
        if coherence:
            raise SceneError(
                "averages is missing: coherence needs the number of spectra that were averaged (the "
                "analyser has it; of a record, its length over that of a segment): add ",
                Setting("averages", 10),
            )
        return
    if not coherence:
        raise SceneError("averages needs the column coherence: add it, or leave averages out")
    if (
        not isinstance(averages, Real)
        or isinstance(averages, bool)
        or not (isfinite(averages) and averages >= 2)
    ):
        raise SceneError(f"averages: {averages} must be a number, at least 2")


def check_lines(
    omega: Reals, H: Complexes, coherence: Reals | None, radius: Reals | None, place: LineName
) -> None:
    """Raise SceneError, with the name of the first line that is wrong, unless frequencies rise
    strictly and all numbers are finite and in range. A radius may be infinite. ``place`` : names a
    line by its index."""
    rules: list[tuple[str, Any, Callable[[Any], Any], str]] = [
        (
            "omega",
            omega,
            lambda x: np.isfinite(x) & (x >= 0),
            "must be a finite frequency, 0 or above",
        ),
        ("H", H, np.isfinite, "must be finite"),
        (
            "coherence",
            coherence,
            lambda x: (x >= 0) & (x <= 1 + _COHERENCE_EXCESS),
            "must lie from 0 to 1",
        ),
        ("radius", radius, lambda x: x >= 0, "must be 0 or above"),
    ]
    # Of a mask ``argmin`` is the index of the first False. A comparison with nan is False, so that
    # nan breaks every rule.
    for key, row, rule, words in rules:
        if row is not None and not (is_right := rule(row)).all():
            first = int(np.argmin(is_right))
            raise SceneError(f"{place(first)}: {key}: {row[first]:.6g} {words}")
    is_rising = np.diff(omega) > 0
    if not is_rising.all():
        i = int(np.argmin(is_rising)) + 1  # the line after the step that does not rise
        low, high = omega[i - 1], omega[i]
        what = (
            "is there twice: keep one" if low == high else f"follows {low:.10g}: sort by frequency"
        )
        raise SceneError(f"{place(i)}: the frequency {high:.10g} rad/s {what}")


def disc_radius(coherence: ArrayLike, averages: float, confidence: float = CONFIDENCE) -> Reals:
    """The radius of the confidence disc of an estimate H1 (``Estimator``), relative to ``|H|``.

    sqrt(2/(n-2) F(2, n-2; confidence) (1-g2)/g2), with n = 2 averages and F(2, n-2; p) the quantile
    of the F distribution with 2 and n - 2 degrees of freedom, which is (n-2)/2 ((1-p)^(-2/(n-2)) -
    1). ``coherence`` : g2, 0 to 1; at 0 the radius is infinite. ``averages`` : of independent
    segments, at least 2.
    A coherence has all its digits right: 1 gives 0. Of other estimates (``Estimator``) give radii.
    Source: Bendat and Piersol, Random Data, on the errors of frequency response estimates.

    >>> print(f"{disc_radius(0.95, 10):.7f} {disc_radius(0.99, 10):.8f} {disc_radius(0.95, 20):.8f}")
    0.1441766 0.06316171 0.09480726
    """
    g2 = np.asarray(coherence, dtype=float)
    with np.errstate(divide="ignore"):
        noise = (1 - g2) / g2
    radius: Reals = np.sqrt(spread_of(averages, confidence) * noise)
    return radius


def coherence_for(radius: ArrayLike, averages: ArrayLike, confidence: float = CONFIDENCE) -> Reals:
    """The least coherence at which a disc is no larger than ``radius``, relative to ``|H|``: the
    inverse of ``disc_radius``, g2 = q/(q + radius^2) with q of ``spread_of``.

    >>> print(f"{coherence_for(0.1, 10):.7f}")
    0.9753056
    """
    spread = spread_of(averages, confidence)
    coherence: Reals = np.asarray(spread / (spread + np.square(radius)))
    return coherence


def averages_for(radius: ArrayLike, coherence: ArrayLike, confidence: float = CONFIDENCE) -> Reals:
    """The least whole number of averages with which a disc is no larger than ``radius``, relative
    to ``|H|``: the inverse of ``disc_radius``, at least 2.

    Infinite where no number is enough; nan where infinity times 0 leaves it open, for an infinite
    radius with a coherence of 0, and a radius of 0 with a coherence of 1.

    >>> int(averages_for(0.1, 0.95)), float(disc_radius(0.95, 18)) > 0.1 >= float(disc_radius(0.95, 19))
    (19, True)
    """
    g2 = np.asarray(coherence, dtype=float)
    with np.errstate(divide="ignore", invalid="ignore"):
        # (1-confidence)^(-1/(averages-1)) - 1 <= radius^2 g2/(1-g2), solved for the averages.
        reach = np.log1p(np.square(radius) * g2 / (1 - g2))
        averages: Reals = np.maximum(2.0, 1 + np.ceil(-np.log1p(-confidence) / reach))
    return averages


def spread_of(averages: ArrayLike, confidence: float) -> Any:
    """Return q = 2/(n-2) F(2, n-2; confidence) with n = 2 averages: the square of a disc's relative
    radius is q (1-g2)/g2 (``disc_radius``)."""
    # The quantile's closed form gives (1-confidence)^(-2/(n-2)) - 1, here in logarithms, which keep
    # all digits for many averages.
    return np.expm1(-np.log1p(-confidence) / (np.asarray(averages, dtype=float) - 1))


@dataclass(frozen=True, slots=True)
class SlopeBound:
    """A bound on the slope of the true response: ``|dH/domega| <= bound``, in N s/m or N m s/rad,
    or, where ``relative``, ``|dH/domega| <= bound |H|``, in s.

    ``text`` : the bound as it was stated. ``motion`` : translation or rotation, as its unit
    implies; None for a relative bound, whose unit fits both.

    >>> read_slope("250 N/m/Hz").bound, read_slope("20 ms").relative
    (39.78873577297384, True)
    """

    bound: float
    relative: bool
    text: str
    motion: MotionKind | None = None

    @property
    def unit(self) -> str:
        """The SI unit of the bound."""
        return (
            "s" if self.relative else Dimension.DAMPING.unit(self.motion or MotionKind.TRANSLATION)
        )

    def grown(self, size: Any, radius: Any, apart: Any) -> Any:
        """Return the radius of a disc, around the value of a line, that contains the true response
        ``apart`` rad/s away from the line, if the line's disc contains it at the line.

        ``size`` : ``|H|`` of the line; ``radius`` : of its disc. The result is radius + bound
        apart; with a relative bound radius + (size + radius) (exp(bound apart) - 1): by Gronwall's
        inequality the true ``|H|``, at most size + radius at the line, grows no faster than
        exp(bound apart). Rounded up.
        """
        change = self.bound * apart * _ROUND_UP
        if not self.relative:
            return (radius + change) * _ROUND_UP
        # Overflow gives an infinite radius, which is true: far from the line nothing is known.
        # Infinity times 0 is no number: an infinite disc at the line, or one of radius 0 about 0
        # far away, has not grown.
        with np.errstate(over="ignore", invalid="ignore"):
            growth = np.nan_to_num((size + radius) * np.expm1(change), nan=0.0, posinf=np.inf)
        return (radius + growth) * _ROUND_UP

    def nearest(self, sizes: tuple[Any, Any], apart: Any) -> Any:
        """Return the distance after the first of two lines, rad/s, at which the sum of both radii,
        as ``grown``, is least. ``sizes`` : ``|H|`` + radius of each line; ``apart`` : the distance
        of the lines, rad/s."""
        # At a distance x the sum is s1 exp(b x) + s2 exp(b (d - x)) and a constant, with the bound
        # b and d = ``apart``. It is least at x = d/2 + log(s2/s1)/(2 b), or at the end of [0, d]
        # next to it. An absolute bound gives the same sum everywhere.
        if not self.relative or not self.bound:
            return np.zeros_like(apart)
        with np.errstate(divide="ignore", invalid="ignore"):
            distance = apart / 2 + np.log(sizes[1] / sizes[0]) / (2 * self.bound)
        # nan where both sizes are 0 or infinite: the sum is the same everywhere, and 0 will do.
        return np.clip(np.nan_to_num(distance), 0, apart)


def read_slope(given: Number) -> SlopeBound:
    """Read a bound on the slope from its text; SceneError for a bare number, whose meaning would be
    open, and for a unit that is neither a damping's nor a time's."""
    if not isinstance(given, str) or not any(x.isalpha() for x in given):
        raise SceneError(f"slope: {quoted(given)} has no unit: {_SLOPE_EXAMPLES}")
    for dimension in (Dimension.DAMPING, Dimension.TIME):
        try:
            read = number(given, dimension)
        except SceneError:
            continue
        if read.value < 0:
            raise SceneError(f"slope: {quoted(given)} must be >= 0")
        return SlopeBound(float(read.value), dimension is Dimension.TIME, given, read.motion)
    raise SceneError(f"slope: {quoted(given)} is no bound of a slope: {_SLOPE_EXAMPLES}")


class Estimator(Enum):
    """The estimator of a response from spectra.

    H1: the cross spectrum of motion and force over that of motion; H2: the spectrum of force over
    the cross spectrum of force and motion; joint: the cross spectrum of a reference with force over
    that with motion.
    """

    H1 = "H1"
    H2 = "H2"
    JOINT = "joint"


@dataclass(frozen=True)
class Welch:
    """How spectra were estimated by Welch's method: the mean over ``segments`` that overlap.

    ``samples`` : in the records. ``rate`` : samples a second. ``length`` : samples of a segment.
    ``shift`` : samples from the start of a segment to that of the next.
    ``averages`` : the number of independent segments whose mean would have the same variance.
    ``every`` : of so many neighbouring lines one is kept.
    ``cube`` : a test of linearity (``estimating.cube``), the share of the cube of the predicted
    force in the measured one, divided by its standard error; below 0 where the force grows less
    than in proportion, None where that was not tested.
    """

    estimator: Estimator
    samples: int
    rate: float
    window: str
    length: int
    shift: int
    segments: int
    averages: float
    every: int
    cube: float | None = None

    @property
    def cube_chance(self) -> float | None:
        """The p-value of ``cube``: the probability of a share of so many standard errors or more,
        of either sign, if the display is linear; None where that was not tested."""
        return None if self.cube is None else erfc(abs(self.cube) / sqrt(2))

    @property
    def words(self) -> str:
        """All settings in a sentence, for a page."""
        kept = "every frequency" if self.every == 1 else f"one frequency of {self.every}"
        overlap = f"{100 * (1 - self.shift / self.length):.3g} %"
        return (
            f"{self.estimator.value} by Welch's method: {self.samples} samples at "
            f"{self.rate:.6g} Hz, {self.segments} "
            f"segments of {self.length} samples ({self.length / self.rate:.4g} s), window "
            f"{self.window}, overlap "
            f"{overlap}, mean removed; {self.averages:.4g} effective averages; {kept}"
        )

    def row(self) -> dict[str, Any]:
        """The settings as JSON documents have them."""
        return {
            "estimator": self.estimator.value,
            "samples": self.samples,
            "rate_hz": self.rate,
            "window": self.window,
            "segment": self.length,
            "shift": self.shift,
            "segments": self.segments,
            "averages": self.averages,
            "every": self.every,
            "cube": self.cube,
            "cube_probability": self.cube_chance,
        }
