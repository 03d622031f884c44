"""haptisym: evaluate haptic displays symbolically. What is felt instead, when it is noticed, and as what.

>>> import haptisym as hs
>>> m, b, k = hs.symbols("m b k")
>>> d = hs.distort(hs.environments.mass_spring_damper(m, b, k), hs.effects.first_order_lag(hs.symbols("omega_c")))
>>> d.relative_real
-omega**2/(omega**2 + omega_c**2)
"""

from . import effects, environments
from .catalogue import Effect, Environment
from .crossings import Crossing, CrossingKind
from .distortion import Distortion, distort
from .errors import ExpressionError, HaptisymError, SceneError, UndecidedError
from .evaluation import Evaluation, evaluate
from .jnd import Part, Threshold
from .numeric.accuracy import Accuracy
from .peaks import Peak, peaks
from .percepts import Change, Percept, Property
from .report.notebook import register as _register
from .scene import Scene
from .scenefile import load_scene, parse_scene, scene_names
from .symbols import omega, s, symbols
from .tex.latex import latex
from .typeset.mathml import mathml

_register()

__version__ = "0.1.0"

_ON_DEMAND = {
    "Cost": "costs.costs",
    "Derivation": "formulas.derivation",
    "EncoderQuantisation": "simulation.results",
    "FamilyEvaluation": "family.evaluation",
    "ForceSaturation": "simulation.results",
    "Language": "codegen.scene",
    "SceneFamily": "family.family",
    "Simulation": "simulation.simulate",
    "Relevance": "pruning.relevance",
    "check": "simulation.simulate",
    "chirp": "simulation.motions",
    "cost": "costs.costs",
    "derive": "formulas.derivation",
    "evaluate_all": "family.evaluation",
    "family_names": "scenefile",
    "distortion_code": "codegen.scene",
    "hard_costs": "costs.hardcosts",
    "interop": "",
    "load_scenes": "scenefile",
    "metrics": "measures.transparency",
    "multisine": "simulation.motions",
    "parse_scenes": "scenefile",
    "recording": "simulation.recordings",
    "Sensitivities": "sensitivities.answers",
    "Tolerances": "tolerance.answers",
    "DesignMap": "requirement.designmap",
    "Requirement": "requirement.question",
    "design_map": "requirement.designmap",
    "require": "requirement.question",
    "relevance": "pruning.relevance",
    "scene_code": "codegen.scene",
    "sensitivity": "sensitivities.answers",
    "simulate": "simulation.simulate",
    "simulation_cost": "costs.costs",
    "sine": "simulation.motions",
    "tolerances": "tolerance.answers",
    "sweep": "sweeps.designspace",
}
"""What is loaded only when it is used: simulation needs SciPy (the extra ``simulate``), formulas cost time at start."""


def __getattr__(name: str) -> object:
    if name not in _ON_DEMAND:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    module = import_module(f".{_ON_DEMAND[name] or name}", __name__)
    return getattr(module, name) if _ON_DEMAND[name] else module


__all__ = [
    "Accuracy",
    "Change",
    "Crossing",
    "CrossingKind",
    "Distortion",
    "Effect",
    "Environment",
    "Evaluation",
    "ExpressionError",
    "HaptisymError",
    "Part",
    "Peak",
    "Percept",
    "Property",
    "Scene",
    "SceneError",
    "Threshold",
    "UndecidedError",
    "distort",
    "effects",
    "environments",
    "evaluate",
    "latex",
    "load_scene",
    "mathml",
    "omega",
    "parse_scene",
    "peaks",
    "s",
    "scene_names",
    "symbols",
]
