r"""Which damping of the paper's filter goes unnoticed furthest up, and why the best one lies where two criteria meet.

Claim. In the paper's example (m = 1.8 kg, b = 15 N s/m, k = 100 N/m behind a second-order low-pass of 80 rad/s) the bandwidth
is largest where the real and the imaginary part reach their threshold at one frequency,

    Re dH = -c |H_env|,    Im dH = c |H_env|,

two equations in omega and zeta. The sum of their squares, |G - 1|^2 = 2 c^2, gives zeta^2 as a quotient of polynomials in
omega^2; their sum, Re dH + Im dH = 0, gives zeta. What is left is one polynomial in omega, and the best of its roots is

    omega = 27.1337522921323016... rad/s,    zeta = 0.0734002886766650244...,

3.4 times the bandwidth with the paper's zeta = 0.5. With a little more damping the imaginary part is noticed first, with less
the real one: the maximum is a corner, and is missed on both sides at first order. The display is passive from zeta = 5/96 on.

Assumptions. c = 10 % for both parts, on a band from 0 to 60 rad/s.

Source of the example: W. Fu, M. M. van Paassen, M. Mulder, 2019, section 3.

Run as ``python 20_best_damping.py [directory]``; formulas and figure go to the directory, ``derived`` if none is given.
"""

# %%
import sys
from dataclasses import replace
from pathlib import Path

from matplotlib.figure import Figure
from numpy import linspace
from sympy import I, Integer, Poly, Rational, cancel, diff, expand, fraction, im, latex, re, sqrt, symbols, together

import haptisym as hs

m, b, k, wn, c = Rational(9, 5), Integer(15), Integer(100), Integer(80), Rational(1, 10)
omega, zeta = symbols("omega zeta", positive=True)
s = I * omega


def is_zero(difference):
    """Whether an expression is zero identically."""
    return expand(fraction(together(difference))[0]) == 0


# %% [markdown]
# ## 1. Two equations
#
# $\Delta H = H_{env}(G - 1)$, $G - 1 = -(s^2 + 2\zeta\omega_n s)/D$, $D = s^2 + 2\zeta\omega_n s + \omega_n^2$.

# %%
H = m * s**2 + b * s + k
D = s**2 + 2 * zeta * wn * s + wn**2
change = expand(-H * (s**2 + 2 * zeta * wn * s))
turned = expand(change * D.subs(I, -I))  # over |D|^2
real, imag = re(turned), im(turned)
size = expand(D * D.subs(I, -I)), expand(H * H.subs(I, -I))
assert is_zero(real + I * imag - turned)

paper = hs.load_scene("fu2019")
d = hs.distort(paper.environment, hs.effects.second_order_lowpass(wn, zeta))
assert is_zero(d.real.subs(hs.omega, omega) - real / size[0])
assert is_zero(d.imag.subs(hs.omega, omega) - imag / size[0])

# %% [markdown]
# ## 2. What is left of them
#
# The sum of the squares has no environment in it, and is linear in $Z = (2\zeta\omega_n)^2$.

# %%
Z = symbols("Z", positive=True)
squares = expand(real**2 + imag**2 - 2 * c**2 * size[0] ** 2 * size[1])
over = cancel(squares / (size[0] * size[1]))  # |G - 1|^2 - 2 c^2
linear = Poly(expand(fraction(together(over))[0]).subs(zeta**2, Z / (4 * wn**2)), Z)
assert linear.degree() == 1
Z_of = cancel(-linear.coeff_monomial(1) / linear.coeff_monomial(Z))
assert is_zero(Z_of - (2 * c**2 * (wn**2 - omega**2) ** 2 - omega**4) / (omega**2 * (1 - 2 * c**2)))

# %% [markdown]
# $\mathrm{Re}\,\Delta H + \mathrm{Im}\,\Delta H = 0$ has $\zeta$ and $\zeta^2$ in it, the latter
# known: it gives $\zeta$, and $\zeta^2$ once more, which must be the same.

# %%
balance = Poly(expand(real + imag), zeta)
assert balance.degree() == 2
rest = balance.coeff_monomial(1) + balance.coeff_monomial(zeta**2) * Z_of / (4 * wn**2)
zeta_of = cancel(-rest / balance.coeff_monomial(zeta))
left = Poly(fraction(together(4 * wn**2 * zeta_of**2 - Z_of))[0], omega)
factors = [(f, n) for f, n in left.factor_list()[1] if f.degree() > 1]

# %% [markdown]
# ## 3. Its roots
#
# Isolated by exact root counting. Each of those at which $\zeta > 0$, and the signs are those of the claim, is a meeting of
# both thresholds.

# %%
meetings = []
for factor, _ in factors:
    for (low, high), _ in factor.intervals(eps=Rational(1, 10**24)):
        if low > 0 and zeta_of.subs(omega, low) > 0 and Z_of.subs(omega, low) > 0:
            meetings.append(((low + high) / 2, factor))
found, factor = min(meetings, key=lambda x: abs(x[0] - 27))
best = zeta_of.subs(omega, found)
assert str(found.evalf(18)) == "27.1337522921323016"
assert str(best.evalf(18)) == "0.0734002886766650244"
at = {omega: found, zeta: best}
assert abs((real / size[0] + c * sqrt(size[1])).subs(at).evalf(30)) < 1e-18
assert abs((imag / size[0] - c * sqrt(size[1])).subs(at).evalf(30)) < 1e-18

# %% [markdown]
# ## 4. A corner
#
# How each threshold moves with $\zeta$ follows from $F = r^2 - c^2$ by implicit differentiation: one frequency
# falls and the other one rises.

# %%
slopes = {}
for name, part in (("r_r", real), ("r_i", imag)):
    F = part**2 - c**2 * size[0] ** 2 * size[1]
    slopes[name] = (-diff(F, zeta) / diff(F, omega)).subs(at).evalf(12)
assert slopes["r_i"] < 0 < slopes["r_r"]

# %% [markdown]
# ## 5. The package finds it
#
# `design` proves that no other damping does better; exact evaluations on either side show the corner.

# %%
scene = replace(paper, band=(Integer(0), Integer(60)))
answer = hs.design(scene, {"zeta": (0.01, 1)}, gap="1e-6")
assert answer.certified
assert answer.bandwidth[0] <= found.evalf(20) * (1 + Rational(1, 10**15))
assert answer.bandwidth[1] >= found.evalf(20)
[[(low, high)]] = answer.clusters
assert low <= best <= high
assert {x.criterion.symbol for x in answer.binding} == {"r_r", "r_i"}
for share, first in ((Rational(101, 100), "imag"), (Rational(99, 100), "real")):
    there = hs.evaluate(scene.with_values({"effects.filter.zeta": Rational(str(best.evalf(20))) * share}))
    assert there.crossings[0].criterion.name == first
    assert float(there.bandwidth) < answer.bandwidth[0]
passive = hs.require(scene, "zeta", (0.01, 1), that="passive").feasible[0].low
assert passive.digits(12) == str(Rational(5, 96).evalf(12))
assert best > Rational(5, 96)

# %%
output = Path(sys.argv[1] if len(sys.argv) > 1 else "derived")
output.mkdir(parents=True, exist_ok=True)
formulas = {r"(2\zeta\omega_n)^2": Z_of, "0": factor.as_expr()}
(output / "20_best_damping.tex").write_text(
    "\\begin{align}\n"
    + " \\\\\n".join(f"{name} &= {latex(form)}" for name, form in formulas.items())
    + "\n\\end{align}\n",
    encoding="utf-8",
)

# %% [markdown]
# The bandwidth over $\zeta$: its two branches, and the corner where they meet.

# %%
figure = Figure(figsize=(3.5, 2.6), layout="constrained")
axes = figure.subplots()
places = linspace(0.02, 0.3, 57)
rows = [hs.evaluate(scene.with_values({"effects.filter.zeta": Rational(f"{x:.4f}")})).bandwidth for x in places]
axes.plot(places, [float(x) for x in rows], color="k", linewidth=1)
axes.plot([float(best)], [float(found)], "o", color="k", markersize=4)
axes.annotate(f"{float(found):.4f} rad/s", (float(best), float(found)), (6, -2), textcoords="offset points", fontsize=8)
axes.set(xlim=(0, 0.3), ylim=(0, 30), xlabel=r"$\zeta$", ylabel="bandwidth (rad/s)")
figure.savefig(output / "20_best_damping.pdf", metadata={"CreationDate": None})
