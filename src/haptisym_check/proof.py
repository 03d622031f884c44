"""A certificate against a scene file: proven, or refused."""

import hashlib
import json
from decimal import Decimal
from functools import partial
from typing import Any

from haptisym_check.chart import CURVES, Chart, Curve, claimed
from haptisym_check.link import PARTS, functions, link
from haptisym_check.reading import keyed, listed, number, numbers
from haptisym_check.requirement import values
from haptisym_check.scene import MOST_DELAYS, Element, Scene, UnreadableError, combined, need
from haptisym_check.waves import factor_of, polynomial_factor
from haptisym_check.zeros import zeros


def unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """An object of JSON in which no key stands twice."""
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
    kind, digest, name, claim, proof = keyed(told, "format", "scene_sha256", "environment", "claim", "proof")
    need(kind == "haptisym.certificate/1", "the format is not haptisym.certificate/1")
    need(digest == hashlib.sha256(scene_file).hexdigest(), "the certificate is that of another scene file")
    known = [answer for x, answer in QUESTIONS.items() if isinstance(claim, dict) and claim.get("question") == x]
    need(known, "the claim answers no question that is known")
    follows, words = known[0](claim, proof, Scene(scene_file, name, claim.get("free")))
    keyed(claim, "question", *follows)
    for key, x in follows.items():
        same = json.dumps(claim[key], sort_keys=True) == json.dumps(x, sort_keys=True)
        need(same, f"{key}: proven is {x}, and that is not claimed")
    return "\n  ".join(words)


Answer = tuple[dict[str, Any], list[str]]  # what follows from a proof, and the same in words


def evaluation(claim: dict[str, Any], proof: Any, scene: Scene) -> Answer:
    """All that happens on the band."""
    lags, points, told, products, poles = keyed(proof, "delays", "breakpoints", "factors", "functions", "poles")
    own = tuple(number(x) for x in listed(lags, MOST_DELAYS))
    need(all(0 < x < 2**100 and x.denominator < 2**100 for x in own), "a delay is not positive, or too long")
    factors = [factor_of(x, own) for x in listed(told, 500)]
    proven = link(products, NAMES, factors, partial(functions, scene, own), len(own))
    enclosures = [[number(x) for x in listed(pair, 2, 2)] for pair in listed(claim.get("frequencies"), 2000, 2)]
    chart = Chart(scene, numbers(points, 2000, 2), factors, enclosures)
    found = claimed({key: Curve(x, chart) for key, x in proven.items()}, from_0=chart.from_0)
    count = None if poles is None else zeros(poles, lambda point: scene.at(point)[1][::-1])
    at = [f"{Decimal(x.numerator) / x.denominator:.10g}" for x, _ in enclosures]
    lines = [f"Proven on the band from {at[0]} to {at[-1]} rad/s: {len(found['crossings'])} crossings, none missed."]
    for x in found["crossings"]:
        between = " and ".join(claim["frequencies"][x["at"]])
        lines += [f"{x['part']} part {MEETS[x['kind']]} its threshold between {between} rad/s"]
    lines += [f"transparent from {at[x]} to {at[y]} rad/s" for x, y in found["transparent"]]
    for x in found["percepts"]:
        lines += [f"{x['change']} {x['property']} ({x['part']} part) from {at[x['from']]} to {at[x['to']]} rad/s"]
    lines += [f"imposed motion: {'nothing is said of' if count is None else count} poles of H_perc in Re s >= 0"]
    return {"frequencies": claim["frequencies"], **found, "stable": None if count is None else count == 0}, lines


def stability(claim: dict[str, Any], proof: Any, scene: Scene) -> Answer:
    """Poles under imposed motion, and roots in hands, in Re s >= 0."""
    poles, held = keyed(proof, "imposed", "held")
    count, found = zeros(poles, lambda point: scene.at(point)[1][::-1]), []
    lines, rows = [f"Proven: {count} poles of H_perc in Re s >= 0 (imposed motion)."], listed(claim.get("held"), 100)
    for told, own in zip(rows, listed(held, len(rows), len(rows)), strict=True):
        hand, _ = keyed(told, "hand", "unstable")
        z = in_hand(hand, scene)
        roots = zeros(own, lambda point, z=z: combined("+", scene.at(point)[1], z.at(point)[0]))  # type: ignore[misc]
        found.append({"hand": hand, "unstable": roots})
        words = ascii(hand) if isinstance(hand, str) else ", ".join(f"{key} = {hand[key]}" for key in "mbk")
        lines += [f"held in the hand {words}: {roots} roots in Re s >= 0"]
    return {"imposed": count, "held": found}, lines


def in_hand(hand: Any, scene: Scene) -> Element:
    """m s^2 + b s + k: of a hand of the scene file by its name, or as claimed."""
    own = scene.hand(hand) if isinstance(hand, str) else dict(zip("mbk", map(number, keyed(hand, *"mbk")), strict=True))
    return Element({**own, "model": "mass-spring-damper"}, 1)


def requirement(claim: dict[str, Any], proof: Any, scene: Scene) -> Answer:
    """For which values of a free parameter the display is transparent on the band."""
    polynomials, products, slabs = keyed(proof, "factors", "functions", "slabs")
    parts = [part for part in PARTS if part in listed(claim.get("parts"), 2, 1)]
    factors = [polynomial_factor(x) for x in listed(polynomials, 500)]
    told = link(products, [f"excess.{part}" for part in parts], factors, partial(functions, scene, ()))
    found, binds = values(told, factors, slabs, scene)
    free = listed(claim.get("free"), 9, 1)
    lines = [f"Proven of {ascii('.'.join(map(str, free)))[1:-1]}, {' and '.join(parts)} part, on the whole band:"]
    for low, high, holds in found:
        lines += [f"{'transparent' if holds else 'not transparent'} between {low or '-oo'} and {high or 'oo'}"]
    lines += [f"what binds: {', '.join(f'{part} part' for part in binds)}"] if binds else []
    return {"free": free, "parts": parts, "values": found, "binds": binds}, lines


MEETS = {"exceeds": "exceeds", "returns": "returns below", "touches": "touches"}
NAMES = [f"{x}.{part}" for x in CURVES for part in PARTS]
QUESTIONS = {"evaluation": evaluation, "stability": stability, "requirement": requirement}
