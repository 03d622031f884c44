"""Sampled loops whose roots are known: put there by the controller, or eigenvalues of what one period does to the state."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from random import Random
from typing import Any

import numpy as np
from scipy.linalg import expm
from sympy import Expr, Poly, Symbol

import haptisym as hs

w = Symbol("w")  # 1/z
NOTHING = hs.Hand("nothing")


def placed(C: Expr, parameters: Mapping[str, Any]) -> hs.Scene:
    """A loop of period 1 s whose characteristic polynomial is C(w), C(0) = 1, held by nothing.

    The device b s = s makes w/(1 - w) of a held force, and by backward differences a felt H(s) is D(w) = H(1 - w): together
    (1 - w) + w D(w) = C.
    """
    D = Poly(((C - 1) / w + 1).expand(), w).as_expr()
    felt = hs.environments.expression(
        str(D.subs(w, 1 - Symbol("s")).expand()).replace("**", "^"), parameters=parameters
    )
    effects = hs.effects.sampled_loop("1 s", "backward-difference"), hs.effects.shunt(b=1)
    return hs.Scene(felt, effects, hands=(NOTHING,))


@dataclass(frozen=True)
class Wall:
    """A spring and a damper of any sign behind a clock, a device, perhaps on a soft drive, and a hand.

    ``samples``, ``late`` : whole samples of computation, and a delay in s behind them.
    """

    numbers: Mapping[str, str]
    method: str = "backward-difference"
    samples: int = 0
    late: str = "0"
    soft: Mapping[str, str] = field(default_factory=dict)

    @property
    def scene(self) -> hs.Scene:
        x = self.numbers
        felt = hs.environments.expression("k + b*s", parameters={"k": f"{x['k']} N/m", "b": f"{x['b']} N*s/m"})
        effects = [hs.effects.sampled_loop(f"{x['T']} s", self.method, self.samples)]
        effects += [hs.effects.delay(f"{self.late} s")] if float(self.late) else []
        effects.append(hs.effects.shunt(m=x["m"], b=x["d"]))
        effects += [hs.effects.compliance(**self.soft)] if self.soft else []
        return hs.Scene(felt, tuple(effects), hands=(hs.Hand("hand", x["m_h"], x["b_h"], x["k_h"]),))

    def eigenvalues(self, **changed: float) -> Any:
        """Of x_(n+1) = M x_n, x being the state, the sample before and the forces on their way; other numbers than its own where given."""
        x = {key: float(value) for key, value in self.numbers.items()} | changed
        T, (A, B) = x["T"], self._plant(x)
        whole, rest = divmod(round((self.samples * T + float(self.late)) / T, 9), 1)
        ell, n, theta = int(whole), len(B), rest * T
        if self.method == "tustin" and x["b"]:  # without a damper its pole cancels
            now, before, back = x["k"] + 2 * x["b"] / T, x["k"] - 2 * x["b"] / T, 1.0
        else:
            now, before, back = x["k"] + x["b"] / T, -x["b"] / T, 0.0
        unit = np.eye(n + 2 + ell)
        force = -now * unit[0] - before * unit[n] - back * unit[n + 1]
        forces = [force, *unit[n + 1 :]]
        Phi, recent = _held(A, B, T - theta)
        older, early = _held(A, B, theta)
        M = np.zeros_like(unit)
        M[:n, :n] = Phi @ older
        M[:n] += np.outer(recent, forces[ell]) + np.outer(Phi @ early, forces[ell + 1])
        M[n] = unit[0]
        M[n + 1 :] = forces[: ell + 1]
        return np.linalg.eigvals(M)

    def radius(self, **changed: float) -> float:
        """The largest size of an eigenvalue."""
        return float(abs(self.eigenvalues(**changed)).max())

    def _plant(self, x: Mapping[str, float]) -> tuple[Any, Any]:
        """The motion of the device, and of the hand if a drive lies in between."""
        m, d, m_h, b_h, k_h = (x[key] for key in ("m", "d", "m_h", "b_h", "k_h"))
        if not self.soft:
            total = m + m_h
            return ((0.0, 1.0), (-k_h / total, -(d + b_h) / total)), (0.0, 1 / total)
        k, b = (float(self.soft[key]) for key in "kb")
        device = (0.0, 1.0, 0.0, 0.0), (-k / m, -(b + d) / m, k / m, b / m)
        hand = (0.0, 0.0, 0.0, 1.0), (k / m_h, b / m_h, -(k + k_h) / m_h, -(b + b_h) / m_h)
        return (*device, *hand), (0.0, 1 / m, 0.0, 0.0)


@cache
def _held(A: tuple[tuple[float, ...], ...], B: tuple[float, ...], T: float) -> tuple[Any, Any]:
    """exp(A T), and what a force that is held for T adds."""
    n = len(B)
    both = np.zeros((n + 1, n + 1))
    both[:n, :n], both[:n, n] = A, B
    moved = expm(both * T)
    return moved[:n, :n], moved[:n, n]


def wall(draw: Random, *, plain: bool = False) -> Wall:
    """At random; ``plain``: by backward differences, without a drive, and late by whole samples alone."""
    numbers = {
        "k": draw.choice(["0", "40", "900"]), "b": draw.choice(["0", "0.5", "3"]), "T": draw.choice(["0.001", "0.004", "0.02"]),
        "m": draw.choice(["0.05", "0.3"]), "d": draw.choice(["0.1", "0.2", "2"]), "m_h": draw.choice(["0.1", "0.2"]),
        "b_h": draw.choice(["0.1", "4", "30"]), "k_h": draw.choice(["5", "200"]),
    }  # fmt: skip
    samples = draw.choice([0, 0, 1, 2])
    if plain:
        return Wall(numbers, samples=samples)
    soft = {"k": draw.choice(["900", "20000"]), "b": draw.choice(["0.5", "9"])} if draw.random() < 0.5 else {}
    return Wall(numbers, draw.choice(["tustin", "backward-difference"]), samples, draw.choice(["0", "0.0013"]), soft)
