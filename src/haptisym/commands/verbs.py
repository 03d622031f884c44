"""The verbs: of each its help, its options and its question. A new verb is a function here
(``cli.VERBS`` reads its first line).

What only some calls need (figures, SciPy, dask, the writers) is imported where it is called for, so
that ``--json`` in a loop pays for none of it.
"""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from haptisym.commands.options import (
    CERTIFICATE,
    ENVIRONMENT,
    EVERYTHING,
    FIGURES,
    FORMULAS,
    JSON,
    LIMIT,
    NO_FILES,
    SCENE,
    TABLE,
    Ask,
    PathType,
    choice,
    draw,
    end,
    figure,
    given,
    hand_over,
    keep,
    keep_pages,
    keep_text,
    not_over,
    number,
    option,
    optional,
    output,
    verb,
)
from haptisym.commands.terminal import progress, say, say_document, write
from haptisym.judge.answers import Answer
from haptisym.kernel.errors import SceneError
from haptisym.model.measuredscene import MeasuredScene
from haptisym.model.scenefile import chosen, felt_through, load_scene, open_scenes


@verb(
    click.Argument(["scene"]),
    click.Argument(["more"], nargs=-1, metavar=""),
    JSON,
    ENVIRONMENT,
    NO_FILES,
    option(
        "--environments FILE...", "Use the environments of these scenes instead.", multiple=True
    ),
    option("--tolerance X", "Leave out effects that together change the ratios by at most X."),
    option("--regions", "Compare with square, disc and diamond of the same half widths."),
    option(
        "--discriminate",
        "With --regions: the changes that would decide between square, disc and tilted ellipse.",
    ),
    option("--proportion P", "Convert the JND to this proportion of correct answers, as 0.84."),
    option(
        "--movement MOVEMENT",
        (
            'What a fit of stiffness, damping and mass reports: "0:15" or "velocity:1:15" '
            "(rad/s), or a file."
        ),
    ),
    FIGURES,
    output(
        "--response FILE",
        "Write the exact response, sampled on the band, as a CSV file that [perceived] reads.",
    ),
    number("--points N", "Number of frequency points of --response.", 2, 1_000_000, 200),
    CERTIFICATE,
    LIMIT,
    TABLE,
    FORMULAS,
    needs=[
        ("--points", "--response", "the lines of a file"),
        ("--discriminate", "--regions", "a comparison of regions"),
    ],
)
def evaluate(ask: Ask) -> Answer:
    """Find when a hand notices a display, and as what.

    SCENE is a scene file (TOML) or the name of a shipped scene.

    Step 1: every frequency of the band at which r_r = |Re dH|/|H_env| or r_i = |Im dH|/|H_env|
    crosses the JND. Step 2:
    the mechanical property that changes there (stiffness, damping, mass). All crossings are proven.

    A scene with several environments ([[environments]], or --environments after SCENE) gives a row
    for each, and the band on which the display is transparent with all of them.

    \b
    Examples:
      haptisym evaluate fu2019
      haptisym evaluate palpation-device
      haptisym evaluate palpation-device --environment liver
      haptisym evaluate fu2019 --environments fu2019 helicopter-cyclic my-stick.toml
      haptisym evaluate fu2019 --figures figures --latex fu2019.tex
      haptisym evaluate fu2019 --report fu2019.html
      haptisym evaluate fu2019 --regions
      haptisym evaluate fu2019 --regions --discriminate
      haptisym evaluate palpation-device --regions
      haptisym evaluate my-device.toml --proportion 0.84
      haptisym evaluate fu2019 --movement 0:15
      haptisym evaluate my-device.toml --certificate my-device.proof.json
      haptisym evaluate fu2019 --response fu2019.csv --points 60
      haptisym evaluate my-device.toml --json --digits 50
      haptisym evaluate control-stick-in-detail --tolerance 0.01
      haptisym evaluate fu2019-bench            a simulated bench run
      haptisym evaluate bench.toml              a scene with [perceived] from a file
    """
    if ask.more and not ask.environments:
        raise click.UsageError(f"got an unexpected argument ({ask.more[0]})")
    opened, _ = open_scenes(ask.scene, files=not ask.no_files)
    if isinstance(opened, MeasuredScene):
        return _measured(opened, ask)
    family = felt_through(opened, ask.scene, (*ask.environments, *ask.more))
    # No limit of its own: the one of the command line is around the whole question.
    same: dict[str, Any] = {"regions": ask.regions, "proportion": ask.proportion, "limit": None}
    if ask.environment is None and (ask.environments or len(family) > 1):
        for one in ("--tolerance", "--certificate", "--response", "--movement", "--discriminate"):
            if given(one):
                raise SceneError(f"{one} takes one environment: choose it with --environment NAME")
        from haptisym.verbs.family.entry import evaluate_all

        return evaluate_all(family, ask.digits or 15, **same)
    from haptisym.verbs.evaluate.entry import evaluate as of

    scene = (
        family[str(ask.environment)]
        if ask.environments
        else chosen(family, Path(ask.scene).name, ask.environment)
    )
    alone = {"tolerance": ask.tolerance, "movement": ask.movement, "discriminate": ask.discriminate}
    result = of(scene, ask.digits or 15, **alone, **same)
    if ask.response is not None:
        from haptisym.model.measuring import write_sampled

        keep(
            "response", ask.response, lambda: write_sampled(result.given, ask.response, ask.points)
        )
    return result


# Options that a measured scene would ignore: its answer is the same whatever they are.
_ABOUT_FORMULAS = (
    "--environments",
    "--environment",
    "--digits",
    "--tolerance",
    "--certificate",
    "--regions",
    "--proportion",
    "--response",
    "--points",
    "--limit",
    "--movement",
    "--discriminate",
)


def _measured(scene: MeasuredScene, ask: Ask) -> Answer:
    """The answer for a measured scene; SceneError for what only formulas have."""
    for one in _ABOUT_FORMULAS:
        if given(one):
            raise SceneError(
                f"{one} is about scenes of formulas, and this one is measured: leave it out"
            )
    not_over(scene.files, {"latex": ask.latex, "report": ask.report})
    from haptisym.verbs.measured.entry import judge

    return judge(scene)


@verb(
    click.Argument(["scenes"], nargs=-1, required=True, metavar="SCENE..."),
    option(
        "--with PATH=VALUE",
        "Compare one scene with itself at this value; repeatable.",
        name="values",
        multiple=True,
    ),
    option("--hand NAME", "Hand of all scenes, or a shipped one; repeatable.", multiple=True),
    ENVIRONMENT,
    NO_FILES,
    JSON,
    figure("the ratios of all scenes"),
    LIMIT,
    TABLE,
)
def compare(ask: Ask) -> Answer:
    """Compare two to six displays: which is transparent furthest.

    SCENE is a scene file (TOML) or the name of a shipped scene; measured ones too.

    Prints the bandwidths in order, proven, equal ones together; as what each display is noticed
    first, and by how much later than the first one; in which parameters, models and bands they
    differ; and whether each is stable in the hands that all of them have, or in those of --hand.

    Exit status 3 where the order of two bandwidths is undecided, as it may be of measured displays.

    \b
    Examples:
      haptisym compare fu2019 helicopter-cyclic --figure both.pdf
      haptisym compare fu2019 --with filter.zeta=0.4
      haptisym compare fu2019 fu2019-bench
      haptisym compare fu2019 my-device.toml --hand postural-arm --json
    """
    from haptisym.verbs.compare.entry import compare as of

    values = dict(map(_value_of, ask.values))
    return of(
        *ask.scenes,
        values=values or None,
        hand=ask.hand or None,
        environment=ask.environment,
        files=not ask.no_files,
        digits=ask.digits or 15,
        limit=None,
    )


def _value_of(text: str) -> tuple[str, str]:
    """A path, and its value."""
    path, _, value = (x.strip() for x in text.partition("="))
    if not path or not value:
        raise SceneError(f'--with {text[:60]}: write PATH=VALUE, as filter.zeta=0.07 or "tau=4 ms"')
    return path, value


# Languages of ``derive --to``; "python" is another word for "numpy".
_CODE = ("numpy", "python", "c", "octave", "javascript")
_OUTPUTS = ("text", "latex", "mathml", "json", "sympy", *_CODE)
_MEANT = {"matlab": "MATLAB runs --to octave", "julia": "for Julia: --to c, which ccall runs"}


class _Language(click.Choice[str]):
    """A language of ``derive --to``; for those that have none of their own it names the one to
    take."""

    def convert(self, value: str, param: click.Parameter | None, ctx: click.Context | None) -> str:
        if value in _MEANT:
            self.fail(_MEANT[value], param, ctx)
        return super().convert(value, param, ctx)


@verb(
    SCENE,
    option(
        "--symbolic", "Keep every parameter a symbol (default).", name="mode", flag_value="symbolic"
    ),
    option(
        "--numeric",
        "Insert the number of the scene for every parameter.",
        name="mode",
        flag_value="numeric",
    ),
    option(
        "--keep NAME",
        "Keep only this parameter a symbol, by path or name; repeatable.",
        multiple=True,
    ),
    option(
        "--to",
        "Language of the output.",
        type=_Language(_OUTPUTS),
        default="text",
        show_default=True,
    ),
    option("--of QUANTITY", "Print only this quantity; repeatable.", multiple=True),
    option("--dimensionless", "Print the dimensionless form, too."),
    JSON,
    LIMIT,
)
def derive(ask: Ask) -> None:
    """Derive the formulas of a scene, as text, LaTeX or code.

    SCENE is a scene file (TOML) or the name of a shipped scene.

    Quantities for --of: H_env, H_perc, dH, Re dH, Im dH, |H_env|^2, r_r, r_i, Re(dH/H_env),
    Im(dH/H_env), the threshold polynomials p_r and p_i, the perceived properties k_env, m_env,
    b_env, k_perc, m_perc, b_perc, the force phasors F_si_env, F_d_env, F_si_perc, F_d_perc, jnd k,
    jnd b, jnd m, the crossings omega_r and omega_i, the changeovers omega_env and omega_perc, and
    the sensitivities d omega_r/d NAME and d omega_i/d NAME of a crossing to a parameter.

    \b
    Examples:
      haptisym derive fu2019
      haptisym derive fu2019 --keep omega_n --of "Re dH" --to latex
      haptisym derive fu2019 --to c > distortion.c
    """
    from haptisym.verbs.derive.derivation import derive as of

    language = "json" if ask.json else ask.to
    if ask.keep and ask.mode:
        raise SceneError(
            f"--keep gives the parameters that stay symbols, and so does --{ask.mode}: leave "
            f"out one of them"
        )
    if ask.json and ask.to != "json" and given("--to"):
        what = f"--json is one document of all formulas, and --to {ask.to} another output"
        raise SceneError(f"{what}: leave out one of them")
    if ask.of and ask.to in (*_CODE, "sympy"):
        what = f"--of chooses among formulas, and --to {ask.to} writes all quantities"
        raise SceneError(f"{what}: leave out one of them")
    # Parameters that stay symbols: those of --keep, none with --numeric, else all (None).
    kept = ask.keep or (() if ask.mode == "numeric" else None)
    derivation = replace(of(ask.scene, kept), of=ask.of, shows_groups=ask.dimensionless)
    page = keep_pages(derivation, ask)
    # Not by ``hand_over``: another language stands in place of the page.
    if language == "json":
        say_document(derivation.to_json())
    elif language == "text":
        say(page(), ask.digits)
    else:
        write(_in(language, derivation, kept))


def _in(language: str, derivation: Any, kept: tuple[str, ...] | None) -> str:
    """A derivation in another language; ``kept`` : the parameters that stay arguments of code."""
    if language in _CODE:
        from haptisym.writing.code import Language, scene_code

        return scene_code(
            derivation.scene,
            Language["NUMPY" if language == "python" else language.upper()],
            parameters=kept,
        )
    if language == "latex":
        return str(derivation.to_latex())
    if language == "sympy":
        from haptisym.pages.derive import script

        return script(derivation)
    from haptisym.writing.html import fragment

    return fragment(derivation.document()) + "\n"


@verb(
    SCENE,
    JSON,
    option(
        "--tolerance X",
        "Allowed change of r_r and r_i by leaving out effects.",
        default="0.01",
        show_default=True,
    ),
    figure("the influences along the band"),
    LIMIT,
)
def effects(ask: Ask) -> Answer:
    """Find which effects of a scene matter.

    SCENE is a scene file (TOML) or the name of a shipped scene.

    Prints, proven, the largest change of r_r and r_i on the band without each effect, the smallest
    set of effects with which both ratios stay within the tolerance, and intervals that hold all
    crossings of the full scene.

    \b
    Examples:
      haptisym effects control-stick-in-detail
      haptisym effects sidestick --tolerance 0.1 --figure influences.pdf
      haptisym effects my-device.toml --json
    """
    from haptisym.verbs.effects.relevance import relevance

    answer = relevance(ask.scene, ask.tolerance, limit=None)
    # Computed when first asked for, which must be within the limit.
    _ = answer.effects, answer.crossings, answer.dominance
    return answer


@verb(
    SCENE,
    option(
        "--free PATH",
        "Free parameter, by path or name; twice for a map.",
        multiple=True,
        required=True,
    ),
    option(
        "--range LO HI",
        'Range searched, as "50 rad/s" "30 Hz"; 1e-6 to 1e6 times the value if not given.',
        multiple=True,
        nargs=2,
    ),
    choice("--part", "Require the condition of one part only.", "real", "imag"),
    choice(
        "--that",
        "What is required; repeatable, for all of them together.",
        "transparent",
        "stable",
        "steady",
        "passive",
        multiple=True,
        default=["transparent"],
        show_default=True,
    ),
    option("--hand NAME", "Hand of --that stable or steady, of the scene or shipped."),
    option("--jnd C", "Add the transparent set for this JND to a map; repeatable.", multiple=True),
    option("--friction F", "Coulomb friction of the device, for the bound 2 f_c/Delta in a map."),
    option("--resolution DELTA", "Step of the encoder, for the same bound."),
    option("--any-environment", "Require |G - 1| <= c, for every environment at once."),
    JSON,
    figure("the set, or the map"),
    CERTIFICATE,
    number("--slices N", "Largest number of exact slices of a map.", 3, 2000, 41),
    option("--uniform", "Space the slices of a map evenly."),
    option(
        "--within SHARE",
        "Estimated error of a map between slices, as a share (0.5 % if not given).",
    ),
    LIMIT,
    TABLE,
    needs=[
        ("--hand", "--that", "the hand of --that stable"),
        ("--friction", "--resolution", "Abbott and Okamura's bound 2 f_c/Delta"),
        ("--resolution", "--friction", "Abbott and Okamura's bound 2 f_c/Delta"),
    ],
    each=True,
)
def require(ask: Ask) -> Answer:
    """Find all values of a parameter that satisfy a requirement.

    SCENE is a scene file (TOML) or the name of a shipped scene.

    Required is that the display is transparent on its whole band, stable in a hand, steady in it (a drift is allowed), or
    passive. To require a bandwidth, end the band of the scene there. The result is a proven union of intervals, with what
    limits it at each end.

    \b
    Examples:
      haptisym require fu2019 --free effects.filter.omega_n
      haptisym require fu2019 --free zeta --range 0 1 --json --digits 50
      haptisym require fu2019 --free omega_n --certificate proof.json
      haptisym require delayed-spring --free tau --any-environment
      haptisym require delayed-spring --free environment.k --range 1 1000 --that stable --hand postural-arm
      haptisym require virtual-wall --free environment.b --free environment.k --range 0 40 --range 10 4000 \\
          --that transparent --that stable --hand postural-arm --jnd 0.05 --jnd 0.2 --figure z-width.svg
      haptisym require fu2019 --free omega_n --free zeta --range 60 200 --range 0.1 1 --figure map.svg
    """
    from haptisym.model.jnd import Part
    from haptisym.verbs.require.required import require as of

    _refuse_contradictions(len(ask.free), len(ask.range))
    same: dict[str, Any] = {
        "part": Part(ask.part) if ask.part else None,
        "that": ask.that,
        "hand": ask.hand,
        "limit": None,
        "any_environment": ask.any_environment,
    }
    if len(ask.free) == 2:
        from haptisym.verbs.require.designmap import design_map

        same |= {
            key: getattr(ask, key)
            for key in ("slices", "uniform", "within", "jnd", "friction", "resolution")
        }
        return design_map(ask.scene, ask.free, ask.range, **same)
    answer = of(ask.scene, ask.free[0], *ask.range, digits=ask.digits or 15, **same)
    # Computed when first asked for, which may take its time and must be within the limit.
    _ = answer.nearest
    return answer


def _refuse_contradictions(free: int, ranges: int) -> None:
    """SceneError for options that do not go with so many parameters and ranges."""
    if free > 2 or (ranges and ranges != free):
        raise SceneError(
            "--free may be given once or twice, and --range not at all or as often, in the "
            "same order"
        )
    if given("--certificate") and free == 2:
        raise SceneError(
            "--certificate is about one parameter's values: give --free once, or leave it out"
        )
    for one in ("--slices", "--jnd", "--friction", "--uniform", "--within"):
        if given(one) and free == 1:
            raise SceneError(
                f"{one} is about a map of two parameters: give --free twice, or leave it out"
            )
    if given("--uniform") and given("--within"):
        raise SceneError(
            "--uniform places slices evenly, and --within where they are needed: leave out "
            "one of them"
        )
    if free == 2 and not ranges:
        raise SceneError("a map of two parameters needs a --range for each")


@verb(
    SCENE,
    option("--hand NAME", "Hand of the scene, or a shipped one; repeatable.", multiple=True),
    option(
        "--free PATH", "Parameter whose stability limits are searched; repeatable.", multiple=True
    ),
    figure("the hand's plane: where the display is stable"),
    JSON,
    CERTIFICATE,
    LIMIT,
    TABLE,
    each=True,
)
def stability(ask: Ask) -> Answer:
    """Find whether a display shakes, and its stability limits.

    SCENE is a scene file (TOML) or the name of a shipped scene.

    Three statements, each proven by itself: stable in a hand (mass, damping and stiffness, of
    [hand] in the scene or a shipped one); stable under prescribed motion; passive, that is stable
    in the hand of any passive operator.

    Exit status 2 where a figure was asked for that cannot be drawn; the answer is printed all the
    same.

    \b
    Examples:
      haptisym stability delayed-spring --hand light-touch
      haptisym stability fu2019 --hand postural-arm --hand firm-grip
      haptisym stability delayed-spring --hand postural-arm --free environment.k --free tau
      haptisym stability delayed-spring --hand postural-arm --figure plane.svg
      haptisym stability my-device.toml --json --digits 50
      haptisym stability fu2019 --hand firm-grip --certificate proof.json
    """
    from haptisym.verbs.stability.entry import stability as of

    return of(ask.scene, ask.hand or None, ask.free, digits=ask.digits or 15, limit=None)


@verb(
    click.Argument(["scene"]),
    ENVIRONMENT,
    NO_FILES,
    option(
        "--free PATH[=LO:HI]",
        (
            "Free parameter and its range; up to three. A tenth to ten times its value if no "
            "range is given."
        ),
        multiple=True,
        required=True,
    ),
    choice(
        "--keep",
        "Search only values with this property; repeatable.",
        "passive",
        "stable",
        "steady",
        multiple=True,
    ),
    option("--hand NAME", "Hand of --keep stable and steady, of the scene or shipped."),
    option(
        "--robust SHARE",
        "Maximise the worst bandwidth if all values are off by up to this share, as 5%.",
    ),
    option(
        "--gap SHARE",
        "Relative gap between the proven bounds (0.1 % if not given, 1 % for three parameters).",
    ),
    JSON,
    figure("the bandwidth over one or two parameters"),
    LIMIT,
    TABLE,
    needs=[("--hand", "--keep", "the hand of --keep stable")],
)
def design(ask: Ask) -> Answer:
    """Find the values with the largest bandwidth.

    SCENE is a scene file (TOML) or the name of a shipped scene; of one with several environments the least bandwidth counts.

    Prints the best values, proven bounds of the largest bandwidth in the range, the criteria that limit it, and how much
    bandwidth remains if all values are off by 1 % or 5 %.

    \b
    Examples:
      haptisym design fu2019 --free zeta=0.01:1
      haptisym design inertia-compensation --free "m_c=0 g:32 g" --free "b_c=0 N*s/m:3.6 N*s/m" --keep passive
      haptisym design lead-compensation --free "T=0 ms:30 ms" --robust 5%
      haptisym design palpation-device --free omega_c --figure bandwidth.svg
    """
    from haptisym.verbs.design.entry import design as of

    opened, _ = open_scenes(ask.scene, files=not ask.no_files)
    if isinstance(opened, MeasuredScene):
        raise SceneError(
            "a measured scene has no parameters to choose: haptisym identify fits a model to it"
        )
    # Without a choice the whole family is designed for: of several bandwidths the least counts.
    scene = (
        opened if ask.environment is None else chosen(opened, Path(ask.scene).name, ask.environment)
    )
    free = dict(map(_range_of, ask.free))
    return of(scene, free, keep=ask.keep, hand=ask.hand, robust=ask.robust, gap=ask.gap, limit=None)


def _range_of(text: str) -> tuple[str, tuple[str, str] | None]:
    """A path, and the two ends that follow it."""
    path, sign, ends = text.partition("=")
    if not sign:
        return path, None
    low, colon, high = ends.partition(":")
    if not colon or not low.strip() or not high.strip():
        raise SceneError(
            f'--free {text[:60]}: write the range as LO:HI, as zeta=0.01:1 or "tau=1 ms:9 ms"'
        )
    return path.strip(), (low.strip(), high.strip())


@verb(SCENE, JSON, figure("bars of the elasticities"), LIMIT, each=True)
def sensitivity(ask: Ask) -> Answer:
    """Find how each frequency moves with each parameter.

    SCENE is a scene file (TOML) or the name of a shipped scene.

    For every crossing, changeover frequency and the bandwidth, and every parameter p and the
    threshold c: the derivative d omega/dp and the elasticity (p/omega) d omega/dp, proven.
    Undefined where a ratio is tangent to its threshold.

    \b
    Examples:
      haptisym sensitivity fu2019
      haptisym sensitivity my-device.toml --figure elasticities.pdf
      haptisym sensitivity my-device.toml --json --digits 50
    """
    from haptisym.verbs.sensitivity.entry import sensitivity as of

    return of(ask.scene, ask.digits or 15, limit=None)


@verb(
    SCENE,
    JSON,
    number("--samples N", "Number of random sets for the estimates.", 0, 100_000, 200),
    option("--seed", "Seed of the random sets.", type=int, default=2019, show_default=True),
    option(
        "--hand NAME", "Test stability in this hand, for all values; repeatable.", multiple=True
    ),
    figure("enclosures and samples, with a hand the plane of hands below them"),
    LIMIT,
    TABLE,
    each=True,
)
def tolerances(ask: Ask) -> Answer:
    """Find what holds for all values in given ranges.

    SCENE is a scene file (TOML) or the name of a shipped scene; a parameter in it may be written
    "1.8 kg +- 5 %", "1.8 kg +- 0.1 kg" or ["1.7 kg", "1.9 kg"], the threshold likewise.

    Proven by branch and bound: whether the display is transparent for all values, for none or for
    some; where each crossing lies; with --hand, whether it is stable for all values, for none or
    for some. Estimated: quantiles over random values. Exit status 3 where a verdict is undecided
    within the limit.

    \b
    Examples:
      haptisym tolerances fu2019-tolerances
      haptisym tolerances my-device.toml --samples 1000 --figure tolerances.pdf
      haptisym tolerances fu2019-tolerances --hand light-touch
      haptisym tolerances my-device.toml --json
    """
    from haptisym.verbs.tolerances.proofs import tolerances as of

    if ask.samples == 0 and given("--seed"):
        what = "--seed is about the random numbers of the estimates, and --samples 0 draws none"
        raise SceneError(f"{what}: leave out one of them")
    return of(ask.scene, ask.samples, ask.seed, hand=ask.hand or None, limit=None)


@verb(
    SCENE,
    option(
        "--vary PATH=LO:HI:N[:log]",
        'N values of a parameter, as "omega_n=40 rad/s:200 rad/s:100"; repeatable.',
        multiple=True,
        required=True,
    ),
    option("--hand NAME", "Count unstable poles in this hand; repeatable.", multiple=True),
    option(
        "--out FILE",
        "Write to FILE.zarr or FILE.nc; continues what is there.",
        type=PathType(path_type=Path),
    ),
    JSON,
    figure("the design chart of one or two parameters"),
    option(
        "--workers N", "Processes on this machine (1 if not given).", type=click.IntRange(1, 1024)
    ),
    option("--cluster ADDRESS", 'Address of a dask scheduler, as "tcp://10.0.0.1:8786".'),
    apart=[("--workers", "--cluster", "--workers computes on this machine, --cluster on others")],
)
def sweep(ask: Ask) -> None:
    """Evaluate a scene for every combination of values.

    SCENE is a scene file (TOML) or the name of a shipped scene. PATH is effects.NAME.KEY,
    environment.KEY, evaluation.jnd, hand.KEY, or a symbol.

    For each set: the first crossing and the number of crossings of each part, the bandwidth, the
    transparent fraction of the band, the changeover frequencies, and in each hand the number of
    unstable poles. Counts are proven, frequencies to a relative 1e-10. The same command continues
    an interrupted sweep.

    \b
    Examples:
      haptisym sweep fu2019 --vary effects.filter.omega_n=20:200:100 --figure bandwidth.svg
      haptisym sweep fu2019 --vary "effects.filter.omega_n=5 Hz:50 Hz:1000:log" \\
          --vary environment.m=0.5:5:1000 --out design.zarr --workers 2
      haptisym sweep fu2019 --hand light-touch --vary effects.filter.omega_n=5:200:100
    """
    # Workers share no memory with this process: their blocks meet in a file.
    if (ask.workers or ask.cluster) and ask.out is None:
        raise SceneError("--workers and --cluster need --out FILE, to which the workers write")
    from haptisym.commands.engines import engine, left_of
    from haptisym.model.scene import in_hands
    from haptisym.verbs.sweep.axes import spaced
    from haptisym.verbs.sweep.entry import Swept
    from haptisym.verbs.sweep.entry import sweep as of

    scene = in_hands(ask.scene, ask.hand or None)
    varied = [spaced(text, scene) for text in ask.vary]
    if len({path for path, _ in varied}) < len(varied):
        raise SceneError("--vary: each path may be given only once")
    if ask.figure is not None and len(varied) > 2:
        raise SceneError(
            f"figure: {ask.figure} would show one or two parameters, not {len(varied)}"
        )
    with progress("sets", kept=lambda reached: left_of(ask.out, reached)) as told:
        # In memory, without --out, dask has no part.
        with engine(ask.workers, ask.cluster) if ask.out else nullcontext():
            data = of(scene, dict(varied), out=ask.out, progress=told)
        hand_over(Swept(scene, data, ask.out), ask)


@verb(
    SCENE,
    choice("--to", "Language of the output.", "text", "latex", default="text", show_default=True),
    figure("the measures over the band"),
    option("--absolute-stability", "Print absolute stability even where it does not hold."),
    choice(
        "--rule RULE",
        "Test a control by 14 CFR Part 60: table A2A (aeroplanes) or C2A (helicopters).",
        "14cfr60-a2a",
        "14cfr60-c2a",
    ),
    option("--control NAME", "pitch, roll, pedals or nosewheel; cyclic, collective or pedals."),
    option("--travel LENGTH", "From neutral to the stop, for tolerances in pounds."),
    option("--sweep DURATION", 'How long a full sweep lasts, as "4 s"; repeatable.', multiple=True),
    JSON,
    LIMIT,
    EVERYTHING,
    apart=[
        ("--json", "--to", "--json prints one document, and --to another output"),
        *(
            ("--rule", x, "--rule prints a report of its tests")
            for x in ("--absolute-stability", "--all", "--to")
        ),
    ],
    needs=[(x, "--rule", "the tests of a rule") for x in ("--control", "--travel", "--sweep")],
    each=True,
)
def metrics(ask: Ask) -> Answer | None:
    """Compare the JND with other measures of transparency.

    SCENE is a scene file (TOML) or the name of a shipped scene.

    Transmitted over environment impedance and its 3 dB edges, relative distortion, Z_min, Z_max and
    Z_width, sensitivity, passivity and absolute stability, effective stiffness, mass and damping,
    and the free-response tolerances of flight simulators; --all prints formulas and values of each.

    \b
    Examples:
      haptisym metrics fu2019
      haptisym metrics steering-wheel --figure metrics.svg
      haptisym metrics fu2019 --to latex > metrics.tex
      haptisym metrics fu2019 --rule 14cfr60-a2a --travel "10 cm" --sweep "4 s" --report qtg.pdf
    """
    if ask.rule:
        from haptisym.verbs.metrics.controlloading import control_loading

        return control_loading(
            ask.scene, ask.rule, ask.control, travel=ask.travel, sweeps=ask.sweep, limit=None
        )
    from haptisym.verbs.metrics.entry import metrics as of

    answer = of(ask.scene, absolute_stability=ask.absolute_stability, limit=None)
    if ask.to == "text":
        return answer
    from haptisym.writing.latex import piece

    # What ``hand_over`` would do, with a piece of LaTeX in place of the page.
    draw(answer, ask)
    write(piece(keep_pages(answer, ask)()) + "\n")
    end(answer)
    return None


@verb(
    optional("scene"),
    ENVIRONMENT,
    NO_FILES,
    JSON,
    figure("digits against time"),
    option("--quick", "Fewer methods and repeats, for a first look."),
    option("--hard-cases", "Measure cases on which usual methods fail, instead of a scene."),
)
def cost(ask: Ask) -> Answer:
    """Measure what accuracy costs in time, for a scene or on hard cases.

    SCENE is a scene file (TOML) or the name of a shipped scene.

    Correct digits and time, measured against proven references of higher precision: of the ratios
    in floats and to many digits, of the crossings by grids, eigenvalues and proof, of Pade
    approximants for delays, and of each effect left out.

    \b
    Examples:
      haptisym cost fu2019
      haptisym cost my-device.toml --quick --figure cost.png
      haptisym cost --hard-cases --json
    """
    if ask.hard_cases and (ask.scene or ask.quick or ask.environment):
        raise SceneError(
            "--hard-cases brings its own scenes: leave out SCENE, --environment and --quick"
        )
    if ask.scene is None and not ask.hard_cases:
        raise SceneError("cost: name a SCENE, or ask for --hard-cases")
    from haptisym.verbs.cost.entry import cost as of
    from haptisym.verbs.cost.hardcosts import hard_costs

    with progress() as told:

        def at(what: str, share: float) -> None:
            """Report the share that is done, and what is being measured."""
            told(share, 1.0, what)

        return (
            hard_costs(told=at)
            if ask.scene is None
            else of(load_scene(ask.scene, ask.environment), quick=ask.quick, told=at)
        )


# Options of a hand that moves as prescribed, which a release test has none of.
_MOVED = ("--motion", "--amplitude", "--omega", "--check", "--lowpass")


@verb(
    SCENE,
    JSON,
    option(
        "--motion sine|multisine|chirp|FILE.csv",
        "Motion of the hand.",
        default="sine",
        show_default=True,
    ),
    option("--amplitude LENGTH", 'Amplitude of the motion, as "5 cm" or "3 deg".'),
    option("--omega FREQUENCY", 'Frequency of a sine, or the highest; as "2 Hz".'),
    option("--duration TIME", 'Simulated time, as "20 s".'),
    option("--release LENGTH", "Release test: hold displaced by LENGTH, then let go."),
    option("--hand NAME", "Hand of the release test, of the scene or shipped."),
    option("--check", "Compare with the closed form at ten frequencies."),
    option("--quantise LENGTH", 'Resolution of the position encoder, as "0.1 mm".'),
    option("--saturate FORCE", 'Largest force that can be rendered, as "5 N".'),
    option("--lowpass FREQUENCY", 'Smooth a recorded motion (zero phase), as "20 Hz".'),
    choice(
        "--lowpass-order ORDER",
        "Order of the low-pass filter (4 if not given).",
        "2",
        "4",
        "6",
        "8",
    ),
    output("--force FILE", "Write the force in time, with the motion, as CSV."),
    FIGURES,
    LIMIT,
    apart=[
        ("--check", "--motion", "--check chooses the motion itself"),
        ("--check", "--force", "--check compares frequencies, --force writes one run in time"),
        *(
            ("--release", x, f"--release lets the hand go, {x} is about a hand that moves")
            for x in _MOVED
        ),
    ],
    needs=[
        ("--lowpass-order", "--lowpass", "the low-pass"),
        ("--hand", "--release", "a hand that lets go"),
    ],
)
def simulate(ask: Ask) -> Answer:
    """Simulate a scene in time, and compare with the closed form.

    The force at the hand follows from the equations of motion of the elements of the scene (delay lines, sampling, sliding
    friction), not from the closed form; a lock-in recovers Re and Im of H_perc. With --release the hand holds the display
    displaced and lets go: does it shake, at which rate and frequency?

    \b
    Examples:
      haptisym simulate fu2019 --omega "10 rad/s"
      haptisym simulate sampled-wall --check
      haptisym simulate stick-with-friction --amplitude "5 cm" --figures figures
      haptisym simulate delayed-spring --release "1 cm" --hand light-touch
      haptisym simulate delayed-spring --release "1 cm" --hand light-touch --quantise "0.1 mm" --saturate "5 N"
      haptisym simulate fu2019 --motion hand.csv --lowpass "20 Hz" --force force.csv
    """
    with progress("s simulated") as told:
        if ask.release:
            from haptisym.verbs.simulate.entry import extras_of
            from haptisym.verbs.simulate.release import release

            extras = extras_of({"quantise": ask.quantise, "saturate": ask.saturate})
            found: Any = release(
                ask.scene,
                ask.release,
                ask.hand,
                duration=ask.duration,
                extras=extras,
                progress=told,
                limit=None,
            )
            force = found
        else:
            from haptisym.verbs.simulate.entry import run  # SciPy is loaded for this verb alone

            keys = (
                "amplitude",
                "omega",
                "duration",
                "quantise",
                "saturate",
                "lowpass",
                "lowpass_order",
            )
            found = run(
                ask.scene,
                ask.check,
                {"kind": ask.motion, **{x: getattr(ask, x) for x in keys}},
                told,
            )
            force = found[0]
    keep_text("force", ask.force, force.to_csv)
    return found  # type: ignore[no-any-return]


def _need_a_model(_context: click.Context, option: click.Parameter, given: Any) -> Any:
    """What was given; SceneError with the names of all models where that is none."""
    if given == "" or (isinstance(given, tuple) and "" in given):
        raise SceneError(
            f"{option.opts[0]} needs a model: valid are {', '.join(_models(option.multiple))}"
        )
    return given


def _models(of_effects: bool) -> Iterable[str]:
    """The names of all models, of effects or of environments."""
    from haptisym.model.catalogue import EFFECTS, ENVIRONMENTS

    return EFFECTS if of_effects else ENVIRONMENTS


def _no_such_option(_context: click.Context, _option: click.Parameter, given: str | None) -> None:
    """SceneError for an option by which one looks for models."""
    if given is not None:
        raise SceneError(
            "--model: what is felt is --environment MODEL, and what stands behind it "
            "--effect MODEL; or --degrees N D. "
            f"Environments are {', '.join(_models(False))}; effects are {', '.join(_models(True))}"
        )


_MAY_LACK: dict[str, Any] = {"is_flag": False, "flag_value": ""}
"""Of an option that needs a model and may be given none, which is then said with the names of
all."""


def _by_role(
    ctx: click.Context, param: click.Parameter, given: tuple[str, ...]
) -> dict[str, str | int]:
    """The values of ROLE=VALUE by their roles; whole numbers, which count columns, as such."""
    values: dict[str, str | int] = {}
    for text in given:
        role, equals, value = (x.strip() for x in text.partition("="))
        if not (role and equals and value):
            raise SceneError(f"{param.opts[-1]} {text}: write it as {param.metavar}")
        values[role] = int(value) if value.isdecimal() else value
    return values


@verb(
    click.Argument(["file"]),
    option(
        "--environment MODEL",
        "Environment model, as mass-spring-damper.",
        callback=_need_a_model,
        **_MAY_LACK,
    ),
    option(
        "--effect MODEL",
        "Effect model, nearest the environment first; repeatable.",
        multiple=True,
        callback=_need_a_model,
        **_MAY_LACK,
    ),
    option("--model", "", hidden=True, expose_value=False, callback=_no_such_option, **_MAY_LACK),
    option(
        "--degrees N D",
        "Degrees of numerator and denominator, in place of a model.",
        nargs=2,
        type=int,
    ),
    option("--band LOW HIGH", 'Use only this band, as "1 Hz" "20 Hz".', nargs=2),
    option("--averages N", "Number of averages of the column coherence.", type=float),
    option("--confidence P", "Confidence of all intervals (0.95 if not given).", type=float),
    option("--estimator NAME", "Estimator for records in time: H1, H2 or joint."),
    option("--segment TIME", 'Length of Welch segments of records in time, as "4 s".'),
    option(
        "--columns ROLE=COLUMN",
        "Header or number of a column, as real=2; repeatable.",
        multiple=True,
        callback=_by_role,
    ),
    option(
        "--unit ROLE=UNIT",
        "Unit of a column, as magnitude=dB; repeatable.",
        multiple=True,
        callback=_by_role,
    ),
    option(
        "--zwidth FILE",
        "Fit the device of a sampled scene to walls that began to shake: columns K and B.",
        type=PathType(),
    ),
    option("--free NAME", "Parameter that --zwidth fits; repeatable.", multiple=True),
    option("--hand NAME", "Hand in which --zwidth was measured (none if not given)."),
    option("--quantity NAME", "What the response is, as impedance (stiffness if not given)."),
    option("--sign -1", "The force was measured as the reaction: turn its sign round.", type=int),
    option("--minus FILE", "Measurement of the rig without load, which is subtracted."),
    option("--title TEXT", "Title of the scene that is written.", default=""),
    JSON,
    output("--scene FILE", "Write the fitted scene, each parameter with its range."),
    NO_FILES,
    figure("the model over what was measured, and the residuals"),
    LIMIT,
    needs=[("--free", "--zwidth", "the walls"), ("--hand", "--zwidth", "the walls")],
)
def identify(ask: Ask) -> Answer:
    """Fit a model to a measured response.

    FILE holds frequency points, or with --estimator records in time (CSV); or it is a scene with
    [perceived] (TOML), whose environment is known and whose effects are fitted. With --zwidth it is
    a sampled scene, of which --free parameters, or those with a range, are fitted.

    MODEL is a model of the catalogue. After a colon follow the parameters that it has, where some
    are optional, and given values: shunt:m,b or second-order-lowpass:zeta=0.5.

    Weighted least squares. Estimated: parameters with confidence intervals, and a test whether the
    model fits.

    \b
    Examples:
      haptisym identify device.csv --averages 20 --environment mass-spring-damper --effect delay
      haptisym identify device.csv --degrees 2 2 --effect delay --figure fit.svg
      haptisym identify bench.toml --effect second-order-lowpass --scene device.toml
      haptisym identify records.csv --estimator H1 --segment "4 s" --environment mass-spring-damper
      haptisym identify device.csv --environment kelvin-voigt --effect shunt:m --band "1 Hz" "20 Hz"
      haptisym identify wheel.toml --zwidth walls.csv --free effects.wheel.m --free effects.wheel.b
    """
    from haptisym.verbs.identify import entry

    if ask.zwidth:
        from haptisym.verbs.identify.zwidth import fit_zwidth

        in_hand = {"hand": ask.hand} if ask.hand else {}
        return fit_zwidth(ask.file, ask.zwidth, ask.free, **in_hand, limit=None)

    # Only what was given: a scene with [perceived] has its own and refuses any of them.
    keys = ("estimator", "segment", "columns", "unit", "quantity", "sign", "minus")
    records = {key: x for key in keys if (x := getattr(ask, key))}
    measured = entry.opened(
        ask.file, ask.averages, ask.confidence, files=not ask.no_files, **records
    )
    not_over(
        measured.files, {key: getattr(ask, key) for key in ("scene", "figure", "latex", "report")}
    )
    asked: dict[str, Any] = {"degrees": ask.degrees, "band": ask.band, "title": ask.title}
    fit = entry.identify(measured, ask.environment, ask.effect, **asked, limit=None)
    keep_text("scene", ask.scene, lambda: fit.text)
    return fit


class _Number(click.ParamType[object]):
    """A decimal number, or one of some words."""

    name = "number"

    def __init__(self, *words: str) -> None:
        self.words = words

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> object:
        from haptisym.model.quantities import decimal

        try:
            return (
                value
                if isinstance(value, float) or value in self.words
                else float(decimal(str(value)))
            )
        except SceneError as error:
            raise error.within(param.opts[-1] if param else "number") from None


@verb(
    optional("data"),
    option("--published", "List published thresholds that a scene can use by name."),
    option(
        "--discriminate",
        "With --regions: the changes that would decide between square, disc and tilted ellipse.",
    ),
    option(
        "--proportion P",
        "Proportion of responses that defines the JND (0.75 if not given).",
        type=_Number(),
    ),
    option(
        "--alternatives M",
        "Forced choice between M alternatives; levels are differences.",
        type=int,
    ),
    option(
        "--reference X", "Level of the standard, for the JND as a fraction of it.", type=_Number()
    ),
    option("--guess G", "Guess rate (0 if not given).", type=_Number(), default=0.0),
    option(
        "--lapse L", 'Lapse rate, or "free" (0 if not given).', type=_Number("free"), default=0.0
    ),
    option(
        "--confidence C",
        "Confidence of the interval (0.95 if not given).",
        type=_Number(),
        default=0.95,
    ),
    choice(
        "--method",
        "Method of the fit.",
        "likelihood",
        "psignifit",
        default="likelihood",
        show_default=True,
    ),
    option("--level COLUMN", "Column of the levels."),
    option("--count COLUMN", "Column of the counted responses, k."),
    option("--trials COLUMN", "Column of all responses, n."),
    option("--answer COLUMN", "Column of single responses, 1 or 0."),
    option("--more WORD", "Response that means more, where responses are two words."),
    option("--where COLUMN=VALUE", "Use only rows with this value; repeatable.", multiple=True),
    figure("answers and curve"),
    JSON,
)
def jnd(ask: Ask) -> Answer:
    """Fit a psychometric function to responses: the JND.

    DATA is a table (CSV) with a row for each level (level, k of n responses; as quickpsy and
    Palamedes write it) or for each trial (level, response; as PsychoPy writes it, staircases too),
    or a result of psignifit 4 (JSON).

    Without --alternatives responses are "more" or "less" than the standard: the JND is the distance
    from the point of subjective equality. With it they are correct or not, and the JND is the level
    itself.

    \b
    Examples:
      haptisym jnd answers.csv --reference 5
      haptisym jnd answers.csv --reference 5 --proportion 0.84 --figure answers.svg
      haptisym jnd staircase.csv --alternatives 2 --reference 1 --where participant=07
      haptisym jnd psignifit.json --method psignifit --json
      haptisym jnd --published
    """
    from haptisym.verbs.jnd.entry import jnd as of
    from haptisym.verbs.jnd.entry import published

    # Refused are all options but those that are spared, so that a new option is refused as well.
    if ask.published:
        spared = ("--published", "--json", "--latex", "--report")
        if any(given(x.opts[-1]) for x in jnd.params if x.opts[-1] not in spared):
            raise SceneError(
                "--published lists what others measured: leave out DATA and what is about it"
            )
        return published()
    if ask.data is None:
        raise SceneError("jnd: name a file of answers as DATA, or ask for --published")
    same = {
        key: getattr(ask, key)
        for key in (
            "proportion",
            "alternatives",
            "guess",
            "reference",
            "confidence",
            "method",
            "more",
        )
    }
    columns = {
        key: x
        for key in ("level", "count", "trials", "answer")
        if (x := getattr(ask, key)) is not None
    }
    # The only word that ``--lapse`` takes is "free": the rate is fitted.
    lapse = None if isinstance(ask.lapse, str) else ask.lapse
    return of(ask.data, lapse=lapse, where=_pairs(ask.where), columns=columns, **same)


def _pairs(asked: Iterable[str]) -> dict[str, str]:
    """The values of COLUMN=VALUE by their columns; SceneError for a column that is given
    twice."""
    values: dict[str, str] = {}
    for one in asked:
        column, sign, value = one.partition("=")
        if not sign or not column:
            raise SceneError(f'--where "{one[:60]}": write it as COLUMN=VALUE')
        if column in values:
            raise SceneError(f"--where {column} is given twice: lines have one value in a column")
        values[column] = value
    return values
