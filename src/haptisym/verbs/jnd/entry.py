"""What a person's answers say of the just-noticeable difference, and what was published.

What a person's answers say of the just-noticeable difference, ready for a scene. Estimated, never certified.

The published thresholds as an answer: a table for reading, and for a program.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from decimal import ROUND_CEILING, ROUND_FLOOR, ROUND_HALF_EVEN, Context
from functools import cached_property
from math import isfinite
from pathlib import Path
from typing import Any, ClassVar

from haptisym.judge.answers import Answer
from haptisym.kernel.budget import ONE_THREAD
from haptisym.kernel.errors import SceneError
from haptisym.kernel.objects import counted
from haptisym.model.jnd import Published, published_by_name
from haptisym.verbs.jnd.fitting import Asked, Deviance, Estimate, Fit, grouped_words
from haptisym.verbs.jnd.tables import Answers, condensed, read_answers

METHODS = {"likelihood": "maximum likelihood", "psignifit": "psignifit 4"}


@dataclass(frozen=True)
class File:
    """What an answer is about where that is no scene."""

    title: str

    def asides(self, besides: Collection[str] = (), varied: Collection[str] | None = ()) -> list[str]:
        """Nothing: no parameter is nominal."""
        return []

    def aside_keys(self, besides: Collection[str] = (), varied: Collection[str] | None = ()) -> dict[str, Any]:
        """Nothing."""
        return {}


@dataclass(frozen=True, repr=False)
class Psychometric(Answer):
    """A psychometric function for answers at several levels, and the JND that it gives.

    ``answers`` : the data. ``fit`` : the curve, its middle (the point of subjective equality of a comparison), the JND with its
    interval, the deviance. ``reference`` : the level of the standard; the JND as a fraction of it is ``fraction``.
    """

    _schema: ClassVar[str] = "haptisym.jnd/1"
    _page: ClassVar[str] = "haptisym.pages.jnd:page"
    _figure: ClassVar[str] = "haptisym.figures.jnd:jnd_figure"

    answers: Answers
    asked: Asked
    fit: Fit
    method: str = "likelihood"
    confidence: float = 0.95
    reference: float | None = None

    def _line(self) -> str:
        found = self.fraction or self.jnd
        return f"{self.answers.name}: {'fraction' if self.fraction else 'JND'} {found.value:.4g} at {self.asked.proportion:.4g}"

    @property
    def certified(self) -> bool:
        """False: answers are measured, and what is fitted to them is an estimate."""
        return False

    @property
    def _about(self) -> File:
        return File(self.answers.name)

    @property
    def jnd(self) -> Estimate:
        """In the unit of the levels."""
        return self.fit.jnd

    @property
    def middle(self) -> Estimate:
        """Where the curve is halfway: of a comparison the point of subjective equality."""
        return self.fit.middle

    @property
    def fraction(self) -> Estimate | None:
        """The JND over the level of the standard; None without one."""
        return None if self.reference is None else self.jnd.scaled(1 / self.reference)

    @property
    def deviance(self) -> Deviance:
        """How well the curve fits."""
        return self.fit.deviance

    @cached_property
    def table(self) -> dict[str, str]:
        """The threshold as the table ``jnd`` of a scene's ``[evaluation]``, values as TOML; empty without a fraction.

        The interval is a range. A comparison tells its proportion, so that it can be brought to another one; the curve of a
        forced choice has another shape, and is asked for the proportion itself.
        """
        if self.fraction is None:
            return {}
        own = dict.fromkeys(("real", "imag"), _written(self.fraction)) | {"confidence": f"{self.confidence:g}"}
        return own if self.asked.alternatives else own | {"proportion": f"{self.asked.proportion:.15g}"}

    @property
    def line(self) -> str:
        """The same as one line; empty without a fraction."""
        told = ", ".join(f"{key} = {value}" for key, value in self.table.items())
        return f"jnd = {{ {told} }}" if told else ""

    @property
    def notes(self) -> tuple[str, ...]:
        """What was put together or left out."""
        grouped = grouped_words(self.deviance, len(self.answers.rows))
        tested = (f"For the test of the fit: {grouped}",) if grouped and self.deviance.p is not None else ()
        return (*self.answers.notes, *self.fit.notes, *tested)

    def _body(self) -> dict[str, Any]:
        curve, tested = self.fit.curve, self.deviance
        return {
            "alternatives": self.asked.alternatives,
            "proportion": self.asked.proportion,
            "confidence": self.confidence,
            "method": METHODS[self.method],
            "data": [{"level": x.level, "k": x.count, "n": x.trials} for x in self.answers.rows],
            "curve": {"mu": curve.mu, "sigma": curve.sigma, "guess": curve.guess, "lapse": curve.lapse},
            "threshold": _row(self.middle),
            "jnd": _row(self.jnd),
            "reference": self.reference,
            "fraction": None if self.fraction is None else _row(self.fraction),
            "deviance": {"value": tested.value, "degrees": tested.degrees, "p": tested.p, "fits": tested.fits},
            "line": self.line or None,
            "notes": list(self.notes),
            "certified": self.certified,
        }


def jnd(
    data: Answers | str | Path,
    *,
    proportion: float | None = None,
    alternatives: int | None = None,
    guess: float = 0.0,
    lapse: float | None = 0.0,
    reference: float | None = None,
    confidence: float = 0.95,
    method: str = "likelihood",
    columns: Mapping[str, str] | None = None,
    where: Mapping[str, str] | None = None,
) -> Psychometric:
    """Fit a cumulative Gaussian to the answers in a file; what it says of the JND. Needs SciPy.

    ``data`` : a table (CSV) of levels with counts k of n, or of single answers 1 and 0, or what psignifit 4 saved as JSON.
    ``proportion`` : of "more", or of right answers, at which the JND is taken; 0.75 for a comparison, else halfway between chance
    and 1. ``alternatives`` : of a forced choice, whose levels are differences from the standard. ``guess``, ``lapse`` : shares of
    answers that do not depend on the level; a lapse of None is fitted, up to 0.1. ``reference`` : the level of the standard.
    ``method`` : "likelihood", or "psignifit", which is another package, and fits guesses and lapses itself. ``columns`` : which
    column holds "level", "count", "trials" or "answer"; ``where`` : only lines with these values.
    """
    answers = condensed(data if isinstance(data, Answers) else read_answers(data, columns or {}, where or {}))
    choices = answers.alternatives if alternatives is None else alternatives
    if answers.alternatives not in (None, choices):
        raise SceneError(f"{answers.name} says that there were {answers.alternatives} alternatives, not {choices}")
    asked = Asked.of(proportion, choices)
    _check(asked, guess, lapse, reference, confidence)
    if method not in METHODS:
        raise SceneError(f'method: "{str(method)[:60]}": valid are {", ".join(METHODS)}')
    if method == "psignifit":
        from haptisym.verbs.jnd.fitting import fitted_by_psignifit

        if guess or lapse != 0:
            raise SceneError("psignifit fits guesses and lapses itself: leave out guess and lapse")
        fit = fitted_by_psignifit(answers, asked, confidence)
    else:
        from haptisym.verbs.jnd.fitting import fitted

        with ONE_THREAD:
            fit = fitted(answers, asked, 1 / choices if choices else guess, lapse, confidence)
    if choices:
        fit = replace(fit, jnd=fit.jnd.as_size)
    return Psychometric(answers, asked, fit, method, confidence, reference)


def _check(asked: Asked, guess: float, lapse: float | None, reference: float | None, confidence: float) -> None:
    if asked.alternatives and guess:
        raise SceneError("guess: a forced choice has its own, one over the number of alternatives: leave it out")
    for key, share in (("guess", guess), ("lapse", lapse)):
        if share is not None and not 0 <= share < 0.5:
            raise SceneError(f"{key}: {share:g} must lie from 0 to below 0.5")
    if reference is not None and not (isfinite(reference) and reference > 0):
        raise SceneError(f"reference: {reference:g} must be a level above 0")
    if not 0 < confidence < 1:
        raise SceneError(f"confidence: {confidence:g} must lie between 0 and 1")


def _row(x: Estimate) -> dict[str, Any]:
    return {"value": x.value, "interval": [x.low, x.high]}


def _written(x: Estimate) -> str:
    """A range with its nominal value; the interval is rounded outwards. The value alone where the interval has no end."""
    nominal = _decimal(x.value, ROUND_HALF_EVEN)
    if x.low is None or x.high is None or x.low <= 0:
        return nominal
    return f"[{_decimal(x.low, ROUND_FLOOR)}, {nominal}, {_decimal(x.high, ROUND_CEILING)}]"


def _decimal(value: float, rounding: str) -> str:
    return f"{Context(prec=4, rounding=rounding).create_decimal_from_float(value):f}"


class PublishedThresholds(Answer, tuple[Published, ...]):
    """Published just-noticeable differences, each usable by its name: ``jnd = { like = "viscosity-forced-choice" }``."""

    _schema: ClassVar[str] = "haptisym.published/1"
    _page: ClassVar[str] = "haptisym.pages.jnd:published_page"

    def __new__(cls, found: Iterable[Published]) -> PublishedThresholds:
        return super().__new__(cls, found)

    def _line(self) -> str:
        return counted(len(self), "published threshold")

    @property
    def certified(self) -> bool:
        """False: they were measured."""
        return False

    @property
    def _about(self) -> File:
        return File("Published thresholds")

    def _body(self) -> dict[str, Any]:
        return {"thresholds": [_row_in_published(x) for x in self], "certified": self.certified}


def _row_in_published(x: Published) -> dict[str, Any]:
    return {
        "name": x.name,
        "quantity": x.quantity,
        "fraction": [float(x.low), float(x.high)],
        "criterion": None if x.criterion is None else float(x.criterion),
        "reference": x.reference,
        "source": x.source,
        "doi": x.doi or None,
        "read": x.read,
        "usable": not x.apart,
    }


def published() -> PublishedThresholds:
    """All published thresholds that the package knows, with their sources.

    >>> [x.name for x in published() if x.criterion]
    ['steering-wheel', 'viscosity-forced-choice', 'viscosity-matching']
    """
    return PublishedThresholds(published_by_name().values())
