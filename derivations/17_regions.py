r"""The disc inside the box, the box inside the disc: by how much the bandwidth depends on the shape of the JND region.

Claim. With x = Re dH/|H_env|, y = Im dH/|H_env| and half widths c the diamond |x| + |y| <= c lies in the disc x^2 + y^2 <= c^2,
the disc in the box |x|, |y| <= c, and that in the disc of sqrt(2) c. So the bandwidths w of diamond, disc and box keep

    w_diamond(c) <= w_disc(c) <= w_box(c) <= w_disc(sqrt(2) c),        w_disc(c) <= w_diamond(sqrt(2) c),

and nothing better holds of disc and box for all environments: both ends are attained. A first-order lag, r = |dH/H_env| =
omega/sqrt(omega^2 + omega_c^2), has w_disc(c) = omega_c c/sqrt(1 - c^2) whatever the environment, so that

    1 <= w_box(c)/w_disc(c) <= sqrt(2 (1 - c^2)/(1 - 2 c^2)),

which is sqrt(99)/7 = 1.4214... for c = 1/10. It is attained by H_env = 3 + 4 s behind a lag of 7 rad/s: at 1 rad/s both parts
of dH are exactly a tenth of |H_env|. The lower end is attained by H_env = omega_c + s: there dH = -s is imaginary throughout.

Regions that hold all smaller ones. A region R(p) that grows with each of its numbers makes the bandwidth grow with each, so
that over a box of them the least and the most bandwidth are those of two corners. Half widths of the diamond and of the
ellipse without tilt are such numbers; those of a tilted ellipse (x/a)^2 - 2 t (x/a)(y/b) + (y/b)^2 <= 1 - t^2 are not:
with t = 1/2 and b = 1 the point (1/2, 1) is on the border of that of a = 1 and outside that of a = 2. A multiple of any
such region holds it.

Assumptions. Linear; one frequency at a time; 0 < c < 1/sqrt 2.

Source. Eq. (4) of W. Fu, M. M. van Paassen, M. Mulder, Framework for a Two-step Evaluation of Haptic Displays, IFAC-PapersOnLine
52(19) 97-102, 2019, doi:10.1016/j.ifacol.2019.12.119: its region is the box, and how both parts work together is left open.

Run as ``python 17_regions.py [directory]``; formulas and figure go to the directory, ``derived`` if none is given.
"""

# %%
import sys
from pathlib import Path

from sympy import I, Rational, expand, fraction, im, re, sqrt, symbols, together

omega, omega_c, c, r = symbols("omega omega_c c r", positive=True)
x, y, a, b = symbols("x y a b", real=True)


def is_zero(difference: object) -> bool:
    """Whether an expression is zero identically: exact, over a common denominator and multiplied out."""
    return bool(expand(fraction(together(difference))[0]) == 0)


# %% [markdown]
# ## 1. One region in the other
#
# With $a = |x|$ and $b = |y|$, both at least 0: $(a + b)^2 - (a^2 + b^2) = 2ab \ge 0$, so that the diamond is in the disc, and
# $a^2 + b^2 - \max(a, b)^2 = \min(a, b)^2 \ge 0$, so that the disc is in the box. In the box $a^2 + b^2 \le 2c^2$; in the disc
# $(a + b)^2 = 2(a^2 + b^2) - (a - b)^2 \le 2c^2$. What is transparent for a region is so for a larger one, at each
# frequency: the
# bandwidth, the end of the first transparent interval, grows with the region.

# %%
assert is_zero((a + b) ** 2 - (a**2 + b**2) - 2 * a * b)
assert is_zero((a + b) ** 2 + (a - b) ** 2 - 2 * (a**2 + b**2))

# %% [markdown]
# ## 2. A lag: the most that box and disc can differ
#
# Behind a force lag $G = \omega_c/(s + \omega_c)$ the change is $(G - 1)H$, whatever $H$ is, and $|G - 1|$ grows with
# $\omega$. The disc
# is left where $|G - 1| = c$; the box nowhere before that, and at the latest where $|G - 1| = \sqrt 2\,c$.

# %%
G = omega_c / (I * omega + omega_c)
square = expand(re(expand((G - 1) * (G - 1).conjugate(), complex=True)))
assert is_zero(square - omega**2 / (omega**2 + omega_c**2))
disc = omega_c * r / sqrt(1 - r**2)
assert is_zero(square.subs(omega, disc) - r**2)
most = sqrt(2 * (1 - c**2) / (1 - 2 * c**2))
assert is_zero((disc.subs(r, sqrt(2) * c) / disc.subs(r, c)) ** 2 - most**2)

# %% [markdown]
# ## 3. Both ends are attained
#
# $H = 3 + 4s$ behind $7/(s + 7)$, at $\omega = 1$: $H = 3 + 4j$, $|H| = 5$, and what is felt is $7(3 + 4j)/(7 + j) = 3.5
# + 3.5j$. Each part of
# the change is $0.5 = |H|/10$. At all lower frequencies both parts are smaller: $|H|^2/100$ less their squares has no zero in
# $(0, 1)$, by Sturm's theorem. The lower end: $H = \omega_c + s$ is made $\omega_c$ by the lag, $\Delta H = -s$.

# %%
H = 3 + 4 * I * omega
change = (7 / (I * omega + 7) - 1) * H
at_one = change.subs(omega, 1).expand(complex=True)
assert (re(at_one), im(at_one)) == (Rational(1, 2), -Rational(1, 2))
assert expand(H.subs(omega, 1) * H.subs(omega, 1).conjugate()) == 25
for part in (re, im):
    own = part(change.expand(complex=True))
    room = fraction(together((9 + 16 * omega**2) / 100 - own**2))[0]
    met = room.as_poly(omega)
    assert met.count_roots(0, 1) == met.count_roots(1, 1) == 1  # at 1 alone
    assert room.subs(omega, Rational(1, 2)) > 0
assert is_zero(most.subs(c, Rational(1, 10)) ** 2 - Rational(99, 49))
assert is_zero((G - 1) * (omega_c + I * omega) + I * omega)

# %% [markdown]
# ## 4. Regions that hold all smaller ones
#
# $R(p) \subseteq R(q)$ makes what is noticed with $q$ noticed with $p$, at every frequency, so that the first frequency at
# which something is noticed is no later with $p$. With half widths $a$, $b$ the disc's $(x/a)^2 + (y/b)^2$ and the
# diamond's $|x|/a + |y|/b$ fall as $a$ grows. The tilted ellipse's form does not: its derivative to $1/a$ changes its sign
# with $x/a - t\,y/b$. Scaled by $\lambda \geq 1$ it falls, like $1/\lambda^2$.

# %%
t, u, v = symbols("t u v", real=True)  # u = x/a, v = y/b
tilted = u**2 - 2 * t * u * v + v**2
half = {t: Rational(1, 2), v: 1}
assert tilted.subs(half).subs(u, Rational(1, 2)) == Rational(3, 4)  # (1/2, 1) with a = 1: 1 - t^2, on the border
assert tilted.subs(half).subs(u, Rational(1, 4)) == Rational(13, 16) > Rational(3, 4)  # with a = 2: outside
assert is_zero(tilted.diff(u) - 2 * (u - t * v))
assert is_zero(tilted.subs({u: u / r, v: v / r}, simultaneous=True) - tilted / r**2)

# %% [markdown]
# ## 5. The package says the same
#
# Exactly: bandwidths are certified numbers, and those of the box are rational here.

# %%
import haptisym as hs
from haptisym import effects, environments
from haptisym.figures import evaluation as evaluation_charts
from haptisym.figures.layers import draw


def widths(environment: hs.Environment, speed: int, half: Rational, high: int) -> dict[str, hs.RealNumber]:
    """The bandwidths of square, disc and diamond behind a lag."""
    scene = hs.Scene(environment, (effects.first_order_lag(speed),), (0, high), hs.Threshold.of(half))
    return {x.name: x.bandwidth for x in hs.evaluate(scene, regions=True).regions}


TENTH = Rational(1, 10)
widest = widths(environments.kelvin_voigt(3, 4), 7, TENTH, 5)
assert widest["square"].digits(50).rstrip("0") == "1."
ratio = most.subs(c, TENTH)
assert widest["disc"].digits(40) == str((1 / ratio).evalf(40))
narrowest = widths(environments.kelvin_voigt(4, 1), 4, Rational(3, 5), 10)
assert narrowest["square"].digits(50) == narrowest["disc"].digits(50) == narrowest["diamond"].digits(50)
assert float(narrowest["disc"]) == float(disc.subs({r: Rational(3, 5), omega_c: 4})) == 3.0
paper = hs.evaluate("fu2019", regions=True).regions
ordered = [float(x.bandwidth) for name in ("diamond", "disc", "square") for x in paper if x.name == name]
assert ordered == sorted(ordered)

# %% [markdown]
# The ends of two ranges are two evaluations; for a tilted ellipse they would not be, and it is refused.

# %%
example = hs.load_scene("fu2019")


def judged(jnd: dict[str, object]) -> hs.Evaluation:
    """The paper's example with another JND."""
    return hs.evaluate(hs.Scene(example.environment, example.effects, example.band, jnd))


both = judged({"shape": "ellipse", "real": ["0.09", "0.11"], "imag": ["0.1", "0.12"]}).bandwidths
assert both
for end, (across, up) in ((both.least, ("0.09", "0.1")), (both.most, ("0.11", "0.12"))):
    corner = judged({"shape": "ellipse", "real": across, "imag": up}).bandwidth
    assert end is not None
    assert corner is not None
    assert end.digits(40) == corner.digits(40)
try:
    judged({"shape": "ellipse", "real": ["0.09", "0.11"], "imag": "0.1", "tilt": "0.5"})
    refused = False
except hs.SceneError:
    refused = True
assert refused

# %% [markdown]
# The formulas and the figure: the change's way through the plane, leaving the disc at $7/\sqrt{99}$ and the box in its
# corner at 1 rad/s.

# %%
from matplotlib.figure import Figure

output = Path(sys.argv[1] if len(sys.argv) > 1 else "derived")
output.mkdir(parents=True, exist_ok=True)
tex = rf"1 \leq \frac{{w_\mathrm{{box}}(c)}}{{w_\mathrm{{disc}}(c)}} \leq {hs.latex(most)}"
(output / "17_regions.tex").write_text(f"\\begin{{align}}\n{tex}\n\\end{{align}}\n", encoding="utf-8")
figure = Figure(figsize=(3.4, 3.8), layout="constrained")
lagging = hs.Scene(environments.kelvin_voigt(3, 4), (effects.first_order_lag(7),), (0, 2), hs.Threshold.of(TENTH))
draw(figure.subplots(), evaluation_charts.regions(hs.evaluate(lagging, regions=True)))
figure.savefig(output / "17_regions.pdf", metadata={"CreationDate": None})
