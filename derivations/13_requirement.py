r"""What a parameter must be for nobody to notice: the edge polynomial and its root, for three parameters and a delay.

Claim. In the paper's example, band [0, 15 rad/s], the imaginary part binds at the band's edge whichever parameter is free, and
the value that is just enough is a root of r_i(omega_max)^2 = c^2: of a polynomial of degree 8 in the filter's frequency, of
degree 4 in its damping ratio, and linear in c^2,

    omega_n >= 122.355814770431 rad/s,   zeta <= 0.264345145449365,   c >= 0.155424076383943.

Each is, to 40 digits, the end that ``require`` gives. A delay on a spring must keep tau <= asin(c)/omega_max, if c < 1: the
same formula that ``require`` finds by solving the condition at the band's edge.

Assumptions. Linear; m, b, k > 0; steady sinusoidal motion, x_h = x_e; the same threshold for both parts (eq. 4). That these
roots bind on the *whole* band, and no touch inside does, is what derivation 10 proves for omega_n; here a Sturm count shows it
for each of the three on both sides of its end.

Source. Eqs. (4), (7) to (10) of W. Fu, M. M. van Paassen, M. Mulder, Framework for a Two-step Evaluation of Haptic Displays,
IFAC-PapersOnLine 52(19) 97-102, 2019, doi:10.1016/j.ifacol.2019.12.119.

Run as ``python 13_requirement.py [directory]``; formulas and figure go to the directory, ``derived`` if none is given.
"""

# %%
import sys
from pathlib import Path

from sympy import (
    Expr,
    Float,
    I,
    Poly,
    Rational,
    Symbol,
    asin,
    cos,
    exp,
    expand,
    fraction,
    latex,
    sin,
    sqrt,
    symbols,
    together,
)

m, b, k, w, zeta, omega, c, tau = symbols("m b k omega_n zeta omega c tau", positive=True)
W, end = symbols("W omega_max", positive=True)
s, t, X = symbols("s t X")


def is_zero(difference: Expr) -> bool:
    """Whether an expression is zero identically: exact, over a common denominator and multiplied out."""
    return expand(fraction(together(difference))[0]) == 0


# %% [markdown]
# ## 1. Newton's law and the filter
#
# The environment answers the motion $x = Xe^{st}$ with $f_e = m\ddot x + b\dot x + kx$; the filter passes on $f_h$ with
# $\ddot f_h + 2\zeta\omega_n\dot f_h + \omega_n^2f_h = \omega_n^2f_e$.

# %%
H = m * s**2 + b * s + k
G = w**2 / (s**2 + 2 * zeta * w * s + w**2)
motion = X * exp(s * t)
f_e = m * motion.diff(t, 2) + b * motion.diff(t) + k * motion
f_h = G * H * motion
assert is_zero(f_e - H * motion)
assert is_zero(f_h.diff(t, 2) + 2 * zeta * w * f_h.diff(t) + w**2 * (f_h - f_e))

# %% [markdown]
# ## 2. The condition
#
# With $A = k - m\omega^2$, $B = b\omega$ and $U = (1 - 4\zeta^2)\omega_n^2 - \omega^2$ the distortion $\Delta H = H(G - 1)$
# has the parts $\omega^2(AU + 2\zeta\omega_n^3b)/D$ and $\omega(b\omega^2U - 2\zeta\omega_n^3A)/D$. A part is noticed where
# $E = (\text{top})^2 - c^2(A^2 + B^2)D^2 > 0$, a polynomial in $W = \omega^2$.

# %%
A, B = k - m * omega**2, b * omega
U, D = (1 - 4 * zeta**2) * w**2 - omega**2, (w**2 - omega**2) ** 2 + (2 * zeta * w * omega) ** 2
real, imag = omega**2 * (A * U + 2 * zeta * w**3 * b), omega * (b * omega**2 * U - 2 * zeta * w**3 * A)
assert is_zero((H * (G - 1)).subs(s, I * omega) - (real + I * imag) / D)
EXCESS = [expand(top**2 - c**2 * (A**2 + B**2) * D**2).subs(omega, sqrt(W)) for top in (real, imag)]

# %% [markdown]
# ## 3. At the band's edge
#
# $E(\omega_{max}^2) = 0$ is a polynomial in each parameter. In $\omega_n$ it has degree 8 and no formula; in $c^2$ it is linear:
# $c = r_i(\omega_{max})$.

# %%
edge = EXCESS[1].subs(W, end**2)
assert Poly(edge, w).degree() == 8
assert Poly(edge, zeta).degree() == 4
threshold = sqrt((imag**2 / ((A**2 + B**2) * D**2)).subs(omega, end))
assert is_zero(edge.subs(c, threshold))

PAPER = {m: Rational("1.8"), b: 15, k: 100, w: 80, zeta: Rational("0.5"), c: Rational("0.1"), end: 15}
CLAIMED = {w: "122.355814770431", zeta: "0.264345145449365", c: "0.155424076383943"}


def edge_roots(free: Symbol) -> list[Float]:
    """The positive roots of the edge polynomial in one parameter, 50 digits."""
    numbers = {x: value for x, value in PAPER.items() if x != free}
    polynomial = Poly(edge.subs(numbers), free, domain="QQ")
    return [root.evalf(50) for root in polynomial.real_roots() if root > 0]


def noticed(part: int, free: Symbol, value: Rational) -> bool:
    """Whether a part exceeds the threshold anywhere on the band: by a Sturm count, exact."""
    polynomial = Poly(EXCESS[part].subs({**PAPER, free: value}), W, domain="QQ")
    return bool(polynomial.count_roots(0, PAPER[end] ** 2) > 0)


ENDS = {}
for free, digits in CLAIMED.items():
    [ENDS[free]] = [root for root in edge_roots(free) if str(root.evalf(15)) == digits]
    just_below, just_above = (Rational(str(ENDS[free].evalf(30))) * (1 + Rational(i, 10**9)) for i in (-1, 1))
    enough, too_little = (just_below, just_above) if free == zeta else (just_above, just_below)
    assert not noticed(0, free, enough)
    assert not noticed(1, free, enough)
    assert noticed(1, free, too_little)

# %% [markdown]
# ## 4. A delay on a spring
#
# A delay passes on $f_h(t) = f_e(t - \tau)$, so $G = e^{-s\tau}$. On a spring $r_i = \sin\omega\tau$ and
# $r_r = 1 - \cos\omega\tau$: while $\omega\tau \le \pi/2$ both grow, and $r_r = \tan(\omega\tau/2)\,r_i \le r_i$. So the
# condition at the edge, $\sin\omega_{max}\tau = c$, is the whole of it.

# %%
assert is_zero(motion.subs(t, t - tau) - exp(-s * tau) * motion)
lateness = (exp(-I * omega * tau) - 1).rewrite(cos)
assert is_zero(lateness - (cos(omega * tau) - 1 - I * sin(omega * tau)))
enough_delay = asin(c) / end
assert is_zero(sin(end * enough_delay) - c)

# %% [markdown]
# ## 5. The package says the same
#
# The ends of `require` are these roots, digit by digit, with the same binding; its closed forms are these formulas.

# %%
import haptisym as hs

paper = hs.load_scene("fu2019")
for free, value in ENDS.items():
    [span] = hs.require(paper, free.name).feasible
    claimed = span.last if free == zeta else span.first
    assert claimed.value.digits(40) == str(value.evalf(40))
    [binding] = claimed.bindings
    assert (binding.part, binding.kind.value, float(binding.omega)) == (hs.Part.IMAG, "band-edge", 15.0)
[form] = hs.require(paper, "c").forms
assert is_zero(form**2 - threshold**2)

spring = hs.Scene(hs.environments.mass_spring_damper(k=100), (hs.effects.delay("5 ms"),), (0, 15))
[form] = hs.require(spring, "tau").forms
assert form - enough_delay == 0

# %% [markdown]
# The formulas, and the largest ratio on the band over its threshold against the filter's frequency, with the requirement.

# %%

output = Path(next((given for given in sys.argv[1:2] if not given.startswith("-")), "derived"))
output.mkdir(parents=True, exist_ok=True)
lines = [rf"\omega_n &\ge {CLAIMED[w]}", rf"\tau &\le {latex(enough_delay)}", rf"c &\ge {latex(threshold)}"]
(output / "13_requirement.tex").write_text(
    "\\begin{align}\n" + " \\\\\n".join(lines) + "\n\\end{align}\n", encoding="utf-8"
)
hs.require(paper, "omega_n").save_figure(output / "13_requirement.pdf")
