r"""How small a change of the natural frequency can be felt: c zeta at resonance, and what lies around it.

Claim. Let stiffness and mass change so that the natural frequency grows by the factor 1 + delta,

    k -> k (1 + delta)^(1 + kappa),    m -> m (1 + delta)^(kappa - 1),    b as it is

(kappa = 1: by the stiffness alone; -1: by the mass alone; 0: by both, sqrt(k m) as it is). Moved at resonance the change is
noticed from delta = c zeta on, to first order whatever kappa is; to second order from c zeta - (kappa - 1/2) (c zeta)^2 on, and
exactly from sqrt(1 + 2 c zeta) - 1, 1/sqrt(1 - 2 c zeta) - 1 or c zeta + sqrt(1 + (c zeta)^2) - 1 on. Moved at x = omega/omega_n,
to first order from

    delta = c sqrt((1 - x^2)^2 + (2 zeta x)^2)/|1 + kappa + (1 - kappa) x^2|

on, for which c zeta sqrt((1 - zeta^2)/(1 - zeta^2 (1 - kappa^2))) is the least value: at resonance itself if kappa = 0. Slow
movement has c/(1 + kappa) instead, whatever zeta is. The JNDs of stiffness, mass and damping are the cases of one parameter.
With c = 10 % the 3.99 to 6.96 % of Li et al. (2008) are those of zeta from 0.40 to 0.70, if felt at resonance.

Assumptions. Linear, m, b, k > 0; a steady sinusoidal movement of one frequency, the same before and after the change; eq. (4)
with the H before the change, c the same for both parts. Section 5 says what that leaves out.

Source. Eqs. (2) to (4) of W. Fu, M. M. van Paassen, M. Mulder, Framework for a Two-step Evaluation of Haptic Displays,
IFAC-PapersOnLine 52(19) 97-102, 2019, doi:10.1016/j.ifacol.2019.12.119. Measured: Y. Li, A. Israr, V. Patoglu, M. K. O'Malley,
Passive and Active Kinesthetic Perception Just-Noticeable-Difference for Natural Frequency of Virtual Dynamic Systems, HAPTICS
2008, doi:10.1109/HAPTICS.2008.4479908 (abstract).

Run as ``python 12_natural_frequency_jnd.py [directory]``; formulas and figure go to the directory, ``derived`` if none is
given.
"""

# %%
import sys
from pathlib import Path

from sympy import (
    Abs,
    Expr,
    I,
    Integer,
    Poly,
    Rational,
    Symbol,
    diff,
    exp,
    expand,
    fraction,
    limit,
    oo,
    series,
    sqrt,
    symbols,
    together,
)

m, b, k, omega, omega_n, zeta, c, x, W = symbols("m b k omega omega_n zeta c x W", positive=True)  # W = x^2
kappa, alpha_k, alpha_m, alpha_b = symbols("kappa alpha_k alpha_m alpha_b", real=True)
delta = Symbol("delta", real=True)
nu = Symbol("nu", positive=True)  # 1 + delta
s, t, X = symbols("s t X")


def is_zero(difference: Expr) -> bool:
    """Whether an expression is zero identically: exact, over a common denominator and multiplied out."""
    return expand(fraction(together(difference))[0]) == 0


# %% [markdown]
# ## 1. What is felt at a frequency
#
# For $x(t) = Xe^{j\omega t}$ Newton's law gives $H = k - m\omega^2 + jb\omega$. With $\omega_n = \sqrt{k/m}$,
# $\zeta = b/(2\sqrt{km})$ and $x = \omega/\omega_n$, measured in $k$: $H/k = 1 - x^2 + 2j\zeta x$, $|H|^2/k^2 = S$. At
# resonance spring and mass cancel, $|H| = b\omega_n = 2\zeta k$.

# %%
motion = X * exp(I * omega * t)
force = m * motion.diff(t, 2) + b * motion.diff(t) + k * motion
H = k - m * omega**2 + I * b * omega
IN_RATIOS = {k: m * omega_n**2, b: 2 * zeta * m * omega_n, omega: x * omega_n}
S = (1 - x**2) ** 2 + (2 * zeta * x) ** 2
assert is_zero(force / motion - H)
assert is_zero((H / k).subs(IN_RATIOS) - (1 - x**2) - 2 * I * zeta * x)
assert is_zero(S.subs(x, 1) - (2 * zeta) ** 2)

# %% [markdown]
# ## 2. Any small change of the three parameters
#
# Let $k$, $m$ and $b$ grow by the fractions $\alpha_k\delta$, $\alpha_m\delta$ and $\alpha_b\delta$. $H$ is linear in them, so
# $\Re\Delta H/k = \delta\,(\alpha_k - \alpha_mx^2)$ and $\Im\Delta H/k = \delta\,2\zeta x\,\alpha_b$. By eq. (4) the first is
# noticed from $\delta = c\sqrt S/|\alpha_k - \alpha_mx^2|$ on and the second from $c\sqrt S/(2\zeta x|\alpha_b|)$ on. One
# parameter at a time, times that parameter, these are the JNDs $c|H|$, $c|H|/\omega^2$ and $c|H|/\omega$ (derivation 06).

# %%
grown = {k: k * (1 + alpha_k * delta), m: m * (1 + alpha_m * delta), b: b * (1 + alpha_b * delta)}
change = (H.subs(grown, simultaneous=True) - H) / k
assert is_zero(change.subs(IN_RATIOS) - delta * (alpha_k - alpha_m * x**2) - I * delta * 2 * zeta * x * alpha_b)

by_real = c * sqrt(S) / Abs(alpha_k - alpha_m * x**2)
by_imag = c * sqrt(S) / (2 * zeta * x * Abs(alpha_b))
modulus = k * sqrt(S)  # |H|
alone = {alpha_k: 0, alpha_m: 0, alpha_b: 0}
jnd_stiffness = k * by_real.subs({**alone, alpha_k: 1})
jnd_mass = m * by_real.subs({**alone, alpha_m: 1})
jnd_damping = b * by_imag.subs({**alone, alpha_b: 1})
for jnd, power in ((jnd_stiffness, 0), (jnd_damping, 1), (jnd_mass, 2)):
    assert is_zero((jnd - c * modulus / omega**power).subs(IN_RATIOS))

# %% [markdown]
# ## 3. The natural frequency
#
# $\omega_n = \sqrt{k/m}$ grows by $\delta$ if $\alpha_k - \alpha_m = 2$: by $\alpha_k = 1 + \kappa$, $\alpha_m = \kappa - 1$,
# with any $\kappa$. The real part is noticed from $\delta = c\sqrt S/|1 + \kappa + (1 - \kappa)x^2|$ on. At $x = 1$ the
# denominator is 2 for every $\kappa$: $\delta = c\zeta$. There it does not matter *how* the natural frequency was changed; a
# change of $k$ and $m$ alike is not felt at all.

# %%
on_path = {k: k * nu ** (1 + kappa), m: m * nu ** (kappa - 1)}
assert (k / m).subs(on_path, simultaneous=True).powsimp() == nu**2 * k / m
rate = diff((H.subs(on_path, simultaneous=True) / k).subs(IN_RATIOS), nu).subs(nu, 1)
assert is_zero(rate - (1 + kappa + (1 - kappa) * x**2))

noticed = c * sqrt(S) / Abs(1 + kappa + (1 - kappa) * x**2)
at_resonance = c * zeta
general = by_real.subs({alpha_k: 1 + kappa, alpha_m: kappa - 1})
assert is_zero((general**2 - noticed**2).replace(Abs, lambda z: z))
assert is_zero(noticed.subs(x, 1) - at_resonance)
assert is_zero(noticed.subs({x: 1, kappa: Rational(7, 3)}) - at_resonance)
assert is_zero((jnd_stiffness / (2 * k)).subs(x, 1) - at_resonance)
assert is_zero((jnd_mass / (2 * m)).subs(x, 1) - at_resonance)

# %% [markdown]
# The damping may change with it, by $\alpha_b\delta$. At resonance that is noticed from $c/|\alpha_b|$ on, later than $c\zeta$
# as long as $|\alpha_b| < 1/\zeta$. With the damping ratio kept, $b \sim \sqrt{km}$, that is $\alpha_b = \kappa$.

# %%
assert (k * m).subs(on_path, simultaneous=True).powsimp() == nu ** (2 * kappa) * k * m
assert diff(sqrt(nu ** (2 * kappa)), nu).subs(nu, 1) == kappa
assert is_zero(by_imag.subs(x, 1) - c / Abs(alpha_b))

# %% [markdown]
# **Exactly**, for a change that is not small: with $u = c\zeta$, at resonance,
# $(1 + \delta)^\kappa\left((1 + \delta) - \frac1{1 + \delta}\right) = 2u$. The left side is
# $2\delta + (2\kappa - 1)\delta^2 + O(\delta^3)$, so $\delta = u - (\kappa - \frac12)u^2 + O(u^3)$. A decrease is the same with
# $u$ and $\delta$ negative. Without a second-order term is $\kappa = 1/2$; in closed form are
#
# | | changed by | noticed from | remainder against $u$ |
# |---|---|---|---|
# | $\kappa = 1$ | the stiffness | $\sqrt{1 + 2u} - 1$ | between $-u^2/2$ and $-u^2/2 + u^3/2$ |
# | $\kappa = 0$ | both | $u + \sqrt{1 + u^2} - 1$ | between $u^2/2 - u^4/8$ and $u^2/2$ |
# | $\kappa = -1$ | the mass | $1/\sqrt{1 - 2u} - 1$ | between $3u^2/2$ and $3u^2/2 + 5u^3$ (for $u \le 1/5$) |

# %%
u = Symbol("u", positive=True)
factor_change = nu**kappa * (nu - 1 / nu)
real_change = ((H.subs(on_path, simultaneous=True) - H) / k).subs(IN_RATIOS).subs(x, 1)
assert (real_change - factor_change).expand() == 0

exact_change = factor_change.subs(nu, 1 + delta)
second_order = u - (kappa - Rational(1, 2)) * u**2
assert is_zero(series(exact_change, delta, 0, 3).removeO() - 2 * delta - (2 * kappa - 1) * delta**2)
assert is_zero(series(exact_change.subs(delta, second_order), u, 0, 3).removeO() - 2 * u)

BY_STIFFNESS, BY_BOTH, BY_MASS = Integer(1), Integer(0), Integer(-1)
exactly = {BY_STIFFNESS: sqrt(1 + 2 * u) - 1, BY_BOTH: u + sqrt(1 + u**2) - 1, BY_MASS: 1 / sqrt(1 - 2 * u) - 1}
for path, form in exactly.items():
    assert is_zero(exact_change.subs({kappa: path, delta: form}) - 2 * u)
    assert is_zero(series(form, u, 0, 3).removeO() - second_order.subs(kappa, path))

# %% [markdown]
# The remainders: each change grows with $\delta$, so a $\delta$ at which it is less than $2u$ is a lower bound, and one at which
# it is more an upper bound. Their differences from $2u$ are rational, with a sign that Sturm's theorem tells.

# %%
bounds = {
    BY_STIFFNESS: (u - u**2 / 2, u - u**2 / 2 + u**3 / 2),
    BY_BOTH: (u + u**2 / 2 - u**4 / 8, u + u**2 / 2),
    BY_MASS: (u + 3 * u**2 / 2, u + 3 * u**2 / 2 + 5 * u**3),
}
SMALL = Rational(1, 5)
for path, (low, high) in bounds.items():
    growth = diff(exact_change.subs(kappa, path), delta).subs(delta, u)
    assert all(coefficient > 0 for coefficient in Poly(fraction(together(growth))[0].expand(), u).coeffs())
    for bound, sign in ((low, -1), (high, 1)):
        excess = Poly(expand(fraction(together(exact_change.subs({kappa: path, delta: bound}) - 2 * u))[0]), u)
        lowest = min(power for (power,) in excess.monoms())
        reduced = excess.quo(Poly(u**lowest, u))  # the root at u = 0 taken out
        assert reduced.count_roots(0, SMALL) == 0
        assert reduced.eval(SMALL) * sign > 0

half = {u: Rational("0.05")}  # c = 10 %, zeta = 0.5
assert [f"{float(100 * form.subs(half)):.2f}" for form in exactly.values()] == ["4.88", "5.12", "5.41"]
assert [f"{float(100 * form.subs(u, -u).subs(half)):.2f}" for form in exactly.values()] == ["-5.13", "-4.88", "-4.65"]

# %% [markdown]
# ## 4. Away from resonance
#
# With $p = 1 + \kappa$, $q = 1 - \kappa$, $e = 1 - 2\zeta^2$ and $W = x^2$, $\delta^2/c^2 = (W^2 - 2eW + 1)/(p + qW)^2$ has one
# extreme, where $W(p + eq) = q + ep$, and with $N = p^2 + q^2 + 2epq$
#
# $$\frac{\delta^2}{c^2} = \frac{1 - e^2}{N} + \frac{\left((p + eq)W - (q + ep)\right)^2}{N\,(p + qW)^2}:$$
#
# nothing less anywhere, and at that place, if it is at $W > 0$, just
# $\delta = c\zeta\sqrt{(1 - \zeta^2)/(1 - \zeta^2(1 - \kappa^2))}$.
#
# * $\kappa = 0$: at resonance itself, whatever $\zeta$; $\delta = c\zeta$.
# * $\kappa = 1$ and $-1$: at $x^2 = 1 - 2\zeta^2$ and its inverse; $\delta = c\zeta\sqrt{1 - \zeta^2}$ (derivation 06).
#
# So resonance is never off the best by more than the factor $\sqrt{1 - \zeta^2}$, for $|\kappa| \le 1$. Far from it, $\delta$
# tends to $c/(1 + \kappa)$ for slow and $c/(1 - \kappa)$ for fast movement, whatever $\zeta$: half the JND of a spring or of a
# mass.

# %%
p, q, e = 1 + kappa, 1 - kappa, 1 - 2 * zeta**2
N = p**2 + q**2 + 2 * e * p * q
squared = (W**2 - 2 * e * W + 1) / (p + q * W) ** 2
best = (q + e * p) / (p + e * q)
least = c * zeta * sqrt((1 - zeta**2) / (1 - zeta**2 * (1 - kappa**2)))
assert is_zero((noticed**2).replace(Abs, lambda z: z) - c**2 * squared.subs(W, x**2))
assert is_zero(squared - (1 - e**2) / N - ((p + e * q) * W - (q + e * p)) ** 2 / (N * (p + q * W) ** 2))
assert is_zero(N - 4 * (1 - zeta**2 * (1 - kappa**2)))
assert is_zero(c**2 * (1 - e**2) / N - least**2)
assert is_zero(c**2 * squared.subs(W, best) - least**2)
assert (best.subs(kappa, 0).cancel(), least.subs(kappa, 0)) == (1, at_resonance)
for path, place in ((1, e), (-1, 1 / e)):
    assert is_zero(best.subs(kappa, path) - place)
    assert is_zero(least.subs(kappa, path) ** 2 - (c * zeta) ** 2 * (1 - zeta**2))
assert is_zero((c * zeta) ** 2 - least**2 - least**2 * zeta**2 * kappa**2 / (1 - zeta**2))
assert limit(squared, W, 0) == 1 / p**2
assert is_zero(limit(squared.subs(kappa, Rational(1, 3)), W, oo) - (1 / q**2).subs(kappa, Rational(1, 3)))

# %% [markdown]
# ## 5. What Li et al. measured
#
# A JND of 3.99 to 6.96 % for natural frequencies of 1 and 2 Hz. At resonance, with $c$ = 10 %, these are the $\zeta$ from 0.40
# to 0.70; and no large bias was found between systems of the same natural frequency and different stiffness, as section 3 says.
# But this confirms nothing:
#
# * The abstract does not say $\zeta$, nor at which frequency people moved. A stiffness felt in slow movement has the same 5 %,
#   $c/2$, at any $\zeta$; so has a mass in fast movement.
# * People could move each system at its *own* resonance. Then $H = jb\omega_n$ before and $jb\omega_n(1 + \delta)$ after: real
#   parts are felt in neither, and what differs is the damping force, by the fraction $\delta$, noticed from $c$ on. It is not one
#   movement at two dynamics, though, and eq. (4) is not about that.
# * Far below $\zeta = 0.4$ the model says far less than was measured. The hand adds damping of its own, which $\zeta$ here would
#   have to contain.

# %%
TEN_PERCENT = {c: Rational("0.1")}
measured = [Rational("0.0399"), Rational("0.0696")]
assert [str((value / c).subs(TEN_PERCENT).evalf(2)) for value in measured] == ["0.40", "0.70"]
assert (noticed.subs(kappa, 1).subs(x, 0), limit(noticed.subs(kappa, -1), x, oo)) == (c / 2, c / 2)
own = {omega: sqrt(k / m)}
assert is_zero(H.subs(own) - I * b * sqrt(k / m))

# %% [markdown]
# ## 6. The package says the same
#
# Its JNDs of the three parameters; and its ratios for an environment that is rendered with another natural frequency. (Ratios
# squared: both sides are positive.)

# %%
import haptisym as hs

E = hs.environments
packaged = hs.distort(E.mass_spring_damper(m, b, k)).parameter_jnd(c)
for derived, form in ((jnd_stiffness, packaged.stiffness), (jnd_damping, packaged.damping), (jnd_mass, packaged.mass)):
    assert is_zero((derived**2 - form**2).subs(IN_RATIOS))
assert is_zero(((packaged.stiffness / (2 * k)) ** 2).subs(IN_RATIOS).subs(x, 1) - at_resonance**2)
assert is_zero(((packaged.mass / (2 * m)) ** 2).subs(IN_RATIOS).subs(x, 1) - at_resonance**2)

for path in exactly:
    after = E.mass_spring_damper(m * nu ** (path - 1), b, k * nu ** (1 + path))
    d = hs.distort(E.mass_spring_damper(m, b, k), rendered=after)
    ratio_squared = d.real**2 / d.modulus**2
    assert d.imag == 0
    assert is_zero(ratio_squared - d.ratio_real.replace(Abs, lambda z: z) ** 2)
    at_one = ratio_squared.subs(IN_RATIOS).subs(x, 1)
    assert is_zero(at_one - (exact_change.subs({kappa: path, delta: nu - 1}) / (2 * zeta)) ** 2)

# %% [markdown]
# Evaluations. A natural frequency 5 % higher, $c$ = 10 %, $\omega_n = 10$ rad/s: by the closed forms it is just noticed at
# resonance if $2u = (1 + \delta)^\kappa((1 + \delta) - 1/(1 + \delta))$, $\zeta = u/c$. The threshold is met at 10 rad/s exactly.
# A change by the stiffness is noticed from there downwards, one by the mass upwards (to 27 rad/s), one by both nowhere but from
# 9.85 to 10 rad/s. With a little more damping the change is not noticed at 10 rad/s, with a little less it is.

# %%
from haptisym import CrossingKind, Part

RAISED = Rational(21, 20)
SIDE = Rational(10) ** -9


def evaluated(path: Expr, ratio: Expr) -> hs.Evaluation:
    """The evaluation of 1 kg, 100 N/m with that damping ratio, rendered with a natural frequency 5 % higher."""
    before = E.mass_spring_damper(1, 20 * ratio, 100)
    after = E.mass_spring_damper(RAISED ** (path - 1), 20 * ratio, 100 * RAISED ** (1 + path))
    return hs.evaluate(hs.Scene(before, (), (Integer(0), Integer(40)), rendered=after), digits=20)


def noticed_at_ten(path: Expr, ratio: Expr) -> bool:
    """Whether a natural frequency 5 % higher is noticed by somebody who moves at resonance, 10 rad/s."""
    unchanged = evaluated(path, ratio).transparent
    return not any(float(band.low.omega) <= 10 <= float(band.high.omega) for band in unchanged)


EXCEEDS, RETURNS = CrossingKind.EXCEEDS, CrossingKind.RETURNS
for path, expected in {
    BY_STIFFNESS: [("10.0000", RETURNS)],
    BY_BOTH: [("9.84856", EXCEEDS), ("10.0000", RETURNS)],
    BY_MASS: [("10.0000", EXCEEDS), ("27.1514", RETURNS)],
}.items():
    ratio = exact_change.subs({kappa: path, delta: RAISED - 1}) / 2 / TEN_PERCENT[c]
    crossings = evaluated(path, ratio).crossings
    assert {crossing.part for crossing in crossings} == {Part.REAL}
    assert [(crossing.omega.digits(6), crossing.kind) for crossing in crossings] == expected
    assert 10 in [Rational(crossing.omega.digits(20)) for crossing in crossings]
    assert noticed_at_ten(path, ratio - SIDE)
    assert not noticed_at_ten(path, ratio + SIDE)

# %% [markdown]
# ## 7. Formulas and figure

# %%
from matplotlib.figure import Figure
from numpy import linspace
from sympy import lambdify

from haptisym import latex

output = Path(next((given for given in sys.argv[1:2] if not given.startswith("-")), "derived"))
output.mkdir(parents=True, exist_ok=True)

name = r"\frac{\Delta_{jnd} \omega_n}{\omega_n}"
formulas = {
    name: noticed,
    rf"{name} (\omega = \omega_n)": at_resonance,
    rf"{name} (k; \omega = \omega_n)": exactly[BY_STIFFNESS].subs(u, at_resonance),
    rf"{name} (m; \omega = \omega_n)": exactly[BY_MASS].subs(u, at_resonance),
    rf"{name} (k, m; \omega = \omega_n)": exactly[BY_BOTH].subs(u, at_resonance),
    rf"\min_\omega {name}": least,
}
formulas_tex = [f"{name} &= {latex(form)}" for name, form in formulas.items()]
(output / "12_natural_frequency_jnd.tex").write_text(
    "\\begin{align}\n" + " \\\\\n".join(formulas_tex) + "\n\\end{align}\n", encoding="utf-8"
)

# %% [markdown]
# Left, the JND at resonance over the damping ratio, exact for a rise by the stiffness, by both and by the mass, with $c\zeta$ in
# grey and the measured range as a band. Right, to first order, over the frequency of movement, for $\zeta$ = 0.5 (thick) and
# 0.25 (thin).

# %%
figure = Figure(figsize=(7.0, 2.9), layout="constrained")
resonance, elsewhere = figure.subplots(1, 2)
STYLES = {BY_STIFFNESS: ("-", "stiffness"), BY_BOTH: ("--", "both"), BY_MASS: (":", "mass")}
ratios, places = linspace(0, 1, 101), linspace(0, 2.5, 251)
for path, (style, label) in STYLES.items():
    rise = lambdify(u, 100 * exactly[path], "numpy")
    resonance.plot(
        ratios, rise(0.1 * ratios), style, color="k", lw=1.2, label=f"by the {label}".replace("the both", "both")
    )
    first_order = lambdify((x, zeta), (100 * noticed).subs(TEN_PERCENT).subs(kappa, path), "numpy")
    for ratio, width in ((0.5, 1.4), (0.25, 0.7)):
        values = first_order(places[1:], ratio)
        elsewhere.plot(places[1:], values, style, color="k", lw=width)
resonance.plot(ratios, 10 * ratios, color="0.6", lw=2.5, zorder=1)
for axes in (resonance, elsewhere):
    axes.axhspan(100 * float(measured[0]), 100 * float(measured[1]), color="0.9", lw=0, zorder=0)
resonance.set(xlim=(0, 1), ylim=(0, 12), xlabel=r"$\zeta$", ylabel=r"JND of $\omega_n$ (%)")
resonance.legend(loc="upper left", frameon=False, fontsize=8)
elsewhere.set(xlim=(0, 2.5), ylim=(0, 12), xlabel=r"$\omega/\omega_n$", ylabel=r"JND of $\omega_n$ (%)")
elsewhere.plot([1, 1], [5, 2.5], "o", color="k", ms=4)
figure.savefig(output / "12_natural_frequency_jnd.pdf", metadata={"CreationDate": None})
