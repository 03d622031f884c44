"""The languages that code is written in, the names that each allows, and text that is safe in its comments."""

from __future__ import annotations

import keyword
import re
import unicodedata
from collections.abc import Iterable, Mapping
from enum import Enum
from itertools import chain, count

from haptisym.kernel.errors import SceneError, quoted
from haptisym.writing.layout import greek


class Language(Enum):
    """A programming language, and how its files end."""

    NUMPY = "py"
    C = "c"
    OCTAVE = "m"
    JULIA = "jl"
    JAVASCRIPT = "js"

    @classmethod
    def of(cls, given: Language | str) -> Language:
        """A language, or that of a name in small letters; SceneError for any other."""
        known = {x.name.lower(): x for x in cls}
        if isinstance(given, cls):
            return given
        if isinstance(given, str) and given.lower() in known:
            return known[given.lower()]
        raise SceneError(f"language: {quoted(given)} is none of {', '.join(known)}")


def _words(text: str) -> frozenset[str]:
    return frozenset(text.split())


_FUNCTIONS = _words("abs cos exp fabs log max min pow sin sinc sqrt tan pi")  # what the code itself may call
RESERVED: Mapping[Language, frozenset[str]] = {
    Language.NUMPY: _FUNCTIONS
    | {*keyword.kwlist, *keyword.softkwlist, "np", "float", "NamedTuple", "shape", "results"},
    Language.C: _FUNCTIONS
    | _words(
        "alignas alignof asm auto bool break case catch char class const constexpr continue default delete do double else "
        "enum extern false float for friend goto if inline int long namespace new nullptr operator private protected public "
        "register restrict return short signed sizeof static static_assert struct switch template this thread_local throw "
        "true try typedef typename typeof typeof_unqual union unsigned using virtual void volatile while main values "
        "acos asin atan atan2 ceil cosh sinh tanh floor fmod frexp ldexp log10 modf erf erfc gamma lgamma tgamma hypot "
        "j0 j1 jn y0 y1 yn cbrt exp2 expm1 log1p log2 logb fma fdim fmax fmin remainder round trunc rint nan isnan isinf "
        "index linux unix signgam HUGE_VAL INFINITY NAN"
    ),
    Language.OCTAVE: _FUNCTIONS
    | _words(
        "break case catch classdef continue do else elseif end end_try_catch end_unwind_protect endclassdef endenumeration "
        "endevents endfor endfunction endif endmethods endparfor endproperties endswitch endwhile enumeration events for "
        "function global if methods otherwise parfor persistent properties return spmd switch try until unwind_protect "
        "unwind_protect_cleanup while arguments import i j I J e Inf NaN NA eps ans inf nan true false ones zeros size zero "
        "values nargin nargout"
    ),
    Language.JULIA: _FUNCTIONS
    | _words(
        "abstract baremodule begin break catch const continue do else elseif end export false finally for function global "
        "if import in isa let local macro module mutable new outer primitive public quote return struct true try type using "
        "where while im Inf NaN float iszero one zero"
    ),
    Language.JAVASCRIPT: _FUNCTIONS
    | _words(
        "abstract arguments async await boolean break byte case catch char class const continue debugger default delete do "
        "double else enum eval export extends false final finally float for function get goto if implements import in "
        "instanceof int interface let long module native new null of package private protected public return set short "
        "static super switch synchronized this throw throws transient true try typeof undefined var void volatile while "
        "with yield Math Infinity NaN Object exports require globalThis window"
    ),
}
"""Words that cannot name a parameter: keywords, and names that the generated code uses itself."""

_LONGEST = 60  # characters of a name; MATLAB reads 63


def identifiers(names: Iterable[str], language: Language, taken: Iterable[str] = ()) -> dict[str, str]:
    """For each name, one that the language allows and that nothing else has: itself where possible, else visibly changed.

    >>> identifiers(["m", "lambda", "ζ", "k 1"], Language.NUMPY)
    {'m': 'm', 'lambda': 'lambda_', 'ζ': 'zeta', 'k 1': 'k_1'}
    """
    listed = list(names)
    used = {*RESERVED[language], *taken}
    chosen: dict[str, str] = {}
    # names that can stay are given first, so that no changed one takes them
    for name in sorted(listed, key=lambda x: _plain(x) != x or x in used):
        stem = _plain(name)[:_LONGEST]
        chosen[name] = next(x for x in _candidates(stem) if x not in used)
        used.add(chosen[name])
    return {name: chosen[name] for name in listed}


def _candidates(stem: str) -> Iterable[str]:
    return chain([stem, f"{stem}_"], (f"{stem}_{n}" for n in count(2)))


def _plain(name: str) -> str:
    """ASCII letters, digits and _, a letter in front; Greek letters by their names."""
    spelt = "".join(c if c.isascii() else _letter(c) for c in unicodedata.normalize("NFKC", name))
    word = re.sub(r"\W+", "_", spelt).rstrip("_" if not name.endswith("_") else "")
    return word if re.match("[A-Za-z]", word) else f"p_{word.lstrip('_')}"


def _letter(c: str) -> str:
    base = unicodedata.normalize("NFKD", c)[0]
    return greek(c) or (base if base.isascii() else f"_u{ord(c):04X}")


def function_name(name: str, language: Language) -> str:
    """The name if the language allows it for a function; SceneError otherwise."""
    if not re.fullmatch("[A-Za-z][A-Za-z0-9_]*", name) or len(name) > _LONGEST or name in RESERVED[language]:
        raise SceneError(
            f'"{name[:80]}" cannot name a function in {language.name}: use at most {_LONGEST} ASCII letters, digits and _, '
            "a letter in front, and no word that the language has"
        )
    return name


def comment(text: str) -> str:
    """Any text as one line that ends no comment and no string, in any of the languages, and hides nothing.

    >>> comment("a */ b\\nc")
    'a * / b c'
    """
    line = "".join(c if c.isprintable() else "?" for c in " ".join(text.split()))
    # a backslash first: what becomes of it must not close a comment with the star before it
    for mark, harmless in (("\\", "/"), ("*/", "* /"), ("/*", "/ *"), ('"', "'")):
        line = line.replace(mark, harmless)
    return re.sub(r"\?(?=\?)", "? ", line)  # two of them start a trigraph in C
