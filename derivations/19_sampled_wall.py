r"""How stiff a sampled wall may be before it shakes: exactly, with its hold, its delay and the device in continuous time.

Claim. A wall K, sampled every T and held, on a device m x'' + b x' = -F has from one sample to the next the polynomial

    z^2 + (K c_1 - 1 - p) z + p + K c_0,   p = exp(-b T/m), c_1 = (T - (m/b)(1 - p))/b, c_0 = ((m/b)(1 - p) - T p)/b,

and for b T/m <= 3.5 all its roots have |z| < 1 exactly if

    0 < K < b^2 (1 - p)/(m (1 - p) - b T p) = (2 b/T)(1 + b T/(6 m) + ...):

more than passivity allows, 2 b/T. With alpha = K T^2/m and a virtual damper beta = B T/m by backward difference and no device
damping the boundary is alpha = 2 beta (2 - beta)/(2 + beta), largest 12 - 8 sqrt 2 at beta = 2 sqrt 2 - 2.

Assumptions. The position is read the moment before the force changes; m, b, T > 0; K a number, not in contact and out of it.

Source. The linear limit K < (b + B)/(T/2 + delay) of Gil, Sanchez, Hulin, Preusche and Hirzinger (2009) is its slope at the
origin.

Run as ``python 19_sampled_wall.py [directory]``; formulas and figure go to the directory, ``derived`` if none is given.
"""

# %%
import sys
from pathlib import Path

from flint import arb
from matplotlib.figure import Figure
from numpy import linspace
from sympy import (
    Expr,
    Integer,
    Matrix,
    Rational,
    Symbol,
    cancel,
    diff,
    exp,
    expand,
    fraction,
    lambdify,
    latex,
    series,
    solve,
    sqrt,
    symbols,
    together,
)

import haptisym as hs
from haptisym.kernel.sampledloop import Plant, SampledLoop
from haptisym.verbs.stability.held import held

m, b, T, t = symbols("m b T t", positive=True)
K, B, z, F, x0, v0 = symbols("K B z F x_0 v_0", real=True)


def is_zero(difference: Expr) -> bool:
    """Whether an expression is zero identically."""
    return expand(fraction(together(difference))[0]) == 0


# %% [markdown]
# ## 1. From one sample to the next
#
# While the force $-F$ is held, $m\ddot x + b\dot x = -F$ has this solution from $x_0$, $v_0$ on.

# %%
fade = exp(-b * t / m)
moved = x0 + m / b * (1 - fade) * v0 - F / b * (t - m / b * (1 - fade))
speed = diff(moved, t)
assert is_zero(m * diff(moved, t, 2) + b * speed + F)
assert (moved.subs(t, 0), speed.subs(t, 0)) == (x0, v0)

p = Symbol("p", positive=True)  # exp(-b T/m)
after = [expand(e.subs(t, T).subs(exp(-b * T / m), p)) for e in (moved, speed)]
state = Matrix([[e.coeff(v) for v in (x0, v0)] for e in after])
push = Matrix([e.coeff(F) for e in after])

# %% [markdown]
# The wall holds $F = K x_0$: the roots are the eigenvalues of one matrix.

# %%
closed = state + push * Matrix([[K, 0]])
polynomial = expand((z * Matrix([[1, 0], [0, 1]]) - closed).det())
c1 = (T - m / b * (1 - p)) / b
c0 = (m / b * (1 - p) - T * p) / b
assert is_zero(polynomial - (z**2 + (K * c1 - 1 - p) * z + p + K * c0))

# %% [markdown]
# ## 2. Jury's conditions
#
# $P(1) > 0$, $P(-1) > 0$ and $P(0) < 1$. The first is $K(c_0 + c_1) = K T (1 - p)/b > 0$. The last is $K < (1 - p)/c_0$,
# with $c_0 > 0$. It binds before the second, $K(c_1 - c_0) < 2(1 + p)$, while $2(1 + p)\,c_0 > (1 - p)(c_1 - c_0)$: with
# $y = bT/m$ while $h(y) = 4(1 - p) - y(1 + p)^2 > 0$. That is so up to $y = 3.5$: $h$ and its slope are 0 at 0, its second
# derivative is positive up to 0.2, and from there on balls of values show it, cell by cell.

# %%
assert is_zero(polynomial.subs(z, 1) - K * T * (1 - p) / b)
critical = b**2 * (1 - p) / (m * (1 - p) - b * T * p)
assert is_zero(polynomial.subs(z, 0).subs(K, critical) - 1)
y = Symbol("y", positive=True)
h = 4 * (1 - p) - y * (1 + p) ** 2
both = cancel((2 * (1 + p) * c0 - (1 - p) * (c1 - c0)) * b**2 / m).subs(T, y * m / b)
assert is_zero(both - h)
of_y = h.subs(p, exp(-y))
assert (of_y.subs(y, 0), diff(of_y, y).subs(y, 0)) == (0, 0)
bend = diff(of_y, y, 2)


def is_positive(form: Expr, low: float, high: float) -> bool:
    """On an interval, by balls around its values in two hundred cells of it."""
    values = lambdify(y, form, {"exp": lambda e: e.exp()})
    width = (high - low) / 200
    return all(values(arb(low + (i + 0.5) * width, 0.51 * width)) > 0 for i in range(200))


assert is_positive(bend, 0, 0.2)
assert is_positive(of_y, 0.2, 3.5)

# %% [markdown]
# For short periods it is the known limit, and a little more.

# %%
short = series((critical.subs(p, exp(-b * T / m)) * T / (2 * b)).subs(T, y * m / b), y, 0, 2).removeO()
assert is_zero(short - (1 + y / 6))

# %% [markdown]
# ## 3. A virtual damper on a device without damping
#
# $p \to 1$: $x_{k+1} = x_k + T v_k - (T^2/2m) F_k$, $v_{k+1} = v_k - (T/m) F_k$, with $F_k = K x_k + B(x_k - x_{k-1})/T$.

# %%
alpha, beta = symbols("alpha beta", positive=True)
damped = Matrix([[1 - (alpha + beta) / 2, 1, beta / 2], [-(alpha + beta), 1, beta], [1, 0, 0]])  # x, T v, the last x
three = expand((z * Matrix.eye(3) - damped).det())
a3, a2, a1, a0 = (three.coeff(z, n) for n in (3, 2, 1, 0))
assert a3 == 1
pair = expand((1 - a0**2) - (a1 - a0 * a2))  # Jury: a pair on the circle
boundary = 2 * beta * (2 - beta) / (2 + beta)
assert is_zero(pair.subs(alpha, boundary))
[best] = [r for r in solve(fraction(together(diff(boundary, beta)))[0], beta) if r > 0]
assert is_zero(best - (2 * sqrt(2) - 2))
assert expand(boundary.subs(beta, best) * (2 + best) - (12 - 8 * sqrt(2)) * (2 + best)) == 0

# %% [markdown]
# ## 4. The package has the same
#
# Its polynomial is in $w = 1/z$, its coefficients in balls: here for $m = b = T = 1$, where $p = 1/e$.

# %%
loop = SampledLoop(
    Plant((Integer(0), Integer(1), Integer(1)), ((Integer(0), (Integer(1),)),)),
    Integer(1),
    (Rational(3, 7),),
    (Integer(1),),
)
theirs = loop.balls()
known = {m: 1, b: 1, T: 1, K: Rational(3, 7)}
mine = [polynomial.subs(known).expand().coeff(z, 2 - n).subs(p, exp(-1)) for n in range(3)]
assert len(theirs) == 3
assert all((x / theirs[0]).overlaps(arb(str((y / mine[0]).evalf(40)))) for x, y in zip(theirs, mine, strict=True))


def wall(stiffness: Expr, damping: Expr, device: dict[str, Expr], period: Expr) -> hs.Scene:
    given = {"k": stiffness, "b": damping}
    rendered = hs.environments.expression("k + b*s", parameters=given)
    return hs.Scene(rendered, (hs.effects.sampled_loop(period, "backward-difference"), hs.effects.shunt(**device)))


FREE = hs.Hand("let go")
P3 = {m: Rational(1, 25), b: Rational(4, 5), T: Rational(1, 1000)}
limit_of_p3 = critical.subs(p, exp(-b * T / m)).subs(P3)
for side, count in ((-1, 0), (1, 2)):
    near = Rational(str((limit_of_p3 * (1 + side * Rational(1, 10**15))).evalf(25)))
    scene = wall(near, Integer(0), {"m": P3[m], "b": P3[b]}, P3[T])
    assert held(scene, FREE).unstable == count
for ratio in (Rational(1, 5), Rational(1), Rational(7, 4)):
    for side, count in ((-1, 0), (1, 2)):
        near = boundary.subs(beta, ratio) * (1 + side * Rational(1, 10**15))
        assert held(wall(near, ratio, {"m": Integer(1)}, Integer(1)), FREE).unstable == count

# %%
output = Path(sys.argv[1] if len(sys.argv) > 1 else "derived")
output.mkdir(parents=True, exist_ok=True)
formulas = {"P(z)": polynomial.collect(z), r"K_\mathrm{max}": critical, r"\alpha": boundary}
(output / "19_sampled_wall.tex").write_text(
    "\\begin{align}\n"
    + " \\\\\n".join(f"{name} &= {latex(form)}" for name, form in formulas.items())
    + "\n\\end{align}\n",
    encoding="utf-8",
)

# %% [markdown]
# The boundary without device damping: stable below the line; the straight line is the linear limit, $\alpha = 2\beta$, the dot
# the stiffest wall.

# %%
figure = Figure(figsize=(3.5, 2.9), layout="constrained")
axes = figure.subplots()
dampers = linspace(0, 2, 200)
axes.plot(dampers, lambdify(beta, boundary, "numpy")(dampers), color="k")
axes.plot(dampers, 2 * dampers, "--", color="0.5", lw=0.8)
axes.plot([float(best)], [float(boundary.subs(beta, best))], "o", color="k", ms=4)
axes.set(xlim=(0, 2), ylim=(0, 1), xlabel=r"$\beta = BT/m$", ylabel=r"$\alpha = KT^2/m$")
figure.savefig(output / "19_sampled_wall.pdf", metadata={"CreationDate": None})
