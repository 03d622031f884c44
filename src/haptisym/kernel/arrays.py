"""NumPy, loaded when an array is first asked for: the exact core neither waits for it nor needs it.

Modules in which some functions work on arrays write ``from haptisym.kernel.arrays import np``.
Where NumPy is not there (in a browser, say), what needs it is undecided, and says so; where an
exact way does as well, ``has_arrays`` tells to take that.
"""

from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec
from types import ModuleType
from typing import TYPE_CHECKING, Any

from haptisym.kernel.errors import UndecidedError

__all__ = ["has_arrays", "np"]


class _Later(ModuleType):
    """A module that is imported when a name of it is first used; a name that was used once costs no
    more than in the module."""

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):  # what readers of documentation ask of everything
            raise AttributeError(name)
        try:
            value = getattr(import_module(self.__name__), name)
        except ModuleNotFoundError:
            raise UndecidedError("this needs NumPy, which is missing: pip install numpy") from None
        setattr(self, name, value)
        return value


def has_arrays() -> bool:
    """Whether NumPy is there, without loading it.

    >>> has_arrays()
    True
    """
    try:
        return find_spec("numpy") is not None
    except ValueError:  # None stands in its place among the loaded modules
        return False


if TYPE_CHECKING:
    import numpy as np
else:
    np = _Later("numpy")
