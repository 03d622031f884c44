"""The command line: ``haptisym evaluate SCENE`` and its sisters.

What only some calls need (Rich for text, matplotlib for figures, the LaTeX printer) is imported where it is called
for, so that ``--json`` in a loop pays for none of it.
"""

from __future__ import annotations

import sys
from json import dumps
from pathlib import Path

import click

from . import __version__
from .commands.cost import cost
from .commands.effects import effects
from .commands.metrics import metrics
from .commands.require import require
from .commands.sensitivity import sensitivity
from .commands.sweep import sweep
from .commands.tolerances import tolerances
from .errors import HaptisymError, SceneError, UndecidedError
from .evaluation import evaluate as evaluate_scene
from .family.family import SceneFamily
from .options import environment_option, json_option
from .scenefile import family_names, load_scene, load_scenes, scene_names


class _Sisters(click.Group):
    """The group of verbs; a bare call prints the help."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(self.commands)  # in the order of the code, the main job first


@click.group(cls=_Sisters, context_settings={"help_option_names": ["-h", "--help"]}, no_args_is_help=False)
@click.version_option(__version__, prog_name="haptisym", message="%(prog)s %(version)s")
def app() -> None:
    """Evaluate haptic displays symbolically.

    A scene says what a hand should feel (the environment) and what stands in between (the effects). haptisym derives in
    closed form what is felt instead, proves from which frequency a person notices, and as what: stiffness, mass, damping.

    \b
    Begin with:
      haptisym evaluate fu2019              the example of Fu, van Paassen and Mulder (2019)
      haptisym scenes                       what else the package ships
      haptisym evaluate my-device.toml      your own; copy a shipped scene to start
    """


_CODE = ("numpy", "c", "octave", "julia", "javascript")
_OUTPUTS = ("text", "latex", "mathml", "json", *_CODE)


@app.command()
@click.argument("scene")
@click.argument("more", nargs=-1, metavar="")
@json_option
@environment_option
@click.option(
    "--environments",
    multiple=True,
    metavar="FILE...",
    help="Feel the environments of these scenes (files or names) instead, all at once.",
)
@click.option(
    "--digits",
    type=click.IntRange(1, 10_000),
    default=15,
    show_default=True,
    help="Correct decimal digits of each crossing.",
)
@click.option("--tolerance", metavar="X", help="Leave out the effects that change the ratios by at most that, jointly.")
@click.option(
    "--figures", type=click.Path(file_okay=False, path_type=Path), metavar="DIR", help="Write the figures there."
)
@click.option(
    "--latex", type=click.Path(dir_okay=False, path_type=Path), metavar="FILE", help="Write the derivation as LaTeX."
)
@click.option(
    "--report",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE",
    help="Write the report: a page (.html) with an explorer, or a document (.pdf).",
)
def evaluate(
    scene: str,
    more: tuple[str, ...],
    as_json: bool,
    environment: str | None,
    environments: tuple[str, ...],
    digits: int,
    tolerance: str | None,
    figures: Path | None,
    latex: Path | None,
    report: Path | None,
) -> None:
    """Find when a display begins to be noticed, and how it is felt, with proof.

    SCENE is a scene file (TOML) or the name of a shipped scene.

    Step 1 finds every frequency of the band at which r_r = |Re dH|/|H_env| or r_i = |Im dH|/|H_env| meets the JND
    threshold; step 2 says as which mechanical property the distortion is felt beyond it. Frequencies are in rad/s.

    A scene with several environments ([[environments]], or --environments after SCENE) gives a row for each and the worst
    case: the band that is transparent for all, and which environment and part bind at its ends.

    \b
    Examples:
      haptisym evaluate fu2019
      haptisym evaluate palpation-device
      haptisym evaluate palpation-device --environment liver
      haptisym evaluate fu2019 --environments fu2019 helicopter-cyclic my-stick.toml
      haptisym evaluate fu2019 --figures figures --latex fu2019.tex
      haptisym evaluate fu2019 --report fu2019.html
      haptisym evaluate my-device.toml --json --digits 50
      haptisym evaluate control-stick-in-detail --tolerance 0.01
    """
    if more and not environments:
        raise click.UsageError(f"got an unexpected argument ({more[0]})")
    family = load_scenes(scene, (*environments, *more))
    if environment is None and (environments or len(family) > 1):
        _evaluate_all(family, digits, figures, as_json=as_json, refused=latex or report)
        return
    result = evaluate_scene(
        load_scene(scene, environment) if not environments else family[str(environment)], digits, tolerance=tolerance
    )
    if figures is not None:
        from .figures.files import save_figures

        written = save_figures(result, figures)
        click.echo(f"{len(written)} figures written to {figures}", err=True)
    if latex is not None:
        from .tex.document import document

        latex.write_text(document(result), encoding="utf-8")
        click.echo(f"LaTeX written to {latex}", err=True)
    if report is not None:
        from .report.page import save_report

        save_report(result, report)
        click.echo(f"report written to {report}", err=True)
    click.echo(result.to_json() if as_json else str(result), nl=as_json)
    if not result.certified:
        sys.exit(3)


def _evaluate_all(
    family: SceneFamily, digits: int, figures: Path | None, *, as_json: bool, refused: Path | None
) -> None:
    """Several environments at once."""
    from .family.evaluation import evaluate_all

    if refused is not None:
        raise SceneError(f"{refused}: --latex and --report take one environment: choose with --environment NAME")
    result = evaluate_all(family, digits)
    if figures is not None:
        from .family.figure import save_family_figures

        written = save_family_figures(result, figures)
        click.echo(f"{len(written)} figures written to {figures}", err=True)
    click.echo(result.to_json() if as_json else str(result), nl=as_json)
    if not result.certified:
        sys.exit(3)


@app.command()
@click.argument("scene")
@click.option(
    "--symbolic", "mode", flag_value="symbolic", default="symbolic", help="Keep every parameter a symbol (the default)."
)
@click.option("--numeric", "mode", flag_value="numeric", help="Put the scene's number in for every parameter.")
@click.option(
    "--keep",
    "keep",
    multiple=True,
    metavar="NAME",
    help="Keep this parameter only (may be repeated; c is the threshold).",
)
@click.option("--to", "language", type=click.Choice(_OUTPUTS), default="text", show_default=True, help="What to write.")
@click.option(
    "--of", "names", multiple=True, metavar="QUANTITY", help="Only this quantity, written out (may be repeated)."
)
@environment_option
@json_option
def derive(
    scene: str,
    mode: str,
    keep: tuple[str, ...],
    language: str,
    names: tuple[str, ...],
    environment: str | None,
    as_json: bool,
) -> None:
    """Derive the formulas of a scene: in steps, written out, solved, dimensionless, and as code.

    SCENE is a scene file (TOML) or the name of a shipped scene.

    Quantities for --of: H_env, H_perc, dH, Re dH, Im dH, |H_env|^2, r_r, r_i, Re(dH/H_env), Im(dH/H_env), the threshold
    polynomials p_r and p_i, the perceived properties k_env, m_env, b_env, k_perc, m_perc, b_perc, the force phasors F_si_env,
    F_d_env, F_si_perc, F_d_perc, jnd k, jnd b, jnd m, the crossings omega_r and omega_i, the changeovers omega_env and
    omega_perc, and the sensitivities d omega_r/d NAME and d omega_i/d NAME of a crossing to a parameter.

    \b
    Examples:
      haptisym derive fu2019
      haptisym derive fu2019 --keep omega_n --of "Re dH" --to latex
      haptisym derive fu2019 --to c > distortion.c
    """
    from .formulas.derivation import derive as derive_scene

    loaded = load_scene(scene, environment)
    kept = keep or (None if mode == "symbolic" else ())
    if not as_json and language in _CODE:
        from .codegen.scene import Language, scene_code

        names_kept = None if kept is None else [x for x in kept if x != "c"]
        click.echo(scene_code(loaded, Language[language.upper()], parameters=names_kept), nl=False)
        return
    from .formulas import text as derivationtext
    from .formulas.sections import asked, sections

    d = derive_scene(loaded, kept)
    found = asked(d, names) if names else sections(d)
    write = getattr(derivationtext, f"as_{'json' if as_json else language}")
    click.echo(write(d, found), nl=as_json or language == "json")


@app.command()
@json_option
def scenes(as_json: bool) -> None:
    """List the scenes that the package ships."""
    listed = [(name, load_scenes(name)) for name in (*scene_names(), *family_names())]
    if as_json:
        keys = [(name, x.title, x.source, [e.name for e in x.first.effects], len(x)) for name, x in listed]
        rows = [dict(zip(("name", "title", "source", "effects", "environments"), row, strict=True)) for row in keys]
        click.echo(dumps({"schema": "haptisym.scenes/1", "scenes": rows}, indent=2, ensure_ascii=False))
        return
    width = max(len(name) for name, _ in listed)
    for name, x in listed:
        click.echo(f"{name:<{width}}  {x.title}")


@app.command()
@click.argument("scene")
@json_option
@environment_option
@click.option(
    "--motion",
    "kind",
    metavar="sine|multisine|chirp|FILE.csv",
    default="sine",
    show_default=True,
    help="What the hand does.",
)
@click.option("--amplitude", metavar="LENGTH", help='Of the motion, as "5 cm" or "3 deg".')
@click.option("--omega", metavar="FREQUENCY", help='Of a sine, or the highest; as "10 rad/s" or "2 Hz".')
@click.option("--duration", metavar="TIME", help='Simulated time, as "20 s"; as long as needed if not given.')
@click.option("--check", is_flag=True, help="Compare with the closed form at ten frequencies along the band.")
@click.option("--quantise", metavar="LENGTH", help='Resolution of the position encoder, as "0.1 mm".')
@click.option("--saturate", metavar="FORCE", help='Largest force that can be rendered, as "5 N".')
@click.option(
    "--figures", type=click.Path(file_okay=False, path_type=Path), metavar="DIR", help="Write the figures there."
)
def simulate(
    scene: str, as_json: bool, environment: str | None, check: bool, figures: Path | None, **options: str | None
) -> None:
    """Simulate a scene in time, and recover from the force what the closed form says.

    The force at the hand follows from the equations of motion of the scene's elements (delay lines, sampling clocks, sliding
    friction), not from the closed form; a lock-in then gives back Re and Im of H_perc to compare with it.

    \b
    Examples:
      haptisym simulate fu2019 --omega "10 rad/s"
      haptisym simulate sampled-wall --check
      haptisym simulate stick-with-friction --amplitude "5 cm" --figures figures
    """
    from .simulation.command import run  # SciPy is loaded for this verb alone

    runs = run(load_scene(scene, environment), check, options)
    if figures is not None:
        from .simulation.figures import save_simulation_figures

        written = save_simulation_figures(runs, figures)
        click.echo(f"{len(written)} figures written to {figures}", err=True)
    from .simulation.results import document
    from .simulation.text import page

    click.echo(dumps(document(runs), indent=2, ensure_ascii=False) if as_json else page(runs), nl=as_json)
    if any(x.agrees is False for x in runs):
        sys.exit(3)


app.add_command(metrics)
app.add_command(cost)
app.add_command(sensitivity)
app.add_command(tolerances)
app.add_command(sweep)
app.add_command(require)
app.add_command(effects)


def main() -> None:
    """Run the command line: exit status 0 done, 2 wrong scene or command line, 3 undecided."""
    try:
        sys.exit(app(sys.argv[1:] or ["--help"], standalone_mode=False, prog_name="haptisym"))
    except click.exceptions.Abort:
        sys.exit(130)
    except click.ClickException as error:
        error.show()
        sys.exit(2)
    except UndecidedError as error:
        _fail(f"undecided: {error}", 3)
    except HaptisymError as error:
        _fail(f"error: {error}", 2)
    except OSError as error:
        _fail(f"error: {error.filename}: {error.strerror}", 2)


def _fail(message: str, status: int) -> None:
    click.echo(message, err=True)
    sys.exit(status)
