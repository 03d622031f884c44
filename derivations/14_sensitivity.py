r"""How a threshold frequency moves with each parameter: implicit differentiation, and two sum rules.

Claim. At a crossing of the paper's example, $r(\omega, p) = c$, the frequency moves with a parameter $p$ as
$d\omega/dp = -F_p/F_\omega$, where $F$ is the numerator of $r^2 - c^2$: a quotient of polynomials. The elasticities
$e_p = (p/\omega)\,d\omega/dp$ keep two sum rules, whatever the values: $e_m + e_b + e_k = 0$ (forces scaled move nothing) and
$e_b + 2e_k + e_{\omega_n} = 1$ (a clock that runs slower by a factor makes every frequency larger by it). Where the ratio only
touches its threshold $F_\omega = 0$: there the frequency has no derivative.

Assumptions. Mass, spring and damper behind a second-order filter; all symbols positive.

Source. Fu, van Paassen and Mulder (2019), eqs. (4), (7), (8), (10); the implicit function theorem; Euler's theorem on
homogeneous functions.
"""

# %%
import sys
from pathlib import Path

from sympy import Function, I, Poly, Rational, Symbol, diff, expand, fraction, symbols, together

omega, m, b, k, omega_n, zeta, c, u = symbols("omega m b k omega_n zeta c u", positive=True)
s = I * omega

# %% [markdown]
# ## 1. From the physics to the equation
#
# The hand should feel $H = ms^2 + bs + k$ and feels $GH$. Numerator and denominator of $G$ and $H$ are complex numbers on
# $s = j\omega$; real and imaginary parts are taken by hand.

# %%
H_real, H_imag = k - m * omega**2, b * omega
below_real, below_imag = omega_n**2 - omega**2, 2 * zeta * omega_n * omega  # of G
squared = below_real**2 + below_imag**2
P, Q = omega_n**2 * below_real / squared - 1, -(omega_n**2) * below_imag / squared  # G - 1 = P + j Q
parts = {"real": P * H_real - Q * H_imag, "imag": P * H_imag + Q * H_real}  # of dH = (G - 1) H
ratios = {name: part**2 / (H_real**2 + H_imag**2) for name, part in parts.items()}
equations = {
    name: Poly(fraction(together(r2 - c**2))[0].expand(), omega, m, b, k, omega_n, zeta, c)
    for name, r2 in ratios.items()
}

# %% [markdown]
# ## 2. Implicit differentiation
#
# Along a crossing $F(\omega(p), p) = 0$ for every $p$. So is its derivative by $p$, $F_p + F_\omega\,d\omega/dp$.

# %%
parameters = (m, b, k, omega_n, zeta, c)
along, slope = Function("along")(b), Symbol("slope")
for F in equations.values():  # for one parameter, by the chain rule of SymPy
    total = diff(F.as_expr().subs(omega, along), b).subs(diff(along, b), slope).subs(along, omega)
    assert Poly(total, slope, *F.gens) == Poly(F.diff(b).as_expr() + F.diff(omega).as_expr() * slope, slope, *F.gens)

# %% [markdown]
# ## 3. The sum rules
#
# $F$ is homogeneous in $(m, b, k)$, and with the weights 1, 1, 2 and 1 of $\omega, b, k, \omega_n$ (their powers of 1/s): Euler's
# theorem. On $F = 0$ the right-hand sides vanish; divided by $-\omega F_\omega$ the rules are those of the elasticities.

# %%
for F in equations.values():
    force = sum(p * F.diff(p) for p in (m, b, k))
    clock = omega * F.diff(omega) + b * F.diff(b) + 2 * k * F.diff(k) + omega_n * F.diff(omega_n)
    for total in (force, clock):
        degree = Rational(total.coeffs()[0], F.coeffs()[0])
        assert total - degree * F == 0
        assert degree > 0

# %% [markdown]
# ## 4. At a touch
#
# Let $r = a(1 - (\omega - 1)^2)$ near its greatest value $a$. For $a = c$ it touches at $\omega = 1$, where $F_\omega = 0$ and
# $F_a \neq 0$. For $a = c(1 + u)$ it crosses at $1 \pm \sqrt{u/(1 + u)}$, and for $a < c$ nowhere: no derivative at $u = 0$.

# %%
a = Symbol("a", positive=True)
peak = a * (1 - (omega - 1) ** 2) - c
at_touch = {omega: 1, a: c}
assert diff(peak, omega).subs(at_touch) == 0
assert diff(peak, a).subs(at_touch) == 1
assert expand(peak.subs(a, c * (1 + u)).subs(omega, 1 + (u / (1 + u)) ** Rational(1, 2))).cancel() == 0

# %% [markdown]
# ## 5. The package says the same

# %%
import haptisym as hs

scene = hs.load_scene("fu2019")
d = hs.derive(scene)
own = {p.symbol: Symbol(p.symbol.name, positive=True) for p in scene.parameters}
for part in hs.Part:
    packaged = d.equation(part)
    F = Poly(
        packaged.ring.expression(packaged.F).xreplace({**own, hs.omega: omega, hs.symbols("c"): c}),
        *equations["real"].gens,
    )
    quotient, rest = equations[part.value].div(
        F
    )  # what was cancelled: powers of omega, nothing that is 0 at a crossing
    assert rest == 0
    assert set(quotient.free_symbols) <= {omega}
    for p in parameters:
        symbol = next((x for x in d.kept if x.name == p.name), hs.symbols("c"))
        formula = d.sensitivity(part, symbol).xreplace({**own, hs.omega: omega, hs.symbols("c"): c})
        above, below = (Poly(x, *F.gens) for x in fraction(formula))
        assert (above * F.diff(omega) + F.diff(p) * below).is_zero  # formula - (-F_p/F_omega) = 0

found = hs.sensitivity(scene)
for x in found.crossings:
    e = {row.name: float(row.elasticity) for row in x.parameters}
    assert abs(e["m"] + e["b"] + e["k"]) < 1e-14
    assert abs(e["b"] + 2 * e["k"] + e["omega_n"] - 1) < 1e-14

# %% [markdown]
# ## 6. Formulas and figure

# %%
from haptisym import latex

output = Path(next((given for given in sys.argv[1:2] if not given.startswith("-")), "derived"))
output.mkdir(parents=True, exist_ok=True)
formula = hs.derive(scene, ["omega_n"]).sensitivity(
    hs.Part.REAL, next(p.symbol for p in scene.parameters if p.symbol.name == "omega_n")
)
lines = [
    rf"\frac{{d \omega_r}}{{d \omega_n}} &= {latex(formula)}",
    r"e_m + e_b + e_k &= 0",
    r"e_b + 2 e_k + e_{\omega_n} &= 1",
]
(output / "14_sensitivity.tex").write_text(
    "\\begin{align}\n" + " \\\\\n".join(lines) + "\n\\end{align}\n", encoding="utf-8"
)
found.save_figure(output / "14_sensitivity.pdf")
