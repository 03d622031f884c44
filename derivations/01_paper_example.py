r"""The numerical example of Fu, van Paassen and Mulder (2019), from Newton's law to every statement of its section 3.

Claim. A mass-spring-damper felt through a second-order low-pass filter (eqs. 7 and 8) is distorted by

    Re dH = omega^2 ((k - m omega^2) u + 2 zeta omega_n^3 b)/D,
    Im dH = omega (omega^2 b u - 2 zeta omega_n^3 (k - m omega^2))/D,
    u = (1 - 4 zeta^2) omega_n^2 - omega^2,    D = (omega_n^2 - omega^2)^2 + (2 zeta omega_n omega)^2.

With the paper's numbers r_r exceeds 10 % from 7.97891679... rad/s and r_i from 11.9373109... rad/s (printed as 8 and 12),
each once on 0 to 15 rad/s and nowhere else there. What section 3 says about stiffness, mass and damping is proven on whole
intervals (section 7 here); section 8 says what its rounding, and its "approximately 10 %", hide.

Assumptions. Linear, at rest for t < 0; the hand and the environment make the same motion, x_h = x_e; m, b, k, omega_n,
zeta > 0; the threshold c is the same for both parts (eq. 4).

Source. W. Fu, M. M. van Paassen, M. Mulder, Framework for a Two-step Evaluation of Haptic Displays, IFAC-PapersOnLine
52(19) 97-102, 2019, doi:10.1016/j.ifacol.2019.12.119, eqs. (1) to (10) and section 3.

Run as ``python 01_paper_example.py [directory]``; formulas and figure go to the directory, ``derived`` if none is given.
"""

# %%
import sys
from dataclasses import replace
from pathlib import Path

from sympy import (
    Abs,
    Expr,
    Function,
    I,
    Poly,
    Rational,
    Symbol,
    cancel,
    diff,
    exp,
    expand,
    fraction,
    laplace_transform,
    limit,
    oo,
    pi,
    sign,
    sqrt,
    symbols,
    together,
)
from sympy.integrals.laplace import laplace_correspondence, laplace_initial_conds

m, b, k, omega_n, zeta, omega, c = symbols("m b k omega_n zeta omega c", positive=True)
s, X = symbols("s X")


def is_zero(difference: Expr) -> bool:
    """Whether an expression is zero identically: exact, over a common denominator and multiplied out."""
    return expand(fraction(together(difference))[0]) == 0


# %% [markdown]
# ## 1. Newton's law
#
# A hand that moves a mass $m$ by $x(t)$ against a spring $k$ and a damper $b$ has to supply the force
# $f_e = m\ddot x + b\dot x + kx$. From rest, the Laplace transform makes of it $F_e = (m s^2 + b s + k) X_e$: eq. (7).

# %%
t = Symbol("t", positive=True)
x, f_e, f_h = (Function(name)(t) for name in ("x", "f_e", "f_h"))
X_e, F_e, F_h = (Function(name)(s) for name in ("X_e", "F_e", "F_h"))


def transformed(side: Expr) -> Expr:
    """The Laplace transform of one side of an equation of motion, from rest."""
    image = laplace_transform(side, t, s, noconds=True)
    image = laplace_correspondence(image, {x.func: X_e.func, f_e.func: F_e.func, f_h.func: F_h.func})
    return laplace_initial_conds(image, t, {x.func: [0, 0], f_e.func: [0, 0], f_h.func: [0, 0]})


H_env = cancel(transformed(m * x.diff(t, 2) + b * x.diff(t) + k * x) / X_e)
assert is_zero(H_env - (m * s**2 + b * s + k))

# %% [markdown]
# ## 2. The filter
#
# The device passes on a force $f_h$ that follows $f_e$ as a damped oscillator of natural frequency $\omega_n$ does:
# $\ddot f_h + 2\zeta\omega_n \dot f_h + \omega_n^2 f_h = \omega_n^2 f_e$. Its transform is $F_h = G F_e$, so with
# $X_h = X_e$ the hand feels $H_{perc} = G H_{env}$. The paper's $6400/(s^2 + 80 s + 6400)$, eq. (8), is
# $\omega_n = 80$ rad/s and $\zeta = 1/2$.

# %%
G = cancel(
    transformed(omega_n**2 * f_e)
    / F_e
    / cancel(transformed(f_h.diff(t, 2) + 2 * zeta * omega_n * f_h.diff(t) + omega_n**2 * f_h) / F_h)
)
assert is_zero(G - omega_n**2 / (s**2 + 2 * zeta * omega_n * s + omega_n**2))
assert is_zero(G.subs({omega_n: 80, zeta: Rational(1, 2)}) - 6400 / (s**2 + 80 * s + 6400))

H_perc = G * H_env
dH = H_perc - H_env  # eq. (9)
assert is_zero(dH - H_env * (G - 1))

# %% [markdown]
# ## 3. On the axis $s = j\omega$
#
# Write $H_{env}(j\omega) = A + jB$ with $A = k - m\omega^2$, $B = b\omega$; and the filter's denominator as $P + jQ$ with
# $P = \omega_n^2 - \omega^2$, $Q = 2\zeta\omega_n\omega$. Then $G = \omega_n^2/(P + jQ)$ and
# $G - 1 = (\omega^2 - jQ)/(P + jQ)$. To split a quotient, multiply above and below by the conjugate $P - jQ$; below stands
# then $D = P^2 + Q^2$, which is real.

# %%
A, B = k - m * omega**2, b * omega
P, Q = omega_n**2 - omega**2, 2 * zeta * omega_n * omega
D = P**2 + Q**2

assert is_zero(H_env.subs(s, I * omega) - (A + I * B))
assert is_zero(G.subs(s, I * omega) - omega_n**2 / (P + I * Q))
assert is_zero((G - 1).subs(s, I * omega) - (omega**2 - I * Q) / (P + I * Q))
assert is_zero((P + I * Q) * (P - I * Q) - D)


def parts(z: Expr) -> tuple[Expr, Expr]:
    """Real and imaginary part of a polynomial in real symbols: its terms without and with j."""
    z = expand(z)
    assert is_zero(z.coeff(I, 0) + I * z.coeff(I, 1) - z)
    return z.coeff(I, 0), z.coeff(I, 1)


perceived_top = parts(omega_n**2 * (A + I * B) * (P - I * Q))
distortion_top = parts((A + I * B) * (omega**2 - I * Q) * (P - I * Q))
relative_top = parts((omega**2 - I * Q) * (P - I * Q))

# %% [markdown]
# One abbreviation is left to make, $u = (1 - 4\zeta^2)\omega_n^2 - \omega^2$ (for the paper's $\zeta$ just $-\omega^2$),
# because $\omega^2 P - Q^2 = \omega^2 u$ and $Q(P + \omega^2) = 2\zeta\omega_n^3\omega$. The closed forms:

# %%
u = (1 - 4 * zeta**2) * omega_n**2 - omega**2

perceived_real = omega_n**2 * (A * P + B * Q) / D
perceived_imag = omega_n**2 * (B * P - A * Q) / D
real = omega**2 * (A * u + 2 * zeta * omega_n**3 * b) / D
imag = omega * (omega**2 * b * u - 2 * zeta * omega_n**3 * A) / D
relative_real = omega**2 * u / D
relative_imag = -2 * zeta * omega_n**3 * omega / D

for form, top in zip(
    [perceived_real, perceived_imag, real, imag, relative_real, relative_imag],
    [*perceived_top, *distortion_top, *relative_top],
    strict=True,
):
    assert is_zero(form - top / D)
assert is_zero(perceived_real - A - real)
assert is_zero(perceived_imag - B - imag)

# %% [markdown]
# The ratios of eq. (10) divide by the modulus $|H_{env}|$, $|H_{env}|^2 = A^2 + B^2$. Squared they are rational, and since
# $|\Delta H| = |H_{env}||G - 1|$ they share out the relative distortion:
# $r_r^2 + r_i^2 = |\Delta H/H_{env}|^2 = (\omega^4 + Q^2)/D$, whatever the environment.

# %%
square = A**2 + B**2
modulus = sqrt(square)
ratio_real, ratio_imag = Abs(real) / modulus, Abs(imag) / modulus
ratio_real_squared, ratio_imag_squared = real**2 / square, imag**2 / square
relative_squared = (omega**4 + Q**2) / D

assert is_zero(relative_squared - relative_real**2 - relative_imag**2)
assert is_zero(ratio_real_squared + ratio_imag_squared - relative_squared)

# %% [markdown]
# ## 4. Forces and noticeable changes
#
# A hand moving as $x = X e^{j\omega t}$ meets the force $m\ddot x + b\dot x + kx = H_{env} X e^{j\omega t}$. The part
# $X\,\Re H$ is in phase with the displacement (a spring, if $\Re H > 0$) or opposite to it, that is in phase with the
# acceleration (inertia, if $\Re H < 0$): eq. (5). The part $jX\,\Im H$ is in phase with the velocity: eq. (6), which
# assumes $\Im H > 0$. So $\Re H$ reads as a stiffness, $-\Re H/\omega^2$ as a mass, $\Im H/\omega$ as a damping.

# %%
motion = X * exp(I * omega * t)
force = m * motion.diff(t, 2) + b * motion.diff(t) + k * motion
spring_inertia_force, damping_force = X * A, I * X * B
assert is_zero(force / exp(I * omega * t) - spring_inertia_force - damping_force)

positive = Symbol("R", positive=True)
assert is_zero(X * Abs(positive) * exp(I * 0) - X * positive)  # eq. (5), angle 0 degrees
assert is_zero(X * Abs(-positive) * exp(I * pi) - X * (-positive))  # eq. (5), angle 180 degrees
assert is_zero(X * Abs(positive) * exp(I * pi / 2) - I * X * positive)  # eq. (6), angle 90 degrees

stiffness, damping, mass = A, B / omega, -A / omega**2
assert is_zero(stiffness * motion + damping * motion.diff(t) - force)  # read as a spring and a damper ...
assert is_zero(mass * motion.diff(t, 2) + damping * motion.diff(t) - force)  # ... or as a mass and a damper

# %% [markdown]
# Eq. (4) says a change of $\Re H$ or $\Im H$ is just noticeable when it is $c\,|H|$. A change $p$ of $k$, $b$ or $m$
# alone moves $H$ by $p$, $j\omega p$ or $-\omega^2 p$, which is wholly real or wholly imaginary; it is noticed from
# $c|H|$, $c|H|/\omega$ or $c|H|/\omega^2$ on.

# %%
slopes = [diff(A + I * B, parameter) for parameter in (k, b, m)]
assert slopes == [1, I * omega, -(omega**2)]
jnd_stiffness, jnd_damping, jnd_mass = (c * modulus / Abs(slope) for slope in slopes)
assert (jnd_damping, jnd_mass) == (jnd_stiffness / omega, jnd_stiffness / omega**2)

# %% [markdown]
# ## 5. Changeovers
#
# $\Re H_{env} = 0$ at $\omega = \sqrt{k/m}$, as the paper says. $\Re H_{perc} = 0$ where $AP + BQ = 0$, a quadratic in
# $W = \omega^2$: $mW^2 - SW + k\omega_n^2 = 0$ with $S = k + m\omega_n^2 - 2\zeta\omega_n b$. Its lower root is where the
# felt spring turns into inertia. It is *not* $\sqrt{k/m}$: for a fast filter it lies higher by $\zeta b/(m\omega_n)$, as
# a fraction of $\sqrt{k/m}$. The upper root, where inertia turns into a spring again, is of the filter's size.

# %%
W = Symbol("W", positive=True)


def in_W(form: Expr) -> Expr:
    """A form that is even in omega, as one in W = omega^2."""
    even = expand(form).subs(omega, sqrt(W))
    assert even.is_polynomial(W)
    return even


S = k + m * omega_n**2 - 2 * zeta * omega_n * b
assert is_zero(in_W(A * P + B * Q) - (m * W**2 - S * W + k * omega_n**2))

changeover_environment = sqrt(k / m)
changeover_perceived = sqrt((S - sqrt(S**2 - 4 * m * k * omega_n**2)) / (2 * m))
assert is_zero(A.subs(omega, changeover_environment))
assert is_zero(in_W(A * P + B * Q).subs(W, changeover_perceived**2))

lag = Symbol("lag", positive=True)  # 1/omega_n
crossed = expand((m * W**2 - S * W + k * omega_n**2) / omega_n**2).subs(omega_n, 1 / lag)
undelayed = {lag: 0, W: k / m}
assert crossed.subs(undelayed) == 0
moved = -(diff(crossed, lag) / diff(crossed, W)).subs(undelayed)  # dW/dlag
assert is_zero(moved / (2 * k / m) - zeta * b / m)  # d omega/omega = dW/(2 W)

# %% [markdown]
# ## 6. The paper's numbers, and every root
#
# $m = 1.8$ kg, $b = 15$ Ns/m, $k = 100$ N/m, $\omega_n = 80$ rad/s, $\zeta = 1/2$, $c = 10$ %, from 0 to 15 rad/s. A
# threshold is exceeded where $(\text{top of } \Re\Delta H)^2 > c^2 |H_{env}|^2 D^2$: a polynomial in $W$ with rational
# coefficients, of degree six.

# %%
NUMBERS = {m: Rational("1.8"), b: 15, k: 100, omega_n: 80, zeta: Rational("0.5"), c: Rational("0.1")}
END = 15


def polynomial(form: Expr) -> Poly:
    """An even polynomial of omega with the paper's numbers, in W = omega^2."""
    return Poly(in_W(form.subs(NUMBERS)), W, domain="QQ")


def top_over(form: Expr, denominator: Expr) -> Expr:
    """The numerator of a form over a denominator known to be positive."""
    top, bottom = fraction(cancel(together(form * denominator)))
    assert bottom == 1
    return top


excess_real = polynomial(top_over(real, D) ** 2 - c**2 * square * D**2)
excess_imag = polynomial(top_over(imag, D) ** 2 - c**2 * square * D**2)
assert excess_real.degree() == excess_imag.degree() == 6

# %% [markdown]
# How many positive roots there are is proven first, by Sturm's theorem, and does not depend on finding them: the real
# threshold is crossed once in all, the imaginary one twice, of which once in the band. All roots are simple, so the sign
# changes at each. (Beyond the filter's range $H_{perc}$ fades away: $r_r \to 1$ but $r_i \to 0$: an odd and an even count.)

# %%
assert (excess_real.count_roots(0, END**2), excess_real.count_roots(0, None)) == (1, 1)
assert (excess_imag.count_roots(0, END**2), excess_imag.count_roots(0, None)) == (1, 2)
assert excess_real.is_sqf
assert excess_imag.is_sqf
assert [limit(r.subs(NUMBERS), omega, oo) for r in (ratio_real_squared, ratio_imag_squared)] == [1, 0]

# %% [markdown]
# Then they are computed to 60 digits, and each is proven to 50: the polynomial, in exact rational arithmetic, has opposite
# signs $10^{-50}$ to the left and to the right. With the count above, none is missing.


# %%
def frequencies(polynomial: Poly) -> list[Expr]:
    """The square roots of all positive roots, proven to 50 decimals."""
    roots = [root for root in polynomial.nroots(n=64, maxsteps=500) if root.is_real and root > 0]
    found = [sqrt(root).evalf(60) for root in roots]
    assert len(found) == polynomial.count_roots(0, None)
    for value in found:
        left, right = (Rational(str(value)) + side * Rational(10) ** -50 for side in (-1, 1))
        assert polynomial.eval(left**2) * polynomial.eval(right**2) < 0
    return sorted(found)


def rounded(value: Expr, digits: int) -> str:
    """A number to so many significant digits."""
    return str(value.evalf(digits))


[crossing_real] = frequencies(excess_real)
crossing_imag, crossing_imag_back = frequencies(excess_imag)
assert rounded(crossing_real, 18) == "7.97891679017470770"  # the paper: 8
assert rounded(crossing_imag, 18) == "11.9373109243220578"  # the paper: 12
assert rounded(crossing_imag_back, 18) == "156.245841062892840"  # far beyond the band

spring_environment, spring_perceived = polynomial(A), polynomial(A * P + B * Q)
[turn_environment] = frequencies(spring_environment)
turn_perceived, turn_perceived_back = frequencies(spring_perceived)
assert rounded(turn_environment, 3) == "7.45"  # the paper: 7.45
assert rounded(turn_environment, 12) == rounded(changeover_environment.subs(NUMBERS), 12) == "7.45355992500"
assert rounded(turn_perceived, 12) == rounded(changeover_perceived.subs(NUMBERS), 12) == "7.87948122919"
assert rounded(turn_perceived_back, 6) == "75.6756"

for name, value in {
    "r_r = c": crossing_real,
    "r_i = c": crossing_imag,
    "r_i = c again": crossing_imag_back,
    "Re H_env = 0": turn_environment,
    "Re H_perc = 0": turn_perceived,
}.items():
    print(f"{name:14} {rounded(value, 30):>32} rad/s")

# %% [markdown]
# ## 7. What section 3 says, on whole intervals
#
# A polynomial without a root on a closed interval keeps its sign there; so one Sturm count and one value prove a statement
# for *all* frequencies of the interval. Where an interval ends at an irrational crossing, a rational number close to it
# is taken: the crossing is the only root around, so that nothing is lost in between.


# %%
def sign_on(low: Expr | int | str, high: Expr | int | str, polynomial: Poly) -> int:
    """The sign of a polynomial in W for all low <= omega <= high, proven."""
    ends = Rational(low) ** 2, Rational(high) ** 2
    assert polynomial.count_roots(*ends) == 0
    return int(sign(polynomial.eval(ends[1])))


# %% [markdown]
# **"... the rendered dynamics will be perceived to be the same as the environment dynamics only if both $r_r$ and $r_i$ are
# below 10%."** Both are, from 0 up to 7.97891...; and from there on, all the way to 15 rad/s, $r_r$ is above. So the
# "bandwidth of perceptual transparency" is 7.979 rad/s. From 11.9373... on, $r_i$ is above too.

# %%
below, above = Rational("7.9789167"), Rational("7.9789168")
assert below < crossing_real < above
assert sign_on(0, below, excess_real) == -1
assert sign_on(above, END, excess_real) == 1
assert sign_on(0, above, excess_imag) == -1
assert sign_on(0, "11.9373109", excess_imag) == -1
assert sign_on("11.9373110", END, excess_imag) == 1

# %% [markdown]
# **"The two systems both exhibit spring behaviors at relatively low frequencies and exhibit inertia behavior at higher
# frequencies"**, with one changeover each in the band; and both resist the velocity throughout, so that eq. (6) applies
# ($\Im H_{perc}$ has the sign of $BP - AQ = \omega(bP - 2\zeta\omega_n A)$). **"However, the rendered dynamics ...
# deviate more ... as frequency increases"**: $|\Delta H|$ grows without a pause, at all frequencies.

# %%
damping_perceived = polynomial(b * P - 2 * zeta * omega_n * A)
for spring, turn in ((spring_environment, turn_environment), (spring_perceived, turn_perceived)):
    assert spring.count_roots(0, END**2) == 1
    assert spring.eval(0) > 0 > spring.eval(END**2)
    assert 0 < turn < END
assert sign_on(0, END, damping_perceived) == 1


def growth(top: Expr, bottom: Expr) -> Poly:
    """A polynomial in W with the sign of the derivative of top/bottom."""
    above, below = polynomial(top), polynomial(bottom)
    return above.diff() * below - above * below.diff()


deviation = square * omega**2 * (omega**2 + (2 * zeta * omega_n) ** 2)
assert is_zero(deviation / D - real**2 - imag**2)
assert growth(deviation, D).count_roots(0, None) == 0
assert growth(deviation, D).eval(0) > 0

# %% [markdown]
# **"... the frequency from which the difference in the real part starts to exceed the threshold is higher than the changeover
# frequency of the environment. This means that the stiffness of the environment is preserved ..."** True: where the
# environment is a spring, nothing is noticed. But the paper does not say that the changeover moves, from 7.4536 to 7.8795 rad/s:
# between the two the environment is inertia and the hand feels a spring. That, too, goes unnoticed, because the crossing comes
# later still, at 7.9789. So no stiffness is ever noticed as changed, and none is noticed that is not there.

# %%
witness = Rational("7.9")
assert sign_on(witness, END, spring_environment) == -1
assert sign_on(witness, END, spring_perceived) == -1
assert sign_on(0, witness, excess_real) == -1
assert turn_environment < turn_perceived < witness < crossing_real
assert sign_on("7.46", "7.87", spring_environment) == -1
assert sign_on("7.46", "7.87", spring_perceived) == 1

# %% [markdown]
# **"... the perceived mass will be different from the mass of the environment for most of the time"**: on 93 % of the
# frequencies at which the environment is inertia. **"... will lead the operator to always perceive the environment mass as
# smaller"**: $\Re H_{env} < \Re H_{perc} < 0$ from the crossing to 15 rad/s. ($\Re\Delta H$ is positive at *every*
# frequency, so below the changeovers the hand feels a little more stiffness, unnoticed.)

# %%
more_real = polynomial(top_over(real, D) / omega**2)
assert more_real.count_roots(0, None) == 0
assert more_real.eval(0) > 0
assert sign_on(witness, END, spring_perceived) == sign_on(witness, END, spring_environment) == -1
share = (END - crossing_real) / (END - turn_environment)
assert rounded(share, 2) == "0.93"

# %% [markdown]
# **"... the rendered dynamics always have larger projections on the imaginary axis ... a higher damping"**:
# $\Im H_{perc} > \Im H_{env} > 0$ on all of 11.937 to 15 rad/s, where it is noticed, and already from 7.457 rad/s. Below that
# the damping felt is *lower* (at 0 by $2\zeta k/\omega_n = 1.25$ Ns/m out of 15), but $r_i$ stays below 3.9 % there.

# %%
more_imag = polynomial(top_over(imag, D) / omega)
turn_damping, turn_damping_back = frequencies(more_imag)
assert rounded(turn_damping, 8) == "7.4569351"
assert turn_damping_back > END
assert sign_on("7.457", END, more_imag) == 1
assert sign_on(0, "7.456", more_imag) == -1
assert limit(imag / omega, omega, 0) == -2 * zeta * k / omega_n
assert (2 * zeta * k / omega_n).subs(NUMBERS) == Rational("1.25")
low_excess = polynomial(top_over(imag, D) ** 2 - Rational("0.039") ** 2 * square * D**2)
assert sign_on(0, "7.457", low_excess) == -1

# %% [markdown]
# ## 8. What the rounding hides
#
# At "8 rad/s" the display is no longer transparent, and at "12 rad/s" the damping is already felt as higher: a bandwidth
# should be rounded down. Between 7.9789 and 8 rad/s the real threshold is exceeded, if only just: $r_r(8) = 10.02$ %.
#
# For $r_r$ is flat. It grows through the whole band, but only to 11.62 % at 15 rad/s, so that the "approximately" of
# $c \approx 10$ % (eq. 4) matters far more than the rounding:
#
# | $c$ | $r_r > c$ from, rad/s | $r_i > c$ from, rad/s | |
# |---|---|---|---|
# | 9 % | 7.1614 | 11.434 | stiffness is noticed as higher, from below the changeover of the environment |
# | 9.85 % | 7.8356 | 11.861 | mass is noticed as stiffness, up to 7.8795 rad/s |
# | 10 % | 7.9789 | 11.937 | the paper's statements |
# | 11 % | 9.4112 | 12.457 | the same |
# | 12 % | not in the band | 12.993 | nothing is noticed about the mass |
#
# As $r_r$ grows, its crossing lies above a changeover exactly if $c$ is larger than $r_r$ there: 9.398 % at that of the
# environment and 9.897 % at that of the perceived dynamics. So the stiffness of the environment is preserved with 0.6
# percentage point to spare, but only 0.1 keeps the mass from being noticed as a stiffness that is not there.


# %%
top_real, top_imag = top_over(real, D), top_over(imag, D)


def excess(top: Expr, threshold: str) -> Poly:
    """The threshold polynomial for another c."""
    return polynomial(top**2 - Rational(threshold) ** 2 * square * D**2)


def percent(ratio_squared: Expr, frequency: Expr | int) -> str:
    """A ratio at a frequency, in per cent."""
    return rounded(100 * sqrt(ratio_squared.subs(NUMBERS).subs(omega, frequency)), 4)


assert excess_real.eval(8**2) > 0
assert excess_imag.eval(12**2) > 0
assert percent(ratio_real_squared, 8) == "10.02"
assert percent(ratio_imag_squared, 12) == "10.12"
assert percent(ratio_real_squared, END) == "11.62"

growth_real = growth(top_real**2, square * D**2)
assert growth_real.count_roots(0, END**2) == 1
assert growth_real.eval(0) == 0  # the one root is where r_r starts
assert growth_real.eval(END**2) > 0
assert percent(ratio_real_squared, turn_environment) == "9.398"
assert percent(ratio_real_squared, turn_perceived) == "9.897"

starts = {
    threshold: [rounded(frequencies(excess(top, threshold))[0], 5) for top in (top_real, top_imag)]
    for threshold in ("0.09", "0.0985", "0.10", "0.11", "0.12")
}
assert starts["0.09"] == ["7.1614", "11.434"]
assert starts["0.0985"] == ["7.8356", "11.861"]
assert starts["0.10"] == ["7.9789", "11.937"]
assert starts["0.11"] == ["9.4112", "12.457"]
assert starts["0.12"] == ["20.530", "12.993"]

# %% [markdown]
# ## 9. Three near-synonyms, three answers
#
# | name | meets 10 % at, rad/s |
# |---|---|
# | distortion ratios $r_r$; $r_i$, which the JND judges | 7.979; 11.937, 156.246 |
# | relative distortion $\Re(\Delta H/H_{env})$; $\Im(\Delta H/H_{env})$ | 42.511; 7.922316, 182.339 |
# | its modulus $\lvert\Delta H/H_{env}\rvert$ | 7.922312 |
#
# The relative distortion is $G - 1$: it does not know the environment, and judged by its parts the same filter would be
# transparent, in the real part, to 42.5 rad/s. The ratios are the same arrow $G - 1$ turned by the phase of $H_{env}$. At
# $\sqrt{k/m}$ that is a quarter turn, so that there $r_r = |\Im(G - 1)|$ and $r_i = |\Re(G - 1)|$: the two parts have changed
# places. That is why the crossing of $r_r$ at 7.979 has its neighbour, 7.922, in the *imaginary* part of the relative
# distortion. The modulus bounds both ratios: below 7.9223 rad/s this filter is transparent for every environment whatever.

# %%
[relative_real_crossing] = frequencies(polynomial(top_over(relative_real, D) ** 2 - c**2 * D**2))
relative_imag_crossings = frequencies(polynomial(top_over(relative_imag, D) ** 2 - c**2 * D**2))
excess_modulus = polynomial(top_over(relative_squared, D) - c**2 * D)
[modulus_crossing] = frequencies(excess_modulus)
assert rounded(relative_real_crossing, 5) == "42.511"
assert [rounded(value, 7) for value in relative_imag_crossings] == ["7.922316", "182.3392"]
assert rounded(modulus_crossing, 7) == "7.922312"
assert sign_on(0, "7.9223", excess_modulus) == -1

quarter_turn = {omega: changeover_environment}
assert is_zero((ratio_real_squared - relative_imag**2).subs(quarter_turn))
assert is_zero((ratio_imag_squared - relative_real**2).subs(quarter_turn))

# %% [markdown]
# ## 10. The package says the same
#
# Only now the package is asked. Each closed form minus the one derived above is exactly zero. (Where a modulus is a square
# root, the squares are compared: both sides are positive. And $|z|^2 = z^2$ for the real $z$ in the ratios; SymPy does not
# see by itself that they are real, because it does not see that $D$, multiplied out, is positive.)

# %%
import haptisym as hs


def squared(ratio: Expr) -> Expr:
    """The square of a product in which moduli of real forms are factors."""
    assert ratio.is_Mul
    return ratio.replace(Abs, lambda z: z) ** 2


d = hs.distort(hs.environments.mass_spring_damper(m, b, k), hs.effects.second_order_lowpass(omega_n, zeta))
env, perc, jnd = d.environment_properties, d.perceived_properties, d.parameter_jnd(c)

for name, derived, packaged in [
    ("H_env", H_env, d.environment),
    ("H_perc", H_perc, d.perceived),
    ("dH", dH, d.distortion),
    ("Re dH", real, d.real),
    ("Im dH", imag, d.imag),
    ("r_r^2", squared(ratio_real), squared(d.ratio_real)),
    ("r_i^2", squared(ratio_imag), squared(d.ratio_imag)),
    ("Re dH/H_env", relative_real, d.relative_real),
    ("Im dH/H_env", relative_imag, d.relative_imag),
    ("|H_env|^2", square, d.modulus**2),
    ("changeover of H_env", changeover_environment, d.changeover_environment),
    ("changeover of H_perc, squared", changeover_perceived**2, d.changeover_perceived**2),
    ("Re H_env", A, env.real),
    ("Im H_env", B, env.imag),
    ("Re H_perc", perceived_real, perc.real),
    ("Im H_perc", perceived_imag, perc.imag),
    ("stiffness", A, env.stiffness),
    ("stiffness felt", perceived_real, perc.stiffness),
    ("mass", -A / omega**2, env.mass),
    ("mass felt", -perceived_real / omega**2, perc.mass),
    ("damping", B / omega, env.damping),
    ("damping felt", perceived_imag / omega, perc.damping),
    ("spring or inertia force", spring_inertia_force, env.spring_inertia_force),
    ("spring or inertia force felt", X * perceived_real, perc.spring_inertia_force),
    ("damping force", damping_force, env.damping_force),
    ("damping force felt", I * X * perceived_imag, perc.damping_force),
    ("JND of k, squared", jnd_stiffness**2, jnd.stiffness**2),
    ("JND of b, squared", jnd_damping**2, jnd.damping**2),
    ("JND of m, squared", jnd_mass**2, jnd.mass**2),
]:
    assert is_zero(derived - packaged), name

both_negative = {m: 1, b: Rational("0.01"), k: 100, omega_n: 80, zeta: 2, omega: 1}
assert max(form.subs(both_negative) for form in (real, imag)) < 0
assert min(form.subs(both_negative) for form in (d.ratio_real, d.ratio_imag)) > 0

# %% [markdown]
# And the evaluation of the paper's scene has the same crossings to 40 digits, no other ones, and the same percepts; on a wider
# band it finds the return at 156.2 and the changeover at 75.7 rad/s.

# %%
from haptisym import Change, CrossingKind, Part, Property

scene = hs.load_scene("fu2019")
result = hs.evaluate(scene, digits=40)
wide = hs.evaluate(scene.with_band(0, 200), digits=40)
EXCEEDS, RETURNS = CrossingKind.EXCEEDS, CrossingKind.RETURNS

expected = [  # the sign is that of Re dH, positive everywhere, or of Im dH, positive between its zeros at 7.457 and 247.8
    (Part.REAL, EXCEEDS, 1, 1, rounded(crossing_real, 40)),
    (Part.IMAG, EXCEEDS, 1, 1, rounded(crossing_imag, 40)),
    (Part.IMAG, RETURNS, 1, 1, rounded(crossing_imag_back, 40)),
]
assert turn_damping < crossing_imag < crossing_imag_back < turn_damping_back


def described(found: hs.Evaluation) -> list[tuple[Part, CrossingKind, int, int, str]]:
    """The crossings of an evaluation."""
    return [(x.part, x.kind, x.sign, x.multiplicity, x.omega.digits(40)) for x in found.crossings]


assert described(result) == expected[:2]
assert described(wide) == expected
assert [x["digits"] for x in result.to_dict()["crossings"]] == [digits for *_, digits in expected[:2]]

assert result.bandwidth.digits(40) == rounded(crossing_real, 40)
assert [(x.low.omega.digits(40), x.high.omega.digits(40)) for x in result.transparent] == [
    ("0", rounded(crossing_real, 40))
]
assert [x.omega.digits(40) for x in result.changeovers_environment] == [rounded(turn_environment, 40)]
assert [x.omega.digits(40) for x in result.changeovers_perceived] == [rounded(turn_perceived, 40)]
assert [x.omega.digits(40) for x in wide.changeovers_perceived] == [
    rounded(turn, 40) for turn in (turn_perceived, turn_perceived_back)
]
assert [
    (x.part, x.property, x.change, x.band.low.omega.digits(40), x.band.high.omega.digits(2)) for x in result.percepts
] == [
    (Part.REAL, Property.MASS, Change.LOWER, rounded(crossing_real, 40), "15"),
    (Part.IMAG, Property.DAMPING, Change.HIGHER, rounded(crossing_imag, 40), "15"),
]
assert (result.outside_model, result.unbounded, result.stable) == ((), (), True)

# %% [markdown]
# With the other thresholds of section 8 it finds what the table says, in the order of frequency.

# %%
MASS, DAMPING = (Part.REAL, Property.MASS, Change.LOWER), (Part.IMAG, Property.DAMPING, Change.HIGHER)

for threshold, percepts in {
    "0.09": [
        (Part.REAL, Property.STIFFNESS, Change.HIGHER),
        (Part.REAL, Property.MASS_TO_STIFFNESS, Change.HIGHER),
        (Part.REAL, Property.MASS_TO_STIFFNESS, Change.LOWER),
        MASS,
        DAMPING,
    ],
    "0.0985": [(Part.REAL, Property.MASS_TO_STIFFNESS, Change.LOWER), MASS, DAMPING],
    "0.11": [MASS, DAMPING],
    "0.12": [DAMPING],
}.items():
    other = hs.evaluate(replace(scene, threshold=hs.Threshold.of(threshold)))
    assert [(x.part, x.property, x.change) for x in other.percepts] == percepts
    assert [x.omega.digits(5) for x in other.crossings if x.part is Part.IMAG] == starts[threshold][1:]

# %% [markdown]
# ## 11. Formulas and figure

# %%
from matplotlib.figure import Figure
from numpy import linspace
from sympy import lambdify

from haptisym import latex

output = Path(next((given for given in sys.argv[1:2] if not given.startswith("-")), "derived"))
output.mkdir(parents=True, exist_ok=True)

formulas = {
    r"H_{env}(s)": H_env,
    r"H_{perc}(s)": H_perc,
    r"\Re\,\Delta H": real,
    r"\Im\,\Delta H": imag,
    r"\lvert H_{env} \rvert^2": square,
    r"\Re\frac{\Delta H}{H_{env}}": relative_real,
    r"\Im\frac{\Delta H}{H_{env}}": relative_imag,
    r"\Re H_{perc}": perceived_real,
    r"\Im H_{perc}": perceived_imag,
    r"r_r": ratio_real,
    r"r_i": ratio_imag,
    r"\omega_{env}": changeover_environment,
    r"\omega_{perc}": changeover_perceived,
}
formulas_tex = [f"{name} &= {latex(form)}" for name, form in formulas.items()]
(output / "01_paper_example.tex").write_text(
    "\\begin{align}\n" + " \\\\\n".join(formulas_tex) + "\n\\end{align}\n", encoding="utf-8"
)

# %% [markdown]
# The figure repeats the paper's fig. 5 (left) and looks closer at its "8 rad/s" (right).

# %%
figure = Figure(figsize=(7.0, 2.9), layout="constrained")
overview, detail = figure.subplots(1, 2)
curves = [
    ("$r_r$", "-", lambdify(omega, sqrt(ratio_real_squared.subs(NUMBERS)), "numpy"), crossing_real),
    ("$r_i$", "--", lambdify(omega, sqrt(ratio_imag_squared.subs(NUMBERS)), "numpy"), crossing_imag),
]
for axes, low, high in ((overview, 0, END), (detail, 7.2, 8.4)):
    grid = linspace(low, high, 601)
    axes.axvspan(low, float(crossing_real), color="0.9", lw=0)
    axes.axhline(10, color="0.3", lw=0.8, ls=":")
    for label, style, curve, crossing in curves:
        axes.plot(grid, 100 * curve(grid), style, color="k", lw=1.2, label=label)
        if low < crossing < high:
            point = (float(crossing), 10)
            axes.plot(*point, "o", color="k", ms=4)
            axes.annotate(rounded(crossing, 5), point, (5, -11), textcoords="offset points", fontsize=8)
    axes.set(xlim=(low, high), xlabel=r"$\omega$ (rad/s)", ylabel="distortion ratio (%)")
overview.set(ylim=(0, 16))
overview.legend(loc="lower right", frameon=False)
detail.set(ylim=(9, 10.6), xticks=[7.2, 7.4, 7.6, 7.8, 8, 8.2, 8.4])
for turn, label in ((turn_environment, r"$\Re H_{env} = 0$"), (turn_perceived, r"$\Re H_{perc} = 0$")):
    place = (float(turn), 10.55)
    detail.axvline(float(turn), color="0.5", lw=0.8)
    detail.annotate(label, place, (-2, 0), textcoords="offset points", rotation=90, ha="right", va="top", fontsize=8)
figure.savefig(output / "01_paper_example.pdf", metadata={"CreationDate": None})
