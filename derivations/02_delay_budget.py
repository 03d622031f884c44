r"""How much delay may a haptic display have? The turned arrow, from f_h(t) = f_e(t - tau) to milliseconds.

Claim. A pure delay distorts every environment by dH = H (exp(-s tau) - 1). A spring, a damper or a mass alone is felt as
something else from omega tau = asin(c) on: the spring and the mass by r_i = |sin omega tau|, the damper by r_r, with the parts
exchanged; the other part, 1 - cos omega tau, follows at acos(1 - c). For any environment r_r^2 + r_i^2 = (2 sin(omega tau/2))^2,
so that a delay is unnoticed for all of them while omega tau <= 2 asin(c/2) = 0.100042 (c = 0.1; 6.67 ms at 15 rad/s) and noticed
for all of them between 2 asin(c/sqrt 2) and 2 pi less that. Both bounds are attained. So at one frequency no two
environments can have thresholds more than a factor 2 apart (sqrt 2, if one of them is a spring, a damper or a mass); Rank et
al. (2010) measured 15, 36 and 72 ms.

Assumptions. Linear; steady sinusoidal motion, x_h = x_e; m, b, k, tau > 0; 0 < c < 1, the same for both parts (eq. 4).
Delays on the force side and on the motion side add up.

Source. Eqs. (4), (9), (10) of W. Fu, M. M. van Paassen, M. Mulder, Framework for a Two-step Evaluation of Haptic Displays,
IFAC-PapersOnLine 52(19) 97-102, 2019, doi:10.1016/j.ifacol.2019.12.119. Measured thresholds: M. Rank, Z. Shi, H. J. Müller,
S. Hirche, The Influence of Different Haptic Environments on Time Delay Discrimination in Force Feedback, LNCS 6191, 2010,
doi:10.1007/978-3-642-14064-8_30 (abstract).

Run as ``python 02_delay_budget.py [directory]``; formulas and figure go to the directory, ``derived`` if none is given.
"""

# %%
import sys
from pathlib import Path

from sympy import (
    Expr,
    Function,
    I,
    Integer,
    Rational,
    Symbol,
    acos,
    asin,
    cos,
    diff,
    exp,
    expand,
    fraction,
    pi,
    sin,
    sqrt,
    symbols,
    tan,
    together,
)

m, b, k, tau, omega, c = symbols("m b k tau omega c", positive=True)
s, t, u, X = symbols("s t u X")
phi = Symbol("phi", real=True)


def is_zero(difference: Expr) -> bool:
    """Whether an expression is zero identically: waves as exponentials, over a common denominator, multiplied out."""
    return expand(fraction(together(difference.rewrite(exp)))[0]) == 0


# %% [markdown]
# ## 1. The delayed force
#
# The hand moves as $x = X e^{j\omega t}$. The environment answers with $f_e = m\ddot x + b\dot x + kx$, and the display
# passes it on late: $f_h(t) = f_e(t - \tau)$. What the hand feels is $H_{perc} = f_h/x$.

# %%
motion = X * exp(I * omega * t)
force = m * motion.diff(t, 2) + b * motion.diff(t) + k * motion
H = m * s**2 + b * s + k
G = exp(-s * tau)

assert is_zero(force / motion - H.subs(s, I * omega))
assert is_zero(force.subs(t, t - tau) / motion - (H * G).subs(s, I * omega))

# %% [markdown]
# The same for any force that starts at $t = 0$: in its Laplace integral put $t = u + \tau$, and what stands under the
# integral is $e^{-s\tau}$ times what it was.

# %%
f_e = Function("f_e")
late = (f_e(t - tau) * exp(-s * t)).subs(t, u + tau)
assert is_zero(late - G * f_e(u) * exp(-s * u))

dH = H * G - H  # eq. (9)
assert is_zero(dH - H * (exp(-s * tau) - 1))

# %% [markdown]
# ## 2. The arrow $G - 1$
#
# On the axis $G - 1 = e^{-j\omega\tau} - 1$: its parts are $\cos\omega\tau - 1$ and $-\sin\omega\tau$ (Euler), its length is
# $2\sin(\omega\tau/2)$, and it points in the direction $-(\pi + \omega\tau)/2$.

# %%
relative = (G - 1).subs(s, I * omega)
relative_real, relative_imag = cos(omega * tau) - 1, -sin(omega * tau)
length = 2 * sin(omega * tau / 2)

assert is_zero(relative - relative_real - I * relative_imag)
assert is_zero(relative - length * exp(-I * (pi + omega * tau) / 2))
assert is_zero(relative_real**2 + relative_imag**2 - length**2)

# %% [markdown]
# ## 3. A spring, a damper, a mass
#
# Each has its own direction: $H/|H| = 1$, $j$ and $-1$. Turned by it, the arrow's parts over $|H|$ are
#
# | | $\Re\Delta H/\lvert H\rvert$ | $\Im\Delta H/\lvert H\rvert$ | $r = \lvert\sin\omega\tau\rvert$ | $r = 1 - \cos\omega\tau$ |
# |---|---|---|---|---|
# | spring $k$ | $\cos\omega\tau - 1$ | $-\sin\omega\tau$ | $r_i$ | $r_r$ |
# | damper $bs$ | $\sin\omega\tau$ | $\cos\omega\tau - 1$ | $r_r$ | $r_i$ |
# | mass $ms^2$ | $1 - \cos\omega\tau$ | $\sin\omega\tau$ | $r_i$ | $r_r$ |

# %%
SPRING, DAMPER, MASS = {m: 0, b: 0}, {m: 0, k: 0}, {b: 0, k: 0}
modulus = {"spring": k, "damper": b * omega, "mass": m * omega**2}
elements = {
    "spring": (SPRING, relative_real, relative_imag),
    "damper": (DAMPER, -relative_imag, relative_real),
    "mass": (MASS, -relative_real, -relative_imag),
}
for name, (alone, real, imag) in elements.items():
    on_axis = dH.subs(alone).subs(s, I * omega)
    assert is_zero(on_axis - modulus[name] * (real + I * imag)), name

# %% [markdown]
# ## 4. When
#
# Write $x = \omega\tau$. For $0 < x < \pi/2$ the sine comes first, because $1 - \cos x = \tan(x/2)\sin x$ and there
# $\tan(x/2) < 1$: where $\sin x$ reaches $c$, the other ratio is still below it. So the bandwidth of a spring, of a damper
# and of a mass is the same, $\arcsin(c)/\tau$, and the other part follows at $\arccos(1 - c)/\tau$.

# %%
x = Symbol("x", positive=True)
assert is_zero((1 - cos(x)) * cos(x / 2) - sin(x) * sin(x / 2))
assert tan(x / 2).subs(x, pi / 2) == 1

first, second = asin(c), acos(1 - c)
assert sin(first) == c
assert 1 - cos(second) == c
other_at_first = (1 - cos(first)) ** 2 / sin(first) ** 2  # tan(asin(c)/2)^2
assert is_zero(other_at_first - (1 - sqrt(1 - c**2)) ** 2 / c**2)

bandwidth = first / tau

# %% [markdown]
# Beyond $\pi/2$ the sine falls again and the rest is symmetry: on $0 \le x \le 2\pi$, $|\sin x|$ exceeds $c$ from
# $\arcsin c$ to $\pi - \arcsin c$ and from $\pi + \arcsin c$ to $2\pi - \arcsin c$, and $1 - \cos x$ from $\arccos(1 - c)$
# to $2\pi - \arccos(1 - c)$. Together they leave only the two ends transparent.

# %%
sine_crossings = [first, pi - first, pi + first, 2 * pi - first]
cosine_crossings = [second, 2 * pi - second]
assert all(is_zero(sin(place) ** 2 - c**2) for place in sine_crossings)
assert all(is_zero(1 - cos(place) - c) for place in cosine_crossings)

# %% [markdown]
# ## 5. Any environment
#
# An environment of phase $\varphi$ at this frequency turns the arrow by $\varphi$:
# $\Delta H/|H| = e^{j\varphi}(G - 1) = 2\sin(x/2)\,(\sin(\varphi - x/2)\cdot 1 - \cos(\varphi - x/2)\cdot j)$. Turning does
# not change the length, so $r_r^2 + r_i^2 = (2\sin(x/2))^2$ whatever the environment, and the larger of the two lies
# between $2\sin(x/2)/\sqrt 2$ and $2\sin(x/2)$. Hence, for $c < \sqrt 2$:
#
# * unnoticed for *every* environment while $x \le 2\arcsin(c/2)$;
# * noticed for *every* environment while $2\arcsin(c/\sqrt 2) < x < 2\pi - 2\arcsin(c/\sqrt 2)$.

# %%
turned = exp(I * phi) * relative
turned_real, turned_imag = length * sin(phi - omega * tau / 2), -length * cos(phi - omega * tau / 2)
assert is_zero(turned - turned_real - I * turned_imag)
assert is_zero(turned_real**2 + turned_imag**2 - length**2)

never_before, always_after = 2 * asin(c / 2), 2 * asin(c / sqrt(2))
assert is_zero(2 * sin(never_before / 2) - c)
assert is_zero(2 * sin(always_after / 2) - sqrt(2) * c)

# %% [markdown]
# No better bound exists, since both are attained: the first by $\varphi = x/2$, where the arrow lies along the imaginary
# axis (a spring with a damper beside it, $b\omega/k = \tan(\omega\tau/2)$), the second by $\varphi = x/2 + \pi/4$, where
# both ratios are equal.

# %%
along = {phi: omega * tau / 2}
diagonal = {phi: omega * tau / 2 + pi / 4}
worst_damping = k * tan(omega * tau / 2) / omega
assert (turned_real.subs(along), turned_imag.subs(along)) == (0, -length)
assert turned_real.subs(diagonal) == -turned_imag.subs(diagonal) == length / sqrt(2)

# %% [markdown]
# With $c = 10$ %: $\omega\tau \le 0.100042$ for any environment, $0.100167$ for a spring, a damper or a mass; and nobody is
# spared from $0.141539$ on. At 15 rad/s, the end of the paper's band, these are 6.67, 6.68 and 9.44 ms.


# %%
def rounded(value: Expr, digits: int) -> str:
    """A number to so many significant digits."""
    return str(value.evalf(digits))


TEN_PERCENT = {c: Rational("0.1")}
budgets = [form.subs(TEN_PERCENT) for form in (never_before, first, always_after)]
assert [rounded(budget, 6) for budget in budgets] == ["0.100042", "0.100167", "0.141539"]
assert [rounded(1000 * budget / 15, 3) for budget in budgets] == ["6.67", "6.68", "9.44"]

# %% [markdown]
# In between, every phase has its own threshold, in closed form. The delay turns the environment's arrow $e^{j\varphi}$ back
# by $x$, and what counts is by how much its shadow on either axis has moved: $r_i = |\sin\varphi - \sin(\varphi - x)|$ and
# $r_r = |\cos(\varphi - x) - \cos\varphi|$. For $0 \le \varphi \le \pi/2$ the sine falls at once, and the cosine grows
# until the arrow lies on the axis and falls from there on.

# %%
delayed_sine, delayed_cosine = sin(phi - omega * tau), cos(phi - omega * tau)
assert is_zero(turned_imag - (delayed_sine - sin(phi)))
assert is_zero(turned_real - (delayed_cosine - cos(phi)))

threshold_imag = phi - asin(sin(phi) - c)
threshold_real_before_axis = phi - acos(cos(phi) + c)  # while cos(phi) + c <= 1
threshold_real_behind_axis = phi + acos(cos(phi) - c)
x_of = {omega: x / tau}
for threshold, form, moved in [
    (threshold_imag, delayed_sine - sin(phi), -c),
    (threshold_real_before_axis, delayed_cosine - cos(phi), c),
    (threshold_real_behind_axis, delayed_cosine - cos(phi), -c),
]:
    assert form.subs(x_of).subs(x, threshold) - moved == 0

assert threshold_imag.subs(phi, 0) == first  # the spring
assert threshold_real_behind_axis.subs(phi, 0) == second
assert is_zero(threshold_real_before_axis.subs(phi, pi / 2) - (pi / 2 - acos(c)))  # the damper: asin(c)
assert is_zero(sin(pi / 2 - acos(c)) - c)

# %% [markdown]
# ## 6. What Rank et al. measured
#
# Delay was noticed from 15 ms with a damper, 36 ms with a spring and 72 ms with a damped inertia, $ms^2 + bs$. The model
# says: from $\omega\tau = \arcsin c$ with the first two, and with any environment whatever from at most
# $2\arcsin(c/\sqrt 2)$. Both depend on $\omega\tau$ and $c$ alone. So, at one frequency of movement, whatever it was and
# whatever $c$ is:
#
# * damper and spring have the *same* threshold; measured: a factor 2.4;
# * a damped inertia has one at most $\sqrt 2$ times as large, since $\arcsin(y)/y$ grows: $2\arcsin(c/\sqrt 2) \le
#   \sqrt 2\arcsin c$; measured: a factor 2 to the spring and 4.8 to the damper;
# * any two environments have thresholds within a factor 2, since $\sin 2\theta \ge \sqrt 2\sin\theta$ up to $\theta = \pi/4$:
#   $2\arcsin(c/\sqrt 2) \le 2 \cdot 2\arcsin(c/2)$ for $c \le \sqrt 2$.
#
# No single $c$ explains even two of the three. Nor do two explain them all: with $c_r = \sin(15\,\mathrm{ms}\,\omega)$ for
# the damper and $c_i = \sin(36\,\mathrm{ms}\,\omega)$ for the spring, the arrow of 72 ms has the length
# $2\sin(36\,\mathrm{ms}\,\omega) = 2c_i$, but the longest that fits unnoticed is $\sqrt{c_r^2 + c_i^2} < \sqrt 2\,c_i$.
# (That is for movements below 6.9 Hz, where these sines still grow.) Movements of different frequency could: 2.4 times as
# fast with the damper as with the spring. So the budget says what a person who notices $c$ does not notice for certain; it
# does not predict when delay is noticed.

# %%
y, theta = symbols("y theta", positive=True)
grows = expand(diff(asin(y) / y, y) * y**2)  # has the sign of the slope of asin(y)/y
assert grows.subs(y, 0) == 0
assert is_zero(diff(grows, y) - y**2 / (1 - y**2) ** Rational(3, 2))  # positive for 0 < y < 1, hence so is grows
assert is_zero(sin(2 * theta) - sqrt(2) * sin(theta) * sqrt(2) * cos(theta))
assert sqrt(2) * cos(pi / 4) == 1  # and cos falls on 0 < theta < pi/4

measured = {"damper": 15, "spring": 36, "damped inertia": 72}
assert Rational(measured["spring"], measured["damper"]) == Rational("2.4")
assert Rational(measured["damped inertia"], measured["spring"]) == 2 > sqrt(2)
assert Rational(measured["damped inertia"], measured["damper"]) == Rational("4.8") > 2
late_spring, late_inertia = (omega * Rational(measured[name], 1000) for name in ("spring", "damped inertia"))
assert is_zero(length.subs(tau, late_inertia / omega) - 2 * sin(late_spring))

# %% [markdown]
# As an illustration, at 1 Hz (their frequency is not in the abstract) the three thresholds would need $c$ = 9 %, 22 % and a
# value between 32 and 45 %.

# %%
turn = {name: 2 * pi * Rational(value, 1000) for name, value in measured.items()}
needed = [sin(turn["damper"]), sin(turn["spring"])]
needed += [share * sin(turn["damped inertia"] / 2) for share in (sqrt(2), 2)]
assert [round(100 * value) for value in needed] == [9, 22, 32, 45]

# %% [markdown]
# ## 7. How
#
# $\Im H_{perc}$ is $-k\sin x$, $b\omega\cos x$ and $m\omega^2\sin x$. So behind a delay a spring is *active at once*, up to
# $x = \pi$: it hands out energy, which the paper's eq. (6) excludes. A damper is so from $x = \pi/2$ on, a mass from $\pi$.
# The spring turns into "inertia" at $x = \pi/2$, where $\Re H_{perc} = k\cos x$ changes its sign.

# %%
changeover = pi / (2 * tau)
felt = {name: (H * G).subs(alone).subs(s, I * omega) for name, (alone, _, _) in elements.items()}
assert is_zero(felt["spring"] - k * (cos(omega * tau) - I * sin(omega * tau)))
assert is_zero(felt["damper"] - b * omega * (sin(omega * tau) + I * cos(omega * tau)))
assert is_zero(felt["mass"] - m * omega**2 * (-cos(omega * tau) + I * sin(omega * tau)))
assert cos(omega * tau).subs(omega, changeover) == 0

# %% [markdown]
# ## 8. The package says the same
#
# Each closed form minus the one derived above is exactly zero. Of ratios the squares are compared: both sides are positive.

# %%
import haptisym as hs

E = hs.environments
delay = hs.effects.delay(tau)
d = hs.distort(E.mass_spring_damper(m, b, k), delay)
assert is_zero(d.environment - H)
assert is_zero(d.perceived - H * G)
assert is_zero(d.distortion - dH)
assert is_zero(d.relative_real - relative_real)
assert is_zero(d.relative_imag - relative_imag)
assert is_zero(d.ratio_real**2 + d.ratio_imag**2 - length**2)

for name, (alone, real, imag) in elements.items():
    kept = {str(p): p for p in (m, b, k) if p not in alone}
    pure = hs.distort(E.mass_spring_damper(**kept), delay)
    perceived = pure.perceived_properties
    assert is_zero(pure.real - modulus[name] * real), name
    assert is_zero(pure.imag - modulus[name] * imag), name
    assert is_zero(pure.ratio_real**2 - real**2), name
    assert is_zero(pure.ratio_imag**2 - imag**2), name
    assert is_zero(perceived.real + I * perceived.imag - felt[name]), name
assert hs.distort(E.mass_spring_damper(k=k), delay).changeover_perceived == changeover

voigt = hs.distort(E.kelvin_voigt(k, b), delay)
assert is_zero((voigt.ratio_imag**2).subs(b, worst_damping) - length**2)
assert is_zero(voigt.real.subs(b, worst_damping))

# %% [markdown]
# And an evaluation with numbers finds these crossings and no others, to 40 digits, over a whole turn
# $0 \le \omega\tau \le 2\pi$.

# %%
from haptisym import CrossingKind, Part

DELAY = Rational("0.036")
WHOLE_TURN = (Integer(0), 2 * pi / DELAY)
EXCEEDS, RETURNS = CrossingKind.EXCEEDS, CrossingKind.RETURNS


def at(place: Expr) -> str:
    """The frequency at which omega tau has a value, to 40 digits."""
    return rounded((place / DELAY).subs(TEN_PERCENT), 40)


def expected(form: Expr, part: Part) -> list[tuple[Part, CrossingKind, int, str]]:
    """The crossings of a part that is plus or minus a sine, or plus or minus one minus a cosine."""
    places = sine_crossings if form.has(sin) else cosine_crossings
    values = [form.subs(x_of).subs(x, place).subs(TEN_PERCENT) for place in places]
    signs = [1 if value.evalf() > 0 else -1 for value in values]
    kinds = [EXCEEDS, RETURNS] * 2
    return [(part, *each) for each in zip(kinds, signs, map(at, places), strict=False)]


active = {"spring": (Integer(0), pi), "damper": (pi / 2, 3 * pi / 2), "mass": (pi, 2 * pi)}
for name, environment in {
    "spring": E.mass_spring_damper(k=100),
    "damper": E.mass_spring_damper(b=5),
    "mass": E.mass_spring_damper(m=2),
}.items():
    result = hs.evaluate(hs.Scene(environment, (hs.effects.delay(DELAY),), WHOLE_TURN), digits=40)
    _, real, imag = elements[name]
    found = [(x.part, x.kind, x.sign, x.omega.digits(40)) for x in result.crossings]
    assert found == sorted(expected(real, Part.REAL) + expected(imag, Part.IMAG), key=lambda row: float(row[-1])), name
    assert all(x.multiplicity == 1 for x in result.crossings)
    assert result.bandwidth.digits(40) == rounded(bandwidth.subs({tau: DELAY, **TEN_PERCENT}), 40)
    ends = [(x.low.omega.digits(40), x.high.omega.digits(40)) for x in result.transparent]
    assert ends == [("0", at(first)), (at(2 * pi - first), at(2 * pi))], name
    [outside] = result.outside_model
    assert [x.omega.digits(40) for x in (outside.low, outside.high)] == [at(place) for place in active[name]], name
    assert result.certified

# %% [markdown]
# So are the thresholds for an environment of constant phase in between: a spring-pot $s^{1/2}$, with $\varphi = \pi/4$.

# %%
pot = hs.evaluate(hs.Scene(E.spring_pot(100, "1/2"), (hs.effects.delay(DELAY),), (Integer(0), Integer(20))), digits=40)
assert [(x.part, x.omega.digits(40)) for x in pot.crossings] == [
    (Part.IMAG, at(threshold_imag.subs(phi, pi / 4))),
    (Part.REAL, at(threshold_real_before_axis.subs(phi, pi / 4))),
]

# %% [markdown]
# ## 9. Formulas and figure

# %%
from matplotlib.figure import Figure
from numpy import arccos, arcsin, linspace, where
from numpy import cos as wave_cos
from numpy import pi as half_turn
from numpy import sin as wave_sin

from haptisym import latex

output = Path(next((given for given in sys.argv[1:2] if not given.startswith("-")), "derived"))
output.mkdir(parents=True, exist_ok=True)

formulas = {
    r"\Delta H(s)": H * (G - 1),
    r"\Re\frac{\Delta H}{H_{env}}": relative_real,
    r"\Im\frac{\Delta H}{H_{env}}": relative_imag,
    r"\sqrt{r_r^2 + r_i^2}": length,
    r"\omega_1": bandwidth,
    r"\omega_2": second / tau,
    r"\omega_{any}": never_before / tau,
    r"\omega_{all}": always_after / tau,
    r"\omega_i(\varphi)": threshold_imag / tau,
}
formulas_tex = [f"{name} &= {latex(form)}" for name, form in formulas.items()]
(output / "02_delay_budget.tex").write_text(
    "\\begin{align}\n" + " \\\\\n".join(formulas_tex) + "\n\\end{align}\n", encoding="utf-8"
)

# %% [markdown]
# Left, the two curves that a spring, a damper and a mass share. Right, the threshold of any environment by its phase
# (repeating every half turn), for $c$ = 10 %: spring and mass at the ends, the damper in the middle, between the two
# bounds.

# %%
figure = Figure(figsize=(7.0, 2.9), layout="constrained")
shared, phases = figure.subplots(1, 2)
turns = linspace(0, 2 * half_turn, 601)
shared.plot(turns, abs(wave_sin(turns)), "-k", lw=1.2, label=r"$|\sin\omega\tau|$")
shared.plot(turns, 1 - wave_cos(turns), "--k", lw=1.2, label=r"$1 - \cos\omega\tau$")
shared.axhline(0.1, color="0.3", lw=0.8, ls=":")
for low, high in ((0, float(budgets[1])), (2 * half_turn - float(budgets[1]), 2 * half_turn)):
    shared.axvspan(low, high, color="0.8", lw=0)
shared.set(xlim=(0, 2 * half_turn), ylim=(0, 2.1), xlabel=r"$\omega\tau$ (rad)", ylabel="distortion ratio")
shared.legend(loc="upper right", frameon=False, fontsize=8)

quarter = linspace(0, half_turn / 2, 601)
imag_first = quarter - arcsin(wave_sin(quarter) - 0.1)
near_axis = wave_cos(quarter) + 0.1 > 1
before_axis = quarter - arccos(where(near_axis, 1, wave_cos(quarter) + 0.1))
real_first = where(near_axis, quarter + arccos(wave_cos(quarter) - 0.1), before_axis)
for shown, form, label in ((imag_first, "-k", "$r_i = c$"), (real_first, "--k", "$r_r = c$")):
    phases.plot(180 / half_turn * quarter, shown, form, lw=1.2, label=label)
    mirrored = real_first if shown is imag_first else imag_first
    phases.plot(90 + 180 / half_turn * quarter, mirrored, form, lw=1.2)
for budget in budgets:
    phases.axhline(float(budget), color="0.3", lw=0.8, ls=":")
phases.set(xlim=(0, 180), ylim=(0.08, 0.2), xticks=[0, 45, 90, 135, 180])
phases.set(xlabel="phase of the environment (degrees)", ylabel=r"threshold $\omega\tau$ (rad)")
phases.legend(loc="upper center", frameon=False, fontsize=8)
figure.savefig(output / "02_delay_budget.pdf", metadata={"CreationDate": None})
