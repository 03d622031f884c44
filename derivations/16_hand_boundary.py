r"""Does it shake in a hand? The boundary of stability is the negative of what is felt, shifted by the mass of the hand.

Claim. A hand m_h, b_h, k_h that holds a display moves by H_perc(s) + m_h s^2 + b_h s + k_h. A root of that lies on the imaginary
axis at omega > 0 exactly where

    k_h = m_h omega^2 - Re H_perc(j omega),        b_h = -Im H_perc(j omega)/omega:

the negative of the effective stiffness and damping that step 2 names, the stiffness shifted by m_h omega^2; and at omega = 0 on
the line k_h = -H_perc(0). So a hand that damps more than b* = sup(-Im H_perc/omega) never meets the boundary, whatever its mass
and stiffness. A spring K that comes late by tau has b_h = K sin(omega tau)/omega <= b* = K tau, its limit as omega -> 0. The
two questions trade off: a hand b holds it for all masses and stiffnesses exactly while tau <= b/K, and it is transparent then up
to asin(c)/tau >= asin(c) K/b; K = 100 N/m, b = 5.5 N s/m, c = 0.1: 1.82122583930108720628 rad/s. In the hand 0.554 kg, 6.45
N s/m, 135 N/m a spring 36 ms late is stable up to K = 199.85210225871012834 N/m, where it oscillates at 22.244306341605851 rad/s.

Assumptions. Linear; the hand and the display move together; m_h, b_h, k_h >= 0; K, tau > 0; 0 < c < 1.

Source. D-decomposition (Neimark), derived anew here; step 2: W. Fu, M. M. van Paassen, M. Mulder (2019), section 2.3,
doi:10.1016/j.ifacol.2019.12.119. The hand: Scientific Reports 5, 18004 (2015), figure 3.

Run as ``python 16_hand_boundary.py [directory]``; formulas and figure go to the directory, ``derived`` if none is given.
"""

# %%
import sys
from pathlib import Path

from mpmath import mp, mpf
from sympy import (
    Expr,
    Function,
    I,
    Rational,
    Symbol,
    cos,
    diff,
    exp,
    expand,
    fraction,
    limit,
    pi,
    sin,
    solve,
    symbols,
    together,
)

m_h, b_h, k_h, omega, K, tau, c = symbols("m_h b_h k_h omega K tau c", positive=True)
s, t, X = symbols("s t X")


def is_zero(difference: Expr) -> bool:
    """Whether an expression is zero identically: waves as exponentials, over a common denominator, multiplied out."""
    return expand(fraction(together(difference.rewrite(exp)))[0]) == 0


# %% [markdown]
# ## 1. Hand and display move together
#
# The display pushes back with $f = H_{perc} x$, the hand with its inertia, damping and stiffness. Nobody else pushes. With
# $x = X e^{st}$ that leaves $(H_{perc} + m_h s^2 + b_h s + k_h) X = 0$: motions that go on by themselves are the zeros of the
# bracket, and they grow where $\mathrm{Re}\,s > 0$.

# %%
H = Function("H")(s)
motion = X * exp(s * t)
hand = m_h * motion.diff(t, 2) + b_h * motion.diff(t) + k_h * motion
characteristic = H + m_h * s**2 + b_h * s + k_h
assert is_zero((H * motion + hand) / motion - characteristic)

# %% [markdown]
# ## 2. On the axis
#
# Write $H_{perc}(j\omega) = R + jI$. Real and imaginary part of the bracket vanish together at one pair $k_h, b_h$ for each
# $\omega > 0$: a curve in the hand's plane. At $\omega = 0$ the damping does not matter.

# %%
R, J = symbols("R J", real=True)
on_axis = characteristic.subs(H, R + I * J).subs(s, I * omega)
real, imag = R + k_h - m_h * omega**2, J + b_h * omega
assert is_zero(on_axis - (real + I * imag))
boundary = solve([real, imag], [k_h, b_h])
assert is_zero(boundary[k_h] - (m_h * omega**2 - R))
assert is_zero(boundary[b_h] + J / omega)

# %% [markdown]
# ## 3. A spring that comes late
#
# $H_{perc} = K e^{-s\tau}$. As $\sin x < x$, the damping on the boundary stays below its limit $K\tau$ at $\omega \to 0$.

# %%
late = K * exp(-s * tau)
k_late = m_h * omega**2 - K * cos(omega * tau)
b_late = K * sin(omega * tau) / omega
assert is_zero(late.subs(s, I * omega) + m_h * (I * omega) ** 2 + b_late * I * omega + k_late)
assert limit(b_late, omega, 0) == K * tau
u = Symbol("u", positive=True)
rise = u - sin(u)  # 0 at 0, and its slope 1 - cos u is nowhere negative
assert rise.subs(u, 0) == 0
assert is_zero(diff(rise, u) - 2 * sin(u / 2) ** 2)

# %% [markdown]
# A hand $b$ is enough for all masses and stiffnesses while $b^* = K\tau \le b$. The delay is noticed from $\sin\omega\tau = c$ on
# ([`02_delay_budget.py`](02_delay_budget.py)), at $\omega = \mathrm{asin}(c)/\tau \ge \mathrm{asin}(c) K/b$: what keeps a soft
# spring from shaking keeps it transparent, too.
#
# With less damping, $b < K\tau$, some hand shakes: $K\sin(\omega\tau)/\omega$ falls from $K\tau$ to 0 on $(0, \pi/\tau]$, so
# that it is $b$ at one frequency there, and every mass $m_h \ge K\cos(\omega\tau)/\omega^2$ has a stiffness $k_h \ge 0$ with
# roots on the axis. So whoever wants all masses and stiffnesses held must have $\tau \le b/K$: design for stability bounds
# the bandwidth from below.

# %%
falls = u * cos(u) - sin(u)  # of the sign of the slope of sin(u)/u; 0 at 0, its own slope -u sin(u) < 0 on (0, pi)
assert falls.subs(u, 0) == 0
assert is_zero(diff(falls, u) + u * sin(u))
assert b_late.subs(omega, pi / tau) == 0
least_mass = K * cos(omega * tau) / omega**2
assert is_zero(k_late.subs(m_h, least_mass))
assert diff(k_late, m_h) == omega**2
mp.dps = 40
least = mp.asin(mpf(1) / 10) * 100 / mpf("5.5")
assert mp.nstr(least, 21) == "1.82122583930108720628"

# %% [markdown]
# ## 4. How stiff may it be in one hand?
#
# $K e^{-j\omega\tau} = m_h\omega^2 - k_h - jb_h\omega$ on the boundary: the angle tells $\omega$, the length $K$.

# %%
mass, damping, stiffness, delay = mpf("0.554"), mpf("6.45"), mpf(135), mpf("0.036")


def angle(w: mpf) -> mpf:
    """Im of (m w^2 - k - j b w) exp(j w tau): 0 on the boundary."""
    return ((mass * w**2 - stiffness - 1j * damping * w) * mp.expj(w * delay)).imag


frequency = mp.findroot(angle, mpf("22.24"))
stiffest = abs(mass * frequency**2 - stiffness - 1j * damping * frequency)
assert mp.nstr(stiffest, 20) == "199.85210225871012834"
assert mp.nstr(frequency, 17) == "22.244306341605851"

# %% [markdown]
# ## 5. The package says the same

# %%
import haptisym as hs

for name in ("fu2019", "delayed-spring", "position-force-teleoperation"):
    d = hs.load_scene(name).distortion()
    response = d.perceived.subs(hs.s, I * hs.omega)
    own = d.perc_response.real.expression() + I * d.perc_response.imag.expression()
    assert is_zero(response - own)
    k_on = m_h * hs.omega**2 - d.perc_response.real.expression()
    b_on = -d.perc_response.imag.expression() / hs.omega
    assert is_zero(response + m_h * (I * hs.omega) ** 2 + b_on * I * hs.omega + k_on)

arm = hs.stability("delayed-spring", "postural-arm", free=["environment.k"], digits=20).to_dict()
[row] = [x for x in arm["held"][0]["critical"] if x["path"] == "environment.k"]
assert row["digits"] == mp.nstr(stiffest, 20)
assert abs(row["omega"] - frequency) < mpf(10) ** -14
assert arm["every_passive_hand"]["damping"] == float(100 * Rational(36, 1000))

soft = hs.Scene(hs.environments.mass_spring_damper(k=100), (hs.effects.delay(Rational("5.5") / 100),))
assert hs.stability(soft).to_dict()["every_passive_hand"]["damping"] == 5.5
[first, *_] = hs.evaluate(soft, 20).crossings
assert first.omega.digits(21) == mp.nstr(least, 21)

# %% [markdown]
# ## 6. Formulas and figure

# %%
from haptisym import latex

output = Path(next((given for given in sys.argv[1:2] if not given.startswith("-")), "derived"))
output.mkdir(parents=True, exist_ok=True)
lines = [rf"k_h &= {latex(k_late)}", rf"b_h &= {latex(b_late)} \le K \tau"]
(output / "16_hand_boundary.tex").write_text(
    "\\begin{align}\n" + " \\\\\n".join(lines) + "\n\\end{align}\n", encoding="utf-8"
)
hs.stability("delayed-spring", "postural-arm").save_figure(output / "16_hand_boundary.pdf")
