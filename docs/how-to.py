# %% [markdown]
# # How to: I have ..., I want ...
#
# From a designer's question to the verb that answers it, with one device all the way: a trainer on which a hand learns
# to feel a lump in soft tissue. Each question has its line on the command line and its call in Python; both give the same
# answer. Run this page cell by cell, or as a notebook: `python docs/make_notebook.py docs/how-to.py how-to.ipynb`.
#
# | I have | I want to know | ask |
# |---|---|---|
# | a device on paper | when it is noticed, and as what | [`evaluate`](#when-is-it-noticed-and-as-what) |
# | the same | the formulas | [`derive`](#what-is-the-formula) |
# | many effects | which of them matter | [`effects`](#which-effects-matter) |
# | a value to choose | which values will do | [`require`](#how-light-must-the-handle-be) |
# | two values to choose | which pairs will do | [`require`, twice `--free`](#how-light-and-how-fast) |
# | a hand | whether it shakes | [`stability`](#does-it-shake-in-a-hand) |
# | one thing to improve | which one pays | [`sensitivity`](#what-should-be-improved) |
# | parts with tolerances | what holds for all of them | [`tolerances`](#parts-are-only-known-as-ranges) |
# | a design space | how it looks | [`sweep`](#what-does-the-whole-design-space-look-like) |
# | a paper with another measure | what that says | [`metrics`](#what-do-other-measures-say) |
# | a device on the bench | what was measured, judged | [`evaluate`, with `[perceived]`](#what-does-the-device-on-the-bench-do) |
# | lines of a measurement | a model of them | [`identify`](#which-model-fits-what-was-measured) |
# | answers of people | their threshold | [`jnd`](#what-is-the-threshold-of-these-people) |
# | a doubt | a proof, or a witness | [`evaluate --certificate`, `simulate`](#must-i-believe-it) |
# | numbers in floats | what they are worth | [`cost`](#what-does-accuracy-cost) |
# | a program of my own | a function, or code | [`compile`, `derive --to`](#a-function-for-my-own-program) |

# %% [markdown]
# ## The device
#
# A scene is a file. This one is `trainer.toml`: what should be felt, what stands in between, what is asked, whose hand.
# All models are in the [scene reference](scenes.md).

# %%
import haptisym as hs

trainer = hs.parse_scene(
    """
    title = "Palpation trainer"
    source = "illustrative"

    [environment]                      # a lump in soft tissue
    model = "kelvin-voigt"
    k = "400 N/m +- 10 %"
    b = "6 N*s/m"

    [[effects]]                        # nearest the environment first
    name = "amplifier"
    model = "first-order-lag"
    omega_c = "40 Hz"

    [[effects]]
    name = "handle"
    model = "shunt"
    m = "60 g"
    b = "0.4 N*s/m"

    [evaluation]
    band = ["0 Hz", "8 Hz"]
    jnd = 0.15

    [hand]
    m = "0.2 kg"
    b = "4 N*s/m"
    k = "200 N/m"
    """
)
trainer

# %% [markdown]
# ## When is it noticed, and as what?
#
# `haptisym evaluate trainer.toml`. All crossings of the band, proven; then what is felt beyond them.

# %%
felt = hs.evaluate(trainer)
assert felt.bandwidth.digits(6) == "40.4447"
felt

# %%
ax = felt.plot()

# %% [markdown]
# ## What is the formula?
#
# `haptisym derive trainer.toml`, and `--to latex`, `mathml`, `c`, ... One formula of it in Python:

# %%
trainer.symbolic_distortion().perceived

# %% [markdown]
# ## Which effects matter?
#
# `haptisym effects trainer.toml --tolerance "5 %"`: the fewest effects whose evaluation differs by less than that,
# jointly, on the whole band.

# %%
kept = hs.relevance(trainer, "5 %")
assert len(kept.pruned.effects) == 2
kept

# %% [markdown]
# ## How light must the handle be?
#
# `haptisym require trainer.toml --free handle.m`. All masses for which nothing is noticed on the whole band, and
# what binds at the ends.

# %%
light = hs.require(trainer, "handle.m")
assert light.feasible[0].high.value.digits(5) == "0.046607"
light

# %% [markdown]
# The same with the wish that no passive hand can make it shake: `--that transparent --that passive`. A mass below zero
# (compensation by control) is then out.

# %%
hs.require(trainer, "handle.m", that=("transparent", "passive"))

# %% [markdown]
# ## How light, and how fast?
#
# `haptisym require trainer.toml --free handle.m --free omega_c --range "0 g" "80 g" --range "10 Hz" "80 Hz" --figure map.svg`.
# Exact slices; between them nothing is claimed.

# %%
both = hs.design_map(trainer, ["handle.m", "omega_c"], [("0 g", "80 g"), ("10 Hz", "80 Hz")], slices=9)
ax = both.plot()

# %% [markdown]
# ## Does it shake in a hand?
#
# `haptisym stability trainer.toml`, or `--hand NAME` for a published one. Three statements that are never mixed:
# under imposed motion, in this hand, in every passive hand.

# %%
firm = hs.stability(trainer)
assert firm.every_passive_hand.holds
firm

# %% [markdown]
# ## What should be improved?
#
# `haptisym sensitivity trainer.toml`. Per cent of bandwidth per per cent of each parameter, exact.

# %%
slopes = hs.sensitivity(trainer)
assert slopes.crossings[0].ranked[0].name == "m"
slopes

# %% [markdown]
# ## Parts are only known as ranges
#
# `haptisym tolerances trainer.toml`. The tissue is known to 10 %; what is said holds for every value of it.

# %%
ranges = hs.tolerances(trainer, samples=20)
assert ranges.verdict.value == "none"
ranges

# %% [markdown]
# ## What does the whole design space look like?
#
# `haptisym sweep trainer.toml --vary "handle.m=0 g:80 g:9" --vary "omega_c=10 Hz:80 Hz:8"`. Every count is proven, also
# where it is computed in floats. (Extra `sweep`.)

# %%
import numpy as np

space = hs.sweep(trainer, {"handle.m": np.linspace(0, 0.08, 9), "omega_c": 2 * np.pi * np.linspace(10, 80, 8)})
assert dict(space.sizes) == {"effects.handle.m": 9, "effects.amplifier.omega_c": 8}
space

# %% [markdown]
# ## What do other measures say?
#
# `haptisym metrics trainer.toml`: the measures of the field beside the verdict, each with its source, and where they
# disagree.

# %%
others = hs.metrics(trainer)
others.notes

# %% [markdown]
# ## What does the device on the bench do?
#
# A scene whose `[perceived]` is a file is judged at its lines, with their discs of uncertainty: [measured.md](measured.md).
# Here a "measurement" is made up from the scene itself, a little off, with a disc of 8 N/m.

# %%
made_up = hs.sampled(trainer, np.linspace(5, 50, 10))
bench = hs.MeasuredScene(
    trainer.environment,
    hs.measured(made_up.omega, made_up.H * 1.01, radius=[8.0] * 10),
    trainer.band,
    hs.Threshold.of("0.15"),
)
judged = hs.evaluate(bench)
assert not judged.certified
judged

# %%
ax = judged.plot()

# %% [markdown]
# ## Which model fits what was measured?
#
# `haptisym identify device.csv --environment kelvin-voigt --effect shunt --scene found.toml`: least squares weighted by the
# discs, what each line tells of each parameter, whether the model holds at all, and a scene for all other verbs. It is
# estimated, never certified: [identify.md](identify.md).

# %%
fitted = hs.identify(bench.perceived, "kelvin-voigt", ["shunt:m"])
assert not fitted.certified
[(x.parameter.name, f"{x.value:.3g}", f"{x.error:.1g}") for x in fitted.estimates]

# %% [markdown]
# ## What is the threshold of these people?
#
# `haptisym jnd answers.csv --reference 400`: from answers at several levels to the line of the scene file. (Extra
# `psychophysics`.)

# %%
from pathlib import Path
from tempfile import mkdtemp

answers = Path(mkdtemp()) / "answers.csv"
answers.write_text("level,k,n\n320,2,40\n360,9,40\n400,21,40\n440,32,40\n480,38,40\n")
person = hs.jnd(answers, reference=400)
person.line

# %% [markdown]
# ## Must I believe it?
#
# Not on its word. `haptisym evaluate trainer.toml --certificate proof.json` writes a proof, and
# `python -m haptisym_check proof.json trainer.toml` checks it with the standard library alone. And
# `haptisym simulate trainer.toml --check` asks the equations of motion, without the closed forms. (Extra `simulate`.)

# %%
import json

claim = json.loads(felt.certificate())["claim"]
claim["crossings"]

# %%
run = hs.check(trainer, amplitude="1 cm", count=3)
assert run.agrees
run

# %% [markdown]
# ## What does accuracy cost?
#
# `haptisym cost trainer.toml --figure cost.svg`: right digits against time, live.

# %%
hs.cost(trainer, quick=True).summary

# %% [markdown]
# ## A function for my own program
#
# `haptisym derive trainer.toml --to numpy` (or `c`, `octave`, `javascript`) writes code that needs nothing of
# haptisym; `compile` gives a function of NumPy.

# %%
ratios = trainer.distortion().compile()([10.0, 40.0, 45.0])
assert (ratios.ratio_real > 0.15).tolist() == [False, False, True]
ratios.ratio_real
