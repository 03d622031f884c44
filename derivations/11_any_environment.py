r"""What can be said of a display without knowing the environment: the length of the arrow G - 1 decides.

Claim. A pure series effect G distorts by dH = H (G - 1). At one frequency, with L = |G - 1|,

    every environment whatever is felt unchanged   exactly if   L <= min(c_real, c_imag),
    no environment at all is felt unchanged        exactly if   L > sqrt(c_real^2 + c_imag^2)    (sqrt 2 c for equal ones).

Both bounds are attained: with psi = arg(G - 1), by the phases -psi and pi/2 - psi of H, and by -psi + atan(c_imag/c_real). In
between, a share 1 - (4/pi) acos(c/L) of all phases is left (c the same for both). In the paper's example the bounds are
7.9223118... and 11.1000534... rad/s. Closed forms: a lag has omega = omega_c sqrt(C/(1 - C)), C = c^2 or 2 c^2; a delay
2 asin(sqrt(C)/2)/tau; a second-order low-pass a quadratic in omega^2; a hold omega T between 2 sqrt(C) (1 + C/9) and
sqrt(9 - sqrt(81 - 72 C)). Two effects of which one does not amplify have at most L_1 + L_2. With something beside the
environment (a shunt) no such statement exists: what is noticed then depends on the size of H.

Assumptions. Linear; steady sinusoidal motion, x_h = x_e; m, b, k, omega_c, omega_n, zeta, tau, T > 0; thresholds < 1 (eq. 4).

Source. Eqs. (4), (8) to (10) of W. Fu, M. M. van Paassen, M. Mulder, Framework for a Two-step Evaluation of Haptic Displays,
IFAC-PapersOnLine 52(19) 97-102, 2019, doi:10.1016/j.ifacol.2019.12.119.

Run as ``python 11_any_environment.py [directory]``; formulas and figure go to the directory, ``derived`` if none is given.
"""

# %%
import sys
from pathlib import Path

from sympy import (
    Expr,
    Function,
    I,
    Integer,
    Poly,
    Rational,
    Symbol,
    acos,
    asin,
    atan,
    cos,
    diff,
    exp,
    expand,
    fraction,
    integrate,
    limit,
    oo,
    pi,
    sin,
    sqrt,
    symbols,
    together,
)

m, b, k, omega, omega_c, omega_n, zeta, tau, T = symbols("m b k omega omega_c omega_n zeta tau T", positive=True)
c, c_real, c_imag, L, C = symbols("c c_real c_imag L C", positive=True)  # C: the square of a bound of L
phi, psi = symbols("phi psi", real=True)
s, t, X = symbols("s t X")


def is_zero(difference: Expr) -> bool:
    """Whether an expression is zero identically: waves as exponentials, over a common denominator, multiplied out."""
    return expand(fraction(together(difference.rewrite(exp)))[0]) == 0


# %% [markdown]
# ## 1. The turned arrow
#
# For the motion $x = Xe^{st}$ the environment's force is $f_e = H x$, and the device passes on $f_h = G f_e$. So
# $\Delta H = H(G - 1)$, and with $\varphi = \arg H$, $\psi = \arg(G - 1)$, $L = |G - 1|$:
#
# $$\frac{\Delta H}{|H|} = L\,e^{j(\varphi + \psi)},\qquad r_r = L\,|\cos(\varphi + \psi)|,\qquad
# r_i = L\,|\sin(\varphi + \psi)|.$$
#
# Of the environment only the direction is left; and a half turn changes nothing, so every direction is that of something
# passive, $0 \le \varphi < 180°$: a spring or a mass with a damper beside it.

# %%
G, H = Function("G")(s), Function("H")(s)
motion = X * exp(s * t)
force = H * motion
dH = (G * force - force) / motion  # eq. (9)
assert is_zero(dH - H * (G - 1))

turned = exp(I * phi) * L * exp(I * psi)
turned_real, turned_imag = L * cos(phi + psi), L * sin(phi + psi)
assert is_zero(turned - turned_real - I * turned_imag)
assert is_zero(turned_real**2 + turned_imag**2 - L**2)
for part in (turned_real, turned_imag):
    assert is_zero(part.subs(phi, phi + pi) + part)

# %% [markdown]
# ## 2. Every environment, and none
#
# *Every.* Neither ratio is more than $L$, so $L \le \min(c_r, c_i)$ is enough. It is needed too: at $\varphi = -\psi$ the arrow
# lies along the real axis, $r_r = L$, and at $\varphi = \pi/2 - \psi$ along the imaginary one, $r_i = L$.
#
# *None.* $r_r^2 + r_i^2 = L^2$. If $L^2 > c_r^2 + c_i^2$, not both $r_r \le c_r$ and $r_i \le c_i$. If not, the direction
# $\varphi = -\psi + \arctan(c_i/c_r)$, to the corner of the threshold region, has $r_r = Lc_r/\sqrt{c_r^2 + c_i^2} \le c_r$
# and $r_i = Lc_i/\sqrt{c_r^2 + c_i^2} \le c_i$.

# %%
corner = sqrt(c_real**2 + c_imag**2)
for direction, along_real, along_imag in (
    (-psi, L, 0),
    (pi / 2 - psi, 0, L),
    (atan(c_imag / c_real) - psi, L * c_real / corner, L * c_imag / corner),
):
    assert is_zero(turned_real.subs(phi, direction) ** 2 - along_real**2)
    assert is_zero(turned_imag.subs(phi, direction) ** 2 - along_imag**2)

# %% [markdown]
# *In between*, $c < L \le \sqrt 2c$, the same for both parts: in a quarter turn $\theta = \varphi + \psi$ must be at least
# $\arccos(c/L)$ and at most $\arcsin(c/L) = \pi/2 - \arccos(c/L)$. That is a share of $1 - \frac4\pi\arccos\frac cL$ of all
# directions: 1 at $L = c$, 0 at $L = \sqrt 2c$.

# %%
share = 1 - 4 / pi * acos(c / L)
assert cos(acos(c / L)) == sin(asin(c / L)) == c / L
assert is_zero(share - ((pi / 2 - acos(c / L)) - acos(c / L)) / (pi / 2))
assert (share.subs(L, c), share.subs(L, sqrt(2) * c)) == (1, 0)

# %% [markdown]
# The attaining environments, for $G - 1 = -p - jq$ at the frequency $\omega$ with $p, q \ge 0$ (an effect that lags and does not
# overshoot): $H \sim \overline{G - 1}$, a mass $p/\omega^2$ with a damper $q/\omega$, has $r_r = L$; a spring $q$ with a damper
# $p/\omega$ has $r_i = L$; and the first one turned by the corner's angle is a mass $(pc_r + qc_i)/\omega^2$ with a damper
# $(qc_r - pc_i)/\omega$.

# %%
p, q = symbols("p q", positive=True)
arrow = -p - I * q
WORST_REAL = {m: p / omega**2, b: q / omega, k: 0}
WORST_IMAG = {m: 0, b: p / omega, k: q}
BEST = {m: (p * c_real + q * c_imag) / omega**2, b: (q * c_real - p * c_imag) / omega, k: 0}
element = m * s**2 + b * s + k
for tuned, outcome in ((WORST_REAL, 1), (WORST_IMAG, -I), (BEST, c_real + I * c_imag)):
    assert is_zero((element * arrow).subs(s, I * omega).subs(tuned) - (p**2 + q**2) * outcome)

# %% [markdown]
# ## 3. Closed forms
#
# $L^2 = C$, with $C = c^2$ for "every" and $C = 2c^2$ for "none":
#
# | effect | $L^2$ | $L^2 = C$ at |
# |---|---|---|
# | lag, $y = \omega/\omega_c$ | $y^2/(1 + y^2)$ | $y^2 = C/(1 - C)$ |
# | low-pass, $y = \omega/\omega_n$ | $(y^4 + 4\zeta^2y^2)/((1 - y^2)^2 + 4\zeta^2y^2)$ | $(1 - C)y^4 + ay^2 - C = 0$ |
# | delay, $x = \omega\tau$ | $4\sin^2(x/2)$ | $x = 2\arcsin(\sqrt C/2)$ |
# | hold, $x = \omega T$ | $1 - 2\sin(x)/x + 2(1 - \cos x)/x^2$ | section 4 |
#
# with $a = 4\zeta^2(1 - C) + 2C$. For $C < 1$ the first two have one positive root, where $L$ passes $\sqrt C$ for good; the
# delay's stay above until $2\pi - x$.

# %%
lag, lowpass = omega_c / (s + omega_c), omega_n**2 / (s**2 + 2 * zeta * omega_n * s + omega_n**2)
delay, hold = exp(-s * tau), (1 - exp(-s * T)) / (s * T)
x, y, V = symbols("x y V", positive=True)  # V = y^2


def squared_length(effect: Expr) -> Expr:
    """|G(j omega) - 1|^2 = (G(j omega) - 1)(G(-j omega) - 1), of an effect with real coefficients."""
    return (effect - 1).subs(s, I * omega) * (effect - 1).subs(s, -I * omega)


lag_square = y**2 / (1 + y**2)
lowpass_square = (y**4 + 4 * zeta**2 * y**2) / ((1 - y**2) ** 2 + 4 * zeta**2 * y**2)
delay_square = 4 * sin(x / 2) ** 2
hold_square = 1 - 2 * sin(x) / x + 2 * (1 - cos(x)) / x**2
for effect, own, form in (
    (lag, {omega: y * omega_c}, lag_square),
    (lowpass, {omega: y * omega_n}, lowpass_square),
    (delay, {omega: x / tau}, delay_square),
    (hold, {omega: x / T}, hold_square),
):
    assert is_zero(squared_length(effect).subs(own) - form)

a = 4 * zeta**2 * (1 - C) + 2 * C
lag_bound = sqrt(C / (1 - C))
lowpass_bound = sqrt((sqrt(a**2 + 4 * C * (1 - C)) - a) / (2 * (1 - C)))
delay_bound = 2 * asin(sqrt(C) / 2)
assert is_zero(lag_square.subs(y, lag_bound) - C)
assert is_zero(lowpass_square.subs(y, lowpass_bound) - C)
assert delay_square.subs(x, delay_bound) == C
assert is_zero((lowpass_square - C) * ((1 - y**2) ** 2 + 4 * zeta**2 * y**2) - ((1 - C) * y**4 + a * y**2 - C))


def rounded(value: Expr, digits: int) -> str:
    """A number to so many significant digits."""
    return str(value.evalf(digits))


EVERY, NONE = {C: Rational("0.01")}, {C: Rational("0.02")}  # c = 10 %
assert lag_bound.subs(NONE) == Rational(1, 7)
assert [rounded(form.subs(EVERY), 6) for form in (lag_bound, delay_bound)] == ["0.100504", "0.100042"]
assert [rounded(lowpass_bound.subs(EVERY).subs(zeta, Rational(value)), 3) for value in ("0.5", "0.7", "1")] == [
    "0.0990",
    "0.0713",
    "0.0501",
]
paper_every, paper_none = (80 * lowpass_bound.subs(zeta, Rational("0.5")).subs(bound) for bound in (EVERY, NONE))
print(f"every environment up to {rounded(paper_every, 20)}, none from {rounded(paper_none, 20)} rad/s on")
assert [rounded(value, 9) for value in (paper_every, paper_none)] == ["7.92231186", "11.1000534"]

# %% [markdown]
# ## 4. The hold
#
# $F = x^2L^2$ has the slope $2x(1 - \cos x)$, and the cosine lies between its partial sums:
# $x^2/2 - x^4/24 \le 1 - \cos x \le x^2/2 - x^4/24 + x^6/720$ (the differences and their derivatives start at 0, and the sixth
# derivative of either has one sign). Integrated and divided by $x^2$, for all $x > 0$:
#
# $$\frac{x^2}{4} - \frac{x^4}{72} \le L^2 \le \frac{x^2}{4} - \frac{x^4}{72} + \frac{x^6}{2880}.$$
#
# And $L$ grows up to $x = \pi$ (the Nyquist frequency): the slope of $L^2$ times $x^3/2$ is 0 at 0 and has the slope
# $x^2\sin x$.

# %%
F = expand(x**2 * hold_square)
sums = (x**2 / 2 - x**4 / 24, x**2 / 2 - x**4 / 24 + x**6 / 720)
low_square, high_square = (expand(integrate(2 * x * partial, x) / x**2) for partial in sums)
assert F.subs(x, 0) == 0
assert is_zero(diff(F, x) - 2 * x * (1 - cos(x)))
for partial, slopes in zip(sums, ((4, 1 - cos(x)), (6, cos(x) - 1)), strict=True):
    order, last = slopes
    difference = 1 - cos(x) - partial
    assert [diff(difference, x, i).subs(x, 0) for i in range(order)] == [0] * order
    assert is_zero(diff(difference, x, order) - last)
assert low_square == x**2 / 4 - x**4 / 72
assert high_square == x**2 / 4 - x**4 / 72 + x**6 / 2880

growth = expand(diff(hold_square, x) * x**3 / 2)
assert growth.subs(x, 0) == 0
assert is_zero(diff(growth, x) - x**2 * sin(x))

# %% [markdown]
# So $L^2 = C$ lies below the place where the lower bound is $C$, and above any place where the upper bound is less:
#
# $$2\sqrt C\left(1 + \frac C9\right) < x < \sqrt{9 - \sqrt{81 - 72C}}\qquad(C \le 1/2).$$
#
# For $c$ = 10 % that is 0.200222 to six digits: 13.35 ms at 15 rad/s. The first factor is the delay of half a period.

# %%
hold_low, hold_high = 2 * sqrt(C) * (1 + C / 9), sqrt(9 - sqrt(81 - 72 * C))
assert is_zero(low_square.subs(x, hold_high) - C)
room = Poly(expand(C - high_square.subs(x, hold_low)), C)
assert room.count_roots(0, Rational(1, 2)) == 1  # C = 0 itself
assert room.eval(Rational(1, 2)) > 0
assert [rounded(form.subs(EVERY), 6) for form in (hold_low, hold_high)] == ["0.200222", "0.200223"]
assert hold_high.subs(C, Rational(1, 2)).evalf() < pi.evalf()
assert rounded(1000 * hold_low.subs(EVERY) / 15, 4) == "13.35"

# %% [markdown]
# ## 5. Two effects
#
# $G_1G_2 - 1 = (G_1 - 1) + G_1(G_2 - 1)$, so $L \le L_1 + |G_1|L_2$, which is at most $L_1 + L_2$ if $G_1$ does not amplify. So
# the budgets of delays, holds and lags add up, and one filter with a resonance may be among them. Two lags are, exactly, a
# low-pass with $\omega_n^2 = \omega_1\omega_2$ and $2\zeta\omega_n = \omega_1 + \omega_2$.

# %%
G_1, G_2, omega_1, omega_2 = symbols("G_1 G_2 omega_1 omega_2", positive=True)
assert is_zero(G_1 * G_2 - 1 - ((G_1 - 1) + G_1 * (G_2 - 1)))
two_lags = lag.subs(omega_c, omega_1) * lag.subs(omega_c, omega_2)
as_lowpass = {omega_n: sqrt(omega_1 * omega_2), zeta: (omega_1 + omega_2) / (2 * sqrt(omega_1 * omega_2))}
assert is_zero(two_lags - lowpass.subs(as_lowpass))
for effect in (lag, delay, hold):  # none of them amplifies
    passed = (effect.subs(s, I * omega) * effect.subs(s, -I * omega)).subs(omega, x / T)
    loss = {lag: x**2 / (x**2 + (omega_c * T) ** 2), delay: 0, hold: 1 - (sin(x / 2) / (x / 2)) ** 2}[effect]
    assert is_zero(1 - passed - loss)

# %% [markdown]
# ## 6. A shunt
#
# A device's own impedance $Z$ beside the environment gives $H_{perc} = H + Z$: $\Delta H = Z$, whatever $H$ is, and
# $r_r = |\Re Z|/|H|$. At any frequency where $Z \ne 0$ an environment large enough hides it and one small enough does not:
# there is neither an "every" nor a "none". A compliance, $1/H_{perc} = 1/H + 1/K$, is the same the other way round:
# $\Delta H/H = -H/(K + H)$ grows with $H$.

# %%
h, Z, K = symbols("H Z K")
size = Symbol("size", positive=True)
with_shunt, with_compliance, in_series = (
    together((felt - h) / h) for felt in (h + Z, 1 / (1 / h + 1 / K), G_1 * h)
)  # dH/H
assert is_zero(with_shunt.subs(h, size * h) - with_shunt / size)
assert is_zero(with_compliance + h / (K + h))
assert is_zero(in_series.subs(h, size * h) - in_series)
scaled = with_compliance.subs(h, size * h)
assert (limit(scaled, size, 0), limit(scaled, size, oo)) == (0, -1)

# %% [markdown]
# ## 7. The package says the same

# %%
import haptisym as hs

E, effects = hs.environments, hs.effects
for effect, packaged in (
    (lag, effects.first_order_lag(omega_c)),
    (lowpass, effects.second_order_lowpass(omega_n, zeta)),
    (delay, effects.delay(tau)),
    (hold, effects.zero_order_hold(T)),
):
    d = hs.distort(E.mass_spring_damper(k=k), packaged)
    assert is_zero(d.relative_real**2 + d.relative_imag**2 - squared_length(effect))
    assert is_zero(d.ratio_real**2 + d.ratio_imag**2 - squared_length(effect))

# %% [markdown]
# Evaluations of the paper's filter. Up to $10^{-9}$ rad/s below 7.9223... every environment tried is unchanged, the worst one
# too; $10^{-9}$ above, the worst ones are not. Beyond 11.1001... none is, up to 1000 rad/s; just below, the best one is.

# %%
SIDE = Rational(10) ** -9
FILTER = effects.second_order_lowpass(80, "0.5")


def exact(value: Expr) -> Rational:
    """A number rounded to 25 digits."""
    return Rational(rounded(value, 25))


def tuned(form: dict[Symbol, Expr], place: Rational, limits: tuple[str, str] = ("0.1", "0.1")) -> hs.Environment:
    """An environment that attains a bound at that frequency, behind the paper's filter."""
    real, imag = (
        (lowpass - 1).subs({omega_n: 80, zeta: Rational("0.5"), s: I * place}).expand(complex=True).as_real_imag()
    )
    assert max(real, imag) < 0
    numbers = {p: -real, q: -imag, omega: place, c_real: Rational(limits[0]), c_imag: Rational(limits[1])}
    return E.mass_spring_damper(*(form[name] if form[name] == 0 else form[name].subs(numbers) for name in (m, b, k)))


def transparent(
    environment: hs.Environment, low: Expr, high: Expr, limits: tuple[str, str] = ("0.1", "0.1")
) -> list[tuple[float, float]]:
    """The transparent intervals of an environment behind the paper's filter."""
    result = hs.evaluate(hs.Scene(environment, (FILTER,), (low, high), hs.Threshold.of(*limits)))
    return [(float(x.low.omega), float(x.high.omega)) for x in result.transparent]


OTHERS = (
    E.mass_spring_damper(Rational("1.8"), 15, 100),
    E.mass_spring_damper(k=100),
    E.mass_spring_damper(b=15),
    E.mass_spring_damper(m=2),
    E.zener(200, 300, 6),
    E.two_mass(1, 1, 100, "0.5", "0.2", 30),
)
under, over = exact(paper_every) - SIDE, exact(paper_every) + SIDE
for environment in (*OTHERS, tuned(WORST_REAL, under), tuned(WORST_IMAG, under)):
    assert transparent(environment, Integer(0), under) == [(0, float(under))]
for worst in (WORST_REAL, WORST_IMAG):
    [(_, end)] = transparent(tuned(worst, over), Integer(0), over)
    assert end < float(over)

before, behind = exact(paper_none) - SIDE, exact(paper_none) + SIDE
for environment in (*OTHERS, tuned(BEST, behind)):
    assert transparent(environment, behind, Integer(1000)) == []
assert transparent(tuned(BEST, before), Integer(11), before)[-1][1] == float(before)

# %% [markdown]
# Unequal thresholds, 10 % and 20 %: the smaller one and $\sqrt{0.01 + 0.04}$ decide.

# %%
UNEQUAL = ("0.1", "0.2")
unequal_none = exact(80 * lowpass_bound.subs({zeta: Rational("0.5"), C: Rational("0.05")}))
assert transparent(tuned(WORST_IMAG, over, UNEQUAL), Integer(0), over, UNEQUAL) == [(0, float(over))]
[(_, end)] = transparent(tuned(WORST_REAL, over, UNEQUAL), Integer(0), over, UNEQUAL)
assert end < float(over)
near = unequal_none - SIDE
assert transparent(tuned(BEST, near, UNEQUAL), Integer(17), near, UNEQUAL)[-1][1] == float(near)
for environment in (*OTHERS, tuned(BEST, unequal_none + SIDE, UNEQUAL)):
    assert transparent(environment, unequal_none + SIDE, Integer(1000), UNEQUAL) == []

# %% [markdown]
# A second effect, 2 ms of delay: at 6.8 rad/s $L_1 + L_2 < 10$ %, so every environment is still unchanged up to there. And a
# shunt: 0.1 kg of the device is noticed on a spring of 50 N/m from $\sqrt{50}$ rad/s on, on one of 200 N/m from twice that on,
# while behind a series effect the two springs are the same.

# %%
sum_of_lengths = sqrt(lowpass_square.subs({zeta: Rational("0.5"), y: Rational("0.085")})) + 2 * sin(Rational("0.0068"))
assert sum_of_lengths.evalf() < Rational("0.1")
for environment in OTHERS:
    scene = hs.Scene(environment, (FILTER, effects.delay("2 ms")), (Integer(0), Rational("6.8")))
    assert hs.evaluate(scene).crossings == ()


def first_crossing(stiffness: int, effect: hs.Effect) -> str:
    """Where a spring is first felt as changed."""
    scene = hs.Scene(E.mass_spring_damper(k=stiffness), (effect,), (Integer(0), Integer(20)))
    return hs.evaluate(scene, digits=20).crossings[0].omega.digits(20)


assert first_crossing(50, effects.shunt(m="0.1")) == rounded(sqrt(50), 20)
assert first_crossing(200, effects.shunt(m="0.1")) == rounded(2 * sqrt(50), 20)
assert first_crossing(50, FILTER) == first_crossing(200, FILTER)

# %% [markdown]
# ## 8. Formulas and figure

# %%
from matplotlib.figure import Figure
from numpy import arccos, clip, linspace, maximum
from numpy import pi as half_turn
from sympy import lambdify

from haptisym import latex

output = Path(next((given for given in sys.argv[1:2] if not given.startswith("-")), "derived"))
output.mkdir(parents=True, exist_ok=True)

filter_length = omega * sqrt(omega**2 + (2 * zeta * omega_n) ** 2)
filter_length /= sqrt((omega_n**2 - omega**2) ** 2 + (2 * zeta * omega_n * omega) ** 2)
assert is_zero(filter_length**2 - squared_length(lowpass))

formulas = {
    r"\sqrt{r_r^2 + r_i^2}": filter_length,
    r"\omega_{lag}": omega_c * lag_bound,
    r"\omega_{filter}": omega_n * lowpass_bound,
    r"\omega_{delay}": delay_bound / tau,
    r"\min \omega_{hold}": hold_low / T,
    r"\max \omega_{hold}": hold_high / T,
}
formulas_tex = [f"{name} &= {latex(form)}" for name, form in formulas.items()]
(output / "11_any_environment.tex").write_text(
    "\\begin{align}\n" + " \\\\\n".join(formulas_tex) + "\n\\end{align}\n", encoding="utf-8"
)

# %% [markdown]
# Left, the paper's filter: the larger of the two ratios lies in the grey area for every environment, between $L/\sqrt 2$ and
# $L$; the paper's environment and a spring inside it. Right, the share of all phases whose environments are felt unchanged,
# for four effects that all delay by 12.5 ms at low frequency.

# %%
figure = Figure(figsize=(7.0, 2.9), layout="constrained")
lengths, phases = figure.subplots(1, 2)
band = linspace(0.01, 15, 401)
PAPER = {omega_n: 80, zeta: Rational("0.5")}
length = lambdify(omega, filter_length.subs(PAPER), "numpy")
lengths.fill_between(band, 100 * length(band) / 2**0.5, 100 * length(band), color="0.85", lw=0)
for environment, style, label in ((OTHERS[0], "-", "paper's environment"), (OTHERS[1], "--", "spring")):
    values = hs.distort(environment, FILTER).compile()(band)
    larger = maximum(values.ratio_real, values.ratio_imag)
    lengths.plot(band, 100 * larger, style, color="k", lw=1.2, label=label)
lengths.axhline(10, color="0.3", lw=0.8, ls=":")
for bound in (paper_every, paper_none):
    lengths.plot(float(bound), 10, "o", color="k", ms=4)
lengths.set(
    xlim=(0, 15),
    ylim=(0, 20),
    xticks=[0, 5, 10, 15],
    yticks=[0, 5, 10, 15, 20],
    xlabel=r"$\omega$ (rad/s)",
    ylabel="larger ratio (%)",
)
lengths.legend(loc="upper left", frameon=False, fontsize=8)

close = linspace(7.5, 12, 401)
for square, argument, values, style, label in (
    (lag_square, y, close / 80, "-", "lag 80 rad/s"),
    (lowpass_square.subs(zeta, Rational("0.5")), y, close / 80, "--", "low-pass 80 rad/s, 0.5"),
    (delay_square, x, close / 80, "-.", "delay 12.5 ms"),
    (hold_square, x, close / 40, ":", "hold 25 ms"),
):
    relative = clip(0.1 / lambdify(argument, square, "numpy")(values) ** 0.5, 2**-0.5, 1)
    phases.plot(close, 100 * (1 - 4 / half_turn * arccos(relative)), style, color="k", lw=1.2, label=label)
phases.set(xlim=(7.5, 12), ylim=(0, 105), xlabel=r"$\omega$ (rad/s)", ylabel="phases left (%)")
phases.legend(loc="upper right", frameon=False, fontsize=8)
figure.savefig(output / "11_any_environment.pdf", metadata={"CreationDate": None})
