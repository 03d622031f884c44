"""NumPy functions of closed forms: shape kept, limits by value, as accurate as asked for."""

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
from haptisym.kernel.errors import SceneError
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

_LEAST = 32  # frequencies that are not taken apart to find those at which a float overflows
_MOST_DOUBLED = 28  # decimal digits that a double-double can prove
_ROOM = {
    True: (53, 1020),
    False: (107, 900),
}  # binary digits and greatest exponent of floats, and of double-doubles
_MOST_KEPT = 64  # judgements
_FEW = 24  # points for which balls alone are cheaper than an array of double-doubles


class Values(NamedTuple):
    """Values of the closed forms at the given frequencies, each of the shape of the broadcast
    arguments."""

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
    names = (of,) if isinstance(of, str) else tuple(of)
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
    ``parameters`` : the names that it must be given. Arguments are exact: the doubles that they
    are.
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
        out = np.empty((len(self.fields), size))
        self._fill(inputs, size, out)
        return self._kind(*[x.reshape(shape) for x in out])

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
    def certified(self) -> Certified:
        """What proves values where floats do not do."""
        return Certified(self.program, self.forms)

    @cached_property
    def _doubles(self) -> Doubles:
        return Doubles(self.program, bounded=False)

    def _fill(self, inputs: Sequence[Any], size: int, out: Any) -> None:
        fast = self.accuracy is Accuracy.FAST
        found = None if self.accuracy is Accuracy.CERTIFIED else self._judged(ranges(inputs))
        if found is not None and found.safe:
            self._compute(inputs, size, out)
        else:
            (self._watch if fast else self._prove)(inputs, size, out)
            out[:, ~_are_finite(inputs, size)] = np.nan
            if not fast:
                return
        # one sum tells of all whether any is not finite; where they overflow only together, nothing
        # is repaired
        if not (found and found.finite) and not _all_finite(out):
            self._repair(inputs, out)

    def _judged(self, inputs: tuple[MagnitudeRange, ...]) -> Judgement:
        """What can over- or underflow, kept for other inputs of that size: it takes longer than a
        thousand frequencies."""
        if inputs not in self._judgements:
            if len(self._judgements) >= _MOST_KEPT:
                self._judgements.clear()
            self._judgements[inputs] = judged(
                self.program, inputs, *_ROOM[self.accuracy is Accuracy.FAST]
            )
        return self._judgements[inputs]

    @cached_property
    def _judgements(self) -> dict[tuple[MagnitudeRange, ...], Judgement]:
        return {}

    def _watch(self, inputs: Sequence[Any], size: int, out: Any) -> None:
        """In floats wherever the processor sees them keep their digits, and proven elsewhere."""
        try:
            Floats(self.program).run(inputs, size, out, watched=True)
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
        found, _ = self.certified.run(inputs, size)
        for row, name in zip(out, self.fields, strict=True):
            row[...] = found[name]

    def _compute(self, inputs: Sequence[Any], size: int, out: Any) -> None:
        if self.accuracy is Accuracy.FAST:
            self.floats.run(inputs, size, out)
            return
        found = self._doubles.run(inputs, size)
        for row, name in zip(out, self.fields, strict=True):
            row[...] = found[name].hi

    def _repair(self, inputs: Sequence[Any], out: Any) -> None:
        for n in np.flatnonzero(~np.isfinite(out).all(axis=0)).tolist():
            names = [
                name for name, row in zip(self.fields, out, strict=True) if not np.isfinite(row[n])
            ]
            for name, value in self.certified.at(_point(inputs, n), names).items():
                out[self.fields.index(name), n] = value

    def _texts(
        self, inputs: Sequence[Any], size: int, count: int
    ) -> tuple[dict[str, list[str | None]], Counter[str]]:
        texts: dict[str, list[str | None]] = {name: [None] * size for name in self.fields}
        methods: Counter[str] = Counter()
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
        if sorted(values) != list(self.parameters):
            needed, given = (", ".join(sorted(x)) or "none" for x in (self.parameters, values))
            raise SceneError(f"parameters needed are {needed}; given are {given}")
        arguments = [
            _array("omega", omega),
            *[_array(name, values[name]) for name in self.parameters],
        ]
        shapes = {x.shape for x in arguments}
        try:
            shape = shapes.pop() if len(shapes) == 1 else np.broadcast_shapes(*shapes)
        except ValueError:
            listed = ", ".join(
                f"{name} {x.shape}"
                for name, x in zip(("omega", *self.parameters), arguments, strict=True)
            )
            raise SceneError(f"the shapes of the arguments do not broadcast: {listed}") from None
        flat = [
            float(x.item())
            if x.size == 1
            else (x if x.shape == shape else np.broadcast_to(x, shape)).ravel()
            for x in arguments
        ]
        return flat, shape, prod(shape)


def _array(name: str, given: ArrayLike) -> Array:
    if np.iscomplexobj(given):
        raise SceneError(
            f"{name}: give real {'frequencies in rad/s' if name == 'omega' else 'numbers in SI'}"
        )
    try:
        return np.asarray(given, dtype=float)
    except (TypeError, ValueError):
        raise SceneError(f"{name}: {given!r} must be real numbers") from None


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
