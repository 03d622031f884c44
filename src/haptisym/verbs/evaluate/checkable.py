"""Whether a certificate is one for which a checker works long enough (docs/certificates.md, "Limits")."""

from __future__ import annotations

import re
from collections.abc import Sequence
from math import prod
from typing import Any

from haptisym.kernel.errors import SceneError

_FORMULA = re.compile(r"""\b[A-Z]["']?\s*=\s*("{3}|'{3}|["'])(.*?)\1""", re.DOTALL)
_BROKEN = re.compile(r"\bs\s*(\^|\*\*)[\s(+-]*[0-9]*\.")  # a power of s that is not whole
_MOST = 10**7  # no scene of the package needs more than two thirds of it; some three times as much may be refused


def need_checkable(certificate: str, proof: dict[str, Any], scene: str) -> None:
    """SceneError where a checker refuses the certificate of a scene.

    It is asked where its work may be beyond its limits, and where a formula has powers of s: it may not see that they cancel.
    """
    powers = any(_BROKEN.search(found[2]) for found in _FORMULA.finditer(scene))
    if not powers and _points(proof) * len(certificate) <= _MOST:
        return
    from haptisym_check import RefusedError, check  # it is asked of few scenes

    try:
        check(certificate.encode(), scene.encode())
    except RefusedError as error:
        raise SceneError(f"no checker accepts a certificate of this scene: {error}") from None


def _points(proof: dict[str, Any]) -> int:
    """About so many has the grid on which it is shown that the functions are those of the scene."""
    if "functions" not in proof:
        return 0
    factors, count = [_degrees(x) for x in proof["factors"]], 2 + len(proof.get("delays", ()))
    sides = [
        [(abs(n), factors[i]) for i, n in told["powers"] if n * side > 0]
        for told in proof["functions"].values()
        for side in (1, -1)
    ]
    places = range(max(map(len, factors), default=0))
    most = [max(sum(n * own[v] for n, own in row if v < len(own)) for row in sides) + 1 for v in places]
    corners = [n * (n + 1) // 2 for n in most[count:]]
    return int(prod(most[:count] + corners))


def _degrees(factor: dict[str, Any]) -> Sequence[int]:
    """In omega, in pi, in the tangent of each delay, in the two parts of each power together."""
    terms = factor.get("terms") or [[[], factor["polynomial"]]]
    waves = factor.get("waves", [])
    high = factor.get("step", 1) * (max(len(p) for _, p in terms) - 1), max(len(row) for _, p in terms for row in p) - 1
    powers = range(len(waves), len(terms[0][0]), 2)
    return [*high, *waves, *(max(sum(turns[i : i + 2]) for turns, _ in terms) for i in powers)]
