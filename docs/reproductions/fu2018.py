# %% [markdown]
# # Fu, Landman, van Paassen and Mulder (2018): JNDs that break Weber's law
#
# *Modeling Human Difference Threshold in Perceiving Mechanical Properties From Force*, THMS 48(4), 359-368,
# [doi:10.1109/THMS.2018.2844212](https://doi.org/10.1109/THMS.2018.2844212). Read: abstract, without numbers. The threshold of haptisym was
# made from these data: agreement is no independent support. Computed at 6 rad/s with $c\lvert H\rvert$.

# %%
from book import Table, statement

import haptisym as hs


def jnd(m, b, k):
    return hs.distort(hs.environments.mass_spring_damper(m, b, k), hs.effects.delay(0)).parameter_jnd(0.1)


fractions = [float(jnd(4, 2, k).stiffness.subs(hs.omega, 6)) / k for k in (50, 100, 144)]
damping = [float(jnd(2, 5, k).damping.subs(hs.omega, 6)) for k in (72, 150, 300)]
rows = Table(
    [
        statement(
            "stiffness JND as a fraction, with mass", "abstract", "falls as k rises",
            " > ".join(f"{100 * x:.1f} %" for x in fractions), sorted(fractions, reverse=True) == fractions,
        ),
        statement(
            "damping JND at constant damping", "abstract", "rises with the response of k and m",
            " < ".join(f"{x:.3g} N s/m" for x in damping), sorted(damping) == damping,
        ),
    ]
)  # fmt: skip
rows
