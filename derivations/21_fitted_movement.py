r"""What a fit of stiffness, damping and mass to a movement reports: moments of its spectrum, in closed form.

Claim. A movement with the displacement spectrum S(omega) and the force H(j omega) that goes with it: least squares of the force
on position, velocity and acceleration have the normal equations

    k M_0 - m M_2 = int S Re H,   k M_2 - m M_4 = int S omega^2 Re H,   b M_2 = int S omega Im H,   M_n = int S omega^n,

so that only moments of S against Re H and Im H count. A mass-spring-damper is reported as it is, whatever the movement. On two
lines k and m are what Re H is on both. Where S is flat in displacement or velocity on a band, and H rational, the integrals are
logarithms at the poles of H. In the paper's example

    S flat from 0 to 15 rad/s                       k = 99.8347809537, b = 16.8292036316, m = 1.60570315029,
    velocity flat from 1 to 15 rad/s                k = 99.9639491593, b = 15.5758572891, m = 1.60745594847,
    S flat up to 7.978916790174708 rad/s            k = 99.9895907186, b = 14.6074571324, m = 1.61090746247;

in the last nothing is noticed at any one frequency, and still the fitted mass is 10.5 % low: a mass is seen by the part of
Re dH that grows with omega^2, while eq. (10) compares with all of |H_env|, most of it the spring's.

A spring K behind a delay tau, moved up to w, is reported, to the lowest order in w tau, with a damping of -K tau and a mass of
K tau^2/2.

Assumptions. Linear; H without a pole on the band. It is what such a fit reports, not what a person was shown to perceive.

Source of the example: W. Fu, M. M. van Paassen, M. Mulder, 2019, section 3. The fit is ordinary least squares; with Parseval's
theorem its sums over time are integrals over frequency.

Run as ``python 21_fitted_movement.py [directory]``; formulas and figure go to the directory, ``derived`` if none is given.
"""

# %%
import sys
from pathlib import Path

from matplotlib.figure import Figure
from sympy import (
    I,
    Integer,
    Poly,
    Rational,
    cancel,
    cos,
    diff,
    expand,
    integrate,
    latex,
    log,
    series,
    sin,
    solve,
    symbols,
)

import haptisym as hs
from haptisym.verbs.evaluate.movement import movement

k, b, m, omega, K, tau, w = symbols("k b m omega K tau w", positive=True)
names = ("k", "b", "m")


# %% [markdown]
# ## 1. The normal equations
#
# $E = \int S\,|H - (k - m\omega^2 + j b\omega)|^2\,d\omega$ is quadratic in $k$, $b$, $m$. With numbers for the moments of $S$
# against $\mathrm{Re}\,H = X$ and $\mathrm{Im}\,H = Y$ it is a polynomial, whose derivatives vanish at the fit.

# %%
M0, M2, M4, X0, X2, Y1, rest = symbols("M_0 M_2 M_4 X_0 X_2 Y_1 E_0", positive=True)
E = rest - 2 * (k * X0 - m * X2 + b * Y1) + k**2 * M0 - 2 * k * m * M2 + m**2 * M4 + b**2 * M2
fit = solve([diff(E, x) for x in (k, b, m)], [k, b, m], dict=True)[0]
below = M0 * M4 - M2**2
assert cancel(fit[k] - (X0 * M4 - M2 * X2) / below) == 0
assert cancel(fit[b] - Y1 / M2) == 0
assert cancel(fit[m] - (M2 * X0 - M0 * X2) / below) == 0


def fitted(moments, real, imag):
    """k, b and m of moments."""
    at = dict(zip((M0, M2, M4, X0, X2, Y1), (*moments, *real, imag), strict=True))
    return {name: fit[x].subs(at) for name, x in zip(names, (k, b, m), strict=True)}


# %% [markdown]
# A mass-spring-damper is reported as it is: $X_n = k M_n - m M_{n+2}$, $Y_1 = b M_2$.

# %%
own = fitted((M0, M2, M4), (k * M0 - m * M2, k * M2 - m * M4), b * M2)
assert all(cancel(own[x.name] - x) == 0 for x in (k, b, m))

# %% [markdown]
# On two lines, with whatever weights $p$ and $q$, $k - m\omega^2$ is $\mathrm{Re}\,H$ on both.

# %%
p, q, u, v, X_u, X_v = symbols("p q u v X_u X_v", positive=True)
two = fitted(
    (p + q, p * u**2 + q * v**2, p * u**4 + q * v**4), (p * X_u + q * X_v, p * u**2 * X_u + q * v**2 * X_v), Integer(0)
)
assert all(cancel(two["k"] - two["m"] * x**2 - seen) == 0 for x, seen in ((u, X_u), (v, X_v)))

# %% [markdown]
# ## 2. A flat band, in closed form
#
# $H_{perc} = H_{env}\,\omega_n^2/(s^2 + 2\zeta\omega_n s + \omega_n^2)$ with $s = j\omega$: a constant and a term for each pole
# $s_i$. The moments need $\int\omega^n H(j\omega)\,d\omega$, of which each term is a polynomial and a logarithm:
# $\int \frac{\omega^n\,d\omega}{j\omega - s_i}$ follows from $\omega^n = (\omega^n - z_i^n) + z_i^n$, $z_i = -j s_i$.

# %%
s = symbols("s")
wn, zeta = Integer(80), Rational(1, 2)
above = Poly(wn**2 * (Rational(9, 5) * s**2 + 15 * s + 100), s)
beneath = Poly(s**2 + 2 * zeta * wn * s + wn**2, s)
constant, remainder = above.div(beneath)
poles = solve(beneath.as_expr(), s)
residues = [remainder.as_expr().subs(s, x) / beneath.diff(s).as_expr().subs(s, x) for x in poles]


def divided(n, z):
    """(omega^n - z^n)/(omega - z) written out; n may be below 0."""
    return sum(z ** (n - 1 - i) * omega**i for i in range(n)) - sum(z ** (n - 1 - i) * omega**i for i in range(n, 0))


def moment(n, low, high):
    """The integral of omega^n H_perc(j omega) over a band, exact."""
    total = constant.as_expr() * integrate(omega**n, (omega, low, high))
    for pole, residue in zip(poles, residues, strict=True):
        z, of_pole = -I * pole, log(I * high - pole) - log(I * low - pole)
        total += residue / I * (integrate(divided(n, z), (omega, low, high)) + z**n * of_pole)
    return total


z_i = symbols("z_i")
assert all(expand(divided(n, z_i) * (omega - z_i) + z_i**n - omega**n) == 0 for n in range(-2, 3))
response = constant.as_expr() + sum(c / (s - x) for c, x in zip(residues, poles, strict=True))
assert cancel(response - above.as_expr() / beneath.as_expr()) == 0


def flat(low, high, weight):
    """What is reported where S = omega^weight on a band, to 25 digits."""
    moments = [integrate(omega ** (n + weight), (omega, low, high)) for n in (0, 2, 4)]
    values = [moment(n + weight, low, high).evalf(30) for n in (0, 2, 1)]
    return fitted(moments, (values[0].as_real_imag()[0], values[1].as_real_imag()[0]), values[2].as_real_imag()[1])


# %% [markdown]
# ## 3. The paper's example
#
# All digits of the claim, and the package's.

# %%
paper = hs.load_scene("fu2019")
end = hs.evaluate(paper).bandwidth.digits(16)
assert end == "7.978916790174708"
claims = {
    "0:15": (flat(Integer(0), Integer(15), 0), ("99.8347809537", "16.8292036316", "1.60570315029")),
    "velocity:1:15": (flat(Integer(1), Integer(15), -2), ("99.9639491593", "15.5758572891", "1.60745594847")),
    f"0:{end}": (flat(Integer(0), Rational(end), 0), ("99.9895907186", "14.6074571324", "1.61090746247")),
}
for text, (exact, printed) in claims.items():
    package = movement(paper, text)
    assert package.environment == {"k": 100.0, "b": 15.0, "m": 1.8}
    for name, digits in zip(names, printed, strict=True):
        assert str(exact[name].evalf(12)) == digits
        assert float(exact[name]) == package.perceived[name]
inside = movement(paper, f"0:{end}")
assert hs.evaluate(paper, movement="0:7.9").bandwidth == hs.evaluate(paper).bandwidth
assert abs(inside.change["m"] + Rational("0.105")) < 1e-3  # although nothing is noticed frequency by frequency

# %% [markdown]
# ## 4. A spring that comes late
#
# $H = K e^{-j\omega\tau}$ up to $w$: $\mathrm{Re}\,H = K\cos\omega\tau$, $\mathrm{Im}\,H = -K\sin\omega\tau$.

# %%
real = [integrate(omega**n * K * cos(omega * tau), (omega, 0, w)) for n in (0, 2)]
imag = integrate(-omega * K * sin(omega * tau), (omega, 0, w))
late = fitted([w ** (n + 1) / (n + 1) for n in (0, 2, 4)], real, imag)
assert expand(series(late["b"], tau, 0, 2).removeO() + K * tau) == 0
assert expand(series(late["m"], tau, 0, 3).removeO() - K * tau**2 / 2) == 0
assert expand(series(late["k"], tau, 0, 4).removeO() - K) == 0  # the first term of k is of fourth order
spring = hs.Scene(hs.environments.mass_spring_damper(k=100), (hs.effects.delay("36 ms"),), (0, 15))
at = {K: 100, tau: Rational(36, 1000), w: 15}
package = movement(spring, "0:15").perceived
assert all(float(late[name].subs(at).evalf(30)) == package[name] for name in names)

# %%
output = Path(sys.argv[1] if len(sys.argv) > 1 else "derived")
output.mkdir(parents=True, exist_ok=True)
formulas = {"k": fit[k], "b": fit[b], "m": fit[m], r"b_{K,\tau}": late["b"], r"m_{K,\tau}": late["m"].factor()}
(output / "21_fitted_movement.tex").write_text(
    "\\begin{align}\n"
    + " \\\\\n".join(f"{name} &= {latex(form)}" for name, form in formulas.items())
    + "\n\\end{align}\n",
    encoding="utf-8",
)

# %% [markdown]
# What is reported of the paper's display over the end of a flat band, relative to what should be felt; up to the line nothing
# is noticed at any one frequency.

# %%
figure = Figure(figsize=(3.5, 2.6), layout="constrained")
axes = figure.subplots()
ends = [0.5 * n for n in range(1, 31)]
changes = [movement(paper, f"0:{x}").change for x in ends]
for name, label, style in (("k", "stiffness", "-"), ("b", "damping", "--"), ("m", "mass", "-.")):
    axes.plot(ends, [100 * x[name] for x in changes], style, color="k", linewidth=1, label=label)
axes.axvline(float(end), color="0.5", linewidth=0.8)
axes.set(xlim=(0, 15), xlabel="end of the band (rad/s)", ylabel="change of the fit (%)")
axes.legend(fontsize=8, frameon=False)
figure.savefig(output / "21_fitted_movement.pdf", metadata={"CreationDate": None})
