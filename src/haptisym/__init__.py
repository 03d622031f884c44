"""haptisym: evaluate haptic displays symbolically. What is felt instead, when it is noticed, and as what.

>>> import haptisym as hs
>>> m, b, k = hs.symbols("m b k")
>>> d = hs.distort(hs.environments.mass_spring_damper(m, b, k), hs.effects.first_order_lag(hs.symbols("omega_c")))
>>> d.relative_real
-omega**2/(omega**2 + omega_c**2)
"""

from importlib import import_module

__version__ = "0.2.0"

_NAMES = {
    "": "effects environments interop",
    "judge.crossings": "Crossing CrossingKind",
    "judge.evaluation": "Evaluation",
    "judge.peaks": "Peak Peaks peaks",
    "judge.percepts": "Change Percept Property",
    "kernel.errors": "ExpressionError HaptisymError SceneError UndecidedError",
    "kernel.reals": "RealNumber",
    "kernel.rings": "omega s symbols",
    "kernel.roots": "Interval Point",
    "model.catalogue": "Effect Environment Hand hands",
    "model.devices": "devices",
    "model.distortion": "Distortion distort",
    "model.estimating": "estimated",
    "model.jnd": "Part Published Threshold",
    "model.measured": "Measurement",
    "model.measuredscene": "MeasuredScene",
    "model.measuring": "measured sampled",
    "model.scene": "Scene",
    "model.scenefile": "SceneFamily load_scene load_scenes parse_scene parse_scenes",
    "model.shipped": "family_names scene_names",
    "pages.notebook": "latex",
    "programs.accuracy": "Accuracy",
    "verbs.cost.entry": "Cost cost",
    "verbs.cost.hardcosts": "HardCosts hard_costs",
    "verbs.derive.derivation": "Derivation derive",
    "verbs.derive.verify": "Verification verify",
    "verbs.design.entry": "Design design",
    "verbs.effects.relevance": "Relevance relevance",
    "verbs.evaluate.entry": "evaluate",
    "verbs.family.entry": "FamilyEvaluation evaluate_all",
    "verbs.identify.entry": "Identification identify",
    "verbs.jnd.entry": "Psychometric PublishedThresholds jnd published",
    "verbs.measured.entry": "MeasuredEvaluation",
    "verbs.metrics.controlloading": "ControlLoading control_loading",
    "verbs.metrics.entry": "metrics",
    "verbs.metrics.metric": "Metrics",
    "verbs.require.designmap": "DesignMap design_map",
    "verbs.require.required": "Requirement require",
    "verbs.sensitivity.entry": "Sensitivities sensitivity",
    "verbs.simulate.entry": "EncoderQuantisation ForceSaturation Simulation check simulate",
    "model.motions": "chirp multisine recording sine",
    "verbs.simulate.release": "Release release",
    "verbs.stability.entry": "Stability stability",
    "verbs.sweep.entry": "sweep",
    "verbs.tolerances.proofs": "Tolerances tolerances",
    "writing.code": "Language distortion_code scene_code",
    "writing.mathml": "mathml",
    "writing.schemas": "json_schema",
}
"""The public names by the modules that have them, each loaded when one of its names is used: not even SymPy is before.

Type checkers and editors read ``__init__.pyi``, which names the same.
"""
_MODULES = {name: module for module, names in _NAMES.items() for name in names.split()}
__all__ = sorted(_MODULES)


def __getattr__(name: str) -> object:
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module = import_module(f".{_MODULES[name] or name}", __name__)
    found = globals()[name] = getattr(module, name) if _MODULES[name] else module
    return found


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
