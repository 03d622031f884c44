# %% [markdown]
# # Jones and Hunter (1993); Jones, Hunter and Lafontaine (1997): viscosity
#
# 34 % by matching (84 %), 19 % by forced choice (71 %), Perception 26, 1571-1578,
# [doi:10.1068/p261571](https://doi.org/10.1068/p261571). Read: abstracts. For a cumulative Gaussian the two are one threshold.

# %%
from dataclasses import replace

from book import Table, number

import haptisym as hs

scene = replace(hs.load_scene("fu2019"), threshold=hs.Threshold.like("viscosity-forced-choice"))
at_84 = hs.evaluate(scene, proportion="0.84").scene.threshold.real
rows = Table([number("19 % at 71 %, at 84 %", "abstracts", "0.34", float(at_84))])
rows
