"""The paper's scene for the oracles, and any scene evaluated in a line."""

from __future__ import annotations

from fractions import Fraction

from oracles import Case, Element
from sympy import Rational

import haptisym as hs

ENVIRONMENT = Element("mass-spring-damper", {"m": Fraction(9, 5), "b": Fraction(15), "k": Fraction(100)})
FILTER = Element("second-order-lowpass", {"omega_n": Fraction(80), "zeta": Fraction(1, 2)})


def paper(high: int = 15, c: Fraction = Fraction(1, 10)) -> Case:
    return Case(ENVIRONMENT, (FILTER,), (Fraction(0), Fraction(high)), {"real": c, "imag": c})


def ask(environment: hs.Environment, *chain: hs.Effect, band: tuple[object, object] = (0, 15), c: object = "0.1",
        imag: object = None) -> hs.Evaluation:  # fmt: skip
    low, high = (Rational(str(x)) for x in band)
    return hs.evaluate(hs.Scene(environment, chain, (low, high), hs.Threshold.of(c, imag)))
