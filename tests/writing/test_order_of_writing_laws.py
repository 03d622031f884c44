"""In which order factors and terms stand, what is taken together, under which root, and where a sign stands."""

from __future__ import annotations

import random
from itertools import combinations
from typing import Any

import pytest
import sympy as sp
from formulas import EXPRESSIONS
from hypothesis import given
from marks import examples
from plainreader import expression
from sympy import Abs, Add, Expr, I, Integer, Mul, Pow, Rational, Symbol, cos, exp, pi, sqrt

import haptisym as hs
from haptisym.kernel.symbols import X, omega, s
from haptisym.writing.boxes import Box, Name, Numeral, Sum
from haptisym.writing.layout import layout
from haptisym.writing.mathtext import plain
from haptisym.writing.names import named

a, b, c, d, k, m = hs.symbols("a b c d k m")
J, zeta, omega_n, omega_c = hs.symbols("J zeta omega_n omega_c")
u, v = sp.symbols("u v", real=True)
"""Whose signs are not known."""

IN_ORDER: list[Expr] = [
    3 ** Rational(1, 3), pi, X, b, k, zeta, a + J, omega_c, omega_n, c + omega_n, s, I, cos(m), (d + s) ** 2, sqrt(m + s),
]  # fmt: skip
"""Numbers, X, parameters (Latin before Greek), their sums, frequencies, their sums, s, j, functions, sums with s, roots of sums."""


def test_every_two_factors_of_a_product_stand_in_the_order_of_their_kinds() -> None:
    for one, two in combinations(IN_ORDER, 2):
        shown = plain(Mul(one, two))
        first, second = (f"({plain(x)})" if x.is_Add else plain(x) for x in (one, two))
        assert shown in (f"{first} {second}", f"{second} {first}"), shown
        assert shown == f"{first} {second}", shown
    for one, two in combinations([x.xreplace({s: omega}) for x in IN_ORDER], 2):
        assert plain(Mul(one, two)).startswith(f"({plain(one)})" if one.is_Add else plain(one))


def test_the_order_of_factors_does_not_depend_on_the_order_in_which_they_were_multiplied() -> None:
    pick = random.Random(4)
    for _ in range(30):
        chosen = sorted(pick.sample(range(len(IN_ORDER)), 5))
        shown = plain(Mul(*(IN_ORDER[i] for i in chosen)))
        parts = [f"({plain(x)})" if x.is_Add else plain(x) for x in (IN_ORDER[i] for i in chosen)]
        assert shown == " ".join(parts)


@pytest.mark.parametrize(
    ("form", "shown"),
    [
        # descending powers of s, numbers last; a sum to a power counts as its highest term
        (k + b * s + m * s**2 + 3, "m s^2 + b s + k + 3"),
        (s**3 + k * (s + 1) ** 2, "s^3 + k (s + 1)^2"),
        (s**3 + k * (s**2 + 1) ** 2, "k (s^2 + 1)^2 + s^3"),
        (s**3 + k * (s**3 + s + 1), "k (s^3 + s + 1) + s^3"),
        # quotients of sums that hold s last of all, behind roots of such sums; without s below they are coefficients
        (k / (s + 1) + m + s, "s + m + k/(s + 1)"),
        (k / (s + 1) + sqrt(s + 1) + m, "m + sqrt(s + 1) + k/(s + 1)"),
        (k * s / (a + b) + m + s**2, "s^2 + k s/(a + b) + m"),
        (1 / s + s + 1, "s + 1 + 1/s"),
        # without s, omega or a frequency all symbols count
        (a + b * c + 2, "b c + a + 2"),
        (a**3 + b * c + d, "a^3 + b c + d"),
        (a / (b + c) + d + 1, "d + 1 + a/(b + c)"),
        (a**b + c**2 + d, "c^2 + d + a^b"),
        ((s + 1) ** k + s**3, "s^3 + (s + 1)^k"),
        # functions behind what has the same power, numbers too
        (cos(b) + 1 + k, "k + 1 + cos(b)"),
        (k + k * cos(b), "k + k cos(b)"),
        (a * s**2 + s**2 * cos(b), "(a + cos(b)) s^2"),
        # omega, and frequencies among the parameters, where there is no s
        (k - m * omega**2 + b * omega, "k + b omega - m omega^2"),
        (k * omega_n + m * omega_n**2 + b, "m omega_n^2 + k omega_n + b"),
        (omega_c * omega_n**2 + omega_c**2 * omega_n, "omega_c^2 omega_n + omega_c omega_n^2"),
        # what has the same power of s is taken together, and what all of it has in common stands in front
        (2 * b * s + 2 * k * s + 1, "2 (b + k) s + 1"),
        (s * (2 * b + 2 * k) + 1, "2 (b + k) s + 1"),
        (b * s - k * s + 1, "(b - k) s + 1"),
        (s * (b - k) + a + c, "(b - k) s + a + c"),
        (a * b + a * c + s, "s + a (b + c)"),
    ],
)
def test_terms_stand_as_a_person_orders_them(form: Expr, shown: str) -> None:
    assert plain(form) == shown


@pytest.mark.parametrize(
    ("form", "shown"),
    [
        (sqrt(k / m), "sqrt(k/m)"), (3 * sqrt(k / m), "3 sqrt(k/m)"), (-3 * sqrt(k / m), "-3 sqrt(k/m)"), (1 / sqrt(k * m), "1/sqrt(k m)"),
        (a / (sqrt(k) * sqrt(m) * b), "a/(b sqrt(k m))"), (sqrt(2) * sqrt(k), "sqrt(2 k)"), (3 * sqrt(2) * sqrt(k), "sqrt(18 k)"),
        (-sqrt(2) * sqrt(k), "-sqrt(2 k)"), (-3 * sqrt(2) * sqrt(k / m) * a, "-a sqrt(18 k/m)"), (sqrt(k) / sqrt(2), "sqrt(0.5 k)"),
        (sqrt(2) * sqrt(k) / sqrt(m), "sqrt(2 k/m)"), (sqrt(k), "sqrt(k)"), (5 * sqrt(2), "5 sqrt(2)"), (a * sqrt(k) / m, "a sqrt(k)/m"),
        (sqrt(u) * sqrt(k), "sqrt(k u)"), (sqrt(u) * sqrt(v), "sqrt(u) sqrt(v)"), (sqrt(u) / sqrt(v), "sqrt(u)/sqrt(v)"),
        (sqrt(u) * sqrt(v) * sqrt(k), "sqrt(k) sqrt(u) sqrt(v)"), (b / sqrt(k), "b/sqrt(k)"), (k ** Rational(3, 2) / sqrt(m), "k^1.5/sqrt(m)"),
    ],
)  # fmt: skip
def test_square_roots_are_gathered_under_one_where_no_two_signs_are_unknown(form: Expr, shown: str) -> None:
    assert plain(form) == shown
    known = {x.name: x for x in form.free_symbols}
    at = {x: Rational(n, 7) for n, x in enumerate(sorted(form.free_symbols, key=str), 2)}
    assert float(expression(shown, known).subs(at)) == pytest.approx(float(form.subs(at)))


@pytest.mark.parametrize(
    ("form", "shown"),
    [
        # a minus in front goes into a sum of at most three terms that then begins with a plus
        (-(k * (a - b)), "k (b - a)"),
        (-(k * (a - b + c)), "k (b - a - c)"),
        (-(k * (a - b + c - d)), "-k (a - b + c - d)"),
        (-(k * (a - b) ** 3), "k (b - a)^3"),
        (-(k * (a - b) ** 2), "-k (a - b)^2"),
        (-(k * (a + b)), "-k (a + b)"),
        (-k / (a - b), "k/(b - a)"),
        (-k * (a + c) / (s - b), "k (a + c)/(b - s)"),
        (-k * sqrt(a - b), "-k sqrt(a - b)"),
        # a sum that would begin with a minus changes its sign, and so does its product where the power is odd
        (k * (-(s**2) + b * s - 1), "-k (s^2 - b s + 1)"),
        (k * (-(s**2) + b * s - 1) ** 2, "k (s^2 - b s + 1)^2"),
        (k * sqrt(-(s**2) + b * s - 1), "k sqrt(-s^2 + b s - 1)"),
        (k * (-(s**2) + b * s - 1) ** Rational(3, 2), "k (-s^2 + b s - 1)^1.5"),
        (k / (-(s**2) + b * s - 1) ** 3, "-k/(s^2 - b s + 1)^3"),
        (Abs(-(s**2) + b * s - 1, evaluate=False), "|s^2 - b s + 1|"),
        (Abs(s**2 - b * s + 1, evaluate=False), "|s^2 - b s + 1|"),
        (Abs(-k * s, evaluate=False), "|k s|"),
        # a sum that is one term when its like powers are taken together is taken apart into factors
        (k * (b * s + J * s), "k (b + J) s"),
        (k * (b * s - J * s), "k (b - J) s"),
        (k / (b * s + J * s), "k/((b + J) s)"),
        (k * (b * s + J * s) * (s + 1), "k (b + J) s (s + 1)"),
        # numbers of a quotient
        (k / (3 * m), "k/(3 m)"),
        (2 * k / (3 * m), "2 k/(3 m)"),
        (3 * k / (2 * m), "1.5 k/m"),
        (-3 * k / (2 * m), "-1.5 k/m"),
        (3 * pi / (2 * m), "3 pi/(2 m)"),
        (Rational(3, 16) * pi / m, "0.1875 pi/m"),
        (3 * pi * k / 8, "0.375 pi k"),
        (Mul(Rational(1, 3), k, evaluate=False), "(1/3) k"),
        (Integer(-3), "-3"),
        (Pow(0, k, evaluate=False), "0^k"),
        (Pow(Integer(-2), k, evaluate=False), "(-2)^k"),
        (Pow(Rational(1, 2), k, evaluate=False), "(0.5)^k"),
        (pi**k, "pi^k"),
        (exp(k) * cos(k) ** 2, "cos(k)^2 exp(k)"),
        (sp.nan, "nan"),
        (sp.Eq(k, m + 1, evaluate=False), "k = m + 1"),
        (sp.Ne(k, m, evaluate=False), "k != m"),
    ],
)
def test_signs_and_numbers_stand_where_a_person_writes_them(form: Expr, shown: str) -> None:
    assert plain(form) == shown


def signs_of(box: object) -> set[int]:
    """Of all sums within a tree."""
    found = {sign for sign, _ in box.terms} if isinstance(box, Sum) else set()
    for name in getattr(box, "__dataclass_fields__", {}):
        inside = getattr(box, name)
        for x in inside if isinstance(inside, tuple) else (inside,):
            for y in x if isinstance(x, tuple) else (x,):
                found |= signs_of(y)
    return found


@given(EXPRESSIONS)
@examples(100)
def test_the_sign_of_a_term_is_plus_one_or_minus_one(form: Expr) -> None:
    for own in (form, -form, form**2, -k * (a - b) ** 3 + form):
        assert signs_of(layout(own)) <= {1, -1}


def test_a_negative_number_is_a_sum_of_one_term_and_one_term_with_a_plus_is_no_sum() -> None:
    assert layout(Integer(-3)) == Sum(((-1, Numeral("3")),))
    assert layout(-k) == Sum(((-1, layout(k)),))
    assert isinstance(layout(k), Name)
    assert layout(k - m) == Sum(((1, layout(k)), (-1, layout(m))))
    for form in (-k * (a - b) ** 3, k * (-(s**2) + b * s - 1), k / (-(s**2) + b * s - 1) ** 3, -2 * k / m):
        assert signs_of(layout(form)) <= {1, -1}


def test_the_same_formula_has_the_same_tree_in_whatever_order_it_was_put_together() -> None:
    pick = random.Random(2)
    terms = [m * s**2, b * s, -k, J * s, 3 * s**2, 1 / (s + a), sqrt(a + s), cos(b)]
    seen: set[Box] = set()
    for _ in range(10):
        pick.shuffle(terms)
        seen.add(layout(Add(*terms)))
    assert len(seen) == 1


# Names

GREEK = (
    "alpha", "beta", "gamma", "delta", "epsilon", "zeta", "eta", "theta", "iota", "kappa", "lambda", "mu", "nu", "xi", "omicron", "pi", "rho", "sigma",
    "tau", "upsilon", "phi", "chi", "psi", "omega",
)  # fmt: skip


def test_symbols_stand_in_the_order_of_their_alphabets_latin_before_greek_and_small_beside_large() -> None:
    names = [
        "a",
        "A_n",
        "b",
        "b_2",
        "c",
        "force",
        "m",
        "z",
        "alpha",
        "β",
        "Gamma",
        "delta",
        "Δ_n",
        "zeta",
        "θ",
        "mu",
        "phi",
        "psi",
    ]
    keys = {"force": "f", "β": "beta", "Δ_n": "delta", "θ": "theta"}

    def key(name: str) -> tuple[Any, ...]:
        own = keys.get(name, name.split("_")[0]).lower()
        return own in GREEK, GREEK.index(own) if own in GREEK else 0, own

    pick = random.Random(9)
    for _ in range(60):
        chosen = pick.sample(names, 4)
        chosen = list({key(x): x for x in chosen}.values())
        shown = plain(Mul(*map(Symbol, chosen)))
        assert shown.split(" ") == sorted(chosen, key=key)
    assert plain(Symbol("b_2") * Symbol("b_1") * Symbol("b")) == "b b_1 b_2"
    assert plain(Symbol("Zeta_n") * Symbol("zeta_a")) in ("Zeta_n zeta_a", "zeta_a Zeta_n")


def test_letters_of_names_slant_words_stand_upright_and_digits_do_neither() -> None:
    for text, upright in (
        ("k", False),
        ("omega", False),
        ("ω", False),
        ("Δ", False),
        ("wall", True),
        ("é", True),
        ("7", False),
        ("77", False),
        ("Omega", False),
    ):
        assert named(text).head.upright is upright, text
    assert [(x.letters, x.upright) for x in named("k_ab_cd_1_ef").below] == [
        ("ab cd", True),
        ("1", False),
        ("ef", True),
    ]
    assert named("ω_n").head.letters == "omega"
