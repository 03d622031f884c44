"""The two-step evaluation of a measured scene, at the measured frequencies alone.

What would resolve the open lines: the coherence, the number of averages or the radius at which their discs decide.

The rows of a document with a million lines as text, a table of characters at once: every number reads back as itself.

The two-step evaluation of a measured scene, at the measured frequencies alone. Measured, never certified.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import isfinite
from typing import Any, ClassVar, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from haptisym.judge.answers import Answer
from haptisym.judge.percepts import Change, Property
from haptisym.kernel.errors import SceneError
from haptisym.kernel.shown import counted, titled
from haptisym.model.jnd import Part
from haptisym.model.measured import Measurement, Reals, averages_for, coherence_for
from haptisym.model.measuredscene import MeasuredScene
from haptisym.verbs.measured.between import Between, between
from haptisym.verbs.measured.judging import CODES, Judged, Lines, Signs, Verdict, ends_of, judged, lines_of, signs

MOST_AVERAGES = 1e6
"""More than anyone takes: a line that would need more lies at its threshold, as far as measuring goes."""

MOST_COHERENCE = 1 - 1e-6
"""More than any bench gives."""


@dataclass(frozen=True)
class Share:
    """What resolves half of the open lines, and all of them; None where nothing sensible does."""

    half: float | None
    all: float | None

    def row(self) -> dict[str, Any]:
        """As a document has it."""
        return {"half": self.half, "all": self.all}


@dataclass(frozen=True)
class Needed:
    """What would resolve open lines if the estimates stay where they are, each quantity alone, the others as they are.

    ``radius`` : at most, relative to ``|H_env|``. ``coherence``, ``averages`` : at least; None where the discs do not come from
    them, or not from them alone.
    """

    lines: int
    radius: Share
    coherence: Share | None
    averages: Share | None


def needed(x: Lines, found: Sequence[Judged]) -> Needed | None:
    """Of the lines that are open in some judgement; None if none is."""
    open_lines = np.any([one.verdict == 0 for one in found], axis=0)
    if not open_lines.any():
        return None
    margins = [np.where(one.verdict == 0, np.abs(one.distance), np.inf) for one in found]
    margin = np.min(margins, axis=0)[open_lines]
    felt, own = x.felt, x.own
    coherence = averages = None
    if felt.coherence is not None and (own is None or own.discs is None):
        coherence, averages = _of_coherence(felt, x, margin, open_lines)
    return Needed(int(open_lines.sum()), _shares(-margin, negated=True), coherence, averages)


def _of_coherence(felt: Measurement, x: Lines, margin: Reals, at: Any) -> tuple[Share, Share]:
    assert felt.averages is not None
    with np.errstate(divide="ignore", invalid="ignore"):
        relative = margin * np.abs(x.environment[at]) / np.abs(x.perceived[at])
    coherence = coherence_for(relative, felt.averages, felt.confidence)
    averages = averages_for(relative, felt.coherence[at], felt.confidence)
    return _shares(coherence, most=MOST_COHERENCE), _shares(averages, most=MOST_AVERAGES)


def _shares(values: Reals, *, most: float = np.inf, negated: bool = False) -> Share:
    """The value that is enough for at least half of the lines, and for all; None for one above ``most``."""
    row, middle = np.nan_to_num(values, nan=np.inf), (len(values) - 1) // 2
    found = (
        float(np.partition(row, middle)[middle]),
        float(row.max()),
    )  # as sorting all would give, in a fourth of the time
    half, every = (None if value > most or not np.isfinite(value) else -value if negated else value for value in found)
    return Share(half, every)


Letters: TypeAlias = NDArray[np.uint8]

_TOGETHER = 20_000
"""Rows that are written at once: a table of all would need as much memory as the document."""
_FEW = 1000
"""Up to so many lines numbers are the shortest that read back; more have 17 digits, which takes a tenth of the time."""
_EXACT = 10.0 ** np.arange(23)
"""Powers of ten that floats hold exactly."""
_LEAST = -6
_DECADES = 10.0 ** np.arange(_LEAST, 17)
"""Between which numbers are written by their digits; a product with a power of ``_EXACT`` is then a whole number of 17."""
_SPLIT = 134217729.0
_FOUR = np.frombuffer("".join(f"{i:04}" for i in range(10_000)).encode(), np.uint32)
"""Four digits as one number of 32 bits."""
_EXPONENTS = np.frombuffer("".join(f"e{i:+03}" for i in range(_LEAST, 17)).encode(), np.uint32)


def row_texts(
    columns: Sequence[tuple[str, Reals | None]], kinds: Any, end: Callable[[int], str], between: str
) -> Iterator[str]:
    """Rows, many at once, with ``between`` after each: ``columns`` by name, None for null, and what ends a row.

    ``kinds`` : a number for each line; ``end`` : of the first line of a kind what all of that kind end with.

    >>> columns = [("omega", np.array([1, 0.25])), ("radius", None)]
    >>> list(row_texts(columns, np.array([7, 7]), lambda line: '"real": "below"', "; "))
    ['{"omega":  1.0, "radius": null, "real": "below"}; {"omega": 0.25, "radius": null, "real": "below"}; ']
    """
    names, first, own = np.unique(kinds, return_index=True, return_inverse=True)
    told = {name: end(int(line)) for name, line in zip(names.tolist(), first.tolist(), strict=True)}
    ends, last = _left([f", {x}" for x in told.values()]), _left([f"}}{between}"])
    for start in range(0, len(own), _TOGETHER):
        some = slice(start, start + _TOGETHER)
        parts: list[Letters] = []
        for i, (name, row) in enumerate(columns):
            label = f"{', ' if i else '{'}{json.dumps(name)}: "
            parts += [_left([label]), _left(["null"]) if row is None else numerals(row[some], few=len(own) <= _FEW)]
        yield _joined([*parts, ends[own[some]], last], len(own[some]))


def _left(texts: Sequence[str]) -> Letters:
    """A table of texts, a row each; spaces fill it."""
    width = max(map(len, texts), default=0)
    return np.frombuffer("".join(x.ljust(width) for x in texts).encode("ascii"), np.uint8).reshape(len(texts), width)


def _joined(parts: Sequence[Letters], count: int) -> str:
    """Tables side by side, one row after the other."""
    whole = np.empty((count, sum(x.shape[1] for x in parts)), np.uint8)
    at = 0
    for x in parts:
        whole[:, at : at + x.shape[1]] = x
        at += x.shape[1]
    return whole.tobytes().decode("ascii")


def numerals(x: Reals, *, few: bool) -> Letters:
    """Numbers as text, a row each, null for what is not finite.

    >>> [bytes(row).decode() for row in numerals(np.array([0.1, 1 / 3, np.inf]), few=False)]
    ['1.0000000000000000e-01', '3.3333333333333331e-01', '                  null']
    """
    x = np.asarray(x, dtype=float)
    if few:
        texts = [repr(v) if np.isfinite(v) else "null" for v in x.tolist()]
        width = max(map(len, texts), default=0)
        return _left([t.rjust(width) for t in texts])
    plain = (x == 0) | ((x >= _DECADES[0]) & (x < _DECADES[-1]))
    found = _by_digits(np.where(plain, x, 0.0))
    if not plain.all():
        others = numerals(x[~plain], few=True)
        wide = max(found.shape[1], others.shape[1])
        found, others = (np.pad(t, ((0, 0), (wide - t.shape[1], 0)), constant_values=ord(" ")) for t in (found, others))
        found[~plain] = others
    return found


def _by_digits(x: Reals) -> Letters:
    """``d.dddddddddddddddde+dd`` of numbers from 10^-6 to 10^16, and of 0; 17 digits, the nearest, 15 where they read back."""
    decade = np.where(x == 0, -_LEAST, np.searchsorted(_DECADES, x, "right") - 1)
    shift = 16 - _LEAST - decade
    digits = _product(x, _EXACT[shift])
    short = (digits + 50) // 100
    digits = np.where(short / _EXACT[np.maximum(shift - 2, 0)] == x, np.where(shift >= 2, 100 * short, digits), digits)
    found = np.empty((len(x), 22), np.uint8)
    fours = [np.ndarray(len(x), np.uint32, found, at, (22,)) for at in (2, 6, 10, 14, 18)]  # columns of four letters
    fours.pop()[:] = _EXPONENTS.take(decade)
    while fours:
        above = digits // 10_000
        fours.pop()[:] = _FOUR.take(digits - 10_000 * above)
        digits = above
    found[:, 0], found[:, 1] = digits + ord("0"), ord(".")
    return found


def _product(x: Reals, power: Reals) -> Any:
    """The whole number nearest to a product from 10^16 to 10^17: its float, which is whole, and what that lacks (Dekker)."""
    found = x * power
    (a, b), (c, d) = _halves(x), _halves(power)
    return found.astype(np.int64) + np.rint(((a * c - found) + a * d + b * c) + b * d).astype(np.int64)


def _halves(x: Reals) -> tuple[Reals, Reals]:
    high = _SPLIT * x - (_SPLIT * x - x)
    return high, x - high


def listed(rows: Iterator[str], between: str) -> Iterator[str]:
    """A list, in parts, of rows that end with ``between``; what is after the last is left out.

    >>> "".join(listed(iter(["1,2,", "3,"]), ",")), "".join(listed(iter([]), ","))
    ('[\\n    1,2,3\\n  ]', '[]')
    """
    last = None
    for part in rows:
        yield "[\n    " if last is None else last
        last = part
    yield "[]" if last is None else f"{last.removesuffix(between)}\n  ]"


class Row(NamedTuple):
    """What is said of one line. ``radius`` : of the disc around the change, relative to ``|H_env|``; None where none is known."""

    omega: float
    ratio_real: float
    ratio_imag: float
    radius: float | None
    real: Verdict
    imag: Verdict
    joint: Verdict | None = None


class MeasuredPercept(NamedTuple):
    """What is felt of a part at one line, as far as the discs decide it.

    ``part`` : None where both are noticed together, neither by itself; ``property`` and ``change`` are then of the part that lies
    nearer its own limit, and ``other`` is how the other one has changed.
    """

    part: Part | None
    omega: float
    property: Property
    change: Change
    other: tuple[Property, Change] | None = None


@dataclass(frozen=True, eq=False, repr=False)
class MeasuredEvaluation(Answer):
    """What the measured lines say, line by line; between them nothing but by a bound on the slope, and nothing is certified.

    ``lines`` : the numbers. ``distance`` : of each part's ratio from its threshold, positive outside. ``verdict`` : of each part
    by itself 1 where the whole disc exceeds the threshold, -1 where the whole disc is below, 0 where the disc does not tell;
    ``joint`` : the same of both together, where the region judges them so.
    ``signs`` : what step 2 is told by. ``rows``, ``percepts`` : the same as values.
    """

    _schema: ClassVar[str] = "haptisym.measured/1"
    _page: ClassVar[str] = "haptisym.pages.measured:page"
    _figure: ClassVar[str] = "haptisym.figures.measured:measured_figure"

    scene: MeasuredScene
    lines: Lines
    distance: Mapping[Part, Reals]
    verdict: Mapping[Part, Any]
    joint: Judged | None
    signs: Mapping[Part, Signs]
    needed: Needed | None

    def _line(self) -> str:
        told = [f"{int((self.verdict[part] == code).sum())} {x.value}" for part in Part for code, x in CODES.items()]
        lines = counted(len(self), "line")
        return f"{titled(self.scene.title)}: {lines}, real {', '.join(told[:3])}, imaginary {', '.join(told[3:])}"

    def __len__(self) -> int:
        return len(self.lines.omega)

    @cached_property
    def between(self) -> Between | None:
        """What is told between the lines; None without a bound on the slope."""
        return between(self.scene, self.lines)

    @property
    def certified(self) -> bool:
        """False: what is measured is not proven."""
        return False

    @property
    def left_out(self) -> int:
        """Lines of the perceived response that are not judged: off the band, or without a line of the environment."""
        return len(self.scene.perceived) - len(self)

    @cached_property
    def rows(self) -> tuple[Row, ...]:
        """Every line that is judged."""
        return tuple(self._rows())

    def _rows(self) -> Iterator[Row]:
        x = self.lines
        radius = [None] * len(self) if x.radius is None else x.radius.tolist()
        ratios = np.abs(x.change.real).tolist(), np.abs(x.change.imag).tolist()
        codes = [self.verdict[part] for part in Part] + ([self.joint.verdict] if self.joint else [])
        told = ((CODES[code] for code in row.tolist()) for row in codes)
        yield from map(Row, x.omega.tolist(), *ratios, radius, *told)

    def noticed(self, part: Part | None) -> Any:
        """Where step 2 asks how a part is felt, or None for both together, which neither is by itself."""
        if self.joint is None:
            return self.verdict[part] == 1 if part else np.zeros(len(self), dtype=bool)
        alone = [self.verdict[x] for x in Part]
        own = self.verdict[part] == 1 if part else (alone[0] == -1) & (alone[1] == -1)
        return (self.joint.verdict == 1) & own

    def named(self, part: Part | None) -> Any:
        """Where a property is named: the part is noticed, and its disc tells what it is felt as."""
        asked = Part if part is None else (part,)
        known = np.all([self.signs[x].known for x in asked], axis=0)
        active = self.signs[Part.IMAG].perceived < 0  # there the model has no name
        return self.noticed(part) & known & ~(active if part is not Part.REAL else False)

    @cached_property
    def percepts(self) -> tuple[MeasuredPercept, ...]:
        """What is felt, at each line where the discs decide it."""
        wanted = (*Part, None)
        return tuple(self._percept(part, i) for part in wanted for i in np.flatnonzero(self.named(part)).tolist())

    def order(self, line: int) -> list[Part]:
        """Both parts, the one that lies nearer its own limit last, as estimated."""
        return [Part.IMAG, Part.REAL] if self.real_nearer[line] else [Part.REAL, Part.IMAG]

    @cached_property
    def real_nearer(self) -> Any:
        """At which lines the real part's change is a larger share of its own limit than the imaginary part's."""
        x = self.lines
        sides = {Part.REAL: x.change.real, Part.IMAG: x.change.imag}
        ends = {part: ends_of(self.scene.threshold, part, x.omega) for part in Part}
        real, imag = (np.maximum(side / ends[part][1], side / ends[part][0]) for part, side in sides.items())
        return real > imag

    def _percept(self, part: Part | None, i: int) -> MeasuredPercept:
        omega = float(self.lines.omega[i])
        if part is not None:
            return MeasuredPercept(part, omega, *self.signs[part].label(part, i))
        far, near = self.order(i)
        return MeasuredPercept(None, omega, *self.signs[near].label(near, i), self.signs[far].label(far, i))

    def _body(self) -> dict[str, Any]:
        return self._told([_row(x) for x in self._rows()], [_percept(p) for p in self.percepts])

    def _told(self, rows: Any, percepts: Any) -> dict[str, Any]:
        felt = self.scene.perceived
        return {
            "lines": len(self),
            "left_out": self.left_out,
            "threshold": self.scene.threshold.row(),
            "averages": felt.averages,
            **({} if felt.welch is None else {"estimate": felt.welch.row()}),
            "confidence": None if self.lines.radius is None else felt.confidence,
            "rows": rows,
            "percepts": percepts,
            **({} if self.between is None else {"between": self.between.row(self.scene.slopes)}),
            "needed": None if self.needed is None else _needed(self.needed),
            "certified": self.certified,
        }

    def to_json(self) -> str:
        """As text, one line for each measured line."""
        return "".join(self.json_parts())

    def json_parts(self) -> Iterator[str]:
        """The same in parts: a million lines make a quarter of a gigabyte."""
        long = {"rows": self._row_texts, "percepts": self._percept_texts}
        frame = {"schema": self._schema, "title": self.scene.title} | self._told(None, None) | self.scene.aside_keys()
        for i, (key, x) in enumerate(frame.items()):
            yield f"{',' if i else '{'}\n  {json.dumps(key)}: "
            yield from listed(long[key](), _BETWEEN) if key in long else (_short(x),)
        yield "\n}"

    def _row_texts(self) -> Iterator[str]:
        x = self.lines
        numbers = {
            "omega": x.omega,
            "ratio_real": np.abs(x.change.real),
            "ratio_imag": np.abs(x.change.imag),
            "radius": x.radius,
        }
        codes = {part.value: self.verdict[part] for part in Part} | (
            {"joint": self.joint.verdict} if self.joint else {}
        )
        kinds = np.zeros(len(self), dtype=int)
        for own in codes.values():
            kinds = 3 * kinds + own
        return row_texts(
            list(numbers.items()),
            kinds,
            lambda i: _inside({k: CODES[int(x[i])].value for k, x in codes.items()}),
            _BETWEEN,
        )

    def _percept_texts(self) -> Iterator[str]:
        for part in (*Part, None):
            lines = np.flatnonzero(self.named(part))
            if len(lines):
                yield from self._felt_alike(part, lines)

    def _felt_alike(self, part: Part | None, lines: Any) -> Iterator[str]:
        def end(i: int) -> str:
            told = _percept(self._percept(part, int(lines[i])))
            return _inside({key: x for key, x in told.items() if key != "omega"})

        return row_texts([("omega", self.lines.omega[lines])], self.kinds(part)[lines], end, _BETWEEN)

    def kinds(self, part: Part | None) -> Any:
        """A number for each line: the same where a part, or None for both together, is felt alike."""
        found = np.zeros(len(self), dtype=int)
        for x in Part if part is None else (part,):
            own = self.signs[x]
            found = 1000 * found + 27 + 9 * own.environment + 3 * own.perceived + own.compared
        return found if part else 2 * found + self.real_nearer


_BETWEEN = ",\n    "
"""Two rows of a list in JSON."""


def _inside(told: Mapping[str, Any]) -> str:
    """Keys and values without the braces."""
    return json.dumps(told)[1:-1]


def _short(value: Any) -> str:
    return json.dumps(value, indent=2, ensure_ascii=False).replace("\n", "\n  ")


def _percept(p: MeasuredPercept) -> dict[str, Any]:
    if p.part is None and p.other:
        felt: Any = [p.other[0].value, p.property.value], [p.other[1].value, p.change.value]
    else:
        felt = p.property.value, p.change.value
    return {"part": p.part.value if p.part else "joint", "omega": p.omega, "property": felt[0], "change": felt[1]}


def _row(x: Row) -> dict[str, Any]:
    numbers = {"ratio_real": x.ratio_real, "ratio_imag": x.ratio_imag, "radius": x.radius}
    finite = {key: value if value is not None and isfinite(value) else None for key, value in numbers.items()}
    return {"omega": x.omega, **finite, "real": x.real.value, "imag": x.imag.value} | (
        {} if x.joint is None else {"joint": x.joint.value}
    )


def _needed(x: Needed) -> dict[str, Any]:
    shares = {"radius": x.radius, "coherence": x.coherence, "averages": x.averages}
    return {"lines": x.lines} | {key: share.row() for key, share in shares.items() if share is not None}


def judge(scene: MeasuredScene) -> MeasuredEvaluation:
    """Judge every measured line of a scene on its band. SceneError where there is none.

    >>> from haptisym import environments
    >>> from haptisym.model.measuring import measured
    >>> felt = measured([2, 8], [92.8 + 30j, -30 + 120j], radius=[2, 2])
    >>> found = judge(MeasuredScene(environments.mass_spring_damper(1.8, 15, 100), felt))
    >>> [(x.real.value, x.imag.value) for x in found.rows]
    [('below', 'below'), ('exceeds', 'below')]
    """
    if not isinstance(scene, MeasuredScene):
        raise SceneError(
            f"{type(scene).__name__} is not a measured scene: make one with MeasuredScene(environment, perceived)"
        )
    x = lines_of(scene)
    alone = {part: one for part in Part if (one := judged(scene, x, part))}
    joint = judged(scene, x, None)
    distance, found = ({part: getattr(one, key) for part, one in alone.items()} for key in ("distance", "verdict"))
    told = {part: signs(x, part) for part in Part}
    return MeasuredEvaluation(
        scene, x, distance, found, joint, told, needed(x, [joint] if joint else list(alone.values()))
    )
