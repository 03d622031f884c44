# %% [markdown]
# # Figures
#
# Every kind of figure once, with the code that draws it. `plot` of an answer draws on axes of yours, or on new ones, and
# returns them: titles, limits and sizes are matplotlib's business. A further scene on the same axes has the next
# colour; the colours are told apart by colour-blind readers and in print. `color` and `label` are of the scene, all other
# keywords of its curves.

# %%
import numpy as np

import haptisym as hs

paper = hs.load_scene("fu2019")
slow = paper.with_values({"omega_n": 50})

# %% [markdown]
# ## Two scenes on the same axes

# %%
ax = hs.evaluate(paper).plot(label="80 rad/s")
ax = hs.evaluate(slow).plot(ax, label="50 rad/s", linewidth=2)

# %% [markdown]
# ## Evaluation
#
# H_env and H_perc in the plane, their parts along the band, other JND regions, and the bandwidth over a range of thresholds.

# %%
ax = hs.evaluate(paper).plot(kind="nyquist")

# %%
ax = hs.evaluate(paper).plot(kind="projections-real")

# %%
ax = hs.evaluate(paper).plot(kind="projections-imag")

# %%
ax = hs.evaluate(paper, regions=True).plot(kind="regions")

# %%
ranged = paper.with_values({"jnd": "0.1 +- 20 %"})
ax = hs.evaluate(ranged).plot(kind="bandwidths")

# %% [markdown]
# ## Local maxima of the ratios

# %%
ax = hs.peaks(paper).plot()

# %% [markdown]
# ## Several environments

# %%
tissues = hs.load_scenes("palpation-device")
ax = hs.evaluate_all(tissues).plot(kind="real")

# %%
ax = hs.evaluate_all(tissues).plot(kind="imag")

# %% [markdown]
# ## Measured lines

# %%
exact = hs.sampled(paper, np.linspace(1, 15, 20))
lines = hs.measured(exact.omega, exact.H * 1.02, radius=[4.0] * 20)
bench = hs.evaluate(hs.MeasuredScene(paper.environment, lines))
ax = bench.plot()

# %%
ax = bench.plot(kind="nyquist")

# %% [markdown]
# ## A model that was fitted

# %%
fitted = hs.identify(lines, "mass-spring-damper", ["second-order-lowpass"])
ax = fitted.plot()

# %%
ax = fitted.plot(kind="phase")

# %%
ax = fitted.plot(kind="residuals")

# %% [markdown]
# ## Which effects matter

# %%
stick = hs.relevance("control-stick-in-detail")
ax = stick.plot(kind="real")

# %%
ax = stick.plot(kind="dominance")

# %% [markdown]
# ## Requirements

# %%
ax = hs.require(paper, "omega_n").plot()

# %%
pairs = ["zeta", "omega_n"], [("0.3", "0.8"), (50, 300)]
ax = hs.design_map(paper, *pairs, slices=9).plot()

# %%
ax = hs.design_map(paper, *pairs, slices=9, that=("transparent", "passive")).plot()

# %% [markdown]
# ## Stability in a hand

# %%
ax = hs.stability("delayed-spring", ["postural-arm"]).plot()

# %% [markdown]
# ## Sensitivities and tolerances

# %%
ax = hs.sensitivity(paper).plot()

# %%
ax = hs.tolerances("fu2019-tolerances", samples=20).plot()

# %% [markdown]
# ## Other measures

# %%
ax = hs.metrics(paper).plot()

# %%
ax = hs.metrics(paper).plot(kind="verdicts")

# %% [markdown]
# ## What accuracy costs

# %%
ax = hs.cost(paper, quick=True).plot()

# %% [markdown]
# ## Simulations

# %%
run = hs.check(paper, count=5)
ax = run.plot()

# %%
ax = run.plot(kind="loop")

# %%
ax = run.plot(kind="recovered-real")

# %%
ax = hs.release("delayed-spring", "1 cm", "postural-arm").plot()

# %% [markdown]
# ## Thresholds

# %%
ax = hs.published().plot()

# %%
from pathlib import Path
from tempfile import mkdtemp

answers = Path(mkdtemp()) / "answers.csv"
answers.write_text("level,k,n\n8,1,20\n9,4,20\n10,10,20\n11,17,20\n12,19,20\n")
ax = hs.jnd(answers, reference=10).plot()
