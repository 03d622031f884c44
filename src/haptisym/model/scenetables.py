"""What a scene file says: TOML tables to scenes, with every error naming key, value and rule."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import replace
from decimal import Decimal
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from sympy import Integer

from haptisym.kernel.errors import SceneError, meant, need
from haptisym.model.catalogue import EFFECTS, ENVIRONMENTS, Effect, Environment, Model
from haptisym.model.family import SceneFamily, named
from haptisym.model.friction import read_friction
from haptisym.model.hand import Hand, hand
from haptisym.model.jnd import Threshold
from haptisym.model.jndtables import read_threshold
from haptisym.model.measuredscene import MeasuredScene
from haptisym.model.quantities import Dimension, number
from haptisym.model.ranges import read_confidence
from haptisym.model.scene import Scene, frequency

if TYPE_CHECKING:
    from haptisym.model.measured import Measurement  # needs NumPy, which a scene of formulas does not load

Table: TypeAlias = Mapping[str, Any]

MOST_EFFECTS = 100
_TABLES = (
    "title", "source", "environment", "environments", "rendered", "perceived", "effects", "hand", "hands", "evaluation",
)  # fmt: skip
MEASURED = (
    "this scene is measured, line by line, and evaluate alone judges it; every other question needs formulas: a model in "
    "[environment], and [[effects]] in place of [perceived]"
)
_APART = ("environments", "rendered", "effects", "hand", "hands")
"""Tables that a scene with a measured response does not have."""
_DEFAULT_BAND = (Integer(0), Integer(15))  # rad/s, the band of the paper
_TOML_HINTS = {
    "Expected newline or end of document": '; a value with a unit goes in quotes, as in k = "100 N/m"',
    "Invalid value": '; a value with a unit goes in quotes, as in k = "100 N/m"',
    "('effects',) twice": "; each effect begins with [[effects]]",
}


_MEASURED_LINES = (
    "a table of lines and no scene: a scene (TOML) names it, as file = ... under [perceived]; haptisym identify fits a model to "
    "a response, and haptisym jnd a curve to answers"
)


def _is_table_of_lines(text: str) -> bool:
    """Whether it begins as CSV does: columns, and nothing that TOML begins with."""
    first = next((x for line in text.splitlines() if (x := line.partition("#")[0].strip())), "")
    return any(x in first for x in ",;\t") and not any(x in first for x in "=[{")


def _toml(text: str) -> Table:
    need("scene", text, str, "give the text of a scene file; load_scene reads a file")
    try:
        return tomllib.loads(text.removeprefix("\N{BYTE ORDER MARK}"), parse_float=Decimal)
    except tomllib.TOMLDecodeError as error:
        if _is_table_of_lines(text):
            raise SceneError(_MEASURED_LINES) from None
        hint = next((hint for words, hint in _TOML_HINTS.items() if words in str(error)), "")
        raise SceneError(f"not valid TOML: {error}{hint}") from None
    except RecursionError:
        raise SceneError("not valid TOML: nested too deeply") from None
    except ValueError as error:  # a whole number with thousands of digits
        raise SceneError(f"not valid TOML: {error}") from None


def read_scenes(text: str) -> SceneFamily:
    """The scenes of a TOML text, one for each of its environments. SceneError names key, value and rule."""
    table = _toml(text)
    if _is_measured(table):
        raise SceneError(MEASURED)
    return _formulas(table, text)


def read_any(text: str, folder: Path) -> SceneFamily | MeasuredScene:
    """The same; or a scene whose responses are measured, and lie in files of that folder."""
    table = _toml(text)
    return _measured_scene(table, folder) if _is_measured(table) else _formulas(table, text)


def _is_measured(table: Table) -> bool:
    own = table.get("environment")
    return "perceived" in table or (isinstance(own, Mapping) and "file" in own)


def _formulas(table: Table, text: str) -> SceneFamily:
    _only(table, _TABLES, "")
    evaluation = _table(table.get("evaluation", {}), "evaluation")
    _only(evaluation, ("band", "jnd", "confidence", "friction"), "evaluation")
    effects = tuple(_effects(table.get("effects", [])))
    band = _band(evaluation["band"]) if "band" in evaluation else _DEFAULT_BAND
    threshold = _threshold(evaluation["jnd"]) if "jnd" in evaluation else Threshold()
    title, source = _text(table, "title"), _text(table, "source")
    rows = _environments(table) if "environments" in table else [_one_environment(table)]
    hands = tuple(_hands(table))
    shared: dict[str, Any] = {"hands": hands, "text": text}
    if "friction" in evaluation:
        shared["friction"] = _read("evaluation", read_friction, evaluation["friction"])
    if "confidence" in evaluation:
        shared["confidence"] = read_confidence("evaluation: confidence", evaluation["confidence"])
    scenes = ((name, Scene(own, effects, band, threshold, rendered, **shared)) for name, own, rendered in rows)
    return named(scenes, title, source)


def _read(place: str, reader: Any, given: Any) -> Any:
    try:
        return reader(given)
    except SceneError as error:
        raise error.within(place) from None


def _one_environment(table: Table) -> tuple[str, Environment, Environment | None]:
    if "environment" not in table:
        raise SceneError("[environment] is missing: a scene needs something that should be felt")
    if isinstance(table["environment"], list):
        raise SceneError("environment: one is written [environment]; several are written [[environments]], with an s")
    rendered = _environment(table["rendered"], "rendered") if "rendered" in table else None
    return "environment", _environment(table["environment"], "environment"), rendered


def _environments(table: Table) -> Iterable[tuple[str, Environment, Environment | None]]:
    """Name, environment and what is rendered for it, of each of several."""
    given = table["environments"]
    if not isinstance(given, list) or not given:
        raise SceneError("environments: must be written [[environments]], once for each environment")
    for key in ("environment", "rendered"):
        if key in table:
            raise SceneError(f"{key}: give either [{key}] or [[environments]], each with its own {key}")
    for position, one in enumerate(given, 1):
        own = dict(_table(one, f"environments[{position}]"))
        name, rendered = own.pop("name", None), own.pop("rendered", None)
        name = str(own.get("model", position)) if name is None else name
        place = f'environments[{position}] "{str(name)[:60]}"'
        if not isinstance(name, str) or not name:
            raise SceneError(f'environments[{position}]: name: "{name}" must be a string that is not empty')
        environment = _environment(own, place)
        yield name, environment, None if rendered is None else _rendered(rendered, environment, f"{place}: rendered")


def _rendered(given: Any, environment: Environment, place: str) -> Environment:
    """What is rendered for an environment; its references are to that environment's values."""
    try:
        return _environment(given, place).tied_to(environment)
    except SceneError as error:
        raise error.within(place) from None


def _environment(given: Any, place: str) -> Environment:
    model, parameters = _model(given, ENVIRONMENTS, place)
    return _built(model, parameters, place)  # type: ignore[no-any-return]


def _effects(given: Any) -> Iterable[Effect]:
    if not isinstance(given, list):
        raise SceneError("effects: must be written [[effects]], once for each effect")
    if len(given) > MOST_EFFECTS:
        raise SceneError(f"effects: a scene may have at most {MOST_EFFECTS} effects, this one has {len(given)}")
    for position, table in enumerate(given, 1):
        place = f"effects[{position}]"
        model, parameters = _model(table, EFFECTS, place)
        if not isinstance(parameters.get("name", ""), str) or parameters.get("name") == "":
            raise SceneError(f'{place}: name: "{parameters["name"]}" must be a string that is not empty')
        yield _built(model, parameters, f'{place} "{parameters.get("name", model.name)}"')


def _hands(table: Table) -> Iterable[Hand]:
    if "hand" in table and "hands" in table:
        raise SceneError("hand: give either [hand] or [[hands]], each with a name")
    if isinstance(table.get("hand"), list):
        raise SceneError("hand: one is written [hand]; several are written [[hands]], with an s")
    if not isinstance(table.get("hands", []), list):
        raise SceneError("hands: must be written [[hands]], once for each hand")
    rows = [("hand", table["hand"])] if "hand" in table else []
    rows += [(f"hands[{i}]", x) for i, x in enumerate(table.get("hands", []), 1)]
    for place, given in rows:
        own = dict(_table(given, place))
        name = own.pop("name", "hand" if place == "hand" else None)
        if not isinstance(name, str) or not name:
            raise SceneError(f"{place}: name: each of several hands needs one, a string that is not empty")
        try:
            yield hand(name, own)
        except SceneError as error:
            raise error.within(place) from None


def _model(given: Any, catalogue: Mapping[str, Model], place: str) -> tuple[Model, dict[str, Any]]:
    table = dict(_table(given, place))
    name = table.pop("model", None)
    if name is None:
        raise SceneError(f"{place}: model is missing: valid are {', '.join(catalogue)}")
    if not isinstance(name, str) or name not in catalogue:
        hint = meant(str(name), catalogue)
        raise SceneError(f'{place}: unknown model "{str(name)[:60]}": {hint}valid are {", ".join(catalogue)}')
    return catalogue[name], table


def _built(model: Model, parameters: Table, place: str) -> Any:
    if "parameters" in parameters:
        _table(parameters["parameters"], f"{place}: parameters")
    try:
        return model.build(**parameters)
    except SceneError as error:
        raise error.within(place) from None


def _band(given: Any) -> tuple[Any, Any]:
    if not isinstance(given, list) or len(given) != 2:
        raise SceneError(
            f'evaluation: band: "{given}" must be a list of two frequencies, as in ["0 rad/s", "15 rad/s"]'
        )
    for x in given:
        frequency("evaluation: band", x)
    low, high = given  # as they are written, for what may be said about them
    return low, high


def _measured_scene(table: Table, folder: Path) -> MeasuredScene:
    for key in _APART:
        if key in table:
            raise SceneError(
                f"{key}: does not go with what is measured, which is [environment] and [perceived]: leave it out"
            )
    _only(table, _TABLES, "")
    for key in ("environment", "perceived"):
        if key not in table:
            raise SceneError(f"[{key}] is missing: what is felt is compared, line by line, with what should be felt")
    own = _table(table["environment"], "environment")
    environment = _measurement(own, "environment", folder) if "file" in own else _environment(own, "environment")
    perceived = _measurement(_table(table["perceived"], "perceived"), "perceived", folder)
    evaluation = _table(table.get("evaluation", {}), "evaluation")
    _only(evaluation, ("band", "jnd"), "evaluation")
    band = _band(evaluation["band"]) if "band" in evaluation else None
    threshold = _threshold(evaluation["jnd"]) if "jnd" in evaluation else Threshold()
    return MeasuredScene(environment, perceived, band, threshold, _text(table, "title"), _text(table, "source"))


def _measurement(table: Table, place: str, folder: Path) -> Measurement:
    from haptisym.model.measured import CONFIDENCE
    from haptisym.model.responsefile import RECORDS, read_file
    from haptisym.model.slope import read_slope

    try:
        _only(table, ("file", "averages", "confidence", "slope", *RECORDS), "")
        name = table.get("file")
        if not isinstance(name, str) or not name or "\0" in name:
            raise SceneError("file: give the name of a CSV file beside the scene")
        averages, confidence, overlap = (_float(table, key) for key in ("averages", "confidence", "overlap"))
        settings = {key: table[key] for key in RECORDS if key in table}
        if overlap is not None:
            settings["overlap"] = overlap
        slope = read_slope(table["slope"]) if "slope" in table else None
        found = read_file(folder / name, averages, CONFIDENCE if confidence is None else confidence, settings)
        return found if slope is None else replace(found, slope=slope)
    except SceneError as error:
        raise error.within(place) from None


def _float(table: Table, key: str) -> float | None:
    if key not in table:
        return None
    try:
        return float(number(table[key], Dimension.RATIO).value)
    except SceneError as error:
        raise error.within(key) from None


def _threshold(given: Any) -> Threshold:
    try:
        return read_threshold(given)
    except SceneError as error:
        raise error.within("evaluation: jnd") from None


def _text(table: Table, key: str) -> str:
    value = table.get(key, "")
    if not isinstance(value, str):
        raise SceneError(f'{key}: "{value}" must be a string')
    return value


def _table(given: Any, place: str) -> Table:
    if not isinstance(given, Mapping):
        raise SceneError(f'{place}: "{str(given)[:60]}" must be a table of keys and values')
    return given


def _only(table: Table, valid: tuple[str, ...], place: str) -> None:
    for key in table:
        if key not in valid:
            where = f"{place}: " if place else ""
            raise SceneError(f'{where}unknown key "{key[:60]}": {meant(key, valid)}valid are {", ".join(valid)}')
