"""A certificate against a scene file: proven, or refused."""

import hashlib
import json
from typing import Any

from haptisym_check.chart import CURVES, Chart, Curve, claimed
from haptisym_check.link import PARTS, Product, functions, link
from haptisym_check.poles import poles
from haptisym_check.polynomials import keyed, listed, number, polynomial, small, unique, whole
from haptisym_check.scene import RefusedError, Scene, need


def check(text: bytes, scene_file: bytes) -> str:
    """The claim in words, if the certificate proves it for that scene; RefusedError if not."""
    need(len(text) <= 4_000_000 and len(scene_file) <= 1_000_000, "a file is too large")
    try:
        told = json.loads(text, object_pairs_hook=unique, parse_constant=small, parse_float=small, parse_int=small)
    except (ValueError, RecursionError) as error:
        raise RefusedError(f"the certificate is no JSON: {error}") from None
    kind, digest, name, claim, proof = keyed(told, "format", "scene_sha256", "environment", "claim", "proof")
    need(kind == "haptisym.certificate/1", "the format is not haptisym.certificate/1")
    need(digest == hashlib.sha256(scene_file).hexdigest(), "the certificate is that of another scene file")
    scene = Scene(scene_file, name)
    points, polynomials, products, about_poles = keyed(proof, "breakpoints", "factors", "functions", "poles")
    factors = [
        (whole(step, 1, 2), polynomial(p))
        for step, p in (keyed(x, "step", "polynomial") for x in listed(polynomials, 500))
    ]
    names = [f"{x}.{part}" for x in CURVES for part in PARTS]
    curves = {key: Product(x, len(factors)) for key, x in zip(names, keyed(products, *names), strict=True)}
    link(curves, factors, lambda omega, pi: functions(scene, omega, pi))
    need(isinstance(claim, dict) and "frequencies" in claim, "the claim has no frequencies")
    enclosures = [[number(x) for x in listed(pair, 2, 2)] for pair in listed(claim["frequencies"], 2000)]
    chart = Chart(scene, [number(x) for x in listed(points, 2000, 2)], factors, enclosures)
    follows = claimed({key: Curve(x, chart) for key, x in curves.items()}, from_0=chart.from_0) | {
        "stable": poles(about_poles, scene)
    }
    keyed(claim, "frequencies", *follows)
    for key, x in follows.items():
        need(
            json.dumps(claim[key], sort_keys=True) == json.dumps(x, sort_keys=True),
            f"{key}: proven is {x}, and that is not claimed",
        )
    return said(claim)


def said(claim: dict[str, Any]) -> str:
    """The claim in words."""
    at = [f"{float(number(x)):.10g}" for x, _ in claim["frequencies"]]
    meets = {"exceeds": "exceeds", "returns": "returns below", "touches": "touches"}
    lines = [f"Proven on the band from {at[0]} to {at[-1]} rad/s: {len(claim['crossings'])} crossings, none missed."]
    for x in claim["crossings"]:
        lines += [
            f"{x['part']} part {meets[x['kind']]} its threshold between {' and '.join(claim['frequencies'][x['at']])} rad/s"
        ]
    lines += [f"transparent from {at[x]} to {at[y]} rad/s" for x, y in claim["transparent"]]
    for x in claim["percepts"]:
        lines += [f"{x['change']} {x['property']} ({x['part']} part) from {at[x['from']]} to {at[x['to']]} rad/s"]
    stable = {
        True: "all poles of H_perc lie in Re s < 0",
        False: "H_perc has a pole in Re s >= 0",
        None: "nothing is said of poles",
    }
    return "\n  ".join([*lines, f"imposed motion: {stable[claim['stable']]}"])
