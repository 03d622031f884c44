# %% [markdown]
# # Abbott and Okamura (2005): quantisation and friction
#
# *Effects of Position Quantization and Sampling Rate on Virtual-Wall Passivity*, IEEE Transactions on Robotics 21(5), 952. Read: abstract
# and the condition, $K \le \min(2 b/T, 2 f_c/\Delta)$. haptisym decides the first term exactly; friction and the encoder's steps are not
# in its passivity test, so that the second is arithmetic.

# %%
from book import Table, apart, number

import haptisym as hs

scene = hs.Scene(
    hs.environments.mass_spring_damper(k=50),
    (hs.effects.sampled_loop(T="1 ms", method="backward-difference"), hs.effects.shunt(m="40 g", b=0.1)),
    (0, 100),
)
most = hs.require(scene, "environment.k", that=("passive",)).feasible[-1].high.digits(15)
rows = Table(
    [
        number("2 b/T, b = 0.1 N s/m, T = 1 ms", "condition", "200", most, "N/m"),
        apart(
            "2 f_c/Δ, f_c = 0.05 N, Δ = 61.4 μm", "condition", f"{2 * 0.05 / 61.4e-6:.2f} N/m", "none",
            "a nonlinear friction and an encoder's steps are outside a linear test",
        ),
    ]
)  # fmt: skip
rows
