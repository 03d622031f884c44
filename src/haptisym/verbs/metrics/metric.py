"""The measures of transparency: the exact functions that they are read off, their closed forms,
charts and rows.

A chain of effects is one two-port [F_h; X_h] = [[A, B], [C, D]] [F_e; X_e]: what a display does to
any environment (``TwoPort``). From its entries follow what is felt of nothing and of a rigid
environment, sensitivity, and Llewellyn's criterion of absolute stability, whose conditions on the
axis and on the poles are tested at all frequencies (``Unconditional``). The other criteria of the
field compare H_perc with H_env: the 3 dB edges and relative distortion. Passivity of a display is
in ``haptisym.judge.passivity``. What is shown is collected in ``Measured``.
Derivation: 15_metrics.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from pkgutil import resolve_name
from typing import Any, ClassVar, TypeAlias

from sympy import Expr, Integer, Rational, sqrt

from haptisym.judge.answers import Answer
from haptisym.judge.bounds import around
from haptisym.judge.crossings import PASSIVE, Criterion, kept
from haptisym.judge.evaluation import Evaluation
from haptisym.judge.passivity import (
    Beyond,
    Passivity,
    has_advance,
    has_no_pole_right,
    most_charted,
    poles_allow,
)
from haptisym.judge.peaks import ValueAt
from haptisym.kernel.asymptoticsign import Sense, asymptotic_sign
from haptisym.kernel.dynamics import RealFunction, Ring, on_axis, squared_modulus
from haptisym.kernel.errors import SceneError, UndecidedError, meant
from haptisym.kernel.objects import Shown, counted, titled
from haptisym.kernel.reals import ExactNumber, RealNumber, short
from haptisym.kernel.rings import Polynomial, RationalFunction, cleared, omega
from haptisym.kernel.roots import Chart, Interval, Point, chart, sign_of_number
from haptisym.model.distortion import Distortion
from haptisym.model.quantities import MotionKind
from haptisym.model.scene import Scene, clocks
from haptisym.verbs.metrics.freeresponse import FlightRule, FreeResponse, free_response


@dataclass(frozen=True)
class TwoPort:
    """A display as a two-port: the chain matrix ``[F_h; X_h] = [[A, B], [C, D]] [F_e; X_e]``, known
    up to a factor.

    What is read off it does not see that factor: quotients of entries, and det over a product of
    two entries.
    """

    d: Distortion

    @property
    def ring(self) -> Ring:
        """The ring that all its functions are of."""
        ring = self.d.env.ring
        assert isinstance(ring, Ring)
        return ring

    @cached_property
    def _entries(self) -> tuple[Polynomial, Polynomial, Polynomial, Polynomial]:
        """The product of the chain's matrices, the one nearest the environment applied first."""
        # Each matrix is multiplied by its common denominator: entries stay polynomials, and the
        # factor cancels in all that is read off.
        a, b, c, d = (self.ring.constant(n) for n in (1, 0, 0, 1))
        for matrix in self.d.chain.matrices:
            p, q, r, t = cleared([self.ring.convert(entry) for entry in matrix])
            a, b, c, d = p * a + q * c, p * b + q * d, r * a + t * c, r * b + t * d
        return a, b, c, d

    @cached_property
    def _det(self) -> Polynomial:
        a, b, c, d = self._entries
        return a * d - b * c

    def _over(self, top: Polynomial, bottom: Polynomial) -> RationalFunction | None:
        """Return a quotient in lowest terms; None where it is infinite everywhere."""
        return None if bottom.is_zero() else self.ring.function(top, bottom).reduced()

    @property
    def least(self) -> RationalFunction | None:
        """Z_min = B/D, what is felt of no environment at all (H_env -> 0); None where that is
        infinite everywhere."""
        return self._over(self._entries[1], self._entries[3])

    @property
    def most(self) -> RationalFunction | None:
        """Z_max = A/C, what is felt of a rigid one (H_env -> infinity); None where nothing bounds
        it."""
        return self._over(self._entries[0], self._entries[2])

    @property
    def width(self) -> RationalFunction | None:
        """Z_width = Z_max - Z_min = det/(C D); None where nothing bounds it."""
        return self._over(self._det, self._entries[2] * self._entries[3])

    @property
    def gain(self) -> RationalFunction | None:
        """g = det/D^2 = -h12 h21."""
        return self._over(self._det, self._entries[3] ** 2)

    @property
    def leak(self) -> RationalFunction | None:
        """C/D = h22."""
        return self._over(self._entries[2], self._entries[3])

    @property
    def sensitivity(self) -> RationalFunction | None:
        """dH_perc/dH_env = det/(C H + D)^2 of the Moebius map, H being the environment (or what is
        rendered)."""
        H = self.ring.convert(self.d.chain.rendered).reduced()
        # H = N/D_H: numerator and denominator are both taken times D_H^2, so that all stay
        # polynomials.
        below = self._entries[2] * H.numerator + self._entries[3] * H.denominator
        return self._over(self._det * H.denominator**2, below**2)


MOST_SYMBOLS = 8
"""Parameters that a formula in symbols may have; with more it would fill pages."""

Function: TypeAlias = RationalFunction | RealFunction


@dataclass(frozen=True, repr=False)
class Form(Shown):
    """A closed form with its name, a function of s or of omega."""

    name: str
    numbers: TwoPort
    symbols: TwoPort | None

    def _line(self) -> str:
        return f"{self.name} = {self.value}"

    @cached_property
    def symbolic(self) -> Function | None:
        """The form in the scene's symbols; None with too many of them, and where there is none
        (a division by 0)."""
        return None if self.symbols is None else _FORMS[self.name](self.symbols)

    @cached_property
    def numeric(self) -> Function | None:
        """The form in the scene's numbers; None where there is none."""
        return _FORMS[self.name](self.numbers)

    @property
    def value(self) -> Expr | None:
        """The form as an expression: in symbols if there is one, else in numbers."""
        found = self.symbolic or self.numeric
        return None if found is None else found.factored()


def _mass(x: TwoPort) -> RealFunction:
    """Return the effective mass -Re H_perc/omega^2."""
    real = on_axis(x.d.perc).real
    return RealFunction((-real.function / real.axis.convert(omega**2)).reduced())


def _damping(x: TwoPort) -> RealFunction:
    """Return the effective damping Im H_perc/omega."""
    imag = on_axis(x.d.perc).imag
    return RealFunction((imag.function / imag.axis.convert(omega)).reduced())


_FORMS: dict[str, Callable[[TwoPort], Function | None]] = {
    "Gamma": lambda x: (x.d.perc / x.d.env).reduced(),
    "Theta": lambda x: (x.d.difference / x.d.env).reduced(),
    "Z_min": lambda x: x.least,
    "Z_max": lambda x: x.most,
    "Z_width": lambda x: x.width,
    "dH_perc/dH_env": lambda x: x.sensitivity,
    "g": lambda x: x.gain,
    # Effective stiffness, mass and damping: H_perc as if it were of one of them alone.
    "k_perc": lambda x: on_axis(x.d.perc).real,
    "m_perc": _mass,
    "b_perc": _damping,
}


def ratio_square(d: Distortion) -> RealFunction:
    """Return |H_perc/H_env|^2."""
    return squared_modulus((d.perc / d.env).reduced())


def _below(d: Distortion) -> RealFunction:
    """Return 1/2 - |H_perc/H_env|^2, which is positive where the ratio is more than 3 dB below
    1."""
    square = ratio_square(d)
    return RealFunction(square.axis.convert(Rational(1, 2))) - square


TOO_SMALL = Criterion("-3 dB", "-3 dB", "|H_perc/H_env|", "|H_perc/H_env| >= 1/sqrt(2)", _below)
TOO_LARGE = Criterion(
    "+3 dB",
    "+3 dB",
    "|H_perc/H_env|",
    "|H_perc/H_env| <= sqrt(2)",
    ratio_square,
    threshold=sqrt(Integer(2)),
)
WITHIN_3_DB = (TOO_SMALL, TOO_LARGE)


def relative_square(d: Distortion) -> RealFunction:
    """Return |dH/H_env|^2."""
    return squared_modulus((d.difference / d.env).reduced())


def relative(c: Expr) -> Criterion:
    """Return the criterion |dH/H_env| <= c."""
    return Criterion(
        "relative",
        "relative distortion",
        "|dH/H_env|",
        "|dH/H_env| <= c",
        relative_square,
        threshold=c,
    )


_Hybrid: TypeAlias = Callable[
    [RealFunction, RealFunction, RealFunction, RealFunction], RealFunction
]
"""A condition as a function of Im h11, Im h22, Re g and |g|^2, with g = -h12 h21; positive where it
fails."""


def _read(rule: str, d: Distortion) -> RealFunction:
    """Return the function of a condition of Llewellyn's for a display; SceneError where D = 0."""
    port = TwoPort(d)
    least, leak, gain = port.least, port.leak, port.gain
    if least is None or leak is None or gain is None:
        raise SceneError("the hybrid matrix of this scene does not exist (D = 0)")
    return _CONDITIONS[rule](
        on_axis(least).imag, on_axis(leak).imag, on_axis(gain).real, squared_modulus(gain)
    )


def _lack(
    own: RealFunction, other: RealFunction, real: RealFunction, _: RealFunction
) -> RealFunction:
    """Return -(Re g - 2 Im h11 Im h22), which is positive where the third condition fails."""
    return RealFunction((own * other).function + (own * other).function) - real


# Llewellyn: Re h11 >= 0, Re h22 >= 0 and 2 Re h11 Re h22 >= |h12 h21| + Re(h12 h21), h of velocity.
# With displacement, h11 is over j omega and h22 times j omega: real parts become imaginary ones,
# and Re h11 Re h22 = -Im h11 Im h22. The last condition is |g| <= Re g - 2 Im h11 Im h22: squared,
# so that it is rational, with the sign of the right side as a condition of its own.
_CONDITIONS: Mapping[str, _Hybrid] = {
    "Im h11 >= 0": lambda own, *_: RealFunction(-own.function),
    "Im h22 <= 0": lambda _own, other, *_: other,
    "Re g - 2 Im h11 Im h22 >= 0": _lack,
    "(Re g - 2 Im h11 Im h22)^2 >= |g|^2": lambda *x: x[3] - _lack(*x) * _lack(*x),
}
LLEWELLYN = tuple(
    Criterion(rule, rule, rule.split(" ")[0], rule, partial(_read, rule)) for rule in _CONDITIONS
)
"""Conditions on the axis for absolute stability; those on the poles are others."""


@dataclass(frozen=True)
class Unconditional:
    """Llewellyn's criterion at all frequencies. ``axis`` : whether the conditions hold at every
    frequency. ``poles`` : whether h11, h22 and h12 h21 have none in Re s > 0, and h11 and h22 on
    the axis simple ones with positive residues alone. None where not decided."""

    axis: bool | None
    poles: bool | None

    @property
    def holds(self) -> bool | None:
        """Whether the two-port is absolutely stable: with any passive operator and environment."""
        if self.axis is False or self.poles is False:
            return False
        return True if self.axis and self.poles else None


def _on_axis(d: Distortion, port: TwoPort) -> bool | None:
    """Whether Llewellyn's conditions on the axis hold at every frequency; None where not
    decided."""
    if port.least is None:
        return None
    functions = {x: x.function(d) for x in LLEWELLYN}
    high: Expr = Integer(1)
    try:
        for f in functions.values():
            assert isinstance(f, RealFunction)  # none is about a threshold
            # N D has the sign of N/D. Beyond a radius that sign is known; up to the largest of
            # these radii a chart has all changes of sign.
            product = f.function.numerator * f.function.denominator
            beyond = asymptotic_sign(f.axis.function(product))
            if beyond.sense is Sense.BOTH or (beyond.sense is Sense.POSITIVE and not f.is_zero):
                return False
            if beyond.sense is Sense.UNKNOWN:
                return None
            high = beyond.radius if sign_of_number(beyond.radius - high) > 0 else high
        seen = most_charted(d, high)
        points = chart(functions, Integer(0), seen).points
    except UndecidedError:
        return None
    if any(sign > 0 for p in points for sign in p.after.values()):
        return False
    # Long delays turn so often that only a part is charted: then nothing is known of the rest.
    return None if seen != high or any(p.undecided for p in points) else True


def _poles(port: TwoPort) -> bool | None:
    """Whether h11 = B/(D s), h22 = s C/D and g = -h12 h21 have the poles that absolute stability
    allows; None where not decided."""
    least, leak, gain = port.least, port.leak, port.gain
    if least is None or leak is None or gain is None:
        return None
    s = port.ring.function(port.ring.variable)
    # With a passive environment y the impedance is h11 + g/(h22 + y), and h22 + y grows at most as
    # s: an advance of g is one of the impedance.
    if not gain.is_zero and has_advance(gain):
        return False
    # ``poles_allow`` asks for the poles of F/s: F = B/D for h11, and F = s^2 C/D for h22.
    allowed = (poles_allow(least), poles_allow((leak * s * s).reduced()), has_no_pole_right(gain))
    if False in allowed:
        return False
    return None if None in allowed else True


Bands: TypeAlias = tuple[Interval, ...]
FAR = 100
"""Multiple of the band's end up to which 3 dB edges are searched, where no delay makes infinitely
many."""


@dataclass(frozen=True)
class Measured:
    """The exact functions that the measures are read off, and their charts."""

    evaluation: Evaluation

    @property
    def d(self) -> Distortion:
        """The distortion: what is felt instead of the environment."""
        return self.evaluation.distortion

    @property
    def band(self) -> tuple[Expr, Expr]:
        """The ends of the band, rad/s."""
        low, high = self.evaluation.scene.band
        return low, high

    @cached_property
    def port(self) -> TwoPort:
        """The chain as a two-port."""
        return TwoPort(self.d)

    @cached_property
    def _symbolic(self) -> TwoPort | None:
        scene = self.evaluation.scene
        return (
            TwoPort(Distortion.of(scene.chain)) if len(scene.parameters) <= MOST_SYMBOLS else None
        )

    def forms(self, *names: str) -> tuple[Form, ...]:
        """Return some of the closed forms, by their names."""
        return tuple(Form(name, self.port, self._symbolic) for name in names)

    @cached_property
    def relative(self) -> Criterion | None:
        """|dH/H_env| against the smaller threshold; None where the JND is no number for each
        part."""
        plain = self.evaluation.scene.threshold.is_plain
        return relative(min(x.threshold for x in self.evaluation.criteria)) if plain else None

    @cached_property
    def sensitivity_square(self) -> RealFunction | None:
        """|S|^2 of the change to that of the rendered dynamics; None where the port has none."""
        found = self.port.sensitivity
        return None if found is None else squared_modulus(found)

    @cached_property
    def reach(self) -> Expr:
        """The frequency up to which 3 dB edges are searched, rad/s."""
        return self.band[1] * (1 if self.d.env.ring.functions else FAR)

    @cached_property
    def edges(self) -> Chart:
        """Where the transmitted impedance is 3 dB below and above the environment."""
        return self._chart(WITHIN_3_DB, self.reach)

    def _chart(self, criteria: Iterable[Criterion], high: Expr) -> Chart:
        return chart({x: x.function(self.d) for x in criteria}, self.band[0], high)

    @cached_property
    def _inside(self) -> Chart:
        return self._chart(WITHIN_3_DB, self.band[1])

    @property
    def inside(self) -> Bands:
        """Where it is within 3 dB of the environment's, on the band."""
        return kept(self._inside)

    @cached_property
    def _within(self) -> Chart:
        # Where the JND is a region, the modulus is compared with the largest circle inside it.
        if self.relative:
            return self._chart([self.relative], self.band[1])
        return chart(
            {"": around(self.evaluation.scene.threshold, relative_square(self.d))[0]}, *self.band
        )

    @property
    def within(self) -> Bands:
        """Where |dH/H_env| is at most the smaller threshold, or within the largest circle that the
        region holds."""
        return self._within.where(lambda signs: all(sign <= 0 for sign in signs.values()))

    @cached_property
    def _passive(self) -> Chart:
        return self._chart([PASSIVE], self.band[1])

    @property
    def passive(self) -> Bands:
        """Where on the band Im H_perc >= 0."""
        return kept(self._passive)

    @cached_property
    def _llewellyn(self) -> Chart | None:
        return None if self.port.least is None else self._chart(LLEWELLYN, self.band[1])

    @cached_property
    def unconditional(self) -> Unconditional:
        """What Llewellyn's criterion says at all frequencies, poles included."""
        # The criterion is for linear elements that do not change with time: a clock is none.
        if clocks(self.evaluation.scene):
            return Unconditional(None, None)
        return Unconditional(_on_axis(self.d, self.port), _poles(self.port))

    @property
    def llewellyn(self) -> Bands | None:
        """Where on the band Llewellyn's conditions on the axis hold; None where the hybrid matrix
        does not exist (D = 0)."""
        return None if self._llewellyn is None else kept(self._llewellyn)

    @property
    def certified(self) -> bool:
        """Whether nothing on any chart was left undecided."""
        charts = (self.edges, self._inside, self._within, self._passive, self._llewellyn)
        return self.evaluation.certified and not any(x.undecided for x in charts if x is not None)

    @cached_property
    def effective(self) -> tuple[tuple[RealNumber, dict[str, RealNumber | None]], ...]:
        """Effective stiffness, mass and damping of H_perc at the band's ends and at the crossings;
        None where infinite."""
        response = self.d.perc_response
        axis = response.real.axis
        w = RealFunction(axis.convert(omega))
        minus = RealFunction(axis.convert(Integer(-1)))
        mass = minus * response.real / (w * w)
        properties = {"k": response.real, "m": mass, "b": response.imag / w}
        # On one chart with the excesses, so that at a crossing their zeros and poles are exact.
        excesses = {x: x.function(self.d) for x in self.evaluation.criteria}
        points = chart({**properties, **excesses}, *self.band).points
        ends = (points[0], points[-1])
        rows = []
        for p in points:
            if p in ends or any(p.orders.get(x, 0) > 0 for x in excesses):
                values = {key: value_at(f, p, key) for key, f in properties.items()}
                rows.append((p.omega, values))
        return tuple(rows)

    @cached_property
    def free(self) -> FreeResponse:
        """What the display does when it is let go, as an aeroplane's is judged."""
        return free_response(self.d)

    @cached_property
    def free_of_a_helicopter(self) -> FreeResponse:
        """The same, as a helicopter's is judged."""
        return free_response(self.d, FlightRule.HELICOPTER)

    @property
    def unit(self) -> str:
        """The unit of a dynamic stiffness."""
        return "N m/rad" if self.evaluation.scene.motion is MotionKind.ROTATION else "N/m"

    @property
    def units(self) -> dict[str, str]:
        """The units of stiffness, mass and damping."""
        if self.evaluation.scene.motion is MotionKind.ROTATION:
            return {"k": "N m/rad", "m": "kg m^2", "b": "N m s/rad"}
        return {"k": "N/m", "m": "kg", "b": "N s/m"}


def value_at(f: RealFunction, point: Point, key: object) -> RealNumber | None:
    """The value of a function of a chart at one of its points: 0 at a zero, None at a pole."""
    order = point.orders.get(key, 0)
    if order < 0:
        return None
    return ZERO if order > 0 or f.is_zero else ValueAt(f, point.omega)


ZERO = ExactNumber(Integer(0))


def covers(bands: Bands, table: Chart) -> bool:
    """Whether a set of bands is the whole band of a chart."""
    ends = [table.points[i].omega for i in (0, -1)]
    return len(bands) == 1 and [bands[0].low.omega, bands[0].high.omega] == ends


@dataclass(frozen=True)
class MetricValue:
    """A value of a measure: a number, bands, or a word; None where it is infinite. ``unit`` is
    empty for a ratio.

    Where there is a tolerance: ``reference`` is the environment's own number, ``kept`` whether the
    value is near enough.
    """

    what: str
    value: RealNumber | int | str | Bands | None
    unit: str = ""
    reference: RealNumber | int | None = None
    tolerance: str = ""
    kept: bool = True
    at: RealNumber | None = None
    """The frequency that ``what`` names, as it is known."""


@dataclass(frozen=True, repr=False)
class Metric(Shown):
    """A measure: ``forms`` its closed forms, ``values`` its numbers, ``evidence`` how well
    ``source`` is known to say so."""

    name: str
    forms: tuple[Form, ...]
    values: tuple[MetricValue, ...]
    source: str
    evidence: str
    verdict: str
    at: RealNumber | None = None
    """The frequency that the verdict names, as it is known."""

    def _line(self) -> str:
        return f"{self.name}: {self.verdict}"


@dataclass(frozen=True, repr=False)
class Metrics(Answer):
    """The measures of other authors for a scene, compared with its JND evaluation.

    ``metrics`` : one ``Metric`` for each, with formula, value, unit, verdict and source. ``notes``
    : where their verdicts differ from that of ``evaluation``. ``measured`` : what was computed for
    them. Each metric has whether its number is proven or computed.

    >>> import haptisym as hs
    >>> found = hs.metrics("fu2019")
    >>> found.evaluation.bandwidth
    7.97891679017471
    """

    _schema: ClassVar[str] = "haptisym.metrics/1"
    _page: ClassVar[str] = "haptisym.pages.metrics:page"
    _figure: ClassVar[str] = "haptisym.figures.effects:METRICS"

    evaluation: Evaluation
    metrics: tuple[Metric, ...]
    notes: tuple[str, ...]
    measured: Measured
    tell_absolute: bool = False

    @property
    def told(self) -> tuple[Metric, ...]:
        """The measures that the text output shows: absolute stability, which most displays lack,
        only where it holds or is requested."""
        is_absolute = self["absolute stability"].verdict.startswith("absolutely stable")
        return tuple(
            x
            for x in self.metrics
            if self.tell_absolute or is_absolute or x.name != "absolute stability"
        )

    def _line(self) -> str:
        return f"{titled(self.scene.title)}: {counted(len(self.metrics), 'measure')}"

    @property
    def scene(self) -> Scene:
        """The scene that was evaluated."""
        return self.evaluation.scene

    @property
    def certified(self) -> bool:
        """Whether nothing that a measure is read off was left undecided."""
        return self.decided and self.measured.certified

    @property
    def decided(self) -> bool:
        """Whether every measure was found in time."""
        return not any(x.verdict.startswith("undecided") for x in self.metrics)

    def __getitem__(self, name: str) -> Metric:
        for metric in self.metrics:
            if metric.name == name:
                return metric
        names = [x.name for x in self.metrics]
        raise SceneError(
            f'unknown measure "{name}": {meant(name, names)}valid are {", ".join(names)}'
        )

    def _body(self) -> dict[str, Any]:
        e = self.evaluation
        return {
            "band": [float(e.chart.points[i].omega) for i in (0, -1)],
            "jnd": {
                "threshold": e.scene.threshold.row(),
                "transparent": _pairs(e.transparent),
                "bandwidth": None if e.bandwidth is None else float(e.bandwidth),
            },
            "metrics": [_metric_row(x) for x in self.metrics],
            "notes": list(self.notes),
            **({"caveats": list(e.caveats)} if e.caveats else {}),
            "certified": self.certified,
        }


_FORMULAS = "haptisym.pages.metrics:formulas"
"""The function that writes the formulas of a measure; loaded when they are needed, as pages are of
a higher rank."""


def _metric_row(x: Metric) -> dict[str, Any]:
    return {
        "name": x.name,
        "formula": resolve_name(_FORMULAS)(x),
        "values": [_value_row(v) for v in x.values],
        "unit": next((v.unit for v in x.values), ""),
        "source": x.source,
        "evidence": x.evidence,
        "verdict": x.verdict,
    }


def _value_row(x: MetricValue) -> dict[str, Any]:
    found = {"what": x.what, "value": _plain(x.value), "unit": x.unit}
    if x.reference is None:
        return found
    return {**found, "environment": _plain(x.reference), "tolerance": x.tolerance, "kept": x.kept}


def _plain(value: RealNumber | int | str | Bands | None) -> Any:
    """Return a number, a list of bands, a word, or None for what is infinite, as documents have
    it."""
    if isinstance(value, tuple):
        return _pairs(value)
    return float(value) if isinstance(value, RealNumber) else value


def _pairs(bands: Bands) -> list[list[float]]:
    return [[float(x.low.omega), float(x.high.omega)] for x in bands]


_YES = {True: "yes", False: "no", None: "not decided"}
_ANSWERS = {True: "holds", False: "does not hold", None: "not decided"}


def passivity_measure(m: Measured) -> Metric:
    """Return the measure of passivity: Im H_perc >= 0 on the band and above it, and the damping
    of a hand that compensates what is generated."""
    found = m.evaluation.passivity
    return Metric(
        "passivity",
        (),
        (
            MetricValue("Im H_perc >= 0 on the band", m.passive, "rad/s"),
            *(_values(m, found) if found else ()),
        ),
        "a display is stable with any passive operator exactly if H_perc/s is positive real",
        "per frequency derived (15_metrics); of a sampled display Colgate and Schenkel "
        "(1997), as quoted by Weir and "
        "Colgate: read",
        _verdict(m, found),
        found.active[0].low.omega if found and found.active else None,
    )


def _values(m: Measured, found: Passivity) -> list[MetricValue]:
    """Return the rows of passivity beyond the band: where, how much, and what compensates it."""
    high = ExactNumber(found.high)
    rows = [
        MetricValue(
            f"Im H_perc < 0, searched up to {short(high)} rad/s", found.active, "rad/s", at=high
        )
    ]
    rows += [MetricValue("Im H_perc beyond that", found.beyond.value)]
    if (given := found.most_given) and found.active:
        where = f" at {short(given.omega)} rad/s" if given.omega else ""
        rows += [
            MetricValue(
                f"most energy given per cycle, over π A²{where}",
                given.value,
                m.unit,
                at=given.omega,
            )
        ]
    untold = found.holds is None and found.beyond is Beyond.CLOCK
    rows += [
        MetricValue(
            "any passive operator",
            "undecided for a sampled display" if untold else _ANSWERS[found.holds],
        )
    ]
    compensation = "hand damping that compensates it"
    if found.is_unbounded:
        rows += [MetricValue(compensation, "none: the activity is unbounded")]
    elif found.is_active and found.poles_allow is False:
        # Damping of the hand moves no pole of H_perc, and removes no advance.
        rows += [MetricValue(compensation, f"none: {_preventing(found)} passivity")]
    elif found.is_active and found.poles_allow and found.damping:
        where = (
            f", set at {short(found.damping.omega)} rad/s"
            if found.damping.omega
            else ", approached at high frequency"
        )
        rows += [
            MetricValue(
                f"{compensation}{where}", found.damping.value, m.units["b"], at=found.damping.omega
            )
        ]
    return [*rows, MetricValue("stable under prescribed motion", _YES[m.evaluation.stable])]


def _preventing(found: Passivity) -> str:
    """What prevents passivity, where ``poles_allow`` is False, with its verb."""
    return "an advance prevents" if has_advance(found.distortion.perc) else "poles prevent"


def _verdict(m: Measured, found: Passivity | None) -> str:
    """Return the verdict in words: the band first, then all frequencies as far as they are
    decided."""
    kept = covers(m.passive, m.evaluation.chart)
    band = (
        "Im H_perc >= 0 on the whole band"
        if kept
        else "Im H_perc < 0 somewhere on the band: active there"
    )
    if found is None:
        return f"{band}; whether that is so at all frequencies was not decided"
    if found.holds and found.sampled:
        return f"{band}; passive, by Colgate and Schenkel's condition"
    if found.holds:
        return "passive: Im H_perc >= 0 at all frequencies and no pole prevents it"
    if found.is_active and found.holds is False:
        above = (
            f", but < 0 above it, first from {short(found.active[0].low.omega)} rad/s"
            if kept and found.active
            else ""
        )
        return f"{band}{above}; not passive"
    if found.beyond is Beyond.CLOCK and found.holds is False:
        return f"{band}; not passive, by Colgate and Schenkel's condition"
    if found.beyond is Beyond.CLOCK:
        return (
            f"{band} and up to half the sampling rate; that leaves passivity of the sampled "
            f"display undecided"
        )
    if found.beyond is Beyond.NEVER and found.poles_allow is False:
        return f"Im H_perc >= 0 at all frequencies, but {_preventing(found)} passivity"
    return f"{band}; passivity undecided"


def absolute_stability_measure(m: Measured) -> Metric:
    """Llewellyn's criterion: the band where its conditions on the axis hold, and all of it at all
    frequencies."""
    bands, whole = m.llewellyn, m.unconditional
    rows: tuple[MetricValue, ...] = ()
    if bands is None:
        verdict = "not offered: D = 0, so that the hybrid matrix does not exist"
    else:
        rows = (
            MetricValue("conditions on the axis hold, on the band", bands, "rad/s"),
            MetricValue("conditions on the axis at all frequencies", _ANSWERS[whole.axis]),
            MetricValue("conditions on the poles", _ANSWERS[whole.poles]),
        )
        verdict = _absolutely(m, covers(bands, m.evaluation.chart))
    return Metric(
        "absolute stability",
        m.forms("g"),
        rows,
        "Llewellyn's criterion, after Adams and Hannaford (1999)",
        "verified (tutorial chapter 9.3.3)",
        verdict,
    )


def _absolutely(m: Measured, kept: bool) -> str:  # noqa: FBT001
    """Return the verdict on absolute stability in words; ``kept`` : on the whole band."""
    whole = m.unconditional
    if whole.holds:
        return "absolutely stable: with any passive operator and environment"
    if not kept:
        return (
            "not absolutely stable: the conditions on the axis fail somewhere on the band, "
            "where the display may "
            "generate energy"
        )
    if whole.axis is False:
        return (
            "not absolutely stable: the conditions on the axis hold on the whole band, but fail "
            "above it"
        )
    if whole.poles is False:
        return (
            "not absolutely stable: the conditions on the axis hold on the whole band, but poles "
            "break those on the poles"
        )
    return (
        "the conditions on the axis hold on the whole band; whether it is absolutely stable was "
        "not decided"
    )
