"""The criteria of the field's measures: the 3 dB edges, relative distortion, and Llewellyn's conditions on the axis."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import TypeAlias

from sympy import Expr, Integer, Rational, sqrt

from haptisym.judge.criteria import Criterion
from haptisym.kernel.errors import SceneError
from haptisym.kernel.response import RealFunction, on_axis, squared_modulus
from haptisym.model.distortion import Distortion
from haptisym.verbs.metrics.twoport import TwoPort


def ratio_square(d: Distortion) -> RealFunction:
    """|H_perc/H_env|^2."""
    return squared_modulus((d.perc / d.env).reduced())


def _below(d: Distortion) -> RealFunction:
    square = ratio_square(d)
    return RealFunction(square.axis.convert(Rational(1, 2))) - square


TOO_SMALL = Criterion("-3 dB", "-3 dB", "|H_perc/H_env|", "|H_perc/H_env| >= 1/sqrt(2)", _below)
TOO_LARGE = Criterion(
    "+3 dB", "+3 dB", "|H_perc/H_env|", "|H_perc/H_env| <= sqrt(2)", ratio_square, threshold=sqrt(Integer(2))
)
WITHIN_3_DB = (TOO_SMALL, TOO_LARGE)


def relative_square(d: Distortion) -> RealFunction:
    """|dH/H_env|^2."""
    return squared_modulus((d.difference / d.env).reduced())


def relative(c: Expr) -> Criterion:
    """|dH/H_env| <= c."""
    return Criterion("relative", "relative distortion", "|dH/H_env|", "|dH/H_env| <= c", relative_square, threshold=c)


_Hybrid: TypeAlias = Callable[[RealFunction, RealFunction, RealFunction, RealFunction], RealFunction]
"""Of Im h11, Im h22, Re g and |g|^2, with g = -h12 h21."""


def _read(rule: str, d: Distortion) -> RealFunction:
    port = TwoPort.of(d.chain, d.env.ring)  # type: ignore[arg-type]
    least, leak, gain = port.least, port.leak, port.gain
    if least is None or leak is None or gain is None:
        raise SceneError("D = 0: the hybrid matrix of this scene does not exist")
    return _CONDITIONS[rule](on_axis(least).imag, on_axis(leak).imag, on_axis(gain).real, squared_modulus(gain))


def _lack(own: RealFunction, other: RealFunction, real: RealFunction, _: RealFunction) -> RealFunction:
    """-(Re g - 2 Im h11 Im h22)."""
    return RealFunction((own * other).function + (own * other).function) - real


_CONDITIONS: Mapping[str, _Hybrid] = {
    "Im h11 >= 0": lambda own, *_: _nothing(own) - own,
    "Im h22 <= 0": lambda _own, other, *_: other,
    "Re g - 2 Im h11 Im h22 >= 0": _lack,
    "(Re g - 2 Im h11 Im h22)^2 >= |g|^2": lambda *x: x[3] - _lack(*x) * _lack(*x),
}
LLEWELLYN = tuple(Criterion(rule, rule, rule.split(" ")[0], rule, partial(_read, rule)) for rule in _CONDITIONS)
"""Conditions on the axis for absolute stability; those on the poles are others."""


def _nothing(f: RealFunction) -> RealFunction:
    return RealFunction(f.axis.zero)
