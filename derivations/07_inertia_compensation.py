r"""Feeling less mass than the device has: what inertia compensation distorts, and when it becomes active.

Claim. A device of mass m_d is to feel like m_t s^2 + b s + k. The controller renders the rest, R = (m_t - m_d) s^2 + b s + k,
through its loop G, and the hand adds m_d s^2 by holding the device:

    H_perc = G R + m_d s^2,    dH = (G - 1) R.

Only what is rendered is distorted. Behind a first-order lag omega_c

    Im H_perc = omega (b - (k + (m_d - m_t) omega^2)/omega_c)/(1 + (omega/omega_c)^2),

so a mass below the hardware's is felt from an active device above omega_a = sqrt((b omega_c - k)/(m_d - m_t)), at all
frequencies if b omega_c <= k; more mass than the hardware's costs nothing of the kind, once b omega_c >= k. Damping in the device
itself, b_d, prevents it at all frequencies if b_d >= omega_c (m_d - m_t) and b + b_d >= k/omega_c. A bare mass m_t is felt as
m_t + (m_d - m_t) y^2/(1 + y^2), y = omega/omega_c: as the device in the end. With q = |1 - m_d/m_t|, r_i reaches c at
y = (q -+ sqrt(q^2 - 4 c^2))/(2 c), if q >= 2 c, and r_r at y = sqrt(c/(q - c)), if q > c.

Assumptions. Linear; the device is one rigid mass (and, where it says so, a damper); m_d, m_t, b, k, omega_c > 0; acceleration is
measured without any error or lag other than G's.

Source. Eqs. (4), (6), (9), (10) of W. Fu, M. M. van Paassen, M. Mulder, Framework for a Two-step Evaluation of Haptic Displays,
IFAC-PapersOnLine 52(19) 97-102, 2019, doi:10.1016/j.ifacol.2019.12.119; eq. (6) assumes Im H_perc > 0.

Run as ``python 07_inertia_compensation.py [directory]``; formulas and figure go to the directory, ``derived`` if none is given.
"""

# %%
import sys
from decimal import Context
from pathlib import Path

from sympy import (
    Abs,
    Expr,
    Function,
    I,
    Integer,
    Poly,
    Rational,
    Symbol,
    cos,
    diff,
    exp,
    expand,
    fraction,
    limit,
    oo,
    sin,
    sqrt,
    symbols,
    together,
)

m_t, m_d, b, k, omega_c, omega, c, b_d, tau = symbols("m_t m_d b k omega_c omega c b_d tau", positive=True)
s, t, X = symbols("s t X")


def is_zero(difference: Expr) -> bool:
    """Whether an expression is zero identically: waves as exponentials, over a common denominator, multiplied out."""
    return expand(fraction(together(difference.rewrite(exp)))[0]) == 0


# %% [markdown]
# ## 1. Newton's law for the device
#
# The hand's force $f_h$ and the motor's force $-f_r$ move the device: $m_d\ddot x = f_h - f_r$. For $x = Xe^{st}$ the
# motor, told to render $R$, delivers $f_r = G R\,x$. With an ideal motor, $G = 1$, the hand should feel the target; that
# says what $R$ has to be.

# %%
G, R = Function("G")(s), Symbol("R")
motion = X * exp(s * t)
target = m_t * s**2 + b * s + k
f_h = m_d * motion.diff(t, 2) + G * R * motion
H_perc = expand(f_h / motion)
assert is_zero(H_perc - G * R - m_d * s**2)

rendered = target - m_d * s**2
assert is_zero(H_perc.subs({G: 1, R: rendered}) - target)
assert is_zero(rendered - ((m_t - m_d) * s**2 + b * s + k))

dH = H_perc.subs(R, rendered) - target  # eq. (9)
assert is_zero(dH - (G - 1) * rendered)

# %% [markdown]
# So the hardware's own mass is never distorted; but a target that is much lighter than the device is distorted as if the
# whole difference were an environment of its own.
#
# ## 2. Behind a first-order lag
#
# $G = \omega_c/(s + \omega_c)$, with $y = \omega/\omega_c$: $G = (1 - jy)/(1 + y^2)$ and $G - 1 = -(y^2 + jy)/(1 + y^2)$,
# against $R = K + jb\omega$, $K = k + (m_d - m_t)\omega^2$: to the motor, compensation is a *spring* that grows with the
# frequency.

# %%
lag = omega_c / (s + omega_c)
y = omega / omega_c
K = k + (m_d - m_t) * omega**2
assert is_zero(rendered.subs(s, I * omega) - K - I * b * omega)
assert is_zero(lag.subs(s, I * omega) - (1 - I * y) / (1 + y**2))

real = -y * (y * K - b * omega) / (1 + y**2)
imag = -y * (K + y * b * omega) / (1 + y**2)
felt_real = (K + y * b * omega) / (1 + y**2) - m_d * omega**2
felt_imag = (b * omega - y * K) / (1 + y**2)
assert is_zero(((lag - 1) * rendered).subs(s, I * omega) - real - I * imag)
assert is_zero(H_perc.subs(R, rendered).subs(G, lag).subs(s, I * omega) - felt_real - I * felt_imag)

# %% [markdown]
# ## 3. When it becomes active
#
# Moved by $x$ with $|X| = 1$, the device takes up $\frac{\omega}{2}\Im H_{perc}$ of power. If $\Im H_{perc} < 0$ it hands
# out energy, which eq. (6) excludes: no damping is felt there. The sign is that of $b\omega - yK$, that is of
# $b\omega_c - k - (m_d - m_t)\omega^2$:
#
# | | $b\omega_c > k$ | $b\omega_c < k$ |
# |---|---|---|
# | $m_t < m_d$ | active above $\omega_a$ | active everywhere |
# | $m_t > m_d$ | passive everywhere | active below $\omega_a$ |

# %%
activity = b * omega_c - k - (m_d - m_t) * omega**2
assert is_zero(felt_imag - omega * omega_c * activity / (omega**2 + omega_c**2))

omega_a = sqrt((b * omega_c - k) / (m_d - m_t))
assert is_zero(activity.subs(omega, omega_a))
assert is_zero(diff(activity, omega) + 2 * (m_d - m_t) * omega)  # it falls if m_t < m_d, else it rises

# %% [markdown]
# The power: force times velocity, averaged over a period.

# %%
place = Symbol("x", real=True)  # omega t
real_part, imag_part = symbols("R_H I_H", real=True)
force = real_part * cos(place) - imag_part * sin(place)  # Re (H e^(jx)), for x(t) = cos(omega t)
power = (force * diff(cos(place), place) * omega).expand()
assert is_zero(power + real_part * omega * sin(2 * place) / 2 - imag_part * omega * (1 - cos(2 * place)) / 2)

# %% [markdown]
# A damper in the device itself acts beside the lag, not behind it: $\Im H_{perc}$ grows by $b_d\omega$. It stays positive
# for all $\omega$ if $b + b_d \ge k/\omega_c$ and $b_d \ge \omega_c(m_d - m_t)$: of the hardware's mass, not more than
# $b_d/\omega_c$ may be compensated, unless the target's damping forbids it to be felt.

# %%
damped = together(felt_imag + b_d * omega) * (1 + y**2) * omega_c / omega
assert is_zero(damped - ((b + b_d) * omega_c - k + (b_d / omega_c - (m_d - m_t)) * omega**2))

# %% [markdown]
# Any other loop does the same where it only lags: behind a pure delay a mass alone has
# $\Im H_{perc} = (m_t - m_d)\omega^2\sin\omega\tau$, negative at once if $m_t < m_d$.

# %%
alone = {b: 0, k: 0}
delayed = H_perc.subs(R, rendered).subs(G, exp(-s * tau)).subs(alone).subs(s, I * omega)
delayed_imag = (m_t - m_d) * omega**2 * sin(omega * tau)
delayed_real = -(m_t - m_d) * omega**2 * cos(omega * tau) - m_d * omega**2
assert is_zero(delayed - delayed_real - I * delayed_imag)

# %% [markdown]
# What activity costs: a hand that is a mass $m_h$ on an undamped spring $k_h$ closes the loop $m_hs^2 + k_h + H_{perc}$. By
# Routh it is stable exactly if $m_t > m_d$ (with $b = k = 0$); with less, damping of the hand itself has to make up for it.

# %%
m_h, k_h = symbols("m_h k_h", positive=True)
loop = together(m_h * s**2 + k_h + H_perc.subs(R, rendered).subs(G, lag).subs(alone))
a3, a2, a1, a0 = Poly(fraction(loop)[0], s).all_coeffs()
assert is_zero(a2 * a1 - a3 * a0 - omega_c * k_h * (m_t - m_d))
assert is_zero(a2 - omega_c * (m_t + m_h))
assert (a1, a0) == (k_h, k_h * omega_c)
assert is_zero(a3 - (m_d + m_h))

# %% [markdown]
# ## 4. A bare mass
#
# $H = m_ts^2$: what is felt is $m_t$ at low frequency and the device at high frequency, with a halfway mark at $\omega_c$;
# heavier if $m_t < m_d$. The ratios depend on the two masses by $q = |1 - m_d/m_t|$ only.

# %%
felt_mass = m_t + (m_d - m_t) * omega**2 / (omega**2 + omega_c**2)
assert is_zero(-felt_real.subs(alone) / omega**2 - felt_mass)
assert felt_mass.subs(omega, 0) == m_t
assert limit(felt_mass, omega, oo) == m_d
assert is_zero(felt_mass.subs(omega, omega_c) - (m_t + m_d) / 2)

q, z = symbols("q y", positive=True)
modulus = m_t * omega**2
ratio_real, ratio_imag = q * z**2 / (1 + z**2), q * z / (1 + z**2)
in_masses = {z: y, q: 1 - m_d / m_t}
assert is_zero(real.subs(alone) / modulus - ratio_real.subs(in_masses))
assert is_zero(imag.subs(alone) / modulus - ratio_imag.subs(in_masses))

# %% [markdown]
# $r_i$ has its maximum, $q/2$, at $\omega_c$; $r_r$ grows towards $q$. So a compensation of less than the fraction $c$ is
# never noticed, one of less than $2c$ only in the mass.

# %%
assert is_zero(diff(ratio_imag, z) - q * (1 - z**2) / (1 + z**2) ** 2)
assert ratio_imag.subs(z, 1) == q / 2
assert is_zero(diff(ratio_real, z) - 2 * q * z / (1 + z**2) ** 2)
assert limit(ratio_real, z, oo) == q

imag_first, imag_last = ((q + sign * sqrt(q**2 - 4 * c**2)) / (2 * c) for sign in (-1, 1))
real_first = sqrt(c / (q - c))
assert all(is_zero(ratio_imag.subs(z, place) - c) for place in (imag_first, imag_last))
assert is_zero(ratio_real.subs(z, real_first) - c)

# %% [markdown]
# ## 5. The package says the same
#
# The hand's own way through the scene: what is rendered, through the lag, beside the device.

# %%
import haptisym as hs

E, F = hs.environments, hs.effects
through = (F.first_order_lag(omega_c), F.shunt(m=m_d))
d = hs.distort(E.mass_spring_damper(m_t, b, k), *through, rendered=E.expression(rendered))
perceived = d.perceived_properties
for name, derived, packaged in [
    ("H_perc", H_perc.subs(R, rendered).subs(G, lag), d.perceived),
    ("dH", (lag - 1) * rendered, d.distortion),
    ("Re dH", real, d.real),
    ("Im dH", imag, d.imag),
    ("Re H_perc", felt_real, perceived.real),
    ("Im H_perc", felt_imag, perceived.imag),
    ("r_r^2", real**2 / ((k - m_t * omega**2) ** 2 + (b * omega) ** 2), d.ratio_real**2),
    ("r_i^2", imag**2 / ((k - m_t * omega**2) ** 2 + (b * omega) ** 2), d.ratio_imag**2),
]:
    difference = (derived - packaged).replace(Abs, lambda value: value)  # of the ratios, squared and real
    assert is_zero(difference), name

with_damper = hs.distort(
    E.mass_spring_damper(m_t, b, k), F.first_order_lag(omega_c), F.shunt(m=m_d, b=b_d), rendered=E.expression(rendered)
)
assert is_zero(with_damper.perceived_properties.imag - felt_imag - b_d * omega)

bare = hs.distort(E.mass_spring_damper(m=m_t), *through, rendered=E.expression(rendered.subs(alone)))
assert is_zero(bare.perceived_properties.mass - felt_mass)
assert is_zero(bare.ratio_real.replace(Abs, lambda value: value) ** 2 - ratio_real.subs(in_masses) ** 2)
assert is_zero(bare.ratio_imag.replace(Abs, lambda value: value) ** 2 - ratio_imag.subs(in_masses) ** 2)

# %% [markdown]
# Evaluations with numbers. A device of 1 kg behind 100 rad/s that is to feel like 0.5 kg ($q = 1$), like 0.88 kg
# ($q = 3/22$, between $c$ and $2c$), like 0.95 kg ($q = 1/19 < c$) and like 2 kg ($q = 1/2$): the crossings are those of
# section 4, and the light ones are active at all frequencies.

# %%
from haptisym import CrossingKind, Part

EXCEEDS, RETURNS = CrossingKind.EXCEEDS, CrossingKind.RETURNS
BAND = (Integer(0), Integer(2000))
TEN_PERCENT = Rational("0.1")
DEVICE = {m_d: 1, omega_c: 100, c: TEN_PERCENT}


def digits(value: Expr) -> str:
    """A number rounded to 30 digits from 50."""
    return f"{Context(prec=30).create_decimal(str(value.evalf(50))):f}"


def evaluated(values: dict[Symbol, Expr]) -> hs.Evaluation:
    """The scene of a compensated device with numbers; parameters that are not there are 0."""
    given = {p: values.get(p, 0) for p in (m_t, b, k)}
    scene = hs.Scene(
        E.mass_spring_damper(*given.values()),
        (F.first_order_lag(values[omega_c]), F.shunt(m=values[m_d])),
        BAND,
        rendered=E.expression(rendered.subs(values).subs(given)),
    )
    return hs.evaluate(scene, digits=30)


for mass, count in {"0.5": 3, "0.88": 1, "0.95": 0, "2": 3}.items():
    values = {**DEVICE, m_t: Rational(mass)}
    numbers = {c: TEN_PERCENT, q: abs(1 - 1 / Rational(mass))}
    result = evaluated(values)
    rows = []
    if numbers[q] > 2 * TEN_PERCENT:
        rows += [(imag_first, Part.IMAG, EXCEEDS), (imag_last, Part.IMAG, RETURNS)]
    if numbers[q] > TEN_PERCENT:
        rows += [(real_first, Part.REAL, EXCEEDS)]
    expected = [(digits(DEVICE[omega_c] * place.subs(numbers)), *rest) for place, *rest in rows]
    found = [(x.omega.digits(30), x.part, x.kind) for x in result.crossings]
    assert found == sorted(expected, key=lambda row: float(row[0])), mass
    assert len(found) == count
    active = [(float(x.low.omega), float(x.high.omega)) for x in result.outside_model]
    assert active == ([(0, 2000)] if Rational(mass) < 1 else []), mass
    assert {x.change.value for x in result.percepts if x.part is Part.REAL} <= {
        "higher" if Rational(mass) < 1 else "lower"
    }

# %% [markdown]
# With a target of damping 5 Ns/m and stiffness 100 N/m the four cases of section 3: the activity starts, or ends, at
# $\omega_a$.

# %%
LOW, HIGH = BAND
for mass, stiffness, active in (
    ("0.5", 100, [(omega_a, HIGH)]),
    ("0.5", 900, [(LOW, HIGH)]),
    ("2", 100, []),
    ("2", 900, [(LOW, omega_a)]),
):
    values = {**DEVICE, m_t: Rational(mass), b: 5, k: stiffness}
    found = [(x.low.omega.digits(30), x.high.omega.digits(30)) for x in evaluated(values).outside_model]
    assert found == [tuple(digits(end.subs(values)) for end in ends) for ends in active], (mass, stiffness)

# %% [markdown]
# ## 6. Formulas and figure

# %%
from matplotlib.figure import Figure
from numpy import linspace, logspace
from sympy import lambdify

from haptisym import latex

output = Path(next((given for given in sys.argv[1:2] if not given.startswith("-")), "derived"))
output.mkdir(parents=True, exist_ok=True)

formulas = {
    r"H_{perc}(s)": lag * rendered + m_d * s**2,
    r"\Delta H(s)": (lag - 1) * rendered,
    r"\Im H_{perc}": omega * omega_c * activity / (omega**2 + omega_c**2),
    r"\omega_a": omega_a,
    r"m_{perc}": felt_mass,
    r"r_r": ratio_real,
    r"r_i": ratio_imag,
}
formulas_tex = [f"{name} &= {latex(form)}" for name, form in formulas.items()]
(output / "07_inertia_compensation.tex").write_text(
    "\\begin{align}\n" + " \\\\\n".join(formulas_tex) + "\n\\end{align}\n", encoding="utf-8"
)

# %% [markdown]
# Left, the mass felt on a device of 1 kg with a lag of 100 rad/s, for four targets. Right, the damping felt,
# $\Im H_{perc}/\omega$, for targets with 5 Ns/m: below zero the device is active.

# %%
figure = Figure(figsize=(7.0, 2.9), layout="constrained")
masses, dampings = figure.subplots(1, 2)
TARGETS = {0.25: ":", 0.5: "--", 0.88: "-.", 2.0: "-"}
mass_of = lambdify((omega, m_t), felt_mass.subs(DEVICE), "numpy")
damping_of = lambdify((omega, m_t), (felt_imag / omega).subs(DEVICE).subs({b: 5, k: 100}), "numpy")
wide, band = logspace(0, 4, 401), linspace(0.1, 60, 401)
for value, style in TARGETS.items():
    masses.semilogx(wide, mass_of(wide, value), style, color="k", lw=1.2, label=f"$m_t$ = {value:g} kg")
    dampings.plot(band, damping_of(band, value), style, color="k", lw=1.2)
masses.set(xlim=(1, 1e4), ylim=(0, 2.4), xlabel=r"$\omega$ (rad/s)", ylabel="mass felt (kg)")
masses.legend(loc="upper right", frameon=False, fontsize=8)
dampings.axhspan(-20, 0, color="0.9", lw=0)
dampings.set(xlim=(0, 60), ylim=(-20, 20), xlabel=r"$\omega$ (rad/s)", ylabel="damping felt (Ns/m)")
figure.savefig(output / "07_inertia_compensation.pdf", metadata={"CreationDate": None})
