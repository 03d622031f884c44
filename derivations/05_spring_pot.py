r"""Tissue of constant phase: from the fractional derivative to H = k_alpha s^alpha, and its thresholds behind a lag.

Claim. A force proportional to the fractional derivative of order alpha (0 < alpha < 1) of the motion is the dynamics
H = k_alpha s^alpha; on the axis k_alpha omega^alpha (cos phi + j sin phi) with phi = alpha pi/2 at every frequency. Behind a
first-order lag omega_c, with y = omega/omega_c,

    r_r = y |y cos phi - sin phi|/(1 + y^2),    r_i = y (y sin phi + cos phi)/(1 + y^2),

without k_alpha, and each meets its threshold c where a quadratic in y vanishes:

    r_i = c:  (sin phi - c) y^2 + cos phi y - c = 0,
    r_r = c:  (cos phi - c) y^2 - sin phi y - c = 0    or    (cos phi + c) y^2 - sin phi y + c = 0.

Below y = tan phi more stiffness is felt than there is, above less; and above it the display is active. For alpha = 2/3 and
c = 1/4 the ratio r_r touches c at y = 1/sqrt 3 without exceeding it.

Assumptions. Linear, k_alpha, omega_c > 0, 0 < alpha < 1; steady sinusoidal motion (the derivative is taken over all the past);
x_h = x_e; 0 < c < 1, the same for both parts. Nothing beside the spring-pot: with a spring k in parallel the phase changes.

Source. The spring-pot (named by G. W. Scott Blair, 1947; recalled), as used for organs by Mishra and Cleveland (2024),
doi:10.3389/fbioe.2024.1386955. Thresholds: eqs. (4), (9), (10) of Fu, van Paassen and Mulder (2019),
doi:10.1016/j.ifacol.2019.12.119.

Run as ``python 05_spring_pot.py [directory]``; formulas and figure go to the directory, ``derived`` if none is given.
"""

# %%
import sys
from decimal import Context
from pathlib import Path

from sympy import (
    Expr,
    I,
    Integer,
    Rational,
    Symbol,
    cos,
    discriminant,
    exp,
    expand,
    fraction,
    gamma,
    gammasimp,
    laplace_transform,
    mellin_transform,
    pi,
    sin,
    sqrt,
    symbols,
    tan,
    together,
)

k_alpha, alpha, omega, omega_c, c = symbols("k_alpha alpha omega omega_c c", positive=True)
s, t, v, X = symbols("s t v X")
phi = alpha * pi / 2


def is_zero(difference: Expr) -> bool:
    """Whether an expression is zero identically: waves as exponentials, over a common denominator, multiplied out."""
    return expand(fraction(together(difference.rewrite(exp)))[0]) == 0


# %% [markdown]
# ## 1. The fractional derivative of a sine
#
# Between the displacement (order 0: a spring) and the velocity (order 1: a damper) lies the derivative of order $\alpha$, a
# mean of all past velocities that forgets slowly:
# $D^\alpha x(t) = \frac{1}{\Gamma(1-\alpha)}\int_0^\infty \dot x(t - v)\,v^{-\alpha}\,dv$. For $x = X e^{j\omega t}$ the
# velocity $v$ ago was $j\omega x\,e^{-j\omega v}$, so that
#
# $\frac{D^\alpha x}{x} = \frac{j\omega}{\Gamma(1-\alpha)}\int_0^\infty v^{-\alpha}(\cos\omega v - j\sin\omega v)\,dv
#  = \frac{j\omega^\alpha}{\Gamma(1-\alpha)}\int_0^\infty u^{-\alpha}(\cos u - j\sin u)\,du, \quad u = \omega v$.
#
# The two integrals are Mellin transforms at $z = 1 - \alpha$: $\Gamma(z)\cos(\pi z/2)$ and $\Gamma(z)\sin(\pi z/2)$, valid
# for $0 < z < 1$.

# %%
motion = X * exp(I * omega * t)
assert is_zero(motion.diff(t).subs(t, t - v) / motion - I * omega * exp(-I * omega * v))

u, z = symbols("u z", positive=True)
for wave in (cos, sin):
    integral, (low, high), _ = mellin_transform(wave(u), u, z)
    assert low <= 0 < 1 <= high
    assert gammasimp(integral / (gamma(z) * wave(pi * z / 2))) == 1

z_here = {z: 1 - alpha}
derivative = I * omega**alpha * (cos(pi * z / 2) - I * sin(pi * z / 2)).subs(z_here)
on_axis = k_alpha * omega**alpha * (cos(phi) + I * sin(phi))
assert is_zero(k_alpha * derivative - on_axis)

# %% [markdown]
# So $(j\omega)^\alpha$ is meant with the phase $\alpha\pi/2$, at every frequency. The same from rest, by Laplace: the mean
# is a convolution of $\dot x$, that is $sX$, with $t^{-\alpha}/\Gamma(1-\alpha)$, that is $s^{\alpha-1}$.

# %%
rate, time = symbols("s t", positive=True)
memory, _, valid = laplace_transform(time**-alpha / gamma(1 - alpha), time, rate)
assert is_zero(rate * memory - rate**alpha)
assert valid == (alpha < 1)

H = k_alpha * s**alpha
assert is_zero(exp(alpha * I * pi / 2) - cos(phi) - I * sin(phi))  # s^alpha at s = j

# %% [markdown]
# Its parts keep their ratio, $\tan\varphi$: whoever moves it, fast or slow, feels the same mixture of spring and damper.

# %%
real_env, imag_env = k_alpha * omega**alpha * cos(phi), k_alpha * omega**alpha * sin(phi)
modulus = k_alpha * omega**alpha
assert is_zero(on_axis - real_env - I * imag_env)
assert is_zero(real_env**2 + imag_env**2 - modulus**2)
assert is_zero(imag_env / real_env - tan(phi))

# %% [markdown]
# ## 2. Behind a lag
#
# $G = \omega_c/(s + \omega_c)$, so $G - 1 = -jy/(1 + jy) = -(y^2 + jy)/(1 + y^2)$ with $y = \omega/\omega_c$; turned by
# $\varphi$:

# %%
G = omega_c / (s + omega_c)
y = Symbol("y", positive=True)
in_y = {omega: y * omega_c}
relative = (G - 1).subs(s, I * omega)
assert is_zero(relative.subs(in_y) + (y**2 + I * y) / (1 + y**2))

dH = H * G - H  # eq. (9)
turned_real = -y * (y * cos(phi) - sin(phi)) / (1 + y**2)
turned_imag = -y * (y * sin(phi) + cos(phi)) / (1 + y**2)
turned = exp(I * phi) * relative.subs(in_y)
assert is_zero(turned - turned_real - I * turned_imag)

real = -modulus * omega * (omega * cos(phi) - omega_c * sin(phi)) / (omega**2 + omega_c**2)
imag = -modulus * omega * (omega * sin(phi) + omega_c * cos(phi)) / (omega**2 + omega_c**2)
assert is_zero(on_axis * relative - real - I * imag)
assert is_zero(real.subs(in_y) - modulus.subs(in_y) * turned_real)
assert is_zero(imag.subs(in_y) - modulus.subs(in_y) * turned_imag)

# %% [markdown]
# ## 3. How
#
# $\Re\Delta H$ changes its sign at $y = \tan\varphi$: below, the lagging damper part helps the spring, and more stiffness
# is felt than there is. The perceived phase is $\varphi - \arctan y$: it runs out at the same $y$. There the tissue is felt
# as a spring without any damping, of just its own stiffness $\Re H_{env}$; beyond, $\Im H_{perc} < 0$ and the display is
# active. $\Re H_{perc}$ stays positive.

# %%
felt = exp(I * phi) * G.subs(s, I * omega).subs(in_y)
felt_real, felt_imag = (cos(phi) + y * sin(phi)) / (1 + y**2), (sin(phi) - y * cos(phi)) / (1 + y**2)
assert is_zero(felt - felt_real - I * felt_imag)

turn = {y: sin(phi) / cos(phi)}
assert is_zero(turned_real.subs(turn))
assert is_zero(felt_imag.subs(turn))
assert is_zero(felt_real.subs(turn) - cos(phi))

# %% [markdown]
# ## 4. When
#
# $r_i = c$ where $y^2\sin\varphi + y\cos\varphi = c(1 + y^2)$; and $r_r = c$ where
# $\pm(y^2\cos\varphi - y\sin\varphi) = c(1 + y^2)$. Three quadratics in $y$:

# %%
quadratic_imag = (sin(phi) - c) * y**2 + cos(phi) * y - c
quadratic_less = (cos(phi) - c) * y**2 - sin(phi) * y - c  # r_r where less stiffness is felt
quadratic_more = (cos(phi) + c) * y**2 - sin(phi) * y + c  # r_r where more stiffness is felt
assert is_zero(-turned_imag - c - quadratic_imag / (1 + y**2))
assert is_zero(-turned_real - c - quadratic_less / (1 + y**2))
assert is_zero(turned_real - c + quadratic_more / (1 + y**2))

# %% [markdown]
# Their roots, written so that none is a difference of large numbers. How many are positive is read off the signs of the
# coefficients (Descartes) and of the discriminant:
#
# * $r_i$: $y = 2c/(\cos\varphi \pm \sqrt{\cos^2\varphi + 4c(\sin\varphi - c)})$. One is positive if $\sin\varphi > c$; both
#   are if $\sin\varphi < c$ and the root is real, $\cos^2\varphi > 4c(c - \sin\varphi)$.
# * $r_r$, less: $y = (\sin\varphi + \sqrt{\sin^2\varphi + 4c(\cos\varphi - c)})/(2(\cos\varphi - c))$, if
#   $\cos\varphi > c$; else none.
# * $r_r$, more: $y = 2c/(\sin\varphi \pm \sqrt{\sin^2\varphi - 4c(\cos\varphi + c)})$: two if
#   $\sin^2\varphi > 4c(\cos\varphi + c)$; one, a touch, if equal.

# %%
root_imag = sqrt(cos(phi) ** 2 + 4 * c * (sin(phi) - c))
root_less = sqrt(sin(phi) ** 2 + 4 * c * (cos(phi) - c))
root_more = sqrt(sin(phi) ** 2 - 4 * c * (cos(phi) + c))
for quadratic, root in ((quadratic_imag, root_imag), (quadratic_less, root_less), (quadratic_more, root_more)):
    assert is_zero(discriminant(quadratic, y) - root**2)

imag_first, imag_last = (2 * c / (cos(phi) + sign * root_imag) for sign in (1, -1))
less = (sin(phi) + root_less) / (2 * (cos(phi) - c))
more_first, more_last = (2 * c / (sin(phi) + sign * root_more) for sign in (1, -1))
for quadratic, place in (
    (quadratic_imag, imag_first),
    (quadratic_imag, imag_last),
    (quadratic_less, less),
    (quadratic_more, more_first),
    (quadratic_more, more_last),
):
    assert is_zero(quadratic.subs(y, place))

# %% [markdown]
# For a spring ($\varphi = 0$) and a damper ($\varphi = \pi/2$) they become what a lag does to those: $y^2 = c/(1 - c)$ for
# the part in line with the element, and $y = c(1 + y^2)$ for the other. No phase has a crossing before
# $y = c/\sqrt{1 - c^2}$ (0.1005), where the whole relative distortion $y/\sqrt{1 + y^2}$ is $c$.

# %%
spring, damper = {alpha: 0}, {alpha: 1}
assert is_zero(less.subs(spring) ** 2 - c / (1 - c))
assert is_zero(quadratic_imag.subs(spring) - (y - c * (1 + y**2)))
assert is_zero(imag_first.subs(damper) ** 2 - c / (1 - c))
assert is_zero(quadratic_more.subs(damper) + (y - c * (1 + y**2)))
assert is_zero(turned_real**2 + turned_imag**2 - y**2 / (1 + y**2))
earliest = c / sqrt(1 - c**2)
assert is_zero((y**2 / (1 + y**2)).subs(y, earliest) - c**2)
assert str(earliest.subs(c, Rational("0.1")).evalf(4)) == "0.1005"

# %% [markdown]
# ## 5. A touch
#
# $\alpha = 2/3$ has $\varphi = 60°$, and $\sin^2\varphi = 4c(\cos\varphi + c)$ reads $4c^2 + 2c - 3/4 = 0$: $c = 1/4$.
# There $r_r$ rises to exactly 25 % at $y = 1/\sqrt 3$ and falls again: nothing is noticed.

# %%
touching = {alpha: Rational(2, 3), c: Rational(1, 4)}
assert root_more.subs(touching) == 0
assert more_first.subs(touching) == more_last.subs(touching) == 1 / sqrt(3)
assert expand(quadratic_more.subs(touching) - Rational(3, 4) * (y - 1 / sqrt(3)) ** 2) == 0

# %% [markdown]
# ## 6. The package says the same

# %%
import haptisym as hs

d = hs.distort(hs.environments.spring_pot(k_alpha, alpha), hs.effects.first_order_lag(omega_c))
env, perc = d.environment_properties, d.perceived_properties
back = {y: omega / omega_c}
for name, derived, packaged in [
    ("H_env", H, d.environment),
    ("H_perc", H * G, d.perceived),
    ("dH", dH, d.distortion),
    ("Re H_env", real_env, env.real),
    ("Im H_env", imag_env, env.imag),
    ("|H_env|", modulus, d.modulus),
    ("Re dH", real, d.real),
    ("Im dH", imag, d.imag),
    ("Re H_perc", modulus * felt_real.subs(back), perc.real),
    ("Im H_perc", modulus * felt_imag.subs(back), perc.imag),
    ("r_r^2", turned_real.subs(back) ** 2, d.ratio_real**2),
    ("r_i^2", turned_imag.subs(back) ** 2, d.ratio_imag**2),
    ("Re dH/H_env", -(omega**2) / (omega**2 + omega_c**2), d.relative_real),
    ("Im dH/H_env", -omega * omega_c / (omega**2 + omega_c**2), d.relative_imag),
]:
    assert is_zero(derived - packaged), name

# %% [markdown]
# Evaluations with numbers find the roots of the quadratics and nothing else, to 40 digits, for orders that cover these
# cases: two roots of $r_i$ ($\alpha = 1/20$), none of the "more" quadratic (1/4), two (1/2 and above), none of the "less"
# one in the end (19/20). And the display is active from $\omega_c\tan\varphi$ on.

# %%
from haptisym import CrossingKind, Part

CUTOFF, TOP = 20, 4000
EXCEEDS, RETURNS = CrossingKind.EXCEEDS, CrossingKind.RETURNS


def at(place: Expr, values: dict[Symbol, Expr]) -> str:
    """The frequency of a value of y, rounded to 40 digits from 60."""
    return f"{Context(prec=40).create_decimal(str((CUTOFF * place.subs(values)).evalf(60))):f}"


def expected(values: dict[Symbol, Expr]) -> list[tuple[str, Part, CrossingKind, int]]:
    """All crossings by section 4, in order."""
    phase, limit = phi.subs(values), values[c]
    rows = [(imag_first, Part.IMAG, EXCEEDS, -1)]
    if (sin(phase) - limit).is_negative:
        rows += [(imag_last, Part.IMAG, RETURNS, -1)]
    if (sin(phase) ** 2 - 4 * limit * (cos(phase) + limit)).is_positive:
        rows += [(more_first, Part.REAL, EXCEEDS, 1), (more_last, Part.REAL, RETURNS, 1)]
    if (cos(phase) - limit).is_positive:
        rows += [(less, Part.REAL, EXCEEDS, -1)]
    placed = [(at(place, values), *rest) for place, *rest in rows]
    return sorted(placed, key=lambda row: float(row[0]))


def evaluated(values: dict[Symbol, Expr]) -> hs.Evaluation:
    """The scene with numbers; the band ends high above the filter."""
    environment = hs.environments.spring_pot(100, values[alpha])
    lag = hs.effects.first_order_lag(CUTOFF)
    band = (Integer(0), Integer(TOP))
    return hs.evaluate(hs.Scene(environment, (lag,), band, hs.Threshold.of(values[c])), digits=40)


counts = {"1/20": 3, "1/4": 2, "1/2": 4, "2/3": 4, "9/10": 4, "19/20": 3}
for order, count in counts.items():
    values = {alpha: Rational(order), c: Rational("0.1")}
    result = evaluated(values)
    found = [(x.omega.digits(40), x.part, x.kind, x.sign) for x in result.crossings]
    assert found == expected(values), order
    assert len(found) == count
    assert result.certified
    [active] = result.outside_model
    assert active.low.omega.digits(40) == at(tan(phi), values)
    assert float(active.high.omega) == TOP
    print(f"alpha = {order:5}: {', '.join(f'{float(row[0]):.5g}' for row in found)} rad/s")

# %% [markdown]
# At the touch no crossing is claimed: the package says "touches", or that it could not tell, at that very frequency.

# %%
touch = evaluated(touching)
touches = [x.omega for x in touch.crossings if x.kind is CrossingKind.TOUCHES] + [x.omega for _, x in touch.undecided]
assert [x.digits(30) for x in touches] == [str((CUTOFF / sqrt(3)).evalf(30))]
assert [(x.omega.digits(40), x.part) for x in touch.crossings if x.kind is not CrossingKind.TOUCHES] == [
    (at(imag_first, touching), Part.IMAG),
    (at(less, touching), Part.REAL),
]

# %% [markdown]
# ## 7. Formulas and figure

# %%
from matplotlib.figure import Figure
from numpy import linspace, logspace, nan, where
from sympy import lambdify

from haptisym import latex

output = Path(next((given for given in sys.argv[1:2] if not given.startswith("-")), "derived"))
output.mkdir(parents=True, exist_ok=True)

formulas = {
    r"H_{env}(s)": H,
    r"\Re\,\Delta H": real,
    r"\Im\,\Delta H": imag,
    r"\frac{\omega_{i}}{\omega_c}": imag_first,
    r"\frac{\omega_{r,less}}{\omega_c}": less,
    r"\frac{\omega_{r,more}}{\omega_c}": more_first,
}
formulas_tex = [f"{name} &= {latex(form)}" for name, form in formulas.items()]
(output / "05_spring_pot.tex").write_text(
    "\\begin{align}\n" + " \\\\\n".join(formulas_tex) + "\n\\end{align}\n", encoding="utf-8"
)

# %% [markdown]
# Left, the ratio $r_r$ for four orders: a hump of more stiffness, then less. Right, all thresholds against the order, for
# $c$ = 10 %: solid those of $r_i$, which returns only for $\sin\varphi < c$; dashed those of $r_r$, within the nose more
# stiffness, above the line less.

# %%
figure = Figure(figsize=(7.0, 2.9), layout="constrained")
humps, thresholds = figure.subplots(1, 2)
places = logspace(-2, 2, 601)
ratio_real = lambdify((y, alpha), turned_real, "numpy")
for order, style in {0.25: ":", 0.5: "-.", 2 / 3: "--", 0.9: "-"}.items():
    humps.semilogx(places, abs(ratio_real(places, order)), style, color="k", lw=1.2, label=rf"$\alpha$ = {order:.2g}")
humps.axhline(0.1, color="0.3", lw=0.8, ls=":")
humps.set(xlim=(0.01, 100), ylim=(0, 1), xlabel=r"$\omega/\omega_c$", ylabel="$r_r$")
humps.legend(loc="upper left", frameon=False, fontsize=8)

orders = linspace(0.002, 0.998, 499)
for form, style in ((imag_first, "-"), (imag_last, "-"), (less, "--"), (more_first, "--"), (more_last, "--")):
    places = lambdify(alpha, form.subs(c, 0.1), "numpy")(orders.astype(complex))  # complex where there is no root
    shown = where((abs(places.imag) < 1e-9) & (places.real > 0), places.real, nan)
    thresholds.semilogy(orders, shown, style, color="k", lw=1)
thresholds.set(xlim=(0, 1), ylim=(0.05, 100), xlabel=r"order $\alpha$", ylabel=r"threshold $\omega/\omega_c$")
figure.savefig(output / "05_spring_pot.pdf", metadata={"CreationDate": None})
