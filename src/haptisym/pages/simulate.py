"""The page of a simulation: what was simulated, and how it compares with the closed form."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import pi

from haptisym.model.quantities import Dimension
from haptisym.pages.late import drawing
from haptisym.pages.words import H_PERC, noted, page_about, rounded, stiffness_unit, unit
from haptisym.verbs.simulate.entry import Estimate, Simulation, Simulations
from haptisym.writing.document import Block, Column, Document, Facts, Paragraph, Phrase, Section, Strong, Table, listed

_AGREES: dict[bool | None, Phrase] = {True: "yes", False: Strong("NO"), None: "-"}
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
        drawing(name, caption, "simulate:simulation_figure", runs, name)
        for name, caption in _CAPTIONS.items()
        if name.startswith("simulated") or any(run.estimates for run in runs)
    )
    blocks = Facts(tuple(_simulated(runs))), *_table(runs), *drawn, *noted(runs[0].notes), Paragraph(_verdict(runs))
    return page_about(found.scene, blocks, "Simulation in time", found.asides())


def _simulated(runs: Sequence[Simulation]) -> Iterator[tuple[str, Phrase]]:
    first = runs[0]
    length, force = (unit(x, first.scene.motion) for x in (Dimension.DISPLACEMENT, Dimension.FORCE))
    kind = first.motion.name + (f", {len(runs)} runs" if len(runs) > 1 else "")
    most = max(float(abs(run.force).max()) for run in runs)
    yield "simulated", ", ".join(first.built)
    yield "motion", f"{kind}, up to {first.motion.amplitude:.4g} {length}"
    yield "time", f"0 to {max(float(run.time[-1]) for run in runs):.4g} s"
    yield "force", f"up to {most:.4g} {force} at the hand"


def _table(runs: Sequence[Simulation]) -> Iterator[Block]:
    rows = tuple(_row(x) for run in runs for x in run.estimates)
    if rows:
        numbers = "rad/s", "Hz", "Re simulated", "Im simulated", "from closed", "error up to"
        columns = *(Column(x, number=True) for x in numbers), Column("agrees")
        heading = H_PERC, f" recovered from the force, {stiffness_unit(runs[0].scene)}"
        caption = (*heading, "; its distance from the closed form, and the error of the simulation, estimated.")
        yield Section(heading, (Table(columns, rows, caption),))


def _row(x: Estimate) -> tuple[Phrase, ...]:
    frequency = rounded(x.omega, 4), rounded(x.omega / (2 * pi), 4)
    found = rounded(x.simulated.real, 9), rounded(x.simulated.imag, 9)
    return *frequency, *found, rounded(x.difference, 2), rounded(x.error, 2), _AGREES[x.agrees]


def _verdict(runs: Sequence[Simulation]) -> Phrase:
    rows = [x for run in runs for x in run.estimates]
    if not rows:
        return "No ratio is recovered from this motion or from so short a run."
    reasons = dict.fromkeys(x.approximate for x in rows if x.approximate)
    if reasons:
        sizes = [x.difference / abs(x.closed) for x in rows if x.approximate and x.closed]
        worst = f"; it differs by up to {100 * max(sizes):.2g}\xa0%" if sizes else ""
        return f"The closed form is not exact here: {'; '.join(reasons)}{worst}."
    wrong = [f"{x.omega:.4g}" for x in rows if not x.agrees]
    if wrong:
        return "Simulation and closed form ", Strong("DISAGREE"), " at ", listed(wrong), " rad/s."
    return "Simulation and closed form agree within the estimated error of the simulation at every frequency."
