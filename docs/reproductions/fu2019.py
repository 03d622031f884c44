# %% [markdown]
# # Fu, van Paassen and Mulder (2019): the two steps
#
# *Framework for a Two-step Evaluation of Haptic Displays*, IFAC-PapersOnLine 52(19), 97-102,
# [doi:10.1016/j.ifacol.2019.12.119](https://doi.org/10.1016/j.ifacol.2019.12.119), section 3. Read: whole. The frequencies are read off
# figure 5; $m = 1.8$ kg, $b = 15$ N s/m, $k = 100$ N/m behind $6400/(s^2 + 80 s + 6400)$, $c = 10\ \%$.

# %%
from book import Table, apart, number, statement

import haptisym as hs

found = hs.evaluate("fu2019", movement="0:15")
onset = {x.part.value: x.omega for x in found.crossings}
felt = [f"{x.change.value} {x.property.value}" for x in found.percepts]
best = hs.design(hs.load_scene("fu2019").with_band(0, 60), {"zeta": (0.01, 1)}, keep="passive", gap="1e-7")
fit = ", ".join(f"{key} {float(100 * x):+.2g} %" for key, x in found.to_dict()["movement"]["change"].items())

rows = Table(
    [
        number("real part noticed from", "section 3, figure 5", "8", onset["real"].digits(15), "rad/s"),
        number("imaginary part noticed from", "section 3, figure 5", "12", onset["imag"].digits(15), "rad/s"),
        number(
            "changeover of the environment", "section 3", "7.45", found.changeovers_environment[0].omega.digits(15), "rad/s"
        ),
        statement("stiffness", "section 3", "preserved", "in no percept", not any("stiffness" in x for x in felt)),
        statement("mass above 8 rad/s", "section 3, figure 7a", "lower", felt[0], felt[0] == "lower mass"),
        statement("damping above 12 rad/s", "section 3, figure 7b", "higher", felt[1], felt[1] == "higher damping"),
        apart(
            "best damping ratio of the filter", "", "not given",
            f"ζ = {float(best.best.values[0]):.7f}, to {float(best.best.bandwidth):.5f} rad/s", "the paper asks for none",
        ),
        apart("fit of k, b, m to a flat movement, 0 to 15 rad/s", "", "not given", fit, "the paper fits none"),
    ]
)  # fmt: skip
rows
