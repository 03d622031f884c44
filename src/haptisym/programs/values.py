"""NumPy functions of a scene's closed forms: arrays of frequencies and parameters in, arrays of the
broadcast shape out, at one of three levels of accuracy (``programs.accuracy``).

A call first bounds the magnitudes of all steps from those of its inputs. If nothing can overflow or
lose digits to underflow, floats or double-doubles compute all points at once; otherwise the points
at which that happens are found, and computed with a proof. Entries that are not finite (0/0, poles)
are replaced by their limits at the end. ``digits`` gives correctly rounded decimal strings. Begin
with ``Compiled``.
"""

from __future__ import annotations

import time
from collections import Counter, namedtuple
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, cached_property
from math import prod
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from haptisym.kernel.arrays import np
from haptisym.kernel.errors import SceneError, several
from haptisym.kernel.names import keywords
from haptisym.kernel.objects import Shown
from haptisym.kernel.reals import rounded, whole
from haptisym.programs.accuracy import Accuracy, Backend
from haptisym.programs.certified import Certified, Doubles, FormsAt
from haptisym.programs.floats import Floats, Judgement, MagnitudeRange, judged, ranges
from haptisym.programs.machine import Machine
from haptisym.programs.program import Program

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    Array: TypeAlias = NDArray[np.float64]
else:
    Array = Any

_LEAST = 32  # frequencies that are not halved again to find those at which a float overflows
_MOST_DOUBLED = 28  # decimal digits that a double-double can prove
# By whether floats compute, or double-doubles: binary digits, and the exponent that no step may
# reach. The low part of a double-double and the error of a product are some 107 bits below it, and
# must not underflow either, which leaves it less room.
_ROOM = {True: (53, 1020), False: (107, 900)}
_MOST_KEPT = 64  # judgements that a function keeps
_FEW = 24  # points for which balls alone are cheaper than an array of double-doubles


class Values(NamedTuple):
    """Real and imaginary parts at the given frequencies, each of the shape of the broadcast
    arguments.

    ``real``, ``imag`` : of the distortion dH = H_perc - H_env, in its unit. ``ratio_...`` : their
    magnitudes over |H_env|. ``relative_...`` : of dH/H_env. ``environment_...`` : of H_env.
    ``perceived_...`` : of H_perc.
    """

    real: Array
    imag: Array
    ratio_real: Array
    ratio_imag: Array
    relative_real: Array
    relative_imag: Array
    environment_real: Array
    environment_imag: Array
    perceived_real: Array
    perceived_imag: Array


def chosen(of: Sequence[str] | str | None) -> tuple[str, ...]:
    """The fields asked for, each once; all of them for None. SceneError for what is no field.

    >>> chosen(["ratio_real", "ratio_imag"])
    ('ratio_real', 'ratio_imag')
    """
    if of is None:
        return Values._fields
    names = (of,) if isinstance(of, str) else several("of", of, "give names of closed forms")
    wrong = [name for name in names if name not in Values._fields or names.count(name) > 1]
    if wrong or not names:
        raise SceneError(
            f"of: {wrong[0] if wrong else 'nothing'}: choose among "
            f"{', '.join(Values._fields)}, each once"
        )
    return names


@dataclass(frozen=True, eq=False, repr=False)
class Compiled(Shown):
    """A function ``f(omega, name=value, ...)`` of frequencies in rad/s and parameters in SI, all of
    them broadcast.

    ``fields`` : what it returns, as a named tuple (``Values`` where it is all of them) of arrays of
    the broadcast shape.
    ``parameters`` : the names that it must be given; one that is no name in Python as ``lambdify``
    has it (``lambda_``). Arguments are exact: the doubles that they are.
    Steps that could overflow, or lose digits to underflow, are never left to floats: such
    frequencies are computed as at the level "certified". Values that floats leave undefined (0/0)
    are limits; poles are infinite; a result beyond the range of doubles is infinite or 0.
    Frequencies that are not finite give not-a-number.
    """

    fields: tuple[str, ...]
    parameters: tuple[str, ...]
    accuracy: Accuracy
    program: Program
    forms: FormsAt
    floats: Floats | Machine

    def _line(self) -> str:
        return (
            f"of {', '.join(['omega', *self.parameters])}: {', '.join(self.fields)} "
            f"({self.accuracy.value})"
        )

    def __call__(self, /, omega: ArrayLike, **values: ArrayLike) -> Any:
        inputs, shape, size = self._inputs(omega, values)
        judgement = None if self.accuracy is Accuracy.CERTIFIED else self._judged(ranges(inputs))
        is_plain = judgement and judgement.finite and self.accuracy is Accuracy.FAST
        # At one point, arrays of one number would take most of the time.
        if is_plain and shape == ():
            return self._kind(*map(np.array, self.floats.point(inputs)))
        out = np.empty((len(self.fields), size))
        rows = [*out]
        if is_plain:
            self.floats.fill(inputs, size, rows)
        else:
            self._fill(inputs, size, out, judgement)
        return self._kind(*(rows if len(shape) == 1 else [x.reshape(shape) for x in rows]))

    @cached_property
    def _kind(self) -> Any:
        return Values if self.fields == Values._fields else _tuple("Values", self.fields)

    def digits(self, /, omega: ArrayLike, count: int, **values: ArrayLike) -> Any:
        """Correctly rounded decimal strings with ``count`` significant digits, by the cheapest
        method that proves them.

        The named tuple has the fields, strings or arrays of strings in the broadcast shape, and
        besides ``method``, what proved how many of the values, and ``seconds``, what that cost.
        "0", "inf", "-inf" and "nan" are written so. A tie within 200 more digits goes to the even
        digit.
        """
        count = whole("digits", count)
        started = time.perf_counter()
        inputs, shape, size = self._inputs(omega, values)
        texts, methods = self._texts(inputs, size, count)
        columns = [
            texts[name][0] if shape == () else np.array(texts[name], dtype=object).reshape(shape)
            for name in texts
        ]
        method = ", ".join(f"{n} by {name}" for name, n in methods.most_common())
        return _tuple("Digits", (*self.fields, "method", "seconds"))(
            *columns, method, time.perf_counter() - started
        )

    @cached_property
    def _names(self) -> frozenset[str]:
        return frozenset(self.parameters)

    @cached_property
    def _own(self) -> dict[str, str]:
        """The name of each parameter by the keyword that it is in Python."""
        return {x: name for name, x in keywords(self.parameters).items()}

    @cached_property
    def certified(self) -> Certified:
        """What proves values where floats do not do."""
        return Certified(self.program, self.forms)

    @cached_property
    def _doubles(self) -> Doubles:
        return Doubles(self.program, bounded=False)

    def _fill(
        self, inputs: Sequence[Any], size: int, out: Any, judgement: Judgement | None
    ) -> None:
        fast = self.accuracy is Accuracy.FAST
        if judgement is not None and judgement.safe:
            self._compute(inputs, size, out)
        else:
            # An input that is not finite makes the judgement unsafe, if any step reads it.
            (self._watch if fast else self._prove)(inputs, size, out)
            out[:, ~_are_finite(inputs, size)] = np.nan
            if not fast:
                return
        # One sum shows for all entries whether any is not finite. Where finite entries overflow
        # only when added, ``_repair`` finds nothing to do.
        if not (judgement and judgement.finite) and not _all_finite(out):
            self._repair(inputs, out)

    def _judged(self, inputs: tuple[MagnitudeRange, ...]) -> Judgement:
        """What can over- or underflow, kept for other inputs of that size: it takes longer than a
        thousand frequencies."""
        found = self._judgements.get(inputs)
        if found is None:
            found = judged(self.program, inputs, *_ROOM[self.accuracy is Accuracy.FAST])
            if len(self._judgements) >= _MOST_KEPT:
                self._judgements.clear()
            self._judgements[inputs] = found
        return found

    @cached_property
    def _judgements(self) -> dict[tuple[MagnitudeRange, ...], Judgement]:
        return {}

    def _watch(self, inputs: Sequence[Any], size: int, out: Any) -> None:
        """Fill ``out`` in floats wherever the processor reports neither overflow nor underflow, and
        with proven values elsewhere."""
        # The processor does not say at which frequency it happened: halves are tried again.
        try:
            self.floats.run(inputs, size, [*out], watched=True)
        except FloatingPointError:
            if size <= _LEAST:
                self._prove(inputs, size, out)
                return
            for part in (slice(0, size // 2), slice(size // 2, size)):
                self._watch(
                    [x if np.ndim(x) == 0 else x[part] for x in inputs],
                    part.stop - part.start,
                    out[:, part],
                )

    def _prove(self, inputs: Sequence[Any], size: int, out: Any) -> None:
        values, _ = self.certified.run(inputs, size)
        for row, name in zip(out, self.fields, strict=True):
            row[...] = values[name]

    def _compute(self, inputs: Sequence[Any], size: int, out: Any) -> None:
        """Fill ``out`` in floats or double-doubles, without a proof."""
        if self.accuracy is Accuracy.FAST:
            self.floats.run(inputs, size, [*out])
            return
        results = self._doubles.run(inputs, size)
        for row, name in zip(out, self.fields, strict=True):
            row[...] = results[name].hi

    def _repair(self, inputs: Sequence[Any], out: Any) -> None:
        """Replace the entries that are not finite by their exact values, limits or infinities."""
        for n in np.flatnonzero(~np.isfinite(out).all(axis=0)).tolist():
            names = [
                name for name, row in zip(self.fields, out, strict=True) if not np.isfinite(row[n])
            ]
            for name, value in self.certified.at(_point(inputs, n), names).items():
                out[self.fields.index(name), n] = value

    def _texts(
        self, inputs: Sequence[Any], size: int, count: int
    ) -> tuple[dict[str, list[str | None]], Counter[str]]:
        """The decimal strings by field, and how many of them each method has proven."""
        texts: dict[str, list[str | None]] = {name: [None] * size for name in self.fields}
        methods: Counter[str] = Counter()
        # Double-doubles first, as they take all points at once; a text that they do not prove is
        # None.
        if count <= _MOST_DOUBLED and size > _FEW:
            sound = _are_finite(inputs, size).tolist()
            for name, x in self.certified.doubles.run(inputs, size).items():
                rows = zip(*(part.tolist() for part in x), sound, strict=True)
                texts[name] = [_decimal(row, count) if ok else None for *row, ok in rows]
        for name, row in texts.items():
            proven = sum(text is not None for text in row)
            methods["double-double"] += proven
            for n in (n for n, text in enumerate(row) if text is None):
                number = self.certified.number(_point(inputs, n), name)
                row[n] = f"{number:g}" if isinstance(number, float) else number.digits(count)
                methods["limit" if isinstance(number, float) else "ball arithmetic"] += 1
        return texts, +methods

    def _inputs(
        self, omega: ArrayLike, values: Mapping[str, ArrayLike]
    ) -> tuple[list[Any], tuple[int, ...], int]:
        """Single numbers as floats, everything else as flat arrays of the broadcast shape; that
        shape, and its size."""
        if values.keys() != self._names:
            values = {self._own.get(name, name): x for name, x in values.items()}
        if values.keys() != self._names:
            needed, given = (", ".join(sorted(x)) or "none" for x in (self.parameters, values))
            raise SceneError(f"parameters needed are {needed}; given are {given}")
        arguments = [
            _array("omega", omega),
            *[_array(name, values[name]) for name in self.parameters],
        ]
        shapes = {() if isinstance(x, float) else x.shape for x in arguments}
        try:
            shape = shapes.pop() if len(shapes) == 1 else np.broadcast_shapes(*shapes)
        except ValueError:
            named = zip(("omega", *self.parameters), arguments, strict=True)
            listed = ", ".join(f"{name} {np.shape(x)}" for name, x in named)
            raise SceneError(f"the shapes of the arguments do not broadcast: {listed}") from None
        # A single number stays one: steps that depend on such numbers alone are computed once, and
        # not for every frequency.
        flat: list[Any] = []
        for x in arguments:
            if isinstance(x, float):
                flat.append(x)
            elif x.size == 1:
                flat.append(x.item())
            else:
                flat.append((x if x.shape == shape else np.broadcast_to(x, shape)).ravel())
        return flat, shape, prod(shape)


def _array(name: str, given: ArrayLike) -> Any:
    """An argument as an array of floats, or as the float that it is; SceneError for what is no real
    number."""
    if type(given) is float:
        return given
    from_anything = np.asarray  # where NumPy is missing, that is the error
    try:
        x = from_anything(given)
        if x.dtype == float:
            return x
        # NumPy would drop an imaginary part with a mere warning.
        real = None if x.dtype.kind == "c" else x.astype(float)
    except (TypeError, ValueError):
        raise SceneError(f"{name}: {given!r} must be real numbers") from None
    if real is None:
        what = "frequencies in rad/s" if name == "omega" else "numbers in SI"
        raise SceneError(f"{name}: give real {what}")
    return real


@cache
def _tuple(name: str, fields: tuple[str, ...]) -> Any:
    """A class is made once: that takes longer than a thousand values."""
    return namedtuple(name, fields)


def _all_finite(out: Any) -> bool:
    with np.errstate(all="ignore"):
        return bool(np.isfinite(out.sum()))


def _are_finite(inputs: Sequence[Any], size: int) -> Any:
    """At which points all inputs are numbers."""
    return np.logical_and.reduce([np.broadcast_to(np.isfinite(x), (size,)) for x in inputs])


def _point(inputs: Sequence[Any], n: int) -> tuple[float, ...]:
    return tuple(float(x) if np.ndim(x) == 0 else float(x[n]) for x in inputs)


def _decimal(row: Sequence[float], count: int) -> str | None:
    """The decimal digits that a double-double proves; None if it does not."""
    if not np.isfinite(row).all():
        return None
    # In fractions hi + lo -+ error is exact. An enclosure of 0 has no first digit.
    hi, lo, error = (Fraction(x) for x in row)
    low, high = hi + lo - error, hi + lo + error
    return rounded(low, high, count) if low * high > 0 else None


def compiled(
    program: Program,
    forms: FormsAt,
    accuracy: Accuracy | str = Accuracy.FAST,
    engine: Backend | str = Backend.NUMPY,
) -> Compiled:
    """The function of a program whose results are fields of ``Values``; SceneError for a wrong
    level or engine."""
    level = Accuracy.of(accuracy)
    floats = Machine(program) if Backend.of(engine) is Backend.NUMBA else Floats(program)
    names = tuple(x.name for x in program.inputs[1:])
    return Compiled(tuple(program.results), names, level, program, forms, floats)
