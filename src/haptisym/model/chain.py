"""A chain of dynamics: the environment, what is rendered for it, and the effects between it and the hand."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from sympy import Expr, Symbol

from haptisym.kernel.dynamics import Ring, on_axis
from haptisym.kernel.errors import SceneError
from haptisym.kernel.rings import Polynomial, RationalFunction, cleared
from haptisym.kernel.rings import c as threshold
from haptisym.model.catalogue import Matrix
from haptisym.model.jnd import Part
from haptisym.model.parameters import in_place

if TYPE_CHECKING:
    from haptisym.programs.program import Program
    from haptisym.programs.steps import Steps

NOTHING_TO_FEEL = (
    "the environment is zero at every frequency: there is nothing to feel, and nothing to compare with (whether the display "
    "shakes in a hand can be asked: `stability`)"
)


@dataclass(frozen=True)
class Chain:
    """The dynamics themselves: H_env, what is rendered for it, and the effects' chain matrices, nearest the environment first."""

    environment: Expr
    rendered: Expr
    matrices: tuple[Matrix, ...]

    def dynamics(
        self, ring: Ring | None = None, *, free_air: bool = False
    ) -> tuple[RationalFunction, RationalFunction]:
        """H_env and H_perc in lowest terms, in a ring that holds them (the smallest one unless given).

        Raises SceneError where H_perc is not a dynamics, and where H_env is zero everywhere but in ``free_air``.
        """
        ring = ring or self.ring
        environment = ring.convert(self.environment).reduced()
        if environment.is_zero and not free_air:
            raise SceneError(NOTHING_TO_FEEL)
        return environment, self.perceived(range(len(self.matrices)), ring)

    def perceived(self, places: Iterable[int], ring: Ring | None = None) -> RationalFunction:
        """H_perc in lowest terms, of the effects at these places alone, in the ring of all unless given another."""
        ring = ring or self.ring
        found = ring.convert(self.rendered)
        for i in places:
            found = _through(found, [ring.convert(entry) for entry in self.matrices[i]])
        return found.reduced()

    @cached_property
    def ring(self) -> Ring:
        """The ring that holds them all."""
        # the symbol c comes along so that thresholds may stay symbols; a variable that does not occur costs nothing
        own = {x.name for entry in self.entries() for x in entry.free_symbols}
        return Ring.of([*self.entries(), *(() if threshold.name in own else (threshold,))])

    def entries(self) -> tuple[Expr, ...]:
        """All dynamics in it: H_env, what is rendered, and the entries of the matrices."""
        return self.environment, self.rendered, *(entry for matrix in self.matrices for entry in matrix)

    @property
    def parameters(self) -> tuple[Symbol, ...]:
        """The symbols in it, in the order of their names."""
        own = {x for entry in self.entries() for x in entry.free_symbols}
        return tuple(x for x in self.ring.symbols if x in own)

    def program(self, fields: Sequence[str]) -> Program:
        """The straight-line program of some fields of ``numeric.Values``; what is 0 everywhere is written as 0."""
        from haptisym.programs.balls import BallPoint  # a certified answer needs no program
        from haptisym.programs.stable import stable_program

        write = stable_program(self.environment, self.rendered, self.matrices, self.parameters)
        program = write(fields, ())
        # a value that is not 0 at some point settles that a field is not 0 everywhere
        sample = BallPoint(program, tuple(1.25 + n / 8 for n in range(len(program.inputs)))).balls(128)
        zero = [name for name in fields if sample[name].contains(0) and self.vanishes(name)]
        return write(fields, zero) if zero else program

    def vanishes(self, name: str) -> bool:
        """Whether a field is 0 at all frequencies, whatever the parameters."""
        kind, _, part = name.rpartition("_")
        env, perc = self.dynamics(free_air=kind == "perceived")
        change = perc - env
        of = change / env if kind == "relative" else {"environment": env, "perceived": perc}.get(kind, change)
        raw = on_axis(of)
        return (raw.raw_real if part == "real" else raw.raw_imag).is_zero

    @cached_property
    def steps(self) -> Steps:
        """All fields of ``numeric.Values`` in named steps, as a page shows them: of what is felt, H_env + dH."""
        from haptisym.programs.steps import DISTORTION, Steps, page_steps

        found = page_steps(self.program((*DISTORTION, "environment_real", "environment_imag")))
        of = found.results
        felt = {f"perceived_{part.value}": of[f"environment_{part.value}"] + of[part.value] for part in Part}
        return Steps(found.definitions, {**of, **felt})

    def without_axis_zeros(self) -> tuple[Chain, bool]:
        """A chain with the same ratios, though H_env has no zeros on s = j omega; whether r_r is its r_i.

        All dynamics are taken over the factors Z of H_env that are real or imaginary there: H/Z behind [[A, B/Z], [C Z, D]].
        """
        environment = self.ring.convert(self.environment).reduced()
        Z = self.ring.function(_axis_zeros(self.ring, environment.numerator))
        if Z.numerator.is_constant():
            return self, False

        def times(x: Expr, power: int) -> Expr:
            return (self.ring.convert(x) * Z**power).reduced().expression() if x else x

        matrices = tuple((a, times(b, -1), times(c, 1), d) for a, b, c, d in self.matrices)
        odd = int(Z.numerator.monoms()[0][0]) % 2 == 1
        return Chain(times(self.environment, -1), times(self.rendered, -1), matrices), odd

    def at(self, values: Mapping[Symbol, Expr]) -> Chain:
        """The same chain with values for some of its symbols."""
        return self.map(lambda entry: in_place(entry, values))

    def map(self, change: Callable[[Expr], Expr]) -> Chain:
        """The chain with every dynamics in it changed."""
        matrices = tuple((change(a), change(b), change(c), change(d)) for a, b, c, d in self.matrices)
        return Chain(change(self.environment), change(self.rendered), matrices)


def _axis_zeros(ring: Ring, polynomial: Polynomial) -> Polynomial:
    """The factors of a polynomial that can vanish on s = j omega: s itself, and those in s^2."""
    found = ring.constant(1)
    for factor, n in ring.factors(polynomial, in_square=False)[1] if polynomial else ():
        even = len({int(exponents[0]) % 2 for exponents in factor.monoms()}) == 1
        if factor.degrees()[0] and even and not any(factor.degrees()[ring.size :]):
            found = found * factor**n
    return found


def _through(H: RationalFunction, matrix: Sequence[RationalFunction]) -> RationalFunction:
    """The Moebius map (A H + B)/(C H + D), without fractions inside."""
    a, b, c, d = cleared(matrix)
    top = a * H.numerator + b * H.denominator
    bottom = c * H.numerator + d * H.denominator
    if bottom.is_zero():
        raise SceneError("the effects make the perceived dynamics infinite at every frequency (C H + D = 0)")
    return RationalFunction(H.ring, top, bottom)
