"""A derivation as plain text, as LaTeX, as MathML and as JSON: the same sections, written four times."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape as escaped
from json import dumps
from textwrap import fill
from typing import Any

from haptisym.model.parameters import Parameter
from haptisym.model.quantities import Dimension, Motion
from haptisym.pages.lines import WIDTH
from haptisym.pages.sections import Phrase, Section, sections
from haptisym.verbs.derive.derivation import QUANTITIES, Derivation
from haptisym.writing.mathml import mathml
from haptisym.writing.mathtext import plain, text
from haptisym.writing.texlines import Names, Row, align
from haptisym.writing.texnames import coded, spaced
from haptisym.writing.texprinter import formula, tex


def page(d: Derivation) -> str:
    """The page of all sections."""
    return as_text(d, sections(d))


def as_text(d: Derivation, sections: Iterable[Section]) -> str:
    """A page of text."""
    blocks = [_heading(d), *map(_section_text, sections)]
    return "\n\n".join(block for block in blocks if block) + "\n"


def _heading(d: Derivation) -> str:
    rows = [f"  {p.symbol!s:<12} {_meaning(p, d.scene.motion):<34} {_state(d, p)}" for p in d.scene.parameters]
    title = [fill(x, WIDTH) for x in (d.scene.title or "Untitled scene", d.scene.source, *_asides(d)) if x]
    return "\n".join([*title, "", *rows])


def _asides(d: Derivation) -> list[str]:
    """That parameters vary, and what of the formulas holds for all of their values."""
    kept = any(p.interval for p in d.scene.parameters if p.symbol in d.kept)
    return [note + " Formulas in their symbols hold for all values." * kept for note in d.scene.asides()]


def _meaning(p: Parameter, motion: Motion | None) -> str:
    kind = "number" if p.dimension in (Dimension.ANY, Dimension.RATIO) else p.dimension.name.lower()
    unit = "" if p.dimension in (Dimension.ANY, Dimension.RATIO) else p.dimension.unit(motion)
    return f"{kind}, {unit}" if unit else kind


def _state(d: Derivation, p: Parameter) -> str:
    return f"a symbol; {plain(p.value)} in the scene" if p.symbol in d.kept else plain(p.value)


def _section_text(section: Section) -> str:
    lines = [_said(section.title)] if section.title else []
    lines += [fill(_said(x), WIDTH, initial_indent="  ", subsequent_indent="  ") for x in section.notes]
    lines += [_equation_text(text(line.equation)) for line in section.equations]
    return "\n".join(lines)


def _said(phrase: Phrase) -> str:
    """A phrase as plain text."""
    return _greek("".join(x if isinstance(x, str) else text(x) for x in phrase))


def _greek(line: str) -> str:
    return line.replace("omega", "ω")


def _equation_text(line: str) -> str:
    left, _, right = _greek(line).partition(" ")
    return fill(f"{left} {right}", WIDTH, initial_indent="    ", subsequent_indent="        ", break_long_words=False)


def as_latex(d: Derivation, sections: Iterable[Section]) -> str:
    r"""LaTeX for a paper: a paragraph for each section, its equations in an ``align*``."""
    names = Names()  # long numerators and denominators keep their names from section to section
    return "\n\n".join([*map(coded, _asides(d)), *(_section_latex(x, names) for x in sections)]) + "\n"


def _section_latex(section: Section, names: Names) -> str:
    words = [rf"\paragraph{{{_set(section.title)}}}"] if section.title else []
    words += [_set(note) for note in section.notes]
    if section.equations:
        words.append(
            align([Row(tex(x.left), x.value, relation=_RELATIONS[x.relation]) for x in section.equations], names)
        )
    return "\n".join(words)


def _set(phrase: Phrase) -> str:
    """A phrase in LaTeX."""
    return "".join(spaced(x) if isinstance(x, str) else f"${tex(x)}$" for x in phrase)


_RELATIONS = {"=": "=", "≈": r"\approx"}


def as_mathml(d: Derivation, sections: Iterable[Section]) -> str:
    """MathML for a page: a heading, its words and its equations, section after section."""
    lines = [f"<h2>{escaped(d.scene.title or 'Untitled scene')}</h2>", *(f"<p>{escaped(x)}</p>" for x in _asides(d))]
    for section in sections:
        lines += [f"<h3>{_marked(section.title)}</h3>"] if section.title else []
        lines += [f"<p>{_marked(note)}</p>" for note in section.notes]
        lines += [mathml(line.equation, display=True) for line in section.equations]
    return "\n".join(lines) + "\n"


def _marked(phrase: Phrase) -> str:
    """A phrase as MathML within HTML."""
    return "".join(escaped(x) if isinstance(x, str) else mathml(x) for x in phrase)


def as_json(d: Derivation, sections: Iterable[Section]) -> str:
    """The document of ``haptisym derive --json``, schema ``haptisym.derivation/1``."""
    return dumps(to_dict(d, sections), indent=2, ensure_ascii=False)


def to_dict(d: Derivation, sections: Iterable[Section]) -> dict[str, Any]:
    """The same as a dictionary."""
    return {
        "schema": "haptisym.derivation/1",
        "title": d.scene.title,
        "parameters": [_parameter(d, p) for p in d.scene.parameters],
        "operations": d.steps.operations,
        "sections": [_section(section) for section in sections],
        "quantities": list(QUANTITIES),
        **d.scene.aside_keys(),
    }


def _parameter(d: Derivation, p: Parameter) -> dict[str, Any]:
    meaning = _meaning(p, d.scene.motion)
    shown = {"text": plain(p.value), "latex": formula(p.value)}
    return {"name": p.symbol.name, "meaning": meaning, "symbol": p.symbol in d.kept, "value": shown}


def _section(section: Section) -> dict[str, Any]:
    boxes = [line.equation for line in section.equations]
    rows = [{"text": text(e), "latex": tex(e), "mathml": mathml(e)} for e in boxes]
    return {"title": _said(section.title), "notes": [_said(x) for x in section.notes], "equations": rows}
