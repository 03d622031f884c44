"""Every closed form of a page against the physics in complex numbers: derivations, quantities of a distortion, JND regions."""

from __future__ import annotations

import cmath
import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import cache
from itertools import islice, pairwise
from typing import Any

import mpmath
import numpy as np
import pytest
from mathreader import expression
from sympy import Expr, Number, Symbol, atan2, lambdify, sympify

import haptisym as hs
from haptisym.kernel.rings import X, omega, s
from haptisym.model.jnd import Part
from haptisym.model.shipped import scene_names
from haptisym.pages.scene import ClosedForms, SceneForms, derivation
from haptisym.writing.boxes import text
from haptisym.writing.document import Block, Equations, Line, Notes, Paragraph, Section
from haptisym.writing.mathml import mathml
from haptisym.writing.plain import said

E, F = hs.environments, hs.effects
FREQUENCIES = (0.7, 3.0, 11.0, 29.0)

# Derivations, in symbols and in numbers


@dataclass(frozen=True)
class Case:
    """A scene, its environment and what is felt as functions of s, and the numbers of its symbols by their names on the page."""

    scene: hs.Scene
    env: Any
    perc: Any
    values: dict[str, float]

    @property
    def shown(self) -> dict[str, Section]:
        return shown(self.scene)


@cache
def shown(scene: hs.Scene) -> dict[str, Section]:
    """The first four sections, by their titles; what follows has tests of its own."""
    found = islice(derivation(SceneForms(hs.evaluate(scene))), 4)
    return {str(x.title): x for x in found if isinstance(x, Section)}


M, B, K, WC, BS = 1.23456789, 3.1415926535, 97.531, 37.123456, 1.618033988
SCENES = {
    "lag": Case(
        hs.Scene(E.mass_spring_damper(m=2, b=3, k=100), (F.first_order_lag(20),)),
        lambda s: 2 * s * s + 3 * s + 100, lambda s: (2 * s * s + 3 * s + 100) * 20 / (s + 20),
        {"m": 2, "b": 3, "k": 100, "omega_c": 20},
    ),
    "long numbers": Case(
        hs.Scene(E.mass_spring_damper(m=str(M), b=str(B), k=str(K)), (F.first_order_lag(str(WC)),)),
        lambda s: M * s * s + B * s + K, lambda s: (M * s * s + B * s + K) * WC / (s + WC),
        {"m": M, "b": B, "k": K, "omega_c": WC},
    ),
    "long quotient": Case(
        hs.Scene(E.mass_spring_damper(b=str(B), k=str(K)), (F.first_order_lag(str(WC)), F.shunt(b=str(BS)))),
        lambda s: B * s + K, lambda s: (B * s + K) * WC / (s + WC) + BS * s,
        {"b": B, "k": K, "omega_c": WC, "b_shunt": BS},
    ),
    "long delay": Case(
        hs.Scene(E.mass_spring_damper(k=str(K)), (F.delay("12.3456789 ms"), F.shunt(b=str(BS)))),
        lambda s: K, lambda s: K * cmath.exp(-0.0123456789 * s) + BS * s, {"k": K, "tau": 0.0123456789, "b": BS},
    ),
    "in between": Case(
        hs.Scene(E.mass_spring_damper(k=100), (F.shunt(b=4), F.compliance(k=500))),
        lambda s: 100, lambda s: 1 / (1 / 500 + 1 / (100 + 4 * s)),
        {"k": 100, "b": 4, "k_2": 500},
    ),
    "delay": Case(
        hs.Scene(E.kelvin_voigt(k=100, b=3), (F.delay("10 ms"),)),
        lambda s: 100 + 3 * s, lambda s: (100 + 3 * s) * cmath.exp(-0.01 * s), {"k": 100, "b": 3, "tau": 0.01},
    ),
    "two-port": Case(
        hs.Scene(E.mass_spring_damper(b=3, k=100), (F.two_port("2", "s", "0.001*s", "3"), F.two_port("1", "0.5*s", "0", "1"))),
        lambda s: 3 * s + 100, lambda s: (2 * (3 * s + 100) + s) / (0.001 * s * (3 * s + 100) + 3) + 0.5 * s, {"b": 3, "k": 100},
    ),
    "clock": Case(
        hs.Scene(E.mass_spring_damper(k=100), (F.sampled_loop("10 ms", "tustin"),), rendered=E.kelvin_voigt(k=100, b=2)),
        lambda s: 100,
        lambda s: (100 + 2 * 200 * cmath.tanh(s * 0.005)) * (1 - cmath.exp(-0.01 * s)) / (0.01 * s),
        {"k": 100, "k_rendered": 100, "b": 2, "T": 0.01, "T_1": 0.01},
    ),
    "no effect": Case(hs.Scene(E.mass_spring_damper(b=3, k=100)), lambda s: 3 * s + 100, lambda s: 3 * s + 100, {"b": 3, "k": 100}),
}  # fmt: skip


def lines(section: Section) -> Iterator[Line]:
    for x in section.blocks:
        if isinstance(x, Equations):
            yield from x.lines


def value(form: Any, case: Case, omega: float) -> complex:
    assert isinstance(form, Expr)
    own = {**case.values, "omega": omega, "s": 1j * omega}
    return complex(form.xreplace({x: sympify(own[x.name]) for x in form.free_symbols}).evalf())


def truth(case: Case, omega: float) -> dict[str, complex]:
    env, perc = complex(case.env(1j * omega)), complex(case.perc(1j * omega))
    d = perc - env
    return {
        "H_env(s)": env, "H_perc(s)": perc, "H_env": env, "Re dH": d.real, "Im dH": d.imag, "|H_env|^2": abs(env) ** 2, "r_r": abs(d.real) / abs(env),
        "r_i": abs(d.imag) / abs(env), "Re(dH/H_env)": (d / env).real, "Im(dH/H_env)": (d / env).imag, "k_perc": perc.real,
        "m_perc": -perc.real / omega**2, "b_perc": perc.imag / omega,
    }  # fmt: skip


@pytest.mark.slow
@pytest.mark.few("lag", "two-port", "clock", "long delay")
@pytest.mark.parametrize("name", SCENES)
def test_every_closed_form_of_a_derivation_has_the_value_that_the_physics_has(name: str) -> None:
    """Those after ≈ to six digits, all others exactly."""
    case, told = SCENES[name], set()
    for title in ("Dynamics", "Distortion", "Perceived properties"):
        for line in lines(case.shown[title]):
            left = said(line.left)
            for w in FREQUENCIES:
                true = truth(case, w)
                if left in true:
                    told.add(left)
                    close = 1e-4 if line.relation == "≈" else 1e-9
                    size = abs(true[left]) + close * abs(true["H_env"] if left[:3] in ("Re ", "Im ") else 1)
                    assert abs(value(line.value, case, w) - true[left]) <= close * size, (left, w)
    assert told >= set(truth(case, 1)) - {"H_env"}


@pytest.mark.few("no effect")
@pytest.mark.parametrize("name", SCENES)
def test_threshold_polynomials_are_positive_exactly_where_a_ratio_exceeds(name: str) -> None:
    case = SCENES[name]
    section = case.shown["Threshold polynomials"]
    forms = {said(x.left): x for x in lines(section)}
    assert set(forms) == {"p_r", "p_i"}
    both = set()
    for w in (*FREQUENCIES, 0.2, 1.7, 5.0, 8.0, 17.0, 22.0, 50.0, 90.0):
        for part in "ri":
            excess = truth(case, w)[f"r_{part}"].real - 0.1
            assert (value(forms[f"p_{part}"].value, case, w).real > 0) == (excess > 0), (part, w)
            both.add(excess > 0)
    assert both == ({False} if name == "no effect" else {True, False})


def test_a_changeover_of_the_environment_and_as_felt_is_told_where_it_has_a_formula() -> None:
    """Re H_perc is zero, behind a lag, where (k - m w^2) wc + b w^2 is."""
    told = {said(x.left): value(x.value, SCENES["lag"], 1) for x in lines(SCENES["lag"].shown["Perceived properties"])}
    assert told["ω_env"] == pytest.approx(50**0.5)
    assert told["ω_perc"] == pytest.approx((100 * 20 / (2 * 20 - 3)) ** 0.5)


@pytest.mark.slow
def test_closed_forms_that_are_long_in_symbols_stand_in_numbers() -> None:
    chain = [F.shunt(m="0.1 kg", b=n) if n % 2 else F.compliance(k=400 + n, b=n) for n in range(1, 5)]
    found = shown(hs.Scene(E.mass_spring_damper(k=100), tuple(chain), (1, 9)))
    for x in (x for section in (found["Distortion"], found["Perceived properties"]) for x in lines(section)):
        assert {y.name for y in x.value.free_symbols} <= {"s", "omega"}  # type: ignore[union-attr]
    [*_, perceived] = lines(found["Dynamics"])
    assert said(perceived.left) == "H_perc(s)"
    H = 100 + 0j
    for n in range(1, 5):
        z = 0.1 * 9 * -1 + 3j * n if n % 2 else 400 + n + 3j * n
        H = H + z if n % 2 else 1 / (1 / H + 1 / z)
    assert complex(perceived.value.subs(s, 3j).evalf()) == pytest.approx(H, rel=1e-4)  # type: ignore[union-attr]


# What is printed with rounded numbers, read as it is printed

CLOCK = hs.Scene(
    E.mass_spring_damper(m="0.5", b=5, k=300),
    (F.sampled_loop("1 ms", "backward-difference"), F.first_order_lag("40 Hz")),
    ("0 Hz", "10 Hz"),
)
CLOSE = hs.Scene(
    E.mass_spring_damper(m=1, b="0.1", k=10000), (F.first_order_lag("1234567/89 rad/s"), F.delay("1/700 s")), (1, 300)
)
"""A clock of 1 kHz, of which the coefficients of p_r are up to 10^30 and cancel; a light resonance behind a long number."""
PRINTED = {**{name: name for name in scene_names()}, "clock": CLOCK, "close": CLOSE}


def read_back(scene: hs.Scene) -> tuple[hs.Evaluation, dict[tuple[str, bool], Callable[[Any], Any]]]:
    """The formulas in omega or s alone of a derivation, as a reader of MathML has them, and whether each is rounded."""
    e = hs.evaluate(scene)
    found: dict[tuple[str, bool], Callable[[Any], Any]] = {}
    for section in islice(derivation(SceneForms(e)), 4):
        for line in lines(section) if isinstance(section, Section) else ():
            if isinstance(line.value, Expr) and line.value.free_symbols <= {s, omega} and not line.value.has(atan2):
                form = expression(mathml(line.value), {"s": s, "omega": omega})
                of = lambdify((s, omega), form, "mpmath")
                found[said(line.left), line.relation == "≈"] = lambda w, of=of: mpmath.mpmathify(
                    of(mpmath.mpc(0, w), w)
                )
    return e, found


@pytest.mark.slow
@pytest.mark.parametrize("name", PRINTED)
def test_what_is_printed_with_rounded_numbers_has_its_values_and_its_zeros_to_four_digits(name: str) -> None:
    """Of each value four digits, or those of a frequency that is the same to four; of each zero four, and no other zero."""
    given = PRINTED[name]
    e, found = read_back(hs.load_scene(given) if isinstance(given, str) else given)
    low, high = (mpmath.mpf(float(x)) for x in e.scene.band)
    H, own = (lambdify(s, x, "mpmath") for x in (e.distortion.perceived, e.distortion.environment))
    true = {
        "H_perc(s)": H, "H_env(s)": own, "Re dH": lambda z: (H(z) - own(z)).real, "Im dH": lambda z: (H(z) - own(z)).imag,
        "Re(dH/H_env)": lambda z: (H(z) / own(z) - 1).real, "Im(dH/H_env)": lambda z: (H(z) / own(z) - 1).imag,
        "k_perc": lambda z: H(z).real, "b_perc": lambda z: H(z).imag / abs(z),
    }  # fmt: skip
    with mpmath.workdps(60):
        for w in (low + (high - low) * x / 29 for x in range(1, 30, 3)):
            for (left, rounded), form in found.items():
                if left not in true:
                    continue
                here, *near = (mpmath.mpmathify(true[left](mpmath.mpc(0, w * x))) for x in (1, 1 - 1e-4, 1 + 1e-4))
                room = 1e-4 * abs(here) + max(abs(x - here) for x in near) if rounded else 1e-25 * (1 + abs(here))
                assert abs(form(w) - here) <= room, (left, w)
        for part in Part:
            form = next(
                (found[f"p_{part.value[0]}", x] for x in (True, False) if (f"p_{part.value[0]}", x) in found), None
            )
            at = [mpmath.mpf(float(c.omega)) for c in e.crossings if c.part is part and c.kind.value != "touches"]
            for w in at if form is not None else ():
                below, above = (mpmath.sign(form(w * x).real) for x in (1 - 6e-5, 1 + 6e-5))
                assert below == -above, (part, w)
            if form is not None:
                grid = [low + (high - low) * mpmath.mpf(x) / 211 for x in range(1, 211)]
                signs = [mpmath.sign(form(w).real) for w in grid if all(abs(w / x - 1) > 1e-4 for x in at)]
                assert sum(x != y for x, y in pairwise(signs)) <= len(at)


@pytest.mark.slow
@pytest.mark.core
def test_a_threshold_polynomial_that_no_readable_coefficients_leave_true_is_told_by_the_distortion() -> None:
    """By hand: the clock of 1 kHz crosses at 22.2086497392685 (real) and 26.8326096382267 rad/s (imaginary)."""
    sections = [x for x in derivation(SceneForms(hs.evaluate(CLOCK))) if isinstance(x, Section)]
    shown = {said(x.left): text(x.equation) for x in lines(sections[2])}
    assert shown == {f"p_{x[0].lower()}": f"p_{x[0].lower()} = ({x} dH)^2 - 0.01 |H_env|^2" for x in ("Re", "Im")}
    told = words_and_lines(sections[1].blocks)[0]
    assert "Not written is Re dH with numbers" in told


LEVER = hs.Scene(
    E.kelvin_voigt(800, 2),
    (
        F.sampled_loop("1 ms", "backward-difference", delay=2),
        F.first_order_lag(250),
        F.encoder("0.02 mm", "1 mm"),
        F.shunt(m="0.35", b="1.2"),
    ),
    (0, 60),
)


def test_no_common_factor_makes_the_numbers_in_its_sum_so_many_times_as_large() -> None:
    """One of 8e-57 stood before a sum of numbers up to 7e69."""
    found = [x.value for section in shown(LEVER).values() for x in lines(section) if isinstance(x.value, Expr)]
    sizes = [abs(float(y)) for x in found for y in x.atoms(Number) if y]
    assert len(sizes) > 50
    assert 1e-10 < min(sizes) < max(sizes) < 1e20
    relative = next(x for x in lines(shown(LEVER)["Distortion"]) if said(x.left) == "Re(dH/H_env)")
    d = hs.evaluate(LEVER).distortion
    exact = (d.perceived / d.environment - 1).subs(s, 40j).evalf()
    assert float(relative.value.subs(omega, 40).evalf()) == pytest.approx(float(exact.as_real_imag()[0]), rel=1e-4)


# Quantities of a distortion

GAINS: dict[str, tuple[Any, Any, Any]] = {
    "lag": (hs.distort(E.mass_spring_damper(2, 3, 100), F.first_order_lag(20)), lambda z: 2 * z * z + 3 * z + 100, lambda z: 20 / (z + 20)),
    "delay": (hs.distort(E.maxwell(100, 5), F.delay("10 ms")), lambda z: 500 * z / (5 * z + 100), lambda z: cmath.exp(-0.01 * z)),
    "two": (
        hs.distort(E.kelvin_voigt(100, 3), F.first_order_lag(20), F.first_order_lag(20)), lambda z: 100 + 3 * z, lambda z: 400 / (z + 20) ** 2,
    ),
}  # fmt: skip


@pytest.mark.few("lag")
@pytest.mark.parametrize("name", GAINS)
def test_every_quantity_of_a_distortion_has_its_value(name: str) -> None:
    """With an amplitude of 2.5 m and a threshold of an eighth."""
    distortion, env, gain = GAINS[name]
    rows = {re.sub(r"\(ωj?\)", "", said(x.left)): x.value for x in ClosedForms(distortion).all()}
    given = (omega, X, Symbol("c", positive=True), s)
    found = {key: lambdify(given, x, "mpmath") for key, x in rows.items() if isinstance(x, Expr)}
    for w in FREQUENCIES:
        h = complex(env(1j * w))
        p = h * complex(gain(1j * w))
        change = p - h
        true: dict[str, complex] = {
            "H_env(s)": h, "H_perc(s)": p, "Re dH": change.real, "Im dH": change.imag, "|H_env|^2": abs(h) ** 2, "r_r": abs(change.real) / abs(h),
            "r_i": abs(change.imag) / abs(h), "Re(dH/H_env)": (change / h).real, "Im(dH/H_env)": (change / h).imag,
        }  # fmt: skip
        for system, own in (("env", h), ("perc", p)):
            true |= {
                f"k_{system}": own.real, f"m_{system}": -own.real / w**2, f"b_{system}": own.imag / w, f"F_si_{system}": 2.5 * own.real,
                f"F_d_{system}": 2.5j * own.imag,
            }  # fmt: skip
        true |= {f"Δ_jnd {key}": 0.125 * abs(h) / w**n for n, key in enumerate("kbm")}
        told = {re.sub("^(Delta_)?jnd", "Δ_jnd", key): complex(f(w, 2.5, 0.125, 1j * w)) for key, f in found.items()}
        assert told.keys() == true.keys()
        for key, x in true.items():
            assert abs(told[key] - x) <= 1e-10 * (1 + abs(x)), (key, w)


# Regions of the JND

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


@pytest.mark.dear("in_report-each way", "when-floor", "when-moving polygon")
@pytest.mark.few("when-moving polygon", "when-floor", "in_report-ellipse", "in_report-each way")
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


@pytest.mark.slow
@pytest.mark.parametrize("name", ["ellipse", "diamond", "polygon", "moving polygon"])
def test_the_border_of_a_region_in_both_relative_parts_is_positive_exactly_outside(name: str) -> None:
    _, lines = when(name)
    env, d = change()
    x, y = d.real / abs(env), d.imag / abs(env)
    given: dict[str, Any] = {"x_r": x, "x_i": y, "omega": BAND}
    shown = {said(line.left): line.value for line in lines if said(line.left).startswith("q_")}
    sides = [lambdify(sorted(q.free_symbols, key=str), q, "numpy")(*(given[s.name] for s in sorted(q.free_symbols, key=str)))
             for q in shown.values()]  # fmt: skip
    outside = REGIONS[name][1](x, y)[name.split()[-1]]
    near = np.any([abs(q) < 1e-9 for q in sides], axis=0)
    assert (np.any([q > 0 for q in sides], axis=0) == outside)[~near].all()


def of_spring(jnd: Any, *effects: Any) -> tuple[str, list[Line]]:
    asked = hs.derive(hs.Scene(E.mass_spring_damper(k=100), effects or (F.first_order_lag(20),), ("0.03", 60), jnd))
    [own] = [x for x in asked.document().blocks if isinstance(x, Section) and x.title == "When it is noticed"]
    return words_and_lines(own.blocks)


def solved(lines: Iterable[Line], name: str) -> list[float]:
    """The solutions of that name behind a lag of 20 rad/s, in ascending order."""
    found = [line.value for line in lines if said(line.left) == name]
    return sorted(float(x.subs(dict.fromkeys(x.free_symbols, 20))) for x in found if isinstance(x, Expr))


def test_a_spring_behind_a_lag_leaves_a_diamond_where_a_quadratic_equation_says() -> None:
    """10 w^2 + 5 w wc = w^2 + wc^2 has the root (sqrt(61) - 5) wc/18; the other side of the axis the same with +5."""
    _, lines = of_spring({"shape": "diamond", "real": "0.1", "imag": "0.2"})
    assert solved(lines, "ω_joint_11") == [pytest.approx(20 * (61**0.5 - 5) / 18)]
    assert solved(lines, "ω_joint_21") == [pytest.approx(20 * (61**0.5 + 5) / 18)]


def test_one_function_has_a_name_without_places_and_its_solutions_are_its_crossings() -> None:
    """With limits that are formulas: w^2/(w^2 + wc^2) = w^2/1000 where w^2 = 1000 - wc^2."""
    _, lines = of_spring({"real": "omega**2/1000", "imag": "0.4"})
    assert solved(lines, "ω_real") == [pytest.approx(600**0.5)]
    assert solved(lines, "ω_imag") == [pytest.approx(10), pytest.approx(40)]  # 20 w = 0.4 (w^2 + 400)
