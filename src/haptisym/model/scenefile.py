"""Scenes by the name of a shipped one, by the path of a file, or from a text, with every error naming the file."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

from haptisym.kernel.errors import SceneError, meant
from haptisym.model.catalogue import Effect, Environment
from haptisym.model.distortion import Distortion
from haptisym.model.family import SceneFamily, named
from haptisym.model.measuredscene import MeasuredScene
from haptisym.model.scene import Scene
from haptisym.model.scenetables import MEASURED, read_any, read_scenes

_T = TypeVar("_T", SceneFamily, SceneFamily | MeasuredScene)

_SHIPPED = Path(__file__).parents[1]  # ``importlib.resources`` takes longer than the evaluation of a scene
LARGEST_FILE = 1_000_000  # bytes; a scene is a page of text


def scene_names() -> tuple[str, ...]:
    """The names of the scenes with one environment that the package ships.

    >>> "fu2019" in scene_names()
    True
    """
    return _shipped("scenes")


def family_names() -> tuple[str, ...]:
    """The names of the scenes with several environments that the package ships.

    >>> family_names()
    ('palpation-device',)
    """
    return _shipped("families")


def bench_names() -> tuple[str, ...]:
    """The names of the measured scenes that the package ships: simulated bench runs, which ``evaluate`` and ``identify`` take.

    >>> bench_names()
    ('delayed-spring-bench', 'fu2019-bench', 'fu2019-clipped-bench')
    """
    return _shipped("benches")


def _shipped(folder: str) -> tuple[str, ...]:
    entries = (_SHIPPED / folder).iterdir()
    return tuple(sorted(entry.name.removesuffix(".toml") for entry in entries if entry.name.endswith(".toml")))


def load_scene(scene: str | Path, environment: str | None = None) -> Scene:
    """The scene of that name (one that the package ships) or in that file. SceneError says what is wrong with it.

    ``environment`` : which of several environments; without it a scene that has several is an error that lists them.

    >>> load_scene("fu2019").environment.H
    9*s**2/5 + 15*s + 100
    >>> load_scene("palpation-device", "muscle").environment.H
    2*s + 290
    """
    return _chosen(*scene_text(scene), environment)


def load_scenes(scene: str | Path, environments: Iterable[str | Path] = ()) -> SceneFamily:
    """The scenes in that file (or of that name), one for each of its environments: one or several.

    ``environments`` : scenes whose environments (each with what is rendered for it) take the place of the scene's own;
    named after their files. SceneError says what is wrong.

    >>> list(load_scenes("palpation-device")), list(load_scenes("fu2019", ["fu2019", "helicopter-cyclic"]))
    (['fat', 'muscle', 'liver', 'tumour'], ['fu2019', 'helicopter-cyclic'])
    """
    text, name = scene_text(scene)
    return felt_through(parse_scenes(text, name), name, environments)


def felt_through(own: SceneFamily, name: str, environments: Iterable[str | Path]) -> SceneFamily:
    """The displays of scenes with the environments of others, if there are any; ``name`` is what error messages call the file."""
    given = [(label, x) for place in environments for label, x in _labelled(place)]
    if not given:
        return own
    try:
        return named(((label, _with_environment(own.first, label, x)) for label, x in given), own.title, own.source)
    except SceneError as error:
        raise error.within(name) from None


def open_scenes(scene: str | Path) -> tuple[SceneFamily | MeasuredScene, str]:
    """What is in that file, or has that name: scenes of formulas, or one that is measured; and what error messages call it."""
    text, name = scene_text(scene)
    folder = _SHIPPED / "benches" if str(scene) in bench_names() else Path(str(scene)).parent
    return _parsed(name, lambda: read_any(text, folder)), name


def as_scene(given: Scene | str | Path) -> Scene:
    """A scene as it is, or the one of that name or in that file: what every question about a scene begins with.

    >>> as_scene("fu2019").environment.H
    9*s**2/5 + 15*s + 100
    >>> as_scene(load_scene("fu2019").environment)
    Traceback (most recent call last):
      ...
    haptisym.kernel.errors.SceneError: Environment is not a scene: make one with Scene(environment, effects, band, threshold)
    """
    return given if isinstance(given, Scene) else load_scene(given)


def as_family(given: SceneFamily | Scene | str | Path) -> SceneFamily:
    """Scenes as they are, or those of that name or in that file; a scene is a family of one."""
    if isinstance(given, SceneFamily):
        return given
    if isinstance(given, Scene):
        return named([("environment", given)], given.title, given.source)
    return load_scenes(given)


def _with_environment(display: Scene, label: str, other: Scene) -> Scene:
    """The display of one scene with the environment of another."""
    try:
        return replace(display, environment=other.environment, rendered=other.rendered)
    except SceneError as error:
        raise error.within(label) from None


def _labelled(place: str | Path) -> list[tuple[str, Scene]]:
    """The environments of a scene as scenes, each by its name; the only one by the name of its file."""
    text, name = scene_text(place)
    family = parse_scenes(text, name)
    if len(family) == 1:
        return [(name.removesuffix(".toml"), family.first)]
    return list(family.scenes.items())


def parse_scene(text: str, name: str = "scene", environment: str | None = None) -> Scene:
    """The scene that a TOML text describes; ``name`` is what error messages call it, ``environment`` one of several.

    >>> parse_scene('environment = { model = "maxwell", k = 100, b = "5 N*s/m" }').band
    (0, 15)
    """
    return _chosen(text, name, environment)


def parse_scenes(text: str, name: str = "scene") -> SceneFamily:
    """The scenes that a TOML text describes, one for each of its environments; ``name`` is what error messages call it."""
    return _parsed(name, lambda: read_scenes(text))


def _parsed(name: str, read: Callable[[], _T]) -> _T:
    try:
        found = read()
        for scene in () if isinstance(found, MeasuredScene) else found.scenes.values():
            _ = scene.closed  # what is wrong with the dynamics as a whole is wrong with this file
    except SceneError as error:
        raise error.within(name) from None
    return found


def _chosen(text: str, name: str, environment: str | None) -> Scene:
    return chosen(parse_scenes(text, name), name, environment)


def chosen(family: SceneFamily, name: str, environment: str | None) -> Scene:
    """One environment of several, or the only one; ``name`` is what error messages call the file."""
    try:
        if environment is None:
            return family.only()
        scene = family[environment]
    except SceneError as error:
        raise error.within(name) from None
    return replace(scene, title=f"{scene.title or 'Untitled scene'}: {environment}")


def scene_text(scene: str | Path) -> tuple[str, str]:
    """The text of a shipped scene or of a file, and what error messages call it. A file is read once, as pipes can only be."""
    if not isinstance(scene, str | Path) or "\n" in str(scene):
        raise SceneError(_instead(scene))
    name = str(scene)
    for folder, known in (("scenes", scene_names), ("families", family_names), ("benches", bench_names)):
        if name in known():
            return (_SHIPPED / folder / f"{name}.toml").read_text(encoding="utf-8"), name
    path = Path(name)
    return _read(path), path.name if path.is_file() else name


def _instead(given: object) -> str:
    """What to call with something that is neither the name of a scene nor a path."""
    if isinstance(given, str):
        return "this is a scene's text, not its name or path: read it with parse_scene(text)"
    if isinstance(given, Scene):
        return "this is a scene already, not the name or path of one"
    if isinstance(given, MeasuredScene):
        return MEASURED
    if isinstance(given, SceneFamily):
        way = f'choose one, as in scenes["{next(iter(given))}"], or ask for all with evaluate_all(scenes)'
    elif isinstance(given, Distortion):
        way = "it has no band and no threshold; make one with Scene(environment, effects, band, threshold)"
    elif isinstance(given, Environment | Effect):
        way = "make one with Scene(environment, effects, band, threshold)"
    elif isinstance(getattr(given, "scene", None), Scene):
        way = "its attribute scene is one"
    else:
        way = "give a Scene, the name of one that the package ships, or the path of a scene file"
    return f"{type(given).__name__} is not a scene: {way}"


def _read(path: Path) -> str:
    try:
        with path.open("rb") as file:
            data = file.read(LARGEST_FILE + 1)  # of a pipe or device nothing else tells how much there is
    except (OSError, ValueError) as error:
        raise SceneError(f"{path}: {_no_such_scene(path, error)}") from None
    if len(data) > LARGEST_FILE:
        raise SceneError(f"{path}: the file has more than {LARGEST_FILE} bytes; a scene may have at most that")
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise SceneError(f"{path}: the file is written in UTF-16: save it as UTF-8")
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError:
        raise SceneError(f"{path}: not a text file (UTF-8)") from None


def _no_such_scene(path: Path, error: Exception) -> str:
    known = scene_names() + family_names()
    files = sorted(x.name for x in path.parent.glob("*.toml"))
    hint = (
        meant(f"{path.name}.toml", [x for x in files if x == f"{path.name}.toml"])
        or meant(path.name, [x for x in files if x != path.name])
        or meant(path.name.removesuffix(".toml"), known)
        or f"the package ships {', '.join(known)}"
    )
    reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
    return f"neither a scene file ({reason.lower()}) nor a scene of the package; {hint.rstrip()}"
