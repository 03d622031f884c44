"""An evaluation's results in LaTeX: tables with booktabs, and the sentences that go with them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from sympy import Expr

from haptisym.judge.crossings import Crossing, CrossingKind
from haptisym.judge.evaluation import Evaluation
from haptisym.kernel.hertz import Hertz
from haptisym.kernel.reals import RealNumber
from haptisym.kernel.roots import Interval, Point
from haptisym.model.jnd import Part, is_irrational_algebraic
from haptisym.pages.words import NOT_HELD
from haptisym.writing.texnames import escape
from haptisym.writing.texprinter import formula

RATIOS = {Part.REAL: "r_r", Part.IMAG: "r_i"}
_NAMES = {Part.REAL: "real", Part.IMAG: "imaginary"}


def threshold_value(c: Expr) -> str:
    """The threshold after its sign: of equality, or of approximation where it is an irrational algebraic number."""
    return rf"\approx {formula(c.evalf(12))}" if is_irrational_algebraic(c) else f"= {formula(c)}"


# Step 1.


def crossing_tables(e: Evaluation) -> list[str]:
    """When: every crossing on the band."""
    if not e.crossings:
        return [f"No ratio meets its threshold on the band ({_proven(e)})."]
    header = ["part", r"$\omega$ (rad/s)", r"$\omega/2\pi$ (Hz)", "what happens", "distortion", "multiplicity"]
    columns = "l l l l l r" if e.digits <= _LONG_NUMBER else "l p{4cm} l l l r"
    rows = [_crossing(e, c) for c in e.crossings]
    caption = f"All crossings of the thresholds on the band: {_proven(e)}."
    return tables(caption, "crossings", columns, header, rows, most=_MOST_ROWS * 15 // max(15, e.digits))


_VERBS = {CrossingKind.EXCEEDS: "rises above", CrossingKind.RETURNS: "falls below", CrossingKind.TOUCHES: "touches"}
_LONG_NUMBER = 25  # digits; a longer one is set on several lines


def _crossing(e: Evaluation, c: Crossing) -> list[str]:
    event = f"${c.criterion.symbol}$ {_VERBS[c.kind]} ${threshold_value(c.criterion.threshold).removeprefix('= ')}$"
    sense = rf"$\{c.criterion.component} \Delta H {'>' if c.sign > 0 else '<'} 0$" if c.sign else ""
    digits = c.omega.digits(e.digits)
    if len(digits) > _LONG_NUMBER:
        digits = r"\allowbreak ".join(digits[i : i + 5] for i in range(0, len(digits), 5))
    return [
        c.criterion.words.removesuffix(" part"),
        digits,
        Hertz(c.omega).digits(5),
        event,
        sense,
        str(c.multiplicity),
    ]


def transparency(e: Evaluation) -> str:
    """Where neither ratio exceeds its threshold."""
    if not e.transparent:
        return "At every frequency of the band a ratio exceeds its threshold: the transparent set is empty."
    pieces = r" \cup ".join(_set(x) for x in e.transparent)
    found = rf"The display is perceptually transparent on ${pieces}$ rad/s"
    if (
        len(e.transparent) == 1
        and e.transparent[0].low is e.chart.points[0]
        and e.transparent[0].high is e.chart.points[-1]
    ):
        return f"{found}, the whole band."
    if e.bandwidth is None:
        return f"{found}, and not at the low end of the band: there is no transparent bandwidth."
    return f"{found}; the bandwidth of transparency is {short(e.bandwidth)} rad/s ({short(Hertz(e.bandwidth))} Hz)."


def _set(x: Interval) -> str:
    low, high = short(x.low.omega), short(x.high.omega)
    return rf"\{{{low}\}}" if x.low is x.high else f"[{low}, {high}]"


# Step 2.


def percept_tables(e: Evaluation) -> list[str]:
    """How: what is felt where a ratio exceeds its threshold."""
    if not e.felt:
        return [f"Nothing is noticed on the band: neither ratio exceeds its threshold ({_proven(e)})."]
    header = ["part", r"$\omega$ (rad/s)", "felt as"]
    caption = f"What is felt where a ratio exceeds its threshold: {_proven(e)}."
    rows = [[_NAMES[x.part], _span(x.band), x.words] for x in e.felt]
    return tables(caption, "percepts", "l l l", header, rows)


def changeovers(e: Evaluation) -> str:
    """Where the sign of Re H changes, of the environment and of what is felt."""
    told = [
        rf"$\Re H_{{\mathrm{{{name}}}}}$ changes its sign {f'at {_places(points)}' if points else 'nowhere on the band'}"
        for name, points in (("env", e.changeovers_environment), ("perc", e.changeovers_perceived))
    ]
    return f"Spring and inertia change over: {' and '.join(told)}."


def reservations(e: Evaluation) -> list[str]:
    """Where the model says nothing: an active display, an unbounded ratio."""
    found = []
    if e.outside_model:
        where = listed(_span(x) for x in e.outside_model)
        noticed = "so that no property is named for what is noticed there" if e.unnamed else "but not noticed there"
        found.append(
            rf"The imaginary part is outside the paper's model at {where} rad/s, {noticed}: the display is active "
            r"($\Im H_{\mathrm{perc}} < 0$)."
        )
    if e.unbounded:
        found.append(
            rf"A ratio is unbounded at {_places(e.unbounded)}: there is nothing to compare with "
            r"($H_{\mathrm{env}} = 0$, or $\Delta H$ infinite)."
        )
    return found


# Certainty.


def _proven(e: Evaluation) -> str:
    return "proven, none missed and none invented" if e.certified else "proven, but for what is listed as undecided"


def stability(e: Evaluation) -> str:
    """Whether the force under imposed motion is stable, which says nothing about a display in a hand."""
    if e.stable is None:
        return f"Whether the force under imposed motion is stable was not decided. {NOT_HELD}"
    if e.stable:
        poles = r"all poles of $H_{\mathrm{perc}}$ lie in the open left half plane"
        return f"The force under imposed motion is stable: {poles}. {NOT_HELD}"
    return r"The force under imposed motion is \emph{not} stable: a pole of $H_{\mathrm{perc}}$ has $\Re s \ge 0$."


def undecided_tables(e: Evaluation) -> list[str]:
    """What stayed open at the precision limit; nothing where everything is decided."""
    if not e.undecided:
        return []
    caption = "Undecided at the precision limit: whether the ratio touches its threshold here, crosses it twice or stays clear."
    rows = [
        [x.words.removesuffix(" part"), f"[{low}, {high}]"]
        for x, (low, high) in ((x, point.omega.enclosure(e.digits)) for x, point in e.undecided)
    ]
    return tables(caption, "undecided", "l l", ["part", r"near $\omega$ (rad/s)"], rows)


def certainty(e: Evaluation) -> str:
    """What is proven and what is assumed."""
    but = "".join(rf" \textbf{{But:}} {escape(caveat)}" for caveat in e.caveats)
    rest = "" if e.certified else ", but for what is listed as undecided"
    return (
        f"Proven{rest}: the tables list all crossings and all percepts on the band; every digit, sign and interval follows from "
        "exact polynomials and ball arithmetic, nothing was sampled, and each number is correctly rounded. Assumed: that "
        f"the dynamics are linear, and the threshold of human perception (Fu, van Paassen and Mulder, 2019, eq.~4).{but}"
    )


# Words and tables.


def short(x: RealNumber, digits: int = 5) -> str:
    """A number to a few digits, without trailing zeros."""
    text = x.digits(digits)
    return text.rstrip("0").rstrip(".") if "." in text and "E" not in text else text


def listed(items: Iterable[str]) -> str:
    """``a, b and c``."""
    *others, last = items
    return f"{', '.join(others)} and {last}" if others else last


def _span(x: Interval) -> str:
    low, high = short(x.low.omega), short(x.high.omega)
    return low if x.low is x.high else f"{low} to {high}"


def _places(points: Iterable[Point]) -> str:
    return f"{listed(short(p.omega) for p in points)} rad/s"


_MOST_ROWS = 35  # of a table, so that it fits on a page


def tables(
    caption: str, label: str, columns: str, header: Sequence[str], rows: Sequence[Iterable[str]], most: int = _MOST_ROWS
) -> list[str]:
    """A table with booktabs; several where it would be longer than a page, none without rows."""
    found = []
    for start in range(0, len(rows), max(1, most)):
        body = "\n".join(f"    {' & '.join(row)} \\\\" for row in rows[start : start + max(1, most)])
        title = f"{caption}\\label{{tab:{label}}}" if start == 0 else f"{caption} (Continued.)"
        found.append(
            f"\\begin{{table}}[htbp]\n  \\centering\n  \\caption{{{title}}}\n  \\begin{{tabular}}{{{columns}}}\n"
            f"    \\toprule\n    {' & '.join(header)} \\\\\n    \\midrule\n{body}\n    \\bottomrule\n"
            "  \\end{tabular}\n\\end{table}"
        )
    return found
