r"""How fast must a low-pass be? The slowest filter that nobody notices up to a given frequency, and where it would be noticed.

Claim. A filter of frequency w is transparent for a mass-spring-damper on the whole band [0, omega_max] exactly if w >= w*, in
each case computed here. w* is a root of one of two polynomials in w: the threshold polynomial at the band's edge, or its
discriminant, whose root is a touch inside the band; which one it is, is proven by counting roots between all of them. In the
paper's example, band [0, 15 rad/s], c = 10 %, the imaginary part binds, at the edge: omega_n >= 122.355814770... rad/s (the
real part alone: 91.953106694..., at the edge too); with damping 5 instead of 15 Ns/m on [0, 9 rad/s] the real part binds by
a touch, omega_n >= 76.651304... A first-order lag has a closed form at every single frequency, for an environment of phase phi

    omega_c >= omega (-cos phi + sqrt(cos^2 phi - 4 c (sin phi + c)))/(2 c)    (r_i, 90 degrees < phi < 180 degrees),

and on a spring, a damper or a mass over the whole band omega_c >= omega_max (1 + sqrt(1 - 4 c^2))/(2 c), if c < 1/2. A delay
on any of these must be at most asin(c)/omega_max.

Assumptions. Linear; m, b, k > 0 where they are there; steady sinusoidal motion, x_h = x_e; 0 < c < 1, the same for both parts
(eq. 4); the filter's damping ratio is given.

Source. Eqs. (4), (7) to (10) of W. Fu, M. M. van Paassen, M. Mulder, Framework for a Two-step Evaluation of Haptic Displays,
IFAC-PapersOnLine 52(19) 97-102, 2019, doi:10.1016/j.ifacol.2019.12.119.

Run as ``python 10_lowpass_requirement.py [directory]``; formulas and figure go to the directory, ``derived`` if none is given.
"""

# %%
import sys
from dataclasses import dataclass
from pathlib import Path

from sympy import (
    Abs,
    Expr,
    I,
    Integer,
    Poly,
    Rational,
    Symbol,
    asin,
    cos,
    diff,
    exp,
    expand,
    fraction,
    sin,
    sqrt,
    symbols,
    together,
)

m, b, k, w, zeta, omega, c, tau = symbols("m b k w zeta omega c tau", positive=True)  # w: omega_n or omega_c
W = Symbol("W", positive=True)  # omega^2
s, t, X = symbols("s t X")


def is_zero(difference: Expr) -> bool:
    """Whether an expression is zero identically: exact, over a common denominator and multiplied out."""
    return expand(fraction(together(difference))[0]) == 0


# %% [markdown]
# ## 1. Newton's law and two filters
#
# The environment answers the motion $x = Xe^{st}$ with $f_e = m\ddot x + b\dot x + kx$. A first-order lag passes on
# $f_h$ with $\dot f_h + wf_h = wf_e$, a second-order filter $\ddot f_h + 2\zeta w\dot f_h + w^2f_h = w^2f_e$.

# %%
H = m * s**2 + b * s + k
lag, lowpass = w / (s + w), w**2 / (s**2 + 2 * zeta * w * s + w**2)
motion = X * exp(s * t)
f_e = m * motion.diff(t, 2) + b * motion.diff(t) + k * motion
assert is_zero(f_e - H * motion)
assert is_zero((lag * f_e).diff(t) + w * (lag * f_e - f_e))
assert is_zero((lowpass * f_e).diff(t, 2) + 2 * zeta * w * (lowpass * f_e).diff(t) + w**2 * (lowpass * f_e - f_e))

# %% [markdown]
# ## 2. The threshold polynomials
#
# On the axis $H = A + jB$ with $A = k - m\omega^2$, $B = b\omega$, and $\Delta H = H(G - 1)$ has the parts
#
# | | $\Re\Delta H$ | $\Im\Delta H$ | $D$ |
# |---|---|---|---|
# | lag | $-\omega^2(A - wb)/D$ | $-\omega(wA + b\omega^2)/D$ | $w^2 + \omega^2$ |
# | order 2 | $\omega^2(AU + 2\zeta w^3b)/D$ | $\omega(b\omega^2U - 2\zeta w^3A)/D$ | $(w^2 - \omega^2)^2 + (2\zeta w\omega)^2$ |
#
# with $U = (1 - 4\zeta^2)w^2 - \omega^2$. A ratio exceeds $c$ where $E = (\text{top})^2 - c^2(A^2 + B^2)D^2 > 0$, a polynomial
# in $W = \omega^2$ and $w$.

# %%
A, B = k - m * omega**2, b * omega
S = A**2 + B**2
U = (1 - 4 * zeta**2) * w**2 - omega**2
D_1, D_2 = w**2 + omega**2, (w**2 - omega**2) ** 2 + (2 * zeta * w * omega) ** 2
TOPS = {
    lag: (-(omega**2) * (A - w * b), -omega * (w * A + b * omega**2), D_1),
    lowpass: (omega**2 * (A * U + 2 * zeta * w**3 * b), omega * (b * omega**2 * U - 2 * zeta * w**3 * A), D_2),
}
for G, (real, imag, D) in TOPS.items():
    assert is_zero((H * (G - 1)).subs(s, I * omega) - (real + I * imag) / D)

EXCESS = {
    G: [expand(top**2 - c**2 * S * D**2).subs(omega, sqrt(W)) for top in (real, imag)]
    for G, (real, imag, D) in TOPS.items()
}

# %% [markdown]
# ## 3. What can go wrong on the way down
#
# Let the filter become slower, $w$ falling from infinity. At first nothing is noticed: the coefficient of the highest power of
# $w$ in $E$ is $-c^2(A^2 + B^2)$, negative on all of the band. The number of places in the band where $r = c$ changes only
# where one comes in over an end of the band or two appear at once. Over the lower end none comes: $E = -c^2k^2w^{2n} < 0$ at
# $W = 0$; nor from infinity, since the coefficient of the highest power of $W$ holds no $w$. So it changes only at
#
# * the *edge*: $E(\omega_{max}^2, w) = 0$, or
# * a *touch*: $E = \partial E/\partial W = 0$, where the discriminant of $E$ in $W$ vanishes.

# %%
for G, order in ((lag, 2), (lowpass, 4)):
    for E, last in zip(EXCESS[G], (1 - c**2, -(c**2)), strict=True):
        in_w = Poly(E, w)
        assert in_w.degree() == 2 * order
        assert is_zero(in_w.LC() + c**2 * S.subs(omega, sqrt(W)))
        assert is_zero(E.subs(W, 0) + c**2 * k**2 * w ** (2 * order))
        assert is_zero(Poly(E, W).LC() - last * m**2)

# %% [markdown]
# Both are polynomials in $w$ alone, so there are finitely many such $w$, in rational intervals that keep them apart. Between two
# neighbours the number of places is the same for all $w$, and one value $w$ there tells it (Sturm's theorem). If there is one,
# the filter is noticed; if there is none, it is not. At these $w$ themselves, below $w^*$, a frequency is shown at which the
# filter is noticed all over the interval.


# %%
@dataclass(frozen=True)
class Requirement:
    """The slowest filter that is enough: a root of a polynomial, alone in an interval; and whether it is the edge's."""

    polynomial: Poly
    interval: tuple[Rational, Rational]
    at_edge: bool

    def bounds(self, digits: int) -> tuple[Rational, Rational]:
        """Rational bounds, 10^-digits apart at most."""
        return self.polynomial.refine_root(*self.interval, eps=Rational(10) ** -digits)

    def digits(self, count: int) -> str:
        """So many significant digits of it."""
        low, high = (str(bound.evalf(count)) for bound in self.bounds(count + 5))
        assert low == high
        return low


def noticed(E: Poly, filter_frequency: Expr, end: Expr) -> bool:
    """Whether r = c anywhere in the band, for a filter at which nothing is only touched."""
    return bool(E.eval(w, filter_frequency).count_roots(0, end**2) > 0)


def noticed_throughout(E: Poly, interval: tuple[Rational, Rational], end: Expr) -> bool:
    """Whether there is a frequency in the band at which all filters of an interval are noticed."""
    at_one = (E.eval(W, (end * Rational(i, 16)) ** 2) for i in range(1, 17))
    return any(in_w.eval(interval[0]) > 0 and in_w.count_roots(*interval) == 0 for in_w in at_one)


def requirement(E: Poly, end: Expr) -> Requirement:
    """The w* with: noticed for all w < w*, not noticed for any w >= w*."""
    edge, touch = E.eval(W, end**2), E.discriminant()
    both = (edge * touch).sqf_part()
    intervals = [interval for interval, _ in both.intervals(eps=Rational(1, 1000)) if interval[1] > 0]
    ends = [Integer(0), *(bound for interval in intervals for bound in interval), intervals[-1][1] + 1]
    gaps = list(zip(ends[::2], ends[1::2], strict=True))
    assert all(low < high for low, high in gaps)
    pattern = [noticed(E, (low + high) / 2, end) for low, high in gaps]
    count = sum(pattern)
    assert pattern == [True] * count + [False] * (len(pattern) - count)  # one w* only
    assert all(noticed_throughout(E, interval, end) for interval in intervals[: count - 1])
    last = intervals[count - 1]
    return Requirement(both, last, edge.count_roots(*last) == 1)


# %% [markdown]
# ## 4. The paper's example
#
# 1.8 kg, 15 Ns/m, 100 N/m; $\zeta = 1/2$; $c$ = 10 %; to 15 rad/s. Both parts bind at the edge, the imaginary part first: the
# filter would have to be half as fast again as the paper's 80 rad/s. A first-order lag needs 106 rad/s: to first order both are
# a delay of $1/w$, the rest is of second order.

# %%
SIDE = Rational(10) ** -12
PAPER = {m: Rational("1.8"), b: 15, k: 100, zeta: Rational("0.5"), c: Rational("0.1")}
LIGHT = {**PAPER, b: 5}


def polynomial(E: Expr, values: dict[Symbol, Expr]) -> Poly:
    """A threshold polynomial with numbers, in W and w."""
    return Poly(E.subs(values), W, w, domain="QQ")


def requirements(G: Expr, values: dict[Symbol, Expr], end: int) -> list[Requirement]:
    """Those of the real and of the imaginary part."""
    return [requirement(polynomial(E, values), Integer(end)) for E in EXCESS[G]]


paper_real, paper_imag = requirements(lowpass, PAPER, 15)
assert [(x.digits(14), x.at_edge) for x in (paper_real, paper_imag)] == [
    ("91.953106694811", True),
    ("122.35581477043", True),
]
lag_real, lag_imag = requirements(lag, PAPER, 15)
assert [(x.digits(8), x.at_edge) for x in (lag_real, lag_imag)] == [("104.25630", True), ("105.98251", True)]

# %% [markdown]
# ## 5. Where a touch binds
#
# With a third of the damping, and a band that ends a little above the natural frequency $\omega_0 = 7.45$ rad/s, $r_r$ has its
# peak inside the band: just enough is the filter at which the peak touches 10 %. By derivation 09 that is near
# $\omega_0\,2\zeta/(c\sqrt{1 - \zeta_e^2}) = 75.9$ rad/s, at $\omega_0/\sqrt{1 - 2\zeta_e^2} = 7.73$ rad/s, with $\zeta_e$ the
# environment's damping ratio. On a longer band the imaginary part takes over, at the edge.

# %%
light_real, light_imag = requirements(lowpass, LIGHT, 9)
assert [(x.digits(8), x.at_edge) for x in (light_real, light_imag)] == [("76.651305", False), ("65.250060", True)]
longer_imag = requirement(polynomial(EXCESS[lowpass][1], LIGHT), Integer(15))
assert (longer_imag.digits(8), longer_imag.at_edge) == ("147.13611", True)

damping_ratio, own = 5 / (2 * sqrt(180)), sqrt(Rational(1000, 18))
assert str((own * 10 / sqrt(1 - damping_ratio**2)).evalf(3)) == "75.9"
assert str((own / sqrt(1 - 2 * damping_ratio**2)).evalf(3)) == "7.73"

# The touch: a hair above w* the polynomial has no root in the band, a hair below two, close together.
E = polynomial(EXCESS[lowpass][0], LIGHT)
w_low, w_high = (bound + side * SIDE for bound, side in zip(light_real.bounds(12), (-1, 1), strict=True))
close = E.eval(w, w_low).intervals(eps=Rational(1, 10**6), inf=0, sup=81)
assert len(close) == 2
assert not noticed(E, w_high, Integer(9))
touch = sqrt(close[0][0][0])
assert str(touch.evalf(3)) == "7.73"

# %% [markdown]
# ## 6. Closed forms
#
# With $y = \omega/\omega_c$ a lag has $G - 1 = -(y^2 + jy)/(1 + y^2)$. An environment of phase $\varphi$ turns it:
# $r_r = |y\sin\varphi - y^2\cos\varphi|/(1 + y^2)$ and $r_i = |y\cos\varphi + y^2\sin\varphi|/(1 + y^2)$. Each starts at 0 and
# is first of one sign, then perhaps of the other. So at *one* frequency $r = c$ is a quadratic in $\omega_c/\omega = 1/y$, and
# its largest root is the lag that is just enough there:
#
# | ratio | $\omega_c/\omega$ | |
# |---|---|---|
# | $r_r$ | $\left(\sin\varphi + \sqrt{\sin^2\varphi - 4c(\cos\varphi + c)}\right)/(2c)$ | where this is real |
# | $r_r$ | $\left(-\sin\varphi + \sqrt{\sin^2\varphi + 4c(\cos\varphi - c)}\right)/(2c)$ | else, if $\cos\varphi > c$ |
# | $r_i$ | $\left(-\cos\varphi + \sqrt{\cos^2\varphi - 4c(\sin\varphi + c)}\right)/(2c)$ | where real, $\varphi > 90°$ |
# | $r_i$ | $\left(\cos\varphi + \sqrt{\cos^2\varphi + 4c(\sin\varphi - c)}\right)/(2c)$ | else, if real and positive |
#
# and where there is none the ratio stays below $c$ whatever the lag ($0 < \varphi < 180°$). For the paper's environment at 15
# rad/s these are the two numbers of section 4 again.

# %%
y, phi = symbols("y phi", positive=True)
sine, cosine = symbols("sin_phi cos_phi", real=True)
turned_real, turned_imag = (y * sine - y**2 * cosine) / (1 + y**2), -(y * cosine + y**2 * sine) / (1 + y**2)
turned = (cosine + I * sine) * (lag - 1).subs({s: I * omega, w: omega / y})
assert is_zero(turned - turned_real - I * turned_imag)

speed_real = (sine + sqrt(sine**2 - 4 * c * (cosine + c))) / (2 * c)
speed_real_else = (-sine + sqrt(sine**2 + 4 * c * (cosine - c))) / (2 * c)
speed_imag = (-cosine + sqrt(cosine**2 - 4 * c * (sine + c))) / (2 * c)
speed_imag_else = (cosine + sqrt(cosine**2 + 4 * c * (sine - c))) / (2 * c)
for form, speed in (
    (turned_real - c, speed_real),
    (turned_real + c, speed_real_else),
    (turned_imag - c, speed_imag),
    (turned_imag + c, speed_imag_else),
):
    assert is_zero(form.subs(y, 1 / speed))

at_edge = {omega: 15}
modulus = sqrt(S.subs(PAPER).subs(at_edge))
turn = {cosine: A.subs(PAPER).subs(at_edge) / modulus, sine: B.subs(PAPER).subs(at_edge) / modulus}
for speed, required in ((speed_real, lag_real), (speed_imag, lag_imag)):
    form = 15 * speed.subs(PAPER).subs(turn)
    assert str(form.evalf(30)) == required.digits(30)

# %% [markdown]
# *A spring* ($\varphi = 0$), *a damper* (90°) and *a mass* (180°) have the same two ratios, $y/(1 + y^2)$ and
# $y^2/(1 + y^2)$, in one order or the other. Both grow up to $y = 1$, the first is the larger one there, and its peak is
# $1/2$: for $c < 1/2$ it binds, at the edge of the band; for $c \ge 1/2$ it is never noticed, and the second binds,
#
# $$\omega_c \ge \omega_{max}\frac{1 + \sqrt{1 - 4c^2}}{2c}\quad(c < 1/2),\qquad
# \omega_c \ge \omega_{max}\sqrt{\frac{1 - c}{c}}\quad(c \ge 1/2).$$

# %%
first, second = y / (1 + y**2), y**2 / (1 + y**2)
for where, real_ratio, imag_ratio in (((1, 0), second, first), ((0, 1), first, second), ((-1, 0), second, first)):
    alone = dict(zip((cosine, sine), where, strict=True))
    assert is_zero(turned_real.subs(alone) ** 2 - real_ratio**2)
    assert is_zero(turned_imag.subs(alone) ** 2 - imag_ratio**2)
assert is_zero(diff(first, y) - (1 - y**2) / (1 + y**2) ** 2)
assert is_zero(diff(second, y) - 2 * y / (1 + y**2) ** 2)
assert is_zero(first - second - first * (1 - y))

end = Symbol("omega_max", positive=True)
lag_enough, lag_enough_coarse = end * (1 + sqrt(1 - 4 * c**2)) / (2 * c), end * sqrt((1 - c) / c)
assert is_zero((first - c).subs(y, end / lag_enough))
assert is_zero((second - c).subs(y, end / lag_enough_coarse))
assert is_zero(lag_enough - end * speed_imag_else.subs({cosine: 1, sine: 0}))
assert str(lag_enough.subs({c: Rational("0.1"), end: 15}).evalf(6)) == "148.485"

# %% [markdown]
# *A delay* instead of the lag: for a spring $r_i = \sin\omega\tau$ and $r_r = 1 - \cos\omega\tau = \tan(\omega\tau/2)\,r_i$, so
# up to a quarter turn the sine binds, and it grows: $\tau \le \arcsin(c)/\omega_{max}$; the damper and the mass have the same
# two (derivation 02).

# %%
delayed = (exp(-s * tau) - 1).subs(s, I * omega)
assert is_zero(delayed.rewrite(cos) - (cos(omega * tau) - 1 - I * sin(omega * tau)))
delay_enough = asin(c) / end
assert sin(end * delay_enough) == c

# %% [markdown]
# ## 7. The package says the same
#
# Its ratios with symbols: $r^2 - c^2$ is $E/((A^2 + B^2)D^2)$; the parts are compared and $|H|^2$.

# %%
import haptisym as hs

Env, F = hs.environments, hs.effects
for G, effect in ((lag, F.first_order_lag(w)), (lowpass, F.second_order_lowpass(w, zeta))):
    d = hs.distort(Env.mass_spring_damper(m, b, k), effect)
    real, imag, D = TOPS[G]
    assert is_zero(d.real - real / D)
    assert is_zero(d.imag - imag / D)
    assert is_zero(d.modulus**2 - S)

spring = hs.distort(Env.mass_spring_damper(k=k), F.first_order_lag(w))
damper = hs.distort(Env.mass_spring_damper(b=b), F.first_order_lag(w))
at_the_edge = {omega: end, w: lag_enough}
for ratio in (spring.ratio_imag, damper.ratio_real):
    assert is_zero(ratio.replace(Abs, lambda z: z).subs(at_the_edge) ** 2 - c**2)
late = hs.distort(Env.mass_spring_damper(k=k), F.delay(tau))
assert is_zero((late.imag / k).subs({omega: end, tau: delay_enough}) ** 2 - c**2)

# %% [markdown]
# And an evaluation on both sides of each boundary, $10^{-12}$ rad/s apart: no crossing in the band on the one side; on the other
# side one, or near a touch two, of the part that binds.

# %%
from haptisym import Part


def crossed(environment: hs.Environment, effect: hs.Effect, end: int) -> list[Part]:
    """The parts that cross the threshold in the band; the display is transparent on all of it if there is none."""
    result = hs.evaluate(hs.Scene(environment, (effect,), (Integer(0), Integer(end))))
    found = [crossing.part for crossing in result.crossings]
    whole = [(float(x.low.omega), float(x.high.omega)) for x in result.transparent] == [(0, end)]
    assert whole == (not found)
    return found


def msd(values: dict[Symbol, Expr]) -> hs.Environment:
    """The environment with numbers."""
    return Env.mass_spring_damper(values[m], values[b], values[k])


def second_order(frequency: Expr) -> hs.Effect:
    """The filter of the paper's damping ratio."""
    return F.second_order_lowpass(frequency, "0.5")


REAL, IMAG = Part.REAL, Part.IMAG
for values, effect, required, stop, expected in (
    (PAPER, second_order, paper_imag, 15, [IMAG]),
    (PAPER, second_order, paper_real, 15, [REAL, IMAG]),
    (PAPER, F.first_order_lag, lag_imag, 15, [IMAG]),
    (PAPER, F.first_order_lag, lag_real, 15, [IMAG, REAL]),
    (LIGHT, second_order, light_real, 9, [REAL, REAL]),
    (LIGHT, second_order, light_imag, 9, [REAL, REAL, IMAG]),
    (LIGHT, second_order, longer_imag, 15, [IMAG]),
):
    low, high = required.bounds(12)
    slower, faster = (crossed(msd(values), effect(x), stop) for x in (low - SIDE, high + SIDE))
    binding = [part for part in expected if part not in faster]
    assert sorted(slower, key=str) == sorted(expected, key=str)
    assert len(set(binding)) == 1
    assert sorted(faster, key=str) == sorted((part for part in expected if part not in binding), key=str)

# %% [markdown]
# The closed forms: a lag and a delay on a spring, on a damper and on a mass, to 15 rad/s.

# %%
numbers = {c: Rational("0.1"), end: 15}
lag_bound, delay_bound = (Rational(str(form.subs(numbers).evalf(25))) for form in (lag_enough, delay_enough))
for name in "mbk":
    part = REAL if name == "b" else IMAG
    alone = Env.mass_spring_damper(**{name: 10})
    for effect, enough, too_little in (
        (F.first_order_lag, lag_bound + SIDE, lag_bound - SIDE),
        (F.delay, delay_bound - SIDE, delay_bound + SIDE),
    ):
        assert crossed(alone, effect(enough), 15) == []
        assert crossed(alone, effect(too_little), 15) == [part]

# %% [markdown]
# ## 8. Formulas and figure

# %%
from matplotlib.figure import Figure
from numpy import array, linspace, maximum, roots
from sympy import lambdify

from haptisym import latex

output = Path(next((given for given in sys.argv[1:2] if not given.startswith("-")), "derived"))
output.mkdir(parents=True, exist_ok=True)

of_phase = {sine: sin(phi), cosine: cos(phi)}
formulas = {
    r"\omega_c / \omega (r_r)": speed_real.subs(of_phase),
    r"\omega_c / \omega (r_i)": speed_imag.subs(of_phase),
    r"\omega_c (c < 1/2)": lag_enough,
    r"\omega_c (c \ge 1/2)": lag_enough_coarse,
    r"\tau": delay_enough,
}
formulas_tex = [f"{name} &= {latex(form)}" for name, form in formulas.items()]
(output / "10_lowpass_requirement.tex").write_text(
    "\\begin{align}\n" + " \\\\\n".join(formulas_tex) + "\n\\end{align}\n", encoding="utf-8"
)

# %% [markdown]
# Left, the natural frequency that a second-order filter needs, over the end of the band: at each frequency the largest root of
# $E$ in $w$ (thin), and the largest of these up to there (thick, flat where a touch binds). The paper's environment in black,
# with 5 Ns/m in grey. Right, the touch: the lighter damped environment behind 76.65 rad/s.

# %%
figure = Figure(figsize=(7.0, 2.9), layout="constrained")
needs, ratios = figure.subplots(1, 2)
band = linspace(0.5, 15, 146)
for values, color in ((PAPER, "k"), (LIGHT, "0.55")):
    for E, style, name in zip(EXCESS[lowpass], ("-", "--"), ("$r_r$", "$r_i$"), strict=True):
        rows = lambdify(W, Poly(E.subs(values), w).all_coeffs(), "numpy")
        at_each = array([max(root.real for root in roots(rows(x**2)) if abs(root.imag) < 1e-6) for x in band])
        needs.plot(band, at_each, style, color=color, lw=0.6)
        label = f"{name}, {values[b]} Ns/m"
        needs.plot(band, maximum.accumulate(at_each), style, color=color, lw=1.5, label=label)
for required, stop in ((paper_real, 15), (paper_imag, 15), (light_real, 9), (light_imag, 9)):
    needs.plot(stop, float(required.bounds(9)[0]), "o", color="k", ms=4, clip_on=False, zorder=3)
needs.set(
    xlim=(0, 15),
    ylim=(0, 150),
    xticks=[0, 5, 10, 15],
    xlabel="end of the band (rad/s)",
    ylabel=r"$\omega_n$ needed (rad/s)",
)
needs.legend(loc="upper left", frameon=False, fontsize=8)

places = linspace(0, 12, 301)
with_numbers = {**LIGHT, w: light_real.bounds(12)[1]}
for top, style, label in zip(TOPS[lowpass][:2], ("-", "--"), ("$r_r$", "$r_i$"), strict=True):
    squared = lambdify(omega, (top**2 / (S * D_2**2)).subs(with_numbers), "numpy")
    ratios.plot(places, 100 * squared(places) ** 0.5, style, color="k", lw=1.2, label=label)
ratios.axvspan(0, 9, color="0.9", lw=0)
ratios.axhline(10, color="0.3", lw=0.8, ls=":")
ratios.plot(float(touch), 10, "o", color="k", ms=4)
ratios.set(xlim=(0, 12), ylim=(0, 14), xlabel=r"$\omega$ (rad/s)", ylabel="distortion ratio (%)")
ratios.legend(loc="upper left", frameon=False)
figure.savefig(output / "10_lowpass_requirement.pdf", metadata={"CreationDate": None})
