r"""What sampling does to the dynamics felt: from the staircase of held forces to a delay of half a period.

Claim. A force that is sampled every T seconds and held in between is passed on, at the frequency of the movement, through
G(s) = (1 - exp(-s T))/(s T); on the axis that is exp(-j omega T/2) sin(y)/y with y = omega T/2: exactly the phase of a delay
of half a period, and a loss of amplitude of at most y^2/6. So |G - exp(-s T/2)| <= (omega T)^2/24 (9.4e-6 at 15 rad/s and
1 kHz). A spring is felt through it with r_i = (1 - cos x)/x, r_r = 1 - sin(x)/x, x = omega T: r_i exceeds 10 % from
x = 0.2006725... on, r_r from 0.7866... on.

Assumptions. Sampling and holding without quantisation; steady sinusoidal motion, below the Nyquist frequency pi/T; only the
component at the frequency of the movement is judged. The images at omega + 2 pi n/T, which the staircase also has, are
omega T/(omega T + 2 pi n) times as large as that component (section 3). T, m, b, k > 0.

Source. Eqs. (4), (9), (10) of W. Fu, M. M. van Paassen, M. Mulder, Framework for a Two-step Evaluation of Haptic Displays,
IFAC-PapersOnLine 52(19) 97-102, 2019, doi:10.1016/j.ifacol.2019.12.119. The hold is textbook material; here it is
derived.

Run as ``python 03_sample_and_hold.py [directory]``; formulas and figure go to the directory, ``derived`` if none is given.
"""

# %%
import sys
from collections.abc import Callable
from pathlib import Path

from sympy import (
    Expr,
    I,
    Integer,
    Rational,
    Symbol,
    cos,
    diff,
    exp,
    expand,
    fraction,
    integrate,
    pi,
    sin,
    sinh,
    symbols,
    together,
)

m, b, k, T, omega = symbols("m b k T omega", positive=True)
s, t, tau = symbols("s t tau")


def is_zero(difference: Expr) -> bool:
    """Whether an expression is zero identically: waves as exponentials, over a common denominator, multiplied out."""
    return expand(fraction(together(difference.rewrite(exp)))[0]) == 0


# %% [markdown]
# ## 1. The staircase
#
# While $nT \le t < (n+1)T$, the hand gets the force of the moment $nT$. Of a wave $e^{j\omega t}$ that makes a staircase.
# Divided by the wave itself, it is $e^{-j\omega(t - nT)}$: the same in every period, so a periodic function of period $T$,
# and its mean over one period is the part of the staircase that moves with the wave. This mean is $G$.

# %%
n = Symbol("n", integer=True)
wave = exp(I * omega * t)
held = wave.subs(t, n * T)
within = Symbol("within", real=True)  # the time since the last sample
assert is_zero((held / wave).subs(t, n * T + within) - exp(-I * omega * within))

passed = integrate(exp(-I * omega * within), (within, 0, T)) / T
assert is_zero(passed - (1 - exp(-I * omega * T)) / (I * omega * T))

# %% [markdown]
# The same for any force: a sample $f(nT)$ is held as a pulse of height $f(nT)$ and length $T$ (0 before, 0 after). The
# Laplace integral of a pulse of height 1 is $(1 - e^{-sT})/s$; and sampling passes on $1/T$ of the signal's own spectrum
# (besides images of it). The product is $G(s)$.

# %%
rate = Symbol("s", positive=True)  # s, in the half plane where the integral over a longer and longer time converges
pulse = integrate(exp(-rate * within), (within, 0, T)).subs(rate, s)
G = (1 - exp(-s * T)) / (s * T)
assert is_zero(pulse / T - G)
assert is_zero(G.subs(s, I * omega) - passed)

# %% [markdown]
# ## 2. Half a period
#
# Taking half of the exponent out leaves a real number: $G = e^{-sT/2}\,\frac{\sinh(sT/2)}{sT/2}$, on the axis
# $e^{-j\omega T/2}\,\frac{\sin y}{y}$ with $y = \omega T/2$. The delay is exactly $T/2$ while $y < \pi$; then the sine
# changes its sign.

# %%
y = omega * T / 2
assert is_zero(G - exp(-s * T / 2) * sinh(s * T / 2) / (s * T / 2))
assert is_zero(passed - exp(-I * y) * sin(y) / y)

# %% [markdown]
# The remainder. With $x = \omega T$, $|G - e^{-jx/2}| = 1 - \sin y/y$, and $1 - \sin y/y \le y^2/6 = x^2/24$: the function
# $g = y^3/6 - y + \sin y$ and its first two derivatives are 0 at $y = 0$, and its third is $1 - \cos y \ge 0$, so that all
# of them are $\ge 0$ for $y > 0$. The 24 cannot be improved: the quotient tends to 1 as $x \to 0$.

# %%
z = Symbol("y", positive=True)
g = z**3 / 6 - z + sin(z)
assert [diff(g, z, order).subs(z, 0) for order in range(3)] == [0, 0, 0]
assert is_zero(diff(g, z, 3) - 2 * sin(z / 2) ** 2)
assert is_zero((passed - exp(-I * y)) * exp(I * y) - (sin(y) / y - 1))
assert (1 - sin(z) / z).series(z, 0, 4).removeO() == z**2 / 6

remainder = (omega * T) ** 2 / 24
assert is_zero(remainder.subs(T, 2 * z / omega) - z**2 / 6)
assert is_zero(1 - sin(z) / z + g / z - z**2 / 6)  # the remainder is the bound less g/y
assert f"{float(remainder.subs({omega: 15, T: Rational('0.001')})):.1e}" == "9.4e-06"

# %% [markdown]
# To first order both are $1 - sT/2$: $G = \int_0^1 e^{-sTv}\,dv$ is the mean of all delays from 0 to $T$.

# %%
v = Symbol("v", positive=True)
assert is_zero(integrate(exp(-rate * T * v), (v, 0, 1)).subs(rate, s) - G)
for form in (G, exp(-s * T / 2)):
    assert form.series(s, 0, 2).removeO().equals(1 - s * T / 2)

# %% [markdown]
# ## 3. What else is in the staircase
#
# The other Fourier components of the periodic function are the images, at $\omega + 2\pi n/T$. They are $x/(x + 2\pi n)$
# times as large as the component judged here: 0.24 % at 15 rad/s and 1 kHz, and at some 6000 rad/s, where they are
# vibration, not dynamics.

# %%
image = passed.subs(omega, omega + 2 * pi * n / T)  # the mean of the periodic function against exp(2 pi j n t/T)
share = omega * T / (omega * T + 2 * pi * n)
assert is_zero(image - passed * share)
assert round(10000 * share.subs({n: 1, omega: 15, T: Rational("0.001")})) == 24

# %% [markdown]
# ## 4. The distortion
#
# $\Delta H = H(G - 1)$ for any environment. The parts of $G - 1$ are $\sin x/x - 1$ and $-(1 - \cos x)/x$; with a spring,
# whose $H$ is real and positive, their moduli are $r_r$ and $r_i$ themselves.

# %%
H = m * s**2 + b * s + k
dH = H * G - H  # eq. (9)
relative_real, relative_imag = sin(omega * T) / (omega * T) - 1, (cos(omega * T) - 1) / (omega * T)
assert is_zero(dH - H * (G - 1))
assert is_zero((G - 1).subs(s, I * omega) - relative_real - I * relative_imag)

# %% [markdown]
# For $0 < x \le 2$ both ratios grow, so each meets $c$ at most once there:
#
# * the slope of $(1 - \cos x)/x$ has the sign of $x\sin x - (1 - \cos x) = 2\sin y\,(2y\cos y - \sin y)$, $y = x/2 \le 1$;
#   and $\tan y < 2y$ there, because the tangent bends upwards and $\tan 1 < 2$;
# * the slope of $1 - \sin x/x$ has the sign of $\sin x - x\cos x$, which is 0 at 0 and has the slope $x\sin x > 0$.

# %%
x = Symbol("x", positive=True)
ratio_real, ratio_imag = 1 - sin(x) / x, (1 - cos(x)) / x
assert is_zero(ratio_real + relative_real.subs(omega, x / T))
assert is_zero(ratio_imag + relative_imag.subs(omega, x / T))
assert is_zero(diff(ratio_imag, x) * x**2 - 2 * sin(x / 2) * (x * cos(x / 2) - sin(x / 2)))
assert is_zero(diff(diff(sin(z) / cos(z), z), z) - 2 * sin(z) / cos(z) ** 3)
assert 2 * cos(1).evalf() > sin(1).evalf()
assert is_zero(diff(ratio_real, x) * x**2 - (sin(x) - x * cos(x)))
assert is_zero(diff(sin(x) - x * cos(x), x) - x * sin(x))

# %% [markdown]
# Where they meet $c$ = 10 % is no closed form, so it is enclosed: sine and cosine of a rational number lie between
# consecutive partial sums of their alternating series, so that the sign of a ratio less $c$ is proven in rational
# arithmetic.

# %%
C = Rational("0.1")
TERMS = 24


def partial_sums(place: Rational, first_power: int) -> list[Rational]:
    """The last two partial sums of sine (first power 1) or cosine (0), for 0 < place < 2: the function is in between."""
    total, term, sums = Integer(0), place**first_power, []
    for power in range(first_power, first_power + 2 * TERMS, 2):
        total += term
        sums.append(total)
        term *= -(place**2) / ((power + 1) * (power + 2))
    return sorted(sums[-2:])


def excess_imag(place: Rational) -> list[Rational]:
    """Bounds of 1 - cos(x) - c x."""
    low, high = partial_sums(place, 0)
    return [1 - high - C * place, 1 - low - C * place]


def excess_real(place: Rational) -> list[Rational]:
    """Bounds of (1 - c) x - sin(x)."""
    low, high = partial_sums(place, 1)
    return [(1 - C) * place - high, (1 - C) * place - low]


def crossing(excess: Callable[[Rational], list[Rational]], digits: int) -> str:
    """Where an excess becomes positive between 0.1 and 2, by bisection; each sign is proven."""
    low, high = Rational("0.1"), Integer(2)
    assert excess(low)[1] < 0 < excess(high)[0]
    while high - low > Rational(10) ** -(digits + 3):
        middle = (low + high) / 2
        bounds = excess(middle)
        assert bounds[0] > 0 or bounds[1] < 0
        low, high = (low, middle) if bounds[0] > 0 else (middle, high)
    assert low.round(digits) == high.round(digits)
    return str(low.evalf(digits))


crossing_imag, crossing_real = crossing(excess_imag, 30), crossing(excess_real, 30)
print(f"r_i = 10 % at omega T = {crossing_imag}\nr_r = 10 % at omega T = {crossing_real}")
assert crossing_imag.startswith("0.2006725")
assert crossing_real.startswith("0.7866")

# %% [markdown]
# A pure delay of $T/2$ has $r_i = c$ at $\omega T = 2\arcsin c = 0.2003$: a little earlier, since the hold's sine is
# divided by $y$. At 1 kHz the hold costs half a millisecond of the delay budget (6.67 ms at 15 rad/s, derivation 02).

# %% [markdown]
# ## 5. The package says the same

# %%
import haptisym as hs

hold = hs.effects.zero_order_hold(T)
d = hs.distort(hs.environments.mass_spring_damper(m, b, k), hold)
assert is_zero(hold.matrix[0] - G)
assert hold.matrix[1:] == (0, 0, 1)
assert is_zero(d.perceived - H * G)
assert is_zero(d.distortion - dH)
assert is_zero(d.relative_real - relative_real)
assert is_zero(d.relative_imag - relative_imag)
assert is_zero(d.ratio_real**2 + d.ratio_imag**2 - relative_real**2 - relative_imag**2)

spring = hs.distort(hs.environments.mass_spring_damper(k=k), hold)
assert is_zero(spring.real - k * relative_real)
assert is_zero(spring.imag - k * relative_imag)
assert is_zero(spring.ratio_real**2 - relative_real**2)
assert is_zero(spring.ratio_imag**2 - relative_imag**2)

# %% [markdown]
# An evaluation at 100 Hz finds the two crossings, to 30 digits, and no others up to $\omega T = 2$. And it finds that the
# spring is active at once, as behind any delay: $\Im H_{perc} = -k(1 - \cos x)/x < 0$.

# %%
from haptisym import CrossingKind, Part

PERIOD = Rational("0.01")
scene = hs.Scene(
    hs.environments.mass_spring_damper(k=100), (hs.effects.zero_order_hold(PERIOD),), (Integer(0), 2 / PERIOD)
)
result = hs.evaluate(scene, digits=30)


def at(place: str) -> str:
    """The frequency at which omega T has a value, to 28 digits."""
    return str((Rational(place) / PERIOD).evalf(28))


assert [(c.part, c.kind, c.sign, c.omega.digits(28)) for c in result.crossings] == [
    (Part.IMAG, CrossingKind.EXCEEDS, -1, at(crossing_imag)),
    (Part.REAL, CrossingKind.EXCEEDS, -1, at(crossing_real)),
]
assert result.bandwidth.digits(28) == at(crossing_imag)
[outside] = result.outside_model
assert (float(outside.low.omega), float(outside.high.omega)) == (0, 200)

# %% [markdown]
# ## 6. Formulas and figure

# %%
from matplotlib.figure import Figure
from numpy import floor, linspace, sinc
from numpy import pi as half_turn
from numpy import sin as wave_sin
from sympy import lambdify

from haptisym import latex

output = Path(next((given for given in sys.argv[1:2] if not given.startswith("-")), "derived"))
output.mkdir(parents=True, exist_ok=True)

formulas = {
    r"G(s)": G,
    r"G(\omega j)": exp(-I * y) * sin(y) / y,
    r"\epsilon": remainder,  # |G - exp(-s T/2)| is at most that
    r"\Re\frac{\Delta H}{H_{env}}": relative_real,
    r"\Im\frac{\Delta H}{H_{env}}": relative_imag,
}
formulas_tex = [f"{name} &= {latex(form)}" for name, form in formulas.items()]
(output / "03_sample_and_hold.tex").write_text(
    "\\begin{align}\n" + " \\\\\n".join(formulas_tex) + "\n\\end{align}\n", encoding="utf-8"
)

# %% [markdown]
# Left, eight samples per period: the staircase and its component at the wave's frequency, half a sample late. Right, the two
# ratios of a spring, with those of a pure delay of half a period in grey.

# %%
figure = Figure(figsize=(7.0, 2.9), layout="constrained")
staircase, ratios = figure.subplots(1, 2)
times = linspace(0, 12, 2401)  # in samples
angle = 2 * half_turn / 8
staircase.plot(times, wave_sin(angle * times), color="0.6", lw=1, label="$f_e$")
staircase.plot(times, wave_sin(angle * floor(times)), "-k", lw=0.8, label="held")
passed_on = sinc(1 / 8) * wave_sin(angle * (times - 0.5))  # numpy's sinc(u) is sin(pi u)/(pi u)
staircase.plot(times, passed_on, "--k", lw=1.2, label="at the same frequency")
staircase.set(xlim=(0, 12), ylim=(-1.1, 1.9), xlabel="time (samples)", ylabel="force")
staircase.legend(loc="upper right", frameon=False, fontsize=8)

places = linspace(1e-6, 2, 401)
for form, delayed, style, label in (
    (ratio_imag, sin(x / 2), "-", "$r_i$"),
    (ratio_real, 1 - cos(x / 2), "--", "$r_r$"),
):
    ratios.plot(places, lambdify(x, delayed, "numpy")(places), style, color="0.7", lw=1.2)
    ratios.plot(places, lambdify(x, form, "numpy")(places), style, color="k", lw=1.2, label=label)
ratios.axhline(0.1, color="0.3", lw=0.8, ls=":")
for place in (crossing_imag, crossing_real):
    ratios.plot(float(place), 0.1, "o", color="k", ms=4)
ratios.set(xlim=(0, 2), ylim=(0, 0.6), xlabel=r"$\omega T$ (rad)", ylabel="distortion ratio")
ratios.legend(loc="upper left", frameon=False)
figure.savefig(output / "03_sample_and_hold.pdf", metadata={"CreationDate": None})
