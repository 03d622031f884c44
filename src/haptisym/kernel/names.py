"""Names of symbols: the Greek letters, and how a name is spelt where only identifiers are allowed.

In Python a symbol is a keyword argument of its own name, ``f(omega, k=100)``; one that cannot be,
as ``lambda`` or ``\\mu``, is spelt everywhere as ``spelt`` has it: ``lambda_`` and ``mu``.
"""

from __future__ import annotations

import keyword
import re
import unicodedata
from collections.abc import Container, Iterable
from itertools import chain, count

GREEK = (
    "alpha",
    "beta",
    "gamma",
    "delta",
    "epsilon",
    "zeta",
    "eta",
    "theta",
    "iota",
    "kappa",
    "lambda",
    "mu",
    "nu",
    "xi",
    "omicron",
    "pi",
    "rho",
    "sigma",
    "tau",
    "upsilon",
    "phi",
    "chi",
    "psi",
    "omega",
)
CAPITALS = (
    "Gamma",
    "Delta",
    "Theta",
    "Lambda",
    "Xi",
    "Pi",
    "Sigma",
    "Upsilon",
    "Phi",
    "Psi",
    "Omega",
)


def greek(c: str) -> str:
    """The English name of a Greek letter, "" for any other character.

    >>> greek("ω"), greek("Δ"), greek("w")
    ('omega', 'Delta', '')
    """
    size, _, name = unicodedata.name(c, "").removeprefix("GREEK ").partition(" LETTER ")
    # Unicode spells it "lamda", everyone else "lambda".
    name = name.lower().replace("lamda", "lambda")
    return "" if name not in GREEK else name if size == "SMALL" else name.capitalize()


LONGEST = 60
"""Characters of a name in code; MATLAB reads 63."""
CALLED = frozenset(
    "Abs I abs acos asin atan atan2 cos exp im pi re sin sqrt tan".split()  # noqa: SIM905
)
"""What plain functions of Python call: a parameter of such a name would hide it."""


def keywords(names: Iterable[str]) -> dict[str, str]:
    """For each name the keyword argument that it is in Python: itself where it can be one.

    >>> keywords(["k", "lambda", "sqrt", r"\\mu", "k_{env}", "ζ"])
    {'k': 'k', 'lambda': 'lambda_', 'sqrt': 'sqrt_', '\\\\mu': 'mu', 'k_{env}': 'k_env', 'ζ': 'ζ'}
    """
    listed, reserved = list(names), {*keyword.kwlist, *CALLED}
    own = {x for x in listed if x.isidentifier() and x not in reserved}
    others = spelt((x for x in listed if x not in own), own | reserved)
    return {x: others.get(x, x) for x in listed}


def spelt(names: Iterable[str], taken: Container[str] = ()) -> dict[str, str]:
    """For each name an identifier of ASCII letters that nothing else has and that is not ``taken``:
    itself where possible, else visibly changed."""
    listed = list(names)
    chosen: dict[str, str] = {}
    used = set[str]()

    # Names that can stay are given first, so that no changed one takes them.
    for name in sorted(listed, key=lambda x: _plain(x) != x or x in taken):
        stem = _plain(name)[:LONGEST]
        # The least changed first, of endless ones.
        candidates = chain([stem, f"{stem}_"], (f"{stem}_{n}" for n in count(2)))
        chosen[name] = next(x for x in candidates if x not in used and x not in taken)
        used.add(chosen[name])
    return {name: chosen[name] for name in listed}


def _plain(name: str) -> str:
    """ASCII letters, digits and _, a letter in front; Greek letters by their names."""
    ascii_only = (c if c.isascii() else _letter(c) for c in unicodedata.normalize("NFKC", name))
    spelling = re.sub(r"^\W+", "", "".join(ascii_only))
    word = re.sub(r"_*\W[\W_]*", "_", spelling).rstrip("_" if not name.endswith("_") else "")
    return word if re.match("[A-Za-z]", word) else f"p_{word.lstrip('_')}"


def _letter(c: str) -> str:
    """A character that is not ASCII: a Greek letter's name, a letter without its accent, else the
    code point."""
    base = unicodedata.normalize("NFKD", c)[0]
    return greek(c) or (base if base.isascii() else f"_u{ord(c):04X}")
