"""Code in NumPy, C, Octave and MATLAB, or JavaScript: one function that computes a program, without haptisym.

The steps of the program become expressions: numbers are the nearest doubles, and there are no more brackets than are needed.
"""

from __future__ import annotations

from collections.abc import Mapping, Set
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Any

from flint import ctx, fmpq
from sympy import Add, Expr, Rational, Symbol, pi, preorder_traversal

from haptisym import __version__
from haptisym.kernel.errors import SceneError
from haptisym.kernel.reals import ExactNumber, bounds, expression_ball
from haptisym.programs.program import Program
from haptisym.programs.steps import Reader
from haptisym.writing.code.languages import (
    RESERVED,
    Described,
    Language,
    Routine,
    comment,
    function_name,
    identifiers,
    laid_out,
)


@dataclass(frozen=True)
class Dialect:
    """How a language writes arithmetic; ``whole`` : whether a whole number may be written without a point."""

    power: str
    library: str = ""
    absolute: str = "abs"
    pi: str = "pi"
    times: str = "*"
    over: str = "/"
    whole: bool = True


DIALECTS: Mapping[Language, Dialect] = {
    Language.NUMPY: Dialect("{}**{}", "np.", pi="np.pi"),
    Language.C: Dialect("pow({}, {})", absolute="fabs", whole=False),
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
        """Without that minus."""
        return self.text[1:]

    def at_least(self, kind: Precedence) -> str:
        """In brackets unless it is of this kind or a greater one, and has no minus."""
        return self.text if self.kind >= kind and not self.is_negative else f"({self.text})"

    @property
    def as_first(self) -> str:
        """As the first operand of a product."""
        return f"({self.text})" if self.kind is Precedence.SUM else self.text


@dataclass(kw_only=True)
class CodeReader(Reader[CodePiece]):
    """``names`` : what the arguments are called; ``helpers`` : what computes ``sinc`` and ``sincm1``.

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
        number = nearest_double(Rational(int(value.p), int(value.q)) if isinstance(value, fmpq) else value)
        is_whole = self.dialect.whole and number.is_integer() and abs(number) < 1e15
        return CodePiece(
            str(int(number)) if is_whole else repr(number), Precedence.PRODUCT if number < 0 else Precedence.ATOM
        )

    def name(self, name: str) -> CodePiece:
        """A name."""
        return CodePiece(name)

    def is_name(self, value: CodePiece) -> bool:
        return value.text.removeprefix("-").isidentifier()

    def made(self, operation: str, *arguments: CodePiece) -> CodePiece:
        """An operation, as the language writes it."""
        if operation in ("add", "sub", "mul", "div", "neg", "power"):
            piece: CodePiece = getattr(self, f"_{operation}")(*arguments)
            return piece
        known = {**self.helpers, "abs": f"{self.dialect.library}{self.dialect.absolute}"}
        return CodePiece(f"{known.get(operation, self.dialect.library + operation)}({arguments[0].text})")

    def _add(self, x: CodePiece, y: CodePiece) -> CodePiece:
        if (x.is_negative, y.kind is Precedence.SUM) > (y.is_negative, x.kind is Precedence.SUM):
            x, y = y, x
        return self._sub(x, self._neg(y)) if y.is_negative else CodePiece(f"{x.text} + {y.as_first}", Precedence.SUM)

    def _sub(self, x: CodePiece, y: CodePiece) -> CodePiece:
        return CodePiece(f"{x.text} + {y.unsigned}" if y.is_negative else f"{x.text} - {y.as_first}", Precedence.SUM)

    def _neg(self, x: CodePiece) -> CodePiece:
        if x.is_negative:
            return CodePiece(x.unsigned, x.kind)
        return CodePiece(f"-{x.as_first}", min(Precedence.PRODUCT, max(x.kind, Precedence.QUOTIENT)))

    def _mul(self, x: CodePiece, y: CodePiece) -> CodePiece:
        if _leads(y) > _leads(x):
            x, y = y, x
        kind = Precedence.QUOTIENT if x.kind is Precedence.QUOTIENT else Precedence.PRODUCT
        return CodePiece(f"{x.as_first}{self.dialect.times}{y.at_least(Precedence.PRODUCT)}", kind)

    def _div(self, x: CodePiece, y: CodePiece) -> CodePiece:
        return CodePiece(f"{x.as_first}{self.dialect.over}{y.at_least(Precedence.POWER)}", Precedence.QUOTIENT)

    def _power(self, x: CodePiece, y: CodePiece) -> CodePiece:
        if y.text == "0.5":
            return self.made("sqrt", x)
        if self.dialect.power.endswith(")"):
            return CodePiece(self.dialect.power.format(x.text, y.text))
        sides = x.at_least(Precedence.ATOM), y.at_least(Precedence.ATOM)
        return CodePiece(self.dialect.power.format(*sides), Precedence.POWER)


def _leads(x: CodePiece) -> int:
    """Which factor stands first: what begins with a minus, then numbers, then a quotient."""
    return 3 if x.is_negative else 2 if x.text[0].isdigit() else 1 if x.kind is Precedence.QUOTIENT else 0


def nearest_double(number: Expr) -> float:
    """The double nearest to an exact number; SceneError where none is near.

    >>> from sympy import Rational
    >>> nearest_double(Rational(1, 3)), nearest_double(40 * pi)
    (0.3333333333333333, 125.66370614359172)
    """
    try:
        return 0.0 if _vanishes(number) else float(ExactNumber(number))
    except OverflowError:
        raise SceneError(f"{str(number)[:60]} is too large for a double, whose largest is 1.8e308") from None


def _vanishes(number: Expr) -> bool:
    """Whether a number made with roots is below 1e-600 of what it is a sum of: zero, or nothing beside any double."""
    if not any(isinstance(x, Add) for x in preorder_traversal(number)):
        return False
    with ctx.workprec(4096):
        low, high = bounds(expression_ball(number))
    return low <= 0 <= high


@dataclass(frozen=True)
class Argument:
    """What a function is given: its symbol, unit, meaning, the values it may have and, where there is one, an example."""

    symbol: Symbol
    unit: str = "SI units"
    meaning: str = "parameter"
    range: str = ""
    example: str = ""


@dataclass(frozen=True)
class About:
    """What the header of a file says: a title, paragraphs of notes, and for each result what it is and its unit."""

    title: str = ""
    notes: tuple[str, ...] = ()
    results: Mapping[str, tuple[str, str]] | None = None


@dataclass(frozen=True)
class Source:
    """All that code in any language is written from: what is computed, from what, and what is said about it."""

    program: Program
    arguments: tuple[Argument, ...]
    about: About = About()

    def code(self, language: Language | str, *, name: str = "distortion") -> str:
        """The text of one function that computes the program, self-contained, documented in the language's own style.

        ``arguments`` are all that the program needs, in the order of the call. NumPy, Octave and MATLAB functions take and
        return arrays (broadcast, shape kept, constants included); C fills a struct of doubles,
        its declarations first, in an include guard; JavaScript returns an object. Numbers are the doubles nearest to the exact
        ones. A name that the language does not allow is changed, and the documentation says so.
        Raises SceneError for a missing or doubled argument, and for a name that cannot be a function's.

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
        used = {program.inputs[step.arguments[0]] for step in program.operations if step.name == "input"}
        _check(program, used, listed)
        own = function_name(name, language)
        helpers = {kind: f"{own}_{kind}" for kind in ("sinc", "sincm1")}
        taken = {own, *helpers.values(), f"{own}_values", f"{own[0].upper()}{own[1:]}Values"}
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
            name=own,
            heading=comment(self.about.title or "Values of closed forms.").rstrip(".") + ".",
            notes=tuple(comment(x) for x in (*self.about.notes, f"Generated by haptisym {__version__}.")),
            arguments=tuple(Described(names[a.symbol], _argument_words(a, names, used)) for a in listed),
            results=tuple(Described(x, _result_words(x, self.about)) for x in values),
            definitions=tuple((x, piece.text) for x, piece in reader.definitions),
            values=tuple(values.items()),
            unused=tuple(names[a.symbol] for a in listed if a.symbol not in used),
            helpers={kind: helper for kind, helper in helpers.items() if kind in operations},
            uses_pi=any(step.value == pi for step in program.operations),
        )
        return laid_out(routine, language)


def _check(program: Program, used: Set[Symbol], arguments: tuple[Argument, ...]) -> None:
    symbols = [a.symbol for a in arguments]
    doubled = next((x for x in symbols if symbols.count(x) > 1), None)
    if doubled is not None:
        raise SceneError(f"{doubled} is an argument twice")
    if missing := used - set(symbols):
        raise SceneError(f"the steps need {', '.join(sorted(map(str, missing)))}, which is no argument")
    if not program.results or not arguments:
        raise SceneError("a function needs at least one argument and one result")


def _argument_words(argument: Argument, names: Mapping[Symbol, str], used: Set[Symbol]) -> str:
    own = argument.symbol.name
    words = [", ".join(x for x in (argument.meaning, argument.unit) if x), argument.range, argument.example]
    words += [f"called {own} in the formulas"] if names[argument.symbol] != own else []
    words += ["no result depends on it"] if argument.symbol not in used else []
    return comment("; ".join(x for x in words if x))


def _result_words(name: str, about: About) -> str:
    meaning, unit = (about.results or {}).get(name, ("result", ""))
    return comment(f"{meaning}, {unit}" if unit else meaning)
