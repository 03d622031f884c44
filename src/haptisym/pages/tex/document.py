r"""A scene's evaluation as a complete LaTeX document: definitions, formulas, thresholds, results, what is certain."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from haptisym.judge.evaluation import Evaluation
from haptisym.kernel.hertz import Hertz
from haptisym.model.catalogue import Effect
from haptisym.model.jnd import Part
from haptisym.model.parameters import Parameter
from haptisym.model.quantities import Dimension, Motion
from haptisym.pages.tex.forms import DIFFERENCE, DYNAMICS, FELT, RATIOS, RELATIVE, Group, SceneForms
from haptisym.pages.tex.latex import at_s
from haptisym.pages.tex.results import (
    certainty,
    changeovers,
    crossing_tables,
    listed,
    percept_tables,
    reservations,
    short,
    stability,
    tables,
    threshold_value,
    transparency,
    undecided_tables,
)
from haptisym.writing.numerals import rounded
from haptisym.writing.texlines import LINE, Names, Row, align, width
from haptisym.writing.texnames import coded, escape
from haptisym.writing.texprinter import formula


def document(evaluation: Evaluation, figures: Mapping[str, str] = MappingProxyType({})) -> str:
    """The whole document, for pdflatex with article, amsmath, booktabs and geometry; plain ASCII.

    ``figures`` : files of the figures of ``haptisym.figures.files``, by their names; with any, graphicx is needed too.

    >>> from haptisym import effects, environments
    >>> from haptisym.judge.evaluation import evaluate
    >>> from haptisym.model.scene import Scene
    >>> text = document(evaluate(Scene(environments.kelvin_voigt(290, 2), (effects.first_order_lag(100),))))
    >>> text.isascii(), text.count("begin{table}")
    (True, 3)
    """
    scene, body = evaluation.scene, _Body(evaluation, SceneForms(evaluation), figures)
    sections = {  # each is written when its turn comes: what is named is numbered in the order in which it is read
        "Scene": body.scene,
        "Dynamics": body.dynamics,
        "Distortion": body.distortion,
        "Step 1: when is it noticed?": body.when,
        "Step 2: how is it felt?": body.how,
        "Stability and certainty": body.certainty,
        "Threshold polynomials": body.thresholds,
    }
    written = [f"\\section{{{title}}}\n\n{_joined(paragraphs())}" for title, paragraphs in sections.items()]
    text = "\n\n".join([*written[:-1], "\\appendix", written[-1].replace("}", r"}\label{app:thresholds}", 1)])
    source = f"Source of the scene: {escape(scene.source.rstrip('. '))}.\n\n" if scene.source else ""
    source += "".join(f"{coded(aside)}\n\n" for aside in evaluation.given.asides())
    graphics = "\\usepackage{graphicx}\n" if figures else ""
    title = scene.title or "Untitled scene"
    return _TEMPLATE % (graphics, _information(f"{_TITLE}: {title}"), _TITLE, escape(title), source, text)


_TITLE = "Two-step evaluation of a haptic display"
_TEMPLATE = r"""\documentclass[a4paper]{article}
\usepackage[margin=2.5cm]{geometry}
\usepackage{amsmath}
\usepackage{booktabs}
%s\allowdisplaybreaks
\emergencystretch=3em
\setlength{\parindent}{0pt}
\setlength{\parskip}{\medskipamount}
\setlength{\abovecaptionskip}{0pt}
\setlength{\belowcaptionskip}{1ex}
\renewcommand{\Re}{\operatorname{Re}}
\renewcommand{\Im}{\operatorname{Im}}
%s
\title{%s\\[1ex] \large %s}
\author{}
\date{\today}

\begin{document}

\maketitle

%s%s

\end{document}
"""


def _information(title: str) -> str:
    """What the PDF says about itself, plain or in UTF-16, and an identity that does not depend on where it was made."""
    plain = re.fullmatch(r"[\w ,.:;'=/+-]*(?:\([\w ,.:;'=/+-]*\)[\w ,.:;'=/+-]*)*", title, re.ASCII)
    coded = ("\ufeff" + title).encode("utf-16-be").hex().upper()
    told = f"({title})" if plain else f"<{coded}>"
    return rf"\ifdefined\pdfinfo \pdfinfo{{/Title {told} /Creator (haptisym)}} \pdftrailerid{{}} \fi"


_CAPTIONS = {
    "ratios": "Distortion ratios over the band. Grey: neither exceeds its threshold, the display is transparent.",
    "projections-real": "Magnitude of the real part of the environment and of what is felt: bold where it is noticed.",
    "projections-imag": "Magnitude of the imaginary part of both: bold where it is noticed.",
    "nyquist": "Environment (solid) and what is felt (dashed) in the complex plane, towards higher frequencies.",
    "jnd-square": "Both at one frequency; the grey region holds the changes that are not noticed.",
}


def _drawn(figures: Mapping[str, str], *names: str) -> Iterator[str]:
    """Those of some figures that there are, side by side, each above its numbered caption."""
    here = [name for name in names if name in figures]
    if here:
        columns = "\\hfill\n".join(
            "\\begin{minipage}[t]{0.48\\linewidth}\\centering\n"
            f"\\includegraphics[width=\\linewidth]{{{figures[name]}}}\n"
            f"\\caption{{{_CAPTIONS[name]}\\label{{fig:{name}}}}}\n\\end{{minipage}}"
            for name in here
        )
        yield f"\\begin{{figure}}[!htbp]\n\\centering\n{columns}\n\\end{{figure}}"


def _references(figures: Mapping[str, str], *names: str) -> str:
    """Figures~1 and~2, as far as they are drawn."""
    here = [rf"\ref{{fig:{name}}}" for name in names if name in figures]
    return f"Figure{'s' if len(here) > 1 else ''}~{listed(here)}" if here else ""


_VALUES = r"the values of Table~\ref{tab:parameters}"


@dataclass(frozen=True)
class _Body:
    """The sections, each as paragraphs. Named numerators and denominators are shared by all of them."""

    evaluation: Evaluation
    forms: SceneForms
    figures: Mapping[str, str]
    names: Names = field(default_factory=Names)

    def scene(self) -> Iterator[str]:
        e = self.evaluation
        yield f"The environment, a model of the kind {escape(e.scene.environment.model)}, is felt {_through(e)}."
        yield from self._parameters()
        low, high = e.scene.band
        ends = " to ".join(short(Hertz(e.chart.points[i].omega)) for i in (0, -1))
        yield (
            rf"The band of interest is ${formula(low)} \le \omega \le {formula(high)}$ rad/s ({ends} Hz). A change of the "
            rf"real or the imaginary part is noticed when it exceeds {_limits(e)} of $|H_{{\mathrm{{env}}}}|$."
        )

    def _parameters(self) -> list[str]:
        scene = self.evaluation.scene
        rows = [self._parameter(", ".join(x.paths).removeprefix("effects."), x) for x in scene.parameters]
        columns = "l p{5cm} l l l" if any(len(row[1]) > 31 for row in rows) else "l l l l l"
        header = ["symbol", "parameter", "quantity", "value", "unit"]
        return tables("The parameters, in SI units.", "parameters", columns, header, rows)

    def _parameter(self, paths: str, p: Parameter) -> list[str]:
        quantity = "" if p.dimension is Dimension.ANY else p.dimension.name.lower()
        unit = p.dimension.unit(self.evaluation.scene.motion or Motion.TRANSLATION)
        symbol = formula(self.forms.short_names.get(p.symbol, p.symbol))
        return [f"${symbol}$", escape(paths), quantity, f"${_value(p)}$", _unit(unit)]

    def dynamics(self) -> Iterator[str]:
        scene = self.evaluation.scene
        rows = [Row(at_s("env"), scene.environment.dynamics)]
        sentences = ["Dynamics are force per position."]
        if scene.rendered:
            sentences.append(r"The controller renders $H_{\mathrm{rend}}$ for $H_{\mathrm{env}}$.")
            rows.append(Row(at_s("rendered"), scene.rendered.dynamics))
        for i, effect in enumerate(scene.effects, 1):
            action, entries = _action(i, effect)
            sentences.append(f"Effect {i}, {escape(effect.name)}, {action}.")
            rows += entries
        yield " ".join(sentences)
        yield self._align([*rows, *(self.forms.in_symbols(DYNAMICS) or [])[1:]])
        if scene.parameters:
            yield rf"With {_VALUES} (here and below, long numbers are rounded to six digits after $\approx$):"
            yield self._align(self.forms.in_numbers(DYNAMICS))

    def distortion(self) -> Iterator[str]:
        lead = r"On $s = \omega j$ the distortion $\Delta H = H_{\mathrm{perc}} - H_{\mathrm{env}}$ has the parts"
        yield from self._formulas(lead, DIFFERENCE)
        yield from self._formulas("The distortion ratios, which the threshold judges, are", RATIOS)
        yield from self._formulas("The relative distortion, not to be confused with them, is", RELATIVE)
        if self.evaluation.scene.parameters and self.forms.in_symbols(DIFFERENCE):
            yield f"With {_VALUES} the distortion is"
            yield self._align(self.forms.in_numbers(DIFFERENCE))

    def when(self) -> Iterator[str]:
        yield (
            r"A ratio exceeds its threshold where its square does, and so no root is needed: $r_r > c$ exactly where "
            r"$p_r(\omega) > 0$, and $r_r = c$ where $p_r(\omega) = 0$; likewise $r_i$ and $p_i$. Both are written in "
            r"Appendix~\ref{app:thresholds}."
        )
        if self.evaluation.crossings:
            yield r"The crossings are their roots on the band; Table~\ref{tab:crossings} lists all of them."
        yield from (*crossing_tables(self.evaluation), *undecided_tables(self.evaluation))
        yield transparency(self.evaluation) + self._see("ratios", "shows the ratios")
        yield from _drawn(self.figures, "ratios")

    def _see(self, name: str, says: str) -> str:
        found = _references(self.figures, name)
        return f" {found} {says}." if found else ""

    def thresholds(self) -> Iterator[str]:
        yield (
            r"The functions $p_r$ and $p_i$, which are positive exactly where the ratio exceeds its threshold, are "
            rf"{self._kind()} with exact coefficients (to ten digits after $\approx$), written here up to a positive factor:"
        )
        yield self._align([self.forms.threshold(part) for part in Part])

    def certainty(self) -> Iterator[str]:
        yield stability(self.evaluation)
        yield certainty(self.evaluation)

    def _kind(self) -> str:
        functions = self.evaluation.distortion.squared_modulus.axis.functions
        return r"polynomials in $\omega$, its powers, sines and cosines" if functions else r"polynomials in $\omega^2$"

    def how(self) -> Iterator[str]:
        lead = (
            r"$\Re H$ is felt as stiffness where it is positive and as mass where it is negative, $\Im H$ as damping. The "
            "stiffness, mass and damping perceived are"
        )
        yield from self._formulas(lead, FELT)
        if self.evaluation.felt:
            yield r"Table~\ref{tab:percepts} compares them with the environment's where the difference is noticed."
        yield from percept_tables(self.evaluation)
        yield changeovers(self.evaluation)
        yield from self._closed_changeovers()
        yield from reservations(self.evaluation)
        projections, plane = ("projections-real", "projections-imag"), ("nyquist", "jnd-square")
        if found := _references(self.figures, *projections):
            also = _references(self.figures, *plane)
            yield f"{found} show both parts of what is felt{f', {also} both at once' if also else ''}."
        yield from _drawn(self.figures, *projections)
        yield from _drawn(self.figures, *plane)

    def _closed_changeovers(self) -> Iterator[str]:
        d = self.forms.symbolic
        found = {"env": d.changeover_environment, "perc": d.changeover_perceived} if d else {}
        rows = [Row(rf"\omega_{{\mathrm{{{name}}}}}", form) for name, form in found.items() if form is not None]
        if rows := [row for row in rows if width(formula(row.value)) < LINE - 5]:
            yield "In closed form, the lowest frequencies of changeover, while they are real and positive, are"
            yield self._align(rows)

    def _formulas(self, lead: str, group: Group) -> Iterator[str]:
        """Closed forms in symbols; in numbers if they would be too long to read."""
        in_symbols = self.forms.in_symbols(group) if self.evaluation.scene.parameters else None
        rows = in_symbols or self.forms.in_numbers(group)
        is_explained = in_symbols or not self.evaluation.scene.parameters or all(row.optional for row in rows)
        yield lead if is_explained else f"{lead} (with {_VALUES}; too long in symbols)"
        yield self._align(rows)

    def _align(self, rows: list[Row]) -> str:
        return align(self.forms.named(rows), self.names)


def _joined(paragraphs: Iterable[str]) -> str:
    """Paragraphs; a display belongs to the one before it."""
    text = ""
    for paragraph in paragraphs:
        text += ("\n" if paragraph.startswith(r"\begin{align*}") else "\n\n" if text else "") + paragraph
    return text


def _through(e: Evaluation) -> str:
    effects = e.scene.effects
    if not effects:
        return "directly: nothing stands between it and the hand"
    names = [f"{escape(x.name)}{'' if x.name == x.model else f' ({escape(x.model)})'}" for x in effects]
    return f"through {listed(names)}{', in this order from the environment' if len(effects) > 1 else ''}"


def _limits(e: Evaluation) -> str:
    real, imag = (threshold_value(e.scene.threshold[part]) for part in Part)
    if real == imag:
        return f"the fraction $c {real}$"
    return f"the fraction $c {real}$ (real) or $c {imag}$ (imaginary)"


def _value(p: Parameter) -> str:
    """The exact value if it is short; a decimal beside it, or instead of it, if that says more."""
    exact, decimal = formula(p.value), formula(rounded(p.value))
    if len(exact) > 16:
        return rf"\approx {decimal}"
    return exact if p.value.is_Rational else rf"{exact} \approx {decimal}"


def _unit(unit: str) -> str:
    return unit.replace("*", r"\,").replace("^2", "$^{2}$") or "SI"


def _action(i: int, effect: Effect) -> tuple[str, list[Row]]:
    """What the effect of that number does to H, in words, and the formulas that the words name."""
    a, b, c, d = effect.dynamics
    if (b, c, d) == (0, 0, 1):
        return f"multiplies the force by $G_{{{i}}}$", [Row(f"G_{{{i}}}(s)", a)]
    if (a, c, d) == (1, 0, 1):
        return f"adds the impedance $Z_{{{i}}}$", [Row(f"Z_{{{i}}}(s)", b)]
    if (a, b, d) == (1, 0, 1):
        return f"adds the compliance $Y_{{{i}}}$ in series", [Row(f"Y_{{{i}}}(s)", c)]
    mapped = "$H$ becomes $(A_{0} H + B_{0})/(C_{0} H + D_{0})$".replace("0", str(i))
    return f"is a two-port: {mapped}", [Row(f"{x}_{{{i}}}(s)", y) for x, y in zip("ABCD", effect.dynamics, strict=True)]
