"""A certificate against a scene file: proven, or refused."""

import hashlib
import json
import re
from functools import partial
from typing import Any

from haptisym_check.chart import CURVES, Chart, Curve, claimed
from haptisym_check.factors import Factor
from haptisym_check.link import PARTS, Product, functions, link
from haptisym_check.reading import keyed, listed, number, numbers
from haptisym_check.requirement import values
from haptisym_check.scene import MOST_DELAYS, Element, Point, Ratio, Scene, UnreadableError, Value, combined, need
from haptisym_check.waves import factor_of
from haptisym_check.zeros import zeros


def unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """An object of JSON in which no key stands twice."""
    need(len(dict(pairs)) == len(pairs), "a key stands twice")
    return dict(pairs)


def small(text: str) -> int:
    """A whole number of JSON, of at most six digits."""
    need(re.fullmatch("-?[0-9]{1,6}", text), f"{text[:40]} is no small whole number")
    return int(text)


def check(text: bytes, scene_file: bytes) -> str:
    """The claim in words, if the certificate proves it for that scene; RefusedError if not."""
    need(len(text) <= 4_000_000 and len(scene_file) <= 1_000_000, "a file is too large")
    try:
        told = json.loads(text, object_pairs_hook=unique, parse_constant=small, parse_float=small, parse_int=small)
    except (ValueError, RecursionError) as error:
        raise UnreadableError(f"the certificate is no JSON: {error}") from None
    kind, digest, name, claim, proof = keyed(told, "format", "scene_sha256", "environment", "claim", "proof")
    need(kind == "haptisym.certificate/1", "the format is not haptisym.certificate/1")
    need(digest == hashlib.sha256(scene_file).hexdigest(), "the certificate is that of another scene file")
    question = claim.get("question") if isinstance(claim, dict) else None
    need(str(question) in QUESTIONS, "the claim answers no question that is known")
    follows, words = QUESTIONS[str(question)](claim, proof, Scene(scene_file, name, claim.get("free")))
    keyed(claim, "question", *follows)
    for key, x in follows.items():
        same = json.dumps(claim[key], sort_keys=True) == json.dumps(x, sort_keys=True)
        need(same, f"{key}: proven is {x}, and that is not claimed")
    return "\n  ".join(words)


Answer = tuple[dict[str, Any], list[str]]  # what follows from a proof, and the same in words
COUNTS = {None: "nothing is said of poles", 0: "all poles of H_perc lie in Re s < 0"}


def linked(
    told: Any, products: Any, names: list[str], scene: Scene, delays: Any = ()
) -> tuple[list[Factor], dict[str, Product]]:
    """Factors, and functions as products of them, which are those of the scene (rule 1)."""
    own = tuple(number(x) for x in delays)
    short = all(x > 0 and x.numerator.bit_length() + x.denominator.bit_length() < 200 for x in own)
    need(short, "a delay is not positive, or too long")
    factors = [factor_of(x, own) for x in listed(told, 500)]
    found = {key: Product(x, factors) for key, x in zip(names, keyed(products, *names), strict=True)}
    link(found, factors, partial(functions, scene), own, Value(0, 1))
    return factors, found


def evaluation(claim: dict[str, Any], proof: Any, scene: Scene) -> Answer:
    """All that happens on the band."""
    delays, points, polynomials, products, poles = keyed(
        proof, "delays", "breakpoints", "factors", "functions", "poles"
    )
    names = [f"{x}.{part}" for x in CURVES for part in PARTS]
    factors, told = linked(polynomials, products, names, scene, listed(delays, MOST_DELAYS))
    enclosures = [[number(x) for x in listed(pair, 2, 2)] for pair in listed(claim.get("frequencies"), 2000, 2)]
    chart = Chart(scene, numbers(points, 2000, 2), factors, enclosures)
    found = claimed({key: Curve(x, chart) for key, x in told.items()}, from_0=chart.from_0)
    count = None if poles is None else zeros(poles, lambda point: scene.at(point)[1][::-1])
    at = [f"{float(x):.10g}" for x, _ in enclosures]
    lines = [f"Proven on the band from {at[0]} to {at[-1]} rad/s: {len(found['crossings'])} crossings, none missed."]
    for x in found["crossings"]:
        place = " and ".join(claim["frequencies"][x["at"]])
        lines += [f"{x['part']} part {MEETS[x['kind']]} its threshold between {place} rad/s"]
    lines += [f"transparent from {at[x]} to {at[y]} rad/s" for x, y in found["transparent"]]
    for x in found["percepts"]:
        lines += [f"{x['change']} {x['property']} ({x['part']} part) from {at[x['from']]} to {at[x['to']]} rad/s"]
    lines += [f"imposed motion: {COUNTS.get(count, 'H_perc has a pole in Re s >= 0')}"]
    return {"frequencies": claim["frequencies"], **found, "stable": None if count is None else count == 0}, lines


def stability(claim: dict[str, Any], proof: Any, scene: Scene) -> Answer:
    """Poles under imposed motion, and roots in hands, in Re s >= 0."""
    poles, held = keyed(proof, "imposed", "held")
    count = zeros(poles, lambda point: scene.at(point)[1][::-1])
    found, lines = [], [f"Proven: {count} poles of H_perc in Re s >= 0 (imposed motion)."]
    rows, proofs = listed(claim.get("held"), 100), listed(held, 100)
    need(len(rows) == len(proofs), "there are not as many proofs as hands")
    for told, own in zip(rows, proofs, strict=True):
        hand, _ = keyed(told, "hand", "unstable")
        z = Element({"model": "mass-spring-damper", **in_hand(hand, scene)}, 1)
        roots = zeros(own, partial(loop, scene, z))
        found.append({"hand": hand, "unstable": roots})
        words = hand if isinstance(hand, str) else ", ".join(f"{key} = {hand[key]}" for key in "mbk")
        lines += [f"held in the hand {words}: {roots} roots in Re s >= 0"]
    return {"imposed": count, "held": found}, lines


def in_hand(hand: Any, scene: Scene) -> dict[str, Any]:
    """Mass, damping and stiffness: of a hand of the scene file by its name, or as they are claimed."""
    if isinstance(hand, str):
        need(hand in scene.hands, f"the scene has no hand {hand!r}")
        return scene.hands[hand]
    return dict(zip("mbk", map(number, keyed(hand, "m", "b", "k")), strict=True))


def loop(scene: Scene, hand: Element, point: Point) -> Ratio:
    """H_perc + m s^2 + b s + k."""
    return combined("+", scene.at(point)[1], hand.at(point)[0])


def requirement(claim: dict[str, Any], proof: Any, scene: Scene) -> Answer:
    """For which values of a free parameter the display is transparent on the band."""
    polynomials, products, slabs = keyed(proof, "factors", "functions", "slabs")
    parts = [part for part in PARTS if part in listed(claim.get("parts"), 2, 1)]
    factors, told = linked(polynomials, products, [f"excess.{part}" for part in parts], scene)
    need(all(type(x) is Factor for x in factors), "a factor is no polynomial")
    found, binds = values(told, factors, slabs, scene)
    free = listed(claim.get("free"), 9, 1)
    lines = [f"Proven of {'.'.join(map(str, free))}, {' and '.join(parts)} part, on the whole band:"]
    for low, high, holds in found:
        lines += [f"{'transparent' if holds else 'not transparent'} between {low or '-oo'} and {high or 'oo'}"]
    lines += [f"what binds: {', '.join(f'{part} part' for part in binds)}"] if binds else []
    return {"free": free, "parts": parts, "values": found, "binds": binds}, lines


MEETS = {"exceeds": "exceeds", "returns": "returns below", "touches": "touches"}
QUESTIONS = {"evaluation": evaluation, "stability": stability, "requirement": requirement}
