"""The explorer of a scene in a notebook: sliders over a figure and the three lines of the result.

While a slider moves, the compiled closed forms are drawn: floating point on samples of the band.
When the sliders rest, the scene with their values is evaluated exactly, as ``evaluate`` does. Begin
with ``explore``. The sliders are those of a report (``pages.explorer``).
"""

from __future__ import annotations

from asyncio import TimerHandle, get_running_loop
from collections.abc import Callable, Mapping
from html import escape
from importlib import import_module
from io import BytesIO
from math import log10
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from sympy import Symbol

from haptisym.figures import pen
from haptisym.figures.curves import columns, evenly, limit_of, name_of
from haptisym.figures.layers import frequency
from haptisym.judge.crossings import noticed
from haptisym.judge.evaluation import Evaluation
from haptisym.kernel.errors import HaptisymError, SceneError
from haptisym.model.scene import Scene
from haptisym.model.scenefile import as_scene
from haptisym.pages.evaluation import findings, proven
from haptisym.pages.explorer import Slider, limit_sliders, parameter_sliders
from haptisym.pages.scene import SceneForms
from haptisym.verbs.evaluate.entry import evaluate
from haptisym.writing.document import Style
from haptisym.writing.layout import named
from haptisym.writing.plain import said

_QUIET = 0.3  # s without a change before the scene is evaluated exactly
# Steps of a slider, and of a decade of one: a slider takes its nearest step for what is typed,
# which must be the same to four digits. From 9.999 to the next one is a step of 4.3e-5 decades.
_STEPS, _STEPS_A_DECADE = 200_000, 25_000
_SIZE, _DOTS = (5.6, 3.2), 110  # inches of the figure, and dots per inch


class Explorer:
    """Sliders over a figure and the three lines of a result; a notebook shows them.

    ``evaluation`` : the exact result at the values at which the sliders rested last, as
    ``evaluate`` gives it; ``evaluation.scene`` is the scene with these values. ``sliders`` : the
    widget of each number, by its path. ``text`` : the lines as they are shown. ``widget`` : all of
    it, of ipywidgets.

    Lines that are computed (floating point, no error bound) are marked as computed, and replaced
    when the sliders rest. A value that the model does not allow is named in place of the lines.
    """

    def __init__(self, scene: Scene, widgets: Any) -> None:
        self.evaluation = evaluate(scene)
        self.sliders: dict[str, Any] = {}
        self.text = ""
        self._given = scene
        self._forms = SceneForms(self.evaluation)
        symbolic = self._forms.symbolic
        self._compiled: Callable[..., Any] | None = symbolic.compile() if symbolic else None
        self._used = {x.name for x in symbolic.free_symbols} if symbolic else set()
        self._timer: TimerHandle | None = None
        self._marks = [
            (path, slider.shown(), f"{name} ({slider.unit.text})" if slider.unit.text else name)
            for path, slider, name in _sliders(self.evaluation, self._forms)
        ]
        for path, slider, name in self._marks:
            self.sliders[path] = _widget(widgets, slider, name)
            self.sliders[path].observe(lambda _: self._moved(), names="value")
        self._image = widgets.Image(format="png")
        self._lines = widgets.HTML()
        reset = widgets.Button(description="Reset")
        reset.on_click(lambda _: self._reset())
        self.widget = widgets.VBox([self._lines, self._image, *self.sliders.values(), reset])
        self._settle()

    def _ipython_display_(self) -> None:
        import_module("IPython.display").display(self.widget)

    def _values(self) -> dict[str, float | str]:
        """The values of the sliders that are not where the scene has them: SI, or in the unit in
        which the scene gives them."""
        at = ((path, slider, self.sliders[path].value) for path, slider, _ in self._marks)
        moved = {
            path: (slider.unit, float(f"{x:.4g}")) for path, slider, x in at if x != slider.value
        }
        return {
            path: x if unit.size == 1 else f"{x} {unit.name}" for path, (unit, x) in moved.items()
        }

    def _moved(self) -> None:
        """Draw what the sliders show, and evaluate it once they rest."""
        try:
            scene = self._given.with_values(self._values())
        except HaptisymError as wrong:
            self._say(str(wrong))
            return
        if self._compiled:
            self._draw(scene, self._compiled)
        if self._timer:
            self._timer.cancel()
        try:
            self._timer = get_running_loop().call_later(_QUIET, self._settle)
        except RuntimeError:  # no loop runs: nothing else can move meanwhile
            self._settle()

    def _reset(self) -> None:
        for path, slider, _ in self._marks:
            self.sliders[path].value = slider.value

    def _settle(self) -> None:
        """Evaluate the scene at the sliders' values."""
        try:
            found = self.evaluation = evaluate(self._given.with_values(self._values()))
        except HaptisymError as wrong:
            self._say(str(wrong))
            return
        printed = Style(frequency=found.scene.frequency).phrase
        rows = [f"{said(name):<11}{said(printed(value))}" for name, value in findings(found)]
        self._say("\n".join([*rows, *(said(printed(x)) for x in proven(found))]))
        ax = found.plot(_axes())
        self._show(ax)
        self._judged = ax.get_ylabel()
        omega = evenly(found)
        self._rested = columns(found.criteria, found.distortion.compile()(omega), omega)

    def _draw(self, scene: Scene, compiled: Callable[..., Any]) -> None:
        """Draw the compiled closed forms at a scene's values, the last exact ones in grey."""
        numbers = {p.symbol.name: float(p.value) for p in scene.parameters}
        omega = evenly(self.evaluation)
        across = frequency(scene.frequency)
        values = compiled(omega, **{x: numbers[x] for x in self._used if x in numbers})
        criteria = noticed(scene.threshold)
        limits = [limit_of(x) for x in criteria]
        ratios = columns(criteria, values, omega)
        ax = _axes()
        for old, new, x, stroke in zip(
            self._rested.T, ratios.T, criteria, pen.STROKES, strict=False
        ):
            ax.plot(across.of(omega), old, color=pen.GREY, linestyle=stroke, linewidth=0.7)
            ax.plot(across.of(omega), new, color=pen.INK, linestyle=stroke, label=name_of(x))
        for limit in set(limits):
            ax.axhline(limit, color=pen.GREY, linewidth=0.7)
        top = max(1.06 * float(np.nanquantile(ratios, 0.97)), *(2 * limit for limit in limits))
        ax.set(
            xlim=(across.of(omega[0]), across.of(omega[-1])),
            ylim=(0, top),
            xlabel=across.text,
            ylabel=self._judged,
        )
        ax.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=2, frameon=False)
        self._show(ax)
        outside = np.flatnonzero(~(ratios <= limits).all(axis=1))
        if not outside.size:
            least = "the whole band"
        elif outside[0] == 0:
            least = "none: noticed at the lower end of the band"
        else:  # it lies between two samples
            below, above = across.of(omega[outside[0] - 1]), across.of(omega[outside[0]])
            least = f"{below:.4g} to {above:.4g} {across.unit.text}"
        self._say(
            f"Bandwidth  {least}\nFelt as    (when the sliders rest)\nStability  (when the sliders "
            f"rest)\nComputed: floating point on {len(omega)} samples of the band, no error bound."
        )

    def _show(self, ax: Any) -> None:
        made = BytesIO()
        ax.figure.savefig(made, format="png", dpi=_DOTS)
        self._image.value = made.getvalue()

    def _say(self, text: str) -> None:
        self.text = text.replace("\N{NO-BREAK SPACE}", " ")
        self._lines.value = f"<pre>{escape(self.text)}</pre>"


def _axes() -> Any:
    """Empty axes, always at the same place, so that the picture does not jump."""
    figure = Figure(_SIZE)
    figure.subplots_adjust(left=0.11, right=0.97, bottom=0.15, top=0.82)
    return figure.add_subplot()


def explore(scene: Scene | str | Path) -> Explorer:
    """Sliders for the numbers of a scene, in a notebook, over a figure and the three lines of its
    result.

    ``scene`` : a Scene, the name of a shipped one, or the path of a scene file. While a slider
    moves, the ratios are computed (floating point, no error bound); when it rests, the result is
    that of ``evaluate``. Returns an ``Explorer``, whose ``evaluation`` is the last exact result.

    Needs Jupyter with ipywidgets, ``pip install haptisym[notebook]``. SceneError without it or
    outside of a notebook, where ``haptisym evaluate SCENE --report FILE.html`` writes a page with
    sliders.
    """
    found = as_scene(scene)
    try:
        widgets = import_module("ipywidgets")
        shell = import_module("IPython").get_ipython()
    except ImportError as missing:
        raise SceneError(
            f'explore: {missing.name} is missing: "pip install haptisym[notebook]"; {_ELSEWHERE}'
        ) from None
    if not hasattr(shell, "kernel"):
        raise SceneError(f"explore: sliders need a notebook (Jupyter); {_ELSEWHERE}")
    return Explorer(found, widgets)


_ELSEWHERE = "haptisym evaluate SCENE --report FILE.html writes a page with sliders without it"


def _sliders(e: Evaluation, forms: SceneForms) -> list[tuple[str, Slider, str]]:
    """The path, the slider and the name of each number that can be moved, as a report has it."""
    by_symbol = parameter_sliders(e, forms)
    moved = [
        (f"{p.place}.{p.key}", by_symbol[p.symbol][0], _name(forms.short_names, p.symbol))
        for p in e.scene.parameters
        if p.symbol in by_symbol
    ]
    paths = {knob.path for knob in e.scene.knobs}
    limits = limit_sliders(e.scene)
    shared = len({id(slider) for slider, _ in limits.values()}) == 1
    for key, (slider, _) in limits.items():
        path = "evaluation.jnd" if shared else f"evaluation.jnd.{key}"
        if path in paths and path not in [x for x, _, _ in moved]:
            part, _, side = key.partition(".")
            name = "c" if shared else said(named(f"c_{part}")) + " ↓" * bool(side)
            moved.append((path, slider, name))
    return moved


def _name(short: Mapping[Symbol, Symbol], symbol: Symbol) -> str:
    """Return the name of a parameter, short where the effect's is long: ``ω_n``."""
    return said(named(short.get(symbol, symbol).name))


def _widget(widgets: Any, slider: Slider, name: str) -> Any:
    """A slider of ipywidgets."""
    look = {"style": {"description_width": "9em"}, "layout": {"width": "34em"}}
    given = {"value": slider.value, "description": name, "readout_format": ".4g", **look}
    if not slider.is_logarithmic:
        step = (slider.high - slider.low) / _STEPS
        return widgets.FloatSlider(min=slider.low, max=slider.high, step=step, **given)
    low, high = log10(slider.low), log10(slider.high)
    return widgets.FloatLogSlider(min=low, max=high, step=1 / _STEPS_A_DECADE, **given)
