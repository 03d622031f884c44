"""A model fitted to a measured response, with what the lines tell of it, and the scene file that it
makes.

Whether the model holds is told by its residuals: their chi^2, the correlation of one line's with
the next one's, and, of records, a force that follows the cube of what is predicted. Between which
values each parameter lies is told by the curvature; the box that holds all of them together is
Bonferroni's.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from decimal import ROUND_CEILING, ROUND_FLOOR, Context
from functools import cached_property
from math import erfc, floor, log10, sqrt
from pathlib import Path
from statistics import NormalDist
from typing import Any, ClassVar

import numpy as np
from sympy import Expr, Rational, pi

from haptisym.judge.answers import Answer
from haptisym.kernel.budget import SECONDS, limited
from haptisym.kernel.errors import SceneError
from haptisym.kernel.objects import counted, titled
from haptisym.model.catalogue import ENVIRONMENTS, Environment
from haptisym.model.jnd import Part, Shape, Threshold
from haptisym.model.measured import Complexes, Measurement
from haptisym.model.measuredscene import MeasuredScene
from haptisym.model.measuring import measured
from haptisym.model.parameters import Parameter, Rule
from haptisym.model.quantities import Dimension, MotionKind, Number
from haptisym.model.scene import Scene, frequency
from haptisym.model.scenefile import open_scenes, parse_scene
from haptisym.model.shipped import bench_names, family_names, scene_names
from haptisym.verbs.identify.fitting import (
    Degrees,
    Fit,
    Free,
    Table,
    Wanted,
    filled,
    fit,
    wanted,
    with_others,
)


def scene_text(
    title: str, source: str, remarks: Iterable[str], tables: Sequence[tuple[str, Table]]
) -> str:
    """A scene file. ``remarks`` : comments at its head. ``tables`` : each with its heading, as
    ``[environment]``.

    >>> print(scene_text("Wall", "", ["fitted"], [("[environment]", {"model": "kelvin-voigt", "k": ["1 N/m", "3 N/m"]})]))
    # fitted
    title = "Wall"
    <BLANKLINE>
    [environment]
    model = "kelvin-voigt"
    k = ["1 N/m", "3 N/m"]
    <BLANKLINE>
    """
    head = [
        *(f"# {x}" for x in remarks),
        f"title = {_value(title)}",
        *([f"source = {_value(source)}"] if source else []),
    ]
    for heading, table in tables:
        head += ["", heading, *(f"{key} = {_value(x)}" for key, x in table.items())]
    return "\n".join(head) + "\n"


def _value(given: Any) -> str:
    if isinstance(given, str):
        return json.dumps(given, ensure_ascii=False).replace(
            "\x7f", "\\u007f"
        )  # which TOML reads as JSON does
    if isinstance(given, Mapping):
        return f"{{ {', '.join(f'{key} = {_value(x)}' for key, x in given.items())} }}"
    return f"[{', '.join(map(_value, given))}]" if isinstance(given, list | tuple) else str(given)


def environment_table(own: Environment) -> Table:
    """The table of an environment whose parameters are numbers."""
    slots = ENVIRONMENTS[own.model].slots
    table: dict[str, Any] = {"model": own.model}
    table |= {key: str(own.dynamics) for key, x in slots.items() if x.formula}
    for p in own.parameters:
        key = p.key.partition("[")[0]
        if key not in slots:
            table.setdefault("parameters", {})[p.key] = _quantity(p)
        elif slots[key].several:
            table.setdefault(key, []).append(_quantity(p))
        else:
            table[key] = _quantity(p)
    return table


def _quantity(p: Parameter) -> Any:
    low, high = p.interval or (p.value, p.value)
    unit = p.unit_in(p.motion) if p.motion or p.exponents else ""
    told = [exactly(x, p.dimension, unit) for x in (low, p.value, high)]
    return told if p.interval else told[1]


def exactly(value: Expr, dimension: Dimension, unit: str) -> str:
    """An exact number as a scene file has it, in Hz where it is a frequency that has pi in it."""
    if dimension is Dimension.FREQUENCY:
        turns = value / (2 * pi)
        return f"{turns} Hz" if turns.is_Rational else f"{value} rad/s"
    number = str(value) if isinstance(value, Rational) else repr(float(value))
    return f"{number} {unit}".rstrip()


def threshold_value(c: Threshold) -> Any:
    """What a scene file says of a threshold: its key ``jnd``."""
    if c.source:
        return {"like": c.source}
    own = c.region
    if own.corners:
        return {
            "shape": own.shape.value,
            "corners": [[str(x), str(y)] for x, y in own.corners],
            **_taken(c),
        }
    table: dict[str, Any] = {} if own.shape is Shape.SQUARE else {"shape": own.shape.value}
    table |= {part.value: _limit(c, part) for part in Part} | (
        {"tilt": str(own.tilt)} if own.tilt else {}
    )
    if own.floor is not None:
        table["floor"] = str(own.floor)
    return table | _taken(c)


def _taken(c: Threshold) -> dict[str, Any]:
    return {} if c.proportion is None else {"proportion": str(c.proportion)}


def _limit(c: Threshold, part: Part) -> Any:
    interval, lower = c.interval(part), c.lower(part)
    if c[part].is_number and not c[part].is_Rational:
        raise SceneError(
            f"jnd: {c[part]} cannot be written in a scene file: give a rational number"
        )
    if lower is not None:
        return {"higher": str(c[part]), "lower": str(lower)}
    return (
        str(c[part]) if interval is None else [str(x) for x in (interval[0], c[part], interval[1])]
    )


def band_value(low: float, high: float) -> list[str]:
    """What a scene file says of a band that ends at floats: in Hz where that has fewer digits, as
    in the file of the lines.

    Twelve digits are enough: ``Measurement.on_band`` allows for files that round more.
    """
    return [
        min(f"{x:.12g} rad/s", f"{x / (2 * np.pi):.12g} Hz", key=lambda text: len(text.split()[0]))
        for x in (low, high)
    ]


_EXACT = 1e-9  # of the largest response
_LEAST_LINES = 8
"""For a test of neighbours."""


@dataclass(frozen=True)
class FitVerdict:
    """What the residuals tell of a model.

    ``square`` : their chi^2, None where no disc is known; ``chance`` : of one that large where the
    model holds. ``neighbours`` :
    correlation of the residuals of neighbouring lines; ``neighbours_chance`` : of one that large.
    ``cube_chance`` : of records, of a force that follows the cube of what is predicted so much.
    ``fits`` : False where one of these is less likely than its part of what the confidence leaves;
    None where no disc is known and the others tell nothing.
    """

    square: float | None
    freedom: int
    chance: float | None
    neighbours: float | None
    neighbours_chance: float | None
    cube_chance: float | None
    fits: bool | None


def verdict(found: Fit) -> FitVerdict:
    """Are the residuals as large as the discs say, is one line's residual independent of the next
    one's, are records linear?"""
    from scipy.special import gammaincc

    known, welch = found.noise.freedom is not None, found.lines.welch
    square = float(found.noise.squares(found.residuals).sum()) if known else None
    chance = (
        None
        if square is None or not found.freedom
        else float(gammaincc(found.freedom / 2, square / 2))
    )
    # residuals that are no more than where least squares end tell nothing of the model
    is_exact = bool(
        np.abs(found.model - found.lines.H).max() <= _EXACT * np.abs(found.lines.H).max()
    )
    together = None if is_exact else _neighbours(even(found))
    by_chance = None if together is None else erfc(together * sqrt(len(found.lines) - 1)) / 2
    by_cube = welch.cube_chance if welch else None
    spare = (1 - found.lines.confidence) / (2 if by_cube is None else 3)
    wrong = any(x is not None and x < spare for x in (chance, by_chance, by_cube))
    fits = False if wrong else True if chance is not None else None
    return FitVerdict(square, found.freedom, chance, together, by_chance, by_cube, fits)


def even(found: Fit) -> Complexes:
    """The residuals with their tails brought to those of a normal distribution."""
    size = np.abs(found.residuals)
    with np.errstate(invalid="ignore", divide="ignore"):
        shown = np.where(
            size > 0, found.residuals / size * np.sqrt(found.noise.squares(found.residuals)), 0
        )
    return np.asarray(shown, dtype=complex)


def _neighbours(residuals: Complexes) -> float | None:
    """The correlation of one line's residual with the next one's."""
    size = float(np.square(np.abs(residuals)).mean())
    if len(residuals) < _LEAST_LINES or size == 0:
        return None
    return float((residuals[1:] * np.conj(residuals[:-1])).real.mean() / size)


@dataclass(frozen=True)
class Estimate:
    """A parameter that was found, SI. ``low``, ``high`` : its confidence interval by itself;
    ``least``, ``most`` : its side of the box that holds all parameters together with the
    confidence, at least. ``error`` : standard error."""

    parameter: Free
    value: float
    error: float
    low: float
    high: float
    least: float
    most: float

    @property
    def written(self) -> float:
        """The value to a hundredth of its error, and to three digits at least: no file says more
        than is known."""
        if self.parameter.rule is Rule.FRACTION or not (self.value and 0 < self.error < np.inf):
            return self.value
        last = min(floor(log10(self.error)), floor(log10(abs(self.value))))
        return round(self.value, 2 - last)

    @property
    def told(self) -> bool:
        """Whether the lines tell it well enough for a range to mean anything: a positive one within
        a factor of two."""
        if self.parameter.rule is Rule.POSITIVE:
            return self.most <= 2 * self.value
        return self.parameter.rule is not Rule.FRACTION or self.most - self.least < 0.9


def estimates(found: Fit) -> tuple[Estimate, ...]:
    """Of all parameters; the box is Bonferroni's, each side with its share of what the confidence
    leaves."""
    spare, free = 1 - found.lines.confidence, found.wanted.free
    one, all_of_them = (_reach(found, 1 - spare / (2 * parts)) for parts in (1, len(free)))
    made = []
    for x, value, variance in zip(
        free, found.values.tolist(), np.diag(found.covariance).tolist(), strict=True
    ):
        error = float(np.sqrt(variance))
        made.append(
            Estimate(
                x,
                value,
                error,
                *_ends(x, value, one * error),
                *_ends(x, value, all_of_them * error),
            )
        )
    return tuple(made)


def _reach(found: Fit, share: float) -> float:
    """Standard errors from the middle to that share of the distribution."""
    from scipy.special import stdtrit

    if found.noise.freedom is None:
        return float(stdtrit(max(found.freedom, 1), share))
    return NormalDist().inv_cdf(share)


def _ends(x: Free, value: float, reach: float) -> tuple[float, float]:
    """An interval that keeps the parameter's rule: even in the logarithm where it must be
    positive."""
    if x.rule is Rule.POSITIVE:
        factor = float(np.exp(min(reach / value, 600.0)))
        low, high = value / factor, value * factor
    elif x.rule is Rule.FRACTION:
        step = float(np.exp(min(reach / (value * (1 - value)), 30.0)))
        odds = value / (1 - value)
        low, high = odds / step / (1 + odds / step), odds * step / (1 + odds * step)
    else:
        low, high = value - reach, value + reach
    return rounded(max(low, 0.0) if x.rule is Rule.NONNEGATIVE else low, ROUND_FLOOR), rounded(
        high, ROUND_CEILING
    )


_DIGITS = 6


def rounded(value: float, way: str) -> float:
    """A few digits, outward, so that a range stays one."""
    return float(Context(prec=_DIGITS, rounding=way).create_decimal_from_float(value))


_APART = 1e-6
_LARGE = 0.1
"""Of a value, the error up to which simulated runs find that intervals hold the truth as often as
they say."""


@dataclass(frozen=True)
class MeasuredLines:
    """What was asked about: lines, which have no parameters to vary."""

    title: str

    def asides(
        self, besides: Collection[str] = (), varied: Collection[str] | None = ()
    ) -> list[str]:
        """Nothing."""
        return []

    def aside_keys(
        self, besides: Collection[str] = (), varied: Collection[str] | None = ()
    ) -> dict[str, Any]:
        """Nothing."""
        return {}


@dataclass(frozen=True, eq=False, repr=False)
class Identification(Answer):
    """A model that was fitted to measured lines; estimated, never certified.

    ``measurement`` : what was fitted. ``estimates`` : each free parameter with its confidence
    interval and its side of the box.
    ``verdict`` : whether the model holds, as far as its residuals tell. ``text`` : the scene file
    that it makes.
    """

    _schema: ClassVar[str] = "haptisym.identification/1"
    _page: ClassVar[str] = "haptisym.pages.identify:page"
    settled = True
    _figure: ClassVar[str] = "haptisym.figures.measured:IDENTIFICATION"

    measurement: Measurement
    threshold: Threshold
    title: str
    fit: Fit
    estimates: tuple[Estimate, ...]
    verdict: FitVerdict

    @property
    def _about(self) -> MeasuredLines:
        return MeasuredLines(self.title)

    def _line(self) -> str:
        told = {True: "fits", False: "does NOT fit", None: "untested"}[self.verdict.fits]
        return f"{titled(self.title)}: {counted(len(self.estimates), 'parameter')}, {told}"

    @property
    def certified(self) -> bool:
        """False: what is estimated is not proven."""
        return False

    @property
    def wanted(self) -> Wanted:
        """What was asked for: the model, and which of its values are given."""
        return self.fit.wanted

    @property
    def motion(self) -> MotionKind | None:
        """Whether the hand moves along a line or about an axis; None if no unit tells."""
        return self.measurement.motion

    @cached_property
    def text(self) -> str:
        """The scene file: a range for each parameter, or its value alone where a range would mean
        nothing."""
        by_path = {x.parameter.path: x for x in self.estimates}

        def value(x: Free) -> Any:
            return self._written(by_path[x.path])

        lines, own = self.fit.lines, self.wanted
        evaluation = {
            "band": band_value(float(lines.omega[0]), float(lines.omega[-1])),
            "jnd": threshold_value(self.threshold),
            "confidence": self.fit.lines.confidence,
        }
        tables = [
            ("[environment]", filled(own.environment, value)),
            *(("[[effects]]", filled(x, value)) for x in own.effects),
        ]
        source = f"fitted to {self.measurement.name} by haptisym identify"
        remarks = [
            *self._told(),
            *(f"The same response: {self.moved(x)}." for x in self.fit.others or ()),
        ]
        return scene_text(self.title, source, remarks, [*tables, ("[evaluation]", evaluation)])

    @property
    def has_ranges(self) -> bool:
        """Whether parameters are written as ranges: the model was not refuted, and the lines tell
        every parameter."""
        return self.verdict.fits is not False and all(x.told for x in self.estimates)

    @property
    def confidence_words(self) -> str:
        """Of the box. Intervals of the curvature hold less than they say where errors are large, as
        simulated runs tell.

        Of lines that were estimated from records neither the leakage of the window nor the bias of
        loud lines is in them:
        simulated loops of a mass of 0.8 kg, a damper and a spring held the truth in 41 to 89 of 90
        intervals of 95 %.
        """
        share = f"{100 * self.fit.lines.confidence:g} %"
        which = (
            ", unless the true values are those of another answer with the same response"
            if self.fit.others
            else ""
        )
        if self.fit.lines.welch is not None:
            return (
                f"at most {share}, as records leak and loud ones have a bias: the ranges are too "
                f"narrow{which}"
            )
        large = any(x.error > _LARGE * abs(x.value) for x in self.estimates)
        less = ", some percent less as an error is above a tenth of its value" if large else ""
        return f"about {share}{less}{which}"

    def _written(self, x: Estimate) -> Any:
        motion, dimension = self.motion, x.parameter.dimension
        plain = dimension in (Dimension.ANY, Dimension.RATIO) or (
            motion is None and len(set(dimension.value)) > 1
        )
        unit = "" if plain else f" {dimension.unit(motion)}"
        return (
            [f"{end!r}{unit}" for end in (x.least, x.written, x.most)]
            if self.has_ranges
            else f"{x.written!r}{unit}"
        )

    def moved(self, other: Any) -> str:
        """What is another value in another answer with the same response: paths, values and
        units."""
        pairs = [
            (x, v)
            for x, v in zip(self.estimates, other, strict=True)
            if x.parameter.path in self.ambiguous
        ]
        return ", ".join(
            f"{x.parameter.path} = {v:.6g} {'' if (u := self.unit(x)) == '1' else u}".strip()
            for x, v in pairs
        )

    def _told(self) -> list[str]:
        if self.verdict.fits is False:
            return [
                (
                    "This model does NOT fit what was measured: its parameters are those nearest "
                    "to it, and have no ranges."
                )
            ]
        if not self.has_ranges:
            paths = ", ".join(x.parameter.path for x in self.estimates if not x.told)
            return [
                (
                    f"The data do not identify {paths}: no parameter has a range. Leave that "
                    f"out, or give a value."
                )
            ]
        start = (
            f"Ranges: together they hold the true values with a confidence of "
            f"{self.confidence_words}, if the model is right"
        )
        if self.verdict.fits is None:
            return [f"{start},", "which was not tested: no discs of the lines are known."]
        return [
            f"{start}",
            "and the errors are as the discs say. No test of the residuals spoke against it.",
        ]

    @cached_property
    def scene(self) -> Scene:
        """The scene that the file makes."""
        return parse_scene(self.text, "the scene that was identified")

    def _body(self) -> dict[str, Any]:
        lines, found = self.fit.lines, self.verdict
        return {
            "measurement": self.measurement.name,
            **({} if lines.welch is None else {"estimate": lines.welch.row()}),
            "lines": len(lines),
            "left_out": len(self.measurement) - len(lines),
            "model": self.wanted.words,
            "confidence": lines.confidence,
            "fits": found.fits,
            "chi_square": found.square,
            "degrees_of_freedom": found.freedom,
            "probability": found.chance,
            "neighbours": found.neighbours,
            "neighbours_probability": found.neighbours_chance,
            "starts": self.fit.starts,
            "agreeing": self.fit.agreeing,
            "others": None
            if self.fit.others is None
            else [self._named(x) for x in self.fit.others],
            "parameters": [self._row(x) for x in self.estimates],
            "correlation": correlation(self.fit).tolist(),
            "rows": [
                {"omega": w, "model": [h.real, h.imag], "residual": [r.real, r.imag]}
                for w, h, r in zip(
                    lines.omega.tolist(),
                    self.fit.model.tolist(),
                    self.fit.residuals.tolist(),
                    strict=True,
                )
            ],
            "scene": self.text,
            "certified": self.certified,
        }

    def _named(self, values: Any) -> dict[str, float]:
        return {x.path: float(value) for x, value in zip(self.wanted.free, values, strict=True)}

    @property
    def ambiguous(self) -> tuple[str, ...]:
        """The paths of the parameters that are others in another answer with the same response."""
        own = self.fit.values
        others = np.array(self.fit.others or [own])
        moved = np.any(np.abs(others - own) > _APART * np.abs(own), axis=0)
        return tuple(
            x.path for x, is_moved in zip(self.wanted.free, moved, strict=True) if is_moved
        )

    def _row(self, x: Estimate) -> dict[str, Any]:
        numbers = {
            "value": x.value,
            "error": x.error,
            "interval": [x.low, x.high],
            "box": [x.least, x.most],
        }
        return {"path": x.parameter.path, **numbers, "unit": self.unit(x), "told": x.told}

    def unit(self, x: Estimate) -> str:
        """The unit of a parameter; empty where its dimension is not known."""
        return x.parameter.dimension.unit(self.motion or MotionKind.TRANSLATION)


def correlation(found: Fit) -> Any:
    """Of the estimates."""
    errors = np.sqrt(np.diag(found.covariance))
    return found.covariance / np.outer(errors, errors)


def identify(
    response: Measurement | MeasuredScene | str | Path,
    environment: str | None = None,
    effects: Sequence[str] = (),
    *,
    degrees: Degrees | None = None,
    band: tuple[Number, Number] | None = None,
    averages: float | None = None,
    confidence: float | None = None,
    title: str = "",
    limit: float | None = SECONDS,
) -> Identification:
    """Fit a model to a measured response, by least squares weighted with its discs. Estimated, not
    proven.

    ``response`` : what was measured, or the file of it; or a scene with ``[perceived]``, of which
    what should be felt is known and the effects are fitted. ``environment``, ``effects`` : models
    of the catalogue, ``"shunt:m"`` with some parameters alone,
    ``"second-order-lowpass:zeta=0.5"`` with a given value. ``degrees`` : of a numerator and
    denominator, in place of a model.
    ``band`` : only lines on it. ``averages``, ``confidence`` : of a file's. ``limit`` : seconds of
    processor time that it may take, LimitError after them; None for none. SceneError for what
    cannot be fitted.

    >>> import haptisym as hs
    >>> felt = hs.sampled("fu2019", [2, 4, 6, 8, 10, 12])
    >>> found = identify(felt, "mass-spring-damper", ["second-order-lowpass"])
    >>> [(x.parameter.name, round(x.value, 6)) for x in found.estimates]
    [('m', 1.8), ('b', 15.0), ('k', 100.0), ('omega_n', 80.0), ('zeta', 0.5)]
    """
    given = opened(response, averages, confidence)
    felt, known, threshold, name = given, None, Threshold(), title
    if isinstance(given, MeasuredScene):
        felt, threshold, name = given.perceived, given.threshold, title or given.title
        if not isinstance(given.environment, Environment):
            raise SceneError(
                "environment and perceived are both measured: give the file of the one to fit"
            )
        known = (given.environment, environment_table(given.environment))
        band = band or given.band
    assert isinstance(felt, Measurement)
    asked = wanted(
        environment, [effects] if isinstance(effects, str) else list(effects), degrees, known
    )
    lines = felt if band is None else felt.on_band(*(float(frequency("band", x)) for x in band))
    with limited(limit):
        found = with_others(fit(asked, lines))
    name = name or f"{asked.words}, as measured"
    motion = felt.motion or (given.motion if isinstance(given, MeasuredScene) else None)
    return Identification(
        replace(felt, motion=motion), threshold, name, found, estimates(found), verdict(found)
    )


def opened(
    given: Measurement | MeasuredScene | str | Path,
    averages: float | None = None,
    confidence: float | None = None,
    *,
    files: bool = True,
    **records: Any,
) -> Measurement | MeasuredScene:
    """What was measured, from wherever it is; ``files`` : whether those that a scene names are
    read."""
    certainty: dict[str, Any] = records | {
        key: x for key, x in (("averages", averages), ("confidence", confidence)) if x is not None
    }
    if (
        isinstance(given, str | Path)
        and Path(given).suffix != ".toml"
        and str(given) not in bench_names()
    ):
        if str(given) in (*scene_names(), *family_names()) and not Path(given).exists():
            raise SceneError(
                f"{given}: this shipped scene has formulas, no measured response; "
                f"{_runs(str(given))}"
            )
        return measured(given, **certainty)
    if certainty:
        raise SceneError(
            f"{next(iter(certainty))}: is for a file of frequency points: leave it out, as "
            f"scene and response have their own"
        )
    if isinstance(given, str | Path):
        opened, name = open_scenes(given, files=files)
        if not isinstance(opened, MeasuredScene):
            raise SceneError(
                f"{name}: this scene has formulas, no measured response: give a file, or a "
                f"scene with [perceived]"
            )
        return opened
    if not isinstance(given, Measurement | MeasuredScene):
        raise SceneError(
            f"{type(given).__name__} is no measured response: give a file, measured(omega, "
            f"H) or a MeasuredScene"
        )
    return given


def _runs(name: str) -> str:
    """Which simulated bench run is meant, perhaps."""
    own = f"{name}-bench"
    if own in bench_names():
        return f"its simulated bench run is {own}"
    return f"simulated bench runs are {', '.join(bench_names())}"
