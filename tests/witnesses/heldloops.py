"""Displays in hands for tests of stability, and a second count of their roots: by how often a sampled contour winds around 0."""

from __future__ import annotations

from collections.abc import Callable
from random import Random
from typing import Any

import numpy as np
from sympy import lambdify
from windings import Function, winding

import haptisym as hs
from haptisym.kernel.rings import s

E, F = hs.environments, hs.effects


def closed(scene: hs.Scene, hand: hs.Hand) -> Function:
    """H_perc + m s^2 + b s + k, times the denominator of H_perc: of arrays of s."""
    H = scene.distortion().perc
    top, below = (lambdify(s, H.ring.expression(x), "numpy") for x in (H.numerator, H.denominator))
    m, b, k = (float(p.value) for p in hand.parameters)
    return lambda z: top(z) + (m * z * z + b * z + k) * below(z)


def on_the_right(scene: hs.Scene, reach: float = 500.0) -> int | None:
    """The roots in Re s > 0 of a display in its first hand, up to a size."""
    return winding(closed(scene, scene.hands[0]), reach)


def poles_on_the_right(scene: hs.Scene, reach: float = 500.0) -> int | None:
    """The same of the poles of H_perc."""
    H = scene.distortion().perc
    below = lambdify(s, H.ring.expression(H.denominator), "numpy")
    return winding(lambda z: below(z) + 0 * z, reach)


def display(perceived: str, **parameters: Any) -> hs.Scene:
    """One whose H_perc is what is written."""
    return hs.Scene(E.mass_spring_damper(k=1), (F.series(perceived, parameters=parameters),))


def number(draw: Random, low: float, high: float) -> str:
    """Of three digits."""
    return f"{draw.uniform(low, high):.3g}"


def drawn(draw: Random, *, late: bool) -> hs.Scene:
    """Mass, damper and spring, behind a low pass, a delay and a shunt, or some of these."""
    own = {"m": (0.05, 2), "b": (0.1, 9), "k": (5, 300)}
    felt = {x: number(draw, *ends) for x, ends in own.items() if x == "k" or draw.random() < 0.5}
    behind = [F.second_order_lowpass(number(draw, 5, 60), number(draw, 0.2, 1))] if draw.random() < 0.6 else []
    behind += [F.delay(f"{draw.randint(5, 90)} ms")] if late else []
    behind += [F.shunt(m=number(draw, 0.05, 0.5), b=number(draw, 0.1, 3))] if draw.random() < 0.4 else []
    return hs.Scene(E.mass_spring_damper(**felt), tuple(behind))


def by_eigenvalues(top: Callable[[float], list[float]], value: float) -> int | None:
    """Zeros in Re s > 0 of a polynomial whose coefficients, the highest first, hang on a number; None where one is near the axis."""
    real = np.roots(np.trim_zeros(np.array(top(value), float), "f")).real
    return None if len(real) and np.abs(real).min() < 1e-6 else int((real > 0).sum())
