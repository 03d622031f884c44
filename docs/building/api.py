"""The reference of the Python interface: every public name once, by what it is for."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import haptisym as hs

TOPICS: Mapping[str, tuple[str, str, tuple[str, ...]]] = {
    "api-scenes": (
        "Scenes",
        "What a question is about: an environment, what stands between it and the hand, a band and a threshold. Numbers are exact; quantities are strings with a unit, or numbers in SI and rad/s.",
        (
            "load_scene", "parse_scene", "scene_names", "Scene", "Environment", "Effect", "Threshold", "Part", "Hand", "hands",
            "load_scenes", "parse_scenes", "family_names", "SceneFamily", "measured", "sampled", "Measurement", "MeasuredScene",
        ),
    ),
    "api-questions": (
        "Questions",
        "One function for each verb of the command line; each returns an answer.",
        (
            "evaluate", "evaluate_all", "derive", "relevance", "require", "design_map", "stability", "sensitivity", "tolerances",
            "sweep", "metrics", "peaks", "cost", "hard_costs", "jnd", "published", "simulate", "check", "release", "identify",
        ),
    ),
    "api-answers": (
        "Answers",
        "What a question returns. `print` shows the page of the command line, a notebook shows it set, `to_dict` and `to_json` give the document.",
        (
            "Evaluation", "Crossing", "CrossingKind", "Percept", "Property", "Change", "Interval", "Point", "RealNumber",
            "FamilyEvaluation", "MeasuredEvaluation", "Derivation", "Relevance", "Requirement", "DesignMap", "Stability", "Sensitivities",
            "Tolerances", "Metrics", "Peaks", "Peak", "Cost", "HardCosts", "Psychometric", "Published", "PublishedThresholds", "Simulation",
            "Release", "Identification", "json_schema",
        ),
    ),
    "api-formulas": (
        "Formulas and functions",
        "Closed forms with symbols or numbers, how they are written, and functions of NumPy.",
        ("distort", "Distortion", "symbols", "omega", "s", "Accuracy", "latex", "mathml", "Language", "scene_code", "distortion_code"),
    ),
    "api-motions": (
        "Motions of a simulation",
        "What a hand does in `hs.simulate`, and what else a device has.",
        ("sine", "multisine", "chirp", "recording", "EncoderQuantisation", "ForceSaturation"),
    ),
    "api-errors": (
        "Errors",
        "All are ValueErrors, and each says the thing, the value, the rule and the way out.",
        ("HaptisymError", "SceneError", "ExpressionError", "UndecidedError"),
    ),
}  # fmt: skip
"""Of each page the title, a lead, and the names."""
MODULES = {
    "api-environments": ("Environments", "environments"),
    "api-effects": ("Effects", "effects"),
    "api-interop": ("Other packages", "interop"),
}
"""Modules that are documented whole."""


def listed(page: str) -> tuple[str, ...]:
    """The names of a page; what no page names goes to the questions if it is a function, to the answers if it is a class."""
    told = {name for _, _, names in TOPICS.values() for name in names} | {name for _, name in MODULES.values()}
    kinds = {"api-answers": True, "api-questions": False}
    others = [
        name for name in hs.__all__ if name not in told and isinstance(getattr(hs, name), type) is kinds.get(page)
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


PAGES: dict[str, Callable[[], str]] = {
    **{name: _page(_topic, *given[:2], listed(name)) for name, given in TOPICS.items()},
    **{name: _page(_module, *given) for name, given in MODULES.items()},
}
