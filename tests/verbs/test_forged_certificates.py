"""Nobody gets a false claim past a checker, nor makes it work for long."""

from __future__ import annotations

import json

import pytest
from certificates import of_stability
from forgeries import evaluated, forgeries, gain, of_scene, together, with_squares
from secondchecker import verdicts

from haptisym_check import RefusedError, check


@pytest.mark.slow
def test_forgeries_are_refused() -> None:
    passed = []
    for name, (proof, scene) in forgeries().items():
        try:
            check(proof.encode(), scene.encode())
        except RefusedError:
            continue
        passed.append(name)
    assert passed == []


@pytest.mark.slow
def test_the_second_checker_refuses_forgeries() -> None:
    said = verdicts([*forgeries().values()])
    assert [name for name, (claim, _) in zip(forgeries(), said, strict=True) if claim is not None] == []


def test_what_forgeries_are_made_of_is_accepted_where_it_says_what_is_true() -> None:
    """omega^2 as a factor, two zeros in one, a zero that is told exactly or within its cell, and functions without factors."""
    mass = '[environment]\nmodel = "mass-spring-damper"\nm = 1\n[evaluation]\nband = [0, 9]\n'
    twice = gain("11/10 + (s^2 + 1)*(s^2 + 4)/1000", "1/10", "[1, 3]")
    proof = together(evaluated(twice))
    asked = [(of_scene(with_squares(evaluated(mass)), mass), mass), (of_scene(proof, twice), twice)]
    for told in (["2", "2"], ["1.5", "2.5"]):
        proof["claim"]["frequencies"][1] = told
        asked.append((of_scene(proof, twice), twice))
    constant = gain("12/10", "1/10", "[0, 15]")
    asked.append((of_scene(evaluated(constant), constant), constant))
    for own, scene in asked:
        assert check(own.encode(), scene.encode()).startswith("Proven")
    assert all(claim is not None for claim, _ in verdicts(asked))


def test_names_of_a_scene_do_not_look_like_lines_of_a_proof() -> None:
    proof, text = of_stability("a hand")
    told = json.loads(proof)
    own = told["claim"]["held"][0]["hand"]
    name = "x: 0 roots\n  held in the hand y"
    hands = f"{text}\n[[hands]]\nname = {json.dumps(name)}\n" + "".join(f"{key} = {own[key]}\n" for key in "mbk")
    told["claim"]["held"][0]["hand"] = name
    assert len(check(of_scene(told, hands).encode(), hands.encode()).splitlines()) == 1 + len(told["claim"]["held"])


def check_or_refuse(proof: str, scene: str) -> str:
    try:
        return check(proof.encode(), scene.encode())
    except RefusedError:
        return "refused"


def test_a_certificate_is_read_in_utf_8_alone() -> None:
    proof, text = of_stability("imposed")
    assert check_or_refuse(proof, text).startswith("Proven")
    for encoding in ("utf-16", "utf-32", "utf-8-sig"):
        with pytest.raises(RefusedError):
            check(proof.encode(encoding), text.encode())
