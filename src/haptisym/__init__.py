"""haptisym: evaluate haptic displays symbolically. What is felt instead, when it is noticed, and as what.

>>> import haptisym as hs
>>> m, b, k = hs.symbols("m b k")
>>> d = hs.distort(hs.environments.mass_spring_damper(m, b, k), hs.effects.first_order_lag(hs.symbols("omega_c")))
>>> d.relative_real
-omega**2/(omega**2 + omega_c**2)
"""

from haptisym import effects, environments
from haptisym.judge.crossings import Crossing, CrossingKind
from haptisym.judge.evaluation import Evaluation
from haptisym.judge.percepts import Change, Percept, Property
from haptisym.kernel.errors import ExpressionError, HaptisymError, SceneError, UndecidedError
from haptisym.kernel.reals import RealNumber
from haptisym.kernel.rings import omega, s, symbols
from haptisym.kernel.roots import Interval, Point
from haptisym.model.catalogue import Effect, Environment
from haptisym.model.distortion import Distortion, distort
from haptisym.model.jnd import Part, Threshold
from haptisym.model.measuredscene import MeasuredScene
from haptisym.model.scene import Scene
from haptisym.model.scenefile import load_scene, parse_scene, scene_names
from haptisym.programs.accuracy import Accuracy
from haptisym.verbs.evaluate.entry import evaluate

__version__ = "0.1.0"

_ON_DEMAND = {
    "Cost": "verbs.cost.entry",
    "Derivation": "verbs.derive.derivation",
    "DesignMap": "verbs.require.designmap",
    "EncoderQuantisation": "verbs.simulate.entry",
    "FamilyEvaluation": "verbs.family.entry",
    "ForceSaturation": "verbs.simulate.entry",
    "Hand": "model.catalogue",
    "HardCosts": "verbs.cost.hardcosts",
    "Identification": "verbs.identify.entry",
    "Language": "writing.code",
    "MeasuredEvaluation": "verbs.measured.entry",
    "Measurement": "model.measured",
    "Metrics": "verbs.metrics.metric",
    "Peak": "judge.peaks",
    "Peaks": "judge.peaks",
    "Psychometric": "verbs.jnd.entry",
    "Release": "verbs.simulate.release",
    "Published": "model.jnd",
    "PublishedThresholds": "verbs.jnd.entry",
    "Relevance": "verbs.effects.relevance",
    "Requirement": "verbs.require.required",
    "SceneFamily": "model.scenefile",
    "Stability": "verbs.stability.entry",
    "Sensitivities": "verbs.sensitivity.entry",
    "Simulation": "verbs.simulate.entry",
    "Tolerances": "verbs.tolerances.proofs",
    "Verification": "verbs.derive.verify",
    "check": "verbs.simulate.entry",
    "chirp": "verbs.simulate.motions",
    "cost": "verbs.cost.entry",
    "derive": "verbs.derive.derivation",
    "design_map": "verbs.require.designmap",
    "distortion_code": "writing.code",
    "estimated": "model.estimating",
    "evaluate_all": "verbs.family.entry",
    "family_names": "model.scenefile",
    "hands": "model.catalogue",
    "hard_costs": "verbs.cost.hardcosts",
    "identify": "verbs.identify.entry",
    "interop": "",
    "jnd": "verbs.jnd.entry",
    "json_schema": "writing.schemas",
    "latex": "pages.notebook",
    "load_scenes": "model.scenefile",
    "mathml": "writing.mathml",
    "measured": "model.measuring",
    "metrics": "verbs.metrics.entry",
    "multisine": "verbs.simulate.motions",
    "parse_scenes": "model.scenefile",
    "peaks": "judge.peaks",
    "published": "verbs.jnd.entry",
    "recording": "verbs.simulate.motions",
    "release": "verbs.simulate.release",
    "relevance": "verbs.effects.relevance",
    "require": "verbs.require.required",
    "sampled": "model.measuring",
    "scene_code": "writing.code",
    "sensitivity": "verbs.sensitivity.entry",
    "simulate": "verbs.simulate.entry",
    "sine": "verbs.simulate.motions",
    "stability": "verbs.stability.entry",
    "sweep": "verbs.sweep.entry",
    "tolerances": "verbs.tolerances.proofs",
    "verify": "verbs.derive.verify",
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
    "Hand",
    "HaptisymError",
    "HardCosts",
    "Identification",
    "Interval",
    "Language",
    "MeasuredEvaluation",
    "MeasuredScene",
    "Measurement",
    "Metrics",
    "Part",
    "Peak",
    "Peaks",
    "Percept",
    "Point",
    "Property",
    "Psychometric",
    "Published",
    "PublishedThresholds",
    "RealNumber",
    "Release",
    "Relevance",
    "Requirement",
    "Scene",
    "SceneError",
    "SceneFamily",
    "Sensitivities",
    "Simulation",
    "Stability",
    "Threshold",
    "Tolerances",
    "UndecidedError",
    "Verification",
    "check",
    "chirp",
    "cost",
    "derive",
    "design_map",
    "distort",
    "distortion_code",
    "effects",
    "environments",
    "estimated",
    "evaluate",
    "evaluate_all",
    "family_names",
    "hands",
    "hard_costs",
    "identify",
    "interop",
    "jnd",
    "json_schema",
    "latex",
    "load_scene",
    "load_scenes",
    "mathml",
    "measured",
    "metrics",
    "multisine",
    "omega",
    "parse_scene",
    "parse_scenes",
    "peaks",
    "published",
    "recording",
    "release",
    "relevance",
    "require",
    "s",
    "sampled",
    "scene_code",
    "scene_names",
    "sensitivity",
    "simulate",
    "sine",
    "stability",
    "sweep",
    "symbols",
    "tolerances",
    "verify",
]
