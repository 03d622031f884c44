r"""What a JND of the dynamics means for a single parameter: stiffness, damping, mass, natural frequency.

Claim. By eq. (4) a change of one parameter is noticed from

    dk = c |H|,    db = c |H|/omega,    dm = c |H|/omega^2

on, whatever the environment beside it. So no Weber law holds for a parameter by itself: its JND is a fraction c of the whole
|H|. The natural frequency of a mass-spring-damper that is moved at resonance is noticed as changed from the fraction c zeta
on, to first order and no matter whether stiffness or mass was changed; moved at omega_n sqrt(1 - 2 zeta^2) (by a stiffness),
already from c zeta sqrt(1 - zeta^2), the least of all frequencies. With the damping ratio kept, c zeta holds while zeta < 1.

Assumptions. Linear, m, b, k > 0; a steady sinusoidal movement of one frequency; c the same for both parts (eq. 4); "to first
order" where it says so.

Source. Eqs. (2) to (4) of W. Fu, M. M. van Paassen, M. Mulder, Framework for a Two-step Evaluation of Haptic Displays,
IFAC-PapersOnLine 52(19) 97-102, 2019, doi:10.1016/j.ifacol.2019.12.119.

Run as ``python 06_parameter_jnd.py [directory]``; formulas and figure go to the directory, ``derived`` if none is given.
"""

# %%
import sys
from pathlib import Path

from sympy import (
    Abs,
    Expr,
    Function,
    I,
    Integer,
    Poly,
    Rational,
    Symbol,
    diff,
    exp,
    expand,
    fraction,
    series,
    sqrt,
    symbols,
    together,
)

m, b, k, omega, c, omega_n, zeta = symbols("m b k omega c omega_n zeta", positive=True)
s, t, X = symbols("s t X")


def is_zero(difference: Expr) -> bool:
    """Whether an expression is zero identically: exact, over a common denominator and multiplied out."""
    return expand(fraction(together(difference))[0]) == 0


# %% [markdown]
# ## 1. One parameter more
#
# An environment of any kind, $f = f_0(x)$, gets a little more of a spring, a damper or a mass beside it: the force grows by
# $p\,x$, $p\,\dot x$ or $p\,\ddot x$. For $x = Xe^{j\omega t}$ the dynamics $f/x$ grow by $p$, $j\omega p$ or $-\omega^2p$:
# wholly real or wholly imaginary.

# %%
p = Symbol("p", positive=True)
H_0 = Function("H_0")(omega)  # whatever was there
motion = X * exp(I * omega * t)
grown = {
    name: (H_0 * motion + p * motion.diff(t, order)) / motion
    for name, order in {"stiffness": 0, "damping": 1, "mass": 2}.items()
}
changes = {name: expand(form - H_0) for name, form in grown.items()}
assert changes == {"stiffness": p, "damping": I * omega * p, "mass": -(omega**2) * p}

# %% [markdown]
# Eq. (4): a change of $\Re H$ or of $\Im H$ is just noticed when it is $c\,|H|$. So $p$ is noticed from $c\,|H|$ over the
# modulus of its coefficient on. That is the answer to "how much stiffer must it be", and what a psychophysicist fits:
# $dk/k = c\,|H|/k$ grows without bound where the stiffness is not what is felt of the environment.

# %%
modulus = Symbol("M", positive=True)  # |H|
jnd = {name: c * modulus / Abs(change.subs(p, 1)) for name, change in changes.items()}
assert jnd == {"stiffness": c * modulus, "damping": c * modulus / omega, "mass": c * modulus / omega**2}

# %% [markdown]
# ## 2. A mass-spring-damper
#
# $|H|^2 = (k - m\omega^2)^2 + b^2\omega^2$. Alone, each parameter has the Weber fraction $c$. Together, that of the
# stiffness is $c$ only towards $\omega = 0$ and that of the damping at resonance, where that of stiffness and mass is
# $2c\zeta$.

# %%
H = m * s**2 + b * s + k
square = (k - m * omega**2) ** 2 + (b * omega) ** 2


def squared_modulus(dynamics: Expr) -> Expr:
    """|H(j omega)|^2 = H(j omega) H(-j omega), of dynamics with real coefficients."""
    return dynamics.subs(s, I * omega) * dynamics.subs(s, -I * omega)


assert is_zero(squared_modulus(H) - square)
for parameter, name, others in ((k, "stiffness", (m, b)), (b, "damping", (m, k)), (m, "mass", (b, k))):
    alone = dict.fromkeys(others, 0)
    assert jnd[name].subs(modulus, sqrt(square.subs(alone))) / parameter == c

at_resonance = {k: m * omega_n**2, b: 2 * zeta * m * omega_n, omega: omega_n}
assert (square / k**2).subs(omega, 0) == 1
assert is_zero((square / (b * omega) ** 2).subs(at_resonance) - 1)
assert is_zero((square / k**2).subs(omega, omega_n).subs(at_resonance) - (2 * zeta) ** 2)
assert is_zero((square / (m * omega**2) ** 2).subs(at_resonance) - (2 * zeta) ** 2)

# %% [markdown]
# ## 3. The natural frequency
#
# Write $k = m\omega_n^2$ and $b = 2\zeta m\omega_n$. Moved at $\omega = \omega_n$ the spring and the mass cancel,
# $|H| = b\omega_n = 2\zeta m \omega_n^2$: the less damping, the less there is beside which a change must be noticed.
# Another natural frequency, by another stiffness (at the same $m$ and $b$) or by another mass (at the same $k$ and $b$),
# moves $\Re H = k - m\omega^2$ at the rate $2m\omega_n$ in either case.

# %%
assert is_zero(square.subs(at_resonance) - (2 * zeta * m * omega_n**2) ** 2)

nu = Symbol("nu", positive=True)  # the natural frequency after the change
by_stiffness = m * nu**2 - m * omega**2
by_mass = k - k / nu**2 * omega**2
for form in (by_stiffness, by_mass):
    assert is_zero((form.subs(nu, omega_n) - (k - m * omega**2)).subs(k, m * omega_n**2))
rates = [diff(form, nu).subs({nu: omega_n}) for form in (by_stiffness, by_mass)]
rates_at_resonance = [rate.subs(at_resonance) for rate in rates]
assert rates_at_resonance == [2 * m * omega_n, 2 * m * omega_n]

felt_at_resonance = 2 * zeta * m * omega_n**2
natural_frequency_jnd = c * zeta  # a fraction of omega_n
for rate in rates_at_resonance:
    assert is_zero(c * felt_at_resonance / (rate * omega_n) - natural_frequency_jnd)

# %% [markdown]
# With $c$ = 10 % and $\zeta = 1/2$: 5 %. The 4.0 to 7.0 % that Li et al. (2008) measured at 1 to 2 Hz would be those of
# $\zeta$ from 0.40 to 0.70 (their $\zeta$ is not known here).
#
# *Not to first order*: a stiffness that raises $\omega_n$ by the fraction $\delta$ changes $\Re H$ by
# $m\omega_n^2(2\delta + \delta^2)$, noticed from $\delta = \sqrt{1 + 2c\zeta} - 1$ on; one that lowers it, from
# $1 - \sqrt{1 - 2c\zeta}$. Between the two lies $c\zeta$, since the square root bends down; for $c\zeta = 5$ % they are
# 4.88 and 5.13 %.

# %%
delta = Symbol("delta", positive=True)
raised, lowered = sqrt(1 + 2 * c * zeta) - 1, 1 - sqrt(1 - 2 * c * zeta)
for sign, fraction_noticed in ((1, raised), (-1, lowered)):
    change = (by_stiffness.subs(nu, omega_n * (1 + sign * delta)) - by_stiffness.subs(nu, omega_n)).expand()
    assert is_zero(change.subs(delta, fraction_noticed) - sign * c * felt_at_resonance)
    assert is_zero(series(fraction_noticed, c, 0, 2).removeO() - natural_frequency_jnd)
    assert is_zero(diff(fraction_noticed, c, 2) + sign * zeta**2 / (1 + 2 * sign * c * zeta) ** Rational(3, 2))
half = {c: Rational("0.1"), zeta: Rational("0.5")}
assert [str((100 * form.subs(half)).evalf(3)) for form in (raised, lowered)] == ["4.88", "5.13"]

# %% [markdown]
# *With the damping ratio kept*, $b = 2\zeta m\omega_n$ changes too, and so does $\Im H$, at the rate $2\zeta m\omega$. At
# resonance that alone is noticed from the fraction $c$ on: later than $c\zeta$ while $\zeta < 1$.

# %%
damping_part = 2 * zeta * m * nu * omega
rate_imag = diff(damping_part, nu).subs(at_resonance)
assert is_zero(c * felt_at_resonance / (rate_imag * omega_n) - c)

# %% [markdown]
# *At other frequencies of movement*, a change of stiffness is noticed from $\delta = c\,|H|/(2m\omega_n^2)$ on, and $|H|$
# is least not at resonance but a little below, at $\omega^2 = \omega_n^2(1 - 2\zeta^2)$ (for $\zeta < 1/\sqrt 2$): there
# from $c\zeta\sqrt{1 - \zeta^2}$. For a change of mass, $\delta = c\,|H|/(2m\omega^2)$, the same least value lies as much
# above, at $\omega^2 = \omega_n^2/(1 - 2\zeta^2)$.

# %%
W = Symbol("W", positive=True)  # (omega/omega_n)^2
shape = expand((square / (m * omega_n**2) ** 2).subs({k: m * omega_n**2, b: 2 * zeta * m * omega_n}))
shape = expand(shape.subs(omega, omega_n * sqrt(W)))
assert is_zero(shape - ((1 - W) ** 2 + 4 * zeta**2 * W))

by_stiffness_squared = c**2 * shape / 4
by_mass_squared = by_stiffness_squared / W**2
least = c * zeta * sqrt(1 - zeta**2)
for form, place in ((by_stiffness_squared, 1 - 2 * zeta**2), (by_mass_squared, 1 / (1 - 2 * zeta**2))):
    assert is_zero(diff(form, W).subs(W, place))
    assert is_zero(form.subs(W, place) - least**2)
    assert is_zero(form.subs(W, 1) - natural_frequency_jnd**2)
assert is_zero(by_stiffness_squared - least**2 - c**2 * (W - 1 + 2 * zeta**2) ** 2 / 4)  # no less anywhere
assert is_zero(by_mass_squared.subs(W, 1 / W) - by_stiffness_squared)

# %% [markdown]
# ## 4. The package says the same
#
# Its three JNDs, for a mass-spring-damper and for environments of other kinds, squared (both sides are positive).

# %%
import haptisym as hs

E = hs.environments
k0, k1, b1, m2, b2, k2 = symbols("k0 k1 b1 m2 b2 k2", positive=True)
maxwell = k1 * b1 * s / (k1 + b1 * s)
hung = m * s**2 + b * s + k + (k2 + b2 * s) * m2 * s**2 / (m2 * s**2 + b2 * s + k2)

for environment, dynamics in (
    (E.mass_spring_damper(m, b, k), H),
    (E.zener(k0, k1, b1), k0 + maxwell),
    (E.two_mass(m, b, k, m2, b2, k2), hung),
):
    packaged = hs.distort(environment).parameter_jnd(c)
    of = {modulus: sqrt(squared_modulus(dynamics))}
    assert is_zero(jnd["stiffness"].subs(of) ** 2 - packaged.stiffness**2), environment.model
    assert is_zero(jnd["damping"].subs(of) ** 2 - packaged.damping**2), environment.model
    assert is_zero(jnd["mass"].subs(of) ** 2 - packaged.mass**2), environment.model

stiffness_jnd = hs.distort(E.mass_spring_damper(m, b, k)).parameter_jnd(c).stiffness
assert is_zero((stiffness_jnd / (2 * k)).subs(at_resonance) ** 2 - natural_frequency_jnd**2)

# %% [markdown]
# And an evaluation notices what these formulas say is noticed. The environment 1 kg, 2 Ns/m, 115 N/m has at 10 rad/s
# $H = 15 + 20j$, $|H| = 25$ N/m: with $c$ = 10 %, 2.5 N/m more stiffness should meet the threshold of $r_r$ exactly at 10
# rad/s, so should 25 g more mass, and 0.25 Ns/m more damping that of $r_i$.

# %%
from haptisym import CrossingKind, Part

BAND = (Integer(0), Integer(20))
PERCEIVED = {m: 1, b: 2, k: 115}
TEN_PERCENT = Rational("0.1")


def noticed(values: dict[Symbol, Expr], more: dict[Symbol, Expr]) -> list[tuple[Part, CrossingKind, str]]:
    """The crossings if an environment is rendered with more of a parameter."""
    changed = {name: value + more.get(name, 0) for name, value in values.items()}
    scene = hs.Scene(E.mass_spring_damper(*values.values()), (), BAND, rendered=E.mass_spring_damper(*changed.values()))
    return [(x.part, x.kind, x.omega.digits(30)) for x in hs.evaluate(scene).crossings]


def excess(values: dict[Symbol, Expr], change: Expr) -> Poly:
    """(r/c)^2 - 1 over a positive factor, in W = omega^2, where a part of dH has that modulus."""
    return Poly((change**2 - TEN_PERCENT**2 * square).subs(values).expand().subs(omega, sqrt(W)), W)


def places(values: dict[Symbol, Expr], change: Expr) -> list[str]:
    """The frequencies at which the ratio is c, in order."""
    return sorted((str(sqrt(root).evalf(30)) for root in excess(values, change).ground_roots()), key=float)


at_ten = {omega: 10, c: TEN_PERCENT}
jnd_at_ten = {name: form.subs(modulus, sqrt(square)).subs(PERCEIVED).subs(at_ten) for name, form in jnd.items()}
assert jnd_at_ten == {"stiffness": Rational("2.5"), "damping": Rational("0.25"), "mass": Rational("0.025")}
TEN = str(Integer(10).evalf(30))
EXCEEDS, RETURNS = CrossingKind.EXCEEDS, CrossingKind.RETURNS
for parameter, name, part, change in (
    (k, "stiffness", Part.REAL, jnd_at_ten["stiffness"]),
    (b, "damping", Part.IMAG, jnd_at_ten["damping"] * omega),
    (m, "mass", Part.REAL, jnd_at_ten["mass"] * omega**2),
):
    found = noticed(PERCEIVED, {parameter: jnd_at_ten[name]})
    assert [row[0] for row in found] == [part, part], name
    assert [row[1] for row in found] == [EXCEEDS, RETURNS], name
    assert [row[2] for row in found] == places(PERCEIVED, change), name
    assert found[0][2] == TEN, name

# %% [markdown]
# The natural frequency: 1 kg, 5 Ns/m, 100 N/m has $\omega_n = 10$ rad/s, $\zeta = 1/4$, so $c\zeta = 2.5$ %. A stiffness 5
# % higher (an $\omega_n$ higher by 2.5 % to first order) meets the threshold at 10 rad/s; by section 3 it exceeds it from a
# little below on.

# %%
RESONANT = {m: 1, b: 5, k: 100}
found = noticed(RESONANT, {k: 5})
assert [row[:2] for row in found] == [(Part.REAL, EXCEEDS), (Part.REAL, RETURNS)]
assert [row[2] for row in found] == places(RESONANT, Integer(5)) == [str(sqrt(75).evalf(30)), TEN]
least_change = 2 * 100 * least.subs({c: TEN_PERCENT, zeta: Rational(1, 4)})
assert noticed(RESONANT, {k: Rational(str(least_change.evalf(20))) - Rational(10) ** -15}) == []
assert len(noticed(RESONANT, {k: Rational(str(least_change.evalf(20))) + Rational(10) ** -15})) == 2

# %% [markdown]
# ## 5. Formulas and figure

# %%
from matplotlib.figure import Figure
from numpy import linspace
from sympy import lambdify

from haptisym import latex

output = Path(next((given for given in sys.argv[1:2] if not given.startswith("-")), "derived"))
output.mkdir(parents=True, exist_ok=True)

whole = {modulus: sqrt(square)}
formulas = {
    r"\Delta_{jnd} k": jnd["stiffness"].subs(whole),
    r"\Delta_{jnd} b": jnd["damping"].subs(whole),
    r"\Delta_{jnd} m": jnd["mass"].subs(whole),
    r"\frac{\Delta_{jnd} \omega_n}{\omega_n} (\omega = \omega_n)": natural_frequency_jnd,
    r"\min_\omega \frac{\Delta_{jnd} \omega_n}{\omega_n}": least,
}
formulas_tex = [f"{name} &= {latex(form)}" for name, form in formulas.items()]
(output / "06_parameter_jnd.tex").write_text(
    "\\begin{align}\n" + " \\\\\n".join(formulas_tex) + "\n\\end{align}\n", encoding="utf-8"
)

# %% [markdown]
# Left, the JND of each parameter of the paper's example (1.8 kg, 15 Ns/m, 100 N/m) as a fraction of itself: about 10 % for
# the stiffness below the changeover, for the mass above it, and much more elsewhere. Right, the JND of the natural
# frequency by a stiffness, over the frequency of movement, with $c\zeta$ marked.

# %%
figure = Figure(figsize=(7.0, 2.9), layout="constrained")
fractions, natural = figure.subplots(1, 2)
EXAMPLE = {m: Rational("1.8"), b: 15, k: 100, c: TEN_PERCENT}
grid = linspace(0.5, 15, 601)
for parameter, name, style in ((k, "stiffness", "-"), (b, "damping", "--"), (m, "mass", ":")):
    relative = (100 * jnd[name].subs(whole) / parameter).subs(EXAMPLE)
    fractions.semilogy(grid, lambdify(omega, relative, "numpy")(grid), style, color="k", lw=1.2, label=name)
fractions.axhline(10, color="0.3", lw=0.8, ls=":")
fractions.set(xlim=(0, 15), ylim=(5, 500), xlabel=r"$\omega$ (rad/s)", ylabel="JND of the parameter (%)")
fractions.legend(loc="upper right", frameon=False, fontsize=8)

relative_frequencies = linspace(0, 2, 401)
of_ratio = lambdify((W, zeta), sqrt(by_stiffness_squared.subs(c, 10)), "numpy")  # in per cent
for ratio, style in {0.25: "-", 0.5: "--", 1.0: ":"}.items():
    shown = of_ratio(relative_frequencies**2, ratio)
    natural.plot(relative_frequencies, shown, style, color="k", lw=1.2, label=rf"$\zeta$ = {ratio:g}")
    natural.plot(1, 10 * ratio, "o", color="k", ms=4)
natural.set(xlim=(0, 2), ylim=(0, 15), xlabel=r"$\omega/\omega_n$", ylabel=r"JND of $\omega_n$ (%)")
natural.legend(loc="lower right", frameon=False, fontsize=8)
figure.savefig(output / "06_parameter_jnd.pdf", metadata={"CreationDate": None})
