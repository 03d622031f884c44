"""What an answer about one parameter says of its parts: its document, its formulas, and each thing asked by itself."""

from __future__ import annotations

from dataclasses import replace
from random import Random
from types import SimpleNamespace
from typing import Any

import pytest
from sympy import Integer, Rational, Symbol, asin, symbols

import haptisym as hs
from haptisym.judge.bounds import ANY_ENVIRONMENT
from haptisym.judge.criteria import PASSIVE, Criterion, noticed
from haptisym.kernel.errors import LimitError, UndecidedError
from haptisym.kernel.reals import ExactNumber, Sliver
from haptisym.verbs.require.feasible import Binding, End, Kind, Solved, Span, bound_ends, spanned
from haptisym.verbs.require.freeparameter import Domain
from haptisym.verbs.require.nearest import Nearest
from haptisym.verbs.require.required import Requirement
from haptisym.verbs.require.wishes import STABLE, SUITS_ALL

SCENE = hs.load_scene("fu2019")
REAL, IMAG = noticed(SCENE.threshold)
HELD = Criterion(STABLE, "stable", "", "", REAL.measure)
HANDS = Criterion(SUITS_ALL, "suits all", "", "", REAL.measure)


def number(x: Any) -> ExactNumber:
    return ExactNumber(Rational(x))


def binding(pick: Random) -> Binding:
    criterion = pick.choice([REAL, IMAG, HELD, PASSIVE, ANY_ENVIRONMENT])
    return Binding(criterion, pick.choice([None, number(pick.randint(0, 15))]), pick.choice([*Kind]))


def told(b: Binding) -> dict[str, Any]:
    """What a document has of something that binds: the part of what is felt, or what else was asked."""
    part = {"real": "real", "imag": "imag"}.get(b.criterion.name)
    name = b.criterion.name if b.criterion in (HELD, PASSIVE) else "transparent"
    return {"part": part, "criterion": name, "omega": b.omega and float(b.omega), "kind": b.kind.value}


def drawn(pick: Random) -> tuple[Requirement, dict[str, Any]]:
    """An answer made of parts, and these."""
    marks = sorted(pick.sample(range(1, 40), 4))

    def end(x: int) -> End:
        bindings = tuple(binding(pick) for _ in range(pick.choice([0, 1, 1, 2])))
        return End(number(x), pick.random() < 0.5, bindings)

    spans = [Span(end(a), end(b)) for a, b in (marks[:2], marks[2:])][: pick.randint(0, 2)]
    if spans and pick.random() < 0.4:
        spans[0] = Span(End(None), spans[0].high)
    if spans and pick.random() < 0.4:
        alone = replace(spans[-1].low)  # another end that is the same
        spans[-1] = Span(spans[-1].low, alone if pick.random() < 0.5 else End(None))
    undecided = pick.choice([(), ((None, number(50)), (number(60), None)), ((number(50), number(51)),)])
    low, high = pick.choice([(None, None), (Integer(0), None), (Integer(0), Integer(99))])
    criteria = tuple(pick.sample([REAL, IMAG, HELD, HANDS], pick.randint(1, 4)))
    limit, reason = pick.choice([None, 7.0]), pick.choice(["", "friction"])
    that = pick.choice([("transparent",), ("transparent", "stable")])
    found = Requirement(
        SCENE, SCENE.knobs["omega_n"], Domain(low, high), tuple(spans), undecided, criteria, 20, limit, that, reason
    )
    ends = list(dict.fromkeys(x for span in spans for x in (span.low, span.high) if x.bindings))
    forms = tuple(pick.choice([None, asin(Symbol("c")) / (n + 2)]) for n in range(len(ends)))
    near = pick.choice([None, Nearest(number(3), number(Rational(3, 2)), binding(pick), 1.5, 1.25)])
    found.__dict__.update(forms=forms, nearest=near)
    return found, {"ends": ends, "forms": forms, "near": near}


@pytest.mark.parametrize("seed", range(6))
def test_a_document_of_a_requirement_holds_what_its_parts_say(seed: int) -> None:
    pick = Random(seed)
    for _ in range(20):
        found, parts = drawn(pick)
        row = found.to_dict()
        low, high = (x and float(x) for x in (found.domain.low, found.domain.high))
        assert row["range"] == [0.0 if found.domain.low == 0 else low, high]
        assert (row["free"], row["unit"], row["band"]) == ("effects.filter.omega_n", "rad/s", [0.0, 15.0])
        assert row["condition"] == [x.name for x in found.criteria]
        assert row["criteria"] == list(found.that)
        assert row["feasible"] == found.spans() == [[value(x.low), value(x.high)] for x in found.feasible]
        assert row["ends"] == [[digits(span.low), digits(span.high)] for span in found.feasible]
        ends = parts["ends"]
        assert list(found.ends) == list(bound_ends(found.feasible)) == ends
        forms = dict(zip(ends, parts["forms"], strict=True))
        rows = [
            {"at": value(x), **told(b), "closed_form": forms[x] and str(forms[x])} for x in ends for b in x.bindings
        ]
        assert row["binding"] == rows
        pairs = [[None if x is None else float(x) for x in pair] for pair in found.undecided]
        assert (row["undecided"], row["certified"], found.certified) == (pairs, not pairs, not pairs)
        near = parts["near"]
        assert ("nearest" in row) is (near is not None)
        if near:
            assert row["nearest"] == {"value": 3.0, "ratio": 1.5, **told(near.binding), "times": 1.5, "at_least": 1.25}
        assert row.get("limit") == (found.limit if pairs else None)
        assert row.get("reason") == (found.reason or None if pairs else None)
        assert found.rows() == {
            **{key: row[key] for key in ("feasible", "binding", "undecided", "certified")},
            **({"reason": found.reason} if pairs and found.reason else {}),
        }
        assert row["closed_form"] == found.closed_form == formula(found, forms)
        line = " or ".join(map(spanned, found.feasible)) or "none will do"
        assert found._line().endswith(f": effects.filter.omega_n (rad/s): {line}")


def value(x: End) -> float | None:
    return None if x.value is None else float(x.value)


def digits(x: End) -> dict[str, Any] | None:
    if x.value is None:
        return None
    return {"digits": x.value.digits(20), "enclosure": list(x.value.enclosure(20)), "closed": x.closed}


def formula(found: Requirement, forms: dict[End, Any]) -> str | None:
    """The inequalities, where each end at which something binds has a formula; None where one has none, or none binds."""
    if not forms or None in forms.values():
        return None
    rows = []
    for span in found.feasible:
        if span.low == span.high:
            rows += [f"omega_n = {forms[span.low]}"] if span.low in forms else []
            continue
        own = [f"omega_n {sign} {forms[x]}" for x, sign in ((span.low, ">="), (span.high, "<=")) if x in forms]
        rows += [" and ".join(own)] if own else []
    return " or ".join(rows)


def test_of_a_value_at_which_nothing_binds_no_formula_is_written() -> None:
    """Alone, or without bound; beside an interval with one."""
    edge = Binding(REAL, number(15), Kind.EDGE)
    free, whole = SCENE.knobs["omega_n"], Domain(None, None)
    for span in (Span(End(number(1), closed=True), End(number(1), closed=True)), Span(End(None), End(None))):
        found = Requirement(SCENE, free, whole, (span, Span(End(number(7), True, (edge,)), End(None))))  # noqa: FBT003
        found.__dict__["forms"] = (Symbol("x"),)
        assert found.closed_form == "omega_n >= x"


def test_a_number_without_a_unit_has_none_in_its_line() -> None:
    found = hs.require(SCENE, "zeta")
    assert ": effects.filter.zeta: " in found._line()


@pytest.mark.parametrize(
    ("gain", "asked", "end", "told"),
    [
        ("1 + s^2*((q-5)^2 + 1)/1000", (0, 10), 5, "q = (5*omega_max - sqrt(1000*c - omega_max**2))/omega_max"),
        ("1 + s^2*q^2/1000", (1, 10), 1, "q = 10*sqrt(10)*sqrt(c)/omega_max"),
        ("1 + s^2*q^2/1000", (0, 1), 1, "q <= 10*sqrt(10)*sqrt(c)/omega_max"),
    ],
)
def test_one_value_that_alone_will_do_is_written_as_an_equation(gain: str, asked: Any, end: float, told: str) -> None:
    """r_r = omega^2 ((q - 5)^2 + 1)/1000, or omega^2 q^2/1000, on a spring, is 1/10 at 10 rad/s for one value."""
    series = hs.effects.series(gain, parameters={"q": 2})
    scene = hs.Scene(hs.environments.mass_spring_damper(k=100), (series,), (0, 10))
    found = hs.require(scene, "q", asked)
    [span] = found.feasible
    assert span.high.value is not None
    assert float(span.high.value) == end
    assert found.closed_form == told


# --- formulas ---------------------------------------------------------------------------------------------------------


def test_a_formula_is_sought_for_a_positive_end_at_which_something_binds_at_an_end_of_the_band(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Of what binds, in turn; with the values of all symbols, of c, and of the end of the band."""
    asked, answers = list[Any](), list[Any]()
    c, most, least = symbols("c omega_max omega_min", positive=True)

    def closed_form(condition: Any, free: Any, place: Any, known: Any, value: str) -> Any:
        asked.append((condition, free, place, known[place], next(y for x, y in known.items() if str(x) == "c"), value))
        return answers[len(asked) - 1]

    monkeypatch.setattr("haptisym.verbs.require.required.closed_form", closed_form)
    found = Requirement(SCENE, SCENE.knobs["omega_n"], Domain(None, None), (), criteria=(IMAG, REAL))
    monkeypatch.setattr(Requirement, "_symbolic", lambda _, x: None if x is HELD else f"of {x.name}")
    symbol, text = SCENE.knobs["omega_n"].symbol, number(7).digits(60)
    edge, start = Binding(REAL, number(15), Kind.EDGE), Binding(IMAG, number(2), Kind.START)
    inside, at_rest = Binding(REAL, number(3), Kind.TOUCH), Binding(REAL, number(0), Kind.START)
    nowhere = Binding(REAL, None, Kind.EDGE)
    of_edge = ("of real", symbol, most, SCENE.band[1], REAL.threshold, text)
    of_start = ("of imag", symbol, least, SCENE.band[0], IMAG.threshold, text)
    for bindings, given, told_, expected in (
        ((edge,), [c], [of_edge], c), ((start,), [c], [of_start], c), ((inside, at_rest, nowhere), [], [], None),
        ((inside, edge), [c], [of_edge], c), ((edge, start), [None, c], [of_edge, of_start], c),
        ((edge, start), [None, None], [of_edge, of_start], None), ((), [], [], None),
        ((Binding(HELD, number(15), Kind.EDGE), edge), [], [], None),
    ):  # fmt: skip
        asked.clear()
        answers[:] = given
        assert found.form(End(number(7), closed=True, bindings=bindings)) == expected
        assert asked == told_
    for at in (None, number(0), number(-3), Sliver(7, 8)):  # type: ignore[arg-type]
        asked.clear()
        assert found.form(End(at, closed=True, bindings=(edge,))) is None
        assert asked == []
    answers[:] = [c, None]
    spans = tuple(Span(End(number(x), closed=True, bindings=(edge,)), End(None)) for x in (7, 9))
    both = Requirement(SCENE, SCENE.knobs["omega_n"], Domain(None, None), spans, criteria=(IMAG, REAL))
    asked.clear()
    assert both.forms == (c, None)


def test_a_condition_is_written_in_symbols_unless_it_is_of_a_region_a_formula_or_as_long_as_a_book() -> None:
    found = hs.require(SCENE, "omega_n")
    assert found._symbolic(REAL) is not None
    own: Any = found._symbolic(REAL)
    names = {str(x) for x in own.axis.meanings}
    assert {"m", "b", "k", "omega_n", "zeta", "c"} <= names
    for jnd in ({"shape": "diamond", "real": 0.1, "imag": 0.1}, {"real": "0.1 + omega/100", "imag": 0.1}):
        other = noticed(hs.Scene(SCENE.environment, SCENE.effects, SCENE.band, jnd).threshold)
        assert found._symbolic(other[0]) is None
    for above, below, is_short in ((10, 1, True), (2500, 2, True), (2501, 2, False), (5001, 1, False)):
        difference = SimpleNamespace(numerator=long(above), denominator=long(below))
        scene = SimpleNamespace(symbolic_distortion=lambda x=difference: SimpleNamespace(difference=x))
        asked: Any = SimpleNamespace(scene=scene)
        if is_short:
            with pytest.raises(AttributeError):  # it goes on to what is no distortion
                Requirement._symbolic(asked, REAL)
        else:
            assert Requirement._symbolic(asked, REAL) is None


def long(count: int) -> Any:
    """A polynomial of so many terms."""
    return SimpleNamespace(monoms=lambda: [0] * count)


# --- each thing alone -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(4))
def test_where_nothing_will_do_each_thing_that_was_asked_is_told_by_itself(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What is felt together, and stability and the hands each alone; not where something will do, or one thing was asked."""
    pick = Random(seed)
    for _ in range(30):
        found, _ = drawn(pick)
        if pick.random() < 0.7:
            left = pick.choice([(), (), found.undecided])
            found = Requirement(SCENE, found.free, found.domain, (), left, found.criteria, that=found.that)
        asked: list[Any] = []
        error = pick.choice([None, None, None, UndecidedError("open"), LimitError("over")])

        def solve_all(
            scene: Any, free: Any, domain: Any, criteria: Any, asked: Any = asked, error: Any = error
        ) -> Solved:
            asked.append(criteria)
            if error and len(asked) == 2:
                raise error
            return Solved((), ((None, None),), ", ".join(x.name for x in criteria))

        monkeypatch.setattr("haptisym.verbs.require.required.solve_all", solve_all)
        felt = tuple(x for x in found.criteria if x in (REAL, IMAG))
        groups = [*([felt] if felt else []), *((x,) for x in found.criteria if x not in (REAL, IMAG))]
        told_ = found.alone
        if found.feasible or found.undecided or len(groups) < 2:
            assert (told_, asked) == ((), [])
        elif error:
            assert told_ == ()
        else:
            assert [x.criteria for x in told_] == asked == groups
            for x, group in zip(told_, groups, strict=True):
                names = ", ".join(y.name for y in group)
                assert (x.undecided, x.reason, x.that, x.feasible) == (((None, None),), names, (), ())
                assert (x.free, x.domain) == (found.free, found.domain)
