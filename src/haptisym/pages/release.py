"""The page of a release: what was let go, how the motion went on, and what the closed form says of it."""

from __future__ import annotations

from collections.abc import Iterator

from haptisym.kernel.rootcount import RootChain
from haptisym.model.scene import clocks
from haptisym.pages.words import H_PERC, cell, near, noted, page_about
from haptisym.verbs.simulate.release import Closed, Release
from haptisym.writing.document import (
    FREQUENCY,
    Block,
    Column,
    Document,
    Facts,
    Figure,
    Phrase,
    Strong,
    Table,
    listed,
)


def page(r: Release) -> Document:
    """The whole page."""
    shown = "Motion after the hand lets go, and the envelope of the rightmost pole in closed form."
    blocks = *_table(r), *noted(_remarks(r)), Facts(tuple(_run(r))), Figure("release", shown, r.figure)
    return page_about(r.scene, _answer(r), blocks, (_how_sure(r),), "Release test", r.asides())


def _answer(r: Release) -> Iterator[tuple[Phrase, Phrase]]:
    motion: Phrase = "undecided from this run" if r.grows is None else Strong("grows") if r.grows else "decays"
    yield "After release", motion
    yield "Closed form", _held(r)


def _run(r: Release) -> Iterator[tuple[str, Phrase]]:
    motion = r.scene.motion
    numbers = listed((f"{p.key} = ", near(p.value, unit=p.shown_unit(motion))) for p in r.hand.parameters)
    yield "simulated", ", ".join(r.built)
    yield "hand", (f"{r.hand.name}: ", numbers)
    yield "held at", (near(r.displacement), f" {r.unit}, at rest, then let go")
    yield "time", ("0 to ", near(float(r.time[-1])), f" s{f' (it {r.stopped})' if r.stopped else ''}")


def _table(r: Release) -> Iterator[Block]:
    """Rate and frequency as read from the motion, and of the closed form."""
    rows: list[tuple[Phrase, ...]] = []
    if r.fitted is not None:
        omega: Phrase = "-" if r.is_envelope else cell(r.fitted.omega)
        rows.append(("simulated motion", near(r.fitted.rate), omega, f"{r.error:.2g}"))
    if r.closed is not None and not r.is_envelope:
        proven = "proven" if r.closed.root.certified else "not proven to be the rightmost"
        root = "largest pole z, ln z/T" if clocks(r.scene) else "rightmost pole"
        rows.append((root, near(r.closed.rate), cell(r.closed.omega), proven))
    if rows:
        caption = "The motion that decays last: it goes as exp(rate t). The error of the simulated one is estimated."
        numbers = Column("rate (1/s)", number=True), Column(FREQUENCY, number=True, hertz=True)
        yield Table((Column("slowest decay"), *numbers, Column("error")), tuple(rows), caption)


def _remarks(r: Release) -> Iterator[Phrase]:
    if r.closed is not None and r.is_envelope:
        yield _chain(r.closed)
    loop: Phrase = "the sampled loop" if clocks(r.scene) else (H_PERC, " + m s^2 + b s + k")
    yield "Closed form: ", loop, "."


def _held(r: Release) -> Phrase:
    roots = r.held.roots
    if roots is None:
        return Strong("undecided"), f" ({r.held.reason})"
    if r.held.stable:
        return "stable, no pole has |z| ≥ 1" if clocks(r.scene) else "stable, no pole has Re\xa0s\xa0≥\xa00"
    if roots.chain is RootChain.NEAR:
        return Strong(
            "unstable"
        ), ": infinitely many poles come arbitrarily near to the axis, far above what a release moves"
    return Strong("unstable"), ""


def _chain(closed: Closed) -> Phrase:
    rate = near(closed.chain or 0.0)
    return (
        "Infinitely many poles have rates that tend to ",
        rate,
        " 1/s: the simulated rate is that of the motion's largest values.",
    )


def _how_sure(r: Release) -> Phrase:
    if r.grows is None:
        return "Computed: whether the motion grows or decays does not follow from this run."
    if r.approximate:
        return "Computed. The closed form is not what was simulated here: ", r.approximate, "."
    if r.agrees is False or r.sign_agrees is False:
        return "Computed. Simulation and closed form ", Strong("disagree"), "."
    if r.agrees is None and r.sign_agrees is None:
        return "Computed. There is no closed form to compare with."
    what = "the sign of the rate" if r.is_envelope or r.agrees is None else "rate and frequency"
    return f"Computed. Simulation and closed form agree in {what}."
