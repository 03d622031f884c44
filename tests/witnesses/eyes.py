"""Colours as other eyes see them, and as print has them: Viénot, Brettel and Mollon (1999), and CIE 1976 lightness and difference."""

from __future__ import annotations

import numpy as np

TO_XYZ = np.array(
    [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]]
)
TO_CONES = np.array([[0.40024, 0.7076, -0.08081], [-0.2263, 1.16532, 0.0457], [0.0, 0.0, 0.91822]]) @ TO_XYZ
"""Hunt, Pointer and Estevez, for D65."""
WHITE = TO_XYZ.sum(axis=1)


def linear(color: str) -> np.ndarray:
    """Linear light of a colour as ``#rrggbb``."""
    share = np.array([int(color[i : i + 2], 16) / 255 for i in (1, 3, 5)])
    return np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)


def missing(cone: int) -> np.ndarray:
    """What a person without these cones (0 long, 1 middle, 2 short) sees: the plane through white and one pure colour."""
    white, anchor = TO_CONES.sum(axis=1), TO_CONES @ linear("#0000ff" if cone < 2 else "#ff0000")
    normal = np.cross(white, anchor)
    projection = np.eye(3)
    projection[cone] = -normal / normal[cone]
    projection[cone, cone] = 0
    return np.linalg.inv(TO_CONES) @ projection @ TO_CONES


EYES = {"usual": np.eye(3), "no long cones": missing(0), "no middle cones": missing(1), "no short cones": missing(2)}


def lab(light: np.ndarray) -> np.ndarray:
    """CIE L*a*b* of linear light."""
    x = TO_XYZ @ np.clip(light, 0, 1) / WHITE
    f = np.where(x > (6 / 29) ** 3, np.cbrt(x), x / (3 * (6 / 29) ** 2) + 4 / 29)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


def lightness(color: str) -> float:
    """L*, what is left in greyscale: 0 black, 100 white."""
    return float(lab(linear(color))[0])


def difference(one: str, other: str, eye: str) -> float:
    """How far two colours are apart to an eye; 2.3 is just noticed side by side."""
    seen = [lab(EYES[eye] @ linear(x)) for x in (one, other)]
    return float(np.linalg.norm(seen[0] - seen[1]))
