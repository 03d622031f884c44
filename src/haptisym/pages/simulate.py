"""A simulation as a page of text: what was simulated, and how it compares with the closed form."""

from __future__ import annotations

from collections.abc import Sequence
from math import pi
from textwrap import fill

from haptisym.model.quantities import Motion as Kind
from haptisym.verbs.simulate.results import Estimate, Simulation, Simulations

_WIDTH = 96


def page(found: Simulation | Simulations) -> str:
    """The whole page; several runs of one scene, one for each frequency, are one table."""
    runs = found.runs
    notes = [fill(note, _WIDTH) for note in runs[0].notes]
    parts = [_heading(runs), _table(runs), *notes, _verdict(runs)]
    return "\n\n".join(part for part in parts if part) + "\n"


def _heading(runs: Sequence[Simulation]) -> str:
    first = runs[0]
    length, force = ("rad", "N m") if first.scene.motion is Kind.ROTATION else ("m", "N")
    kind = first.motion.name + (f", {len(runs)} runs" if len(runs) > 1 else "")
    most = max(float(abs(run.force).max()) for run in runs)
    rows = [
        ("simulated", ", ".join(first.built)),
        ("motion", f"{kind}, up to {first.motion.amplitude:.4g} {length}"),
        ("time", f"0 to {max(float(run.time[-1]) for run in runs):.4g} s"),
        ("force", f"up to {most:.4g} {force} at the hand"),
    ]
    title = (first.scene.title or "Untitled scene", *first.asides())
    lines = [fill(line, _WIDTH) for line in title if line]
    return "\n".join([*lines, *(fill(f"  {key:<11}{text}", _WIDTH, subsequent_indent=" " * 13) for key, text in rows)])


def _table(runs: Sequence[Simulation]) -> str:
    rows = [x for run in runs for x in run.estimates]
    if not rows:
        return ""
    unit = "N m/rad" if runs[0].scene.motion is Kind.ROTATION else "N/m"
    head = f"H_perc recovered from the force, {unit}\n\n"
    titles = f"  {'rad/s':>9} {'Hz':>8} {'Re simulated':>16} {'Im simulated':>16} {'from closed':>12} {'error up to':>12}  agrees"
    return head + "\n".join([titles, *map(_row, rows)])


def _row(x: Estimate) -> str:
    verdict = {True: "yes", False: "NO", None: "-"}[x.agrees]
    return (
        f"  {x.omega:>9.4g} {x.omega / (2 * pi):>8.4g} {x.simulated.real:>16.9g} {x.simulated.imag:>16.9g} "
        f"{x.difference:>12.2g} {x.error:>12.2g}  {verdict}"
    )


def _verdict(runs: Sequence[Simulation]) -> str:
    rows = [x for run in runs for x in run.estimates]
    if not rows:
        return "No ratio is recovered from this motion or from so short a run."
    reasons = list(dict.fromkeys(x.approximate for x in rows if x.approximate))
    if reasons:
        sizes = [x.difference / abs(x.closed) for x in rows if x.approximate and x.closed]
        worst = f"; it differs by up to {100 * max(sizes):.2g} %" if sizes else ""
        return fill(f"The closed form is not exact here: {'; '.join(reasons)}{worst}.", _WIDTH)
    wrong = [x for x in rows if not x.agrees]
    if wrong:
        return fill(
            f"Simulation and closed form DISAGREE at {', '.join(f'{x.omega:.4g}' for x in wrong)} rad/s.", _WIDTH
        )
    return "Simulation and closed form agree within the estimated error of the simulation at every frequency."
