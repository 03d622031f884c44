# %% [markdown]
# # 14 CFR Part 60: control dynamics
#
# Appendix A, table A2A, 2.b, and appendix C, table C2A, 2.a.5. Read: both tables. They publish tolerances, no results; the case is $m = 1.8$ kg,
# $b = 3$ N s/m, $k = 100$ N/m with a handle of 0.3384 kg and 0.6 N s/m, whose numbers follow from
# $x(t) = e^{-\sigma t}(\cos\omega t + \sigma/\omega\,\sin\omega t)$.

# %%
from book import Table, apart

import haptisym as hs

stick = hs.Scene(
    hs.environments.mass_spring_damper("1.8 kg", 3, 100), (hs.effects.shunt(m="0.3384 kg", b=0.6),), (0, 15)
)
damped = hs.Scene(hs.environments.mass_spring_damper("1 kg", 30, 100), (hs.effects.shunt(m="0.6 kg"),), (0, 15))
WHY = "the rule has tolerances, no results"


def checks(scene, table):
    return {x.what.split(",")[0]: x for x in hs.metrics(scene)[f"free response, {table}"].values}


def row(what, table, check, tolerance):
    change = float(check.value) / float(check.reference) - 1
    computed = (
        f"{check.reference.digits(9)} s, with the handle {100 * change:+.3f} %: {'passes' if check.kept else 'fails'}"
    )
    return apart(what, table, tolerance, computed, WHY)


aeroplane, helicopter = checks(stick, "aeroplanes"), checks(stick, "helicopters")
rows = Table(
    [
        row("from 0.9 A_d to the first zero crossing", "A2A, 2.b", aeroplane["P_0"], "10 %"),
        row("from release to the first zero crossing", "C2A, 2.a.5", helicopter["P_0"], "10 %"),
        row("first period", "A2A, 2.b", aeroplane["P_1"], "20 %"),
        row(
            "overdamped, from 0.9 to 0.1 A_d", "A2A, 2.b", checks(damped, "aeroplanes")["time from 90 % to 10 % of A_d"], "10 %"
        ),
    ]
)  # fmt: skip
rows
