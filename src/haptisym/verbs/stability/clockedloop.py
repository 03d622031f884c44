"""The loop of a display with a clock in a hand: controller A/B, hold, and the plant N/Q that moves.

One sampler, at one place of the chain. What lies before it, seen from the hand, is the controller
or, behind a zero-order hold, continuous; device, compliance and hand are the plant, in continuous
time, exactly discretized by ``SampledLoop``. UndecidedError for what such a loop cannot be: two
samplers, friction, or a delay or power of s that returns between sampler and hand, so that the
plant is no quotient of polynomials behind pure delays. Begin with ``loop_of``.
"""

from __future__ import annotations

from collections.abc import Mapping

from sympy import Expr, I, Integer, Rational, pi

from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import SceneError, UndecidedError
from haptisym.kernel.rings import Polynomial, RationalFunction, degree_in
from haptisym.kernel.rootcount import Roots, is_stable
from haptisym.kernel.sampledloop import Plant, SampledLoop
from haptisym.model.catalogue import CLOCKS, SAMPLED_LOOP, Effect, Hand, controller
from haptisym.model.scene import Scene


def clocked_roots(scene: Scene, hand: Hand) -> Roots:
    """The roots in |z| >= 1 of a display with a clock in a hand; those outside the circle are its
    ``right``."""
    outside, at_1 = loop_of(scene, hand).unstable()
    return Roots(outside + at_1, outside)


def clock_of(scene: Scene) -> tuple[int, Effect]:
    """The one effect with a clock, and its place. UndecidedError where there are two."""
    (place, *others) = [i for i, effect in enumerate(scene.effects) if effect.model in CLOCKS]
    if others:
        raise UndecidedError("the poles of a loop with two samplers")
    return place, scene.effects[place]


def series_alone(scene: Scene) -> bool:
    """Whether what comes before the clock does no more than multiply the force."""
    place, _ = clock_of(scene)
    return all(x.matrix[1:] == (0, 0, 1) for x in scene.effects[:place])


def loop_of(scene: Scene, hand: Hand) -> SampledLoop:
    """The loop of a scene in a hand: controller, delay, hold, then device, compliance and hand in
    continuous time; symbols for parameters may stay in it.

    A ``sampled-loop`` samples the position, a ``zero-order-hold`` the force that comes to it:
    before it all is continuous.
    UndecidedError where a delay or a power of s returns between sampler and hand, or a jump of the
    force jumps back at once.
    """
    place, clock = clock_of(scene)
    behind, before = scene.effects[place + 1 :], scene.effects[:place]
    rendered = Integer(1) if clock.model == SAMPLED_LOOP else scene.rendering.H
    entries = [x for effect in (*before, *behind) for x in effect.matrix]
    ring = Ring.of([rendered, hand.Z, *entries])
    G = (ring.one / impedance(ring, behind, ring.convert(hand.Z))).reduced()
    above: tuple[Expr, ...] = (Integer(1),)
    below: tuple[Expr, ...] = (Integer(1),)
    if clock.model == SAMPLED_LOOP:
        D = controller(clock)
        above, below = (tuple(D.ring.coefficients(p)) for p in (D.numerator, D.denominator))
    else:
        H = ring.convert(rendered)
        for effect in before:
            a, b, c, d = map(ring.convert, effect.matrix)
            H = ((a * H + b) / (c * H + d)).reduced()
        # The clock holds no force: the loop has the modes of what moves, alone.
        if H.is_zero:
            above = (Integer(0),)
        else:
            G = _seen_by_the_clock(G * H)
    return SampledLoop(plant_of(G, ring), clock.parameters[0].value, above, below)


def _seen_by_the_clock(G: RationalFunction) -> RationalFunction:
    """The product of what moves and the force before the clock, without modes that cancel and fade.

    What the force does not see remains a mode of what moves, and what the motion does not reach one
    of the force: exp(p T) is a root of the loop for each p that cancels. Those that do not fade are
    left in place.
    """
    ring, common = G.ring, G.numerator.gcd(G.denominator)
    cancelled = RationalFunction(ring, ring.one.numerator, common)
    # With an open parameter in what cancels, it may fade for some values alone: it stays.
    is_open = any(degree_in([common], i) for i in range(2, ring.size))
    return (
        G.monic() if is_open or not (common.is_constant() or is_stable(cancelled)) else G.reduced()
    )


def impedance(ring: Ring, effects: tuple[Effect, ...], hand: RationalFunction) -> RationalFunction:
    """Force per position that what moves shows to the held force: the hand, seen through
    effects."""
    Z = hand
    for effect in reversed(effects):
        a, b, c, d = map(ring.convert, effect.matrix)
        top, bottom = Z * d + b, Z * c + a
        if bottom.is_zero:
            raise UndecidedError("the roots of a loop whose force does not reach the hand")
        Z = (top / bottom).reduced()
    if Z.is_zero:
        raise UndecidedError(
            "the roots of a loop with nothing that has mass, damping or stiffness between "
            "sampler and hand"
        )
    return Z


def plant_of(G: RationalFunction, ring: Ring) -> Plant:
    """A dynamics between clock and sampler as a plant: a quotient with delays in its numerator
    alone, once those that all terms of the denominator share are taken off."""
    first, last = ring.size, ring.size + len(ring.lags)
    if degree_in([G.numerator, G.denominator], ring.meanings.index(I)) if I in ring.meanings else 0:
        raise UndecidedError("the roots of a loop with friction")
    for i in range(first, len(ring.meanings)):
        # One power of a delay in all of the denominator is a pure advance, which the numerator may
        # undo; several would be a delay that returns.
        powers = {int(e[i]) for e in G.denominator.monoms()}
        if len(powers) > 1 or (
            i >= last and (powers != {0} or any(int(e[i]) for e in G.numerator.monoms()))
        ):
            what = "a delay" if i < last else "a power of s"
            raise UndecidedError(
                f"the roots of a loop in which {what} returns between sampler and hand"
            )
    early = tuple(int(x) for x in G.denominator.monoms()[0][first:last])
    [(_, bottom)] = _by_delay(ring, G.denominator).items()
    terms = [
        (
            sum(
                ((n - m) * lag for n, m, lag in zip(turns, early, ring.lags, strict=True)),
                Integer(0),
            ),
            row,
        )
        for turns, row in _by_delay(ring, G.numerator).items()
    ]
    if any(lag.could_extract_minus_sign() for lag, _ in terms):
        raise UndecidedError("the roots of a loop that is not causal")
    try:
        return Plant(bottom, tuple(terms))
    except SceneError as error:
        raise UndecidedError(f"the roots of a loop: {error}") from None


def _by_delay(ring: Ring, polynomial: Polynomial) -> Mapping[tuple[int, ...], tuple[Expr, ...]]:
    """For each product of delays the coefficients of its polynomial in s."""
    first, last = ring.size, ring.size + len(ring.lags)
    rows: dict[tuple[int, ...], dict[int, Expr]] = {}
    for exponents, value in polynomial.to_dict().items():
        own = [int(n) for n in exponents]
        row = rows.setdefault(tuple(own[first:last]), {})
        factor = Rational(int(value.p), int(value.q)) * pi ** own[1]
        for symbol, n in zip(ring.symbols, own[2:first], strict=True):
            factor *= symbol**n
        row[own[0]] = row.get(own[0], Integer(0)) + factor
    return {
        turns: tuple(row.get(n, Integer(0)) for n in range(max(row) + 1))
        for turns, row in rows.items()
    }
