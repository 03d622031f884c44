"""Measures of transparency as a page of text and as LaTeX."""

from __future__ import annotations

from collections.abc import Sequence
from textwrap import fill

from haptisym.kernel.reals import RealNumber
from haptisym.pages.lines import WIDTH, caveats_text, listed, percent, short, span
from haptisym.verbs.metrics.forms import Form
from haptisym.verbs.metrics.measured import Bands
from haptisym.verbs.metrics.metric import Metric, Metrics, Value
from haptisym.writing.mathtext import text
from haptisym.writing.texlines import Names, Row, align
from haptisym.writing.texnames import coded, escape
from haptisym.writing.texprinter import tex

_PROVEN = (
    "Certain: every edge, band and number is proven by exact polynomials and ball arithmetic, not sampled. How far a source "
    "was read is said beside it."
)
_OPEN = (
    "UNDECIDED at the precision limit: whether some function touches its limit, crosses it twice or stays clear of it."
)


def as_text(m: Metrics) -> str:
    """A page of text."""
    blocks = [_heading(m), *map(_metric_text, m.metrics), _notes(m), caveats_text(m.evaluation.caveats), _certain(m)]
    return "\n\n".join(block for block in blocks if block) + "\n"


def _heading(m: Metrics) -> str:
    e = m.evaluation
    lines = [fill(line, WIDTH) for line in (e.scene.title or "Untitled scene", *m.asides())]
    return "\n".join([*lines, "", _indented(f"JND: {jnd_verdict(m)}")])


def jnd_verdict(m: Metrics) -> str:
    """What the JND evaluation says, in a line."""
    e = m.evaluation
    c = e.scene.threshold
    limits = percent(c.real) if c.real == c.imag else f"{percent(c.real)} and {percent(c.imag)}"
    if not e.transparent:
        return f"transparent nowhere on the band (c = {limits})"
    return f"transparent {_bands(e.transparent)} (c = {limits})"


def _metric_text(metric: Metric) -> str:
    lines = [_title(metric)]
    lines += [_formula_text(form) for form in metric.forms]
    width = max((len(x.what) for x in metric.values), default=0)
    lines += [_value_text(x, width) for x in metric.values]
    lines += [_indented(metric.verdict), _indented(f"Source: {metric.source} [{metric.evidence}]")]
    return "\n".join(lines)


def _formula_text(form: Form) -> str:
    line = text(form.equation).replace("omega", "ω")
    return fill(line, WIDTH, initial_indent="    ", subsequent_indent="        ", break_long_words=False)


def _value_text(x: Value, width: int) -> str:
    return fill(f"{x.what:<{width}}  {shown(x)}", WIDTH, initial_indent="  ", subsequent_indent=" " * (width + 4))


def shown(x: Value) -> str:
    """A value in words."""
    if x.value is None:
        return "infinite"
    if isinstance(x.value, tuple):
        return _bands(x.value) if x.value else "nowhere"
    number = f"{_number(x.value)} {x.unit}".rstrip()
    if x.reference is None:
        return number
    verdict = "kept" if x.kept else "NOT KEPT"
    return f"{number}, environment {_number(x.reference)} {x.unit}".rstrip() + f"; tolerance {x.tolerance}: {verdict}"


def _number(x: RealNumber | int | str) -> str:
    return short(x) if isinstance(x, RealNumber) else str(x)


def _bands(bands: Bands) -> str:
    return listed(span(x) for x in bands)


def _notes(m: Metrics) -> str:
    if not m.notes:
        return ""
    return "\n".join(["Where they disagree", *(_indented(note) for note in m.notes)])


def _certain(m: Metrics) -> str:
    return fill(_PROVEN if m.certified else _OPEN, WIDTH)


def _indented(words: str) -> str:
    return fill(words, WIDTH, initial_indent="  ", subsequent_indent="  ")


def as_latex(m: Metrics) -> str:
    r"""LaTeX: a table of verdicts (booktabs) and, for each measure, its formulas in an ``align*`` (amsmath)."""
    names = Names()
    asides = map(coded, m.asides())
    return "\n\n".join([*asides, _latex_table(m), *(_metric_latex(x, names) for x in m.metrics if x.forms)]) + "\n"


def _latex_table(m: Metrics) -> str:
    rows = [("JND", jnd_verdict(m), ""), *((x.name, x.verdict, x.evidence) for x in m.metrics)]
    lines = [" & ".join(map(escape, row)) + r" \\" for row in rows]
    head = [
        "\\begin{tabular}{lp{0.42\\linewidth}p{0.2\\linewidth}}",
        "  \\toprule",
        "  measure & verdict & source known \\\\",
    ]
    return "\n".join([*head, "  \\midrule", *(f"  {line}" for line in lines), "  \\bottomrule", "\\end{tabular}"])


def _metric_latex(metric: Metric, names: Names) -> str:
    source = f"{escape(metric.source)} ({escape(metric.evidence)})."
    return "\n".join([rf"\paragraph{{{escape(_title(metric))}}} {source}", *_aligned(metric.forms, names)])


def _title(metric: Metric) -> str:
    return f"{metric.name[0].upper()}{metric.name[1:]}"


def _aligned(forms: Sequence[Form], names: Names) -> list[str]:
    """Closed forms line by line; definitions that have none as they are."""
    rows = [
        Row(tex(x.left), x.value, tex(x.means) if x.means else "", relation=_TEX[x.relation])
        for x in forms
        if x.value is not None
    ]
    others = [rf"\[ {tex(x.equation)} \]" for x in forms if x.value is None]
    return [*([align(rows, names)] if rows else []), *others]


_TEX = {"=": "=", "≈": r"\approx"}
