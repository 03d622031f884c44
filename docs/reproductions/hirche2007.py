# %% [markdown]
# # Hirche and Buss (2007): what a delayed wave link displays
#
# *Human Perceived Transparency with Time Delay*, STAR 31. Read: abstract, which says that displayed stiffness, mass and damping are derived;
# the formulas here are derived from `wave-variables` with one-way delay $T/2$ and impedance $b$. $k = 100$ N/m, $b = 10$ N s/m,
# $T = 40$ ms.

# %%
from book import Table, apart

import haptisym as hs

link = hs.effects.wave_variables(b="10 N*s/m", tau="20 ms")
WHY = "only the abstract was read"


def felt(environment, omega=1e-3):
    return float(hs.distort(environment, link).compile()([omega]).perceived_real[0])


spring = felt(hs.environments.mass_spring_damper(k=100))
mass = -felt(hs.environments.mass_spring_damper(m="1e-6 kg")) / 1e-6
rigid = felt(hs.environments.mass_spring_damper(k=1e12))
scene = hs.Scene(hs.environments.mass_spring_damper(k=100), (link,), ("1e-4 rad/s", "2e-4 rad/s"), hs.Threshold.of(0.1))
most = 2 * float(hs.require(scene, "effects.wave-variables.tau", ("0.1 ms", "100 ms")).feasible[-1].high)
rows = Table(
    [
        apart("stiffness k/(1 + k T/2b)", "", f"{100 / 1.2:.4f} N/m, derived", f"{spring:.4f} N/m", WHY),
        apart("mass in free air, b T/2", "", "0.2 kg, derived", f"{mass:.4f} kg", WHY),
        apart("rigid contact, 2 b/T", "", "500 N/m, derived", f"{rigid:.4f} N/m", WHY),
        apart("within 10 % while T is at most", "", "0.222 b/k, derived", f"{most * 10:.4f} b/k", WHY),
    ]
)
rows
