r"""One chart for every mass-spring-damper behind every second-order low-pass: the paper's example without units.

Claim. The distortion ratios of a mass-spring-damper behind a second-order low-pass depend on four numbers only,

    x = omega/omega_0,  zeta = b/(2 sqrt(k m)),  rho = omega_n/omega_0,  zeta_f,      omega_0 = sqrt(k/m),

and meet the threshold c where two polynomials of degree six in x^2 vanish. Towards both ends of the chart the crossings are
straight lines, x_r = y_r rho and x_i = y_i rho, the same two for every zeta (zeta_f = 1/2, c = 0.1: 0.5314 and 0.09903).
In between all curves of r_r pass through (rho, x) = (1/y_i, 1), and all curves of r_i through (1/y_r, 1). For a fast filter
(to first order in 1/rho) and zeta < 1/sqrt 2, r_r reaches c near omega_0 while c rho < 2 zeta_f/sqrt(1 - zeta^2), and only
at about y_r rho beyond. r_r meets c for every filter and environment; r_i need not. The paper's example is the point
rho = 24/sqrt 5, zeta = sqrt(5)/4, with the crossings 1.0705 and 1.6016, that is 7.97891679... and 11.9373109... rad/s.

Assumptions. Linear, m, b, k, omega_n, zeta_f > 0; steady sinusoidal motion, x_h = x_e; 0 < c < 1, the same for both parts
(eq. 4).

Source. Eqs. (4), (7) to (10) of W. Fu, M. M. van Paassen, M. Mulder, Framework for a Two-step Evaluation of Haptic Displays,
IFAC-PapersOnLine 52(19) 97-102, 2019, doi:10.1016/j.ifacol.2019.12.119. The theorem on dimensionless groups:
E. Buckingham, On Physically Similar Systems, Phys. Rev. 4, 345-376, 1914.

Run as ``python 09_universal_chart.py [directory]``; formulas and figure go to the directory, ``derived`` if none is given.
"""

# %%
import sys
from pathlib import Path

from sympy import (
    Abs,
    Expr,
    I,
    Integer,
    Matrix,
    Poly,
    Rational,
    Symbol,
    diff,
    exp,
    expand,
    fraction,
    sqrt,
    symbols,
    together,
)

m, b, k, omega_n, omega, omega_0, c = symbols("m b k omega_n omega omega_0 c", positive=True)
x, zeta, rho, zeta_f, W = symbols("x zeta rho zeta_f W", positive=True)  # W = x^2
s, t, X = symbols("s t X")


def is_zero(difference: Expr) -> bool:
    """Whether an expression is zero identically: exact, over a common denominator and multiplied out."""
    return expand(fraction(together(difference))[0]) == 0


# %% [markdown]
# ## 1. Newton's law and the filter
#
# The hand moves as $x = Xe^{st}$, the environment answers with $f_e = m\ddot x + b\dot x + kx$ (eq. 7), and the device passes
# on a force that follows $\ddot f_h + 2\zeta_f\omega_n\dot f_h + \omega_n^2f_h = \omega_n^2f_e$ (eq. 8).

# %%
H = m * s**2 + b * s + k
G = omega_n**2 / (s**2 + 2 * zeta_f * omega_n * s + omega_n**2)
motion = X * exp(s * t)
f_e, f_h = H * motion, G * H * motion
assert is_zero(m * motion.diff(t, 2) + b * motion.diff(t) + k * motion - f_e)
assert is_zero(f_h.diff(t, 2) + 2 * zeta_f * omega_n * f_h.diff(t) + omega_n**2 * (f_h - f_e))

dH = G * H - H  # eq. (9)

# %% [markdown]
# ## 2. Three groups
#
# $m$, $b$, $k$, $\omega_n$ and $\omega$ are measured in kg, kg/s, kg/s$^2$, 1/s and 1/s. As powers of kilogram and second
# these are the columns of a matrix of rank 2, so $5 - 2 = 3$ independent products are without dimension, and any such product
# is one of these three: the null space of the matrix is spanned by the exponents of $x$, $\zeta$ and $\rho$. The filter's
# damping ratio and $c$ are numbers already.

# %%
DIMENSIONS = Matrix([[1, 1, 1, 0, 0], [0, -1, -2, -1, -1]])  # kilogram and second, of m, b, k, omega_n, omega
HALF = Rational(1, 2)
GROUPS = Matrix(
    [
        [HALF, 0, -HALF, 0, 1],  # x = omega sqrt(m/k)
        [-HALF, 1, -HALF, 0, 0],  # 2 zeta = b/sqrt(k m)
        [HALF, 0, -HALF, 1, 0],  # rho = omega_n sqrt(m/k)
    ]
)
assert DIMENSIONS.rank() == 2
assert Matrix.zeros(2, 3) == DIMENSIONS * GROUPS.T
assert GROUPS.rank() == len(DIMENSIONS.nullspace()) == 3

IN_GROUPS = {k: m * omega_0**2, b: 2 * zeta * m * omega_0, omega_n: rho * omega_0, omega: x * omega_0}

# %% [markdown]
# Measured in $k$, the environment is $A + jB$ with $A = 1 - x^2$ and $B = 2\zeta x$, and the filter's denominator
# $P + jQ$, $P = \rho^2 - x^2$, $Q = 2\zeta_f\rho x$. With $U = (1 - 4\zeta_f^2)\rho^2 - x^2$ and $D = P^2 + Q^2$
#
# $$\frac{\Re\Delta H}{k} = x^2\,\frac{AU + 4\zeta\zeta_f\rho^3}{D},\qquad
# \frac{\Im\Delta H}{k} = 2x\,\frac{\zeta x^2U - \zeta_f\rho^3A}{D},\qquad \frac{|H|^2}{k^2} = S = A^2 + B^2:$$
#
# neither $m$ nor $\omega_0$ is left in them.

# %%
A, B = 1 - x**2, 2 * zeta * x
P, Q = rho**2 - x**2, 2 * zeta_f * rho * x
U = (1 - 4 * zeta_f**2) * rho**2 - x**2
D, S = P**2 + Q**2, A**2 + B**2
real = x**2 * (A * U + 4 * zeta * zeta_f * rho**3) / D
imag = 2 * x * (zeta * x**2 * U - zeta_f * rho**3 * A) / D

on_axis = {s: I * omega}
assert is_zero((H / k).subs(on_axis).subs(IN_GROUPS) - A - I * B)
assert is_zero((dH / k).subs(on_axis).subs(IN_GROUPS) - real - I * imag)
ratio_real, ratio_imag = Abs(real) / sqrt(S), Abs(imag) / sqrt(S)  # eq. (10)

# %% [markdown]
# ## 3. The threshold polynomials
#
# $r > c$ where $(\text{top})^2 > c^2SD^2$: two polynomials in $W = x^2$. With $g = (1 - 4\zeta_f^2)\rho^2$,
# $h = g + 4\zeta\zeta_f\rho^3$, $n = \zeta_f\rho^3$, $u = \zeta g + n$, $e = 1 - 2\zeta^2$ and $f = 1 - 2\zeta_f^2$ their
# coefficients are
#
# | | $W^2(W^2 - (1 + g)W + h)^2$ | $4W(\zeta W^2 - uW + n)^2$ | $SD^2$, taken $c^2$ times from either |
# |---|---|---|---|
# | $W^6$ | $1$ | $0$ | $1$ |
# | $W^5$ | $-2(1 + g)$ | $4\zeta^2$ | $-4f\rho^2 - 2e$ |
# | $W^4$ | $(1 + g)^2 + 2h$ | $-8\zeta u$ | $(4f^2 + 2)\rho^4 + 8ef\rho^2 + 1$ |
# | $W^3$ | $-2(1 + g)h$ | $4u^2 + 8\zeta n$ | $-4f\rho^6 - 2e(4f^2 + 2)\rho^4 - 4f\rho^2$ |
# | $W^2$ | $h^2$ | $-8un$ | $\rho^8 + 8ef\rho^6 + (4f^2 + 2)\rho^4$ |
# | $W$ | $0$ | $4n^2$ | $-2e\rho^8 - 4f\rho^6$ |
# | $1$ | $0$ | $0$ | $\rho^8$ |

# %%
g = (1 - 4 * zeta_f**2) * rho**2
h, n = g + 4 * zeta * zeta_f * rho**3, zeta_f * rho**3
u, e, f = zeta * g + n, 1 - 2 * zeta**2, 1 - 2 * zeta_f**2
table = [
    (1, 0, 1),
    (-2 * (1 + g), 4 * zeta**2, -4 * f * rho**2 - 2 * e),
    ((1 + g) ** 2 + 2 * h, -8 * zeta * u, (4 * f**2 + 2) * rho**4 + 8 * e * f * rho**2 + 1),
    (-2 * (1 + g) * h, 4 * u**2 + 8 * zeta * n, -4 * f * rho**6 - 2 * e * (4 * f**2 + 2) * rho**4 - 4 * f * rho**2),
    (h**2, -8 * u * n, rho**8 + 8 * e * f * rho**6 + (4 * f**2 + 2) * rho**4),
    (0, 4 * n**2, -2 * e * rho**8 - 4 * f * rho**6),
    (0, 0, rho**8),
]
powers = [W**i for i in range(6, -1, -1)]
excess_real, excess_imag = (
    sum((row[column] - c**2 * row[2]) * power for row, power in zip(table, powers, strict=True)) for column in (0, 1)
)
for excess, form in ((excess_real, real), (excess_imag, imag)):
    assert is_zero(excess.subs(W, x**2) - (form * D) ** 2 + c**2 * S * D**2)

# %% [markdown]
# **Is there a crossing at all?** At $W = 0$ both polynomials are $-c^2\rho^8 < 0$: slow enough a movement hides any filter.
# The leading coefficients are $1 - c^2 > 0$ and $-c^2 < 0$. So $r_r$ meets $c$ for *every* filter and every environment, an
# odd number of times (counted with multiplicity), and $r_i$ an even number of times, perhaps never. Without any: the filter
# $8000/((s + 20)(s + 400))$ takes one pole from $(s + 1)(s + 20)$ and leaves $(s + 1)$ with a motion that lags nowhere
# ($\zeta = \zeta_f = 21/(4\sqrt 5)$, $\rho = 20$).

# %%
assert [excess.subs(W, 0) for excess in (excess_real, excess_imag)] == [-(c**2) * rho**8] * 2
assert [Poly(excess, W).LC().factor() for excess in (excess_real, excess_imag)] == [(1 - c**2).factor(), -(c**2)]

TEN_PERCENT = {c: Rational("0.1")}
NEVER = {zeta: 21 / (4 * sqrt(5)), zeta_f: 21 / (4 * sqrt(5)), rho: 20, **TEN_PERCENT}


def counted(excess: Expr, values: dict[Symbol, Expr]) -> int:
    """How many positive roots a threshold polynomial has, by Sturm's theorem."""
    return Poly(expand(excess.subs(values)), W, domain="QQ").count_roots(0, None)


assert (counted(excess_real, NEVER), counted(excess_imag, NEVER)) == (1, 0)

# %% [markdown]
# ## 4. Slow movement
#
# For $x \to 0$ the imaginary part comes first, with the slope $2\zeta_f/\rho$ of $r_i$; $r_r$ grows with
# $x^2h/\rho^4 = x^2\left((1 - 4\zeta_f^2)/\rho^2 + 4\zeta\zeta_f/\rho\right)$.


def leading(form: Expr, variable: Symbol) -> tuple[Expr, int]:
    """Coefficient and power of a rational function as a variable grows without bound."""
    top, bottom = (Poly(part, variable) for part in fraction(together(form)))
    return top.LC() / bottom.LC(), top.degree() - bottom.degree()


def trailing(form: Expr, variable: Symbol) -> tuple[Expr, int]:
    """Coefficient and power of a rational function as a variable goes to 0."""
    inverse = Symbol("v", positive=True)
    coefficient, power = leading(form.subs(variable, 1 / inverse), inverse)
    return coefficient, -power


assert S.subs(x, 0) == 1
for form, growth, power in ((real, h / rho**4, 2), (imag, -2 * zeta_f / rho, 1)):
    coefficient, found = trailing(form, x)
    assert found == power
    assert is_zero(coefficient - growth)

# %% [markdown]
# ## 5. A fast filter
#
# At a fixed $x$, for $\rho \to \infty$: $\rho r_r \to 4\zeta\zeta_fx^2/\sqrt S$ and $\rho r_i \to 2\zeta_fx|1 - x^2|/\sqrt S$:
# a delay of $2\zeta_f/\omega_n$. The first has its peak, $2\zeta_f/\sqrt{1 - \zeta^2}$, at $x^2 = 1/(1 - 2\zeta^2)$ if
# $\zeta < 1/\sqrt 2$, and grows towards $4\zeta\zeta_f$ if not. Where it meets $c\rho$ is a quadratic in $v = 1/x^2$:
#
# $$x_r \approx \left(e + \sqrt{e^2 - 1 + \left(\frac{4\zeta\zeta_f}{c\rho}\right)^2}\right)^{-1/2},\qquad e = 1 - 2\zeta^2.$$

# %%
for form, limit in ((real, 4 * zeta * zeta_f * x**2), (imag, -2 * zeta_f * x * A)):
    coefficient, power = leading(form, rho)
    assert power == -1
    assert is_zero(coefficient - limit)

v = Symbol("v", positive=True)
flat_squared = (4 * zeta * zeta_f) ** 2 / ((v - e) ** 2 + 4 * zeta**2 * (1 - zeta**2))
peak_squared = 4 * zeta_f**2 / (1 - zeta**2)
assert is_zero(flat_squared.subs(v, 1 / x**2) - (4 * zeta * zeta_f * x**2) ** 2 / S)
assert is_zero(flat_squared.subs(v, e) - peak_squared)
assert is_zero(flat_squared.subs(v, 0) - (4 * zeta * zeta_f) ** 2)

v_first = e + sqrt(e**2 - 1 + (4 * zeta * zeta_f / (c * rho)) ** 2)
fast_crossing = 1 / sqrt(v_first)
assert is_zero(flat_squared.subs(v, v_first) - (c * rho) ** 2)

# %% [markdown]
# So near $\omega_0$ the real part of a fast filter's distortion is noticed while $c\rho$ is below the peak, and not beyond.
# What is left is the crossing that the polynomial must have, and it leaves with the filter: for $x = \rho y$ and
# $\rho \to \infty$ only the mass is felt, $H \to -m\omega^2$, which is real, so that the ratios are the moduli of the parts of
# $G - 1$, at $y = \omega/\omega_n$. For $\rho \to 0$ only the spring is felt there, which is real too: the same again.

# %%
y, V = symbols("y V", positive=True)  # V = y^2
D_y = (1 - y**2) ** 2 + (2 * zeta_f * y) ** 2
p = y**2 * (y**2 - 1 + 4 * zeta_f**2) / D_y  # -Re(G - 1)
q = 2 * zeta_f * y / D_y  # -Im(G - 1)
assert is_zero((G - 1).subs(s, I * y * omega_n) + p + I * q)

for end in (leading, trailing):
    square, degree = end(S.subs(x, rho * y), rho)
    for form, part in ((real, p), (imag, q)):
        coefficient, power = end(form.subs(x, rho * y), rho)
        assert 2 * power == degree
        assert is_zero(coefficient**2 / square - part**2)

# %% [markdown]
# $p = c$ is a quadratic in $y^2$ with one positive root (and for $\zeta_f \ge 1/2$ no other place has $|p| = c$):
#
# $$y_r^2 = \frac{a + \sqrt{a^2 + 4c(1 - c)}}{2(1 - c)},\qquad a = (1 - 4\zeta_f^2) - 2c\,(1 - 2\zeta_f^2).$$
#
# $q = c$ is a quartic in $y$. It has roots for every $\zeta_f$ if $c < 1/2$, since where $1 - y^2 = 2\zeta_fy$ the value is
# $q = 1/(2(1 - y^2)) > 1/2$. So for fast filters, and for slow ones, $r_i$ is noticed too.

# %%
a = (1 - 4 * zeta_f**2) - 2 * c * (1 - 2 * zeta_f**2)
y_r = sqrt((a + sqrt(a**2 + 4 * c * (1 - c))) / (2 * (1 - c)))
assert is_zero((p - c).subs(y, y_r))
assert is_zero((p - c) * D_y - ((1 - c) * y**4 - a * y**2 - c))
assert is_zero(q.subs(zeta_f, (1 - y**2) / (2 * y)) - 1 / (2 * (1 - y**2)))

# The other sign, p = -c, is (1 + c) V^2 - w V + c = 0 with w = (1 + c) 2 f - 1, and f <= 1/2 makes w <= c.
w = (1 + c) * 2 * f - 1
assert is_zero((p + c) * D_y - ((1 + c) * V**2 - w * V + c).subs(V, y**2))
assert is_zero(w.subs(zeta_f, HALF) - c)
assert is_zero(c**2 - 4 * c * (1 + c) + c * (4 + 3 * c))  # so its discriminant is negative where w > 0

IN_CHART = {zeta_f: HALF, **TEN_PERCENT}
quartic = Poly(fraction(together((c - q).subs(IN_CHART)))[0], y, domain="QQ")
y_i, y_i_back = (root for root in quartic.nroots(n=30) if root.is_real)
assert quartic.count_roots(0, None) == 2
assert [str(value.evalf(4)) for value in (y_r.subs(IN_CHART), y_i, y_i_back)] == ["0.5314", "0.09903", "2.279"]

# %% [markdown]
# ## 6. Where all curves meet
#
# At $x = 1$ the spring and the mass cancel and only the damper is felt: a quarter turn, so that $r_r = q(1/\rho)$ and
# $r_i = |p(1/\rho)|$, whatever $\zeta$. All curves of $r_r = c$ go through $\rho = 1/y_i$ there, all of $r_i = c$ through
# $1/y_r$. Through the first, on double logarithmic paper, with the slope
# $\dfrac{d\ln x}{d\ln\rho} = \dfrac{yq'}{yq' + p/\zeta}$ (with $\zeta_f = 1/2$ and $c$ = 10 % at most 1, and above 0.99
# for $\zeta > 0.1$).

# %%
at_one = {x: 1, rho: 1 / y}
D_one = (rho**2 - 1) ** 2 + (2 * zeta_f * rho) ** 2
meeting_real, meeting_imag = 2 * zeta_f * rho**3 / D_one, (1 - (1 - 4 * zeta_f**2) * rho**2) / D_one
for form, meeting, part in ((real, meeting_real, q), (imag, meeting_imag, p)):
    assert is_zero((form**2 / S).subs(x, 1) - meeting**2)
    assert is_zero(meeting - part.subs(y, 1 / rho))

squared = real**2 / S
growth = (rho * diff(squared, rho) / (x * diff(squared, x))).subs(at_one)
slope = y * diff(q, y) / (y * diff(q, y) + p / zeta)
assert is_zero(growth + slope)
slopes = [slope.subs({zeta_f: HALF, y: y_i, zeta: Rational(value)}).evalf(6) for value in ("0.1", "1")]
assert 0.99 < slopes[0] < slopes[1] < 1

# %% [markdown]
# ## 7. The paper's example
#
# $m = 1.8$ kg, $b = 15$ Ns/m, $k = 100$ N/m, $\omega_n = 80$ rad/s: $\rho = 24/\sqrt 5 = 10.73$, $\zeta = \sqrt 5/4$. It lies
# just beyond the point where all curves meet, and just before the peak $2\zeta_f/(c\sqrt{1 - \zeta^2}) = 12.06$: that is why
# its $r_r$ is so flat. With 97 instead of 80 rad/s it is noticed at 26 instead of 8 rad/s.

# %%
PAPER = {zeta: sqrt(5) / 4, rho: 24 / sqrt(5), zeta_f: HALF, **TEN_PERCENT}
paper = {m: Rational("1.8"), b: 15, k: 100, omega_n: 80}
own_frequency = sqrt(k / m).subs(paper)
assert (b / (2 * sqrt(k * m))).subs(paper) == PAPER[zeta]
assert 80 / own_frequency == PAPER[rho]
assert str((sqrt(peak_squared) / c).subs(PAPER).evalf(4)) == "12.06"
assert (counted(excess_real, PAPER), counted(excess_imag, PAPER)) == (1, 2)


def crossings(excess: Expr, values: dict[Symbol, Expr]) -> list[Expr]:
    """The places x of all positive roots, to 40 digits."""
    polynomial = Poly(expand(excess.subs(values)), W, domain="QQ").sqf_part()
    found = [sqrt(root) for root in polynomial.nroots(n=50, maxsteps=500) if root.is_real and root > 0]
    assert len(found) == polynomial.count_roots(0, None)
    return sorted(found)


[x_r], (x_i, x_i_back) = crossings(excess_real, PAPER), crossings(excess_imag, PAPER)
print(f"x_r = {x_r.evalf(20)}, x_i = {x_i.evalf(20)}")
assert [str(value.evalf(5)) for value in (x_r, x_i)] == ["1.0705", "1.6016"]
assert str((own_frequency * x_r).evalf(16)) == "7.978916790174708"
assert str((own_frequency * x_i).evalf(17)) == "11.937310924322058"
assert str(fast_crossing.subs(PAPER).evalf(3)) == "1.08"

# %% [markdown]
# ## 8. The package says the same
#
# With symbols, in the groups of section 2. A modulus hides a sign: in the ratios either is tried.

# %%
import haptisym as hs

E, F = hs.environments, hs.effects
d = hs.distort(E.mass_spring_damper(m, b, k), F.second_order_lowpass(omega_n, zeta_f))
plain = hs.distort(E.mass_spring_damper(1, 2 * zeta, 1), F.second_order_lowpass(rho, zeta_f))
for derived, packaged, bare in (
    (real, d.real / k, plain.real),
    (imag, d.imag / k, plain.imag),
    (S, d.modulus**2 / k**2, plain.modulus**2),
):
    assert is_zero(packaged.subs(IN_GROUPS) - derived)
    assert is_zero(bare.subs(omega, x) - derived)
for ratio, part in ((d.ratio_real, d.real), (d.ratio_imag, d.imag)):
    signed = ratio.replace(Abs, lambda z: z) * d.modulus
    assert is_zero(signed - part) or is_zero(signed + part)

# %% [markdown]
# Evaluations. The paper's scene crosses where the polynomials do, and so, twice as fast, does a steering wheel of
# 0.018 kg m$^2$, 0.3 Nms/rad and 4 Nm/rad behind 160 rad/s: it is the same point of the chart.

# %%
from haptisym import Part

WIDE = (Integer(0), Integer(400))


def found(scene: hs.Scene, part: Part) -> list[str]:
    """The crossings of a part, to 30 digits."""
    return [x.omega.digits(30) for x in hs.evaluate(scene, digits=30).crossings if x.part is part]


def expected(own: Expr, places: list[Expr]) -> list[str]:
    """Places of the chart for an environment with that natural frequency."""
    return [str((own * place).evalf(30)) for place in places]


example = hs.load_scene("fu2019").with_band(*WIDE)
wheel = hs.Scene(
    E.mass_spring_damper("0.018 kg*m^2", "0.3 N*m*s/rad", "4 N*m/rad"), (F.second_order_lowpass(160, "0.5"),), WIDE
)
for scene, own in ((example, own_frequency), (wheel, 2 * own_frequency)):
    assert found(scene, Part.REAL) == expected(own, [x_r])
    assert found(scene, Part.IMAG) == expected(own, [x_i, x_i_back])

faster = hs.Scene(E.mass_spring_damper(Rational("1.8"), 15, 100), (F.second_order_lowpass(97, "0.5"),), WIDE)
assert [place[:5] for place in found(faster, Part.REAL)] == ["26.08"]

# %% [markdown]
# Where all curves meet: with $\rho = 10$ and $c = q(1/10) = 1000/9901$, $r_r$ crosses at exactly $\omega = \omega_0 = 1$ rad/s
# for every $\zeta$. And the scene of section 3 has no crossing of $r_i$ at all.

# %%
threshold = meeting_real.subs({zeta_f: HALF, rho: 10})
assert threshold == Rational(1000, 9901)
for damping in ("0.1", "0.4", "1", "2", "8"):
    scene = hs.Scene(E.mass_spring_damper(1, damping, 1), (F.second_order_lowpass(10, "0.5"),), WIDE, threshold)
    assert 1 in [Rational(place) for place in found(scene, Part.REAL)], damping

never = hs.Scene(
    E.mass_spring_damper(1, 21, 20), (F.series("8000/((s + 20)*(s + 400))"),), (Integer(0), Integer(10**6))
)
assert found(never, Part.IMAG) == []
assert found(never, Part.REAL) == expected(sqrt(20), crossings(excess_real, NEVER))

# %% [markdown]
# ## 9. Formulas and figure

# %%
from matplotlib.figure import Figure
from numpy import logspace, meshgrid
from sympy import lambdify

from haptisym import latex

output = Path(next((given for given in sys.argv[1:2] if not given.startswith("-")), "derived"))
output.mkdir(parents=True, exist_ok=True)

formulas = {
    r"r_r": ratio_real,
    r"r_i": ratio_imag,
    r"x_r (\rho \gg 1)": fast_crossing,
    r"\max_x \rho r_r (\rho \to \infty)": sqrt(peak_squared),
    r"y_r": y_r,
    r"r_r (x = 1)": meeting_real,
    r"r_i (x = 1)": Abs(meeting_imag),
}
formulas_tex = [f"{name} &= {latex(form)}" for name, form in formulas.items()]
(output / "09_universal_chart.tex").write_text(
    "\\begin{align}\n" + " \\\\\n".join(formulas_tex) + "\n\\end{align}\n", encoding="utf-8"
)

# %% [markdown]
# The chart, for $\zeta_f = 1/2$ and $c$ = 10 %: every frequency at which $r_r$ (above) or $r_i$ (below) is $c$; the lowest
# line over a $\rho$ is the crossing. In grey the two lines that they all tend to; a ring where all curves meet, a dot at
# the paper's example. Read it as: filter over natural frequency to the right, movement over natural frequency upwards.

# %%
figure = Figure(figsize=(3.4, 5.0), layout="constrained")
panels = figure.subplots(2, 1, sharex=True)
filters, movements = logspace(0, 2, 161), logspace(-1, 2, 241)
grid = meshgrid(filters, movements)
STYLES = {Rational("0.2"): ":", sqrt(5) / 4: "-", Integer(1): "--", Integer(2): "-."}
LINES = (float(y_r.subs(IN_CHART)), float(y_i))
for panel, form, crossing, meets in zip(panels, (real, imag), (x_r, x_i), LINES[::-1], strict=True):
    for line in LINES:
        panel.plot(filters, line * filters, color="0.8", lw=2.5, zorder=1)
    for value, style in STYLES.items():
        squared_ratio = lambdify((rho, x), (form**2 / S).subs({zeta_f: HALF, zeta: value}), "numpy")(*grid)
        panel.contour(*grid, 100 * squared_ratio, [1], colors="k", linestyles=style, linewidths=1.1)
        panel.plot([], [], style, color="k", lw=1.1, label=rf"$\zeta$ = {float(value):.2g}")
    panel.plot(1 / meets, 1, "o", color="k", mfc="w", ms=6, zorder=3)
    panel.plot(float(PAPER[rho]), float(crossing), "o", color="k", ms=4, zorder=4)
    panel.set(xscale="log", yscale="log", ylim=(0.1, 100))
panels[0].set(ylabel=r"$r_r = c$ at $\omega/\omega_0$")
panels[1].set(xlabel=r"$\rho = \omega_n/\omega_0$", ylabel=r"$r_i = c$ at $\omega/\omega_0$")
panels[0].legend(loc="upper left", frameon=False, fontsize=8)
figure.savefig(output / "09_universal_chart.pdf", metadata={"CreationDate": None})
