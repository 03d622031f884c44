"""Scene files: TOML tables to scenes, with every error naming file, key, value and rule.

A scene is given by the name of a shipped one, by the path of a file, or as a text. Numbers are read
as decimals, and so are exact. A file with several environments is a ``SceneFamily``: one display,
and everything that should be felt through it. One with ``[perceived]`` is a ``MeasuredScene``,
compared with its environment line by line. Begin with ``load_scene`` and ``parse_scene``.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from decimal import Decimal
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar

from sympy import Expr, Integer

import haptisym.effects
import haptisym.environments  # noqa: F401  both fill the catalogue
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import SceneError, meant, need, within
from haptisym.kernel.objects import Shown, titled
from haptisym.kernel.rings import c
from haptisym.model.catalogue import (
    EFFECTS,
    ENVIRONMENTS,
    Effect,
    Environment,
    Hand,
    Model,
    read_hand,
)
from haptisym.model.devices import read_device
from haptisym.model.distortion import Distortion
from haptisym.model.jnd import Threshold, read_threshold
from haptisym.model.measuredscene import MeasuredScene
from haptisym.model.parameters import free_name, read_confidence
from haptisym.model.quantities import Dimension, Number, Unit, number
from haptisym.model.scene import Scene, frequency, read_friction
from haptisym.model.shipped import SHIPPED, bench_names, family_names, scene_names, shipped_text

if TYPE_CHECKING:
    # Needs NumPy, which a scene of formulas does not load.
    from haptisym.model.measured import Measurement


MOST_ENVIRONMENTS = 100


@dataclass(frozen=True, repr=False)
class SceneFamily(Shown):
    """Scenes by the names of their environments, all with the same effects, band and threshold.

    ``scenes`` : at least one, in order. Valid by construction: SceneError where a scene has other
    effects, another band or another threshold than the first. A mapping: ``family["liver"]``,
    ``len(family)``, ``for name in family``.

    >>> from haptisym import effects, environments
    >>> lag = (effects.first_order_lag(20),)
    >>> soft, hard = (Scene(environments.kelvin_voigt(k, 2), lag) for k in (100, 1000))
    >>> family = SceneFamily({"soft": soft, "hard": hard})
    >>> list(family), family["hard"].environment.H
    (['soft', 'hard'], 2*s + 1000)
    """

    scenes: Mapping[str, Scene]
    title: str = ""
    source: str = ""

    def _line(self) -> str:
        return f"{titled(self.title)}: {', '.join(self.scenes)}"

    def __post_init__(self) -> None:
        need(
            "environments",
            self.scenes,
            Mapping,
            'give scenes by name, as {"soft": load_scene(...)}',
        )
        for name, scene in self.scenes.items():
            need(
                f"environments: {name}", scene, Scene, "give a scene, as load_scene(...) makes one"
            )
        if not 1 <= len(self.scenes) <= MOST_ENVIRONMENTS:
            raise SceneError(f"environments: give 1 to {MOST_ENVIRONMENTS}, not {len(self.scenes)}")
        for name, scene in self.scenes.items():
            if _display(scene) != _display(self.first):
                raise SceneError(
                    f'environments: "{name}" has other effects, another band or another JND: '
                    f"evaluate it alone"
                )

    def __getitem__(self, name: str) -> Scene:
        if name not in self.scenes:
            these = "these are" if len(self) > 1 else "there is only"
            raise SceneError(
                f'unknown environment "{name}": {meant(name, self)}{these} {self.listed()}'
            )
        return self.scenes[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.scenes)

    def __len__(self) -> int:
        return len(self.scenes)

    @property
    def first(self) -> Scene:
        """The first scene, whose effects, band and threshold are those of all."""
        return next(iter(self.scenes.values()))

    @property
    def band(self) -> tuple[Expr, Expr]:
        """Lowest and highest frequency, rad/s."""
        return self.first.band

    @property
    def frequency(self) -> Unit:
        """The unit of frequency in which pages print."""
        return self.first.frequency

    @property
    def threshold(self) -> Threshold:
        """The threshold of all scenes."""
        threshold: Threshold = self.first.threshold
        return threshold

    def at_proportion(self, end: Number) -> SceneFamily:
        """The family with its threshold at another proportion of right answers; SceneError where
        the threshold's own is not given."""
        return replace(
            self, scenes={name: scene.at_proportion(end) for name, scene in self.scenes.items()}
        )

    def asides(
        self, besides: Collection[str] = (), varied: Collection[str] | None = ()
    ) -> list[str]:
        """The notes to print with an answer for all scenes, each once, with the names of the scenes
        that it is about unless it is about all."""
        whose: dict[str, list[str]] = {}
        for name, scene in self.scenes.items():
            for note in scene.asides(besides, varied):
                whose.setdefault(note, []).append(name)
        return [
            x if len(names) == len(self.scenes) else f"{', '.join(names)}: {x}"
            for x, names in whose.items()
        ]

    def aside_keys(
        self, besides: Collection[str] = (), varied: Collection[str] | None = ()
    ) -> dict[str, Any]:
        """The notes as keys of a JSON document: ``confidence``, and ``nominal``, the ranges of each
        scene in which something varies."""
        nominal = {
            name: scene.aside_keys(besides, varied).get("nominal")
            for name, scene in self.scenes.items()
        }
        ranges = {name: of_scene for name, of_scene in nominal.items() if of_scene}
        keys = {"confidence": self.level and float(self.level), "nominal": ranges}
        return {key: x for key, x in keys.items() if x}

    @property
    def level(self) -> Expr | None:
        """The lowest confidence with which ranges of a scene were estimated; None where there are
        none."""
        return min((x.level for x in self.scenes.values() if x.level is not None), default=None)

    def listed(self) -> str:
        """The names of the environments in one line."""
        return ", ".join(f'"{name}"' for name in self)

    def only(self) -> Scene:
        """The one scene; SceneError where there are several, with how to choose."""
        if len(self) > 1:
            raise SceneError(
                f"this scene has {len(self)} environments ({self.listed()}): choose one with "
                f"--environment NAME "
                '(in Python: load_scene(..., environment="NAME")), or evaluate all of them '
                "together with "
                "haptisym evaluate (in Python: evaluate_all(load_scenes(...)))"
            )
        return self.first

    def ring(self) -> Ring:
        """One ring that holds the dynamics of all scenes, so that their functions can be compared
        exactly."""
        return common_ring(self.scenes.values())


def common_ring(scenes: Iterable[Scene]) -> Ring:
    """One ring that holds the dynamics of several scenes, and the symbol of a threshold."""
    entries = [entry for scene in scenes for entry in scene.distortion().chain.entries()]
    return Ring.of([c, *entries])


def _display(scene: Scene) -> tuple[object, ...]:
    """What the scenes of a family must share: effects, band and threshold."""
    # Effects by their matrices with values, as symbols differ where an environment has a parameter
    # of the same name. The matrix of a sampled loop holds its environment: of it only the values.
    effects = (
        (e.name, e.settings, tuple(p.value for p in e.parameters) if e.renders else e.matrix)
        for e in scene.effects
    )
    return tuple(effects), scene.band, scene.threshold


def named(scenes: Iterable[tuple[str, Scene]], title: str = "", source: str = "") -> SceneFamily:
    """A family of scenes under names of their own: the second "liver" becomes "liver-2"."""
    family: dict[str, Scene] = {}
    for name, scene in scenes:
        family[free_name(name, family, "-")] = replace(scene, title=title, source=source)
    return SceneFamily(family, title, source)


Table: TypeAlias = Mapping[str, Any]

MOST_EFFECTS = 100
_TABLES = (
    "title",
    "source",
    "environment",
    "environments",
    "rendered",
    "perceived",
    "effects",
    "device",
    "hand",
    "hands",
    "evaluation",
)
MEASURED = (
    "this scene is measured: only evaluate, compare and identify take it. All others need a model in "
    "[environment], and [[effects]] "
    "in place of [perceived]; haptisym identify fits one"
)
_APART = ("environments", "rendered", "effects", "device", "hand", "hands")
"""Tables that a scene with a measured response does not have."""
# The band of the paper, rad/s
_DEFAULT_BAND = (Integer(0), Integer(15))
_TOML_HINTS = {
    "Expected newline or end of document": (
        '; a value with a unit goes in quotes, as in k = "100 N/m"'
    ),
    "Invalid value": '; a value with a unit goes in quotes, as in k = "100 N/m"',
    "('effects',) twice": "; each effect begins with [[effects]]",
    "Cannot overwrite a value": "; each of several effects begins with [[effects]]",
    "Expected '=' after a key": "; a heading is in brackets, as [environment]",
    "('environment',) twice": "; several environments begin with [[environments]]",
}


_MEASURED_LINES = (
    'a table of lines, not a scene: name it in a scene, as file = "..." in [perceived]; '
    "haptisym identify fits a model to a "
    "response, haptisym jnd a curve to responses of a person"
)


def _is_table_of_lines(text: str) -> bool:
    """Whether a text that is no TOML begins as CSV does: with separators, and none of the signs
    of a line of TOML."""
    first = next((x for line in text.splitlines() if (x := line.partition("#")[0].strip())), "")
    return any(x in first for x in ",;\t") and not any(x in first for x in "=[{")


DEEPEST = 20
"""The most parts of a key with dots; the time that tomllib takes grows with the square of them."""
# Possessive quantifiers (*+) never give back what they took: on a string that does not end, the
# search does not try all shorter ones, and its time stays proportional to the length of the text.
_QUOTED = re.compile(
    r""""{3}(?:[^"\\]|\\.|"(?!""))*+(?:"{3,5})?"""
    r"""|'{3}(?:[^']|'(?!''))*+(?:'{3,5})?"""
    r"""|"(?:[^"\\\n]|\\[^\n])*+"?"""
    r"""|'[^'\n]*+'?|#[^\n]*+""",
    re.DOTALL,
)
"""A string of TOML, or a comment; one without its end goes to where that must have been, so that
nothing is read twice."""


def _deepest(text: str) -> int:
    """The most parts between dots of any word outside of strings: an upper bound for keys."""
    words = re.split(r"[\s,=\[\]{}]+", _QUOTED.sub("", text).replace(" ", "").replace("\t", ""))
    return 1 + max(x.count(".") for x in words)


def _toml(text: str) -> Table:
    """The tables of a TOML text, decimals exact; SceneError for what is no TOML, with a hint."""
    need("scene", text, str, "give the text of a scene file; load_scene reads a file")
    # Before parsing: for a key of many parts tomllib takes a time that grows with their square.
    if _deepest(text) > DEEPEST:
        raise SceneError(f"not a scene: a key has more than {DEEPEST} parts")
    # Some editors write a byte order mark, which TOML does not allow. Decimals, not floats: 0.1 is
    # then exactly 1/10.
    try:
        return tomllib.loads(text.removeprefix("\N{BYTE ORDER MARK}"), parse_float=Decimal)
    except tomllib.TOMLDecodeError as error:
        if _is_table_of_lines(text):
            raise SceneError(_MEASURED_LINES) from None
        hint = next((hint for words, hint in _TOML_HINTS.items() if words in str(error)), "")
        raise SceneError(f"not valid TOML: {error}{hint}") from None
    except RecursionError:
        raise SceneError("not valid TOML: nested too deeply") from None
    except ValueError as error:
        # Python refuses whole numbers with thousands of digits.
        raise SceneError(f"not valid TOML: {error}") from None


def read_scenes(text: str) -> SceneFamily:
    """The scenes of a TOML text, one for each of its environments. SceneError names key, value and
    rule."""
    table = _toml(text)
    if _is_measured(table):
        raise SceneError(MEASURED)
    return _formulas(table, text)


def read_any(text: str, folder: Path, *, files: bool = True) -> SceneFamily | MeasuredScene:
    """The scenes of a TOML text, or the one whose responses are measured, in files of that folder.

    ``files`` : whether files that a scene names may be read; SceneError for such a scene if not.
    """
    table = _toml(text)
    if not files and _is_measured(table):
        raise SceneError("file: names a file, and with --no-files none that a scene names is read")
    return _measured_scene(table, folder) if _is_measured(table) else _formulas(table, text)


def _is_measured(table: Table) -> bool:
    """Whether a scene has a measured response, perceived or as its environment."""
    environment = table.get("environment")
    return "perceived" in table or (isinstance(environment, Mapping) and "file" in environment)


def _formulas(table: Table, text: str) -> SceneFamily:
    """The scenes of formulas that tables describe."""
    _only(table, _TABLES, "")
    evaluation = _table(table.get("evaluation", {}), "evaluation")
    _only(evaluation, ("band", "jnd", "confidence", "friction"), "evaluation")
    effects = tuple(_effects(table.get("effects", [])))
    # A device's mass and damping are at the hand: the last of the effects.
    if "device" in table:
        effects = *effects, *read_device(_table(table["device"], "device"))
    band = _band(evaluation["band"]) if "band" in evaluation else _DEFAULT_BAND
    with within("evaluation: jnd"):
        threshold = read_threshold(evaluation["jnd"]) if "jnd" in evaluation else Threshold()
    # Everything that is not an environment is read once, and shared by all scenes.
    title, source = _text(table, "title"), _text(table, "source")
    environments = _environments(table) if "environments" in table else [_one_environment(table)]
    hands = tuple(_hands(table))
    shared: dict[str, Any] = {"hands": hands, "text": text}
    if "friction" in evaluation:
        with within("evaluation"):
            shared["friction"] = read_friction(evaluation["friction"])
    if "confidence" in evaluation:
        shared["confidence"] = read_confidence("evaluation: confidence", evaluation["confidence"])
    scenes = (
        (name, Scene(environment, effects, band, threshold, rendered, **shared))
        for name, environment, rendered in environments
    )
    return named(scenes, title, source)


def _one_environment(table: Table) -> tuple[str, Environment, Environment | None]:
    """Name, environment and what is rendered for it, of a scene with one."""
    if "environment" not in table:
        raise SceneError(
            '[environment] is missing: add it, with a model, as model = "mass-spring-damper"'
        )
    if isinstance(table["environment"], list):
        raise SceneError("environment: write [environment] for one, [[environments]] for several")
    rendered = _environment(table["rendered"], "rendered") if "rendered" in table else None
    return "environment", _environment(table["environment"], "environment"), rendered


def _environments(table: Table) -> Iterable[tuple[str, Environment, Environment | None]]:
    """Name, environment and what is rendered for it, of each of several."""
    given = table["environments"]
    if not isinstance(given, list) or not given:
        raise SceneError("environments: write [[environments]] once for each environment")
    for key in ("environment", "rendered"):
        if key in table:
            raise SceneError(
                f"{key}: give either [{key}] or [[environments]], each with its own {key}"
            )
    for position, one in enumerate(given, 1):
        keys = dict(_table(one, f"environments[{position}]"))
        name, rendered = keys.pop("name", None), keys.pop("rendered", None)
        name = str(keys.get("model", position)) if name is None else name
        place = f'environments[{position}] "{str(name)[:60]}"'
        if not isinstance(name, str) or not name:
            raise SceneError(f'environments[{position}]: name: "{name}": give a name, as "mine"')
        # Tied here, where the error can name the environment that lacks what is referred to.
        environment = _environment(keys, place)
        if rendered is not None:
            rendered = _rendered(rendered, environment, f"{place}: rendered")
        yield name, environment, rendered


def _rendered(given: Any, environment: Environment, place: str) -> Environment:
    """What is rendered for an environment, its references resolved to that environment's values."""
    with within(place):
        return _environment(given, place).tied_to(environment)


def _environment(given: Any, place: str) -> Environment:
    """The environment that a table describes; ``place`` is what errors call it."""
    model, parameters = _model(given, ENVIRONMENTS, place)
    return _built(model, parameters, place)  # type: ignore[no-any-return]


def _effects(given: Any) -> Iterable[Effect]:
    """The effects that a list of tables describes, in its order."""
    if not isinstance(given, list):
        raise SceneError("effects: write [[effects]] once for each effect")
    if len(given) > MOST_EFFECTS:
        raise SceneError(f"effects: at most {MOST_EFFECTS}, not {len(given)}")
    for position, table in enumerate(given, 1):
        place = f"effects[{position}]"
        model, parameters = _model(table, EFFECTS, place)
        if not isinstance(parameters.get("name", ""), str) or parameters.get("name") == "":
            raise SceneError(f'{place}: name: "{parameters["name"]}": give a name, as "mine"')
        yield _built(model, parameters, f'{place} "{parameters.get("name", model.name)}"')


def _hands(table: Table) -> Iterable[Hand]:
    """The hands of a scene: one in [hand], or several in [[hands]]."""
    if "hand" in table and "hands" in table:
        raise SceneError("hand: give either [hand] or [[hands]], each with a name")
    if isinstance(table.get("hand"), list):
        raise SceneError("hand: write [hand] for one, [[hands]] for several")
    if not isinstance(table.get("hands", []), list):
        raise SceneError("hands: write [[hands]] once for each hand")
    rows = [("hand", table["hand"])] if "hand" in table else []
    rows += [(f"hands[{i}]", x) for i, x in enumerate(table.get("hands", []), 1)]
    for place, given in rows:
        keys = dict(_table(given, place))
        name = keys.pop("name", "hand" if place == "hand" else None)
        if not isinstance(name, str) or not name:
            raise SceneError(f"{place}: name is missing: each of several hands needs one")
        with within(place):
            yield read_hand(name, keys)


_COMMON = {
    "voi": "kelvin-voigt",
    "spring": "mass-spring-damper",
    "delay": "delay",
    "latency": "delay",
    "zoh": "zero-order-hold",
    "hold": "zero-order-hold",
    "sampl": "sampled-loop",
    "control": "sampled-loop",
    "discrete": "sampled-loop",
    "mass": "shunt",
    "inertia": "shunt",
    "damp": "shunt",
    "device": "shunt",
    "friction": "coulomb-friction",
    "quanti": "encoder",
    "resolution": "encoder",
    "display": "admittance-display",
    "hyster": "backlash",
    "play": "backlash",
    "slack": "backlash",
    "dead": "dead-zone",
    "satur": "saturation",
    "limit": "saturation",
    "clip": "saturation",
    "gear": "two-port",
    "lever": "two-port",
    "transmission": "two-port",
    "pid": "series expression",
    "low": "second-order-lowpass",
    "lag": "first-order-lag",
    "motor": "first-order-lag",
    "actuator": "first-order-lag",
    "shaft": "compliance",
    "cable": "compliance",
    "tendon": "compliance",
    "belt": "compliance",
    "coupling": "compliance",
    "transfer": "series",
}
"""Words for a model that are not its name; the first that an unknown name contains is meant. Of two
models one is an effect, the other an environment."""


def _model(given: Any, catalogue: Mapping[str, Model], place: str) -> tuple[Model, dict[str, Any]]:
    """The model that a table names, and the table's other keys."""
    table = dict(_table(given, place))
    name = table.pop("model", None)
    if name is None:
        raise SceneError(f"{place}: model is missing: valid are {', '.join(catalogue)}")
    if not isinstance(name, str) or name not in catalogue:
        # A word that says what is meant goes before a similar spelling.
        words = (models for word, models in _COMMON.items() if word in str(name).lower())
        likely = (x for models in words for x in models.split() if x in catalogue)
        hint = next((f'did you mean "{x}"? ' for x in likely), "") or meant(str(name), catalogue)
        raise SceneError(
            f'{place}: unknown model "{str(name)[:60]}": {hint}valid are {", ".join(catalogue)}'
        )
    return catalogue[name], table


def _built(model: Model, parameters: Table, place: str) -> Any:
    """The environment or effect of a model with these parameters."""
    if "parameters" in parameters:
        _table(parameters["parameters"], f"{place}: parameters")
    with within(place):
        return model.build(**parameters)


def _band(given: Any) -> tuple[Any, Any]:
    """The ends of a band, checked, as they are written: the scene prints in their unit."""
    if not isinstance(given, list) or len(given) != 2:
        raise SceneError(
            f'evaluation: band: "{given}": give two frequencies, as ["0 rad/s", "15 rad/s"]'
        )
    for x in given:
        frequency("evaluation: band", x)
    low, high = given
    return low, high


def _measured_scene(table: Table, folder: Path) -> MeasuredScene:
    """The scene with measured responses that tables describe, their files in that folder."""
    for key in _APART:
        if key in table:
            raise SceneError(
                f"{key}: a measured scene has [environment] and [perceived] only: leave it out"
            )
    _only(table, _TABLES, "")
    for key in ("environment", "perceived"):
        if key not in table:
            raise SceneError(
                f"[{key}] is missing: a measured scene needs [environment] and [perceived]"
            )
    felt = _table(table["environment"], "environment")
    environment = (
        _measurement(felt, "environment", folder)
        if "file" in felt
        else _environment(felt, "environment")
    )
    perceived = _measurement(_table(table["perceived"], "perceived"), "perceived", folder)
    evaluation = _table(table.get("evaluation", {}), "evaluation")
    _only(evaluation, ("band", "jnd"), "evaluation")
    band = _band(evaluation["band"]) if "band" in evaluation else None
    with within("evaluation: jnd"):
        threshold = read_threshold(evaluation["jnd"]) if "jnd" in evaluation else Threshold()
    return MeasuredScene(
        environment, perceived, band, threshold, _text(table, "title"), _text(table, "source")
    )


def _measurement(table: Table, place: str, folder: Path) -> Measurement:
    """The measured response that a table names by its file."""
    from haptisym.model.measured import read_slope
    from haptisym.model.responsefile import LAYOUT, RECORDS, read_file

    with within(place):
        _only(table, ("file", "minus", "averages", "confidence", "slope", *RECORDS, *LAYOUT), "")
        for key in ("file", *({"minus"} & {*table})):
            name = table.get(key)
            if not isinstance(name, str) or not name or "\0" in name:
                raise SceneError(f"{key}: give the name of a file in the folder of the scene")
        averages, confidence, overlap = (
            _float(table, key) for key in ("averages", "confidence", "overlap")
        )
        settings = {key: table[key] for key in (*RECORDS, *LAYOUT) if key in table}
        if overlap is not None:
            settings["overlap"] = overlap
        if "minus" in table:
            settings["minus"] = folder / table["minus"]
        slope = read_slope(table["slope"]) if "slope" in table else None
        response = read_file(folder / table["file"], averages, confidence, settings)
        return response if slope is None else replace(response, slope=slope)


def _float(table: Table, key: str) -> float | None:
    """A dimensionless number of a table; None where it is not there."""
    if key not in table:
        return None
    with within(key):
        return float(number(table[key], Dimension.RATIO).value)


def _text(table: Table, key: str) -> str:
    """A string of a table; empty where it is not there."""
    value = table.get(key, "")
    if not isinstance(value, str):
        raise SceneError(f'{key}: "{value}" must be a string')
    return value


def _table(given: Any, place: str) -> Table:
    """Return what is given; SceneError unless it is a table."""
    if not isinstance(given, Mapping):
        raise SceneError(f'{place}: "{str(given)[:60]}" must be a table of keys and values')
    return given


def _only(table: Table, valid: tuple[str, ...], place: str) -> None:
    """SceneError for a key of a table that is not among the valid ones."""
    for key in table:
        if key not in valid:
            where = f"{place}: " if place else ""
            raise SceneError(
                f'{where}unknown key "{key[:60]}": {meant(key, valid)}valid are {", ".join(valid)}'
            )


_T = TypeVar("_T", SceneFamily, SceneFamily | MeasuredScene)

# Bytes; a scene is a page of text.
LARGEST_FILE = 1_000_000


def load_scene(scene: str | Path, environment: str | None = None) -> Scene:
    """The scene of that name (one that the package ships) or in that file. SceneError if it is
    wrong, with the reason.

    ``environment`` : which of several environments; without it a scene that has several is an error
    that lists them.

    >>> load_scene("fu2019").environment.H
    9*s**2/5 + 15*s + 100
    >>> load_scene("palpation-device", "muscle").environment.H
    2*s + 290
    """
    return _chosen(*scene_text(scene), environment)


def load_scenes(scene: str | Path, environments: Iterable[str | Path] = ()) -> SceneFamily:
    """The scenes in that file (or of that name), one for each of its environments: one or several.

    ``environments`` : scenes whose environments (each with what is rendered for it) take the place
    of the scene's own; named after their files. SceneError if one is wrong, with the reason.

    >>> list(load_scenes("palpation-device")), list(load_scenes("fu2019", ["fu2019", "helicopter-cyclic"]))
    (['fat', 'muscle', 'liver', 'tumour'], ['fu2019', 'helicopter-cyclic'])
    """
    text, name = scene_text(scene)
    return felt_through(parse_scenes(text, name), name, environments)


def felt_through(own: SceneFamily, name: str, environments: Iterable[str | Path]) -> SceneFamily:
    """A family's display with the environments of other scenes in place of its own; the family
    itself if there are none. ``name`` is what error messages call the file."""
    others = [(label, x) for place in environments for label, x in _labelled(place)]
    if not others:
        return own
    with within(name):
        return named(
            ((label, _with_environment(own.first, label, x)) for label, x in others),
            own.title,
            own.source,
        )


def open_scenes(
    scene: str | Path, *, files: bool = True
) -> tuple[SceneFamily | MeasuredScene, str]:
    """The scenes of formulas, or the measured one, of that name or in that file; and what error
    messages call it.

    ``files`` : whether files that the scene names are read; without them, a scene may come from
    anybody.
    """
    text, name = scene_text(scene)
    # The files of a shipped measured scene are shipped too: they are read in any case.
    is_shipped = str(scene) in bench_names()
    folder = SHIPPED / "benches" if is_shipped else Path(str(scene)).parent
    return _parsed(name, lambda: read_any(text, folder, files=files or is_shipped)), name


def as_scene(given: Scene | str | Path) -> Scene:
    """A scene as it is, or the one of that name or in that file: what every question about a scene
    begins with.

    >>> as_scene("fu2019").environment.H
    9*s**2/5 + 15*s + 100
    >>> as_scene(load_scene("fu2019").environment)
    Traceback (most recent call last):
      ...
    haptisym.kernel.errors.SceneError: Environment is not a scene: make one with Scene(environment, effects, band, threshold)
    """
    return _without_roots(given) if isinstance(given, Scene) else load_scene(given)


def _without_roots(scene: Scene) -> Scene:
    """Return the scene; SceneError where it holds a root as sqrt(k*m), for which there are closed
    forms but no certified numbers."""
    for root in scene.chain.ring.roots.values():
        raise SceneError(
            f"{root}: in a scene only s has fractional powers, as in 0.17*s^0.5: give it as "
            f"a parameter"
        )
    return scene


def as_family(given: SceneFamily | Scene | str | Path) -> SceneFamily:
    """A family as it is, or the one of that name or in that file; a scene is a family of one."""
    if isinstance(given, SceneFamily):
        return given
    if isinstance(given, Scene):
        given = _without_roots(given)
        return named([("environment", given)], given.title, given.source)
    return load_scenes(given)


def _with_environment(display: Scene, label: str, other: Scene) -> Scene:
    """The display of one scene with the environment of another."""
    with within(label):
        return replace(display, environment=other.environment, rendered=other.rendered)


def _labelled(place: str | Path) -> list[tuple[str, Scene]]:
    """The scenes of a file, each by the name of its environment; an only one by the name of the
    file."""
    text, name = scene_text(place)
    family = parse_scenes(text, name)
    if len(family) == 1:
        return [(name.removesuffix(".toml"), family.first)]
    return list(family.scenes.items())


def parse_scene(text: str, name: str = "scene", environment: str | None = None) -> Scene:
    """The scene that a TOML text describes; ``name`` is what error messages call it,
    ``environment`` one of several.

    >>> parse_scene('environment = { model = "maxwell", k = 100, b = "5 N*s/m" }').band
    (0, 15)
    """
    return _chosen(text, name, environment)


def parse_scenes(text: str, name: str = "scene") -> SceneFamily:
    """The scenes that a TOML text describes, one for each of its environments, by their names;
    exact numbers.

    ``name`` : what error messages call the text. SceneError names table, key, value and rule of
    what is wrong.

    >>> text = 'environments = [{ name = "soft", model = "kelvin-voigt", k = "1 N/mm", b = 2 }]'
    >>> parse_scenes(text)["soft"].environment.H
    2*s + 1000
    """
    return _parsed(name, lambda: read_scenes(text))


def _parsed(name: str, read: Callable[[], _T]) -> _T:
    """What ``read`` returns, with errors naming the file, to which what they propose is added; the
    closed forms of scenes are made at once."""
    try:
        scenes = read()
        # What is wrong with the dynamics as a whole is wrong with this file: it must show here.
        for scene in () if isinstance(scenes, MeasuredScene) else scenes.scenes.values():
            _ = scene.closed
    except SceneError as error:
        raise error.within(name).written() from None
    return scenes


def _chosen(text: str, name: str, environment: str | None) -> Scene:
    """The only scene of a text, or the one with that environment."""
    return chosen(parse_scenes(text, name), name, environment)


def chosen(family: SceneFamily, name: str, environment: str | None) -> Scene:
    """One environment of several, or the only one; ``name`` is what error messages call the
    file."""
    with within(name):
        if environment is None:
            return family.only()
        scene = family[environment]
    return replace(scene, title=f"{scene.title or 'Untitled scene'}: {environment}")


def scene_text(scene: str | Path) -> tuple[str, str]:
    """The text of a shipped scene or of a file, and what error messages call it. A file is read
    once, as pipes can only be."""
    # A name or a path has no line break: this is the text of a scene.
    if not isinstance(scene, str | Path) or "\n" in str(scene):
        raise SceneError(_instead(scene))
    name = str(scene)
    if (text := shipped_text(name)) is not None:
        return text, name
    path = Path(name)
    return _text_of(path), path.name if path.is_file() else name


def _instead(given: object) -> str:
    """The error for something that is neither the name of a scene nor a path: what to do
    with it."""
    if isinstance(given, str):
        return "this is the text of a scene: read it with parse_scene(text)"
    if isinstance(given, Scene):
        return "this is already a Scene: pass it to the command"
    if isinstance(given, MeasuredScene):
        return MEASURED
    if isinstance(given, SceneFamily):
        both = "evaluate_all(scenes) or answer_each(scenes, hs.stability)"
        advice = f'choose one, as in scenes["{next(iter(given))}"], or ask for all with {both}'
    elif isinstance(given, Distortion):
        advice = (
            "it has no band and no threshold; make one with Scene(environment, effects, band, "
            "threshold)"
        )
    elif isinstance(given, Environment | Effect):
        advice = "make one with Scene(environment, effects, band, threshold)"
    elif isinstance(getattr(given, "scene", None), Scene):
        advice = "its attribute scene is one"
    else:
        advice = "give a Scene, the name of one that the package ships, or the path of a scene file"
    return f"{type(given).__name__} is not a scene: {advice}"


def _text_of(path: Path) -> str:
    """The text of a file in UTF-8; SceneError where it cannot be read, or is too large."""
    # One byte more than allowed: of a pipe or a device nothing else tells how much there is.
    try:
        with path.open("rb") as file:
            data = file.read(LARGEST_FILE + 1)
    except (OSError, ValueError) as error:
        raise SceneError(f"{path}: {_no_such_scene(path, error)}") from None
    if len(data) > LARGEST_FILE:
        raise SceneError(f"{path}: a scene has at most {LARGEST_FILE} bytes")
    # The byte order marks of UTF-16.
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise SceneError(f"{path}: the file is written in UTF-16: save it as UTF-8")
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError:
        raise SceneError(f"{path}: not a text file (UTF-8)") from None


def _no_such_scene(path: Path, error: Exception) -> str:
    """The error for a path that cannot be read, with the likeliest scene that is meant."""
    from difflib import get_close_matches  # where something went wrong

    # First a file of the same name with .toml, then a similar one, then a similar shipped scene.
    known = scene_names() + family_names()
    beside = [y for x in (".toml", path.suffix) if x for y in sorted(path.parent.glob(f"*{x}"))]
    # By their names without endings, which would make all of them similar.
    files = {x.stem: x.name for x in reversed(beside) if x.name != path.name}
    near = get_close_matches(path.stem, files, n=1)
    hint = f'did you mean "{files[near[0]]}"?' if near else meant(path.stem, known).rstrip()
    reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
    # What ends like a file is meant as one: of shipped scenes none but a similar one helps.
    if path.suffix:
        what = "no such file" if isinstance(error, FileNotFoundError) else reason.lower()
        return f"{what}: {hint}" if hint else what
    hint = hint or f"the package ships {', '.join(known)}"
    return f"no such scene ({reason.lower()}): {hint}"
