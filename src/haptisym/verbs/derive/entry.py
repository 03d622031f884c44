"""A derivation as a result: a page of text, LaTeX, and the document of the command line."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any, ClassVar

from haptisym.judge.answers import Answer
from haptisym.model.scene import Scene
from haptisym.pages.derive import as_json, latex, to_dict
from haptisym.pages.sections import sections
from haptisym.verbs.derive.derivation import Derivation as Formulas
from haptisym.verbs.derive.derivation import derive as formulas


class Derivation(Answer, Formulas):
    __doc__ = Formulas.__doc__
    _schema: ClassVar[str] = "haptisym.derivation/1"
    _page: ClassVar[str] = "haptisym.pages.derive:page"

    def to_latex(self) -> str:
        """What ``haptisym derive --to latex`` prints."""
        return latex(self)

    def to_dict(self) -> dict[str, Any]:
        """The document of ``haptisym derive --json``, schema ``haptisym.derivation/1``."""
        return to_dict(self, sections(self))

    def to_json(self) -> str:
        """The document of ``haptisym derive --json`` as text."""
        return as_json(self, sections(self))


def derive(scene: Scene | str | Path, keep: Iterable[str] | None = None) -> Derivation:
    """The formulas of a scene; ``print`` shows them as a page of text.

    ``keep`` : the names of the parameters that stay symbols; None for all of them and the threshold, () for none. A name
    that the scene does not have raises SceneError.

    >>> found = derive("fu2019", keep=["omega_n"])
    >>> found
    <Derivation "Numerical example of Fu, van Paassen and ...": omega_n as symbols>
    >>> found["H_perc"]
    omega_n**2*(9*s**2 + 75*s + 500)/(5*omega_n**2 + 5*omega_n*s + 5*s**2)
    """
    found = formulas(scene, keep)
    return Derivation(found.scene, found.kept, found.kept_thresholds)
