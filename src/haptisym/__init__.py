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
from .exact.reals import RealNumber
from .exact.roots import Interval, Point
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
    "Derivation": "formulas.answers",
    "DesignMap": "requirement.designmap",
    "EncoderQuantisation": "simulation.results",
    "FamilyEvaluation": "family.evaluation",
    "ForceSaturation": "simulation.results",
    "HardCosts": "costs.hardcosts",
    "Language": "codegen.scene",
    "Metrics": "measures.transparency",
    "Relevance": "pruning.answers",
    "Requirement": "requirement.question",
    "SceneFamily": "family.family",
    "Sensitivities": "sensitivities.answers",
    "Simulation": "simulation.simulate",
    "Tolerances": "tolerance.answers",
    "check": "simulation.simulate",
    "chirp": "simulation.motions",
    "cost": "costs.costs",
    "derive": "formulas.answers",
    "design_map": "requirement.designmap",
    "distortion_code": "codegen.scene",
    "evaluate_all": "family.evaluation",
    "family_names": "scenefile",
    "hard_costs": "costs.hardcosts",
    "interop": "",
    "load_scenes": "scenefile",
    "metrics": "measures.transparency",
    "multisine": "simulation.motions",
    "parse_scenes": "scenefile",
    "recording": "simulation.recordings",
    "relevance": "pruning.answers",
    "require": "requirement.question",
    "scene_code": "codegen.scene",
    "sensitivity": "sensitivities.answers",
    "simulate": "simulation.simulate",
    "simulation_cost": "costs.costs",
    "sine": "simulation.motions",
    "sweep": "sweeps.designspace",
    "tolerances": "tolerance.answers",
}
"""What is loaded only when it is used: simulation needs SciPy (the extra ``simulate``), formulas cost time at start.

Type checkers and editors read ``__init__.pyi``, which names the same.
"""


def __getattr__(name: str) -> object:
    if name not in _ON_DEMAND:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    module = import_module(f".{_ON_DEMAND[name] or name}", __name__)
    return getattr(module, name) if _ON_DEMAND[name] else module


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})


__all__ = [
    "Accuracy",
    "Change",
    "Cost",
    "Crossing",
    "CrossingKind",
    "Derivation",
    "DesignMap",
    "Distortion",
    "Effect",
    "EncoderQuantisation",
    "Environment",
    "Evaluation",
    "ExpressionError",
    "FamilyEvaluation",
    "ForceSaturation",
    "HaptisymError",
    "HardCosts",
    "Interval",
    "Language",
    "Metrics",
    "Part",
    "Peak",
    "Percept",
    "Point",
    "Property",
    "RealNumber",
    "Relevance",
    "Requirement",
    "Scene",
    "SceneError",
    "SceneFamily",
    "Sensitivities",
    "Simulation",
    "Threshold",
    "Tolerances",
    "UndecidedError",
    "check",
    "chirp",
    "cost",
    "derive",
    "design_map",
    "distort",
    "distortion_code",
    "effects",
    "environments",
    "evaluate",
    "evaluate_all",
    "family_names",
    "hard_costs",
    "interop",
    "latex",
    "load_scene",
    "load_scenes",
    "mathml",
    "metrics",
    "multisine",
    "omega",
    "parse_scene",
    "parse_scenes",
    "peaks",
    "recording",
    "relevance",
    "require",
    "s",
    "scene_code",
    "scene_names",
    "sensitivity",
    "simulate",
    "simulation_cost",
    "sine",
    "sweep",
    "symbols",
    "tolerances",
]
