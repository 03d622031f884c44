"""Random scenes as the text of a scene file."""

from __future__ import annotations

from fractions import Fraction

from oracles import Case, Element, Hertz

FORMULAS = {
    "expression": ("expression", 'H = "k*(s + z)/(s + q) + b*s"'),
    "gain": ("series", 'G = "g"'),
    "lead-lag": ("series", 'G = "(1 + s*T1)/(1 + s*T2)"'),
    "admittance-display": ("admittance-display", 'P = "w^2/(s^2 + w*s + w^2)"'),
    "two-port": ("two-port", 'A = "g"\nB = "d*s"\nC = "y/(s + q)"\nD = "1"'),
}


def _text(value: Fraction) -> str:
    return f'"{value.numerator}/{value.denominator}{" Hz" if isinstance(value, Hertz) else ""}"'


def _table(element: Element) -> str:
    """The keys of an environment or effect."""
    values = {name: _text(x) for name, x in element.values.items()}
    if element.kind in FORMULAS:
        model, formulas = FORMULAS[element.kind]
        listed = ", ".join(f"{name} = {x}" for name, x in values.items())
        return f'model = "{model}"\n{formulas}\nparameters = {{ {listed} }}\n'
    if element.kind == "prony":
        k, b = (f"[{values[f'{name}_1']}, {values[f'{name}_2']}]" for name in "kb")
        return f'model = "prony"\nk0 = {values["k0"]}\nk = {k}\nb = {b}\n'
    order = "order = 2\n" if element.kind == "pade-delay" else ""
    return f'model = "{element.kind}"\n{order}' + "".join(f"{name} = {x}\n" for name, x in values.items())


def toml(case: Case) -> str:
    """The scene file of a random scene."""
    effects = "".join(f"[[effects]]\n{_table(x)}" for x in case.between)
    low, high = map(_text, case.band)
    real, imag = (_text(case.c[part]) for part in ("real", "imag"))
    return (
        f"[environment]\n{_table(case.felt)}{effects}"
        f"[evaluation]\nband = [{low}, {high}]\njnd = {{ real = {real}, imag = {imag} }}\n"
    )
