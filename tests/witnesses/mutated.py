"""Random changes of certificates: of a leaf, of what a list or an object holds, of what stands where, of how JSON is written."""

from __future__ import annotations

import copy
import json
import random
import re
from collections.abc import Iterator
from fractions import Fraction
from typing import Any

Path = tuple[str | int, ...]

_ODD = (
    None, True, False, 0, -1, 1, 2, 7, 10**7, 1.0, 0.5, "", "0", "-0", "1", "-1", "1/2", "1E0", "1e0", "+1", " 1", "1 ", "1\n", "٣", "１",
    "0x1", "1_0", ".5", "5.", "1/0", "1/-2", "1E999", "1E-999", "1E1000", "9" * 2000, "9" * 2001, "NaN", "inf", "real", "imag", "touches",
    [], {}, [[]], ["0"], [["1"]], [0, 0], ["0", "0"],
)  # fmt: skip


def places(x: Any, at: Path = ()) -> Iterator[Path]:
    """The paths of all that it holds."""
    inner = x.items() if isinstance(x, dict) else enumerate(x) if isinstance(x, list) else ()
    for key, y in inner:
        yield (*at, key)
        yield from places(y, (*at, key))


def inside(x: Any, path: Path) -> Any:
    """What stands there."""
    for key in path:
        x = x[key]
    return x


def _leaf(source: random.Random, x: Any) -> Any:
    """Another one, often nearly the same."""
    if source.random() < 0.3:
        return copy.deepcopy(source.choice(_ODD))
    if isinstance(x, bool) or x is None:
        return source.choice((True, False, None, int(bool(x))))
    if isinstance(x, int):
        return source.choice((x + 1, x - 1, -x, 2 * x, float(x), str(x), bool(x)))
    if isinstance(x, str) and re.fullmatch(r"-?[0-9]+([./][0-9]+)?", x):
        n = Fraction(x)
        at, digit = source.randrange(len(x)), source.choice("0123456789-/.E")
        return source.choice((
            str(n + 1), str(-n), str(2 * n), str(n + Fraction(1, 10**9)), str(n * Fraction(1001, 1000)), str(n * Fraction(999, 1000)),
            f"{x}0", f"0{x}", f"{x}.0", f"{x}/1", f"{x}E0", x[:at] + digit + x[at + 1 :], x[:at] + x[at + 1 :],
        ))  # fmt: skip
    return copy.deepcopy(source.choice(_ODD))


def _changed(source: random.Random, proof: Any, others: list[Any]) -> Any:
    """One change."""
    paths = list(places(proof))
    if source.random() < 0.7:  # no polynomial with many coefficients for the most part
        paths = [x for x in paths if "polynomial" not in x and "terms" not in x] or paths
    path = source.choice(paths)
    above, key = inside(proof, path[:-1]), path[-1]
    what = source.choice(("leaf", "leaf", "leaf", "left out", "twice", "swapped", "swapped", "transplanted", "moved"))
    if what == "leaf" and not isinstance(above[key], dict | list):
        above[key] = _leaf(source, above[key])
    elif what == "left out":
        del above[key]
    elif what == "twice" and isinstance(above, list):
        above.insert(source.randrange(len(above) + 1), copy.deepcopy(above[key]))
    elif what == "swapped":
        other = source.choice(list(above) if isinstance(above, dict) else range(len(above)))
        above[key], above[other] = above[other], above[key]
    elif what == "transplanted":
        other = source.choice(others)
        same = [x for x in places(other) if x == path] or [x for x in places(other) if x[-1] == key]
        if same:
            above[key] = copy.deepcopy(inside(other, source.choice(same)))
    elif what == "moved":
        above[key] = copy.deepcopy(inside(proof, source.choice(paths)))
    return proof


def _written(source: random.Random, text: str) -> str:
    """The same, or nearly, as JSON may be written."""
    what = source.randrange(7)
    if what == 0:
        return re.sub(r'"([a-z])', lambda x: f'"\\u{ord(x[1]):04x}', text, count=source.randrange(1, 9))
    if what == 1:
        return re.sub(r"(?<=[\[ :])0(?=[,\]])", "-0", text, count=source.randrange(1, 4))
    if what == 2:
        return re.sub(
            r"(?<=[\[ :])([0-9])(?=[,\]])",
            source.choice((r"\1.0", r"\1e0", r"\g<1>0E-1", r"+\1", r"0\1")),
            text,
            count=1,
        )
    if what == 3:
        keys = re.findall(r'"[a-z]+": ', text)
        return re.sub(key := source.choice(keys), lambda x: f"{key}1, {x[0]}", text, count=1)
    if what == 4:
        return text.replace(
            " ", source.choice(("\t\n", "\r ", "\u00a0", "\u2028", "\ufeff", "\f")), source.randrange(1, 5)
        )
    if what == 5:
        return source.choice(
            (
                f"\ufeff{text}",
                f"{text}\n",
                f"{text} x",
                f"[{text}]",
                text[:-1],
                f"{text[:-1]},}}",
                text.replace('"', "'"),
            )
        )
    return text.replace("null", source.choice(("NaN", "-Infinity", "nulL", "None")), 1)


def mutated(seed: int, proofs: list[Any]) -> tuple[int, str]:
    """Which certificate, and the text of a mutant of it with one to three changes."""
    source = random.Random(seed)
    at = source.randrange(len(proofs))
    proof = copy.deepcopy(proofs[at])
    others = [x for x in proofs if x["claim"]["question"] == proof["claim"]["question"]]
    for _ in range(source.choice((0, 1, 1, 1, 2, 3))):
        proof = _changed(source, proof, others)
    text = json.dumps(proof, ensure_ascii=source.random() < 0.5)
    return at, _written(source, text) if source.random() < 0.2 else text
