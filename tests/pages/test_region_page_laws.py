"""Where a page says that a region is left, by formulas: each is held against the region itself, worked out in floats."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
import pytest
from sympy import Expr, lambdify

import haptisym as hs
from haptisym.pages import regionforms
from haptisym.pages.derivation import derivation
from haptisym.pages.sceneforms import SceneForms
from haptisym.writing.document import Block, Equations, Line, Notes, Paragraph, Section
from haptisym.writing.plain import said

E, F = hs.environments, hs.effects
VALUES = {"k": 100.0, "b": 1.0, "omega_c": 20.0}
BAND = np.linspace(0.03, 60, 400)


def change() -> tuple[Any, Any]:
    """H_env and dH of a spring and damper behind a lag."""
    env = 100 + 1j * BAND
    return env, env * (20 / (20 + 1j * BAND)) - env


CORNERS = [(0.1, 0.0), (0.0, 0.2), (-0.3, 0.0), (0.0, -0.4)]


def outside_polygon(x: Any, y: Any) -> Any:
    """On the right of an edge, as one walks around to the left."""
    ways = zip(CORNERS, [*CORNERS[1:], CORNERS[0]], strict=True)
    return np.any([(q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0]) < 0 for p, q in ways], axis=0)


def each_way(x: Any, y: Any) -> dict[str, Any]:
    env, d = change()
    grows = abs((env + d).imag) > abs(env.imag)
    return {"r_r": abs(x) > 0.08, "r_i": abs(y) > np.where(grows, 0.3, 0.12)}


def with_floor(x: Any, y: Any) -> dict[str, Any]:
    least = 15 / abs(change()[0])
    return {"r_r": abs(x) > np.maximum(0.1, least), "r_i": abs(y) > np.maximum(0.2, least)}


def moving(x: Any, y: Any) -> Any:
    """A corner on the imaginary axis moves outwards."""
    top = BAND / 300
    edges = (x / 0.1 + y / top, -x / 0.3 + y / top, -x / 0.3 - y / 0.4, x / 0.1 - y / 0.4)
    return np.max(edges, axis=0) > 1


REGIONS: dict[str, tuple[Any, Callable[[Any, Any], dict[str, Any]]]] = {
    "ellipse": (
        {"shape": "ellipse", "real": "0.3", "imag": "0.4", "tilt": "0.5"},
        lambda x, y: {"ellipse": (x / 0.3) ** 2 - x / 0.3 * y / 0.4 + (y / 0.4) ** 2 > 0.75},
    ),
    "diamond": (
        {"shape": "diamond", "real": "0.3", "imag": "0.4"},
        lambda x, y: {"diamond": abs(x) / 0.3 + abs(y) / 0.4 > 1},
    ),
    "polygon": (
        {"shape": "polygon", "corners": [[str(x), str(y)] for x, y in CORNERS]},
        lambda x, y: {"polygon": outside_polygon(x, y)},
    ),
    "each way": ({"real": "0.08", "imag": {"higher": "0.3", "lower": "0.12"}}, each_way),
    "formula": (
        {"real": "0.05 + omega/400", "imag": "0.2"},
        lambda x, y: {"r_r": abs(x) > 0.05 + BAND / 400, "r_i": abs(y) > 0.2},
    ),
    "floor": ({"real": "0.1", "imag": "0.2", "floor": "15 N/m"}, with_floor),
    "moving polygon": (
        {"shape": "polygon", "corners": [["0.1", "0"], ["0", "omega/300"], ["-0.3", "0"], ["0", "-0.4"]]},
        lambda x, y: {"polygon": moving(x, y)},
    ),
}  # fmt: skip


def scene(name: str) -> hs.Scene:
    return hs.Scene(E.kelvin_voigt(k=100, b=1), (F.first_order_lag(20),), ("0.03", 60), REGIONS[name][0])


def numbers(lines: Iterable[Line]) -> dict[str, list[Any]]:
    """What each formula is on the band, by its name; several where it has several."""
    found: dict[str, list[Any]] = {}
    for line in lines:
        assert isinstance(line.value, Expr)
        free = sorted(line.value.free_symbols, key=str)
        value = lambdify(free, line.value, "numpy")(*(VALUES.get(x.name, BAND) for x in free))
        found.setdefault(said(line.left).split("(")[0], []).append(np.broadcast_to(value, BAND.shape))
    return found


def told(words: str, values: dict[str, list[Any]]) -> dict[str, Any]:
    """``The ellipse is left exactly where p > 0 and q > 0 or r > 0``, worked out."""
    found = {}
    names = r"(\w+) (?:is left|exceeds its limit) exactly where ((?:[\w()ω]+ > 0(?:, | and | or )?)+)"
    for what, where in re.findall(names, words):
        clauses = [re.findall(r"(\w+)(?:\(ω\))? > 0", x) for x in re.split(", | or ", where)]
        found[what] = np.any([np.all([values[name][0] > 0 for name in row], axis=0) for row in clauses], axis=0)
    return found


def words_and_lines(blocks: Iterable[Block]) -> tuple[str, list[Line]]:
    shown = list(blocks)
    words = [said(x.words) for x in shown if isinstance(x, Paragraph)]
    words += [said(entry) for x in shown if isinstance(x, Notes) for entry in x.entries]
    return " ".join(words).replace("\xa0", " "), [line for x in shown if isinstance(x, Equations) for line in x.lines]


def when(name: str) -> tuple[str, list[Line]]:
    """What the page of a derivation says of it, in symbols."""
    sections = [x for x in hs.derive(scene(name)).document().blocks if isinstance(x, Section)]
    [own] = [x for x in sections if x.title == "When it is noticed"]
    return words_and_lines(own.blocks)


def in_report(name: str) -> tuple[str, list[Line]]:
    """What a report's derivation says of it, in numbers."""
    own = next(
        x
        for x in derivation(SceneForms(hs.evaluate(scene(name))))
        if isinstance(x, Section) and "Threshold" in str(x.title)
    )
    return words_and_lines(own.blocks)


def clear(of: dict[str, list[Any]]) -> Any:
    """Where no function is so small that rounding may turn its sign."""
    return np.all([abs(x) > 1e-9 for rows in of.values() for x in rows], axis=0)


@pytest.mark.parametrize("name", REGIONS)
@pytest.mark.parametrize("page", [when, in_report])
def test_a_region_is_left_exactly_where_the_page_says_that_its_functions_are_positive(
    name: str, page: Callable[[str], tuple[str, list[Line]]]
) -> None:
    words, lines = page(name)
    env, d = change()
    truth = REGIONS[name][1](d.real / abs(env), d.imag / abs(env))
    functions = numbers(x for x in lines if said(x.left).startswith("p_"))
    found = told(words, functions)
    assert set(found) == set(truth)
    for what, outside in truth.items():
        assert 20 < outside.sum() < 380
        assert (found[what] == outside)[clear(functions)].all()
    assert sum(clear(functions)) > 300
    assert len({said(x.left) for x in lines if said(x.left).startswith("p_")}) == len(functions) == words.count(" > 0")


# What a derivation says besides


BORDERS = {
    "ellipse": "The ellipse is left where q_1 is positive.",
    "diamond": "The diamond is left where q_1 is positive.",
    "polygon": "The polygon is left where one of q_1, q_2, q_3 or q_4 is positive.",
    "moving polygon": "The polygon is left where one of q_1, q_2, q_3 or q_4 is positive.",
}


@pytest.mark.parametrize("name", BORDERS)
def test_the_border_of_a_region_in_both_relative_parts_is_positive_exactly_outside(name: str) -> None:
    words, lines = when(name)
    assert words.count(BORDERS[name]) == 1
    env, d = change()
    x, y = d.real / abs(env), d.imag / abs(env)
    given: dict[str, Any] = {"x_r": x, "x_i": y, "omega": BAND}
    shown = {said(line.left): line.value for line in lines if said(line.left).startswith("q_")}
    sides = [lambdify(sorted(q.free_symbols, key=str), q, "numpy")(*(given[s.name] for s in sorted(q.free_symbols, key=str)))
             for q in shown.values()]  # fmt: skip
    assert [*shown] == [f"q_{n}" for n in range(1, len(shown) + 1)]
    outside = REGIONS[name][1](x, y)[name.split()[-1]]
    near = np.any([abs(q) < 1e-9 for q in sides], axis=0)
    assert (np.any([q > 0 for q in sides], axis=0) == outside)[~near].all()
    [real, imag] = [line for line in lines if said(line.left).startswith("x_")]
    assert [said(z.equation) for z in (real, imag)] == ["x_r = Re dH/|H_env|", "x_i = Im dH/|H_env|"]


@pytest.mark.parametrize(("name", "word"), [("ellipse", "The JND is an ellipse, "), ("each way", "The limits are 8 % (real)"),
                                            ("floor", "The limits are 10 % (real)")])  # fmt: skip
def test_a_derivation_begins_with_the_region_and_ends_with_who_has_the_numbers(name: str, word: str) -> None:
    words, lines = when(name)
    assert words.startswith(word)
    assert words.endswith("Its crossings, as numbers: `haptisym evaluate`.")
    assert ("x_r" in {said(line.left) for line in lines}) == (name == "ellipse")
    assert "Too long" not in words


SPRING = E.mass_spring_damper(k=100)


def of_spring(jnd: Any, *effects: Any) -> tuple[str, list[Line]]:
    asked = hs.derive(hs.Scene(SPRING, effects or (F.first_order_lag(20),), ("0.03", 60), jnd))
    [own] = [x for x in asked.document().blocks if isinstance(x, Section) and x.title == "When it is noticed"]
    return words_and_lines(own.blocks)


def solved(lines: Iterable[Line], name: str) -> list[float]:
    """The solutions of that name behind a lag of 20 rad/s, in ascending order."""
    found = [line.value for line in lines if said(line.left) == name]
    return sorted(float(x.subs(dict.fromkeys(x.free_symbols, 20))) for x in found if isinstance(x, Expr))


def test_a_spring_behind_a_lag_leaves_a_diamond_where_a_quadratic_equation_says() -> None:
    """10 w^2 + 5 w wc = w^2 + wc^2 has the root (sqrt(61) - 5) wc/18; the other side of the axis the same with +5."""
    words, lines = of_spring({"shape": "diamond", "real": "0.1", "imag": "0.2"})
    assert solved(lines, "ω_joint_11") == [pytest.approx(20 * (61**0.5 - 5) / 18)]
    assert solved(lines, "ω_joint_21") == [pytest.approx(20 * (61**0.5 + 5) / 18)]
    told = "r_j: each crossing is one of the solutions, or a frequency at which another function changes its sign."
    assert words.count(told) == 1
    assert "p_joint_11 > 0 or p_joint_21 > 0." in words.replace("(ω)", "")


def test_one_function_has_a_name_without_places_and_its_solutions_are_its_crossings() -> None:
    """With limits that are formulas: w^2/(w^2 + wc^2) = w^2/1000 where w^2 = 1000 - wc^2."""
    words, lines = of_spring({"real": "omega**2/1000", "imag": "0.4"})
    assert "r_r exceeds its limit exactly where p_real > 0. " in words.replace("(ω)", "")
    assert "r_i exceeds its limit exactly where p_imag > 0. " in words.replace("(ω)", "")
    assert "each crossing is one of the solutions" not in words
    assert solved(lines, "ω_real") == [pytest.approx(600**0.5)]
    assert words.count("r_r: in force where 1000 - ω_c^2 ≥ 0.") == 1
    assert solved(lines, "ω_imag") == [pytest.approx(10), pytest.approx(40)]  # 20 w = 0.4 (w^2 + 400)


def test_a_solution_that_two_functions_share_and_a_remark_about_two_are_told_once() -> None:
    """A limit of 0.2 to either side: the same equation, whether the part grows or shrinks."""
    words, lines = of_spring({"real": "0.1", "imag": {"higher": "0.2", "lower": "0.2"}, "floor": "1 N/m"})
    shown = [x.value for x in lines if said(x.left).startswith("ω_imag")]
    assert len(shown) == len(set(shown)) > 0
    notes = re.findall(r"r_i: [^:]*?\.", words)
    assert len(notes) == len(set(notes)) > 0


def test_functions_that_are_long_are_named_and_left_out() -> None:
    """A polygon with seven corners has fourteen functions; sixteen lines are written, and the others are named."""
    corners = [
        [f"{0.1 * c:.4f}", f"{0.1 * s:.4f}"]
        for c, s in ((np.cos(n * 2 * np.pi / 7), np.sin(n * 2 * np.pi / 7)) for n in range(7))
    ]
    words, lines = of_spring({"shape": "polygon", "corners": corners})
    written = [said(x.left).split("(")[0] for x in lines]
    told = re.search(r"Too long to be written out unasked: ([^.]*)\. Fewer symbols make them shorter\.", words)
    assert told
    left = re.findall(r"p_joint_\d+", told[1])
    assert left
    both = {f"p_joint_{i}{j}" for i in range(1, 8) for j in (1, 2)}
    assert {x for x in written if x.startswith("p_")} | set(left) == both
    assert not set(written) & set(left)
    assert len([x for x in written if x[0] in "xqp"]) + len(left) == 2 + 7 + 14


@pytest.mark.parametrize("parts", [7, 12])
def test_of_a_long_chain_the_border_is_written_and_that_its_functions_are_not(parts: int) -> None:
    """Seven parts in twos, with fifteen symbols: the functions would have millions of terms, which takes minutes."""
    chain = [F.shunt(m="0.1 kg", b=n) if n % 2 else F.compliance(k=400 + n, b=n) for n in range(1, parts + 1)]
    asked = hs.derive(hs.Scene(SPRING, tuple(chain), ("0.03", 60), {"shape": "diamond", "real": "0.1", "imag": "0.2"}))
    words, lines = words_and_lines(regionforms.when(asked).blocks)
    told = "Closed forms of this chain are long: which functions of ω decide it is not written out."
    assert words.count(told) == 1
    assert "exactly where" not in words
    assert [said(x.left) for x in lines] == ["x_r", "x_i", "q_1"]
    assert told not in of_spring({"shape": "diamond", "real": "0.1", "imag": "0.2"})[0]
