"""haptisym: evaluate haptic displays symbolically. What is felt instead, when it is noticed, and as
what.

>>> import haptisym as hs
>>> m, b, k = hs.symbols("m b k")
>>> d = hs.distort(hs.environments.mass_spring_damper(m, b, k), hs.effects.first_order_lag(hs.symbols("omega_c")))
>>> d.relative_real
-omega**2/(omega**2 + omega_c**2)
"""

import re
from importlib import import_module
from pkgutil import get_data

__version__ = "0.3.0"

_MODULES = {
    name: module
    for module, several, names in re.findall(
        r"^from haptisym\.?(\S*) import (?:\(([^)]+)\)|(.+))$",
        (get_data(__name__, "__init__.pyi") or b"").decode(),
        re.MULTILINE,
    )
    for name in re.findall(r"(\w+) as", several or names)
}
"""The public names and the modules that have them, as the stub says; each is loaded when it is
used: not even SymPy is before."""
__all__ = sorted(_MODULES)


def __getattr__(name: str) -> object:
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module = import_module(f".{_MODULES[name] or name}", __name__)
    found = globals()[name] = getattr(module, name) if _MODULES[name] else module
    return found


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
