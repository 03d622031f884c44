"""A certificate against a scene file: proven, or refused; and what is proven, in words.

A certificate has a claim and a proof. Each question computes from the proof and the scene what the
claim must be; the two are then compared as a whole, so nothing in a claim is taken on trust. Begin
with ``check``, then ``evaluation``.
"""

import hashlib
import json
from functools import partial
from typing import Any

from haptisym_check.chart import CURVES, PlaceTable, SignRow, claimed, zeros
from haptisym_check.delayterms import factor_of
from haptisym_check.requirement import requirement
from haptisym_check.scene import PARTS, Element, SceneFile, functions, link
from haptisym_check.values import (
    UnreadableError,
    combined,
    delays_and_orders,
    keyed,
    listed,
    need,
    number,
    numbers,
)

# A certificate against a scene file: proven, or refused.


def unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """An object of JSON in which no key stands twice; refused otherwise."""
    # Readers of JSON differ in which of two equal keys counts: such a certificate would say
    # different things to different checkers.
    need(len(dict(pairs)) == len(pairs), "a key stands twice")
    return dict(pairs)


def depth(x: Any) -> int:
    """How deeply lists and objects are nested."""
    inner = x.values() if isinstance(x, dict) else x if isinstance(x, list) else ()
    return 1 + max(map(depth, inner), default=0)


def check(text: bytes, scene_file: bytes) -> str:
    """The claim in words, if the certificate proves it for that scene; RefusedError if not."""
    need(len(text) <= 4_000_000 and len(scene_file) <= 1_000_000, "a file is too large")
    try:
        told = json.loads(text.decode(), object_pairs_hook=unique)
        need(depth(told) < 20, "lists are nested too deeply")
    except (ValueError, RecursionError) as error:
        raise UnreadableError(f"the certificate is no JSON: {error}") from None
    kind, digest, name, claim, proof = keyed(
        told, "format", "scene_sha256", "environment", "claim", "proof"
    )
    need(kind == "haptisym.certificate/1", "the format is not haptisym.certificate/1")
    need(
        digest == hashlib.sha256(scene_file).hexdigest(),
        "the certificate is that of another scene file",
    )
    known = [
        answer
        for x, answer in QUESTIONS.items()
        if isinstance(claim, dict) and claim.get("question") == x
    ]
    need(known, "the claim answers no question that is known")
    follows = known[0](claim, proof, SceneFile(scene_file, name, claim.get("free")))
    # Compared as text: for Python 1 == True == 1.0, which are three different claims.
    keyed(claim, "question", *follows)
    for key, x in follows.items():
        same = json.dumps(claim[key], sort_keys=True) == json.dumps(x, sort_keys=True)
        need(same, f"{key}: proven is {x}, and that is not claimed")
    return "\n  ".join(words(claim))


def evaluation(claim: dict[str, Any], proof: Any, scene: SceneFile) -> dict[str, Any]:
    """What the claim of an evaluation must be: all that happens on the band (rules 1 to 5)."""
    lags, powers, points, told, products, poles = keyed(proof, *EVALUATION)
    delays, orders = delays_and_orders(lags, powers)
    factors = [factor_of(x, delays, orders) for x in listed(told, 500)]
    at_point = partial(functions, scene, delays, orders)
    proven = link(products, NAMES, factors, at_point, scene.length, (len(delays), len(orders)))
    enclosures = [
        [number(x) for x in listed(pair, 2, 2)]
        for pair in listed(claim.get("frequencies"), 2000, 2)
    ]
    chart = PlaceTable(scene, numbers(points, 2000, 2), factors, enclosures)
    curves = {key: SignRow(x, chart) for key, x in proven.items()}
    on_band = claimed(curves, from_0=chart.from_0)
    # The poles of H_perc are the zeros of 1/H_perc. Without a proof of them nothing is claimed.
    stable = None
    if poles is not None:
        stable = zeros(poles, lambda point: scene.at(point)[1][::-1], scene.length) == 0
    return {"frequencies": claim["frequencies"], **on_band, "stable": stable}


def stability(claim: dict[str, Any], proof: Any, scene: SceneFile) -> dict[str, Any]:
    """What the claim about stability must be: the numbers of poles under prescribed motion, and of
    roots in each hand, in Re s >= 0."""
    poles, held = keyed(proof, "imposed", "held")
    rows, in_hands = listed(claim.get("held"), 100), []
    # All of these counts together may take no longer than one that stands alone.
    share = 1 + len(rows)
    count = zeros(poles, lambda point: scene.at(point)[1][::-1], scene.length, share)
    for told, of_hand in zip(rows, listed(held, len(rows), len(rows)), strict=True):
        hand, _ = keyed(told, "hand", "unstable")
        roots = zeros(of_hand, in_hand(hand, scene), scene.length, share)
        in_hands.append({"hand": hand, "unstable": roots})
    return {"imposed": count, "held": in_hands}


def in_hand(hand: Any, scene: SceneFile) -> Any:
    """The function H_perc + m s^2 + b s + k of a point, with a hand of the scene file by its name,
    or one whose numbers are in the claim."""
    table = (
        scene.hand(hand)
        if isinstance(hand, str)
        else dict(zip("mbk", map(number, keyed(hand, *"mbk")), strict=True))
    )
    z = Element({**table, "model": "mass-spring-damper"}, 1)
    return lambda point: combined("+", scene.at(point)[1], z.at(point)[0])


EVALUATION = "delays", "orders", "breakpoints", "factors", "functions", "poles"
NAMES = [f"{x}.{part}" for x in CURVES for part in PARTS]
QUESTIONS = {"evaluation": evaluation, "stability": stability, "requirement": requirement}


# Claims that are proven, in words.


def words(claim: dict[str, Any]) -> list[str]:
    """The proven claim in words: a line for what it is about, then one for each result."""
    return {"evaluation": of_band, "stability": of_roots, "requirement": of_values}[
        claim["question"]
    ](claim)


def of_band(claim: dict[str, Any]) -> list[str]:
    """The lines of an evaluation."""
    at = [x if x == y else f"[{x}, {y}]" for x, y in claim["frequencies"]]
    n = len(claim["crossings"])
    lines = [
        (
            f"Proven on the band from {at[0]} to {at[-1]} rad/s: {n or 'no'} "
            f"crossing{'s'[: n > 1]}, none missed."
        )
    ]
    for x in claim["crossings"]:
        lines += [f"{x['part']} part {MEETS[x['kind']]} its threshold at {at[x['at']]} rad/s"]
    lines += [f"transparent from {at[x]} to {at[y]} rad/s" for x, y in claim["transparent"]]
    for x in claim["percepts"]:
        lines += [
            (
                f"{x['change']} {x['property']} ({x['part']} part) from {at[x['from']]} to "
                f"{at[x['to']]} rad/s"
            )
        ]
    return [*lines, f"prescribed motion: {POLES[claim['stable']]} poles of H_perc in Re s >= 0"]


def of_roots(claim: dict[str, Any]) -> list[str]:
    """The lines of a claim about stability."""
    lines = [f"Proven: {claim['imposed']} poles of H_perc in Re s >= 0 (prescribed motion)."]
    for hand, roots in ((x["hand"], x["unstable"]) for x in claim["held"]):
        name = (
            ascii(hand)
            if isinstance(hand, str)
            else ", ".join(f"{key} = {hand[key]}" for key in "mbk")
        )
        lines += [f"held in the hand {name}: {roots} roots in Re s >= 0"]
    return lines


def of_values(claim: dict[str, Any]) -> list[str]:
    """The lines of a requirement."""
    free, parts, binds = claim["free"], claim["parts"], claim["binds"]
    lines = [
        (
            f"Proven of {ascii('.'.join(map(str, free)))[1:-1]}, {' and '.join(parts)} part, on "
            f"the whole band:"
        )
    ]
    for low, high, holds in claim["values"]:
        lines += [
            (
                f"{'transparent' if holds else 'not transparent'} between {low or '-oo'} and "
                f"{high or 'oo'}"
            )
        ]
    return lines + ([f"what binds: {', '.join(f'{part} part' for part in binds)}"] if binds else [])


MEETS = {"exceeds": "exceeds", "returns": "returns below", "touches": "touches"}
POLES = {True: "no", False: "some", None: "nothing is said of"}
