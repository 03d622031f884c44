"""The two-step evaluation of a measured scene, at the measured frequencies alone. Measured, never certified."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from math import isfinite
from typing import Any, ClassVar, NamedTuple

import numpy as np

from haptisym.judge.answers import Answer
from haptisym.judge.percepts import Change, Property
from haptisym.kernel.errors import SceneError
from haptisym.kernel.shown import counted, titled
from haptisym.model.jnd import Part
from haptisym.model.measured import Reals
from haptisym.model.measuredscene import MeasuredScene
from haptisym.verbs.measured.between import Between, between
from haptisym.verbs.measured.judging import CODES, Judged, Lines, Signs, Verdict, judged, lines_of, signs
from haptisym.verbs.measured.needed import Needed, needed
from haptisym.verbs.measured.regions import ends_of
from haptisym.verbs.measured.rowtext import listed, row_texts


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
