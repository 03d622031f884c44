"""The page of a release: what was let go, how the motion went on, and what the closed form says of it."""

from __future__ import annotations

from collections.abc import Iterator

from haptisym.kernel.rootcount import RootChain
from haptisym.model.scene import clocks
from haptisym.pages.words import H_PERC, page_about, rounded, unit
from haptisym.verbs.simulate.release import Closed, Release
from haptisym.writing.document import (
    Block,
    Column,
    Document,
    Facts,
    Figure,
    Notes,
    Number,
    Paragraph,
    Phrase,
    Strong,
    Table,
)

_WORDS = {True: "grows", False: "dies away"}


def page(r: Release) -> Document:
    """The whole page."""
    shown = "Motion after the hand lets go, and the envelope of the closed form's rightmost root."
    blocks = Facts(tuple(_run(r))), *_table(r), Figure("release", shown, r.figure), *_remarks(r), Paragraph(_verdict(r))
    return page_about(r.scene, blocks, "Held displaced, and let go", r.asides())


def _run(r: Release) -> Iterator[tuple[str, Phrase]]:
    motion = r.scene.motion
    numbers = ", ".join(f"{p.key} = {float(p.value):.6g} {unit(p.dimension, motion)}" for p in r.hand.parameters)
    yield "simulated", ", ".join(r.built)
    yield "hand", f"{r.hand.name}: {numbers}"
    yield "held at", f"{r.displacement:.6g} {r.unit}, at rest, then let go"
    yield "time", f"0 to {float(r.time[-1]):.4g} s{f', when it had {r.stopped}' if r.stopped else ''}"


def _table(r: Release) -> Iterator[Block]:
    """Rate and frequency as read from the motion, and of the closed form."""
    rows: list[tuple[Phrase, ...]] = []
    if r.fitted is not None:
        omega: Phrase = "-" if r.is_envelope else rounded(r.fitted.omega, 9)
        rows.append(("read from the motion", rounded(r.fitted.rate, 9), omega, f"{r.error:.2g}"))
    if r.closed is not None and not r.is_envelope:
        rate, omega = r.closed.root.digits()
        proven = "proven" if r.closed.root.certified else "not proven to be the rightmost"
        root = "largest root z, ln z/T" if clocks(r.scene) else "rightmost root"
        rows.append((root, Number(rate, r.closed.rate), Number(omega, r.closed.omega), proven))
    if rows:
        caption = "The motion that lasts longest: it goes as exp(rate t). The error of what is read is estimated."
        numbers = (Column(x, number=True) for x in ("rate (1/s)", "rad/s"))
        yield Table((Column("what lasts longest"), *numbers, Column("error")), tuple(rows), caption)


def _remarks(r: Release) -> Iterator[Block]:
    if r.closed is not None and r.is_envelope:
        yield Notes((_chain(r.closed),))
    loop: Phrase = "the loop with its clock" if clocks(r.scene) else (H_PERC, " + m s^2 + b s + k")
    yield Notes((("Held in this hand, by the closed form (", loop, "): ", _held(r), "."),))


def _held(r: Release) -> Phrase:
    roots = r.held.roots
    if roots is None:
        return f"not decided ({r.held.reason})"
    if r.held.stable:
        return "stable, no root has |z| ≥ 1" if clocks(r.scene) else "stable, no root has Re\xa0s\xa0≥\xa00"
    if roots.chain is RootChain.NEAR:
        return Strong(
            "NOT"
        ), " stable, infinitely many roots come as near to the axis as one likes, far above what a release moves"
    return Strong("NOT"), " stable"


def _chain(closed: Closed) -> Phrase:
    return (
        f"The closed form has infinitely many roots, whose rates tend to {closed.chain or 0.0:.6g} 1/s: no single one ",
        "lasts longest, and the rate that is read is that of the motion's largest values.",
    )


def _verdict(r: Release) -> Phrase:
    if r.grows is None:
        return "Whether the motion grows or dies away cannot be read from this run."
    told = "After letting go the motion ", Strong("GROWS") if r.grows else "dies away", "."
    if r.approximate:
        return *told, f" The closed form is not what was simulated here: {r.approximate}."
    if r.agrees is False or r.sign_agrees is False:
        return *told, " Simulation and closed form ", Strong("DISAGREE"), "."
    if r.agrees is None and r.sign_agrees is None:
        return *told, " There is nothing to compare it with."
    what = "the sign of the rate" if r.is_envelope or r.agrees is None else "rate and frequency"
    return *told, f" Simulation and closed form agree in {what}."
