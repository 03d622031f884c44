"""The quantities of the evaluation by their names, typeset: what stands to the left of a closed form, and what it means.

H_env, H_perc, H_rendered   environment, what is felt instead, what is really rendered (functions of s)
dH, Re dH, Im dH            distortion H_perc - H_env (eq. 9); its parts on s = j omega
|H_env|, |H_env|^2          what they are compared with
r_r, r_i                    distortion ratios (eq. 10)
Re(dH/H_env), Im(dH/H_env)  relative distortion, which is something else
k_env, m_env, b_env         stiffness, mass and damping of the environment; k_perc, ... as felt
F_si_env, F_d_env           phasors of the force of spring or inertia, and of damping (eqs. 5 and 6); F_si_perc, ... as felt
omega_env, omega_perc       changeover between spring and inertia
p_r, p_i                    threshold polynomials: positive exactly where the ratio exceeds its threshold
omega_r, omega_i            crossing of the threshold
jnd k, jnd m, jnd b         the change of one parameter that is just noticed
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from sympy import Basic

from haptisym.kernel.errors import SceneError
from haptisym.writing.boxes import (
    Absolute,
    Applied,
    Box,
    Equation,
    Fraction,
    Name,
    Numeral,
    Operator,
    Power,
    Prefixed,
    Product,
    Sum,
    Titled,
    Word,
)
from haptisym.writing.layout import layout, named

_OMEGA, _J = named("omega"), named("j")
_SQUARED = Numeral("2")


def equation(name: str, value: Basic, *, relation: str = "=", explained: bool = False) -> Equation:
    """``name = value`` as boxes, for ``text`` (plain), ``tex`` and ``mathml``; ``explained``: with the meaning between them.

    name : one of those above. relation : ``=``, or ``≈`` where ``value`` was rounded.
    Raises SceneError for any other name.

    >>> from haptisym.writing.mathtext import text
    >>> from haptisym.kernel.rings import s, symbols
    >>> text(equation("H_env", symbols("k") + s)), text(equation("r_r", symbols("k"), explained=True))
    ('H_env(s) = s + k', 'r_r = |Re dH/H_env| = k')
    """
    sides: tuple[Box, ...] = (quantity(name), layout(value))
    relations: tuple[str, ...] = (relation,)
    if explained and _row(name)[1] is not None:
        sides, relations = (sides[0], meaning(name), sides[1]), ("=", relation)
    return Equation(sides, relations)


def quantity(name: str) -> Box:
    """A quantity as it is set: ``Re dH`` is the real part of Delta H(omega j)."""
    return _row(name)[0]


def meaning(name: str) -> Box:
    """What it is in terms of others; itself, if it is defined elsewhere."""
    set_as, means = _row(name)
    return means or set_as


def _row(name: str) -> tuple[Box, Box | None]:
    if name not in QUANTITIES:
        raise SceneError(f"{name!r} is not the name of a quantity: these are {', '.join(QUANTITIES)}")
    return QUANTITIES[name]


def function(name: str, *arguments: Box) -> Box:
    """A function of omega j (or of what is given), called by its name alone in plain text."""
    return Titled(name, Applied(named(name), arguments or (Product((_OMEGA, _J)),)))


def _on_s(name: str) -> Box:
    return Titled(f"{name}(s)", function(name.replace("rendered", "rend"), named("s")))


_CHANGE = Titled("dH", Prefixed(named("Delta"), function("H")))
_ENVIRONMENT = function("H_env")
_RELATIVE = Fraction(_CHANGE, _ENVIRONMENT)
_SIZE = Absolute(_ENVIRONMENT)
_LEAST = Product((named("c"), _SIZE))


def _of_change(operator: str, ratio: str) -> dict[str, tuple[Box, Box | None]]:
    part = Prefixed(Operator(operator), _CHANGE)
    return {
        f"{operator} dH": (part, None),
        ratio: (function(ratio, _OMEGA), Absolute(Fraction(part, _ENVIRONMENT))),
        f"p_{ratio[-1]}": (function(f"p_{ratio[-1]}", _OMEGA), None),
        f"omega_{ratio[-1]}": (named(f"omega_{ratio[-1]}"), None),
        f"{operator}(dH/H_env)": (Titled(f"{operator}(dH/H_env)", Prefixed(Operator(operator), _RELATIVE)), None),
    }


def _of_system(system: str) -> dict[str, tuple[Box, Box | None]]:
    H, X = function(f"H_{system}"), function("X")
    real, imag = (Prefixed(Operator(operator), H) for operator in ("Re", "Im"))
    k, m, b = (function(f"{letter}_{system}", _OMEGA) for letter in "kmb")
    return {
        f"H_{system}": (_on_s(f"H_{system}"), None),
        f"k_{system}": (k, real),
        f"m_{system}": (m, Sum(((-1, Fraction(k, Power(_OMEGA, _SQUARED))),))),
        f"b_{system}": (b, Fraction(imag, _OMEGA)),
        f"F_si_{system}": (_force("si", system), Product((X, real))),
        f"F_d_{system}": (_force("d", system), Product((X, imag, _J))),
        f"omega_{system}": (named(f"omega_{system}"), None),
    }


def _force(kind: str, system: str) -> Box:
    below = (Word(kind, upright=True), Word(system, upright=True))
    name = f"F_{kind}_{system}"
    return Titled(name, Applied(Name(name, Word("F", upright=False), below), (Product((_OMEGA, _J)),)))


def _of_parameter(key: str, means: Box) -> tuple[Box, Box | None]:
    return Prefixed(named("Delta_jnd"), named(key)), means


QUANTITIES: Mapping[str, tuple[Box, Box | None]] = MappingProxyType({
    **_of_system("env"), **_of_system("perc"), "H_rendered": (_on_s("H_rendered"), None),
    "dH": (Titled("dH(s)", Prefixed(named("Delta"), function("H", named("s")))), None),
    **_of_change("Re", "r_r"), **_of_change("Im", "r_i"),
    "|H_env|": (_SIZE, None), "|H_env|^2": (Power(_SIZE, _SQUARED), None),
    "jnd k": _of_parameter("k", _LEAST),
    "jnd b": _of_parameter("b", Fraction(_LEAST, _OMEGA)),
    "jnd m": _of_parameter("m", Fraction(_LEAST, Power(_OMEGA, _SQUARED))),
})  # fmt: skip
"""Each name with its box, and the box of its meaning where there is one."""
