"""Nobody gets a false claim past a checker of certificates, nor makes it work for long; and the one in JavaScript says the same."""

from __future__ import annotations

import copy
import json
import random
import subprocess
import sys
from collections.abc import Callable, Iterator
from fractions import Fraction
from functools import cache
from itertools import product
from pathlib import Path
from typing import Any

import pytest
from certificates import HOSTILE, certificate, hostile, of_requirement, of_scene, of_stability, text_of, verdict
from forgeries import LATE_GAIN, evaluated, gain, slab, with_slabs

from haptisym_check import RefusedError, check

# True documents: each with its scene

TWICE = gain("11/10 + (s^2 + 1)*(s^2 + 4)/1000", "1/10", "[1, 3]")
MASS = '[environment]\nmodel = "mass-spring-damper"\nm = 1\n[evaluation]\nband = [0, 9]\n'
CONSTANT = gain("12/10", "1/10", "[0, 15]")
BASES: dict[str, Callable[[], tuple[str, str]]] = {
    "band": lambda: (certificate("fu2019"), text_of("fu2019")),
    "twice": lambda: (of_scene(evaluated(TWICE), TWICE), TWICE),
    "mass": lambda: (of_scene(evaluated(MASS), MASS), MASS),
    "constant": lambda: (of_scene(evaluated(CONSTANT), CONSTANT), CONSTANT),
    "delay": lambda: (certificate("delayed-spring"), text_of("delayed-spring")),
    "power": lambda: (certificate("powers alone"), text_of("powers alone")),
    "roots": lambda: of_stability("unstable, held"),
    "values": lambda: of_requirement("up to a value"),
    "late values": lambda: of_requirement("a threshold above a delay"),
}


@cache
def true(base: str) -> tuple[str, str]:
    return BASES[base]()


def told(base: str) -> Any:
    """A copy to change."""
    return json.loads(true(base)[0])


@pytest.mark.few("twice", "mass", "constant", "late values")
@pytest.mark.parametrize("base", BASES)
def test_what_forgeries_are_made_of_is_accepted(base: str) -> None:
    assert verdict(*true(base)).startswith("Proven")


# One change of a document, by the rule that refuses it

NOT_THAT = "not that of the scene"
F, P, C = "proof.functions", "proof", "claim"
HALF_WAVE = {"waves": [1], "terms": [[[0], [["1"]]]]}
FORGED: dict[str, list[tuple[str, dict[str, Any], str]]] = {
    "the document": [
        ("band", {"format": "haptisym.certificate/2"}, "the format is not"),
        ("band", {"scene_sha256": "0" * 64}, "another scene file"),
        ("band", {"note": ""}, "expected an object with the keys"),
        ("band", {"environment": "a"}, "of at most 100 tables is none"),
        ("band", {"claim.question": "metrics"}, "answers no question"),
        ("band", {"claim.note": ""}, "expected an object with the keys question"),
        ("band", {"proof.note": ""}, "expected an object with the keys"),
        ("band", {"proof.breakpoints.1": "82/011"}, "not written as one"),
        ("band", {"proof.breakpoints.1": "7E1000"}, "not written as one"),
        ("band", {"proof.breakpoints.1": "0"}, "do not ascend"),
        ("band", {"proof.factors.6.step": 3}, "a whole number from 1 to 2"),
        ("band", {"proof.factors.6.polynomial": [["0"], ["0"]]}, "its leading coefficient is 0"),
        ("band", {"claim.crossings.0.multiplicity": True}, "crossings: proven is"),
        ("delay", {"proof.delays": ["0"]}, "not positive"),
        ("delay", {"proof.delays": [f"1/{2**100}"]}, "too large"),
        ("power", {"proof.orders": ["1"]}, "delays or orders"),
        ("delay", {"proof.delays": ["1"] * 3, "proof.orders": ["1/2"] * 2}, "too many"),
        ("roots", {"proof": {"held,imposed": {}}}, "the keys imposed, held"),
        *(("band", {"proof.factors.6.polynomial": [[x], ["1"]]}, "a polynomial is not one") for x in ("1_0", " 1", "\u0661", 1)),
    ],
    "1, functions": [
        ("band", {f"{F}.environment.real": {"number": "0", "powers": []}}, NOT_THAT),
        ("band", {f"{F}.environment.real.number": "-1/5000"}, NOT_THAT),
        ("band", {f"{F}.environment.real.number": "1/5"}, NOT_THAT),
        ("band", {f"{F}.excess.imag.powers": [[1, -1], [2, -2]]}, NOT_THAT),
        ("band", {f"{F}.sum.imag.powers": [[2, -1], [6, 1], [11, 1], [11, 1]]}, "stands twice"),
        ("band", {f"{F}.sum.imag.powers": [[2, -1], [6, 1], [11, True]]}, "a whole number from"),
        ("mass", {f"{F}.environment.imag": {"number": "0", "powers": [[0, 1]]}}, "zero everywhere has no factors"),
        ("delay", {"+proof.factors": HALF_WAVE, f"{F}.perceived.real.powers": [[4, 1], [5, 1], [8, 1]]}, "in a turn"),
        ("delay", {"proof.delays.0": "9/251"}, "the proof has none that it is a multiple of"),
        ("delay", {"proof.delays.0": "18/250"}, "the proof has none that it is a multiple of"),
        ("delay", {"proof.delays.0": "9/500"}, NOT_THAT),
        ("power", {"proof.orders.0": "1/3"}, "no such order"),
    ],
    "2, cells": [
        ("band", {"proof.breakpoints": ["0", "82/11", "15/2", "23/3", "71/9", "15"]}, "may hold two zeros"),
        ("band", {"proof.breakpoints.0": "1"}, "does not hold the low end"),
        ("band", {"proof.breakpoints.6": "14"}, "does not hold the high end"),
        ("twice", {"proof.breakpoints": ["1", "2", "3"]}, "zero at a breakpoint"),
        ("twice", {"proof.breakpoints": ["1/2", "3"]}, "two zeros, or one beside an end"),
        ("power", {"proof.breakpoints": ["0", "30"]}, "a sign stays open"),
        ("delay", {"proof.breakpoints": ["0", "15"]}, "a sign stays open"),
        ("delay", {"proof.breakpoints": ["0", "3/2", "15"]}, "two zeros|stays open"),
    ],
    "3, enclosures": [
        ("twice", {"claim.frequencies.1": ["9/4", "5/2"]}, "holds no zero"),
        ("twice", {"claim.frequencies.1": ["5/2", "3/2"]}, "holds no zero"),
        ("twice", {"claim.frequencies.1": ["1", "5/2"]}, "holds no zero"),
        ("twice", {"claim.frequencies.1": ["3/2", "3"]}, "holds no zero"),
        ("twice", {"claim.frequencies.0": ["3/2", "2"]}, "the low end of the band is not in"),
        ("twice", {"claim.frequencies.2": ["2", "5/2"]}, "the high end of the band is not in"),
        ("twice", {"+claim.frequencies": ["3", "3"]}, "not as many frequencies"),
        ("delay", {"claim.frequencies.1": ["3/2", "2"]}, "holds no zero"),
    ],
    "4, claims": [
        ("band", {"claim.crossings": []}, "crossings: proven is"),
        *(("band", {f"claim.crossings.0.{key}": x}, "crossings: proven is") for key, x in {"at": 4, "part": "imag", "kind": "returns", "sign": -1, "multiplicity": 2}.items()),
        *(("band", {f"claim.percepts.0.{key}": x}, "percepts: proven is") for key, x in {"from": 4, "property": "stiffness", "change": "higher"}.items()),
        ("band", {"claim.transparent": [[0, 6]]}, "transparent: proven is"),
        ("band", {"claim.changeovers.perceived": []}, "changeovers: proven is"),
        ("mass", {"claim.changeovers.environment": [0]}, "changeovers: proven is"),
        ("power", {"claim.changeovers.perceived": [0, 2]}, "changeovers: proven is"),
        ("delay", {"claim.outside_model": []}, "outside_model: proven is"),
        ("band", {"claim.unbounded": [1]}, "unbounded: proven is"),
        ("band", {"claim.stable": False}, "stable: proven is"),
        ("delay", {"claim.stable": True}, "stable: proven is"),
    ],
    "5, roots": [
        ("roots", {"claim.imposed": 1}, "imposed: proven is 2"),
        ("roots", {"claim.held.0.unstable": 1}, "held: proven is"),
        ("roots", {"claim.held.0.hand.k": "136"}, NOT_THAT),
        ("roots", {"claim.held.0.hand": "a"}, "has not one hand"),
        ("roots", {"proof.imposed.factors.0.1.0": "1"}, NOT_THAT),
        ("roots", {"proof.imposed.function": {"number": "0", "powers": []}}, NOT_THAT),
        ("roots", {"proof.held.0.cells.0": []}, "may hold two zeros"),
        ("roots", {"proof.held.0.cells.0": ["101"]}, "may hold two zeros|E is zero"),
        ("roots", {"proof.held.0.cells.0": ["177", "101"]}, "do not ascend"),
        ("roots", {"proof.imposed.cells.0": ["100"]}, "E is zero between two cells"),
        ("roots", {"proof.imposed.cells": [[]]}, "a list of 2 to 2"),
        ("roots", {"claim.imposed": 3, "+proof.imposed.factors": [["-1"], ["1"]], "++proof.imposed.factors": [["-1"], ["1"]],
                   "proof.imposed.cells": [[]] * 4, "+proof.imposed.function.powers": [2, 1], "++proof.imposed.function.powers": [3, -1]}, "the denominator may share it"),
        ("roots", {"+proof.imposed.factors": [["1"], [str(2**61 - 1)]], "++proof.imposed.factors": [["1"], [str(2**61 - 1)]],
                   "proof.imposed.cells": [[]] * 4, "+proof.imposed.function.powers": [2, 1], "++proof.imposed.function.powers": [3, -1]}, "the denominator may share it"),
    ],
    "6, values": [
        ("values", {"claim.values.0.2": False}, "values: proven is"),
        ("values", {"claim.values.0.1": "1/4"}, "values: proven is"),
        ("values", {"claim.binds": ["real"]}, "binds: proven is"),
        ("values", {"claim.parts": ["real"], f"{F}": {"excess.real": {"number": "1/100", "powers": [[0, 1], [1, -1], [2, -2]]}}}, "not on the band|may not be"),
        ("values", {"claim.parts": ["number"], F: {}}, "of no part"),
        ("values", {"claim.free": ["effects", 0, "omega_n"]}, NOT_THAT),
        ("values", {"claim.free": ["effects", -1, "zeta"]}, "a path is not understood"),
        ("values", {"claim.free": ["effects", 0, "tau"]}, "has no such number"),
        ("values", {"proof.slabs.0.points": ["0", "15/2"]}, "do not hold the band"),
        ("values", {"proof.slabs.0.points": ["1", "15"]}, "do not hold the band"),
        ("values", {"proof.slabs.0.points": ["0", "15"]}, "not proven|may be zero|may be positive"),
        ("values", {"proof.slabs.0.part": "imag", "proof.slabs.0.points": ["15"]}, "not proven|may not be positive"),
        ("values", {"proof.slabs.1.points": ["16"]}, "not on the band"),
        ("values", {"proof.slabs.1.points": ["0"]}, "not proven|may not be positive|may be zero"),
        ("values", {"proof.slabs.1.part": ["imag"], "claim.binds": [["imag"]]}, "not on the band|unhashable"),
        ("values", {"proof.slabs.0.to": "3/10", "claim.values.0.1": "3/10"}, "do not ascend|not proven|may be positive"),
        ("values", {"proof.slabs.1.from": "1/10", "claim.values.1.0": "1/10"}, "do not ascend"),
        ("values", {"proof.slabs.2.from": "2", "claim.values.1": ["264345145449365319/1000000000000000000", None, False]}, "more than an end"),
        ("late values", {"proof.delays": []}, "expected a list of 0 to 0"),
        ("late values", {"claim.free": ["effects", 0, "tau"]}, "a delay is negative, or has pi in it"),
        ("late values", {"proof.slabs.1.points": ["0", "15"]}, "stays open|not proven"),
    ],
}  # fmt: skip


def with_changes(base: str, changes: dict[str, Any]) -> tuple[str, str]:
    """Each at its path; ``+``: appended to the list there."""
    document = told(base)
    for path, new in changes.items():
        *above, last = keys_of(document, path.lstrip("+"))
        place = document
        for key in above:
            place = place[key]
        if path[0] == "+":
            place[last].append(new)
        else:
            place[last] = copy.deepcopy(new)
    return json.dumps(document), true(base)[1]


def keys_of(document: Any, path: str) -> Iterator[str | int]:
    """A function's name has a point."""
    words = (
        path.replace(".real", "/real").replace(".imag", "/imag").split(".") if path.startswith(F) else path.split(".")
    )
    for word in words:
        yield int(word) if word.isdigit() else word.replace("/", ".")


@pytest.mark.dear(
    "2, cells-5",
    "3, enclosures-4",
    "4, claims-12",
    "4, claims-14",
    "4, claims-4",
    "6, values-0",
    "6, values-10",
    "6, values-11",
    "6, values-12",
    "6, values-14",
    "6, values-15",
    "6, values-16",
    "6, values-17",
    "6, values-2",
    "the document-12",
    "the document-19",
    "the document-20",
)
@pytest.mark.parametrize(("rule", "number"), [(rule, i) for rule, rows in FORGED.items() for i in range(len(rows))])
def test_each_rule_refuses_what_it_is_there_for(rule: str, number: int) -> None:
    base, changes, why = FORGED[rule][number]
    said = verdict(*with_changes(base, changes))
    assert said.startswith("refused: ")
    assert any(x in said for x in why.split("|")), said


# Forgeries of whole documents: each claims what is false, or means nothing, for a reason that rules could overlook

Forgeries = Iterator[tuple[str, str]]
MADE: list[tuple[Callable[[], Forgeries], str]] = []


def refused_as(why: str) -> Callable[[Callable[[], Forgeries]], Callable[[], Forgeries]]:
    def listed(make: Callable[[], Forgeries]) -> Callable[[], Forgeries]:
        MADE.append((make, why))
        return make

    return listed


@refused_as("a function that is zero everywhere has no factors")
def zero_with_factors() -> Forgeries:
    """An excess that is zero everywhere has no crossings, though factors stand beside the 0."""
    text = gain("11/10", "1/10", "[0, 15]")
    proof = told("constant")
    own = proof["proof"]
    own["poles"], proof["claim"]["stable"] = None, None
    own["factors"], own["breakpoints"] = [{"step": 1, "polynomial": [["-5"], ["1"]]}], ["0", "15"]
    ratios = {"environment": "100", "perceived": "110", "difference": "10", "sum": "210"}
    own["functions"] = {
        f"{x}.{part}": {"number": n if part == "real" else "0", "powers": []}
        for (x, n), part in product(ratios.items(), ("real", "imag"))
    }
    own["functions"] |= {
        "excess.real": {"number": "0", "powers": [[0, 1]]},
        "excess.imag": {"number": "-1/100", "powers": []},
    }
    proof["claim"] |= {
        "frequencies": [["0", "0"], ["5", "5"], ["15", "15"]], "transparent": [[0, 2]], "percepts": [],
        "crossings": [{"at": 1, "part": "real", "kind": "touches", "sign": 1, "multiplicity": 1}],
    }  # fmt: skip
    yield of_scene(proof, text), text
    own["functions"]["excess.real"]["powers"] = [[0, -1]]
    yield of_scene(proof | {"claim": {**proof["claim"], "crossings": [], "unbounded": [1]}}, text), text


@refused_as("a function is nowhere defined")
def denominators_that_vanish_wherever_one_looks() -> Forgeries:
    """(omega - 17) ... (omega - 24) above and below: rule 1 looks at eight places whether a function is defined."""
    p = [1]
    for n in range(17, 25):
        p = [-n * x + y for x, y in zip([*p, 0], [0, *p], strict=True)]
    proof = told("constant")
    proof["proof"]["factors"] += [{"step": 1, "polynomial": [[str(c)] for c in p]}] * 2
    n = len(proof["proof"]["factors"])
    proof["proof"]["functions"]["sum.real"]["powers"] += [[n - 2, 1], [n - 1, -1]]
    yield json.dumps(proof), true("constant")[1]


@refused_as("the degrees are too high")
def factors_of_high_degree_that_cancel() -> Forgeries:
    proof = told("constant")
    proof["proof"]["factors"] += [{"step": 1, "polynomial": [["1"]] * 150}] * 2
    n = len(proof["proof"]["factors"])
    proof["proof"]["functions"]["sum.imag"] = {"number": "1", "powers": [[n - 2, 40], [n - 1, -40]]}
    yield json.dumps(proof), true("constant")[1]


@refused_as("changeovers: proven is")
def order_at_0() -> Forgeries:
    """omega^2 has order 2 at 0, though its square is the variable: a mass does not change its sign there."""
    proof = with_squares(told("mass"))
    assert verdict(proof, MASS).startswith("Proven")
    proof["claim"]["changeovers"] = {"environment": [0], "perceived": [0]}
    yield json.dumps(proof), MASS


def with_squares(proof: dict[str, Any]) -> dict[str, Any]:
    """omega^2 in place of omega omega."""
    factors = proof["proof"]["factors"]
    at = factors.index({"step": 1, "polynomial": [["0"], ["1"]]})
    factors[at] = {"step": 2, "polynomial": [["0"], ["1"]]}
    for x in proof["proof"]["functions"].values():
        x["powers"] = [[i, n // 2 if i == at else n] for i, n in x["powers"]]
    return proof


@refused_as("an enclosure holds no zero")
def enclosure_at_the_end() -> Forgeries:
    """A factor with one zero at the end of the band has another in the cell beside it, and that is not where the first is."""
    proof = told("twice")
    factors = proof["proof"]["factors"]
    first, second = (factors.index({"step": 2, "polynomial": [[str(-n)], ["1"]]}) for n in (1, 4))
    factors[first] = {"step": 2, "polynomial": [["4"], ["-5"], ["1"]]}
    factors[second] = {"step": 2, "polynomial": [["1"]]}
    assert verdict(proof, TWICE).startswith("Proven")
    for wrong in (["1", "1"], ["1", "1.5"]):
        proof["claim"]["frequencies"][1] = wrong
        yield json.dumps(proof), TWICE


@refused_as("the slabs do not ascend")
def past_infinity() -> Forgeries:
    """Values ascend: behind those without a bound above there are none."""
    proof = told("values")
    last = proof["proof"]["slabs"][-1]
    below = {**last, "from": None, "to": "-100000"}
    for slabs in ([last, below], [{**last, "from": "100000"}, {**below, "to": "200000"}]):
        proof["proof"]["slabs"] = slabs
        proof["claim"] |= {"values": [[slabs[0]["from"], slabs[1]["to"], False]], "binds": []}
        yield json.dumps(proof), true("values")[1]


@refused_as("the band is empty")
def no_band() -> Forgeries:
    """On a band that ends before it begins nothing is transparent, and everything."""
    proof, text = of_requirement("none")
    empty = text.replace('["0 rad/s", "15 rad/s"]', "[15, 0]")
    other = json.loads(proof)
    other["proof"]["slabs"] = [{"from": "1", "to": "2", "points": ["5"], "part": None}]
    other["claim"] |= {"values": [["1", "2", True]], "binds": []}
    yield of_scene(other, empty), empty


@refused_as("has not one hand")
def hands() -> Forgeries:
    """A hand is one, and has a mass, a damping and a stiffness alone."""
    proof, text = told("roots"), true("roots")[1]
    own = proof["claim"]["held"][0]["hand"]
    hand = "".join(f'{key} = "{own[key]}"\n' for key in "mbk")
    proof["claim"]["held"][0]["hand"] = "a"
    named = f'{text}\n[[hands]]\nname = "a"\n'
    assert verdict(of_scene(proof, named + hand), named + hand).startswith("Proven")
    for listed in (
        f'k = 1\n[[hands]]\nname = "a"\n{hand}',
        f'model = "two-mass"\n{hand}',
        'model = "expression"\nH = "8*s + 400"\n',
    ):
        yield of_scene(proof, named + listed), named + listed


@refused_as("of at most 100 tables is none|not one environment|is no TOML")
def scene_of_another_kind() -> Forgeries:
    """Tables of a scene that are none, or lists of what is none."""
    proof, text = told("roots"), true("roots")[1]
    proof["claim"]["held"][0]["hand"] = "hand"
    for line in ("hand = 5", "hands = 5", "hands = [5]", "environments = 5", "environments = [{}]", "effects = 5"):
        yield of_scene(proof, f"{line}\n{text}"), f"{line}\n{text}"
    other = text.replace("[environment]", '[[environments]]\nname = ["a"]')
    yield of_scene(proof | {"environment": ["a"]}, other), other


@refused_as("holds no zero|stays open|no such order")
def orders_that_are_another_ones() -> Forgeries:
    """The functions of x + j y are those of every order, and what follows is not."""
    for old, new in (("0.3", "0.31"), ("0.3", "0.300000001"), ("0.3", "0.7")):
        other, proof = (
            text_of("a spring-pot").replace(f"alpha = {old}", f"alpha = {new}"),
            json.loads(certificate("a spring-pot")),
        )
        for orders in ([old], [new]):
            proof["proof"]["orders"] = orders
            yield of_scene(proof, other), other


@refused_as("is not proven|stays open|may be zero|not on the band|may not be positive")
def values_beside_delays() -> Forgeries:
    """An end that belongs to a slab is one of its values; at no other frequency than 0, nor for all of the band, is it shown there."""
    for point in ("0", "1/1000000", "1"):
        yield with_slabs(slab("1", "2", [point]), slab("2", "3", [point])), LATE_GAIN
        yield with_slabs(slab("1", "3", [point])), LATE_GAIN
    for points, ends in product((["0", "1"], ["0", "1/2", "1"]), (("1", "2"), ("2", "3"), ("199/100", "201/100"))):
        yield with_slabs(slab(*ends, points, None)), LATE_GAIN
    yield with_slabs(slab("2", "3", ["-1"])), LATE_GAIN
    yield with_slabs(slab("2", "3", ["1/2"], "imag")), LATE_GAIN


@refused_as("nested too deeply|is no JSON")
def claims_as_deep_as_there_is_room() -> Forgeries:
    good, text = told("band"), true("band")[1]
    for depth, place in product((20, 100, 990), ("claim", "proof", "scene_sha256")):
        yield json.dumps({**good, place: "?"}).replace('"?"', "[" * depth + "]" * depth), text


@refused_as("a key stands twice|is no JSON|not written as one|expected|a file is too large|answers no question")
def other_spellings() -> Forgeries:
    proof, text = true("twice")
    for wrong in (
        "", "[]", '{"format": NaN}', '{"format": 1.5}', '{"format": "\\ud800"}', proof.replace('"real"', '"re\\u0061l'), proof.replace('"at": ', '"\\u0061t": 1, "at": '),
        proof.replace("[[0, ", "[[-0.0, "), proof.replace("[[0, ", "[[0e0, "), proof.replace(" ", "\u00a0"), proof.replace('["2", "2"]', '["٢", "2"]'), f"[{proof}]",
        proof.replace('["2", "2"]', '[" 2", "2"]'), proof + " " * 4_000_000,
    ):  # fmt: skip
        assert wrong != proof
        yield wrong, text


@pytest.mark.dear(
    "enclosure_at_the_end", "hands", "no_band", "orders_that_are_another_ones", "past_infinity", "values_beside_delays"
)
@pytest.mark.parametrize("make", [x for x, _ in MADE], ids=lambda x: x.__name__)
def test_forged_documents_are_refused_for_the_reason_that_they_were_made_for(make: Callable[[], Forgeries]) -> None:
    why = dict(MADE)[make].split("|")
    listed = [*make()]
    assert listed
    for proof, scene in listed:
        said = verdict(proof, scene)
        assert said.startswith("refused: "), proof[:500]
        assert any(x in said for x in why), said


OTHERS: dict[str, list[tuple[str, str, str]]] = {
    "fu2019": [
        *((old, new, NOT_THAT) for old, new in (("zeta = 0.5", "zeta = 0.51"), ('"80 rad/s"', '"80 Hz"'), ('"1.8 kg"', '"1.8 g"'), ("jnd = 0.10", "jnd = 0.11"))),
        ("jnd = 0.10", "jnd = { real = 0.1, imag = 0.2 }", NOT_THAT), ("[evaluation]", '[[effects]]\nmodel = "series"\nG = "2"\n[evaluation]', NOT_THAT), ('"1.8 kg"', '"1.8 N"', "wrong dimension"),
    ],
    "powers alone": [
        ("mm", "mm^0.5", "is not rational"), ("s^0.5", "ms^0.5", "is not rational"), ("s^0.5", "s^.5*(m)^0.5", "not understood"), ('"1/2"', '"1/2 m"', "wrong dimension"),
        ('"1/2"', "[0.4, 0.6, 0.8]", "no such order"),
    ],
    "a clock": [("tustin", "backward-difference", NOT_THAT), ("delay = 1", "delay = 2", NOT_THAT), ("2 ms", "1 ms", "is a multiple of"), ("2 ms", "2.001 ms", "is a multiple of")],
    "orders of a formula": [
        ("s^(1.3)", "s^1.4", "no such order"), ("s^(1.3)", "s^0.3", NOT_THAT), ("s^(1.3)", "(s)^1.3", "is not known"), ("s^(1.3)", "s*z", "is not known"), ("s^(1.3)", "30^0.3*s", "is not known"),
    ],
}  # fmt: skip


@pytest.mark.dear("fu2019")
@pytest.mark.few("fu2019", "powers alone")
@pytest.mark.parametrize("name", OTHERS)
def test_a_certificate_is_none_of_a_scene_with_other_numbers(name: str) -> None:
    text, proof = text_of(name), json.loads(certificate(name))
    for old, new, why in OTHERS[name]:
        assert old in text
        assert why in verdict(of_scene(proof, text.replace(old, new)), text.replace(old, new)), new


# Any change at all


def changes_of(x: Any, at: tuple[str | int, ...] = ()) -> Iterator[tuple[tuple[str | int, ...], Any]]:
    """What may stand at each place instead of what stands there."""
    if isinstance(x, dict):
        for key in x:
            yield at, {k: y for k, y in x.items() if k != key}
            yield from changes_of(x[key], (*at, key))
    elif isinstance(x, list):
        for i in range(len(x)):
            yield at, x[:i] + x[i + 1 :]
            yield at, x[: i + 1] + x[i:]
            yield from changes_of(x[i], (*at, i))
        yield at, x[::-1]
    elif isinstance(x, bool) or x is None:
        yield from ((at, y) for y in (True, False, None, 1, 0, "0"))
    elif isinstance(x, int):
        yield from ((at, y) for y in (x + 1, x - 1, -x, float(x), str(x), True))
    elif x.lstrip("-").replace("/", "").replace(".", "").isdigit():
        n = Fraction(x)
        yield from (
            (at, str(y)) for y in (n + 1, -n, 2 * n, n * (1 + Fraction(1, 10**9)), n * (1 - Fraction(1, 10**9)))
        )
    else:
        yield from ((at, y) for y in ("", "real", "imag", "touches", "higher", 7, None))


def means_the_same(claim: dict[str, Any], own: dict[str, Any]) -> bool:
    """Whether only enclosures differ, and hold what they held."""
    ends = [
        [Fraction(x) for x in (*a, *b)]
        for a, b in zip(claim.get("frequencies", ()), own.get("frequencies", ()), strict=True)
    ]
    return {**claim, "frequencies": 0} == {**own, "frequencies": 0} and all(a <= d and c <= b for a, b, c, d in ends)


QUESTIONS = {
    **{f"the band: {x}": (certificate, x) for x in ("fu2019", "touches", "delayed-spring", "powers alone")},
    **{f"roots: {x}": (of_stability, x) for x in ("unstable, held", "on the axis")},
    **{f"values: {x}": (of_requirement, x) for x in ("up to a value", "a threshold", "a threshold above a delay")},
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize(
    ("about", "count"),
    [
        *((x, 20) for x in ("the band: touches", "roots: unstable, held", "values: a threshold")),
        *(pytest.param(x, 80, marks=pytest.mark.slow) for x in QUESTIONS),
    ],
)
def test_whatever_is_changed_a_document_is_refused_or_claims_the_same(about: str, count: int) -> None:
    """So many of all changes, chosen by lot."""
    make, name = QUESTIONS[about]
    found: Any = make(name)
    proof, scene = (found, text_of(name)) if isinstance(found, str) else found
    own, refused = json.loads(proof), 0
    for path, new in random.Random(about).sample([*changes_of(own)], count):
        other = {"": copy.deepcopy(own)}
        *above, last = "", *path
        place: Any = other
        for key in above:
            place = place[key]
        place[last] = new
        said = verdict(other[""], scene)
        refused += said.startswith("refused")
        assert said.startswith("refused") or means_the_same(other[""]["claim"], own["claim"]), (path, new)
    assert refused > count // 2


# How documents may be written


def test_json_may_be_written_in_every_way_but_in_utf_8_alone() -> None:
    proof, text = true("twice")
    for same in (
        proof.replace('"real"', '"re\\u0061l"'), proof.replace("[[0, ", "[[-0, "), proof.replace('["2", "2"]', '["-0.2E1", "4/2"]').replace('"-0.2', '"0.2'),
        json.dumps(json.loads(proof), indent="\t").replace("\n", "\r\n"), proof + " " * (4_000_000 - len(proof)),
    ):  # fmt: skip
        assert same != proof
        assert verdict(same, text).startswith("Proven")
    for encoding in ("utf-16", "utf-32", "utf-8-sig"):
        with pytest.raises(RefusedError):
            check(proof.encode(encoding), text.encode())


def test_a_claim_is_told_in_lines_that_no_name_of_a_scene_can_forge() -> None:
    proof = told("band")
    ends, at = proof["claim"]["frequencies"], proof["claim"]["crossings"][0]["at"]
    ends[0], ends[-1], ends[at] = ["-1000", "1000"], ["-5", "1E9"], ["7.97", "7.99"]
    lines = verdict(proof, true("band")[1]).splitlines()
    assert lines[0] == "Proven on the band from [-1000, 1000] to [-5, 1E9] rad/s: 2 crossings, none missed."
    assert "  real part exceeds its threshold at [7.97, 7.99] rad/s" in lines
    proof, text = told("roots"), true("roots")[1]
    own, name = proof["claim"]["held"][0]["hand"], "x: 0 roots\n  held in the hand y"
    held = f"{text}\n[[hands]]\nname = {json.dumps(name)}\n" + "".join(f'{key} = "{own[key]}"\n' for key in "mbk")
    proof["claim"]["held"][0]["hand"] = name
    assert len(verdict(of_scene(proof, held), held).splitlines()) == 2


# Work


@pytest.mark.slow
@pytest.mark.few("deep", "slabs without end")
@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_documents_are_refused_within_twenty_seconds_of_work_and_600_megabytes(
    name: str, tmp_path: Path
) -> None:
    proof, scene = tmp_path / "proof.json", tmp_path / "scene.toml"
    proof.write_text(dict(hostile())[name], encoding="utf-8")
    scene.write_text(text_of("fu2019"), encoding="utf-8")
    code = (
        "import resource, sys\nfrom haptisym_check.__main__ import main\n"
        "resource.setrlimit(resource.RLIMIT_AS, (600_000_000,) * 2)\n"
        "resource.setrlimit(resource.RLIMIT_CPU, (20, 20))\nsys.exit(main(sys.argv[1:]))"
    )
    command = [sys.executable, "-c", code, str(proof), str(scene)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode in (1, 2)
    assert (done.stdout + done.stderr).startswith(("NOT proven: ", "the certificate is no JSON: "))


# Documents that are wrong in ways of their own


def test_a_document_that_is_wrong_as_a_whole_is_refused() -> None:
    forged = [
        *past_infinity(),
        *other_spellings(),
        *zero_with_factors(),
        *no_band(),
        *hands(),
        *scene_of_another_kind(),
        *enclosure_at_the_end(),
    ]
    assert len(forged) > 10
    for i, (proof, scene) in enumerate(forged):
        assert verdict(proof, scene).startswith("refused"), i
