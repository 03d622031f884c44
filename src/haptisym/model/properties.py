"""What a person makes of a dynamics at a frequency: stiffness, mass and damping, and how much each
must change to be noticed.

**Problem.** A hand moves with the amplitude X at the frequency omega and feels the force F = H(j
omega) X. A person takes it for that of a spring k, a damper b or a mass m, of which each alone has
the dynamics k, j omega b, -omega^2 m.

**Formulas** (Fu, van Paassen and Mulder 2019, doi:10.1016/j.ifacol.2019.12.119). The force has a
part in phase with the motion and one a quarter of a turn ahead (eqs. 5 and 6):

    F = X Re H + j X Im H.

The first is that of a stiffness Re H, or of a mass -Re H/omega^2, as its sign is; the second that
of a damping Im H/omega (section 2.3). By eq. (4) a change is noticed where Re H or Im H moves by
more than c abs(H). A change dk moves Re H by dk, dm moves it by -omega^2 dm, and db moves Im H by
omega db; so that the least that is noticed of each alone is

    dk = c abs(H),    db = c abs(H)/omega,    dm = c abs(H)/omega^2.

**Guaranteed.** Formulas are identities for omega > 0 where H is finite. Begin with ``properties``.
"""

from __future__ import annotations

from dataclasses import dataclass

from sympy import Expr, I, Symbol

from haptisym.kernel.dynamics import Response
from haptisym.kernel.rings import X, omega
from haptisym.model.parameters import in_place


@dataclass(frozen=True)
class Properties:
    """What a person makes of a dynamics H at a frequency: closed forms in omega.

    ``real``, ``imag`` : Re H and Im H, N/m; for a rotation N m/rad. Forces are phasors, N or N m,
    for a motion of the complex ``amplitude`` X.
    """

    real: Expr
    imag: Expr
    frequency: Expr = omega
    """The symbol of omega, or a value."""
    amplitude: Symbol = X

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
        return self.amplitude * self.real

    @property
    def damping_force(self) -> Expr:
        """The force of the damper, for a motion of amplitude X: j X Im H."""
        return I * self.amplitude * self.imag


@dataclass(frozen=True)
class ParameterJND:
    """How much stiffness, damping and mass must each change alone to be noticed: dk, db and dm, in
    N/m, N s/m and kg (for a rotation N m/rad, N m s/rad, kg m^2)."""

    stiffness: Expr
    damping: Expr
    mass: Expr

    @classmethod
    def of(cls, modulus: Expr, c: Expr, frequency: Expr) -> ParameterJND:
        """The changes for a threshold c > 0 at a frequency, where abs(H) is ``modulus``."""
        least = c * modulus
        return cls(least, least / frequency, least / frequency**2)


def properties(response: Response, frequency: Expr = omega, amplitude: Symbol = X) -> Properties:
    """The properties of a dynamics from its response on s = j omega.

    ``frequency`` : what stands for omega in them; ``amplitude`` : what stands for the amplitude of
    the motion.
    """
    named = {omega: frequency}
    real = in_place(response.real.factored(), named)
    imag = in_place(response.imag.factored(), named)
    return Properties(real, imag, frequency, amplitude)
