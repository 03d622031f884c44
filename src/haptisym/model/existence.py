"""For which values of a number there is no scene: where its environment is zero everywhere, or it
is divided by 0.

Both are zeros of polynomials in the number and pi, whatever frequency and delays are.
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
    """All values at which there is none, of either sign; ``in_air`` : but for those with nothing to
    feel.

    >>> from haptisym import effects, environments
    >>> spring = environments.expression("k - 5", parameters={"k": "8 N/m"})
    >>> late = Scene(spring, (effects.delay("1 ms"),))
    >>> missing(late, late.knobs["k"])
    [5]
    """
    chain = scene.chain.at(values(x for x in scene.parameters if x.path != free.path))
    ring = Ring.of(chain.entries())
    if free.parts or free.symbol not in ring.symbols:
        return []
    index = ring.meanings.index(free.symbol)
    factors = list[Polynomial]()
    for p in _vanishing(chain, ring):
        factors += [f for f in _factors(p, index) if f not in factors]
    found = (x for f in factors for x in real_roots(f, index, negative=True))
    return [
        x
        for x in found
        if not (_is_rational(x) and allowed(scene, free, x.value, in_air=in_air))  # type: ignore[attr-defined]
    ]


def allowed(scene: Scene, free: Knob, value: Expr, *, in_air: bool = False) -> bool:
    """Whether the scene exists at a value of the parameter; ``in_air`` : with nothing to feel,
    too."""
    try:
        put = free.put(scene, value)
        _ = put.closed if in_air else put.distortion()
    except SceneError:
        return False
    return True


def _vanishing(chain: Chain, ring: Ring) -> Iterator[Polynomial]:
    """What must not be zero everywhere: the environment, and all that is divided by."""
    yield ring.convert(chain.environment).reduced().numerator
    yield chain.perceived(range(len(chain.matrices)), ring).denominator
    for entry in chain.entries():
        yield ring.convert(entry).denominator


def _factors(polynomial: Polynomial, index: int) -> Iterator[Polynomial]:
    """Those in one variable, and pi, alone: where they are zero the polynomial is, whatever the
    other variables are."""
    rows: dict[tuple[int, ...], dict[tuple[int, ...], object]] = {}
    for exponents, value in monomials(polynomial):
        own = [int(n) for n in exponents]
        key = tuple(n if i in (1, index) else 0 for i, n in enumerate(own))
        rest = tuple(0 if i in (1, index) else n for i, n in enumerate(own))
        rows.setdefault(rest, {})[key] = value
    context = polynomial.context()
    common = context.constant(0)
    for row in rows.values():
        common = common.gcd(context.from_dict(row))
    yield from (f for f, _ in common.factor()[1]) if common else ()


def _is_rational(x: RealNumber) -> bool:
    return isinstance(x, ExactNumber) and bool(x.value.is_Rational)


def real_roots(factor: Polynomial, index: int, *, negative: bool) -> Iterator[RealNumber]:
    """The positive roots, and negative ones if wanted, of an irreducible polynomial in pi and the
    parameter of that index."""
    own = [int(n) for n in factor.degrees()]
    if not own[index]:
        return
    rows = [[0] * (own[1] + 1) for _ in range(own[index] + 1)]
    for exponents, value in monomials(factor):
        rows[int(exponents[index])][int(exponents[1])] = int(value.p)
    if len(rows) == 2:
        value = -_in_pi(rows[0]) / _in_pi(rows[1])
        yield ExactNumber(value.cancel() if value.has(pi) else value)
        return
    yield from _positive_roots(rows)
    if negative:
        mirrored = [[-n for n in row] if i % 2 else row for i, row in enumerate(rows)]
        yield from map(Negative, _positive_roots(mirrored))


def _in_pi(row: Sequence[int]) -> Expr:
    return sum((Integer(n) * pi**i for i, n in enumerate(row)), Integer(0))


def _positive_roots(rows: Sequence[Sequence[int]]) -> list[RealNumber]:
    return [*PolynomialFactor(tuple(_trimmed(row) for row in rows), step=1).positive_roots()]


def _trimmed(row: Sequence[int]) -> tuple[int, ...]:
    """A row without the zeros of high powers of pi, so that a rational one is seen to be so."""
    last = max((i for i, n in enumerate(row) if n), default=0)
    return tuple(row[: last + 1])
