from haptisym import effects, environments, interop
from haptisym.judge.crossings import Crossing, CrossingKind
from haptisym.judge.evaluation import Evaluation
from haptisym.judge.peaks import Peak, Peaks, peaks
from haptisym.judge.percepts import Change, Percept, Property
from haptisym.kernel.errors import ExpressionError, HaptisymError, SceneError, UndecidedError
from haptisym.kernel.reals import RealNumber
from haptisym.kernel.rings import omega, s, symbols
from haptisym.kernel.roots import Interval, Point
from haptisym.model.catalogue import Effect, Environment, Hand, hands
from haptisym.model.distortion import Distortion, distort
from haptisym.model.estimating import estimated
from haptisym.model.jnd import Part, Published, Threshold
from haptisym.model.measured import Measurement
from haptisym.model.measuredscene import MeasuredScene
from haptisym.model.measuring import measured, sampled
from haptisym.model.motions import chirp, multisine, recording, sine
from haptisym.model.scene import Scene
from haptisym.model.scenefile import SceneFamily, load_scene, load_scenes, parse_scene, parse_scenes
from haptisym.model.shipped import family_names, scene_names
from haptisym.pages.notebook import latex
from haptisym.programs.accuracy import Accuracy
from haptisym.verbs.cost.entry import Cost, cost
from haptisym.verbs.cost.hardcosts import HardCosts, hard_costs
from haptisym.verbs.derive.derivation import Derivation, derive
from haptisym.verbs.derive.verify import Verification, verify
from haptisym.verbs.design.entry import Design, design
from haptisym.verbs.effects.relevance import Relevance, relevance
from haptisym.verbs.evaluate.entry import evaluate
from haptisym.verbs.family.each import FamilyAnswers, answer_each
from haptisym.verbs.family.entry import FamilyEvaluation, evaluate_all
from haptisym.verbs.identify.entry import Identification, identify
from haptisym.verbs.jnd.entry import Psychometric, PublishedThresholds, jnd, published
from haptisym.verbs.measured.entry import MeasuredEvaluation
from haptisym.verbs.metrics.entry import metrics
from haptisym.verbs.metrics.metric import Metrics
from haptisym.verbs.require.designmap import DesignMap, design_map
from haptisym.verbs.require.required import Requirement, require
from haptisym.verbs.sensitivity.entry import Sensitivities, sensitivity
from haptisym.verbs.simulate.entry import EncoderQuantisation, ForceSaturation, Simulation, check, simulate
from haptisym.verbs.simulate.release import Release, release
from haptisym.verbs.stability.entry import Stability, stability
from haptisym.verbs.sweep.entry import sweep
from haptisym.verbs.tolerances.proofs import Tolerances, tolerances
from haptisym.writing.code import Language, distortion_code, scene_code
from haptisym.writing.mathml import mathml
from haptisym.writing.schemas import json_schema

__version__: str

__all__ = [
    "Accuracy",
    "Change",
    "Cost",
    "Crossing",
    "CrossingKind",
    "Derivation",
    "Design",
    "DesignMap",
    "Distortion",
    "Effect",
    "EncoderQuantisation",
    "Environment",
    "Evaluation",
    "ExpressionError",
    "FamilyAnswers",
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
    "answer_each",
    "check",
    "chirp",
    "cost",
    "derive",
    "design",
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
