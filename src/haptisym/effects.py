"""The catalogue of effects: what stands between environment and hand, as chain matrices.

``[F_h; X_h] = [[A, B], [C, D]] [F_e; X_e]``, so that ``H_perc = (A H + B)/(C H + D)``. A series
effect multiplies the force by G, a shunt adds an impedance beside the environment, a compliance
adds 1/K to 1/H.

Parameters are numbers in SI, strings with units or SymPy symbols; each function also takes
``name``. It returns an
``Effect`` and raises ``SceneError`` for a wrong unit, a forbidden value or a missing parameter.
"""

from __future__ import annotations

from math import comb, factorial

from sympy import Add, Expr, I, Rational, cosh, exp, pi, sinh

from haptisym.kernel.errors import SceneError
from haptisym.kernel.harmonics import deadband, following, lagging, limiter, quantiser
from haptisym.kernel.rings import s
from haptisym.model.catalogue import Matrix, effect
from haptisym.model.parameters import (
    Amplitude,
    Damping,
    DampingRatio,
    Force,
    Formula,
    Frequency,
    Method,
    Order,
    PositiveDamping,
    PositiveForce,
    PositiveMass,
    PositiveStiffness,
    PositiveTime,
    Samples,
    Scale,
    SignedDamping,
    SignedMass,
    SignedStiffness,
    Stiffness,
    Time,
)


def _series(G: Expr) -> Matrix:
    """F_h = G F_e, X_h = X_e: the motion is not changed."""
    return (G, 0, 0, 1)


def _shunt(Z: Expr) -> Matrix:
    """F_h = F_e + Z X_e, X_h = X_e: both have one motion, and their forces add up."""
    return (1, Z, 0, 1)


@effect("first-order-lag")
def first_order_lag(omega_c: Frequency) -> Matrix:
    """First-order lag (actuator, force sensor): G(s) = omega_c/(s + omega_c), in series.

    omega_c : cut-off, rad/s, > 0.

    >>> first_order_lag("20 Hz").matrix
    (40*pi/(s + 40*pi), 0, 0, 1)
    """
    return _series(omega_c / (s + omega_c))


@effect("second-order-lowpass")
def second_order_lowpass(omega_n: Frequency, zeta: DampingRatio) -> Matrix:
    """Second-order low-pass filter: G(s) = omega_n^2/(s^2 + 2 zeta omega_n s + omega_n^2), in
    series.

    omega_n : undamped natural frequency, rad/s, > 0; zeta : damping ratio, >= 0.
    Source: Fu, van Paassen and Mulder (2019), eq. (8).

    >>> second_order_lowpass("80 rad/s", 0.5).matrix
    (6400/(s**2 + 80*s + 6400), 0, 0, 1)
    """
    return _series(omega_n**2 / (s**2 + 2 * zeta * omega_n * s + omega_n**2))


@effect("delay")
def delay(tau: Time) -> Matrix:
    """Pure time delay, exact: G(s) = exp(-s tau), in series.

    tau : delay, s, >= 0. Delays on the force and on the motion side add up.

    >>> delay("5 ms").matrix
    (exp(-s/200), 0, 0, 1)
    """
    return _series(exp(-s * tau))


@effect("pade-delay")
def pade_delay(tau: Time, order: Order) -> Matrix:
    """The diagonal Pade approximant of a delay, for comparison with the exact one: G(s) = p(-s
    tau)/p(s tau), in series.

    tau : delay, s, >= 0; order : 1 to 10.
    p(x) = sum over i of C(n, i) (2 n - i)!/(2 n)! x^i.

    >>> pade_delay(2, 1).matrix
    ((1 - s)/(s + 1), 0, 0, 1)
    """

    def p(x: Expr) -> Expr:
        """The numerator of the approximant of exp(x); the denominator is p(-x)."""
        terms = []
        for i in range(order + 1):
            weight = Rational(comb(order, i) * factorial(2 * order - i), factorial(2 * order))
            terms.append(weight * x**i)
        return Add(*terms)

    return _series(p(-s * tau) / p(s * tau))


@effect("zero-order-hold")
def zero_order_hold(T: PositiveTime) -> Matrix:
    """Sample and hold, exact at the base band: G(s) = (1 - exp(-s T))/(s T), in series.

    T : sampling period, s, > 0.

    >>> zero_order_hold("1 ms").matrix
    (1000*(1 - exp(-s/1000))/s, 0, 0, 1)
    """
    # The hold alone is (1 - exp(-s T))/s; sampling brings the factor 1/T at the base band.
    return _series((1 - exp(-s * T)) / (s * T))


@effect("sampled-loop")
def sampled_loop(T: PositiveTime, method: Method = "", delay: Samples = 0) -> Matrix:
    """A sampled controller: it samples the position, renders the environment as D(z) =
    H(s(z)), and holds the force.

    T : sampling period, s, > 0; delay : whole samples of computation, absent = none; method : what
    s becomes, "backward-difference" (1 - 1/z)/T, "tustin" (2/T)(1 - 1/z)/(1 + 1/z) or
    "forward-difference" (z - 1)/T; absent where a difference-equation is rendered, which is D(z)
    itself.
    The first effect of a scene, and its only clock. Below pi/T it makes H_perc = D(exp(s T)) exp(-s
    T delay)
    (1 - exp(-s T))/(s T), exact for prescribed motion; its matrix alone has delay and hold, in a
    scene D - H next to them, too.

    >>> from haptisym.environments import kelvin_voigt
    >>> from haptisym.model.distortion import distort
    >>> found = distort(kelvin_voigt(5, 2), sampled_loop(1, "backward-difference")).perceived
    >>> abs((found - (1 - exp(-s)) * (7 - 2 * exp(-s)) / s).subs(s, 3).evalf()) < 1e-14
    True
    """
    return _series(exp(-s * T * delay) * (1 - exp(-s * T)) / (s * T))


@effect("series")
def series(G: Formula) -> Matrix:
    """Any series effect: the force is multiplied by G(s), which may be improper.

    G : formula in ``s`` and the names of ``parameters``.

    >>> series("1/(1 + s*T)", parameters={"T": "10 ms"}).matrix
    (1/(s/100 + 1), 0, 0, 1)
    """
    return _series(G)


@effect("shunt")
def shunt(
    m: SignedMass = 0, b: SignedDamping = 0, k: SignedStiffness = 0, Z: Formula = None
) -> Matrix:
    """An impedance parallel to the environment, such as the device's own mass: H_perc = H + Z, Z(s) = m
    s^2 + b s + k.

    m : kg; b : N s/m; k : N/m; any sign (a negative mass is inertia compensation); each may be
    absent.
    Z : a formula in ``s`` and the names of ``parameters`` instead of these.

    >>> shunt(m="-45 g").matrix
    (1, -9*s**2/200, 0, 1)
    """
    given = bool(m or b or k)
    if Z is not None and given:
        raise SceneError("shunt: give either Z, or some of m, b, k")
    if Z is None and not given:
        raise SceneError("shunt: give Z, or at least one of m, b, k")
    return _shunt(m * s**2 + b * s + k if Z is None else Z)


@effect("compliance")
def compliance(k: PositiveStiffness = 0, b: PositiveDamping = 0) -> Matrix:
    """A spring and damper in the drive train (torsion bar, cable, virtual coupling): 1/H_perc = 1/H
    + 1/(k + b s).

    k : stiffness, N/m; b : damping, N s/m; both > 0; one of them may be absent.

    >>> compliance(k="5000 N/m").matrix
    (1, 0, 1/5000, 1)
    """
    if not (k or b):
        raise SceneError("compliance: give at least one of k, b")
    # One force, and motions that add up: X_h = X_e + F_e/(k + b s).
    return (1, 0, 1 / (k + b * s), 1)


@effect("coulomb-friction")
def coulomb_friction(force: Force, amplitude: Amplitude) -> Matrix:
    """Dry friction as its describing function, a shunt Z = j 4 F/(pi A): exact for sinusoidal
    motion of that amplitude.

    force : friction force F, N, >= 0; amplitude : of the hand's motion A, m, > 0.

    >>> coulomb_friction("0.2 N", "5 cm").matrix
    (1, 16*I/pi, 0, 1)
    """
    # The first harmonic of a square wave of height F is 4 F/pi, in phase with the velocity j omega
    # X; over X it depends on the amplitude and not on omega.
    return _shunt(I * 4 * force / (pi * amplitude))


@effect("encoder")
def encoder(q: Amplitude, amplitude: Amplitude) -> Matrix:
    """An encoder that rounds the motion to whole steps, q round(x/q), as its describing function:
    H_perc = N H, N = 4 q/(pi A) times the sum of sqrt(1 - ((2 i - 1) q/(2 A))^2), (2 i - 1) q < 2 A.

    q : step, m or rad, > 0; amplitude : of the motion A, > 0. N = 0 where 2 A <= q: it never moves
    on by a step. Left out: all harmonics but the first, and what the motion adds to the sine.
    Derivation: 22_quantiser.

    >>> encoder("1 mm", "0.4 mm").matrix
    (0, 0, 0, 1)
    """
    return _series(quantiser(q / (2 * amplitude)))


@effect("backlash")
def backlash(gap: Amplitude, amplitude: Amplitude) -> Matrix:
    """Play between hand and environment, as its describing function: H_perc = N H, N = 1/2 + (asin
    u + u sqrt(1 - u^2))/pi - j (1 - u^2)/pi, u = 1 - gap/A.

    gap : total width of the play, m or rad, > 0; amplitude : of the hand's motion A, > 0. The
    driven side keeps its place while no flank touches it; N = 0 where 2 A <= gap: none ever does.
    Left out: all harmonics but the first, and what a mass behind the play does on its own.
    Derivation: 23_backlash.

    >>> backlash("1 mm", "0.5 mm").matrix
    (0, 0, 0, 1)
    """
    u = 1 - gap / amplitude
    return _series(following(u) + I * lagging(u))


@effect("dead-zone")
def dead_zone(width: Amplitude, amplitude: Amplitude) -> Matrix:
    """A motion of which the part within a width on either side of 0 is lost, as its describing
    function: H_perc = N H, N = 1 - 2/pi (asin u + u sqrt(1 - u^2)), u = width/A.

    width : half width, m or rad, > 0; amplitude : of the hand's motion A, > 0. N = 0 where A <=
    width. Left out: all harmonics but the first. Derivation: 24_dead_zone.

    >>> dead_zone("1 mm", "1 mm").matrix
    (0, 0, 0, 1)
    """
    return _series(deadband(width / amplitude))


@effect("saturation")
def saturation(limit: PositiveForce, amplitude: PositiveForce) -> Matrix:
    """A force that is limited, as its describing function: H_perc = N H, N = 2/pi (asin u + u
    sqrt(1 - u^2)), u = limit/A; 1 where A <= limit.

    limit : N or N m, > 0; amplitude : of the force that enters A, N or N m, > 0.
    Left out: all harmonics but the first. Derivation: 24_dead_zone.

    >>> saturation("2 N", "1 N").matrix
    (1, 0, 0, 1)
    """
    return _series(limiter(limit / amplitude))


@effect("admittance-display")
def admittance_display(P: Formula, tau: Time = 0) -> Matrix:
    """An admittance display, X = P exp(-s tau) F/H_env: H_perc = H_env exp(s tau)/P, with P(s) the
    closed position loop.

    P : formula in ``s`` and the names of ``parameters``; tau : its delay, s, absent = none.

    >>> admittance_display("1/(s/100 + 1)").matrix
    (s/100 + 1, 0, 0, 1)
    >>> admittance_display(1, "25 ms").matrix
    (exp(s/40), 0, 0, 1)
    """
    # X = P exp(-s tau) F/H_env: a delay of the motion is a lead in force per motion.
    return (exp(s * tau) / P, 0, 0, 1)


@effect("wave-variables")
def wave_variables(b: PositiveDamping, tau: PositiveTime) -> Matrix:
    """A wave-variable (lossless transmission line) link: [[cosh s tau, b s sinh s tau], [sinh s
    tau/(b s), cosh s tau]].

    b : wave impedance, N s/m, > 0; tau : one-way delay, s, > 0. Source: Niemeyer and Slotine
    (1991).

    >>> wave_variables(2, 3).matrix
    (cosh(3*s), 2*s*sinh(3*s), sinh(3*s)/(2*s), cosh(3*s))
    """
    return (cosh(s * tau), b * s * sinh(s * tau), sinh(s * tau) / (b * s), cosh(s * tau))


@effect("position-force-teleoperator")
def position_force_teleoperator(
    Mm: PositiveMass,
    Ms: PositiveMass,
    Bs: Damping,
    Ks: Stiffness,
    tau: Time = 0,
    Dm: Damping = 0,
    Ds: Damping = 0,
    scale_x: Scale = 1,
    scale_f: Scale = 1,
) -> Matrix:
    """Position-force teleoperator: H_perc = Zm + scale_x scale_f E Cs H/(Zs + Cs + H).

    Zm = Mm s^2 + Dm s and Zs = Ms s^2 + Ds s : the devices, kg and N s/m; Cs = Bs s + Ks : the
    slave's controller, N s/m and N/m; E = exp(-2 s tau), tau : one-way delay, s, >= 0. The slave
    follows scale_x times the hand's position, which feels scale_f times its force, both > 0.
    Absent: no delay, no damping, scales of 1.

    >>> position_force_teleoperator(1, 2, 3, 4).matrix[2:]
    (1, 2*s**2 + 3*s + 4)
    """
    Zm, Zcs, Cs = Mm * s**2 + Dm * s, Ms * s**2 + (Ds + Bs) * s + Ks, Bs * s + Ks
    E = scale_x * scale_f * exp(-2 * s * tau)
    # H_perc over the common denominator Zcs + H; a chain matrix counts up to a factor.
    return (Zm + E * Cs, Zm * Zcs, 1, Zcs)


@effect("position-position-teleoperator")
def position_position_teleoperator(
    Mm: PositiveMass,
    Bm: Damping,
    Km: Stiffness,
    Ms: PositiveMass,
    Bs: Damping,
    Ks: Stiffness,
    tau: Time = 0,
    Dm: Damping = 0,
    Ds: Damping = 0,
) -> Matrix:
    """Position-position teleoperator: H_perc = Zm + Cm - E Cm Cs/(Zs + Cs + H).

    Zm = Mm s^2 + Dm s, Zs = Ms s^2 + Ds s : the devices, kg and N s/m, absent damping = 0; Cm = Bm
    s + Km, Cs = Bs s + Ks : the controllers, N s/m and N/m; E = exp(-2 s tau), tau : one-way delay,
    s, >= 0, absent = no delay. Scales of position and force are in Cm: scale_x scale_f Cs of equal
    ones.

    >>> position_position_teleoperator(1, 1, 1, 2, 3, 4).matrix[0]
    s**2 + s + 1
    """
    Cm, Cs, E = Bm * s + Km, Bs * s + Ks, exp(-2 * s * tau)
    Zcm, Zcs = Mm * s**2 + Dm * s + Cm, Ms * s**2 + Ds * s + Cs
    return (Zcm, Zcm * Zcs - E * Cm * Cs, 1, Zcs)


@effect("four-channel-teleoperator")
def four_channel_teleoperator(
    Mm: PositiveMass,
    Bm: Damping,
    Km: Stiffness,
    Ms: PositiveMass,
    Bs: Damping,
    Ks: Stiffness,
    tau: Time = 0,
    Dm: Damping = 0,
    Ds: Damping = 0,
    scale_x: Scale = 1,
    scale_f: Scale = 1,
) -> Matrix:
    """Four-channel teleoperator: H_perc = Zcm + E (n H - Zcm)(Zcm + n Zcs)/(n Zcs + n H - E (n H -
    Zcm)), n = scale_x scale_f; n H itself without delay.

    Zcm = Mm s^2 + (Dm + Bm) s + Km, Zcs = Ms s^2 + (Ds + Bs) s + Ks : device plus controller, kg, N
    s/m, N/m; E = exp(-2 s tau), tau : one-way delay, s, >= 0. The slave moves by scale_x times the
    hand's motion, which feels scale_f times its force, both > 0. Absent: no delay, no damping of
    the devices, scales of 1.
    Source: Lawrence (1993), transparency-optimised gains.

    >>> four_channel_teleoperator(1, 1, 1, 2, 3, 4).matrix[1:3]
    (0, 0)
    """
    n, E = scale_x * scale_f, exp(-2 * s * tau)
    # The slave's side as the hand sees it: forces times scale_f, motions over scale_x.
    Zcm, Zcs = Mm * s**2 + (Dm + Bm) * s + Km, n * (Ms * s**2 + (Ds + Bs) * s + Ks)
    return (n * (Zcm + E * Zcs), Zcm * Zcs * (1 - E), n * (1 - E), Zcs + E * Zcm)


@effect("two-port")
def two_port(A: Formula, B: Formula, C: Formula, D: Formula) -> Matrix:
    """Any linear two-port, by its chain matrix: F_h = A F_e + B X_e, X_h = C F_e + D X_e.

    A, B, C, D : formulas in ``s`` and the names of ``parameters``.

    >>> two_port("1", "2*s^2", "0", "1").matrix
    (1, 2*s**2, 0, 1)
    """
    return (A, B, C, D)
