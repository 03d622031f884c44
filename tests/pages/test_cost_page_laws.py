"""The pages of what accuracy costs, of rows drawn by lot: each row, each sentence and each count against the rows themselves."""

from __future__ import annotations

import random
from math import inf
from statistics import median
from typing import Any

import pytest
from pagewords import flat, lines

import haptisym as hs
from haptisym.verbs.cost.entry import Cost
from haptisym.verbs.cost.hardcases import FAMILIES
from haptisym.verbs.cost.hardcosts import HardCosts
from haptisym.verbs.cost.measurement import HardRow, Measurement, Omission
from haptisym.verbs.cost.summary import duration
from haptisym.writing.document import Figure, Section, Table
from haptisym.writing.plain import said

SCENE = hs.Scene(
    hs.environments.mass_spring_damper(k=100), (hs.effects.first_order_lag(20),), title="Spring", source="a book"
)
ASKED = {
    "evaluate": "The ratios r_r and r_i: time for one frequency",
    "crossings": "The crossings on the band: time for all of them",
    "delay": "The crossings with approximated delays, against the exact ones",
    "effects": "The crossings with an effect left out, against all effects",
    "sweep": "A sweep over sets of parameters: time for a set",
    "simulation": "H_perc recovered from a simulation in time, against the closed form",
}


def cost(*rows: Measurement, left_out: tuple[Omission, ...] = (), **condition: float) -> Cost:
    return Cost(SCENE, rows, left_out, condition, {"processor": "one", "python": "3.11"})


def cell_text(phrase: Any) -> str:
    return said(phrase).replace("\xa0", " ")


def tables(found: Any) -> dict[str, Table]:
    """By the titles of their sections."""
    sections = [x for x in found.document().blocks if isinstance(x, Section)]
    return {cell_text(x.title): y for x in sections for y in x.blocks if isinstance(y, Table)}


def drawn(pick: random.Random, task: str, method: str) -> Measurement:
    counted = pick.random() < 0.6
    return Measurement(
        task, method, pick.choice([3.14159, 15.96, 19.96, 20.0, 30.4, 99.5]), pick.choice([2e-7, 3.21e-4, 0.5, 12.0]), pick.random() < 0.5,
        pick.choice([0, 2]) if counted else 0, pick.choice([0, 1]) if counted else 0,
        *((pick.choice([0, 3]), 250) if task == "sweep" else ()),
    )  # fmt: skip


def wrong(row: Measurement) -> str:
    if row.sets:
        return f"{100 * row.wrong / row.sets:.2g} % of {row.sets} sets" if row.wrong else f"none of {row.sets} sets"
    parts = [f"misses {row.missed}"] * bool(row.missed) + [f"invents {row.invented}"] * bool(row.invented)
    return " and ".join(parts)


def test_each_question_that_was_measured_has_a_table_of_its_methods_in_turn() -> None:
    pick = random.Random(3)
    for _ in range(12):
        tasks = pick.sample(list(ASKED), pick.randint(1, 6))
        rows = [drawn(pick, task, f"way {n}") for task in tasks for n in range(pick.randint(1, 4))]
        pick.shuffle(rows)
        shown = tables(cost(*rows))
        assert list(shown) == [words for task, words in ASKED.items() if task in tasks]
        for task in tasks:
            table, own = shown[ASKED[task]], [x for x in rows if x.task == task]
            heads = [cell_text(x.heading) for x in table.columns]
            assert heads == [
                "method",
                "right digits",
                "time",
                "proven",
                "sets with a wrong count" if task == "sweep" else "",
            ]
            assert [x.number for x in table.columns] == [False, True, False, False, False]
            assert [[cell_text(x) for x in row] for row in table.rows] == [
                [x.method, f"{x.digits:.1f}" if x.digits < 20 else f"{x.digits:.0f}", duration(x.seconds), "yes" if x.proven else "no", wrong(x)] for x in own
            ]  # fmt: skip
            assert cell_text(table.caption) == f"{ASKED[task]}."


def test_a_condition_number_is_told_where_it_is_known_and_may_be_infinite() -> None:
    rows = [Measurement(task, "a", 3.0, 1.0, proven=True) for task in ("evaluate", "crossings", "delay")]
    assert list(tables(cost(*rows, evaluate=1234.5, crossings=inf))) == [
        f"{ASKED['evaluate']} (condition number 1.2e+03)", f"{ASKED['crossings']} (condition number infinite: a touch)", ASKED["delay"],
    ]  # fmt: skip


def test_what_was_left_out_and_what_was_not_reached_is_told_and_on_what_it_was_measured() -> None:
    late = Measurement("sweep", "exact", 15.0, 1.0, proven=True, left_open=7, asked=90)
    found = cost(
        late,
        Measurement("sweep", "grid", 3.0, 1.0, proven=False, wrong=1, sets=50),
        left_out=(Omission("sweep", "roots", "a delay"),),
    )
    text = flat(found)
    assert text.count("exact: 7 of 90 sets were not reached within the limit of time.") == 1
    assert "grid: " not in text
    assert text.count("Left out: roots (a delay).") == 1
    assert text.endswith("Measured on processor one, python 3.11.")
    assert lines(found)[:2] == ["Spring: what accuracy costs", "a book"]
    assert "not reached" not in flat(cost(Measurement("sweep", "exact", 15.0, 1.0, proven=True)))
    figures = [x for x in found.document().blocks if isinstance(x, Figure)]
    assert [(x.name, x.wide) for x in figures] == [("cost", True)]


# The hard cases


def hard(pick: random.Random, family: str, case: str, method: str) -> HardRow:
    verdict = pick.choice(["right", "right", "loses 3 digits", "undecided", "cannot: a delay"])
    return HardRow(
        "evaluate" if family == next(iter(FAMILIES)) else "crossings", method, pick.choice([1.26, 8.0, 15.9]), pick.choice([1e-5, 2e-3, 0.7, 3.0]),
        pick.random() < 0.7, pick.choice([0, 0, 2]), pick.choice([0, 0, 1]), family=family, case=case, condition=pick.choice([5.0, 1e4, inf]),
        ours=pick.random() < 0.5, verdict=verdict,
    )  # fmt: skip


def hard_line(rows: list[HardRow]) -> list[str]:
    own = [x for x in rows if not x.verdict.startswith("cannot")]
    if not own:
        return [rows[0].method, "", "", "", "", rows[0].verdict]
    missed, invented, still = (
        sum(x.missed for x in own),
        sum(x.invented for x in own),
        sum(x.verdict == "undecided" for x in own),
    )
    bad = sorted((x for x in own if x.verdict != "right"), key=lambda x: x.digits)
    counts = [f"misses {missed}"] * bool(missed) + [f"invents {invented}"] * bool(invented)
    told = " and ".join(counts) or (f"{still} undecided, and said so" if still else bad[0].verdict if bad else "")
    right = len([x for x in own if x.verdict == "right"])
    return [
        rows[0].method, f"{right}/{len(own)}", f"{min(x.digits for x in own):.1f}", duration(median([x.seconds for x in own])),
        "no" if [x for x in own if not x.proven] else "yes", told,
    ]  # fmt: skip


@pytest.mark.parametrize("seed", range(8))
def test_a_family_of_hard_cases_tells_its_questions_its_condition_and_a_line_for_each_method(seed: int) -> None:
    pick = random.Random(seed)
    chosen = pick.sample(list(FAMILIES), pick.randint(1, 3))
    rows = [
        hard(pick, family, f"case {n}", f"way {m}")
        for family in chosen for n in range(1 if pick.random() < 0.4 else pick.randint(2, 4)) for m in range(3)
    ]  # fmt: skip
    found = HardCosts(tuple(rows), {"processor": "two"})
    shown, text = tables(found), flat(found)
    assert list(shown) == [f"{name}: {why}" for name, why in FAMILIES.items() if name in chosen]
    for family in chosen:
        own = [x for x in rows if x.family == family]
        table = shown[f"{family}: {FAMILIES[family]}"]
        count, worst = len({x.case for x in own}), max(x.condition for x in own)
        what = "values of r_r and r_i" if own[0].task == "evaluate" else "crossings"
        condition = "infinity" if worst == inf else f"{worst:.2g}"
        assert f"{count} question{'s' if count > 1 else ''} about {what}, condition number up to {condition}." in text
        assert [cell_text(x.heading) for x in table.columns] == ["method", "right", "digits", "time", "proven", ""]
        assert [x.number for x in table.columns] == [False, False, True, False, False, False]
        ways = list(dict.fromkeys(x.method for x in own))
        assert [[cell_text(x) for x in row] for row in table.rows] == [
            hard_line([x for x in own if x.method == way]) for way in ways
        ]
        assert cell_text(table.caption) == f"{family}."
    assert text.endswith("Measured on processor two.")
    figures = [x for x in found.document().blocks if isinstance(x, Figure)]
    assert [(x.name, x.wide) for x in figures] == [("hard-cases", True)]
