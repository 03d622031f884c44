r"""The display that measures force and moves: why an admittance display divides by its position loop.

Claim. An admittance display computes from the measured force S_f F_h how the environment would move and moves so, X_h = P X_ref
with its closed position loop P. What the hand feels is

    H_perc = H_env/(P S_f),    dH = H_env (1/(P S_f) - 1),

as long as the hand cannot push the position loop away; if it can, by D = X_h/F_h at X_ref = 0, 1/H_perc = P S_f/H_env + D.
With P = omega_p/(s + omega_p) and a perfect sensor a mass-spring-damper is felt, at all frequencies, with the stiffness k, the
mass m + b/omega_p and the damping b + (k - m omega^2)/omega_p; the display is active above sqrt((k + b omega_p)/m). Whatever
the environment, |dH/H_env| = omega/omega_p: unnoticed up to c omega_p, where the r_i of a mass or a spring and the r_r of a
damper meet the threshold. The lags of loop and sensor add up: |dH/H_env| = omega (T_p + T_f) to first order.

Assumptions. Linear; one degree of freedom; the computed motion is exact; m, b, k, omega_p > 0; c the same for both parts (eq. 4).

Source. The architecture: A. Q. L. Keemink, H. van der Kooij, A. H. A. Stienen, Admittance control for physical human-robot
interaction, Int. J. Robotics Research, 2018 (recalled; the derivation does not rest on it). Eqs. (4), (9), (10) of Fu, van
Paassen and Mulder (2019), doi:10.1016/j.ifacol.2019.12.119.

Run as ``python 08_admittance_display.py [directory]``; formulas and figure go to the directory, ``derived`` if none is given.
"""

# %%
import sys
from decimal import Context
from pathlib import Path

from sympy import (
    Abs,
    Expr,
    I,
    Integer,
    Poly,
    Rational,
    Symbol,
    cancel,
    cos,
    diff,
    exp,
    expand,
    fraction,
    pi,
    sin,
    solve,
    sqrt,
    symbols,
    together,
)

m, b, k, omega, omega_p, omega_f, c, tau = symbols("m b k omega omega_p omega_f c tau", positive=True)
m_d, K_p, K_d, w, zeta = symbols("m_d K_p K_d w zeta", positive=True)
s, H, P, S_f, D = symbols("s H P S_f D")
F_h, X_h, X_ref = symbols("F_h X_h X_ref")


def is_zero(difference: Expr) -> bool:
    """Whether an expression is zero identically: waves as exponentials, over a common denominator, multiplied out."""
    return expand(fraction(together(difference.rewrite(exp)))[0]) == 0


# %% [markdown]
# ## 1. Around the loop
#
# The sensor says $S_fF_h$. The computed environment moves under that force as $H_{env}X_{ref} = S_fF_h$. The position loop
# makes the device do the same, $X_h = PX_{ref}$, but gives way a little to the hand: $X_h = PX_{ref} + DF_h$.

# %%
computed = H * X_ref - S_f * F_h
moved = X_h - (P * X_ref + D * F_h)
[motions] = solve([computed, moved], [X_ref, X_h], dict=True)
H_perc = F_h / motions[X_h]
assert is_zero(1 / H_perc - (P * S_f / H + D))
assert is_zero(H_perc.subs(D, 0) - H / (P * S_f))

dH = H / (P * S_f) - H  # eq. (9)
assert is_zero(dH - H * (1 / (P * S_f) - 1))

# %% [markdown]
# What are $P$ and $D$? Newton's law for the device with a position controller,
# $m_d\ddot x = K_p(x_{ref} - x) - K_d\dot x + f_h$, gives a second-order $P$ of natural frequency $w = \sqrt{K_p/m_d}$ and
# $D = P/K_p$. So the hand feels the environment in series with a spring of about $K_p$: nothing, as long as that is much
# stiffer than the environment over $S_f$; and $D = 0$ exactly if the measured force is fed forward to the motor. From here
# on, $D = 0$.

# %%
newton = m_d * s**2 * X_h - (K_p * (X_ref - X_h) - K_d * s * X_h + F_h)
[[position]] = [solve(newton, X_h)]
P_loop, D_loop = (cancel(expand(position).coeff(signal)) for signal in (X_ref, F_h))
second_order = w**2 / (s**2 + 2 * zeta * w * s + w**2)
assert is_zero(P_loop - second_order.subs({w: sqrt(K_p / m_d), zeta: K_d / (2 * sqrt(K_p * m_d))}))
assert is_zero(D_loop - P_loop / K_p)
assert is_zero(1 / H_perc.subs(D, P / K_p) - P * (S_f / H + 1 / K_p))

# %% [markdown]
# ## 2. A lag of first order
#
# $P = \omega_p/(s + \omega_p)$ and $S_f = 1$: $H_{perc} = H(1 + s/\omega_p)$, a polynomial. It is the environment plus
# $s/\omega_p$ times itself, so stiffness turns into damping, damping into mass, and mass into something that pushes.

# %%
msd = m * s**2 + b * s + k
lag = omega_p / (s + omega_p)
felt = msd / lag
real_felt = k - (m + b / omega_p) * omega**2
imag_felt = omega * (b + (k - m * omega**2) / omega_p)
assert is_zero(felt.subs(s, I * omega) - real_felt - I * imag_felt)

stiffness_felt, mass_felt = k, m + b / omega_p
damping_felt = b + (k - m * omega**2) / omega_p
assert is_zero(real_felt - stiffness_felt + mass_felt * omega**2)
assert is_zero(imag_felt - damping_felt * omega)

# %% [markdown]
# The changeover falls, from $\sqrt{k/m}$ to $\sqrt{k/(m + b/\omega_p)}$. And there is no damping left where
# $m\omega^2 = k + b\omega_p$: beyond, $\Im H_{perc} < 0$, the display is active. A bare mass is rendered by an active
# display at all frequencies.

# %%
changeover = sqrt(k / mass_felt)
omega_a = sqrt((k + b * omega_p) / m)
assert is_zero(real_felt.subs(omega, changeover))
assert is_zero(imag_felt.subs(omega, omega_a))
assert diff(damping_felt, omega) == -2 * m * omega / omega_p  # it falls throughout
assert is_zero(imag_felt.subs({b: 0, k: 0}) + m * omega**3 / omega_p)

# %% [markdown]
# ## 3. When
#
# $1/P - 1 = j\omega/\omega_p$, a quarter turn: $\Re\Delta H = -\frac{\omega}{\omega_p}\Im H_{env}$ and
# $\Im\Delta H = \frac{\omega}{\omega_p}\Re H_{env}$. So
#
# * $r_r = \frac{\omega}{\omega_p}\,\frac{|\Im H|}{|H|}$, $r_i = \frac{\omega}{\omega_p}\,\frac{|\Re H|}{|H|}$, and
#   $r_r^2 + r_i^2 = (\omega/\omega_p)^2$ whatever the environment: unnoticed up to $c\,\omega_p$;
# * a mass or a spring alone has $r_r = 0$ and $r_i = \omega/\omega_p$, a damper the reverse: $c\,\omega_p$ is attained;
# * above $\sqrt 2\,c\,\omega_p$ one of the two exceeds $c$, for every environment.

# %%
A, B = k - m * omega**2, b * omega
real, imag = -omega * B / omega_p, omega * A / omega_p
square = A**2 + B**2
assert is_zero(msd.subs(s, I * omega) - A - I * B)
assert is_zero((msd * (1 / lag - 1)).subs(s, I * omega) - real - I * imag)
assert is_zero(real**2 + imag**2 - square * (omega / omega_p) ** 2)

budget = c * omega_p
for others, part, none in (({m: 0, b: 0}, imag, real), ({b: 0, k: 0}, imag, real), ({m: 0, k: 0}, real, imag)):
    assert is_zero((part**2 / square).subs(others).subs(omega, budget) - c**2)
    assert none.subs(others) == 0

# %% [markdown]
# (An impedance display behind the same lag has $|\Delta H/H| = y/\sqrt{1 + y^2}$ with $y = \omega/\omega_p$, and so
# $c/\sqrt{1 - c^2}\,\omega_p$: the same budget but for half a per cent. Only its errors have other signs.)

# %%
behind_lag = (lag - 1).subs(s, I * omega)
behind_lag_squared = (omega / omega_p) ** 2 / (1 + (omega / omega_p) ** 2)
assert is_zero(behind_lag * behind_lag.subs(omega, -omega) - behind_lag_squared)
assert is_zero(behind_lag_squared.subs(omega, budget / sqrt(1 - c**2)) - c**2)

# %% [markdown]
# ## 4. Loop and sensor together
#
# $1/P$ and $1/S_f$ multiply. With a second-order loop and a first-order sensor $1/(PS_f) = a + jd$,
# $a = 1 - \omega^2\left(\frac{1}{w^2} + \frac{2\zeta}{w\omega_f}\right)$,
# $d = \omega\left(\frac{2\zeta}{w} + \frac{1}{\omega_f}\right) - \frac{\omega^3}{w^2\omega_f}$: to first order the two lags
# $2\zeta/w$ and $1/\omega_f$ add up.

# %%
sensor = omega_f / (s + omega_f)
a = 1 - omega**2 * (1 / w**2 + 2 * zeta / (w * omega_f))
d = omega * (2 * zeta / w + 1 / omega_f) - omega**3 / (w**2 * omega_f)
assert is_zero((1 / (second_order * sensor)).subs(s, I * omega) - a - I * d)
assert is_zero(diff(a - 1 + I * d, omega).subs(omega, 0) - I * (2 * zeta / w + 1 / omega_f))

both_real, both_imag = A * (a - 1) - B * d, A * d + B * (a - 1)
assert is_zero((A + I * B) * (a - 1 + I * d) - both_real - I * both_imag)

# %% [markdown]
# A delay in the loop is divided by as well: $H e^{s\tau}$, a *prediction*. A mass is then felt as $m\cos\omega\tau$,
# lighter, and active at once.

# %%
predicted = (m * s**2 / exp(-s * tau)).subs(s, I * omega)
assert is_zero(predicted + m * omega**2 * (cos(omega * tau) + I * sin(omega * tau)))

# %% [markdown]
# ## 5. The package says the same

# %%
import haptisym as hs

E, F = hs.environments, hs.effects
packaged = hs.distort(E.mass_spring_damper(m, b, k), F.admittance_display(lag))
perceived = packaged.perceived_properties
for name, derived, form in [
    ("H_perc", felt, packaged.perceived),
    ("dH", msd * (1 / lag - 1), packaged.distortion),
    ("Re dH", real, packaged.real),
    ("Im dH", imag, packaged.imag),
    ("Re H_perc", real_felt, perceived.real),
    ("damping felt", damping_felt, perceived.damping),
    ("changeover, squared", changeover**2, packaged.changeover_perceived**2),
]:
    assert is_zero(derived - form), name
for ratio, part in ((packaged.ratio_real, real), (packaged.ratio_imag, imag)):
    assert is_zero(ratio.replace(Abs, lambda value: value) ** 2 - part**2 / square)

both = hs.distort(E.mass_spring_damper(m, b, k), F.series(1 / sensor), F.admittance_display(second_order))
assert is_zero(both.perceived - msd / (second_order * sensor))
assert is_zero(both.real - both_real)
assert is_zero(both.imag - both_imag)

yielding = hs.distort(
    E.mass_spring_damper(m, b, k),
    F.admittance_display(second_order),
    F.two_port(Integer(1), Integer(0), second_order / K_p, Integer(1)),
)
assert is_zero(yielding.perceived - H_perc.subs({S_f: 1, P: second_order, D: second_order / K_p, H: msd}))

delayed = hs.distort(E.mass_spring_damper(m=m), F.admittance_display(exp(-s * tau)))
assert is_zero(delayed.perceived_properties.real + I * delayed.perceived_properties.imag - predicted)
assert is_zero(delayed.perceived_properties.mass - m * cos(omega * tau))

# %% [markdown]
# Evaluations with numbers. First-order loop of 100 rad/s on 6 kg, 10 Ns/m, 150 N/m: the excess of a ratio over 10 % is a
# polynomial in $W = \omega^2$ with rational coefficients; all its roots are found, and their number is proven by Sturm's
# theorem.

# %%
from haptisym import CrossingKind, Part

W = Symbol("W", positive=True)
TEN_PERCENT = Rational("0.1")
NUMBERS = {m: 6, b: 10, k: 150, omega_p: 100}


def digits(value: Expr) -> str:
    """A number rounded to 30 digits from 50."""
    return f"{Context(prec=30).create_decimal(str(value.evalf(50))):f}"


def excess(part: Expr, values: dict[Symbol, Expr]) -> Poly:
    """A part of dH squared less (c |H|)^2, in W."""
    return Poly(expand((part**2 - TEN_PERCENT**2 * square).subs(values)).subs(omega, sqrt(W)), W)


def crossings(parts: dict[Part, Expr], values: dict[Symbol, Expr], top: Expr) -> list[tuple[str, Part]]:
    """All places up to the top of the band where a ratio meets 10 %."""
    found = []
    for part, form in parts.items():
        roots = excess(form, values).nroots(n=60, maxsteps=500)
        found += [(digits(sqrt(root)), part) for root in roots if root.is_real and 0 < root < top**2]
    return sorted(found, key=lambda row: float(row[0]))


first_parts = {Part.REAL: real, Part.IMAG: imag}
assert [excess(form, NUMBERS).count_roots(0, 100**2) for form in first_parts.values()] == [0, 1]

scene = hs.Scene(
    E.mass_spring_damper(6, 10, 150), (F.admittance_display(lag.subs(NUMBERS)),), (Integer(0), Integer(100))
)
result = hs.evaluate(scene, digits=30)
assert [(x.omega.digits(30), x.part) for x in result.crossings] == crossings(first_parts, NUMBERS, 100)
assert [x.kind for x in result.crossings] == [CrossingKind.EXCEEDS]
[active] = result.outside_model
assert active.low.omega.digits(30) == digits(omega_a.subs(NUMBERS))
assert [x.omega.digits(30) for x in result.changeovers_perceived] == [digits(changeover.subs(NUMBERS))]
assert result.crossings[0].omega.digits(4) == "10.23"

# %% [markdown]
# The shipped scene, with a loop of 25 Hz and $\zeta$ = 0.8 and a sensor of 50 Hz: the same environment is noticed from 7.83
# rad/s on.

# %%
shipped = hs.load_scene("admittance-display")
assert [parameter.key for parameter in shipped.parameters] == ["m", "b", "k", "w_f", "w", "zeta"]
values = dict(zip((m, b, k, omega_f, w, zeta), [x.value for x in shipped.parameters], strict=True))
assert is_zero((msd / (second_order * sensor)).subs(values) - shipped.distortion().perceived)
both_parts = {Part.REAL: both_real, Part.IMAG: both_imag}
evaluated = hs.evaluate(shipped, digits=30)
found = [(x.omega.digits(30), x.part) for x in evaluated.crossings]
assert found == crossings(both_parts, values, 8 * pi)
assert found[0][0].startswith("7.832")

# %% [markdown]
# ## 6. Formulas and figure

# %%
from matplotlib.figure import Figure
from numpy import linspace
from sympy import lambdify

from haptisym import latex

output = Path(next((given for given in sys.argv[1:2] if not given.startswith("-")), "derived"))
output.mkdir(parents=True, exist_ok=True)

formulas = {
    r"H_{perc}": H / (P * S_f),
    r"\Delta H": H * (1 / (P * S_f) - 1),
    r"k_{perc}": stiffness_felt,
    r"m_{perc}": mass_felt,
    r"b_{perc}": damping_felt,
    r"\omega_{perc}": changeover,
    r"\omega_a": omega_a,
    r"\omega_{any}": budget,
}
formulas_tex = [f"{name} &= {latex(form)}" for name, form in formulas.items()]
(output / "08_admittance_display.tex").write_text(
    "\\begin{align}\n" + " \\\\\n".join(formulas_tex) + "\n\\end{align}\n", encoding="utf-8"
)

# %% [markdown]
# Left, the ratios with the first-order loop and, dotted, $\omega/\omega_p$, which bounds both. Right, the damping felt with
# it, and with the shipped scene's loop and sensor (dashed): below zero the display is active.

# %%
figure = Figure(figsize=(7.0, 2.9), layout="constrained")
ratios, dampings = figure.subplots(1, 2)
grid = linspace(0.05, 25, 501)
for form, style, label in ((real, "-", "$r_r$"), (imag, "--", "$r_i$")):
    ratio = lambdify(omega, sqrt(form**2 / square).subs(NUMBERS), "numpy")
    ratios.plot(grid, ratio(grid), style, color="k", lw=1.2, label=label)
ratios.plot(grid, grid / NUMBERS[omega_p], ":k", lw=0.8)
ratios.axhline(0.1, color="0.3", lw=0.8, ls=":")
ratios.plot(float(result.bandwidth), 0.1, "o", color="k", ms=4)
ratios.set(xlim=(0, 25), ylim=(0, 0.25), xlabel=r"$\omega$ (rad/s)", ylabel="distortion ratio")
ratios.legend(loc="upper left", frameon=False)
for form, style in ((damping_felt.subs(NUMBERS), "-"), (((B + both_imag) / omega).subs(values), "--")):
    dampings.plot(grid, lambdify(omega, form, "numpy")(grid), style, color="k", lw=1.2)
dampings.axhspan(-40, 0, color="0.9", lw=0)
dampings.set(xlim=(0, 25), ylim=(-40, 20), xlabel=r"$\omega$ (rad/s)", ylabel="damping felt (Ns/m)")
figure.savefig(output / "08_admittance_display.pdf", metadata={"CreationDate": None})
