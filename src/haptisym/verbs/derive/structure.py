"""The closed forms in short, named steps, as a person would write them down: they stay short as devices are cascaded.

The environment is H_env = R + j X. A chain of series effects G = G_1 G_2 ... changes it by the relative distortion
P + j Q = G - 1, put together from those of the devices by 1 + P + j Q = (1 + P_1 + j Q_1)(1 + P_2 + j Q_2)..., so that
nothing cancels at low frequencies. A shunt S + j T adds itself; a two-port with a compliance in it adds
((A - D) H + B - C H^2)/(C H + D).
So Re dH = R P - X Q and Im dH = R Q + X P, plus what the others add.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import reduce
from itertools import chain, count
from operator import add
from typing import TypeAlias

from sympy import Abs, Add, Expr, Integer, Symbol, count_ops, sqrt

from haptisym.kernel.dynamics import Ring
from haptisym.kernel.response import RealFunction, on_axis
from haptisym.kernel.rings import Polynomial, RationalFunction, cleared, degree_in
from haptisym.model.distortion import Chain, Distortion
from haptisym.programs.values import Values
from haptisym.verbs.derive.steps import Steps

Pair: TypeAlias = tuple[Expr, Expr]
"""Real and imaginary part."""
_NOTHING: Pair = (Integer(0), Integer(0))


def structure(of: Chain | Distortion, write: Callable[[RealFunction], Expr] = RealFunction.factored) -> Steps:
    """A distortion in named steps; the results have the names of ``numeric.Values``.

    ``write`` : how a real function of a delay or a power of s is written; ``RealFunction.stable`` in half angles, for floats.
    At omega = 0 the ratios are 0/0 where H_env is 0 there: the closed forms of ``Distortion`` have the limit.

    >>> from haptisym import effects, environments
    >>> from haptisym.model.distortion import distort
    >>> from haptisym.kernel.symbols import symbols
    >>> m, b, k, omega_c = symbols("m b k omega_c")
    >>> steps = structure(distort(environments.mass_spring_damper(m, b, k), effects.first_order_lag(omega_c)))
    >>> for name, value in steps.definitions:
    ...     print(name, "=", value)
    R = k - m*omega**2
    X = b*omega
    N = R**2 + X**2
    M = omega**2 + omega_c**2
    P = -omega**2/M
    Q = -omega*omega_c/M
    >>> steps.results["real"], steps.results["imag"]
    (P*R - Q*X, P*X + Q*R)
    """
    dynamics = of.chain if isinstance(of, Distortion) else of
    taken = {x.name for x in dynamics.ring.symbols} | {"omega", "c"}
    return _Writer(dynamics.ring, write, taken).steps(dynamics)


@dataclass(frozen=True)
class _Series:
    """A series effect, by G - 1 in lowest terms."""

    delta: RationalFunction


@dataclass(frozen=True)
class _Shunt:
    """What stands beside the environment, by its Z in lowest terms."""

    impedance: RationalFunction


@dataclass(frozen=True)
class _Port:
    """A two-port with a compliance in it: A - D, B, C and D, up to a common factor."""

    entries: tuple[RationalFunction, ...]


_Stage: TypeAlias = _Series | _Shunt | _Port


def _stages(matrix: Sequence[RationalFunction]) -> Iterator[_Stage]:
    """What a chain matrix does, one thing after the other; an identity does nothing."""
    ring = matrix[0].ring
    a, b, c, d = (ring.function(p) for p in cleared(matrix))
    if not c.is_zero:
        yield _Port((a - d, b, c, d))
        return
    delta, impedance = ((a - d) / d).reduced(), (b / d).reduced()
    if not delta.is_zero:
        yield _Series(delta)
    if not impedance.is_zero:
        yield _Shunt(impedance)


def _runs(stages: Sequence[_Stage]) -> list[list[_Stage]]:
    """Series effects that follow each other together, everything else alone."""
    runs: list[list[_Stage]] = []
    for stage in stages:
        if runs and isinstance(stage, _Series) and isinstance(runs[-1][0], _Series):
            runs[-1].append(stage)
        else:
            runs.append([stage])
    return runs


@dataclass
class _Writer:
    """Writes one computation down, step by step."""

    ring: Ring
    write: Callable[[RealFunction], Expr]
    taken: set[str]
    definitions: list[tuple[Symbol, Expr]] = field(default_factory=list)
    factors: list[tuple[Polynomial, Pair]] = field(default_factory=list)

    def steps(self, of: Chain) -> Steps:
        H = R, X = self.named("RX", self.environment(of.environment))
        N = self.name("N", R**2 + X**2)
        stages = [x for matrix in of.matrices for x in _stages([self.ring.convert(entry) for entry in matrix])]
        labels = _labels(stages)
        dH, relative, runs = self.rendered(of), _NOTHING, _runs(stages)
        for n, run in enumerate(runs):
            felt = H if dH == _NOTHING else self.named("RX", _plus(H, dH), f"_{n}")
            if isinstance(run[0], _Series):
                relative = self.relative([self.device(x, labels[id(x)]) for x in run if isinstance(x, _Series)])
                dH = _plus(dH, _times(felt, relative))
            else:
                dH = _plus(dH, self.beside(run[0], labels[id(run[0])], felt))
            if run is not runs[-1]:
                dH = self.named("EF", dH, f"_{n + 1}")
        if len(runs) > 1 or dH != _times(H, relative):
            E, F = dH = self.named("EF", dH)
            relative = (E * R + F * X) / N, (F * R - E * X) / N
        ratios = (Abs(part) / sqrt(N) for part in dH)
        values = (*dH, *ratios, *relative, *H, *_plus(H, dH))
        return Steps(tuple(self.definitions), dict(zip(Values._fields, values, strict=True)))

    def environment(self, H: Expr) -> Pair:
        """Re and Im of H_env: its polynomial and each of its fractions for itself, as they are written in the model."""
        terms = [self.ring.convert(term).reduced() for term in Add.make_args(H)]
        whole = [x for x in terms if x.denominator.is_constant()]
        fractions = [x for x in terms if not x.denominator.is_constant()]
        total = self.closed(reduce(add, whole).reduced(), "_e") if whole else _NOTHING
        for i, fraction in enumerate(fractions, 1):
            total = _plus(total, self.closed(fraction, f"_e{i}" if len(fractions) > 1 else "_e"))
        return total

    def rendered(self, of: Chain) -> Pair:
        """Re and Im of what is rendered beyond the environment."""
        if of.rendered == of.environment:
            return _NOTHING
        more = self.ring.convert(of.rendered) - self.ring.convert(of.environment)
        return self.named("EF", self.closed(more.reduced(), "_r"), "_r")

    def device(self, stage: _Series, label: str) -> Pair:
        """P_i + j Q_i = G_i - 1."""
        return self.named("PQ", self.closed(stage.delta, label), label)

    def relative(self, devices: Sequence[Pair]) -> Pair:
        """P + j Q of devices in a row."""
        (P, Q), *others = devices
        for p, q in others:
            P, Q = self.named("PQ", (P + p + P * p - Q * q, Q + q + P * q + Q * p), "")
        return P, Q

    def beside(self, stage: _Stage, label: str, felt: Pair) -> Pair:
        """What a shunt or a two-port adds."""
        if isinstance(stage, _Shunt):
            return self.named("ST", self.closed(stage.impedance, label), label)
        assert isinstance(stage, _Port)
        a, B, C, D = map(self.entry, stage.entries)
        C_H = _times(C, felt)
        U, V = self.named("UV", _plus(C_H, D), label)
        M = self.name(f"M{label}", U**2 + V**2)
        K, L = self.named("KL", _plus(_times((a[0] - C_H[0], a[1] - C_H[1]), felt), B), label)
        return (K * U + L * V) / M, (L * U - K * V) / M

    def entry(self, entry: RationalFunction) -> Pair:
        """Re and Im of an entry of a chain matrix, a polynomial: the product of its factors, each written once."""
        if entry.is_zero:
            return _NOTHING
        unit, factors = self.ring.factors(entry.numerator, in_square=False)
        total: Pair = (unit, Integer(0))
        for factor, n in factors:
            for _ in range(n):
                total = _times(total, self.factor(factor))
        return total

    def factor(self, factor: Polynomial) -> Pair:
        """Y_n + j Z_n, a factor of the entries of chain matrices."""
        for known, pair in self.factors:
            if known == factor:
                return pair
        label = f"_{len(self.factors) + 1}"
        real, imag = self.closed(self.ring.function(factor), label)
        short = max(map(count_ops, (real, imag))) <= _SHORT
        self.factors.append((factor, (real, imag) if short else self.named("YZ", (real, imag), label)))
        return self.factors[-1][1]

    def closed(self, f: RationalFunction, label: str) -> Pair:
        """Re and Im of a dynamics on s = j omega, over the squared modulus U^2 + V^2 of its denominator."""
        axis, f = self.ring.axis, f.cleared()
        if any(degree_in([f.numerator, f.denominator], i) for i in range(self.ring.size, len(self.ring.meanings))):
            response = on_axis(f)
            return self.write(response.real), self.write(response.imag)
        (p, q), (u, v) = axis.parts([f.numerator, f.denominator])
        above, square = (p * u + q * v, q * u - p * v), u * u + v * v
        if f.denominator.is_constant() or any(not x.is_zero() and not x.gcd(square).is_constant() for x in above):
            response = on_axis(f)
            return response.real.factored(), response.imag.factored()
        U, V = (self.name(f"{letter}{label}", axis.expression(x)) for letter, x in zip("UV", (u, v), strict=True))
        M = self.name(f"M{label}", U**2 + V**2)
        real, imag = (axis.factored_expression(x) / M for x in above)
        return real, imag

    def named(self, letters: str, values: Pair, label: str = "") -> Pair:
        return self.name(letters[0] + label, values[0], least=1), self.name(letters[1] + label, values[1], least=1)

    def name(self, name: str, value: Expr, least: int = 2) -> Expr:
        """A symbol for a value; the value itself if it takes fewer operations than that."""
        if count_ops(value) < least:
            return value
        stems = chain([name], (f"{name}_{n}" if "_" not in name else f"{name}{'x' * n}" for n in count(1)))
        free = next(x for x in stems if x not in self.taken)
        self.taken.add(free)
        self.definitions.append((Symbol(free, real=True), value))
        return self.definitions[-1][0]


_SHORT = 4  # operations: a longer factor in a chain matrix gets a name


def _labels(stages: Sequence[_Stage]) -> dict[int, str]:
    """The index of each stage among those of its kind; none for one of a kind."""
    labels = {}
    for kind in (_Series, _Shunt, _Port):
        own = [x for x in stages if isinstance(x, kind)]
        labels.update({id(x): f"_{i}" if len(own) > 1 else "" for i, x in enumerate(own, 1)})
    return labels


def _plus(x: Pair, y: Pair) -> Pair:
    return x[0] + y[0], x[1] + y[1]


def _times(x: Pair, y: Pair) -> Pair:
    return x[0] * y[0] - x[1] * y[1], x[0] * y[1] + x[1] * y[0]
