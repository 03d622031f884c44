"""The dynamics H_perc that a hand perceives through a chain of effects, computed exactly.

**Problem.** A controller renders an environment, a dynamics H = F/X (force over motion, a function
of s); between it and the hand there are n effects (filters, delays, samplers, elastic parts). What
does the hand feel?

**Formula.** Effect i is a two-port with the chain matrix M_i over functions of s (the transmission
matrix of Feldtkeller 1937), which takes force and motion on the side of the environment to those on
the side of the hand:

    (F'; X') = M_i (F; X),    M_i = (A, B; C, D).

H' = F'/X' is then the Moebius map (A H + B)/(C H + D) of H; a multiple of M_i gives the same one.
As maps compose as matrices multiply, H_perc is the map of the product M_n ... M_2 M_1, effect 1
nearest the environment, of H_rendered, what the controller renders. The *distortion* is dH = H_perc
- H_env against H_env, what should be felt (mostly H_rendered = H_env). On s = j omega the ratios
are r_r = abs(Re dH)/abs(H_env) and r_i = abs(Im dH)/abs(H_env); a difference is noticed where a
ratio exceeds a threshold c (Fu, van Paassen and Mulder 2019, doi:10.1016/j.ifacol.2019.12.119).

**Exact.** H_env, H_rendered and all entries of the matrices are elements of a ``Ring``: quotients
of polynomials in s, pi, parameters (positive symbols, or exact numbers in their place), delays
exp(-s tau), powers s^alpha and first harmonics. A first harmonic (of friction, backlash and the
like) is a variable of its own there, whatever it is a function of. *Lowest terms*: numerator and
denominator have no common factor as polynomials in these variables.

**Guaranteed.** H_perc is exact for the matrices given (a sampler or a first harmonic is a model
itself): an identity in s and the parameters, where no denominator vanishes. SceneError is raised
where C H + D = 0 behind some effect, so that H_perc has no value there, or where there is nothing
to compare it with (H_env = 0).

Begin with ``Chain.dynamics``. Closed forms of Re and Im are in ``closedforms``, stiffness, mass and
damping in ``properties``, crossings, changeovers and bandwidth in ``frequencies``, leading terms at
low and high frequency in ``asymptotes``. ``Distortion`` (model.distortion) is the object by which
all are used.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache, reduce
from typing import TYPE_CHECKING, Any

from sympy import Expr, Symbol

from haptisym.kernel.dynamics import Ring, on_axis
from haptisym.kernel.errors import SceneError
from haptisym.kernel.harmonics import Harmonic
from haptisym.kernel.rings import Polynomial, RationalFunction, cleared, monomials, s
from haptisym.kernel.rings import c as symbol_c
from haptisym.model.catalogue import Matrix
from haptisym.model.jnd import Part
from haptisym.model.parameters import in_place

if TYPE_CHECKING:
    from haptisym.programs.program import Program
    from haptisym.programs.steps import Steps


NOTHING_TO_FEEL = (
    "the environment is zero at every frequency: add mass, damping or stiffness (haptisym "
    "stability takes free air)"
)
_SAMPLE_BITS = 128
"""Precision, bits, at which a program is tried at one point: there the ball of a field that is not
0 everywhere hardly ever holds 0."""
_S = 0
"""The place of s among the variables of a ring, and of its exponent in a monomial."""


@dataclass(frozen=True)
class Chain:
    """A display as exact dynamics in s; stiffness, damping and mass in SI, s in rad/s.

    ``environment`` : H_env, what should be felt.
    ``rendered`` : H_rendered, what the controller renders for it.
    ``matrices`` : the chain matrices (A, B, C, D) of the effects, nearest the environment first.
    """

    environment: Expr
    rendered: Expr
    matrices: tuple[Matrix, ...]

    def dynamics(
        self, ring: Ring | None = None, *, free_air: bool = False
    ) -> tuple[RationalFunction, RationalFunction]:
        """H_env and H_perc in lowest terms, in ``ring`` or else in that of the chain.

        SceneError as of ``perceived``, and, unless ``free_air``, where H_env is zero everywhere:
        then there is no ratio to it.
        """
        ring = self.ring if ring is None else ring
        environment = ring.convert(self.environment).reduced()
        if environment.is_zero and not free_air:
            raise SceneError(NOTHING_TO_FEEL)
        return environment, self.perceived(range(len(self.matrices)), ring)

    def perceived(self, effects: Iterable[int], ring: Ring | None = None) -> RationalFunction:
        """H_perc in lowest terms with some of the effects alone, in ``ring`` or else in that of the
        chain.

        ``effects`` : their indices in ``matrices``, ascending. SceneError where H behind one of
        them has no value at any frequency. A further effect may make of H = oo a finite H_perc
        (elastic parts of -k and k, then one more, give that one), but no program of the chain takes
        this way.
        """
        ring = self.ring if ring is None else ring
        H = ring.convert(self.rendered)
        for i in effects:
            # Over one common denominator the four entries are polynomials; it cancels in F/X.
            a, b, c, d = cleared([ring.convert(entry) for entry in self.matrices[i]])
            force = a * H.numerator + b * H.denominator
            motion = c * H.numerator + d * H.denominator
            if not motion:
                raise SceneError(
                    f"effect {i + 1} makes H_perc infinite, or 0/0, at every frequency (C H + D = 0): "
                    f"change it, or write it and the next one as one effect"
                )
            H = RationalFunction(ring, force, motion)
        return H.reduced()

    @cached_property
    def ring(self) -> Ring:
        """The smallest ring that holds all dynamics of the chain, and ``threshold_symbol``."""
        # With the symbol of a threshold crossings have formulas in it; a variable that does not
        # occur costs nothing.
        return Ring.of([*self.entries(), self.threshold_symbol])

    @cached_property
    def threshold_symbol(self) -> Symbol:
        """The symbol that the ring has for a threshold: c, or c_, c__ where a parameter has that
        name."""
        return unused(symbol_c, self.parameters)

    def entries(self) -> tuple[Expr, ...]:
        """All dynamics of the chain: H_env, H_rendered, and the entries of the matrices."""
        entries = [self.environment, self.rendered]
        for matrix in self.matrices:
            entries += matrix
        return tuple(entries)

    @property
    def parameters(self) -> tuple[Symbol, ...]:
        """The symbols of the chain except s, in the order of their names."""
        symbols = {x for entry in self.entries() for x in entry.free_symbols}
        return tuple(sorted(symbols - {s}, key=str))

    @property
    def harmonics(self) -> tuple[Expr, ...]:
        """The first harmonics (describing functions of friction, backlash and the like) in the
        chain whose sizes are still symbols."""
        harmonics = {x for entry in self.entries() for x in entry.atoms(Harmonic)}
        return tuple(sorted(harmonics, key=str))

    @property
    def harmonic_symbols(self) -> frozenset[Symbol]:
        """The symbols in the first harmonics: sizes that can be set, but not be searched, as the
        harmonics are no quotients of polynomials in them."""
        return frozenset().union(*(x.free_symbols for x in self.harmonics))

    def program(self, fields: Sequence[str]) -> Program:
        """The straight-line program, a list of elementary operations, that computes some fields
        from omega and the parameters: those of ``programs.values.Values``, and the squares of its
        ratios, as "squared_real". A field that is 0 for all arguments is written as 0.

        KeyError for what is no field.
        """
        return self._program(fields, ())

    def _program(self, fields: Sequence[str], harmonics: tuple[Expr, ...]) -> Program:
        """As ``program``, with ``harmonics`` as further inputs, and all other first harmonics
        computed."""
        from haptisym.programs.balls import BallPoint  # a certified answer needs no program

        inputs = (*self.parameters, *harmonics)
        write = _writer(self.environment, self.rendered, self.matrices, inputs)
        program = write(fields, ())
        # A value that is not 0 at one point settles that a field is not 0 everywhere. Only fields
        # whose ball holds 0 there need the exact, slower test. Any point is right; at one whose
        # numbers are exact doubles, all different, neither 0 nor 1, little cancels by chance.
        point = tuple(1.25 + n / 8 for n in range(len(program.inputs)))
        balls = BallPoint(program, point).balls(_SAMPLE_BITS)
        vanishing = [name for name in fields if balls[name].contains(0) and self._vanishes(name)]
        return write(fields, vanishing) if vanishing else program

    def _vanishes(self, field: str) -> bool:
        """Whether a field of ``program`` is 0 at all frequencies and for all parameters, decided
        exactly. (A ratio and its square are where that part of dH is.)"""
        kind, _, part = field.rpartition("_")
        environment, perceived = self.dynamics(free_air=kind == "perceived")
        dynamics = perceived - environment
        if kind == "relative":
            dynamics = dynamics / environment
        elif kind == "environment":
            dynamics = environment
        elif kind == "perceived":
            dynamics = perceived
        response = on_axis(dynamics)
        return (response.raw_real if Part(part) is Part.REAL else response.raw_imag).is_zero

    @cached_property
    def steps(self) -> Steps:
        """All fields of ``programs.values.Values`` in named steps, as a page shows them: equations
        with names for what occurs more than once. H_perc is given as H_env + dH."""
        from haptisym.programs.steps import DISTORTION, Steps, page_steps

        fields = (*DISTORTION, "environment_real", "environment_imag")
        # For a reader a first harmonic is a name, which is explained once.
        page = page_steps(self._program(fields, self.harmonics))
        results = dict(page.results)
        for part in Part:
            perceived = results[f"environment_{part.value}"] + results[part.value]
            results[f"perceived_{part.value}"] = perceived
        return Steps(page.definitions, results)

    @property
    def in_series(self) -> bool:
        """Whether each effect only multiplies H, by A/D: B and C are written as 0 in its matrix."""
        return all(b == 0 and c == 0 for _, b, c, _ in self.matrices)

    def without_axis_zeros(self) -> tuple[Chain, bool]:
        """A chain with the same ratios whose H_env has fewer zeros on s = j omega, and whether the
        parts have changed places: r_r of this chain is then r_i of that one.

        All dynamics are divided by the product Z of the factors of H_env that are polynomials in s
        and can vanish there. Where dH vanishes with Z, as behind effects in series, the ratio
        abs(Re dH)/abs(H_env) at a zero of Z is then a value and not 0/0; where dH does not, it has a
        pole there as before. Zeros that stay are those of factors with a delay (1 - exp(-s T) at
        omega T = 2 pi n), of a power s^alpha at 0, and those that a polynomial has where its
        parameters satisfy one more equation (m s^2 + (b_1 - b_2) s + k at b_1 = b_2): there the
        ratio is 0/0, and cells around them stay undecided.

        - (A H + B)/(C H + D) over Z is the map of [[A, B/Z], [C Z, D]] applied to H/Z.
        - Z(j omega) is real, or it is imaginary. If real, Re dH and Im dH of the quotient are those
          of dH over abs(Z), up to the sign; if imaginary, they change places.
        """
        H_env = self.ring.convert(self.environment).reduced()
        Z = self.ring.function(_axis_zeros(self.ring, H_env.numerator))
        if Z.numerator.is_constant():
            return self, False
        # All factors of Z but s itself are even in s, so that any term has the parity of Z. An odd
        # Z is imaginary on the axis.
        is_odd = int(Z.numerator.monoms()[0][_S]) % 2 == 1
        return self.over(Z), is_odd

    def over(self, Z: RationalFunction) -> Chain:
        """The chain with all dynamics divided by Z, in lowest terms. It has a ring of its own, and
        with it a threshold symbol, as parameters may cancel."""

        def times(x: Expr, power: int) -> Expr:
            """A dynamics times that power of Z, in lowest terms; 0 stays as it is."""
            return (self.ring.convert(x) * Z**power).reduced().expression() if x else x

        matrices = []
        for a, b, c, d in self.matrices:
            matrices.append((a, times(b, -1), times(c, 1), d))
        return Chain(times(self.environment, -1), times(self.rendered, -1), tuple(matrices))

    def replaced(self, values: Mapping[Symbol, Expr]) -> Chain:
        """The same chain with values, numbers or expressions, in place of some of its symbols."""
        return self.map(lambda entry: in_place(entry, values))

    def at(self, values: Mapping[Symbol, Expr]) -> Chain:
        """As ``replaced``, for what searches values of the other symbols.

        SceneError where numbers are put in and a first harmonic, which is no quotient of
        polynomials, keeps a symbol.
        """
        chain = self.replaced(values)
        if chain.harmonics and any(x.is_number for x in values.values()):
            names = ", ".join(sorted(map(str, chain.harmonic_symbols)))
            raise SceneError(
                f"{names}: a number of a describing function can be set, not varied: write "
                "another value into the scene (with_values in Python; haptisym compare SCENE "
                "--with PATH=VALUE), and ask again"
            )
        return chain

    def map(self, change: Callable[[Expr], Expr]) -> Chain:
        """The chain with a function applied to every dynamics in it."""
        matrices = []
        for a, b, c, d in self.matrices:
            matrices.append((change(a), change(b), change(c), change(d)))
        return Chain(change(self.environment), change(self.rendered), tuple(matrices))


def unused(symbol: Symbol, taken: Iterable[Symbol]) -> Symbol:
    """The symbol, with as many _ after its name as it takes that no symbol of ``taken`` has it."""
    name, names = symbol.name, {x.name for x in taken}
    while name in names:
        name += "_"
    return Symbol(name, positive=symbol.is_positive)


@lru_cache(maxsize=8)
def _writer(
    environment: Expr, rendered: Expr, matrices: tuple[Matrix, ...], inputs: tuple[Symbol, ...]
) -> Callable[[Sequence[str], Collection[str]], Program]:
    """Return a function that writes programs of a chain, from the fields wanted and those known to
    be 0.

    All of its programs share their first steps, which are computed here. It is cached, as a program
    is written again where fields vanish, and several sets of fields are wanted of one chain.
    """
    from haptisym.programs.distortion import stable_program

    return stable_program(environment, rendered, matrices, inputs)


def _axis_zeros(ring: Ring, polynomial: Polynomial) -> Polynomial:
    """The product of the irreducible factors of a polynomial, without delays and powers s^alpha,
    that are real or imaginary on s = j omega: s itself, and those in s^2.

    These can vanish there, as it takes one equation. Any other factor f in s alone takes two, Re f
    = Im f = 0, for one unknown omega: with numbers it has no zero there, as f(s) and f(-s) would
    share it, and an irreducible f would be even or odd; with parameters it has one only where these
    satisfy one more equation. Of a factor with a delay or a power nothing is claimed.
    """
    zeros_on_axis = ring.constant(1)
    if not polynomial:
        return zeros_on_axis
    for factor, multiplicity in ring.factors(polynomial, in_square=False)[1]:
        # With powers of s of one parity only (irreducible: s, or a polynomial in s^2) the factor is
        # real or imaginary on the axis. One with a delay or a fractional power is neither, mostly.
        parities = {int(exponents[_S]) % 2 for exponents in factor.monoms()}
        degrees = factor.degrees()
        if degrees[_S] and len(parities) == 1 and not any(degrees[ring.size :]):
            zeros_on_axis = zeros_on_axis * factor**multiplicity
    return zeros_on_axis


def real_factor(ring: Ring, polynomial: Polynomial) -> Polynomial:
    """The largest factor of a polynomial, not 0, that is real on s = j omega, as k + m s^2: it is
    even in s, without delays and powers s^alpha.

    >>> from sympy import exp
    >>> ring = Ring.of([Symbol("k"), exp(-s)])
    >>> ring.expression(real_factor(ring, ring.convert((Symbol("k") + s**2) * (1 + s * exp(-s))).numerator))
    k + s**2
    """
    # The polynomial is a sum over all products of delays and powers, each with a coefficient in s
    # and the parameters. The factor divides the even and the odd part of each coefficient in s.
    parts: dict[tuple[int, ...], dict[tuple[int, ...], Any]] = {}
    for monomial, value in monomials(polynomial):
        exponents = tuple(map(int, monomial))
        in_coefficient, of_functions = exponents[: ring.size], exponents[ring.size :]
        parity = in_coefficient[_S] % 2
        without_functions = in_coefficient + (0,) * len(of_functions)
        parts.setdefault((parity, *of_functions), {})[without_functions] = value
    first, *more = (ring.context.from_dict(x) for x in parts.values())
    common = reduce(lambda x, y: x.gcd(y), more, first)
    # All its terms have one parity in s; an odd one has a factor s, which is imaginary.
    lowest_power = int(common.deflation_index()[1][_S])
    return common / ring.variable ** (lowest_power % 2)
