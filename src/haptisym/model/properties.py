"""What a person makes of a dynamics: stiffness, mass and damping, their JNDs, and where a spring begins to feel as a mass."""

from __future__ import annotations

from dataclasses import dataclass

from sympy import Expr, I, Symbol

from haptisym.kernel.dynamics import RealFunction, Response
from haptisym.kernel.rings import X, omega
from haptisym.kernel.solutions import solve


@dataclass(frozen=True)
class Properties:
    """What a person makes of a dynamics at a frequency (section 2.3): closed forms in omega.

    ``real``, ``imag``: Re H and Im H, N/m. ``stiffness`` = Re H, N/m; ``mass`` = -Re H/omega^2, kg; ``damping`` =
    Im H/omega, N s/m. ``spring_inertia_force`` = X Re H (eq. 5) and ``damping_force`` = j X Im H (eq. 6): phasors of
    the force, N, for a motion of complex amplitude X. For a rotation read N m/rad, kg m^2, N m s/rad and N m.
    """

    real: Expr
    imag: Expr
    frequency: Symbol = omega
    """The symbol of omega."""

    @property
    def stiffness(self) -> Expr:
        """Re H, N/m or N m/rad: a spring where it is positive."""
        return self.real

    @property
    def mass(self) -> Expr:
        """-Re H/omega^2, kg or kg m^2: an inertia where it is positive."""
        return -self.real / self.frequency**2

    @property
    def damping(self) -> Expr:
        """Im H/omega: N s/m or N m s/rad."""
        return self.imag / self.frequency

    @property
    def spring_inertia_force(self) -> Expr:
        """The force of spring and inertia together, for a motion of amplitude X: X Re H."""
        return X * self.real

    @property
    def damping_force(self) -> Expr:
        """The force of the damper, for a motion of amplitude X: j X Im H."""
        return I * X * self.imag


@dataclass(frozen=True)
class ParameterJND:
    """How much a single parameter must change to be noticed: dk = c|H|, db = c|H|/omega, dm = c|H|/omega^2.

    N/m, N s/m and kg (for a rotation N m/rad, N m s/rad, kg m^2). Derived from eq. (4): a change of one parameter by p moves
    Re H by dk or -omega^2 dm, or Im H by omega db.
    """

    stiffness: Expr
    damping: Expr
    mass: Expr


def properties(response: Response, frequency: Symbol = omega) -> Properties:
    """Of the dynamics that has this response, with that symbol for omega."""
    real, imag = (x.factored().xreplace({omega: frequency}) for x in (response.real, response.imag))
    return Properties(real, imag, frequency)


def first_changeover(f: RealFunction) -> Expr | None:
    """The lowest zero or pole of odd order, where every one has a readable formula and the lowest is known."""
    if f.is_zero or any(angle.constant for angle in f.axis.angles):
        return None  # with s^alpha the sign of a root depends on the order, which may be a symbol
    # a denominator is a squared modulus and changes no sign, but where its zeros meet those of the numerator
    numeric = not (f.expression().free_symbols - {omega})
    poles = solve(RealFunction(f.axis.one / f.function)) if numeric else ()
    odd = [x for x in (*solve(f), *poles) if x.order % 2]
    found = [x.omega for x in odd if x.omega is not None]
    if not found or len(found) < len(odd):
        return None
    if all(x.is_number for x in found):
        return min(found)
    lowest = [x for x in found if all(x is other or (x - other).is_negative for other in found)]
    if lowest:
        return lowest[0]
    return found[0] if len({x.equation for x in odd}) == 1 else None
