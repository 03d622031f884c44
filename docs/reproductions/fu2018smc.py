# %% [markdown]
# # Fu, van Paassen and Mulder (2018): mass and stiffness together
#
# *Modeling the Coupled Difference Threshold of Perceiving Mass and Stiffness from Force*, IEEE SMC,
# [repository.tudelft.nl, uuid 9d2fac79](https://repository.tudelft.nl/record/uuid:9d2fac79-0b75-4f73-974c-89d6b2b902d9). Read: abstract,
# without numbers. The threshold of haptisym was made from these data: agreement is no independent support. Computed at 6 rad/s.

# %%
from book import Table, statement

import haptisym as hs


def forces(b):
    """JND of the spring force and of the inertia force, per displacement."""
    jnd = hs.distort(hs.environments.mass_spring_damper(2, b, 100), hs.effects.delay(0)).parameter_jnd(0.1)
    return float(jnd.stiffness.subs(hs.omega, 6)), float((jnd.mass * hs.omega**2).subs(hs.omega, 6))


spring, inertia = zip(*map(forces, (2, 10, 30)), strict=True)
rows = Table(
    [
        statement(
            "JND of spring force and inertia force", "abstract", "identical", f"{spring[1]:.5g} and {inertia[1]:.5g} N/m",
            abs(spring[1] - inertia[1]) < 1e-9,
        ),
        statement(
            "both, with damping", "abstract", "rise", " < ".join(f"{x:.3g} N/m" for x in spring), sorted(spring) == list(spring)
        ),
    ]
)  # fmt: skip
rows
