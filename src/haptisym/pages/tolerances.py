"""Tolerances as a page of text: the verdict, the enclosures, and apart from them what is only estimated."""

from __future__ import annotations

from collections.abc import Mapping
from textwrap import fill

from sympy import Expr

from haptisym.kernel.reals import RealNumber
from haptisym.model.jnd import Part
from haptisym.model.ranges import spread
from haptisym.pages.lines import WIDTH, both, table
from haptisym.verbs.tolerances.proofs import Enclosure, Tolerances, Verdict
from haptisym.verbs.tolerances.quantiles import quantiles

_RATIO = {Part.REAL: "r_r", Part.IMAG: "r_i"}
_VERDICTS = {
    Verdict.ALL: "Proven: transparent on the whole band for ALL values within the ranges.",
    Verdict.NONE: "Proven: for NONE of the values within the ranges is the display transparent on the whole band.",
    Verdict.DEPENDS: "Proven: it DEPENDS on the values within the ranges whether the display is transparent on the whole band.",
    Verdict.UNDECIDED: "UNDECIDED within the work budget: whether the display is transparent on the whole band for all values, "
    "some or none. The enclosures below are proven.",
}


def page(a: Tolerances) -> str:
    """The whole page."""
    parts = [_heading(a), _varying(a), _verdict(a), _enclosures(a), _bandwidth(a), _estimates(a)]
    return "\n\n".join(part for part in parts if part) + "\n"


def _heading(a: Tolerances) -> str:
    low, high = a.box.scene.band
    lines = [
        a.box.scene.title or "Untitled scene",
        *a.asides(),
        f"Band: {float(low):.6g} to {float(high):.6g} rad/s",
    ]
    return "\n".join(fill(line, WIDTH) for line in lines)


def _varying(a: Tolerances) -> str:
    nominal = a.nominal.values
    rows = [
        (
            x.name,
            f"{float(x.low):.6g}",
            f"{float(x.high):.6g}",
            "" if x.unit == "1" else x.unit,
            spread(nominal[x.name], (x.low, x.high)),
        )
        for x in a.box.sides
    ]
    return table(("varies", "from", "to", "", ""), rows)


def _verdict(a: Tolerances) -> str:
    lines = [fill(_VERDICTS[a.verdict], WIDTH)]
    for title, one in (("Transparent", a.transparent), ("Noticed", a.noticed)):
        if one is not None and a.verdict in (Verdict.DEPENDS, Verdict.UNDECIDED):
            lines.append(
                fill(
                    f"{title}, for example, with {listed(one.values)}.",
                    WIDTH,
                    initial_indent="  ",
                    subsequent_indent="  ",
                )
            )
    if a.limit is not None:
        lines.append(fill(_CUT.format(a.limit, len(a.samples)), WIDTH))
    return "\n".join(lines)


_CUT = (
    "The limit of {:g} s was reached: enclosures may be wider than they need be, and {} sets of values were drawn. "
    "What is said to be proven is."
)


def listed(values: Mapping[str, Expr]) -> str:
    """Values by name, rounded."""
    return ", ".join(f"{name} = {float(x):.6g}" for name, x in values.items())


def _enclosures(a: Tolerances) -> str:
    if not a.enclosures:
        return "No ratio meets its threshold on the band, for no values within the ranges: proven."
    head = "Guaranteed: where the ratios meet their thresholds, whatever the values\n\n"
    columns = ("ratio", "from (rad/s)", "to (rad/s)", "crossings", "it grows with", "it falls with")
    said = "An end marked = is reached, at a corner of the ranges; any other is a bound, which crossings may come near or not."
    return head + table(columns, map(_row, a.enclosures)) + "\n\n" + fill(said, WIDTH)


def _row(x: Enclosure) -> tuple[str, ...]:
    count = "any number" if x.count is None else f"{x.count} always"
    grows, falls = (", ".join(name for name, n in x.monotonic.items() if n == sign) or "-" for sign in (1, -1))
    return _RATIO[x.part], _end(x.low, x.at_low), _end(x.high, x.at_high), count, grows, falls


def _end(x: RealNumber, at: Mapping[str, Expr] | None) -> str:
    return f"{'=' if at else ''}{x.digits(6)}"


def _bandwidth(a: Tolerances) -> str:
    if a.bandwidth is None:
        return fill(
            "That the display is transparent from the low end of the band on is not proven for all values.", WIDTH
        )
    low, high = a.bandwidth
    return fill(f"Guaranteed: the bandwidth lies between {both(low)} and {both(high)}.", WIDTH)


def _estimates(a: Tolerances) -> str:
    if not a.samples:
        return ""
    q = quantiles(a.samples)
    rows = [("first crossing", *map(_quantile, _of(q.first))), ("bandwidth", *map(_quantile, _of(q.bandwidth)))]
    head = f"Estimated, NOT guaranteed: quantiles over {len(a.samples)} sets of values, drawn uniformly (seed {a.seed})\n\n"
    share = f"Of these sets {q.transparent} are transparent on the whole band."
    return head + table(("rad/s", "5 %", "50 %", "95 %"), rows) + f"\n\n{share}"


def _of(x: Mapping[int, float | None]) -> list[float | None]:
    return [x[5], x[50], x[95]]


def _quantile(x: float | None) -> str:
    return "none" if x is None else f"{x:.5g}"
