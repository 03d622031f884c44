r"""What play makes of a sine: less, and later. The first harmonic, from the Fourier integral.

Claim. Of x = A sin(theta) a play of total width g, whose driven side keeps its place while no flank touches it, makes a motion
with the first harmonic N A sin(theta): with u = 1 - g/A and 2 A > g,

    N = 1/2 + (asin u + u sqrt(1 - u^2))/pi - j (1 - u^2)/pi,   1 - u^2 = g/A (2 - g/A).

The lag costs energy: half a period of it is the area of the loop of driven over driving side, 2 g (2 A - g) a period. Up to
2 A = g nothing moves; for A much larger than g, N tends to 1 - j 2 g/(pi A).

Assumptions. The driven side stays where it is between the flanks (friction, no mass of its own that flies on); one sine. A
describing function leaves out all other harmonics.

Source. Derived here. The method: A. Gelb and W. E. Vander Velde, Multiple-Input Describing Functions, 1968 (recalled).

Run as ``python 23_backlash.py [directory]``; formulas and figure go to the directory, ``derived`` if none is given.
"""

# %%
import sys
from pathlib import Path

from matplotlib.figure import Figure
from sympy import I, Rational, asin, cos, diff, expand, integrate, latex, pi, sin, sqrt, symbols

import haptisym as hs

A, theta = symbols("A theta", positive=True)
u = symbols("u", real=True)
g = A * (1 - u)

# %% [markdown]
# ## 1. A period
#
# From $\theta = -\pi/2$ on the driving side goes up; first it crosses the play, while the driven side rests at $-A + g/2$, until
# it has gone $g$: $A\sin\theta = -A + g$, at $\theta_1 = -\arcsin u$. From there to $\pi/2$ the flank pushes, $y = A\sin\theta -
# g/2$. On the way down everything is the same with the other sign, so that half a period is enough.

# %%
first = -asin(u)
rests, pushed = -A + g / 2, A * sin(theta) - g / 2


def half(weight):
    """2/pi times the integral over half a period, of both pieces."""
    piece = [(rests, -pi / 2, first), (pushed, first, pi / 2)]
    return 2 / pi * sum(integrate(expand(y * weight), (theta, low, high)) for y, low, high in piece)


assert expand(rests - pushed.subs(theta, first)) == 0  # it goes on from where it rested

# %% [markdown]
# ## 2. The harmonic
#
# $N = (b + j a)/A$ with $b = \frac{2}{\pi}\int y\sin\theta$ and $a = \frac{2}{\pi}\int y\cos\theta$.

# %%
real = Rational(1, 2) + (asin(u) + u * sqrt(1 - u**2)) / pi
imag = -(1 - u**2) / pi
assert expand(half(sin(theta)) / A - real) == 0
assert expand(half(cos(theta)) / A - imag) == 0

# %% [markdown]
# ## 3. The loop, and both ends
#
# The area of $y$ over $x$ is a parallelogram's, $2A - g$ long and $g$ wide, both ways; a first harmonic lags by it: $-\pi A^2
# \mathrm{Im}\,N = g\,(2A - g)$.

# %%
width = symbols("g", positive=True)
assert expand(-pi * A**2 * imag - g * (2 * A - g)) == 0
assert real.subs(u, -1) == imag.subs(u, -1) == 0
assert (real.subs(u, 1), imag.subs(u, 1)) == (1, 0)
assert diff(imag.subs(u, 1 - width / A), width).subs(width, 0) == -2 / (pi * A)

# %% [markdown]
# ## 4. The package

# %%
for gap, amplitude in ((1, 3), (3, 2), (Rational(7, 10), 1)):
    exact = (real + I * imag).subs(u, 1 - Rational(gap) / amplitude)
    package = hs.effects.backlash(gap, amplitude).matrix[0]
    assert abs((exact - package).evalf(70)) < Rational(1, 10**55)
assert hs.effects.backlash(2, 1).matrix[0] == 0
assert hs.effects.backlash(3, 1).matrix[0] == 0

# %%
output = Path(sys.argv[1] if len(sys.argv) > 1 else "derived")
output.mkdir(parents=True, exist_ok=True)
(output / "23_backlash.tex").write_text(
    f"\\begin{{align}}\n\\mathrm{{Re}}\\,N &= {latex(real)} \\\\\n\\mathrm{{Im}}\\,N &= {latex(imag)}\n\\end{{align}}\n",
    encoding="utf-8",
)

# %%
figure = Figure(figsize=(3.5, 2.6), layout="constrained")
axes = figure.subplots()
ratios = [Rational(n, 100) for n in range(1, 200)]
values = [complex(hs.effects.backlash(x, 1).matrix[0]) for x in ratios]
axes.plot([x.real for x in values], [x.imag for x in values], color="k", linewidth=1)
axes.set(xlabel="Re N", ylabel="Im N")
figure.savefig(output / "23_backlash.pdf", metadata={"CreationDate": None})
