"""The sections of a derivation, of derivations put together by hand: what is written out, what is counted, and from where on."""

from __future__ import annotations

from types import SimpleNamespace as Made
from typing import Any

import pytest
from sympy import Add, Expr, Integer, Rational, Symbol, asin, symbols

import haptisym as hs
from haptisym.kernel.errors import SceneError
from haptisym.kernel.solutions import Solution
from haptisym.kernel.symbols import omega, s
from haptisym.model.jnd import Part
from haptisym.model.quantities import Dimension
from haptisym.pages import sections as page
from haptisym.pages.solved import answers
from haptisym.programs.steps import DISTORTION, Steps
from haptisym.verbs.derive.derivation import QUANTITIES
from haptisym.writing.document import Equations, Notes, Section
from haptisym.writing.names import named
from haptisym.writing.plain import said

k, m, b, tau = symbols("k m b tau", positive=True)
a, c = symbols("a c", real=True)


def told(section: Section) -> tuple[str, list[str], list[str]]:
    """Its title, its notes and its equations."""
    notes = [said(x) for block in section.blocks if isinstance(block, Notes) for x in block.entries]
    lines = [said(x.equation) for block in section.blocks if isinstance(block, Equations) for x in block.lines]
    return said(section.title), notes, lines


def sized(operations: int) -> Expr:
    """A sum of symbols that takes so many operations."""
    return Add(*(Symbol(f"y{n}") for n in range(operations + 1)))


class Derived:
    """A derivation that came out so."""

    def __init__(self, operations: int = 9, **own: Any) -> None:
        results = {x: Symbol(x) for x in DISTORTION}
        self.steps: Any = Made(operations=operations, only=lambda names: Steps((), {x: results[x] for x in names}))
        self.scene: Any = Made(
            effects=[], parameters=[], threshold=Made(is_plain=True), band=(Integer(0), Rational(15))
        )
        self.of: tuple[str, ...] = ()
        self.forms: dict[str, Expr] = {}
        self.terms = dict.fromkeys(Part, 1)
        self.solved: dict[Part, list[Solution]] = {x: [] for x in Part}
        self.changed: dict[str, list[Solution]] = {"env": [], "perc": []}
        self.__dict__.update(own)

    def __getitem__(self, name: str) -> Expr:
        return self.forms.get(name, s)

    def operations(self, name: str) -> int:
        return int(self[name].count_ops())

    def excess(self, part: Part) -> Any:
        return Made(function=Made(numerator=range(self.terms[part])))

    def crossings(self, part: Part) -> list[Solution]:
        return self.solved[part]

    def changeovers(self, system: str) -> list[Solution]:
        return self.changed[system]


@pytest.mark.parametrize(
    ("operations", "size", "written"), [(150, 120, True), (151, 1, False), (150, 121, False), (1, 1, True)]
)
def test_what_is_felt_is_written_out_up_to_150_steps_and_120_operations(
    operations: int, size: int, written: Any
) -> None:
    d: Any = Derived(operations, forms={"H_env": k, "H_perc": sized(size)})
    title, notes, lines = told(page._dynamics(d))
    assert (title, notes) == ("Dynamics", ["Nothing stands between environment and hand."])
    assert [x.split(" = ")[0] for x in lines] == ["H_env(s)", "H_perc(s)"][: 1 + written]
    chain: Any = Derived(scene=Made(effects=[Made(name="lag"), Made(name="shunt")]))
    assert told(page._dynamics(chain))[1] == ["From the environment to the hand: lag then shunt."]


def test_steps_are_told_with_their_number_and_all_six_results() -> None:
    d: Any = Derived(37)
    title, notes, lines = told(page._in_steps(d))
    assert (title, notes) == ("In steps (37 operations in all)", [])
    assert [x.split(" = ")[0] for x in lines] == ["Re dH", "Im dH", "r_r", "r_i", "Re(dH/H_env)", "Im(dH/H_env)"]
    assert [x.split(" = ")[1] for x in lines] == list(DISTORTION)
    defined = Steps(((Symbol("W"), omega**2),), {x: Symbol("W") * k + Symbol("W") for x in DISTORTION})
    assert told(Section("", (Equations(tuple(page._steps(defined))),)))[2][0] == "W = ω^2"


@pytest.mark.parametrize("size", [120, 121])
def test_closed_forms_are_written_out_while_they_are_short_and_asked_for_by_name_where_all_are_long(size: int) -> None:
    d: Any = Derived(150, forms={"Re dH": sized(size), "Im dH": s, "|H_env|^2": sized(size)})
    title, notes, lines = told(page._written_out(d))
    assert (title, notes) == ("Written out, in lowest terms", [])
    assert len(lines) == (3 if size == 120 else 1)
    long: Any = Derived(151)
    assert told(page._written_out(long)) == (
        "Written out",
        [f"Closed forms of this chain are long. Ask for one by its name: {', '.join(QUANTITIES)}."],
        [],
    )


FOUND = [Solution(k / m, s), Solution(None, omega**2 - k)]


def test_when_it_is_noticed_is_a_polynomial_while_that_is_short_with_the_frequencies_where_it_is_zero() -> None:
    forms = {"p_r": sized(120), "p_i": sized(121)}
    d: Any = Derived(150, forms=forms, solved={Part.REAL: FOUND, Part.IMAG: FOUND[:1]})
    title, notes, lines = told(page._when(d))
    assert title == "When it is noticed"
    assert notes == [
        "A ratio exceeds its threshold exactly where its p is positive.",
        "r_r: a solution is a root of a factor of degree 2 in ω: it has no readable formula, the equation is the answer.",
        "p_i takes 121 operations; ask for it by its name.",
    ]
    assert [x.split(" = ")[0] for x in lines] == ["p_r", "ω_r", "ω_i"]
    for terms in (2000, 2001):
        large: Any = Derived(150, terms={Part.REAL: terms, Part.IMAG: 1}, solved={Part.REAL: FOUND[:1], Part.IMAG: []})
        _, notes, lines = told(page._when(large))
        assert ("p_r has 2001 terms; ask for it by its name." in notes) == (terms > 2000)
        assert [x.split(" = ")[0] for x in lines] == (["p_i"] if terms > 2000 else ["p_r", "ω_r", "p_i"])
        solved = told(page._solved(large))
        assert (solved[0], len(solved[2])) == ("Crossings, solved", int(terms == 2000))
    endless: Any = Derived(151, solved={Part.REAL: FOUND, Part.IMAG: FOUND})
    assert page._when(endless).blocks == page._solved(endless).blocks == ()


def test_crossings_that_are_solved_have_no_word_about_those_that_are_not() -> None:
    d: Any = Derived(solved={Part.REAL: FOUND, Part.IMAG: FOUND[1:]})
    assert told(page._solved(d))[1:] == ([], ["ω_r = k/m"])


def test_changeovers_of_what_is_felt_are_told_where_its_closed_form_is_not_long() -> None:
    for operations in (150, 151):
        d: Any = Derived(operations, changed={"env": FOUND[:1], "perc": FOUND[:1]})
        title, _, lines = told(page._changeovers(d))
        assert title == "Where spring and inertia change over"
        assert [x.split(" = ")[0] for x in lines] == ["ω_env", "ω_perc"][: 1 + (operations == 150)]


def test_groups_are_counted_and_what_keeps_its_name_is_not_told_again() -> None:
    def one(groups: int, parameters: int) -> Any:
        made = [Made(symbol=Symbol(f"g_{n}"), value=k**n / m) for n in range(1, groups + 1)]
        own = [*made[:-1], Made(symbol=Symbol("zeta"), value=Symbol("zeta"))] if groups > 1 else made
        results = {x: Symbol("omega") for x in DISTORTION}
        found = Made(
            frequency=Made(symbol=Symbol("x"), value=omega / k), groups=own, stiffness=k, values={},
            chain=Made(at=lambda _: Made(steps=Steps((), results))), forwards=lambda form: form,
        )  # fmt: skip
        return Derived(groups=found, scene=Made(parameters=list(range(parameters))))

    for groups, parameters, words in (
        (0, 0, "no parameters and ω become x and no groups"), (1, 1, "1 parameter and ω become x and 1 group"), (3, 5, "5 parameters and ω become x and 3 groups"),
    ):  # fmt: skip
        first, second = page._dimensionless(one(groups, parameters))
        title, notes, lines = told(first)
        assert title == "Without dimensions"
        assert notes == [f"{words}; H is in units of k. The ratios, as functions of these:"]
        assert [x.split(" = ")[0] for x in lines] == ["x", "g_1", "g_2"][: 1 + min(groups, 2)]
        assert (said(second.title), len(told(second)[2])) == ("", 6)
    for parameters in (20, 21):
        assert len(list(page._dimensionless(one(1, parameters)))) == (2 if parameters == 20 else 0)

    class Unlike(Derived):
        @property
        def groups(self) -> Any:
            raise SceneError("a unit is missing")

    d: Any = Unlike()
    assert [told(x) for x in page._dimensionless(d)] == [
        ("Without dimensions", ["Not possible: a unit is missing."], [])
    ]


def number(text: str) -> Any:
    return Made(enclosure=lambda digits: ("0", text) if digits == 1 else ("", ""))


def test_leading_terms_of_fast_devices_are_told_with_what_they_leave_out() -> None:
    def one(sizes: tuple[int, int], bounds: tuple[str | None, str | None], operations: int = 9) -> Any:
        forms = dict(zip(Part, map(sized, sizes), strict=True))
        limits = {x: None if y is None else number(y) for x, y in zip(Part, bounds, strict=True)}
        found = Made(part=lambda x: forms[x], bounds=limits, fast=[tau, k])
        own = [Made(symbol=tau, dimension=Dimension.TIME), Made(symbol=k, dimension=Dimension.STIFFNESS)]
        return Derived(operations, expansion=lambda: found, scene=Made(parameters=own, band=(Integer(0), Integer(15))))

    [section] = page._fast(one((3, 120), ("0.01", "2e-5")))
    title, notes, lines = told(section)
    assert title == "Fast devices: τ small and k large"
    assert notes == [
        "What is left out makes at most 0.01 in r_r and 2e-5 in r_i on 0 to 15 rad/s with the scene's numbers: proven."
    ]
    assert [x.split(" ≈ ")[0] for x in lines] == ["Re dH", "Im dH"]
    assert all(" ≈ " in x for x in lines)
    [short] = page._fast(one((121, 5), ("0.01", None)))
    assert told(short)[1] == [
        "What is left out makes at most 0.01 in r_r on 0 to 15 rad/s with the scene's numbers: proven."
    ]
    assert len(told(short)[2]) == 1
    [bare] = page._fast(one((1, 1), (None, None)))
    assert told(bare)[1] == []
    assert list(page._fast(one((121, 121), ("1", "1")))) == []
    assert [len(list(page._fast(one((1, 1), ("1", "1"), n)))) for n in (150, 151)] == [1, 0]

    def none() -> Any:
        raise SceneError("nothing is fast")

    d: Any = Derived(expansion=none)
    assert list(page._fast(d)) == []


# Solutions


@pytest.mark.parametrize(
    ("solutions", "lines", "notes"),
    [
        ([Solution(k / m, s)], ["ω = k/m"], []),
        ([Solution(asin(a) / tau, s)], ["ω = asin(a)/τ"], ["in force where"]),
        ([Solution(None, omega**3 * k + omega - 1)], [], ["of degree 3 in ω"]),
        ([Solution(None, omega**3 + omega), Solution(None, omega**3 - omega)], [], ["of degree 3 in ω"]),
        ([Solution(None, k + b)], [], ["of degree 0 in ω"]),
        ([Solution(None, (omega**2 + 1) * (omega**2 + k))], [], ["of degree 4 in ω"]),
        ([Solution(k / m, s, 2 * tau)], ["ω = k/m"], ["so are these plus any multiple of 2 τ."]),
        ([Solution(None, omega * asin(omega))], [], ["in ω and its sines and cosines"]),
    ],
)
def test_a_solution_is_a_formula_or_it_is_told_of_which_degree_its_equation_is(
    solutions: list[Solution], lines: list[str], notes: list[str]
) -> None:
    rows, found = answers(named("omega"), solutions)
    assert [said(x.equation) for x in rows] == lines
    assert len(found) == len(notes)
    for x, words in zip(found, notes, strict=True):
        assert words in said(x)
        assert said(x).endswith(".")


def test_conditions_are_written_out_while_they_are_short() -> None:
    def words(*conditions: Expr) -> list[str]:
        own: Any = Made(omega=k, conditions=conditions, period=0)
        return [said(x) for x in answers(named("w"), [own, own])[1]]

    assert words() == []
    assert words(k - m, b - 1) == ["in force where k - m ≥ 0 and b - 1 ≥ 0."]
    assert words(k - m, sized(5)) == ["a formula is in force where nothing under its roots is negative."]
    assert "≥ 0" in words(sized(4))[0]


# What is asked for by name


def test_what_is_asked_for_is_told_in_turn_and_what_is_none_is_refused_with_all_names() -> None:
    lag = hs.Scene(hs.environments.mass_spring_damper(k=100), (hs.effects.first_order_lag(20),), (0, 15), "0.1")
    d = hs.derive(lag)
    [section] = page.asked(d, ["imdh", "omega_i", "d omega_i/d omega_c"])
    title, notes, lines = told(section)
    assert title == "Formulas"
    assert lines[0].startswith("Im dH = ")
    assert [x.startswith(("ω_i = ", "d ω_i/(d ω_c) = ", "(d ω_i)/(d ω_c) = ")) for x in lines[1:]] == [True] * (
        len(lines) - 1
    )
    assert any("at a crossing. Undefined where the display only touches its threshold." in x for x in notes)
    with pytest.raises(
        SceneError,
        match=r'"nothing" is not a quantity: these are .*omega_perc, d omega_r/d PARAMETER, d omega_i/d PARAMETER',
    ):
        page.canonical("nothing")
    assert page.canonical(" |h_ENV|^2 ") == "|H_env|^2"
    some = hs.derive(lag, ["omega_c"])
    with pytest.raises(SceneError, match=r'"environment.k" does not stay a symbol: omega_c'):
        page.asked(some, ["d omega_r/d environment.k"])
