# %% [markdown]
# # PLoS ONE 10(9), e0138012 (2015): mass behind a delay
#
# People push a mass of 6 kg off an admittance display whose position comes late. Read: fragments. haptisym judges steady oscillation,
# where a delay of either sign leaves $m\cos\omega\tau$ of the mass; the push is a transient. Computed at 1 Hz.

# %%
from math import tau as turn

from book import Table, statement

import haptisym as hs


def mass(delay):
    d = hs.distort(hs.environments.mass_spring_damper(m="6 kg"), hs.effects.delay(delay))
    return 100 * (float(d.compile()([turn]).perceived_real[0]) / (-6 * turn**2) - 1)


rows = Table(
    [
        statement(
            f"mass felt with {delay}", "results", f"+{published} %", f"{mass(delay):+.2f} %", mass(delay) > 0, "sign"
        )
        for delay, published in (("25 ms", 10), ("50 ms", 20))
    ]
)
rows
