"""Certificates made to deceive a checker: each claims what is false, or means nothing, for a reason that rules could overlook."""

from __future__ import annotations

import copy
import hashlib
import json
from collections.abc import Iterator
from functools import cache
from typing import Any

from certificates import certificate, of_requirement, of_stability, text_of

import haptisym as hs

W = {"step": 2, "polynomial": [["0"], ["1"]]}


def gain(series: str, jnd: str, band: str) -> str:
    """A spring of 100 N/m that is felt times something."""
    return (
        '[environment]\nmodel = "kelvin-voigt"\nk = 100\nb = 0\n'
        f'[[effects]]\nmodel = "series"\nG = "{series}"\n[evaluation]\nband = {band}\njnd = "{jnd}"\n'
    )


def evaluated(text: str) -> dict[str, Any]:
    """A true certificate."""
    return json.loads(hs.evaluate(hs.parse_scene(text)).certificate())  # type: ignore[no-any-return]


def of_scene(proof: Any, text: str) -> str:
    """The certificate with that scene's hash."""
    return json.dumps({**proof, "scene_sha256": hashlib.sha256(text.encode()).hexdigest()})


@cache
def forgeries() -> dict[str, tuple[str, str]]:
    """Certificate and scene of each."""
    found = [_zero_with_factors, _order_at_0, _enclosure_at_the_end, _past_infinity, _no_band, _places_from_behind]
    every = [
        *found,
        _hands,
        _binding_in_a_list,
        _keys_with_a_comma,
        _prime,
        _scene_of_another_kind,
        _claims_of_another_kind,
        _powers,
        _values_beside_delays,
        _delays_and_orders_that_are_free,
    ]
    return {f"{f.__name__.strip('_')} {i}": pair for f in every for i, pair in enumerate(f())}


def _zero_with_factors() -> Iterator[tuple[str, str]]:
    """An excess that is zero everywhere has no crossings, though factors stand beside the 0."""
    text = gain("11/10", "1/10", "[0, 15]")
    proof = evaluated(gain("12/10", "1/10", "[0, 15]"))
    own = proof["proof"]
    own["poles"], proof["claim"]["stable"] = None, None
    own["factors"], own["breakpoints"] = [{"step": 1, "polynomial": [["-5"], ["1"]]}], ["0", "15"]
    ratios = {"environment": "100", "perceived": "110", "difference": "10", "sum": "210"}
    own["functions"] = {
        f"{x}.{part}": {"number": n if part == "real" else "0", "powers": []}
        for x, n in ratios.items()
        for part in ("real", "imag")
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


def _order_at_0() -> Iterator[tuple[str, str]]:
    """omega^2 has order 2 at 0, though its square is the variable: a mass does not change its sign there."""
    text = '[environment]\nmodel = "mass-spring-damper"\nm = 1\n[evaluation]\nband = [0, 9]\n'
    proof = with_squares(evaluated(text))
    proof["claim"]["changeovers"] = {"environment": [0], "perceived": [0]}
    yield of_scene(proof, text), text


def with_squares(proof: dict[str, Any]) -> dict[str, Any]:
    """omega^2 in place of omega omega."""
    other = copy.deepcopy(proof)
    factors = other["proof"]["factors"]
    at = factors.index({"step": 1, "polynomial": [["0"], ["1"]]})
    factors[at] = W
    for x in other["proof"]["functions"].values():
        x["powers"] = [[i, n // 2 if i == at else n] for i, n in x["powers"]]
    return other


def _enclosure_at_the_end() -> Iterator[tuple[str, str]]:
    """A factor with one zero at the end of the band has another in the cell beside it, and that is not where the first is."""
    text = gain("11/10 + (s^2 + 1)*(s^2 + 4)/1000", "1/10", "[1, 3]")
    proof = together(evaluated(text))
    for wrong in (["1", "1"], ["1", "1.5"]):
        proof["claim"]["frequencies"][1] = wrong
        yield of_scene(proof, text), text


def together(proof: dict[str, Any]) -> dict[str, Any]:
    """(omega^2 - 1)(omega^2 - 4) as one factor."""
    other = copy.deepcopy(proof)
    factors = other["proof"]["factors"]
    first, second = (factors.index({"step": 2, "polynomial": [[str(-n)], ["1"]]}) for n in (1, 4))
    factors[first] = {"step": 2, "polynomial": [["4"], ["-5"], ["1"]]}
    factors[second] = {"step": 2, "polynomial": [["1"]]}
    return other


def _past_infinity() -> Iterator[tuple[str, str]]:
    """Values ascend: behind those without a bound above there are none."""
    proof, text = of_requirement("from a value on")
    told = json.loads(proof)
    last = told["proof"]["slabs"][-1]
    below = {**last, "from": None, "to": "-100000"}
    for slabs in ([last, below], [{**last, "from": "100000"}, {**below, "to": "200000"}]):
        other = copy.deepcopy(told)
        other["proof"]["slabs"] = slabs
        other["claim"] |= {"values": [[slabs[0]["from"], slabs[1]["to"], True]], "binds": []}
        yield json.dumps(other), text


def _no_band() -> Iterator[tuple[str, str]]:
    """On a band that ends before it begins nothing is transparent."""
    proof, text = of_requirement("none")
    empty = text.replace('["0 rad/s", "15 rad/s"]', "[15, 0]")
    told = json.loads(proof)
    slab = {"from": "1", "to": "2", "points": ["5"], "part": None}
    told["proof"]["slabs"], told["claim"]["values"], told["claim"]["binds"] = [slab], [["1", "2", True]], []
    yield of_scene(told, empty), empty


def _places_from_behind() -> Iterator[tuple[str, str]]:
    """Places in lists count from 0 on, and are numbers."""
    proof, text = of_requirement("up to a value")
    for place in (-1, False):
        told = json.loads(proof)
        told["claim"]["free"][1] = place
        yield json.dumps(told), text


def _hands() -> Iterator[tuple[str, str]]:
    """A hand is one, and has a mass, a damping and a stiffness alone."""
    proof, text = of_stability("a hand")
    told = json.loads(proof)
    own = told["claim"]["held"][0]["hand"]
    hand = "".join(f"{key} = {own[key]}\n" for key in "mbk")
    told["claim"]["held"][0]["hand"] = "a"
    for hands in (
        f'[[hands]]\nname = "a"\nk = 1\n[[hands]]\nname = "a"\n{hand}',
        f'[[hands]]\nname = "a"\nmodel = "two-mass"\n{hand}',
        '[[hands]]\nname = "a"\nmodel = "expression"\nH = "8*s + 400"\n',
    ):
        yield of_scene(told, f"{text}\n{hands}"), f"{text}\n{hands}"


def _binding_in_a_list() -> Iterator[tuple[str, str]]:
    """A part is a name, not a list with one."""
    proof, text = of_requirement("from a value on")
    told = json.loads(proof)
    for row in told["proof"]["slabs"]:
        row["part"] = row["part"] and [row["part"]]
    yield json.dumps({**told, "claim": {**told["claim"], "binds": [[x] for x in told["claim"]["binds"]]}}), text


def _keys_with_a_comma() -> Iterator[tuple[str, str]]:
    """Two keys are not one with a comma."""
    told = json.loads(of_stability("imposed")[0])
    told["proof"] = {"held,imposed": told["proof"]}
    yield json.dumps(told), of_stability("imposed")[1]


def _prime() -> Iterator[tuple[str, str]]:
    """Modulo a prime a leading coefficient may vanish."""
    proof, text = of_stability("unstable, held")
    told = json.loads(proof)
    other = [["1"], [str(2**61 - 1)]]
    for key in (told["proof"]["imposed"], *told["proof"]["held"]):
        count = len(key["factors"])
        key["factors"] += [other, other]
        key["cells"] += [[], []]
        key["function"]["powers"] += [[count, 1], [count + 1, -1]]
    yield json.dumps(told), text


def _scene_of_another_kind() -> Iterator[tuple[str, str]]:
    """Tables of a scene that are none, or lists of what is none."""
    told = json.loads(of_stability("a hand")[0])
    told["claim"]["held"][0]["hand"] = "hand"
    text = of_stability("a hand")[1]
    for line in ("hand = 5", "hands = 5", "hands = [5]", "environments = 5", "environments = [{}]", "effects = 5"):
        other = f"{line}\n{text}"
        yield of_scene(told, other), other
    other = text.replace("[environment]", '[[environments]]\nname = ["a"]')
    yield of_scene(told | {"environment": ["a"]}, other), other


def _powers() -> Iterator[tuple[str, str]]:
    """The functions of x + j y are those of every order, and what follows is not; a power of omega has no other side at 0."""
    for old, new in (("0.3", "0.31"), ("0.3", "0.300000001"), ("0.3", "0.7")):
        other = text_of("a spring-pot").replace(f"alpha = {old}", f"alpha = {new}")
        for orders in ([old], [new], [old, new], [new, old]):
            told = json.loads(certificate("a spring-pot"))
            told["proof"]["orders"] = orders
            yield of_scene(told, other), other
    text = text_of("powers alone")
    told = json.loads(certificate("powers alone"))
    for key in ("environment", "perceived"):
        own = copy.deepcopy(told)
        own["claim"]["changeovers"][key] = [0, *own["claim"]["changeovers"][key]]
        yield json.dumps(own), text
    for old, new in (
        ("mm", "mm^0.5"),
        ("s^0.5", "ms^0.5"),
        ("s^0.5", "s^.5*(m)^0.5"),
        ('"1/2"', '"1/2 m"'),
        ('"1/2"', "[0.4, 0.6, 0.8]"),
    ):
        assert old in text
        yield of_scene(told, text.replace(old, new)), text.replace(old, new)
    text = text_of("orders of a formula")
    told = json.loads(certificate("orders of a formula"))
    for old, new in (
        ("s^(1.3)", "s^1.4"),
        ("s^(1.3)", "s^0.3"),
        ("s^(1.3)", "(s)^1.3"),
        ("s^(1.3)", "s*z"),
        ("s^(1.3)", "30^0.3*s"),
    ):
        yield of_scene(told, text.replace(old, new)), text.replace(old, new)


LATE_GAIN = gain("11/10 + (w - 2)^2/10", "1/10", "[0, 1]").replace(
    "[evaluation]", 'parameters = { w = 3 }\n[[effects]]\nmodel = "delay"\ntau = "10 ms"\n[evaluation]'
)
"""Of any w but 2 the real part exceeds its threshold at low frequencies, and of 2 it is the threshold at 0."""


def with_slabs(*slabs: dict[str, Any]) -> str:
    """The certificate of a claim about the real part in that scene."""
    found = json.loads(hs.require(hs.parse_scene(LATE_GAIN), "w", ("2.5 1", "3 1")).certificate())
    found["proof"]["slabs"] = list(slabs)
    ends = slabs[0]["from"], slabs[-1]["to"]
    found["claim"] |= {"values": [[*ends, slabs[0]["part"] is None]], "binds": []}
    return json.dumps(found)


def slab(low: str, high: str, points: list[str], part: str | None = "real") -> dict[str, Any]:
    """One of a proof."""
    return {"from": low, "to": high, "points": points, "part": part}


def _values_beside_delays() -> Iterator[tuple[str, str]]:
    """An end that belongs to a slab is one of its values; at no other frequency than 0, nor for all of the band, is it shown there."""
    for point in ("0", "1/1000000", "1"):
        yield with_slabs(slab("1", "2", [point]), slab("2", "3", [point])), LATE_GAIN
        yield with_slabs(slab("1", "3", [point])), LATE_GAIN
    for points in (["0", "1"], ["0", "1/2", "1"]):
        yield with_slabs(slab("1", "2", points, None)), LATE_GAIN
        yield with_slabs(slab("2", "3", points, None)), LATE_GAIN
        yield with_slabs(slab("199/100", "201/100", points, None)), LATE_GAIN
    yield with_slabs(slab("2", "3", ["-1"])), LATE_GAIN
    yield with_slabs(slab("2", "3", ["1/2"], "imag")), LATE_GAIN


def _delays_and_orders_that_are_free() -> Iterator[tuple[str, str]]:
    """They are no coefficients: what holds for one holds for no other."""
    for name, path in (("a threshold above a delay", "tau"), ("a device on a power", "alpha")):
        proof, text = of_requirement(name)
        for place in (["effects", 0, path], ["environment", path], ["effects", 0, "T"]):
            told = json.loads(proof)
            told["claim"]["free"] = place
            yield json.dumps(told), text
        for key in ("delays", "orders"):
            for wrong in (None, [], {}, ["0"], ["-1"], ["1"] * 5, [1], [["1"]], "1", [f"1/{2**100}"], [f"{2**100}"]):
                told = json.loads(proof)
                if told["proof"].get(key, []) != wrong:
                    told["proof"][key] = wrong
                    yield json.dumps(told), text


def _claims_of_another_kind() -> Iterator[tuple[str, str]]:
    """Lists as deep as there is room for, wherever something else is due."""
    good, text = json.loads(certificate("fu2019")), text_of("fu2019")
    for depth in (100, 800, 960, 990, 1000):
        deep = "[" * depth + "]" * depth
        for place in ("claim", "proof", "environment", "scene_sha256"):
            yield json.dumps({**good, place: "?"}).replace('"?"', deep), text
        for place in ("question", "percepts", "frequencies"):
            yield json.dumps({**good, "claim": {**good["claim"], place: "?"}}).replace('"?"', deep), text
        for place in ("breakpoints", "poles", "factors"):
            yield json.dumps({**good, "proof": {**good["proof"], place: "?"}}).replace('"?"', deep), text
