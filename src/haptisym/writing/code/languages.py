"""The languages that code is written in: the names that each allows, and how each lays a routine out.

A routine is its documentation, in that language's own style and safe in its comments, and then its statements.
"""

from __future__ import annotations

import keyword
import re
import textwrap
import unicodedata
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from itertools import chain, count

from haptisym.kernel.errors import SceneError, quoted
from haptisym.programs.program import LAST, SMALL
from haptisym.writing.layout import greek


class Language(Enum):
    """A programming language, and how its files end."""

    NUMPY = "py"
    C = "c"
    OCTAVE = "m"
    JAVASCRIPT = "js"

    @classmethod
    def of(cls, given: Language | str) -> Language:
        """A language, or that of a name in small letters; SceneError for any other."""
        known = {x.name.lower(): x for x in cls}
        if isinstance(given, cls):
            return given
        if isinstance(given, str) and given.lower() in known:
            return known[given.lower()]
        way = "; for Julia take c, which it calls by ccall, or numpy" if str(given).lower() in ("julia", "jl") else ""
        raise SceneError(f"language: {quoted(given)} is none of {', '.join(known)}{way}")


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


_WIDTH = 100  # columns
_SINC, _SINCM1 = "sin(x)/x, and 1 at x = 0", "sin(x)/x - 1, by its series for small x"
_EQUALS = "\N{NO-BREAK SPACE}=\N{NO-BREAK SPACE}"


@dataclass(frozen=True)
class Described:
    """A name and what it stands for, in words that are safe in a comment."""

    name: str
    words: str


@dataclass(frozen=True)
class Routine:
    """A function in one language, all but its layout.

    ``heading`` : what the function computes, in a line. ``notes`` : paragraphs, what there is to know and where it comes from.
    ``definitions`` and ``values`` : names (or results) and expressions as text. ``unused`` : arguments on which nothing
    depends. ``helpers`` : what sin(x)/x (``sinc``) and sin(x)/x - 1 (``sincm1``) are called, where a result needs them.
    """

    name: str
    heading: str
    notes: tuple[str, ...]
    arguments: tuple[Described, ...]
    results: tuple[Described, ...]
    definitions: tuple[tuple[str, str], ...]
    values: tuple[tuple[str, str], ...]
    unused: tuple[str, ...]
    helpers: Mapping[str, str]
    uses_pi: bool

    @property
    def listed(self) -> str:
        """The arguments as in a call."""
        return ", ".join(x.name for x in self.arguments)


def laid_out(routine: Routine, language: Language) -> str:
    """The source text of a routine."""
    return "\n".join(_LAYOUTS[language](routine)).rstrip() + "\n"


def _numpy(r: Routine) -> Iterable[str]:
    values = f"{r.name[0].upper()}{r.name[1:]}Values"
    yield from _paragraphs(r, "# ")
    yield from ("", "from typing import NamedTuple", "", "import numpy as np", "", "")
    yield from (f"class {values}(NamedTuple):", '    """Arrays of the broadcast shape of the arguments."""', "")
    yield from (f"    {x.name}: np.ndarray  # {x.words}" for x in r.results)
    yield from ("", "")
    if name := r.helpers.get("sinc"):
        yield from (f"def {name}(x):", f'    """{_SINC}."""')
        yield from ("    return np.where(x == 0.0, 1.0, np.sin(x) / np.where(x == 0.0, 1.0, x))", "", "")
    if name := r.helpers.get("sincm1"):
        yield from (
            f"def {name}(x):",
            f'    """{_SINCM1}."""',
            f"    near = np.minimum(np.abs(x), {SMALL})",
            "    y = 0.0",
        )
        yield from (f"    for n in range({LAST}, 1, -2):", "        y = -near*near/(n*(n - 1))*(1.0 + y)")
        yield from (f"    far = np.where(np.abs(x) > {SMALL}, x, 1.0)",)
        yield from (f"    return np.where(np.abs(x) > {SMALL}, np.sin(far)/far - 1.0, y)", "", "")
    yield from _wrapped(f"def {r.name}({r.listed}):", "    ")
    yield from (f'    """{r.heading}', "", "    Parameters", "    ----------")
    yield from _documented(r.arguments, "    ", " : array_like")
    yield from (
        "",
        "    Returns",
        "    -------",
        f"    {values}",
        "        Arrays of the broadcast shape of the arguments.",
    )
    yield '    """'
    yield from (f"    {x.name} = np.asarray({x.name}, dtype=float)" for x in r.arguments)
    yield from _wrapped(f"    shape = np.broadcast_shapes({', '.join(f'{x.name}.shape' for x in r.arguments)})", "    ")
    yield '    with np.errstate(all="ignore"):  # at a pole the value is inf or nan'
    yield from _statements(r.definitions, "        {} = {}", "        ", "({})")
    yield "        results = ("
    for name, text in r.values:
        yield from (f"            # {name}", *_wrapped(f"            {text},", "            "))
    yield from ("        )", f"    return {values}(*(np.broadcast_to(x, shape).astype(float) for x in results))")


def _c(r: Routine) -> Iterable[str]:
    guard, parameters = f"{r.name.upper()}_H", ", ".join(f"double {x.name}" for x in r.arguments)
    prototype = f"void {r.name}({parameters}, {r.name}_values *values)"
    yield from ("/*", *_paragraphs(r, " * "), " */", f"#ifndef {guard}", f"#define {guard}", "")
    yield from ("/** What the function computes. */", "typedef struct {")
    yield from (f"    double {x.name}; /**< {x.words} */" for x in r.results)
    yield from (f"}} {r.name}_values;", "", "/**", f" * @brief {r.heading}", " *")
    yield from (f" * @param[in] {x.name} {x.words}" for x in r.arguments)
    yield from (
        " * @param[out] values the results",
        " */",
        *_wrapped(f"{prototype};", ""),
        "",
        f"#endif /* {guard} */",
        "",
    )
    yield from ("#include <math.h>", "")
    if name := r.helpers.get("sinc"):
        yield from (f"/* {_SINC} */", f"static double {name}(double x)", "{")
        yield from ("    return x == 0.0 ? 1.0 : sin(x)/x;", "}", "")
    if name := r.helpers.get("sincm1"):
        yield from (f"/* {_SINCM1} */", f"static double {name}(double x)", "{", "    double n, y = 0.0;")
        yield from (f"    if (fabs(x) > {SMALL}) return sin(x)/x - 1.0;", f"    for (n = {LAST}.0; n > 1.0; n -= 2.0)")
        yield from ("        y = -x*x/(n*(n - 1.0))*(1.0 + y);", "    return y;", "}", "")
    yield from (*_wrapped(prototype, ""), "{")
    if r.uses_pi:
        yield "    const double pi = 3.141592653589793;"
    yield from _statements(r.definitions, "    const double {} = {};", "    ")
    yield from (f"    (void){name};" for name in r.unused)
    yield from (*_statements(r.values, "    values->{} = {};", "    "), "}")


def _octave(r: Routine) -> Iterable[str]:
    call = f"values = {r.name}({r.listed})"
    yield from _wrapped(f"function {call}", "  ", " ...")
    yield from (f"%{r.name.upper()}  {r.heading}", *_filled(call, "%   "), "%", "%   Arrays or numbers:")
    yield from _documented(r.arguments, "%   ", "")
    yield from ("%", "%   A struct of arrays of their common size (as by broadcasting):")
    yield from _documented(r.results, "%   values.", "")
    yield from ("%", *_notes(r, "%   "), "")
    yield from _wrapped(f"  zero = zeros(size({' + '.join(x.name for x in r.arguments)}));", "  ", " ...")
    yield from _statements(r.definitions, "  {} = {};", "  ", continued=" ...")
    yield from (*_statements(r.values, "  values.{} = zero + ({});", "  ", continued=" ..."), "end")
    if name := r.helpers.get("sinc"):
        yield from ("", f"function y = {name}(x)", f"% {_SINC}", "  y = ones(size(x));")
        yield from ("  other = x ~= 0;", "  y(other) = sin(x(other))./x(other);", "end")
    if name := r.helpers.get("sincm1"):
        yield from ("", f"function y = {name}(x)", f"% {_SINCM1}", "  y = zeros(size(x));", f"  for n = {LAST}:-2:3")
        yield from ("    y = -x.*x/(n*(n - 1)).*(1 + y);", "  end", f"  other = abs(x) > {SMALL};")
        yield from ("  y(other) = sin(x(other))./x(other) - 1;", "end")


def _javascript(r: Routine) -> Iterable[str]:
    values = f"{r.name[0].upper()}{r.name[1:]}Values"
    yield from ("/*", *_paragraphs(r, " * "), " */", "")
    if name := r.helpers.get("sinc"):
        yield from (f"/** {_SINC} */", f"function {name}(x) {{", "  return x === 0 ? 1 : Math.sin(x)/x;", "}", "")
    if name := r.helpers.get("sincm1"):
        yield from (
            f"/** {_SINCM1} */",
            f"function {name}(x) {{",
            f"  if (Math.abs(x) > {SMALL}) return Math.sin(x)/x - 1;",
        )
        yield from (
            "  let y = 0;",
            f"  for (let n = {LAST}; n > 1; n -= 2) y = -x*x/(n*(n - 1))*(1 + y);",
            "  return y;",
            "}",
            "",
        )
    yield from ("/**", f" * @typedef {{Object}} {values}")
    yield from (f" * @property {{number}} {x.name} {x.words}" for x in r.results)
    yield from (" */", "", "/**", f" * {r.heading}", " *")
    yield from (f" * @param {{number}} {x.name} {x.words}" for x in r.arguments)
    yield from (f" * @returns {{{values}}}", " */", *_wrapped(f"function {r.name}({r.listed}) {{", "  "))
    yield '  "use strict";'
    yield from _statements(r.definitions, "  const {} = {};", "  ")
    yield from ("  return {", *_statements(r.values, "    {}: {},", "    "), "  };", "}", "")
    yield from ('if (typeof module !== "undefined" && module.exports) {', f"  module.exports = {{ {r.name} }};", "}")


_LAYOUTS: Mapping[Language, Callable[[Routine], Iterable[str]]] = {
    Language.NUMPY: _numpy,
    Language.C: _c,
    Language.OCTAVE: _octave,
    Language.JAVASCRIPT: _javascript,
}


def _paragraphs(r: Routine, mark: str) -> Iterable[str]:
    """The header of a file: what is computed, from what, into what."""
    yield from _filled(r.heading, mark)
    yield mark.rstrip()
    for title, described in (("Arguments:", r.arguments), ("Results:", r.results)):
        yield f"{mark}{title}"
        yield from _documented(described, f"{mark}  ", "")
        yield mark.rstrip()
    yield from _notes(r, mark)


def _notes(r: Routine, mark: str) -> Iterable[str]:
    for note in r.notes:
        yield from _filled(note, mark)


def _filled(text: str, mark: str, indent: str = "  ") -> list[str]:
    return textwrap.wrap(text, _WIDTH, initial_indent=mark, subsequent_indent=mark + indent, break_on_hyphens=False)


def _documented(described: Sequence[Described], indent: str, kind: str) -> Iterable[str]:
    """Names with their meanings; with a kind, the meaning in a line below, as NumPy has it."""
    widest = max((len(x.name) for x in described), default=0)
    for x in described:
        if kind:
            yield f"{indent}{x.name}{kind}"
            yield from _filled(x.words, f"{indent}    ", "")
        else:
            yield from _filled(f"{x.name:{widest}}  {x.words}", indent, "    ")


def _statements(
    pairs: Sequence[tuple[str, str]], form: str, indent: str, bracket: str = "{}", continued: str = ""
) -> Iterable[str]:
    """One statement for each pair of a name and an expression; a long one on several lines, in brackets where needed."""
    for name, text in pairs:
        whole = form.format(name, text)
        yield from _wrapped(
            whole if len(whole) <= _WIDTH else form.format(name, bracket.format(text)), indent, continued
        )


def _wrapped(line: str, indent: str, continued: str = "") -> list[str]:
    """A line of code on as many lines as it needs, broken at spaces, each but the last with what continues a line.

    Never at a line's first equals sign, after which Python must see an open bracket.
    """
    if len(line) <= _WIDTH:
        return [line]
    own = line.lstrip()
    lines = textwrap.wrap(
        own.replace(" = ", _EQUALS, 1),
        _WIDTH,
        initial_indent=line[: -len(own)],
        subsequent_indent=f"{indent}    ",
        break_long_words=False,
        break_on_hyphens=False,
    )
    lines = [x.replace(_EQUALS, " = ") for x in lines]
    return [*(f"{x}{continued}" for x in lines[:-1]), lines[-1]]
