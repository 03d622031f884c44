"""One question about each environment of a family: the answers side by side and, of values that are
required, what they share.

The values of a parameter that do for all environments are the intersection of their proven sets; at
each of its ends the environments bind that have an end of their own there. A value that no
environment excludes and one leaves open stays open.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar

from haptisym.judge.answers import Answer
from haptisym.kernel.budget import Left, share
from haptisym.kernel.errors import UndecidedError, within
from haptisym.kernel.objects import counted, titled
from haptisym.kernel.sets import ValueSet, combined
from haptisym.model.scene import Scene
from haptisym.model.scenefile import SceneFamily, as_family


@dataclass(frozen=True, repr=False)
class FamilyAnswers(Answer):
    """The result of one command for each environment of a scene: ``answers``, by the names of the
    environments.

    ``common`` : where they are sets of values of one parameter, their intersection, SI, proven;
    else None. ``binding`` : at each end of it the environments that limit it. Each result is that
    of its environment alone. ``left`` : the environments without a result, each with the reason.
    Made by ``answer_each``.
    """

    _schema: ClassVar[str] = "haptisym.answers/1"
    _page: ClassVar[str] = "haptisym.pages.familyanswers:page"
    _figure: ClassVar[str] = "haptisym.figures.family:EACH"

    family: SceneFamily
    answers: Mapping[str, Any]
    left: Left = field(default_factory=dict)

    def _line(self) -> str:
        return f"{titled(self.family.title)}: {counted(len(self.answers), 'answer')}"

    @property
    def _about(self) -> SceneFamily:
        return self.family

    @property
    def certified(self) -> bool:
        """Whether all answers are, and nothing that they share was left undecided."""
        shared = self.common is None or not self.common.undecided
        return all(x.certified for x in self.answers.values()) and shared and not self.left

    @property
    def settled(self) -> bool:
        """Whether no answer has a question that stayed undecided."""
        return all(x.settled for x in self.answers.values()) and not self.left

    @cached_property
    def common(self) -> ValueSet | None:
        """The values that do for all environments; None where the answers are no such sets."""
        each = list(self.answers.values())
        domains: set[Any] = {getattr(x, "domain", None) for x in each}
        # no sets of values, or of different ranges: then the parameter is one of the environments
        # themselves, and its values are about different things
        if (
            self.left
            or len(domains) > 1
            or None in domains
            or not all(hasattr(x, "values") for x in each)
        ):
            return None
        return combined([x.values for x in each])

    @property
    def binding(self) -> tuple[tuple[float, str, str], ...]:
        """The ends of the common values, SI, each with an environment that limits it and its
        criterion."""
        ends = [end.value for end in self.common.ends] if self.common else []
        # an end of the intersection is an end of one set at least, of those that have it there
        bindings = {
            (float(value), name, b.criterion.name)
            for value in ends
            for name, x in self.answers.items()
            for limit in x.ends
            if float(limit.value) == float(value)
            for b in limit.bindings
        }
        return tuple(sorted(bindings))

    def _body(self) -> dict[str, Any]:
        rows = [{"name": name, **x.to_dict()} for name, x in self.answers.items()]
        return {
            "environments": rows,
            "certified": self.certified,
            **({"common": self._common()} if self.common else {}),
        }

    def _left(self) -> dict[str, Any]:
        rows = [{"name": name, "reason": why} for name, why in self.left.items()]
        return {"undecided": rows} if rows else {}

    def _common(self) -> dict[str, Any]:
        def pair(low: Any, high: Any) -> list[float | None]:
            return [None if x is None else float(x) for x in (low, high)]

        assert self.common is not None
        return {
            "feasible": [pair(x.low, x.high) for x in self.common.feasible],
            "binding": [
                {"at": at, "environment": name, "criterion": x} for at, name, x in self.binding
            ],
            "undecided": [pair(x.low, x.high) for x in self.common.undecided],
        }


def answer_each(
    family: SceneFamily | Scene | str | Path, question: Callable[[Scene], Any]
) -> FamilyAnswers:
    """Ask one question about each environment of a scene, and put the answers side by side.

    ``family`` : scenes, or their name or file. ``question`` : what is asked of each scene, such as
    ``hs.stability``, or a lambda with its arguments. Each answer is that of its
    environment alone; ``common``, of ``hs.require``, is the intersection of the proven sets. Raises
    what the question raises; where it is undecided for some environments, for all others there is
    an answer.

    >>> from haptisym import load_scenes, require
    >>> family = load_scenes("fu2019", ["fu2019", "helicopter-cyclic"])
    >>> found = answer_each(family, lambda scene: require(scene, "omega_n"))
    >>> [round(at, 6) for at, *_ in found.binding] == [round(float(found.common.feasible[0].low), 6)]
    True
    """
    family = as_family(family)
    answers, left = dict[str, Any](), Left()
    for i, (name, scene) in enumerate(family.scenes.items()):
        try:
            # an equal share of the time that is left for each that is still to come
            with share(1 / (len(family) - i)), within(f'environment "{name}"'):
                answers[name] = question(scene)
        except UndecidedError as error:
            left[name] = str(error)
            # undecided for all of them: there is no answer to return
            if len(left) == len(family):
                raise
    return FamilyAnswers(family, answers, left)
