r"""What damping a sampled wall asks of its device so that every passive hand may hold it, for a filtered wall, too.

Claim. A device m s^2 + b s (and a spring) whose position is sampled every T, with a controller C(z) and a hold, gives a hand
no energy, whatever the hand does, if

    b >= T/2 Re((1 - exp(-j theta)) C(exp(j theta)))/(1 - cos theta),    0 < theta <= pi,

(Colgate and Schenkel), b >= 0 and C(1) + k >= 0, k the device's own spring; and a hand that moves as fast between samples as at
them, evenly, has nothing more. A spring K asks for
K T/2; d samples late for K (T/2 + d T); with a virtual damper B by backward difference for K T/2 + |B|; and where that
damper's velocity goes through a first-order low-pass of time constant tau, for K T/2 + B T/(T + 2 tau) if B >= 0, for
K T/2 - B if B <= 0. In x = cos theta, or t = tan(theta/2), every such condition is one polynomial sign.

Assumptions. A linear controller that settles, a hold of the same clock, no delay that is not a whole number of samples.

Source. J. E. Colgate, G. G. Schenkel, Passivity of a class of sampled-data systems: application to haptic interfaces, Journal
of Robotic Systems 14(1) 37-47, 1997, where the condition is derived by another way.

Run as ``python 18_sampled_passivity.py [directory]``; formulas and figure go to the directory, ``derived`` if none is given.
"""

# %%
import sys
from pathlib import Path

from matplotlib.figure import Figure
from numpy import linspace, pi
from sympy import (
    Expr,
    I,
    Integer,
    Rational,
    cancel,
    cos,
    diff,
    exp,
    expand,
    fraction,
    integrate,
    lambdify,
    latex,
    limit,
    oo,
    sin,
    summation,
    symbols,
    together,
)

import haptisym as hs
from haptisym.judge.colgate import sampled_passivity

b, K, T, tau, theta = symbols("b K T tau theta", positive=True)
B, x, t = symbols("B x t", real=True)
w = symbols("w")  # 1/z, one sample ago


def is_zero(difference: Expr) -> bool:
    """Whether an expression is zero identically, in exponentials over a common denominator."""
    return expand(fraction(together(difference.rewrite(exp)))[0]) == 0


# %% [markdown]
# ## 1. The energy of one period
#
# While the force $u_k = C x_k$ is held, the hand does the work $u_k\,\Delta_k$ against it, $\Delta_k = x_{k+1} - x_k$, however it
# moves in between. The damper takes $\int b\,\dot x^2\,dt$, which is least for an even motion: with $\dot x = \Delta/T + r$,
# where $r$ has mean 0, it is $b\,\Delta^2/T + \int b\,r^2\,dt$. Mass and spring give back what they took.

# %%
step = symbols("Delta", real=True)
even = integrate(b * (step / T) ** 2, (t, 0, T))
assert is_zero(even - b * step**2 / T)
mean, rest = symbols("R R_2", real=True)  # of r and of r^2, over one period
square = expand(b * T * ((step / T) ** 2 + 2 * step / T * mean + rest))  # b times the integral of (Delta/T + r)^2
assert is_zero(square.subs(mean, 0) - (even + b * T * rest))

# %% [markdown]
# So over all periods a hand can draw nothing if $\sum_k \left(u_k\,\Delta_k + b\,\Delta_k^2/T\right) \ge 0$ for every motion, and
# the hand that moves evenly between samples attains that. By Parseval it is so if it is so for each $x_k = e^{jk\theta}$:
# $|\Delta|^2 = 2(1 - \cos\theta)$, and $u\,\bar\Delta = C\,(e^{-j\theta} - 1)$.

# %%
z = exp(I * theta)
assert is_zero((z - 1) * (1 / z - 1) - 2 * (1 - cos(theta)))
c_re, c_im = symbols("c_r c_i", real=True)
C = c_re + I * c_im
work = expand(((C * (1 / z - 1)) + (c_re - I * c_im) * (z - 1)) / 2)  # the real part
needed = T / 2 * expand(((1 - 1 / z) * C + (1 - z) * (c_re - I * c_im)) / 2) / (1 - cos(theta))
assert is_zero((work + b * 2 * (1 - cos(theta)) / T) - 2 * (1 - cos(theta)) / T * (b - needed))

# %% [markdown]
# A motion that does not come back is the limit $\theta \to 0$, and adds a condition: held at $x$ after a slow motion, the work
# that was done against controller and spring is $(C(1) + k)\,x^2/2$. Where that is negative a hand draws energy without bound,
# however much is damped; and a hand of stiffness $k_h$ has the root $z = 1$ just where $C(1) + k + k_h = 0$, so that a softer
# one is pushed away.

# %%
rest, own, end = symbols("C_1 k x_e", real=True)
steps = symbols("N", positive=True, integer=True)
n = symbols("n", integer=True)
slow = summation(
    rest * (n * end / steps) * (end / steps), (n, 0, steps - 1)
)  # the force held over each of N small steps
assert expand(limit(slow, steps, oo) + own * end**2 / 2 - (rest + own) * end**2 / 2) == 0

# %% [markdown]
# ## 2. In $x = \cos\theta$
#
# A controller is a quotient of polynomials in $w = 1/z$; $\mathrm{Re}$ of such a quotient is one in $\cos\theta$.

# %%


def right_side(controller: Expr) -> Expr:
    """T/2 Re((1 - w) C)/(1 - cos theta) in x = cos theta, of a controller in w."""
    above, below = fraction(together((1 - w) * controller))
    turned = {w: cos(theta) - I * sin(theta)}
    top, bottom = (expand(e.subs(turned)) for e in (above, below))
    conjugate = expand(below.subs(w, cos(theta) + I * sin(theta)))
    other = expand(above.subs(w, cos(theta) + I * sin(theta)))
    real = expand((top * conjugate + other * bottom) / 2)
    square = expand(bottom * conjugate)
    y = symbols("y")  # sin theta, which comes squared

    def in_x(e: Expr) -> Expr:
        rest = expand(e.subs(sin(theta), y).subs(cos(theta), x))
        even = expand(sum(rest.coeff(y, 2 * n) * (1 - x**2) ** n for n in range(8)))
        odd = expand(sum(rest.coeff(y, 2 * n + 1) for n in range(8)))
        assert odd == 0
        return even

    return cancel(T / 2 * in_x(real) / in_x(square) / (1 - x))


spring = right_side(K + 0 * w)
assert spring == K * T / 2
difference = right_side(K + B * (1 - w) / T)
assert is_zero(difference - (K * T / 2 - B * x))
late = {n: right_side((K + B * (1 - w) / T) * w**n) for n in (1, 2)}
chebyshev = {1: x, 2: 2 * x**2 - 1, 3: 4 * x**3 - 3 * x}
for n, found in late.items():
    kernel = 1 + 2 * sum(chebyshev[i] for i in range(1, n + 1))
    assert is_zero(found - (K * T / 2 * kernel - B * chebyshev[n + 1]))
    assert is_zero(found.subs({B: 0, x: 1}) - K * (T / 2 + n * T))

# %% [markdown]
# The largest value: of $K T/2 - B x$ on $[-1, 1]$ it is $K T/2 + |B|$; of a spring that is late it is at $\theta \to 0$, where
# all cosines are 1.
#
# ## 3. A filtered damper
#
# Behind a low-pass of time constant $\tau$, $s$ becomes $s/(1 + \tau s)$, and by backward difference $(1 - w)/(T + \tau(1 - w))$.
# What is asked for falls or rises with $x$ all the way, as its slope has one sign: the ends tell.

# %%
filtered = right_side(K + B * (1 - w) / (T + tau * (1 - w)))
slope = cancel(diff(filtered, x))
over, under = fraction(together(slope))
assert not over.has(x)  # a number, of the sign of -B
assert is_zero(slope * (T**2 + 2 * tau * (T + tau) * (1 - x)) ** 2 + B * T**2 * (T + tau) * (T + 2 * tau))
high, low = cancel(filtered.subs(x, -1)), cancel(limit(filtered, x, 1))
assert is_zero(high - (K * T / 2 + B * T / (T + 2 * tau)))
assert is_zero(low - (K * T / 2 - B))

# %% [markdown]
# ## 4. The package has the same
#
# Its right-hand side is a function of $t = \tan(\theta/2)$: $x = (1 - t^2)/(1 + t^2)$.

# %%
VALUES = {K: Integer(500), B: Integer(3), T: Rational(1, 1000), tau: Rational(1, 300)}
FILTER = {"k": 500, "b": 3, "w": 300}


def package(delay: int) -> hs.Scene:
    wall = hs.environments.expression("k + b*s*w/(s + w)", parameters=FILTER)
    return hs.Scene(
        wall, (hs.effects.sampled_loop("1 ms", "backward-difference", delay), hs.effects.shunt(m="45 g", b="1"))
    )


for delay in (0, 1):
    mine = right_side((K + B * (1 - w) / (T + tau * (1 - w))) * w**delay).subs(VALUES)
    theirs = sampled_passivity(package(delay))
    assert theirs is not None
    assert theirs.sides is not None
    own = theirs.sides[0].expression()
    assert is_zero(mine.subs(x, (1 - hs.omega**2) / (1 + hs.omega**2)) - own)
at_once = sampled_passivity(package(0))
assert at_once is not None
assert at_once.needed is not None
assert at_once.at_rest == VALUES[K]
assert at_once.needed.value.digits(12) == str((K * T / 2 + B * T / (T + 2 * tau)).subs(VALUES).evalf(12))

# %%
output = Path(sys.argv[1] if len(sys.argv) > 1 else "derived")
output.mkdir(parents=True, exist_ok=True)
formulas = {
    "b_{K}": spring,
    "b_{K, B}": difference,
    "b_{K, B, 1}": late[1],
    r"b_{\tau}": filtered,
    r"\max b_{\tau}": high,
}
(output / "18_sampled_passivity.tex").write_text(
    "\\begin{align}\n"
    + " \\\\\n".join(f"{name} &= {latex(form)}" for name, form in formulas.items())
    + "\n\\end{align}\n",
    encoding="utf-8",
)

# %% [markdown]
# The right-hand side over $\theta$: of the wall at once (solid), filtered (dashed), and filtered and a sample late (dotted).

# %%
figure = Figure(figsize=(3.5, 2.9), layout="constrained")
axes = figure.subplots()
angles = linspace(0.001, pi, 400)
rows = {"at once": (difference, "-"), "filtered": (filtered, "--")}
rows["filtered, late"] = (right_side((K + B * (1 - w) / (T + tau * (1 - w))) * w), ":")
for label, (form, style) in rows.items():
    axes.plot(
        angles, lambdify(theta, form.subs(VALUES).subs(x, cos(theta)), "numpy")(angles), style, color="k", label=label
    )
axes.set(xlim=(0, pi), xlabel=r"$\theta = \omega T$", ylabel="b asked for (N s/m)")
axes.legend(frameon=False, fontsize=8)
figure.savefig(output / "18_sampled_passivity.pdf", metadata={"CreationDate": None})
