"""The page of a simulation: what was simulated, and how it compares with the closed form; and that
of a release."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from haptisym.kernel.rootcount import RootChain
from haptisym.model.quantities import Dimension
from haptisym.model.scene import clocks
from haptisym.pages import words as w
from haptisym.pages.stability import limit_cycle_table
from haptisym.verbs.simulate.entry import Simulation, Simulations
from haptisym.verbs.simulate.release import Closed, Release
from haptisym.verbs.stability.limitcycles import linear
from haptisym.writing import document as doc
from haptisym.writing.document import FREQUENCY_UNIT, Block, Document, Phrase, Strong, listed

_AGREES: dict[bool | None, Phrase] = {True: "yes", False: Strong("no"), None: "-"}
_CAPTIONS = {
    "simulated-time": "Motion and force at the hand in time.",
    "simulated-loop": "Force over displacement, as felt and of the environment alone.",
    "recovered-real": (
        "Real part as recovered from the force (rings) and by its closed form (dashed)."
    ),
    "recovered-imag": (
        "Imaginary part as recovered from the force (rings) and by its closed form (dashed)."
    ),
}


def page(found: Simulation | Simulations) -> Document:
    """Return the page of a simulation; several runs of one scene, one for each frequency, are one
    table."""
    runs = found.runs
    # Without a ratio that was recovered there is nothing to compare with the closed form.
    drawn = (
        w.drawing(found, name, caption)
        for name, caption in _CAPTIONS.items()
        if name.startswith("simulated") or any(run.estimates for run in runs)
    )
    blocks = *_table(runs), doc.Facts(tuple(_simulated(runs))), *drawn, *w.noted(runs[0].notes)
    answer = (("Closed form", _verdict(runs)),)
    return w.page_about(
        found.scene, answer, blocks, (_HOW_SURE,), "Simulation in time", found.asides()
    )


_HOW_SURE = (
    "Computed: a simulation in floating point; its error is estimated from runs of different "
    "accuracy."
)


def _simulated(runs: Sequence[Simulation]) -> Iterator[tuple[str, Phrase]]:
    """Yield what was simulated: motion, time, force, and the errors that hardware adds."""
    first = runs[0]
    length, force = (
        w.unit(x, first.scene.motion) for x in (Dimension.DISPLACEMENT, Dimension.FORCE)
    )
    kind = first.motion.name + (f", {len(runs)} runs" if len(runs) > 1 else "")
    most = max(float(abs(run.force).max()) for run in runs)
    yield "motion", (f"{kind}, up to ", w.near(first.motion.amplitude), f" {length}")
    yield "time", ("0 to ", w.near(max(float(run.time[-1]) for run in runs)), " s")
    yield "force", ("up to ", w.near(most), f" {force} at the hand")
    if first.error:
        x = first.error
        yield (
            "force error",
            (
                "up to ",
                w.near(x.largest),
                f" {force}, RMS ",
                w.near(x.rms),
                f" {force}, against ideal hardware",
            ),
        )
        yield (
            "of it encoder",
            (
                "up to ",
                w.near(x.quantised_largest),
                f" {force}, RMS ",
                w.near(x.quantised_rms),
                f" {force}",
            ),
        )
        yield "at the limit", (w.near(100 * x.at_limit), "\xa0% of the time")


def _table(runs: Sequence[Simulation]) -> Iterator[Block]:
    """Yield the table of H_perc as recovered from the force, against the closed form."""
    rows = [x for run in runs for x in run.estimates]
    if rows:
        heading = w.H_PERC, f" recovered from the force, {w.stiffness_unit(runs[0].scene)}"
        caption = (
            *heading,
            "; its distance from the closed form, and the error of the simulation, estimated.",
        )
        agrees = w.Field("agrees", lambda x: _AGREES[x.agrees])
        shown = w.table(
            rows,
            caption,
            w.hertz(lambda x: w.cell(x.omega)),
            w.number("Re", lambda x: w.near(x.simulated.real)),
            w.number("Im", lambda x: w.near(x.simulated.imag)),
            w.number("difference", lambda x: w.near(x.difference, most=2)),
            w.number("estimated error", lambda x: w.near(x.error, most=2)),
            # Where all agree, the answer says so, and the column would be all yes.
            *[agrees] * (not all(x.agrees for x in rows)),
        )
        yield doc.Section(heading, (shown,))


def _verdict(runs: Sequence[Simulation]) -> Phrase:
    """Return whether the closed form agrees with the simulation, or is not exact for it."""
    rows = [x for run in runs for x in run.estimates]
    if not rows:
        return "not compared: no ratio is recovered from this motion, or from so short a run"
    reasons = dict.fromkeys(x.approximate for x in rows if x.approximate)
    if reasons:
        # The distance relative to H_perc; a closed form of 0 has none.
        sizes = [x.difference / abs(x.closed) for x in rows if x.approximate and x.closed]
        worst: Phrase = (
            ("; it differs by up to ", w.at_most(100 * max(sizes)), "\xa0%") if sizes else ""
        )
        return f"not exact here: {'; '.join(reasons)}", worst
    wrong = [w.cell(x.omega) for x in rows if not x.agrees]
    if wrong:
        return (
            Strong("disagrees"),
            " with the simulation at ",
            listed(wrong),
            "\xa0",
            FREQUENCY_UNIT,
        )
    where = f" at all {len(rows)} frequencies" if len(rows) > 1 else ""
    return f"agrees with the simulation{where}, within its estimated error"


# A release: what was let go, how the motion went on, and what the closed form gives for it.


def page_release(r: Release) -> Document:
    """Return the page of a release."""
    shown = "Motion after the hand lets go, and the envelope of the rightmost pole in closed form."
    chain = [_chain(r.closed)] if r.closed is not None and r.is_envelope else []
    blocks = (
        *_table_release(r),
        *limit_cycle_table(r.scene.motion, [(r.hand.name, x) for x in r.limit_cycles or ()]),
        *w.noted(chain),
        *w.caveats(r.caveats),
        doc.Facts(tuple(_run(r))),
        doc.Figure("release", shown, r.figure),
    )
    return w.page_about(r.scene, _answer(r), blocks, (_how_sure(r),), "Release test", r.asides())


def _answer(r: Release) -> Iterator[tuple[Phrase, Phrase]]:
    # With dry friction or an encoder the motion may end, which no linear loop does.
    """Yield how the motion goes on, and what the linear loop is proven to do."""
    rests = bool(r.extras) and r.stopped == "come to rest"
    motion: Phrase = (
        "undecided from this run" if r.grows is None else Strong("grows") if r.grows else "decays"
    )
    yield (
        "After release",
        _rattle(r) if r.rattle else "comes to rest (simulated)" if rests else motion,
    )
    left = _left_out(r)
    yield ("Linear loop", (_held(r), f", without {left}")) if left else ("Closed form", _held(r))


def _left_out(r: Release) -> str:
    """Return the names of what is not linear, which the linear loop is without."""
    effects = [x.name for x in r.scene.effects if x not in linear(r.scene).effects]
    return ", ".join([*effects, *["encoder and limit of the force"] * bool(r.extras)])


def _rattle(r: Release) -> Phrase:
    """Amplitude and frequency of the motion that stays."""
    assert r.rattle is not None
    size = w.near(r.rattle.amplitude), f" {r.unit} at "
    return (
        Strong("rattles"),
        " (simulated): amplitude ",
        *size,
        w.cell(r.rattle.omega),
        "\xa0",
        FREQUENCY_UNIT,
    )


def _run(r: Release) -> Iterator[tuple[str, Phrase]]:
    """Yield what was released: the hand, its displacement, the time, and which poles decide."""
    motion = r.scene.motion
    numbers = listed(
        (f"{p.key} = ", w.near(p.value, unit=p.shown_unit(motion))) for p in r.hand.parameters
    )
    yield "hand", (f"{r.hand.name}: ", numbers)
    yield "displaced by", (w.near(r.displacement), f" {r.unit}, at rest, then let go")
    yield (
        "time",
        ("0 to ", w.near(float(r.time[-1])), f" s{f' ({r.stopped})' if r.stopped else ''}"),
    )
    yield (
        "poles",
        "those of the sampled loop"
        if clocks(r.scene)
        else ("zeros of ", w.H_PERC, " + m s^2 + b s + k"),
    )


def _table_release(r: Release) -> Iterator[Block]:
    """Rate and frequency as read from the motion, and of the closed form."""
    rows: list[tuple[Phrase, ...]] = []
    if r.fitted is not None:
        # Of a chain of poles no single one lasts longest, so no frequency is read.
        omega: Phrase = "-" if r.is_envelope else w.cell(r.fitted.omega)
        rows.append(("simulated motion", w.near(r.fitted.rate), omega, f"{r.error:.2g}"))
    if r.closed is not None and not r.is_envelope:
        proven = "proven" if r.closed.root.certified else "not proven to be the rightmost"
        root = "largest pole z, ln z/T" if clocks(r.scene) else "rightmost pole"
        left = [x.name for x in r.scene.effects if x not in linear(r.scene).effects]
        without = f" without {', '.join(left)}" * bool(left)
        rows.append((root + without, w.near(r.closed.rate), w.cell(r.closed.omega), proven))
    if rows:
        caption = (
            "The motion that decays last: it goes as exp(rate t). The error of the simulated one "
            "is estimated."
        )
        yield w.table(
            rows,
            caption,
            w.Field("slowest decay", lambda x: x[0]),
            w.number("rate (1/s)", lambda x: x[1]),
            w.hertz(lambda x: x[2]),
            w.Field("error", lambda x: x[3]),
        )


def _held(r: Release) -> Phrase:
    """Return the proven verdict on the linear loop."""
    roots = r.held.roots
    if roots is None:
        return Strong("undecided"), f" ({r.held.reason})"
    if r.held.stable:
        return "stable: no unstable poles"
    if roots.chain is RootChain.NEAR:
        chain = (
            ": infinitely many poles come arbitrarily near to the axis, far above what a release "
            "moves"
        )
        return Strong("unstable"), chain
    return Strong("unstable"), ""


def _chain(closed: Closed) -> Phrase:
    """Return to which rate the poles of an infinite chain tend."""
    words = (
        "Infinitely many poles have rates that tend to {} 1/s: the simulated rate is that of the "
        "motion's largest values."
    )
    return w.phrased(words, w.near(closed.chain or 0.0))


def _how_sure(r: Release) -> Phrase:
    """Return what is proven and what is computed about a release."""
    if r.extras and r.held.roots is not None:
        return (
            "Proven: the verdict on the linear loop. Computed: the motion, a simulation with "
            "quantisation or saturation."
        )
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
