"""The answers of an evaluation in brief, at the head of its page."""

from __future__ import annotations

from haptisym.judge.evaluation import Evaluation
from haptisym.kernel.hertz import Hertz
from haptisym.pages.report.results import frequency, is_transparent_throughout
from haptisym.pages.tex.results import short
from haptisym.writing.htmltext import Html, element, joined


def findings(e: Evaluation) -> Html:
    """The answers in brief."""
    rows = [
        ("bandwidth", *_bandwidth(e)), ("first felt as", *_first(e)),
        ("under imposed motion", {True: "stable", False: "not stable", None: "undecided"}[e.stable], _STABLE[e.stable]),
        ("these answers", "proven" if e.certified else "in part undecided", _open(e)),
    ]  # fmt: skip
    cells = (
        element("div", element("dt", x), element("dd", element("strong", y), element("span", z))) for x, y, z in rows
    )
    return element("dl", *cells, given={"class": "findings"})


_STABLE = {
    True: "no pole with Re\xa0s ≥ 0; a hand was not looked at", False: "a pole with Re\xa0s ≥ 0",
    None: "whether a pole has Re\xa0s ≥ 0 is open",
}  # fmt: skip


def _bandwidth(e: Evaluation) -> tuple[Html, Html]:
    if is_transparent_throughout(e):
        high = e.chart.points[-1].omega
        return joined([frequency(high), " rad/s"]), joined([short(Hertz(high)), " Hz, the whole band"])
    if e.bandwidth is None:
        elsewhere = ["transparent from ", frequency(e.transparent[0].low.omega), " rad/s on"] if e.transparent else []
        return joined(["none"]), joined(elsewhere or ["transparent nowhere on the band"])
    more = f", and on {len(e.transparent) - 1} more" if len(e.transparent) > 1 else ""
    return joined([frequency(e.bandwidth), " rad/s"]), joined([f"{short(Hertz(e.bandwidth))} Hz{more}"])


def _first(e: Evaluation) -> tuple[Html, Html]:
    if not e.felt:
        return joined(["nothing"]), joined(["nothing is noticed on the band"])
    first = min(e.felt, key=lambda x: float(x.band.low.omega))
    return joined([first.words]), joined(["from ", frequency(first.band.low.omega), " rad/s on"])


def _open(e: Evaluation) -> str:
    if e.certified:
        return "none missed, none invented"
    return "1 tangency stayed open" if len(e.undecided) == 1 else f"{len(e.undecided)} tangencies stayed open"
