"""Random JND regions of every kind, each as the table that a scene file has. Nothing here comes from the package."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import Any

from hypothesis import strategies as st
from sympy import SympifyError, cancel, sympify

Draw = Callable[[st.SearchStrategy[Any]], Any]
PERCENT = st.integers(2, 60).map(lambda n: f"{n}/100")
SLOPES = st.sampled_from(["", " + omega/300", " + 1/(omega + 3)", " + omega**2/(omega**2 + 50)"])
LIMITS = st.builds(lambda c, more: c + more, PERCENT, SLOPES)


def on_circle(n: int) -> tuple[Fraction, Fraction]:
    """A rational point of the circle, further round for larger n from -12 to 12."""
    t = Fraction(n, 5)
    return (1 - t**2) / (1 + t**2), 2 * t / (1 + t**2)


@st.composite
def polygons(draw: Draw) -> dict[str, Any]:
    """Convex, 0 inside: some points of a circle, made longer, wider and moved a little."""
    turns = sorted(draw(st.sets(st.integers(-12, 12), min_size=1, max_size=4)) | {-9, 0, 8})
    a, b = (Fraction(draw(st.integers(3, 60)), 100) for _ in range(2))
    shift = [Fraction(draw(st.integers(-3, 3)), 20) for _ in range(2)]
    stretch = draw(SLOPES)
    corners = [(a * (x + shift[0]), b * (y + shift[1])) for x, y in map(on_circle, turns)]
    if draw(st.booleans()):
        corners.reverse()
    return {"shape": "polygon", "corners": [[f"{x}", f"({y})*(1{stretch})" if stretch else f"{y}"] for x, y in corners]}


@st.composite
def jnds(draw: Draw) -> dict[str, Any]:
    """A JND of any kind."""
    kind = draw(st.sampled_from(["square", "sided", "floor", "ellipse", "diamond", "polygon"]))
    if kind == "polygon":
        return draw(polygons())  # type: ignore[no-any-return]
    found = {"real": draw(LIMITS), "imag": draw(LIMITS)}
    if kind in ("ellipse", "diamond"):
        found["shape"] = kind
    if kind == "ellipse":
        found["tilt"] = draw(st.integers(-9, 9).map(lambda n: f"{n}/10"))
    if kind in ("sided", "floor"):
        sides = draw(st.sampled_from([("real",), ("imag",), ("real", "imag"), ()]))
        found |= {part: {"higher": draw(LIMITS), "lower": draw(LIMITS)} for part in sides}
    if kind == "floor":
        found["floor"] = draw(st.sampled_from(["1/10", "3", "100", "2 + omega", "50/(omega + 1)"]))
    return found


def picked(pick: Any) -> dict[str, Any]:
    """A JND of any kind but the paper's, by choices of a generator (``strategies.Seeded``)."""
    more = ("", "", "", " + omega/300", " + 1/(omega + 3)", " + omega**2/(omega**2 + 50)")

    def limit() -> str:
        return f"{pick.whole(2, 60)}/100{pick.choice(more)}"

    kind = pick.choice(("formula", "sided", "floor", "both", "ellipse", "diamond", "polygon"))
    if kind == "polygon":
        return _picked_polygon(pick, pick.choice(more[2:]))
    found: dict[str, Any] = {"real": limit(), "imag": limit()}
    if kind == "formula":
        found["real"] += " + omega/100"
    if kind in ("ellipse", "diamond"):
        found["shape"] = kind
    if kind == "ellipse":
        found["tilt"] = f"{pick.whole(-9, 9)}/10"
    if kind in ("sided", "both"):
        for part in pick.choice((("real",), ("imag",), ("real", "imag"))):
            found[part] = {"higher": limit(), "lower": limit()}
    if kind in ("floor", "both"):
        found["floor"] = pick.choice(("1/10", "3", "100", "2 + omega", "50/(omega + 1)"))
    return found


def _picked_polygon(pick: Any, stretch: str) -> dict[str, Any]:
    turns = sorted({*(pick.whole(-12, 12) for _ in range(pick.whole(1, 3))), -9, 0, 8})
    a, b = (Fraction(pick.whole(3, 60), 100) for _ in range(2))
    shift = [Fraction(pick.whole(-3, 3), 20) for _ in range(2)]
    corners = [(a * (x + shift[0]), b * (y + shift[1])) for x, y in map(on_circle, turns)]
    if pick.whole(0, 1):
        corners.reverse()
    return {"shape": "polygon", "corners": [[f"{x}", f"({y})*(1{stretch})" if stretch else f"{y}"] for x, y in corners]}


def inline(jnd: Any) -> str:
    """As TOML."""
    if isinstance(jnd, dict):
        return "{ " + ", ".join(f"{key} = {inline(x)}" for key, x in jnd.items()) + " }"
    if isinstance(jnd, list | tuple):
        return "[" + ", ".join(map(inline, jnd)) + "]"
    return str(jnd) if isinstance(jnd, float | int) else f'"{jnd}"'


def same_rows(one: Any, other: Any) -> bool:
    """Whether rows of JNDs are alike, their formulas as functions of omega: one is written with brackets, one without."""
    if isinstance(one, dict) and isinstance(other, dict):
        return one.keys() == other.keys() and all(same_rows(one[key], other[key]) for key in one)
    if isinstance(one, list) and isinstance(other, list):
        return len(one) == len(other) and all(map(same_rows, one, other))
    if one == other:
        return True
    try:
        return bool(cancel(sympify(one) - sympify(other)) == 0)
    except (SympifyError, TypeError):
        return False
