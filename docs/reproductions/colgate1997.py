# %% [markdown]
# # Colgate and Schenkel (1997): a sampled wall that is passive
#
# *Passivity of a class of sampled-data systems*. Read: the formulas, as later papers quote them: $b > K T/2 + \lvert B\rvert$. With
# $b = 0.8$ N s/m and $T = 1$ ms the largest spring is $2 b/T$. The wall in nobody's hand, on a device of 40 g, is stable a little further.

# %%
from book import Table, apart, number

import haptisym as hs

loop = hs.effects.sampled_loop(T="1 ms", method="backward-difference")
device = hs.effects.shunt(m="40 g", b=0.8)


def wall(**damping):
    return hs.Scene(hs.environments.mass_spring_damper(k=100, **damping), (loop, device), (0, 100))


def most(scene):
    return hs.require(scene, "environment.k", that=("passive",)).feasible[-1].high.digits(15)


free = hs.stability(wall(), "none", ("environment.k",)).to_dict()["held"][0]["critical"][-1]["digits"]
rows = Table(
    [
        number("largest passive K, B = 0", "condition", "1600", most(wall()), "N/m"),
        number("largest passive K, B = 0.3 N s/m", "condition", "1000", most(wall(b=0.3)), "N/m"),
        apart(
            "largest stable K in free air, 40 g",
            "",
            "not given",
            f"{free} N/m",
            "the condition is for any passive hand",
        ),
    ]
)
rows
