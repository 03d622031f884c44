"""A SymPy expression, or a quantity of the evaluation, laid out as a person would write it: the
tree of boxes of all writers.

Names are taken apart: a letter or word with subscripts, Greek letters spelt out or not. Numbers are
exact: a whole number is written as it is, without separators; a fraction as a decimal where that
ends within six digits, or is shorter (9/5 is 1.8), else as a fraction. Only ``approximate`` and
``rounded`` round, and whoever uses them says so. Terms and factors stand in the order, and grouped,
as a person writes them. Nothing is evaluated: the tree stands for the expression exactly. What it
has no box for (a derivative, say) stands as a function of its arguments.

Quantities have a name each:

H_env, H_perc, H_rendered   environment, what is felt instead, what is really rendered (of s)
dH, Re dH, Im dH            distortion H_perc - H_env (eq. 9); its parts on s = j omega
|H_env|, |H_env|^2          what they are compared with
r_r, r_i                    distortion ratios (eq. 10)
Re(dH/H_env), Im(dH/H_env)  relative distortion, which is something else
k_env, m_env, b_env         stiffness, mass and damping of the environment; k_perc, ... as felt
F_si_env, F_d_env           phasors of the force of spring or inertia, and of damping (eqs. 5 and
                            6); F_si_perc, ... as felt
omega_env, omega_perc       changeover between spring and inertia
p_r, p_i                    threshold polynomials: positive exactly where the ratio exceeds its
                            threshold
omega_r, omega_i            crossing of the threshold
jnd k, jnd m, jnd b         the change of one parameter that is just noticed
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Callable, Iterable, Mapping
from decimal import Decimal
from functools import cache
from types import MappingProxyType
from typing import Any, TypeAlias

import sympy
from sympy import (
    Abs,
    Add,
    Basic,
    Expr,
    Float,
    Function,
    I,
    Integer,
    MatrixBase,
    Mul,
    Number,
    Pow,
    Rational,
    S,
    Symbol,
    atan,
    atan2,
    factor_terms,
    pi,
    sqrt,
)
from sympy.core.function import Application
from sympy.core.relational import Relational
from sympy.functions import exp

from haptisym.kernel.errors import SceneError
from haptisym.kernel.harmonics import Harmonic
from haptisym.kernel.names import CAPITALS, GREEK, greek
from haptisym.kernel.reals import ExactNumber, Proven
from haptisym.kernel.rings import X, finite, omega, s
from haptisym.writing.boxes import (
    Absolute,
    Applied,
    Box,
    Exponential,
    Fenced,
    Fraction,
    MatrixBox,
    Name,
    Numeral,
    Operator,
    Power,
    Prefixed,
    Radical,
    Ratio,
    Relation,
    Series,
    SideBySide,
    Sum,
    Titled,
    Word,
    text,
)

# Parameters of effects that are called by a word but known by a letter.
_LETTER_OF = {"force": "F", "amplitude": "A"}


_COMMAND = re.compile(rf"\\(?=({'|'.join((*GREEK, *CAPITALS))})(?![A-Za-z]))")


@cache
def named(text: str) -> Name:
    """A symbol's name taken apart: ``_`` starts subscripts, and so does what follows a first letter
    or ends in digits.

    >>> [word.letters for word in named("omega_n_filter").below], [word.letters for word in named("zeta_force_sensor").below]
    (['n', 'filter'], ['force sensor'])
    >>> named("Mm").below[0].letters, named("k12").below[0].letters, named("force_friction").head.letters
    ('m', '12', 'F')
    """
    # A name may be written in LaTeX.
    plain = re.sub(r"_\{([^{}]*)\}", r"_\1", _COMMAND.sub("", text))
    # k1 and Mm are a letter with a subscript, as k_1 and M_m are; so is any word that ends in
    # digits. Xi and Pi are letters themselves. A name of underscores alone stays as it is.
    head, *below = [word for word in plain.split("_") if word] or [text]
    parted = re.fullmatch(r"(.*[^\d])(\d+)", head) or re.fullmatch("([A-Z])([a-z])", head)
    if parted and head not in CAPITALS:
        head, below = parted[1], [parted[2], *below]
    return Name(text, _word(_LETTER_OF.get(head, head)), tuple(_joined(map(_word, below))))


def _word(text: str) -> Word:
    """A part of a name: a letter, which slants, or a word, which does not."""
    letters = greek(text) or text if len(text) == 1 else text
    stem = letters.rstrip("'")
    is_letter = (len(stem) == 1 and stem.isascii()) or stem in GREEK or stem in CAPITALS
    return Word(letters, not is_letter and not letters.isdigit())


def _joined(words: Iterable[Word]) -> list[Word]:
    """The words of subscripts; upright ones that follow each other are one."""
    parts: list[Word] = []
    for word in words:
        if parts and word.upright and parts[-1].upright:
            parts[-1] = Word(f"{parts[-1].letters} {word.letters}", upright=True)
        else:
            parts.append(word)
    return parts


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
    return (
        is_greek,
        GREEK.index(name.lower()) if is_greek else 0,
        (name or head).lower(),
        head,
        below,
    )


_SHORT = 6  # digits of a decimal that a paper would print
_READABLE = 12  # digits of a decimal that can be read
_READABLE_RATIO = 8  # digits of a fraction, above and below


def number(value: Rational) -> Numeral | Ratio:
    """An exact rational number >= 0.

    >>> number(Rational(9, 5)), number(Rational(1, 3)), number(Rational(1, 10**6))
    (Numeral(digits='1.8', exponent=0), Ratio(above=1, below=3), Numeral(digits='1', exponent=-6))
    """
    if value.q == 1:
        return Numeral(str(value.p))
    # A decimal that ends is exact as well, and read more easily; but 1/1024 is shorter than
    # 0.0009765625.
    exact = _terminating(value)
    if exact is not None:
        length = len(exact.as_tuple().digits)
        if length <= _SHORT or length < len(f"{value.p}{value.q}"):
            return decimal(exact)
    return Ratio(int(value.p), int(value.q))


def _terminating(value: Rational) -> Decimal | None:
    """A rational number as a decimal that ends; None if it does not: its denominator has a prime
    other than 2 and 5."""
    below, places = int(value.q), 0
    for prime in (2, 5):
        power = 0
        while below % prime == 0:
            below, power = below // prime, power + 1
        places = max(places, power)
    # From text: arithmetic of decimals rounds to 28 digits.
    return None if below > 1 else Decimal(f"{int(value.p) * 10**places // int(value.q)}E-{places}")


def decimal(value: Decimal) -> Numeral:
    """A decimal >= 0 with a power of ten where it would have many zeros.

    >>> decimal(Decimal("0.00025")), decimal(Decimal("4.0919E9"))
    (Numeral(digits='0.00025', exponent=0), Numeral(digits='4.0919', exponent=9))
    """
    # From 0.0001 to below ten million there are few zeros to count.
    if -4 <= value.adjusted() < 7:
        return Numeral(f"{value:f}")
    first, *others = map(str, value.as_tuple().digits)
    rest = "".join(others).rstrip("0")
    return Numeral(f"{first}.{rest}" if rest else first, value.adjusted())


def approximate(expression: Expr, digits: int = 6) -> Expr:
    """The formula with long numbers, and if there are any then irrational ones too, rounded to that
    many digits.

    The phase of a sine, which grows with omega, stays exact but for the angles in it.

    >>> from sympy import Symbol
    >>> s = Symbol("s")
    >>> approximate(Rational(408233133, 200000001) * s + 40 * pi), approximate(Rational(4, 3) * s + 40 * pi)
    (2.04117*s + 125.664, 4*s/3 + 40*pi)
    """
    if is_brief(expression):
        return expression
    return _with_numbers(
        expression, lambda x: x if x.is_Integer and abs(x) < 10**digits else rounded(x, digits)
    )


def is_brief(expression: Expr) -> bool:
    """Whether a formula has no long number; to see that makes nothing anew, which takes far
    longer."""
    if not expression.free_symbols:
        rational, rest = expression.as_coeff_Mul()
        return is_short(rational) and rest in (S.One, pi, pi**2)
    if isinstance(expression, Pow):
        return is_brief(expression.base)
    if not isinstance(expression, Add | Mul):
        return not isinstance(expression, Function) or all(map(is_brief, expression.args))
    # The numbers of a sum or product are judged as one, as they are printed.
    known, rest = expression.as_independent(
        *expression.free_symbols, as_Add=isinstance(expression, Add)
    )
    return all(map(is_brief, (known, *expression.func.make_args(rest))))


def _with_numbers(expression: Expr, change: Callable[[Expr], Expr]) -> Expr:
    """An expression with each of its numbers changed, but for exponents and arguments of
    functions."""
    if not expression.free_symbols:
        return change(expression)
    if isinstance(expression, Pow):
        return Pow(finite(_with_numbers(expression.base, change)), expression.exp)
    if isinstance(expression, Abs):
        return Abs(_with_numbers(expression.args[0], change), evaluate=False)
    if isinstance(expression, atan | atan2):  # an angle, which cannot drift
        return expression.func(*(_with_numbers(x, change) for x in expression.args))
    if isinstance(expression, Function):
        # A rounded factor of omega in a sine would drift ever further from the exact phase.
        return expression.xreplace(
            {x: _with_numbers(x, change) for x in expression.atoms(atan, atan2)}
        )
    if not isinstance(expression, Add | Mul):
        return expression
    known, rest = expression.as_independent(
        *expression.free_symbols, as_Add=isinstance(expression, Add)
    )
    others = (_with_numbers(x, change) for x in expression.func.make_args(rest))
    return expression.func(change(known), *others)


def rounded(value: Expr, digits: int = 6) -> Expr:
    """A number, rational in pi, correctly rounded."""
    if value.has(I):  # the phase of friction
        parts = zip((1, I), value.as_real_imag(), strict=True)
        return Add(*(x * rounded(y, digits) for x, y in parts if y))
    return Float(ExactNumber(value).digits(digits), digits)


def is_short(value: Rational) -> bool:
    """Whether a rational number can be read as it is: few digits, and no power of ten beside them.

    >>> is_short(Rational(68, 15)), is_short(Rational(12345678)), is_short(Rational(408233133, 200000001))
    (True, True, False)
    """
    match number(abs(value)):
        case Ratio(above, below):
            return len(f"{above}{below}") <= _READABLE_RATIO
        case Numeral(digits, exponent):
            return len(digits) <= _READABLE and (not exponent or digits == "1")
    raise AssertionError


def place(factor: Expr) -> tuple[Any, ...]:
    """Where a factor stands in a product: numbers, X, parameters, their sums, frequencies, s or
    omega, j, functions, sums."""
    # The first entry is the kind of factor, in the order above; later ones order within a kind.
    base = base_of(factor)
    if base in (s, omega):
        return (6,)
    if base.is_Symbol:
        return (1 if base == X else 4 if _is_frequency(base) else 2, *alphabetical(base))
    if factor == I:
        return (7,)
    if isinstance(base, Add):
        if not factor.is_Add and not factor.exp.is_Integer:
            return (10,)
        return (
            9 if base.has(s, omega) else 5 if any(map(_is_frequency, base.free_symbols)) else 3,
        )
    return 0 if base.is_number else 8, str(factor)


def base_of(factor: Expr) -> Expr:
    """What is raised to a power."""
    return factor.base if isinstance(factor, Pow) else factor


def _is_frequency(symbol: Symbol) -> bool:
    return bool(symbol.name.startswith("omega_"))


def variable_of(expr: Expr) -> Symbol | None:
    """The variable whose powers order a sum: s, omega, else a frequency among the parameters."""
    free = expr.free_symbols
    named = sorted(filter(_is_frequency, free), key=alphabetical)
    return next((x for x in (s, omega, *named) if x in free), None)


def grouped(expr: Add, variable: Symbol | None) -> list[Expr]:
    """The terms of a sum, those with the same power of the variable made one: their coefficients in
    front of it.

    >>> from sympy import symbols
    >>> b, J, k = symbols("b J k")
    >>> grouped(b * s + J * s + k, s)
    [k, s*(J + b)]
    """
    # Without a variable there are no powers to group by: each term stands by itself.
    if variable is None:
        return list(expr.args)
    coefficients: dict[Expr, list[Expr]] = {}
    for term in expr.args:
        coefficient, power = term.as_independent(variable, as_Add=False)
        coefficients.setdefault(power, []).append(coefficient)
    terms: list[Expr] = []
    for power, alike in coefficients.items():
        total = factor_terms(Add(*alike)) if len(alike) > 1 or alike[0].has(Add) else alike[0]
        is_sum = isinstance(total, Add) or isinstance(-total, Add)
        # Constant terms stay apart: a sum in parentheses with nothing behind it groups nothing.
        terms += alike if power == 1 and is_sum else [Mul(total, power)]
    return terms


def rank(term: Expr, variable: Symbol | None) -> tuple[Any, ...]:
    """Sort key of a term: descending powers, quotients last, then the natural order of the
    factors."""
    names = sorted(place(f) for f in Mul.make_args(term) if not f.is_Number)
    return -_degree(term, variable), any(name[0] == 8 for name in names), not names, str(names)


def _degree(term: Expr, variable: Symbol | None) -> Expr:
    """The power of the variable in a term (of all symbols without one); least for quotients of
    sums."""
    total: Expr = S.Zero
    for f in Mul.make_args(term):
        base, exponent = (f.base, f.exp) if isinstance(f, Pow) else (f, S.One)
        counts = base == variable or (variable is None and base.is_Symbol)
        if counts:
            total += exponent if exponent.is_Number else S.Half
        elif isinstance(base, Add) and exponent.is_Number:
            # Below every power that a formula has: quotients of sums stand last, roots of sums just
            # before them.
            if exponent < 0 and (variable is None or base.has(variable)):
                return Integer(-1000)
            if not exponent.is_Integer:
                return Integer(-999)
            total += exponent * max(_degree(x, variable) for x in base.args)
    return total


def fraction(expr: Expr) -> tuple[Expr, list[Expr], list[Expr]]:
    """Number, other factors above and other factors below the line; square roots gathered under one
    root.

    >>> from sympy import symbols
    >>> k, m = symbols("k m", positive=True)
    >>> fraction(3 * k / m), fraction(2 * sqrt(k / m))
    ((3, [k], [m]), (2, [sqrt(k/m)], []))
    """
    # A negative exponent means below the line, also a symbolic one such as -n.
    coefficient, rest = expr.as_coeff_Mul()
    above: list[Expr] = []
    below: list[Expr] = []
    for f in Mul.make_args(rest):
        if isinstance(f, Pow) and f.exp.could_extract_minus_sign():
            below.append(Pow(f.base, -f.exp))
        elif f != 1:
            above.append(f)
    # sqrt(a) sqrt(b) = sqrt(a b) needs all but one of them to be non-negative.
    roots = [f.base for f in (*above, *below) if _is_root(f)]
    if len(roots) < 2 or sum(not root.is_nonnegative for root in roots) > 1:
        return coefficient, above, below
    return _one_root(coefficient, above, below)


def _one_root(
    coefficient: Expr, above: list[Expr], below: list[Expr]
) -> tuple[Expr, list[Expr], list[Expr]]:
    """The same quotient with one root above the line; the coefficient goes under it if a number is
    there already."""
    if not any(map(_is_root, above)):
        root = sqrt(Mul(*(f.base for f in below if _is_root(f))), evaluate=False)
        return coefficient, above, [*(f for f in below if not _is_root(f)), root]
    inside = [f.base for f in above if _is_root(f)] + [1 / f.base for f in below if _is_root(f)]
    numbers = [x for x in inside if x.is_Rational]
    under = Mul(*(x for x in inside if not x.is_Rational))
    outside = coefficient
    # 2 sqrt(3) sqrt(k) becomes sqrt(12 k): one number under the root instead of one in front and
    # one inside. The sign stays outside. Evaluated, SymPy would draw it out again.
    if numbers:
        factors = Mul.make_args(under)
        under = Mul(Mul(coefficient**2, *numbers), *factors, evaluate=False)
        outside = S.One if coefficient > 0 else S.NegativeOne
    root = sqrt(under, evaluate=False)
    return (
        outside,
        [*(f for f in above if not _is_root(f)), root],
        [f for f in below if not _is_root(f)],
    )


def _is_root(factor: Expr) -> bool:
    """Whether a factor is a square root."""
    return isinstance(factor, Pow) and factor.exp == S.Half


def exponent(factor: Expr) -> int:
    """A factor's whole exponent; 0 for any other one."""
    if not isinstance(factor, Pow):
        return 1
    return int(factor.exp) if factor.exp.is_Integer else 0


def is_flippable(factor: Expr) -> bool:
    """Whether a factor is a sum, or a power of one, whose sign can be drawn out."""
    return isinstance(base_of(factor), Add) and exponent(factor) > 0


def flipped(factor: Expr) -> Expr:
    """The same factor with the signs of its sum turned around."""
    return Pow(-base_of(factor), exponent(factor))


_FUNCTIONS = {
    **{name: name for name in ("sin", "cos", "tan", "cot", "sinh", "cosh", "tanh", "coth")},
    **{f"a{name}": f"arc{name}" for name in ("sin", "cos", "tan")},
    "asinh": "arsinh",
    "acosh": "arcosh",
    "atanh": "artanh",
    "log": "ln",
    "re": "Re",
    "im": "Im",
    "Max": "max",
    "Min": "min",
    "atan2": "atan2",
    "floor": "floor",
}
_CONSTANTS = {pi: named("pi"), I: named("j"), S.Exp1: named("e"), S.Infinity: named("∞")}

_RELATIONS = {"==": "=", "!=": "≠", "<": "<", ">": ">", "<=": "≤", ">=": "≥"}

_Quotient: TypeAlias = tuple[int, Expr, list[Expr], list[Expr]]
"""Sign, coefficient >= 0, other factors above and below the line."""


def layout(expression: Basic) -> Box:
    """The boxes of an expression.

    >>> from haptisym.kernel.rings import s
    >>> layout(2 * s + 3)
    Sum(terms=((1, SideBySide(factors=(Numeral(digits='2', exponent=0), \
Name(text='s', head=Word(letters='s', upright=False), below=())))), (1, Numeral(digits='3', exponent=0))))
    """
    return _Layout().box(expression)


class _Layout:
    """Boxes, orders of terms and quotients of an expression's parts: what occurs twice is laid out
    once."""

    def __init__(self) -> None:
        self._boxes: dict[Basic, Box] = {}
        self._orders: dict[Expr, list[Expr]] = {}
        self._quotients: dict[Expr, _Quotient] = {}

    def box(self, expr: Basic) -> Box:
        """The boxes of an expression or of a part of it."""
        if expr not in self._boxes:
            self._boxes[expr] = self._made(expr)
        return self._boxes[expr]

    def _made(self, expr: Basic) -> Box:
        """The boxes of an expression that has none yet."""
        if expr in _CONSTANTS:
            return _CONSTANTS[expr]
        for kind, make in self._makers:
            if isinstance(expr, kind):
                return make(self, expr)
        if expr.args:
            return self._applied(named(expr.func.__name__), expr)
        return named(str(expr))

    def _symbol(self, expr: Symbol) -> Box:
        return named(expr.name)

    def _number(self, expr: Number) -> Box:
        if expr.is_extended_negative:
            return Sum(((-1, self.box(-expr)),))
        if isinstance(expr, Float):
            return decimal(Decimal(str(expr)).normalize())
        return number(expr) if isinstance(expr, Rational) else named(str(expr))

    def _proven(self, expr: Proven) -> Box:
        return decimal(Decimal(expr.number.digits()).normalize())

    def _sum(self, expr: Add) -> Box:
        return _summed([self._signed(term) for term in self._written(expr)])

    def _product(self, expr: Mul) -> Box:
        return _summed([self._signed(expr)])

    def _power(self, expr: Pow) -> Box:
        if expr.exp.could_extract_minus_sign():
            return self._product(expr)
        if expr.exp == S.Half:
            return Radical(self.box(expr.base))
        base, raised = self.box(expr.base), expr.base
        # These read as one thing: x^2, |x|^2, sin(x)^2. A fraction, decimal or sum does not.
        is_bare = raised.is_Symbol or raised in (pi, I) or (raised.is_Integer and raised >= 0)
        is_bare = is_bare or isinstance(base, Absolute | Applied)
        return Power(base if is_bare else Fenced(base), self.box(expr.exp))

    def _absolute(self, expr: Abs) -> Box:
        # |x| = |-x|: the one that begins without a minus.
        inside = expr.args[0]
        if isinstance(inside, Add) and self._is_negative(inside):
            inside = -inside
        return Absolute(self._signed(inside)[1])

    def _exponential(self, expr: exp) -> Box:
        return Exponential(self.box(expr.args[0]))

    def _series(self, expr: sympy.Sum) -> Box:
        index, first, last = expr.limits[0]
        return Series(*map(self.box, (expr.function, index, first, last)))

    def _function(self, expr: Application) -> Box:
        # Nobody knows it by name, so that it is written out.
        if isinstance(expr, Harmonic):
            return self.box(expr.explicit)
        name = expr.func.__name__
        return self._applied(
            Operator(_FUNCTIONS[name]) if name in _FUNCTIONS else named(name), expr
        )

    def _applied(self, function: Box, expr: Basic) -> Box:
        return Applied(function, tuple(map(self.box, expr.args)))

    def _matrix(self, expr: MatrixBase) -> Box:
        return MatrixBox(tuple(tuple(map(self.box, row)) for row in expr.tolist()))

    def _relation(self, expr: Relational) -> Box:
        return Relation((self.box(expr.lhs), self.box(expr.rhs)), (_RELATIONS[expr.rel_op],))

    # The first kind that fits: exp and Abs are functions too, so they stand before these.
    _makers: tuple[tuple[type, Callable[[_Layout, Basic], Box]], ...] = (
        (Symbol, _symbol),
        (Number, _number),
        (Proven, _proven),
        (Mul, _product),
        (Pow, _power),
        (Add, _sum),
        (Abs, _absolute),
        (exp, _exponential),
        (sympy.Sum, _series),
        (Application, _function),
        (MatrixBase, _matrix),
        (Relational, _relation),
    )

    # Signs and quotients.

    def _signed(self, expr: Expr) -> tuple[int, Box]:
        """The sign to print in front of a term, and the rest of it."""
        if not (isinstance(expr, Mul | Pow) or expr.is_Number):
            return 1, self.box(expr)
        sign, coefficient, above, below = self._quotient(expr)
        if not below:
            product = self._side_by_side(coefficient, above)
            return sign, Fenced(product) if isinstance(product, Sum) else product
        upper, lower = coefficient, S.One
        # One line of fraction instead of two: k/(3 m), not (1/3) k/m. A decimal stays above the
        # line, except for small denominators beside pi: 5 pi/(2 m), not 2.5 pi/m.
        if isinstance(coefficient, Rational) and (
            (pi in above and coefficient.q < 10)
            or coefficient.p == 1
            or isinstance(number(coefficient), Ratio)
        ):
            upper, lower = Integer(coefficient.p), Integer(coefficient.q)
        return sign, Fraction(self._side_by_side(upper, above), self._side_by_side(lower, below))

    def _side_by_side(self, coefficient: Expr, factors: list[Expr]) -> Box:
        """Factors side by side; a sum in parentheses unless it stands alone."""
        boxes = [self.box(f) for f in sorted(factors, key=place)]
        if coefficient != 1 or isinstance(coefficient, Float) or not boxes:
            boxes.insert(0, self.box(coefficient))
        if len(boxes) == 1:
            return boxes[0]
        return SideBySide(tuple(Fenced(x) if isinstance(x, Sum) else x for x in boxes))

    # Signs of sums need orders of terms, and orders need signs of terms: each calls the other, and
    # without the tables the same parts would be laid out again at every level.

    def _quotient(self, expr: Expr) -> _Quotient:
        """Sign, coefficient >= 0, other factors above and other factors below the line."""
        if expr not in self._quotients:
            self._quotients[expr] = self._oriented(*fraction(self._spliced(expr)))
        return self._quotients[expr]

    def _spliced(self, expr: Expr) -> Expr:
        """The same product, with sums that are written as one term taken apart into its factors."""
        # k s + b s is written (b + k) s, so in a product it is two factors and no sum.
        pairs = [(self._written(f) if isinstance(f, Add) else [f], f) for f in Mul.make_args(expr)]
        # A product that is left as it is stays the very same object: nothing is evaluated anew.
        if all(len(terms) > 1 or terms == [f] for terms, f in pairs):
            return expr
        return Mul(*(terms[0] if len(terms) == 1 else f for terms, f in pairs))

    def _oriented(self, coefficient: Expr, above: list[Expr], below: list[Expr]) -> _Quotient:
        """The same quotient with sums that start with a plus where they can; the sign that is left
        over in front."""
        # (b - a) becomes -(a - b): each turn of a sum with an odd exponent changes the sign.
        sign = -1 if coefficient.is_extended_negative else 1
        for factors in (above, below):
            for i, f in enumerate(factors):
                if is_flippable(f) and self._is_negative(base_of(f)):
                    factors[i], sign = flipped(f), sign * (-1) ** exponent(f)
        # A minus that is left over is absorbed by the first short sum with an odd exponent, once.
        for factors in (above, below):
            for i, f in enumerate(factors):
                is_odd_sum = is_flippable(f) and exponent(f) % 2
                if sign < 0 and is_odd_sum and self._absorbs_minus(base_of(f)):
                    factors[i], sign = flipped(f), 1
        return sign, abs(coefficient), above, below

    def _absorbs_minus(self, total: Add) -> bool:
        """Whether a person would write -(a - b) as (b - a)."""
        return len(total.args) <= 3 and not self._is_negative(-total)

    def _is_negative(self, expr: Expr) -> bool:
        """Whether a term, or the first term of a sum, is printed with a minus."""
        first = self._written(expr)[0] if isinstance(expr, Add) else expr
        if not (isinstance(first, Mul | Pow) or first.is_Number):
            return False
        return self._quotient(first)[0] < 0

    def _written(self, expr: Add) -> list[Expr]:
        """The terms of a sum as a person orders and groups them."""
        if expr not in self._orders:
            self._orders[expr] = self._in_order(expr)
        return self._orders[expr]

    def _in_order(self, expr: Add) -> list[Expr]:
        """Descending powers; ascending where that avoids a leading minus."""
        variable = variable_of(expr)
        terms = grouped(expr, variable)
        ranks = [rank(term, variable) for term in terms]
        descending = sorted(range(len(terms)), key=lambda i: ranks[i])
        negative = [self._is_negative(term) for term in terms]
        signs = [negative[i] for i in descending]
        # Powers of a variable are turned around as a whole: k - m omega^2. That is no gain where
        # the lowest power has a minus too.
        if not signs[0] or all(signs) or (variable and signs[-1]):
            return [terms[i] for i in descending]
        ascending = sorted(range(len(terms)), key=lambda i: (-ranks[i][0], *ranks[i][1:]))
        first = next(i for i in ascending if not negative[i])
        ascending.remove(first)
        return [terms[i] for i in (first, *ascending)]


def _summed(terms: list[tuple[int, Box]]) -> Box:
    """A sum; one term with a plus is no sum."""
    return terms[0][1] if len(terms) == 1 and terms[0][0] > 0 else Sum(tuple(terms))


def plain(expression: Basic) -> str:
    """A formula as one line of text, names as they are called.

    >>> from sympy import Rational, symbols
    >>> from haptisym.kernel.rings import s
    >>> k, omega_n = symbols("k omega_n")
    >>> plain(Rational(9, 5) * s**2 + 15 * s + 100), plain(-k * (s + 1) / (2 * omega_n**2))
    ('1.8 s^2 + 15 s + 100', '-k (s + 1)/(2 omega_n^2)')
    """
    return text(layout(expression))


# The quantities of the evaluation by their names.


_OMEGA, _J = named("omega"), named("j")
_SQUARED = Numeral("2")


def equation(name: str, value: Basic, *, relation: str = "=", explained: bool = False) -> Relation:
    """``name = value`` as boxes, for ``text`` (plain), ``tex`` and ``mathml``; ``explained``: with
    the meaning between them.

    name : one of those above. relation : ``=``, or ``≈`` where ``value`` was rounded.
    Raises SceneError for any other name.

    >>> from haptisym.kernel.rings import s, symbols
    >>> text(equation("H_env", symbols("k") + s)), text(equation("r_r", symbols("k"), explained=True))
    ('H_env(s) = s + k', 'r_r = |Re dH/H_env| = k')
    """
    sides: tuple[Box, ...] = (quantity(name), layout(value))
    relations: tuple[str, ...] = (relation,)
    if explained and _row(name)[1] is not None:
        sides, relations = (sides[0], meaning(name), sides[1]), ("=", relation)
    return Relation(sides, relations)


def quantity(name: str) -> Box:
    """A quantity as it is set: ``Re dH`` is the real part of Delta H(omega j)."""
    return _row(name)[0]


def meaning(name: str) -> Box:
    """A quantity in terms of others; the quantity itself, if it is defined elsewhere."""
    set_as, means = _row(name)
    return means or set_as


def _row(name: str) -> tuple[Box, Box | None]:
    """The box of a quantity and that of its meaning, if there is one; SceneError for no
    quantity."""
    if name not in QUANTITIES:
        raise SceneError(
            f"{name!r} is not the name of a quantity: these are {', '.join(QUANTITIES)}"
        )
    return QUANTITIES[name]


def function(name: str, *arguments: Box) -> Box:
    """A function of omega j (or of what is given), called by its name alone in plain text."""
    return Titled(name, Applied(named(name), arguments or (SideBySide((_OMEGA, _J)),)))


def _on_s(name: str) -> Box:
    """A dynamics as a function of s."""
    return Titled(f"{name}(s)", function(name.replace("rendered", "rend"), named("s")))


_CHANGE = Titled("dH", Prefixed(named("Delta"), function("H")))
_ENVIRONMENT = function("H_env")
_RELATIVE = Fraction(_CHANGE, _ENVIRONMENT)
_SIZE = Absolute(_ENVIRONMENT)
_LEAST = SideBySide((named("c"), _SIZE))


def _of_change(operator: str, ratio: str) -> dict[str, tuple[Box, Box | None]]:
    """The quantities of one part of the distortion: the part, its ratio, threshold polynomial and
    crossing, and the part of the relative distortion."""
    part = Prefixed(Operator(operator), _CHANGE)
    return {
        f"{operator} dH": (part, None),
        ratio: (function(ratio, _OMEGA), Absolute(Fraction(part, _ENVIRONMENT))),
        f"p_{ratio[-1]}": (function(f"p_{ratio[-1]}", _OMEGA), None),
        f"omega_{ratio[-1]}": (named(f"omega_{ratio[-1]}"), None),
        f"{operator}(dH/H_env)": (
            Titled(f"{operator}(dH/H_env)", Prefixed(Operator(operator), _RELATIVE)),
            None,
        ),
    }


def _of_system(system: str) -> dict[str, tuple[Box, Box | None]]:
    """The quantities of the environment (``env``) or of what is felt (``perc``)."""
    H, X = function(f"H_{system}"), function("X")
    real, imag = (Prefixed(Operator(operator), H) for operator in ("Re", "Im"))
    k, m, b = (function(f"{letter}_{system}", _OMEGA) for letter in "kmb")
    return {
        f"H_{system}": (_on_s(f"H_{system}"), None),
        f"k_{system}": (k, real),
        f"m_{system}": (m, Sum(((-1, Fraction(k, Power(_OMEGA, _SQUARED))),))),
        f"b_{system}": (b, Fraction(imag, _OMEGA)),
        f"F_si_{system}": (_force("si", system), SideBySide((X, real))),
        f"F_d_{system}": (_force("d", system), SideBySide((X, imag, _J))),
        f"omega_{system}": (named(f"omega_{system}"), None),
    }


def _force(kind: str, system: str) -> Box:
    """The phasor of a force: of spring or inertia (``si``), or of damping (``d``)."""
    below = (Word(kind, upright=True), Word(system, upright=True))
    name = f"F_{kind}_{system}"
    return Titled(
        name, Applied(Name(name, Word("F", upright=False), below), (SideBySide((_OMEGA, _J)),))
    )


def _of_parameter(key: str, means: Box) -> tuple[Box, Box | None]:
    """The change of a parameter that is just noticed, and its meaning."""
    return Prefixed(named("Delta_jnd"), named(key)), means


QUANTITIES: Mapping[str, tuple[Box, Box | None]] = MappingProxyType(
    {
        **_of_system("env"),
        **_of_system("perc"),
        "H_rendered": (_on_s("H_rendered"), None),
        "dH": (Titled("dH(s)", Prefixed(named("Delta"), function("H", named("s")))), None),
        **_of_change("Re", "r_r"),
        **_of_change("Im", "r_i"),
        "|H_env|": (_SIZE, None),
        "|H_env|^2": (Power(_SIZE, _SQUARED), None),
        "jnd k": _of_parameter("k", _LEAST),
        "jnd b": _of_parameter("b", Fraction(_LEAST, _OMEGA)),
        "jnd m": _of_parameter("m", Fraction(_LEAST, Power(_OMEGA, _SQUARED))),
    }
)
"""Each name with its box, and the box of its meaning where there is one."""
