# %% [markdown]
# # Figures
#
# After this page you can draw every kind of figure: each is shown once, with its code. `plot` of a result draws on axes of
# yours, or on new ones, and returns them. Titles, limits and sizes are set with matplotlib. Another scene on the same axes
# has the next colour; colour-blind readers can distinguish the colours, also in print. `color` and `label` belong to the scene,
# other keywords to its curves. `plot` calls the `draw_` functions of `haptisym.figures`.

# %%
import numpy as np
from matplotlib import pyplot

import haptisym as hs
from haptisym.figures import evaluation as evaluation_charts
from haptisym.figures import measured as measured_charts
from haptisym.figures import sweep as sweep_charts
from haptisym.figures.layers import draw
from haptisym.verbs.sweep.entry import Swept

paper = hs.load_scene("fu2019")
slow = paper.with_values({"omega_n": 50})

# %% [markdown]
# ## Two scenes on the same axes

# %%
ax = hs.evaluate(paper).plot(label="80 rad/s")
ax = hs.evaluate(slow).plot(ax, label="50 rad/s", linewidth=2)

# %% [markdown]
# ## Formulas
#
# A derivation draws its ratios for the values of the scene.

# %%
ax = hs.derive(paper).plot()

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
ax = hs.evaluate(paper, discriminate=True).plot(kind="discriminate")

# %%
ranged = paper.with_values({"jnd": "0.1 +- 20 %"})
ax = hs.evaluate(ranged).plot(kind="bandwidths")

# %% [markdown]
# ## The JND at one frequency
#
# The JND square of the paper around the tip of H_env, and another region. The frequency is in rad/s.

# %%
ax = pyplot.figure(layout="constrained").add_subplot()
square = draw(ax, evaluation_charts.square(hs.evaluate(paper), 10))

# %%
tilted = {"shape": "ellipse", "real": "0.1", "imag": "0.2", "tilt": "30 deg"}
felt = hs.Scene(paper.environment, paper.effects, paper.band, tilted)
ax = pyplot.figure(layout="constrained").add_subplot()
region = draw(ax, evaluation_charts.square(hs.evaluate(felt), 10))

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

# %%
ax = hs.evaluate_all(tissues, regions=True).plot(kind="regions")

# %% [markdown]
# ## Measured frequency points

# %%
exact = hs.sampled(paper, np.linspace(1, 15, 20))
lines = hs.measured(exact.omega, exact.H * 1.02, radius=[4.0] * 20)
bench = hs.evaluate(hs.MeasuredScene(paper.environment, lines))
ax = bench.plot()

# %%
ax = bench.plot(kind="nyquist")

# %% [markdown]
# With a bound on the slope, the possible values between the points are a band.

# %%
bounded = hs.measured(exact.omega, exact.H * 1.02, radius=[4.0] * 20, slope="65 N*s/m")
ax = hs.evaluate(hs.MeasuredScene(paper.environment, bounded)).plot()

# %%
joint = hs.evaluate(hs.MeasuredScene(felt.environment, lines, None, felt.threshold))
ax = pyplot.figure(layout="constrained").add_subplot()
dots = draw(ax, measured_charts.measured_plane(joint))

# %% [markdown]
# ## A fitted model

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

# %%
late = ["k", "tau"], [(20, 1000), ("0.001", "0.05")]
ax = hs.design_map("delayed-spring", *late, slices=9, that=("transparent", "stable"), hand="postural-arm").plot()

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

# %%
late = hs.load_scene("delayed-spring").with_values({"k": "100 N/m +- 20 %", "tau": "36 ms +- 10 %"})
ax = hs.tolerances(late, samples=0, hand="postural-arm").plot(kind="hands")

# %% [markdown]
# ## Sweeps
#
# `hs.sweep` returns an xarray Dataset. The bandwidth over one parameter, and over two with the boundary of an exact map;
# hatched where the display is unstable in a hand.

# %%
swept = hs.sweep(paper, {"effects.filter.zeta": np.linspace(0.2, 1, 81)})
ax = Swept(paper, swept).plot()

# %%
grid = {"effects.filter.omega_n": np.linspace(50, 300, 41), "effects.filter.zeta": np.linspace(0.3, 0.8, 41)}
ax = pyplot.figure(layout="constrained").add_subplot()
chart = draw(ax, sweep_charts.plane(hs.sweep(paper, grid), hs.design_map(paper, *pairs, slices=9)))

# %%
stiff = hs.load_scene("delayed-spring").with_values({"k": "500 N/m"})
ax = pyplot.figure(layout="constrained").add_subplot()
curves = draw(
    ax, sweep_charts.curves(hs.sweep(stiff, {"effects.delay.tau": np.linspace(0, 0.04, 41)}, hand="postural-arm"))
)

# %%
springs = {"environment.k": np.linspace(50, 1000, 11), "effects.delay.tau": np.linspace(0, 0.06, 11)}
ax = pyplot.figure(layout="constrained").add_subplot()
chart = draw(ax, sweep_charts.plane(hs.sweep("delayed-spring", springs, hand="postural-arm")))

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

# %%
from haptisym.verbs.cost.hardcosts import hard_cases

ax = pyplot.figure(figsize=(9, 1.6), layout="constrained").add_subplot()
ax = hs.hard_costs(hard_cases("identities")).plot(ax)

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
ax = run.plot(kind="recovered-imag")

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
