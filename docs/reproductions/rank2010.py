# %% [markdown]
# # Rank, Shi, Müller and Hirche (2010): delay
#
# *The Influence of Different Haptic Environments on Time Delay Discrimination in Force Feedback*, LNCS 6191,
# [doi:10.1007/978-3-642-14064-8_30](https://doi.org/10.1007/978-3-642-14064-8_30). Read: abstract, which states no frequency. The
# model gives spring and damper one threshold, $\arcsin(c)/\omega$, and a damped inertia at most $\sqrt 2$ times as much for small $c$, whatever
# $\omega$; the ratios of the measured delays are compared, at 1 Hz.

# %%
from book import Table, apart, number

import haptisym as hs

TURN = 6.283185307179586


def noticed(environment):
    """The smallest delay that is noticed at 1 Hz, c = 10 %."""
    scene = hs.Scene(environment, (hs.effects.delay("10 ms"),), (TURN - 1e-6, TURN), hs.Threshold.of(0.1))
    return hs.require(scene, "effects.delay.tau", ("0 ms", "100 ms")).feasible[0].high


damper = noticed(hs.environments.mass_spring_damper(b=1))
spring = noticed(hs.environments.mass_spring_damper(k=1))
inertia = noticed(hs.environments.mass_spring_damper(m="0.1834 kg", b=1))
rows = Table(
    [
        apart("damper", "abstract", "15 ms", f"{1e3 * float(damper):.4g} ms", "the frequency is not stated"),
        number("spring, times the damper's", "abstract", "2.4", float(spring) / float(damper)),
        number("damped inertia, times the damper's", "abstract", "4.8", float(inertia) / float(damper)),
    ]
)
rows
