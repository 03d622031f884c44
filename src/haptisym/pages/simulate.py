"""The page of a simulation: what was simulated, and how it compares with the closed form."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from haptisym.model.quantities import Dimension
from haptisym.pages.late import drawing
from haptisym.pages.words import H_PERC, at_most, cell, near, noted, page_about, stiffness_unit, unit
from haptisym.verbs.simulate.entry import Estimate, Simulation, Simulations
from haptisym.writing.document import (
    FREQUENCY,
    FREQUENCY_UNIT,
    Block,
    Column,
    Document,
    Facts,
    Phrase,
    Section,
    Strong,
    Table,
    listed,
)

_AGREES: dict[bool | None, Phrase] = {True: "yes", False: Strong("no"), None: "-"}
_CAPTIONS = {
    "simulated-time": "Motion and force at the hand in time.",
    "simulated-loop": "Force over displacement, as felt and of the environment alone.",
    "recovered-real": "Real part as recovered from the force (rings) and by its closed form (dashed).",
    "recovered-imag": "Imaginary part as recovered from the force (rings) and by its closed form (dashed).",
}


def page(found: Simulation | Simulations) -> Document:
    """The whole page; several runs of one scene, one for each frequency, are one table."""
    runs = found.runs
    drawn = (
        drawing(name, caption, "sheet:draw_figure", runs, name)
        for name, caption in _CAPTIONS.items()
        if name.startswith("simulated") or any(run.estimates for run in runs)
    )
    blocks = *_table(runs), Facts(tuple(_simulated(runs))), *drawn, *noted(runs[0].notes)
    answer = (("Closed form", _verdict(runs)),)
    return page_about(found.scene, answer, blocks, (_HOW_SURE,), "Simulation in time", found.asides())


_HOW_SURE = "Computed: a simulation in floating point; its error is estimated from runs of different accuracy."


def _simulated(runs: Sequence[Simulation]) -> Iterator[tuple[str, Phrase]]:
    first = runs[0]
    length, force = (unit(x, first.scene.motion) for x in (Dimension.DISPLACEMENT, Dimension.FORCE))
    kind = first.motion.name + (f", {len(runs)} runs" if len(runs) > 1 else "")
    most = max(float(abs(run.force).max()) for run in runs)
    yield "simulated", ", ".join(first.built)
    yield "motion", (f"{kind}, up to ", near(first.motion.amplitude), f" {length}")
    yield "time", ("0 to ", near(max(float(run.time[-1]) for run in runs)), " s")
    yield "force", ("up to ", near(most), f" {force} at the hand")


def _table(runs: Sequence[Simulation]) -> Iterator[Block]:
    rows = tuple(_row(x) for run in runs for x in run.estimates)
    if rows:
        numbers = "Re simulated", "Im simulated", "difference", "error"
        columns = (
            Column(FREQUENCY, number=True, hertz=True),
            *(Column(x, number=True) for x in numbers),
            Column("agrees"),
        )
        heading = H_PERC, f" recovered from the force, {stiffness_unit(runs[0].scene)}"
        caption = (*heading, "; its distance from the closed form, and the error of the simulation, estimated.")
        yield Section(heading, (Table(columns, rows, caption),))


def _row(x: Estimate) -> tuple[Phrase, ...]:
    found = near(x.simulated.real), near(x.simulated.imag)
    return cell(x.omega), *found, near(x.difference, most=2), near(x.error, most=2), _AGREES[x.agrees]


def _verdict(runs: Sequence[Simulation]) -> Phrase:
    rows = [x for run in runs for x in run.estimates]
    if not rows:
        return "not compared: no ratio is recovered from this motion, or from so short a run"
    reasons = dict.fromkeys(x.approximate for x in rows if x.approximate)
    if reasons:
        sizes = [x.difference / abs(x.closed) for x in rows if x.approximate and x.closed]
        worst: Phrase = ("; it differs by up to ", at_most(100 * max(sizes)), "\xa0%") if sizes else ""
        return f"not exact here: {'; '.join(reasons)}", worst
    wrong = [cell(x.omega) for x in rows if not x.agrees]
    if wrong:
        return Strong("disagrees"), " with the simulation at ", listed(wrong), "\xa0", FREQUENCY_UNIT
    return "agrees with the simulation at every frequency, within its estimated error"
