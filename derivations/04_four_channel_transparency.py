r"""When a teleoperator vanishes, and what delay makes of it: the four-channel network, solved.

Claim. Of all gains of the four channels between master and slave exactly one set gives the hand the environment's own force and
motion, whatever they are: C1 = Zcs, C2 = C3 = 1, C4 = -Zcm. With a delay tau in each direction and E = exp(-2 s tau),

    H_perc = Zcm + E (H - Zcm)(Zcm + Zcs)/(Zcs + H - E (H - Zcm)),
    dH = -(1 - E)(H - Zcm)(H + Zcs)/(Zcs + H - E (H - Zcm)),

which is 0 identically for tau = 0; and, whatever the delay, for an environment that is like the master, H = Zcm. To first order
dH is that of a round trip 2 tau, -2 s tau H, times (H - Zcm)(H + Zcs)/(H (Zcm + Zcs)): soft controllers make a delay worse. The
chain matrix is [[Zcm + E Zcs, Zcm Zcs (1 - E)], [1 - E, Zcs + E Zcm]] over exp(-s tau)(Zcm + Zcs), and of determinant 1. With
two channels only, the same network gives the position-force and the position-position teleoperator. Where positions are scaled
by scale_x to the slave and forces by scale_f back, n = scale_x scale_f, the hand feels all of that with n H for H, n Zcs for Zcs.

Assumptions. Linear, one degree of freedom; master Zm = Mm s^2 + Dm s, slave Zs = Ms s^2 + Ds s; local controllers Cm = Bm s + Km
and Cs = Bs s + Ks; Zcm = Zm + Cm, Zcs = Zs + Cs; ideal force sensors and actuators; no local force feedback (Lawrence's C5, C6).
Everything is force per position (s times Lawrence's impedances), so that H is the dynamic stiffness of the environment.

Source. The four-channel architecture: D. A. Lawrence, Stability and Transparency in Bilateral Teleoperation, IEEE Trans.
Robotics and Automation 9(5), 1993 (recalled; the gains are derived here). dH: eq. (9) of Fu, van Paassen and Mulder (2019),
doi:10.1016/j.ifacol.2019.12.119.

Run as ``python 04_four_channel_transparency.py [directory]``; formulas and figure go to the directory, ``derived`` if none is
given.
"""

# %%
import sys
from pathlib import Path

from sympy import (
    Expr,
    I,
    Integer,
    Matrix,
    Rational,
    Symbol,
    diff,
    exp,
    expand,
    fraction,
    linear_eq_to_matrix,
    solve,
    sqrt,
    symbols,
    together,
)

Mm, Bm, Km, Ms, Bs, Ks, tau, omega = symbols("Mm Bm Km Ms Bs Ks tau omega", positive=True)
Dm, Ds, scale_x, scale_f = symbols("Dm Ds scale_x scale_f", positive=True)
s, H, Zm, Zs, Cm, Cs, C1, C2, C3, C4 = symbols("s H Z_m Z_s C_m C_s C1:5")
F_h, X_h, F_e, X_e = symbols("F_h X_h F_e X_e")
Zcm, Zcs = symbols("Z_cm Z_cs")


def is_zero(difference: Expr) -> bool:
    """Whether an expression is zero identically: exact, over a common denominator and multiplied out."""
    return expand(fraction(together(difference))[0]) == 0


# %% [markdown]
# ## 1. The network
#
# The master moves as the hand does, under the hand's force and its controller's; the slave under its controller's force
# against the environment's. Each controller holds its own device by $C_m$ or $C_s$ and listens to the other side's position
# and force, which arrive $\tau$ late:
#
# $Z_m X_h = F_h - C_m X_h - e^{-s\tau}(C_4 X_e + C_2 F_e)$, $\quad Z_s X_e = -F_e - C_s X_e + e^{-s\tau}(C_1 X_h + C_3 F_h)$.

# %%
late = exp(-s * tau)
E = exp(-2 * s * tau)
master = Zm * X_h - (F_h - Cm * X_h - late * (C4 * X_e + C2 * F_e))
slave = Zs * X_e - (-F_e - Cs * X_e + late * (C1 * X_h + C3 * F_h))
device = {Zm: Zcm - Cm, Zs: Zcs - Cs}  # what counts is device plus controller, Zcm and Zcs


# %% [markdown]
# ## 2. The gains
#
# Without delay the hand should feel the environment, $F_h = F_e$ and $X_h = X_e$, for every $F_e$ and $X_e$. Each equation
# then holds for two independent numbers, and that leaves no choice. (With $F_h = \lambda F_e$ and $X_h = \lambda X_e$, a
# scaled teleoperator, the hand would feel the same $H$; the gains are then $Z_{cs}/\lambda$, $\lambda$, $1/\lambda$,
# $-\lambda Z_{cm}$.)

# %%
scale = Symbol("lambda", positive=True)
vanished = {F_h: scale * F_e, X_h: scale * X_e, tau: 0}
demands = [
    equation.subs(device).subs(vanished).expand().coeff(signal) for equation in (master, slave) for signal in (F_e, X_e)
]
[scaled] = solve(demands, [C1, C2, C3, C4], dict=True)
assert scaled == {C1: Zcs / scale, C2: scale, C3: 1 / scale, C4: -scale * Zcm}
gains = {channel: gain.subs(scale, 1) for channel, gain in scaled.items()}
assert gains == {C1: Zcs, C2: 1, C3: 1, C4: -Zcm}

# %% [markdown]
# ## 3. What the hand feels
#
# Against an environment $F_e = H X_e$ the two equations are linear in $F_h$ and $X_e$ for a given $X_h$.


# %%
def felt(channels: dict[Symbol, Expr]) -> Expr:
    """H_perc = F_h/X_h for given gains."""
    equations = [equation.subs(device).subs(channels).subs(F_e, H * X_e) for equation in (master, slave)]
    coefficients, right = linear_eq_to_matrix(equations, [F_h, X_e])
    return together((coefficients.inv() * right)[0] / X_h)


N = Zcs + H - E * (H - Zcm)
H_perc = Zcm + E * (H - Zcm) * (Zcm + Zcs) / N
assert is_zero(felt(gains) - H_perc)

dH = H_perc - H  # eq. (9)
distortion = -(1 - E) * (H - Zcm) * (H + Zcs) / N
assert is_zero(dH - distortion)

# %% [markdown]
# So there is no distortion without delay, and none with any delay where $H = Z_{cm}$: there the master itself, with its
# controller, already is the environment, and what comes late is only the confirmation. ($H = -Z_{cs}$, the other zero, is no
# passive environment.)

# %%
assert dH.subs(tau, 0).expand() == 0
assert together(H_perc.subs(tau, 0) - H) == 0
assert dH.subs(H, Zcm) == 0
assert is_zero(dH.subs(H, -Zcs))
assert not is_zero(dH)

# %% [markdown]
# To first order in the delay: $\Delta H \approx -2s\tau\,(H - Z_{cm})(H + Z_{cs})/(Z_{cm} + Z_{cs})$. A plain delay of the
# round trip would have $-2s\tau H$. The teleoperator is better or worse by the factor
# $(1 - Z_{cm}/H)(H + Z_{cs})/(Z_{cm} + Z_{cs})$.

# %%
slope = diff(distortion, tau).subs(tau, 0)
factor = (H - Zcm) * (H + Zcs) / (H * (Zcm + Zcs))
assert is_zero(slope - diff(H * exp(-2 * s * tau), tau).subs(tau, 0) * factor)

# %% [markdown]
# ## 4. The chain matrix
#
# Solved for $F_h$ and $X_h$ instead, the equations give $[F_h; X_h] = T\,[F_e; X_e]$. A common factor of $T$ cancels in
# $H_{perc} = (A H + B)/(C H + D)$; without it the four entries are free of $e^{-s\tau}$ but for $E$. $\det T = 1$: the
# network is reciprocal, as if it were made of springs, masses, dampers and levers.

# %%
equations = [equation.subs(device).subs(gains) for equation in (master, slave)]
coefficients, right = linear_eq_to_matrix(equations, [F_h, X_h])
T = (coefficients.inv() * right).jacobian([F_e, X_e])
chain = Matrix([[Zcm + E * Zcs, Zcm * Zcs * (1 - E)], [1 - E, Zcs + E * Zcm]])
assert all(is_zero(entry) for entry in T - chain / (late * (Zcm + Zcs)))
assert is_zero(T.det() - 1)
assert T.subs(tau, 0).applyfunc(together) == Matrix([[1, 0], [0, 1]])

(A, B), (C, D) = chain.tolist()
assert is_zero((A * H + B) / (C * H + D) - H_perc)

# %% [markdown]
# ## 5. Two channels
#
# Position to the slave ($C_1 = C_s$) and force back ($C_2 = 1$, a free master: $C_m = 0$) is the position-force
# teleoperator; positions both ways ($C_1 = C_s$, $C_4 = -C_m$) the position-position one. Neither vanishes without delay,
# but for an environment that happens to solve $Z_m(Z_{cs} + H) = H(Z_s + H)$ or $(Z_{cm} - H)(Z_{cs} + H) = C_m C_s$.

# %%
position_force = Zm + E * Cs * H / (Zcs + H)
position_position = Zcm - E * Cm * Cs / (Zcs + H)
assert is_zero(felt({C1: Cs, C2: 1, C3: 0, C4: 0}).subs(Zcm, Zm) - position_force)
assert is_zero(felt({C1: Cs, C2: 0, C3: 0, C4: -Cm}) - position_position)

# %% [markdown]
# Scaled, the slave should move by $\sigma_x$ times the hand's motion, and the hand feel $\sigma_f$ times its force: with $n =
# \sigma_x\sigma_f$ the hand feels what it would of an environment $nH$ through a slave $nZ_{cs}$, without delay $nH$.

# %%
n = scale_x * scale_f
asked = {F_h: scale_f * F_e, X_e: scale_x * X_h, tau: 0}
demands = [equation.subs(device).subs(asked).expand().coeff(x) for equation in (master, slave) for x in (F_e, X_h)]
[with_scales] = solve(demands, [C1, C2, C3, C4], dict=True)
assert with_scales == {C1: scale_x * Zcs, C2: scale_f, C3: 1 / scale_f, C4: -Zcm / scale_x}
scaled_H_perc = H_perc.subs({H: n * H, Zcs: n * Zcs}, simultaneous=True)
assert is_zero(felt(with_scales) - scaled_H_perc)
assert is_zero(scaled_H_perc.subs(tau, 0) - n * H)
scaled_position_force = Zm + n * E * Cs * H / (Zcs + H)
assert is_zero(felt({C1: scale_x * Cs, C2: scale_f, C3: 0, C4: 0}).subs(Zcm, Zm) - scaled_position_force)
assert is_zero(felt({C1: scale_x * Cs, C2: 0, C3: 0, C4: -Cm / scale_x}) - position_position)  # its scale is in C_m

# %%
undelayed = {tau: 0, Zcs: Zs + Cs}
left_over = position_force.subs(undelayed) - H
assert is_zero(left_over - (Zm * (Zs + Cs + H) - H * (Zs + H)) / (Zs + Cs + H))
left_over = position_position.subs(tau, 0) - H
assert is_zero(left_over - ((Zcm - H) * (Zcs + H) - Cm * Cs) / (Zcs + H))

# %% [markdown]
# ## 6. On the axis
#
# $\Delta H(j\omega)$ with devices and controllers as polynomials, its real and imaginary part with numbers: the
# teleoperator of EmanueleFeola/phri (Mm = 0.5 kg, Ms = 2 kg, Bm = 16 and Bs = 64 Ns/m, Km = 10 and Ks = 40 N/m) holding 200
# N/m and 100 Ns/m, over 50 ms each way. At low frequency the first order says $|\Delta H/H| \approx 2\omega\tau\cdot 4.56$:
# such soft controllers cost 4.56 times what the delay alone costs, so that 10 % is to be expected near 0.22 rad/s.

# %%
DEVICES = {
    Zcm: Mm * s**2 + (Dm + Bm) * s + Km,
    Zcs: Ms * s**2 + (Ds + Bs) * s + Ks,
    Zm: Mm * s**2 + Dm * s,
    Cm: Bm * s + Km,
    Cs: Bs * s + Ks,
}
NUMBERS = {Dm: 0, Ds: 0, Mm: Rational("0.5"), Bm: 16, Km: 10, Ms: 2, Bs: 64, Ks: 40, tau: Rational("0.05")}
STIFFNESS, DAMPING = 200, 100
held = {H: DAMPING * s + STIFFNESS}

at_rest = factor.subs(held).subs(DEVICES).subs(NUMBERS).subs(s, 0)
assert at_rest == Rational("4.56")
first_guess = Rational("0.1") / (2 * NUMBERS[tau] * at_rest)
assert str(first_guess.evalf(2)) == "0.22"

on_axis = distortion.subs(held).subs(DEVICES).subs(NUMBERS).subs(s, I * omega)
modulus = sqrt(STIFFNESS**2 + (DAMPING * omega) ** 2)

# %% [markdown]
# ## 7. The package says the same

# %%
import haptisym as hs

effects = hs.effects
four = effects.four_channel_teleoperator(Mm, Bm, Km, Ms, Bs, Ks, tau, Dm, Ds)
any_environment = hs.environments.mass_spring_damper(k=H)  # H may be any number here, so also m s^2 + b s + k

for teleoperator, derived in [
    (four, H_perc),
    (effects.four_channel_teleoperator(Mm, Bm, Km, Ms, Bs, Ks, tau, Dm, Ds, scale_x, scale_f), scaled_H_perc),
    (effects.position_force_teleoperator(Mm, Ms, Bs, Ks, tau, Dm, Ds), position_force),
    (effects.position_force_teleoperator(Mm, Ms, Bs, Ks, tau, Dm, Ds, scale_x, scale_f), scaled_position_force),
    (effects.position_position_teleoperator(Mm, Bm, Km, Ms, Bs, Ks, tau, Dm, Ds), position_position),
]:
    d = hs.distort(any_environment, teleoperator)
    assert is_zero(d.perceived - derived.subs(DEVICES)), teleoperator.model
    assert is_zero(d.distortion - (derived - H).subs(DEVICES)), teleoperator.model

assert all(is_zero(entry) for entry in Matrix(2, 2, four.matrix) - chain.subs(DEVICES))

environment = hs.environments.mass_spring_damper(*hs.symbols("m b k"))
vanishing = hs.distort(environment, effects.four_channel_teleoperator(Mm, Bm, Km, Ms, Bs, Ks))
assert (vanishing.distortion, vanishing.ratio_real, vanishing.ratio_imag) == (0, 0, 0)
undamped = effects.four_channel_teleoperator(Mm, Bm, Km, Ms, Bs, Ks, tau)
like_the_master = hs.distort(hs.environments.mass_spring_damper(Mm, Bm, Km), undamped)
assert (like_the_master.distortion, like_the_master.real, like_the_master.imag) == (0, 0, 0)

# %% [markdown]
# An evaluation of that scene with numbers finds one crossing of each ratio up to 15 rad/s. At 35 decimals to the left of it
# the ratio is below 10 %, as far to the right above; and a scan of the derived ratios shows no other change. Without delay
# all is transparent.

# %%
from numpy import diff as differences
from numpy import flatnonzero, linspace
from numpy import sign as signs
from sympy import lambdify

from haptisym import CrossingKind, Part

BAND = (Integer(0), Integer(15))
C_JND = Rational("0.1")


def scene(delay: Rational | int) -> hs.Scene:
    """The scene of section 6 with some delay."""
    values = [NUMBERS[p] for p in (Mm, Bm, Km, Ms, Bs, Ks)]
    teleoperator = effects.four_channel_teleoperator(*values, delay)
    return hs.Scene(hs.environments.kelvin_voigt(STIFFNESS, DAMPING), (teleoperator,), BAND)


def ratio(part: Part, place: Expr) -> Expr:
    """r_r or r_i at a frequency, to 50 digits."""
    real, imag = on_axis.subs(omega, place).evalf(60).as_real_imag()
    return abs(real if part is Part.REAL else imag) / modulus.subs(omega, place).evalf(60)


result = hs.evaluate(scene(NUMBERS[tau]), digits=40)
crossings = {x.part: Rational(x.omega.digits(40)) for x in result.crossings}
assert [(x.part, x.kind) for x in result.crossings] == [
    (Part.IMAG, CrossingKind.EXCEEDS),
    (Part.REAL, CrossingKind.EXCEEDS),
]
for part, place in crossings.items():
    below, above = (ratio(part, place + side * Rational(10) ** -35) for side in (-1, 1))
    assert below < C_JND < above, part
assert str(crossings[Part.IMAG].evalf(6)) == "0.242757"
assert result.stable

grid = linspace(1e-3, 15, 3001)
scanned = lambdify(omega, on_axis / modulus, "numpy")(grid)
for part, values in {Part.REAL: abs(scanned.real), Part.IMAG: abs(scanned.imag)}.items():
    [change] = flatnonzero(differences(signs(values - 0.1)))
    assert grid[change] < crossings[part] < grid[change + 1]

undelayed_result = hs.evaluate(scene(0))
assert undelayed_result.crossings == ()
assert [(float(x.low.omega), float(x.high.omega)) for x in undelayed_result.transparent] == [(0, 15)]

# %% [markdown]
# ## 8. Formulas and figure

# %%
from matplotlib.figure import Figure
from numpy import logspace

from haptisym import latex

output = Path(next((given for given in sys.argv[1:2] if not given.startswith("-")), "derived"))
output.mkdir(parents=True, exist_ok=True)

formulas = {
    r"H_{perc}": H_perc,
    r"\Delta H": distortion,
    r"\left.\frac{\partial\,\Delta H}{\partial\tau}\right|_{\tau = 0}": -2 * s * H * factor,
    **{name: entry / (late * (Zcm + Zcs)) for name, entry in zip("ABCD", (A, B, C, D), strict=True)},
    r"H_{perc,pf}": position_force,
    r"H_{perc,pp}": position_position,
}
formulas_tex = [f"{name} &= {latex(form)}" for name, form in formulas.items()]
(output / "04_four_channel_transparency.tex").write_text(
    "\\begin{align}\n" + " \\\\\n".join(formulas_tex) + "\n\\end{align}\n", encoding="utf-8"
)

# %% [markdown]
# Left, the ratios of section 6, and dotted what the first order in the delay makes of their root sum of squares. Right, the
# factor by which the same teleoperator makes a delay worse, or better, for slow movements of a spring $k$: none is
# distorted less than that which is as stiff as the master's controller.

# %%
figure = Figure(figsize=(7.0, 2.9), layout="constrained")
ratios, factors = figure.subplots(1, 2)
ratios.plot(grid, abs(scanned.real), "-k", lw=1.2, label="$r_r$")
ratios.plot(grid, abs(scanned.imag), "--k", lw=1.2, label="$r_i$")
ratios.plot(grid, grid * float(Rational("0.1") / first_guess), ":k", lw=0.8)
ratios.axhline(0.1, color="0.3", lw=0.8, ls=":")
for place in crossings.values():
    ratios.plot(float(place), 0.1, "o", color="k", ms=4)
ratios.set(xlim=(0, 8), ylim=(0, 0.8), xlabel=r"$\omega$ (rad/s)", ylabel="distortion ratio")
ratios.legend(loc="upper right", bbox_to_anchor=(1, 0.6), frameon=False)
stiffnesses = logspace(0, 3, 601)
at_rest_of = lambdify(H, factor.subs(DEVICES).subs(NUMBERS).subs(s, 0), "numpy")
factors.loglog(stiffnesses, abs(at_rest_of(stiffnesses)), "-k", lw=1.2)
factors.plot(STIFFNESS, float(at_rest), "o", color="k", ms=4)
factors.axhline(1, color="0.3", lw=0.8, ls=":")
factors.set(xlim=(1, 1000), ylim=(0.01, 30), xlabel="stiffness held (N/m)", ylabel="factor on a delay of $2\\tau$")
figure.savefig(output / "04_four_channel_transparency.pdf", metadata={"CreationDate": None})
