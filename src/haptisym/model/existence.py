"""The values of a parameter for which a scene does not exist: where its environment is zero at all
frequencies, or where a dynamics divides by zero.

A polynomial in s, delays, pi and the parameter p vanishes at all frequencies where all its
coefficients, which are polynomials in p and pi, vanish: at the real zeros of their greatest common
divisor. These are found exactly. A *ring* (``kernel.dynamics``) has s, pi, the parameters, the unit
delays and the powers of s for generators, in this order. Begin with ``missing``.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from sympy import Expr, Integer, pi

from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import SceneError
from haptisym.kernel.factors import PolynomialFactor
from haptisym.kernel.reals import ExactNumber, Negative, RealNumber
from haptisym.kernel.rings import Polynomial, monomials
from haptisym.model.chain import Chain
from haptisym.model.parameters import values
from haptisym.model.scene import Knob, Scene


def missing(scene: Scene, free: Knob, *, in_air: bool = False) -> list[RealNumber]:
    """All real values of the parameter ``free`` at which there is no scene, certified, each once.

    ``in_air`` : a scene with nothing to feel counts as one.

    >>> from haptisym import effects, environments
    >>> spring = environments.expression("k - 5", parameters={"k": "8 N/m"})
    >>> late = Scene(spring, (effects.delay("1 ms"),))
    >>> missing(late, late.knobs["k"])
    [5]
    """
    others = (x for x in scene.parameters if x.path != free.path)
    chain = scene.chain.at(values(others))
    ring = Ring.of(chain.entries())
    if free.parts or free.symbol not in ring.symbols:
        return []
    index = ring.meanings.index(free.symbol)
    factors = list[Polynomial]()
    for p in _vanishing(chain, ring):
        for factor in _factors(p, index):
            if factor not in factors:
                factors.append(factor)
    # At a candidate the scene may exist all the same: a factor can cancel in the whole, and in free
    # air the environment may be zero. Where it is rational the scene is built there to see; any
    # other candidate counts as missing.
    without_scene = []
    for factor in factors:
        for x in real_roots(factor, index, negative=True):
            value = x.value if isinstance(x, ExactNumber) and x.value.is_Rational else None
            if value is None or not allowed(scene, free, value, in_air=in_air):
                without_scene.append(x)
    return without_scene


def allowed(scene: Scene, free: Knob, value: Expr, *, in_air: bool = False) -> bool:
    """Whether the scene exists at a value of the parameter; ``in_air`` : a scene with nothing to
    feel counts as one."""
    try:
        changed = free.put(scene, value)
        _ = changed.closed if in_air else changed.distortion()
    except SceneError:
        return False
    return True


def _vanishing(chain: Chain, ring: Ring) -> Iterator[Polynomial]:
    """The polynomials that must not vanish at all frequencies: the numerator of H_env, all
    denominators, and what each effect divides by, C H + D, also where that cancels later."""
    yield ring.convert(chain.environment).reduced().numerator
    yield chain.perceived(range(len(chain.matrices)), ring).denominator
    for i, (_, _, C, D) in enumerate(chain.matrices):
        before = chain.perceived(range(i), ring)
        yield (ring.convert(C) * before + ring.convert(D)).reduced().numerator
    for entry in chain.entries():
        yield ring.convert(entry).denominator


def _factors(polynomial: Polynomial, index: int) -> Iterator[Polynomial]:
    """The irreducible factors in the variable of that index, and pi, alone: where one is zero the
    polynomial is zero, whatever the other variables are."""
    # Sorted by monomials in the other variables; what all coefficients have in common is the gcd.
    rows: dict[tuple[int, ...], dict[tuple[int, ...], object]] = {}
    for exponents, value in monomials(polynomial):
        others = [int(n) for n in exponents]
        kept = [0] * len(others)
        for i in {1, index}:  # pi, and the variable
            kept[i] = others[i]
            others[i] = 0
        row = rows.setdefault(tuple(others), {})
        row[tuple(kept)] = value
    context = polynomial.context()
    common = context.constant(0)
    for row in rows.values():
        common = common.gcd(context.from_dict(row))
    if common:
        _, factors = common.factor()
        yield from (factor for factor, _ in factors)


def real_roots(factor: Polynomial, index: int, *, negative: bool) -> Iterator[RealNumber]:
    """The positive roots, and negative ones if wanted, of an irreducible polynomial in pi and the
    parameter of that index."""
    degrees = [int(n) for n in factor.degrees()]
    degree, degree_in_pi = degrees[index], degrees[1]
    if not degree:
        return
    # One row for each power of the parameter: its coefficient by ascending powers of pi, which is
    # transcendental and so behaves as a variable of its own.
    rows = [[0] * (degree_in_pi + 1) for _ in range(degree + 1)]
    for exponents, value in monomials(factor):
        row = rows[int(exponents[index])]
        row[int(exponents[1])] = int(value.p)
    # Degree one: the root is a number that can be written down.
    if degree == 1:
        constant, slope = map(_in_pi, rows)
        root = -constant / slope
        yield ExactNumber(root.cancel() if root.has(pi) else root)
        return
    yield from _positive_roots(rows)
    if negative:
        # The negative roots of p(x) are the positive ones of p(-x), negated.
        mirrored = [[-n for n in row] if i % 2 else row for i, row in enumerate(rows)]
        yield from map(Negative, _positive_roots(mirrored))


def _in_pi(row: Sequence[int]) -> Expr:
    """The number whose coefficients by ascending powers of pi are given."""
    total = Integer(0)
    for i, n in enumerate(row):
        total += Integer(n) * pi**i
    return total


def _positive_roots(rows: Sequence[Sequence[int]]) -> list[RealNumber]:
    """The positive roots of a polynomial whose coefficients are these rows, by powers of pi."""
    coefficients = tuple(_trimmed(row) for row in rows)
    factor = PolynomialFactor(coefficients, step=1)
    return [*factor.positive_roots()]


def _trimmed(row: Sequence[int]) -> tuple[int, ...]:
    """A row without the zeros of high powers of pi, so that a rational one is seen to be so."""
    there = [i for i, n in enumerate(row) if n]
    last = max(there, default=0)
    return tuple(row[: last + 1])
