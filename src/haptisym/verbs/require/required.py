"""The command ``require``: all values of one parameter for which a display is what is asked,
transparent, stable in a hand, or passive, alone or together.

Each thing asked has its own way (``solving``, ``hands``); the values for all of them are the
intersection. Where a condition binds at an end of the band, the end of the values may have a
formula: the condition there, in symbols, solved for the parameter and checked against 60 digits.
Begin with ``require``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from sympy import Abs, Expr, Float, Symbol

from haptisym.judge.answers import Answer
from haptisym.judge.bindings import IN_HANDS, Binding, Kind, stable_in
from haptisym.judge.bounds import ANY_ENVIRONMENT
from haptisym.judge.crossings import PASSIVE, Criterion, noticed, opened
from haptisym.kernel.arrays import has_arrays
from haptisym.kernel.budget import SECONDS, Told, limited
from haptisym.kernel.dynamics import RealFunction
from haptisym.kernel.errors import LimitError, SceneError, UndecidedError, meant
from haptisym.kernel.objects import titled
from haptisym.kernel.reals import RealNumber, Sliver, whole
from haptisym.kernel.rings import c, monomials, omega
from haptisym.kernel.sets import STOPPED, Domain, Piece, SingleValue, ValueSet, combined
from haptisym.kernel.solutions import Solution, exchanged
from haptisym.kernel.solutions import solve as formulas_of
from haptisym.model.catalogue import Hand
from haptisym.model.jnd import Part
from haptisym.model.parameters import values
from haptisym.model.quantities import Number
from haptisym.model.scene import Knob, Scene
from haptisym.model.scenefile import as_scene
from haptisym.model.valueranges import domain, searched
from haptisym.verbs.require.freeparameter import asked_of
from haptisym.verbs.require.solving import solve

if TYPE_CHECKING:
    from haptisym.verbs.require.nearest import Nearest

_DIGITS = 60
_MOST_TERMS, _MOST_OPERATIONS = 600, 80


def closed_form(
    condition: RealFunction, free: Symbol, place: Symbol, known: Mapping[Symbol, Expr], value: str
) -> Expr | None:
    """The formula for a parameter at which a condition binds at a frequency; None where there is no
    readable one.

    ``condition``: with symbols for all parameters; ``place``: the name of the frequency; ``known``:
    what all of them are worth; ``value``: decimal digits of the one solution that is meant, at
    least 60.
    """
    turned = exchanged(condition, free, place)
    if turned is None or len(turned.function.numerator) > _MOST_TERMS:
        return None
    # Several branches solve the condition: the one meant is the one with the digits of the end.
    for solution in _solved(_Posed.of(turned)):
        form = solution.omega
        if (
            form is not None
            and form.count_ops() <= _MOST_OPERATIONS
            and _is(form.xreplace(dict(known)), value)
        ):
            return form
    return None


@dataclass(frozen=True)
class _Posed:
    """A function whose zeros are asked for, equal to others by its terms: the slices of a map all
    ask for the same one, which is then solved once."""

    told: tuple[object, ...]
    function: RealFunction = field(compare=False)

    @classmethod
    def of(cls, function: RealFunction) -> _Posed:
        axis, parts = function.axis, (function.function.numerator, function.function.denominator)
        terms = (frozenset((tuple(map(int, e)), x) for e, x in monomials(p)) for p in parts)
        return cls((axis.meanings, tuple(axis.angles), tuple(axis.orders), *terms), function)


@lru_cache(maxsize=32)
def _solved(posed: _Posed) -> tuple[Solution, ...]:
    return formulas_of(posed.function)


def _is(number: Expr, value: str) -> bool:
    """Whether a formula has a value of 60 decimal digits, to all but eight of them."""
    found = number.evalf(_DIGITS)
    return bool(
        found.is_real
        and Abs(found - Float(value, _DIGITS)) <= Abs(found) * Float(10) ** (8 - _DIGITS)
    )


TRANSPARENT, SUITS_ALL = "transparent", "passive"
WISHES = (TRANSPARENT, *IN_HANDS, SUITS_ALL)
EVERY_PASSIVE_HAND = replace(PASSIVE, words="any passive operator", rule="passive")


def wishes(that: Sequence[str]) -> tuple[str, ...]:
    """What is asked, each thing once, in their order. SceneError names what is none of them."""
    listed = [that] if isinstance(that, str) else list(that)
    for x in listed:
        if x not in WISHES:
            raise SceneError(
                (
                    f'that: "{str(x)[:60]}" is none of {", ".join(WISHES)}; {meant(str(x), WISHES)}'
                ).rstrip("; ")
            )
    if not listed:
        raise SceneError(f"that: nothing is asked: one or more of {', '.join(WISHES)}")
    return tuple(x for x in WISHES if x in listed)


def in_words(name: str, criteria: Sequence[Criterion]) -> str:
    """Return what is required by one word, in full: ``transparent in the imaginary part`` where
    ``transparent`` is about that part alone."""
    judged = (x for x in criteria if x.name not in (*IN_HANDS, SUITS_ALL))
    return next((x.kept for x in judged if name == TRANSPARENT), name)


def further(scene: Scene, wanted: Sequence[str]) -> tuple[Criterion, ...]:
    """The criteria beside those of the JND: a hand each, and passivity."""
    held = tuple(stable_in(hand, x) for x in IN_HANDS if x in wanted for hand in scene.hands)
    return (*held, EVERY_PASSIVE_HAND) if SUITS_ALL in wanted else held


def solve_all(scene: Scene, free: Knob, asked: Domain, criteria: Sequence[Criterion]) -> ValueSet:
    """All values with which every criterion is kept: the intersection of those for each way of
    solving. What one way leaves undecided may still fail by another."""
    found = list[ValueSet]()
    judged = [x for x in criteria if x.name not in (*IN_HANDS, SUITS_ALL)]
    if judged:
        # A way that stays undecided must not hide that another one proves that no value holds.
        found.append(_or_open(lambda: solve(scene, free, asked, judged), asked))
    if len(judged) < len(criteria):
        from haptisym.verbs.require.hands import of_hands  # which much else is loaded for

        found += [_or_open(x, asked) for x in of_hands(scene, free, asked, criteria)]
    # At an end that is asked about what holds next to it is known as well.
    low, high = searched(free, asked)
    reach = replace(
        asked,
        low=low if asked.low is None else asked.low,
        high=high if asked.high is None else asked.high,
    )
    return replace(combined(found), searched=reach)


def _or_open(solved: Callable[[], ValueSet], asked: Domain) -> ValueSet:
    """The values; all of them undecided where that is not known, or the time does not last."""
    try:
        return solved()
    except LimitError:
        return ValueSet.all_of(asked, holds=None, reason=STOPPED)
    except UndecidedError as error:
        return ValueSet.all_of(asked, holds=None, reason=str(error))


_NAMES = {
    Kind.EDGE: Symbol("omega_max", positive=True),
    Kind.START: Symbol("omega_min", positive=True),
}

# Seconds for what each thing that was asked allows by itself.
_SECONDS = 5.0
# Products of terms of numerator and denominator of dH in symbols: beyond it no formula is readable,
# and building one takes minutes.
_MOST_PRODUCTS = 5000


@dataclass(frozen=True, repr=False)
class Requirement(Answer):
    """All values of one parameter for which a scene is transparent on its whole band, or what else
    is asked.

    ``free`` : the parameter, its path, unit and the value that the scene gives. ``domain`` : the
    values that were asked about, SI.
    ``values`` : all that were searched, SI, as a ``ValueSet``: its pieces hold, fail or are
    undecided, with a reason.
    ``feasible`` : the pieces that hold, in order; () means proven that there are none. The points
    at their ends have the condition that limits there, and at which frequency. ``undecided`` : the
    pieces of which nothing is proven.
    ``criteria`` : what is to hold; ``that`` : the words it was asked with. ``limit`` : seconds of a
    limit that cut the work short, None if none did.

    Proven: every value inside ``feasible`` satisfies it, and none outside of ``feasible`` and
    ``undecided`` does.

    >>> import haptisym as hs
    >>> found = hs.require("fu2019", "omega_n")
    >>> [(float(x.low), x.closed[0]) for x in found.feasible], found.undecided
    ([(122.35581477043092, True)], ())
    """

    _schema: ClassVar[str] = "haptisym.requirement/1"
    _page: ClassVar[str] = "haptisym.pages.require:page"
    _figure: ClassVar[str] = "haptisym.figures.requirement:REQUIREMENT"
    _certificate: ClassVar[str] = "haptisym.verbs.require.certificate:certificate"

    scene: Scene
    free: Knob
    domain: Domain
    values: ValueSet
    criteria: tuple[Criterion, ...] = ()
    digits: int = 15
    limit: float | None = None
    that: tuple[str, ...] = ("transparent",)
    """What was asked, as ``require`` takes it."""

    def _line(self) -> str:
        unit = f" ({self.free.unit})" if self.free.unit not in ("", "1") else ""
        return f"{titled(self.scene.title)}: {self.free.path}{unit}: {self.values.said}"

    @property
    def feasible(self) -> tuple[Piece, ...]:
        """The values that satisfy the requirement."""
        return self.values.feasible

    @property
    def undecided(self) -> tuple[Piece, ...]:
        """The values of which nothing is proven."""
        return self.values.undecided

    @property
    def reason(self) -> str:
        """Why something is undecided, where it is not for lack of time."""
        return self.values.reason

    @property
    def certified(self) -> bool:
        """Whether every end is proven and nothing was left undecided."""
        return not self.undecided

    @property
    def ends(self) -> tuple[SingleValue, ...]:
        """The ends that a condition limits, in order."""
        return self.values.ends

    @cached_property
    def nearest(self) -> Nearest | None:
        """The value that comes nearest where none holds what is asked; found in five seconds or not
        at all."""
        if self.feasible or self.undecided or not has_arrays():  # without NumPy nobody guesses
            return None
        from haptisym.verbs.require.nearest import ParameterQuestion, nearest

        return nearest(ParameterQuestion(self.scene, self.free, self.domain, self.criteria))

    @cached_property
    def alone(self) -> tuple[Requirement, ...]:
        """The answer for each of several things asked by itself, where no value holds all of them;
        in five seconds or not at all."""
        judged = tuple(x for x in self.criteria if x.name not in (*IN_HANDS, SUITS_ALL))
        others = [(x,) for x in self.criteria if x not in judged]
        asked = [judged, *others] if judged else others
        if self.feasible or self.undecided or len(asked) < 2:
            return ()
        with suppress(UndecidedError), limited(_SECONDS):
            return tuple(map(self._only, asked))
        return ()

    def _only(self, criteria: tuple[Criterion, ...]) -> Requirement:
        found = solve_all(self.scene, self.free, self.domain, criteria)
        return replace(self, values=found, criteria=criteria, that=())

    def form(self, end: SingleValue) -> Expr | None:
        """The value at an end as a formula in the scene's symbols, ``c`` and ``omega_max``; None
        where none is readable."""
        # Symbols are positive; and an end that is known by a narrow interval has no digits to check
        # by.
        if isinstance(end.value, Sliver) or float(end.value) <= 0:
            return None
        for binding in end.bindings:
            # At an end of the band the frequency is a symbol of its own; inside it depends on the
            # parameter, and a formula would be that of a double root.
            place = _NAMES.get(binding.kind)
            if place is not None and binding.omega is not None and float(binding.omega) > 0:
                condition = self._symbolic(binding.criterion)
                if condition is None:
                    return None
                known = self._known(binding.criterion) | {
                    place: self.scene.band[binding.kind is Kind.EDGE]
                }
                found = closed_form(condition, self.free.symbol, place, known, end.value.digits(60))
                if found is not None:
                    return found
        return None

    @cached_property
    def forms(self) -> tuple[Expr | None, ...]:
        """The formulas of ``ends``, None for each that has none."""
        return tuple(self.form(end) for end in self.ends)

    def _symbolic(self, criterion: Criterion) -> RealFunction | None:
        """The condition with symbols for all parameters; None where it would fill a book, or is
        that of a region."""
        if criterion.region is not None or criterion.threshold.has(omega):
            return None
        d = self.scene.symbolic_distortion()
        if (
            len(d.difference.numerator.monoms()) * len(d.difference.denominator.monoms())
            > _MOST_PRODUCTS
        ):
            return None
        # The threshold is open too, so that the formula holds c.
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
            "searched": [float(x) for x in searched(self.free, self.domain)],
            "band": [float(x) for x in self.scene.band],
            "condition": [x.name for x in self.criteria],
            "criteria": list(self.that),
            "feasible": rows["feasible"],
            "ends": [[self._end(x, 0), self._end(x, 1)] for x in self.feasible],
            "binding": rows["binding"],
            "closed_form": self.closed_form,
            "undecided": rows["undecided"],
            "certified": self.certified,
        }

    def _left(self) -> dict[str, Any]:
        found = {} if self.nearest is None else {"nearest": _nearest(self.nearest)}
        return (
            found
            | ({"limit": self.limit} if self.undecided and self.limit is not None else {})
            | self._why
        )

    def spans(self) -> list[list[float | None]]:
        """The values as a document has them, None where there is no end."""
        return [[_float(x.low), _float(x.high)] for x in self.feasible]

    def rows(self) -> dict[str, Any]:
        """What a document has about the values alone."""
        forms = dict(zip(self.ends, self.forms, strict=True))
        return {
            "feasible": self.spans(),
            "binding": [
                {
                    "at": float(end.value),
                    **_binding(b),
                    "closed_form": None if forms[end] is None else str(forms[end]),
                }
                for end in self.ends
                for b in end.bindings
            ],
            "undecided": [[_float(x.low), _float(x.high)] for x in self.undecided],
            "certified": self.certified,
            **self._why,
        }

    @property
    def _why(self) -> dict[str, Any]:
        return {"reason": self.reason} if self.undecided and self.reason else {}

    @property
    def closed_form(self) -> str | None:
        """The requirement as a formula where each end has one, such as ``tau <=
        asin(c)/omega_max``."""
        forms = dict(zip(self.ends, self.forms, strict=True))
        if not forms or any(form is None for form in forms.values()):
            return None
        return " or ".join(
            x for x in (self._inequality(span, forms) for span in self.feasible) if x
        )

    def _inequality(self, piece: Piece, forms: dict[SingleValue, Expr | None]) -> str:
        name = self.free.symbol.name
        if piece.is_single and piece.first in forms:
            return f"{name} = {forms[piece.first]}"
        low = [f"{name} >= {forms[piece.first]}"] if piece.first in forms else []
        high = [f"{name} <= {forms[piece.last]}"] if piece.last in forms else []
        return " and ".join(low + high)

    def _end(self, piece: Piece, side: int) -> dict[str, Any] | None:
        value = (piece.low, piece.high)[side]
        if value is None:
            return None
        enclosure = list(value.enclosure(self.digits))
        return {
            "digits": value.digits(self.digits),
            "enclosure": enclosure,
            "closed": piece.closed[side],
        }


def _float(x: RealNumber | None) -> float | None:
    return None if x is None else float(x)


def _binding(b: Binding) -> dict[str, Any]:
    omega = None if b.omega is None else float(b.omega)
    part = None if b.criterion.name == ANY_ENVIRONMENT.name else b.criterion.name
    name = b.criterion.name if b.criterion.name in WISHES else "transparent"
    return {
        "part": part if name == "transparent" else None,
        "criterion": name,
        "omega": omega,
        "kind": b.kind.value,
    }


def _nearest(x: Nearest) -> dict[str, Any]:
    row = {"value": float(x.value), "ratio": float(x.ratio), **_binding(x.binding)}
    return {**row, "times": x.times, "at_least": x.at_least}


def require(
    scene: Scene | str | Path,
    path: str,
    range: tuple[Number, Number] | None = None,  # noqa: A002 - the word that the question uses
    *,
    part: Part | None = None,
    any_environment: bool = False,
    that: Sequence[str] = (TRANSPARENT,),
    hand: str | Hand | None = None,
    digits: int = 15,
    limit: float | None = SECONDS,
    told: Told | None = None,
) -> Requirement:
    """The values of one parameter for which r_r <= c_real and r_i <= c_imag on the whole band: all
    of them, exactly.

    ``path`` : of the parameter, as ``effects.filter.omega_n``, ``environment.m``,
    ``evaluation.jnd``, or its symbol.
    ``range`` : the values asked about, numbers in SI or strings with a unit; if not given all that
    the model allows, of which those from a millionth to a million times the scene's are searched,
    and 0.
    ``part`` : ask for one part's condition only. ``any_environment`` : ask for |G - 1| <= c
    instead, which series effects G must keep to go unnoticed with every environment.
    ``that`` : what is asked of the display, together: "transparent", "stable" (in ``hand``, one of
    the scene or one that the package ships; in all hands of the scene if not given), "steady" (so
    but for a drift, as in free air), "passive" (stable with any passive operator).

    ``limit`` : seconds of processor time after which what is proven so far is answered, all other
    values being undecided; None for no limit.
    ``told`` : is called now and then with how much is done, of how much, and what it is.

    The answer is certified, by floats with bounds and by balls; values at which a ratio only
    touches its threshold, and what else these leave open, are in ``undecided``. SceneError where
    the path, the range or the scene is not fit.

    >>> from haptisym.model.scenefile import load_scene
    >>> found = require(load_scene("fu2019"), "effects.filter.omega_n")
    >>> [(x.low.digits(12), x.high) for x in found.feasible]
    [('122.355814770', None)]
    """
    scene = as_scene(scene)
    digits = whole("digits", digits)
    wanted = wishes(that)
    if {*IN_HANDS} & {*wanted}:
        from haptisym.verbs.require.hands import with_hands  # which much else is loaded for

        scene = with_hands(scene, hand)
    free = scene.knobs[path]
    asked = domain(free, range)
    judged = (
        asked_of(scene, [free], part, any_environment=any_environment)
        if TRANSPARENT in wanted
        else ()
    )
    criteria = (*judged, *further(scene, wanted))
    with limited(limit, told) as budget:
        found = solve_all(scene, free, asked, criteria)
    return Requirement(scene, free, asked, found, criteria, digits, budget.cut, tuple(wanted))


def is_quick(scene: Scene) -> bool:
    """Whether exact sets take milliseconds: low order, no delays nor powers of s, rational numbers.

    >>> from haptisym.model.scenefile import load_scene
    >>> is_quick(load_scene("fu2019")), is_quick(load_scene("delayed-spring"))
    (True, False)
    """
    d = scene.distortion()
    for x in noticed(scene.threshold):
        f = x.function(d)
        if not isinstance(f, RealFunction) or f.axis.functions:
            return False
        coefficients = f.axis.univariate(f.function.numerator)
        if coefficients is None or len(coefficients) > _QUICK_DEGREE + 1:
            return False
    return True


_QUICK_DEGREE = 12  # of the threshold polynomial in omega: a device of order 2
