"""A derivation as a script of SymPy: symbols with their assumptions, the dynamics, then the distortion in named steps."""

from __future__ import annotations

import re
from collections.abc import Iterator

import sympy
from sympy import Expr, Function, Symbol
from sympy.printing.str import StrPrinter

from haptisym.kernel.rings import omega, s
from haptisym.programs.steps import DISTORTION
from haptisym.verbs.derive.derivation import Derivation
from haptisym.writing.code.languages import Language, comment, identifiers

_FUNCTIONS = frozenset(dir(sympy)) - {"s"}
_ALWAYS = ("Abs", "I", "Rational", "Symbol", "exp", "pi", "sqrt")  # what a script may call, whatever its names
_ASSUMED = ("positive", "nonnegative", "real")
_FACTORED = 400  # operations of H_perc up to which it is written in lowest terms


class _Printer(StrPrinter):  # type: ignore[misc]
    """Fractions stay exact where Python would divide them."""

    def _print_Rational(self, x: Expr) -> str:
        return str(x.p) if x.q == 1 else f"Rational({x.p}, {x.q})"

    def _print_Abs(self, x: Expr) -> str:
        return f"Abs({self._print(x.args[0])}, evaluate=False)"  # or SymPy multiplies out what stands in it


def script(d: Derivation) -> str:
    """The text of the script: run, it defines each symbol and each quantity by its name.

    >>> from haptisym.verbs.derive.derivation import derive
    >>> text = script(derive("delayed-spring"))
    >>> known = {}
    >>> exec(text, known)
    >>> known["H_perc"]
    k*exp(-s*tau)
    """
    return "\n".join(_lines(d)) + "\n"


def _lines(d: Derivation) -> Iterator[str]:
    steps = d.steps.only(DISTORTION)
    perceived = d["H_perc"]
    if perceived.count_ops() > _FACTORED:  # as the chain builds it
        perceived = d.chain.rendered
        for a, b, c, e in d.chain.matrices:
            perceived = (a * perceived + b) / (c * perceived + e)
    dynamics = {"H_env": d["H_env"], "H_perc": perceived}
    own = sorted(steps.free_symbols - {omega} | d.distortion.free_symbols, key=str)
    every = [omega, s, *own, *(x for x, _ in steps.definitions)]
    called = {f.func.__name__ for _, value in steps.definitions for f in value.atoms(Function)}
    taken = (*called, *_ALWAYS, *dynamics, *steps.results)
    names = identifiers((x.name for x in every), Language.NUMPY, taken)
    named = {x: Symbol(names[x.name]) for x in every}

    def text(form: Expr) -> str:
        return str(_Printer().doprint(form.xreplace(named)))

    rows = [(names[x.name], text(value)) for x, value in steps.definitions]
    rows += [(name, text(value)) for name, value in steps.results.items()]
    above = [(name, text(value)) for name, value in dynamics.items()]
    words = {word for _, value in (*rows, *above) for word in re.findall(r"[A-Za-z]\w*", value)}
    used = words & _FUNCTIONS - {*names.values()}
    yield f'"""{comment(d.scene.title or "Distortion of a haptic display")}'
    yield from ("", "H is force per position; s the Laplace variable, omega the frequency in rad/s. SI units.", '"""')
    yield from ("", f"from sympy import {', '.join(sorted({*used, 'Symbol'}))}", "")
    for x in (s, omega, *own):
        assumed = next((f", {a}=True" for a in _ASSUMED if getattr(x, f"is_{a}")), "")
        yield f'{names[x.name]} = Symbol("{comment(x.name)}"{assumed})'
    yield ""
    yield from (f"{name} = {value}" for name, value in above)
    yield from ("", "# Re and Im of dH = H_perc - H_env at s = j omega, over |H_env|, and of dH/H_env: in named steps")
    yield from (f"{name} = {value}" for name, value in rows)
