r"""Other measures of transparency, from the equations of the two-port: what each has to do with the JND test.

Claim. Let Gamma = H_perc/H_env. With phi = arg H_env the distortion over |H_env| is the relative distortion turned by phi,

    (Re dH + j Im dH)/|H_env| = e^{j phi} (Gamma - 1),        r_r = |Re ...|, r_i = |Im ...|,

so that |Gamma - 1| <= c is enough for both ratios, and a box instead of a disc is all that tells the two tests apart. A chain
matrix [[A, B], [C, D]] makes H_perc = (A H + B)/(C H + D): what is felt of nothing is Z_min = B/D, of a rigid environment
Z_max = A/C, their difference Z_width = (A D - B C)/(C D) = -h12 h21/h22, and a small change of H is passed on times
(A D - B C)/(C H + D)^2. With g = (A D - B C)/D^2 Llewellyn's condition reads Re g - 2 Im(B/D) Im(C/D) >= |g|, where
Im(B/D) >= 0 >= Im(C/D). A display let go swings by the zeros of H_perc: P_0 = (pi - atan(omega_d/sigma))/omega_d,
P_n = 2 pi/omega_d, A_n/A_d = exp(-n pi sigma/omega_d); a series effect has no part in that. The paper's filter is 3 dB down at
80 sqrt((1 + sqrt 5)/2) = 101.76 rad/s, 12.8 times its bandwidth by the JND.

Assumptions. Linear; steady sinusoidal motion (the free response: released at rest from A_d, one pair of zeros
-sigma +- j omega_d); all parameters > 0.

Source. Eqs. (9), (10) of W. Fu, M. M. van Paassen, M. Mulder (2019), doi:10.1016/j.ifacol.2019.12.119. The measures: Lawrence
(1993), Griffiths et al. (2008), Hashtrudi-Zaad and Salcudean (2001), Cavusoglu et al. (2002), recalled and derived anew here;
Llewellyn's criterion; 14 CFR Part 60, appendix A, attachment 2.

Run as ``python 15_metrics.py [directory]``; formulas and figure go to the directory, ``derived`` if none is given.
"""

# %%
import sys
from pathlib import Path

from sympy import (
    Expr,
    I,
    Rational,
    atan,
    cos,
    diff,
    exp,
    expand,
    fraction,
    limit,
    oo,
    pi,
    sin,
    solve,
    sqrt,
    symbols,
    together,
)

m, b, k, omega, omega_n, zeta, M = symbols("m b k omega omega_n zeta M", positive=True)
sigma, omega_d, A_d, t = symbols("sigma omega_d A_d t", positive=True)
s, H, X_h, X_e, F_h, F_e = symbols("s H X_h X_e F_h F_e")


def is_zero(difference: Expr) -> bool:
    """Whether an expression is zero identically: over a common denominator, multiplied out."""
    return expand(fraction(together(difference))[0]) == 0


# %% [markdown]
# ## 1. A display as a two-port
#
# The environment's force is passed on through a filter, $f = G f_e$, and the hand moves the device's mass as well,
# $f_h = f + M\ddot x$, with $x_h = x_e$. In between, a joint of stiffness $k$ would add its yielding $f/k$ to the motion. Each is
# a pair of equations; written as a matrix from the environment's side to the hand's, they multiply.

# %%
G = omega_n**2 / (s**2 + 2 * zeta * omega_n * s + omega_n**2)
A, B, C, D = symbols("A B C D")
joint = symbols("k_j", positive=True)
passed = G * F_e  # the filter
at_joint = (passed, X_e + passed / joint)  # the joint yields
at_hand = (at_joint[0] + M * s**2 * at_joint[1], at_joint[1])  # the device's mass moves with the hand
chain = [expand(row).coeff(side) for row in at_hand for side in (F_e, X_e)]
H_perc = (at_hand[0] / at_hand[1]).subs(F_e, H * X_e)
moebius = (A * H + B) / (C * H + D)
in_chain = dict(zip((A, B, C, D), chain, strict=True))
assert is_zero(H_perc - moebius.subs(in_chain))

# %% [markdown]
# ## 2. Limits, width, sensitivity, and the hybrid matrix
#
# $f_h = h_{11}x_h + h_{12}f_e$, $-x_e = h_{21}x_h + h_{22}f_e$.

# %%
det = A * D - B * C
Z_min, Z_max = limit(moebius, H, 0), limit(moebius, H, oo)
assert is_zero(Z_min - B / D)
assert is_zero(Z_max - A / C)
assert is_zero(Z_max - Z_min - det / (C * D))
sensitivity = diff(moebius, H)
assert is_zero(sensitivity - det / (C * H + D) ** 2)
[found] = solve([A * F_e + B * X_e - F_h, C * F_e + D * X_e - X_h], [F_h, X_e], dict=True)
force, moved = (expand(found[side]) for side in (F_h, X_e))
h11, h12, h21, h22 = force.coeff(X_h), force.coeff(F_e), -moved.coeff(X_h), -moved.coeff(F_e)
for entry, own in ((h11, B / D), (h12, det / D), (h21, -1 / D), (h22, C / D)):
    assert is_zero(entry - own)
assert is_zero(Z_max - Z_min + h12 * h21 / h22)

# %% [markdown]
# ## 3. Passive and absolutely stable
#
# A motion $Xe^{j\omega t}$ takes the mean power $\frac12\Re(F\,\overline{j\omega X}) = \frac12\omega|X|^2\,\Im H$: passive
# at that frequency exactly if $\Im H \ge 0$. In force over velocity $h_{11}$ becomes $h_{11}/s$ and $h_{22}$ becomes
# $s h_{22}$, the product $p = h_{12}h_{21}$ stays. Behind a passive environment of admittance $y$, $\Re y \ge 0$, the hand meets
# $h_{11} - p/(h_{22} + y)$. The values $w = 1/(h_{22} + y)$ fill the disc of radius and centre $1/(2\Re h_{22})$:

# %%
x_0, y_0, r, v = symbols("x_0 y_0 r v", real=True)
g_22 = symbols("g_22", positive=True)
power = (F_h * (-I * omega) * X_h).subs(F_h, (x_0 + I * y_0) * X_h) / X_h**2  # X real
assert is_zero(power - omega * y_0 + I * omega * x_0)
# |w - 1/(2 g)|^2 - 1/(4 g^2) for w = 1/(g + r + j v) is -r/(g |g + r + j v|^2): inside for r > 0, on the rim for r = 0
square = (g_22 + r) ** 2 + v**2
re_w, im_w = (g_22 + r) / square, -v / square
assert is_zero((re_w - 1 / (2 * g_22)) ** 2 + im_w**2 - 1 / (4 * g_22**2) + r / (g_22 * square))

# %% [markdown]
# The largest $\Re(pw)$ on that disc is $(\Re p + |p|)/(2\Re h_{22})$, so that the hand meets a passive thing whatever the
# environment exactly if $2\,\Re h_{11}\,\Re h_{22} \ge \Re p + |p|$. With $h_{11}/(j\omega)$, $j\omega h_{22}$ and $p = -g$:
# $-2\,\Im(B/D)\,\Im(C/D) + \Re g \ge |g|$; the frequency drops out.

# %%
re_11, im_11, re_22, im_22 = symbols("re_11 im_11 re_22 im_22", real=True)
own_11 = ((re_11 + I * im_11) / (I * omega)).expand(complex=True)
own_22 = ((re_22 + I * im_22) * I * omega).expand(complex=True)
assert is_zero(own_11.as_real_imag()[0] * own_22.as_real_imag()[0] + im_11 * im_22)
assert is_zero(h12 * h21 + det / D**2)

# %% [markdown]
# ## 4. Let go
#
# $x(t) = A_de^{-\sigma t}(\cos\omega_dt + \frac\sigma{\omega_d}\sin\omega_dt)$ starts at rest, obeys the equation whose zeros are
# $-\sigma \pm j\omega_d$, crosses zero first at $\omega_dt = \pi - \arctan(\omega_d/\sigma)$, and turns back at
# $\omega_dt = n\pi$.

# %%
x = A_d * exp(-sigma * t) * (cos(omega_d * t) + sigma / omega_d * sin(omega_d * t))
assert is_zero(diff(x, t, 2) + 2 * sigma * diff(x, t) + (sigma**2 + omega_d**2) * x)
assert (x.subs(t, 0), diff(x, t).subs(t, 0)) == (A_d, 0)
P_0 = (pi - atan(omega_d / sigma)) / omega_d
assert is_zero(x.subs(t, P_0).expand(trig=True))
speed = diff(x, t)
assert is_zero(speed + A_d * exp(-sigma * t) * (sigma**2 + omega_d**2) / omega_d * sin(omega_d * t))
for n in range(1, 4):
    assert is_zero(x.subs(t, n * pi / omega_d) - (-1) ** n * A_d * exp(-n * pi * sigma / omega_d))

# %% [markdown]
# ## 5. The package's formulas
#
# For a mass-spring-damper behind a filter and a mass. First the rotation: with $e^{j\varphi} = H_{env}/|H_{env}|$ it says
# $\Delta H = H_{env}(\Gamma - 1)$ part by part.

# %%
import haptisym as hs
from haptisym import effects, environments

stick = environments.mass_spring_damper(m, b, k)
d = hs.distort(stick, effects.second_order_lowpass(omega_n, zeta), effects.shunt(m=M))
H_env = d.environment_properties.real + I * d.environment_properties.imag
turned = H_env * (d.relative_real + I * d.relative_imag)
assert is_zero(d.real + I * d.imag - turned)
assert is_zero(d.modulus**2 - d.environment_properties.real**2 - d.environment_properties.imag**2)
assert is_zero(d.relative_real + I * d.relative_imag - (d.perceived / d.environment - 1).subs(hs.s, I * omega))
assert is_zero(d.real**2 + d.imag**2 - d.modulus**2 * (d.relative_real**2 + d.relative_imag**2))

PAPER = hs.load_scene("fu2019")
loose = hs.Scene(
    environments.kelvin_voigt(100, 3),
    (effects.second_order_lowpass(80, 0.5), effects.compliance(k=5000), effects.shunt(m="0.1")),
)
own = hs.metrics(loose)
symbol = {p.symbol.name: p.symbol for p in loose.parameters}
names = {omega_n: symbol["omega_n"], zeta: symbol["zeta"], joint: symbol["k_compliance"], M: symbol["m"], s: hs.s}
at = {H: symbol["k"] + symbol["b"] * hs.s}


def in_package(form: Expr) -> Expr:
    """A formula in A, B, C, D with the chain of section 1, in the package's symbols."""
    return form.subs(in_chain).subs(names).subs(at)


for name, index, form in (
    ("impedance range", 0, Z_min),
    ("impedance range", 1, Z_max),
    ("impedance range", 2, Z_max - Z_min),
    ("sensitivity", 0, sensitivity),
    ("absolute stability", 0, det / D**2),
):
    assert is_zero(own[name].forms[index].value - in_package(form)), name

decay, swing = Rational(15) / (2 * Rational("1.8")), sqrt(100 / Rational("1.8") - (Rational(15) / Rational("3.6")) ** 2)
shown = {sigma: decay, omega_d: swing}
expected = (P_0, 2 * pi / omega_d, exp(-pi * sigma / omega_d))
free = hs.metrics(PAPER)["free response, helicopters"].values  # the environment's, a pair of zeros from rest
for value, form in zip(free, expected, strict=False):
    assert value.reference.digits(30) == str(form.subs(shown).evalf(30)), value.what

golden = 80 * sqrt((1 + sqrt(5)) / 2)
edges = hs.metrics(PAPER)["transmitted impedance ratio"].values
assert edges[0].value.digits(30) == str(golden.evalf(30))
print(f"3 dB edge of the paper's filter: {golden.evalf(10)} rad/s")

# %% [markdown]
# ## 6. Formulas and figure

# %%
from matplotlib.figure import Figure
from numpy import linspace

from haptisym import latex

output = Path(next((given for given in sys.argv[1:2] if not given.startswith("-")), "derived"))
output.mkdir(parents=True, exist_ok=True)
formulas = {
    r"Z_{min}": Z_min,
    r"Z_{max}": Z_max,
    r"Z_{width}": det / (C * D),
    r"\frac{d H_{perc}}{d H_{env}}": det / (C * H + D) ** 2,
    "P_0": P_0,
    "P_n": 2 * pi / omega_d,
}
lines = [f"{name} &= {latex(form)}" for name, form in formulas.items()]
(output / "15_metrics.tex").write_text(
    "\\begin{align}\n" + " \\\\\n".join(lines) + "\n\\end{align}\n", encoding="utf-8"
)

# %% [markdown]
# The relative distortion of the paper's example in the plane, and the same turned by the environment's phase: only the
# turned one can be compared with the box of the JND; the disc does not mind.

# %%
figure = Figure(figsize=(3.4, 3.2), layout="constrained")
ax = figure.subplots()
band = linspace(0.01, 15, 401)
v = PAPER.distortion().compile()(band)
plain = v.relative_real + 1j * v.relative_imag
direction = v.environment_real + 1j * v.environment_imag
turned_curve = plain * direction / abs(direction)
ax.plot(plain.real, plain.imag, "k--", lw=1.1, label=r"$\Gamma - 1$")
ax.plot(turned_curve.real, turned_curve.imag, "k-", lw=1.1, label=r"$e^{j\varphi}(\Gamma - 1)$")
ax.plot([-0.1, 0.1, 0.1, -0.1, -0.1], [-0.1, -0.1, 0.1, 0.1, -0.1], color="0.4", lw=0.8, label="box of the JND")
ax.set(xlabel="real part", ylabel="imaginary part")
ax.set_aspect("equal")
ax.legend(loc="lower right", frameon=False, fontsize=7)
figure.savefig(output / "15_metrics.pdf", metadata={"CreationDate": None})
