# %% [markdown]
# # Gil and others (2009), Hulin (2009): the linear condition
#
# $K < (b + B)/(T/2 + t_d)$, and without device damping $\alpha = 2\beta(2 - \beta)/(2 + \beta)$ with $\alpha = K T^2/m$, $\beta = B T/m$. Read: the
# formulas. One sample late, $b = 0.8$ N s/m, $T = 1$ ms, 40 g: the condition is the limit of passivity; in free air the exact limit is
# 0.55 % beyond it.

# %%
from math import sqrt

from book import Table, number

import haptisym as hs


def wall(environment, device, **loop):
    clock = hs.effects.sampled_loop(method="backward-difference", **loop)
    return hs.Scene(hs.environments.mass_spring_damper(**environment), (clock, hs.effects.shunt(**device)), (0, 1))


def stable_to(scene):
    return hs.stability(scene, "none", ("environment.k",)).to_dict()["held"][0]["critical"][-1]["digits"]


late = wall({"k": 100}, {"m": "40 g", "b": 0.8}, T="1 ms", delay=1)
passive = hs.require(late, "environment.k", that=("passive",)).feasible[-1].high.digits(15)
unit = wall({"k": 0.5, "b": "0.8284271247461901"}, {"m": 1}, T="1 s", delay=0)
rows = Table(
    [
        number("largest K, passive", "condition", "533.333", passive, "N/m"),
        number("largest K, stable in free air", "condition", "533.333", stable_to(late), "N/m"),
        number("largest α, at β = 2 sqrt 2 - 2", "boundary", f"{12 - 8 * sqrt(2):.10f}", stable_to(unit)),
    ]
)
rows
