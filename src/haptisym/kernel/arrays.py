"""NumPy, loaded when an array is first asked for: the exact core neither waits for it nor needs it.

Modules in which some functions work on arrays write ``from haptisym.kernel.arrays import np``.
Where NumPy is not there (in a browser, say), what needs it is undecided, and says so; where an
exact way does as well, ``has_arrays`` tells to take that.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from importlib import import_module
from importlib.util import find_spec
from types import ModuleType
from typing import TYPE_CHECKING, Any

from haptisym.kernel.errors import UndecidedError

__all__ = ["has_arrays", "in_floats", "np"]


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


def in_floats(function: Callable[..., Any]) -> Callable[..., Any]:
    """A function of NumPy that computes in floats whatever it is given, and returns a constant for
    each entry of the arguments.

    >>> in_floats(lambda x: x**8)([1000])
    array([1.e+24])
    """

    @wraps(function)
    def called(*arguments: Any, **named: Any) -> Any:
        given = [*map(_in_floats, arguments)], {x: _in_floats(y) for x, y in named.items()}
        shape = np.broadcast_shapes(*map(np.shape, (*given[0], *given[1].values())))
        found = function(*given[0], **given[1])
        if isinstance(found, list):
            return [_filled(x, shape) for x in found]
        return _filled(found, shape)

    return called


def _in_floats(x: Any) -> Any:
    """A number or an array in floats, complex ones as they are: whole numbers would overflow."""
    if isinstance(x, float | complex):
        return x
    array = x if hasattr(x, "dtype") else np.asarray(x)
    return array if getattr(array.dtype, "kind", "f") in "fc" else array.astype(float)


def _filled(x: Any, shape: tuple[int, ...]) -> Any:
    """An array of that shape for a single number."""
    return x if np.ndim(x) or not shape else np.full(shape, x)


if TYPE_CHECKING:
    import numpy as np
else:
    np = _Later("numpy")
