"""Which effects matter, as a page of text."""

from __future__ import annotations

from textwrap import fill

from haptisym.model.jnd import Part
from haptisym.pages.lines import WIDTH, listed, rounded_up, table
from haptisym.verbs.effects.relevance import Enclosure, Relevance


def page(r: Relevance) -> str:
    """The answer of ``haptisym effects``: what matters, by how much each changes the ratios, where, and what is certain."""
    parts = [_heading(r), _verdict(r), _effects(r), _dominance(r), _crossings(r), _certain(r)]
    return "\n\n".join(part for part in parts if part) + "\n"


def _heading(r: Relevance) -> str:
    return "\n".join(
        fill(line, WIDTH) for line in (r.scene.title or "Untitled scene", r.scene.source, *r.scene.asides()) if line
    )


def _verdict(r: Relevance) -> str:
    kept, dropped = ([e.name for e in effects] for effects in (r.pruned.effects, r.dropped))
    names = listed(kept) or "none"
    of = f"{len(kept)} of {len(r.scene.effects)} effects matter: {names}."
    if not dropped:
        return fill(of, WIDTH)
    full, few = r.operations
    bounds = " and ".join(f"{name} by at most {rounded_up(r.bound[part].most)}" for name, part in _NAMES)
    return fill(
        f"{of} Without all others together, {bounds} anywhere on the band (tolerance {float(r.tolerance):g}). The distortion "
        f"then takes {few} operations, written in steps, where it took {full}.",
        WIDTH,
    )


_NAMES = (("r_r changes", Part.REAL), ("r_i", Part.IMAG))


def _effects(r: Relevance) -> str:
    if not r.effects:
        return "The scene has no effects."
    rows = [
        (x.effect.name, x.effect.model, *(rounded_up(x.change[part].most) for part in Part), "kept" if x.kept else "")
        for x in sorted(r.effects, key=lambda x: -max(change.most for change in x.change.values()))
    ]
    lines = ["Largest change of each ratio on the band by leaving out that effect alone", ""]
    lines.append(table(("effect", "model", "r_r", "r_i", ""), rows))
    if any(not change.is_finite for x in r.effects for change in x.change.values()):
        lines += ["", "  Unbounded: near a frequency where H_env = 0 or a dynamics is infinite, no bound exists."]
    return "\n".join(lines)


def _dominance(r: Relevance) -> str:
    if len(r.effects) < 2 or not r.dominance:
        return ""
    rows = [(f"{float(x.low):.4g} to {float(x.high):.4g}", x.effect.name) for x in r.dominance]
    return f"Which one changes the ratios most\n\n{table(('band (rad/s)', 'effect'), rows)}"


def _crossings(r: Relevance) -> str:
    if not r.crossings:
        return "The full scene has no crossing on the band."
    rows = [(x.part.value, _interval(x), _says(x)) for x in r.crossings]
    return f"Where the full scene's crossings are\n\n{table(('part', 'ω (rad/s)', ''), rows)}"


def _interval(x: Enclosure) -> str:
    low, high = x.bounds
    return f"{low:.6g}" if high - low < 1e-6 * high else f"{low:.6g} to {high:.6g}"


def _says(x: Enclosure) -> str:
    return "at least one" if x.certain else "none, one or several"


def _certain(r: Relevance) -> str:
    smallest = (
        f"No smaller set of effects stays within the tolerance, {float(r.tolerance):g}."
        if r.smallest
        else "This is the smallest set found; that no smaller one does is not proven."
    )
    return fill(
        "Certain: bounds are proven on the whole band by ball arithmetic, for all left-out effects together; outside the "
        f"intervals above the full scene has no crossing. {smallest}",
        WIDTH,
    )
