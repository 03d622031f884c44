"""The reference of the Python interface: every public name once, by purpose."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import haptisym as hs

TOPICS: Mapping[str, tuple[str, str, tuple[str, ...]]] = {
    "api-scenes": (
        "Scenes in Python",
        "After this page you can build scenes in Python: environment, effects, band, threshold, hands. Quantities are strings with a unit, or numbers in SI and rad/s; numbers are exact.",
        (
            "load_scene", "parse_scene", "scene_names", "Scene", "Environment", "Effect", "Threshold", "Part", "Hand", "hands", "devices",
            "load_scenes", "parse_scenes", "family_names", "SceneFamily", "measured", "sampled", "Measurement", "MeasuredScene",
        ),
    ),
    "api-questions": (
        "A function for each command",
        "After this page you can call every command from Python: a function each, which returns a result.",
        (
            "evaluate", "evaluate_all", "compare", "derive", "relevance", "require", "design_map", "stability", "sensitivity", "tolerances",
            "sweep", "metrics", "control_loading", "peaks", "cost", "hard_costs", "jnd", "published", "simulate", "check", "release", "identify", "fit_zwidth",
        ),
    ),
    "api-answers": (
        "Results",
        "After this page you can use what the functions return. `print` gives the text output, a notebook typesets it, `to_dict` and `to_json` give the JSON document.",
        (
            "Evaluation", "Crossing", "CrossingKind", "Percept", "Property", "Change", "Interval", "Point", "RealNumber",
            "FamilyEvaluation", "MeasuredEvaluation", "Comparison", "Derivation", "Relevance", "Requirement", "ValueSet", "DesignMap", "Stability", "Sensitivities",
            "Tolerances", "Metrics", "Peaks", "Peak", "Cost", "HardCosts", "Psychometric", "Published", "PublishedThresholds", "Simulation",
            "Release", "Identification", "ZWidthFit", "json_schema",
        ),
    ),
    "api-formulas": (
        "Formulas",
        "After this page you can derive closed forms with symbols or numbers, write them, and compile them for NumPy.",
        ("distort", "Distortion", "symbols", "omega", "s", "Accuracy", "latex", "mathml", "Language", "scene_code", "distortion_code"),
    ),
    "api-motions": (
        "Motions of a simulation",
        "After this page you can choose the motion of the hand in `hs.simulate`, and add an encoder or a force limit.",
        ("sine", "multisine", "chirp", "recording", "EncoderQuantisation", "ForceSaturation"),
    ),
    "api-errors": (
        "Errors",
        "After this page you can catch errors. All are ValueErrors; each names what is wrong, its value, the rule and the remedy.",
        ("HaptisymError", "SceneError", "ExpressionError", "UndecidedError"),
    ),
}  # fmt: skip
"""The title, lead and names of each page."""
MODULES = {
    "api-environments": ("Environments", "environments"),
    "api-effects": ("Effects", "effects"),
    "api-interop": ("Other packages", "interop"),
}
"""Modules that are documented as a whole."""


def listed(page: str) -> tuple[str, ...]:
    """Return the names of a page; unlisted functions go to the functions, unlisted classes to the results."""
    placed = {name for _, _, names in TOPICS.values() for name in names} | {name for _, name in MODULES.values()}
    kinds = {"api-answers": True, "api-questions": False}
    others = [
        name for name in hs.__all__ if name not in placed and isinstance(getattr(hs, name), type) is kinds.get(page)
    ]
    return (*TOPICS[page][2], *others)


def _topic(title: str, lead: str, names: tuple[str, ...]) -> str:
    return "\n".join([f"# {title}\n", f"{lead}\n", *map(_entry, names)])


def _entry(name: str) -> str:
    thing = getattr(hs, name)
    kind = "class" if isinstance(thing, type) else "function" if callable(thing) else "data"
    members = (
        "\n:members:\n:undoc-members:\n:inherited-members: Answer, tuple, Enum, ValueError" if kind == "class" else ""
    )
    return f"```{{eval-rst}}\n.. auto{kind}:: haptisym.{name}{_indented(members)}\n```\n"


def _indented(options: str) -> str:
    return options.replace("\n", "\n   ")


def _module(title: str, name: str) -> str:
    return f"# {title}\n\n```{{eval-rst}}\n.. automodule:: haptisym.{name}\n   :members:\n```\n"


def _page(make: Callable[..., str], *given: object) -> Callable[[], str]:
    return lambda: make(*given)


def _contents() -> str:
    """Return the page that the reference of the Python interface begins with."""
    lead = "After this page you know where each class and function of `import haptisym as hs` is described.\n"
    titles = {name: title for name, (title, *_) in {**TOPICS, **MODULES}.items()}
    order = ["api-scenes", *MODULES, *(name for name in TOPICS if name != "api-scenes")]
    rows = [f"- [{titles[name]}]({name}.md)" for name in order]
    names = "\n".join(order)
    return "\n".join(["# Python interface\n", lead, *rows, f"\n```{{toctree}}\n:hidden:\n\n{names}\n```\n"])


PAGES: dict[str, Callable[[], str]] = {
    "api": _contents,
    **{name: _page(_topic, *given[:2], listed(name)) for name, given in TOPICS.items()},
    **{name: _page(_module, *given) for name, given in MODULES.items()},
}
