"""The measures of transparency that the field uses, side by side with the JND verdict, and where
the two disagree.

Each measure (``_MEASURES``) has its closed form, proven numbers, its source and how well that is
known. The functions that they are read off are in ``metric``. Derivation: 15_metrics.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import partial
from pathlib import Path

from haptisym.judge.crossings import Criterion, kept
from haptisym.judge.evaluation import evaluate
from haptisym.judge.peaks import largest_value
from haptisym.kernel.budget import SECONDS, Left, in_time, limited
from haptisym.kernel.dynamics import RealFunction, squared_modulus
from haptisym.kernel.reals import RealNumber, SquareRoot, short
from haptisym.kernel.rings import RationalFunction
from haptisym.kernel.roots import Point, chart
from haptisym.model.scene import Scene
from haptisym.model.scenefile import as_scene
from haptisym.verbs.metrics.freeresponse import FreeResponse
from haptisym.verbs.metrics.metric import (
    FAR,
    TOO_LARGE,
    WITHIN_3_DB,
    ZERO,
    Measured,
    Metric,
    Metrics,
    MetricValue,
    absolute_stability_measure,
    covers,
    passivity_measure,
    relative_square,
    value_at,
)

_BLIND = (
    "A force filter or delay in series leaves the zeros of the dynamics where they are: it "
    "changes only how a free response "
    "begins, while the JND test judges all of it."
)
_SLACK = (
    "The free response stays within its tolerances although a moving hand notices the distortion "
    "on this band."
)
_STRICT = (
    "The free response exceeds its tolerances although a moving hand notices nothing on this band."
)
_COARSE = (
    "The transmitted impedance stays within 3 dB on the whole band on which the JND is "
    "exceeded: 3 dB is 29 to 41 % of the "
    "modulus, far more than the threshold, and ignores the phase."
)
_ACTIVE = (
    "Transparent is not absolutely stable: the conditions on the axis fail on all of the "
    "band but single frequencies, so that "
    "this display may generate energy with some passive operator or environment where "
    "nothing is noticed."
)


def disagreements(m: Measured) -> Iterable[str]:
    """Yield sentences on where a measure and the JND verdict differ."""
    # The bandwidth is the band's end itself, the same object, where nothing is noticed.
    e = m.evaluation
    noticed = e.bandwidth is not e.chart.points[-1].omega
    if noticed and m.free.blind:
        yield _BLIND
    elif noticed and m.free.passes:
        yield _SLACK
    elif not noticed and m.free.passes is False:
        yield _STRICT
    if noticed and covers(m.inside, e.chart):
        yield _COARSE
    # All intervals are single points: the conditions hold only where one of their functions is 0.
    if e.transparent and m.llewellyn is not None and all(x.low is x.high for x in m.llewellyn):
        yield _ACTIVE


def metrics(
    scene: Scene | str | Path, *, absolute_stability: bool = False, limit: float | None = SECONDS
) -> Metrics:
    """The measures of transparency of a scene with numbers for all parameters: each proven on its
    band.

    Transmitted impedance ratio and relative distortion, Z_min, Z_max and Z_width, sensitivity,
    passivity and absolute stability at all frequencies, effective stiffness, mass and damping, free
    response. ``absolute_stability`` : whether the page has it where it fails, too, as it does for
    most displays. ``limit`` : seconds of processor time after which all further measures are
    undecided; None for none. LimitError where the crossings are. Raises SceneError if a parameter
    is still a symbol.

    >>> from haptisym.model.scenefile import load_scene
    >>> found = metrics(load_scene("fu2019"))
    >>> [x.value.digits(6) for x in found["transmitted impedance ratio"].values if x.what.startswith("-3 dB")]
    ['101.762']
    """
    scene = as_scene(scene)
    with limited(limit):
        m = Measured(evaluate(scene))
        left = Left()
        # A measure that the limit cuts short is undecided by itself; the others that were found
        # stand.
        measures = tuple(
            in_time(partial(measure, m), name, left)
            or Metric(name, (), (), "", "", f"undecided: {left[name]}")
            for name, measure in _MEASURES.items()
        )
        notes = in_time(lambda: tuple(disagreements(m)), "notes", left) or ()
        return Metrics(m.evaluation, measures, notes, m, absolute_stability)


def _modulus_at_ends(function: RationalFunction, m: Measured, what: str) -> list[MetricValue]:
    """Return |f| at both ends of the band."""
    # From the square, which is rational: zeros and poles are exact, and the root is taken of balls.
    square = squared_modulus(function)
    points = chart({"": square}, *m.band).points
    squares = {end: value_at(square, points[i], "") for end, i in (("low", 0), ("high", -1))}
    roots = {end: x if x is None or x == ZERO else SquareRoot(x) for end, x in squares.items()}
    return [MetricValue(f"{what} at {end} end", x, m.unit) for end, x in roots.items()]


def _largest(square: RealFunction, m: Measured) -> RealNumber | None:
    """Return the largest value of a modulus on the band, given its square; None where unbounded."""
    if square.is_zero:
        return ZERO
    peak = largest_value(square, *m.band)
    return None if peak is None else SquareRoot(peak)


# The measures


def _ratio(m: Measured) -> Metric:
    """Transmitted impedance ratio |H_perc/H_env|: its 3 dB edges and where it is between them."""
    edges = [p for p in m.edges.points if any(_passes(p, x) for x in WITHIN_3_DB)]
    values = [MetricValue(_edge(p), p.omega, "rad/s") for p in edges]
    inside = kept(m.edges)
    upto = "the band" if m.reach == m.band[1] else f"{FAR} times the band's high end"
    return Metric(
        "transmitted impedance ratio",
        m.forms("Gamma"),
        (*values, MetricValue(f"within 3 dB (up to {upto})", inside, "rad/s")),
        (
            "Lawrence (1993): transparent where the displayed impedance is the environment's, "
            "Z_t = Z_e"
        ),
        "as the EuroVR knowledge base cites it: read; ratio and 3 dB edges derived",
        _beside_bandwidth(m, edges) if edges else "no 3 dB edge",
        edges[0].omega if edges else None,
    )


def _beside_bandwidth(m: Measured, edges: list[Point]) -> str:
    """Return words that compare the first 3 dB edge with the bandwidth by the JND."""
    edge, bandwidth = edges[0].omega, m.evaluation.bandwidth
    first = f"first 3 dB edge at {short(edge)} rad/s"
    if bandwidth is None or float(bandwidth) == 0:
        return f"{first}; the JND test finds no transparent band that begins at the band's low end"
    if bandwidth is m.evaluation.chart.points[-1].omega:
        return f"{first}; the JND is nowhere exceeded on the band"
    share = float(edge) / float(bandwidth)
    return f"{first}, {share:.3g} times the bandwidth by the JND"


def _passes(p: Point, x: Criterion) -> bool:
    """Whether a measure passes its limit at a point; one that only touches it does not."""
    return p.before[x] != p.after[x]


def _edge(p: Point) -> str:
    """Return the name of an edge with the way the ratio goes there: for "too small" it rises where
    the criterion's function falls."""
    x = next(x for x in WITHIN_3_DB if _passes(p, x))
    return f"{x.name} edge, {'rising' if (p.after[x] > 0) == (x is TOO_LARGE) else 'falling'}"


def _relative(m: Measured) -> Metric:
    square = relative_square(m.d)
    circle = (
        f"at most {float(100 * m.relative.threshold):.6g} %"
        if m.relative
        else "within the largest circle that the region holds"
    )
    return Metric(
        "relative distortion",
        m.forms("Theta"),
        (
            MetricValue(circle, m.within, "rad/s"),
            MetricValue("largest on the band", _largest(square, m)),
        ),
        "Fu, van Paassen and Mulder (2019): dH over |H_env|, both parts together",
        "verified; the modulus derived",
        _RELATIVE if m.relative else _IN_CIRCLE,
    )


_RELATIVE = (
    "where it is at most c neither r_r nor r_i can exceed c; the JND test asks less, as it "
    "judges the two parts apart"
)
_IN_CIRCLE = (
    "where it is in that circle no change leaves the region; the JND test asks less, as the "
    "region is larger"
)


def _range(m: Measured) -> Metric:
    least, most, width = m.port.least, m.port.most, m.port.width
    values = (
        [MetricValue("|Z_min| everywhere", None, m.unit)]
        if least is None
        else _modulus_at_ends(least, m, "|Z_min|")
    )
    for name, function in (("|Z_max|", most), ("|Z_width|", width)):
        shown = (
            [MetricValue(f"{name} everywhere", None, m.unit)]
            if function is None
            else _modulus_at_ends(function, m, name)
        )
        values += shown
    # Z_min = 0: in free space the display is not felt at all.
    empty = "nothing" if least is not None and least.is_zero else "Z_min"
    verdict = (
        f"where there is nothing, {empty} is felt; a rigid environment is felt as "
        f"{'rigid' if most is None else 'Z_max'}"
    )
    return Metric(
        "impedance range",
        m.forms("Z_min", "Z_max", "Z_width"),
        tuple(values),
        (
            "Hashtrudi-Zaad and Salcudean (2001): minimum and dynamic range (width) of the "
            "transmitted impedance"
        ),
        "abstract read; the formulas are limits of the two-port, derived (15_metrics)",
        verdict,
    )


def _sensitivity(m: Measured) -> Metric:
    square = m.sensitivity_square
    value = None if square is None else _largest(square, m)
    return Metric(
        "sensitivity",
        m.forms("dH_perc/dH_env"),
        (MetricValue("largest |dH_perc/dH_env| on the band", value),),
        "derivative of H_perc by H_env",
        "derived (15_metrics)",
        (
            "1 where a small change of the environment is passed on unchanged; independent of "
            "the environment itself"
        ),
    )


def _effective(m: Measured) -> Metric:
    names = {"k": "stiffness", "m": "mass", "b": "damping"}
    values = [
        MetricValue(f"{names[key]} at {short(w)} rad/s", x, m.units[key], at=w)
        for w, row in m.effective
        for key, x in row.items()
    ]
    return Metric(
        "effective impedance",
        m.forms("k_perc", "m_perc", "b_perc"),
        tuple(values),
        "step 2 of Fu, van Paassen and Mulder (2019)",
        "verified",
        "what step 2 of the JND evaluation judges",
    )


def _free(found: FreeResponse, m: Measured, of: str, table: str) -> Metric:
    values = [
        MetricValue(
            x.name,
            "none" if x.perceived is None else x.perceived,
            x.unit,
            x.environment,
            x.tolerance,
            x.passes,
        )
        for x in found.checks
    ]
    # Without effects H_perc is H_env, and that its zeros are the same says nothing.
    blind = found.blind and found.checks and m.evaluation.scene.effects
    passed = {True: "passes", False: "fails", None: found.refused}[found.passes]
    how = (
        "; H_perc has the zeros of H_env: these effects change how the motion begins, and no period"
        if blind
        else ""
    )
    return Metric(
        f"free response, {of}",
        (),
        tuple(values),
        f"14 CFR Part 60, appendix {table}",
        "verified; the whole response from rest",
        f"{passed}{how}",
    )


_MEASURES: Mapping[str, Callable[[Measured], Metric]] = {
    "transmitted impedance ratio": _ratio,
    "relative distortion": _relative,
    "impedance range": _range,
    "sensitivity": _sensitivity,
    "passivity": passivity_measure,
    "absolute stability": absolute_stability_measure,
    "effective impedance": _effective,
    "free response, aeroplanes": lambda m: _free(
        m.free, m, "aeroplanes", "A, attachment 2, table A2A, 2.b"
    ),
    "free response, helicopters": lambda m: _free(
        m.free_of_a_helicopter, m, "helicopters", "C, attachment 2, table C2A, 2.a.5"
    ),
}
