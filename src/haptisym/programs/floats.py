"""A program in floats, as array operations of NumPy, and whether floats can be trusted with it.

``Floats`` runs a program block by block, so that what is computed stays in the cache, into buffers
made once. ``judge`` bounds the magnitude of every step from those of the inputs: where all bounds
lie within the exponents of a float, no step overflows or loses digits to underflow. Its bounds are
powers of two, each rounded to the careful side. sin x/x and its slopes are here too, accurate to
some roundings also where x is small.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache, cached_property
from math import factorial, frexp, inf, isfinite, prod, sqrt
from typing import Any, NamedTuple

from flint import fmpq
from sympy import Expr, Poly, fraction, together

from haptisym.kernel.arrays import np
from haptisym.kernel.harmonics import staircase
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.rings import omega
from haptisym.programs.program import LAST, SMALL, Operation, Program

_TERMS = [(-1.0) ** k / factorial(2 * k + 1) for k in range(LAST // 2 + 1)]
"""Coefficients of the series of sin x/x, by powers of x^2."""
_NEAR = 1.5  # below it the closed forms of the slopes are differences of nearly equal numbers
_SLOPES = [
    [c * prod(range(2 * k - n + 1, 2 * k + 1)) for k, c in enumerate(_TERMS) if 2 * k >= n]
    for n in range(4)
]
"""Coefficients of the series of sin x/x and three derivatives, those of odd order over x."""


def sinc(x: Any, out: Any = None) -> Any:
    """sin(x)/x, and 1 at 0."""
    with np.errstate(invalid="ignore"):
        return _put(np.where(x == 0, 1.0, np.sin(x) / x), out)


def sincm1(x: Any, out: Any = None) -> Any:
    """sin(x)/x - 1, by its series while it is small."""
    # ``where`` takes both branches of all points: each is kept within its own range, so that
    # neither divides by 0 nor overflows.
    size = np.abs(x)
    square, far = np.minimum(size, SMALL) ** 2, np.maximum(size, SMALL)
    return _put(
        np.where(size <= SMALL, _horner(_TERMS[1:], square) * square, np.sin(far) / far - 1.0), out
    )


def quantiser(x: Any, out: Any = None) -> Any:
    """The first harmonic of a staircase over the amplitude, by x = q/(2 A) > 0
    (``kernel.harmonics``)."""
    return _put(8 / np.pi * x * staircase(x), out)


def sinc_and_slopes(x: Any) -> tuple[Any, ...]:
    """sin x/x and three derivatives: near 0 by their series, else by x f'' + 2 f' + x f = 0."""
    # Solved for f'', and once differentiated for f''', the equation divides by x at each order.
    is_near = np.abs(x) < _NEAR
    # No quotient below is taken near 0: there ``far`` is a number that is not used.
    far = np.where(is_near, _NEAR, x)
    f = np.sin(far) / far
    df = (np.cos(far) - f) / far
    d2f = -f - 2 * df / far
    d3f = -df - (3 * d2f + f) / far
    values = []
    for n, by_equation in enumerate((f, df, d2f, d3f)):
        # Derivatives of odd order are odd: x times a series in x^2.
        by_series = _horner(_SLOPES[n], x * x) * (x if n % 2 else 1.0)
        values.append(np.where(is_near, by_series, by_equation))
    return tuple(values)


def _horner(row: Sequence[float], x: Any) -> Any:
    """The polynomial with these coefficients, the lowest first."""
    total = np.full_like(x, row[-1])
    # In place: two passes over one array, and no temporary ones.
    for c in row[-2::-1]:
        total *= x
        total += c
    return total


def _put(values: Any, out: Any) -> Any:
    """The values, or ``out`` filled with them: the calling convention of a ufunc."""
    if out is None:
        return values
    out[...] = values
    return out


BLOCK = 8192  # frequencies: a buffer of 64 KiB


@cache
def ufuncs() -> dict[str, Callable[..., Any]]:
    """What computes a step on arrays, by its name."""
    return {
        "add": np.add,
        "sub": np.subtract,
        "mul": np.multiply,
        "div": np.divide,
        "neg": np.negative,
        "abs": np.abs,
        "sqrt": np.sqrt,
        "cos": np.cos,
        "sin": np.sin,
        "sinc": sinc,
        "sincm1": sincm1,
        "asin": np.arcsin,
        # Their third argument is not taken for ``out``.
        "max": lambda x, y, out=None: np.maximum(x, y, out=out),
        "min": lambda x, y, out=None: np.minimum(x, y, out=out),
        "quantiser": quantiser,
        "power": np.power,
    }


_SELDOM = frozenset({"sinc", "sincm1", "quantiser"})
"""Functions of this module, which are no ufuncs of NumPy."""


def nearest(value: Any) -> np.float64:
    """The double nearest to an exact constant of a program."""
    if isinstance(value, fmpq):
        # Python divides integers of any length with one rounding.
        try:
            return np.float64(int(value.p) / int(value.q))
        except OverflowError:
            return np.float64(np.inf if value > 0 else -np.inf)
    return np.float64(float(ExactNumber(value)))


@dataclass(frozen=True)
class Floats:
    """A program in floats, for inputs of which some are single numbers."""

    program: Program

    @cached_property
    def constants(self) -> dict[int, np.float64]:
        """The program's constants, each rounded once."""
        steps = enumerate(self.program.operations)
        return {i: nearest(step.value) for i, step in steps if step.name == "constant"}

    def run(
        self, inputs: Sequence[Any], size: int, out: Sequence[Any], *, watched: bool = False
    ) -> None:
        """Fill the arrays ``out``, one for each result; an input is a float or an array of that
        size.

        ``watched`` : FloatingPointError where the processor says that a step overflowed, or lost
        digits to underflow.
        """
        flag: Any = "raise" if watched else "ignore"
        # 0/0 and division by 0 are no failure here: the caller replaces what is not finite.
        with np.errstate(divide="ignore", invalid="ignore", over=flag, under=flag):
            self.fill(inputs, size, out, watched=watched)

    def fill(
        self, inputs: Sequence[Any], size: int, out: Sequence[Any], *, watched: bool = False
    ) -> None:
        """As ``run``, with warnings as NumPy is set up: for inputs that cause none, as ``judge``
        says."""
        plan = self._plan(tuple([isinstance(x, float) for x in inputs]))
        numbers = plan.numbers(inputs, watched=watched)
        if plan.steps:
            plan.fill(inputs, numbers, size, out)
        # Last, as a result may repeat another one, which is now there.
        for n, x, what, place in plan.others:
            out[n][...] = (
                numbers[x] if what == "number" else inputs[place] if what == "input" else out[place]
            )

    def point(self, inputs: Sequence[float]) -> list[float]:
        """The results for single numbers for which ``judge`` says that all are finite."""
        numbers = self._plan((True,) * len(inputs)).numbers(inputs, watched=False)
        return [numbers[x] for x in self.program.results.values()]

    def _plan(self, numbers: tuple[bool, ...]) -> _Plan:
        """For inputs of which these are single numbers: made once, as it takes longer than a
        thousand frequencies."""
        plan = self._plans.get(numbers)
        if plan is None:
            plan = self._plans[numbers] = _plan(self.program, self.constants, numbers)
        return plan

    @cached_property
    def _plans(self) -> dict[tuple[bool, ...], _Plan]:
        return {}


_Step = tuple[Callable[..., Any], int, int | None, int]
"""A function, the places of its one or two arguments, and the place of its value."""
_Bound = tuple[list[tuple[Callable[..., Any], Sequence[Any]]], list[tuple[list[Any], int, int]]]
"""Functions with their arrays, and where in these lists of arrays those of a call are put."""
_LENGTHS = 8  # of arrays for which a plan keeps buffers


@dataclass(frozen=True)
class _Plan:
    """How a program is run: first what is one number for all frequencies, then the arrays.

    Numbers stand in a list of all operations: ``constants`` has those that are known, ``single``
    are the inputs that are numbers, with their places, and ``alone`` the steps, as functions of
    Python and as those of NumPy. Arrays stand in a longer list: all operations, ``buffers`` arrays,
    then the results. ``held`` has its constants, as arrays without dimensions, which NumPy reads
    soonest; ``read`` are the places of other numbers, ``arrays`` inputs with their places, and
    ``steps`` what is computed.
    ``others`` : results that no step writes, as they are a number, an input or an earlier result.
    ``kept`` : buffers of earlier calls, by their length.
    """

    constants: list[Any]
    single: tuple[tuple[int, int], ...]
    alone: tuple[tuple[_Step, ...], tuple[_Step, ...]]
    held: list[Any]
    read: tuple[int, ...]
    arrays: tuple[tuple[int, int], ...]
    steps: tuple[_Step, ...]
    buffers: int
    others: tuple[tuple[int, int, str, int], ...]
    kept: dict[int, _Bound | None] = field(default_factory=dict)

    def numbers(self, inputs: Sequence[Any], *, watched: bool) -> list[Any]:
        """The values of all steps that are one number; ``watched`` : as in ``Floats.run``."""
        quick, full = self.alone
        try:
            return self._numbers(full if watched else quick, inputs)
        except (ArithmeticError, ValueError):
            if watched:
                raise
            # What Python refuses, as 1/0 and the root of -1, has a value in NumPy.
            return self._numbers(full, inputs)

    def _numbers(self, steps: Sequence[_Step], inputs: Sequence[Any]) -> list[Any]:
        known = self.constants.copy()
        for i, n in self.single:
            known[i] = inputs[n]
        for function, x, y, place in steps:
            known[place] = function(known[x]) if y is None else function(known[x], known[y])
        return known

    def fill(
        self, inputs: Sequence[Any], numbers: Sequence[Any], size: int, out: Sequence[Any]
    ) -> None:
        """Fill the results that are arrays, block by block."""
        arrays = [inputs[n] for _, n in self.arrays]
        given = [*arrays, *[np.array(numbers[i]) for i in self.read], *out]
        if size <= BLOCK:
            self._block(given, size)
            return
        for start in range(0, size, BLOCK):
            part = slice(start, start + BLOCK)
            self._block([x[part] if x.ndim else x for x in given], min(BLOCK, size - start))

    def _block(self, given: Sequence[Any], length: int) -> None:
        # ``pop`` is atomic: what it gives belongs to this call alone, and another thread that asks
        # for this length makes its own.
        steps, slots = self.kept.pop(length, None) or self._bound(length, len(given))
        for place, i, n in slots:
            place[i] = given[n]
        for function, arguments in steps:
            function(*arguments)
        # The arrays of the call are not kept alive.
        for place, i, _ in slots:
            place[i] = None
        if len(self.kept) >= _LENGTHS:
            self.kept.clear()
        self.kept[length] = steps, slots

    def _bound(self, length: int, count: int) -> _Bound:
        """The steps with buffers of that length; ``count`` arrays come with each call."""
        known = [*self.held, *np.empty((self.buffers, length))]
        of_calls = [i for i, _ in self.arrays] + [*self.read]
        # Behind the buffers stand the results.
        results = range(len(known), len(known) + count - len(of_calls))
        place = {i: n for n, i in enumerate([*of_calls, *results])}
        known += [None] * len(results)
        steps: list[tuple[Callable[..., Any], Sequence[Any]]] = []
        slots: list[tuple[list[Any], int, int]] = []
        for function, *places in self.steps:
            used = [i for i in places if i is not None]
            arguments = [known[i] for i in used]
            of_call = [(arguments, n, place[i]) for n, i in enumerate(used) if i in place]
            # A call with a tuple is quicker than one with a list.
            steps.append((function, arguments if of_call else tuple(arguments)))
            slots += of_call
        return steps, slots


def _plan(
    program: Program, constants: Mapping[int, np.float64], are_numbers: Sequence[bool]
) -> _Plan:
    """The plan of a program for inputs of which some ``are_numbers`` for all frequencies."""
    operations, results = program.operations, tuple(program.results.values())
    arrays: list[tuple[int, int]] = []
    single: list[tuple[int, int]] = []
    alone, moving, are_single = [], [], set(constants)
    for i, step in enumerate(operations):
        if step.name == "input":
            is_number = are_numbers[step.arguments[0]]
            (single if is_number else arrays).append((i, step.arguments[0]))
            are_single |= {i} if is_number else set()
        elif step.name != "constant" and all(x in are_single for x in step.arguments):
            alone.append((i, step))
            are_single.add(i)
        elif step.name != "constant":
            moving.append((i, step))
    places, count = _places(moving, operations, results)
    read = {x for _, step in moving for x in step.arguments} & are_single
    others = []
    for n, x in enumerate(results):
        if x in are_single:
            others.append((n, x, "number", 0))
        elif operations[x].name == "input":
            others.append((n, x, "input", operations[x].arguments[0]))
        elif results.index(x) < n:
            others.append((n, x, "result", results.index(x)))
    indices = range(len(operations))
    return _Plan(
        constants=[float(constants[i]) if i in constants else None for i in indices],
        single=tuple(single),
        alone=(_steps(alone, {}, {**ufuncs(), **_PYTHON}), _steps(alone, {}, ufuncs())),
        held=[np.array(constants[i]) if i in constants and i in read else None for i in indices],
        read=tuple(read - set(constants)),
        arrays=tuple(arrays),
        steps=_steps(moving, places, ufuncs()),
        buffers=count,
        others=tuple(others),
    )


_PYTHON: dict[str, Callable[..., Any]] = {
    "add": operator.add,
    "sub": operator.sub,
    "mul": operator.mul,
    "div": operator.truediv,
    "neg": operator.neg,
    "abs": abs,
    "sqrt": sqrt,
}
"""What computes a step on single numbers: the same doubles as NumPy, in a tenth of its time."""


def _steps(
    steps: Sequence[tuple[int, Operation]],
    places: Mapping[int, int],
    functions: Mapping[str, Callable[..., Any]],
) -> tuple[_Step, ...]:
    """The steps with their functions; ``places`` : of values that do not stand at their index."""
    found = []
    for i, step in steps:
        x, *others = (places.get(a, a) for a in step.arguments)
        found.append((functions[step.name], x, others[0] if others else None, places.get(i, i)))
    return tuple(found)


def _places(
    moving: Sequence[tuple[int, Operation]],
    operations: Sequence[Operation],
    results: tuple[int, ...],
) -> tuple[dict[int, int], int]:
    """Where each step is put: behind the places of all operations into as few buffers as will do,
    or into a result."""
    last = _last_uses(operations, results)
    # Reversed, so that of equal results the first one holds the step; the others are copies.
    direct = {x: n for n, x in reversed(list(enumerate(results)))}
    free: list[int] = []
    place: dict[int, int] = {}
    count = 0
    for i, step in moving:
        ended = {x for x in step.arguments if last.get(x) == i and x in place and x not in direct}
        # A ufunc may write over its own argument, element by element; those of ``_SELDOM`` read
        # theirs again after they have begun to write.
        if step.name not in _SELDOM:
            free += [place[x] for x in ended]
        # Results stand behind the buffers, whose number is not known yet: negative until then.
        if i in direct:
            place[i] = -1 - direct[i]
        else:
            if not free:
                free, count = [count], count + 1
            place[i] = free.pop()
        if step.name in _SELDOM:
            free += [place[x] for x in ended]
    size = len(operations)
    return {x: size + (n if n >= 0 else count - 1 - n) for x, n in place.items()}, count


def _last_uses(operations: Sequence[Operation], results: Sequence[int]) -> dict[int, int]:
    """For each step the last one that reads it; results are read after all steps."""
    last = {
        x: i for i, step in enumerate(operations) if step.name != "input" for x in step.arguments
    }
    return {**last, **dict.fromkeys(results, len(operations))}


_SINE = 70.0  # no cosine, and no sine of a double of at least 2^-69, is smaller than 2^-70


class MagnitudeRange(NamedTuple):
    """What is known of a step x at all frequencies: 2^low <= abs(x) <= 2^high where x is not 0;
    ``positive`` : whether x >= 0 is known; ``nonzero`` : whether x is known to be nowhere 0."""

    low: float
    high: float
    positive: bool = False
    nonzero: bool = False


class Judgement(NamedTuple):
    """``safe`` : no step over- or underflows; ``finite`` : nor is there a division by 0, so that
    all results are finite."""

    safe: bool
    finite: bool


def judge(program: Program, inputs: Sequence[Any], digits: int, limit: int) -> Judgement:
    """Whether every step that is not 0 stays between 2^-limit and 2^limit, in arithmetic with that
    many binary digits.

    >>> from sympy import Symbol
    >>> from haptisym.programs.program import Writer
    >>> x = Symbol("x")
    >>> write = Writer((x,))
    >>> program = write.program({"y": write.div(write.constant(1), write.power(write.input(x), 3))})
    >>> judge(program, [1e100], 53, 1020)
    Judgement(safe=True, finite=True)
    >>> judge(program, [np.array([0.0, 1.0])], 53, 1020), judge(program, [1e-110], 53, 1020).safe
    (Judgement(safe=True, finite=False), False)
    """
    return judged(program, ranges(inputs), digits, limit)


def ranges(inputs: Sequence[Any]) -> tuple[MagnitudeRange, ...]:
    """The magnitude ranges of inputs, in powers of two, so that inputs of about the same size share
    one judgement."""
    return tuple([_of_number(x) if isinstance(x, float) else _of_array(x) for x in inputs])


def judged(
    program: Program, inputs: Sequence[MagnitudeRange], digits: int, limit: int
) -> Judgement:
    """As ``judge``, for all inputs within these ranges."""
    known: list[MagnitudeRange] = []
    finite = True
    # A frequency that no step reads has to be finite all the same: at others the answer is
    # not-a-number.
    if inf in (x.high for x in inputs):
        return Judgement(safe=False, finite=False)
    for step in program.operations:
        if step.name == "input":
            known.append(inputs[step.arguments[0]])
        elif step.name == "constant":
            known.append(_of_number(nearest(step.value)))
        else:
            of = [known[x] for x in step.arguments]
            known.append(_step(step.name, step.arguments, of, digits))
            finite = finite and (step.name != "div" or of[1].nonzero)
            # Powers with exponents that are no whole numbers, and roots, are numbers from 0 on.
            finite = finite and (step.name not in ("power", "sqrt") or of[0].positive)
        if not (known[-1].low > -limit and known[-1].high < limit):
            return Judgement(safe=False, finite=False)
    return Judgement(safe=True, finite=finite)


def _of_number(x: float) -> MagnitudeRange:
    if not isfinite(x):
        return MagnitudeRange(-inf, inf)
    if x == 0:
        return MagnitudeRange(0.0, 0.0, positive=True)
    exponent = frexp(x)[1]
    return MagnitudeRange(exponent - 1.0, float(exponent), x > 0, nonzero=True)


def _of_array(x: Any) -> MagnitudeRange:
    """The range of given numbers; where all are 0, that of 1."""
    if not x.size:
        return MagnitudeRange(0.0, 0.0, positive=True)
    # In half the time of ``min`` and ``max``; the place of a not-a-number is found by both.
    least, most = x.item(x.argmin()), x.item(x.argmax())
    if not (isfinite(least) and isfinite(most)):
        return MagnitudeRange(-inf, inf)
    low, high = least, most
    # The smallest magnitude that is not 0 takes a pass of its own, unless all are positive.
    if least <= 0:
        low, high = float(np.min(np.abs(x), where=x != 0, initial=inf)), max(most, -least)
    if low == inf:
        return MagnitudeRange(0.0, 0.0, positive=True)
    # frexp gives x = f 2^e with 1/2 <= f < 1, so that 2^(e - 1) <= x < 2^e.
    return MagnitudeRange(
        frexp(low)[1] - 1.0, float(frexp(high)[1]), least >= 0, least > 0 or most < 0
    )


def _step(
    name: str, arguments: Sequence[int], of: Sequence[MagnitudeRange], digits: int
) -> MagnitudeRange:
    """The range of a step from those of its arguments; a power of two more or less covers the
    rounding of the step itself."""
    x = of[0]
    if name in ("neg", "abs"):
        return x._replace(positive=name == "abs")
    if name == "sqrt":
        return MagnitudeRange(x.low / 2 - 1, x.high / 2 + 1, positive=True, nonzero=x.nonzero)
    # sin x is about x where x is small, and sin x/x is divided by an x that may be large.
    if name in ("sin", "cos", "sinc"):
        sine, sinc_ = min(-_SINE, x.low - 1), -_SINE - max(x.high, 0.0)
        return MagnitudeRange({"sin": sine, "cos": -_SINE, "sinc": sinc_}[name], 0.0)
    if name == "sincm1":  # between -x^2/6 and -x^2/8 for abs(x) <= 2, between -5/4 and -1/2 beyond
        return MagnitudeRange(min(2 * x.low - 3, -1.0), min(2 * x.high - 2, 1.0), nonzero=x.nonzero)
    if name == "asin":  # between x and pi x/2
        return x._replace(high=x.high + 1)
    if name == "quantiser":  # 8 x/pi sqrt(1 - x^2), which is not 0, with one step; near 1 with more
        return MagnitudeRange(min(x.low, 0.0) - digits, 1.0, positive=True)
    y = of[1]
    both = x.nonzero and y.nonzero
    if name in ("max", "min"):
        positive = x.positive and y.positive
        return MagnitudeRange(min(x.low, y.low), max(x.high, y.high), positive, both)
    if name == "mul":
        is_square = arguments[0] == arguments[1]
        positive = (x.positive and y.positive) or is_square
        return MagnitudeRange(x.low + y.low, x.high + y.high, positive, both)
    if name == "div":
        return MagnitudeRange(
            x.low - y.high - 1, x.high - y.low + 1, x.positive and y.positive, x.nonzero
        )
    if name == "power":
        if not _is_of_root(y):
            return MagnitudeRange(-inf, inf)
        return MagnitudeRange(min(x.low, 0.0), max(x.high, 0.0), positive=True, nonzero=x.nonzero)
    # Nothing cancels between numbers >= 0. Otherwise a sum of two floats is a multiple of the last
    # place of the smaller one: where it is not 0 it is no smaller than that.
    if name == "add" and x.positive and y.positive:
        return MagnitudeRange(
            min(x.low, y.low),
            max(x.high, y.high) + 1,
            positive=True,
            nonzero=x.nonzero or y.nonzero,
        )
    return MagnitudeRange(min(x.low, y.low) - digits - 1, max(x.high, y.high) + 1)


def _is_of_root(exponent: MagnitudeRange) -> bool:
    """Whether an exponent is known to lie between 0 and 1, so that its power lies between 1 and the
    base. Any other takes a base of no great size out of the range of floats."""
    return exponent.positive and exponent.high <= 0


def floats_of(x: Expr, at: Any) -> Any:
    """The floats of a number, or of a rational function of omega at frequencies in rad/s."""
    if not x.has(omega):
        return float(x)
    above, below = (
        np.array([float(c) for c in Poly(p, omega).all_coeffs()]) for p in fraction(together(x))
    )
    return np.polyval(above, at) / np.polyval(below, at)
