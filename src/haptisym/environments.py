"""The catalogue of environments: what should be felt, as dynamic stiffness H(s) = F(s)/X(s).

Parameters are numbers in SI, strings with units (``"1.8 kg"``) or SymPy symbols. Units are given
for a translation; for a rotation read kg m^2, N m s/rad and N m/rad. Each function returns an
``Environment`` and raises ``SceneError`` for a wrong unit, a negative value or a missing parameter.
"""

from __future__ import annotations

from sympy import Expr

from haptisym.kernel.errors import SceneError
from haptisym.kernel.rings import s
from haptisym.model.catalogue import environment
from haptisym.model.parameters import (
    Damping,
    DampingList,
    Formula,
    FormulaInZ,
    FractionalOrder,
    FractionalStiffness,
    Mass,
    PositiveDamping,
    PositiveMass,
    PositiveStiffness,
    Stiffness,
    StiffnessList,
)


@environment("mass-spring-damper")
def mass_spring_damper(m: Mass = 0, b: Damping = 0, k: Stiffness = 0) -> Expr:
    """Mass, spring and damper: H(s) = m s^2 + b s + k.

    m : mass, kg; b : damping, N s/m; k : stiffness, N/m. All >= 0; each may be absent, but not all
    of them.
    Source: Fu, van Paassen and Mulder (2019), eq. (7).

    >>> mass_spring_damper("1.8 kg", "15 N*s/m", "100 N/m").H
    9*s**2/5 + 15*s + 100
    """
    if not (m or b or k):
        raise SceneError("mass-spring-damper: give at least one of m, b, k")
    return m * s**2 + b * s + k


@environment("kelvin-voigt")
def kelvin_voigt(k: Stiffness, b: Damping) -> Expr:
    """Spring and damper side by side: H(s) = k + b s.

    k : stiffness, N/m; b : damping, N s/m. Both >= 0.

    >>> kelvin_voigt(290, 2).H
    2*s + 290
    """
    return k + b * s


@environment("maxwell")
def maxwell(k: PositiveStiffness, b: PositiveDamping) -> Expr:
    """Spring and damper in a row: H(s) = k b s/(k + b s). A fluid: it gives way to a steady force.

    k : stiffness, N/m; b : damping, N s/m. Both > 0.

    >>> maxwell(100, 5).H
    500*s/(5*s + 100)
    """
    return k * b * s / (k + b * s)


@environment("zener")
def zener(k0: Stiffness, k1: PositiveStiffness, b1: PositiveDamping) -> Expr:
    """Standard linear solid (Zener, Kelvin-Boltzmann): H(s) = k0 + k1 b1 s/(k1 + b1 s).

    k0 : relaxed stiffness, N/m, >= 0; k1 : stiffness of the Maxwell branch, N/m; b1 : its damping,
    N s/m, both > 0.

    >>> zener(200, 300, 6).H
    1800*s/(6*s + 300) + 200
    """
    return k0 + k1 * b1 * s / (k1 + b1 * s)


@environment("prony")
def prony(k0: Stiffness, k: StiffnessList, b: DampingList) -> Expr:
    """Generalised Maxwell solid (Prony series): H(s) = k0 + sum of k_i b_i s/(k_i + b_i s).

    k0 : relaxed stiffness, N/m, >= 0; k : stiffnesses of the branches, N/m; b : their dampings, N
    s/m; all > 0.

    >>> prony(200, ["300 N/m"], ["6 N*s/m"]).H == zener(200, 300, 6).H
    True
    """
    if len(k) != len(b):
        raise SceneError(f"k and b need equally many entries, not {len(k)} and {len(b)}")
    return k0 + sum(ki * bi * s / (ki + bi * s) for ki, bi in zip(k, b, strict=True))


@environment("spring-pot")
def spring_pot(k_alpha: FractionalStiffness, alpha: FractionalOrder, k: Stiffness = 0) -> Expr:
    """Fractional (spring-pot) tissue, with k fractional Kelvin-Voigt: H(s) = k + k_alpha s^alpha.

    k_alpha : N s^alpha/m, > 0, may be given bare; alpha : order, 0 < alpha < 1 (0 would be a
    spring, 1 a damper); k : stiffness parallel to it, N/m, >= 0, may be absent.

    >>> spring_pot(100, "0.25").H
    100*s**(1/4)
    """
    return k + k_alpha * s**alpha


@environment("two-mass")
def two_mass(
    m1: Mass, b1: Damping, k1: Stiffness, m2: PositiveMass, b2: Damping, k2: Stiffness
) -> Expr:
    """A second mass on a spring and damper: H(s) = m1 s^2 + b1 s + k1 + (k2 + b2 s) m2 s^2/(m2 s^2
    + b2 s + k2).

    m1, b1, k1 : what the hand holds; m2, b2, k2 : what hangs on it (m2 > 0). kg, N s/m, N/m, all >=
    0.

    >>> two_mass(1, 0, 0, 1, 0, 100).H
    s**2 + 100*s**2/(s**2 + 100)
    """
    return m1 * s**2 + b1 * s + k1 + (k2 + b2 * s) * m2 * s**2 / (m2 * s**2 + b2 * s + k2)


@environment("expression")
def expression(H: Formula) -> Expr:
    """Any dynamics: H(s) = the formula.

    H : formula in ``s`` and the names of ``parameters``, a mapping from name to number or string
    with unit.

    >>> expression("m*s^2 + k", parameters={"m": "2 kg", "k": "50 N/m"}).H
    2*s**2 + 50
    """
    result: Expr = H
    return result


@environment("difference-equation")
def difference_equation(D: FormulaInZ) -> Expr:
    """What a controller computes at each sample, force from position: D(z), as [rendered] behind a
    sampled-loop only.

    D : formula in ``z`` (one sample later) and the names of ``parameters``; no future samples.
    ``z_back`` is 1/z.

    >>> difference_equation("k + b*(1 - 1/z)", parameters={"k": "500 N/m", "b": "2 kN/m"}).H
    2500 - 2000*z_back
    """
    result: Expr = D
    return result
