r"""What an encoder makes of a sine: the first harmonic of a staircase, from the Fourier integral.

Claim. An encoder that rounds to whole steps, q round(x/q), answers x = A sin(theta) with the first harmonic N A sin(theta),

    N = 4 q/(pi A) sum over i with (2 i - 1) q < 2 A of sqrt(1 - ((2 i - 1) q/(2 A))^2),

real, and the same at every frequency. N is 0 up to A = q/2, where the encoder never moves on; with one step it is largest at
A = q/sqrt(2), 4/pi = 1.2732: a loop with an encoder has up to 27 % more gain than without. For A much larger than
q it tends to 1.

Assumptions. The midtread quantiser, whose output is 0 about 0; a motion that is one sine about 0. A describing function leaves
out all other harmonics, and that a sine about another place than 0 sees other steps.

Source. Derived here. The method: A. Gelb and W. E. Vander Velde, Multiple-Input Describing Functions, 1968 (recalled).

Run as ``python 22_quantiser.py [directory]``; formulas and figure go to the directory, ``derived`` if none is given.
"""

# %%
import sys
from pathlib import Path

from matplotlib.figure import Figure
from sympy import Rational, asin, cos, diff, integrate, latex, oo, pi, sin, sqrt, symbols

import haptisym as hs

q, A, theta = symbols("q A theta", positive=True)

# %% [markdown]
# ## 1. One step
#
# The staircase is a sum of steps. Step $i$ adds $q$ while $x > (2i - 1)q/2$, and $-q$ while $x$ is as far below 0: on the first
# half period from $\theta_i = \arcsin((2i - 1)q/(2A))$ to $\pi - \theta_i$. Its first harmonic is
# $\frac{2}{\pi}\int q\sin\theta\,d\theta$ there, as both halves give the same.


# %%
def step(i):
    """The first harmonic of step i, from the Fourier integral."""
    begins = asin((2 * i - 1) * q / (2 * A))
    return 2 / pi * integrate(q * sin(theta), (theta, begins, pi - begins))


def N(steps):
    """The claim, with so many steps."""
    u = q / (2 * A)
    return 4 * q / (pi * A) * sum(sqrt(1 - ((2 * i - 1) * u) ** 2) for i in range(1, steps + 1))


assert all((sum(step(i) for i in range(1, n + 1)) / A - N(n)).expand() == 0 for n in (1, 2, 5))

# %% [markdown]
# In phase: each step is symmetric about $\theta = \pi/2$, so that the part with $\cos\theta$ is 0.

# %%
begins = asin(q / (2 * A))
assert integrate(q * cos(theta), (theta, begins, pi - begins)) == 0

# %% [markdown]
# ## 2. The largest gain, and a fine encoder
#
# With one step $N = \frac{4q}{\pi A}\sqrt{1 - (q/2A)^2}$, whose slope vanishes at $A = q/\sqrt 2$. For ever more steps the sum
# is that of the midpoint rule for $\frac{4}{\pi}\int_0^1\sqrt{1 - u^2}\,du = 1$.

# %%
assert diff(N(1), A).subs(A, q / sqrt(2)).simplify() == 0
assert N(1).subs(A, q / sqrt(2)).simplify() == 4 / pi
u = symbols("u", positive=True)
assert 4 / pi * integrate(sqrt(1 - u**2), (u, 0, 1)) == 1
assert N(1).subs(A, q / 2) == 0

# %% [markdown]
# ## 3. The package
#
# In symbols its form is exact; in numbers it has 60 digits.

# %%
for step_size, amplitude, count in ((1, 3, 3), (2, 3, 2), (1, Rational(7, 5), 1), (3, 1, 0)):
    package = hs.effects.encoder(step_size, amplitude).matrix[0]
    assert abs((N(count).subs({q: step_size, A: amplitude}) - package).evalf(70)) < Rational(1, 10**55)
assert hs.effects.encoder(q, A).matrix[0].subs({q: 1, A: Rational(1, 2)}) == 0
fine = hs.effects.encoder(1, 10000).matrix[0]
assert abs(fine - 1) < 1e-5
assert N(1).subs(A, oo * q) == 0  # what one step alone makes of a large motion

# %%
output = Path(sys.argv[1] if len(sys.argv) > 1 else "derived")
output.mkdir(parents=True, exist_ok=True)
(output / "22_quantiser.tex").write_text(
    f"\\begin{{align}}\nN_1 &= {latex(N(1))} \\\\\nN_2 &= {latex(N(2))}\n\\end{{align}}\n", encoding="utf-8"
)

# %%
figure = Figure(figsize=(3.5, 2.6), layout="constrained")
axes = figure.subplots()
amplitudes = [0.3 + 0.01 * n for n in range(400)]
axes.plot(amplitudes, [float(hs.effects.encoder(1, x).matrix[0]) for x in amplitudes], color="k", linewidth=1)
axes.set(xlabel="amplitude (steps)", ylabel="N")
figure.savefig(output / "22_quantiser.pdf", metadata={"CreationDate": None})
