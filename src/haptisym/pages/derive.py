"""The page of a derivation, and its document of JSON."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from haptisym.model.parameters import Parameter
from haptisym.model.quantities import Dimension, MotionKind, unit_text
from haptisym.pages.sections import sections
from haptisym.pages.words import page_about
from haptisym.verbs.derive.derivation import QUANTITIES, Derivation
from haptisym.writing.document import Column, Document, Equations, Line, Notes, Paragraph, Phrase, Section, Table, coded
from haptisym.writing.latex import fragment
from haptisym.writing.layout import layout
from haptisym.writing.mathml import mathml
from haptisym.writing.mathtext import plain, text
from haptisym.writing.names import named
from haptisym.writing.plain import said
from haptisym.writing.texprinter import formula, tex


def page(d: Derivation) -> Document:
    """The parameters, and the sections."""
    rows = tuple((named(p.symbol.name), _meaning(p, d.scene.motion), _state(d, p)) for p in d.scene.parameters)
    table = Table((Column("symbol"), Column("what it is"), Column("value")), rows, "The parameters, in SI units.")
    return page_about(d.scene, ((table,) if rows else ()) + sections(d), "Derivation", _asides(d))


def latex(d: Derivation) -> str:
    r"""LaTeX for a paper: a paragraph for each section, its equations in an ``align*``; amsmath is all it needs."""
    return fragment((*(Paragraph(coded(x)) for x in _asides(d)), *sections(d)), depth=2) + "\n"


def _asides(d: Derivation) -> list[str]:
    """That parameters vary, and what of the formulas holds for all of their values."""
    kept = any(p.interval for p in d.scene.parameters if p.symbol in d.kept)
    return [note + " Formulas in their symbols hold for all values." * kept for note in d.scene.asides()]


def _meaning(p: Parameter, motion: MotionKind | None) -> str:
    plain, unit = p.dimension in (Dimension.ANY, Dimension.RATIO), p.unit_in(motion)
    kind = "number" if plain else p.dimension.name.lower()
    return f"{kind}, {unit_text(unit)}" if unit not in ("", "1") else kind


def _state(d: Derivation, p: Parameter) -> Phrase:
    return ("a symbol; ", layout(p.value), " in the scene") if p.symbol in d.kept else layout(p.value)


def body(d: Derivation) -> dict[str, Any]:
    """What its document holds."""
    return {
        "parameters": [_parameter(d, p) for p in d.scene.parameters],
        "operations": d.steps.operations,
        "sections": [_section(section) for section in sections(d)],
        "quantities": list(QUANTITIES),
    }


def _parameter(d: Derivation, p: Parameter) -> dict[str, Any]:
    shown = {"text": plain(p.value), "latex": formula(p.value)}
    return {
        "name": p.symbol.name,
        "meaning": _meaning(p, d.scene.motion),
        "symbol": p.symbol in d.kept,
        "value": shown,
    }


def _section(section: Section) -> dict[str, Any]:
    boxes = [line.equation for line in lines_of(section)]
    rows = [{"text": text(e), "latex": tex(e), "mathml": mathml(e)} for e in boxes]
    notes = [said(x) for block in section.blocks if isinstance(block, Notes) for x in block.entries]
    return {"title": said(section.title), "notes": notes, "equations": rows}


def lines_of(section: Section) -> Iterator[Line]:
    """The equations of a section."""
    return (line for block in section.blocks if isinstance(block, Equations) for line in block.lines)
