# %% [markdown]
# # Li, Israr, Patoglu and O'Malley (2008): natural frequency
#
# *Passive and active kinesthetic perception JND for natural frequency*,
# [doi:10.1109/HAPTICS.2008.4479908](https://doi.org/10.1109/HAPTICS.2008.4479908). Read: abstract: 3.99 to 6.96 % at 1 and 2 Hz. The model
# gives $c\,\zeta$ for a stiffness or mass moved at resonance (`derivations/12_natural_frequency_jnd.py`).

# %%
from book import Table, apart

import haptisym as hs


def fraction(zeta):
    """JND of the natural frequency at resonance: half of c |H|/k."""
    d = hs.distort(hs.environments.mass_spring_damper(1, 2 * zeta, 1), hs.effects.delay(0))
    return float(d.parameter_jnd(0.1).stiffness.subs(hs.omega, 1)) / 2


assert abs(fraction(0.5) - 0.05) < 1e-12
rows = Table(
    [
        apart(
            "JND of the natural frequency", "abstract", "3.99 to 6.96 %",
            f"{100 * fraction(0.399):.2f} % at ζ = 0.399, {100 * fraction(0.696):.2f} % at ζ = 0.696, c = 10 %",
            "their damping ratio was not read",
        )
    ]
)  # fmt: skip
rows
