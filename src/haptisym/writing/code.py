"""Code in NumPy, C, Octave and MATLAB, or JavaScript: one function that computes a scene's closed
forms, without haptisym.

Each language allows certain names, and lays a routine out in its own way: its documentation, safe
in its comments, and then its statements. The steps of a program become expressions: numbers are the
nearest doubles, and there are no more brackets than are needed. At the end stand the functions that
a user calls: code of a scene, or of a distortion, as a function of omega and of the parameters.
"""

from __future__ import annotations

import keyword
import re
import textwrap
from collections.abc import Callable, Iterable, Mapping, Sequence, Set
from dataclasses import dataclass, field
from enum import Enum, IntEnum
from pathlib import Path
from typing import Any

from flint import ctx, fmpq
from sympy import Add, Expr, Pow, Rational, Symbol, pi, preorder_traversal

from haptisym import __version__
from haptisym.kernel.dynamics import on_axis
from haptisym.kernel.errors import SceneError, quoted
from haptisym.kernel.harmonics import MOST_STEPS
from haptisym.kernel.names import LONGEST, spelt
from haptisym.kernel.reals import ExactNumber, bounds, expression_ball
from haptisym.kernel.rings import omega
from haptisym.model.chain import Chain
from haptisym.model.distortion import Distortion, part_of
from haptisym.model.jnd import Part
from haptisym.model.parameters import Rule, values
from haptisym.model.quantities import Dimension, MotionKind
from haptisym.model.scene import THRESHOLD, Knob, Scene
from haptisym.model.scenefile import as_scene
from haptisym.programs.balls import BallPoint
from haptisym.programs.distortion import closed_program
from haptisym.programs.program import LAST, SMALL, Program
from haptisym.programs.steps import Reader
from haptisym.programs.values import Values
from haptisym.writing.layout import plain as in_line


class Language(Enum):
    """A programming language of ``scene_code`` and ``distortion_code``; its value is the ending of
    its files."""

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
        way = (
            "; for Julia take c, which it calls by ccall, or numpy"
            if str(given).lower() in ("julia", "jl")
            else ""
        )
        raise SceneError(f"language: {quoted(given)} is none of {', '.join(known)}{way}")


def _words(text: str) -> frozenset[str]:
    """The words of a text, as a set."""
    return frozenset(text.split())


# What the code itself may call: a parameter of that name would hide the function.
_FUNCTIONS = _words("abs asin cos exp fabs log max min pow sin sinc sqrt tan pi")
RESERVED: Mapping[Language, frozenset[str]] = {
    Language.NUMPY: _FUNCTIONS
    | {*keyword.kwlist, *keyword.softkwlist, "np", "float", "NamedTuple", "shape", "results"},
    Language.C: _FUNCTIONS
    | _words(
        "alignas alignof asm auto bool break case catch char class const constexpr continue "
        "default delete do double else "
        "enum extern false float for friend goto if inline int long namespace new nullptr "
        "operator private protected public "
        "register restrict return short signed sizeof static static_assert struct switch "
        "template this thread_local throw "
        "true try typedef typename typeof typeof_unqual union unsigned using virtual void "
        "volatile while main values "
        "acos asin atan atan2 ceil cosh sinh tanh floor fmod frexp ldexp log10 modf erf erfc "
        "gamma lgamma tgamma hypot "
        "j0 j1 jn y0 y1 yn cbrt exp2 expm1 log1p log2 logb fma fdim fmax fmin remainder "
        "round trunc rint nan isnan isinf "
        "index linux unix signgam HUGE_VAL INFINITY NAN"
    ),
    Language.OCTAVE: _FUNCTIONS
    | _words(
        "break case catch classdef continue do else elseif end end_try_catch "
        "end_unwind_protect endclassdef endenumeration "
        "endevents endfor endfunction endif endmethods endparfor endproperties endswitch "
        "endwhile enumeration events for "
        "function global if methods otherwise parfor persistent properties return spmd "
        "switch try until unwind_protect "
        "unwind_protect_cleanup while arguments import i j I J e Inf NaN NA eps ans inf nan "
        "true false ones zeros size zero "
        "values nargin nargout"
    ),
    Language.JAVASCRIPT: _FUNCTIONS
    | _words(
        "abstract arguments async await boolean break byte case catch char class const "
        "continue debugger default delete do "
        "double else enum eval export extends false final finally float for function get "
        "goto if implements import in "
        "instanceof int interface let long module native new null of package private "
        "protected public return set short "
        "static super switch synchronized this throw throws transient true try typeof "
        "undefined var void volatile while "
        "with yield Math Infinity NaN Object exports require globalThis window"
    ),
}
"""Words that cannot name a parameter: keywords, and names that the generated code uses itself."""


def identifiers(
    names: Iterable[str], language: Language, taken: Iterable[str] = ()
) -> dict[str, str]:
    """For each name, one that the language allows and that nothing else has: itself where possible,
    else visibly changed.

    >>> identifiers(["m", "lambda", "ζ", "k 1"], Language.NUMPY)
    {'m': 'm', 'lambda': 'lambda_', 'ζ': 'zeta', 'k 1': 'k_1'}
    """
    return spelt(names, {*RESERVED[language], *taken})


def function_name(name: str, language: Language) -> str:
    """The name if the language allows it for a function; SceneError otherwise."""
    if (
        not re.fullmatch("[A-Za-z][A-Za-z0-9_]*", name)
        or len(name) > LONGEST
        or name in RESERVED[language]
    ):
        raise SceneError(
            f'"{name[:80]}" cannot name a function in {language.name}: use at most '
            f"{LONGEST} ASCII letters, digits and _, "
            "a letter in front, and no word that the language has"
        )
    return name


def comment(text: str) -> str:
    """Any text as one line that ends no comment and no string, in any of the languages, and hides
    nothing.

    >>> comment("a */ b\\nc")
    'a * / b c'
    """
    line = "".join(c if c.isprintable() else "?" for c in " ".join(text.split()))
    # A backslash first: what becomes of it must not close a comment with the star before it.
    for mark, harmless in (("\\", "/"), ("*/", "* /"), ("/*", "/ *"), ('"', "'")):
        line = line.replace(mark, harmless)
    return re.sub(r"\?(?=\?)", "? ", line)  # two of them start a trigraph in C


_WIDTH = 100  # columns
_SINC, _SINCM1 = "sin(x)/x, and 1 at x = 0", "sin(x)/x - 1, by its series for small x"
# The first harmonic of a staircase is the midpoint rule, with intervals 2 u wide, for 4/pi times
# the integral of sqrt(1 - x^2) from 0 to 1, which is 1. As that ends in a root, the rule is off by
# 16/pi zeta(-1/2, t) u^(3/2), 0 < t <= 1, and terms of higher order: by 1.06 u^(3/2) at most. With
# more steps than the package sums it is taken as 1.
_FINE = 1 / (2 * MOST_STEPS)
_STAIRS = (
    f"first harmonic of steps q over an amplitude A, u = q/(2 A); 1 up to {_FINE} (off by 1.2e-8)"
)
_EQUALS = "\N{NO-BREAK SPACE}=\N{NO-BREAK SPACE}"


@dataclass(frozen=True)
class Described:
    """A name and what it stands for, in words that are safe in a comment."""

    name: str
    words: str


@dataclass(frozen=True)
class Routine:
    """A function in one language, all but its layout.

    ``heading`` : what the function computes, in a line. ``notes`` : paragraphs, what there is to
    know and where it comes from.
    ``definitions`` and ``values`` : names (or results) and expressions as text. ``unused`` :
    arguments on which nothing depends. ``helpers`` : what sin(x)/x (``sinc``), sin(x)/x - 1
    (``sincm1``) and the first harmonic of a staircase (``quantiser``) are called, where a result
    needs them.
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
    """The source text of a routine, with one line end at its end."""
    return "\n".join(_LAYOUTS[language](routine)).rstrip() + "\n"


def _numpy(r: Routine) -> Iterable[str]:
    """The lines of a module for NumPy: a named tuple of results, helpers, the function."""
    values = f"{r.name[0].upper()}{r.name[1:]}Values"
    yield from _paragraphs(r, "# ")
    yield from ("", "from typing import NamedTuple", "", "import numpy as np", "", "")
    yield from (
        f"class {values}(NamedTuple):",
        '    """Arrays of the broadcast shape of the arguments."""',
        "",
    )
    yield from (f"    {x.name}: np.ndarray  # {x.words}" for x in r.results)
    yield from ("", "")
    if name := r.helpers.get("sinc"):
        yield from (f"def {name}(x):", f'    """{_SINC}."""')
        # np.where computes both branches everywhere, so the division must be one at 0 as well.
        yield from (
            "    return np.where(x == 0.0, 1.0, np.sin(x) / np.where(x == 0.0, 1.0, x))",
            "",
            "",
        )
    if name := r.helpers.get("sincm1"):
        # Both branches run for all x: each has its argument kept where it is sound, the series
        # near 0, the quotient away from 0.
        yield from (
            f"def {name}(x):",
            f'    """{_SINCM1}."""',
            f"    near = np.minimum(np.abs(x), {SMALL})",
            "    y = 0.0",
        )
        yield from (
            f"    for n in range({LAST}, 1, -2):",
            "        y = -near*near/(n*(n - 1))*(1.0 + y)",
        )
        yield from (f"    far = np.where(np.abs(x) > {SMALL}, x, 1.0)",)
        yield from (f"    return np.where(np.abs(x) > {SMALL}, np.sin(far)/far - 1.0, y)", "", "")
    if name := r.helpers.get("quantiser"):
        yield from (
            f"def {name}(u):",
            f'    """{_STAIRS}."""',
            f"    fine = u <= {_FINE}",
            # At 1 there is no step to sum.
            "    u = np.where(fine, 1.0, u)",
            "    total = 0.0*u",
            f"    for n in range(1, {2 * MOST_STEPS}, 2):",
            "        if not np.any(n*u < 1.0):",
            "            break",
            "        total = total + np.sqrt(np.maximum(1.0 - (n*u)**2, 0.0))",
            "    return np.where(fine, 1.0, 8.0/np.pi*u*total)",
            "",
            "",
        )
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
    yield from _wrapped(
        f"    shape = np.broadcast_shapes({', '.join(f'{x.name}.shape' for x in r.arguments)})",
        "    ",
    )
    yield '    with np.errstate(all="ignore"):  # at a pole the value is inf or nan'
    yield from _statements(r.definitions, "        {} = {}", "        ", "({})")
    yield "        results = ("
    for name, text in r.values:
        yield from (f"            # {name}", *_wrapped(f"            {text},", "            "))
    yield from (
        "        )",
        f"    return {values}(*(np.broadcast_to(x, shape).astype(float) for x in results))",
    )


def _c(r: Routine) -> Iterable[str]:
    """The lines of a file for C: the struct and the prototype within an include guard, then the
    functions."""
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
        yield from (
            f"/* {_SINCM1} */",
            f"static double {name}(double x)",
            "{",
            "    double n, y = 0.0;",
        )
        yield from (
            f"    if (fabs(x) > {SMALL}) return sin(x)/x - 1.0;",
            f"    for (n = {LAST}.0; n > 1.0; n -= 2.0)",
        )
        yield from ("        y = -x*x/(n*(n - 1.0))*(1.0 + y);", "    return y;", "}", "")
    if name := r.helpers.get("quantiser"):
        yield from (
            f"/* {_STAIRS} */",
            f"static double {name}(double u)",
            "{",
            "    double n, total = 0.0;",
            f"    if (u <= {_FINE}) return 1.0;",
            "    for (n = 1.0; n*u < 1.0; n += 2.0)",
            "        total += sqrt(1.0 - n*u*(n*u));",
            "    return 8.0/3.141592653589793*u*total;",
            "}",
            "",
        )
    yield from (*_wrapped(prototype, ""), "{")
    if r.uses_pi:
        yield "    const double pi = 3.141592653589793;"
    yield from _statements(r.definitions, "    const double {} = {};", "    ")
    # The cast tells compilers that an argument on which nothing depends is not forgotten.
    yield from (f"    (void){name};" for name in r.unused)
    yield from (*_statements(r.values, "    values->{} = {};", "    "), "}")


def _octave(r: Routine) -> Iterable[str]:
    """The lines of a file for Octave and MATLAB: the function with its help text, then helpers."""
    call = f"values = {r.name}({r.listed})"
    yield from _wrapped(f"function {call}", "  ", " ...")
    yield from (
        f"%{r.name.upper()}  {r.heading}",
        *_filled(call, "%   "),
        "%",
        "%   Arrays or numbers:",
    )
    yield from _documented(r.arguments, "%   ", "")
    yield from ("%", "%   A struct of arrays of their common size (as by broadcasting):")
    yield from _documented(r.results, "%   values.", "")
    yield from ("%", *_notes(r, "%   "), "")
    yield from _wrapped(
        f"  zero = zeros(size({' + '.join(x.name for x in r.arguments)}));", "  ", " ..."
    )
    # ``zero`` gives every result the common size of the arguments, also a constant.
    yield from _statements(r.definitions, "  {} = {};", "  ", continued=" ...")
    yield from (*_statements(r.values, "  values.{} = zero + ({});", "  ", continued=" ..."), "end")
    if name := r.helpers.get("sinc"):
        yield from ("", f"function y = {name}(x)", f"% {_SINC}", "  y = ones(size(x));")
        yield from ("  other = x ~= 0;", "  y(other) = sin(x(other))./x(other);", "end")
    if name := r.helpers.get("sincm1"):
        yield from (
            "",
            f"function y = {name}(x)",
            f"% {_SINCM1}",
            "  y = zeros(size(x));",
            f"  for n = {LAST}:-2:3",
        )
        yield from ("    y = -x.*x/(n*(n - 1)).*(1 + y);", "  end", f"  other = abs(x) > {SMALL};")
        yield from ("  y(other) = sin(x(other))./x(other) - 1;", "end")
    if name := r.helpers.get("quantiser"):
        yield from (
            "",
            f"function y = {name}(u)",
            f"% {_STAIRS}",
            f"  fine = u <= {_FINE};",
            "  u(fine) = 1;",
            "  y = zeros(size(u));",
            "  n = 1;",
            "  while any(n*u(:) < 1)",
            "    y = y + sqrt(max(1 - (n*u).^2, 0));",
            "    n = n + 2;",
            "  end",
            "  y = 8/pi*u.*y;",
            "  y(fine) = 1;",
            "end",
        )


def _javascript(r: Routine) -> Iterable[str]:
    """The lines of a script for browsers, which is also a module for Node."""
    values = f"{r.name[0].upper()}{r.name[1:]}Values"
    yield from ("/*", *_paragraphs(r, " * "), " */", "")
    if name := r.helpers.get("sinc"):
        yield from (
            f"/** {_SINC} */",
            f"function {name}(x) {{",
            "  return x === 0 ? 1 : Math.sin(x)/x;",
            "}",
            "",
        )
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
    if name := r.helpers.get("quantiser"):
        yield from (
            f"/** {_STAIRS} */",
            f"function {name}(u) {{",
            f"  if (u <= {_FINE}) return 1;",
            "  let total = 0;",
            "  for (let n = 1; n*u < 1; n += 2) total += Math.sqrt(1 - n*u*(n*u));",
            "  return 8/Math.PI*u*total;",
            "}",
            "",
        )
    yield from ("/**", f" * @typedef {{Object}} {values}")
    yield from (f" * @property {{number}} {x.name} {x.words}" for x in r.results)
    yield from (" */", "", "/**", f" * {r.heading}", " *")
    yield from (f" * @param {{number}} {x.name} {x.words}" for x in r.arguments)
    yield from (
        f" * @returns {{{values}}}",
        " */",
        *_wrapped(f"function {r.name}({r.listed}) {{", "  "),
    )
    yield '  "use strict";'
    yield from _statements(r.definitions, "  const {} = {};", "  ")
    yield from ("  return {", *_statements(r.values, "    {}: {},", "    "), "  };", "}", "")
    yield from (
        'if (typeof module !== "undefined" && module.exports) {',
        f"  module.exports = {{ {r.name} }};",
        "}",
    )


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
    """The notes in lines of a comment."""
    for note in r.notes:
        yield from _filled(note, mark)


def _filled(text: str, mark: str, indent: str = "  ") -> list[str]:
    """A text in lines that begin with the mark of a comment."""
    return textwrap.wrap(
        text, _WIDTH, initial_indent=mark, subsequent_indent=mark + indent, break_on_hyphens=False
    )


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
    pairs: Sequence[tuple[str, str]],
    form: str,
    indent: str,
    bracket: str = "{}",
    continued: str = "",
) -> Iterable[str]:
    """One statement for each pair of a name and an expression; a long one on several lines, in
    brackets where needed."""
    for name, text in pairs:
        whole = form.format(name, text)
        yield from _wrapped(
            whole if len(whole) <= _WIDTH else form.format(name, bracket.format(text)),
            indent,
            continued,
        )


def _wrapped(line: str, indent: str, continued: str = "") -> list[str]:
    """A line of code on as many lines as it needs, broken at spaces, each but the last with what
    continues a line.

    Never at a line's first equals sign, after which Python must see an open bracket.
    """
    if len(line) <= _WIDTH:
        return [line]
    statement = line.lstrip()
    # No-break spaces keep ``wrap`` from breaking there; they become spaces again below.
    lines = textwrap.wrap(
        statement.replace(" = ", _EQUALS, 1),
        _WIDTH,
        initial_indent=line[: -len(statement)],
        subsequent_indent=f"{indent}    ",
        break_long_words=False,
        break_on_hyphens=False,
    )
    lines = [x.replace(_EQUALS, " = ") for x in lines]
    return [*(f"{x}{continued}" for x in lines[:-1]), lines[-1]]


# Expressions.


@dataclass(frozen=True)
class Dialect:
    """How a language writes arithmetic; ``functions`` : those that it calls by another name;
    ``whole`` : whether a whole number may be written without a point."""

    # Not in C, where 1/2 divides integers and is 0.
    power: str
    library: str = ""
    functions: Mapping[str, str] = field(default_factory=dict)
    pi: str = "pi"
    times: str = "*"
    over: str = "/"
    whole: bool = True


DIALECTS: Mapping[Language, Dialect] = {
    Language.NUMPY: Dialect(
        "{}**{}", "np.", {"asin": "arcsin", "max": "maximum", "min": "minimum"}, pi="np.pi"
    ),
    Language.C: Dialect(
        "pow({}, {})", functions={"abs": "fabs", "max": "fmax", "min": "fmin"}, whole=False
    ),
    Language.OCTAVE: Dialect("{}.^{}", times=".*", over="./"),
    Language.JAVASCRIPT: Dialect("Math.pow({}, {})", "Math.", pi="Math.PI"),
}


class Precedence(IntEnum):
    """What an expression is; only a greater kind needs no brackets as a factor."""

    SUM = 0
    QUOTIENT = 1
    PRODUCT = 2
    POWER = 3
    ATOM = 4


@dataclass(frozen=True)
class CodePiece:
    """An expression of some kind as text; a negative product or quotient begins with its minus."""

    text: str
    kind: Precedence = Precedence.ATOM

    @property
    def is_negative(self) -> bool:
        """Whether it begins with a minus that a sum can take over."""
        return self.text.startswith("-") and self.kind is not Precedence.SUM

    @property
    def unsigned(self) -> str:
        """The expression without that minus."""
        return self.text[1:]

    def at_least(self, kind: Precedence) -> str:
        """The text, in brackets unless it is of this kind or a greater one, and has no minus."""
        return self.text if self.kind >= kind and not self.is_negative else f"({self.text})"

    @property
    def as_first(self) -> str:
        """The text as the first operand of a product: only a sum needs brackets there."""
        return f"({self.text})" if self.kind is Precedence.SUM else self.text


@dataclass(kw_only=True)
class CodeReader(Reader[CodePiece]):
    """Reads a program as expressions of a language.

    ``names`` : what the arguments are called; ``helpers`` : what computes ``sinc`` and the like.

    >>> from haptisym.programs.program import Writer
    >>> from sympy import sqrt
    >>> a, b = Symbol("a"), Symbol("b")
    >>> write = Writer((a, b))
    >>> program = write.program({"y": write.expression(pi - sqrt(a) * (a - b) / 3)})
    >>> for language in Language:
    ...     reader = CodeReader(program, {"a", "b"}, dialect=DIALECTS[language], names={a: "a", b: "b"})
    ...     reader.results()["y"].text
    'np.pi - 0.3333333333333333*np.sqrt(a)*(a - b)'
    'pi - 0.3333333333333333*sqrt(a)*(a - b)'
    'pi - 0.3333333333333333.*sqrt(a).*(a - b)'
    'Math.PI - 0.3333333333333333*Math.sqrt(a)*(a - b)'
    """

    dialect: Dialect
    names: Mapping[Symbol, str]
    helpers: Mapping[str, str] = field(default_factory=dict)

    def input(self, symbol: Symbol) -> CodePiece:
        """The name of an argument."""
        return CodePiece(self.names[symbol])

    def constant(self, value: Any) -> CodePiece:
        """The nearest double, as the language writes it."""
        if value == pi:
            return CodePiece(self.dialect.pi)
        number = nearest_double(
            Rational(int(value.p), int(value.q)) if isinstance(value, fmpq) else value
        )
        is_whole = self.dialect.whole and number.is_integer() and abs(number) < 1e15
        return CodePiece(
            str(int(number)) if is_whole else repr(number),
            Precedence.PRODUCT if number < 0 else Precedence.ATOM,
        )

    def name(self, name: str) -> CodePiece:
        """The name of an intermediate value."""
        return CodePiece(name)

    def is_name(self, value: CodePiece) -> bool:
        """Whether a value is a mere name, perhaps with a minus."""
        return value.text.removeprefix("-").isidentifier()

    def made(self, operation: str, *arguments: CodePiece) -> CodePiece:
        """An operation, as the language writes it."""
        if operation in ("add", "sub", "mul", "div", "neg", "power"):
            piece: CodePiece = getattr(self, f"_{operation}")(*arguments)
            return piece
        own = self.dialect.library + self.dialect.functions.get(operation, operation)
        listed = ", ".join(x.text for x in arguments)
        return CodePiece(f"{self.helpers.get(operation, own)}({listed})")

    def _add(self, x: CodePiece, y: CodePiece) -> CodePiece:
        # x + y and y + x are the same double, so the order is free: first what has no minus, then
        # a sum, which needs no brackets there. A sum in second place keeps its brackets, as
        # addition of doubles is not associative.
        if (x.is_negative, y.kind is Precedence.SUM) > (y.is_negative, x.kind is Precedence.SUM):
            x, y = y, x
        return (
            self._sub(x, self._neg(y))
            if y.is_negative
            else CodePiece(f"{x.text} + {y.as_first}", Precedence.SUM)
        )

    def _sub(self, x: CodePiece, y: CodePiece) -> CodePiece:
        return CodePiece(
            f"{x.text} + {y.unsigned}" if y.is_negative else f"{x.text} - {y.as_first}",
            Precedence.SUM,
        )

    def _neg(self, x: CodePiece) -> CodePiece:
        # A minus binds less than a power, so nothing with a minus counts as more than a product.
        if x.is_negative:
            return CodePiece(x.unsigned, x.kind)
        return CodePiece(
            f"-{x.as_first}", min(Precedence.PRODUCT, max(x.kind, Precedence.QUOTIENT))
        )

    def _mul(self, x: CodePiece, y: CodePiece) -> CodePiece:
        # Commutative as well: first what would need brackets in second place, or reads better.
        if _leads(y) > _leads(x):
            x, y = y, x
        kind = Precedence.QUOTIENT if x.kind is Precedence.QUOTIENT else Precedence.PRODUCT
        return CodePiece(f"{x.as_first}{self.dialect.times}{y.at_least(Precedence.PRODUCT)}", kind)

    def _div(self, x: CodePiece, y: CodePiece) -> CodePiece:
        return CodePiece(
            f"{x.as_first}{self.dialect.over}{y.at_least(Precedence.POWER)}", Precedence.QUOTIENT
        )

    def _power(self, x: CodePiece, y: CodePiece) -> CodePiece:
        # IEEE 754 asks for a correctly rounded square root, and leaves the accuracy of powers open.
        if y.text == "0.5":
            return self.made("sqrt", x)
        # A function call has brackets of its own; an operator needs them around all but atoms.
        if self.dialect.power.endswith(")"):
            return CodePiece(self.dialect.power.format(x.text, y.text))
        sides = x.at_least(Precedence.ATOM), y.at_least(Precedence.ATOM)
        return CodePiece(self.dialect.power.format(*sides), Precedence.POWER)


def _leads(x: CodePiece) -> int:
    """Which factor stands first: what begins with a minus, then numbers, then a quotient."""
    if x.is_negative:
        return 3
    if x.text[0].isdigit():
        return 2
    return 1 if x.kind is Precedence.QUOTIENT else 0


def nearest_double(number: Expr) -> float:
    """The double nearest to an exact number; SceneError where none is near.

    >>> from sympy import Rational
    >>> nearest_double(Rational(1, 3)), nearest_double(40 * pi)
    (0.3333333333333333, 125.66370614359172)
    """
    try:
        return 0.0 if _vanishes(number) else float(ExactNumber(number))
    except OverflowError:
        raise SceneError(
            f"{str(number)[:60]} is too large for a double, whose largest is 1.8e308"
        ) from None


def _vanishes(number: Expr) -> bool:
    """Whether a number made with roots is below 1e-600 of what it is a sum of: zero, or nothing
    beside any double."""
    # Without a sum nothing cancels, and a number that is not written as 0 is none.
    if not any(isinstance(x, Add) for x in preorder_traversal(number)):
        return False
    # Whether a sum of roots is exactly 0 can be hard to decide. It need not be: with 4096 bits, a
    # ball that contains 0 is far below the smallest double relative to its terms.
    with ctx.workprec(4096):
        low, high = bounds(expression_ball(number))
    return low <= 0 <= high


@dataclass(frozen=True)
class Argument:
    """What a function is given: its symbol, unit, meaning, the values it may have and, where there
    is one, an example."""

    symbol: Symbol
    unit: str = "SI units"
    meaning: str = "parameter"
    range: str = ""
    example: str = ""


@dataclass(frozen=True)
class About:
    """What the header of a file says: a title, paragraphs of notes, and for each result what it is
    and its unit."""

    title: str = ""
    notes: tuple[str, ...] = ()
    results: Mapping[str, tuple[str, str]] | None = None


@dataclass(frozen=True)
class Source:
    """All that code in any language is written from: what is computed, from what, and what is said
    about it."""

    program: Program
    arguments: tuple[Argument, ...]
    about: About = About()

    def code(self, language: Language | str, *, name: str = "distortion") -> str:
        """The text of one function that computes the program, self-contained, documented in the
        language's own style.

        ``arguments`` are all that the program needs, in the order of the call. NumPy, Octave and
        MATLAB functions take and return arrays (broadcast, shape kept, constants included); C fills
        a struct of doubles, its declarations first, in an include guard; JavaScript returns an
        object. Numbers are the doubles nearest to the exact ones. A name that the language does not
        allow is changed, and the documentation says so.
        Raises SceneError for a missing or doubled argument, and for a name that cannot be a
        function's.

        >>> from haptisym.programs.program import Writer
        >>> k = Argument(Symbol("k"), "N/m", "stiffness", "> 0")
        >>> write = Writer((k.symbol,))
        >>> third = write.program({"y": write.expression(k.symbol / 3)})
        >>> print(Source(third, (k,)).code(Language.JAVASCRIPT, name="third").split("*/")[-1])
        <BLANKLINE>
        function third(k) {
          "use strict";
          return {
            y: 0.3333333333333333*k,
          };
        }
        <BLANKLINE>
        if (typeof module !== "undefined" && module.exports) {
          module.exports = { third };
        }
        <BLANKLINE>
        """
        language, program, listed = Language.of(language), self.program, self.arguments
        inputs = (step for step in program.operations if step.name == "input")
        used = {program.inputs[step.arguments[0]] for step in inputs}
        _check(program, used, listed)
        function = function_name(name, language)
        helpers = {kind: f"{function}_{kind}" for kind in ("sinc", "sincm1", "quantiser")}
        # Names of the struct or class of results, in any language; arguments must not take them.
        results = {f"{function}_values", f"{function[0].upper()}{function[1:]}Values"}
        taken = {function, *helpers.values(), *results}
        chosen = identifiers((a.symbol.name for a in listed), language, taken)
        names = {a.symbol: chosen[a.symbol.name] for a in listed}
        reader = CodeReader(
            program,
            {*taken, *names.values(), *RESERVED[language]},
            dialect=DIALECTS[language],
            names=names,
            helpers=helpers,
        )
        values = {x: piece.text for x, piece in reader.results().items()}
        operations = {step.name for step in program.operations}
        routine = Routine(
            name=function,
            heading=comment(self.about.title or "Values of closed forms.").rstrip(".") + ".",
            notes=tuple(
                comment(x) for x in (*self.about.notes, f"Generated by haptisym {__version__}.")
            ),
            arguments=tuple(
                Described(names[a.symbol], _argument_words(a, names, used)) for a in listed
            ),
            results=tuple(Described(x, _result_words(x, self.about)) for x in values),
            definitions=tuple((x, piece.text) for x, piece in reader.definitions),
            values=tuple(values.items()),
            unused=tuple(names[a.symbol] for a in listed if a.symbol not in used),
            helpers={kind: helper for kind, helper in helpers.items() if kind in operations},
            uses_pi=any(step.value == pi for step in program.operations),
        )
        return laid_out(routine, language)


def _check(program: Program, used: Set[Symbol], arguments: tuple[Argument, ...]) -> None:
    """SceneError unless the arguments are all that the program needs, each of them once."""
    symbols = [a.symbol for a in arguments]
    doubled = next((x for x in symbols if symbols.count(x) > 1), None)
    if doubled is not None:
        raise SceneError(f"{doubled} is an argument twice")
    if missing := used - set(symbols):
        raise SceneError(
            f"the steps need {', '.join(sorted(map(str, missing)))}, which is no argument"
        )
    if not program.results or not arguments:
        raise SceneError("a function needs at least one argument and one result")


def _argument_words(argument: Argument, names: Mapping[Symbol, str], used: Set[Symbol]) -> str:
    """What a comment says about an argument: meaning, unit, range, example, and its name in the
    formulas where the language does not allow that one."""
    symbol = argument.symbol.name
    words = [
        ", ".join(x for x in (argument.meaning, argument.unit) if x),
        argument.range,
        argument.example,
    ]
    words += [f"called {symbol} in the formulas"] if names[argument.symbol] != symbol else []
    words += ["no result depends on it"] if argument.symbol not in used else []
    return comment("; ".join(x for x in words if x))


def _result_words(name: str, about: About) -> str:
    """What a comment says about a result: its meaning and unit."""
    meaning, unit = (about.results or {}).get(name, ("result", ""))
    return comment(f"{meaning}, {unit}" if unit else meaning)


# Scenes and distortions.


FREQUENCY = Argument(omega, "rad/s", "angular frequency", ">= 0")
_MEANINGS = {
    "real": "Re dH, the real part of the distortion dH = H_perc - H_env",
    "imag": "Im dH",
    "ratio_real": "r_r = |Re dH|/|H_env|, what the JND judges, a ratio",
    "ratio_imag": "r_i = |Im dH|/|H_env|, what the JND judges, a ratio",
    "relative_real": "Re(dH/H_env), which is not r_r, a ratio",
    "relative_imag": "Im(dH/H_env), which is not r_i, a ratio",
    "environment_real": "Re H_env, what should be felt",
    "environment_imag": "Im H_env",
    "perceived_real": "Re H_perc, what is felt",
    "perceived_imag": "Im H_perc",
}
_NOTES = (
    (
        "H is force per position at s = j omega. Re H > 0 is felt as stiffness Re H, Re H < 0 as "
        "mass -Re H/omega^2."
    ),
    "At omega = 0 the values are the limits where these are finite. At a pole they are Inf or NaN.",
    "At a zero of H_env 0/0 is NaN, where compile() of haptisym gives the limit.",
    (
        "An argument that is 0 may make 0/0 there, which is NaN: a term that is not there is "
        "better left out of the scene."
    ),
)


def scene_code(
    scene: Scene | str | Path,
    language: Language | str,
    *,
    name: str = "distortion",
    parameters: Iterable[str] | None = None,
) -> str:
    """The closed forms of a scene as a function of omega and of its parameters.

    ``parameters`` : the names of those that stay arguments, in SI; all by default, none for ``()``.
    The others have the scene's values in the code. The results are Re and Im of dH, of dH/H_env, of
    H_env and of H_perc, and the ratios r_r and r_i. Raises SceneError for a parameter that the
    scene does not have.

    With sums of squares for moduli and half angles for delays, each part has an error below 1e-12
    (|H_env| + |H_perc|), the ratios and relative parts below 1e-12 (1 + |H_perc|/|H_env|): tested
    for every shipped scene, with its values and with values around them, at omega = 0 and up to
    10^4 rad/s.

    >>> from haptisym.model.scenefile import load_scene
    >>> text = scene_code(load_scene("fu2019"), Language.C, parameters=["omega_n"])
    >>> next(line for line in text.splitlines() if line.startswith("void"))
    'void distortion(double omega, double omega_n, distortion_values *values);'
    """
    return scene_program(scene, parameters).code(language, name=name)


def scene_program(scene: Scene | str | Path, parameters: Iterable[str] | None = None) -> Source:
    """What ``scene_code`` prints, with the same parameters, derived once for several languages.

    >>> from haptisym.model.scenefile import load_scene
    >>> [x.symbol.name for x in scene_program(load_scene("delayed-spring")).arguments]
    ['omega', 'k', 'tau']
    """
    scene = as_scene(scene)
    free = (
        list(scene.parameters)
        if parameters is None
        else [scene.knobs[name].felt() for name in parameters]
    )
    limit = next((x for x in free if x.parts), None)
    if limit is not None:
        raise SceneError(f"{limit.path} is a threshold, of which code holds nothing: leave it out")
    fixed = values(x for x in scene.parameters if x not in free)
    chain = scene.chain.replaced(fixed)
    # In the order of the scene, whatever the order that the names were given in.
    arguments = [_argument(x, scene.motion) for x in scene.parameters if x in free]
    arguments += [Argument(x) for x in chain.parameters if x not in {a.symbol for a in arguments}]
    about = About(
        scene.title or "Distortion of a haptic display",
        _scene_notes(scene, fixed),
        _results(scene.motion),
    )
    return Source(computed(chain), (FREQUENCY, *arguments), about)


def distortion_code(
    distortion: Distortion, language: Language | str, *, name: str = "distortion"
) -> str:
    """The closed forms of a distortion as a function of omega and of the parameters that are still
    symbols, by name.

    >>> from haptisym import effects, environments
    >>> from haptisym.model.distortion import distort
    >>> d = distort(environments.kelvin_voigt(100, 2), effects.delay(Symbol("tau")))
    >>> "function values = distortion(omega, tau)" in distortion_code(d, Language.OCTAVE)
    True
    """
    arguments = [FREQUENCY, *(Argument(x) for x in sorted(distortion.free_symbols, key=str))]
    notes = (
        f"H_env(s) = {_formula(distortion.environment)}",
        f"H_perc(s) = {_formula(distortion.perceived)}",
        *_NOTES,
    )
    about = About("Distortion of a haptic display", notes, _results(None))
    return Source(computed(distortion.needed_chain), tuple(arguments), about).code(
        language, name=name
    )


def computed(chain: Chain) -> Program:
    """The fields of ``Values``, in its order: the program that ``compile`` runs, if no value of it
    is a limit, else that of the closed forms."""
    # ``compile`` takes limits where a value is 0/0; plain code cannot, and common factors that make
    # 0/0 are cancelled in closed forms.
    program = chain.program(Values._fields)
    return program if _has_no_limits(chain, program) else closed(chain)


def closed(chain: Chain) -> Program:
    """The program of the same values from the closed forms, in lowest terms."""
    d = Distortion.of(chain)
    dynamics = (d.env.numerator, d.env.denominator, d.perc.denominator)
    factors: list[Any] = []
    for polynomial in dynamics:
        factors.extend(p for p, _ in d.env.ring.factors(polynomial, in_square=False)[1])
    return closed_program(d.functions(Values._fields), factors, chain.parameters)


def _has_no_limits(chain: Chain, program: Program) -> bool:
    """Whether all values are values: Re and Im of H_env have no zero in common, and nothing is 0/0
    at 0."""
    environment = on_axis(chain.ring.convert(chain.environment).reduced())
    R, X = (part_of(environment, part).function.numerator for part in Part)
    apart = R.is_zero() or X.is_zero() or R.gcd(X).is_constant()
    # omega = 0, and for each parameter another generic value, exact as a double: a step that
    # divides by 0 there has a ball that is not finite.
    parameters = (1.25 + n / 8 for n in range(len(program.inputs) - 1))
    at_zero = BallPoint(program, (0.0, *parameters))
    return apart and all(x.is_finite() for x in at_zero.balls(128).values())


def _results(motion: MotionKind | None) -> dict[str, tuple[str, str]]:
    """Meaning and unit of each result; ratios have none."""
    force = Dimension.STIFFNESS.unit(motion)
    return {
        name: (words, "" if name.startswith(("ratio", "relative")) else force)
        for name, words in _MEANINGS.items()
    }


def _formula(expression: Expr) -> str:
    """A formula as a line of text."""
    plainly = all(x.exp.is_number for x in expression.atoms(Pow))
    return in_line(expression) if plainly else str(expression).replace("**", "^")


def _scene_notes(scene: Scene, fixed: Mapping[Symbol, Expr]) -> tuple[str, ...]:
    """The notes in the header of a scene's code: its dynamics, effects, fixed values, remarks and
    source."""
    effects = [f"{e.name} ({e.model})" if e.name != e.model else e.name for e in scene.effects]
    chain = ", ".join(effects) or "none"
    rendered = [f"Rendered instead: {_formula(scene.rendering.dynamics)}"] if scene.rendered else []
    given = ", ".join(
        f"{p.symbol} = {_formula(p.value)}" for p in scene.parameters if p.symbol in fixed
    )
    limits = [THRESHOLD] if scene.knobs.limits else []  # a polygon has none
    return (
        f"H_env(s) = {_formula(scene.environment.dynamics)} ({scene.environment.model})",
        *rendered,
        f"H_perc: through these effects, nearest the environment first: {chain}.",
        *([f"Fixed values, SI: {given}."] if given else []),
        *scene.asides([*limits, *(x.path for x in scene.parameters if x.symbol not in fixed)]),
        *_NOTES,
        *([f"Source: {scene.source}"] if scene.source else []),
    )


_LABELS = {"environment": "the environment", "rendered": "what is rendered"}


_RANGES = {
    Rule.POSITIVE: "> 0",
    Rule.NONNEGATIVE: ">= 0",
    Rule.FRACTION: "between 0 and 1",
    Rule.ANY: "any sign",
}


def _argument(parameter: Knob, motion: MotionKind | None) -> Argument:
    """The argument for a parameter of a scene."""
    dimension = parameter.dimension
    kind = "number" if dimension in (Dimension.ANY, Dimension.RATIO) else dimension.name.lower()
    unit = "" if dimension is Dimension.RATIO else parameter.unit_in(motion) or "SI units"
    effect = parameter.place.partition(".")[2]
    label = _LABELS.get(parameter.place) or f"the effect {effect}"
    meaning = f"{kind} {parameter.key} of {label}"
    # An effect without a name of its own is called by its model, which is not repeated then.
    if not label.endswith(f" {parameter.model}"):
        meaning += f" ({parameter.model})"
    example = ""
    if parameter.value.is_number:
        example = f"{nearest_double(parameter.value):.12g} in the scene"
    return Argument(parameter.symbol, unit, meaning, _RANGES.get(parameter.rule, ""), example)
