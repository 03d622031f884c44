"""Claims that are proven, in words."""

from typing import Any


def words(claim: dict[str, Any]) -> list[str]:
    """A line for what it is about, then one for each thing that it says."""
    return {"evaluation": of_band, "stability": of_roots, "requirement": of_values}[claim["question"]](claim)


def of_band(claim: dict[str, Any]) -> list[str]:
    """Of an evaluation."""
    at = [x if x == y else f"[{x}, {y}]" for x, y in claim["frequencies"]]
    n = len(claim["crossings"])
    lines = [f"Proven on the band from {at[0]} to {at[-1]} rad/s: {n or 'no'} crossing{'s'[: n > 1]}, none missed."]
    for x in claim["crossings"]:
        lines += [f"{x['part']} part {MEETS[x['kind']]} its threshold at {at[x['at']]} rad/s"]
    lines += [f"transparent from {at[x]} to {at[y]} rad/s" for x, y in claim["transparent"]]
    for x in claim["percepts"]:
        lines += [f"{x['change']} {x['property']} ({x['part']} part) from {at[x['from']]} to {at[x['to']]} rad/s"]
    return [*lines, f"prescribed motion: {POLES[claim['stable']]} poles of H_perc in Re s >= 0"]


def of_roots(claim: dict[str, Any]) -> list[str]:
    """Of stability."""
    lines = [f"Proven: {claim['imposed']} poles of H_perc in Re s >= 0 (prescribed motion)."]
    for hand, roots in ((x["hand"], x["unstable"]) for x in claim["held"]):
        name = ascii(hand) if isinstance(hand, str) else ", ".join(f"{key} = {hand[key]}" for key in "mbk")
        lines += [f"held in the hand {name}: {roots} roots in Re s >= 0"]
    return lines


def of_values(claim: dict[str, Any]) -> list[str]:
    """Of a requirement."""
    free, parts, binds = claim["free"], claim["parts"], claim["binds"]
    lines = [f"Proven of {ascii('.'.join(map(str, free)))[1:-1]}, {' and '.join(parts)} part, on the whole band:"]
    for low, high, holds in claim["values"]:
        lines += [f"{'transparent' if holds else 'not transparent'} between {low or '-oo'} and {high or 'oo'}"]
    return lines + ([f"what binds: {', '.join(f'{part} part' for part in binds)}"] if binds else [])


MEETS = {"exceeds": "exceeds", "returns": "returns below", "touches": "touches"}
POLES = {True: "no", False: "some", None: "nothing is said of"}
