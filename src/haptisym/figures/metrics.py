"""The figure of the measures: |Gamma|, relative distortion and the JND ratios over the band, with the bands of each verdict."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from haptisym.figures import pen
from haptisym.figures.judged import is_share, limit_of
from haptisym.figures.sampling import band_of, ends_of, sampled
from haptisym.figures.sheet import stacked
from haptisym.figures.style import Look, dress, entries, legend, limit, name_frequency, scale_of
from haptisym.verbs.metrics.metric import Bands, Metrics

_DOTS_AND_DASHES: Any = (0, (5, 1.5, 1, 1.5))
_FINE: Any = (0, (1, 1))


def metrics_figure(m: Metrics) -> Figure:
    """Curves above; below, for each measure, a bar where it is content."""
    return stacked(3.4, (2.0, lambda ax: draw_measures(ax, m)), (1.1, lambda ax: draw_verdicts(ax, m)))


def draw_measures(
    ax: Axes, m: Metrics, *, color: str | None = None, label: str = "", hertz: bool | None = None
) -> list[Line2D]:
    """r_r, r_i, |dH/H_env| and | |Gamma| - 1 | over the band, with the thresholds: all are fractions of |H_env|.

    ``color``, ``label``, ``hertz`` : as of ``haptisym.figures.ratios.draw_ratios``. Returns the four lines.

    >>> from haptisym import load_scene, metrics
    >>> ax = Figure().add_subplot()
    >>> [line.get_label() for line in draw_measures(ax, metrics(load_scene("fu2019")))][:2]
    ['$r_\\\\mathrm{r}$', '$r_\\\\mathrm{i}$']
    """
    e = m.evaluation
    look, scale = Look.on(ax, r"$r_\mathrm{r}$", color, label), scale_of(ax, e.scene.band, hertz=hertz)
    omega = sampled(e)
    v = e.distortion.compile()(omega)
    env, perc = np.hypot(v.environment_real, v.environment_imag), np.hypot(v.perceived_real, v.perceived_imag)
    relative = np.hypot(v.ratio_real, v.ratio_imag)
    with np.errstate(divide="ignore", invalid="ignore"):
        size = np.abs(perc / env - 1)
    rows = (
        (v.ratio_real, pen.INK, pen.SOLID, r"$r_\mathrm{r}$"),
        (v.ratio_imag, pen.INK, pen.DASHED, r"$r_\mathrm{i}$"),
        (relative, pen.RED, _DOTS_AND_DASHES, r"$|\Delta H/H_\mathrm{env}|$"),
        (size, pen.BLUE, _FINE, r"$||\Gamma| - 1|$"),
    )
    lines = [
        line
        for values, own, style, name in rows
        for line in ax.plot(
            scale.of(omega), values, color=look.ink(own), linestyle=style, linewidth=1.1,
            label=f"{name}{look.suffix}",
        )
    ]  # fmt: skip
    limits = sorted({limit_of(x) for x in e.criteria if not is_share(x)})
    told = entries(ax)
    thresholds = [
        ax.axhline(c, color=pen.GREY, linewidth=0.6, label=f"$c = {c:.3g}$")
        for c in limits
        if f"$c = {c:.3g}$" not in told
    ]
    finite = relative[np.isfinite(relative)]
    most = max(limits, default=0.1)
    top = max(1.06 * float(finite.max()) if finite.size else 0.0, 1.6 * most)
    low, high = band_of(e)
    limit(ax, (scale.of(low), scale.of(high)), (0, min(top, 8 * most)), number=look.number)
    dress(ax, scale.label, r"fraction of $|H_\mathrm{env}|$")
    legend(ax, [*lines, *thresholds])
    return lines


def draw_verdicts(
    ax: Axes, m: Metrics, *, color: str | None = None, label: str = "", hertz: bool | None = None
) -> list[Line2D]:
    """A bar for each measure where it is content, the JND's at the top; those of a further scene below in its colour.

    Returns the bars.
    """
    before = len({str(line.get_color()) for line in ax.lines})
    look = Look(
        color or (pen.INK, pen.BLUE, pen.RED)[before % 3], color is not None, f", {label}" if label else "", before
    )
    scale = scale_of(ax, m.evaluation.scene.band, hertz=hertz)
    rows = verdict_bands(m)
    made: list[Line2D] = []
    for i, (_, bands) in enumerate(reversed(rows)):
        y = i - 0.24 * before
        for ends in (scale.of(np.array(ends_of(x))) for x in bands):
            marker: dict[str, Any] = {"marker": "|", "markersize": 6, "clip_on": False} if ends[0] == ends[1] else {}
            made += ax.plot(ends, [y, y], color=look.color, linewidth=_BAR, solid_capstyle="butt", **marker)
    if made and label:
        made[0].set_label(label)
        legend(ax, [*entries(ax).values(), made[0]])
    low, high = band_of(m.evaluation)
    limit(ax, (scale.of(low), scale.of(high)), (-0.6, len(rows) - 0.4), number=before)
    dress(ax)
    ax.set_yticks(range(len(rows)), [name for name, _ in reversed(rows)], fontsize=pen.SMALL)
    ax.tick_params(axis="y", length=0)
    name_frequency(ax, scale)
    return made


_BAR = 5.0
"""Points: how thick the bars are."""


def verdict_bands(m: Metrics) -> list[tuple[str, Bands]]:
    """Where each verdict is a good one, as far as it depends on the frequency."""
    own = m.measured
    rows = [
        ("JND", m.evaluation.transparent),
        (r"$|\Delta H/H_\mathrm{env}| \leq c$", own.within),
        ("within 3 dB", own.inside),
    ]
    stable = own.llewellyn
    return [
        *rows,
        (r"$\mathrm{Im}\,H_\mathrm{perc} \geq 0$", own.passive),
        *([("Llewellyn, axis", stable)] if stable is not None else []),
    ]
