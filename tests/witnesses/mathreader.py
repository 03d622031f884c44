"""Reads presentation MathML back into an expression, knowing nothing of the writer. Whatever it does not expect is an error."""

from __future__ import annotations

import unicodedata
from collections.abc import Mapping
from xml.etree import ElementTree

import sympy as sp
from sympy import Expr, I, Rational, Symbol, pi

SPACE = "{http://www.w3.org/1998/Math/MathML}"
_FUNCTIONS = {"cos": sp.cos, "sin": sp.sin, "cosh": sp.cosh, "sinh": sp.sinh, "arcsin": sp.asin, "arccos": sp.acos, "arctan": sp.atan}  # fmt: skip
_TIMES = ("\u2062", "⋅", "×")
_APPLY = "\u2061"
_CLOSING = {"(": ")", "|": "|"}


def expression(mathml: str, known: Mapping[str, Symbol]) -> Expr:
    """The expression that a formula stands for; ``known`` maps names without marks (``omegan``) to symbols."""
    root = ElementTree.fromstring(mathml)
    assert root.tag == f"{SPACE}math"
    [inside] = root
    return _Reader(known).value(inside)


class _Reader:
    def __init__(self, known: Mapping[str, Symbol]) -> None:
        self.known = known

    def value(self, element: ElementTree.Element) -> Expr:
        return getattr(self, f"_{element.tag.removeprefix(SPACE)}")(element)

    def _mn(self, element: ElementTree.Element) -> Expr:
        return Rational(_text(element))

    def _mi(self, element: ElementTree.Element) -> Expr:
        return {"j": I, "π": pi}.get(_text(element)) or self._named(element)

    def _named(self, element: ElementTree.Element) -> Symbol:
        return self.known["".join(_spelt(c) for c in "".join(element.itertext()) if c not in ",\xa0")]

    _msub = _named

    def _mstyle(self, element: ElementTree.Element) -> Expr:
        [inside] = element
        return self.value(inside)

    def _msqrt(self, element: ElementTree.Element) -> Expr:
        [inside] = element
        return sp.sqrt(self.value(inside))

    def _mfrac(self, element: ElementTree.Element) -> Expr:
        above, below = element
        return self.value(above) / self.value(below)

    def _msup(self, element: ElementTree.Element) -> Expr:
        base, exponent = element
        if base.tag == f"{SPACE}mi" and _text(base) == "e":
            return sp.exp(self.value(exponent))
        return self.value(base) ** self.value(exponent)

    def _msubsup(self, element: ElementTree.Element) -> Expr:
        head, below, exponent = element
        base = ElementTree.Element(f"{SPACE}msub")
        base.extend([head, below])
        return self._named(base) ** self.value(exponent)

    def _mrow(self, element: ElementTree.Element) -> Expr:
        items = list(element)
        opening = _operator(items[0])
        if opening in _CLOSING:
            assert _operator(items[-1]) == _CLOSING[opening]
            [inside] = items[1:-1]
            return self.value(inside) if opening == "(" else sp.Abs(self.value(inside))
        if len(items) == 3 and _operator(items[1]) == _APPLY:
            return self._applied(items[0], items[2])
        return self._sum(items)

    def _applied(self, function: ElementTree.Element, argument: ElementTree.Element) -> Expr:
        if function.tag == f"{SPACE}msup":
            function, exponent = function
            return self._applied(function, argument) ** self.value(exponent)
        assert function.get("mathvariant") == "normal"
        return _FUNCTIONS[_text(function)](self.value(argument))

    def _sum(self, items: list[ElementTree.Element]) -> Expr:
        total, sign, factors = sp.S.Zero, 1, list[ElementTree.Element]()
        for item in items:
            if _operator(item) in ("+", "−"):
                assert factors or item is items[0]
                total += sign * self._product(factors) if factors else 0
                sign, factors = -1 if _operator(item) == "−" else 1, []
            else:
                factors.append(item)
        return total + sign * self._product(factors)

    def _product(self, items: list[ElementTree.Element]) -> Expr:
        result = self.value(items[0])
        for operator, item in zip(items[1::2], items[2::2], strict=True):
            assert _operator(operator) in (*_TIMES, "/")
            result = result / self.value(item) if _operator(operator) == "/" else result * self.value(item)
        return result


def _text(element: ElementTree.Element) -> str:
    assert element.text is not None
    assert not len(element)
    return element.text


def _operator(element: ElementTree.Element) -> str:
    return _text(element) if element.tag == f"{SPACE}mo" else ""


def _spelt(c: str) -> str:
    name = unicodedata.name(c)
    if not name.startswith("GREEK"):
        return c
    word = name.split()[-1].lower().replace("lamda", "lambda")
    return word.capitalize() if "CAPITAL" in name else word
