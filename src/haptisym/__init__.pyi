from . import effects, environments, interop
from .catalogue import Effect, Environment
from .codegen.scene import Language, distortion_code, scene_code
from .costs.costs import Cost, cost, simulation_cost
from .costs.hardcosts import HardCosts, hard_costs
from .crossings import Crossing, CrossingKind
from .distortion import Distortion, distort
from .errors import ExpressionError, HaptisymError, SceneError, UndecidedError
from .evaluation import Evaluation, evaluate
from .exact.reals import RealNumber
from .exact.roots import Interval, Point
from .family.evaluation import FamilyEvaluation, evaluate_all
from .family.family import SceneFamily
from .formulas.answers import Derivation, derive
from .jnd import Part, Threshold
from .measures.transparency import Metrics, metrics
from .numeric.accuracy import Accuracy
from .peaks import Peak, peaks
from .percepts import Change, Percept, Property
from .pruning.answers import Relevance, relevance
from .requirement.designmap import DesignMap, design_map
from .requirement.question import Requirement, require
from .scene import Scene
from .scenefile import family_names, load_scene, load_scenes, parse_scene, parse_scenes, scene_names
from .sensitivities.answers import Sensitivities, sensitivity
from .simulation.motions import chirp, multisine, sine
from .simulation.recordings import recording
from .simulation.results import EncoderQuantisation, ForceSaturation
from .simulation.simulate import Simulation, check, simulate
from .sweeps.designspace import sweep
from .symbols import omega, s, symbols
from .tex.latex import latex
from .tolerance.answers import Tolerances, tolerances
from .typeset.mathml import mathml

__version__: str

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
