# %% [markdown]
# # haptisym in a quarter of an hour
#
# You write down what a hand should feel and what stands in between. haptisym derives in closed form what is felt
# instead, proves from which frequency a person begins to notice, and says as what. This page can be run cell by cell
# in an editor that knows `# %%`, or as a notebook: `python docs/make_notebook.py` writes `docs/tutorial.ipynb`.

# %%
import haptisym as hs

# %% [markdown]
# ## The paper's example
#
# A mass of 1.8 kg on a spring and a damper is displayed through a second-order filter of 80 rad/s (Fu, van Paassen
# and Mulder 2019, section 3). It is one of the scenes that the package ships.

# %%
paper = hs.load_scene("fu2019")
paper

# %% [markdown]
# An evaluation answers both questions of the paper: *when* is the distortion noticed, and *how* is it felt?

# %%
result = hs.evaluate(paper)
result

# %% [markdown]
# The paper reads 8 and 12 rad/s off a plot. Here the crossings are proven: none is missed, none invented, and there
# are as many digits as you ask for.

# %%
first, second = result.crossings
assert first.omega.digits(30) == "7.97891679017470770281589544718"
first

# %%
[(p.property.value, p.change.value, p.band) for p in result.percepts]

# %% [markdown]
# As a figure, on axes of matplotlib that are yours from then on. A second scene goes onto the same ones.

# %%
ax = result.plot(label="80 rad/s")
ax = hs.evaluate(paper.with_values({"omega_n": 50})).plot(ax, label="50 rad/s")

# %% [markdown]
# The ratio of the imaginary part has a local maximum below its threshold. `peaks` finds it, exactly as well: a
# threshold of just that size would be touched, and not exceeded.

# %%
peak = hs.peaks(paper)[0]
peak

# %% [markdown]
# ## A delay
#
# What if the force is 4 ms late as well? A delay is exact in haptisym, and no Pade approximation.

# %%
late = hs.Scene(
    paper.environment,
    (*paper.effects, hs.effects.delay("4 ms")),
    paper.band,
    title="The paper's example, 4 ms late",
)
delayed = hs.evaluate(late)
assert delayed.bandwidth is not None
assert float(delayed.bandwidth) < float(result.bandwidth)
delayed

# %% [markdown]
# How much delay may it be, if the display is to stay transparent up to 5 rad/s? The bandwidth of a few delays says
# where to look.

# %%
bandwidths = {}
for milliseconds in (1, 2, 5, 10, 20):
    scene = hs.Scene(paper.environment, (*paper.effects, hs.effects.delay(f"{milliseconds} ms")), paper.band)
    bandwidth = hs.evaluate(scene).bandwidth
    bandwidths[milliseconds] = float(bandwidth) if bandwidth is not None else 0.0
assert bandwidths[1] > bandwidths[20]
bandwidths

# %% [markdown]
# ## Your own scene
#
# Scenes are data: TOML, with units. Effects stand in their order from the environment to the hand, and none that you
# do not name is used.

# %%
own = hs.parse_scene(
    """
    title = "Soft tissue felt through a light device"

    [environment]
    model = "kelvin-voigt"
    k = "300 N/m"
    b = "2 N*s/m"

    [[effects]]
    name = "device"
    model = "shunt"
    m = "60 g"

    [[effects]]
    name = "sampling"
    model = "zero-order-hold"
    T = "1 ms"

    [evaluation]
    band = ["0 Hz", "20 Hz"]
    jnd = { real = 0.10, imag = 0.15 }
    """
)
own

# %%
felt = hs.evaluate(own)
assert felt.certified
felt

# %% [markdown]
# A mistake in a scene is an error that names the place, the value and the rule.

# %%
try:
    hs.environments.kelvin_voigt("300 N", "2 N*s/m")
except hs.SceneError as error:
    message = str(error)
assert "expected N/m" in message
message

# %% [markdown]
# ## Formulas
#
# With symbols instead of numbers the same functions give closed forms. `real` and `imag` are the parts of the
# distortion, `ratio_real` and `ratio_imag` are what the threshold judges.

# %%
m, b, k, omega_n, zeta = hs.symbols("m b k omega_n zeta")
d = hs.distort(hs.environments.mass_spring_damper(m, b, k), hs.effects.second_order_lowpass(omega_n, zeta))
d

# %% [markdown]
# They are SymPy expressions: substitute, differentiate, take limits.

# %%
assert str(d.changeover_environment) == "sqrt(k)/sqrt(m)"
d.changeover_environment

# %%
d.relative_real.diff(hs.omega).subs({omega_n: 80, zeta: 0.5, hs.omega: 10})

# %% [markdown]
# For numbers there is a NumPy function; its arguments broadcast.

# %%
f = d.compile()
values = f([5.0, 10.0, 15.0], m=1.8, b=15.0, k=100.0, omega_n=80.0, zeta=0.5)
assert (values.ratio_real > 0.1).tolist() == [False, True, True]
values.ratio_real

# %% [markdown]
# ## LaTeX, MathML and code
#
# `latex` writes formulas and tables for a paper, `mathml` for a page.

# %%
text = hs.latex(d.perceived)
assert text.startswith(r"\frac")
print(text)

# %%
print(hs.mathml(d.environment))

# %% [markdown]
# The closed forms as a function in C, JavaScript, Octave and MATLAB, or NumPy, which needs nothing of
# haptisym:

# %%
from haptisym.writing.code.entry import scene_code
from haptisym.writing.code.languages import Language

code = scene_code(paper, Language.C, parameters=["omega_n"])
assert "void distortion(double omega, double omega_n, distortion_values *values)" in code
print(code)

# %% [markdown]
# ## A report
#
# `haptisym evaluate SCENE --report FILE.html` writes all of this on one page: tables, figures, the derivation step by
# step, and an explorer with a slider for each parameter. `--report FILE.pdf` sets the derivation as a document.

# %%
from pathlib import Path
from tempfile import mkdtemp

from haptisym.pages.report import save_report

report = Path(mkdtemp()) / "tutorial.html"
save_report(felt, report)
assert report.stat().st_size > 100_000
report.name
