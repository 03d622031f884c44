# %% [markdown]
# # Lécuyer and others (2000): compliance
#
# JND of compliance 6 % between two virtual springs, 13.4 % between a virtual and a real one. Read: abstract. The
# paper's threshold, as a compliance of a spring that is moved slowly, is between them.

# %%
from book import Table, apart

import haptisym as hs

jnd = hs.distort(hs.environments.mass_spring_damper(k=100), hs.effects.delay(0)).parameter_jnd(0.1)
stiffer, softer = (100 * (1 / (1 + sign * float(jnd.stiffness) / 100) - 1) for sign in (1, -1))
WHY = "stiffness, movement and criterion were not read"
rows = Table(
    [
        apart(f"compliance JND, {what}", "abstract", published, f"{stiffer:+.2f} to {softer:+.2f} % at c = 10 %", WHY)
        for what, published in (("virtual, virtual", "6 %"), ("virtual, real", "13.4 %"))
    ]
)
rows
