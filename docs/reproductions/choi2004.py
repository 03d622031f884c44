# %% [markdown]
# # Choi and Tan (2004): update rate and textures
#
# *Effect of Update Rate on Perceived Instability of Virtual Haptic Texture*, IROS 2004. Read: abstract. From 250 Hz to 40 kHz the largest
# stiffness of a clean texture rises from 0.325 to 0.904 N/mm, "a 278% increase". Passivity, $K < 2 b/T$, would let it rise 160 times: it is
# not what limits textures.

# %%
from book import Table, number

import haptisym as hs


def most(T):
    loop, device = hs.effects.sampled_loop(T=T, method="backward-difference"), hs.effects.shunt(m="40 g", b=1)
    scene = hs.Scene(hs.environments.mass_spring_damper(k=50), (loop, device), (0, 100))
    return float(hs.require(scene, "environment.k", that=("passive",)).feasible[-1].high)


rows = Table(
    [
        number("0.904 over 0.325, as a ratio", "abstract", "2.78", 0.904 / 0.325),
        number("the same ratio, if passivity were the limit", "abstract", "2.78", most("25 us") / most("4 ms")),
    ]
)
rows
