r"""What a limit and a dead zone make of a sine: first harmonics that add up to 1, from the Fourier integral.

Claim. A limit of +-l answers A sin(theta) with the first harmonic N A sin(theta), N = L(l/A),

    L(u) = 2/pi (asin u + u sqrt(1 - u^2)) for u < 1, else 1,

and a dead zone of half width w, which loses what the limit keeps, with 1 - L(w/A): 0 up to A = w. Both are real and the same at
every frequency. A play is made of the same function: its part in phase is (1 + L(1 - g/A))/2 (23_backlash).

Assumptions. One sine about 0. A describing function leaves out all other harmonics.

Source. Derived here. The method: A. Gelb and W. E. Vander Velde, Multiple-Input Describing Functions, 1968 (recalled).

Run as ``python 24_dead_zone.py [directory]``; formulas and figure go to the directory, ``derived`` if none is given.
"""

# %%
import sys
from pathlib import Path

from matplotlib.figure import Figure
from sympy import Rational, asin, expand, integrate, latex, pi, sin, sqrt, symbols

import haptisym as hs

A, u, theta = symbols("A u theta", positive=True)

# %% [markdown]
# ## 1. The limit
#
# On a quarter period it is $A\sin\theta$ up to $\theta_1 = \arcsin u$, $u = l/A$, and $l$ from there on; four quarters are
# alike: $N = \frac{4}{\pi A}\int_0^{\pi/2} y\sin\theta\,d\theta$.


# %%
def harmonic(*pieces):
    """4/(pi A) times the integral over a quarter, piece by piece."""
    return 4 / (pi * A) * sum(integrate(expand(y * sin(theta)), (theta, low, high)) for y, low, high in pieces)


first, limit = asin(u), u * A
limited = harmonic((A * sin(theta), 0, first), (limit, first, pi / 2))
L = 2 / pi * (asin(u) + u * sqrt(1 - u**2))
assert expand(limited - L) == 0
assert L.subs(u, 1) == 1

# %% [markdown]
# ## 2. The dead zone
#
# Nothing up to $\theta_1$, then $A\sin\theta - w$: what the limit leaves of the sine.

# %%
lost = harmonic((A * sin(theta) - limit, first, pi / 2))
assert expand(lost - (1 - L)) == 0

# %% [markdown]
# ## 3. The package

# %%
for size, amplitude in ((1, 3), (2, 3), (Rational(99, 100), 1)):
    exact = L.subs(u, Rational(size) / amplitude)
    assert abs((exact - hs.effects.saturation(size, amplitude).matrix[0]).evalf(70)) < Rational(1, 10**55)
    assert abs((1 - exact - hs.effects.dead_zone(size, amplitude).matrix[0]).evalf(70)) < Rational(1, 10**55)
assert hs.effects.dead_zone(1, 1).matrix[0] == hs.effects.dead_zone(2, 1).matrix[0] == 0
assert hs.effects.saturation(1, 1).matrix[0] == hs.effects.saturation(2, 1).matrix[0] == 1

# %%
output = Path(sys.argv[1] if len(sys.argv) > 1 else "derived")
output.mkdir(parents=True, exist_ok=True)
(output / "24_dead_zone.tex").write_text(f"\\begin{{align}}\nL(u) &= {latex(L)}\n\\end{{align}}\n", encoding="utf-8")

# %%
figure = Figure(figsize=(3.5, 2.6), layout="constrained")
axes = figure.subplots()
ratios = [Rational(n, 50) for n in range(1, 75)]
for label, make, style in (("limit", hs.effects.saturation, "-"), ("dead zone", hs.effects.dead_zone, "--")):
    axes.plot(ratios, [float(make(x, 1).matrix[0]) for x in ratios], style, color="k", linewidth=1, label=label)
axes.set(xlabel="size over amplitude", ylabel="N")
axes.legend(fontsize=8, frameon=False)
figure.savefig(output / "24_dead_zone.pdf", metadata={"CreationDate": None})
