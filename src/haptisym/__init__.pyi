from haptisym import effects as effects, environments as environments, interop as interop
from haptisym.judge.crossings import Crossing as Crossing, CrossingKind as CrossingKind
from haptisym.judge.evaluation import Evaluation as Evaluation
from haptisym.judge.peaks import Peak as Peak, Peaks as Peaks, peaks as peaks
from haptisym.judge.percepts import Change as Change, Percept as Percept, Property as Property
from haptisym.kernel.errors import (
    ExpressionError as ExpressionError,
    HaptisymError as HaptisymError,
    SceneError as SceneError,
    UndecidedError as UndecidedError,
)
from haptisym.kernel.reals import RealNumber as RealNumber
from haptisym.kernel.rings import omega as omega, s as s, symbols as symbols
from haptisym.kernel.roots import Interval as Interval, Point as Point
from haptisym.kernel.sets import ValueSet as ValueSet
from haptisym.model.catalogue import (
    Effect as Effect,
    Environment as Environment,
    Hand as Hand,
    hands as hands,
)
from haptisym.model.devices import devices as devices
from haptisym.model.distortion import (
    Distortion as Distortion,
    distort as distort,
    solve_for as solve_for,
)
from haptisym.model.estimating import estimated as estimated
from haptisym.model.jnd import Part as Part, Published as Published, Threshold as Threshold
from haptisym.model.measured import Measurement as Measurement
from haptisym.model.measuredscene import MeasuredScene as MeasuredScene
from haptisym.model.measuring import measured as measured, sampled as sampled
from haptisym.model.motions import (
    chirp as chirp,
    multisine as multisine,
    recording as recording,
    sine as sine,
)
from haptisym.model.scene import Scene as Scene
from haptisym.model.scenefile import (
    SceneFamily as SceneFamily,
    load_scene as load_scene,
    load_scenes as load_scenes,
    parse_scene as parse_scene,
    parse_scenes as parse_scenes,
)
from haptisym.model.shipped import family_names as family_names, scene_names as scene_names
from haptisym.pages.explore import Explorer as Explorer, explore as explore
from haptisym.pages.notebook import latex as latex
from haptisym.programs.accuracy import Accuracy as Accuracy
from haptisym.verbs.cost.entry import Cost as Cost, cost as cost
from haptisym.verbs.cost.hardcosts import HardCosts as HardCosts, hard_costs as hard_costs
from haptisym.verbs.derive.derivation import Derivation as Derivation, derive as derive
from haptisym.verbs.derive.verify import Verification as Verification, verify as verify
from haptisym.verbs.design.entry import Design as Design, design as design
from haptisym.verbs.effects.relevance import Relevance as Relevance, relevance as relevance
from haptisym.verbs.compare.entry import Comparison as Comparison, compare as compare
from haptisym.verbs.evaluate.entry import evaluate as evaluate
from haptisym.verbs.family.answers import FamilyAnswers as FamilyAnswers, answer_each as answer_each
from haptisym.verbs.family.entry import (
    FamilyEvaluation as FamilyEvaluation,
    evaluate_all as evaluate_all,
)
from haptisym.verbs.identify.entry import Identification as Identification, identify as identify
from haptisym.verbs.identify.zwidth import ZWidthFit as ZWidthFit, fit_zwidth as fit_zwidth
from haptisym.verbs.jnd.entry import (
    Psychometric as Psychometric,
    PublishedThresholds as PublishedThresholds,
    jnd as jnd,
    published as published,
)
from haptisym.verbs.measured.entry import MeasuredEvaluation as MeasuredEvaluation
from haptisym.verbs.metrics.controlloading import (
    ControlLoading as ControlLoading,
    control_loading as control_loading,
)
from haptisym.verbs.metrics.entry import metrics as metrics
from haptisym.verbs.metrics.metric import Metrics as Metrics
from haptisym.verbs.require.designmap import DesignMap as DesignMap, design_map as design_map
from haptisym.verbs.require.required import Requirement as Requirement, require as require
from haptisym.verbs.sensitivity.entry import (
    Sensitivities as Sensitivities,
    sensitivity as sensitivity,
)
from haptisym.verbs.simulate.entry import (
    EncoderQuantisation as EncoderQuantisation,
    ForceSaturation as ForceSaturation,
    Simulation as Simulation,
    check as check,
    simulate as simulate,
)
from haptisym.verbs.simulate.release import Release as Release, release as release
from haptisym.verbs.stability.entry import Stability as Stability, stability as stability
from haptisym.verbs.sweep.entry import sweep as sweep
from haptisym.verbs.tolerances.proofs import Tolerances as Tolerances, tolerances as tolerances
from haptisym.writing.code import (
    Language as Language,
    distortion_code as distortion_code,
    scene_code as scene_code,
)
from haptisym.writing.mathml import mathml as mathml
from haptisym.writing.schemas import json_schema as json_schema

__version__: str
