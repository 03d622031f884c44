"""Values of one parameter at which a scene does not exist: where its environment is zero everywhere, or it is divided by 0."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from sympy import Expr

from haptisym.kernel.alike import ordered
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import SceneError
from haptisym.kernel.monomials import monomials
from haptisym.kernel.reals import ExactNumber, RealNumber
from haptisym.kernel.rings import Polynomial
from haptisym.model.chain import Chain
from haptisym.model.knobs import Knob
from haptisym.model.parameters import values
from haptisym.model.scene import Scene
from haptisym.verbs.require.boundary import real_roots
from haptisym.verbs.require.feasible import End, Span


def missing(scene: Scene, free: Knob) -> list[RealNumber]:
    """All such values, of either sign.

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
    return [x for x in found if not (_is_rational(x) and allowed(scene, free, x.value))]  # type: ignore[attr-defined]


def allowed(scene: Scene, free: Knob, value: Expr) -> bool:
    """Whether the scene exists at a value of the parameter."""
    try:
        free.put(scene, value).distortion()
    except SceneError:
        return False
    return True


def without(spans: Sequence[Span], gone: Sequence[RealNumber]) -> tuple[Span, ...]:
    """Intervals of values without some."""
    found = tuple(spans)
    for x in gone:
        found = tuple(y for span in found for y in _cut(span, x))
    return found


def _cut(span: Span, x: RealNumber) -> Iterator[Span]:
    low, high = span.low, span.high
    after = 1 if low.value is None else ordered(low.value, x)
    before = 1 if high.value is None else ordered(x, high.value)
    if after > 0 and before > 0:
        yield from (Span(low, End(x)), Span(End(x), high))
    elif after < 0 or before < 0:
        yield span
    elif after or before:  # x is one of two ends
        yield Span(replace(low, closed=low.closed and after > 0), replace(high, closed=high.closed and before > 0))


def _vanishing(chain: Chain, ring: Ring) -> Iterator[Polynomial]:
    """What must not be zero everywhere: the environment, and all that is divided by."""
    yield ring.convert(chain.environment).reduced().numerator
    yield chain.perceived(range(len(chain.matrices)), ring).denominator
    for entry in chain.entries():
        yield ring.convert(entry).denominator


def _factors(polynomial: Polynomial, index: int) -> Iterator[Polynomial]:
    """Those in one variable, and pi, alone: where they are zero the polynomial is, whatever the other variables are."""
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
