"""The names of symbols as people write them: a letter or word with subscripts, Greek letters spelt out or not."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable
from functools import cache
from typing import Any

from sympy import Symbol

from haptisym.writing.boxes import Name, Word

GREEK = (
    "alpha", "beta", "gamma", "delta", "epsilon", "zeta", "eta", "theta", "iota", "kappa", "lambda", "mu", "nu", "xi",
    "omicron", "pi", "rho", "sigma", "tau", "upsilon", "phi", "chi", "psi", "omega",
)  # fmt: skip
CAPITALS = ("Gamma", "Delta", "Theta", "Lambda", "Xi", "Pi", "Sigma", "Upsilon", "Phi", "Psi", "Omega")
_LETTER_OF = {"force": "F", "amplitude": "A"}  # parameters of effects, called by a word but known by a letter


@cache
def named(text: str) -> Name:
    """A symbol's name taken apart: ``_`` starts subscripts, and so does what follows a first letter or ends in digits.

    >>> [word.letters for word in named("omega_n_filter").below], [word.letters for word in named("zeta_force_sensor").below]
    (['n', 'filter'], ['force sensor'])
    >>> named("Mm").below[0].letters, named("k12").below[0].letters, named("force_friction").head.letters
    ('m', '12', 'F')
    """
    head, *below = [word for word in text.split("_") if word] or [text]
    parted = re.fullmatch(r"(.*[^\d])(\d+)", head) or re.fullmatch("([A-Z])([a-z])", head)
    if parted and head not in CAPITALS:
        head, below = parted[1], [parted[2], *below]
    return Name(text, _word(_LETTER_OF.get(head, head)), tuple(_joined(map(_word, below))))


def _word(text: str) -> Word:
    """A letter slants; a word does not."""
    letters = greek(text) or text if len(text) == 1 else text
    is_letter = (len(letters) == 1 and letters.isascii()) or letters in GREEK or letters in CAPITALS
    return Word(letters, not is_letter and not letters.isdigit())


def _joined(words: Iterable[Word]) -> list[Word]:
    """The words of subscripts; upright ones that follow each other are one."""
    found: list[Word] = []
    for word in words:
        if found and word.upright and found[-1].upright:
            found[-1] = Word(f"{found[-1].letters} {word.letters}", upright=True)
        else:
            found.append(word)
    return found


def greek(c: str) -> str:
    """The English name of a Greek letter, "" for any other character.

    >>> greek("ω"), greek("Δ"), greek("w")
    ('omega', 'Delta', '')
    """
    size, _, name = unicodedata.name(c, "").removeprefix("GREEK ").partition(" LETTER ")
    name = name.lower().replace("lamda", "lambda")
    return "" if name not in GREEK else name if size == "SMALL" else name.capitalize()


def letter(word: str) -> str:
    """The Greek letter of that name; any other word as it is.

    >>> letter("omega"), letter("Delta"), letter("wall")
    ('ω', 'Δ', 'wall')
    """
    if word not in GREEK and word not in CAPITALS:
        return word
    size = "SMALL" if word in GREEK else "CAPITAL"
    return unicodedata.lookup(f"GREEK {size} LETTER {word.upper().replace('LAMBDA', 'LAMDA')}")


def alphabetical(symbol: Symbol) -> tuple[Any, ...]:
    """Where a symbol stands in a product: Latin before Greek, each in the order of its alphabet."""
    head, _, below = symbol.name.partition("_")
    name = greek(head) if len(head) == 1 else _LETTER_OF.get(head, head)
    is_greek = name.lower() in GREEK
    return is_greek, GREEK.index(name.lower()) if is_greek else 0, (name or head).lower(), head, below
