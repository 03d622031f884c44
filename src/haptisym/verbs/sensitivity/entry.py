"""Sensitivities as a result: formulas, a page of text and the document of the command line."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from sympy import Expr

from haptisym.judge.evaluation import evaluate
from haptisym.kernel.shown import Answer, counted, titled
from haptisym.kernel.symbols import c
from haptisym.model.jnd import Part
from haptisym.model.scene import Scene
from haptisym.model.scenefile import as_scene
from haptisym.pages.sensitivity import page
from haptisym.verbs.derive.derivation import derive
from haptisym.verbs.sensitivity.slopes import Sensitive, Sensitivity, Slopes


class Sensitivities(Answer, Slopes):
    """How the frequencies of a scene move with its parameters; ``print`` shows tables, ``to_json`` gives the document."""

    def _line(self) -> str:
        changeovers = len(self.changeovers_environment) + len(self.changeovers_perceived)
        found = counted(len(self.crossings), "crossing"), counted(changeovers, "changeover")
        return f"{titled(self.evaluation.scene.title)}: {', '.join(found)}"

    def formula(self, part: Part, name: str) -> Expr:
        """d omega/d parameter at a crossing of that part, in omega and all parameters; ``name`` may be ``c``."""
        d = derive(self.evaluation.scene)
        return d.sensitivity(part, next((x for x in d.kept if x.name == name), c))

    def __str__(self) -> str:
        return page(self)

    def to_dict(self) -> dict[str, Any]:
        """The document of ``haptisym sensitivity --json``, schema ``haptisym.sensitivity/1``."""
        return {
            "schema": "haptisym.sensitivity/1",
            "title": self.evaluation.scene.title,
            "crossings": [self._row(x) for x in self.crossings],
            "changeovers": {
                "environment": [self._row(x) for x in self.changeovers_environment],
                "perceived": [self._row(x) for x in self.changeovers_perceived],
            },
            "bandwidth": None if self.bandwidth is None else self._row(self.bandwidth),
            "certified": self.certified,
            **self.evaluation.scene.aside_keys(varied=None),
        }

    def to_json(self) -> str:
        """The document of ``haptisym sensitivity --json`` as text."""
        return json.dumps(self.to_dict(), indent=2, ensure_ascii=False)

    def _row(self, x: Sensitive) -> dict[str, Any]:
        part = {"part": x.part.value} if x.part else {}
        kind = {"kind": x.kind.value} if x.kind else {}
        reason = {"reason": x.reason} if x.reason else {}
        rows = [self._parameter(p) for p in x.parameters]
        return {**part, "omega": float(x.omega), **kind, **reason, "parameters": rows}

    def _parameter(self, p: Sensitivity) -> dict[str, Any]:
        values = {"derivative": p.derivative, "elasticity": p.elasticity}
        floats = {key: None if x is None else float(x) for key, x in values.items()}
        digits = {key: None if x is None else x.digits(self.evaluation.digits) for key, x in values.items()}
        reason = ({"reason": p.reason} if p.reason else {}) | ({"side": p.side} if p.side else {})
        return {"path": p.path, "name": p.name, "unit": p.unit, **floats, "digits": digits, **reason}


def sensitivity(scene: Scene | str | Path, digits: int = 15) -> Sensitivities:
    """How each crossing, changeover and the bandwidth of a scene moves with each parameter and the threshold.

    Guaranteed: every number is a certified enclosure of the exact derivative, to as many ``digits`` as wanted; None, with the
    reason, where there is no derivative. Works for every scene that can be evaluated. Raises SceneError if a parameter is
    still a symbol.

    >>> from haptisym.model.scenefile import load_scene
    >>> first = sensitivity(load_scene("fu2019")).crossings[0]
    >>> [(x.name, x.elasticity.digits(4)) for x in first.ranked[:2]]
    [('omega_n', '1.265'), ('zeta', '-1.245')]
    """
    scene = as_scene(scene)
    return Sensitivities(evaluate(scene, digits))
