"""Scene files: TOML text to a ``Scene``, with every error naming file, key, value and rule."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Mapping
from decimal import Decimal
from difflib import get_close_matches
from importlib.resources import files
from pathlib import Path
from typing import Any, TypeAlias

from sympy import Expr, Integer

from .catalogue import EFFECTS, ENVIRONMENTS, Effect, Environment, Model
from .errors import SceneError
from .jnd import Threshold
from .scene import Scene, frequency

Table: TypeAlias = Mapping[str, Any]

LARGEST_FILE = 1_000_000  # bytes; a scene is a page of text
MOST_EFFECTS = 100
_DEFAULT_BAND = (Integer(0), Integer(15))  # rad/s, the band of the paper


def scene_names() -> tuple[str, ...]:
    """The names of the scenes that the package ships.

    >>> "fu2019" in scene_names()
    True
    """
    folder = files("haptisym") / "scenes"
    return tuple(sorted(entry.name.removesuffix(".toml") for entry in folder.iterdir() if entry.name.endswith(".toml")))


def load_scene(scene: str | Path) -> Scene:
    """The scene of that name (one that the package ships) or in that file. SceneError says what is wrong with it.

    >>> load_scene("fu2019").environment.H
    9*s**2/5 + 15*s + 100
    """
    name = str(scene)
    if name in scene_names():
        return parse_scene((files("haptisym") / "scenes" / f"{name}.toml").read_text(encoding="utf-8"), name)
    return parse_scene(_read(Path(name)), Path(name).name)


def parse_scene(text: str, name: str = "scene") -> Scene:
    """The scene that a TOML text describes; ``name`` is what error messages call it.

    >>> parse_scene('environment = { model = "maxwell", k = 100, b = "5 N*s/m" }').band
    (0, 15)
    """
    try:
        scene = _scene(_toml(text))
        scene.distortion()  # what is wrong with the dynamics as a whole is wrong with this file
    except SceneError as error:
        raise error.within(name) from None
    return scene


def _read(path: Path) -> str:
    try:
        if path.is_file() and path.stat().st_size > LARGEST_FILE:
            raise SceneError(
                f"{path}: the file has {path.stat().st_size} bytes; a scene may have at most {LARGEST_FILE}"
            )
        return path.read_text(encoding="utf-8")
    except UnicodeDecodeError:
        raise SceneError(f"{path}: not a text file (UTF-8)") from None
    except (OSError, ValueError) as error:
        raise SceneError(f"{path}: {_no_such_scene(path, error)}") from None


def _no_such_scene(path: Path, error: Exception) -> str:
    known = scene_names()
    close = get_close_matches(path.name.removesuffix(".toml"), known, n=1)
    hint = f'did you mean "{close[0]}"?' if close else f"the package ships {', '.join(known)}"
    reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
    return f"neither a scene file ({reason.lower()}) nor a scene of the package; {hint}"


def _toml(text: str) -> Table:
    try:
        return tomllib.loads(text, parse_float=Decimal)
    except tomllib.TOMLDecodeError as error:
        raise SceneError(f"not valid TOML: {error}") from None
    except RecursionError:
        raise SceneError("not valid TOML: nested too deeply") from None
    except ValueError as error:  # a whole number with thousands of digits
        raise SceneError(f"not valid TOML: {error}") from None


def _scene(table: Table) -> Scene:
    _only(table, ("title", "source", "environment", "rendered", "effects", "evaluation"), "")
    if "environment" not in table:
        raise SceneError("[environment] is missing: a scene needs something that should be felt")
    evaluation = _table(table.get("evaluation", {}), "evaluation")
    _only(evaluation, ("band", "jnd"), "evaluation")
    return Scene(
        environment=_environment(table["environment"], "environment"),
        effects=tuple(_effects(table.get("effects", []))),
        band=_band(evaluation["band"]) if "band" in evaluation else _DEFAULT_BAND,
        threshold=_threshold(evaluation["jnd"]) if "jnd" in evaluation else Threshold(),
        rendered=_environment(table["rendered"], "rendered") if "rendered" in table else None,
        title=_text(table, "title"),
        source=_text(table, "source"),
    )


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


def _model(given: Any, catalogue: Mapping[str, Model], place: str) -> tuple[Model, dict[str, Any]]:
    table = dict(_table(given, place))
    name = table.pop("model", None)
    if name is None:
        raise SceneError(f"{place}: model is missing: valid are {', '.join(catalogue)}")
    if not isinstance(name, str) or name not in catalogue:
        close = get_close_matches(str(name), catalogue, n=1)
        hint = f'did you mean "{close[0]}"? ' if close else ""
        raise SceneError(f'{place}: unknown model "{str(name)[:60]}": {hint}valid are {", ".join(catalogue)}')
    return catalogue[name], table


def _built(model: Model, parameters: Table, place: str) -> Any:
    if "parameters" in parameters:
        _table(parameters["parameters"], f"{place}: parameters")
    try:
        return model.build(**parameters)
    except SceneError as error:
        raise error.within(place) from None


def _band(given: Any) -> tuple[Expr, Expr]:
    if not isinstance(given, list) or len(given) != 2:
        raise SceneError(
            f'evaluation: band: "{given}" must be a list of two frequencies, as in ["0 rad/s", "15 rad/s"]'
        )
    low, high = (frequency("evaluation: band", x) for x in given)
    return low, high


def _threshold(given: Any) -> Threshold:
    try:
        if not isinstance(given, Mapping):
            return Threshold.of(given)
        _only(given, ("real", "imag"), "")
        if len(given) < 2:
            raise SceneError("must give both real and imag")
        return Threshold.of(given["real"], given["imag"])
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
            raise SceneError(f'{where}unknown key "{key[:60]}": valid are {", ".join(valid)}')
