"""Identification: a model fitted to a measured response, and the scene file that it makes.

Whether the model holds is judged by its residuals r, measured less model in units of sigma
(``verdict``): the sum of |r|^2 against chi^2, the correlation of neighbouring residuals, and, of
records, a force that follows the cube of what is predicted. The interval of each parameter follows
from the curvature of the sum of squares; the box that holds all parameters together with the
confidence, at least, is Bonferroni's (``estimates``). Read from ``identify``.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from decimal import ROUND_CEILING, ROUND_FLOOR, Context
from functools import cached_property
from math import erfc, floor, log10, sqrt
from pathlib import Path
from statistics import NormalDist
from typing import Any, ClassVar

import numpy as np
from sympy import Expr, Rational, pi

from haptisym.judge.answers import Answer, NoScene
from haptisym.kernel.budget import SECONDS, limited
from haptisym.kernel.errors import SceneError
from haptisym.kernel.objects import counted, titled
from haptisym.model.catalogue import ENVIRONMENTS, Environment
from haptisym.model.jnd import Part, Shape, Threshold
from haptisym.model.measured import Complexes, Measurement
from haptisym.model.measuredscene import MeasuredScene
from haptisym.model.measuring import measured
from haptisym.model.parameters import Parameter, Rule
from haptisym.model.quantities import HERTZ, RADIANS, Dimension, MotionKind, Number, Unit
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
    """Return the text of a scene file. ``remarks`` : comments at its head. ``tables`` : each with
    its heading, as ``[environment]``.

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
    """Return a value as TOML."""
    # Strings are escaped as in JSON, but that TOML has no bare DEL.
    if isinstance(given, str):
        return json.dumps(given, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(given, Mapping):
        return f"{{ {', '.join(f'{key} = {_value(x)}' for key, x in given.items())} }}"
    return f"[{', '.join(map(_value, given))}]" if isinstance(given, list | tuple) else str(given)


def environment_table(own: Environment) -> Table:
    """Return the table of an environment whose parameters are numbers, as a scene file has it."""
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
    """Return a parameter as a scene file has it: one text, or three for a range."""
    low, high = p.interval or (p.value, p.value)
    unit = p.unit_in(p.motion) if p.motion or p.exponents else ""
    texts = [exactly(x, p.dimension, unit) for x in (low, p.value, high)]
    return texts if p.interval else texts[1]


def exactly(value: Expr, dimension: Dimension, unit: str) -> str:
    """Return an exact number as a scene file has it: in Hz where it is a frequency with pi in
    it."""
    if dimension is Dimension.FREQUENCY:
        # A scene file has no pi: a frequency that was given in Hz is a rational number of turns
        # again.
        turns = value / (2 * pi)
        return f"{turns} Hz" if turns.is_Rational else f"{value} rad/s"
    number = str(value) if isinstance(value, Rational) else repr(float(value))
    return f"{number} {unit}".rstrip()


def threshold_value(c: Threshold) -> Any:
    """Return the value of the key ``jnd`` of a scene file for a threshold."""
    if c.source:
        return {"like": c.source}
    region = c.region
    if region.corners:
        return {
            "shape": region.shape.value,
            "corners": [[str(x), str(y)] for x, y in region.corners],
            **_taken(c),
        }
    table: dict[str, Any] = {} if region.shape is Shape.SQUARE else {"shape": region.shape.value}
    table |= {part.value: _limit(c, part) for part in Part}
    if region.tilt:
        table["tilt"] = str(region.tilt)
    if region.floor is not None:
        table["floor"] = str(region.floor)
    return table | _taken(c)


def _taken(c: Threshold) -> dict[str, Any]:
    """Return the proportion at which a threshold was taken; empty where that is not known."""
    return {} if c.proportion is None else {"proportion": str(c.proportion)}


def _limit(c: Threshold, part: Part) -> Any:
    """Return the limit of one part: a number, a range, or one for each way; SceneError where it is
    irrational, which no text gives exactly."""
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


_BAND = 4
"""Digits of the ends of a band that is written, at the most."""


def band_value(low: float, high: float, *, in_hertz: bool = False) -> list[str]:
    """Return the band of a scene file that holds floats from ``low`` to ``high``, rounded outward:
    in Hz where that has fewer digits, or where the file of the points is ``in_hertz``.

    >>> band_value(1, 20), band_value(1, 20, in_hertz=True)
    (['1 rad/s', '20 rad/s'], ['0.1591 Hz', '3.184 Hz'])
    """
    turns = _outward(low / (2 * np.pi), high / (2 * np.pi), _BAND)
    return [
        f"{hertz} Hz" if in_hertz or len(hertz) < len(radians) else f"{radians} rad/s"
        for hertz, radians in zip(turns, _outward(low, high, _BAND), strict=True)
    ]


def _outward(low: float, high: float, digits: int) -> list[str]:
    """The ends of a range as decimals, rounded outward to so many digits."""
    # Twelve digits first: of 0.2 Hz in rad/s a float gives 0.19999999999999998 Hz back.
    return [
        f"{Context(digits, way).create_decimal(f'{float(x):.12g}').normalize():f}"
        for x, way in ((low, ROUND_FLOOR), (high, ROUND_CEILING))
    ]


_EXACT = 1e-9  # of the largest response
_LEAST_LINES = 8
"""Frequency points that the test of neighbouring residuals needs: with fewer the correlation is far
from normally distributed."""


@dataclass(frozen=True)
class FitVerdict:
    """Whether a model holds, by its residuals.

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
    """Test a fit: whether the residuals are as large as the discs say, whether neighbouring
    residuals are independent, and whether records are linear."""
    from scipy.special import gammaincc

    known, welch = found.noise.freedom is not None, found.lines.welch
    square = float(found.noise.squares(found.residuals).sum()) if known else None
    chance = (
        None
        if square is None or not found.freedom
        else float(gammaincc(found.freedom / 2, square / 2))
    )
    # Residuals this small are where least squares ended: their order says nothing of the model.
    is_exact = bool(
        np.abs(found.model - found.lines.H).max() <= _EXACT * np.abs(found.lines.H).max()
    )
    together = None if is_exact else _neighbours(even(found))
    # Of n independent residuals the correlation of neighbours is about normal with the standard
    # deviation 1/sqrt(2 (n - 1)), as each pair has two parts: erfc(c sqrt(n - 1))/2 is its upper
    # tail.
    by_chance = None if together is None else erfc(together * sqrt(len(found.lines) - 1)) / 2
    by_cube = welch.cube_chance if welch else None
    # Two or three tests share what the confidence leaves, so that a true model fails any of them no
    # more often than that.
    spare = (1 - found.lines.confidence) / (2 if by_cube is None else 3)
    wrong = any(x is not None and x < spare for x in (chance, by_chance, by_cube))
    fits = False if wrong else True if chance is not None else None
    return FitVerdict(square, found.freedom, chance, together, by_chance, by_cube, fits)


def even(found: Fit) -> Complexes:
    """Return the residuals with their sizes carried over to those of a normal distribution."""
    # A sigma that is estimated from few averages makes long tails, and a single large residual
    # would decide the correlation.
    size = np.abs(found.residuals)
    with np.errstate(invalid="ignore", divide="ignore"):
        scaled = found.residuals / size * np.sqrt(found.noise.squares(found.residuals))
        shown = np.where(size > 0, scaled, 0)
    return np.asarray(shown, dtype=complex)


def _neighbours(residuals: Complexes) -> float | None:
    """Return the correlation of neighbouring residuals; None where there are too few, or all are
    0."""
    size = float(np.square(np.abs(residuals)).mean())
    if len(residuals) < _LEAST_LINES or size == 0:
        return None
    return float((residuals[1:] * np.conj(residuals[:-1])).real.mean() / size)


@dataclass(frozen=True)
class Estimate:
    """The estimate of a parameter, SI. ``low``, ``high`` : its confidence interval by itself;
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
        """The value to a hundredth of its error, and to three digits at least: a file gives no
        digits that are not known."""
        return self._to_known(self.value)

    def _to_known(self, value: float, size: float = 1.0) -> float:
        """Round a value in a unit of this size, in SI."""
        error = self.error / size
        if self.parameter.rule is Rule.FRACTION or not (value and 0 < error < np.inf):
            return value
        return round(value, 2 - min(floor(log10(error)), floor(log10(abs(value)))))

    def in_unit(self, size: float) -> tuple[str, str, str]:
        """The low end of the box, the value and the high end in a unit of this size, in SI, as a
        scene file has them: ends outward, to a tenth of their distance at least."""
        low, value, high = (x / size for x in (self.least, self.value, self.most))
        # Two digits more than the range leaves open; a share near 1 would be rounded to it.
        spread = (high - low) / max(abs(low), abs(high), 1e-300)
        digits = _DIGITS
        if spread and self.parameter.rule is not Rule.FRACTION:
            digits = min(_DIGITS, max(2, 2 - floor(log10(spread))))
        least, most = _outward(low, high, digits)
        return least, f"{self._to_known(value, size):.12g}", most

    @property
    def told(self) -> bool:
        """Whether the data determine it well enough for a range to mean anything: a positive one
        within a factor of two."""
        if self.parameter.rule is Rule.POSITIVE:
            return self.most <= 2 * self.value
        return self.parameter.rule is not Rule.FRACTION or self.most - self.least < 0.9


def estimates(found: Fit) -> tuple[Estimate, ...]:
    """Return the estimates of all parameters; the box is Bonferroni's, each side with its share
    of what the confidence leaves."""
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
    """Return the quantile of a standardised estimate: Student's t where the noise is estimated
    from the residuals, else normal."""
    from scipy.special import stdtrit

    if found.noise.freedom is None:
        return float(stdtrit(max(found.freedom, 1), share))
    return NormalDist().inv_cdf(share)


def _ends(x: Free, value: float, reach: float) -> tuple[float, float]:
    """Return the ends of an interval that keeps the parameter's rule: even in the logarithm
    where it must be positive."""
    # The exponents are bounded, so that a parameter the data say nothing of has finite ends.
    if x.rule is Rule.POSITIVE:
        factor = float(np.exp(min(reach / value, 600.0)))
        low, high = value / factor, value * factor
    elif x.rule is Rule.FRACTION:
        # Even in the logarithm of the odds, whose slope is 1/(x (1 - x)): both ends stay in (0, 1).
        step = float(np.exp(min(reach / (value * (1 - value)), 30.0)))
        odds = value / (1 - value)
        low = odds / step / (1 + odds / step)
        high = odds * step / (1 + odds * step)
    else:
        low, high = value - reach, value + reach
    low = max(low, 0.0) if x.rule is Rule.NONNEGATIVE else low
    return rounded(low, ROUND_FLOOR), rounded(high, ROUND_CEILING)


_DIGITS = 6


def rounded(value: float, way: str) -> float:
    """Round to six digits in a way that ``decimal`` names: ends of a range outward, so that it
    holds what it held."""
    return float(Context(prec=_DIGITS, rounding=way).create_decimal_from_float(value))


_APART = 1e-6
_LARGE = 0.1
"""Relative error up to which simulated runs find that intervals hold the truth as often as they
claim."""


@dataclass(frozen=True, eq=False, repr=False)
class Identification(Answer):
    """A model that was fitted to measured lines; estimated, never certified.

    ``measurement`` : what was fitted. ``estimates`` : each free parameter with its confidence
    interval and its side of the box.
    ``verdict`` : whether the residuals are in keeping with the model. ``text`` : the scene file
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
    def _about(self) -> NoScene:
        return NoScene(self.title)

    def _line(self) -> str:
        verdict = {True: "fits", False: "does NOT fit", None: "untested"}[self.verdict.fits]
        return f"{titled(self.title)}: {counted(len(self.estimates), 'parameter')}, {verdict}"

    @property
    def certified(self) -> bool:
        """False: what is estimated is not proven."""
        return False

    @property
    def wanted(self) -> Wanted:
        """The model that was asked for, and which of its values are given."""
        return self.fit.wanted

    @property
    def motion(self) -> MotionKind | None:
        """Whether the hand moves along a line or about an axis; None if no unit shows it."""
        return self.measurement.motion

    @cached_property
    def text(self) -> str:
        """The scene file: a range for each parameter, or its value alone where a range would mean
        nothing."""
        by_path = {x.parameter.path: x for x in self.estimates}

        def value(x: Free) -> Any:
            return self._written(by_path[x.path])

        lines, model = self.fit.lines, self.wanted
        evaluation = {
            "band": band_value(
                float(lines.omega[0]), float(lines.omega[-1]), in_hertz=lines.in_hertz
            ),
            "jnd": threshold_value(self.threshold),
            "confidence": self.fit.lines.confidence,
        }
        tables = [
            ("[environment]", filled(model.environment, value)),
            *(("[[effects]]", filled(x, value)) for x in model.effects),
        ]
        source = f"fitted to {self.measurement.name} by haptisym identify"
        remarks = [
            *self._told(),
            *(f"The same response: {self.moved(x)}." for x in self.fit.others or ()),
        ]
        return scene_text(self.title, source, remarks, [*tables, ("[evaluation]", evaluation)])

    @property
    def has_ranges(self) -> bool:
        """Whether parameters are written as ranges: the model was not refuted, and the data
        determine every parameter."""
        return self.verdict.fits is not False and all(x.told for x in self.estimates)

    @property
    def confidence_words(self) -> str:
        """Words for the confidence of the box. Where errors are large, intervals from the curvature
        hold the truth less often than they claim, as simulated runs show.

        Of points that were estimated from records neither the leakage of the window nor the bias of
        loud points is in them: simulated loops of a mass of 0.8 kg, a damper and a spring held the
        truth in 41 to 89 of 90 intervals of 95 %.
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
        """Return an estimate as the scene file has it: a range, or its value alone."""
        # Where the file does not tell the kind of motion it is that of the page, along a line.
        plain = x.parameter.dimension in (Dimension.ANY, Dimension.RATIO)
        unit = Unit("") if plain else self.unit(x)
        texts = [f"{text} {unit.name}".rstrip() for text in x.in_unit(float(unit.size))]
        return texts if self.has_ranges else texts[1]

    def moved(self, other: Any) -> str:
        """Return what differs in another answer with the same response: paths, values and units."""
        pairs = [
            (x, v)
            for x, v in zip(self.estimates, other, strict=True)
            if x.parameter.path in self.ambiguous
        ]
        return ", ".join(
            f"{x.parameter.path} = {v / float(self.unit(x).size):.6g} {self.unit(x).name}".strip()
            for x, v in pairs
        )

    def _told(self) -> list[str]:
        """Return remarks for the head of the scene file: what its ranges mean."""
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
        """The paths of the parameters that have other values in another answer with the same
        response."""
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
        return {"path": x.parameter.path, **numbers, "unit": self._si_unit(x), "told": x.told}

    def unit(self, x: Estimate) -> Unit:
        """The unit in which a parameter is printed and written: Hz where the file is in Hz, ms for
        times below 1 s, else that of SI; without a name where its dimension is not known."""
        dimension = x.parameter.dimension
        if dimension is Dimension.FREQUENCY:
            return self.frequency
        if dimension is Dimension.TIME and x.value < 1:
            return Unit("ms", Rational(1, 1000))
        name = self._si_unit(x)
        return Unit("" if name == "1" else name)

    def _si_unit(self, x: Estimate) -> str:
        """Return the SI unit of a parameter; empty where its dimension is not known."""
        return x.parameter.dimension.unit(self.motion or MotionKind.TRANSLATION)

    @property
    def frequency(self) -> Unit:
        """The unit of frequency of the file: rad/s or Hz."""
        return HERTZ if self.measurement.in_hertz else RADIANS


def correlation(found: Fit) -> Any:
    """Return the correlation matrix of the estimates."""
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
    models = [effects] if isinstance(effects, str) else list(effects)
    asked = wanted(environment, models, degrees, known)
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
    """Return the measured response, or scene, that is given in any form; ``files`` : whether
    those that a scene names are read."""
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
    """Return words that point to the simulated bench run of a scene, or to all of them."""
    bench = f"{name}-bench"
    if bench in bench_names():
        return f"its simulated bench run is {bench}"
    return f"simulated bench runs are {', '.join(bench_names())}"
