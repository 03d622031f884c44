"""What a parameter must be: the values that were found, with a formula where there is one, and as a document."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar

from sympy import Expr, Symbol

from haptisym.judge.answers import Answer
from haptisym.judge.bounds import ANY_ENVIRONMENT
from haptisym.judge.criteria import Criterion, opened
from haptisym.kernel.budget import limited
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import RealNumber, Sliver
from haptisym.kernel.response import RealFunction
from haptisym.kernel.shown import titled
from haptisym.kernel.symbols import c, omega
from haptisym.model.jnd import Part
from haptisym.model.knobs import Knob
from haptisym.model.parameters import values
from haptisym.model.scene import Scene
from haptisym.verbs.require.closedforms import closed_form
from haptisym.verbs.require.feasible import Binding, End, Kind, Span, bound_ends, spanned
from haptisym.verbs.require.freeparameter import Domain
from haptisym.verbs.require.nearest import Nearest, nearest
from haptisym.verbs.require.wishes import STABLE, SUITS_ALL, solve_all

_NAMES = {Kind.EDGE: Symbol("omega_max", positive=True), Kind.START: Symbol("omega_min", positive=True)}

_SECONDS = 5.0
"""For what each thing that was asked allows by itself."""
_MOST_PRODUCTS = 5000
"""Of terms above and below the line of dH in symbols: beyond it no formula is readable, and building one takes minutes."""


@dataclass(frozen=True, repr=False)
class Requirement(Answer):
    """All values of one parameter for which a scene is transparent on its whole band, or what else is asked, certified.

    ``feasible``: intervals of values, SI, in order; () means proved that none will do. Each end says what binds there: which
    condition, and where on the band. ``undecided``: values about which nothing is proven; empty for every rational scene.
    ``limit``: the seconds of a limit that cut the work short, None if none did.
    ``domain``: the values that were asked about. ``criteria``: what is to hold.
    """

    _schema: ClassVar[str] = "haptisym.requirement/1"
    _page: ClassVar[str] = "haptisym.pages.require:page"
    _figure: ClassVar[str] = "haptisym.figures.require:requirement_figure"
    _certificate: ClassVar[str] = "haptisym.verbs.require.certificate:certificate"

    scene: Scene
    free: Knob
    domain: Domain
    feasible: tuple[Span, ...]
    undecided: tuple[tuple[RealNumber | None, RealNumber | None], ...] = ()
    criteria: tuple[Criterion, ...] = ()
    digits: int = 15
    limit: float | None = None
    that: tuple[str, ...] = ("transparent",)
    """What was asked, as ``require`` takes it."""
    reason: str = ""
    """Why something is undecided, where it is not for lack of time."""

    def _line(self) -> str:
        spans = " or ".join(map(spanned, self.feasible)) or "none will do"
        unit = f" ({self.free.unit})" if self.free.unit not in ("", "1") else ""
        return f"{titled(self.scene.title)}: {self.free.path}{unit}: {spans}"

    @property
    def certified(self) -> bool:
        """Whether every end is proven and nothing was left undecided."""
        return not self.undecided

    @property
    def ends(self) -> tuple[End, ...]:
        """The ends at which a condition binds, in order."""
        return bound_ends(self.feasible)

    @cached_property
    def nearest(self) -> Nearest | None:
        """Where no value will do, the one that comes nearest; found in five seconds or not at all."""
        return nearest(self)

    @cached_property
    def alone(self) -> tuple[Requirement, ...]:
        """Where no value will do and several things are asked: the answer for each by itself; in five seconds or not at all."""
        judged = tuple(x for x in self.criteria if x.name not in (STABLE, SUITS_ALL))
        others = [(x,) for x in self.criteria if x not in judged]
        asked = [judged, *others] if judged else others
        if self.feasible or self.undecided or len(asked) < 2:
            return ()
        with suppress(UndecidedError), limited(_SECONDS):
            return tuple(map(self._only, asked))
        return ()

    def _only(self, criteria: tuple[Criterion, ...]) -> Requirement:
        found = solve_all(self.scene, self.free, self.domain, criteria)
        return replace(
            self, feasible=found.feasible, undecided=found.undecided, criteria=criteria, that=(), reason=found.reason
        )

    def form(self, end: End) -> Expr | None:
        """The value at an end as a formula in the scene's symbols, ``c`` and ``omega_max``; None where none is readable."""
        if end.value is None or isinstance(end.value, Sliver) or float(end.value) <= 0:
            return None
        for binding in end.bindings:
            place = _NAMES.get(binding.kind)
            if place is not None and binding.omega is not None and float(binding.omega) > 0:
                condition = self._symbolic(binding.criterion)
                if condition is None:
                    return None
                known = self._known(binding.criterion) | {place: self.scene.band[binding.kind is Kind.EDGE]}
                found = closed_form(condition, self.free.symbol, place, known, end.value.digits(60))
                if found is not None:
                    return found
        return None

    @cached_property
    def forms(self) -> tuple[Expr | None, ...]:
        """The formulas of ``ends``, None for each that has none."""
        return tuple(self.form(end) for end in self.ends)

    def _symbolic(self, criterion: Criterion) -> RealFunction | None:
        """The condition with symbols for all parameters; None where it would fill a book, or is that of a region."""
        if criterion.region is not None or criterion.threshold.has(omega):
            return None
        d = self.scene.symbolic_distortion()
        if len(d.difference.numerator.monoms()) * len(d.difference.denominator.monoms()) > _MOST_PRODUCTS:
            return None
        [found] = (x.function(d) for x in opened([criterion], tuple(Part)))
        assert isinstance(found, RealFunction)
        return found

    def _known(self, criterion: Criterion) -> dict[Symbol, Expr]:
        own = next(x.threshold for x in self.criteria if x.name == criterion.name)
        return {**values(self.scene.parameters), c: own}

    @property
    def _varied(self) -> tuple[list[str], list[str]]:
        return [self.free.path], [self.free.path]

    def _body(self) -> dict[str, Any]:
        low, high = (None if x is None else float(x) for x in (self.domain.low, self.domain.high))
        rows = self.rows()
        return {
            "free": self.free.path,
            "unit": self.free.unit,
            "range": [low, high],
            "band": [float(x) for x in self.scene.band],
            "condition": [x.name for x in self.criteria],
            "criteria": list(self.that),
            "feasible": rows["feasible"],
            "ends": [[self._end(x.low), self._end(x.high)] for x in self.feasible],
            "binding": rows["binding"],
            "closed_form": self.closed_form,
            "undecided": rows["undecided"],
            "certified": self.certified,
        }

    def _left(self) -> dict[str, Any]:
        found = {} if self.nearest is None else {"nearest": _nearest(self.nearest)}
        return found | ({"limit": self.limit} if self.undecided and self.limit is not None else {}) | self._why

    def spans(self) -> list[list[float | None]]:
        """The values as a document has them, None where there is no end."""
        return [[_float(x.low), _float(x.high)] for x in self.feasible]

    def rows(self) -> dict[str, Any]:
        """What a document says about the values alone."""
        forms = dict(zip(self.ends, self.forms, strict=True))
        return {
            "feasible": self.spans(),
            "binding": [
                {"at": _float(end), **_binding(b), "closed_form": None if forms[end] is None else str(forms[end])}
                for end in self.ends
                for b in end.bindings
            ],
            "undecided": [[None if x is None else float(x) for x in pair] for pair in self.undecided],
            "certified": self.certified,
            **self._why,
        }

    @property
    def _why(self) -> dict[str, Any]:
        return {"reason": self.reason} if self.undecided and self.reason else {}

    @property
    def closed_form(self) -> str | None:
        """The requirement as a formula where each end has one, such as ``tau <= asin(c)/omega_max``."""
        forms = dict(zip(self.ends, self.forms, strict=True))
        if not forms or any(form is None for form in forms.values()):
            return None
        return " or ".join(x for x in (self._inequality(span, forms) for span in self.feasible) if x)

    def _inequality(self, span: Span, forms: dict[End, Expr | None]) -> str:
        name = self.free.symbol.name
        if span.low == span.high and span.low in forms:
            return f"{name} = {forms[span.low]}"
        low = [f"{name} >= {forms[span.low]}"] if span.low in forms else []
        high = [f"{name} <= {forms[span.high]}"] if span.high in forms else []
        return " and ".join(low + high)

    def _end(self, end: End) -> dict[str, Any] | None:
        if end.value is None:
            return None
        enclosure = list(end.value.enclosure(self.digits))
        return {"digits": end.value.digits(self.digits), "enclosure": enclosure, "closed": end.closed}


def _float(end: End) -> float | None:
    return None if end.value is None else float(end.value)


def _binding(b: Binding) -> dict[str, Any]:
    omega = None if b.omega is None else float(b.omega)
    part = None if b.criterion.name == ANY_ENVIRONMENT.name else b.criterion.name
    name = b.criterion.name if b.criterion.name in ("stable", "passive") else "transparent"
    return {"part": part if name == "transparent" else None, "criterion": name, "omega": omega, "kind": b.kind.value}


def _nearest(x: Nearest) -> dict[str, Any]:
    row = {"value": float(x.value), "ratio": float(x.ratio), **_binding(x.binding)}
    return {**row, "times": x.times, "at_least": x.at_least}
