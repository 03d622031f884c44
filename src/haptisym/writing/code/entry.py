"""Code for a scene, or for a distortion: its closed forms as one function of omega and of the parameters."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

from sympy import Expr, Pow, Symbol

from haptisym.kernel.dynamics import on_axis
from haptisym.kernel.errors import SceneError
from haptisym.kernel.rings import omega
from haptisym.model.chain import Chain
from haptisym.model.distortion import Distortion, part_of
from haptisym.model.jnd import Part
from haptisym.model.parameters import Rule, values
from haptisym.model.quantities import Dimension, MotionKind
from haptisym.model.scene import THRESHOLD, Knob, Scene
from haptisym.model.scenefile import as_scene
from haptisym.programs.balls import BallPoint
from haptisym.programs.program import Program
from haptisym.programs.stable import closed_program
from haptisym.programs.values import Values
from haptisym.writing.code.code import About, Argument, Source, nearest_double
from haptisym.writing.code.languages import Language
from haptisym.writing.mathtext import plain

__all__ = ["Language", "distortion_code", "scene_code", "scene_program"]

FREQUENCY = Argument(omega, "rad/s", "angular frequency", ">= 0")
_MEANINGS = {
    "real": "Re dH, the real part of the distortion dH = H_perc - H_env",
    "imag": "Im dH",
    "ratio_real": "r_r = |Re dH|/|H_env|, what the JND judges, a ratio",
    "ratio_imag": "r_i = |Im dH|/|H_env|, what the JND judges, a ratio",
    "relative_real": "Re(dH/H_env), which is not r_r, a ratio",
    "relative_imag": "Im(dH/H_env), which is not r_i, a ratio",
    "environment_real": "Re H_env, what should be felt",
    "environment_imag": "Im H_env",
    "perceived_real": "Re H_perc, what is felt",
    "perceived_imag": "Im H_perc",
}
_NOTES = (
    "H is force per position at s = j omega. Re H > 0 is felt as stiffness Re H, Re H < 0 as mass -Re H/omega^2.",
    "At omega = 0 the values are the limits where these are finite. At a pole they are Inf or NaN.",
    "At a zero of H_env 0/0 is NaN, where compile() of haptisym gives the limit.",
    "An argument that is 0 may make 0/0 there, which is NaN: a term that is not there is better left out of the scene.",
)


def scene_code(
    scene: Scene | str | Path,
    language: Language | str,
    *,
    name: str = "distortion",
    parameters: Iterable[str] | None = None,
) -> str:
    """The closed forms of a scene as a function of omega and of its parameters.

    ``parameters`` : the names of those that stay arguments, in SI; all by default, none for ``()``. The others have the
    scene's values in the code. The results are Re and Im of dH, of dH/H_env, of H_env and of H_perc, and the ratios r_r
    and r_i. Raises SceneError for a parameter that the scene does not have.

    With sums of squares for moduli and half angles for delays, each part has an error below 1e-12 (|H_env| + |H_perc|),
    the ratios and relative parts below 1e-12 (1 + |H_perc|/|H_env|): tested for every shipped scene, with its
    values and with values around them, at omega = 0 and up to 10^4 rad/s.

    >>> from haptisym.model.scenefile import load_scene
    >>> text = scene_code(load_scene("fu2019"), Language.C, parameters=["omega_n"])
    >>> next(line for line in text.splitlines() if line.startswith("void"))
    'void distortion(double omega, double omega_n, distortion_values *values);'
    """
    return scene_program(scene, parameters).code(language, name=name)


def scene_program(scene: Scene | str | Path, parameters: Iterable[str] | None = None) -> Source:
    """What ``scene_code`` prints, with the same parameters, derived once for several languages.

    >>> from haptisym.model.scenefile import load_scene
    >>> [x.symbol.name for x in scene_program(load_scene("delayed-spring")).arguments]
    ['omega', 'k', 'tau']
    """
    scene = as_scene(scene)
    free = scene.parameters if parameters is None else [scene.knobs[name].felt() for name in parameters]
    limit = next((x for x in free if x.parts), None)
    if limit is not None:
        raise SceneError(f"{limit.path} is a threshold, of which code holds nothing: leave it out")
    fixed = values(x for x in scene.parameters if x not in free)
    chain = scene.chain.at(fixed)
    arguments = [_argument(x, scene.motion) for x in scene.parameters if x in free]
    arguments += [Argument(x) for x in chain.parameters if x not in {a.symbol for a in arguments}]
    about = About(scene.title or "Distortion of a haptic display", _scene_notes(scene, fixed), _results(scene.motion))
    return Source(computed(chain), (FREQUENCY, *arguments), about)


def distortion_code(distortion: Distortion, language: Language | str, *, name: str = "distortion") -> str:
    """The closed forms of a distortion as a function of omega and of the parameters that are still symbols, by name.

    >>> from haptisym import effects, environments
    >>> from haptisym.model.distortion import distort
    >>> d = distort(environments.kelvin_voigt(100, 2), effects.delay(Symbol("tau")))
    >>> "function values = distortion(omega, tau)" in distortion_code(d, Language.OCTAVE)
    True
    """
    arguments = [FREQUENCY, *(Argument(x) for x in sorted(distortion.free_symbols, key=str))]
    notes = (f"H_env(s) = {_formula(distortion.environment)}", f"H_perc(s) = {_formula(distortion.perceived)}", *_NOTES)
    about = About("Distortion of a haptic display", notes, _results(None))
    return Source(computed(distortion.needed_chain), tuple(arguments), about).code(language, name=name)


def computed(chain: Chain) -> Program:
    """The fields of ``Values``, in its order: the program that ``compile`` runs, if no value of it is a limit."""
    program = chain.program(Values._fields)
    return program if _has_no_limits(chain, program) else closed(chain)


def closed(chain: Chain) -> Program:
    """The same from the closed forms, in lowest terms."""
    d = Distortion.of(chain)
    dynamics = (d.env.numerator, d.env.denominator, d.perc.denominator)
    factors = [p for polynomial in dynamics for p, _ in d.env.ring.factors(polynomial, in_square=False)[1]]
    return closed_program(d.functions(Values._fields), factors, chain.parameters)


def _has_no_limits(chain: Chain, program: Program) -> bool:
    """Whether all values are values: Re and Im of H_env have no zero in common, and nothing is 0/0 at 0."""
    environment = on_axis(chain.ring.convert(chain.environment).reduced())
    R, X = (part_of(environment, part).function.numerator for part in Part)
    apart = R.is_zero() or X.is_zero() or R.gcd(X).is_constant()
    at_zero = BallPoint(program, (0.0, *(1.25 + n / 8 for n in range(len(program.inputs) - 1))))
    return apart and all(x.is_finite() for x in at_zero.balls(128).values())


def _results(motion: MotionKind | None) -> dict[str, tuple[str, str]]:
    force = Dimension.STIFFNESS.unit(motion)
    return {name: (words, "" if name.startswith(("ratio", "relative")) else force) for name, words in _MEANINGS.items()}


def _formula(expression: Expr) -> str:
    """A formula as a line of text."""
    plainly = all(x.exp.is_number for x in expression.atoms(Pow))
    return plain(expression) if plainly else str(expression).replace("**", "^")


def _scene_notes(scene: Scene, fixed: Mapping[Symbol, Expr]) -> tuple[str, ...]:
    chain = ", ".join(f"{e.name} ({e.model})" if e.name != e.model else e.name for e in scene.effects) or "none"
    rendered = [f"Rendered instead: {_formula(scene.rendered.dynamics)}"] if scene.rendered else []
    given = ", ".join(f"{p.symbol} = {_formula(p.value)}" for p in scene.parameters if p.symbol in fixed)
    limits = [THRESHOLD] if scene.knobs.limits else []  # a polygon has none
    return (
        f"H_env(s) = {_formula(scene.environment.dynamics)} ({scene.environment.model})",
        *rendered,
        f"H_perc: through these effects, nearest the environment first: {chain}.",
        *([f"Fixed values, SI: {given}."] if given else []),
        *scene.asides([*limits, *(x.path for x in scene.parameters if x.symbol not in fixed)]),
        *_NOTES,
        *([f"Source: {scene.source}"] if scene.source else []),
    )


_LABELS = {"environment": "the environment", "rendered": "what is rendered"}


_RANGES = {Rule.POSITIVE: "> 0", Rule.NONNEGATIVE: ">= 0", Rule.FRACTION: "between 0 and 1", Rule.ANY: "any sign"}


def _argument(p: Knob, motion: MotionKind | None) -> Argument:
    label = _LABELS.get(p.place) or f"the effect {p.place.partition('.')[2]}"
    kind = "number" if p.dimension in (Dimension.ANY, Dimension.RATIO) else p.dimension.name.lower()
    unit = "" if p.dimension is Dimension.RATIO else p.unit_in(motion) or "SI units"
    example = f"{nearest_double(p.value):.12g} in the scene" if p.value.is_number else ""
    model = "" if label.endswith(f" {p.model}") else f" ({p.model})"
    return Argument(p.symbol, unit, f"{kind} {p.key} of {label}{model}", _RANGES.get(p.rule, ""), example)
