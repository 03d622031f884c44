"""Scenes and documents that certificates are forged of."""

from __future__ import annotations

import json
from functools import cache
from typing import Any

import haptisym as hs


def gain(series: str, jnd: str, band: str) -> str:
    """A spring of 100 N/m that is felt times something."""
    return (
        '[environment]\nmodel = "kelvin-voigt"\nk = 100\nb = 0\n'
        f'[[effects]]\nmodel = "series"\nG = "{series}"\n[evaluation]\nband = {band}\njnd = "{jnd}"\n'
    )


def evaluated(text: str) -> dict[str, Any]:
    """A true certificate."""
    return json.loads(hs.evaluate(hs.parse_scene(text)).certificate())  # type: ignore[no-any-return]


LATE_GAIN = gain("11/10 + (w - 2)^2/10", "1/10", "[0, 1]").replace(
    "[evaluation]", 'parameters = { w = 3 }\n[[effects]]\nmodel = "delay"\ntau = "10 ms"\n[evaluation]'
)
"""Of any w but 2 the real part exceeds its threshold at low frequencies, and of 2 it is the threshold at 0."""


@cache
def _late() -> str:
    return hs.require(hs.parse_scene(LATE_GAIN), "w", ("2.5 1", "3 1")).certificate()


def with_slabs(*slabs: dict[str, Any]) -> str:
    """The certificate of a claim about the real part in that scene."""
    found = json.loads(_late())
    found["proof"]["slabs"] = list(slabs)
    ends = slabs[0]["from"], slabs[-1]["to"]
    found["claim"] |= {"values": [[*ends, slabs[0]["part"] is None]], "binds": []}
    return json.dumps(found)


def slab(low: str, high: str, points: list[str], part: str | None = "real") -> dict[str, Any]:
    """One of a proof."""
    return {"from": low, "to": high, "points": points, "part": part}
